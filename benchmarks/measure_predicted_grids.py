"""Free space beyond the explored part of schools: the log loss of predicted grids, beside simple predictions.

Run: OMP_NUM_THREADS=1 python benchmarks/measure_predicted_grids.py [--data ../shared/data] [--count 100] [--json FILE]

Every school is explored to one corridor, and to a quarter, half and three quarters of them; what remains is predicted
by a model of the schools of all other buildings, and each of COUNT samples is drawn behind the open ends. Of open
corridors only what lies within 3 m of a door to a known room is known, also their areas.

Scored are the cells, every third of 0.1 m along rows and columns, in the box around the true school and 5 m more, that
are not in the known part or its walls (0.1 m). In truth a cell is free if it is in a room, and not within 0.1 m of its
outline, unless in a door. The log loss is the mean of -ln of the probability of what is true, at most -ln 0.0001.

- half: every cell is free with probability 0.5.
- average map: the share of free cells at the same distance from the known part on other schools.
- average map at open ends: that at the same distances from the known part and from its nearest open end.
- wall lines: straight walls of the known part are extended over the box. Cells on these lines, cells in faces between
  them at an open end, and other cells have the share of free cells of their class on other schools; a class also says
  whether the cell lies between the outermost lines in x and in y.
- shares: (share of samples + s) / (1 + 2 s), with the s of the least loss on other schools.
- blurred shares: a logistic regression on the log-odds of the share blurred by 4 and by 8 m.
- free probability: the same with the logarithms of both distances; that of `ShareGrid.free_probability`.

Everything that is fitted is fitted to the schools of other buildings, in six folds. The last lines are the weights that
a fit to all schools gives, for pianta.prediction.continuation.free_probability.
"""

from __future__ import annotations

import argparse
import json
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import log
from pathlib import Path

import networkx as nx
import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry
from sklearn.linear_model import LogisticRegression

import pianta
from pianta._types import Floats, Indices, Mask
from pianta.errors import BuildingWarning
from pianta.floor import Floor
from pianta.generation.drawing.blocks import CELL
from pianta.generation.type_model import TypeModel, learn_type, prepare_room_graph
from pianta.graphs.metrics import find_corridors
from pianta.gridmap import GridMap
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.labels import SCHEMAS, LabelConvention
from pianta.prediction.continuation.continuations import SampleDrawer
from pianta.prediction.continuation.count_samples import SampleCounts
from pianta.prediction.continuation.free_probability import describe_cells
from pianta.prediction.continuation.ground import PARTS, cover
from pianta.prediction.continuation.known_part import KnownPart, locate_known_part
from pianta.prediction.explored_part import read_explored_part
from pianta.prediction.revealed_floor import RevealedFloor, reveal_corridors
from pianta.prediction.unexplored_part import FloorSampler
from pianta_bench.data.building_of import building_of
from pianta_bench.prediction.intervals import resample_buildings

TYPE = "school"
SHARES_EXPLORED = (0.0, 0.25, 0.5, 0.75)
WINDOW = 5.0  # m around the true floor
STEP = 3  # fine cells; PARTS and STEP have no common divisor, so all positions in a cell occur
WALL = 0.1  # m
FOLDS = 6
LEAST_PROBABILITY = 1e-4
EDGES = (0.5, 1, 2, 3, 5, 8, 12, 18, 27, 40)  # m, of the tables of distances
PRIOR_CELLS = 0.005  # of a floor's cells, with which a class of cells counts as the mean
SMOOTHINGS = (0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
FITTED = 1500  # cells of a case to which a regression is fitted
LEAST_WALL = 1.0  # m, of a side of an outline that gives a wall line
SAME_LINE = 0.4  # m between lines that are one
REACH = 0.5  # m from a face to an open end

Fit = Callable[["Sequence[Case]"], Callable[["Case"], Floats]]


@dataclass(frozen=True, eq=False)
class Case:
    """The scored cells of a floor, explored to a stage, shapes (N,); features: as of describe_cells, shape (N, 4)."""

    name: str
    explored: int
    building: str
    free: Mask
    share: Floats
    features: Floats
    classes: Indices

    def find_bins(self, columns: Sequence[int]) -> Indices:
        """The number of the distances to the known part (2) or to an open end (3), or both, by EDGES."""
        bins = [np.digitize(np.expm1(self.features[:, column]), EDGES) for column in columns]
        return np.asarray(np.ravel_multi_index(bins, [len(EDGES) + 1] * len(bins)))


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    warnings.simplefilter("ignore", BuildingWarning)
    cases = [*list_cases(options.data, options.count)]
    buildings = sorted({case.building for case in cases})
    free = np.mean([case.free.mean() for case in cases])
    cells = sum(len(case.free) for case in cases)
    print(f"{len(cases)} cases of {len(buildings)} buildings, {cells} cells, {free:.0%} free")
    losses = {name: measure_losses(cases, buildings, fit) for name, fit in PREDICTORS.items()}
    for name, values in losses.items():
        print(f"{name:26} {np.mean(values):.4f} ± {np.std(values):.4f}")
    for name in ("shares", "blurred shares", "free probability"):
        for other in ("half", "average map", "average map at open ends", "wall lines"):
            differences = zip(cases, losses[name] - losses[other], strict=True)
            interval = resample_buildings((case.building, float(value)) for case, value in differences)
            print(f"{name} - {other}: {interval.mean:+.4f} ({interval.low:+.4f} to {interval.high:+.4f})")
    regression = fit_regression(cases, slice(None))
    print("INTERCEPT =", round(float(regression.intercept_[0]), 3))
    print("WEIGHTS =", tuple(regression.coef_[0].round(3).tolist()))
    if options.json:
        names = [{"floor": case.name, "explored": case.explored, "building": case.building} for case in cases]
        content = {"cases": names, "losses": {name: values.tolist() for name, values in losses.items()}}
        options.json.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def list_cases(data: Path, count: int) -> Iterator[Case]:
    """The stages of all schools that leave something unknown."""
    floors = {path.stem: read_building_xml(path) for path in sorted((data / "buildings" / TYPE).glob("*.xml"))}
    schema = SCHEMAS[TYPE]
    graphs = {name: prepare_room_graph(floor.graph(), schema) for name, floor in floors.items()}
    homes = {name: building_of(data, f"buildings/{TYPE}/{name}.xml") for name in floors}
    for name, floor in floors.items():
        model = learn_type([graph for other, graph in graphs.items() if homes[other] != homes[name]], schema)
        sampler = FloorSampler(model)
        corridors = len(find_corridors(graphs[name], schema, convention=LabelConvention.GRAPHS))
        for explored in sorted({max(1, -int(-share * corridors // 1)) for share in SHARES_EXPLORED}):
            truth = reveal_corridors(floor.graph(), schema, corridors=explored)
            if truth.unknown:
                yield measure_case(floor, truth, model, sampler, count, (name, explored, homes[name]))


def measure_case(  # noqa: PLR0917
    floor: Floor,
    truth: RevealedFloor,
    model: TypeModel,
    sampler: FloorSampler,
    count: int,
    names: tuple[str, int, str],
) -> Case:
    """Predict a floor, draw the samples, and take the scored cells."""
    forget_open_areas(truth.part, locate_known_part(read_explored_part(truth.part, model.schema), floor, truth))
    prediction = pianta.predict(truth.part, sampler, count=count)
    known_part = locate_known_part(prediction.explored, floor, truth)
    counts = (drawer := SampleDrawer.make(prediction, known_part, model)).count().cells
    rooms = [floor[number].polygon for number in truth.graph]
    frame, padding = widen(drawer.ground.frame, rooms)
    share, features = describe_padded(counts, padding)
    unseen = ~cover([outline.buffer(WALL) for outline in known_part.outlines], frame)
    outlines = shapely.union_all([room.boundary for room in rooms]).buffer(WALL)
    doors = [door.line.buffer(1.5 * WALL, cap_style="flat") for door in floor.doors if door.joins_rooms]
    free = cover(rooms, frame) & ~(cover([outlines], frame) & ~cover(doors, frame))
    classes = classify_by_lines(known_part, frame, np.repeat(np.repeat(features[..., 3], PARTS, 0), PARTS, 1))
    scored = find_box(rooms, frame) & unseen
    rows, columns = np.nonzero(scored[::STEP, ::STEP])
    rows, columns = rows * STEP, columns * STEP
    name, explored, building = names
    cells = (rows // PARTS, columns // PARTS)
    print(f"{name} after {explored} corridors: {len(rows)} cells, {free[rows, columns].mean():.0%} free", flush=True)
    return Case(name, explored, building, free[rows, columns], share[cells], features[cells], classes[rows, columns])


def forget_open_areas(part: nx.Graph, known_part: KnownPart) -> None:
    """Give open corridors the area that is seen of them."""
    for node, number in known_part.ids.items():
        part.nodes[number]["area"] = known_part.partial[node].area


def widen(frame: GridMap, rooms: Sequence[BaseGeometry]) -> tuple[GridMap, list[tuple[int, int]]]:
    """The fine cells of a frame that contains the box around rooms; and the cells added at each side of both axes."""
    xy = shapely.get_coordinates(np.array(rooms, dtype=object))
    rows, columns = frame.map_to_pixel(xy[:, 0], xy[:, 1])
    padding = [
        (max(0, 1 - int((ends.min() - WINDOW / CELL) // 1)), max(0, 1 + int((ends.max() + WINDOW / CELL) // 1) - side))
        for ends, side in ((rows, frame.shape[0]), (columns, frame.shape[1]))
    ]
    shape = [PARTS * (side + sum(added)) for side, added in zip(frame.shape, padding, strict=True)]
    x, y = frame.pixel_to_map(frame.shape[0] + padding[0][1], -padding[1][0])
    return GridMap(np.zeros(shape, np.int8), CELL / PARTS, (float(x), float(y), frame.origin[2])), padding


def describe_padded(counts: SampleCounts, padding: list[tuple[int, int]]) -> tuple[Floats, Floats]:
    """The shares and the features of the cells of a ground with more cells around it."""
    share, unknown = counts.average()
    openings = np.pad(counts.ground.openings, padding)
    share, unknown = np.pad(share, padding), np.pad(unknown, padding, constant_values=1)
    return share, describe_cells(share, unknown, openings, cell=CELL)


def find_box(rooms: Sequence[BaseGeometry], frame: GridMap) -> Mask:
    """The cells in the box around rooms, along the rows, and WINDOW more."""
    xy = shapely.get_coordinates(np.array(rooms, dtype=object))
    rows, columns = (np.array(part) for part in frame.map_to_pixel(xy[:, 0], xy[:, 1]))
    margin = WINDOW / frame.resolution
    inside = [
        (np.arange(side) >= ends.min() - margin) & (np.arange(side) <= ends.max() + margin)
        for ends, side in zip((rows, columns), frame.shape, strict=True)
    ]
    return np.outer(*inside)


def classify_by_lines(known_part: KnownPart, frame: GridMap, near_open: Floats) -> Indices:
    """The class of each cell between the extended straight walls of a known part; near_open: log1p of m."""
    lines: tuple[list[float], list[float]] = ([], [])
    for ring in shapely.get_rings(shapely.get_parts(known_part.outlines)):
        pixels = np.column_stack(frame.map_to_pixel(*shapely.get_coordinates(ring).T)) * frame.resolution
        for (row, column), (next_row, next_column) in pairwise(pixels.tolist()):
            if abs(next_column - column) >= LEAST_WALL and abs(next_row - row) < 0.1 * abs(next_column - column):
                lines[0].append((row + next_row) / 2)
            if abs(next_row - row) >= LEAST_WALL and abs(next_column - column) < 0.1 * abs(next_row - row):
                lines[1].append((column + next_column) / 2)
    positions = [merge_lines(values) for values in lines]
    centres = [(np.arange(side) + 0.5) * frame.resolution for side in frame.shape]
    faces = [np.searchsorted(lines_, at) for lines_, at in zip(positions, centres, strict=True)]
    on_line = [np.abs(at[:, None] - lines_).min(axis=1) <= WALL for lines_, at in zip(positions, centres, strict=True)]
    between = [(face > 0) & (face < len(lines_)) for lines_, face in zip(positions, faces, strict=True)]
    number = faces[0][:, None] * (len(positions[1]) + 1) + faces[1]
    is_known = cover(known_part.outlines, frame)
    at_end = np.isin(number, np.unique(number[(near_open < log(1 + REACH)) & ~is_known]))
    wall = on_line[0][:, None] | on_line[1]
    return np.asarray(between[0][:, None] + 1 * between[1] + 3 * at_end + 6 * wall)


def merge_lines(values: Sequence[float]) -> Floats:
    """Sorted positions of lines, without those beside another one; one outside of the grid without any."""
    merged: list[float] = []
    for value in sorted(values):
        if not merged or value - merged[-1] > SAME_LINE:
            merged.append(value)
    return np.array(merged or [-1e3])


def measure_losses(cases: Sequence[Case], buildings: Sequence[str], fit: Fit) -> Floats:
    """The log loss of each case, by a predictor that was fitted to other folds of buildings."""
    order = np.random.default_rng(1).permutation(len(buildings))
    folds = {buildings[index]: number % FOLDS for number, index in enumerate(order)}
    losses = np.zeros(len(cases))
    for fold in range(FOLDS):
        predict = fit([case for case in cases if folds[case.building] != fold])
        for index in (index for index, case in enumerate(cases) if folds[case.building] == fold):
            losses[index] = measure_loss(predict(cases[index]), cases[index])
    return losses


def measure_loss(probability: Floats, case: Case) -> float:
    """The log loss of the probabilities that cells are free."""
    true = np.where(case.free, probability, 1 - probability)
    return float(-np.log(true.clip(LEAST_PROBABILITY, 1 - LEAST_PROBABILITY)).mean())


def fit_half(_: Sequence[Case]) -> Callable[[Case], Floats]:
    """One half for each cell."""
    return lambda case: np.full(len(case.free), 0.5)


def fit_table(cases: Sequence[Case], classify: Callable[[Case], Indices]) -> Callable[[Case], Floats]:
    """The share of free cells of each class; each case counts the same."""
    size = (len(EDGES) + 1) ** 2
    free, total = np.zeros(size), np.zeros(size)
    for case in cases:
        free += np.bincount(classify(case), case.free, size) / len(case.free)
        total += np.bincount(classify(case), minlength=size) / len(case.free)
    mean = free.sum() / total.sum()
    shares = (free + PRIOR_CELLS * mean) / (total + PRIOR_CELLS)
    return lambda case: np.asarray(shares[classify(case)])


def fit_smoothing(cases: Sequence[Case]) -> Callable[[Case], Floats]:
    """The shares, smoothed."""

    def smooth(case: Case, by: float) -> Floats:
        return np.asarray((case.share + by) / (1 + 2 * by))

    best = min(SMOOTHINGS, key=lambda by: np.mean([measure_loss(smooth(case, by), case) for case in cases]))
    return lambda case: smooth(case, best)


def fit_regression(cases: Sequence[Case], columns: slice) -> LogisticRegression:
    """A logistic regression on some of the features; each case counts the same."""
    rng = np.random.default_rng(5)
    chosen = [rng.choice(len(case.free), min(FITTED, len(case.free)), replace=False) for case in cases]
    features = np.vstack([case.features[rows, columns] for case, rows in zip(cases, chosen, strict=True)])
    free = np.concatenate([case.free[rows] for case, rows in zip(cases, chosen, strict=True)])
    weights = np.concatenate([np.full(len(rows), FITTED / len(rows)) for rows in chosen])
    return LogisticRegression(C=1e3, max_iter=2000).fit(features, free, sample_weight=weights)


def fit_logistic(cases: Sequence[Case], columns: slice) -> Callable[[Case], Floats]:
    """The probabilities of a regression."""
    regression = fit_regression(cases, columns)
    return lambda case: np.asarray(regression.predict_proba(case.features[:, columns])[:, 1])


PREDICTORS: dict[str, Fit] = {
    "half": fit_half,
    "average map": lambda cases: fit_table(cases, lambda case: case.find_bins((2,))),
    "average map at open ends": lambda cases: fit_table(cases, lambda case: case.find_bins((2, 3))),
    "wall lines": lambda cases: fit_table(cases, lambda case: case.classes),
    "shares": fit_smoothing,
    "blurred shares": lambda cases: fit_logistic(cases, slice(2)),
    "free probability": lambda cases: fit_logistic(cases, slice(None)),
}

if __name__ == "__main__":
    main()
