"""How far exits are, how many rooms have one way out, and how long evacuations take."""

from __future__ import annotations

from pianta_bench.evacuation.maps import MAPS, MIN_IOU
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
MAP_LENGTHS = {
    "error": "error of a room's longest way, median room, m",
    "longest, truth": "longest way of the drawn floor, m",
    "longest, map": "the same on the map, m",
}
MAP_SHARES = {
    "exits": "exits on the map",
    "rooms": f"true rooms on the map, IoU {MIN_IOU:g}",
    "no way": "of these without a way out on the map",
    "relative error": "error of a room's longest way, median room",
    "agreement": "one or several ways out, as in truth",
    "agreement by chance": "the same, if the more frequent answer is given for all rooms of a map",
    "one way, truth": "rooms with one way out on the drawn floor",
    "one way, map": "the same on the map",
}
MAP_WAYS = Table(
    title="Evacuation on robots' maps, against the drawn floors: lengths",
    where={"metric": list(MAP_LENGTHS)},
    labels=MAP_LENGTHS,
)
MAP_ROOMS = Table(
    title="Evacuation on robots' maps, against the drawn floors: shares",
    where={"metric": list(MAP_SHARES)},
    labels=MAP_SHARES,
    factor=100,
    unit="%",
    notes=("Exits are where the drawing has them; rooms with the same room on the map count.",),
)


def tabulate(results: Results) -> list[FilledTable]:
    """Means over the floors of each part, or over maps."""
    if any(item.part == MAPS for item in results.items):
        return [MAP_WAYS.fill(results.records), MAP_ROOMS.fill(results.records)]
    counts = {part: sum(item.part == part and not item.failure for item in results.items) for part in PARTS.values()}
    counted = ", ".join(f"{part} {count}" for part, count in counts.items())
    return [WAYS.fill(results.records), ROOMS.fill(results.records, notes=(f"Floors: {counted}.",))]
