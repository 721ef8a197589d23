"""A simulated 2-D lidar in a world of cells."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, pi
from typing import NamedTuple

import numpy as np

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.exploration.beams import measure_ranges
from pianta.exploration.world import World


class Pose(NamedTuple):
    """The pose of a robot: x, y in metres of the map frame, heading in radians counter-clockwise from x."""

    x: float
    y: float
    heading: float = 0.0


@dataclass(frozen=True)
class Lidar:
    """A planar laser scanner.

    beams: number of beams, evenly over the field. reach: of a beam, metres. noise: standard deviation of a range,
    metres. field: of view, radians, centred on the heading.
    Raises OptionError, with all faults in one message, for values out of range.
    """

    beams: int = 360
    reach: float = 8.0
    noise: float = 0.01
    field: float = 2 * pi

    def __post_init__(self) -> None:
        faults = []
        if not 1 <= self.beams <= 100_000:
            faults.append(f"beams are {self.beams}, give 1 … 100000")
        if not (isfinite(self.reach) and self.reach > 0):
            faults.append(f"reach is {self.reach}, give positive metres")
        if not (isfinite(self.noise) and self.noise >= 0):
            faults.append(f"noise is {self.noise}, give metres, 0 or more")
        if not 0 < self.field <= 2 * pi:
            faults.append(f"field is {self.field}, give radians up to 2π")
        if faults:
            raise OptionError("not a lidar: " + "; ".join(faults))

    def angles(self, heading: float) -> Floats:
        """Directions of the beams in the map frame, radians, from right to left; half a gap is left at both ends."""
        return heading + self.field * ((np.arange(self.beams) + 0.5) / self.beams - 0.5)


def scan(world: World, pose: Pose, lidar: Lidar, rng: np.random.Generator) -> Floats:
    """Simulate a scan: ranges, shape (beams,), metres; inf if no obstacle is within reach."""
    beams = aim_beams(world, lidar.angles(pose.heading))
    origin = world.pixel(pose.x, pose.y)
    ranges = measure_ranges(world.blocked, origin, beams, lidar.reach / world.resolution) * world.resolution
    if lidar.noise:
        ranges = np.clip(ranges + rng.normal(0, lidar.noise, lidar.beams), 0, None)
        ranges[ranges >= lidar.reach] = inf
    return ranges


def aim_beams(world: World, angles: Floats) -> Floats:
    """Unit vectors row, col, shape (N, 2), of directions in the map frame, radians."""
    turned = angles - world.origin[2]
    return np.column_stack([-np.sin(turned), np.cos(turned)])
