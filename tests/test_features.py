"""The laser scans, their features and the classifier of the feature-based segmentation, checked by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.lib.stride_tricks import sliding_window_view

from pianta.layout.rivals.features import (
    BEAMS,
    PLACE_CLASSES,
    PlaceClassifier,
    choose_cells,
    describe_scans,
    load_place_classifier,
    scan_cells,
    segment_by_features,
)
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.scan import simulate_map
from tests.drawn_maps import carve

ROOM = carve((80, 120), (10, 71, 10, 111))
MIDDLE = np.array([[40, 60]])
QUARTER = BEAMS // 4


def circle(radius: float):
    return np.full((1, BEAMS), radius)


def test_beams_go_right_down_left_and_up_to_the_walls():
    (lengths,) = scan_cells(ROOM, MIDDLE, 0.05)
    right, down, left, up = lengths[::QUARTER]
    assert (right, left) == (pytest.approx(2.525, abs=0.03), pytest.approx(2.525, abs=0.03))
    assert (down, up) == (pytest.approx(1.525, abs=0.03), pytest.approx(1.525, abs=0.03))
    assert lengths.max() <= np.hypot(2.6, 1.6)


def test_a_beam_leaves_through_a_door():
    free = ROOM | carve(ROOM.shape, (38, 43, 111, 118))
    (lengths,) = scan_cells(free, MIDDLE, 0.05)
    assert lengths[0] == pytest.approx(2.525 + 7 * 0.05, abs=0.03)


def test_beams_end_at_the_edge_of_the_map():
    (lengths,) = scan_cells(np.ones((21, 21), bool), np.array([[10, 10]]), 0.1)
    assert lengths[0] == pytest.approx(1.05, abs=0.06)


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
def test_no_beam_passes_through_an_obstacle(seed):
    free = np.random.default_rng(seed).random((20, 20)) > 0.2
    free[10, 10] = True
    lengths = scan_cells(free, np.array([[10, 10]]), 1.0)[0]
    angle = 2 * np.pi * np.arange(BEAMS) / BEAMS
    way = np.arange(0, 30, 0.05)
    rows, cols = 10.5 + np.sin(angle)[:, None] * way, 10.5 + np.cos(angle)[:, None] * way
    inside = (rows >= 0) & (rows < 20) & (cols >= 0) & (cols < 20)
    blocked = ~(inside & free[rows.clip(0, 19).astype(int), cols.clip(0, 19).astype(int)])
    # It may clip a corner, and end in the obstacle, by half a cell.
    stretches = sliding_window_view(blocked & (way <= lengths[:, None]), 12, axis=1).all(axis=2)
    assert not stretches.any()


def test_features_of_a_round_room():
    features = {name: float(values[0]) for name, values in describe_scans(circle(3.0)).items()}
    assert features["mean length"] == pytest.approx(3)
    assert features["area"] == pytest.approx(np.pi * 9, rel=1e-3)
    assert features["perimeter"] == pytest.approx(np.pi * 6, rel=1e-3)
    assert features["width"] == pytest.approx(6)
    assert features["elongation"] == pytest.approx(1)
    assert features["mean length to 2 m"] == pytest.approx(2)
    assert features["gaps"] == 0
    assert features["deviation of length"] == pytest.approx(0, abs=1e-9)


def test_a_jump_between_beams_is_a_gap():
    lengths = circle(3.0)
    lengths[0, 10:20] = 6.0
    features = describe_scans(lengths)
    assert features["gaps"][0] == 2
    assert features["relative gaps"][0] == 0
    assert features["mean step"][0] == pytest.approx(6 / BEAMS)


@given(st.integers(0, BEAMS - 1), st.integers(0, 2**32 - 1))
def test_features_do_not_depend_on_where_the_robot_looks(turn, seed):
    lengths = 0.5 + 5 * np.random.default_rng(seed).random((1, BEAMS))
    turned = describe_scans(np.roll(lengths, turn, axis=1))
    for name, values in describe_scans(lengths).items():
        assert turned[name] == pytest.approx(values), name


def test_stumps_vote_by_weight():
    classifier = PlaceClassifier(
        ("width", "area"), np.array([2.0, 9.0]), np.array([1, 1]), np.array([0, 2]), np.array([1.0, 0.5])
    )
    votes = classifier.vote({"width": np.array([2.0, 2.1]), "area": np.array([10.0, 1.0])})
    assert votes.tolist() == [[0, 1, 0.5], [1, 0.5, 0]]


def test_the_classifier_of_pianta_is_complete():
    classifier = load_place_classifier()
    features = describe_scans(circle(1.0))
    assert len(classifier.feature) == 350
    assert set(classifier.feature) <= features.keys()
    assert (classifier.weight > 0).all()
    assert {*classifier.below.tolist(), *classifier.above.tolist()} == set(range(len(PLACE_CLASSES)))


def test_rooms_and_corridors_of_an_unknown_floor_are_distinguished():
    floor = make_corridor_floor(seed=1234, length=24)
    grid = simulate_map(floor)
    corridor = floor.label_image(grid) == 1
    cells = choose_cells(grid.free, 10)
    classes = load_place_classifier().vote(describe_scans(scan_cells(grid.free, cells, grid.resolution))).argmax(axis=1)
    is_corridor = corridor[tuple(cells.T)]
    assert (classes[is_corridor] == PLACE_CLASSES.index("corridor")).mean() > 0.85
    assert (classes[~is_corridor] == PLACE_CLASSES.index("room")).mean() > 0.85


@pytest.mark.slow
def test_an_unknown_floor_is_divided_into_its_rooms():
    floor = make_corridor_floor(seed=1234, length=24)
    grid = simulate_map(floor)
    labels = segment_by_features(grid)
    assert len(floor.rooms) - 1 <= labels.max() <= len(floor.rooms) + 1


def test_one_cell_is_scanned_in_each_square():
    free = carve((6, 6), (0, 6, 0, 3), (0, 1, 5, 6))
    assert choose_cells(free, 3).tolist() == [[1, 1], [0, 5], [4, 1]]
