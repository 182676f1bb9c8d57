"""Where things are, and the meshes and binaries that the tests ask for."""

import json
import lzma
import os
import subprocess
from pathlib import Path

import pytest

REPO = Path(__file__).resolve().parents[2]
REFERENCE = REPO / "tests" / "reference"
# Meshes that are not ours to publish; whoever has them gets more tests. Without them, those tests are skipped.
MESHES = Path(os.environ["PLANISH_MESHES"]).resolve() if os.environ.get("PLANISH_MESHES") else None
NO_MESHES = "PLANISH_MESHES names no folder of meshes"


def external(name):
    """The path of an external mesh, or of a file beside their folder; none where it is absent."""
    folders = [] if MESHES is None else [MESHES, MESHES.parent]
    return next((folder / name for folder in folders if (folder / name).is_file()), None)


def binary(name, variable):
    path = Path(os.environ.get(variable, REPO / "target" / "release" / name))
    if not path.is_file():
        pytest.fail(f"{path} is missing: build it (cargo build --release --workspace) or set {variable}")
    return path


@pytest.fixture(scope="session")
def planish():
    return binary("planish", "PLANISH")


@pytest.fixture(scope="session")
def planish_quantities():
    """The planish side of `reference.quantities`: a function of a mesh file."""

    def quantities(path):
        program = binary("quantities", "PLANISH_QUANTITIES")
        return json.loads(subprocess.run([program, path], check=True, capture_output=True).stdout)

    return quantities


@pytest.fixture(scope="session")
def baked(planish, tmp_path_factory):
    """A function of a mesh file, "uvs", "bare" (without its texture coordinates), "folded" (with charts upon others),
    "beside" (in the next UDIM tile) or "tiles" (over two of them), and options of `planish bake`; each case is baked once."""
    # It imports this file.
    from baked import bake, beside, folded, tiles, without_uvs

    done = {}
    change = {"uvs": lambda mesh, _: mesh, "bare": without_uvs, "beside": beside, "folded": folded, "tiles": tiles}

    def make(mesh, uvs, *options):
        key = (mesh, uvs, options)
        if key not in done:
            if mesh is None:
                pytest.skip(NO_MESHES)
            folder = tmp_path_factory.mktemp(mesh.stem)
            done[key] = bake(planish, change[uvs](mesh, folder), folder / "out", *options)
        return done[key]

    return make


def parameters(paths, missing=""):
    """One parameter per path; where there are none, a single one that is skipped and says what is missing."""
    named = [pytest.param(path, id=path.name.split(".obj")[0]) for path in paths]
    return named or [pytest.param(None, id="external", marks=pytest.mark.skip(reason=missing))]


def unpacked(path, folder):
    """The path of a mesh that programs without xz can read."""
    if path.suffix != ".xz":
        return path
    plain = folder / path.stem
    plain.write_bytes(lzma.decompress(path.read_bytes()))
    return plain


def reference_meshes():
    paths = sorted(REFERENCE.glob("*.obj"))
    assert paths, "tests/reference has no meshes: run make_meshes.py"
    return paths


@pytest.fixture(scope="module")
def cluster():
    """Two processes of Dask."""
    # It is slow to import, and most tests do without.
    import distributed

    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster


@pytest.fixture
def client(cluster):
    """A client of the two processes."""
    import distributed

    with distributed.Client(cluster) as client:
        yield client
