"""Fit the networks that segment plans into walls, doors, inside and outside, on real and synthetic plans.

    pip install torch onnx
    python training/fit_plan_regions.py --fold 0 --minutes 60 -o plan_regions_0.onnx [--data DIR]
        [--start plan_regions_0.onnx] [--rate 1e-3] [--share 0.6]

The plans of every other building are left out, by --fold 0 or 1, so that each network can be evaluated on plans that
it was not trained on; src/pianta/models/plan_regions.json lists its training plans. Besides real plans each network is
trained on synthetic ones: floors of buildings drawn anew by pianta.worlds in other styles, and homes of home_plans.py.
The networks that come with pianta were fitted in four runs without homes, and in a fifth with them, of 38 minutes with
--start, --rate 1e-3 and --share 0.6.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from hashlib import sha1
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import shapely
import torch
from home_plans import HomePlan, draw_home_plan
from numpy.typing import NDArray
from torch import nn
from torch.nn import functional
from unet import UNet, average_onnx, has_bfloat16, read_onnx, write_onnx

from pianta.errors import PiantaError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.images import read_picture
from pianta.plan.walls.segmentation import DOOR, DOOR_CELLS, INSIDE, OUTSIDE, WALL, input_layers
from pianta.worlds.plans.drawing import draw_plan
from pianta.worlds.plans.look import PlanLook
from pianta_bench.data.building_of import building_of
from pianta_bench.data.folders import find_data
from pianta_bench.plans.plan_sets import find_image, list_plans, read_true_plan

Layers, ClassMap = NDArray[np.uint8], NDArray[np.uint8]
Lesson = tuple[Layers, ClassMap]

# Layers of a sheet, see pianta.plan.walls.segmentation.input_layers.
LAYERS = 4
# All of these are chosen by hand. Side of a square in training, cells of the network.
SIDE = 288
BATCH = 5
LEARNING_RATE = 3e-3
# Weights of the classes in the loss; walls and doors cover little area.
WEIGHTS = {INSIDE: 1.0, WALL: 2.5, DOOR: 5.0, OUTSIDE: 1.0}
LABEL_SMOOTHING = 0.03
# Widths of walls and doors in the true regions, cells.
WALL_CELLS = 3
DOOR_LINE_CELLS = 4
# Synthetic plans of each floor, and the probability of one of them in a batch, per that of a real plan of its size.
DRAWINGS = 3
SYNTHETIC_WEIGHT = 0.25
# Lessons of homes, each of several plans, and the share of the batches that they are.
HOME_LESSONS = 300
HOME_SHARE = 0.4
# Cells across a door of 0.9 m on homes: their walls and rooms are half as large as those of schools.
HOME_DOOR_CELLS = 2 * DOOR_CELLS
# Side of such a lesson, and space around each of its plans, cells.
HOMES_SIDE = 400
HOME_SPACE = 6
SCREENSHOT = "screenshot"


class Probabilities(nn.Module):
    """The network with probabilities for scores, as it is saved."""

    def __init__(self, network: UNet) -> None:
        super().__init__()
        self.network = network

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Probabilities of the classes, shape (N, classes, H, W)."""
        return torch.softmax(self.network(x), 1)


def fold_of(building: str, buildings: list[str]) -> int:
    """0 or 1, by turns in the order of the SHA-1 of the buildings' names."""
    ordered = sorted(buildings, key=lambda name: sha1(name.encode(), usedforsecurity=False).hexdigest())
    return ordered.index(building) % 2


def make_lesson(
    colors: NDArray[np.uint8], floors: list[Floor], grid: GridMap, door_cells: float = DOOR_CELLS
) -> Lesson:
    """The layers of a sheet and its true regions, both in cells of the network, door_cells across a door.

    Walls are the outlines of the rooms, doors their lines, with or without ink there.
    """
    cell = 0.9 / grid.resolution / door_cells
    layers = (input_layers(colors, cell_px=cell) * 255).astype(np.uint8)
    regions = np.full(layers.shape[1:], OUTSIDE, np.uint8)

    def points(shape: shapely.Geometry) -> NDArray[np.int32]:
        rows, cols = grid.map_to_pixel(*shapely.get_coordinates(shape).T)
        return np.rint(np.column_stack([cols, rows]) / cell * 16 - 8).astype(np.int32)

    for room in (room for floor in floors for room in floor.rooms):
        cv2.fillPoly(regions, [points(room.polygon.exterior)], INSIDE, cv2.LINE_8, 4)
    for room in (room for floor in floors for room in floor.rooms):
        rings = [points(ring) for ring in (room.polygon.exterior, *room.polygon.interiors)]
        cv2.polylines(regions, rings, True, WALL, WALL_CELLS, cv2.LINE_8, 4)  # noqa: FBT003
    for door in (door for floor in floors for door in floor.doors):
        cv2.polylines(regions, [points(door.line)], False, DOOR, DOOR_LINE_CELLS, cv2.LINE_8, 4)  # noqa: FBT003
    return layers, regions


def read_lessons(data: Path, fold: int) -> tuple[list[Lesson], list[Lesson], list[str]]:
    """Lessons of real and of synthetic plans, without the buildings of a fold, and the buildings that they show."""
    drawings = sorted((data / "buildings").glob("[so]*/*.xml"))
    files = [*(find_image(data, name) for name in list_plans(data)), *drawings]
    building = {file: building_of(data, file.relative_to(data).as_posix()) for file in files}
    buildings = sorted(set(building.values()))
    chosen = [name for name in buildings if fold_of(name, buildings) != fold]
    real, used_buildings = [], set[str]()
    images: dict[bytes, list[Any]] = {}
    for name in list_plans(data):
        plan = read_true_plan(data, name)
        if building[find_image(data, name)] in chosen and plan.kind != SCREENSHOT:
            # Two floors of a building can be on the same image; the truth of each has one of them.
            images.setdefault(find_image(data, name).read_bytes(), []).append((name, plan))
    for plans in images.values():
        name, plan = plans[0]
        real.append(make_lesson(read_picture(find_image(data, name)), [other.truth for _, other in plans], plan.grid))
        used_buildings.add(building[find_image(data, name)])
    rng = np.random.default_rng(5)
    synthetic = []
    for file in drawings:
        if building[file] in chosen:
            used_buildings.add(building[file])
            synthetic += [lesson for _ in range(DRAWINGS) if (lesson := draw_lesson(read_building_xml(file), rng))]
    return real, synthetic, sorted(used_buildings)


def draw_lesson(floor: Floor, rng: np.random.Generator) -> Lesson | None:
    """A lesson from a floor drawn in a random style; None if it cannot be drawn."""
    half = rng.uniform(0.06, 0.16)
    rooms = []
    for room in floor.rooms:
        parts = shapely.get_parts(room.polygon.buffer(-half, join_style="mitre"))
        rooms.append(replace(room, polygon=max(parts, key=shapely.area, default=room.polygon)))
    look = PlanLook(
        style=str(rng.choice(["thick", "double", "single"], p=[0.4, 0.35, 0.25])),  # type: ignore[arg-type]
        px_per_metre=float(rng.uniform(11, 26)),
        doors=str(rng.choice(["arc", "leaf", "gap", "double"], p=[0.45, 0.15, 0.25, 0.15])),  # type: ignore[arg-type]
        windows=int(rng.choice([0, 2, 3])),
        furniture=float(rng.choice([0, 0.4, 1])),
        legend=bool(rng.random() < 0.3),
        colored=bool(rng.random() < 0.35),
        evacuation=bool(rng.random() < 0.3),
        noise=float(rng.choice([0, 0.2, 0.6])),
        rotation=float(rng.choice([0, 0, rng.uniform(-40, 40)])),
        ink=int(rng.choice([0, 60, 150])),
        dimensions=bool(rng.random() < 0.3),
        scale_bar=bool(rng.random() < 0.3),
        title="Ground floor" if rng.random() < 0.4 else "",
        lettering=float(rng.uniform(0.3, 0.7)),
    )
    names = {room.id: (room.label or "Room").title() for room in floor.rooms} if rng.random() < 0.8 else {}
    try:
        plan = draw_plan(replace(floor, rooms=tuple(rooms)), look, seed=int(rng.integers(10**6)), texts=names)
    except PiantaError:
        return None
    return make_lesson(plan.colors, [floor], plan.grid)


def make_home_lessons(count: int, rng: np.random.Generator) -> list[Lesson]:
    """Lessons of homes, as many plans on each as there is space for."""
    lessons: list[Lesson] = []
    parts: list[Lesson] = []
    while len(lessons) < count:
        try:
            plan = draw_home_plan(rng)
        except PiantaError:
            continue
        part = make_home_lesson(plan)
        if not place_parts([part]):
            lessons.append(part)
            continue
        if len(place_parts([*parts, part])) <= len(parts):
            lessons.append(join_parts(parts))
            parts = []
        parts.append(part)
    return lessons


def make_home_lesson(plan: HomePlan) -> Lesson:
    """The lesson of a home, without walls where rooms are open to each other."""
    layers, regions = make_lesson(plan.colors, [plan.truth], plan.grid, HOME_DOOR_CELLS)
    cell = 0.9 / plan.grid.resolution / HOME_DOOR_CELLS
    for line in plan.open_lines:
        rows, cols = plan.grid.map_to_pixel(*shapely.get_coordinates(line).T)
        ends = np.rint(np.column_stack([cols, rows]) / cell * 16 - 8).astype(np.int32)
        cv2.polylines(regions, [ends], False, INSIDE, WALL_CELLS + 1, cv2.LINE_8, 4)  # noqa: FBT003
    return layers, regions


def place_parts(parts: list[Lesson]) -> list[tuple[int, int]]:
    """Row and col of each part on a lesson, in rows from left to right; less of them if there is no space for all."""
    corners: list[tuple[int, int]] = []
    row = col = below = 0
    for _, regions in parts:
        height, width = (side + HOME_SPACE for side in regions.shape)
        if col + width > HOMES_SIDE:
            row, col = below, 0
        if row + height > HOMES_SIDE or width > HOMES_SIDE:
            break
        corners.append((row, col))
        col, below = col + width, max(below, row + height)
    return corners


def join_parts(parts: list[Lesson]) -> Lesson:
    """One lesson of several, on white paper."""
    layers = np.zeros((LAYERS, HOMES_SIDE, HOMES_SIDE), np.uint8)
    layers[:2] = 255
    joined = np.full((HOMES_SIDE, HOMES_SIDE), OUTSIDE, np.uint8)
    for (part, regions), (row, col) in zip(parts, place_parts(parts), strict=True):
        window = slice(row, row + regions.shape[0]), slice(col, col + regions.shape[1])
        layers[:, *window] = part
        joined[window] = regions
    return layers, joined


def augment_lesson(lesson: Lesson, rng: np.random.Generator) -> Lesson:
    """A square of a lesson, scaled, rotated, mirrored, and with other tones."""
    _, regions = lesson
    scale = np.exp(rng.uniform(np.log(0.6), np.log(1.65)))
    angle = rng.integers(4) * 90 + (rng.uniform(-45, 45) if rng.random() < 0.25 else rng.normal())
    centers = rng.uniform((0, 0), regions.shape, (4, 2))
    row, col = next((center for center in centers if regions[tuple(center.astype(int))] != OUTSIDE), centers[-1])
    return cut_square(lesson, (row, col), side=SIDE, angle=angle, scale=scale, outside=OUTSIDE, rng=rng)


def cut_square(
    lesson: Lesson,
    middle: tuple[float, float],
    *,
    side: int,
    angle: float,
    scale: float,
    outside: int,
    rng: np.random.Generator,
) -> Lesson:
    """A square around a place near the middle, row and col, turned, scaled, perhaps mirrored, and with other tones.

    side: cells. angle: degrees. outside: the class beyond the lesson.
    """
    layers, classes = lesson
    row, col = middle
    matrix = cv2.getRotationMatrix2D((float(col), float(row)), float(angle), float(scale))
    matrix[:, 2] += np.array([side / 2 - col, side / 2 - row]) + rng.uniform(-60, 60, 2)
    if rng.random() < 0.5:
        matrix = np.array([[-1.0, 0, side - 1], [0, 1, 0]]) @ np.vstack([matrix, [0, 0, 1]])
    paper = [int(np.percentile(layer, 90)) for layer in layers[:2]] + [0, 0]
    moved = cv2.warpAffine(layers.transpose(1, 2, 0), matrix, (side, side), flags=cv2.INTER_LINEAR, borderValue=paper)
    moved_classes = cv2.warpAffine(classes, matrix, (side, side), flags=cv2.INTER_NEAREST, borderValue=outside)
    return change_tones(moved.transpose(2, 0, 1).astype(np.float32) / 255, rng), moved_classes


def change_tones(layers: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """Layers without colour, paler, darker, grainy, soft, or with thinner or thicker lines."""
    if rng.random() < 0.5:
        layers[2] = 0
    if rng.random() < 0.3:
        layers[0] = layers[:2].mean(axis=0)
    layers[:2] = np.clip(layers[:2], 0, 1) ** np.exp(rng.normal(0, 0.35))
    darkest = rng.uniform(0.3, 0.75) if rng.random() < 0.25 else rng.choice([0, rng.uniform(0, 0.35)])
    lightest = rng.uniform(0.75, 1)
    layers[:2] = darkest * min(1, lightest) + (lightest - darkest * lightest) * layers[:2]
    if rng.random() < 0.3:
        layers += rng.normal(0, rng.uniform(0.01, 0.05), layers.shape)
    if rng.random() < 0.25:
        layers[:2] = [cv2.GaussianBlur(layer, (0, 0), rng.uniform(0.4, 1)) for layer in layers[:2]]
    if rng.random() < 0.2:
        layers[:2] = [cv2.erode(layer, np.ones((2, 2))) for layer in layers[:2]]
    if rng.random() < 0.4:
        layers[3] = np.clip(layers[3] * rng.uniform(0.5, 1.3), 0, 1)
    if rng.random() < 0.15:
        layers[3] = cv2.erode(layers[3], np.ones((2, 2)))
    if rng.random() < 0.1:
        layers[rng.integers(4)] = rng.random()
    return layers


@dataclass(frozen=True, eq=False)
class Lessons:
    """Lessons of real plans, of buildings that were drawn anew, and of made homes."""

    real: list[Lesson]
    synthetic: list[Lesson]
    homes: list[Lesson]


def draw_batches(chosen: Lessons, rng: np.random.Generator) -> Iterator[tuple[Any, Any]]:
    """Endless batches of lessons; large sheets are more frequent."""
    lessons = [*chosen.real, *chosen.synthetic, *chosen.homes]
    weights = np.sqrt([regions.size for _, regions in lessons])
    weights[len(chosen.real) :] *= SYNTHETIC_WEIGHT
    buildings = len(chosen.real) + len(chosen.synthetic)
    weights[:buildings] *= (1 - HOME_SHARE) / weights[:buildings].sum()
    weights[buildings:] *= HOME_SHARE / max(weights[buildings:].sum(), 1e-9)
    while True:
        picked = rng.choice(len(lessons), BATCH, p=weights / weights.sum())
        layers, regions = zip(*(augment_lesson(lessons[i], rng) for i in picked), strict=True)
        yield torch.from_numpy(np.stack(layers)), torch.from_numpy(np.stack(regions).astype(np.int64))


def fit(
    network: UNet,
    batches: Iterator[tuple[Any, Any]],
    weights: Mapping[int, float],
    *,
    minutes: float,
    rate: float,
    smoothing: float = 0.0,
) -> None:
    """Fit a network by AdamW, with a rate that decreases as a cosine; prints the loss.

    weights: of the classes in the loss. smoothing: of their labels. In bfloat16 if the processor supports it.
    """
    network.to(memory_format=torch.channels_last)
    optimizer = torch.optim.AdamW(network.parameters(), rate, weight_decay=1e-3)
    class_weights = torch.tensor([weights[number] for number in sorted(weights)])
    start, loss_so_far = time.monotonic(), 0.0
    for step, (layers, classes) in enumerate(batches, start=1):
        done = (time.monotonic() - start) / 60 / minutes
        if done >= 1:
            return
        for group in optimizer.param_groups:
            group["lr"] = rate * min(1, step / 100) * ((1 + np.cos(np.pi * done)) / 2 + 0.01)
        with torch.autocast("cpu", torch.bfloat16, enabled=has_bfloat16()):
            scores = network(layers.to(memory_format=torch.channels_last))
        loss = functional.cross_entropy(scores.float(), classes, class_weights, label_smoothing=smoothing)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        loss_so_far += (loss.item() - loss_so_far) / min(step, 50)
        if step % 20 == 0:
            sys.stdout.write(f"step {step}, {done:.0%} of the time, loss {loss_so_far:.3f}\n")
            sys.stdout.flush()


def main() -> None:
    """Fit a network and save it as ONNX, with its weights to start from, and the buildings that it was trained on."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--fold", type=int, choices=(0, 1), required=True)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--start", type=Path, help="weights to start from, .pt or .onnx")
    parser.add_argument("--rate", type=float, default=LEARNING_RATE, help="the highest learning rate")
    parser.add_argument("--share", type=float, default=1.0, help="of the fitted weights in the mean with --start.onnx")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("-o", "--out", type=Path, required=True)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    torch.manual_seed(options.fold)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        real, synthetic, buildings = read_lessons(find_data(options.data), options.fold)
    lessons = Lessons(real, synthetic, make_home_lessons(HOME_LESSONS, np.random.default_rng(7 + options.fold)))
    counts = f"{len(real)} plans, {len(synthetic)} synthetic ones, of {len(buildings)} buildings"
    sys.stdout.write(f"{counts}, {len(lessons.homes)} lessons of homes\n")
    network = UNet(LAYERS, len(WEIGHTS))
    if options.start and options.start.suffix == ".onnx":
        some = draw_batches(lessons, np.random.default_rng(3))
        read_onnx(network, options.start, torch.cat([next(some)[0] for _ in range(8)]))
    elif options.start:
        network.load_state_dict(torch.load(options.start, weights_only=True))
    batches = draw_batches(lessons, np.random.default_rng(options.fold))
    fit(network, batches, WEIGHTS, minutes=options.minutes, rate=options.rate, smoothing=LABEL_SMOOTHING)
    torch.save(network.state_dict(), options.out.with_suffix(".pt"))
    names = {"input_name": "sheet", "output_name": "probabilities"}
    write_onnx(Probabilities(network), options.out, inputs=LAYERS, **names)
    if options.share < 1:
        average_onnx(options.out, options.start, options.share)
    options.out.with_suffix(".json").write_text(json.dumps(buildings, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
