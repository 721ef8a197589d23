"""The borders that the method `structure` considers, and what the decision about each rests on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from shapely import LineString, get_coordinates

from pianta._types import Floats, Indices
from pianta.gridmap import GridMap
from pianta.layout._working_grid import WorkingGrid, check_shows_rooms
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.merging import (
    FEATURES,
    MergeModel,
    describe_separators,
    find_active_separators,
    find_corridor_bends,
    initial_rooms,
    join_rooms,
    read_default_merge_model,
    select_likeliest,
)
from pianta.layout.structure.reconstruct import Oversegmentation, merge_and_split_regions, oversegment
from pianta.layout.structure.wall_lines import find_wall_lines

BY_WALL_LINE = "by the line of a wall"


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
    """The borders that reconstruct_structure considers in a grid map.

    Raises MapError when the map shows no room.
    """
    check_shows_rooms(grid)
    cut, model = oversegment(grid, parameters), read_default_merge_model()
    features, is_bend = follow_merging(cut, model)
    probabilities = 1 / (1 + np.exp(model.log_odds(features)))
    reasons = [_describe(row, bend=bend) for row, bend in zip(features, is_bend.tolist(), strict=True)]
    # Wall lines close wider openings, by a rule
    wall_lines = find_wall_lines(cut.space, resolution=cut.working_grid.resolution)
    _, borders = merge_and_split_regions(cut, wall_lines, parameters, model)
    openings = [line for line in borders if not (cut.separators.lines == line).all(axis=(1, 2)).any()]
    lines = np.concatenate([cut.separators.lines, np.reshape(openings, (-1, 2, 2))])
    return ConsideredBorders(
        _lines_to_map(lines, cut.working_grid),
        (*probabilities.tolist(), *[None] * len(openings)),
        (*reasons, *[BY_WALL_LINE] * len(openings)),
    )


def follow_merging(cut: Oversegmentation, model: MergeModel) -> tuple[Floats, NDArray[np.bool_]]:
    """Features of each separator when it was decided upon, shape (B, 11); and whether a corridor goes on there, (B,).

    The steps are those of merge_regions. A separator is decided upon when its rooms are merged, or at the end.
    """
    separators, rooms = cut.separators, initial_rooms(cut.regions)
    features = np.zeros((len(separators.sides), len(FEATURES)))
    is_bend = np.zeros(len(separators.sides), bool)
    while True:
        active = find_active_separators(rooms, separators)
        pairs: Indices = rooms.owner[separators.sides[active]]
        features[active] = describe_separators(rooms, separators, active, resolution=cut.regions.resolution)
        log_odds = model.log_odds(features[active])
        chosen = select_likeliest(pairs, log_odds, log_odds > 0)
        if not len(chosen):
            chosen = select_likeliest(pairs, log_odds, find_corridor_bends(rooms, pairs, features[active]))
            is_bend[active[chosen]] = True
        if not len(chosen):
            return features, is_bend
        rooms = join_rooms(rooms, pairs[chosen])


def _describe(features: Floats, *, bend: bool) -> str:
    """The facts about a separator that count most: how open it is, and the walls in line with it."""
    if bend:
        return "a corridor goes on behind it"
    values = dict(zip(FEATURES, features.tolist(), strict=True))
    width = np.exp(values["log opening over narrower width"])
    walls = f"walls of {values['wall in line, less']:.1f} and {values['wall in line, more']:.1f} m in line"
    return f"opening {width:.0%} of the narrower side, {values['open share']:.0%} of the border open, {walls}"


def _lines_to_map(lines: Floats, working_grid: WorkingGrid) -> Floats:
    """Lines of cells, shape (N, 2, 2), end, then row and col, as x and y in metres of the map frame."""
    in_metres = [LineString((line[:, ::-1] + 0.5) * working_grid.resolution) for line in lines]
    return np.reshape([get_coordinates(working_grid.to_map(line)) for line in in_metres], (-1, 2, 2))
