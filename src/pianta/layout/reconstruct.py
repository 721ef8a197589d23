"""A grid map in, a floor out, by the method of your choice."""

from __future__ import annotations

from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.layout.methods import DEFAULT_METHOD, RECONSTRUCTIONS, check_method
from pianta.layout.partial.predict import predict_partial_rooms


def reconstruct(grid: GridMap, *, method: str = DEFAULT_METHOD, source: str = "") -> Floor:
    """Floor of a grid map, in metres of the map frame: rooms, doors and, by some methods, representative lines.

    Rooms that end at space that nobody has seen are partial, by `structure` and `thesis`, and predicted as a whole.

    method: one of METHODS.
    source: the name that the floor carries.

    Raises OptionError for an unknown method, and MapError when the map shows no room.
    """
    check_method(method)
    return predict_partial_rooms(RECONSTRUCTIONS[method](grid, source), grid)
