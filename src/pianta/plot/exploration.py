"""Pictures of explorations: the map that robots made, their tracks, the frontiers left, and the area over the way."""

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
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.io._files import atomic_file
from pianta.plot._figure import new_ax, save_png
from pianta.plot.floor import BACKGROUND, DPI, INK, LONG_SIDE_PX, plot_scale_bar
from pianta.plot.grid import FREE_GREY, OCCUPIED_GREY, UNKNOWN_GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Paul Tol's "bright" scheme, for lines.
TRACK_COLORS = ("#4477aa", "#aa3377", "#228833", "#ccbb44", "#66ccee", "#ee6677")
FRONTIER_COLOR = "#ee7733"
# Free space that nobody has seen yet.
UNSEEN_GREY = 243
# Inches: the curve below the map, and what is left of it and below it for its labels.
CURVE_HEIGHT, LEFT, BELOW = 1.3, 0.55, 0.45
FONT_SIZE = 7
# The short side of the map is at least this share of the long one.
MIN_ASPECT = 0.25
ANIMATION_DPI, FRAMES_A_SECOND, MAX_FRAMES, LAST_FRAMES = 100, 10, 80, 10

WRITERS = {"gif": "pillow", "mp4": "ffmpeg"}


def plot_exploration(
    run: Exploration, world: World | Floor | GridMap | str | Path, *, ax: Axes | None = None, scan: int | None = None
) -> Axes:
    """Draw what robots knew at a scan: the map, frontiers in orange, and their tracks so far.

    What is free and was not seen by then is pale. A disc is a start, a ring where a robot is. Axes are metres from the
    lower left corner of the grid.

    Parameters
    ----------
    run
        Of `explore`.
    world
        The world that was explored, as `explore` takes it.
    ax
        Where to draw; a new figure if None.
    scan
        The number of the scan, from 0; None for the last.

    Returns
    -------
    Axes
        The ax that was drawn on; nothing is shown.

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
    # The frame of the picture is that of the grid, which may be turned against the map frame.
    extent = (0, width * world.resolution, 0, height * world.resolution)
    ax.imshow(colors, extent=extent, interpolation="antialiased", zorder=0)
    for number, track in enumerate(_tracks_until(run, scan)):
        rows, cols = world.grid.map_to_pixel(track[:, 0], track[:, 1])
        x, y = cols * world.resolution, (height - rows) * world.resolution
        color = TRACK_COLORS[number % len(TRACK_COLORS)]
        ax.plot(x, y, color=color, linewidth=0.9, zorder=2)
        ax.plot(x[:1], y[:1], "o", color=color, markersize=3.5, zorder=3)
        ax.plot(x[-1:], y[-1:], "o", color=color, markersize=5, markerfacecolor="white", zorder=4)
    ax.set(xlim=extent[:2], ylim=extent[2:], aspect="equal")
    return ax


def plot_area(run: Exploration, *, ax: Axes | None = None, scan: int | None = None) -> Axes:
    """Draw the share of the reachable area, in %, over the metres of all robots, up to a scan.

    Parameters
    ----------
    run
        Of `explore`.
    ax
        Where to draw; a new figure if None.
    scan
        The number of the scan, from 0; None for the last.

    Returns
    -------
    Axes
        The ax that was drawn on; nothing is shown.

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
    ax.tick_params(labelsize=FONT_SIZE, color=INK)
    ax.grid(visible=True, linewidth=0.3)
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def draw_exploration(run: Exploration, world: World, *, scan: int | None = None) -> Figure:
    """Picture of an exploration at a scan, by default the last: the map with the tracks, and below it the area seen."""
    from matplotlib.figure import Figure

    height, width = world.blocked.shape
    sides = np.maximum(np.array([width, height]) / max(width, height), MIN_ASPECT) * LONG_SIDE_PX / DPI
    size = (sides[0], sides[1] + CURVE_HEIGHT + BELOW)
    figure = Figure(figsize=size, dpi=DPI, facecolor="white")
    share = (CURVE_HEIGHT + BELOW) / size[1]
    ax = figure.add_axes((0, share, 1, 1 - share), facecolor=BACKGROUND)
    ax.set_axis_off()
    plot_exploration(run, world, ax=ax, scan=scan)
    plot_scale_bar(ax=ax)
    inches = LEFT, BELOW, size[0] - LEFT - 0.15, CURVE_HEIGHT - 0.1
    curve = figure.add_axes((inches[0] / size[0], inches[1] / size[1], inches[2] / size[0], inches[3] / size[1]))
    plot_area(run, ax=curve, scan=scan)
    return figure


def save_exploration_picture(run: Exploration, world: World, path: str | Path) -> None:
    """Write the picture of draw_exploration as a PNG, the same bytes for the same run.

    Raises PiantaError when the file cannot be written.
    """
    figure = draw_exploration(run, world)
    save_png(figure, path)


def check_animation(kind: str) -> None:
    """Refuse an animation that cannot be written here: MP4 needs the program ffmpeg.

    Raises OptionError, in one line.
    """
    from matplotlib.animation import writers

    if kind not in WRITERS:
        raise OptionError(f"animation is {kind!r}, give gif, mp4 or none")
    if not writers.is_available(WRITERS[kind]):
        raise OptionError(f"an animation as {kind} needs {WRITERS[kind]}, which is not installed; give gif")


def save_animation(
    run: Exploration, world: World, path: str | Path, *, kind: str = "gif", frames: int = MAX_FRAMES
) -> None:
    """Write an exploration as a moving picture, in steps of the same way, 10 a second; it rests at the end.

    kind: "gif" or "mp4". frames: at most so many.
    Raises OptionError as check_animation does, and PiantaError when the file cannot be written.
    """
    from matplotlib.animation import writers

    check_animation(kind)
    ways = np.linspace(0, run.distance[-1], frames)
    scans = np.unique(np.append(np.searchsorted(run.distance, ways - 1e-9), len(run.area) - 1))
    writer = writers[WRITERS[kind]](fps=FRAMES_A_SECOND)
    # The writers tell the format by the name of the file.
    with atomic_file(path) as temporary, TemporaryDirectory() as folder:
        file = Path(folder, f"exploration.{kind}")
        with writer.saving(draw_exploration(run, world, scan=0), str(file), ANIMATION_DPI):
            for scan in [*scans.tolist(), *[scans[-1]] * LAST_FRAMES]:
                writer.fig = draw_exploration(run, world, scan=scan)
                writer.grab_frame()
        copyfile(file, temporary)


def _color_cells(run: Exploration, world: World, scan: int) -> NDArray[np.uint8]:
    """Colours of cells, shape (H, W, 3), as they were known at a scan."""
    known = np.where((run.scan_of_cell >= 0) & (run.scan_of_cell <= scan), run.map.cells, UNKNOWN)
    greys = np.where(world.blocked, UNKNOWN_GREY, UNSEEN_GREY).astype(np.uint8)
    greys[known == FREE] = FREE_GREY
    greys[known == OCCUPIED] = OCCUPIED_GREY
    colors = np.repeat(greys[:, :, None], 3, axis=2)
    colors[border_cells(known)] = tuple(bytes.fromhex(FRONTIER_COLOR[1:]))
    return colors


def _tracks_until(run: Exploration, scan: int) -> list[NDArray[np.float64]]:
    """The tracks, x, y, heading, shape (N, 3) each, up to a scan of all robots."""
    made = run.robot[: scan + 1]
    return [track[: np.count_nonzero(made == number)] for number, track in enumerate(run.tracks)]
