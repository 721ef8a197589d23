"""The morphological segmentation, checked by hand."""

import numpy as np

from pianta.layout.rivals.morphological import MorphologicalParameters, segment_by_erosion
from tests.drawn_maps import carve, make_grid

# Two rooms of 2 × 2 m that a door of 0.8 m joins.
PAIR = carve((60, 104), (10, 50, 10, 50), (10, 50, 54, 94), (22, 38, 50, 54))


def test_erosion_takes_a_door_apart_and_gives_back_what_it_took():
    labels = segment_by_erosion(make_grid(PAIR), parameters=MorphologicalParameters(largest=3))
    west, east = (set(labels[10:50, cols].ravel().tolist()) for cols in (slice(10, 50), slice(54, 94)))
    assert (west, east) == ({1}, {2})
    # Both fronts come to the middle of the door, and no cell is left over.
    assert (labels[22:38, 50:54] == [1, 1, 2, 2]).all()


def test_space_below_the_largest_room_is_not_eroded():
    labels = segment_by_erosion(make_grid(PAIR), parameters=MorphologicalParameters(largest=9))
    assert (labels == PAIR).all()


def test_a_room_is_eroded_no_further_though_it_has_a_waist():
    # The pair falls off the hall, 10 × 10 m, long before its own door is taken apart.
    free = carve((300, 260), (10, 210, 10, 210), (230, 270, 10, 50), (230, 270, 54, 94), (242, 258, 50, 54))
    free |= carve(free.shape, (210, 230, 28, 32))
    labels = segment_by_erosion(make_grid(free))
    assert labels.max() == 2
    assert len(set(labels[232:268, 12:92][free[232:268, 12:92]].tolist())) == 1


def test_what_falls_off_below_the_smallest_room_is_given_to_its_neighbour():
    # A niche of 0.5 m² behind a gap of 0.2 m
    free = carve((60, 90), (10, 50, 10, 50), (28, 32, 50, 54), (25, 35, 54, 74))
    assert (segment_by_erosion(make_grid(free)) == free).all()


def test_the_smallest_room_has_0_8_square_metres():
    def lone_room(cols: int):
        return segment_by_erosion(make_grid(carve((40, 60), (10, 30, 10, 10 + cols)))).max()

    assert (lone_room(15), lone_room(16)) == (0, 1)


def test_a_large_square_shrinks_until_it_is_a_room():
    square = np.pad(np.ones((200, 200), bool), 1)
    assert (segment_by_erosion(make_grid(square)) == square).all()
