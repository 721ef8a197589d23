"""The building type of a floor, by the model that comes with pianta or your own."""

from __future__ import annotations

from dataclasses import replace

from pianta._arguments import check_argument
from pianta.building_types.model import BuildingTypeModel, TypePrediction
from pianta.floor import Floor
from pianta.rooms.completion import fill_missing_labels


def classify_building(floor: Floor, model: BuildingTypeModel | None = None) -> Floor:
    """Predict the building type of a floor, or find that it is unlike all floors that the model was trained on.

    Rooms are compared by their manual labels; rooms without one, by the labels of `label_rooms`.

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
        The floor with `building_type`, type -> probability, replacing what it had; empty if the floor is unlike
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
    prediction = predict_building_type(floor, model) if floor.rooms else None
    return replace(floor, building_type=dict(prediction.probabilities) if prediction and prediction.is_known else {})


def predict_building_type(floor: Floor, model: BuildingTypeModel | None = None) -> TypePrediction:
    """The prediction behind `classify_building`, with typicality and the most similar training floors.

    Raises LabelError for a floor without rooms.
    """
    check_argument(floor, Floor, "floor", "a Floor of read or reconstruct")
    check_argument(model, (BuildingTypeModel, type(None)), "model", "a model of train_building_types or load_model")
    from pianta.building_types.model_file import read_default_building_type_model

    model = model or read_default_building_type_model()
    return model.predict(fill_missing_labels(floor, model.label_set).floor)
