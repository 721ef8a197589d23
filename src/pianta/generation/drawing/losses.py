"""What makes one layout better than another: the less a layout loses, the better."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import reduce
from itertools import chain
from math import ceil, inf
from typing import Any

import cv2
import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.generation.drawing.blocks import DOOR_CELLS, NO_ROOM, Cells, measure_contacts
from pianta.generation.drawing.choices import Edge
from pianta.generation.drawing.programme import Programme
from pianta.generation.drawing.site import Site

Mask = NDArray[np.bool_]
Pixels = NDArray[np.uint8]  # 0 and 1

# What a layout loses, besides its bounding box over its area. All chosen by hand, on drawn schools.
LOSS_BY_LENGTH = 0.3  # for each time that it is as long as wide
LOSS_BY_FACADE = 0.6  # for the length of the facade, over the side of a square of the same area
LOSS_BY_ELONGATION = 0.15  # for each time that corridors are as long as wide, on average
LOSS_BY_DARKNESS = 3.0  # if no room has windows and all need some
LOSS_BY_OPEN_SIDES = 2.0  # if corridors have no wall but the facade
WINDOW_CELLS = 4  # of outer wall, with which a room has windows
COURT_CELLS = 15  # least width of a court with windows to it; narrower gaps are closed
LOSS_BY_OUTSIDE = 60.0  # if nothing is on the site
LOSS_BY_DOOR = 0.3  # for a door that needs an arm
GAP_WIDTH = 5  # cells of arm for each cell of the way between the rooms of such a door
POOL = 2  # side of the blocks of cells of which ways consist
MAX_WAY = 75  # blocks of a way, at most
LOSS_BY_ARM = 6.0  # for arms, over its area
ROOM_FACTOR = 6  # arms of rooms count as often as those of corridors
LOSS_BY_CORNER = 0.05  # for a corner of a room that is no rectangle
LOSS_BY_NECK = 1.0  # for a room that is narrow in a part of it
NECK_SHARE = 0.8  # of the widest square in a room: what is narrower is such a part
NECK_CELLS = 64  # least size of such a part
CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
NEAR = np.ones((5, 5), np.uint8)


def find_missing_doors(cells: Cells, graph: nx.Graph) -> tuple[Edge, ...]:
    """The edges of a graph whose rooms share no wall that is long enough for a door."""
    contacts = measure_contacts(cells)
    return tuple(edge for edge in graph.edges if contacts.get((min(edge), max(edge)), 0) < DOOR_CELLS)


def measure_shape(cells: Cells) -> float:
    """The loss by the bounding box of a building, over its area, and by how elongated it is."""
    rooms = (cells != NO_ROOM).view(np.uint8)
    _, _, width, height = cv2.boundingRect(rooms)
    area = int(np.count_nonzero(rooms))
    return height * width / area + LOSS_BY_LENGTH * max(height, width) / min(height, width)


def measure_form(cells: Cells, programme: Programme) -> float:
    """The loss by all that makes a building unlike real ones."""
    return (
        measure_shape(cells)
        + measure_facade(cells)
        + measure_elongation(cells, programme.corridors)
        + measure_outer_walls(cells, programme.window_needs, programme.corridors)
    )


def measure_facade(cells: Cells) -> float:
    """The loss by the length of the facade, over the side of a square of the same area."""
    rooms = np.pad(cells != NO_ROOM, 1).astype(np.int8)
    sides = np.abs(np.diff(rooms, axis=0)).sum() + np.abs(np.diff(rooms, axis=1)).sum()
    return LOSS_BY_FACADE * float(sides) / float(np.sqrt(rooms.sum()))


def measure_elongation(cells: Cells, corridors: frozenset[object]) -> float:
    """The loss by corridors that are long and narrow, by their bounding boxes."""
    aspects = []
    for corridor in corridors:
        _, _, width, height = cv2.boundingRect((cells == corridor).view(np.uint8))
        aspects.append(max(height, width) / min(height, width))
    return LOSS_BY_ELONGATION * float(np.mean(aspects)) if aspects else 0.0


def measure_outer_walls(cells: Cells, window_needs: Mapping[int, float], corridors: frozenset[Any]) -> float:
    """The loss by rooms without outer wall, by how much each needs windows, and by corridors at the facade.

    Of rooms it is the mean over all, of corridors the share of the facade in the outline of all.
    """
    kernel = np.ones((COURT_CELLS, COURT_CELLS), np.uint8)
    is_open = cv2.morphologyEx((cells == NO_ROOM).view(np.uint8), cv2.MORPH_OPEN, kernel) == 1
    outer, outline = np.zeros((2, len(window_needs)), np.int64)
    for lines, air in ((cells, is_open), (cells.T, is_open.T)):
        for room, beside, other in ((lines[:-1], air[1:], lines[1:]), (lines[1:], air[:-1], lines[:-1])):
            outer += np.bincount(room[(room != NO_ROOM) & beside], minlength=len(outer))
            outline += np.bincount(room[(room != NO_ROOM) & (room != other)], minlength=len(outer))
    needs = np.array([window_needs[room] for room in range(len(outer))])
    own = [*corridors]
    by_darkness = LOSS_BY_DARKNESS * float(needs[outer < WINDOW_CELLS].sum()) / len(needs)
    return by_darkness + LOSS_BY_OPEN_SIDES * float(outer[own].sum() / max(1, outline[own].sum()))


def measure_outside(cells: Cells, site: Site) -> float:
    """The loss by the share of a layout that is not on a site, at the best position."""
    return LOSS_BY_OUTSIDE * site.find_position(cells, pool=POOL).outside / int((cells != NO_ROOM).sum())


def measure_gaps(cells: Cells, missing: Collection[Edge], corridors: frozenset[object], *, below: float = inf) -> float:
    """The loss by arms that a layout will need, for each missing door by the way between its rooms.

    cells: with a margin, through which ways lead around the layout. below: once the loss is not, doors are left out.
    """
    area = int((cells != NO_ROOM).sum())
    free = _pool(cells == NO_ROOM, np.logical_and)
    ways = np.asarray(cv2.erode(free, np.ones((2, 2), np.uint8), anchor=(0, 0), borderValue=0), np.uint8)
    loss = LOSS_BY_DOOR * len(missing)
    for room, others in _group_by_room(missing).items():
        if loss >= below:
            break
        start, *goals = (_dilate(_pool(cells == each, np.logical_or), NEAR) & ways for each in (room, *others))
        for other, way in zip(others, _measure_ways(start, goals, ways), strict=True):
            factor = 1 if room in corridors or other in corridors else ROOM_FACTOR
            loss += LOSS_BY_ARM * factor * GAP_WIDTH * POOL * way / area
    return loss


def _group_by_room(edges: Collection[Edge]) -> dict[int, list[int]]:
    """The other rooms of edges by one of their rooms, that with most edges, so that there are few groups."""
    counts = Counter(chain.from_iterable(edges))
    groups: dict[int, list[int]] = defaultdict(list)
    for edge in edges:
        room, other = sorted(edge, key=lambda each: -counts[each])
        groups[room].append(other)
    return groups


def _dilate(pixels: Pixels, kernel: Pixels) -> Pixels:
    return np.asarray(cv2.dilate(pixels, kernel), np.uint8)


def _pool(mask: Mask, join: Callable[[Mask, Mask], Mask]) -> Pixels:
    """Blocks of cells, of which all or any are in a mask; joined row by row, for speed."""
    rows, columns = (size // POOL * POOL for size in mask.shape)
    lines = reduce(join, (mask[first:rows:POOL, :columns] for first in range(POOL)))
    return reduce(join, (lines[:, first::POOL] for first in range(POOL))).view(np.uint8)


def _measure_ways(start: Pixels, goals: Sequence[Pixels], ways: Pixels) -> list[int]:
    """Blocks of cells of the shortest way from a start to each goal, at most MAX_WAY."""
    lengths = np.ones_like(start)
    reached, count = start, 0
    for _ in range(MAX_WAY):
        # A single goal is reached, or nothing new
        if (len(goals) == 1 and (reached & goals[0]).any()) or count == (count := int(np.count_nonzero(reached))):
            break
        lengths += 1 - reached
        reached = _dilate(reached, CROSS) & ways
    lengths[reached == 0] = MAX_WAY
    return [int(lengths[goal == 1].min(initial=MAX_WAY)) for goal in goals]


def measure_arms(cells: Cells, arms: int, used: int) -> float:
    """The loss by arms, of a number of cells together."""
    return LOSS_BY_DOOR * arms + LOSS_BY_ARM * used / int((cells >= 0).sum())


def measure_corners(cells: Cells) -> float:
    """The loss by corners and narrow parts of rooms."""
    return LOSS_BY_CORNER * count_inner_corners(cells) + LOSS_BY_NECK * count_narrow_rooms(cells)


def count_inner_corners(cells: Cells) -> int:
    """The corners of all rooms with 270° inside: a rectangle has none, a bend one, a crossing four."""
    squares = np.stack([cells[:-1, :-1], cells[:-1, 1:], cells[1:, 1:], cells[1:, :-1]])
    count = 0
    for turn in range(4):
        first, second, third, other = np.roll(squares, turn, axis=0)
        count += int(((first == second) & (second == third) & (first != other) & (first != NO_ROOM)).sum())
    return count


def count_narrow_rooms(cells: Cells) -> int:
    """The rooms with a part that is narrower than the rest: whoever sees them would take it for another room."""
    return sum(_has_narrow_part(cells == room) for room in np.unique(cells[cells != NO_ROOM]))


def measure_width(room: Mask) -> int:
    """Cells of the side of the largest square in a room."""
    cropped, side = _crop(room), 1
    while cv2.erode(cropped, np.ones((side + 1, side + 1), np.uint8), borderValue=0).any():
        side += 1
    return side


def _has_narrow_part(room: Mask) -> bool:
    cropped = _crop(room)
    if cropped[1:-1, 1:-1].all():
        return False
    side = ceil(NECK_SHARE * measure_width(room))
    opened = cv2.morphologyEx(cropped, cv2.MORPH_OPEN, np.ones((side, side), np.uint8), borderValue=0)
    narrow = cropped & (np.asarray(opened) == 0)
    _, _, parts, _ = cv2.connectedComponentsWithStats(narrow, connectivity=4)
    return bool((parts[1:, cv2.CC_STAT_AREA] >= NECK_CELLS).any())


def _crop(room: Mask) -> Pixels:
    """The bounding box of a room, with a cell around it."""
    rows, columns = np.nonzero(room)
    box = room[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    return np.pad(box, 1).astype(np.uint8)
