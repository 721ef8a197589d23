"""KTH XMLs are read as floors in metres, with one door for the portals of two rooms."""

import warnings
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import box, get_coordinates

from pianta.errors import BuildingError, BuildingWarning
from pianta.floor import Floor
from pianta.io.buildings.kth_xml import read_kth_xml
from tests.mutation import mutated, refused_in_one_line

# 20 units are a metre. An office of 5 m × 4 m, a wall of 0.2 m, and a corridor of 10 m × 2 m below.
OFFICE = [(0, 0), (100, 0), (100, 80), (0, 80)]
CORRIDOR = [(0, 84), (200, 84), (200, 124), (0, 124)]
# 1 m of the wall, in both rooms.
OFFICE_DOOR = (60, 80), (40, 80)
CORRIDOR_DOOR = (40, 84), (60, 84)

Point = tuple[object, object]


def segment(start: Point, end: Point, target: str | None = None, type_: str = "Wall") -> str:
    ends = f'x1="{start[0]}" y1="{start[1]}" x2="{end[0]}" y2="{end[1]}"'
    return f'<linesegment {ends} type="{type_ if target is None else "Portal"}" target="{target or ""}"/>'


def space(name: str, type_: str, corners: Sequence[Point], *doors: str, portals: str = "") -> str:
    """The doors replace the third edge."""
    edges = [segment(start, end) for start, end in zip(corners, [*corners[1:], corners[0]], strict=True)]
    edges[2:3] = doors or edges[2:3]
    contour = f'<contour><centroid x="0" y="0"/>{"".join(edges)}</contour>'
    return f'<space name="{name}" type="{type_}">{contour}{portals}</space>'


def floor_xml(*spaces: str, scale: str = 'PixelDistance="100" RealDistance="5"') -> str:
    names = 'BuildingName="0510" FloorName="2"'
    return f'<?xml version="1.0"?><floor {names}><Domain name="KTH"/><Scale {scale}/>{"".join(spaces)}</floor>'


def office(*doors: str, portals: str = "") -> str:
    doors = doors or (segment((100, 80), OFFICE_DOOR[0]), segment(*OFFICE_DOOR, "K"), segment(OFFICE_DOOR[1], (0, 80)))
    return space("A", "Kontor", OFFICE, *doors, portals=portals)


def corridor(*doors: str, portals: str = "") -> str:
    """The corners start so that the third edge is the wall to the office."""
    corners = [CORRIDOR[2], CORRIDOR[3], CORRIDOR[0], CORRIDOR[1]]
    doors = doors or (segment((0, 84), (40, 84)), segment(*CORRIDOR_DOOR, "A"), segment((60, 84), (200, 84)))
    return space("K", " korridor ", corners, *doors, portals=portals)


TWO_ROOMS = floor_xml(office(portals='<portal target="K"/>'), corridor(portals='<portal target="A"/>'))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("kth") / "0510_2.xml"


def read(path: Path, text: str) -> Floor:
    path.write_text(text)
    return read_kth_xml(path)


def test_two_rooms_in_metres_with_one_door_within_the_wall(path):
    floor = read(path, TWO_ROOMS)
    assert [(room.id, room.label) for room in floor.rooms] == [(1, "KONTOR"), (2, "KORRIDOR")]
    assert floor.rooms[0].polygon.symmetric_difference(box(0, -4, 5, 0)).area < 1e-9
    assert floor.rooms[1].polygon.symmetric_difference(box(0, -6.2, 10, -4.2)).area < 1e-9
    (door,) = floor.doors
    assert (door.rooms, door.kind) == ((1, 2), "door")
    assert door.width == pytest.approx(1)
    assert sorted(get_coordinates(door.line).tolist()) == [pytest.approx([2, -4.1]), pytest.approx([3, -4.1])]
    assert (floor.source, floor.building_type) == ("0510_2.xml", {})


def test_a_door_of_one_room_only_is_at_its_segment(path):
    floor = read(path, floor_xml(office(), corridor(segment((0, 84), (200, 84)))))
    assert get_coordinates(floor.doors[0].line)[:, 1] == pytest.approx(np.array([-4, -4]))


def test_two_doors_between_the_same_rooms_are_two(path):
    """The corridor draws its sides in the other order; the second door is 0.5 m in one room and 1 m in the other."""
    office_segments = [segment((100, 80), (90, 80), "K"), segment((90, 80), (60, 80)), segment(*OFFICE_DOOR, "K")]
    corridor_segments = [segment(*CORRIDOR_DOOR, "A"), segment((60, 84), (85, 84)), segment((85, 84), (105, 84), "A")]
    floor = read(path, floor_xml(office(*office_segments), corridor(*corridor_segments)))
    assert sorted((door.line.centroid.x, door.width) for door in floor.doors) == [
        pytest.approx((2.5, 1)),
        pytest.approx((4.75, 0.5)),
    ]


def test_sides_far_from_each_other_are_two_doors(path):
    floor = read(path, floor_xml(office(segment((100, 80), (80, 80), "K")), corridor()))
    assert sorted(door.line.centroid.x for door in floor.doors) == pytest.approx([2.5, 4.5])


def test_a_point_is_a_door_of_90_cm_along_the_wall(path):
    floor = read(path, floor_xml(office(segment((50, 80), (50, 80), "K")), corridor(segment((0, 84), (200, 84)))))
    ends = sorted(get_coordinates(floor.doors[0].line).tolist())
    assert ends == [pytest.approx([2.05, -4]), pytest.approx([2.95, -4])]


def test_a_target_without_a_segment_goes_to_the_middle_of_the_wall(path):
    text = floor_xml(
        office(segment((100, 80), (0, 80)), portals='<portal target="K"/>'),
        corridor(segment((0, 84), (200, 84)), portals='<portal target="A"/>'),
    )
    with pytest.warns(BuildingWarning, match="KONTOR"):
        floor = read(path, text)
    (door,) = floor.doors
    assert door.line.centroid.coords[0] == pytest.approx((2.5, -4), abs=0.1)
    assert door.width == pytest.approx(0.9)


@pytest.mark.parametrize("target", ["", "A", "9999"])
def test_a_portal_to_no_other_room_is_left_out(path, target):
    text = floor_xml(office(segment((100, 80), (0, 80), target)), corridor(segment((0, 84), (200, 84))))
    with pytest.warns(BuildingWarning, match="KONTOR"):
        assert read(path, text).doors == ()


def test_segments_with_gaps_are_bridged(path):
    edges = [segment((0, 0), (90, 0)), segment((100, 0), (100, 80), type_="Window"), segment((95, 80), (0, 80))]
    text = floor_xml(f'<space name="A" type=""><contour>{"".join(edges)}</contour></space>')
    (room,) = read(path, text).rooms
    assert (room.label, room.polygon.area) == (None, pytest.approx(20))


def test_a_room_that_no_door_leads_to_is_reported(path):
    alone = space("C", "TRAPP", [(300, 0), (400, 0), (400, 80), (300, 80)])
    with pytest.warns(BuildingWarning, match="TRAPP"):
        read(path, floor_xml(office(), corridor(), alone))


@pytest.mark.parametrize(
    ("stray", "message"),
    [
        ('<space name="B" type="TRAPP"/>', "area"),
        (space("B", "TRAPP", [(300, 0), (400, 0), (350, 0)]), "area"),
        (space("B", "TRAPP", [(300, 0), ("nan", 0), (350, 80)]), "'nan'"),
        (office(), r"\(KONTOR\) is a copy of room 1"),
    ],
)
def test_a_room_that_cannot_be_read_is_left_out_and_the_others_stay(path, stray, message):
    with pytest.warns(BuildingWarning, match=f"without some of its rooms: room 3.*{message}"):
        floor = read(path, floor_xml(office(), corridor(), stray))
    assert [room.id for room in floor] == [1, 2]
    assert [door.rooms for door in floor.doors] == [(1, 2)]


def test_rooms_of_one_name_both_stay_with_the_doors_that_they_list(path):
    with pytest.warns(BuildingWarning, match=r"2 rooms have the name 'A'"):
        floor = read(
            path, TWO_ROOMS.replace("</floor>", space("A", "TRAPP", [(0, 200), (9, 200), (9, 300)]) + "</floor>")
        )
    assert [room.id for room in floor] == [1, 2, 3]
    assert [door.rooms for door in floor.doors] == [(1, 2)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (floor_xml(), "rooms"),
        (floor_xml(office(segment((100, 80), ("nan", 80)))), "nan"),
        (floor_xml(office(segment((100, 80), ("1e7", 80)))), "1e7"),
        (floor_xml(office(), scale='PixelDistance="0" RealDistance="5"'), "PixelDistance"),
        (floor_xml(office(), scale='RealDistance="inf"'), "inf"),
        (floor_xml('<space name="A"/>'), "area"),
        (floor_xml(office(*[segment((50, 80), (50, 80), "K")] * 101), corridor()), "100"),
        (floor_xml(office(portals='<portal target="K"/>' * 20000), corridor()), "20002"),
        ("<building/>", "layout"),
        ('<!DOCTYPE f [<!ENTITY e "e">]><floor>&e;</floor>', "entities"),
        (TWO_ROOMS[:-3], "XML"),
    ],
)
def test_files_without_a_floor_are_refused(path, text, message):
    with pytest.raises(BuildingError, match=message):
        read(path, text)


@given(content=st.binary() | mutated(TWO_ROOMS.encode()))
def test_a_damaged_file_is_read_or_refused(path, content):
    path.write_bytes(content)
    with refused_in_one_line(), warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        assert isinstance(read_kth_xml(path), Floor)


coordinate = st.sampled_from([0, 1e-9, 0.1, 40, 60, 80, 84, -10, 1e6, -1e6, 1e-300])
corner = st.tuples(coordinate, coordinate)


@pytest.mark.slow
@given(corners=st.lists(corner, min_size=3, max_size=6), door=st.tuples(corner, corner))
def test_any_outline_and_door_is_read_or_refused(path, corners, door):
    text = floor_xml(space("A", "", corners, segment(door[0], door[1], "K")), corridor())
    with suppress(BuildingError), warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        floor = read(path, text)
        assert (len(floor.rooms), len(floor.doors)) in {(2, 1), (2, 2), (1, 0)}
        assert all(door.width > 0 for door in floor.doors)
