"""The map of a floor from its points: walls where points stand above each other, free where there is floor."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing

from pianta._types import Floats, Mask
from pianta.errors import MapError
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.io._files import MAX_CELLS, check_cell_count, short_repr
from pianta.io.point_clouds import PointFile, open_points

DEFAULT_RESOLUTION = 0.05  # metres per cell
MAX_METRES = 10_000.0  # from zero; larger coordinates are of the earth and need double care


@dataclass(frozen=True, kw_only=True)
class CloudParameters:
    """Heights in metres, above the floor except where noted; chosen by hand, no fit is on record."""

    bin: float = 0.05  # of the histogram of heights
    min_peak: float = 0.2  # points at the height of the floor, as a share of those at the most frequent height
    above_peak: float = 0.2  # the floor is the most frequent height from the lowest peak up to this
    floor_band: float = 0.15  # points of the floor are up to this far from it
    lowest: float = 0.3  # points of walls, from here
    highest: float = 1.9  # to here, below the top of doors
    min_extent: float = 0.8  # between the lowest and the highest point in a cell of a wall


CLOUD = CloudParameters()


def read_cloud_map(path: str | Path, *, resolution: float = DEFAULT_RESOLUTION, max_cells: int = MAX_CELLS) -> GridMap:
    """Map of one floor from a PCD or PLY, z up, in metres.

    A cell is occupied if its points between 0.3 and 1.9 m above the floor span at least 0.8 m; free if it has points
    of the floor, or lies between such cells; else unknown. Furniture that is lower leaves no trace.

    Raises MapError, in one line, for a file that is damaged, has no walls or is larger than max_cells.
    """
    points = open_points(path)
    name = f"map {short_repr(path)}"
    floor = find_floor_height(points)
    low, high = find_extent(points, floor)
    if not np.isfinite(np.concatenate([low, high])).all():
        raise MapError(f"{name} has no points up to {CLOUD.highest} m above its floor, at z = {floor:.2f} m; turn z up")
    first = np.floor(low / resolution).astype(int)
    width, height = (np.floor(high / resolution).astype(int) - first + 1).tolist()
    check_cell_count((height, width), name, max_cells=max_cells)
    is_floor, is_wall = find_cells(points, floor, first, (height, width), resolution)
    if not is_wall.any():
        raise MapError(f"{name} has no walls above its floor, at z = {floor:.2f} m; give a floor with z up, in metres")
    cells = np.full((height, width), UNKNOWN, np.int8)
    cells[binary_closing(is_floor, np.ones((3, 3)))] = FREE
    cells[is_wall] = OCCUPIED
    x, y = (first * resolution).tolist()
    return GridMap(np.flipud(cells).copy(), resolution, (x, y, 0.0), Path(path).name)


def find_floor_height(points: PointFile) -> float:
    """The height of the floor: the lowest at which there are many points, metres."""
    counts: dict[int, int] = {}
    for block in points.iterate_blocks():
        if np.abs(block).max(initial=0) > MAX_METRES:
            raise MapError(
                f"map {short_repr(points.path)} has points farther than {MAX_METRES:.0f} m from 0, move them"
            )
        bins, numbers = np.unique(np.floor(block[:, 2] / CLOUD.bin).astype(int), return_counts=True)
        for each, number in zip(bins.tolist(), numbers.tolist(), strict=True):
            counts[each] = counts.get(each, 0) + number
    if not counts:
        raise MapError(f"map {short_repr(points.path)} has no point with finite coordinates")
    peak = min(each for each, number in counts.items() if number >= CLOUD.min_peak * max(counts.values()))
    near = [each for each in counts if peak <= each <= peak + CLOUD.above_peak / CLOUD.bin]
    return (max(near, key=lambda each: counts[each]) + 0.5) * CLOUD.bin


def find_extent(points: PointFile, floor: float) -> tuple[Floats, Floats]:
    """The lowest and the highest x, y of the points of floor and walls; infinite without any."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for block in points.iterate_blocks():
        above = block[:, 2] - floor
        inside = block[(above > -CLOUD.floor_band) & (above < CLOUD.highest), :2]
        low, high = (
            np.minimum(low, inside.min(axis=0, initial=np.inf)),
            np.maximum(high, inside.max(axis=0, initial=-np.inf)),
        )
    return low, high


def find_cells(
    points: PointFile, floor: float, first: NDArray[np.int_], shape: tuple[int, int], resolution: float
) -> tuple[Mask, Mask]:
    """Cells with points of the floor, and cells of walls, shape (H, W), row 0 at the lowest y.

    first: column and row of the first cell.
    """
    size = shape[0] * shape[1]
    is_floor = np.zeros(size, bool)
    lowest, highest = np.full(size, np.inf, np.float32), np.full(size, -np.inf, np.float32)
    for block in points.iterate_blocks():
        above = block[:, 2] - floor
        inside = (above > -CLOUD.floor_band) & (above < CLOUD.highest)
        cols, rows = (np.floor(block[inside, :2] / resolution).astype(int) - first).T
        cells, above = rows * shape[1] + cols, above[inside].astype(np.float32)
        is_floor[cells[above < CLOUD.floor_band]] = True
        is_high = above > CLOUD.lowest
        np.minimum.at(lowest, cells[is_high], above[is_high])
        np.maximum.at(highest, cells[is_high], above[is_high])
    is_wall = highest - lowest >= CLOUD.min_extent
    return is_floor.reshape(shape), is_wall.reshape(shape)
