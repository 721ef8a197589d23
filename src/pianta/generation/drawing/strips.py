"""A spanning tree of rooms as blocks: a corridor is a strip with rows of blocks along both sides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from math import sqrt
from typing import Any

import networkx as nx
import numpy as np

from pianta.generation.drawing.blocks import DOOR_CELLS, Block, Rectangle, make_block, round_randomly
from pianta.generation.drawing.choices import Choices
from pianta.generation.drawing.room_blocks import (
    Areas,
    draw_end_room,
    draw_notched,
    draw_room,
    draw_suite,
    is_small,
    stack_blocks,
)
from pianta.generation.drawing.rows import Row, divide_paths, make_row

# All lengths in cells of 0.5 m, chosen by hand after the schools of the data.
DEPTHS = (9, 24)  # shallowest and deepest row of rooms
CORRIDOR_WIDTHS = (5, 12)  # narrowest and widest corridor
USUAL_WIDTHS = (5.0, 10.0)  # a corridor is longer than its rooms if it would be wider than about this
HALL_WIDTH = 40  # widest room with rooms on both sides
SHORTEST = 4  # corridor
ALLEY = 4  # beside blocks to which another corridor must lead
MAX_BEHIND = 2  # blocks behind a room
MAX_INNER = 3  # rooms at the back of a room; with more it is drawn as a corridor
MAX_CORNERS = 2  # small rooms cut out of a room
CORNER_SHARE = 0.45  # of the room's area, at most
SIDES = (0.9, 1.15)  # depth of a row over the side of a square of a usual room in it
END_AREAS = (20, 130)  # smallest and largest room at the end of a corridor
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
        corridors, rooms = self._choose_ends(room, children, ends, rng)
        sides = [each for each in children if each not in (*corridors, *rooms)]
        rows = self._draw_rows(room, sides, rng)
        wings = [self._draw_block(each, room, sum(DEPTHS) // 2) for each in corridors]
        # Rows go beyond an end of the corridor if it is free, or has a room as wide as the corridor
        after, before = len(wings) < 1, ends == 2 and len(wings) < 2
        row = max(each.length - before * each.before - after * each.after for each in rows)
        width, length = self._choose_size(room, row, rng)
        rectangles = [Rectangle(room, 0, 0, width, length)]
        for each, is_left in zip(rows, (True, False), strict=True):
            first = each.choose_start(length, before=before, after=after, rng=rng)
            for r in (r for block, y in each.blocks for r in block.moved(first + y, 0)):
                corners = (-r.y1, r.x0, -r.y0, r.x1) if is_left else (width + r.y0, r.x0, width + r.y1, r.x1)
                rectangles.append(Rectangle(r.room, *corners))
        blocks = [*wings, *(draw_end_room(each, self.areas[each], width, rng) for each in rooms)]
        for block, is_top in zip(blocks, (True, False), strict=False):
            x = width // 2 - (block.start + block.stop) // 2
            bounds = (DOOR_CELLS - block.stop, width - DOOR_CELLS - block.start)
            for r in block.moved(int(np.clip(x, *bounds)), 0):
                y = (length + r.y0, length + r.y1) if is_top else (-r.y1, -r.y0)
                rectangles.append(Rectangle(r.room, r.x0, y[0], r.x1, y[1]))
        return make_block(rectangles, 0, width)

    def _choose_ends(
        self, room: int, children: Sequence[int], ends: int, rng: np.random.Generator
    ) -> tuple[list[int], list[int]]:
        """The corridors and the rooms at the ends of a corridor, together as many as ends at most."""
        corridors = [each for each in children if each in self.corridors and not self._is_leaf(each)]
        rng.shuffle(corridors)
        corridors = corridors[: int(rng.integers(0, ends + 1)) if len(children) > MAX_BEHIND else ends]
        if room not in self.corridors or len(children) - len(corridors) <= MAX_BEHIND:
            return corridors, []
        siblings = self.graph.subgraph(children)
        least, most = END_AREAS
        rooms = [
            each
            for each in children
            if self._is_leaf(each) and siblings.degree[each] == 0 and least <= self.areas[each] <= most
        ]
        rng.shuffle(rooms)
        return corridors, rooms[: int(rng.integers(0, ends - len(corridors) + 1))]

    def _draw_rows(self, room: int, children: Sequence[int], rng: np.random.Generator) -> list[Row]:
        """The rows on both sides of a corridor, each of a depth that fits its rooms."""
        depth = self._choose_depth(children, rng)
        wings = {each: self._draw_block(each, room, depth) for each in children if not self._is_leaf(each)}

        def measure(each: int) -> float:
            return wings[each].width if each in wings else sqrt(self.areas[each])

        rows = []
        for paths in divide_paths(self._find_paths(children, rng), measure, self.areas.__getitem__, rng):
            depth = self._choose_depth([each for path in paths for each in path], rng)
            groups = self._group_blocks(paths, wings, depth, rng)
            rows.append(self._make_row(groups, children, depth, rng))
        return rows

    def _choose_depth(self, children: Sequence[int], rng: np.random.Generator) -> int:
        """The depth of the rows of rooms: about the side of a square of the room in which half of their area ends."""
        leaves = sorted(self.areas[each] for each in children if self._is_leaf(each))
        if not leaves:
            return sum(DEPTHS) // 2
        half = sum(leaves) / 2
        middle = next(area for area, total in zip(leaves, accumulate(leaves), strict=True) if total >= half)
        depth = round_randomly(sqrt(middle) * rng.uniform(*SIDES), rng)
        return min(max(depth, DEPTHS[0]), DEPTHS[1])

    def _choose_size(self, room: int, row: int, rng: np.random.Generator) -> tuple[int, int]:
        """Width and length of a corridor of its area, which is as long as its longer row of rooms at least."""
        area, is_corridor = self.areas[room], room in self.corridors
        length = max(row, SHORTEST)
        usual = rng.uniform(*USUAL_WIDTHS) if is_corridor else max(6.0, sqrt(area / 1.5))
        length = max(length, min(round_randomly(area / usual, rng), int(1.5 * length) + 12))
        if is_corridor and room in self.joined:
            length = max(length, row + ALLEY)
        widest = CORRIDOR_WIDTHS[1] if is_corridor else HALL_WIDTH
        return min(max(round_randomly(area / length, rng), CORRIDOR_WIDTHS[0]), widest), length

    def _group_blocks(
        self, groups: Sequence[Sequence[int]], wings: Mapping[int, Block], depth: int, rng: np.random.Generator
    ) -> list[list[Block]]:
        """The blocks of the rooms in a row; those with a door between them side by side, as a group.

        wings: the blocks of rooms with others behind them.
        """
        corners = self._choose_corners(groups, depth, rng)
        cut_out = {small for smalls in corners.values() for small in smalls}
        blocks = []
        for group in groups:
            if group[0] in cut_out:
                continue
            blocks.append([wings.get(each) or self._draw_in_row(each, corners.get(each), depth) for each in group])
        return blocks

    def _draw_in_row(self, room: int, corners: Sequence[int] | None, depth: int) -> Block:
        """The block of a room in a row, and of small rooms that are cut out of its corners."""
        rng = self.choices.make_rng(room)
        if corners:
            return draw_notched(room, corners, self.areas, depth, rng)
        return draw_room(room, self.areas[room], depth, rng)

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

    def _make_row(self, groups: list[list[Block]], rooms: Sequence[int], depth: int, rng: np.random.Generator) -> Row:
        """The blocks of a side with their positions; wings are at one of its ends."""
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
        return make_row(row, y, frozenset(rooms))
