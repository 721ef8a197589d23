import numpy as np
import pytest

from pianta.layout.partial.shape_network import (
    COLUMNS_LAYER,
    LAYERS,
    PATCH_SIZE,
    ROWS_LAYER,
    SYMMETRIES,
    draw_lines,
    draw_patch,
    expect_cells,
)
from tests.partial_scenes import fill_cells, make_scene

# A patch of 80 x 80 cells of 0.25 m around rows and cols 10 … 19 of cells of 0.1 m has 2.5 of these in a side.
OBSERVED = fill_cells(10, 10, 20, 20)


@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_a_symmetry_is_undone(symmetry):
    cells = np.arange(12, dtype=np.float32).reshape(3, 4)
    assert (symmetry.undo(symmetry.move(cells)) == cells).all()


def test_the_eight_symmetries_differ():
    cells = np.arange(9).reshape(3, 3)
    assert len({symmetry.move(cells).tobytes() for symmetry in SYMMETRIES}) == 8


def test_the_walls_in_line_with_columns_are_those_with_rows_after_an_exchange():
    layers = np.zeros((len(LAYERS), 2, 2), np.uint8)
    layers[COLUMNS_LAYER] = [[1, 2], [1, 2]]
    (exchange,) = (each for each in SYMMETRIES if each.exchanged and not each.mirrored)
    moved = exchange.apply(layers)
    assert moved[ROWS_LAYER].tolist() == [[1, 1], [2, 2]]
    assert not moved[COLUMNS_LAYER].any()


def test_lines_are_drawn_where_their_cells_are():
    # From the middle of the cell in row 4, col 10 to that in col 20; two cells of the scene are one of the patch.
    matrix = np.array([[0.5, 0, 0], [0, 0.5, 0]])
    image = draw_lines(np.array([[[10.5, 4.5], [20.5, 4.5]]]), matrix)
    rows, cols = np.nonzero(image > 127)
    assert (set(rows.tolist()), set(cols.tolist())) == ({2}, {*range(5, 11)})


def test_lines_that_end_far_away_are_cut_off():
    far = np.array([[[-1e9, 4.5], [1e9, 4.5]], [[-1e9, -1e9], [-1e9, 1e9]]])
    image = draw_lines(far, np.eye(2, 3))
    assert (image[4] > 127).all()
    assert not np.delete(image, (3, 4, 5), axis=0).any()


def test_a_patch_shows_walls_and_doors():
    scene = make_scene(OBSERVED, lines=np.array([[[0, 30.0], [60, 30.0]]]), doors=np.array([[[12, 20.0], [20, 20.0]]]))
    layers, matrix = draw_patch(scene)
    assert layers.shape == (len(LAYERS), PATCH_SIZE, PATCH_SIZE)
    wall, door = (layers[LAYERS.index(name)].max(axis=1) for name in ("lines of walls", "doors"))
    to_row = matrix[1, 1] * (np.array([30, 20]) - 0.5) + matrix[1, 2]
    assert np.abs([wall.argmax(), door.argmax()] - to_row).max() <= 1


def test_a_mirrored_or_turned_scene_has_the_mirrored_or_turned_cells():
    """Nearly: a cell of a patch is the mean of two by two of the scene, whose middle is half a cell off."""
    lines = np.array([[[0, 8.0], [60, 8.0]], [[5.0, 0], [5.0, 40]], [[32.0, 0], [32.0, 40]]])
    scene = make_scene(OBSERVED, fill_cells(0, 34, 40, 60), lines=lines)
    expected = expect_cells(scene)
    mirrored = make_scene(OBSERVED[::-1], scene.others[::-1], lines=np.abs([[[0, 40.0], [0, 40.0]]] - lines))
    assert expect_cells(mirrored)[::-1] == pytest.approx(expected, abs=0.1)
    turned = make_scene(OBSERVED.T, scene.others.T, lines=lines[..., ::-1])
    assert pytest.approx(expected, abs=0.1) == expect_cells(turned).T


def test_cells_of_other_rooms_are_improbable_and_observed_ones_certain():
    scene = make_scene(OBSERVED, fill_cells(0, 34, 40, 60))
    cells = expect_cells(scene)
    assert (cells[OBSERVED] == 1).all()
    assert not cells[:, 34:].any()
    assert ((cells >= 0) & (cells <= 1)).all()
