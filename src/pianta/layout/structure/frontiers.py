"""Frontiers: where free space ends at unknown space.

Section 8.2 of the thesis calls a face partial that is adjacent to an external one with hardly any wall between them;
here a room is partial by the length of its frontier.
"""

from __future__ import annotations

from math import ceil

import cv2
import numpy as np
import shapely
from shapely import Polygon

from pianta._types import Floats, LabelImage, Mask
from pianta.errors import MapError
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.layout._label_images import grow_mask
from pianta.layout._working_grid import WorkingGrid, to_working_grid
from pianta.layout.parameters import StructureParameters

# Unknown cells this near to an obstacle may be the blurred side of a wall; cells of the working grid (chosen by hand).
BLUR_PX = 2
# A shorter frontier is the shadow of a piece of furniture: share of the side of a square as large as the room. Chosen
# on nine maps of three buildings of `pianta bench partial`, as the largest that misses no partial room.
MIN_FRONTIER_SHARE = 0.25


def find_frontiers(grid: GridMap, working_grid: WorkingGrid, space: Mask, *, min_thickness: float = 0.0) -> Mask:
    """Free cells beside unknown ones that have no obstacle near, shape (H, W) of the working grid.

    grid: the map of the working grid. space: shape (H, W), the free cells.
    min_thickness: thinner unknown space is ignored, as a grey wall or a gap between two beams; metres.
    """
    # A wall may be thinner than a working cell, so a working cell is an obstacle if any part of it is.
    reach = round(working_grid.resolution / grid.resolution) // 2
    obstacle = working_grid.sample(grow_mask(grid.occupied, reach))
    unknown = _drop_thin(working_grid.sample(grid.unknown) & ~space, round(min_thickness / working_grid.resolution / 2))
    clear = ~grow_mask(obstacle, BLUR_PX)
    return np.asarray(space & clear & grow_mask(unknown & clear, 1))


def _drop_thin(unknown: Mask, reach: int) -> Mask:
    """Unknown cells, shape (H, W), that lie in a fully unknown square of side 2 · reach + 1."""
    if reach < 1:
        return unknown
    # The working grid ends close behind the free space; unknown space is taken to continue beyond its edge.
    around = np.pad(unknown, 2 * reach, mode="edge").astype(np.uint8)
    block = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    thick = cv2.morphologyEx(around, cv2.MORPH_OPEN, block)[2 * reach : -2 * reach, 2 * reach : -2 * reach]
    return np.asarray(thick > 0)


def measure_frontiers(labels: LabelImage, frontier: Mask, *, resolution: float) -> Floats:
    """Length of the frontier of each label 0 … max, metres; shape (1 + max,).

    labels, frontier: shape (H, W). resolution: metres per cell. Each cell counts as its side, so that a diagonal
    frontier is up to √2 times as long as measured.
    """
    return np.asarray(np.bincount(labels[frontier], minlength=int(labels.max()) + 1) * resolution, float)


def find_partial_labels(labels: LabelImage, frontier_lengths: Floats, *, min_length: float, resolution: float) -> Mask:
    """Whether each label 0 … max is a partial room, shape (1 + max,): it ends at unknown space.

    Its frontier has at least min_length, and MIN_FRONTIER_SHARE for its size.
    labels: shape (H, W). frontier_lengths: of each label, shape (1 + max,); metres. min_length, resolution: metres.
    """
    side = np.sqrt(np.bincount(labels.ravel(), minlength=len(frontier_lengths))) * resolution
    return np.asarray(frontier_lengths >= np.maximum(min_length, MIN_FRONTIER_SHARE * side))


def is_partial_room(room: Polygon, grid: GridMap, parameters: StructureParameters) -> bool:
    """Whether a room ends at unknown space, by its outline in the map frame, such as of one that was joined from parts.

    By the rule of `find_partial_labels`, on the free cells of the map.
    """
    rows, cols = (np.asarray(each) for each in grid.map_to_pixel(*shapely.get_coordinates(room).T))
    margin = ceil(parameters.unseen_width / grid.resolution)
    (top, bottom), (left, right) = (
        (max(0, int(each.min()) - margin), min(size, ceil(each.max()) + margin))
        for each, size in zip((rows, cols), grid.shape, strict=True)
    )
    x, y = (float(each) for each in grid.pixel_to_map(bottom, left))
    part = GridMap(grid.cells[top:bottom, left:right], grid.resolution, (x, y, grid.origin[2]))
    try:
        working_grid = to_working_grid(
            part, part.free, resolution=parameters.working_resolution, coarsest=part.resolution, normal_pose=False
        )
    except MapError:  # none of its cells is free any more
        return False
    inside = working_grid.sample(Floor((Room(1, room),)).label_image(part)).astype(np.int32)
    frontier = find_frontiers(part, working_grid, working_grid.free, min_thickness=parameters.unseen_width)
    lengths = measure_frontiers(inside, frontier, resolution=working_grid.resolution)
    cell = working_grid.resolution
    is_partial = find_partial_labels(inside, lengths, min_length=parameters.frontier, resolution=cell)
    return bool(len(is_partial) > 1 and is_partial[1])


def remove_ray_leaks(labels: LabelImage, frontier_lengths: Floats, *, width: float, resolution: float) -> LabelImage:
    """Labels, shape (H, W), without those narrower than width between their frontiers: rays that left through glass.

    frontier_lengths: of each label, shape (1 + max,); metres. width, resolution: metres.
    """
    area = np.bincount(labels.ravel(), minlength=len(frontier_lengths)) * resolution**2
    # A strip has a frontier on both sides, so its width is twice its area over the length of its frontier.
    return np.where((area < width / 2 * frontier_lengths)[labels], 0, labels)
