"""True rooms beside found rooms, with the errors marked."""

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
GOLDEN_TURN, HUES, LIGHTNESS = 0.381966, (0.09, 0.88), (0.72, 0.82)
ERROR_COLOR, UNMATCHED_GREY = (204, 20, 40), 175
MARGIN_M, OUTLINE_M = 1.0, 0.15
LONG_SIDE_PX, DPI, CAPTION_PX = 2000, 100, 46


def save_comparison(found: NDArray[np.integer], truth: NDArray[np.integer], grid: GridMap, path: str | Path) -> None:
    """Write a PNG of the true rooms, left, and the found ones, right, on the map, cropped to the building.

    found, truth: shape (H, W), n > 0 is a room. Rooms that match (IoU above 0.5) have one colour, the others are grey
    with a red outline; the pixels in which a pair of matching rooms differs are red on the right.

    Raises PiantaError when the file cannot be written.
    """
    from matplotlib.figure import Figure

    window = _crop_building((found > 0) | (truth > 0) | grid.free, round(MARGIN_M / grid.resolution))
    found, truth = found[window], truth[window]
    matches = match_rooms(found, truth)
    images = paint_comparison(found, truth, GridMap(grid.cells[window], grid.resolution), matches)
    rows, cols = found.shape
    scale = LONG_SIDE_PX / max(2 * cols, rows)
    size = 2 * cols * scale / DPI, (rows * scale + CAPTION_PX) / DPI
    figure = Figure(figsize=size, dpi=DPI, facecolor="white")
    number, true = (len(np.unique(labels[labels > 0])) for labels in (found, truth))
    missed, wrong = true - len(matches), number - len(matches)
    captions = f"{true} true rooms, {missed} missed", f"{number} rooms found, {wrong} of them no true room; red: errors"
    height = rows * scale / (rows * scale + CAPTION_PX)
    for side, (image, caption) in enumerate(zip(images, captions, strict=True)):
        ax = figure.add_axes((side / 2, 0, 0.498, height))
        ax.set_axis_off()
        ax.imshow(image, aspect="auto", interpolation="antialiased")
        figure.text(side / 2 + 0.005, (1 + height) / 2, caption, fontsize=14, va="center")
    save_chart(figure, Path(path), dpi=DPI)


def paint_comparison(
    found: NDArray[np.integer], truth: NDArray[np.integer], grid: GridMap, matches: dict[int, int]
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """The two pictures, red, green and blue of each cell, shape (H, W, 3).

    matches: the id of a true room by that of the found room that matches it.
    """
    partners = np.zeros(int(found.max(initial=0)) + 1, np.int32)
    partners[list(matches)] = list(matches.values())
    found_as_true = np.where(found > 0, partners[np.maximum(found, 0)], 0)
    true_matched = np.where(np.isin(truth, list(matches.values())), truth, 0)
    left, right = (_paint_map(grid) for _ in range(2))
    for image, rooms, matched in ((left, truth, true_matched), (right, found, found_as_true)):
        image[rooms > 0] = UNMATCHED_GREY
        image[matched > 0] = _color_ids(int(truth.max(initial=0)))[matched[matched > 0]]
        image[_outline_rooms(np.where(matched > 0, 0, rooms), round(OUTLINE_M / grid.resolution))] = ERROR_COLOR
    right[found_as_true != true_matched] = ERROR_COLOR
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
    """The rim of each room, some cells wide, inside of it and not around what stands in it; shape (H, W)."""
    from scipy.ndimage import grey_closing, maximum_filter, minimum_filter

    size = 2 * max(width, 1) + 1
    around = np.where(rooms > 0, rooms, grey_closing(rooms, 3 * size, mode="constant"))
    return np.asarray((rooms > 0) & (maximum_filter(around, size) != minimum_filter(around, size)))


def _crop_building(seen: NDArray[np.bool_], margin: int) -> tuple[slice, slice]:
    """Rows and columns around what is seen; all of them where nothing is."""
    windows = []
    for axis in (1, 0):
        places = np.flatnonzero(seen.any(axis=axis))
        first, last = (places[0], places[-1]) if places.size else (0, seen.shape[1 - axis] - 1)
        windows.append(slice(max(first - margin, 0), last + margin + 1))
    return windows[0], windows[1]
