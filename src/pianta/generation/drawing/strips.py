"""A spanning tree of rooms as blocks: a corridor is a strip with the blocks of its rooms along both sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import sqrt
from typing import Any

import networkx as nx
import numpy as np

from pianta.generation.drawing.blocks import DOOR_CELLS, Block, Rectangle, make_block, round_randomly
from pianta.generation.drawing.choices import Choices
from pianta.generation.drawing.room_blocks import (
    Areas,
    draw_notched,
    draw_room,
    draw_suite,
    is_small,
    stack_blocks,
)

# All lengths in cells of 0.5 m, chosen by hand after the schools of the data.
DEPTHS = (9, 18)  # shallowest and deepest row of rooms
CORRIDOR_WIDTHS = (3, 9)  # narrowest and widest corridor
USUAL_WIDTHS = (4.5, 7.0)  # a corridor is longer than its rooms if it would be wider than about this
HALL_WIDTH = 40  # widest room with rooms on both sides
SHORTEST = 4  # corridor
ALLEY = 4  # beside blocks to which another corridor must lead
MAX_BEHIND = 2  # blocks behind a room
MAX_INNER = 3  # rooms at the back of a room; with more it is drawn as a corridor
MAX_CORNERS = 2  # small rooms cut out of a room
CORNER_SHARE = 0.45  # of the room's area, at most
WING_RATIO = 1.6  # a block that is higher than this times the depth of the row is a wing


@dataclass(eq=False)
class TreeLayout:
    """Draws a spanning tree of a graph.

    graph: connected; nodes are integers. areas: of each room, in cells. corridors: nodes. choices: of the tree, and of
    what is random at each room.
    """

    graph: nx.Graph
    areas: Areas
    corridors: frozenset[Any]
    choices: Choices
    tree: nx.Graph = field(init=False)
    joined: set[int] = field(init=False)

    def __post_init__(self) -> None:
        self.tree = self.choices.find_tree(self.graph, self.corridors)
        # Rooms with edges outside the tree
        self.joined = {node for edge in self.graph.edges if not self.tree.has_edge(*edge) for node in edge}

    def draw(self) -> Block:
        """The block of all rooms."""
        return self._draw_strip(self.choices.root, None, ends=2)

    def _list_children(self, room: int, parent: int | None) -> list[int]:
        return [each for each in self.tree[room] if each != parent]

    def _is_leaf(self, room: int) -> bool:
        return len(self.tree[room]) == 1

    def _draw_block(self, room: int, parent: int, depth: int) -> Block:
        children, rng = self._list_children(room, parent), self.choices.make_rng(room)
        if not children:
            return draw_room(room, self.areas[room], depth, rng)
        if room not in self.corridors:
            if len(children) <= MAX_INNER and all(map(self._is_leaf, children)):
                rng.shuffle(children)
                return draw_suite(room, children, self.areas, depth, rng)
            if len(children) <= MAX_BEHIND:
                rng.shuffle(children)
                behind = [self._draw_block(child, room, depth) for child in children]
                return stack_blocks(draw_room(room, self.areas[room], depth, rng), behind)
        return self._draw_strip(room, parent, ends=1)

    def _draw_strip(self, room: int, parent: int | None, *, ends: int) -> Block:
        """A corridor along y, with blocks on both sides and at its ends."""
        children, rng = self._list_children(room, parent), self.choices.make_rng(room)
        depth = self._choose_depth(children, rng)
        corridors = [each for each in children if each in self.corridors and not self._is_leaf(each)]
        rng.shuffle(corridors)
        at_ends = corridors[: int(rng.integers(0, ends + 1)) if len(children) > MAX_BEHIND else ends]
        groups = self._group_blocks(room, [each for each in children if each not in at_ends], depth, rng)
        sides = [self._make_row(groups_of_side, depth, rng) for groups_of_side in self._balance(groups, rng)]
        width, length = self._choose_size(room, max(end for _, end in sides), rng)
        rectangles = [Rectangle(room, 0, 0, width, length)]
        for (row, end), is_left in zip(sides, (True, False), strict=True):
            first = int(rng.choice((0, length - end)))
            for block, y in row:
                for r in block.moved(first + y, 0):
                    corners = (-r.y1, r.x0, -r.y0, r.x1) if is_left else (width + r.y0, r.x0, width + r.y1, r.x1)
                    rectangles.append(Rectangle(r.room, *corners))
        for each, is_top in zip(at_ends, (True, False), strict=False):
            block = self._draw_block(each, room, depth)
            x = width // 2 - (block.start + block.stop) // 2
            bounds = (DOOR_CELLS - block.stop, width - DOOR_CELLS - block.start)
            for r in block.moved(int(np.clip(x, *bounds)), 0):
                rows = (length + r.y0, length + r.y1) if is_top else (-r.y1, -r.y0)
                rectangles.append(Rectangle(r.room, r.x0, rows[0], r.x1, rows[1]))
        return make_block(rectangles, 0, width)

    def _choose_depth(self, children: Sequence[int], rng: np.random.Generator) -> int:
        """The depth of the rows of rooms: somewhat more than their usual width."""
        leaves = [self.areas[each] for each in children if self._is_leaf(each)]
        side = sqrt(1.1 * float(np.median(leaves))) if leaves else sum(DEPTHS) / 2
        return int(np.clip(round_randomly(side * rng.uniform(0.8, 1.2), rng), *DEPTHS))

    def _choose_size(self, room: int, row: int, rng: np.random.Generator) -> tuple[int, int]:
        """Width and length of a corridor of its area, which is as long as its longer row of rooms at least."""
        area, is_corridor = self.areas[room], room in self.corridors
        length = max(row, SHORTEST)
        usual = rng.uniform(*USUAL_WIDTHS) if is_corridor else max(6.0, sqrt(area / 1.5))
        length = max(length, min(round_randomly(area / usual, rng), int(1.5 * length) + 12))
        if is_corridor and room in self.joined:
            length = max(length, row + ALLEY)
        widest = CORRIDOR_WIDTHS[1] if is_corridor else HALL_WIDTH
        return int(np.clip(round_randomly(area / length, rng), CORRIDOR_WIDTHS[0], widest)), length

    def _group_blocks(
        self, room: int, children: Sequence[int], depth: int, rng: np.random.Generator
    ) -> list[list[Block]]:
        """The blocks of the rooms at a corridor; those with a door between them side by side, as a group."""
        groups = self._find_paths(children, rng)
        corners = self._choose_corners(groups, depth, rng)
        cut_out = {small for smalls in corners.values() for small in smalls}
        blocks = []
        for group in groups:
            if group[0] in cut_out:
                continue
            blocks.append(
                [
                    draw_notched(each, corners[each], self.areas, depth, self.choices.make_rng(each))
                    if corners.get(each)
                    else self._draw_block(each, room, depth)
                    for each in group
                ]
            )
        return blocks

    def _find_paths(self, rooms: Sequence[int], rng: np.random.Generator) -> list[list[int]]:
        """The rooms in an order in which many with a door between them follow each other."""
        between = self.graph.subgraph(rooms)
        paths = []
        for component in sorted(map(sorted, nx.connected_components(between))):
            path: list[int] = []
            left = set(component)
            while left:
                following = [room for room in between[path[-1]] if room in left] if path else []
                ranks = {
                    room: (sum(each in left for each in between[room]), rng.random())
                    for room in sorted(following or left)
                }
                path.append(min(ranks, key=ranks.__getitem__))
                left.remove(path[-1])
            paths.append(path)
        return paths

    def _choose_corners(
        self, groups: Sequence[Sequence[int]], depth: int, rng: np.random.Generator
    ) -> dict[int, list[int]]:
        """Which small rooms are cut out of which larger room beside them; none to which arms must lead."""
        leaves = {room for group in groups for room in group if self._is_leaf(room)}
        smalls = [
            group[0]
            for group in groups
            if len(group) == 1 and group[0] in leaves - self.joined and is_small(self.areas[group[0]], depth)
        ]
        hosts = [
            room
            for room in sorted(leaves)
            if not is_small(self.areas[room], depth) and 7 * depth < self.areas[room] < 2 * depth**2
        ]
        rng.shuffle(smalls)
        rng.shuffle(hosts)
        corners: dict[int, list[int]] = {host: [] for host in hosts}
        for small in smalls:
            for host, others in corners.items():
                total = self.areas[small] + sum(self.areas[each] for each in others)
                if len(others) < MAX_CORNERS and total < CORNER_SHARE * self.areas[host]:
                    others.append(small)
                    break
        return corners

    def _balance(
        self, groups: list[list[Block]], rng: np.random.Generator
    ) -> tuple[list[list[Block]], list[list[Block]]]:
        """The groups on two sides of nearly the same length."""
        sides: tuple[list[list[Block]], list[list[Block]]] = ([], [])
        lengths = [0, 0]
        order = rng.permutation(len(groups)).tolist()
        for index in sorted(order, key=lambda index: -sum(block.width for block in groups[index])):
            shorter = int(lengths[1] < lengths[0])
            sides[shorter].append(groups[index])
            lengths[shorter] += sum(block.width for block in groups[index])
        return sides

    def _make_row(
        self, groups: list[list[Block]], depth: int, rng: np.random.Generator
    ) -> tuple[list[tuple[Block, int]], int]:
        """The blocks of a side with their positions, and where the row ends; wings are at one of its ends."""
        order = rng.permutation(len(groups)).tolist()
        order.sort(key=lambda index: max(block.height for block in groups[index]) > WING_RATIO * depth)
        if rng.random() < 1 / 2:
            order.reverse()
        row, y = [], 0
        for index in order:
            group = groups[index] if rng.random() < 1 / 2 else groups[index][::-1]
            for block in group:
                rooms = block.rooms
                gap = ALLEY if self.choices.alleys and len(rooms) > 1 and not self.joined.isdisjoint(rooms) else 0
                row.append((block if rng.random() < 1 / 2 else block.mirrored(), y + gap))
                y += block.width + 2 * gap
        return row, y
