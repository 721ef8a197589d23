"""Photos of plans from an angle are straightened; scans, renders and plans with slanted walls are left as they are."""

from math import cos, pi, sin
from pathlib import Path

import cv2
import numpy as np
import pytest
from shapely import box

from pianta._types import Colors
from pianta.io.images import read_picture
from pianta.plan.read_plan import read_plan
from pianta.plan.sheets.open_sheet import open_sheet
from pianta.plan.sheets.perspective import straighten
from pianta.worlds.floors import build_floor
from pianta.worlds.plans.drawing import draw_plan

# Metres between the axes of walls: a passage with rooms on both sides
SIX = build_floor(
    box(0, 0, 12, 3),
    [box(0, 3, 4, 8), box(4, 3, 8, 8), box(8, 3, 12, 8), box(0, -5, 4, 0), box(4, -5, 8, 0), box(8, -5, 12, 0)],
    side_doors=0,
)
PLAN = draw_plan(SIX)
# Where the corners of the sheet are on the photo, x and y in shares of its sides: the far edge is shorter
FROM_BELOW = ((0.2, 0.15), (0.8, 0.12), (0.93, 0.9), (0.08, 0.92))


def photograph(colors: Colors, corners: tuple[tuple[float, float], ...], *, table: bool) -> tuple[Colors, np.ndarray]:
    """A photo of 1200 × 900 pixels, and the matrix from x and y on the sheet to x and y on the photo."""
    (height, width), size = colors.shape[:2], (1200, 900)
    sheet = np.array([(0, 0), (width, 0), (width, height), (0, height)], np.float32)
    matrix = cv2.getPerspectiveTransform(sheet, (np.array(corners) * size).astype(np.float32))
    border = (60, 85, 120) if table else (255, 255, 255)
    photo = cv2.warpPerspective(colors, matrix, size, flags=cv2.INTER_AREA, borderValue=border)
    noise = np.random.default_rng(0).normal(0, 4, photo.shape)
    return np.clip(photo + noise, 0, 255).astype(np.uint8), matrix


@pytest.mark.parametrize(("table", "by"), [(True, "the edges of its paper"), (False, "the directions of its lines")])
def test_a_photo_from_an_angle_becomes_the_sheet_again(table, by):
    photo, matrix = photograph(PLAN.colors, FROM_BELOW, table=table)
    straight = straighten(photo)
    assert straight is not None
    assert straight.by == by
    height, width = PLAN.colors.shape[:2]
    grid = np.array([(x, y, 1) for x in np.linspace(0.1, 0.9, 5) * width for y in np.linspace(0.1, 0.9, 5) * height])
    moved = grid @ matrix.T @ straight.matrix.T
    moved = moved[:, :2] / moved[:, 2:]
    for axis, side in ((0, width), (1, height)):
        slope, start = np.polyfit(grid[:, axis], moved[:, axis], 1)
        assert slope > 0, "neither mirrored nor turned"
        # Upright again to half a percent of the sheet
        assert np.abs(start + slope * grid[:, axis] - moved[:, axis]).max() < 0.005 * slope * side


@pytest.mark.parametrize("table", [True, False])
@pytest.mark.parametrize("turn", [0, 4])
def test_a_photo_from_above_is_left_as_it_is(table, turn):
    """Also turned by degrees."""
    angle = turn * pi / 180
    square = [(0.1, 0.1), (0.9, 0.1), (0.9, 0.9), (0.1, 0.9)]
    scaled = [((x - 0.5) * 1200, (y - 0.5) * 900) for x, y in square]
    turned = [(x * cos(angle) - y * sin(angle), x * sin(angle) + y * cos(angle)) for x, y in scaled]
    corners = tuple((x / 1200 * 0.9 + 0.5, y / 900 * 0.9 + 0.5) for x, y in turned)
    assert straighten(photograph(PLAN.colors, corners, table=table)[0]) is None


def test_a_building_with_a_slanted_side_is_left_as_it_is():
    plan = np.full((600, 900, 3), 255, np.uint8)
    cv2.polylines(plan, [np.array([(100, 100), (700, 100), (820, 500), (100, 500)])], True, (0, 0, 0), 6)
    for x in range(180, 700, 80):
        cv2.line(plan, (x, 100), (x, 250), (0, 0, 0), 4)
        cv2.line(plan, (x, 350), (x, 500), (0, 0, 0), 4)
    for y in range(140, 260, 40):
        cv2.line(plan, (100, y), (500, y), (0, 0, 0), 3)
        cv2.line(plan, (100, y + 220), (400, y + 220), (0, 0, 0), 3)
    assert straighten(plan) is None


@pytest.mark.parametrize("shape", [(1, 1), (20, 40_000), (120, 33_000), (300, 300)])
def test_pictures_without_lines_or_of_odd_shapes_are_left_as_they_are(shape):
    assert straighten(np.full((*shape, 3), 255, np.uint8)) is None


def test_the_note_names_the_sheet_that_the_results_fit(tmp_path):
    photo, _ = photograph(PLAN.colors, FROM_BELOW, table=True)
    cv2.imwrite(str(tmp_path / "photo.png"), photo[..., ::-1])
    reading = read_plan(tmp_path / "photo.png", with_text=False)
    (note,) = reading.notes
    assert note.startswith("photo: taken from an angle and straightened by the edges of its paper")
    assert reading.sheet is not None
    assert reading.floors[0].grid.shape == reading.sheet.shape != photo.shape[:2]
    assert len(reading.floors[0].floor.rooms) == 7


def test_scans_and_renders_of_the_data_are_left_as_they_are(data: Path):
    files = [*(data / "floorplans").iterdir(), *(data / "planfiles" / "raster").glob("*")]
    pictures = [file for file in sorted(files) if file.suffix.lower() in {".png", ".jpg", ".gif"}]
    if not pictures:
        pytest.skip("the plans of the data are missing")
    for file in pictures:
        assert straighten(read_picture(file)) is None, file.name


def test_a_straightened_sheet_has_no_resolution_of_its_paper(tmp_path):
    from PIL import Image

    photo, _ = photograph(PLAN.colors, FROM_BELOW, table=True)
    Image.fromarray(photo).save(tmp_path / "photo.jpg", dpi=(300, 300), quality=95)
    Image.fromarray(PLAN.colors).save(tmp_path / "scan.jpg", dpi=(300, 300), quality=95)
    assert open_sheet(tmp_path / "photo.jpg").px_per_inch is None
    assert open_sheet(tmp_path / "scan.jpg").px_per_inch == 300
