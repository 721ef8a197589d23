"""Gaps narrower than doors: their lines, and the gaps that a floor needs as doors."""

from itertools import permutations

import networkx as nx
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString

from pianta._types import Floats, LabelImage, Mask
from pianta.floor import Door, Floor
from pianta.gridmap import GridMap
from pianta.layout._voronoi_doors import compute_clearance
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure import reconstruct as structure
from pianta.layout.structure.narrow_passages import choose_narrow_doors, find_narrow_passages, find_wall_gaps
from pianta.layout.structure.reconstruct import reconstruct_structure
from pianta.layout.structure.regions import Regions
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta.worlds.scan import simulate_map
from tests.drawn_maps import Rectangle, carve, make_grid

MAX_WIDTH = 7.0
# Two rooms side by side with two columns of wall between them, and their labels.
ONE, OTHER = (5, 45, 5, 30), (5, 45, 32, 60)


def draw_rooms(*gaps: Rectangle, rooms: tuple[Rectangle, ...] = (ONE, OTHER)) -> tuple[Mask, LabelImage]:
    """Space of rooms and gaps, and labels: rooms in their order, gaps with the label of the first room."""
    labels = np.zeros((50, 65), np.int32)
    labels[carve((50, 65), *gaps)] = 1
    for number, room in enumerate(rooms, start=1):
        labels[carve((50, 65), room)] = number
    return labels > 0, labels


def find_gaps(space: Mask, labels: LabelImage) -> Floats:
    regions = Regions(labels, np.zeros(1), np.zeros(1), 0.05)
    return find_narrow_passages(regions, space, compute_clearance(space), max_width=MAX_WIDTH)


@pytest.mark.parametrize("width", [2, 3, 4, 6])
def test_the_line_of_a_gap_joins_the_cells_of_wall_beside_it(width):
    (line,) = find_gaps(*draw_rooms((20, 20 + width, 30, 32)))
    (top, left), (bottom, right) = sorted(map(tuple, line.tolist()))
    assert (top, bottom) == (19, 20 + width)
    assert left == right
    assert left in (30, 31)


def test_rooms_without_a_gap_and_with_a_door_have_no_line():
    assert find_gaps(*draw_rooms()).shape == (0, 2, 2)
    assert find_gaps(*draw_rooms((15, 33, 30, 32))).shape == (0, 2, 2)


def test_rooms_that_are_joined_have_no_line():
    space, labels = draw_rooms((20, 22, 30, 32))
    regions = Regions(labels, np.zeros(1), np.zeros(1), 0.05)
    for joined, count in (([(1, 2)], 0), ([(1, None), (1, 3)], 1)):
        assert (
            len(find_narrow_passages(regions, space, compute_clearance(space), max_width=MAX_WIDTH, joined=joined))
            == count
        )


def test_rooms_that_touch_by_a_corner_have_no_line():
    rooms = (5, 25, 5, 30), (25, 45, 30, 60)
    assert find_gaps(*draw_rooms(rooms=rooms)).shape == (0, 2, 2)


def test_the_widest_of_several_gaps_is_chosen():
    gaps = (10, 12, 30, 32), (20, 24, 30, 32), (35, 38, 30, 32)
    for order in permutations(gaps):
        (line,) = find_gaps(*draw_rooms(*order))
        assert sorted(line[:, 0].tolist()) == [19, 24]


def test_gaps_between_other_rooms_have_a_line_each():
    rooms = ONE, (5, 24, 32, 60), (26, 45, 32, 60)
    lines = find_gaps(*draw_rooms((10, 12, 30, 32), (40, 43, 30, 32), rooms=rooms))
    assert sorted(sorted(line[:, 0].tolist()) for line in lines) == [[9, 12], [39, 43]]


# Where the gap between room a and room b of map plans2 opens into a niche; b begins in the niche.
NICHE = """
aaaaaa........bbbbb
aaaaaa........bbbbb
aaaaaa........bbbbb
aaaaaa..aaab..bbbbb
aaaaaa..aaab..bbbbb
aaaaaaaaaaabbbbbbbb
aaaaaaaaaaabbbbbbbb
aaaaaaaaaaabbbbbbbb
aaaaaaaaaaabbbbbbbb
aaaaaaaaa..bbbbbbbb
aaaaaaaaa..bbbbbbbb
aaaaaaaaa..bbbbbbbb
aaaaaaaaa..bbbbbbbb
"""


def test_a_line_divides_rooms_that_meet_beside_the_narrowest_point():
    drawing = np.array([[" ab".find(cell) for cell in row.replace(".", " ")] for row in NICHE.split()], np.int32)
    labels = np.pad(np.pad(drawing, ((0, 0), (12, 12)), mode="edge"), 1)
    (line,) = find_gaps(labels > 0, labels)
    # The upper jamb is beside the niche, the lower one is the end of the wall below.
    (top, _), (bottom, col) = sorted(map(tuple, line.tolist()))
    assert (top, bottom) == (5, 10)
    assert col in (22, 23)


def test_labels_may_be_rotated_mirrored_and_renumbered():
    _, labels = draw_rooms((20, 22, 30, 32), (36, 39, 30, 32))
    for turns in range(4):
        for named in (labels, np.where(labels > 0, 3 - labels, 0).astype(np.int32)):
            turned = np.ascontiguousarray(np.rot90(named, turns))
            for image in (turned, np.ascontiguousarray(turned[:, ::-1])):
                (line,) = find_gaps(image > 0, image)
                assert np.hypot(*np.subtract(*line)) == 4


def make_door(one: int, other: int | None, width: float, at: float = 0.0) -> Door:
    return Door((one, other), LineString([(at, 0), (at, width)]), width)


def list_pairs(doors: list[Door]) -> list[tuple[int, int | None, float]]:
    return [(door.rooms[0], door.rooms[1], door.width) for door in doors]


def test_a_gap_is_a_door_if_nothing_else_leads_to_a_room():
    doors = [make_door(1, 2, 0.9), make_door(2, 3, 0.9)]
    narrow = [make_door(3, 4, 0.2), make_door(1, 3, 0.2), make_door(1, 2, 0.3)]
    assert list_pairs(choose_narrow_doors(doors, narrow, [1, 2, 3, 4])) == [(3, 4, 0.2)]


def test_the_widest_of_several_gaps_is_the_door():
    doors = [make_door(1, 2, 0.9)]
    narrow = [make_door(1, 3, 0.15), make_door(2, 3, 0.25), make_door(3, 4, 0.1), make_door(1, 4, 0.2)]
    assert list_pairs(choose_narrow_doors(doors, narrow, [1, 2, 3, 4])) == [(2, 3, 0.25), (1, 4, 0.2)]


def test_two_groups_of_rooms_are_joined_too():
    doors = [make_door(1, 2, 0.9), make_door(3, 4, 0.9)]
    narrow = [make_door(2, 3, 0.2), make_door(1, 4, 0.15)]
    assert list_pairs(choose_narrow_doors(doors, narrow, [1, 2, 3, 4])) == [(2, 3, 0.2)]


def test_gaps_half_as_wide_as_the_doors_are_doors():
    doors = [make_door(1, 2, 0.5), make_door(2, 3, 0.5), make_door(3, 4, 2.0)]
    narrow = [make_door(1, 3, 0.25), make_door(1, 4, 0.24)]
    assert list_pairs(choose_narrow_doors(doors, narrow, [1, 2, 3, 4])) == [(1, 3, 0.25)]


def test_where_there_is_no_door_gaps_join_each_room_once():
    narrow = [make_door(1, 2, 0.2), make_door(2, 3, 0.2), make_door(1, 3, 0.3)]
    assert list_pairs(choose_narrow_doors([], narrow, [1, 2, 3])) == [(1, 3, 0.3), (1, 2, 0.2)]
    assert choose_narrow_doors([], [], [1, 2]) == []


def test_gaps_out_of_a_room_are_no_entrances_and_entrances_reach_nothing():
    doors = [make_door(1, None, 0.9), make_door(2, None, 0.9)]
    narrow = [make_door(1, None, 0.2), make_door(3, None, 0.2), make_door(1, 2, 0.1)]
    assert list_pairs(choose_narrow_doors(doors, narrow, [1, 2, 3])) == [(1, 2, 0.1)]


def test_a_narrow_passage_beside_one_twice_as_wide_is_a_gap_in_the_wall():
    doors = [make_door(1, 2, 0.5), make_door(1, 2, 0.25), make_door(1, 2, 0.26), make_door(2, 3, 0.25)]
    assert list_pairs(find_wall_gaps(doors, max_width=0.3)) == [(1, 2, 0.25)]


def test_a_passage_of_less_than_a_quarter_of_the_usual_width_is_a_gap_in_the_wall():
    """The median is 1 m."""
    doors = [make_door(1, 2, 1.0), make_door(2, 3, 0.24), make_door(3, 4, 1.2), make_door(4, 5, 1.0)]
    assert list_pairs(find_wall_gaps([*doors, make_door(5, 6, 0.25)], max_width=0.3)) == [(2, 3, 0.24)]
    assert find_wall_gaps(doors, max_width=0.24) == []


def test_without_passages_there_is_no_gap():
    assert find_wall_gaps([], max_width=0.3) == []


def test_a_hole_in_a_wall_beside_a_door_is_no_door():
    """Two rooms of 4 × 4 m; a door of 1 m, and 1.5 m from it a hole of 0.2 m. Where the door is shut, it is one."""
    rooms = carve((100, 190), (10, 90, 10, 90), (10, 90, 94, 174))
    hole, door = carve((100, 190), (70, 74, 90, 94)), carve((100, 190), (20, 40, 90, 94))
    for free, widths in ((rooms | hole | door, [1.0]), (rooms | hole, [0.2])):
        floor = reconstruct_structure(make_grid(free), parameters=StructureParameters())
        assert len(floor.rooms) == 2
        assert [door.width for door in floor.doors] == pytest.approx(widths, abs=0.06)


def test_gaps_whose_widths_differ_by_rounding_keep_their_order():
    narrow = [make_door(1, 2, 0.3, at=5.0), make_door(1, 3, 0.3, at=1.0), make_door(2, 3, 0.1 + 0.2, at=-7.0)]
    assert list_pairs(choose_narrow_doors([], narrow, [1, 2, 3])) == [(1, 2, 0.3), (1, 3, 0.3)]


pairs = st.tuples(st.integers(1, 9), st.integers(1, 9)).filter(lambda pair: pair[0] != pair[1])


@given(wide=st.lists(pairs, max_size=8), narrow=st.lists(st.tuples(pairs, st.integers(2, 6)), max_size=20))
def test_all_rooms_with_gaps_are_reached_without_superfluous_gaps(wide, narrow):
    rooms, doors = range(1, 10), [make_door(pair[0], pair[1], 0.9) for pair in wide]
    gaps = [make_door(pair[0], pair[1], 0.05 * width) for pair, width in narrow]
    chosen = choose_narrow_doors(doors, gaps, rooms)
    by_doors = nx.Graph([door.rooms for door in doors])
    by_doors.add_nodes_from(rooms)
    with_all = nx.compose(by_doors, nx.Graph([door.rooms for door in gaps]))
    # All gaps are narrower than half of any door.
    bound = nx.number_connected_components(by_doors) - nx.number_connected_components(with_all)
    with_chosen = nx.compose(by_doors, nx.Graph([door.rooms for door in chosen]))
    assert nx.number_connected_components(with_chosen) == nx.number_connected_components(with_all)
    assert doors == [] or len(chosen) == bound


def run_structure(grid: GridMap) -> Floor:
    return reconstruct_structure(grid, parameters=StructureParameters())


def find_only_door(floor: Floor) -> Door:
    graph = floor.graph()
    return next(door for door in floor.doors if min(graph.degree(room) for room in door.room_ids) == 1)


def close_door(floor: Floor, grid: GridMap, left: float) -> GridMap:
    """The map with the only door of a room closed from both jambs, except a gap of `width` metres in its middle."""
    door = find_only_door(floor)
    (x0, y0), (x1, y1) = door.line.coords
    middle, length = np.array([x0 + x1, y0 + y1]) / 2, door.line.length
    along = np.array([x1 - x0, y1 - y0]) / length
    cells = grid.cells.copy()
    rows, cols = np.indices(grid.shape)
    xy = np.stack(grid.pixel_to_map(rows.ravel() + 0.5, cols.ravel() + 0.5), axis=1) - middle
    beside, away = xy @ along, xy @ np.array([-along[1], along[0]])
    closed = (np.abs(beside) > left / 2) & (np.abs(beside) < length / 2 + 0.05) & (np.abs(away) < 0.1)
    cells[closed.reshape(grid.shape)] = 100
    return GridMap(cells, grid.resolution, grid.origin)


@pytest.mark.slow
@pytest.mark.parametrize("name", FLOOR_MAKERS)
def test_a_room_whose_door_is_narrowed_to_20_cm_is_still_joined(name):
    truth = make_floor(name, seed=10)
    grid = simulate_map(truth)
    open_, narrowed, closed = (run_structure(close_door(truth, grid, left)) for left in (5.0, 0.2, 0.0))
    assert len(narrowed.rooms) == len(open_.rooms) == len(truth.rooms)
    assert narrowed.graph().edges == open_.graph().edges
    assert len(closed.graph().edges) == len(open_.graph().edges) - 1
    nearest = min(narrowed.doors, key=lambda door: door.line.distance(find_only_door(truth).line))
    assert nearest.width == pytest.approx(0.2, abs=0.051)
    assert shapely.distance(nearest.line, find_only_door(truth).line) < 0.1


@pytest.mark.slow
def test_rooms_are_the_same_without_the_gaps(monkeypatch):
    truth = make_floor("corridor", seed=10)
    grid = close_door(truth, simulate_map(truth), 0.1)
    with_gap = run_structure(grid)
    monkeypatch.setattr(structure, "choose_narrow_doors", lambda *_: [])
    without = run_structure(grid)
    assert without.rooms == with_gap.rooms
    assert len(without.doors) == len(with_gap.doors) - 1


def test_a_gap_into_a_ray_leak_is_no_door():
    """A ray that left through a gap of 0.2 m in the outer wall, into unknown space."""
    free = carve((140, 320), (40, 100, 10, 100), (40, 100, 103, 200), (65, 83, 100, 103), (60, 64, 200, 310))
    grid = make_grid(free)
    cells = grid.cells.copy()
    cells[:, 203:][~free[:, 203:]] = -1
    floor = run_structure(GridMap(cells, grid.resolution, grid.origin))
    assert [door.rooms for door in floor.doors if not door.is_entrance] == [(1, 2)]
    assert len(floor.rooms) == 2


@pytest.mark.parametrize(("resolution", "cells"), [(0.025, 8), (0.05, 4), (0.05, 2), (0.1, 2), (0.1, 1)])
def test_a_gap_is_found_in_cells_of_any_size(resolution, cells):
    free = carve((60, 83), (10, 50, 10, 40), (10, 50, 42, 72))
    scale = round(0.1 / resolution)
    free = free.repeat(scale, axis=0).repeat(scale, axis=1)
    free[30 * scale : 30 * scale + cells, 39 * scale : 43 * scale] = True
    (door,) = run_structure(make_grid(free, resolution=resolution)).doors
    assert (door.rooms, door.kind) == ((1, 2), "door")
    assert door.width == pytest.approx(cells * resolution)
