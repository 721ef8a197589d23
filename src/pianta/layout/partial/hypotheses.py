"""Hypotheses of the whole shape of a partial room: its frontiers moved to wall lines of the building."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import TypeAlias

import cv2
import numpy as np
from scipy import ndimage

from pianta._types import Floats, Indices, Mask
from pianta.layout._label_images import shrink_mask
from pianta.layout.partial.scene import NEAR_DISTANCE, Bounds, RoomScene, Window, find_bounds

# The constants of the hypotheses and of their features were chosen by hand before the model was fitted to them.
# Least length of frontier on an open side; metres.
MIN_FRONTIER = 0.3
# Frontier cells belong to a side if they are at most this far from its outermost cell; metres.
SIDE_BAND = 1.0
# Standard deviation of the blur of the support of lines; metres.
SUPPORT_BLUR = 0.15
# Distance beside the room over which the weight of a line falls to 1/e; metres.
SUPPORT_DECAY = 15.0
# Lines support a side if the tangent of the angle between them is less than this.
MAX_LINE_SLOPE = 0.12
# A local maximum of the support is a position to try if it is larger; metres.
MIN_PEAK_SUPPORT = 0.3
# Distance beyond the side that halves the rank of a line; metres.
PEAK_DISTANCE = 5.0
# Quantiles of the extents of larger rooms that are tried, the first one with priority.
EXTENT_QUANTILES = (0.5, 0.2, 0.8)
# Number of positions that are tried for each side if one, two, three or four sides are open; a limit of time.
POSITION_COUNTS = (14, 7, 5, 4)
# A column of cells stops a side if more than this share of it is blocked.
STOP_SHARE = 0.5
# Least distance by which a side is moved; metres.
MIN_MOVE = 0.3
# Open rows with gaps of at most this number of rows are one run.
RUN_GAP = 3
# Narrower parts of the added area are removed; metres.
SLIVER_WIDTH = 0.3
# A whole rectangle is a hypothesis if it has fewer wall cells inside than this share of its outline, ...
MAX_WALL_SHARE = 0.05
# ... and if its area is larger by more than this share than that of its reachable part.
MIN_GROWTH = 0.02
# More doors count as this many, ...
MAX_DOORS = 6
# ... divided by this.
DOOR_SCALE = 3
# Rate at which the similarity to the most similar room falls with the difference of log extents.
NEAREST_SIMILARITY_RATE = 3
# Width of the Gaussian of the mean similarity; difference of log extents.
MEAN_SIMILARITY_WIDTH = 0.3
# Longest move over the shorter extent of the room, at most.
MAX_MOVE_RATIO = 3.0

FEATURES = (
    "log seen area",
    "log seen aspect",
    "seen share of its rectangle",
    "seen share",
    "rectangle share",
    "log area over the median",
    "log aspect",
    "likeness of the nearest",
    "mean likeness",
    "outline at walls",
    "outline at rooms",
    "frontier of the outline",
    "walls inside",
    "share stopped",
    "line, weakest",
    "line, mean",
    "sides moved",
    "sides open",
    "metres moved",
    "metres moved over extent",
    "ends at an obstacle",
    "is a strip",
    "frontier of the room",
    "frontier passed",
    "doors",
    "rooms seen whole",
)


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A shape that the room may have.

    cells: in a window of the scene, with all observed ones. bounds: of its rectangle. features: shape (26,), in the
    order of FEATURES.
    """

    cells: Mask
    window: Window
    bounds: Bounds
    features: Floats


@dataclass(frozen=True, eq=False)
class Side:
    """An open side of the rectangle around the observed cells, with the scene rotated so that it is on the right.

    turns: quarter turns of the scene, as for np.rot90, that bring the side to the right. extreme: its column then.
    open_rows: rows in which the room ends at its frontier. support: metres of wall lines at 0, 1, … cells beyond.
    stop: cells to the obstacle that stops it. offsets: cells by which it is moved in the hypotheses, 0 first.
    """

    turns: int
    extreme: int
    open_rows: Indices
    support: Floats
    stop: int
    offsets: tuple[int, ...]


# The sides that are moved, and by how many cells.
Moves: TypeAlias = tuple[tuple[Side, int], ...]


def list_hypotheses(scene: RoomScene) -> list[Hypothesis]:
    """The room as observed, its rectangle with the open sides moved outwards, and strips beyond each frontier."""
    sides = [side for side in (_find_side(scene, turns) for turns in range(4)) if side is not None]
    bounds = scene.bounds
    hypotheses = [_describe(scene, scene.observed[scene.window(bounds)], bounds, (), sides)]
    for rectangle, moves, strip in _list_rectangles(scene, sides):
        window = scene.window(rectangle)
        reachable = _fill(scene, window, rectangle)
        hypotheses.append(_describe(scene, reachable, rectangle, moves, sides, strip=strip))
        # A hidden corner behind the end of a wall belongs to the room too
        full = _draw(window, rectangle) & ~scene.others[window] | scene.observed[window]
        if not strip and np.count_nonzero(full) > (1 + MIN_GROWTH) * np.count_nonzero(reachable):
            hypothesis = _describe(scene, full, rectangle, moves, sides)
            if hypothesis.features[FEATURES.index("walls inside")] < MAX_WALL_SHARE:
                hypotheses.append(hypothesis)
    return hypotheses


def _list_rectangles(scene: RoomScene, sides: list[Side]) -> Iterator[tuple[Bounds, Moves, bool]]:
    """Rectangles, with the moves of sides that make them, and whether they are strips."""
    if not sides:
        return
    count = POSITION_COUNTS[len(sides) - 1]
    for offsets in product(*(side.offsets[:count] for side in sides)):
        moves = tuple((side, offset) for side, offset in zip(sides, offsets, strict=True) if offset)
        rectangle = scene.bounds
        for side, offset in moves:
            rectangle = _move_side(rectangle, side.turns, offset)
        yield rectangle, moves, False
    for side in sides:
        strip = _bound_strip(scene, side)
        for offset in side.offsets[1:]:
            yield _move_side(strip, side.turns, offset), ((side, offset),), True


def _move_side(bounds: Bounds, turns: int, offset: int) -> Bounds:
    """Bounds with one side, which quarter turns bring to the right, moved outwards."""
    moved = [*bounds]
    # The right, bottom, left and top side.
    moved[(3, 2, 1, 0)[turns]] += offset if turns < 2 else -offset
    return moved[0], moved[1], moved[2], moved[3]


def _draw(window: Window, bounds: Bounds) -> Mask:
    """The rectangle in a window of the scene."""
    top, left, bottom, right = bounds
    rows, cols = window
    mask = np.zeros((rows.stop - rows.start, cols.stop - cols.start), bool)
    mask[max(top - rows.start, 0) : bottom + 1 - rows.start, max(left - cols.start, 0) : right + 1 - cols.start] = True
    return mask


def _find_side(scene: RoomScene, turns: int) -> Side | None:
    """The side that quarter turns bring to the right, with its offsets; None if it has too little frontier."""
    observed, blocked, frontier = (np.rot90(mask, turns) for mask in (scene.observed, scene.blocked, scene.frontier))
    rows = np.flatnonzero(observed.any(axis=1))
    last = observed.shape[1] - 1 - observed[rows, ::-1].argmax(axis=1)
    extreme, cell = int(last.max()), scene.view.cell
    is_open = (last >= extreme - SIDE_BAND / cell) & frontier[rows, last]
    if is_open.sum() * cell < MIN_FRONTIER or extreme + 1 >= observed.shape[1]:
        return None
    open_rows = rows[is_open]
    ahead = blocked[open_rows, extreme + 1 :].mean(axis=0) > STOP_SHARE
    stop = int(ahead.argmax()) if ahead.any() else len(ahead) - 1
    support = _measure_support(scene, turns, extreme, (int(rows[0]), int(rows[-1])))
    return Side(turns, extreme, open_rows, support, stop, _choose_offsets(scene, turns, support, stop))


def _measure_support(scene: RoomScene, turns: int, extreme: int, span: tuple[int, int]) -> Floats:
    """Metres of wall in line with a side that is moved by 0, 1, … cells; walls beside the room have more weight."""
    width = np.rot90(scene.observed, turns).shape[1]
    lines = _turn_lines(scene, turns)
    steps = np.abs(lines[:, 1] - lines[:, 0])
    parallel = lines[(steps[:, 0] < MAX_LINE_SLOPE * steps[:, 1])]
    lengths = np.abs(parallel[:, 1, 1] - parallel[:, 0, 1]) * scene.view.cell
    beside = np.maximum(span[0] - parallel[..., 1].max(axis=1), parallel[..., 1].min(axis=1) - span[1]).clip(min=0)
    weights = lengths * np.exp(-beside * scene.view.cell / SUPPORT_DECAY)
    offsets = np.rint(parallel[..., 0].mean(axis=1) - (extreme + 1)).astype(int)
    within = (offsets >= 0) & (offsets < width - extreme - 1)
    support = np.bincount(offsets[within], weights[within], minlength=max(1, width - extreme - 1))
    sigma = SUPPORT_BLUR / scene.view.cell
    # The peak of a single line stays as high as its weight.
    return np.asarray(ndimage.gaussian_filter1d(support, sigma, mode="constant") * sigma * np.sqrt(2 * np.pi))


def _turn_lines(scene: RoomScene, turns: int) -> Floats:
    """The lines of the scene as col and row after quarter turns by np.rot90, shape (L, 2, 2)."""
    lines, (height, width) = scene.lines, scene.observed.shape
    for _ in range(turns):
        lines = np.stack([lines[..., 1], width - lines[..., 0]], axis=-1)
        height, width = width, height
    return lines


def _choose_offsets(scene: RoomScene, turns: int, support: Floats, stop: int) -> tuple[int, ...]:
    """Cells by which a side is moved: 0, up to the obstacle, to the best lines, and to the extents of other rooms."""
    cell = scene.view.cell
    shortest, limit = max(1, round(MIN_MOVE / cell)), stop + 1
    peaks = [
        i
        for i in range(shortest, min(limit, len(support) - 1))
        if support[i] > MIN_PEAK_SUPPORT and support[i] >= support[i - 1] and support[i] > support[i + 1]
    ]
    cols = np.flatnonzero(np.rot90(scene.observed, turns).any(axis=0))
    extent = (np.ptp(cols[[0, -1]]) + 1) * cell
    extents = scene.extents[:, turns % 2]
    growth = extents[extents > extent + MIN_MOVE] - extent
    sizes = [round(float(size) / cell) for size in np.quantile(growth, EXTENT_QUANTILES)] if len(growth) else []
    # Near lines come first, unless much longer ones are behind
    ranked = sorted(peaks, key=lambda i: -support[i] / (1 + i * cell / PEAK_DISTANCE))
    offsets = [0, *ranked[:2], stop, *sizes[:1], *ranked[2:5], *sizes[1:], *ranked[5:]]
    return tuple(dict.fromkeys(offset for offset in offsets if offset == 0 or shortest <= offset < limit))


def _bound_strip(scene: RoomScene, side: Side) -> Bounds:
    """The longest run of open rows of a side, up to the side."""
    observed = np.rot90(scene.observed, side.turns)
    runs = np.split(side.open_rows, np.flatnonzero(np.diff(side.open_rows) > RUN_GAP) + 1)
    run = max(runs, key=len)
    last = observed.shape[1] - 1 - observed[run, ::-1].argmax(axis=1)
    strip = np.zeros(observed.shape, bool)
    strip[run[0] : run[-1] + 1, last.min() : side.extreme + 1] = True
    return find_bounds(np.rot90(strip, -side.turns))


def _fill(scene: RoomScene, window: Window, rectangle: Bounds) -> Mask:
    """The observed cells, and those of a rectangle that the frontier reaches without crossing walls or other rooms."""
    observed = scene.observed[window]
    rest = _draw(window, rectangle) & scene.possible[window]
    reach = max(1, round(SLIVER_WIDTH / scene.view.cell / 2))
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    opened = cv2.morphologyEx((rest | observed).view(np.uint8), cv2.MORPH_OPEN, square)
    thick = np.asarray(opened).view(bool) & rest
    count, parts = cv2.connectedComponents(thick.view(np.uint8), connectivity=4)
    chosen = np.zeros(count, bool)
    chosen[parts[scene.near_frontier[window] & thick]] = True
    return np.asarray(observed | chosen[parts])


def _describe(
    scene: RoomScene, cells: Mask, rectangle: Bounds, moves: Moves, sides: list[Side], *, strip: bool = False
) -> Hypothesis:
    """A hypothesis with its features. cells: in the window of the rectangle."""
    window = scene.window(rectangle)
    frontier = scene.frontier[window]
    features = (
        *_compare_extents(scene, cells),
        *_measure_outline(scene, cells, window, rectangle),
        *_measure_moves(scene, moves, sides),
        float(strip),
        scene.frontier_count * scene.view.cell / np.sqrt(scene.observed_area),
        np.count_nonzero(frontier & shrink_mask(cells, scene.near)) / max(1, scene.frontier_count),
        min(scene.doors, MAX_DOORS) / DOOR_SCALE,
        np.log1p(len(scene.extents)),
    )
    return Hypothesis(cells, window, rectangle, np.array(features, float))


def _compare_extents(scene: RoomScene, cells: Mask) -> tuple[float, ...]:
    """The first nine features: size and aspect against those of the observed part and of other rooms."""
    cell = scene.view.cell
    extent, size = (_measure_extent(bounds, cell) for bounds in (scene.bounds, find_bounds(cells)))
    observed_area, area = scene.observed_area, np.count_nonzero(cells) * cell**2
    differences = np.abs(scene.log_extents - np.log(np.sort(size))).sum(axis=1)
    return (
        np.log(observed_area),
        abs(np.log(extent[0] / extent[1])),
        observed_area / extent.prod(),
        observed_area / area,
        extent.prod() / size.prod(),
        np.log(area) - scene.median_log_area,
        abs(np.log(size[0] / size[1])),
        np.exp(-NEAREST_SIMILARITY_RATE * np.min(differences)),
        np.mean(np.exp(-((differences / MEAN_SIMILARITY_WIDTH) ** 2))),
    )


def _measure_outline(scene: RoomScene, cells: Mask, window: Window, rectangle: Bounds) -> tuple[float, ...]:
    """The next five features: shares of the outline at walls, rooms and frontier, walls inside, and blocked cells."""
    outline = cells & ~shrink_mask(cells, 1)
    full = _draw(window, rectangle) | scene.observed[window]
    inside = shrink_mask(full, scene.near) & scene.walls[window] & ~scene.observed[window]
    masks = (scene.near_walls[window], scene.near_rooms[window], scene.frontier[window])
    length = np.count_nonzero(outline)
    shares = [np.count_nonzero(outline & mask) / length for mask in masks]
    return *shares, np.count_nonzero(inside) / length, 1 - np.count_nonzero(cells) / np.count_nonzero(full)


def _measure_moves(scene: RoomScene, moves: Moves, sides: list[Side]) -> tuple[float, ...]:
    """The next seven features: which sides were moved, how far, and onto how much wall."""
    cell = scene.view.cell
    supports = [float(side.support[min(offset, len(side.support) - 1)]) for side, offset in moves] or [0.0]
    metres = [offset * cell for _, offset in moves] or [0.0]
    ends = [abs(offset - side.stop) * cell < 2 * NEAR_DISTANCE for side, offset in moves] or [False]
    return (
        np.log1p(min(supports)),
        np.log1p(np.mean(supports)),
        len(moves),
        len(sides),
        np.log1p(sum(metres)),
        min(MAX_MOVE_RATIO, max(metres) / float(_measure_extent(scene.bounds, cell).min())),
        float(np.mean(ends)),
    )


def _measure_extent(bounds: Bounds, cell: float) -> Floats:
    """Extent along the columns and along the rows, metres."""
    top, left, bottom, right = bounds
    return np.array([right - left + 1, bottom - top + 1]) * cell
