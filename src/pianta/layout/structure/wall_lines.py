"""Wall lines: the representative lines of a map's walls (thesis section 3.1), with the side that the wall is on."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pianta._types import Floats, Indices, Mask
from pianta.layout.structure.necks import measure_lengths
from pianta.layout.structure.pieces import look_up

# Half the length of contour that gives a place of it its tangent, and the step along a line; metres.
TANGENT, STEP = 0.2, 0.1
# A face is a piece of contour that is straight but for the first, and at least as long as the second; metres.
TOLERANCE, SHORTEST_FACE = 0.1, 0.4
# Contour as near to a line as this, and turned against it by less than this, is on it; metres, degrees.
BAND, ANGLE = 0.15, 15.0
# How far beyond its face a line is fitted, ever further; metres.
REACHES = (0.5, 1.5, 3.0)
# Length of contour on a line, at least; metres.
LEAST_SUPPORT = 0.8
# Where, as shares of its length from its middle, a face is asked on which side its wall is, and how far beside; metres.
ASKED, BESIDE = (-0.3, -0.15, 0.0, 0.15, 0.3), 0.1
# Lines of one wall face: metres apart across and along, and degrees between them, at most.
SAME_ACROSS, SAME_ALONG, SAME_ANGLE = 0.1, 4.0, 3.0


@dataclass(frozen=True, eq=False)
class WallLines:
    """Lines along the faces of walls.

    points: shape (N, 2), a place on each line; row and col, in cells.
    along: shape (N, 2), its direction, of length 1. towards: shape (N, 2), across it, to the side that the wall is on.
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
    """Wall lines of the space where a robot may be, shape (H, W), those of the longest faces first.

    resolution: metres per cell.
    """
    # Straight pieces of the contour are the faces of walls
    faces, tangents = _trace_faces(space, TOLERANCE / resolution, round(TANGENT / resolution))
    faces = faces[measure_lengths(faces) * resolution >= SHORTEST_FACE]
    lengths = measure_lengths(faces)
    points, along = faces.mean(axis=1), (faces[:, 1] - faces[:, 0]) / lengths[:, None]
    # A face is too short to tell its direction: the contour in line with it, ever further away, refines it
    step = max(1, round(STEP / resolution))
    for beyond in REACHES:
        halves = np.minimum(lengths / 2, REACHES[-1] / resolution) + beyond / resolution
        line, steps, cells = _sample_contour(
            tangents, points, along, halves, step=step, band=round(BAND / resolution), angle=ANGLE
        )
        points, along = _fit_lines(points, along, line, cells)
        # A step counts once, however many cells of the contour lie across it
        supports = (
            np.bincount(line[np.flatnonzero(np.diff(steps, prepend=-1))], minlength=len(faces)) * step * resolution
        )
    # The wall is where the space is not
    lines = WallLines(points, along, _face_walls(points, along, lengths, space, max(2, BESIDE / resolution)))
    # What few pieces of contour support is no wall, and one line represents all that lie on each other
    chosen = np.flatnonzero(supports >= LEAST_SUPPORT)
    chosen = chosen[np.argsort(-lengths[chosen], kind="stable")]
    return _drop_doubles(lines.select(chosen), resolution)


def span_walls(lines: WallLines, space: Mask, *, reach: float, gap: float, resolution: float) -> Floats:
    """Each wall line from where its wall begins to where it ends, shape (N, 2, 2): end, then row and col.

    A wall has space before it and none behind it; it goes on after gaps, which may be doors, up to a width. A line that
    is more gap than wall, or has no length, is left out.
    space: shape (H, W). reach: how far it is followed both ways. gap, reach, resolution: metres.
    """
    step = max(1, round(STEP / resolution))
    most = int(reach / resolution) // step * step
    distances = np.arange(-most, most + 1, step)
    places = lines.points[:, None] + lines.along[:, None] * distances[:, None]
    behind, before = places + lines.towards[:, None], places - 2 * lines.towards[:, None]
    walled = ~look_up(space, behind) & look_up(space, before)
    spans = [np.zeros((0, 2, 2))]
    for i, wall in enumerate(walled):
        seen = distances[wall]
        if len(seen):
            stretches = np.split(seen, np.flatnonzero(np.diff(seen) * resolution > gap) + 1)
            nearest = min(stretches, key=lambda stretch: np.abs(stretch).min())
            # A single place is no line, and what is less wall than gaps only passes by obstacles.
            if len(nearest) > 1 and 2 * len(nearest) * step > np.ptp(nearest):
                spans.append((lines.points[i] + np.outer(nearest[[0, -1]], lines.along[i]))[None])
    return np.concatenate(spans)


def _trace_faces(space: Mask, tolerance: float, window: int) -> tuple[Floats, NDArray[np.float32]]:
    """Straight pieces of the contours, shape (N, 2, 2), and the tangent of each contour cell, shape (H, W, 2)."""
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
    """Contour cells on each line, looked for step by step within a half length of its point.

    Returns the line, the step and the row and col of each cell; shapes (C,), (C,) and (C, 2).
    """
    most = int(halves.max(initial=0)) // step * step
    distances = np.arange(-most, most + 1, step)
    line, place = np.nonzero(np.abs(distances) <= halves[:, None])
    middles = points[line] + along[line] * distances[place, None]
    cells = np.rint(middles[:, None] + turn(along)[line, None] * np.arange(-band, band + 1)[:, None])
    agreement = np.abs((look_up(tangents, cells) * along[line, None]).sum(axis=-1))
    steps, across = np.nonzero(agreement > np.cos(np.radians(angle)))
    return line[steps], steps, cells[steps, across]


def _fit_lines(points: Floats, along: Floats, line: Indices, cells: Floats) -> tuple[Floats, Floats]:
    """Lines turned to the principal axis of their cells, each point to the nearest place of it."""

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


def _face_walls(points: Floats, along: Floats, lengths: Floats, space: Mask, beside: float) -> Floats:
    """Direction across each line to the side with less space beside the face."""
    across = turn(along)
    asked = points[:, None] + along[:, None] * (lengths[:, None] * ASKED)[..., None]
    one, other = (look_up(space, asked + side * beside * across[:, None]).sum(axis=1) for side in (1, -1))
    return across * np.where(one <= other, 1, -1)[:, None]


def _drop_doubles(lines: WallLines, resolution: float) -> WallLines:
    """Lines without those that lie on an earlier one."""
    near = KDTree(lines.points).query_pairs(np.hypot(SAME_ALONG, SAME_ACROSS) / resolution, output_type="ndarray")
    earlier, later = near[np.lexsort(near.T)].T if len(near) else np.zeros((2, 0), int)
    steps = (lines.points[earlier] - lines.points[later]) * resolution
    across = [np.abs((steps * turn(lines.along[which])).sum(axis=1)) for which in (earlier, later)]
    along = np.abs((steps * lines.along[later]).sum(axis=1))
    agreement = (lines.towards[earlier] * lines.towards[later]).sum(axis=1)
    same = (np.maximum(*across) < SAME_ACROSS) & (along < SAME_ALONG) & (agreement > np.cos(np.radians(SAME_ANGLE)))
    kept = np.ones(len(lines), bool)
    # Sorted by the later one, so that whether the earlier one stays is known.
    for first, second in zip(earlier[same].tolist(), later[same].tolist(), strict=True):
        kept[second] &= not kept[first]
    return lines.select(kept)


def turn(directions: Floats) -> Floats:
    """Directions, shape (..., 2), turned by 90 degrees."""
    return np.stack([directions[..., 1], -directions[..., 0]], axis=-1)
