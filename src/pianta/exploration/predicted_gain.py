"""Our policy: frontiers in the order of a tour, worth what is expected behind them (thesis, sections 8.3 and 8.4)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from shapely import Point

from pianta.exploration.expectations import DOOR_REACH, RoomExpectations
from pianta.exploration.frontiers import Frontier
from pianta.exploration.gain import measure_gains
from pianta.exploration.perception import Perception
from pianta.exploration.situation import Situation
from pianta.exploration.tours import choose_first_visit, measure_between
from pianta.generation.unexplored_part import FloorSampler

Floats = NDArray[np.float64]

# Frontiers that a tour goes through, the nearest ones.
PLACES = 12
# Less to see than this is nothing, as long as there is more elsewhere; m².
LEAST_GAIN = 2.0
# Area that comes into sight along a metre of way, m².
SEEN_PER_METRE = 8.0
# Worth grows with the square root of area: what is expected is uncertain.
EXPONENT = 0.5
# What a search gives for the chance to find what is looked for, and for any m² besides.
HIT_WORTH, SEARCH_AREA_WORTH = 1.0, 1e-4


@dataclass(frozen=True, eq=False)
class PredictedGain:
    """The first frontier of the tour on which the least of what is expected has to wait.

    sampler: of a model of the building's type; without one, the unknown in sight of a frontier is all that is expected
    behind it. find: a label; the tour is then the one that finds it soonest.
    """

    sampler: FloorSampler | None = None
    find: str | None = None
    _expectations: RoomExpectations | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        if self.sampler is not None:
            object.__setattr__(self, "_expectations", RoomExpectations(self.sampler, find=self.find))

    def choose(self, situation: Situation) -> list[Frontier | None]:
        """A frontier for each robot; those of the others count as visited."""
        areas, hits = self.expect(situation)
        worths = areas**EXPONENT
        if self.find is not None:
            worths = HIT_WORTH * hits + SEARCH_AREA_WORTH * areas
        chosen: list[Frontier | None] = []
        taken = np.zeros(len(areas), bool)
        for distances in situation.distances:
            place = self._choose_place(situation, np.where(taken, np.inf, distances), areas, worths)
            chosen.append(None if place is None else situation.frontiers[place])
            if place is not None:
                taken[place] = True
        return chosen

    def _choose_place(self, situation: Situation, distances: Floats, areas: Floats, worths: Floats) -> int | None:
        """The place among the frontiers of the next one to visit."""
        possible = np.isfinite(distances)
        if not possible.any():
            return None
        worthy = possible & (areas >= LEAST_GAIN)
        chosen = np.flatnonzero(worthy if worthy.any() else possible)
        chosen = chosen[np.argsort(distances[chosen], kind="stable")][:PLACES]
        if len(chosen) == 1:
            return int(chosen[0])
        targets = np.array([situation.frontiers[place].target for place in chosen])
        between = measure_between(situation.passable, targets, resolution=situation.resolution)
        lengths = areas[chosen] / SEEN_PER_METRE
        return int(chosen[choose_first_visit(distances[chosen], between, worths[chosen], lengths)])

    def expect(self, situation: Situation) -> tuple[Floats, Floats]:
        """Area expected behind each frontier, m², and the chance of a hit there, shape (frontiers,) each."""
        targets = [frontier.target for frontier in situation.frontiers]
        gains = measure_gains(situation.known, targets, reach=situation.reach, resolution=situation.resolution)
        gains = np.maximum(gains, situation.resolution**2)
        if self._expectations is None or situation.seen is None:
            return gains, np.zeros(len(gains))
        return _expect_of_rooms(situation, self._expectations, gains)


def _expect_of_rooms(situation: Situation, expectations: RoomExpectations, gains: Floats) -> tuple[Floats, Floats]:
    """The rest of the room of each frontier, as far as it is in sight, and what lies beyond."""
    seen = situation.seen
    if seen is None:
        return gains, np.zeros(len(gains))
    rooms = {room.id: room for room in seen.rooms}
    ends = [
        room if room in rooms else find_door(seen, point)
        for room, point in zip(situation.rooms, situation.points, strict=True)
    ]
    lengths: dict[int | None, float] = {}
    for frontier, end in zip(situation.frontiers, ends, strict=True):
        lengths[end] = lengths.get(end, 0.0) + frontier.length
    beyond = expectations.predict_beyond(seen, sorted(end for end in lengths if end in rooms))
    areas, hits = gains.copy(), np.zeros(len(gains))
    for place, (frontier, end) in enumerate(zip(situation.frontiers, ends, strict=True)):
        if end is None:
            continue
        share = frontier.length / lengths[end]
        within = min(gains[place], expectations.expect_rest(rooms[end].label, rooms[end].area)) if end in rooms else 0
        areas[place] = max(within + beyond.area.get(end, 0.0) * share, situation.resolution**2)
        hits[place] = beyond.hit.get(end, 0.0) * share
    return areas, hits


def find_door(seen: Perception, point: Floats) -> int | None:
    """The unopened door that a point, x, y, is near, as `-1 - number`; None where there is none."""
    at_door = [
        (line.distance(Point(*point)), number)
        for (_, number), line in zip(seen.unopened, seen.unopened_lines, strict=True)
    ]
    distance, number = min(at_door, default=(np.inf, 0))
    return -1 - number if distance <= DOOR_REACH else None
