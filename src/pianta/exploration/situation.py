"""What a policy knows when it decides where robots go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pianta.exploration.frontiers import Frontier
from pianta.exploration.lidar import Pose
from pianta.exploration.perception import Perception


@dataclass(frozen=True, eq=False)
class Situation:
    """A moment at which robots need somewhere to go.

    known: the map so far, shape (H, W), int8; -1 unknown, 0 free, 100 occupied. Not to be changed.
    passable: where a robot can stand, as far as it is known, shape (H, W).
    resolution, origin: metres per cell, and the frame, as in GridMap.
    poses: of the robots. frontiers: those that a robot can reach, one at least.
    distances: on foot from each robot to the target of each frontier, metres, shape (robots, frontiers); inf where no
        way leads.
    points: x, y of the targets of the frontiers, metres of the map frame, shape (frontiers, 2).
    rooms: for each frontier the id of the room that most of its cells lie in, 0 for none or where no floor is known.
    reach: of the lidar, metres. seen: the rooms that were recognised, None where no floor is known.
    travelled: by all robots so far, metres. decision: how many there were before.
    """

    known: NDArray[np.int8]
    passable: NDArray[np.bool_]
    resolution: float
    origin: tuple[float, float, float]
    poses: tuple[Pose, ...]
    frontiers: tuple[Frontier, ...]
    distances: NDArray[np.float64]
    points: NDArray[np.float64]
    rooms: tuple[int, ...]
    reach: float
    seen: Perception | None = None
    travelled: float = 0.0
    decision: int = 0


class Policy(Protocol):
    """Whoever tells robots where to go."""

    def choose(self, situation: Situation) -> list[Frontier | None]:
        """A frontier for each robot, of those that it can reach, or None where it should stay.

        No two robots get the same. A policy that leaves all of them at None ends the exploration: its advice to stop.
        """
        ...
