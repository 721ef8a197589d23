"""Synthetic buildings by name, with the map that a robot would make of them."""

from __future__ import annotations

from typing import TypedDict, Unpack

from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._files import short_repr
from pianta.worlds.floors import FLOOR_MAKERS, make_floor

SAMPLE = "sample"
KINDS = (SAMPLE, *FLOOR_MAKERS)


class MapOptions(TypedDict, total=False):
    """The options of a simulated map."""

    resolution: float
    noise: float
    furniture: float
    glass_spray: bool
    yaw: float


def make_world(kind: str = SAMPLE, *, seed: int | None = None, **options: Unpack[MapOptions]) -> tuple[Floor, GridMap]:
    """Make a synthetic building and the map that a robot would make of it.

    The command `pianta world` calls this function.

    Parameters
    ----------
    kind
        "sample", which is always the same, or "corridor", "l", "ring" or "hall".
    seed
        Of the building and the noise; 0 if None.
    **options
        `resolution` (metres per cell), `noise` (0 … 1), `furniture` (0 empty, 1 a busy office, at most 10),
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
        An unknown kind, an option or a seed without meaning, or an option of the sample, which has none.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor", resolution=0.1)
    >>> len(floor), grid.shape
    (19, (167, 323))
    """
    from pianta.worlds.scan import make_sample, map_floor

    if kind not in KINDS:
        raise OptionError(f"kind is {short_repr(kind)}, give one of {', '.join(KINDS)}")
    if seed is not None and seed < 0:
        raise OptionError(f"seed is {seed}, give 0 or more")
    if kind != SAMPLE:
        floor = make_floor(kind, seed=seed or 0)
        return floor, map_floor(floor, seed=seed or 0, **options)
    if options or seed is not None:
        raise OptionError(f"the sample is always the same, leave out the options or give {', '.join(FLOOR_MAKERS)}")
    return make_sample()
