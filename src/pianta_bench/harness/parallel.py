"""The steps of a bench in several processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from pianta_bench.harness.records import Track

Outcome = TypeVar("Outcome")


def run_steps(steps: Mapping[str, Callable[[], Outcome]], *, jobs: int | None, track: Track) -> Iterator[Outcome]:
    """The results of the steps, in their order; they do not depend on `jobs`.

    steps: by name; their arguments and results must be picklable.
    jobs: number of processes, None for one per core; with 1 all steps run in this process.
    track: wraps the names, to show progress.
    """
    from joblib import Parallel, cpu_count, delayed

    processes = min(jobs or cpu_count(), max(len(steps), 1))
    outcomes = Parallel(processes, return_as="generator")(delayed(step)() for step in steps.values())
    for _, outcome in zip(track([*steps]), outcomes, strict=True):
        yield outcome
