"""Bootstrap intervals of means over buildings, whose floors and doors resemble each other."""

from __future__ import annotations

from collections.abc import Iterable

from pianta.errors import DataError
from pianta.evaluation.bootstrap import Interval, bootstrap_ratio


def resample_buildings(values: Iterable[tuple[str, float]]) -> Interval:
    """The mean of values, each with its building, and its bootstrap interval; values of a building stay together.

    Raises DataError without values.
    """
    groups: dict[str, list[float]] = {}
    for building, value in values:
        groups.setdefault(building, []).append(value)
    interval = bootstrap_ratio([sum(own) for own in groups.values()], [len(own) for own in groups.values()], seed=0)
    if interval is None:
        raise DataError("there are no figures to compare, give those of one building at least")
    return interval
