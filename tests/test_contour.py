import numpy as np
import pytest

from pianta.layout.parameters import ThesisParameters
from pianta.layout.thesis.contour import compute_map_contour
from tests.drawn_maps import carve, make_working_grid

# 4 m by 6 m of free space.
BUILDING = (10, 90, 10, 130)
SHAPE = (100, 140)


@pytest.mark.parametrize(
    ("hole", "is_inside"),
    [
        ((40, 59, 50, 68), True),  # 0.95 m by 0.9 m
        ((40, 62, 50, 72), False),  # 1.1 m by 1.1 m
    ],
)
def test_holes_as_large_as_a_courtyard_are_outside(hole, is_inside):
    building, spot = carve(SHAPE, BUILDING), carve(SHAPE, hole)
    inner = compute_map_contour(make_working_grid(building & ~spot), ThesisParameters())
    assert np.array_equal(inner, building if is_inside else building & ~spot)


def test_a_room_in_a_courtyard_is_inside():
    courtyard, pavilion = carve(SHAPE, (20, 80, 30, 110)), carve(SHAPE, (40, 65, 50, 80))
    free = carve(SHAPE, BUILDING) & ~courtyard | pavilion
    assert np.array_equal(compute_map_contour(make_working_grid(free), ThesisParameters()), free)


def test_patches_smaller_than_a_room_are_outside():
    building = carve(SHAPE, (10, 90, 10, 90))
    free = building | carve(SHAPE, (10, 28, 100, 118))
    assert np.array_equal(compute_map_contour(make_working_grid(free), ThesisParameters()), building)
    assert np.array_equal(compute_map_contour(make_working_grid(free), ThesisParameters(room_area=0.5)), free)


def test_areas_are_in_square_metres_whatever_the_cells():
    free = carve(SHAPE, BUILDING) & ~carve(SHAPE, (40, 62, 50, 72))
    inner = compute_map_contour(make_working_grid(free, resolution=0.04), ThesisParameters())
    assert np.array_equal(inner, carve(SHAPE, BUILDING))


def test_a_room_inside_a_ring_of_corridor_is_inside_though_no_door_leads_to_it():
    corridor = carve(SHAPE, BUILDING) & ~carve(SHAPE, (30, 70, 30, 110))
    room = carve(SHAPE, (32, 68, 32, 108))
    inner = compute_map_contour(make_working_grid(corridor | room), ThesisParameters())
    assert inner[corridor | room].all()
