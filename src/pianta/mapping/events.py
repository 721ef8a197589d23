"""Events: what a map update has changed in the building, for people and programs that follow it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import shapely

from pianta.evaluation.coverage import overlap_areas
from pianta.floor import Floor, Room

# A room is in another one if this share of it is. Chosen by hand.
MIN_INSIDE = 0.5
MAX_LISTED = 3  # events of a kind in a line


class EventKind(StrEnum):
    """What has happened."""

    NEW_BUILDING = "new building"
    NEW_ROOM = "room found"
    JOINED_ROOMS = "rooms joined"
    DIVIDED_ROOM = "room divided"
    LOST_ROOM = "room gone"
    COMPLETE_ROOM = "room complete"
    NEW_LABEL = "label changed"
    NEW_TYPE = "type changed"


@dataclass(frozen=True)
class Event:
    """One change of a building.

    Attributes
    ----------
    kind
        What has happened: "new building", "room found", "rooms joined", "room divided", "room gone", "room complete",
        "label changed" or "type changed".
    rooms
        The ids of the rooms: the one that was found, is gone, complete or has another label; those that were joined, or
        into which a room was divided, the one that keeps its id first. Empty for the building.
    before, after
        The label, or the type; None if unknown.
    """

    kind: EventKind
    rooms: tuple[int, ...] = ()
    before: str | None = None
    after: str | None = None

    def __str__(self) -> str:
        """The event as a line."""
        ids = " ".join(map(str, self.rooms))
        change = f": {self.before or 'unknown'} → {self.after or 'unknown'}" if self.before != self.after else ""
        return f"{self.kind} {ids}".strip() + change


def describe_events(events: Sequence[Event]) -> str:
    """Events as one line: those of a kind, or their number if there are many."""
    grouped: dict[EventKind, list[Event]] = {}
    for event in events:
        grouped.setdefault(event.kind, []).append(event)
    return ", ".join(
        f"{len(group)} × {name}" if len(group) > MAX_LISTED else ", ".join(map(str, group))
        for name, group in grouped.items()
    )


def list_events(floor: Floor, previous: Floor, *, is_new_building: bool = False) -> list[Event]:
    """What has changed from the previous floor, whose ids rooms have kept."""
    old, new = (next(iter(each.building_type), None) for each in (previous, floor))
    events = [Event(EventKind.NEW_BUILDING)] if is_new_building else []
    events += [Event(EventKind.NEW_TYPE, (), old, new)] if old != new else []
    return [*events, *_list_room_events(floor, previous)]


def _list_room_events(floor: Floor, previous: Floor) -> Iterator[Event]:
    rooms, old_rooms = ({room.id: room for room in each} for each in (floor, previous))
    joined, divided = _find_joined(rooms, old_rooms), _find_joined(old_rooms, rooms)
    yield from (Event(EventKind.JOINED_ROOMS, (room, *others)) for room, others in joined.items())
    yield from (Event(EventKind.DIVIDED_ROOM, (room, *parts)) for room, parts in divided.items())
    explained = {each for group in (*joined.values(), *divided.values()) for each in group}
    for room in rooms.values():
        old = old_rooms.get(room.id)
        if old is None and room.id not in explained:
            yield Event(EventKind.NEW_ROOM, (room.id,), after=room.label)
        if not room.partial and (old is None or old.partial):
            yield Event(EventKind.COMPLETE_ROOM, (room.id,))
        if old is not None and room.label != old.label:
            yield Event(EventKind.NEW_LABEL, (room.id,), old.label, room.label)
    yield from (
        Event(EventKind.LOST_ROOM, (gone,)) for gone in old_rooms if gone not in rooms and gone not in explained
    )


def _find_joined(rooms: Mapping[int, Room], old_rooms: Mapping[int, Room]) -> dict[int, tuple[int, ...]]:
    """For each room of both floors the old rooms that are gone and lie in it."""
    gone = [room for room in old_rooms.values() if room.id not in rooms]
    if not (gone and rooms):
        return {}
    polygons = [np.array([room.polygon for room in each], dtype=object) for each in (gone, rooms.values())]
    inside = overlap_areas(*polygons) / shapely.area(polygons[0])[:, None]
    joined: dict[int, tuple[int, ...]] = {}
    for old, shares in zip(gone, inside, strict=True):
        room = [*rooms][int(shares.argmax())]
        if shares.max() >= MIN_INSIDE and room in old_rooms:
            joined[room] = (*joined.get(room, ()), old.id)
    return joined
