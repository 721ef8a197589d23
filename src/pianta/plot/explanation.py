"""Pictures of explanations: the borders between rooms that were considered, on the map."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pianta.gridmap import GridMap
from pianta.layout.explanation import Border, Explanation
from pianta.plot.figure import new_ax
from pianta.plot.floor_parts import FURNITURE_COLOR, FURNITURE_OPACITY, plot_furniture
from pianta.plot.grid import INK_LEVEL, add_image, plot_grid
from pianta.plot.picture import add_legend, find_extent, new_picture, plot_scale_bar, show_extent
from pianta.plot.room_marks import plot_ids
from pianta.plot.styles import EDGE_COLOR, RoomStyle

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Borders that divide two rooms, and borders within one room.
CUT_COLOR = "#cc2233"
JOINED_COLOR = "#5577aa"
JOINED_DASHES = (0, (2.5, 1.5))
CUT_WIDTH = 2.2
JOINED_WIDTH = 1.2
# Points.
NUMBER_SIZE = 5.5
# A border within a room has no number if it is less probable than this.
MIN_NUMBERED = 0.05
BORDER_LEVEL, NUMBER_LEVEL = 4.2, 6
# Colours of the evidence, by its class, and the highest opacity; outside and floor have none.
EVIDENCE_COLORS = {2: "#223355", 3: "#ee7733", 4: FURNITURE_COLOR}
EVIDENCE_NAMES = {2: "wall", 3: "door", 4: "furniture"}
EVIDENCE_OPACITY = 0.6


def plot_explanation(explanation: Explanation, *, ax: Axes | None = None) -> Axes:
    """Draw the borders between rooms that were considered, with the probability that each divides two rooms.

    Borders that divide are red, borders within a room are blue and dashed. Below are the map, the ids of the rooms, and
    the furniture, or, if a model gives it, the evidence for walls, doors and furniture.

    Parameters
    ----------
    explanation
        The result of `explain`.
    ax
        Where to draw, metres of the map frame; a new figure if None.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> _, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_explanation(pianta.explain(grid))
    """
    from shapely.plotting import patch_from_polygon

    ax = new_ax(ax)
    floor, grid = explanation.floor, explanation.grid
    plot_grid(grid, ax=ax)
    if explanation.evidence is None:
        plot_furniture(floor, ax=ax)
    else:
        _plot_evidence(explanation.evidence, grid, ax)
    for room in floor.rooms:
        outline = {"facecolor": "none", "edgecolor": EDGE_COLOR, "linewidth": 0.5, "zorder": 1}
        ax.add_artist(patch_from_polygon(room.polygon, **outline))
    plot_ids(floor, {room.id: RoomStyle("#ffffff") for room in floor.rooms}, ax)
    for border in explanation.borders:
        _plot_border(border, ax)
    show_extent(find_extent(floor, grid), ax)
    return ax


def draw_explanation(explanation: Explanation) -> Figure:
    """Picture of an explanation, cropped to the building, with a scale bar and a legend; as large as draw_floor's."""
    figure, ax = new_picture(find_extent(explanation.floor, explanation.grid))
    plot_explanation(explanation, ax=ax)
    plot_scale_bar(ax=ax)
    add_legend(figure, _list_samples(explanation))
    return figure


def _plot_border(border: Border, ax: Axes) -> None:
    """Draw a border, and the probability at its middle."""
    from matplotlib.lines import Line2D

    color, width = (CUT_COLOR, CUT_WIDTH) if border.divides else (JOINED_COLOR, JOINED_WIDTH)
    stroke = Line2D(*border.line.xy, color=color, linewidth=width, zorder=BORDER_LEVEL)
    if not border.divides:
        stroke.set_linestyle(JOINED_DASHES)
    ax.add_line(stroke)
    if border.probability is None or (not border.divides and border.probability < MIN_NUMBERED):
        return
    ((x, y),) = border.line.interpolate(0.5, normalized=True).coords
    look: dict[str, Any] = {"color": color, "fontsize": NUMBER_SIZE, "ha": "center", "va": "center"}
    back = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
    ax.text(x, y, f"{border.probability:.2f}", bbox=back, zorder=NUMBER_LEVEL, clip_on=True, **look)


def _plot_evidence(evidence: NDArray[np.float32], grid: GridMap, ax: Axes) -> None:
    """Tint the cells by the evidence for walls, doors and furniture; evidence: shape (H, W, 5)."""
    from matplotlib.colors import to_rgb

    for index, color in EVIDENCE_COLORS.items():
        opacity = evidence[:, :, index : index + 1] * EVIDENCE_OPACITY
        pixels = np.concatenate([np.broadcast_to(to_rgb(color), (*opacity.shape[:2], 3)), opacity], axis=2)
        add_image(Image.fromarray((255 * pixels).astype(np.uint8)), "RGBA", grid, ax, level=INK_LEVEL)


def _list_samples(explanation: Explanation) -> list[tuple[Artist, str]]:
    """Handles and texts of the legend."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    samples: list[tuple[Artist, str]] = [
        (Line2D([], [], color=CUT_COLOR, linewidth=CUT_WIDTH), "divides two rooms, with its probability"),
        (Line2D([], [], color=JOINED_COLOR, linewidth=JOINED_WIDTH, linestyle=JOINED_DASHES), "considered, one room"),
    ]
    if explanation.evidence is not None:
        named = [(EVIDENCE_COLORS[index], EVIDENCE_OPACITY, name) for index, name in EVIDENCE_NAMES.items()]
    else:
        named = [(FURNITURE_COLOR, FURNITURE_OPACITY, "furniture")] if explanation.floor.furniture else []
    return samples + [(Patch(facecolor=(color, opacity)), name) for color, opacity, name in named]
