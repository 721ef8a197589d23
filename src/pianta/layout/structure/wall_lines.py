"""Wall lines: the representative lines of a map's walls (thesis section 3.1), with the side that the wall is on."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pianta._types import Floats, Indices, Mask
from pianta.layout.structure.necks import measure_lengths
from pianta.layout.structure.regions import sample_image

# The constants of this module were chosen by hand on the maps of the benches (docs/methods/structure.md).
# Length of contour on both sides of a cell that gives its tangent; metres.
TANGENT_REACH = 0.2
# Distance between the samples along a line; metres.
SAMPLE_SPACING = 0.1
# A face is a piece of contour that deviates from a straight line by at most this; metres.
FACE_TOLERANCE = 0.1
# Least length of a face; metres.
MIN_FACE_LENGTH = 0.4
# Contour cells belong to a line if they are at most this far from it; metres.
LINE_BAND = 0.15
# The same for the angle between their tangent and the line; degrees.
LINE_ANGLE = 15.0
# How far beyond the ends of its face a line is fitted, in three rounds; metres.
FIT_REACHES = (0.5, 1.5, 3.0)
# Least length of contour on a line; metres.
MIN_SUPPORT = 0.8
# Positions on a face where the side of its wall is sampled, from its middle; share of its length.
SIDE_POSITIONS = (-0.3, -0.15, 0.0, 0.15, 0.3)
# Distance from the face at which it is sampled; metres.
SIDE_DISTANCE = 0.1
# Two lines are one wall face if they are less than this apart across ...
SAME_ACROSS = 0.1
# ... and along, in metres, ...
SAME_ALONG = 4.0
# ... and have less than this angle between them; degrees.
SAME_ANGLE = 3.0


@dataclass(frozen=True, eq=False)
class WallLines:
    """Lines along the faces of walls.

    points: shape (N, 2), a point on each line; row and col, in cells.
    along: shape (N, 2), unit vector along it. towards: shape (N, 2), unit vector across it, towards the wall.
    """

    points: Floats
    along: Floats
    towards: Floats

    def __len__(self) -> int:
        return len(self.points)

    def select(self, chosen: Mask | Indices) -> WallLines:
        """The lines of a mask, or of indices, shape (N,)."""
        return WallLines(self.points[chosen], self.along[chosen], self.towards[chosen])


def find_wall_lines(space: Mask, *, resolution: float) -> WallLines:
    """Wall lines of the free space, shape (H, W), those of the longest faces first.

    resolution: metres per cell.
    """
    # Straight pieces of the contour are the faces of walls
    faces, tangents = _trace_faces(space, FACE_TOLERANCE / resolution, round(TANGENT_REACH / resolution))
    faces = faces[measure_lengths(faces) * resolution >= MIN_FACE_LENGTH]
    lengths = measure_lengths(faces)
    points, along = faces.mean(axis=1), (faces[:, 1] - faces[:, 0]) / lengths[:, None]
    # A short face has an inaccurate direction: fit the line to the contour along it, further away in each round
    step = max(1, round(SAMPLE_SPACING / resolution))
    for reach in FIT_REACHES:
        halves = np.minimum(lengths / 2, FIT_REACHES[-1] / resolution) + reach / resolution
        line, steps, cells = _sample_contour(
            tangents, points, along, halves, step=step, band=round(LINE_BAND / resolution), angle=LINE_ANGLE
        )
        points, along = _refit_lines(points, along, line, cells)
        # A step counts once, although several contour cells may lie across it
        supports = (
            np.bincount(line[np.flatnonzero(np.diff(steps, prepend=-1))], minlength=len(faces)) * step * resolution
        )
    # The wall is on the side without free space
    lines = WallLines(
        points, along, _find_wall_sides(points, along, lengths, space, max(2, SIDE_DISTANCE / resolution))
    )
    # Drop lines with little contour on them, and all but one of those that lie on each other
    chosen = np.flatnonzero(supports >= MIN_SUPPORT)
    chosen = chosen[np.argsort(-lengths[chosen], kind="stable")]
    return _drop_duplicates(lines.select(chosen), resolution)


def span_walls(lines: WallLines, space: Mask, *, reach: float, gap: float, resolution: float) -> Floats:
    """Each wall line from where its wall begins to where it ends, shape (N, 2, 2): end, then row and col.

    A wall has free space in front of it and none behind it; it continues after gaps up to a width, which may be doors.
    Lines with more gap than wall, or of no length, are left out.
    space: shape (H, W). reach: how far a line is followed both ways. gap, reach, resolution: metres.
    """
    step = max(1, round(SAMPLE_SPACING / resolution))
    steps = int(reach / resolution) // step * step
    distances = np.arange(-steps, steps + 1, step)
    samples = lines.points[:, None] + lines.along[:, None] * distances[:, None]
    behind, before = samples + lines.towards[:, None], samples - 2 * lines.towards[:, None]
    is_wall = ~sample_image(space, behind) & sample_image(space, before)
    spans = [np.zeros((0, 2, 2))]
    for i, wall in enumerate(is_wall):
        wall_distances = distances[wall]
        if len(wall_distances):
            stretches = np.split(wall_distances, np.flatnonzero(np.diff(wall_distances) * resolution > gap) + 1)
            nearest = min(stretches, key=lambda stretch: np.abs(stretch).min())
            # A single sample is no line; a line with less wall than gaps only passes by obstacles.
            if len(nearest) > 1 and 2 * len(nearest) * step > np.ptp(nearest):
                spans.append((lines.points[i] + np.outer(nearest[[0, -1]], lines.along[i]))[None])
    return np.concatenate(spans)


def _trace_faces(space: Mask, tolerance: float, window: int) -> tuple[Floats, NDArray[np.float32]]:
    """Straight pieces of the contours, shape (N, 2, 2), and the unit tangent of each contour cell, shape (H, W, 2).

    tolerance: how far the contour may be from a piece. window: length of contour on both sides of a cell that gives its
    tangent. Both are in cells; rows come before cols.
    """
    window = max(2, window)
    tangents = np.zeros((*space.shape, 2), np.float32)
    faces = [np.zeros((0, 2, 2))]
    for contour in cv2.findContours(space.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)[0]:
        cells = contour[:, 0, ::-1]
        if len(cells) < 2 * window + 2:
            continue
        chords = (np.roll(cells, -window, axis=0) - np.roll(cells, window, axis=0)).astype(np.float32)
        tangents[cells[:, 0], cells[:, 1]] = chords / np.maximum(np.hypot(*chords.T), 1e-6)[:, None]
        corners = cv2.approxPolyDP(contour, tolerance, closed=True)[:, 0, ::-1].astype(float)
        if len(corners) > 1:
            faces.append(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1))
    return np.concatenate(faces), tangents


def _sample_contour(
    tangents: NDArray[np.float32], points: Floats, along: Floats, halves: Floats, *, step: int, band: int, angle: float
) -> tuple[Indices, Indices, Floats]:
    """Contour cells on each line, from samples along it; cells.

    points, along: a point on each line and its unit vector, shape (N, 2). halves: how far from its point a line is
    sampled, shape (N,). step: from one sample to the next. band: how far a contour cell may be from the line. angle:
    between the tangent of a contour cell and the line, at most; degrees.

    Returns the line, the number of the sample, and the row and col of each cell; shapes (C,), (C,) and (C, 2).
    """
    longest = int(halves.max(initial=0)) // step * step
    distances = np.arange(-longest, longest + 1, step)
    line, index = np.nonzero(np.abs(distances) <= halves[:, None])
    middles = points[line] + along[line] * distances[index, None]
    cells = np.rint(middles[:, None] + turn(along)[line, None] * np.arange(-band, band + 1)[:, None])
    agreement = np.abs((sample_image(tangents, cells) * along[line, None]).sum(axis=-1))
    steps, across = np.nonzero(agreement > np.cos(np.radians(angle)))
    return line[steps], steps, cells[steps, across]


def _refit_lines(points: Floats, along: Floats, line: Indices, cells: Floats) -> tuple[Floats, Floats]:
    """Fit each line to its contour cells: it gets their principal axis, and its point is projected onto that.

    points, along: a point on each line and its unit vector, shape (N, 2). line: index of the line of each cell, shape
    (C,). cells: row and col, shape (C, 2). Returns new points and along; lines of less than three cells stay.
    """

    def total(values: Floats) -> Floats:
        return np.asarray(np.bincount(line, values, len(points)), np.float64)

    count = np.bincount(line, minlength=len(points))
    middles = np.column_stack([total(cells[:, 0]), total(cells[:, 1])]) / np.maximum(count, 1)[:, None]
    rows, cols = (cells - middles[line]).T
    angles = np.arctan2(2 * total(rows * cols), total(cols**2 - rows**2)) / 2
    axes = np.column_stack([np.sin(angles), np.cos(angles)])
    axes *= np.where((axes * along).sum(axis=1) < 0, -1, 1)[:, None]
    feet = middles + ((points - middles) * axes).sum(axis=1)[:, None] * axes
    fitted = (count > 2)[:, None]
    return np.where(fitted, feet, points), np.where(fitted, axes, along)


def _find_wall_sides(points: Floats, along: Floats, lengths: Floats, space: Mask, distance: float) -> Floats:
    """Unit vector across each line, towards the side with less free space; shape (N, 2).

    lengths: of the faces. distance: from the face at which free space is looked up. Both are in cells.
    """
    across = turn(along)
    samples = points[:, None] + along[:, None] * (lengths[:, None] * SIDE_POSITIONS)[..., None]
    one, other = (sample_image(space, samples + side * distance * across[:, None]).sum(axis=1) for side in (1, -1))
    return across * np.where(one <= other, 1, -1)[:, None]


def _drop_duplicates(lines: WallLines, resolution: float) -> WallLines:
    """Lines without those that lie on an earlier one."""
    near = KDTree(lines.points).query_pairs(np.hypot(SAME_ALONG, SAME_ACROSS) / resolution, output_type="ndarray")
    earlier, later = near[np.lexsort(near.T)].T if len(near) else np.zeros((2, 0), int)
    steps = (lines.points[earlier] - lines.points[later]) * resolution
    across = [np.abs((steps * turn(lines.along[which])).sum(axis=1)) for which in (earlier, later)]
    along = np.abs((steps * lines.along[later]).sum(axis=1))
    agreement = (lines.towards[earlier] * lines.towards[later]).sum(axis=1)
    same = (np.maximum(*across) < SAME_ACROSS) & (along < SAME_ALONG) & (agreement > np.cos(np.radians(SAME_ANGLE)))
    selected = np.ones(len(lines), bool)
    # The pairs are sorted by the later line, so the decision about the earlier line is final when it is used.
    for first, second in zip(earlier[same].tolist(), later[same].tolist(), strict=True):
        selected[second] &= not selected[first]
    return lines.select(selected)


def turn(directions: Floats) -> Floats:
    """Directions, shape (..., 2), turned by 90 degrees."""
    return np.stack([directions[..., 1], -directions[..., 0]], axis=-1)
