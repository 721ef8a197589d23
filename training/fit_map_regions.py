"""Fit the network that segments robots' maps into walls, doors, furniture and rooms, on simulated maps.

    pip install torch onnx
    python training/map_lessons.py LESSONS --minutes 30
    python training/fit_map_regions.py LESSONS --minutes 60 -o src/pianta/models/map_regions.onnx [--start WEIGHTS.pt]
    python training/annotated_lessons.py ANNOTATED
    python training/fit_map_regions.py LESSONS --annotated ANNOTATED --start WEIGHTS.pt --rate 3e-4 --minutes 5 -o …

The network learns two things for each cell: its class (outside, floor, wall, door, furniture), and for each of OFFSETS
whether the cell at that offset is in the same room: affinities, as in Turaga et al., Convolutional networks can learn
to generate affinity graphs for image segmentation, 2010. In a last, short fit real maps with annotated rooms can take
part; --leave-out BUILDING keeps whole buildings for the test.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch
from lesson_files import FINE_CELLS, UNKNOWN_CLASS, Lesson, read_lesson
from numpy.typing import NDArray
from torch import nn
from torch.nn import functional
from unet import UNet, has_bfloat16, write_onnx

from pianta.layout.structure.evidence import DOOR, FLOOR, FURNITURE, OFFSETS, OUTSIDE, WALL

# Layers of maps, classes, rooms, and which cells count; the shapes are (N, 2, SIDE, SIDE) and (N, SIDE, SIDE).
Batch = tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]

# Layers of a map: its free and its occupied share.
LAYERS = 2
# All of these are chosen by hand. Side of a square in training, cells of the network.
SIDE = 256
BATCH = 8
LEARNING_RATE = 3e-3
WEIGHT_DECAY = 1e-4
# Steps in which the rate rises from zero.
WARM_UP = 100
# Longest gradient; longer ones are shortened.
MAX_GRADIENT = 1.0
# Squares with a smaller share of free cells are left out.
MIN_FREE_SHARE = 0.05
# Weights of the classes in the loss.
WEIGHTS = {OUTSIDE: 0.5, FLOOR: 1.0, WALL: 1.5, DOOR: 5.0, FURNITURE: 1.0}
# Weight of the affinities against the classes.
AFFINITY_WEIGHT = 2.0
# Weight of pairs in two rooms against pairs in one.
BORDER_WEIGHT = 2.0
# Value of each image of a lesson outside of its map.
OUTER_VALUES = {"free": 0, "occupied": 0, "classes": OUTSIDE, "rooms": 0, "counts": 1}
# Share of the squares of a batch that are of annotated maps, if there are any.
ANNOTATED_SHARE = 0.5
# Steps after which new lessons are read, the loss is printed, and the weights are saved.
READ_STEPS = 200
PRINT_STEPS = 50
SAVE_STEPS = 100


class Probabilities(nn.Module):
    """The network with probabilities instead of scores, as it is shipped."""

    def __init__(self, network: UNet) -> None:
        super().__init__()
        self.network = network

    def forward(self, layers: torch.Tensor) -> torch.Tensor:
        """Class probabilities and affinities, shape (N, 5 + len(OFFSETS), h, w)."""
        scores = self.network(layers)
        classes, affinities = scores[:, : len(WEIGHTS)], scores[:, len(WEIGHTS) :]
        return torch.cat([functional.softmax(classes, 1), torch.sigmoid(affinities)], 1)


def draw_square(lesson: Lesson, rng: np.random.Generator) -> tuple[NDArray, ...]:
    """A square of a lesson, turned and mirrored at random: map, shape (2, S, S), classes, rooms, and what counts."""
    top, left = (int(rng.integers(-SIDE // 4, max(1, side - SIDE * 3 // 4))) for side in lesson["free"].shape)
    turns, is_mirrored = int(rng.integers(4)), rng.random() < 0.5
    images = []
    for name, outer_value in OUTER_VALUES.items():
        square = np.full((SIDE, SIDE), outer_value, lesson[name].dtype)
        part = lesson[name][max(top, 0) : top + SIDE, max(left, 0) : left + SIDE]
        down, right = max(-top, 0), max(-left, 0)
        square[down : down + part.shape[0], right : right + part.shape[1]] = part
        square = np.rot90(square, turns)
        images.append(square[:, ::-1] if is_mirrored else square)
    free, occupied, classes, rooms, counts = images
    layers = np.stack([free, occupied]).astype(np.float32) / FINE_CELLS
    return layers, classes.astype(np.int64), rooms.astype(np.int32), counts.astype(bool)


def draw_batches(folder: Path, annotated: list[Path], rng: np.random.Generator) -> Iterator[Batch]:
    """Batches without end; lessons that are added to the folder later are read too.

    annotated: lessons of real maps, of which ANNOTATED_SHARE of the squares are, if there are any.
    """
    lessons: dict[Path, Lesson] = {}
    while True:
        simulated = sorted(folder.glob("*.npz"))
        for _ in range(READ_STEPS):
            squares: list[tuple[NDArray, ...]] = []
            while len(squares) < BATCH:
                paths = annotated if annotated and len(squares) < ANNOTATED_SHARE * BATCH else simulated
                path = paths[int(rng.integers(len(paths)))]
                if path not in lessons:
                    lessons[path] = read_lesson(path)
                square = draw_square(lessons[path], rng)
                if square[0][0].mean() > MIN_FREE_SHARE:
                    squares.append(square)
            layers, classes, rooms, counts = (
                torch.from_numpy(np.stack(images)) for images in zip(*squares, strict=True)
            )
            yield layers, classes, rooms, counts


def measure_loss(
    scores: torch.Tensor, classes: torch.Tensor, rooms: torch.Tensor, counts: torch.Tensor
) -> torch.Tensor:
    """Cross entropy of the classes and of the affinities."""
    weights = torch.tensor([WEIGHTS[value] for value in sorted(WEIGHTS)])
    by_cell = functional.cross_entropy(
        scores[:, : len(WEIGHTS)], classes, weights, reduction="none", ignore_index=UNKNOWN_CLASS
    )
    loss = by_cell[counts & (classes != UNKNOWN_CLASS)].mean()
    for i, offset in enumerate(OFFSETS, start=len(WEIGHTS)):
        here, there = _pair_cells(rooms, offset)
        both = (here > 0) & (there > 0) & torch.logical_and(*_pair_cells(counts, offset))
        same = (here == there).float()
        pair_weights = 1 + (BORDER_WEIGHT - 1) * (1 - same)
        score, _ = _pair_cells(scores[:, i], offset)
        by_pair = functional.binary_cross_entropy_with_logits(score, same, pair_weights, reduction="none")
        loss = loss + AFFINITY_WEIGHT / len(OFFSETS) * by_pair[both].mean()
    return loss


def _pair_cells(image: torch.Tensor, offset: tuple[int, int]) -> tuple[torch.Tensor, torch.Tensor]:
    """The cells of an image that have another one at an offset, both parts of which are 0 or more, and the others."""
    down, right = offset
    height, width = image.shape[-2:]
    return image[..., : height - down, : width - right], image[..., down:, right:]


def fit(network: UNet, batches: Iterator[Batch], *, minutes: float, rate: float, weights_file: Path) -> None:
    """Fit a network by AdamW, with a rate that decreases as a cosine; prints the loss, and saves the weights at times.

    In bfloat16 if the processor supports it.
    """
    network.to(memory_format=torch.channels_last)
    optimizer = torch.optim.AdamW(network.parameters(), rate, weight_decay=WEIGHT_DECAY)
    start, mean_loss = time.monotonic(), 0.0
    for step, (layers, classes, rooms, counts) in enumerate(batches, start=1):
        seconds = time.monotonic() - start
        done = seconds / 60 / minutes
        if done >= 1:
            return
        for group in optimizer.param_groups:
            group["lr"] = rate * min(1.0, step / WARM_UP) * (1 + np.cos(np.pi * done)) / 2
        with torch.autocast("cpu", torch.bfloat16, enabled=has_bfloat16()):
            scores = network(layers.to(memory_format=torch.channels_last))
        loss = measure_loss(scores.float(), classes, rooms, counts)
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), MAX_GRADIENT)
        optimizer.step()
        mean_loss += (loss.item() - mean_loss) / min(step, PRINT_STEPS)
        if step % PRINT_STEPS == 0:
            sys.stdout.write(f"step {step}, {seconds:.0f} s, loss {mean_loss:.3f}\n")
            sys.stdout.flush()
        if step % SAVE_STEPS == 0:
            torch.save(network.state_dict(), weights_file)


def main() -> None:
    """Fit for some minutes; write the network as ONNX, and its weights to start from."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lessons", type=Path)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--rate", type=float, default=LEARNING_RATE)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--start", type=Path, help="weights to start from")
    parser.add_argument("--annotated", type=Path, help="folder of lessons of annotated_lessons.py")
    parser.add_argument("--leave-out", nargs="*", default=[], help="buildings of these that take no part")
    parser.add_argument("-o", "--out", type=Path, required=True)
    options = parser.parse_args()
    if not any(options.lessons.glob("*.npz")):
        parser.error(f"{options.lessons} has no lessons, make some with map_lessons.py")
    torch.set_num_threads(options.threads)
    torch.manual_seed(options.seed)
    network = UNet(LAYERS, len(WEIGHTS) + len(OFFSETS))
    if options.start:
        network.load_state_dict(torch.load(options.start, weights_only=True))
    annotated = sorted(options.annotated.glob("*.npz")) if options.annotated else []
    annotated = [path for path in annotated if path.stem.split("__")[0] not in options.leave_out]
    batches = draw_batches(options.lessons, annotated, np.random.default_rng(options.seed))
    weights_file = options.out.with_suffix(".pt")
    fit(network, batches, minutes=options.minutes, rate=options.rate, weights_file=weights_file)
    torch.save(network.state_dict(), weights_file)
    write_onnx(Probabilities(network), options.out, inputs=LAYERS, input_name="map", output_name="evidence")


if __name__ == "__main__":
    main()
