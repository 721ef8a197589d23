"""A vector plan as a sheet of pixels, at a scale at which doors have the size that the network was trained for."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Colors, Floats, Mask
from pianta.errors import OptionError, PlanError
from pianta.io._files import short_repr
from pianta.io.drawings._drawing import ROLES, DrawnText, PlanDrawing
from pianta.plan.sheets.hatches import find_hatches
from pianta.plan.sheets.sheet import DOOR_WIDTH, PlacedText, Sheet
from pianta.plan.sheets.wall_strokes import find_wall_strokes

DOOR_PX = 32  # pixels of a door; the network has 8 cells a door, so a cell is 4 pixels
LONGEST_PX = 4000  # pixels of the longer side, at most
MARGIN_PX = 24  # pixels of paper around the drawing
LINE_PX = 2  # pixels of the thinnest line
UNSCALED_SHARE = 0.5  # of LONGEST_PX, for a drawing without units and doors

MIN_UNNAMED_DOORS = 3
_GAP_SHARE = 0.5  # of the extent: what lies beyond a wider empty stretch is no part of the plan
_MAX_CUTS = 20  # empty stretches cut off along each axis
_POINT = 1e-9  # drawing units: a smaller drawing is a point
_LINE_OF_CAPITALS = 1.4  # height of a line of text, in heights of its capitals
_LETTER_OF_CAPITALS = 0.85  # width of a letter, in heights of the capitals
_SUBPIXEL_BITS = 4  # fractional bits of points of OpenCV


def draw_sheet(drawing: PlanDrawing, *, longest_px: int = LONGEST_PX) -> Sheet:
    """Draw a vector plan as pixels, black on white, with its walls, doors and texts in their frame.

    longest_px: pixels of the longer side, at most.

    With units, a door of 0.9 m is DOOR_PX pixels wide; without units but with doors, the median door is; with neither,
    the longer side has half of longest_px, or more if leaves with their arcs ask for it. Lines are at least LINE_PX
    wide, without grey. The walls are the lines that the drawing names walls, else those with much thicker strokes, and
    its filled areas; None without such lines. Texts are placed and not drawn; a drawing without texts may have letters
    of lines, so the sheet has None. Hatches are left out, and what lies beyond an empty stretch that is wider than half
    of the extent.

    Raises OptionError if longest_px leaves no room within the margin, PlanError if nothing is drawn.
    """
    if longest_px < 4 * MARGIN_PX:
        raise OptionError(f"longest_px is {longest_px}, give at least {4 * MARGIN_PX}")
    low, high = _extent(drawing)
    frame = _Frame(low, high, _px_per_unit(drawing, high - low, longest_px))
    doors, unnamed = (
        each[((each.mean(axis=1) >= low) & (each.mean(axis=1) <= high)).all(axis=1)]
        for each in (drawing.doors, drawing.unnamed_doors)
    )
    texts = tuple(_place_text(text, frame) for text in drawing.texts if frame.holds(text.x, text.y))
    fills = _draw_fills(drawing, frame)
    is_hatch = (drawing.roles == ROLES.index("other")) & find_hatches(drawing.lines, drawing.widths)
    is_wall = _find_walls(drawing, is_hatch)
    ink = _draw_lines(drawing, ~is_hatch, frame) | fills
    return Sheet(
        colors=np.where(ink[:, :, None], np.uint8(0), np.uint8(255)).repeat(3, axis=2),
        walls=_draw_lines(drawing, is_wall, frame) | fills if is_wall.any() else None,
        doors=frame.to_pixels(doors),
        unnamed_doors=frame.to_pixels(unnamed),
        texts=texts or None,
        resolution=drawing.metres_per_unit and drawing.metres_per_unit / frame.px_per_unit,
        px_per_unit=frame.px_per_unit,
        source=drawing.source,
    )


@dataclass(frozen=True, eq=False)
class _Frame:
    """Where drawing units lie on the sheet; low, high: shape (2,), the corners of the extent, drawing units."""

    low: Floats
    high: Floats
    px_per_unit: float

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the sheet, pixels."""
        width, height = np.ceil((self.high - self.low) * self.px_per_unit).astype(int) + 2 * MARGIN_PX
        return int(height), int(width)

    def to_pixels(self, points: Floats) -> Floats:
        """Row and col, in continuous pixels, of points x, y, shape (…, 2)."""
        x, y = np.moveaxis(points, -1, 0)
        rows, cols = (self.high[1] - y) * self.px_per_unit, (x - self.low[0]) * self.px_per_unit
        return np.stack([rows + MARGIN_PX, cols + MARGIN_PX], axis=-1)

    def holds(self, x: float, y: float) -> bool:
        """Whether a point lies on the sheet."""
        row, col = self.to_pixels(np.array([x, y]))
        height, width = self.shape
        return bool(0 <= row < height and 0 <= col < width)

    def to_cv(self, points: Floats) -> NDArray[np.int32]:
        """Points x, y for OpenCV: col, row, from the centre of the first pixel, in 2**-_SUBPIXEL_BITS pixels."""
        pixels = np.clip(self.to_pixels(points), -1e5, 1e5)
        return np.asarray(np.round((pixels[..., ::-1] - 0.5) * 2**_SUBPIXEL_BITS), np.int32)


def _find_walls(drawing: PlanDrawing, is_hatch: Mask) -> Mask:
    """The lines of walls: those that the file names, else those with much thicker strokes, shape (N,)."""
    is_wall = drawing.roles == ROLES.index("wall")
    if not is_wall.any():
        is_wall[~is_hatch] = find_wall_strokes(drawing.lines[~is_hatch], drawing.widths[~is_hatch])
    return np.asarray(is_wall)


def _extent(drawing: PlanDrawing) -> tuple[Floats, Floats]:
    """The corners of what is drawn, shape (2,) each, drawing units, without what lies far off."""
    boxes = [np.stack([drawing.lines.min(axis=1), drawing.lines.max(axis=1)], axis=1)]
    boxes += [np.array([[outline.min(axis=0), outline.max(axis=0)]]) for outline in drawing.fills]
    bounds = np.concatenate(boxes)
    if not len(bounds):
        raise PlanError(f"plan {short_repr(drawing.source)} draws nothing, give one with lines")
    # Named walls are the plan, however many lines a detail beside it has
    is_wall = np.zeros(len(bounds), bool)
    is_wall[: len(drawing.lines)] = drawing.roles == ROLES.index("wall")
    weights = is_wall.astype(float) if is_wall.any() else np.ones(len(bounds))
    for axis in [0, 1] * _MAX_CUTS:
        near = _heavier_side(bounds, weights, axis)
        bounds, weights = bounds[near], weights[near]
    return bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)


def _heavier_side(bounds: Floats, weights: Floats, axis: int) -> Mask:
    """Which boxes, shape (N, 2, 2), lie on the heavier side of the widest empty stretch along an axis, shape (N,).

    All, unless the stretch is wider than half the extent, and than the longer side of what would stay.
    """
    order = np.argsort(bounds[:, 0, axis], kind="stable")
    starts = bounds[order, 0, axis]
    reached = np.maximum.accumulate(bounds[order, 1, axis])
    gaps = starts[1:] - reached[:-1]
    if not len(gaps) or gaps.max() <= _GAP_SHARE * (reached[-1] - starts[0]):
        return np.ones(len(bounds), bool)
    side = bounds[:, 0, axis] >= starts[gaps.argmax() + 1]
    side = side if weights[side].sum() > weights[~side].sum() else ~side
    rest = (bounds[side, 1].max(axis=0) - bounds[side, 0].min(axis=0)).max()
    return np.asarray(side if gaps.max() > rest else np.ones(len(bounds), bool))


def _px_per_unit(drawing: PlanDrawing, size: Floats, longest_px: int) -> float:
    """Pixels per drawing unit, so that doors have DOOR_PX and the longer side fits."""
    longest = float(size.max())
    if not longest > _POINT:
        raise PlanError(f"plan {short_repr(drawing.source)} draws a single point, give one with walls")
    fitting = (longest_px - 2 * MARGIN_PX - 1) / longest
    if drawing.metres_per_unit is not None:
        return min(fitting, DOOR_PX * drawing.metres_per_unit / DOOR_WIDTH)
    named, unnamed = _median_width(drawing.doors), _median_width(drawing.unnamed_doors)
    if named > 0:
        return min(fitting, DOOR_PX / named)
    # A few arcs may be furniture, so what leaves say never makes the sheet coarser
    finer = DOOR_PX / unnamed if unnamed > 0 and len(drawing.unnamed_doors) >= MIN_UNNAMED_DOORS else 0.0
    return min(fitting, max(finer, fitting * UNSCALED_SHARE))


def _median_width(doors: Floats) -> float:
    """Drawing units; 0 without doors."""
    return float(np.median(np.linalg.norm(np.diff(doors, axis=1), axis=2))) if len(doors) else 0.0


def _draw_lines(drawing: PlanDrawing, chosen: Mask, frame: _Frame) -> Mask:
    """Lines of their widths; those of LINE_PX have exactly that, although OpenCV draws odd numbers of pixels."""
    points = frame.to_cv(drawing.lines[chosen])
    widths = np.round(drawing.widths[chosen] * frame.px_per_unit).clip(LINE_PX, max(frame.shape))
    canvas: Colors = np.zeros(frame.shape, np.uint8)
    # A line of two pixels lies on both sides of the border between them
    _draw_chains(canvas, points[widths == LINE_PX] + 2 ** (_SUBPIXEL_BITS - 1), 1)
    canvas = np.asarray(cv2.dilate(canvas, np.ones((LINE_PX, LINE_PX), np.uint8), anchor=(0, 0)), np.uint8)
    for width in np.unique(widths[widths > LINE_PX]):
        _draw_chains(canvas, points[widths == width], int(width) - 1)
    return np.asarray(canvas > 0)


def _draw_chains(canvas: Colors, points: NDArray[np.int32], thickness: int) -> None:
    cv2.polylines(canvas, list(points), False, 255, thickness, cv2.LINE_8, _SUBPIXEL_BITS)  # noqa: FBT003


def _draw_fills(drawing: PlanDrawing, frame: _Frame) -> Mask:
    canvas = np.zeros(frame.shape, np.uint8)
    for outline in drawing.fills:
        cv2.fillPoly(canvas, [frame.to_cv(outline)], 255, cv2.LINE_8, _SUBPIXEL_BITS)
    return canvas > 0


def _place_text(text: DrawnText, frame: _Frame) -> PlacedText:
    """A text with a box as high as a line of it, and as wide as its letters usually are."""
    along = np.array([np.cos(text.angle), np.sin(text.angle)])
    up = np.array([-along[1], along[0]])
    right = along * len(text.text) * _LETTER_OF_CAPITALS * text.height / 2
    above = up * _LINE_OF_CAPITALS * text.height / 2
    corners = np.array([text.x, text.y]) + np.array([above - right, above + right, right - above, -above - right])
    return PlacedText(text.text, frame.to_pixels(corners))
