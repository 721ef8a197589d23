"""Processor time of what is measured."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time
from typing import TypeVar

Outcome = TypeVar("Outcome")


def measure_time(make: Callable[[], Outcome]) -> tuple[float, Outcome]:
    """The processor time of this process, s, and what `make` returns."""
    start = process_time()
    outcome = make()
    return process_time() - start, outcome
