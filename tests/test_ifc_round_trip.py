"""An IFC that was read goes back to IFC with its GlobalIds, numbers, names and storeys, as a user does it."""

import json
from pathlib import Path
from typing import Any

import pytest
from shapely import LineString, box

import pianta
from pianta.errors import FloorError
from pianta.io.drawings.ifc import read_ifc_plan
from tests.command_line import run_pianta
from tests.ifc_models import Model

ifcopenshell = pytest.importorskip("ifcopenshell", reason="pianta[bim] is not installed")

# Millimetres: two rooms with a wall of 200 between them, and one that touches the second.
ROOMS = {
    "0.01": [(0, 0), (4000, 0), (4000, 3000), (0, 3000)],
    "0.02": [(4200, 0), (8000, 0), (8000, 3000), (4200, 3000)],
    "0.03": [(8000, 0), (9500, 0), (9500, 3000), (8000, 3000)],
}


@pytest.fixture
def model():
    """Two storeys of three rooms, with doors between two of them and to the outside, and an open border."""
    model = Model()
    for name, height in (("EG / Ground", 0.0), ("1. OG", 3000.0)):
        storey = model.storey(name, height)
        spaces = [model.space(storey, corners, Name=number, LongName="Büro") for number, corners in ROOMS.items()]
        for space in spaces[1:]:
            model.bound(space, None, ConnectionGeometry=model.upright((8000, 500), (8000, 2500)))
        model.door(storey, (4100, 1000))
        model.door(storey, (0, 1000))
    return model


def run(*arguments: object) -> None:
    code, _, error = run_pianta(*arguments)
    assert not code, error


def collect(file: Path) -> tuple[set[Any], set[Any], set[str]]:
    """The GlobalId, Name and LongName of storeys, spaces and doors."""
    model = ifcopenshell.open(file)
    spaces = {(each.GlobalId, each.Name, each.LongName) for each in model.by_type("IfcSpace")}
    storeys = {(each.GlobalId, each.Name, each.Elevation) for each in model.by_type("IfcBuildingStorey")}
    return spaces, storeys, {each.GlobalId for each in model.by_type("IfcDoor")}


def test_global_ids_go_to_the_geojson_and_back(tmp_path, model):
    model.file.write(str(tmp_path / "plan.ifc"))
    run("read", tmp_path / "plan.ifc", "-o", tmp_path / "out")
    folders = sorted(folder.name for folder in (tmp_path / "out").iterdir() if folder.is_dir())
    assert folders == ["1. OG", "EG Ground"]
    floor = json.loads((tmp_path / "out" / "EG Ground" / "floor.geojson").read_text(encoding="utf-8"))
    assert (floor["title"], floor["elevation"]) == ("EG / Ground", 0)
    assert floor["global_id"] == model.file.by_type("IfcBuildingStorey")[0].GlobalId
    rooms = [each["properties"] for each in floor["features"] if each["properties"]["class"] == "room"]
    assert [(each["number"], each["name"]) for each in rooms] == [(number, "Büro") for number in ROOMS]
    run("convert", tmp_path / "out", "--to", "ifc", "-o", tmp_path / "back.ifc")
    spaces, storeys, doors = collect(tmp_path / "back.ifc")
    old_spaces, old_storeys, old_doors = collect(tmp_path / "plan.ifc")
    assert (spaces, doors) == (old_spaces, old_doors)
    assert storeys == {(key, name, height / 1000) for key, name, height in old_storeys}
    ground, first = read_ifc_plan(tmp_path / "back.ifc")
    assert sorted(door.rooms for door in ground.floor.doors if door.joins_rooms) == [(1, 2), (2, 3)]
    assert [door.is_entrance for door in ground.floor.doors if not door.joins_rooms] == [True]
    assert [door.is_entrance for door in first.floor.doors if not door.joins_rooms] == [False]
    (opening,) = (door for door in ground.floor.doors if door.kind == "opening")
    assert opening.rooms == (2, 3)
    assert opening.width == pytest.approx(2)


def test_tables_have_numbers_and_global_ids(tmp_path, model):
    model.file.write(str(tmp_path / "plan.ifc"))
    run("read", tmp_path / "plan.ifc", "-o", tmp_path / "out")
    run("convert", tmp_path / "out", "--to", "csv", "-o", tmp_path / "rooms.csv")
    header, first, *_ = (line.split(",") for line in (tmp_path / "rooms.csv").read_text(encoding="utf-8").splitlines())
    row = dict(zip(header, first, strict=True))
    assert (row["number"], row["name"]) == ("0.01", "Büro")
    assert row["global_id"] == model.file.by_type("IfcSpace")[0].GlobalId


def test_a_floor_keeps_the_values_of_an_ifc_in_its_file(tmp_path):
    floor = pianta.Floor(
        (
            pianta.Room(
                1, box(0, 0, 4, 3), name="Flat roof", number="D.1", global_id="3$f2p7VyLB7eox67SA_zKE", flag="roof"
            ),
        ),
        (pianta.Door((1, None), LineString([(0, 1), (0, 2)]), 1.0, leads_out=False, global_id="door"),),
        title="Dach",
        elevation=6.2,
        global_id="3XCneI9iz229MqbsDmyZvc",
    )
    floor.save(tmp_path / "floor.geojson")
    assert pianta.read_floor(tmp_path / "floor.geojson") == floor
    storey = pianta.Storey(floor)
    assert (storey.title, storey.elevation) == ("Dach", 6.2)
    assert floor.graph().nodes[1]["entrances"] == 0


@pytest.mark.parametrize("identifier", ["x" * 65, " ", "a\nb"])
def test_identifiers_that_are_no_text_are_refused(identifier):
    with pytest.raises(FloorError, match="identifier"):
        pianta.Room(1, box(0, 0, 1, 1), global_id=identifier)


def test_identifiers_that_no_ifc_can_have_are_new(tmp_path):
    """Two rooms with one identifier, and one whose identifier is too short: two of the three are new."""
    same = "3$f2p7VyLB7eox67SA_zKE"
    rooms = [pianta.Room(n, box(5 * n, 0, 5 * n + 4, 3), global_id=key) for n, key in enumerate((same, same, "7"), 1)]
    assert pianta.convert(pianta.Floor(tuple(rooms)), tmp_path / "a.ifc", to="ifc") == [
        "2 identifiers that no IFC can have, or that occur twice, are new"
    ]
    identifiers = [space.GlobalId for space in ifcopenshell.open(tmp_path / "a.ifc").by_type("IfcSpace")]
    assert (identifiers[0], len({*identifiers}), {len(each) for each in identifiers}) == (same, 3, {22})
