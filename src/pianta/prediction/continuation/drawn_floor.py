"""A floor in the map frame: a known part, and beyond it the rooms of a sample that were placed on its ground."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, sin
from typing import TypeAlias

import networkx as nx
import numpy as np
import shapely
from shapely import LineString, Point, Polygon
from shapely.geometry.base import BaseGeometry

from pianta._types import Floats
from pianta.floor import PREDICTED_FLAG, Door, Floor, Room
from pianta.generation.drawing.blocks import CELL, DOOR_CELLS, Cells, Contact, find_contacts
from pianta.generation.drawing.walls import outline_cells
from pianta.gridmap import GridMap
from pianta.layout._label_images import largest_part
from pianta.prediction.continuation.known_part import KnownPart
from pianta.worlds.wall_axes import INNER_WALL, find_wall_axes, find_wall_body, round_to_mm

ToMap: TypeAlias = Callable[[BaseGeometry], BaseGeometry]

PASSAGE = 0.9  # m, width of a predicted door, in the middle of the wall that its rooms share
LEAST_AREA = 0.5  # m²; of a room of which less is left beside the known rooms nothing is drawn
MILLIMETRE = 0.001  # m
REACH = 1.6  # m, from a known door to the room behind it at most: a wall, and the reach of thresholds


@dataclass(frozen=True, eq=False)
class SampleRooms:
    """Rooms of a sample as cells of a frame, row 0 at the top.

    graph: of the sample. partial: explored part's node of each room of which a part is seen, by node of the sample.
    behind: node of the sample behind each unopened door, by unknown room. unknown: nodes that are to have cells.
    """

    cells: Cells
    graph: nx.Graph
    partial: Mapping[int, int]
    behind: Mapping[int, int]
    unknown: frozenset[int]

    @cached_property
    def placed(self) -> list[int]:
        """The nodes with cells."""
        present = {*np.unique(self.cells).tolist()}
        return [node for node in self.graph if node in present]

    @cached_property
    def doors(self) -> list[tuple[int, int]]:
        """The doors of unknown rooms that are not known, the smaller node first."""
        edges = ((min(edge), max(edge)) for edge in self.graph.edges)
        return [edge for edge in edges if self.unknown.issuperset(edge) and not self.partial.keys() >= {*edge}]

    @cached_property
    def contacts(self) -> dict[tuple[int, int], Contact]:
        """The walls in which there is space for these doors."""
        walls = find_contacts(self.cells)
        return {door: walls[door] for door in self.doors if door in walls and walls[door].length >= DOOR_CELLS}

    @cached_property
    def numbers(self) -> dict[str, int]:
        """Counts of unknown rooms, of those without cells, of their doors and of those with a wall.

        given up: doors between placed rooms without a wall.
        """
        placed = {*self.placed}
        given_up = sum(placed.issuperset(door) for door in self.doors) - len(self.contacts)
        rooms, unplaced = len(self.unknown), len(self.unknown - placed)
        doors = {"doors": len(self.doors), "walls": len(self.contacts), "given up": given_up}
        return {"rooms": rooms, "unplaced": unplaced, **doors}


def draw_floor(sample: SampleRooms, known_part: KnownPart, frame: GridMap) -> Floor:
    """The floor of a sample: known rooms stay, seen ones get a prediction, others are new and have a flag."""
    to_map, cells = _find_motion(frame), np.flipud(sample.cells)
    spaces = {node: outline_cells(cells, node) for node in sample.placed}
    body = find_wall_body(find_wall_axes(spaces.values()), Polygon())
    rooms = {room.id: room for room in known_part.floor}
    first = max(known_part.floor.last_id, *rooms) + 1
    ids = {node: first + number for number, node in enumerate(node for node in spaces if node not in sample.partial)}
    ids |= {node: known_part.ids[number] for node, number in sample.partial.items()}
    gap = INNER_WALL / 2
    for node, space in spaces.items():
        shape = to_map(space.difference(body))
        others = [
            room.polygon
            for room in known_part.floor
            if room.id != ids[node] and shapely.dwithin(room.polygon, shape, gap)
        ]
        shape = shape.difference(shapely.union_all([other.buffer(gap) for other in others]))
        if node in sample.partial:
            rooms[ids[node]] = _extend(rooms[ids[node]], shape)
        elif (outline := round_outline(shape)).area >= LEAST_AREA:
            rooms[ids[node]] = Room(ids[node], outline, sample.graph.nodes[node]["label"], flag=PREDICTED_FLAG)
    doors = [door for door in _list_doors(sample, known_part, ids, to_map) if _is_between(door, rooms)]
    axes = find_wall_axes(space for node, space in spaces.items() if node not in sample.partial)
    return replace(
        known_part.floor,
        rooms=tuple(rooms[number] for number in sorted(rooms)),
        doors=(*known_part.floor.doors, *doors),
        walls=(*known_part.floor.walls, *(to_map(axis) for axis in axes)),
        last_id=max(known_part.floor.last_id, *rooms),
    )


def round_outline(shape: BaseGeometry) -> Polygon:
    """The largest part of a shape in millimetres, in which narrower necks are gone."""
    return round_to_mm(largest_part(shapely.set_precision(shape, MILLIMETRE)))


def _extend(room: Room, shape: BaseGeometry) -> Room:
    """A room of which a part is seen, with the whole that a sample gives it."""
    complete = largest_part(shape.union(room.polygon))
    is_larger = complete.contains(room.polygon.representative_point()) and complete.area > room.polygon.area
    return replace(room, partial=True, predicted=complete if is_larger else room.polygon, confidence=None)


def _list_doors(sample: SampleRooms, known_part: KnownPart, ids: Mapping[int, int], to_map: ToMap) -> Iterator[Door]:
    """Known doors to predicted rooms, and predicted doors."""
    for end, node in sample.behind.items():
        if end in known_part.ends and node in ids and node not in sample.partial:
            line = known_part.ends[end]
            yield Door((known_part.near[end], ids[node]), line, max(line.length, 0.0))
    for (one, other), contact in sample.contacts.items():
        yield Door((ids[one], ids[other]), to_map(_locate_passage(contact, len(sample.cells))), PASSAGE)


def _locate_passage(contact: Contact, rows: int) -> LineString:
    """The door in the middle of a wall between cells, m from the lower left corner of all."""
    start, across = (contact.column, contact.row) if contact.is_level else (contact.row, contact.column)
    middle = start + contact.length / 2
    half = PASSAGE / CELL / 2
    ends = np.array([(middle - half, across + 1), (middle + half, across + 1)])
    columns, rows_down = ends.T if contact.is_level else ends.T[::-1]
    return LineString(np.column_stack([columns, rows - rows_down]) * CELL)


def _is_between(door: Door, rooms: Mapping[int, Room]) -> bool:
    """Whether both rooms of a door are drawn and near it."""
    middle: Point = door.line.interpolate(0.5, normalized=True)
    return all(
        number in rooms and (rooms[number].predicted or rooms[number].polygon).distance(middle) <= REACH
        for number in door.room_ids
    )


def _find_motion(frame: GridMap) -> ToMap:
    """From metres along the sides of a frame, from its lower left corner, to the map frame."""
    x, y, yaw = frame.origin
    turn = np.array([[cos(yaw), sin(yaw)], [-sin(yaw), cos(yaw)]])

    def move(xy: Floats) -> Floats:
        return np.asarray(xy @ turn + (x, y))

    return lambda geometry: shapely.transform(geometry, move)
