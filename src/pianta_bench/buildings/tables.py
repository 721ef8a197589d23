"""Table 6.1 beside that of the thesis, areas below curves, confusion of types, processor time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from pianta._types import Mask
from pianta.labels import LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.buildings.fact_files import CHOSEN, FILES, FactScores
from pianta_bench.buildings.measure import BUILDING_TASK, FLOOR_TASK, ROOM_TASK, SECONDS, WRONG_ROOMS
from pianta_bench.buildings.models import KLOG, MODELS
from pianta_bench.buildings.scores import BOTH, BUILDING, FLOOR, POSITIVE, Scores
from pianta_bench.buildings.scores import PARTS as SHORT_TYPES
from pianta_bench.data.annotated_floors import KINDS
from pianta_bench.harness.error_rates import STATISTICS, STATISTICS_NOTE, measure_error_rates
from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.places.models import PIANTA

PUBLISHED_KLOG = "kLog"
OWN_MODELS = f"Ex-T and {KLOG}"
CHANCE = "chance"
SCHOOLS = "schools"
OFFICES = "offices"
# Counted with the 30 schools and 20 offices of the thesis.
PRINTED = (
    "Printed figures stand where they can be: 5.00 is no share of the thesis' 50 floors, but 2 of 20 offices",
    "or 3 of 30 schools give it as a mean over classes; 8.00 is 4 of the 50 floors, and no such mean.",
)


def share_wrong(floors: Sequence[Any]) -> Cell:
    """Share of errors, %; floors: True or 1 for an error, one value or an array for each floor."""
    wrong = np.concatenate([np.atleast_1d(each) for each in floors])
    return Cell(100 * float(wrong.mean()), count=len(wrong))


def show_rate(rates: Sequence[tuple[float | None, int]]) -> Cell:
    """The only error rate, %, and the number of floors."""
    ((rate, floors),) = rates
    return Cell(rate, count=floors)


def add_seconds(seconds: Sequence[float]) -> Cell:
    """The sum of seconds."""
    return Cell(sum(seconds))


ROOMS = Table(
    title="Table 6.1, errors of place classification",
    unit="%",
    rows=("model",),
    columns=("part", "labels"),
    where={
        "model": [PUBLISHED_KLOG if model == KLOG else model for model in MODELS],
        "part": [SCHOOLS, OFFICES],
        "labels": list(LABELS),
    },
    labels={SCHOOLS: "S", OFFICES: "O", PUBLISHED_KLOG: KLOG},
    summarise=share_wrong,
    digits=2,
    published="table_6_1_places.csv",
)
TYPES = Table(
    title="Table 6.1, errors of building classification",
    unit="%",
    rows=("model",),
    columns=("labels", "statistic"),
    where={
        "model": ROOMS.where["model"],
        "labels": list(LABELS),
        "statistic": list(STATISTICS),
        "left_out": BUILDING,
    },
    labels={PUBLISHED_KLOG: KLOG},
    summarise=show_rate,
    digits=2,
    published="table_6_1_buildings.csv",
    notes=(STATISTICS_NOTE,),
)
ONE_FLOOR = replace(TYPES, title=f"{TYPES.title}, one floor left out", where={**TYPES.where, "left_out": FLOOR})
OTHER_TYPES = replace(TYPES, title="Building classification, errors", published="")
FACT_FILES = replace(
    TYPES,
    title="Table 6.1, building classification on the thesis' fact files",
    where={"model": [PUBLISHED_KLOG, CHOSEN], "labels": list(FILES), "statistic": list(STATISTICS)},
)
FLOOR_ERRORS = Table(
    title="Place classification, errors of floors",
    unit="% of a floor's rooms",
    rows=("model",),
    columns=("part", "labels"),
    where={"model": list(MODELS), "part": [SCHOOLS, OFFICES], "labels": list(LABELS), "metric": WRONG_ROOMS},
    labels=ROOMS.labels,
)
AREAS = Table(
    title="Figs. 6.2 and 6.3, areas below curves",
    rows=("model",),
    columns=("part", "curve"),
    where={"model": [*MODELS, CHANCE], "part": [*SHORT_TYPES.values(), BOTH], "curve": ["ROC", "PR"]},
    digits=3,
    notes=(
        f"R/C. Places: positive is CORRIDOR. Buildings: positive is {POSITIVE}; one building left out.",
        "PR: precision over recall, the area below its steps.",
    ),
)
CONFUSION = Table(
    title="Confusion of building types, {labels}",
    unit="floors",
    rows=("model", "true"),
    columns=("predicted",),
    summarise=lambda counts: Cell(counts[0][0], count=counts[0][1]),
    digits=0,
    notes=("Rows: true types, columns: predicted ones.",),
)
TIMES = Table(
    title="Processor time",
    unit="s",
    rows=("item",),
    columns=("metric",),
    where={"part": SECONDS, "item": [*MODELS, OWN_MODELS], "metric": [ROOM_TASK, BUILDING_TASK, FLOOR_TASK]},
    summarise=add_seconds,
    notes=("Processor time of all threads, without reading floors and describing their rooms.",),
)


def tabulate(results: Results) -> list[FilledTable]:
    """Table 6.1, places floor by floor, one floor left out, areas and times; of folders errors, confusion and times."""
    scores: Scores = results.objects["scores"]
    rates = [*_rename_klog(derive_rates(scores))]
    times = [*results.records, *_join_times(results)]
    if not results.objects["is_table_6_1"]:
        counts = ", ".join(f"{name} {len(scores.list_type(name))} floors" for name in scores.building_types)
        trees = (
            f"{counts}. Whole buildings are left out. Ex-T: Extra-Trees on single rooms, {results.options['trees']} "
            "trees; a floor gets the type of most of its rooms. kLog-style: a relational kernel on whole floors. "
            "Unlike all training floors: pianta read would call the type unknown."
        )
        confusions = [CONFUSION.fill(_count_types(scores, each), labels=each) for each in LABELS]
        types = OTHER_TYPES.fill(rates, notes=(trees, *_name_wrong_floors(scores, BUILDING)))
        return [types, *confusions, TIMES.fill(times)]
    left_out = "Whole buildings are left out."
    learned = "The models are trained on the other floors of the building, as in the thesis."
    return [
        ROOMS.fill(_rename_klog(_list_wrong_rooms(scores)), notes=_note_rooms(results)),
        TYPES.fill(rates, notes=(*PRINTED, left_out, *_name_wrong_floors(scores, BUILDING))),
        ONE_FLOOR.fill(rates, notes=(learned, *_name_wrong_floors(scores, FLOOR))),
        *fill_fact_files(results.objects["facts"]),
        FLOOR_ERRORS.fill(results.records),
        AREAS.fill(_list_areas(scores)),
        TIMES.fill(times, notes=("Thesis: 20 minutes for kLog, 1 hour for Ex-T.",)),
    ]


def fill_fact_files(facts: FactScores) -> Iterator[FilledTable]:
    """The table of the fact files, if they are there."""
    if not facts.floors:
        return
    types = [floor.kind for floor in facts.floors]
    wrong = {key: facts.wrong_floors(*key) for key in facts.types}
    records = (
        {"model": model, "labels": label_set, "statistic": statistic, "value": (rate, len(types))}
        for (model, label_set), each in wrong.items()
        for statistic, rate in measure_error_rates(types, each.tolist()).items()
    )
    counts = " and ".join(f"{types.count(name)} {name}s" for name in KINDS)
    items = [floor.item for floor in facts.floors]
    yield FACT_FILES.fill(
        _rename_klog(records),
        notes=(
            f"{counts} (thesis: 30 and 20), whole buildings left out. The printed 8.00 is 4 of 50 floors.",
            "type: the labels of the types, such as CLASSROOM, whose names alone can reveal a type.",
            f"{CHOSEN}: bins and C with the fewest errors on the training floors.",
            *(f"Wrong, {', '.join(key)}: {_name(items, each)}." for key, each in wrong.items()),
        ),
    )


def derive_rates(scores: Scores) -> Iterator[Record]:
    """The error rates of building types, %, by what was left out, model, label set and statistic."""
    types = [floor.annotated.kind for floor in scores.floors]
    for left_out, model, label_set in scores.types:
        rates = measure_error_rates(types, scores.wrong_floors(left_out, model, label_set).tolist())
        for statistic, rate in rates.items():
            fields = {"left_out": left_out, "model": model, "labels": label_set, "statistic": statistic}
            yield {**fields, "value": (rate, len(types))}


def _rename_klog(records: Iterable[Record]) -> Iterator[Record]:
    """Records in which the relational kernel has the name of the published method that it replaces."""
    for record in records:
        yield {**record, "model": PUBLISHED_KLOG} if record.get("model") == KLOG else record


def _list_wrong_rooms(scores: Scores) -> Iterator[Record]:
    """Which rooms of each floor are wrong."""
    for (model, label_set), (index, floor) in product(scores.rooms, enumerate(scores.floors)):
        wrong = scores.wrong_rooms(index, model, label_set)
        yield {"part": f"{floor.annotated.kind}s", "model": model, "labels": label_set, "value": wrong}


def _list_areas(scores: Scores) -> Iterator[Record]:
    for part, model, curve_name, curve in scores.measure_curves():
        yield {"part": part, "model": model, "curve": curve_name, "value": curve.area}
        if model == MODELS[0]:
            yield {"part": part, "model": CHANCE, "curve": curve_name, "value": curve.chance}


def _count_types(scores: Scores, label_set: LabelSet) -> Iterator[Record]:
    """Number of floors of each true type with each predicted type, and number of floors of the true type."""
    true = [floor.annotated.kind for floor in scores.floors]
    for model, one, other in product(MODELS, scores.building_types, scores.building_types):
        pairs = [*zip(true, scores.predicted_types(BUILDING, model, label_set), strict=True)]
        yield {"model": model, "true": one, "predicted": other, "value": (pairs.count((one, other)), true.count(one))}


def _join_times(results: Results) -> Iterator[Record]:
    """The times of Extra-Trees and the relational kernel together."""
    for record in results.select(part=SECONDS, item=list(MODELS[:-1])):
        yield {**record, "item": OWN_MODELS}


def _note_rooms(results: Results) -> tuple[str, ...]:
    """The notes below the tables: rooms and floors of both types, training, and label convention."""
    scores = results.objects["scores"]
    floors = {name: [scores.floors[index].annotated.floor for index in scores.list_type(name)] for name in KINDS}
    schools, offices = (
        f"{sum(len(floor.rooms) for floor in each)} rooms on {len(each)} floors" for each in floors.values()
    )
    return (
        f"S schools: {schools} (thesis: 30 floors). O offices: {offices} (20). Whole buildings are left out.",
        f"Trained on floors of the same type, {PIANTA} on both. Ex-T: {results.options['trees']} trees (thesis: 500).",
        f"{KLOG}: the thesis' column has kLog.",
        f"Labels are divided as in the thesis' {results.options['convention']} (docs/methods/labels.md).",
    )


def _name_wrong_floors(scores: Scores, left_out: str) -> Iterator[str]:
    """For each model and label set the floors with a wrong type; for pianta also those unlike all training floors."""
    items = [floor.annotated.item for floor in scores.floors]
    for model, label_set in product(MODELS, LABELS):
        wrong = scores.wrong_floors(left_out, model, label_set)
        yield f"Wrong, {model}, {label_set}: {_name(items, wrong)}."
        typical = scores.types[left_out, model, label_set].typical
        if typical is not None:
            yield f"Unlike all training floors, {model}, {label_set}: {_name(items, ~typical)}."


def _name(items: Sequence[str], chosen: Mask) -> str:
    return ", ".join(item for item, is_chosen in zip(items, chosen, strict=True) if is_chosen) or "none"
