"""Comparisons of policies: pairs of runs from the same start, and means over buildings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import TypeAlias

from pianta.evaluation.bootstrap import Interval, bootstrap_mean, bootstrap_ratio
from pianta_bench.harness.records import Record

# A task is a start, or a search from a start. By building, for each task, the metres of each policy.
Metres: TypeAlias = Mapping[str, Sequence[Mapping[str, float]]]


@dataclass(frozen=True, eq=False)
class Pairs:
    """Metres of the tasks that all policies completed. left_out: the other tasks, and which policies did not."""

    metres: Metres
    left_out: tuple[str, ...]

    @property
    def count(self) -> int:
        """The number of tasks."""
        return sum(map(len, self.metres.values()))

    def average(self, policy: str) -> list[float]:
        """The mean metres of a policy in each building."""
        return [fmean(task[policy] for task in tasks) for tasks in self.metres.values()]


def pair_runs(records: Iterable[Record], policies: Sequence[str]) -> Pairs:
    """Pairs of the records of one metric."""
    tasks: dict[tuple[str, str, int, str | None], dict[str, float | None]] = {}
    for record in records:
        task = record["part"], record["building"], record["start"], record["label"]
        tasks.setdefault(task, {})[record["policy"]] = record["value"]
    metres: dict[str, list[dict[str, float]]] = {}
    left_out = []
    for (part, building, start, label), reached in tasks.items():
        complete = {policy: value for policy in policies if (value := reached.get(policy)) is not None}
        if len(complete) == len(policies):
            metres.setdefault(f"{part} {building}", []).append(complete)
        else:
            missing = ", ".join(policy for policy in policies if policy not in complete)
            left_out.append(f"{building} start {start}{f', {label}' if label else ''}: {missing}")
    return Pairs(metres, tuple(left_out))


def compare_policies(pairs: Pairs, policy: str, other: str, *, seed: int) -> Interval | None:
    """The distances of a policy in those of another: the mean over buildings of mean ratios.

    Tasks that take the other 0 m do not count.
    """
    ratios = [[task[policy] / task[other] for task in tasks if task[other] > 0] for tasks in pairs.metres.values()]
    return bootstrap_mean([fmean(building_ratios) for building_ratios in ratios if building_ratios], seed=seed)


def compare_sums(pairs: Pairs, policy: str, other: str, *, seed: int) -> Interval | None:
    """The same as the ratio of sums of the mean metres of buildings."""
    both = zip(pairs.average(policy), pairs.average(other), strict=True)
    positive = [(metres, others) for metres, others in both if others > 0]
    return bootstrap_ratio([metres for metres, _ in positive], [others for _, others in positive], seed=seed)


def find_best(pairs: Pairs, policies: Sequence[str]) -> str | None:
    """The policy with the fewest metres on average over buildings; None without pairs or policies."""
    if not pairs.metres or not policies:
        return None
    return min(policies, key=lambda policy: fmean(pairs.average(policy)))
