"""Prediction of the unexplored part of a floor (thesis, section 8.3)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import networkx as nx
import numpy as np

from pianta._arguments import check_argument
from pianta._types import Floats
from pianta.errors import GraphError, OptionError
from pianta.floor import Floor
from pianta.generation.type_model import TypeModel, check_model_type
from pianta.graphs.metrics import find_corridors
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from pianta.io._files import short_repr
from pianta.labels import LabelConvention, LabelSchema
from pianta.prediction.explored_part import ExploredPart, read_explored_part
from pianta.prediction.label_distributions import MIN_SHARE, find_nearest_distribution, mix_labels
from pianta.prediction.printed_sampler import PrintedSampler
from pianta.prediction.unexplored_part import FloorSampler, SampledFloor

MAX_SAMPLES = 10_000
# Quantiles of a SampleInterval.
LOW_QUANTILE = 0.1
HIGH_QUANTILE = 0.9


@dataclass(frozen=True)
class SampleInterval:
    """The mean of a number over all samples, and the interval of four fifths of them.

    Attributes
    ----------
    mean
        Over the samples.
    low, high
        The quantiles 0.1 and 0.9.
    """

    mean: float
    low: float
    high: float

    @classmethod
    def from_values(cls, values: Sequence[float] | Floats) -> SampleInterval:
        """The interval of one number of each sample.

        Parameters
        ----------
        values
            The numbers, shape (samples,).

        Returns
        -------
        SampleInterval
            Mean and quantiles.
        """
        low, high = np.quantile(values, (LOW_QUANTILE, HIGH_QUANTILE), method="nearest")
        return cls(float(np.mean(values)), float(low), float(high))


@dataclass(frozen=True)
class OpenEnd:
    """The expected rooms behind an unopened door, or along the rest of an open corridor.

    Attributes
    ----------
    room
        The name of the unknown room behind the door, or of the corridor.
    near
        The room with the door; the corridor itself at its open end.
    labels
        Label -> probability, the most probable first. Of the room behind the door: the mean of its share of samples
        and of its frequency behind similar doors. At a corridor, of the unknown rooms with a door to it.
    sampled
        As `labels`, from the samples alone.
    leads_on
        The probability that an unexplored corridor is nearer to this end than to others.
    rooms
        Number of unknown rooms that are nearer to this end than to others.
    area
        Of these rooms, m²; None if the model has no areas.
    """

    room: Hashable
    near: Hashable
    labels: Mapping[str, float]
    sampled: Mapping[str, float]
    leads_on: float
    rooms: SampleInterval
    area: SampleInterval | None

    @property
    def name(self) -> str:
        """The names of both rooms, which stay as long as rooms keep their ids."""
        return f"{self.near}-{self.room}"

    @property
    def is_door(self) -> bool:
        """Whether it is an unopened door; otherwise it is an open corridor."""
        return self.room != self.near


@dataclass(frozen=True, eq=False)
class Prediction:
    """The explored part of a floor, whole floors sampled around it, and their statistics.

    Attributes
    ----------
    explored
        The explored part, with its open ends.
    samples
        Whole floors that contain the explored part.
    schema
        The labels of the model.
    average
        Label -> mean share of the rooms of a floor of the model: the baseline.
    similar_doors
        Unknown room behind a door -> label -> its frequency behind similar doors of the model; empty for samples as
        printed.
    """

    explored: ExploredPart
    samples: tuple[SampledFloor, ...]
    schema: LabelSchema
    average: Mapping[str, float]
    similar_doors: Mapping[int, Mapping[str, float]] = field(default_factory=dict)

    @cached_property
    def rooms(self) -> SampleInterval:
        """Number of rooms of the whole floor, corridors included."""
        return SampleInterval.from_values([len(sample.graph) for sample in self.samples])

    @cached_property
    def area(self) -> SampleInterval | None:
        """Area of all rooms of the floor, m²; None if a room has no area."""
        sizes = [[area for _, area in sample.graph.nodes(data="area")] for sample in self.samples]
        return None if any(None in areas for areas in sizes) else SampleInterval.from_values([*map(sum, sizes)])

    @cached_property
    def counts(self) -> Mapping[str, SampleInterval]:
        """Number of unknown rooms by label, the most frequent first; labels of all samples."""
        intervals = {
            label: SampleInterval.from_values(column)
            for label, column in zip(self.schema.by_name, self._label_counts.T, strict=True)
            if column.any()
        }
        return dict(sorted(intervals.items(), key=lambda item: -item[1].mean))

    @cached_property
    def shares(self) -> Mapping[str, float]:
        """Label -> share of the unknown rooms: the distribution with the least mean divergence from the samples' own.

        Samples are weighted by their unknown rooms. The mean would spread over too many labels, because a few rooms
        have few labels. Empty if no sample has unknown rooms.
        """
        counts = self._label_counts[self._label_counts.sum(axis=1) > 0]
        if not len(counts):
            return {}
        nearest = find_nearest_distribution(counts)
        shares = zip(self.schema.by_name, nearest.tolist(), strict=True)
        return {label: share for label, share in shares if share > MIN_SHARE}

    @cached_property
    def ends(self) -> tuple[OpenEnd, ...]:
        """Every unopened door and open corridor, in the order of the explored part."""
        unseen = [assign_unseen_rooms(sample, self.explored) for sample in self.samples]
        corridors = [self._list_corridors(sample.graph) for sample in self.samples]
        return tuple(self._describe_end(end, unseen, corridors) for end in (*self.explored.open, *self.explored.doors))

    @cached_property
    def skeleton(self) -> nx.Graph:
        """Known corridors, and possible corridors behind open ends; `probability` at each node and edge.

        Nodes are named as in the input graph; the space behind an open corridor is `("beyond", name)`. An edge between
        two ends has the share of samples that join them through unknown corridors alone.
        """
        explored = self.explored
        names = dict(explored.graph.nodes(data="room"))
        graph = nx.Graph()
        graph.add_nodes_from(((names[node]), {"probability": 1.0}) for node in sorted(explored.corridors))
        edges = explored.known_graph.subgraph(explored.corridors).edges
        graph.add_edges_from(((names[one], names[other]) for one, other in edges), probability=1.0)
        counts: Counter[tuple[Hashable, Hashable]] = Counter()
        for sample in self.samples:
            counts.update(_list_skeleton_edges(sample, explored, self._list_corridors(sample.graph)))
        for (one, other), count in sorted(counts.items(), key=str):
            graph.add_edge(one, other, probability=count / len(self.samples))
        for node in graph:
            probabilities = [probability for *_, probability in graph.edges(node, data="probability")]
            graph.nodes[node].setdefault("probability", max(probabilities, default=0.0))
        return graph

    @cached_property
    def typical(self) -> SampledFloor:
        """The sample most similar to the others, by the Weisfeiler-Lehman kernel of whole floors."""
        similarity = WeisfeilerLehman(iterations=2).fit([sample.graph for sample in self.samples]).compare()
        distances = np.sqrt(np.maximum(2 - 2 * similarity, 0))
        return self.samples[int(distances.sum(axis=0).round(9).argmin())]

    def corridor_graph(self, sample: SampledFloor) -> nx.Graph:
        """The corridors of a sample and the edges between them.

        Parameters
        ----------
        sample
            One of `samples`.

        Returns
        -------
        networkx.Graph
            A subgraph of the graph of the sample.
        """
        skeleton: nx.Graph = sample.graph.subgraph(sorted(self._list_corridors(sample.graph))).copy()
        return skeleton

    @cached_property
    def _label_counts(self) -> Floats:
        """Number of unknown rooms of each label of the schema, shape (samples, labels)."""
        columns = {label: column for column, label in enumerate(self.schema.by_name)}
        counts = np.zeros((len(self.samples), len(columns)))
        for row, sample in enumerate(self.samples):
            for node in sample.unseen:
                counts[row, columns[sample.graph.nodes[node]["label"]]] += 1
        return counts

    def _list_corridors(self, graph: nx.Graph) -> set[int]:
        corridors = find_corridors(graph, self.schema, convention=LabelConvention.GRAPHS)
        return {node for node in graph if node in corridors}

    def _describe_end(
        self, end: int, unseen: Sequence[Mapping[int, Sequence[int]]], corridors: Sequence[set[int]]
    ) -> OpenEnd:
        """Statistics of an open end over all samples; unseen: rooms by end, corridors: rooms, both for each sample."""
        explored = self.explored
        behind = [rooms[end] for rooms in unseen]
        labels: Counter[str] = Counter()
        for sample, rooms in zip(self.samples, behind, strict=True):
            at_end = [sample.behind[end]] if end in sample.behind else []
            if end in explored.open:
                at_end = [node for node in sample.graph[sample.known_nodes[end]] if node in rooms]
            labels.update(sample.graph.nodes[node]["label"] for node in at_end)
        has_corridor = [bool(nodes.intersection(rooms)) for nodes, rooms in zip(corridors, behind, strict=True)]
        sizes = [
            [sample.graph.nodes[node].get("area") for node in rooms]
            for sample, rooms in zip(self.samples, behind, strict=True)
        ]
        room = explored.graph.nodes[end]["room"]
        sampled = {label: count / labels.total() for label, count in labels.most_common()}
        return OpenEnd(
            room,
            explored.graph.nodes[explored.doors.get(end, end)]["room"],
            mix_labels(sampled, self.similar_doors.get(end, {})),
            sampled,
            float(np.mean(has_corridor)),
            SampleInterval.from_values([len(rooms) for rooms in behind]),
            None if any(None in areas for areas in sizes) else SampleInterval.from_values([*map(sum, sizes)]),
        )


def predict(
    floor: Floor | nx.Graph,
    model: TypeModel | FloorSampler,
    *,
    count: int = 100,
    seed: int = 0,
    as_printed: bool = False,
) -> Prediction:
    """Predict the unexplored part of a floor (thesis, section 8.3).

    The command `pianta predict` calls this function.

    Parameters
    ----------
    floor
        A partly explored floor, with labels of the model's type; or its graph, as of `Floor.graph`. It continues at
        partial rooms.
    model
        Model of the building's type, with functional areas by "corr"; or its sampler, which saves work for many
        floors.
    count
        Number of sampled floors.
    seed
        The same seed gives the same prediction.
    as_printed
        Sample as section 8.3 is printed, to compare; takes some ten times as long.

    Returns
    -------
    Prediction
        The expected rooms behind each open end, and the sampled floors.

    Raises
    ------
    GraphError
        The floor has no open end, or no known room.
    LabelError
        The floor has labels outside the schema of the model.
    OptionError
        `count` or `seed` is out of range, or the areas of the model are by "ncut".
    ModelError
        The model is of another building type than the floor, or has no corridors.

    References
    ----------
    M. Luperto, PhD thesis, section 8.3.

    Examples
    --------
    >>> import pianta
    >>> floor = pianta.read_floor("explored/floor.geojson")  # doctest: +SKIP
    >>> pianta.predict(floor, pianta.load_model("school.json")).rooms.mean  # doctest: +SKIP
    41.3
    """
    check_argument(floor, (Floor, nx.Graph), "floor", "a Floor of read, or its graph")
    check_argument(model, (TypeModel, FloorSampler), "model", "a model of train_type or load_model")
    check_samples(count, seed)
    sampler = _choose_sampler(model, as_printed=as_printed)
    if isinstance(floor, Floor):
        check_model_type(floor.given_type, sampler.model, f"floor {short_repr(floor.source)}")
    graph = floor.graph() if isinstance(floor, Floor) else floor
    explored = read_explored_part(graph, sampler.model.schema)
    if not explored.open_ends:
        raise GraphError("no door of it is unopened and no corridor goes on, so there is nothing to predict")
    samples = tuple(sampler.sample(explored, range(count), seed=seed))
    similar = {} if isinstance(sampler, PrintedSampler) else sampler.doors.predict(explored)
    return Prediction(explored, samples, sampler.model.schema, sampler.label_shares, similar)


def check_samples(count: int, seed: int) -> None:
    """Raise OptionError for a number of samples, or a seed, out of range."""
    if not 1 <= count <= MAX_SAMPLES:
        raise OptionError(f"{count} samples are wanted, give 1 to {MAX_SAMPLES}")
    if seed < 0:
        raise OptionError(f"seed is {seed}, give 0 or more")


def _choose_sampler(model: TypeModel | FloorSampler, *, as_printed: bool) -> FloorSampler:
    """The sampler of a model, or the given one; the printed one if wanted."""
    if isinstance(model, PrintedSampler) or (isinstance(model, FloorSampler) and not as_printed):
        return model
    type_model = model.model if isinstance(model, FloorSampler) else model
    return PrintedSampler(type_model) if as_printed else FloorSampler(type_model)


def assign_unseen_rooms(sample: SampledFloor, explored: ExploredPart) -> dict[int, list[int]]:
    """The unknown rooms of a sample by their nearest open end, in hops; the first of equally near ones."""
    first = {sample.known_nodes[end]: end for end in explored.open}
    for end in explored.doors:
        if end in sample.behind:
            first.setdefault(sample.behind[end], end)
    assigned: dict[int, list[int]] = {end: [] for end in (*explored.open, *explored.doors)}
    unseen = {*sample.unseen}
    beyond = sample.graph.subgraph(unseen.union(first))
    nearest = dict(first)
    layer = [*first]
    while layer:
        following = []
        for node in layer:
            for near in beyond[node]:
                if near not in nearest:
                    nearest[near] = nearest[node]
                    following.append(near)
        layer = following
    for node, end in nearest.items():
        if node in unseen:
            assigned[end].append(node)
    return assigned


def _list_skeleton_edges(
    sample: SampledFloor, explored: ExploredPart, corridors: set[int]
) -> set[tuple[Hashable, Hashable]]:
    """The edges of one sample for `Prediction.skeleton`, each once."""
    names = dict(explored.graph.nodes(data="room"))
    unseen = corridors.intersection(sample.unseen)
    parts = [*nx.connected_components(sample.graph.subgraph(unseen))]
    edges: set[tuple[Hashable, Hashable]] = set()
    ends: dict[int, Hashable] = {corridor: ("beyond", names[corridor]) for corridor in explored.open}
    for part in parts:
        at_part: list[Hashable] = []
        for corridor in explored.open:
            if part.intersection(sample.graph[sample.known_nodes[corridor]]):
                edges.add((names[corridor], ends[corridor]))
                at_part.append(ends[corridor])
        for door, near in explored.doors.items():
            if sample.behind.get(door) in part:
                at_part.append(names[door])
                if near in explored.corridors:
                    edges.add((names[near], names[door]))
        ordered = sorted(at_part, key=str)
        edges.update((one, other) for index, one in enumerate(ordered) for other in ordered[index + 1 :])
    return edges
