"""Rooms by wall lines and narrow passages together: what the thesis asks for in chapter 9."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString

from pianta._types import Floats, Mask
from pianta.errors import MapError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.layout._canvas import Canvas, draw_canvas
from pianta.layout._numbering import assemble_floor
from pianta.layout._outlines import join_outlines, largest_part, outline_labels
from pianta.layout._voronoi_doors import compute_clearance
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.clutter import remove_clutter
from pianta.layout.structure.frontiers import drop_spray, find_frontiers, measure_frontiers
from pianta.layout.structure.merging import MergeModel, absorb_small_rooms, merge_pieces, read_default_merge_model
from pianta.layout.structure.narrow_passages import choose_narrow_doors, find_narrow_passages
from pianta.layout.structure.necks import Clearance, find_necks
from pianta.layout.structure.notches import fill_notches
from pianta.layout.structure.passages import list_passages
from pianta.layout.structure.pieces import Borders, Labels, Pieces, cut_into_pieces, find_borders
from pianta.layout.structure.splitting import split_rooms
from pianta.layout.structure.wall_lines import WallLines, find_wall_lines, span_walls


@dataclass(frozen=True, eq=False)
class Cut:
    """The free space of a map, cut wherever two rooms may meet.

    space: shape (H, W) of the canvas, where a robot may be, furniture removed. clearance: its distance transform, in
    cells.
    """

    canvas: Canvas
    space: Mask
    clearance: Clearance
    pieces: Pieces
    borders: Borders


def reconstruct_structure(grid: GridMap, *, parameters: StructureParameters, model: MergeModel | None = None) -> Floor:
    """Floor of a grid map: rooms that are cut at doors and follow the walls, and the doors; metres of the map frame.

    Rooms are numbered in reading order of the map image. Raises MapError when the map shows no room.
    """
    if grid.free.all():
        raise MapError("every cell of the map is free, so no wall bounds a room; check its thresholds and negate")
    # Cut the free space at every neck that may be a door
    cut = cut_space(grid, parameters)
    cell = cut.canvas.resolution
    # Merge what was cut without reason, and cut along lines of wall what has no neck
    lines = find_wall_lines(cut.space, resolution=cell)
    labels, passages = find_rooms(cut, lines, parameters, model or read_default_merge_model())
    # Rooms that end at unknown space are partial, and what is hardly more than its end is spray
    rays = measure_frontiers(labels, find_frontiers(grid, cut.canvas, cut.space), resolution=cell)
    seen = drop_spray(labels, rays, width=parameters.passage_width, resolution=cell)
    frontier = find_frontiers(grid, cut.canvas, cut.space, thinnest=parameters.unseen_width)
    unseen = measure_frontiers(labels, frontier, resolution=cell)
    # Give the rooms clean outlines that go on behind the furniture along their walls
    outlines, numbers = outline_rooms(seen, cut.canvas, parameters)
    if not len(numbers):
        raise MapError("the map shows no room, its free space is too small or too scattered; check the resolution")
    rooms = [
        Room(number, outline, partial=bool(unseen[number] >= parameters.frontier))
        for number, outline in zip(numbers.tolist(), outlines, strict=True)
    ]
    # The lines along which two rooms are still cut are the doors
    doors = find_doors(replace(cut, pieces=replace(cut.pieces, labels=labels)), passages, numbers.tolist(), parameters)
    walls = span_walls(lines, cut.space, reach=parameters.line_reach, gap=parameters.door_width, resolution=cell)
    return assemble_floor(rooms, doors, [_draw_wall(wall, cut.canvas) for wall in walls], grid)


def cut_space(grid: GridMap, parameters: StructureParameters) -> Cut:
    """The free space of a grid map, without furniture, cut at its necks."""
    free = remove_clutter(grid.free, size_px=parameters.clutter_size / grid.resolution)
    canvas = draw_canvas(grid, free, resolution=parameters.working_resolution)
    cell = canvas.resolution
    space = _drop_patches(canvas.free, parameters.patch_area / cell**2)
    clearance = compute_clearance(space)
    necks = find_necks(
        space,
        clearance,
        saddle_ratio=parameters.saddle_ratio,
        mouth_ratio=parameters.mouth_ratio,
        passage=parameters.passage_width / cell,
        merge_distance=parameters.neck_distance / cell,
    )
    pieces = cut_into_pieces(space, clearance, necks, least=parameters.passage_width / 2 / cell, resolution=cell)
    borders = find_borders(pieces, space, necks, reach=parameters.wall_reach)
    return Cut(canvas, space, clearance, pieces, borders)


def find_rooms(cut: Cut, lines: WallLines, parameters: StructureParameters, model: MergeModel) -> tuple[Labels, Floats]:
    """Rooms as a label image of the canvas, shape (H, W), and the lines that part them, shape (N, 2, 2), in cells."""
    cell = cut.canvas.resolution
    # Openness, walls in line, sizes and shapes say which necks are doors
    rooms, parting, odds = merge_pieces(cut.pieces, cut.borders, model)
    owner = absorb_small_rooms(rooms.owner, cut.pieces, cut.borders, parting, odds, parameters=parameters)
    labels = owner[cut.pieces.labels].astype(np.int32)
    # Lines of wall say where a room is open wider than a neck
    labels, openings = split_rooms(labels, cut.space, cut.clearance, lines, parameters=parameters, resolution=cell)
    return labels, np.concatenate([cut.borders.lines[parting], openings])


def find_doors(cut: Cut, passages: Floats, rooms: Sequence[int], parameters: StructureParameters) -> list[Door]:
    """Doors in the map frame: passages along which rooms are cut, and narrower gaps where nothing else leads.

    cut: with the rooms as its pieces. passages: shape (N, 2, 2), in cells. rooms: the labels that are rooms.
    """
    cell = cut.canvas.resolution
    list_doors = partial(list_passages, rooms=set(rooms), canvas=cut.canvas, door_width=parameters.door_width)
    borders = find_borders(cut.pieces, cut.space, passages, reach=0.0)
    doors = list_doors(borders, least=parameters.passage_width / 2)
    widest, joined = parameters.passage_width / cell + 1, {door.rooms for door in doors}
    gaps = find_narrow_passages(cut.pieces, cut.space, cut.clearance, widest=widest, joined=joined)
    narrow = list_doors(find_borders(cut.pieces, cut.space, gaps, reach=0.0), least=parameters.gap_width)
    return doors + choose_narrow_doors(doors, narrow, rooms)


def outline_rooms(
    labels: Labels, canvas: Canvas, parameters: StructureParameters
) -> tuple[NDArray[np.object_], NDArray[np.integer]]:
    """Outlines in the map frame of the labels of a canvas, shape (R,), and the labels."""
    outlines, numbers = outline_labels(labels)
    outlines = shapely.transform(outlines, lambda xy: xy * canvas.resolution)
    outlines = np.array([largest_part(shape) for shape in shapely.coverage_simplify(outlines, parameters.smoothing)])
    outlines = fill_notches(outlines, depth=parameters.notch_depth, width=parameters.notch_width)
    return np.array([canvas.to_map(outline) for outline in join_outlines(outlines)], dtype=object), numbers


def _draw_wall(wall: Floats, canvas: Canvas) -> LineString:
    """A line between two cells, shape (2, 2), in the map frame."""
    return LineString(canvas.to_map(LineString((wall[:, ::-1] + 0.5) * canvas.resolution)))


def _drop_patches(free: Mask, least: float) -> Mask:
    """Free cells, shape (H, W), without the groups of fewer than least cells."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] >= least
    large[0] = False
    return np.asarray(large[labels])
