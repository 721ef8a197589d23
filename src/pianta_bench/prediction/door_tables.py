"""What is behind unopened doors: how often predictions are right, and how exact their probabilities are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import fmean
from typing import Any

import numpy as np

from pianta._types import Floats
from pianta.evaluation.prediction import expect_calibration_error, measure_label_reliability
from pianta.evaluation.semantics import Reliability, measure_reliability
from pianta.labels import LabelSchema
from pianta_bench.harness.records import Record
from pianta_bench.harness.tables import Cell, Table
from pianta_bench.prediction.baselines import ANY_DOOR, LOCAL
from pianta_bench.prediction.intervals import resample_buildings
from pianta_bench.prediction.scores import PREDICTED, PRINTED, SAMPLED, SIMILAR_DOORS

HALF = "half"
ALL = "all"
CHANCE_DRAWS = 200  # whose mean is the calibration error by chance; chosen by hand
DOOR_PREDICTORS = (PREDICTED, SAMPLED, SIMILAR_DOORS, LOCAL, ANY_DOOR, PRINTED)
# Figures of probabilities, which these do not give.
WITHOUT_PROBABILITIES = (LOCAL, ANY_DOOR)


DOORS = Table(
    title="What is behind unopened doors, {part}",
    rows=("stage", "predictor"),
    columns=("metric",),
    where={"predictor": list(DOOR_PREDICTORS)},
    summarise=Cell.only,
    digits={"squared error": 3},
    notes=(
        "right: the most probable label; squared error: of all probabilities, 0 to 2.",
        "predicted: the mean of samples and similar doors; these are found by the label and",
        "the area of the room and by the known labels. local: the most frequent label behind",
        "unopened doors of rooms with the same label on other floors; any door: of all rooms.",
        "Expected calibration errors, %; by chance alone: if all probabilities were exact.",
        "all: each door once, at the first stage at which it is unopened.",
    ),
)
RELIABILITY = Table(
    title="Reliability of predictions of doors, all stages, {part}",
    rows=("probability",),
    columns=("metric",),
    summarise=Cell.only,
)


def derive_doors(doors: Sequence[Record], schema: LabelSchema) -> Iterator[Record]:
    """How often predictions of what is behind a door are right, and how exact their probabilities are."""
    for stage, every in ((HALF, [door for door in doors if door["half"]]), (ALL, list_first(doors))):
        for predictor in DOOR_PREDICTORS:
            chosen = [door for door in every if predictor in door]
            # The printed sampler predicts with half of the corridors only; a part of all doors compares with nothing.
            if predictor != PREDICTED and (not chosen or len(chosen) < len(every)):
                continue
            figures = measure_doors(chosen, schema, predictor) if chosen else {}
            for metric, value in ({"doors": len(chosen)} | figures).items():
                yield {"stage": stage, "predictor": predictor, "metric": metric, "value": value}


def measure_doors(doors: Sequence[Record], schema: LabelSchema, predictor: str) -> dict[str, float | None]:
    """The figures of one predictor; of one without probabilities only how often it is right, %."""
    figures: dict[str, float | None] = {
        "right, %": 100 * fmean(top_label(door, predictor) == door["true"] for door in doors)
    }
    if predictor in WITHOUT_PROBABILITIES:
        return figures
    top, every = find_reliability(doors, schema, predictor)
    chance = expect_calibration_error(list_probabilities(doors, schema, predictor), draws=CHANCE_DRAWS, seed=0)
    errors = {"error of\ntop label": top.error, "by chance\nalone": chance, "error of\nevery label": every.error}
    figures["squared error"] = float(np.mean(measure_squared_errors(doors, schema, predictor)))
    return figures | {name: 100 * float(error) for name, error in errors.items()}


def measure_squared_errors(doors: Sequence[Record], schema: LabelSchema, predictor: str) -> Floats:
    """The squared error of the probabilities of each door, summed over labels (Brier, 1950), shape (doors,)."""
    names = [*schema.by_name]
    truth = np.array([[float(name == door["true"]) for name in names] for door in doors]).reshape(-1, len(names))
    errors: Floats = ((list_probabilities(doors, schema, predictor) - truth) ** 2).sum(axis=1)
    return errors


def compare_doors(doors: Sequence[Record], schema: LabelSchema) -> Iterator[str]:
    """Notes on doors with half of the corridors: differences from other predictors, and intervals over buildings."""
    half = [door for door in doors if door["half"]]
    if not half:
        return
    buildings = [door.get("building", door["item"]) for door in half]
    right = {name: [100.0 * (top_label(door, name) == door["true"]) for door in half] for name in DOOR_PREDICTORS}
    errors = {name: measure_squared_errors(half, schema, name).tolist() for name in DOOR_PREDICTORS}
    yield "Differences, half, with a bootstrap interval of 95 % over buildings:"
    for unit, digits, figures, others in (
        ("right, points", 1, right, (SAMPLED, SIMILAR_DOORS, LOCAL, ANY_DOOR, PRINTED)),
        ("squared error", 3, errors, (SAMPLED, SIMILAR_DOORS, PRINTED)),
    ):
        for other in others:
            values = [one - two for one, two in zip(figures[PREDICTED], figures[other], strict=True)]
            interval = resample_buildings(zip(buildings, values, strict=True))
            ends = f"{interval.mean:+.{digits}f} ({interval.low:+.{digits}f} to {interval.high:+.{digits}f})"
            yield f"  {unit}, minus {other}: {ends}"


def derive_reliability(doors: Sequence[Record], schema: LabelSchema) -> Iterator[Record]:
    """How often the top label of a door is right, by its probability; doors of all stages."""
    top, _ = find_reliability(list_first(doors), schema, PREDICTED)
    for low, count, mean, right in zip(top.edges, top.counts, top.confidence, top.accuracy, strict=False):
        figures = {"doors": int(count), "probability, %": 100 * float(mean), "right, %": 100 * float(right)}
        for metric, value in figures.items() if count else ():
            yield {"probability": f"{100 * low:.0f} to {100 * low + 10:.0f} %", "metric": metric, "value": value}


def list_first(doors: Sequence[Record]) -> list[Record]:
    """Each door at the first stage at which it is unopened; floor by floor, the last stage first."""
    items = [*dict.fromkeys(door["item"] for door in doors)]
    ordered = sorted(doors, key=lambda door: (items.index(door["item"]), -door["explored"]))
    return [*{(door["item"], door["door"]): door for door in ordered}.values()]


def find_reliability(doors: Sequence[Record], schema: LabelSchema, predictor: str) -> tuple[Reliability, Reliability]:
    """Reliability of the top labels, and of all labels, of the predictions of doors."""
    probabilities = list_probabilities(doors, schema, predictor)
    names = [*schema.by_name]
    truth = np.array([names.index(door["true"]) for door in doors], int)
    return measure_reliability(probabilities, truth), measure_label_reliability(probabilities, truth)


def list_probabilities(doors: Sequence[Record], schema: LabelSchema, predictor: str) -> Floats:
    """The probabilities of all labels, shape (doors, labels)."""
    rows = [[door.get(predictor, {}).get(name, 0.0) for name in schema.by_name] for door in doors]
    return np.array(rows, float).reshape(-1, len(schema.by_name))


def top_label(door: Record, predictor: str) -> str | None:
    """The most probable label, the first of several; None without probabilities."""
    labels: dict[str, Any] = door.get(predictor, {})
    return max(labels, key=lambda label: labels[label]) if labels else None
