"""What the tests of the Python package share: the command line to compare with, and a mesh in arrays."""

import json
import subprocess

import numpy as np
import trimesh

from conftest import REPO

DUCK = REPO / "data" / "duck_noisy.obj"


def command(planish, *args):
    """Runs the command line and returns its report."""
    done = subprocess.run([planish, *args, "--json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def sphere(subdivisions=3, noise=0.01):
    mesh = trimesh.creation.icosphere(subdivisions)
    random = np.random.default_rng(1)
    return np.array(mesh.vertices + random.normal(0, noise, mesh.vertices.shape)), np.array(mesh.faces)
