"""The tables of bench places beside those of the thesis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from pianta.evaluation.semantics import LabelPair, Reliability, count_confusion, semantic_accuracy
from pianta.labels import LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.places.evaluated import (
    BACKWARD,
    FORWARD,
    LAYOUTS,
    METHODS,
    OFFICES,
    SCHOOLS,
    THESIS_LAYOUTS,
    TRUE_LAYOUTS,
    EvaluatedFloor,
    measure_curve,
)
from pianta_bench.places.measure import COST, COUNTS, WRONG_ROOMS
from pianta_bench.places.models import CENTRAL, IN_DRAWINGS_SCALE, LOCAL, MAPPED, PIANTA, with_steps

KLOG = "kLog"
NOTHING = "nothing"
FUNCTIONS = LABELS[LabelSet.F_C_E_S]
# The models without those after one of their steps.
FINAL_MODELS = (CENTRAL, IN_DRAWINGS_SCALE, PIANTA, MAPPED)
SHORT_PARTS = {SCHOOLS: "S", OFFICES: "O", LAYOUTS: "L"}


def pool_errors(floors: Sequence[Sequence[LabelPair]]) -> Cell:
    """Share of wrong rooms, %, over the rooms of all floors."""
    pairs = [pair for floor in floors for pair in floor]
    return Cell(100 - 100 * semantic_accuracy(pairs) if pairs else None, count=len(pairs))


def calibration_error(curves: Sequence[Reliability]) -> Cell:
    """Expected calibration error of the only curve, in percentage points."""
    (curve,) = curves
    rooms = int(curve.counts.sum())
    return Cell(100 * curve.error if rooms else None, count=rooms)


TABLE_6_1 = Table(
    title="Table 6.1, errors of place classification",
    unit="%",
    rows=("model",),
    columns=("part", "labels"),
    where={
        "model": [LOCAL, CENTRAL, KLOG, *with_steps(PIANTA), *with_steps(MAPPED)],
        "part": [SCHOOLS, OFFICES],
        "labels": list(LABELS),
    },
    labels=SHORT_PARTS,
    summarise=pool_errors,
    digits=2,
    published="table_6_1_places.csv",
)
TABLE_5_2 = Table(
    title="Table 5.2, semantic accuracy on reconstructed layouts",
    unit="%",
    rows=("part", "model"),
    columns=("labels", "way"),
    where={
        "part": [LAYOUTS, THESIS_LAYOUTS, TRUE_LAYOUTS],
        "model": [CENTRAL, IN_DRAWINGS_SCALE, *with_steps(PIANTA), *with_steps(MAPPED)],
        "labels": list(LABELS),
        "way": [FORWARD, BACKWARD],
    },
    labels={LAYOUTS: "structure", THESIS_LAYOUTS: "Algorithm 1", TRUE_LAYOUTS: "true layout"},
    published="table_5_2.csv",
)
CONFUSION = Table(
    title="Table {table}, confusion of {rooms}, {layouts}",
    unit="%",
    rows=("model", "true"),
    columns=("predicted",),
    where={"model": [CENTRAL, PIANTA], "true": list(FUNCTIONS), "predicted": [*FUNCTIONS, NOTHING]},
    labels={label: label[0] for label in FUNCTIONS},
    notes=("Rows: true labels, columns: predicted ones; means over the maps that have the label.",),
)
CALIBRATION = Table(
    title="Expected calibration error",
    unit="percentage points",
    rows=("model",),
    columns=("part", "labels"),
    where={"model": [CENTRAL, PIANTA, MAPPED], "part": list(SHORT_PARTS), "labels": list(LABELS)},
    labels=SHORT_PARTS,
    summarise=calibration_error,
    notes=(
        "10 bins of equal width by the probability of the predicted label.",
        "S schools, O offices, L reconstructed layouts of schools, rooms that overlap no true room left out.",
    ),
)
COSTS = Table(
    title="Cost",
    where={"part": COST},
    digits=2,
    notes=("Time of all threads, without the simulation of maps.",),
)


def tabulate(results: Results) -> list[FilledTable]:
    """Table 6.1 (places), Tables 5.2 to 5.4, calibration, and cost if it was measured."""
    floors: list[EvaluatedFloor] = results.objects["floors"]
    convention = f"Labels are divided as in the thesis' {results.objects['convention']} (docs/methods/labels.md)."
    layouts = {part: [floor for floor in floors if floor.part == part] for part in METHODS}
    tables = [
        TABLE_6_1.fill(_pair_labels(floors), notes=(*_note_counts(floors), convention)),
        TABLE_5_2.fill(_list_accuracies(results, floors), notes=(*_note_maps(layouts[LAYOUTS]), convention)),
        *(fill_confusion(layouts[part], way, part) for way, part in product((FORWARD, BACKWARD), METHODS)),
        CALIBRATION.fill(_measure_calibration(floors)),
    ]
    counts = {record["metric"]: record for record in results.select(part=COUNTS)}
    if counts:
        number, rooms, map_rooms = (counts[name]["value"] for name in ("floors", "rooms", "map rooms"))
        training = f"Training on {number} floors with {rooms} rooms"
        note = f"{training}; map of {counts['rooms']['item']}, {map_rooms} rooms found."
        tables.append(COSTS.fill(results.records, notes=(note,)))
    return tables


def fill_confusion(layouts: Sequence[EvaluatedFloor], way: str, part: str) -> FilledTable:
    """Confusion in F/C/E/S, % of the rooms with a true label, means over the maps that have the label.

    part: of the layouts; the thesis' figures stand beside those of its Algorithm 1.
    """
    forward = way == FORWARD
    title = {"table": "5.3", "rooms": "found rooms (FC)"} if forward else {"table": "5.4", "rooms": "true rooms (BC)"}
    left_out = "Rooms that overlap no true room are left out." if forward else f"{NOTHING}: no found room overlaps it."
    published = "table_5_3.csv" if forward else "table_5_4.csv"
    table = replace(CONFUSION, published=published if part == THESIS_LAYOUTS else "")
    return table.fill(_list_confusions(layouts, way), notes=(left_out,), **title, layouts=TABLE_5_2.labels[part])


def _pair_labels(floors: Sequence[EvaluatedFloor]) -> Iterator[Record]:
    """Pairs of labels of each annotated floor, by model and label set."""
    for floor, label_set in product(floors, LABELS):
        if floor.part in {SCHOOLS, OFFICES}:
            for model in floor.probabilities:
                pairs = floor.pair_labels(model, label_set)
                yield {"part": floor.part, "model": model, "labels": label_set, "value": pairs}


def _list_accuracies(results: Results, floors: Sequence[EvaluatedFloor]) -> Iterator[Record]:
    """Right rooms, %, of each reconstructed floor; and of its true rooms, where FC and BC are equal."""
    for record in results.select(part=list(METHODS), metric=WRONG_ROOMS):
        if record["part"] == LAYOUTS or record["model"] in FINAL_MODELS:
            yield {**record, "value": 100 - record["value"]}
    for floor, label_set, way in product(floors, LABELS, (FORWARD, BACKWARD)):
        if floor.part == TRUE_LAYOUTS:
            for model in FINAL_MODELS:
                accuracy = 100 * semantic_accuracy(floor.pair_labels(model, label_set))
                yield {"part": floor.part, "model": model, "labels": label_set, "way": way, "value": accuracy}


def _list_confusions(layouts: Sequence[EvaluatedFloor], way: str) -> Iterator[Record]:
    """For each map and true label the shares of predicted labels; None without rooms of that true label."""
    for floor, model in product(layouts, (CENTRAL, PIANTA)):
        shares = count_confusion(floor.pair_labels(model, LabelSet.F_C_E_S, way), FUNCTIONS)
        for (row, column), share in np.ndenumerate(shares):
            names = {"model": model, "true": FUNCTIONS[row], "predicted": (*FUNCTIONS, NOTHING)[column]}
            yield {**names, "value": None if np.isnan(share) else float(share)}


def _measure_calibration(floors: Sequence[EvaluatedFloor]) -> Iterator[Record]:
    """The reliability of each model over the rooms of a part."""
    for part, label_set, model in product(SHORT_PARTS, LABELS, (CENTRAL, PIANTA, MAPPED)):
        curve = measure_curve([floor for floor in floors if floor.part == part], model, label_set)
        yield {"part": part, "labels": label_set, "model": model, "value": curve}


def _note_counts(floors: Sequence[EvaluatedFloor]) -> tuple[str, ...]:
    """The notes below the tables: rooms and floors of schools and offices, and what the models were trained on."""
    rooms = {part: [len(floor.truth.rooms) for floor in floors if floor.part == part] for part in (SCHOOLS, OFFICES)}
    schools, offices = (f"{sum(counts)} rooms on {len(counts)} floors" for counts in rooms.values())
    return (
        f"S schools: {schools} (thesis: 30 floors). O offices: {offices} (20). Whole buildings are left out.",
        "Ex-T: 500 trees, trained on floors of the same type. pianta: on both types.",
        "pianta, maps too: on a simulated map of each floor besides.",
    )


def _note_maps(layouts: Sequence[EvaluatedFloor]) -> tuple[str, ...]:
    return (
        f"Means over {len(layouts)} maps (thesis: 20), labelled by models without their building.",
        f"Ex-T: 11 features, trained on schools. {IN_DRAWINGS_SCALE}: of maps enlarged to the scale of their drawings.",
        "structure: the method of `pianta read`. Algorithm 1: that of `--method thesis`, and of the thesis.",
        "true layout: the same models on the true rooms, where FC is BC.",
    )
