"""Borders between rooms: stretches, lines from jamb to jamb, straight label images."""

from __future__ import annotations

import numpy as np
import pytest

from pianta._types import Floats, LabelImage, Mask
from pianta.layout._voronoi_doors import compute_clearance
from pianta.layout.structure.borders import Borders, draw_borders, list_stretches, straighten_borders

NO_NECKS = np.zeros((0, 2, 2))


def make_two_rooms() -> tuple[LabelImage, Mask]:
    """Two rooms of 24 × 20 cells beside a wall of two columns with an opening of 10 rows; the border is ragged."""
    space = np.zeros((26, 44), bool)
    space[1:25, 1:21] = space[1:25, 23:43] = True
    space[8:18, 21:23] = True
    labels = np.zeros(space.shape, np.int32)
    labels[space] = 2
    labels[:, :21][space[:, :21]] = 1
    for row in range(8, 18):
        labels[row, 21 : 21 + row % 3] = 1
    return labels, space


def straighten(labels: LabelImage, space: Mask, necks: Floats = NO_NECKS) -> tuple[LabelImage, Borders]:
    clearance = compute_clearance(space)
    straight = straighten_borders(labels, space, clearance, necks, min_clearance=1.0, resolution=0.1)
    return straight, draw_borders(list_stretches(straight), space, necks, 0.1)


def test_a_stretch_has_the_cells_of_both_rooms():
    labels = np.array([[1, 1, 2], [1, 2, 2], [0, 0, 0], [1, 1, 2]])
    stretches = list_stretches(labels)
    assert [sorted(map(tuple, cells.tolist())) for cells in stretches] == [
        [(0, 1), (0, 2), (1, 0), (1, 1)],
        [(3, 1), (3, 2)],
    ]


def test_rooms_that_do_not_touch_have_no_stretch():
    assert list_stretches(np.array([[1, 0, 2]])) == []
    assert list_stretches(np.zeros((3, 3), int)) == []


def test_a_ragged_border_becomes_a_line_from_jamb_to_jamb():
    labels, space = make_two_rooms()
    straight, borders = straighten(labels, space)
    assert borders.straight.tolist() == [True]
    ends = borders.lines[0][np.argsort(borders.lines[0, :, 0])]
    # The jambs are the walls above row 8 and below row 17
    assert ends[:, 0] == pytest.approx([7, 18], abs=1)
    assert (np.abs(ends[:, 1] - 21.5) <= 2).all()
    assert ((straight > 0) == (labels > 0)).all()
    columns = [int((straight[row] == 1).sum()) for row in range(8, 18)]
    assert max(columns) - min(columns) <= 2


def test_a_border_follows_a_neck_near_it():
    labels, space = make_two_rooms()
    neck = np.array([[[7.0, 21.0], [18.0, 21.0]]])
    straight, borders = straighten(labels, space, neck)
    assert borders.lines.tolist() == neck.tolist()
    # The cells on the neck's own column belong to either room; those beside it do not change sides
    assert (straight[8:18, 20] == 1).all()
    assert (straight[8:18, 22] == 2).all()


def test_a_border_with_a_corner_stays():
    space = np.zeros((42, 42), bool)
    space[1:41, 1:41] = True
    labels = np.where(space, 1, 0).astype(np.int32)
    labels[1:15, 1:15] = 2
    straight, borders = straighten(labels, space)
    assert borders.straight.tolist() == [False]
    assert (straight == labels).all()
