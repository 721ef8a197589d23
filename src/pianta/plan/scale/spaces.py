"""The floors of rooms between their walls, in pixels of the sheet, and the texts that stand on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from pianta.floor import Floor
from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.walls.segmentation import DOOR, WALL, ClassMap


@dataclass(frozen=True, kw_only=True)
class SpaceParameters:
    """Thresholds of `measure_spaces`; cells are those of the class map, eight a door."""

    barrier: float = 0.4  # probability of wall and door together from which on a cell is no floor
    # The network draws walls wider than they are: by 1.2 to 2.1 cells on each face, in nine rooms of four plans
    wall_excess: float = 1.8  # cells
    full_side: float = 0.3  # of the longest line of cells: shorter ones are niches and passages, and no side of a room


PARAMETERS = SpaceParameters()


@dataclass(frozen=True, eq=False)
class Space:
    """The floor of a room without its walls, and the texts that stand in the room.

    area: square pixels of the sheet. width, height: pixels, along columns and rows.
    """

    area: float
    width: float
    height: float
    texts: tuple[PlacedText, ...]


def measure_spaces(
    floors: Sequence[Floor], class_map: ClassMap, texts: Sequence[PlacedText], *, height: int
) -> list[Space]:
    """The floor of each room, which itself reaches to the middle of its walls.

    floors: in pixels of the sheet, y up. height: of the sheet, pixels.
    """
    probabilities, cell = class_map.probabilities, class_map.cell_px
    free = probabilities[WALL] + probabilities[DOOR] < PARAMETERS.barrier
    rooms = [room.polygon for floor in floors for room in floor.rooms]
    if not rooms:
        return []
    positions = np.array([(text.middle[1], height - text.middle[0]) for text in texts]).reshape(-1, 2)
    owners, owned = shapely.STRtree(shapely.points(positions)).query(rooms, predicate="contains")
    spaces = []
    for number, room in enumerate(rooms):
        cells = _cells_of(room, height / cell, cell, free.shape) & free
        area, width, side = _measure_cells(cells)
        inside = tuple(texts[index] for index in sorted(owned[owners == number]))
        spaces.append(Space(area * cell**2, width * cell, side * cell, inside))
    return [space for space in spaces if space.area > 0]


def _cells_of(room: shapely.Polygon, height: float, cell: float, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """The cells of a room, shape (H, W), without its holes. height: of the sheet, cells."""
    mask = np.zeros(shape, np.uint8)
    for ring, value in ((room.exterior, 1), *((hole, 0) for hole in room.interiors)):
        x, y = np.asarray(ring.coords).T[:2] / cell
        cv2.fillPoly(mask, [np.rint(np.column_stack([x, height - y]) - 0.5).astype(np.int32)], value)
    return mask.astype(bool)


def _measure_cells(cells: NDArray[np.bool_]) -> tuple[float, float, float]:
    """The area, width and height of the floor on some cells, with what the network takes for wall around it; cells."""
    if not cells.any():
        return 0.0, 0.0, 0.0
    width, height = (
        float((along >= PARAMETERS.full_side * along.max()).sum()) for along in (cells.sum(axis=0), cells.sum(axis=1))
    )
    excess = 2 * PARAMETERS.wall_excess
    grown = (width + excess) * (height + excess) / (width * height)
    return float(cells.sum()) * grown, width + excess, height + excess
