"""What came of an exploration, and its record while it runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil, inf

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.exploration.perception import SEEN_SHARE
from pianta.exploration.robots import Robot
from pianta.exploration.world import World
from pianta.gridmap import FREE, UNKNOWN, GridMap


@dataclass(frozen=True, eq=False)
class Exploration:
    """A run, scan by scan.

    Attributes
    ----------
    distance
        Travelled by all robots together at each scan, metres, shape (scans,).
    area
        Seen by then of the reachable area, m², shape (scans,).
    time
        When all robots had driven so far, seconds, shape (scans,).
    robot
        The number of the robot that made each scan, shape (scans,).
    robot_distance
        Travelled by each robot at each scan, metres, shape (scans, robots).
    tracks
        Of each robot x, y, heading, metres and radians of the map frame, shape (scans of it, 3).
    reachable_area
        All that could be seen, m².
    seen, entered
        Room -> distance, metres, at which a fifth of it had been seen, and at which a robot came in.
    map
        The final map.
    scan_of_cell
        The scan that first saw a cell, -1 for none, shape (H, W).
    outcome
        "done", "no reachable frontier", "found LABEL", "share reached", "stopped by the policy" or "distance limit".
    found
        The id of the room that was looked for, None when it was not found.
    decisions
        How often the policy was asked.
    """

    distance: Floats
    area: Floats
    time: Floats
    robot: NDArray[np.int_]
    robot_distance: Floats
    tracks: tuple[Floats, ...]
    reachable_area: float
    seen: Mapping[int, float]
    entered: Mapping[int, float]
    map: GridMap
    scan_of_cell: NDArray[np.int32]
    outcome: str
    found: int | None = None
    decisions: int = 0

    @property
    def share(self) -> Floats:
        """Share of the reachable area that had been seen at each scan, 0 … 1, shape (scans,)."""
        return self.area / self.reachable_area

    def distance_to(self, share: float) -> float:
        """The way of all robots together until a share of the reachable area was seen.

        Parameters
        ----------
        share
            From 0, the share before the first scan, to 1.

        Returns
        -------
        float
            Metres; inf when so much was never seen, as for a share above 1.
        """
        # Areas are sums of cells, a millionth of which is none.
        reached = np.flatnonzero(self.share >= share - 1e-9)
        return float(self.distance[reached[0]]) if len(reached) else inf


@dataclass
class Record:
    """The record of a run in a world, of which an area counts; the robots are those that are seen driving."""

    world: World
    area: Mask
    robots: Sequence[Robot]
    reach: float
    seen: dict[int, float] = field(default_factory=dict)
    entered: dict[int, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.scan_of_cell = np.full(self.world.blocked.shape, -1, np.int32)
        self.room_counts = np.zeros(len(self.world.room_cells), int)
        self.seen_cells = 0
        self.area_cells = int(np.count_nonzero(self.area))
        self._counted = np.zeros(self.world.blocked.shape, bool)
        self._rows: list[tuple[float, ...]] = []
        self._tracks: list[list[tuple[float, float, float]]] = [[] for _ in self.robots]

    @property
    def share(self) -> float:
        """Share of the area that was seen, 0 … 1."""
        return self.seen_cells / self.area_cells

    @property
    def distance(self) -> float:
        """Travelled by all robots together, metres."""
        return sum(robot.travelled for robot in self.robots)

    def add_scan(self, number: int, known: NDArray[np.int8]) -> None:
        """Take down what a robot, by its number, has seen; known: the map with its scan."""
        robot = self.robots[number]
        row, col = self.world.cell(robot.pose.x, robot.pose.y)
        reach = ceil(self.reach / self.world.resolution) + 1
        window = slice(max(row - reach, 0), row + reach + 1), slice(max(col - reach, 0), col + reach + 1)
        scan_of_cell = self.scan_of_cell[window]
        scan_of_cell[(scan_of_cell < 0) & (known[window] != UNKNOWN)] = len(self._rows)
        new = (known[window] == FREE) & ~self._counted[window]
        self._counted[window] |= new
        self.seen_cells += int(np.count_nonzero(new & self.area[window]))
        self._add_rooms(self.world.room_of_cell[window][new], int(self.world.room_of_cell[row, col]))
        self._tracks[number].append(robot.pose)
        times = max(robot.time for robot in self.robots)
        cells = self.seen_cells * self.world.resolution**2
        self._rows.append((self.distance, cells, times, number, *(robot.travelled for robot in self.robots)))

    def _add_rooms(self, rooms: NDArray[np.uint16], here: int) -> None:
        """Count newly seen cells of rooms, and note where a robot is."""
        added = np.bincount(rooms, minlength=len(self.room_counts))
        self.room_counts += added
        for room in np.flatnonzero(added[1:]) + 1:
            if self.room_counts[room] >= SEEN_SHARE * self.world.room_cells[room]:
                self.seen.setdefault(int(room), self.distance)
        if here:
            self.entered.setdefault(here, self.distance)

    def close(self, grid: GridMap, outcome: str, *, found: int | None, decisions: int) -> Exploration:
        """The exploration as it has ended."""
        rows = np.array(self._rows, float)
        return Exploration(
            distance=rows[:, 0],
            area=rows[:, 1],
            time=rows[:, 2],
            robot=rows[:, 3].astype(int),
            robot_distance=rows[:, 4:],
            tracks=tuple(np.array(track, float).reshape(-1, 3) for track in self._tracks),
            reachable_area=self.area_cells * self.world.resolution**2,
            seen=dict(self.seen),
            entered=dict(self.entered),
            map=grid,
            scan_of_cell=self.scan_of_cell,
            outcome=outcome,
            found=found,
            decisions=decisions,
        )
