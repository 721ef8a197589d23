"""Floors with shapes and texts that other formats cannot hold, converted as a user does it."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
import shapely
from defusedxml import ElementTree
from shapely import LineString, Polygon, box

import pianta
from pianta.errors import FloorError, OptionError
from pianta.io.floors import LOCAL_CRS
from pianta.io.writers._formats import FORMATS
from pianta.io.writers.writable_parts import MAX_ID, keep_writable
from tests.command_line import list_files, run_pianta

ROOMS = (pianta.Room(1, box(0, 0, 4, 3), "OFFICE"), pianta.Room(2, box(4.2, 0, 8, 3), "CORRIDOR"))
DOOR = pianta.Door((1, 2), LineString([(4.1, 1), (4.1, 2)]), 1.0)
ANCHOR = "{latitude: 45.4785, longitude: 9.2327, bearing: 30}"
# Formats of shapes, which need no map of the floor.
SHAPES = sorted(name for name, each in FORMATS.items() if not each.needs_map and name not in {"valetudo", "map-card"})


def keep(floor: pianta.Floor) -> tuple[pianta.Floor, list[str]]:
    building, notes = keep_writable(pianta.Building((pianta.Storey(floor),)))
    return building.storeys[0].floor, notes


def test_a_sound_floor_stays_as_it_is():
    floor = pianta.Floor(ROOMS, (DOOR,), furniture=(pianta.Furniture(box(1, 1, 2, 2)),))
    assert keep(floor) == (floor, [])


def test_a_door_without_length_is_put_along_the_nearest_side():
    door = pianta.Door((1, 2), LineString([(4.1, 1), (4.1, 1)]), 0.8)
    floor, notes = keep(pianta.Floor(ROOMS, (door,)))
    assert shapely.get_coordinates(floor.doors[0].line).ravel() == pytest.approx([4.1, 0.6, 4.1, 1.4])
    assert notes == ["1 door without length drawn along the outline of the room"]


@pytest.mark.parametrize("width", [0.0, 1e300])
def test_a_door_without_length_and_with_an_impossible_width_has_a_usual_one(width):
    loop = pianta.Door((1, None), LineString([(2, 0), (3, 0), (2, 0)]), width)
    floor, _ = keep(pianta.Floor(ROOMS, (loop,)))
    assert floor.doors[0].line.length == pytest.approx(0.9)


def test_parts_without_size_are_left_out_and_named():
    sliver = Polygon([(20, 0), (21, 1e-9), (21, 0)])
    floor = pianta.Floor(
        (*ROOMS, pianta.Room(3, sliver)),
        (DOOR, pianta.Door((2, 3), LineString([(8, 1), (8, 2)]), 1.0)),
        walls=(LineString([(0, 0), (0, 0)]), LineString([(0, 0), (1, 0)])),
        furniture=(pianta.Furniture(box(1, 1, 1 + 1e-9, 2)),),
    )
    written, notes = keep(floor)
    assert ([room.id for room in written], written.doors, len(written.walls), written.furniture) == (
        [1, 2],
        (DOOR,),
        1,
        (),
    )
    assert notes == [
        "1 room (3) without area left out, with doors",
        "1 piece of furniture without area left out",
        "1 wall without length left out",
    ]


def test_links_to_rooms_without_area_are_left_out():
    sliver = pianta.Room(1, Polygon([(0, 0), (1, 1e-9), (1, 0)]))
    storeys = (pianta.Storey(pianta.Floor(ROOMS), "ground"), pianta.Storey(pianta.Floor((sliver,)), "first"))
    link = pianta.Link("stairs", (("ground", 1), ("first", 1)))
    written, notes = keep_writable(pianta.Building(storeys, "House", (link,)))
    assert written.links == ()
    assert notes == [
        "storey first: 1 room (1) without area left out, with doors",
        "1 link to rooms without area left out",
    ]


def test_labels_are_cleaned():
    labels, probabilities = {"a\x00": "b\x1b[31m"}, {"a\x00": {"b\x1b[31m": 0.5}}
    room = pianta.Room(1, box(0, 0, 4, 3), "b\x1b[31m", labels, probabilities)
    floor, notes = keep(pianta.Floor((room, pianta.Room(2, box(5, 0, 6, 1), "x" * 201))))
    assert (floor[1].label, floor[1].labels, floor[1].label_probability) == ("b [31m", {"a": "b [31m"}, 0.5)
    assert floor[2].label == "x" * 200
    assert notes == ["characters that cannot be printed, and all after 200, left out in 2 labels"]


def test_names_of_buildings_and_storeys_are_cleaned():
    building = pianta.Building((pianta.Storey(pianta.Floor(ROOMS), title="a\nb"),), "c\x00d")
    written, notes = keep_writable(building)
    assert (written.name, written.storeys[0].title) == ("c d", "a b")
    assert len(notes) == 1


def test_names_of_folders_and_large_ids_are_refused():
    with pytest.raises(FloorError, match=r"^storey 'a\\x00' has a name that cannot be printed, rename it$"):
        keep_writable(pianta.Building((pianta.Storey(pianta.Floor(ROOMS), "a\x00"),)))
    with pytest.raises(FloorError, match=f"^room id is {MAX_ID + 1}, other formats hold up to {MAX_ID}; read the map"):
        keep(pianta.Floor((pianta.Room(MAX_ID + 1, box(0, 0, 1, 1)),)))


def test_ids_of_a_scene_graph_differ_where_ids_of_rooms_are_large(tmp_path):
    floors = [pianta.Floor((pianta.Room(number, box(0, 0, 1, 1)),)) for number in (3_000_001, 1)]
    building = pianta.Building(tuple(pianta.Storey(floor, name) for floor, name in zip(floors, "abc", strict=False)))
    more = pianta.Building((*building.storeys, pianta.Storey(floors[1], "c"), pianta.Storey(floors[1], "d")))
    pianta.convert(more, tmp_path / "graph.json", to="scene-graph")
    ids = [node["id"] for node in json.loads((tmp_path / "graph.json").read_text())["nodes"]]
    assert len(ids) == len({*ids}) == 5


def hostile_folder(folder: Path) -> Path:
    """A floor.geojson as another program could write it: no door, room or label is sound."""
    shapes = {
        1: [[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]],
        2: [[4.2, 0], [8, 0], [8, 3], [4.2, 3], [4.2, 0]],
        3: [[0, 0], [5e-324, 0], [1, 1], [0, 0]],
    }
    features = [
        {
            "type": "Feature",
            "properties": {"class": "room", "room": number, "label": "]]>\x00\x1b[31m\ufffe<script>", "name": "=1+1"},
            "geometry": {"type": "Polygon", "coordinates": [shape]},
        }
        for number, shape in shapes.items()
    ]
    features += [
        {
            "type": "Feature",
            "properties": {"class": "door", "rooms": [1, 2], "width": 1e9, "kind": door_kind},
            "geometry": {"type": "LineString", "coordinates": line},
        }
        for door_kind in ("door", "opening")
        for line in ([[4.1, 1], [4.1, 1]], [[4.1, 1], [5, 1], [4.1, 1]], [[4.1, 1], [4.1, 1.00001]])
    ]
    content = {
        "type": "FeatureCollection",
        "format": "pianta floor",
        "version": "2.5",
        "frame": "map",
        "units": "metres",
        "crs": {"type": "name", "properties": {"name": LOCAL_CRS}},
        "features": features,
    }
    folder.mkdir()
    (folder / "floor.geojson").write_text(json.dumps(content), encoding="utf-8")
    return folder


@pytest.mark.parametrize("name", SHAPES)
def test_every_format_of_a_hostile_floor_is_written_or_refused_in_one_line(tmp_path, name):
    for package in FORMATS[name].packages:
        pytest.importorskip(package)
    target = tmp_path / "out" / FORMATS[name].file
    target.parent.mkdir()
    arguments = ["convert", hostile_folder(tmp_path / "floor"), "--to", name, "-o", target]
    if FORMATS[name].needs_georeference:
        (tmp_path / "anchor.yaml").write_text(ANCHOR)
        arguments += ["--georeference", tmp_path / "anchor.yaml"]
    outcome = run_pianta(*arguments)
    assert (outcome.code, outcome.err) == (0, "")
    assert "without area left out" in outcome.out
    for file, content in list_files(target.parent).items():
        assert not Path(file).name.startswith(".pianta"), file
        if Path(file).suffix in {".svg", ".gml", ".osm", ".sdf"}:
            ElementTree.fromstring(content)
        assert b"\x00\x1b[31m" not in content
    if name == "ifc":
        import ifcopenshell.validate

        log = ifcopenshell.validate.json_logger()
        ifcopenshell.validate.validate(ifcopenshell.open(str(target)), log)
        assert log.statements == []
    if name in {"osm", "osmag"}:
        root = ElementTree.parse(target).getroot()
        for element in root:
            keys = [tag.get("k") for tag in element.findall("tag")]
            assert len(keys) == len({*keys})
        assert all(len(way.findall("nd")) > 1 for way in root.findall("way"))
    if name in {"gpkg", "geoparquet", "geojson-layers"}:
        import geopandas

        if name == "gpkg":
            tables = [geopandas.read_file(target, layer=layer) for layer in ("rooms", "doors")]
        else:
            read = geopandas.read_parquet if name == "geoparquet" else geopandas.read_file
            tables = [read(file) for file in sorted(target.iterdir())]
        assert all(table.is_valid.all() for table in tables)


def test_an_image_larger_than_memory_is_refused(tmp_path):
    floor = pianta.Floor((ROOMS[0], pianta.Room(2, box(1e8 - 8, 1e8 - 3, 1e8, 1e8))))
    with pytest.raises(OptionError, match=r"^the image of 100000003 m × 100000003 m would have .* pixels, the limit"):
        pianta.convert(floor, tmp_path / "stage", to="stage")
    assert not (tmp_path / "stage").exists()


class TestOutputs:
    @pytest.mark.parametrize("name", ["csv", "stage"])
    def test_a_pipe_is_not_replaced(self, tmp_path, name):
        folder = hostile_folder(tmp_path / "floor")
        pipe = tmp_path / "pipe" if name == "csv" else tmp_path / "out" / "floor.world"
        pipe.parent.mkdir(exist_ok=True)
        os.mkfifo(pipe)
        outcome = run_pianta("convert", folder, "--to", name, "-o", pipe if name == "csv" else pipe.parent)
        assert outcome.code == 2
        assert "is a device or pipe, give" in outcome.err
        assert outcome.err.count("\n") == 1
        assert pipe.is_fifo()

    def test_stdout_a_missing_folder_a_loop_and_a_long_name_are_refused(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        folder = hostile_folder(tmp_path / "floor")
        Path("loop").symlink_to("loop")
        for name, reason in {
            "-": "output is -, and convert does not write to stdout; give the name of a file",
            "no/x": "output 'no/x': folder 'no' does not exist, create it",
            "loop": "output 'loop' cannot be written: Too many levels of symbolic links",
            "x" * 300: f"output '{'x' * 147}...{'x' * 148}' cannot be written: File name too long",
        }.items():
            outcome = run_pianta("convert", folder, "--to", "csv", "-o", name)
            assert (outcome.code, outcome.err) == (2, f"error: {reason}\n")
        assert sorted(path.name for path in tmp_path.iterdir()) == ["floor", "loop"]


def test_a_map_far_from_zero_is_refused_by_its_origin(tmp_path):
    cells = np.full((60, 60), 100, np.int8)
    cells[5:55, 5:55] = 0
    pianta.GridMap(cells, 0.05, (1e9, 0.0, 0.0)).save(tmp_path / "map.npz")
    outcome = run_pianta("read", tmp_path / "map.npz", "-o", tmp_path / "out", "--no-labels")
    assert outcome.code == 2
    assert outcome.err.endswith(
        "its origin, (1000000000.0, 0.0), is farther than 5e+07 m from zero; check the origin\n"
    )
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("radius", ["1e-9", "nan", "-1", "10"])
def test_robots_smaller_than_a_cell_or_larger_than_a_room_are_refused(tmp_path, radius):
    folder = hostile_folder(tmp_path / "floor")
    outcome = run_pianta("convert", folder, "--to", "cleaning", "--robot-radius", radius, "-o", tmp_path / "a.json")
    assert (outcome.code, outcome.err.count("\n")) == (2, 1)
    assert "give metres from 0.01 to below 10" in outcome.err
