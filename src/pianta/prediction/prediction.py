"""What probably lies beyond the explored part of a floor (thesis, section 8.3)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import networkx as nx
import numpy as np

from pianta._arguments import check_argument
from pianta._types import Floats
from pianta.errors import GraphError, ModelError, OptionError
from pianta.floor import Floor
from pianta.generation.type_model import TypeModel
from pianta.graphs.metrics import find_corridors
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from pianta.io._files import short_repr
from pianta.labels import LabelConvention, LabelSchema
from pianta.prediction.explored_part import ExploredPart, read_explored_part
from pianta.prediction.unexplored_part import FloorSampler, SampledFloor

MAX_SAMPLES = 10_000
# Ends of the interval that four of five samples are in.
LOW, HIGH = 0.1, 0.9
# Steps to the distribution nearest to the samples', and the length of the first ones.
NEAREST_STEPS, RATE = 200, 2.0
LEAST_SHARE = 1e-9


@dataclass(frozen=True)
class Spread:
    """A number over all samples: its mean, and the ends of the interval that four of five are in.

    Attributes
    ----------
    mean
        The mean.
    low, high
        The quantiles 0.1 and 0.9.
    """

    mean: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Sequence[float] | Floats) -> Spread:
        """The spread of one number of each sample.

        Parameters
        ----------
        values
            The numbers, shape (samples,).

        Returns
        -------
        Spread
            Mean and quantiles.
        """
        low, high = np.quantile(values, (LOW, HIGH), method="nearest")
        return cls(float(np.mean(values)), float(low), float(high))


@dataclass(frozen=True)
class OpenEnd:
    """What may lie behind an unopened door, or further along an open corridor.

    Attributes
    ----------
    room
        The name of the unknown room behind the door, or of the corridor.
    near
        The room that the door is in; the corridor itself at its open end.
    labels
        Label -> probability, the most probable first, of the room behind the door; at a corridor, of any unknown room
        that opens into it.
    leads_on
        The probability that unexplored corridors are nearest to this end.
    rooms
        How many rooms are unknown and nearer to this end than to others.
    area
        Of these rooms, m²; None where the model has no sizes.
    """

    room: Hashable
    near: Hashable
    labels: Mapping[str, float]
    leads_on: float
    rooms: Spread
    area: Spread | None

    @property
    def is_door(self) -> bool:
        """Whether it is an unopened door, not the open end of a corridor."""
        return self.room != self.near


@dataclass(frozen=True, eq=False)
class Prediction:
    """The explored part of a floor, whole floors sampled around it, and what these tell together.

    Attributes
    ----------
    explored
        What is known, and its open ends.
    samples
        Whole floors that continue what is known.
    schema
        The labels of the model.
    average
        Label -> share of the rooms of a floor of the model, the blind guess.
    """

    explored: ExploredPart
    samples: tuple[SampledFloor, ...]
    schema: LabelSchema
    average: Mapping[str, float]

    @cached_property
    def rooms(self) -> Spread:
        """Rooms of the whole floor, corridors included."""
        return Spread.of([len(sample.graph) for sample in self.samples])

    @cached_property
    def area(self) -> Spread | None:
        """Area of all rooms of the floor, m²; None where a room has no size."""
        sizes = [[area for _, area in sample.graph.nodes(data="area")] for sample in self.samples]
        if any(area is None for of_sample in sizes for area in of_sample):
            return None
        return Spread.of([sum(of_sample) for of_sample in sizes])

    @cached_property
    def counts(self) -> Mapping[str, Spread]:
        """Unknown rooms by label, the most frequent first; labels that some sample has."""
        spreads = {
            label: Spread.of(column)
            for label, column in zip(self.schema.by_name, self._label_counts.T, strict=True)
            if column.any()
        }
        return dict(sorted(spreads.items(), key=lambda item: -item[1].mean))

    @cached_property
    def shares(self) -> Mapping[str, float]:
        """Label -> share of the unknown rooms: the distribution that diverges least from the samples' own on average.

        A sample counts as often as it has unknown rooms. The mean would tell of too many labels: few rooms have few.
        Nothing where no sample has any.
        """
        counts = self._label_counts[self._label_counts.sum(axis=1) > 0]
        if not len(counts):
            return {}
        nearest = find_nearest_distribution(counts)
        shares = zip(self.schema.by_name, nearest.tolist(), strict=True)
        return {label: share for label, share in shares if share > LEAST_SHARE}

    @cached_property
    def ends(self) -> tuple[OpenEnd, ...]:
        """Every unopened door and open corridor, in the order of the explored part."""
        shared = [share_unseen(sample, self.explored) for sample in self.samples]
        corridors = [self._list_corridors(sample.graph) for sample in self.samples]
        return tuple(self._tell_end(end, shared, corridors) for end in (*self.explored.open, *self.explored.doors))

    @cached_property
    def skeleton(self) -> nx.Graph:
        """Corridors that are known, and what may be corridors behind open ends; `probability` at each node and edge.

        Nodes are named as in the graph that was given, and what lies behind an open corridor `("beyond", name)`. An
        edge between two ends says how often a sample joins them through unknown corridors alone.
        """
        explored = self.explored
        names = dict(explored.graph.nodes(data="room"))
        graph = nx.Graph()
        graph.add_nodes_from(((names[node]), {"probability": 1.0}) for node in sorted(explored.corridors))
        known = explored.known.subgraph(explored.corridors)
        graph.add_edges_from(((names[one], names[other]) for one, other in known.edges), probability=1.0)
        found: Counter[tuple[Hashable, Hashable]] = Counter()
        for sample in self.samples:
            found.update(_list_skeleton_edges(sample, explored, self._list_corridors(sample.graph)))
        for (one, other), count in sorted(found.items(), key=str):
            graph.add_edge(one, other, probability=count / len(self.samples))
        for node in graph:
            edges = [probability for *_, probability in graph.edges(node, data="probability")]
            graph.nodes[node].setdefault("probability", max(edges, default=0.0))
        return graph

    @cached_property
    def typical(self) -> SampledFloor:
        """The sample that is most like the others, by the Weisfeiler-Lehman kernel of whole floors."""
        similarity = WeisfeilerLehman(iterations=2).fit([sample.graph for sample in self.samples]).compare()
        distances = np.sqrt(np.maximum(2 - 2 * similarity, 0))
        return self.samples[int(distances.sum(axis=0).round(9).argmin())]

    def take_skeleton(self, sample: SampledFloor) -> nx.Graph:
        """The corridors of a sample and the edges between them.

        Parameters
        ----------
        sample
            One of `samples`.

        Returns
        -------
        networkx.Graph
            A part of the graph of the sample.
        """
        skeleton: nx.Graph = sample.graph.subgraph(sorted(self._list_corridors(sample.graph))).copy()
        return skeleton

    @cached_property
    def _label_counts(self) -> Floats:
        """Unknown rooms of each label of the schema in each sample, shape (samples, labels)."""
        columns = {label: column for column, label in enumerate(self.schema.by_name)}
        counts = np.zeros((len(self.samples), len(columns)))
        for row, sample in enumerate(self.samples):
            for node in sample.unseen:
                counts[row, columns[sample.graph.nodes[node]["label"]]] += 1
        return counts

    def _list_corridors(self, graph: nx.Graph) -> set[int]:
        corridors = find_corridors(graph, self.schema, convention=LabelConvention.GRAPHS)
        return {node for node in graph if node in corridors}

    def _tell_end(
        self, end: int, shared: Sequence[Mapping[int, Sequence[int]]], corridors: Sequence[set[int]]
    ) -> OpenEnd:
        explored = self.explored
        names: Counter[str] = Counter()
        for sample, of_ends in zip(self.samples, shared, strict=True):
            at_end = [sample.behind[end]] if end in sample.behind else []
            if end in explored.open:
                at_end = [node for node in sample.graph[sample.known[end]] if node in of_ends[end]]
            names.update(sample.graph.nodes[node]["label"] for node in at_end)
        behind = [of_ends[end] for of_ends in shared]
        on = [bool(corridors[number].intersection(rooms)) for number, rooms in enumerate(behind)]
        sizes = [
            [sample.graph.nodes[node].get("area") for node in rooms]
            for sample, rooms in zip(self.samples, behind, strict=True)
        ]
        has_sizes = all(size is not None for of_sample in sizes for size in of_sample)
        room = explored.graph.nodes[end]["room"]
        return OpenEnd(
            room,
            explored.graph.nodes[explored.doors.get(end, end)]["room"],
            {label: count / names.total() for label, count in names.most_common()},
            float(np.mean(on)),
            Spread.of([len(rooms) for rooms in behind]),
            Spread.of([sum(of_sample) for of_sample in sizes]) if has_sizes else None,
        )


def predict(floor: Floor | nx.Graph, model: TypeModel | FloorSampler, *, count: int = 100, seed: int = 0) -> Prediction:
    """Predict what lies beyond the explored part of a floor (thesis, section 8.3).

    The command `pianta predict` calls this function.

    Parameters
    ----------
    floor
        A floor that is explored in part, its rooms with labels of the model's type; or its graph, as
        `Floor.graph` gives it. It goes on where rooms were seen in part.
    model
        Model of the building's type, with functional areas by "corr"; or its sampler, which spares work when many
        floors are predicted.
    count
        How many floors are sampled.
    seed
        The same seed gives the same prediction.

    Returns
    -------
    Prediction
        What is expected behind each open end, and the sampled floors.

    Raises
    ------
    GraphError
        The floor is explored already, or nothing is known of it.
    LabelError
        The floor has labels that the model does not have.
    OptionError
        `count` or `seed` is out of range, or the model's areas are by "ncut".
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
    if not 1 <= count <= MAX_SAMPLES:
        raise OptionError(f"{count} samples are wanted, give 1 to {MAX_SAMPLES}")
    if seed < 0:
        raise OptionError(f"seed is {seed}, give 0 or more")
    sampler = model if isinstance(model, FloorSampler) else FloorSampler(model)
    if isinstance(floor, Floor):
        check_model_type(floor.given_type, sampler.model, f"floor {short_repr(floor.source)}")
    graph = floor.graph() if isinstance(floor, Floor) else floor
    explored = read_explored_part(graph, sampler.model.schema)
    if not explored.open_ends:
        raise GraphError("no door of it is unopened and no corridor goes on, so there is nothing to predict")
    samples = tuple(sampler.sample(explored, range(count), seed=seed))
    return Prediction(explored, samples, sampler.model.schema, sampler.label_shares)


def check_model_type(building_type: str | None, model: TypeModel, name: str) -> None:
    """Refuse a floor of another type than the model's; None is any type. name: how the message calls the floor.

    Raises ModelError, in one line.
    """
    if building_type is not None and building_type != model.building_type:
        message = f"{name} is of type {short_repr(building_type)} and the model of {short_repr(model.building_type)}"
        raise ModelError(f"{message}, give a model of type {short_repr(building_type)}")


def share_unseen(sample: SampledFloor, explored: ExploredPart) -> dict[int, list[int]]:
    """The unknown rooms of a sample that are nearest to each open end, in hops; of two as near, to the first."""
    first = {sample.known[end]: end for end in explored.open}
    for end in explored.doors:
        if end in sample.behind:
            first.setdefault(sample.behind[end], end)
    shared: dict[int, list[int]] = {end: [] for end in (*explored.open, *explored.doors)}
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
            shared[end].append(node)
    return shared


def find_nearest_distribution(counts: Floats) -> Floats:
    """The distribution, shape (labels,), whose Jensen-Shannon divergence from those of some counts is least on average.

    counts: shape (n, labels), rows weighted by their sums, which are above 0. By exponentiated gradient descent.
    """
    weights = counts.sum(axis=1)
    rows = counts / weights[:, None]
    weights = weights / weights.sum()
    nearest = weights @ rows + LEAST_SHARE
    nearest /= nearest.sum()
    for _ in range(NEAREST_STEPS):
        gradient = weights @ np.log2(nearest / ((rows + nearest) / 2)) / 2
        nearest = np.maximum(nearest * np.exp(-RATE * (gradient - nearest @ gradient)), LEAST_SHARE)
        nearest /= nearest.sum()
    found: Floats = nearest
    return found


def _list_skeleton_edges(
    sample: SampledFloor, explored: ExploredPart, corridors: set[int]
) -> set[tuple[Hashable, Hashable]]:
    """The edges of one sample for `Prediction.skeleton`, each once."""
    names = dict(explored.graph.nodes(data="room"))
    unseen = corridors.intersection(sample.unseen)
    parts = [*nx.connected_components(sample.graph.subgraph(unseen))]
    edges: set[tuple[Hashable, Hashable]] = set()
    ends: dict[Hashable, Hashable] = {}
    for corridor in explored.open:
        ends[names[corridor]] = ("beyond", names[corridor])
    for part in parts:
        at_part: list[Hashable] = []
        for corridor in explored.open:
            if part.intersection(sample.graph[sample.known[corridor]]):
                edges.add((names[corridor], ends[names[corridor]]))
                at_part.append(ends[names[corridor]])
        for door, near in explored.doors.items():
            if sample.behind.get(door) in part:
                at_part.append(names[door])
                if near in explored.corridors:
                    edges.add((names[near], names[door]))
        ordered = sorted(at_part, key=str)
        edges.update((one, other) for place, one in enumerate(ordered) for other in ordered[place + 1 :])
    return edges
