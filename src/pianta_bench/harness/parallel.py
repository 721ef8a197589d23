"""The steps of a bench in several processes, or on a cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, TypeVar

from pianta.batch.processes import Outcome as ItemOutcome
from pianta.batch.processes import run_items
from pianta.batch.run_batch import import_cluster
from pianta.errors import PiantaError
from pianta_bench.harness.records import Track

Outcome = TypeVar("Outcome")
Step = tuple[int, Callable[[], Any]]

# Of the Dask cluster that runs the steps; None to run them here
_SCHEDULER: ContextVar[str | None] = ContextVar("scheduler", default=None)


@contextmanager
def use_scheduler(scheduler: str | None) -> Iterator[None]:
    """Run the steps of benches in the block on a Dask cluster. scheduler: as of `read_batch`."""
    token = _SCHEDULER.set(scheduler)
    try:
        yield
    finally:
        _SCHEDULER.reset(token)


def run_steps(steps: Mapping[str, Callable[[], Outcome]], *, jobs: int | None, track: Track) -> Iterator[Outcome]:
    """The results of the steps, in their order; they do not depend on `jobs`.

    steps: by name; they, their arguments and results must be picklable.
    jobs: number of processes, None for one per core; with 1 all steps run in this process.
    track: wraps the names, to show progress.
    Raises what a step raises, and PiantaError if the process of a step ends twice.
    """
    names, scheduler = [*steps], _SCHEDULER.get()
    processes = min(jobs or os.cpu_count() or 1, max(len(steps), 1))
    if scheduler is None and processes == 1:
        for name, _ in zip(names, track(names), strict=True):
            yield steps[name]()
        return
    items = [*enumerate(steps.values())]
    if scheduler is None:
        outcomes: Iterator[ItemOutcome[Step, _Done]] = run_items(_run_step, items, jobs=processes)
    else:
        outcomes = import_cluster().run_on_cluster(_run_step, items, scheduler=scheduler)
    arrived: dict[int, Any] = {}
    for number, _ in enumerate(track(names)):
        while number not in arrived:
            outcome = next(outcomes)
            arrived[outcome.item[0]] = _take(outcome, names[outcome.item[0]])
        yield arrived.pop(number)


@dataclass(frozen=True)
class _Done:
    """The result of a step, or the exception that it has raised."""

    result: Any = None
    error: Exception | None = None


def _run_step(step: Step) -> _Done:
    """In a process: run a step."""
    try:
        return _Done(step[1]())
    except PiantaError as error:
        return _Done(error=error)


def _take(outcome: ItemOutcome[Step, _Done], name: str) -> Any:  # of any step
    """The result of a step; raises its exception."""
    if outcome.fault is not None or outcome.result is None:
        error = PiantaError(f"step {name}: {outcome.fault.message if outcome.fault else 'no result'}")
        if outcome.fault and outcome.fault.report:
            error.add_note(outcome.fault.report)
        raise error
    if outcome.result.error is not None:
        raise outcome.result.error
    return outcome.result.result
