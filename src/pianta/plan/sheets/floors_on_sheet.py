"""The floors on a sheet: which parts of the drawing are floors of their own, and the rooms and doors of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from shapely import LineString

from pianta._types import Floats, Mask
from pianta.errors import MapError
from pianta.floor import Door, Floor, scale_floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.layout.reconstruct import find_rooms
from pianta.plan.doors.lines import PlanDoors, join_rooms
from pianta.plan.walls.floor_map import FloorMap


@dataclass(frozen=True, kw_only=True)
class SheetFloorParameters:
    """Thresholds of the floors on a sheet. Chosen by hand, no fit is on record."""

    floor_gap: float = 2.0  # m: parts of one building are no further apart
    min_floor_share: float = 0.15  # of the largest floor: smaller parts are sketches and legends
    min_floor_area: float = 30.0  # m²: so are parts with a smaller area
    min_room_area: float = 1.0  # m²: smaller rooms are what a jagged line leaves beside a wall
    wall_cells: int = 7  # cells across: half of that around a floor is wall that belongs to it
    same_door_distance: float = 0.8  # m between the middles of a drawn door and of the same one in the layout


PARAMETERS = SheetFloorParameters()


def reconstruct_sheet_floors(floor_map: FloorMap, doors: PlanDoors, *, method: str, source: str) -> list[Floor]:
    """The floors of a sheet, the largest first, in pixels of the sheet with y up; floors without rooms are left out.

    doors: those that are drawn. method: one of METHODS.
    """
    grid, per_metre = floor_map.grid, 1 / floor_map.resolution
    numbers = split_sheet(floor_map.inside, resolution=grid.resolution)
    certain, uncertain = (
        [_to_metres(line, floor_map) for line in doors.lines[chosen]] for chosen in (~doors.uncertain, doors.uncertain)
    )
    floors = []
    for number in range(1, int(numbers.max(initial=0)) + 1):
        # Walls belong to the floors beside them
        own = cv2.dilate((numbers == number).view(np.uint8), np.ones((PARAMETERS.wall_cells,) * 2)) > 0
        cells = np.where(own, grid.cells, UNKNOWN).astype(np.int8)
        try:
            floor = find_rooms(GridMap(cells, grid.resolution, grid.origin, source), method=method)
        except MapError:
            continue
        floors.append(scale_floor(_add_doors(floor, certain, uncertain), per_metre, per_metre))
    return floors


def split_sheet(inside: Mask, *, resolution: float) -> NDArray[np.int32]:
    """Number of the floor of each cell, shape (H, W): 0 for none, 1 for the largest floor, and so on.

    inside: shape (H, W), the rooms of a sheet. resolution: metres per cell.
    What is too small for a floor is left out, unless nothing is larger.
    """
    distance = cv2.distanceTransform((~inside).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    parts, count = ndimage.label(distance * resolution <= PARAMETERS.floor_gap / 2)
    areas = np.bincount(parts[inside], minlength=count + 1) * resolution**2
    areas[0] = 0
    largest = areas.max(initial=0)
    least = min(max(PARAMETERS.min_floor_share * largest, PARAMETERS.min_floor_area), largest)
    floors = [part for part in np.argsort(-areas, kind="stable") if areas[part] > 0 and areas[part] >= least]
    numbers = np.zeros(count + 1, np.int32)
    numbers[floors] = np.arange(1, len(floors) + 1)
    return np.where(inside, numbers[parts], 0).astype(np.int32)


def _to_metres(line: Floats, floor_map: FloorMap) -> LineString:
    """A line of row and col in pixels of the sheet, in metres, y up."""
    rows, cols = line.T * floor_map.resolution
    return LineString(np.column_stack([cols, floor_map.height - rows]))


def _add_doors(floor: Floor, certain: Sequence[LineString], uncertain: Sequence[LineString]) -> Floor:
    """The floor with drawn doors, lines in metres, besides those of its layout; all rooms complete, none predicted.

    An uncertain line is a door if one of its rooms has no other. What stands in a room is a rest of the drawing, such
    as a column or a stroke, and no furniture. All doors are drawn, so none is only possible.
    """
    floor = _drop_slivers(replace(floor, furniture=(), possible_doors=()))
    drawn_doors = join_rooms(floor.rooms, certain)
    reached = {room for door in drawn_doors for room in door.room_ids}
    for door in join_rooms(floor.rooms, uncertain):
        if not reached >= set(door.room_ids):
            drawn_doors.append(door)
            reached.update(door.room_ids)

    def is_new(door: Door) -> bool:
        near = (other for other in drawn_doors if other.rooms == door.rooms)
        return all(_middle(other).distance(_middle(door)) > PARAMETERS.same_door_distance for other in near)

    # Where doors are drawn, a passage without one is an opening
    others = [replace(door, kind="opening") if drawn_doors else door for door in filter(is_new, floor.doors)]
    doors = sorted([*drawn_doors, *others], key=lambda door: (door.room_ids, door.line.coords[0]))
    rooms = tuple(replace(room, partial=False, predicted=None, confidence=None) for room in floor.rooms)
    return replace(floor, rooms=rooms, doors=tuple(doors))


def _drop_slivers(floor: Floor) -> Floor:
    """The floor without rooms that are too small to stand in, unless all are."""
    large = [room for room in floor.rooms if room.polygon.area >= PARAMETERS.min_room_area] or floor.rooms
    new_ids = {room.id: number for number, room in enumerate(large, start=1)}
    doors = [door.renumber_rooms(new_ids) for door in floor.doors if new_ids.keys() >= set(door.room_ids)]
    rooms = tuple(replace(room, id=new_ids[room.id]) for room in large)
    return replace(floor, rooms=rooms, doors=tuple(doors), last_id=0)


def _middle(door: Door) -> shapely.Point:
    return door.line.interpolate(0.5, normalized=True)
