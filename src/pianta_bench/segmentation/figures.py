"""True rooms beside reconstructed rooms, with the errors marked."""

from __future__ import annotations

from colorsys import hls_to_rgb
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta.evaluation.segmentation import match_rooms
from pianta.gridmap import GridMap
from pianta.plot.grid import FREE_GREY, OCCUPIED_GREY, UNKNOWN_GREY
from pianta_bench.harness.charts import save_chart

# Neighbouring ids differ by the golden angle; reds are left to the errors.
GOLDEN_TURN = 0.381966  # of a full turn of hue
HUES = (0.09, 0.88)
LIGHTNESS = (0.72, 0.82)  # of even and odd ids
ERROR_COLOR = (204, 20, 40)
UNMATCHED_GREY = 175
MARGIN_M = 1.0  # m around the building
OUTLINE_M = 0.15  # m, width of the outlines of unmatched rooms
LONG_SIDE_PX = 2000
DPI = 100
CAPTION_PX = 46


def save_comparison(
    reconstructed: NDArray[np.integer], truth: NDArray[np.integer], grid: GridMap, path: str | Path
) -> None:
    """Write a PNG of the true rooms, left, and the reconstructed ones, right, on the map, cropped to the building.

    reconstructed, truth: shape (H, W), n > 0 is a room. Rooms that match (IoU above 0.5) have one colour, others are
    grey with a red outline; the pixels in which a pair of matching rooms differs are red on the right.

    Raises PiantaError when the file cannot be written.
    """
    from matplotlib.figure import Figure

    window = _crop_building((reconstructed > 0) | (truth > 0) | grid.free, round(MARGIN_M / grid.resolution))
    reconstructed, truth = reconstructed[window], truth[window]
    matches = match_rooms(reconstructed, truth)
    images = paint_comparison(reconstructed, truth, GridMap(grid.cells[window], grid.resolution), matches)
    rows, cols = reconstructed.shape
    scale = LONG_SIDE_PX / max(2 * cols, rows)
    size = 2 * cols * scale / DPI, (rows * scale + CAPTION_PX) / DPI
    figure = Figure(figsize=size, dpi=DPI, facecolor="white")
    number, true = (len(np.unique(labels[labels > 0])) for labels in (reconstructed, truth))
    missed, wrong = true - len(matches), number - len(matches)
    captions = (
        f"{true} true rooms, {missed} missed",
        f"{number} reconstructed rooms, {wrong} without a match; red: errors",
    )
    height = rows * scale / (rows * scale + CAPTION_PX)
    for side, (image, caption) in enumerate(zip(images, captions, strict=True)):
        ax = figure.add_axes((side / 2, 0, 0.498, height))
        ax.set_axis_off()
        ax.imshow(image, aspect="auto", interpolation="antialiased")
        figure.text(side / 2 + 0.005, (1 + height) / 2, caption, fontsize=14, va="center")
    save_chart(figure, Path(path), dpi=DPI)


def paint_comparison(
    reconstructed: NDArray[np.integer], truth: NDArray[np.integer], grid: GridMap, matches: dict[int, int]
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """The two pictures, red, green and blue of each cell, shape (H, W, 3).

    matches: the id of a true room by the id of the reconstructed room that matches it.
    """
    partners = np.zeros(int(reconstructed.max(initial=0)) + 1, np.int32)
    partners[list(matches)] = list(matches.values())
    true_of_reconstructed = np.where(reconstructed > 0, partners[np.maximum(reconstructed, 0)], 0)
    true_matched = np.where(np.isin(truth, list(matches.values())), truth, 0)
    left, right = (_paint_map(grid) for _ in range(2))
    for image, rooms, matched in ((left, truth, true_matched), (right, reconstructed, true_of_reconstructed)):
        image[rooms > 0] = UNMATCHED_GREY
        image[matched > 0] = _color_ids(int(truth.max(initial=0)))[matched[matched > 0]]
        image[_outline_rooms(np.where(matched > 0, 0, rooms), round(OUTLINE_M / grid.resolution))] = ERROR_COLOR
    right[true_of_reconstructed != true_matched] = ERROR_COLOR
    return left, right


def _paint_map(grid: GridMap) -> NDArray[np.uint8]:
    greys = np.full(grid.shape, UNKNOWN_GREY, np.uint8)
    greys[grid.free] = FREE_GREY
    greys[grid.occupied] = OCCUPIED_GREY
    return np.repeat(greys[:, :, None], 3, axis=2)


def _color_ids(highest: int) -> NDArray[np.uint8]:
    """A light colour for each id up to the highest, shape (1 + highest, 3)."""
    first, last = HUES
    hues = first + (np.arange(highest + 1) * GOLDEN_TURN) % 1 * (last - first)
    colors = [hls_to_rgb(hue, LIGHTNESS[index % 2], 0.7) for index, hue in enumerate(hues.tolist())]
    return np.round(255 * np.array(colors)).astype(np.uint8)


def _outline_rooms(rooms: NDArray[np.integer], width: int) -> NDArray[np.bool_]:
    """The rim of each room, `width` cells wide, inside the room and not around obstacles in it; shape (H, W)."""
    from scipy.ndimage import grey_closing, maximum_filter, minimum_filter

    size = 2 * max(width, 1) + 1
    around = np.where(rooms > 0, rooms, grey_closing(rooms, 3 * size, mode="constant"))
    return np.asarray((rooms > 0) & (maximum_filter(around, size) != minimum_filter(around, size)))


def _crop_building(building: NDArray[np.bool_], margin: int) -> tuple[slice, slice]:
    """Rows and columns around the cells of the building; all of them if it has none."""
    windows = []
    for axis in (1, 0):
        indices = np.flatnonzero(building.any(axis=axis))
        first, last = (indices[0], indices[-1]) if indices.size else (0, building.shape[1 - axis] - 1)
        windows.append(slice(max(first - margin, 0), last + margin + 1))
    return windows[0], windows[1]
