"""Figs. 6.2 and 6.3: ROC and precision-recall curves of places and buildings in R/C."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from pianta.evaluation.curves import Curve
from pianta_bench.buildings.models import KLOG
from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Results
from pianta_bench.places.models import PIANTA

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Paul Tol's "bright" scheme, for colour-blind readers; one colour per part, one stroke per model.
COLORS = MappingProxyType({"S": "#4477aa", "O": "#cc6633", "S+O": "#228833"})
STROKES = MappingProxyType({KLOG: "--", PIANTA: "-"})
NAMES = MappingProxyType({"S": "schools", "O": "offices", "S+O": "buildings"})
FIGURES = MappingProxyType({"places.png": ("S", "O"), "buildings.png": ("S+O",)})
DPI = 130


def save_figures(results: Results, folder: Path) -> None:
    """Write places.png and buildings.png into a folder; raises PiantaError if one cannot be written."""
    curves = [*results.objects["scores"].measure_curves()]
    for name, parts in FIGURES.items():
        figure = start_chart(9.6, 5.3)
        roc, precision_recall = figure.subplots(1, 2)
        for part, model, curve_name, curve in curves:
            if part in parts and model in STROKES:
                plot = plot_roc if curve_name == "ROC" else plot_precision_recall
                ax = roc if curve_name == "ROC" else precision_recall
                plot(curve, f"{NAMES[part]}, {model}", ax=ax, color=COLORS[part], stroke=STROKES[model])
                if (model, curve_name) == (PIANTA, "PR"):
                    ax.axhline(curve.chance, color=COLORS[part], linewidth=0.8, linestyle=":", zorder=0)
        roc.plot((0, 1), (0, 1), color="#999999", linewidth=0.8, linestyle=":", zorder=0)
        roc.set(xlabel="false positive rate", ylabel="true positive rate", title="ROC")
        precision_recall.set(xlabel="recall", ylabel="precision", title="precision-recall")
        for ax in (roc, precision_recall):
            ax.set(xlim=(-0.01, 1.01), ylim=(0, 1.01), aspect="equal")
            ax.spines[["top", "right"]].set_visible(False)
            ax.legend(framealpha=0.9, edgecolor="none", fontsize=8, loc="lower right", title="area")
        save_chart(figure, folder / name, dpi=DPI)


def plot_roc(curve: Curve, name: str, *, ax: Axes, color: str, stroke: str = "-") -> Axes:
    """Draw a ROC curve, its area in the legend."""
    ax.plot(curve.x, curve.y, color=color, linestyle=stroke, linewidth=1.6, label=f"{name} {curve.area:.3f}")
    return ax


def plot_precision_recall(curve: Curve, name: str, *, ax: Axes, color: str, stroke: str = "-") -> Axes:
    """Draw a precision-recall curve as steps, the highest precision of each recall, its area in the legend."""
    recall, first = np.unique(curve.x, return_index=True)
    precision = np.maximum.reduceat(curve.y, first)
    # With recall 0 there is no precision; the first step begins there.
    precision[0] = precision[1]
    label = f"{name} {curve.area:.3f}"
    ax.plot(recall, precision, color=color, linestyle=stroke, linewidth=1.6, label=label, drawstyle="steps-pre")
    return ax
