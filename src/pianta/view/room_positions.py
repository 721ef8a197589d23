"""Positions on a map for rooms of a sampled floor that no robot has seen: beside their neighbours, off known rooms.

No model says where these rooms are. The positions are only such that nothing overlaps and doors are short.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Mapping
from math import atan2, cos, pi, sin, sqrt

import networkx as nx
import numpy as np
import shapely
from shapely import Point
from shapely.geometry.base import BaseGeometry

from pianta.view.drawn_graphs import area_of

# Radius of a room without an area, and the least and the largest radius, m; chosen by hand.
USUAL_RADIUS = 1.7
SMALLEST_RADIUS = 0.7
LARGEST_RADIUS = 6.0
# Between two rooms, and between a room and known ones, m.
GAP = 0.4
# Positions that are tried: directions around a room, and how many distances of GROWTH times the shortest.
DIRECTIONS = 24
DISTANCES = 14
GROWTH = 1.3

XY = tuple[float, float]


def radius_of(graph: nx.Graph, node: Hashable) -> float:
    """The radius of a disc of the node's area, m."""
    area = area_of(graph, node)
    radius = USUAL_RADIUS if area is None else sqrt(area / pi)
    return min(max(radius, SMALLEST_RADIUS), LARGEST_RADIUS)


def place_unknown(graph: nx.Graph, starts: Mapping[Hashable, XY], shape: BaseGeometry) -> dict[Hashable, XY]:
    """x, y of all nodes that hang together with those of `starts`, metres of the map frame.

    starts: of nodes whose position is certain. shape: what other rooms must not cover, such as the known rooms.
    """
    shapely.prepare(shape)
    middle = shape.centroid if not shape.is_empty else Point(0, 0)
    positions: dict[Hashable, XY] = dict(starts)
    discs: list[tuple[float, float, float]] = []
    waiting = deque(starts)
    while waiting:
        node = waiting.popleft()
        for near in graph[node]:
            if near not in positions:
                positions[near] = _find_position(
                    positions[node], (middle.x, middle.y), radius_of(graph, near), shape, discs
                )
                discs.append((*positions[near], radius_of(graph, near)))
                waiting.append(near)
    return positions


def _find_position(
    start: XY, middle: XY, radius: float, shape: BaseGeometry, discs: list[tuple[float, float, float]]
) -> XY:
    """The first free position around a start, the nearest first, away from the middle first."""
    outwards = atan2(start[1] - middle[1], start[0] - middle[0])
    turns = sorted(
        (2 * pi * step / DIRECTIONS for step in range(DIRECTIONS)), key=lambda turn: min(turn, 2 * pi - turn)
    )
    others = np.array(discs).reshape(-1, 3)
    distance = 2 * radius
    position = start
    for _ in range(DISTANCES):
        for turn in turns:
            position = (start[0] + distance * cos(outwards + turn), start[1] + distance * sin(outwards + turn))
            gaps = np.hypot(others[:, 0] - position[0], others[:, 1] - position[1]) - others[:, 2] - radius
            if (gaps >= GAP).all() and not shapely.dwithin(shape, Point(position), radius + GAP):
                return position
        distance *= GROWTH
    return position
