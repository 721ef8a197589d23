"""The floors on a sheet: which parts of the drawing are floors of their own, and the rooms and doors of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage
from shapely import LineString

from pianta._types import Floats
from pianta.errors import MapError
from pianta.floor import Door, Floor, scale_floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.layout.reconstruct import find_rooms
from pianta.plan.doors.lines import PlanDoors, join_rooms
from pianta.plan.walls.floor_map import FloorMap

# Parts of a building lie no further apart than this, metres; parts smaller than this share of the largest floor, or
# than this area, m², are no floors, but sketches and legends.
APART, LEAST_SHARE, LEAST_AREA = 2.0, 0.15, 30.0
# A smaller room is none, m².
LEAST_ROOM = 1.0
# Walls that are so many cells wide belong to the floor beside them.
WALL_CELLS = 7
# A door that the layout method finds this near to a remembered one is the same, metres.
SAME_DOOR = 0.8


def lay_out_floors(floor_map: FloorMap, doors: PlanDoors, *, method: str, source: str) -> list[Floor]:
    """The floors of a sheet, the largest first, in pixels of the sheet with y up; floors without rooms are left out.

    doors: the remembered ones. method: one of METHODS.
    """
    grid, per_metre = floor_map.grid, 1 / floor_map.resolution
    parts = part_floors(floor_map.inside, resolution=grid.resolution)
    floors = []
    for number in range(1, int(parts.max(initial=0)) + 1):
        # Walls belong to the floors beside them
        own = cv2.dilate((parts == number).view(np.uint8), np.ones((WALL_CELLS,) * 2)) > 0
        cells = np.where(own, grid.cells, UNKNOWN).astype(np.int8)
        try:
            floor = find_rooms(GridMap(cells, grid.resolution, grid.origin, source), method=method)
        except MapError:
            continue
        sure, doubtful = (
            [_place_line(line, floor_map) for line in doors.lines[chosen]]
            for chosen in (~doors.doubtful, doors.doubtful)
        )
        floors.append(scale_floor(_remember_doors(floor, sure, doubtful), per_metre, per_metre))
    return floors


def part_floors(inside: NDArray[np.bool_], *, resolution: float) -> NDArray[np.int32]:
    """Floor of each cell, shape (H, W): 0 for none, else 1 for the largest floor, and so on.

    inside: shape (H, W), the rooms of a sheet. resolution: metres per cell.
    What is too small for a floor is left out, unless nothing is larger.
    """
    distance = cv2.distanceTransform((~inside).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    parts, count = ndimage.label(distance * resolution <= APART / 2)
    areas = np.bincount(parts[inside], minlength=count + 1) * resolution**2
    areas[0] = 0
    largest = areas.max(initial=0)
    least = min(max(LEAST_SHARE * largest, LEAST_AREA), largest)
    kept = [part for part in np.argsort(-areas, kind="stable") if areas[part] > 0 and areas[part] >= least]
    number = np.zeros(count + 1, np.int32)
    number[kept] = np.arange(1, len(kept) + 1)
    return np.where(inside, number[parts], 0).astype(np.int32)


def _place_line(line: Floats, floor_map: FloorMap) -> LineString:
    """A line of row and col in pixels of the sheet, in metres, y up."""
    rows, cols = line.T * floor_map.resolution
    return LineString(np.column_stack([cols, floor_map.height - rows]))


def _remember_doors(floor: Floor, sure: Sequence[LineString], doubtful: Sequence[LineString]) -> Floor:
    """The floor with the doors along lines beside those that it has, whole rooms, and none predicted.

    A doubtful one is a door where one of its rooms has no other.
    """
    floor = _drop_slivers(floor)
    remembered = join_rooms(floor.rooms, sure)
    reached = {room for door in remembered for room in door.room_ids}
    for door in join_rooms(floor.rooms, doubtful):
        if not reached >= set(door.room_ids):
            remembered.append(door)
            reached.update(door.room_ids)

    def is_new(door: Door) -> bool:
        near = (known for known in remembered if known.rooms == door.rooms)
        return all(_middle(known).distance(_middle(door)) > SAME_DOOR for known in near)

    # Where doors are drawn, a passage without one is an opening
    others = [replace(door, kind="opening") if remembered else door for door in filter(is_new, floor.doors)]
    doors = [*remembered, *others]
    rooms = tuple(replace(room, partial=False, predicted=None, confidence=None) for room in floor.rooms)
    return replace(
        floor, rooms=rooms, doors=tuple(sorted(doors, key=lambda door: (door.room_ids, door.line.coords[0])))
    )


def _drop_slivers(floor: Floor) -> Floor:
    """The floor without rooms in which nobody can stand: what a jagged line leaves beside a wall."""
    kept = [room for room in floor.rooms if room.polygon.area >= LEAST_ROOM] or floor.rooms
    new_ids = {room.id: number for number, room in enumerate(kept, start=1)}
    doors = [door.renumber_rooms(new_ids) for door in floor.doors if new_ids.keys() >= set(door.room_ids)]
    rooms = tuple(replace(room, id=new_ids[room.id]) for room in kept)
    return replace(floor, rooms=rooms, doors=tuple(doors), last_id=0)


def _middle(door: Door) -> shapely.Point:
    return door.line.interpolate(0.5, normalized=True)
