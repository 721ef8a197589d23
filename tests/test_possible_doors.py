"""Doors that may be there but are shut: walls and probabilities that are drawn by hand."""

import numpy as np
import pytest
from shapely import LineString, get_coordinates

from pianta._types import LabelImage, Mask
from pianta.floor import Door
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout._working_grid import WorkingGrid
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure import reconstruct as structure
from pianta.layout.structure.evidence import Probabilities
from pianta.layout.structure.possible_doors import find_possible_doors, find_sides, fit_leaf
from pianta.layout.structure.reconstruct import reconstruct_structure
from pianta.worlds.floors import make_floor
from pianta.worlds.scan import list_shut_doors, simulate_map
from tests.drawn_maps import Rectangle, carve

# Two rooms of 2 m with a wall of 0.2 m between them, and a leaf of 0.9 m that fills its whole depth; cells of 0.05 m.
SHAPE = (60, 90)
ONE, OTHER = (10, 50, 4, 40), (10, 50, 44, 84)
WALL: Rectangle = (10, 50, 40, 44)
LEAF: Rectangle = (20, 38, 40, 44)
# From (60 - 20) to (60 - 38) cells above the lower edge, in the middle of the wall.
LINE = [(2.1, 2.0), (2.1, 1.1)]


def draw_rooms(one: Rectangle = ONE, other: Rectangle = OTHER) -> LabelImage:
    labels = np.zeros(SHAPE, np.int32)
    labels[carve(SHAPE, one)] = 1
    labels[carve(SHAPE, other)] = 2
    return labels


def draw_probability(*leaves: Rectangle, value: float = 0.8) -> Probabilities:
    return np.where(carve(SHAPE, *leaves), value, 0.1).astype(np.float32)


def draw_grid(rooms: LabelImage, *, unseen: Mask | None = None, origin=(0.0, 0.0, 0.0)) -> WorkingGrid:
    """The rooms are free, and the cells that were not seen are unknown; all others are obstacles."""
    cells = np.where(rooms > 0, FREE, OCCUPIED)
    if unseen is not None:
        cells[unseen] = UNKNOWN
    return WorkingGrid(rooms > 0, 0.05, np.eye(3), GridMap(cells, 0.05, origin))


def find(
    *leaves: Rectangle,
    value: float = 0.8,
    rooms: LabelImage | None = None,
    occupied: Rectangle = WALL,
    doors: tuple[Door, ...] = (),
) -> list[Door]:
    rooms = draw_rooms() if rooms is None else rooms
    probability = draw_probability(*leaves, value=value)
    return find_possible_doors(probability, rooms, carve(SHAPE, occupied), doors, draw_grid(rooms))


def test_a_leaf_in_a_wall_is_a_possible_door_from_jamb_to_jamb():
    (door,) = find(LEAF)
    assert door.rooms == (1, 2)
    assert door.kind == "door"
    assert door.width == pytest.approx(0.9)
    assert door.probability == pytest.approx(0.8)
    assert sorted(get_coordinates(door.line).tolist()) == pytest.approx(np.array(sorted(map(list, LINE))))


def test_the_line_is_in_the_map_frame():
    rooms = draw_rooms()
    grid = draw_grid(rooms, origin=(10.0, -5.0, np.pi / 2))
    (door,) = find_possible_doors(draw_probability(LEAF), rooms, carve(SHAPE, WALL), (), grid)
    expected = sorted([10.0 - y, -5.0 + x] for x, y in LINE)
    assert sorted(get_coordinates(door.line).tolist()) == pytest.approx(np.array(expected))


def test_its_probability_is_the_mean_of_its_cells():
    probability = draw_probability(LEAF, value=0.9)
    probability[carve(SHAPE, (20, 29, 40, 44))] = 0.6
    (door,) = find_possible_doors(probability, draw_rooms(), carve(SHAPE, WALL), (), draw_grid(draw_rooms()))
    assert door.probability == pytest.approx(0.75)


@pytest.mark.parametrize(("value", "count"), [(0.5, 0), (0.59, 0), (0.61, 1)])
def test_what_is_hardly_likely_is_none(value, count):
    assert len(find(LEAF, value=value)) == count


@pytest.mark.parametrize(("cells", "count"), [(11, 0), (12, 1), (26, 1), (27, 0)])
def test_a_door_is_0_6_to_1_3_m_wide(cells, count):
    assert len(find((20, 20 + cells, 40, 44))) == count


def test_two_leaves_are_two_doors():
    first, second = (12, 26, 40, 44), (30, 48, 40, 44)
    assert sorted(door.width for door in find(first, second)) == pytest.approx([0.7, 0.9])


def test_a_square_has_no_direction():
    """14 × 12 cells in a wall of 0.6 m: 1.17 times as long as thick; with 10 cells 1.4 times."""
    rooms = draw_rooms(other=(10, 50, 52, 84))
    assert find((20, 34, 40, 52), rooms=rooms, occupied=(10, 50, 40, 52)) == []
    rooms = draw_rooms(other=(10, 50, 50, 84))
    assert len(find((20, 34, 40, 50), rooms=rooms, occupied=(10, 50, 40, 50))) == 1


def test_where_one_can_go_through_is_no_shut_door():
    rooms = draw_rooms()
    rooms[carve(SHAPE, (25, 30, 40, 44))] = 1
    assert find(LEAF, rooms=rooms) == []


def test_one_room_on_both_sides_has_none():
    rooms = draw_rooms()
    rooms[rooms == 2] = 1
    assert find(LEAF, rooms=rooms) == []


@pytest.mark.parametrize(("start", "count"), [(52, 1), (53, 0)])
def test_a_room_is_at_most_0_4_m_from_the_leaf(start, count):
    """The leaf ends before column 44: 8 and 9 cells."""
    assert len(find(LEAF, rooms=draw_rooms(other=(10, 50, start, 84)))) == count


@pytest.mark.parametrize(("bottom", "count"), [(35, 1), (29, 0)])
def test_obstacles_stand_along_most_of_the_leaf(bottom, count):
    """Of the nine positions at rows 21.3 … 35.7, the last is at an obstacle or not, or only the first half is."""
    assert len(find(LEAF, occupied=(10, bottom, 40, 44))) == count


@pytest.mark.parametrize(("rooms", "gap", "count"), [((1, 2), 0.4, 0), ((1, 2), 0.6, 1), ((1, None), 0.4, 1)])
def test_another_door_of_its_rooms_is_not_near(rooms, gap, count):
    other = Door(rooms, LineString([(2.1, 1.1 - gap), (2.1, 0.1)]), 0.5)
    assert len(find(LEAF, doors=(other,))) == count


class TestToTheUnseen:
    @pytest.mark.parametrize(("value", "count"), [(0.7, 0), (0.8, 1)])
    def test_strong_evidence_leads_out_of_a_room(self, value, count):
        rooms = np.where(draw_rooms() == 1, 1, 0).astype(np.int32)
        grid = draw_grid(rooms, unseen=carve(SHAPE, (0, 60, 44, 90)))
        doors = find_possible_doors(draw_probability(LEAF, value=value), rooms, carve(SHAPE, WALL), (), grid)
        assert [door.rooms for door in doors] == [(1, None)] * count

    def test_free_cells_that_are_no_room_were_seen(self):
        rooms = np.where(draw_rooms() == 1, 1, 0).astype(np.int32)
        assert find_possible_doors(draw_probability(LEAF), rooms, carve(SHAPE, WALL), (), draw_grid(draw_rooms())) == []

    def test_no_room_on_either_side(self):
        rooms = np.zeros(SHAPE, np.int32)
        grid = draw_grid(rooms, unseen=~carve(SHAPE, WALL))
        assert find_possible_doors(draw_probability(LEAF), rooms, carve(SHAPE, WALL), (), grid) == []


def test_a_leaf_is_along_its_cells():
    """Five cells on a diagonal: their middles are 4 √2 apart, and half a cell is added at each end."""
    leaf = fit_leaf(np.array([(i, i) for i in range(3, 8)]), np.ones(5))
    half = 0.5 / np.sqrt(2)
    assert np.sort(leaf.ends, axis=0) == pytest.approx(np.array([[3 - half] * 2, [7 + half] * 2]))
    assert leaf.thickness == pytest.approx(1)


def test_the_sides_of_a_leaf_are_the_rooms_of_most_positions():
    """Room 2 is beside 12 of the 18 rows, room 3 beside the others."""
    rooms = draw_rooms()
    rooms[32:50, 44:84] = 3
    leaf = fit_leaf(np.argwhere(carve(SHAPE, LEAF)), np.ones(18 * 4))
    assert set(find_sides(leaf, rooms, rooms < 0, reach=10)) == {1, 2}


def test_the_rooms_of_possible_doors_have_the_ids_of_the_floor(monkeypatch):
    """The possible doors here are the doors that were found, before the rooms get their ids."""
    monkeypatch.setattr(
        structure, "find_possible_doors", lambda probability, rooms, occupied, doors, grid, thresholds: doors
    )
    grid = simulate_map(make_floor("corridor", seed=3), seed=3)
    floor = reconstruct_structure(grid, parameters=StructureParameters())
    assert len(floor.doors) > 5
    assert floor.possible_doors == floor.doors


def test_the_shut_doors_of_a_simulated_map_are_known():
    floor = make_floor("office", seed=103)
    shut = list_shut_doors(floor, seed=103)
    grid = simulate_map(floor, seed=103, door_leaves=True)
    blocked = []
    for index, door in enumerate(floor.doors):
        row, col = (np.floor(at).astype(int) for at in grid.map_to_pixel(*door.line.centroid.coords[0]))
        if not grid.free[row, col]:
            blocked.append(index)
    assert len(shut) > 3
    assert blocked == shut
