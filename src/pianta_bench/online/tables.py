"""Semantic mapping on-line: over the way, against one reading of the last map, what updates cost, and calibration."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from statistics import fmean

import numpy as np

from pianta.evaluation.bootstrap import bootstrap_mean
from pianta.evaluation.semantics import bin_reliability
from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.online.measure import (
    CHANGED_IDS,
    COST,
    DOORS,
    END_BASELINE,
    END_BELIEF,
    LABEL_BELIEF,
    LABELS,
    LARGEST,
    LONGER,
    METRES_MAP,
    METRES_PERFECT,
    RATIO,
    READ_LABELS,
    READ_ROOMS,
    READ_TYPE,
    READING,
    ROOMS,
    SIZE,
    STAGES,
    TYPE,
    TYPE_AT,
    TYPE_BELIEF,
    name_stage,
)

BINS = 10  # of equal width, for calibration
WAY = Table(
    title="{type}s while a robot maps them",
    rows=("metric",),
    columns=("stage",),
    factor=100,
    unit="%",
    notes=(
        "By the share of the area that the robot has seen. Rooms: IoU above 0.5 with",
        "true ones of which half was seen. Labels F/C/E/S of these. Type: announced.",
        "Expected rooms: of the whole floor, by a mapper that knows the type; the",
        "error is the difference over the true number.",
    ),
)
SHARES = (ROOMS, READ_ROOMS, LABELS, READ_LABELS, TYPE, READ_TYPE, TYPE_AT, CHANGED_IDS)
END = Table(
    title="At the end of the way, and what updates cost",
    labels={
        **{name: f"{name}, %" for name in SHARES},
        **{name: name for name in (METRES_MAP, METRES_PERFECT, LONGER, COST, LARGEST, READING, RATIO)},
    },
    digits=dict.fromkeys((COST, LARGEST, READING, RATIO, LONGER), 2) | {METRES_MAP: 0, METRES_PERFECT: 0},
    notes=(
        "One reading: of the last map as a whole. Ids changed: of true rooms that were",
        "neither joined nor divided. Update over reading: mean seconds of an update",
        "over those of a whole reading of the map, at four shares of the area.",
    ),
)
CALIBRATION = Table(
    title="Calibration over the way",
    rows=("metric",),
    columns=("figure",),
    summarise=Cell.only,
    factor=100,
    unit="%",
    notes=(
        "Error: mean difference of probability and share that is right, over ten bins.",
        "Behind doors: function (F/C/E/S) of the room behind a door that is not open,",
        "by the belief, and by the mean shares of labels on the floors of the model.",
    ),
)


def tabulate(results: Results) -> list[FilledTable]:
    """Figures over the way, at the end, and of calibration."""
    return [
        WAY.fill(_list_stages(results), type=results.options["type"]),
        END.fill(_list_end(results), notes=_describe_ways(results)),
        CALIBRATION.fill(_calibrate(results)),
    ]


def _list_stages(results: Results) -> Iterator[Record]:
    for metric in (ROOMS, DOORS, LABELS, TYPE, SIZE):
        for stage in STAGES:
            for record in results.select(metric=name_stage(metric, stage)):
                yield {**record, "metric": metric, "stage": f"{stage:.0%}"}


def _list_end(results: Results) -> Iterator[Record]:
    last = {name_stage(metric, STAGES[-1]): metric for metric in (ROOMS, LABELS, TYPE)}
    for record in (*results.records, *_average_starts(results)):
        if "start" in record:
            continue
        metric, value = last.get(record["metric"], record["metric"]), record["value"]
        if metric in END.labels:
            yield {
                **record,
                "metric": metric,
                "value": 100 * value if metric in SHARES and value is not None else value,
            }


def _average_starts(results: Results) -> list[Record]:
    """The mean metres, and ratios, of each building over the starts from which both robots get so far."""
    records: list[Record] = []
    for metric in (METRES_MAP, METRES_PERFECT, LONGER):
        ways = _select_ways(results, metric)
        for (part, item), each in groupby(ways, key=lambda way: (way["part"], way["item"])):
            value = fmean(way["value"] for way in each)
            records.append({"part": part, "item": item, "metric": metric, "value": value})
    return records


def _select_ways(results: Results, metric: str) -> list[Record]:
    """The records of the ways that count."""
    counted = {(way["item"], way["start"]) for way in results.select(metric=LONGER) if way["value"] is not None}
    return [way for way in results.select(metric=metric) if (way["item"], way["start"]) in counted]


def _describe_ways(results: Results) -> Iterator[str]:
    """How many ways the metres are of, which starts do not count, and the interval of the mean ratio."""
    ways, counted = results.select(metric=LONGER), _select_ways(results, LONGER)
    interval = bootstrap_mean(
        [record["value"] for record in _average_starts(results) if record["metric"] == LONGER],
        seed=results.options["seed"],
    )
    if interval:
        yield f"Ways for the metres: {len(counted)}. The mean of each floor comes first."
    if interval and interval.count > 1:
        yield (
            f"Over perfect: {interval.low:.2f} to {interval.high:.2f}, 95 % of the means when floors are resampled "
            "(bootstrap)."
        )
    left_out = [f"{way['item']} start {way['start']}" for way in ways if way["value"] is None]
    if left_out:
        yield f"Without 90 % by both, or with 0 m, left out: {', '.join(left_out)}."


def _calibrate(results: Results) -> Iterator[Record]:
    """The expected calibration error of the likeliest answers, with equal weight of each update and room."""
    for metric in (LABEL_BELIEF, TYPE_BELIEF, END_BELIEF, END_BASELINE):
        records = results.select(metric=metric)
        if not records:
            continue
        probability = np.array([record["probability"] for record in records])
        is_right = np.array([record["value"] for record in records]) > 0
        error = bin_reliability(probability, is_right, bins=BINS).error
        figures = {"belief": probability.mean(), "right": is_right.mean(), "error": error}
        yield from (
            {"part": "", "metric": metric, "figure": name, "value": float(value)} for name, value in figures.items()
        )
