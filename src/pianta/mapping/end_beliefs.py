"""Beliefs over what lies behind unopened doors and along open corridors of a map that grows (section 8.3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from pianta.errors import GraphError, LabelError
from pianta.floor import Floor
from pianta.mapping.beliefs import Distribution, update_belief
from pianta.prediction.explored_part import read_explored_part
from pianta.prediction.prediction import OpenEnd, Prediction
from pianta.prediction.unexplored_part import FloorSampler

# Floors that are sampled, without moves of steps 2 and 4, which take long and seldom change a room behind an end.
# Chosen by hand, as those of exploration.
SAMPLES = 16


def predict_ends(
    floor: Floor, sampler: FloorSampler, before: Mapping[str, Distribution], *, is_new: bool
) -> tuple[tuple[OpenEnd, ...], Prediction | None]:
    """The open ends of a floor, with beliefs over labels as their labels, and what a model expects of the whole floor.

    No ends and None if nothing is open, or no room is known yet. before: the belief at each open end, by its name.
    is_new: whether the floor has been read again; else the beliefs stay.
    """
    try:
        explored = read_explored_part(floor.graph(), sampler.model.schema)
    except (GraphError, LabelError):
        return (), None
    if not explored.open_ends:
        return (), None
    samples = tuple(sampler.sample(explored, range(SAMPLES), edge_moves=0, door_moves=0))
    similar = sampler.doors.predict(explored)
    prediction = Prediction(explored, samples, sampler.model.schema, sampler.label_shares, similar)
    beliefs = [
        old if (old := before.get(end.name)) and not is_new else _update(old, end, sampler.label_shares)
        for end in prediction.ends
    ]
    ends = zip(prediction.ends, beliefs, strict=True)
    return tuple(replace(end, labels=belief) for end, belief in ends), prediction


def _update(before: Distribution | None, end: OpenEnd, prior: Distribution) -> Distribution:
    """The belief over all labels of the model, the most probable first.

    A sample of floors is a full reading, so the prior has no weight; a label that no sample has is not ruled out.
    """
    reading = {label: end.labels.get(label, 0.0) for label in prior}
    belief = update_belief(before, reading, prior, trust=1.0)
    return dict(sorted(belief.items(), key=lambda answer: -answer[1]))
