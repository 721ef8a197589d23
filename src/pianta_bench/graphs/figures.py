"""The distributions of the metrics of Table 5.1."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pianta_bench.graphs.measure import PARTS
from pianta_bench.graphs.tables import LABELS
from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Results
from pianta_bench.harness.tables import Cell, read_published

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SEED = 0  # of the horizontal positions of the dots
SPREAD = 0.18  # of the dots to both sides, in distances between two parts
PANELS_A_ROW = 5
DPI = 150
COLORS = ("#4477aa", "#cc6633")


def save_figures(results: Results, folder: Path) -> None:
    """Write graphs.png, a panel for each published metric: a dot a building, mean ± sd here and as published.

    Raises PiantaError if the file cannot be written.
    """
    published = {record["metric"] for record in read_published("table_5_1.csv")}
    metrics = [metric for metric in LABELS if metric in published]
    rows = -(-len(metrics) // PANELS_A_ROW)
    figure = start_chart(2.1 * PANELS_A_ROW, 2.3 * rows)
    axes = figure.subplots(rows, PANELS_A_ROW).ravel()
    for ax, metric in zip(axes, metrics, strict=False):
        plot_distributions(results, metric, ax=ax)
    for ax in axes[len(metrics) :]:
        ax.set_axis_off()
    axes[-1].legend(*axes[0].get_legend_handles_labels(), loc="center", frameon=False, fontsize=8)
    save_chart(figure, folder / "graphs.png", dpi=DPI)


def plot_distributions(results: Results, metric: str, *, ax: Axes) -> Axes:
    """Draw one metric: for each part its buildings as dots, and mean ± sd, measured here and published."""
    random = np.random.default_rng(SEED)
    published = {record["part"]: record for record in read_published("table_5_1.csv") if record["metric"] == metric}
    style: dict[str, Any] = {"capsize": 2.5, "markersize": 4, "elinewidth": 1}
    for x, (part, color) in enumerate(zip(PARTS.values(), COLORS, strict=True)):
        figures = results.values(part=part, metric=metric)
        cell = Cell.over(figures)
        positions = x + random.uniform(-SPREAD, SPREAD, len(figures))
        ax.scatter(positions, figures, s=7, color=color, alpha=0.5, linewidths=0)
        if cell.mean is not None:
            label = "mean ± sd here" if not x else None
            ax.errorbar(x - 0.3, cell.mean, cell.sd or 0.0, fmt="o", color="#222222", label=label, **style)
        label = "mean ± sd in the thesis" if not x else None
        mean, sd = (float(published[part][name]) for name in ("mean", "sd"))
        ax.errorbar(x + 0.3, mean, sd, fmt="D", color="#999999", label=label, **style)
    ax.set_title(LABELS[metric], fontsize=9)
    ax.set_xticks(range(len(PARTS)), [*PARTS.values()], fontsize=8)
    ax.set_xlim(-0.5, len(PARTS) - 0.5)
    ax.tick_params(axis="y", labelsize=7)
    ax.spines[["top", "right"]].set_visible(False)
    return ax
