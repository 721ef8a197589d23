"""The floors of a vector plan whose rooms are drawn: in metres, with the coordinates of the file."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from shapely import LineString, STRtree
from shapely.affinity import scale as stretch

from pianta._types import Floats
from pianta.floor import Floor, Room
from pianta.io.drawings._drawing import ROLES, PlanDrawing
from pianta.plan.drawn_rooms.faces import find_enclosed_rooms
from pianta.plan.drawn_rooms.outlines import DrawnRoom, find_room_outlines
from pianta.plan.drawn_rooms.passages import find_passages
from pianta.plan.drawn_rooms.units import find_unit, lengths_of, unit_by_areas
from pianta.plan.sheets.sheet import PlanScale

# Metres.
FLOOR_GAP = 2.0  # between floors side by side, as on sheets of pixels
CORRIDOR_GAP = 3.0  # between rooms of one floor, if what lies between them is not drawn as a room
WALL_REACH = 1.0  # from a room to the lines of its walls
MIN_WALL_LENGTH = 0.3
MAX_WALLS = 5000  # lines of a floor that are kept
MIN_FLOOR_ROOMS = 2  # fewer are a detail beside a floor, and stay with the nearest one
MAX_SIZE = 1e5  # m of a drawing


def read_drawn_floors(
    drawing: PlanDrawing,
    *,
    resolution: float | None = None,
    room_layers: Collection[str] = (),
    chosen_walls: bool = False,
) -> tuple[list[Floor], PlanScale, str] | None:
    """The floors whose rooms are closed outlines, or enclosed by lines; None if the plan has neither.

    resolution: metres per drawing unit, None to find them. room_layers: those of rooms, as the user gives them.
    chosen_walls: whether the user gives the layers of walls.

    Returns the floors, the largest first, with the corners as they are drawn; metres per drawing unit; and a line
    about where the rooms come from.
    """
    metres = resolution if resolution is not None else drawing.metres_per_unit
    rooms: tuple[DrawnRoom, ...] = (
        () if chosen_walls else find_room_outlines(drawing, metres=metres, chosen=room_layers)
    )
    if not rooms and not chosen_walls and resolution is None:
        # The unit in the header may be that of a template
        rooms = find_room_outlines(drawing, metres=None)
        rooms = rooms if unit_by_areas(rooms, None) else ()
    note = _describe_outlines(rooms) if rooms else ""
    if not rooms and not room_layers:
        rooms = find_enclosed_rooms(drawing, only_walls=chosen_walls)
        note = f"rooms: {len(rooms)} areas that lines enclose, with the corners as drawn"
    if not rooms:
        return None
    unit = find_unit(drawing, rooms, resolution=resolution)
    if _size_of(rooms) * unit.resolution > MAX_SIZE:
        return None
    return _make_floors(drawing, rooms, unit.resolution), unit, note


def _size_of(rooms: Sequence[DrawnRoom]) -> float:
    """The longer side of all rooms, drawing units."""
    left, bottom, right, top = shapely.total_bounds(np.array([room.polygon for room in rooms], object)).tolist()
    return float(max(right - left, top - bottom))


def _describe_outlines(rooms: Sequence[DrawnRoom]) -> str:
    layers = ", ".join(
        f"{layer} {sum(room.layer == layer for room in rooms)}" for layer in dict.fromkeys(r.layer for r in rooms)
    )
    return f"rooms: closed outlines of layer {layers}, with the corners as drawn"


def _make_floors(drawing: PlanDrawing, drawn_rooms: Sequence[DrawnRoom], metres: float) -> list[Floor]:
    """The floors of rooms that lie together, the largest first."""
    outlines = [stretch(room.polygon, metres, metres, origin=(0, 0)) for room in drawn_rooms]
    is_wall = drawing.roles == ROLES.index("wall")
    # Lines of the rooms' own layers are their outlines
    layers = {room.layer for room in drawn_rooms}
    if len(drawing.line_layers):
        own = [number for number, layer in enumerate(drawing.layers) if layer in layers]
        is_wall &= ~np.isin(drawing.line_layers, own)
    walls = drawing.lines[is_wall] * metres
    floors = []
    for members in _group_rooms(outlines, walls):
        rooms = tuple(
            Room(room_id, outlines[index], name=source.name or None, number=source.number or None)
            for room_id, (index, source) in enumerate(((index, drawn_rooms[index]) for index in members), start=1)
        )
        near = _lines_near(walls, rooms)
        doors = find_passages(rooms, named=drawing.doors * metres, unnamed=drawing.unnamed_doors * metres, walls=near)
        lines = near[lengths_of(near) >= MIN_WALL_LENGTH][:MAX_WALLS]
        floors.append(Floor(rooms, tuple(doors), tuple(map(LineString, lines)), source=drawing.source))
    return sorted(floors, key=lambda floor: -sum(room.polygon.area for room in floor.rooms))


def _lines_near(lines: Floats, rooms: Sequence[Room]) -> Floats:
    """The lines that are near a room, shape (N, 2, 2)."""
    if not len(lines):
        return lines
    tree = STRtree(shapely.linestrings(lines))
    near = tree.query([room.polygon for room in rooms], predicate="dwithin", distance=WALL_REACH)[1]
    return np.asarray(lines[np.unique(near)])


def _group_rooms(outlines: Sequence[shapely.Polygon], walls: Floats) -> list[list[int]]:
    """The indexes of rooms of each floor: rooms that lie near each other, directly, through others, or by walls."""
    shapes = np.array(outlines, object)
    tree = STRtree(shapes)
    first, second = tree.query(shapes, predicate="dwithin", distance=FLOOR_GAP)
    if len(walls):
        # A wall that touches two rooms joins them, as along a corridor that is not drawn as a room
        lines, touched = tree.query(shapely.linestrings(walls), predicate="dwithin", distance=WALL_REACH)
        same = lines[1:] == lines[:-1]
        first, second = np.append(first, touched[1:][same]), np.append(second, touched[:-1][same])
    numbers = _components(first, second, len(shapes))
    hulls = np.array(
        [shapely.union_all(shapes[numbers == number]).envelope for number in range(numbers.max() + 1)], object
    )
    one, other = STRtree(hulls).query(hulls, predicate="dwithin", distance=CORRIDOR_GAP)
    facing = [_overlap_along_an_axis(hulls[i], hulls[j]) for i, j in zip(one, other, strict=True)]
    numbers = _components(one[facing], other[facing], len(hulls))[numbers]
    numbers = _with_details(shapes, numbers)
    return [np.flatnonzero(numbers == number).tolist() for number in dict.fromkeys(numbers.tolist())]


def _overlap_along_an_axis(one: shapely.Polygon, other: shapely.Polygon) -> bool:
    """Whether two rows of rooms face each other over a corridor: it is less wide than the rows are deep."""
    gap = float(one.distance(other))
    depths = [min(box.bounds[2] - box.bounds[0], box.bounds[3] - box.bounds[1]) for box in (one, other)]
    return gap <= FLOOR_GAP or gap < min(depths)


def _components(first: np.ndarray, second: np.ndarray, count: int) -> np.ndarray:
    joined = coo_array((np.ones(len(first), bool), (first, second)), shape=(count, count))
    return np.asarray(connected_components(joined, directed=False)[1])


def _with_details(shapes: np.ndarray, numbers: np.ndarray) -> np.ndarray:
    """The numbers of floors, with single rooms given to the floor that is nearest to them."""
    counts = np.bincount(numbers)
    large = np.isin(numbers, np.flatnonzero(counts >= MIN_FLOOR_ROOMS))
    if large.all() or not large.any():
        return numbers
    tree = STRtree(shapes[large])
    result = numbers.copy()
    for index in np.flatnonzero(~large):
        result[index] = numbers[large][tree.nearest(shapes[index])]
    return result
