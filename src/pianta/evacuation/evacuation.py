"""The result of an evacuation: rooms with their ways out, doors with their queues, and what a shut door would cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from pianta._types import Floats
from pianta.floor import Floor

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class WayOut:
    """How people leave a room.

    Attributes
    ----------
    room
        The id of the room.
    people
        How many people are in it.
    distance, longest
        From the middle of the room, and from its farthest point, to the nearest exit, metres; 0 in an exit room, inf
        without a way out.
    doors
        The numbers of the doors on the way from the middle, in order.
    line
        The way from the middle, x, y in metres of the map frame, shape (N, 2); empty without one.
    time
        When the last of its people is out, seconds; None without people, or without a way out.
    shared_doors
        The numbers of the doors that are on every way out, sorted.
    shared_rooms
        The ids of the other rooms that are on every way out, sorted.
    dead_end
        From the farthest point to the last shared door, metres: how far one walks before there are two ways out; None
        without a shared door.
    """

    room: int
    people: int
    distance: float
    longest: float
    doors: tuple[int, ...]
    line: Floats
    time: float | None
    shared_doors: tuple[int, ...]
    shared_rooms: tuple[int, ...]
    dead_end: float | None

    @property
    def has_one_way(self) -> bool:
        """Whether one shut door cuts the room off, be it only its own."""
        return bool(self.shared_doors)


@dataclass(frozen=True)
class DoorUse:
    """What happens at a door, and what happens if it is shut.

    Attributes
    ----------
    number
        Of the door in `floor.doors`, counted from 1.
    rooms
        The rooms that it joins, as in `Door`.
    capacity
        People per second.
    people
        How many pass it.
    last
        When the last of them passes, seconds; None if it is not used.
    wait
        The longest wait in its queue, seconds.
    is_shut
        Whether it is shut; the further figures are then those of this evacuation.
    cut_off
        The rooms without a way out if it is shut, beyond those that have none now.
    people_cut_off
        The people in them.
    time_if_shut
        When the last of the others is out if it is shut, seconds.
    longest_if_shut
        The longest way of the others if it is shut, metres.
    """

    number: int
    rooms: tuple[int, int | None]
    capacity: float
    people: int
    last: float | None
    wait: float
    is_shut: bool
    cut_off: tuple[int, ...]
    people_cut_off: int
    time_if_shut: float
    longest_if_shut: float


@dataclass(frozen=True, eq=False)
class Evacuation:
    """How a floor is evacuated: ways, rooms with one way out, times with queues, and what a shut door costs.

    Attributes
    ----------
    floor
        The floor.
    exit_rooms
        Ids of the rooms that lead out, sorted.
    exit_doors
        Numbers of the entrances that lead out, sorted; a number is the place in `floor.doors`, counted from 1.
    ways
        One for each room, in the order of the floor.
    doors
        One for each door, in the order of the floor.
    time
        When the last person is out, seconds, without those that have no way out.
    time_without_queues
        The same if people did not have to wait at doors, seconds.
    """

    floor: Floor
    exit_rooms: tuple[int, ...]
    exit_doors: tuple[int, ...]
    ways: tuple[WayOut, ...]
    doors: tuple[DoorUse, ...]
    time: float
    time_without_queues: float

    @property
    def people(self) -> int:
        """All people on the floor."""
        return sum(way.people for way in self.ways)

    @property
    def cut_off(self) -> tuple[int, ...]:
        """The ids of the rooms without a way out."""
        return tuple(way.room for way in self.ways if way.longest == float("inf"))

    @property
    def longest(self) -> WayOut:
        """The room with the longest way out, of those that have one."""
        return max((way for way in self.ways if way.longest < float("inf")), key=lambda way: way.longest)

    @property
    def one_way(self) -> tuple[int, ...]:
        """The ids of the rooms that one shut door cuts off, be it only their own."""
        return tuple(way.room for way in self.ways if way.has_one_way)

    @property
    def dead_ends(self) -> tuple[int, ...]:
        """The ids of the rooms that a shut door elsewhere cuts off: behind their own door there is still one way."""
        own = {door.number: door.rooms for door in self.doors}
        return tuple(way.room for way in self.ways if any(way.room not in own[number] for number in way.shared_doors))

    def rank_doors(self) -> list[DoorUse]:
        """The doors by what it costs if one is shut, the worst first.

        Returns
        -------
        list of DoorUse
            By people cut off, then rooms cut off, then the time of the others.
        """
        usable = [door for door in self.doors if not door.is_shut]
        return sorted(usable, key=lambda door: (-door.people_cut_off, -len(door.cut_off), -door.time_if_shut))

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw rooms by their distance to the exit, ways, exits, shut doors and dead ends.

        Parameters
        ----------
        ax
            Where to draw, in metres of the map frame; a new figure if None.

        Returns
        -------
        Axes
            The ax with the drawing; nothing is shown.
        """
        from pianta.plot.evacuation import plot_evacuation

        return plot_evacuation(self, ax=ax)

    def as_json(self) -> dict[str, object]:
        """The result without shapes, in types that JSON can hold.

        Returns
        -------
        dict
            The content of evacuation.json; lengths in metres, times in seconds, None for what does not exist.
        """
        return {
            "source": self.floor.source,
            "people": self.people,
            "exit_rooms": [*self.exit_rooms],
            "exit_doors": [*self.exit_doors],
            "time": round(self.time, 1),
            "time_without_queues": round(self.time_without_queues, 1),
            "longest_way": _round(self.longest.longest),
            "cut_off": [*self.cut_off],
            "one_way": [*self.one_way],
            "dead_ends": [*self.dead_ends],
            "rooms": [self._describe_way(way) for way in self.ways],
            "doors": [_describe_door(door) for door in self.doors],
        }

    def _describe_way(self, way: WayOut) -> dict[str, object]:
        room = self.floor[way.room]
        return {
            "room": way.room,
            "label": room.label,
            "area": round(room.polygon.area, 2),
            "people": way.people,
            "distance": _round(way.distance),
            "longest": _round(way.longest),
            "doors": [*way.doors],
            "line": way.line.round(3).tolist(),
            "time": None if way.time is None else round(way.time, 1),
            "shared_doors": [*way.shared_doors],
            "shared_rooms": [*way.shared_rooms],
            "dead_end": None if way.dead_end is None else _round(way.dead_end),
        }


def _describe_door(door: DoorUse) -> dict[str, object]:
    values: Mapping[str, object] = asdict(door)
    return {name: round(value, 2) if isinstance(value, float) else value for name, value in values.items()}


def _round(metres: float) -> float | None:
    return round(metres, 2) if metres < float("inf") else None
