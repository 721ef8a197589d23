"""Floors as worlds of simulators, homes and scene graphs."""

import json
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import pianta
from pianta.errors import PlanError
from pianta.io.drawings.sweethome3d import MAX_HOME_BYTES, read_sweethome3d
from pianta.io.ros_maps import read_ros_map
from pianta.io.writers.scene_graph import node_id
from tests.test_convert_cad import FLOOR, HOUSE

NUMBERS = re.compile(r"[-+0-9.e ]+")


def check_sdf(path: Path) -> list[str]:
    """Faults by the rules of SDF 1.9: names, poses and sizes."""
    etree = pytest.importorskip("lxml.etree")
    root = etree.parse(path).getroot()
    faults = [] if (root.tag, root.get("version")) == ("sdf", "1.9") else ["no SDF 1.9"]
    for element in root.iter():
        names = [child.get("name") for child in element if child.tag in {"model", "link", "frame", "joint", "light"}]
        names += [child.get("name") for child in element if child.tag == "world"]
        for tag in ("collision", "visual"):
            own = [child.get("name") for child in element if child.tag == tag]
            faults += [f"{tag}s have one name"] if len({*own}) < len(own) else []
        faults += [f"siblings have one name: {names}"] if len({*names}) < len(names) else []
        faults += [f"name {name}" for name in names if not name or "::" in name or name.startswith("__")]
        if element.tag == "pose":
            values = element.text.split()
            faults += [] if len(values) == 6 and np.isfinite([*map(float, values)]).all() else [f"pose {element.text}"]
        if element.tag == "size" and element.getparent().tag == "box":
            values = [*map(float, element.text.split())]
            faults += [] if len(values) == 3 and min(values) > 0 else [f"size {element.text}"]
        if element.tag == "model" and not element.findall("link"):
            faults.append("a model without a link")
    return faults


def list_boxes(path: Path, prefix: str) -> list[tuple[list[float], list[float]]]:
    etree = pytest.importorskip("lxml.etree")
    boxes = []
    for collision in etree.parse(path).getroot().iter("collision"):
        if collision.get("name").startswith(prefix):
            pose, size = collision.findtext("pose"), collision.findtext("geometry/box/size")
            boxes.append(([*map(float, pose.split())], [*map(float, size.split())]))
    return boxes


def test_gazebo_has_walls_with_gaps_at_doors(tmp_path):
    building = pianta.Building(HOUSE.storeys, "House::<1>")
    notes = pianta.convert(building, tmp_path / "gazebo", to="gazebo")
    assert notes == ["a world has no :: and no __ around its name, this one is named House-<1>"]
    world = tmp_path / "gazebo" / "world.sdf"
    assert check_sdf(world) == []
    # The wall between rooms 1 and 3, with a door from x = 1 to 2; all walls are 2.7 m high
    row = [(pose, size) for pose, size in list_boxes(world, "wall") if pose[1] == 2.1 and size[1] == 0.2]
    assert all(size[2] == 2.7 and pose[2] == 1.35 for pose, size in row)
    for pose, size in row:
        assert not pose[0] - size[0] / 2 < 1.5 < pose[0] + size[0] / 2
    lintels = list_boxes(world, "lintel")
    assert lintels[0][0][:3] == pytest.approx([1.5, 2.1, 2.35])
    assert len(lintels) == 2  # none over the opening
    rooms = json.loads((tmp_path / "gazebo" / "rooms.json").read_text(encoding="utf-8"))
    assert rooms[0]["frame"] == "storey_0::room_1"
    assert (rooms[0]["name"], rooms[0]["label"], rooms[3]["z"]) == ("2502C Rossi & <Figli>", "OFFICE", 3.2)


def test_stage_has_an_image_a_world_and_a_map(tmp_path):
    notes = pianta.convert(HOUSE, tmp_path / "stage", to="stage")
    assert notes == ["each storey is a world of its own", "Stage holds no 1 link between storeys, left out"]
    names = {file.name for file in (tmp_path / "stage").iterdir()}
    assert names == {f"{storey}.{end}" for storey in ("ground", "first") for end in ("world", "png", "yaml")}
    grid = read_ros_map(tmp_path / "stage" / "ground.yaml")
    rows, cols = grid.shape
    world = (tmp_path / "stage" / "ground.world").read_text(encoding="utf-8")
    (width, height, _), (x, y, *_) = (
        [*map(float, re.findall(rf"{key} \[ ([-\d. ]+) \]", world.split("\nfloorplan\n")[1])[0].split())]
        for key in ("size", "pose")
    )
    assert (width, height) == pytest.approx((cols * 0.05, rows * 0.05))
    assert (x - width / 2, y - height / 2) == pytest.approx(grid.origin[:2])
    with Image.open(tmp_path / "stage" / "ground.png") as image:
        assert image.size == (cols, rows)

    def at(x: float, y: float) -> int:
        return int(grid.cells[rows - 1 - int((y - grid.origin[1]) / 0.05), int((x - grid.origin[0]) / 0.05)])

    # In room 1, in the wall between the rooms, in the door, on the table
    assert (at(0.5, 4.5), at(4.1, 4), at(1.5, 2.1), at(1.5, 3.5)) == (0, 100, 0, 100)


def test_pianta_reads_the_map_of_stage(tmp_path):
    floor, _ = pianta.make_world("corridor")
    pianta.convert(floor, tmp_path / "stage", to="stage")
    read = pianta.reconstruct(pianta.read_map(tmp_path / "stage" / "floor.yaml"))
    assert (len(read), len(read.doors)) == (19, 20)


def test_sweet_home_gives_back_rooms_doors_and_names(tmp_path):
    notes = pianta.convert(HOUSE, tmp_path / "house.sh3d", to="sweethome3d")
    assert notes == [
        "1 room with holes: their outlines lead around the holes",
        "Sweet Home 3D holds no 1 link between storeys, left out",
    ]
    ground, first = pianta.read(tmp_path / "house.sh3d", labels=False).storeys
    assert (ground.title, ground.elevation, first.elevation) == ("Ground floor", 0, 3.2)
    for room, twin in zip(FLOOR, ground.floor, strict=True):
        assert room.polygon.symmetric_difference(twin.polygon).area < 1e-4
    assert [room.name for room in ground.floor] == ["2502C Rossi & <Figli>", '50%%d ^J "x" 🏠', "CORRIDOR"]
    # The opening is a gap in the wall
    assert [door.rooms for door in ground.floor.doors] == [(1, 3), (3, None)]


def test_home_follows_the_order_of_its_document_type(tmp_path):
    etree = pytest.importorskip("lxml.etree")
    pianta.convert(HOUSE, tmp_path / "house.sh3d", to="sweethome3d")
    with zipfile.ZipFile(tmp_path / "house.sh3d") as archive:
        assert archive.testzip() is None
        assert archive.namelist() == ["Home.xml", "0/box.obj"]
        root = etree.fromstring(archive.read("Home.xml"))
    # level*, (pieceOfFurniture | doorOrWindow)*, wall*, room*
    order = {"level": 0, "doorOrWindow": 1, "pieceOfFurniture": 1, "wall": 2, "room": 3}
    positions = [order[element.tag] for element in root]
    assert positions == sorted(positions)
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    assert len({*ids}) == len(ids)
    levels = {element.get("id") for element in root.findall("level")}
    assert {element.get("level") for element in root if element.get("level")} == levels


def test_a_home_drawn_by_hand(tmp_path):
    """Without levels, with a window, a door in a group, and a room of two corners."""
    home = """<?xml version='1.0'?><home version='6600' name='x'>
    <doorOrWindow id='a' name='Door' x='400' y='150' angle='1.5707964' width='90' depth='10' height='200'/>
    <furnitureGroup name='g' x='0' y='0'>
    <doorOrWindow name='Front' x='200' y='300' width='80' depth='10' height='200'/></furnitureGroup>
    <doorOrWindow name='Window' x='100' y='0' elevation='90' width='80' depth='10' height='120'/>
    <room name='Bad'><point x='0' y='0'/><point x='1' y='x'/></room>
    <room name='Kitchen'><point x='0' y='0'/><point x='395' y='0'/><point x='395' y='295'/><point x='0' y='295'/></room>
    <room><point x='405' y='0'/><point x='800' y='0'/><point x='800' y='295'/><point x='405' y='295'/></room></home>"""
    with zipfile.ZipFile(tmp_path / "home.sh3d", "w") as archive:
        archive.writestr("Home.xml", home)
        archive.writestr("../../evil.txt", "never extracted")
    (storey,) = read_sweethome3d(tmp_path / "home.sh3d")
    assert [(room.name, round(room.polygon.area, 4)) for room in storey.floor] == [
        ("Kitchen", 11.6525),
        (None, 11.6525),
    ]
    assert [(door.rooms, round(door.width, 3)) for door in storey.floor.doors] == [((1, 2), 0.9), ((1, None), 0.8)]
    assert not (tmp_path.parent.parent / "evil.txt").exists()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("<home/>", "has no rooms"),
        ("<house/>", "is no home of Sweet Home 3D"),
        ("<home", "damaged Home.xml"),
        ("<!DOCTYPE home [<!ENTITY a 'b'>]><home>&a;</home>", "declares a document type"),
        (" " * (MAX_HOME_BYTES + 1), "of more than"),
        (None, "has no Home.xml"),
    ],
    ids=["empty", "other", "damaged", "entities", "bomb", "old"],
)
def test_hostile_homes_are_refused_in_one_line(content, message, tmp_path):
    with zipfile.ZipFile(tmp_path / "home.sh3d", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("Home" if content is None else "Home.xml", content or "")
    with pytest.raises(PlanError, match=message) as raised:
        read_sweethome3d(tmp_path / "home.sh3d")
    assert "\n" not in str(raised.value)


def test_what_is_no_zip_is_refused(tmp_path):
    (tmp_path / "home.sh3d").write_bytes(b"PK\x03\x04 cut off")
    with pytest.raises(PlanError, match="is no home of Sweet Home 3D or damaged"):
        read_sweethome3d(tmp_path / "home.sh3d")


def test_scene_graph_has_the_ids_of_spark_dsg(tmp_path):
    assert node_id("R", 0) == 5908722711110090752 > 2**53
    notes = pianta.convert(HOUSE, tmp_path / "graph.json", to="scene-graph")
    assert notes == [
        "a scene graph holds no 1 entrance, left out",
        "room 3 of the second storey is R(1000003), of the third R(2000003)",
    ]
    graph = json.loads((tmp_path / "graph.json").read_text(encoding="utf-8"))
    nodes = {node["id"]: node for node in graph["nodes"]}
    assert [node - node_id("R", 0) for node in nodes if nodes[node]["layer"] == 4] == [1, 2, 3, 1_000_001]
    first = nodes[node_id("R", 1)]["attributes"]
    assert first["type"] == "RoomNodeAttributes"
    assert first["bounding_box"]["dimensions"] == pytest.approx([4, 3, 2.7])
    assert first["bounding_box"]["world_P_center"] == pytest.approx([2, 3.7, 1.35])
    assert first["semantic_class_probabilities"] == {"OFFICE": 1.0}
    assert (first["name"], first["semantic_label"]) == ("2502C Rossi & <Figli>", 2**32 - 1)
    ends = {(edge["source"] - node_id("R", 0), edge["target"] - node_id("R", 0)) for edge in graph["edges"]}
    assert {(1, 3), (2, 3), (3, 1_000_001)} <= ends
    assert all(edge["source"] in nodes and edge["target"] in nodes for edge in graph["edges"])


def test_scene_graph_loads_in_spark_dsg(tmp_path):
    spark_dsg = pytest.importorskip("spark_dsg")
    pianta.convert(HOUSE, tmp_path / "graph.json", to="scene-graph")
    graph = spark_dsg.DynamicSceneGraph.load(str(tmp_path / "graph.json"))
    assert (graph.num_nodes(), graph.num_edges()) == (5, 7)


def test_a_home_with_damaged_lzma_is_refused(tmp_path):
    path = tmp_path / "home.sh3d"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("Home.xml", "<home>" + "<room/>" * 100 + "</home>")
    content = bytearray(path.read_bytes())
    start = content.index(b"Home.xml") + len("Home.xml")
    # After the header of LZMA, which has nine bytes
    content[start + 12 : start + 24] = b"\xff" * 12
    path.write_bytes(content)
    with pytest.raises(PlanError, match=r"is no home of Sweet Home 3D or damaged, save it again: Corrupt input data$"):
        read_sweethome3d(path)
