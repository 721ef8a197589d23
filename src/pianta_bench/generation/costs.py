"""What sampling costs: seconds of each step and iteration, beside a Gram row computed from scratch (Table 7.2)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import wraps
from itertools import cycle, islice
from statistics import median
from time import perf_counter
from typing import Any

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.generation.area_clusters import AreaKernel
from pianta.generation.buildings import BuildingSampler, split_batches
from pianta.generation.type_model import TypeModel

# Metrics.
SECONDS = "seconds"
ITERATION = "seconds of an iteration"
HOPPER_ITERATION = "seconds of an iteration by Graph Hopper"
GRAM_ROW = "seconds of a Gram row"
BATCH = "buildings side by side"
# The work that they are of.
STEP_1_3 = "steps 1 and 3"
STEP_2 = "step 2"
STEP_4 = "step 4"
STEPS = (STEP_1_3, STEP_2, STEP_4)
ALL_STEPS = "all steps"
FLOORS = "row of floors"
FUNCTIONAL = "row of functional graphs"
FLOORS_AT_ONCE = "row of floors, all at once"
FUNCTIONAL_AT_ONCE = "row of functional graphs, all at once"


WL_ITERATIONS = 5  # of the Weisfeiler-Lehman kernel; its default in pianta
ROW_RUNS = 51  # whose median is the time of a row; chosen by hand
HOPPER_BUILDINGS = 10  # sampled by Graph Hopper, which takes long; chosen by hand
BATCH_RUNS = 5  # the same of rows that are computed at once


class Clock(list[Floats]):
    """Stands for the list of the traces of chains, and keeps the time of each iteration instead of the trace."""

    def __init__(self) -> None:
        super().__init__()
        self.times: list[float] = []

    def append(self, costs: Floats) -> None:  # noqa: ARG002 - only the time counts
        """Note that an iteration has ended."""
        self.times.append(perf_counter())

    def list_seconds(self) -> list[float]:
        """How long each iteration but the first took."""
        return [float(seconds) for seconds in np.diff(self.times)]


def _time_step(step: str, method: Callable[..., Any]) -> Any:
    """The method of a TimedSampler that keeps the times of a step. method: takes the generators of buildings last."""

    @wraps(method)
    def timed(self: TimedSampler, *arguments: Any, **options: Any) -> Any:
        clock = Clock()
        start = perf_counter()
        result = method(self, *arguments, **options, traces=clock)
        self.steps[step] += perf_counter() - start
        self.iterations[step] += [seconds / len(arguments[-1]) for seconds in clock.list_seconds()]
        return result

    return timed


@dataclass(frozen=True, eq=False)
class TimedSampler(BuildingSampler):
    """A BuildingSampler that measures how long its steps take.

    steps: seconds of each step, of all buildings together. iterations: seconds of each iteration of each step, over the
    number of buildings side by side.
    """

    steps: dict[str, float] = field(default_factory=lambda: dict.fromkeys(STEPS, 0.0))
    iterations: dict[str, list[float]] = field(default_factory=lambda: {step: [] for step in STEPS})

    sample_areas = _time_step(STEP_1_3, BuildingSampler.sample_areas)
    join_areas = _time_step(STEP_2, BuildingSampler.join_areas)
    connect_rooms = _time_step(STEP_4, BuildingSampler.connect_rooms)

    def renew_areas(self, *arguments: Any, **options: Any) -> list[list[nx.Graph]]:
        """Step 3 goes on; its time counts as that of steps 1 and 3."""
        start = perf_counter()
        areas = super().renew_areas(*arguments, **options)
        self.steps[STEP_1_3] += perf_counter() - start
        return areas


def time_sampling(model: TypeModel, count: int, *, seed: int) -> tuple[list[nx.Graph], dict[tuple[str, str], Any]]:
    """The buildings that `generate_buildings` makes, and what they cost, by metric and work.

    SECONDS: of all buildings. ITERATION: seconds of the median one, for one building; None for a step of fewer than
    two. GRAM_ROW: seconds of the row of one graph of mean size against the floors of the model, or against their
    functional graphs, from scratch; all at once: of such a row where those of all buildings are computed together.
    BATCH: how many buildings are sampled side by side.
    """
    start = perf_counter()
    sampler = TimedSampler(model)
    batches = split_batches(range(count), max(len(floor.graph) for floor in model.floors))
    graphs = [graph for batch in batches for graph in sampler.sample(batch, seed=seed)]
    total = perf_counter() - start
    floors = [floor.graph for floor in model.floors]
    functional = [floor.functional_graph for floor in model.floors]
    as_many = [*islice(cycle(functional), count)]
    return graphs, {
        **{(SECONDS, step): seconds for step, seconds in sampler.steps.items()},
        (SECONDS, ALL_STEPS): total,
        **{(ITERATION, step): median(seconds) if seconds else None for step, seconds in sampler.iterations.items()},
        (GRAM_ROW, FLOORS): time_rows(floors, [_find_mean_sized(graphs)], runs=ROW_RUNS),
        (GRAM_ROW, FUNCTIONAL): time_rows(functional, [_find_mean_sized(functional)], runs=ROW_RUNS),
        (GRAM_ROW, FLOORS_AT_ONCE): time_rows(floors, graphs, runs=BATCH_RUNS),
        (GRAM_ROW, FUNCTIONAL_AT_ONCE): time_rows(functional, as_many, runs=BATCH_RUNS),
        (BATCH, ALL_STEPS): len(batches[0]),
    }


def time_hopper_sampling(model: TypeModel, *, seed: int) -> dict[tuple[str, str], float | None]:
    """HOPPER_ITERATION by step: as ITERATION of `time_sampling`, with the Graph Hopper kernel in steps 2 and 4."""
    sampler = TimedSampler(model, kernel=AreaKernel.GRAPH_HOPPER)
    sampler.sample(range(HOPPER_BUILDINGS), seed=seed)
    return {
        (HOPPER_ITERATION, step): median(seconds) if seconds else None for step, seconds in sampler.iterations.items()
    }


def time_rows(references: Sequence[nx.Graph], graphs: Sequence[nx.Graph], *, runs: int) -> float:
    """Seconds of a graph's row of the WL Gram matrix, median of runs; the kernel already has the references."""
    from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

    kernel = WeisfeilerLehman(iterations=WL_ITERATIONS).fit(references)
    return _time(lambda: kernel.compare(graphs), runs) / len(graphs)


def _time(work: Callable[[], object], runs: int) -> float:
    """Median time of `runs` calls, seconds."""
    seconds = []
    for _ in range(runs):
        start = perf_counter()
        work()
        seconds.append(perf_counter() - start)
    return median(seconds)


def _find_mean_sized(graphs: Sequence[nx.Graph]) -> nx.Graph:
    mean = float(np.mean([len(graph) for graph in graphs]))
    return min(graphs, key=lambda graph: abs(len(graph) - mean))
