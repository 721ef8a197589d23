"""Table 5.1: metrics of annotated schools and offices as graphs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from pianta.graphs.centrality import drop_isolated, measure_decay
from pianta.graphs.metrics import GRAPH_METRICS, find_corridors, measure_graph
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.labels import schema_of
from pianta_bench.data.folders import list_maps
from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.comparison import Cell, ComparisonRow, ComparisonTable, Items
from pianta_bench.harness.table import Column, Figures, Row, measure_rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Folder of data/buildings, and the name of the part.
PARTS = MappingProxyType({"school": "schools", "office": "offices"})
DECAY = "decay"
# As Table 5.1 has them.
CENTRALITY_NAMES = MappingProxyType(
    {"betweenness": "betw-cen", "closeness": "closn-cen", "eigenvector": "eig-cen", "katz": "katz-cen"}
)
NAMES = MappingProxyType(
    {
        "nodes": "nodes",
        "edges": "edges",
        "nodes_r": "nodes R",
        "nodes_c": "nodes C",
        "path_length": "path-length",
        "diameter": "diameter",
        "art_points": "art-points",
        "assortativity": "assortativity",
        **{
            key + suffix: name + of
            for key, name in CENTRALITY_NAMES.items()
            for suffix, of in (("", ""), ("_r", " R"), ("_c", " C"))
        },
        DECAY: "sum of 2^-d",
    }
)
# Mean and standard deviation of schools, then of offices.
PRINTED: Mapping[str, tuple[tuple[float, float], tuple[float, float]]] = MappingProxyType(
    {
        "nodes": ((35.24, 18.33), (45.15, 16.22)),
        "nodes_r": ((27.84, 15.05), (34.25, 12.94)),
        "nodes_c": ((7.42, 4.45), (10.90, 4.54)),
        "path_length": ((3.33, 0.81), (3.51, 0.52)),
        "diameter": ((6.34, 2.30), (6.9, 1.52)),
        "art_points": ((8.8, 5.81), (10.65, 3.99)),
        "assortativity": ((-0.51, 0.20), (-0.50, 0.13)),
        "betweenness": ((0.039, 0.011), (0.0302, 0.013)),
        "betweenness_r": ((0.005, 0.006), (0.003, 0.003)),
        "betweenness_c": ((0.181, 0.090), (0.117, 0.044)),
        "closeness": ((0.328, 0.086), (0.245, 0.089)),
        "closeness_r": ((0.309, 0.077), (0.246, 0.083)),
        "closeness_c": ((0.418, 0.160), (0.311, 0.113)),
        "eigenvector": ((0.256, 0.078), (0.219, 0.067)),
        "eigenvector_r": ((0.197, 0.062), (0.158, 0.046)),
        "eigenvector_c": ((0.498, 0.181), (0.401, 0.123)),
        "katz": ((0.181, 0.045), (0.152, 0.031)),
        "katz_r": ((0.166, 0.045), (0.138, 0.032)),
        "katz_c": ((0.241, 0.076), (0.198, 0.031)),
    }
)
PRINTED_COUNTS = (50, 20)
# The first rows count something of a few tens, shown to two digits as printed; the others are shares.
TWO_DIGITS = GRAPH_METRICS[: GRAPH_METRICS.index("betweenness")]
NOTES = (
    "Rooms without a door are left out; C: CORRIDOR, HALL, LOBBY, ENTRANCE, OPENSPACE; R: all others.",
    "closn-cen is the usual closeness; the last row is what section 5.1 prints for it.",
)
SEED, PANELS_A_ROW, SPREAD = 0, 5, 0.18
DPI = 150
COLORS = ("#4477aa", "#cc6633")


def measure_graphs(
    data: Path, *, pictures: Path | None = None, track: Callable[[Sequence[str]], Iterable[str]] = iter
) -> tuple[tuple[ComparisonTable, ...], Items]:
    """Table 5.1 over data/buildings/school/*.xml and data/buildings/office/*.xml, and the metrics of each building.

    A building that cannot be read or has unknown labels has no figures and does not count.
    pictures: an existing folder for graphs.png, the distributions. track: wraps the buildings, to show progress.
    Raises DataError when there are no buildings of a type.
    """
    folders = {kind: data / "buildings" / kind for kind in PARTS}
    names = {kind: list_maps(folder, ".xml") for kind, folder in folders.items()}
    tracked = iter(track([f"{kind}/{name}" for kind in PARTS for name in names[kind]]))
    columns = [Column(key, NAMES[key], "") for key in (*GRAPH_METRICS, DECAY)]
    items: dict[str, tuple[Row, ...]] = {}
    for kind, part in PARTS.items():
        measure = partial(_measure_building, folder=folders[kind], kind=kind)
        own = (next(tracked).removeprefix(f"{kind}/") for _ in names[kind])
        items[part] = measure_rows(own, measure, columns=columns)
    if pictures:
        save_distributions(items, pictures / "graphs.png")
    return (compare_with_table_5_1(items),), items


def compare_with_table_5_1(items: Items) -> ComparisonTable:
    """Means over the buildings of each part, beside those of Table 5.1."""
    rows = []
    for key, name in NAMES.items():
        printed = PRINTED.get(key, ((None, None), (None, None)))
        cells = [
            Cell.over((row.figures[key] for row in rows_of_part), pair)
            for rows_of_part, pair in zip(items.values(), printed, strict=True)
        ]
        rows.append(ComparisonRow(name, tuple(cells), 2 if key in TWO_DIGITS else 3))
    counted = [sum(not row.failure for row in rows_of_part) for rows_of_part in items.values()]
    told = (f"{part} {here} (thesis {there})" for here, part, there in zip(counted, items, PRINTED_COUNTS, strict=True))
    title = "Table 5.1, metrics of buildings as graphs"
    return ComparisonTable(title, tuple(items), tuple(rows), (f"Buildings: {', '.join(told)}.", *NOTES))


def save_distributions(items: Items, path: Path) -> None:
    """Write a PNG with a panel for each row of Table 5.1: a dot a building, mean ± sd here and as printed.

    Raises PiantaError when the file cannot be written.
    """
    keys = [key for key in NAMES if key in PRINTED]
    rows = -(-len(keys) // PANELS_A_ROW)
    figure = start_chart(2.1 * PANELS_A_ROW, 2.3 * rows)
    axes = figure.subplots(rows, PANELS_A_ROW).ravel()
    for ax, key in zip(axes, keys, strict=False):
        plot_distributions(items, key, ax=ax)
    for ax in axes[len(keys) :]:
        ax.set_axis_off()
    axes[-1].legend(*axes[0].get_legend_handles_labels(), loc="center", frameon=False, fontsize=8)
    save_chart(figure, path, dpi=DPI)


def plot_distributions(items: Items, key: str, *, ax: Axes) -> Axes:
    """Draw one metric: for each part its buildings as dots, and mean ± sd, measured here and printed."""
    random = np.random.default_rng(SEED)
    for place, (rows, printed, color) in enumerate(zip(items.values(), PRINTED[key], COLORS, strict=True)):
        figures = [figure for row in rows if (figure := row.figures[key]) is not None]
        cell = Cell.over(figures)
        beside = random.uniform(-SPREAD, SPREAD, len(figures))
        ax.scatter(place + beside, figures, s=7, color=color, alpha=0.5, linewidths=0)
        style: dict[str, Any] = {"capsize": 2.5, "markersize": 4, "elinewidth": 1}
        if cell.mean is not None:
            label = "mean ± sd here" if not place else None
            ax.errorbar(place - 0.3, cell.mean, cell.sd or 0.0, fmt="o", color="#222222", label=label, **style)
        label = "mean ± sd in the thesis" if not place else None
        ax.errorbar(place + 0.3, *printed, fmt="D", color="#999999", label=label, **style)
    ax.set_title(NAMES[key], fontsize=9)
    ax.set_xticks(range(len(items)), items, fontsize=8)
    ax.set_xlim(-0.5, len(items) - 0.5)
    ax.tick_params(axis="y", labelsize=7)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def _measure_building(name: str, *, folder: Path, kind: str) -> Iterator[Figures]:
    graph = drop_isolated(read_building_xml(folder / f"{name}.xml").graph())
    measured = measure_graph(graph, find_corridors(graph, schema_of(kind)))
    decay = list(measure_decay(graph).values())
    yield measured | {DECAY: float(np.mean(decay)) if decay else None}
