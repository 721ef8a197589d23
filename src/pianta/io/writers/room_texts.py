"""Names and numbers of rooms, as tables and drawings of other programs have them."""

from __future__ import annotations

# A word with a digit is a number, as long as it is as short as those on doors.
MAX_NUMBER = 12  # characters


def split_number(name: str | None) -> tuple[str | None, str | None]:
    """The number of a room, such as 2502C, and the rest of its name; None for what it does not have."""
    words = (name or "").split()
    number = next((word for word in words if any(map(str.isdigit, word)) and len(word) <= MAX_NUMBER), None)
    rest = " ".join(word for word in words if word != number)
    return number, rest or None
