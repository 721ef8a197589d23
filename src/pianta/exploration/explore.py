"""The exploration of an unknown world: scan, map, find frontiers, choose a target, drive; until none is left."""

from __future__ import annotations

import warnings
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np

from pianta._types import Floats, Mask
from pianta.errors import MapWarning, OptionError
from pianta.exploration.frontiers import MIN_LENGTH, Frontier, count_border, find_frontiers
from pianta.exploration.lidar import Lidar, Pose, scan
from pianta.exploration.occupancy import OccupancyGrid
from pianta.exploration.perception import Percept, Perception, WantedRoom
from pianta.exploration.perceptions import PERFECT, make_perception
from pianta.exploration.policies import make_policy
from pianta.exploration.policy_input import Policy, PolicyInput
from pianta.exploration.record import Exploration, Record
from pianta.exploration.robots import DRIVES, Robot
from pianta.exploration.routes import find_route, measure_distances, straighten_route
from pianta.exploration.starts import Point, find_starts, place_robots
from pianta.exploration.world import World, as_world, clear_cells, explorable_cells, reachable_cells
from pianta.floor import Floor
from pianta.gridmap import FREE, OCCUPIED, GridMap
from pianta.labels import standard_name

if TYPE_CHECKING:
    from pianta.mapping.mapper import Mapper

# All values were chosen by hand.
# A target is dropped when no cell of its frontier this near to it borders on the unknown any more; m.
TARGET_RADIUS = 1.0
# When a robot has arrived, the cells of the frontier this near to it no longer count; m.
GIVE_UP_RADIUS = 0.5
# The default of max_distance: metres for each m² of reachable area, and metres besides.
MAX_DISTANCE_PER_AREA = 5.0
MIN_MAX_DISTANCE = 200.0
MAX_ROBOTS = 100


@dataclass(frozen=True)
class Settings:
    """The options of a run, see `explore`; lengths in metres. stop: a share, None for all."""

    lidar: Lidar
    radius: float
    drive: str
    step: float
    stop: float | None
    max_distance: float
    min_length: float


def explore(
    world: World | Floor | GridMap | str | Path,
    policy: Policy | str = "nearest",
    *,
    starts: Sequence[Point] | None = None,
    lidar: Lidar | None = None,
    robots: int = 1,
    radius: float = 0.2,
    drive: str = "point",
    step: float = 0.5,
    stop: float | str = "all",
    find: str | None = None,
    perception: str | Mapper = PERFECT,
    max_distance: float | None = None,
    min_length: float = MIN_LENGTH,
    seed: int = 0,
    track: Callable[[float], None] | None = None,
) -> Exploration:
    """Explore a world with simulated robots that share a map; a policy chooses their targets.

    The command `pianta explore` calls this function. The policy decides again when a robot has arrived, and when
    nothing unknown is left at its target.

    Parameters
    ----------
    world
        A floor, a grid map, a world, the file of one of them, or a floor type of `make_world`.
    policy
        How the next frontier is chosen: "nearest", "gain", "gain-exp" or "predicted", or an object with `choose`.
    starts
        Points x, y of robots, metres of the map frame; None for the entrance. Further robots start beside them.
    lidar
        Of every robot; None for 360 beams of 8 m.
    robots
        The number of robots.
    radius
        Of every robot, metres.
    drive
        "point" moves in any direction at once, "differential" turns first.
    step
        Metres driven between two scans.
    stop
        The observed share of the reachable area at which the run ends, 0 … 1; "all" until no frontier is left.
    find
        A label; the run ends when a room with it is recognised: a robot is inside, or a fifth of it is observed. With
        perception "map" it ends when the robots' own map has a room that it labels so with a probability of a half,
        which may be wrong; else the mapper reads the last map to its end, and the result has the likeliest room.
    perception
        What the policy and a search learn of rooms: "perfect" for the true ones, as in the thesis; "map" for what is
        read from the map every few metres; or a Mapper, which reads it so, and may know the building's type.
    max_distance
        Of all robots together, metres; None to derive it from the area, so that every run ends.
    min_length
        Shorter frontiers are ignored, metres.
    seed
        Of the noise of the lidars, and of a synthetic world.
    track
        Called with the observed share of the area after every scan.

    Returns
    -------
    Exploration
        The map, the tracks, and the observed area over the distance.

    Raises
    ------
    OptionError
        A start is in a wall, no room has or can have the label, or a value makes no sense.

    Warns
    -----
    MapWarning
        Rooms that no robot can reach.

    References
    ----------
    M. Luperto, PhD thesis, section 8.3.

    Examples
    --------
    >>> import pianta
    >>> from shapely import LineString, box
    >>> rooms = (pianta.Room(1, box(0, 0, 4, 3)), pianta.Room(2, box(4, 0, 8, 3)))
    >>> floor = pianta.Floor(rooms, (pianta.Door((1, 2), LineString([(4, 1), (4, 2)]), 1.0),))
    >>> run = pianta.explore(floor)
    >>> run.outcome, float(run.share[-1])
    ('done', 1.0)
    """
    if seed < 0:
        raise OptionError(f"cannot explore: seed is {seed}, give 0 or more")
    world = as_world(world, seed=seed)
    policy = make_policy(policy, find=find) if isinstance(policy, str) else policy
    _check_options(robots=robots, radius=radius, drive=drive, step=step, stop=stop, max_distance=max_distance)
    perceived, wanted = make_perception(perception, world), None if find is None else standard_name(find)
    if wanted is not None:
        perceived.check_label(wanted)
    if starts is None or not len(starts):
        starts = find_starts(world, radius=radius)[:1]
    points = place_robots(world, starts, robots, radius=radius)
    reachable = reachable_cells(world, [world.cell(*point) for point in points], radius=radius)
    area = explorable_cells(world, reachable, radius=radius)
    _warn_of_unreachable(world, reachable)
    longest = MAX_DISTANCE_PER_AREA * np.count_nonzero(area) * world.resolution**2 + MIN_MAX_DISTANCE
    settings = Settings(
        lidar=lidar or Lidar(),
        radius=radius,
        drive=drive,
        step=step,
        stop=None if stop == "all" else float(stop),
        max_distance=longest if max_distance is None else max_distance,
        min_length=min_length,
    )
    run = _Run(
        world,
        policy,
        settings,
        perceived,
        points=points,
        area=area,
        wanted=wanted,
        seed=seed,
        track=track,
    )
    return run.explore()


class _Run:
    """The state of a run."""

    def __init__(
        self,
        world: World,
        policy: Policy,
        settings: Settings,
        perception: Perception,
        *,
        points: Sequence[Point],
        area: Mask,
        wanted: str | None,
        seed: int,
        track: Callable[[float], None] | None,
    ) -> None:
        self.world, self.policy, self.settings, self.wanted = world, policy, settings, wanted
        self.perception = perception
        self.robots = [Robot(Pose(*point), settings.drive) for point in points]
        self.map = OccupancyGrid(world)
        self.given_up = np.zeros(world.blocked.shape, bool)
        self.record = Record(world, area, self.robots, settings.lidar.reach)
        self.rng, self.track = np.random.default_rng(seed), track
        self.decisions = 0

    def explore(self) -> Exploration:
        """Run until one of the ends."""
        for number in range(len(self.robots)):
            self._scan(number)
        outcome = self._find_outcome()
        while outcome is None:
            if any(self._needs_goal(robot) for robot in self.robots):
                outcome = self._decide()
            for number, robot in enumerate(self.robots):
                if outcome is None and robot.goal is not None:
                    robot.advance(self.settings.step)
                    self._scan(number)
                    outcome = self._find_outcome()
        grid = self.map.to_grid_map()
        room = self._find_wanted_room()
        if room is None and self.wanted is not None:
            room = self.perception.find_likeliest_room(self.wanted, grid)
        found_room = None if room is None else (room.id, room.probability, room.is_right)
        return self.record.close(grid, outcome, found_room=found_room, decisions=self.decisions)

    def _scan(self, number: int) -> None:
        """Add a scan of a robot at its pose."""
        pose, lidar = self.robots[number].pose, self.settings.lidar
        self.map.add_scan(pose, lidar, scan(self.world, pose, lidar, self.rng))
        self.record.add_scan(number, self.map.cells)
        if self.track:
            self.track(self.record.share)

    def _find_outcome(self) -> str | None:
        """Why the run has ended; None if it has not."""
        if (room := self._find_wanted_room()) is not None:
            return f"found {room.label}"
        if self.settings.stop is not None and self.record.share >= self.settings.stop:
            return "share reached"
        return "distance limit" if self.record.distance >= self.settings.max_distance else None

    def _find_wanted_room(self) -> WantedRoom | None:
        """A room of the wanted label that was recognised."""
        return None if self.wanted is None else self.perception.find_room(self.wanted, self.record)

    def _needs_goal(self, robot: Robot) -> bool:
        """Whether a robot has arrived, or its target is no frontier any more, or cannot be reached."""
        goal = robot.goal
        if goal is None:
            return len(self.robots) == 1 or all(other.goal is None for other in self.robots)
        if not robot.route:
            self._give_up(robot, goal)
            return True
        near = np.hypot(*(goal.cells - goal.target).T) * self.world.resolution <= TARGET_RADIUS
        return count_border(self.map.cells, goal.cells[near]) == 0 or self._is_barred(robot)

    def _is_barred(self, robot: Robot) -> bool:
        """Whether a mapped obstacle is on the next step of a robot."""
        x, y = robot.route[0]
        here = np.array(robot.pose[:2])
        length = float(np.hypot(*(np.array([x, y]) - here)))
        ahead = min(length, self.settings.step)
        samples = np.arange(0, ahead + self.world.resolution, self.world.resolution / 2).clip(max=ahead)
        points = here + samples[:, None] * ((np.array([x, y]) - here) / max(length, 1e-9))
        rows, cols = np.floor(self.world.grid.map_to_pixel(points[:, 0], points[:, 1])).astype(int)
        return bool((self.map.cells[rows, cols] == OCCUPIED).any())

    def _give_up(self, robot: Robot, goal: Frontier) -> None:
        """Ignore the cells of a frontier near a robot that has arrived: it will observe no more there."""
        points = np.array(self.world.pixel(*robot.pose[:2]))
        near = np.hypot(*(goal.cells + 0.5 - points).T) * self.world.resolution <= GIVE_UP_RADIUS
        self.given_up[tuple(goal.cells[near].T)] = True
        self.given_up[goal.target] = True

    def _decide(self) -> str | None:
        """Assign targets by the policy; return the outcome if the room is found, or no robot gets a target."""
        percept = self.perception.perceive(self.map.to_grid_map(), self.record)
        if self._find_wanted_room() is not None:
            return self._find_outcome()
        radius_px = self.settings.radius / self.world.resolution
        cells = self.map.cells
        passable = (cells == FREE) & clear_cells(cells == OCCUPIED, radius_px)
        distances, frontiers = self._reach_frontiers(passable)
        if not frontiers:
            # Walls that were mapped after a robot had passed can leave it no way back but the one that it came
            passable |= self._list_driven() & (cells == FREE)
            distances, frontiers = self._reach_frontiers(passable)
        if not frontiers:
            return "no reachable frontier" if self._find_frontiers(cells == FREE) else "done"
        goals = self.policy.choose(self._describe(frontiers, distances, passable, percept))
        self.decisions += 1
        for robot, goal, lengths in zip(self.robots, goals, distances, strict=True):
            robot.goal, robot.route = goal, deque()
            if goal is not None:
                robot.route = self._plan(lengths, goal.target)
        return None if any(goal is not None for goal in goals) else "stopped by the policy"

    def _reach_frontiers(self, passable: Mask) -> tuple[list[Floats], list[Frontier]]:
        """Path length from each robot to each cell, and the frontiers that a robot can reach over these cells."""
        distances = [self._measure_distances(robot, passable) for robot in self.robots]
        reachable = np.logical_or.reduce([np.isfinite(lengths) for lengths in distances])
        return distances, self._find_frontiers(reachable)

    def _list_driven(self) -> Mask:
        """The cells over which the middles of robots have driven, shape (H, W); 4-connected, as routes need."""
        driven = np.zeros(self.map.cells.shape, np.uint8)
        for robot in self.robots:
            # cv2 wants the middle of a cell at whole numbers, x before y
            pixels = np.array([self.world.pixel(*corner)[::-1] for corner in robot.corners]) - 0.5
            cv2.polylines(driven, [np.rint(pixels).astype(np.int32)], isClosed=False, color=1, lineType=cv2.LINE_4)
        return driven > 0

    def _find_frontiers(self, reachable: Mask) -> list[Frontier]:
        """The frontiers of the current map, without cells given up; reachable: shape (H, W), where robots can stand."""
        return find_frontiers(
            self.map.cells,
            reachable,
            resolution=self.world.resolution,
            min_length=self.settings.min_length,
            given_up=self.given_up,
        )

    def _measure_distances(self, robot: Robot, passable: Mask) -> Floats:
        """Path length from a robot to each cell; obstacles within its radius are noise and do not block it."""
        row, col = self.world.cell(robot.pose.x, robot.pose.y)
        if passable[row, col]:
            return measure_distances(passable, [(row, col)], resolution=self.world.resolution)
        reach = int(self.settings.radius / self.world.resolution) + 1
        window = slice(max(row - reach, 0), row + reach + 1), slice(max(col - reach, 0), col + reach + 1)
        original = passable[window].copy()
        passable[window] |= self.map.cells[window] == FREE
        passable[row, col] = True
        distances = measure_distances(passable, [(row, col)], resolution=self.world.resolution)
        passable[window] = original
        return distances

    def _plan(self, distances: Floats, target: tuple[int, int]) -> deque[Point]:
        """The corners, x, y, of the straightened route to a target."""
        route = find_route(distances, target, resolution=self.world.resolution)
        corners = straighten_route(route, np.isfinite(distances))
        points = [self.world.point((row, col)) for row, col in corners.tolist()]
        return deque(points[1:] or points)

    def _describe(
        self, frontiers: Sequence[Frontier], distances: Sequence[Floats], passable: Mask, percept: Percept
    ) -> PolicyInput:
        """The input of the policy."""
        rows, cols = np.array([frontier.target for frontier in frontiers]).T
        x, y = self.world.grid.pixel_to_map(rows + 0.5, cols + 0.5)
        in_rooms = [np.bincount(percept.room_of_cell[tuple(frontier.cells.T)]) for frontier in frontiers]
        cells = self.map.cells.view()
        cells.setflags(write=False)
        return PolicyInput(
            cells=cells,
            passable=passable,
            resolution=self.world.resolution,
            origin=self.world.origin,
            poses=tuple(robot.pose for robot in self.robots),
            frontiers=tuple(frontiers),
            distances=np.array([lengths[rows, cols] for lengths in distances]),
            points=np.column_stack([x, y]),
            rooms=tuple(int(counts.argmax()) for counts in in_rooms),
            reach=self.settings.lidar.reach,
            recognised=percept.recognised,
            travelled=self.record.distance,
            decision=self.decisions,
        )


def _check_options(
    *, robots: int, radius: float, drive: str, step: float, stop: str | float, max_distance: float | None
) -> None:
    """Raise OptionError that names every option out of range."""
    faults = [] if 1 <= robots <= MAX_ROBOTS else [f"robots are {robots}, give 1 … {MAX_ROBOTS}"]
    for name, value in (("radius", radius), ("step", step), ("max_distance", max_distance)):
        if value is not None and not (isfinite(value) and value > 0):
            faults.append(f"{name} is {value}, give positive metres")
    if drive not in DRIVES:
        faults.append(f"drive is {drive!r}, give one of {', '.join(DRIVES)}")
    if stop != "all" and not (isinstance(stop, float | int) and 0 < stop <= 1):
        faults.append(f"stop is {stop!r}, give a share above 0 and up to 1, or 'all'")
    if faults:
        raise OptionError("cannot explore: " + "; ".join(faults))


def _warn_of_unreachable(world: World, reachable: Mask) -> None:
    """Issue a MapWarning that names up to 10 rooms without a reachable cell; reachable: shape (H, W)."""
    if world.floor is None:
        return
    reached = set(np.unique(world.room_of_cell[reachable]).tolist())
    if rooms := [room for room in world.floor.rooms if room.id not in reached]:
        named = ", ".join(f"{room.id} {room.label or ''}".strip() for room in rooms[:10])
        named += ", …" if rooms[10:] else ""
        message = f"rooms {named} cannot be reached and are ignored: the robot fits through no door to them"
        warnings.warn(MapWarning(message), stacklevel=3)
