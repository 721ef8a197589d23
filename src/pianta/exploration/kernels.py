"""Loops over cells that numba compiles where it is installed; each has a numpy fallback with the same results."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import Any, ParamSpec, TypeVar

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


@cache
def has_numba() -> bool:
    """Whether numba, of the extra pianta[sim], is installed."""
    return find_spec("numba") is not None


def choose_kernel(
    kernel: Callable[Arguments, Result], fallback: Callable[Arguments, Result]
) -> Callable[Arguments, Result]:
    """The kernel compiled by numba, or without numba its fallback; numba is imported here and nowhere earlier."""
    return compile_kernel(kernel) if has_numba() else fallback


@cache
def compile_kernel(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """The kernel compiled by numba; its machine code is kept on disk for the next process."""
    from numba import njit

    compiled: Callable[..., Any] = njit(cache=True, nogil=True)(kernel)
    return compiled
