"""Arguments of public functions, checked where a mistake would otherwise show far from its cause."""

from __future__ import annotations

from pianta.errors import OptionError


def check_argument(value: object, kinds: type | tuple[type, ...], name: str, remedy: str) -> None:
    """Raise OptionError for an argument of another type.

    Parameters
    ----------
    value
        What was given.
    kinds
        The types that it may have.
    name
        Of the argument.
    remedy
        What to give, such as "a GridMap of read_map".
    """
    if not isinstance(value, kinds):
        raise OptionError(f"{name}= is a {type(value).__name__}, give {remedy}")
