"""Pictures of a PlacesBench: how far its probabilities can be trusted, and which labels it confuses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pianta.evaluation.semantics import Reliability
from pianta.labels import LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.old_report import show_figure
from pianta_bench.places.evaluated_floor import LAYOUTS, OFFICES, SCHOOLS
from pianta_bench.places.models import CENTRAL, PIANTA
from pianta_bench.places.tables import (
    PRINTED_BACKWARD,
    PRINTED_FORWARD,
    PlacesBench,
    average_confusions,
    measure_curve,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Paul Tol's "bright" scheme, for colour-blind readers.
COLORS = MappingProxyType({SCHOOLS: "#4477aa", OFFICES: "#cc6633", LAYOUTS: "#228833"})
SHAPES = MappingProxyType({SCHOOLS: "o", OFFICES: "s", LAYOUTS: "^"})
DPI = 130


def save_place_pictures(bench: PlacesBench, folder: Path) -> None:
    """Write reliability.png and confusion.png into a folder; raises PiantaError when one cannot be written."""
    for name, draw in PICTURES.items():
        save_chart(draw(bench), folder / name, dpi=DPI)


def draw_reliability(bench: PlacesBench) -> Figure:
    """Share of right labels by the probability of the label given, and rooms in each bin; a column a label set."""
    figure = start_chart(9, 5.4)
    curves, counts = figure.subplots(2, len(LABELS), sharex=True, height_ratios=(3, 1), squeeze=False)
    for label_set, above, below in zip(LABELS, curves, counts, strict=True):
        for place, part in enumerate(COLORS):
            curve = measure_curve(bench.of_part(part), PIANTA, label_set)
            _plot_curve(curve, part, ax=above)
            _plot_counts(curve, part, place, ax=below)
        above.plot((0, 1), (0, 1), color="#999999", linewidth=1, linestyle="--", zorder=0)
        above.set(title=str(label_set), xlim=(0.2, 1.02), ylim=(0, 1.02))
        above.legend(frameon=False, fontsize=8, loc="lower right")
        below.set(xlabel="probability of the label given", yscale="log")
        for ax in (above, below):
            ax.spines[["top", "right"]].set_visible(False)
    curves[0].set_ylabel("share of right labels")
    counts[0].set_ylabel("rooms")
    return figure


def draw_confusions(bench: PlacesBench) -> Figure:
    """Tables 5.3 (left) and 5.4 (right) as heat maps: the thesis, Extra-Trees here, pianta."""
    figure = start_chart(7.4, 9.6)
    layouts = bench.of_part(LAYOUTS)
    axes = figure.subplots(3, 2)
    for column, (printed, backward) in enumerate(((PRINTED_FORWARD, False), (PRINTED_BACKWARD, True))):
        way = "true rooms, BC" if backward else "found rooms, FC"
        of_thesis = np.array([[mean for mean, _ in row] for row in printed])
        plot_confusion(of_thesis, f"thesis, Table 5.{'4' if backward else '3'}", ax=axes[0, column])
        for ax, model in zip(axes[1:, column], (CENTRAL, PIANTA), strict=True):
            cells = average_confusions(layouts, model, backward=backward)
            means = np.array([[np.nan if cell.mean is None else cell.mean for cell in row] for row in cells])
            plot_confusion(means, f"{model}, {way}", ax=ax)
    return figure


def plot_confusion(means: NDArray[np.float64], title: str, *, ax: Axes) -> Axes:
    """Draw a confusion matrix in %, shape (labels, labels) or with one more column for rooms without a label."""
    labels = LABELS[LabelSet.F_C_E_S]
    given = [*(label[0] for label in labels), "none"][: means.shape[1]]
    ax.imshow(np.nan_to_num(means), cmap="Blues", vmin=0, vmax=100)
    for (row, col), mean in np.ndenumerate(means):
        color = "white" if mean > 55 else "#222222"
        ax.text(col, row, show_figure(float(mean), 0), ha="center", va="center", color=color, fontsize=9)
    ax.set_xticks(range(len(given)), given)
    ax.set_yticks(range(len(labels)), [label[0] for label in labels])
    ax.set_title(title, fontsize=10)
    ax.set_xlabel("given", fontsize=8)
    ax.set_ylabel("true", fontsize=8)
    return ax


PICTURES: MappingProxyType[str, Callable[[PlacesBench], Figure]] = MappingProxyType(
    {"reliability.png": draw_reliability, "confusion.png": draw_confusions}
)


def _plot_curve(curve: Reliability, part: str, *, ax: Axes) -> None:
    filled = curve.counts > 0
    style: dict[str, Any] = {"color": COLORS[part], "marker": SHAPES[part], "markersize": 4.5, "linewidth": 1.3}
    label = f"{part}, ECE {100 * curve.error:.1f}" if filled.any() else f"{part}, no rooms"
    # Standard error of a share: few rooms say little.
    error = np.sqrt(curve.accuracy * (1 - curve.accuracy) / np.maximum(curve.counts, 1))
    ax.errorbar(curve.confidence[filled], curve.accuracy[filled], error[filled], label=label, elinewidth=0.7, **style)


def _plot_counts(curve: Reliability, part: str, place: int, *, ax: Axes) -> None:
    width = (curve.edges[1] - curve.edges[0]) / (len(COLORS) + 1)
    left = curve.edges[:-1] + (place + 0.5) * width
    ax.bar(left, curve.counts, width, align="edge", color=COLORS[part])
