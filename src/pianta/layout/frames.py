"""The motion between the frames of two maps of a building: SLAM begins where the robot stands, and as it stands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats, Mask

Polygons = NDArray[np.object_]

# The constants were chosen by hand.
# Cell size at which outlines are compared; metres.
OUTLINE_CELL = 0.2
# Cells along the longest side, at most; a limit of memory.
MAX_OUTLINE_CELLS = 2000
# Cell size at which all angles are tried; metres.
COARSE_CELL = 0.4
# Angles that are tried if the walls of the two maps have no common direction; radians.
ANGLE_STEP = pi / 90
# Walls have a main direction if the mean of their fourfold directions is this long; 1 if all are at right angles.
CLEAR_DIRECTION = 0.3
# Motions that bring less of the outlines are compared with those of all angles.
GOOD_SHARE = 0.6
# Outlines are straightened by this much, so that the steps of cells in walls at an angle have no directions; metres.
STEP_TOLERANCE = 0.15
# Steps by which an angle is refined, each twice as fine as the one before; the first in radians.
FIRST_STEP = pi / 90
REFINEMENTS = 5
# Points of the outlines this far apart are fitted to the other outlines, as far as these are nearer than a limit, which
# falls from the first to the last round; metres.
FIT_SPACING = 0.1
FIT_LIMITS = (0.6, 0.45, 0.3, 0.3, 0.2, 0.2, 0.2, 0.2)
# Fewer points fit no motion.
MIN_FITTED = 20


@dataclass(frozen=True)
class Motion:
    """A rotation about the origin by an angle, radians, and then a shift, metres."""

    angle: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)

    def apply(self, xy: Floats) -> Floats:
        """Points of shape (N, 2) in the other frame."""
        c, s = cos(self.angle), sin(self.angle)
        return np.asarray(xy @ np.array([[c, s], [-s, c]]) + self.shift)

    def revert(self, xy: Floats) -> Floats:
        """Points of shape (N, 2) of the other frame in the first one."""
        c, s = cos(self.angle), sin(self.angle)
        return np.asarray((xy - np.array(self.shift)) @ np.array([[c, -s], [s, c]]))

    def move(self, polygons: Polygons) -> Polygons:
        """Polygons in the other frame."""
        return np.asarray(shapely.transform(polygons, self.apply), dtype=object)


def find_motion(polygons: Polygons, previous: Polygons) -> tuple[Motion, float]:
    """The motion that brings most of the previous outlines onto the new ones, and the share that it brings.

    The share is that of the shorter outlines, since either map may show more of the building. Outlines locate better
    than areas, which overlap for every motion between two floors. If the walls of both have the same main direction
    after a rotation, only the four rotations of this kind are tried; if either has no main direction, or these bring
    few outlines, all are. The best is fitted to the outlines themselves.
    """
    cell = _choose_cell(polygons, previous, OUTLINE_CELL)
    share, motion = max(_try_angles(polygons, previous, _list_likely_angles(polygons, previous), cell), key=_by_share)
    unclear = min(abs(measure_direction(each)) for each in (polygons, previous)) < CLEAR_DIRECTION
    if unclear or share < GOOD_SHARE:
        coarse = _choose_cell(polygons, previous, COARSE_CELL)
        angles = np.arange(0, 2 * pi, ANGLE_STEP)
        _, rough = max(_try_angles(polygons, previous, angles, coarse), key=_by_share)
        share, motion = max([(share, motion), *_try_angles(polygons, previous, [rough.angle], cell)], key=_by_share)
    step = FIRST_STEP
    for _ in range(REFINEMENTS):
        near = [motion.angle - step, motion.angle + step]
        share, motion = max([(share, motion), *_try_angles(polygons, previous, near, cell)], key=_by_share)
        step /= 2
    fitted = _fit_outlines(polygons, previous, motion)
    return fitted, measure_share(polygons, fitted.move(previous))


def find_shift(polygons: Polygons, previous: Polygons, *, cell: float | None = None) -> tuple[Motion, float]:
    """The shift that brings most of the previous outlines onto the new ones, to one cell; and the share that it brings.

    cell: metres; chosen unless given. The share is as in find_motion.
    """
    cell = _choose_cell(polygons, previous, OUTLINE_CELL) if cell is None else cell
    new, new_low = _draw_outlines(polygons, cell)
    old, old_low = _draw_outlines(previous, cell)
    counts = count_matches(new, old)
    first = new_low - 1 - old_low - (np.array(old.shape) - 1)
    best = np.array(np.unravel_index(counts.argmax(), counts.shape))
    x, y = ((best + first) * cell).tolist()
    return Motion(shift=(x, y)), float(counts.max()) / (2 * min(np.count_nonzero(old), np.count_nonzero(new)))


def measure_share(polygons: Polygons, previous: Polygons) -> float:
    """The share of the outlines that is common without a motion, as in find_motion."""
    cell = _choose_cell(polygons, previous, OUTLINE_CELL)
    new, new_low = _draw_outlines(polygons, cell)
    old, old_low = _draw_outlines(previous, cell)
    rows, cols = (np.argwhere(old) + old_low - new_low + 1).T
    near = _grow(new)
    inside = (rows >= 0) & (cols >= 0) & (rows < near.shape[0]) & (cols < near.shape[1])
    return float(near[rows[inside], cols[inside]].sum() / (2 * min(len(rows), int(np.count_nonzero(new)))))


def count_matches(new: Mask, old: Mask) -> Floats:
    """For every shift of the old cells the count of those on new ones."""
    from scipy.signal import fftconvolve

    # Rounded, because counts are integers.
    return np.asarray(np.rint(fftconvolve(_grow(new), old[::-1, ::-1].astype(float))))


def _grow(cells: Mask) -> Floats:
    """A cell on an outline counts twice and one beside it once, because no wall is measured twice at one position."""
    from scipy.ndimage import binary_dilation

    padded = np.pad(cells, 1)
    return np.asarray(padded.astype(float) + binary_dilation(padded, np.ones((3, 3))))


def _by_share(candidate: tuple[float, Motion]) -> float:
    return candidate[0]


def _try_angles(
    polygons: Polygons, previous: Polygons, angles: Floats | list[float], cell: float
) -> Iterator[tuple[float, Motion]]:
    """The best shift with each angle, and the share of the previous outlines that it brings onto the new ones."""
    for angle in angles:
        motion, share = find_shift(polygons, Motion(float(angle)).move(previous), cell=cell)
        yield share, Motion(float(angle), motion.shift)


def _list_likely_angles(polygons: Polygons, previous: Polygons) -> list[float]:
    """No rotation, and those that bring the main direction of the walls of both to the same one."""
    new, old = (np.angle(measure_direction(each)) / 4 for each in (polygons, previous))
    turn = float(new - old)
    return [0.0, *(turn + quarter * pi / 2 for quarter in range(4))]


def _fit_outlines(polygons: Polygons, previous: Polygons, motion: Motion) -> Motion:
    """The motion fitted by least squares of the distances of previous points to lines of the outlines (ICP)."""
    from scipy.spatial import cKDTree

    starts, ends = _list_segments(polygons)
    lengths = np.hypot(*(ends - starts).T)
    counts = np.ceil(lengths / FIT_SPACING).astype(int)
    segment = np.repeat(np.arange(len(starts)), counts)
    share = (np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts) + 0.5) / counts[segment]
    target = starts[segment] + share[:, None] * (ends - starts)[segment]
    along = ((ends - starts) / lengths[:, None])[segment]
    tree = cKDTree(target)
    points = shapely.get_coordinates(shapely.segmentize(shapely.get_rings(_straighten(previous)), FIT_SPACING))
    for limit in FIT_LIMITS:
        moved = motion.apply(points)
        distance, nearest = tree.query(moved, distance_upper_bound=limit)
        near = distance < limit
        if np.count_nonzero(near) < MIN_FITTED:
            return motion
        here, normal = moved[near], along[nearest[near]][:, ::-1] * [-1, 1]
        middle = here.mean(axis=0)
        lever = here - middle
        # A small rotation by a about the middle moves a point by a times its lever turned by 90°
        columns = np.column_stack([(normal * lever[:, ::-1] * [-1, 1]).sum(axis=1), normal])
        gaps = (normal * (target[nearest[near]] - here)).sum(axis=1)
        angle, x, y = np.linalg.lstsq(columns, gaps, rcond=None)[0]
        step = Motion(float(angle))
        shift = middle + [x, y] + step.apply(np.array(motion.shift)[None] - middle)[0]
        motion = Motion(motion.angle + float(angle), (float(shift[0]), float(shift[1])))
    return motion


def _list_segments(polygons: Polygons) -> tuple[Floats, Floats]:
    """First and last points of the straight lines of outlines, without the steps of cells."""
    rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(_straighten(polygons))]
    return np.concatenate([ring[:-1] for ring in rings]), np.concatenate([ring[1:] for ring in rings])


def _straighten(polygons: Polygons) -> Polygons:
    return np.asarray(shapely.simplify(polygons, STEP_TOLERANCE), dtype=object)


def measure_direction(polygons: Polygons) -> complex:
    """The mean of the fourfold directions of outlines: a quarter of its angle is the main direction."""
    rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(_straighten(polygons))]
    steps = np.concatenate([np.diff(ring, axis=0) for ring in rings])
    # The factor 4 makes directions that differ by a right angle equal; squares give long walls more weight.
    weights = np.hypot(*steps.T) ** 2
    return complex((weights * np.exp(4j * np.arctan2(steps[:, 1], steps[:, 0]))).sum() / weights.sum())


def _choose_cell(polygons: Polygons, previous: Polygons, cell: float) -> float:
    """The size of the cells, metres."""
    return max(cell, *(_measure_extent(each) / MAX_OUTLINE_CELLS for each in (polygons, previous)))


def _measure_extent(polygons: Polygons) -> float:
    """The longer side of the box around all polygons, in their unit."""
    left, bottom, right, top = shapely.total_bounds(polygons)
    return float(max(right - left, top - bottom))


def _draw_outlines(polygons: Polygons, cell: float) -> tuple[Mask, NDArray[np.int64]]:
    """Cells on the outlines, indexed by x and y, and the x, y in whole cells of the first one."""
    import cv2

    rings = [np.rint(shapely.get_coordinates(ring) / cell).astype(np.int64) for ring in shapely.get_rings(polygons)]
    corners = np.concatenate(rings)
    low = corners.min(axis=0)
    image = np.zeros(corners.max(axis=0) - low + 1, np.uint8)
    # OpenCV's x runs along the second axis.
    cv2.polylines(image, [(ring - low)[:, ::-1].astype(np.int32) for ring in rings], isClosed=True, color=1)
    return image.astype(bool), low
