"""The distance transform segmentation, checked by hand."""

from pianta.layout.rivals.distance import DistanceParameters, segment_by_clearance
from tests.drawn_maps import carve, make_grid

# Three rooms of 2 × 2 m in a row, with doors of 0.4 m and 1 m.
ROW = carve((60, 148), (10, 50, 10, 50), (10, 50, 54, 94), (10, 50, 98, 138), (26, 34, 50, 54), (20, 40, 94, 98))


def rooms_in_row(parameters: DistanceParameters | None = None):
    labels = segment_by_clearance(make_grid(ROW), parameters=parameters)
    return [labels[30, col] for col in (30, 74, 118)], labels


def test_the_threshold_with_most_rooms_is_kept():
    rooms, labels = rooms_in_row()
    assert rooms == [1, 2, 3]
    assert (labels[10:50, 10:50] == 1).all()
    assert ((labels > 0) == ROW).all()


def test_patches_below_the_smallest_room_do_not_count():
    # Above 0.2 m the first room has 1.6 × 1.6 m left; where the second door closes, at 0.5 m, 1 × 1 m is left of each.
    rooms, _ = rooms_in_row(DistanceParameters(smallest=2.0))
    assert rooms == [1, 2, 2]


def test_patches_above_the_largest_room_do_not_count():
    rooms, labels = rooms_in_row(DistanceParameters(largest=0.9))
    assert rooms == [1, 2, 3]
    rooms, labels = rooms_in_row(DistanceParameters(largest=0.3))
    assert not labels.any()


def test_of_two_equally_good_thresholds_the_lower_is_kept():
    # Two rooms and a closet: where the door of 0.3 m is closed the closet is gone, and two are left either way.
    free = carve((60, 140), (10, 50, 10, 50), (10, 50, 54, 94), (26, 32, 50, 54), (20, 34, 110, 124))
    labels = segment_by_clearance(make_grid(free))
    assert labels[27, 117] > 0
