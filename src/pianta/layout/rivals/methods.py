"""The room segmentations of the survey (Bormann et al., ICRA 2016), by name."""

from __future__ import annotations

from collections.abc import Callable

from pianta._types import LabelImage
from pianta.errors import MapError, OptionError
from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters

SEGMENTATIONS = ("morphological", "distance", "voronoi", "features")


def segment_rooms(grid: GridMap, *, method: str, parameters: Parameters | None = None) -> LabelImage:
    """Rooms of a grid map by a rival method, shape (H, W): 0 no room, 1 … N; every room is connected by cell sides.

    method: one of SEGMENTATIONS. parameters: of the class in the module of the method; None for the defaults.
    Raises OptionError for an unknown method, and MapError when the map shows no room.
    """
    from pianta.layout._working_grid import NO_ROOM, check_shows_rooms
    from pianta.layout.rivals.distance import segment_by_clearance
    from pianta.layout.rivals.features import segment_by_features
    from pianta.layout.rivals.morphological import segment_by_erosion
    from pianta.layout.rivals.voronoi import segment_by_voronoi_diagram

    methods: dict[str, Callable[..., LabelImage]] = {
        "morphological": segment_by_erosion,
        "distance": segment_by_clearance,
        "voronoi": segment_by_voronoi_diagram,
        "features": segment_by_features,
    }
    if method not in SEGMENTATIONS:
        raise OptionError(f"method is {method!r}, give one of {', '.join(SEGMENTATIONS)}")
    check_shows_rooms(grid)
    labels = methods[method](grid, parameters=parameters)
    if not labels.any():
        raise MapError(NO_ROOM)
    return labels
