"""The method `structure`: rooms by narrow passages and wall lines together, as chapter 9 of the thesis proposes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
import shapely
from shapely import LineString

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.errors import MapError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.layout._label_images import Polygons, join_outlines, largest_part, outline_labels
from pianta.layout._numbering import assemble_floor
from pianta.layout._voronoi_doors import compute_clearance
from pianta.layout._working_grid import NO_ROOM, WorkingGrid, check_shows_rooms, remove_clutter, to_working_grid
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.frontiers import find_frontiers, measure_frontiers, remove_ray_leaks
from pianta.layout.structure.merging import MergeModel, absorb_small_rooms, merge_regions, read_default_merge_model
from pianta.layout.structure.narrow_passages import choose_narrow_doors, find_narrow_passages
from pianta.layout.structure.necks import Clearance, find_necks
from pianta.layout.structure.notches import fill_notches
from pianta.layout.structure.passages import list_passages
from pianta.layout.structure.regions import Regions, Separators, cut_into_regions, find_separators
from pianta.layout.structure.splitting import split_rooms
from pianta.layout.structure.wall_lines import WallLines, find_wall_lines, span_walls


@dataclass(frozen=True, eq=False)
class Oversegmentation:
    """The free space of a map, cut at every point where two rooms may meet.

    space: shape (H, W) of the working grid, the free cells without furniture. clearance: its distance transform, in
    cells.
    """

    working_grid: WorkingGrid
    space: Mask
    clearance: Clearance
    regions: Regions
    separators: Separators


def reconstruct_structure(grid: GridMap, *, parameters: StructureParameters, model: MergeModel | None = None) -> Floor:
    """Floor of a grid map: rooms that are cut at doors and follow the walls, and the doors; metres of the map frame.

    Rooms are numbered in reading order of the map image. Raises MapError when the map shows no room.
    """
    check_shows_rooms(grid)
    # Cut the free space at every neck that may be a door
    cut = oversegment(grid, parameters)
    cell = cut.working_grid.resolution
    # Merge regions without a door between them, and split rooms along wall lines where there is no neck
    lines = find_wall_lines(cut.space, resolution=cell)
    labels, passages = merge_and_split_regions(cut, lines, parameters, model or read_default_merge_model())
    # Rooms that end at unknown space are partial, and those with little area for their frontier are ray leaks
    leak_frontier = find_frontiers(grid, cut.working_grid, cut.space)
    frontier_lengths = measure_frontiers(labels, leak_frontier, resolution=cell)
    room_labels = remove_ray_leaks(labels, frontier_lengths, width=parameters.passage_width, resolution=cell)
    frontier = find_frontiers(grid, cut.working_grid, cut.space, min_thickness=parameters.unseen_width)
    unseen = measure_frontiers(labels, frontier, resolution=cell)
    # Give the rooms clean outlines that continue behind the furniture along their walls
    outlines, numbers = outline_rooms(room_labels, cut.working_grid, parameters)
    if not len(numbers):
        raise MapError(NO_ROOM)
    rooms = [
        Room(number, outline, partial=bool(unseen[number] >= parameters.frontier))
        for number, outline in zip(numbers.tolist(), outlines, strict=True)
    ]
    # The lines that still separate two rooms are the doors
    by_room = replace(cut, regions=replace(cut.regions, labels=labels))
    doors = find_doors(by_room, passages, numbers.tolist(), parameters)
    walls = span_walls(lines, cut.space, reach=parameters.line_reach, gap=parameters.door_width, resolution=cell)
    return assemble_floor(rooms, doors, [_wall_to_map(wall, cut.working_grid) for wall in walls], grid)


def oversegment(grid: GridMap, parameters: StructureParameters) -> Oversegmentation:
    """The free space of a grid map, without furniture, cut at its necks."""
    free = remove_clutter(grid.free, size_px=parameters.clutter_size / grid.resolution)
    working_grid = to_working_grid(grid, free, resolution=parameters.working_resolution)
    cell = working_grid.resolution
    space = _drop_patches(working_grid.free, parameters.patch_area / cell**2)
    clearance = compute_clearance(space)
    necks = find_necks(
        space,
        clearance,
        saddle_ratio=parameters.saddle_ratio,
        mouth_ratio=parameters.mouth_ratio,
        passage_width=parameters.passage_width / cell,
        merge_distance=parameters.neck_distance / cell,
    )
    min_clearance = parameters.passage_width / 2 / cell
    regions = cut_into_regions(space, clearance, necks, min_clearance=min_clearance, resolution=cell)
    separators = find_separators(regions, space, necks, reach=parameters.wall_reach)
    return Oversegmentation(working_grid, space, clearance, regions, separators)


def merge_and_split_regions(
    cut: Oversegmentation, lines: WallLines, parameters: StructureParameters, model: MergeModel
) -> tuple[LabelImage, Floats]:
    """Merge regions into rooms by the model, then split rooms along wall lines.

    Returns the label image of the rooms on the working grid, shape (H, W), 0 no room; and the doors and openings
    between them as straight lines, shape (N, 2, 2): end, then row and col, in cells.
    """
    cell = cut.working_grid.resolution
    # Openness, walls in line, sizes and shapes decide which necks are doors
    rooms, active, log_odds = merge_regions(cut.regions, cut.separators, model)
    owner = absorb_small_rooms(rooms.owner, cut.regions, cut.separators, active, log_odds, parameters=parameters)
    labels = owner[cut.regions.labels].astype(np.int32)
    # Wall lines decide where a room is open wider than a neck
    labels, openings = split_rooms(labels, cut.space, cut.clearance, lines, parameters=parameters, resolution=cell)
    return labels, np.concatenate([cut.separators.lines[active], openings])


def find_doors(
    cut: Oversegmentation, passages: Floats, rooms: Sequence[int], parameters: StructureParameters
) -> list[Door]:
    """Doors in the map frame: passages between rooms, and narrower gaps where no passage leads to a room.

    cut: with the rooms as its regions. passages: shape (N, 2, 2), in cells. rooms: the labels that are rooms.
    """
    cell = cut.working_grid.resolution
    list_doors = partial(
        list_passages, rooms=set(rooms), working_grid=cut.working_grid, door_width=parameters.door_width
    )
    separators = find_separators(cut.regions, cut.space, passages, reach=0.0)
    doors = list_doors(separators, min_width=parameters.passage_width / 2)
    max_width, joined = parameters.passage_width / cell + 1, {door.rooms for door in doors}
    gaps = find_narrow_passages(cut.regions, cut.space, cut.clearance, max_width=max_width, joined=joined)
    narrow = list_doors(find_separators(cut.regions, cut.space, gaps, reach=0.0), min_width=parameters.gap_width)
    return doors + choose_narrow_doors(doors, narrow, rooms)


def outline_rooms(
    labels: LabelImage, working_grid: WorkingGrid, parameters: StructureParameters
) -> tuple[Polygons, Indices]:
    """Outlines of rooms, shape (R,), in metres of the map frame; and the label of each room, shape (R,).

    labels: label image on the working grid, shape (H, W), 0 no room.
    """
    outlines, numbers = outline_labels(labels)
    outlines = shapely.transform(outlines, lambda xy: xy * working_grid.resolution)
    outlines = np.array([largest_part(shape) for shape in shapely.coverage_simplify(outlines, parameters.smoothing)])
    outlines = fill_notches(outlines, depth=parameters.notch_depth, width=parameters.notch_width)
    in_map = np.array([working_grid.to_map(outline) for outline in join_outlines(outlines)], dtype=object)
    return in_map, numbers.astype(np.intp)


def _wall_to_map(wall: Floats, working_grid: WorkingGrid) -> LineString:
    """A line between two cells, shape (2, 2), in the map frame."""
    return LineString(working_grid.to_map(LineString((wall[:, ::-1] + 0.5) * working_grid.resolution)))


def _drop_patches(free: Mask, min_cells: float) -> Mask:
    """Free cells, shape (H, W), without connected groups of fewer than min_cells."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] >= min_cells
    large[0] = False
    return np.asarray(large[labels])
