"""A floor of which a robot has explored a part, with the truth of the rest (thesis, section 8.3)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property

import networkx as nx

from pianta.errors import OptionError
from pianta.generation.type_model import prepare_room_graph
from pianta.graphs.labelled_graphs import name_some
from pianta.graphs.metrics import find_corridors
from pianta.labels import LabelConvention, LabelSchema
from pianta.prediction.explored_part import explore_by_corridors


@dataclass(frozen=True, eq=False)
class RevealedFloor:
    """A true floor and its explored part.

    graph: all rooms with a door, with `label` and optionally `area`, m². part: input of `read_explored_part`. behind:
    the room of `graph` behind each unopened door, by the name of the unknown room in `part`.
    """

    graph: nx.Graph
    part: nx.Graph
    behind: Mapping[Hashable, Hashable]

    @cached_property
    def unknown(self) -> tuple[Hashable, ...]:
        """The rooms outside of the explored part."""
        return tuple(node for node in self.graph if node not in self.part)

    @cached_property
    def counts(self) -> Mapping[str, int]:
        """Label -> number of unknown rooms, the most frequent first."""
        return dict(Counter(self.graph.nodes[node]["label"] for node in self.unknown).most_common())

    @property
    def shares(self) -> Mapping[str, float]:
        """Label -> share of the unknown rooms."""
        return {label: count / len(self.unknown) for label, count in self.counts.items()}

    @property
    def area(self) -> float | None:
        """Area of all rooms, m²; None if a room has no area."""
        sizes = [area for _, area in self.graph.nodes(data="area")]
        return None if None in sizes else float(sum(sizes))


def reveal_corridors(graph: nx.Graph, schema: LabelSchema, *, corridors: int) -> RevealedFloor:
    """Explore the first corridors of a floor, as `explore_by_corridors` does.

    graph: as of `Floor.graph`; rooms keep their names, rooms without a door are left out.
    Raises OptionError for a floor with partial rooms and for more corridors than the floor has, GraphError and
    LabelError as `prepare_room_graph`.
    """
    if partial := [node for node, is_partial in graph.nodes(data="partial", default=False) if is_partial is True]:
        raise OptionError(f"rooms {name_some(partial)} are partial, so it is no whole floor; predict it as it is")
    prepared = prepare_room_graph(graph, schema)
    stages = explore_by_corridors(prepared, find_corridors(prepared, schema, convention=LabelConvention.GRAPHS))
    if not 1 <= corridors <= len(stages):
        raise OptionError(f"the floor has {len(stages)} corridors, give 1 to {len(stages)} to explore, not {corridors}")
    part = stages[corridors - 1]
    names: dict[Hashable, Hashable] = dict(prepared.nodes(data="room"))
    behind: dict[Hashable, Hashable] = {}
    for door in [node for node in part if node not in names]:
        near, far = (names[int(number)] for number in str(door).split("-"))
        name = f"{near}-{far}"
        while name in graph or name in behind:
            name += "'"
        names[door], behind[name] = name, far
    complete = nx.relabel_nodes(prepared, {node: names[node] for node in prepared})
    return RevealedFloor(complete, nx.relabel_nodes(part, {node: names[node] for node in part}), behind)
