"""What is predicted of partial rooms, beside what was seen of them: grey hatching in a dashed outline."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shapely import difference, get_parts

from pianta.floor import Floor
from pianta.layout._outlines import GRID

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

HATCH_COLOR, OUTLINE_COLOR = "#999999", "#777777"
HATCH, DASHES, WIDTH = "\\\\", (0, (4, 2.5)), 0.9
# Below the rooms and above the map.
LEVEL = 0.5
# Smaller bits beyond what was seen are the walls, m².
LEAST_AREA = 0.05


def plot_predictions(floor: Floor, *, ax: Axes) -> Axes:
    """Draw what is predicted of partial rooms: what was not seen hatched, around the whole a dashed outline."""
    from shapely.plotting import patch_from_polygon

    for room in floor.rooms:
        if room.predicted is None:
            continue
        for part in get_parts(difference(room.predicted, room.polygon, grid_size=GRID)):
            if part.area >= LEAST_AREA:
                look = {"facecolor": "none", "edgecolor": HATCH_COLOR, "hatch": HATCH, "linewidth": 0, "zorder": LEVEL}
                ax.add_patch(patch_from_polygon(part, **look))
        outline = {"facecolor": "none", "edgecolor": OUTLINE_COLOR, "linestyle": DASHES, "linewidth": WIDTH}
        ax.add_patch(patch_from_polygon(room.predicted, **outline, zorder=LEVEL))
    return ax


def sample_prediction() -> tuple[Patch, str]:
    """Handle of a legend for predictions, and its text."""
    from matplotlib.patches import Patch

    handle = Patch(facecolor="none", edgecolor=HATCH_COLOR, hatch=2 * HATCH, linestyle=(0, (2, 1.5)), linewidth=0.6)
    return handle, "predicted"
