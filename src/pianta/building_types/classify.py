"""The building type of a floor, by the model that comes with pianta or your own."""

from __future__ import annotations

from dataclasses import replace

from pianta._arguments import check_argument
from pianta.building_types.model import BuildingModel, Verdict
from pianta.floor import Floor
from pianta.rooms.completion import complete_labels


def classify_building(floor: Floor, model: BuildingModel | None = None) -> Floor:
    """Say what kind of building a floor belongs to, or that it is unlike all that the model knows.

    Rooms are compared by the labels that somebody gave them, else by those of `label_rooms`.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    model
        Model of `train_building_types` or `load_model`; None for the one that comes with pianta, of schools and
        offices.

    Returns
    -------
    Floor
        The floor with `building_type`, type -> probability, in place of what it had; empty where the floor is unlike
        all types, or has no rooms. The labels of the rooms stay as they are.

    References
    ----------
    M. Luperto, PhD thesis, section 6.2.

    Examples
    --------
    >>> import pianta
    >>> floor, _ = pianta.make_world("corridor")
    >>> sorted(pianta.classify_building(floor).building_type)
    ['office', 'school']
    """
    return replace(floor, building_type=_find_type(judge_building(floor, model)) if floor.rooms else {})


def judge_building(floor: Floor, model: BuildingModel | None = None) -> Verdict:
    """What a model says of the building of a floor; model and labels as in classify_building.

    Raises LabelError for a floor without rooms.
    """
    check_argument(floor, Floor, "floor", "a Floor of read or reconstruct")
    check_argument(model, (BuildingModel, type(None)), "model", "a model of train_building_types or load_model")
    from pianta.building_types.model_file import read_default_building_model

    model = model or read_default_building_model()
    return model.judge(complete_labels(floor, model.label_set).floor)


def _find_type(verdict: Verdict) -> dict[str, float]:
    return dict(verdict.probabilities) if verdict.known else {}
