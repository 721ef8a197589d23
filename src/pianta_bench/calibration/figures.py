"""Reliability diagram of the probabilities of rooms and of doors."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from pianta.evaluation.semantics import BINS, Reliability, bin_reliability
from pianta_bench.calibration.measure import REGIONS
from pianta_bench.calibration.tables import list_groups
from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Paul Tol's "bright" scheme, for colour-blind readers.
COLORS = MappingProxyType(
    {
        "survey": "#4477aa",
        "furniture": "#66ccee",
        "clutter": "#cc6633",
        "vacuum": "#aa3377",
        "schools": "#228833",
        "growing": "#bbbbbb",
        "worlds": "#ccbb44",
    }
)
# Bins with fewer rooms or doors are not drawn: they say little.
MIN_COUNT = 5
DPI = 130


def save_figures(results: Results, folder: Path) -> None:
    """Write reliability.png into a folder; raises PiantaError if it cannot be written."""
    save_chart(draw_reliability(results), folder / "reliability.png", dpi=DPI)


def draw_reliability(results: Results) -> Figure:
    """Share of right ones by probability, of each set, and how many are in each bin; a column for each of REGIONS."""
    figure = start_chart(11, 5.2)
    curves, counts = figure.subplots(2, len(REGIONS), sharex=True, height_ratios=(3, 1))
    for regions, above, below in zip(REGIONS, curves, counts, strict=True):
        groups = [group for group in list_groups(results, regions) if group[0] in COLORS]
        bottom = np.zeros(BINS)
        for part, probabilities, is_right in groups:
            curve = bin_reliability(probabilities, is_right, bins=BINS)
            _plot_curve(curve, part, ax=above)
            below.bar(curve.edges[:-1], curve.counts, 1 / BINS, bottom, align="edge", color=COLORS[part])
            bottom += curve.counts
        above.plot((0, 1), (0, 1), color="#999999", linewidth=1, linestyle="--", zorder=0)
        above.set(title=regions, xlim=(0, 1.02), ylim=(0, 1.02))
        if groups:
            above.legend(frameon=False, fontsize=8, loc="lower right")
        below.set_xlabel("probability")
        for ax in (above, below):
            ax.spines[["top", "right"]].set_visible(False)
    curves[0].set_ylabel("share of right ones")
    counts[0].set_ylabel("number")
    return figure


def _plot_curve(curve: Reliability, part: str, *, ax: Axes) -> None:
    """Draw a reliability curve with standard errors; the legend has its expected calibration error, points."""
    filled = curve.counts >= MIN_COUNT
    # Standard error of a share: few regions say little.
    error = np.sqrt(curve.accuracy * (1 - curve.accuracy) / np.maximum(curve.counts, 1))
    ax.errorbar(
        curve.confidence[filled],
        curve.accuracy[filled],
        error[filled],
        color=COLORS[part],
        label=f"{part}, error {100 * curve.error:.1f}",
        marker="o",
        markersize=4,
        linewidth=1.3,
        elinewidth=0.7,
    )
