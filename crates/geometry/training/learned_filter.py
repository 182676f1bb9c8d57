"""Trains the learned filter: samples, network, samples with that network, next network, and so on.

    python crates/geometry/training/learned_filter.py CLEAN WEIGHTS.safetensors --samples target/release/examples/learned_samples

CLEAN is a folder of clean meshes (OBJ). Features come from the example `learned_samples`, so that training and use have one
implementation. Needs numpy.
"""

import argparse
import json
import subprocess
import time
from pathlib import Path

import numpy as np

HIDDEN = (224, 192, 128)
CANDIDATES, FEATURES, PER_SURFACE = 52, 235, 4  # the features begin with the candidates' normals
INPUT_NORMAL = slice(221, 224)  # where the features have the normal of the input
NARROW = slice(21, 24)  # a narrow bilateral filter: what is easy anyway
EASY = 2.5  # degrees
BATCH = 8192


def unit(x):
    """Unit vectors, with a derivative everywhere, and the lengths."""
    length = np.sqrt((x * x).sum(-1, keepdims=True) + 1e-12)
    return x / length, length


def through_unit(gradient, unit_vectors, length):
    """Derivative by x, given that by unit(x)."""
    return (gradient - unit_vectors * (unit_vectors * gradient).sum(-1, keepdims=True)) / length


def angles(a, b):
    """Angles between unit vectors, degrees."""
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(1)))


class Network:
    """Says which mixture of candidate normals, with which correction, and how much of the input a face should have."""

    def __init__(self, mean, deviation, others, random):
        self.mean, self.deviation = mean, deviation
        sizes = (len(mean), *HIDDEN, CANDIDATES + others + 4)
        bound = [1 / np.sqrt(a) for a in sizes]
        draw = lambda k, *shape: random.uniform(-bound[k], bound[k], shape).astype(np.float32)  # noqa: E731
        self.weights = [draw(k, b, a) for k, (a, b) in enumerate(zip(sizes, sizes[1:]))]
        self.biases = [draw(k, b) for k, b in enumerate(sizes[1:])]
        self.biases[-1][-1] = -1.5
        # Normals of other surfaces come after all features of the mesh itself.
        own = np.arange(3 * CANDIDATES).reshape(-1, 3)
        self.places = np.concatenate([own, FEATURES + PER_SURFACE * np.arange(others)[:, None] + np.arange(3)])

    def parameters(self):
        """All that is fitted."""
        return self.weights + self.biases

    def normals(self, x):
        """Normals (#samples×3) in the frames of the faces."""
        return self.forward(x)[0]

    def forward(self, x):
        """Normals, and all that their derivatives need."""
        layers = [(x - self.mean) / self.deviation]
        for k, (weight, bias) in enumerate(zip(self.weights, self.biases)):
            values = layers[-1] @ weight.T + bias
            layers.append(np.maximum(values, 0, out=values) if k + 1 < len(self.weights) else values)
        out, count = layers[-1], len(self.places)
        shares = np.exp(out[:, :count] - out[:, :count].max(1, keepdims=True))
        shares /= shares.sum(1, keepdims=True)
        candidates = x[:, self.places]
        mixed = np.matmul(shares[:, None, :], candidates)[:, 0] + 0.5 * out[:, count : count + 3]
        found, mixed_length = unit(mixed)
        kept = 1 / (1 + np.exp(np.clip(-2 * out[:, count + 3 :], None, 80)))
        own = x[:, INPUT_NORMAL]
        normals, length = unit((1 - kept) * found + kept * own)
        return normals, (layers, shares, candidates, found, mixed_length, kept, own, length)

    def gradients(self, x, truth, weight):
        """Weighted mean distance of the normals from the true ones, and its derivatives by the parameters."""
        normals, (layers, shares, candidates, found, mixed_length, kept, own, length) = self.forward(x)
        difference = normals - truth
        distance = np.sqrt((difference * difference).sum(1) + 1e-7)
        by_sum = through_unit(difference * (weight / distance / len(x))[:, None], normals, length)
        by_mixed = through_unit((1 - kept) * by_sum, found, mixed_length)
        by_shares = np.matmul(candidates, by_mixed[:, :, None])[:, :, 0]
        by_shares = shares * (by_shares - (shares * by_shares).sum(1, keepdims=True))
        by_gate = 2 * kept * (1 - kept) * (by_sum * (own - found)).sum(1, keepdims=True)
        back = np.concatenate([by_shares, 0.5 * by_mixed, by_gate], axis=1)
        weights, biases = [], []
        for k in reversed(range(len(self.weights))):
            weights.insert(0, back.T @ layers[k])
            biases.insert(0, back.sum(0))
            if k:
                back = (back @ self.weights[k]) * (layers[k] > 0)
        return (weight * distance).mean(), weights + biases


class Adam:
    """Adam with decoupled decay of the weights (Loshchilov and Hutter 2019); the rate rises, and falls as a cosine."""

    def __init__(self, parameters, rate, steps):
        self.parameters, self.rate, self.steps, self.step = parameters, rate, steps, 0
        self.first = [np.zeros_like(p) for p in parameters]
        self.second = [np.zeros_like(p) for p in parameters]

    def move(self, gradients):
        """Takes a step."""
        self.step += 1
        part, warm = self.step / self.steps, 0.15
        rate = self.rate * (part / warm if part < warm else 0.5 + 0.5 * np.cos(np.pi * (part - warm) / (1 - warm)))
        scale = rate / (1 - 0.9**self.step)
        second_scale = 1 / (1 - 0.999**self.step)
        for p, first, second, gradient in zip(self.parameters, self.first, self.second, gradients):
            p *= 1 - 1e-3 * rate
            first += 0.1 * (gradient - first)
            second += 0.001 * (gradient * gradient - second)
            p -= scale * first / (np.sqrt(second * second_scale) + 1e-8)


class Samples:
    """Samples of a prefix: features, true normals, and the piece of each."""

    def __init__(self, prefix):
        self.features = np.load(f"{prefix}.features.npy", mmap_mode="r")
        targets = np.load(f"{prefix}.targets.npy")
        self.truth, self.piece = np.ascontiguousarray(targets[:, :3]), targets[:, 3].astype(np.int64)
        self.pieces = [line.split() for line in open(f"{prefix}.pieces.txt")]

    def rows(self, which):
        """Features of some samples in single precision, as the filter clamps them."""
        return np.clip(self.features[which], -20, 20).astype(np.float32)

    def mean_errors(self, normals):
        """Mean angle of each piece between the true normals and those that `normals` finds for features, degrees."""
        count = len(self.features)
        parts = [slice(k, k + 65536) for k in range(0, count, 65536)]
        error = np.concatenate([angles(normals(self.rows(part)), self.truth[part]) for part in parts])
        sizes = np.bincount(self.piece, minlength=len(self.pieces))
        return np.bincount(self.piece, error, minlength=len(self.pieces)) / np.maximum(sizes, 1)


def train(samples, others, epochs, rate, seed, left_out=()):
    """Fits a network to samples, but for the pieces of the shapes that are left out."""
    random = np.random.default_rng(seed)
    # A piece counts by how well it can be done at all: what is easy is asked for more precisely.
    base = np.minimum(*(samples.mean_errors(lambda x, c=c: unit(x[:, c])[0]) for c in (NARROW, INPUT_NORMAL)))
    weight = (1 / (base + EASY))[samples.piece].astype(np.float32)
    weight /= weight.mean()
    is_used = np.array([name not in left_out for name, _ in samples.pieces])
    used = np.flatnonzero(is_used[samples.piece])
    some = samples.rows(np.sort(random.choice(used, min(len(used), 200_000), replace=False)))
    network = Network(some.mean(0), some.std(0) + np.float32(1e-2), others, random)
    batch = min(BATCH, len(used))
    steps = len(used) // batch
    optimiser = Adam(network.parameters(), rate, epochs * steps)
    start = time.time()
    for epoch in range(epochs):
        order, total = random.permutation(used), 0.0
        for k in range(steps):
            rows = np.sort(order[k * batch : (k + 1) * batch])
            loss, gradients = network.gradients(samples.rows(rows), samples.truth[rows], weight[rows])
            optimiser.move(gradients)
            total += loss
        print(f"  epoch {epoch + 1}: loss {total / steps:.5f}, {time.time() - start:.0f} s", flush=True)
    report(samples, samples.mean_errors(network.normals), base, is_used)
    return network


def report(samples, found, base, is_used):
    """Prints mean errors by kind of noise, for pieces that were used and those that were left out."""
    kinds = np.array([kind for _, kind in samples.pieces])
    for kind in sorted(set(kinds)):
        for name, which in [("used", is_used), ("left out", ~is_used)]:
            those = which & (kinds == kind)
            if those.any():
                print(f"  {kind:12} {those.sum():5} {name:8}: {found[those].mean():6.2f}° (easy filter {base[those].mean():6.2f}°)")
    print(f"  {len(samples.features)} samples, mean {found.mean():.3f}°", flush=True)


def tensors_of(network, name):
    """Tensors of a network as the filter reads them."""
    found = {f"{name}.mean": network.mean, f"{name}.deviation": network.deviation}
    for k, (weight, bias) in enumerate(zip(network.weights, network.biases)):
        found[f"{name}.{k}.weight"], found[f"{name}.{k}.bias"] = weight, bias
    return {key: value.astype("<f2") for key, value in found.items()}


def save(path, tensors):
    """Writes a safetensors file of halves."""
    head, offset = {}, 0
    for name, tensor in tensors.items():
        head[name] = {"dtype": "F16", "shape": tensor.shape, "data_offsets": [offset, offset + tensor.nbytes]}
        offset += tensor.nbytes
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 8)
    Path(path).write_bytes(len(text).to_bytes(8, "little") + text + b"".join(t.tobytes() for t in tensors.values()))


def load(path):
    """Tensors of a safetensors file of halves."""
    data = Path(path).read_bytes()
    length = int.from_bytes(data[:8], "little")
    head, body = json.loads(data[8 : 8 + length]), data[8 + length :]
    cut = {name: body[slice(*info["data_offsets"])] for name, info in head.items()}
    return {name: np.frombuffer(cut[name], "<f2").reshape(info["shape"]) for name, info in head.items()}


def main():
    """Trains all stages and writes the weights after each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clean")
    parser.add_argument("weights")
    parser.add_argument("--samples", default="target/release/examples/learned_samples", help="the built example")
    parser.add_argument("--folder", default="/tmp", help="where samples are kept")
    parser.add_argument("--stages", type=int, default=3)
    parser.add_argument("--fusion", action="store_true", help="also the network that mixes in what `auto` finds")
    parser.add_argument("--others", default="/tmp/others", help="folder for what `auto` finds, which takes longest")
    parser.add_argument("--others-ready", action="store_true", help="take what is in that folder and make no more")
    parser.add_argument("--fusion-draws", type=int, default=6)
    parser.add_argument("--first", type=int, default=0, help="stages before this one are read from the weights")
    parser.add_argument("--draws", type=int, default=12, help="pieces of each mesh")
    parser.add_argument("--rows", type=int, default=2000, help="faces of each piece")
    parser.add_argument("--epochs", type=int, default=8)
    parser.add_argument("--rate", type=float, default=2e-3)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    tensors = load(options.weights) if options.first else {}
    names = [f"stage{k}" for k in range(options.stages)] + (["fusion"] if options.fusion else [])
    tensors = {key: value for key, value in tensors.items() if key.split(".")[0] in names[: options.first]}
    for k, name in enumerate(names[options.first :], options.first):
        save(options.weights, tensors)
        prefix, start = f"{options.folder}/{name}", time.time()
        draws = options.fusion_draws if name == "fusion" else options.draws
        command = [options.samples, options.clean, prefix, "--draws", str(draws), "--rows", str(options.rows)]
        # Each stage sees other pieces with other noise than those before, which those before fit too well.
        command += ["--seed", str(100_000_000_000 * (options.seed * 10 + k + 1))]
        command += ["--weights", options.weights] if tensors else []
        if name == "fusion":
            command += ["--others", options.others]
            if not options.others_ready:
                Path(options.others).mkdir(exist_ok=True)
                subprocess.run([*command, "--make-others"], check=True)
        subprocess.run(command, check=True)
        print(f"{name}: samples in {time.time() - start:.0f} s", flush=True)
        network = train(Samples(prefix), int(name == "fusion"), options.epochs, options.rate, options.seed + k)
        tensors.update(tensors_of(network, name))
        save(options.weights, tensors)


if __name__ == "__main__":
    main()
