"""Synthetic floors with exact rooms, doors and walls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations, pairwise
from math import ceil, floor, inf
from typing import Literal

import numpy as np
from shapely import LineString, Polygon, box, unary_union

from pianta.errors import OptionError
from pianta.floor import Door, Floor, Room
from pianta.worlds.homes import make_home_floor
from pianta.worlds.wall_axes import (
    OUTER_WALL,
    Range,
    Seed,
    find_shared_wall,
    find_wall_axes,
    find_wall_body,
    round_to_mm,
)
from pianta.worlds.workplaces import make_depot_floor, make_office_floor, make_open_plan_floor, make_ward_floor

# The measures are usual ones of offices and schools (chosen by hand).
# Narrowest and widest door; metres.
DOOR_WIDTH = (0.8, 1.0)
# From the end of a wall's axis to the nearest jamb: half an outer wall, and 0.3 m of wall for the frame; metres.
DOOR_MARGIN = OUTER_WALL / 2 + 0.3
# Length of wall that a door needs; metres.
MIN_DOOR_WALL = DOOR_WIDTH[1] + 2 * DOOR_MARGIN
# Least share of the free length of a strip of rooms that goes to each room, before normalisation.
MIN_ROOM_SHARE = 0.2


def make_corridor_floor(
    *,
    seed: Seed = 0,
    length: float = 30.0,
    corridor_width: float = 2.4,
    room_depth: float = 6.0,
    room_width: Range = (3.0, 7.0),
) -> Floor:
    """Floor with a straight corridor along x and a row of rooms on either side.

    All lengths are metres between wall axes; room_width is the narrowest and, where the walls allow, the widest room.
    Raises OptionError when a length is not positive or leaves no space for a room and its door.
    """
    _check_lengths(length=length, corridor_width=corridor_width, room_depth=room_depth, room_width=min(room_width))
    rng = np.random.default_rng(seed)
    corridor = box(0, 0, length, corridor_width)
    south = _cut_strip((0, -room_depth, length, 0), "x", room_width, rng)
    north = _cut_strip((0, corridor_width, length, corridor_width + room_depth), "x", room_width, rng)
    return build_floor(corridor, [*south, *north], seed=rng, source="corridor")


def make_l_floor(
    *,
    seed: Seed = 0,
    lengths: Range = (26.0, 20.0),
    corridor_width: float = 2.4,
    room_depth: float = 6.0,
    room_width: Range = (3.0, 7.0),
) -> Floor:
    """Floor with an L-shaped corridor, its wings along x and y, and rooms along both sides of both wings.

    Options and errors as in make_corridor_floor; lengths are those of the wings, measured outside the elbow.
    """
    _check_lengths(
        length=min(lengths), corridor_width=corridor_width, room_depth=room_depth, room_width=min(room_width)
    )
    rng = np.random.default_rng(seed)
    (east, north), w, d = lengths, corridor_width, room_depth
    corridor = Polygon([(0, 0), (east, 0), (east, w), (w, w), (w, north), (0, north)])
    rooms = [
        *_cut_strip((0, -d, east, 0), "x", room_width, rng, overhang=(d, 0)),
        *_cut_strip((-d, 0, 0, north), "y", room_width, rng),
        *_cut_strip((w, w, east, w + d), "x", room_width, rng),
        *_cut_strip((w, w + d, w + d, north), "y", room_width, rng),
    ]
    return build_floor(corridor, rooms, seed=rng, source="l")


def make_ring_floor(
    *,
    seed: Seed = 0,
    length: float = 28.0,
    width: float = 14.0,
    corridor_width: float = 2.0,
    room_depth: float = 5.0,
    room_width: Range = (3.0, 7.0),
) -> Floor:
    """Floor with a ring corridor around two rows of inner rooms, and rooms all around it.

    Options and errors as in make_corridor_floor; length and width are those of the ring's outer edge.
    """
    _check_lengths(
        length=length,
        corridor_width=corridor_width,
        room_depth=room_depth,
        room_width=min(room_width),
        inner_width=width - 2 * corridor_width,
    )
    rng = np.random.default_rng(seed)
    west, south, east, north = corridor_width, corridor_width, length - corridor_width, width - corridor_width
    corridor = box(0, 0, length, width).difference(box(west, south, east, north))
    rooms = [
        *_cut_strip((west, south, east, width / 2), "x", room_width, rng),
        *_cut_strip((west, width / 2, east, north), "x", room_width, rng),
        *_surround(length, width, room_depth, room_width, rng),
    ]
    return build_floor(corridor, rooms, seed=rng, source="ring")


def make_hall_floor(
    *,
    seed: Seed = 0,
    length: float = 18.0,
    width: float = 12.0,
    room_depth: float = 5.0,
    room_width: Range = (3.0, 7.0),
    pillars: bool = True,
) -> Floor:
    """Floor with a hall, if wanted with pillars (holes of its polygon), and rooms all around it.

    Options and errors as in make_corridor_floor.
    """
    _check_lengths(length=length, width=width, room_depth=room_depth, room_width=min(room_width))
    rng = np.random.default_rng(seed)
    rooms = _surround(length, width, room_depth, room_width, rng)
    columns = _make_pillars(length, width) if pillars else []
    return build_floor(box(0, 0, length, width), rooms, label="HALL", pillars=columns, seed=rng, source="hall")


# Plain floors, all of one shape; benches and tests count on their number and order.
FLOOR_MAKERS: dict[str, Callable[..., Floor]] = {
    "corridor": make_corridor_floor,
    "l": make_l_floor,
    "ring": make_ring_floor,
    "hall": make_hall_floor,
}
# Floors of buildings for a purpose, which vary in shape and have a label for each room.
LABELLED_FLOOR_MAKERS: dict[str, Callable[..., Floor]] = {
    "home": make_home_floor,
    "office": make_office_floor,
    "open_plan": make_open_plan_floor,
    "ward": make_ward_floor,
    "depot": make_depot_floor,
}


def make_floor(name: str, *, seed: int) -> Floor:
    """Floor of a maker named in FLOOR_MAKERS or LABELLED_FLOOR_MAKERS, default options; its source is "name-seed".

    Raises OptionError for any other name.
    """
    makers = FLOOR_MAKERS | LABELLED_FLOOR_MAKERS
    if name not in makers:
        raise OptionError(f"floor is {name!r}, give one of {', '.join(makers)}")
    return replace(makers[name](seed=seed), source=f"{name}-{seed}")


def build_floor(
    passage: Polygon,
    rooms: Sequence[Polygon],
    *,
    label: str = "CORRIDOR",
    pillars: Sequence[Polygon] = (),
    side_doors: float = 0.1,
    seed: Seed = 0,
    source: str = "",
) -> Floor:
    """Floor from the wall axes around its spaces: walls of real thickness, and a door from each room to the passage.

    passage, rooms: polygons with sides along x and y that tile the floor, metres; the passage gets id 1 and the label.
    pillars: holes to be cut into the passage.
    side_doors: probability of a door between two neighbouring rooms.
    Raises OptionError, naming all of them, when rooms share too little wall with the passage for a door.
    """
    rng = np.random.default_rng(seed)
    spaces = dict(enumerate([passage, *rooms], start=1))
    shared = {pair: find_shared_wall(spaces[pair[0]], spaces[pair[1]]) for pair in combinations(spaces, 2)}
    closed = [room for (first, room), wall in shared.items() if first == 1 and wall.length < MIN_DOOR_WALL]
    if closed:
        raise OptionError(f"rooms {closed} share too little wall with room 1, give {MIN_DOOR_WALL:g} m for a door")
    axes = find_wall_axes(spaces.values())
    walls = find_wall_body(axes, unary_union([passage, *rooms]))
    inner = {room: round_to_mm(space.difference(unary_union([walls, *pillars]))) for room, space in spaces.items()}
    return Floor(
        rooms=tuple(Room(room, polygon, label=label if room == 1 else "ROOM") for room, polygon in inner.items()),
        doors=tuple(
            _place_door(pair, wall, rng)
            for pair, wall in shared.items()
            if wall.length >= MIN_DOOR_WALL and (pair[0] == 1 or rng.random() < side_doors)
        ),
        walls=axes,
        source=source,
    )


def _cut_strip(
    bounds: tuple[float, float, float, float],
    along: Literal["x", "y"],
    room_width: Range,
    rng: np.random.Generator,
    overhang: Range = (0, 0),
) -> list[Polygon]:
    """Rooms between cross walls of a strip (x0, y0, x1, y1); the first and last extend beyond it by the overhang."""
    x0, y0, x1, y1 = bounds
    if along == "y":
        return [box(x0, a, x1, b) for a, b in pairwise(_draw_cross_walls(y0, y1, room_width, rng))]
    walls = _draw_cross_walls(x0, x1, room_width, rng)
    walls[0] -= overhang[0]
    walls[-1] += overhang[1]
    return [box(a, y0, b, y1) for a, b in pairwise(walls)]


def _draw_cross_walls(start: float, stop: float, room_width: Range, rng: np.random.Generator) -> list[float]:
    """Coordinates of walls from start to stop, at least the narrow width apart, rounded to centimetres."""
    narrow, wide = room_width
    most = floor((stop - start) / narrow + 1e-9)
    if most < 1:
        raise OptionError(f"{stop - start:g} m of wall hold no room, give a room_width that starts below {narrow:g} m")
    fewest = min(ceil((stop - start) / wide - 1e-9), most)
    count = int(rng.integers(fewest, most + 1))
    shares = np.cumsum(MIN_ROOM_SHARE + rng.random(count))
    spare = (stop - start) - count * narrow
    walls = start + narrow * np.arange(1, count) + spare * shares[:-1] / shares[-1]
    return [start, *(float(wall) for wall in walls.round(2)), stop]


def _surround(
    length: float, width: float, room_depth: float, room_width: Range, rng: np.random.Generator
) -> list[Polygon]:
    """Rooms on the four sides of the rectangle from (0, 0) to (length, width)."""
    d = room_depth
    return [
        *_cut_strip((0, -d, length, 0), "x", room_width, rng, overhang=(d, d)),
        *_cut_strip((length, 0, length + d, width), "y", room_width, rng),
        *_cut_strip((0, width, length, width + d), "x", room_width, rng, overhang=(d, d)),
        *_cut_strip((-d, 0, 0, width), "y", room_width, rng),
    ]


def _make_pillars(length: float, width: float, *, spacing: float = 5.0, size: float = 0.5) -> list[Polygon]:
    """Square pillars on an even grid inside the rectangle from (0, 0) to (length, width)."""
    columns, rows = (np.linspace(0, side, max(round(side / spacing), 1) + 1)[1:-1] for side in (length, width))
    return [box(x - size / 2, y - size / 2, x + size / 2, y + size / 2) for x in columns for y in rows]


def _place_door(rooms: tuple[int, int], wall: LineString, rng: np.random.Generator) -> Door:
    """Door at a random position on the axis of a wall, clear of its ends; rounded to centimetres."""
    narrow, wide = DOOR_WIDTH
    width = round(narrow + (wide - narrow) * rng.random(), 2)
    start = round(DOOR_MARGIN + (wall.length - 2 * DOOR_MARGIN - width) * rng.random(), 2)
    jambs = [wall.interpolate(start), wall.interpolate(start + width)]
    return Door(rooms, round_to_mm(LineString(jambs)), width)


def _check_lengths(**lengths: float) -> None:
    """Raise OptionError naming all lengths that are not positive."""
    faults = [f"{name} is {value}" for name, value in lengths.items() if not 0 < value < inf]
    if faults:
        raise OptionError("not a floor: " + "; ".join(faults) + "; give positive metres")
