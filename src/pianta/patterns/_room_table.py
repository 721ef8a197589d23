"""RoomTable: the rooms of one or several storeys as arrays, with the rows that they form along corridors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats, Indices, Mask
from pianta.floor import Door, Floor, Room
from pianta.labels import ALL_SCHEMAS, FCES, RC, LabelSet, normalize_label
from pianta.rooms._outlines import Geometries, draw_outlines, measure_unit
from pianta.rooms._shapes import fit_rectangles

# All were chosen by hand; the unit of a floor is 6.5 m in the median school or office.
# Units: rooms on both sides of a corridor of 2 to 4 m are near each other.
NEAR_DISTANCE = 0.6
# Doors of a corridor among rooms without a label; section 4.3.1: corridors "usually more than four", rooms 1 or 2.
CORRIDOR_DOORS = 4
# Doors whose walls differ more in direction are on different sides of a corridor.
MAX_SIDE_ANGLE = np.radians(45)

# Rooms along one side of a corridor, by their indices in a RoomTable and in order, and the direction of the wall there.
Row = tuple[Indices, Floats]


@dataclass(frozen=True, eq=False)
class RoomTable:
    """n rooms of one or several storeys.

    storeys: the index of the storey of each room, shape (n,). ids: of the rooms on their storeys, shape (n,).
    middles: centroids of the outlines, m, shape (n, 2). near: which rooms are near each other, shape (n, n).
    corridors: which are corridors, shape (n,). rows: of rooms along corridors. unit: m.
    shapes: outlines about their centroids, shape (n,). labels: a number for each label, -1 without one, shape (n,).
    """

    storeys: Indices
    ids: Indices
    middles: Floats
    near: Mask
    corridors: Mask
    rows: tuple[Row, ...]
    unit: float
    shapes: Geometries
    labels: Indices

    def __len__(self) -> int:
        """The number of rooms."""
        return len(self.ids)

    def outlines(self, rooms: Indices) -> Geometries:
        """The outlines of rooms where they are."""
        return move_shapes(self.shapes[rooms], self.middles[rooms])

    def shuffle(self, generator: np.random.Generator, *, within_labels: bool = False) -> RoomTable:
        """The same storeys, where the rooms that are no corridors have exchanged shapes and labels at random.

        within_labels: whether only rooms of the same label exchange them.
        """
        order = np.arange(len(self))
        groups = np.where(within_labels, self.labels, 0)
        for group in np.unique(groups):
            rooms = np.flatnonzero(~self.corridors & (groups == group))
            order[rooms] = generator.permutation(rooms)
        return replace(self, shapes=self.shapes[order], labels=self.labels[order])


def build_room_table(storeys: Sequence[Floor], *, labels: bool) -> RoomTable:
    """The rooms of storeys, in order; labels: whether the labels count, else all rooms have none."""
    rooms = [room for floor in storeys for room in floor.rooms]
    unit = float(np.sqrt(np.median(shapely.area([room.polygon for room in rooms]))))
    outlines = np.concatenate([draw_outlines(floor, measure_unit(floor)) for floor in storeys if floor.rooms])
    middles = shapely.get_coordinates(shapely.centroid(outlines))
    counts = [len(floor.rooms) for floor in storeys]
    storey_of = np.repeat(np.arange(len(storeys)), counts)
    starts = np.cumsum([0, *counts])
    rows = [row for floor, start in zip(storeys, starts, strict=False) for row in _find_rows(floor, int(start))]
    near = _find_near(outlines, storey_of, NEAR_DISTANCE * unit)
    for indices, _ in rows:
        near[indices[:-1], indices[1:]] = near[indices[1:], indices[:-1]] = True
    return RoomTable(
        storey_of,
        np.array([room.id for room in rooms]),
        middles,
        near,
        np.concatenate([find_corridors(floor) for floor in storeys]),
        tuple(rows),
        unit,
        move_shapes(outlines, -middles),
        _number_labels(rooms) if labels else np.full(len(rooms), -1),
    )


def move_shapes(shapes: Geometries, shifts: Floats) -> Geometries:
    """Shapes moved, each by its own shift, shape (n, 2)."""
    corners = np.repeat(shifts, shapely.get_num_coordinates(shapes), axis=0)
    return np.asarray(shapely.transform(shapes, lambda xy: xy + corners), dtype=object)


def find_corridors(floor: Floor) -> Mask:
    """Which rooms are corridors: by R/C or the label, else by the number of doors; shape (rooms,)."""
    doors = np.bincount(
        [room_id for door in floor.doors for room_id in door.room_ids],
        minlength=max((room.id for room in floor.rooms), default=0) + 1,
    )
    return np.array([_is_corridor(room, int(doors[room.id])) for room in floor.rooms], bool)


def _is_corridor(room: Room, doors: int) -> bool:
    """Whether a room is a corridor; doors: how many it has."""
    if LabelSet.R_C in room.labels:
        return room.labels[LabelSet.R_C] == RC.CORRIDOR
    name = normalize_label(room.label) or ""
    functions = {schema.by_name[name].function for schema in ALL_SCHEMAS.values() if name in schema.by_name}
    if functions or name in {*RC, *FCES}:
        return FCES.CONNECTION in functions or name in (RC.CORRIDOR, FCES.CONNECTION)
    return doors >= CORRIDOR_DOORS


def _number_labels(rooms: Sequence[Room]) -> Indices:
    names = [normalize_label(room.label) for room in rooms]
    numbers = {name: number for number, name in enumerate(sorted({name for name in names if name}))}
    return np.array([-1 if name is None else numbers[name] for name in names])


def _find_near(outlines: Geometries, storeys: Indices, reach: float) -> Mask:
    """Which rooms of one storey are within a distance of each other, m; shape (n, n), False on the diagonal."""
    one, other = shapely.STRtree(outlines).query(outlines, predicate="dwithin", distance=reach)
    near = np.zeros((len(outlines), len(outlines)), bool)
    near[one, other] = storeys[one] == storeys[other]
    np.fill_diagonal(near, val=False)
    return near


def _find_rows(floor: Floor, start: int) -> Iterator[Row]:
    """The rows along all corridors of a floor; start: the index of its first room."""
    index_of = {room.id: start + number for number, room in enumerate(floor.rooms)}
    is_corridor = dict(zip(index_of, find_corridors(floor).tolist(), strict=True))
    for corridor in floor.rooms:
        if is_corridor[corridor.id]:
            beside = {door: other for door in floor.doors if (other := _behind(door, corridor.id)) in is_corridor}
            doors = {door: floor[other] for door, other in beside.items() if other and not is_corridor[other]}
            for side in _divide_sides(corridor, doors):
                rooms = [index_of[room.id] for room, _ in side]
                if len(rooms) > 1:
                    yield np.array(rooms), np.array([along for _, along in side])


def _behind(door: Door, room_id: int) -> int | None:
    """The room that a door joins to a room; None for an entrance, and if the door is not the room's."""
    others = [other for other in door.room_ids if other != room_id]
    return others[0] if len(others) == len(door.room_ids) - 1 and others else None


def _divide_sides(corridor: Room, doors: dict[Door, Room]) -> Iterator[list[tuple[Room, Floats]]]:
    """The rooms along each side of a corridor, in the order of their doors, each with the direction of its wall.

    A side is a part of the outline, or of the outline of a hole, along which the doors lead in one direction.
    """
    rings = (corridor.polygon.exterior, *corridor.polygon.interiors)
    on_ring: list[list[tuple[float, Room, Floats]]] = [[] for _ in rings]
    for door, room in doors.items():
        middle = door.line.interpolate(0.5, normalized=True)
        ring = int(np.argmin([each.distance(middle) for each in rings]))
        on_ring[ring].append((rings[ring].project(middle), room, _point_out(door, room)))
    for entries in on_ring:
        entries.sort(key=lambda entry: entry[:1])
        outs = np.array([out for _, _, out in entries]).reshape(-1, 2)
        turns = (outs * np.roll(outs, 1, axis=0)).sum(axis=1) < np.cos(MAX_SIDE_ANGLE)
        first = int(np.argmax(turns)) if turns.any() else 0
        order = np.roll(np.arange(len(entries)), -first)
        for side in np.split(order, np.flatnonzero(turns[order])):
            # Of a room with several doors, the first.
            by_room = {entries[i][1].id: (entries[i][1], outs[i][::-1] * (1, -1)) for i in side[::-1]}
            yield [*by_room.values()][::-1]


def _point_out(door: Door, room: Room) -> Floats:
    """The unit vector across a door, into a room."""
    ends = shapely.get_coordinates(door.line)[[0, -1]]
    along = ends[1] - ends[0]
    across = np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), 1e-9)
    inside = shapely.get_coordinates(room.polygon.representative_point())[0] - ends.mean(axis=0)
    return np.asarray(across if across @ inside >= 0 else -across)


def measure_rectangles(shapes: Geometries) -> tuple[Floats, Floats, Floats]:
    """Lengths and widths of the rectangles around shapes, m, and the directions of their long sides, radians."""
    rectangles = fit_rectangles(shapes)
    longest = np.argmax(rectangles.sides, axis=1)
    along = rectangles.along[np.arange(len(longest)), longest]
    return rectangles.length, rectangles.width, np.arctan2(along[:, 1], along[:, 0])


def measure_extents(shapes: Geometries, along: Floats) -> NDArray[np.float64]:
    """Frontage and depth of shapes: their extents along a wall and across it, m, shape (n, 2); along: shape (n, 2)."""
    across = along[:, ::-1] * (-1, 1)
    corners = [shapely.get_coordinates(shape) for shape in shapes]
    return np.array(
        [[np.ptp(xy @ a), np.ptp(xy @ b)] for xy, a, b in zip(corners, along, across, strict=True)]
    ).reshape(-1, 2)
