"""Labels of rooms and the building's type, as `pianta read` finds them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pianta.errors import LabelError, OptionError
from pianta.floor import Floor, Room
from pianta.labels import SCHEMAS, LabelSchema, standard_building_type

if TYPE_CHECKING:
    from pianta.building_types.model import BuildingTypeModel
    from pianta.rooms.model import RoomModel
    from pianta.rooms.name_dictionary import RoomNameDictionary


@dataclass(frozen=True)
class Labelling:
    """How floors are labelled.

    rooms: the model of rooms. buildings: the model of building types. words: what names of rooms say of their labels;
    None for those of pianta. building_type: the one that is given, which is then not predicted.
    """

    rooms: RoomModel
    buildings: BuildingTypeModel
    words: RoomNameDictionary | None
    building_type: str | None = None

    @classmethod
    def make(
        cls,
        room_model: RoomModel | str | Path | None,
        building_model: BuildingTypeModel | str | Path | None,
        words: str | Path | None,
        building_type: str | None,
    ) -> Labelling:
        """Read the models from their files, or those that come with pianta for None."""
        from pianta.building_types.model import BuildingTypeModel
        from pianta.building_types.model_file import read_building_type_model, read_default_building_type_model
        from pianta.rooms.model import RoomModel
        from pianta.rooms.model_file import read_default_room_model, read_room_model
        from pianta.rooms.name_dictionary import read_room_name_dictionary

        if building_model is not None and building_type is not None:
            raise OptionError("building_type= makes building_model= useless, leave either out")
        rooms = read_default_room_model() if room_model is None else room_model
        rooms = read_room_model(rooms) if isinstance(rooms, str | Path) else rooms
        _check_model("room_model", rooms, RoomModel)
        if building_type is not None:
            building_type = check_type_name(building_type)
            if building_type not in rooms.building_types:
                known = ", ".join(rooms.building_types)
                raise OptionError(f"the model knows no building type {building_type!r}, give one of {known}")
        buildings = read_default_building_type_model() if building_model is None else building_model
        buildings = read_building_type_model(buildings) if isinstance(buildings, str | Path) else buildings
        _check_model("building_model", buildings, BuildingTypeModel)
        return cls(rooms, buildings, read_room_name_dictionary(words) if words is not None else None, building_type)

    @property
    def schemas(self) -> Mapping[str, LabelSchema]:
        """The schemas of building types that come with pianta and those of the model of rooms."""
        return {**SCHEMAS, **self.rooms.schemas}

    @property
    def predicted_types(self) -> tuple[str, ...]:
        """The building types that it tells apart; none where the type is given."""
        return self.buildings.building_types if self.building_type is None else ()

    def label(self, floor: Floor) -> Floor:
        """The floor with its building's type, and labels for all rooms that nobody has labelled.

        A type that the floor has is taken as given, and rooms get its labels. A type that the model predicts gives
        rooms no labels: where it is wrong, it would name all of them wrongly.
        """
        from pianta.building_types.classify import classify_building
        from pianta.rooms.completion import fill_missing_labels
        from pianta.rooms.from_names import label_named_rooms
        from pianta.rooms.model import keep_manual_label

        found = label_named_rooms(floor, self.rooms, self.words).rooms
        given = map(keep_manual_label, floor.rooms)
        rooms: tuple[Room, ...] = tuple(old if old.label else new for old, new in zip(given, found, strict=True))
        labelled = replace(floor, rooms=rooms)
        if floor.building_type:
            return labelled
        # What is found of a room stands for a given label that no schema has.
        coarse = fill_missing_labels(labelled, self.buildings.label_set, schemas=self.schemas, labelled=found).floor
        return replace(labelled, building_type=classify_building(coarse, self.buildings).building_type)


def _check_model(name: str, model: object, kind: type) -> None:
    """Raise OptionError for a model of another kind."""
    if not isinstance(model, kind):
        raise OptionError(f"{name}= is a {type(model).__name__}, give a {kind.__name__} or its file")


def check_type_name(building_type: str) -> str:
    """A building type in lower case.

    Raises OptionError for what is no name.
    """
    try:
        return standard_building_type(building_type)
    except LabelError as error:
        raise OptionError(f"building_type=: {error}") from None


def describe_type(floor: Floor, building_types: Sequence[str]) -> str:
    """The type of a floor's building, with probabilities, or that it is unknown.

    building_types: those that the model knows.
    """
    if not floor.building_type:
        return f"unknown, unlike every type that the model knows ({', '.join(building_types)})"
    if floor.given_type:
        return f"{floor.building_types[0]}, as somebody has said"
    first, *others = (f"{kind} {floor.building_type[kind]:.2f}" for kind in floor.building_types)
    return f"{first} ({', '.join(others)})" if others else first
