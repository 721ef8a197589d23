"""What each room of a floor is for, by the model that comes with pianta or your own."""

from __future__ import annotations

from pianta._arguments import check_argument
from pianta.floor import Floor
from pianta.rooms.model import RoomModel


def label_rooms(floor: Floor, model: RoomModel | None = None) -> Floor:
    """Predict what each room of a floor is for.

    Labels are in the sets "R/C" and "F/C/E/S" (by the convention of the thesis' experiments), and in that of the most
    probable building type of the floor that the model has, if there is one. Each label is consistent with the coarser.

    Parameters
    ----------
    floor
        The floor, metres of the map frame; give it `building_type={"school": 1.0}` for the labels of schools.
    model
        Model of `train_rooms` or `load_model`; None for the one that comes with pianta.

    Returns
    -------
    Floor
        The floor with a label for each room, and probabilities; older labels are replaced.

    References
    ----------
    M. Luperto, PhD thesis, chapters 4 and 5.

    Examples
    --------
    >>> import pianta
    >>> _, grid = pianta.make_world("corridor")
    >>> floor = pianta.label_rooms(pianta.reconstruct(grid))
    >>> [room.id for room in floor if room.labels["R/C"] == "CORRIDOR"]
    [9]
    """
    check_argument(floor, Floor, "floor", "a Floor of read or reconstruct")
    check_argument(model, (RoomModel, type(None)), "model", "a model of train_rooms or load_model")
    from pianta.rooms.model_file import read_default_room_model

    return (model or read_default_room_model()).label(floor)
