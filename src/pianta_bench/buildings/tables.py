"""The tables of bench buildings: Table 6.1 beside the printed one, areas below curves, confusion, processor time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import product
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from pianta.evaluation.curves import Curve, measure_precision_recall, measure_roc
from pianta.labels import RC, LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.buildings.measure import BUILDING, BUILDINGS, FLOOR, FLOORS, PLACES, BuildingsBench
from pianta_bench.buildings.models import KLOG, MODELS
from pianta_bench.data.annotated_floors import KINDS
from pianta_bench.harness.comparison import Cell, ComparisonRow, ComparisonTable, save_comparisons
from pianta_bench.harness.table import Row
from pianta_bench.places.models import CENTRAL, LOCAL, PIANTA
from pianta_bench.places.tables import PRINTED_ERRORS

PRINTED_PLACES = MappingProxyType(
    {LOCAL: PRINTED_ERRORS[LOCAL], CENTRAL: PRINTED_ERRORS[CENTRAL], KLOG: PRINTED_ERRORS["kLog"]}
)
# R/C, F/C/E/S (Table 6.1).
PRINTED_BUILDINGS: Mapping[str, tuple[float, ...]] = MappingProxyType(
    {LOCAL: (40.0, 5.0), CENTRAL: (30.0, 5.0), KLOG: (8.0, 8.0)}
)
INITIALS = MappingProxyType({"school": "S", "office": "O"})
# What counts as positive in the curves of buildings: the rarer type.
POSITIVE = "office"
# Processor seconds that the rows of Table 6.1 may take together.
MOST_SECONDS = 60
DIGITS = 4


def tabulate_buildings(bench: BuildingsBench) -> tuple[ComparisonTable, ...]:
    """Table 6.1, places floor by floor, one floor left out, areas and times; of folders errors, confusion and times."""
    if not bench.of_thesis:
        return (tabulate_types(bench), *(tabulate_confusion(bench, each) for each in LABELS), tabulate_seconds(bench))
    return (
        compare_places(bench),
        compare_types(bench, BUILDING),
        compare_types(bench, FLOOR),
        tabulate_floors(bench),
        tabulate_areas(bench),
        tabulate_seconds(bench),
    )


def compare_places(bench: BuildingsBench) -> ComparisonTable:
    """Share of wrong rooms over all rooms of a type (Table 6.1, place classification)."""
    sets = [*product(KINDS, LABELS)]
    rows = []
    for model in MODELS:
        printed = PRINTED_PLACES.get(model, (None,) * len(sets))
        wrong = [
            np.concatenate([wrong_rooms(bench, place, model, each) for place in bench.places_of(kind)])
            for kind, each in sets
        ]
        cells = [_share(of_set, of_thesis) for of_set, of_thesis in zip(wrong, printed, strict=True)]
        rows.append(ComparisonRow(model, tuple(cells), digits=2))
    told = [
        f"{sum(len(bench.floors[place].drawn.floor.rooms) for place in bench.places_of(kind))} rooms on "
        f"{len(bench.places_of(kind))} floors"
        for kind in KINDS
    ]
    notes = (
        f"S schools: {told[0]} (thesis: 30 floors). O offices: {told[1]} (20). Whole buildings are left out.",
        f"Trained on floors of the same type, {PIANTA} on both. Ex-T: {bench.trees} trees (thesis: 500).",
        f"{KLOG}: the thesis' column has kLog.",
        f"Labels are divided as in the thesis' {bench.split} (docs/labels.md).",
    )
    columns = tuple(f"{INITIALS[kind]} {each}" for kind, each in sets)
    return ComparisonTable("Table 6.1, errors of place classification", columns, tuple(rows), notes, "%")


def compare_types(bench: BuildingsBench, left_out: str) -> ComparisonTable:
    """Share of wrong floors (Table 6.1, building classification); left_out: BUILDING, or FLOOR as in the thesis."""
    rows = tuple(ComparisonRow(model, _type_cells(bench, left_out, model), digits=2) for model in MODELS)
    title = "Table 6.1, errors of building classification"
    note = "Whole buildings are left out."
    if left_out == FLOOR:
        title += ", one floor left out"
        note = "Other floors of its building are learned from, as in the thesis."
    columns = tuple(f"S+O {each}" for each in LABELS)
    return ComparisonTable(title, columns, rows, (note, *tell_wrong_floors(bench, left_out)), "%")


def tabulate_types(bench: BuildingsBench) -> ComparisonTable:
    """Share of wrong floors of all types."""
    rows = []
    for model in MODELS:
        cells = [_share(wrong_floors(bench, BUILDING, model, each)) for each in LABELS]
        rows.append(ComparisonRow(model, tuple(cells), digits=2))
    counts = [f"{kind} {len(bench.places_of(kind))} floors" for kind in bench.building_types]
    notes = (
        f"{', '.join(counts)}. Whole buildings are left out. Ex-T: {bench.trees} trees.",
        *tell_wrong_floors(bench, BUILDING),
    )
    return ComparisonTable("Building classification, errors", tuple(map(str, LABELS)), tuple(rows), notes, "%")


def tabulate_confusion(bench: BuildingsBench, label_set: LabelSet) -> ComparisonTable:
    """How many floors of each type are given each type."""
    types = bench.building_types
    true = [floor.drawn.kind for floor in bench.floors]
    rows = []
    for model, kind in product(MODELS, types):
        given = [types[column] for column in bench.types[BUILDING, model, label_set].argmax(axis=1)]
        pairs = [pair for pair in zip(true, given, strict=True) if pair[0] == kind]
        cells = [Cell(pairs.count((kind, name)), count=len(pairs)) for name in types]
        rows.append(ComparisonRow(f"{model}: {kind}", tuple(cells), digits=0))
    note = "A row a true type, a column a given one."
    return ComparisonTable(f"Confusion of building types, {label_set}", tuple(types), tuple(rows), (note,), "floors")


def tabulate_floors(bench: BuildingsBench) -> ComparisonTable:
    """Share of wrong rooms of a floor, mean and standard deviation over floors."""
    sets = [*product(KINDS, LABELS)]
    rows = [
        ComparisonRow(
            model,
            tuple(
                Cell.over(100 * wrong_rooms(bench, place, model, each).mean() for place in bench.places_of(kind))
                for kind, each in sets
            ),
        )
        for model in MODELS
    ]
    columns = tuple(f"{INITIALS[kind]} {each}" for kind, each in sets)
    return ComparisonTable("Place classification, errors of floors", columns, tuple(rows), (), "% of a floor's rooms")


def tabulate_areas(bench: BuildingsBench) -> ComparisonTable:
    """Areas below the curves of Figs. 6.2 and 6.3."""
    curves = draw_curves(bench)
    parts = [*dict.fromkeys(part for part, _ in curves)]
    rows = [
        ComparisonRow(model, tuple(Cell(curve.area) for part in parts for curve in curves[part, model]), digits=3)
        for model in MODELS
    ]
    chance = [Cell(curve.chance) for part in parts for curve in curves[part, MODELS[0]]]
    rows.append(ComparisonRow("chance", tuple(chance), digits=3))
    notes = (
        f"R/C. Places: positive is CORRIDOR. Buildings: positive is {POSITIVE}; one building left out.",
        "PR: precision over recall, the area that of its steps.",
    )
    columns = tuple(f"{part} {name}" for part in parts for name in ("ROC", "PR"))
    return ComparisonTable("Figs. 6.2 and 6.3, areas below curves", columns, tuple(rows), notes)


def tabulate_seconds(bench: BuildingsBench) -> ComparisonTable:
    """Processor time of training and judging, without reading the floors."""
    tasks = [task for task in (PLACES, BUILDINGS, FLOORS) if any(of_task == task for of_task, _ in bench.seconds)]
    rows = {model: [bench.seconds[task, model] for task in tasks] for model in MODELS}
    rows["Ex-T and kLog-style"] = [sum(of_task) for of_task in zip(*(rows[each] for each in MODELS[:-1]), strict=True)]
    notes = ["Processor time of all threads, without reading floors and measuring their rooms."]
    if bench.of_thesis:
        own = sum(rows["Ex-T and kLog-style"][:2])
        verdict = "kept" if own <= MOST_SECONDS else "missed"
        notes.append(f"The rows of Table 6.1 of Ex-T and {KLOG} take {own:.1f} s; bar of {MOST_SECONDS} s {verdict}.")
        notes.append("Thesis: 20 minutes for kLog, 1 hour for Ex-T.")
    shown = tuple(ComparisonRow(name, tuple(map(Cell, seconds))) for name, seconds in rows.items())
    return ComparisonTable("Processor time", tuple(tasks), shown, tuple(notes), "s")


def tell_wrong_floors(bench: BuildingsBench, left_out: str) -> Iterator[str]:
    """For each model and label set the floors whose type is wrong, and those that pianta finds unlike all it knows."""
    for model, label_set in product(MODELS, LABELS):
        wrong = np.flatnonzero(wrong_floors(bench, left_out, model, label_set))
        yield f"Wrong, {model}, {label_set}: {_name(bench, wrong)}."
        if model == PIANTA:
            unlike = np.flatnonzero(~bench.typical[left_out, label_set])
            yield f"Unlike all known, {model}, {label_set}: {_name(bench, unlike)}."


def wrong_rooms(bench: BuildingsBench, place: int, model: str, label_set: LabelSet) -> NDArray[np.bool_]:
    """Which rooms of a floor have a wrong label, shape (rooms,)."""
    given = np.array(LABELS[label_set])[bench.places[model, label_set][place].argmax(axis=1)]
    return np.asarray(given != np.array(bench.floors[place].labels[label_set]))


def wrong_floors(bench: BuildingsBench, left_out: str, model: str, label_set: LabelSet) -> NDArray[np.bool_]:
    """Which floors have a wrong type, shape (floors,)."""
    given = np.array(bench.building_types)[bench.types[left_out, model, label_set].argmax(axis=1)]
    return np.asarray(given != np.array([floor.drawn.kind for floor in bench.floors]))


def draw_curves(bench: BuildingsBench) -> dict[tuple[str, str], tuple[Curve, Curve]]:
    """ROC and precision-recall curves in R/C by part, S, O and S+O, and model."""
    curves = {}
    for kind, model in product(KINDS, MODELS):
        places = bench.places_of(kind)
        truth = [label == RC.CORRIDOR for place in places for label in bench.floors[place].labels[LabelSet.R_C]]
        scores = np.concatenate([bench.places[model, LabelSet.R_C][place] for place in places])
        curves[INITIALS[kind], model] = _measure_both(truth, scores[:, LABELS[LabelSet.R_C].index(RC.CORRIDOR)])
    positive = bench.building_types.index(POSITIVE)
    truth = [floor.drawn.kind == POSITIVE for floor in bench.floors]
    for model in MODELS:
        curves["S+O", model] = _measure_both(truth, bench.types[BUILDING, model, LabelSet.R_C][:, positive])
    return curves


def save_buildings(bench: BuildingsBench, path: Path) -> None:
    """Write every cell of the tables, the errors of every floor, its verdicts and rooms, and the curves, as JSON.

    Raises PiantaError when the file cannot be written.
    """
    curves = draw_curves(bench) if bench.of_thesis else {}
    more = {
        "split": bench.split,
        "seed": bench.seed,
        "trees": bench.trees,
        "floors": [_floor_as_json(bench, place) for place in range(len(bench.floors))],
        "curves": [
            {"part": part, "model": model, "curve": name, **_curve_as_json(curve)}
            for (part, model), both in curves.items()
            for name, curve in zip(("ROC", "PR"), both, strict=True)
        ],
    }
    save_comparisons("buildings", tabulate_buildings(bench), list_items(bench), path, more=more)


def list_items(bench: BuildingsBench) -> dict[str, list[Row]]:
    """The figures of every floor, and the floors that failed, by part."""
    items = {part: [*rows] for part, rows in bench.failed.items()}
    for place, floor in enumerate(bench.floors):
        figures = {
            f"{model}, {label_set}, wrong rooms, %": 100 * float(wrong_rooms(bench, place, model, label_set).mean())
            for model, label_set in bench.places
        }
        figures |= {
            f"{model}, {label_set}, wrong type, {left_out} left out": float(
                wrong_floors(bench, left_out, model, label_set)[place]
            )
            for left_out, model, label_set in bench.types
        }
        items.setdefault(f"{floor.drawn.kind}s", []).append(Row(floor.drawn.item, figures))
    return items


def _floor_as_json(bench: BuildingsBench, place: int) -> dict[str, object]:
    floor, types = bench.floors[place], bench.building_types
    return {
        "item": floor.drawn.item,
        "building": floor.drawn.building,
        "type": floor.drawn.kind,
        "rooms": [room.id for room in floor.drawn.floor.rooms],
        "true": {str(label_set): labels for label_set, labels in floor.labels.items()},
        "given": [
            {
                "model": model,
                "labels": str(label_set),
                "given": [LABELS[label_set][column] for column in of_floors[place].argmax(axis=1)],
            }
            for (model, label_set), of_floors in bench.places.items()
        ],
        "scores": [
            {
                "left_out": left_out,
                "model": model,
                "labels": str(label_set),
                **dict(zip(types, scores[place].round(DIGITS).tolist(), strict=True)),
            }
            for (left_out, model, label_set), scores in bench.types.items()
        ],
    }


def _curve_as_json(curve: Curve) -> dict[str, object]:
    return {**asdict(curve), "x": curve.x.round(DIGITS).tolist(), "y": curve.y.round(DIGITS).tolist()}


def _measure_both(truth: Sequence[bool], scores: NDArray[np.float64]) -> tuple[Curve, Curve]:
    return measure_roc(truth, scores.tolist()), measure_precision_recall(truth, scores.tolist())


def _type_cells(bench: BuildingsBench, left_out: str, model: str) -> tuple[Cell, ...]:
    printed = PRINTED_BUILDINGS.get(model, (None, None))
    return tuple(
        _share(wrong_floors(bench, left_out, model, label_set), of_thesis)
        for label_set, of_thesis in zip(LABELS, printed, strict=True)
    )


def _share(wrong: NDArray[np.bool_], printed: float | None = None) -> Cell:
    return Cell(100 * float(wrong.mean()), printed_mean=printed, count=len(wrong))


def _name(bench: BuildingsBench, places: NDArray[np.intp]) -> str:
    return ", ".join(bench.floors[place].drawn.item for place in places) or "none"
