"""Homes are known by the names of their rooms, in nine languages, and the rooms get the labels of homes."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from shapely import box

import pianta
from pianta.floor import Floor, Furniture, Room
from pianta.labels import HOME, LabelSet
from pianta.reading._labelling import Labelling, describe_type
from pianta.rooms import home
from pianta.rooms.home import find_home_evidence, label_home


def floor(*names: str | None) -> Floor:
    """Rooms of 4 × 3 m in a row."""
    return Floor(tuple(Room(k, box(4 * k, 0, 4 * k + 4, 3), name=name) for k, name in enumerate(names, start=1)))


def label(*names: str | None, building_type: str | None = None) -> Floor:
    types = {building_type: 1.0} if building_type else {}
    return Labelling.make(None, None, None, building_type).label(Floor(floor(*names).rooms, building_type=types))


@pytest.mark.parametrize(
    ("names", "labels"),
    [
        (("Living", "Bedroom 2", "Bath", "Hall", "PNTR"), ("LIVING ROOM", "BEDROOM", "BATHROOM", "HALL", "STORAGE")),
        (
            ("Wohnen", "Schlafen", "Küche", "Flur", "Abst."),
            ("LIVING ROOM", "BEDROOM", "KITCHEN", "CORRIDOR", "STORAGE"),
        ),
        (("Soggiorno", "Camera", "Bagno", "Disimpegno"), ("LIVING ROOM", "BEDROOM", "BATHROOM", "CORRIDOR")),
        (
            ("Séjour", "Chambre 1", "SdB", "Cellier", "Entrée"),
            ("LIVING ROOM", "BEDROOM", "BATHROOM", "STORAGE", "ENTRANCE"),
        ),
        (("Salón", "Dormitorio", "Baño", "Pasillo"), ("LIVING ROOM", "BEDROOM", "BATHROOM", "CORRIDOR")),
        (("Sala de estar", "Quarto", "Cozinha", "Varanda"), ("LIVING ROOM", "BEDROOM", "KITCHEN", "BALCONY")),
        (("SOVRUM 1", "KLK", "BALKONG", "VARDAGSRUM"), ("BEDROOM", "CLOSET", "BALCONY", "LIVING ROOM")),
        (("洋室", "リビング", "トイレ", "浴室"), ("BEDROOM", "LIVING ROOM", "TOILET", "BATHROOM")),
        (("Kinderzimmer", "Gäste-WC", "Essen", "Terrasse"), ("CHILD ROOM", "TOILET", "DINING ROOM", "TERRACE")),
    ],
)
def test_rooms_of_homes_in_several_languages(names, labels):
    labelled = label(*names)
    assert tuple(room.label for room in labelled) == labels
    assert labelled.building_types == ("home",)
    assert all(room.label_probabilities["home"][room.label or ""] > 0.8 for room in labelled)


@pytest.mark.parametrize(
    "names",
    [
        ("Classroom", "Library", "Hall", "Kitchen", "WC"),
        ("Office", "Meeting room", "Kitchen", "Toilet", "Store"),
        ("Kitchen", "Bath", "Hall"),
        ("Living room",),
        ("Lounge", "Kitchen", "Dining", "Office 1", "Office 2", "Office 3"),
        ("CH-3", "CH-4", "CH-7"),
        ("Primary sodium tank", "Main primary pump", "Primary hot cells"),
        ("Living room", "Bedroom", "Office 1", "Conference", "Reception", "Lab", "Canteen", "Auditorium"),
        (None, None),
    ],
)
def test_other_floors_are_no_homes(names):
    assert find_home_evidence(floor(*names)).probability == 0
    assert "home" not in label(*names).building_type


def test_the_probability_grows_with_the_rooms_of_a_home():
    """Two rooms: 1 - 0.3**2; a bedroom and a kitchen, which counts half: 1 - 0.3**1.5."""
    assert find_home_evidence(floor("Bedroom", "Living")).probability == pytest.approx(0.91)
    assert find_home_evidence(floor("Bedroom", "Kitchen")).probability == pytest.approx(0.8357, abs=1e-4)


def test_labels_of_the_coarser_sets_follow_from_those_of_homes():
    living, hall, unnamed = label("Living", "Hall", None, building_type="home")
    assert living.labels == {"R/C": "ROOM", "F/C/E/S": "FUNCTIONAL", "home": "LIVING ROOM"}
    assert hall.labels["R/C"] == "CORRIDOR"
    for room in (living, hall):
        assert sum(room.label_probabilities["F/C/E/S"].values()) == pytest.approx(1)
    assert set(unnamed.labels) == {str(LabelSet.R_C)}


def test_a_given_type_is_kept_and_so_are_manual_labels():
    named = floor("Bath", "Meeting", "Store")
    manual = Floor((named.rooms[0], Room(2, named[2].polygon, name="Bedroom", label="OFFICE"), named.rooms[2]))
    labelled = Labelling.make(None, None, None, "home").label(Floor(manual.rooms, building_type={"home": 1.0}))
    assert [room.label for room in labelled] == ["BATHROOM", "OFFICE", "STORAGE"]
    with pytest.raises(pianta.PiantaError, match="office, school, home"):
        Labelling.make(None, None, None, "castle")


def test_labels_of_corrected_rooms_follow_their_names():
    labelling = Labelling.make(None, None, None, None)
    before = labelling.label(floor("Living", "Bedroom", "Bath"))
    assert labelling.relabel(before.rename(3, "Kitchen"))[3].label == "KITCHEN"


def test_what_is_printed_about_a_home():
    def describe(rooms: Floor) -> str:
        return describe_type(replace(rooms, building_type={"home": 0.91}), ("office", "school"))

    assert describe(floor("Living", "Bath")) == "home 0.91, by the names of its rooms"
    assert describe(with_fixtures(floor(None), room_1="hob bath")) == "home 0.91, by its fixtures"
    assert describe(floor(None)) == "home 0.91, by its other storeys"


def with_fixtures(rooms: Floor, **kinds: str) -> Floor:
    """The floor with fixtures; kinds: room_1="bath hob" for two fixtures in room 1."""
    pieces = [
        Furniture(box(4 * int(room[5:]) + 1, 1, 4 * int(room[5:]) + 1.6, 1.6), 0.9, name)
        for room, listed in kinds.items()
        for name in listed.split()
    ]
    return replace(rooms, furniture=tuple(pieces))


def test_two_kinds_of_fixtures_of_homes_make_a_home():
    """1 - 0.3**2; one kind alone has 0.7, which is too little, and offices have toilets and sinks, too."""
    unnamed = floor(None, None, None)
    assert find_home_evidence(with_fixtures(unnamed, room_1="hob", room_2="bed")).probability == pytest.approx(0.91)
    assert find_home_evidence(with_fixtures(unnamed, room_1="hob sink", room_2="toilet")).probability == 0
    assert find_home_evidence(with_fixtures(unnamed, room_1="bed", room_2="bed")).probability == 0
    named = with_fixtures(floor("Living", None), room_2="hob")
    assert find_home_evidence(named).probability == pytest.approx(0.91)


def test_rooms_without_a_name_are_labelled_by_their_fixtures():
    rooms = with_fixtures(
        floor(None, None, None, "Store", None), room_1="hob sink", room_2="bed", room_3="toilet bath", room_4="bed"
    )
    labelled = Labelling.make(None, None, None, None).label(rooms)
    assert [room.label for room in labelled][:4] == ["KITCHEN", "BEDROOM", "BATHROOM", "STORAGE"]
    assert describe_type(labelled, ("office", "school")).endswith("by the names of its rooms and its fixtures")


@pytest.mark.parametrize(
    ("depth", "kinds", "label"),
    [
        (3, "toilet sink", "BATHROOM"),
        (1.2, "toilet", "TOILET"),
        (1.2, "toilet bath", "BATHROOM"),
        (9, "hob", "KITCHEN"),
    ],
)
def test_small_rooms_with_a_toilet_have_no_bath(depth, kinds, label):
    room = Floor((Room(1, box(4, 0, 6, depth)),))
    pieces = tuple(Furniture(box(4.5, 0.3, 4.8, 0.6), 0.9, name) for name in kinds.split())
    evidence = find_home_evidence(replace(room, furniture=pieces))
    probabilities = evidence.labels[1]
    assert max(probabilities, key=lambda name: probabilities[name]) == label


def test_finnish_homes_have_short_names():
    assert "home" in label("MH", "OH", "KK", "VH").building_type


def test_manual_labels_are_kept_by_label_home():
    rooms = Floor((Room(1, box(0, 0, 4, 3), name="Bath", label="KITCHEN"),))
    assert label_home(rooms, find_home_evidence(rooms))[1].label == "KITCHEN"


def test_each_word_of_homes_has_one_label():
    content = json.loads(Path(home.__file__).with_name("home_names.json").read_text(encoding="utf-8"))
    for language in ("en", "it", "de", "fr", "es", "pt", "sv", "fi", "ja"):
        words = [word for entry in content["kinds"] for word in entry["words"][language]]
        assert sorted(set(words)) == sorted(words), language
    assert {name for entry in content["kinds"] for name in entry["labels"]["home"]} <= set(HOME.by_name)


def test_all_storeys_of_a_house_are_a_home():
    """The cellar alone has too few names."""
    labelling = Labelling.make(None, None, None, None)
    storeys = [labelling.label(floor(*names)) for names in (["Kitchen", "Bedroom 1", "Living room"], ["Garage", None])]
    assert [each.building_types[:1] for each in storeys] != [("home",), ("home",)]
    shared = labelling.share_home(storeys)
    assert [each.building_types for each in shared] == [("home",), ("home",)]
    assert shared[1][1].label == "GARAGE"


def test_a_flat_above_offices_makes_no_home_of_them():
    labelling = Labelling.make(None, None, None, None)
    offices = floor("Office", "Meeting room", "Office", "Archive", "Reception", "Office")
    storeys = [labelling.label(each) for each in (floor("Kitchen", "Bedroom", "Living room"), offices)]
    assert labelling.share_home(storeys) == storeys


def test_a_given_type_of_a_storey_stays():
    labelling = Labelling.make(None, None, None, None)
    house = labelling.label(floor("Kitchen", "Bedroom", "Living room"))
    school = replace(labelling.label(floor("Garage")), building_type={"school": 1.0})
    assert labelling.share_home([house, school])[1] == school
