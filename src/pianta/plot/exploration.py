"""Pictures of explorations: the map that robots made, their tracks, the frontiers left, and the area over distance."""

from __future__ import annotations

from pathlib import Path
from shutil import copyfile
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pianta.errors import OptionError
from pianta.exploration.frontiers import border_cells
from pianta.exploration.record import Exploration
from pianta.exploration.world import World, as_world
from pianta.floor import Floor
from pianta.gridmap import FREE, OCCUPIED, GridMap
from pianta.io._files import atomic_file
from pianta.plot.figure import DPI, new_ax, new_figure
from pianta.plot.grid import FREE_GREY, OCCUPIED_GREY, UNKNOWN_GREY
from pianta.plot.picture import BACKGROUND, LONG_SIDE_PX, MIN_ASPECT, plot_scale_bar
from pianta.plot.styles import DARK_INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Paul Tol's "bright" scheme, for lines.
TRACK_COLORS = ("#4477aa", "#aa3377", "#228833", "#ccbb44", "#66ccee", "#ee6677")
FRONTIER_COLOR = "#ee7733"
# Free space that is not explored yet.
UNEXPLORED_GREY = 243
# Inches: height of the curve below the map; space for its labels, left of it and below it.
CURVE_HEIGHT = 1.3
LEFT = 0.55
BELOW = 0.45
FONT_SIZE = 7

ANIMATION_DPI = 100
FRAMES_PER_SECOND = 10
MAX_FRAMES = 80
# How often the last picture is repeated at the end.
LAST_FRAMES = 10
# Writer of matplotlib by file format.
WRITERS = {"gif": "pillow", "mp4": "ffmpeg"}


def plot_exploration(
    run: Exploration, world: World | Floor | GridMap | str | Path, *, ax: Axes | None = None, scan: int | None = None
) -> Axes:
    """Draw the map that robots had at a scan, with frontiers in orange and the tracks so far.

    Free space that was not explored by then is pale. A disc is where a robot started, a ring where it is. Axes are
    metres from the lower left corner of the grid.

    Parameters
    ----------
    run
        The result of `explore`.
    world
        The explored world, as `explore` accepts it.
    ax
        Where to draw; a new figure if None.
    scan
        The number of the scan, from 0; None for the last.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import numpy as np
    >>> import pianta
    >>> grid = pianta.GridMap(np.zeros((20, 30), int), 0.1)
    >>> run = pianta.explore(grid)
    >>> ax = pianta.plot.plot_exploration(run, grid)
    """
    ax = new_ax(ax)
    world = as_world(world)
    scan = len(run.area) - 1 if scan is None else scan
    colors = _color_cells(run, world, scan)
    height, width = colors.shape[:2]
    # The picture shows the frame of the grid, which may be rotated against the map frame.
    extent = (0, width * world.resolution, 0, height * world.resolution)
    ax.imshow(colors, extent=extent, interpolation="antialiased", zorder=0)
    moved = run.robot[: scan + 1]
    for number, track in enumerate(run.tracks):
        xy = track[: np.count_nonzero(moved == number), :2]
        rows, cols = world.grid.map_to_pixel(*xy.T)
        x, y = cols * world.resolution, (height - rows) * world.resolution
        color = TRACK_COLORS[number % len(TRACK_COLORS)]
        ax.plot(x, y, color=color, linewidth=0.9, zorder=2)
        ax.plot(x[:1], y[:1], "o", color=color, markersize=3.5, zorder=3)
        ax.plot(x[-1:], y[-1:], "o", color=color, markersize=5, markerfacecolor="white", zorder=4)
    ax.set(xlim=extent[:2], ylim=extent[2:], aspect="equal")
    return ax


def plot_area(run: Exploration, *, ax: Axes | None = None, scan: int | None = None) -> Axes:
    """Draw the explored share of the reachable area, in %, over the metres of all robots, up to a scan.

    Parameters
    ----------
    run
        The result of `explore`.
    ax
        Where to draw; a new figure if None.
    scan
        The number of the scan, from 0; None for the last.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import numpy as np
    >>> import pianta
    >>> grid = pianta.GridMap(np.zeros((20, 30), int), 0.1)
    >>> run = pianta.explore(grid)
    >>> ax = pianta.plot.plot_area(run)
    """
    ax = new_ax(ax, equal=False)
    until = len(run.area) if scan is None else scan + 1
    ax.plot(run.distance[:until], 100 * run.share[:until], color=TRACK_COLORS[0], linewidth=1.2)
    ax.set(xlim=(0, max(run.distance[-1], 1)), ylim=(0, 102), yticks=(0, 50, 90, 100))
    ax.set_xlabel("driven, m", fontsize=FONT_SIZE, labelpad=1)
    ax.set_ylabel(f"% of {run.reachable_area:.0f} m²", fontsize=FONT_SIZE, labelpad=1)
    ax.tick_params(labelsize=FONT_SIZE, color=DARK_INK)
    ax.grid(visible=True, linewidth=0.3)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def draw_exploration(run: Exploration, world: World, *, scan: int | None = None) -> Figure:
    """Picture of an exploration at a scan, by default the last: the map with the tracks, and below it the area."""
    height, width = world.blocked.shape
    sides = np.maximum(np.array([width, height]) / max(width, height), MIN_ASPECT) * LONG_SIDE_PX / DPI
    size = (sides[0], sides[1] + CURVE_HEIGHT + BELOW)
    figure = new_figure(*size)
    share = (CURVE_HEIGHT + BELOW) / size[1]
    ax = figure.add_axes((0, share, 1, 1 - share), facecolor=BACKGROUND)
    ax.set_axis_off()
    plot_exploration(run, world, ax=ax, scan=scan)
    plot_scale_bar(ax=ax)
    curve_width, curve_height = size[0] - LEFT - 0.15, CURVE_HEIGHT - 0.1
    curve = figure.add_axes((LEFT / size[0], BELOW / size[1], curve_width / size[0], curve_height / size[1]))
    plot_area(run, ax=curve, scan=scan)
    return figure


def check_animation(file_format: str) -> None:
    """Raise OptionError for an animation that cannot be written here: MP4 needs the program ffmpeg."""
    from matplotlib.animation import writers

    if file_format not in WRITERS:
        raise OptionError(f"animation is {file_format!r}, give gif, mp4 or none")
    writer = WRITERS[file_format]
    if not writers.is_available(writer):
        raise OptionError(f"an animation as {file_format} needs {writer}, which is not installed; give gif")


def save_animation(
    run: Exploration, world: World, path: str | Path, *, file_format: str = "gif", frames: int = MAX_FRAMES
) -> None:
    """Write an exploration as an animation with frames at equal distances, which rests at the end.

    file_format: "gif" or "mp4". frames: how many at most.
    Raises OptionError as check_animation does, and PiantaError if the file cannot be written.
    """
    from matplotlib.animation import writers

    check_animation(file_format)
    distances = np.linspace(0, run.distance[-1], frames)
    scans = np.unique(np.append(np.searchsorted(run.distance, distances - 1e-9), len(run.area) - 1))
    writer = writers[WRITERS[file_format]](fps=FRAMES_PER_SECOND)
    # The writers choose the format by the suffix of the file.
    with atomic_file(path) as temporary, TemporaryDirectory() as folder:
        file = Path(folder, f"exploration.{file_format}")
        with writer.saving(draw_exploration(run, world, scan=0), str(file), ANIMATION_DPI):
            for scan in [*scans.tolist(), *[scans[-1]] * LAST_FRAMES]:
                writer.fig = draw_exploration(run, world, scan=scan)
                writer.grab_frame()
        copyfile(file, temporary)


def _color_cells(run: Exploration, world: World, scan: int) -> NDArray[np.uint8]:
    """Colours of cells, RGB of shape (H, W, 3), as robots had mapped them at a scan."""
    cells = run.map_at(scan).cells
    greys = np.where(world.blocked, UNKNOWN_GREY, UNEXPLORED_GREY).astype(np.uint8)
    greys[cells == FREE] = FREE_GREY
    greys[cells == OCCUPIED] = OCCUPIED_GREY
    colors = np.repeat(greys[:, :, None], 3, axis=2)
    colors[border_cells(cells)] = tuple(bytes.fromhex(FRONTIER_COLOR[1:]))
    return colors
