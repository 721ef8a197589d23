"""How far numbers of rooms hold under noise and turns, of each set and of each map."""

from __future__ import annotations

from collections.abc import Iterator

from pianta_bench.harness.records import Record, Results, name_parts
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.robustness.measure import WHOLE_MAP

NOISE_COLUMNS = {
    "changed": "noise:\nchanged %",
    "noise_least": "least\nunder noise",
    "noise_most": "most\nunder noise",
}
TURN_COLUMNS = {
    "within": "turns:\nwithin %",
    "turn_least": "least\nturned",
    "turn_most": "most\nturned",
}
LABELS = {"rooms": "rooms", **NOISE_COLUMNS, **TURN_COLUMNS}
NOISE_NOTE = (
    "noise: {draws} draws of 1 % of all cells, half occupied and half free; changed: draws with a number of rooms that "
    "differs by more than 5 % from that of the map."
)
TURN_NOTE = (
    "turns: by each multiple of {turns}° (nearest cells, unknown outside); within: turns with a number of rooms that "
    "differs by at most 5 % from that of the map."
)
FAILED_NOTE = "A map that failed counts as changed by all draws and turns."

MAPS = Table(
    title="Rooms under noise and turns, {part}, method {method}",
    rows=("item",),
    columns=("metric",),
    where={"metric": list(LABELS), "variant": WHOLE_MAP},
    labels=LABELS,
    summarise=Cell.only,
    summaries=("mean",),
)
SETS = Table(
    title="Rooms under noise and turns, method {method}",
    rows=("part",),
    columns=("metric",),
    where={"metric": ["maps", "changed", "never_changed", "within", "always_within"]},
    labels={
        "maps": "maps",
        "changed": "noise:\nchanged %",
        "never_changed": "maps never\nchanged",
        "within": "turns:\nwithin %",
        "always_within": "maps always\nwithin",
    },
    digits={"maps": 0, "never_changed": 0, "always_within": 0},
)


def tabulate(results: Results) -> list[FilledTable]:
    """The figures of each map, then means of each set, and on how many maps every draw and every turn holds."""
    options = {key: results.options[key] for key in ("method", "draws", "turns")}
    parts = [*name_parts(results.items)]
    own = results.select(variant=WHOLE_MAP)
    tables = [MAPS.fill(results.select(part=part), part=part, method=options["method"]) for part in parts]
    derived = [record for part in parts for record in count_maps(results, part)]
    notes = [NOISE_NOTE.format(**options)] * bool(options["draws"])
    notes += [TURN_NOTE.format(**options)] * bool(options["turns"]) + [FAILED_NOTE] * results.failed
    return [*tables, SETS.fill([*own, *derived], notes=notes, **options)]


def count_maps(results: Results, part: str) -> Iterator[Record]:
    """The number of maps of a set, of those that no draw changes, and of those that every turn leaves within."""
    counts = {"maps": sum(item.part == part for item in results.items)}
    for count, metric, best in (("never_changed", "changed", 0), ("always_within", "within", 100)):
        values = results.values(part=part, metric=metric, variant=WHOLE_MAP)
        if values:
            counts[count] = sum(value == best for value in values)
    for metric, value in counts.items():
        yield {"part": part, "metric": metric, "value": value}
