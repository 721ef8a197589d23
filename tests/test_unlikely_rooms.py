"""What is too thin for a room, and boxes that nothing leads to, on label images that are written by hand."""

import numpy as np
import pytest

from pianta._types import LabelImage, Mask
from pianta.layout.structure.unlikely_rooms import absorb_thin_rooms, drop_enclosed_spots, find_boxes

# Metres per cell. A strip of n rows holds a circle of n cells, of n + 1 if n is odd.
RESOLUTION = 0.1


def absorb(labels: LabelImage, free: Mask | None = None, occupied: Mask | None = None) -> LabelImage:
    """The rooms that stay; without free cells, those of all labels are free."""
    observed = labels > 0 if free is None else free
    walls = np.zeros(labels.shape, bool) if occupied is None else occupied
    return absorb_thin_rooms(labels, observed, walls, resolution=RESOLUTION)


def make_strip(rows: int, cols: int, *, wall: int = 0) -> LabelImage:
    """A corridor of 2 × 6 m, label 1, and above it, behind some rows of wall, a strip, label 2."""
    labels = np.zeros((50, 64), np.int32)
    labels[28:48, 2:62] = 1
    labels[28 - wall - rows : 28 - wall, 20 : 20 + cols] = 2
    return labels


class TestThinRooms:
    @pytest.mark.parametrize(("rows", "is_room"), [(4, False), (6, True)])
    def test_a_strip_thinner_than_any_door_belongs_to_its_neighbour(self, rows, is_room):
        """It is open along 1 m; the row where it meets the corridor is not counted: 3 or 5 rows, 0.4 or 0.6 m."""
        labels = make_strip(rows, 10)
        assert (absorb(labels) == (labels if is_room else labels > 0)).all()

    def test_of_two_neighbours_it_is_the_one_with_the_longest_contact(self):
        labels = make_strip(4, 10)
        labels[28:48, 26:62][labels[28:48, 26:62] == 1] = 3
        assert (absorb(labels)[24:28, 20:30] == 1).all()

    @pytest.mark.parametrize(("rows", "is_room"), [(6, False), (8, True)])
    def test_where_nothing_leads_to_a_room_is_as_wide_as_most_doors(self, rows, is_room):
        """A strip of 0.6 or 0.8 m behind a wall, such as outside the façade."""
        labels = make_strip(rows, 30, wall=1)
        assert (absorb(labels) == 2).any() == is_room

    @pytest.mark.parametrize(("cols", "is_room"), [(23, True), (24, False)])
    def test_a_niche_open_along_three_times_its_depth_is_none(self, cols, is_room):
        """Of 9 rows 8 are counted, 0.8 m; three times that is 2.4 m."""
        labels = make_strip(9, cols)
        assert (absorb(labels) == 2).any() == is_room

    def test_a_room_of_a_metre_is_no_niche(self):
        """Of 11 rows 10 are counted, 1 m."""
        labels = make_strip(11, 40)
        assert (absorb(labels) == labels).all()

    @pytest.mark.parametrize(("gap", "is_room"), [(2, True), (3, False)])
    def test_the_space_between_rays_is_none(self, gap, is_room):
        """Rays of one cell, with 2 cells between them that count as seen, or with 3 that do not."""
        labels = make_strip(20, 10)
        free = labels == 1
        free[8:28, 20 : 30 : gap + 1] = True
        assert (absorb(labels, free) == (labels if is_room else labels == 1)).all()

    def test_walls_between_rays_were_not_seen_free(self):
        labels = make_strip(20, 10)
        free = labels == 1
        free[8:28, 20:30:3] = True
        assert (absorb(labels, free, (labels == 2) & ~free) == (labels == 1)).all()

    def test_chairs_in_a_room_do_not_make_it_thin(self):
        """Legs of one cell, 1 m apart."""
        labels = make_strip(25, 25)
        free = labels > 0
        free[5:28:10, 22:45:10] = False
        assert (absorb(labels, free, (labels > 0) & ~free) == labels).all()

    def test_two_strips_one_behind_the_other_belong_to_the_corridor(self):
        labels = make_strip(4, 10)
        labels[21:24, 20:30] = 3
        assert (absorb(labels) == (labels > 0)).all()

    def test_the_labels_that_are_given_stay_as_they_are(self):
        labels = make_strip(4, 10)
        absorb(labels)
        assert (labels == make_strip(4, 10)).all()

    def test_no_room_at_all(self):
        assert not absorb(np.zeros((5, 5), np.int32)).any()


class TestBoxes:
    """A hall of 10 × 10 m with boxes whose walls are one cell thick."""

    def make_hall(self, *corners: tuple[int, int], side: int) -> Mask:
        free = np.zeros((104, 104), bool)
        free[2:102, 2:102] = True
        for row, col in corners:
            free[row - 1 : row + side + 1, col - 1 : col + side + 1] = False
            free[row : row + side, col : col + side] = True
        return free

    @pytest.mark.parametrize(("side", "is_box"), [(9, False), (10, True), (19, True), (20, False)])
    def test_boxes_of_one_to_four_square_metres(self, side, is_box):
        boxes = find_boxes(self.make_hall((40, 40), side=side), resolution=RESOLUTION)
        assert boxes.sum() == is_box * side**2
        assert boxes[40, 40] == is_box

    def test_a_box_against_the_wall(self):
        """The hall is near on three sides of four."""
        boxes = find_boxes(self.make_hall((40, 3), side=15), resolution=RESOLUTION)
        assert boxes.sum() == 15**2

    def test_boxes_side_by_side_do_not_make_each_other_rooms(self):
        boxes = find_boxes(self.make_hall((40, 40), (40, 53), side=12), resolution=RESOLUTION)
        assert boxes.sum() == 2 * 12**2

    def test_a_box_with_an_entry_is_none(self):
        free = self.make_hall((40, 40), side=15)
        free[45, 55] = True
        assert not find_boxes(free, resolution=RESOLUTION).any()

    def test_a_closet_in_a_corner_of_the_building_is_none(self):
        """The hall is near on one side only."""
        free = np.zeros((60, 60), bool)
        free[30:59, 1:59] = free[10:29, 1:15] = True
        assert not find_boxes(free, resolution=RESOLUTION).any()

    def test_a_spot_between_two_rooms_and_another_spot_stays(self):
        labels = np.zeros((40, 43), np.int32)
        labels[1:39, 1:21], labels[1:39, 22:42] = 1, 2
        labels[14:26, 14:29] = 0
        labels[15:25, 15:21], labels[15:25, 22:28] = 3, 4
        assert (drop_enclosed_spots(labels, resolution=RESOLUTION) == labels).all()
