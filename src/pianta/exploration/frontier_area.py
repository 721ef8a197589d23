"""How much area a robot will really find behind a frontier: what it measures there, weighed as simulated runs teach.

Of all frontiers half lead to less than 2 m²: corners, slits between beams, the far side of a doorway. What is in sight
of them, through gaps in walls that are not seen yet, tells little of that; a small perceptron tells more.
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
from pianta.exploration.perception import Perception
from pianta.exploration.situation import Situation
from pianta.models import MODELS

# Unknown area this near counts apart from that in the reach of the lidar, m.
NEAR = 3.0
# A frontier in a room that was not recognised belongs to an unopened door within this distance, m.
DOOR_REACH = 4.0
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
# The weights of the perceptron, of training/fit_frontier_area.py; it gives the square root of m².
WEIGHTS = MODELS / "frontier_area.json"


def measure_frontiers(situation: Situation, expectations: RoomExpectations) -> tuple[Floats, Floats]:
    """MEASURES of each frontier, shape (frontiers, measures), and the chance of a hit behind it, shape (frontiers,).

    Areas are square roots of m². Rooms share what is expected of them among their frontiers by length.
    """
    frontiers, seen = situation.frontiers, situation.seen
    targets = [frontier.target for frontier in frontiers]
    in_sight, near = (
        measure_gains(situation.known, targets, reach=reach, resolution=situation.resolution)
        for reach in (situation.reach, min(NEAR, situation.reach))
    )
    measured = np.zeros((len(frontiers), len(MEASURES)))
    measured[:, 0], measured[:, 1] = np.sqrt(in_sight), np.sqrt(near)
    measured[:, 2] = np.sqrt([frontier.length for frontier in frontiers])
    hits = np.zeros(len(frontiers))
    if seen is None:
        return measured, hits
    rooms = {room.id: room for room in seen.rooms}
    ends = _find_ends(situation, seen, rooms.keys())
    lengths: dict[int | None, float] = {}
    for frontier, end in zip(frontiers, ends, strict=True):
        lengths[end] = lengths.get(end, 0.0) + frontier.length
    beyond = expectations.predict_beyond(seen, sorted(end for end in lengths if end in rooms))
    for place, (frontier, end) in enumerate(zip(frontiers, ends, strict=True)):
        share = frontier.length / lengths[end]
        measured[place, 7] = share
        if end is None:
            continue
        measured[place, 6] = np.sqrt(beyond.area.get(end, 0.0) * share)
        measured[place, 8] = end not in rooms
        hits[place] = beyond.hit.get(end, 0.0) * share
        if end in rooms:
            room = rooms[end]
            rest = expectations.expect_rest(room.label, room.area)
            measured[place, 3:6] = 1, np.sqrt(rest), np.sqrt(room.area)
            measured[place, 9] = room.entered
    return measured, hits


def expect_areas(measured: Floats) -> Floats:
    """Area behind frontiers, m², shape (n,), from their MEASURES, shape (n, measures)."""
    weights = _read_weights()
    hidden = (measured - weights["mean"]) / weights["spread"]
    for layer in range(len(weights) // 2 - 2):
        hidden = np.maximum(hidden @ weights[f"weights {layer}"] + weights[f"bias {layer}"], 0)
    last = len(weights) // 2 - 2
    roots = (hidden @ weights[f"weights {last}"] + weights[f"bias {last}"])[:, 0]
    areas: Floats = np.maximum(roots, 0) ** 2
    return areas


def find_door(seen: Perception, point: Sequence[float] | Floats) -> int | None:
    """The unopened door that a point, x, y, is near, as `-1 - number`; None where there is none."""
    at_door = [
        (line.distance(Point(*point)), number)
        for (_, number), line in zip(seen.unopened, seen.unopened_lines, strict=True)
    ]
    distance, number = min(at_door, default=(np.inf, 0))
    return -1 - number if distance <= DOOR_REACH else None


def _find_ends(situation: Situation, seen: Perception, known: Collection[int]) -> list[int | None]:
    """The recognised room that each frontier lies in, or the unopened door that it is at."""
    return [
        room if room in known else find_door(seen, point)
        for room, point in zip(situation.rooms, situation.points, strict=True)
    ]


@cache
def _read_weights() -> dict[str, Floats]:
    content = json.loads(WEIGHTS.read_text())
    return {name: np.array(values, float) for name, values in content.items()}
