"""NRRD files of pynrrd in `planish-viewer`: the picture is that of the same values as bare numbers."""

import subprocess

import nrrd
import numpy
import pytest
from conftest import binary

SIZE = (9, 7, 5)


def values(dtype):
    """Values that tell the axes apart."""
    x, y, z = numpy.meshgrid(*map(numpy.arange, SIZE), indexing="ij")
    return (10 * x + 3 * y * y + 20 * (z == 2)).astype(dtype)


def draw(folder, *options):
    out = folder / "out.png"
    viewer = binary("planish-viewer", "PLANISH_VIEWER")
    fixed = ["--headless", out, "--backend", "software", "--size", "60x50", "--transfer", "fog", "--volume-place", "fit"]
    subprocess.run([viewer, *options, *fixed], check=True, timeout=600)
    return out.read_bytes()


@pytest.mark.parametrize("endian", ["little", "big"])
@pytest.mark.parametrize("encoding", ["raw", "gzip"])
@pytest.mark.parametrize("dtype, name", [("u1", "u8"), ("i2", "i16"), ("u2", "u16"), ("f4", "f32"), ("f8", "f64")])
def test_files_of_pynrrd_have_the_values_that_were_written(tmp_path, dtype, name, encoding, endian):
    raw, file = tmp_path / "a.raw", tmp_path / "a.nrrd"
    raw.write_bytes(values("<" + dtype).tobytes(order="F"))
    order = ">" if endian == "big" else "<"
    nrrd.write(str(file), values(order + dtype), {"encoding": encoding, "spacings": [1.0, 1.0, 2.0]})
    size = ",".join(map(str, SIZE))
    bare = draw(tmp_path, "--volume", raw, "--volume-size", size, "--volume-type", name, "--volume-spacing", "1,1,2")
    assert draw(tmp_path, "--volume", file) == bare
    detached = tmp_path / "b.nhdr"
    nrrd.write(str(detached), values(order + dtype), {"encoding": encoding, "spacings": [1.0, 1.0, 2.0]})
    assert draw(tmp_path, "--volume", detached) == bare
    # The picture shows the values.
    nrrd.write(str(file), values(order + dtype)[::-1], {"encoding": encoding, "spacings": [1.0, 1.0, 2.0]})
    assert draw(tmp_path, "--volume", file) != bare
