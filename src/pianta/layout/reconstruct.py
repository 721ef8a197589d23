"""Layout reconstruction by any of the methods: a grid map in, a floor out."""

from __future__ import annotations

from functools import partial

from pianta._arguments import check_argument
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters, StructureParameters, ThesisParameters, check_parameters
from pianta.layout.rivals.methods import SEGMENTATIONS

METHODS = ("structure", "thesis", *SEGMENTATIONS)
DEFAULT_METHOD = METHODS[0]


def reconstruct(
    grid: GridMap,
    *,
    method: str = DEFAULT_METHOD,
    parameters: Parameters | None = None,
    as_printed: bool = False,
    predict_partial: bool = True,
) -> Floor:
    """Reconstruct the floor that a grid map shows: its rooms and doors, and its walls by some methods.

    With `structure` and `thesis`, rooms that end at unknown space are partial, and their whole shape is predicted
    (thesis, section 8.2).

    Parameters
    ----------
    grid
        The occupancy grid; its `source` becomes the floor's.
    method
        One of `METHODS`: "structure" (a network and narrow passages, the default), "thesis" (Algorithm 1 of
        section 3.1), or a method of the survey of Bormann et al. ("morphological", "distance", "voronoi",
        "features").
    parameters
        The thresholds of the method, in metres; None for the default values. `StructureParameters` for
        "structure", `ThesisParameters` for "thesis", and the class beside each method of the survey.
    as_printed
        Whether the method "thesis" is Algorithm 1 as the thesis prints it, without our departures:
        `ThesisParameters.as_printed()` for `parameters`.
    predict_partial
        Whether to predict the whole shape of partial rooms; without it the floor is found faster.

    Returns
    -------
    Floor
        Rooms, doors, walls and, with `structure`, furniture, metres of the map frame. Rooms are numbered from 1 in
        reading order of the map image.

    Raises
    ------
    OptionError
        The method is unknown, or the parameters or `as_printed` belong to another method.
    MapError
        The map shows no room.

    References
    ----------
    M. Luperto, PhD thesis, section 3.1 and chapter 9; R. Bormann et al., Room segmentation: survey, implementation,
    and analysis, ICRA 2016.

    Examples
    --------
    >>> import pianta
    >>> _, grid = pianta.make_world("corridor")
    >>> floor = pianta.reconstruct(grid)
    >>> len(floor), len(floor.doors)
    (19, 20)
    >>> len(pianta.reconstruct(grid, method="morphological"))
    19
    """
    check_argument(grid, GridMap, "grid", "a GridMap of read_map")
    if as_printed:
        check_as_printed(method, parameters)
        parameters = ThesisParameters.as_printed()
    floor = find_rooms(grid, method=method, parameters=parameters)
    if not predict_partial or not any(room.partial for room in floor.rooms):
        return floor
    from pianta.layout.partial.predict import predict_partial_rooms

    return predict_partial_rooms(floor, grid)


def find_rooms(grid: GridMap, *, method: str, parameters: Parameters | None = None) -> Floor:
    """The floor of `reconstruct`, without a prediction for partial rooms."""
    check_method(method)
    if method in SEGMENTATIONS:
        from pianta.layout.rivals.methods import segment_rooms
        from pianta.layout.rivals.to_floor import floor_from_labels

        return floor_from_labels(grid, segment_rooms(grid, method=method, parameters=parameters))
    if method == "thesis":
        from pianta.layout.thesis.reconstruct import reconstruct_layout

        return reconstruct_layout(grid, parameters=check_parameters(parameters, ThesisParameters))
    from pianta.layout.structure.reconstruct import reconstruct_structure
    from pianta.layout.structure.tiles import PARAMETERS as TILE_PARAMETERS
    from pianta.layout.structure.tiles import reconstruct_in_tiles

    read = partial(reconstruct_structure, parameters=check_parameters(parameters, StructureParameters))
    return read(grid) if grid.cells.size <= TILE_PARAMETERS.max_whole else reconstruct_in_tiles(grid, read)


def check_as_printed(method: str, parameters: Parameters | None = None) -> None:
    """Raise OptionError if as_printed=True is given for another method, or with parameters."""
    if method != "thesis":
        raise OptionError(f"as_printed=True is for method thesis and method is {method}, give method='thesis'")
    if parameters is not None:
        raise OptionError("as_printed=True and parameters= are given, leave either out")


def check_method(method: str) -> None:
    """Raise OptionError for an unknown method."""
    if method not in METHODS:
        raise OptionError(f"method is {method!r}, give one of {', '.join(METHODS)}")
