"""Evidence of the network: the main direction of a map, and the frames of its cells."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pianta._types import Mask
from pianta.layout.structure.evidence import FLOOR, OUTSIDE, evaluate_map, find_main_direction
from tests.drawn_maps import carve

# Two rooms of 5 × 5 m and a door of 1 m between them, cells of 0.05 m.
ROOMS = carve((240, 340), (70, 170, 60, 160), (70, 170, 164, 264), (110, 130, 160, 164))
WALLS = (cv2.dilate(ROOMS.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0) & ~ROOMS


def turn_cells(cells: Mask, degrees: float) -> Mask:
    """The cells turned about the middle of the image, clockwise on the screen where rows count downwards."""
    height, width = cells.shape
    matrix = cv2.getRotationMatrix2D((width / 2, height / 2), -degrees, 1.0)
    return np.asarray(cv2.warpAffine(cells.astype(np.uint8), matrix, (width, height), flags=cv2.INTER_NEAREST), bool)


@pytest.mark.parametrize("degrees", [0, 5, 20, 44, -10, -40])
def test_the_main_direction_is_that_of_the_walls(degrees):
    assert np.degrees(find_main_direction(turn_cells(ROOMS, degrees))) == pytest.approx(degrees, abs=0.7)


def test_a_map_without_edges_is_not_turned():
    assert find_main_direction(np.ones((20, 20), bool)) == 0
    assert find_main_direction(ROOMS) == 0


@pytest.mark.parametrize("degrees", [0, 30, -15])
def test_evidence_is_on_the_cells_of_the_map_at_any_angle(degrees):
    free, walls = turn_cells(ROOMS, degrees), turn_cells(WALLS, degrees)
    evidence = evaluate_map(free, walls, resolution=0.05)
    floor = evidence.enlarge(evidence.classes[FLOOR])
    assert floor.shape == free.shape
    inner = cv2.erode(free.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    assert floor[inner].mean() > 0.9
    assert floor[~free].mean() < 0.2
    assert evidence.enlarge(evidence.classes[OUTSIDE])[0, 0] > 0.9


@pytest.mark.parametrize("degrees", [0, 30])
def test_labels_are_sampled_at_the_cells_of_the_network(degrees):
    """The number of cells is that of the map at half the resolution; enlarged, the labels are where they were."""
    free, walls = turn_cells(ROOMS, degrees), turn_cells(WALLS, degrees)
    evidence = evaluate_map(free, walls, resolution=0.05)
    sampled = evidence.sample(free.astype(np.int32))
    assert sampled.shape == evidence.classes.shape[1:]
    assert sampled.sum() == pytest.approx(free.sum() / 4, rel=0.02)
    assert (evidence.enlarge(sampled.astype(np.float32)) > 0.5)[free].mean() > 0.97
