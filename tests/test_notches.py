import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import Polygon, box

from pianta.layout.structure.notches import fill_notches

ROOM = box(0, 0, 6, 5)


def fill(*outlines: Polygon, depth: float = 1.0, width: float = 3.0) -> list[Polygon]:
    return list(fill_notches(np.array(outlines, dtype=object), depth=depth, width=width))


def covers_same(one: Polygon, other: Polygon) -> bool:
    return bool(one.symmetric_difference(other).area < 1e-4)


@pytest.mark.parametrize(
    "cabinet",
    [
        box(0, 0, 0.6, 2),
        box(5.4, 4, 6, 5),
        box(2, 4.4, 4, 5),
        box(0, 1, 0.5, 2),
        # Deeper than wide.
        box(2, 0, 2.1, 0.9),
    ],
)
@pytest.mark.parametrize("turn", [0, 30, 90])
def test_a_cabinet_in_a_corner_or_on_a_side_is_filled(cabinet, turn):
    outline, expected = (shapely.affinity.rotate(shape, turn, origin=(0, 0)) for shape in (ROOM - cabinet, ROOM))
    (filled,) = fill(outline)
    assert covers_same(filled, expected)


def test_a_filled_outline_has_no_surplus_corners_in_either_direction():
    outline = ROOM - box(0, 0, 0.6, 2) - box(2, 4.4, 4, 5)
    assert len(fill(outline)[0].exterior.coords) == 5
    assert covers_same(fill(outline.reverse())[0], ROOM)


def test_the_wall_between_two_doors_is_not_filled():
    # Two doors, 30 cm deep in the lower wall, 1 m apart.
    room = box(0, 0, 12, 5)
    outline = room | box(4, -0.3, 5, 0) | box(6, -0.3, 7, 0)
    assert covers_same(fill(outline)[0], outline)
    deeper = room | box(4, -0.4, 5, 0) | box(6, -0.4, 7, 0)
    assert covers_same(fill(deeper)[0], room | box(4, -0.4, 7, 0))


@pytest.mark.parametrize("corner", [box(0, 0, 0.3, 2), box(4, 4.7, 6, 5)])
def test_the_wall_between_a_door_and_the_corner_is_not_filled(corner):
    outline = ROOM - corner
    assert covers_same(fill(outline)[0], outline)


@pytest.mark.parametrize("missing", [box(0, 0, 1.1, 2), box(2, 3.9, 4, 5), box(0, 0, 0.6, 3.1), box(2, 4, 5.1, 5)])
def test_a_notch_too_deep_or_too_wide_for_furniture_stays(missing):
    outline = ROOM - missing
    assert covers_same(fill(outline)[0], outline)
    assert covers_same(fill(outline, depth=1.2, width=3.2)[0], ROOM)


def test_an_l_shaped_room_stays():
    outline = box(0, 0, 6, 2) | box(0, 0, 2, 6)
    assert covers_same(fill(outline)[0], outline)


def test_a_slanting_corner_stays():
    outline = Polygon([(1, 0), (6, 0), (6, 5), (0, 5), (0, 1)])
    assert covers_same(fill(outline)[0], outline)


def test_the_wall_beside_a_niche_stays_where_it_is_longer_than_furniture():
    outline = box(0, 0, 12, 5) | box(4, 5, 5, 5.6)
    assert covers_same(fill(outline)[0], outline)
    # Two cabinets of 2 m and 3 m leave the same outline as a niche.
    assert covers_same(fill(ROOM | box(2, 5, 3, 5.6))[0], box(0, 0, 6, 5.6))


def test_a_notch_that_overlaps_another_room_stays():
    outline, shaft = ROOM - box(5.2, 4.2, 6, 5), box(5.4, 4.4, 6, 5)
    assert all(map(covers_same, fill(outline, shaft), (outline, shaft)))
    assert all(map(covers_same, fill(shaft, outline), (shaft, outline)))
    far = box(8, 0, 10, 5)
    assert all(map(covers_same, fill(outline, far), (ROOM, far)))


def test_a_notch_between_two_rooms_goes_to_one_of_them():
    one, other = box(0, 0, 4, 4) - box(3, 3, 4, 4), box(3, 3, 7, 7) - box(3, 3, 4, 4)
    filled = fill(one, other)
    assert all(map(covers_same, filled, (box(0, 0, 4, 4), other)))


def test_a_room_that_a_notch_touches_keeps_its_area():
    outline, beside = ROOM - box(5, 4, 6, 5), box(5.99, 4, 8, 5)
    filled = fill(outline, beside)
    assert covers_same(filled[1], beside)
    assert covers_same(filled[0], ROOM - beside)


def test_a_notch_in_front_of_furniture_behind_furniture_is_filled_too():
    steps = ROOM - box(0, 0, 0.5, 1.5) - box(0, 0, 1, 0.5)
    assert covers_same(fill(steps)[0], ROOM)


def test_holes_stay():
    outline = ROOM - box(0, 0, 0.6, 2) - box(3, 2, 4, 3)
    assert covers_same(fill(outline)[0], ROOM - box(3, 2, 4, 3))


def test_no_outline_and_an_empty_one_are_unchanged():
    assert fill() == []
    assert fill(Polygon(), ROOM)[0].is_empty


decimetres = st.integers(0, 60)
sizes = st.integers(1, 35)
furniture = st.lists(st.tuples(st.integers(0, 130), decimetres, sizes, sizes), max_size=8)


@pytest.mark.slow
@given(furniture)
def test_filled_rooms_are_valid_contain_their_outline_and_never_overlap(pieces):
    obstacles = shapely.union_all(
        [box(x / 10, y / 10, (x + wide) / 10, (y + deep) / 10) for x, y, wide, deep in pieces]
    )
    walls = [box(0, 0, 4, 6), box(4, 0, 9, 3), box(4.2, 3, 9, 6), box(9.1, 0, 13, 6)]
    parts = [max(shapely.get_parts(room - obstacles), key=lambda part: part.area, default=Polygon()) for room in walls]
    rooms = [part for part in parts if not part.is_empty]
    filled = fill(*rooms)
    for room, result in zip(rooms, filled, strict=True):
        assert isinstance(result, Polygon)
        assert result.is_valid
        assert (room - result).area < 1e-4
        assert (result - room.envelope).area < 1e-4
    overlaps = [one & other for i, one in enumerate(filled) for other in filled[:i]]
    assert max((overlap.area for overlap in overlaps), default=0.0) < 1e-4


@pytest.mark.slow
@given(furniture)
def test_a_filled_outline_has_no_notch_left(pieces):
    obstacles = shapely.union_all(
        [box(x / 20, y / 10, (x + wide) / 20, (y + deep) / 10) for x, y, wide, deep in pieces]
    )
    (room,) = [max(shapely.get_parts(ROOM - obstacles), key=lambda part: part.area, default=Polygon())]
    (once,) = fill(room)
    assert covers_same(fill(once)[0], once)
