"""Faults of an input as one message, with the first ten of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from pydantic import ValidationError

from pianta.errors import PiantaError
from pianta.io._files import short_repr

MAX_LISTED_FAULTS = 10


def join_faults(faults: Sequence[str]) -> str:
    """The faults on one line; beyond the first ten only their number."""
    listed = "; ".join(faults[:MAX_LISTED_FAULTS])
    more = len(faults) - MAX_LISTED_FAULTS
    return f"{listed}; and {more} more" if more > 0 else listed


@contextmanager
def validation_as(error: type[PiantaError]) -> Iterator[None]:
    """Raise `error`, which describes every fault, for a ValidationError of pydantic; also a decorator."""
    try:
        yield
    except ValidationError as exception:
        raise error(describe_validation(exception)) from None


def describe_validation(error: ValidationError) -> str:
    """The path to each fault, pydantic's message, and the value if it is a scalar."""
    faults = []
    for fault in error.errors(include_url=False):
        text = fault["msg"].removeprefix("Value error, ")
        if fault["loc"]:
            text = f"{_describe_location(fault['loc'])}: {text}"
            if isinstance(fault["input"], str | int | float | None):
                text += f", found {short_repr(fault['input'])}"
        faults.append(text)
    return join_faults(faults)


def _describe_location(keys: tuple[int | str, ...]) -> str:
    """Path to a value, such as features[3].geometry; keys that are no identifiers are quoted."""
    plain = (key if isinstance(key, str) and key.isidentifier() and len(key) < 50 else None for key in keys)
    steps = (f"[{short_repr(key)}]" if name is None else f".{name}" for key, name in zip(keys, plain, strict=True))
    return "".join(steps).removeprefix(".")
