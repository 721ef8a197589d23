"""Misread numbers of rooms are corrected by those of the other rooms."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import box

from pianta.floor import Floor, Room
from pianta.plan.text.room_numbers import correct_numbers, correct_room_numbers


@pytest.mark.parametrize(
    ("numbers", "last"),
    [
        (["2502A", "2502B", "25020"], "2502C"),
        (["2502A", "2502C", "25028"], "2502B"),
        (["2502A", "2502B", "2502C", "25020"], "2502D"),
        (["12B", "12C", "124"], "12A"),
        # One sibling is too few, and O and D are no letters that come next
        (["2502A", "25020"], "25020"),
        (["2502A", "2502F", "25020"], "25020"),
        (["2504A", "2504B", "25020"], "25020"),
        (["2502A", "2502B", "25027"], "25027"),
        (["2502A", "2502B", "Office"], "Office"),
    ],
)
def test_a_digit_becomes_the_letter_that_is_missing(numbers, last):
    assert correct_numbers(numbers) == [*numbers[:-1], last]


@given(st.lists(st.from_regex(r"\d{2,4}[A-Z0-9]?", fullmatch=True), max_size=12))
def test_only_the_last_digit_changes_and_no_number_becomes_that_of_another_room(numbers):
    corrected = correct_numbers(numbers)
    for before, after in zip(numbers, corrected, strict=True):
        assert before[:-1] == after[:-1]
        assert before == after or after not in numbers


def test_names_of_rooms_keep_what_follows_the_number():
    names = ["2502A Lab", "2502B", "25020 Office 8", None]
    floor = Floor(tuple(Room(k, box(k, 0, k + 1, 1), name=name) for k, name in enumerate(names, start=1)))
    assert [room.name for room in correct_room_numbers(floor)] == ["2502A Lab", "2502B", "2502C Office 8", None]
