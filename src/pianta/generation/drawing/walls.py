"""A floor with walls and doors, from the cells of its rooms."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

import networkx as nx
import numpy as np
from shapely import LineString, Polygon, box, unary_union, union_all

from pianta.floor import Door, Floor, Room
from pianta.generation.drawing.blocks import CELL, Cells
from pianta.generation.drawing.programme import Programme
from pianta.worlds.wall_axes import (
    find_shared_wall,
    find_wall_axes,
    find_wall_body,
    round_to_mm,
    split_sides,
)

ENTRANCE = "ENTRANCE"  # the label of rooms that lead outside
ENTRANCE_WIDTH = 1.2  # m
# m, of openings: from those on that a reader takes for openings. Floors seldom have their true widths; chosen by hand
OPENING_WIDTHS = (2.1, 3.0)
MARGIN = 0.3  # of wall beside a door, from the axis of the next wall, m


def build_plan(
    cells: Cells,
    programme: Programme,
    doors: Iterable[tuple[int, int]],
    rng: np.random.Generator,
    *,
    building_type: str,
) -> Floor:
    """A floor whose rooms have the labels of a graph, with ids from 1, and a door for each pair of nodes.

    cells: the node of each cell. Rooms called ENTRANCE have a door to the outside if they have an outer wall.
    """
    graph = programme.graph
    spaces = {node: outline_cells(cells, node) for node in graph}
    axes = find_wall_axes(spaces.values())
    footprint = unary_union([*spaces.values()])
    walls = find_wall_body(axes, footprint)
    rooms = [
        Room(node + 1, round_to_mm(space.difference(walls)), label=graph.nodes[node]["label"])
        for node, space in spaces.items()
    ]
    inner = []
    for one, other in doors:
        wall = find_shared_wall(spaces[one], spaces[other])
        is_opening = rng.random() < programme.opening_shares.get((one, other), 0.0)
        width = float(rng.uniform(*OPENING_WIDTHS) if is_opening else rng.choice(programme.door_widths))
        door_kind: Literal["door", "opening"] = "opening" if is_opening else "door"
        inner.append(Door((one + 1, other + 1), *position_door(wall, width, rng), kind=door_kind))
    return Floor(
        tuple(rooms),
        doors=(*inner, *_make_entrances(spaces, graph, footprint, rng)),
        walls=axes,
        building_type={building_type: 1.0},
        source=str(graph.graph.get("source", "")),
    )


def outline_cells(cells: Cells, room: int) -> Polygon:
    """The outline of a room, metres."""
    rows, columns = np.nonzero(np.diff(np.pad(cells == room, ((0, 0), (1, 1))).astype(np.int8), axis=1))
    runs = box(columns[::2] * CELL, rows[::2] * CELL, columns[1::2] * CELL, (rows[::2] + 1) * CELL)
    outline: Polygon = union_all(runs).simplify(0)
    return outline


def _make_entrances(
    spaces: Mapping[int, Polygon], graph: nx.Graph, footprint: Polygon, rng: np.random.Generator
) -> list[Door]:
    """A door to the outside for each room called ENTRANCE that has enough outer wall."""
    entrances = []
    for node in (node for node, label in graph.nodes(data="label") if label == ENTRANCE):
        sides: Sequence[LineString] = [*split_sides(spaces[node].boundary.intersection(footprint.exterior))]
        longest = max(sides, key=lambda side: side.length, default=LineString())
        if longest.length >= ENTRANCE_WIDTH + 2 * MARGIN:
            entrances.append(Door((node + 1, None), *position_door(longest, ENTRANCE_WIDTH, rng)))
    return entrances


def find_closed_entrances(floor: Floor) -> tuple[int, ...]:
    """The ids of rooms called ENTRANCE without a door to the outside."""
    open_rooms = {room for door in floor.doors if door.is_entrance for room in door.room_ids}
    return tuple(room.id for room in floor if room.label == ENTRANCE and room.id not in open_rooms)


def position_door(wall: LineString, widest: float, rng: np.random.Generator) -> tuple[LineString, float]:
    """A door at a random position of a wall, from jamb to jamb, and its width, which is less if the wall is short."""
    free = wall.length - 2 * MARGIN
    width = round(min(widest, free), 2)
    start = MARGIN + (free - width) * rng.random()
    jambs = [wall.interpolate(start), wall.interpolate(start + width)]
    return round_to_mm(LineString(jambs)), width
