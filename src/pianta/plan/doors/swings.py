"""Doors by their swings: the quarter circle of a leaf's free edge, which tells where a door is and how wide.

A swing needs no scale: circles are fitted to what is curved in the outlines of the ink, and those stay that are a
quarter, thin, and have a leaf at one end and a jamb at the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.plan.doors.quarters import DIRECTIONS, MOST_CLUTTER, RINGS, Quarter, read_quarters
from pianta.plan.sheets.binarization import Contrast

# Radii that are looked for, pixels, and how much one length of looking grows to the next.
LEAST_RADIUS, MOST_RADIUS, GROWTH = 7.0, 150.0, 1.2
# Ink, and the hair-light lines of evacuation maps, in units of measure_contrast.
LEVELS = (0.5, 0.2)
# Sheets are brought to so many pixels, small ones enlarged so many times at most, for circles of few pixels.
FINE_PIXELS, MOST_FACTOR = 3e6, 3.0
# What is fitted at once: this many radians of a circle, through so many points.
LEAST_TURN, MOST_TURN, FITTED = 1.05, 1.5, 13
# What is looked at of a circle and fitted again, radians from the middle of its arc.
ROUND, ARC = np.linspace(-pi, pi, DIRECTIONS, endpoint=False), np.linspace(-0.55, 0.55, 15)
WHOLE_ARC, FITTINGS = np.linspace(-0.52, 0.52, 19), 3
ON, BESIDE = np.array([0.94, 0.97, 1.0, 1.03, 1.06]), np.array([0.4, 0.55, 0.7, 0.84, 1.16, 1.25])
MAX_CIRCLES = 3000
# Pixels about circles that are looked up at once.
CACHED = 1 << 16
# The drawing that a door belongs to is so many radii long, and such a share of the sheet.
LEAST_DRAWING, LEAST_SHARE = 5.0, 0.1
# Doors of one plan differ so much, and so many of one width tell it.
SPREAD, LEAST_DOORS = 0.12, 3
# A leaf sweeps from here to here, degrees from the closed door, and so many radii with its stroke.
SWEPT_FROM, SWEPT_TO, SWEPT_RADIUS = 10.0, 95.0, 1.1
# What is smaller or larger than the doors of a plan by so much is none.
LEAST_SIZE, MOST_SIZE = 0.6, 1.6


@dataclass(frozen=True, eq=False)
class Swing:
    """A door drawn with its leaf and the quarter circle of the leaf's free edge.

    hinge, jamb: the ends of the closed door; open_end: where the leaf's free edge is drawn; row and col in continuous
    pixels, shape (2,). radius: pixels. score: 0 … 1, how much of arc and leaf is drawn.
    """

    hinge: Floats
    jamb: Floats
    open_end: Floats
    radius: float
    score: float

    @property
    def middle(self) -> Floats:
        """Row and col of the middle of the quarter, shape (2,)."""
        return np.asarray((self.jamb + self.open_end) / 2)

    @property
    def closed(self) -> Floats:
        """The closed door from hinge to jamb, shape (2, 2), row and col."""
        return np.array([self.hinge, self.jamb])

    def sweep(self) -> Floats:
        """Corners of what the leaf sweeps, its arc included but not the closed door, shape (N, 2), row and col."""
        closed, opened = self.jamb - self.hinge, self.open_end - self.hinge
        turned = np.radians(np.linspace(SWEPT_FROM, SWEPT_TO, 10))[:, None]
        rim = SWEPT_RADIUS * (np.cos(turned) * closed + np.sin(turned) * opened)
        return np.asarray(self.hinge + np.vstack([np.zeros((1, 2)), rim]))


@dataclass(frozen=True)
class DoorSize:
    """The width of the doors of a sheet, pixels, of how many doors it is, and how sure, 0 … 1."""

    px: float
    count: int
    confidence: float


def agree_on_size(swings: Sequence[Swing]) -> DoorSize | None:
    """The width on which most swings agree within 12 %, None when fewer than 3 do."""
    radii = np.array([swing.radius for swing in swings])
    if len(radii) < LEAST_DOORS:
        return None
    # What is taken for a swing in letters and furniture is mostly small
    scores = np.array([swing.score * swing.radius for swing in swings])
    agrees = np.abs(np.log(radii[:, None] / radii[None])) <= np.log1p(SPREAD)
    best = agrees[int((agrees @ scores).argmax())]
    count = int(best.sum())
    if count < LEAST_DOORS:
        return None
    share = float(scores[best].sum() / scores.sum())
    return DoorSize(float(np.median(radii[best])), count, share * count / (count + 2))


def find_swings(contrast: Contrast | Mask) -> tuple[Swing, ...]:
    """The doors of a sheet drawn with a swing, best first; each leaf of a double door is one.

    contrast: shape (H, W), 0 … 1: as of measure_contrast where that is more than binarise, which has wide walls; or the
    ink. Doors of 7 to 150 pixels are found.
    """
    if min(contrast.shape) < 2 * LEAST_RADIUS:
        return ()
    factor = min(MOST_FACTOR, sqrt(FINE_PIXELS / contrast.size))
    size = tuple(round(side * factor) for side in contrast.shape[::-1])
    way = cv2.INTER_CUBIC if factor > 1 else cv2.INTER_AREA
    fine = np.asarray(cv2.resize(contrast.astype(np.float32), size, interpolation=way), np.float32)
    found = [swing for level in LEVELS for swing in _find_at_level(fine, level, factor)]
    swings = tuple(_leave_out_twins(found))
    usual = agree_on_size(swings)
    if usual is None or usual.count < 2 * LEAST_DOORS:
        return swings
    return tuple(swing for swing in swings if LEAST_SIZE <= swing.radius / usual.px <= MOST_SIZE)


def _find_at_level(fine: Contrast, level: float, factor: float) -> list[Swing]:
    """Swings of lines above a contrast; fine: enlarged by the factor."""
    points, outlines = _trace_outlines(fine > level)
    arcs = [
        _fit_circles(points, outlines, round(length * factor))
        for length in _lengths(LEAST_RADIUS * LEAST_TURN, MOST_RADIUS * MOST_TURN)
    ]
    circles = _thin_out(np.concatenate([np.zeros((0, 5)), *arcs]))
    least = np.maximum(LEAST_DRAWING * circles[:, 2], LEAST_SHARE * max(fine.shape))
    circles = circles[_measure_drawings(fine > level, circles) > least]
    circles = circles[_look_like_arcs(fine > level, circles)]
    circles = _leave_out_equal(_fit_again(fine, circles, ARC))
    circles, quarters = _keep_quarters(fine > level, circles, [None] * len(circles))
    for _ in range(FITTINGS):
        circles, quarters = _keep_quarters(fine > level, _fit_again(fine, circles, WHOLE_ARC), quarters, circles)
    return [_place_swing(circle, quarter, factor) for circle, quarter in zip(circles, quarters, strict=True)]


def _keep_quarters(
    ink: Mask, circles: Floats, before: Sequence[Quarter | None], rough: Floats | None = None
) -> tuple[Floats, list[Quarter]]:
    """The circles that are a swing, turned to the middle of their quarter, and the quarter of each.

    before, rough: what was read of each and from what circle; it stays, with less score, where nothing is read now.
    """
    turned, quarters = [], []
    read = read_quarters(_unroll(ink, circles, ROUND, RINGS))
    for circle, new, old, other in zip(circles, read, before, circles if rough is None else rough, strict=True):
        if new is not None:
            shift = round((new.leaf + new.closed) / 2) - DIRECTIONS // 2
            turned.append(circle + np.array([0, 0, 0, shift * 2 * pi / DIRECTIONS, 0]))
            quarters.append(Quarter(new.score - float(circle[4]), new.leaf - shift, new.closed - shift))
        elif old is not None:
            turned.append(other)
            quarters.append(Quarter(0.85 * old.score, old.leaf, old.closed))
    return np.array(turned).reshape(-1, 5), quarters


def _measure_drawings(ink: Mask, circles: Floats) -> Floats:
    """The longer side of the drawing that each arc is connected to: buildings are large, chairs and letters small."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(ink.astype(np.uint8))
    sides = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1)
    sides[0] = 0
    there: Floats = sides[_unroll(labels, circles, np.zeros(1), ON)].max(axis=(1, 2)).astype(float)
    return there


def _lengths(first: float, last: float) -> Iterator[float]:
    while first <= last:
        yield first
        first *= GROWTH


def _trace_outlines(ink: Mask) -> tuple[Floats, NDArray[np.int64]]:
    """Points one pixel apart along the outlines of ink, row and col, and the number of the outline of each."""
    outlines, _ = cv2.findContours(ink.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    # An outline begins anywhere, so its begin is told again at its end.
    turned = [np.concatenate([line, line[: len(line) // 2]]) for line in outlines if len(line) >= 2 * LEAST_RADIUS]
    if not turned:
        return np.zeros((0, 2)), np.zeros(0, np.int64)
    points = np.concatenate(turned)[:, 0, ::-1].astype(float)
    number = np.repeat(np.arange(len(turned)), [len(line) for line in turned])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    places = np.arange(0, along[-1])
    before = np.searchsorted(along, places, side="right") - 1
    within = number[before] == number[np.minimum(before + 1, len(number) - 1)]
    evenly = np.column_stack([np.interp(places[within], along, points[:, axis]) for axis in (0, 1)])
    return evenly, number[before][within]


def _fit_circles(points: Floats, outlines: NDArray[np.int64], length: int) -> Floats:
    """Circles through pieces of outlines of a length, shape (M, 5): row, col, radius, direction, misfit in radii."""
    starts = np.arange(0, len(points) - length, max(1, length // 8))
    starts = starts[outlines[starts] == outlines[starts + length]]
    rows, cols = points.T.copy()
    ends = [(axis[starts], axis[starts + length // 2], axis[starts + length]) for axis in (rows, cols)]
    chord = np.hypot(*(last - first for first, _, last in ends))
    height = np.hypot(*(middle - (first + last) / 2 for first, middle, last in ends))
    radius = chord**2 / (8 * np.maximum(height, 1e-3)) + height / 2
    starts = starts[(length / radius > 0.9 * LEAST_TURN) & (length / radius < 1.1 * MOST_TURN)]
    places = starts + np.round(np.linspace(0, length, FITTED)).astype(int)[:, None]
    circles = _fit_pieces(rows[places], cols[places])
    radius, misfit = circles[:, 2], circles[:, 4]
    turn = length / radius
    return circles[(misfit < 0.4 / radius + 0.012) & (turn > LEAST_TURN) & (turn < MOST_TURN)]


def _fit_pieces(rows: Floats, cols: Floats) -> Floats:
    """The circle of each piece of points in a row, rows and cols of shape (N, M); columns as of _fit_circles."""
    row, col = rows.mean(axis=0), cols.mean(axis=0)
    down, right = rows - row, cols - col
    # The circle of least algebraic distance (Kåsa, 1976) solves two linear equations in its middle
    down_2, right_2 = down**2, right**2
    squares = down_2 + right_2
    a, b, c = down_2.sum(axis=0) + 1e-9, (down * right).sum(axis=0), right_2.sum(axis=0) + 1e-9
    u, v = (down * squares).sum(axis=0), (right * squares).sum(axis=0)
    scale = 2 * (a * c - b * b)
    middle = (c * u - b * v) / scale, (a * v - b * u) / scale
    radius = np.sqrt(middle[0] ** 2 + middle[1] ** 2 + squares.mean(axis=0))
    apart = np.sqrt((down - middle[0]) ** 2 + (right - middle[1]) ** 2) - radius
    misfit = np.sqrt((apart**2).mean(axis=0)) / radius
    half = len(rows) // 2
    direction = np.arctan2(down[half] - middle[0], right[half] - middle[1])
    return np.column_stack([row + middle[0], col + middle[1], radius, direction, misfit])


def _fit_again(fine: Contrast, circles: Floats, arc: Floats) -> Floats:
    """Circles through the middle of the lines at whose rims they were found; columns as of _fit_circles."""
    near = np.linspace(0.88, 1.12, 13)
    shares = _unroll(fine, circles, arc, near).astype(float) + 1e-6
    radii = circles[:, 2, None] * (shares * near).sum(axis=2) / shares.sum(axis=2)
    angles = circles[:, 3, None] + arc
    rows, cols = circles[:, 0, None] + radii * np.sin(angles), circles[:, 1, None] + radii * np.cos(angles)
    return _fit_pieces(rows.T, cols.T)


def _thin_out(circles: Floats) -> Floats:
    """The best fitting of the circles in each cell of a grid of middles, radii and directions, best first."""
    circles = circles[np.argsort(circles[:, 4], kind="stable")]
    size = np.round(np.log(circles[:, 2]) / 0.12)
    cell = 0.15 * np.exp(0.12 * size)
    turn = np.round(circles[:, 3] * 3)
    coarse = np.column_stack([np.round(circles[:, 0] / cell), np.round(circles[:, 1] / cell), size, turn])
    keys = coarse.astype(np.int64) @ np.array([1 << 40, 1 << 20, 1 << 8, 1])
    return circles[np.sort(np.unique(keys, return_index=True)[1])]


def _leave_out_equal(circles: Floats) -> Floats:
    """The best fitting of circles that are nearly the same, best first."""
    kept, columns = [], circles[:MAX_CIRCLES].T.copy()
    while columns.size:
        row, col, radius, direction, _ = best = columns[:, 0].copy()
        kept.append(best)
        reach = (0.06 * radius) ** 2
        apart = (columns[0] - row) ** 2 + (columns[1] - col) ** 2
        other = (apart >= reach) | ((columns[2] - radius) ** 2 >= reach)
        other |= np.abs((columns[3] - direction + pi) % (2 * pi) - pi) >= 0.4
        other[0] = False
        columns = columns[:, other]
    return np.array(kept).reshape(-1, 5)


def _unroll(image: NDArray[Any], circles: Floats, angles: Floats, rings: Floats) -> NDArray[Any]:
    """The image about each circle, shape (M, angles, rings); angles are taken from the direction of its arc."""
    row, col, radius, direction = circles[:, :4].T.astype(np.float32)[:, :, None]
    turned = direction + angles.astype(np.float32)
    down, right, reach = np.sin(turned), np.cos(turned), radius * rings.astype(np.float32)
    height, width = image.shape
    unrolled = np.empty((len(circles), len(angles), len(rings)), image.dtype)
    # In parts that stay in the cache
    step = max(1, CACHED // (len(angles) * len(rings)))
    for part in (slice(start, start + step) for start in range(0, len(circles), step)):
        rows, cols = (
            np.clip(np.rint(place[part, None] + way[part, :, None] * reach[part, None]), 0, np.float32(side - 1))
            for place, way, side in ((row, down, height), (col, right, width))
        )
        unrolled[part] = image.take(rows.astype(np.int32) * width + cols.astype(np.int32))
    return unrolled


def _look_like_arcs(ink: Mask, circles: Floats) -> Mask:
    """Which circles have ink along the middle of their arc, hardly any on both sides of it, and are not closed."""
    arc, beside = (_unroll(ink, circles, ARC, rings) for rings in (ON, BESIDE))
    rest = _unroll(ink, circles, np.linspace(1.4, 2 * pi - 1.4, 15), ON)
    drawn, closed = (part.any(axis=2).mean(axis=1) for part in (arc, rest))
    return np.asarray((drawn > 0.85) & (beside.mean(axis=(1, 2)) <= MOST_CLUTTER) & (closed < 0.7))


def _place_swing(circle: Floats, quarter: Quarter, factor: float) -> Swing:
    row, col, radius, direction, _ = circle
    angles = np.array([quarter.leaf, quarter.closed]) * (2 * pi / DIRECTIONS) - pi + direction
    hinge = np.array([row, col])
    open_end, jamb = hinge + radius * np.column_stack([np.sin(angles), np.cos(angles)])
    # OpenCV counts from the middle of the first pixel
    hinge, jamb, open_end = ((place + 0.5) / factor for place in (hinge, jamb, open_end))
    return Swing(hinge, jamb, open_end, float(radius) / factor, quarter.score)


def _leave_out_twins(swings: list[Swing]) -> list[Swing]:
    """The best of swings that lie over each other; leaf, arc and door have small swings in their corners."""
    best: list[Swing] = []
    for swing in sorted(swings, key=lambda swing: -swing.score):
        if not any(_cover(other, swing) and abs(np.log(other.radius / swing.radius)) < 0.3 for other in best):
            best.append(swing)
    kept: list[Swing] = []
    for swing in sorted(best, key=lambda swing: -swing.score * sqrt(swing.radius)):
        if not any(_cover(other, swing) for other in kept):
            kept.append(swing)
    return kept


def _cover(swing: Swing, other: Swing) -> bool:
    return bool(np.hypot(*(swing.middle - other.middle)) <= 0.6 * swing.radius)
