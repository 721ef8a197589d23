import numpy as np
import pytest
from hypothesis import given, reject
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from shapely import MultiPoint, box, get_coordinates

from pianta._types import Mask
from pianta.errors import MapError
from pianta.layout._working_grid import MARGIN_PX, to_working_grid
from tests.drawn_maps import carve, make_grid

# Mostly free.
masks = (
    arrays(np.int8, array_shapes(min_dims=2, max_dims=2, max_side=12), elements=st.integers(0, 7))
    .map(np.bool_)
    .filter(np.any)
)
SYMMETRIES = [(turns, mirrored) for turns in range(4) for mirrored in (False, True)]


def apply_symmetry(cells: Mask, turns: int, mirrored: bool):
    turned = np.rot90(cells, turns)
    return turned[:, ::-1] if mirrored else turned


def make_or_reject(free: Mask, resolution: float, yaw: float = 0.0):
    """Working grid of free cells; examples whose free space is narrower than a working cell are rejected."""
    try:
        return to_working_grid(make_grid(free, resolution=resolution, yaw=yaw), free, resolution=0.05)
    except MapError:
        reject()


def test_free_space_is_cropped_with_a_margin_and_turned_into_the_canonical_pose():
    free = carve((30, 40), (10, 20, 7, 9), (18, 20, 9, 12))
    expected = carve((5, 10), (0, 2, 0, 10), (2, 5, 0, 2))
    working_grid = to_working_grid(make_grid(free), free, resolution=0.05)
    assert np.array_equal(working_grid.free, np.pad(expected, MARGIN_PX))
    assert working_grid.resolution == 0.05


def test_fine_cells_are_joined_and_a_joined_cell_with_any_wall_is_wall():
    free = np.ones((4, 6), bool)
    free[1, 0] = False
    working_grid = to_working_grid(make_grid(free, resolution=0.025), free, resolution=0.05)
    assert working_grid.resolution == 0.05
    assert (working_grid.free.sum(), working_grid.free.size) == (5, (2 + 2 * MARGIN_PX) * (3 + 2 * MARGIN_PX))


def test_joining_an_odd_number_of_cells_repeats_the_last():
    free = np.ones((5, 7), bool)
    working_grid = to_working_grid(make_grid(free, resolution=0.025), free, resolution=0.05)
    assert working_grid.free.sum() == 3 * 4


def test_coarse_cells_are_repeated():
    free = np.ones((2, 3), bool)
    working_grid = to_working_grid(make_grid(free, resolution=0.1), free, resolution=0.05)
    assert working_grid.resolution == 0.05
    assert working_grid.free.sum() == 4 * 6


@pytest.mark.parametrize(
    ("resolution", "repeats", "expected"),
    [
        (0.05, 1, 0.05),
        (0.08, 1, 0.08),
        (0.1, 1, 0.1),
        (0.2, 1, 0.1),
        (0.05, 2, 0.1),
        (0.025, 2, 0.05),
        (0.05, 3, 0.05),
        (0.05, 4, 0.1),
    ],
)
def test_cells_up_to_the_coarsest_size_stay_also_on_maps_that_were_enlarged(resolution, repeats, expected):
    # Odd positions, so that the smallest blocks are the cells themselves.
    cells = carve((12, 12), (1, 8, 1, 4), (1, 4, 1, 11))
    free = cells.repeat(repeats, axis=0).repeat(repeats, axis=1)
    working_grid = to_working_grid(make_grid(free, resolution=resolution), free, resolution=0.05, coarsest=0.1)
    assert working_grid.resolution == pytest.approx(expected)


def test_geometry_of_the_working_grid_is_transformed_into_the_map_frame():
    free = carve((30, 40), (10, 20, 5, 35))
    working_grid = to_working_grid(make_grid(free, yaw=np.pi / 2), free, resolution=0.05)
    start, stop = MARGIN_PX * 0.05, MARGIN_PX * 0.05 + np.array([1.5, 0.5])
    # 0.25 … 1.75 m along the grid's x axis, which points along the map's y; 0.5 … 1 m along its y axis.
    assert working_grid.to_map(box(start, start, *stop)).equals_exact(
        box(1.5 - 1.0, -2 + 0.25, 1.5 - 0.5, -2 + 1.75), 1e-9, normalize=True
    )


@pytest.mark.slow
@given(masks, st.sampled_from([0.025, 0.05, 0.1]), st.integers(0, 5))
def test_all_symmetries_and_paddings_of_a_map_give_the_same_working_grid(free, resolution, padding):
    poses = [apply_symmetry(free, turns, mirrored) for turns, mirrored in SYMMETRIES]
    paddings = ((padding, 0), (1, 2 * padding))
    working_grids = [make_or_reject(np.pad(pose, paddings), resolution).free for pose in poses]
    assert all(np.array_equal(working_grid, working_grids[0]) for working_grid in working_grids)


@pytest.mark.slow
@given(masks, st.integers(2, 4))
def test_smaller_cells_give_the_same_working_grid(free, factor):
    fine = free.repeat(factor, axis=0).repeat(factor, axis=1)
    working_grid, same = make_or_reject(free, 0.05), make_or_reject(fine, 0.05 / factor)
    assert np.array_equal(working_grid.free, same.free)
    assert same.resolution == pytest.approx(0.05)


@pytest.mark.slow
@given(
    masks,
    st.sampled_from(SYMMETRIES),
    st.sampled_from([(0.05 / 3, 3), (0.025, 2), (0.05, 1), (0.1, 0.5), (0.15, 1 / 3)]),
    st.integers(0, 5),
    st.floats(-3, 3),
)
def test_working_cells_cover_the_map_cells_that_they_represent(mask, symmetry, scale, padding, yaw):
    resolution, width = scale
    free = np.pad(apply_symmetry(mask, *symmetry), ((0, padding), (padding, 1)))
    working_grid = make_or_reject(free, resolution, yaw)
    rows, cols = np.indices(working_grid.free.shape).reshape(2, -1)
    centres = working_grid.to_map(MultiPoint((np.column_stack([cols, rows]) + 0.5) * working_grid.resolution))
    row, col = working_grid.grid.map_to_pixel(*get_coordinates(centres).T)
    row_spans, col_spans = (
        span_cells(middles, width, np.flatnonzero(free.any(axis=axis))) for middles, axis in ((row, 1), (col, 0))
    )
    parts = [free[slice(*row_span), slice(*col_span)] for row_span, col_span in zip(row_spans, col_spans, strict=True)]
    assert working_grid.free.ravel().tolist() == [bool(part.size and part.all()) for part in parts]


def span_cells(middles: np.ndarray, width: float, within: np.ndarray):
    """First and last + 1 of the cells that intervals of a width touch, among a range of cells; shape (N, 2)."""
    first, last = np.floor(middles - width / 2 + 1e-6), np.ceil(middles + width / 2 - 1e-6)
    return np.column_stack([np.maximum(first, within[0]), np.clip(last, 0, within[-1] + 1)]).astype(int)


@pytest.mark.slow
@given(masks, st.sampled_from(SYMMETRIES), st.sampled_from([0.025, 0.05, 0.1, 0.15]), st.integers(0, 5))
def test_sampled_free_cells_are_those_of_the_working_grid_in_every_pose_and_resolution(
    mask, symmetry, resolution, padding
):
    free = np.pad(apply_symmetry(mask, *symmetry), ((0, padding), (padding, 1)))
    # Joined cells are all free or all occupied.
    free = free.repeat(2, axis=0).repeat(2, axis=1) if resolution == 0.025 else free
    working_grid = make_or_reject(free, resolution)
    assert np.array_equal(working_grid.sample(free), working_grid.free)


def test_a_sample_of_numbers_has_the_same_numbers_and_0_beyond_the_map():
    free = np.ones((2, 3), bool)
    working_grid = to_working_grid(make_grid(free), free, resolution=0.05)
    numbers = np.array([[1, 2, 3], [4, 5, 6]])
    assert np.sort(working_grid.sample(numbers)[working_grid.free]).tolist() == [1, 2, 3, 4, 5, 6]
    assert not working_grid.sample(numbers)[~working_grid.free].any()


def test_cells_around_the_free_space_are_sampled_and_none_beyond_the_map():
    free = carve((30, 40), (2, 12, 5, 35))
    working_grid = to_working_grid(make_grid(free), free, resolution=0.05)
    # Two rows of the working grid lie above the map; the free space is one rectangle, so its pose is that of the map.
    assert np.array_equal(working_grid.sample(np.ones((30, 40), bool)).sum(axis=1), [0, 0, *[38] * 16])
    assert not working_grid.sample(np.zeros((30, 40), bool)).any()


@pytest.mark.parametrize(("turns", "mirrored"), SYMMETRIES)
def test_other_cells_than_free_ones_are_sampled_in_the_pose_of_the_working_grid(turns, mirrored):
    free = carve((30, 40), (10, 20, 7, 9), (18, 20, 9, 12))
    mark = carve((30, 40), (17, 18, 9, 11))
    working_grid = to_working_grid(
        make_grid(apply_symmetry(free, turns, mirrored)), apply_symmetry(free, turns, mirrored), resolution=0.05
    )
    # The canonical pose, see above: the corner of the L comes first.
    expected = np.pad(carve((5, 10), (2, 4, 2, 3)), MARGIN_PX)
    assert np.array_equal(working_grid.sample(apply_symmetry(mark, turns, mirrored)), expected)


@pytest.mark.parametrize(
    ("free", "resolution", "message"),
    [
        (np.zeros((3, 3), bool), 0.05, "free"),
        (np.ones((3, 3), bool), 0.001, r"0\.05.*0\.001"),
        (np.ones((3, 3), bool), 1e-320, r"0\.05"),
        (np.eye(90, dtype=bool), 0.01, r"0\.05"),
        (np.ones((99, 99), bool), 50.0, "50"),
        (np.ones((99, 99), bool), 1e308, "coarse"),
    ],
)
def test_free_space_without_a_valid_working_grid_is_refused(free, resolution, message):
    with pytest.raises(MapError, match=message):
        to_working_grid(make_grid(free, resolution=resolution), free, resolution=0.05)
