"""Beliefs: distributions over labels and types that each reading of a growing map updates, and what is announced.

A Bayes filter with exponential forgetting. With the reading p, its trust s and the prior q,

    b_k ∝ b_(k-1)^(1 - GAIN) · (p^s · q^(1 - s))^GAIN,

which is Bayes' rule for evidence that fades, as neighbouring readings are of the same walls: a product of all of them
would soon be certain of anything. Readings of little trust move a belief to the prior rather than to themselves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pianta.building_types.growing_map_types import GrowingMapTypeModel, read_default_growing_map_type_model
from pianta.building_types.map_types import MIN_TYPE_PROBABILITY, OTHER, MapTypeModel
from pianta.floor import Floor, Room
from pianta.labels import LabelSet
from pianta.rooms.features import RoomContext, describe_rooms
from pianta.rooms.model import RoomModel
from pianta.rooms.model_file import read_default_room_model

# All but FEW_ROOMS were chosen by hand; that by the logarithmic loss of parts of floors whose building was left out.
GAIN = 0.5
MARGIN = 0.1  # by which another answer is more probable before it is announced instead
TYPE_MARGIN = 0.1  # by which a type that was announced may be less probable than a new one must be
UNPREDICTED_SHARE = 0.5  # that is taken to be seen of a partial room without a predicted shape
FEW_ROOMS = 1.0  # rooms, complete or not, with which a reading of the type has half of its trust
ANNOUNCED_SHARE = (
    0.5  # that was seen of a room whose label is announced: through a door, most rooms look like entrances
)
MIN_PROBABILITY = 1e-3  # of any answer: a reading rules nothing out
MIN_COARSE_PROBABILITY = 0.9  # of a label of R/C that is announced without a type, as by `read`
DIGITS = 4  # of probabilities

Distribution = Mapping[str, float]


def update_belief(
    before: Distribution | None, reading: Distribution, prior: Distribution, trust: float
) -> Distribution:
    """The belief after a reading, over its answers.

    before: None for the first reading. prior: over the same answers. trust: 0 … 1.
    """
    answers = [*reading]
    logarithms = trust * _log(reading, answers) + (1 - trust) * _log(prior, answers)
    if before is not None and {*answers} <= before.keys():
        logarithms = (1 - GAIN) * _log(before, answers) + GAIN * logarithms
    weights = np.exp(logarithms - logarithms.max())
    return dict(zip(answers, (weights / weights.sum()).round(DIGITS).tolist(), strict=True))


def choose_announced(belief: Distribution, announced: str | None) -> str:
    """The answer to announce: that announced before, unless another one is clearly more probable."""
    best = max(belief, key=lambda answer: belief[answer])
    return announced if announced is not None and belief.get(announced, 0.0) + MARGIN > belief[best] else best


def update_type(
    before: Distribution | None,
    floor: Floor,
    model: MapTypeModel | GrowingMapTypeModel | None = None,
    context: RoomContext | None = None,
) -> Distribution:
    """The belief over types, with OTHER for none of them, after a reading; few rooms have little weight.

    model: None for the one that comes with pianta. context: of the rooms, by `describe_rooms`; None to compute it.
    """
    prediction = (model or read_default_growing_map_type_model()).predict(floor, context=context)
    reading = {**prediction.probabilities, OTHER: prediction.neither}
    uniform = dict.fromkeys(reading, 1 / len(reading))
    return update_belief(before, reading, uniform, len(floor) / (len(floor) + FEW_ROOMS))


def choose_type(belief: Distribution, announced: str | None) -> str | None:
    """The type to announce, None if no type is probable enough; that announced before may be a little less probable."""
    types = {name: value for name, value in belief.items() if name != OTHER}
    best = choose_announced(types, announced)
    limit = MIN_TYPE_PROBABILITY - (TYPE_MARGIN if best == announced else 0.0)
    return best if types[best] >= limit else None


def update_labels(floor: Floor, previous: Floor, model: RoomModel | None, context: RoomContext | None = None) -> Floor:
    """The floor with announced labels, and with beliefs as their probabilities; rooms have the ids of the previous one.

    The prior of each label set is its mean over all rooms of the reading. A room that was seen in part is trusted by
    the share of its predicted shape that was seen. Labels finer than R/C are announced once a type is.
    """
    context = context or describe_rooms(floor)
    bare = replace(floor, rooms=tuple(map(_strip_labels, floor)))
    read = (model or read_default_room_model()).label(bare, context=context)
    before = {room.id: room for room in previous}
    priors = _average([room.label_probabilities for room in read])
    rooms = tuple(
        _announce_labels(old, new, before.get(old.id), priors, is_typed=bool(floor.building_type))
        for old, new in zip(floor, read, strict=True)
    )
    return replace(floor, rooms=rooms)


def measure_trust(room: Room) -> float:
    """The share of a room that was seen, as far as it is known; 0 … 1."""
    if not room.partial:
        return 1.0
    return min(1.0, room.polygon.area / room.predicted.area) if room.predicted else UNPREDICTED_SHARE


def _announce_labels(
    room: Room, read: Room, before: Room | None, priors: Mapping[str, Distribution], *, is_typed: bool
) -> Room:
    trust = measure_trust(room)
    beliefs, labels = {}, {}
    for label_set, reading in read.label_probabilities.items():
        old = before.label_probabilities.get(label_set) if before else None
        beliefs[label_set] = update_belief(old, reading, priors[label_set], trust)
        labels[label_set] = choose_announced(beliefs[label_set], before.labels.get(label_set) if before else None)
    coarse, label = str(LabelSet.R_C), before.label if before else None
    if trust >= ANNOUNCED_SHARE:
        label = [*labels.values()][-1] if is_typed else labels[coarse]
    if not is_typed and beliefs[coarse][labels[coarse]] < MIN_COARSE_PROBABILITY:
        label = None
    return replace(room, label=label, labels=labels, label_probabilities=beliefs)


def _strip_labels(room: Room) -> Room:
    return replace(room, label=None, labels={}, label_probabilities={})


def _average(distributions: Sequence[Mapping[str, Distribution]]) -> dict[str, Distribution]:
    """The mean of distributions, by label set."""
    return {
        label_set: {
            answer: float(np.mean([each[label_set][answer] for each in distributions])) for answer in distribution
        }
        for label_set, distribution in distributions[0].items()
    }


def _log(distribution: Distribution, answers: Sequence[str]) -> NDArray[np.float64]:
    return np.log(np.maximum([distribution[answer] for answer in answers], MIN_PROBABILITY))
