"""The share of floors that repeats itself, beside the same rooms in random places."""

from __future__ import annotations

from collections import Counter

from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import FilledTable, Table
from pianta_bench.patterns.measure import BY_LABEL, PARTS, STOREYS, STRANGERS, WAYS

SHARES = ("repeated", "repeated shuffled", "repeated area", "saved", "saved shuffled", "in rows", "above all", "across")
LABELS = {
    "repeated": "in a\npattern, %",
    "repeated shuffled": "shuf-\nfled, %",
    "repeated area": "of the\narea, %",
    "saved": "follow from\nothers, %",
    "saved shuffled": "shuf-\nfled, % ",
    "in rows": "in rows,\n%",
    "above all": "floors above\nall shuffled, %",
    "largest": "rooms of the\nlargest",
    "across": "on several\nstoreys, %",
}
NOTE = (
    "Shares of the rooms, mean ± sd over floors. A pattern is a group of at least 2 rooms that is there at least "
    "twice. Follow from others: those of all occurrences but one. Shuffled: the rooms that are no corridors exchange "
    "shapes and labels at random, {shuffles} times."
)
FLOORS = Table(
    title="Model floor plans of {part}, {count} floors",
    rows=("way",),
    columns=("metric",),
    where={
        "way": list(WAYS),
        "metric": [
            *("repeated", "repeated shuffled", "repeated area", "saved", "saved shuffled"),
            *("in rows", "largest", "above all"),
        ],
    },
    labels=LABELS,
    notes=(NOTE,),
)
STOREYS_TABLE = Table(
    title="Model floor plans of several storeys, schools",
    rows=("part",),
    columns=("metric",),
    where={"part": [STOREYS, STRANGERS], "metric": ["repeated", "saved", "saved shuffled", "across", "largest"]},
    labels=LABELS,
    notes=(
        "Mean ± sd over {count} buildings of several storeys; below, the first storeys of two of them.",
        "On several storeys: rooms in patterns that have occurrences on more than one.",
    ),
)


def tabulate(results: Results) -> list[FilledTable]:
    """A table for each type of building, and one of storeys."""
    records = [_in_percent(record) for record in results.records]
    counts = Counter(record["part"] for record in results.select(metric="rooms", way=BY_LABEL))
    tables = [
        FLOORS.narrow(part=part).fill(records, part=part, count=counts[part], **results.options)
        for part in PARTS.values()
        if counts[part]
    ]
    if counts[STOREYS]:
        tables.append(STOREYS_TABLE.fill(records, count=counts[STOREYS]))
    return tables


def _in_percent(record: Record) -> Record:
    return {**record, "value": 100 * record["value"]} if record["metric"] in SHARES else record
