"""Our policy: frontiers in the order of a tour, worth what is expected behind them (thesis, sections 8.3 and 8.4)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.exploration.classical_policies import SHORTEST_WAY, assign_frontiers
from pianta.exploration.expectations import RoomExpectations
from pianta.exploration.frontier_area import MEASURES, expect_areas, measure_frontiers
from pianta.exploration.frontiers import Frontier
from pianta.exploration.gain import measure_gains
from pianta.exploration.situation import Situation
from pianta.exploration.tours import choose_first_visit, measure_between
from pianta.gridmap import FREE
from pianta.prediction.unexplored_part import FloorSampler

# Frontiers that a tour goes through, the nearest ones.
PLACES = 12
# Less to see than this is nothing, as long as there is more elsewhere; m².
LEAST_AREA, LEAST_SIGHT = 1.0, 0.1
# Area that comes into sight along a metre of way, m².
SEEN_PER_METRE = 8.0
# Worth grows slowly with area: what is expected is uncertain, and small rooms on the way are best seen at once.
EXPONENT = 0.35
# Of what is expected and what is in sight the geometric mean counts, with this weight for what is in sight.
SIGHT = 0.5
# In a search, area in sight counts by the chance to find what is looked for there, and by so much besides.
ANYWHERE = 0.1


@dataclass(frozen=True, eq=False)
class PredictedGain:
    """The first frontier of the tour on which what is expected has to wait least.

    sampler: of a model of the building's type; without one, or without recognised rooms, the unknown area in sight of a
    frontier is all that is expected behind it. find: a label; then the frontier with most area in sight for the way,
    each m² weighed by the chance that a room of that label is behind. enough: a share of the floor, 0 … 1; when so much
    of it has been seen by all that is expected, the advice is to stop.
    Raises OptionError for a share without meaning, or without a sampler that it could be told by.
    """

    sampler: FloorSampler | None = None
    find: str | None = None
    enough: float | None = None
    _expectations: RoomExpectations | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        if self.enough is not None and not 0 < self.enough <= 1:
            raise OptionError(f"enough is {self.enough}, give a share above 0 and up to 1")
        if self.enough is not None and self.sampler is None:
            raise OptionError("without a model nothing is expected of the floor, so no share of it is enough; give one")
        if self.sampler is not None:
            object.__setattr__(self, "_expectations", RoomExpectations(self.sampler, find=self.find))

    def choose(self, situation: Situation) -> list[Frontier | None]:
        """A frontier for each robot; what the one before goes to is left to it."""
        sight, areas, hits = self.expect(situation)
        if self.enough is not None and self.expect_share(situation, areas) >= self.enough:
            return [None] * len(situation.poses)
        if self.find is not None:
            worths = sight * (hits + ANYWHERE)
            ways = np.maximum(situation.distances, SHORTEST_WAY)
            return assign_frontiers(situation, lambda crowded: worths * np.maximum(1 - crowded, 0.01) / ways)
        # The perceptron explains half of what is found; with what is in sight tours are shorter than with either.
        areas = np.where(areas < LEAST_AREA, areas, areas ** (1 - SIGHT) * sight**SIGHT)
        worths = areas**EXPONENT
        chosen: list[Frontier | None] = []
        taken = np.zeros(len(areas), bool)
        for distances in situation.distances:
            place = _choose_place(situation, np.where(taken, np.inf, distances), areas, worths)
            chosen.append(None if place is None else situation.frontiers[place])
            if place is not None:
                # Robots keep apart: what is in reach of a goal is seen from there.
                apart = np.hypot(*(situation.points - situation.points[place]).T)
                taken[place] = True
                worths = np.where(apart < situation.reach, worths / 2, worths)
        return chosen

    def expect(self, situation: Situation) -> tuple[Floats, Floats, Floats]:
        """Of each frontier area in sight and expected, m², and the chance of a hit; shape (frontiers,) each."""
        if self._expectations is None or situation.seen is None:
            targets = [frontier.target for frontier in situation.frontiers]
            sight = measure_gains(situation.known, targets, reach=situation.reach, resolution=situation.resolution)
            sight = np.maximum(sight, LEAST_SIGHT)
            return sight, np.maximum(sight, situation.resolution**2), np.zeros(len(sight))
        measured, hits = measure_frontiers(situation, self._expectations)
        sight = np.maximum(measured[:, MEASURES.index("in sight")] ** 2, LEAST_SIGHT)
        return sight, np.maximum(expect_areas(measured), situation.resolution**2), hits

    def expect_share(self, situation: Situation, areas: Floats) -> float:
        """The share of the floor that has been seen, by the areas that are expected behind the frontiers."""
        seen = float(np.count_nonzero(situation.known == FREE)) * situation.resolution**2
        return seen / (seen + float(areas.sum()))


def _choose_place(situation: Situation, distances: Floats, areas: Floats, worths: Floats) -> int | None:
    """The place among the frontiers of the next one to visit; None where none can be reached."""
    possible = np.isfinite(distances)
    if not possible.any():
        return None
    worthy = possible & (areas >= LEAST_AREA)
    chosen = np.flatnonzero(worthy if worthy.any() else possible)
    chosen = chosen[np.argsort(distances[chosen], kind="stable")][:PLACES]
    if len(chosen) == 1:
        return int(chosen[0])
    targets = np.array([situation.frontiers[place].target for place in chosen])
    between = measure_between(situation.passable, targets, resolution=situation.resolution)
    lengths = areas[chosen] / SEEN_PER_METRE
    return int(chosen[choose_first_visit(distances[chosen], between, worths[chosen], lengths)])
