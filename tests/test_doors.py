import numpy as np
import pytest
from shapely import get_coordinates

from pianta.layout._voronoi_doors import compute_clearance, draw_voronoi_diagram, find_doors
from pianta.layout._working_grid import to_working_grid
from pianta.layout.parameters import ThesisParameters
from tests.drawn_maps import carve, make_grid, make_working_grid

DEFAULT = ThesisParameters()
CELL = 0.05
SHAPE = (120, 203)
# Two rooms of 5 m by 4 m, and 3 cells of wall between them.
LEFT, RIGHT = (20, 100, 0, 100), (20, 100, 103, 203)


def build_rooms(*gaps: tuple[int, int]):
    """Free space of the two rooms and of gaps (top, bottom) in their wall; and the owner of each cell."""
    shape = (SHAPE[0], SHAPE[1] + 20)
    moved = [(top, bottom, left + 10, right + 10) for top, bottom, left, right in (LEFT, RIGHT)]
    free = carve(shape, *moved, *[(top, bottom, 110, 113) for top, bottom in gaps])
    owner = np.full(shape, -1)
    # The representative line runs along the middle of the wall.
    owner[20:100, 10:111], owner[20:100, 111:213] = 0, 1
    return free, owner


def find_drawn_doors(*gaps: tuple[int, int], parameters=DEFAULT):
    free, owner = build_rooms(*gaps)
    return find_doors(make_working_grid(free), owner, parameters)


@pytest.mark.parametrize("width", [8, 12, 16, 17, 18, 20, 25, 39])
@pytest.mark.parametrize("top", [30, 57])
def test_one_gap_in_the_wall_is_one_door_of_its_width(top, width):
    (door,) = find_drawn_doors((top, top + width))
    assert door.rooms == (1, 2)
    assert door.kind == "door"
    assert door.width == pytest.approx(width * CELL, abs=CELL)
    assert door.line.length == pytest.approx(door.width)
    (x0, y0), (x1, y1) = get_coordinates(door.line)
    # The map's y points up; the wall is at columns 110 to 113.
    assert (x0 + x1) / 2 == pytest.approx(111.5 * CELL, abs=2 * CELL)
    assert sorted([y0, y1]) == pytest.approx([(120 - top - width) * CELL, (120 - top) * CELL], abs=CELL)


def test_two_gaps_are_two_doors():
    doors = find_drawn_doors((25, 43), (70, 86))
    assert [door.rooms for door in doors] == [(1, 2), (1, 2)]
    assert sorted(door.width for door in doors) == pytest.approx([16 * CELL, 18 * CELL], abs=CELL)


def test_a_gap_wider_than_a_door_is_an_opening():
    (opening,) = find_drawn_doors((40, 84))
    assert (opening.kind, opening.rooms) == ("opening", (1, 2))
    assert opening.width == pytest.approx(44 * CELL, abs=CELL)
    (door,) = find_drawn_doors((40, 84), parameters=ThesisParameters(door_width=2.5))
    assert door.kind == "door"


@pytest.mark.parametrize("gaps", [(), ((50, 54),)])
def test_no_door_where_the_wall_is_closed_or_its_gap_leads_nowhere(gaps):
    assert find_drawn_doors(*gaps) == []


def test_the_narrowest_passage_is_a_parameter():
    (door,) = find_drawn_doors((50, 54), parameters=ThesisParameters(passage_width=0.1))
    assert door.width == pytest.approx(0.2, abs=CELL)


def test_a_line_beside_the_wall_gives_the_same_door():
    free, owner = build_rooms((50, 68))
    expected = find_doors(make_working_grid(free), owner, DEFAULT)
    for shift in (-8, 8):
        shifted = np.where(owner >= 0, (np.arange(owner.shape[1]) >= 111 + shift).astype(int), -1)
        (door,) = find_doors(make_working_grid(free), shifted, DEFAULT)
        assert door.rooms == (1, 2)
        assert door.width == pytest.approx(expected[0].width, abs=CELL)
        assert door.line.distance(expected[0].line) < 0.1


def test_a_line_beside_a_closed_wall_gives_no_door():
    # The strip of the right room beyond the wall belongs to the left room; a cupboard narrows the way out of it.
    free, _ = build_rooms()
    free &= ~carve(free.shape, (20, 50, 118, 130), (68, 100, 118, 130))
    owner = np.where(np.arange(free.shape[1]) < 124, 0, 1) * np.ones((len(free), 1), int)
    assert find_doors(make_working_grid(free), owner, DEFAULT) == []


def test_a_passage_that_a_ragged_line_crosses_repeatedly_is_one_door():
    free, owner = build_rooms((50, 68))
    owner[:, 104:118] = np.arange(14) // 2 % 2
    (door,) = find_doors(make_working_grid(free), owner, DEFAULT)
    assert door.width == pytest.approx(18 * CELL, abs=CELL)


def test_rooms_that_meet_at_a_corner_have_no_door():
    free = carve((120, 120), (10, 58, 10, 58), (10, 58, 61, 110), (61, 110, 10, 58), (61, 110, 61, 110))
    # The room at the top left has a door to its right and one below; the others have none.
    free |= carve(free.shape, (25, 43, 58, 61), (58, 61, 25, 43))
    owner = np.full(free.shape, 0)
    owner[:, 59:] += 1
    owner[59:] += 2
    doors = find_doors(make_working_grid(free), owner, DEFAULT)
    assert sorted(door.rooms for door in doors) == [(1, 2), (1, 3)]


def test_doors_lie_in_the_map_frame():
    free, _ = build_rooms((50, 68))
    grid = make_grid(free, yaw=0.3)
    canvas = to_working_grid(grid, free, resolution=CELL)
    # The canvas is the map upside down or mirrored or both, or neither; the wall is in its middle in any case.
    owner = np.broadcast_to(np.arange(canvas.free.shape[1]) >= canvas.free.shape[1] / 2, canvas.free.shape).astype(int)
    (door,) = find_doors(canvas, owner, DEFAULT)
    middle = door.line.interpolate(0.5, normalized=True)
    assert np.ravel(grid.map_to_pixel(middle.x, middle.y)) == pytest.approx([59, 111.5], abs=2)


def test_clearance_is_the_distance_to_the_nearest_obstacle():
    clearance = compute_clearance(carve((7, 20), (1, 6, 1, 19)))
    assert clearance[3, 8:12].tolist() == [3, 3, 3, 3]
    assert clearance[0].tolist() == [0] * 20
    assert clearance[2, 2] == 2


def test_voronoi_diagram_of_a_corridor_is_its_middle():
    diagram = draw_voronoi_diagram(carve((11, 40), (1, 10, 1, 39)))
    assert diagram[:, 10:30].sum(axis=0).tolist() == [1] * 20
    assert diagram[5, 10:30].all()


def test_clearance_is_the_exact_root_at_every_memory_address():
    free = np.ones((301, 407), bool)
    free[150, 200] = False
    rows, cols = np.ogrid[:301, :407]
    exact = np.sqrt((rows - 150.0) ** 2 + (cols - 200.0) ** 2).astype(np.float32)
    for shift in range(4):
        window = np.s_[:, shift : 400 + shift]
        assert (compute_clearance(free[window]) == exact[window]).all()
