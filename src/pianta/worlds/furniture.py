"""Furniture of synthetic floors at the height of a lidar."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from shapely import LineString, Point, Polygon, affinity, box, get_coordinates, unary_union

from pianta.floor import Floor

# The constants and the sizes of the pieces were chosen by hand.
# Floor area per attempt to place a piece, at density 1; m².
AREA_PER_PIECE = 1.5
# Clear space around each piece that is not at a wall; metres.
PASSAGE = 0.7
# Clear space around each door; metres.
DOOR_CLEARANCE = 1.0
# A piece stands against a wall if it is at most this far from it, because of rounding; metres.
TOUCH = 1e-6


def furnish_floor(floor: Floor, *, density: float, leg: float, rng: np.random.Generator) -> list[Polygon]:
    """Obstacles at the height of a lidar in all rooms but corridors, metres in the floor's frame.

    density: 0 empty … 1 a busy office.
    leg: side of the square legs of tables and chairs, metres.
    Every piece stands against a wall or leaves a passage all around it, so that no room is cut in two.
    """
    obstacles = []
    for room in floor.rooms:
        if room.label != "CORRIDOR":
            doors = [door.line for door in floor.doors if room.id in door.rooms]
            obstacles += _furnish_room(room.polygon, doors, density, leg, rng)
    return obstacles


def _furnish_room(
    room: Polygon, doors: Sequence[LineString], density: float, leg: float, rng: np.random.Generator
) -> list[Polygon]:
    """Obstacles of pieces at random positions, clear of doors; leg: its side, metres. density: 0 empty … 1 busy."""
    clear = room.difference(unary_union([door.buffer(DOOR_CLEARANCE) for door in doors])).buffer(TOUCH)
    pieces: list[Polygon] = []
    obstacles: list[Polygon] = []
    for _ in range(round(density * room.area / AREA_PER_PIECE)):
        draw_piece, has_legs = PIECE_TYPES[int(rng.integers(len(PIECE_TYPES)))]
        piece = draw_piece(room, rng)
        to_wall = piece.distance(room.boundary)
        near = 0 < to_wall - TOUCH < PASSAGE or any(piece.distance(other) < PASSAGE for other in pieces)
        if clear.contains(piece) and not near:
            pieces.append(piece)
            obstacles += _find_legs(piece, leg) if has_legs else [piece]
    return obstacles


def _draw_shelf(room: Polygon, rng: np.random.Generator) -> Polygon:
    """A box whose back is on a side of the room."""
    sides = [LineString(ends) for ends in pairwise(get_coordinates(room.exterior))]
    side = sides[int(rng.integers(len(sides)))]
    length = min(1.0 + rng.random(), side.length)
    start = (side.length - length) * rng.random()
    back = LineString([side.interpolate(start), side.interpolate(start + length)])
    # The exterior runs counter-clockwise, so the room is on its left, where distances are positive.
    return back.buffer(0.4, single_sided=True)


def _draw_desk(room: Polygon, rng: np.random.Generator) -> Polygon:
    return _place_box(1.2 + 0.6 * rng.random(), 0.6 + 0.3 * rng.random(), room, rng)


def _draw_chair(room: Polygon, rng: np.random.Generator) -> Polygon:
    return _place_box(0.45, 0.45, room, rng)


def _draw_round_table(room: Polygon, rng: np.random.Generator) -> Polygon:
    return Point(_draw_position(room, rng)).buffer(0.25 + 0.4 * rng.random(), quad_segs=4)


def _place_box(length: float, depth: float, room: Polygon, rng: np.random.Generator) -> Polygon:
    """A box in the bounds of the room, along either axis or, one time in three, at any angle."""
    angle = 90 * int(rng.integers(2)) + (rng.random() < 1 / 3) * 90 * rng.random()
    turned = affinity.rotate(box(-length / 2, -depth / 2, length / 2, depth / 2), angle, origin=(0, 0))
    return affinity.translate(turned, *_draw_position(room, rng))


def _draw_position(room: Polygon, rng: np.random.Generator) -> tuple[float, float]:
    x0, y0, x1, y1 = room.bounds
    return x0 + (x1 - x0) * rng.random(), y0 + (y1 - y0) * rng.random()


def _find_legs(piece: Polygon, leg: float) -> list[Polygon]:
    """Square legs about the corners of a piece."""
    return [Point(corner).buffer(leg / 2, cap_style="square") for corner in get_coordinates(piece.exterior)[:-1]]


# How a piece is drawn, and whether the lidar detects only its legs.
PIECE_TYPES: tuple[tuple[Callable[[Polygon, np.random.Generator], Polygon], bool], ...] = (
    (_draw_shelf, False),
    (_draw_desk, False),
    (_draw_desk, True),
    (_draw_chair, True),
    (_draw_round_table, False),
)
