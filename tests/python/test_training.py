"""The pipeline that trains the learned filter, on a few shapes: it runs, it learns, and its derivatives are right."""

import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import REPO, binary

TRAINING = REPO / "crates/geometry/training"
sys.path.insert(0, str(TRAINING))
import learned_filter  # noqa: E402


def test_derivatives_are_those_of_the_loss():
    """Central differences of the loss by some weights."""
    random = np.random.default_rng(3)
    features = random.normal(size=(40, learned_filter.FEATURES + learned_filter.PER_SURFACE))
    network = learned_filter.Network(features.mean(0), features.std(0), 1, random)
    network.weights = [w.astype(float) for w in network.weights]
    network.biases = [b + 0.01 * random.normal(size=b.shape) for b in network.biases]
    truth = learned_filter.unit(random.normal(size=(40, 3)))[0]
    weight = random.uniform(0.5, 2, 40)
    gradients = network.gradients(features, truth, weight)[1]
    for values, gradient in zip(network.parameters(), gradients):
        for _ in range(5):
            place, step = tuple(random.integers(0, n) for n in values.shape), 1e-6
            before, losses = values[place], []
            for moved in (before + step, before - step):
                values[place] = moved
                losses.append(network.gradients(features, truth, weight)[0])
            values[place] = before
            assert (losses[0] - losses[1]) / (2 * step) == pytest.approx(gradient[place], rel=1e-4, abs=1e-8)


def test_all_stages_are_trained_from_clean_shapes(tmp_path):
    """The documented commands on ten shapes of our own; the loss of each network falls."""
    shapes, weights = tmp_path / "shapes", tmp_path / "weights.safetensors"
    subprocess.run([sys.executable, TRAINING / "shapes.py", shapes, "--count", "10"], check=True)
    command = [sys.executable, TRAINING / "learned_filter.py", shapes, weights, "--folder", tmp_path, "--stages", "2", "--fusion", "--others", tmp_path / "others"]
    command += ["--draws", "1", "--fusion-draws", "1", "--rows", "500", "--epochs", "4"]
    command += ["--samples", binary("examples/learned_samples", "PLANISH_LEARNED_SAMPLES")]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    losses = [float(loss) for loss in re.findall(r"loss ([\d.]+)", printed)]
    assert len(losses) == 28  # two stages on all shapes and on each half, and the fusion
    assert all(last < 0.95 * first for first, last in zip(losses[::4], losses[3::4])), printed
    tensors = learned_filter.load(weights)
    assert {name.split(".")[0] for name in tensors} == {"stage0", "stage1", "fusion"}
    assert all(np.isfinite(tensor).all() for tensor in tensors.values())
    names = [{path.stem for path in tmp_path.glob(f"{name}/*.obj")} for name in ("own0", "others0", "own1", "others1")]
    assert names[0].isdisjoint(names[1]) and len(names[0] | names[1]) == 10
    assert names[0] == names[3] and names[1] == names[2]


def test_meshes_of_one_shape_are_never_parted():
    """A remeshed copy of a shape that was trained on would tell the fusion too much good of the stages."""
    assert learned_filter.shape_of("scorpion_dec") == learned_filter.shape_of("scorpion_iso") == "scorpion"
    assert learned_filter.shape_of("cad_so_base_occ") == "cad_so_base"
    assert learned_filter.shape_of("own_blob_001") == "own_blob_001"
