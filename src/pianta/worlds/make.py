"""Synthetic buildings by name, with simulated maps of them; those of a model are in pianta.generation.world."""

from __future__ import annotations

from typing import TypedDict, Unpack

from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._files import short_repr
from pianta.worlds.floors import FLOOR_MAKERS, LABELLED_FLOOR_MAKERS, make_floor

SAMPLE = "sample"
WORLD_NAMES = (SAMPLE, *FLOOR_MAKERS, *LABELLED_FLOOR_MAKERS)


class MapOptions(TypedDict, total=False):
    """The options of a simulated map."""

    resolution: float
    noise: float
    furniture: float
    dense_furniture: bool
    door_leaves: bool
    glass_spray: bool
    yaw: float


def make_synthetic_world(
    name: str = SAMPLE, *, seed: int | None = None, **options: Unpack[MapOptions]
) -> tuple[Floor, GridMap]:
    """A synthetic building with its furniture, and its map; as `pianta.make_world` without a model.

    Raises OptionError for an unknown name, an option or a seed out of range, and options of the sample.
    """
    from pianta.worlds.scan import make_sample

    if name not in WORLD_NAMES:
        raise OptionError(
            f"name is {short_repr(name)}, give one of {', '.join(WORLD_NAMES)}, or a building type with its model"
        )
    check_seed(seed)
    if name != SAMPLE:
        return map_world(make_floor(name, seed=seed or 0), seed=seed or 0, **options)
    if options or seed is not None:
        raise OptionError(f"the sample is always the same, leave out the options or give {', '.join(WORLD_NAMES[1:])}")
    return make_sample()


def map_world(floor: Floor, *, seed: int, **options: Unpack[MapOptions]) -> tuple[Floor, GridMap]:
    """A floor with the furniture of its map, and the map."""
    from pianta.worlds.furnish import furnish
    from pianta.worlds.scan import simulate_map

    grid = simulate_map(floor, seed=seed, **options)
    furnished = furnish(
        floor,
        furniture=options.get("furniture", 0.0),
        dense_furniture=options.get("dense_furniture", False),
        resolution=grid.resolution,
        seed=seed,
    )
    return furnished, grid


def check_seed(seed: int | None) -> None:
    """Raise OptionError for a negative seed."""
    if seed is not None and seed < 0:
        raise OptionError(f"seed is {seed}, give 0 or more")
