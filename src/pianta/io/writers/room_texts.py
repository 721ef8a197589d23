"""Names and numbers of rooms, as tables and drawings of other programs have them."""

from __future__ import annotations

import shapely

from pianta.building import Storey
from pianta.floor import Room

# A word with a digit is a number, as long as it is as short as those on doors.
MAX_NUMBER = 12  # characters
TEXT_TOLERANCE = 0.1  # metres


def split_number(name: str | None) -> tuple[str | None, str | None]:
    """The number of a room, such as 2502C, and the rest of its name; None for what it does not have."""
    words = (name or "").split()
    number = next((word for word in words if any(map(str.isdigit, word)) and len(word) <= MAX_NUMBER), None)
    rest = " ".join(word for word in words if word != number)
    return number, rest or None


def number_and_name(room: Room) -> tuple[str | None, str | None]:
    """The number and the name of a room, from its name if the number stands there; None for what it does not have."""
    if room.number is None:
        return split_number(room.name)
    return room.number, None if room.name == room.number else room.name


def place_text(room: Room) -> tuple[float, float, float]:
    """Where the text of a room is: x and y of the middle of its largest circle, and the radius of that; metres."""
    circle = shapely.maximum_inscribed_circle(room.polygon, TEXT_TOLERANCE)
    (x, y), _ = shapely.get_coordinates(circle)
    return float(x), float(y), float(circle.length)


def title_storey(storey: Storey) -> str:
    """What people call a storey, else its name."""
    return storey.title or storey.name
