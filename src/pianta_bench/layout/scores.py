"""What the benches of rooms measure: scores counted in two ways, rooms, and time in distance transforms."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from statistics import median
from time import perf_counter

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta.evaluation.coverage import Scores
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.layout.reconstruct import reconstruct
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.scan import simulate_map
from pianta_bench.harness.table import Column, Figures

TRANSFORMS = 5
TIME_NOTE = (
    "Time: of reconstruct on one thread, in seconds, and in exact distance transforms of the same map (DT), "
    "which depends little on the machine."
)


def name_columns(scores: Sequence[str], headings: Sequence[str]) -> tuple[Column, ...]:
    """Columns of the figures of describe_scores and describe_time."""
    counted = [
        Column(f"{score}_{count}", f"{heading}\n{count}", "%", failed=0.0)
        for count in ("free", "walls")
        for score, heading in zip(scores, headings, strict=True)
    ]
    return (
        *counted,
        Column("mean_iou", "mean\nIoU", "%", failed=0.0),
        Column("f1", "\nF1", "%", failed=0.0),
        Column("found", "rooms\nfound", "rooms", failed=0),
        Column("true", "\ntrue", "rooms"),
        Column("seconds", "time\ns", "s", digits=2),
        Column("transforms", "time\nDT", "exact distance transforms of the same map"),
    )


def compare_counts(scores: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """The keys of the columns of the scores, by the way of counting."""
    counts = {"free cells": "free", "walls counted": "walls"}
    return {name: tuple(f"{score}_{count}" for score in scores) for name, count in counts.items()}


def describe_scores(free: Scores, walls: Scores, scores: Sequence[str]) -> Figures:
    """Figures, in %, of the named scores by both ways of counting, then mean IoU and F1 on free cells, and rooms.

    free: scores on free cells. walls: scores with the walls counted, where no room is lost.
    """
    shares = {f"{score}_free": getattr(free, score) for score in scores}
    shares |= {f"{score}_walls": getattr(walls, score) for score in scores}
    shares |= {"mean_iou": free.mean_iou, "f1": free.f1}
    return {key: 100 * share for key, share in shares.items()} | {"found": walls.found, "true": walls.true}


def time_reconstruction(grid: GridMap, *, method: str) -> tuple[Floor, Figures]:
    """The floor of a map, and how long that took: seconds, and how many exact distance transforms take as long.

    A distance transform is cv2.distanceTransform of the free cells with the precise mask, the median of five. Both
    run on one thread of OpenCV, one after the other.
    """
    _load_method(method)
    free = grid.free.astype(np.uint8)
    with _one_thread():
        start = perf_counter()
        floor = reconstruct(grid, method=method)
        seconds = perf_counter() - start
        transform = median(_time_transform(free) for _ in range(TRANSFORMS))
    return floor, {"seconds": seconds, "transforms": seconds / transform}


@cache
def _load_method(method: str) -> None:
    """Run a method once on a small map: the first run also loads libraries, which is no time of a map."""
    with suppress(Exception):  # the maps will show it
        reconstruct(simulate_map(make_corridor_floor(length=10, room_width=(5, 5))), method=method)


@contextmanager
def _one_thread() -> Iterator[None]:
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def _time_transform(free: NDArray[np.uint8]) -> float:
    start = perf_counter()
    cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return perf_counter() - start
