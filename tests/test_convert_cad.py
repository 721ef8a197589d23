"""Floors as drawings and building models, read back by programs that we did not write, and by pianta."""

import numpy as np
import pytest
import shapely
from shapely import LineString, Polygon, box

import pianta
from pianta.io.drawings.ifc import read_ifc_plan
from pianta.io.writers.dxf import escape_text
from pianta.io.writers.wall_parts import find_walls

# Rooms of 4 m x 3 m, with walls of 0.2 m between them, north of a corridor of 8.2 m x 2 m.
FLOOR = pianta.Floor(
    (
        pianta.Room(1, box(0, 2.2, 4, 5.2), "OFFICE", name="2502C Rossi & <Figli>"),
        pianta.Room(2, box(4.2, 2.2, 8.2, 5.2), "OFFICE", name='50%%d ^J "x" 🏠'),
        pianta.Room(3, Polygon(box(0, 0, 8.2, 2).exterior, [box(4, 0.5, 5, 1).exterior]), "CORRIDOR"),
    ),
    (
        pianta.Door((1, 3), LineString([(1, 2.1), (2, 2.1)]), 0.9),
        pianta.Door((2, 3), LineString([(6, 2.1), (7, 2.1)]), 1.0, "opening"),
        pianta.Door((3, None), LineString([(0, 0.5), (0, 1.5)]), 1.0),
    ),
    furniture=(pianta.Furniture(box(1, 3, 2, 4)),),
)
UPPER = pianta.Floor(FLOOR.rooms[:1])
HOUSE = pianta.Building(
    (pianta.Storey(FLOOR, "ground", 0.0, title="Ground floor"), pianta.Storey(UPPER, "first", 3.2)),
    "House <1>",
    (pianta.Link("stairs", (("ground", 3), ("first", 1))),),
)


def test_gaps_between_rooms_are_walls():
    walls = find_walls(FLOOR)
    between = {part.rooms: part for part in walls.parts if len(part.rooms) == 2}
    assert between.keys() == {(1, 2), (1, 3), (2, 3)}
    assert between[1, 2].thickness == pytest.approx(0.2)
    assert np.unique(between[1, 2].ends[:, 0]) == pytest.approx([4.1])
    # The wall stays whole at its door, and the solid pieces leave it open
    assert [walls.parts[host].rooms for host in walls.hosts] == [(1, 3), (2, 3), (3,)]
    solid = shapely.union_all([part.area for part in walls.solid])
    for door in FLOOR.doors:
        assert solid.intersection(door.line).length == pytest.approx(0, abs=1e-9)
    assert solid.intersection(shapely.union_all([room.polygon for room in FLOOR])).area == pytest.approx(0, abs=1e-9)


def test_rooms_that_touch_have_a_thin_wall():
    floor = pianta.Floor((pianta.Room(1, box(0, 0, 2, 2)), pianta.Room(2, box(2, 0, 4, 2))))
    (part,) = (part for part in find_walls(floor).parts if len(part.rooms) == 2)
    assert (part.thickness, part.rooms) == (0.1, (1, 2))


def test_outer_walls_keep_their_thickness_beside_a_room_that_touches():
    """Rooms that share a side: the outer walls of both end at its corners, where the other room begins beside them."""
    floor = pianta.Floor((pianta.Room(1, box(0, 0, 2, 2)), pianta.Room(2, box(2, 0, 4, 2))))
    outer = [part for part in find_walls(floor).parts if len(part.rooms) == 1]
    assert [part.thickness for part in outer] == [0.15] * 6


def test_an_outer_wall_is_thinner_only_where_another_room_begins_behind_it():
    # A slanted room whose corner is 5 cm above the first one, from x = 3 on
    corner = Polygon([(3, 2.05), (5, 2.05), (5, 4), (4.5, 4)])
    floor = pianta.Floor((pianta.Room(1, box(0, 0, 4, 2)), pianta.Room(2, corner)))
    above = [part for part in find_walls(floor).parts if part.rooms == (1,) and part.ends[:, 1].min() > 2]
    assert {round(part.thickness, 3) for part in above} == {0.15}
    between = [part for part in find_walls(floor).parts if part.rooms == (1, 2)]
    assert [round(part.thickness, 3) for part in between] == [0.05]


def test_a_door_in_no_wall_has_a_part_of_its_own():
    floor = pianta.Floor(FLOOR.rooms[:2], (pianta.Door((1, 2), LineString([(1, 4), (2, 4)]), 1.0),))
    walls = find_walls(floor)
    assert walls.parts[walls.hosts[0]].length == 1


def test_codes_of_dxf_are_escaped():
    assert escape_text("50%%d ^J \\U+0041 a%b") == "50% %d ^ J /U+0041 a%b"


def test_dxf_has_a_polyline_and_a_stamp_for_each_room(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    notes = pianta.convert(FLOOR, tmp_path / "floor.dxf", to="dxf")
    assert notes == ["1 name with codes of DXF (%%, ^, \\U+) changed"]
    document = ezdxf.readfile(tmp_path / "floor.dxf")
    audit = document.audit()
    assert (audit.errors, audit.fixes, document.units) == ([], [], 6)
    space = document.modelspace()
    rooms = [*space.query('LWPOLYLINE[layer=="ROOMS"]')]
    assert all(line.closed for line in rooms)
    areas = [Polygon([point[:2] for point in line.get_points()]).area for line in rooms]
    assert areas == pytest.approx([12, 12, 16.4, 0.5])  # the last one is a hole
    stamps = [
        {tag.dxf.tag: tag.dxf.text for tag in stamp.attribs} for stamp in space.query('INSERT[name=="ROOM_STAMP"]')
    ]
    assert [stamp["NUMBER"] for stamp in stamps] == ["2502C", "50% %d", "3"]
    assert [stamp["NAME"] for stamp in stamps] == ["Rossi & <Figli>", '^ J "x" 🏠', ""]
    assert [stamp["AREA"] for stamp in stamps] == ["12.00 m²", "12.00 m²", "15.90 m²"]
    assert stamps[1]["LABEL"] == "OFFICE"
    doors = [[*insert.dxf.insert.vec2, insert.dxf.xscale] for insert in space.query('INSERT[name=="DOOR"]')]
    assert np.allclose(doors, [(1, 2.1, 1), (0, 0.5, 1)])
    assert len(space.query('LINE[layer=="OPENINGS"]')) == 1


def test_storeys_of_a_dxf_are_layers(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    notes = pianta.convert(HOUSE, tmp_path / "house.dxf", to="dxf")
    assert notes[1:] == [
        "each storey has its own layers, those of the lowest one are on",
        "DXF holds no 1 link between storeys, left out",
    ]
    document = ezdxf.readfile(tmp_path / "house.dxf")
    assert not document.audit().errors
    assert len(document.modelspace().query('LWPOLYLINE[layer=="1_first_ROOMS"]')) == 1
    assert document.layers.get("0_ground_ROOMS").is_on()
    assert document.layers.get("1_first_ROOMS").is_off()


@pytest.mark.parametrize(
    ("to", "file", "package"), [("dxf", "floor.dxf", "ezdxf"), ("svg", "floor.svg", "svgelements")]
)
def test_pianta_reads_its_own_drawings(to, file, package, tmp_path):
    pytest.importorskip(package)
    floor, _ = pianta.make_world("corridor")
    pianta.convert(floor, tmp_path / file, to=to)
    read = pianta.read(tmp_path / file, labels=False).floor
    corners = (
        shapely.total_bounds([room.polygon for room in floor]),
        shapely.total_bounds([room.polygon for room in read]),
    )
    shift = corners[0][:2] - corners[1][:2]
    # A room without a name is written as its id, which is read as a number
    written = {room.id: int(room.number or 0) for room in read}
    assert {room.name for room in read} == {None}
    twins = {written[room.id]: shapely.transform(room.polygon, lambda points: points + shift) for room in read}
    assert len(read) == len(floor)
    for room in floor:
        twin = twins[room.id]
        assert twin.intersection(room.polygon).area / twin.union(room.polygon).area > 0.9
    assert {tuple(sorted(written[each] for each in door.room_ids)) for door in read.doors} == {
        door.room_ids for door in floor.doors
    }


def test_svg_has_groups_and_ids(tmp_path):
    etree = pytest.importorskip("lxml.etree")
    assert pianta.convert(FLOOR, tmp_path / "floor.svg", to="svg") == []
    root = etree.parse(tmp_path / "floor.svg").getroot()
    space = {"s": "http://www.w3.org/2000/svg"}
    ids = root.xpath("//s:g[@id='rooms']/s:path/@id", namespaces=space)
    assert ids == ["room-1", "room-2", "room-3"]
    assert root.xpath("//s:g[@id='names']/s:text/text()", namespaces=space)[0] == "2502C Rossi & <Figli>"
    assert not root.xpath("//s:script", namespaces=space)
    # 8.2 m with outer walls of 0.15 m and margins of 1 m on both sides, and four rows of the legend, 0.6 m each
    assert root.get("viewBox") == "0 0 10.5 9.9"
    texts = root.xpath("//s:g[@id='legend']/s:text/text()", namespaces=space)
    # Two offices, then one corridor; half the width of 8.5 m is at least 2 m
    expected = ["2 m", "OFFICE (2)", "CORRIDOR (1)", "door (side of its leaf unknown)", "opening", "furniture"]
    assert texts == expected
    fills = root.xpath("//s:g[@id='rooms']/s:path/@fill", namespaces=space)
    # An office is for other things in other types of buildings, so that it has no colour without a type
    assert fills == ["#fad5a8"]
    corridor = root.xpath("//s:path[@id='room-3']/@d", namespaces=space)[0]
    assert "1.15 6.35" in corridor


def test_svg_is_read_by_svgelements(tmp_path):
    svgelements = pytest.importorskip("svgelements")
    pianta.convert(HOUSE, tmp_path / "house.svg", to="svg")
    # A pixel is an inch / 96; the drawing is at 1:100
    parsed = svgelements.SVG.parse(tmp_path / "house.svg", ppi=96)
    boxes = {element.id: element.bbox() for element in parsed.elements() if isinstance(element, svgelements.Path)}
    width = (boxes["storey-1-room-1"][2] - boxes["storey-1-room-1"][0]) / 96 * 2.54
    assert width == pytest.approx(4, abs=1e-4)
    assert boxes["storey-1-room-1"][3] < boxes["storey-0-room-1"][1]  # the upper storey is above
    assert 'data-metres-per-unit="1"' in (tmp_path / "house.svg").read_text(encoding="utf-8")


@pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")  # in ifcopenshell.validate
@pytest.mark.filterwarnings("ignore:Exception ignored:pytest.PytestUnraisableExceptionWarning")
def test_ifc_is_valid_and_gives_the_same_building(tmp_path):
    pytest.importorskip("ifcopenshell")
    import ifcopenshell
    from ifcopenshell import validate

    notes = pianta.convert(HOUSE, tmp_path / "house.ifc", to="ifc")
    assert notes == []
    log = validate.json_logger()
    validate.validate(str(tmp_path / "house.ifc"), log, express_rules=True)
    assert log.statements == []
    ground, first = read_ifc_plan(tmp_path / "house.ifc")
    assert (ground.name, ground.elevation, first.name, first.elevation) == ("Ground floor", 0, "first", 3.2)
    for room, twin in zip(FLOOR, ground.floor, strict=True):
        assert room.polygon.symmetric_difference(twin.polygon).area < 1e-6
    assert [door.rooms for door in ground.floor.doors] == [(1, 3), (3, None), (2, 3)]
    assert [door.kind for door in ground.floor.doors] == ["door", "door", "opening"]
    assert [door.width for door in ground.floor.doors] == pytest.approx([0.9, 1, 1])
    model = ifcopenshell.open(tmp_path / "house.ifc")
    assert [(space.Name, space.LongName, space.ObjectType) for space in model.by_type("IfcSpace")][::2] == [
        ("2502C", "Rossi & <Figli>", "OFFICE"),
        ("3", None, "CORRIDOR"),
    ]
    quantities = [
        {quantity.Name: quantity[3] for quantity in each.Quantities} for each in model.by_type("IfcElementQuantity")
    ]
    assert (quantities[0]["NetFloorArea"], quantities[0]["GrossPerimeter"]) == pytest.approx((12, 14))
    assert len(model.by_type("IfcRelVoidsElement")) == 3
    assert len(model.by_type("IfcRelFillsElement")) == 2
    (zone,) = model.by_type("IfcZone")
    assert [space.Name for space in zone.IsGroupedBy[0].RelatedObjects] == ["3", "2502C"]


def test_ifc_of_the_same_building_has_the_same_ids(tmp_path):
    ifcopenshell = pytest.importorskip("ifcopenshell")
    ids = []
    for name in ("one.ifc", "two.ifc"):
        pianta.convert(HOUSE, tmp_path / name, to="ifc")
        ids.append([each.GlobalId for each in ifcopenshell.open(tmp_path / name).by_type("IfcRoot")])
    assert ids[0] == ids[1]
    assert len({*ids[0]}) == len(ids[0])


@pytest.mark.parametrize("to", ["dxf", "svg", "ifc", "gazebo", "stage", "sweethome3d", "scene-graph"])
def test_a_floor_without_rooms_is_written(to, tmp_path):
    if to in {"dxf", "ifc"}:
        pytest.importorskip({"dxf": "ezdxf", "ifc": "ifcopenshell"}[to])
    assert pianta.convert(pianta.Floor(()), tmp_path / f"empty.{to}", to=to) == []
    assert (tmp_path / f"empty.{to}").exists()
