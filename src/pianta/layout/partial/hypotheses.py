"""Hypotheses of what a partial room looks like as a whole: its frontiers moved on to lines of the building."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from pianta._types import Floats, Mask
from pianta.layout.partial.scene import NEAR, Scene, Window, grow, shrink

# Shortest frontier on a side that may go on, and how far from the outermost cell it may be; metres.
LEAST_FRONTIER, BAND = 0.3, 1.0
# Nearest and widest blur of a line, and a line beside the room tells less from this distance on; metres.
BLUR, BESIDE = 0.15, 15.0
# Lines turned against a side by more than this are not along it: sine of the angle.
ASLANT = 0.12
# How many places for a side are tried where one, two, three or four sides are open.
PLACES = (14, 7, 5, 4)
# Share of a column that stops what goes on, and what goes on is at least this far; metres.
STOPPED, SHORTEST = 0.5, 0.3
# Narrow parts of what is added are shaved off; metres.
SLIVER = 0.3

# The other rooms of a building of which none was seen whole, metres; how many cells of a wall may be inside a shape,
# for each on its outline; and a shape that adds less than this share to another is the same.
USUAL_EXTENT, FEW_WALLS, WORTH = np.array([[4.0, 5.0]]), 0.05, 0.02
# More doors than this are as good as many.
MANY_DOORS = 6
# First row and column, last row and column, both within.
Bounds: TypeAlias = tuple[int, int, int, int]

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

    cells: of a window of the scene, with all those seen. bounds: of the rectangle that it fills up. features: of
    FEATURES, shape (26,).
    """

    cells: Mask
    window: Window
    bounds: Bounds
    features: Floats


@dataclass(frozen=True, eq=False)
class Side:
    """A side of the rectangle around the seen cells, turned to the right.

    turns: quarter turns of the scene, as by np.rot90, that turn it there. extreme: its column then.
    open_rows: rows in which the room ends at its frontier there. support: metres of line at so many cells beyond.
    stop: cells to what stops it. places: cells beyond, 0 first, that are tried.
    """

    turns: int
    extreme: int
    open_rows: NDArray[np.intp]
    support: Floats
    stop: int
    places: tuple[int, ...]


# The sides that were moved on, and by how many cells.
Moves: TypeAlias = tuple[tuple[Side, int], ...]


def list_hypotheses(scene: Scene) -> list[Hypothesis]:
    """The room as seen, its rectangle with the open sides moved on, and strips beyond each frontier."""
    sides = [side for side in (_find_side(scene, turns) for turns in range(4)) if side is not None]
    seen = scene.seen[scene.window(_bound(scene.seen))]
    found = [_describe(scene, seen, _bound(scene.seen), (), sides)]
    for shape, moved, strip in _list_shapes(scene, sides):
        window = scene.window(shape)
        filled = _fill(scene, window, shape)
        found.append(_describe(scene, filled, shape, moved, sides, strip=strip))
        # What is hidden in a corner can often be reached past nothing but a wall's end
        whole = _draw(scene, window, shape) & ~scene.others[window] | scene.seen[window]
        if not strip and whole.sum() > (1 + WORTH) * filled.sum():
            hypothesis = _describe(scene, whole, shape, moved, sides)
            if hypothesis.features[FEATURES.index("walls inside")] < FEW_WALLS:
                found.append(hypothesis)
    return found


def _list_shapes(scene: Scene, sides: list[Side]) -> Iterator[tuple[Bounds, Moves, bool]]:
    """Rectangles, by which steps of which sides they come about, and whether they are strips."""
    if not sides:
        return
    count = PLACES[len(sides) - 1]
    for steps in product(*(side.places[:count] for side in sides)):
        moved = tuple((side, step) for side, step in zip(sides, steps, strict=True) if step)
        rectangle = _bound(scene.seen)
        for side, step in moved:
            rectangle = _move_side(rectangle, side.turns, step)
        yield rectangle, moved, False
    for side in sides:
        for step in side.places[1:]:
            yield _bound_strip(scene, side, step), ((side, step),), True


def _bound(mask: Mask) -> Bounds:
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return int(rows[0]), int(cols[0]), int(rows[-1]), int(cols[-1])


def _move_side(bounds: Bounds, turns: int, step: int) -> Bounds:
    """Bounds with the side that so many quarter turns bring to the right moved on by a step."""
    top, left, bottom, right = bounds
    return ((top, left, bottom, right + step), (top, left, bottom + step, right), (top, left - step, bottom, right),
            (top - step, left, bottom, right))[turns]  # fmt: skip


def _draw(scene: Scene, window: Window, bounds: Bounds) -> Mask:
    """The rectangle in a window of the scene."""
    top, left, bottom, right = bounds
    mask = np.zeros(scene.seen.shape, bool)[window]
    rows, cols = window
    mask[max(top - rows.start, 0) : bottom + 1 - rows.start, max(left - cols.start, 0) : right + 1 - cols.start] = True
    return mask


def _find_side(scene: Scene, turns: int) -> Side | None:
    """A side with the places that it may have; None where it is no frontier."""
    seen, blocked, frontier = (np.rot90(mask, turns) for mask in (scene.seen, scene.blocked, scene.frontier))
    rows = np.flatnonzero(seen.any(axis=1))
    last = seen.shape[1] - 1 - seen[rows, ::-1].argmax(axis=1)
    extreme, cell = int(last.max()), scene.view.cell
    is_open = (last >= extreme - BAND / cell) & frontier[rows, last]
    if is_open.sum() * cell < LEAST_FRONTIER or extreme + 1 >= seen.shape[1]:
        return None
    open_rows = rows[is_open]
    ahead = blocked[open_rows, extreme + 1 :].mean(axis=0) > STOPPED
    stop = int(ahead.argmax()) if ahead.any() else len(ahead) - 1
    support = _support_places(scene, turns, extreme, (int(rows[0]), int(rows[-1])))
    return Side(turns, extreme, open_rows, support, stop, _choose_places(scene, turns, support, stop))


def _support_places(scene: Scene, turns: int, extreme: int, span: tuple[int, int]) -> Floats:
    """Metres of wall in line with a side that is moved on by 0, 1, … cells; walls beside the room count for more."""
    width = np.rot90(scene.seen, turns).shape[1]
    lines = _turn_lines(scene, turns)
    steps = np.abs(lines[:, 1] - lines[:, 0])
    along = lines[(steps[:, 0] < ASLANT * steps[:, 1])]
    lengths = np.abs(along[:, 1, 1] - along[:, 0, 1]) * scene.view.cell
    beside = np.maximum(span[0] - along[..., 1].max(axis=1), along[..., 1].min(axis=1) - span[1]).clip(min=0)
    weights = lengths * np.exp(-beside * scene.view.cell / BESIDE)
    beyond = along[..., 0].mean(axis=1) - (extreme + 1)
    places = np.rint(beyond).astype(int)
    within = (places >= 0) & (places < width - extreme - 1)
    support = np.bincount(places[within], weights[within], minlength=max(1, width - extreme - 1))
    sigma = BLUR / scene.view.cell
    return np.asarray(ndimage.gaussian_filter1d(support, sigma, mode="constant") * sigma * np.sqrt(2 * np.pi))


def _turn_lines(scene: Scene, turns: int) -> Floats:
    """Lines as col and row of the scene after so many quarter turns by np.rot90, shape (L, 2, 2)."""
    lines, (height, width) = scene.lines, scene.seen.shape
    for _ in range(turns):
        lines = np.stack([lines[..., 1], width - lines[..., 0]], axis=-1)
        height, width = width, height
    return lines


def _choose_places(scene: Scene, turns: int, support: Floats, stop: int) -> tuple[int, ...]:
    """Cells that a side is moved on by: 0, what stops it, the best lines, and the extents of other rooms."""
    least, limit = max(1, round(SHORTEST / scene.view.cell)), stop + 1
    peaks = [
        i
        for i in range(least, min(limit, len(support) - 1))
        if support[i] > 0.3 and support[i] >= support[i - 1] and support[i] > support[i + 1]
    ]
    extent = (np.ptp(_bound_cols(np.rot90(scene.seen, turns))) + 1) * scene.view.cell
    known = scene.extents[:, turns % 2]
    larger = known[known > extent + SHORTEST] - extent
    sizes = (
        [round(float(size) / scene.view.cell) for size in np.quantile(larger, (0.5, 0.2, 0.8))] if len(larger) else []
    )
    # The nearest lines are tried first, unless much longer ones are behind
    ranked = sorted(peaks, key=lambda i: -support[i] / (1 + i * scene.view.cell / 5))
    wanted = [0, *ranked[:2], stop, *sizes[:1], *ranked[2:5], *sizes[1:], *ranked[5:]]
    return tuple(dict.fromkeys(place for place in wanted if place == 0 or least <= place < limit))


def _bound_cols(mask: Mask) -> NDArray[np.intp]:
    return np.flatnonzero(mask.any(axis=0))[[0, -1]]


def _bound_strip(scene: Scene, side: Side, step: int) -> Bounds:
    """The longest run of open rows of a side, moved on alone."""
    seen = np.rot90(scene.seen, side.turns)
    runs = np.split(side.open_rows, np.flatnonzero(np.diff(side.open_rows) > 3) + 1)
    run = max(runs, key=len)
    last = seen.shape[1] - 1 - seen[run, ::-1].argmax(axis=1)
    strip = np.zeros(seen.shape, bool)
    strip[run[0] : run[-1] + 1, last.min() : side.extreme + step + 1] = True
    return _bound(np.rot90(strip, -side.turns))


def _fill(scene: Scene, window: Window, shape: Bounds) -> Mask:
    """The seen cells, and those of a shape that can be reached from the frontier past no obstacle and no other room."""
    seen = scene.seen[window]
    rest = _draw(scene, window, shape) & ~seen & ~scene.blocked[window]
    reach = max(1, round(SLIVER / scene.view.cell / 2))
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    whole = cv2.morphologyEx((rest | seen).astype(np.uint8), cv2.MORPH_OPEN, square).astype(bool) & rest
    _, parts = cv2.connectedComponents(whole.astype(np.uint8), connectivity=4)
    touched = np.unique(parts[grow(scene.frontier[window], 1) & whole])
    chosen = np.zeros(parts.max() + 1, bool)
    chosen[touched] = True
    chosen[0] = False
    return np.asarray(seen | chosen[parts])


def _describe(
    scene: Scene, cells: Mask, shape: Bounds, moved: Moves, sides: list[Side], *, strip: bool = False
) -> Hypothesis:
    """A hypothesis with its features. cells: of the window of the shape."""
    window = scene.window(shape)
    frontier, seen = scene.frontier[window], scene.seen.sum() * scene.view.cell**2
    features = (
        *_compare_extents(scene, cells),
        *_look_along_outline(scene, cells, shape),
        *_weigh_moves(scene, moved, sides),
        float(strip),
        scene.frontier.sum() * scene.view.cell / np.sqrt(seen),
        (frontier & shrink(cells, scene.near)).sum() / max(1, scene.frontier.sum()),
        min(scene.doors, MANY_DOORS) / 3,
        np.log1p(len(scene.extents)),
    )
    return Hypothesis(cells, window, shape, np.array(features, float))


def _compare_extents(scene: Scene, cells: Mask) -> tuple[float, ...]:
    """Size and aspect of a hypothesis beside those of what was seen and of other rooms: the first nine features."""
    cell = scene.view.cell
    extent, size = (_measure_extent(_bound(mask), cell) for mask in (scene.seen, cells))
    seen, area = scene.seen.sum() * cell**2, cells.sum() * cell**2
    known = scene.extents if len(scene.extents) else USUAL_EXTENT
    apart = np.abs(np.log(np.sort(known, axis=1) / np.sort(size))).sum(axis=1)
    return (
        np.log(seen),
        abs(np.log(extent[0] / extent[1])),
        seen / extent.prod(),
        seen / area,
        extent.prod() / size.prod(),
        np.log(area) - float(np.median(np.log(known.prod(axis=1)))),
        abs(np.log(size[0] / size[1])),
        np.exp(-3 * np.min(apart)),
        np.mean(np.exp(-((apart / 0.3) ** 2))),
    )


def _look_along_outline(scene: Scene, cells: Mask, shape: Bounds) -> tuple[float, ...]:
    """What the outline of a hypothesis lies at, which walls are inside it, and what stops it: the next five."""
    window = scene.window(shape)
    outline = cells & ~shrink(cells, 1)
    drawn = _draw(scene, window, shape) | scene.seen[window]
    inside = shrink(drawn, scene.near) & scene.walls[window] & ~scene.seen[window]
    marked = (scene.near_walls[window], scene.near_rooms[window], scene.frontier[window])
    shares = [(outline & mask).sum() / outline.sum() for mask in marked]
    return *shares, inside.sum() / outline.sum(), 1 - cells.sum() / drawn.sum()


def _weigh_moves(scene: Scene, moved: Moves, sides: list[Side]) -> tuple[float, ...]:
    """Which sides were moved on, how far, and onto how much wall: the next seven."""
    cell = scene.view.cell
    supports = [float(side.support[min(step, len(side.support) - 1)]) for side, step in moved] or [0.0]
    steps = [step * cell for _, step in moved] or [0.0]
    ends = [abs(step - side.stop) * cell < 2 * NEAR for side, step in moved] or [False]
    return (
        np.log1p(min(supports)),
        np.log1p(np.mean(supports)),
        len(moved),
        len(sides),
        np.log1p(sum(steps)),
        min(3.0, max(steps) / float(_measure_extent(_bound(scene.seen), cell).min())),
        float(np.mean(ends)),
    )


def _measure_extent(bounds: Bounds, cell: float) -> Floats:
    """Along the columns and along the rows, metres."""
    top, left, bottom, right = bounds
    return np.array([right - left + 1, bottom - top + 1]) * cell
