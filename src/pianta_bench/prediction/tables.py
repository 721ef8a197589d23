"""Predictions against baselines, labels, numbers of rooms, skeletons, doors, and time, for each building type."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from statistics import fmean
from textwrap import wrap
from typing import TypeAlias

from pianta.labels import SCHEMAS
from pianta_bench.graphs.measure import PARTS
from pianta_bench.harness.records import Record, Results, select_records
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.prediction.baselines import BASELINES, BLIND, KNOWN_CORRIDORS, KNOWN_PART, LOCAL, SIMILAR
from pianta_bench.prediction.door_tables import (
    ALL,
    DOORS,
    HALF,
    RELIABILITY,
    compare_doors,
    derive_doors,
    derive_reliability,
)
from pianta_bench.prediction.intervals import resample_buildings
from pianta_bench.prediction.scores import (
    DISTANCES,
    EDITS,
    LABEL_SETS,
    MEAN,
    MEDOID,
    ORACLE,
    PREDICTED,
    PRINTED,
    PRINTED_TYPICAL,
    SAMPLE,
    TYPICAL,
)

# A figure of a predictor and of a baseline, None if it does not exist.
Pair: TypeAlias = tuple[float | None, float | None]

STAGES = [HALF, ALL]
MIN_TIMED = 35  # rooms of the floors whose prediction is timed
MAX_TIMED = 45
NOTE_WIDTH = 80  # characters
SIZES_COMPARED = ("rooms, error", "corridors, error")
# By metric and predictor the baseline in each column: skeletons of samples are compared by the mean distance, with all
# floors of the model; the most typical one with the most typical floor.
COMPARED: Mapping[tuple[str, str], Mapping[str, str]] = {
    ("labels", ORACLE): {BLIND: BLIND},
    **{
        (metric, PREDICTED): {name: name for name in (BLIND, KNOWN_PART, LOCAL, SIMILAR)}
        for metric in ("labels", *SIZES_COMPARED)
    },
    **{
        (metric, predictor): {BLIND: blind, KNOWN_PART: KNOWN_PART, LOCAL: LOCAL, KNOWN_CORRIDORS: KNOWN_CORRIDORS}
        for metric in DISTANCES
        for predictor, blind in ((PREDICTED, BLIND), (TYPICAL, MEDOID))
    },
}


def share_better(pairs: Sequence[Pair]) -> Cell:
    """In how many per cent of the pairs the predictor has the lower figure."""
    present = drop_absent(pairs)
    return Cell(100 * fmean(value < other for value, other in present) if present else None, count=len(present))


def show_gain(pairs: Sequence[Pair]) -> Cell:
    """The cell of `measure_gain`."""
    return Cell(measure_gain(pairs), count=len(drop_absent(pairs)))


BETTER = Table(
    title="Section 8.3, {part}, half of the corridors: better than baselines in",
    rows=("metric", "predictor"),
    columns=("baseline",),
    where={
        "metric": ["labels", *SIZES_COMPARED, *DISTANCES],
        "predictor": [PREDICTED, TYPICAL],
        "baseline": list(BASELINES),
    },
    summarise=share_better,
    unit="% of floors",
    notes=("{halves} of {floors} {part} have rooms unseen with half of their corridors explored.",),
)
LOWER = Table(
    title="Section 8.3, {part}, half of the corridors: mean lower than of baselines by",
    rows=BETTER.rows,
    columns=BETTER.columns,
    where=BETTER.where,
    summarise=show_gain,
    unit="%",
    notes=("blind: the mean over skeletons of other floors; beside typical the most typical.",),
)
DIFFERENCES = Table(
    title="Differences from baselines with half of the corridors, {part}",
    rows=("metric", "predictor", "baseline"),
    columns=("end",),
    where=BETTER.where,
    summarise=Cell.only,
    digits=3,
    notes=(
        "Of the means over floors, with a bootstrap interval of 95 % over buildings;",
        "below 0 the prediction is nearer to the truth.",
    ),
)
StageTable = partial(Table, rows=("stage", "metric"), columns=("predictor",))
LABELS = StageTable(
    title="Jensen-Shannon divergence of the labels of unseen rooms, {part}",
    where={
        "stage": STAGES,
        "metric": [*LABEL_SETS.values()],
        "predictor": [PREDICTED, MEAN, SAMPLE, PRINTED, BLIND, KNOWN_PART, LOCAL, SIMILAR, ORACLE],
    },
    digits=3,
    unit="bits",
    notes=(
        "predicted: the distribution nearest to the samples'; mean: of the samples.",
        "oracle: as many labels as are unseen, of this floor's own; not known in practice.",
        "local: what was directly behind open ends of rooms with the same label on other",
        "floors; blind if nothing was, on {silent:.0f} floors with half of the corridors.",
        "similar stages: nearest to what was left of other floors, weighted as by the sampler.",
        "half: of the corridors are explored; all: the mean over stages of a floor first.",
    ),
)
SIZES = StageTable(
    title="Rooms of the whole floor, {part}",
    where={
        "stage": STAGES,
        "metric": ["rooms, error", "rooms, bias", "corridors, error", "corridors, bias"],
        "predictor": [PREDICTED, PRINTED, BLIND, KNOWN_PART, LOCAL, SIMILAR],
    },
    unit="rooms",
    notes=(
        "blind: the mean of other floors, at least the known rooms; known part: times known",
        "corridors over explored ones; local: known rooms and those directly behind open ends;",
        "similar stages: the known rooms and the mean of those left at similar stages.",
        "Rooms in the interval of four of five samples: {half} (half), {all} (all).",
    ),
)
SKELETONS = StageTable(
    title="Distance of the skeleton of corridors, {part}",
    where={
        "stage": STAGES,
        "metric": list(DISTANCES),
        "predictor": [PREDICTED, TYPICAL, PRINTED, PRINTED_TYPICAL, BLIND, MEDOID, KNOWN_PART, LOCAL, KNOWN_CORRIDORS],
    },
    digits=2,
    notes=(
        "WL, NSPDK: sqrt(2 - 2k) of the normalised kernel, which hardly depends on sizes.",
        "edits: upper bound, nodes, edges, labels; of skeletons of 30 corridors at most.",
        "predicted, blind: mean over samples, floors; typical, medoid: the most typical one.",
        "local: a corridor more where one is expected; known corridors: no more than these.",
    ),
)
TIME = Table(
    title=f"Time of {{count}} samples on floors of {MIN_TIMED} to {MAX_TIMED} rooms, {{part}}",
    rows=("work",),
    columns=("metric",),
    where={"work": [f"prediction, {HALF}", f"prediction, {ALL}", "as printed, half", "sampler, once", "model, once"]},
    labels={"seconds": "median"},
    summarise=Cell.median,
    digits=2,
    unit="s of one core",
)


def tabulate(results: Results) -> list[FilledTable]:
    """For each type: against baselines, labels, numbers of rooms, skeletons, doors, their reliability, and time."""
    return [table for building_type in PARTS for table in tabulate_type(results, building_type)]


def tabulate_type(results: Results, building_type: str) -> list[FilledTable]:
    """The tables of a building type."""
    part, schema = PARTS[building_type], SCHEMAS[building_type]
    floors = [*derive_floors(results.select(part=part))]
    pairs = [*derive_pairs(floors)]
    doors = [door for door in results.details["doors"] if door["part"] == part]
    holds = [results.values(part=part, metric="interval holds", half=half) for half in (True, [True, False])]
    half, every = (f"{sum(values):.0f} of {len(values)}" for values in holds)
    count = len(results.select(part=part, metric="rooms"))
    silent = sum(results.values(part=part, metric="no local labels", half=True))
    return [
        BETTER.fill(pairs, part=part, halves=len(holds[0]), floors=count, notes=_compare_labels(pairs)),
        LOWER.fill(pairs, part=part),
        DIFFERENCES.fill(derive_differences(pairs), part=part),
        LABELS.fill(floors, part=part, silent=silent),
        SIZES.fill(floors, part=part, half=half, all=every),
        SKELETONS.fill([each for each in floors if (each["metric"], each["stage"]) != (EDITS, ALL)], part=part),
        DOORS.fill(derive_doors(doors, schema), part=part, notes=compare_doors(doors, schema)),
        RELIABILITY.fill(derive_reliability(doors, schema), part=part),
        TIME.fill(derive_times(results, part), part=part, count=results.options["count"]),
    ]


def derive_floors(records: Iterable[Record]) -> Iterator[Record]:
    """The scores of each floor with half of its corridors explored, and their means over all its stages."""
    floors: dict[tuple[str, str, str], list[Record]] = {}
    for record in records:
        if "predictor" in record:
            key = record["item"], record["metric"], record["predictor"]
            floors.setdefault(key, []).append(record)
    for (item, metric, predictor), stages in floors.items():
        fields = {"item": item, "metric": metric, "predictor": predictor}
        fields["building"] = stages[0].get("building", item)
        values = [record["value"] for record in stages if record["value"] is not None]
        for record in stages:
            if record["half"]:
                yield {**fields, "stage": HALF, "value": record["value"]}
        yield {**fields, "stage": ALL, "value": fmean(values) if values else None}


def derive_pairs(floors: Iterable[Record]) -> Iterator[Record]:
    """The figures of predictors and baselines with half of the corridors, two of a floor each."""
    halves = {
        (record["metric"], record["predictor"], record["item"]): record for record in floors if record["stage"] == HALF
    }
    for (metric, predictor, item), record in halves.items():
        for column, baseline in COMPARED.get((metric, predictor), {}).items():
            other = halves.get((metric, baseline, item), {"value": None})
            fields = {"metric": metric, "predictor": predictor, "baseline": column}
            pair = record["value"], other["value"]
            yield {**fields, "item": item, "building": record["building"], "value": pair}


def derive_differences(pairs: Iterable[Record]) -> Iterator[Record]:
    """The mean difference of each predictor from each baseline, and its bootstrap interval over buildings."""
    groups: dict[tuple[str, str, str], list[Record]] = {}
    for pair in pairs:
        if None not in pair["value"]:
            groups.setdefault((pair["metric"], pair["predictor"], pair["baseline"]), []).append(pair)
    for (metric, predictor, baseline), own in groups.items():
        interval = resample_buildings((pair["building"], pair["value"][0] - pair["value"][1]) for pair in own)
        fields = {"metric": metric, "predictor": predictor, "baseline": baseline}
        for end in ("difference", "from", "to"):
            value = {"difference": interval.mean, "from": interval.low, "to": interval.high}[end]
            yield {**fields, "end": end, "value": value}


def derive_times(results: Results, part: str) -> Iterator[Record]:
    """Seconds of the processor for a prediction of floors of a usual size, a sampler, and a model."""
    rooms = {record["item"]: record["value"] for record in results.select(part=part, metric="rooms")}
    for record in results.select(part=part, metric="seconds"):
        if record["work"] not in ("prediction", PRINTED):
            yield record
            continue
        timed = MIN_TIMED <= rooms[record["item"]] <= MAX_TIMED
        stages = (HALF,) if record["work"] == PRINTED else (HALF, ALL) if record["half"] else (ALL,)
        for stage in stages:
            yield {**record, "work": f"{record['work']}, {stage}", "value": record["value"] if timed else None}


def drop_absent(pairs: Iterable[Pair]) -> list[tuple[float, float]]:
    """The pairs of which both figures exist."""
    return [(value, other) for value, other in pairs if value is not None and other is not None]


def measure_gain(pairs: Iterable[Pair]) -> float | None:
    """By how many per cent the mean of the first figures is lower than that of the others."""
    present = drop_absent(pairs)
    total = sum(other for _, other in present)
    return 100 * (1 - sum(value for value, _ in present) / total) if total else None


def wrap_names(names: Sequence[str]) -> list[str]:
    """Names, indented, in as many lines of a note as needed."""
    return wrap(", ".join(names or ("none",)), NOTE_WIDTH, initial_indent="  ", subsequent_indent="  ")


def _compare_labels(pairs: Iterable[Record]) -> Iterator[str]:
    """Notes on the floors whose labels are predicted better than by the blind average, and on the oracle."""
    predicted, oracle = (
        {
            record["item"]: record["value"]
            for record in select_records(pairs, {"metric": "labels", "predictor": predictor, "baseline": BLIND})
            if None not in record["value"]
        }
        for predictor in (PREDICTED, ORACLE)
    )
    worse = [item for item, (value, blind) in predicted.items() if value >= blind]
    yield f"Labels below the blind average in {len(predicted) - len(worse)} of {len(predicted)}; not in:"
    yield from wrap_names(worse)
    gain = measure_gain(oracle.values())
    if gain is not None:
        below = sum(value < blind for value, blind in oracle.values())
        yield f"The oracle's labels, not known in practice: lower by {gain:.1f} %, below in {below} of {len(oracle)}."
