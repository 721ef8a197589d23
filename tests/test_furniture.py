"""Furniture in maps: what stands in a room and is no wall; small maps with answers by hand."""

from dataclasses import replace

import numpy as np
import pytest
from shapely import LineString, Polygon, box, contains_xy, unary_union

import pianta
from pianta.errors import OptionError
from pianta.floor import Floor, Room
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout.furniture import find_furniture, sort_contents
from tests.drawn_maps import Rectangle, carve

# A room of 5 × 4 m within walls, cells of 0.05 m: rows 10 to 90, columns 10 to 110.
SHAPE = (100, 120)
INSIDE: Rectangle = (10, 90, 10, 110)
ROOM = Room(1, box(0.5, 0.5, 5.5, 4.5))
TABLE: Rectangle = (40, 52, 40, 60)
SHELF: Rectangle = (10, 18, 30, 54)
STUB: Rectangle = (70, 90, 80, 82)


def draw_map(*occupied: Rectangle, unknown: tuple[Rectangle, ...] = (), resolution: float = 0.05) -> GridMap:
    cells = np.where(carve(SHAPE, INSIDE), FREE, OCCUPIED)
    cells[carve(SHAPE, *occupied)] = OCCUPIED
    cells[carve(SHAPE, *unknown)] = UNKNOWN
    return GridMap(cells, resolution)


def in_metres(rectangle: Rectangle) -> Polygon:
    top, bottom, left, right = (side * 0.05 for side in rectangle)
    return box(left, 5 - bottom, right, 5 - top)


def is_same(one: Polygon, other: Polygon) -> bool:
    return bool(one.symmetric_difference(other).area < 1e-9)


def find_areas(grid: GridMap, floor: Floor | None = None) -> list[float]:
    """Areas of the pieces in cells of 0.05 m."""
    pieces = find_furniture(grid, floor or Floor((ROOM,)))
    return [round(piece.polygon.area / 0.05**2, 6) for piece in pieces]


class TestByRules:
    def test_an_empty_room_has_none(self):
        assert find_furniture(draw_map(), Floor((ROOM,))) == ()

    def test_a_floor_without_rooms_has_none(self):
        assert find_furniture(draw_map(TABLE), Floor(())) == ()

    def test_a_table_is_the_polygon_of_its_cells(self):
        (piece,) = find_furniture(draw_map(TABLE), Floor((ROOM,)))
        assert is_same(piece.polygon, in_metres(TABLE))
        assert piece.probability is None

    def test_it_has_the_position_of_the_map(self):
        """The map is turned by 90° and moved; the room with it: x' = 1 - y, y' = 2 + x."""
        grid = replace(draw_map(TABLE), origin=(1.0, 2.0, np.pi / 2))
        turned = Polygon([(1 - y, 2 + x) for x, y in ROOM.polygon.exterior.coords])
        (piece,) = find_furniture(grid, Floor((replace(ROOM, polygon=turned),)))
        expected = Polygon([(1 - y, 2 + x) for x, y in in_metres(TABLE).exterior.coords])
        assert is_same(piece.polygon, expected)

    def test_a_group_that_touches_by_corners_is_one_piece(self):
        squares: list[Rectangle] = [(40, 42, 40, 42), (42, 44, 42, 44)]
        (piece,) = find_furniture(draw_map(*squares), Floor((ROOM,)))
        assert all(piece.polygon.covers(in_metres(square).buffer(-0.01)) for square in squares)
        # 8 cells, one that joins them, and at most one that is rounded off.
        assert piece.polygon.area <= 10 * 0.05**2 + 1e-9

    def test_a_speck_is_spray_and_two_cells_are_furniture(self):
        assert find_areas(draw_map((40, 41, 40, 41))) == []
        assert find_areas(draw_map((40, 41, 40, 42))) == [2]

    def test_small_cells_need_an_area(self):
        """Cells of 0.01 m: 2 × 12 are 0.0024 m², 5 × 12 are 0.006 m²."""
        floor = Floor((Room(1, box(0.1, 0.1, 1.1, 0.9)),))
        cells = draw_map((30, 32, 30, 42), (50, 55, 50, 62), resolution=0.01)
        (piece,) = find_furniture(cells, floor)
        assert piece.polygon.area == pytest.approx(0.006)

    def test_a_shelf_at_a_wall_is_furniture_beyond_the_tolerance_of_the_outline(self):
        """8 cells deep and 24 long; of each column the three cells at the wall may be a part of the wall."""
        assert find_areas(draw_map(SHELF)) == [5 * 24]

    def test_a_shelf_is_furniture_whose_inside_was_not_seen(self):
        top, _, left, right = SHELF
        grid = draw_map(SHELF, unknown=((top, 17, left + 1, right - 1),))
        assert find_areas(grid) == [5 * 24]

    def test_a_stub_of_a_wall_is_none(self):
        assert find_areas(draw_map(STUB)) == []

    def test_a_rough_wall_is_none(self):
        """Bumps of 3 cells are within the tolerance."""
        assert find_areas(draw_map(*((10, 13, left, left + 2) for left in range(20, 100, 7)))) == []

    def test_unknown_cells_alone_are_a_shadow(self):
        grid = draw_map(unknown=(TABLE,))
        assert find_areas(grid) == []
        assert np.array_equal(sort_contents(grid, Floor((ROOM,))).shadows, carve(SHAPE, TABLE))

    def test_a_box_whose_inside_was_not_seen_is_furniture(self):
        assert find_areas(draw_map(TABLE, unknown=((41, 51, 41, 59),))) == [12 * 20]

    def test_a_thin_piece_on_the_line_of_a_wall_is_wall(self):
        """A piece of wall of 1.5 m, with gaps of doors on both sides."""
        grid = draw_map((48, 50, 30, 60))
        wall = LineString([(0.5, 2.55), (5.5, 2.55)])
        assert find_areas(grid, Floor((ROOM,))) == [2 * 30]
        assert find_areas(grid, Floor((ROOM,), walls=(wall,))) == []
        beside = LineString([(0.5, 3.5), (5.5, 3.5)])
        assert find_areas(grid, Floor((ROOM,), walls=(beside,))) == [2 * 30]

    def test_a_short_or_thick_piece_on_the_line_of_a_wall_is_furniture(self):
        floor = Floor((ROOM,), walls=(LineString([(0.5, 2.55), (5.5, 2.55)]),))
        assert find_areas(draw_map((48, 50, 30, 45)), floor) == [2 * 15]
        assert find_areas(draw_map((45, 53, 30, 60)), floor) == [8 * 30]

    def test_an_island_that_the_room_leaves_out_is_furniture(self):
        hole = in_metres(TABLE)
        floor = Floor((replace(ROOM, polygon=ROOM.polygon - hole),))
        assert find_areas(draw_map(TABLE), floor) == [12 * 20]

    def test_a_large_island_and_one_between_two_rooms_are_the_building(self):
        """A shaft of 3 × 3 m = 9 m²."""
        shaft = (20, 80, 30, 90)
        floor = Floor((replace(ROOM, polygon=ROOM.polygon - in_metres(shaft)),))
        assert find_areas(draw_map(shaft), floor) == []
        left, right = box(0.5, 0.5, 2.5, 4.5) - in_metres(TABLE), box(2.5, 0.5, 5.5, 4.5) - in_metres(TABLE)
        assert find_areas(draw_map(TABLE), Floor((Room(1, left), Room(2, right)))) == []

    def test_what_is_outside_of_the_rooms_is_none(self):
        assert find_areas(draw_map(TABLE), Floor((replace(ROOM, polygon=box(3.5, 0.5, 5.5, 4.5)),))) == []


class TestByProbability:
    def test_cells_above_one_half_are_furniture_wherever_they_stand(self):
        probability = np.zeros(SHAPE)
        probability[carve(SHAPE, TABLE)] = 0.09
        probability[carve(SHAPE, STUB)] = 0.9
        probability[70:90, 80] = 0.7
        (piece,) = find_furniture(draw_map(TABLE, STUB), Floor((ROOM,)), probability=probability)
        assert is_same(piece.polygon, in_metres(STUB))
        assert piece.probability == pytest.approx(0.8)

    def test_what_the_rules_find_stays_if_it_is_not_improbable(self):
        probability = np.zeros(SHAPE)
        probability[carve(SHAPE, TABLE)] = 0.11
        (piece,) = find_furniture(draw_map(TABLE), Floor((ROOM,)), probability=probability)
        assert is_same(piece.polygon, in_metres(TABLE))
        assert piece.probability == pytest.approx(0.11)

    def test_free_cells_walls_outside_and_specks_are_none(self):
        assert find_furniture(draw_map((40, 41, 40, 41)), Floor((ROOM,)), probability=np.ones(SHAPE)) == ()

    def test_the_shape_is_that_of_the_map(self):
        with pytest.raises(OptionError, match=r"shape \(3, 4\), give \(100, 120\)"):
            find_furniture(draw_map(), Floor((ROOM,)), probability=np.ones((3, 4)))


class TestReconstruction:
    def test_the_furniture_of_a_world_is_found(self):
        """Without noise all pieces of a furnished world, and nothing in an empty one."""
        _, empty = pianta.make_world("corridor")
        _, grid = pianta.make_world("corridor", furniture=0.7)
        assert pianta.reconstruct(empty).furniture == ()
        floor = pianta.reconstruct(grid)
        furniture = unary_union([piece.polygon for piece in floor.furniture])
        added = grid.occupied & empty.free
        rows, cols = np.nonzero(added)
        x, y = grid.pixel_to_map(rows + 0.5, cols + 0.5)
        share = contains_xy(furniture.buffer(0.16), x, y).mean()
        assert share > 0.8

    def test_rooms_keep_the_floor_under_it(self):
        floor = pianta.reconstruct(draw_map(TABLE, (10, 20, 10, 30)))
        assert len(floor) == 1
        (room,) = floor
        assert room.polygon.intersection(in_metres(TABLE)).area == pytest.approx(in_metres(TABLE).area)
        assert len(floor.furniture) == 2

    def test_the_methods_of_others_find_none(self):
        assert pianta.reconstruct(draw_map(TABLE), method="distance").furniture == ()
