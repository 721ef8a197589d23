"""Rooms by wall lines and narrow passages together: what the thesis asks for in chapter 9."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString

from pianta.errors import MapError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.layout.canvas import Canvas, Mask, draw_canvas
from pianta.layout.clutter import remove_clutter
from pianta.layout.doors import compute_clearance
from pianta.layout.frontiers import find_frontiers, measure_frontiers
from pianta.layout.merging import MODEL, merge_pieces
from pianta.layout.necks import find_necks
from pianta.layout.notches import fill_notches
from pianta.layout.numbering import assemble_floor
from pianta.layout.outlines import largest_part, outline_labels
from pianta.layout.parameters import StructureParameters
from pianta.layout.pieces import Borders, Indices, Labels, Pieces, cut_into_pieces, find_borders


@dataclass(frozen=True, eq=False)
class Cut:
    """The free space of a map, cut wherever two rooms may meet.

    space: shape (H, W) of the canvas, where a robot may be, furniture removed.
    """

    canvas: Canvas
    space: Mask
    pieces: Pieces
    borders: Borders


def reconstruct_structure(grid: GridMap, *, parameters: StructureParameters, source: str = "") -> Floor:
    """Floor of a grid map: rooms that are cut at doors and follow the walls, and the doors; metres of the map frame.

    Rooms are numbered in reading order of the map image. Raises MapError when the map shows no room.
    """
    # Cut the free space at every neck that may be a door
    cut = cut_space(grid, parameters)
    # Merge what was cut without reason: openness, walls in line, sizes and shapes decide
    rooms, parting, odds = merge_pieces(cut.pieces, cut.borders, MODEL)
    # Rooms too small to be one belong to the neighbour that they open to most
    owner = _absorb_small_rooms(rooms.owner, cut, parting, odds, parameters)
    labels = owner[cut.pieces.labels].astype(np.int32)
    frontier = find_frontiers(grid, cut.canvas, cut.space)
    # Give the rooms clean outlines that go on behind the furniture along their walls
    outlines, numbers = outline_rooms(labels, cut.canvas, parameters)
    if not len(numbers):
        raise MapError("the map shows no room, its free space is too small or too scattered; check the resolution")
    length = measure_frontiers(labels, frontier, resolution=cut.canvas.resolution)
    found = [
        Room(i, outline, partial=bool(length[number] >= parameters.frontier))
        for i, (outline, number) in enumerate(zip(outlines, numbers.tolist(), strict=True), start=1)
    ]
    id_of = {int(number): room.id for number, room in zip(numbers, found, strict=True)}
    # Doors are the borders that are left
    doors = _list_doors(owner, cut, id_of, parameters)
    return assemble_floor(found, doors, (), grid, source)


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
        passage=parameters.passage_width / cell,
        merge_distance=parameters.neck_distance / cell,
    )
    pieces = cut_into_pieces(space, clearance, necks, least=parameters.passage_width / 2 / cell, resolution=cell)
    return Cut(canvas, space, pieces, find_borders(pieces, space, necks, reach=parameters.wall_reach))


def outline_rooms(
    labels: Labels, canvas: Canvas, parameters: StructureParameters
) -> tuple[NDArray[np.object_], NDArray[np.integer]]:
    """Outlines in the map frame of the labels of a canvas, shape (R,), and the labels."""
    outlines, numbers = outline_labels(labels)
    outlines = shapely.transform(outlines, lambda xy: xy * canvas.resolution)
    outlines = np.array([largest_part(shape) for shape in shapely.coverage_simplify(outlines, parameters.smoothing)])
    outlines = fill_notches(outlines, depth=parameters.notch_depth, width=parameters.notch_width)
    return np.array([largest_part(canvas.to_map(outline)) for outline in outlines], dtype=object), numbers


def _drop_patches(free: Mask, least: float) -> Mask:
    """Free cells, shape (H, W), without the groups of fewer than least cells."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] >= least
    large[0] = False
    return np.asarray(large[labels])


def _absorb_small_rooms(
    owner: Indices, cut: Cut, parting: Indices, odds: NDArray[np.float64], parameters: StructureParameters
) -> Indices:
    """Room of each piece, where rooms below the least area belong to a neighbour; 0 where they have none."""
    owner = owner.copy()
    area = np.bincount(owner, weights=cut.pieces.area, minlength=len(owner))
    for border in parting[np.argsort(-odds, kind="stable")]:
        one, other = sorted(owner[cut.borders.sides[border]].tolist(), key=lambda room: area[room])
        if one != other and area[one] < parameters.room_area:
            owner[owner == one] = other
            area[other] += area[one]
    return np.where(area[owner] < parameters.room_area, 0, owner)


def _list_doors(owner: Indices, cut: Cut, id_of: dict[int, int], parameters: StructureParameters) -> list[Door]:
    """Doors where two rooms meet; what is more than twice as wide as the door in the middle of all is an opening."""
    cell = cut.canvas.resolution
    sides = owner[cut.borders.sides]
    chosen = [i for i, (one, other) in enumerate(sides.tolist()) if one != other and {one, other} <= id_of.keys()]
    widths = np.maximum(cut.borders.opening[chosen] - cell, 0)
    limit = min(2 * float(np.median(widths)), parameters.door_width) if chosen else parameters.door_width
    doors = []
    for border, width in zip(chosen, widths.tolist(), strict=True):
        ends = cut.borders.lines[border][:, ::-1] + 0.5
        # An obstacle ends half a cell before its centre.
        inward = (ends[::-1] - ends) / max(np.hypot(*(ends[1] - ends[0])), 1e-9) / 2
        line = LineString(cut.canvas.to_map(LineString((ends + inward) * cell)))
        one, other = (id_of[number] for number in sides[border].tolist())
        kind: Literal["door", "opening"] = "door" if width <= limit else "opening"
        doors.append(Door((one, other), line, width, kind))
    return doors
