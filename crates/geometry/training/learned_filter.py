"""Trains the learned filter: samples, network, samples with that network, next network, and so on.

    python crates/geometry/training/learned_filter.py CLEAN WEIGHTS.safetensors --samples target/release/examples/learned_samples

CLEAN is a folder of clean meshes (OBJ). Features come from the example `learned_samples`, so that training and use have one
implementation. Needs numpy; with `--gpu` CuPy as well.

The network that mixes in what `auto` finds (`--fusion`) has to know how far the stages can be trusted on shapes that they have never seen.
So its samples come from stages that were trained on the other shapes: with `--folds 2`, once on each half of the shapes (Wolpert,
*Stacked generalization*, Neural Networks 5, 1992).
"""

import argparse
import json
import re
import subprocess
import time
from pathlib import Path

import numpy as np

xp = np  # what computes: numpy, or CuPy with the same functions

HIDDEN = (224, 192, 128)
CANDIDATES, FEATURES, PER_SURFACE = 52, 235, 4  # the features begin with the candidates' normals
INPUT_NORMAL = slice(221, 224)  # where the features have the normal of the input
NARROW = slice(21, 24)  # a narrow bilateral filter: what is easy anyway
EASY = 2.5  # degrees
BATCH = 8192


def unit(x):
    """Unit vectors, with a derivative everywhere, and the lengths."""
    length = xp.sqrt((x * x).sum(-1, keepdims=True) + 1e-12)
    return x / length, length


def through_unit(gradient, unit_vectors, length):
    """Derivative by x, given that by unit(x)."""
    return (gradient - unit_vectors * (unit_vectors * gradient).sum(-1, keepdims=True)) / length


def angles(a, b):
    """Angles between unit vectors, degrees."""
    return xp.degrees(xp.arctan2(xp.linalg.norm(xp.cross(a, b), axis=1), (a * b).sum(1)))


def on_host(x):
    """An array of numpy."""
    return x if xp is np else xp.asnumpy(x)


class Network:
    """Says which mixture of candidate normals, with which correction, and how much of the input a face should have."""

    def __init__(self, mean, deviation, others, random):
        self.mean, self.deviation = mean, deviation
        sizes = (len(mean), *HIDDEN, CANDIDATES + others + 4)
        bound = [1 / np.sqrt(a) for a in sizes]
        draw = lambda k, *shape: xp.asarray(random.uniform(-bound[k], bound[k], shape).astype(np.float32))  # noqa: E731
        self.weights = [draw(k, b, a) for k, (a, b) in enumerate(zip(sizes, sizes[1:]))]
        self.biases = [draw(k, b) for k, b in enumerate(sizes[1:])]
        self.biases[-1][-1] = -1.5
        # Normals of other surfaces come after all features of the mesh itself.
        own = np.arange(3 * CANDIDATES).reshape(-1, 3)
        self.places = xp.asarray(np.concatenate([own, FEATURES + PER_SURFACE * np.arange(others)[:, None] + np.arange(3)]))

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
            layers.append(xp.maximum(values, 0, out=values) if k + 1 < len(self.weights) else values)
        out, count = layers[-1], len(self.places)
        shares = xp.exp(out[:, :count] - out[:, :count].max(1, keepdims=True))
        shares /= shares.sum(1, keepdims=True)
        candidates = x[:, self.places]
        mixed = xp.matmul(shares[:, None, :], candidates)[:, 0] + 0.5 * out[:, count : count + 3]
        found, mixed_length = unit(mixed)
        kept = 1 / (1 + xp.exp(xp.clip(-2 * out[:, count + 3 :], None, 80)))
        own = x[:, INPUT_NORMAL]
        normals, length = unit((1 - kept) * found + kept * own)
        return normals, (layers, shares, candidates, found, mixed_length, kept, own, length)

    def gradients(self, x, truth, weight):
        """Weighted mean distance of the normals from the true ones, and its derivatives by the parameters."""
        normals, (layers, shares, candidates, found, mixed_length, kept, own, length) = self.forward(x)
        difference = normals - truth
        distance = xp.sqrt((difference * difference).sum(1) + 1e-7)
        by_sum = through_unit(difference * (weight / distance / len(x))[:, None], normals, length)
        by_mixed = through_unit((1 - kept) * by_sum, found, mixed_length)
        by_shares = xp.matmul(candidates, by_mixed[:, :, None])[:, :, 0]
        by_shares = shares * (by_shares - (shares * by_shares).sum(1, keepdims=True))
        by_gate = 2 * kept * (1 - kept) * (by_sum * (own - found)).sum(1, keepdims=True)
        back = xp.concatenate([by_shares, 0.5 * by_mixed, by_gate], axis=1)
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
        self.first = [xp.zeros_like(p) for p in parameters]
        self.second = [xp.zeros_like(p) for p in parameters]

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
            p -= scale * first / (xp.sqrt(second * second_scale) + 1e-8)


class Samples:
    """Samples of prefixes: features, true normals, and the piece of each."""

    def __init__(self, *prefixes):
        features = [np.load(f"{prefix}.features.npy", mmap_mode="r") for prefix in prefixes]
        targets = [np.load(f"{prefix}.targets.npy") for prefix in prefixes]
        pieces = [[line.split() for line in open(f"{prefix}.pieces.txt")] for prefix in prefixes]
        first = np.cumsum([0] + [len(of) for of in pieces[:-1]])
        # One file stays where it is, since it may be larger than the memory.
        self.features = features[0] if len(features) == 1 else np.concatenate(features)
        self.features = self.features if xp is np else xp.asarray(self.features)
        self.truth = xp.asarray(np.ascontiguousarray(np.concatenate(targets)[:, :3]))
        self.piece = np.concatenate([of[:, 3].astype(np.int64) + k for of, k in zip(targets, first)])
        self.pieces = sum(pieces, [])

    def rows(self, which):
        """Features of some samples in single precision, as the filter clamps them."""
        return xp.clip(self.features[which], -20, 20).astype(np.float32)

    def mean_errors(self, normals):
        """Mean angle of each piece between the true normals and those that `normals` finds for features, degrees."""
        count = len(self.features)
        parts = [slice(k, k + 65536) for k in range(0, count, 65536)]
        error = np.concatenate([on_host(angles(normals(self.rows(part)), self.truth[part])) for part in parts])
        sizes = np.bincount(self.piece, minlength=len(self.pieces))
        return np.bincount(self.piece, error, minlength=len(self.pieces)) / np.maximum(sizes, 1)


def train(samples, others, epochs, rate, seed, left_out=()):
    """Fits a network to samples, but for the pieces of the shapes that are left out."""
    random = np.random.default_rng(seed)
    # A piece counts by how well it can be done at all: what is easy is asked for more precisely.
    base = np.minimum(*(samples.mean_errors(lambda x, c=c: unit(x[:, c])[0]) for c in (NARROW, INPUT_NORMAL)))
    weight = (1 / (base + EASY))[samples.piece].astype(np.float32)
    weight = xp.asarray(weight / weight.mean())
    is_used = np.array([name not in left_out for name, _ in samples.pieces])
    used = np.flatnonzero(is_used[samples.piece])
    some = samples.rows(xp.asarray(np.sort(random.choice(used, min(len(used), 200_000), replace=False))))
    network = Network(some.mean(0), some.std(0) + np.float32(1e-2), others, random)
    batch = min(BATCH, len(used))
    steps = len(used) // batch
    optimiser = Adam(network.parameters(), rate, epochs * steps)
    start = time.time()
    for epoch in range(epochs):
        order, total = random.permutation(used), 0.0
        for k in range(steps):
            rows = xp.asarray(np.sort(order[k * batch : (k + 1) * batch]))
            loss, gradients = network.gradients(samples.rows(rows), samples.truth[rows], weight[rows])
            optimiser.move(gradients)
            total += loss
        print(f"  epoch {epoch + 1}: loss {float(total) / steps:.5f}, {time.time() - start:.0f} s", flush=True)
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
    return {key: on_host(value).astype("<f2") for key, value in found.items()}


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


def shape_of(name):
    """The shape of a mesh: its name but for the way in which it was remeshed."""
    return re.sub(r"_(iso|dec|q|quad|gmsh|occ)$", "", name)


def parts_of(clean, count, folder):
    """Splits a folder of meshes by shape. Returns for each of `count` parts a folder with the meshes of the others, and one with its own."""
    files = sorted(Path(clean).glob("*.obj"))
    shapes = sorted({shape_of(file.stem) for file in files})
    part = {shape: k % count for k, shape in enumerate(shapes)}
    found = []
    for k in range(count):
        found.append((Path(folder, f"others{k}"), Path(folder, f"own{k}")))
        for path in found[-1]:
            path.mkdir(parents=True, exist_ok=True)
            for file in files:
                link = path / file.name
                if (part[shape_of(file.stem)] == k) == (path == found[-1][1]) and not link.exists():
                    link.symlink_to(file.resolve())
    return found


class Training:
    """What all networks are trained with."""

    def __init__(self, options):
        self.options = options

    def samples(self, name, number, clean, weights, prefix, extra=()):
        """Makes the samples of a network. Each network sees other pieces with other noise than those before, which those before fit too
        well."""
        options, start = self.options, time.time()
        draws = options.fusion_draws if name == "fusion" else options.draws
        command = [options.samples, str(clean), prefix, "--draws", str(draws), "--rows", str(options.rows)]
        command += ["--seed", str(100_000_000_000 * (options.seed * 10 + number + 1)), *extra]
        command += ["--weights", weights] if Path(weights).exists() else []
        subprocess.run(command, check=True)
        print(f"{prefix}: samples in {time.time() - start:.0f} s", flush=True)

    def stages(self, clean, weights, name, first=0):
        """Trains the stages one after the other, and writes the weights after each."""
        options = self.options
        tensors = load(weights) if first else {}
        kept = [f"stage{k}" for k in range(first)]
        tensors = {key: value for key, value in tensors.items() if key.split(".")[0] in kept}
        Path(weights).unlink(missing_ok=True)
        for k in range(first, options.stages):
            if tensors:
                save(weights, tensors)
            prefix = f"{options.folder}/{name}stage{k}"
            self.samples("stage", k, clean, weights, prefix)
            network = train(Samples(prefix), 0, options.epochs, options.rate, options.seed + k)
            tensors.update(tensors_of(network, f"stage{k}"))
        save(weights, tensors)

    def fusion(self, weights):
        """Trains the network that mixes in what `auto` finds, with stages that have not seen the shapes, and adds it to the weights."""
        options, prefixes = self.options, []
        for k, (others, own) in enumerate(parts_of(options.clean, options.folds, options.folder)):
            stages = f"{options.folder}/part{k}.safetensors"
            if not options.parts_ready:
                print(f"part {k} of {options.folds}", flush=True)
                self.stages(others, stages, f"part{k}-")
            prefixes.append(f"{options.folder}/part{k}-fusion")
            found = f"{options.others}{k}"
            if not options.others_ready:
                Path(found).mkdir(exist_ok=True)
                self.samples("fusion", options.stages, own, stages, prefixes[-1], ["--others", found, "--make-others"])
            self.samples("fusion", options.stages, own, stages, prefixes[-1], ["--others", found])
        network = train(Samples(*prefixes), 1, options.epochs, options.rate, options.seed + options.stages)
        tensors = {key: value for key, value in load(weights).items() if key.startswith("stage")}
        save(weights, {**tensors, **tensors_of(network, "fusion")})


def main():
    """Trains all networks and writes the weights after each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clean")
    parser.add_argument("weights")
    parser.add_argument("--samples", default="target/release/examples/learned_samples", help="the built example")
    parser.add_argument("--folder", default="/tmp", help="where samples are kept")
    parser.add_argument("--stages", type=int, default=3)
    parser.add_argument("--fusion", action="store_true", help="also the network that mixes in what `auto` finds")
    parser.add_argument("--folds", type=int, default=2, help="parts of the shapes, each with stages of its own for the fusion")
    parser.add_argument("--parts-ready", action="store_true", help="take the stages of the parts that are in FOLDER")
    parser.add_argument("--others", default="/tmp/others", help="folders for what `auto` finds, a number is added")
    parser.add_argument("--others-ready", action="store_true", help="take what is in those folders and make no more")
    parser.add_argument("--fusion-draws", type=int, default=6)
    parser.add_argument("--first", type=int, default=0, help="stages before this one are read from the weights")
    parser.add_argument("--draws", type=int, default=12, help="pieces of each mesh")
    parser.add_argument("--rows", type=int, default=2000, help="faces of each piece")
    parser.add_argument("--epochs", type=int, default=8)
    parser.add_argument("--rate", type=float, default=2e-3)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--gpu", action="store_true", help="compute with CuPy")
    options = parser.parse_args()
    if options.gpu:
        global xp
        import cupy as xp
    training = Training(options)
    if options.first < options.stages:
        training.stages(options.clean, options.weights, "", options.first)
    if options.fusion:
        training.fusion(options.weights)


if __name__ == "__main__":
    main()
