"""The area that a robot will find behind a frontier, by a perceptron that was trained on simulated runs.

Half of all frontiers lead to less than 2 m²: corners, gaps between beams, the far side of a doorway. The unknown area
in sight, through gaps of walls that are not mapped yet, predicts this poorly; the perceptron predicts it better.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from functools import cache

import numpy as np
from shapely import Point

from pianta._types import Floats
from pianta.exploration.expectations import RoomExpectations
from pianta.exploration.gain import measure_gains
from pianta.exploration.policy_input import PolicyInput
from pianta.exploration.recognised_rooms import RecognisedRooms
from pianta.models import MODELS

# Reach of the second measure of unknown area, m; the weights belong to it.
NEAR = 3.0
# A frontier outside of the recognised rooms belongs to an unopened door within this distance, m. Chosen by hand.
DOOR_REACH = 4.0
# The inputs of the perceptron, in the order of its weights.
MEASURES = (
    "in sight",
    "in sight within 3 m",
    "length",
    "in a room",
    "rest of the room",
    "seen of the room",
    "beyond",
    "share of its end",
    "at a door",
    "entered",
)
# Weights fitted by training/fit_frontier_area.py; the output is the square root of m².
WEIGHTS = MODELS / "frontier_area.json"


def measure_frontiers(inputs: PolicyInput, expectations: RoomExpectations) -> tuple[Floats, Floats]:
    """MEASURES of each frontier, shape (frontiers, measures), and P(wanted label behind it), shape (frontiers,).

    Areas are square roots of m². The frontiers of a room share the expected area behind it by their lengths.
    """
    frontiers, recognised = inputs.frontiers, inputs.recognised
    targets = [frontier.target for frontier in frontiers]
    in_sight, near = (
        measure_gains(inputs.cells, targets, reach=reach, resolution=inputs.resolution)
        for reach in (inputs.reach, min(NEAR, inputs.reach))
    )
    measures = np.zeros((len(frontiers), len(MEASURES)))
    measures[:, 0], measures[:, 1] = np.sqrt(in_sight), np.sqrt(near)
    measures[:, 2] = np.sqrt([frontier.length for frontier in frontiers])
    hits = np.zeros(len(frontiers))
    if recognised is None:
        return measures, hits
    rooms = {room.id: room for room in recognised.rooms}
    ends = _find_ends(inputs, recognised, rooms.keys())
    lengths: dict[int | None, float] = {}
    for frontier, end in zip(frontiers, ends, strict=True):
        lengths[end] = lengths.get(end, 0.0) + frontier.length
    beyond = expectations.predict_beyond(recognised, sorted(end for end in lengths if end in rooms))
    for row, (frontier, end) in enumerate(zip(frontiers, ends, strict=True)):
        share = frontier.length / lengths[end]
        measures[row, 7] = share
        if end is None:
            continue
        measures[row, 6] = np.sqrt(beyond.area.get(end, 0.0) * share)
        measures[row, 8] = end not in rooms
        hits[row] = beyond.hit.get(end, 0.0) * share
        if end in rooms:
            room = rooms[end]
            rest = expectations.expect_rest(room.label, room.area)
            measures[row, 3:6] = 1, np.sqrt(rest), np.sqrt(room.area)
            measures[row, 9] = room.entered
    return measures, hits


def expect_areas(measures: Floats) -> Floats:
    """Expected area behind frontiers, m², shape (n,), from their MEASURES, shape (n, measures)."""
    weights = _read_weights()
    hidden = (measures - weights["mean"]) / weights["spread"]
    last = len(weights) // 2 - 2
    for layer in range(last):
        hidden = np.maximum(hidden @ weights[f"weights {layer}"] + weights[f"bias {layer}"], 0)
    roots = (hidden @ weights[f"weights {last}"] + weights[f"bias {last}"])[:, 0]
    areas: Floats = np.maximum(roots, 0) ** 2
    return areas


def find_door(recognised: RecognisedRooms, point: Sequence[float] | Floats) -> int | None:
    """The nearest unopened door of a point, x, y, as `-1 - number`; None if none is within DOOR_REACH."""
    doors = [
        (line.distance(Point(*point)), number)
        for (_, number), line in zip(recognised.unopened, recognised.unopened_lines, strict=True)
    ]
    distance, number = min(doors, default=(np.inf, 0))
    return -1 - number if distance <= DOOR_REACH else None


def _find_ends(inputs: PolicyInput, recognised: RecognisedRooms, rooms: Collection[int]) -> list[int | None]:
    """The recognised room of each frontier, or the unopened door near it."""
    return [
        room if room in rooms else find_door(recognised, point)
        for room, point in zip(inputs.rooms, inputs.points, strict=True)
    ]


@cache
def _read_weights() -> dict[str, Floats]:
    content = json.loads(WEIGHTS.read_text())
    return {name: np.array(values, float) for name, values in content.items()}
