"""A 2-D lidar in a world of cells: the range of each beam, found by walking the cells that it crosses."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, inf, isfinite, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.exploration.kernels import choose_kernel
from pianta.exploration.world import World


class Pose(NamedTuple):
    """Where a robot stands: x, y in metres of the map frame, heading in radians counter-clockwise from x."""

    x: float
    y: float
    heading: float = 0.0


@dataclass(frozen=True)
class Lidar:
    """A planar laser scanner.

    beams: evenly spread over the field. reach: of a beam, metres. noise: standard deviation of a range, metres.
    field: of view, radians, centred on the heading.
    Raises OptionError, with every fault in one message, for values without meaning.
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
        """Directions of the beams in the map frame, radians; the first is half a gap from the right end of the field.

        The middle of the field is the heading.
        """
        return heading + self.field * ((np.arange(self.beams) + 0.5) / self.beams - 0.5)


def scan(world: World, pose: Pose, lidar: Lidar, rng: np.random.Generator) -> Floats:
    """Ranges, shape (beams,), metres, that a lidar measures at a pose; inf where no obstacle is within its reach."""
    place = world.place(pose.x, pose.y)
    beams = aim_beams(world, lidar.angles(pose.heading))
    ranges = cast_rays(world.blocked, place, beams, lidar.reach / world.resolution) * world.resolution
    if lidar.noise:
        ranges = np.clip(ranges + rng.normal(0, lidar.noise, lidar.beams), 0, None)
        ranges[ranges >= lidar.reach] = inf
    return ranges


def aim_beams(world: World, angles: Floats) -> Floats:
    """Unit vectors row, col, shape (N, 2), of directions in the map frame, radians."""
    turned = angles - world.origin[2]
    return np.column_stack([-np.sin(turned), np.cos(turned)])


def cast_rays(blocked: NDArray[np.bool_], place: tuple[float, float], beams: Floats, reach_px: float) -> Floats:
    """Ranges in cells, shape (N,), from a place to the first blocked cell on each beam; inf beyond the reach.

    blocked: shape (H, W); what lies outside is blocked, too. place: continuous row, col.
    beams: unit vectors row, col, shape (N, 2).
    Every cell that a beam crosses is looked at (Amanatides and Woo, 1987).
    """
    cast = choose_kernel(walk_beams, walk_beams_together)
    return cast(blocked, float(place[0]), float(place[1]), beams, float(reach_px))


def walk_beams(blocked: NDArray[np.bool_], row0: float, col0: float, beams: Floats, reach: float) -> Floats:
    """One beam after the other; for numba."""
    height, width = blocked.shape
    ranges = np.full(len(beams), inf)
    for beam in range(len(beams)):
        down, right = beams[beam, 0], beams[beam, 1]
        row, col = floor(row0), floor(col0)
        next_row = (row + (down > 0) - row0) / down if down != 0 else inf
        next_col = (col + (right > 0) - col0) / right if right != 0 else inf
        way = 0.0
        while way < reach:
            if not (0 <= row < height and 0 <= col < width) or blocked[row, col]:
                ranges[beam] = way
                break
            if next_row < next_col:
                way = next_row
                next_row += abs(1 / down)
                row += 1 if down > 0 else -1
            else:
                way = next_col
                next_col += abs(1 / right)
                col += 1 if right > 0 else -1
    return ranges


def walk_beams_together(blocked: NDArray[np.bool_], row0: float, col0: float, beams: Floats, reach: float) -> Floats:
    """All beams a cell further at a time; for numpy."""
    ranges = np.full(len(beams), inf)
    walk = BeamWalk(row0, col0, beams)
    going = np.arange(len(beams))
    while going.size:
        going = going[walk.way[going] < reach]
        hit = _read_cells(blocked, walk.rows[going], walk.cols[going], outside=True)
        ranges[going[hit]] = walk.way[going[hit]]
        going = going[~hit]
        walk.step(going)
    return ranges


def _read_cells(
    mask: NDArray[np.bool_], rows: NDArray[np.int_], cols: NDArray[np.int_], *, outside: bool
) -> NDArray[np.bool_]:
    """Values of a mask at cells of which some may lie outside."""
    inside = (rows >= 0) & (rows < mask.shape[0]) & (cols >= 0) & (cols < mask.shape[1])
    values = np.full(len(rows), outside)
    values[inside] = mask[rows[inside], cols[inside]]
    return values


class BeamWalk:
    """The walk of many beams from one place over the cells that they cross, in numpy.

    rows, cols: the cell of each beam, shape (N,). way: how far from the place the beam enters it, cells.
    """

    def __init__(self, row0: float, col0: float, beams: Floats) -> None:
        self.way = np.zeros(len(beams))
        self.rows, self.cols = (np.full(len(beams), floor(start)) for start in (row0, col0))
        self._signs = np.where(beams > 0, 1, -1)
        edges = np.where(beams > 0, [floor(row0) + 1, floor(col0) + 1], [floor(row0), floor(col0)])
        # Beams along an axis, or next to it, never meet the edges of the other.
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            self._next = np.where(beams != 0, (edges - [row0, col0]) / beams, inf)
            self._gaps = np.where(beams != 0, np.abs(1 / beams), inf)

    def step(self, going: NDArray[np.int_]) -> None:
        """Move the beams with these numbers into their next cells."""
        downward = self._next[going, 0] < self._next[going, 1]
        for axis, cells, moving in ((0, self.rows, going[downward]), (1, self.cols, going[~downward])):
            self.way[moving] = self._next[moving, axis]
            self._next[moving, axis] += self._gaps[moving, axis]
            cells[moving] += self._signs[moving, axis]

    def leaves_at(self, going: NDArray[np.int_]) -> Floats:
        """How far from the place the beams with these numbers leave their cells, cells."""
        return np.asarray(self._next[going].min(axis=1))
