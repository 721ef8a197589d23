"""Valetudo's map JSON: a map, a truth, and what is written for vacuums."""

import json
import struct
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image
from shapely import box

import pianta
from pianta.errors import BuildingError, BuildingWarning, MapError, OptionError
from pianta.io.vacuum_segments import name_rooms
from pianta.io.valetudo import parse_vacuum_map, read_vacuum_map
from pianta.plan.sheets.map_or_plan import detect_input_kind
from tests.conftest import DATA

# Two segments of 3 × 2 and 2 × 2 pixels of 5 cm with a wall between them, and a pixel of floor below.
LAYERS = [
    {"type": "wall", "pixels": [13, 20, 13, 21], "metaData": {"area": 50}},
    {"type": "segment", "compressedPixels": [10, 20, 3, 10, 21, 3], "metaData": {"segmentId": "16", "name": " Küche "}},
    {"type": "segment", "compressedPixels": [14, 20, 2, 14, 21, 2], "pixels": [], "metaData": {"segmentId": 17}},
    {"type": "floor", "pixels": [10, 22], "metaData": {}},
]
CELLS = [[0, 0, 0, 100, 0, 0], [0, 0, 0, 100, 0, 0], [0, -1, -1, -1, -1, -1]]
MEMBERS = {
    "__class": "ValetudoMap",
    "metaData": {"version": 2, "vendorMapId": 7},
    "size": {"x": 5120, "y": 5120},
    "pixelSize": 5,
    "layers": LAYERS,
    "entities": [{"type": "charger_location", "points": [60, 105]}],
}


def write(path: Path, **changes: object) -> Path:
    path.write_text(json.dumps({**MEMBERS, **changes}), encoding="utf-8")
    return path


def write_png(path: Path, content: bytes) -> Path:
    """A PNG of one white pixel, with the map in a chunk of compressed text."""
    Image.new("RGB", (1, 1), "white").save(path)
    text = b"ValetudoMap\0\0" + zlib.compress(content)
    chunk = struct.pack(">I", len(text)) + b"zTXt" + text + struct.pack(">I", zlib.crc32(b"zTXt" + text))
    png = path.read_bytes()
    path.write_bytes(png[:33] + chunk + png[33:])  # after the signature and the first chunk
    return path


def read_or_fail(path: Path) -> str:
    """What is wrong with a map; another exception than ours fails the test."""
    try:
        return repr(pianta.read_map(path, max_cells=100_000))
    except MapError as error:
        return str(error)


class TestMap:
    def test_floor_and_segments_are_free(self, tmp_path):
        grid = pianta.read_map(write(tmp_path / "map.json"))
        assert grid.cells.tolist() == CELLS
        assert grid.resolution == 0.05
        # Column 10 is at 50 cm; the lower edge of row 22 at 115 cm, with y up
        assert grid.origin == pytest.approx((0.5, -1.15, 0))

    def test_one_in_a_png(self, tmp_path):
        path = write_png(tmp_path / "map.png", write(tmp_path / "map.json").read_bytes())
        assert pianta.read_map(path).cells.tolist() == CELLS
        assert detect_input_kind(path) == "map"

    @pytest.mark.parametrize(
        ("changes", "fault"),
        [
            ({"layers": []}, "it has no pixels"),
            ({"layers": [{"type": "wall", "pixels": [1]}]}, "give pairs and triples"),
            ({"layers": [{"type": "wall", "pixels": [1, -1]}]}, "greater than or equal to 0"),
            ({"layers": [{"type": "wall", "pixels": [1.5, 1]}]}, "integer"),
            ({"layers": [{"type": "wall", "compressedPixels": [0, 0, 10**9]}]}, "less than or equal to 100000"),
            (
                {"layers": [{"type": "wall", "compressedPixels": [0, 0, 9], "pixels": [99999, 9]}]},
                "the limit is",
            ),
            ({"layers": [{"type": "lava", "pixels": [1, 1]}]}, "'floor', 'wall' or 'segment'"),
            ({"layers": LAYERS * 300}, "at most 1000"),
            ({"pixelSize": 0}, "greater than 0"),
            ({"pixelSize": "NaN"}, "finite"),
            ({"__class": "Map"}, "ValetudoMap"),
        ],
    )
    def test_hostile_json_is_one_line(self, tmp_path, changes, fault):
        with pytest.raises(MapError, match=fault) as error:
            pianta.read_map(write(tmp_path / "map.json", **changes), max_cells=10_000)
        assert "\n" not in str(error.value)
        assert "map.json" in str(error.value)

    @pytest.mark.parametrize("content", [b"[1]", b"{", b"[" * 100_000, b'"\xff"', b"{}"])
    def test_other_json_is_one_line(self, tmp_path, content):
        path = tmp_path / "map.json"
        path.write_bytes(content)
        with pytest.raises(MapError) as error:
            pianta.read_map(path)
        assert "\n" not in str(error.value)

    def test_too_many_pixels(self, tmp_path):
        runs = [0, 0, 100_000] * 51
        with pytest.raises(MapError, match="its layers have 5100000 pixels, the limit is 5000000"):
            pianta.read_map(write(tmp_path / "map.json", layers=[{"type": "wall", "compressedPixels": runs}]))

    @pytest.mark.parametrize("name", ["map.json", "map.png"])
    def test_random_damage_is_a_fault_of_one_line_or_none(self, tmp_path, name):
        path = write(tmp_path / "map.json")
        if name == "map.png":
            path = write_png(tmp_path / name, path.read_bytes())
        content, random = path.read_bytes(), np.random.default_rng(0)
        for _ in range(200):
            damaged = bytearray(content)
            for index in random.integers(0, len(content), 3):
                damaged[index] = random.choice([int(random.integers(0, 256)), *b"9-]"])
            path.write_bytes(damaged)
            assert "\n" not in read_or_fail(path)

    def test_a_png_that_unpacks_endlessly(self, tmp_path):
        with pytest.raises(MapError, match="the limit is"):
            pianta.read_map(write_png(tmp_path / "map.png", bytes(2**27)))


class TestTruth:
    def test_segments_are_rooms(self, tmp_path):
        floor = pianta.read_building(write(tmp_path / "map.json"))
        assert [(room.id, room.name) for room in floor] == [(16, "Küche"), (17, None)]
        # Columns 10 to 12, rows 20 and 21: 50 to 65 cm, -110 to -100 cm
        assert floor[16].polygon.equals(box(0.5, -1.1, 0.65, -1.0))
        assert floor.doors == ()

    @pytest.mark.parametrize("number", ["", "-1", "kitchen", "0", "9" * 30, "16"])
    def test_ids_that_rooms_cannot_have(self, tmp_path, number):
        layers = [LAYERS[1], {**LAYERS[2], "metaData": {"segmentId": number}}]
        with pytest.warns(BuildingWarning, match="has the id 17 now"):
            floor = pianta.read_building(write(tmp_path / "map.json", layers=layers))
        assert [room.id for room in floor] == [16, 17]

    def test_scattered_pixels_are_left_out(self, tmp_path):
        layers = [{"type": "segment", "compressedPixels": [0, 0, 9, 20, 0, 1], "metaData": {"segmentId": "1"}}]
        with pytest.warns(BuildingWarning, match="has 2 parts, 10% of it left out"):
            floor = pianta.read_building(write(tmp_path / "map.json", layers=layers))
        assert floor[1].polygon.area == pytest.approx(9 * 0.05**2)

    def test_a_name_that_no_room_can_have(self, tmp_path):
        layers = [{**LAYERS[1], "metaData": {"segmentId": "1", "name": "a\x1b[1m\nb" + "c" * 300}}]
        name = pianta.read_building(write(tmp_path / "map.json", layers=layers))[1].name
        assert name is not None
        assert name.startswith("a [1m b")
        assert len(name) == 200

    def test_without_segments(self, tmp_path):
        with pytest.raises(BuildingError, match="it has 0 rooms"):
            pianta.read_building(write(tmp_path / "map.json", layers=LAYERS[:1]))


@pytest.mark.data
@pytest.mark.parametrize("path", sorted((DATA / "vacuum").glob("*.json")), ids=lambda path: path.stem)
class TestRealMaps:
    @pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
    def test_map_and_truth_are_those_of_the_data(self, path):
        """The data have the same grid with unknown cells around it, and the ids of rooms in an image."""
        grid, truth = pianta.read_map(path), pianta.read_map(path.with_suffix(".yaml"))
        ids = np.asarray(Image.open(path.with_name(f"{path.stem}_gt.png")))
        rows, cols = np.nonzero(truth.cells != -1)
        window = np.s_[rows.min() : rows.max() + 1, cols.min() : cols.max() + 1]
        assert (truth.cells[window] == grid.cells).all()
        labels = pianta.read_building(path).label_image(grid)
        is_room = (labels > 0) & grid.free
        assert len(np.unique(labels[is_room])) == len(np.unique(ids[ids > 0]))
        assert (ids[window][is_room] > 0).mean() > 0.99

    @pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
    def test_a_written_map_is_the_map(self, path, tmp_path):
        floor, grid = pianta.read_building(path), pianta.read_map(path)
        pianta.convert(floor, tmp_path / "map.json", to="valetudo", robot_map=path)
        written = json.loads((tmp_path / "map.json").read_text())
        assert (pianta.read_map(tmp_path / "map.json").cells == grid.cells).all()
        again = pianta.read_building(tmp_path / "map.json")
        assert [(room.id, room.name) for room in again] == [(room.id, room.name) for room in floor]
        # Walls cut a few pixels off segments
        assert (again.label_image(grid)[grid.free] == floor.label_image(grid)[grid.free]).mean() > 0.999
        own = json.loads(path.read_text())
        assert written["entities"] == own["entities"]
        assert written["size"] == own["size"]


def test_rooms_get_the_names_of_segments(tmp_path):
    floor, grid = pianta.make_world("corridor")
    named = pianta.Floor(tuple(replace(room, name=f"Raum {room.id}") for room in floor))
    for name in ("map.json", "map.png"):
        pianta.convert(named, tmp_path / "map.json", to="valetudo", grid=grid)
        if name == "map.png":
            write_png(tmp_path / name, (tmp_path / "map.json").read_bytes())
        reading = pianta.read(tmp_path / name, labels=False)
        names = [room.name for room in reading.floor]
        assert sorted(filter(None, names)) == sorted(room.name for room in named if room.name)
    # A room with all segments gets no name
    one_room = pianta.Floor((pianta.Room(1, box(0, -50, 50, 0)),))
    assert name_rooms(one_room, read_vacuum_map(tmp_path / "map.json"))[1].name is None


# The two segments of LAYERS as rooms, the first with another name, and one that the robot does not know.
FLOOR = pianta.Floor(
    (
        pianta.Room(1, box(0.5, -1.1, 0.65, -1.0), "KITCHEN", name="<b> & 'Cucina' 🍝"),
        pianta.Room(2, box(0.7, -1.1, 0.8, -1.0), "ROOM"),
        pianta.Room(3, box(0.5, -1.15, 0.55, -1.1)),
    )
)


class TestWritten:
    def test_segments_of_the_robot_keep_their_ids(self, tmp_path):
        robot_map = write(tmp_path / "map.json")
        notes = pianta.convert(FLOOR, tmp_path / "new.json", to="valetudo", robot_map=robot_map)
        written = json.loads((tmp_path / "new.json").read_text(encoding="utf-8"))
        assert notes == ["the robot has no segment for 1 room (3), their ids are new"]
        assert written["metaData"] == {"version": 2, "vendorMapId": 7, "totalLayerArea": 11 * 25}
        assert [layer["type"] for layer in written["layers"]] == ["wall", "segment", "segment", "segment"]
        segments = [layer["metaData"] for layer in written["layers"][1:]]
        assert [(each["segmentId"], each.get("name")) for each in segments] == [
            ("16", "<b> & 'Cucina' 🍝"),
            ("17", "ROOM"),
            ("18", None),
        ]
        assert written["layers"][1]["compressedPixels"] == [10, 20, 3, 10, 21, 3]
        assert written["layers"][1]["dimensions"] == {
            "x": {"min": 10, "max": 12, "mid": 11, "avg": 11},
            "y": {"min": 20, "max": 21, "mid": 21, "avg": 21},
            "pixelCount": 6,
        }
        assert written["layers"][1]["metaData"]["area"] == 150

    def test_a_name_of_the_robot_stays(self, tmp_path):
        floor = pianta.Floor((pianta.Room(1, FLOOR[1].polygon, "KITCHEN"),))
        robot_map = write(tmp_path / "map.json")
        pianta.convert(floor, tmp_path / "new.json", to="valetudo", robot_map=robot_map)
        assert pianta.read_building(tmp_path / "new.json")[16].name == "Küche"

    def test_a_new_map(self, tmp_path):
        grid = pianta.GridMap(np.array(CELLS), 0.05, (0.5, -1.15, 0.0))
        assert pianta.convert(FLOOR, tmp_path / "new.json", to="valetudo", grid=grid) == []
        again = pianta.read_map(tmp_path / "new.json")
        assert again.cells.tolist() == CELLS
        assert again.origin == pytest.approx(grid.origin)
        floor = pianta.read_building(tmp_path / "new.json")
        assert all(room.polygon.equals(FLOOR[room.id].polygon) for room in floor)

    def test_a_map_that_does_not_lie_on_pixels_is_moved(self, tmp_path):
        grid = pianta.GridMap(np.array(CELLS), 0.05, (-3.01, 2.0, 0.5))
        corners = [grid.pixel_to_map(row, col) for row, col in ((0, 0), (0, 3), (2, 3), (2, 0))]
        floor = pianta.Floor((pianta.Room(5, type(FLOOR[1].polygon)(corners)),))
        notes = pianta.convert(floor, tmp_path / "new.json", to="valetudo", grid=grid)
        assert notes == [
            "the map begins at 0, 0, turned by -0.5000 rad: Valetudo has no negative coordinates and no angle"
        ]
        assert pianta.read_map(tmp_path / "new.json").cells.tolist() == CELLS
        assert pianta.read_building(tmp_path / "new.json")[5].polygon.area == pytest.approx(6 * 0.05**2)

    def test_card(self, tmp_path):
        robot_map = write(tmp_path / "map.json")
        notes = pianta.convert(FLOOR, tmp_path / "card.yaml", to="map-card", robot_map=robot_map)
        card = yaml.safe_load((tmp_path / "card.yaml").read_text(encoding="utf-8"))
        assert card["type"] == "custom:xiaomi-vacuum-map-card"
        (mode,) = card["map_modes"]
        assert mode["template"] == "vacuum_clean_segment"
        first, second = mode["predefined_selections"]
        assert first["id"] == "16"
        # Centimetres, y down
        assert sorted(map(tuple, first["outline"])) == [(50, 100), (50, 110), (65, 100), (65, 110)]
        assert first["label"]["text"] == "<b> & 'Cucina' 🍝"
        assert first["icon"]["name"] == "mdi:silverware-fork-knife"
        assert (second["id"], second["label"]["text"], second["icon"]["name"]) == ("17", "ROOM", "mdi:broom")
        assert notes[-1] == "the robot has no segment for 1 room (3), left out"

    def test_card_without_the_robot(self, tmp_path):
        notes = pianta.convert(FLOOR, tmp_path / "card.yaml", to="map-card")
        assert "the ids are those of pianta" in notes[-1]

    def test_several_storeys(self, tmp_path):
        house = pianta.Building((pianta.Storey(FLOOR, "ground"), pianta.Storey(FLOOR, "first")))
        with pytest.raises(OptionError, match="a vacuum has one storey, and the building has 'ground', 'first'"):
            pianta.convert(house, tmp_path / "card.yaml", to="map-card")

    def test_without_a_map(self, tmp_path):
        with pytest.raises(OptionError, match="needs the map"):
            pianta.convert(FLOOR, Path(tmp_path / "new.json"), to="valetudo")


def test_two_pixels_far_apart_make_no_map_of_gigabytes():
    layer = {"type": "floor", "metaData": {}, "compressedPixels": [0, 0, 1, 14000, 14000, 1]}
    content = json.dumps({"__class": "ValetudoMap", "pixelSize": 5, "layers": [layer]}).encode()
    with pytest.raises(MapError, match=r"^its pixels are on 14001 × 14001 cells, the limit is 25000000 in all"):
        parse_vacuum_map(content, "robot.json")
