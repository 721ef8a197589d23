import networkx as nx
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import label
from shapely import LineString, box, unary_union

from pianta.errors import OptionError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.worlds.floors import FLOOR_MAKERS, build_floor, make_corridor_floor, make_floor, make_hall_floor
from pianta.worlds.scan import make_sample, simulate_map

names = st.sampled_from(sorted(FLOOR_MAKERS))

seeds = st.integers(0, 10_000)


@pytest.fixture(scope="module")
def tiny() -> Floor:
    """A corridor of 10 m by 2 m with two rooms of 5 m by 4 m on either side, between axes."""
    return make_corridor_floor(length=10, corridor_width=2, room_depth=4, room_width=(5, 5))


def cell_centres(grid: GridMap):
    rows, cols = np.indices(grid.shape) + 0.5
    return grid.pixel_to_map(rows, cols)


def find_free_border(grid: GridMap):
    """Cells that touch a free cell, by side or corner, and are not free."""
    padded = np.pad(grid.free, 1)
    height, width = grid.shape
    touching = np.any([padded[i : i + height, j : j + width] for i in range(3) for j in range(3)], axis=0)
    return touching & ~grid.free


def test_tiny_floor_has_the_areas_that_its_walls_leave(tiny):
    assert [room.label for room in tiny.rooms] == ["CORRIDOR", "ROOM", "ROOM", "ROOM", "ROOM"]
    assert [room.polygon.area for room in tiny.rooms] == pytest.approx([9.7 * 1.85] + 4 * [4.775 * 3.775])
    assert tiny.rooms[1].polygon.equals(box(0.15, -3.85, 4.925, -0.075))


def test_tiny_floor_has_a_door_on_the_wall_axis_for_each_room(tiny):
    assert [door.rooms for door in tiny.doors if 1 in door.rooms] == [(1, 2), (1, 3), (1, 4), (1, 5)]
    assert [set(shapely.get_coordinates(door.line)[:, 1]) for door in tiny.doors[:4]] == [{0}, {0}, {2}, {2}]


def test_tiny_floor_has_four_long_walls_and_cross_walls_cut_by_the_corridor(tiny):
    assert sorted(wall.length for wall in tiny.walls) == [4, 4, 10, 10, 10, 10, 10, 10]


def test_side_doors_join_all_neighbours_or_none():
    rooms = [box(0, 2, 4, 6), box(4, 2, 8, 6), box(8, 2, 12, 6)]
    pairs = [
        [door.rooms for door in build_floor(box(0, 0, 12, 2), rooms, side_doors=chance).doors] for chance in (0, 1)
    ]
    assert pairs == [[(1, 2), (1, 3), (1, 4)], [(1, 2), (1, 3), (1, 4), (2, 3), (3, 4)]]


def test_pillars_are_holes_of_the_hall():
    with_pillars, without = (make_hall_floor(pillars=pillars).rooms[0] for pillars in (True, False))
    assert with_pillars.label == "HALL"
    assert len(with_pillars.polygon.interiors) == 3
    assert without.polygon.area - with_pillars.polygon.area == pytest.approx(3 * 0.25)


def test_ring_corridor_has_a_hole():
    assert len(make_floor("ring", seed=1).rooms[0].polygon.interiors) == 1


@pytest.mark.slow
@given(names, seeds)
def test_every_floor_is_connected_with_walls_between_its_rooms(name, seed):
    floor = make_floor(name, seed=seed)
    assert floor.source == f"{name}-{seed}"
    assert nx.is_connected(floor.graph())
    polygons = [room.polygon for room in floor.rooms]
    near = shapely.STRtree(polygons).query(polygons, "dwithin", 0.149)
    assert (near[0] == near[1]).all()


@pytest.mark.slow
@given(names, seeds)
def test_every_door_is_in_the_middle_of_its_wall_clear_of_corners(name, seed):
    floor = make_floor(name, seed=seed)
    for door in floor.doors:
        assert 0.8 <= door.width <= 1.0
        assert door.line.length == pytest.approx(door.width)
        for room in floor.rooms:
            distance = door.line.distance(room.polygon)
            assert distance == pytest.approx(0.075) if room.id in door.rooms else distance > 0.5


@pytest.mark.slow
@given(seeds)
def test_rooms_have_at_least_the_given_width(seed):
    floor = make_corridor_floor(seed=seed, length=31.7, room_width=(3.5, 4.5))
    widths = [room.polygon.bounds[2] - room.polygon.bounds[0] for room in floor.rooms[1:]]
    assert min(widths) > 3.5 - 0.15 / 2 - 0.3 / 2 - 0.02


def test_floors_depend_only_on_the_seed():
    first, again, other = (make_floor("l", seed=seed) for seed in (1, 1, 2))
    assert [room.polygon for room in first.rooms] == [room.polygon for room in again.rooms]
    assert [door.line for door in first.doors] == [door.line for door in again.doors]
    assert [room.polygon for room in first.rooms] != [room.polygon for room in other.rooms]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: make_floor("castle", seed=0), "castle"),
        (lambda: make_corridor_floor(length=-1, room_depth=0), "length.*room_depth"),
        (lambda: make_corridor_floor(length=2), "wall"),
        (lambda: build_floor(box(0, 0, 9, 2), [box(0, 2, 1, 6), box(1, 2, 2, 6)]), r"\b2, 3\b"),
    ],
)
def test_impossible_floors_are_refused(make, message):
    with pytest.raises(OptionError, match=message):
        make()


@pytest.mark.slow
@pytest.mark.parametrize("name", FLOOR_MAKERS)
@pytest.mark.parametrize("yaw", [0.0, 0.3, -2.0])
def test_free_cells_of_a_clean_map_are_the_rooms_and_door_gaps(name, yaw):
    floor = make_floor(name, seed=4)
    grid = simulate_map(floor, resolution=0.1, margin=1.013, yaw=yaw)
    gaps = [door.line.buffer(0.076, cap_style="flat") for door in floor.doors]
    truth = unary_union([room.polygon for room in floor.rooms] + gaps)
    assert grid.origin[2] == yaw
    np.testing.assert_array_equal(grid.free, shapely.contains_xy(truth, *cell_centres(grid)))


@pytest.mark.slow
@given(names, seeds, st.floats(-3, 3), st.sampled_from([0.05, 0.1]))
@settings(max_examples=20)
def test_free_space_of_a_clean_map_is_connected_and_walled_in(name, seed, yaw, resolution):
    grid = simulate_map(make_floor(name, seed=seed), yaw=yaw, resolution=resolution)
    assert label(grid.free)[1] == 1
    beside_free = find_free_border(grid)
    assert grid.occupied[beside_free].all()


def test_margin_surrounds_the_outer_walls(tiny):
    grid = simulate_map(tiny, margin=0.5, wall_thickness=0.3, resolution=0.1)
    xmin, ymin, xmax, ymax = unary_union([room.polygon for room in tiny.rooms]).bounds
    assert grid.origin == pytest.approx((xmin - 0.8, ymin - 0.8, 0))
    assert grid.shape == (np.ceil((ymax - ymin + 1.6) * 10 - 1e-9), np.ceil((xmax - xmin + 1.6) * 10 - 1e-9))


def test_a_lidar_detects_faces_of_walls_and_a_plan_has_solid_walls(tiny):
    inside_inner_wall, inside_outer_wall = (5.0, 4.0), (0.0, 4.0)
    for solid, values in ((False, (-1, -1)), (True, (100, 100))):
        grid = simulate_map(tiny, resolution=0.02, solid_walls=solid, furniture=2)
        pixels = [grid.map_to_pixel(*point) for point in (inside_inner_wall, inside_outer_wall)]
        assert tuple(grid.cells[int(row), int(col)] for row, col in pixels) == values
        assert (label(grid.unknown)[1] == 1) == solid


@pytest.mark.slow
@given(names, seeds, st.sampled_from([1.0, 5.0]))
@settings(max_examples=20)
def test_furniture_keeps_all_free_space_connected_and_doors_clear(name, seed, density):
    floor = make_floor(name, seed=seed)
    empty = simulate_map(floor, resolution=0.1)
    full = simulate_map(floor, resolution=0.1, furniture=density, seed=seed)
    assert label(full.free)[1] == 1
    blocked = empty.free & ~full.free
    assert blocked.any()
    rooms = {room.id: room.polygon for room in floor.rooms}
    before_doors = unary_union(
        [door.line.buffer(0.9).intersection(rooms[room]) for door in floor.doors for room in door.room_ids]
    )
    assert not shapely.contains_xy(before_doors, *(coordinates[blocked] for coordinates in cell_centres(full))).any()


def test_corridors_stay_empty():
    floor = make_floor("corridor", seed=2)
    empty, full = simulate_map(floor), simulate_map(floor, furniture=3)
    assert not (empty.free & ~full.free & (floor.label_image(empty) == 1)).any()


@pytest.mark.slow
@pytest.mark.parametrize("name", FLOOR_MAKERS)
@pytest.mark.parametrize("seed", range(3))
def test_rays_leave_the_building_through_one_wall(name, seed):
    floor = make_floor(name, seed=seed)
    plain = simulate_map(floor, margin=6)
    with_rays = simulate_map(floor, margin=6, glass_spray=True, seed=seed)
    changed = plain.cells != with_rays.cells
    assert not (changed & (floor.label_image(plain) > 0)).any()
    building = unary_union([room.polygon for room in floor.rooms]).buffer(0.3, join_style="mitre")
    hull = shapely.Polygon(building.exterior)
    x, y = cell_centres(plain)
    far = ~shapely.contains_xy(hull.buffer(2), x, y)
    assert (with_rays.free & far).sum() > 50
    assert (with_rays.occupied & far).sum() > 5
    broken = plain.occupied & changed
    assert 0 < broken.sum() < 0.1 * plain.occupied.sum()


def test_the_default_margin_has_space_for_rays(tiny):
    assert simulate_map(tiny, glass_spray=True).shape == simulate_map(tiny, margin=6).shape


@pytest.mark.slow
def test_more_noise_moves_walls_more():
    floor = make_floor("ring", seed=3)
    clean = simulate_map(floor)
    overlaps = []
    for noise in (0.1, 0.5, 1.0):
        noisy = simulate_map(floor, noise=noise)
        overlaps.append((clean.free & noisy.free).sum() / (clean.free | noisy.free).sum())
    assert 1 > overlaps[0] > overlaps[1] > overlaps[2] > 0.93


def test_noise_leaves_every_room_reachable():
    floor = make_floor("l", seed=6)
    grid = simulate_map(floor, noise=1.0, furniture=1.0)
    parts, _ = label(grid.free)
    main = parts == np.bincount(parts[parts > 0]).argmax()
    rooms = floor.label_image(grid)
    for room in floor.rooms:
        assert (main & (rooms == room.id)).sum() > 0.8 * (rooms == room.id).sum()


@pytest.mark.parametrize("options", [{"noise": 0.5}, {"furniture": 1.0}, {"glass_spray": True}])
def test_maps_depend_only_on_the_seed(tiny, options):
    first, again, other = (simulate_map(tiny, seed=seed, **options).cells for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_furniture_and_noise_have_random_streams_of_their_own(tiny):
    plain, with_rays = (
        simulate_map(tiny, furniture=1, noise=0.5, margin=6, glass_spray=spray) for spray in (False, True)
    )
    inside = tiny.label_image(plain) == 1
    np.testing.assert_array_equal(plain.cells[inside], with_rays.cells[inside])


def test_faults_of_all_options_come_in_one_message():
    with pytest.raises(OptionError) as caught:
        simulate_map(Floor(rooms=()), resolution=0, margin=-1, wall_thickness=0, noise=2, furniture=-1, yaw=np.nan)
    for fault in (
        "rooms",
        "resolution",
        "margin",
        "wall_thickness",
        "noise",
        "furniture",
        "yaw",
    ):
        assert fault in str(caught.value)


def test_sample_is_a_connected_floor_and_always_the_same():
    floor, grid = make_sample()
    assert len(floor.rooms) == 20
    assert nx.is_connected(floor.graph())
    assert grid.resolution == 0.05
    np.testing.assert_array_equal(grid.cells, make_sample()[1].cells)


def test_an_entrance_is_a_gap_in_the_outer_wall():
    entrance = Door((1, None), LineString([(0, 1), (0, 2)]), 1.0)
    closed, open_ = (simulate_map(Floor((Room(1, box(0.1, 0, 4, 3)),), doors)) for doors in ((), (entrance,)))
    row, col = (int(point) for point in open_.map_to_pixel(0.075, 1.5))
    assert closed.occupied[row, col]
    assert open_.free[row, col]
