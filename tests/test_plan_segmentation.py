"""Segmentation of plans: the input of the network, its output, and its entropy."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import binary_dilation

from pianta.plan import network
from pianta.plan.network import BLOCK, TILE, _list_tiles
from pianta.plan.walls.segmentation import (
    DOOR,
    INSIDE,
    NETWORKS,
    OUTSIDE,
    TRAINED_ON,
    WALL,
    ClassMap,
    has_walls,
    input_layers,
    mean_entropy,
    networks_without,
    segment_sheet,
)
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.plans.drawing import draw_plan
from tests.drawn_class_maps import as_class_map, two_rooms

GREY, DARKEST, CHROMA, CONTRAST = range(4)


def page(height: int, width: int, color: int = 255) -> np.ndarray:
    return np.full((height, width, 3), color, np.uint8)


@pytest.mark.parametrize("cell_px", [0.5, 1.0, 2.5, 4.0])
def test_layers_are_as_large_as_the_sheet_in_cells(cell_px):
    layers = input_layers(page(100, 200), cell_px=cell_px)
    assert layers.shape == (4, round(100 / cell_px), round(200 / cell_px))
    assert layers.dtype == np.float32
    assert np.ptp(layers, axis=(1, 2)).max() == 0
    assert layers[:, 0, 0].tolist() == [1, 1, 0, 0]


def test_a_line_thinner_than_a_cell_stays_dark_with_contrast():
    colors = page(160, 160)
    colors[:, 80] = 0
    layers = input_layers(colors, cell_px=8.0)
    assert layers[GREY, 10, 10] == pytest.approx(7 / 8, abs=0.01)
    assert layers[DARKEST, 10, 9:11].sum() == pytest.approx(1, abs=0.02)
    assert layers[CONTRAST, 10, 9:11].sum() == pytest.approx(1, abs=0.02)
    assert layers[:, 10, 3].tolist() == [1, 1, 0, 0]


def test_a_colour_has_chroma_and_grey_has_none():
    colors = page(80, 80)
    colors[:, :40] = (255, 55, 155)
    colors[:, 60:] = 120
    chroma = input_layers(colors, cell_px=2.0)[CHROMA]
    assert chroma[20, 5] == pytest.approx(200 / 255)
    assert chroma[20, 25:].max() == 0


def test_light_lines_on_dark_paper_have_the_layers_of_dark_ones():
    colors = page(64, 64)
    colors[30:34] = 0
    assert np.array_equal(input_layers(colors, cell_px=2.0), input_layers(255 - colors, cell_px=2.0))


def test_the_cells_of_a_narrow_sheet_are_as_large_as_of_any():
    """A line in the middle of a sheet that is lower than a block of the network."""
    colors = page(40, 400)
    colors[20:24] = 0
    dark = input_layers(colors, cell_px=4.0)[GREY, :, 50] < 0.5
    assert len(dark) == 10 < BLOCK
    assert np.flatnonzero(dark).tolist() == [5]


@pytest.mark.parametrize("side", [(31, 200), (97, 130)])
def test_the_probabilities_of_each_cell_sum_to_one(side):
    class_map = segment_sheet(page(*side), door_px=16.0)
    assert class_map.cell_px == 2.0
    assert class_map.probabilities.shape == (4, round(side[0] / 2), round(side[1] / 2))
    assert class_map.probabilities.min() >= 0
    assert class_map.probabilities.sum(axis=0) == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize("network", NETWORKS)
def test_each_network_finds_walls_rooms_and_outside_of_a_simple_plan(network):
    plan = draw_plan(make_corridor_floor(seed=3, length=12, room_depth=4), doors="gap", px_per_metre=20)
    class_map = segment_sheet(plan.colors, door_px=18.0, networks=[network])
    classes_of_cells = class_map.probabilities.argmax(axis=0)
    rows, cols = (np.arange(side) * class_map.cell_px + class_map.cell_px / 2 for side in classes_of_cells.shape)
    x, y = plan.grid.pixel_to_map(*np.meshgrid(rows, cols, indexing="ij"))
    at = np.ix_(rows.astype(int), cols.astype(int))
    rooms = plan.truth.label_image(plan.grid)[at] > 0
    black = plan.colors[at][..., 0] < 128
    rooms &= ~binary_dilation(black, iterations=2)
    beyond = (np.abs(x - 6) > 6.8) | (np.abs(y - 1.2) > 5.9)
    assert (classes_of_cells[rooms] == INSIDE).mean() > 0.85
    assert (classes_of_cells[black] == WALL).mean() > 0.85
    outside = class_map.probabilities[OUTSIDE]
    assert outside[beyond].mean() > outside[rooms].mean() + 0.15


def test_the_mean_of_several_networks_counts():
    colors = draw_plan(make_corridor_floor(seed=3, length=9, room_depth=4), px_per_metre=12).colors
    each = [segment_sheet(colors, door_px=11.0, networks=[name]).probabilities for name in NETWORKS]
    both = segment_sheet(colors, door_px=11.0, networks=NETWORKS).probabilities
    assert both == pytest.approx(np.mean(each, axis=0), abs=1e-6)
    assert np.abs(each[0] - each[1]).max() > 0.01


def test_the_mean_entropy_leaves_out_the_outside():
    certain, even = (as_class_map(two_rooms(), probability=probability) for probability in (1.0, 0.25))
    assert mean_entropy(certain) == pytest.approx(0, abs=1e-4)
    assert mean_entropy(even) == pytest.approx(np.log(4))
    halves = np.zeros((4, 2, 3), np.float32)
    halves[[INSIDE, WALL], 0] = 0.5
    halves[OUTSIDE, 1] = 1
    assert mean_entropy(ClassMap(halves, 1.0)) == pytest.approx(np.log(2), abs=1e-4)


def test_the_mean_entropy_is_highest_if_all_is_outside():
    nothing = np.zeros((4, 5, 5), np.float32)
    nothing[OUTSIDE] = 1
    assert mean_entropy(ClassMap(nothing, 1.0)) == pytest.approx(np.log(4))


@given(st.lists(st.floats(0.01, 1), min_size=4, max_size=4))
def test_the_mean_entropy_is_between_zero_and_log_four(weights):
    shares = np.array(weights, np.float32) / sum(weights)
    entropy = mean_entropy(ClassMap(np.broadcast_to(shares[:, None, None], (4, 3, 3)), 1.0))
    assert 0 <= entropy <= np.log(4) + 1e-4
    if shares[OUTSIDE] < 0.5:
        assert entropy == pytest.approx(-(shares * np.log(shares)).sum(), abs=1e-3)


@pytest.mark.parametrize(("walls", "enough"), [(0, False), (10, False), (20, True)])
def test_a_plan_has_walls_for_its_rooms(walls, enough):
    """A thousand cells of rooms."""
    classes = np.full((40, 40), OUTSIDE)
    classes.flat[:1000] = INSIDE
    classes.flat[1000 : 1000 + walls] = WALL
    assert has_walls(as_class_map(classes)) == enough


def test_walls_need_a_probability_above_one_half():
    assert has_walls(as_class_map(two_rooms(), probability=0.6))
    assert not has_walls(as_class_map(two_rooms(), probability=0.4))
    assert not has_walls(as_class_map(np.full((40, 40), OUTSIDE)))


def test_a_building_is_evaluated_by_networks_that_were_not_trained_on_it():
    trained_on = json.loads(TRAINED_ON.read_text(encoding="utf-8"))["networks"]
    assert set(trained_on) == set(NETWORKS)
    buildings = [(building, name) for name in NETWORKS for building in trained_on[name]]
    assert buildings
    for building, name in buildings:
        others = networks_without(building)
        assert name not in others
        assert others
    assert networks_without("an unknown building") == NETWORKS


def test_the_classes_are_in_the_order_of_the_network():
    assert (INSIDE, WALL, DOOR, OUTSIDE) == (0, 1, 2, 3)


@given(blocks=st.integers(1, 300))
def test_tiles_are_all_of_a_length_and_fit_the_network(blocks):
    length = blocks * BLOCK
    tiles = _list_tiles(length)
    assert [tile.start for tile, _ in tiles] == [0, *(tile.stop for tile, _ in tiles[:-1])]
    assert tiles[-1][0].stop == length
    for tile, input_cells in tiles:
        assert (input_cells.stop - input_cells.start) % BLOCK == 0
        assert tile.stop - tile.start > 0
        assert input_cells.stop - input_cells.start <= TILE


@pytest.mark.slow
def test_tiles_change_little(monkeypatch):
    plan = draw_plan(make_corridor_floor(), px_per_metre=20.0)
    untiled = segment_sheet(plan.colors, door_px=18.0, networks=NETWORKS[:1]).probabilities
    monkeypatch.setattr(network, "TILE", 224)
    monkeypatch.setattr(network, "TILE_OVERLAP", 64)
    tiled = segment_sheet(plan.colors, door_px=18.0, networks=NETWORKS[:1]).probabilities
    # The network sees less of the building around a tile
    assert (untiled.argmax(axis=0) == tiled.argmax(axis=0)).mean() > 0.97
