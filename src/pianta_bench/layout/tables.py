"""Table 3.1a beside the published one, and the figures of each map."""

from __future__ import annotations

from dataclasses import replace

from pianta_bench.harness.records import Results, name_parts
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.layout.graph_scores import F1_SCORES, ITEMS, pool_maps
from pianta_bench.layout.measure import PERCENT
from pianta_bench.layout.timing import FAILED_NOTE, TIME_NOTE

LABELS = {
    "a_fc_free": "A_FC\nfree",
    "a_bc_free": "A_BC\nfree",
    "a_fc_walls": "A_FC\nwalls",
    "a_bc_walls": "A_BC\nwalls",
    "mean_iou": "mean\nIoU",
    "f1": "\nF1",
    "door_precision": "doors\nP",
    "door_recall": "doors\nR",
    "found": "rooms\nfound",
    "true": "\ntrue",
    "seconds": "time\ns",
    "transforms": "time\nDT",
}
PUBLISHED_MAPS = 20  # thesis, Table 3.1a
COUNT_NOTE = "free: the free cells of the map count; walls: the whole polygons count, with the walls between rooms."
DOOR_NOTE = "doors: pairs of true rooms that reconstructed doors join, against those that true doors join."

MAPS = Table(
    title="Layout reconstruction of each map, {part}, method {method}",
    rows=("item",),
    columns=("metric",),
    where={"metric": list(LABELS)},
    labels=LABELS,
    summarise=Cell.only,
    digits={"seconds": 2},
    summaries=("mean", "sd", "median"),
    notes=(COUNT_NOTE, DOOR_NOTE, TIME_NOTE),
)
TABLE_3_1A = Table(
    title="Table 3.1a, accuracy of layout reconstruction, method {method}",
    rows=("part",),
    columns=("metric",),
    where={"metric": list(PERCENT)},
    labels=LABELS,
    published="table_3_1a.csv",
    unit="%",
)


MEANS = replace(TABLE_3_1A, title="Accuracy of layout reconstruction, method {method}", published="")
GRAPH_LABELS = {
    f"{item}_{score}": f"{item}\n{label}"
    for item in ITEMS
    for score, label in {
        "f1": "F1",
        "pooled_precision": "pooled P",
        "pooled_recall": "pooled R",
        "pooled_f1": "pooled F1",
        "true": "true",
    }.items()
}
GRAPH_NOTE = (
    "doors: a door is right within half the width of the true one, at least 0.45 m, from middle to middle, one to one. "
    "edges: pairs of rooms that doors join; an edge is right if both rooms match true rooms (IoU above 0.5 on free "
    "cells) that are joined. pairs: pairs of true rooms that doors join, where a room stands for the true one that it "
    "overlaps most, as in doors P and R. F1: mean over the maps; pooled: those of all maps together."
)
SCHOOL_NOTE = (
    "The true doors of schools are points that often lie beside the gaps of the map, which edges and pairs ignore."
)
GRAPH = Table(
    title="Doors and edges of the room graph, method {method}",
    rows=("part",),
    columns=("metric",),
    where={"metric": list(GRAPH_LABELS)},
    labels=GRAPH_LABELS,
    digits=dict.fromkeys((f"{item}_true" for item in ITEMS), 0),
    unit="%",
    notes=(GRAPH_NOTE,),
)
COUNT_LABELS = {
    label: text
    for item in ITEMS
    for label, text in {
        f"{item}_f1": f"{item}\nF1",
        f"true_{item}": f"{item}\ntrue",
        f"found_{item}": f"{item}\nfound",
        f"right_{item}": f"{item}\nright",
    }.items()
}
GRAPH_OF_MAPS = Table(
    title="Doors and edges of each map, {part}, method {method}",
    rows=("item",),
    columns=("metric",),
    where={"metric": list(COUNT_LABELS)},
    labels=COUNT_LABELS,
    summarise=Cell.only,
    summaries=("mean", "sd", "median"),
)


def tabulate(results: Results) -> list[FilledTable]:
    """The figures of the maps; their means, those of schools beside Table 3.1a; doors and edges of each set."""
    method, parts = results.options["method"], [*name_parts(results.items)]
    tables = [MAPS.fill(results.select(part=part), part=part, method=method) for part in parts]
    failed = [FAILED_NOTE] * results.failed
    if others := [part for part in parts if part != "schools"]:
        tables.append(MEANS.narrow(part=others).fill(results.records, notes=failed, method=method))
    if "schools" in parts:
        schools = [item for item in results.items if item.part == "schools"]
        notes = [f"The thesis' figures are over {PUBLISHED_MAPS} maps; here are {len(schools)}.", *failed]
        tables.append(TABLE_3_1A.fill(results.select(part="schools"), notes=notes, method=method))
    if results.options["maps"]:
        tables += [GRAPH_OF_MAPS.fill(results.select(part=part), part=part, method=method) for part in parts]
    pooled = [record for part in parts for record in pool_maps(results, part)]
    own = results.select(metric=list(F1_SCORES))
    return [*tables, GRAPH.fill([*own, *pooled], notes=[SCHOOL_NOTE] * ("schools" in parts), method=method)]
