"""The classical policies: the nearest frontier, and the most to see for the way.

Several robots share frontiers as in Burgard et al., 2005.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import inf, isfinite
from typing import Literal

import numpy as np

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.exploration.frontiers import Frontier
from pianta.exploration.gain import measure_gains
from pianta.exploration.situation import Situation

# A way counts as this long at least, m, or the frontier at the robot's feet would be worth more than any other.
SHORTEST_WAY = 1.0


def assign_frontiers(situation: Situation, score: Callable[[Floats], Floats]) -> list[Frontier | None]:
    """A frontier for each robot: again and again the best pair of both that are left (Burgard et al., 2005).

    score: from how crowded each frontier is, shape (frontiers,), the scores of all pairs, shape (robots, frontiers),
        more is better. Crowded are frontiers near one that another robot got: 1 at the same place, and less by its
        distance in reaches of the lidar.
    A robot that can reach none of those left gets None.
    """
    chosen: list[Frontier | None] = [None] * len(situation.poses)
    crowded = np.zeros(len(situation.frontiers))
    possible = np.isfinite(situation.distances)
    while possible.any():
        scores = np.where(possible, score(crowded), -inf)
        robot, target = np.unravel_index(int(np.argmax(scores)), scores.shape)
        chosen[robot] = situation.frontiers[target]
        possible[robot, :] = possible[:, target] = False
        apart = np.hypot(*(situation.points - situation.points[target]).T)
        crowded += np.maximum(1 - apart / situation.reach, 0)
    return chosen


class NearestFrontier:
    """The frontier with the shortest way (Yamauchi, 1997); with several robots, a reach further where it is crowded."""

    def choose(self, situation: Situation) -> list[Frontier | None]:
        """A frontier for each robot."""
        return assign_frontiers(situation, lambda crowded: -situation.distances - situation.reach * crowded)


@dataclass(frozen=True)
class InformationGain:
    """The frontier from which most of the unknown may be seen for the way there.

    The gain is the unknown area in sight of the target when nothing but known obstacles hides it. Its worth is divided
    by the way ("ratio", the shorter way to 90 % of a school), or multiplied by exp(-decay · way) ("exponential";
    González-Baños and Latombe, 2002; the shorter one to 99 %). decay: per metre. Where it is crowded, robots gain less.
    Raises OptionError for values without meaning.
    """

    worth: Literal["ratio", "exponential"] = "ratio"
    decay: float = 0.2

    def __post_init__(self) -> None:
        if self.worth not in {"ratio", "exponential"}:
            raise OptionError(f"worth is {self.worth!r}, give 'ratio' or 'exponential'")
        if not (isfinite(self.decay) and self.decay >= 0):
            raise OptionError(f"decay is {self.decay}, give 0 or more per metre")

    def choose(self, situation: Situation) -> list[Frontier | None]:
        """A frontier for each robot."""
        gains = measure_gains(
            situation.known,
            [frontier.target for frontier in situation.frontiers],
            reach=situation.reach,
            resolution=situation.resolution,
        )
        # A frontier without gain is still better than none.
        gains = np.maximum(gains, situation.resolution**2)
        return assign_frontiers(situation, partial(self._score, gains, situation.distances))

    def _score(self, gains: Floats, distances: Floats, crowded: Floats) -> Floats:
        left = gains * np.maximum(1 - crowded, 0.01)
        if self.worth == "ratio":
            return np.asarray(left / np.maximum(distances, SHORTEST_WAY))
        # The logarithm: products of far frontiers would be 0.
        return np.asarray(np.log(left) - self.decay * distances)
