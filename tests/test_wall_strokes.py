"""Walls by the widths of strokes: only if they are much thicker, and divide the floor."""

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from pianta.io.drawings._drawing import PlanDrawing
from pianta.plan.read_plan import read_plan
from pianta.plan.sheets.drawn_sheet import draw_sheet
from pianta.plan.sheets.wall_strokes import find_wall_strokes
from tests.conftest import DATA

Lines = NDArray[np.float64]


def outline(left: float, bottom: float, right: float, top: float) -> Lines:
    corners = np.array([[left, bottom], [right, bottom], [right, top], [left, top], [left, bottom]], float)
    return np.stack([corners[:-1], corners[1:]], axis=1)


# Six rooms, 40 × 40 each, and a table in each
WALLS = np.concatenate([outline(x, y, x + 40, y + 40) for x in (0, 40, 80) for y in (0, 40)])
TABLES = np.concatenate([outline(x + 10, y + 10, x + 20, y + 15) for x in (0, 40, 80) for y in (0, 40)])
PLAN = np.concatenate([WALLS, TABLES])


def widths(wall: float, table: float) -> NDArray[np.float64]:
    return np.repeat([wall, table], [len(WALLS), len(TABLES)])


@pytest.mark.parametrize(("wall", "expected"), [(3, True), (2.5, True), (2.4, False), (1, False)])
def test_much_thicker_strokes_are_walls(wall, expected):
    assert find_wall_strokes(PLAN, widths(wall, 1)).tolist() == [expected] * len(WALLS) + [False] * len(TABLES)


def test_tables_with_thick_strokes_are_none():
    assert not find_wall_strokes(PLAN, widths(1, 3)).any()


def test_outer_walls_alone_are_none():
    """Two outlines, 5 apart, with thick strokes: the walls between the rooms are thin."""
    outer = np.concatenate([outline(-5 * k, -5 * k, 120 + 5 * k, 80 + 5 * k) for k in (0, 1, 2)])
    lines = np.concatenate([outer, PLAN])
    assert not find_wall_strokes(lines, np.repeat([3.0, 1.0], [len(outer), len(PLAN)])).any()


def test_hair_lines_and_few_lines_have_no_ratio():
    assert not find_wall_strokes(PLAN, np.zeros(len(PLAN))).any()
    assert not find_wall_strokes(PLAN[:3], np.array([3.0, 1, 1])).any()
    assert not find_wall_strokes(np.zeros((0, 2, 2)), np.zeros(0)).any()


def test_the_sheet_has_the_walls_of_thick_strokes():
    drawing = PlanDrawing(PLAN, np.full(len(PLAN), 3), widths(3, 1), source="plan.svg")
    sheet = draw_sheet(drawing)
    assert sheet.walls is not None
    ink = sheet.colors[:, :, 0] == 0
    assert 0 < sheet.walls.sum() < ink.sum()
    assert not (sheet.walls & ~ink).any()


@pytest.mark.slow
@pytest.mark.skipif(not (DATA / "planfiles").exists(), reason=f"no planfiles in {DATA}")
def test_furniture_of_a_flat_becomes_no_rooms():
    """Without the widths 23 rooms were read, most of them pieces of furniture.

    A person counts 8: three closets, of which two are read as parts of their rooms, and the six below.
    """
    pytest.importorskip("svgelements", reason="pianta[svg] is not installed")
    floor = read_plan(DATA / "planfiles" / "svg" / "ianmc.svg").floors[0].floor
    left, bottom, right, top = shapely.union_all([room.polygon for room in floor]).bounds

    def room_at(across: float, up: float) -> int | None:
        room = floor.room_at(left + across * (right - left), bottom + up * (top - bottom))
        return None if room is None else room.id

    bedrooms, bath, utility = [room_at(0.2, 0.8), room_at(0.12, 0.25)], room_at(0.43, 0.3), room_at(0.9, 0.15)
    closet = room_at(0.31, 0.1)
    living, kitchen, dining = room_at(0.6, 0.8), room_at(0.9, 0.45), room_at(0.6, 0.15)
    assert living == kitchen == dining
    assert None not in {*bedrooms, bath, utility, living, closet}
    assert len({*bedrooms, bath, utility, living, closet}) == len(floor) == 6
