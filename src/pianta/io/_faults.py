"""Faults of an input as one message: all of them while they are few, else the first and how many more."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import ValidationError

from pianta.io._files import short_repr

MAX_FAULTS_TOLD = 10


def join_faults(faults: Sequence[str]) -> str:
    """The faults on one line, the first ten of them when there are more."""
    told = "; ".join(faults[:MAX_FAULTS_TOLD])
    more = len(faults) - MAX_FAULTS_TOLD
    return f"{told}; and {more} more" if more > 0 else told


def describe_validation(error: ValidationError) -> str:
    """Where each fault is, what pydantic says about it, and the value when it is a scalar."""
    faults = []
    for fault in error.errors(include_url=False):
        text = fault["msg"].removeprefix("Value error, ")
        if fault["loc"]:
            text = f"{_describe_place(fault['loc'])}: {text}"
            if isinstance(fault["input"], str | int | float | None):
                text += f", found {short_repr(fault['input'])}"
        faults.append(text)
    return join_faults(faults)


def _describe_place(keys: tuple[int | str, ...]) -> str:
    """Path to a value, such as features[3].geometry; odd keys are quoted."""
    plain = (key if isinstance(key, str) and key.isidentifier() and len(key) < 50 else None for key in keys)
    steps = (f"[{short_repr(key)}]" if name is None else f".{name}" for key, name in zip(keys, plain, strict=True))
    return "".join(steps).removeprefix(".")
