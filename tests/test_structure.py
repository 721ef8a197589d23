"""The method `structure` from end to end: from a grid map to rooms and doors."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
import shapely

from pianta.errors import MapError
from pianta.evaluation.coverage import forward_coverage, score_layout
from pianta.floor import Door, Floor
from pianta.gridmap import FREE, UNKNOWN, GridMap
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.reconstruct import reconstruct_structure
from pianta.worlds.floors import FLOOR_MAKERS, make_floor, make_hall_floor
from pianta.worlds.scan import simulate_map
from tests.drawn_maps import carve, make_grid

# Two rooms above a corridor, one cell of 5 cm, and a door of 0.9 m and one of 1 m to the corridor.
LEFT, RIGHT, CORRIDOR = (10, 90, 10, 90), (10, 90, 93, 190), (93, 133, 10, 190)
SUITE = carve((143, 200), LEFT, RIGHT, CORRIDOR, (90, 93, 40, 58), (90, 93, 130, 150))

CLEAN = {"noise": 0.0, "furniture": 0.0}
NOISY = {"noise": 0.2, "furniture": 0.0}
FURNISHED = {"noise": 0.3, "furniture": 0.3}
CONDITIONS = {"clean": CLEAN, "noisy": NOISY, "furnished": FURNISHED}


class World(NamedTuple):
    """A true floor, a map of it, and the floor reconstructed from it."""

    truth: Floor
    grid: GridMap
    reconstructed: Floor


def run_structure(grid: GridMap) -> Floor:
    return reconstruct_structure(grid, parameters=StructureParameters())


@cache
def survey_worlds(condition: str, *, glass_spray: bool = False) -> list[World]:
    """Two worlds of each name in FLOOR_MAKERS."""
    worlds = []
    for name in FLOOR_MAKERS:
        for seed in (10, 11):
            truth = make_floor(name, seed=seed)
            level = CONDITIONS[condition]
            grid = simulate_map(
                truth, noise=level["noise"], furniture=level["furniture"], glass_spray=glass_spray, seed=seed
            )
            worlds.append(World(truth, grid, run_structure(grid)))
    return worlds


def polygons_of(floor: Floor):
    return np.array([room.polygon for room in floor.rooms])


def match_doors(world: World):
    """The true doors of each pair of true rooms, and the reconstructed doors between the rooms that overlap them."""
    indices = forward_coverage(list(polygons_of(world.reconstructed)), list(polygons_of(world.truth)))
    true_id = {
        room.id: 0 if index is None else world.truth.rooms[index].id
        for room, index in zip(world.reconstructed.rooms, indices, strict=True)
    }
    true: dict[frozenset[int], list[Door]] = {}
    reconstructed: dict[frozenset[int], list[Door]] = {}
    for door in world.truth.doors:
        true.setdefault(frozenset(door.room_ids), []).append(door)
    for door in world.reconstructed.doors:
        reconstructed.setdefault(frozenset(true_id[room] for room in door.room_ids), []).append(door)
    return true, reconstructed


def check_rooms(grid: GridMap, floor: Floor, *, reach: float = 0.15):
    """Rooms are valid, disjoint polygons that share edges; each free cell is in a room, or at most `reach` away."""
    rooms = polygons_of(floor)
    assert all(room.geom_type == "Polygon" and room.is_valid and room.area > 0 for room in rooms)
    one, other = shapely.STRtree(rooms).query(rooms, predicate="intersects")
    assert shapely.area(shapely.intersection(rooms[one], rooms[other]))[one != other].max(initial=0) < 1e-6
    assert shapely.coverage_is_valid(rooms)
    # Queries on prepared rooms one by one take a tenth of the time of a query on a tree of rooms.
    shapely.prepare(rooms)
    xy = np.column_stack(grid.pixel_to_map(*(np.argwhere(grid.free).T + 0.5)))
    times = sum(shapely.contains_xy(room, xy).astype(int) for room in rooms)
    assert times.max() == 1
    outside = shapely.points(xy[times == 0])
    assert np.any([shapely.dwithin(room, outside, reach) for room in rooms], axis=0).all()


@pytest.mark.slow
@pytest.mark.parametrize("condition", ["clean", "noisy"])
def test_worlds_without_furniture_have_the_true_rooms_and_doors(condition):
    for world in survey_worlds(condition):
        assert len(world.reconstructed.rooms) == len(world.truth.rooms), world.truth.source
        scores = score_layout(list(polygons_of(world.reconstructed)), list(polygons_of(world.truth)))
        assert scores.mean_iou > 0.95
        true, reconstructed = match_doors(world)
        assert {pair: len(doors) for pair, doors in reconstructed.items()} == {
            pair: len(doors) for pair, doors in true.items()
        }


@pytest.mark.slow
def test_furnished_worlds_keep_their_rooms_and_doors_and_gain_few():
    # A row of cupboards sometimes divides a room: one room more in every second or third building.
    for world in survey_worlds("furnished"):
        assert 0 <= len(world.reconstructed.rooms) - len(world.truth.rooms) <= 1, world.truth.source
        true, reconstructed = match_doors(world)
        assert true.keys() <= reconstructed.keys()
    right = [len(world.reconstructed.rooms) == len(world.truth.rooms) for world in survey_worlds("furnished")]
    assert np.mean(right) >= 0.5


@pytest.mark.slow
@pytest.mark.parametrize("condition", CONDITIONS)
def test_rooms_of_worlds_cover_the_free_space_once(condition):
    for world in survey_worlds(condition):
        check_rooms(world.grid, world.reconstructed, reach=0.25 if condition == "furnished" else 0.15)


@pytest.mark.slow
@pytest.mark.parametrize("condition", CONDITIONS)
def test_no_room_of_a_complete_map_is_partial(condition):
    assert not any(room.partial for world in survey_worlds(condition) for room in world.reconstructed.rooms)


@pytest.mark.slow
@pytest.mark.parametrize("condition", CONDITIONS)
def test_doors_lie_between_their_two_rooms(condition):
    for world in survey_worlds(condition):
        rooms = {room.id: room.polygon for room in world.reconstructed.rooms}
        for door in world.reconstructed.doors:
            assert all(door.line.distance(rooms[room]) < 0.3 for room in door.room_ids)


@pytest.mark.slow
@pytest.mark.parametrize("condition", CONDITIONS)
def test_doors_are_as_wide_as_the_true_ones(condition):
    for world in survey_worlds(condition):
        true, reconstructed = match_doors(world)
        for pair in true.keys() & reconstructed.keys():
            for door in reconstructed[pair]:
                nearest = min(true[pair], key=lambda one: one.line.distance(door.line))
                assert door.line.distance(nearest.line) < 0.3
                assert door.width == pytest.approx(nearest.width, abs=0.1)
                assert door.kind == "door"


@pytest.mark.slow
def test_rays_through_glass_are_no_room():
    for world in survey_worlds("clean", glass_spray=True):
        assert len(world.reconstructed.rooms) == len(world.truth.rooms), world.truth.source
        assert sum(room.partial for room in world.reconstructed.rooms) <= 1
        check_rooms_near_the_building(world)


def check_rooms_near_the_building(world: World):
    """The rooms extend no further than rays make them, and they cover the building."""
    building = shapely.union_all(polygons_of(world.truth))
    rooms = shapely.union_all(polygons_of(world.reconstructed))
    assert shapely.coverage_is_valid(polygons_of(world.reconstructed))
    assert rooms.intersection(building).area > 0.99 * building.area


@pytest.mark.slow
def test_rooms_with_ray_leaks_and_furniture_are_valid():
    # A room of these worlds once had an outline that touched itself, and its polygon was lost in the map frame.
    for world in survey_worlds("furnished", glass_spray=True):
        rooms = polygons_of(world.reconstructed)
        assert shapely.coverage_is_valid(rooms)
        assert shapely.area(rooms).min() > 1.0


def test_the_method_by_its_name_is_the_default():
    from pianta.layout.reconstruct import reconstruct

    grid = make_grid(SUITE)
    assert reconstruct(grid) == reconstruct(grid, method="structure") == run_structure(grid)


def test_a_suite_has_its_three_rooms_and_two_doors():
    floor = run_structure(make_grid(SUITE))
    assert [door.rooms for door in floor.doors] == [(1, 3), (2, 3)]
    assert [door.width for door in floor.doors] == pytest.approx([0.9, 1.0], abs=0.01)
    # 80 by 80, 80 by 97 and 40 by 180 cells; the doors, 3 by 18 and 3 by 20 cells, may belong to either side.
    areas, doors = shapely.area(polygons_of(floor)), 0.135 + 0.15
    assert areas.sum() == pytest.approx(16.0 + 19.4 + 18.0 + doors)
    assert (areas - [16.0, 19.4, 18.0] > -1e-6).all()


@pytest.mark.parametrize(
    ("width", "door_kind"), [(0.8, "door"), (1.5, "door"), (1.9, "door"), (2.1, "opening"), (3.0, "opening")]
)
def test_passages_wider_than_a_door_are_openings(width, door_kind):
    half = round(width / 0.05 / 2)
    free = carve((143, 260), (10, 133, 10, 90), (10, 133, 93, 250), (70 - half, 70 + half, 90, 93))
    floor = run_structure(make_grid(free))
    assert [(door.rooms, door.kind) for door in floor.doors] == [((1, 2), door_kind)]
    assert floor.doors[0].width == pytest.approx(2 * half * 0.05, abs=0.02)


# Unexplored parts, as rows and columns of the suite, and the rooms that end there.
HIDDEN = {
    "right end of the right room": ((0, 90, 160, 200), [2]),
    "left end of all": ((0, 143, 0, 50), [1, 3]),
    "top of both rooms": ((0, 40, 0, 200), [1, 2]),
    "right end of the corridor": ((94, 143, 170, 200), [3]),
}


@pytest.mark.parametrize("name", HIDDEN)
def test_rooms_cut_off_by_unknown_space_are_partial(name):
    (top, bottom, left, right), partial = HIDDEN[name]
    cells = make_grid(SUITE).cells.copy()
    cells[top:bottom, left:right] = UNKNOWN
    grid = GridMap(cells, 0.05)
    floor = run_structure(grid)
    assert [room.id for room in floor.rooms if room.partial] == partial
    assert len(floor.rooms) == 3
    check_rooms(grid, floor)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.5, 0.7])
def test_half_a_building_has_partial_rooms_at_its_end_alone(share):
    complete = simulate_map(make_floor("corridor", seed=10))
    cells = complete.cells.copy()
    cut = int(share * cells.shape[1])
    cells[:, cut:] = UNKNOWN
    floor = run_structure(GridMap(cells, complete.resolution, complete.origin))
    end = complete.pixel_to_map(np.array([0.0]), np.array([float(cut)]))[0].item()
    at_end = [room.polygon.bounds[2] > end - 0.1 for room in floor.rooms]
    assert [room.partial for room in floor.rooms] == at_end
    assert 2 <= sum(at_end) <= 3


def test_the_same_building_in_fine_cells_has_the_same_rooms():
    floor, fine = (
        run_structure(make_grid(SUITE)),
        run_structure(make_grid(SUITE.repeat(5, 0).repeat(5, 1), resolution=0.01)),
    )
    areas, fine_areas = shapely.area(polygons_of(floor)), shapely.area(polygons_of(fine))
    assert fine_areas == pytest.approx(areas, abs=1e-6)
    assert [door.width for door in fine.doors] == pytest.approx([door.width for door in floor.doors])


@pytest.mark.slow
def test_a_floor_at_one_centimetre_a_cell_has_the_true_rooms():
    truth = make_floor("hall", seed=11)
    floor = run_structure(simulate_map(truth, resolution=0.01))
    assert len(floor.rooms) == len(truth.rooms)
    assert len(floor.doors) == len(truth.doors)


def test_cells_of_half_a_metre_show_rooms_and_doors():
    # Two rooms of 4 m above a corridor of 1 m. The doors are one cell wide, and far enough from corners and from each
    # other that the wall between them, one cell thick, is too long for furniture.
    free = carve((13, 42), (1, 9, 1, 20), (1, 9, 21, 41), (10, 12, 1, 41), (9, 10, 10, 11), (9, 10, 30, 31))
    grid = make_grid(free, resolution=0.5)
    floor = run_structure(grid)
    assert [door.rooms for door in floor.doors] == [(1, 3), (2, 3)]
    assert [door.width for door in floor.doors] == pytest.approx([0.5, 0.5], abs=0.1)
    assert shapely.area(polygons_of(floor)) == pytest.approx([38.0, 40.0, 20.0], abs=0.51)
    check_rooms(grid, floor)


@pytest.mark.slow
@pytest.mark.parametrize("size", [20, 80, 600])
def test_a_building_of_one_room_is_one_room(size):
    grid = make_grid(carve((size + 20, 2 * size + 20), (10, size + 10, 10, 2 * size + 10)))
    floor = run_structure(grid)
    assert [room.polygon.area for room in floor.rooms] == pytest.approx([2 * size**2 * 0.05**2])
    assert floor.doors == ()
    assert not floor.rooms[0].partial


@pytest.mark.slow
def test_five_hundred_rooms_are_five_hundred_rooms():
    # Rooms of 2.25 m at half the usual resolution, with a door of 0.7 m to each neighbour.
    unit = carve((24, 24), (0, 22, 0, 22), (22, 24, 8, 15), (8, 15, 22, 24))
    free = np.tile(unit, (20, 25))
    free[-2:], free[:, -2:] = False, False
    floor = run_structure(make_grid(np.pad(free, 4), resolution=0.1))
    assert len(floor.rooms) == 500
    # 20 rows with 24 doors between columns, and 19 times 25 between rows.
    assert len(floor.doors) == 20 * 24 + 19 * 25
    assert {len(set(door.rooms)) for door in floor.doors} == {2}
    assert shapely.coverage_is_valid(polygons_of(floor))


@pytest.mark.slow
@pytest.mark.parametrize("pitch", [None, 100])
def test_an_enormous_hall_with_or_without_pillars_is_one_room(pitch):
    free = carve((620, 1020), (10, 610, 10, 1010))
    for row in range(110, 600, 100) if pitch else ():
        for col in range(110, 1000, 100):
            free[row : row + 8, col : col + 8] = False
    floor = run_structure(make_grid(free))
    assert [room.polygon.area for room in floor.rooms] == pytest.approx([50 * 30])


def test_tables_of_which_the_edges_are_seen_are_no_rooms_and_divide_no_hall():
    """A hall of 9 × 8 m; five tables of 1.5 × 1.2 m, two of them against a wall and two a metre from one."""
    free = carve((180, 200), (10, 170, 10, 190))
    for row, col in ((22, 11), (80, 11), (28, 90), (90, 90), (120, 148)):
        free[row - 1 : row + 25, col - 1 : col + 31] = False
        free[row : row + 24, col : col + 30] = True
    floor = run_structure(make_grid(free))
    assert len(floor.rooms) == 1
    assert floor.doors == ()


def test_a_hall_with_pillars_has_its_rooms_around_it():
    truth = make_hall_floor(seed=12, pillars=True)
    floor = run_structure(simulate_map(truth))
    assert len(floor.rooms) == len(truth.rooms)
    assert len(floor.doors) == len(truth.doors)


def draw_maze(rows: int, cols: int, *, width: int, wall: int):
    """Free cells of a maze without loops, all corridors of one width; cells."""
    rng, pitch = np.random.default_rng(0), width + wall
    free = np.zeros((rows * pitch + wall, cols * pitch + wall), bool)
    path, visited = [(0, 0)], {(0, 0)}
    while path:
        row, col = path[-1]
        steps = [(row + 1, col), (row - 1, col), (row, col + 1), (row, col - 1)]
        steps = [(r, c) for r, c in steps if 0 <= r < rows and 0 <= c < cols and (r, c) not in visited]
        if not steps:
            path.pop()
            continue
        path.append(steps[rng.integers(len(steps))])
        visited.add(path[-1])
        top, bottom = sorted((row, path[-1][0]))
        left, right = sorted((col, path[-1][1]))
        free[wall + top * pitch : (bottom + 1) * pitch, wall + left * pitch : (right + 1) * pitch] = True
    return np.pad(free, 5)


@pytest.mark.slow
def test_rooms_of_a_maze_cover_it_and_are_connected():
    grid = make_grid(draw_maze(9, 12, width=30, wall=3))
    floor = run_structure(grid)
    check_rooms(grid, floor)
    # The number of rooms of a maze is undefined; but the maze, and so its rooms, are connected and have no loops.
    assert len(floor.doors) == len(floor.rooms) - 1
    assert not any(room.partial for room in floor.rooms)


@pytest.mark.slow
def test_two_buildings_in_one_map_have_the_rooms_of_both():
    first, second = (simulate_map(make_floor(name, seed=10)) for name in ("corridor", "hall"))
    width = max(first.shape[1], second.shape[1] + 20)
    cells = np.full((first.shape[0] + second.shape[0] + 40, width), UNKNOWN, np.int8)
    cells[: first.shape[0], : first.shape[1]] = first.cells
    cells[-second.shape[0] :, 20 : 20 + second.shape[1]] = second.cells
    both, alone = run_structure(GridMap(cells, 0.05)), [run_structure(first), run_structure(second)]
    areas = np.sort(shapely.area(polygons_of(both)))
    assert areas == pytest.approx(np.sort(np.concatenate([shapely.area(polygons_of(floor)) for floor in alone])), 0.01)
    assert len(both.doors) == sum(len(floor.doors) for floor in alone)
    assert not any(room.partial for room in both.rooms)


def test_a_map_of_free_cells_only_is_refused():
    with pytest.raises(MapError, match="free"):
        run_structure(GridMap(np.full((60, 80), FREE), 0.05))
