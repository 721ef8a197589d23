"""The method `structure`: rooms by a network's evidence, narrow passages and one decision for the whole floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
import shapely
from shapely import LineString, Polygon

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.errors import MapError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout._despeckle import despeckle
from pianta.layout._label_images import Polygons, join_outlines, largest_part, list_contacts, outline_labels
from pianta.layout._numbering import assemble_floor
from pianta.layout._working_grid import NO_ROOM, WorkingGrid, check_shows_rooms, to_working_grid
from pianta.layout.furniture import find_furniture
from pianta.layout.multicut import solve_multicut
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.borders import draw_borders, list_stretches, straighten_borders
from pianta.layout.structure.confidence import rate_regions
from pianta.layout.structure.evidence import (
    CELL,
    DOOR,
    FURNITURE,
    OUTSIDE,
    Evidence,
    evaluate_map,
    sample_class,
)
from pianta.layout.structure.frontiers import (
    find_frontiers,
    find_partial_labels,
    measure_frontiers,
    remove_ray_leaks,
)
from pianta.layout.structure.narrow_passages import choose_narrow_doors, find_narrow_passages, find_wall_gaps
from pianta.layout.structure.necks import Clearance
from pianta.layout.structure.notches import fill_notches
from pianta.layout.structure.passages import list_passages
from pianta.layout.structure.pieces import Pieces, compute_pair_weights, cut_into_pieces
from pianta.layout.structure.possible_doors import THRESHOLDS, Thresholds, find_possible_doors
from pianta.layout.structure.regions import describe_regions, find_separators, sample_image
from pianta.layout.structure.space import find_floor_space
from pianta.layout.structure.unlikely_rooms import (
    absorb_thin_rooms,
    drop_enclosed_spots,
    drop_unseen_rooms,
    find_boxes,
)
from pianta.layout.structure.wall_lines import find_wall_lines, span_walls

# Positions along a border where it is looked up whether its cells were seen, ...
LINE_SAMPLES = np.linspace(0.1, 0.9, 17)
# ... and least share of them that were, for a door (chosen by hand).
MIN_SEEN_LINE_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class Division:
    """The floor of a map, divided into rooms; lengths are in cells of the working grid, shape (H, W).

    occupied: cells with an obstacle that is no noise. space: the cells of the floor. observed: those that are free or
    under small furniture.
    labels: n > 0 for room n, 0 no room. borders: lines on which two rooms meet, shape (N, 2, 2), end, then row and col.
    """

    working_grid: WorkingGrid
    evidence: Evidence
    occupied: Mask
    space: Mask
    observed: Mask
    pieces: Pieces
    labels: LabelImage
    borders: Floats


def reconstruct_structure(grid: GridMap, *, parameters: StructureParameters) -> Floor:
    """Floor of a grid map: rooms that are cut at doors and follow the walls, and the doors; metres of the map frame.

    Rooms are numbered in reading order of the map image. Raises MapError when the map shows no room.
    """
    check_shows_rooms(grid)
    division = divide_floor(grid, parameters)
    rooms, doors = list_regions(division, parameters)
    rooms, doors = rate_regions(rooms, doors, division.labels, division.working_grid, division.evidence)
    working_grid, cell = division.working_grid, division.working_grid.resolution
    lines = find_wall_lines(division.space, resolution=cell)
    walls = span_walls(lines, division.space, reach=parameters.line_reach, gap=parameters.door_width, resolution=cell)
    walls_in_map = [_wall_to_map(wall, working_grid) for wall in walls]
    shut = list_possible_doors(division, [room.id for room in rooms], doors)
    floor = assemble_floor(rooms, doors, walls_in_map, grid, possible_doors=shut)
    # What stands in the rooms, by rules and by what the network sees
    probability = sample_class(division.evidence, working_grid, FURNITURE)
    furniture = find_furniture(grid, floor, probability=probability)
    # The mean of the network's coarse cells is much lower than the share of pieces that are furniture
    return replace(floor, furniture=tuple(replace(piece, probability=None) for piece in furniture))


def list_regions(division: Division, parameters: StructureParameters) -> tuple[list[Room], list[Door]]:
    """The rooms and doors of a division, in the map frame; the id of a room is its label.

    Raises MapError if there is no room.
    """
    working_grid, labels, cell = division.working_grid, division.labels, division.working_grid.resolution
    # Rooms that end at unknown space are partial, and those with little area for their frontier are ray leaks
    leak_frontier = find_frontiers(working_grid.grid, working_grid, division.observed)
    frontier_lengths = measure_frontiers(labels, leak_frontier, resolution=cell)
    room_labels = remove_ray_leaks(labels, frontier_lengths, width=parameters.passage_width, resolution=cell)
    frontier = find_frontiers(working_grid.grid, working_grid, division.observed, min_thickness=parameters.unseen_width)
    unseen = measure_frontiers(labels, frontier, resolution=cell)
    is_partial = find_partial_labels(labels, unseen, min_length=parameters.frontier, resolution=cell)
    # Give the rooms clean outlines that continue behind the furniture along their walls
    outlines, numbers = outline_rooms(room_labels, working_grid, parameters)
    if not len(numbers):
        raise MapError(NO_ROOM)
    rooms = [
        Room(number, outline, partial=bool(is_partial[number]))
        for number, outline in zip(numbers.tolist(), outlines, strict=True)
    ]
    # The borders that two rooms share are the doors
    return rooms, find_doors(division, numbers.tolist(), parameters)


def divide_floor(grid: GridMap, parameters: StructureParameters) -> Division:
    """The floor of a map, divided into rooms."""
    from skimage.measure import label

    # Smaller cells than the network's would show no more of a map with cells of this size
    coarsest = max(CELL, parameters.working_resolution)
    working_grid = to_working_grid(grid, grid.free, resolution=parameters.working_resolution, coarsest=coarsest)
    cell = working_grid.resolution
    # Single cells that differ from all around them are noise
    working_grid, occupied = remove_noise(working_grid)
    # Tables and roped areas that the robot saw through are no rooms, and do not divide any
    boxes = find_boxes(working_grid.free, resolution=cell)
    working_grid = replace(working_grid, free=working_grid.free & ~boxes)
    # What each cell is, and which cells are in one room, as the network sees them
    evidence = evaluate_map(working_grid.free, occupied, resolution=cell)
    # The floor: free cells and furniture, without rays that left the building
    space, observed = find_floor_space(working_grid, occupied, evidence, parameters)
    # Cut it at every neck, and along the borders that the network sees
    pieces = cut_into_pieces(space, evidence, parameters, resolution=cell)
    # One decision for all pieces: the partition that agrees best with all pairs of cells
    pairs, weights, touching = compute_pair_weights(pieces.labels, evidence)
    parts = solve_multicut(int(pieces.labels.max(initial=0)) + 1, pairs, weights, touching)
    labels = np.where(pieces.labels > 0, parts[pieces.labels] + 1, 0).astype(np.int32)
    labels = absorb_small_rooms(labels, pieces.clearance, parameters, resolution=cell)
    labels = drop_unseen_rooms(labels, working_grid.free, evidence.enlarge(evidence.classes[OUTSIDE]), resolution=cell)
    # Two rooms meet on a straight line from jamb to jamb
    labels = straighten_borders(
        labels,
        space,
        pieces.clearance,
        pieces.necks,
        min_clearance=parameters.passage_width / 2 / cell,
        resolution=cell,
    )
    # A part that a straight border has cut off belongs to its neighbour, or is a room of its own
    parts = label(labels, connectivity=1).astype(np.int32)
    labels = absorb_small_rooms(parts, pieces.clearance, parameters, resolution=cell)
    labels = drop_enclosed_spots(labels, resolution=cell)
    labels = absorb_thin_rooms(labels, working_grid.free, occupied, resolution=cell)
    borders = draw_borders(list_stretches(labels), space, pieces.necks, cell)
    return Division(working_grid, evidence, occupied, space, observed, pieces, labels, borders.lines)


def remove_noise(working_grid: WorkingGrid) -> tuple[WorkingGrid, Mask]:
    """The working grid without noise of single cells, and its cells with an obstacle, shape (H, W)."""
    kinds = [working_grid.free, sample_obstacles(working_grid)]
    cells = despeckle(np.select(kinds, [FREE, OCCUPIED], UNKNOWN).astype(np.int8))
    return replace(working_grid, free=cells == FREE), cells == OCCUPIED


def sample_obstacles(working_grid: WorkingGrid) -> Mask:
    """Cells of the working grid that contain an obstacle of the map, shape (H, W)."""
    occupied = working_grid.grid.occupied
    joined = max(1, round(working_grid.resolution / working_grid.grid.resolution))
    if joined > 1:
        occupied = np.asarray(cv2.dilate(occupied.astype(np.uint8), np.ones((joined, joined), np.uint8)), bool)
    return np.asarray(working_grid.sample(occupied))


def absorb_small_rooms(
    labels: LabelImage, clearance: Clearance, parameters: StructureParameters, *, resolution: float
) -> LabelImage:
    """The label image where rooms that are too small or too narrow belong to a neighbour, or to none.

    It is the neighbour with the longest contact. clearance: of the floor, shape (H, W), in cells.
    """
    labels = labels.copy()
    regions = describe_regions(labels, clearance, resolution=resolution)
    area, width = regions.area.copy(), regions.width.copy()
    pairs, lengths = list_contacts(labels)
    owner = np.arange(len(area))
    for room in np.argsort(area, kind="stable").tolist():
        if room == 0 or (area[room] >= parameters.room_area and width[room] >= parameters.room_width):
            continue
        touching = (owner[pairs] == room).any(axis=1) & (owner[pairs[:, 0]] != owner[pairs[:, 1]])
        neighbour = 0
        if touching.any():
            one, other = owner[pairs[touching][lengths[touching].argmax()]]
            neighbour = int(other if one == room else one)
            area[neighbour] += area[room]
            width[neighbour] = max(width[neighbour], width[room])
        owner[owner == room] = neighbour
    return np.asarray(owner[labels], np.int32)


def find_doors(division: Division, rooms: Sequence[int], parameters: StructureParameters) -> list[Door]:
    """Doors in the map frame: borders between rooms, and narrower gaps where no border leads to a room.

    rooms: the labels that are rooms.
    """
    cell, space = division.working_grid.resolution, division.space
    list_doors = partial(
        list_passages, rooms=set(rooms), working_grid=division.working_grid, door_width=parameters.door_width
    )
    regions = describe_regions(division.labels, division.pieces.clearance, resolution=cell)
    separators = find_separators(regions, drop_unseen_lines(division.borders, division.observed))
    doors = list_doors(separators, min_width=parameters.passage_width / 2)
    # Where another way leads, the narrowest are holes in a noisy wall
    slim = find_wall_gaps(doors, max_width=parameters.passage_width)
    max_width, joined = parameters.passage_width / cell + 1, {door.rooms for door in doors}
    doors = [door for door in doors if door not in slim]
    gaps = find_narrow_passages(regions, space, division.pieces.clearance, max_width=max_width, joined=joined)
    narrow = list_doors(find_separators(regions, gaps), min_width=parameters.gap_width)
    return doors + choose_narrow_doors(doors, slim + narrow, rooms)


def list_possible_doors(
    division: Division, rooms: Sequence[int], doors: Sequence[Door], thresholds: Thresholds = THRESHOLDS
) -> list[Door]:
    """Doors in the map frame where the network sees one and nothing leads through: they may be shut.

    rooms: the labels that are rooms. doors: those of find_doors.
    """
    return find_possible_doors(
        division.evidence.enlarge(division.evidence.classes[DOOR]),
        np.where(np.isin(division.labels, rooms), division.labels, 0).astype(np.int32),
        division.occupied,
        doors,
        division.working_grid,
        thresholds=thresholds,
    )


def drop_unseen_lines(lines: Floats, observed: Mask) -> Floats:
    """The lines, shape (N, 2, 2), without those over cells that were not observed: there may be no way through."""
    positions = lines[:, :1] + LINE_SAMPLES[:, None] * (lines[:, 1:] - lines[:, :1])
    return np.asarray(lines[sample_image(observed, positions).mean(axis=1) >= MIN_SEEN_LINE_SHARE])


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
    outlines = np.array([_fill_holes(outline, parameters.room_area) for outline in outlines], dtype=object)
    in_map = np.array([working_grid.to_map(outline) for outline in join_outlines(outlines)], dtype=object)
    return in_map, numbers.astype(np.intp)


def _fill_holes(outline: Polygon, area: float) -> Polygon:
    """The outline without holes of less than an area, m²: pillars, in which there is space for no room."""
    return Polygon(outline.exterior, [hole for hole in outline.interiors if Polygon(hole).area >= area])


def _wall_to_map(wall: Floats, working_grid: WorkingGrid) -> LineString:
    """A line between two cells, shape (2, 2), in the map frame."""
    return LineString(working_grid.to_map(LineString((wall[:, ::-1] + 0.5) * working_grid.resolution)))
