"""Layout XMLs are read as floors; their defects are repaired or reported."""

import csv
import warnings
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from shapely import LineString, Polygon, box, get_coordinates

from pianta.errors import BuildingError, BuildingWarning
from pianta.evaluation.segmentation import score_labels
from pianta.floor import Door, Floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io._xml import MAX_FILE_BYTES
from pianta.io.buildings.read import read_building
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.floors import save_floor
from pianta.io.images import read_image_map
from pianta.labels import OFFICE, schema_of
from pianta_bench.data.survey_truth import read_survey_truth
from tests.mutation import mutated

Corners = Sequence[tuple[object, object]]

LEFT = [(0, 0), (40, 0), (40, 15), (40, 30), (0, 30)]
RIGHT = [(40, 0), (100, 0), (100, 30), (40, 30), (40, 15)]
SPIKED = [(0, 0), (40, 0), (40, 30), (40, 50), (40, 30), (0, 30)]
CROSSED = [(0, 0), (40, 0), (40, 30), (0, 30), (0, -10), (-10, -10), (-10, 5), (0, 5)]
POINT = [(40, 15), (40, 15)]


def points(corners: Corners) -> str:
    return "".join(f'<point x="{x}" y="{y}"/>' for x, y in corners)


def portal(*ids: str, segment: str = "p", type_: str = "EXPLICIT") -> str:
    target = "".join(f"<id>{id_}</id>" for id_ in ids)
    return f"<portal><linesegment>{segment}</linesegment><type>{type_}</type><target>{target}</target></portal>"


def space(id_: str, corners: Corners, portals: str = "", label: str = "OFFICE", door: Corners = POINT) -> str:
    return (
        f'<space id="{id_}"><labels><type>R</type><label>{label}</label></labels>'
        f"<bounding_polygon>{points(corners)}</bounding_polygon><space_representation>"
        f'<linesegment id="w">{points(corners[:2])}<class>WALL</class></linesegment>'
        f'<linesegment id="p">{points(door)}<class>PORTAL</class></linesegment>'
        f"</space_representation><portals>{portals}</portals></space>"
    )


def building(*spaces: str, drawn_px: str = "9", real_cm: str = "90") -> str:
    return (
        f"<building><scale><represented_distance><value>{drawn_px}</value><um>pixel</um></represented_distance>"
        f"<real_distance><value>{real_cm}</value><um>cm</um></real_distance></scale>"
        f"<building_type><main_type>OFFICE</main_type></building_type>"
        f"<floor><spaces>{''.join(spaces)}</spaces><groups><space id='g'/></groups></floor></building>"
    )


TWO_ROOMS = building(space("a", LEFT, portal("a", "b")), space("b", RIGHT, portal("b", "a"), "CORRIDOR"))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("buildings") / "two.xml"


def read(path: Path, text: str, grid: GridMap | None = None) -> Floor:
    path.write_text(text)
    return read_building_xml(path, grid=grid)


def test_two_rooms_in_metres(path):
    """9 px are 0.9 m; the door is a point on the wall between the rooms and becomes 0.9 m of that wall."""
    floor = read(path, TWO_ROOMS)
    left, right = floor.rooms
    assert (left.id, left.label, right.id, right.label) == (1, "OFFICE", 2, "CORRIDOR")
    assert left.polygon.equals_exact(Polygon(np.array(LEFT) * (0.1, -0.1)), 1e-9, normalize=True)
    assert right.polygon.symmetric_difference(box(4, -3, 10, 0)).area < 1e-9
    (door,) = floor.doors
    assert (door.rooms, door.kind) == ((1, 2), "door")
    assert door.width == pytest.approx(0.9)
    assert sorted(get_coordinates(door.line).tolist()) == pytest.approx(np.array([(4, -1.95), (4, -1.05)]))
    assert floor.building_type == {"office": 1.0}
    assert floor.source == "two.xml"


@pytest.mark.parametrize(
    ("type_", "building_type"), [("School", {"school": 1.0}), ("\n old  House ", {"old house": 1.0}), (" ", {})]
)
def test_building_types_are_in_lower_case(path, type_, building_type):
    assert read(path, TWO_ROOMS.replace(">OFFICE</main_type", f">{type_}</main_type")).building_type == building_type


def test_an_invalid_building_type_is_listed_with_the_other_faults(path):
    text = building(space("a", LEFT[:2]), space("b", RIGHT)).replace(">OFFICE</main_type", f">{'x' * 101}</main_type")
    with pytest.raises(BuildingError, match=r"xxx.*area"):
        read(path, text)


def test_two_rooms_on_a_map(path):
    """The pixels of the drawing are those of the map: the right room fills the columns from 40 on."""
    grid = GridMap(np.zeros((30, 100), np.int8), 0.5, (-7.0, 3.0, 0.3))
    floor = read(path, TWO_ROOMS, grid)
    labels = floor.label_image(grid)
    assert (labels[:, :40] == 1).all()
    assert (labels[:, 40:] == 2).all()
    row, col = grid.map_to_pixel(*get_coordinates(floor.doors[0].line).T)
    assert col == pytest.approx(np.array([40, 40]))
    assert sorted(row) == pytest.approx([10.5, 19.5])
    assert floor.doors[0].width == pytest.approx(4.5)


def test_drawn_segment_is_the_door(path):
    door = [(40, 10), (40, 22)]
    floor = read(path, building(space("a", LEFT, portal("a", "b", type_="IMPLICIT"), door=door), space("b", RIGHT)))
    assert floor.doors == (Door((1, 2), LineString([(4, -1), (4, -2.2)]), floor.doors[0].width, "opening"),)
    assert floor.doors[0].width == pytest.approx(1.2)


def test_door_in_a_corner_follows_the_common_wall(path):
    """Rooms a and b meet at y = 30; the point is a corner of a, in the middle of a wall of b."""
    below = [(-50, 30), (90, 30), (90, 60), (-50, 60)]
    corner = [(40, 30), (40, 30)]
    floor = read(path, building(space("a", LEFT, portal("a", "b"), door=corner), space("b", below, door=corner)))
    assert get_coordinates(floor.doors[0].line)[:, 1] == pytest.approx(np.array([-3, -3]))


@pytest.mark.parametrize(("corners", "area"), [(SPIKED, 12), (CROSSED, 12)])
def test_outline_that_meets_itself_keeps_its_largest_part(path, corners, area):
    with pytest.warns(BuildingWarning, match="OFFICE"):
        floor = read(path, building(space("a", corners), space("b", RIGHT)))
    assert floor.rooms[0].polygon.area == pytest.approx(area)


def test_door_without_a_position_goes_to_the_middle_of_the_wall(path):
    portals = portal("a", "b", segment="gone")
    text = building(space("a", LEFT, portals), space("b", RIGHT, portals))
    with pytest.warns(BuildingWarning, match="OFFICE"):
        floor = read(path, text)
    assert floor.doors[0].line.centroid.coords[0] == pytest.approx((4, -1.5), abs=0.01)


@pytest.mark.parametrize("portals", [portal("a", "a"), portal("a", "z"), portal("a"), portal("a", "b", "c")])
def test_door_that_joins_no_two_rooms_is_left_out(path, portals):
    with pytest.warns(BuildingWarning, match="OFFICE"):
        floor = read(
            path, building(space("a", LEFT, portals * 2), space("b", RIGHT), space("c", [(0, 40), (40, 40), (0, 60)]))
        )
    assert floor.doors == ()


def test_all_repairs_are_one_warning(path):
    text = building(space("a", SPIKED, portal("a", "a")), space("b", RIGHT))
    with pytest.warns(BuildingWarning) as caught:
        read(path, text)
    assert len(caught) == 1
    assert "itself" in str(caught[0].message)
    assert "left" in str(caught[0].message)


def test_faults_are_listed_together(path):
    text = building(space("a", LEFT[:2]), space("a", [("x", 0), (1, "1e9"), *LEFT]), drawn_px="0")
    with pytest.raises(BuildingError) as error:
        read(path, text)
    for fault in (
        "'pixel'",
        "(OFFICE)",
        "'x'",
        "'1e9'",
    ):
        assert fault in str(error.value)


NO_AREA: list[Corners] = [
    [],
    [(40, 15)],
    [(40, 15), (40, 15), (40, 15)],
    [(40, 0), (40, 30)],
    [(40, 0), (40, 20), (40, 30), (40, 10)],
    [("nan", 0), (100, 0), (100, 30), (40, 30)],
    [("", 0), (100, 0), (100, 30), (40, 30)],
    [(40, 0), (1e9, 0), (100, 30), (40, 30)],
    [(40 + n % 2, n % 7) for n in range(2001)],
]


@pytest.mark.parametrize("corners", NO_AREA)
def test_a_room_without_an_outline_is_left_out_with_its_door_and_the_others_stay(path, corners):
    """The corridor c keeps its number 3 and its door to a; the door from a to the stray lab goes with the lab."""
    below = [(0, 30), (40, 30), (40, 60), (0, 60)]
    to_stray, to_below = portal("a", "b"), portal("a", "c", segment="none")
    stray = space("b", corners, portal("b", "a"), "LAB")
    text = building(space("a", LEFT, to_stray + to_below), stray, space("c", below, to_below))
    with pytest.warns(BuildingWarning) as caught:
        floor = read(path, text)
    with pytest.warns(BuildingWarning):
        assert read_building(path) == floor
    assert [room.id for room in floor] == [1, 3]
    assert [door.rooms for door in floor.doors] == [(1, 3)]
    (warning,) = caught
    assert "without some of its rooms: room 2 (LAB)" in str(warning.message)
    assert "a door of room 1 (OFFICE) does not join two rooms, left out" in str(warning.message)
    assert "\n" not in str(warning.message)


def test_a_file_of_rooms_without_outlines_is_refused_in_one_line(path):
    with pytest.raises(BuildingError, match=r"none of its rooms can be read; room 1 .*; room 2 \(LAB\)"):
        read(path, building(space("a", LEFT[:2]), space("b", NO_AREA[5], label="LAB")))


def test_rooms_of_one_id_both_stay_with_the_doors_that_they_list(path):
    """Both offices are called a and list their door to the corridor; its own list does not say which one it means."""
    below = [(0, 30), (40, 30), (40, 60), (0, 60)]
    corridor = space("b", RIGHT, portal("a", "b"), "CORRIDOR")
    rooms = [space("a", corners, portal("a", "b", segment="none")) for corners in (LEFT, below)]
    with pytest.warns(BuildingWarning, match=r"2 rooms have the id 'a'"):
        floor = read(path, building(*rooms, corridor))
    assert [door.rooms for door in floor.doors] == [(1, 3), (2, 3)]


def test_a_copy_of_a_room_is_left_out(path):
    text = TWO_ROOMS.replace("</spaces>", space("a", LEFT, portal("a", "b")) + "</spaces>")
    with pytest.warns(BuildingWarning, match=r"room 3 \(OFFICE\) is a copy of room 1 \(OFFICE\)"):
        floor = read(path, text)
    assert [room.id for room in floor] == [1, 2]
    assert [door.rooms for door in floor.doors] == [(1, 2)]


def test_an_invalid_point_of_a_door_moves_the_door_to_the_middle_of_the_wall(path):
    no_place = [("nan", 1)] * 2
    text = building(space("a", LEFT, portal("a", "b"), door=no_place), space("b", RIGHT, door=no_place))
    with pytest.warns(BuildingWarning, match=r"'nan'.*give two numbers") as caught:
        floor = read(path, text)
    assert "middle of their wall" in str(caught[0].message)
    assert floor.doors[0].line.centroid.coords[0] == pytest.approx((4, -1.5), abs=0.01)


@pytest.mark.parametrize(
    "scale", [{"drawn_px": "nan"}, {"drawn_px": "1e-300"}, {"real_cm": "-90"}, {"real_cm": "1e300"}, {"real_cm": ""}]
)
def test_scale_is_positive(path, scale):
    with pytest.raises(BuildingError, match=r"\bscale\b"):
        read(path, building(space("a", LEFT), **scale))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (building(), "rooms"),
        (TWO_ROOMS.replace("</building>", "<floor/></building>"), "floors"),
        ("<building/>", "scale"),
        ("<building>", "XML"),
        ("map", "XML"),
        ('<?xml version="1.0" encoding="klingon"?><building/>', "XML"),
        ('<!DOCTYPE b [<!ENTITY e "e">]><building>&e;</building>', "entities"),
        ('<!DOCTYPE b SYSTEM "file:///etc/passwd"><building/>', "entities"),
        ('<floor BuildingName="b"/>', "KTH"),
        ("<MITquest/>", "MIT"),
        ('{"verts": []}', "HouseExpo"),
        ('<svg xmlns="http://www.w3.org/2000/svg"/>', "SVG"),
        ("<package/>", "package"),
    ],
)
def test_files_without_a_building_are_refused(path, text, message):
    with pytest.raises(BuildingError, match=message):
        read(path, text)


def test_missing_file(tmp_path):
    with pytest.raises(BuildingError, match="exist"):
        read_building_xml(tmp_path / "none.xml")


@given(fuzz=st.data())
def test_damaged_file_is_read_or_refused(path, fuzz):
    path.write_bytes(fuzz.draw(st.binary() | mutated(TWO_ROOMS.encode())))
    with suppress(BuildingError), warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        assert isinstance(read_building_xml(path), Floor)


coordinate = st.sampled_from([0, 1e-9, 0.1, 15, 30, 40, -10, 1e6, -1e6, 1e-300])


@pytest.mark.slow
@given(corners=st.lists(st.tuples(coordinate, coordinate), max_size=6), door=st.tuples(coordinate, coordinate))
def test_any_outline_is_read_or_refused(path, corners, door):
    text = building(
        space("a", corners, portal("a", "b"), door=[door, door]), space("b", RIGHT, portal("a", "b", segment="q"))
    )
    with suppress(BuildingError), warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        floor = read(path, text)
        assert [len(floor.rooms), len(floor.doors)] in ([2, 2], [1, 0])
        assert all(door.width == pytest.approx(0.9) for door in floor.doors)


def test_labels_and_types_are_those_of_schemas(path):
    floor = read(path, TWO_ROOMS.replace("CORRIDOR", "\n conference\t Room ").replace("<label>OFFICE", "<label> "))
    assert [room.label for room in floor.rooms] == [None, "CONFERENCE ROOM"]
    assert schema_of(*floor.building_type) is OFFICE


def test_paths_of_the_annotators_computer_are_not_read(path, tmp_path):
    name = "<name>/Users/annotator/Dropbox/school</name>"
    text = TWO_ROOMS.replace("<scale>", f"{name}<scale>").replace(points(LEFT), points(SPIKED))
    with pytest.warns(BuildingWarning) as caught:
        floor = read(path, text)
    save_floor(floor, tmp_path / "floor.geojson")
    assert "annotator" not in (tmp_path / "floor.geojson").read_text() + str(caught[0].message)


def test_a_door_that_one_room_lists_is_a_door(path):
    floor = read(path, building(space("a", LEFT), space("b", RIGHT, portal("b", "a"))))
    assert [door.rooms for door in floor.doors] == [(1, 2)]


def test_a_room_without_a_list_of_portals_is_reported(path):
    text = TWO_ROOMS.replace(f"<portals>{portal('b', 'a')}</portals>", "")
    with pytest.warns(BuildingWarning, match="CORRIDOR"):
        floor = read(path, text)
    assert [door.rooms for door in floor.doors] == [(1, 2)]


def test_a_drawing_of_areas_without_any_door_is_no_defect(path):
    text = building(space("a", LEFT), space("b", RIGHT)).replace("<portals></portals>", "")
    assert read(path, text).doors == ()


FAR = [[(x + shift, y) for x, y in LEFT] for shift in (200, 240, 300)]


def test_rooms_without_doors_and_groups_are_reported(path):
    """Doors join rooms a and b, and c and d; no door leads to e."""
    door = [(240, 15)] * 2
    text = building(
        *(space("a", LEFT, portal("a", "b")), space("b", RIGHT)),
        *(space("c", FAR[0], portal("c", "d"), door=door), space("d", FAR[1]), space("e", FAR[2], label="LAB")),
    )
    stay = "LAB.*groups"
    with pytest.warns(BuildingWarning, match=stay):
        floor = read(path, text)
    assert len(floor.rooms) == 5


def test_rooms_that_overlap_and_tiny_ones_are_reported_and_stay(path):
    """Of 60 × 30 px, 54 × 2 are 6 % and 54 × 5 are 15 % of the smaller room."""
    rooms = [
        [(0, 30 * n - overlap), (60, 30 * n - overlap), (60, 30 * n + 30), (0, 30 * n + 30)]
        for n, overlap in enumerate((0, 2, 5))
    ]
    tiny = [(70, 0), (78, 0), (78, 8), (70, 8)]
    with pytest.warns(BuildingWarning) as caught:
        floor = read(path, building(*(space(str(n), room) for n, room in enumerate([*rooms, tiny]))))
    message = str(caught[0].message)
    assert "16%" in message
    assert "0.64" in message
    assert message.count(";") == 1
    assert len(floor.rooms) == 4


def test_corners_outside_the_map_are_reported(path):
    """The right room ends 10 px outside a map of 90 px, and on a map of 96 px only by the thickness of a line."""
    read(path, TWO_ROOMS, GridMap(np.zeros((30, 96), np.int8), 0.1, (0.0, 0.0, 0.0)))
    with pytest.warns(BuildingWarning, match=r"\boutside\b"):
        read(path, TWO_ROOMS, GridMap(np.zeros((30, 90), np.int8), 0.1, (0.0, 0.0, 0.0)))


@pytest.mark.slow
def test_buildings_beyond_the_limits_of_size_are_refused(path):
    ring = [(n, n % 2) for n in range(2001)]
    with pytest.raises(BuildingError, match="2001"):
        read(path, building(space("a", ring)))
    with pytest.raises(BuildingError, match="301"):
        read(path, building(space("a", [*ring[:300], (150, -10)])))
    with pytest.raises(BuildingError, match="1001"):
        read(path, building(*(f"<space id='{n}'/>" for n in range(1001))))
    with pytest.raises(BuildingError, match="20001"):
        read(path, building(space("a", LEFT, "<portal/>" * 20001)))
    with path.open("wb") as file:
        file.truncate(MAX_FILE_BYTES + 1)
    with pytest.raises(BuildingError, match="many"):
        read_building_xml(path)


def records(data: Path) -> dict[str, dict[str, str]]:
    """defects.csv by file."""
    with (data / "defects.csv").open() as file:
        return {row["file"]: row for row in csv.DictReader(file)}


def read_with_warnings(file: Path, grid: GridMap | None = None) -> tuple[Floor, str]:
    """The floor of a file, and its warning."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        floor = read_building_xml(file, grid=grid)
    assert len(caught) <= 1
    return floor, "".join(str(warning.message) for warning in caught)


def grid_of_image(file: Path) -> GridMap | None:
    """A grid of the size of the image of a layout; None without an image."""
    for image in (file.with_name(file.stem.removesuffix("_gt") + suffix) for suffix in (".png", ".jpg")):
        if image.is_file():
            with Image.open(image) as opened:
                return GridMap(np.full(opened.size[::-1], UNKNOWN), 0.1, (0.0, 0.0, 0.0))
    return None


@pytest.mark.slow
def test_every_building_has_the_documented_rooms_and_doors(data):
    """The table has the counts of the authors of the data; each door is listed twice."""
    for name, record in records(data).items():
        count = {key: int(value) for key, value in record.items() if value.isdigit()}
        floor, _ = read_with_warnings(data / name)
        graph = floor.graph()
        assert len(floor.rooms) == count["spaces"], name
        assert graph.number_of_edges() == count["edges"], name
        assert len(floor.doors) == (count["portals"] - count["self_portals"]) / 2, name
        assert nx.number_connected_components(graph) == count["components"], name
        assert nx.number_of_isolates(graph) == count["isolated_spaces"], name
        assert len({room.label for room in floor.rooms}) == count["labels"], name
        assert floor.building_type == {record["main_type"].lower(): 1.0}, name


@pytest.mark.slow
def test_every_building_has_the_documented_scale(data):
    """The ratio of one length in metres and in pixels."""
    pixels = GridMap(np.array([[UNKNOWN]]), 1.0, (0.0, 0.0, 0.0))
    for name, record in records(data).items():
        if name.startswith("buildings"):
            floors = [read_with_warnings(data / name, grid)[0] for grid in (None, pixels)]
            metres, px = [np.ptp(get_coordinates([room.polygon for room in floor.rooms])[:, 0]) for floor in floors]
            assert metres / px == pytest.approx(0.9 / float(record["px_per_90cm"])), name


@pytest.mark.slow
def test_every_documented_defect_is_reported(data):
    """As often as documented, and no other defect; empty cells of the table were not counted."""
    for name, record in records(data).items():
        grid = grid_of_image(data / name) if record["outside_image_points"] else None
        _, caught = read_with_warnings(data / name, grid)
        count = {key: int(value) for key, value in record.items() if value.isdigit()}
        groups = count["components"] - count["isolated_spaces"]
        defects = {
            "meets itself": count["invalid_polygons"],
            "does not join two rooms": count["self_portals"] // 2 + count["dangling_portal_targets"],
            "has no place": count["missing_segment_refs"] // 2,
            "less than a square": count["tiny_polygons"],
            "no door leads to": min(count["isolated_spaces"], 1),
            f"form {groups} groups": int(groups > 1),
            "overlap by": count.get("overlapping_pairs", caught.count("overlap by")),
            "corners outside": int(count.get("outside_image_points", 0) > 0),
        }
        for text, number in defects.items():
            assert caught.count(text) == number, f"{name}: {text}"
        assert caught.count(";") + caught.count(", and has") + bool(caught) == sum(defects.values()), name
        for label in filter(None, (part.split(":")[0] for part in record["detail"].split("; "))):
            assert f"({label}) meets itself" in caught, name
        assert f"outside the map: {record['outside_image_points']}," in caught or not count.get("outside_image_points")


def test_every_building_of_the_data_is_documented(data):
    patterns = "survey/*_layout_gt.xml", "slam/*_gt.xml", "buildings/*/*.xml", "floorplans/*.xml", "partial/*/*.xml"
    assert {str(file.relative_to(data)) for pattern in patterns for file in data.glob(pattern)} == set(records(data))


def test_survey_layout_is_on_its_map(data):
    grid = read_image_map(data / "survey" / "Freiburg101_scan.png", resolution=0.05)
    labels = read_building_xml(data / "survey" / "Freiburg101_scan_layout_gt.xml", grid=grid).label_image(grid)
    truth = read_survey_truth(data / "survey" / "Freiburg101_scan_gt_segmentation.png")
    scores = score_labels(labels, truth, counted=grid.free)
    assert (scores.reconstructed, scores.true, scores.f1) == (10, 10, 1.0)
    assert min(scores.a_fc, scores.a_bc) > 0.98
