"""How far exits are, how many rooms have one way out, and how long evacuations take."""

from __future__ import annotations

from pianta_bench.graphs.measure import PARTS
from pianta_bench.harness.records import Results
from pianta_bench.harness.tables import FilledTable, Table

LENGTHS = {
    "exits": "exits",
    "people": "people",
    "median way": "way from the middle, median room, m",
    "median farthest": "way from the farthest point, median room, m",
    "longest": "longest way, m",
    "longest dead end": "longest dead end, m",
    "time": "all out after, s",
    "time without queues": "the same without queues, s",
    "delay": "delay by the worst shut door that cuts no room off, s",
}
SHARES = {
    "one way": "rooms with one way out",
    "dead ends": "dead ends behind the room's own door",
    "worst door": "rooms that the worst shut door cuts off",
    "no way": "rooms without a way out",
}
WAYS = Table(
    title="Evacuation: lengths and times of a floor",
    where={"metric": list(LENGTHS), "part": list(PARTS.values())},
    labels=LENGTHS,
    digits={"exits": 1, "people": 0, "time": 0, "time without queues": 0, "delay": 0},
)
ROOMS = Table(
    title="Evacuation: shares of the rooms of a floor",
    where={"metric": list(SHARES), "part": list(PARTS.values())},
    labels=SHARES,
    factor=100,
    unit="%",
    notes=("Exits: rooms ENTRANCE and STAIRS, as the drawings have no outer doors; they are no rooms here.",),
)


def tabulate(results: Results) -> list[FilledTable]:
    """Means over the floors of each part."""
    counts = {part: sum(item.part == part and not item.failure for item in results.items) for part in PARTS.values()}
    counted = ", ".join(f"{part} {count}" for part, count in counts.items())
    return [WAYS.fill(results.records), ROOMS.fill(results.records, notes=(f"Floors: {counted}.",))]
