"""The result of an exploration, and its recorder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, inf

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.exploration.recognised_rooms import RECOGNISED_SHARE
from pianta.exploration.robots import Robot
from pianta.exploration.world import World
from pianta.gridmap import FREE, UNKNOWN, GridMap


@dataclass(frozen=True, eq=False)
class Exploration:
    """The result of an exploration, scan by scan.

    Attributes
    ----------
    distance
        Travelled by all robots together until each scan, metres, shape (scans,).
    area
        Observed part of the reachable area, m², shape (scans,).
    time
        Of each scan, seconds of driving and turning, shape (scans,).
    robot
        The index of the robot that made each scan, shape (scans,).
    robot_distance
        Travelled by each robot until each scan, metres, shape (scans, robots).
    tracks
        x, y, heading of each robot, metres and radians of the map frame, shape (its scans, 3).
    reachable_area
        The area that robots could observe, m².
    recognised_at, entered_at
        Room -> distance, metres, at which a fifth of it was observed, and at which a robot came in.
    map
        The final map.
    scan_of_cell
        The scan that first observed each cell, -1 for none, shape (H, W).
    outcome
        "done", "no reachable frontier", "found LABEL", "share reached", "stopped by the policy" or "distance limit".
    found_room
        The id of the room found by a search; with perception "map" that of the room on the robots' map, and after a
        search in vain that of the room which has the label most probably. None without one.
    found_probability
        The probability of the wanted label in this room, by the robots; None without one. The outcome says whether the
        search ended there.
    is_found_room_right
        Whether a true room of the wanted label is there, also if the room is just the likeliest one; None without a
        room, and where the truth has no label or just ROOM.
    decisions
        Number of decisions of the policy.
    """

    distance: Floats
    area: Floats
    time: Floats
    robot: NDArray[np.int_]
    robot_distance: Floats
    tracks: tuple[Floats, ...]
    reachable_area: float
    recognised_at: Mapping[int, float]
    entered_at: Mapping[int, float]
    map: GridMap
    scan_of_cell: NDArray[np.int32]
    outcome: str
    found_room: int | None = None
    found_probability: float | None = None
    is_found_room_right: bool | None = None
    decisions: int = 0

    @property
    def share(self) -> Floats:
        """Observed share of the reachable area at each scan, 0 … 1, shape (scans,)."""
        return self.area / self.reachable_area

    def distance_to(self, share: float) -> float:
        """The distance of all robots together until they have observed a share of the reachable area.

        Parameters
        ----------
        share
            From 0, the share before the first scan, to 1.

        Returns
        -------
        float
            Metres; inf if the share was never reached, as for a share above 1.
        """
        # The tolerance is for rounding errors of sums of cells.
        reached = np.flatnonzero(self.share >= share - 1e-9)
        return float(self.distance[reached[0]]) if len(reached) else inf

    def map_at(self, scan: int) -> GridMap:
        """The map that the robots had at a scan.

        Parameters
        ----------
        scan
            Its number, from 0.

        Returns
        -------
        GridMap
            The final map, in which cells that were observed later are unknown.

        Examples
        --------
        >>> import numpy as np
        >>> import pianta
        >>> run = pianta.explore(pianta.GridMap(np.zeros((20, 30), int), 0.1))
        >>> bool((run.map_at(len(run.area) - 1).cells == run.map.cells).all())
        True
        """
        is_observed = (self.scan_of_cell >= 0) & (self.scan_of_cell <= scan)
        return replace(self.map, cells=np.where(is_observed, self.map.cells, UNKNOWN))


@dataclass
class Record:
    """Records a run of robots in a world; area: the cells that count, shape (H, W). reach: of the lidar, metres."""

    world: World
    area: Mask
    robots: Sequence[Robot]
    reach: float
    recognised_at: dict[int, float] = field(default_factory=dict)
    entered_at: dict[int, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.scan_of_cell = np.full(self.world.blocked.shape, -1, np.int32)
        self.room_counts = np.zeros(len(self.world.room_cells), int)
        self.observed_cells = 0
        self.area_cells = int(np.count_nonzero(self.area))
        self._counted = np.zeros(self.world.blocked.shape, bool)
        self._rows: list[tuple[float, ...]] = []
        self._tracks: list[list[tuple[float, float, float]]] = [[] for _ in self.robots]

    @property
    def share(self) -> float:
        """Observed share of the area, 0 … 1."""
        return self.observed_cells / self.area_cells

    @property
    def distance(self) -> float:
        """Travelled by all robots together, metres."""
        return sum(robot.travelled for robot in self.robots)

    def list_positions(self) -> Floats:
        """x, y of all robots at all of their scans, metres of the map frame, shape (N, 2)."""
        return np.array([pose[:2] for track in self._tracks for pose in track], float).reshape(-1, 2)

    def add_scan(self, number: int, cells: NDArray[np.int8]) -> None:
        """Record a scan of the robot with this index; cells: the map with the scan."""
        robot = self.robots[number]
        row, col = self.world.cell(robot.pose.x, robot.pose.y)
        reach = ceil(self.reach / self.world.resolution) + 1
        window = slice(max(row - reach, 0), row + reach + 1), slice(max(col - reach, 0), col + reach + 1)
        scan_of_cell = self.scan_of_cell[window]
        scan_of_cell[(scan_of_cell < 0) & (cells[window] != UNKNOWN)] = len(self._rows)
        new = (cells[window] == FREE) & ~self._counted[window]
        self._counted[window] |= new
        self.observed_cells += int(np.count_nonzero(new & self.area[window]))
        self._add_rooms(self.world.room_of_cell[window][new], int(self.world.room_of_cell[row, col]))
        self._tracks[number].append(robot.pose)
        time = max(robot.time for robot in self.robots)
        area = self.observed_cells * self.world.resolution**2
        self._rows.append((self.distance, area, time, number, *(robot.travelled for robot in self.robots)))

    def _add_rooms(self, rooms: NDArray[np.uint16], here: int) -> None:
        """Count newly observed cells of rooms; here: the room of the robot, 0 for none."""
        added = np.bincount(rooms, minlength=len(self.room_counts))
        self.room_counts += added
        for room in np.flatnonzero(added[1:]) + 1:
            if self.room_counts[room] >= RECOGNISED_SHARE * self.world.room_cells[room]:
                self.recognised_at.setdefault(int(room), self.distance)
        if here:
            self.entered_at.setdefault(here, self.distance)

    def close(
        self, grid: GridMap, outcome: str, *, found_room: tuple[int, float, bool | None] | None, decisions: int
    ) -> Exploration:
        """The result of the run. found_room: its id, the probability of its label, and whether it is right."""
        room, probability, is_right = found_room or (None, None, None)
        rows = np.array(self._rows, float)
        return Exploration(
            distance=rows[:, 0],
            area=rows[:, 1],
            time=rows[:, 2],
            robot=rows[:, 3].astype(int),
            robot_distance=rows[:, 4:],
            tracks=tuple(np.array(track, float).reshape(-1, 3) for track in self._tracks),
            reachable_area=self.area_cells * self.world.resolution**2,
            recognised_at=dict(self.recognised_at),
            entered_at=dict(self.entered_at),
            map=grid,
            scan_of_cell=self.scan_of_cell,
            outcome=outcome,
            found_room=room,
            found_probability=probability,
            is_found_room_right=is_right,
            decisions=decisions,
        )
