"""Table 5.1 beside the published one."""

from __future__ import annotations

from pianta.graphs.metrics import GRAPH_METRICS
from pianta_bench.graphs.measure import DECAY, PARTS
from pianta_bench.harness.records import Results
from pianta_bench.harness.tables import FilledTable, Table

# Names as in Table 5.1.
CENTRALITIES = {"betweenness": "betw-cen", "closeness": "closn-cen", "eigenvector": "eig-cen", "katz": "katz-cen"}
LABELS = {
    "nodes": "nodes",
    "edges": "edges",
    "nodes_r": "nodes R",
    "nodes_c": "nodes C",
    "path_length": "path-length",
    "diameter": "diameter",
    "art_points": "art-points",
    "assortativity": "assortativity",
    **{
        key + suffix: name + rooms
        for key, name in CENTRALITIES.items()
        for suffix, rooms in (("", ""), ("_r", " R"), ("_c", " C"))
    },
    DECAY: "sum of 2^-d",
}
# The first metrics are numbers of up to a few tens, published with two digits; the others are shares.
TWO_DIGITS = GRAPH_METRICS[: GRAPH_METRICS.index("betweenness")]
PUBLISHED_BUILDINGS = {"schools": 50, "offices": 20}  # thesis, section 5.1

TABLE_5_1 = Table(
    title="Table 5.1, metrics of buildings as graphs",
    where={"metric": list(LABELS), "part": list(PARTS.values())},
    labels=LABELS,
    digits={metric: 2 if metric in TWO_DIGITS else 3 for metric in LABELS},
    published="table_5_1.csv",
)
NOTES = (
    "Rooms without a door are left out; C: CORRIDOR, HALL, LOBBY, ENTRANCE, OPENSPACE; R: all others.",
    "closn-cen is the usual closeness; the last row is what section 5.1 prints for it.",
)


def tabulate(results: Results) -> list[FilledTable]:
    """Means over the buildings of each part, beside those of Table 5.1."""
    counts = {part: sum(item.part == part and not item.failure for item in results.items) for part in PARTS.values()}
    counted = ", ".join(f"{part} {count} (thesis {PUBLISHED_BUILDINGS[part]})" for part, count in counts.items())
    return [TABLE_5_1.fill(results.records, notes=(f"Buildings: {counted}.", *NOTES))]
