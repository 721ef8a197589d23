"""Reliability of the probabilities, and confusion of labels."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from pianta._types import Floats
from pianta.evaluation.semantics import Reliability
from pianta.labels import LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Results
from pianta_bench.harness.report import show_figure
from pianta_bench.harness.tables import Cell, FilledTable
from pianta_bench.places.evaluated import (
    BACKWARD,
    FORWARD,
    LAYOUTS,
    METHODS,
    OFFICES,
    SCHOOLS,
    THESIS_LAYOUTS,
    EvaluatedFloor,
    measure_curve,
)
from pianta_bench.places.models import CENTRAL, PIANTA
from pianta_bench.places.tables import TABLE_5_2, fill_confusion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Paul Tol's "bright" scheme, for colour-blind readers.
COLORS = MappingProxyType({SCHOOLS: "#4477aa", OFFICES: "#cc6633", LAYOUTS: "#228833"})
SHAPES = MappingProxyType({SCHOOLS: "o", OFFICES: "s", LAYOUTS: "^"})
# Layouts and models below those of the thesis.
MODELS_OF_LAYOUTS = ((THESIS_LAYOUTS, CENTRAL), (LAYOUTS, CENTRAL), (LAYOUTS, PIANTA))
DPI = 130


def save_figures(results: Results, folder: Path) -> None:
    """Write reliability.png and confusion.png into a folder; raises PiantaError if one cannot be written."""
    floors = results.objects["floors"]
    save_chart(draw_reliability(floors), folder / "reliability.png", dpi=DPI)
    save_chart(draw_confusions(floors), folder / "confusion.png", dpi=DPI)


def draw_reliability(floors: list[EvaluatedFloor]) -> Figure:
    """Share of right labels by probability of the predicted label, and rooms in each bin; one column per label set."""
    figure = start_chart(9, 5.4)
    curves, counts = figure.subplots(2, len(LABELS), sharex=True, height_ratios=(3, 1), squeeze=False)
    for label_set, above, below in zip(LABELS, curves, counts, strict=True):
        for number, part in enumerate(COLORS):
            curve = measure_curve([floor for floor in floors if floor.part == part], PIANTA, label_set)
            _plot_curve(curve, part, ax=above)
            _plot_counts(curve, part, number, ax=below)
        above.plot((0, 1), (0, 1), color="#999999", linewidth=1, linestyle="--", zorder=0)
        above.set(title=str(label_set), xlim=(0.2, 1.02), ylim=(0, 1.02))
        above.legend(frameon=False, fontsize=8, loc="lower right")
        below.set(xlabel="probability of the predicted label", yscale="log")
        for ax in (above, below):
            ax.spines[["top", "right"]].set_visible(False)
    curves[0].set_ylabel("share of right labels")
    counts[0].set_ylabel("rooms")
    return figure


def draw_confusions(floors: list[EvaluatedFloor]) -> Figure:
    """Tables 5.3 (left) and 5.4 (right) as heat maps: the thesis, and models on layouts by two methods."""
    figure = start_chart(7.4, 12.6)
    for column, way in zip(figure.subplots(4, 2).T, (FORWARD, BACKWARD), strict=True):
        tables = {
            part: fill_confusion([floor for floor in floors if floor.part == part], way, part) for part in METHODS
        }
        number = "5.3" if way == FORWARD else "5.4"
        published = _to_array(tables[THESIS_LAYOUTS], CENTRAL, published=True)
        plot_confusion(published, f"thesis, Table {number}, {way}", ax=column[0])
        for ax, (part, model) in zip(column[1:], MODELS_OF_LAYOUTS, strict=True):
            plot_confusion(_to_array(tables[part], model), f"{model}, {TABLE_5_2.labels[part]}, {way}", ax=ax)
    return figure


def plot_confusion(means: Floats, title: str, *, ax: Axes) -> Axes:
    """Draw a confusion matrix in %, shape (labels, labels) or with one more column for rooms without a label."""
    labels = LABELS[LabelSet.F_C_E_S]
    predicted = [*(label[0] for label in labels), "none"][: means.shape[1]]
    ax.imshow(np.nan_to_num(means), cmap="Blues", vmin=0, vmax=100)
    for (row, col), mean in np.ndenumerate(means):
        color = "white" if mean > 55 else "#222222"
        ax.text(col, row, show_figure(float(mean), 0), ha="center", va="center", color=color, fontsize=9)
    ax.set_xticks(range(len(predicted)), predicted)
    ax.set_yticks(range(len(labels)), [label[0] for label in labels])
    ax.set_title(title, fontsize=10)
    ax.set_xlabel("predicted", fontsize=8)
    ax.set_ylabel("true", fontsize=8)
    return ax


def _to_array(table: FilledTable, model: str, *, published: bool = False) -> Floats:
    """Means of the rows of a model in a table of confusion, NaN for a cell without; published ones lack NOTHING."""
    labels = LABELS[LabelSet.F_C_E_S]
    columns = table.columns[: len(labels)] if published else table.columns
    cells = [[table.rows.get(f"{model}, {label[0]}", {}).get(column, Cell()) for column in columns] for label in labels]
    means = [[cell.published_mean if published else cell.mean for cell in row] for row in cells]
    return np.array(means, float)


def _plot_curve(curve: Reliability, part: str, *, ax: Axes) -> None:
    """Draw a reliability curve with standard errors; the legend has its expected calibration error, %."""
    filled = curve.counts > 0
    style: dict[str, Any] = {"color": COLORS[part], "marker": SHAPES[part], "markersize": 4.5, "linewidth": 1.3}
    label = f"{part}, ECE {100 * curve.error:.1f}" if filled.any() else f"{part}, no rooms"
    # Standard error of a share: few rooms say little.
    error = np.sqrt(curve.accuracy * (1 - curve.accuracy) / np.maximum(curve.counts, 1))
    ax.errorbar(curve.confidence[filled], curve.accuracy[filled], error[filled], label=label, elinewidth=0.7, **style)


def _plot_counts(curve: Reliability, part: str, number: int, *, ax: Axes) -> None:
    width = (curve.edges[1] - curve.edges[0]) / (len(COLORS) + 1)
    left = curve.edges[:-1] + (number + 0.5) * width
    ax.bar(left, curve.counts, width, align="edge", color=COLORS[part])
