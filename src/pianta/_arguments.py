"""Checks of arguments of public functions, whose mistakes would otherwise show far from their cause."""

from __future__ import annotations

from pianta.errors import OptionError


def check_argument(value: object, types: type | tuple[type, ...], name: str, remedy: str) -> None:
    """Raise OptionError for an argument, called name, of another type; remedy: such as "a GridMap of read_map"."""
    if not isinstance(value, types):
        raise OptionError(f"{name}= is a {type(value).__name__}, give {remedy}")
