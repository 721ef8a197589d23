"""Clean maps: a grid map without furniture, spray and people, for robots that drive by it."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
import shapely

from pianta._arguments import check_argument
from pianta._types import Mask
from pianta.floor import Floor, cells_of_polygon
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout._label_images import grow_mask, shrink_mask
from pianta.layout.furniture import OUTLINE_TOLERANCE, sort_contents

# The constants were chosen by hand on the maps of data/clutter and data/robotmaps.
# Free cells outside of all rooms stay up to this distance from a room, because outlines are smoothed; metres.
FREE_TOLERANCE = 0.1
# Free cells in a doorway stay up to this distance from the line of the door, which may be at either side; metres.
DOORWAY_REACH = 0.6
# The two faces of a stub of a wall are nearer than this; metres.
WALL_THICKNESS = 0.35
# Groups of occupied cells farther than this from all rooms are no wall of a room; metres.
WALL_REACH = 0.5


def clean_map(grid: GridMap, floor: Floor) -> GridMap:
    """Remove furniture, people, spray and rays through windows from a map, and keep walls and doorways.

    In a room, furniture and other loose cells become free, and so does what was not seen. Walls and their stubs stay;
    where furniture hid a wall, the outline of the room becomes one. Outside of all rooms, free cells become unknown
    except in doorways, and so do occupied cells more than 0.5 m from any room.

    Parameters
    ----------
    grid
        The map.
    floor
        Its floor, as of `reconstruct`. A floor without furniture gets that which the rules find.

    Returns
    -------
    GridMap
        The map with the same cells in the same place, each free (0), occupied (100) or unknown (-1).

    Examples
    --------
    >>> import pianta
    >>> _, grid = pianta.make_world("corridor", furniture=0.5)
    >>> clean = pianta.clean_map(grid, pianta.reconstruct(grid))
    >>> clean.save("clean.yaml")
    >>> int(clean.free.sum()) > int(grid.free.sum())
    True
    """
    check_argument(grid, GridMap, "grid", "a GridMap of read_map")
    check_argument(floor, Floor, "floor", "a Floor of reconstruct")
    contents = sort_contents(grid, floor)
    in_room = contents.rooms > 0
    solid = in_room & ~grid.free
    # Furniture, with the cells between it and the wall, which may belong to either
    pieces = solid & (_fill_furniture(floor, grid) if floor.furniture else contents.pieces > 0)
    behind = _grow(pieces, OUTLINE_TOLERANCE, grid.resolution) & contents.at_outline
    removed = solid & (grow_mask(pieces, 1) | behind)
    removed |= contents.spray
    # What was not seen, except inside the walls that stay
    stays = grid.occupied & ~removed
    free = grid.free | removed | (contents.shadows & ~_close(stays, WALL_THICKNESS, grid.resolution))
    # A wall that furniture hid is drawn where the room ends
    occupied = stays | (grow_mask(removed, 1) & grid.unknown & ~in_room)
    # Rays through windows, and what they hit
    free &= _grow(in_room, FREE_TOLERANCE, grid.resolution) | _find_doorways(floor, grid)
    occupied &= ~_find_distant_groups(occupied, in_room, grid.resolution)
    cells = np.full(grid.shape, UNKNOWN, np.int8)
    cells[free] = FREE
    cells[occupied] = OCCUPIED
    return GridMap(cells, grid.resolution, grid.origin, grid.source)


def _fill_furniture(floor: Floor, grid: GridMap) -> Mask:
    return _fill_polygons((piece.polygon for piece in floor.furniture), grid)


def _find_doorways(floor: Floor, grid: GridMap) -> Mask:
    return _fill_polygons((door.line.buffer(DOORWAY_REACH) for door in floor.doors), grid)


def _fill_polygons(polygons: Iterable[shapely.Polygon], grid: GridMap) -> Mask:
    """The cells whose centres are in any of the polygons, metres of the map frame; shape (H, W)."""
    filled = np.zeros(grid.shape, bool)
    for polygon in polygons:
        rows, cols, inside = cells_of_polygon(polygon, grid)
        filled[rows, cols] |= inside
    return filled


def _grow(mask: Mask, distance: float, resolution: float) -> Mask:
    """The mask, shape (H, W), and all cells up to a distance from it in rows and columns; metres."""
    return grow_mask(mask, round(distance / resolution))


def _close(mask: Mask, distance: float, resolution: float) -> Mask:
    """The mask, shape (H, W), and the cells in gaps in it that are narrower than a distance in metres."""
    reach = round(distance / resolution / 2)
    return shrink_mask(np.pad(grow_mask(mask, reach), reach), reach)[reach:-reach, reach:-reach] if reach else mask


def _find_distant_groups(occupied: Mask, in_room: Mask, resolution: float) -> Mask:
    """Groups of occupied cells that nowhere come near a room, shape (H, W)."""
    count, groups = cv2.connectedComponents(occupied.astype(np.uint8), connectivity=8)
    is_near = np.zeros(count, bool)
    is_near[groups[_grow(in_room, WALL_REACH, resolution)]] = True
    return np.asarray(occupied & ~is_near[groups])
