"""Costs of rooms with one door, by label: in real floors a corridor leads somewhere."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from math import log

from pianta.generation.type_model import TypeModel


def measure_dead_end_costs(model: TypeModel) -> Mapping[str, float]:
    """The log odds that a room of a label has more than one door, where they are positive.

    They are those of the floors of the model, with half a room with one door and half a room with more as prior.
    """
    rooms = Counter(label for floor in model.floors for _, label in floor.graph.nodes(data="label"))
    ends = Counter(
        label
        for floor in model.floors
        for node, label in floor.graph.nodes(data="label")
        if floor.graph.degree(node) == 1
    )
    costs = {label: log((count - ends[label] + 1 / 2) / (ends[label] + 1 / 2)) for label, count in rooms.items()}
    return {label: cost for label, cost in costs.items() if cost > 0}
