"""How rooms of an IFC are joined and what is outside: virtual boundaries, openings, balconies, attics, the ground."""

import numpy as np
import pytest
import shapely

from pianta.errors import PlanError, PlanWarning
from pianta.io.drawings.ifc import IfcStorey, read_ifc_plan
from tests.ifc_models import Model

pytest.importorskip("ifcopenshell", reason="pianta[bim] is not installed")

# Millimetres: a kitchen and a living room that touch at x = 4000, and a bath behind a wall of 200.
KITCHEN = [(0, 0), (4000, 0), (4000, 3000), (0, 3000)]
LIVING = [(4000, 0), (9000, 0), (9000, 3000), (4000, 3000)]
BATH = [(0, 3200), (4000, 3200), (4000, 6000), (0, 6000)]
WALL = [(-200, 3000), (9200, 3000), (9200, 3200), (-200, 3200)]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "plan.ifc"


@pytest.fixture
def house():
    """A model with a ground floor, the kitchen, the living room and the bath."""
    model = Model()
    ground = model.storey()
    spaces = [
        model.space(ground, corners, Name=str(number))
        for number, corners in enumerate((KITCHEN, LIVING, BATH), start=1)
    ]
    return model, ground, spaces


def passages(storey: IfcStorey) -> list[tuple[tuple[int, int | None], str]]:
    return [(door.rooms, door.kind) for door in storey.floor.doors]


@pytest.mark.parametrize("how", ["one element", "corresponding", "no element"])
def test_virtual_boundaries_join_rooms(how, path, house):
    """The boundary is 2000 of the 3000 in which the rooms touch, and there is a wall in the model."""
    model, ground, (kitchen, living, _) = house
    model.element("IfcWall", ground, [(3950, 2000), (4050, 2000), (4050, 3000), (3950, 3000)])
    line = model.upright((4000, 0), (4000, 2000))
    if how == "corresponding":
        first, second = (
            model.bound(space, None, ifc_class="IfcRelSpaceBoundary2ndLevel", ConnectionGeometry=line)
            for space in (kitchen, living)
        )
        first.CorrespondingBoundary, second.CorrespondingBoundary = second, first
    else:
        element = model.file.createIfcVirtualElement() if how == "one element" else None
        for space in (kitchen, living):
            model.bound(space, element, ConnectionGeometry=line)
    (storey,) = model.read(path)
    (opening,) = storey.floor.doors
    assert (opening.rooms, opening.kind) == ((1, 2), "opening")
    assert np.sort(shapely.get_coordinates(opening.line), axis=0) == pytest.approx(np.array([[4, 0], [4, 2]]))


def test_a_virtual_boundary_without_geometry_is_where_rooms_meet(path, house):
    model, _, (kitchen, living, _) = house
    element = model.file.createIfcVirtualElement()
    for space in (kitchen, living):
        model.bound(space, element)
    (opening,) = model.read(path)[0].floor.doors
    assert (opening.rooms, opening.kind, opening.width) == ((1, 2), "opening", pytest.approx(3, abs=1e-3))


def test_a_virtual_boundary_between_storeys_joins_no_rooms_of_a_storey(path):
    model = Model()
    spaces = [model.space(model.storey(name, z), KITCHEN) for name, z in (("Ground", 0.0), ("First", 3000.0))]
    element = model.file.createIfcVirtualElement()
    for space in spaces:
        model.bound(space, element)
    assert [passages(storey) for storey in model.read(path)] == [[], []]


def test_openings_without_a_door_join_rooms(path, house):
    """One from the floor; another begins at the height of a sill, and a recess has the kitchen on both sides."""
    model, ground, _ = house
    wall = model.element("IfcWall", ground, WALL)
    model.opening(wall, [(1000, 2900), (2000, 2900), (2000, 3300), (1000, 3300)])
    model.opening(wall, [(2500, 2900), (3500, 2900), (3500, 3300), (2500, 3300)], low=900, height=1000)
    model.element("IfcWall", ground, [(3950, 0), (4050, 0), (4050, 3000), (3950, 3000)])
    (opening,) = model.read(path)[0].floor.doors
    assert (opening.rooms, opening.kind, opening.width) == ((1, 3), "opening", pytest.approx(1))
    assert shapely.get_coordinates(opening.line) == pytest.approx(np.array([[1, 3.1], [2, 3.1]]))


@pytest.mark.parametrize(("end", "expected"), [(3000, []), (1800, [((1, 2), "opening")])])
def test_rooms_that_touch_are_open_where_no_wall_is(end, expected, path, house):
    """A wall stands on their border from 0 to its end, and the opening is the rest."""
    model, ground, _ = house
    model.element("IfcWall", ground, [(3950, 0), (4050, 0), (4050, end), (3950, end)])
    (storey,) = model.read(path)
    assert passages(storey) == expected
    assert [door.width for door in storey.floor.doors] == pytest.approx([1.2] * len(expected), abs=0.05)


def test_a_door_upstairs_that_leads_to_no_room_is_no_entrance(path):
    """The stairs are 3 m high; a door of a floor 1.2 m above the ground has outer steps."""
    model = Model()
    for name, height in (("Ground", 0.0), ("Mezzanine", 1200.0), ("First", 4200.0)):
        storey = model.storey(name, height)
        model.space(storey, KITCHEN)
        model.door(storey, (0, 1000))
    doors = [storey.floor.doors[0] for storey in model.read(path)]
    assert [(door.rooms, door.leads_out, door.is_entrance) for door in doors] == [
        ((1, None), True, True),
        ((1, None), True, True),
        ((1, None), False, False),
    ]


@pytest.mark.parametrize(("is_exit", "expected"), [(True, True), (False, False)])
def test_an_outer_fire_exit_upstairs_is_an_entrance(is_exit, expected, path):
    model = Model()
    model.storey()
    first = model.storey("First", 3000.0)
    model.space(first, KITCHEN)
    door = model.door(first, (0, 1000))
    model.set_properties(door, "Pset_DoorCommon", IsExternal=True, FireExit=is_exit)
    assert [door.is_entrance for door in model.read(path)[0].floor.doors] == [expected]


def test_a_door_to_a_hall_without_a_space_is_no_entrance(path):
    """Walls enclose the hall north of the kitchen; the door in the south leads out."""
    model = Model()
    ground = model.storey()
    model.space(ground, KITCHEN)
    for corners in (
        [(-200, -200), (4200, -200), (4200, 0), (-200, 0)],
        [(-200, 0), (0, 0), (0, 6000), (-200, 6000)],
        [(4000, 0), (4200, 0), (4200, 6000), (4000, 6000)],
        [(-200, 6000), (4200, 6000), (4200, 6200), (-200, 6200)],
    ):
        model.element("IfcWall", ground, corners)
    model.door(ground, (1000, 3100), turn=0)
    model.door(ground, (1000, -100), turn=0)
    assert [(door.rooms, door.is_entrance) for door in model.read(path)[0].floor.doors] == [
        ((1, None), False),
        ((1, None), True),
    ]


@pytest.mark.parametrize(
    ("name", "elevation", "attributes", "flag"),
    [
        ("Kitchen", 0.0, {}, None),
        ("Dachgeschoss", 0.0, {}, None),
        ("Balkon", 3000.0, {}, "balcony"),
        ("Terrasse Süd", 0.0, {}, "outside"),
        ("Spitzboden", 3000.0, {}, "attic"),
        ("Combles", 3000.0, {}, "attic"),
        ("ROOF", 3000.0, {}, "roof"),
        ("Чердак", 3000.0, {}, "attic"),
        ("A", 3000.0, {"PredefinedType": "EXTERNAL"}, "balcony"),
    ],
)
def test_attics_roofs_and_outer_spaces_are_flagged(name, elevation, attributes, flag, path):
    model = Model()
    model.storey("Ground")
    model.space(model.storey("Own", elevation or 1.0), KITCHEN, LongName=name, **attributes)
    (room,) = model.read(path)[0].floor
    assert (room.name or "A", room.flag) == (name, flag)


def test_a_space_in_which_people_cannot_stand_is_flagged(path):
    model = Model()
    storey = model.storey()
    space = model.space(storey, None)
    model.shape(space, KITCHEN, height=1200.0)
    assert [room.flag for room in model.read(path)[0].floor] == ["low"]


def test_a_partial_space_belongs_to_the_room_and_a_complex_one_is_none(path):
    model = Model()
    ground = model.storey()
    divided = model.space(ground, KITCHEN, Name="whole", CompositionType="ELEMENT")
    model.space(divided, [(0, 0), (1000, 0), (1000, 3000), (0, 3000)], Name="part", CompositionType="PARTIAL")
    flat = model.space(ground, [*LIVING[:2], (9000, 6000), (4000, 6000)], Name="flat", CompositionType="COMPLEX")
    model.space(flat, LIVING, Name="living", CompositionType="ELEMENT")
    assert [room.number for room in model.read(path)[0].floor] == ["whole", "living"]


def test_spaces_of_the_building_are_on_the_storey_at_their_height(path):
    model = Model()
    model.storey("Ground")
    model.storey("First", 3000.0)
    for storey, height in zip(model.file.by_type("IfcBuildingStorey"), (0.0, 3000.0), strict=True):
        from ifcopenshell.api import geometry

        matrix = np.eye(4)
        matrix[2, 3] = height
        geometry.edit_object_placement(model.file, product=storey, matrix=matrix, is_si=False)
    space = model.space(model.building, None, Name="up")
    model.shape(space, KITCHEN, low=3000.0)
    model.space(model.building, LIVING, Name="down")
    assert [(storey.name, [room.number for room in storey.floor]) for storey in model.read(path)] == [
        ("Ground", ["down"]),
        ("First", ["up"]),
    ]


def test_spaces_without_any_storey_are_a_floor_of_the_building(path):
    model = Model()
    model.building.Name = "House"
    model.space(model.building, KITCHEN)
    assert [(storey.name, len(storey.floor)) for storey in model.read(path)] == [("House", 1)]


def test_two_buildings_with_storeys_of_one_name_stay_apart(path):
    from ifcopenshell.api import aggregate, root

    model = Model()
    other = root.create_entity(model.file, ifc_class="IfcBuilding")
    aggregate.assign_object(model.file, products=[other], relating_object=model.site)
    model.space(model.storey("EG"), KITCHEN, Name="1")
    model.space(model.part("IfcBuildingStorey", other, Name="EG", Elevation=0.0), LIVING, Name="2")
    storeys = model.read(path)
    assert [(storey.name, [room.number for room in storey.floor]) for storey in storeys] == [
        ("EG", ["1"]),
        ("EG", ["2"]),
    ]


def test_names_in_other_scripts_are_read(path):
    """The file has them escaped, as \\X2\\…\\X0\\."""
    model = Model()
    model.space(model.storey("一階"), KITCHEN, Name="Б-12", LongName="Küche 台所")
    (storey,) = model.read(path)
    assert "\\X2\\" in path.read_text()
    assert (storey.name, storey.floor[1].number, storey.floor[1].name) == ("一階", "Б-12", "Küche 台所")


@pytest.mark.parametrize("shape_type", ["mapped", "faceted", "drawn"])
def test_shapes_of_any_kind_are_footprints(shape_type, path):
    """A mapped solid that is moved by 1 m, a brep, and a curve in two dimensions without a body."""
    model = Model()
    space = model.space(model.storey(), None)
    make = model.file
    point = make.createIfcCartesianPoint
    origin = make.createIfcAxis2Placement3D(point((0.0, 0.0, 0.0)))
    if shape_type == "mapped":
        model.shape(space, KITCHEN)
        body = space.Representation.Representations[0]
        moved = make.createIfcCartesianTransformationOperator3D(None, None, point((1000.0, 0.0, 0.0)), 1.0, None)
        item = make.createIfcMappedItem(make.createIfcRepresentationMap(origin, body), moved)
        shape = make.createIfcShapeRepresentation(model.body, "Body", "MappedRepresentation", [item])
    elif shape_type == "faceted":
        bottom, top = ([point((float(x), float(y), z)) for x, y in KITCHEN] for z in (0.0, 2500.0))
        sides = [[bottom[i], bottom[i - 1], top[i - 1], top[i]] for i in range(4)]
        faces = [
            make.createIfcFace([make.createIfcFaceOuterBound(make.createIfcPolyLoop(loop), True)])
            for loop in (bottom[::-1], top, *sides)
        ]
        item = make.createIfcFacetedBrep(make.createIfcClosedShell(faces))
        shape = make.createIfcShapeRepresentation(model.body, "Body", "Brep", [item])
    else:
        from ifcopenshell.api import context

        plan = context.add_context(make, context_type="Plan")
        item = make.createIfcPolyline([point(tuple(map(float, corner))) for corner in [*KITCHEN, KITCHEN[0]]])
        shape = make.createIfcShapeRepresentation(plan, "FootPrint", "Curve2D", [item])
    space.Representation = make.createIfcProductDefinitionShape(None, None, [shape])
    (room,) = model.read(path)[0].floor
    assert room.polygon.area == pytest.approx(12)
    assert room.polygon.bounds == pytest.approx((1, 0, 5, 3) if shape_type == "mapped" else (0, 0, 4, 3))


@pytest.mark.parametrize(("width", "unit"), [(0.9, "metres"), (90.0, "centimetres"), (900.0, "millimetres")])
def test_a_missing_unit_is_taken_from_the_doors(width, unit, path):
    model = Model()
    ground = model.storey()
    scale = width / 900
    model.space(ground, [(x * scale, y * scale) for x, y in KITCHEN])
    model.door(ground, (0, 1000 * scale), width=width)
    model.file.by_type("IfcProject")[0].UnitsInContext = None
    with pytest.warns(PlanWarning, match=f"no unit of length, its doors fit {unit}"):
        (storey,) = model.read(path)
    assert storey.floor[1].polygon.area == pytest.approx(12)
    assert storey.floor.doors[0].width == pytest.approx(0.9)


@pytest.mark.parametrize("schema", ["IFC2X_FINAL", "IFC2X2_FINAL", "IFC20_LONGFORM", "IFC151"])
def test_schemas_of_2003_and_before_are_refused_by_name(schema, path):
    path.write_text(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
        f"FILE_SCHEMA(\n('{schema}'));\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"
    )
    with pytest.raises(PlanError, match=f"'{schema}'.*2003.*IFC4") as caught:
        read_ifc_plan(path)
    assert "\n" not in str(caught.value)
