"""Processor time of a function."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time
from typing import TypeVar

Outcome = TypeVar("Outcome")


def measure_time(function: Callable[[], Outcome]) -> tuple[float, Outcome]:
    """The processor time of this process in a call, s, and the result of the call."""
    start = process_time()
    outcome = function()
    return process_time() - start, outcome
