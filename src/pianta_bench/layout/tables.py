"""Table 3.1a beside the published one, and the figures of each map."""

from __future__ import annotations

from pianta_bench.harness.records import Results
from pianta_bench.harness.tables import Cell, FilledTable, Table
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
    title="Layout reconstruction of each map, method {method}",
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


def tabulate(results: Results) -> list[FilledTable]:
    """The figures of the maps; then their means, beside those of Table 3.1a."""
    method = results.options["method"]
    notes = [f"The thesis' figures are over {PUBLISHED_MAPS} maps; here are {len(results.items)}."]
    notes += [FAILED_NOTE] * results.failed
    return [
        MAPS.fill(results.records, method=method),
        TABLE_3_1A.fill(results.records, notes=notes, method=method),
    ]
