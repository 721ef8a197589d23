"""Metrics of annotated schools and offices as graphs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

from pianta.graphs.centrality import drop_isolated, measure_decay
from pianta.graphs.metrics import find_corridors, measure_graph
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.labels import schema_of
from pianta_bench.data.folders import find_data, list_maps
from pianta_bench.harness.records import Figures, Results, Track

# The part of the table, by the building type, which is also the folder in data/buildings.
PARTS: Mapping[str, str] = MappingProxyType({"school": "schools", "office": "offices"})
DECAY = "decay"


def measure(data: Path | None = None, *, track: Track = iter) -> Results:
    """Measure each building of data/buildings/school/*.xml and office/*.xml; one record for each metric.

    A building that cannot be read or has unknown labels has no records.
    track: wraps the names of the buildings, to show progress.
    Raises DataError if there are no buildings of a type.
    """
    folder = find_data(data) / "buildings"
    names = [(building_type, name) for building_type in PARTS for name in list_maps(folder / building_type, ".xml")]
    results = Results()
    for (building_type, name), _ in zip(names, track([f"{each}/{name}" for each, name in names]), strict=True):
        measure_one = partial(measure_building, folder / building_type / f"{name}.xml", building_type)
        results.measure(PARTS[building_type], name, measure_one)
    return results


def measure_building(file: Path, building_type: str) -> Iterator[Figures]:
    """The metrics of the graph of a building without isolated rooms, and the mean of the formula in section 5.1."""
    graph = drop_isolated(read_building_xml(file).graph())
    decay = list(measure_decay(graph).values())
    yield measure_graph(graph, find_corridors(graph, schema_of(building_type)))
    yield {DECAY: float(np.mean(decay)) if decay else None}
