"""The table of the departures, for each set of maps, beside what the thesis prints."""

from __future__ import annotations

from pianta_bench.departures.measure import CHANGES, SCORES, list_variants
from pianta_bench.harness.records import Results, name_parts
from pianta_bench.harness.tables import FilledTable, Table
from pianta_bench.layout.timing import FAILED_NOTE

LABELS = {
    "a_fc_walls": "A_FC\nwalls",
    "a_bc_walls": "A_BC\nwalls",
    "precision_rest": "prec.\nrest",
    "recall_rest": "recall\nrest",
    "mean_iou": "mean\nIoU",
    "f1": "\nF1",
    "rooms": "rooms\nfound %",
    "mean_iou_change": "change\nIoU",
    "f1_change": "change\nF1",
}
NOTE = (
    "+: as printed, with this departure alone; −: ours without it. change: from “thesis as printed” for + and ours, "
    "from ours for −, the mean ± sd of the differences of single maps. A_FC, A_BC: whole polygons, against the drawn "
    "layout. prec., recall: free cells, those in no room as one more room. IoU and F1: as in "
    "`pianta bench segmentation`. rooms found: in % of the true ones."
)
DEPARTURES_OF_SET = Table(
    title="Algorithm 1 as printed and our departures from it, {part}",
    rows=("variant",),
    columns=("metric",),
    where={"metric": [*SCORES, "rooms", *(f"{score}_change" for score in CHANGES)]},
    labels=LABELS,
    published="departures.csv",
    unit="%",
    notes=(NOTE,),
)


def tabulate(results: Results) -> list[FilledTable]:
    """One table for each set."""
    tables = []
    for part in name_parts(results.items):
        count = len({item.item for item in results.items if item.part == part})
        notes = [f"The thesis' figures are over 20 maps; here are {count}.", *[FAILED_NOTE] * results.failed]
        table = DEPARTURES_OF_SET.narrow(part=part, variant=list(list_variants(part)))
        tables.append(table.fill(results.records, notes=notes, part=part))
    return tables
