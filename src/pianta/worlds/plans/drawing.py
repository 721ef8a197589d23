"""Plans in the styles of architects, schools and estate agents, of floors with exact rooms and doors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import radians
from typing import Any

import cv2
import numpy as np
from shapely import Polygon, get_coordinates, unary_union
from shapely.geometry.base import BaseGeometry

from pianta._types import Colors, Floats
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.symbols.drawings import Mark, paint_marks
from pianta.worlds.plans.lettering import (
    LINE_SPACING,
    Lettering,
    WrittenText,
    letter_room,
    measure_legend,
    write_legend,
    write_texts,
)
from pianta.worlds.plans.look import Canvas, PlanLook
from pianta.worlds.plans.symbols import mark_furniture, mark_room_symbol, mark_signs, widen_doors
from pianta.worlds.plans.walls import extend_rooms_to_axes, paint_walls
from pianta.worlds.wall_axes import INNER_WALL, OUTER_WALL

# Lengths on the plan in metres of the building.
# Blank space around the building.
MARGIN = 1.0
# Strip for the dimensions below and beside the building.
DIMENSION_STRIP = 1.4
# Strip for the title above the building, and for the scale bar below it.
TITLE_STRIP = 1.8
# Slashes at the ends of dimension lines.
TICK = 0.2
BAR_HEIGHT = 0.25
# Clear space around texts.
TEXT_MARGIN = 0.1
# Lengths of the scale bar, of which the largest up to a quarter of the building is chosen.
BAR_LENGTHS = (1, 2, 5, 10, 20, 50)
PASTELS = ((198, 219, 239), (199, 233, 192), (253, 226, 170), (221, 204, 232), (250, 209, 205), (229, 229, 229))
PASSAGES = ("CORRIDOR", "HALL")
# Limit of memory.
MAX_PIXELS = 60_000_000


@dataclass(frozen=True, eq=False)
class DrawnPlan:
    """A plan and its ground truth.

    colors: shape (H, W, 3), red, green, blue. truth: the floor, metres; grid.map_to_pixel gives the position of a point
    on the sheet. grid: H × W unknown cells of the true resolution. texts: every line of text.
    names: name of each room that has its name, or its number in the legend, on the sheet; by id.
    """

    colors: Colors
    truth: Floor
    grid: GridMap
    texts: tuple[PlacedText, ...] = ()
    names: Mapping[int, str] = field(default_factory=dict)


def draw_plan(
    floor: Floor,
    look: PlanLook | None = None,
    *,
    seed: int = 0,
    texts: Mapping[int, str] | None = None,
    **changes: Any,  # noqa: ANN401 - the fields of PlanLook, with their types
) -> DrawnPlan:
    """A plan of a floor of pianta.worlds.floors, whose rooms have walls of that thickness between them.

    look: the style; changes: fields of PlanLook that differ from it, such as style="double".
    texts: name to write into each room, by id. Names that do not fit their room are left out. Rooms labelled STAIRS or
    ELEVATOR get the symbol.
    The truth has the doors as they are drawn, and, with walls of single lines, rooms that extend to the lines.
    The same seed draws the same plan. Raises OptionError for looks out of range, or a plan of too many pixels.
    """
    look = replace(look or PlanLook(), **changes)
    texts = texts or {}
    rng = np.random.default_rng(seed)
    truth = widen_doors(floor) if look.doors == "double" else floor
    footprint = unary_union([room.polygon for room in floor.rooms]).buffer(OUTER_WALL, join_style="mitre")
    lettering = Lettering(look.font, max(round(look.lettering * look.px_per_metre), 6), look.text_angle)
    numbers = dict(enumerate(dict.fromkeys(texts.values()), start=1)) if look.legend else {}
    grid = _make_sheet(footprint, look, measure_legend(numbers, lettering.face()) if numbers else 0.0)
    canvas = Canvas(np.full((*grid.shape, 3), 255, np.uint8), grid, look, footprint)
    written = _letter_rooms(truth, texts, numbers, grid, lettering)
    lines = [line for room_lines in written.values() for line in room_lines]
    _paint_rooms(canvas, truth)
    _paint_contents(canvas, truth, lines, rng)
    paint_walls(canvas, truth, rng)
    _paint_measures(canvas)
    lines += _write_around(canvas, numbers, lettering)
    colors = _photograph(write_texts(canvas.colors, lines, ink=look.color), look.noise, rng)
    return DrawnPlan(
        colors,
        extend_rooms_to_axes(truth) if look.style == "single" else truth,
        grid,
        tuple(line.to_placed() for line in lines),
        {room: texts[room] for room, room_lines in written.items() if room_lines},
    )


def _make_sheet(footprint: BaseGeometry, look: PlanLook, legend_px: float) -> GridMap:
    """The frame of a sheet for the rotated building with dimensions, title, scale bar and legend around it."""
    yaw = -radians(look.rotation)
    right, up = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    corners = get_coordinates(footprint) @ np.column_stack([right, up])
    aside = DIMENSION_STRIP if look.dimensions else 0.0
    low = corners.min(axis=0) - MARGIN - (aside, aside + TITLE_STRIP * look.scale_bar)
    high = corners.max(axis=0) + MARGIN + (MARGIN * (legend_px > 0), TITLE_STRIP * bool(look.title))
    width, height = (int(side) for side in np.ceil((high - low) * look.px_per_metre + (legend_px, 0)))
    if width * height > MAX_PIXELS:
        raise OptionError(
            f"a plan of {width} × {height} pixels is too large, give less than {look.px_per_metre:g} px_per_metre"
        )
    x, y = low[0] * right + low[1] * up
    return GridMap(np.full((height, width), UNKNOWN, np.int8), 1 / look.px_per_metre, (x, y, yaw))


def _letter_rooms(
    floor: Floor, texts: Mapping[int, str], numbers: Mapping[int, str], grid: GridMap, lettering: Lettering
) -> dict[int, list[WrittenText]]:
    """Lines of text in each room, by room id: its name, or the number of its name in the legend.

    texts: names by room id. numbers: names by their number in the legend, empty without one. grid: of the sheet.
    """
    number_of = {name: str(number) for number, name in numbers.items()}
    return {
        room.id: letter_room(number_of.get(texts[room.id], texts[room.id]), room.polygon, grid, lettering)
        for room in floor.rooms
        if room.id in texts
    }


def _paint_rooms(canvas: Canvas, floor: Floor) -> None:
    """Each room in a pastel, up to the axes of the walls."""
    if canvas.look.colored:
        for index, room in enumerate(floor.rooms):
            reach = room.polygon.buffer(INNER_WALL / 2, join_style="mitre")
            canvas.fill(reach, PASTELS[index % len(PASTELS)])


def _paint_contents(canvas: Canvas, floor: Floor, lines: Sequence[WrittenText], rng: np.random.Generator) -> None:
    """Stairs and lifts, and signs and furniture clear of the texts."""
    look = canvas.look
    corners = [canvas.grid.pixel_to_map(*line.to_placed().corners.T) for line in lines]
    written = unary_union([Polygon(np.column_stack(xy)).buffer(TEXT_MARGIN) for xy in corners])
    for room in floor.rooms:
        symbol = mark_room_symbol(room)
        if room.label in PASSAGES:
            canvas.paint(mark_signs(room.polygon.difference(written), rng) if look.evacuation else [])
        elif symbol:
            canvas.paint(symbol)
        elif look.furniture:
            canvas.paint(mark_furniture(room, floor.doors, density=look.furniture, blocked=written, rng=rng))


def _paint_measures(canvas: Canvas) -> None:
    """Dimension lines below and beside the building, and the scale bar: a dark half and a light one."""
    look = canvas.look
    top, left, bottom, right = canvas.bounds_px
    marks = []
    if look.dimensions:
        off, tick = DIMENSION_STRIP / 2 * look.px_per_metre, TICK * look.px_per_metre / 2
        for ends in (((left, bottom + off), (right, bottom + off)), ((left - off, top), (left - off, bottom))):
            slashes = [np.array([(x - tick, y + tick), (x + tick, y - tick)]) for x, y in ends]
            marks += [Mark(np.array(ends)), *map(Mark, slashes)]
    if look.scale_bar:
        row, col = _bar_corner(canvas)
        half, height = _bar_metres(canvas) * look.px_per_metre / 2, BAR_HEIGHT * look.px_per_metre
        dark, light = (_box_px(col + shift, row, half, height) for shift in (0, half))
        marks += [Mark(dark, closed=True, color=look.color), Mark(dark, closed=True), Mark(light, closed=True)]
    paint_marks(canvas.colors, marks, np.eye(2, 3), stroke_px=look.stroke_px, ink=look.color)


def _box_px(col: float, row: float, width: float, height: float) -> Floats:
    """Corners of an upright box, shape (4, 2), col and row in pixels; col, row: its lower left corner."""
    return np.array([(col, row), (col + width, row), (col + width, row - height), (col, row - height)])


def _bar_metres(canvas: Canvas) -> int:
    """Length of the scale bar, metres: the largest of BAR_LENGTHS up to a quarter of the building."""
    _, left, _, right = canvas.bounds_px
    return max((length for length in BAR_LENGTHS if 4 * length * canvas.look.px_per_metre <= right - left), default=1)


def _bar_corner(canvas: Canvas) -> tuple[float, float]:
    """Row and col of the lower left corner of the scale bar, in pixels."""
    _, left, bottom, _ = canvas.bounds_px
    below = MARGIN + BAR_HEIGHT + (DIMENSION_STRIP if canvas.look.dimensions else 0.0)
    return bottom + below * canvas.look.px_per_metre, left


def _write_around(canvas: Canvas, numbers: Mapping[int, str], lettering: Lettering) -> list[WrittenText]:
    """Title, legend, dimensions in metres, and the length of the scale bar."""
    look, face, metre = canvas.look, lettering.face(), canvas.look.px_per_metre
    top, left, bottom, right = canvas.bounds_px
    texts = []
    if look.title:
        large = lettering.face(round(1.6 * lettering.height_px))
        texts.append(WrittenText(look.title, large, (top - TITLE_STRIP / 2 * metre, (left + right) / 2)))
    if look.dimensions:
        off = DIMENSION_STRIP / 2 * metre + face.size * LINE_SPACING / 2
        width, height = (f"{length / metre:.2f}" for length in (right - left, bottom - top))
        texts.append(WrittenText(width, face, (bottom + off, (left + right) / 2)))
        texts.append(WrittenText(height, face, ((top + bottom) / 2, left - off), 90.0))
    if look.scale_bar:
        row, col = _bar_corner(canvas)
        length, below = _bar_metres(canvas), row + face.size * LINE_SPACING * 0.75
        ends = {"0": col, f"{length} m": col + length * metre}
        texts += [WrittenText(text, face, (below, end)) for text, end in ends.items()]
    return texts + (write_legend(numbers, (top, right + MARGIN * metre), face) if numbers else [])


def _photograph(colors: Colors, noise: float, rng: np.random.Generator) -> Colors:
    """The picture after a photo: uneven light, grain, JPEG artefacts."""
    if not noise:
        return colors
    height, width = colors.shape[:2]
    corners = (1 - 0.5 * noise * rng.random((3, 3))).astype(np.float32)
    light = cv2.resize(corners, (width, height), interpolation=cv2.INTER_CUBIC)[:, :, None]
    grain = rng.normal(0, 12 * noise, (height, width, 1))
    photo = np.clip(colors * light + grain, 0, 255).astype(np.uint8)
    _, encoded = cv2.imencode(".jpg", photo, [cv2.IMWRITE_JPEG_QUALITY, round(95 - 65 * noise)])
    return np.asarray(cv2.imdecode(encoded, cv2.IMREAD_COLOR), np.uint8)
