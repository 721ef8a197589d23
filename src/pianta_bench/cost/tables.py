"""What the methods cost, and how that grows with the map."""

from __future__ import annotations

from collections.abc import Iterator

from pianta_bench.cost.stages import OTHER, STAGES, TOTAL
from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table

STAGE_NOTE = (
    "Stages: from the file of the map to all results, without the start of the program. The profiler slows stages of "
    "many small calls down more than others."
)
MIN_SECONDS = 0.01  # of a stage on one floor, for a growth that means something

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


STAGE_COST = Table(
    title="Cost of `pianta read` by stage, method structure",
    rows=("stage",),
    columns=("metric", "floors"),
    where={"stage": [*STAGES, OTHER, TOTAL], "metric": ["seconds", "share", "growth"]},
    labels={"seconds": "s", "share": "share %"},
    summarise=Cell.only,
    digits={"seconds": 2, "share": 0, "growth": 2},
    notes=(
        "1, 16: floors on the map, of each of which the last rows were not seen; growth as above.",
        STAGE_NOTE,
    ),
)


def tabulate(results: Results) -> list[FilledTable]:
    """Two rows for each method, and one for each stage."""
    tables = [COST.fill([*results.select(part="cost"), *derive(results)])]
    stages = results.select(part="stages")
    return [*tables, STAGE_COST.fill([*stages, *derive_stages(results)])] if stages else tables


def derive_stages(results: Results) -> Iterator[Record]:
    """The share of each stage, in %, and its growth: of many floors, in times of as many runs on one."""
    many = results.options["tiles"]
    for record in results.select(part="stages"):
        (total,) = results.values(part="stages", stage=TOTAL, floors=record["floors"])
        yield {**record, "metric": "share", "value": 100 * record["value"] / total}
        (one,) = results.values(part="stages", stage=record["stage"], floors=1)
        if record["floors"] == many and one >= MIN_SECONDS:
            yield {**record, "metric": "growth", "value": record["value"] / (many * one)}


def derive(results: Results) -> Iterator[Record]:
    """Millions of cells of each map, and the growth of each method."""
    for record in results.select(metric="cells"):
        yield {**record, "metric": "millions", "value": record["value"] / 1e6}
    floors = results.options["tiles"]
    for many in results.select(part="cost", metric="seconds", floors=floors):
        (one,) = results.values(part="cost", metric="seconds", method=many["method"], floors=1)
        yield {**many, "metric": "growth", "value": many["value"] / (floors * one)}
