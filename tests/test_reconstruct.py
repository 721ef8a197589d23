import dataclasses
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings

from pianta.errors import MapError, OptionError
from pianta.evaluation.coverage import forward_coverage, score_layout
from pianta.floor import Floor
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout.parameters import ThesisParameters
from pianta.layout.reconstruct import METHODS, reconstruct
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta.worlds.scan import make_sample, simulate_map
from tests.drawn_maps import carve, make_grid
from tests.strategies import noise_maps

# Two rooms above a corridor, one cell of 5 cm, and a door from each to the corridor.
LEFT, RIGHT, CORRIDOR = (10, 90, 10, 90), (10, 90, 93, 190), (93, 133, 10, 190)
DOORS = (90, 93, 40, 58), (90, 93, 130, 150)
SUITE = carve((143, 200), LEFT, RIGHT, CORRIDOR, *DOORS)


@pytest.fixture(scope="module", params=["structure", "thesis"])
def method(request):
    """The methods of this project's own."""
    return request.param


@pytest.fixture(scope="module")
def worlds(method) -> list[tuple[Floor, Floor]]:
    """True floors of every name, and their reconstructions from clean maps."""
    floors = [make_floor(name, seed=seed) for name in FLOOR_MAKERS for seed in range(10, 13)]
    return [(floor, reconstruct(simulate_map(floor), method=method)) for floor in floors]


@pytest.fixture(scope="module")
def sample(method) -> tuple[GridMap, Floor]:
    """The sample's map and what is read from it."""
    grid = make_sample()[1]
    return grid, reconstruct(replace(grid, source="sample"), method=method)


def match_rooms(floor: Floor, truth: Floor):
    """Id of the true room that each room overlaps most."""
    polygons, true_polygons = ([room.polygon for room in side.rooms] for side in (floor, truth))
    predicted = forward_coverage(polygons, true_polygons)
    return {
        room.id: truth.rooms[index].id for room, index in zip(floor.rooms, predicted, strict=True) if index is not None
    }


def test_rooms_of_a_suite_are_found_in_place(method):
    floor = reconstruct(make_grid(SUITE), method=method)
    # Row 143 of the map is at y = -2, column 0 at x = 1.5; walls may be drawn anywhere within their 3 cells.
    expected = [(2.0, 0.65, 6.0, 4.65), (6.15, 0.65, 11.0, 4.65), (2.0, -1.5, 11.0, 0.5)]
    assert [room.id for room in floor.rooms] == [1, 2, 3]
    assert [room.polygon.bounds for room in floor.rooms] == [pytest.approx(bounds, abs=0.2) for bounds in expected]
    assert not any(room.partial for room in floor.rooms)


def test_doors_of_a_suite_join_the_rooms_to_the_corridor(method):
    floor = reconstruct(make_grid(SUITE), method=method)
    assert [door.rooms for door in floor.doors] == [(1, 3), (2, 3)]
    assert [door.width for door in floor.doors] == pytest.approx([0.9, 1.0], abs=0.05)
    assert [door.kind for door in floor.doors] == ["door", "door"]
    assert sorted(floor.graph().edges) == [(1, 3), (2, 3)]


def test_walls_of_a_suite_are_its_representative_lines():
    walls = reconstruct(make_grid(SUITE), method="thesis").walls
    upright = sorted(wall.centroid.x for wall in walls if np.ptp(wall.xy[0]) < 0.2)
    level = sorted(wall.centroid.y for wall in walls if np.ptp(wall.xy[1]) < 0.2)
    assert upright == pytest.approx([2.0, 6.075, 11.0], abs=0.15)
    assert level == pytest.approx([-1.5, 0.575, 4.65], abs=0.15)
    assert len(walls) == 6


@pytest.mark.slow
@pytest.mark.parametrize("yaw", [0.3, np.pi / 2, -2.0])
def test_rooms_turn_with_the_yaw_of_the_grid(yaw, method):
    level, turned = (reconstruct(make_grid(SUITE, yaw=angle), method=method) for angle in (0.0, yaw))
    for room, same in zip(level.rooms, turned.rooms, strict=True):
        expected = shapely.affinity.rotate(room.polygon, yaw, origin=(1.5, -2.0), use_radians=True)
        assert same.polygon.equals_exact(expected, 1e-6, normalize=True)
    for door, same_door in zip(level.doors, turned.doors, strict=True):
        expected = shapely.affinity.rotate(door.line, yaw, origin=(1.5, -2.0), use_radians=True)
        assert same_door.line.equals_exact(expected, 1e-6, normalize=True)


@pytest.mark.slow
def test_the_floor_carries_its_source(sample, method):
    assert sample[1].source == "sample"
    assert reconstruct(make_grid(SUITE), method=method).source == ""


def test_rooms_of_the_sample_are_a_coverage_of_free_space(sample):
    grid, floor = sample
    assert shapely.coverage_is_valid([room.polygon for room in floor.rooms])
    labels = floor.label_image(grid)
    assert (labels[grid.free] > 0).mean() > 0.95


def test_ids_follow_the_image_from_the_top_to_the_bottom(sample):
    grid, floor = sample
    corners = [np.column_stack(grid.map_to_pixel(*room.polygon.exterior.xy)).min(axis=0) for room in floor.rooms]
    assert [room.id for room in floor.rooms] == list(range(1, len(corners) + 1))
    rows = np.array(corners)[:, 0] * grid.resolution
    assert (np.diff(rows) > -1).all()


@pytest.mark.slow
def test_the_same_map_gives_the_same_floor(sample, method):
    grid, floor = sample
    again = GridMap(grid.cells.copy(), grid.resolution, grid.origin)
    assert reconstruct(replace(again, source="sample"), method=method) == floor


@pytest.mark.slow
def test_clean_worlds_have_the_true_number_of_rooms(worlds):
    # Parallel walls nearer than 0.9 m become one line (section 3.1), which sometimes divides a room beside it.
    right = [truth.source for truth, floor in worlds if len(floor.rooms) == len(truth.rooms)]
    assert len(right) >= 0.9 * len(worlds)


@pytest.mark.slow
def test_rooms_of_clean_worlds_have_the_true_shape(worlds):
    ious = [
        score_layout([room.polygon for room in floor.rooms], [room.polygon for room in truth.rooms]).mean_iou
        for truth, floor in worlds
    ]
    assert np.mean(ious) > 0.9


@pytest.mark.slow
def test_rooms_of_clean_worlds_are_valid_coverages(worlds):
    for _, floor in worlds:
        assert shapely.coverage_is_valid([room.polygon for room in floor.rooms])


@pytest.mark.slow
def test_the_graph_of_clean_worlds_is_the_true_graph(worlds):
    shares = []
    for truth, floor in worlds:
        true_id = match_rooms(floor, truth)
        predicted = {frozenset(true_id[room] for room in door.rooms) for door in floor.doors}
        true = {frozenset(door.rooms) for door in truth.doors}
        shares.append(2 * len(predicted & true) / (len(predicted) + len(true)))
    assert np.mean(shares) > 0.98
    assert min(shares) > 0.9


@pytest.mark.slow
def test_doors_of_clean_worlds_are_at_their_true_positions(worlds):
    for truth, floor in worlds:
        middles = shapely.line_interpolate_point([door.line for door in floor.doors], 0.5, normalized=True)
        true_id = match_rooms(floor, truth)
        joined = [frozenset(true_id[room] for room in door.rooms) for door in floor.doors]
        for door in truth.doors:
            if frozenset(door.rooms) not in joined:
                continue
            nearest = shapely.distance(
                middles, shapely.line_interpolate_point(door.line, 0.5, normalized=True)
            ).argmin()
            assert middles[nearest].distance(door.line) < 0.5
            assert floor.doors[nearest].width == pytest.approx(door.width, abs=0.1)


def test_a_room_behind_closed_doors_is_a_room(method):
    corridor = carve((220, 260), (10, 210, 10, 250)) & ~carve((220, 260), (50, 170, 50, 210))
    room = carve((220, 260), (53, 167, 53, 207))
    floor = reconstruct(make_grid(corridor | room), method=method)
    labels = floor.label_image(make_grid(corridor | room))
    assert len(set(labels[room].tolist()) - set(labels[corridor].tolist())) == 1
    assert (labels[room] > 0).mean() > 0.95


def test_an_unknown_method_is_refused():
    with pytest.raises(OptionError, match="magic"):
        reconstruct(make_grid(SUITE), method="magic")


@pytest.mark.parametrize("field", [field.name for field in dataclasses.fields(ThesisParameters)])
@pytest.mark.parametrize("value", [0, -1, np.nan, np.inf])
def test_thresholds_are_positive_numbers(field, value):
    with pytest.raises(OptionError, match=rf"^{field}[^\n;]*{value};[^\n;]*$"):
        ThesisParameters(**{field: value})


def test_all_bad_thresholds_are_named_in_one_message():
    with pytest.raises(OptionError, match=r"sigma.*epsilon"):
        ThesisParameters(sigma=-1, epsilon=0)


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        (np.full((60, 80), FREE), "free"),
        (np.full((60, 80), UNKNOWN), "free"),
        (np.full((60, 80), OCCUPIED), "free"),
        (np.array([[FREE]]), "free"),
        (np.array([[UNKNOWN]]), "free"),
        (np.array([[OCCUPIED]]), "free"),
        (np.array([[FREE, OCCUPIED]]), "room"),
        (np.where(carve((60, 80), (30, 33, 40, 43), (5, 7, 5, 7)), FREE, UNKNOWN), "room"),
        (np.where(np.arange(4800).reshape(60, 80) % 97 == 0, FREE, OCCUPIED), "room"),
    ],
)
def test_maps_without_a_room_are_refused(cells, message, method):
    with pytest.raises(MapError, match=message):
        reconstruct(GridMap(cells, 0.05), method=method)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@given(noise_maps())
@settings(max_examples=60)
def test_any_cells_give_a_floor_or_are_refused(method, grid):
    try:
        floor = reconstruct(grid, method=method)
    except MapError:
        return
    assert floor.rooms
    assert shapely.coverage_is_valid([room.polygon for room in floor.rooms])
