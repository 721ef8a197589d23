"""Legends are found by their lines, and rooms in rows are no legend."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.text import legend as plan_legend
from pianta.plan.text.legend import find_legend, standard_key


def line(text: str, row: float, col: float = 0.0, *, height: float = 10.0, width: float | None = None) -> PlacedText:
    right = col + (0.6 * height * len(text) if width is None else width)
    return PlacedText(text, np.array([(row, col), (row, right), (row + height, right), (row + height, col)]))


def column(*texts: str, col: float = 0.0, step: float = 14.0) -> list[PlacedText]:
    return [line(text, step * number, col) for number, text in enumerate(texts)]


@pytest.mark.parametrize(
    ("texts", "entries"),
    [
        (["1. Vestibule", "2. Lobby"], {"1": "Vestibule", "2": "Lobby"}),
        (["1—Main Office", "2—Health Room", "3—Workroom"], {"1": "Main Office", "2": "Health Room", "3": "Workroom"}),
        (["II. COMPUTER ROOM", "12. STORAGE"], {"11": "COMPUTER ROOM", "12": "STORAGE"}),
        (["A - Office", "B - Lab"], {"A": "Office", "B": "Lab"}),
        (["A: Büro", "B: Küche"], {"A": "Büro", "B": "Küche"}),
        (["7) Nurse", "8 & 9) Offices"], {"7": "Nurse", "8": "Offices", "9": "Offices"}),
        (["8—Nurse", "9 - 11—Classrooms"], {"8": "Nurse", "9": "Classrooms", "10": "Classrooms", "11": "Classrooms"}),
        (["Legend", "1 Main office", "2 Health room"], {"1": "Main office", "2": "Health room"}),
        (["Légende :", "01 Accueil", "02 Bureau"], {"1": "Accueil", "2": "Bureau"}),
        (["1 Aula", "2 Bagno", "3 Atrio", "4 Scala"], {"1": "Aula", "2": "Bagno", "3": "Atrio", "4": "Scala"}),
    ],
)  # fmt: skip
def test_lines_below_each_other_are_a_legend(texts, entries):
    legend = find_legend(column(*texts))
    assert legend.entries == entries
    assert {text.text for text in legend.texts} == set(texts)


def test_keys_and_names_that_stand_apart_belong_together():
    texts = [line("Legend", 0)]
    for number, (key, name) in enumerate((("9.", "Principal"), ("10.", "Toilet"), ("11.", "Faculty")), start=1):
        texts += [line(key, 14.0 * number, 6 - 3 * len(key)), line(name, 14.0 * number + 1, 30)]
    legend = find_legend(texts)
    assert legend.entries == {"9": "Principal", "10": "Toilet", "11": "Faculty"}
    assert len(legend.texts) == 7


@pytest.mark.parametrize("width", [4, 8, 9, 10, 12])
def test_a_key_narrower_than_half_its_height_is_not_beside_itself(width):
    texts = [line("Legend", 0, height=20)]
    for number, name in enumerate(("Office", "Lab", "Gym"), start=1):
        texts += [line(str(number), 28 * number, height=20, width=width), line(name, 28 * number, 30, height=20)]
    assert find_legend(texts).entries == {"1": "Office", "2": "Lab", "3": "Gym"}


def test_two_columns_are_read_and_other_texts_are_not_used():
    texts = column("1—Office", "2—Lab", "3—Gym") + column("4—Stage", "5—Kitchen", col=200)
    title = line("Plan of 3 floors", 300)
    legend = find_legend([title, *texts])
    assert legend.entries == {"1": "Office", "2": "Lab", "3": "Gym", "4": "Stage", "5": "Kitchen"}
    assert title not in legend.texts


@pytest.mark.parametrize(
    "texts",
    [
        [],
        column("1. Vestibule"),
        column("201 French", "202 Art", "203 Music"),
        column("1. Vestibule", "2. Lobby", step=80),
        [line("1. Vestibule", 0), line("2. Lobby", 14, 90)],
        column("7. Office", "7. Office"),
        column("31. Office", "4. Lab"),
        column("1. Vestibule", "2. 30 m2"),
        [line("1. Vestibule", 0), line("2. Lobby", 14, height=30)],
        column("Legend", "Fire extinguisher", "Hydrant"),
    ],
)
def test_other_texts_are_no_legend(texts):
    legend = find_legend(texts)
    assert (dict(legend.entries), legend.texts) == ({}, ())


def test_upright_lines_are_no_legend():
    upright = [
        PlacedText(text, np.array([(100, col), (0, col), (0, col + 10), (100, col + 10)], float))
        for text, col in (("1. Office", 0.0), ("2. Lab", 14.0))
    ]
    assert not find_legend(upright).entries


def test_a_legend_finds_names_by_their_keys():
    legend = find_legend(column("1. Vestibule", "2. Lobby", "2. Hall", "3. WC"))
    names = [legend.find_name(text) for text in ("2", "02", " 1. ", "(1)", "4", "Lobby")]
    assert names == ["Lobby", "Lobby", "Vestibule", "Vestibule", None, None]


@pytest.mark.parametrize(("text", "key"), [("7.", "7"), ("007", "7"), ("0", "0"), ("a)", "A"), (" 12b ", "12B")])
def test_standard_keys(text, key):
    assert standard_key(text) == key


@given(st.lists(st.tuples(st.text(max_size=30), st.floats(0, 200), st.floats(0, 200)), max_size=12))
def test_every_entry_comes_from_a_text_that_is_used(positions):
    texts = [line(text, row, col) for text, row, col in positions]
    legend = find_legend(texts)
    assert set(map(id, legend.texts)) <= set(map(id, texts))
    read = " ".join(word for text in legend.texts for word in text.text.split())
    assert all(name in read for name in legend.entries.values())
    assert not legend.entries or len(legend.texts) >= 2


@pytest.mark.slow
def test_a_legend_is_found_among_twenty_thousand_numbers():
    """Most of them on one line, as dimensions are."""
    numbers = [line(str(number % 999), 500, 0.2 * number) for number in range(15_000)]
    numbers += [line(str(number % 999), 600 + 20 * (number // 100), 40 * (number % 100)) for number in range(5_000)]
    legend = find_legend([*numbers, *column("Legend", "1 - Office", "2 - Lab")])
    assert legend.entries == {"1": "Office", "2": "Lab"}


def test_an_entry_with_too_many_keys_is_ignored():
    assert len(find_legend(column("1-100 - Room", "101 - Hall")).entries) == 101
    assert not find_legend(column("1-80,101-181 - Room", "182 - Hall")).entries


def test_no_legend_has_more_entries_than_the_limit(monkeypatch):
    monkeypatch.setattr(plan_legend, "MAX_ENTRIES", 3)
    assert find_legend(column("1. Vestibule", "2. Lobby", "3. Hall", "4. WC")).entries.keys() == {"1", "2", "3"}
