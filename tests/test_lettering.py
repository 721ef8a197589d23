"""Sheets of lettered rooms are what they say, and what is read of them is counted."""

import numpy as np
import pytest

from pianta.errors import OptionError
from pianta.plan.text.recognition import read_texts
from pianta.worlds.plans.name_sheets import FONTS, NAMES, letter_rooms
from pianta_bench.plans import text as plan_text
from pianta_bench.plans.tables import derive_exact_names
from pianta_bench.plans.text import PART, measure_text
from tests.bench_results import list_rows


def ink_of(sheet, number: int):
    """Ink inside the walls of a room, rows and columns where there is any."""
    top, left, bottom, right = sheet.names[number].room
    ink = sheet.colors[top:bottom, left:right, 0] < 128
    return np.flatnonzero(ink.any(axis=1)), np.flatnonzero(ink.any(axis=0)), ink.shape


@pytest.mark.parametrize("font", FONTS)
@pytest.mark.parametrize("capital", [10, 16, 28])
def test_capitals_have_the_given_height_and_are_centred(font, capital):
    sheet = letter_rooms(["HHH", "HE"], font=font, capital=capital)
    for number in (0, 1):
        rows, cols, (height, width) = ink_of(sheet, number)
        assert rows[-1] - rows[0] + 1 == pytest.approx(capital, abs=1.5)
        assert (rows[0] + rows[-1] + 1) / 2 == pytest.approx(height / 2, abs=2)
        assert (cols[0] + cols[-1] + 1) / 2 == pytest.approx(width / 2, abs=2)


def test_upright_names_are_level_ones_turned_to_the_left():
    level, upright = (letter_rooms(["LAB 1"], capital=12, rotation=rotation, columns=1) for rotation in (0, 90))
    assert (np.rot90(level.colors) == upright.colors).all()


def test_rooms_lie_row_by_row_between_walls():
    sheet = letter_rooms(["A", "B", "C"], capital=10, columns=2)
    assert [name.text for name in sheet.names] == ["A", "B", "C"]
    (top, left, bottom, right), (_, second, *_), (third, *_) = (name.room for name in sheet.names)
    assert second > right
    assert third > bottom
    assert (sheet.colors[top - 1, left:right] == 0).all()
    assert (sheet.colors[top:bottom, left - 1] == 0).all()
    assert (sheet.colors[0] == 255).all()
    assert sheet.colors.dtype == np.uint8


def test_names_are_in_five_languages_and_none_twice_within_one():
    assert set(NAMES) == {"en", "it", "de", "fr", "es"}
    assert all(len(set(names)) == len(names) for names in NAMES.values())
    assert any(not name.isascii() for names in NAMES.values() for name in names)


@pytest.mark.parametrize(
    ("names", "options", "message"),
    [
        ([], {}, "names"),
        (["A"], {"font": "Comic"}, "Comic"),
        (["A"], {"rotation": 45}, "rotation"),
        (["A"], {"capital": 3}, "capital"),
        (["A"], {"columns": 0}, "columns"),
    ],
)
def test_invalid_options_are_refused(names, options, message):
    with pytest.raises(OptionError, match=message):
        letter_rooms(names, **options)


def test_names_are_counted_by_font_size_and_rotation(monkeypatch):
    """A reader that finds the first sheet's names only, the other texts not at all."""
    pytest.importorskip("rapidocr")
    shapes = []

    def read_once(colors):
        shapes.append(colors.shape)
        return read_texts(colors) if len(shapes) == 1 else ()

    monkeypatch.setattr(plan_text, "read_texts", read_once)
    results = measure_text(fonts=["DejaVuSans"], capitals=[16], rotations=[0, 90], names=["LAB 1", "Library"])
    rows = list_rows(results, PART)
    assert [row.item for row in rows] == ["DejaVuSans 16 px 0°", "DejaVuSans 16 px 90°"]
    assert [row.figures for row in rows] == [
        {"names": 2, "exact": 2, "share": 100.0, "found": 100.0},
        {"names": 2, "exact": 0, "share": 0.0, "found": 0.0},
    ]
    shares = {record["sheets"]: record["value"] for record in derive_exact_names(results.records)}
    assert shares == {"all": 50.0, "DejaVuSans": 50.0, "16 px": 50.0, "0°": 100.0, "90°": 0.0}
    assert not results.failed
