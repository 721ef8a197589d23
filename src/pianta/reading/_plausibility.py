"""Plausibility of maps: signs of a wrong resolution or inverted greys, or that a map shows no building.

The thresholds were chosen by hand between what the real maps in the data have (14 of robots, 15 with clutter or of
vacuum robots, 38 growing ones, those of the survey) and drawn bad ones (random cells, caves, outdoor maps, wrong
resolutions).
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Mask
from pianta.floor import DOOR_WIDTH, Floor
from pianta.gridmap import GridMap
from pianta.layout._label_images import grow_mask

# Cells along a side of the part of a map that is examined, at most; a limit of time.
MAX_SIDE = 4000
# Median area of rooms below which the resolution is implausible (2.2 m² on real maps, at least); m².
MIN_ROOM_AREA = 1.5
# Median width of doors below which it is implausible (0.45 m on real maps, at least); metres.
MIN_DOOR_WIDTH = 0.35
# Number of doors whose median counts as too narrow.
MIN_DOORS = 5
# Median width of doors, and area of rooms, from which it is implausible (3.0 m, 43 m² in a warehouse); metres and m².
MAX_DOOR_WIDTH = 3.0
MAX_ROOM_AREA = 200.0
# Inverted greys: more than this share of the known cells is occupied, ...
MIN_OCCUPIED_SHARE = 0.5
# ... and nearly all free cells are nearer than this to an occupied or unknown one, as those of walls are; metres.
MAX_WALL_CLEARANCE = 0.15
# Distance from obstacles that nearly all free cells keep below, under which a resolution is implausible (0.53 m on real
# maps, at least, and 0.45 m in an arena of 2 m); metres.
MIN_REACH = 0.4
# Share of the free cells that counts as nearly all.
NEARLY_ALL = 0.95
# Share of unknown cells below which a map counts as one without any.
MAX_UNKNOWN_SHARE = 0.01
# Share of the cells at the edge of a map that are free where it has no outside.
OPEN_EDGE_SHARE = 0.5
# Share of the edge of the free space that has no obstacle near (0.56 on real maps, at most).
MAX_FRONTIER_SHARE = 0.7
# Obstacles at most this far from free cells are at them; metres.
NEAR_DISTANCE = 0.25
# Obstacles with a smaller diagonal are scattered pieces, as furniture is; metres.
PIECE_SIZE = 1.5
# Obstacle courses: at least this share of the occupied cells is in such pieces (0.72 on real maps, at most), ...
MIN_SCATTERED_SHARE = 0.85
# ... of which there are at least these, ...
MIN_PIECES = 30
# ... and at least these per m² of free space.
MIN_PIECE_DENSITY = 1.0
# Pairs of rooms that doors join, per room, from a number of rooms on, that make a floor a mesh (1.3 on real maps,
# at most).
MAX_PAIRS_PER_ROOM = 1.6
MIN_MESH_ROOMS = 8
# Share of rooms without a door, from a number of rooms on, that makes a floor no building (0.8 of 10 on a real map).
MAX_DOORLESS_SHARE = 0.7
MIN_DOORLESS_ROOMS = 20

NO_BUILDING = "so it may show no building, and rooms and doors mean little"


def describe_implausible_reading(floor: Floor, grid: GridMap) -> Iterator[str]:
    """What is implausible about a map and its floor; messages that continue the name of the map."""
    messages = [*describe_implausible_map(grid)]
    # The sizes of rooms in what is no building mean nothing
    yield from messages or [*_describe_resolution(floor, grid.resolution)] or describe_narrow_map(grid)
    yield from describe_implausible_floor(floor, grid)


def describe_implausible_map(grid: GridMap) -> Iterator[str]:
    """What is implausible about a map itself."""
    part = _crop_to_known(grid)
    if inverted := [*describe_inverted_greys(grid)]:
        yield from inverted
    elif _has_scattered_obstacles(part, grid.resolution):
        yield f"its obstacles are small and scattered like those of an obstacle course, {NO_BUILDING}"
    elif (share := _measure_frontier_share(part, grid.resolution)) > MAX_FRONTIER_SHARE:
        yield (
            f"{share:.0%} of the edge of its free space has no wall, as outdoors, {NO_BUILDING}; "
            "if the robot has not finished, read the map again when it has seen more"
        )


def describe_narrow_map(grid: GridMap) -> Iterator[str]:
    """The message for a map whose free space is too narrow for a robot."""
    reach = _measure_reach(_crop_to_known(grid), grid.resolution)
    if reach < MIN_REACH:
        yield (
            f"its resolution of {grid.resolution:g} m per cell is implausible, as nearly all of its free space is less "
            f"than {reach:.2g} m from an obstacle; check it: most robots' maps have 0.05 m"
        )


def describe_inverted_greys(grid: GridMap) -> Iterator[str]:
    """The message for a map whose greys are probably inverted."""
    part = _crop_to_known(grid)
    if _is_inverted(part, grid.resolution):
        yield (
            f"{part.occupied_share:.0%} of its known cells are occupied, and the free ones are as thin as walls, so "
            "its greys are probably inverted; change negate in the map.yaml, or invert the image"
        )


def describe_implausible_floor(floor: Floor, grid: GridMap) -> Iterator[str]:
    """What is implausible about the rooms and doors of a map."""
    rooms, pairs = len(floor.rooms), len({door.rooms for door in floor.doors if door.joins_rooms})
    with_doors = {room_id for door in floor.doors for room_id in door.room_ids}
    doorless = sum(room.id not in with_doors for room in floor.rooms)
    if rooms >= MIN_DOORLESS_ROOMS and doorless >= MAX_DOORLESS_SHARE * rooms:
        yield f"{doorless} of its {rooms} rooms have no door, {NO_BUILDING}; or its doors are shut"
    elif rooms >= MIN_MESH_ROOMS and pairs >= MAX_PAIRS_PER_ROOM * rooms:
        yield f"doors join {pairs} pairs of its {rooms} rooms, as in caves and obstacle courses, {NO_BUILDING}"
    if outside := _find_outside_rooms(floor, grid):
        names = f"room{'s' * (len(outside) > 1)} {' '.join(map(str, outside))}"
        yield (
            f"it has no unknown cells and its edge is free, so what lies outside is read as {names}; "
            "draw it in the grey of unknown, 205"
        )


def _describe_resolution(floor: Floor, resolution: float) -> Iterator[str]:
    """The message for an implausible resolution, metres per cell, by the sizes of rooms and doors."""
    area = float(np.median([room.polygon.area for room in floor.rooms]))
    widths = [door.width for door in floor.doors if door.joins_rooms]
    width = float(np.median(widths)) if widths else None
    measures = []
    if area < MIN_ROOM_AREA or (area >= MAX_ROOM_AREA and width is not None and width >= MAX_DOOR_WIDTH):
        measures.append(f"rooms of {area:.2g} m²" if area < MIN_ROOM_AREA else f"rooms of {area:.0f} m²")
    is_narrow = width is not None and width < MIN_DOOR_WIDTH and len(widths) >= MIN_DOORS
    if width is not None and (is_narrow or measures):
        measures.append(f"doors of {width:.2g} m")
    if not measures:
        return
    remedy = "check it"
    if width is not None:
        remedy += f": if doors are {DOOR_WIDTH} m wide, it is some {resolution * DOOR_WIDTH / width:.2g} m"
    yield (
        f"its resolution of {resolution:g} m per cell is implausible, as it gives {' and '.join(measures)} (medians); "
        f"{remedy}"
    )


class _KnownPart:
    """The cells around the free space of a map. free, occupied: shape (H, W)."""

    def __init__(self, free: Mask, occupied: Mask) -> None:
        self.free = free
        self.occupied = occupied

    @property
    def occupied_share(self) -> float:
        """Share of the known cells that are occupied."""
        occupied = float(self.occupied.sum())
        return occupied / max(1.0, occupied + float(self.free.sum()))


def _crop_to_known(grid: GridMap) -> _KnownPart:
    """The part of a map that has free cells; of a large one the middle."""
    free = grid.free
    window = []
    for axis in (1, 0):
        cells = np.flatnonzero(free.any(axis=axis))
        first, last = (int(cells[0]), int(cells[-1])) if len(cells) else (0, 0)
        margin = max(0, last - first + 1 - MAX_SIDE) // 2
        window.append(slice(max(0, first + margin - 1), last - margin + 2))
    rows, cols = window
    return _KnownPart(free[rows, cols], grid.occupied[rows, cols])


def _is_inverted(part: _KnownPart, resolution: float) -> bool:
    """Whether a map is mostly occupied, and its free cells are as thin as walls."""
    if part.occupied_share <= MIN_OCCUPIED_SHARE or not part.free.any():
        return False
    thin, depth = _measure_reach(part, resolution), _measure_clearance(part.occupied)[part.occupied] * resolution
    return thin <= max(MAX_WALL_CLEARANCE, 2 * resolution) and float(np.median(depth)) > 2 * thin


def _measure_reach(part: _KnownPart, resolution: float) -> float:
    """Distance to the nearest obstacle or unknown cell that nearly all free cells keep below, metres."""
    if not part.free.any():
        return float("inf")
    return float(np.quantile(_measure_clearance(part.free)[part.free], NEARLY_ALL)) * resolution


def _measure_clearance(mask: Mask) -> NDArray[np.float32]:
    """Distance of each cell to the nearest one that is False or beyond the map, shape (H, W), in cells."""
    padded = np.pad(mask, 1).astype(np.uint8)
    return np.asarray(cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1])


def _has_scattered_obstacles(part: _KnownPart, resolution: float) -> bool:
    """Whether nearly all obstacles are small pieces, and there are many of them."""
    _, _, stats, _ = cv2.connectedComponentsWithStats(part.occupied.astype(np.uint8), connectivity=8)
    pieces = stats[1:]
    diagonal = np.hypot(pieces[:, cv2.CC_STAT_WIDTH], pieces[:, cv2.CC_STAT_HEIGHT]) * resolution
    is_small, cells = diagonal < PIECE_SIZE, pieces[:, cv2.CC_STAT_AREA]
    count, area = np.count_nonzero(is_small), np.count_nonzero(part.free) * resolution**2
    return bool(
        count >= max(MIN_PIECES, MIN_PIECE_DENSITY * area)
        and cells[is_small].sum() >= MIN_SCATTERED_SHARE * cells.sum()
    )


def _measure_frontier_share(part: _KnownPart, resolution: float) -> float:
    """Share of the cells at the edge of the free space that have no obstacle near."""
    # The part has one more cell on each side, unless the map ends there
    edge = part.free & grow_mask(np.pad(~part.free, 1, constant_values=True), 1)[1:-1, 1:-1]
    walls = grow_mask(part.occupied, max(1, round(NEAR_DISTANCE / resolution)))
    return float((edge & ~walls).sum()) / max(1.0, float(edge.sum()))


def _find_outside_rooms(floor: Floor, grid: GridMap) -> list[int]:
    """The rooms at the edge of a map that has no unknown cells and whose edge is free; else none."""
    edges = (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1])
    free = np.concatenate([grid.free[edge] for edge in edges])
    if free.mean() <= OPEN_EDGE_SHARE or np.count_nonzero(grid.unknown) >= MAX_UNKNOWN_SHARE * grid.cells.size:
        return []
    labels = floor.label_image(grid)
    ids = np.unique(np.concatenate([labels[edge] for edge in edges]))
    return [int(room_id) for room_id in ids if room_id]
