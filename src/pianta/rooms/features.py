"""Features of a room in its building, by which classifiers predict what it is for.

All are independent of scale: a map with a wrong or unknown resolution gives the same. Sections 4.2.3 and 5.2 of the
thesis describe a room by area, doors and axes ratio, and by its shape and role in the graph. Added here is how it
compares with the other rooms of its floor, which best discriminates between rooms that are mere rectangles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import networkx as nx
import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.floor import Floor
from pianta.graphs.centrality import (
    betweenness_from_paths,
    closeness_from_distances,
    find_largest_eigenvalue,
    measure_katz,
    to_arrays,
)
from pianta.graphs.shortest_paths import Adjacency, ShortestPaths, find_shortest_paths
from pianta.rooms._outlines import draw_outlines, measure_unit
from pianta.rooms._shapes import (
    MISSING,
    REL_TOLERANCE,
    DoorEnds,
    Rectangles,
    fit_rectangles,
    list_door_ends,
    measure_doors,
    measure_shapes,
)
from pianta.rooms._surroundings import find_alike, measure_facades, measure_sizes, measure_walls, share_walls

# Features of the rooms behind the doors of a room, of which maximum, minimum and mean are features of the room.
NEIGHBOUR_FEATURES = ("degree", "betweenness", "elongation", "facade", "alike_share", "compactness")
CONTEXT_FEATURES: tuple[str, ...] = (
    *("compactness", "spread", "elongation", "rectangularity", "convexity"),
    *("doors", "openings", "door_span", "door_to_end"),
    *("size_to_median", "size_rank", "length_to_floor", "share_of_floor", "size_to_commonest"),
    *("alike", "alike_share", "size_to_nearest"),
    *("facade", "facade_sides", "to_centre"),
    *("wall_neighbours", "wall_neighbours_alike", "wall_size_mean", "wall_size_max", "wall_size_min"),
    *("degree", "mean_degree", "closeness", "betweenness", "katz", "eccentricity", "eccentricity_share"),
    *("within_2", "within_2_share", "within_3_share", "hops_to_hub", "parts", "cut_off", "cut_off_share"),
    *("leaves", "leaves_share", "small_leaves", "siblings", "siblings_alike", "siblings_alike_share"),
    *("main_wall", "main_end"),
    *(f"neighbour_{name}_{summary}" for name in ("size", *NEIGHBOUR_FEATURES) for summary in ("max", "min", "mean")),
)
# Alpha of the Katz centrality over its upper bound, one over the largest eigenvalue; the 0.1 of Table 5.1 is above it
# for a corridor with 100 rooms. Chosen by hand.
KATZ_SHARE = 0.5
# A neighbour is small if its area is below this share of the room's; chosen by hand.
SMALL_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class RoomContext:
    """The n rooms of a floor, in its order, as input of a classifier.

    features: CONTEXT_FEATURES, shape (n, k); all finite, MISSING if undefined.
    doors: 1 if a door or opening joins two rooms, shape (n, n).
    hops: number of doors on the shortest path, infinite without one, shape (n, n).
    walls: wall that the room (row) shares with another (column), over its perimeter, shape (n, n).
    alike: pairs of rooms of nearly the same size and length, False on the diagonal, shape (n, n).
    area: m², shape (n,).
    """

    features: Floats
    doors: Floats
    hops: Floats
    walls: Floats
    alike: NDArray[np.bool_]
    area: Floats


def describe_rooms(floor: Floor) -> RoomContext:
    """Features of every room and relations of rooms, independent of scale, rotation, translation and order."""
    n = len(floor.rooms)
    if not n:
        empty = np.zeros((0, 0))
        return RoomContext(np.zeros((0, len(CONTEXT_FEATURES))), empty, empty, empty, empty.astype(bool), np.zeros(0))
    unit = measure_unit(floor)
    outlines = draw_outlines(floor, unit)
    rectangles, ends = fit_rectangles(outlines), list_door_ends(floor)
    doors, alike, walls = join_rooms(floor), find_alike(outlines, rectangles), share_walls(outlines, unit)
    graph = nx.from_numpy_array(doors)
    paths = find_shortest_paths(to_arrays(graph))
    measured = {
        **measure_shapes(outlines, rectangles),
        **measure_doors(ends, rectangles),
        **measure_sizes(outlines, rectangles, alike),
        **measure_facades(outlines, rectangles, unit),
        **measure_walls(walls, outlines),
        **measure_topology(graph, doors, paths),
    }
    area = shapely.area(outlines)
    measured |= measure_relatives(doors, alike, area)
    measured |= measure_main_neighbours(doors, walls, area, ends, rectangles)
    measured |= measure_neighbours(doors, area, measured)
    features = np.column_stack([measured[name] for name in CONTEXT_FEATURES])
    return RoomContext(
        features, doors, paths.distances, walls, alike, shapely.area([room.polygon for room in floor.rooms])
    )


def join_rooms(floor: Floor) -> Floats:
    """1 if a door or opening joins two rooms, shape (n, n)."""
    row_of = {room.id: row for row, room in enumerate(floor.rooms)}
    doors = np.zeros((len(row_of), len(row_of)))
    for door in floor.doors:
        if door.joins_rooms:
            first, second = (row_of[room] for room in door.room_ids)
            doors[first, second] = doors[second, first] = 1
    return doors


def measure_topology(graph: nx.Graph, doors: Floats, paths: ShortestPaths) -> dict[str, Floats]:
    """The role of a room in the graph: centralities, rooms within some doors, and rooms that it alone leads to."""
    n, hops = len(doors), paths.distances
    degree = doors.sum(axis=1)
    betweenness = betweenness_from_paths(paths)
    farthest = np.where(np.isinf(hops), 0, hops).max(axis=1)
    hubs = betweenness >= betweenness.max() * (1 - REL_TOLERANCE)
    to_hub = hops[:, hubs].min(axis=1)
    parts, cut_off = _measure_cuts(graph)
    return {
        "degree": degree,
        "mean_degree": np.full(n, degree.mean()),
        "closeness": closeness_from_distances(hops),
        "betweenness": betweenness,
        "katz": _measure_katz(graph),
        "eccentricity": farthest,
        "eccentricity_share": farthest / max(farthest.max(), 1),
        "within_2": (hops <= 2).sum(axis=1).astype(float),
        "within_2_share": (hops <= 2).mean(axis=1),
        "within_3_share": (hops <= 3).mean(axis=1),
        "hops_to_hub": np.where(np.isinf(to_hub), MISSING, to_hub),
        "parts": parts,
        "cut_off": cut_off,
        "cut_off_share": cut_off / n,
    }


def measure_relatives(doors: Floats, alike: NDArray[np.bool_], area: Floats) -> dict[str, Floats]:
    """Neighbours that are leaves (no other door), and siblings (other rooms that a neighbour leads to)."""
    degree = doors.sum(axis=1)
    leaves = doors * (degree <= 1)
    siblings = _find_siblings(doors)
    count, count_alike = siblings.sum(axis=1), (siblings & alike).sum(axis=1)
    return {
        "leaves": leaves.sum(axis=1),
        "leaves_share": leaves.sum(axis=1) / np.maximum(degree, 1),
        "small_leaves": (leaves * (area[None] < SMALL_SHARE * (1 - REL_TOLERANCE) * area[:, None])).sum(axis=1),
        "siblings": count.astype(float),
        "siblings_alike": count_alike.astype(float),
        "siblings_alike_share": count_alike / np.maximum(count, 1),
    }


def _find_siblings(doors: Floats) -> NDArray[np.bool_]:
    """Which other rooms a neighbour of a room (row) leads to, shape (n, n)."""
    edges = Adjacency(len(doors), *np.nonzero(doors))
    first, second = edges.leave(edges.ends)
    siblings = np.zeros(doors.shape, bool)
    siblings[edges.starts[first], edges.ends[second]] = True
    np.fill_diagonal(siblings, val=False)
    return siblings


def measure_main_neighbours(
    doors: Floats, walls: Floats, area: Floats, ends: DoorEnds, rectangles: Rectangles
) -> dict[str, Floats]:
    """The main neighbour (large, with many doors): its share of the room's walls, and how near its end the door is."""
    n = len(doors)
    weight = doors * (area * (1 + doors.sum(axis=1)))[None]
    main = (weight > 0) & (weight >= weight.max(axis=1, keepdims=True) * (1 - REL_TOLERANCE))
    count = main.sum(axis=1)
    to_end = np.full(n, np.inf)
    end, neighbour = np.nonzero(main[ends.rooms])
    distances = rectangles.distance_to_ends(neighbour, ends.points[end]) / rectangles.length[neighbour]
    np.minimum.at(to_end, ends.rooms[end], distances)
    return {
        "main_wall": np.where(count > 0, (walls * main).sum(axis=1) / np.maximum(count, 1), 0),
        "main_end": np.where(np.isinf(to_end), MISSING, to_end),
    }


def measure_neighbours(doors: Floats, area: Floats, measured: Mapping[str, Floats]) -> dict[str, Floats]:
    """Maximum, minimum and mean of features of the rooms behind doors; sizes relative to the room's own."""
    size = np.log(area)
    summaries = _summarise("size", doors, size[None] - size[:, None])
    for name in NEIGHBOUR_FEATURES:
        summaries |= _summarise(name, doors, np.broadcast_to(measured[name], doors.shape))
    return summaries


def _summarise(name: str, doors: Floats, values: Floats) -> dict[str, Floats]:
    """Summaries over the rooms (columns) that a door joins to a room (row), MISSING without doors."""
    joined, degree = doors > 0, doors.sum(axis=1)
    summaries = {
        "max": np.where(joined, values, -np.inf).max(axis=1),
        "min": np.where(joined, values, np.inf).min(axis=1),
        "mean": (doors * values).sum(axis=1) / np.maximum(degree, 1),
    }
    return {f"neighbour_{name}_{key}": np.where(degree > 0, value, MISSING) for key, value in summaries.items()}


def _measure_katz(graph: nx.Graph) -> Floats:
    """Katz centrality with a mean square of 1, so that floors of different sizes are comparable."""
    largest = max(find_largest_eigenvalue(graph), 1.0)
    values = np.array([*measure_katz(graph, alpha=KATZ_SHARE / largest).values()])
    return np.asarray(values * np.sqrt(len(values)))


def _measure_cuts(graph: nx.Graph) -> tuple[Floats, Floats]:
    """Number of parts of the graph without a room, and number of rooms then cut off from the largest part.

    Both are 0 in a component of one or two rooms.
    """
    parts, cut_off = np.zeros(len(graph)), np.zeros(len(graph))
    cutting = {*nx.articulation_points(graph)}
    for connected in nx.connected_components(graph):
        if len(connected) > 2:
            parts[[*connected]] = 1
            for room in cutting & connected:
                sizes = [len(part) for part in nx.connected_components(graph.subgraph(connected - {room}))]
                parts[room], cut_off[room] = len(sizes), sum(sizes) - max(sizes)
    return parts, cut_off
