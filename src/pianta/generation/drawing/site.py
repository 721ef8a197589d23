"""A site: the outline inside which a building is drawn."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, ceil, degrees
from typing import NamedTuple

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon
from shapely.affinity import rotate, translate

from pianta.errors import ModelError, OptionError
from pianta.floor import Floor, move_floor
from pianta.generation.drawing.blocks import CELL, NO_ROOM, Cells
from pianta.generation.drawing.gaps import GROWTH
from pianta.generation.type_model import TypeModel

Mask = NDArray[np.bool_]

OUTSIDE = -2  # of cells that are neither in a room nor free
FRAME_CELLS = 2  # around a site
LARGEST_SIDE = 1000.0  # m, of a site
FILLED = 0.8  # of a site, at most, by the rooms before they grow; chosen by hand
SHRINKAGE = 0.85  # of the areas of rooms of which no layout fits
LEAST_SCALE = 0.5  # of the areas of rooms that are made to fit; chosen by hand
LEAST_SHARE = 0.7  # of the most rooms that fit, in the smallest building for an outline; chosen by hand
LEAST_PART = 0.6  # of a room that must be inside; chosen by hand


class Position(NamedTuple):
    """Where cells are on a site: after quarter turns, the row and column of their first cell.

    outside: how many cells of rooms are not on the site.
    """

    turns: int
    row: int
    column: int
    outside: float


@dataclass(frozen=True, eq=False)
class Site:
    """An outline as cells.

    mask: the cells inside, with a frame of cells outside. angle: degrees by which the cells are turned to lie on the
    outline. x, y: corner of the first cell before that, m.
    """

    mask: Mask
    angle: float
    x: float
    y: float

    @property
    def area(self) -> int:
        """Cells."""
        return int(self.mask.sum())

    def find_position(self, cells: Cells, *, pool: int = 1) -> Position:
        """Where most cells of rooms are on the site. pool: side of the blocks of cells that are compared, for speed."""
        site, positions = _shrink(self.mask, pool), []
        for turns in range(4):
            building = _shrink(np.rot90(cells != NO_ROOM, turns), pool)
            height, width = building.shape
            padded = np.pad(site, ((height, height), (width, width)))
            overlap = cv2.matchTemplate(padded, building, cv2.TM_CCORR)
            row, column = map(int, np.unravel_index(int(np.argmax(overlap)), overlap.shape))
            # Not from the overlap, which OpenCV may round
            is_free = 1.0 - padded[row : row + height, column : column + width]
            outside = float((building * is_free).sum()) * pool**2
            positions.append(Position(turns, (row - height) * pool, (column - width) * pool, outside))
        return min(positions, key=lambda position: position.outside)

    def put(self, cells: Cells) -> Cells | None:
        """The cells on the site, OUTSIDE around it, without what is not on it; None if that is too much of a room."""
        position = self.find_position(cells)
        turned = np.rot90(cells, position.turns)
        # Margins around the building as large as the site, which may reach into each
        rows, columns = self.mask.shape
        sheet = np.pad(turned, ((rows, rows), (columns, columns)), constant_values=NO_ROOM)
        window = sheet[rows - position.row :, columns - position.column :][:rows, :columns]
        on_site = np.where(self.mask, window, OUTSIDE).astype(np.int32)
        before, after = (np.bincount(each[each >= 0], minlength=cells.max() + 1) for each in (cells, on_site))
        if (after < LEAST_PART * before).any() or not all(map(_is_whole, _list_rooms(on_site, before - after))):
            return None
        return on_site

    def move(self, floor: Floor) -> Floor:
        """A floor of cells of the site, in the frame of the outline."""
        return move_floor(floor, lambda shape: rotate(translate(shape, self.x, self.y), self.angle, origin=(0, 0)))


def choose_rooms(outline: Polygon, model: TypeModel) -> tuple[int, int]:
    """The numbers of rooms of buildings of a type for which an outline has space, fewest and most.

    Raises ModelError for a model without areas, and OptionError for an outline that is too small for the type.
    """
    floors = [dict(floor.graph.nodes(data="area")) for floor in model.floors]
    areas = [[area for area in floor.values() if area is not None] for floor in floors]
    if not any(areas):
        raise ModelError("the model has no areas of rooms, train it on floors with outlines")
    needed = GROWTH * sum(map(sum, areas)) / sum(map(len, areas))
    smallest, largest = min(map(len, floors)), max(map(len, floors))
    most = int(outline.area / needed)
    if most < smallest:
        fault = f"outline has {outline.area:.0f} m², in which {most} rooms of the type fit, and its smallest floor has"
        raise OptionError(f"{fault} {smallest}; give a larger outline, in metres, or numbers of rooms")
    return max(smallest, min(round(LEAST_SHARE * most), largest)), min(most, largest)


def make_site(outline: Polygon) -> Site:
    """The site of an outline, m. Raises OptionError for one that is too large, or no polygon."""
    if outline.is_empty or not outline.is_valid:
        raise OptionError("outline is no valid polygon, give its corners in order")
    corners = np.array(outline.minimum_rotated_rectangle.exterior.coords)
    sides = np.diff(corners[:3], axis=0)
    along = sides[int(np.argmax(np.hypot(*sides.T)))]
    angle = degrees(atan2(along[1], along[0]))
    level = rotate(outline, -angle, origin=(0, 0))
    x, y, right, top = level.bounds
    if max(right - x, top - y) > LARGEST_SIDE:
        raise OptionError(f"outline is {max(right - x, top - y):.0f} m long, at most {LARGEST_SIDE:g}; give metres")
    rows, columns = ceil((top - y) / CELL) + 1, ceil((right - x) / CELL) + 1
    across, up = np.meshgrid(x + np.arange(columns) * CELL, y + np.arange(rows) * CELL)
    inside = shapely.contains_xy(level.buffer(CELL / 100), across, up)
    covered = inside[:-1, :-1] & inside[:-1, 1:] & inside[1:, :-1] & inside[1:, 1:]
    margin = FRAME_CELLS * CELL
    return Site(np.pad(covered, FRAME_CELLS), angle, x - margin, y - margin)


def list_scales(needed: float, site: Site) -> list[float]:
    """By how much areas of rooms are scaled to fit on a site, in the order in which that is tried; at most 1.

    needed: cells of all rooms. Raises OptionError if they would become too small.
    """
    scale, scales = min(1.0, FILLED * site.area / needed), []
    while scale >= LEAST_SCALE:
        scales.append(scale)
        scale *= SHRINKAGE
    if not scales:
        least = needed * CELL**2 * LEAST_SCALE / FILLED
        fault = f"outline has {site.area * CELL**2:.0f} m², and the rooms need {least:.0f} m²"
        raise OptionError(f"{fault}; give a larger outline, in metres, or fewer rooms")
    return scales


def _shrink(mask: Mask, pool: int) -> NDArray[np.float32]:
    """The mean of blocks of cells."""
    pixels = np.ascontiguousarray(mask, np.float32)
    if pool == 1:
        return pixels
    rows, columns = (size // pool for size in mask.shape)
    return np.asarray(cv2.resize(pixels, (columns, rows), interpolation=cv2.INTER_AREA), np.float32)


def _list_rooms(cells: Cells, lost: NDArray[np.int64]) -> list[Mask]:
    """The rooms of which cells were lost."""
    return [cells == room for room in np.flatnonzero(lost)]


def _is_whole(room: Mask) -> bool:
    """Whether a room is one part."""
    return int(cv2.connectedComponents(room.astype(np.uint8), connectivity=4)[0]) == 2
