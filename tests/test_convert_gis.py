"""Floors in formats of GIS programs, read again with what we did not write."""

import json
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element
from zipfile import ZipFile

import numpy as np
import pytest
from defusedxml import ElementTree
from PIL import Image
from shapely import LineString, Point, Polygon, box
from shapely.geometry import shape

import pianta
from pianta.errors import OptionError, PiantaError
from pianta.floor import Door, Floor, Furniture, Room
from pianta.io.georeference import Georeference
from pianta.io.writers._formats import FORMATS
from pianta.io.writers.doorways import place_points, reach_doors
from pianta.io.writers.label_images import STEP, color_room
from pianta.io.writers.room_uses import find_imdf_category, find_osm_use
from pianta.io.writers.storey_levels import number_storeys
from tests.command_line import run_pianta

NASTY = "A<b> & \"c\" 'd' / = 😀"
# Two rooms north of a corridor; the wall between is 0.2 m thick, and the doors are in its middle. A hole in room 2.
FLOOR = Floor(
    (
        Room(1, box(0, 2.2, 4, 5), "CLASSROOM", name=f"12 {NASTY}", partial=True, predicted=box(0, 2.2, 4, 7)),
        Room(2, Polygon(box(4.2, 2.2, 8, 5).exterior, [box(5, 3, 6, 4).exterior]), "STAIRS", probability=0.5),
        Room(3, box(0, 0, 8, 2), "CORRIDOR"),
    ),
    (
        Door((1, 3), LineString([(1, 2.1), (2, 2.1)]), 1.0),
        Door((2, 3), LineString([(6, 2.1), (7, 2.1)]), 1.0, "opening"),
        Door((3, None), LineString([(0, 0.5), (0, 1.5)]), 1.0),
    ),
    (LineString([(0, 2.1), (8, 2.1)]),),
    furniture=(Furniture(box(1, 3, 2, 4), 0.75),),
    possible_doors=(Door((1, 2), LineString([(4.1, 3), (4.1, 4)]), 1.0),),
)
UPPER = replace(FLOOR, doors=(), walls=(), furniture=(), possible_doors=(), rooms=FLOOR.rooms[1:2])
HOUSE = pianta.Building(
    (pianta.Storey(FLOOR, "ground", 0.0), pianta.Storey(UPPER, "first", 3.2)),
    NASTY,
    (pianta.Link("stairs", (("ground", 2), ("first", 2))),),
)
# An anchor at 45.5° north, 9.2° east, whose y axis leads to the north.
ANCHOR = Georeference("+proj=aeqd +lat_0=45.5 +lon_0=9.2 +datum=WGS84 +units=m +type=crs", (1, 0, 0, 0, 1, 0))
GML, CORE = "{http://www.opengis.net/gml/3.2}", "{http://www.opengis.net/indoorgml/1.0/core}"
HREF = "{http://www.w3.org/1999/xlink}href"


def write(building, tmp_path, to, georeference=None) -> tuple[Path, list[str]]:
    path = tmp_path / FORMATS[to].file
    notes = pianta.convert(building, path, to=to, georeference=georeference)
    return path, notes


class TestLayers:
    @pytest.mark.parametrize("to", ["gpkg", "geojson-layers"])
    def test_gdal_reads_metres_of_the_map(self, tmp_path, to):
        pyogrio = pytest.importorskip("pyogrio")
        pyproj = pytest.importorskip("pyproj")
        path, notes = write(HOUSE, tmp_path, to)
        for layer, count in {"rooms": 4, "doors": 3, "walls": 1, "furniture": 1, "possible_doors": 1}.items():
            file = path if to == "gpkg" else path / f"{layer}.geojson"
            info = pyogrio.read_info(file, layer=layer)
            assert info["features"] == count
            crs = pyproj.CRS(info["crs"])
            assert (crs.is_geographic, crs.axis_info[0].unit_name) == (False, "metre")
        assert notes == ["1 link between storeys (stairs, lifts) left out"]

    def test_a_geopackage_has_every_room(self, tmp_path):
        geopandas = pytest.importorskip("geopandas")
        path, _ = write(HOUSE, tmp_path, "gpkg")
        rooms = geopandas.read_file(path, layer="rooms")
        assert rooms["storey"].tolist() == ["ground"] * 3 + ["first"]
        assert rooms["level"].tolist() == [0, 0, 0, 1]
        assert rooms["name"][0] == f"12 {NASTY}"
        assert rooms.geometry[0].equals(FLOOR.rooms[0].polygon)
        assert rooms["area"].tolist() == pytest.approx([11.2, 9.64, 16, 9.64])
        doors = geopandas.read_file(path, layer="doors")
        assert doors["other_room"].isna().tolist() == [False, False, True]
        predicted = geopandas.read_file(path, layer="predicted_rooms")
        assert predicted.geometry[0].equals(box(0, 2.2, 4, 7))
        # The magic number of a GeoPackage: "GPKG"
        with closing(sqlite3.connect(path)) as database:
            assert database.execute("PRAGMA application_id").fetchone() == (0x47504B47,)

    def test_a_georeferenced_geopackage_is_where_the_anchor_is(self, tmp_path):
        geopandas = pytest.importorskip("geopandas")
        path, _ = write(HOUSE, tmp_path, "gpkg", ANCHOR)
        rooms = geopandas.read_file(path, layer="rooms")
        assert rooms.geometry[2].area == pytest.approx(16, abs=1e-6)
        west, south, *_ = rooms.to_crs("EPSG:4326").total_bounds
        assert (west, south) == pytest.approx((9.2, 45.5), abs=1e-7)

    @pytest.mark.parametrize("georeference", [None, ANCHOR])
    def test_geoparquet_names_its_coordinate_system(self, tmp_path, georeference):
        geopandas = pytest.importorskip("geopandas")
        parquet = pytest.importorskip("pyarrow.parquet")
        path, _ = write(HOUSE, tmp_path, "geoparquet", georeference)
        rooms = geopandas.read_parquet(path / "rooms.parquet")
        assert (len(rooms), rooms.crs is None) == (4, georeference is None)
        header = json.loads(parquet.read_schema(path / "rooms.parquet").metadata[b"geo"])
        column = header["columns"][header["primary_column"]]
        # A missing crs would mean degrees; null means unknown
        assert ("crs" in column, column["crs"] is None) == (True, georeference is None)
        assert (header["version"], column["encoding"], column["geometry_types"]) == ("1.1.0", "WKB", ["Polygon"])

    def test_geojson_layers_have_millimetres_or_degrees(self, tmp_path):
        third = Floor((Room(1, box(0, 0, 1 / 3, 2 / 3)),))
        path, _ = write(third, tmp_path, "geojson-layers")
        assert sorted(file.name for file in path.iterdir()) == ["doors.geojson", "rooms.geojson"]
        (room,) = json.loads((path / "rooms.geojson").read_bytes())["features"]
        assert room["geometry"]["coordinates"][0][0] == [0.333, 0]
        assert room["properties"]["area"] == 0.2222
        pytest.importorskip("pyproj")
        path, _ = write(third, tmp_path, "geojson-layers", ANCHOR)
        collection = json.loads((path / "rooms.geojson").read_bytes())
        assert "crs" not in collection
        outline = shape(collection["features"][0]["geometry"])
        assert outline.exterior.is_ccw
        assert outline.bounds == pytest.approx((9.2, 45.5, 9.2, 45.5), abs=1e-4)

    def test_an_empty_floor_has_empty_layers(self, tmp_path):
        geopandas = pytest.importorskip("geopandas")
        for to in ("gpkg", "geoparquet", "geojson-layers"):
            write(Floor(()), tmp_path, to)
        assert len(geopandas.read_file(tmp_path / "floor.gpkg", layer="rooms")) == 0
        assert len(geopandas.read_parquet(tmp_path / "geoparquet" / "rooms.parquet")) == 0


class TestDoorways:
    def test_rooms_reach_to_their_doors(self):
        polygons = reach_doors(FLOOR)
        # A doorway of 1 m x 0.1 m at each of the two doors of the corridor; the entrance is on its outline
        assert [polygons[room].area for room in (1, 2, 3)] == pytest.approx([11.3, 9.74, 16.2])
        for door in FLOOR.doors:
            points = place_points(door)
            for room in door.room_ids:
                corners = {*polygons[room].exterior.coords}
                assert {points.start, points.middle, points.end} <= corners
        assert polygons[1].intersection(polygons[3]).area == pytest.approx(0, abs=1e-9)

    def test_what_a_room_has_across_its_door_goes_to_the_other_room(self):
        # The border is at y = 3.1, the line of the door at y = 3
        rooms = Room(1, box(0, 0, 4, 3.1)), Room(2, box(0, 3.1, 4, 6))
        polygons = reach_doors(Floor(rooms, (Door((1, 2), LineString([(1, 3), (2, 3)]), 1.0),)))
        assert [polygons[room].area for room in (1, 2)] == pytest.approx([12.3, 11.7])
        assert all((1.5, 3) in polygons[room].exterior.coords for room in (1, 2))
        assert polygons[1].intersection(polygons[2]).area == pytest.approx(0, abs=1e-9)

    def test_a_door_far_from_its_room_leaves_the_room_as_it_is(self):
        room = Room(1, box(0, 0, 4, 3))
        far = Floor((room,), (Door((1, None), LineString([(1, 9), (2, 9)]), 1.0),))
        assert reach_doors(far)[1].equals(room.polygon)

    @pytest.mark.parametrize("world", ["corridor", "office", "ring"])
    def test_rooms_of_drawn_buildings_stay_valid_and_apart(self, world):
        floor, _ = pianta.make_world(world)
        polygons = reach_doors(floor)
        assert all(polygon.is_valid for polygon in polygons.values())
        grown = sum(polygon.area for polygon in polygons.values()) - sum(room.polygon.area for room in floor)
        assert 0 <= grown < 0.5 * len(floor.doors)
        shared = [door for door in floor.doors if _is_shared(door, polygons)]
        assert len(shared) == len(floor.doors)


def _is_shared(door, polygons) -> bool:
    middle = place_points(door).middle
    rings = {room: [polygons[room].exterior, *polygons[room].interiors] for room in door.room_ids}
    return all(any(middle in ring.coords for ring in each) for each in rings.values())


class TestOsm:
    def read(self, path) -> Element:
        root: Element = ElementTree.parse(path).getroot()
        assert (root.tag, root.get("version")) == ("osm", "0.6")
        nodes = {node.get("id"): node for node in root.iter("node")}
        ways = {way.get("id"): way for way in root.iter("way")}
        ids = [element.get("id", "") for element in root if element.tag in ("node", "way", "relation")]
        assert len({*ids}) == len(ids)
        assert all(int(each) < 0 for each in ids)
        assert all(abs(float(node.get("lat", "")) - 45.5) < 0.001 for node in nodes.values())
        for way in ways.values():
            refs = [nd.get("ref") for nd in way.iter("nd")]
            assert len(refs) >= 2
            assert {*refs} <= nodes.keys()
        assert all(member.get("ref") in ways for member in root.iter("member"))
        return root

    def tags(self, element) -> dict[str, str]:
        return {tag.get("k", ""): tag.get("v", "") for tag in element.iter("tag")}

    def test_doors_are_nodes_that_the_ways_of_rooms_share(self, tmp_path):
        pytest.importorskip("pyproj")
        path, notes = write(HOUSE, tmp_path, "osm", ANCHOR)
        root = self.read(path)
        doors = [node for node in root.iter("node") if "door" in self.tags(node)]
        users = [
            sum(door.get("id") in {nd.get("ref") for nd in way.iter("nd")} for way in root.iter("way"))
            for door in doors
        ]
        assert users == [2, 2, 1]
        assert [self.tags(door)["door"] for door in doors] == ["yes", "no", "yes"]
        assert self.tags(doors[2])["entrance"] == "yes"
        assert notes == ["1 link between storeys (stairs, lifts) left out"]

    def test_rooms_have_indoor_tags(self, tmp_path):
        pytest.importorskip("pyproj")
        path, _ = write(HOUSE, tmp_path, "osm", ANCHOR)
        root = self.read(path)
        ways = [self.tags(way) for way in root.iter("way")]
        assert {"indoor": "room", "level": "0", "ref": "12", "name": NASTY, "room": "classroom"} in ways
        assert {"indoor": "corridor", "level": "0"} in ways
        assert {"building": "yes", "min_level": "0", "max_level": "1", "name": NASTY} in ways
        relations = [self.tags(relation) for relation in root.iter("relation")]
        assert [(each["type"], each["room"], each["level"]) for each in relations] == [
            ("multipolygon", "stairs", "0"),
            ("multipolygon", "stairs", "1"),
        ]
        roles = [[member.get("role") for member in relation.iter("member")] for relation in root.iter("relation")]
        assert roles == [["outer", "inner"]] * 2
        outlines = [way for way in root.iter("way") if self.tags(way).get("indoor") in ("room", "corridor")]
        for way in outlines:
            refs = [nd.get("ref") for nd in way.iter("nd")]
            assert refs[0] == refs[-1]

    def test_osmag_passages_lead_to_areas_by_name(self, tmp_path):
        pytest.importorskip("pyproj")
        path, notes = write(HOUSE, tmp_path, "osmag", ANCHOR)
        root = self.read(path)
        ways = [(way, self.tags(way)) for way in root.iter("way")]
        areas = {tags["name"]: tags for _, tags in ways if tags["osmAG:type"] == "area"}
        passages = [(way, tags) for way, tags in ways if tags["osmAG:type"] == "passage"]
        assert len(areas) == 6  # four rooms, two storeys: no name occurs twice
        ends = {(tags["osmAG:from"], tags["osmAG:to"]) for _, tags in passages}
        nasty = f"12 {NASTY}"
        doors = {(nasty, "room 3"), ("room 2", "room 3"), ("room 3", "outside")}
        assert ends == doors | {("room 2", "room 2 2")}
        assert {tags["osmAG:areaType"] for tags in areas.values()} == {"structure", "room", "corridor", "stairs"}
        parents = {tags["osmAG:parent"] for tags in areas.values() if tags["osmAG:areaType"] != "structure"}
        assert parents == {"ground", "first"}
        # The ends of a passage are corners of both areas
        ways_of = {tags["name"]: {nd.get("ref") for nd in way.iter("nd")} for way, tags in ways if "name" in tags}
        for way, tags in passages[:2]:
            refs = {nd.get("ref") for nd in way.iter("nd")}
            assert refs <= ways_of[tags["osmAG:from"]]
            assert refs <= ways_of[tags["osmAG:to"]]
        (anchor,) = [node for node in root.iter("node") if self.tags(node).get("name") == "root"]
        assert (float(anchor.get("lat", "")), float(anchor.get("lon", ""))) == pytest.approx((45.5, 9.2))
        assert notes == [
            "2 holes of rooms left out, areas are without",
            "1 wall left out",
            "1 name of rooms got a number, as names are ids here",
        ]


# What the schema of the core module of IndoorGML allows in each element, in this order.
CHILDREN = {
    "IndoorFeatures": ("name", "primalSpaceFeatures", "multiLayeredGraph"),
    "PrimalSpaceFeatures": ("cellSpaceMember", "cellSpaceBoundaryMember"),
    "MultiLayeredGraph": ("spaceLayers",),
    "spaceLayers": ("spaceLayerMember",),
    "SpaceLayer": ("class", "nodes", "edges"),
    "nodes": ("stateMember",),
    "edges": ("transitionMember",),
    "CellSpace": ("description", "name", "cellSpaceGeometry", "duality", "partialboundedBy"),
    "CellSpaceBoundary": ("name", "duality", "cellSpaceBoundaryGeometry"),
    "State": ("name", "duality", "connects", "geometry"),
    "Transition": ("weight", "connects", "duality", "geometry"),
}


class TestIndoorGml:
    def test_elements_are_in_the_order_of_the_schema(self, tmp_path):
        path, notes = write(HOUSE, tmp_path, "indoorgml")
        root = ElementTree.parse(path).getroot()
        assert root.tag == f"{CORE}IndoorFeatures"
        # A feature is in an element of its role, which has no id
        for feature in ("PrimalSpaceFeatures", "MultiLayeredGraph"):
            (child,) = root.find(f"{CORE}{feature[0].lower()}{feature[1:]}")
            assert child.tag == f"{CORE}{feature}"
        for element in root.iter():
            tag = element.tag.removeprefix(CORE)
            if tag in CHILDREN:
                assert f"{GML}id" in element.attrib
                order = [CHILDREN[tag].index(child.tag.split("}")[1]) for child in element]
                assert order == sorted(order)
        assert notes == ["1 wall, 1 piece of furniture, 1 possible door left out, which cells and doors alone describe"]

    def test_every_reference_leads_to_its_dual(self, tmp_path):
        path, _ = write(HOUSE, tmp_path, "indoorgml")
        root = ElementTree.parse(path).getroot()
        every = [element.get(f"{GML}id") for element in root.iter() if f"{GML}id" in element.attrib]
        assert len({*every}) == len(every)
        by_id = {element.get(f"{GML}id"): element for element in root.iter() if f"{GML}id" in element.attrib}
        duals = {
            "CellSpace": "State",
            "State": "CellSpace",
            "CellSpaceBoundary": "Transition",
            "Transition": "CellSpaceBoundary",
        }
        for element in by_id.values():
            for child in element:
                target = child.get(HREF)
                if target is not None:
                    assert target[1:] in by_id
                if child.tag == f"{CORE}duality":
                    dual = by_id[child.get(HREF)[1:]]
                    assert dual.tag == CORE + duals[element.tag.removeprefix(CORE)]
                    assert dual.find(f"{CORE}duality").get(HREF)[1:] == element.get(f"{GML}id")
        counts = {tag: len(root.findall(f".//{CORE}{tag}")) for tag in duals}
        # Four rooms and the outside; three doors and the stairs
        assert counts == {"CellSpace": 4, "State": 5, "CellSpaceBoundary": 3, "Transition": 4}
        for transition in root.iter(f"{CORE}Transition"):
            assert len(transition.findall(f"{CORE}connects")) == 2

    def test_cells_are_at_the_height_of_their_storey(self, tmp_path):
        path, _ = write(HOUSE, tmp_path, "indoorgml")
        root = ElementTree.parse(path).getroot()
        cells = root.findall(f".//{CORE}CellSpace")
        heights, areas = [], []
        for cell in cells:
            rings = [np.array(each.text.split(), float).reshape(-1, 3) for each in cell.iter(f"{GML}posList")]
            heights.append({*np.vstack(rings)[:, 2]})
            areas.append(Polygon(rings[0][:, :2], [ring[:, :2] for ring in rings[1:]]).area)
        assert heights == [{0}, {0}, {0}, {3.2}]
        assert areas == pytest.approx([11.2, 9.64, 16, 9.64])
        assert [cell.find(f"{GML}name").text for cell in cells][:2] == [f"12 {NASTY}", "Room 2"]

    def test_a_building_without_rooms_is_refused(self, tmp_path):
        with pytest.raises(OptionError, match="needs a room"):
            write(Floor(()), tmp_path, "indoorgml")


class TestImdf:
    def read(self, path) -> dict[str, list[dict[str, Any]]]:
        with ZipFile(path) as archive:
            assert archive.testzip() is None
            manifest = json.loads(archive.read("manifest.json"))
            files = {name.removesuffix(".geojson"): json.loads(archive.read(name)) for name in archive.namelist()}
        files.pop("manifest.json")
        assert (manifest["version"], manifest["language"]) == ("1.0.0", "en")
        return {feature_type: content["features"] for feature_type, content in files.items()}

    def test_the_archive_obeys_the_rules(self, tmp_path):
        pytest.importorskip("pyproj")
        path, notes = write(HOUSE, tmp_path, "imdf", ANCHOR)
        files = self.read(path)
        required = {"address", "venue", "building", "footprint", "level", "unit", "opening"}
        assert required <= files.keys()
        features = {feature["id"]: feature for each in files.values() for feature in each}
        assert len(features) == sum(map(len, files.values()))
        for feature_type, each in files.items():
            assert all(feature["feature_type"] == feature_type for feature in each)
            for feature in each:
                properties = feature["properties"]
                references = {"address_id": "address", "level_id": "level"}
                for key, other in references.items():
                    if properties.get(key) is not None:
                        assert features[properties[key]]["feature_type"] == other
                for building in properties.get("building_ids", []):
                    assert features[building]["feature_type"] == "building"
                if properties.get("display_point") and feature["geometry"]:
                    assert shape(feature["geometry"]).distance(shape(properties["display_point"])) < 1e-8
        assert [feature["geometry"] for feature in files["address"] + files["building"]] == [None, None]
        assert "placeholders" in notes[0]

    def test_units_lie_in_their_levels_and_doors_on_their_outlines(self, tmp_path):
        pytest.importorskip("pyproj")
        path, _ = write(HOUSE, tmp_path, "imdf", ANCHOR)
        files = self.read(path)
        levels = {level["id"]: shape(level["geometry"]) for level in files["level"]}
        assert [level["properties"]["ordinal"] for level in files["level"]] == [0, 1]
        units = [(unit["properties"]["level_id"], shape(unit["geometry"])) for unit in files["unit"]]
        for level, unit in units:
            assert levels[level].buffer(1e-8).contains(unit)
        categories = [unit["properties"]["category"] for unit in files["unit"]]
        assert categories == ["classroom", "stairs", "walkway", "stairs"]
        assert files["unit"][0]["properties"]["name"] == {"en": f"12 {NASTY}"}
        for opening in files["opening"]:
            line = shape(opening["geometry"])
            assert line.geom_type == "LineString"
            touching = [unit for level, unit in units if unit.boundary.distance(line.centroid) < 1e-8]
            assert len(touching) == (1 if opening["properties"]["category"].endswith("principal") else 2)

    def test_ids_stay_when_it_is_written_again(self, tmp_path):
        pytest.importorskip("pyproj")
        first, _ = write(HOUSE, tmp_path, "imdf", ANCHOR)
        ids = {feature_type: [each["id"] for each in features] for feature_type, features in self.read(first).items()}
        again, _ = write(HOUSE, tmp_path, "imdf", ANCHOR)
        assert {
            feature_type: [each["id"] for each in features] for feature_type, features in self.read(again).items()
        } == ids


class TestImages:
    def test_pixels_of_a_palette_are_ids(self, tmp_path):
        floor, grid = pianta.make_world("corridor")
        path = tmp_path / "images"
        assert pianta.convert(floor, path, to="label-image", grid=grid) == []
        with Image.open(path / "labels.png") as image:
            assert (image.mode, image.size[::-1]) == ("P", grid.shape)
            assert (np.array(image) == floor.label_image(grid)).all()
            colours = {*map(tuple, np.array(image.convert("RGB")).reshape(-1, 3).tolist())}
        assert colours == {(255, 255, 255), *(color_room(room.id) for room in floor)}
        lines = (path / "colors.csv").read_text(encoding="utf-8").splitlines()
        # 0x9e, 0x37, 0x79
        assert lines[:2] == ["storey,id,red,green,blue,name,label", ",1,158,55,121,,CORRIDOR"]

    def test_large_ids_have_24_bits(self, tmp_path):
        floor, grid = pianta.make_world("corridor")
        large = replace(floor, rooms=(replace(floor.rooms[0], id=60000),), doors=(), last_id=0)
        path = tmp_path / "images"
        notes = pianta.convert(large, path, to="label-image", grid=grid)
        assert notes == ["labels.png has 24-bit colours, as ids are above 255"]
        with Image.open(path / "labels.png") as image:
            pixels = np.array(image).astype(int) @ [65536, 256, 1]
        # STEP is odd, so it has an inverse, which gives the ids back
        ids = pixels * pow(STEP, -1, 2**24) % 2**24
        assert (np.where(pixels == 0xFFFFFF, 0, ids) == large.label_image(grid)).all()

    def test_colours_are_different(self):
        colours = {color_room(room) for room in range(70_000)}
        assert len(colours) == 70_000

    def test_the_picture_has_a_legend_and_names(self, tmp_path):
        rooms = Room(1, box(0, 0, 4, 3)), Room(2, box(4, 0, 8, 3))
        doors = (Door((1, 2), LineString([(4, 0), (4, 1)]), 1.0),)
        opening = (Door((1, 2), LineString([(4, 2), (4, 3)]), 1.0, "opening"),)
        named = (replace(rooms[0], name="Store $1 $2"), rooms[1])
        floors = {"plain": Floor(rooms, doors), "named": Floor(named, doors), "both": Floor(named, doors + opening)}
        texts = {}
        for name, floor in floors.items():
            pianta.convert(floor, tmp_path / name, to="picture")
            texts[name] = (tmp_path / name / "picture.svg").read_text(encoding="utf-8")
        # Texts of the legend are comments beside their letters; a name is one more outline
        assert ["<!-- opening -->" in text for text in texts.values()] == [False, False, True]
        assert all("<!-- door -->" in text for text in texts.values())
        assert texts["named"].count("<path") == texts["plain"].count("<path") + 1

    def test_the_picture_is_an_svg_that_grows_with_the_rooms(self, tmp_path):
        floor, grid = pianta.make_world("corridor")
        pianta.convert(floor, tmp_path / "one", to="picture", grid=grid)
        many = Floor(tuple(Room(10 * x + y + 1, box(x, y, x + 0.9, y + 0.9)) for x in range(16) for y in range(10)))
        pianta.convert(many, tmp_path / "many", to="picture")
        sizes = []
        for name in ("one", "many"):
            root = ElementTree.parse(tmp_path / name / "picture.svg").getroot()
            assert root.tag == "{http://www.w3.org/2000/svg}svg"
            sizes.append(max(float(root.get(side).removesuffix("pt")) for side in ("width", "height")))
        # 8 inches of 72 points; 160 rooms are four times as many as usual
        assert sizes == pytest.approx([576, 1152], abs=1)


@pytest.mark.parametrize(
    ("label", "osm", "imdf"),
    [
        ("EXECUTIVE OFFICE", "office", "office"),
        ("WASHROOM", "toilets", "restroom"),
        ("CORRIDOR", "", "walkway"),
        ("ROOM", "", "room"),
        (None, "", "unspecified"),
        ("PASSENGER ELEVATOR", "elevator", "elevator"),
    ],
)
def test_labels_have_the_words_of_the_formats(label, osm, imdf):
    room = Room(1, box(0, 0, 1, 1), label)
    assert (find_osm_use(room), find_imdf_category(room)) == (osm, imdf)


@pytest.mark.parametrize(
    ("heights", "levels"),
    [((None,), [0]), ((-3.0, 0.0, 3.0), [-1, 0, 1]), ((None, None), [0, 1]), ((-6, -3), [0, 1]), ((0.2, 3), [0, 1])],
)
def test_level_0_is_at_the_ground(heights, levels):
    storeys = tuple(pianta.Storey(Floor(()), f"s{index}", height) for index, height in enumerate(heights))
    assert [*number_storeys(pianta.Building(storeys)).values()] == levels


@pytest.mark.parametrize("to", ["imdf", "osm", "osmag"])
def test_formats_of_the_earth_need_a_georeference(tmp_path, to):
    with pytest.raises(PiantaError, match="georeference"):
        write(HOUSE, tmp_path, to)


def test_other_formats_take_no_georeference(tmp_path):
    with pytest.raises(OptionError, match="takes no georeference"):
        write(HOUSE, tmp_path, "csv", ANCHOR)


def test_the_command_prints_how_well_control_points_fit(tmp_path):
    pytest.importorskip("pyproj")
    FLOOR.save(tmp_path / "floor.geojson")
    (tmp_path / "place.yaml").write_text(
        "{crs: 'EPSG:32632', points: [{map: [0, 0], world: [5e5, 5e6]}, "
        "{map: [8, 0], world: [500008, 5e6]}, {map: [0, 5], world: [5e5, 5000005]}]}"
    )
    georeference = tmp_path / "place.yaml"
    result = run_pianta("convert", tmp_path / "floor.geojson", "--to", "osm", "--georeference", georeference)
    assert (result.code, result.err) == (0, "")
    assert "EPSG:32632, control points are missed by 0.000, 0.000, 0.000 (root mean square 0.000)" in result.out
    assert (tmp_path / "building.osm").is_file()


def test_the_command_names_the_option_that_is_missing(tmp_path):
    FLOOR.save(tmp_path / "floor.geojson")
    result = run_pianta("convert", tmp_path / "floor.geojson", "--to", "imdf")
    assert (result.code, result.out) == (2, "")
    assert result.err == "error: format imdf needs longitudes and latitudes, give --georeference FILE\n"


def test_points_of_a_door_are_its_ends_and_the_middle():
    points = place_points(Door((1, None), LineString([(0, 0), (2, 0)]), 2.0))
    assert Point(points.middle).equals(Point(1, 0))
