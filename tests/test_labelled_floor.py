"""Floors from label images, checked by hand."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy.ndimage import label

from pianta.errors import MapError
from pianta.floor import Floor
from pianta.gridmap import FREE, OCCUPIED, GridMap
from pianta.layout.rivals.to_floor import floor_from_labels
from tests.drawn_maps import carve, make_grid

# Two rooms of 3 × 4 m, 0.2 m of wall between them, and a door of 0.9 m.
WEST, EAST, GAP = (10, 70, 10, 90), (10, 70, 94, 174), (30, 48, 90, 94)
SUITE = carve((80, 184), WEST, EAST, GAP)
LABELS = np.where(carve(SUITE.shape, WEST), 7, np.where(carve(SUITE.shape, EAST, GAP), 3, 0))


def floor_of(labels, *, free=None) -> Floor:
    return floor_from_labels(make_grid(labels > 0 if free is None else free), labels)


def test_each_label_is_a_room_in_reading_order():
    west, east = floor_of(LABELS, free=SUITE).rooms
    assert (west.id, east.id) == (1, 2)
    assert west.polygon.equals(shapely.box(1.5 + 0.5, -2 + 0.5, 1.5 + 4.5, -2 + 3.5))
    assert east.polygon.area == pytest.approx(12 + 0.9 * 0.2)


def test_the_door_between_two_labels_is_found():
    (door,) = floor_of(LABELS, free=SUITE).doors
    assert (door.rooms, door.kind) == ((1, 2), "door")
    assert door.width == pytest.approx(0.9, abs=0.06)
    assert 1.5 + 4.4 < door.line.centroid.x < 1.5 + 4.8
    assert door.line.centroid.y == pytest.approx(-2 + (80 - 39) * 0.05, abs=0.05)


def test_of_a_label_in_parts_the_largest_is_the_room():
    labels = np.array([[5, 5, 0, 5], [5, 0, 2, 2]])
    (large, small) = floor_of(labels).rooms
    assert [round(room.polygon.area / 0.05**2) for room in (large, small)] == [3, 2]


def test_parts_that_touch_at_a_corner_are_two():
    (room,) = floor_of(np.array([[4, 4, 0], [0, 0, 4]])).rooms
    assert room.polygon.area == pytest.approx(2 * 0.05**2)


def test_a_courtyard_is_a_hole_though_it_touches_the_outside_at_a_corner():
    labels = np.array([[1, 1, 1, 1], [1, 0, 1, 1], [1, 1, 0, 1], [1, 1, 1, 0]])
    (room,) = floor_of(labels).rooms
    assert room.polygon.area == pytest.approx(13 * 0.05**2)
    assert room.polygon.is_valid


def test_there_are_no_walls_and_the_source_is_kept():
    floor = floor_from_labels(replace(make_grid(SUITE), source="suite.png"), LABELS)
    assert (floor.walls, floor.source) == ((), "suite.png")


def test_no_label_is_no_floor():
    with pytest.raises(MapError, match="room"):
        floor_of(np.zeros((4, 5), int), free=np.ones((4, 5), bool))


def test_negative_labels_are_no_rooms():
    (room,) = floor_of(np.array([[-1, -1, 3, 3]])).rooms
    assert room.polygon.area == pytest.approx(2 * 0.05**2)


def test_labels_of_another_shape_are_refused():
    with pytest.raises(MapError, match=r"\(2, 3\).*\(80, 184\)"):
        floor_from_labels(make_grid(SUITE), np.ones((2, 3), int))


@pytest.mark.slow
@given(
    arrays(np.int32, array_shapes(min_dims=2, max_dims=2, max_side=12), elements=st.integers(0, 4)).filter(np.any),
    st.sampled_from([0.0, 0.3, -2.0]),
)
def test_the_label_image_of_the_floor_gives_back_the_kept_parts(labels, yaw):
    grid = GridMap(np.where(labels > 0, FREE, OCCUPIED), 0.05, (3.0, -7.0, yaw))
    floor = floor_from_labels(grid, labels)
    assert shapely.coverage_is_valid([room.polygon for room in floor.rooms])
    image = floor.label_image(grid)
    assert len(floor.rooms) == len(set(labels[labels > 0].tolist()))
    for room in floor.rooms:
        (given_label,) = set(labels[image == room.id].tolist())
        parts, _ = label(labels == given_label)
        largest = np.bincount(parts[parts > 0]).max()
        assert len(set(parts[image == room.id].tolist())) == 1
        assert (image == room.id).sum() == largest
