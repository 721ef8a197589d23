"""Passages that are too narrow to be cut as necks, where without them a room could not be reached.

A robot has seen every room of its map, so a way leads there (thesis, section 3.1: the topological map is connected).
In maps of coarse cells, or with doors narrowed by noise, it can be narrower than any door should be.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from statistics import median

import networkx as nx
import numpy as np

from pianta.floor import Door
from pianta.layout.canvas import Mask
from pianta.layout.necks import Clearance, Floats, draw_critical_lines, find_saddles
from pianta.layout.pieces import Labels

# A narrow passage is a door where it has this share of the width of the door in the middle of all.
LIKE_OTHERS = 0.5


def find_narrow_passages(labels: Labels, space: Mask, clearance: Clearance, *, widest: float) -> Floats:
    """Lines from jamb to jamb, shape (N, 2, 2), where two rooms touch by a gap no wider than `widest`, in cells.

    labels: shape (H, W), n for the free cells of room n. space, clearance: as in find_necks.
    """
    saddles = find_saddles(labels, clearance)
    narrow = saddles[saddles[:, 2] <= widest / 2]
    return draw_critical_lines(narrow[:, 3:], space)


def choose_narrow_doors(doors: Sequence[Door], narrow: Iterable[Door], rooms: Iterable[int]) -> list[Door]:
    """Of the narrow doors those that the floor needs: between rooms that no other door joins.

    Chosen are those nearly as wide as most doors are, and the widest that lead to rooms which nothing else leads to.
    """
    known = nx.Graph()
    known.add_nodes_from(rooms)
    known.add_edges_from(door.rooms for door in doors if not door.is_entrance)
    reached = nx.utils.UnionFind(known)
    for component in nx.connected_components(known):
        reached.union(*component)
    wide_enough = LIKE_OTHERS * median(door.width for door in doors) if doors else np.inf
    chosen: list[Door] = []
    for door in sorted(narrow, key=lambda door: (-door.width, door.rooms[0], door.line.coords[0])):
        one, other = door.rooms
        if other is None or known.has_edge(one, other):
            continue
        if door.width >= wide_enough or reached[one] != reached[other]:
            chosen.append(door)
            known.add_edge(one, other)
            reached.union(one, other)
    return chosen
