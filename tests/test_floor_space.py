"""Which cells of a map are floor, rule by rule, for evidence that is made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from pianta._types import Mask
from pianta.gridmap import UNKNOWN, GridMap
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.evidence import CELL, Probabilities
from pianta.layout.structure.space import find_floor_space
from tests.drawn_evidence import make_classes, make_evidence, set_class
from tests.drawn_maps import carve, make_working_grid

# A room of 20 × 30 cells of 0.1 m, with 10 cells around it.
SHAPE = (40, 50)
ROOM = carve(SHAPE, (10, 30, 10, 40))
NOTHING = np.zeros(SHAPE, bool)


def find(
    free: Mask, classes: Probabilities, *, occupied: Mask | None = None, unknown: Mask | None = None
) -> tuple[Mask, Mask]:
    """The floor and the seen floor of a map without occupied and unknown cells, unless they are given."""
    working_grid = make_working_grid(free, resolution=CELL)
    if unknown is not None:
        cells = np.where(unknown, UNKNOWN, working_grid.grid.cells)
        working_grid = replace(working_grid, grid=GridMap(cells, CELL))
    occupied = np.zeros(free.shape, bool) if occupied is None else occupied
    return find_floor_space(working_grid, occupied, make_evidence(classes), StructureParameters())


def make_wall_classes() -> Probabilities:
    """Floor in ROOM and wall around it."""
    classes = make_classes(SHAPE)
    set_class(classes, ~ROOM, wall=1.0)
    return classes


def test_a_room_with_walls_around_it():
    space, seen_space = find(ROOM, make_wall_classes(), occupied=~ROOM)
    assert np.array_equal(space, ROOM)
    assert np.array_equal(seen_space, ROOM)


class TestSmallGroups:
    """A table of 4 × 6 cells in the room is a small group: its diagonal of 0.72 m is less than 1.5 m."""

    TABLE = carve(SHAPE, (18, 22, 20, 26))

    @pytest.mark.parametrize(("wall", "is_floor"), [(0.48, True), (0.52, False)])
    def test_it_is_floor_unless_the_network_sees_wall(self, wall, is_floor):
        classes = make_wall_classes()
        set_class(classes, self.TABLE, wall=wall, door=1 - wall)
        space, seen_space = find(ROOM & ~self.TABLE, classes, occupied=~ROOM | self.TABLE)
        assert np.array_equal(space, ROOM if is_floor else ROOM & ~self.TABLE)
        assert np.array_equal(seen_space, space)

    @pytest.mark.parametrize(("columns", "is_floor"), [(3, False), (2, True)])
    def test_the_mean_of_its_cells_counts(self, columns, is_floor):
        """3 of 6 columns are surely wall: a mean of 0.5; with 2 it is a third."""
        classes = make_wall_classes()
        set_class(classes, self.TABLE, door=1.0)
        set_class(classes, carve(SHAPE, (18, 22, 20, 20 + columns)), wall=1.0)
        space, _ = find(ROOM & ~self.TABLE, classes, occupied=~ROOM | self.TABLE)
        assert space[20, 25] == space[20, 20] == is_floor

    @pytest.mark.parametrize(("length", "is_floor"), [(14, True), (15, False)])
    def test_a_group_that_is_long_is_no_small_group(self, length, is_floor):
        """With 4 rows, the diagonal of 14 columns is 14.6 cells, and that of 15 columns is 15.5 cells."""
        table = carve(SHAPE, (18, 22, 20, 20 + length))
        classes = make_wall_classes()
        set_class(classes, table, door=1.0)
        space, _ = find(ROOM & ~table, classes, occupied=~ROOM | table)
        assert space[20, 25] == is_floor

    def test_one_at_the_edge_of_the_map_goes_on_beyond_it(self):
        """The group in rows 0 to 3 is 4 × 6 cells, but beyond the map there are more that are not free."""
        group = carve(SHAPE, (0, 4, 20, 26))
        classes = make_classes(SHAPE)
        set_class(classes, group, door=1.0)
        space, _ = find(~group, classes, occupied=group)
        assert not space[group].any()
        assert np.array_equal(space[1:-1, 1:-1], ~group[1:-1, 1:-1])

    def test_what_is_around_a_tiny_map_is_no_furniture(self):
        """The map is 8 cells wide, and all around the 5 × 5 free cells it goes on."""
        free = carve((8, 8), (2, 7, 2, 7))
        classes = make_classes(free.shape)
        set_class(classes, ~free, door=1.0)
        assert np.array_equal(find(free, classes)[0], free)


class TestLargeGroups:
    """All around the room is one large group of cells."""

    @pytest.mark.parametrize(("floor", "furniture"), [(0.7, 0.0), (0.4, 0.3)])
    def test_unseen_floor_reaches_0_6_m(self, floor, furniture):
        """6 cells around the room in rows and columns are floor that was not seen."""
        classes = make_classes(SHAPE)
        set_class(classes, ~ROOM, floor=floor, furniture=furniture, wall=1 - floor - furniture)
        space, seen_space = find(ROOM, classes)
        assert np.array_equal(space, carve(SHAPE, (4, 36, 4, 46)))
        assert np.array_equal(seen_space, ROOM)

    def test_what_is_probably_no_floor_is_none(self):
        classes = make_classes(SHAPE)
        set_class(classes, ~ROOM, floor=0.6, wall=0.4)
        assert np.array_equal(find(ROOM, classes)[0], ROOM)

    @pytest.mark.parametrize(("furniture", "is_floor"), [(0.25, False), (0.35, True)])
    def test_obstacles_are_floor_only_where_they_may_be_furniture(self, furniture, is_floor):
        """A row of cupboards, 5 cells deep and as long as the room, which is surely floor or furniture."""
        cupboards = carve(SHAPE, (10, 15, 10, 40))
        classes = make_wall_classes()
        set_class(classes, cupboards, furniture=furniture, floor=1 - furniture)
        space, seen_space = find(ROOM & ~cupboards, classes, occupied=~ROOM | cupboards)
        assert np.array_equal(space, ROOM if is_floor else ROOM & ~cupboards)
        assert np.array_equal(seen_space, ROOM & ~cupboards)

    @pytest.mark.parametrize(("rows", "is_floor"), [(4, False), (5, True)])
    def test_a_thin_row_of_obstacles_is_a_wall(self, rows, is_floor):
        """The network takes it for furniture; a wall of 0.2 m would have a hole then."""
        wall = carve(SHAPE, (10, 10 + rows, 10, 40))
        classes = make_wall_classes()
        set_class(classes, wall, furniture=1.0)
        space, _ = find(ROOM & ~wall, classes, occupied=~ROOM | wall)
        assert space[12, 25] == is_floor

    @pytest.mark.parametrize(("columns", "is_floor"), [(3, True), (4, False)])
    def test_furniture_whose_back_was_not_seen_is_no_floor(self, columns, is_floor):
        """Unknown cells behind a shelf touch one more of its cells than they are: 0.4 m for 3, and 0.5 m for 4."""
        shelf = carve(SHAPE, (5, 10, 10, 38))
        classes = make_wall_classes()
        set_class(classes, shelf, furniture=1.0)
        behind = carve(SHAPE, (4, 5, 10, 10 + columns))
        space, _ = find(ROOM, classes, occupied=~ROOM & ~behind, unknown=behind)
        assert np.array_equal(space, ROOM | shelf if is_floor else ROOM)

    @pytest.mark.parametrize(("top", "is_floor"), [(6, False), (4, True)])
    def test_a_large_group_is_floor_between_sparse_rays(self, top, is_floor):
        """4 × 30 cells are 1.2 m², and 6 × 30 are 1.8 m², which is more than a piece of furniture."""
        group = carve(SHAPE, (top, 10, 10, 40))
        classes = make_wall_classes()
        set_class(classes, group, floor=1.0)
        space, seen_space = find(ROOM, classes, unknown=~ROOM)
        assert np.array_equal(space, ROOM | group if is_floor else ROOM)
        assert np.array_equal(seen_space, ROOM)


class TestFreeCells:
    @pytest.mark.parametrize(("outside", "is_floor"), [(0.85, False), (0.75, True)])
    def test_rays_that_left_the_building_are_no_floor(self, outside, is_floor):
        rays = carve(SHAPE, (15, 25, 40, 49))
        classes = make_wall_classes()
        set_class(classes, rays, outside=outside, wall=1 - outside)
        space, seen_space = find(ROOM | rays, classes, occupied=~(ROOM | rays))
        assert np.array_equal(space, ROOM | rays if is_floor else ROOM)
        assert np.array_equal(seen_space, space)

    def test_free_cells_are_floor_even_if_they_look_like_a_wall(self):
        classes = make_classes(SHAPE)
        set_class(classes, ~NOTHING, wall=1.0)
        assert np.array_equal(find(ROOM, classes)[0], ROOM)

    def test_the_outermost_cells_are_no_floor(self):
        free = ~NOTHING
        space, seen_space = find(free, make_classes(SHAPE))
        assert np.array_equal(space, carve(SHAPE, (1, 39, 1, 49)))
        assert np.array_equal(seen_space, space)

    @pytest.mark.parametrize(("rows", "is_floor"), [(5, True), (4, False)])
    def test_a_patch_below_a_quarter_of_a_square_metre_is_no_floor(self, rows, is_floor):
        """5 × 5 cells are 0.25 m², 4 × 5 cells are 0.2 m²."""
        patch = carve(SHAPE, (2, 2 + rows, 2, 7))
        space, _ = find(ROOM | patch, make_wall_classes(), occupied=~(ROOM | patch))
        assert np.array_equal(space, ROOM | patch if is_floor else ROOM)
