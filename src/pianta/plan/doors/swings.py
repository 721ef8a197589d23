"""Doors by their swings: the quarter circle of a leaf's free edge, which shows where a door is and how wide.

A swing needs no scale: circles are fitted to what is curved in the outlines of the ink, and those stay that are a
quarter, thin, and have a leaf at one end and a jamb at the other. A circle is a row of row, col, radius, the direction
of its arc from the middle, rad, and the misfit of its points, in radii.
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
from pianta.plan.doors.swing_fits import N_DIRECTIONS, RADII, SwingFit, fit_swings
from pianta.plan.doors.swing_fits import PARAMETERS as FIT_PARAMETERS
from pianta.plan.sheets.binarization import Contrast


@dataclass(frozen=True, kw_only=True)
class SwingParameters:
    """Thresholds of `find_swings`; working pixels are those of the resized sheet.

    Chosen by hand, no fit is on record.
    """

    contrast_levels: tuple[float, ...] = (0.5, 0.2)  # of ink, and of the hair-light lines of evacuation maps
    working_pixels: float = 3e6  # to which a sheet is resized
    max_enlargement: float = 3.0  # of small sheets; circles of few pixels fit badly
    # Pieces of outlines that are fitted
    min_radius: float = 7.0  # px of the sheet
    max_radius: float = 150.0  # px of the sheet
    length_step: float = 1.2  # factor from one length of pieces to the next
    min_turn: float = 1.05  # rad of a circle that a piece spans
    max_turn: float = 1.5  # rad
    turn_slack: float = 0.1  # share by which a piece may miss these turns before it is fitted exactly
    n_starts: int = 8  # pieces that begin within one length
    n_fitted_points: int = 13  # of a piece
    max_misfit_px: float = 0.4  # working pixels of misfit, plus:
    max_misfit: float = 0.012  # radii of misfit
    # Circles that are alike; in the grid for a first thinning, and for the second one
    grid_log_radius: float = 0.12  # cell of the logarithm of the radius
    grid_middle: float = 0.15  # cell of the middle, radii
    grid_directions: float = 3.0  # cells per rad of direction
    equal_distance: float = 0.06  # radii between middles, and between radii
    equal_direction: float = 0.4  # rad
    max_circles: int = 3000  # after the first thinning, the best fitting ones
    # What is drawn along an arc
    min_drawing_radii: float = 5.0  # longer side of the drawing that an arc belongs to: chairs and letters are small
    min_drawing_share: float = 0.1  # the same, of the longer side of the sheet
    min_arc_ink: float = 0.85  # share of ink along the middle of an arc
    max_rest_ink: float = 0.7  # share of ink along the rest of the circle
    # Fits of leaf and jamb
    n_refits: int = 3  # times that a circle is fitted again to the whole arc
    lost_fit_factor: float = 0.85  # of the score of a swing that a fit again does not find
    # Swings that are alike
    twin_log_radius: float = 0.3  # logarithm of the ratio of radii
    cover_distance: float = 0.6  # radii between the middles of swings that lie over each other
    # The usual width
    radius_spread: float = 0.12  # share by which the doors of one plan differ
    min_doors: int = 3  # swings of one radius that show the width
    min_size: float = 0.6  # of the usual radius; smaller swings are dropped if twice min_doors have the usual one
    max_size: float = 1.6  # of the usual radius; so are larger ones
    # What the leaf sweeps
    sweep_from: float = 10.0  # degrees from the closed door
    sweep_to: float = 95.0  # degrees
    sweep_radius: float = 1.1  # radii, with the stroke of the arc


PARAMETERS = SwingParameters()

# Directions about a circle, rad from the middle of its arc: all around; along the middle of the arc for the first look;
# along the whole arc; along the rest of the circle
AROUND = np.linspace(-pi, pi, N_DIRECTIONS, endpoint=False)
ARC = np.linspace(-0.55, 0.55, 15)
WHOLE_ARC = np.linspace(-0.52, 0.52, 19)
REST = np.linspace(1.4, 2 * pi - 1.4, 15)
# Radii, in those of the circle: on the arc; beside it; where the line of the arc is looked for
ON_ARC = np.array([0.94, 0.97, 1.0, 1.03, 1.06])
BESIDE_ARC = np.array([0.4, 0.55, 0.7, 0.84, 1.16, 1.25])
NEAR_ARC = np.linspace(0.88, 1.12, 13)
# Pixels about circles that are looked up at once, so that they stay in the cache
N_CACHED_PIXELS = 1 << 16


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
        angles = np.radians(np.linspace(PARAMETERS.sweep_from, PARAMETERS.sweep_to, 10))[:, None]
        rim = PARAMETERS.sweep_radius * (np.cos(angles) * closed + np.sin(angles) * opened)
        return np.asarray(self.hinge + np.vstack([np.zeros((1, 2)), rim]))


@dataclass(frozen=True)
class DoorWidth:
    """The width of the doors of a sheet, pixels, the number of doors that have it, and its confidence, 0 … 1."""

    px: float
    count: int
    confidence: float


def consensus_door_width(swings: Sequence[Swing]) -> DoorWidth | None:
    """The width on which most swings agree, None if too few do."""
    radii = np.array([swing.radius for swing in swings])
    if len(radii) < PARAMETERS.min_doors:
        return None
    # False swings, in letters and furniture, are mostly small
    scores = np.array([swing.score * swing.radius for swing in swings])
    agrees = np.abs(np.log(radii[:, None] / radii[None])) <= np.log1p(PARAMETERS.radius_spread)
    best = agrees[int((agrees @ scores).argmax())]
    count = int(best.sum())
    if count < PARAMETERS.min_doors:
        return None
    share = float(scores[best].sum() / scores.sum())
    return DoorWidth(float(np.median(radii[best])), count, share * count / (count + 2))


def find_swings(contrast: Contrast | Mask) -> tuple[Swing, ...]:
    """The doors of a sheet drawn with a swing, best first; each leaf of a double door is one.

    contrast: shape (H, W), 0 … 1, of `Sheet`, at least 1 where its ink is, which has wide walls; or the ink alone.
    """
    if min(contrast.shape) < 2 * PARAMETERS.min_radius:
        return ()
    factor = min(PARAMETERS.max_enlargement, sqrt(PARAMETERS.working_pixels / contrast.size))
    size = tuple(round(side * factor) for side in contrast.shape[::-1])
    method = cv2.INTER_CUBIC if factor > 1 else cv2.INTER_AREA
    resized = np.asarray(cv2.resize(contrast.astype(np.float32), size, interpolation=method), np.float32)
    levels = PARAMETERS.contrast_levels
    swings = tuple(_drop_twins([swing for level in levels for swing in _find_at_level(resized, level, factor)]))
    usual = consensus_door_width(swings)
    if usual is None or usual.count < 2 * PARAMETERS.min_doors:
        return swings
    return tuple(swing for swing in swings if PARAMETERS.min_size <= swing.radius / usual.px <= PARAMETERS.max_size)


def _find_at_level(contrast: Contrast, level: float, factor: float) -> list[Swing]:
    """Swings of lines above a contrast; contrast: of the sheet resized by the factor."""
    p, ink = PARAMETERS, contrast > level
    points, outlines = _trace_outlines(ink)
    lengths = _lengths(p.min_radius * p.min_turn, p.max_radius * p.max_turn)
    arcs = [_fit_circles(points, outlines, round(length * factor)) for length in lengths]
    circles = _thin_out(np.concatenate([np.zeros((0, 5)), *arcs]))
    smallest = np.maximum(p.min_drawing_radii * circles[:, 2], p.min_drawing_share * max(contrast.shape))
    circles = circles[_drawing_sizes(ink, circles) > smallest]
    circles = circles[_are_arcs(ink, circles)]
    circles = _drop_equal(_fit_to_lines(contrast, circles, ARC))
    circles, fits = _fit_doors(ink, circles, [None] * len(circles), circles)
    for _ in range(p.n_refits):
        circles, fits = _fit_doors(ink, _fit_to_lines(contrast, circles, WHOLE_ARC), fits, circles)
    return [_place_swing(circle, fit, factor) for circle, fit in zip(circles, fits, strict=True)]


def _fit_doors(
    ink: Mask, circles: Floats, former_fits: Sequence[SwingFit | None], former_circles: Floats
) -> tuple[Floats, list[SwingFit]]:
    """The circles that are a swing, their directions moved to the middle of the quarter, and the fit of each.

    former_fits, former_circles: stay, with a lower score, for circles that have no fit now.
    """
    moved, fits = [], []
    rays = _unroll(ink, circles, AROUND, RADII)
    for circle, fit, former, former_circle in zip(circles, fit_swings(rays), former_fits, former_circles, strict=True):
        if fit is not None:
            shift = round((fit.leaf + fit.closed) / 2) - N_DIRECTIONS // 2
            moved.append(circle + np.array([0, 0, 0, shift * 2 * pi / N_DIRECTIONS, 0]))
            fits.append(SwingFit(fit.score - float(circle[4]), fit.leaf - shift, fit.closed - shift))
        elif former is not None:
            moved.append(former_circle)
            fits.append(SwingFit(PARAMETERS.lost_fit_factor * former.score, former.leaf, former.closed))
    return np.array(moved).reshape(-1, 5), fits


def _drawing_sizes(ink: Mask, circles: Floats) -> Floats:
    """The longer side of the drawing that each arc is connected to, pixels: buildings are large, letters small."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(ink.astype(np.uint8))
    sides = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1)
    sides[0] = 0
    sizes: Floats = sides[_unroll(labels, circles, np.zeros(1), ON_ARC)].max(axis=(1, 2)).astype(float)
    return sizes


def _lengths(first: float, last: float) -> Iterator[float]:
    while first <= last:
        yield first
        first *= PARAMETERS.length_step


def _trace_outlines(ink: Mask) -> tuple[Floats, NDArray[np.int64]]:
    """Points one pixel apart along the outlines of ink, row and col, and the number of the outline of each."""
    outlines, _ = cv2.findContours(ink.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    # An outline starts anywhere, so its first half follows again after its end
    long = [
        np.concatenate([line, line[: len(line) // 2]]) for line in outlines if len(line) >= 2 * PARAMETERS.min_radius
    ]
    if not long:
        return np.zeros((0, 2)), np.zeros(0, np.int64)
    points = np.concatenate(long)[:, 0, ::-1].astype(float)
    number = np.repeat(np.arange(len(long)), [len(line) for line in long])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    positions = np.arange(0, along[-1])
    before = np.searchsorted(along, positions, side="right") - 1
    within = number[before] == number[np.minimum(before + 1, len(number) - 1)]
    evenly = np.column_stack([np.interp(positions[within], along, points[:, axis]) for axis in (0, 1)])
    return evenly, number[before][within]


def _fit_circles(points: Floats, outlines: NDArray[np.int64], length: int) -> Floats:
    """Circles through pieces of outlines of a length, pixels, shape (M, 5)."""
    p = PARAMETERS
    starts = np.arange(0, len(points) - length, max(1, length // p.n_starts))
    starts = starts[outlines[starts] == outlines[starts + length]]
    rows, cols = points.T.copy()
    # Three points show roughly how much a piece turns
    ends = [(axis[starts], axis[starts + length // 2], axis[starts + length]) for axis in (rows, cols)]
    chord = np.hypot(*(last - first for first, _, last in ends))
    height = np.hypot(*(middle - (first + last) / 2 for first, middle, last in ends))
    turn = length / (chord**2 / (8 * np.maximum(height, 1e-3)) + height / 2)
    starts = starts[(turn > (1 - p.turn_slack) * p.min_turn) & (turn < (1 + p.turn_slack) * p.max_turn)]
    fitted = starts + np.round(np.linspace(0, length, p.n_fitted_points)).astype(int)[:, None]
    circles = _fit_pieces(rows[fitted], cols[fitted])
    radius, misfit = circles[:, 2], circles[:, 4]
    turn = length / radius
    fits = misfit < p.max_misfit_px / radius + p.max_misfit
    return circles[fits & (turn > p.min_turn) & (turn < p.max_turn)]


def _fit_pieces(rows: Floats, cols: Floats) -> Floats:
    """The circle of each piece of N points, rows and cols of shape (N, M); shape (M, 5)."""
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
    off = np.sqrt((down - middle[0]) ** 2 + (right - middle[1]) ** 2) - radius
    misfit = np.sqrt((off**2).mean(axis=0)) / radius
    half = len(rows) // 2
    direction = np.arctan2(down[half] - middle[0], right[half] - middle[1])
    return np.column_stack([row + middle[0], col + middle[1], radius, direction, misfit])


def _fit_to_lines(contrast: Contrast, circles: Floats, arc: Floats) -> Floats:
    """Circles through the middle of the lines at whose edges they were fitted, shape (M, 5)."""
    shares = _unroll(contrast, circles, arc, NEAR_ARC).astype(float) + 1e-6
    radii = circles[:, 2, None] * (shares * NEAR_ARC).sum(axis=2) / shares.sum(axis=2)
    angles = circles[:, 3, None] + arc
    rows, cols = circles[:, 0, None] + radii * np.sin(angles), circles[:, 1, None] + radii * np.cos(angles)
    return _fit_pieces(rows.T, cols.T)


def _thin_out(circles: Floats) -> Floats:
    """The best fitting of the circles in each cell of a grid of middles, radii and directions, best first."""
    p = PARAMETERS
    circles = circles[np.argsort(circles[:, 4], kind="stable")]
    size = np.round(np.log(circles[:, 2]) / p.grid_log_radius)
    cell = p.grid_middle * np.exp(p.grid_log_radius * size)
    turn = np.round(circles[:, 3] * p.grid_directions)
    coarse = np.column_stack([np.round(circles[:, 0] / cell), np.round(circles[:, 1] / cell), size, turn])
    keys = coarse.astype(np.int64) @ np.array([1 << 40, 1 << 20, 1 << 8, 1])
    return circles[np.sort(np.unique(keys, return_index=True)[1])]


def _drop_equal(circles: Floats) -> Floats:
    """The best fitting of circles that are nearly the same, best first."""
    distinct, columns = [], circles[: PARAMETERS.max_circles].T.copy()
    while columns.size:
        row, col, radius, direction, _ = best = columns[:, 0].copy()
        distinct.append(best)
        reach = (PARAMETERS.equal_distance * radius) ** 2
        is_other = ((columns[0] - row) ** 2 + (columns[1] - col) ** 2 >= reach) | ((columns[2] - radius) ** 2 >= reach)
        is_other |= np.abs((columns[3] - direction + pi) % (2 * pi) - pi) >= PARAMETERS.equal_direction
        is_other[0] = False
        columns = columns[:, is_other]
    return np.array(distinct).reshape(-1, 5)


def _unroll(image: NDArray[Any], circles: Floats, angles: Floats, radii: Floats) -> NDArray[Any]:
    """The image about each circle, shape (M, angles, radii); angles are from the direction of its arc."""
    row, col, radius, direction = circles[:, :4].T.astype(np.float32)[:, :, None]
    turned = direction + angles.astype(np.float32)
    down, right, reach = np.sin(turned), np.cos(turned), radius * radii.astype(np.float32)
    height, width = image.shape
    unrolled = np.empty((len(circles), len(angles), len(radii)), image.dtype)
    step = max(1, N_CACHED_PIXELS // (len(angles) * len(radii)))
    for batch in (slice(start, start + step) for start in range(0, len(circles), step)):
        rows, cols = (
            np.clip(np.rint(middle[batch, None] + way[batch, :, None] * reach[batch, None]), 0, np.float32(side - 1))
            for middle, way, side in ((row, down, height), (col, right, width))
        )
        unrolled[batch] = image.take(rows.astype(np.int32) * width + cols.astype(np.int32))
    return unrolled


def _are_arcs(ink: Mask, circles: Floats) -> Mask:
    """Which circles have ink along the middle of their arc, hardly any on both sides of it, and are not closed."""
    beside = _unroll(ink, circles, ARC, BESIDE_ARC).mean(axis=(1, 2))
    on_arc, on_rest = (_unroll(ink, circles, angles, ON_ARC).any(axis=2).mean(axis=1) for angles in (ARC, REST))
    is_clear = beside <= FIT_PARAMETERS.max_clutter
    return np.asarray((on_arc > PARAMETERS.min_arc_ink) & is_clear & (on_rest < PARAMETERS.max_rest_ink))


def _place_swing(circle: Floats, fit: SwingFit, factor: float) -> Swing:
    """The swing of a circle on the sheet before it was resized by the factor."""
    row, col, radius, direction, _ = circle
    angles = np.array([fit.leaf, fit.closed]) * (2 * pi / N_DIRECTIONS) - pi + direction
    hinge = np.array([row, col])
    open_end, jamb = hinge + radius * np.column_stack([np.sin(angles), np.cos(angles)])
    # OpenCV counts from the middle of the first pixel
    hinge, jamb, open_end = ((point + 0.5) / factor for point in (hinge, jamb, open_end))
    return Swing(hinge, jamb, open_end, float(radius) / factor, fit.score)


def _drop_twins(swings: list[Swing]) -> list[Swing]:
    """The best of swings that lie over each other; leaf, arc and door have small swings in their corners."""

    def is_alike(swing: Swing, other: Swing) -> bool:
        return bool(abs(np.log(other.radius / swing.radius)) < PARAMETERS.twin_log_radius)

    best: list[Swing] = []
    for swing in sorted(swings, key=lambda swing: -swing.score):
        if not any(_covers(other, swing) and is_alike(other, swing) for other in best):
            best.append(swing)
    single: list[Swing] = []
    for swing in sorted(best, key=lambda swing: -swing.score * sqrt(swing.radius)):
        if not any(_covers(other, swing) for other in single):
            single.append(swing)
    return single


def _covers(swing: Swing, other: Swing) -> bool:
    return bool(np.hypot(*(swing.middle - other.middle)) <= PARAMETERS.cover_distance * swing.radius)
