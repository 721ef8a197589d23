"""MIT XMLs are read as floors in metres from their own corner, with one door for the portals of two rooms."""

import warnings
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import box, get_coordinates

from pianta.errors import BuildingError, BuildingWarning, OptionError
from pianta.floor import Floor
from pianta.io.buildings.mit_xml import read_mit_xml
from tests.mutation import mutated, refused_in_one_line

FOOT = 0.3048006096
EAST, NORTH = 709_000, 495_000
# In feet from a corner in the state plane: an office, a corridor along it, and a narrower continuation of the corridor.
OFFICE = [(0, 0), (20, 0), (20, 10), (0, 10)]
CORRIDOR = [(0, 10), (30, 10), (30, 16), (0, 16)]
FURTHER = [(30, 12), (50, 12), (50, 16), (30, 16)]

Point = tuple[object, object]


def portal(target: str, *edges: tuple[object, object], source: str = "", **kinds: str) -> str:
    """Horizontal and explicit, unless class_ and type say otherwise."""
    kinds = {"class": kinds.get("class_", "horizontal"), "type": kinds.get("type", "explicit")}
    names = "".join(f'{name}="{value}" ' for name, value in {**kinds, "source": source, "target": target}.items())
    positions = "".join(f'<edge index="{index}" param="{param}"/>' for index, param in edges)
    return f"<portal {names.replace('source=' + chr(34) * 2, '')}>{positions}</portal>"


def space(name: str, type_: str, corners: Sequence[Point], *portals: str, closed: bool = True) -> str:
    moved = [
        (EAST + x, NORTH + y) if isinstance(x, int | float) and isinstance(y, int | float) else (x, y)
        for x, y in corners
    ]
    points = "".join(f'<point x="{x}" y="{y}"/>' for x, y in moved + moved[:closed])
    contour = f'<contour><centroid x="0" y="0"/><extent maxx="0"/>{points}</contour>'
    return f'<space name="{name}" type="{type_}">{contour}{"".join(portals)}</space>'


def mit_xml(*spaces: str) -> str:
    return f'<?xml version="1.0"?><MITquest><floor name="FLOORCONTOUR">{"".join(spaces)}</floor></MITquest>'


# The door is 5 ft along the wall from the west: edge 2 of the office runs west, edge 0 of the corridor east.
TO_CORRIDOR = portal("1-C", (2, 0.75), source="1-A")
TO_OFFICE = portal("1-A", (0, 5 / 30), source="1-C")
TWO_ROOMS = mit_xml(space("1-A", "OFF", OFFICE, TO_CORRIDOR), space("1-C", "P  circ", CORRIDOR, TO_OFFICE))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("mit") / "1_2.xml"


def read(path: Path, text: str) -> Floor:
    path.write_text(text)
    return read_mit_xml(path)


def test_two_rooms_in_metres_from_their_corner_with_one_door(path):
    floor = read(path, TWO_ROOMS)
    assert [(room.id, room.label) for room in floor.rooms] == [(1, "OFF"), (2, "P CIRC")]
    assert floor.rooms[0].polygon.symmetric_difference(box(0, 0, 20 * FOOT, 10 * FOOT)).area < 1e-6
    assert floor.rooms[1].polygon.symmetric_difference(box(0, 10 * FOOT, 30 * FOOT, 16 * FOOT)).area < 1e-6
    (door,) = floor.doors
    assert (door.rooms, door.kind) == ((1, 2), "door")
    ends = sorted(get_coordinates(door.line).tolist())
    assert ends == [
        pytest.approx([5 * FOOT - 0.45, 10 * FOOT], abs=1e-5),
        pytest.approx([5 * FOOT + 0.45, 10 * FOOT], abs=1e-5),
    ]
    assert (floor.source, floor.building_type) == ("1_2.xml", {})


def test_metres_by_choice(path):
    path.write_text(TWO_ROOMS)
    floor = read_mit_xml(path, unit="metre")
    assert floor.rooms[0].polygon.bounds == pytest.approx((0, 0, 20, 10))
    with pytest.raises(OptionError, match="inch"):
        read_mit_xml(path, unit="inch")  # type: ignore[arg-type]


def test_several_places_are_the_ends_of_a_door(path):
    wide = portal("1-C", (2, 0.5), (2, 0.9))
    floor = read(path, mit_xml(space("1-A", "OFF", OFFICE, wide), space("1-C", "", CORRIDOR)))
    assert floor.doors[0].width == pytest.approx(8 * FOOT)


def test_an_implicit_portal_opens_the_shorter_edge(path):
    """The end of the corridor is 6 ft wide, its continuation 4 ft; both edges are on one line."""
    corridor = space("1-C", "", CORRIDOR, portal("1-D", (1, 0.5), type="IMPLICIT"))
    floor = read(path, mit_xml(corridor, space("1-D", "", FURTHER, portal("1-C", (3, 0.5), type="implicit"))))
    (door,) = floor.doors
    assert door.kind == "opening"
    assert sorted(get_coordinates(door.line).tolist()) == [
        pytest.approx([30 * FOOT, 2 * FOOT]),
        pytest.approx([30 * FOOT, 6 * FOOT]),
    ]


def test_vertical_portals_are_neither_doors_nor_defects(path):
    stairs = portal("2-A", (0, 0.5), class_="VERTICAL", type="STAIR")
    floor = read(path, TWO_ROOMS.replace(TO_CORRIDOR, TO_CORRIDOR + stairs))
    assert [door.rooms for door in floor.doors] == [(1, 2)]


@pytest.mark.parametrize("edges", [[], [(9, 0.5)], [(2, 1.5)], [(2, "nan")], [("x", 0.5)], [(-1, 0.5)], [(1.5, 0.5)]])
def test_a_portal_without_a_place_goes_to_the_middle_of_the_wall(path, edges):
    text = mit_xml(space("1-A", "OFF", OFFICE, portal("1-C", *edges)), space("1-C", "", CORRIDOR))
    with pytest.warns(BuildingWarning, match="OFF"):
        floor = read(path, text)
    assert floor.doors[0].line.centroid.coords[0] == pytest.approx((10 * FOOT, 10 * FOOT), abs=0.15)


@pytest.mark.parametrize("target", ["", "1-A", "W20"])
def test_a_portal_to_no_other_room_is_left_out(path, target):
    with pytest.warns(BuildingWarning, match="OFF"):
        assert read(path, mit_xml(space("1-A", "OFF", OFFICE, portal(target, (0, 0.5))))).doors == ()


def test_an_open_contour_and_rooms_below_a_building_are_read(path):
    text = mit_xml(space("1-A", "OFF", OFFICE, closed=False)).replace("MITquest>", "MITquest><building>", 1)
    (room,) = read(path, text.replace("</MITquest>", "</building></MITquest>")).rooms
    assert room.polygon.area == pytest.approx(200 * FOOT**2)


@pytest.mark.parametrize("corners", [[], [(-9, -9)], [(-9, -9), (-9, 30)], [(-9, "nan"), (-9, 30), (-30, 30)]])
def test_a_room_that_cannot_be_read_is_left_out_and_the_frame_is_that_of_the_others(path, corners):
    text = TWO_ROOMS.replace("</floor>", space("1-S", "STAIR", corners, TO_OFFICE) + "</floor>")
    with pytest.warns(BuildingWarning, match=r"without some of its rooms: room 3 \(STAIR\)"):
        floor = read(path, text)
    expected = read(path, TWO_ROOMS)
    assert [room.id for room in floor] == [1, 2]
    assert all(room.polygon.equals_exact(expected[room.id].polygon, 1e-5) for room in floor)
    assert floor.doors[0].line.equals_exact(expected.doors[0].line, 1e-5)


def test_rooms_of_one_name_both_stay(path):
    with pytest.warns(BuildingWarning, match=r"2 rooms have the name '1-A'"):
        assert [room.id for room in read(path, TWO_ROOMS.replace("1-C", "1-A"))] == [1, 2]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (mit_xml(), "rooms"),
        (TWO_ROOMS.replace("</space><space", "</space></floor><floor><space"), "floors"),
        (mit_xml(space("1-A", "OFF", [*OFFICE, ("nan", 0)])), "nan"),
        (mit_xml(space("1-A", "OFF", [*OFFICE, ("1e9", 0)])), "1e9"),
        (mit_xml(space("1-A", "OFF", OFFICE[:2])), "area"),
        (mit_xml(space("1-A", "OFF", OFFICE, "<portal/>" * 20001)), "20001"),
        ('{"verts": 1}', "HouseExpo"),
        ('<!DOCTYPE f [<!ENTITY e "e">]><MITquest>&e;</MITquest>', "entities"),
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
        assert isinstance(read_mit_xml(path), Floor)


coordinate = st.sampled_from([0, 1e-5, 0.1, 10, 20, 30, -10, 1e6, -1e6])


@pytest.mark.slow
@given(
    corners=st.lists(st.tuples(coordinate, coordinate), max_size=6),
    edges=st.lists(st.tuples(st.integers(0, 5), st.sampled_from([0, 0.25, 1])), max_size=3),
    type_=st.sampled_from(["explicit", "implicit"]),
)
def test_any_outline_and_place_is_read_or_refused(path, corners, edges, type_):
    text = mit_xml(space("1-A", "", corners, portal("1-C", *edges, type=type_)), space("1-C", "", CORRIDOR))
    with suppress(BuildingError), warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        floor = read(path, text)
        assert [door.rooms for door in floor.doors] == ([(1, 2)] if len(floor) == 2 else [])
        assert all(door.width > 0 for door in floor.doors)
