"""What `pianta read` says of a floor: what kind of building it is of, and what each room is for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pianta.errors import LabelError, OptionError
from pianta.floor import Floor
from pianta.labels import SCHEMAS, LabelSchema, standard_building_type

if TYPE_CHECKING:
    from pianta.building_types.model import BuildingModel
    from pianta.rooms.model import PlaceModel
    from pianta.rooms.name_dictionary import RoomWords


@dataclass(frozen=True)
class Labelling:
    """How floors are labelled.

    places: the model of rooms. words: what names of rooms say of their labels. buildings: the model of building types.
    building_type: the one that is given, which then is not asked for.
    """

    places: PlaceModel
    buildings: BuildingModel
    words: RoomWords
    building_type: str | None = None

    def label(self, floor: Floor) -> Floor:
        """The floor with its building's type, and labels for all rooms that nobody has labelled.

        A type that the floor has is taken as given, and rooms get its labels. A type that the model finds gives rooms
        no labels: where it is wrong, it would name all of them wrongly.
        """
        from pianta.building_types.classify import classify_building
        from pianta.rooms.completion import complete_labels
        from pianta.rooms.from_names import label_named_rooms
        from pianta.rooms.model import keep_given_label

        given, found = map(keep_given_label, floor.rooms), label_named_rooms(floor, self.places, self.words).rooms
        rooms = tuple(old if old.label else new for old, new in zip(given, found, strict=True))
        labelled = replace(floor, rooms=rooms)
        if floor.building_type:
            return labelled
        # What is found of a room stands for a given label that no schema has.
        coarse = complete_labels(labelled, self.buildings.label_set, schemas=self.schemas, found=found).floor
        return replace(labelled, building_type=classify_building(coarse, self.buildings).building_type)

    @property
    def schemas(self) -> Mapping[str, LabelSchema]:
        """The schemas of building types that come with pianta and those of the model of rooms."""
        return {**SCHEMAS, **self.places.schemas}

    def judges(self, floor: Floor) -> bool:
        """Whether it is for the model to say what kind of building a floor is of."""
        return self.building_type is None and bool(floor.rooms)


def read_labelling(
    model: Path | None,
    building_model: Path | None,
    building_type: str | None,
    words: Path | None = None,
    *,
    no_labels: bool = False,
) -> Labelling | None:
    """How floors are labelled by models in files, or by those that come with pianta; None for not at all.

    Raises ModelError, in one line, for a file that is no model; OptionError for options that exclude each other, and a
    building type that the model of rooms does not know.
    """
    from pianta.building_types.model_file import read_building_model, read_default_building_model
    from pianta.rooms.model_file import read_default_place_model, read_place_model
    from pianta.rooms.name_dictionary import read_default_room_words, read_room_words

    if no_labels and (model or building_model or words or building_type is not None):
        raise OptionError("--no-labels makes --model, --building-model, --words and --type useless, leave either out")
    if building_model and building_type is not None:
        raise OptionError("--type makes --building-model useless, leave either out")
    if no_labels:
        return None
    places = read_place_model(model) if model else read_default_place_model()
    if building_type is not None and check_type(building_type) not in places.building_types:
        known = ", ".join(places.building_types)
        raise OptionError(f"the model knows no building type {building_type!r}, give one of {known}")
    buildings = read_building_model(building_model) if building_model else read_default_building_model()
    read = read_room_words(words) if words else read_default_room_words()
    return Labelling(places, buildings, read, building_type and check_type(building_type))


def check_type(building_type: str) -> str:
    """The building type of --type in lower case.

    Raises OptionError for what is no name.
    """
    try:
        return standard_building_type(building_type)
    except LabelError as error:
        raise OptionError(f"--type: {error}") from None


def label_floor(floor: Floor, labelling: Labelling | None, older: Floor | None = None) -> Floor:
    """The floor with its type and labels; what somebody has said of a room, or of the type of an older floor, stays.

    Without a labelling, what somebody has said is all that stays.
    """
    from pianta.rooms.model import keep_given_label

    kind = (labelling and labelling.building_type) or (older and older.given_type)
    floor = replace(floor, building_type={kind: 1.0} if kind else {})
    if labelling:
        return labelling.label(floor)
    return replace(floor, rooms=tuple(map(keep_given_label, floor.rooms)))


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


def name_type(floor: Floor) -> str:
    """The most probable type of a floor's building, with its probability, in a few words."""
    kinds = floor.building_types
    return f"{kinds[0]} {floor.building_type[kinds[0]]:.2f}" if kinds else "unknown type"
