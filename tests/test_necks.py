import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta._types import Floats, Mask
from pianta.layout._voronoi_doors import compute_clearance
from pianta.layout.structure.necks import drop_repeated_lines, find_necks, measure_lengths
from tests.drawn_maps import carve

SHAPE = (60, 120)
TWO_ROOMS = carve(SHAPE, (10, 50, 10, 58), (10, 50, 62, 110))


def open_doors(*doors: tuple[int, int]) -> Mask:
    """Two rooms of 40 × 48 cells and a wall of 4 cells between them, open from one row to before another."""
    return TWO_ROOMS | carve(SHAPE, *[(top, bottom, 58, 62) for top, bottom in doors])


def necks_of(
    space: Mask, *, saddle_ratio: float = 0.92, passage_width: float = 4.0, merge_distance: float = 7.0
) -> Floats:
    clearance = compute_clearance(space)
    return find_necks(
        space,
        clearance,
        saddle_ratio=saddle_ratio,
        mouth_ratio=0.65,
        passage_width=passage_width,
        merge_distance=merge_distance,
    )


def test_the_neck_of_a_door_runs_from_jamb_to_jamb():
    (neck,) = necks_of(open_doors((26, 38)))
    assert sorted(neck[:, 0]) == [25, 38]
    assert abs(neck[0, 1] - neck[1, 1]) <= 1
    assert ((neck[:, 1] >= 58) & (neck[:, 1] <= 61)).all()


@pytest.mark.slow
@given(st.integers(12, 22), st.integers(6, 20))
def test_a_door_anywhere_in_a_wall_has_one_neck(top, width):
    (neck,) = necks_of(open_doors((top, top + width)))
    assert sorted(neck[:, 0]) == [top - 1, top + width]
    assert ((neck[:, 1] >= 58) & (neck[:, 1] <= 61)).all()


@pytest.mark.parametrize("span", [(10, 50, 10, 110), (10, 20, 10, 110), (29, 31, 10, 110), (10, 50, 10, 20)])
def test_a_room_or_corridor_of_constant_width_has_no_neck(span):
    assert len(necks_of(carve(SHAPE, span), passage_width=0.5)) == 0


def test_the_same_building_turned_has_the_same_necks_turned():
    space = open_doors((14, 22), (30, 44))
    necks = necks_of(space)
    turned = necks_of(np.rot90(space).copy())
    # Row and col of a map turned counter-clockwise are SHAPE[1] - 1 - col and row.
    back = np.stack([turned[..., 1], SHAPE[1] - 1 - turned[..., 0]], axis=-1)
    assert [sorted(neck[:, 0].tolist()) for neck in necks] == [[13, 22], [29, 44]]
    assert [sorted(neck[:, 0].tolist()) for neck in back] == [[13, 22], [29, 44]]
    assert ((back[..., 1] >= 58) & (back[..., 1] <= 61)).all()


def test_two_doors_between_two_rooms_are_two_necks_the_shorter_first():
    assert measure_lengths(necks_of(open_doors((12, 26), (36, 46)))).tolist() == pytest.approx([11, 15], abs=0.1)


def test_a_room_between_two_doors_has_two_necks():
    space = carve(
        (60, 160), (10, 50, 10, 50), (26, 38, 50, 54), (10, 50, 54, 100), (30, 40, 100, 104), (10, 50, 104, 150)
    )
    assert sorted(map(sorted, necks_of(space)[:, :, 0].tolist())) == [[25, 38], [29, 40]]


def test_space_narrower_than_a_passage_has_no_neck():
    space = open_doors((28, 32))
    assert len(necks_of(space, passage_width=2.0)) == 1
    assert len(necks_of(space, passage_width=6.0)) == 0


def test_a_slight_narrowing_has_a_neck_only_with_a_greater_saddle_ratio():
    space = open_doors((11, 49))
    assert len(necks_of(space, saddle_ratio=0.92)) == 0
    assert len(necks_of(space, saddle_ratio=0.99)) == 1


@pytest.mark.parametrize("space", [np.zeros((20, 20), bool), np.ones((20, 20), bool)])
def test_space_without_walls_or_without_floor_has_no_neck(space):
    assert necks_of(space).shape == (0, 2, 2)


def test_a_line_is_dropped_when_both_its_ends_are_near_those_of_a_shorter_one():
    lines = np.array(
        [
            [[0, 0], [0, 20]],
            [[2, 20], [2, 1]],
            [[0, 0], [9, 20]],
            [[50, 0], [50, 18]],
        ],
        float,
    )
    # The first repeats the second, which runs the other way; the third shares only its start with them.
    assert drop_repeated_lines(lines, 3).tolist() == lines[[3, 1, 2]].tolist()


def test_a_line_just_as_far_away_as_the_distance_stays():
    lines = np.array([[[0, 0], [0, 20]], [[3, 0], [3, 20]]], float)
    assert len(drop_repeated_lines(lines, 3)) == 2
    assert len(drop_repeated_lines(lines, 3.1)) == 1
    assert drop_repeated_lines(np.zeros((0, 2, 2)), 3).shape == (0, 2, 2)


ends = st.tuples(st.integers(0, 9), st.integers(0, 9))


@given(st.lists(st.tuples(ends, ends), max_size=12), st.floats(0.5, 6))
def test_selected_lines_do_not_repeat_each_other_and_dropped_lines_repeat_one(lines, distance):
    all_lines = np.array(lines, float).reshape(-1, 2, 2)
    distinct = drop_repeated_lines(all_lines, distance)

    def repeats(one: Floats, other: Floats) -> bool:
        return bool(min(np.hypot(*(one - turned).T).max() for turned in (other, other[::-1])) < distance)

    assert not any(repeats(one, other) for i, one in enumerate(distinct) for other in distinct[:i])
    assert all(any(repeats(line, other) for other in distinct) for line in all_lines)
    assert (np.diff(measure_lengths(distinct)) >= 0).all()
