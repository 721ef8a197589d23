"""Expected area behind each frontier: the rest of the room that it lies in, and the predicted rooms beyond."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import networkx as nx
import numpy as np

from pianta.errors import GraphError, LabelError
from pianta.exploration.recognised_rooms import RecognisedRooms
from pianta.labels import standard_name
from pianta.prediction.explored_part import read_explored_part
from pianta.prediction.prediction import assign_unseen_rooms
from pianta.prediction.unexplored_part import FloorSampler, SampledFloor

# Floors that are sampled, without moves of steps 2 and 4: the numbers of rooms do not depend on these. By hand.
SAMPLES = 16
# While a room has a frontier, it is at least this many times as large as its observed part. By hand.
MIN_GROWTH = 1.05
# Area of a room if the model has no areas at all, m². By hand.
DEFAULT_AREA = 20.0


@dataclass(frozen=True, eq=False)
class Beyond:
    """Expected rooms beyond the open ends, the mean over samples.

    area: of all unknown rooms nearest to an end, m². hit: the probability that one of them has the wanted label.
    Keys: the id of an open room, or `-1 - number` of an unopened door.
    """

    area: Mapping[int, float] = field(default_factory=dict)
    hit: Mapping[int, float] = field(default_factory=dict)


class RoomExpectations:
    """What the floors of a model let one expect of a building; a prediction is reused until the graph changes.

    find: the wanted label.
    """

    def __init__(self, sampler: FloorSampler, *, find: str | None = None, samples: int = SAMPLES) -> None:
        self.sampler, self.samples = sampler, samples
        self.find = None if find is None else standard_name(find)
        areas: dict[str, list[float]] = {}
        for floor in sampler.model.floors:
            for _, attributes in floor.graph.nodes(data=True):
                if "area" in attributes:
                    areas.setdefault(attributes["label"], []).append(attributes["area"])
        self._areas = {label: np.array(values, float) for label, values in areas.items()}
        self._all_areas = np.concatenate([*self._areas.values()]) if areas else np.array([DEFAULT_AREA])
        self._cached: tuple[object, Beyond] | None = None

    def expect_rest(self, label: str | None, observed: float) -> float:
        """The expected area, m², of the part of a room that is not observed, from its label and its observed area."""
        areas = self._areas.get(label or "", self._all_areas)
        larger = areas[areas > MIN_GROWTH * observed]
        return float((larger - observed).mean()) if len(larger) else (MIN_GROWTH - 1) * observed

    def predict_beyond(self, recognised: RecognisedRooms, open_rooms: Sequence[int]) -> Beyond:
        """Predict what lies beyond open rooms and unopened doors."""
        graph = nx.Graph()
        for room in recognised.rooms:
            graph.add_node(room.id, label=room.label, partial=room.id in open_rooms or room.label is None)
        graph.add_edges_from(door.rooms for door in recognised.floor.doors)
        for near, number in recognised.unopened:
            graph.add_node(-1 - number, label=None, partial=True)
            graph.add_edge(near, -1 - number)
        key = (tuple(graph.nodes(data="partial")), tuple(sorted(map(sorted, graph.edges))))
        if self._cached is None or self._cached[0] != key:
            self._cached = key, self._sample(graph)
        return self._cached[1]

    def _sample(self, graph: nx.Graph) -> Beyond:
        """Expected rooms beyond the open ends of a graph, by sampled whole floors; empty if it is no explored part."""
        try:
            explored = read_explored_part(graph, self.sampler.model.schema)
        except (GraphError, LabelError):
            return Beyond()
        samples = self.sampler.sample(explored, range(self.samples), edge_moves=0, door_moves=0)
        unseen = [assign_unseen_rooms(sample, explored) for sample in samples]
        names = {end: explored.graph.nodes[end]["room"] for end in (*explored.open, *explored.doors)}
        return Beyond(
            {name: self._mean_area(samples, [rooms[end] for rooms in unseen]) for end, name in names.items()},
            {name: self._mean_hit(samples, [rooms[end] for rooms in unseen]) for end, name in names.items()},
        )

    def _mean_area(self, samples: Sequence[SampledFloor], behind: Sequence[Sequence[int]]) -> float:
        """Mean over samples of the area, m², of the rooms behind an end; a room without area has the median of all."""
        middle = float(np.median(self._all_areas))
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
