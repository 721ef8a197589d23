"""Rooms by all methods over the levels of each factor; then labels and building types."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import FilledTable, Table
from pianta_bench.noise.factors import FACTORS
from pianta_bench.noise.measure import CLEAN, LABELLED, LABELS, ROOMS, TYPES

ROOMS_NOTE = (
    "F1 of rooms that match one to one with an IoU above 0.5, on the cells of the true rooms, which bend with the "
    "walls; rooms of up to 0.25 m² are dropped."
)
LABELS_NOTE = (
    "labels: F/C/E/S, each room found against the true one that it overlaps most (eq. 5.1); type: of the building. By "
    "models without the building, of made floors by those that come with pianta."
)
FLOORS_NOTE = "Floors: {floors}."
FAILED_NOTE = "A map that failed counts as 0."

ROOMS_OF_FACTOR = Table(
    title="Rooms over {title}",
    rows=("level",),
    columns=("method",),
    where={"metric": ROOMS},
    unit="%",
)
LABELS_OF_FACTOR = Table(
    title="Labels and building type over {title}",
    rows=("level",),
    columns=("column",),
    unit="%",
)


def tabulate(results: Results) -> list[FilledTable]:
    """For each factor the rooms, then labels and types if a method has them; rows are levels."""
    tables = []
    for name in results.options["factors"]:
        records, title = results.select(factor=name), FACTORS[name].title
        levels = list_levels(results, name)
        rooms = ROOMS_OF_FACTOR.narrow(level=levels, method=[*results.options["methods"]])
        tables.append(rooms.fill(records, title=title))
        if labelled := [*name_columns(records)]:
            tables.append(LABELS_OF_FACTOR.narrow(level=levels).fill(labelled, title=title))
    notes = [ROOMS_NOTE, *[LABELS_NOTE] * any(method in LABELLED for method in results.options["methods"])]
    notes += [FLOORS_NOTE.format(floors=", ".join(results.options["floors"])), *[FAILED_NOTE] * results.failed]
    return [*tables[:-1], replace(tables[-1], notes=tuple(notes))]


def list_levels(results: Results, factor: str) -> list[str]:
    """The levels of a factor, from the clean map on."""
    chosen = FACTORS[factor].choose_levels(results.options["levels"])
    return [CLEAN, *(FACTORS[factor].name_level(level) for level in chosen)]


def name_columns(records: list[Record]) -> Iterator[Record]:
    """The records of labels and types, by metric and method, with the column of the table that they belong to."""
    for metric in (LABELS, *TYPES.values()):
        for method in LABELLED:
            for record in records:
                if (record["metric"], record["method"]) == (metric, method):
                    yield {**record, "column": f"{method}\n{metric}"}
