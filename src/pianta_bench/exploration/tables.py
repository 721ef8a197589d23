"""Distances of the policies that predict against the others; and for each set distances, ratios, searches, and time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, product
from statistics import fmean

from scipy.stats import kendalltau, rankdata

from pianta.labels import SCHOOL
from pianta_bench.exploration import CAMPUS, DRAWN_SET, SYNTHETIC
from pianta_bench.exploration.policies import NEAREST
from pianta_bench.exploration.runs import DECISIONS, SCANS, SECONDS, SHARES, TO_ROOM, name_share
from pianta_bench.exploration.scores import Pairs, compare_policies, compare_sums, find_best, pair_runs
from pianta_bench.harness.records import Record, Results, select_records
from pianta_bench.harness.tables import Cell, FilledTable, Table

COMPARED_SHARE = 0.9
REAL = SCHOOL.building_type  # the set that drawn schools are compared with
MAX_NAMES = 12  # in a note
SHARE_LABELS = {name_share(share): f"{100 * share:.0f} %" for share in SHARES}
RATIO = ("ratio", "from", "to")
SUMS = ("sums", "sums from", "sums to")
SUMS_LABELS = {"sums from": "sums\nfrom", "sums to": "sums\nto"}
INTERVAL_NOTE = "From, to: 95 % of the means when buildings are resampled (bootstrap)."

PREDICTING = Table(
    title="Sections 8.3 and 8.4, {sets}: distances of policies that predict",
    rows=("comparison",),
    columns=("metric",),
    where={"metric": [*RATIO, *SUMS]},
    labels=SUMS_LABELS,
    summarise=Cell.only,
    unit="% of the other's",
    notes=("Best: the fewest metres on average of those that do not predict.", INTERVAL_NOTE),
)
RANKS = Table(
    title="Ranks of policies by mean metres, in real schools and in drawn ones",
    rows=("policy",),
    columns=("column",),
    summarise=Cell.only,
    digits=0,
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
    labels=SUMS_LABELS,
    notes=(
        "Ratio, %: the mean over buildings of mean ratios; sums: the ratio of sums of metres.",
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
    policies = results.options["policies"]
    tables = [tabulate_predicting(results)] if list_policies(results, predicts=True) else []
    if {REAL, DRAWN_SET} <= {*results.options["sets"]}:
        tables.append(tabulate_ranks(results))
    for part in results.options["sets"]:
        own = results.select(part=part)
        distances = {metric: pair_runs(select_records(own, {"metric": metric}), policies) for metric in SHARE_LABELS}
        searches = pair_runs(select_records(own, {"metric": TO_ROOM}), policies)
        notes = [*describe_set(results, part), *describe_left_out(distances)]
        tables.append(DISTANCES.fill(derive_distances(distances, policies), notes=notes, part=part))
        tables.append(RATIOS.fill(derive_ratios(results, distances), part=part))
        if searches.count:
            notes = [
                f"{searches.count} searches in {len(searches.metres)} buildings; the mean of each building first.",
                *name_some("Not all policies succeed, left out", searches.left_out),
            ]
            tables.append(SEARCHES.fill(derive_searches(results, searches), notes=notes, part=part))
            tables.append(LABELS.fill(derive_labels(own, policies), part=part))
        tables.append(RUNS.fill(own, notes=[describe_scans(results)], part=part))
    return tables


def tabulate_predicting(results: Results) -> FilledTable:
    """Policies that predict against the best that does not, in schools and offices, or in the others alone."""
    sets = results.options["sets"]
    parts = [part for part in sets if part not in {SYNTHETIC, DRAWN_SET, CAMPUS}] or [*sets]
    tasks = {f"to {SHARE_LABELS[name_share(COMPARED_SHARE)]}": name_share(COMPARED_SHARE), "to a room": TO_ROOM}
    records: list[Record] = []
    for policy, (task, metric) in product(list_policies(results, predicts=True), tasks.items()):
        pairs = pair_runs(results.select(part=parts, metric=metric), results.options["policies"])
        best = find_best(pairs, list_policies(results, predicts=False))
        for other in dict.fromkeys([best, NEAREST]) if best else ():
            name = f"{policy}, {task}, against {other}{' (best)' * (other == best)}"
            records += compare(results, pairs, policy, str(other), name)
    return PREDICTING.fill(records, sets=" and ".join(parts))


def tabulate_ranks(results: Results) -> FilledTable:
    """The policies in the order of their mean metres to each share, in real schools and in drawn ones."""
    policies = results.options["policies"]
    records: list[Record] = []
    notes = []
    for metric, share in SHARE_LABELS.items():
        ranks = {
            part: rank_policies(pair_runs(results.select(part=part, metric=metric), policies), policies)
            for part in (REAL, DRAWN_SET)
        }
        for part, by_policy in ranks.items():
            records += [
                {"policy": policy, "column": f"{share}\n{part}", "value": by_policy.get(policy)} for policy in policies
            ]
        if all(ranks.values()) and len(policies) > 1:
            tau = kendalltau([ranks[REAL][each] for each in policies], [ranks[DRAWN_SET][each] for each in policies])
            notes.append(f"{share}: Kendall's tau {tau.statistic:.2f}.")
    return RANKS.fill(records, notes=notes)


def rank_policies(pairs: Pairs, policies: Sequence[str]) -> dict[str, float]:
    """The rank of each policy by its mean metres, 1 for the fewest; empty without pairs."""
    if not pairs.metres:
        return {}
    ranks = rankdata([fmean(pairs.average(policy)) for policy in policies], method="min")
    return dict(zip(policies, ranks.tolist(), strict=True))


def list_policies(results: Results, *, predicts: bool) -> list[str]:
    """The names of the policies that predict, or of the others."""
    return [name for name, policy in results.objects["settings"].policies.items() if policy.predicts is predicts]


def derive_distances(distances: Mapping[str, Pairs], policies: Sequence[str]) -> Iterator[Record]:
    """The mean metres to each share of each policy in each building."""
    for policy, (metric, pairs) in product(policies, distances.items()):
        averages: list[float | None] = [*pairs.average(policy)]
        yield from ({"policy": policy, "metric": metric, "value": metres} for metres in averages or [None])


def derive_ratios(results: Results, distances: Mapping[str, Pairs]) -> Iterator[Record]:
    """The ratios of the distances of each policy to those of the nearest frontier."""
    for (metric, pairs), policy in product(distances.items(), results.options["policies"]):
        if policy != NEAREST:
            yield from compare(results, pairs, policy, NEAREST, f"{policy}, to {SHARE_LABELS[metric]}")


def derive_searches(results: Results, searches: Pairs) -> Iterator[Record]:
    """Mean metres until a room was recognised in each building, and ratios to the nearest frontier."""
    for policy in results.options["policies"]:
        for metres in searches.average(policy):
            yield {"policy": policy, "metric": "metres", "value": metres}
        yield from compare(results, searches, policy, NEAREST, policy)


def derive_labels(records: Sequence[Record], policies: Sequence[str]) -> Iterator[Record]:
    """The metres of all searches for each label; the number of searches stands with the label."""
    searches = select_records(records, {"metric": TO_ROOM})
    for label in sorted({record["label"] for record in searches}):
        pairs = pair_runs(select_records(searches, {"label": label}), policies)
        for task in chain.from_iterable(pairs.metres.values()):
            for policy, metres in task.items():
                yield {"label": f"{label} ({pairs.count})", "policy": policy, "value": metres}


def compare(results: Results, pairs: Pairs, policy: str, other: str, name: str) -> Iterator[Record]:
    """RATIO and SUMS of a policy to another, %; the number of buildings stands with the name of the comparison."""
    for metrics, compare_pairs in ((RATIO, compare_policies), (SUMS, compare_sums)):
        interval = compare_pairs(pairs, policy, other, seed=results.options["seed"])
        values = [100 * value for value in (interval.mean, interval.low, interval.high)] if interval else [None] * 3
        comparison = f"{name} ({interval.count})" if interval else name
        for metric, value in zip(metrics, values, strict=True):
            yield {"comparison": comparison, "policy": policy, "metric": metric, "value": value}


def describe_set(results: Results, part: str) -> Iterator[str]:
    """Notes: how many buildings were explored, and which without a model or by no model."""
    starts = {(run.building, run.start) for run in results.objects["runs"] if run.part == part}
    buildings = {building for building, _ in starts}
    yield f"{len(buildings)} buildings, {len(starts)} starts; the mean of each building first."
    yield from results.details["notes"][part]
    if list_policies(results, predicts=True):
        count = sum(building.part == part and not building.others for building in results.objects["buildings"])
        if count:
            yield f"{count} without a model: policies that predict have geometry alone."
        reasons = [f"{item}: {reason}" for item, reason in results.details["unmodelled"][part].items()]
        yield from name_some("No model learns from", reasons)


def describe_left_out(distances: Mapping[str, Pairs]) -> Iterator[str]:
    """Notes: the starts from which not all policies reach a share."""
    for metric, pairs in distances.items():
        yield from name_some(f"Not all reach {SHARE_LABELS[metric]}, left out", pairs.left_out)


def describe_scans(results: Results) -> str:
    """A note: how fast scans are."""
    scans = results.details["scans"]
    numba = "with numba" if scans["numba"] else "without numba, which makes it slow"
    return f"{scans['scans_per_second']:.0f} scans of {scans['beams']} beams a second {numba}."


def name_some(title: str, names: Sequence[str]) -> list[str]:
    """A note with the number of names, then a line for each of the first of them."""
    if not names:
        return []
    more = [f"  and {len(names) - MAX_NAMES} more, which --json lists"] if len(names) > MAX_NAMES else []
    return [f"{title}: {len(names)}", *(f"  {name}" for name in names[:MAX_NAMES]), *more]
