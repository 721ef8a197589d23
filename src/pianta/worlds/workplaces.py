"""Synthetic offices, open-plan offices, wards of hospitals, and depots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from shapely import Polygon, box

from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.worlds.layouts import (
    Layout,
    LayoutError,
    Strip,
    add_columns,
    add_oblique_corner,
    add_pilasters,
    add_stub,
    round_box,
    turn_layout,
)
from pianta.worlds.wall_axes import Range, Seed

# Layouts that are drawn until one can be built.
ATTEMPTS = 300
# The measures are usual ones of such buildings (chosen by hand).
# Share of the rooms that have a door to the room beside them.
SIDE_DOOR_SHARE = 0.12
# Share of the rooms with a closet or a niche of the passage in a corner.
CORNER_SHARE = 0.12
# Share of the floors with an oblique corner.
OBLIQUE_SHARE = 0.1
# Share of the floors with piers along their outer walls.
PIER_SHARE = 0.3
# Rooms that are at least so wide are large, and stand in corners of buildings; metres.
LARGE_WIDTH = 3.4
# Rooms of at least this area may have columns; m².
COLUMN_AREA = 90.0
# Distance of columns; metres.
COLUMN_SPACING = (4.5, 7.5)
# Side of columns; metres.
COLUMN_SIZE = (0.3, 0.6)


@dataclass(frozen=True)
class RoomType:
    """A type of room along a passage.

    width: along the passage, metres; weight: how often it occurs.
    door: widths of its door, metres; opening: widths of its opening, metres, where it is open to the passage.
    open_share: how often it is open; bath_share: how often it has a bathroom of its own in a corner.
    """

    label: str
    width: Range
    weight: float
    door: Range = (0.8, 1.0)
    opening: Range = (2.0, 6.0)
    open_share: float = 0.0
    bath_share: float = 0.0


OFFICE_TYPES = (
    RoomType("OFFICE", (2.4, 4.5), 10),
    RoomType("SHARED OFFICE", (4.5, 8.0), 3),
    RoomType("EXECUTIVE OFFICE", (4.0, 6.5), 1),
    RoomType("CONFERENCE ROOM", (3.5, 8.0), 2, door=(0.9, 1.7)),
    RoomType("OPENSPACE", (12, 28), 1.5, door=(0.9, 1.8), open_share=0.4),
    RoomType("KITCHEN", (2.4, 4.5), 0.8, opening=(1.5, 3.5), open_share=0.5),
    RoomType("BATHROOM", (2.0, 4.0), 0.9),
    RoomType("CLOSET", (1.3, 2.8), 0.8, door=(0.7, 0.9)),
    RoomType("STAIRS", (2.6, 3.4), 0.5, door=(0.9, 1.4)),
    RoomType("LOBBY", (3.0, 7.0), 0.6, open_share=0.9),
    RoomType("RECEPTION", (3.5, 6.0), 0.3, open_share=0.7),
)
OPEN_PLAN_TYPES = (
    RoomType("CONFERENCE ROOM", (2.5, 6.0), 3, door=(0.8, 1.7)),
    RoomType("OFFICE", (2.4, 4.0), 3),
    RoomType("CLOSET", (1.3, 2.2), 1, door=(0.7, 0.9)),
    RoomType("CUBICULE", (1.3, 1.8), 1, door=(0.7, 0.8)),
    RoomType("KITCHEN", (3.0, 6.0), 0.8, open_share=0.7),
    RoomType("BATHROOM", (2.0, 4.0), 0.8),
    RoomType("LOBBY", (3.0, 6.0), 0.6, open_share=0.9),
)
WARD_TYPES = (
    RoomType("WARD", (3.4, 6.5), 9, door=(1.1, 1.4), bath_share=0.75),
    RoomType("OFFICE", (2.6, 4.0), 1),
    RoomType("CLOSET", (1.6, 3.2), 1.2),
    RoomType("BATHROOM", (1.8, 3.0), 0.8),
    RoomType("RECEPTION", (3.5, 6.5), 0.9, opening=(2.0, 5.0), open_share=1),
    RoomType("LOBBY", (3.5, 7.0), 0.6, open_share=0.8),
    RoomType("KITCHEN", (2.4, 4.0), 0.4),
    RoomType("STAIRS", (2.8, 3.4), 0.4, door=(1.0, 1.5)),
)
DEPOT_TYPES = (
    RoomType("OFFICE", (2.5, 5.0), 3),
    RoomType("CLOSET", (1.8, 5.0), 2, door=(0.8, 2.0)),
    RoomType("BATHROOM", (1.8, 3.5), 1),
    RoomType("LOBBY", (3.0, 6.0), 1, open_share=0.6),
)


def make_office_floor(*, seed: Seed = 0, length: float | None = None) -> Floor:
    """Floor of an office: corridors in a line, an L, a T or a ring, with rooms along them; fire doors cut corridors.

    length: of the longest corridor, metres; drawn unless given.
    Raises OptionError when the length is not 12 … 100 m.
    """
    _check_length(length)

    def draw(rng: np.random.Generator) -> Layout:
        corridor_width, depth = (
            rng.uniform(1.5, 2.8),
            rng.uniform(*((4.0, 7.0) if rng.random() < 0.75 else (7.0, 10.0))),
        )
        shape = str(rng.choice(["line", "l", "t", "ring"], p=(0.35, 0.25, 0.2, 0.2)))
        size = float(rng.uniform(16, 50)) if length is None else length
        return _draw_corridor_layout(shape, (size, corridor_width, depth), OFFICE_TYPES, rng)

    return _draw_until_built(draw, seed, "office")


def make_ward_floor(*, seed: Seed = 0, length: float | None = None) -> Floor:
    """Floor of a hospital or care home: rooms for patients with bathrooms, nurse stations open to wide corridors.

    length: of the longest corridor, metres; drawn unless given.
    Raises OptionError when the length is not 12 … 100 m.
    """
    _check_length(length)

    def draw(rng: np.random.Generator) -> Layout:
        corridor_width, depth = rng.uniform(2.0, 3.2), rng.uniform(4.8, 7.0)
        shape = str(rng.choice(["line", "l", "t", "ring"], p=(0.5, 0.2, 0.15, 0.15)))
        size = float(rng.uniform(24, 60)) if length is None else length
        return _draw_corridor_layout(shape, (size, corridor_width, depth), WARD_TYPES, rng)

    return _draw_until_built(draw, seed, "ward")


def make_open_plan_floor(*, seed: Seed = 0) -> Floor:
    """Floor of an open-plan office: a large room with columns, and small rooms on some of its sides and in its core."""

    def draw(rng: np.random.Generator) -> Layout:
        length, width = (round(float(size), 2) for size in (rng.uniform(12, 30), rng.uniform(8, 16)))
        layout = _new_layout(rng)
        hub = layout.add(round_box(0, 0, length, width), "OPENSPACE")
        if rng.random() < 0.35 and length > 18 and width > 11:
            _add_core(layout, hub, length, width)
        _surround(layout, hub, OPEN_PLAN_TYPES, depth=(2.4, 4.5), share=0.55)
        return layout

    return _draw_until_built(draw, seed, "open_plan")


def make_depot_floor(*, seed: Seed = 0) -> Floor:
    """Floor of a warehouse or depot: one or two halls with columns and a wide gate between, and a few side rooms."""

    def draw(rng: np.random.Generator) -> Layout:
        length, width = (round(float(size), 2) for size in (rng.uniform(14, 45), rng.uniform(10, 32)))
        layout = _new_layout(rng)
        hub = layout.add(round_box(0, 0, length, width), "WAREHOUSE")
        if rng.random() < 0.35:
            second = rng.uniform(10, 30)
            layout.add(round_box(-second, 0, 0, width * rng.uniform(0.6, 1)), "WAREHOUSE")
            gate = rng.random() < 0.6
            layout.join(1, [hub], (2.5, 5.0) if gate else (1.0, 2.0), door_kind="opening" if gate else "door")
        _surround(layout, hub, DEPOT_TYPES, depth=(2.5, 5.0), share=0.4, sides=("south", "east", "north"))
        return layout

    return _draw_until_built(draw, seed, "depot")


def _draw_until_built(draw: Callable[[np.random.Generator], Layout], seed: Seed, source: str) -> Floor:
    """The first of the drawn layouts that can be built, with columns and stubs, at a random turn."""
    rng = np.random.default_rng(seed)
    for _ in range(ATTEMPTS):
        try:
            layout = draw(rng)
            _add_columns(layout)
            turn_layout(layout)
            return layout.build(source)
        except LayoutError:
            continue
    raise OptionError(f"no {source} of this size could be drawn, give other options or another seed")


def _new_layout(rng: np.random.Generator) -> Layout:
    return Layout(rng, inner_wall=float(rng.choice([0.1, 0.12, 0.15, 0.2])), outer_wall=0.35)


def _draw_corridor_layout(
    shape: str, sizes: tuple[float, float, float], types: Sequence[RoomType], rng: np.random.Generator
) -> Layout:
    """Corridors of a shape with rooms on both sides; sizes: their length and width, and the depth of rooms, metres."""
    layout = _new_layout(rng)
    length, width, depth = (round(float(size), 2) for size in sizes)
    corridor, strips = _SHAPES[shape](length, width, depth, rng)
    pieces = [layout.add(piece, "CORRIDOR") for piece in _cut_corridor(corridor, width, rng)]
    for first, second in pairwise(pieces):
        layout.join(
            second, [first], width - rng.uniform(0.3, 0.6), door_kind="opening" if rng.random() < 0.1 else "door"
        )
    for strip, overhang in strips:
        _fill_strip(layout, strip, pieces, types, overhang)
    return layout


Skeleton = tuple[Polygon, list[tuple[Strip, Range]]]


def _draw_line(length: float, w: float, d: float, rng: np.random.Generator) -> Skeleton:
    """A straight corridor; rarely, rooms on one side only."""
    strips: list[tuple[Strip, Range]] = [(Strip((0, 0), (1, 0), (0, -1), length, d), (0, 0))]
    if rng.random() < 0.88:
        strips.append((Strip((0, w), (1, 0), (0, 1), length, d * rng.uniform(0.7, 1.2)), (0, 0)))
    return box(0, 0, length, w), strips


def _draw_l(length: float, w: float, d: float, rng: np.random.Generator) -> Skeleton:
    """Wings along x and y, as in make_l_floor."""
    north = round(max(length * rng.uniform(0.5, 1.0), w + d + 6), 2)
    corridor = Polygon([(0, 0), (length, 0), (length, w), (w, w), (w, north), (0, north)])
    return corridor, [
        (Strip((0, 0), (1, 0), (0, -1), length, d), (d, 0)),
        (Strip((0, 0), (0, 1), (-1, 0), north, d), (0, 0)),
        (Strip((w, w), (1, 0), (0, 1), length - w, d), (0, 0)),
        (Strip((w, w + d), (0, 1), (1, 0), north - w - d, d), (0, 0)),
    ]


def _draw_t(length: float, w: float, d: float, rng: np.random.Generator) -> Skeleton:
    """A straight corridor with a branch to the north."""
    middle = round(length * rng.uniform(0.35, 0.6), 2)
    north = round(w + d + rng.uniform(6, 16), 2)
    if middle < d + 3 or length - middle - w < d + 3:
        raise LayoutError("the branch is too near the end")
    corridor = box(0, 0, length, w).union(box(middle, w, middle + w, north))
    return corridor, [
        (Strip((0, 0), (1, 0), (0, -1), length, d), (0, 0)),
        (Strip((0, w), (1, 0), (0, 1), middle, d), (0, 0)),
        (Strip((middle + w, w), (1, 0), (0, 1), length - middle - w, d), (0, 0)),
        (Strip((middle, w + d), (0, 1), (-1, 0), north - w - d, d), (0, 0)),
        (Strip((middle + w, w + d), (0, 1), (1, 0), north - w - d, d), (0, 0)),
    ]


def _draw_ring(length: float, w: float, d: float, rng: np.random.Generator) -> Skeleton:
    """A ring around one or two rows of inner rooms."""
    core = 2 * round(d * rng.uniform(0.7, 1.0) * (1 if rng.random() < 0.6 else 0.5), 2)
    length, width = max(length, 2 * w + 9), 2 * w + core
    corridor = box(0, 0, length, width).difference(box(w, w, length - w, width - w))
    strips: list[tuple[Strip, Range]] = [
        (Strip((0, 0), (1, 0), (0, -1), length, d), (d, d)),
        (Strip((length, 0), (0, 1), (1, 0), width, d), (0, 0)),
        (Strip((0, width), (1, 0), (0, 1), length, d), (d, d)),
        (Strip((0, 0), (0, 1), (-1, 0), width, d), (0, 0)),
        (Strip((w, w), (1, 0), (0, 1), length - 2 * w, core if core <= d else core / 2), (0, 0)),
    ]
    if core > d:
        strips.append((Strip((w, width - w), (1, 0), (0, -1), length - 2 * w, core / 2), (0, 0)))
    return corridor, strips


_SHAPES: dict[str, Callable[[float, float, float, np.random.Generator], Skeleton]] = {
    "line": _draw_line,
    "l": _draw_l,
    "t": _draw_t,
    "ring": _draw_ring,
}


def _cut_corridor(corridor: Polygon, width: float, rng: np.random.Generator) -> list[Polygon]:
    """The corridor, or what two or three fire doors across its part along x make of it, from west to east."""
    x0, _, x1, _ = corridor.bounds
    if corridor.interiors or x1 - x0 < 18 or rng.random() < 0.45:
        return [corridor]
    count = int(rng.integers(1, 2 + (x1 - x0 > 35)))
    cuts = sorted(rng.uniform(x0 + width + 5, x1 - 5, count))
    pieces, low = [], x0 - 1.0
    for cut in (*cuts, x1 + 1.0):
        if cut - low < 5:
            raise LayoutError("fire doors are too near")
        piece = corridor.intersection(round_box(low, -1000, cut, 1000))
        # A piece that is cut lengthwise through a branch would be in two parts, or the branch would be halved.
        pieces.append(piece)
        low = cut
    heights = [corridor.intersection(round_box(cut - width, -1000, cut + width, 1000)).bounds for cut in cuts]
    if any(y1 - y0 > 1.01 * width for _, y0, _, y1 in heights):
        raise LayoutError("a fire door would cut a branch")
    return pieces


def _draw_columns(length: float, types: Sequence[RoomType], rng: np.random.Generator) -> list[tuple[RoomType, float]]:
    """Types of rooms and their widths, metres, that fill a length."""
    weights = np.array([room.weight for room in types])
    columns: list[tuple[RoomType, float]] = []
    left = length
    while left > 0:
        fitting = [index for index, room in enumerate(types) if room.width[0] <= left]
        if not fitting:
            break
        index = int(rng.choice(fitting, p=weights[fitting] / weights[fitting].sum()))
        # Offices beside each other often are of one width.
        repeats = 1 + int(rng.integers(0, 4)) if types[index].weight > 2 else 1
        width = min(float(rng.uniform(*types[index].width)), left)
        for _ in range(repeats):
            if width <= left:
                columns.append((types[index], width))
                left -= width
    if not columns:
        raise LayoutError("a strip is too short")
    scale = length / sum(width for _, width in columns)
    if scale > 1.6:
        raise LayoutError("a strip is too short")
    return [(room, width * scale) for room, width in columns]


def _draw_large_type(types: Sequence[RoomType], rng: np.random.Generator) -> RoomType:
    """A type of large rooms."""
    large = [room for room in types if room.width[0] >= LARGE_WIDTH]
    weights = np.array([room.weight for room in large])
    return large[int(rng.choice(len(large), p=weights / weights.sum()))]


def _fill_strip(
    layout: Layout, strip: Strip, passages: Sequence[int], types: Sequence[RoomType], overhang: Range = (0, 0)
) -> None:
    """Add rooms along a passage, with doors or openings to it; overhang: beyond the first and last room, metres."""
    rng, start, before = layout.rng, 0.0, None
    columns = _draw_columns(strip.length, types, rng)
    for number, (room_type, width) in enumerate(columns):
        room = room_type
        stop = strip.length if number == len(columns) - 1 else round(start + width, 2)
        if (number == 0 and overhang[0] > 0) or (number == len(columns) - 1 and overhang[1] > 0):
            # Rooms in corners of the building are large.
            room = _draw_large_type(types, rng)
        west = start - (overhang[0] if number == 0 else 0)
        east = stop + (overhang[1] if number == len(columns) - 1 else 0)
        space = layout.add(strip.box(west, east, 0, strip.depth), room.label)
        if rng.random() < room.open_share:
            layout.join(space, passages, room.opening, door_kind="opening")
        else:
            layout.join(space, passages, room.door)
        if width > 9:
            layout.join(space, passages, room.door, optional=True)
        if before is not None and rng.random() < SIDE_DOOR_SHARE:
            layout.join(space, [before], (0.8, 0.9), optional=True)
        _cut_corner(layout, strip, space, room=room, passages=passages, ends=(start, stop))
        start, before = stop, space


def _cut_corner(
    layout: Layout, strip: Strip, space: int, *, room: RoomType, passages: Sequence[int], ends: Range
) -> None:
    """Perhaps cut a bathroom, a closet or a niche of the passage out of a corner of a room."""
    rng, (start, stop) = layout.rng, ends
    has_bath = rng.random() < room.bath_share
    if not has_bath and (rng.random() > CORNER_SHARE or room.label in ("STAIRS", "CLOSET", "KITCHEN", "CUBICULE")):
        return
    width, depth = (rng.uniform(1.5, 2.3), rng.uniform(1.6, 2.5)) if has_bath else rng.uniform(0.8, 2.0, 2)
    front = 1.8 if has_bath else 1.6
    if stop - start - width < front or strip.depth - depth < 1.5:
        return
    part = strip.box(start, start + width, 0, depth) if rng.random() < 0.5 else strip.box(stop - width, stop, 0, depth)
    if has_bath:
        layout.join(layout.carve(space, part, "BATHROOM"), [space], (0.8, 1.0))
    elif rng.random() < 0.5:
        passage = max(passages, key=lambda number: layout.spaces[number].intersection(part).length)
        layout.move(part, space, passage)
    elif min(width, depth) > 1.1:
        layout.join(layout.carve(space, part, "CLOSET"), passages, (0.7, 0.9))


def _surround(
    layout: Layout,
    hub: int,
    types: Sequence[RoomType],
    *,
    depth: Range,
    share: float,
    sides: Sequence[str] = ("south", "east", "north", "west"),
) -> None:
    """Add rooms on some sides of a hall, or of a part of a side; share: how often a side has rooms."""
    rng = layout.rng
    _, _, length, width = layout.spaces[hub].bounds
    strips = {
        "south": ((0.0, 0.0), (1, 0), (0, -1), length),
        "east": ((length, 0.0), (0, 1), (1, 0), width),
        "north": ((0.0, width), (1, 0), (0, 1), length),
        "west": ((0.0, 0.0), (0, 1), (-1, 0), width),
    }
    chosen = [side for side in sides if rng.random() < share] or [sides[int(rng.integers(len(sides)))]]
    for side in chosen:
        origin, along, inward, size = strips[side]
        part = size if rng.random() < 0.6 else max(size * rng.uniform(0.4, 0.8), 5.0)
        strip = Strip(origin, along, inward, round(min(part, size), 2), round(float(rng.uniform(*depth)), 2))
        _fill_strip(layout, strip, [hub], types)


def _add_core(layout: Layout, hub: int, length: float, width: float) -> None:
    """Put a core of stairs, lift, toilets and stores in the middle of a hall."""
    rng = layout.rng
    depth = rng.uniform(2.6, 3.6)
    part = length * rng.uniform(0.25, 0.4)
    x0, y0 = (length - part) / 2, (width - depth) / 2
    core = round_box(x0, y0, x0 + part, y0 + depth)
    layout.spaces[hub] = layout.spaces[hub].difference(core)
    labels = ("STAIRS", "BATHROOM", "BATHROOM", "CLOSET", "ELEVATOR")
    walls = [round(float(wall), 2) for wall in np.linspace(core.bounds[0], core.bounds[2], max(int(part / 2.4), 1) + 1)]
    for x, x_next in pairwise(walls):
        space = layout.add(round_box(x, core.bounds[1], x_next, core.bounds[3]), str(rng.choice(labels)))
        layout.join(space, [hub], (0.8, 1.0))


def _add_columns(layout: Layout) -> None:
    """Add columns to large rooms, stubs of walls to some of them, and perhaps piers to all outer walls."""
    rng = layout.rng
    if rng.random() < OBLIQUE_SHARE:
        add_oblique_corner(layout, rng.uniform(1.0, 4.0))
    if rng.random() < PIER_SHARE:
        spacing, width, depth = rng.uniform((2.5, 0.25, 0.08), (7.5, 0.6, 0.35))
        add_pilasters(layout, spacing=spacing, width=width, depth=depth)
    for number, space in enumerate(layout.spaces):
        if layout.labels[number] != "CORRIDOR" and space.area > COLUMN_AREA and rng.random() < 0.6:
            add_columns(layout, number, spacing=rng.uniform(*COLUMN_SPACING), size=rng.uniform(*COLUMN_SIZE))
        if layout.labels[number] in ("OPENSPACE", "LOBBY", "CORRIDOR", "WAREHOUSE") and rng.random() < 0.2:
            add_stub(layout, number, float(rng.uniform(0.25, 0.6)))


def _check_length(length: float | None) -> None:
    """Raise OptionError for a corridor that is too short or too long."""
    if length is not None and not 12 <= length <= 100:
        raise OptionError(f"length is {length}, give 12 … 100 m")
