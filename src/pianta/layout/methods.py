"""The ways in which rooms are found, by name."""

from pianta.errors import OptionError

METHODS = ("thesis",)


def check_method(method: str) -> None:
    """Raise OptionError for the name of no method."""
    if method not in METHODS:
        raise OptionError(f"method is {method!r}, give one of {', '.join(METHODS)}")
