"""Fits the networks and the decision trees of the noise estimate to samples of regions, and calibrates them on shapes left out.

    python crates/geometry/training/noise_estimate.py crates/geometry/src/denoise/noise_field samples.npy [MORE.npy]

`samples.npy` and `samples.txt` are made by the example `noise_samples`; written are `network.json` and `forest.json`. Needs numpy and
scikit-learn. Meshes whose names differ only in how they are meshed (`_iso`, `_dec`, …) count as one shape.
"""

import argparse
import json
import re
from pathlib import Path

import numpy as np
from sklearn.ensemble import HistGradientBoostingClassifier

HIDDEN = (32, 16)
SLOPE = 0.1  # of the activation for negative values
EPOCHS, BATCH, DECAY = 8, 512, 3e-3
FOLDS = 4
# Networks that differ by their starting weights err differently on shapes that they have not seen: their mean counts.
MEMBERS = 4
# Too little noise costs much, too much little: the level is the upper quintile of what the statistics leave open.
QUANTILE = 0.8
LEAST_SIGMA = 0.004  # local edges; below, noise is as good as none
NOISY = 0.025  # local edges: turns faces by one or two degrees
UNSURE = (0.012, 0.035)  # levels for which either answer is right
CLEAN_WEIGHT = 5.0  # a clean mesh is one of 17 versions of its shape
CERTAIN = 6.0
# Of a hundred clean shapes, so many may be called noisy. From four to five, five more of a hundred noisy ones are found; with each
# further one, two.
TOUCHED = 0.05
# Deviation from which a mesh counts as noisy in the calibration, local edges.
PLAIN = 0.04
TREES = dict(
    max_iter=200, learning_rate=0.08, max_leaf_nodes=12, min_samples_leaf=100, l2_regularization=5, max_features=0.3, random_state=1
)
VARIANT = re.compile(r"(\.clean|_iso|_dec|_gmsh|_occ|_quad|_q)+$")


def targets(statistics, truth):
    """Excess of the level over the finest band, and correlation; #rows×2."""
    sigma, correlation = truth.T
    log_sigma = np.log(np.maximum(sigma, LEAST_SIGMA))
    excess = log_sigma - np.maximum(statistics[:, 0], np.log(LEAST_SIGMA))
    return np.stack([excess, np.clip(correlation, -0.5, 1)], 1)


def forward(layers, x):
    """Values of all layers; the last are the outputs."""
    values = [x]
    for k, (weights, bias) in enumerate(layers):
        x = x @ weights + bias
        if k < len(layers) - 1:
            x = np.where(x > 0, x, SLOPE * x)
        values.append(x)
    return values


def gradient(outputs, target, noisy):
    """Gradient of the loss: a quantile for the level, and squares for what noise is like."""
    error = outputs - target
    out = np.empty_like(outputs)
    slope = np.where(error[:, 0] < 0, 2 * QUANTILE, 2 * (1 - QUANTILE))
    out[:, 0] = np.clip(error[:, 0], -0.5, 0.5) * slope
    out[:, 1] = 2 * error[:, 1] * noisy
    return out


def fit(x, target, noisy, weight, seed):
    """Layers (weights, bias) that are fitted by Adam with a cosine schedule."""
    random = np.random.default_rng(seed)
    sizes = (x.shape[1], *HIDDEN, target.shape[1])
    layers = [
        (random.standard_normal((a, b)) * np.sqrt(2 / a), np.zeros(b)) for a, b in zip(sizes, sizes[1:])
    ]
    moments = [[(np.zeros_like(p), np.zeros_like(p)) for p in layer] for layer in layers]
    steps, step = EPOCHS * (len(x) // BATCH), 0
    for _ in range(EPOCHS):
        order = random.permutation(len(x))
        for start in range(0, len(x) - BATCH + 1, BATCH):
            rows = order[start : start + BATCH]
            values = forward(layers, x[rows])
            back = gradient(values[-1], target[rows], noisy[rows]) * weight[rows][:, None] / BATCH
            step += 1
            rate = 1e-3 * (1 + np.cos(np.pi * step / steps)) + 1e-5
            for k in reversed(range(len(layers))):
                weights, bias = layers[k]
                gradients = (values[k].T @ back + DECAY * weights, back.sum(0))
                if k:
                    back = (back @ weights.T) * np.where(values[k] > 0, 1, SLOPE)
                for parameter, of, (mean, square) in zip((weights, bias), gradients, moments[k]):
                    mean[...] = 0.9 * mean + 0.1 * of
                    square[...] = 0.999 * square + 0.001 * of * of
                    corrected = mean / (1 - 0.9**step)
                    parameter -= rate * corrected / (np.sqrt(square / (1 - 0.999**step)) + 1e-8)
    return layers


def fit_trees(statistics, noisy, weight):
    """Trees that say whether a region has noise, by gradient boosting."""
    return HistGradientBoostingClassifier(**TREES).fit(statistics, noisy, sample_weight=weight)


def by_version(evidence, version):
    """Mean evidence of each version of a mesh, and that of the quarter of its regions with the most of it."""
    _, index = np.unique(version, return_inverse=True)
    order = np.lexsort((-evidence, index))
    groups = np.split(evidence[order], np.cumsum(np.bincount(index))[:-1])
    return np.array([g.mean() for g in groups]), np.array([g[: -(-len(g) // 4)].mean() for g in groups])


def load(files):
    """Rows of all files, whose meshes are numbered on, and the names of the meshes."""
    rows, names = [], []
    for file in files:
        of_file = np.load(file).astype(float)
        of_file[:, -2] += len(names)
        rows.append(of_file)
        names += file.with_suffix(".txt").read_text().split()
    return np.concatenate(rows), names


def called(whole, quarter, thresholds):
    """Whether each version of a mesh is called noisy."""
    return (whole > thresholds[0]) | (quarter > thresholds[1])


def thresholds_for(whole, quarter):
    """The lowest thresholds, both at the same quantile of clean shapes, by which no more of these are called noisy than may be."""
    for quantile in np.arange(0.9, 1, 0.001):
        thresholds = np.quantile(whole, quantile), np.quantile(quarter, quantile)
        if called(whole, quarter, thresholds).mean() <= TOUCHED:
            break
    return thresholds


def table_of_trees(trees):
    """The nodes of each tree as lists, see `forest.rs`."""
    tables = []
    for (predictor,) in trees._predictors:
        nodes = predictor.nodes
        leaf = nodes["is_leaf"].astype(bool)
        number = lambda x: float(f"{x:.6g}")
        tables.append(
            {
                "asks": np.where(leaf, -1, nodes["feature_idx"]).tolist(),
                "values": [number(x) for x in np.where(leaf, nodes["value"], nodes["num_threshold"])],
                "left": np.where(leaf, 0, nodes["left"]).tolist(),
                "right": np.where(leaf, 0, nodes["right"]).tolist(),
            }
        )
    return tables


def main():
    """Fits, calibrates and writes; prints how often the trees err on shapes that were left out."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("samples", type=Path, nargs="+")
    options = parser.parse_args()
    rows, names = load(options.samples)
    statistics, truth = rows[:, :-4], rows[:, -4:-2]
    mesh, draw = rows[:, -2].astype(int), rows[:, -1].astype(int)
    shapes = sorted({VARIANT.sub("", name) for name in names})
    fold = np.array([shapes.index(VARIANT.sub("", name)) * 7919 % FOLDS for name in names])[mesh]
    noisy = truth[:, 0] > NOISY
    sure = np.where((truth[:, 0] > UNSURE[0]) & (truth[:, 0] < UNSURE[1]), 0.2, 1.0)
    weight = np.where(draw == 0, CLEAN_WEIGHT, 1.0)

    evidence = np.zeros(len(rows))
    for k in range(FOLDS):
        kept = fold != k
        trees = fit_trees(statistics[kept], noisy[kept], (sure * weight)[kept])
        evidence[~kept] = trees.decision_function(statistics[~kept])
    version, index = np.unique(mesh * 1000 + draw, return_inverse=True)
    whole, quarter = by_version(np.clip(evidence, -CERTAIN, CERTAIN), mesh * 1000 + draw)
    mean = lambda x: np.bincount(index, x) / np.bincount(index)
    clean, plain = version % 1000 == 0, np.sqrt(mean(truth[:, 0] ** 2)) > PLAIN
    plain &= ~clean
    component, part = thresholds_for(whole[clean], quarter[clean])
    verdict = called(whole, quarter, (component, part))
    print(f"{len(names)} meshes of {len(shapes)} shapes, {len(rows)} regions")
    print(f"clean called noisy: {verdict[clean].mean():.3f}, noisy called clean: {1 - verdict[plain].mean():.3f}")

    short = lambda x: float(f"{x:.5g}")
    trees = fit_trees(statistics, noisy, sure * weight)
    forest = {
        "component_threshold": short(component),
        "quarter_threshold": short(part),
        "start": short(np.ravel(trees._baseline_prediction)[0]),
        "trees": table_of_trees(trees),
    }
    (options.folder / "forest.json").write_text(json.dumps(forest, separators=(",", ":")) + "\n")

    centre, deviation = statistics.mean(0), statistics.std(0) + 1e-6
    x = np.clip((statistics - centre) / deviation, -4, 4)
    # The seeds differ from those of the folds.
    members = [fit(x, targets(statistics, truth), noisy.astype(float), weight, MEMBERS * FOLDS + k) for k in range(MEMBERS)]
    brief = lambda values: [short(v) for v in values]
    network = {
        "mean": brief(centre),
        "deviation": brief(deviation),
        "members": [
            [{"weights": [brief(row) for row in w.T], "bias": brief(b)} for w, b in layers] for layers in members
        ],
    }
    (options.folder / "network.json").write_text(json.dumps(network, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
