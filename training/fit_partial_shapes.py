"""Fit the network that estimates which cells belong to a partial room.

    pip install torch onnx
    python training/partial_lessons.py LESSONS
    python training/fit_partial_shapes.py LESSONS --minutes 60 -o src/pianta/models/partial_shapes.onnx

Lessons of the buildings of VALIDATION of partial_maps.py are not learned from; the script prints the IoU with their
true rooms of the seen part, of the rectangle around it, and of the cells with a probability above a half.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from math import cos, pi
from pathlib import Path

import cv2
import numpy as np
import torch
from lesson_files import read_lesson
from numpy.typing import NDArray
from partial_maps import VALIDATION
from torch import nn
from torch.nn import functional

from pianta.layout.partial.shape_network import LAYERS, PATCH_SIZE, SYMMETRIES

# All of these are chosen by hand. Channels at a half, a quarter and an eighth of the cells of a patch.
WIDTHS = (24, 48, 64)
BATCH = 16
LEARNING_RATE = 2e-3
LAST_RATE = 1e-5
WEIGHT_DECAY = 1e-4
# Weight of real maps and of truly partial rooms in the choice of lessons, against others.
REAL_WEIGHT = 2.5
PARTIAL_WEIGHT = 1.5
REAL_SOURCES = ("slam", "survey", "furniture")
# Unseen share of a true room from which it is truly partial, as in `pianta bench partial`.
MIN_UNSEEN = 0.1
# Least seen share of the true room, to be learned from, and to be measured.
MIN_SEEN = 0.15
MIN_MEASURED = 1 / 3
# Weight of cells that are known, in the loss by cells; of unknown ones it is 1.
KNOWN_WEIGHT = 0.1
# Weight of the loss by cells against 1 - IoU.
CELL_WEIGHT = 2.0
# Standard deviation of the logarithm by which a patch is stretched along each axis, and of its shift in cells.
STRETCH_SPREAD = 0.15
SHIFT_SPREAD = 3.0
SAVE_SECONDS = 150
ONNX_OPSET = 13


class ShapeNet(nn.Module):
    """A U-Net on blocks of 2 × 2 cells, as Ronneberger et al., U-Net, 2015."""

    def __init__(self) -> None:
        super().__init__()
        first, second, third = WIDTHS
        self.down1 = _block(4 * len(LAYERS), first)
        self.down2 = _block(first, second)
        self.middle = _block(second, third, dilation=2)
        self.up2 = _block(third + second, second)
        self.up1 = _block(second + first, first)
        self.last = nn.Conv2d(first, 4, 1)

    def forward(self, layers: torch.Tensor) -> torch.Tensor:
        """Scores of cells, shape (N, 1, H, W); their sigmoid is the probability."""
        one = self.down1(functional.pixel_unshuffle(layers, 2))
        two = self.down2(functional.max_pool2d(one, 2))
        low = self.middle(functional.max_pool2d(two, 2))
        two = self.up2(torch.cat([functional.interpolate(low, scale_factor=2), two], 1))
        one = self.up1(torch.cat([functional.interpolate(two, scale_factor=2), one], 1))
        return functional.pixel_shuffle(self.last(one), 2)


def _block(inputs: int, outputs: int, *, dilation: int = 1) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, 3, padding=dilation, dilation=dilation),
        nn.ReLU(),
        nn.Conv2d(outputs, outputs, 3, padding=1),
        nn.ReLU(),
    )


@dataclass(frozen=True, eq=False)
class Lessons:
    """Partial rooms of some maps: layers (N, 11, 80, 80), truth (N, 80, 80), shares and weights (N,)."""

    layers: NDArray[np.uint8]
    truth: NDArray[np.uint8]
    seen_share: NDArray[np.float64]
    unseen_share: NDArray[np.float64]
    weights: NDArray[np.float64]


def read_lessons(folder: Path, *, validation: bool) -> Lessons:
    """The lessons of the real maps of VALIDATION, or those of all other buildings."""
    parts = []
    for file in sorted(folder.glob("*.npz")):
        source, building, _ = file.stem.split("__")
        lesson = read_lesson(file)
        if not len(lesson["seen_share"]) or (building in VALIDATION) != validation:
            continue
        if not validation or source in REAL_SOURCES:
            weight = (REAL_WEIGHT if source in REAL_SOURCES else 1.0) * np.ones(len(lesson["seen_share"]))
            weight[lesson["unseen_share"] > MIN_UNSEEN] *= PARTIAL_WEIGHT
            weight[lesson["seen_share"] < (MIN_MEASURED if validation else MIN_SEEN)] = 0
            parts.append(Lessons(**lesson, weights=weight))
    return Lessons(*(np.concatenate([getattr(part, name) for part in parts]) for name in Lessons.__annotations__))


def draw_batch(lessons: Lessons, rng: np.random.Generator) -> tuple[torch.Tensor, torch.Tensor]:
    """Layers and truth of some rooms, mirrored, exchanged and stretched at random, 0 … 1."""
    chosen = rng.choice(len(lessons.weights), BATCH, p=lessons.weights / lessons.weights.sum())
    layers, truth = (
        np.empty((BATCH, *lessons.layers.shape[1:]), np.float32),
        np.empty((BATCH, *lessons.truth.shape[1:])),
    )
    for number, index in enumerate(chosen):
        symmetry = SYMMETRIES[rng.integers(len(SYMMETRIES))]
        planes = np.concatenate([symmetry.apply(lessons.layers[index]), symmetry.move(lessons.truth[index])[None]])
        stretched = _stretch(planes, rng)
        layers[number], truth[number] = stretched[:-1], stretched[-1]
    return torch.from_numpy(layers) / 255, torch.from_numpy(truth).float() / 255


def _stretch(planes: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.float32]:
    """Planes of a patch, shape (N, H, W), stretched and moved at random; what was not seen repeats the border."""
    scales, middle = np.exp(rng.normal(0, STRETCH_SPREAD, 2)), (PATCH_SIZE - 1) / 2
    matrix = np.column_stack([np.diag(scales), middle * (1 - scales) + rng.normal(0, SHIFT_SPREAD, 2)])
    size = (PATCH_SIZE, PATCH_SIZE)
    moved = [cv2.warpAffine(plane, matrix, size, borderMode=cv2.BORDER_REPLICATE) for plane in planes]
    return np.array(moved, np.float32)


def compute_loss(scores: torch.Tensor, layers: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """Cross entropy of cells, mostly of unknown ones, and 1 - IoU of the room with all that was seen of it."""
    known_cells = torch.maximum(layers[:, LAYERS.index("seen part")], layers[:, LAYERS.index("whole rooms")])
    weights = 1 - (1 - KNOWN_WEIGHT) * known_cells
    entropy = (functional.binary_cross_entropy_with_logits(scores, truth, reduction="none") * weights).mean()
    shape = torch.maximum(torch.sigmoid(scores), layers[:, LAYERS.index("seen part")])
    shared, union = torch.minimum(shape, truth).sum((1, 2)), torch.maximum(shape, truth).sum((1, 2))
    return CELL_WEIGHT * entropy + (1 - shared / (union + 1)).mean()


def measure(network: ShapeNet, lessons: Lessons) -> str:
    """Mean IoU with truly partial rooms: seen part, rectangle around it without other rooms, and network; %."""
    chosen = np.flatnonzero((lessons.unseen_share > MIN_UNSEEN) & (lessons.weights > 0))
    ious = []
    for i in chosen:
        layers = torch.from_numpy(lessons.layers[i : i + 1]).float() / 255
        with torch.no_grad():
            likely = torch.sigmoid(network(layers))[0, 0].numpy() > 0.5
        observed, others = layers[0, 0].numpy() > 0.5, layers[0, 1:3].numpy().max(axis=0) > 0.5
        rows, cols = np.nonzero(observed)
        rectangle = np.zeros_like(observed)
        rectangle[rows.min() : rows.max() + 1, cols.min() : cols.max() + 1] = True
        truth = lessons.truth[i] > 127
        shapes = (observed, rectangle & ~others | observed, likely & ~others | observed)
        ious.append([(shape & truth).sum() / (shape | truth).sum() for shape in shapes])
    means = 100 * np.mean(ious, axis=0)
    return f"{len(chosen)} rooms: seen {means[0]:.1f}, rectangle {means[1]:.1f}, network {means[2]:.1f}"


def main() -> None:
    """Fit the network for some minutes and write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lessons", type=Path)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--start", type=Path, help="weights, .pt, to go on from")
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    torch.manual_seed(0)
    rng = np.random.default_rng(0)
    network = ShapeNet()
    if options.start:
        network.load_state_dict(torch.load(options.start))
    optimiser = torch.optim.AdamW(network.parameters(), LEARNING_RATE, weight_decay=WEIGHT_DECAY)
    lessons, test = (read_lessons(options.lessons, validation=validation) for validation in (False, True))
    start = saved = time.monotonic()
    share = 0.0
    while share < 1:
        share = min(1.0, (time.monotonic() - start) / 60 / options.minutes)
        optimiser.param_groups[0]["lr"] = LAST_RATE + LEARNING_RATE * (1 + cos(pi * share)) / 2
        layers, truth = draw_batch(lessons, rng)
        loss = compute_loss(network(layers)[:, 0], layers, truth)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        if share == 1 or time.monotonic() - saved > SAVE_SECONDS:
            saved = time.monotonic()
            torch.save(network.state_dict(), options.output.with_suffix(".pt"))
            sys.stdout.write(f"{100 * share:.0f} %: {measure(network, test)}\n")
            sys.stdout.flush()
            # partial_lessons.py may have written more.
            lessons = read_lessons(options.lessons, validation=False)
    patch = torch.zeros(1, len(LAYERS), PATCH_SIZE, PATCH_SIZE)
    names = {"input_names": ["layers"], "output_names": ["scores"]}
    torch.onnx.export(network.eval(), (patch,), str(options.output), opset_version=ONNX_OPSET, dynamo=False, **names)


if __name__ == "__main__":
    main()
