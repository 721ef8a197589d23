"""Passages that are too narrow to be cut as necks, where without them a room could not be reached.

The robot that made the map has been in every room, so each can be reached (thesis, section 3.1: the topological map is
connected). In maps of coarse cells, or with doors narrowed by noise, the way can be narrower than any real door.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from math import ceil
from statistics import median

import cv2
import networkx as nx
import numpy as np

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.floor import Door
from pianta.layout._label_images import grow_mask
from pianta.layout.structure.necks import Clearance, draw_critical_lines, find_saddles, measure_lengths
from pianta.layout.structure.regions import Regions, find_separators

# A narrow passage counts as a door from this share of the median width of the doors on (chosen by hand).
MIN_WIDTH_SHARE = 0.5
# A passage may be a gap in a wall if it has less than this share of the median width of all, ...
MIN_USUAL_SHARE = 0.25
# ... or if a passage between the same rooms is at least this many times as wide (both chosen by hand).
WIDER_RATIO = 2.0


def find_narrow_passages(
    rooms: Regions,
    space: Mask,
    clearance: Clearance,
    *,
    max_width: float,
    joined: Collection[tuple[int, int | None]] = (),
) -> Floats:
    """Lines from jamb to jamb, shape (N, 2, 2), where two rooms touch by a gap of at most max_width; cells.

    rooms: as regions of the free space. space, clearance: as in find_necks. Two rooms have one line, in their widest
    gap. joined: pairs of rooms, the smaller first, whose gaps are not needed.
    """
    saddles = find_saddles(rooms.labels, clearance)
    narrow = saddles[saddles[:, 2] <= max_width / 2].astype(int)
    # The middle of a gap is at most half of reach from its saddle, and its line ends within reach of its middle.
    reach = ceil(max_width)
    passages: dict[tuple[int, int], Floats] = {}
    for one, other, _, row, col in narrow.tolist():
        if (one, other) in joined:
            continue
        corner = np.array([max(row - 3 * reach, 0), max(col - 3 * reach, 0)])
        window = np.s_[corner[0] : row + 3 * reach + 1, corner[1] : col + 3 * reach + 1]
        free, saddle = space[window], np.array([row, col]) - corner
        near = np.argwhere(free & (clearance[window] <= max_width / 2))
        middles = near[np.abs(near - saddle).max(axis=1) <= reach // 2]
        lines = draw_critical_lines(middles.astype(float), free)
        lines = np.unique(lines[measure_lengths(lines) <= max_width + 1], axis=0)
        pair = np.where(np.isin(rooms.labels[window], (one, other)), rooms.labels[window], 0)
        lines = _choose_shortest(lines, replace(rooms, labels=pair), saddle, reach=reach) + corner
        passages[one, other] = max(
            passages.get((one, other), lines), lines, key=lambda line: measure_lengths(line).sum()
        )
    return np.concatenate([np.zeros((0, 2, 2)), *passages.values()])


def _choose_shortest(lines: Floats, pair: Regions, saddle: Indices, *, reach: int) -> Floats:
    """The shortest of lines, shape (N, 2, 2), that divides two rooms which meet at a saddle; shape (0 or 1, 2, 2).

    The contact of the two rooms may lie beside the narrowest point of the gap, or run obliquely through it. Contacts
    further away than reach, in cells, belong to other gaps.
    """
    lines = find_separators(pair, lines).lines
    lines = lines[np.argsort(measure_lengths(lines), kind="stable")]
    is_first = pair.labels == pair.labels[tuple(saddle)]
    contact = is_first & grow_mask((pair.labels > 0) & ~is_first, 1)
    around = np.s_[max(saddle[0] - reach, 0) : saddle[0] + reach + 1, max(saddle[1] - reach, 0) : saddle[1] + reach + 1]
    contact[around] = False
    components = cv2.connectedComponents(((pair.labels > 0) & ~contact).astype(np.uint8), connectivity=4)[1]
    labels = np.where(components == components[tuple(saddle)], pair.labels, 0)
    return next((line[None] for line in lines if _divides_rooms(line, labels)), lines[:0])


def _divides_rooms(line: Floats, labels: LabelImage) -> bool:
    """Whether the larger parts of two rooms, the labels above 0, are on different sides of a line."""
    (row0, col0), (row1, col1) = line.astype(int).tolist()
    inside = (labels > 0).astype(np.uint8)
    cv2.line(inside, (col0, row0), (col1, row1), 0)
    parts = cv2.connectedComponents(inside, connectivity=4)[1]
    cut_rooms = np.where(parts > 0, labels, 0)
    sides = {int(np.bincount(parts[cut_rooms == room]).argmax()) for room in np.unique(cut_rooms[cut_rooms > 0])}
    # Rooms that touch by a corner have no passage there, and then only one of them is left.
    return len(sides) == 2


def find_wall_gaps(doors: Sequence[Door], *, max_width: float) -> list[Door]:
    """The doors below a width that may be holes in a noisy wall: the others show that people do not walk there.

    A door of the same rooms is much wider, or most doors of the floor are. max_width: metres.
    """
    widest: dict[tuple[int, int | None], float] = {}
    for door in doors:
        widest[door.rooms] = max(door.width, widest.get(door.rooms, 0.0))
    usual = MIN_USUAL_SHARE * median(door.width for door in doors) if doors else 0.0
    return [
        door
        for door in doors
        if door.width < max_width and (door.width < usual or WIDER_RATIO * door.width <= widest[door.rooms])
    ]


def choose_narrow_doors(doors: Sequence[Door], narrow: Iterable[Door], rooms: Iterable[int]) -> list[Door]:
    """The narrow doors that the floor needs, between rooms that no other door joins.

    These are the doors nearly as wide as most doors, and the widest ones to rooms that no other chain of doors reaches.
    Of equally wide doors the first one is chosen.
    """
    graph = nx.Graph()
    graph.add_nodes_from(rooms)
    graph.add_edges_from(door.rooms for door in doors if door.joins_rooms)
    reached = nx.utils.UnionFind(graph)
    for component in nx.connected_components(graph):
        reached.union(*component)
    wide_enough = MIN_WIDTH_SHARE * median(door.width for door in doors) if doors else np.inf
    chosen: list[Door] = []
    # Widths that are equal in cells must stay equal in spite of rounding errors.
    for door in sorted(narrow, key=lambda door: -round(door.width, 6)):
        one, other = door.rooms
        if other is None or graph.has_edge(one, other):
            continue
        if door.width >= wide_enough or reached[one] != reached[other]:
            chosen.append(door)
            graph.add_edge(one, other)
            reached.union(one, other)
    return chosen
