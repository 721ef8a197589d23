"""Rooms get the names that stand in them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import box

from pianta.floor import MAX_ROOM_NAME_LENGTH, Floor, Room
from pianta.gridmap import GridMap
from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.text.legend import Legend
from pianta.plan.text.room_names import compose_room_name, name_rooms

# 10 m × 6 m at 0.05 m per pixel; the map frame starts at (-2, 3).
GRID = GridMap(np.zeros((120, 200), np.int8), 0.05, (-2.0, 3.0, 0.0))
LEFT, RIGHT = Room(1, box(-2, 3, 3, 9)), Room(2, box(3, 3, 8, 9), name="Older")
LEGEND = Legend({"19": "Classroom", "7": "Office", "8": "Office", "A": "Lab"})


def line(text: str, row: float, col: float, *, height: float = 10.0, width: float = 40.0) -> PlacedText:
    """A level text whose middle lies at row and col."""
    top, bottom, left, right = row - height / 2, row + height / 2, col - width / 2, col + width / 2
    return PlacedText(text, np.array([(top, left), (top, right), (bottom, right), (bottom, left)]))


def upright(text: str, row: float, col: float) -> PlacedText:
    """A text that is read from below upwards, its middle at row and col."""
    corners = [(row + 20, col - 5), (row - 20, col - 5), (row - 20, col + 5), (row + 20, col + 5)]
    return PlacedText(text, np.array(corners, float))


def names_of(*texts: PlacedText, legend: Legend | None = None) -> list[str | None]:
    return [room.name for room in name_rooms(Floor((LEFT, RIGHT)), texts, GRID, legend).rooms]


def test_a_text_names_the_room_around_its_middle():
    assert names_of(line("Lab", 20, 30), line("WC", 100, 150)) == ["Lab", "WC"]
    assert names_of(line("Lab", 20, 96)) == ["Lab", "Older"]
    assert names_of(line("Lab", -20, 30)) == [None, "Older"]
    assert names_of() == [None, "Older"]


def test_nothing_but_names_changes():
    floor = Floor((LEFT, RIGHT), source="plan.png", building_type={"school": 1.0})
    named = name_rooms(floor, [line("Lab", 20, 30)], GRID)
    assert [room.id for room in named.rooms] == [1, 2]
    assert (named.source, named.building_type, named.rooms[0].polygon) == ("plan.png", {"school": 1.0}, LEFT.polygon)


def test_a_line_over_two_rooms_is_split():
    assert names_of(line("203 204", 20, 100, width=70)) == ["203", "204"]
    assert names_of(line("Main office", 20, 60, width=80)) == ["Main office", "Older"]


@pytest.mark.parametrize(
    ("texts", "name"),
    [
        ([line("ROOM", 62, 50), line("CLASS", 50, 52)], "CLASS ROOM"),
        # Codes of furniture, and the height of a sill
        ([line("BEDROOM", 40, 40), line("L", 100, 80, width=8)], "BEDROOM"),
        ([line("BATH", 40, 40), line("TM", 40, 80, width=16)], "BATH"),
        ([line("BALCONY", 40, 40), line("BH=400", 100, 80)], "BALCONY"),
        ([line("U/M", 40, 40), line("LIVING", 80, 40)], "LIVING"),
        ([line("WC", 40, 40, width=16), line("H", 40, 56, width=8)], "WC H"),
        ([line("ET", 40, 40, width=16)], "ET"),
        ([line("B-12", 40, 40), line("OFFICE", 80, 40)], "B-12 OFFICE"),
        ([line("RIUNIONI", 50, 95), line("SALA", 50, 50)], "SALA RIUNIONI"),
        ([line("func-", 50, 50), line("tional", 62, 50)], "functional"),
        ([line("B-", 50, 50), line("12", 62, 50)], "B- 12"),
        ([line("204", 20, 50), line("French", 60, 50)], "204 French"),
        ([line("French", 20, 50), line("204", 60, 50)], "204 French"),
        ([upright("CLASS", 50, 50), upright("ROOM", 50, 62)], "CLASS ROOM"),
        ([line("BEDROOM 11' x 10'", 50, 50)], "BEDROOM"),
        ([line("Office", 50, 50), line("11' x 10'", 62, 50), line("12.5 m²", 74, 50)], "Office"),
        ([line("OFFICE", 50, 50), line("1Y-3° × 154", 62, 50), line("X", 74, 50), line("00", 86, 50)], "OFFICE"),
        ([line("UP", 20, 50), line("Hall", 80, 50)], "Hall"),
        ([line("Gymnasium", 30, 50, height=20), line("hoop", 100, 50)], "Gymnasium"),
        ([line("24 X 30", 50, 50)], None),
        ([line("3.50 m", 50, 50), line("DN", 90, 50), line("—", 70, 50)], None),
        ([line("12", 50, 50), line("13", 90, 50)], "12"),
        ([line("a\tb\u200b", 50, 50)], "a b"),
        ([line("x" * 300, 50, 50)], "x" * MAX_ROOM_NAME_LENGTH),
        ([], None),
    ],
)
def test_texts_of_a_room_become_its_name(texts, name):
    assert compose_room_name(texts) == name
    assert compose_room_name(texts[::-1]) == name


@pytest.mark.parametrize(
    ("texts", "name"),
    [
        ([line("19", 50, 50)], "Classroom"),
        ([line("a.", 50, 50)], "Lab"),
        ([line("19", 50, 50), line("Q", 50, 95)], "Classroom"),
        ([line("7", 30, 50), line("8", 60, 50), line("19", 90, 50)], "Office Classroom"),
        ([line("19", 20, 50), line("Kiln", 80, 50)], "19 Kiln"),
        ([line("20", 50, 50)], "20"),
    ],
)
def test_numbers_get_their_name_from_the_legend(texts, name):
    assert compose_room_name(texts, LEGEND) == name


def test_texts_of_the_legend_name_no_room():
    key = line("19. Classroom", 50, 50)
    legend = Legend({"19": "Classroom"}, (key,))
    assert names_of(key, line("19", 50, 150), legend=legend) == [None, "Classroom"]


@pytest.mark.slow
@given(st.lists(st.tuples(st.text(max_size=20), st.floats(0, 120), st.floats(0, 200)), max_size=8))
def test_every_name_is_valid_for_a_room(positions):
    texts = [line(text, row, col) for text, row, col in positions]
    name = compose_room_name(texts)
    assert name is None or Room(1, box(0, 0, 1, 1), name=name).name == name
    assert len(name_rooms(Floor((LEFT, RIGHT)), texts, GRID).rooms) == 2
