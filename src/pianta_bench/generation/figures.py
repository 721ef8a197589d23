"""Pictures of a GenerationBench: Figs. 7.5, 7.7 and 7.9, and sheets of buildings as in Figs. 7.10 to 7.12."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pianta.labels import SCHOOL
from pianta.plot.figure import save_figure
from pianta.plot.graphs import draw_contact_sheet
from pianta_bench.generation.clusters import ClusterScores
from pianta_bench.generation.measure import CORR, NCUT, REAL, GenerationBench
from pianta_bench.harness.charts import save_chart, start_chart

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 130
# Neighbours that a point of t-SNE looks at, fewer where there are few points.
AREA_PERPLEXITY, BUILDING_PERPLEXITY = 20.0, 15.0
POINTS_A_NEIGHBOUR = 3
REAL_COLOR, MADE_COLOR = "#4477aa", "#ee7733"
# Clusters of a colour have marks of their own.
MARKS = "osD^v"
SHEETS = MappingProxyType({REAL: "Real schools", CORR: "Generated schools, corr", NCUT: "Generated schools, ncut"})


def save_generation_pictures(bench: GenerationBench, folder: Path) -> None:
    """Write heatmap, areas, buildings, real, corr and ncut, as .png, into a folder.

    Raises PiantaError when one cannot be written.
    """
    clusters = {part: judged.clusters for part, judged in bench.models.items()}
    save_chart(draw_clusters(clusters), folder / "heatmap.png", dpi=DPI)
    save_chart(draw_areas(clusters, seed=bench.seed), folder / "areas.png", dpi=DPI)
    save_chart(draw_buildings(bench), folder / "buildings.png", dpi=DPI)
    for part, heading in SHEETS.items():
        graphs = bench.sets[part].graphs
        titles = [graph.graph["source"] for graph in graphs] if part == REAL else None
        sheet = draw_contact_sheet(graphs, schema=SCHOOL, titles=titles, heading=heading)
        save_figure(sheet, folder / f"{part}.png")


def draw_clusters(clusters: Mapping[str, ClusterScores]) -> Figure:
    """Similarity of each two clusters, light where it is high, above the number of areas of each (Fig. 7.5)."""
    figure = start_chart(4.8 * len(clusters), 7)
    axes = figure.subplots(2, len(clusters), squeeze=False, height_ratios=(5, 2))
    for (part, found), (above, below) in zip(clusters.items(), axes.T, strict=True):
        places = np.arange(len(found.sizes))
        image = above.imshow(found.similarity, cmap="magma", vmin=0, vmax=1)
        above.set(title=f"{part}: mean similarity of areas", ylabel="cluster")
        bars = below.bar(places, found.sizes, color=REAL_COLOR)
        below.bar_label(bars, fontsize=7)
        below.set(xlabel="cluster", ylabel="functional areas", xlim=(-0.5, len(places) - 0.5))
        below.spines[["top", "right"]].set_visible(False)
        for ax in (above, below):
            ax.set_xticks(places, places + 1, fontsize=7)
        above.set_yticks(places, places + 1, fontsize=7)
    figure.colorbar(image, ax=axes[0].tolist(), shrink=0.8)
    return figure


def draw_areas(clusters: Mapping[str, ClusterScores], *, seed: int) -> Figure:
    """All functional areas by t-SNE of the Graph Hopper kernel, in the colours of their clusters (Fig. 7.7)."""
    figure = start_chart(6.6 * len(clusters), 6)
    for ax, (part, found) in zip(figure.subplots(1, len(clusters), squeeze=False)[0], clusters.items(), strict=True):
        xy = place_in_plane(found.gram, perplexity=AREA_PERPLEXITY, seed=seed)
        plot_areas(xy, found.clusters, ax=ax)
        ax.set_title(f"{part}: functional areas by cluster")
    return figure


def plot_areas(xy: NDArray[np.float64], clusters: NDArray[np.intp], *, ax: Axes) -> Axes:
    """Draw areas as marks, shape (areas, 2), with a legend of their clusters."""
    from matplotlib import colormaps

    colors = colormaps["tab10"]
    for cluster in range(int(clusters.max(initial=-1)) + 1):
        own = xy[clusters == cluster]
        look: dict[str, Any] = {"color": colors(cluster % 10), "marker": MARKS[cluster // 10 % len(MARKS)]}
        ax.scatter(
            own[:, 0], own[:, 1], s=26, alpha=0.8, edgecolors="white", linewidths=0.4, label=f"{cluster + 1}", **look
        )
    ax.legend(title="cluster", loc="center left", bbox_to_anchor=(1, 0.5), frameon=False, fontsize=8)
    _frame(ax)
    return ax


def draw_buildings(bench: GenerationBench) -> Figure:
    """Real and generated buildings by t-SNE of the WL kernel (Fig. 7.9)."""
    from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

    figure = start_chart(5.2 * len(bench.models), 6)
    real = bench.sets[REAL].graphs
    for ax, part in zip(figure.subplots(1, len(bench.models), squeeze=False)[0], bench.models, strict=True):
        gram = WeisfeilerLehman().fit([*real, *bench.sets[part].graphs]).compare()
        xy = place_in_plane(gram, perplexity=BUILDING_PERPLEXITY, seed=bench.seed)
        look: dict[str, Any] = {"edgecolors": "white", "linewidths": 0.4}
        ax.scatter(
            xy[len(real) :, 0], xy[len(real) :, 1], s=22, color=MADE_COLOR, alpha=0.75, label="generated", **look
        )
        ax.scatter(xy[: len(real), 0], xy[: len(real), 1], s=34, color=REAL_COLOR, marker="D", label="real", **look)
        ax.set_title(f"{part}: schools")
        _frame(ax)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False)
    return figure


def place_in_plane(gram: NDArray[np.float64], *, perplexity: float, seed: int) -> NDArray[np.float64]:
    """Places by t-SNE of the distances 1 - K, shape (items, 2), scaled to 0 … 1."""
    from sklearn.manifold import TSNE

    distances = np.maximum(1 - gram, 0)
    np.fill_diagonal(distances, 0)
    fewer = min(perplexity, (len(gram) - 1) / POINTS_A_NEIGHBOUR)
    reduced = TSNE(metric="precomputed", init="random", perplexity=fewer, random_state=seed).fit_transform(distances)
    spans = np.ptp(reduced, axis=0)
    return np.asarray((reduced - reduced.min(axis=0)) / np.where(spans > 0, spans, 1), np.float64)


def _frame(ax: Axes) -> None:
    ax.set(xlim=(-0.04, 1.04), ylim=(-0.04, 1.04), aspect="equal")
    ax.set_xticks((0, 0.5, 1))
    ax.set_yticks((0, 0.5, 1))
    ax.tick_params(labelsize=8)
