"""Fixtures of homes on a sheet: toilets, baths, sinks, hobs and beds, found by a convolutional network.

Templates are no use for them: everyone draws a bed in another way. The network learned from made plans alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from pianta.floor import Floor, Furniture
from pianta.plan.network import run_network
from pianta.plan.sheets.sheet import Sheet
from pianta.plan.walls.segmentation import input_layers

NETWORK = "plan_fixtures.onnx"
CELL = 0.045  # m of a cell of the network
# The classes of the network, in its order
NO_FIXTURE, TOILET, BATH, SINK, HOB, BED = range(6)
N_CLASSES = 6
KINDS = MappingProxyType({TOILET: "toilet", BATH: "bath", SINK: "sink", HOB: "hob", BED: "bed"})


@dataclass(frozen=True, kw_only=True)
class FixtureParameters:
    """Thresholds of `find_fixtures`. Chosen by hand, no fit is on record."""

    min_probability: float = 0.5  # of a cell
    min_mean: float = 0.7  # of the cells of a fixture
    min_filled: float = 0.6  # of its rectangle that its cells fill
    max_cells: float = 4e6  # cells of a sheet, for time: larger sheets are no homes
    # Smallest and largest rectangle, m²; showers are baths
    toilet: tuple[float, float] = (0.08, 0.6)
    bath: tuple[float, float] = (0.35, 2.2)
    sink: tuple[float, float] = (0.08, 1.2)
    hob: tuple[float, float] = (0.1, 0.7)
    bed: tuple[float, float] = (1.0, 5.0)


PARAMETERS = FixtureParameters()


def find_fixtures(sheet: Sheet, *, resolution: float) -> tuple[Furniture, ...]:
    """The fixtures on a sheet, each as the rectangle that it fills, in metres, y up.

    The origin is the lower left corner of the sheet. resolution: metres per pixel, right within a factor of 1.5.
    """
    cell_px = CELL / resolution
    if sheet.shape[0] * sheet.shape[1] / cell_px**2 > PARAMETERS.max_cells:
        return ()
    probabilities = run_network(NETWORK, input_layers(sheet.colors, cell_px=cell_px))
    return tuple(_list_fixtures(probabilities, cell_px * resolution, sheet.shape[0] * resolution))


def _list_fixtures(probabilities: NDArray[np.float32], cell: float, height: float) -> Iterator[Furniture]:
    """The fixtures by the probabilities of the classes, shape (N_CLASSES, h, w); cell, height: metres."""
    p, best = PARAMETERS, probabilities.argmax(axis=0)
    for number, name in KINDS.items():
        is_kind = (best == number) & (probabilities[number] >= p.min_probability)
        count, labels = cv2.connectedComponents(is_kind.astype(np.uint8), connectivity=4)
        smallest, largest = getattr(p, name)
        for label in range(1, count):
            cells = np.argwhere(labels == label)
            middle, sides, angle = cv2.minAreaRect(cells[:, ::-1].astype(np.float32))
            # Cells reach half a cell beyond their middles
            sides = (sides[0] + 1, sides[1] + 1)
            area, mean = sides[0] * sides[1], float(probabilities[number][tuple(cells.T)].mean())
            if not smallest <= area * cell**2 <= largest or len(cells) < p.min_filled * area or mean < p.min_mean:
                continue
            corners = (cv2.boxPoints((middle, sides, angle)) + 0.5) * cell
            yield Furniture(Polygon(np.column_stack([corners[:, 0], height - corners[:, 1]])), mean, name)


def place_fixtures(floors: Sequence[Floor], fixtures: Sequence[Furniture]) -> list[Floor]:
    """The floors with the fixtures that stand in their rooms."""
    middles = shapely.centroid(np.array([piece.polygon for piece in fixtures], object))
    placed = []
    for floor in floors:
        rooms = shapely.STRtree([room.polygon for room in floor])
        inside = sorted({int(index) for index in rooms.query(middles, predicate="within")[0]})
        placed.append(replace(floor, furniture=(*floor.furniture, *(fixtures[index] for index in inside))))
    return placed
