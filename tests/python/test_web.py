"""The page of web/ in Chromium: it gives what the command line gives, draws what `planish apply` says, and can be stopped."""

import base64
import functools
import http.server
import json
import os
import struct
import subprocess
import threading
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import obj
from baked import DUCK
from clients import SCRIPTS, numbers, package, picture, program
from conftest import REPO

# The page that `tests/run --clients` has built, or the one that somebody has.
DIST = Path(os.environ.get("PLANISH_PAGE", REPO / "web" / "dist"))
FLANGE = REPO / "data" / "flange_noisy.obj"
# Of the largest coordinate: positions and heights are in single precision, and a filter interpolates with rounded weights.
EXACT = 1e-6
# Relative: browsers have exponential functions and angles of their own, which round the last bit of 53 otherwise, and errors of a map are
# differences that lose nine digits.
DIGITS = 1e-6
# A page that takes longer hangs.
SECONDS = 600


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def address():
    """The address of the page on a host of static files."""
    if not (DIST / "planish_web_bg.wasm").is_file():
        pytest.skip(f"{DIST} is missing (web/build makes it, and says what it needs)")
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=DIST))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()


@pytest.fixture
def visit(address, tmp_path):
    """A function of steps of web.mjs: does them on the page, and returns what each of them returned."""
    package("playwright-core")

    def run(*steps, clean=True, **context):
        job = {
            "address": address,
            "clients": str(SCRIPTS),
            "downloads": str(tmp_path),
            "result": str(tmp_path / "result.json"),
            "context": {"viewport": {"width": 1200, "height": 800}, "serviceWorkers": "block", **context},
            "steps": [["visit"], *steps],
        }
        (tmp_path / "job.json").write_text(json.dumps(job, default=str), encoding="utf-8")
        chromium = program("chromium", "chromium-browser", "google-chrome")
        command = [program("node"), SCRIPTS / "web.mjs", chromium, tmp_path / "job.json"]
        run = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
        assert run.returncode == 0, f"{run.stdout}\n{run.stderr}"
        done = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
        assert done["foreign"] == [], "the page asks other places for something"
        assert not clean or done["complaints"] == []
        return done["results"][1:]

    return run


def command_line(planish, folder, *arguments):
    subprocess.run([planish, *arguments], cwd=folder, check=True, capture_output=True)


def textured(folder):
    """The duck with a texture: chequered, so that it is seen."""
    image = Image.fromarray(np.kron(np.indices((16, 16)).sum(0) % 2, np.ones((8, 8))).astype("u1") * 150 + 80)
    image.save(folder / "skin.png")
    for path in (DUCK, DUCK.with_name("duck.mtl")):
        text = path.read_text(encoding="utf-8")
        (folder / path.name).write_text(text.replace("illum 2", "illum 2\nmap_Kd skin.png"), encoding="utf-8")
    return [folder / name for name in (DUCK.name, "duck.mtl", "skin.png")]


def ply(folder):
    """The flange as binary PLY, without texture coordinates."""
    positions, faces = obj.read(FLANGE)
    positions = positions.astype("<f4")
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    lists = b"".join(struct.pack(f"<B{len(face)}i", len(face), *face) for face in faces)
    path = folder / "flange.ply"
    path.write_bytes(head.encode() + positions.tobytes() + lists)
    return path


def whole(path):
    """Texels of an image of whole numbers."""
    with Image.open(path) as image:
        return np.asarray(image).astype(int)


def pixels(path):
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), dtype=float)


def differences(a, b):
    """Share of the pixels that differ."""
    return (np.abs(pixels(a) - pixels(b)).max(axis=2) > 8).mean()


def roughness(path):
    """Mean difference of neighbours in a row, over the middle of a picture."""
    grey = pixels(path).mean(axis=2)
    middle = grey[grey.shape[0] // 4 : -grey.shape[0] // 4, grey.shape[1] // 4 : -grey.shape[1] // 4]
    return np.abs(np.diff(middle, axis=1)).mean()


def close(a, b):
    """Numbers in JSON agree to many digits, and all else is equal."""
    if isinstance(a, float) and isinstance(b, float):
        return a == pytest.approx(b, rel=DIGITS, abs=1e-9)
    if isinstance(a, dict) and isinstance(b, dict):
        return list(a) == list(b) and all(close(a[key], b[key]) for key in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(close, a, b))
    return a == b


def same_files(bundle, folder):
    """The files of a .zip are those of a folder, byte for byte, but for the last digits of measured numbers in the manifest."""
    with zipfile.ZipFile(bundle) as archive:
        found = {name: archive.read(name) for name in archive.namelist()}
    expected = {f"{folder.name}/{path.name}": path.read_bytes() for path in folder.iterdir()}
    assert sorted(found) == sorted(expected)
    manifest = next(name for name in expected if name.endswith(".planish.json"))
    assert close(json.loads(found.pop(manifest)), json.loads(expected.pop(manifest)))
    assert [name for name in expected if found[name] != expected[name]] == []


def agree(meshes, source, displaced):
    """Vertices are drawn where `planish apply` puts them (#V x 3)."""
    index = {p.tobytes(): i for i, p in enumerate(source.astype("f4"))}
    for rest, drawn in meshes:
        rest = numbers(rest).astype("f4")
        vertices = [index[p.tobytes()] for p in rest]
        assert np.abs(numbers(drawn) - displaced[vertices]).max() <= EXACT * np.abs(source).max()
        assert not np.array_equal(numbers(drawn).astype("f4"), rest)


def test_a_textured_obj_becomes_a_bundle_that_the_command_line_knows(visit, planish, tmp_path):
    scan = tmp_path / "scan"
    scan.mkdir()
    files = textured(scan)
    names = ["denoised", "half", "noisy", "plain", "heights", "split", "page"]
    shown = {name: picture(f"web-{name}", tmp_path) for name in names}
    [_, error, *_, bundle, mesh, glb, report, command, positions] = visit(
        ["drop", files], ["done"],
        ["check", "#split", False], ["picture", shown["denoised"], "#canvas"],
        ["fill", "#lambda", "0.5"], ["picture", shown["half"], "#canvas"],
        ["fill", "#lambda", "0"], ["picture", shown["noisy"], "#canvas"],
        ["check", "#texture", False], ["picture", shown["plain"], "#canvas"],
        ["check", "#heights", True], ["fill", "#lambda", "0.75"], ["picture", shown["heights"], "#canvas"],
        ["check", "#heights", False], ["check", "#split", True], ["picture", shown["split"], "#canvas"],
        ["check", "#texture", True], ["picture", shown["page"]],
        ["download", "#save-zip"], ["download", "#save-mesh"], ["download", "#save-glb"],
        ["text", "#report"], ["text", "#command"], ["positions"],
    )  # fmt: skip
    assert error == ""
    with zipfile.ZipFile(bundle) as archive:
        archive.extractall(scan)
    folder = scan / "duck_noisy-planish"
    manifest = folder / "duck_noisy.planish.json"
    assert Path(glb).read_bytes() == (folder / "duck_noisy.glb").read_bytes()
    assert "7550 vertices" in report
    command_line(planish, scan, "check", manifest.relative_to(scan))

    out = scan / "duck_noisy-denoised.obj"
    command_line(planish, scan, "apply", manifest.relative_to(scan), "--lambda", "0.75", "-o", out.name)
    assert Path(mesh).read_bytes() == out.read_bytes()
    agree(positions, obj.read(DUCK)[0], obj.read(out)[0])

    # Networks in single precision turn a last bit of a logarithm into a step of the map here and there.
    assert command == "planish bake duck_noisy.obj"
    command_line(planish, scan, *command.split()[1:], "-o", "own")
    assert sorted(path.name for path in (scan / "own").iterdir()) == sorted(path.name for path in folder.iterdir())
    ours, theirs = (whole(scan / name / "duck_noisy.displacement.png") for name in ("own", folder.name))
    assert ours.shape == theirs.shape and np.abs(ours - theirs).max() <= 1 and (ours != theirs).mean() < 0.01

    assert differences(shown["noisy"], shown["denoised"]) > 0.02
    assert roughness(shown["denoised"]) < roughness(shown["half"]) < roughness(shown["noisy"])
    assert differences(shown["noisy"], shown["plain"]) > 0.05
    assert differences(shown["plain"], shown["heights"]) > 0.05
    # Left of the line, below the label, is what λ = 0 gives.
    split, plain = pixels(shown["split"])[80:], pixels(shown["plain"])[80:]
    middle = split.shape[1] // 2
    assert np.array_equal(split[:, : middle - 40], plain[:, : middle - 40])
    assert not np.array_equal(split[:, middle + 40 :], plain[:, middle + 40 :])


def test_a_ply_with_settings_becomes_the_bundle_of_the_command_line(visit, planish, tmp_path):
    scan = tmp_path / "scan"
    scan.mkdir()
    path = ply(scan)
    [_, first, *_, second, bundle, mesh, command] = visit(
        ["choose", [path]], ["done"],
        ["select", "#method-name", "guided-normals"], ["open", "#method details:nth-of-type(1)"],
        ["fill", "[data-parameter=iterations]", "3"], ["press", "[data-parameter=iterations]", "Tab"],
        ["open", "#method details:nth-of-type(2)"], ["check", "#preserve-volume", True],
        ["open", "#method details:nth-of-type(3)"], ["select", "#texel", "--bits 32"],
        ["click", "#bake"], ["done"],
        ["download", "#save-zip"], ["download", "#save-mesh"], ["text", "#command"],
    )  # fmt: skip
    assert (first, second) == ("", "")
    assert command == "planish bake flange.ply --method guided-normals --iterations 3 --preserve-volume --bits 32"
    command_line(planish, scan, *command.split()[1:])
    same_files(bundle, scan / "flange-planish")
    out = scan / "flange-denoised.ply"
    command_line(planish, scan, "apply", "flange-planish/flange.planish.json", "-o", out.name)
    assert Path(mesh).read_bytes() == out.read_bytes()


def test_a_bake_is_cancelled_and_can_be_begun_again(visit, tmp_path):
    [_, _, _, status, ready, downloads, _, _, error, after, *_, mesh, again] = visit(
        ["drop", [DUCK]], ["stage", "denoising"],
        ["click", "#cancel"], ["text", "#status"], ["enabled", "#bake"], ["enabled", "#save-zip"],
        ["select", "#method-name", "taubin"],
        ["click", "#bake"], ["done"], ["enabled", "#save-zip"], ["download", "#save-zip"],
        # A second one that is cancelled leaves what the first one made.
        ["select", "#method-name", "auto"], ["click", "#bake"], ["stage", "denoising"], ["click", "#cancel"],
        ["rename", "first.zip"], ["download", "#save-mesh"], ["download", "#save-zip"],
    )  # fmt: skip
    assert (status, ready, downloads) == ("Cancelled.", True, False)
    assert (error, after) == ("", True)
    assert Path(mesh).stat().st_size > 1000
    assert Path(again).read_bytes() == (tmp_path / "first.zip").read_bytes()


def test_broken_files_give_the_line_of_the_command_line(visit, planish, tmp_path):
    (tmp_path / "broken.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 x\nf 1 2 3\n")
    (tmp_path / "empty.stl").write_bytes(b"")
    (tmp_path / "notes.txt").write_text("nothing\n")
    names = ["broken.obj", "empty.stl", "notes.txt"]
    told = visit(*(step for name in names for step in (["drop", [tmp_path / name]], ["done"])))[1::2]
    for name, line in zip(names, told, strict=True):
        run = subprocess.run([planish, "info", name], cwd=tmp_path, capture_output=True, text=True)
        assert run.returncode == 2
        assert f"error: {line}\n" == run.stderr
    assert "line 3" in told[0]


def test_the_page_works_without_a_network_and_on_a_small_dark_screen(visit, tmp_path):
    shown = picture("web-small", tmp_path)
    [_, structure, _, error, after, _] = visit(
        ["offline"], ["structure"], ["click", "#welcome [data-sample=flange]"], ["done"], ["structure"], ["picture", shown],
        serviceWorkers="allow", viewport={"width": 390, "height": 800}, hasTouch=True, colorScheme="dark", reducedMotion="reduce",
    )  # fmt: skip
    assert error == ""
    for found in (structure, after):
        assert found["unnamed"] == [] and found["overflow"] <= 0, found
    assert pixels(shown).mean() < 100, "the page is not dark"
