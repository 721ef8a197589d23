"""An ExplorationBench in tables: the bars, metres, ratios, searches, and time, for each set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pianta.evaluation.bootstrap import Interval
from pianta_bench.exploration.buildings import SYNTHETIC
from pianta_bench.exploration.measure import ExplorationBench
from pianta_bench.exploration.policies import CONTENDERS, NEAREST
from pianta_bench.exploration.runs import DECISIONS, SCANS, SECONDS, SHARES, BuildingRuns
from pianta_bench.exploration.scores import (
    average_metres,
    compare_policies,
    compare_sums,
    find_best,
    pair_searches,
    pair_share,
)
from pianta_bench.harness.comparison import Cell, ComparisonRow, ComparisonTable

BAR_SHARE, MAX_NAMED = 0.9, 12
INTERVAL = ("ratio", "from", "to")
MEANT = "From, to: 95 % of the means when buildings are drawn again (bootstrap)."


def tabulate_exploration(bench: ExplorationBench) -> tuple[ComparisonTable, ...]:
    """The bars over all buildings of the data, then for each set metres, ratios, searches, and time."""
    tables = [tabulate_bars(bench)] if _list_predicting(bench) else []
    for kind, results in bench.results.items():
        tables += [tabulate_metres(bench, kind, results), tabulate_ratios(bench, kind, results)]
        if pair_searches(results, bench.settings.policies).count:
            tables += [tabulate_searches(bench, kind, results), tabulate_labels(bench, kind, results)]
        tables.append(tabulate_time(bench, kind, results))
    return tuple(tables)


def tabulate_bars(bench: ExplorationBench) -> ComparisonTable:
    """What predicts against the best that does not, over schools and offices, or over synthetic floors alone."""
    policies, seed = bench.settings.policies, bench.settings.seed
    real = [result for kind, results in bench.results.items() if kind != SYNTHETIC for result in results]
    results = real or [result for results in bench.results.values() for result in results]
    sets = [kind for kind in bench.results if kind != SYNTHETIC] or [SYNTHETIC]
    tasks = {
        f"to {100 * BAR_SHARE:.0f} %": pair_share(results, policies, BAR_SHARE),
        "to a room": pair_searches(results, policies),
    }
    rows = []
    for ours in _list_predicting(bench):
        for task, pairs in tasks.items():
            best = find_best(pairs, policies)
            for other in dict.fromkeys([best, NEAREST]) if best else ():
                against = f"{ours}, {task}, against {other}{' (best)' * (other == best)}"
                mean = compare_policies(pairs, ours, str(other), seed=seed)
                rows.append(_interval_row(against, mean))
                rows.append(_interval_row(f"{against}, sums", compare_sums(pairs, ours, str(other), seed=seed)))
    notes = (
        "Best: the fewest metres on average of those that do not predict.",
        f"Bars: to {100 * BAR_SHARE:.0f} % below 90 and its interval below 100; to a room below 75.",
        MEANT,
    )
    title = f"Sections 8.3 and 8.4, {' and '.join(sets)}: ways of what predicts"
    return ComparisonTable(title, INTERVAL, tuple(rows), notes, "% of the other's")


def tabulate_metres(bench: ExplorationBench, kind: str, results: Sequence[BuildingRuns]) -> ComparisonTable:
    """Metres to each share of the area."""
    policies = bench.settings.policies
    pairs = {share: pair_share(results, policies, share) for share in SHARES}
    rows = [
        ComparisonRow(policy, tuple(Cell.over(average_metres(of, policy)) for of in pairs.values()))
        for policy in policies
    ]
    explored = [result for result in results if result.points]
    starts = sum(len(result.points) for result in explored)
    notes = [
        f"{len(explored)} buildings, {starts} starts; the mean of the starts of each building first.",
        *_tell_sets(bench, kind),
    ]
    for share, of in pairs.items():
        notes += name_some(f"Not all reach {100 * share:.0f} %, left out", of.left_out)
    columns = tuple(f"{100 * share:.0f} %" for share in SHARES)
    return ComparisonTable(f"Way to a share of the area, {kind}", columns, tuple(rows), tuple(notes), "m")


def tabulate_ratios(bench: ExplorationBench, kind: str, results: Sequence[BuildingRuns]) -> ComparisonTable:
    """How long the ways of each policy are, where those of the nearest frontier are 100 %."""
    policies, seed = bench.settings.policies, bench.settings.seed
    rows = []
    for share in SHARES:
        pairs = pair_share(results, policies, share)
        rows += [
            _interval_row(f"{policy}, to {100 * share:.0f} %", compare_policies(pairs, policy, NEAREST, seed=seed))
            for policy in policies
            if policy != NEAREST
        ]
    return ComparisonTable(f"Way against {NEAREST}, {kind}", INTERVAL, tuple(rows), (MEANT,), "%")


def tabulate_searches(bench: ExplorationBench, kind: str, results: Sequence[BuildingRuns]) -> ComparisonTable:
    """Metres until a room of a label is recognised, and against the nearest frontier."""
    policies, seed = bench.settings.policies, bench.settings.seed
    pairs = pair_searches(results, policies)
    rows = []
    for policy in policies:
        metres = Cell.over(average_metres(pairs, policy))
        both = (
            compare_policies(pairs, policy, NEAREST, seed=seed),
            compare_sums(pairs, policy, NEAREST, seed=seed),
        )
        cells = [cell for interval in both for cell in _interval_cells(interval)]
        rows.append(ComparisonRow(policy, (metres, *cells)))
    notes = (
        f"{pairs.count} searches in {len(pairs.metres)} buildings; the mean of those of each building first.",
        "Ratio, %: the mean over buildings of mean ratios; sums: of metres. Rooms in",
        f"sight of the start of {NEAREST} count for metres and sums alone.",
        *name_some("Not all find it, left out", pairs.left_out),
        MEANT,
    )
    columns = ("metres", *INTERVAL, "sums", "from ", "to ")
    return ComparisonTable(f"Search for a room, against {NEAREST}, {kind}", columns, tuple(rows), notes)


def tabulate_labels(bench: ExplorationBench, kind: str, results: Sequence[BuildingRuns]) -> ComparisonTable:
    """Metres of all searches for each label, alike."""
    policies = bench.settings.policies
    complete: dict[str, list[Mapping[str, float]]] = {}
    for result in results:
        for label in dict.fromkeys(run.label for run in result.runs if run.label):
            runs = tuple(run for run in result.runs if run.label == label)
            found = pair_searches([BuildingRuns(result.kind, result.name, result.points, runs)], policies)
            complete.setdefault(label, []).extend(task for tasks in found.metres.values() for task in tasks)
    rows = [
        ComparisonRow(
            f"{label} ({len(tasks)})", tuple(Cell.over([task[policy] for task in tasks]) for policy in policies), 0
        )
        for label, tasks in sorted(complete.items())
        if tasks
    ]
    return ComparisonTable(f"Search by label (searches), {kind}", tuple(policies), tuple(rows), unit="m")


def tabulate_time(bench: ExplorationBench, kind: str, results: Sequence[BuildingRuns]) -> ComparisonTable:
    """Decisions, scans and seconds of the processor for a run through a whole building."""
    keys = {DECISIONS: DECISIONS, SCANS: SCANS, SECONDS: "seconds"}
    rows = []
    for policy in bench.settings.policies:
        figures = [
            run.row.figures for result in results for run in result.runs if run.policy == policy and run.label is None
        ]
        rows.append(ComparisonRow(policy, tuple(Cell.over([row[key] for row in figures]) for key in keys)))
    by = "with numba" if bench.scans.numba else "without numba, which makes it slow"
    notes = (f"{bench.scans.scans_a_second:.0f} scans of {bench.scans.beams} beams a second {by} (bar: 2000).",)
    return ComparisonTable(f"Runs on one core, {kind}", tuple(keys.values()), tuple(rows), notes)


def name_some(what: str, names: Sequence[str]) -> list[str]:
    """A note with how many there are, then a line for each of the first of them."""
    if not names:
        return []
    more = [f"  and {len(names) - MAX_NAMED} more, which --json lists"] if len(names) > MAX_NAMED else []
    return [f"{what}: {len(names)}", *(f"  {name}" for name in names[:MAX_NAMED]), *more]


def _tell_sets(bench: ExplorationBench, kind: str) -> list[str]:
    """What no model learns from, and what is explored without a model."""
    of = bench.sets[kind]
    alone = sum(not building.others for building in of.buildings)
    told = [f"{alone} without a model: what predicts has geometry alone."] if alone and _list_predicting(bench) else []
    unmodelled = [f"{row.item}: {row.failure}" for row in of.unmodelled] if _list_predicting(bench) else []
    return told + name_some("No model learns from", unmodelled)


def _list_predicting(bench: ExplorationBench) -> list[str]:
    return [policy for policy in bench.settings.policies if CONTENDERS[policy].predicts]


def _interval_row(name: str, interval: Interval | None) -> ComparisonRow:
    counted = f" ({interval.count})" if interval else ""
    return ComparisonRow(f"{name}{counted}", _interval_cells(interval))


def _interval_cells(interval: Interval | None) -> tuple[Cell, Cell, Cell]:
    if interval is None:
        return Cell(None), Cell(None), Cell(None)
    mean, low, high = (100 * figure for figure in (interval.mean, interval.low, interval.high))
    return Cell(mean, count=interval.count), Cell(low), Cell(high)
