"""The words in names of rooms that were misread."""

import pytest
from shapely import box

from pianta.floor import Floor, Room
from pianta.rooms.home import read_home_dictionary
from pianta.rooms.name_dictionary import read_default_room_name_dictionary
from pianta.rooms.spelling import correct_name, correct_spelling, list_vocabulary

WORDS = (read_default_room_name_dictionary(), read_home_dictionary())


def make_floor(*names: str | None) -> Floor:
    return Floor(
        rooms=tuple(Room(id=i, polygon=box(i, 0, i + 0.9, 1), name=name) for i, name in enumerate(names, start=1)),
        doors=(),
    )


def names_of(floor: Floor) -> list[str | None]:
    return [room.name for room in floor]


@pytest.mark.parametrize(
    ("read", "right"),
    [
        ("BURO 3", "BÜRO 3"),
        ("Kuche", "Küche"),
        ("DUREAU MEDECIN", "BUREAU MEDECIN"),
        ("Medecin", "Médecin"),
        ("MINDFANG", "WINDFANG"),
        ("Bedroam", "Bedroom"),
    ],
)
def test_misread_words_are_mended(read: str, right: str) -> None:
    assert correct_name(read, list_vocabulary([read], WORDS)) == right


@pytest.mark.parametrize(
    "name",
    [
        "BÜRO 3",
        "Bathrooms",  # a plural
        "DORMITORIO",  # Spanish; DORMITÓRIO is Portuguese
        "Hale",  # too short to be a misread hall
        "Smith",
        "洋室",
        "2502C",
        "",
    ],
)
def test_other_names_stay(name: str) -> None:
    assert correct_name(name, list_vocabulary([name], WORDS)) == name


def test_rooms_of_the_same_floor_show_the_right_spelling() -> None:
    floor = make_floor("DORMITORIO 2", "DORMITÓRIO 1", None)
    assert names_of(correct_spelling(floor, *WORDS)) == ["DORMITÓRIO 2", "DORMITÓRIO 1", None]
