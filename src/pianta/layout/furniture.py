"""Furniture of rooms: what stands in a room of a grid map and is no wall."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString

from pianta._types import Floats, LabelImage, Mask
from pianta.errors import OptionError
from pianta.floor import Floor, Furniture
from pianta.gridmap import GridMap
from pianta.layout._label_images import highest_of_labels, outline_labels

# The constants were chosen by hand on the maps of data/clutter and data/robotmaps.
# An outline may run this far beside the face of its wall, because walls are rough and outlines are smoothed; metres.
OUTLINE_TOLERANCE = 0.15
# What touches a wall and is thinner than this is roughness of the wall; metres beyond OUTLINE_TOLERANCE.
MIN_THICKNESS = 0.15
# What touches a wall, is thinner than this and reaches farther into the room than MAX_STUB_RATIO times its thickness
# is a stub of a wall; metres.
MIN_STUBLESS_THICKNESS = 0.35
MAX_STUB_RATIO = 2.0
# Thin pieces at least this long are walls if they lie on the line of a wall; metres.
WALL_LENGTH = 1.0
# A cell lies on the line of a wall up to this distance; metres.
WALL_LINE_DISTANCE = 0.15
# A thin piece is a wall if at least this share of its cells lies on lines of walls.
WALL_LINE_SHARE = 0.7
# A larger island in a room is a part of the building, such as a shaft; m².
MAX_ISLAND_AREA = 8.0
# Smaller groups of cells are spray of the lidar: two cells of 0.05 m; m².
MIN_AREA = 0.005
# Fewer cells are spray too, whatever their size.
MIN_CELLS = 2
# Cells of higher probability are furniture.
PROBABILITY = 0.5
# Groups that the rules take for furniture are dropped if their mean probability is lower. It is low, because models see
# coarser cells than maps have, and a leg of a chair fills a part of one.
MIN_MEAN_PROBABILITY = 0.1
# An outline of cells is simplified by this; cells. A rectangle of two cells keeps its four corners.
SMOOTHING_CELLS = 0.75

Probabilities = NDArray[np.floating]


@dataclass(frozen=True, eq=False)
class RoomContents:
    """The cells of a map in its rooms that are not free, each a part of one kind; what is left are walls.

    rooms: ids of the rooms on the cells, shape (H, W), with the islands that stand in one room; 0 no room.
    at_outline: cells of rooms at their outlines, where walls may be, shape (H, W).
    pieces: numbers of the pieces of furniture, shape (H, W); 0 none.
    spray: groups of cells too small for furniture, shape (H, W).
    shadows: unknown cells off the outlines that are no furniture, shape (H, W): not seen, or inside a stub of a wall.
    """

    rooms: LabelImage
    at_outline: Mask
    pieces: LabelImage
    spray: Mask
    shadows: Mask


def find_furniture(grid: GridMap, floor: Floor, *, probability: Probabilities | None = None) -> tuple[Furniture, ...]:
    """The furniture in the rooms of a floor, each piece as the polygon of its cells, metres of the map frame.

    Pieces are connected groups of cells that are not free; see sort_contents. probability: of furniture for each cell
    of the grid, shape (H, W), from a model; then a piece has the mean of its cells, else None. From the top left.

    Raises OptionError for probabilities of another shape.
    """
    contents = sort_contents(grid, floor, probability=probability)
    outlines, numbers = outline_labels(_join_diagonals(contents.pieces))
    outlines = shapely.simplify(outlines, SMOOTHING_CELLS)

    def to_map(xy: Floats) -> Floats:
        return np.column_stack(grid.pixel_to_map(xy[:, 1], xy[:, 0]))

    in_map = shapely.transform(outlines, to_map)
    means: list[float | None] = [None] * len(numbers)
    if probability is not None:
        cells = contents.pieces > 0
        members = contents.pieces[cells]
        sums, counts = np.bincount(members, probability[cells]), np.bincount(members)
        means = (sums[numbers] / counts[numbers]).clip(0, 1).tolist()
    return tuple(Furniture(outline, mean) for outline, mean in zip(in_map, means, strict=True))


def sort_contents(grid: GridMap, floor: Floor, *, probability: Probabilities | None = None) -> RoomContents:
    """Sort the cells in rooms that are not free into furniture, spray, shadows, and the walls that remain.

    A group of cells is furniture if it does not touch the outline of its room, or is too thick for a stub of a wall.
    Thin pieces on the line of a wall are walls. With probabilities, of shape (H, W), cells above 0.5 are furniture too,
    and groups with a mean below 0.1 are left out.
    """
    if probability is not None and probability.shape != grid.shape:
        raise OptionError(f"probability has shape {probability.shape}, give {grid.shape}, that of the map")
    rooms = _add_islands(floor.label_image(grid).astype(np.int32), MAX_ISLAND_AREA / grid.resolution**2)
    solid = ~grid.free & (rooms > 0)
    depth = _distance_to_outlines(rooms) * grid.resolution - OUTLINE_TOLERANCE
    chosen = _choose_by_rules(solid, depth, floor, grid)
    if probability is not None:
        members = _label_groups(chosen)[0][chosen]
        is_likely = np.bincount(members, probability[chosen]) >= MIN_MEAN_PROBABILITY * np.bincount(members)
        chosen[chosen] = is_likely[members]
        chosen |= solid & (probability > PROBABILITY)
    chosen &= ~_find_specks(chosen, chosen, grid.resolution)
    spray = _find_specks(~grid.free, solid, grid.resolution)
    shadows = solid & grid.unknown & (depth > 0) & ~chosen & ~spray
    return RoomContents(rooms, (rooms > 0) & (depth <= 0), _label_groups(chosen)[0], spray, shadows)


def _choose_by_rules(solid: Mask, depth: NDArray[np.float32], floor: Floor, grid: GridMap) -> Mask:
    """Cells of furniture and of specks, shape (H, W). depth: how far each cell is off the outline of its room, m."""
    inner = solid & (depth > 0)
    groups, count = _label_groups(inner)
    thickness = 2 * highest_of_labels(_distance_to_other(inner)[inner] - 0.5, groups[inner], count) * grid.resolution
    # Groups that go on up to the outline stand at a wall, or are its stubs
    beside = cv2.dilate((solid & ~inner).astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    at_wall = np.zeros(count + 1, bool)
    at_wall[groups[beside & inner]] = True
    is_stub = (thickness < MIN_STUBLESS_THICKNESS) & (
        highest_of_labels(depth[inner], groups[inner], count) > MAX_STUB_RATIO * thickness
    )
    # What is unknown alone is a shadow, or a gap between two beams
    is_seen = np.bincount(groups[grid.occupied], minlength=count + 1) >= MIN_CELLS
    is_wall = (thickness < MIN_STUBLESS_THICKNESS) & _lie_on_walls(groups, count, floor, grid)
    furniture = is_seen & np.where(at_wall, (thickness >= MIN_THICKNESS) & ~is_stub, ~is_wall)
    chosen = np.zeros_like(inner)
    chosen[inner] = furniture[groups[inner]]
    return chosen


def _lie_on_walls(groups: LabelImage, count: int, floor: Floor, grid: GridMap) -> Mask:
    """Whether each group, by its number from 0 to count, is long and lies on lines of walls; shape (count + 1,)."""
    if not floor.walls:
        return np.zeros(count + 1, bool)
    inside = groups > 0
    rows, cols = np.nonzero(inside)
    members = groups[inside]
    first, last = (
        [highest_of_labels(sign * at, members, count, lowest=-np.inf) for at in (rows, cols)] for sign in (-1, 1)
    )
    spans = np.add(first, last) + 1
    on_lines = _draw_lines(floor.walls, grid, thickness=2 * WALL_LINE_DISTANCE)
    counts = np.bincount(members, minlength=count + 1)
    on_line_counts = np.bincount(members[on_lines[inside]], minlength=count + 1)
    sizes = np.hypot(*spans) * grid.resolution
    return np.asarray((sizes >= WALL_LENGTH) & (on_line_counts >= WALL_LINE_SHARE * counts))


def _draw_lines(lines: tuple[LineString, ...], grid: GridMap, *, thickness: float) -> Mask:
    """The cells on straight lines, in metres of the map frame, of a thickness in metres; shape (H, W)."""
    image = np.zeros(grid.shape, np.uint8)
    width = max(1, round(thickness / grid.resolution))
    for line in lines:
        rows, cols = grid.map_to_pixel(*shapely.get_coordinates(line).T)
        corners = np.round(np.column_stack([cols, rows]) - 0.5).astype(np.int32)
        cv2.polylines(image, [corners], isClosed=False, color=1, thickness=width)
    return image.astype(bool)


def _add_islands(rooms: LabelImage, max_cells: float) -> LabelImage:
    """Label image of rooms, shape (H, W), where groups of up to max_cells other cells inside one room belong to it."""
    outside = np.pad(rooms == 0, 1, constant_values=True).astype(np.uint8)
    _, numbers, stats, _ = cv2.connectedComponentsWithStats(outside, connectivity=4)
    groups = np.asarray(numbers[1:-1, 1:-1], np.int32)
    # A group belongs to the room on all its sides; to none if there are two
    pairs = []
    for one, other in ((np.s_[:-1], np.s_[1:]), (np.s_[1:], np.s_[:-1])):
        for group, room in ((groups[one], rooms[other]), (groups[:, one], rooms[:, other])):
            meets = (group > 0) & (room > 0)
            pairs.append(np.column_stack([group[meets], room[meets]]))
    group, room = np.concatenate(pairs).T
    most = highest_of_labels(room, group, len(stats) - 1).astype(np.int32)
    least = -highest_of_labels(-room, group, len(stats) - 1, lowest=-np.inf)
    is_island = (least == most) & (stats[:, cv2.CC_STAT_AREA] <= max_cells)
    # The first group is that of the frame around the map
    is_island[[0, 1]] = False
    islands = is_island[groups]
    with_islands = rooms.copy()
    with_islands[islands] = most[groups[islands]]
    return with_islands


def _distance_to_outlines(rooms: LabelImage) -> NDArray[np.float32]:
    """Distance of each cell's centre from the nearest side of a cell of another room or of none, in cells; (H, W)."""
    padded = np.pad(rooms, 1)
    same = rooms > 0
    for shifted in (padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]):
        same &= shifted == rooms
    # The cells at the outline, which are not the same, have their centres half a cell from it
    return _distance_to_other(same) + np.float32(0.5)


def _distance_to_other(mask: Mask) -> NDArray[np.float32]:
    """Distance of each cell of a mask from the nearest cell outside it or the map, in cells; shape (H, W)."""
    padded = np.pad(mask, 1).astype(np.uint8)
    return np.asarray(cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_5)[1:-1, 1:-1])


def _find_specks(cells: Mask, wanted: Mask, resolution: float) -> Mask:
    """Those of the wanted cells, a part of the cells, whose group is too small for furniture; shape (H, W)."""
    _, groups, stats, _ = cv2.connectedComponentsWithStats(cells.astype(np.uint8), connectivity=8)
    counts = stats[:, cv2.CC_STAT_AREA]
    # Rounded, since 2 · 0.05² is not 0.005 in binary
    small = (counts < MIN_CELLS) | (np.round(counts * resolution**2, 9) < MIN_AREA)
    specks = np.zeros_like(cells)
    specks[wanted] = small[groups[wanted]]
    return specks


def _label_groups(cells: Mask) -> tuple[LabelImage, int]:
    """Numbers from 1 of the groups of cells that touch by sides or corners, shape (H, W); and how many there are."""
    count, groups = cv2.connectedComponents(cells.astype(np.uint8), connectivity=8)
    return np.asarray(groups, np.int32), count - 1


def _join_diagonals(groups: LabelImage) -> LabelImage:
    """Label image where cells of one group that touch by a corner alone are joined by a cell beside both."""
    joined = groups.copy()
    for step in (1, -1):
        flipped, source = joined[:, ::step], groups[:, ::step]
        corner, opposite = source[:-1, :-1], source[1:, 1:]
        meets = (corner > 0) & (corner == opposite) & (source[:-1, 1:] == 0) & (source[1:, :-1] == 0)
        flipped[:-1, 1:][meets] = corner[meets]
    return joined
