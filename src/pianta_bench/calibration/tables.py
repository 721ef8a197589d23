"""Calibration of the probabilities of rooms and of doors: of each set, and of each bin."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pianta._types import Floats, Mask
from pianta.evaluation.prediction import expect_calibration_error
from pianta.evaluation.semantics import BINS, Reliability, bin_reliability
from pianta_bench.calibration.measure import DOORS, EITHER, REGIONS, ROOMS
from pianta_bench.harness.records import Record, Results, name_parts
from pianta_bench.harness.tables import FilledTable, Table

REAL = "real maps"
# Sets of maps that robots have made in furnished buildings.
REAL_SETS = ("clutter", "vacuum")
ALL = "all"
# Their mean is the calibration error by chance; chosen by hand.
CHANCE_DRAWS = 200

ERROR_NOTE = (
    "calibration error: mean distance of probability and share of right ones over ten bins, weighted by their number, "
    "in points; by chance alone: what it would be if the probabilities were exact. ranking: how often a right one has "
    "a higher probability than a wrong one; 50 is chance."
)

SETS = Table(
    title="Calibration of the probabilities of {regions}",
    columns=("metric",),
    rows=("part",),
    labels={
        "count": "n",
        "probability": "mean\nprobability, %",
        "right": "right,\n%",
        "error": "calibration\nerror",
        "chance": "by chance\nalone",
        "ranking": "ranking,\n%",
    },
    digits={"count": 0},
    notes=(ERROR_NOTE,),
)
BIN_TABLE = Table(
    title="Share of right {regions} by probability",
    rows=("bin",),
    columns=("part", "metric"),
    labels={"count": "n", "right": "right, %"},
    digits={"count": 0},
)
NOTES = {
    ROOMS: "A room is right if a true room has an IoU of at least 0.6 with it, on free cells.",
    DOORS: "A door is right if its middle is within half a width of a true door, and at least within 0.45 m.",
    EITHER: "A door is right if it is near a true door, or if a true door joins the true rooms that its rooms overlap.",
}


def tabulate(results: Results) -> list[FilledTable]:
    """For each of REGIONS: the calibration of each set and of all together, and the shares of each bin."""
    tables = []
    for regions in REGIONS:
        curves = [*list_groups(results, regions)]
        if not curves:
            continue
        figures = [record for part, chances, right in curves for record in describe_set(part, chances, right)]
        tables.append(SETS.narrow(metric=[*SETS.labels]).fill(figures, notes=(NOTES[regions],), regions=regions))
        binned = [record for part, chances, right in curves for record in describe_bins(part, chances, right)]
        tables.append(BIN_TABLE.fill(binned, regions=regions))
    return tables


def list_groups(results: Results, regions: str) -> Iterator[tuple[str, Floats, Mask]]:
    """Probabilities and which are right, shape (n,) each, of each set, of maps of furnished places, and of all."""
    parts = [*name_parts(results.items)]
    real = [part for part in parts if part in REAL_SETS]
    groups = {part: [part] for part in parts} | ({REAL: real} if len(real) > 1 else {})
    if len(parts) > max(len(real), 1):
        groups[ALL] = parts
    for name, members in groups.items():
        chances, right = (
            np.array(results.values(part=members, regions=regions, metric=metric), float)
            for metric in ("probability", "right")
        )
        if len(chances):
            yield name, chances, right > 0


def describe_set(part: str, probabilities: Floats, is_right: Mask) -> Iterator[Record]:
    """The figures of a set: %, and points."""
    curve = bin_reliability(probabilities, is_right, bins=BINS)
    chance = expect_calibration_error(probabilities[:, None], draws=CHANCE_DRAWS, seed=0)
    figures = {
        "count": len(probabilities),
        "probability": 100 * float(probabilities.mean()),
        "right": 100 * float(is_right.mean()),
        "error": 100 * curve.error,
        "chance": 100 * chance,
        "ranking": measure_ranking(probabilities, is_right),
    }
    for metric, value in figures.items():
        yield {"part": part, "metric": metric, "value": value}


def describe_bins(part: str, probabilities: Floats, is_right: Mask) -> Iterator[Record]:
    """The number in each bin and the share of right ones, %."""
    curve: Reliability = bin_reliability(probabilities, is_right, bins=BINS)
    for low, high, count, right in zip(curve.edges, curve.edges[1:], curve.counts, curve.accuracy, strict=False):
        name = f"{100 * low:.0f} to {100 * high:.0f} %"
        yield {"part": part, "bin": name, "metric": "count", "value": int(count)}
        yield {"part": part, "bin": name, "metric": "right", "value": 100 * float(right) if count else None}


def measure_ranking(probabilities: Floats, is_right: Mask) -> float | None:
    """How often a right region has a higher probability than a wrong one, equal ones count half, %; None without both.

    It is the area under the ROC curve.
    """
    right, wrong = probabilities[is_right], np.sort(probabilities[~is_right])
    if not len(right) or not len(wrong):
        return None
    below = (np.searchsorted(wrong, right, "left") + np.searchsorted(wrong, right, "right")) / 2
    return 100 * float(below.mean() / len(wrong))
