"""Figs. 4.3 and 4.4: accuracies, K-distances, clusters, and how well labels agree with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import fmean, stdev
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import read_published
from pianta_bench.types.classifiers import ALGORITHMS
from pianta_bench.types.clusters import EPSILON, MIN_POINTS, OUTLIER, SCALES, RoomClusters
from pianta_bench.types.measure import BY_AREA, BY_NAME
from pianta_bench.types.tables import PUBLISHED_CLUSTERS, THESIS_FIELDS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Paul Tol's "bright" and "muted" schemes, for colour-blind readers; black is left to the outliers.
ALGORITHM_COLORS = ("#4477aa", "#66ccee", "#228833", "#ccbb44")
CLUSTER_COLORS = ("#cc6677", "#332288", "#ddcc77", "#117733", "#88ccee", "#882255", "#44aa99", "#999933", "#aa4499")
INK = "#303030"
ACCENT = "#b5123b"
DPI = 110
# The few largest rooms of a set are far larger than all others; the axes leave them out.
SHOWN_SHARE = 0.98


def save_figures(results: Results, folder: Path) -> None:
    """Write accuracy.png, k_distance.png, clusters.png and cluster_scores.png into a folder; clusters_mit.png of MIT.

    Raises PiantaError when one cannot be written.
    """
    pictures = PICTURES if results.details["sets"] else {}
    pictures = {**pictures, **({"clusters_mit.png": draw_campus} if "campus" in results.objects else {})}
    for name, draw in pictures.items():
        save_chart(draw(results), folder / name, dpi=DPI)


def draw_accuracies(results: Results) -> Figure:
    """Bars of the algorithms and their standard deviations over folds, with the thesis' means (Fig. 4.3)."""
    figure = start_chart(9.5, 4)
    captions = {BY_NAME: "S, M, B by the label's name", BY_AREA: "S, M, B by area"}
    axes = figure.subplots(1, 2, sharey=True)
    for ax, (sizes, caption) in zip(axes, captions.items(), strict=True):
        _plot_accuracies(results.select(metric="accuracy", **THESIS_FIELDS | {"sizes": sizes}), ax=ax)
        ax.set_title(caption, fontsize=11)
    axes[0].set_ylabel("accuracy, %")
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=len(handles), frameon=False, fontsize=9)
    return figure


def draw_distances(results: Results) -> Figure:
    """The K-distance plot of each set, and ε, by which ε is chosen (section 4.2.4)."""
    figure = start_chart(3.4 * len(SCALES), 3.6)
    for ax, scale in zip(figure.subplots(1, len(SCALES), sharey=True), SCALES, strict=True):
        for color, each in zip(ALGORITHM_COLORS, _select_scale(results.objects["clusters"], scale), strict=False):
            ranks = np.linspace(0, 100, len(each.distances))
            ax.plot(ranks, each.distances, color=color, linewidth=1.6, label=f"{each.rooms}, bends at {each.bend:.1f}")
        ax.axhline(EPSILON, color=ACCENT, linestyle="--", linewidth=1, label=f"ε = {EPSILON:g}")
        ax.set(xlabel="rooms, %", ylim=(0, 4 * EPSILON), xlim=(0, 100))
        ax.set_title(scale, fontsize=11)
        ax.legend(frameon=False, fontsize=8, loc="upper left")
        _clear(ax)
    figure.axes[0].set_ylabel(f"distance to the {MIN_POINTS}th room")
    return figure


def draw_clusters(results: Results) -> Figure:
    """Clusters on two principal components, one column per set, one row per scale; outliers black (Fig. 4.4a-d)."""
    count = len(results.details["sets"])
    figure = start_chart(3.5 * count, 3.0 * len(SCALES))
    rows = figure.subplots(len(SCALES), count, squeeze=False)
    for axes, scale in zip(rows, SCALES, strict=True):
        for ax, each in zip(axes, _select_scale(results.objects["clusters"], scale), strict=True):
            _plot_clusters(each, ax=ax)
        axes[0].set_ylabel(scale, fontsize=11)
    figure.supxlabel("first principal component (down: the second), without the farthest rooms", fontsize=9)
    return figure


def draw_campus(results: Results) -> Figure:
    """Clusters of the rooms of MIT on two principal components, one column per scale; outliers black (Fig. 4.4e)."""
    clusters = results.objects["campus"]
    figure = start_chart(4.5 * len(clusters), 4)
    for ax, each in zip(figure.subplots(1, len(clusters), squeeze=False)[0], clusters, strict=True):
        _plot_clusters(each, ax=ax)
        ax.set_xlabel(each.scale, fontsize=10)
    return figure


def draw_cluster_scores(results: Results) -> Figure:
    """Homogeneity and completeness over L_general, and homogeneity over R/C (Fig. 4.4f)."""
    scores = {"homogeneity": "homogeneity", "completeness": "completeness", "homogeneity_r_c": "homogeneity, R/C"}
    figure = start_chart(3.4 * len(SCALES), 3.4)
    for ax, scale in zip(figure.subplots(1, len(SCALES), sharey=True), SCALES, strict=True):
        clusters = _select_scale(results.objects["clusters"], scale)
        for number, (key, name) in enumerate(scores.items()):
            values = [each.figures[key] or 0.0 for each in clusters]
            positions = np.arange(len(clusters)) + (number - 1) * 0.27
            bars = ax.bar(positions, values, 0.25, color=ALGORITHM_COLORS[number], label=name)
            ax.bar_label(bars, fmt="%.2f", fontsize=7, padding=1)
        ax.axhline(
            float(PUBLISHED_CLUSTERS["homogeneity_r_c"]),
            color=ACCENT,
            linestyle="--",
            linewidth=1,
            label="thesis, R/C (H, S, O)",
        )
        ax.set_xticks(range(len(clusters)), [each.rooms for each in clusters])
        ax.set(ylim=(0, 1))
        ax.set_title(scale, fontsize=11)
        _clear(ax)
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=len(handles), frameon=False, fontsize=9)
    return figure


PICTURES: MappingProxyType[str, Callable[[Results], Figure]] = MappingProxyType(
    {
        "accuracy.png": draw_accuracies,
        "k_distance.png": draw_distances,
        "clusters.png": draw_clusters,
        "cluster_scores.png": draw_cluster_scores,
    }
)


def _plot_accuracies(records: Sequence[Record], *, ax: Axes) -> None:
    """Draw bars from the records of folds."""
    folds: dict[str, dict[str, list[float]]] = {}
    for record in records:
        folds.setdefault(record["part"], {}).setdefault(record["algorithm"], []).append(record["value"])
    for number, (algorithm, color) in enumerate(zip(ALGORITHMS, ALGORITHM_COLORS, strict=True)):
        positions = np.arange(len(folds)) + (number - 1.5) * 0.19
        heights, errors = (
            [100 * summarise(each[algorithm]) for each in folds.values()] for summarise in (fmean, stdev)
        )
        ax.bar(positions, heights, 0.18, yerr=errors, color=color, ecolor=INK, capsize=2, label=algorithm)
    published = {record["part"]: float(record["mean"]) for record in read_published("figure_4_3.csv")}
    names = []
    for x, (part, algorithms) in enumerate(folds.items()):
        mean = published[part if "+" not in part else "H+S+O"]
        label = None if x else "thesis, mean of the four"
        ax.plot([x - 0.42, x + 0.42], [mean, mean], color=ACCENT, linewidth=2, label=label)
        union = "\n(thesis: H+S+O)" if "+" in part and part != "H+S+O" else ""
        names.append(f"{part}{union}\n{100 * fmean(map(fmean, algorithms.values())):.1f}\nthesis {mean}")
    ax.set_xticks(range(len(names)), names, fontsize=9)
    ax.set(ylim=(0, 100))
    _clear(ax)


def _plot_clusters(each: RoomClusters, *, ax: Axes) -> None:
    """Draw the rooms of a set in the plane of their principal components, coloured by cluster, outliers in black."""
    low, high = (np.quantile(each.plane, share, axis=0) for share in (1 - SHOWN_SHARE, SHOWN_SHARE))
    margin = 0.1 * (high - low)
    outside = each.clusters == OUTLIER
    first, second = each.plane.T
    ax.scatter(first[outside], second[outside], s=5, color="black", linewidths=0)
    colors = np.array(CLUSTER_COLORS)[each.clusters[~outside] % len(CLUSTER_COLORS)]
    ax.scatter(first[~outside], second[~outside], s=5, color=colors, linewidths=0)
    ax.set(xlim=(low[0] - margin[0], high[0] + margin[0]), ylim=(low[1] - margin[1], high[1] + margin[1]))
    share = 100 * (each.figures["outliers"] or 0.0)
    ax.set_title(f"{each.rooms}: {each.figures['clusters']} clusters, {share:.0f} % outliers", fontsize=10)
    ax.tick_params(labelsize=7)


def _select_scale(clusters: Sequence[RoomClusters], scale: str) -> list[RoomClusters]:
    return [each for each in clusters if each.scale == scale]


def _clear(ax: Axes) -> None:
    ax.spines[["top", "right"]].set_visible(False)
