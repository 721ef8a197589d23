"""Rooms that are too small, or of which no robot has seen much, on label images that are written by hand."""

import numpy as np
import pytest

from pianta._types import LabelImage, Mask
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.reconstruct import absorb_small_rooms
from pianta.layout.structure.unlikely_rooms import drop_enclosed_spots, drop_unseen_rooms

# Cells of 0.16 m²: a room of 4 cells has more than the 0.5 m² of a room, one of 3 cells has less.
RESOLUTION = 0.4


# Half the diameter of the largest circle in a room, in cells: wide enough for a room.
WIDE = 1.0


def absorb(labels: list[list[int]], clearance: list[list[float]] | None = None, **parameters: float) -> list[list[int]]:
    image = np.array(labels, np.int32)
    radius = np.full(image.shape, WIDE, np.float32) if clearance is None else np.array(clearance, np.float32)
    rooms: list[list[int]] = absorb_small_rooms(
        image, radius, StructureParameters(**parameters), resolution=RESOLUTION
    ).tolist()
    return rooms


class TestSmallRooms:
    def test_it_belongs_to_the_neighbour_with_the_longest_contact(self):
        """Room 2 touches room 1 along 3 cells, and room 3 along 2."""
        assert absorb([[1, 1, 2, 3, 3], [1, 1, 2, 3, 3], [1, 1, 1, 3, 3]]) == [
            [1, 1, 1, 3, 3],
            [1, 1, 1, 3, 3],
            [1, 1, 1, 3, 3],
        ]

    def test_one_without_a_neighbour_is_no_room(self):
        assert absorb([[1, 1, 0, 2], [1, 1, 0, 2], [0, 0, 0, 2]]) == [[1, 1, 0, 0], [1, 1, 0, 0], [0, 0, 0, 0]]

    def test_one_that_touches_by_a_corner_has_no_neighbour(self):
        assert absorb([[1, 1, 0], [1, 1, 0], [0, 0, 2]]) == [[1, 1, 0], [1, 1, 0], [0, 0, 0]]

    def test_rooms_of_four_cells_stay(self):
        labels = [[1, 1, 2, 2], [1, 1, 2, 2]]
        assert absorb(labels) == labels

    def test_two_small_rooms_are_one_that_is_large_enough(self):
        """The smallest comes first: room 1 joins room 2, which then has 4 cells and stays."""
        assert absorb([[1, 2, 2, 2, 3, 3, 3, 3]]) == [[2, 2, 2, 2, 3, 3, 3, 3]]

    def test_two_small_rooms_that_are_still_small_join_a_third(self):
        assert absorb([[1, 2, 2, 3, 3, 3, 3]]) == [[3, 3, 3, 3, 3, 3, 3]]

    def test_a_floor_of_one_small_room_is_none(self):
        assert absorb([[0, 1, 1]]) == [[0, 0, 0]]

    def test_the_area_of_a_room_is_a_parameter(self):
        labels = [[1, 1, 1, 2, 2, 2]]
        assert absorb(labels, room_area=0.48) == labels

    def test_one_that_is_narrower_than_half_a_metre_is_none_and_the_width_is_a_parameter(self):
        """Circles of diameter 2 · 0.6 cells are 0.48 m wide, those of 2 · 0.65 cells 0.52 m."""
        labels = [[1] * 4, [0] * 4, [2] * 4]
        clearance = [[0.6] * 4, [0.0] * 4, [0.6, 0.6, 0.65, 0.6]]
        assert absorb(labels, clearance) == [[0] * 4, [0] * 4, [2] * 4]
        assert absorb(labels, clearance, room_width=0.47) == labels

    def test_a_narrow_room_belongs_to_the_neighbour_with_the_longest_contact(self):
        assert absorb([[1] * 4, [2] * 4], [[0.5] * 4, [1.0] * 4]) == [[2] * 4, [2] * 4]

    def test_the_labels_that_are_given_stay_as_they_are(self):
        labels = np.array([[0, 1]], np.int32)
        absorb_small_rooms(labels, np.ones((1, 2), np.float32), StructureParameters(), resolution=RESOLUTION)
        assert labels.tolist() == [[0, 1]]


def drop(labels: LabelImage, free: Mask, outside: float = 0.0) -> list[list[int]]:
    chances = np.full(labels.shape, outside, np.float32)
    dropped: list[list[int]] = drop_unseen_rooms(labels, free, chances, resolution=RESOLUTION).tolist()
    return dropped


class TestUnseenRooms:
    @pytest.mark.parametrize(("cells", "stays"), [(10, True), (11, False)])
    def test_a_tenth_of_a_room_is_free(self, cells, stays):
        labels = np.array([[1] * cells + [0, 2, 2]], np.int32)
        free = np.zeros(labels.shape, bool)
        free[0, [0, -1]] = True
        assert drop(labels, free) == [[int(stays)] * cells + [0, 2, 2]]

    def test_the_highest_label_may_be_unseen(self):
        labels, free = np.array([[1, 2]], np.int32), np.array([[True, False]])
        assert drop(labels, free) == [[1, 0]]

    def test_no_room_at_all(self):
        assert drop(np.zeros((2, 2), np.int32), np.ones((2, 2), bool)) == [[0, 0], [0, 0]]

    @pytest.mark.parametrize(("cells", "outside", "stays"), [(12, 0.19, True), (12, 0.21, False), (13, 0.21, True)])
    def test_a_small_room_that_is_outside_is_a_leak(self, cells, outside, stays):
        """12 cells of 0.4 m are 1.92 m², 13 are 2.08 m²."""
        labels = np.ones((1, cells), np.int32)
        assert drop(labels, labels > 0, outside) == [[int(stays)] * cells]


class TestEnclosedSpots:
    """A hall of 10 × 10 m, cells of 0.1 m; walls are one cell thick."""

    def make_hall(self, *spot: int) -> LabelImage:
        """Rows and columns of a spot in the hall, from, to, with a wall around it."""
        top, bottom, left, right = spot
        labels = np.ones((100, 100), np.int32)
        labels[top - 1 : bottom + 1, left - 1 : right + 1] = 0
        labels[top:bottom, left:right] = 2
        return labels

    @pytest.mark.parametrize(("side", "is_room"), [(19, False), (20, True)])
    def test_a_small_spot_inside_a_room_is_none(self, side, is_room):
        """3.61 and 4 m²."""
        labels = self.make_hall(40, 40 + side, 40, 40 + side)
        rooms = drop_enclosed_spots(labels, resolution=0.1)
        assert (rooms == 2).any() == is_room
        assert ((rooms == 1) == (labels == 1)).all()

    def test_a_spot_with_an_entry_stays(self):
        labels = self.make_hall(40, 50, 40, 50)
        labels[45, 50] = 1
        assert (drop_enclosed_spots(labels, resolution=0.1) == labels).all()

    def test_a_spot_between_two_rooms_stays(self):
        labels = self.make_hall(40, 50, 40, 50)
        labels[:, 45:][labels[:, 45:] == 1] = 3
        assert (drop_enclosed_spots(labels, resolution=0.1) == labels).all()

    def test_a_spot_at_the_edge_of_a_room_stays(self):
        """A closet at a corner of the hall: the room is near on one side only."""
        labels = np.zeros((60, 60), np.int32)
        labels[30:59, 1:59] = 1
        labels[10:29, 1:15] = 2
        assert (drop_enclosed_spots(labels, resolution=0.1) == labels).all()
