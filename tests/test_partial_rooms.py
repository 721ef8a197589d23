from dataclasses import replace
from math import pi

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Point, Polygon, box
from shapely.affinity import rotate, translate

from pianta.cli.read import tabulate_rooms
from pianta.errors import FloorError, OptionError
from pianta.floor import Door, Floor, Room, scale_floor
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout.partial.predict import measure_half_wall, predict_partial_rooms
from pianta.layout.partial.scene import find_main_direction
from pianta.layout.reconstruct import reconstruct
from pianta.layout.room_ids import keep_room_ids
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.partial_scan import choose_viewpoints, find_visible_cells, simulate_partial_map
from pianta.worlds.scan import simulate_map

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
