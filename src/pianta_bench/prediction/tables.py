"""Predictions against baselines, labels, numbers of rooms, skeletons, doors, and time, for each building type."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from statistics import fmean
from textwrap import wrap
from typing import Any, TypeAlias

import numpy as np

from pianta._types import Floats
from pianta.evaluation.prediction import expect_calibration_error, measure_label_reliability
from pianta.evaluation.semantics import Reliability, measure_reliability
from pianta.labels import SCHEMAS, LabelSchema
from pianta_bench.graphs.measure import PARTS
from pianta_bench.harness.records import Record, Results, select_records
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.prediction.baselines import BASELINES, BLIND, KNOWN_PART, LOCAL
from pianta_bench.prediction.scores import (
    DISTANCES,
    EDITS,
    LABEL_SETS,
    MEAN,
    MEDOID,
    ORACLE,
    PREDICTED,
    SAMPLE,
    TYPICAL,
)

# A figure of a predictor and of a baseline, None if it does not exist.
Pair: TypeAlias = tuple[float | None, float | None]

HALF = "half"
ALL = "all"
STAGES = [HALF, ALL]
MIN_TIMED = 35  # rooms of the floors whose prediction is timed
MAX_TIMED = 45
NOTE_WIDTH = 80  # characters
CHANCE_DRAWS = 200  # whose mean is the calibration error by chance; chosen by hand
# By metric and predictor what stands in the column of each baseline: skeletons of samples are compared by the mean
# distance, with all floors of the model; the most typical one with the most typical floor.
COMPARED = {
    ("labels", PREDICTED): BASELINES,
    ("labels", ORACLE): (BLIND,),
    **{(metric, PREDICTED): (BLIND, KNOWN_PART, LOCAL) for metric in DISTANCES},
    **{(metric, TYPICAL): (MEDOID, KNOWN_PART, LOCAL) for metric in DISTANCES},
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
    where={"metric": ["labels", *DISTANCES], "predictor": [PREDICTED, TYPICAL], "baseline": list(BASELINES)},
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
StageTable = partial(Table, rows=("stage", "metric"), columns=("predictor",))
LABELS = StageTable(
    title="Jensen-Shannon divergence of the labels of unseen rooms, {part}",
    where={
        "stage": STAGES,
        "metric": [*LABEL_SETS.values()],
        "predictor": [PREDICTED, MEAN, SAMPLE, *BASELINES, ORACLE],
    },
    digits=3,
    unit="bits",
    notes=(
        "predicted: the distribution nearest to the samples'; mean: of the samples.",
        "oracle: as many labels as are unseen, of this floor's own; not known in practice.",
        "local: blind where it predicts nothing, on {silent:.0f} floors with half of the corridors.",
        "half: of the corridors are explored; all: the mean over stages of a floor first.",
    ),
)
SIZES = StageTable(
    title="Rooms of the whole floor, {part}",
    where={
        "stage": STAGES,
        "metric": ["rooms, error", "rooms, bias", "corridors, error", "corridors, bias"],
        "predictor": [PREDICTED, *BASELINES],
    },
    unit="rooms",
    notes=(
        "blind: the mean of other floors, at least the known rooms; local: a room more for",
        "each open end; known part: times known corridors over explored ones.",
        "Rooms in the interval of four of five samples: {half} (half), {all} (all).",
    ),
)
SKELETONS = StageTable(
    title="Distance of the skeleton of corridors, {part}",
    where={
        "stage": STAGES,
        "metric": list(DISTANCES),
        "predictor": [PREDICTED, TYPICAL, BLIND, MEDOID, KNOWN_PART, LOCAL],
    },
    digits=2,
    notes=(
        "WL, NSPDK: sqrt(2 - 2k) of the normalised kernel, which hardly depends on sizes.",
        "edits: upper bound, nodes, edges, labels; of skeletons of 30 corridors at most.",
        "predicted: mean over samples; typical: of one; medoid: one of the other floors.",
    ),
)
DOORS = Table(
    title="What is behind unopened doors, {part}",
    rows=("stage",),
    columns=("metric",),
    summarise=Cell.only,
    unit="%",
    notes=(
        "Expected calibration errors; by chance alone: if all probabilities were exact.",
        "all: each door once, at the first stage at which it is unopened.",
    ),
)
RELIABILITY = Table(
    title="Reliability of predictions of doors, all stages, {part}",
    rows=("probability",),
    columns=("metric",),
    summarise=Cell.only,
)
TIME = Table(
    title=f"Time of {{count}} samples on floors of {MIN_TIMED} to {MAX_TIMED} rooms, {{part}}",
    rows=("work",),
    columns=("metric",),
    where={"work": [f"prediction, {HALF}", f"prediction, {ALL}", "sampler, once", "model, once"]},
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
        LABELS.fill(floors, part=part, silent=silent),
        SIZES.fill(floors, part=part, half=half, all=every),
        SKELETONS.fill([each for each in floors if (each["metric"], each["stage"]) != (EDITS, ALL)], part=part),
        DOORS.fill(derive_doors(doors, schema), part=part),
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
        values = [record["value"] for record in stages if record["value"] is not None]
        for record in stages:
            if record["half"]:
                yield {**fields, "stage": HALF, "value": record["value"]}
        yield {**fields, "stage": ALL, "value": fmean(values) if values else None}


def derive_pairs(floors: Iterable[Record]) -> Iterator[Record]:
    """The figures of predictors and baselines with half of the corridors, two of a floor each."""
    halves = {
        (record["metric"], record["predictor"], record["item"]): record["value"]
        for record in floors
        if record["stage"] == HALF
    }
    for (metric, predictor, item), value in halves.items():
        for column, baseline in zip(BASELINES, COMPARED.get((metric, predictor), ()), strict=False):
            pair = value, halves.get((metric, baseline, item))
            yield {"metric": metric, "predictor": predictor, "baseline": column, "item": item, "value": pair}


def derive_doors(doors: Sequence[Record], schema: LabelSchema) -> Iterator[Record]:
    """How often predictions of what is behind a door are right, and how exact their probabilities are."""
    for stage, chosen in ((HALF, [door for door in doors if door["half"]]), (ALL, list_first(doors))):
        figures: dict[str, float | None] = dict.fromkeys(
            ("right", "local right", "error of\ntop label", "by chance\nalone", "error of\nevery label")
        )
        if chosen:
            top, every = find_reliability(chosen, schema)
            chance = expect_calibration_error(list_probabilities(chosen, schema), draws=CHANCE_DRAWS, seed=0)
            right = fmean(top_label(door) == door["true"] for door in chosen)
            local = fmean(door["local"] == door["true"] for door in chosen)
            shares = (right, local, top.error, chance, every.error)
            figures = {name: 100 * float(share) for name, share in zip(figures, shares, strict=True)}
        for metric, value in ({"doors": len(chosen)} | figures).items():
            yield {"stage": stage, "metric": metric, "value": value}


def derive_reliability(doors: Sequence[Record], schema: LabelSchema) -> Iterator[Record]:
    """How often the top label of a door is right, by its probability; doors of all stages."""
    top, _ = find_reliability(list_first(doors), schema)
    for low, count, mean, right in zip(top.edges, top.counts, top.confidence, top.accuracy, strict=False):
        figures = {"doors": int(count), "probability, %": 100 * float(mean), "right, %": 100 * float(right)}
        for metric, value in figures.items() if count else ():
            yield {"probability": f"{100 * low:.0f} to {100 * low + 10:.0f} %", "metric": metric, "value": value}


def derive_times(results: Results, part: str) -> Iterator[Record]:
    """Seconds of the processor for a prediction of floors of a usual size, a sampler, and a model."""
    rooms = {record["item"]: record["value"] for record in results.select(part=part, metric="rooms")}
    for record in results.select(part=part, metric="seconds"):
        if record["work"] != "prediction":
            yield record
            continue
        timed = MIN_TIMED <= rooms[record["item"]] <= MAX_TIMED
        for stage in (HALF, ALL) if record["half"] else (ALL,):
            yield {**record, "work": f"prediction, {stage}", "value": record["value"] if timed else None}


def drop_absent(pairs: Iterable[Pair]) -> list[tuple[float, float]]:
    """The pairs of which both figures exist."""
    return [(value, other) for value, other in pairs if value is not None and other is not None]


def measure_gain(pairs: Iterable[Pair]) -> float | None:
    """By how many per cent the mean of the first figures is lower than that of the others."""
    present = drop_absent(pairs)
    total = sum(other for _, other in present)
    return 100 * (1 - sum(value for value, _ in present) / total) if total else None


def list_first(doors: Sequence[Record]) -> list[Record]:
    """Each door at the first stage at which it is unopened; floor by floor, the last stage first."""
    items = [*dict.fromkeys(door["item"] for door in doors)]
    ordered = sorted(doors, key=lambda door: (items.index(door["item"]), -door["explored"]))
    return [*{(door["item"], door["door"]): door for door in ordered}.values()]


def find_reliability(doors: Sequence[Record], schema: LabelSchema) -> tuple[Reliability, Reliability]:
    """Reliability of the top labels, and of all labels, of the predictions of doors."""
    probabilities = list_probabilities(doors, schema)
    names = [*schema.by_name]
    truth = np.array([names.index(door["true"]) for door in doors], int)
    return measure_reliability(probabilities, truth), measure_label_reliability(probabilities, truth)


def list_probabilities(doors: Sequence[Record], schema: LabelSchema) -> Floats:
    """The probabilities of all labels, shape (doors, labels)."""
    rows = [[door["labels"].get(name, 0.0) for name in schema.by_name] for door in doors]
    return np.array(rows, float).reshape(-1, len(schema.by_name))


def top_label(door: Record) -> str | None:
    """The most probable label, the first of several; None without probabilities."""
    labels: dict[str, Any] = door["labels"]
    return max(labels, key=lambda label: labels[label]) if labels else None


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
