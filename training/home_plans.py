"""Plans of homes as estate agents, architects and programs draw them, for fit_plan_regions.py.

Floors are those of pianta.worlds; walls, doors, furniture, pavings and what stands around the building are drawn in
random styles. The measures, shares and ranges of this module were chosen by hand. All lengths are metres.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import cv2
import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray
from shapely import LineString, Point, Polygon, box, unary_union
from shapely.coords import CoordinateSequence

from pianta._types import Floats
from pianta.floor import Door, Floor, Room
from pianta.gridmap import UNKNOWN, GridMap
from pianta.worlds.dense_furniture import furnish_densely
from pianta.worlds.floors import OUTER_WALL, make_floor
from pianta.worlds.homes import make_home_floor

Colors = NDArray[np.uint8]
Color = tuple[int, int, int]

MARGIN = 2.5
# Wider doors of homes without a leaf belong to open-plan rooms: nothing separates their two sides.
WIDEST_DOOR = 1.3
# Rooms with a sign on an evacuation map.
SIGN_SHARE = 0.6
# Legs of chairs and tables are not drawn; m².
SMALLEST_PIECE = 0.03
# Fractions of a pixel that OpenCV draws at.
SHIFT = 4
WHITE: Color = (255, 255, 255)
PASTELS = ((247, 236, 212), (222, 235, 247), (229, 245, 224), (254, 230, 206), (239, 237, 245), (236, 226, 240))
STRONG = ((102, 194, 165), (252, 141, 98), (141, 160, 203), (231, 138, 195), (166, 216, 84), (229, 196, 148))
WALL_COLORS = ((0, 0, 0), (0, 0, 0), (35, 31, 32), (70, 70, 75), (120, 120, 120), (160, 160, 160), (255, 217, 47))
FONTS = (cv2.FONT_HERSHEY_SIMPLEX, cv2.FONT_HERSHEY_DUPLEX, cv2.FONT_HERSHEY_COMPLEX, cv2.FONT_HERSHEY_PLAIN)


@dataclass(frozen=True, eq=False)
class HomePlan:
    """A drawn plan. open_lines: where rooms are open to each other, so that nothing is drawn; metres."""

    colors: Colors
    truth: Floor
    grid: GridMap
    open_lines: tuple[LineString, ...]


class Lettering(NamedTuple):
    """The height of capitals, metres, and one of OpenCV's fonts."""

    height: float
    font: int


class Pen(NamedTuple):
    """The colour and the width, pixels, of thin lines."""

    ink: Color
    width: float


class DoorLine(NamedTuple):
    """The jambs of a door, and where its leaf opens to from the first, as long as the door is wide; shape (2,) each."""

    start: Floats
    end: Floats
    across: Floats


class Sheet:
    """Paper that is drawn on in metres, y up."""

    def __init__(self, bounds: tuple[float, float, float, float], px_per_metre: float, paper: Color) -> None:
        x0, y0, x1, y1 = bounds
        self.px = px_per_metre
        width, height = round((x1 - x0) * px_per_metre), round((y1 - y0) * px_per_metre)
        self.colors = np.full((height, width, 3), paper, np.uint8)
        self.grid = GridMap(np.full((height, width), UNKNOWN, np.int8), 1 / px_per_metre, (x0, y0, 0.0))

    def points(self, coordinates: ArrayLike | CoordinateSequence) -> NDArray[np.int32]:
        """Corners for OpenCV, of x and y."""
        rows, cols = self.grid.map_to_pixel(*np.asarray(coordinates, float)[:, :2].T)
        return np.rint((np.column_stack([cols, rows]) - 0.5) * 2**SHIFT).astype(np.int32)

    def fill(self, shape: shapely.Geometry, color: Color) -> None:
        """Fill polygons."""
        for part in shapely.get_parts(shape):
            if isinstance(part, Polygon) and not part.is_empty:
                rings = [self.points(ring.coords) for ring in (part.exterior, *part.interiors)]
                cv2.fillPoly(self.colors, rings, color, cv2.LINE_AA, SHIFT)

    def line(
        self, coordinates: ArrayLike | CoordinateSequence, color: Color, width: float = 1, *, closed: bool = False
    ) -> None:
        """A line through points; width: pixels."""
        points = [self.points(coordinates)]
        cv2.polylines(self.colors, points, closed, color, max(1, round(width)), cv2.LINE_AA, SHIFT)

    def outline(self, shape: shapely.Geometry, color: Color, width: float = 1) -> None:
        """The outlines of polygons."""
        for part in shapely.get_parts(shape):
            for ring in (part.exterior, *part.interiors) if isinstance(part, Polygon) else ():
                self.line(ring.coords, color, width)

    def hatch(self, shape: shapely.Geometry, color: Color, *, pitch: float, angle: float, width: float = 1) -> None:
        """Parallel lines within polygons."""
        if shape.is_empty:
            return
        x0, y0, x1, y1 = shape.bounds
        middle, reach = np.array([x0 + x1, y0 + y1]) / 2, np.hypot(x1 - x0, y1 - y0) / 2
        along = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along[1], along[0]])
        lines = [
            LineString([middle + off * across - reach * along, middle + off * across + reach * along])
            for off in np.arange(-reach, reach, pitch)
        ]
        for part in shapely.get_parts(shapely.intersection(np.array(lines), shape)):
            for piece in shapely.get_parts(part):
                if isinstance(piece, LineString) and piece.length > 0:
                    self.line(piece.coords, color, width)

    def write(self, text: str, at: tuple[float, float], lettering: Lettering, color: Color) -> None:
        """A text around a point."""
        (x, y), (height, font) = at, lettering
        scale = height * self.px / 22
        (width, _), _ = cv2.getTextSize(text, font, scale, 1)
        (col, row), *_ = self.points([(x, y)]) / 2**SHIFT
        origin = (int(col - width / 2), int(row + height * self.px / 2))
        cv2.putText(self.colors, text, origin, font, scale, color, max(1, round(scale * 1.6)), cv2.LINE_AA)


Furnishing = Callable[[Sheet, Floor, Pen, np.random.Generator], None]


def draw_home_plan(rng: np.random.Generator, furnishing: Furnishing | None = None) -> HomePlan:
    """A plan of a home, or of another floor of pianta.worlds, in a random style; furnishing: instead of `furnish`."""
    if rng.random() < 0.8:
        floor = make_home_floor(seed=rng)
    else:
        floor = make_floor(
            str(rng.choice(["office", "open_plan", "ward", "corridor", "l"])), seed=int(rng.integers(10**6))
        )  # type: ignore[arg-type]
    floor = change_walls(add_entrance(add_balcony(floor, rng), rng), rng)
    open_lines = tuple(door.line for door in floor.doors if door.width > WIDEST_DOOR and door.kind == "opening")
    doors = tuple(door for door in floor.doors if door.line not in open_lines)
    floor = replace(floor, doors=doors)
    solid = [room.polygon for room in floor if room.label != "BALCONY"]
    footprint = unary_union(solid).buffer(OUTER_WALL * rng.uniform(0.4, 1.7), join_style="mitre")
    footprint = footprint.difference(unary_union([room.polygon for room in floor if room.label == "BALCONY"]))
    around = unary_union([footprint, *(room.polygon for room in floor)])
    x0, y0, x1, y1 = around.bounds
    margins = rng.uniform(0.4, MARGIN, 4)
    px = float(np.exp(rng.uniform(np.log(20), np.log(70))))
    paper = WHITE if rng.random() < 0.75 else tuple(int(tone) for tone in rng.integers(225, 256, 3))
    sheet = Sheet((x0 - margins[0], y0 - margins[1], x1 + margins[2], y1 + margins[3]), px, paper)  # type: ignore[arg-type]
    width = max(1.0, px / 40 * rng.uniform(0.6, 1.6))
    ink = tuple([int(rng.choice([0, 0, 30, 70, 110]))] * 3)
    pen = Pen(ink, width)
    draw_around(sheet, around, pen, rng)
    pave_rooms(sheet, floor, pen, rng)
    (furnishing or furnish)(sheet, floor, pen, rng)
    draw_walls(sheet, floor, footprint, [*open_lines, *(door.line for door in doors)], pen, rng=rng)
    draw_doors(sheet, floor, pen, rng)
    write_names(sheet, floor, ink, rng)
    return HomePlan(photograph(sheet.colors, rng), floor, sheet.grid, open_lines)


def add_balcony(floor: Floor, rng: np.random.Generator) -> Floor:
    """The floor, perhaps with a balcony before one of its rooms."""
    if rng.random() < 0.6:
        return floor
    building = unary_union([room.polygon for room in floor]).buffer(OUTER_WALL, join_style="mitre")
    for room in rng.permutation(np.array(floor.rooms, object)):
        coordinates = np.asarray(room.polygon.exterior.coords)[:, :2]
        for start, end in pairwise(coordinates):
            length = float(np.hypot(*(end - start)))
            along = (end - start) / max(length, 1e-9)
            depth, outwards = rng.uniform(1.0, 2.2), np.array([along[1], -along[0]])
            for way in (outwards, -outwards):
                first, last = start + along * 0.1 + way * OUTER_WALL, end - along * 0.1 + way * OUTER_WALL
                shape = Polygon([first, last, last + way * depth, first + way * depth])
                if length < 2.2 or not shape.is_valid or shape.buffer(-0.05).intersects(building):
                    continue
                middle = (start + end) / 2 + way * OUTER_WALL / 2
                half = rng.uniform(0.4, 0.6) * along
                number = max(other.id for other in floor) + 1
                balcony = replace(room, id=number, polygon=shape, label="BALCONY", name=None)
                line = LineString([middle - half, middle + half])
                door = Door((room.id, number), line, line.length)
                return replace(floor, rooms=(*floor.rooms, balcony), doors=(*floor.doors, door), last_id=number)
    return floor


def add_entrance(floor: Floor, rng: np.random.Generator) -> Floor:
    """The floor, mostly with a door that leads outside."""
    if rng.random() < 0.2:
        return floor
    building = unary_union([room.polygon for room in floor]).buffer(0.3 * OUTER_WALL, join_style="mitre")
    for room in rng.permutation(np.array(floor.rooms, object)):
        coordinates = np.asarray(room.polygon.exterior.coords)[:, :2]
        for start, end in pairwise(coordinates):
            length, width = float(np.hypot(*(end - start))), rng.uniform(0.8, 1.1)
            if room.label not in {"CORRIDOR", "LIVING ROOM", "HALL", "KITCHEN"} or length < width + 0.2:
                continue
            along = (end - start) / length
            left = start + along * rng.uniform(0.1, length - width - 0.1)
            for across in (np.array([along[1], -along[0]]), np.array([-along[1], along[0]])):
                line = LineString([left, left + along * width] + across * OUTER_WALL / 2)
                clear = all(door.line.distance(line) > 0.4 for door in floor.doors)
                if clear and not building.intersects(LineString(np.asarray(line.coords) + across * OUTER_WALL)):
                    return replace(floor, doors=(*floor.doors, Door((room.id, None), line, line.length)))
    return floor


def change_walls(floor: Floor, rng: np.random.Generator) -> Floor:
    """The floor with thinner or thicker inner walls."""
    by = rng.uniform(-0.12, 0.04)

    def change(room: Room) -> Room:
        parts = shapely.get_parts(room.polygon.buffer(by, join_style="mitre"))
        return replace(room, polygon=max(parts, key=shapely.area, default=room.polygon))

    return replace(floor, rooms=tuple(map(change, floor.rooms)))


def pave_rooms(sheet: Sheet, floor: Floor, pen: Pen, rng: np.random.Generator) -> None:
    """Rooms in colours, with tiles or boards."""
    palette = [None, PASTELS, STRONG][int(rng.choice(3, p=(0.6, 0.28, 0.12)))]
    one_color = rng.random() < 0.3
    tiles, boards = rng.random() < 0.35, rng.random() < 0.15
    pale = tuple(int(tone) for tone in 255 - (255 - np.array(pen.ink)) * rng.uniform(0.15, 0.7))
    for index, room in enumerate(floor):
        if palette:
            color = palette[0 if one_color else (index + int(rng.integers(2))) % len(palette)]
            sheet.fill(room.polygon.buffer(0.08, join_style="mitre"), color)
        if tiles and room.label in {"BATHROOM", "TOILET", "KITCHEN", "BALCONY"}:
            pitch, turn = rng.uniform(0.15, 0.6), rng.choice([0, 0, np.pi / 4])
            sheet.hatch(room.polygon, pale, pitch=pitch, angle=turn, width=1)
            sheet.hatch(room.polygon, pale, pitch=pitch, angle=turn + np.pi / 2, width=1)
        elif boards and room.label not in {"BATHROOM", "TOILET"}:
            sheet.hatch(
                room.polygon, pale, pitch=rng.uniform(0.12, 0.3), angle=rng.choice([0, np.pi / 2]), width=pen.width
            )


def furnish(sheet: Sheet, floor: Floor, pen: Pen, rng: np.random.Generator) -> None:
    """Furniture from above, stairs and wardrobes."""
    density = float(rng.choice([0, 0.6, 1.0, 1.5], p=(0.2, 0.2, 0.35, 0.25)))
    filling: list[Color | None] = [None, WHITE, (235, 235, 235), (205, 205, 205), (240, 225, 200)]
    color = filling[int(rng.integers(len(filling)))]
    with_signs = rng.random() < 0.2
    fine = Pen(pen.ink, pen.width * rng.uniform(0.5, 1.0))
    for piece in furnish_densely(floor, density=density, rng=rng) if density else []:
        if piece.area < SMALLEST_PIECE:
            continue
        if color is not None:
            sheet.fill(piece, color)
        sheet.outline(piece, *fine)
        if piece.area > 0.25 and rng.random() < 0.6:
            draw_details(sheet, piece, fine, rng)
    for room in floor:
        if room.label in {"CORRIDOR", "LIVING ROOM", "HALL"} and rng.random() < 0.2:
            draw_stairs(sheet, room.polygon, fine, rng)
        if room.label in {"BEDROOM", "CORRIDOR", "OFFICE"} and rng.random() < 0.4:
            draw_wardrobe(sheet, room.polygon, fine, rng)
        if room.label in {"KITCHEN", "BATHROOM", "DINING ROOM"} and rng.random() < 0.7:
            draw_counter(sheet, room.polygon, fine, rng)
        if rng.random() < SIGN_SHARE * with_signs:
            draw_sign(sheet, room.polygon, rng)


def draw_details(sheet: Sheet, piece: Polygon, pen: Pen, rng: np.random.Generator) -> None:
    """Inner lines of a piece: a rim, a circle, a diagonal cross, or pillows."""
    style = int(rng.integers(4))
    if style == 0:
        sheet.outline(piece.buffer(-rng.uniform(0.05, 0.12), join_style="mitre"), *pen)
    elif style == 1:
        x, y = piece.centroid.coords[0]
        for _ in range(int(rng.integers(1, 4))):
            sheet.outline(Point(x, y).buffer(rng.uniform(0.06, 0.2)), *pen)
            x, y = x + rng.uniform(-0.25, 0.25), y + rng.uniform(-0.25, 0.25)
    else:
        corners = np.asarray(piece.exterior.coords)[:4, :2]
        if style == 2 and len(corners) == 4:
            sheet.line(corners[[0, 2]], *pen)
            sheet.line(corners[[1, 3]], *pen)
        else:
            cut = piece.intersection(piece.envelope.buffer(0).intersection(shapely.affinity.translate(piece, 0.3, 0.3)))
            sheet.outline(cut, *pen)


def draw_stairs(sheet: Sheet, room: Polygon, pen: Pen, rng: np.random.Generator) -> None:
    """A flight of stairs along a side of a room."""
    x0, y0, x1, y1 = room.bounds
    run, flight = rng.uniform(0.8, 1.1), rng.uniform(1.5, 3.2)
    along_x = x1 - x0 > y1 - y0
    length, depth = (flight, run) if along_x else (run, flight)
    x, y = (x0, y0) if rng.random() < 0.5 else (x1 - length, y1 - depth)
    shape = box(x, y, x + length, y + depth).intersection(room)
    sheet.outline(shape, *pen)
    sheet.hatch(shape, pen.ink, pitch=rng.uniform(0.22, 0.3), angle=np.pi / 2 if along_x else 0.0, width=pen.width)


def draw_wardrobe(sheet: Sheet, room: Polygon, pen: Pen, rng: np.random.Generator) -> None:
    """A wardrobe along a side of a room, with hangers, doors or a line."""
    x0, y0, x1, y1 = room.bounds
    depth = rng.uniform(0.55, 0.65)
    shape = [box(x0, y0, x1, y0 + depth), box(x0, y0, x0 + depth, y1), box(x1 - depth, y0, x1, y1)][rng.integers(3)]
    shape = shape.intersection(room)
    sheet.outline(shape, *pen)
    if rng.random() < 0.6:
        along_x = shape.bounds[2] - shape.bounds[0] > shape.bounds[3] - shape.bounds[1]
        turn = (np.pi / 2 if along_x else 0.0) + rng.choice([0, 0.2])
        sheet.hatch(shape, pen.ink, pitch=rng.uniform(0.08, 0.6), angle=turn, width=1)


def draw_counter(sheet: Sheet, room: Polygon, pen: Pen, rng: np.random.Generator) -> None:
    """A counter, or tubs and showers, along one to three sides of a room, perhaps in pieces."""
    x0, y0, x1, y1 = room.bounds
    depth = rng.uniform(0.5, 0.9)
    sides = [
        box(x0, y0, x1, y0 + depth),
        box(x0, y1 - depth, x1, y1),
        box(x0, y0, x0 + depth, y1),
        box(x1 - depth, y0, x1, y1),
    ]
    chosen = rng.permutation(4)[: int(rng.integers(1, 4))]
    inner = room.buffer(-0.01, join_style="mitre")
    for side in [sides[index] for index in chosen]:
        low_x, low_y, high_x, high_y = side.bounds
        shares = np.sort(rng.random(int(rng.integers(0, 5))))
        if rng.random() < 0.5:
            sheet.fill(side.intersection(inner), WHITE if rng.random() < 0.6 else (230, 225, 215))
        sheet.outline(side.intersection(inner), *pen)
        for share in shares:
            x, y = low_x + share * (high_x - low_x), low_y + share * (high_y - low_y)
            ends = [(x, low_y), (x, high_y)] if high_x - low_x > high_y - low_y else [(low_x, y), (high_x, y)]
            cut = LineString(ends).intersection(inner)
            if isinstance(cut, LineString) and not cut.is_empty:
                sheet.line(cut.coords, *pen)
        if rng.random() < 0.5:
            sheet.outline(Point(*rng.uniform((low_x, low_y), (high_x, high_y))).buffer(0.2).intersection(side), *pen)


def draw_sign(sheet: Sheet, room: Polygon, rng: np.random.Generator) -> None:
    """A sign of an evacuation map: a red, green or blue square with something white in it, or an arrow."""
    point, size = room.representative_point(), rng.uniform(0.25, 0.9)
    x, y = point.x + rng.uniform(-1, 1), point.y + rng.uniform(-1, 1)
    color: Any = ((226, 30, 40), (0, 140, 80), (30, 60, 200), (70, 160, 60))[int(rng.integers(4))]
    shape = box(x, y, x + size * rng.choice([1, 2]), y + size)
    sheet.fill(shape, color)
    if rng.random() < 0.3:
        sheet.fill(
            Polygon([(x + 2 * size, y - size / 2), (x + 2 * size, y + 1.5 * size), (x + 3 * size, y + size / 2)]), color
        )
    sheet.outline(shape.buffer(-0.2 * size), WHITE, max(1.0, 0.12 * size * sheet.px))
    sheet.line([(x, y), (x + size, y + size)], WHITE, max(1.0, 0.1 * size * sheet.px))


def draw_walls(
    sheet: Sheet,
    floor: Floor,
    footprint: shapely.Geometry,
    gaps: list[LineString],
    pen: Pen,
    *,
    rng: np.random.Generator,
) -> None:
    """Walls with gaps, windows, and railings of balconies."""
    body = footprint.difference(unary_union([room.polygon for room in floor]))
    all_walls = body
    body = body.difference(unary_union([gap.buffer(OUTER_WALL, cap_style="flat") for gap in gaps]))
    windows = list(place_windows(floor, footprint, rng))
    style = rng.choice(["solid", "outline", "hatched", "tinted"], p=(0.45, 0.2, 0.2, 0.15))
    frames = unary_union([window.buffer(OUTER_WALL, cap_style="flat") for window in windows]).intersection(all_walls)
    if (windows and style != "solid") or rng.random() < 0.8:
        body = body.difference(frames)
    color: Any = WALL_COLORS[int(rng.integers(len(WALL_COLORS)))]
    if style == "solid":
        sheet.fill(body, color)
    else:
        if style == "tinted":
            tint: Any = tuple(int(tone) for tone in rng.integers(170, 235, 3)) if rng.random() < 0.3 else (205,) * 3
            sheet.fill(body, tint)
        else:
            sheet.fill(body, WHITE)
        if style == "hatched":
            sheet.hatch(body, pen.ink, pitch=rng.uniform(0.06, 0.4), angle=rng.choice([0.25, 0.75]) * np.pi, width=1)
        sheet.outline(body, pen.ink, pen.width * rng.uniform(0.8, 2))
    panes = int(rng.integers(1, 4))
    glass: Any = WHITE if rng.random() < 0.7 else (166, 216, 84)
    for window in windows:
        frame = window.buffer(OUTER_WALL, cap_style="flat").intersection(all_walls)
        sheet.fill(frame, glass)
        sheet.outline(frame, *pen)
        if panes > 1:
            short = min(frame.bounds[2] - frame.bounds[0], frame.bounds[3] - frame.bounds[1])
            turn = np.arctan2(*(np.diff(np.asarray(window.coords), axis=0)[0, ::-1]))
            sheet.hatch(frame, pen.ink, pitch=max(short / panes, 0.04), angle=float(turn), width=pen.width)
    for room in floor:
        if room.label == "BALCONY":
            sheet.outline(room.polygon, pen.ink, pen.width * rng.uniform(1, 2))
            if rng.random() < 0.5:
                sheet.outline(room.polygon.buffer(rng.uniform(0.06, 0.12), join_style="mitre"), *pen)


def place_windows(floor: Floor, footprint: shapely.Geometry, rng: np.random.Generator) -> Iterator[LineString]:
    """Windows in outer walls, along their inner faces."""
    if rng.random() < 0.15:
        return
    outline = footprint.buffer(0).boundary
    for room in floor:
        coordinates = np.asarray(room.polygon.exterior.coords)[:, :2]
        for start, end in pairwise(coordinates):
            length = float(np.hypot(*(end - start)))
            if room.label == "BALCONY" or length < 1.2 or rng.random() < 0.3:
                continue
            middle, along = (start + end) / 2, (end - start) / max(length, 1e-9)
            half = min(length / 2 - 0.2, rng.uniform(0.4, 1.1)) * along
            line = LineString([middle - half, middle + half])
            clear = all(door.line.distance(line) > OUTER_WALL for door in floor.doors)
            if clear and outline.hausdorff_distance(line) and outline.distance(line) < 1.4 * OUTER_WALL:
                yield line


def draw_doors(sheet: Sheet, floor: Floor, pen: Pen, rng: np.random.Generator) -> None:
    """Each door in the style of the plan, some in another one."""
    styles = tuple(DOOR_STYLES)
    usual = str(rng.choice(styles, p=DOOR_SHARES))
    color: Any = ((231, 138, 195), (141, 211, 199), (230, 160, 90), pen.ink)[int(rng.integers(4))]
    threshold = rng.random() < 0.25
    depth = rng.uniform(0.06, 0.2)
    width = max(1.0, pen.width * rng.uniform(0.5, 1.3))
    for door in floor.doors:
        style = usual if rng.random() < 0.85 else str(rng.choice(styles))
        if door.kind == "opening":
            continue
        start, end = np.asarray(door.line.coords)[[0, -1], :2]
        if rng.random() < 0.5:
            start, end = end, start
        across = np.array([start[1] - end[1], end[0] - start[0]]) * (1 if rng.random() < 0.5 else -1)
        if threshold:
            off = across / np.hypot(*across) * depth / 2
            for way in (off, -off):
                sheet.line([start + way, end + way], pen.ink, width)
        DOOR_STYLES[style](sheet, DoorLine(start, end, across), Pen(color if style == "patch" else pen.ink, width))


def _arc(hinge: Floats, closed: Floats, opened: Floats, until: float = 90) -> Floats:
    angles = np.radians(np.linspace(0, until, 20))[:, None]
    return np.asarray(hinge + np.cos(angles) * closed + np.sin(angles) * opened)


def _draw_arc(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    (start, end, across), (ink, width) = door, pen
    face = start + across * 0.08
    sheet.line(_arc(face, end - start, across), ink, width)
    sheet.line([face, face + across], ink, width)


def _draw_sector(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    (start, end, across), (ink, width) = door, pen
    shape = Polygon([start, *_arc(start, end - start, across)])
    sheet.fill(shape, WHITE)
    sheet.outline(shape, ink, width)


def _draw_panel(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    """A leaf of its thickness, with its arc."""
    (start, end, across), (ink, width) = door, pen
    _draw_leaf_box(sheet, door, pen)
    sheet.line(_arc(start, end - start, across), ink, max(1, width / 2))


def _draw_leaf_box(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    (start, end, across), (ink, width) = door, pen
    thick = (end - start) * 0.06
    shape = Polygon([start, start + across, start + across + thick, start + thick])
    sheet.fill(shape, WHITE)
    sheet.outline(shape, ink, width)


def _draw_leaf(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    (start, end, across), (ink, width) = door, pen
    sheet.line([start, start + (end - start + across) / 2**0.5], ink, 2 * width)


def _draw_half_open(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    (start, end, across), (ink, width) = door, pen
    arc = _arc(start, end - start, across, 45)
    sheet.line(arc, ink, width)
    sheet.line([start, arc[-1]], ink, width)


def _draw_double(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    (start, end, across), (ink, width) = door, pen
    half = (end - start) / 2
    for hinge, closed in ((start, half), (end, -half)):
        sheet.line(_arc(hinge, closed, across / 2), ink, width)
        sheet.line([hinge, hinge + across / 2], ink, width)


def _draw_sliding(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    (start, end, across), (ink, width) = door, pen
    for first, last, off in ((0.0, 0.55, 0.03), (0.45, 1.0, -0.03)):
        ends = start + np.outer([first, last], end - start) + across * off
        sheet.line(ends, ink, width)
        sheet.line(ends + across * off, ink, width)


def _draw_pocket(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    ends = door.start + np.outer([-0.6, 0.5], door.end - door.start)
    shape = LineString(ends).buffer(0.03, cap_style="flat")
    sheet.fill(shape, WHITE)
    sheet.outline(shape, *pen)


def _draw_folding(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    (start, end, across), (ink, width) = door, pen
    along = end - start
    sheet.line(start + np.outer([0, 0.25, 0.5], along) + np.outer([0, 0.3, 0], across), ink, width)
    sheet.line(end - np.outer([0, 0.25, 0.5], along) + np.outer([0, 0.3, 0], across), ink, width)


def _draw_patch(sheet: Sheet, door: DoorLine, pen: Pen) -> None:
    shape = LineString([door.start, door.end]).buffer(np.hypot(*door.across) * 0.11, cap_style="flat")
    sheet.fill(shape, pen.ink if pen.ink != (0, 0, 0) else (200, 200, 200))
    sheet.outline(shape, (60, 60, 60), pen.width)


def _draw_gap(_sheet: Sheet, _door: DoorLine, _pen: Pen) -> None:
    """Nothing."""


DOOR_STYLES: dict[str, Callable[[Sheet, DoorLine, Pen], None]] = {
    "arc": _draw_arc,
    "sector": _draw_sector,
    "panel": _draw_panel,
    "leaf box": _draw_leaf_box,
    "leaf": _draw_leaf,
    "half open": _draw_half_open,
    "double": _draw_double,
    "sliding": _draw_sliding,
    "pocket": _draw_pocket,
    "folding": _draw_folding,
    "patch": _draw_patch,
    "gap": _draw_gap,
}
DOOR_SHARES = (0.26, 0.1, 0.12, 0.06, 0.12, 0.06, 0.04, 0.04, 0.03, 0.03, 0.09, 0.05)


def write_names(sheet: Sheet, floor: Floor, ink: Color, rng: np.random.Generator) -> None:
    """Names, areas and sizes in rooms."""
    if rng.random() < 0.15:
        return
    font, height = FONTS[int(rng.integers(len(FONTS)))], rng.uniform(0.16, 0.34)
    areas, sizes = rng.random() < 0.5, rng.random() < 0.3
    for room in floor:
        x0, y0, x1, y1 = room.polygon.bounds
        lines = [(room.label or "Room").title()]
        if areas:
            lines.append(f"{room.polygon.area:.1f} m2")
        if sizes:
            lines.append(f"{x1 - x0:.2f} x {y1 - y0:.2f}")
        if room.polygon.area < 2 and rng.random() < 0.6:
            continue
        point = room.polygon.representative_point()
        for number, line in enumerate(lines):
            size = height if room.polygon.area > 6 else 0.7 * height
            at = point.x + rng.uniform(-0.2, 0.2), point.y - 1.6 * number * size
            sheet.write(line, at, Lettering(size, font), ink)


def draw_around(sheet: Sheet, around: shapely.Geometry, pen: Pen, rng: np.random.Generator) -> None:
    """Dimension lines, a compass, boxes of text, a frame or a garden around the building."""
    x0, y0, x1, y1 = around.bounds
    if rng.random() < 0.35:
        for number in range(int(rng.integers(1, 3))):
            off = 0.5 + 0.5 * number
            draw_dimensions(sheet, np.array([(x0, y0 - off), (x1, y0 - off)]), pen, rng)
            draw_dimensions(sheet, np.array([(x0 - off, y0), (x0 - off, y1)]), pen, rng)
    left, top = sheet.grid.origin[0], sheet.grid.origin[1] + sheet.grid.shape[0] / sheet.px
    right, low = left + sheet.grid.shape[1] / sheet.px, sheet.grid.origin[1]
    if rng.random() < 0.25:
        inset = rng.uniform(0.05, 0.3)
        sheet.outline(box(left, low, right, top).buffer(-inset), pen.ink, pen.width * rng.uniform(1, 3))
    if rng.random() < 0.3:
        x, y = rng.choice([left + 0.8, right - 0.8]), rng.choice([top - 0.8, low + 0.8])
        sheet.outline(Point(x, y).buffer(rng.uniform(0.3, 0.6)), *pen)
        sheet.line([(x, y - 0.5), (x, y + 0.5), (x + 0.1, y + 0.2)], *pen)
    if rng.random() < 0.3:
        x, y = rng.uniform(left, right), rng.choice([top - 0.6, low + 0.4])
        shape = box(x, y - 0.4, x + rng.uniform(1, 4), y + 0.4)
        if rng.random() < 0.5:
            sheet.fill(shape, PASTELS[int(rng.integers(len(PASTELS)))])
        sheet.outline(shape, *pen)
        for line in np.arange(y - 0.2, y + 0.3, 0.3):
            sheet.write("Approx. floor area", (x + 1, float(line)), Lettering(0.15, FONTS[0]), pen.ink)
    if rng.random() < 0.12:
        for _ in range(int(rng.integers(2, 8))):
            x, y = rng.uniform(left, right), rng.uniform(low, top)
            sheet.outline(Point(x, y).buffer(rng.uniform(0.4, 1.3)), (120, 160, 120), pen.width)
    sheet.fill(around, WHITE)


def draw_dimensions(sheet: Sheet, ends: Floats, pen: Pen, rng: np.random.Generator) -> None:
    """A chain of dimension lines between two points, shape (2, 2)."""
    sheet.line(ends, pen.ink, max(1, pen.width / 2))
    shares = np.sort(np.concatenate([[0, 1], rng.random(int(rng.integers(0, 5)))]))
    along = ends[1] - ends[0]
    for share in shares:
        point = ends[0] + share * along
        sheet.line([point - 0.1, point + 0.1], *pen)
    for first, last in pairwise(shares):
        middle = ends[0] + (first + last) / 2 * along
        metres = (last - first) * float(np.hypot(*along))
        sheet.write(f"{1000 * metres:.0f}", (middle[0] + 0.2, middle[1] + 0.2), Lettering(0.15, FONTS[0]), pen.ink)


def photograph(colors: Colors, rng: np.random.Generator) -> Colors:
    """The sheet compressed, blurred, grainy, or as drawn."""
    draw = rng.random()
    if draw < 0.3:
        _, content = cv2.imencode(".jpg", colors, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(25, 80))])
        colors = np.asarray(cv2.imdecode(content, cv2.IMREAD_COLOR), np.uint8)
    elif draw < 0.45:
        colors = np.asarray(cv2.GaussianBlur(colors, (0, 0), rng.uniform(0.5, 1.2)), np.uint8)
    elif draw < 0.55:
        grain = rng.normal(0, rng.uniform(2, 9), colors.shape)
        colors = np.clip(colors + grain, 0, 255).astype(np.uint8)
    return colors
