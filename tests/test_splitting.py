import cv2
import numpy as np
import pytest

from pianta._types import Floats, LabelImage, Mask
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.splitting import split_rooms
from pianta.layout.structure.wall_lines import WallLines, find_wall_lines
from tests.drawn_maps import carve

NONE = WallLines(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros((0, 2)))


def split(space: Mask, labels: LabelImage | None = None, lines: WallLines | None = None) -> tuple[LabelImage, Floats]:
    clearance = cv2.distanceTransform(space.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE).astype(np.float32)
    lines = find_wall_lines(space, resolution=0.05) if lines is None else lines
    labels = space.astype(np.int32) if labels is None else labels
    return split_rooms(labels, space, clearance, lines, parameters=StructureParameters(), resolution=0.05)


def draw_hall_and_strip() -> Mask:
    """A hall above a strip of 2.4 m; of the wall of 10 m between them 2 m in the middle are open."""
    return carve((180, 240), (20, 100, 20, 220), (104, 152, 20, 220), (100, 104, 100, 140))


def draw_corridor() -> Mask:
    """Three rooms of 5 m, open to the corridor below by 60 % of their front."""
    rooms = [(20, 100, left, left + 100) for left in (20, 124, 228)]
    fronts = [(100, 104, left + 20, left + 80) for left in (20, 124, 228)]
    return carve((214, 350), (104, 194, 20, 328), *rooms, *fronts)


def draw_pillars() -> Mask:
    space = carve((240, 280), (20, 220, 20, 260))
    for row in (80, 160):
        for col in (100, 180):
            space[row : row + 8, col : col + 8] = False
    return space


def test_a_half_wall_divides_a_hall_and_a_strip():
    labels, closed = split(draw_hall_and_strip())

    assert (labels[20:99, 20:220] == 1).all()
    assert (labels[105:152, 20:220] == 2).all()
    assert len(closed) == 1
    np.testing.assert_allclose(np.sort(closed[0, :, 1]), [99, 140], atol=4)
    assert ((closed[0, :, 0] >= 98) & (closed[0, :, 0] <= 105)).all()


def test_rooms_open_by_most_of_their_front_leave_the_corridor():
    labels, closed = split(draw_corridor())

    numbers = labels[[60, 60, 60, 130], [70, 174, 278, 174]]
    assert sorted(numbers.tolist()) == [1, 2, 3, 4]
    assert len(closed) == 3


@pytest.mark.parametrize(
    "space",
    [carve((140, 180), (20, 120, 20, 160)), carve((240, 240), (20, 120, 20, 220), (120, 220, 20, 120)), draw_pillars()],
    ids=["plain", "L-shaped", "pillars"],
)
def test_a_room_without_a_dividing_wall_is_not_split(space):
    labels, closed = split(space)

    np.testing.assert_array_equal(labels, space)
    assert closed.shape == (0, 2, 2)


def test_a_turned_map_is_divided_in_the_same_way():
    space = draw_hall_and_strip()
    straight, turned = split(space)[0], split(np.rot90(space).copy())[0]

    back = np.rot90(turned, -1)
    apart = (straight == 2) != (back == back[130, 60])
    assert back[130, 60] != back[60, 60]
    assert not apart[:96].any()
    assert not apart[108:].any()


def test_rooms_that_no_line_divides_are_unchanged():
    space = draw_hall_and_strip()
    space[2:12, 5:30] = True
    labels = space.astype(np.int32)
    labels[2:12, 5:30] = 7

    divided, _ = split(space, labels)

    assert (divided[2:12, 5:30] == 7).all()
    assert (divided[~space] == 0).all()
    assert (divided[space] > 0).all()
    assert set(np.unique(divided)) == {0, 1, 7, 8}
    assert (labels[space] != 8).all()


@pytest.mark.parametrize(("labels", "lines"), [(None, NONE), (np.zeros((180, 240), np.int32), None)])
def test_without_lines_or_without_rooms_nothing_changes(labels, lines):
    space = draw_hall_and_strip()
    divided, closed = split(space, labels, lines)

    np.testing.assert_array_equal(divided, space if labels is None else labels)
    assert closed.shape == (0, 2, 2)
