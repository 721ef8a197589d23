"""Indoor cells by the least cost of open borders and of disagreement with the network."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import ndimage
from skimage.segmentation import watershed

from pianta._types import Mask
from pianta.plan.walls.indoor_mask import (
    PARAMETERS,
    enclosed_mask,
    grow_labels,
    indoor_mask,
    minimum_cut,
    shared_borders,
    split_space,
)

CELL = 0.1
ROOM = (slice(20, 60), slice(20, 70))


def draw_room(*, gap: int = 0, certainty: float = 0.9) -> tuple[Mask, NDArray[np.float32]]:
    """The free space of a room of 4 × 5 m with a gap in its right wall, and the evidence that each cell is outside."""
    free = np.ones((80, 100), bool)
    free[18:62, 18:72] = False
    free[ROOM] = True
    free[30 : 30 + gap, 70:72] = True
    outside = np.where(free, 0.9, 0).astype(np.float32)
    outside[ROOM] = -certainty
    return free, outside


@pytest.mark.parametrize("gap", [0, 6, 10])
def test_a_gap_in_the_outer_wall_loses_no_room(gap):
    free, outside = draw_room(gap=gap)
    inside = indoor_mask(free, outside, CELL)
    assert inside[ROOM].mean() > 0.97
    assert inside.sum() == pytest.approx(40 * 50, rel=0.03)


def test_an_uncertain_spot_in_a_room_is_inside_and_an_uncertain_room_open_to_the_paper_is_not():
    free, outside = draw_room()
    outside[25:40, 25:40] = 0.8
    assert indoor_mask(free, outside, CELL)[ROOM].all()
    free, outside = draw_room(gap=30, certainty=0.1)
    assert not indoor_mask(free, outside, CELL).any()


def test_a_yard_between_walls_is_outside():
    free, outside = draw_room()
    outside[ROOM] = 0.5
    assert not indoor_mask(free, outside, CELL).any()


def test_enclosed_space_is_inside_if_the_network_is_uncertain():
    for gap, inside in ((0, True), (30, False)):
        free, outside = draw_room(gap=gap, certainty=-0.1)
        assert indoor_mask(free, outside, CELL)[ROOM].all() == inside


def test_space_that_reaches_the_edge_of_the_sheet_is_not_enclosed():
    free = np.array([[1, 0, 0, 0, 0], [0, 1, 1, 0, 1], [0, 0, 0, 0, 1], [0, 0, 1, 0, 0]], bool)
    assert np.argwhere(enclosed_mask(free)).tolist() == [[1, 1], [1, 2]]
    assert not enclosed_mask(np.ones((3, 3), bool)).any()


def test_a_room_that_the_sheet_cuts_off_is_inside_if_the_network_is_certain():
    free, outside = draw_room()
    free, outside = free[:, 30:], outside[:, 30:]
    assert indoor_mask(free, outside, CELL)[20:60, :40].all()
    assert not indoor_mask(free, outside * np.float32(0.1), CELL).any()


def test_the_middle_of_a_hall_has_the_class_of_its_edge():
    free = np.zeros((200, 200), bool)
    free[10:190, 10:190] = True
    outside = np.full(free.shape, 0.9, np.float32)
    outside[10:190, 10:190] = -0.8
    outside[40:160, 40:160] = 0.8
    assert indoor_mask(free, outside, CELL)[10:190, 10:190].all()


def test_parts_meet_where_the_space_is_narrowest():
    free = np.zeros((20, 41), bool)
    free[2:18, 2:18] = free[2:18, 23:39] = True
    free[8:12, 18:23] = True
    distance = ndimage.distance_transform_edt(free)
    parts = split_space(distance.astype(np.float32), 1.0)
    assert len({parts[9, 9], parts[9, 30], 0}) == 3
    assert not parts[~free].any()


@given(st.integers(0, 2**32 - 1), st.integers(1, 30), st.integers(1, 30))
def test_parts_fill_the_free_space_and_stay_within_barriers(seed, height, width):
    free = np.random.default_rng(seed).random((height, width)) < 0.7
    distance = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1]
    parts = split_space(distance.astype(np.float32), 0.2)
    assert parts.shape == free.shape
    assert not parts[~free].any()
    assert not free.any() or parts.flat[distance.argmax()]
    pieces, count = ndimage.label(free)
    filled = [(parts[pieces == piece] > 0).mean() for piece in range(1, count + 1)]
    assert set(filled) <= {0, 1}
    joined, _ = ndimage.label(free, np.ones((3, 3)))
    owners = {tuple(pair) for pair in np.column_stack([parts[parts > 0], joined[parts > 0]]).tolist()}
    assert len(owners) == len({part for part, _ in owners})


def test_a_passage_one_cell_wide_is_part_of_the_space():
    """It crosses the blocks in which the space is flooded."""
    free = np.zeros((21, 41), bool)
    free[2:18, 2:16] = free[2:18, 25:39] = True
    free[9, 16:25] = True
    distance = ndimage.distance_transform_edt(free).astype(np.float32)
    parts = split_space(distance, 0.1)
    left, right = parts[9, 8], parts[9, 31]
    assert left != right
    along = parts[9, 2:39]
    assert (along > 0).all()
    assert along[0] == left
    assert along[-1] == right


@given(st.integers(0, 2**32 - 1))
def test_labels_grow_as_in_the_watershed_of_the_whole_image(seed):
    rng = np.random.default_rng(seed)
    heights = rng.permutation(30 * 40).reshape(30, 40).astype(np.float32)
    labels = ndimage.label(ndimage.gaussian_filter(rng.random((30, 40)), 3) > 0.5)[0].astype(np.int32)
    mask = rng.random((30, 40)) < 0.9
    grown = grow_labels(heights, labels * mask, mask)
    assert (grown[mask & (labels > 0)] == labels[mask & (labels > 0)]).all()
    assert not grown[~mask].any()
    different = grown != watershed(heights, labels * mask, mask=mask)
    # A cell between two labels may have either of them.
    assert different.mean() < 0.01


def test_labels_meet_at_the_ridge():
    heights = np.tile(np.array([0, 1, 2, 9, 3, 2, 1, 0], np.float32), (3, 1))
    labels = np.zeros((3, 8), np.int32)
    labels[:, 0], labels[:, -1] = 4, 7
    grown = grow_labels(heights, labels, np.ones((3, 8), bool))
    assert (np.delete(grown, 3, axis=1) == [4, 4, 4, 7, 7, 7, 7]).all()
    none = grow_labels(heights, np.zeros_like(labels), np.ones((3, 8), bool))
    assert not none.any()


def test_borders_are_as_long_as_the_sides_of_cells_that_touch():
    parts = np.array([[1, 1, 2], [1, 1, 2], [0, 3, 3]], np.int32)
    pairs, lengths = shared_borders(parts)
    assert dict(zip(map(tuple, pairs.tolist()), lengths.tolist(), strict=True)) == {(1, 2): 2, (1, 3): 1, (2, 3): 1}


@pytest.mark.slow
@settings(max_examples=50, deadline=None)
@given(st.lists(st.integers(-5, 5), min_size=1, max_size=6), st.data())
def test_no_other_cut_costs_less(gains, data):
    count = len(gains)
    every = [(one, other) for one in range(count) for other in range(one)]
    pairs = data.draw(st.lists(st.sampled_from(every), unique=True) if every else st.just([]))
    costs = data.draw(st.lists(st.integers(0, 4), min_size=len(pairs), max_size=len(pairs)))

    def worth(chosen: tuple[bool, ...]) -> float:
        parted = sum(cost for (one, other), cost in zip(pairs, costs, strict=True) if chosen[one] != chosen[other])
        return float(sum(gain for gain, is_chosen in zip(gains, chosen, strict=True) if is_chosen) - parted)

    cut = minimum_cut(np.array(gains, float), np.array(pairs, np.int64).reshape(-1, 2), np.array(costs, float))
    assert worth(tuple(cut)) == max(map(worth, product((False, True), repeat=count)))


def test_a_metre_of_open_border_costs_its_parameter():
    """Two parts, one certainly inside, one outside, and 1 m between them."""
    pairs, open_metre = np.array([[0, 1]]), np.array([PARAMETERS.open_border])
    assert minimum_cut(np.array([3.0, -1.0]), pairs, open_metre).tolist() == [True, True]
    assert minimum_cut(np.array([3.0, -2.5]), pairs, open_metre).tolist() == [True, False]
