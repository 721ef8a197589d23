"""Plans with fixtures of homes as they are drawn from above, and where they are, for fit_plan_fixtures.py.

The sizes, shares and ranges of this module were chosen by hand. A fixture is drawn in metres of its own frame: x along
the wall behind it, 0 in its middle; y into the room, 0 at the wall.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely
from home_plans import WHITE, Color, HomePlan, Pen, Sheet, draw_home_plan, furnish
from shapely import LineString, Point, Polygon, affinity, box

from pianta._types import Floats
from pianta.floor import Floor
from pianta.plan.symbols.fixtures import BATH, BED, HOB, SINK, TOILET

# Which fixtures rooms have, and how probable each is.
FIXTURES: dict[str, tuple[tuple[int, float], ...]] = {
    "BATHROOM": ((TOILET, 0.85), (BATH, 0.85), (SINK, 0.9)),
    "TOILET": ((TOILET, 0.95), (SINK, 0.6)),
    "KITCHEN": ((HOB, 0.9), (SINK, 0.9)),
    "BEDROOM": ((BED, 0.8), (BED, 0.1)),
    "CHILD ROOM": ((BED, 0.8),),
    "LIVING ROOM": ((HOB, 0.1), (SINK, 0.1)),
}
# Places along the walls that are tried for a fixture.
ATTEMPTS = 30


class Placed(NamedTuple):
    """A fixture on a plan. kind: one of the classes of the network. shape: its outline, metres."""

    kind: int
    shape: Polygon


@dataclass(frozen=True, eq=False)
class FixturePlan:
    """A plan and the fixtures on it."""

    plan: HomePlan
    fixtures: list[Placed]


class Drawing(NamedTuple):
    """The shapes of a fixture: outlines that are filled with paper, lines over them, and how it is placed."""

    shapes: list[shapely.Geometry]
    lines: list[shapely.Geometry]
    width: float
    depth: float


@dataclass(eq=False)
class FixtureStyle:
    """One way to draw each kind, for a whole plan, since symbols of a plan are alike."""

    rng: np.random.Generator
    drawings: dict[int, Drawing] = field(default_factory=dict)

    def draw(self, number: int) -> Drawing:
        """The drawing of a kind; sometimes another one than before."""
        if number not in self.drawings or self.rng.random() < 0.15:
            self.drawings[number] = DRAWINGS[number](self.rng)
        return self.drawings[number]


def draw_fixture_plan(rng: np.random.Generator) -> FixturePlan:
    """A plan as of `draw_home_plan`, with fixtures."""
    fixtures: list[Placed] = []

    def furnish_with_fixtures(sheet: Sheet, floor: Floor, pen: Pen, rng: np.random.Generator) -> None:
        furnish(sheet, floor, pen, rng)
        fixtures.extend(draw_fixtures(sheet, floor, pen, rng))

    return FixturePlan(draw_home_plan(rng, furnish_with_fixtures), fixtures)


def draw_fixtures(sheet: Sheet, floor: Floor, pen: Pen, rng: np.random.Generator) -> list[Placed]:
    """Fixtures along the walls of the rooms that have them."""
    fine, style = Pen(pen.ink, max(1.0, pen.width * rng.uniform(0.4, 1.0))), FixtureStyle(rng)
    fillings: list[Color] = [WHITE, WHITE, (235, 235, 235), (225, 235, 245)]
    filling = fillings[int(rng.integers(len(fillings)))]
    placed: list[Placed] = []
    for room in floor:
        clear = [door.line.buffer(0.35) for door in floor.doors if room.id in door.room_ids]
        for number, share in FIXTURES.get(room.label or "", ()):
            if rng.random() > share:
                continue
            drawing = style.draw(number)
            move = place_at_wall(room.polygon, drawing, [*clear, *(other.shape for other in placed)], rng)
            if move is None:
                continue
            outline = shapely.transform(box(-drawing.width / 2, 0, drawing.width / 2, drawing.depth), move)
            sheet.fill(outline, filling)
            for shape in drawing.shapes:
                moved = shapely.transform(shape, move)
                sheet.fill(moved, filling)
                sheet.outline(moved, *fine)
            for line in drawing.lines:
                moved = shapely.transform(line, move)
                if isinstance(moved, LineString):
                    sheet.line(moved.coords, *fine)
                else:
                    sheet.outline(moved, *fine)
            placed.append(Placed(number, outline))
    return placed


def place_at_wall(
    room: Polygon, drawing: Drawing, others: list[Polygon], rng: np.random.Generator
) -> Callable[[Floats], Floats] | None:
    """How points of a fixture's frame are moved to a free place at a wall of a room; None if none is found."""
    sides = list(pairwise(np.asarray(room.exterior.coords)[:, :2]))
    turned = rng.random() < 0.3 and drawing.width > 1.2
    for _ in range(ATTEMPTS):
        start, end = sides[int(rng.integers(len(sides)))]
        length = float(np.hypot(*(end - start)))
        side = drawing.depth if turned else drawing.width
        if length < side:
            continue
        along = (end - start) / length
        inwards = np.array([-along[1], along[0]]) if room.exterior.is_ccw else np.array([along[1], -along[0]])
        share = rng.choice([0.0, 1.0, rng.random()])
        at = start + along * (side / 2 + share * (length - side)) + inwards * rng.choice([0, 0.02, 0.1])
        mirror = rng.choice([-1, 1])

        def move(
            points: Floats,
            at: Floats = at,
            along: Floats = along,
            inwards: Floats = inwards,
            mirror: int = mirror,
        ) -> Floats:
            x, y = points[:, 0] * mirror, points[:, 1]
            if turned:
                x, y = y - drawing.depth / 2, x + drawing.width / 2
            return np.asarray(at + x[:, None] * along + y[:, None] * inwards)

        outline = shapely.transform(box(-drawing.width / 2, 0, drawing.width / 2, drawing.depth), move)
        if room.buffer(0.03).covers(outline) and not any(outline.intersects(other.buffer(-0.02)) for other in others):
            return move
    return None


def _rounded(x0: float, y0: float, x1: float, y1: float, radius: float) -> Polygon:
    radius = max(0.0, min(radius, (x1 - x0) / 2 - 0.01, (y1 - y0) / 2 - 0.01))
    inner = box(x0 + radius, y0 + radius, x1 - radius, y1 - radius)
    return inner.buffer(radius) if radius else box(x0, y0, x1, y1)


def _ellipse(x: float, y: float, half_width: float, half_depth: float) -> Polygon:
    return affinity.scale(Point(x, y).buffer(1), half_width, half_depth)


def _draw_toilet(rng: np.random.Generator) -> Drawing:
    """A bowl with or without a cistern and a seat."""
    width, bowl = rng.uniform(0.34, 0.42), rng.uniform(0.42, 0.56)
    tank = rng.choice([0.0, rng.uniform(0.12, 0.22)], p=(0.15, 0.85))
    tank_width = width * rng.uniform(0.95, 1.4)
    shapes: list[shapely.Geometry] = []
    if tank:
        shapes.append(_rounded(-tank_width / 2, 0, tank_width / 2, tank, rng.choice([0, 0.04])))
    middle = tank + bowl / 2
    seat = [
        _ellipse(0, middle, width / 2, bowl / 2),
        _rounded(-width / 2, tank, width / 2, tank + bowl, width / 2.1),
        box(-width / 2, tank, width / 2, tank + bowl / 2).union(_ellipse(0, middle, width / 2, bowl / 2)),
    ][int(rng.integers(3))]
    shapes.append(seat)
    lines: list[shapely.Geometry] = []
    if rng.random() < 0.6:
        lines.append(affinity.scale(seat, 0.7, 0.7))
    if rng.random() < 0.3:
        lines.append(Point(0, tank + bowl * 0.3).buffer(0.03))
    return Drawing(shapes, lines, max(width, tank_width if tank else 0), tank + bowl)


def _draw_bath(rng: np.random.Generator) -> Drawing:
    """A tub, or a shower."""
    if rng.random() < 0.4:
        return _draw_shower(rng)
    width, depth, rim = rng.uniform(1.4, 1.85), rng.uniform(0.66, 0.85), rng.uniform(0.04, 0.1)
    inner = _rounded(-width / 2 + rim, rim, width / 2 - rim, depth - rim, rng.uniform(0.05, 0.4))
    if rng.random() < 0.3:
        inner = inner.intersection(box(-width / 2, 0, 0, depth)).union(
            _ellipse(0, depth / 2, width / 2 - rim, depth / 2 - rim).intersection(box(0, 0, width / 2, depth))
        )
    drain = Point(-width / 2 + rng.uniform(0.18, 0.35), depth / 2).buffer(rng.uniform(0.02, 0.05))
    lines: list[shapely.Geometry] = [inner]
    if rng.random() < 0.7:
        lines.append(drain)
    if rng.random() < 0.3:
        lines.append(affinity.scale(inner, 0.85, 0.8))
    return Drawing([box(-width / 2, 0, width / 2, depth)], lines, width, depth)


def _draw_shower(rng: np.random.Generator) -> Drawing:
    width, depth = rng.uniform(0.7, 1.1), rng.uniform(0.7, 1.1)
    half = width / 2
    outline = box(-half, 0, half, depth)
    if rng.random() < 0.3:
        outline = Polygon([(-half, 0), (half, 0), (half, 0.3 * depth), (0.4 * -half, depth), (-half, depth)])
    lines: list[shapely.Geometry] = []
    style = int(rng.integers(4))
    if style == 0:
        lines += [LineString([(-half, 0), (half, depth)]), LineString([(half, 0), (-half, depth)])]
    if style == 1:
        angles = np.linspace(0, np.pi / 2, 20)
        lines.append(LineString(np.column_stack([-half + width * np.cos(angles), depth * np.sin(angles)])))
    if style == 2:
        lines.append(outline.buffer(-rng.uniform(0.04, 0.1), join_style="mitre"))
    if rng.random() < 0.7:
        lines.append(Point(rng.choice([0, -half + 0.15]), rng.choice([0.15, depth / 2])).buffer(0.05))
    return Drawing([outline], lines, width, depth)


def _draw_sink(rng: np.random.Generator) -> Drawing:
    """A basin, or a sink of a kitchen."""
    lines: list[shapely.Geometry] = []
    if rng.random() < 0.5:
        width, depth = rng.uniform(0.4, 0.75), rng.uniform(0.36, 0.52)
        outline = [
            box(-width / 2, 0, width / 2, depth),
            _rounded(-width / 2, 0, width / 2, depth, depth / 2),
            _ellipse(0, depth / 2, width / 2, depth / 2).union(box(-width / 2, 0, width / 2, depth / 2)),
            _ellipse(0, depth / 2, width / 2, depth / 2),
        ][int(rng.integers(4))]
        if rng.random() < 0.7:
            lines.append(_ellipse(0, depth / 2, width * rng.uniform(0.3, 0.42), depth * rng.uniform(0.28, 0.4)))
        if rng.random() < 0.7:
            lines.append(Point(0, depth * rng.uniform(0.3, 0.6)).buffer(0.025))
        if rng.random() < 0.5:
            lines.append(LineString([(0, 0.02), (0, 0.15)]))
        return Drawing([outline], lines, width, depth)
    width, depth, bowls = rng.uniform(0.5, 1.2), rng.uniform(0.45, 0.6), int(rng.integers(1, 3))
    bowl = min(0.42, 0.85 * width / bowls)
    left = -width / 2 + 0.05
    for number in range(bowls):
        x = left + number * (bowl + 0.03)
        lines.append(_rounded(x, 0.1, x + bowl, depth - 0.06, rng.uniform(0.02, 0.1)))
        lines.append(Point(x + bowl / 2, depth / 2).buffer(0.03))
    if rng.random() < 0.5:
        ribs = np.arange(left + bowls * (bowl + 0.03) + 0.03, width / 2 - 0.04, 0.06)
        lines += [LineString([(x, 0.1), (x, depth - 0.08)]) for x in ribs]
    if rng.random() < 0.6:
        lines.append(LineString([(left + bowl / 2, 0.02), (left + bowl / 2 + 0.05, 0.18)]))
    return Drawing([box(-width / 2, 0, width / 2, depth)], lines, width, depth)


def _draw_hob(rng: np.random.Generator) -> Drawing:
    """A hob of four burners, sometimes two to six, with or without an oven."""
    width, depth = rng.uniform(0.5, 0.75), rng.uniform(0.48, 0.62)
    columns = int(rng.choice([2, 2, 2, 3]))
    radii = rng.uniform(0.06, 0.12, (columns, 2))
    if rng.random() < 0.5:
        radii[:] = radii.mean()
    rings = rng.random() < 0.4
    cross = rng.random() < 0.25
    lines: list[shapely.Geometry] = []
    for column, row in np.ndindex(columns, 2):
        x = -width / 2 + width * (column + 0.5) / columns
        y = depth * (0.28 + 0.44 * row)
        radius = min(float(radii[column, row]), 0.45 * width / columns)
        lines.append(Point(x, y).buffer(radius))
        if rings:
            lines.append(Point(x, y).buffer(0.5 * radius))
        if cross:
            lines += [LineString([(x - radius, y), (x + radius, y)]), LineString([(x, y - radius), (x, y + radius)])]
    if rng.random() < 0.3:
        lines.append(LineString([(-width / 2, depth - 0.04), (width / 2, depth - 0.04)]))
    return Drawing([box(-width / 2, 0, width / 2, depth)], lines, width, depth)


def _draw_bed(rng: np.random.Generator) -> Drawing:
    """A bed with pillows and a blanket, sometimes with tables beside it."""
    double = rng.random() < 0.65
    width, depth = rng.uniform(1.4, 1.9) if double else rng.uniform(0.8, 1.1), rng.uniform(1.9, 2.15)
    half, head = width / 2, rng.choice([0.0, 0.06, 0.12])
    lines: list[shapely.Geometry] = []
    if head:
        lines.append(LineString([(-half, head), (half, head)]))
    count, deep = 2 if double else 1, rng.uniform(0.3, 0.5)
    for number in range(count):
        x = -half + width * (number + 0.5) / count
        reach = 0.42 * width / count
        lines.append(_rounded(x - reach, head + 0.06, x + reach, head + deep, rng.uniform(0, 0.12)))
    fold = head + deep + rng.uniform(0.05, 0.35)
    style = int(rng.integers(4))
    if style == 0:
        lines.append(LineString([(-half, fold), (half, fold)]))
    if style == 1:
        lines.append(LineString([(-half, fold + 0.6), (-half + 0.6 * width, fold), (half, fold)]))
        lines.append(LineString([(-half, fold + 0.6), (-half + 0.3 * width, fold + 0.7), (-half + 0.6 * width, fold)]))
    if style == 2:
        lines.append(_rounded(-half + 0.03, fold, half - 0.03, depth - 0.03, 0.08))
    shapes: list[shapely.Geometry] = [_rounded(-half, 0, half, depth, rng.choice([0, 0.05]))]
    return Drawing(shapes, lines, width, depth)


DRAWINGS: dict[int, Callable[[np.random.Generator], Drawing]] = {
    TOILET: _draw_toilet,
    BATH: _draw_bath,
    SINK: _draw_sink,
    HOB: _draw_hob,
    BED: _draw_bed,
}
