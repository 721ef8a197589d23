"""Where a robot fits: a position in each room, and one in each door."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from pianta._types import Mask
from pianta.floor import Door, Floor, cells_of_polygon
from pianta.navigation.free_space import FreeSpace
from pianta.navigation.lattice import find_stride

Cell: TypeAlias = tuple[int, int]

# Metres around the line of a door in which its position may be, where furniture stands on it: half the width of a door.
DOOR_REACH = 0.45
# A position in a room has at least this share of the best clearance, or CLEARANCE metres, and of these it is the one
# nearest to the centroid. Chosen by hand.
CLEARANCE_SHARE = 0.8
CLEARANCE = 1.0
# Corners of a quarter of a circle around the end of a door; more take time and no other cells (chosen by hand).
CIRCLE = 3


def locate_doors(space: FreeSpace, floor: Floor) -> list[Cell | None]:
    """A cell for each door where the robot fits, the one with most clearance on its line; None without one."""
    return [_locate_door(space, door) for door in floor.doors]


def locate_rooms(space: FreeSpace, floor: Floor, doors: list[Cell | None]) -> dict[int, Cell]:
    """A cell for each room where the robot fits, by the id of the room; rooms in which it fits nowhere have none.

    Of separate parts of a room it is in the one with most doors, and of those with equally many in the largest.
    """
    cells = {room.id: _locate_room(space, floor, room.id, doors) for room in floor}
    return {room: cell for room, cell in cells.items() if cell is not None}


def _locate_door(space: FreeSpace, door: Door) -> Cell | None:
    """First on the line, which is widened by a cell, then around it; in the largest part of the open cells there."""
    for reach in (space.grid.resolution, DOOR_REACH):
        rows, cols, inside = cells_of_polygon(door.line.buffer(reach, quad_segs=CIRCLE), space.grid)
        parts = np.where(inside, space.parts[rows, cols], 0)
        if parts.any():
            mask = parts == parts[parts > 0].min()
            middle = door.line.interpolate(0.5, normalized=True)
            row, col = _find_clear_cell(space, mask, (rows, cols), (middle.x, middle.y), share=1.0)
            return row, col
    return None


def _locate_room(space: FreeSpace, floor: Floor, room: int, doors: list[Cell | None]) -> Cell | None:
    polygon = floor[room].polygon
    rows, cols, inside = cells_of_polygon(polygon, space.grid)
    parts = np.where(inside, space.parts[rows, cols], 0)
    sizes = np.bincount(parts.ravel())
    if not sizes[1:].any():
        return None
    own = [space.parts[cell] for cell, door in zip(doors, floor.doors, strict=True) if cell and room in door.room_ids]
    best = max(np.flatnonzero(sizes[1:]) + 1, key=lambda part: (own.count(part), sizes[part]))
    centroid = polygon.centroid
    return _find_clear_cell(space, parts == best, (rows, cols), (centroid.x, centroid.y), share=CLEARANCE_SHARE)


def _find_clear_cell(
    space: FreeSpace, mask: Mask, window: tuple[slice, slice], near: tuple[float, float], *, share: float
) -> Cell:
    """Of the cells of a mask with a share of the best clearance the one nearest to a position, x, y."""
    cells = np.argwhere(mask) + np.array([window[0].start, window[1].start])
    # Those of the lattice, where there are some
    on_lattice = (cells % find_stride(space.grid.resolution) == 0).all(axis=1)
    cells = cells[on_lattice] if on_lattice.any() else cells
    clearance = space.clearance[tuple(cells.T)]
    enough = min(share * clearance.max(), CLEARANCE)
    cells = cells[clearance >= enough - 1e-9]
    distances = np.hypot(*(space.to_map(cells) - near).T)
    row, col = cells[int(distances.argmin())].tolist()
    return row, col
