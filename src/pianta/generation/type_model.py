"""M = {G, H, C}: what the floors of a building type have in common (thesis, sections 7.2 and 7.3)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.errors import GraphError, LabelError, ModelError
from pianta.generation.area_clusters import AreaKernel, cluster_areas, compare_areas
from pianta.generation.functional_areas import (
    Area,
    Cut,
    Segmentation,
    build_functional_graph,
    find_cuts,
    find_functional_areas,
)
from pianta.graphs.centrality import drop_isolated
from pianta.graphs.labelled_graphs import name_some
from pianta.graphs.metrics import find_corridors
from pianta.io._faults import join_faults
from pianta.io._files import short_repr
from pianta.labels import LabelConvention, LabelSchema, standard_name

Counts: TypeAlias = NDArray[np.int64]

# Iterations of the authors.
SWEEPS, EDGE_MOVES, DOOR_MOVES = 300, 2000, 100
LEAST_FLOORS = 2
# The time and the memory of all steps grow with the square of the rooms of a floor.
MAX_ROOMS = 1000
# R-hat below which chains have mixed (Gelman and Rubin, 1992).
MIXED_BELOW = 1.1


@dataclass(frozen=True)
class Mixing:
    """What was found of one step: its iterations, and R̂ of the median target in the second half of them."""

    iterations: int
    convergence: float

    @property
    def has_mixed(self) -> bool:
        """Whether R̂ is below 1.1, rather than that nobody waits any longer."""
        return self.convergence < MIXED_BELOW


@dataclass(frozen=True)
class ModelMixing:
    """What was found of steps 1, 2 and 4."""

    sweeps: Mixing
    edge_moves: Mixing
    door_moves: Mixing


@dataclass(frozen=True, eq=False)
class TypeFloor:
    """A floor in functional areas, and the clusters of these.

    source: its name. graph: connected, nodes 0 … n - 1 with a `label` each, and maybe an `area`, m². areas: the nodes
    of each functional area.
    clusters: of each area, numbered from 0 over all floors of a model.
    """

    source: str
    graph: nx.Graph
    areas: tuple[Area, ...]
    clusters: tuple[int, ...]

    @cached_property
    def cuts(self) -> dict[tuple[int, int], list[Cut]]:
        """The edges between areas, by the places of the areas."""
        return find_cuts(self.graph, self.areas)

    @cached_property
    def functional_graph(self) -> nx.Graph:
        """H: a node an area, its label its cluster."""
        return build_functional_graph(self.graph, self.areas, [str(cluster) for cluster in self.clusters])

    @cached_property
    def area_graphs(self) -> tuple[nx.Graph, ...]:
        """The part of the graph that is each area, its nodes in order."""
        return tuple(take_area(self.graph, area) for area in self.areas)


@dataclass(frozen=True, eq=False)
class TypeModel:
    """The floors of a building type, their functional areas, and the clusters of these.

    Attributes
    ----------
    schema
        The labels of the type.
    segmentation
        How functional areas are found.
    floors
        Each floor, in functional areas.
    sweeps, edge_moves, door_moves
        Iterations of the chains of steps 1, 2 and 4: those of the authors, or what `train_type` found that the chains
        take.
    mixing
        What `train_type` found; None if unknown, as in a model from a file.

    References
    ----------
    M. Luperto, PhD thesis, sections 7.2, 7.3 and 7.4.3.
    """

    schema: LabelSchema
    segmentation: Segmentation
    floors: tuple[TypeFloor, ...]
    sweeps: int = SWEEPS
    edge_moves: int = EDGE_MOVES
    door_moves: int = DOOR_MOVES
    mixing: ModelMixing | None = None

    def save(self, path: str | Path) -> None:
        """Write the model as a JSON file that `load_model` reads.

        Parameters
        ----------
        path
            The file; an older one is replaced.

        Raises
        ------
        ModelError
            The model could not be read again.
        PiantaError
            The file cannot be written.
        """
        from pianta.generation.type_model_file import save_type_model

        save_type_model(self, path)

    @property
    def building_type(self) -> str:
        """The type, in lower case."""
        return self.schema.building_type

    @cached_property
    def areas(self) -> tuple[nx.Graph, ...]:
        """The functional areas of all floors, those of a floor after each other."""
        return tuple(area for floor in self.floors for area in floor.area_graphs)

    @cached_property
    def clusters(self) -> NDArray[np.intp]:
        """The cluster of each of `areas`."""
        return np.array([cluster for floor in self.floors for cluster in floor.clusters], np.intp)

    @cached_property
    def configurations(self) -> Counts:
        """V: the number of areas of each cluster on each floor, shape (floors, clusters)."""
        return np.array([self.configure(floor) for floor in self.floors])

    @cached_property
    def door_counts(self) -> list[int]:
        """The number of cuts of each edge of the functional graphs, sorted; 1 where no floor has any."""
        return sorted(len(cuts) for floor in self.floors for cuts in floor.cuts.values()) or [1]

    def configure(self, floor: TypeFloor) -> Counts:
        """Give V of a floor: how many areas of each cluster it has.

        Parameters
        ----------
        floor
            A floor in areas of the clusters of this model.

        Returns
        -------
        numpy.ndarray
            Shape (clusters,).
        """
        return np.bincount(floor.clusters, minlength=int(self.clusters.max()) + 1).astype(np.int64)

    def __str__(self) -> str:
        areas = f"{len(self.areas)} functional areas by {self.segmentation}"
        return f"{len(self.floors)} floors, {areas}, {self.configurations.shape[1]} clusters"


def learn_type(
    graphs: Iterable[nx.Graph],
    schema: LabelSchema,
    *,
    segmentation: Segmentation = Segmentation.CORR,
    kernel: AreaKernel = AreaKernel.GRAPH_HOPPER,
) -> TypeModel:
    """Build the model of a building type from the graphs of its floors.

    graphs: as `Floor.graph` gives them.
    Raises ModelError for fewer than two floors, and one that lists each floor that a model cannot take and why.
    """
    prepared, faults = [], []
    for number, graph in enumerate(graphs, 1):
        try:
            prepared.append(prepare_room_graph(graph, schema))
        except (GraphError, LabelError) as error:
            faults.append(f"floor {short_repr(graph.graph.get('source') or number)}: {error}")
    if faults:
        raise ModelError(join_faults(faults))
    if len(prepared) < LEAST_FLOORS:
        raise ModelError(f"{len(prepared)} floor{'s' * (len(prepared) != 1)} given, give two at least, better dozens")
    # 7.3.1: each graph is cut into functional areas, which gives its functional graph as well.
    areas = [_cut(graph, schema, segmentation) for graph in prepared]
    # 7.3.2: areas of all graphs that are alike are a cluster.
    parts = [take_area(graph, area) for graph, own in zip(prepared, areas, strict=True) for area in own]
    clusters = cluster_areas(compare_areas(parts, kernel=kernel), segmentation=segmentation).tolist()
    ends = np.cumsum([len(own) for own in areas]).tolist()
    floors = [
        TypeFloor(graph.graph["source"], graph, own, tuple(clusters[end - len(own) : end]))
        for graph, own, end in zip(prepared, areas, ends, strict=True)
    ]
    return TypeModel(schema, segmentation, tuple(floors))


def recognize_areas(graph: nx.Graph, model: TypeModel) -> TypeFloor:
    """A floor that a model does not know, in functional areas, each of the cluster of the area that it is most like.

    graph: as `learn_type` takes it. Its nodes keep their names in the `room` of those of the floor.
    Raises GraphError and LabelError for one that a model cannot take.
    """
    from pianta.graphs.graph_hopper import GraphHopper

    prepared = prepare_room_graph(graph, model.schema)
    areas = _cut(prepared, model.schema, model.segmentation)
    kernel = GraphHopper().fit(model.areas)
    rows, known = kernel.compare([take_area(prepared, area) for area in areas]), kernel.compare()
    # As the clusters were found: alike is what is alike to the same areas.
    nearest = [int(((known - row) ** 2).sum(axis=1).argmin()) for row in rows]
    return TypeFloor(prepared.graph["source"], prepared, areas, tuple(model.clusters[nearest].tolist()))


def prepare_room_graph(graph: nx.Graph, schema: LabelSchema) -> nx.Graph:
    """The graph of a floor as a model takes it: nodes 0 … n - 1, each with its `label` and its name before, `room`.

    Where it has one, a node keeps its `area`, m². Rooms without a door are left out, as in Table 5.1.
    Raises LabelError that lists rooms without a label, or labels that the schema does not have, and GraphError for a
    floor without doors, of more than 1000 rooms, or whose doors leave it in parts, have a direction or lead back.
    """
    if graph.is_directed() or graph.is_multigraph():
        raise GraphError(f"it is a {type(graph).__name__}, give a networkx.Graph without directions and parallel edges")
    if loops := [*nx.nodes_with_selfloops(graph)]:
        raise GraphError(f"doors of rooms {name_some(loops)} lead back to the same room, remove them")
    joined = drop_isolated(graph)
    if unlabelled := [node for node, label in joined.nodes(data="label") if label is None]:
        raise LabelError(f"rooms {name_some(unlabelled)} have no label, label them")
    if unnamed := [node for node, label in joined.nodes(data="label") if not isinstance(label, str)]:
        raise LabelError(f"the labels of rooms {name_some(unnamed)} are no text, label them")
    find_corridors(joined, schema)
    if not len(joined):
        raise GraphError("no door joins two of its rooms, add doors or leave it out")
    if len(joined) > MAX_ROOMS:
        raise GraphError(f"it has {len(joined)} rooms, give floors of {MAX_ROOMS} at most")
    if (parts := nx.number_connected_components(joined)) > 1:
        raise GraphError(f"its rooms are in {parts} parts that no door joins, add the doors or leave it out")
    places = {node: place for place, node in enumerate(joined)}
    prepared = nx.Graph(source=str(graph.graph.get("source", "")))
    prepared.add_nodes_from(
        (places[node], {"label": standard_name(label), "room": node} | take_size(joined.nodes[node]))
        for node, label in joined.nodes(data="label")
    )
    prepared.add_edges_from((places[one], places[other]) for one, other in joined.edges)
    return prepared


def take_size(attributes: Mapping[str, Any]) -> dict[str, float]:
    """The `area` of a room in its attributes, m², where it is a number above 0; nothing where it is none."""
    area = attributes.get("area")
    if not isinstance(area, int | float) or isinstance(area, bool) or not 0 < area < np.inf:
        return {}
    return {"area": float(area)}


def take_area(graph: nx.Graph, area: Area) -> nx.Graph:
    """The part of a graph that is an area, its nodes in the order of the graph."""
    part = nx.Graph()
    part.add_nodes_from((node, dict(attributes)) for node, attributes in graph.nodes(data=True) if node in area)
    part.add_edges_from((one, other) for one, other in graph.edges if one in area and other in area)
    return part


def count_labels(graphs: Iterable[nx.Graph], schema: LabelSchema) -> Counts:
    """Nodes of each label of a schema in each graph, shape (graphs, labels)."""
    columns = {name: column for column, name in enumerate(schema.by_name)}
    found = [[columns[label] for _, label in graph.nodes(data="label")] for graph in graphs]
    counts = [np.bincount(labels, minlength=len(columns)) for labels in found]
    return np.array(counts, np.int64).reshape(-1, len(columns))


def _cut(graph: nx.Graph, schema: LabelSchema, segmentation: Segmentation) -> tuple[Area, ...]:
    corridors = find_corridors(graph, schema, convention=LabelConvention.GRAPHS)
    return find_functional_areas(graph, corridors, segmentation=segmentation)
