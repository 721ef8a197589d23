"""The evacuation of a floor: the function behind the verb `pianta evacuate`."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from pianta._arguments import check_argument
from pianta._types import Floats
from pianta.errors import BuildingWarning, OptionError
from pianta.evacuation.evacuation import DoorUse, Evacuation, WayOut
from pianta.evacuation.exits import Exits, find_exits, find_shut_doors
from pianta.evacuation.flow import door_capacity
from pianta.evacuation.movement import Movement, move_people
from pianta.evacuation.people import count_people
from pianta.evacuation.walking import WalkingGraph, Ways, build_walking_graph
from pianta.evacuation.ways_out import find_cut_off, find_shared_doors, find_shared_rooms
from pianta.floor import Floor

MAX_LISTED = 10  # rooms of a warning


def evacuate(
    floor: Floor,
    *,
    exits: Sequence[int] | None = None,
    shut: Sequence[int | tuple[int, int | None]] = (),
    people: Mapping[int, int] | None = None,
    densities: Mapping[str, float] | None = None,
    density: float | None = None,
) -> Evacuation:
    """Evacuate a floor: ways to the nearest exit, rooms with one way out, and times with queues at doors.

    This is an estimate for comparing floors and doors, and no certified simulation: all people start at once, know
    the nearest exit, and walk as healthy adults. The command `pianta evacuate` calls this function.

    Parameters
    ----------
    floor
        The floor, with doors; labels of rooms say how many people are in them.
    exits
        Ids of the rooms in which people are out; None for the entrances of the floor, or, if it has none, the rooms
        labelled ENTRANCE or STAIRS.
    shut
        Doors that cannot be passed: their numbers in `floor.doors`, counted from 1, or the two rooms that they join,
        (3, 7), or (3, None) for an entrance.
    people
        How many people are in some rooms, by id.
    densities
        People per m² by label, for rooms not in `people`; other labels have the densities of the building code.
    density
        People per m² of all rooms that are in neither; None for the building code.

    Returns
    -------
    Evacuation
        Ways and times of rooms, queues of doors, and what each door costs if it is shut.

    Raises
    ------
    OptionError
        No exit is known, no room has a way out, a room or door does not exist, or a number makes no sense.

    Warns
    -----
    BuildingWarning
        Rooms without a way out, and densities for labels that no room has.

    References
    ----------
    M. Luperto, PhD thesis, section 8.4. S. M. V. Gwynne and E. R. Rosenbaum, SFPE Handbook of Fire Protection
    Engineering, 5th edition, 2016, chapter 59. International Building Code 2021, Table 1004.5.

    Examples
    --------
    >>> import pianta
    >>> from shapely import LineString, box
    >>> rooms = (pianta.Room(1, box(0, 0, 4, 3), "OFFICE"), pianta.Room(2, box(4, 0, 8, 3), "CORRIDOR"))
    >>> doors = (
    ...     pianta.Door((1, 2), LineString([(4, 1), (4, 2)]), 1.0),
    ...     pianta.Door((2, None), LineString([(8, 1), (8, 2)]), 1.0),
    ... )
    >>> evacuation = pianta.evacuate(pianta.Floor(rooms, doors))
    >>> evacuation.ways[0].distance, evacuation.ways[0].doors, evacuation.one_way
    (6.0, (1, 2), (1, 2))
    """
    check_argument(floor, Floor, "floor", "a Floor of read, read_floor or read_building")
    # Exits, doors that are shut, and people.
    known_exits, shut_doors = find_exits(floor, exits), find_shut_doors(floor, shut)
    counts = count_people(floor, exit_rooms=known_exits.rooms, people=people, densities=densities, density=density)
    cut_off = find_cut_off(floor, known_exits, shut_doors=shut_doors)
    _check_ways_out(floor, known_exits, cut_off)
    # Shortest ways, then the movement of people with queues, also with each door shut.
    scene = _Scene(floor, known_exits, counts, build_walking_graph(floor))
    current = scene.run(shut_doors)
    shared = find_shared_doors(floor, known_exits, shut_doors)
    doors = [
        scene.describe_door(index, current, shut_doors, shared.get(index, frozenset()))
        for index in range(len(floor.doors))
    ]
    shared_rooms = find_shared_rooms(floor, known_exits, shut_doors)
    return Evacuation(
        floor=floor,
        exit_rooms=tuple(sorted(known_exits.rooms)),
        exit_doors=tuple(index + 1 for index in sorted(known_exits.doors)),
        ways=tuple(scene.describe_room(room.id, current, shared, shared_rooms) for room in floor.rooms),
        doors=tuple(doors),
        time=current.movement.time,
        time_without_queues=float((current.movement.times - current.movement.waits).max(initial=0)),
    )


def _check_ways_out(floor: Floor, exits: Exits, cut_off: frozenset[int]) -> None:
    """Raise OptionError if no room has a way out, and warn of those that have none."""
    inside = {room.id for room in floor.rooms} - exits.rooms
    if inside and inside <= cut_off:
        raise OptionError("no room has a way to an exit: no open door leads there, give other exits=")
    if cut_off:
        listed = ", ".join(map(str, sorted(cut_off)[:MAX_LISTED])) + (", …" if len(cut_off) > MAX_LISTED else "")
        text = f"{len(cut_off)} of {len(floor.rooms)} rooms have no way out, their people are not counted as out"
        warnings.warn(f"floor {floor.source!r}: {text}: {listed}", BuildingWarning, stacklevel=3)


@dataclass(frozen=True, eq=False)
class _Run:
    """Ways and movement with some doors shut; longest: the longest way of each room, metres, inf without a way."""

    ways: Ways
    movement: Movement
    longest: Mapping[int, float]


@dataclass(frozen=True, eq=False)
class _Scene:
    """What stays the same while doors are shut."""

    floor: Floor
    exits: Exits
    people: Mapping[int, int]
    graph: WalkingGraph

    def run(self, shut: frozenset[int]) -> _Run:
        """Ways and movement with the doors of these indices shut."""
        outside = [2 * index + 1 for index in self.exits.doors - shut]
        inside = np.flatnonzero(np.isin(self.graph.node_rooms, sorted(self.exits.rooms))).tolist()
        ways = self.graph.find_ways([*outside, *inside], shut)
        moving = {room: 0 if room in self.exits.rooms else count for room, count in self.people.items()}
        return _Run(ways, move_people(self.floor, self.graph, ways, moving), self._find_longest(ways))

    def _find_longest(self, ways: Ways) -> dict[int, float]:
        parts = self.graph.room_spots.items()
        return {
            room: 0.0 if room in self.exits.rooms else float(ways.spot_distances[part].max()) for room, part in parts
        }

    def describe_door(self, index: int, current: _Run, shut: frozenset[int], cut_off: frozenset[int]) -> DoorUse:
        """The use of a door, and what it costs if it is shut too."""
        door, moved = self.floor.doors[index], current.movement
        passed = moved.passed.get(index)
        if_shut = self.run(shut | {index}) if current.ways.uses_door(index) else current
        reachable = [length for length in if_shut.longest.values() if length < inf]
        return DoorUse(
            number=index + 1,
            rooms=door.rooms,
            capacity=door_capacity(door.width),
            people=0 if passed is None else len(passed),
            last=None if passed is None else float(passed[-1]),
            wait=moved.longest_waits.get(index, 0.0),
            is_shut=index in shut,
            cut_off=tuple(sorted(cut_off)),
            people_cut_off=sum(self.people[room] for room in cut_off),
            time_if_shut=if_shut.movement.time,
            longest_if_shut=max(reachable, default=0.0),
        )

    def describe_room(
        self,
        room: int,
        current: _Run,
        shared: Mapping[int, frozenset[int]],
        shared_rooms: Mapping[int, frozenset[int]],
    ) -> WayOut:
        """The way out of a room; shared: the rooms that each door, and each room, cuts off."""
        ways, spot = current.ways, self.graph.room_spots[room].start
        is_exit, node = room in self.exits.rooms, int(ways.first[spot])
        has_way = node >= 0 and not is_exit
        doors = [index for index, cut_off in shared.items() if room in cut_off]
        longest = current.longest[room]
        times = current.movement.times[current.movement.rooms == room]
        return WayOut(
            room=room,
            people=self.people[room],
            distance=0.0 if is_exit else float(ways.spot_distances[spot]),
            longest=longest,
            doors=tuple(index + 1 for index in ways.list_doors(node)) if has_way else (),
            line=self._draw_line(ways, spot, node) if has_way else np.zeros((0, 2)),
            time=float(times.max()) if len(times) else None,
            shared_doors=tuple(index + 1 for index in sorted(doors)),
            shared_rooms=tuple(sorted(other for other, cut_off in shared_rooms.items() if room in cut_off)),
            dead_end=longest - self._last_distance(ways, doors) if doors and longest < inf else None,
        )

    def _draw_line(self, ways: Ways, spot: int, node: int) -> Floats:
        """The way from a spot over its first node, x, y, shape (N, 2)."""
        return np.vstack([self.graph.spots[spot], self.graph.nodes[ways.list_nodes(node)]])

    def _last_distance(self, ways: Ways, doors: Sequence[int]) -> float:
        """Metres to the exit from the last of some doors that are on one way, before it is passed."""
        return min(float(ways.distances[2 * index : 2 * index + 2].max()) for index in doors)
