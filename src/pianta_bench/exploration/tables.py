"""Distances of the policies that predict against the others; and for each set distances, ratios, searches, and time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from pianta_bench.exploration import SYNTHETIC
from pianta_bench.exploration.policies import NEAREST
from pianta_bench.exploration.runs import DECISIONS, SCANS, SECONDS, SHARES, TO_ROOM, RunSettings, name_share
from pianta_bench.exploration.scores import Pairs, compare_policies, compare_sums, find_best, pair_runs
from pianta_bench.harness.records import Figures, Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table

COMPARED_SHARE = 0.9
MAX_NAMES = 12  # in a note
SHARE_LABELS = {name_share(share): f"{100 * share:.0f} %" for share in SHARES}
RATIO = ("ratio", "from", "to")
SUMS = ("sums", "sums from", "sums to")
INTERVAL_LABELS = {"sums": "ratio of\nsums", "sums from": "from\n", "sums to": "to\n"}
INTERVAL_NOTE = "From, to: 95 % of the means when buildings are resampled (bootstrap)."

PREDICTING = Table(
    title="Sections 8.3 and 8.4, {sets}: distances of policies that predict",
    rows=("comparison",),
    columns=("metric",),
    where={"metric": [*RATIO, *SUMS]},
    labels=INTERVAL_LABELS,
    summarise=Cell.only,
    unit="% of the other's",
    notes=("Best: the fewest metres on average of those that do not predict.", INTERVAL_NOTE),
)
DISTANCES = Table(
    title="Distance to a share of the area, {part}",
    rows=("policy",),
    columns=("metric",),
    where={"metric": list(SHARE_LABELS)},
    labels=SHARE_LABELS,
    unit="m",
)
RATIOS = Table(
    title=f"Distance against {NEAREST}, {{part}}",
    rows=("comparison",),
    columns=("metric",),
    where={"metric": list(RATIO)},
    summarise=Cell.only,
    unit="%",
    notes=(INTERVAL_NOTE,),
)
SEARCHES = Table(
    title=f"Search for a room, against {NEAREST}, {{part}}",
    rows=("policy",),
    columns=("metric",),
    where={"metric": ["metres", *RATIO, *SUMS]},
    labels=INTERVAL_LABELS,
    notes=(
        "Ratio, %: the mean over buildings of mean ratios; of sums: of metres.",
        f"Rooms in sight of the start of {NEAREST} count for metres and sums only.",
        INTERVAL_NOTE,
    ),
)
LABELS = Table(
    title="Search by label (searches), {part}",
    rows=("label",),
    columns=("policy",),
    digits=0,
    unit="m",
)
RUNS = Table(
    title="Runs on one core, {part}",
    rows=("policy",),
    columns=("metric",),
    where={"metric": [DECISIONS, SCANS, SECONDS], "label": None},
)


def tabulate(results: Results) -> list[FilledTable]:
    """Policies that predict in all buildings of the data, then for each set distances, ratios, searches, and time."""
    sets = results.options["sets"]
    tables = [tabulate_predicting(results)] if list_policies(results, predicts=True) else []
    for part in sets:
        distances = {
            metric: pair_runs(results.select(part=part, metric=metric), results.options["policies"])
            for metric in SHARE_LABELS
        }
        searches = pair_runs(results.select(part=part, metric=TO_ROOM), results.options["policies"])
        notes = [*describe_set(results, part), *describe_left_out(distances)]
        tables += [
            DISTANCES.fill(derive_distances(results, distances), notes=notes, part=part),
            RATIOS.fill(derive_ratios(results, distances), part=part),
        ]
        if searches.count:
            notes = [
                f"{searches.count} searches in {len(searches.metres)} buildings; the mean of each building first.",
                *name_some("Not all policies succeed, left out", searches.left_out),
            ]
            tables.append(SEARCHES.fill(derive_searches(results, searches), notes=notes, part=part))
            tables.append(LABELS.fill(derive_labels(results, part), part=part))
        tables.append(RUNS.fill(results.select(part=part), notes=[describe_scans(results)], part=part))
    return tables


def tabulate_predicting(results: Results) -> FilledTable:
    """Policies that predict against the best that does not, in schools and offices, or in synthetic floors alone."""
    parts = [part for part in results.options["sets"] if part != SYNTHETIC] or [SYNTHETIC]
    tasks = {f"to {SHARE_LABELS[name_share(COMPARED_SHARE)]}": name_share(COMPARED_SHARE), "to a room": TO_ROOM}
    records: list[Record] = []
    for policy in list_policies(results, predicts=True):
        for task, metric in tasks.items():
            pairs = pair_runs(results.select(part=parts, metric=metric), results.options["policies"])
            best = find_best(pairs, list_policies(results, predicts=False))
            for other in dict.fromkeys([best, NEAREST]) if best else ():
                name = f"{policy}, {task}, against {other}{' (best)' * (other == best)}"
                figures, count = compare(results, pairs, policy, str(other))
                records += name_records(figures, comparison=name + count)
    return PREDICTING.fill(records, sets=" and ".join(parts))


def list_policies(results: Results, *, predicts: bool) -> list[str]:
    """The names of the policies that predict, or of the others."""
    settings: RunSettings = results.objects["settings"]
    return [name for name, policy in settings.policies.items() if policy.predicts is predicts]


def derive_distances(results: Results, distances: dict[str, Pairs]) -> Iterator[Record]:
    """The mean metres to each share of each policy in each building."""
    for policy in results.options["policies"]:
        for metric, pairs in distances.items():
            for metres in pairs.average(policy) or [None]:
                yield {"policy": policy, "metric": metric, "value": metres}


def derive_ratios(results: Results, distances: dict[str, Pairs]) -> Iterator[Record]:
    """The ratios of the distances of each policy to those of the nearest frontier."""
    for metric, pairs in distances.items():
        for policy in results.options["policies"]:
            if policy != NEAREST:
                figures, count = compare(results, pairs, policy, NEAREST)
                yield from name_records(figures, comparison=f"{policy}, to {SHARE_LABELS[metric]}{count}")


def derive_searches(results: Results, searches: Pairs) -> Iterator[Record]:
    """Mean metres until a room was recognised in each building, and ratios to the nearest frontier."""
    for policy in results.options["policies"]:
        for metres in searches.average(policy):
            yield {"policy": policy, "metric": "metres", "value": metres}
        yield from name_records(compare(results, searches, policy, NEAREST)[0], policy=policy)


def derive_labels(results: Results, part: str) -> Iterator[Record]:
    """The metres of all searches for each label; the number of searches stands with the label."""
    records, policies = results.select(part=part, metric=TO_ROOM), results.options["policies"]
    for label in sorted({record["label"] for record in records}):
        pairs = pair_runs([record for record in records if record["label"] == label], policies)
        for tasks in pairs.metres.values():
            for task in tasks:
                for policy in policies:
                    yield {"label": f"{label} ({pairs.count})", "policy": policy, "value": task[policy]}


def compare(results: Results, pairs: Pairs, policy: str, other: str) -> tuple[Figures, str]:
    """RATIO and SUMS of a policy to another, %, and the number of buildings in parentheses; empty for none."""
    figures: dict[str, float | None] = {}
    count = ""
    for metrics, compare_pairs in ((RATIO, compare_policies), (SUMS, compare_sums)):
        interval = compare_pairs(pairs, policy, other, seed=results.options["seed"])
        figures |= dict.fromkeys(metrics)
        if interval:
            values = (100 * value for value in (interval.mean, interval.low, interval.high))
            figures |= dict(zip(metrics, values, strict=True))
            count = f" ({interval.count})"
    return figures, count


def name_records(figures: Figures, **fields: str) -> Iterator[Record]:
    """A record for each figure."""
    for metric, value in figures.items():
        yield {**fields, "metric": metric, "value": value}


def describe_set(results: Results, part: str) -> Iterator[str]:
    """Notes: how many buildings were explored, and which without a model or by no model."""
    runs = [run for run in results.objects["runs"] if run.part == part]
    buildings, starts = {run.building for run in runs}, {(run.building, run.start) for run in runs}
    yield f"{len(buildings)} buildings, {len(starts)} starts; the mean of each building first."
    if list_policies(results, predicts=True):
        count = results.details["without_model"][part]
        if count:
            yield f"{count} without a model: policies that predict have geometry alone."
        reasons = [f"{item}: {reason}" for item, reason in results.details["unmodelled"][part].items()]
        yield from name_some("No model learns from", reasons)


def describe_left_out(distances: dict[str, Pairs]) -> Iterator[str]:
    """Notes: the starts from which not all policies reach a share."""
    for metric, pairs in distances.items():
        yield from name_some(f"Not all reach {SHARE_LABELS[metric]}, left out", pairs.left_out)


def describe_scans(results: Results) -> str:
    """A note: how fast scans are."""
    scans = results.details["scans"]
    numba = "with numba" if scans["numba"] else "without numba, which makes it slow"
    return f"{scans['scans_per_second']:.0f} scans of {scans['beams']} beams a second {numba}."


def name_some(title: str, names: Sequence[str]) -> Iterable[str]:
    """A note with the number of names, then a line for each of the first of them."""
    if not names:
        return []
    more = [f"  and {len(names) - MAX_NAMES} more, which --json lists"] if len(names) > MAX_NAMES else []
    return [f"{title}: {len(names)}", *(f"  {name}" for name in names[:MAX_NAMES]), *more]
