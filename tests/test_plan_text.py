"""Texts of a sheet are read with rapidocr, and their letters are removed from the ink, but not its walls."""

import socket

import cv2
import numpy as np
import pytest

from pianta.plan.sheets.sheet import PlacedText, Sheet
from pianta.plan.text import recognition as plan_text
from pianta.plan.text.detection import text_reader
from pianta.plan.text.recognition import erase_texts, read_texts, remove_texts, text_reader_available
from pianta.worlds.plans.name_sheets import letter_rooms


def placed(text: str, top: float, left: float, height: float, width: float) -> PlacedText:
    bottom, right = top + height, left + width
    return PlacedText(text, np.array([(top, left), (top, right), (bottom, right), (bottom, left)], float))


def test_a_reader_needs_both_of_its_packages(monkeypatch):
    for missing in ("rapidocr", "openvino"):
        monkeypatch.setattr(plan_text, "find_spec", lambda name, missing=missing: None if name == missing else object())
        assert not text_reader_available()
    monkeypatch.setattr(plan_text, "find_spec", lambda name: object())
    assert text_reader_available()


def test_processors_with_bfloat16_read_as_others():
    pytest.importorskip("rapidocr")
    reader = text_reader()
    for stage in (reader._load_det_model(), reader._load_rec_model()):
        compiled = stage.session.session.get_compiled_model()
        assert compiled.get_property("INFERENCE_PRECISION_HINT").get_type_name() == "f32"
        assert compiled.get_property("INFERENCE_NUM_THREADS") == 1


def test_texts_are_read_level_and_upright_without_a_network(monkeypatch):
    pytest.importorskip("rapidocr")

    def refuse(*_, **__):
        raise AssertionError("the internet is used")

    monkeypatch.setattr(socket.socket, "connect", refuse)
    monkeypatch.setattr(socket, "getaddrinfo", refuse)
    text_reader.cache_clear()
    names = "204 French", "Büro"
    level, upright = letter_rooms(names, capital=9), letter_rooms(names, capital=14, rotation=90)
    page = np.full((level.colors.shape[0] + upright.colors.shape[0], 420, 3), 255, np.uint8)
    for sheet, row in ((level, 0), (upright, level.colors.shape[0])):
        height, width = sheet.colors.shape[:2]
        page[row : row + height, :width] = sheet.colors
    texts = read_texts(page)
    assert sorted(text.text for text in texts) == sorted(2 * names)
    for text in texts:
        right, down = text.corners[1] - text.corners[0], text.corners[3] - text.corners[0]
        # Upright names are read from below upwards, so their lines go on to the right
        is_level = text.middle[0] < level.colors.shape[0]
        assert right[1] > 3 * abs(right[0]) if is_level else -right[0] > 3 * abs(right[1])
        assert down[0 if is_level else 1] > 0
        assert 0.5 <= text.confidence <= 1
        assert 8 < text.height < 40
    by_row = {text.text: text.middle for text in texts if text.middle[0] < level.colors.shape[0]}
    top, left, bottom, right_end = level.names[0].room
    assert by_row["204 French"] == pytest.approx([(top + bottom) / 2, (left + right_end) / 2], abs=3)


def test_a_mirrored_sheet_is_read_in_a_mirror():
    """Texts run to the left and their lines down; the same sheet as it is, and one with few texts, is not mirrored."""
    pytest.importorskip("rapidocr")
    names = "Kitchen", "Bedroom", "Storage", "Bathroom", "Office"
    page = np.full((60 * len(names), 240, 3), 255, np.uint8)
    for row, name in enumerate(names):
        page[60 * row :][:60] = _lettered(name)
    mirrored = np.ascontiguousarray(page[:, ::-1])
    texts = read_texts(mirrored)
    assert [text.text for text in texts] == list(names)
    for row, text in enumerate(texts):
        right, down = text.corners[1] - text.corners[0], text.corners[3] - text.corners[0]
        assert (text.is_mirrored, right[1] < 0, down[0] > 0) == (True, True, True)
        assert 60 * row < text.middle[0] < 60 * (row + 1)
    upright = read_texts(page)
    assert [(text.text, text.is_mirrored) for text in upright] == [(name, False) for name in names]
    for text, other in zip(texts, upright, strict=True):
        assert text.middle == pytest.approx([other.middle[0], 240 - other.middle[1]], abs=3)
    assert not any(text.is_mirrored for text in read_texts(mirrored[:120]))


def _lettered(name: str) -> np.ndarray:
    strip = np.full((60, 240, 3), 255, np.uint8)
    cv2.putText(strip, name, (20, 40), cv2.FONT_HERSHEY_SIMPLEX, 1.0, (0, 0, 0), 2, cv2.LINE_AA)
    return strip


def test_a_sheet_without_ink_has_no_texts():
    pytest.importorskip("rapidocr")
    assert read_texts(np.full((40, 70, 3), 255, np.uint8)) == ()


@pytest.mark.parametrize(
    ("read", "expected"),
    [
        ("CLASSR0OM  12", "CLASSROOM 12"),
        ("CLASSR00M", "CLASSROOM"),
        ("st0re", "store"),
        ("B101", "B101"),
        ("100", "100"),
        ("R0", "R0"),
        (" WC ", "WC"),
    ],
)
def test_a_zero_between_letters_is_an_o(read, expected):
    assert plan_text._normalise(read) == expected


def test_drawn_circles_and_signs_of_another_script_are_no_texts():
    texts = [placed(text, 0, 0, 1, 1) for text in ("0000", "国", "Büro", "○", "WC 口", "102")]
    assert [text.text for text in plan_text._without_symbols(texts)] == ["Büro", "○", "102"]
    asian = [placed(text, 0, 0, 1, 1) for text in ("会議室", "事務所", "WC")]
    assert plan_text._without_symbols(asian) == asian


def test_letters_are_removed_and_walls_stay():
    """A text of three letters, of which one touches the wall below, beside a wall that runs through the box."""
    ink = np.zeros((30, 60), bool)
    ink[20, :] = True
    ink[:, 40] = True
    walls = ink.copy()
    for col in (10, 16, 22):
        ink[10:17, col : col + 2] = True
    ink[17:20, 22] = True
    left = remove_texts(ink, [placed("ITI", 9, 8, 9, 36)])
    assert (left == walls).all()


def test_a_diagonal_wall_through_a_text_and_ink_far_from_it_stay():
    ink = np.zeros((60, 60), bool)
    ink[np.arange(60), np.arange(60)] = True
    ink[5:9, 50:53] = True
    walls = ink.copy()
    ink[27:33, 15:17] = True
    assert (remove_texts(ink, [placed("I", 25, 10, 10, 40)]) == walls).all()


def test_an_upright_text_and_one_at_the_border_are_removed():
    ink = np.zeros((50, 20), bool)
    ink[10:40:4, 5:12] = True
    corners = np.array([(42, 4), (8, 4), (8, 13), (42, 13)], float)
    ink[0:3, 15:20] = True
    beyond = placed("x", -2, 13, 6, 9)
    assert not remove_texts(ink, [PlacedText("NAME", corners), beyond]).any()


def test_the_ink_itself_is_not_changed_and_no_text_changes_nothing():
    ink = np.zeros((20, 20), bool)
    ink[8:12, 8:12] = True
    before = ink.copy()
    assert (remove_texts(ink, []) == before).all()
    assert not remove_texts(ink, [placed("o", 7, 7, 6, 6)]).any()
    assert (ink == before).all()
    assert (remove_texts(ink, [placed("o", 90, 90, 6, 6)]) == before).all()


def lettered(room: tuple[int, int, int], ink: int) -> tuple[np.ndarray, np.ndarray]:
    """A coloured room in walls with a stroke and a dot in it; and the same without these."""
    bare = np.full((80, 120, 3), room, np.uint8)
    bare[[10, 11, 68, 69]] = bare[:, [10, 11, 108, 109]] = ink
    colors = bare.copy()
    colors[34:46, 50:53] = colors[34:37, 58:61] = ink
    return colors, bare


@pytest.mark.parametrize(("room", "ink"), [((255, 255, 255), 0), ((253, 226, 170), 30), ((20, 40, 90), 250)])
def test_where_letters_stood_is_the_colour_of_the_room(room, ink):
    """Also of light lines on dark paper."""
    colors, bare = lettered(room, ink)
    before = colors.copy()
    erased = erase_texts(Sheet(colors), [placed("l'", 32, 46, 16, 20)])
    assert np.array_equal(erased.colors, bare)
    assert np.array_equal(colors, before)


def test_without_letters_the_sheet_is_the_same():
    colors, _ = lettered((255, 255, 255), 0)
    sheet = Sheet(colors)
    assert np.array_equal(erase_texts(sheet, []).colors, colors)
    assert np.array_equal(erase_texts(sheet, [placed("x", 55, 20, 8, 8)]).colors, colors)


def test_soft_edges_of_letters_are_removed():
    colors, bare = lettered((255, 255, 255), 0)
    colors[34:46, [49, 53]] = 210
    assert np.array_equal(erase_texts(Sheet(colors), [placed("l'", 32, 46, 16, 20)]).colors, bare)


@pytest.mark.slow
def test_a_text_larger_than_the_sheet_needs_no_memory():
    colors, _ = lettered((255, 255, 255), 0)
    erased = erase_texts(Sheet(colors), [placed("x", -1e9, -1e9, 2e9, 2e9)])
    assert erased.colors.shape == colors.shape
