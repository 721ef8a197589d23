"""The model of a building type, M = {G, H, C} (thesis, sections 7.2 and 7.3)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
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
from pianta.generation.room_shapes import ROOM_MEASURES, list_door_attributes, list_measures
from pianta.graphs.centrality import drop_isolated
from pianta.graphs.labelled_graphs import name_some
from pianta.graphs.metrics import find_corridors
from pianta.io._faults import join_faults
from pianta.io._files import short_repr
from pianta.labels import LabelConvention, LabelSchema, standard_name

if TYPE_CHECKING:
    from pianta.graphs.graph_hopper import GraphHopper

Counts: TypeAlias = NDArray[np.int64]

# Iterations of steps 1, 2 and 4: those of the authors (thesis, section 7.4).
SWEEPS = 300
EDGE_MOVES = 2000
DOOR_MOVES = 100
MIN_FLOORS = 2
# Rooms of a floor; time and memory of all steps grow with their square.
MAX_ROOMS = 1000
# R-hat below which chains have mixed (Gelman and Rubin, 1992).
MIXED_BELOW = 1.1


@dataclass(frozen=True)
class Mixing:
    """Iterations of one step, and R̂ of each target in their second half.

    targets: R̂ of each; empty for a step that has no target, because no floor has two areas.
    """

    iterations: int
    targets: tuple[float, ...] = ()

    @property
    def convergence(self) -> float:
        """The highest R̂ of a target; 1 without targets."""
        return max(self.targets, default=1.0)

    @property
    def has_mixed(self) -> bool:
        """Whether R̂ of all targets is below 1.1; otherwise the limit of iterations was reached."""
        return self.convergence < MIXED_BELOW


@dataclass(frozen=True)
class ModelMixing:
    """The mixing of steps 1, 2 and 4."""

    sweeps: Mixing
    edge_moves: Mixing
    door_moves: Mixing


@dataclass(frozen=True, eq=False)
class TypeFloor:
    """A floor divided into functional areas.

    source: its name. graph: connected, nodes 0 … n - 1 with a `label`, and those of ROOM_MEASURES and DOOR_MEASURES
    that are known. areas: the nodes of each functional area. clusters: the cluster of each area, numbered from 0 over
    all floors of a model.
    """

    source: str
    graph: nx.Graph
    areas: tuple[Area, ...]
    clusters: tuple[int, ...]

    @cached_property
    def cuts(self) -> dict[tuple[int, int], list[Cut]]:
        """The edges between areas, by the indices of the areas."""
        return find_cuts(self.graph, self.areas)

    @cached_property
    def functional_graph(self) -> nx.Graph:
        """H: a node for each area, labelled with its cluster."""
        return build_functional_graph(self.graph, self.areas, [str(cluster) for cluster in self.clusters])

    @cached_property
    def area_graphs(self) -> tuple[nx.Graph, ...]:
        """The subgraph of each area, its nodes in order."""
        return tuple(area_subgraph(self.graph, area) for area in self.areas)


@dataclass(frozen=True, eq=False)
class TypeModel:
    """The floors of a building type, their functional areas, and the clusters of the areas.

    Attributes
    ----------
    schema
        The labels of the type.
    segmentation
        How floors are divided into functional areas.
    floors
        The floors with their functional areas.
    sweeps, edge_moves, door_moves
        Iterations of the chains of steps 1, 2 and 4: those of the authors, or a larger number by `train_type`.
    mixing
        The measurement of `train_type`; None if unknown, as in a model from a file.

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
            The file; an existing one is replaced.

        Raises
        ------
        ModelError
            `load_model` could not read the model.
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
        """The functional areas of all floors, floor by floor."""
        return tuple(area for floor in self.floors for area in floor.area_graphs)

    @cached_property
    def clusters(self) -> NDArray[np.intp]:
        """The cluster of each of `areas`."""
        return np.array([cluster for floor in self.floors for cluster in floor.clusters], np.intp)

    @cached_property
    def _kernel(self) -> tuple[GraphHopper, Floats]:
        """The kernel of `areas`, and its Gram matrix."""
        from pianta.graphs.graph_hopper import GraphHopper

        kernel = GraphHopper().fit(self.areas)
        return kernel, kernel.compare()

    @cached_property
    def configurations(self) -> Counts:
        """V: the number of areas of each cluster on each floor, shape (floors, clusters)."""
        return np.array([self.count_clusters(floor) for floor in self.floors])

    @cached_property
    def door_counts(self) -> list[int]:
        """The number of cuts of each edge of the functional graphs, sorted; [1] if there are no edges."""
        return sorted(len(cuts) for floor in self.floors for cuts in floor.cuts.values()) or [1]

    def count_clusters(self, floor: TypeFloor) -> Counts:
        """V of a floor: the number of its areas in each cluster.

        Parameters
        ----------
        floor
            A floor with areas in the clusters of this model.

        Returns
        -------
        numpy.ndarray
            Shape (clusters,).
        """
        return np.bincount(floor.clusters, minlength=int(self.clusters.max()) + 1).astype(np.int64)

    def assign_clusters(self, areas: Iterable[nx.Graph]) -> list[int]:
        """The cluster of the most similar area of the model, for each area.

        Parameters
        ----------
        areas
            Functional areas, with a `label` at each node.

        Returns
        -------
        list of int
            Similar are areas that are similar to the same areas, as for the clusters of the model.
        """
        kernel, gram = self._kernel
        nearest = [int(((gram - row) ** 2).sum(axis=1).argmin()) for row in kernel.compare(areas)]
        clusters: list[int] = self.clusters[nearest].tolist()
        return clusters

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

    graphs: as of `Floor.graph`.
    Raises ModelError for fewer than two floors, and for invalid floors, with the fault of each.
    """
    prepared, faults = [], []
    for number, graph in enumerate(graphs, 1):
        try:
            prepared.append(prepare_room_graph(graph, schema))
        except (GraphError, LabelError) as error:
            faults.append(f"floor {short_repr(graph.graph.get('source') or number)}: {error}")
    if faults:
        raise ModelError(join_faults(faults))
    if len(prepared) < MIN_FLOORS:
        raise ModelError(f"{len(prepared)} floor{'s' * (len(prepared) != 1)} given, give two at least, better dozens")
    # 7.3.1: divide each graph into functional areas, which defines its functional graph as well.
    areas = [_segment(graph, schema, segmentation) for graph in prepared]
    # 7.3.2: cluster similar areas of all graphs.
    parts = [area_subgraph(graph, area) for graph, own in zip(prepared, areas, strict=True) for area in own]
    clusters = cluster_areas(compare_areas(parts, kernel=kernel), segmentation=segmentation).tolist()
    ends = np.cumsum([len(own) for own in areas]).tolist()
    floors = [
        TypeFloor(graph.graph["source"], graph, own, tuple(clusters[end - len(own) : end]))
        for graph, own, end in zip(prepared, areas, ends, strict=True)
    ]
    return TypeModel(schema, segmentation, tuple(floors))


def check_model_type(building_type: str | None, model: TypeModel, name: str) -> None:
    """Raise ModelError, with the name of the floor, if its type differs from that of the model; None is any type."""
    if building_type is not None and building_type != model.building_type:
        message = f"{name} is of type {short_repr(building_type)} and the model of {short_repr(model.building_type)}"
        raise ModelError(f"{message}, give a model of type {short_repr(building_type)}")


def assign_area_clusters(graph: nx.Graph, model: TypeModel) -> TypeFloor:
    """Divide a new floor into functional areas, and assign each to the cluster of the most similar area of a model.

    graph: as for `learn_type`. The nodes of the result have their original names as `room`.
    Raises GraphError and LabelError as `prepare_room_graph`.
    """
    prepared = prepare_room_graph(graph, model.schema)
    areas = _segment(prepared, model.schema, model.segmentation)
    clusters = model.assign_clusters([area_subgraph(prepared, area) for area in areas])
    return TypeFloor(prepared.graph["source"], prepared, areas, tuple(clusters))


def prepare_room_graph(graph: nx.Graph, schema: LabelSchema) -> nx.Graph:
    """Prepare the graph of a floor for a model: nodes 0 … n - 1, each with its `label` and its original name, `room`.

    Nodes and edges keep their measures, of ROOM_MEASURES and DOOR_MEASURES, and edges whether they are
    openings. Rooms without a door are left out, as in Table 5.1.
    Raises LabelError with the rooms without a label, or with labels outside the schema; and GraphError for a floor
    without doors or with more than 1000 rooms, and for a graph that is not connected, is directed, or has self-loops.
    """
    if graph.is_directed() or graph.is_multigraph():
        raise GraphError(f"it is a {type(graph).__name__}, give a networkx.Graph without directions and parallel edges")
    if loops := [*nx.nodes_with_selfloops(graph)]:
        raise GraphError(f"doors of rooms {name_some(loops)} lead to the same room, remove them")
    joined = drop_isolated(graph)
    if unlabelled := [node for node, label in joined.nodes(data="label") if label is None]:
        raise LabelError(f"rooms {name_some(unlabelled)} have no label, label them")
    if unnamed := [node for node, label in joined.nodes(data="label") if not isinstance(label, str)]:
        raise LabelError(f"the labels of rooms {name_some(unnamed)} are not text, give text")
    find_corridors(joined, schema)
    if not len(joined):
        raise GraphError("no door connects two of its rooms, add doors or leave it out")
    if len(joined) > MAX_ROOMS:
        raise GraphError(f"it has {len(joined)} rooms, give floors with at most {MAX_ROOMS}")
    if (parts := nx.number_connected_components(joined)) > 1:
        raise GraphError(f"its rooms are in {parts} parts without a door between them, add doors or leave it out")
    numbers = {node: number for number, node in enumerate(joined)}
    prepared = nx.Graph(source=str(graph.graph.get("source", "")))
    for node, room in joined.nodes(data=True):
        names = {"label": standard_name(room["label"]), "room": node}
        prepared.add_node(numbers[node], **names, **list_measures(room, ROOM_MEASURES))
    prepared.add_edges_from(
        (numbers[one], numbers[other], list_door_attributes(door)) for one, other, door in joined.edges(data=True)
    )
    return prepared


def size_attribute(attributes: Mapping[str, Any]) -> dict[str, float]:
    """The `area` of a room, m², as an attribute; no attribute if it is not a number above 0."""
    return list_measures(attributes, {"area": ROOM_MEASURES["area"]})


def area_subgraph(graph: nx.Graph, area: Area) -> nx.Graph:
    """The subgraph of an area, its nodes in the order of the graph."""
    part = nx.Graph()
    part.add_nodes_from((node, dict(attributes)) for node, attributes in graph.nodes(data=True) if node in area)
    part.add_edges_from((one, other) for one, other in graph.edges if one in area and other in area)
    return part


def count_labels(graphs: Iterable[nx.Graph], schema: LabelSchema) -> Counts:
    """Number of nodes with each label of a schema, shape (graphs, labels)."""
    columns = {name: column for column, name in enumerate(schema.by_name)}
    labels = [[columns[label] for _, label in graph.nodes(data="label")] for graph in graphs]
    counts = [np.bincount(numbers, minlength=len(columns)) for numbers in labels]
    return np.array(counts, np.int64).reshape(-1, len(columns))


def _segment(graph: nx.Graph, schema: LabelSchema, segmentation: Segmentation) -> tuple[Area, ...]:
    corridors = find_corridors(graph, schema, convention=LabelConvention.GRAPHS)
    return find_functional_areas(graph, corridors, segmentation=segmentation)
