"""Pictures of an ExplorationBench: the area over the way of each policy, and their tracks in a few buildings."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pianta.errors import MapWarning
from pianta.plot.exploration import TRACK_COLORS, plot_exploration
from pianta.plot.floor import plot_scale_bar
from pianta_bench.exploration.measure import ExplorationBench
from pianta_bench.exploration.runs import CURVE, BuildingAtWork, BuildingRuns
from pianta_bench.harness.charts import save_chart, start_chart

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 130
# Buildings of each set that are drawn, spread evenly over those that all policies went through.
DRAWN = 3
WIDTH = 4.2


def save_exploration_pictures(bench: ExplorationBench, folder: Path) -> None:
    """Write curves.png, and SET_NAME.png of a few buildings; raises PiantaError when one cannot be."""
    save_chart(draw_curves(bench), folder / "curves.png", dpi=DPI)
    for kind, results in bench.results.items():
        for result in choose_buildings(results):
            save_chart(draw_tracks(bench, result), folder / f"{kind}_{result.name}.png", dpi=DPI)


def choose_buildings(results: Sequence[BuildingRuns]) -> list[BuildingRuns]:
    """The buildings that are drawn: those whose explorations all came to an end, a few of them."""
    whole = [result for result in results if result.points and all(run.outcome for run in result.runs)]
    places = np.unique(np.linspace(0, len(whole) - 1, DRAWN).round().astype(int)) if whole else ()
    return [whole[place] for place in places]


def draw_curves(bench: ExplorationBench) -> Figure:
    """Share of the area over metres, a panel a set: the mean over buildings of the metres to each share."""
    figure = start_chart(5.2 * len(bench.results), 4.0)
    for ax, (kind, results) in zip(
        figure.subplots(1, len(bench.results), squeeze=False)[0], bench.results.items(), strict=True
    ):
        counts = [
            plot_curve(results, policy, bench.settings.policies, ax=ax, color=color)
            for policy, color in zip(bench.settings.policies, TRACK_COLORS, strict=False)
        ]
        ax.set_title(f"{kind}: mean of {max(counts, default=0)} buildings")
        ax.set(xlabel="driven, m", ylabel="% of the area", ylim=(0, 101), yticks=(0, 20, 40, 60, 80, 90, 95, 100))
        ax.set_xlim(left=0)
        ax.grid(visible=True, linewidth=0.3)
        ax.spines[["top", "right"]].set_visible(False)
        ax.legend(frameon=False, loc="lower right")
    return figure


def plot_curve(results: Sequence[BuildingRuns], policy: str, policies: Sequence[str], *, ax: Axes, color: str) -> int:
    """Draw the curve of a policy, and tell of how many buildings it is."""
    metres = average_curves(results, policy, policies)
    ax.plot(metres.mean(axis=0) if len(metres) else [], 100 * np.array(CURVE if len(metres) else []), color=color,
            linewidth=1.5, label=policy)  # fmt: skip
    return len(metres)


def average_curves(results: Sequence[BuildingRuns], policy: str, policies: Sequence[str]) -> NDArray[np.float64]:
    """Metres to each share of CURVE in each building, shape (buildings, shares), over starts where all reach them."""
    of_buildings = []
    for result in results:
        curves = {(run.start, run.policy): run.curve for run in result.runs if run.label is None and run.curve}
        rows = [
            curves[start, policy]
            for start in range(len(result.points))
            if all(np.isfinite(curves.get((start, other), (np.inf,))[-1]) for other in policies)
        ]
        if rows:
            of_buildings.append(np.mean(rows, axis=0))
    return np.array(of_buildings).reshape(-1, len(CURVE))


def draw_tracks(bench: ExplorationBench, result: BuildingRuns) -> Figure:
    """The tracks of all policies through a building from its first start, side by side; they are driven again."""
    building = next(one for one in bench.sets[result.kind].buildings if one.name == result.name)
    work, policies = BuildingAtWork(building, bench.settings), bench.settings.policies
    height, width = work.world.blocked.shape
    columns = len(policies) if height > width else min(2, len(policies))
    rows = -(-len(policies) // columns)
    figure = start_chart(WIDTH * columns, (WIDTH * height / width + 0.4) * rows)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in axes:
        ax.set_axis_off()
    for ax, policy in zip(axes, policies, strict=False):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MapWarning)
            run, _ = work.explore(policy, 0)
        plot_exploration(run, work.world, ax=ax)
        plot_scale_bar(ax=ax)
        ways = ", ".join(f"{100 * share:.0f} % in {run.distance_to(share):.0f} m" for share in (0.9, 0.99))
        ax.set_title(f"{policy}: {ways}", fontsize=9)
    return figure
