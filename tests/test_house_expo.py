"""HouseExpo JSONs become floors: boxes cut to rooms, and what they leave free."""

import json
import warnings
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import box, union_all

from pianta.errors import BuildingError, BuildingWarning
from pianta.floor import Floor
from pianta.io.buildings.house_expo import read_house_expo
from tests.mutation import mutated, refused_in_one_line

OUTLINE = [[0, 0], [10, 0], [10, 6], [0, 6]]


def house(categories: object, verts: object = OUTLINE) -> str:
    return json.dumps({"id": "a", "room_num": 9, "bbox": {"min": [0, 0]}, "verts": verts, "room_category": categories})


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("houses") / "a.json"


def read(path: Path, text: str) -> Floor:
    path.write_text(text)
    return read_house_expo(path)


def test_boxes_are_rooms_and_the_rest_has_no_label(path):
    """A corridor of 10 m × 1.2 m stays free above three rooms."""
    rooms = {"Living_Room": [[0, 0, 5, 4.8]], " bedroom": [[5, 0, 8, 4.8], [8, 0, 10, 4.8]]}
    floor = read(path, house(rooms))
    assert [(room.id, room.label) for room in floor.rooms] == [
        (1, "LIVING ROOM"),
        (2, "BEDROOM"),
        (3, "BEDROOM"),
        (4, None),
    ]
    shapes = box(0, 0, 5, 4.8), box(5, 0, 8, 4.8), box(8, 0, 10, 4.8), box(0, 4.8, 10, 6)
    for room, shape in zip(floor.rooms, shapes, strict=True):
        assert room.polygon.symmetric_difference(shape).area < 1e-9
    assert (floor.doors, floor.source, floor.building_type) == ((), "a.json", {})


def test_the_smaller_of_overlapping_boxes_wins_and_the_largest_part_stays(path):
    """A bathroom of 2 m × 6 m cuts the hall into 6 m and 2 m; the 2 m become a room without a label."""
    floor = read(path, house({"Hall": [[0, 0, 10, 6]], "Bathroom": [[6, 0, 8, 6]]}))
    assert [(room.label, round(room.polygon.area, 6)) for room in floor.rooms] == [
        ("HALL", 36),
        ("BATHROOM", 12),
        (None, 12),
    ]


def test_of_equal_boxes_the_first_wins(path):
    floor = read(path, house({"B": [[0, 0, 6, 6]], "A": [[4, 0, 10, 6]]}))
    assert [(room.label, room.polygon.area) for room in floor.rooms] == [("B", 36), ("A", 24)]


def test_a_box_under_several_labels_is_one_room_with_the_first(path):
    floor = read(path, house({" ": [[0, 0, 10, 6]], "Kitchen": [[0, 0, 10, 6]], "Dining": [[0, 0, 10, 6]]}))
    assert [room.label for room in floor.rooms] == ["KITCHEN"]


def test_boxes_are_cut_at_the_outline(path):
    floor = read(path, house({"Hall": [[-3, -3, 20, 20]]}, [[0, 0], [10, 0], [10, 3], [5, 3], [5, 6], [0, 6]]))
    assert [room.polygon.area for room in floor.rooms] == [45]


def test_gaps_narrower_than_half_a_metre_and_nooks_are_no_rooms(path):
    """0.4 m along the wall; 0.9 m × 0.9 m in the corner."""
    floor = read(path, house({"Hall": [[0.4, 0, 9.1, 6]], "Closet": [[9.1, 0.9, 10, 6]]}))
    assert [room.label for room in floor.rooms] == ["HALL", "CLOSET"]


def test_a_house_without_boxes_is_one_room(path):
    (room,) = read(path, house({})).rooms
    assert (room.label, room.polygon.area) == (None, 60)


@pytest.mark.parametrize(
    ("boxes", "message"),
    [
        ([[3, 3, 3, 5]], "LAB"),
        ([[5, 0, 3, 5]], "LAB"),
        ([[20, 0, 30, 5]], "LAB"),
        (
            [[0, 0, 4, 4], [0, 0, 4, 2], [0, 2, 4, 4]],
            "LAB",
        ),
    ],
)
def test_boxes_that_are_no_rooms_are_left_out(path, boxes, message):
    with pytest.warns(BuildingWarning, match=message):
        floor = read(path, house({"Lab": boxes}))
    assert len([room for room in floor.rooms if room.label]) == len(boxes) - 1


def test_an_outline_that_meets_itself_keeps_its_largest_part(path):
    """The corner at (5, -5) ties a loop of half a square metre."""
    verts = [[0, 0], [4, 0], [5, -1], [4, -1], [5, 0], [10, 0], [10, 6], [0, 6]]
    with pytest.warns(BuildingWarning, match=r"\boutline\b"):
        (room,) = read(path, house({}, verts)).rooms
    assert room.polygon.symmetric_difference(box(0, 0, 10, 6)).area < 0.26


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (house({}, [[0, 0], [1, 0]]), "verts"),
        (house({}, [[0, 0], [1, 0], [0, "1"]]), r"verts\[2\]\[1\]"),
        (house({}, [[0, 0], [1, 0], [0, 1e5]]), r"verts\[2\]\[1\]"),
        (house({}, [[0, 0], [1, 0], [0, float("nan")]]), r"verts\[2\]\[1\]"),
        (house({}, [[0, 0]] * 2001), "verts"),
        (house({}, [[0, 0], [5, 0], [9, 0]]), "area"),
        (house({}, [[0, 0], [0.5, 0], [0, 0.5]]), "rooms"),
        (house({"Lab": [[0, 0, 1]]}), r"room_category.Lab\[0\]\[3\]"),
        (
            house({"Lab": [[n, 0, n + 1, 1] for n in range(501)], "Hall": [[n, 1, n + 1, 2] for n in range(501)]}),
            "1002",
        ),
        (house([]), "room_category"),
        ('{"verts": []}', "room_category"),
        ('{"verts": [', "JSON"),
        ("[" * 100_000, "JSON"),
        ('{"a": 1, "b": 2}', "a, b"),
        ("[1]", "JSON"),
        ("<MITquest/>", "MIT"),
    ],
)
def test_what_is_no_house_is_refused(path, text, message):
    with pytest.raises(BuildingError, match=message):
        read(path, text)


def test_a_byte_order_mark_is_no_content(path):
    path.write_bytes(b"\xef\xbb\xbf" + house({}).encode())
    assert len(read_house_expo(path).rooms) == 1


@given(content=st.binary() | mutated(house({"Lab": [[0, 0, 5, 5]], "Hall": [[4, 0, 10, 6]]}).encode()))
def test_a_damaged_file_is_read_or_refused(path, content):
    path.write_bytes(content)
    with refused_in_one_line(), warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        assert isinstance(read_house_expo(path), Floor)


coordinate = st.floats(-2, 12) | st.sampled_from([0, 1e-9, 5, 5.000001, 10, 6])


@pytest.mark.slow
@given(boxes=st.lists(st.tuples(coordinate, coordinate, coordinate, coordinate), max_size=8))
def test_rooms_never_overlap_and_stay_in_the_outline(path, boxes):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        floor = read(path, house({"Lab": boxes}))
    shapes = [room.polygon for room in floor.rooms]
    assert sum(shape.area for shape in shapes) == pytest.approx(union_all(shapes).area, abs=1e-6)
    assert union_all(shapes).difference(box(0, 0, 10, 6)).area < 1e-9
