"""What sampling costs: seconds of each step and iteration, beside a Gram row computed from scratch (Table 7.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import cycle, islice
from statistics import median
from time import perf_counter

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.generation.buildings import BuildingSampler, split_batches
from pianta.generation.type_model import Counts, TypeModel

STEP_1_3, STEP_2, STEP_4 = "steps 1 and 3", "step 2", "step 4"
STEPS = (STEP_1_3, STEP_2, STEP_4)
ITERATIONS = 5
ROW_RUNS, BATCH_RUNS = 51, 5


class Clock(list[Floats]):
    """Takes the traces of chains, and the time of each of their iterations in the place of what they say."""

    def __init__(self) -> None:
        super().__init__()
        self.times: list[float] = []

    def append(self, costs: Floats) -> None:  # noqa: ARG002 - only when matters
        """Note that an iteration has ended."""
        self.times.append(perf_counter())

    def list_seconds(self) -> list[float]:
        """How long each iteration but the first took."""
        return [float(seconds) for seconds in np.diff(self.times)]


@dataclass(frozen=True, eq=False)
class TimedSampler(BuildingSampler):
    """A BuildingSampler that notes how long its steps take.

    steps: seconds of each step, of all buildings together. iterations: seconds of each iteration of each step, over the
    number of buildings side by side.
    """

    steps: dict[str, float] = field(default_factory=lambda: dict.fromkeys(STEPS, 0.0))
    iterations: dict[str, list[float]] = field(default_factory=lambda: {step: [] for step in STEPS})

    def sample_areas(
        self,
        starts: Counts,
        generators: Sequence[np.random.Generator],
        *,
        traces: list[Floats] | None = None,  # noqa: ARG002 - the clock takes them
    ) -> list[list[int]]:
        """See BuildingSampler."""
        with self._timing(STEP_1_3, len(generators)) as clock:
            return super().sample_areas(starts, generators, traces=clock)

    def join_areas(
        self,
        chosen: Sequence[Sequence[int]],
        generators: Sequence[np.random.Generator],
        *,
        traces: list[Floats] | None = None,  # noqa: ARG002
    ) -> list[nx.Graph]:
        """See BuildingSampler."""
        with self._timing(STEP_2, len(generators)) as clock:
            return super().join_areas(chosen, generators, traces=clock)

    def connect_rooms(
        self,
        chosen: Sequence[Sequence[int]],
        functional_graphs: Sequence[nx.Graph],
        generators: Sequence[np.random.Generator],
        *,
        traces: list[Floats] | None = None,  # noqa: ARG002
    ) -> list[nx.Graph]:
        """See BuildingSampler."""
        with self._timing(STEP_4, len(generators)) as clock:
            return super().connect_rooms(chosen, functional_graphs, generators, traces=clock)

    @contextmanager
    def _timing(self, step: str, count: int) -> Iterator[Clock]:
        clock = Clock()
        start = perf_counter()
        yield clock
        self.steps[step] += perf_counter() - start
        self.iterations[step] += [seconds / count for seconds in clock.list_seconds()]


@dataclass(frozen=True)
class SamplingCosts:
    """Seconds of a run that made `count` buildings, `batch` of them side by side.

    total: of the run. steps: of all buildings. iterations: of the median iteration, for one building; None for a step
    of fewer than two.
    full_row: of the Gram row of one graph of mean size against the floors of the model, from scratch; functional_row:
    the same of functional graphs. batch_row: of such a row when those of all buildings are computed at once;
    functional_batch_row: the same of as many functional graphs, those of the floors over and over.
    """

    count: int
    batch: int
    total: float
    steps: dict[str, float]
    iterations: dict[str, float | None]
    full_row: float
    functional_row: float
    batch_row: float
    functional_batch_row: float


def time_sampling(model: TypeModel, count: int, *, seed: int) -> tuple[list[nx.Graph], SamplingCosts]:
    """The buildings that `generate_buildings` makes, and what they cost."""
    start = perf_counter()
    sampler = TimedSampler(model)
    batches = split_batches(count, max(len(floor.graph) for floor in model.floors))
    graphs = [graph for batch in batches for graph in sampler.sample(batch, seed=seed)]
    total = perf_counter() - start
    floors = [floor.graph for floor in model.floors]
    functional = [floor.functional_graph for floor in model.floors]
    return graphs, SamplingCosts(
        count,
        len(batches[0]),
        total,
        sampler.steps,
        {step: median(seconds) if seconds else None for step, seconds in sampler.iterations.items()},
        time_rows(floors, [_find_mean_sized(graphs)], runs=ROW_RUNS),
        time_rows(functional, [_find_mean_sized(functional)], runs=ROW_RUNS),
        time_rows(floors, graphs, runs=BATCH_RUNS),
        time_rows(functional, [*islice(cycle(functional), count)], runs=BATCH_RUNS),
    )


def time_rows(references: Sequence[nx.Graph], graphs: Sequence[nx.Graph], *, runs: int) -> float:
    """Seconds, median of runs, of a graph's row of the WL Gram matrix against references that are read already."""
    from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

    kernel = WeisfeilerLehman(iterations=ITERATIONS).fit(references)
    return _time(lambda: kernel.compare(graphs), runs) / len(graphs)


def _time(work: Callable[[], object], runs: int) -> float:
    seconds = []
    for _ in range(runs):
        start = perf_counter()
        work()
        seconds.append(perf_counter() - start)
    return median(seconds)


def _find_mean_sized(graphs: Sequence[nx.Graph]) -> nx.Graph:
    mean = float(np.mean([len(graph) for graph in graphs]))
    return min(graphs, key=lambda graph: abs(len(graph) - mean))
