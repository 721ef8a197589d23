"""Chart of bench online: what is right over the way, and what an update costs."""

from __future__ import annotations

from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING

from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Results
from pianta_bench.online.measure import BEHIND, COST, CURVE, DOORS, LABELS, ROOMS, SIZE, TYPE, name_stage

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 130
# Title of a panel -> metrics of its curves, and the factor of their values. Paul Tol's "bright" scheme has the colours.
PANELS = {
    "what is right, %": ((ROOMS, DOORS, LABELS, TYPE), 100.0),
    "what is expected, %": ((BEHIND, SIZE), 100.0),
    "an update, s": ((COST,), 1.0),
}
COLORS = ("#4477aa", "#ee6677", "#228833", "#aa3377")


def save_figures(results: Results, folder: Path) -> None:
    """Write curves.png into a folder; raises PiantaError when it cannot be written."""
    save_chart(draw_curves(results), folder / "curves.png", dpi=DPI)


def draw_curves(results: Results) -> Figure:
    """Means over buildings by the share of the area that the robot has observed."""
    figure = start_chart(4.2 * len(PANELS), 3.8)
    for ax, (title, (metrics, factor)) in zip(figure.subplots(1, len(PANELS)), PANELS.items(), strict=True):
        for metric, color in zip(metrics, COLORS, strict=False):
            plot_curve(results, metric, factor, ax=ax, color=color)
        ax.set_title(title, fontsize=11)
        ax.set(xlabel="area that the robot has observed, %", xlim=(0, 100), ylim=(0, 100 if factor > 1 else None))
        ax.grid(visible=True, linewidth=0.3)
        ax.spines[["top", "right"]].set_visible(False)
        ax.legend(frameon=False, fontsize=9)
    return figure


def plot_curve(results: Results, metric: str, factor: float, *, ax: Axes, color: str) -> None:
    """Draw the means of a metric; shares of the area that no building has are left out."""
    values = {stage: results.values(metric=name_stage(metric, stage)) for stage in CURVE}
    means = {100 * stage: factor * fmean(each) for stage, each in values.items() if each}
    ax.plot([*means], [*means.values()], color=color, linewidth=1.6, label=metric)
