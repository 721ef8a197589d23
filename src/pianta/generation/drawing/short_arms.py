"""Arms that lead between other rooms where the way around them is long, and take cells of these."""

from __future__ import annotations

from collections.abc import Collection
from itertools import chain

import cv2
import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.generation.drawing.arms import find_widest_arm
from pianta.generation.drawing.blocks import NARROWEST, NO_ROOM, Cells
from pianta.generation.drawing.losses import find_missing_doors, measure_width

Mask = NDArray[np.bool_]

# All chosen by hand, on generated schools.
WIDEST_ARM = 7  # cells
LONG_ARM = 60  # cells of an arm, from which on one between other rooms is looked for
SHORTER = 0.7  # of the cells of an arm through free space, at most of one between rooms
WIDEST_BETWEEN = 5  # cells of the width of an arm between rooms
TRIES = 6  # of such an arm, each without the rooms that the one before harms
LARGE_ROOM = 60  # cells of a room of which some may be taken
LEFT_SHARE = 0.7  # of such a room
LEFT_WIDTH = 5  # cells of the side of the largest square in it


def find_short_arm(cells: Cells, room: int, goal: int, graph: nx.Graph, corridors: Collection[int]) -> Mask | None:
    """The cells of an arm by which a room touches another one, as wide as the room; None without a way.

    It leads through free space, or, without such a way or if that is long, along walls of large rooms, of which each
    keeps its doors, most of its area, and one part. graph: of the doors. corridors: nothing is taken from them.
    """
    widest = max(NARROWEST, min(measure_width(cells == room), WIDEST_ARM))
    arm = find_widest_arm(cells, room, goal, widest)
    if arm is not None and arm.sum() < LONG_ARM:
        return arm
    large = np.flatnonzero(np.bincount(cells[cells >= 0]) >= LARGE_ROOM).tolist()
    through = {*large} - {*corridors, room, goal}
    for _ in range(TRIES):
        between = find_widest_arm(cells, room, goal, min(widest, WIDEST_BETWEEN), through=through)
        if between is None or (arm is not None and between.sum() > SHORTER * arm.sum()):
            break
        harmed = find_harmed(cells, room, between, graph)
        if not harmed:
            return between
        through -= harmed
    return arm


def find_harmed(cells: Cells, room: int, arm: Mask, graph: nx.Graph) -> set[int]:
    """The rooms that lose a door to an arm of a room, or much of their area, or that fall into parts."""
    after = cells.copy()
    after[arm] = room
    robbed = {*np.unique(cells[arm]).tolist()} - {NO_ROOM}
    lost = {*find_missing_doors(after, graph)} - {*find_missing_doors(cells, graph)}
    return {other for other in robbed if not _is_sound(cells == other, after == other)} | {*chain.from_iterable(lost)}


def _is_sound(before: Mask, left: Mask) -> bool:
    """Whether what is left of a room is most of it, in one part, and wide enough."""
    parts, _ = cv2.connectedComponents(left.view(np.uint8), connectivity=4)
    return bool(left.sum() >= LEFT_SHARE * before.sum() and parts == 2 and measure_width(left) >= LEFT_WIDTH)
