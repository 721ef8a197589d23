"""The borders that the method `structure` considers, and what the decision about each rests on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, get_coordinates

from pianta._types import Floats
from pianta.gridmap import GridMap
from pianta.layout._working_grid import WorkingGrid, check_shows_rooms
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.borders import draw_borders, list_stretches
from pianta.layout.structure.evidence import CLASSES, DOOR, WALL, sample_class
from pianta.layout.structure.pieces import find_border_probability
from pianta.layout.structure.reconstruct import divide_floor
from pianta.layout.structure.regions import sample_image

# A line inside a room that is nearer to a border of it is the same border; metres (chosen by hand).
SAME_BORDER = 0.4
# Samples along a border, where its probability is looked up.
SAMPLES = 25


@dataclass(frozen=True, eq=False)
class ConsideredBorders:
    """Lines along which two rooms could meet.

    lines: shape (N, 2, 2), end, then x and y; metres of the map frame.
    probabilities: that each divides two rooms; None if a rule decided.
    reasons: what the decision about each rests on.
    evidence: probability that a cell is outside, floor, wall, door or furniture, shape (H, W, 5) of the map, or None.
    """

    lines: Floats
    probabilities: tuple[float | None, ...]
    reasons: tuple[str, ...]
    evidence: NDArray[np.float32] | None = None


def explain_structure(grid: GridMap, *, parameters: StructureParameters) -> ConsideredBorders:
    """The borders that reconstruct_structure considers in a grid map: those between the pieces of its floor.

    Raises MapError when the map shows no room.
    """
    check_shows_rooms(grid)
    division = divide_floor(grid, parameters)
    pieces, resolution = division.pieces, division.working_grid.resolution
    # Stretches inside a room, where its pieces have been joined, besides the borders between rooms
    stretches = [cells for cells in list_stretches(pieces.labels) if np.ptp(division.labels[tuple(cells.T)]) == 0]
    inner = draw_borders(stretches, division.space, pieces.necks, resolution)
    borders, candidates = (shapely.linestrings(group) for group in (division.borders, inner.lines))
    tree = shapely.STRtree(borders)
    near, _ = tree.query(candidates, predicate="dwithin", distance=SAME_BORDER / resolution)
    is_new = ~np.isin(np.arange(len(candidates)), near)
    lines = np.concatenate([division.borders, np.unique(inner.lines[is_new], axis=0)])
    positions = lines[:, :1] + np.linspace(0, 1, SAMPLES)[:, None] * (lines[:, 1:] - lines[:, :1])
    evidence = division.evidence
    probability, wall, door = (
        sample_image(evidence.enlarge(image), positions).mean(axis=1)
        for image in (find_border_probability(evidence), evidence.classes[WALL], evidence.classes[DOOR])
    )
    reasons = tuple(f"{d:.0%} door and {w:.0%} wall on it" for w, d in zip(wall, door, strict=True))
    return ConsideredBorders(
        _lines_to_map(lines, division.working_grid),
        tuple(probability.clip(0, 1).tolist()),
        reasons,
        np.stack([sample_class(evidence, division.working_grid, cell_class) for cell_class in CLASSES], axis=-1),
    )


def _lines_to_map(lines: Floats, working_grid: WorkingGrid) -> Floats:
    """Lines of cells, shape (N, 2, 2), end, then row and col, as x and y in metres of the map frame."""
    in_metres = [LineString((line[:, ::-1] + 0.5) * working_grid.resolution) for line in lines]
    return np.reshape([get_coordinates(working_grid.to_map(line)) for line in in_metres], (-1, 2, 2))
