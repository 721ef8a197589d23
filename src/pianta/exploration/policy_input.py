"""The input of a policy, and the interface of policies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.exploration.frontiers import Frontier
from pianta.exploration.lidar import Pose
from pianta.exploration.recognised_rooms import RecognisedRooms


@dataclass(frozen=True, eq=False)
class PolicyInput:
    """The state of an exploration when robots need new targets.

    cells: the map, shape (H, W), int8, read-only; -1 unknown, 0 free, 100 occupied.
    passable: mapped cells where a robot can stand, shape (H, W).
    resolution, origin: metres per cell, and the frame, as in GridMap.
    poses: of the robots. frontiers: those that a robot can reach, at least one.
    distances: path length from each robot to the target of each frontier, metres, shape (robots, frontiers); inf
        without a path.
    points: x, y of the targets of the frontiers, metres of the map frame, shape (frontiers, 2).
    rooms: for each frontier the id of the room with most of its cells; 0 for no room, and without a floor.
    reach: of the lidar, metres. recognised: the recognised rooms, None without a floor.
    travelled: by all robots until now, metres. decision: number of earlier decisions.
    """

    cells: NDArray[np.int8]
    passable: Mask
    resolution: float
    origin: tuple[float, float, float]
    poses: tuple[Pose, ...]
    frontiers: tuple[Frontier, ...]
    distances: Floats
    points: Floats
    rooms: tuple[int, ...]
    reach: float
    recognised: RecognisedRooms | None = None
    travelled: float = 0.0
    decision: int = 0


class Policy(Protocol):
    """Chooses the next frontier of each robot."""

    def choose(self, inputs: PolicyInput) -> list[Frontier | None]:
        """Return a frontier for each robot, of those that it can reach, or None if it should stay.

        No two robots get the same frontier. If all of them get None, the exploration ends.
        """
        ...
