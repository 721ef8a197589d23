"""Time of reconstruction, in seconds and in distance transforms of the same map."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from statistics import median
from time import perf_counter

import cv2
import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits  # scikit-learn requires it

from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters
from pianta.layout.reconstruct import reconstruct
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.scan import simulate_map
from pianta_bench.harness.records import Figures

TRANSFORMS = 5  # runs; their median counts
NO_TIME: Figures = {"seconds": None, "transforms": None}
TIME_NOTE = (
    "Time: of reconstruct, with all its steps, on one thread, in seconds, and in exact distance transforms of the "
    "same map (DT), which depends little on the machine."
)
FAILED_NOTE = "A map that failed counts as 0."


def time_reconstruction(grid: GridMap, *, method: str, parameters: Parameters | None = None) -> tuple[Floor, Figures]:
    """The floor of a map, and the time of its reconstruction, in seconds and in exact distance transforms of the map.

    The time of a distance transform is the median of five runs of cv2.distanceTransform on the free cells with the
    precise mask. OpenCV, with its networks, BLAS and OpenMP use one thread.
    """
    _load_method(method)
    free = grid.free.astype(np.uint8)
    with _one_thread():
        start = perf_counter()
        floor = reconstruct(grid, method=method, parameters=parameters)
        seconds = perf_counter() - start
        transform = median(_time_transform(free) for _ in range(TRANSFORMS))
    return floor, {"seconds": seconds, "transforms": seconds / transform}


@cache
def _load_method(method: str) -> None:
    """Run a method once on a small map, since the first run also loads libraries."""
    with suppress(Exception):  # the error will occur again on the maps, and be recorded there
        reconstruct(simulate_map(make_corridor_floor(length=10, room_width=(5, 5))), method=method)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let OpenCV, BLAS and OpenMP use one thread within the context."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        with threadpool_limits(1):
            yield
    finally:
        cv2.setNumThreads(threads)


def _time_transform(free: NDArray[np.uint8]) -> float:
    start = perf_counter()
    cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return perf_counter() - start
