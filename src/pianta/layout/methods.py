"""The ways in which rooms are found, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.layout.rivals.methods import SEGMENTATIONS, segment_rooms

Reconstruct = Callable[[GridMap, str], Floor]


def check_method(method: str) -> None:
    """Raise OptionError for the name of no method."""
    if method not in METHODS:
        raise OptionError(f"method is {method!r}, give one of {', '.join(METHODS)}")


def reconstruct_by_thesis(grid: GridMap, source: str) -> Floor:
    """Floor by Algorithm 1 of the thesis."""
    from pianta.layout.parameters import ThesisParameters
    from pianta.layout.thesis.reconstruct import reconstruct_layout

    return reconstruct_layout(grid, parameters=ThesisParameters(), source=source)


def reconstruct_by_segmentation(grid: GridMap, source: str, *, method: str) -> Floor:
    """Floor from the label image of one of SEGMENTATIONS."""
    from pianta.layout.rivals.to_floor import floor_from_labels

    return floor_from_labels(grid, segment_rooms(grid, method=method), source=source)


def reconstruct_by_structure(grid: GridMap, source: str) -> Floor:
    """Floor by narrow passages and wall lines together."""
    from pianta.layout.parameters import StructureParameters
    from pianta.layout.structure.reconstruct import reconstruct_structure

    return reconstruct_structure(grid, parameters=StructureParameters(), source=source)


RECONSTRUCTIONS: Mapping[str, Reconstruct] = {
    "structure": reconstruct_by_structure,
    "thesis": reconstruct_by_thesis,
    **{name: partial(reconstruct_by_segmentation, method=name) for name in SEGMENTATIONS},
}
METHODS = tuple(RECONSTRUCTIONS)
DEFAULT_METHOD = METHODS[0]
