"""The tables of bench places: what was measured beside what the thesis prints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType

import numpy as np

from pianta.evaluation.semantics import (
    Reliability,
    count_confusion,
    measure_reliability,
    semantic_accuracy,
)
from pianta.labels import LabelConvention, LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.harness.comparison import Cell, ComparisonRow, ComparisonTable
from pianta_bench.harness.table import Row
from pianta_bench.places.evaluated_floor import LAYOUTS, OFFICES, SCHOOLS, TRUE_LAYOUTS, JudgedFloor
from pianta_bench.places.models import CENTRAL, IN_DRAWINGS_SCALE, LOCAL, MAPPED, PIANTA, STEPS, name_step

KLOG = "kLog"
# Errors, %: schools in R/C and F/C/E/S, then offices (Table 6.1).
PRINTED_ERRORS: Mapping[str, tuple[float, ...]] = MappingProxyType(
    {LOCAL: (3.74, 35.56, 7.21, 36.15), CENTRAL: (2.44, 33.42, 5.12, 32.80), KLOG: (6.82, 46.89, 7.73, 44.92)}
)
# Forward and backward in R/C, then in F/C/E/S: mean and standard deviation, % (Table 5.2).
PRINTED_ACCURACIES = ((97.1, 2.1), (96.5, 2.5), (76.1, 9.1), (77.5, 10.5))
# Rows are true labels, in the order of F/C/E/S (Tables 5.3 and 5.4).
PRINTED_FORWARD = (
    ((82.3, 4.7), (2.8, 3.8), (2.2, 2.9), (12.7, 3.3)),
    ((1.8, 3.1), (94.4, 3.8), (2.3, 2.5), (1.5, 3.2)),
    ((0.9, 2.8), (10.1, 15.5), (72.0, 2.2), (17.0, 14.5)),
    ((5.7, 8.1), (12.0, 10.2), (30.3, 18.1), (52.0, 8.2)),
)
PRINTED_BACKWARD = (
    ((96.6, 5.9), (0.8, 1.5), (1.2, 1.3), (1.4, 1.7)),
    ((2.2, 4.1), (90.6, 11.7), (0.9, 1.3), (6.3, 8.7)),
    ((9.2, 11.5), (2.2, 3.0), (64.3, 18.5), (24.3, 17.4)),
    ((33.9, 22.3), (1.1, 1.2), (17.6, 12.5), (47.4, 10.4)),
)
NOTHING = "nothing"
INITIALS = MappingProxyType({SCHOOLS: "S", OFFICES: "O", LAYOUTS: "L"})


@dataclass(frozen=True)
class Cost:
    """Processor time, s, of training on all floors, drawn alone and with simulated ones; of reading a map; of labels.

    floors, rooms: of training on drawn ones. item, map_rooms: the map that was read and its rooms found.
    """

    floors: int
    rooms: int
    train_drawn: float
    train_all: float
    item: str
    map_rooms: int
    read: float
    label: float


@dataclass(frozen=True)
class PlacesBench:
    """What was measured: judged floors, the figures of every floor by part, and cost, None where no map was read."""

    split: LabelConvention
    seed: int
    judged: Sequence[JudgedFloor]
    items: dict[str, list[Row]]
    cost: Cost | None

    def of_part(self, part: str) -> list[JudgedFloor]:
        """The judged floors of a part."""
        return [floor for floor in self.judged if floor.part == part]


def tabulate_places(bench: PlacesBench) -> tuple[ComparisonTable, ...]:
    """Table 6.1 (places), Tables 5.2 to 5.4, calibration, and cost where it was measured."""
    return (
        compare_with_table_6_1(bench),
        compare_with_table_5_2(bench),
        compare_confusions(bench, backward=False),
        compare_confusions(bench, backward=True),
        tabulate_calibration(bench),
        *([tabulate_cost(bench.cost)] if bench.cost else []),
    )


def compare_with_table_6_1(bench: PlacesBench) -> ComparisonTable:
    """Share of wrong rooms over all rooms of a type."""
    sets = [*product((SCHOOLS, OFFICES), LABELS)]
    models = [LOCAL, CENTRAL, KLOG, *_with_steps(PIANTA), *_with_steps(MAPPED)]
    rows = []
    for model in models:
        printed = PRINTED_ERRORS.get(model, (None,) * len(sets))
        cells = [
            Cell(None, printed_mean=of_thesis)
            if model == KLOG
            else _count_errors(bench, part, model, labels, of_thesis)
            for (part, labels), of_thesis in zip(sets, printed, strict=True)
        ]
        rows.append(ComparisonRow(model, tuple(cells), digits=2))
    told = [
        f"{sum(len(floor.true.rooms) for floor in bench.of_part(part))} rooms on {len(bench.of_part(part))} floors"
        for part in (SCHOOLS, OFFICES)
    ]
    notes = (
        f"S schools: {told[0]} (thesis: 30 floors). O offices: {told[1]} (20). Whole buildings are left out.",
        "Ex-T: 500 trees, trained on floors of the same type. pianta: on both types.",
        "pianta, maps too: on a simulated map of each floor besides.",
        _tell_split(bench.split),
    )
    columns = tuple(f"{INITIALS[part]} {labels}" for part, labels in sets)
    return ComparisonTable("Table 6.1, errors of place classification", columns, tuple(rows), notes, "%")


def compare_with_table_5_2(bench: PlacesBench) -> ComparisonTable:
    """Semantic accuracies of reconstructed schools, means over maps; and of the same models on the true layouts."""
    sets = [*product(LABELS, (False, True))]
    nothing = ((None, None),) * len(sets)
    rows = []
    for part in (LAYOUTS, TRUE_LAYOUTS):
        steps = [*_with_steps(PIANTA), *_with_steps(MAPPED)] if part == LAYOUTS else [PIANTA, MAPPED]
        for model in (CENTRAL, IN_DRAWINGS_SCALE, *steps):
            printed = PRINTED_ACCURACIES if (part, model) == (LAYOUTS, CENTRAL) else nothing
            cells = [
                Cell.over((100 * _accuracy(floor, model, *each) for floor in bench.of_part(part)), of_thesis)
                for each, of_thesis in zip(sets, printed, strict=True)
            ]
            name = model if part == LAYOUTS else f"true layout: {model}"
            rows.append(ComparisonRow(name, tuple(cells)))
    columns = tuple(f"{labels} {'BC' if backward else 'FC'}" for labels, backward in sets)
    notes = (
        f"Means over {len(bench.of_part(LAYOUTS))} maps (thesis: 20), labelled by models without their building.",
        f"Ex-T: 11 features, trained on schools. {IN_DRAWINGS_SCALE}: of maps enlarged to the scale of their drawings.",
        "true layout: the same models on the true rooms, where FC is BC.",
        _tell_split(bench.split),
    )
    return ComparisonTable("Table 5.2, semantic accuracy on reconstructed layouts", columns, tuple(rows), notes, "%")


def compare_confusions(bench: PlacesBench, *, backward: bool) -> ComparisonTable:
    """Confusion in F/C/E/S, % of the rooms with a true label, means over the maps that have the label."""
    labels = LABELS[LabelSet.F_C_E_S]
    rows = []
    for model in (CENTRAL, PIANTA):
        means = average_confusions(bench.of_part(LAYOUTS), model, backward=backward)
        for place, name in enumerate(labels):
            of_thesis = (PRINTED_BACKWARD if backward else PRINTED_FORWARD)[place] if model == CENTRAL else ()
            printed = [*of_thesis, *[(None, None)] * (len(labels) + 1 - len(of_thesis))]
            cells = [
                replace(cell, printed_mean=pair[0], printed_sd=pair[1])
                for cell, pair in zip(means[place], printed, strict=True)
            ]
            rows.append(ComparisonRow(f"{model}: {name[0]}", tuple(cells)))
    title = f"Table 5.{'4' if backward else '3'}, confusion of {'true rooms (BC)' if backward else 'found rooms (FC)'}"
    note = "A row a true label, a column a given one; means over the maps that have the label."
    left = f"{NOTHING}: no found room overlaps it." if backward else "Rooms that overlap no true room are left out."
    return ComparisonTable(title, (*(name[0] for name in labels), NOTHING), tuple(rows), (note, left), "%")


def average_confusions(floors: Sequence[JudgedFloor], model: str, *, backward: bool) -> list[list[Cell]]:
    """Means over floors of each cell of their confusion matrices in F/C/E/S: a list of labels + 1 for each label."""
    labels = LABELS[LabelSet.F_C_E_S]
    each = [count_confusion(floor.pair(model, LabelSet.F_C_E_S, backward=backward), labels) for floor in floors]
    shares = np.array(each).reshape(-1, len(labels), len(labels) + 1)
    return [
        [Cell.over(column[~np.isnan(column)].tolist()) for column in of_label.T] for of_label in shares.swapaxes(0, 1)
    ]


def measure_curve(floors: Sequence[JudgedFloor], model: str, label_set: LabelSet) -> Reliability:
    """Reliability of a model over the rooms of floors whose true label is known."""
    known = [floor.known(model, label_set) for floor in floors]
    votes = [np.zeros((0, len(LABELS[label_set]))), *(votes for votes, _ in known)]
    truth = [np.zeros(0, np.intp), *(truth for _, truth in known)]
    return measure_reliability(np.concatenate(votes), np.concatenate(truth))


def tabulate_calibration(bench: PlacesBench) -> ComparisonTable:
    """Expected calibration error of the models, by part and label set."""
    sets = [*product((SCHOOLS, OFFICES, LAYOUTS), LABELS)]
    rows = []
    for model in (CENTRAL, PIANTA, MAPPED):
        curves = [measure_curve(bench.of_part(part), model, labels) for part, labels in sets]
        cells = [
            Cell(100 * curve.error if curve.counts.sum() else None, count=int(curve.counts.sum())) for curve in curves
        ]
        rows.append(ComparisonRow(model, tuple(cells)))
    notes = (
        "10 bins of equal width by the probability of the given label.",
        "S schools, O offices, L reconstructed layouts of schools, rooms that overlap no true room left out.",
    )
    columns = tuple(f"{INITIALS[part]} {labels}" for part, labels in sets)
    return ComparisonTable("Expected calibration error", columns, tuple(rows), notes, "percentage points")


def tabulate_cost(cost: Cost) -> ComparisonTable:
    """Processor times, and that of labelling in times of reading."""
    figures = {
        "training, drawn floors only": cost.train_drawn,
        "training, simulated maps too": cost.train_all,
        "reading the map": cost.read,
        "labelling its floor": cost.label,
        "labelling per reading": cost.label / cost.read,
    }
    rows = tuple(ComparisonRow(name, (Cell(figure),), digits=2) for name, figure in figures.items())
    notes = (
        f"Training on {cost.floors} floors with {cost.rooms} rooms; map of {cost.item}, {cost.map_rooms} rooms found.",
        "Time of all threads, without making the simulated maps.",
    )
    return ComparisonTable("Cost", ("processor s",), rows, notes)


def _with_steps(model: str) -> list[str]:
    return [model, *(name_step(model, step) for step in STEPS)]


def _count_errors(bench: PlacesBench, part: str, model: str, labels: LabelSet, printed: float | None) -> Cell:
    pairs = [pair for floor in bench.of_part(part) for pair in floor.pair(model, labels)]
    error = 100 - 100 * semantic_accuracy(pairs) if pairs else None
    return Cell(error, printed_mean=printed, count=len(pairs))


def _accuracy(floor: JudgedFloor, model: str, labels: LabelSet, backward: bool) -> float:  # noqa: FBT001
    return semantic_accuracy(floor.pair(model, labels, backward=backward))


def _tell_split(split: LabelConvention) -> str:
    return f"Labels are divided as in the thesis' {split} (docs/labels.md)."
