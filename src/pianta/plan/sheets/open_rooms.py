"""False rooms: blocks of solid wall, and parts of open rooms that the layout method cuts at furniture.

The method extends walls to divide the floor. At home, where most of such a border shows nothing, its two sides are one
open-plan room. Elsewhere they are not joined: a hall and the corridor that opens into it are two rooms, and on the 47
plans of `floorplans` joining lowers the scores.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import networkx as nx
import numpy as np
import shapely
from shapely import Polygon

from pianta._types import Floats, Indices, Mask
from pianta.floor import Floor, Room
from pianta.floor.shapes import join_shapes
from pianta.plan.sheets.sheet import Sheet
from pianta.plan.walls.segmentation import WALL, ClassMap


@dataclass(frozen=True, kw_only=True)
class OpenRoomParameters:
    """Thresholds of `join_open_rooms`; shares are of the length of a border.

    Chosen by hand on six flats; those of small parts raise the F1 of rooms on the plans of `floorplans`, too.
    """

    solid_share: float = 0.9  # of a room that is ink, if it is a block of wall
    border_cells: float = 3.0  # cells of the network between two rooms with a border, at most
    border_step: float = 0.05  # m between two points of a border that are looked at
    clear_cells: float = 1.0  # cells around a free point of a border in which there is no ink
    max_wall: float = 0.8  # probability of a wall at a free point; the network continues walls through open rooms
    open_share: float = 0.35  # of a border that is free if both sides are one room at home
    open_length: float = 2.0  # m of the same: more than a passage
    small_part: float = 1.5  # m²: a smaller room is part of another one, as what furniture cuts off
    small_share: float = 0.3  # of their border that is free


PARAMETERS = OpenRoomParameters()


@dataclass(frozen=True)
class Border:
    """Where two rooms meet.

    rooms: their ids. length: metres. free: share of the length where nothing is drawn.
    """

    rooms: tuple[int, int]
    length: float
    free: float


def join_open_rooms(floor: Floor, sheet: Sheet, class_map: ClassMap, *, resolution: float, at_home: bool) -> Floor:
    """The floor without blocks of wall, and with the parts of open rooms joined; rooms are numbered anew.

    floor: in metres, y up, with the origin in the lower left corner of the sheet. resolution: metres per pixel.
    """
    p = PARAMETERS
    solid = _solid_rooms(floor, sheet, resolution)
    if len(solid) < len(floor):
        floor = _without(floor, solid)
    areas = {room.id: room.polygon.area for room in floor}
    borders = list(_list_borders(floor, sheet, class_map, resolution))
    joined = nx.Graph()
    joined.add_nodes_from(areas)
    for border in borders:
        if at_home and border.free >= p.open_share and border.free * border.length >= p.open_length:
            joined.add_edge(*border.rooms)
    for room, area in areas.items():
        open_sides = [border for border in borders if room in border.rooms and border.free >= p.small_share]
        if area < p.small_part and open_sides:
            joined.add_edge(*max(open_sides, key=lambda border: border.free * border.length).rooms)
    return _join(floor, [set(part) for part in nx.connected_components(joined)])


def _solid_rooms(floor: Floor, sheet: Sheet, resolution: float) -> set[int]:
    """The ids of rooms that are filled with ink."""
    solid = set()
    for room in floor:
        window, inside = _pixels_of(room.polygon, sheet.shape, resolution)
        ink = sheet.ink[window][inside]
        if ink.size and ink.mean() >= PARAMETERS.solid_share:
            solid.add(room.id)
    return solid


def _pixels_of(polygon: Polygon, shape: tuple[int, int], resolution: float) -> tuple[tuple[slice, slice], Mask]:
    """The rows and columns around a polygon in metres, and its pixels among these."""
    corners = _to_pixels(np.asarray(polygon.exterior.coords)[:, :2], shape, resolution)
    low = np.clip(np.floor(corners.min(axis=0)).astype(int), 0, shape)
    high = np.clip(np.ceil(corners.max(axis=0)).astype(int) + 1, 0, shape)
    mask = np.zeros(np.maximum(high - low, 1), np.uint8)
    cv2.fillPoly(mask, [np.rint(corners - low)[:, ::-1].astype(np.int32)], 1)
    return (slice(low[0], high[0]), slice(low[1], high[1])), mask[: high[0] - low[0], : high[1] - low[1]] > 0


def _to_pixels(points: Floats, shape: tuple[int, int], resolution: float) -> Floats:
    """Row and col of points x and y, metres, shape (N, 2)."""
    return np.column_stack([shape[0] - points[:, 1] / resolution, points[:, 0] / resolution])


def _list_borders(floor: Floor, sheet: Sheet, class_map: ClassMap, resolution: float) -> Iterator[Border]:
    """The borders between rooms that are next to each other."""
    walls, side = class_map.probabilities[WALL], 2 * round(PARAMETERS.clear_cells * class_map.cell_px) + 1
    ink = cv2.dilate(sheet.ink.view(np.uint8), np.ones((side, side), np.uint8)) > 0
    reach = PARAMETERS.border_cells * class_map.cell_px * resolution
    rooms = floor.rooms
    firsts, seconds = shapely.STRtree([room.polygon for room in rooms]).query(
        [room.polygon for room in rooms], predicate="dwithin", distance=reach
    )
    for first, second in zip(firsts, seconds, strict=True):
        one, other = rooms[first], rooms[second]
        # What is outside is no part of a room
        is_pair = first < second and one.flag == other.flag
        points = _points_between(one, other, reach) if is_pair else np.zeros((0, 2))
        if len(points):
            pixels = _to_pixels(points, sheet.shape, resolution)
            has_wall = walls[_indices(pixels / class_map.cell_px, walls.shape)] >= PARAMETERS.max_wall
            is_drawn = has_wall | ink[_indices(pixels, ink.shape)]
            yield Border((one.id, other.id), len(points) * PARAMETERS.border_step, 1 - float(is_drawn.mean()))


def _points_between(one: Room, other: Room, reach: float) -> Floats:
    """Points at even distances in the middle between the outlines of two rooms, x and y, shape (N, 2)."""
    side = other.polygon.boundary.intersection(one.polygon.buffer(reach))
    opposite = one.polygon.boundary
    points = []
    for piece in shapely.get_parts(side):
        distances = np.arange(PARAMETERS.border_step / 2, piece.length, PARAMETERS.border_step)
        near = shapely.line_interpolate_point(piece, distances)
        far = shapely.line_interpolate_point(opposite, shapely.line_locate_point(opposite, near))
        points.append((shapely.get_coordinates(near) + shapely.get_coordinates(far)) / 2)
    return np.concatenate(points) if points else np.zeros((0, 2))


def _indices(positions: Floats, shape: tuple[int, ...]) -> tuple[Indices, Indices]:
    """The rows and columns of the cells in which positions lie, or of the nearest ones of a layer of a shape."""
    rows, cols = np.clip(np.floor(positions).astype(int), 0, np.array(shape) - 1).T
    return rows, cols


def _without(floor: Floor, dropped: set[int]) -> Floor:
    """The floor without some rooms and their doors."""
    rooms = tuple(room for room in floor if room.id not in dropped)
    doors = tuple(door for door in floor.doors if not dropped & set(door.room_ids))
    return replace(floor, rooms=rooms, doors=doors)


def _join(floor: Floor, parts: list[set[int]]) -> Floor:
    """The floor with the rooms of each part as one, numbered anew in the order of their first."""
    new_ids: dict[int, int] = {}
    rooms: list[Room] = []
    for number, part in enumerate(sorted(parts, key=min), start=1):
        own = [room for room in floor if room.id in part]
        largest = max(own, key=lambda room: room.polygon.area)
        if len(own) > 1:
            others = [room.polygon for room in floor if room.id not in part]
            largest = replace(largest, polygon=join_shapes([room.polygon for room in own], others))
        rooms.append(replace(largest, id=number))
        new_ids |= dict.fromkeys(part, number)
    lead_elsewhere = [door for door in floor.doors if len({room and new_ids[room] for room in door.rooms}) == 2]
    doors = tuple(door.renumber_rooms(new_ids) for door in lead_elsewhere)
    return replace(floor, rooms=tuple(rooms), doors=doors, last_id=0)
