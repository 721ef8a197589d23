"""The explored part of a floor as outlines in the map frame: known rooms, open corridors, and unopened doors."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from typing import Any

import shapely
from shapely import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from pianta.errors import FloorError
from pianta.floor import Door, Floor
from pianta.graphs.labelled_graphs import name_some
from pianta.layout._label_images import largest_part
from pianta.prediction.explored_part import ExploredPart
from pianta.prediction.revealed_floor import RevealedFloor

# Of a whole floor that is explored for a test, an open corridor is seen this far from the doors of known rooms.
SIGHT = 3.0  # m, chosen by hand


@dataclass(frozen=True, eq=False)
class KnownPart:
    """What is known of a floor, metres of the map frame.

    floor: the known rooms, and others as far as they are seen, with the doors between them. partial: the part that is
    seen of open corridors and of unknown rooms, by node of the explored part. ends: unknown room -> the line of the
    unopened door to it. near: unknown room -> the id of the room with that door. ids: of the rooms of `partial`.
    """

    floor: Floor
    partial: Mapping[int, BaseGeometry]
    ends: Mapping[int, LineString]
    near: Mapping[int, int]
    ids: Mapping[int, int]

    @property
    def closed(self) -> list[Polygon]:
        """The outlines of rooms that do not go on."""
        return [room.polygon for room in self.floor if room.id not in self.ids.values()]

    @property
    def outlines(self) -> list[BaseGeometry]:
        """Of all rooms, as far as they are seen."""
        return [*self.closed, *self.partial.values()]


def locate_known_part(explored: ExploredPart, floor: Floor, truth: RevealedFloor | None = None) -> KnownPart:
    """The outlines of an explored part on the floor that it was read from.

    truth: if that is a whole floor; of its open corridors only what lies near a door of a known room is seen.
    Raises FloorError if rooms or doors of the explored part are not on the floor.
    """
    names: dict[int, Any] = dict(explored.graph.nodes(data="room"))
    rooms = {node: names[node] for node in explored.known_graph}
    if missing := sorted({name for name in rooms.values() if name not in floor}, key=str):
        raise FloorError(f"rooms {name_some(missing)} of the prediction are not on the floor, give the floor of both")
    lines = _list_doors(floor)
    ends, ids = {}, {node: rooms[node] for node in explored.open}
    for node, near in explored.doors.items():
        far = truth.behind[names[node]] if truth else names[node]
        pair = frozenset((names[near], far))
        if pair not in lines:
            raise FloorError(f"the floor has no door between rooms {name_some([names[near], far])} of the prediction")
        # A room of which a part is seen through two doors is at the first
        if truth is None and far in ids.values():
            continue
        ends[node] = lines[pair]
        if truth is None:
            ids[node] = far
    near_ids = {node: names[near] for node, near in explored.doors.items()}
    if truth is None:
        return KnownPart(floor, {node: floor[number].polygon for node, number in ids.items()}, ends, near_ids, ids)
    closed = {rooms[node] for node in explored.closed}
    partial = {node: _clip_to_sight(floor, number, closed) for node, number in ids.items()}
    return KnownPart(_reveal(floor, closed, {ids[node]: partial[node] for node in ids}), partial, ends, near_ids, ids)


def _list_doors(floor: Floor) -> dict[frozenset[Hashable], LineString]:
    """The widest passage between each two rooms."""
    doors: dict[frozenset[Hashable], Door] = {}
    for door in floor.doors:
        pair: frozenset[Hashable] = frozenset(door.room_ids)
        if pair not in doors or doors[pair].width < door.width:
            doors[pair] = door
    return {pair: door.line for pair, door in doors.items()}


def _clip_to_sight(floor: Floor, corridor: int, closed: AbstractSet[int]) -> BaseGeometry:
    """What is seen of a corridor from the doors that join it to known rooms."""
    lines = [door.line for door in floor.doors if corridor in door.room_ids and not closed.isdisjoint(door.room_ids)]
    return floor[corridor].polygon.intersection(shapely.union_all([line.buffer(SIGHT) for line in lines]))


def _reveal(floor: Floor, closed: AbstractSet[int], partial: Mapping[int, BaseGeometry]) -> Floor:
    """A whole floor without what is not explored; partial: by the ids of open corridors."""
    rooms = [room for room in floor if room.id in closed]
    rooms += [
        replace(floor[number], polygon=part, partial=True)
        for number, outline in partial.items()
        if not (part := largest_part(outline)).is_empty
    ]
    ids = {room.id for room in rooms}
    doors = tuple(
        door for door in floor.doors if ids.issuperset(door.room_ids) and not closed.isdisjoint(door.room_ids)
    )
    return replace(
        floor,
        rooms=tuple(rooms),
        doors=doors,
        walls=(),
        furniture=(),
        possible_doors=(),
        last_id=max(floor.last_id, *(room.id for room in floor)),
    )
