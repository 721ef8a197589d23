"""Draw the picture of docs/methods/exploration.md: python docs/draw_exploration.py."""

from __future__ import annotations

from draw_pictures import IMAGES, frame, save
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pianta.exploration.explore import explore
from pianta.exploration.policies import PREDICTED, make_policy
from pianta.exploration.record import Exploration
from pianta.exploration.world import build_world
from pianta.plot.exploration import TRACK_COLORS, plot_exploration
from pianta.plot.picture import plot_scale_bar
from pianta.worlds.floors import make_ring_floor

SEED = 4
# Policies whose curves are drawn; of the first and the last the tracks, too.
POLICIES = ("nearest", "gain", PREDICTED)


def main() -> None:
    """Draw explorations of a synthetic floor; without a model, the predicted policy uses geometry alone."""
    world = build_world(make_ring_floor(seed=SEED))
    runs = {name: explore(world, make_policy(name)) for name in POLICIES}
    figure = Figure(figsize=(15, 4), layout="compressed")
    *maps, curves = figure.subplots(1, 3, width_ratios=(1, 1, 0.8))
    for ax, name in zip(maps, (POLICIES[0], POLICIES[-1]), strict=True):
        plot_exploration(runs[name], world, ax=ax)
        plot_scale_bar(ax=ax)
        distances = ", ".join(f"{100 * share:.0f} % in {runs[name].distance_to(share):.0f} m" for share in (0.9, 0.99))
        frame(ax, f"{name}: {distances}")
    plot_curves(runs, ax=curves)
    save(figure, IMAGES / "exploration.png")


def plot_curves(runs: dict[str, Exploration], *, ax: Axes) -> None:
    """Plot the explored share over the distance, a line for each policy."""
    for (name, run), color in zip(runs.items(), TRACK_COLORS, strict=False):
        ax.plot(run.distance, 100 * run.share, color=color, linewidth=1.5, label=name)
    ax.set(xlabel="driven, m", ylabel="% of the area", ylim=(0, 101), yticks=(0, 20, 40, 60, 80, 90, 100))
    ax.set_xlim(left=0)
    ax.grid(visible=True, linewidth=0.3)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(frameon=False, loc="lower right")


if __name__ == "__main__":
    main()
