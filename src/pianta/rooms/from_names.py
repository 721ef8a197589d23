"""What rooms are for, by their names and their geometry: names are evidence before the floor is labelled as a whole.

For each room, p(label | geometry, name) is proportional to p(label | geometry) p(name | label). The evidence of names
multiplies the probabilities of F/C/E/S after the first pass, so that a named entrance informs its neighbours, and again
before the random field. Labels of a building type are weighted within their function.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from pianta._types import Floats
from pianta.floor import Floor
from pianta.labels import LabelSchema
from pianta.rooms.features import RoomContext
from pianta.rooms.model import (
    FUNCTIONS,
    RoomModel,
    columns_by_function,
    describe_neighbours,
    find_labelled_type,
    find_neighbourhood,
)
from pianta.rooms.name_dictionary import (
    RoomNameDictionary,
    read_default_room_name_dictionary,
    room_name_prior,
)

# Lower bound of the probability that trees give a label of a named room: a forest is too certain about rooms unlike
# its training rooms, and a printed name is seldom wrong. Chosen by hand.
MIN_PROBABILITY = 0.05


def label_named_rooms(
    floor: Floor,
    model: RoomModel | None = None,
    words: RoomNameDictionary | None = None,
    *,
    context: RoomContext | None = None,
) -> Floor:
    """The floor with a label for each room, as label_rooms, but using the rooms' names too.

    model, words: model and dictionary; None for those that come with pianta. If the dictionary has none of the names,
    the result is that of label_rooms. context: of the rooms, by `describe_rooms`; None to compute it.
    """
    from pianta.rooms.model_file import read_default_room_model

    model = model or read_default_room_model()
    building_type = find_labelled_type(floor, model)
    schema = None if building_type is None else model.schemas[building_type]
    priors: list[dict[str, float] | None] = []
    if any(room.name for room in floor.rooms):
        words = words or read_default_room_name_dictionary()
        priors = [room_name_prior(room.name, schema, words) if room.name else None for room in floor.rooms]
    if not any(priors):
        return model.label(floor, context=context)
    attributes = {field.name: getattr(model, field.name) for field in fields(RoomModel)}
    return _NamedRoomModel(**attributes, evidence=_to_evidence(priors, schema)).label(floor, context=context)


@dataclass(frozen=True, eq=False)
class _Evidence:
    """p(name | label) of n rooms, up to a factor for each room; ones for a room whose name says nothing.

    functions: for F/C/E/S, shape (n, 4). labels: for the labels of a building type, shape (n, labels).
    """

    functions: Floats
    labels: Floats


def _to_evidence(priors: Sequence[Mapping[str, float] | None], schema: LabelSchema | None) -> _Evidence:
    """The evidence of names whose priors are based on equally probable labels."""
    names = list(map(str, FUNCTIONS)) if schema is None else [label.name for label in schema.labels]
    rows = [[prior[name] for name in names] if prior else [1 / len(names)] * len(names) for prior in priors]
    labels = np.array(rows) * len(names)
    if schema is None:
        return _Evidence(labels, np.ones((len(rows), 0)))
    # The evidence for a function is the strongest of those for its labels.
    functions = np.ones((len(rows), len(FUNCTIONS)))
    for function, columns in columns_by_function(schema).items():
        functions[:, function] = labels[:, columns].max(axis=1, initial=MIN_PROBABILITY)
    return _Evidence(functions, labels)


@dataclass(frozen=True, eq=False, kw_only=True)
class _NamedRoomModel(RoomModel):
    """A room model for one floor, whose rooms have names."""

    evidence: _Evidence

    def predict_functions(self, context: RoomContext) -> dict[str, Floats]:
        """Probabilities of F/C/E/S with the evidence of names, shape (rooms, 4), by the step that predicts them."""
        evidence = self.evidence.functions
        first = _combine(self.first.predict(context.features), evidence)
        second = self.second.predict(describe_neighbours(context, first))
        # The random field will divide the logarithms by its temperature, which must not weaken the names.
        combined = _combine(second, evidence, self.field.temperature)
        marginals = self.field.compute_marginals(combined, find_neighbourhood(context))
        return {"first pass": first, "second pass": second, "random field": marginals}

    def _predict_names(self, context: RoomContext, functions: Floats, building_type: str) -> Floats:
        """Probabilities of the labels of a type, as of RoomModel; names divide that of a function among its labels."""
        votes = super()._predict_names(context, functions, building_type)
        for columns in columns_by_function(self.schemas[building_type]).values():
            total = votes[:, columns].sum(axis=1, keepdims=True)
            shares = np.divide(votes[:, columns], total, out=np.zeros_like(votes[:, columns]), where=total > 0)
            votes[:, columns] = total * _combine(shares, self.evidence.labels[:, columns])
        return votes


def _combine(probabilities: Floats, evidence: Floats, temperature: float = 1.0) -> Floats:
    """Probabilities of the trees multiplied by the evidence of names, shape (n, L).

    temperature: divides the logarithms of the result later; the evidence has full weight after that.
    """
    calibrated = _normalise(np.maximum(probabilities, 1e-9) ** (1 / temperature))
    joint = _normalise(np.maximum(calibrated, MIN_PROBABILITY) * evidence) ** temperature
    is_neutral = (evidence == evidence[:, :1]).all(axis=1)[:, None]
    return np.where(is_neutral, probabilities, _normalise(joint))


def _normalise(weights: Floats) -> Floats:
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))
