"""Room ids stay on a map that has grown or moved, and never come back."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Polygon, box

from pianta.errors import FloorError
from pianta.evaluation.persistence import Persistence, score_persistence
from pianta.floor import Door, Floor, Room
from pianta.io.maps import read_map
from pianta.layout.frames import Motion, find_motion, find_shift, measure_share
from pianta.layout.reconstruct import reconstruct
from pianta.layout.room_ids import find_frame_motion, keep_room_ids, match_rooms
from pianta.worlds.floors import FLOOR_MAKERS, make_floor

LEFT, MIDDLE, RIGHT = box(0, 0, 4, 3), box(4, 0, 9, 3), box(9, 0, 12, 3)
LINE = LineString([(4, 1), (4, 2)])
EXAMPLES = 40  # of a test that compares floors several times

cuts = st.lists(st.integers(1, 19), min_size=1, max_size=6, unique=True).map(lambda inner: [0, *sorted(inner), 20])


def floor_of(*polygons: Polygon, first_id: int = 1, doors: tuple[Door, ...] = (), last_id: int = 0) -> Floor:
    rooms = tuple(Room(number, polygon) for number, polygon in enumerate(polygons, start=first_id))
    return Floor(rooms, doors, last_id=last_id)


def ids_of(floor: Floor) -> list[int]:
    return [room.id for room in floor.rooms]


def move(floor: Floor, x: float, y: float) -> Floor:
    rooms = (replace(room, polygon=shapely.affinity.translate(room.polygon, x, y)) for room in floor.rooms)
    return replace(floor, rooms=tuple(rooms))


@st.composite
def tilings(draw) -> Floor:
    """A block of 20 m × 20 m cut into columns, and these into rooms; ids in any order, some rooms missing."""
    xs = draw(cuts)
    cells = [box(*low, *high) for x in pairwise(xs) for y in pairwise(draw(cuts)) for low, high in [zip(x, y)]]  # noqa: B905
    ids = draw(st.permutations(range(1, len(cells) + 1)))
    rooms = [Room(id_, cell) for id_, cell in zip(ids, cells, strict=True) if draw(st.integers(0, 9))]
    return Floor(tuple(rooms), last_id=len(cells) + draw(st.integers(0, 3)))


def test_rooms_that_have_grown_keep_their_ids_and_new_ones_get_new_ids():
    """The second room was partly explored before; the third is in space that was unexplored."""
    previous = floor_of(LEFT, box(4, 0, 5.5, 2), first_id=4)
    assert ids_of(keep_room_ids(floor_of(RIGHT, MIDDLE, LEFT), previous)) == [6, 5, 4]


def test_the_largest_part_of_a_split_room_keeps_its_id():
    previous = floor_of(LEFT, MIDDLE)
    assert ids_of(keep_room_ids(floor_of(box(4, 0, 6, 3), box(6, 0, 9, 3), LEFT), previous)) == [3, 2, 1]


def test_merged_rooms_get_the_id_of_the_largest():
    floor = keep_room_ids(floor_of(box(0, 0, 9, 3), RIGHT), floor_of(LEFT, MIDDLE, RIGHT))
    assert (ids_of(floor), floor.last_id) == ([2, 3], 3)


def test_a_part_of_one_room_never_gets_the_id_of_a_smaller_one():
    """The largest part of a room of 30 m² is merged with a closet of 3 m², and does not get the id of the closet."""
    previous = floor_of(box(0, 0, 10, 3), box(10, 0, 11, 3))
    assert ids_of(keep_room_ids(floor_of(box(0, 0, 4.8, 3), box(4.8, 0, 11, 3)), previous)) == [3, 1]


def test_a_room_beside_one_that_is_gone_does_not_get_its_id():
    previous = floor_of(LEFT, MIDDLE, RIGHT)
    assert ids_of(keep_room_ids(floor_of(LEFT, MIDDLE, box(11.8, 0, 15, 3)), previous)) == [1, 2, 4]


def test_an_id_is_never_given_twice():
    three = floor_of(LEFT, MIDDLE, RIGHT)
    two = keep_room_ids(floor_of(LEFT, MIDDLE), three)
    assert (ids_of(two), two.last_id) == ([1, 2], 3)
    three_again = keep_room_ids(floor_of(LEFT, MIDDLE, RIGHT), two)
    assert (ids_of(three_again), three_again.last_id) == ([1, 2, 4], 4)


@pytest.mark.parametrize("last_id", [0, 7])
def test_nothing_in_common_gives_new_ids_only(last_id):
    assert ids_of(keep_room_ids(floor_of(LEFT, MIDDLE), Floor((), last_id=last_id))) == [last_id + 1, last_id + 2]
    empty = keep_room_ids(Floor(()), floor_of(LEFT, last_id=last_id))
    assert (empty.rooms, empty.last_id) == ((), last_id or 1)


def test_doors_and_entrances_lead_to_the_same_rooms():
    doors = Door((1, 2), LINE, 1.0), Door((2, None), LINE, 0.9, "opening")
    new = replace(floor_of(LEFT, MIDDLE, doors=doors), possible_doors=(Door((1, 2), LINE, 0.8, probability=0.75),))
    floor = keep_room_ids(new, floor_of(MIDDLE, first_id=5))
    assert ids_of(floor) == [6, 5]
    assert floor.doors == (Door((5, 6), LINE, 1.0), Door((5, None), LINE, 0.9, "opening"))
    assert floor.possible_doors == (Door((5, 6), LINE, 0.8, probability=0.75),)


def test_a_label_stays_until_there_is_another():
    labels, probabilities = {"R/C": "ROOM", "school": "LAB"}, {"school": {"LAB": 0.7, "OFFICE": 0.3}}
    old_labels = labels, probabilities
    previous = Floor((Room(3, LEFT, "LAB", *old_labels), Room(4, MIDDLE, "OFFICE", *old_labels), Room(5, RIGHT)))
    floor = Floor((Room(1, LEFT), Room(2, MIDDLE, "HALL", partial=True), Room(3, RIGHT)), source="new")
    expected = Room(3, LEFT, "LAB", *old_labels), Room(4, MIDDLE, "HALL", partial=True), Room(5, RIGHT)
    assert keep_room_ids(floor, previous) == Floor(expected, source="new")


def test_a_name_stays_until_there_is_another():
    previous = Floor((Room(3, LEFT, name="1 French"), Room(4, MIDDLE, "OFFICE", name="Records"), Room(5, RIGHT)))
    floor = Floor((Room(1, LEFT), Room(2, MIDDLE, "HALL", name="Lobby"), Room(3, RIGHT, name="WC")))
    expected = Room(3, LEFT, name="1 French"), Room(4, MIDDLE, "HALL", name="Lobby"), Room(5, RIGHT, name="WC")
    assert keep_room_ids(floor, previous).rooms == expected


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(FLOOR_MAKERS))
@pytest.mark.parametrize("shift", [(0.3, -0.3), (1.0, 0), (-6.55, 3.1), (1e6, -3e5)])
def test_ids_stay_when_the_frame_has_moved(name, shift):
    previous = make_floor(name, seed=1)
    mixed = Floor(tuple(replace(room, id=99 - room.id) for room in move(previous, *shift).rooms))
    assert ids_of(keep_room_ids(mixed, previous)) == ids_of(previous)


def test_ids_stay_when_the_map_has_grown_and_its_frame_has_moved():
    """The first half of a floor, whose rooms are numbered from 30, then all of it."""
    complete = make_floor("l", seed=3)
    half = Floor(tuple(replace(room, id=room.id + 29) for room in complete.rooms[:11]))
    same_ids = ids_of(keep_room_ids(move(complete, 8.3, 5.2), half))
    assert same_ids == list(range(30, 41)) + list(range(41, 30 + len(complete.rooms)))


def test_a_shift_is_estimated_to_one_cell_with_its_share():
    polygons = np.array([LEFT, MIDDLE, RIGHT], dtype=object)
    shifted = np.array([shapely.affinity.translate(room, -7, 50) for room in polygons])
    motion, share = find_shift(shifted, polygons)
    assert motion.shift == pytest.approx((-7, 50))
    assert share == pytest.approx(1)
    assert measure_share(shifted, polygons) == 0
    motion, share = find_shift(polygons, polygons)
    assert (motion, share, measure_share(polygons, polygons)) == (Motion(), 1, 1)


@pytest.mark.parametrize("degrees", [15, 90, 171, 233])
def test_a_rotation_is_found_with_its_shift(degrees):
    previous = np.array([room.polygon for room in make_floor("l", seed=3).rooms])
    true = Motion(np.radians(degrees), (8.0, -3.0))
    motion, share = find_motion(true.move(previous), previous)
    corners = np.array([[0, 0], [40, 0], [40, 30]], float)
    assert motion.apply(corners) == pytest.approx(true.apply(corners), abs=0.3)
    assert share > 0.8


@pytest.mark.parametrize("degrees", [15, 90])
def test_ids_stay_when_the_robot_stood_in_another_direction(degrees):
    previous = make_floor("l", seed=3)
    turn = Motion(np.radians(degrees), (5.0, 2.0))
    turned = Floor(
        tuple(replace(room, id=99 - room.id, polygon=shapely.transform(room.polygon, turn.apply)) for room in previous)
    )
    assert ids_of(keep_room_ids(turned, previous)) == ids_of(previous)


def test_a_floor_of_another_building_is_refused():
    one, other = make_floor("l", seed=3), make_floor("ring", seed=8)
    assert find_frame_motion(one, one) == Motion()
    with pytest.raises(FloorError, match=r"of another building: \d+ % of its rooms"):
        find_frame_motion(one, other)


def test_a_frame_with_rooms_at_their_old_positions_is_not_shifted():
    """The first of three equal rooms is gone and a fourth is new; shifted by one room, all three would match."""
    row = [box(4 * i, 0, 4 * i + 4, 3) for i in range(4)]
    assert ids_of(keep_room_ids(floor_of(*row[1:]), floor_of(*row[:3]))) == [2, 3, 4]


def test_a_frame_is_not_shifted_for_one_more_common_wall():
    """Rooms observed to a third of their depth; shifted by a room, the end of the last would lie on a closet's wall."""
    previous = floor_of(*(box(left, 0, right, 1) for left, right in ((4, 8), (8, 12), (12, 15.2))))
    row = [box(left, 0, right, 3) for left, right in pairwise((0, 4, 8, 11.2, 12, 16))]
    polygons, old = (np.array([room.polygon for room in each.rooms]) for each in (floor_of(*row), previous))
    motion, share = find_shift(polygons, old)
    assert motion.shift[0] == pytest.approx(-4)
    assert 0 < share - measure_share(polygons, old) < 0.1
    assert ids_of(keep_room_ids(floor_of(*row), previous)) == [4, 1, 2, 5, 3]


def test_a_single_room_elsewhere_is_another_room():
    assert ids_of(keep_room_ids(floor_of(box(50, 50, 54, 53), box(54, 50, 60, 53)), floor_of(LEFT))) == [2, 3]


@pytest.mark.slow
@given(tilings())
def test_the_same_floor_stays_as_it_is(floor):
    assert keep_room_ids(floor, floor) == floor


@pytest.mark.slow
@settings(max_examples=EXAMPLES)
@given(tilings(), tilings())
def test_ids_are_unique_and_new_or_old(floor, previous):
    same_ids = keep_room_ids(floor, previous)
    new = [room_id for room_id in ids_of(same_ids) if room_id not in ids_of(previous)]
    assert new == list(range(previous.last_id + 1, same_ids.last_id + 1))
    assert len(set(ids_of(same_ids))) == len(floor.rooms)
    assert [room.polygon for room in same_ids.rooms] == [room.polygon for room in floor.rooms]


@pytest.mark.slow
@settings(max_examples=EXAMPLES)
@given(tilings(), tilings(), st.data())
def test_ids_do_not_depend_on_the_order_and_the_numbers_of_the_rooms(floor, previous, data):
    numbers = data.draw(st.permutations(range(1, len(floor.rooms) + 1)))
    renumbered = [replace(room, id=number) for room, number in zip(floor.rooms, numbers, strict=True)]
    shuffled = Floor(tuple(data.draw(st.permutations(renumbered))))
    one, other = keep_room_ids(floor, previous), keep_room_ids(shuffled, previous)
    polygons = [{room.id: room.polygon for room in each.rooms if room.id <= previous.last_id} for each in (one, other)]
    assert polygons[0] == polygons[1]
    assert sorted(ids_of(one)) == sorted(ids_of(other))
    assert ids_of(keep_room_ids(Floor(tuple(renumbered)), previous)) == ids_of(one)


@pytest.mark.slow
@given(tilings(), tilings())
def test_a_room_that_is_mostly_the_same_is_matched(floor, previous):
    """With any other rooms on the two floors."""
    polygons, old_polygons = (np.array([room.polygon for room in each.rooms], object) for each in (floor, previous))
    matches = match_rooms(polygons, old_polygons)
    for old, match, iou in zip(previous.rooms, matches.room, matches.iou, strict=True):
        shares = [share_of(room, old) for room in floor.rooms]
        assert iou == pytest.approx(shares[match] if match >= 0 else 0)
        assert all(index == match for index, share in enumerate(shares) if share > 0.5)


def share_of(room: Room, old: Room) -> float:
    """IoU of two rooms."""
    return float(room.polygon.intersection(old.polygon).area / room.polygon.union(old.polygon).area)


def check_similar_rooms_keep_ids(floor: Floor, previous: Floor) -> int:
    """The number of rooms with an IoU above 0.5 with a previous room; each of them must have its id."""
    similar = [(room.id, old.id) for room in floor.rooms for old in previous.rooms if share_of(room, old) > 0.5]
    assert all(new == old for new, old in similar)
    return len(similar)


@pytest.mark.slow
def test_ids_stay_while_a_real_map_grows(data: Path):
    folder = data / "partial" / "freiburg79"
    if not folder.is_dir():
        pytest.skip(f"no growing maps in {folder}")
    grids = [read_map(folder / f"r_{step:03}.png", resolution=0.05) for step in (10, 12, 15)]
    floors = [reconstruct(grid, method="thesis") for grid in grids]
    same_ids = [floors[0]]
    for floor in floors[1:]:
        same_ids.append(keep_room_ids(floor, same_ids[-1]))
        assert check_similar_rooms_keep_ids(same_ids[-1], same_ids[-2]) >= 10
        moved = keep_room_ids(move(floor, 12.35, -7.8), same_ids[-2])
        assert np.mean(np.array(ids_of(moved)) == ids_of(same_ids[-1])) == 1
    raw, scores = score_persistence(floors), score_persistence(same_ids)
    assert (scores.rooms, scores.persisting) == (raw.rooms, raw.persisting)
    assert scores.same_id_share > 2 * raw.same_id_share


def test_persistence_counts_rooms_that_last_and_ids_that_stay():
    """Left keeps its id, middle gets another, right is gone; then left is inside a larger room and middle halved."""
    floors = [
        floor_of(LEFT, MIDDLE, RIGHT),
        Floor((Room(1, LEFT), Room(7, MIDDLE))),
        Floor((Room(1, box(-9, 0, 4, 3)), Room(7, box(4, 0, 6.5, 3)))),
    ]
    assert score_persistence(floors) == Persistence(rooms=5, persisting=3, same_id=2)
    assert score_persistence(floors).persisting_share == pytest.approx(3 / 5)
    assert score_persistence(floors).same_id_share == pytest.approx(2 / 3)


@pytest.mark.parametrize("floors", [[], [floor_of(LEFT)], [Floor(()), floor_of(LEFT)]])
def test_persistence_of_nothing_is_perfect(floors):
    scores = score_persistence(floors)
    assert (scores.rooms, scores.persisting_share, scores.same_id_share) == (0, 1, 1)


def test_persistence_of_rooms_that_are_all_gone_is_none():
    assert score_persistence([floor_of(LEFT), Floor(())]) == Persistence(rooms=1, persisting=0, same_id=0)


def test_rooms_that_were_one_for_a_step_get_back_their_ids():
    """4 m × 3 m and 5 m × 3 m, then both as one, then apart again; the one room has the id of the larger."""
    two = floor_of(LEFT, MIDDLE)
    one = keep_room_ids(floor_of(box(0, 0, 9, 3)), two)
    assert ids_of(one) == [2]
    assert ids_of(keep_room_ids(floor_of(MIDDLE, LEFT), one)) == [2, 3]
    again = keep_room_ids(floor_of(MIDDLE, LEFT), one, earlier=[two])
    assert (ids_of(again), again.last_id) == ([2, 1], 2)


def test_a_room_that_was_two_for_a_step_gets_back_its_id():
    """The larger part of the room keeps id 1 for the step; then the smaller part grows and would be the larger one."""
    one = floor_of(box(0, 0, 9, 3))
    parts = replace(keep_room_ids(floor_of(MIDDLE, LEFT), one), last_id=7)
    assert ids_of(parts) == [1, 2]
    assert ids_of(keep_room_ids(floor_of(box(0, 0, 9, 3), RIGHT), parts, earlier=[one])) == [1, 8]


def test_the_newest_floor_with_the_outline_of_a_room_gives_its_id():
    """The room of 4 m × 3 m was number 1, then 5; in the previous floor it is a part of number 6."""
    floors = Floor((Room(6, box(0, 0, 9, 3)),)), Floor((Room(5, LEFT),)), Floor((Room(1, LEFT),))
    assert ids_of(keep_room_ids(floor_of(LEFT), floors[0], earlier=floors[1:])) == [5]


def test_a_room_that_has_grown_while_it_was_a_part_of_another_gets_back_its_id():
    """The second room has grown from 3 m × 3 m to 5 m × 3 m, so its outline is not the old one; the first one's is."""
    two, one = floor_of(LEFT, box(4, 0, 7, 3)), Floor((Room(1, box(0, 0, 9, 3)),), last_id=2)
    assert ids_of(keep_room_ids(floor_of(LEFT, MIDDLE), one, earlier=[two])) == [1, 2]


def test_an_id_of_an_earlier_floor_goes_to_one_room_only():
    """Number 1 is in both floors; its halves are cut as one room of the previous and one of the earlier floor."""
    earlier, previous = Floor((Room(1, LEFT),)), Floor((Room(1, MIDDLE), Room(2, RIGHT)))
    floor = keep_room_ids(floor_of(LEFT, MIDDLE, RIGHT), previous, earlier=[earlier])
    assert (ids_of(floor), floor.last_id) == ([3, 1, 2], 3)


def test_new_ids_follow_the_last_one_of_all_floors():
    floor = keep_room_ids(floor_of(LEFT), floor_of(RIGHT, last_id=4), earlier=[floor_of(RIGHT, last_id=9)])
    assert (ids_of(floor), floor.last_id) == ([10], 10)


def test_names_come_back_with_the_id():
    named, one = Floor((Room(1, LEFT, name="1 French"), Room(2, MIDDLE))), Floor((Room(2, box(0, 0, 9, 3)),))
    assert [room.name for room in keep_room_ids(floor_of(LEFT, MIDDLE), one, earlier=[named])] == ["1 French", None]


@given(tilings(), tilings())
def test_a_floor_has_its_ids_again_after_a_step_that_is_cut_differently(floor, cut_differently):
    """A hall beside the block is the same in all steps, so that the frame is known."""
    hall = Room(500, box(20, 0, 60, 20))
    floor, cut_differently = (
        replace(each, rooms=(hall, *each.rooms), last_id=500) for each in (floor, cut_differently)
    )
    between = keep_room_ids(cut_differently, floor)
    shuffled = Floor(tuple(replace(room, id=1000 - room.id) for room in floor.rooms))
    again = keep_room_ids(shuffled, between, earlier=[floor])
    assert ids_of(again) == ids_of(floor)


@pytest.mark.slow
@settings(max_examples=EXAMPLES)
@given(tilings(), tilings(), tilings())
def test_ids_are_unique_with_earlier_floors_and_new_ones_are_new(floor, previous, earlier):
    result = keep_room_ids(floor, previous, earlier=[earlier])
    old_ids = {*ids_of(previous), *ids_of(earlier)}
    assert len({*ids_of(result)}) == len(result.rooms)
    assert all(number in old_ids or number > max(previous.last_id, earlier.last_id) for number in ids_of(result))
    assert result.last_id == max([previous.last_id, earlier.last_id, *ids_of(result)])
