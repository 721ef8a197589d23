"""Names and other texts of files, on one line and without what terminals and other programs obey."""

from __future__ import annotations

from pianta.floor import MAX_ROOM_NAME_LENGTH


def clean_name(text: str | None) -> str | None:
    """A name as a room can have it: printable, without blanks around it, at most 200 characters; None if empty."""
    printable = "".join(char if char.isprintable() else " " for char in text or "")
    return " ".join(printable.split())[:MAX_ROOM_NAME_LENGTH].strip() or None


def is_clean(text: str) -> bool:
    """Whether a text is printable and as short as the name of a room."""
    return text.isprintable() and len(text) <= MAX_ROOM_NAME_LENGTH
