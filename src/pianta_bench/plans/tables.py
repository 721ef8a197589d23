"""Figures of each plan, of the kinds of plans, with and without symbols, and of the names on drawn sheets."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from statistics import fmean
from typing import Any

from pianta_bench.harness.records import Record, Results, select_records
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.plans.measure import READINGS, WITH, WITHOUT
from pianta_bench.plans.plan_sets import KINDS, SCREENSHOT
from pianta_bench.plans.scores import SCORES
from pianta_bench.plans.text import EXACT, EXACT_SHARE, NAME_COUNT, NAMED_SHARE, PART

MAIN_METRICS = (*SCORES, "doors_f1", "edges_f1")
LABELS = {
    "a_fc": "A_FC",
    "a_bc": "A_BC",
    "precision": "prec.",
    "recall": "recall",
    "mean_iou": "IoU",
    "f1": "F1",
    "doors_f1": "doors\nf1",
    "edges_f1": "edges\nf1",
    "found": "rooms\nfound",
    "true": "rooms\ntrue",
    "floors": "floors",
    "unmatched": "unmatched",
    "scale_error": "scale\nerror",
    "seconds": "time\ns",
}
BUILDINGS = ("school", "office")
OTHER_KINDS = list(KINDS[: KINDS.index(SCREENSHOT)])
# What counts in the means of real plans.
REPRESENTATIVE: dict[str, Any] = {"is_sound": True, "kind": OTHER_KINDS, "building_type": BUILDINGS, "reading": WITH}
LARGE = 2.0  # million pixels; smaller plans say little of the time for a large one
LARGE_SIZE = 6.0  # million pixels of the plan for which the time is estimated
UNSOUND = "*"

PLANS = Table(
    title=f"{{title}}, each, {WITH}",
    rows=("item",),
    columns=("metric",),
    where={"metric": list(LABELS), "reading": WITH},
    labels=LABELS,
    summarise=Cell.only,
    digits=0,
    unit="%",
    notes=(
        "doors: within half the width of a true one, entrances left out; edges: pairs of rooms that doors join.",
        "unmatched: % of the area in floors of the sheet that the truth does not have, which do not count.",
        "scale error: of metres per pixel; annotators of real plans estimated the width of a door by eye.",
    ),
)
GROUPS = Table(
    title=f"Kinds of plans, {WITH}",
    rows=("group",),
    columns=("metric",),
    where={"metric": list(MAIN_METRICS)},
    labels=LABELS,
    unit="%",
    notes=("Kinds by the look of a plan; all: schools and offices with a sound truth, no screenshots.",),
)
SYMBOLS = Table(
    title="{title} that draw their doors ({count}), with and without symbols",
    rows=("reading",),
    columns=("metric",),
    where={"metric": list(MAIN_METRICS), "reading": [*READINGS, "difference"]},
    labels=LABELS,
    unit="%",
)
SUMMARY = Table(
    title="Schools and offices with a sound truth",
    columns=("figure",),
    summarise=Cell.only,
    notes=(f"Seconds: the slowest of the plans above {LARGE:g} million pixels, in proportion.",),
)
NAMES = Table(
    title="Names of rooms on synthetic plans, {font}",
    rows=("item",),
    columns=("metric",),
    where={"part": PART},
    labels={
        NAME_COUNT: "names",
        EXACT: "read\nexactly",
        EXACT_SHARE: "% read\nexactly",
        NAMED_SHARE: "% rooms with\na name",
    },
    summarise=Cell.only,
    digits={NAME_COUNT: 0, EXACT: 0},
    summaries=("mean", "sd", "median"),
)
EXACT_NAMES = Table(
    title="Names on synthetic plans that are read exactly",
    rows=("sheets",),
    columns=("metric",),
    summarise=Cell.only,
    unit="% of names",
    notes=(
        "exactly: letter by letter, with capitals, accents and blanks.",
        "Names of schools and offices in English, Italian, German, French and Spanish, black on white, each in a room.",
    ),
)


def tabulate(results: Results) -> list[FilledTable]:
    """All tables of the sets that were measured."""
    tables = []
    real, synthetic = (results.select(set=part) for part in ("real", "drawn"))
    if real:
        tables += [tabulate_plans(results, real, title="Plans"), GROUPS.fill(derive_groups(real))]
        tables += [tabulate_symbols(real, title="Plans"), tabulate_summary(results, real)]
    if synthetic:
        failure = results.details.get("text_failure")
        notes = [f"Names on drawn plans were not read: {failure}"] * bool(failure)
        tables.append(tabulate_plans(results, synthetic, title="Drawn plans", summaries=("mean", "sd")))
        tables.append(tabulate_symbols(synthetic, title="Drawn plans", notes=notes))
    names = results.select(part=PART)
    if names:
        fonts = dict.fromkeys(record["font"] for record in names)
        tables += [NAMES.fill(results.select(part=PART, font=font), font=font) for font in fonts]
        tables.append(EXACT_NAMES.fill(derive_exact_names(names)))
    return tables


def tabulate_plans(
    results: Results, records: Sequence[Record], *, title: str, summaries: tuple[str, ...] = ()
) -> FilledTable:
    """A row for each plan, kind by kind; those without a sound truth have UNSOUND."""
    kinds = [*KINDS, *{record["kind"] for record in records}.difference(KINDS)]
    records = sorted(records, key=lambda record: (kinds.index(record["kind"]), record["item"]))
    defects = {plan["plan"]: plan["defects"] for plan in results.details["plans"] if plan.get("defects")}
    unsound = [item for item in dict.fromkeys(record["item"] for record in records) if item in defects]
    notes = [f"{UNSOUND} {item}: the truth {', '.join(defects[item])}." for item in unsound]
    notes += ["A plan that failed counts as 0, one without a truth does not count."] * results.failed
    starred = ({**record, "item": record["item"] + UNSOUND * (not record["is_sound"])} for record in records)
    return replace(PLANS, summaries=summaries).fill(starred, notes=notes, title=title)


def derive_groups(records: Sequence[Record]) -> Iterator[Record]:
    """The records of each kind of drawing and of building with a sound truth, of all, and of those left apart."""
    groups: dict[str, dict[str, Any]] = {
        **{plan_kind: {**REPRESENTATIVE, "kind": plan_kind} for plan_kind in OTHER_KINDS},
        **{f"{name}s": {**REPRESENTATIVE, "building_type": name} for name in BUILDINGS},
        "all": REPRESENTATIVE,
        "all, median": REPRESENTATIVE,
        "apart: truth not sound": {"is_sound": False, "reading": WITH},
        "apart: screenshots": {"kind": SCREENSHOT, "reading": WITH},
    }
    for group, where in groups.items():
        chosen = select_records(records, {**where, "metric": MAIN_METRICS})
        name = f"{group} ({len({record['item'] for record in chosen})})"
        if group != "all, median":
            yield from ({**record, "group": name} for record in chosen)
            continue
        for metric in MAIN_METRICS if chosen else ():
            value = Cell.median(record["value"] for record in chosen if record["metric"] == metric).mean
            yield {"group": name, "metric": metric, "value": value}


def tabulate_symbols(records: Sequence[Record], *, title: str, notes: Sequence[str] = ()) -> FilledTable:
    """Both readings of the plans that draw their doors and have a sound truth, and their differences."""
    kinds = [record["kind"] for record in records if record["kind"] != SCREENSHOT]
    drawing = select_records(records, {"draws_doors": True, "is_sound": True, "kind": kinds})
    better, equal = count_better(drawing)
    count = len({record["item"] for record in drawing})
    note = (
        f"Better with symbols, by the mean of A_FC and A_BC, on {better} of {count} plans; "
        f"equal, which does not count as better, on {equal}."
    )
    return SYMBOLS.fill([*drawing, *derive_differences(drawing)], notes=[note, *notes], title=title, count=count)


def derive_differences(records: Sequence[Record]) -> Iterator[Record]:
    """For each plan and metric the figure with symbols less that without."""
    others = {(each["item"], each["metric"]): each["value"] for each in records if each["reading"] == WITHOUT}
    for record in select_records(records, {"reading": WITH}):
        other = others[record["item"], record["metric"]]
        if record["value"] is not None and other is not None:
            yield {**record, "reading": "difference", "value": record["value"] - other}


def count_better(records: Sequence[Record]) -> tuple[int, int]:
    """The number of plans that are read better with symbols, by the mean of A_FC and A_BC, and of equal ones."""
    accuracies: dict[str, dict[str, list[float]]] = {}
    for record in select_records(records, {"metric": ["a_fc", "a_bc"]}):
        accuracies.setdefault(record["item"], {}).setdefault(record["reading"], []).append(record["value"])
    pairs = [(fmean(readings[WITH]), fmean(readings[WITHOUT])) for readings in accuracies.values()]
    return sum(one > other for one, other in pairs), sum(one == other for one, other in pairs)


def tabulate_summary(results: Results, records: Sequence[Record]) -> FilledTable:
    """Means and medians of the representative plans, and the time for a large plan."""
    sound = select_records(records, {**REPRESENTATIVE, "reading": list(READINGS)})
    drawing = select_records(sound, {"draws_doors": True})
    plans, drawing_plans = (len({record["item"] for record in chosen}) for chosen in (sound, drawing))
    figures: dict[str, float | None] = {}
    for metric, name, chosen in (("a_fc", "A_FC", sound), ("a_bc", "A_BC", sound), ("doors_f1", "doors F1", drawing)):
        values = [record["value"] for record in select_records(chosen, {"metric": metric, "reading": WITH})]
        figures |= {f"{name}, median": Cell.median(values).mean, f"{name}, mean": Cell.over(values).mean}
    better, _ = count_better(drawing)
    figures["better with symbols, % of plans"] = 100 * better / drawing_plans if drawing_plans else None
    figures[f"seconds for {LARGE_SIZE:g} million pixels"] = estimate_time(records)
    figures["names read exactly, %"] = share_exact(results.select(part=PART))
    note = f"{plans} schools and offices; doors, symbols: {drawing_plans} that draw their doors."
    summary = ({"metric": name, "figure": "here", "value": value} for name, value in figures.items())
    return SUMMARY.fill(summary, notes=[note])


def estimate_time(records: Sequence[Record]) -> float | None:
    """Seconds for LARGE_SIZE million pixels on the plan that was slowest for its size, of the large ones."""
    sizes = {record["item"]: record["value"] for record in select_records(records, {"metric": "megapixels"})}
    times = [
        LARGE_SIZE * record["value"] / sizes[record["item"]]
        for record in select_records(records, {"metric": "seconds", "reading": WITH})
        if record["value"] is not None and sizes[record["item"]] > LARGE
    ]
    return max(times, default=None)


def derive_exact_names(records: Sequence[Record]) -> Iterator[Record]:
    """The share of names that are read exactly: of all, and by font, size and rotation."""
    groups: dict[str, Sequence[Record]] = {"all": records}
    for name in ("font", "capital", "rotation"):
        for value in dict.fromkeys(record[name] for record in records):
            groups[value] = select_records(records, {name: value})
    for sheets, chosen in groups.items():
        yield {"sheets": sheets, "metric": "read exactly", "value": share_exact(chosen)}


def share_exact(records: Iterable[Record]) -> float | None:
    """Percent of the names on sheets that are read exactly."""
    sums = dict.fromkeys((EXACT, NAME_COUNT), 0.0)
    for record in records:
        if record["metric"] in sums:
            sums[record["metric"]] += record["value"] or 0
    return 100 * sums[EXACT] / sums[NAME_COUNT] if sums[NAME_COUNT] else None
