"""The scores of all floors, and Fig. 8.4 as curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from pianta._types import Floats
from pianta.labels import LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Results
from pianta_bench.places.models import CENTRAL, LOCAL
from pianta_bench.realism.measure import OFFICES, ONE, SCHOOLS, TWO, WORLDS, list_scores
from pianta_bench.realism.models import KLOG

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Paul Tol's "bright" scheme, for colour-blind readers.
COLORS = MappingProxyType({OFFICES: "#4477aa", WORLDS: "#cc3311", SCHOOLS: "#999999"})
SHAPES = MappingProxyType({OFFICES: "o", WORLDS: "D", SCHOOLS: "s"})
CURVES = MappingProxyType(
    {
        LOCAL: ("#ccbb44", ":"),
        CENTRAL: ("#ee6677", "-."),
        KLOG: ("#228833", "--"),
        TWO: ("#4477aa", "-"),
        ONE: ("#222222", (0, (5, 1))),
    }
)
DPI = 130
SPREAD = 0.28  # largest distance of the marks of a part from its line, in distances between lines


def save_figures(results: Results, folder: Path) -> None:
    """Write scores.png and curves.png into a folder; raises PiantaError when one cannot be written."""
    save_chart(draw_scores(results), folder / "scores.png", dpi=DPI)
    save_chart(draw_curves(results), folder / "curves.png", dpi=DPI)


def draw_scores(results: Results) -> Figure:
    """Likeness to real offices, and probability of being real: one mark per floor, one column per label set."""
    figure = start_chart(10, 4.6)
    axes = figure.subplots(2, len(LABELS), squeeze=False)
    for label_set, (above, below) in zip(LABELS, axes.T, strict=True):
        likeness = {part: results.values(metric="likeness", label_set=label_set, part=part) for part in COLORS}
        plot_scores(likeness, ax=above)
        # Schools are in neither of the two classes.
        plot_scores({part: list_scores(results, TWO, label_set, part) for part in (OFFICES, WORLDS)}, ax=below)
        above.set_title(str(label_set))
        above.set_xlabel("one class: likeness to the three nearest real offices")
        below.set_xlabel("two classes: probability of being real")
        below.axvline(0.5, color="#999999", linewidth=1, linestyle="--", zorder=0)
        below.set_xlim(-0.03, 1.03)
    return figure


def plot_scores(scores: Mapping[str, Sequence[float] | Floats], *, ax: Axes) -> Axes:
    """Draw the scores of each part as marks, parts below each other, with the median of the offices."""
    parts = [part for part, figures in scores.items() if len(figures)]
    for row, part in enumerate(parts):
        across = row + SPREAD * (2 * ((np.arange(len(scores[part])) * 0.618) % 1) - 1)
        ax.scatter(scores[part], across, s=26, marker=SHAPES[part], color=COLORS[part], alpha=0.75, linewidths=0)
    ax.axvline(float(np.median(scores[OFFICES])), color=COLORS[OFFICES], linewidth=1, zorder=0)
    ax.set_yticks(range(len(parts)), parts)
    ax.set_ylim(len(parts) - 0.5, -0.5)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def draw_curves(results: Results) -> Figure:
    """Receiver operating characteristic and precision over recall of real offices, one row per label set."""
    figure = start_chart(9, 8)
    for label_set, (left, right) in zip(LABELS, figure.subplots(len(LABELS), 2, squeeze=False), strict=True):
        plot_curves(results, label_set, left, right)
    return figure


def plot_curves(results: Results, label_set: LabelSet, left: Axes, right: Axes) -> None:
    """Draw the curves of all models in a label set."""
    from sklearn.metrics import average_precision_score, precision_recall_curve, roc_auc_score, roc_curve

    likeness = [results.values(metric="likeness", label_set=label_set, part=part) for part in (OFFICES, WORLDS)]
    real = [True] * len(likeness[0]) + [False] * len(likeness[1])
    for model, (color, style) in CURVES.items():
        # Many floors have the typicality 0, so likeness is used instead.
        parts = (
            likeness if model == ONE else [list_scores(results, model, label_set, part) for part in (OFFICES, WORLDS)]
        )
        scores = np.concatenate(parts)
        false, true, _ = roc_curve(real, scores)
        precision, recall, _ = precision_recall_curve(real, scores)
        look: dict[str, Any] = {"color": color, "linestyle": style, "linewidth": 1.6}
        left.plot(false, true, label=f"{model}, area {roc_auc_score(real, scores):.3f}", **look)
        right.plot(recall, precision, label=f"{model}, mean {average_precision_score(real, scores):.3f}", **look)
    left.set(xlabel="worlds called real", ylabel="offices called real", title=f"{label_set}, ROC")
    right.set(xlabel="recall of offices", ylabel="precision", title=f"{label_set}, precision and recall")
    for ax in (left, right):
        ax.set(xlim=(-0.02, 1.02), ylim=(-0.02, 1.03))
        ax.legend(frameon=False, fontsize=8, loc="lower right" if ax is left else "lower left")
        ax.spines[["top", "right"]].set_visible(False)
