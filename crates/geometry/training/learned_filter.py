"""Trains the learned filter: samples, network, samples with that network, next network, and so on.

    python crates/geometry/training/learned_filter.py CLEAN WEIGHTS.safetensors --samples target/release/examples/learned_samples

CLEAN is a folder of clean meshes (OBJ). Features come from the example `learned_samples`, so that training and use have one
implementation. Needs numpy and torch; uses a GPU where there is one.
"""

import argparse
import json
import subprocess
import time
from pathlib import Path

import numpy as np
import torch

HIDDEN = (224, 192, 128)
CANDIDATES, FEATURES, PER_SURFACE = 52, 235, 4
INPUT_NORMAL = slice(221, 224)  # where the features have the normal of the input
NARROW = slice(21, 24)  # a narrow bilateral filter: what is easy anyway
EASY = 2.5  # degrees
BATCH = 8192


class Network(torch.nn.Module):
    """Says which mixture of candidate normals, with which correction, and how much of the input a face should have."""

    def __init__(self, features, candidates, mean, deviation):
        super().__init__()
        self.register_buffer("mean", mean)
        self.register_buffer("deviation", deviation)
        sizes = (features, *HIDDEN, candidates + 4)
        self.layers = torch.nn.ModuleList(torch.nn.Linear(a, b) for a, b in zip(sizes, sizes[1:]))
        torch.nn.init.constant_(self.layers[-1].bias[-1:], -1.5)
        own = torch.arange(3 * CANDIDATES).reshape(-1, 3)
        others = FEATURES + PER_SURFACE * torch.arange(candidates - CANDIDATES)[:, None] + torch.arange(3)
        self.register_buffer("places", torch.cat([own, others]))

    def forward(self, x):
        """Normals (#samples×3) in the frames of the faces."""
        values = (x - self.mean) / self.deviation
        for k, layer in enumerate(self.layers):
            values = layer(values if k == 0 else torch.relu(values))
        count = len(self.places)
        shares = torch.softmax(values[:, :count], 1)
        mean = (shares[:, :, None] * x[:, self.places]).sum(1) + 0.5 * values[:, count : count + 3]
        kept = torch.sigmoid(2 * values[:, count + 3 : count + 4])
        return unit((1 - kept) * unit(mean) + kept * x[:, INPUT_NORMAL])


def unit(x):
    """Unit vectors, with a gradient everywhere."""
    return x / torch.sqrt((x * x).sum(-1, keepdim=True) + 1e-12)


def angles(a, b):
    """Angles between unit vectors, degrees."""
    return torch.rad2deg(torch.atan2(torch.linalg.cross(a, b).norm(dim=1), (a * b).sum(1)))


def batches(x, indices, device):
    """Rows in single precision on the device."""
    return x[indices].to(device, non_blocking=True).float()


def train(prefix, others, epochs, rate, device, seed):
    """Fits a network to the samples of a prefix."""
    torch.manual_seed(seed)
    x = torch.from_numpy(np.load(f"{prefix}.features.npy"))
    targets = torch.from_numpy(np.load(f"{prefix}.targets.npy"))
    kinds = np.array([line.split()[1] for line in open(f"{prefix}.pieces.txt")])
    truth, piece = targets[:, :3].contiguous().to(device), targets[:, 3].long().to(device)
    if device.type == "cuda":
        x = x.to(device)
    # A piece counts by how well it can be done at all: what is easy is asked for more precisely.
    pieces = len(kinds)

    def mean_error(columns):
        error = torch.cat([angles(unit(batches(x, slice(k, k + 65536), device)[:, columns]), truth[k : k + 65536]) for k in range(0, len(x), 65536)])
        count = torch.bincount(piece, minlength=pieces).clamp(min=1)
        return torch.bincount(piece, error, minlength=pieces) / count

    base = torch.minimum(mean_error(NARROW), mean_error(INPUT_NORMAL))
    weight = (1 / (base + EASY))[piece]
    weight = (weight / weight.mean()).float()
    some = batches(x, torch.randperm(len(x), device=x.device)[:200_000], device).clamp(-20, 20)
    network = Network(x.shape[1], CANDIDATES + others, some.mean(0), some.std(0) + 1e-2).to(device)
    optimiser = torch.optim.AdamW(network.parameters(), rate, weight_decay=1e-3)
    steps = max(1, len(x) // BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, epochs * steps + 1, pct_start=0.15)
    compiled = network
    start = time.time()
    for epoch in range(epochs):
        order = torch.randperm(len(x), device=x.device)
        total = torch.zeros((), device=device)
        for k in range(steps):
            rows = order[k * BATCH : (k + 1) * BATCH]
            difference = compiled(batches(x, rows, device)) - truth[rows.to(device)]
            loss = (weight[rows.to(device)] * torch.sqrt((difference * difference).sum(1) + 1e-7)).mean()
            optimiser.zero_grad(set_to_none=True)
            loss.backward()
            optimiser.step()
            schedule.step()
            total += loss.detach()
        if epoch % 5 == 4 or epoch == epochs - 1:
            print(f"  epoch {epoch + 1}: loss {total.item() / steps:.5f}, {time.time() - start:.0f} s", flush=True)
    network.eval()
    with torch.no_grad():
        error = torch.cat([angles(network(batches(x, slice(k, k + 65536), device)), truth[k : k + 65536]) for k in range(0, len(x), 65536)])
    count = torch.bincount(piece, minlength=pieces).clamp(min=1)
    by_piece = (torch.bincount(piece, error, minlength=pieces) / count).cpu().numpy()
    base = base.cpu().numpy()
    for kind in sorted(set(kinds)):
        print(f"  {kind:12} {(kinds == kind).sum():5} pieces: {by_piece[kinds == kind].mean():6.2f}° (easy filter {base[kinds == kind].mean():6.2f}°)")
    print(f"  {len(x)} samples, mean {by_piece.mean():.3f}°", flush=True)
    return network


def tensors_of(network, name):
    """Tensors of a network as the filter reads them."""
    found = {f"{name}.mean": network.mean, f"{name}.deviation": network.deviation}
    for k, layer in enumerate(network.layers):
        found[f"{name}.{k}.weight"], found[f"{name}.{k}.bias"] = layer.weight, layer.bias
    return {key: value.detach().cpu().numpy().astype("<f2") for key, value in found.items()}


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
    parser.add_argument("--fusion", action="store_true", help="also the network that mixes in what `auto` found")
    parser.add_argument("--others", default="/tmp/others", help="folder for what `auto` finds, which takes longest")
    parser.add_argument("--others-ready", action="store_true", help="take what is in that folder and make no more")
    parser.add_argument("--first", type=int, default=0, help="stages before this one are read from the weights")
    parser.add_argument("--draws", type=int, default=12, help="pieces of each mesh")
    parser.add_argument("--fusion-draws", type=int, default=6)
    parser.add_argument("--rows", type=int, default=2000, help="faces of each piece")
    parser.add_argument("--epochs", type=int, default=8)
    parser.add_argument("--rate", type=float, default=2e-3)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    if device.type == "cuda":
        torch.set_float32_matmul_precision("high")
    tensors = load(options.weights) if options.first else {}
    names = [f"stage{k}" for k in range(options.stages)] + (["fusion"] if options.fusion else [])
    tensors = {key: value for key, value in tensors.items() if key.split(".")[0] in names[: options.first]}
    for k, name in enumerate(names):
        if k < options.first:
            continue
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
        network = train(prefix, int(name == "fusion"), options.epochs, options.rate, device, options.seed + k)
        tensors.update(tensors_of(network, name))
        save(options.weights, tensors)


if __name__ == "__main__":
    main()
