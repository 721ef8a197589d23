"""Processor time of what is measured."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time
from typing import TypeVar

Made = TypeVar("Made")


def measure_time(make: Callable[[], Made]) -> tuple[float, Made]:
    """The processor time of this process, s, and what was made."""
    start = process_time()
    made = make()
    return process_time() - start, made
