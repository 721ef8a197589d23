"""Doors of a layout: where the Voronoi diagram of the free space crosses from room to room (section 3.1)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from shapely import LineString

from pianta._types import Mask
from pianta.floor import Door
from pianta.layout._canvas import Canvas
from pianta.layout.parameters import ThesisParameters

Pixel = tuple[int, int]

# Half of the eight neighbours, so that each pair of pixels is looked at once.
HALF_NEIGHBOURS = ((0, 1), (1, -1), (1, 0), (1, 1))
# A pixel of the diagram is as far from one jamb as from the other. Where it is this many times as far, both of its
# nearest obstacles belong to one rough wall, and there is no passage between them.
LOPSIDED = 1.5
# Cosine of the angle by which two jambs may miss lying exactly opposite.
OPPOSITE = 0.7


def find_doors(canvas: Canvas, rooms: NDArray[np.integer], parameters: ThesisParameters) -> list[Door]:
    """Doors between rooms, in the map frame.

    rooms: shape (H, W), n ≥ 0 for cells of room n + 1, -1 elsewhere.

    A crossing of the Voronoi diagram and the common edge of two rooms is moved along the diagram to the narrowest
    place nearby, because representative lines run beside walls as often as through them. The door spans that place
    from jamb to jamb. Passages wider than door_width are openings.
    """
    owner = _extend_rooms(rooms, parameters.line_distance / canvas.resolution)
    owner = _join_cut_off_parts(np.where(canvas.free, owner, -1))
    clearance = compute_clearance(canvas.free)
    diagram = draw_voronoi_diagram(canvas.free)
    reach = parameters.line_distance / canvas.resolution
    found: dict[tuple[int, int], list[Door]] = {}
    for crossing, pair in sorted(_find_crossings(diagram, owner)):
        narrowest = _walk_to_narrowest(crossing, diagram, clearance, reach)
        jambs = _find_jambs(narrowest, canvas.free, float(clearance[narrowest]))
        if jambs is None:
            continue
        line = LineString(jambs[:, ::-1] * canvas.resolution)
        if line.length >= parameters.passage_width:
            kind: Literal["door", "opening"] = "door" if line.length <= parameters.door_width else "opening"
            door = Door((pair[0] + 1, pair[1] + 1), LineString(canvas.to_map(line)), line.length, kind)
            found.setdefault(pair, []).append(door)
    return [door for doors in found.values() for door in _drop_repeated(doors)]


def compute_clearance(free: Mask) -> NDArray[np.float32]:
    """Distance transform: cells from each free cell to the nearest other cell, centre to centre; shape (H, W)."""
    distance = cv2.distanceTransform(free.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # Its last bit depends on where the image lies in memory; squares of distances between cells are whole.
    return np.sqrt(np.rint(np.square(distance, dtype=np.float64))).astype(np.float32)


def draw_voronoi_diagram(free: Mask) -> Mask:
    """The Voronoi diagram of the obstacles on the grid: the one cell wide skeleton of the free space, shape (H, W)."""
    from skimage.morphology import skeletonize

    return np.asarray(skeletonize(free))


def _extend_rooms(rooms: NDArray[np.integer], reach: float) -> NDArray[np.integer]:
    """Rooms, extended to the cells in no room that are less than reach cells away; shape (H, W)."""
    nobody = rooms < 0
    distance, nearest = cv2.distanceTransformWithLabels(
        nobody.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    room_of_label = np.full(nearest.max() + 1, -1, rooms.dtype)
    room_of_label[nearest[~nobody]] = rooms[~nobody]
    return np.where(distance < reach, room_of_label[nearest], -1)


def _join_cut_off_parts(owner: NDArray[np.integer]) -> NDArray[np.integer]:
    """Owners of free cells, shape (H, W), where parts that a wall cuts off from their room go to the room they touch.

    A representative line beside a wall leaves a strip of one room to the other.
    """
    from skimage.measure import label

    parts, count = label(owner, background=-1, connectivity=1, return_num=True)
    owner_of_part = np.full(count + 1, -1, owner.dtype)
    owner_of_part[parts.ravel()] = owner.ravel()
    # The largest part of each room comes last among its own.
    by_size = np.lexsort((np.bincount(parts.ravel(), minlength=count + 1), owner_of_part))
    is_main = np.zeros(count + 1, bool)
    is_main[by_size[np.append(np.diff(owner_of_part[by_size]) > 0, True)]] = True
    joined = owner_of_part.copy()
    for part, neighbour in _list_contacts(parts):
        if not is_main[part] and is_main[neighbour]:
            joined[part] = owner_of_part[neighbour]
    return np.asarray(joined[parts])


def _list_contacts(parts: NDArray[np.integer]) -> NDArray[np.integer]:
    """Pairs of parts that touch by an edge, both ways round, the longest contact last; shape (N, 2). Part 0 is none."""
    below = np.column_stack([parts[:-1].ravel(), parts[1:].ravel()])
    beside = np.column_stack([parts[:, :-1].ravel(), parts[:, 1:].ravel()])
    pairs = np.concatenate([below, beside])
    pairs = pairs[(pairs[:, 0] != pairs[:, 1]) & (pairs > 0).all(axis=1)]
    contacts, lengths = np.unique(np.concatenate([pairs, pairs[:, ::-1]]), axis=0, return_counts=True)
    return np.asarray(contacts[np.argsort(lengths, kind="stable")])


def _find_crossings(diagram: Mask, owner: NDArray[np.integer]) -> Iterator[tuple[Pixel, tuple[int, int]]]:
    """Pixels where the diagram passes from one room to another, and the two rooms, the smaller number first."""
    rows, cols = np.nonzero(diagram)
    for row_step, col_step in HALF_NEIGHBOURS:
        beside_row, beside_col = rows + row_step, cols + col_step
        here, there = owner[rows, cols], owner[beside_row, beside_col]
        crosses = diagram[beside_row, beside_col] & (here != there) & (here >= 0) & (there >= 0)
        for i in np.flatnonzero(crosses):
            yield (int(rows[i]), int(cols[i])), (int(min(here[i], there[i])), int(max(here[i], there[i])))


def _walk_to_narrowest(start: Pixel, diagram: Mask, clearance: NDArray[np.float32], reach: float) -> Pixel:
    """The pixel that is reached from start by going along the diagram to ever less clearance, up to reach cells."""
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
    """Row, col of the faces of both jambs beside a pixel of the diagram, shape (2, 2), in cells; None for no passage.

    The jambs are the nearest obstacle, and the nearest one that lies roughly opposite.
    """
    reach = int(LOPSIDED * clearance) + 2
    top, left = max(pixel[0] - reach, 0), max(pixel[1] - reach, 0)
    blocked = np.argwhere(~free[top : pixel[0] + reach + 1, left : pixel[1] + reach + 1]) + np.array([top, left])
    steps = blocked - np.array(pixel)
    lengths = np.hypot(*steps.T)
    near = steps[lengths.argmin()]
    opposite = np.flatnonzero(steps @ near <= -OPPOSITE * lengths * lengths.min())
    if not len(opposite) or lengths[opposite].min() > LOPSIDED * clearance + 1:
        return None
    jambs = np.array([near, steps[opposite[lengths[opposite].argmin()]]])
    # An obstacle ends half a cell before its centre.
    faces = jambs * (1 - 0.5 / np.hypot(*jambs.T))[:, None]
    return np.asarray(faces + np.array(pixel) + 0.5)


def _drop_repeated(doors: list[Door]) -> list[Door]:
    """Doors of one pair of rooms, without those nearer to a narrower one than the width of the two."""
    kept: list[Door] = []
    for door in sorted(doors, key=lambda door: (door.width, door.line.coords[0])):
        if all(door.line.distance(other.line) > max(door.width, other.width) / 2 for other in kept):
            kept.append(door)
    return kept
