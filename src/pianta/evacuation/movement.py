"""How people leave: each walks the shortest way to the nearest exit, and queues at its doors."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pianta._types import Floats, Indices
from pianta.evacuation.flow import FREE_SPEED, door_capacity, pass_queue, walking_speed
from pianta.evacuation.walking import WalkingGraph, Ways
from pianta.floor import Floor

GOLDEN = (5**0.5 - 1) / 2  # multiples of it, modulo 1, are spread evenly at every length


@dataclass(frozen=True, eq=False)
class Movement:
    """When people are out, and how long they wait.

    rooms: id of the room of each person who has a way out. times: when each is out, s. waits: in all queues, s.
    passed: by index of each door that was used, the times at which people passed it, s, sorted; longest_waits: the
        longest wait there, s.
    """

    rooms: Indices
    times: Floats
    waits: Floats
    passed: Mapping[int, Floats]
    longest_waits: Mapping[int, float]

    @property
    def time(self) -> float:
        """When the last person is out, s; 0 without people."""
        return float(self.times.max(initial=0))


def place_people(graph: WalkingGraph, ways: Ways, people: Mapping[int, int]) -> Indices:
    """The spot of each person who has a way out, shape (P,).

    The first of a room is where the way is longest, the others are spread over the floor; whoever is added takes a new
    spot, so that more people are never out earlier.
    """
    placed = [np.zeros(0, int)]
    for room, count in people.items():
        part = graph.room_spots[room]
        distances = ways.spot_distances[part]
        if not (count and np.isfinite(distances).any()):
            continue
        furthest = int(np.argmax(np.where(np.isfinite(distances), distances, -1)))
        inside = np.flatnonzero(graph.spots_inside[part])
        order = np.argsort(np.arange(1, len(inside) + 1) * GOLDEN % 1, kind="stable")
        # A spot that no door can be reached from has no way; its people take the way of the longest.
        usable = np.where(np.isfinite(distances[inside]), inside, furthest)[order]
        own = np.concatenate([[furthest], usable[np.arange(count - 1) % len(usable)]])
        placed.append(part.start + own)
    return np.concatenate(placed)


def move_people(floor: Floor, graph: WalkingGraph, ways: Ways, people: Mapping[int, int]) -> Movement:
    """Simulate the evacuation: door by door, those farthest from an exit first, as queues depend on earlier ones only.

    people: in each room by its id. All start at once.
    """
    spots = place_people(graph, ways, people)
    rooms = graph.spot_rooms[spots]
    speeds = {room.id: walking_speed(people[room.id] / room.polygon.area) for room in floor.rooms}
    near_sides = ways.next_doors[ways.first[spots]]
    # Walk through their room, as fast as its density allows.
    to_door = ways.spot_distances[spots] - ways.distances[near_sides]
    clock = to_door / np.array([speeds[room] for room in rooms.tolist()]) if len(spots) else np.zeros(0)
    waits, passed, longest = np.zeros(len(spots)), {}, {}
    queues: defaultdict[int, list[Indices]] = defaultdict(list)
    by_side = np.argsort(near_sides, kind="stable")
    sides, starts = np.unique(near_sides[by_side], return_index=True)
    for side, queue in zip(sides.tolist(), np.split(by_side, starts)[1:], strict=True):
        queues[side].append(queue)
    for side in _sort_sides(ways):
        if side not in queues:
            continue
        queue = np.concatenate(queues[side])
        queue = queue[np.argsort(clock[queue], kind="stable")]
        # Pass the door one after the other.
        departures = pass_queue(clock[queue], door_capacity(floor.doors[side // 2].width))
        passed[side // 2], longest[side // 2] = departures, float((departures - clock[queue]).max())
        waits[queue] += departures - clock[queue]
        # Walk on to the next door, or out.
        next_side = int(ways.next_doors[ways.following[side]])
        clock[queue] = departures + (ways.distances[side] - ways.distances[next_side]) / FREE_SPEED
        if ways.following[next_side] >= 0:
            queues[next_side].append(queue)
    return Movement(rooms, clock, waits, passed, longest)


def _sort_sides(ways: Ways) -> list[int]:
    """The near sides of doors on shortest ways, those with the most doors left first."""
    nodes = np.arange(len(ways.following))
    sides = nodes[(ways.next_doors == nodes) & (ways.following >= 0)]
    return sorted(sides.tolist(), key=lambda side: -len(ways.list_doors(side)))
