"""Synthetic buildings by name, with simulated maps of them."""

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


def make_world(name: str = SAMPLE, *, seed: int | None = None, **options: Unpack[MapOptions]) -> tuple[Floor, GridMap]:
    """Make a synthetic building and the map that a robot would make of it.

    The command `pianta world` calls this function.

    Parameters
    ----------
    name
        "sample", which is always the same, or "corridor", "l", "ring" or "hall", or, with labels, "home", "office",
        "open_plan", "ward" or "depot".
    seed
        Of the building and the noise; None for 0.
    **options
        `resolution` (metres per cell), `noise` (0 … 1), `furniture` (0 empty, 1 a busy office, at most 10),
        `dense_furniture` (whether it is chosen by the labels of rooms, stands in corridors too, and may nearly close
        passages), `door_leaves` (whether doors are open, half open and shut, not gaps),
        `glass_spray` (whether one outer wall is glass), `yaw` (radians from the building's axes to the map's).

    Returns
    -------
    floor : Floor
        The truth: rooms and doors, metres of the map frame.
    grid : GridMap
        The map.

    Raises
    ------
    OptionError
        The name is unknown, an option or the seed is out of range, or the sample has options.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor", resolution=0.1)
    >>> len(floor), grid.shape
    (19, (167, 323))
    """
    from pianta.worlds.scan import make_sample, simulate_map

    if name not in WORLD_NAMES:
        raise OptionError(f"name is {short_repr(name)}, give one of {', '.join(WORLD_NAMES)}")
    if seed is not None and seed < 0:
        raise OptionError(f"seed is {seed}, give 0 or more")
    if name != SAMPLE:
        floor = make_floor(name, seed=seed or 0)
        return floor, simulate_map(floor, seed=seed or 0, **options)
    if options or seed is not None:
        raise OptionError(f"the sample is always the same, leave out the options or give {', '.join(WORLD_NAMES[1:])}")
    return make_sample()
