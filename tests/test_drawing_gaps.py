"""Rows of rooms that go beyond the ends of a corridor, and rooms that grow into gaps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.generation.drawing.blocks import DOOR_CELLS, NO_ROOM, Block, Rectangle
from pianta.generation.drawing.gaps import MAX_GROWTH, close_gaps
from pianta.generation.drawing.losses import LOSS_BY_ELONGATION, LOSS_BY_FACADE, measure_elongation, measure_facade
from pianta.generation.drawing.rows import divide_paths, make_row


def read_cells(*lines: str) -> np.ndarray:
    """Cells as digits, a dot for none, with two cells of margin."""
    rows = [[NO_ROOM if sign == "." else int(sign) for sign in line] for line in lines]
    return np.pad(np.array(rows, np.int32), 2, constant_values=NO_ROOM)


class TestCloseGaps:
    def test_a_room_grows_to_the_room_before_it(self):
        cells = read_cells("00000.11", "00000.11")
        close_gaps(cells, [0, 1])
        assert np.array_equal(cells, read_cells("00000011", "00000011"))

    def test_a_room_grows_to_the_facade_beside_it(self):
        cells = read_cells("1111.", "1111.", *["11110"] * 4)
        close_gaps(cells, [0, 1])
        assert np.array_equal(cells, read_cells(*["11110"] * 6))

    def test_rooms_do_not_become_much_larger(self):
        cells = read_cells("00....11", "00....11")
        before = cells.copy()
        close_gaps(cells, [0, 1])
        assert np.array_equal(cells, before)

    def test_a_side_of_two_parts_does_not_grow(self):
        cells = read_cells("0.0", "000", "...", "111")
        close_gaps(cells, [0])
        assert np.array_equal(cells[:3], read_cells("0.0", "000", "...", "111")[:3])

    @given(st.lists(st.integers(-1, 3), min_size=36, max_size=36))
    def test_rooms_only_grow_into_free_cells(self, values):
        before = np.repeat(np.repeat(np.array(values, np.int32).reshape(6, 6), 3, axis=0), 3, axis=1)
        cells = before.copy()
        rooms = np.unique(before[before != NO_ROOM]).tolist()
        close_gaps(cells, rooms)
        assert np.array_equal(cells[before != NO_ROOM], before[before != NO_ROOM])
        for room in rooms:
            assert (cells == room).sum() <= (1 + MAX_GROWTH) * (before == room).sum()


def test_a_row_goes_beyond_the_corridor_as_far_as_doors_allow():
    first = Block((Rectangle(1, 0, 0, 10, 12),), 0, 10)
    # A wing: its corridor 2 has rooms 3 and 4 on both sides, which have no door to the corridor of the row
    wing = Block((Rectangle(3, 0, 0, 6, 9), Rectangle(2, 6, 0, 10, 20), Rectangle(4, 10, 0, 16, 9)), 6, 10)
    row = make_row([(first, 0), (wing, 10)], 26, {1, 2}, 12)
    assert (row.before, row.after) == (10 - DOOR_CELLS, 10 - DOOR_CELLS)
    rng = np.random.default_rng(0)
    assert {row.choose_start(12, before=True, after=True, rng=rng) for _ in range(30)} == {-7}
    assert {row.choose_start(26, before=False, after=False, rng=rng) for _ in range(30)} == {0}
    assert {row.choose_start(26, before=True, after=True, rng=rng) for _ in range(30)} == {-7, 0, 7}


@pytest.mark.parametrize("seed", range(8))
def test_sides_are_about_equally_long_or_have_rooms_of_about_one_size(seed):
    areas = {room: 4.0 if room < 8 else 36.0 for room in range(12)}
    paths = [[room] for room in areas]
    sides = divide_paths(paths, lambda room: areas[room] ** 0.5, areas.__getitem__, np.random.default_rng(seed))
    lengths = [sum(areas[room] ** 0.5 for (room,) in side) for side in sides]
    assert sorted(room for side in sides for (room,) in side) == list(areas)
    assert abs(lengths[0] - lengths[1]) <= 8.0


def test_large_rooms_may_have_a_side_of_their_own():
    areas = {room: 9.0 if room < 6 else 36.0 for room in range(9)}

    def divide(seed: int) -> set[frozenset[int]]:
        rng = np.random.default_rng(seed)
        sides = divide_paths([[room] for room in areas], lambda room: areas[room] ** 0.5, areas.__getitem__, rng)
        return {frozenset(room for (room,) in side) for side in sides}

    similar = {frozenset(range(6)), frozenset(range(6, 9))}
    assert 5 < sum(divide(seed) == similar for seed in range(20)) < 16


def test_losses_by_facade_and_by_elongation():
    cells = read_cells("0000", "1111", "1111", "1111", "1111")
    assert measure_facade(cells) == pytest.approx(LOSS_BY_FACADE * 18 / 20**0.5)
    assert measure_elongation(cells, frozenset({0})) == pytest.approx(LOSS_BY_ELONGATION * 4)
    assert measure_elongation(cells, frozenset({0, 1})) == pytest.approx(LOSS_BY_ELONGATION * 2.5)
    assert measure_elongation(cells, frozenset()) == 0.0
