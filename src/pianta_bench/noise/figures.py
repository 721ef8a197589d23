"""Curves of bench noise: rooms, labels and building type over the levels of each factor."""

from __future__ import annotations

from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING

from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Results
from pianta_bench.noise.factors import FACTORS
from pianta_bench.noise.measure import LABELS, ROOMS, TYPES
from pianta_bench.noise.tables import list_levels
from pianta_bench.types.maps import RIGHT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CURVES = (ROOMS, LABELS, TYPES[RIGHT])
# Paul Tol's "bright" scheme, for colour-blind readers.
COLORS = ("#4477aa", "#cc6633", "#228833", "#aa3377", "#66ccee", "#ccbb44")
DPI = 130


def save_figures(results: Results, folder: Path) -> None:
    """Write curves.png into a folder; raises PiantaError if it cannot be written."""
    save_chart(draw_curves(results), folder / "curves.png", dpi=DPI)


def draw_curves(results: Results) -> Figure:
    """Means over the floors: a column of panels for each factor, a row for each figure that a method has."""
    factors = results.options["factors"]
    metrics = [metric for metric in CURVES if results.select(metric=metric)]
    figure = start_chart(2.9 * len(factors) + 1.2, 2.4 * len(metrics) + 0.8)
    panels = figure.subplots(len(metrics), len(factors), squeeze=False, sharey=True)
    for row, metric in zip(panels, metrics, strict=True):
        for ax, factor in zip(row, factors, strict=True):
            plot_factor(results, factor, metric, ax=ax)
        row[0].set_ylabel(f"{metric}, %")
    for ax, factor in zip(panels[-1], factors, strict=True):
        ax.set_xlabel(FACTORS[factor].title)
    handles, names = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=len(names), frameon=False)
    return figure


def plot_factor(results: Results, factor: str, metric: str, *, ax: Axes) -> None:
    """Draw the mean over the floors by level, a curve for each method; the levels are evenly spaced."""
    levels = list_levels(results, factor)
    for method, color in zip(results.options["methods"], COLORS, strict=False):
        by_level = [results.values(factor=factor, level=level, method=method, metric=metric) for level in levels]
        if all(by_level):
            ax.plot(range(len(levels)), [*map(fmean, by_level)], ".-", color=color, linewidth=1.4, label=method)
    ax.set(xticks=range(len(levels)), xticklabels=levels, ylim=(-2, 102))
    ax.grid(visible=True, linewidth=0.3)
    ax.spines[["top", "right"]].set_visible(False)
