from dataclasses import replace
from math import pi

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Point, Polygon, box
from shapely.affinity import rotate, translate

from pianta.cli.reading_text import tabulate_rooms
from pianta.errors import FloorError, OptionError
from pianta.floor import Door, Floor, Room, scale_floor
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout.partial.consensus import (
    NETWORK_WEIGHT,
    TEMPERATURE,
    choose_shape,
    expect_iou,
    find_probable_cells,
    mix_cells,
)
from pianta.layout.partial.hypotheses import FEATURES, Hypothesis
from pianta.layout.partial.predict import (
    clip_obstacles,
    measure_half_wall,
    predict_partial_rooms,
    subtract_obstacles,
)
from pianta.layout.partial.scene import (
    MAX_COMPARED_ROOMS,
    FloorIndex,
    View,
    find_bounds,
    find_main_direction,
)
from pianta.layout.reconstruct import reconstruct
from pianta.layout.room_ids import keep_room_ids
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.partial_scan import choose_viewpoints, find_visible_cells, simulate_partial_map
from pianta.worlds.scan import simulate_map
from tests.partial_scenes import fill_cells, make_scene

RESOLUTION = 0.05
# A row of rooms of 4 m x 5 m north of a corridor; the third was observed to a depth of 3 m.
COMPLETE = (box(0, 2.2, 4, 7.2), box(4.2, 2.2, 8.2, 7.2), box(12.6, 2.2, 16.6, 7.2))
CORRIDOR, OBSERVED, TRUE = box(0, 0, 16.6, 2), box(8.4, 2.2, 12.4, 5.2), box(8.4, 2.2, 12.4, 7.2)


def draw_row() -> tuple[Floor, GridMap]:
    """The row with its map: wall faces around the observed part, but not beyond it."""
    grid = GridMap(np.full((220, 400), UNKNOWN, np.int8), RESOLUTION, (-1.5, -1.5, 0.0))
    observed = [*COMPLETE, CORRIDOR, OBSERVED]
    cells = np.full(grid.shape, UNKNOWN, np.int8)
    rows, cols = np.indices(grid.shape) + 0.5
    x, y = grid.pixel_to_map(rows, cols)
    complete = shapely.union_all([*COMPLETE, CORRIDOR, TRUE])
    observed_area = shapely.union_all(observed)
    cells[
        shapely.contains_xy(observed_area.buffer(0.1, join_style="mitre"), x, y) & ~shapely.contains_xy(complete, x, y)
    ] = OCCUPIED
    cells[shapely.contains_xy(observed_area, x, y)] = FREE
    # The observed end of the walls.
    cells[shapely.contains_xy(box(8.4, 5.2, 12.4, 5.4), x, y)] = UNKNOWN
    rooms = [Room(i, polygon) for i, polygon in enumerate((*COMPLETE, CORRIDOR), start=1)]
    floor = Floor(
        (*rooms, Room(5, OBSERVED, partial=True)), (Door((4, 5), shapely.LineString([(10, 2.1), (11, 2.1)]), 1.0),)
    )
    return floor, replace_cells(grid, cells)


def last_prediction(floor: Floor) -> Polygon:
    """The prediction for the last room."""
    predicted = floor.rooms[-1].predicted
    assert predicted
    return predicted


def replace_cells(grid: GridMap, cells: np.ndarray) -> GridMap:
    return GridMap(cells, grid.resolution, grid.origin)


@pytest.fixture(scope="module")
def row() -> tuple[Floor, GridMap]:
    return draw_row()


def test_a_room_between_others_is_as_deep_as_they_are(row):
    predicted = last_prediction(predict_partial_rooms(*row))
    wall = measure_half_wall(row[0])
    # A cell of the scene is 0.1 m.
    assert predicted.bounds == pytest.approx(TRUE.buffer(wall, join_style="mitre").bounds, abs=0.15)


def test_a_prediction_contains_the_observed_part_and_overlaps_no_room(row):
    floor = predict_partial_rooms(*row)
    room = floor.rooms[-1]
    assert room.polygon.equals(OBSERVED)
    predicted = last_prediction(floor)
    assert predicted.buffer(1e-6).contains(room.polygon)
    assert all(predicted.intersection(other.polygon).area < 1e-6 for other in floor.rooms[:-1])
    assert 0 < (room.confidence or 0) <= 1


def test_only_partial_rooms_are_predicted(row):
    floor, grid = row
    assert all(
        room.predicted is None and room.confidence is None for room in predict_partial_rooms(floor, grid).rooms[:-1]
    )
    complete = replace(floor, rooms=tuple(replace(room, partial=False) for room in floor.rooms))
    assert predict_partial_rooms(complete, grid) is complete


def test_a_room_thinner_than_a_cell_is_predicted_too(row):
    thin = box(8.51, 6, 8.52, 6.01)
    predicted = last_prediction(predict_partial_rooms(Floor((Room(1, thin, partial=True),)), row[1]))
    assert predicted.buffer(1e-6).contains(thin)


def as_hypothesis(cells: np.ndarray) -> Hypothesis:
    return Hypothesis(cells, (slice(0, 40), slice(0, 60)), find_bounds(cells), np.zeros(len(FEATURES)))


def test_expected_iou_is_what_is_common_of_all():
    # 100 cells, of which 40 are surely in the room, which has 60 more with a probability of a half.
    probability = np.zeros((40, 60))
    probability[:10, :4], probability[20:30, :6] = 1, 0.5
    window = (slice(0, 10), slice(0, 10))
    assert expect_iou(probability, np.ones((10, 10), bool), window) == pytest.approx(40 / (100 + 70 - 40))


def test_the_probability_of_a_cell_is_a_mean_of_network_and_hypotheses():
    scene = make_scene(fill_cells(10, 10, 20, 20), others=fill_cells(0, 45, 40, 60))
    hypotheses = [as_hypothesis(scene.observed), as_hypothesis(fill_cells(10, 10, 20, 50))]
    mixed = mix_cells(scene, np.full((40, 60), 0.5), hypotheses, np.array([0.5, 0.5 + TEMPERATURE]))
    share = np.exp(1) / (1 + np.exp(1))
    assert mixed[15, [15, 30, 50]] == pytest.approx([1, NETWORK_WEIGHT / 2 + (1 - NETWORK_WEIGHT) * share, 0])
    # Beside the longer hypothesis, in the wall, and further away.
    assert mixed[[20, 21], 30] == pytest.approx([mixed[15, 30], NETWORK_WEIGHT / 2])


def test_a_straight_hypothesis_is_taken_if_it_is_nearly_as_good_as_the_probable_cells():
    scene = make_scene(fill_cells(10, 10, 20, 20))
    hypotheses = [as_hypothesis(scene.observed), as_hypothesis(fill_cells(10, 10, 20, 40))]
    probable = fill_cells(9, 9, 21, 41).astype(float)
    shape = choose_shape(scene, hypotheses, probable)
    assert (shape.cells == hypotheses[1].cells).all()
    assert (shape.expected_iou, shape.reaches_walls) == (1, False)
    probable[9:21, 41:50] = 1
    shape = choose_shape(scene, hypotheses, probable)
    assert (int(np.count_nonzero(shape.cells)), shape.expected_iou, shape.reaches_walls) == (12 * 41, 1.0, True)


def test_the_observed_part_is_taken_if_nothing_else_is_better():
    scene = make_scene(fill_cells(10, 10, 20, 20))
    hypotheses = [as_hypothesis(scene.observed), as_hypothesis(fill_cells(10, 10, 20, 40))]
    shape = choose_shape(scene, hypotheses, fill_cells(9, 9, 21, 21).astype(float))
    assert (shape.cells == scene.observed).all()


def test_probable_cells_are_joined_to_the_observed_part_and_no_slivers():
    scene = make_scene(fill_cells(10, 10, 20, 20))
    probability = fill_cells(10, 10, 20, 30) * 0.6 + fill_cells(30, 10, 40, 30) * 0.9
    probability[14:17, 30:50] = 0.9
    shape = find_probable_cells(scene, probability)
    cells = np.zeros_like(scene.observed)
    cells[shape.window] = shape.cells
    assert (cells == fill_cells(10, 10, 20, 30)).all()


def test_a_sliver_whose_walls_are_larger_than_itself_is_predicted_too(row):
    sliver = box(8.41, 6, 12.39, 6.02)
    floor = Floor((*row[0].rooms[:-1], Room(5, sliver, partial=True)))
    predicted = last_prediction(predict_partial_rooms(floor, row[1]))
    assert predicted.buffer(1e-6).contains(sliver)
    assert all(predicted.intersection(other.polygon).area < 1e-6 for other in floor.rooms[:-1])


def test_the_index_of_a_floor_finds_what_is_near_a_room():
    # A row of 300 rooms of 4 m x 5 m: those that begin within 60 m of the first one's end are the rooms 2 to 16.
    rooms = [Room(i + 1, box(4 * i, 0, 4 * i + 4, 5)) for i in range(300)]
    index = FloorIndex.from_floor(Floor(tuple(rooms)))
    assert index.sides[index.find_sides(rooms[0], 60.0)][..., 0].max() == 68
    extents = index.measure_extents(rooms[0], View(0.0, np.zeros(2), (10, 10), 0.1))
    assert extents.shape == (MAX_COMPARED_ROOMS, 2)
    assert extents == pytest.approx(np.tile([4.0, 5.0], (MAX_COMPARED_ROOMS, 1)))


@pytest.mark.parametrize("yaw", [0.0, 0.4, -0.9])
def test_a_view_samples_the_cell_below_each_of_its_centres(yaw):
    grid = GridMap(np.zeros((30, 50), np.int8), 0.07, (1.0, -2.0, yaw))
    values = np.arange(1500, dtype=np.uint16).reshape(grid.shape) % 251
    view = View(0.3, np.array([0.1, -1.9]), (40, 25), 0.1)
    sampled = view.sample(values.astype(np.uint8), grid, beyond=255)
    rows, cols = (np.indices(view.shape) + 0.5).reshape(2, -1)
    pixels = grid.map_to_pixel(*view.to_map(np.column_stack([cols, rows])).T)
    row, col = (np.floor(pixel).astype(int) for pixel in pixels)
    inside = (row >= 0) & (row < 30) & (col >= 0) & (col < 50)
    expected = np.where(inside, values[row.clip(0, 29), col.clip(0, 49)], 255)
    assert 0 < inside.mean() < 1
    assert (sampled.ravel() == expected).all()


def test_without_predictions_rooms_are_still_partial():
    floor = make_corridor_floor(seed=3)
    grid = simulate_partial_map(floor, simulate_map(floor, seed=3), share=0.6, reach=8, entered=0.2, seed=3)
    reconstructed, plain = reconstruct(grid), reconstruct(grid, predict_partial=False)
    assert any(room.predicted for room in reconstructed.rooms)
    unpredicted = tuple(replace(room, predicted=None, confidence=None) for room in reconstructed.rooms)
    assert plain == replace(reconstructed, rooms=unpredicted)


def test_half_a_wall_is_half_the_distance_of_rooms(row):
    assert measure_half_wall(row[0]) == pytest.approx(0.1)


def test_half_a_wall_is_0_if_rooms_touch():
    assert measure_half_wall(Floor((Room(1, box(0, 0, 4, 4)), Room(2, box(4, 0, 8, 4))))) == pytest.approx(0, abs=0.01)


def test_a_floor_of_one_room_has_the_usual_wall():
    assert measure_half_wall(Floor((Room(1, box(0, 0, 4, 4), partial=True),))) > 0


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(angle=st.floats(-pi, pi), x=st.floats(-50, 50), y=st.floats(-50, 50))
def test_a_turned_map_gives_the_turned_prediction(row, angle, x, y):
    floor, grid = row

    def move(shape: shapely.Geometry) -> shapely.Geometry:
        return translate(rotate(shape, angle, origin=(0, 0), use_radians=True), x, y)

    x0, y0 = shapely.get_coordinates(move(Point(grid.origin[:2])))[0]
    turned = GridMap(grid.cells, grid.resolution, (x0, y0, grid.origin[2] + angle))
    rooms = tuple(replace(room, polygon=move(room.polygon)) for room in floor.rooms)
    doors = tuple(replace(door, line=move(door.line)) for door in floor.doors)
    reconstructed = last_prediction(predict_partial_rooms(Floor(rooms, doors), turned))
    expected = move(last_prediction(predict_partial_rooms(floor, grid)))
    assert reconstructed.intersection(expected).area / reconstructed.union(expected).area > 0.9


@pytest.mark.parametrize("angle", [0.0, 0.3, -0.6])
def test_the_main_direction_is_that_of_the_walls(row, angle):
    rooms = tuple(
        replace(room, polygon=rotate(room.polygon, angle, origin=(0, 0), use_radians=True)) for room in row[0].rooms
    )
    assert find_main_direction(Floor(rooms), rooms[-1]) == pytest.approx(angle)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["structure", "thesis"])
def test_predictions_of_a_floor_overlap_neither_rooms_nor_each_other(method):
    floor = make_corridor_floor(seed=3)
    grid = simulate_partial_map(floor, simulate_map(floor, seed=3), share=0.6, reach=8, entered=0.2, seed=3)
    reconstructed = reconstruct(grid, method=method)
    predicted = [room for room in reconstructed.rooms if room.predicted]
    assert predicted
    assert all(room.partial for room in predicted)
    assert len(predicted) == sum(room.partial for room in reconstructed.rooms)
    for room in predicted:
        shape = room.predicted or Polygon()
        assert shape.buffer(1e-6).contains(room.polygon)
        rest = [other.predicted or other.polygon for other in reconstructed.rooms if other.id != room.id]
        assert shape.intersection(shapely.union_all(rest)).area < 0.05


def test_the_same_map_gives_the_same_prediction(row):
    assert predict_partial_rooms(*row) == predict_partial_rooms(*row)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"predicted": box(0, 0, 1, 1)}, "partial"),
        ({"partial": True, "confidence": 0.5}, "predicted"),
        ({"partial": True, "predicted": box(0, 0, 1, 1), "confidence": 1.5}, r"1\.5"),
    ],
)
def test_an_invalid_prediction_is_refused(change, message):
    with pytest.raises(FloorError, match=message):
        Room(1, box(0, 0, 1, 1), **change)


def test_a_scaled_floor_scales_predictions():
    room = Room(1, box(0, 0, 1, 1), partial=True, predicted=box(0, 0, 2, 1), confidence=0.5)
    assert last_prediction(scale_floor(Floor((room,)), 2, 3)).bounds == (0, 0, 4, 3)


def test_the_graph_contains_predictions():
    rooms = (
        Room(1, box(0, 0, 1, 1), partial=True, predicted=box(0, 0, 2, 1), confidence=0.5),
        Room(2, box(3, 0, 4, 1)),
    )
    nodes = Floor(rooms).graph().nodes
    assert (nodes[1]["predicted_area"], nodes[1]["confidence"]) == (2, 0.5)
    assert (nodes[2]["predicted_area"], nodes[2]["confidence"]) == (None, None)


def test_a_lidar_detects_no_cell_behind_a_wall():
    cells = np.zeros((20, 40), np.int8)
    cells[:, 20] = OCCUPIED
    observed = find_visible_cells(GridMap(cells, 0.1), Point(1.0, 1.0), reach=10)
    assert observed[:, 20].any()
    assert observed[10, :20].all()
    assert not observed[:, 22:].any()


def test_a_robot_that_passes_no_door_takes_one_scan():
    floor = make_corridor_floor(seed=1)
    assert len(choose_viewpoints(floor, share=0, entered=1, seed=1)) == 1


def test_an_invalid_share_is_refused():
    floor = make_corridor_floor(seed=1)
    with pytest.raises(OptionError, match="share"):
        simulate_partial_map(floor, simulate_map(floor), share=2, reach=8)


def test_a_room_that_keeps_its_id_keeps_its_prediction():
    room = Room(1, box(0, 0, 2, 3), partial=True, predicted=box(0, 0, 4, 3), confidence=0.5)
    (same,) = keep_room_ids(Floor((room,)), Floor((Room(7, box(0, 0, 2, 3), "LAB"),))).rooms
    assert (same.id, same.label, same.predicted, same.confidence) == (
        7,
        "LAB",
        room.predicted,
        0.5,
    )


def test_the_table_shows_the_observed_share_of_a_room():
    rooms = (Room(1, box(0, 0, 2, 3), partial=True, predicted=box(0, 0, 4, 3)), Room(2, box(5, 0, 6, 1), partial=True))
    column = tabulate_rooms(Floor(rooms)).columns[-1]
    assert [*column.cells] == ["in part, ~50 %", "in part"]


def test_the_table_shows_no_share_of_a_room_whose_prediction_adds_nothing():
    room = Room(1, box(0, 0, 2, 3), partial=True, predicted=box(0, 0, 2, 3))
    assert [*tabulate_rooms(Floor((room,))).columns[-1].cells] == ["in part"]


def test_obstacles_that_touch_the_clipped_area_with_a_side_too():
    """The shape fills x and y from 0 to 4, so that obstacles are clipped at 4.5 m.

    The U has an arm from 4 to 4.5 m, and a side of the other arm lies on the edge of the box.
    """
    shape = box(0, 0, 4, 4)
    obstacle = Polygon([(3, 1), (6, 1), (6, 3), (4.5, 3), (4.5, 2), (3, 2)])
    clipped = clip_obstacles([obstacle], shape)
    assert clipped.area == pytest.approx(1.5)
    assert subtract_obstacles(shape, clipped, Room(1, box(0, 0, 2, 4))).area == pytest.approx(15)
