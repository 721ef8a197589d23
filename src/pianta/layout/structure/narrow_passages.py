"""Passages that are too narrow to be cut as necks, where without them a room could not be reached.

A robot has seen every room of its map, so a way leads there (thesis, section 3.1: the topological map is connected).
In maps of coarse cells, or with doors narrowed by noise, it can be narrower than any door should be.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from math import ceil
from statistics import median

import cv2
import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.floor import Door
from pianta.layout.structure.necks import Clearance, draw_critical_lines, find_saddles, measure_lengths
from pianta.layout.structure.pieces import Labels, Pieces, find_borders

# A narrow passage is a door where it has this share of the width of the door in the middle of all.
LIKE_OTHERS = 0.5


def find_narrow_passages(
    rooms: Pieces, space: Mask, clearance: Clearance, *, widest: float, joined: Collection[tuple[int, int | None]] = ()
) -> Floats:
    """Lines from jamb to jamb, shape (N, 2, 2), where two rooms touch by a gap no wider than `widest`, in cells.

    rooms: as pieces of the space. space, clearance: as in find_necks. Two rooms have one line, in their widest gap.
    joined: pairs of rooms, the smaller first, whose gaps nobody needs.
    """
    saddles = find_saddles(rooms.labels, clearance)
    narrow = saddles[saddles[:, 2] <= widest / 2].astype(int)
    # A line ends near its middle, which is near the saddle, and both rooms are seen as far beyond it
    reach = ceil(widest)
    found: dict[tuple[int, int], Floats] = {}
    for one, other, _, row, col in narrow.tolist():
        if (one, other) in joined:
            continue
        corner = np.array([max(row - 3 * reach, 0), max(col - 3 * reach, 0)])
        window = np.s_[corner[0] : row + 3 * reach + 1, corner[1] : col + 3 * reach + 1]
        free, place = space[window], np.array([row, col]) - corner
        near = np.argwhere(free & (clearance[window] <= widest / 2))
        middles = near[np.abs(near - place).max(axis=1) <= reach // 2]
        lines = draw_critical_lines(middles.astype(float), free)
        lines = np.unique(lines[measure_lengths(lines) <= widest + 1], axis=0)
        pair = np.where(np.isin(rooms.labels[window], (one, other)), rooms.labels[window], 0)
        lines = _choose_narrowest(lines, replace(rooms, labels=pair), free, place, reach=reach) + corner
        found[one, other] = max(found.get((one, other), lines), lines, key=lambda line: measure_lengths(line).sum())
    return np.concatenate([np.zeros((0, 2, 2)), *found.values()])


def _choose_narrowest(lines: Floats, pair: Pieces, space: Mask, place: NDArray[np.intp], *, reach: int) -> Floats:
    """Of lines, shape (N, 2, 2), the shortest that parts two rooms which meet at a place; shape (0 or 1, 2, 2).

    The contact of two rooms may lie beside the narrowest place of a gap, or askew in it. Contacts further away than
    reach, in cells, are other gaps.
    """
    lines = find_borders(pair, space, lines, reach=0.0).lines
    lines = lines[np.argsort(measure_lengths(lines), kind="stable")]
    is_first = pair.labels == pair.labels[tuple(place)]
    contact = is_first & (cv2.dilate(((pair.labels > 0) & ~is_first).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)
    here = np.s_[max(place[0] - reach, 0) : place[0] + reach + 1, max(place[1] - reach, 0) : place[1] + reach + 1]
    contact[here] = False
    joined = cv2.connectedComponents(((pair.labels > 0) & ~contact).astype(np.uint8), connectivity=4)[1]
    labels = np.where(joined == joined[tuple(place)], pair.labels, 0)
    return next((line[None] for line in lines if _parts_rooms(line, labels)), lines[:0])


def _parts_rooms(line: Floats, labels: Labels) -> bool:
    """Whether the larger parts of two rooms, the labels above 0, are on different sides of a line."""
    (row0, col0), (row1, col1) = line.astype(int).tolist()
    cut = (labels > 0).astype(np.uint8)
    cv2.line(cut, (col0, row0), (col1, row1), 0)
    parts = cv2.connectedComponents(cut, connectivity=4)[1]
    cut_rooms = np.where(parts > 0, labels, 0)
    sides = {int(np.bincount(parts[cut_rooms == room]).argmax()) for room in np.unique(cut_rooms[cut_rooms > 0])}
    # A corner by which two rooms touch is no passage, and only one of them is here
    return len(sides) == 2


def choose_narrow_doors(doors: Sequence[Door], narrow: Iterable[Door], rooms: Iterable[int]) -> list[Door]:
    """Of the narrow doors those that the floor needs: between rooms that no other door joins.

    Chosen are those nearly as wide as most doors are, and the widest that lead to rooms which nothing else leads to.
    Of doors that are equally wide the first ones are chosen.
    """
    known = nx.Graph()
    known.add_nodes_from(rooms)
    known.add_edges_from(door.rooms for door in doors if not door.is_entrance)
    reached = nx.utils.UnionFind(known)
    for component in nx.connected_components(known):
        reached.union(*component)
    wide_enough = LIKE_OTHERS * median(door.width for door in doors) if doors else np.inf
    chosen: list[Door] = []
    # Rounding must not tell widths apart that are equal in cells
    for door in sorted(narrow, key=lambda door: -round(door.width, 6)):
        one, other = door.rooms
        if other is None or known.has_edge(one, other):
            continue
        if door.width >= wide_enough or reached[one] != reached[other]:
            chosen.append(door)
            known.add_edge(one, other)
            reached.union(one, other)
    return chosen
