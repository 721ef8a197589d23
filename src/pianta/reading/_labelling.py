"""Labels of rooms and the type of the building, as `pianta read` predicts them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from pathlib import Path
from typing import TYPE_CHECKING

from pianta._arguments import check_argument
from pianta.errors import LabelError, OptionError
from pianta.floor import Floor, Room
from pianta.labels import FCES, HOME, RC, SCHEMAS, LabelSchema, LabelSet, standard_building_type

if TYPE_CHECKING:
    from pianta.building_types.model import BuildingTypeModel
    from pianta.rooms.model import RoomModel
    from pianta.rooms.name_dictionary import RoomNameDictionary


# Least probability of ROOM or CORRIDOR to be the label of a room in a building of no known type. Chosen by hand: of the
# living rooms and kitchens of homes that are taken for corridors nearly all have less.
MIN_COARSE_PROBABILITY = 0.9
# Least probability of no known type that is printed: two digits of less are 0.00.
MIN_SHOWN_PROBABILITY = 0.005


@dataclass(frozen=True)
class Labelling:
    """The models and the options by which floors are labelled.

    words: a dictionary of room names; None for pianta's own. building_type: the user's, which is then not predicted.
    label_unknown: whether rooms keep all labels if the building is of no known type. has_own_types: whether `buildings`
    is a model of the user's.
    """

    rooms: RoomModel
    buildings: BuildingTypeModel
    words: RoomNameDictionary | None
    building_type: str | None = None
    label_unknown: bool = False
    has_own_types: bool = False

    @classmethod
    def make(
        cls,
        room_model: RoomModel | str | Path | None,
        building_model: BuildingTypeModel | str | Path | None,
        words: str | Path | None,
        building_type: str | None,
        *,
        label_unknown: bool = False,
    ) -> Labelling:
        """Read the models from their files; None for those that come with pianta."""
        from pianta.building_types.model import BuildingTypeModel
        from pianta.building_types.model_file import read_building_type_model, read_default_building_type_model
        from pianta.rooms.model import RoomModel
        from pianta.rooms.model_file import read_default_room_model, read_room_model
        from pianta.rooms.name_dictionary import read_room_name_dictionary

        if building_model is not None and building_type is not None:
            raise OptionError("building_type= makes building_model= useless, leave either out")
        rooms = read_default_room_model() if room_model is None else room_model
        rooms = read_room_model(rooms) if isinstance(rooms, str | Path) else rooms
        check_argument(rooms, RoomModel, "room_model", "a RoomModel or its file")
        if building_type is not None:
            building_type = check_type_name(building_type)
            types = (*rooms.building_types, HOME.building_type)
            if building_type not in types:
                listed = ", ".join(dict.fromkeys(types))
                raise OptionError(f"the model knows no building type {building_type!r}, give one of {listed}")
        buildings = read_default_building_type_model() if building_model is None else building_model
        buildings = read_building_type_model(buildings) if isinstance(buildings, str | Path) else buildings
        check_argument(buildings, BuildingTypeModel, "building_model", "a BuildingTypeModel or its file")
        dictionary = read_room_name_dictionary(words) if words is not None else None
        own = building_model is not None
        return cls(rooms, buildings, dictionary, building_type, label_unknown, has_own_types=own)

    @property
    def schemas(self) -> Mapping[str, LabelSchema]:
        """The label schemas of pianta and those of the room model, by building type."""
        return {**SCHEMAS, HOME.building_type: HOME, **self.rooms.schemas}

    @property
    def predicted_types(self) -> tuple[str, ...]:
        """The building types among which the model chooses; empty if the user has given the type."""
        return self.buildings.building_types if self.building_type is None else ()

    def label(self, floor: Floor) -> Floor:
        """The floor with the type of its building, and with labels for all rooms without a manual one.

        If the floor has a type, that type stays and rooms get its labels. A predicted type gives no labels to rooms:
        a wrong one would give all of them wrong names. If the building is of no known type, labels of F/C/E/S, which
        are those of schools and offices, are left out unless `label_unknown`, or a name says what the room is for.
        A home is known by the names of its rooms and by fixtures in them, and they get the labels of homes.
        """
        from pianta.building_types.classify import classify_described
        from pianta.rooms.completion import fill_missing_labels
        from pianta.rooms.features import describe_rooms
        from pianta.rooms.from_names import label_named_rooms
        from pianta.rooms.home import find_home_evidence
        from pianta.rooms.model import has_manual_label, keep_manual_label

        context = describe_rooms(floor)
        predicted = label_named_rooms(floor, self.rooms, self.words, context=context).rooms
        manual = map(keep_manual_label, floor.rooms)
        rooms: tuple[Room, ...] = tuple(old if old.label else new for old, new in zip(manual, predicted, strict=True))
        labelled = replace(floor, rooms=rooms)
        if floor.building_type:
            return self._label_home(labelled) if self._is_home(floor) else labelled
        home = find_home_evidence(floor, self.words).probability
        if home and not self.has_own_types and HOME.building_type not in self.rooms.building_types:
            return self._label_home(replace(labelled, building_type={HOME.building_type: home}))
        if self.has_own_types or all(map(has_manual_label, labelled.rooms)):
            # A manual label that no schema has is replaced by the predicted one.
            described = fill_missing_labels(
                labelled, self.buildings.label_set, schemas=self.schemas, labelled=predicted
            ).floor
            types = classify_described(described, self.buildings).building_type
        else:
            types = classify_described(labelled, context=context).building_type
        classified = replace(labelled, building_type=types)
        return classified if classified.building_type or self.label_unknown else self._keep_reliable_labels(classified)

    def relabel(self, floor: Floor) -> Floor:
        """The floor with labels of the type that its building has by now, for the rooms whose label was predicted.

        The same floor if a label is of no schema of this model: another model has predicted it.
        """
        from pianta.rooms.from_names import label_named_rooms
        from pianta.rooms.model import has_manual_label

        is_predicted = [bool(room.label_probabilities) and not has_manual_label(room) for room in floor]
        own = {*RC, *FCES, *(name for schema in self.schemas.values() for name in schema.by_name)}
        if not all(room.label is None or room.label in own for room in compress(floor, is_predicted)):
            return floor
        labelled = label_named_rooms(floor, self.rooms, self.words)
        if self._is_home(floor):
            labelled = self._label_home(labelled)
        elif not (floor.building_type or self.label_unknown):
            labelled = self._keep_reliable_labels(labelled)
        pairs = zip(floor, labelled, is_predicted, strict=True)
        return replace(floor, rooms=tuple(new if predicted else old for old, new, predicted in pairs))

    def share_home(self, storeys: Sequence[Floor]) -> list[Floor]:
        """The labelled storeys of a building; all are a home if names and fixtures on all of them together say so.

        A storey of a house may have too few names, as an attic or a cellar.
        """
        from pianta.rooms.home import find_home_evidence, join_home_evidence

        evidence = join_home_evidence([find_home_evidence(floor, self.words) for floor in storeys])
        knows_homes = self.has_own_types or HOME.building_type in self.rooms.building_types
        if self.building_type is not None or knows_homes or not evidence.probability:
            return list(storeys)
        home = {HOME.building_type: evidence.probability}
        return [
            floor if floor.given_type else self._label_home(replace(floor, building_type=home)) for floor in storeys
        ]

    def _is_home(self, floor: Floor) -> bool:
        """Whether the type of a floor is home, of which the model of rooms knows nothing."""
        is_home = next(iter(floor.building_type), None) == HOME.building_type
        return is_home and HOME.building_type not in self.rooms.building_types

    def _label_home(self, floor: Floor) -> Floor:
        """The floor of a home with labels of homes where names or fixtures give them, and of R/C for the others."""
        from pianta.rooms.home import find_home_evidence, label_home
        from pianta.rooms.model import has_manual_label

        evidence = find_home_evidence(floor, self.words)
        coarse = tuple(room if has_manual_label(room) else _keep_coarse_label(room) for room in floor.rooms)
        return label_home(replace(floor, rooms=coarse), evidence)

    def _keep_reliable_labels(self, floor: Floor) -> Floor:
        """The floor of a building of no known type, with the labels that do not depend on the type."""
        from pianta.rooms.model import has_manual_label

        return replace(
            floor,
            rooms=tuple(
                room if has_manual_label(room) or self._is_named(room) else _keep_coarse_label(room)
                for room in floor.rooms
            ),
        )

    def _is_named(self, room: Room) -> bool:
        """Whether the name of a room says what it is for."""
        from pianta.rooms.name_dictionary import read_default_room_name_dictionary, room_name_prior

        words = self.words or read_default_room_name_dictionary() if room.name else None
        return words is not None and room_name_prior(room.name or "", None, words) is not None


def _keep_coarse_label(room: Room) -> Room:
    """The room with its label of R/C alone, which is that of the room if it is certain enough."""
    name = str(LabelSet.R_C)
    label, probabilities = room.labels[name], room.label_probabilities[name]
    is_certain = probabilities[label] >= MIN_COARSE_PROBABILITY
    return replace(
        room, label=label if is_certain else None, labels={name: label}, label_probabilities={name: probabilities}
    )


def check_type_name(building_type: str) -> str:
    """A building type in lower case.

    Raises OptionError for an invalid name.
    """
    try:
        return standard_building_type(building_type)
    except LabelError as error:
        raise OptionError(f"building_type=: {error}") from None


def _describe_home_evidence(floor: Floor) -> str:
    """What a home is known by."""
    from pianta.rooms.home import HOME_FIXTURES

    names = ["the names of its rooms"] if any(room.name for room in floor) else []
    fixtures = ["its fixtures"] if any(piece.kind in HOME_FIXTURES for piece in floor.furniture) else []
    return " and ".join(names + fixtures) or "its other storeys"


def describe_type(floor: Floor, candidate_types: Sequence[str]) -> str:
    """The type of a floor's building with probabilities, or that it is unlike all candidate types of the model."""
    if not floor.building_type:
        return f"unknown, unlike every type that the model knows ({', '.join(candidate_types)})"
    if floor.given_type:
        return f"{floor.building_types[0]}, as given by a user"
    first, *others = (f"{name} {floor.building_type[name]:.2f}" for name in floor.building_types)
    if HOME.building_type in floor.building_type and HOME.building_type not in candidate_types:
        return f"{first}, by {_describe_home_evidence(floor)}"
    neither = 1 - sum(floor.building_type.values())
    if neither >= MIN_SHOWN_PROBABILITY:
        others.append(f"{'neither' if len(candidate_types) == 2 else 'none of these'} {neither:.2f}")
    return f"{first} ({', '.join(others)})" if others else first
