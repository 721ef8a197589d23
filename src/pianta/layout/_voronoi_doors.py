"""Doors of a layout: where the Voronoi diagram of the free space crosses from room to room (thesis, section 3.1)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from shapely import LineString

from pianta._types import Mask
from pianta.floor import Door
from pianta.layout._label_images import Labels, list_contacts, nearest_labels
from pianta.layout._working_grid import WorkingGrid
from pianta.layout.parameters import ThesisParameters

Pixel = tuple[int, int]

# Steps to half of the eight neighbours, so that each pair of pixels is visited once.
HALF_NEIGHBOURS = ((0, 1), (1, -1), (1, 0), (1, 1))
# A pixel of the diagram is equally far from both jambs. If the farther one is more than this many times as far as the
# nearer, both of its nearest obstacles belong to one rough wall, and there is no passage (chosen by hand).
MAX_JAMB_RATIO = 1.5
# The cosine of the angle between the two jambs, seen from the pixel, is at most minus this: about 134° or more (chosen
# by hand).
MIN_OPPOSITE_COSINE = 0.7


def find_doors(working_grid: WorkingGrid, rooms: Labels, parameters: ThesisParameters) -> list[Door]:
    """Doors between rooms, in the map frame.

    rooms: shape (H, W), n ≥ 0 for cells of room n + 1, -1 elsewhere.

    A crossing of the Voronoi diagram and the common edge of two rooms is moved along the diagram to the narrowest
    point nearby, because representative lines run beside walls as often as through them. The door spans from jamb to
    jamb there. Passages wider than door_width are openings.
    """
    reach = parameters.line_distance / working_grid.resolution
    owner = _reassign_cut_off_parts(np.where(working_grid.free, _extend_rooms(rooms, reach), -1))
    clearance = compute_clearance(working_grid.free)
    diagram = draw_voronoi_diagram(working_grid.free)
    doors: dict[tuple[int, int], list[Door]] = {}
    for crossing, pair in sorted(_find_crossings(diagram, owner)):
        narrowest = _walk_to_narrowest(crossing, diagram, clearance, reach)
        jambs = _find_jambs(narrowest, working_grid.free, float(clearance[narrowest]))
        if jambs is None:
            continue
        line = LineString(jambs[:, ::-1] * working_grid.resolution)
        if line.length >= parameters.passage_width:
            door_kind: Literal["door", "opening"] = "door" if line.length <= parameters.door_width else "opening"
            ends = LineString(working_grid.to_map(line))
            doors.setdefault(pair, []).append(Door((pair[0] + 1, pair[1] + 1), ends, line.length, door_kind))
    return [door for pair_doors in doors.values() for door in _drop_repeated(pair_doors)]


def compute_clearance(free: Mask) -> NDArray[np.float32]:
    """Distance transform: cells from each free cell to the nearest other cell, centre to centre; shape (H, W)."""
    distance = cv2.distanceTransform(free.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # The last bit depends on the address of the image in memory. Squared distances between cells are integers, so
    # rounding them makes the result reproducible.
    return np.sqrt(np.rint(np.square(distance, dtype=np.float64))).astype(np.float32)


def draw_voronoi_diagram(free: Mask) -> Mask:
    """The Voronoi diagram of the obstacles on the grid: the one cell wide skeleton of the free space, shape (H, W)."""
    from skimage.morphology import skeletonize

    return np.asarray(skeletonize(free))


def _extend_rooms(rooms: Labels, reach: float) -> Labels:
    """Rooms, extended to cells of no room that are less than reach cells away; shape (H, W)."""
    nearest, distance = nearest_labels(rooms, background=-1)
    return np.where(distance < reach, nearest, -1)


def _reassign_cut_off_parts(owner: Labels) -> Labels:
    """Owners of free cells, shape (H, W), where parts that a wall cuts off from their room go to a room they touch.

    A representative line beside a wall leaves a strip of one room on the side of the other.
    """
    from skimage.measure import label

    parts, count = label(owner, background=-1, connectivity=1, return_num=True)
    owner_of_part = np.full(count + 1, -1, owner.dtype)
    owner_of_part[parts.ravel()] = owner.ravel()
    # Sort the parts by owner and size, so that the largest part of each room comes last.
    by_size = np.lexsort((np.bincount(parts.ravel(), minlength=count + 1), owner_of_part))
    is_main = np.zeros(count + 1, bool)
    is_main[by_size[np.append(np.diff(owner_of_part[by_size]) > 0, True)]] = True
    new_owner = owner_of_part.copy()
    pairs, lengths = list_contacts(parts)
    both_ways, lengths = np.concatenate([pairs, pairs[:, ::-1]]), np.tile(lengths, 2)
    # The longest contact comes last, and overwrites the others.
    for part, neighbour in both_ways[np.lexsort((both_ways[:, 1], both_ways[:, 0], lengths))]:
        if not is_main[part] and is_main[neighbour]:
            new_owner[part] = owner_of_part[neighbour]
    return np.asarray(new_owner[parts])


def _find_crossings(diagram: Mask, owner: Labels) -> Iterator[tuple[Pixel, tuple[int, int]]]:
    """Pixels where the diagram passes from one room to another, and the two rooms, the smaller number first."""
    rows, cols = np.nonzero(diagram)
    for row_step, col_step in HALF_NEIGHBOURS:
        beside_row, beside_col = rows + row_step, cols + col_step
        here, there = owner[rows, cols], owner[beside_row, beside_col]
        crosses = diagram[beside_row, beside_col] & (here != there) & (here >= 0) & (there >= 0)
        for i in np.flatnonzero(crosses):
            yield (int(rows[i]), int(cols[i])), (int(min(here[i], there[i])), int(max(here[i], there[i])))


def _walk_to_narrowest(start: Pixel, diagram: Mask, clearance: NDArray[np.float32], reach: float) -> Pixel:
    """The pixel reached from start by descending along the diagram to less and less clearance, up to reach cells."""
    here = start
    while True:
        row, col = here
        window = np.argwhere(diagram[row - 1 : row + 2, col - 1 : col + 2]) + np.array([row - 1, col - 1])
        narrowest = window[clearance[window[:, 0], window[:, 1]].argmin()]
        following = (int(narrowest[0]), int(narrowest[1]))
        beyond = np.hypot(following[0] - start[0], following[1] - start[1]) > reach
        if beyond or clearance[following] >= clearance[here]:
            return here
        here = following


def _find_jambs(pixel: Pixel, free: Mask, clearance: float) -> NDArray[np.float64] | None:
    """Row, col of the faces of both jambs beside a pixel of the diagram, shape (2, 2), in cells; None if no passage.

    The jambs are the nearest obstacle, and the nearest one roughly opposite.
    """
    reach = int(MAX_JAMB_RATIO * clearance) + 2
    top, left = max(pixel[0] - reach, 0), max(pixel[1] - reach, 0)
    blocked = np.argwhere(~free[top : pixel[0] + reach + 1, left : pixel[1] + reach + 1]) + np.array([top, left])
    steps = blocked - np.array(pixel)
    lengths = np.hypot(*steps.T)
    near = steps[lengths.argmin()]
    opposite = np.flatnonzero(steps @ near <= -MIN_OPPOSITE_COSINE * lengths * lengths.min())
    if not len(opposite) or lengths[opposite].min() > MAX_JAMB_RATIO * clearance + 1:
        return None
    jambs = np.array([near, steps[opposite[lengths[opposite].argmin()]]])
    # An obstacle ends half a cell before its centre.
    faces = jambs * (1 - 0.5 / np.hypot(*jambs.T))[:, None]
    return np.asarray(faces + np.array(pixel) + 0.5)


def _drop_repeated(doors: list[Door]) -> list[Door]:
    """Doors between two rooms, without those nearer to a narrower one than half the width of the wider."""
    distinct: list[Door] = []
    for door in sorted(doors, key=lambda door: (door.width, door.line.coords[0])):
        if all(door.line.distance(other.line) > max(door.width, other.width) / 2 for other in distinct):
            distinct.append(door)
    return distinct
