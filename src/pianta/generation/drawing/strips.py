"""A spanning tree of rooms as blocks: a corridor is a strip with rows of blocks along both sides."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from itertools import accumulate, chain
from math import sqrt
from typing import Any, NamedTuple

import networkx as nx
import numpy as np

from pianta.generation.drawing.blocks import DOOR_CELLS, Block, Rectangle, make_block, round_randomly
from pianta.generation.drawing.choices import Choices, Edge
from pianta.generation.drawing.room_blocks import (
    Areas,
    draw_end_room,
    draw_room,
    draw_suite,
    is_small,
    stack_blocks,
)
from pianta.generation.drawing.rows import Row, divide_paths, make_row

# All lengths in cells of 0.5 m, chosen by hand after the schools of the data.
DEPTHS = (9, 24)  # shallowest and deepest row of rooms
CORRIDOR_WIDTHS = (5, 40)  # narrowest and widest corridor, or room with rooms on both sides
USUAL_WIDTHS = (5.0, 10.0)  # of corridors of which the type has no aspects
SHORTEST = 4  # corridor
ALLEY = 4  # beside blocks to which another corridor must lead
ROOM_ASPECT = 1.5  # of a room with rooms on both sides
MAX_BEHIND = 2  # blocks behind a room
MAX_INNER = 3  # rooms at the back of a room; with more it is drawn as a corridor
END_AREA = 20  # smallest room at the end of a corridor
WIDE_END_AREA = 130  # a larger one is wider than the corridor
ORDERED = 0.7  # of corridors beside which blocks are where their doors outside the tree need them
WING_RATIO = 1.6  # a block that is higher than this times the depth of the row is a wing


# Room, the one that leads to it, depth of its row, and a small room in front of rooms behind it, if any.
BlockKey = tuple[int, int, int, int | None]


class End(NamedTuple):
    """An end of a corridor, and whether the rows on its sides may go beyond it.

    room: what is there, None for nothing or for what leads to the corridor. A corridor is in the middle of the end, and
    no row goes beyond it. A room is as wide as the corridor, or wider; then it begins at the side whose row may go on.
    """

    room: int | None
    left: bool
    right: bool


def find_adjacent_blocks(tree: nx.Graph, root: int, edges: Iterable[Edge]) -> tuple[nx.Graph, set[int]]:
    """The blocks that should be beside each other, and those that should be near the room that leads to them.

    Then rooms with a door outside the tree are near each other. A block has the number of its first room. Of each edge,
    the two blocks that contain its rooms, and to which the same room leads, should be beside each other, and all blocks
    inside these two that contain its rooms should be near what leads to them.
    """
    parents = {child: parent for parent, child in nx.bfs_edges(tree, root)}
    beside, near = nx.Graph(), set()
    for edge in edges:
        ways = []
        for room in edge:
            way = [room]
            while way[-1] in parents:
                way.append(parents[way[-1]])
            ways.append(way[::-1])
        shared = sum(one == other for one, other in zip(*ways, strict=False))
        first, second = (way[shared:] for way in ways)
        if first and second:
            beside.add_edge(first[0], second[0])
        near |= {*first[1:], *second[1:]}
    return beside, near


@dataclass(eq=False)
class TreeLayout:
    """Draws a spanning tree of a graph.

    graph: connected; nodes are integers. areas: of each room, in cells. corridors: nodes. choices: of the tree, and of
    what is random at each room. aspects: of corridors, the longer side over the shorter one, if known. joints: the
    rooms at each room in the spanning tree. joined: the rooms with doors outside it. neighbors, near_parent: by
    `find_adjacent_blocks`. blocks: that were drawn, by the arguments of `_draw_block`.
    """

    graph: nx.Graph
    areas: Areas
    corridors: frozenset[Any]
    choices: Choices
    aspects: Mapping[int, float] = field(default_factory=dict)
    joints: Mapping[int, Sequence[int]] = field(init=False)
    joined: set[int] = field(init=False)
    neighbors: nx.Graph = field(init=False)
    near_parent: set[int] = field(init=False)
    blocks: dict[BlockKey, Block] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        tree = self.choices.find_tree(self.graph, self.corridors)
        self.joints = {room: [*tree.adj[room]] for room in tree}
        outside = [edge for edge in self.graph.edges if not tree.has_edge(*edge)]
        self.joined = {node for edge in outside for node in edge}
        self.neighbors, self.near_parent = find_adjacent_blocks(tree, self.choices.root, outside)

    def change(self, choices: Choices) -> TreeLayout:
        """The layout of other choices; blocks that they leave as they are are not drawn again."""
        if not choices.have_same_tree(self.choices):
            return TreeLayout(self.graph, self.areas, self.corridors, choices, self.aspects)
        changed = {room for room, seed in choices.seeds.items() if seed != self.choices.seeds[room]}
        other = copy(self)
        other.choices = choices
        other.blocks = {
            key: block for key, block in self.blocks.items() if changed.isdisjoint(r.room for r in block.rectangles)
        }
        return other

    def draw(self) -> Block:
        """The block of all rooms."""
        return self._draw_strip(self.choices.root, None, ends=2)

    def _list_children(self, room: int, parent: int | None) -> list[int]:
        return [each for each in self.joints[room] if each != parent]

    def _is_leaf(self, room: int) -> bool:
        return len(self.joints[room]) == 1

    def _is_apart(self, room: int, others: frozenset[int]) -> bool:
        """Whether a room has no door to any of the others."""
        return others.isdisjoint(self.graph.adj[room])

    def _is_suite(self, room: int, parent: int) -> bool:
        """Whether a room leads to few rooms, which lead to nothing else."""
        children = self._list_children(room, parent)
        return room not in self.corridors and 0 < len(children) <= MAX_INNER and all(map(self._is_leaf, children))

    def _draw_block(self, room: int, parent: int, depth: int, front: int | None = None) -> Block:
        """A room with all that is reached through it, drawn once. depth, front: as of BlockKey."""
        key = room, parent, depth, front
        if key not in self.blocks:
            self.blocks[key] = self._draw_new_block(*key)
        return self.blocks[key]

    def _draw_new_block(self, room: int, parent: int, depth: int, front: int | None) -> Block:
        children, rng = self._list_children(room, parent), self.choices.make_rng(room)
        if not children:
            return draw_room(room, self.areas[room], depth, rng)
        if room not in self.corridors:
            if self._is_suite(room, parent):
                rng.shuffle(children)
                return draw_suite(room, children, self.areas, depth, rng, front=front)
            if len(children) <= MAX_BEHIND:
                rng.shuffle(children)
                behind = [self._draw_block(child, room, depth) for child in children]
                return stack_blocks(draw_room(room, self.areas[room], depth, rng), behind)
        return self._draw_strip(room, parent, ends=1)

    def _draw_strip(self, room: int, parent: int | None, *, ends: int) -> Block:
        """A corridor along y, with blocks on both sides and at its ends."""
        children, rng = self._list_children(room, parent), self.choices.make_rng(room)
        top, bottom = self._choose_ends(room, children, ends, rng)
        rows = self._draw_rows(room, children, (bottom, top), rng)
        sides = [*zip(rows, (bottom.left, bottom.right), (top.left, top.right), strict=True)]
        row = max(each.length - before * each.before - after * each.after for each, before, after in sides)
        width, length = self._choose_size(room, row, rng)
        rectangles = [Rectangle(room, 0, 0, width, length)]
        for (each, before, after), is_left in zip(sides, (True, False), strict=True):
            first = each.choose_start(length, before=before, after=after, rng=rng)
            for r in (r for block, y in each.blocks for r in block.moved(first + y, 0)):
                corners = (-r.y1, r.x0, -r.y0, r.x1) if is_left else (width + r.y0, r.x0, width + r.y1, r.x1)
                rectangles.append(Rectangle(r.room, *corners))
        for end, is_top in ((top, True), (bottom, False)):
            for r in self._draw_end(end, room, rows, width):
                y = (length + r.y0, length + r.y1) if is_top else (-r.y1, -r.y0)
                rectangles.append(Rectangle(r.room, r.x0, y[0], r.x1, y[1]))
        return make_block(rectangles, 0, width)

    def _choose_ends(self, room: int, children: Sequence[int], ends: int, rng: np.random.Generator) -> tuple[End, End]:
        """Both ends of a corridor; with `ends` of 1 its parent is at the second one."""
        corridors = [each for each in children if each in self.corridors and not self._is_leaf(each)]
        rng.shuffle(corridors)
        corridors = corridors[: int(rng.integers(0, ends + 1)) if len(children) > MAX_BEHIND else ends]
        chosen = [End(each, left=False, right=False) for each in corridors]
        if room in self.corridors and len(children) - len(corridors) > MAX_BEHIND:
            siblings = frozenset(children)
            rooms = [
                each
                for each in children
                if self._is_leaf(each) and self._is_apart(each, siblings) and self.areas[each] >= END_AREA
            ]
            rng.shuffle(rooms)
            for each in rooms[: int(rng.integers(0, ends - len(corridors) + 1))]:
                is_wide, is_left = self.areas[each] > WIDE_END_AREA, bool(rng.integers(2))
                chosen.append(End(each, left=is_left or not is_wide, right=not (is_left and is_wide)))
        chosen += [End(None, left=True, right=True)] * (ends - len(chosen))
        first, second = (*chosen, End(None, left=False, right=False))[:2]
        return first, second

    def _draw_end(self, end: End, parent: int, rows: Sequence[Row], width: int) -> list[Rectangle]:
        """What is at an end of a corridor of a width, above y = 0."""
        if end.room is None:
            return []
        if end.left and end.right:
            return draw_end_room(end.room, self.areas[end.room], width, self.choices.make_rng(end.room)).moved(0, 0)
        if end.left or end.right:
            block = self._draw_block(end.room, parent, rows[end.right].depth)
            return block.moved(0 if end.left else width - block.width, 0)
        block = self._draw_block(end.room, parent, sum(DEPTHS) // 2)
        bounds = (DOOR_CELLS - block.stop, width - DOOR_CELLS - block.start)
        return block.moved(int(np.clip(width // 2 - (block.start + block.stop) // 2, *bounds)), 0)

    def _draw_rows(
        self, room: int, children: Sequence[int], ends: tuple[End, End], rng: np.random.Generator
    ) -> list[Row]:
        """The rows on both sides of a corridor, each of a depth that fits its rooms."""
        bottom, top = (end.room for end in ends)
        children = [each for each in children if each not in {bottom, top}]
        depth = self._choose_depth(children)
        fronts = self._choose_fronts(room, children, depth, rng)
        wings = {
            each: self._draw_block(each, room, depth, fronts.get(each)) for each in children if not self._is_leaf(each)
        }
        in_front = {*fronts.values()}
        paths = self._find_paths([each for each in children if each not in in_front], rng)

        def measure(each: int) -> float:
            return wings[each].width if each in wings else sqrt(self.areas[each])

        def draw(each: int, depth: int) -> Block:
            return wings.get(each) or draw_room(each, self.areas[each], depth, self.choices.make_rng(each))

        first, last = ({*self.neighbors[end]} if end in self.neighbors else set() for end in (bottom, top))
        first |= self.near_parent
        if rng.random() > ORDERED:
            first, last = set(), set()
        rows = []
        for side in divide_paths(paths, measure, self.areas.__getitem__, rng):
            depth = self._choose_depth([*chain(*side)])
            ranks = {each: (each in last) - (each in first) for each in chain(*side)}
            ordered = [path if ranks[path[0]] <= ranks[path[-1]] else path[::-1] for path in side]
            groups = [[(ranks[each], draw(each, depth)) for each in path] for path in ordered]
            rows.append(self._make_row(groups, children, depth, rng))
        return rows

    def _choose_depth(self, children: Sequence[int]) -> int:
        """The depth of the rows of rooms: the side of a square of the room in which half of all such sides ends."""
        sides = sorted(sqrt(self.areas[each]) for each in children if self._is_leaf(each))
        if not sides:
            return sum(DEPTHS) // 2
        middle = next(side for side, total in zip(sides, accumulate(sides), strict=True) if total >= sum(sides) / 2)
        return min(max(round(middle), DEPTHS[0]), DEPTHS[1])

    def _choose_size(self, room: int, row: int, rng: np.random.Generator) -> tuple[int, int]:
        """Width and length of a corridor of its area and aspect; it is as long as its longer row of rooms at least."""
        area, is_corridor = self.areas[room], room in self.corridors
        if is_corridor and room not in self.aspects:
            usual = area / rng.uniform(*USUAL_WIDTHS)
        else:
            usual = sqrt(area * self.aspects.get(room, ROOM_ASPECT))
        length = max(row, SHORTEST, round_randomly(usual, rng))
        if is_corridor and room in self.joined:
            length = max(length, row + ALLEY)
        narrowest, widest = CORRIDOR_WIDTHS
        return min(max(round_randomly(area / length, rng), narrowest), widest), length

    def _find_paths(self, rooms: Sequence[int], rng: np.random.Generator) -> list[list[int]]:
        """The rooms in an order in which many whose blocks have a door between them follow each other."""
        between = self.neighbors.subgraph(rooms)
        paths = [[room] for room in rooms if room not in between]
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

    def _choose_fronts(
        self, parent: int, children: Sequence[int], depth: int, rng: np.random.Generator
    ) -> dict[int, int]:
        """A small room for each suite in which a strip has space in front of its only room; none that needs an arm."""
        suites = [each for each in children if self._is_suite(each, parent)]
        odd = [each for each in suites if len(self._list_children(each, parent)) % 2]
        if not odd:
            return {}
        siblings = frozenset(children)
        smalls = [
            each
            for each in children
            if self._is_leaf(each)
            and each not in self.joined
            and self._is_apart(each, siblings)
            and is_small(self.areas[each], depth)
        ]
        rng.shuffle(smalls)
        rng.shuffle(odd)
        return dict(zip(odd, smalls, strict=False))

    def _make_row(
        self,
        groups: list[list[tuple[int, Block]]],
        rooms: Sequence[int],
        depth: int,
        rng: np.random.Generator,
    ) -> Row:
        """The blocks of a side with their positions; wings are at one of its ends.

        groups: blocks that follow each other, each with its rank: below 0 for one that should be at the beginning of
        the row, above 0 for one that should be at its end.
        """
        order = rng.permutation(len(groups)).tolist()
        order.sort(key=lambda index: max(block.height for _, block in groups[index]) > WING_RATIO * depth)
        if rng.random() < 1 / 2:
            order.reverse()
        order.sort(key=lambda index: sum(rank for rank, _ in groups[index]))
        row, y = [], 0
        for index in order:
            group = groups[index]
            if group[0][0] == group[-1][0] and rng.random() < 1 / 2:
                group = group[::-1]
            for _, block in group:
                is_wing = len(block.rooms) > 1
                gap = ALLEY if self.choices.alleys and is_wing and not self.joined.isdisjoint(block.rooms) else 0
                row.append((block if rng.random() < 1 / 2 else block.mirrored(), y + gap))
                y += block.width + 2 * gap
        return make_row(row, y, frozenset(rooms), depth)
