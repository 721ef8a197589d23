"""How the cost of a method grows: one floor against sixteen of them on one map."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from statistics import median

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from pianta import __version__
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io._files import atomic_file
from pianta.layout.reconstruct import METHODS
from pianta.worlds.floors import make_ring_floor
from pianta.worlds.scan import simulate_map
from pianta_bench.harness.old_report import start_table
from pianta_bench.layout.scores import time_reconstruction

SIDE_CELLS, TILES = 1000, 4
SMALL_RUNS = 3
# What the growth may be, and the memory of the process that reads the large map, MB.
MOST_GROWTH, MOST_MEGABYTES = 1.5, 1500
NOTES = (
    "growth: time of sixteen floors in times of sixteen runs on one; near 1 is linear in the number of cells.",
    f"Bars: growth up to {MOST_GROWTH}, peak below {MOST_MEGABYTES} MB, of a process of its own.",
)


@dataclass(frozen=True)
class Cost:
    """What a method took for a map: its cells and rooms found, seconds, exact distance transforms, peak MB."""

    cells: int
    rooms: int
    seconds: float
    transforms: float
    megabytes: float


@dataclass(frozen=True)
class Growth:
    """The costs of a method on one floor and on many of it."""

    method: str
    tiles: int
    one: Cost
    many: Cost

    @property
    def growth(self) -> float:
        """Time of the many floors in times of as many runs on one."""
        return self.many.seconds / (self.tiles * self.one.seconds)


def measure_cost(
    *,
    methods: Sequence[str] = METHODS,
    side: int = SIDE_CELLS,
    tiles: int = TILES,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> tuple[Growth, ...]:
    """Costs of methods on a made floor of side × side cells, and on tiles × tiles copies of it, unknown space between.

    Each map is read in a process of its own, so that its peak of memory is known. track: as of measure_segmentation.
    """
    jobs = [(method, count) for method in methods for count in (1, tiles)]
    names = [f"{count * count} floors, {method}" for method, count in jobs]
    costs = [_measure_apart(method, side, count) for (method, count), _ in zip(jobs, track(names), strict=True)]
    pairs = zip(methods, costs[::2], costs[1::2], strict=True)
    return tuple(Growth(method, tiles * tiles, one, many) for method, one, many in pairs)


def tile_floor(side: int, tiles: int) -> GridMap:
    """A made floor with a ring corridor and furniture, tiles × tiles times, each side × side cells with its margin."""
    length = side * 0.05 - 13
    grid = simulate_map(make_ring_floor(length=length, width=length), furniture=0.3)
    cells = np.full((side, side), UNKNOWN, np.int8)
    rows, cols = grid.shape
    cells[:rows, :cols] = grid.cells
    return GridMap(np.tile(cells, (tiles, tiles)), grid.resolution)


def show_growths(growths: Sequence[Growth]) -> Group:
    """Two rows a method, and what the figures mean."""
    rows = start_table("cost", "floors", "cells\nmillions", "rooms", "time\ns", "time\nDT", "peak\nMB", "growth")
    for growth in growths:
        for count, cost, ratio in ((1, growth.one, ""), (growth.tiles, growth.many, f"{growth.growth:.2f}")):
            figures = f"{cost.seconds:.2f}", f"{cost.transforms:.0f}", f"{cost.megabytes:.0f}", ratio
            rows.add_row(growth.method, str(count), f"{cost.cells / 1e6:.1f}", str(cost.rooms), *figures)
    lines: list[RenderableType] = [rows, Text(), *map(Text, NOTES)]
    return Group(*lines)


def save_growths(growths: Sequence[Growth], path: str | Path) -> None:
    """Write every figure as JSON; raises PiantaError when the file cannot be written."""
    figures = [{**asdict(growth), "growth": growth.growth} for growth in growths]
    content = {"pianta": __version__, "bench": "cost", "methods": figures, "notes": NOTES}
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def _measure_apart(method: str, side: int, tiles: int) -> Cost:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(_measure_cost, method, side, tiles).result()


def _measure_cost(method: str, side: int, tiles: int) -> Cost:
    import resource

    grid = tile_floor(side, tiles)
    runs = [time_reconstruction(grid, method=method) for _ in range(SMALL_RUNS if tiles == 1 else 1)]
    seconds, transforms = (median(time[key] or 0.0 for _, time in runs) for key in ("seconds", "transforms"))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)
    return Cost(grid.cells.size, len(runs[0][0].rooms), seconds, transforms, peak)
