"""The building type of a floor, by the model that comes with pianta or your own."""

from __future__ import annotations

from dataclasses import replace

from pianta._arguments import check_argument
from pianta.building_types.map_types import MapTypePrediction
from pianta.building_types.model import BuildingTypeModel, TypePrediction
from pianta.floor import Floor
from pianta.rooms.completion import fill_missing_labels
from pianta.rooms.features import RoomContext
from pianta.rooms.model import has_manual_label


def classify_building(floor: Floor, model: BuildingTypeModel | None = None) -> Floor:
    """Predict the building type of a floor, or find that it is probably of no type that the model knows.

    A floor all of whose rooms have a manual label is compared with drawn floors, by these labels. Any other floor, such
    as one that was read from a map, is compared with readings of maps, by its rooms and doors alone; with a model of
    your own also by the labels of `label_rooms`.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    model
        Model of `train_building_types` or `load_model`; None for those that come with pianta, of schools and offices.

    Returns
    -------
    Floor
        The floor with `building_type`, type -> probability, replacing what it had; empty if no type is probable
        enough, the floor is unlike all types, or it has no rooms. What the probabilities lack to 1 is the probability
        of a building of none of the types. The labels of the rooms stay as they are.

    References
    ----------
    M. Luperto, PhD thesis, section 6.2.

    Examples
    --------
    >>> import pianta
    >>> _, grid = pianta.make_world("home")
    >>> pianta.classify_building(pianta.reconstruct(grid)).building_type
    {}
    """
    return classify_described(floor, model)


def classify_described(
    floor: Floor, model: BuildingTypeModel | None = None, *, context: RoomContext | None = None
) -> Floor:
    """The floor as `classify_building` gives it; context: of its rooms, by `describe_rooms`, None to compute it."""
    if not floor.rooms:
        return replace(floor, building_type={})
    prediction: TypePrediction | MapTypePrediction
    if model is None and not all(map(has_manual_label, floor.rooms)):
        prediction = predict_map_type(floor, context=context)
    else:
        prediction = predict_building_type(floor, model)
    return replace(floor, building_type=dict(prediction.probabilities) if prediction.is_known else {})


def predict_map_type(floor: Floor, *, context: RoomContext | None = None) -> MapTypePrediction:
    """The prediction behind `classify_building` for a floor that was read from a map, also that it is of no known type.

    context: of its rooms, by `describe_rooms`; None to compute it. Raises LabelError for a floor without rooms.
    """
    check_argument(floor, Floor, "floor", "a Floor of read or reconstruct")
    from pianta.building_types.map_type_file import read_default_map_type_model

    return read_default_map_type_model().predict(floor, context=context)


def predict_building_type(floor: Floor, model: BuildingTypeModel | None = None) -> TypePrediction:
    """The prediction behind `classify_building` by labels, with typicality and the most similar training floors.

    Raises LabelError for a floor without rooms.
    """
    check_argument(floor, Floor, "floor", "a Floor of read or reconstruct")
    check_argument(model, (BuildingTypeModel, type(None)), "model", "a model of train_building_types or load_model")
    from pianta.building_types.model_file import read_default_building_type_model

    model = model or read_default_building_type_model()
    return model.predict(fill_missing_labels(floor, model.label_set).floor)
