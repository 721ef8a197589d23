"""Our policy: frontiers in the order of a tour, weighted by the expected area behind them (thesis, 8.3 and 8.4)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.exploration.classical_policies import MIN_PATH_LENGTH, apply_crowding, assign_frontiers
from pianta.exploration.expectations import RoomExpectations
from pianta.exploration.frontier_area import MEASURES, expect_areas, measure_frontiers
from pianta.exploration.frontiers import Frontier
from pianta.exploration.gain import measure_gains
from pianta.exploration.policy_input import PolicyInput
from pianta.exploration.routes import measure_distances_between
from pianta.exploration.tours import choose_first_target
from pianta.gridmap import FREE
from pianta.prediction.unexplored_part import FloorSampler

# All values were chosen by hand; docs/methods/exploration.md has the reasons.
# A tour goes through this many frontiers, the nearest ones.
MAX_TOUR_TARGETS = 12
# A frontier with a smaller expected area is visited only if there is no other, m².
MIN_AREA = 1.0
# Lower limit of the area in sight, m².
MIN_SIGHT = 0.1
# Area that becomes visible along a metre of path, m².
AREA_PER_METRE = 8.0
# Worth = area ** WORTH_EXPONENT: expected areas are uncertain, and small rooms near the path are cheapest now.
WORTH_EXPONENT = 0.35
# Weight of the area in sight in its geometric mean with the expected area.
SIGHT_WEIGHT = 0.5
# In a search, each m² in sight counts P(wanted label) plus this.
BASE_HIT = 0.1


@dataclass(frozen=True, eq=False)
class PredictedGain:
    """Go to the first frontier of the tour on which expected area waits least.

    sampler: of a model of the building's type. Without it, or without recognised rooms, the expected area is the
    unknown area in sight of a frontier. find: a label; then the next frontier is the one with most area in sight per
    metre, each m² weighted by the probability of the label. enough: a share of the floor, 0 … 1, by expectation; when
    it has been observed, the policy ends the exploration.
    Raises OptionError if the share makes no sense or has no sampler.
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

    def choose(self, inputs: PolicyInput) -> list[Frontier | None]:
        """Return a frontier for each robot, one robot after the other."""
        sight, areas, hits = self.expect(inputs)
        if self.enough is not None and self.expect_share(inputs, areas) >= self.enough:
            return [None] * len(inputs.poses)
        if self.find is not None:
            worths = sight * (hits + BASE_HIT)
            paths = np.maximum(inputs.distances, MIN_PATH_LENGTH)
            return assign_frontiers(inputs, lambda crowded: apply_crowding(worths, crowded) / paths)
        # The perceptron explains half of the variance; tours by both areas are shorter than by either.
        areas = np.where(areas < MIN_AREA, areas, areas ** (1 - SIGHT_WEIGHT) * sight**SIGHT_WEIGHT)
        worths = areas**WORTH_EXPONENT
        chosen: list[Frontier | None] = []
        assigned = np.zeros(len(areas), bool)
        for distances in inputs.distances:
            index = _choose_next(inputs, np.where(assigned, np.inf, distances), areas, worths)
            chosen.append(None if index is None else inputs.frontiers[index])
            if index is not None:
                # Frontiers within reach of a target are observed from there, so other robots gain less.
                gaps = np.hypot(*(inputs.points - inputs.points[index]).T)
                assigned[index] = True
                worths = np.where(gaps < inputs.reach, worths / 2, worths)
        return chosen

    def expect(self, inputs: PolicyInput) -> tuple[Floats, Floats, Floats]:
        """Area in sight and expected area, m², and P(wanted label) of each frontier, shape (frontiers,) each."""
        if self._expectations is None or inputs.recognised is None:
            targets = [frontier.target for frontier in inputs.frontiers]
            sight = measure_gains(inputs.cells, targets, reach=inputs.reach, resolution=inputs.resolution)
            sight = np.maximum(sight, MIN_SIGHT)
            return sight, np.maximum(sight, inputs.resolution**2), np.zeros(len(sight))
        measures, hits = measure_frontiers(inputs, self._expectations)
        sight = np.maximum(measures[:, MEASURES.index("in sight")] ** 2, MIN_SIGHT)
        return sight, np.maximum(expect_areas(measures), inputs.resolution**2), hits

    def expect_share(self, inputs: PolicyInput, areas: Floats) -> float:
        """The observed share of the floor, from the expected areas behind the frontiers."""
        observed = float(np.count_nonzero(inputs.cells == FREE)) * inputs.resolution**2
        return observed / (observed + float(areas.sum()))


def _choose_next(inputs: PolicyInput, distances: Floats, areas: Floats, worths: Floats) -> int | None:
    """The index of the next frontier of a robot; None if it can reach none."""
    possible = np.isfinite(distances)
    if not possible.any():
        return None
    worthy = possible & (areas >= MIN_AREA)
    chosen = np.flatnonzero(worthy if worthy.any() else possible)
    chosen = chosen[np.argsort(distances[chosen], kind="stable")][:MAX_TOUR_TARGETS]
    if len(chosen) == 1:
        return int(chosen[0])
    targets = np.array([inputs.frontiers[index].target for index in chosen])
    between = measure_distances_between(inputs.passable, targets, resolution=inputs.resolution)
    lengths = areas[chosen] / AREA_PER_METRE
    return int(chosen[choose_first_target(distances[chosen], between, worths[chosen], lengths)])
