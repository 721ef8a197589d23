"""The storeys of an IFC as floors, with a frame in which they can be drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from shapely import unary_union

from pianta.floor import Floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io.drawings.ifc import read_ifc_plan
from pianta.plan.scale import PlanScale

IFC_SUFFIX = ".ifc"
# Metres of a cell of the frame, of the margin around the rooms, and cells at most along the longer side.
CELL, MARGIN, MOST_CELLS = 0.05, 1.0, 8000


def read_storeys(path: str | Path) -> list[tuple[Floor, GridMap, PlanScale, str]]:
    """Each storey with rooms, from the lowest to the highest: its floor, a frame of unknown cells, scale and name.

    Warnings and errors as of read_ifc_plan.
    """
    framed = [(storey, _frame(storey.floor)) for storey in read_ifc_plan(path)]
    return [(storey.floor, frame, _scale(frame), storey.name) for storey, frame in framed]


def _scale(frame: GridMap) -> PlanScale:
    return PlanScale(frame.resolution, "the units of the file", 1.0)


def _frame(floor: Floor) -> GridMap:
    left, bottom, right, top = unary_union([room.polygon for room in floor.rooms]).bounds
    longest = max(right - left, top - bottom) + 2 * MARGIN
    cell = max(CELL, longest / MOST_CELLS)
    shape = tuple(int(np.ceil((side + 2 * MARGIN) / cell)) for side in (top - bottom, right - left))
    return GridMap(np.full(shape, UNKNOWN, np.int8), cell, (left - MARGIN, bottom - MARGIN, 0.0))
