"""Fit the network that tells walls, doors, furniture and rooms of robots' maps apart, on simulated maps.

    pip install torch onnx
    python training/map_lessons.py LESSONS --minutes 30
    python training/fit_map_regions.py LESSONS --minutes 60 -o src/pianta/models/map_regions.onnx [--start WEIGHTS.pt]

The network learns two things for each cell: its class (outside, floor, wall, door, furniture), and for each of OFFSETS
whether the cell at that offset is in the same room (affinities, as in Turaga et al., Convolutional networks can learn to
generate affinity graphs for image segmentation, 2010). Real maps take no part in it.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.nn import functional

from pianta.layout.structure.evidence import DOOR, FLOOR, FURNITURE, OFFSETS, OUTSIDE, WALL

# Channels of the U-Net at each depth.
CHANNELS = (16, 32, 48, 64, 96, 128)
# All of these are chosen by hand. Side of a square in training, cells of the network.
SIDE = 256
BATCH = 8
LEARNING_RATE = 3e-3
# Weights of the classes in the loss.
WEIGHTS = {OUTSIDE: 0.5, FLOOR: 1.0, WALL: 1.5, DOOR: 5.0, FURNITURE: 1.0}
# Weight of the affinities against the classes.
AFFINITY_WEIGHT = 2.0
# Weight of pairs in two rooms against pairs in one.
BORDER_WEIGHT = 2.0


class RegionNet(nn.Module):
    """A U-Net (Ronneberger et al., 2015) from a map to class scores and affinity scores."""

    def __init__(self) -> None:
        super().__init__()
        self.down, self.up = nn.ModuleList(), nn.ModuleList()
        before = 2
        for channels in CHANNELS:
            self.down.append(_make_block(before, channels))
            before = channels
        for i in range(len(CHANNELS) - 1):
            self.up.append(_make_block(CHANNELS[i] + CHANNELS[i + 1], CHANNELS[i]))
        self.last = nn.Conv2d(CHANNELS[0], len(WEIGHTS) + len(OFFSETS), 1)

    def forward(self, layers: torch.Tensor) -> torch.Tensor:
        """Scores, shape (N, 5 + len(OFFSETS), h, w), of layers, shape (N, 2, h, w)."""
        levels = []
        for i, block in enumerate(self.down):
            layers = block(functional.max_pool2d(layers, 2) if i else layers)
            levels.append(layers)
        for i in reversed(range(len(CHANNELS) - 1)):
            layers = functional.interpolate(layers, scale_factor=2.0, mode="nearest")
            layers = self.up[i](torch.cat([levels[i], layers], 1))
        return self.last(layers)


class Probabilities(nn.Module):
    """The network with probabilities instead of scores, as it is shipped."""

    def __init__(self, net: RegionNet) -> None:
        super().__init__()
        self.net = net

    def forward(self, layers: torch.Tensor) -> torch.Tensor:
        """Class probabilities and affinities, shape (N, 5 + len(OFFSETS), h, w)."""
        scores = self.net(layers)
        classes = len(WEIGHTS)
        return torch.cat([functional.softmax(scores[:, :classes], 1), torch.sigmoid(scores[:, classes:])], 1)


def _make_block(before: int, channels: int) -> nn.Sequential:
    layers: list[nn.Module] = []
    for inputs in (before, channels):
        layers += [nn.Conv2d(inputs, channels, 3, padding=1, bias=False), nn.BatchNorm2d(channels), nn.ReLU()]
    return nn.Sequential(*layers)


def read_lesson(path: Path) -> dict[str, NDArray]:
    """The images of a lesson."""
    with np.load(path) as file:
        return dict(file)


def draw_square(lesson: dict[str, NDArray], rng: np.random.Generator) -> list[NDArray]:
    """A square of a lesson, mirrored and turned at random: map, shape (2, S, S), classes, rooms, and what counts."""
    height, width = lesson["free"].shape
    top, left = (int(rng.integers(-SIDE // 4, max(1, size - SIDE * 3 // 4))) for size in (height, width))
    images = []
    for name, outside in (("free", 0), ("occupied", 0), ("classes", OUTSIDE), ("rooms", 0), ("counts", 1)):
        image = np.full((SIDE, SIDE), outside, lesson[name].dtype)
        rows, cols = (slice(max(first, 0), min(first + SIDE, size)) for first, size in ((top, height), (left, width)))
        part = lesson[name][rows, cols]
        image[rows.start - top : rows.start - top + part.shape[0], cols.start - left : cols.start - left + part.shape[1]] = part
        images.append(image)
    turns, mirror = int(rng.integers(4)), rng.random() < 0.5
    images = [np.rot90(image, turns) for image in images]
    if mirror:
        images = [image[:, ::-1] for image in images]
    free, occupied, classes, rooms, counts = images
    return [np.stack([free, occupied]).astype(np.float32) / 4, classes.astype(np.int64), rooms.astype(np.int32), counts.astype(bool)]


def draw_batches(folder: Path, rng: np.random.Generator) -> Iterator[list[torch.Tensor]]:
    """Batches without end; new lessons of the folder are found as they come."""
    cache: dict[Path, dict[str, NDArray]] = {}
    paths: list[Path] = []
    for step in range(10**9):
        if step % 200 == 0:
            paths = sorted(p for p in folder.glob("*.npz") if not p.name.endswith(".part.npz"))
        squares = []
        while len(squares) < BATCH:
            path = paths[int(rng.integers(len(paths)))]
            if path not in cache:
                cache[path] = read_lesson(path)
            square = draw_square(cache[path], rng)
            if square[0][0].mean() > 0.05:
                squares.append(square)
        yield [torch.from_numpy(np.stack([square[i] for square in squares])) for i in range(4)]


def measure_loss(scores: torch.Tensor, classes: torch.Tensor, rooms: torch.Tensor, counts: torch.Tensor) -> torch.Tensor:
    """Cross entropy of the classes and of the affinities."""
    weights = torch.tensor([WEIGHTS[c] for c in sorted(WEIGHTS)])
    by_class = functional.cross_entropy(scores[:, : len(WEIGHTS)], classes, weights, reduction="none")
    loss = by_class[counts].mean()
    for i, (down, right) in enumerate(OFFSETS):
        here, there = _shift(rooms, down, right)
        both = (here > 0) & (there > 0) & _shift(counts, down, right)[0] & _shift(counts, down, right)[1]
        score = _shift(scores[:, len(WEIGHTS) + i], down, right)[0]
        same = (here == there).float()
        by_pair = functional.binary_cross_entropy_with_logits(score, same, reduction="none") * (
            1 + (BORDER_WEIGHT - 1) * (1 - same)
        )
        loss = loss + AFFINITY_WEIGHT / len(OFFSETS) * by_pair[both].mean()
    return loss


def _shift(image: torch.Tensor, down: int, right: int) -> tuple[torch.Tensor, torch.Tensor]:
    """The cells of an image that have one at an offset down and right, both at least 0, and those cells."""
    height, width = image.shape[-2:]
    return image[..., : height - down, : width - right], image[..., down:, right:]


def main() -> None:
    """Fit for some minutes; write the weights and the network."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lessons", type=Path)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--rate", type=float, default=LEARNING_RATE)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--start", type=Path, help="weights to go on from")
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    torch.manual_seed(options.seed)
    net = RegionNet().to(memory_format=torch.channels_last)
    if options.start:
        net.load_state_dict(torch.load(options.start, weights_only=True))
    optimizer = torch.optim.AdamW(net.parameters(), options.rate, weight_decay=1e-4)
    start, seconds, mean = time.monotonic(), 60 * options.minutes, 0.0
    for step, (layers, classes, rooms, counts) in enumerate(draw_batches(options.lessons, np.random.default_rng(options.seed))):
        done = (time.monotonic() - start) / seconds
        if done >= 1:
            break
        # Warm up, then a cosine to zero
        rate = options.rate * min(1.0, (step + 1) / 100) * (0.5 + 0.5 * np.cos(np.pi * done))
        for group in optimizer.param_groups:
            group["lr"] = float(rate)
        with torch.autocast("cpu", torch.bfloat16):
            scores = net(layers.to(memory_format=torch.channels_last))
        loss = measure_loss(scores.float(), classes, rooms, counts)
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        mean = 0.98 * mean + 0.02 * loss.item() if step else loss.item()
        if step % 50 == 0:
            sys.stdout.write(f"{step} {time.monotonic() - start:.0f} s loss {mean:.3f}\n")
            sys.stdout.flush()
        if step % 100 == 99:
            torch.save(net.state_dict(), options.output.with_suffix(".pt"))
    torch.save(net.state_dict(), options.output.with_suffix(".pt"))
    write_network(net, options.output)


def write_network(net: RegionNet, path: Path) -> None:
    """Write the network as ONNX, for maps of any size that 32 divides."""
    net.eval()
    torch.onnx.export(
        Probabilities(net).float(),
        (torch.zeros(1, 2, 64, 96),),
        str(path),
        input_names=["map"],
        output_names=["evidence"],
        opset_version=13,
        dynamo=False,
        dynamic_axes={"map": {2: "height", 3: "width"}, "evidence": {2: "height", 3: "width"}},
    )


if __name__ == "__main__":
    main()
