"""IFC files are read as floors in metres, one per storey: spaces are rooms with names, doors join them."""

import re
import sys
import warnings

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from pianta.errors import PlanError, PlanWarning
from pianta.io.drawings import ifc as ifc_plan
from pianta.io.drawings.ifc import IfcStorey, read_ifc_plan
from tests.ifc_models import Corners, Model
from tests.mutation import mutated, refused_in_one_line

ifcopenshell = pytest.importorskip("ifcopenshell", reason="pianta[bim] is not installed")

# Millimetres: an L-shaped office, and a lab behind a wall of 200.
OFFICE = [(0, 0), (5000, 0), (5000, 3000), (2000, 3000), (2000, 6000), (0, 6000)]
LAB = [(5200, 0), (9000, 0), (9000, 3000), (5200, 3000)]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "plan.ifc"


def outlines(storey: IfcStorey) -> list[shapely.Polygon]:
    return [room.polygon for room in storey.floor.rooms]


def metres(corners: Corners) -> shapely.Polygon:
    return shapely.Polygon(np.array(corners) / 1000)


def is_same(first: shapely.Polygon, second: shapely.Polygon) -> bool:
    return bool(first.symmetric_difference(second).area < 1e-6)


@pytest.mark.parametrize("schema", ["IFC2X3", "IFC4"])
def test_spaces_become_rooms_and_a_door_joins_them(path, schema):
    model = Model(schema=schema)
    ground = model.storey()
    model.space(ground, OFFICE, Name="101", LongName=" Head's\n office ")
    model.space(ground, LAB, Name="102")
    model.door(ground, (5100, 1000))
    (storey,) = model.read(path)
    assert all(map(is_same, outlines(storey), [metres(OFFICE), metres(LAB)]))
    assert [len(outline.exterior.coords) for outline in outlines(storey)] == [7, 5]
    assert [(room.number, room.name) for room in storey.floor] == [("101", "Head's office"), ("102", None)]
    assert [room.title for room in storey.floor] == ["101 Head's office", "102"]
    assert [room.global_id for room in storey.floor] == [space.GlobalId for space in model.file.by_type("IfcSpace")]
    assert storey.floor.global_id == ground.GlobalId
    (door,) = storey.floor.doors
    assert (door.rooms, door.kind, door.global_id) == ((1, 2), "door", model.file.by_type("IfcDoor")[0].GlobalId)
    assert door.width == pytest.approx(0.9)
    assert shapely.get_coordinates(door.line) == pytest.approx(np.array([[5.1, 1], [5.1, 1.9]]))
    assert (storey.name, storey.elevation, storey.floor.source) == ("Ground", 0, "plan.ifc")


def test_lengths_are_turned_into_metres_and_placements_apply(path):
    """The office is turned by 90° about its corner at (100, 200), in metres."""
    model = Model(prefix=None)
    first = model.storey("First", 3.5)
    model.space(first, [(x / 1000, y / 1000) for x, y in OFFICE], at=(100, 200), turn=np.pi / 2)
    model.door(first, (100, 201), width=1.2)
    (storey,) = model.read(path)
    turned = shapely.Polygon([(100 - y / 1000, 200 + x / 1000) for x, y in OFFICE])
    assert is_same(outlines(storey)[0], turned)
    assert storey.elevation == 3.5
    (door,) = storey.floor.doors
    assert door.rooms == (1, None)
    assert door.width == pytest.approx(1.2)
    assert storey.names == {}


def test_a_door_is_as_long_as_the_opening_that_it_fills(path):
    """The opening goes through the wall of 200, from 900 to 2000; the door is at one side of the opening."""
    from ifcopenshell.api import feature, root

    model = Model()
    ground = model.storey()
    model.space(ground, OFFICE)
    model.space(ground, LAB)
    door = model.door(ground, (5000, 1000))
    wall, opening = (root.create_entity(model.file, ifc_class=name) for name in ("IfcWall", "IfcOpeningElement"))
    model.shape(opening, [(5000, 900), (5200, 900), (5200, 2000), (5000, 2000)])
    model.locate(opening, (0, 0), 0)
    feature.add_feature(model.file, feature=opening, element=wall)
    feature.add_filling(model.file, opening=opening, element=door)
    ((line, width, rooms),) = [(door.line, door.width, door.rooms) for door in model.read(path)[0].floor.doors]
    assert shapely.get_coordinates(line) == pytest.approx(np.array([[5.1, 0.9], [5.1, 2.0]]))
    assert rooms == (1, 2)
    assert width == pytest.approx(0.9)


def test_a_door_with_a_shape_and_no_width_is_as_wide_as_its_shape(path):
    model = Model()
    ground = model.storey()
    model.space(ground, OFFICE)
    door = model.door(ground, (1000, 0), width=None, turn=0)
    model.shape(door, [(0, -50), (800, -50), (800, 50), (0, 50)])
    (door,) = model.read(path)[0].floor.doors
    assert shapely.get_coordinates(door.line) == pytest.approx(np.array([[1, 0], [1.8, 0]]))
    assert door.rooms == (1, None)
    assert door.width == pytest.approx(0.8)


@pytest.mark.parametrize(
    "ifc_type", ["IfcRelSpaceBoundary", "IfcRelSpaceBoundary1stLevel", "IfcRelSpaceBoundary2ndLevel"]
)
def test_boundaries_of_any_level_give_the_rooms_of_a_door(path, ifc_type):
    """Even for a door that is far from both rooms and on no storey."""
    model = Model()
    model.boundary_class = ifc_type
    ground = model.storey()
    spaces = [model.space(ground, OFFICE), model.space(ground, LAB)]
    model.door(None, (50_000, 0), bounding=spaces[::-1])
    assert [door.rooms for door in model.read(path)[0].floor.doors] == [(1, 2)]


@pytest.mark.parametrize(("boundary", "rooms"), [("EXTERNAL", (1, None)), ("INTERNAL", (1, 2))])
def test_a_door_that_bounds_one_space_is_an_entrance_if_it_is_outer(path, boundary, rooms):
    """Else the room on its other side is sought."""
    model = Model()
    ground = model.storey()
    office = model.space(ground, OFFICE)
    model.space(ground, LAB)
    model.door(ground, (5100, 1000), bounding=[office], boundary=boundary)
    assert [door.rooms for door in model.read(path)[0].floor.doors] == [rooms]


def test_rooms_that_meet_in_the_middle_of_the_wall_are_distinguished(path):
    """The door stands at the side of the wall, within the lab."""
    model = Model()
    ground = model.storey()
    model.space(ground, [(0, 0), (5000, 0), (5000, 3000), (0, 3000)])
    model.space(ground, [(5000, 0), (9000, 0), (9000, 3000), (5000, 3000)])
    model.door(ground, (5100, 1000))
    assert [door.rooms for door in model.read(path)[0].floor.doors] == [(1, 2)]


def test_doors_and_spaces_without_a_position_are_left_out_with_a_warning(path):
    model = Model()
    ground = model.storey()
    model.space(ground, OFFICE)
    model.space(ground, None, Name="nowhere")
    model.door(ground, (50_000, 0))
    model.door(ground, (1000, 1000))
    model.door(None, (0, 0))
    expected = r"plan\.ifc.*1 spaces.*1 doors.*2 doors"
    with pytest.warns(PlanWarning, match=expected):
        (storey,) = model.read(path)
    assert (len(storey.floor.rooms), storey.floor.doors) == (1, ())


def test_nested_spaces_and_gross_areas_are_no_rooms_and_outer_ones_are_flagged(path):
    model = Model()
    ground = model.storey()
    suite = model.space(ground, [(0, 0), (9000, 0), (9000, 6000), (0, 6000)], Name="suite")
    model.space(suite, OFFICE, Name="office")
    model.space(suite, LAB, Name="lab")
    model.space(ground, LAB, Name="terrace", PredefinedType="EXTERNAL")
    model.space(ground, LAB, Name="sum", PredefinedType="GFA")
    rooms = model.read(path)[0].floor
    assert [(room.name, room.flag) for room in rooms] == [("office", None), ("lab", None), ("terrace", "outside")]


def test_storeys_are_ordered_from_below_and_chosen_by_name(path):
    model = Model()
    attic, ground = model.storey("Attic", 3000.0), model.storey("Ground floor")
    model.storey("Roof", 6000.0)
    model.space(attic, LAB)
    model.space(ground, OFFICE)
    model.door(ground, (0, 1000))
    storeys = model.read(path)
    assert [(storey.name, storey.elevation, len(storey.floor.doors)) for storey in storeys] == [
        ("Ground floor", 0, 1),
        ("Attic", 3, 0),
    ]
    (chosen,) = read_ifc_plan(path, storey="ground FLOOR ")
    assert is_same(outlines(chosen)[0], metres(OFFICE))
    expected = "Cellar.*Attic.*Ground floor"
    with pytest.raises(PlanError, match=expected):
        read_ifc_plan(path, storey="Cellar")


def test_a_model_without_spaces_is_refused(path):
    model = Model()
    with pytest.raises(PlanError, match="IfcSpace"):
        model.read(path)
    model.space(model.storey(), None)
    with pytest.raises(PlanError, match="shape"):
        model.read(path)


def test_numbers_beyond_the_limits_are_refused(path, monkeypatch):
    monkeypatch.setattr(ifc_plan, "MAX_SPACES", 1)
    monkeypatch.setattr(ifc_plan, "MAX_DOORS", 0)
    model = Model()
    ground = model.storey()
    model.space(ground, OFFICE)
    model.door(ground, (0, 1000))
    with pytest.raises(PlanError, match="doors"):
        model.read(path)
    model.space(ground, LAB)
    with pytest.raises(PlanError, match="spaces"):
        model.read(path)


HEADER = "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
END = "ENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "empty"),
        ("PK\x03\x04 zipped", "IFC"),
        ('<?xml version="1.0"?><ifcXML/>', "IFC"),
        (HEADER, "END-ISO-10303-21"),
        ("ISO-10303-21;\nnoise\nEND-ISO-10303-21;", "IFC"),
        (HEADER + "FILE_SCHEMA(('NONE'));\n" + END, "IFC"),
        (HEADER + "FILE_SCHEMA(('IFC4'));\n" + END, "IfcSpace"),
    ],
)
def test_files_without_a_plan_are_refused_in_one_line(path, content, message):
    path.write_text(content)
    with pytest.raises(PlanError, match=message) as caught:
        read_ifc_plan(path)
    assert "\n" not in str(caught.value)


def test_a_placement_relative_to_itself_is_refused(path):
    model = Model()
    ground = model.storey()
    model.space(ground, OFFICE)
    door = model.door(ground, (0, 0))
    model.file.write(str(path))
    placement = door.ObjectPlacement.id()
    text = re.sub(rf"(#{placement}=IFCLOCALPLACEMENT\()[^,]*", rf"\1#{placement}", path.read_text())
    path.write_text(text)
    with pytest.raises(PlanError, match="damaged"):
        read_ifc_plan(path)


@pytest.fixture(scope="module")
def valid(tmp_path_factory):
    """The bytes of two rooms with a door that bounds them."""
    model = Model()
    ground = model.storey()
    spaces = [model.space(ground, OFFICE, Name="101"), model.space(ground, LAB)]
    model.door(ground, (5100, 1000), bounding=spaces)
    path = tmp_path_factory.mktemp("ifc") / "valid.ifc"
    model.read(path)
    return path.read_bytes()


@pytest.mark.slow
@settings(max_examples=60)
@given(data=st.data())
def test_damaged_files_are_read_or_refused_in_one_line(tmp_path_factory, valid, data):
    path = tmp_path_factory.getbasetemp() / "damaged.ifc"
    path.write_bytes(data.draw(mutated(valid)))
    with refused_in_one_line(), warnings.catch_warnings():
        warnings.simplefilter("ignore", PlanWarning)
        read_ifc_plan(path)


def test_a_missing_library_is_named(path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ifcopenshell", None)
    path.write_text(HEADER)
    with pytest.raises(PlanError, match=r"pianta\[bim\]"):
        read_ifc_plan(path)
