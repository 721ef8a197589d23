"""Blocks of a room and of the few rooms that are reached through it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import sqrt

import numpy as np

from pianta.generation.drawing.blocks import DOOR_CELLS, NARROWEST, Block, Rectangle, make_block, round_randomly

# All chosen by hand. A room that would be narrower than this, in cells, or deeper than this times its width, is small:
# it has a shape of its own instead of the depth of its row.
SMALL_WIDTH = 4
SMALL_RATIO = 3.2
# Width of a room over the depth of its row from which it becomes deeper than the row.
LARGE_RATIO = 2.2
LARGE_SHAPE = 1.6  # width over depth of such a room
MAX_STRIPS = 2  # beside a room
STRIP_RATIO = 3.5  # depth over width of a strip of one room, at most
SMALL_SHAPES = (1.2, 2.4)  # depth over width of a small room
FRONT = 4  # cells: depth of a room in front of rooms at its back, and its least width

Areas = Mapping[int, float]


def is_small(area: float, depth: int) -> bool:
    """Whether a room, of an area in cells, is too narrow in a row of a depth."""
    return area / depth < SMALL_WIDTH or depth > SMALL_RATIO * area / depth


def draw_room(room: int, area: float, depth: int, rng: np.random.Generator) -> Block:
    """A rectangular room in a row of a depth."""
    width = area / depth
    if is_small(area, depth):
        columns = max(NARROWEST, round_randomly(sqrt(area / rng.uniform(*SMALL_SHAPES)), rng))
        rows = max(NARROWEST, round_randomly(area / columns, rng))
    elif width > LARGE_RATIO * depth:
        rows = max(depth, round_randomly(sqrt(area / LARGE_SHAPE), rng))
        columns = round_randomly(area / rows, rng)
    else:
        columns, rows = round(width), depth
    return Block((Rectangle(room, 0, 0, columns, rows),), 0, columns)


def draw_end_room(room: int, area: float, width: int, rng: np.random.Generator) -> Block:
    """A room as wide as the corridor at whose end it is."""
    rows = max(NARROWEST, round_randomly(area / width, rng))
    return Block((Rectangle(room, 0, 0, width, rows),), 0, width)


def draw_suite(
    room: int,
    inner: Sequence[int],
    areas: Areas,
    depth: int,
    rng: np.random.Generator,
    *,
    front: int | None = None,
) -> Block:
    """A room with rooms in strips beside it, and with those that are too small for this at its back; a rectangle.

    inner: rooms that are reached through the room. front: a small room that is reached as the room is, in a strip in
    front of one of the inner rooms.
    """
    total = sum(areas[each] for each in (room, *inner, *([] if front is None else [front])))
    if total < depth**2 / 1.5:
        depth = max(NARROWEST + FRONT, round_randomly(sqrt(total), rng))
    elif total > LARGE_RATIO * depth**2:
        depth = round_randomly(sqrt(total / 1.5), rng)
    strips, back = _draw_strips(inner, front, areas, depth, rng)
    rectangles = [each for strip in strips[:1] for each in strip]
    start = max((each.x1 for each in rectangles), default=0)
    rectangles += [each.moved(start, 0) for each in _draw_with_back(room, back, areas, depth, rng)]
    stop = max(each.x1 for each in rectangles)
    rectangles += [each.moved(stop, 0) for strip in strips[1:] for each in strip]
    return Block(tuple(rectangles), start, stop)


def _draw_strips(
    inner: Sequence[int], front: int | None, areas: Areas, depth: int, rng: np.random.Generator
) -> tuple[list[list[Rectangle]], list[int]]:
    """At most two strips of a depth, of one room or two behind each other; and the inner rooms that are in none."""
    left = [*inner]
    groups: list[tuple[int, ...]] = [] if front is None else [(front, left.pop())]
    while left and len(groups) < MAX_STRIPS:
        groups.append((left.pop(), left.pop()) if len(left) > 1 else (left.pop(),))
    strips = []
    for group in groups:
        width = max(NARROWEST, round_randomly(sum(areas[each] for each in group) / depth, rng))
        if len(group) == 1 and depth > STRIP_RATIO * width:
            left += group
            continue
        first_depth = round_randomly(areas[group[0]] / width, rng)
        height = depth if len(group) == 1 else int(np.clip(first_depth, NARROWEST, depth - NARROWEST))
        bounds = zip(group, (0, height), (height, depth), strict=False)
        strips.append([Rectangle(each, 0, first, width, last) for each, first, last in bounds])
    return strips, left


def _draw_with_back(
    room: int, back: Sequence[int], areas: Areas, depth: int, rng: np.random.Generator
) -> list[Rectangle]:
    """A room with rooms along its back wall, together a rectangle."""
    total = areas[room] + sum(areas[each] for each in back)
    sizes = [(each, *_fit_inner(areas[each], depth, rng)) for each in back]
    spare = max(round_randomly(total / depth, rng), FRONT) - sum(width for _, width, _ in sizes)
    gaps = [0] * (len(sizes) + 1)
    gaps[rng.integers(len(gaps))] = max(0, spare)
    rectangles, x = [], 0
    for gap, (each, width, height) in zip(gaps, sizes, strict=False):
        if gap:
            rectangles.append(Rectangle(room, x, 0, x + gap, depth))
        x += gap
        rectangles.append(Rectangle(room, x, 0, x + width, depth - height))
        rectangles.append(Rectangle(each, x, depth - height, x + width, depth))
        x += width
    if gaps[-1]:
        rectangles.append(Rectangle(room, x, 0, x + gaps[-1], depth))
    return rectangles


def stack_blocks(room: Block, behind: Sequence[Block]) -> Block:
    """A rectangular room with one block or two behind its back wall."""
    ((number, _, _, width, height),) = room.rectangles
    if len(behind) == 1:
        (block,) = behind
        low, high = sorted((DOOR_CELLS - block.stop, width - DOOR_CELLS - block.start))
        x = int(np.clip((width - block.start - block.stop) // 2, low, high))
        return make_block([Rectangle(number, 0, 0, width, height), *block.moved(x, height)], 0, width)
    left, right = behind
    # The sides with the doors face each other
    left = left if left.width - left.stop <= left.start else left.mirrored()
    right = right if right.start <= right.width - right.stop else right.mirrored()
    before, after = left.width - left.stop + DOOR_CELLS, right.start + DOOR_CELLS
    if before + after > width:
        height = max(FRONT, round(width * height / (before + after)))
        width = before + after
    middle = max(before, min(width // 2, width - after))
    rectangles = [*left.moved(middle - left.width, height), *right.moved(middle, height)]
    return make_block([Rectangle(number, 0, 0, width, height), *rectangles], 0, width)


def _fit_inner(area: float, depth: int, rng: np.random.Generator) -> tuple[int, int]:
    """Columns and rows of a room at the back of another one in a row of a depth, which leave space in front of it."""
    rows = int(np.clip(round_randomly(sqrt(area), rng), NARROWEST, depth - FRONT))
    return max(NARROWEST, round_randomly(area / rows, rng)), rows
