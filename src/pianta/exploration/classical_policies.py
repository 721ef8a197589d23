"""The classical policies: the nearest frontier, and the most unknown area for the path.

Several robots share frontiers as in Burgard et al., 2005.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite
from typing import Literal

import numpy as np

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.exploration.frontiers import Frontier
from pianta.exploration.gain import measure_gains
from pianta.exploration.policy_input import PolicyInput

# Lower limit of a path length in ratios, m; otherwise a frontier next to the robot beats any other. Chosen by hand.
MIN_PATH_LENGTH = 1.0
# Lower limit of the share of a worth that crowding leaves. Chosen by hand.
MIN_UNCROWDED_SHARE = 0.01


def assign_frontiers(inputs: PolicyInput, score: Callable[[Floats], Floats]) -> list[Frontier | None]:
    """Assign a frontier to each robot: repeatedly the best remaining pair (Burgard et al., 2005).

    score: from the crowding of each frontier, shape (frontiers,), the scores of all pairs, shape (robots, frontiers);
        more is better. Crowding grows by 1 at the target of another robot, and by less in proportion to the distance
        from it, to 0 at the reach of the lidar.
    A robot that can reach no remaining frontier gets None.
    """
    chosen: list[Frontier | None] = [None] * len(inputs.poses)
    crowding = np.zeros(len(inputs.frontiers))
    possible = np.isfinite(inputs.distances)
    while possible.any():
        scores = np.where(possible, score(crowding), -inf)
        robot, target = np.unravel_index(int(np.argmax(scores)), scores.shape)
        chosen[robot] = inputs.frontiers[target]
        possible[robot, :] = possible[:, target] = False
        gaps = np.hypot(*(inputs.points - inputs.points[target]).T)
        crowding += np.maximum(1 - gaps / inputs.reach, 0)
    return chosen


def apply_crowding(worths: Floats, crowding: Floats) -> Floats:
    """Reduce the worth of crowded frontiers, shape (frontiers,)."""
    return np.asarray(worths * np.maximum(1 - crowding, MIN_UNCROWDED_SHARE))


class NearestFrontier:
    """The frontier with the shortest path (Yamauchi, 1997); a fully crowded one counts as a reach further away."""

    def choose(self, inputs: PolicyInput) -> list[Frontier | None]:
        """Return a frontier for each robot."""
        return assign_frontiers(inputs, lambda crowding: -inputs.distances - inputs.reach * crowding)


@dataclass(frozen=True)
class InformationGain:
    """The frontier with most unknown area in sight for the path to it.

    The gain is the unknown area in sight of the target if only mapped obstacles hide it. The worth is the gain divided
    by the path length ("ratio", the shorter run to 90 % of a school), or multiplied by exp(-decay · length)
    ("exponential"; González-Baños and Latombe, 2002; the shorter run to 99 %). decay: per metre.
    Raises OptionError for values that make no sense.
    """

    worth: Literal["ratio", "exponential"] = "ratio"
    decay: float = 0.2

    def __post_init__(self) -> None:
        if self.worth not in {"ratio", "exponential"}:
            raise OptionError(f"worth is {self.worth!r}, give 'ratio' or 'exponential'")
        if not (isfinite(self.decay) and self.decay >= 0):
            raise OptionError(f"decay is {self.decay}, give 0 or more per metre")

    def choose(self, inputs: PolicyInput) -> list[Frontier | None]:
        """Return a frontier for each robot."""
        targets = [frontier.target for frontier in inputs.frontiers]
        gains = measure_gains(inputs.cells, targets, reach=inputs.reach, resolution=inputs.resolution)
        # A frontier without gain is still better than none.
        gains = np.maximum(gains, inputs.resolution**2)

        def score(crowding: Floats) -> Floats:
            left = apply_crowding(gains, crowding)
            if self.worth == "ratio":
                return np.asarray(left / np.maximum(inputs.distances, MIN_PATH_LENGTH))
            # The logarithm, because the product underflows for distant frontiers.
            return np.asarray(np.log(left) - self.decay * inputs.distances)

        return assign_frontiers(inputs, score)
