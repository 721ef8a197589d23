"""Names of rooms join what geometry says, also for the rooms around them."""

from dataclasses import replace

import numpy as np
import pytest

from pianta.floor import Floor, Room
from pianta.labels import SCHOOL
from pianta.rooms.from_names import label_named_rooms
from pianta.rooms.label import label_rooms
from pianta.rooms.name_dictionary import RoomNameDictionary, RoomNameEntry
from pianta.worlds.floors import make_floor
from tests.labelled_floors import label_by_rule, small_model


@pytest.fixture(scope="module")
def plain():
    floor = label_by_rule(make_floor("corridor", seed=5), source="unseen.xml")
    return replace(floor, rooms=tuple(Room(room.id, room.polygon) for room in floor.rooms))


def named(floor: Floor, **names: str) -> Floor:
    name_by_id = {int(key.removeprefix("room_")): name for key, name in names.items()}
    return replace(floor, rooms=tuple(replace(room, name=name_by_id.get(room.id)) for room in floor.rooms))


def room_of(floor: Floor, room_id: int) -> Room:
    return next(room for room in floor.rooms if room.id == room_id)


def a_classroom(floor: Floor) -> int:
    return next(room.id for room in label_rooms(floor, small_model()).rooms if room.labels["school"] == "CLASSROOM")


def test_without_names_it_is_label_rooms(plain):
    assert label_named_rooms(plain, small_model()) == label_rooms(plain, small_model())


def test_unknown_names_change_no_label_and_stay(plain):
    floor = named(plain, room_2="Luperto", room_3="12")
    assert label_named_rooms(floor, small_model()) == label_rooms(floor, small_model())
    assert room_of(label_named_rooms(floor, small_model()), 2).name == "Luperto"


@pytest.mark.parametrize(
    ("name", "labels"),
    [
        ("GYMNASIUM", {"GYM"}),
        ("Biblioteca", {"LIBRARY"}),
        ("Treppenhaus", {"STAIRS"}),
        ("204 Toilet", {"BATHROOM", "WASHROOM"}),
        ("Corridoio", {"CORRIDOR"}),
    ],
)
def test_a_name_outweighs_geometry(plain, name, labels):
    room_id = a_classroom(plain)
    labelled = label_named_rooms(named(plain, **{f"room_{room_id}": name}), small_model())
    room = room_of(labelled, room_id)
    assert room.labels["school"] in labels
    schema = SCHOOL.by_name[room.labels["school"]]
    assert (schema.room_or_corridor(), schema.function_in()) == (room.labels["R/C"], room.labels["F/C/E/S"])
    assert (room.label, room.name) == (room.labels["school"], name)


def test_geometry_decides_what_a_name_leaves_open(plain):
    """An office of a school is a small, medium or big administrative room."""
    room_id = a_classroom(plain)
    labelled = label_named_rooms(named(plain, **{f"room_{room_id}": "Office"}), small_model())
    room = room_of(labelled, room_id)
    assert room.label is not None
    assert room.label.endswith("ADMINISTRATIVE")
    probabilities = room.label_probabilities["school"]
    administrative = [probabilities[name] for name in probabilities if name.endswith("ADMINISTRATIVE")]
    assert probabilities[room.label] == max(administrative)
    assert sum(administrative) > 0.5


def test_probabilities_still_add_up_level_by_level(plain):
    floor = named(plain, room_1="Corridor", room_2="Gym", room_3="Library", room_4="WC")
    for room in label_named_rooms(floor, small_model()).rooms:
        functions, names = room.label_probabilities["F/C/E/S"], room.label_probabilities["school"]
        assert sum(functions.values()) == pytest.approx(1)
        assert room.label_probabilities["R/C"]["CORRIDOR"] == functions["CONNECTION"]
        for function, probability in functions.items():
            below = [label.name for label in SCHOOL.labels if label.function_in() == function]
            assert sum(names[name] for name in below) == pytest.approx(probability)


def test_without_a_type_names_determine_the_function(plain):
    room_id = a_classroom(plain)
    floor = replace(named(plain, **{f"room_{room_id}": "Lager"}), building_type={})
    room = room_of(label_named_rooms(floor, small_model()), room_id)
    assert (room.label, [*room.labels]) == ("SERVICE", ["R/C", "F/C/E/S"])


def test_neighbours_hear_of_a_name(plain):
    room_id = a_classroom(plain)
    before = label_rooms(plain, small_model())
    after = label_named_rooms(named(plain, **{f"room_{room_id}": "Corridor"}), small_model())
    changed = [
        abs(old.label_probabilities["F/C/E/S"][name] - new.label_probabilities["F/C/E/S"][name])
        for old, new in zip(before.rooms, after.rooms, strict=True)
        if old.id != room_id
        for name in old.label_probabilities["F/C/E/S"]
    ]
    assert np.max(changed) > 1e-3


def test_a_dictionary_of_ones_own_is_used(plain):
    gym = SCHOOL.by_name["GYM"]
    words = RoomNameDictionary((RoomNameEntry(gym.function_in(), {"xx": ("blorp",)}, {"school": ("GYM",)}),))
    room_id = a_classroom(plain)
    floor = named(plain, **{f"room_{room_id}": "Blorp"})
    assert room_of(label_named_rooms(floor, small_model(), words), room_id).label == "GYM"
    assert label_named_rooms(floor, small_model()) == label_rooms(floor, small_model())
