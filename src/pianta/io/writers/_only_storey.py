"""Formats of one floor: its rooms and its map."""

from __future__ import annotations

from pianta.building import Building
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._files import short_repr


def get_only_storey(building: Building, format_name: str) -> tuple[Floor, GridMap]:
    """The floor and the map of a building with one storey.

    Raises OptionError for several storeys, and without a map.
    """
    if len(building) > 1:
        names = ", ".join(short_repr(storey.name) for storey in building)
        raise OptionError(f"format {format_name} is for one floor, give the folder of one of the storeys {names}")
    (storey,) = building
    if storey.grid is None:
        raise OptionError(f"format {format_name} needs the map, give it with grid=")
    return storey.floor, storey.grid
