import numpy as np
import pytest

from pianta._types import Mask
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout._working_grid import to_working_grid
from pianta.layout.structure.frontiers import (
    BLUR_PX,
    MIN_FRONTIER_SHARE,
    find_frontiers,
    find_partial_labels,
    measure_frontiers,
    remove_ray_leaks,
)
from tests.drawn_maps import Rectangle, carve

SHAPE = (60, 80)
ROOM = (10, 50, 10, 70)
GREY = 50


def draw_map(*layers: tuple[Rectangle, int], resolution: float = 0.05) -> GridMap:
    """Map with rectangles of a value drawn one over the other, unknown elsewhere."""
    cells = np.full(SHAPE, UNKNOWN, np.int8)
    for rectangle, value in layers:
        cells[carve(SHAPE, rectangle)] = value
    return GridMap(cells, resolution)


def frontier_of(grid: GridMap) -> tuple[Mask, float]:
    canvas = to_working_grid(grid, grid.free, resolution=0.05)
    frontier = find_frontiers(grid, canvas, canvas.free)
    return frontier, float(measure_frontiers(canvas.free.astype(np.int32), frontier, resolution=canvas.resolution)[1])


WALLS = ((8, 52, 8, 72), OCCUPIED)
FLOOR = (ROOM, FREE)


def test_a_room_closed_by_walls_has_no_frontier():
    assert frontier_of(draw_map(WALLS, FLOOR))[1] == 0


@pytest.mark.parametrize("resolution", [0.025, 0.05, 0.1])
def test_a_wall_of_one_cell_closes_a_room_at_every_resolution(resolution):
    # Odd and even rows and columns, so that joined cells hold the wall on either side.
    for shift in (0, 1):
        room = (10 + shift, 50, 10 + shift, 70)
        walls = ((room[0] - 1, 51, room[2] - 1, 71), OCCUPIED)
        assert frontier_of(draw_map(walls, (room, FREE), resolution=resolution))[1] == 0


def test_the_side_without_a_wall_is_a_frontier_of_its_length():
    grid = draw_map(WALLS, ((8, 52, 70, 72), UNKNOWN), FLOOR)
    frontier, length = frontier_of(grid)
    # 40 cells, less those near the walls at both ends.
    assert length == pytest.approx((40 - 2 * BLUR_PX) * 0.05)
    # One cell wide.
    assert frontier.sum() == 40 - 2 * BLUR_PX
    assert 1 in (frontier.any(axis=0).sum(), frontier.any(axis=1).sum())


@pytest.mark.parametrize("resolution", [0.025, 0.1])
def test_a_frontier_is_as_long_in_metres_at_every_resolution(resolution):
    grid = draw_map(WALLS, ((8, 52, 70, 72), UNKNOWN), FLOOR, resolution=resolution)
    assert frontier_of(grid)[1] == pytest.approx(40 * resolution, abs=2 * (BLUR_PX + 1) * 0.05)


def test_the_blurred_side_of_a_wall_is_no_frontier():
    blurred = draw_map(((6, 54, 6, 74), OCCUPIED), ((9, 51, 9, 71), GREY), FLOOR)
    assert blurred.unknown[9, 40]
    assert frontier_of(blurred)[1] == 0
    grey = draw_map(((9, 51, 9, 71), GREY), FLOOR)
    assert frontier_of(grey)[1] > 9


def test_a_door_to_unknown_space_is_a_frontier():
    grid = draw_map(WALLS, ((20, 34, 70, 72), FREE), FLOOR)
    assert frontier_of(grid)[1] == pytest.approx((14 - 2 * BLUR_PX) * 0.05)


def test_each_label_has_the_frontier_of_its_own_cells():
    labels = np.array([[0, 1, 1, 3], [2, 2, 3, 3]], np.int32)
    frontier = np.array([[1, 1, 1, 0], [0, 0, 0, 1]], bool)
    assert measure_frontiers(labels, frontier, resolution=0.5).tolist() == [0.5, 1.0, 0.0, 0.5]
    assert measure_frontiers(labels, np.zeros_like(frontier), resolution=0.5).tolist() == [0, 0, 0, 0]


def test_a_strip_of_free_space_between_frontiers_is_a_ray_leak():
    # Strips 2 m long, 0.2 m and 0.4 m wide, with a frontier on both long sides, and a room with one on a side.
    labels = np.zeros((60, 40), np.int32)
    labels[2:6], labels[10:18], labels[20:60] = 1, 2, 3
    unseen = np.array([0.0, 4.0, 4.0, 2.0])
    cleaned = remove_ray_leaks(labels, unseen, width=0.3, resolution=0.05)
    assert np.unique(cleaned).tolist() == [0, 2, 3]
    assert (cleaned == np.where(labels == 1, 0, labels)).all()


def test_without_frontiers_there_is_no_ray_leak():
    labels = np.eye(5, dtype=np.int32)
    assert (remove_ray_leaks(labels, np.zeros(2), width=0.3, resolution=0.05) == labels).all()


def test_a_partial_room_has_a_frontier_that_is_long_for_its_size():
    """Rooms of 2 m x 2 m and 6 m x 6 m: a quarter of their sides is 0.5 m and 1.5 m."""
    labels = np.zeros((140, 200), np.int32)
    labels[10:50, 10:50], labels[10:130, 60:180] = 1, 2
    assert MIN_FRONTIER_SHARE == 0.25

    def find(*lengths: float) -> tuple[bool, ...]:
        return tuple(map(bool, find_partial_labels(labels, np.array([0, *lengths]), min_length=0.4, resolution=0.05)))

    assert find(0.51, 1.51) == (False, True, True)
    assert find(0.49, 1.49) == (False, False, False)
    labels[labels == 1] = 0
    labels[10:12, 10:12] = 1
    assert find(0.39, 0) == (False, False, False)
    assert find(0.41, 0) == (False, True, False)
