import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta._types import Floats, Mask
from pianta.layout._voronoi_doors import compute_clearance
from pianta.layout.structure.merging import (
    find_active_separators,
    initial_rooms,
    join_rooms,
    merge_regions,
    read_default_merge_model,
)
from pianta.layout.structure.regions import Regions, Separators, cut_into_regions, find_separators
from tests.drawn_maps import carve

MODEL = read_default_merge_model()

SHAPE = (120, 200)
# Four rooms of 4.5 m beside each other, walls of 20 cm between them: a door, open over all of it, a door.
SPACE = carve(SHAPE, (10, 100, 4, 48), (60, 78, 48, 52), (10, 100, 52, 144), (60, 78, 144, 148), (10, 100, 148, 196))
DOORS = [[[59, 50], [78, 50]], [[59, 146], [78, 146]]]
OPEN = [[[9, 98], [100, 98]]]


def cut(space: Mask, lines: Floats) -> tuple[Regions, Separators]:
    regions = cut_into_regions(space, compute_clearance(space), lines, min_clearance=3.0, resolution=0.05)
    return regions, find_separators(regions, space, lines, reach=3.0)


def merge(space: Mask, lines: Floats) -> set[frozenset[tuple[int, int]]]:
    """Rooms, as sets of cells on a coarse raster."""
    regions, separators = cut(space, lines)
    rooms, _, _ = merge_regions(regions, separators, MODEL)
    owner = rooms.owner[regions.labels]
    cells = [(row, col) for row in range(2, SHAPE[0], 6) for col in range(2, SHAPE[1], 6) if space[row, col]]
    return {frozenset(cell for cell in cells if owner[cell] == room) for room in {owner[cell] for cell in cells}}


def test_halves_of_an_open_room_merge_and_rooms_with_a_door_do_not():
    regions, separators = cut(SPACE, np.array(DOORS + OPEN, float))
    west, left, right, east = regions.labels[30, [20, 70, 120, 180]]
    assert len({west, left, right, east}) == 4
    rooms, active, log_odds = merge_regions(regions, separators, MODEL)
    assert rooms.owner[left] == rooms.owner[right]
    assert len({rooms.owner[west], rooms.owner[left], rooms.owner[east]}) == 3
    assert separators.lines[active].tolist() == DOORS
    assert log_odds.shape == (2,)
    assert (log_odds < 0).all()


def test_a_merged_room_has_the_area_and_the_width_of_its_parts():
    regions, separators = cut(SPACE, np.array(DOORS + OPEN, float))
    left, right = regions.labels[30, [70, 120]]
    rooms, _, _ = merge_regions(regions, separators, MODEL)
    room = rooms.owner[left]
    assert room == min(left, right)
    assert rooms.area[room] == pytest.approx(regions.area[left] + regions.area[right])
    assert rooms.width[room] == max(regions.width[left], regions.width[right])
    hull = rooms.hulls[room].reshape(-1, 2)
    assert (
        hull.min(axis=0).tolist() == np.min([regions.hulls[i].min(axis=(0, 1)) for i in (left, right)], axis=0).tolist()
    )
    assert (
        hull.max(axis=0).tolist() == np.max([regions.hulls[i].max(axis=(0, 1)) for i in (left, right)], axis=0).tolist()
    )


def test_joining_pairs_keeps_the_total_area_and_numbers_rooms_by_the_smaller():
    regions, _ = cut(SPACE, np.array(DOORS + OPEN, float))
    joined = join_rooms(initial_rooms(regions), np.array([[4, 2], [1, 3]]))
    assert joined.owner.tolist() == [0, 1, 2, 1, 2]
    assert joined.area[[1, 2]].sum() == pytest.approx(regions.area.sum())
    again = join_rooms(joined, np.array([[2, 1]]))
    assert again.owner.tolist() == [0, 1, 1, 1, 1]
    assert again.area[1] == pytest.approx(regions.area.sum())
    # The initial rooms are not changed.
    assert initial_rooms(regions).owner.tolist() == [0, 1, 2, 3, 4]
    assert joined.area[1] < again.area[1]


def test_separators_within_a_room_are_not_active():
    regions, separators = cut(SPACE, np.array(DOORS + OPEN, float))
    rooms = initial_rooms(regions)
    assert find_active_separators(rooms, separators).tolist() == [0, 1, 2]
    joined = join_rooms(rooms, separators.sides[[2]])
    assert find_active_separators(joined, separators).tolist() == [0, 1]


def test_without_separators_every_region_is_a_room():
    regions, separators = cut(carve(SHAPE, (10, 50, 10, 50), (60, 100, 10, 50)), np.zeros((0, 2, 2)))
    rooms, active, log_odds = merge_regions(regions, separators, MODEL)
    assert rooms.owner.tolist() == [0, 1, 2]
    assert (len(active), len(log_odds)) == (0, 0)


openings = st.lists(st.integers(8, 90), min_size=3, max_size=3)


@pytest.mark.slow
@given(openings, st.permutations(range(3)), st.lists(st.booleans(), min_size=3, max_size=3))
def test_rooms_do_not_depend_on_the_order_or_direction_of_separators(heights, order, turned):
    walls = [48, 96, 144]
    gaps = [(100 - height, 100, col, col + 4) for height, col in zip(heights, walls, strict=True)]
    spans = [(10, 100, 4, 48), (10, 100, 52, 96), (10, 100, 100, 144), (10, 100, 148, 196)]
    space = carve(SHAPE, *spans, *gaps)
    lines = np.array(
        [[[100 - height - 1, col + 2], [100, col + 2]] for height, col in zip(heights, walls, strict=True)]
    )
    shuffled = np.array([line[::-1] if turn else line for line, turn in zip(lines, turned, strict=True)])[list(order)]
    assert merge(space, lines.astype(float)) == merge(space, shuffled.astype(float))
