"""How probable it is that a room or a door of the method `structure` is right.

Logistic models of a few measures of what the network saw, fitted by training/fit_region_confidence.py.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import shapely
from numpy.typing import ArrayLike

from pianta._types import Floats, LabelImage
from pianta.floor import Door, Room
from pianta.layout._working_grid import WorkingGrid
from pianta.layout.structure.evidence import DOOR, FLOOR, OFFSETS, WALL, Evidence, Probabilities
from pianta.layout.structure.regions import sample_image
from pianta.models import MODELS

MODEL_FILE = MODELS / "region_confidence.json"
ROOM_MEASURES = ("leak", "weakest border", "division inside", "floor", "log area", "convexity")
DOOR_MEASURES = ("door", "wall", "across", "jambs", "unusual width", "least room")
# The constants were chosen by hand. Measures are used up to this many spreads from their mean, so that none decides
# alone.
MAX_DEVIATION = 4.0
# Probabilities are kept this far from 0 and 1, so that no single pair of cells decides.
MIN_PROBABILITY = 0.02
# Pairs of cells begin at every second row and column: means need no more, and this takes a quarter of the time.
PAIR_STEP = 2
# Two rooms with fewer such pairs are no neighbours.
MIN_PAIRS = 3
# Positions along a door where images are looked up.
LINE_SAMPLES = np.linspace(0, 1, 9)
# Distances beyond the ends of a door at which a jamb is searched; cells of the network.
JAMB_DEPTHS = np.arange(1, 4)
# Width of a usual door; metres.
USUAL_WIDTH = 0.9
# Least width of a door for its logarithm; metres.
MIN_WIDTH = 0.1
# Digits of a probability after the point.
DIGITS = 3


@dataclass(frozen=True, eq=False)
class LogisticModel:
    """The probability to be right; the arrays have shape (measures,).

    means, spreads: of the measures in the fit. weights: of the measures, less their means, over their spreads.
    """

    means: Floats
    spreads: Floats
    weights: Floats
    bias: float

    def predict(self, measures: Floats) -> Floats:
        """Probabilities, shape (N,), of what has measures of shape (N, measures)."""
        return np.asarray(1 / (1 + np.exp(-(self.standardise(measures) @ self.weights + self.bias))))

    def standardise(self, measures: Floats) -> Floats:
        """Measures, shape (N, measures), in spreads from their means."""
        return np.asarray(((measures - self.means) / self.spreads).clip(-MAX_DEVIATION, MAX_DEVIATION))


@dataclass(frozen=True, eq=False)
class ConfidenceModel:
    """The models of rooms, by ROOM_MEASURES, and of doors, by DOOR_MEASURES."""

    rooms: LogisticModel
    doors: LogisticModel


@cache
def read_confidence_model(path: Path = MODEL_FILE) -> ConfidenceModel:
    """The model in a file of training/fit_region_confidence.py."""
    content = json.loads(path.read_text(encoding="utf-8"))

    def read(noun: str, measures: Sequence[str]) -> LogisticModel:
        by_name = content[noun]["measures"]
        means, spreads, weights = (
            np.array([by_name[name][key] for name in measures]) for key in ("mean", "spread", "weight")
        )
        return LogisticModel(means, spreads, weights, float(content[noun]["bias"]))

    return ConfidenceModel(read("rooms", ROOM_MEASURES), read("doors", DOOR_MEASURES))


def rate_regions(
    rooms: Sequence[Room], doors: Sequence[Door], labels: LabelImage, working_grid: WorkingGrid, evidence: Evidence
) -> tuple[list[Room], list[Door]]:
    """The rooms and doors with the probability that each is right.

    labels: shape (H, W) of the working grid; the label of a room is its id.
    """
    model = read_confidence_model()
    room_chances = model.rooms.predict(measure_rooms(rooms, labels, evidence))
    by_id = {room.id: chance for room, chance in zip(rooms, room_chances.tolist(), strict=True)}
    door_measures = np.column_stack([measure_doors(doors, working_grid, evidence), measure_least_rooms(doors, by_id)])
    door_chances = model.doors.predict(door_measures)
    return (
        [replace(room, probability=round(by_id[room.id], DIGITS)) for room in rooms],
        [
            replace(door, probability=round(chance, DIGITS))
            for door, chance in zip(doors, door_chances.tolist(), strict=True)
        ],
    )


def measure_rooms(rooms: Sequence[Room], labels: LabelImage, evidence: Evidence) -> Floats:
    """ROOM_MEASURES of each room, shape (rooms, measures).

    Pairs are those of cells at OFFSETS. leak: the share that pairs with a cell in another room have in the sum of the
    affinities of its pairs. weakest border: the highest mean log odds of one room of the pairs with a neighbour.
    division inside: mean probability of pairs inside it to be in two rooms. floor: mean probability of this class.
    convexity: share of its convex hull that it covers.

    labels: shape (H, W) of the working grid; the label of a room is its id.
    """
    numbers = np.array([room.id for room in rooms])
    cells = evidence.sample(labels)
    count = int(labels.max(initial=0)) + 1
    inside, across = _sum_inside(cells, evidence, count), _sum_across(cells, evidence, count)
    size = np.maximum(np.bincount(cells.ravel(), minlength=count), 1)
    by_number = [
        # One more pair, for rooms without any
        across.affinity / (inside.affinity + across.affinity + 1),
        across.weakest,
        (inside.pairs - inside.affinity) / (inside.pairs + 1),
        np.bincount(cells.ravel(), evidence.classes[FLOOR].ravel(), count) / size,
    ]
    polygons = [room.polygon for room in rooms]
    area = shapely.area(polygons)
    return np.column_stack(
        [*(values[numbers] for values in by_number), np.log(area), area / shapely.area(shapely.convex_hull(polygons))]
    )


@dataclass(frozen=True, eq=False)
class _Inside:
    """The pairs of cells in each label, and the sum of their affinities; shape (labels,)."""

    pairs: Floats
    affinity: Floats


@dataclass(frozen=True, eq=False)
class _Across:
    """The sum of the affinities of pairs of cells in each label and in another one; shape (labels,).

    weakest: the highest mean log odds with a neighbour.
    """

    affinity: Floats
    weakest: Floats


def _list_pairs(cells: LabelImage, evidence: Evidence) -> Iterator[tuple[LabelImage, LabelImage, Probabilities]]:
    """Labels of the two cells of pairs, 0 no room, and their affinities; for each offset three images of one shape.

    cells: labels on the cells of the network, shape (h, w).
    """
    for (down, right), affinity in zip(OFFSETS, evidence.affinities, strict=True):
        height, width = cells.shape[0] - down, cells.shape[1] - right
        if height > 0 and width > 0:
            one, other = (image[::PAIR_STEP, ::PAIR_STEP] for image in (cells[:height, :width], cells[down:, right:]))
            yield one, other, affinity[:height:PAIR_STEP, :width:PAIR_STEP]


def _sum_inside(cells: LabelImage, evidence: Evidence, count: int) -> _Inside:
    pairs, affinities = np.zeros((2, count))
    for one, other, affinity in _list_pairs(cells, evidence):
        same = (one == other) & (one > 0)
        pairs += np.bincount(one[same], minlength=count)
        affinities += np.bincount(one[same], affinity[same], count)
    return _Inside(pairs, affinities)


def _sum_across(cells: LabelImage, evidence: Evidence, count: int) -> _Across:
    keys, values = [np.zeros(0, np.int64)], [np.zeros(0)]
    for one, other, affinity in _list_pairs(cells, evidence):
        apart = (one != other) & (one > 0) & (other > 0)
        low, high = np.minimum(one, other)[apart], np.maximum(one, other)[apart]
        keys.append(low.astype(np.int64) * count + high)
        values.append(affinity[apart].astype(float))
    borders, index, pairs = np.unique(np.concatenate(keys), return_inverse=True, return_counts=True)
    affinity = np.concatenate(values)
    sums, log_odds = (np.bincount(index.ravel(), each, len(borders)) for each in (affinity, _to_log_odds(affinity)))
    total, weakest = np.zeros(count), np.full(count, float(_to_log_odds(0.0)))
    for rooms in np.divmod(borders, count):
        np.add.at(total, rooms, sums)
        is_long = pairs >= MIN_PAIRS
        np.maximum.at(weakest, rooms[is_long], (log_odds / pairs)[is_long])
    return _Across(total, weakest)


def measure_doors(doors: Sequence[Door], working_grid: WorkingGrid, evidence: Evidence) -> Floats:
    """DOOR_MEASURES of each door but the last one, shape (doors, measures - 1).

    door: mean probability of this class at most a cell from its line. wall: mean probability of this class on its line.
    across: mean log odds that cells 0.2 m before and behind its line are in one room. jambs: probability of wall beyond
    its ends, the lower of both. unusual width: distance of the logarithms of its width and of a usual one.
    """
    if not doors:
        return np.zeros((0, len(DOOR_MEASURES) - 1))
    ends = _find_cells(doors, working_grid, evidence)
    along = ends[:, 1] - ends[:, 0]
    line = ends[:, :1] + LINE_SAMPLES[:, None] * along[:, None]
    door, wall = evidence.classes[DOOR], evidence.classes[WALL]
    near_door, near_wall = (cv2.dilate(image, np.ones((3, 3), np.uint8)) for image in (door, wall))
    beyond = JAMB_DEPTHS[:, None] * (along / np.linalg.norm(along, axis=1).clip(1e-9)[:, None])[:, None]
    jambs = [
        sample_image(near_wall, ends[:, side, None] + sign * beyond).max(axis=1) for side, sign in ((0, -1), (1, 1))
    ]
    width = np.array([max(door.width, MIN_WIDTH) for door in doors])
    return np.column_stack(
        [
            sample_image(near_door, line).mean(axis=1),
            sample_image(wall, line).mean(axis=1),
            _measure_across(line, along, evidence),
            np.minimum(*jambs),
            np.abs(np.log(width / USUAL_WIDTH)),
        ]
    )


def measure_least_rooms(doors: Sequence[Door], room_chances: Mapping[int, float]) -> Floats:
    """The last of DOOR_MEASURES: log odds that the less probable one of a door's rooms is right, shape (doors,).

    room_chances: probability of each room to be right, by id.
    """
    return _to_log_odds([min(room_chances[room] for room in door.room_ids) for door in doors])


def _find_cells(doors: Sequence[Door], working_grid: WorkingGrid, evidence: Evidence) -> Floats:
    """Row and col of the ends of doors, in cells of the network from the middle of the first; shape (doors, 2, 2)."""
    xy = shapely.get_coordinates([door.line for door in doors])
    ones = np.ones(len(xy))
    rows, cols, _ = np.linalg.inv(working_grid.to_grid) @ [*working_grid.grid.map_to_pixel(*xy.T), ones]
    col, row = evidence.from_working @ [cols, rows, ones]
    return np.column_stack([row, col]).reshape(-1, 2, 2) - 0.5


def _measure_across(line: Floats, along: Floats, evidence: Evidence) -> Floats:
    """Mean log odds that the cells at the shortest offset around positions on doors are in one room, shape (doors,).

    line: positions on each door, shape (doors, N, 2), row and col. along: from one end to the other, shape (doors, 2).
    """
    by_axis = [
        sample_image(affinity, line - np.array(offset) / 2)
        for offset, affinity in zip(OFFSETS[:2], evidence.affinities, strict=False)
    ]
    # Across an upright door lie the cells of other columns
    is_upright = np.abs(along[:, 0]) > np.abs(along[:, 1])
    return np.asarray(_to_log_odds(np.where(is_upright[:, None], *by_axis)).mean(axis=1))


def _to_log_odds(probability: ArrayLike) -> Floats:
    bounded = np.clip(np.asarray(probability, float), MIN_PROBABILITY, 1 - MIN_PROBABILITY)
    return np.asarray(np.log(bounded / (1 - bounded)))
