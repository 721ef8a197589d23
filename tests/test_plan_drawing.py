"""Drawn plans agree with their truth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Point, Polygon, box, unary_union

from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.worlds.floors import FLOOR_MAKERS, build_floor, make_floor
from pianta.worlds.plans.drawing import DrawnPlan, draw_plan
from pianta.worlds.plans.lettering import Lettering, WrittenText
from pianta.worlds.plans.look import WALL_STYLES, PlanLook
from pianta.worlds.plans.symbols import DOOR_STYLES

# A passage of 6 m × 2 m, and two rooms of 3 m × 3 m above it; metres between the axes of the walls.
AXES = (box(0, 0, 6, 2), box(0, 2, 3, 5), box(3, 2, 6, 5))
SMALL = build_floor(AXES[0], AXES[1:], side_doors=0)
WHITE, BLACK = [255, 255, 255], [0, 0, 0]


def colors_at(plan: DrawnPlan, *points: tuple[float, float]) -> list[list[int]]:
    rows, cols = (np.floor(values).astype(int) for values in plan.grid.map_to_pixel(*np.array(points).T))
    picked: list[list[int]] = plan.colors[rows, cols].tolist()
    return picked


def middle_of(door):
    return door.line.interpolate(0.5, normalized=True).coords[0]


def test_thick_walls_are_black_and_rooms_and_doors_are_white():
    plan = draw_plan(SMALL, doors="gap")
    on_walls = [(0, 1), (6, 1), (3, 4), (3, 0), (0, 5), (-0.1, 3)]
    assert colors_at(plan, *on_walls) == [BLACK] * 6
    assert colors_at(plan, (3, 1), (1.5, 3.5), (4.5, 3.5)) == [WHITE] * 3
    assert colors_at(plan, *map(middle_of, plan.truth.doors)) == [WHITE] * len(plan.truth.doors)
    assert colors_at(plan, (-0.5, 1), (7, 5.8)) == [WHITE] * 2


def test_the_sheet_is_as_large_as_the_building_and_its_margin():
    """6.3 m × 5.3 m with the outer walls, and a metre around."""
    plan = draw_plan(SMALL, px_per_metre=20)
    assert plan.colors.shape == (146, 166, 3)
    assert plan.grid.shape == (146, 166)
    assert plan.grid.resolution == 0.05
    assert plan.grid.map_to_pixel(-1.15, 6.15) == pytest.approx((0, 0))


def test_double_walls_are_two_lines():
    plan = draw_plan(SMALL, style="double", px_per_metre=100, doors="gap")
    row, col = (int(value) for value in plan.grid.map_to_pixel(3, 4.5))
    dark = plan.colors[row, col - 20 : col + 20, 0] < 128
    starts = np.flatnonzero(np.diff(dark.astype(int)) == 1)
    assert len(starts) == 2
    assert np.ptp(starts) == pytest.approx(15, abs=1)


def test_single_walls_are_lines_where_rooms_meet():
    plan = draw_plan(SMALL, style="single", px_per_metre=40, doors="gap")
    row, col = (int(value) for value in plan.grid.map_to_pixel(3, 4.5))
    dark = np.flatnonzero(plan.colors[row, col - 20 : col + 20, 0] < 128)
    assert 1 <= len(dark) <= 4
    assert dark.mean() + col - 20 == pytest.approx(col, abs=1.5)
    assert [room.polygon.equals(axes) for room, axes in zip(plan.truth.rooms, AXES, strict=True)] == [True] * 3


def test_pillars_stay_out_of_rooms_of_single_walls():
    hall = make_floor("hall", seed=0)
    plan = draw_plan(hall, style="single", px_per_metre=20)
    assert len(plan.truth.rooms[0].polygon.interiors) == len(hall.rooms[0].polygon.interiors) > 0


@pytest.mark.slow
@settings(max_examples=25)
@given(
    st.sampled_from(sorted(FLOOR_MAKERS)),
    st.sampled_from(WALL_STYLES),
    st.sampled_from(DOOR_STYLES),
    st.sampled_from([0, 2, 3]),
    st.floats(-180, 180),
)
def test_walls_are_closed_except_for_doors(name, style, doors, windows, rotation):
    """Along the outline of a room there is ink everywhere except in doors."""
    floor = make_floor(name, seed=7)
    plan = draw_plan(floor, style=style, doors=doors, windows=windows, rotation=rotation, px_per_metre=25)
    inked = plan.colors[:, :, 0] < 160
    room = plan.truth.rooms[1].polygon
    gaps = unary_union([door.line.buffer(0.5) for door in plan.truth.doors])
    points = [room.exterior.interpolate(step) for step in np.arange(0.3, room.exterior.length, 0.5)]
    points = [point for point in points if not gaps.contains(point)]
    pixels = np.column_stack(plan.grid.map_to_pixel([point.x for point in points], [point.y for point in points]))
    near = [inked[row - 3 : row + 4, col - 3 : col + 4].any() for row, col in pixels.astype(int)]
    assert points
    assert all(near)


@pytest.mark.slow
@settings(max_examples=15)
@given(st.sampled_from(sorted(FLOOR_MAKERS)), st.integers(0, 20), st.floats(-180, 180))
def test_doors_are_gaps_on_a_turned_sheet(name, seed, rotation):
    floor = make_floor(name, seed=seed)
    plan = draw_plan(floor, doors="gap", rotation=rotation, px_per_metre=20)
    assert colors_at(plan, *map(middle_of, floor.doors)) == [WHITE] * len(floor.doors)
    assert colors_at(plan, *(room.polygon.representative_point().coords[0] for room in floor.rooms)) == [WHITE] * len(
        floor.rooms
    )
    assert plan.truth == floor


def test_doors_of_the_truth_are_as_wide_as_drawn():
    floor = make_floor("corridor", seed=5)
    plan = draw_plan(floor, doors="double", px_per_metre=40)
    assert {door.width for door in plan.truth.doors} > {1.6}
    wide = next(door for door in plan.truth.doors if door.width == 1.6)
    ends = [wide.line.interpolate(reach).coords[0] for reach in (0.1, 1.5)]
    assert colors_at(plan, *ends) == [WHITE] * 2


@pytest.mark.slow
def test_the_same_seed_draws_the_same_plan():
    floor = make_floor("l", seed=1)
    one, same, other = (draw_plan(floor, seed=seed, furniture=0.5, noise=0.3, px_per_metre=15) for seed in (3, 3, 4))
    assert np.array_equal(one.colors, same.colors)
    assert not np.array_equal(one.colors, other.colors)


def test_names_are_written_in_their_rooms():
    plan = draw_plan(SMALL, texts={1: "Corridor", 2: "Main office", 3: "Lab"}, doors="gap")
    assert plan.names == {1: "Corridor", 2: "Main office", 3: "Lab"}
    assert [text.text for text in plan.texts] == ["Corridor", "Main office", "Lab"]
    for room, text in zip(plan.truth.rooms, plan.texts, strict=True):
        corners = np.column_stack(plan.grid.pixel_to_map(*text.corners.T))
        assert room.polygon.contains(Polygon(corners))
        rows, cols = (
            slice(int(low), int(high) + 1) for low, high in zip(text.corners[0], text.corners[2], strict=True)
        )
        assert plan.colors[rows, cols].min() < 100
        around = plan.colors[rows.start - 2, cols]
        assert around.min() > 200


def test_long_names_are_broken_and_those_that_do_not_fit_left_out():
    names = {2: "Staff meeting room", 3: "Donaudampfschifffahrtsgesellschaftsraum"}
    plan = draw_plan(SMALL, texts=names, lettering=0.35)
    assert plan.names == {2: "Staff meeting room"}
    assert [text.text for text in plan.texts] == ["Staff", "meeting room"]
    assert plan.texts[0].middle[0] < plan.texts[1].middle[0]


def test_text_runs_upwards_at_90_degrees():
    (text,) = draw_plan(SMALL, texts={2: "Store"}, text_angle=90).texts
    (row0, col0), (row1, col1) = text.corners[:2]
    assert row1 < row0 - 10
    assert col1 == pytest.approx(col0)
    assert text.height == pytest.approx(np.hypot(*(text.corners[2] - text.corners[1])))


@given(st.floats(-180, 180), st.text("abcXYZ", min_size=1, max_size=8))
def test_corners_go_clockwise_from_the_upper_left_one(angle, letters):
    placed = WrittenText(letters, Lettering().face(), (50.0, 60.0), angle).to_placed()
    first, second, third, _ = placed.corners
    along, down = second - first, third - second
    assert placed.middle == pytest.approx((50, 60))
    assert along @ down == pytest.approx(0, abs=1e-6)
    assert along[1] * down[0] - along[0] * down[1] > 0
    assert np.degrees(np.arctan2(-along[0], along[1])) == pytest.approx(angle, abs=1e-6) or abs(angle) == 180


def test_a_legend_explains_the_numbers():
    plan = draw_plan(SMALL, texts={1: "Hall", 2: "Office", 3: "Office"}, legend=True)
    assert [text.text for text in plan.texts] == ["1", "2", "2", "Legend", "1 Hall", "2 Office"]
    assert plan.names == {1: "Hall", 2: "Office", 3: "Office"}
    _, right = plan.grid.map_to_pixel(6.15, 0)
    assert all(text.corners[:, 1].min() > right for text in plan.texts[3:])
    assert max(text.corners[:, 1].max() for text in plan.texts) < plan.grid.shape[1]


def test_title_dimensions_and_scale_bar_are_outside_the_building():
    plan = draw_plan(SMALL, title="First floor", dimensions=True, scale_bar=True, px_per_metre=50)
    assert [text.text for text in plan.texts] == ["First floor", "6.30", "5.30", "0", "1 m"]
    outside = box(-0.15, -0.15, 6.15, 5.15)
    for text in plan.texts:
        corners = np.column_stack(plan.grid.pixel_to_map(*text.corners.T))
        assert outside.disjoint(Polygon(corners))
        assert text.corners.min() >= 0
        assert (text.corners.max(axis=0) <= plan.grid.shape).all()
    ends = [text.middle for text in plan.texts[-2:]]
    assert ends[1][1] - ends[0][1] == pytest.approx(50)
    assert ends[0][0] == ends[1][0]


def test_coloured_rooms_and_ink():
    plan = draw_plan(SMALL, colored=True, ink=90, doors="gap")
    inside = colors_at(plan, (3, 1), (1.5, 3.5), (4.5, 3.5))
    assert len({tuple(color) for color in inside}) == 3
    assert WHITE not in inside
    assert colors_at(plan, (0, 1)) == [[90, 90, 90]]


def test_signs_of_evacuation_are_red_and_green():
    colors = draw_plan(SMALL, evacuation=True).colors.astype(int)
    green = (colors[:, :, 1] - colors[:, :, 0]) > 80
    assert green.any()
    assert not ((draw_plan(SMALL).colors.astype(int) @ [1, -1, 0]) != 0).any()


def test_noise_darkens_and_leaves_the_shape():
    clean, noisy = (draw_plan(SMALL, noise=noise, seed=1) for noise in (0.0, 1.0))
    assert noisy.colors.shape == clean.colors.shape
    assert noisy.colors.mean() < clean.colors.mean() - 5
    assert colors_at(noisy, (0, 1))[0][0] < 120 < colors_at(noisy, (3, 1))[0][0]


def test_the_input_floor_is_not_changed():
    floor = make_floor("corridor", seed=2)
    before = Floor(floor.rooms, floor.doors, floor.walls, source=floor.source)
    assert draw_plan(floor, furniture=0.3, px_per_metre=15).truth == before == floor
    assert floor.rooms[0].polygon.contains(Point(floor.rooms[0].polygon.representative_point()))


def test_all_invalid_fields_of_a_style_are_named_in_one_message():
    with pytest.raises(OptionError, match=r"style.*doors.*windows.*px_per_metre"):
        PlanLook(style="fat", doors="none", windows=4, px_per_metre=1)  # type: ignore[arg-type]
    with pytest.raises(OptionError, match=r"furniture.*noise.*ink"):
        PlanLook(furniture=2, noise=-1, ink=255)
    with pytest.raises(OptionError, match="Comic"):
        draw_plan(SMALL, font="Comic", texts={2: "Lab"})
    with pytest.raises(OptionError, match="pixels"):
        draw_plan(make_floor("ring", seed=0), px_per_metre=500)
