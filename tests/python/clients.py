"""The client programs: where they are, what to do without them, and the snippets of docs/clients.md that they run."""

import atexit
import base64
import functools
import json
import os
import re
import shutil
import subprocess

import numpy as np
import pytest

from conftest import REPO

SCRIPTS = REPO / "tests" / "clients"
PAGE = REPO / "docs" / "clients.md"
# Set by `tests/run --clients`: what it installed must be there.
REQUIRED = os.environ.get("PLANISH_CLIENTS") == "1"
# Pictures for people to look at go here, or else to pytest's temporary folder.
PICTURES = os.environ.get("PLANISH_PICTURES")
SECONDS = 120


def missing(reason):
    """Skips the test, or fails it where all clients were asked for."""
    (pytest.fail if REQUIRED else pytest.skip)(f"{reason} (tests/run --clients installs it)")


def program(*names):
    """The path of the first of these programs that is installed."""
    for name in names:
        if path := shutil.which(name):
            return path
    return missing(f"{names[0]} is not installed")


def package(name):
    """Asks for an npm package of tests/clients/package.json."""
    if not (SCRIPTS / "node_modules" / name / "package.json").is_file():
        missing(f"the npm package {name} is not installed")


def snippet(name):
    """The code of docs/clients.md that stands under <!-- snippet: NAME -->."""
    block = rf"<!-- snippet: {re.escape(name)} -->\n```\w+\n(.*?)^```$"
    found = re.findall(block, PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    assert len(found) == 1, f"docs/clients.md has {len(found)} snippets {name}"
    return found[0]


def numbers(encoded):
    """What `base64` in numbers.js wrote: n x 3."""
    return np.frombuffer(base64.b64decode(encoded), dtype="<f4").reshape(-1, 3).astype(float)


def text(array):
    """Numbers as `floats` in numbers.js reads them."""
    return base64.b64encode(np.ascontiguousarray(array, dtype="<f4").tobytes()).decode()


def picture(name, tmp_path):
    folder = tmp_path if PICTURES is None else PICTURES
    os.makedirs(folder, exist_ok=True)
    return os.path.join(folder, f"{name}.png")


def figures(name, **errors):
    """Prints the worst of each kind of error, in shares of the range: `pytest -s` shows them."""
    print(f"\n{name}:", ", ".join(f"{kind} {values.max():.2e} R" for kind, values in errors.items()))


def execute(command, **options):
    """Runs a client to its end; what it printed is the message if it fails."""
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=SECONDS, **options)
    assert done.returncode == 0, f"{command[0]} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}"
    return done.stdout


@functools.cache
def browser():
    """A process that runs jobs in Chromium until the tests end."""
    node, chromium = program("node"), program("chromium", "chromium-browser", "google-chrome")
    package("playwright-core")
    package("three")
    command = [node, SCRIPTS / "browser.mjs", chromium]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    atexit.register(process.communicate)
    return process


def in_browser(module, arguments, files, tmp_path, screenshot=None, code=None):
    """What `run(arguments)` of a module in tests/clients returns in Chromium.

    The page finds `files` under /files/ and the snippet named `code` as /snippet/code.js."""
    process = browser()
    (tmp_path / "code.js").write_text(snippet(code), encoding="utf-8")
    folders = {"clients": SCRIPTS, "modules": SCRIPTS / "node_modules", "files": files, "snippet": tmp_path}
    job = {
        "folders": {name: str(folder) for name, folder in folders.items()},
        "module": f"/clients/{module}",
        "arguments": {"snippet": "/snippet/code.js", **arguments},
        "result": str(tmp_path / "result.json"),
        "screenshot": screenshot,
    }
    (tmp_path / "job.json").write_text(json.dumps(job), encoding="utf-8")
    print(tmp_path / "job.json", file=process.stdin, flush=True)
    complaint = json.loads(process.stdout.readline() or '"the browser is gone"')
    assert not complaint, complaint
    return json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
