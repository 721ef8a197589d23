"""Symbols of plans as small drawings of our own: doors, windows, stairs, lifts and the signs of evacuation maps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import ceil, cos, radians, sin
from types import MappingProxyType
from typing import Literal

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pianta._types import Colors, Floats
from pianta.errors import OptionError
from pianta.gridmap import GridMap

Color = tuple[int, int, int]
SymbolKind = Literal["door", "window", "object"]

BLACK, WHITE, RED, GREEN = (0, 0, 0), (255, 255, 255), (214, 28, 36), (0, 146, 69)
SUBPIXEL_BITS = 6  # fractional bits of points of OpenCV
WALL_DEPTH = 0.24  # door widths of the depth of a wall
TREAD = 0.3  # door widths between the treads of stairs


@dataclass(frozen=True, eq=False)
class Mark:
    """A line of a drawing, or a filled area.

    points: shape (N, 2), x to the right and y down. closed: whether the last joins the first.
    color: red, green, blue of an area; None for a line, which is drawn in the ink of the plan.
    """

    points: Floats
    closed: bool = False
    color: Color | None = None


@dataclass(frozen=True, eq=False)
class SymbolDrawing:
    """A symbol, in widths of a single door: x to the right and y down.

    jambs: shape (2, 2), the ends of the gap of a door or window in the axis of the wall; None for objects.
    """

    kind: SymbolKind
    marks: tuple[Mark, ...]
    jambs: Floats | None = None

    @property
    def is_sign(self) -> bool:
        """Whether it has colours of its own."""
        return any(mark.color is not None for mark in self.marks)


def draw_symbol(name: str, *, size_px: float, stroke_px: int = 1) -> Colors:
    """A symbol on white paper: greys, shape (H, W), or colours, shape (H, W, 3), of signs.

    name: one of SYMBOLS. size_px: the width of a single door, pixels. stroke_px: width of the lines, pixels.
    Raises OptionError for any other name and for sizes at which nothing can be seen.
    """
    (height, width), matrix = frame_symbol(name, size_px=size_px, stroke_px=stroke_px)
    paper = np.full((height, width, 3), 255, np.uint8)
    paint_marks(paper, SYMBOLS[name].marks, matrix, stroke_px=stroke_px)
    return paper if SYMBOLS[name].is_sign else paper[:, :, 0].copy()


def frame_symbol(name: str, *, size_px: float, stroke_px: int = 1) -> tuple[tuple[int, int], Floats]:
    """Rows and columns of what draw_symbol draws, and the matrix, shape (2, 3), from the drawing to its col, row.

    The matrix gives continuous pixels, so also the jambs on the picture. Errors as of draw_symbol.
    """
    if name not in SYMBOLS:
        raise OptionError(f"symbol is {name!r}, give one of {', '.join(SYMBOLS)}")
    if not (size_px >= 4 and stroke_px >= 1):
        raise OptionError(f"a symbol of {size_px} px in lines of {stroke_px} px cannot be seen, give 4 and 1 or more")
    symbol = SYMBOLS[name]
    jambs = [] if symbol.jambs is None else [symbol.jambs]
    points = np.concatenate([*(mark.points for mark in symbol.marks), *jambs])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = stroke_px + 1  # smooth lines are wider by a pixel
    width, height = (max(ceil(side * size_px + 2 * margin), 3) for side in high - low)
    matrix = np.array([[size_px, 0, margin - low[0] * size_px], [0, size_px, margin - low[1] * size_px]])
    return (height, width), matrix


def paint_marks(
    colors: Colors, marks: Iterable[Mark], matrix: Floats, *, stroke_px: int = 1, ink: Color = BLACK
) -> None:
    """Paint marks over a picture, shape (H, W, 3), smoothly.

    matrix: shape (2, 3), from the frame of the marks to continuous pixels col, row.
    """
    for mark in marks:
        cols_and_rows = mark.points @ matrix[:, :2].T + matrix[:, 2]
        # OpenCV counts from the middle of the first pixel
        points = np.round((cols_and_rows - 0.5) * 2**SUBPIXEL_BITS).astype(np.int32)
        if mark.color is not None:
            cv2.fillPoly(colors, [points], mark.color, cv2.LINE_AA, SUBPIXEL_BITS)
        else:
            cv2.polylines(colors, [points], mark.closed, ink, stroke_px, cv2.LINE_AA, SUBPIXEL_BITS)


def pixel_matrix(grid: GridMap) -> Floats:
    """From x, y of a map frame, metres, to continuous pixels col, row of its grid; shape (2, 3)."""
    rows, cols = grid.map_to_pixel([0.0, 1.0, 0.0], [0.0, 0.0, 1.0])
    ends = np.array([cols, rows])
    return np.column_stack([ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0], ends[:, 0]])


def _line(*points: ArrayLike) -> Mark:
    return Mark(np.array(points, float))


def _area(color: Color, *points: ArrayLike) -> Mark:
    return Mark(np.array(points, float), closed=True, color=color)


def _frame(left: float, top: float, right: float, bottom: float) -> Mark:
    return Mark(np.array([(left, top), (right, top), (right, bottom), (left, bottom)], float), closed=True)


def _rectangle(color: Color, left: float, top: float, right: float, bottom: float) -> Mark:
    return _area(color, (left, top), (right, top), (right, bottom), (left, bottom))


def _arc(start: float, stop: float) -> Floats:
    """Points of an arc of radius 1 around the origin; degrees, from the x axis upwards on the sheet."""
    angles = np.radians(np.linspace(start, stop, 2 + round(abs(stop - start) / 6)))
    return np.column_stack([np.cos(angles), -np.sin(angles)])


def _swing(angle: float, *, hinge: float = 0.0, mirrored: bool = False, arc: bool = True) -> tuple[Mark, ...]:
    """A leaf of width 1 open by an angle, degrees, and the arc of its free edge back to the other jamb."""
    side = -1 if mirrored else 1
    tip = hinge + side * cos(radians(angle)), -sin(radians(angle))
    leaf = _line((hinge, 0), tip)
    return (leaf, Mark(_arc(angle, 0) * (side, 1) + (hinge, 0))) if arc else (leaf,)


def _door(*marks: Mark, width: float = 1.0) -> SymbolDrawing:
    return SymbolDrawing("door", marks, np.array([(0.0, 0.0), (width, 0.0)]))


def _window(panes: int, width: float = 1.5) -> SymbolDrawing:
    """A number of lines along the wall, two of them its faces, between two jambs."""
    lines = [_line((0, y), (width, y)) for y in np.linspace(-WALL_DEPTH / 2, WALL_DEPTH / 2, panes)]
    ends = [_line((x, -WALL_DEPTH / 2), (x, WALL_DEPTH / 2)) for x in (0, width)]
    return SymbolDrawing("window", (*lines, *ends), np.array([(0.0, 0.0), (width, 0.0)]))


def _object(*marks: Mark) -> SymbolDrawing:
    return SymbolDrawing("object", marks)


def _sign(color: Color, *marks: Mark) -> SymbolDrawing:
    """A picture on a square of a colour."""
    return _object(_rectangle(color, 0, 0, 1, 1), *marks)


def _stairs(treads: int = 10, width: float = 1.4) -> SymbolDrawing:
    """Treads across a flight, and an arrow along its middle."""
    length, middle = treads * TREAD, width / 2
    lines = [_line((x, 0), (x, width)) for x in np.arange(1, treads) * TREAD]
    tip, barbs = length - TREAD, length - 2 * TREAD
    head = _line((barbs, middle - 0.15), (tip, middle), (barbs, middle + 0.15))
    return _object(_frame(0, 0, length, width), *lines, _line((TREAD / 2, middle), (tip, middle)), head)


def _lift(side: float = 1.8) -> SymbolDrawing:
    """A box with its diagonals."""
    return _object(_frame(0, 0, side, side), _line((0, 0), (side, side)), _line((0, side), (side, 0)))


def _extinguisher() -> SymbolDrawing:
    bottle = [(0.36, 0.88), (0.36, 0.42), (0.44, 0.32), (0.44, 0.24), (0.58, 0.24), (0.58, 0.32), (0.66, 0.42)]
    hose = [(0.44, 0.2), (0.3, 0.28), (0.22, 0.52), (0.28, 0.54), (0.35, 0.32), (0.46, 0.26)]
    handle = [(0.42, 0.12), (0.7, 0.16), (0.7, 0.22), (0.42, 0.2)]
    return _sign(RED, *(_area(WHITE, *shape) for shape in ([*bottle, (0.66, 0.88)], hose, handle)))


def _hydrant() -> SymbolDrawing:
    """A reel of hose, and its nozzle."""
    circle = _arc(0, 360)
    rings = [(0.34, WHITE), (0.25, RED), (0.16, WHITE), (0.07, RED)]
    reel = [_area(color, *(circle * radius + (0.42, 0.46))) for radius, color in rings]
    return _sign(RED, *reel, _area(WHITE, (0.7, 0.5), (0.78, 0.5), (0.86, 0.86), (0.76, 0.86)))


def _arrow(tip: tuple[float, float], direction: tuple[float, float], color: Color, length: float) -> Mark:
    """An arrow with its tip at a point."""
    outline = np.array([(0, 0), (-0.45, 0.36), (-0.45, 0.14), (-1, 0.14), (-1, -0.14), (-0.45, -0.14), (-0.45, -0.36)])
    along = np.array(direction) / np.hypot(*direction)
    across = np.array([-along[1], along[0]])
    return _area(color, *(np.array(tip) + length * (outline[:, :1] * along + outline[:, 1:] * across)))


def _exit() -> SymbolDrawing:
    """A doorway, and an arrow to it."""
    return _sign(GREEN, _rectangle(WHITE, 0.62, 0.16, 0.86, 0.84), _arrow((0.56, 0.5), (1, 0), WHITE, 0.46))


def _first_aid() -> SymbolDrawing:
    """A cross."""
    return _sign(GREEN, _rectangle(WHITE, 0.4, 0.16, 0.6, 0.84), _rectangle(WHITE, 0.16, 0.4, 0.84, 0.6))


def _assembly_point() -> SymbolDrawing:
    """Four arrows to the middle."""
    ways = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    return _sign(GREEN, *(_arrow((0.5 - 0.08 * x, 0.5 - 0.08 * y), (x, y), WHITE, 0.42) for x, y in ways))


def _way_out() -> SymbolDrawing:
    """The green arrow along an escape route."""
    return _object(_arrow((1.6, 0.3), (1, 0), (0, 190, 60), 1.6))


SYMBOLS: Mapping[str, SymbolDrawing] = MappingProxyType(
    {
        "door": _door(*_swing(90)),
        "door 45": _door(*_swing(45)),
        "leaf": _door(*_swing(90, arc=False)),
        "leaf 45": _door(*_swing(45, arc=False)),
        "double door": _door(*_swing(90), *_swing(90, hinge=2, mirrored=True), width=2),
        "sliding door": _door(
            _frame(-0.05, -0.1, 0.55, 0),
            _frame(0.45, 0, 1.05, 0.1),
            _line((0, -0.1), (0, 0.1)),
            _line((1, -0.1), (1, 0.1)),
        ),
        "window": _window(2),
        "window 3": _window(3),
        "stairs": _stairs(),
        "lift": _lift(),
        "extinguisher": _extinguisher(),
        "hydrant": _hydrant(),
        "exit": _exit(),
        "first aid": _first_aid(),
        "assembly point": _assembly_point(),
        "way out": _way_out(),
    }
)
