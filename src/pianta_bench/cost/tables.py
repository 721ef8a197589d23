"""What the methods cost, and how that grows with the map."""

from __future__ import annotations

from collections.abc import Iterator

from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table

COST = Table(
    title="Cost of one floor, and of many on one map",
    rows=("method", "floors"),
    columns=("metric",),
    where={"metric": ["millions", "rooms", "seconds", "transforms", "megabytes", "growth"]},
    labels={
        "millions": "cells\nmillions",
        "seconds": "time\ns",
        "transforms": "time\nDT",
        "megabytes": "peak\nMB",
    },
    summarise=Cell.only,
    digits={"seconds": 2, "transforms": 0, "megabytes": 0, "growth": 2},
    notes=("growth: time of many floors in times of as many runs on one; near 1 is linear in the number of cells.",),
)


def tabulate(results: Results) -> list[FilledTable]:
    """Two rows for each method."""
    return [COST.fill([*results.records, *derive(results)])]


def derive(results: Results) -> Iterator[Record]:
    """Millions of cells of each map, and the growth of each method."""
    for record in results.select(metric="cells"):
        yield {**record, "metric": "millions", "value": record["value"] / 1e6}
    floors = results.options["tiles"]
    for many in results.select(metric="seconds", floors=floors):
        (one,) = results.values(metric="seconds", method=many["method"], floors=1)
        yield {**many, "metric": "growth", "value": many["value"] / (floors * one)}
