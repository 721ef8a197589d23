"""What each room of a floor is for, by the model that comes with pianta or your own."""

from __future__ import annotations

from pianta.floor import Floor
from pianta.rooms.model import PlaceModel


def label_rooms(floor: Floor, model: PlaceModel | None = None) -> Floor:
    """The floor with a label for each room, and probabilities; rooms keep nothing of older labels.

    model: the one that comes with pianta unless given.
    Labels are in the sets "R/C" and "F/C/E/S" (the split of the thesis' experiments), and in that of the most probable
    building type of the floor that the model knows, if there is one. A label lies below that of the coarser set.
    """
    from pianta.rooms.model_file import read_default_place_model

    return (model or read_default_place_model()).label(floor)
