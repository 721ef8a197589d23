"""Layouts: spaces that tile a floor, and the doors and openings to place in the walls between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from shapely import LineString, Point, Polygon, box, get_coordinates, set_precision, transform, unary_union
from shapely.geometry.base import BaseGeometry

from pianta._types import Floats
from pianta.floor import Door, Floor, Room
from pianta.floor.polygons import list_polygons
from pianta.worlds.wall_axes import Range, find_shared_wall, find_wall_axes, round_to_mm, split_sides

DoorKind = Literal["door", "opening"]

# Coordinates of wall axes are multiples of this, so that walls of neighbours meet exactly; metres.
LATTICE = 0.01
# The measures below were chosen by hand.
# From the end of a wall's axis to the nearest jamb, at least; metres.
DOOR_MARGIN = 0.15
# From a door's jamb to a stub, a column or another door, at least; metres.
CLEAR_OF_DOOR = 0.35
# Narrowest door that a short wall gets instead of a wider one; metres.
NARROWEST_DOOR = 0.65
# Share of the doors that stand in a corner of their wall.
CORNER_SHARE = 0.55
# Attempts to find a free position for a door in its wall.
ATTEMPTS = 20
# Share of the walls that are thicker than others, such as those that bear the building.
THICK_SHARE = 0.15
# Thickest wall between rooms; metres.
THICKEST_WALL = 0.35
# Share of the rooms with columns whose columns are round.
ROUND_SHARE = 0.3
# Narrower places of rooms, left by walls, are no part of them; metres.
NARROWEST_ROOM = 0.3


class LayoutError(Exception):
    """A random layout that cannot be built; its maker draws another one."""


@dataclass(frozen=True)
class DoorRequest:
    """A door or opening that a layout gets: from a space to that of the others with which it shares most wall.

    width: metres; a short wall narrows it. An optional one is left out where it finds no wall.
    """

    space: int
    others: Sequence[int]
    width: float
    kind: DoorKind = "door"
    optional: bool = False


@dataclass
class Layout:
    """Spaces between wall axes with labels, requested doors, and solid blocks; polygons have sides along x and y.

    inner_wall, outer_wall: thickness, metres. Spaces are numbered from 0; rooms get the next higher id.
    """

    rng: np.random.Generator
    inner_wall: float = 0.12
    outer_wall: float = 0.3
    spaces: list[Polygon] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)
    requests: list[DoorRequest] = field(default_factory=list)
    blocks: list[Polygon] = field(default_factory=list)

    def add(self, space: BaseGeometry, label: str) -> int:
        """Add a space and return its number; LayoutError if it is in several parts or empty."""
        self.spaces.append(_one_polygon(space))
        self.labels.append(label)
        return len(self.spaces) - 1

    def carve(self, space: int, part: Polygon, label: str) -> int:
        """Cut a part off a space as a space of its own, and return its number."""
        self.spaces[space] = _one_polygon(self.spaces[space].difference(part))
        return self.add(part, label)

    def move(self, part: Polygon, source: int, target: int) -> None:
        """Cut a part off one space and join it to another without a wall."""
        self.spaces[source] = _one_polygon(self.spaces[source].difference(part))
        self.spaces[target] = _one_polygon(self.spaces[target].union(part))

    def join(
        self,
        space: int,
        others: Sequence[int],
        width: float | Range,
        *,
        door_kind: DoorKind = "door",
        optional: bool = False,
    ) -> None:
        """Request a door; a range of widths is drawn from."""
        metres = width if isinstance(width, int | float) else self.rng.uniform(*width)
        self.requests.append(DoorRequest(space, tuple(others), round(float(metres), 2), door_kind, optional))

    def build(self, source: str) -> Floor:
        """The floor; LayoutError if a requested door finds no wall, or a room is too small for its walls."""
        lines: list[LineString] = []
        doors = [door for request in self.requests if (door := self._place_door(request, lines)) is not None]
        axes = find_wall_axes(self.spaces)
        inner = [wall for axis in axes for wall in self._draw_wall(axis)]
        outer = unary_union(self.spaces).boundary.buffer(self.outer_wall / 2, join_style="mitre")
        solid = unary_union([*inner, outer, *self._clear_blocks(lines)])
        rooms = tuple(
            Room(number, _room_inside(space, solid), label=label)
            for number, (space, label) in enumerate(zip(self.spaces, self.labels, strict=True), start=1)
        )
        self._check_reach(doors)
        return Floor(rooms, tuple(doors), axes, source=source)

    def _draw_wall(self, axis: LineString) -> list[Polygon]:
        """The body of a wall, which may be thicker than others; its ends are not, so that it ends in other walls."""
        wall = axis.buffer(self.inner_wall / 2, cap_style="square")
        if self.rng.random() >= THICK_SHARE:
            return [wall]
        thickness = min(self.inner_wall * self.rng.uniform(1.3, 2.5), THICKEST_WALL)
        return [wall, axis.buffer(thickness / 2, cap_style="flat")]

    def _place_door(self, request: DoorRequest, lines: list[LineString]) -> Door | None:
        """The requested door, clear of those before; its line joins them. None for an optional one without wall."""
        others = [other for other in request.others if other != request.space]
        walls = [find_shared_wall(self.spaces[request.space], self.spaces[other]) for other in others]
        lengths = [wall.length for wall in walls]
        if not lengths or max(lengths) < NARROWEST_DOOR + 2 * DOOR_MARGIN:
            if request.optional:
                return None
            raise LayoutError("a door finds no wall")
        wall, other = walls[int(np.argmax(lengths))], others[int(np.argmax(lengths))]
        width = round(min(request.width, wall.length - 2 * DOOR_MARGIN) - 0.005, 2)
        for _ in range(ATTEMPTS):
            line = self._draw_door_line(wall, width)
            if all(line.distance(before) > CLEAR_OF_DOOR for before in lines):
                lines.append(line)
                return Door((request.space + 1, other + 1), line, width, request.kind)
        if request.optional:
            return None
        raise LayoutError("doors meet")

    def _draw_door_line(self, wall: LineString, width: float) -> LineString:
        free = wall.length - 2 * DOOR_MARGIN - width
        if self.rng.random() < CORNER_SHARE:
            start = min(0.25 * self.rng.random(), free)
            start = start if self.rng.random() < 0.5 else free - start
        else:
            start = free * self.rng.random()
        ends = [wall.interpolate(DOOR_MARGIN + start), wall.interpolate(DOOR_MARGIN + start + width)]
        return round_to_mm(LineString(ends))

    def _clear_blocks(self, lines: Sequence[LineString]) -> list[Polygon]:
        """The blocks that stand in the way of no door."""
        doors = unary_union([line.buffer(2 * CLEAR_OF_DOOR) for line in lines])
        return [block for block in self.blocks if block.disjoint(doors)]

    def _check_reach(self, doors: Sequence[Door]) -> None:
        """Raise LayoutError unless every room can be reached from the first."""
        reached, size = {1}, 0
        while len(reached) > size:
            size = len(reached)
            for door in doors:
                if reached & set(door.room_ids):
                    reached |= set(door.room_ids)
        if len(reached) < len(self.spaces):
            raise LayoutError("not every room can be reached")


@dataclass(frozen=True)
class Strip:
    """A strip of rooms along a passage: a starts where along leads from, b is 0 at the passage and grows inward.

    origin, along, inward: x and y, metres; along and inward are unit vectors along the axes.
    """

    origin: tuple[float, float]
    along: tuple[int, int]
    inward: tuple[int, int]
    length: float
    depth: float

    def box(self, a0: float, a1: float, b0: float, b1: float) -> Polygon:
        """The rectangle from a0 to a1 and from b0 to b1."""
        (x, y), (ax, ay), (bx, by) = self.origin, self.along, self.inward
        xs = [x + a * ax + b * bx for a, b in ((a0, b0), (a1, b1))]
        ys = [y + a * ay + b * by for a, b in ((a0, b0), (a1, b1))]
        return round_box(min(xs), min(ys), max(xs), max(ys))


def round_box(x0: float, y0: float, x1: float, y1: float) -> Polygon:
    """A rectangle with its corners on the lattice."""
    return box(*(round(round(value / LATTICE) * LATTICE, 2) for value in (x0, y0, x1, y1)))


def add_stub(layout: Layout, space: int, length: float) -> None:
    """Add a short piece of wall that stands out from a side of a space, metres long."""
    x, y, ux, uy = _draw_side_position(layout, space)
    stub = LineString([(x, y), (x + length * ux, y + length * uy)])
    layout.blocks.append(stub.buffer(layout.inner_wall / 2, cap_style="flat"))


def add_shaft(layout: Layout, space: int, size: float) -> None:
    """Add a solid block in a corner of a space, such as a chimney or a shaft for pipes; size of its sides, metres."""
    x, y = get_coordinates(layout.spaces[space].exterior)[int(layout.rng.integers(4))]
    layout.blocks.append(Point(x, y).buffer(size, cap_style="square"))


def add_columns(layout: Layout, space: int, *, spacing: float, size: float) -> None:
    """Add square or round columns on an even grid to a space; spacing, size of a side, metres."""
    x0, y0, x1, y1 = layout.spaces[space].bounds
    xs, ys = (np.linspace(a, b, max(round((b - a) / spacing), 1) + 1) for a, b in ((x0, x1), (y0, y1)))
    inside = layout.spaces[space].buffer(-size)
    is_round = layout.rng.random() < ROUND_SHARE
    for x in xs:
        for y in ys:
            if inside.contains(Point(x, y)):
                column = Point(x, y).buffer(size / 2, quad_segs=4, cap_style="round" if is_round else "square")
                layout.blocks.append(column)


def add_oblique_corner(layout: Layout, size: float) -> None:
    """Fill one of the outermost corners of the floor with a solid triangle; size: its legs along the walls, metres."""
    outline = unary_union(layout.spaces)
    x0, y0, x1, y1 = outline.bounds
    signs = [(1, 1), (1, -1), (-1, 1), (-1, -1)]
    sign_x, sign_y = signs[int(layout.rng.integers(4))]
    x, y = x1 if sign_x > 0 else x0, y1 if sign_y > 0 else y0
    if outline.intersects(Point(x, y)):
        share = layout.rng.uniform(0.5, 1.5)
        layout.blocks.append(Polygon([(x, y), (x - sign_x * size * share, y), (x, y - sign_y * size)]))


def add_pilasters(layout: Layout, *, spacing: float, width: float, depth: float) -> None:
    """Add piers that stand out from the outer walls at even distances; measures in metres."""
    reach = depth + layout.outer_wall / 2
    for side in split_sides(unary_union(layout.spaces).simplify(0).boundary):
        half = (width / 2, reach) if side.bounds[1] == side.bounds[3] else (reach, width / 2)
        for position in np.arange(spacing / 2, side.length, spacing):
            x, y = side.interpolate(position).coords[0]
            layout.blocks.append(box(x - half[0], y - half[1], x + half[0], y + half[1]))


def turn_layout(layout: Layout) -> None:
    """Mirror or turn all spaces and blocks at random by multiples of a quarter turn."""
    flip_x, flip_y, swap = (bool(draw < 0.5) for draw in layout.rng.random(3))

    def turn(xy: Floats) -> Floats:
        flipped = xy * (-1 if flip_x else 1, -1 if flip_y else 1)
        return flipped[:, ::-1] if swap else flipped

    layout.spaces = [transform(space, turn) for space in layout.spaces]
    layout.blocks = [transform(block, turn) for block in layout.blocks]


def _draw_side_position(layout: Layout, space: int) -> tuple[float, float, float, float]:
    """A point on a side of a space, and the unit vector into the space."""
    xy = get_coordinates(layout.spaces[space].normalize().exterior)
    sides = np.diff(xy, axis=0)
    lengths = np.abs(sides).sum(axis=1)
    side = int(layout.rng.choice(len(sides), p=lengths / lengths.sum()))
    x, y = xy[side] + sides[side] * layout.rng.uniform(0.2, 0.8)
    # A normalised shell runs clockwise, so the space is on the right of its sides.
    ux, uy = sides[side][1] / lengths[side], -sides[side][0] / lengths[side]
    return float(x), float(y), float(ux), float(uy)


def _room_inside(space: Polygon, solid: BaseGeometry) -> Polygon:
    """The part of a space that walls and blocks leave, without slivers; LayoutError if nothing is left."""
    left = space.difference(solid)
    parts = [part for part in list_polygons(left) if not part.buffer(-NARROWEST_ROOM).is_empty]
    if not parts:
        raise LayoutError("a room is too small")
    inside = round_to_mm(max(parts, key=lambda part: part.area))
    if not inside.is_valid:
        raise LayoutError("an oblique wall meets a corner")
    return inside


def _one_polygon(geometry: BaseGeometry) -> Polygon:
    """The geometry on the lattice as one polygon; LayoutError if it is empty or in several parts."""
    polygon = set_precision(geometry, LATTICE)
    if not isinstance(polygon, Polygon) or polygon.is_empty:
        raise LayoutError("a space is not in one part")
    return polygon.simplify(0)
