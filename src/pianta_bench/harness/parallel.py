"""The same measurement of many inputs, in one process or in several."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from pianta_bench.harness.records import Track

Input = TypeVar("Input")
Output = TypeVar("Output")


def run_all(
    run: Callable[[Input], Output], inputs: Sequence[Input], names: Sequence[str], *, jobs: int, track: Track
) -> Iterator[Output]:
    """The outputs in the order of the inputs. jobs: processes. track: wraps the names, to show progress."""
    if jobs == 1:
        for each, _ in zip(inputs, track(names), strict=True):
            yield run(each)
        return
    from joblib import Parallel, delayed

    outputs = Parallel(n_jobs=jobs, return_as="generator")(delayed(run)(each) for each in inputs)
    for _, output in zip(track(names), outputs, strict=True):
        yield output
