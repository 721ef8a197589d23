"""Charts of bench exploration: the area over the distance for each policy, and the tracks in a few buildings."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pianta._types import Floats
from pianta.errors import MapWarning
from pianta.plot.exploration import TRACK_COLORS, plot_exploration
from pianta.plot.picture import plot_scale_bar
from pianta_bench.exploration.buildings import ExploredBuilding
from pianta_bench.exploration.runs import CURVE, PreparedBuilding, Run, RunSettings
from pianta_bench.harness.charts import save_chart, start_chart
from pianta_bench.harness.records import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 130
PICTURES = 3  # buildings of each set, spread evenly over those that all policies explored
WIDTH = 4.2  # of the tracks of a policy, inches


def save_figures(results: Results, folder: Path) -> None:
    """Write curves.png, and SET_NAME.png of a few buildings; raises PiantaError if a file cannot be written."""
    save_chart(draw_curves(results), folder / "curves.png", dpi=DPI)
    for part in results.options["sets"]:
        for building in choose_buildings(results, part):
            chart = draw_tracks(building, results.objects["settings"])
            save_chart(chart, folder / f"{part}_{building.name}.png", dpi=DPI)


def choose_buildings(results: Results, part: str) -> list[ExploredBuilding]:
    """A few of the buildings of a set in which no run failed."""
    runs: list[Run] = [run for run in results.objects["runs"] if run.part == part]
    names = {run.building for run in runs} - {run.building for run in runs if not run.outcome}
    buildings = [each for each in results.objects["buildings"] if each.part == part and each.name in names]
    indices = np.unique(np.linspace(0, len(buildings) - 1, PICTURES).round().astype(int)) if buildings else ()
    return [buildings[index] for index in indices]


def draw_curves(results: Results) -> Figure:
    """Share of the area over metres, a panel for each set: the mean over buildings of the metres to each share."""
    sets, policies = results.options["sets"], results.options["policies"]
    figure = start_chart(5.2 * len(sets), 4.0)
    for ax, part in zip(figure.subplots(1, len(sets), squeeze=False)[0], sets, strict=True):
        runs = [run for run in results.objects["runs"] if run.part == part]
        counts = [
            plot_curve(average_curves(runs, policy, policies), policy, ax=ax, color=color)
            for policy, color in zip(policies, TRACK_COLORS, strict=False)
        ]
        ax.set_title(f"{part}: mean of {max(counts, default=0)} buildings")
        ax.set(xlabel="distance, m", ylabel="% of the area", ylim=(0, 101), yticks=(0, 20, 40, 60, 80, 90, 95, 100))
        ax.set_xlim(left=0)
        ax.grid(visible=True, linewidth=0.3)
        ax.spines[["top", "right"]].set_visible(False)
        ax.legend(frameon=False, loc="lower right")
    return figure


def plot_curve(metres: Floats, policy: str, *, ax: Axes, color: str) -> int:
    """Draw the curve of a policy; returns the number of buildings. metres: of `average_curves`."""
    shares = 100 * np.array(CURVE if len(metres) else [])
    ax.plot(metres.mean(axis=0) if len(metres) else [], shares, color=color, linewidth=1.5, label=policy)
    return len(metres)


def average_curves(runs: Sequence[Run], policy: str, policies: Sequence[str]) -> Floats:
    """Metres to each share of CURVE in each building, shape (buildings, shares): the mean of its starts.

    Only starts from which all policies reach the last share count.
    """
    curves: dict[str, dict[int, dict[str, tuple[float, ...]]]] = {}
    for run in runs:
        if run.label is None and run.curve and np.isfinite(run.curve[-1]):
            curves.setdefault(run.building, {}).setdefault(run.start, {})[run.policy] = run.curve
    means = []
    for starts in curves.values():
        complete = [by_policy[policy] for by_policy in starts.values() if {*policies} <= by_policy.keys()]
        if complete:
            means.append(np.mean(complete, axis=0))
    return np.array(means).reshape(-1, len(CURVE))


def draw_tracks(building: ExploredBuilding, settings: RunSettings) -> Figure:
    """The tracks of all policies through a building from its first start, side by side; the runs are repeated."""
    prepared, policies = PreparedBuilding(building, settings), [*settings.policies]
    height, width = prepared.world.blocked.shape
    columns = len(policies) if height > width else min(2, len(policies))
    rows = -(-len(policies) // columns)
    figure = start_chart(WIDTH * columns, (WIDTH * height / width + 0.4) * rows)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in axes:
        ax.set_axis_off()
    for ax, policy in zip(axes, policies, strict=False):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MapWarning)
            run, _ = prepared.explore(policy, 1)
        plot_exploration(run, prepared.world, ax=ax)
        plot_scale_bar(ax=ax)
        distances = ", ".join(f"{100 * share:.0f} % in {run.distance_to(share):.0f} m" for share in (0.9, 0.99))
        ax.set_title(f"{policy}: {distances}", fontsize=9)
    return figure
