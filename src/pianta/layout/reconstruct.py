"""A grid map in, a floor out, by the method of your choice."""

from __future__ import annotations

from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.layout.methods import check_method
from pianta.layout.parameters import ThesisParameters
from pianta.layout.thesis import reconstruct_layout


def reconstruct(
    grid: GridMap, *, method: str = "thesis", parameters: ThesisParameters | None = None, source: str = ""
) -> Floor:
    """Floor of a grid map, in metres of the map frame: rooms, doors and representative lines.

    method: one of METHODS.
    parameters: thresholds in metres; the defaults suit every map.
    source: the name that the floor carries.

    Raises OptionError for an unknown method, and MapError when the map shows no room.
    """
    check_method(method)
    return reconstruct_layout(grid, parameters=parameters or ThesisParameters(), source=source)
