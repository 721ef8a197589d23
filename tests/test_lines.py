import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.layout.parameters import ThesisParameters
from pianta.layout.thesis import lines as lines_module
from pianta.layout.thesis.lines import RepresentativeLine, cluster_angles, cluster_spatially, get_representative_lines

DEFAULT = ThesisParameters()

offset_lists = st.lists(st.integers(0, 500).map(lambda cm: cm / 100), min_size=1, max_size=15)


def aim(*degrees: float):
    """Segments of 2 m from the origin at angles."""
    return np.array([[0, 0, 2 * np.cos(angle), 2 * np.sin(angle)] for angle in np.radians(degrees)])


def partition(labels: np.ndarray):
    """Clusters as sets of positions."""
    return {frozenset(np.flatnonzero(labels == label).tolist()) for label in np.unique(labels)}


def angle_between(angle: np.ndarray, other: np.ndarray):
    """Degrees between undirected lines at angles in radians."""
    return np.degrees(np.abs((angle - other + np.pi / 2) % np.pi - np.pi / 2))


def test_one_step_of_mean_shift_weighs_angles_with_the_kernel_of_the_thesis(monkeypatch):
    monkeypatch.setattr(lines_module, "MAX_SHIFTS", 1)
    labels, angles = cluster_angles(aim(6, 6, 8), DEFAULT)
    # 1 - cos 2° = 0.00060917; K = (1 - 0.00060917 / 0.023)² = 0.94773. The centres move to
    # (2 · 6 + K · 8) / (2 + K) = 6.64302 and (2 K · 6 + 8) / (2 K + 1) = 6.69074.
    assert labels.tolist() == [0, 0, 0]
    assert np.degrees(angles) == pytest.approx([(2 * 6.64302 + 6.69074) / 3], abs=1e-3)


def test_angles_beyond_the_kernel_are_clusters_of_their_own():
    # The kernel ends where 1 - cos = 0.023, at 12.3°.
    labels, angles = cluster_angles(aim(30, 42.5, 115), DEFAULT)
    assert labels.tolist() == [0, 1, 2]
    assert np.degrees(angles) == pytest.approx([30, 42.5, 115])


def test_angles_within_the_kernel_drift_into_one_cluster():
    labels, angles = cluster_angles(aim(30, 36), DEFAULT)
    assert labels.tolist() == [0, 0]
    assert np.degrees(angles) == pytest.approx([33])


def test_directions_near_zero_and_near_pi_are_one_cluster():
    labels, angles = cluster_angles(aim(1, 178, 90), DEFAULT)
    assert labels[0] == labels[1] != labels[2]
    assert angle_between(angles[labels], np.radians([-0.5, -0.5, 90])) == pytest.approx([0, 0, 0], abs=0.01)


@pytest.mark.parametrize("apart", [0.1, 1, 3, 5])
def test_a_cluster_whose_angles_surround_zero_is_one(apart):
    labels, angles = cluster_angles(aim(apart, 180 - apart, 180 - apart, apart, 0), DEFAULT)
    assert labels.tolist() == [0] * 5
    assert angle_between(angles, np.zeros(1)) == pytest.approx([0], abs=0.01)


@given(st.lists(st.integers(0, 1799).map(lambda tenths: tenths / 10), min_size=1, max_size=8), st.integers(0, 255))
def test_the_direction_of_a_segment_does_not_matter(degrees, flips):
    segments = aim(*degrees)
    reverse = (flips >> np.arange(len(degrees))) & 1 == 1
    turned = np.where(reverse[:, None], segments[:, [2, 3, 0, 1]], segments)
    (labels, angles), (same_labels, same_angles) = cluster_angles(segments, DEFAULT), cluster_angles(turned, DEFAULT)
    assert partition(labels) == partition(same_labels)
    assert angle_between(angles[labels], same_angles[same_labels]).max() < 0.1


@pytest.mark.parametrize(
    ("offsets", "labels"),
    [
        ([0, 0.1, 1.0, 1.2], [0, 0, 1, 1]),  # means 0.05 and 1.1
        ([1.2, 0, 1.0, 0.1], [1, 0, 1, 0]),
        ([0, 0.5, 1.0, 1.5], [0, 0, 1, 1]),  # means 0.25 and 1.25: neighbours are near, yet no chain
        ([0, 0, 0, 0.8], [0, 0, 0, 0]),
        ([0, 0.7, 0.8], [0, 0, 0]),  # 0.75 is near 0
        ([0, 0.9], [0, 1]),
        ([3.0], [0]),
    ],
)
def test_parallel_lines_nearer_than_the_distance_are_one(offsets, labels):
    assert cluster_spatially(np.array(offsets), 0.9).tolist() == labels


@pytest.mark.slow
@given(offset_lists)
def test_spatial_clusters_are_intervals_whose_means_lie_apart(offsets):
    values = np.array(offsets)
    labels = cluster_spatially(values, 0.9)
    assert (np.diff(labels[np.argsort(values, kind="stable")]) >= 0).all()
    means = np.array([values[labels == label].mean() for label in range(labels.max() + 1)])
    assert (np.diff(means) > 0.9 - 1e-9).all()


@given(offset_lists.flatmap(lambda offsets: st.tuples(st.just(offsets), st.permutations(range(len(offsets))))))
def test_spatial_clusters_do_not_depend_on_the_order(case):
    offsets, order = np.array(case[0]), np.array(case[1])
    assert np.array_equal(cluster_spatially(offsets[order], 0.9), cluster_spatially(offsets, 0.9)[order])


def test_a_line_runs_through_the_median_of_the_middles_of_its_segments():
    segments = np.array([[0, 1.0, 2, 1.0], [3, 1.1, 6, 1.1], [0, 1.5, 1, 1.5], [0, 4.0, 3, 4.0]])
    first, second = get_representative_lines(segments, DEFAULT)
    assert (first.angle, first.offset) == pytest.approx((0, 1.1))
    assert (second.angle, second.offset) == pytest.approx((0, 4.0))


def test_lines_of_a_turned_building_keep_their_places():
    turn = np.radians(17)
    direction, normal = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    segments = np.array([np.concatenate([normal * y, normal * y + direction * 3]) for y in (1.0, 4.0, 4.2, 4.3)])
    lines = get_representative_lines(segments, DEFAULT)
    assert [line.angle for line in lines] == pytest.approx([turn, turn])
    assert [line.offset for line in lines] == pytest.approx([1.0, 4.2])
    assert [line.covered.ravel().tolist() for line in lines] == [pytest.approx([0, 3])] * 2


@pytest.mark.parametrize(("length", "count"), [(0.95, 0), (1.05, 1)])
def test_a_line_needs_enough_wall_to_support_it(length, count):
    segments = np.array([[0, 1, length, 1], [4, 1, 4 + length, 1]])
    assert len(get_representative_lines(segments, DEFAULT)) == count


def test_segments_cover_what_they_project_onto():
    segments = np.array([[5.5, 1, 7, 1], [0, 1, 2, 1], [3, 1.2, 1, 1.2]])
    (line,) = get_representative_lines(segments, ThesisParameters(filled_gap=0.5))
    assert line.covered == pytest.approx(np.array([[0, 3], [5.5, 7]]))


@pytest.mark.parametrize(("filled_gap", "covered"), [(0.9, [[0, 3], [4, 6]]), (1.1, [[0, 6]])])
def test_gaps_as_wide_as_a_door_count_as_wall(filled_gap, covered):
    segments = np.array([[0, 1, 3, 1], [4, 1, 6, 1]])
    (line,) = get_representative_lines(segments, ThesisParameters(filled_gap=filled_gap))
    assert line.covered == pytest.approx(np.array(covered))


def test_no_segments_give_no_lines():
    assert get_representative_lines(np.zeros((0, 4)), DEFAULT) == []


@pytest.mark.parametrize(
    ("start", "end", "length"),
    [(0, 4, 3), (1, 3.5, 1.5), (2, 3, 0), (-5, -1, 0), (5, 6, 0), (-5, 9, 3), (0.5, 0.75, 0.25)],
)
def test_cover_is_the_length_of_wall_in_an_interval(start, end, length):
    line = RepresentativeLine(0.0, 1.0, np.array([[0.0, 2.0], [3.0, 4.0]]))
    assert line.cover(np.array([start]), np.array([end])) == pytest.approx([length])


@given(st.sets(st.integers(0, 19)).filter(bool), st.integers(-3, 23), st.integers(0, 10))
def test_cover_counts_the_covered_pieces(pieces, start, length):
    covered = np.array([[piece, piece + 1] for piece in sorted(pieces)], float)
    line = RepresentativeLine(0.0, 0.0, covered)
    expected = len(pieces & set(range(start, start + length)))
    assert line.cover(np.array([float(start)]), np.array([float(start + length)])) == pytest.approx([expected])
