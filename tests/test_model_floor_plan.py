"""Repeated groups of rooms: known answers, and independence of how a floor lies on its map."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon, affinity, box

from pianta import find_model_floor_plan, make_world
from pianta.errors import FloorError, OptionError
from pianta.floor import Door, Floor, Room
from pianta.patterns._correspondences import fit_motion
from pianta.patterns._room_table import build_room_table, find_corridors
from pianta.patterns.model_floor_plan import Motion, Pattern
from pianta.plot.model_floor_plan import plot_model_floor_plan

Shape = TypeVar("Shape", Polygon, LineString)
# m: no two of these widths are alike.
SMALL, MEDIUM, WIDE = 3.0, 4.5, 7.0


def make_wing(widths: Sequence[float], labels: Sequence[str] | None = None, *, first: int = 1) -> Floor:
    """Rooms of 6 m depth in a row, above a corridor of 2 m, each with a door to it; the corridor is the last room."""
    starts = np.cumsum([0.0, *widths])
    names = labels or ["OFFICE"] * len(widths)
    rooms = [
        Room(number, box(start, 2, end, 8), name)
        for number, ((start, end), name) in enumerate(zip(pairwise(starts), names, strict=True), start=first)
    ]
    corridor = Room(first + len(widths), box(0, 0, starts[-1], 2), "CORRIDOR")
    doors = tuple(
        Door((room.id, corridor.id), LineString([(x - 0.5, 2), (x + 0.5, 2)]), 1.0)
        for room in rooms
        for x in [room.polygon.centroid.x]
    )
    return Floor((*rooms, corridor), doors)


def list_rooms(patterns: Sequence[Pattern]) -> list[list[tuple[int, ...]]]:
    return [[each.rooms for each in pattern.occurrences] for pattern in patterns]


def test_a_sequence_that_comes_three_times():
    # SMALL MEDIUM WIDE three times: 9 rooms and the corridor, of which 2 · 3 follow from the first three.
    floor = make_wing([SMALL, MEDIUM, WIDE] * 3)
    plan = find_model_floor_plan(floor, shuffles=0)
    assert list_rooms(plan.patterns) == [[(1, 2, 3), (4, 5, 6), (7, 8, 9)]]
    (pattern,) = plan.patterns
    assert (pattern.name, pattern.kind, pattern.saved, pattern.rooms) == ("A", "row", 6, 9)
    motions = [each.motion for each in pattern.occurrences[1:] if each.motion]
    assert [(motion.name, motion.shift) for motion in motions] == [("moved", (14.5, 0.0)), ("moved", (29.0, 0.0))]
    assert [motion.overlap for motion in motions] == pytest.approx([1, 1])
    assert (plan.rooms, plan.repeated, plan.saved, plan.model_rooms) == (10, 0.9, 0.6, 4)
    # 9 rooms of 6 m depth along 43.5 m, and a corridor of 2 m.
    assert (plan.area, plan.repeated_area) == pytest.approx((8 * 43.5, 6 * 43.5))


def test_a_mirrored_sequence():
    floor = make_wing([SMALL, MEDIUM, WIDE, 10.0, WIDE, MEDIUM, SMALL])
    plan = find_model_floor_plan(floor, shuffles=0)
    assert list_rooms(plan.patterns) == [[(1, 2, 3), (7, 6, 5)]]
    motion = plan.patterns[0].occurrences[1].motion
    assert motion
    # The axis is at 19.5 m. Rectangles on one line are also taken there by a half turn, but not these: it would lift
    # them off their row; the centroids are on a line, so that a half turn about (19.5, 5) does as well.
    assert motion.name == "turned by 180°"
    assert motion.overlap == pytest.approx(1)


def test_rooms_on_both_sides_of_the_axis_are_mirrored_only_when_a_turn_does_not_do():
    # An L-shaped room and a square beside it, and their mirror images: no rotation takes the L onto its image.
    shape = box(0, 0, 6, 6).difference(box(3, 3, 6, 6))
    rooms = [shape, box(6, 0, 10, 6)]
    mirrored = [affinity.scale(each, -1, 1, origin=Point(12, 0)) for each in rooms]
    floor = Floor(tuple(Room(number, each) for number, each in enumerate([*rooms, *mirrored], start=1)))
    plan = find_model_floor_plan(floor, shuffles=0)
    assert list_rooms(plan.patterns) == [[(1, 2), (3, 4)]]
    motion = plan.patterns[0].occurrences[1].motion
    assert motion
    assert (motion.name, motion.mirrored, motion.angle) == ("mirrored", True, 90)


def test_a_pattern_within_a_pattern():
    # Fig. 4.2: C = (SMALL, MEDIUM) twice and WIDE are B, which is twice in A; 10 rooms, 5 follow from B, 2 in B from C.
    floor = make_wing([SMALL, MEDIUM, SMALL, MEDIUM, WIDE, 10.0, 12.5, SMALL, MEDIUM, SMALL, MEDIUM, WIDE])
    plan = find_model_floor_plan(floor, shuffles=0)
    # C four times saves 6 rooms, more than B twice, which saves 5.
    assert list_rooms(plan.patterns)[0] == [(1, 2), (3, 4), (8, 9), (10, 11)]
    floor = make_wing([SMALL, MEDIUM, SMALL, MEDIUM, WIDE, 9.0, 10.9, 13.2] * 2)
    plan = find_model_floor_plan(floor, shuffles=0)
    assert list_rooms(plan.patterns) == [[(1, 2, 3, 4, 5, 6, 7, 8), (9, 10, 11, 12, 13, 14, 15, 16)]]
    assert list_rooms(plan.patterns[0].inner) == [[(1, 2), (3, 4)]]
    assert plan.patterns[0].inner[0].name == "A.1"
    assert (plan.patterns[0].saved, plan.saved) == (8 + 2, 10 / 17)


def test_labels_must_agree_unless_they_do_not_count():
    widths = [SMALL, MEDIUM, WIDE] * 2
    floor = make_wing(widths, ["OFFICE"] * 3 + ["KITCHEN"] * 3)
    assert find_model_floor_plan(floor, shuffles=0).patterns == ()
    assert list_rooms(find_model_floor_plan(floor, labels=False, shuffles=0).patterns) == [[(1, 2, 3), (4, 5, 6)]]
    some = [replace(room, label=None) if room.id in {4, 5, 6} else room for room in floor.rooms]
    unlabelled = find_model_floor_plan(replace(floor, rooms=tuple(some)), shuffles=0)
    assert list_rooms(unlabelled.patterns) == [[(1, 2, 3), (4, 5, 6)]]


def test_a_sequence_along_a_bend_is_found_by_its_order():
    # The rooms of the second wing are 13 % wider: ln 1.13 = 0.122, above the 0.12 of a motion, below the 0.2 of a row.
    straight = make_wing([SMALL, MEDIUM, WIDE])
    stretched = make_wing([1.13 * SMALL, 1.13 * MEDIUM, 1.13 * WIDE], first=5)
    moved = move_floor(stretched, angle=70, shift=(60, 10))
    floor = Floor((*straight.rooms, *moved.rooms), (*straight.doors, *moved.doors))
    (pattern,) = find_model_floor_plan(floor, shuffles=0).patterns
    assert [each.rooms for each in pattern.occurrences] == [(1, 2, 3), (5, 6, 7)]
    assert pattern.kind == "row"
    motion = pattern.occurrences[1].motion
    assert motion
    assert motion.angle == pytest.approx(70, abs=1)


def test_storeys_repeat_each_other():
    ground = make_wing([SMALL, MEDIUM, WIDE])
    upper = move_floor(ground, angle=0, shift=(1000, -3))
    plan = find_model_floor_plan([ground, upper], shuffles=0)
    (pattern,) = plan.patterns
    assert [(each.storey, each.rooms) for each in pattern.occurrences] == [(0, (1, 2, 3, 4)), (1, (1, 2, 3, 4))]
    assert (plan.rooms, plan.saved) == (8, 0.5)
    alone = [find_model_floor_plan(each, shuffles=0).patterns for each in (ground, upper)]
    assert alone == [(), ()]


def test_shuffled_rooms_repeat_less():
    # Twelve rooms of twelve widths, twice: shuffled, they seldom stand in the same order again.
    widths = [2.5 * 1.17**step for step in range(12)]
    plan = find_model_floor_plan(make_wing(widths * 2), shuffles=20)
    assert plan.saved == 12 / 25
    assert plan.chance
    assert plan.chance.shuffles == 20
    assert plan.chance.below == 1
    assert plan.chance.saved < 0.2
    assert plan.chance.saved_sd > 0
    assert find_model_floor_plan(make_wing(widths * 2), shuffles=20) == plan
    assert find_model_floor_plan(make_wing(widths * 2), shuffles=20, seed=1) != plan


def test_rooms_of_one_label_that_are_equal_stay_when_they_are_shuffled_among_themselves():
    floor = make_wing([SMALL, MEDIUM, WIDE] * 3, ["CLOSET", "OFFICE", "KITCHEN"] * 3)
    plan = find_model_floor_plan(floor, shuffles=5, within_labels=True)
    assert plan.chance
    assert (plan.chance.saved, plan.chance.saved_sd, plan.chance.below) == (0.6, 0, 0)


def move_floor(
    floor: Floor, *, angle: float, shift: tuple[float, float], scale: float = 1, mirror: bool = False
) -> Floor:
    def move(shape: Shape) -> Shape:
        scaled = affinity.scale(shape, -scale if mirror else scale, scale, origin=(0, 0))
        return affinity.translate(affinity.rotate(scaled, angle, (0, 0)), *shift)

    rooms = tuple(replace(room, polygon=move(room.polygon)) for room in floor.rooms)
    doors = tuple(replace(door, line=move(door.line), width=door.width * scale) for door in floor.doors)
    return replace(floor, rooms=rooms, doors=doors)


WORLDS = {name: make_world(name, seed=1)[0] for name in ("l", "depot")}


@pytest.mark.slow
@pytest.mark.parametrize("name", WORLDS)
@settings(max_examples=8, deadline=None)
@given(
    st.floats(0, 360),
    st.tuples(st.floats(-200, 200), st.floats(-200, 200)),
    st.sampled_from([0.5, 1, 3]),
    st.booleans(),
)
def test_patterns_do_not_depend_on_orientation(name, angle, shift, scale, mirror):
    plan = find_model_floor_plan(WORLDS[name], shuffles=2)
    assert plan.patterns
    moved = find_model_floor_plan(
        move_floor(WORLDS[name], angle=angle, shift=shift, scale=scale, mirror=mirror), shuffles=2
    )
    assert list_rooms(moved.patterns) == list_rooms(plan.patterns)
    assert moved.chance == plan.chance


@settings(max_examples=30, deadline=None)
@given(st.lists(st.sampled_from([SMALL, MEDIUM, WIDE]), min_size=1, max_size=10))
def test_every_plan_is_consistent(widths):
    floor = make_wing(widths)
    plan = find_model_floor_plan(floor, shuffles=0)
    rooms = [room for pattern in plan.patterns for each in pattern.occurrences for room in each.rooms]
    assert len(rooms) == len(set(rooms))
    assert set(rooms) <= {room.id for room in floor}
    assert 0 <= plan.saved <= plan.repeated <= 1
    areas = {room.id: room.polygon.area for room in floor}
    for pattern in plan.patterns:
        first, *others = pattern.occurrences
        assert others
        for other in others:
            for one, two in zip(first.rooms, other.rooms, strict=True):
                assert np.log(areas[one] / areas[two]) == pytest.approx(0, abs=0.2)


@pytest.mark.parametrize(
    ("turned", "name"),
    [(0, "moved"), (2, "moved"), (92, "turned by 90°"), (359, "moved"), (45, "turned by 45°")],
)
def test_names_of_motions(turned, name):
    cos, sin = np.cos(np.radians(turned)), np.sin(np.radians(turned))
    assert Motion(((cos, -sin), (sin, cos)), (0, 0), 1).name == name


def test_fitted_motions():
    start = np.array([[0.0, 0], [4, 0], [0, 1]])
    quarter = np.array([[0.0, -1], [1, 0]])
    matrix, shift = fit_motion(start, start @ quarter.T + (3, 5), mirrored=False)
    assert matrix == pytest.approx(quarter)
    assert shift == pytest.approx([3, 5])
    flip = np.diag([1.0, -1.0])
    matrix, shift = fit_motion(start, start @ flip, mirrored=True)
    assert matrix == pytest.approx(flip)
    assert shift == pytest.approx([0, 0])


def test_corridors_by_label_and_by_doors():
    labels = ["OFFICE", "CONNECTION", "ROOM", "HALL", "GALLERY", None, None]
    rooms = [Room(number, box(3 * number, 0, 3 * number + 3, 5), label) for number, label in enumerate(labels, start=1)]
    # Room 7 has four doors, room 6 has three; GALLERY is in no schema and has none.
    doors = [Door((6, number), LineString([(0, 0), (0, 1)]), 1.0) for number in (1, 2)]
    doors += [Door((7, number), LineString([(0, 0), (0, 1)]), 1.0) for number in (1, 2, 3, 6)]
    rooms.append(Room(8, box(0, 9, 3, 12), "x", labels={"R/C": "CORRIDOR"}))
    corridors = find_corridors(Floor(tuple(rooms), tuple(doors)))
    assert corridors.tolist() == [False, True, False, True, False, False, True, True]


def test_rows_run_along_each_side_of_a_corridor():
    # Doors at x = 1, 4, 7 in the upper wall and 2, 5 in the lower one, and one at the end.
    corridor = Room(9, box(0, 0, 9, 2), "CORRIDOR")
    above = [Room(n, box(x - 1, 2, x + 2, 6)) for n, x in ((1, 1), (2, 4), (3, 7))]
    below = [Room(4, box(0, -4, 4, 0)), Room(5, box(4, -4, 9, 0))]
    end = Room(6, box(9, -1, 12, 3))
    points = [(9, 1, 1, 2), (9, 2, 4, 2), (9, 3, 7, 2), (9, 4, 2, 0), (9, 5, 5, 0)]
    doors = [Door((a, b), LineString([(x - 0.4, y), (x + 0.4, y)]), 0.8) for a, b, x, y in points]
    doors.append(Door((9, 6), LineString([(9, 0.6), (9, 1.4)]), 0.8))
    table = build_room_table([Floor((*above, *below, end, corridor), tuple(doors))], labels=True)
    rows = [table.ids[rooms].tolist() for rooms, _ in table.rows]
    # The outline of the corridor is counter-clockwise.
    assert sorted(rows) == [[3, 2, 1], [4, 5]]


@pytest.mark.parametrize("rooms", [(Room(1, box(0, 0, 3, 3)),), (Room(1, box(0, 0, 3, 3)), Room(2, box(3, 0, 6, 3)))])
def test_too_few_rooms_for_a_pattern(rooms):
    plan = find_model_floor_plan(Floor(rooms), shuffles=3)
    assert (plan.patterns, plan.repeated, plan.saved, plan.model_rooms) == ((), 0, 0, len(rooms))
    assert plan.chance
    assert (plan.chance.saved, plan.chance.below) == (0, 0)


def test_a_floor_without_rooms_is_refused():
    with pytest.raises(FloorError, match="no rooms"):
        find_model_floor_plan(Floor(()))
    with pytest.raises(FloorError, match="no rooms"):
        find_model_floor_plan([])
    empty_storey = find_model_floor_plan([Floor(()), make_wing([SMALL, MEDIUM] * 2)], shuffles=0)
    assert list_rooms(empty_storey.patterns) == [[(1, 2), (3, 4)]]
    assert empty_storey.patterns[0].occurrences[0].storey == 1


@pytest.mark.parametrize("floor", ["floor.geojson", 5, [make_wing([SMALL]), None]])
def test_what_is_no_floor_is_refused(floor):
    with pytest.raises(OptionError, match=r"floor= is a (str|int|NoneType), give a Floor"):
        find_model_floor_plan(floor)


def test_negative_shuffles_are_refused():
    with pytest.raises(OptionError, match="shuffles is -1"):
        find_model_floor_plan(make_wing([SMALL]), shuffles=-1)


def test_corresponding_rooms_have_one_colour_in_the_picture():
    floor = make_wing([SMALL, MEDIUM, WIDE] * 2)
    ax = plot_model_floor_plan(floor, find_model_floor_plan(floor, shuffles=0))
    colors = [patch.get_facecolor() for patch in ax.patches[: len(floor)]]
    assert colors[:3] == colors[3:6]
    assert len(set(colors)) == 4
    assert {text.get_text() for text in ax.texts} >= {"A1", "A2"}
