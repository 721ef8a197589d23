"""Symbols are detected where they were drawn, in every pose and size, and removed without the walls."""

from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pianta.plan.sheets.sheet import Sheet
from pianta.plan.symbols.detection import find_symbols, remove_symbols
from pianta.plan.symbols.drawings import draw_symbol, frame_symbol
from pianta.plan.symbols.templates import Template, builtin_templates, read_symbol_folder

Image = NDArray[Any]

WHITE = 255


def named(*names: str) -> tuple[Template, ...]:
    return tuple(template for template in builtin_templates() if template.name in names)


def blank(height: int = 240, width: int = 320) -> Image:
    return np.full((height, width, 3), WHITE, np.uint8)


def draw_over(sheet: Image, image: Image, row: int, col: int) -> None:
    """Draw an image over a sheet with its upper left corner at row, col."""
    image = np.repeat(image[:, :, None], 3, axis=2) if image.ndim == 2 else image
    part = sheet[row : row + image.shape[0], col : col + image.shape[1]]
    np.minimum(part, image, out=part)


def jambs_of(name: str, size_px: float, stroke_px: int = 2) -> Image:
    _, matrix = frame_symbol(name, size_px=size_px, stroke_px=stroke_px)
    return np.asarray(np.array([(0.0, 0.0), (1.0, 0.0)]) @ matrix[:, :2].T[:, ::-1] + matrix[::-1, 2])


def turned(points: Image, shape: tuple[int, ...], quarters: int) -> Image:
    for _ in range(quarters):
        points = np.column_stack([shape[1] - points[:, 1], points[:, 0]])
        shape = shape[::-1]
    return points


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("quarters", [0, 1, 2, 3])
def test_a_door_is_found_in_every_pose(quarters, mirrored):
    image = draw_symbol("door", size_px=32, stroke_px=2)
    jambs = jambs_of("door", 32)
    if mirrored:
        image, jambs = image[:, ::-1], jambs * (1, -1) + (0, image.shape[1])
    jambs = turned(jambs, image.shape, quarters) + np.array([80, 120])
    sheet = blank()
    draw_over(sheet, np.rot90(image, quarters), 80, 120)
    (symbol,) = find_symbols(Sheet(sheet), door_px=32, templates=named("door"))
    assert (symbol.name, symbol.kind) == ("door", "door")
    assert symbol.score > 0.7
    assert symbol.jambs is not None
    jambs_found = symbol.jambs[np.lexsort(symbol.jambs.round().T)]
    assert np.abs(jambs_found - jambs[np.lexsort(jambs.round().T)]).max() < 4


@pytest.mark.parametrize("size", [0.8, 1.0, 1.3])
@pytest.mark.parametrize("door_px", [16, 32, 60])
def test_a_door_is_found_at_other_sizes_than_expected(door_px, size):
    sheet = blank(400, 400)
    draw_over(sheet, draw_symbol("door", size_px=door_px * size, stroke_px=max(1, door_px // 16)), 150, 180)
    (symbol,) = find_symbols(Sheet(sheet), door_px=door_px, templates=named("door"))
    assert symbol.jambs is not None
    assert np.hypot(*np.diff(symbol.jambs, axis=0)[0]) == pytest.approx(door_px * size, rel=0.2)


def test_the_noise_of_jpeg_hides_no_door():
    sheet = blank()
    draw_over(sheet, draw_symbol("door", size_px=32, stroke_px=2), 80, 120)
    noisy = np.asarray(cv2.imdecode(cv2.imencode(".jpg", sheet, [cv2.IMWRITE_JPEG_QUALITY, 40])[1], 1))
    (symbol,) = find_symbols(Sheet(noisy), door_px=32, templates=named("door"))
    assert np.abs(symbol.corners.min(axis=0) - (80, 120)).max() < 5


@pytest.mark.parametrize("paper", [(255, 255, 255), (110, 204, 135)])
def test_doors_of_thin_lines_on_white_and_green_are_found(paper):
    sheet = np.full((240, 320, 3), paper, np.uint8)
    cv2.rectangle(sheet, (20, 20), (300, 220), (100, 100, 100), 5)
    door = draw_symbol("door", size_px=32, stroke_px=1)[:, :, None] < 128
    part = sheet[80 : 80 + door.shape[0], 120 : 120 + door.shape[1]]
    part[:] = np.where(door, (part * 0.85).astype(np.uint8), part)
    symbols = find_symbols(Sheet(sheet), door_px=32, templates=named("door"))
    assert [symbol.name for symbol in symbols] == ["door"]


def test_signs_are_found_by_their_colours_at_any_size():
    sheet = blank()
    cv2.rectangle(sheet, (20, 20), (300, 220), (0, 0, 0), 4)
    signs = {"extinguisher": (60, 60, 16), "first aid": (60, 200, 24), "exit": (150, 100, 34)}
    for name, (row, col, side) in signs.items():
        draw_over(sheet, draw_symbol(name, size_px=side), row, col)
    symbols = {symbol.name: symbol for symbol in find_symbols(Sheet(sheet), door_px=24, templates=builtin_templates())}
    assert symbols.keys() == signs.keys()
    for name, (row, col, side) in signs.items():
        assert symbols[name].jambs is None
        assert np.abs(symbols[name].corners.mean(axis=0) - (row + side / 2 + 2, col + side / 2 + 2)).max() < 3


def test_signs_in_a_row_are_separate_and_found_on_green_routes():
    sheet = blank()
    sheet[60:140, 40:280] = (110, 204, 135)
    sign = draw_symbol("hydrant", size_px=24)[2:-2, 2:-2]
    for col in (100, 124, 148):
        sheet[90:114, col : col + 24] = sign
    symbols = find_symbols(Sheet(sheet), door_px=24, templates=named("hydrant"))
    assert sorted(round(symbol.corners[:, 1].mean() / 12) for symbol in symbols) == [9, 11, 13]


def test_doors_are_searched_only_near_given_points():
    sheet = blank()
    for col in (40, 220):
        draw_over(sheet, draw_symbol("door", size_px=32, stroke_px=2), 100, col)
    assert len(find_symbols(Sheet(sheet), door_px=32, templates=named("door"))) == 2
    (symbol,) = find_symbols(Sheet(sheet), door_px=32, templates=named("door"), near=[(115, 235)])
    assert symbol.corners[:, 1].mean() > 200
    assert find_symbols(Sheet(sheet), door_px=32, templates=named("door"), near=np.zeros((0, 2))) == ()


@settings(max_examples=10)
@given(st.integers(20, 180), st.integers(20, 260), st.integers(0, 3))
def test_quarter_turns_of_a_sheet_turn_its_symbols(row, col, quarters):
    sheet = blank()
    draw_over(sheet, draw_symbol("door", size_px=28, stroke_px=2), row, col)
    (symbol,) = find_symbols(Sheet(np.rot90(sheet, quarters)), door_px=28, templates=named("door"))
    middle = turned(np.array([(row + 17.0, col + 17.0)]), (240, 320), quarters)[0]
    assert np.abs(symbol.corners.mean(axis=0) - middle).max() < 4


def draw_walls(sheet: Image) -> None:
    cv2.rectangle(sheet, (30, 30), (290, 210), (0, 0, 0), 6)
    cv2.line(sheet, (30, 120), (290, 120), (0, 0, 0), 4)


def draw_text(sheet: Image) -> None:
    cv2.putText(sheet, "OFFICE 108", (20, 100), cv2.FONT_HERSHEY_SIMPLEX, 1.2, (0, 0, 0), 2, cv2.LINE_AA)


def draw_tables(sheet: Image) -> None:
    cv2.circle(sheet, (100, 100), 30, (0, 0, 0), 1, cv2.LINE_AA)
    cv2.rectangle(sheet, (180, 80), (280, 130), (0, 0, 0), 1)


def draw_rooms(sheet: Image) -> None:
    sheet[30:130, 30:160] = (200, 40, 40)
    sheet[30:130, 160:300] = (40, 160, 60)


@pytest.mark.slow
@pytest.mark.parametrize("draw", [draw_walls, draw_text, draw_tables, draw_rooms, lambda sheet: None])
def test_a_sheet_without_symbols_has_none(draw):
    sheet = blank()
    draw(sheet)
    assert find_symbols(Sheet(sheet), door_px=24, templates=builtin_templates()) == ()


def test_symbols_cut_out_of_a_sheet_are_found_on_it(tmp_path):
    sheet = blank()
    draw_walls(sheet)
    sheet[115:126, 150:182] = WHITE
    draw_over(sheet, draw_symbol("door", size_px=30, stroke_px=2)[:, ::-1], 85, 148)
    cut = sheet[84:128, 146:186]
    fill = np.full(cut.shape, WHITE, np.uint8)
    fill[34:38] = 0
    assert cv2.imwrite(str(tmp_path / "door.png"), cut)
    assert cv2.imwrite(str(tmp_path / "wall.png"), fill)
    (symbol,) = find_symbols(Sheet(sheet), door_px=30, templates=read_symbol_folder(tmp_path))
    assert symbol.score > 0.95
    assert symbol.jambs is not None
    assert np.abs(symbol.jambs - [(120, 146), (120, 186)]).max() < 2
    (turned_symbol,) = find_symbols(Sheet(np.rot90(sheet)), door_px=30, templates=read_symbol_folder(tmp_path))
    assert turned_symbol.jambs is not None
    assert np.abs(turned_symbol.jambs - [(174, 120), (134, 120)]).max() < 2


def test_a_door_is_removed_and_its_walls_stay():
    sheet = blank()
    draw_over(sheet, draw_symbol("door", size_px=32, stroke_px=2), 80, 120)
    row, (left, right) = 80 + round(jambs_of("door", 32)[0, 0]), 120 + jambs_of("door", 32)[:, 1].round().astype(int)
    for start, stop in ((20, left), (right, 300)):
        sheet[row - 2 : row + 3, start:stop] = 0
    walls = sheet.copy()
    walls[: row - 2] = WHITE
    symbols = find_symbols(Sheet(sheet), door_px=32, templates=named("door"))
    cleared = remove_symbols(sheet, symbols)
    assert len(symbols) == 1
    assert (cleared[: row - 5] < 128).sum() < 0.15 * (sheet[: row - 5] < 128).sum()
    away = np.abs(np.arange(320) - (left + right) / 2) > 20
    assert (cleared[:, away] == walls[:, away]).all()


def test_a_removed_sign_has_the_colour_of_its_route():
    sheet = np.full((240, 320, 3), (110, 204, 135), np.uint8)
    sheet[90:114, 100:124] = draw_symbol("hydrant", size_px=24)[2:-2, 2:-2]
    symbols = find_symbols(Sheet(sheet), door_px=24, templates=named("hydrant"))
    assert len(symbols) == 1
    assert np.abs(remove_symbols(sheet, symbols).astype(int) - (110, 204, 135)).max() <= 2
    assert (remove_symbols(sheet, ()) == sheet).all()


def test_templates_that_do_not_fit_are_left_out():
    large = Template("large", "object", np.eye(200, dtype=np.uint8) * 255)
    small = Template("small", "door", np.eye(5, dtype=np.uint8) * 255)
    assert find_symbols(Sheet(blank(40, 40)), door_px=10, templates=(large, small)) == ()
    assert find_symbols(Sheet(blank()), door_px=24, templates=()) == ()


@pytest.mark.slow
def test_the_evacuation_maps_have_signs_and_no_windows(data):
    path = str(data / "floorplans" / "evacuation" / "escapeplan.png")
    sheet = np.asarray(cv2.imread(path))[:, :, ::-1].copy()
    symbols = [symbol.name for symbol in find_symbols(Sheet(sheet), door_px=17, templates=builtin_templates())]
    assert symbols.count("first aid") == 2
    assert symbols.count("way out") >= 5
    assert [name for name in symbols if name.startswith("window")] == []
