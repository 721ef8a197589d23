"""Furniture of synthetic floors: what stands in the rooms of a floor whose map `simulate_map` makes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from shapely import Polygon

from pianta.floor import Floor, Furniture
from pianta.worlds.dense_furniture import furnish_densely, place_pieces
from pianta.worlds.furniture import furnish_floor
from pianta.worlds.wall_axes import round_to_mm

# Side of the legs of tables and chairs that do not stand by the labels of rooms, unless cells are larger; metres.
LEG = 0.05


def furnish(
    floor: Floor, *, furniture: float, dense_furniture: bool = False, resolution: float = 0.05, seed: int = 0
) -> Floor:
    """The floor with the furniture that its map by `simulate_map` with these options and this seed shows.

    What a lidar detects is a piece each: the legs of a table are four. Those by the labels of rooms have a kind.
    """
    rng = _make_rng(seed)
    if dense_furniture:
        pieces = place_pieces(floor, density=furniture, rng=rng)
        return _add(floor, [(part, piece.kind) for piece in pieces for part in piece.parts])
    obstacles = place_obstacles(floor, furniture, resolution, rng, by_label=False)
    return _add(floor, [(obstacle, "") for obstacle in obstacles])


def furnish_for_robot(floor: Floor, *, furniture: float, radius: float, seed: int = 0) -> Floor:
    """The floor furnished by the labels of its rooms, with ways for a robot from each door into its rooms.

    furniture: 0 empty … 1 in use. radius: of the robot, metres. The furniture is that of `furnish`, without the pieces
    that close ways.
    """
    from pianta.worlds.ways import keep_ways

    pieces = keep_ways(floor, place_pieces(floor, density=furniture, rng=_make_rng(seed)), radius=radius)
    return _add(floor, [(part, piece.kind) for piece in pieces for part in piece.parts])


def place_obstacles(
    floor: Floor, density: float, resolution: float, rng: np.random.Generator, *, by_label: bool
) -> list[Polygon]:
    """What stands in the rooms, metres in the floor's frame; by_label: also in corridors, and nearly closing passages.

    density: 0 empty … 1 a busy place. resolution: metres per cell.
    """
    if by_label:
        return furnish_densely(floor, density=density, rng=rng)
    return furnish_floor(floor, density=density, leg=max(LEG, resolution), rng=rng)


def _make_rng(seed: int) -> np.random.Generator:
    """The random stream that `simulate_map` has for furniture."""
    return np.random.default_rng(seed).spawn(3)[0]


def _add(floor: Floor, parts: list[tuple[Polygon, str]]) -> Floor:
    """The floor with parts of pieces and their kinds, rounded to millimetres."""
    return replace(floor, furniture=tuple(Furniture(round_to_mm(part), kind=name or None) for part, name in parts))
