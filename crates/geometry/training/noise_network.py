"""Fits the network of the noise estimate to samples of regions, and calibrates it on shapes that it has not seen.

    python crates/geometry/training/noise_network.py samples.npy crates/geometry/src/denoise/noise_field/network.json

`samples.npy` and `samples.txt` are made by the example `noise_samples`. Needs numpy. Meshes whose names differ only in how they
are meshed (`_iso`, `_dec`, …) count as one shape.
"""

import argparse
import json
import re
from pathlib import Path

import numpy as np

HIDDEN = (32, 16)
SLOPE = 0.1  # of the activation for negative values
EPOCHS, BATCH, DECAY = 8, 512, 3e-3
FOLDS = 8
# Networks that differ by their starting weights err differently on shapes that they have not seen: their mean counts.
MEMBERS = 4
# Too little noise costs much, too much little: the level is the upper quintile of what the statistics leave open.
QUANTILE = 0.8
LEAST_SIGMA = 0.004  # local edges; below, noise is as good as none
NOISY = 0.025  # local edges: turns faces by one or two degrees
UNSURE = (0.012, 0.035)  # levels for which either answer is right
CLEAN_WEIGHT = 5.0  # a clean mesh is one of 17 versions of its shape
CERTAIN = 6.0
# Of a hundred clean shapes, these fractions are below the two thresholds.
COMPONENT, QUARTER = 0.985, 0.985
VARIANT = re.compile(r"(\.clean|_iso|_dec|_gmsh|_occ|_quad|_q)+$")


def targets(statistics, truth):
    """Excess of the level over the finest band, correlation, and whether there is noise; #rows×3."""
    sigma, correlation = truth.T
    log_sigma = np.log(np.maximum(sigma, LEAST_SIGMA))
    excess = log_sigma - np.maximum(statistics[:, 0], np.log(LEAST_SIGMA))
    noisy = (sigma > NOISY).astype(float)
    return np.stack([excess, np.clip(correlation, -0.5, 1), noisy], 1)


def forward(layers, x):
    """Values of all layers; the last are the outputs."""
    values = [x]
    for k, (weights, bias) in enumerate(layers):
        x = x @ weights + bias
        if k < len(layers) - 1:
            x = np.where(x > 0, x, SLOPE * x)
        values.append(x)
    return values


def gradient(outputs, target, sure):
    """Gradient of the loss: a quantile for the level, squares for what noise is like, and the log-loss of the verdict."""
    noisy = target[:, 2]
    error = outputs - target
    out = np.empty_like(outputs)
    slope = np.where(error[:, 0] < 0, 2 * QUANTILE, 2 * (1 - QUANTILE))
    out[:, 0] = np.clip(error[:, 0], -0.5, 0.5) * slope
    out[:, 1] = 2 * error[:, 1] * noisy
    out[:, 2] = (1 / (1 + np.exp(-outputs[:, 2])) - noisy) * sure
    return out


def fit(x, target, sure, weight, seed):
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
            back = gradient(values[-1], target[rows], sure[rows]) * weight[rows][:, None] / BATCH
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


def fit_members(x, target, sure, weight, seed):
    """Layers of each network of the ensemble."""
    return [fit(x, target, sure, weight, MEMBERS * seed + member) for member in range(MEMBERS)]


def outputs(members, x):
    """Mean of the last layers of the networks."""
    return sum(forward(layers, x)[-1] for layers in members) / len(members)


def by_version(evidence, version):
    """Mean evidence of each version of a mesh, and that of the quarter of its regions with the most of it."""
    _, index = np.unique(version, return_inverse=True)
    order = np.lexsort((-evidence, index))
    groups = np.split(evidence[order], np.cumsum(np.bincount(index))[:-1])
    return np.array([g.mean() for g in groups]), np.array([g[: -(-len(g) // 4)].mean() for g in groups])


def main():
    """Fits, calibrates and writes the network; prints how often it errs on shapes that were left out."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("samples", type=Path)
    parser.add_argument("network", type=Path)
    options = parser.parse_args()
    rows = np.load(options.samples).astype(float)
    names = options.samples.with_suffix(".txt").read_text().split()
    statistics, truth, mesh, draw = rows[:, :-4], rows[:, -4:-2], rows[:, -2].astype(int), rows[:, -1].astype(int)
    shapes = sorted({VARIANT.sub("", name) for name in names})
    fold = np.array([shapes.index(VARIANT.sub("", name)) * 7919 % FOLDS for name in names])[mesh]
    mean, deviation = statistics.mean(0), statistics.std(0) + 1e-6
    x = np.clip((statistics - mean) / deviation, -4, 4)
    target = targets(statistics, truth)
    sure = np.where((truth[:, 0] > UNSURE[0]) & (truth[:, 0] < UNSURE[1]), 0.2, 1.0)
    weight = np.where(draw == 0, CLEAN_WEIGHT, 1.0)

    evidence = np.zeros(len(x))
    for k in range(FOLDS):
        kept = fold != k
        members = fit_members(x[kept], target[kept], sure[kept], weight[kept], k)
        evidence[~kept] = outputs(members, x[~kept])[:, 2]
    version = mesh * 1000 + draw
    whole, quarter = by_version(np.clip(evidence, -CERTAIN, CERTAIN), version)
    clean = np.unique(version) % 1000 == 0
    component, part = np.quantile(whole[clean], COMPONENT), np.quantile(quarter[clean], QUARTER)
    called = (whole > component) | (quarter > part)
    print(f"{len(names)} meshes of {len(shapes)} shapes, {len(x)} regions")
    print(f"clean called noisy: {called[clean].mean():.3f}, noisy called clean: {1 - called[~clean].mean():.3f}")

    members = fit_members(x, target, sure, weight, FOLDS)
    brief = lambda values: [float(f"{v:.5g}") for v in values]
    network = {
        "component_threshold": float(f"{component:.5g}"),
        "quarter_threshold": float(f"{part:.5g}"),
        "mean": brief(mean),
        "deviation": brief(deviation),
        "members": [
            [{"weights": [brief(row) for row in w.T], "bias": brief(b)} for w, b in layers] for layers in members
        ],
    }
    options.network.write_text(json.dumps(network, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
