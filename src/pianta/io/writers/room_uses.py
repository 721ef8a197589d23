"""What our labels of rooms are called in OpenStreetMap and in IMDF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType

from pianta.floor import Room

# Words of labels, of which the first that a label has counts: the value of OpenStreetMap's key `room`, and the category
# of a unit in IMDF, "" without one.
_USES = MappingProxyType(
    {
        "ELEVATOR": ("elevator", "elevator"),
        "STAIRS": ("stairs", "stairs"),
        "TOILET": ("toilets", "restroom"),
        "WASHROOM": ("toilets", "restroom"),
        "BATHROOM": ("bathroom", "restroom"),
        "CLASSROOM": ("classroom", "classroom"),
        "LAB": ("laboratory", "laboratory"),
        "LIBRARY": ("library", "library"),
        "AUDITORIUM": ("auditorium", "auditorium"),
        "GYM": ("gym", "recreation"),
        "CAFETERIA": ("canteen", "foodservice"),
        "CANTEEN": ("canteen", "foodservice"),
        "KITCHEN": ("kitchen", "kitchen"),
        "CONFERENCE": ("conference", "conferenceroom"),
        "OFFICE": ("office", "office"),
        "OPENSPACE": ("office", "office"),
        "CUBICULE": ("office", "office"),
        "ADMINISTRATIVE": ("administration", "office"),
        "RECEPTION": ("reception", "lobby"),
        "LOBBY": ("lobby", "lobby"),
        "ENTRANCE": ("entrance", "lobby"),
        "ENTRYWAY": ("entrance", "lobby"),
        "WAITING": ("waiting", "waitingroom"),
        "STORAGE": ("storage", "storage"),
        "CLOSET": ("storage", "storage"),
        "WARDROBE": ("locker", "storage"),
        "CHANGING": ("locker", "lockerroom"),
        "GARAGE": ("garage", "parking"),
        "TERRACE": ("", "terrace"),
        "BALCONY": ("", "terrace"),
        "BEDROOM": ("bedroom", ""),
        "LIVING": ("living", ""),
        "DINING": ("dining_room", ""),
        "LAUNDRY": ("laundry", "laundryroom"),
        "BOILER": ("technical", "mechanicalroom"),
        "TECHNICAL": ("technical", "mechanicalroom"),
        "UTILITY": ("technical", "mechanicalroom"),
        "CORRIDOR": ("", "walkway"),
        "HALLWAY": ("", "walkway"),
        "HALL": ("hall", "lobby"),
    }
)
CORRIDORS = ("CORRIDOR", "HALLWAY")


def find_osm_use(room: Room) -> str:
    """The value of the key `room`; "" for a corridor and for a label without one."""
    return next((_USES[word][0] for word in _list_known(room)), "")


def find_imdf_category(room: Room) -> str:
    """The category of the unit of a room; "room" for another label, and "unspecified" without one."""
    other = "unspecified" if room.label is None else "room"
    return next((_USES[word][1] or other for word in _list_known(room)), other)


def is_corridor(room: Room) -> bool:
    """Whether people walk through the room to others."""
    return any(word in CORRIDORS for word in _list_words(room))


def count_uses() -> Mapping[str, tuple[str, str]]:
    """All known words with their two uses."""
    return _USES


def _list_known(room: Room) -> Iterator[str]:
    # The last word of a label says what the room is: EXECUTIVE OFFICE is an OFFICE
    return (word for word in reversed(_list_words(room)) if word in _USES)


def _list_words(room: Room) -> list[str]:
    return [*(room.label or "").split(), *(label for label in room.labels.values() if label in CORRIDORS)]
