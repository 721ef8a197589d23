"""The ground on which unknown rooms are placed: cells along the walls, with the known rooms and the open ends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, cos, hypot, sin
from typing import Any, NamedTuple

import cv2
import networkx as nx
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString
from shapely.geometry.base import BaseGeometry

from pianta._types import Floats, Mask
from pianta.errors import FloorError
from pianta.floor import cells_of_polygon
from pianta.floor.polygons import list_polygons
from pianta.generation.drawing.blocks import CELL, NO_ROOM, Cells
from pianta.generation.drawing.choices import compute_edge_weight
from pianta.gridmap import GridMap
from pianta.layout.frames import measure_direction
from pianta.prediction.continuation.known_part import KnownPart
from pianta.prediction.continuation.layout import BLOCKED, RESERVED, SpaceFiller, fill_space
from pianta.prediction.unexplored_part import SampledFloor

# All chosen by hand.
PARTS = 5  # of a cell, along each side, by which the share of it that is known is measured
TAKEN_SHARE = 0.3  # of a cell that is known, from which no room is placed there
WALL_SHARE = 0.1  # the same for obstacles of the map
REACHES = (0.3, 0.5, 0.75, 1.0, 1.3)  # m from a door to the first free cell behind it
MARGIN_FACTOR = 1.5  # free space around the known part, over the side of a square of the area of all unknown rooms
MARGINS = (15.0, 80.0)  # m, smallest and largest
LARGEST = 250_000.0  # m², of the known part with the space around it; limits memory to some hundred megabytes
ROUNDING = 1e-6  # of a cell
CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


class Layout(NamedTuple):
    """The rooms of a sample in cells. numbers: its node of each room of which a part is seen, by explored node."""

    cells: Cells
    numbers: Mapping[int, int]


@dataclass(frozen=True, eq=False)
class Ground:
    """The known part in cells, along the main direction of its walls.

    frame: cell size and position of the cells in the map frame, row 0 at the top. blocked: cells where no room may be
    placed. partial: cells of open corridors and of unknown rooms of which a part is seen, by node of the explored part,
    without walls. thresholds: cells that the room behind an unopened door covers, by unknown room. openings: free cells
    where the known part goes on.
    """

    frame: GridMap
    blocked: Mask
    partial: Mapping[int, Mask]
    thresholds: Mapping[int, Mask]
    openings: Mask

    def arrange(
        self, sample: SampledFloor, *, areas: Mapping[int, float], corridors: frozenset[int], rng: np.random.Generator
    ) -> Layout:
        """Place the unknown rooms of a sample. areas: of its rooms, m²; corridors: its nodes."""
        cells: Cells = np.where(self.blocked, BLOCKED, NO_ROOM).astype(np.int32)
        numbers: dict[int, int] = {}
        for node, mask in self.partial.items():
            number = sample.known_nodes.get(node, sample.behind.get(node))
            # In a few samples nothing is behind a door
            cells[mask] = BLOCKED
            if number is not None and number not in numbers.values() and mask.any():
                cells[mask] = numbers[node] = number
        thresholds: dict[int, Mask] = {}
        for door, mask in self.thresholds.items():
            if door in sample.behind and mask.any():
                thresholds.setdefault(sample.behind[door], mask)
                cells[mask] = RESERVED
        partial = {number: float(self.partial[node].sum()) for node, number in numbers.items()}
        parents = span_unknown(sample, [*partial], [*thresholds], corridors, rng)
        in_cells = {node: area / CELL**2 for node, area in areas.items()}
        fill_space(SpaceFiller(cells, in_cells, corridors, thresholds, rng), partial, parents)
        return Layout(cells, numbers)


def span_unknown(
    sample: SampledFloor,
    partial: Sequence[int],
    behind: Sequence[int],
    corridors: frozenset[int],
    rng: np.random.Generator,
) -> dict[int, int | None]:
    """The room that leads to each unknown one, by node of the sample; None for those behind a known door."""
    inside = [*dict.fromkeys([*partial, *sample.unseen])]
    weighted = nx.Graph()
    root = -1
    weighted.add_node(root)
    for one, other in sample.graph.subgraph(inside).edges:
        weighted.add_edge(one, other, weight=compute_edge_weight((one, other), corridors, rng.random()))
    # Beginnings come first: what is seen, then what is behind a door
    weighted.add_weighted_edges_from((root, node, 0.5) for node in behind)
    weighted.add_weighted_edges_from((root, node, 0.0) for node in partial)
    tree = nx.minimum_spanning_tree(weighted)
    parents: dict[int, int | None] = {}
    for parent, node in nx.bfs_edges(tree, root):
        if node not in partial:
            parents[node] = None if parent == root else parent
    return parents


def prepare_ground(known_part: KnownPart, grid: GridMap | None, *, unknown_area: float) -> Ground:
    """The ground around a known part; grid: its map if there is one. unknown_area: of unknown rooms at most, m²."""
    margin = float(np.clip(MARGIN_FACTOR * unknown_area**0.5, *MARGINS))
    frame = make_frame(known_part.outlines, margin)
    partial = {node: measure_cover([outline], frame) >= TAKEN_SHARE for node, outline in known_part.partial.items()}
    blocked = measure_cover(known_part.closed, frame) >= TAKEN_SHARE
    if grid is not None:
        blocked |= count_cells(grid.occupied, grid, frame) >= WALL_SHARE
        blocked |= (count_cells(grid.free, grid, frame) >= TAKEN_SHARE) & ~np.logical_or.reduce(
            [blocked, *partial.values()]
        )
    partial = {node: mask & ~blocked for node, mask in partial.items()}
    blocked[[0, -1]], blocked[:, [0, -1]] = True, True
    free = ~np.logical_or.reduce([blocked, *partial.values()])
    thresholds = {
        node: find_threshold(line, free, frame)
        for node, line in known_part.ends.items()
        if node not in known_part.partial
    }
    openings = free & cv2.dilate(
        np.logical_or.reduce([np.zeros_like(free), *partial.values()]).astype(np.uint8), CROSS
    ).astype(bool)
    return Ground(frame, blocked, partial, thresholds, np.logical_or.reduce([openings, *thresholds.values()]))


def make_frame(outlines: Sequence[BaseGeometry], margin: float) -> GridMap:
    """Cells along the main direction of the walls, around outlines with a margin, m."""
    yaw = float(np.angle(measure_direction(np.array(outlines, dtype=object)))) / 4
    turned = shapely.transform(np.array(outlines, dtype=object), lambda xy: _turn(xy, -yaw))
    left, bottom, right, top = shapely.total_bounds(turned)
    width, height = right - left + 2 * margin, top - bottom + 2 * margin
    if not width * height <= LARGEST:
        size = f"{width:.0f} m × {height:.0f} m"
        raise FloorError(f"the floor has {size} with the space around it, give one of {LARGEST:.0f} m² at most")
    columns, rows = (ceil(side / CELL - ROUNDING) for side in (width, height))
    x, y = _turn(np.array([[left - margin, bottom - margin]]), yaw)[0].tolist()
    return GridMap(np.zeros((rows, columns), np.int8), CELL, (x, y, yaw))


def _turn(xy: Floats, angle: float) -> Floats:
    c, s = cos(angle), sin(angle)
    return np.asarray(xy @ np.array([[c, s], [-s, c]]))


def measure_cover(outlines: Iterable[BaseGeometry], frame: GridMap) -> Floats:
    """The share of each cell that outlines cover."""
    return average_cells(cover(outlines, refine(frame)))


def count_cells(mask: Mask, grid: GridMap, frame: GridMap) -> Floats:
    """The share of each cell of a frame that cells of a map cover."""
    rows, cols = np.nonzero(mask)
    rows, cols = (np.floor(part).astype(int) for part in frame.map_to_pixel(*grid.pixel_to_map(rows + 0.5, cols + 0.5)))
    inside = (rows >= 0) & (cols >= 0) & (rows < frame.shape[0]) & (cols < frame.shape[1])
    numbers = rows[inside] * frame.shape[1] + cols[inside]
    counts = np.bincount(numbers, minlength=frame.cells.size).reshape(frame.shape)
    return np.asarray(counts * (grid.resolution / frame.resolution) ** 2)


def refine(frame: GridMap) -> GridMap:
    """A frame with smaller cells."""
    rows, columns = frame.shape
    return GridMap(np.zeros((rows * PARTS, columns * PARTS), np.int8), CELL / PARTS, frame.origin)


def cover(outlines: Iterable[BaseGeometry], fine: GridMap) -> Mask:
    """The cells whose centres are in one of the outlines."""
    covered = np.zeros(fine.shape, bool)
    for outline in list_polygons([*outlines]):
        rows, columns, mask = cells_of_polygon(outline, fine)
        covered[rows, columns] |= mask
    return covered


def average_cells(fine: NDArray[Any]) -> Floats:
    """The mean over the fine cells of each cell."""
    rows, columns = (side // PARTS for side in fine.shape)
    return np.asarray(fine.reshape(rows, PARTS, columns, PARTS).mean(axis=(1, 3)))


def find_threshold(line: LineString, free: Mask, frame: GridMap) -> Mask:
    """The free cells before a door, on its side where there is space; none if there is no space."""
    mask = np.zeros_like(free)
    (x0, y0), (x1, y1) = line.coords[0], line.coords[-1]
    length = hypot(x1 - x0, y1 - y0) or 1.0
    along = np.array([x1 - x0, y1 - y0]) / length
    middle = np.array([x0 + x1, y0 + y1]) / 2
    for reach in REACHES:
        for side in (1, -1):
            normal = side * np.array([-along[1], along[0]])
            points = middle + reach * normal + np.outer((0.0, -CELL, CELL), along)
            rows, cols = (np.floor(part).astype(int) for part in frame.map_to_pixel(points[:, 0], points[:, 1]))
            inside = (rows >= 0) & (cols >= 0) & (rows < free.shape[0]) & (cols < free.shape[1])
            if inside[0] and free[rows[0], cols[0]]:
                for row, col in zip(rows[inside].tolist(), cols[inside].tolist(), strict=True):
                    mask[row, col] = free[row, col]
                return mask
    return mask
