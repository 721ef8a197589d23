"""What the runs of an ExplorationBench say: pairs of runs from the same start, and means over buildings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean

from pianta.evaluation.bootstrap import Interval, bootstrap_mean, bootstrap_ratio
from pianta_bench.exploration.policies import CONTENDERS
from pianta_bench.exploration.runs import FOUND, BuildingRuns, Run, name_share

# What all policies did: by building, by start and by label where there is one, the metres of each policy.
Metres = Mapping[str, Sequence[Mapping[str, float]]]


@dataclass(frozen=True, eq=False)
class Pairs:
    """Metres of runs that all policies brought to their end. left_out: the others, and whose runs are missing."""

    metres: Metres
    left_out: tuple[str, ...]

    @property
    def count(self) -> int:
        """How many starts there are, or searches."""
        return sum(map(len, self.metres.values()))


def pair_share(results: Sequence[BuildingRuns], policies: Sequence[str], share: float) -> Pairs:
    """Metres to a share of the area, from the starts from which all policies reach it."""
    explorations = [(result, [run for run in result.runs if run.label is None]) for result in results]
    return _pair(explorations, policies, name_share(share))


def pair_searches(results: Sequence[BuildingRuns], policies: Sequence[str]) -> Pairs:
    """Metres to the rooms that are looked for, of the searches in which all policies find them."""
    searches = [(result, [run for run in result.runs if run.label is not None]) for result in results]
    return _pair(searches, policies, FOUND)


def _pair(of_buildings: Sequence[tuple[BuildingRuns, Sequence[Run]]], policies: Sequence[str], key: str) -> Pairs:
    metres: dict[str, list[dict[str, float]]] = {}
    left_out = []
    for result, runs in of_buildings:
        tasks: dict[tuple[int, str | None], dict[str, float | None]] = {}
        for run in runs:
            tasks.setdefault((run.start, run.label), {})[run.policy] = run.row.figures.get(key)
        for (start, label), found in tasks.items():
            known = {policy: reached for policy in policies if (reached := found.get(policy)) is not None}
            if len(known) == len(policies):
                metres.setdefault(f"{result.kind} {result.name}", []).append(known)
            else:
                missing = ", ".join(policy for policy in policies if policy not in known)
                left_out.append(f"{result.name} start {start + 1}{f', {label}' if label else ''}: {missing}")
    return Pairs(metres, tuple(left_out))


def average_metres(pairs: Pairs, policy: str) -> list[float]:
    """The mean metres of a policy in each building."""
    return [fmean(task[policy] for task in tasks) for tasks in pairs.metres.values()]


def compare_policies(pairs: Pairs, policy: str, other: str, *, seed: int) -> Interval | None:
    """How long the ways of a policy are, where those of the other are 1: the mean over buildings of mean ratios.

    Ways of the other of 0 m do not count.
    """
    ratios = [[task[policy] / task[other] for task in tasks if task[other] > 0] for tasks in pairs.metres.values()]
    return bootstrap_mean([fmean(of_building) for of_building in ratios if of_building], seed=seed)


def compare_sums(pairs: Pairs, policy: str, other: str, *, seed: int) -> Interval | None:
    """The same as the ratio of sums of the mean metres of buildings."""
    both = zip(average_metres(pairs, policy), average_metres(pairs, other), strict=True)
    known = [(metres, others) for metres, others in both if others > 0]
    return bootstrap_ratio([metres for metres, _ in known], [others for _, others in known], seed=seed)


def find_best(pairs: Pairs, policies: Sequence[str]) -> str | None:
    """The classical policy with the fewest metres on average over buildings; None where nothing is known."""
    classical = [policy for policy in policies if not CONTENDERS[policy].predicts]
    if not pairs.metres or not classical:
        return None
    return min(classical, key=lambda policy: fmean(average_metres(pairs, policy)))
