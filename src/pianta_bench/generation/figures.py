"""Pictures of generated buildings: Figs. 7.5, 7.7 and 7.9, and sheets of buildings as in Figs. 7.10 to 7.12."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from pianta._types import Floats, Indices
from pianta.plot.figure import save_figure
from pianta.plot.graphs import draw_contact_sheet
from pianta_bench.generation.clusters import ClusterScores
from pianta_bench.generation.measure import CORR, NCUT, REAL, TYPES
from pianta_bench.generation.stability import CLUSTERS, SIZES
from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 130
# Neighbours of a point in t-SNE, fewer if there are few points; chosen by hand.
AREA_PERPLEXITY = 20.0
BUILDING_PERPLEXITY = 15.0
MIN_POINTS_PER_NEIGHBOUR = 3
REAL_COLOR = "#4477aa"
GENERATED_COLOR = "#ee7733"
# Clusters of a colour have marks of their own.
MARKS = "osD^v"
SHEETS = MappingProxyType({REAL: "Real {}s", CORR: "Generated {}s, corr", NCUT: "Generated {}s, ncut"})


def save_figures(results: Results, folder: Path) -> None:
    """Write heatmap, areas, buildings, clusters, real, corr and ncut, as .png, into a folder.

    Raises PiantaError if one cannot be written.
    """
    clusters, type_ = results.objects["clusters"], results.options["type"]
    save_chart(draw_stability(results), folder / "clusters.png", dpi=DPI)
    save_chart(draw_clusters(clusters), folder / "heatmap.png", dpi=DPI)
    save_chart(draw_areas(clusters, seed=results.options["seed"]), folder / "areas.png", dpi=DPI)
    save_chart(draw_buildings(results), folder / "buildings.png", dpi=DPI)
    for part, heading in SHEETS.items():
        graphs = results.objects["graphs"][part]
        titles = [graph.graph["source"] for graph in graphs] if part == REAL else None
        sheet = draw_contact_sheet(graphs, schema=TYPES[type_], titles=titles, heading=heading.format(type_))
        save_figure(sheet, folder / f"{part}.png")


def draw_clusters(clusters: Mapping[str, ClusterScores]) -> Figure:
    """Similarity of each two clusters, light where it is high, above the number of areas of each (Fig. 7.5)."""
    figure = start_chart(4.8 * len(clusters), 7)
    axes = figure.subplots(2, len(clusters), squeeze=False, height_ratios=(5, 2))
    for (part, scores), (above, below) in zip(clusters.items(), axes.T, strict=True):
        positions = np.arange(len(scores.sizes))
        image = above.imshow(scores.similarity, cmap="magma", vmin=0, vmax=1)
        above.set(title=f"{part}: mean similarity of areas", ylabel="cluster")
        bars = below.bar(positions, scores.sizes, color=REAL_COLOR)
        below.bar_label(bars, fontsize=7)
        below.set(xlabel="cluster", ylabel="functional areas", xlim=(-0.5, len(positions) - 0.5))
        below.spines[["top", "right"]].set_visible(False)
        for ax in (above, below):
            ax.set_xticks(positions, positions + 1, fontsize=7)
        above.set_yticks(positions, positions + 1, fontsize=7)
    figure.colorbar(image, ax=axes[0].tolist(), shrink=0.8)
    return figure


def draw_areas(clusters: Mapping[str, ClusterScores], *, seed: int) -> Figure:
    """All functional areas by t-SNE of the Graph Hopper kernel, in the colours of their clusters (Fig. 7.7)."""
    figure = start_chart(6.6 * len(clusters), 6)
    for ax, (part, scores) in zip(figure.subplots(1, len(clusters), squeeze=False)[0], clusters.items(), strict=True):
        xy = embed_in_plane(scores.gram, perplexity=AREA_PERPLEXITY, seed=seed)
        plot_areas(xy, scores.clusters, ax=ax)
        ax.set_title(f"{part}: functional areas by cluster")
    return figure


def plot_areas(xy: Floats, clusters: Indices, *, ax: Axes) -> Axes:
    """Draw areas as marks, shape (areas, 2), with a legend of their clusters."""
    from matplotlib import colormaps

    colors = colormaps["tab10"]
    for cluster in range(int(clusters.max(initial=-1)) + 1):
        own = xy[clusters == cluster]
        style: dict[str, Any] = {"color": colors(cluster % 10), "marker": MARKS[cluster // 10 % len(MARKS)]}
        ax.scatter(
            own[:, 0], own[:, 1], s=26, alpha=0.8, edgecolors="white", linewidths=0.4, label=f"{cluster + 1}", **style
        )
    ax.legend(title="cluster", loc="center left", bbox_to_anchor=(1, 0.5), frameon=False, fontsize=8)
    _frame(ax)
    return ax


def draw_buildings(results: Results) -> Figure:
    """Real and generated buildings by t-SNE of the WL kernel (Fig. 7.9)."""
    from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

    graphs, models = results.objects["graphs"], results.objects["models"]
    figure = start_chart(5.2 * len(models), 6)
    real = len(graphs[REAL])
    style: dict[str, Any] = {"edgecolors": "white", "linewidths": 0.4}
    for ax, part in zip(figure.subplots(1, len(models), squeeze=False)[0], models, strict=True):
        gram = WeisfeilerLehman().fit([*graphs[REAL], *graphs[part]]).compare()
        xy = embed_in_plane(gram, perplexity=BUILDING_PERPLEXITY, seed=results.options["seed"])
        ax.scatter(*xy[real:].T, s=22, color=GENERATED_COLOR, alpha=0.75, label="generated", **style)
        ax.scatter(*xy[:real].T, s=34, color=REAL_COLOR, marker="D", label="real", **style)
        ax.set_title(f"{part}: {results.options['type']}s")
        _frame(ax)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False)
    return figure


def draw_stability(results: Results) -> Figure:
    """The number of clusters by the number of floors, mean and standard deviation over draws (section 7.3.3)."""
    figure = start_chart(5, 3.6)
    ax = figure.subplots()
    for part, color in zip(results.objects["models"], (REAL_COLOR, GENERATED_COLOR), strict=True):
        counts = {
            size: [float(value) for value in results.values(part=part, metric=CLUSTERS, floors=name) if value]
            for size, name in ((size, f"{size} floors") for size in SIZES)
        }
        counts = {size: values for size, values in counts.items() if values}
        means, deviations = ([f(values) for values in counts.values()] for f in (np.mean, np.std))
        ax.errorbar([*counts], means, deviations, color=color, marker="o", capsize=3, label=part)
    ax.set(xlabel="floors", ylabel="clusters", ylim=(0, None))
    ax.legend(frameon=False)
    ax.spines[["top", "right"]].set_visible(False)
    return figure


def embed_in_plane(gram: Floats, *, perplexity: float, seed: int) -> Floats:
    """Positions by t-SNE of the distances 1 - K, shape (items, 2), scaled to 0 … 1."""
    from sklearn.manifold import TSNE

    distances = np.maximum(1 - gram, 0)
    np.fill_diagonal(distances, 0)
    fewer = min(perplexity, (len(gram) - 1) / MIN_POINTS_PER_NEIGHBOUR)
    reduced = TSNE(metric="precomputed", init="random", perplexity=fewer, random_state=seed).fit_transform(distances)
    spans = np.ptp(reduced, axis=0)
    return np.asarray((reduced - reduced.min(axis=0)) / np.where(spans > 0, spans, 1), np.float64)


def _frame(ax: Axes) -> None:
    ax.set(xlim=(-0.04, 1.04), ylim=(-0.04, 1.04), aspect="equal")
    ax.set_xticks((0, 0.5, 1))
    ax.set_yticks((0, 0.5, 1))
    ax.tick_params(labelsize=8)
