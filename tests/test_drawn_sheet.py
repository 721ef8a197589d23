"""Sheets of vector plans: doors of a fixed size, walls separate, everything in one frame of pixels."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pianta.errors import OptionError, PlanError
from pianta.io.drawings._drawing import ROLES, DrawnText, PlanDrawing, Role
from pianta.plan.sheets.drawn_sheet import MARGIN_PX, draw_sheet
from pianta.plan.sheets.sheet import Sheet

M = MARGIN_PX
# A room of 9 m × 4.5 m: with units, 32 pixels for a door of 0.9 m make it 320 × 160.
ROOM = [(0, 0, 9, 0), (9, 0, 9, 4.5), (9, 4.5, 0, 4.5), (0, 4.5, 0, 0)]


def drawing(*lines: Sequence[float] | NDArray[np.float64], role: Role = "wall", **attributes: object) -> PlanDrawing:
    """Lines x0, y0, x1, y1 of a role, in metres by default."""
    ends = np.array(lines, float).reshape(-1, 2, 2)
    options = {"roles": np.full(len(ends), ROLES.index(role)), "widths": np.zeros(len(ends)), "metres_per_unit": 1.0}
    return PlanDrawing(lines=ends, **{**options, **attributes})  # type: ignore[arg-type]


def bounds(mask: NDArray[np.bool_]) -> list[int]:
    """First and last row, first and last col of the set pixels."""
    rows, cols = np.nonzero(mask)
    return [int(limit) for axis in (rows, cols) for limit in (axis.min(), axis.max())]


def ink(sheet: Sheet) -> NDArray[np.bool_]:
    return np.asarray(sheet.colors[..., 0] == 0)


def test_a_room_in_metres_has_doors_of_32_pixels():
    sheet = draw_sheet(drawing(*ROOM, source="a.dxf"))
    assert sheet.colors.shape == (160 + 2 * M, 320 + 2 * M, 3)
    assert sheet.resolution == pytest.approx(0.9 / 32)
    assert sheet.source == "a.dxf"
    assert set(np.unique(sheet.colors)) == {0, 255}
    assert np.abs(np.array(bounds(ink(sheet))) - (M, M + 160, M, M + 320)).max() <= 1
    assert not sheet.colors[M + 10 : M + 150, M + 10 : M + 310].min() < 255, "nothing within"
    assert sheet.walls is not None
    assert (sheet.walls == ink(sheet)).all()
    assert sheet.texts is None


def test_units_and_origin_do_not_change_the_sheet():
    """The same room in millimetres, at the coordinates of a state plane, with a door and a text."""
    text, door = DrawnText("Office", 4, 2, 0.2, 0.5), np.array([[[1, 0], [2, 0]]], float)
    here = draw_sheet(drawing(*ROOM, doors=door, texts=(text,)))
    shift = np.array([7e8, 5e9])
    moved = DrawnText("Office", 4e3 + shift[0], 2e3 + shift[1], 200, 0.5)
    there = draw_sheet(
        drawing(
            *(np.array(ROOM) * 1000 + np.tile(shift, 2)),
            doors=door * 1000 + shift,
            texts=(moved,),
            metres_per_unit=1e-3,
        )
    )
    assert (here.colors == there.colors).all()
    assert here.resolution == pytest.approx(there.resolution)
    assert here.doors == pytest.approx(there.doors, abs=1e-3)
    assert here.texts is not None
    assert there.texts is not None
    assert here.texts[0].corners == pytest.approx(there.texts[0].corners, abs=1e-3)


def test_rows_go_down_and_doors_lie_on_their_lines():
    sheet = draw_sheet(drawing((0, 0, 9, 0), (0, 0, 0, 4.5), doors=np.array([[[1.8, 4.5], [2.7, 4.5]]])))
    assert sheet.doors == pytest.approx(np.array([[[M, M + 64], [M, M + 96]]]))
    assert ink(sheet)[M + 159 : M + 161].any(axis=0).sum() >= 320, "the line along y = 0 is the lowest"
    assert not ink(sheet)[M, M + 10 :].any()


@pytest.mark.parametrize(("angle", "first", "second"), [(0, (-1, -1), (-1, 1)), (np.pi / 2, (1, -1), (-1, -1))])
def test_corners_of_texts_go_clockwise_from_where_reading_starts(angle, first, second):
    """first, second: signs of row and col from the middle; a text turned counter-clockwise is read upwards."""
    sheet = draw_sheet(drawing(*ROOM, texts=(DrawnText("Lab", 4.5, 2.25, 0.27, angle),)))
    assert sheet.texts is not None
    (text,) = sheet.texts
    assert (text.text, text.confidence) == ("Lab", 1)
    assert text.middle == pytest.approx([M + 80, M + 160])
    assert np.sign(text.corners - text.middle)[:2].tolist() == [list(first), list(second)]
    assert text.corners[0] + text.corners[2] == pytest.approx(2 * text.middle)
    assert text.height == pytest.approx(0.27 * 1.4 * 32 / 0.9)


def test_without_units_the_median_door_gives_the_scale():
    doors = np.array([[[1, 0], [2, 0]], [[3, 0], [4, 0]], [[5, 0], [9, 0]]], float)
    sheet = draw_sheet(drawing(*ROOM, doors=doors, metres_per_unit=None))
    assert sheet.colors.shape[:2] == (4.5 * 32 + 2 * M, 9 * 32 + 2 * M)
    assert sheet.resolution is None


def test_without_units_and_doors_the_longer_side_is_half_the_limit():
    sheet = draw_sheet(drawing(*ROOM, metres_per_unit=None), longest_px=1000)
    assert sheet.colors.shape[1] == pytest.approx(500, abs=2 * M)


def test_a_large_building_is_drawn_smaller():
    sheet = draw_sheet(drawing(*np.array(ROOM) * 100), longest_px=1000)
    assert 1000 - 3 <= sheet.colors.shape[1] <= 1000
    assert sheet.resolution == pytest.approx(900 / (1000 - 2 * M - 1))


def test_distant_pieces_are_left_out():
    """Stray pieces on three sides with their surroundings; one of them is a detail with more lines than the walls."""
    junk = [(x, -4e5 + x, x + 1, -4e5) for x in range(10)]
    lines = [*ROOM, (1e6, 0, 1e6 + 1, 0), (-5e7, 3, -5e7, 4), *junk]
    roles = np.array([ROLES.index("wall")] * 4 + [ROLES.index("other")] * (len(lines) - 4))
    far = DrawnText("far", 1e6, 0, 1)
    sheet = draw_sheet(drawing(*lines, roles=roles, texts=(far,), doors=np.array([[[1e6, 0], [1e6, 1]]])))
    assert sheet.colors.shape[:2] == (160 + 2 * M, 320 + 2 * M)
    assert (sheet.doors.shape, sheet.texts) == ((0, 2, 2), None)


def test_both_floors_of_a_sheet_stay():
    other = [(x0 + 14, y0, x1 + 14, y1) for x0, y0, x1, y1 in ROOM]
    assert draw_sheet(drawing(*ROOM, *other)).colors.shape[1] == pytest.approx(23 * 32 / 0.9 + 2 * M, abs=1)


def test_doors_windows_and_furniture_are_drawn_and_are_no_walls():
    lines = [*ROOM, *((x, 1, x, 3) for x in (2, 4, 6))]
    roles = np.array([0] * 4 + [ROLES.index(role) for role in ("door", "window", "other")])
    sheet = draw_sheet(drawing(*lines, roles=roles))
    assert sheet.walls is not None
    assert (sheet.walls == ink(draw_sheet(drawing(*ROOM)))).all()
    within = ink(sheet)[M + 10 : M + 150, M + 10 : M + 310]
    assert np.flatnonzero(np.diff(within.any(axis=0).astype(int)) == 1).size == 3


def test_filled_areas_are_ink_and_walls_where_any_wall_is_named():
    poche = np.array([(0, 0), (9, 0), (9, 0.9), (0, 0.9)], float)
    named = draw_sheet(drawing(*ROOM, fills=(poche,)))
    assert named.walls is not None
    assert named.walls[M + 130 : M + 158, M + 2 : M + 318].all()
    assert not named.walls[M + 10 : M + 125, M + 10 : M + 310].any()
    unnamed = draw_sheet(drawing(*ROOM, role="other", fills=(poche,)))
    assert unnamed.walls is None
    assert ink(unnamed)[M + 130 : M + 158, M + 2 : M + 318].all()


def test_lines_are_as_wide_as_they_are_drawn_and_two_pixels_at_least():
    sheet = draw_sheet(drawing((0, 0, 9, 0), (0, 3, 9, 3), widths=np.array([0.0, 0.27])))
    rows = ink(sheet)[:, M + 160].nonzero()[0]
    assert rows[-2:].tolist() == [M + 106, M + 107], "3 m below the upper line, on both sides of the border of two rows"
    wide = rows[:-2]
    assert len(wide) == pytest.approx(0.27 * 32 / 0.9, abs=1.5)
    assert wide.mean() == pytest.approx(M, abs=1)


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        (drawing(source="a.svg"), r"a\.svg"),
        (drawing((1, 1, 1, 1), source="a.svg"), r"a\.svg"),
    ],
)
def test_an_empty_plan_is_refused(plan, message):
    with pytest.raises(PlanError, match=rf"^[^\n]*{message}[^\n]*$"):
        draw_sheet(plan)


def test_a_sheet_without_room_is_refused():
    with pytest.raises(OptionError, match=f"longest_px.*{4 * M}"):
        draw_sheet(drawing(*ROOM), longest_px=90)


corner = st.floats(-1e9, 1e9)


@pytest.mark.slow
@given(
    lines=st.lists(st.tuples(corner, corner, corner, corner), min_size=1, max_size=20),
    metres=st.none() | st.floats(1e-9, 1e9),
)
def test_any_sheet_is_within_the_limit(lines, metres):
    plan = drawing(*lines, metres_per_unit=metres, doors=np.array(lines)[:1].reshape(-1, 2, 2))
    if np.ptp(plan.lines.reshape(-1, 2), axis=0).max() > 1e-9:
        sheet = draw_sheet(plan, longest_px=300)
        assert max(sheet.colors.shape) <= 300
        assert sheet.walls is not None
        assert sheet.walls.any()
    else:
        with pytest.raises(PlanError, match="point"):
            draw_sheet(plan, longest_px=300)
