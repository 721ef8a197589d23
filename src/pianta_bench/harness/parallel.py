"""The steps of a bench in several processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from pianta_bench.harness.records import Track

Outcome = TypeVar("Outcome")


def run_steps(steps: Mapping[str, Callable[[], Outcome]], *, jobs: int | None, track: Track) -> Iterator[Outcome]:
    """What the steps return, in their order; it does not depend on `jobs`.

    steps: by name; what they are called with and return goes from process to process, so it can be pickled.
    jobs: number of processes, None for one for each core; with 1 everything is done in this process.
    track: wraps the names, to show progress.
    """
    from joblib import Parallel, cpu_count, delayed

    processes = min(jobs or cpu_count(), max(len(steps), 1))
    outcomes = Parallel(processes, return_as="generator")(delayed(step)() for step in steps.values())
    for _, outcome in zip(track([*steps]), outcomes, strict=True):
        yield outcome
