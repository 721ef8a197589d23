"""Fit the network that finds fixtures of homes on plans: on made plans, and on real ones without fixtures.

    pip install torch onnx
    python training/fit_plan_fixtures.py --minutes 40 -o src/pianta/models/plan_fixtures.onnx [--start FILE.pt]

The real plans are those of schools and offices of every other building (fold 1 of fit_plan_regions.py), on which
nothing counts as a fixture: their furniture, text and hatches look like some. On the other buildings false fixtures can
be counted.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import shapely
import torch
from fit_plan_regions import LAYERS, SCREENSHOT, Lesson, Probabilities, cut_square, fit, fold_of
from fixture_plans import FixturePlan, draw_fixture_plan
from unet import UNet, write_onnx

from pianta.errors import PiantaError
from pianta.io.images import read_picture
from pianta.plan.symbols.fixtures import BATH, BED, CELL, HOB, N_CLASSES, NO_FIXTURE, SINK, TOILET
from pianta.plan.walls.segmentation import input_layers
from pianta_bench.data.building_of import building_of
from pianta_bench.data.folders import find_data
from pianta_bench.plans.plan_sets import find_image, list_plans, read_true_plan

# All of these are chosen by hand. Side of a square in training, cells; about 9 m.
SIDE = 192
BATCH = 6
LEARNING_RATE = 3e-3
PLANS = 1500
# Share of the lessons that are real plans without fixtures.
REAL_SHARE = 0.35
# Weights of the classes in the loss; fixtures cover little area, and beds most of it.
WEIGHTS = {NO_FIXTURE: 0.5, TOILET: 8.0, BATH: 4.0, SINK: 6.0, HOB: 8.0, BED: 1.5}
# Channels at each depth: fixtures are small, so that the deepest levels of the network of walls are not needed.
CHANNELS = (12, 24, 40, 56)


def make_lesson(example: FixturePlan) -> Lesson:
    """The layers of a plan and the fixtures of its cells."""
    cell = CELL / example.plan.grid.resolution
    layers = (input_layers(example.plan.colors, cell_px=cell) * 255).astype(np.uint8)
    kinds = np.full(layers.shape[1:], NO_FIXTURE, np.uint8)
    for number, shape in example.fixtures:
        rows, cols = example.plan.grid.map_to_pixel(*shapely.get_coordinates(shape).T)
        corners = np.rint(np.column_stack([cols, rows]) / cell * 16 - 8).astype(np.int32)
        cv2.fillPoly(kinds, [corners], number, cv2.LINE_8, 4)
    return layers, kinds


def make_lessons(count: int, rng: np.random.Generator) -> list[Lesson]:
    """Lessons of made plans."""
    lessons: list[Lesson] = []
    while len(lessons) < count:
        try:
            lessons.append(make_lesson(draw_fixture_plan(rng)))
        except PiantaError:
            continue
    return lessons


def read_real_lessons(data: Path) -> list[Lesson]:
    """Lessons of real plans of schools and offices, on which nothing is a fixture."""
    files = {name: find_image(data, name) for name in list_plans(data)}
    building = {name: building_of(data, file.relative_to(data).as_posix()) for name, file in files.items()}
    buildings = sorted(set(building.values()))
    lessons = []
    for name, file in files.items():
        plan = read_true_plan(data, name)
        if fold_of(building[name], buildings) == 1 and plan.kind != SCREENSHOT:
            layers = input_layers(read_picture(file), cell_px=CELL / plan.grid.resolution)
            lessons.append(((layers * 255).astype(np.uint8), np.full(layers.shape[1:], NO_FIXTURE, np.uint8)))
    return lessons


def augment_lesson(lesson: Lesson, rng: np.random.Generator) -> Lesson:
    """A square of a lesson, scaled, rotated, mirrored, and with other tones."""
    _, kinds = lesson
    scale = np.exp(rng.normal(0, 0.17))
    angle = rng.integers(4) * 90 + (rng.uniform(-45, 45) if rng.random() < 0.15 else rng.normal())
    row, col = rng.uniform((0, 0), kinds.shape)
    # Around a fixture of a random kind, mostly
    present = np.setdiff1d(kinds, [NO_FIXTURE])
    if len(present) and rng.random() < 0.85:
        cells = np.argwhere(kinds == rng.choice(present))
        row, col = cells[int(rng.integers(len(cells)))]
    return cut_square(lesson, (row, col), side=SIDE, angle=angle, scale=scale, outside=NO_FIXTURE, rng=rng)


def draw_batches(lessons: list[Lesson], real: list[Lesson], rng: np.random.Generator) -> Iterator[tuple[Any, Any]]:
    """Endless batches of lessons; of real plans large ones are more frequent."""
    sizes = np.array([kinds.size for _, kinds in real], float)
    while True:
        chosen = [
            real[int(rng.choice(len(real), p=sizes / sizes.sum()))]
            if real and rng.random() < REAL_SHARE
            else lessons[int(rng.integers(len(lessons)))]
            for _ in range(BATCH)
        ]
        layers, kinds = zip(*(augment_lesson(lesson, rng) for lesson in chosen), strict=True)
        yield torch.from_numpy(np.stack(layers)), torch.from_numpy(np.stack(kinds).astype(np.int64))


def main() -> None:
    """Fit the network and save it as ONNX, with its weights to start from."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--minutes", type=float, default=40)
    parser.add_argument("--start", type=Path, help="weights to start from, .pt")
    parser.add_argument("--plans", type=int, default=PLANS)
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("-o", "--out", type=Path, required=True)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    torch.manual_seed(options.seed)
    lessons = make_lessons(options.plans, np.random.default_rng(options.seed))
    network = UNet(LAYERS, N_CLASSES, CHANNELS)
    if options.start:
        network.load_state_dict(torch.load(options.start, weights_only=True))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        real = read_real_lessons(find_data(options.data))
    batches = draw_batches(lessons, real, np.random.default_rng(options.seed))
    fit(network, batches, WEIGHTS, minutes=options.minutes, rate=LEARNING_RATE)
    torch.save(network.state_dict(), options.out.with_suffix(".pt"))
    names = {"input_name": "sheet", "output_name": "probabilities"}
    write_onnx(Probabilities(network), options.out, inputs=LAYERS, **names)


if __name__ == "__main__":
    main()
