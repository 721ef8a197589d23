import numpy as np
import pytest

from pianta.layout.parameters import ThesisParameters
from pianta.layout.thesis.segments import detect_edges, detect_segments
from tests.drawn_maps import carve, make_working_grid

DEFAULT = ThesisParameters()

ROOM = make_working_grid(carve((120, 180), (20, 100, 30, 150)))
# x, y of the two corners of the room, metres.
LEFT, TOP, RIGHT, BOTTOM = 1.5, 1.0, 7.5, 5.0


def measure_along_sides(segments: np.ndarray):
    """Length of the segments on each side of the room (left, right, top, bottom), and of those on none of them."""
    lengths = np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])
    on_side = [np.abs(segments[:, [0, 2]] - x).max(axis=1) <= 0.1 for x in (LEFT, RIGHT)]
    on_side += [np.abs(segments[:, [1, 3]] - y).max(axis=1) <= 0.1 for y in (TOP, BOTTOM)]
    return [lengths[mask].sum() for mask in (*on_side, ~np.any(on_side, axis=0))]


def count_stubs_found(column: int, passes: int):
    """Segments on a stub of wall, 12 cells long at a given column, beside a door at the end of a cross wall."""
    rooms = carve((160, 240), (10, 78, 10, 230), (82, 150, 10, 230))
    wall, door = carve(rooms.shape, (10, 78, column, column + 3)), carve(rooms.shape, (48, 66, column, column + 3))
    edges = detect_edges(make_working_grid(rooms & ~wall | door), DEFAULT)
    segments = detect_segments(edges, 0.05, ThesisParameters(hough_passes=passes)) / 0.05
    upright = np.abs(segments[:, 0] - segments[:, 2]) < 2
    beside = np.abs(segments[:, 0] - column - 1.5) < 4
    return int((upright & beside & (segments[:, [1, 3]].min(axis=1) > 62)).sum())


def test_edges_run_around_the_free_space():
    rows, cols = np.nonzero(detect_edges(ROOM, DEFAULT))
    beside_sides = np.isin(rows, (19, 20, 99, 100)) | np.isin(cols, (29, 30, 149, 150))
    assert beside_sides.all()
    assert (rows.min(), rows.max(), cols.min(), cols.max()) == pytest.approx((20, 99, 30, 149), abs=1)
    assert len(rows) >= 2 * (78 + 118)


def test_segments_lie_on_the_sides_of_a_room():
    *sides, distance = measure_along_sides(detect_segments(detect_edges(ROOM, DEFAULT), 0.05, DEFAULT))
    assert sides == pytest.approx([4, 4, 6, 6], abs=0.2)
    assert distance == 0


def test_segments_are_in_metres_whatever_the_cells():
    room = make_working_grid(ROOM.free.repeat(2, axis=0).repeat(2, axis=1), resolution=0.025)
    *sides, distance = measure_along_sides(detect_segments(detect_edges(room, DEFAULT), 0.025, DEFAULT))
    assert sides == pytest.approx([4, 4, 6, 6], abs=0.2)
    assert distance == 0


def test_walls_shorter_than_a_segment_are_not_found():
    pillar = make_working_grid(~carve((60, 60), (28, 32, 28, 32)))
    edges = detect_edges(pillar, DEFAULT)
    assert edges.any()
    assert len(detect_segments(edges, 0.05, DEFAULT)) == 0


def test_later_passes_find_short_walls_beside_doors():
    columns = range(60, 120, 6)
    once, thrice = ([count_stubs_found(column, passes) > 0 for column in columns] for passes in (1, 3))
    assert all(covered for covered, before in zip(thrice, once, strict=True) if before)
    assert sum(thrice) > sum(once)


def test_no_edges_give_no_segments():
    assert detect_segments(np.zeros((50, 50), np.uint8), 0.05, DEFAULT).shape == (0, 4)
