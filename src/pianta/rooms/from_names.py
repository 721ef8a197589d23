"""What rooms are for, given their names too: what names say joins what geometry says before the floor is judged.

Of each room, p(label | geometry, name) is taken as p(label | geometry) p(name | label). Names multiply what the trees
say of F/C/E/S before rooms look at each other, and what the random field is given; so an entrance that is named tells
its neighbours what they are. Labels of a building type are weighed within their function.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from pianta._types import Floats
from pianta.floor import Floor
from pianta.labels import LabelSchema
from pianta.rooms.features import RoomContext
from pianta.rooms.label import label_rooms
from pianta.rooms.model import FUNCTIONS, RoomModel, describe_neighbours, find_neighbourhood
from pianta.rooms.name_dictionary import RoomNameDictionary, read_default_room_name_dictionary, room_name_prior

# Of a room with a name that says something, trees leave every label at least this probability: a forest is surer of
# itself than of rooms unlike those that it was grown on, and what is printed in a room is seldom wrong.
LEAST = 0.05


def label_named_rooms(floor: Floor, model: RoomModel | None = None, words: RoomNameDictionary | None = None) -> Floor:
    """The floor with a label for each room, as label_rooms gives them, with what the rooms' names say.

    model: the one that comes with pianta unless given. words: the dictionary that comes with pianta unless given.
    Where no room has a name that the dictionary knows, it is label_rooms.
    """
    from pianta.rooms.model_file import read_default_room_model

    model = model or read_default_room_model()
    known = next((name for name in floor.building_types if name in model.names), None)
    schema = None if known is None else model.schemas[known]
    if not any(room.name for room in floor.rooms):
        return label_rooms(floor, model)
    words = words or read_default_room_name_dictionary()
    priors = [room_name_prior(room.name, schema, words) if room.name else None for room in floor.rooms]
    if not any(priors):
        return label_rooms(floor, model)
    parts = {part.name: getattr(model, part.name) for part in fields(RoomModel)}
    return _NamedRoomModel(**parts, evidence=_weigh_names(priors, schema)).label(floor)


@dataclass(frozen=True, eq=False)
class _Evidence:
    """What the names of n rooms say: of F/C/E/S, shape (n, 4), and of the labels of a type, shape (n, labels).

    p(name | label) up to a factor for each room; ones where a name says nothing.
    """

    functions: Floats
    labels: Floats


def _weigh_names(priors: Sequence[Mapping[str, float] | None], schema: LabelSchema | None) -> _Evidence:
    """What names say, given the labels that they make probable when all were equally likely before."""
    names = list(map(str, FUNCTIONS)) if schema is None else [label.name for label in schema.labels]
    rows = [[prior[name] for name in names] if prior else [1 / len(names)] * len(names) for prior in priors]
    labels = np.array(rows) * len(names)
    if schema is None:
        return _Evidence(labels, np.ones((len(rows), 0)))
    # A name speaks for a function as it does for that label of it for which it speaks most.
    functions = np.array([FUNCTIONS.index(label.function_in()) for label in schema.labels])
    of_functions = [
        labels[:, functions == number].max(axis=1, initial=LEAST) if (functions == number).any() else np.ones(len(rows))
        for number in range(len(FUNCTIONS))
    ]
    return _Evidence(np.stack(of_functions, axis=1), labels)


@dataclass(frozen=True, eq=False, kw_only=True)
class _NamedRoomModel(RoomModel):
    """A place model for one floor, whose rooms have names."""

    evidence: _Evidence

    def _judge(self, context: RoomContext) -> dict[str, Floats]:
        said = self.evidence.functions
        first = _combine(self.first.predict(context.features), said)
        second = self.second.predict(describe_neighbours(context, first))
        # The field divides logarithms by its temperature, which is the trees' and not the names'.
        told = _combine(second, said, self.field.temperature)
        judged = self.field.compute_marginals(told, find_neighbourhood(context))
        return {"first pass": first, "second pass": second, "random field": judged}

    def _name(self, context: RoomContext, judged: Floats, building_type: str) -> Floats:
        votes = super()._name(context, judged, building_type)
        functions = np.array([FUNCTIONS.index(label.function_in()) for label in self.schemas[building_type].labels])
        for number in np.unique(functions):
            of_function = functions == number
            total = votes[:, of_function].sum(axis=1, keepdims=True)
            shares = np.divide(votes[:, of_function], total, out=np.zeros_like(votes[:, of_function]), where=total > 0)
            votes[:, of_function] = total * _combine(shares, self.evidence.labels[:, of_function])
        return votes


def _combine(probabilities: Floats, said: Floats, temperature: float = 1.0) -> Floats:
    """Probabilities of labels by the trees, with what names say, shapes (n, L).

    temperature: by which the logarithms of the outcome will be divided; names count as they are after that.
    """
    calibrated = _normalise(np.maximum(probabilities, 1e-9) ** (1 / temperature))
    joint = _normalise(np.maximum(calibrated, LEAST) * said) ** temperature
    silent = (said == said[:, :1]).all(axis=1)[:, None]
    return np.where(silent, probabilities, _normalise(joint))


def _normalise(weights: Floats) -> Floats:
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))
