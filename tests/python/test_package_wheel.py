"""The wheel of the Python package: the command line in it, its examples, its documentation and its types."""

import doctest
import importlib
import os
import pkgutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import planish as package
from conftest import REPO
from packaged import DUCK, command, sphere


def program():
    return Path(sys.executable).with_name("planish")


def test_the_wheel_has_the_command_line(planish, tmp_path):
    for args in (["--version"], ["info", str(DUCK), "--json"], ["denoise", "none.obj", "-o", "a.obj"], ["--nonsense"], []):
        ours, theirs = (subprocess.run([p, *args], capture_output=True, cwd=tmp_path) for p in (planish, program()))
        assert (ours.returncode, ours.stdout, ours.stderr) == (theirs.returncode, theirs.stdout, theirs.stderr)
    module = subprocess.run([sys.executable, "-m", "planish", "--version"], capture_output=True)
    assert module.stdout == subprocess.run([planish, "--version"], capture_output=True).stdout
    command(planish, "denoise", DUCK, "-o", tmp_path / "a.obj", "--method", "taubin")
    command(program(), "denoise", DUCK, "-o", tmp_path / "b.obj", "--method", "taubin")
    assert (tmp_path / "a.obj").read_bytes() == (tmp_path / "b.obj").read_bytes()


def test_ctrl_c_ends_the_command_line_of_the_wheel(tmp_path):
    mesh = tmp_path / "large.obj"
    package.Mesh(*sphere(7)).write(mesh)
    work = ["bake", mesh, "-o", tmp_path / "out" / "deep", "--method", "taubin", "--iterations", "100000"]
    process = subprocess.Popen([program(), *work], stderr=subprocess.PIPE, text=True)
    # The folder is made when the mesh has been read, and denoising takes hours.
    while process.poll() is None and not (tmp_path / "out").exists():
        time.sleep(0.001)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 1 and "interrupted; nothing was written" in errors, errors
    assert [path.name for path in tmp_path.iterdir()] == ["large.obj"]




def modules():
    return [importlib.import_module(f"planish.{info.name}") for info in pkgutil.iter_modules(package.__path__)]


def test_examples_in_docstrings_are_true():
    found = [doctest.testmod(module) for module in [package, *(m for m in modules() if hasattr(m, "__file__"))]]
    assert sum(result.failed for result in found) == 0
    assert sum(result.attempted for result in found) > 20


def test_every_public_name_is_documented():
    for name in package.__all__:
        thing = getattr(package, name)
        assert thing.__doc__ and len(thing.__doc__) > 15, name
        if isinstance(thing, type):
            for member, value in vars(thing).items():
                assert member.startswith("_") or not callable(value) or value.__doc__, f"{name}.{member}"


def test_types_and_stubs_are_right():
    pytest.importorskip("mypy")
    env = {**os.environ, "MYPY_CACHE_DIR": os.devnull}
    config = ["--config-file", str(REPO / "crates" / "python" / "pyproject.toml")]
    checked = subprocess.run([sys.executable, "-m", "mypy", *config, "-p", "planish"], capture_output=True, text=True, env=env)
    assert checked.returncode == 0, checked.stdout
    stubs = [sys.executable, "-m", "mypy.stubtest", "planish._planish", "--mypy-config-file", config[1]]
    checked = subprocess.run(stubs, capture_output=True, text=True, env=env)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_a_plot_shows_where_vertices_moved(tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    vertices, faces = sphere(2)
    axes = package.denoise(vertices, faces).plot()
    axes.figure.savefig(tmp_path / "plot.png")
    assert (tmp_path / "plot.png").stat().st_size > 5000
