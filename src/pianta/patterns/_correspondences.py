"""Correspondences: rooms of storeys that one rigid motion, or one step from row to row, maps onto other rooms.

A motion is a translation, a rotation, a reflection, or a reflection with a translation. As in Mitra, Guibas and Pauly
(ACM Trans. Graph. 25, 2006), each pair of rooms that are alike proposes motions; a motion counts with all rooms that it
maps onto others.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely

from pianta._types import Floats, Indices, Mask
from pianta.patterns._room_table import RoomTable, measure_extents, measure_rectangles, move_shapes
from pianta.rooms._outlines import Geometries
from pianta.rooms._shapes import fit_rectangles
from pianta.rooms._surroundings import find_alike

# Least number of rooms of a pattern: one room alone is no sequence; and of one that is rotations by its order alone, as
# two rooms of some sizes often follow each other by chance.
MIN_ROOMS = 2
MIN_ROOMS_IN_ROW = 3
# All were chosen by hand; the unit of a floor is 6.5 m in the median school or office.
# Units: 1 m, by which the centroids of a room and of its image may differ.
MAX_CENTROID_DISTANCE = 0.15
# Least IoU of a moved room with its image; rooms of a row that are half a metre off still have it.
MIN_IOU = 0.7
# A rectangle with a smaller ratio of its sides may also be turned by a quarter.
SQUARE_RATIO = 1.25
# Motions whose rotations differ by less are one.
SAME_ROTATION = np.radians(5)
# Largest difference of the logarithms of frontages, depths and areas of rooms of two rows that correspond.
MAX_LOG_DIFFERENCE_IN_ROWS = 0.2


@dataclass(frozen=True, eq=False)
class Correspondences:
    """m correspondences of n rooms.

    images: the image of each room, -1 without one, shape (m, n). least: the least number of rooms of a pattern that
    each one may justify, shape (m,).
    """

    images: Indices
    least: Indices

    def find_copies(self, rooms: Indices) -> Indices:
        """The images of rooms by the correspondences that have them all, shape (copies, rooms)."""
        copies = self.images[self.least <= len(rooms)][:, rooms]
        return np.unique(copies[(copies >= 0).all(axis=1)], axis=0)


def find_correspondences(table: RoomTable) -> Correspondences:
    """All correspondences of rooms with others: by motions, and by the order of rooms along corridors."""
    matches = [(image, MIN_ROOMS) for image in _find_motions(table)]
    matches += [(image, MIN_ROOMS_IN_ROW) for image in _align_rows(table)]
    own = np.arange(len(table))
    kept_rows = [(*image, least) for image, least in matches if ((image >= 0) & (image != own)).sum() >= least]
    # In one order, whatever the orientation of the floor.
    rows = np.unique(np.array(kept_rows, np.intp).reshape(-1, len(table) + 1), axis=0)
    return Correspondences(rows[:, :-1], rows[:, -1])


def fit_motion(start: Floats, end: Floats, *, mirrored: bool) -> tuple[Floats, Floats]:
    """The motion that takes points nearest to others by least squares: matrix, shape (2, 2), and shift, shape (2,).

    mirrored: whether it reflects. Kabsch, Acta Cryst. A 32, 1976.
    """
    u, _, v = np.linalg.svd((start - start.mean(axis=0)).T @ (end - end.mean(axis=0)))
    sign = -1.0 if mirrored else 1.0
    flip = np.diag([1.0, sign * np.linalg.det(u) * np.linalg.det(v)])
    matrix = (u @ flip @ v).T
    return matrix, end.mean(axis=0) - matrix @ start.mean(axis=0)


def overlap_shapes(one: Geometries, other: Geometries) -> Floats:
    """The IoU of pairs of shapes, shape (n,)."""
    common = shapely.area(shapely.intersection(one, other))
    return np.asarray(common / (shapely.area(one) + shapely.area(other) - common))


def _find_motions(table: RoomTable) -> Iterator[Indices]:
    """The image of each room by every motion that maps at least MIN_ROOMS rooms onto others."""
    alike = find_alike(table.shapes, fit_rectangles(table.shapes)) & _have_one_label(table)
    length, width, direction = measure_rectangles(table.shapes)
    is_square = length < SQUARE_RATIO * width
    rotations: defaultdict[tuple[int, int, bool], list[float]] = defaultdict(list)
    for one, other in np.argwhere(alike).tolist():
        turns = (0, 1, 2, 3) if is_square[one] else (0, 2)
        for mirrored in (False, True):
            # A reflection takes the direction d to r - d.
            between = direction[other] + direction[one] * (1 if mirrored else -1)
            for rotation in (between + turn * np.pi / 2 for turn in turns):
                if any(abs(_wrap(rotation - each)) < SAME_ROTATION for each in rotations[one, other, mirrored]):
                    continue
                matrix = _rotation_matrix(rotation, mirrored=mirrored)
                shift = table.middles[other] - matrix @ table.middles[one]
                image, settled = _settle(table, alike, (matrix, shift), mirrored=mirrored)
                for pair in zip(*_pairs(image), strict=True):
                    rotations[(*pair, mirrored)].append(settled)
                yield image


def _settle(table: RoomTable, alike: Mask, motion: tuple[Floats, Floats], *, mirrored: bool) -> tuple[Indices, float]:
    """The images of all rooms by a motion, after one fit to the rooms that it maps, and its rotation, radians."""
    image = _match(table, alike, motion)
    start, end = _pairs(image)
    if len(start) >= MIN_ROOMS:
        motion = fit_motion(table.middles[start], table.middles[end], mirrored=mirrored)
        image = _match(table, alike, motion)
        start, end = _pairs(image)
    moved = shapely.transform(table.shapes[start], lambda xy: xy @ motion[0].T)
    positions = table.middles[start] @ motion[0].T + motion[1]
    moved = move_shapes(np.asarray(moved, dtype=object).reshape(-1), positions)
    image[start[overlap_shapes(moved, table.outlines(end)) < MIN_IOU]] = -1
    return image, float(np.arctan2(motion[0][1, 0], motion[0][0, 0]))


def _match(table: RoomTable, alike: Mask, motion: tuple[Floats, Floats]) -> Indices:
    """For each room the nearest room that is alike, or itself, at the moved centroid; -1 without one."""
    moved = table.middles @ motion[0].T + motion[1]
    away = np.hypot(*(moved[:, None] - table.middles).transpose(2, 0, 1))
    away[~(alike | np.eye(len(table), dtype=bool))] = np.inf
    nearest = np.argmin(away, axis=1)
    image = np.where(away.min(axis=1) <= MAX_CENTROID_DISTANCE * table.unit, nearest, -1)
    # Of several rooms with one image, the first.
    _, first = np.unique(image, return_index=True)
    unique = np.full(len(image), -1)
    unique[first] = image[first]
    return unique


def _align_rows(table: RoomTable) -> Iterator[Indices]:
    """The images of the rooms of a row in every other place of the same row, or of another, in both directions."""
    extents = [measure_extents(table.shapes[rooms], along) for rooms, along in table.rows]
    log_area = np.log(shapely.area(table.shapes))
    same_label = _have_one_label(table)
    for one, (rooms, _) in enumerate(table.rows):
        for other, (others, _) in enumerate(table.rows):
            sizes, other_sizes = np.log(extents[one]), np.log(extents[other])
            alike = (np.abs(sizes[:, None] - other_sizes) <= MAX_LOG_DIFFERENCE_IN_ROWS).all(axis=2)
            alike &= np.abs(log_area[rooms][:, None] - log_area[others]) <= MAX_LOG_DIFFERENCE_IN_ROWS
            alike &= same_label[np.ix_(rooms, others)] | (rooms[:, None] == others)
            for is_reversed in (False, True):
                matches = alike[:, ::-1] if is_reversed else alike
                targets = others[::-1] if is_reversed else others
                for offset in range(1 - len(rooms), len(others)):
                    if one == other and not is_reversed and offset == 0:
                        continue
                    yield _align(len(table), rooms, targets, matches, offset)


def _align(n: int, rooms: Indices, targets: Indices, alike: Mask, offset: int) -> Indices:
    """The images of n rooms when those of a row are put beside others that begin `offset` rooms later."""
    image = np.full(n, -1)
    steps = np.arange(max(0, -offset), min(len(rooms), len(targets) - offset))
    steps = steps[alike[steps, steps + offset]]
    image[rooms[steps]] = targets[steps + offset]
    return image


def _have_one_label(table: RoomTable) -> Mask:
    """Which rooms have the same label, or not both a label, shape (n, n)."""
    labels = table.labels
    return np.asarray((labels[:, None] == labels) | (labels[:, None] < 0) | (labels < 0))


def _pairs(image: Indices) -> tuple[Indices, Indices]:
    """The rooms with an image, and their images."""
    start = np.flatnonzero(image >= 0)
    return start, image[start]


def _rotation_matrix(angle: float, *, mirrored: bool) -> Floats:
    """The matrix of a rotation; mirrored: after a reflection in the x-axis, which together take d to angle - d."""
    cos, sin = np.cos(angle), np.sin(angle)
    matrix = np.array([[cos, -sin], [sin, cos]])
    return matrix @ np.diag([1.0, -1.0]) if mirrored else matrix


def _wrap(angle: float) -> float:
    """An angle within π of 0."""
    return float((angle + np.pi) % (2 * np.pi) - np.pi)
