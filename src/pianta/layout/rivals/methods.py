"""The rival segmentations by name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pianta.errors import MapError, OptionError
from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters

SEGMENTATIONS = ("morphological", "distance", "voronoi", "features")
# Cells coarser than this show no doors; metres.
COARSEST = 0.5


def segment_rooms(grid: GridMap, *, method: str, parameters: Parameters | None = None) -> NDArray[np.int32]:
    """Rooms of a grid map by a rival method, shape (H, W): 0 no room, 1 … N; every room is connected by cell sides.

    method: one of SEGMENTATIONS. parameters: of that method, as its module has them; None for the survey's.
    Raises OptionError for an unknown method, and MapError when the map shows no room.
    """
    from pianta.layout.rivals.distance import segment_by_clearance
    from pianta.layout.rivals.features import segment_by_features
    from pianta.layout.rivals.morphological import segment_by_erosion
    from pianta.layout.rivals.voronoi import segment_by_voronoi_diagram

    segments: dict[str, Callable[..., NDArray[np.int32]]] = {
        "morphological": segment_by_erosion,
        "distance": segment_by_clearance,
        "voronoi": segment_by_voronoi_diagram,
        "features": segment_by_features,
    }
    if method not in SEGMENTATIONS:
        raise OptionError(f"method is {method!r}, give one of {', '.join(SEGMENTATIONS)}")
    if grid.resolution > COARSEST:
        raise MapError(f"cells of {grid.resolution:g} m are too coarse to show rooms; check the resolution")
    if not grid.free.any():
        raise MapError("the map has no free cell, so there is no room to find; check its thresholds and negate")
    if grid.free.all():
        raise MapError("every cell of the map is free, so no wall bounds a room; check its thresholds and negate")
    labels = segments[method](grid, parameters=parameters)
    if not labels.any():
        raise MapError("the map shows no room, its free space is too small or too scattered; check the resolution")
    return labels
