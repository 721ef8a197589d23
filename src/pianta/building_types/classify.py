"""The building type of a floor, by the model that comes with pianta or your own."""

from __future__ import annotations

from dataclasses import replace

from pianta.building_types.model import BuildingModel, Verdict
from pianta.floor import Floor
from pianta.rooms.completion import complete_labels


def classify_building(floor: Floor, model: BuildingModel | None = None) -> Floor:
    """The floor with probabilities of its building's types; with none where it is unlike all that the model knows.

    They take the place of those that the floor has.
    model: the one that comes with pianta unless given.
    Rooms are compared by the labels that somebody gave them, else by those of label_rooms; the labels of the floor stay
    as they are. A floor without rooms gets no type.
    """
    return replace(floor, building_type=_find_type(judge_building(floor, model)) if floor.rooms else {})


def judge_building(floor: Floor, model: BuildingModel | None = None) -> Verdict:
    """What a model says of the building of a floor; model and labels as in classify_building.

    Raises LabelError for a floor without rooms.
    """
    from pianta.building_types.model_file import read_default_building_model

    model = model or read_default_building_model()
    return model.judge(complete_labels(floor, model.label_set).floor)


def _find_type(verdict: Verdict) -> dict[str, float]:
    return dict(verdict.probabilities) if verdict.known else {}
