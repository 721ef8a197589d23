"""What a robot expects behind each frontier: the rest of the room it lies in, and what is predicted beyond it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.errors import GraphError, LabelError
from pianta.exploration.perception import Perception
from pianta.labels import standard_name
from pianta.prediction.explored_part import read_explored_part
from pianta.prediction.prediction import share_unseen
from pianta.prediction.unexplored_part import FloorSampler, SampledFloor

# Floors that are sampled, without moving what is drawn: the numbers of rooms are drawn already.
SAMPLES = 16
# A room is taken to be larger than what was seen of it by this much at least, while it has a frontier.
LEAST_REST = 1.05


@dataclass(frozen=True, eq=False)
class Beyond:
    """What lies beyond the open ends of what was seen, on average of some samples.

    area: m² of all unknown rooms nearest to an end; hit: the probability that one of these has the label that is looked
    for. Both by the room that is open, or by `-1 - number` of an unopened door.
    """

    area: Mapping[int, float] = field(default_factory=dict)
    hit: Mapping[int, float] = field(default_factory=dict)


class RoomExpectations:
    """What the floors of a model let expect of a building; predictions are kept while nothing new is seen.

    find: the label of the room that is looked for.
    """

    def __init__(self, sampler: FloorSampler, *, find: str | None = None, samples: int = SAMPLES) -> None:
        self.sampler, self.samples = sampler, samples
        self.find = None if find is None else standard_name(find)
        self._sizes: dict[str, Floats] = {}
        for floor in sampler.model.floors:
            for _, attributes in floor.graph.nodes(data=True):
                if "area" in attributes:
                    found = self._sizes.setdefault(attributes["label"], np.zeros(0))
                    self._sizes[attributes["label"]] = np.append(found, attributes["area"])
        self._all_sizes = np.concatenate([*self._sizes.values()]) if self._sizes else np.array([20.0])
        self._known: tuple[object, Beyond] | None = None

    def expect_rest(self, label: str | None, seen: float) -> float:
        """How many more m² a room of a label has, of which so many were seen and some were not."""
        sizes = self._sizes.get(label or "", self._all_sizes)
        larger = sizes[sizes > LEAST_REST * seen]
        # A room that is larger than all that are known ends soon.
        return float((larger - seen).mean()) if len(larger) else (LEAST_REST - 1) * seen

    def predict_beyond(self, seen: Perception, open_rooms: Sequence[int]) -> Beyond:
        """What lies beyond open rooms and unopened doors."""
        graph = nx.Graph()
        for room in seen.rooms:
            graph.add_node(room.id, label=room.label, partial=room.id in open_rooms or room.label is None)
        graph.add_edges_from(door.rooms for door in seen.floor.doors)
        for near, number in seen.unopened:
            graph.add_node(-1 - number, label=None, partial=True)
            graph.add_edge(near, -1 - number)
        key = (tuple(graph.nodes(data="partial")), tuple(sorted(map(sorted, graph.edges))))
        if self._known is None or self._known[0] != key:
            self._known = key, self._sample(graph)
        return self._known[1]

    def _sample(self, graph: nx.Graph) -> Beyond:
        try:
            explored = read_explored_part(graph, self.sampler.model.schema)
        except (GraphError, LabelError):
            return Beyond()
        samples = self.sampler.sample(explored, range(self.samples), edge_moves=0, door_moves=0)
        shared = [share_unseen(sample, explored) for sample in samples]
        names = {end: explored.graph.nodes[end]["room"] for end in (*explored.open, *explored.doors)}
        return Beyond(
            {name: self._mean_area(samples, [of_ends[end] for of_ends in shared]) for end, name in names.items()},
            {name: self._mean_hit(samples, [of_ends[end] for of_ends in shared]) for end, name in names.items()},
        )

    def _mean_area(self, samples: Sequence[SampledFloor], behind: Sequence[Sequence[int]]) -> float:
        middle = float(np.median(self._all_sizes))
        areas = [
            sum(sample.graph.nodes[node].get("area", middle) for node in rooms)
            for sample, rooms in zip(samples, behind, strict=True)
        ]
        return float(np.mean(areas))

    def _mean_hit(self, samples: Sequence[SampledFloor], behind: Sequence[Sequence[int]]) -> float:
        hits = [
            any(sample.graph.nodes[node]["label"] == self.find for node in rooms)
            for sample, rooms in zip(samples, behind, strict=True)
        ]
        return float(np.mean(hits))
