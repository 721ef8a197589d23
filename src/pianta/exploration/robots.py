"""A simulated robot: its pose, its target, and its drive."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from math import atan2, hypot, pi, remainder

from pianta.exploration.frontiers import Frontier
from pianta.exploration.lidar import Pose

DRIVES = ("point", "differential")

# m/s; chosen by hand, a slow indoor robot.
SPEED = 0.5
# rad/s on the spot; chosen by hand.
TURN_RATE = 1.0


@dataclass
class Robot:
    """A disc that follows a route of straight lines.

    drive: "point" moves in any direction at once; "differential" turns on the spot first, which takes time.
    goal: the frontier that it drives to, None while it waits. route: the next corners x, y, metres of the map frame.
    travelled: metres. time: of driving and turning, seconds. corners: x, y, where it began and ended each straight line
    so far.
    """

    pose: Pose
    drive: str = "point"
    goal: Frontier | None = None
    route: deque[tuple[float, float]] = field(default_factory=deque)
    travelled: float = 0.0
    time: float = 0.0
    corners: list[tuple[float, float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.corners.append(self.pose[:2])

    def advance(self, step: float) -> None:
        """Follow the route for `step` metres, or to its end."""
        left = step
        while self.route and left > 0:
            x, y = self.route[0]
            length = hypot(x - self.pose.x, y - self.pose.y)
            if length > 0:
                self._turn(atan2(y - self.pose.y, x - self.pose.x))
            share = 1.0 if length <= left else left / length
            here = self.pose
            self.pose = Pose(here.x + share * (x - here.x), here.y + share * (y - here.y), here.heading)
            if share == 1:
                self.pose = Pose(x, y, here.heading)
                self.route.popleft()
            self.corners.append(self.pose[:2])
            moved = min(length, left)
            left -= moved
            self.travelled += moved
            self.time += moved / SPEED

    def _turn(self, heading: float) -> None:
        if self.drive == "differential":
            self.time += abs(remainder(heading - self.pose.heading, 2 * pi)) / TURN_RATE
        self.pose = self.pose._replace(heading=heading)
