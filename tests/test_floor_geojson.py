"""Round trips of floor.geojson are exact, and other files are refused."""

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, Polygon, box
from shapely.geometry import shape

from pianta.errors import FloorError, PiantaError
from pianta.floor import Door, Floor, Furniture, Room
from pianta.io.floors import read_floor, save_floor
from tests.mutation import mutated

ENTRANCE = Door((4, None), LineString([(0, 1), (0, 2)]), 1.0)
FLOOR = Floor(
    rooms=(
        Room(
            4,
            Polygon([(0, 0), (4, 0), (4, 3), (0, 3)], [[(1, 1), (1, 2), (2, 2), (2, 1)]]),
            "AULA È",
            {"R/C": "ROOM", "school": "AULA È"},
            {"R/C": {"ROOM": 1.0}, "school": {"LAB": 0.3, "AULA È": 0.7}},
        ),
        Room(2, box(4, 0, 9.1, 3), partial=True),
    ),
    doors=(
        Door((4, 2), LineString([(4, 0.1), (4, 1)]), 0.9),
        Door((2, 4), LineString([(4, 2), (4, 3)]), 1, "opening"),
        ENTRANCE,
    ),
    walls=(LineString([(0, 0), (9.1, 0)]), LineString([(4, 0), (4, 0.1), (4, 3)])),
    building_type={"SCHOOL": 0.75, "OFFICE": 0.25},
    source="map.yaml",
    last_id=9,
    furniture=(
        Furniture(box(2.5, 1, 3, 2), kind="bed"),
        Furniture(Polygon([(5, 0), (7, 0), (7, 2), (5, 2)], [[(5.5, 0.5), (6, 0.5), (6, 1)]]), 0.75),
    ),
    possible_doors=(
        Door((4, 2), LineString([(4, 1.5), (4, 1.75)]), 0.25, probability=0.5),
        Door((4, None), LineString([(0, 2), (0, 2.5)]), 0.5),
    ),
)
ROOM = {"class": "room", "room": 1}
FURNITURE = {"class": "furniture"}
DOOR = {"class": "door", "rooms": [1, 2], "width": 1.0}
SQUARE = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]}
BOW_TIE = {"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]]]}
LINE = {"type": "LineString", "coordinates": [[0, 0], [1, 1]]}

metres = st.floats(-1e8, 1e8)
names = st.text(max_size=5)
probabilities = st.dictionaries(names, st.floats(0, 1), max_size=3)
labels = st.dictionaries(names, names, max_size=3)
label_probabilities = st.dictionaries(names, probabilities, max_size=3)
lines = st.lists(st.tuples(metres, metres), min_size=2, max_size=4).map(LineString)
polygons = st.builds(
    lambda x, y, width, height: box(x, y, x + width, y + height),
    *[st.floats(-1e6, 1e6)] * 2,
    *[st.floats(0.1, 100)] * 2,
)


def is_room_name(text: str) -> bool:
    return bool(text.strip()) and text.isprintable()


@st.composite
def floors(draw) -> Floor:
    ids = draw(st.lists(st.integers(1, 10**6), unique=True, max_size=5))
    labelling = st.tuples(polygons, st.none() | names, labels, label_probabilities, st.booleans())
    named = st.none() | names.filter(is_room_name)
    certainty = st.none() | st.floats(0, 1)
    rooms = tuple(replace(Room(id_, *draw(labelling)), name=draw(named), probability=draw(certainty)) for id_ in ids)
    pairs = st.lists(st.sampled_from([*ids, None]), min_size=2, max_size=2, unique=True) if ids else st.nothing()
    kinds = st.sampled_from(["door", "opening"])
    any_doors = st.lists(st.builds(Door, pairs.map(tuple), lines, st.floats(0, 1e300), kinds, certainty), max_size=3)
    doors, possible_doors = draw(any_doors), draw(any_doors)
    walls = draw(st.lists(lines, max_size=3))
    last_id = max(ids, default=0) + draw(st.integers(0, 9))
    furniture = draw(st.lists(st.builds(Furniture, polygons, certainty), max_size=3))
    building = draw(probabilities), draw(st.text(max_size=5)), last_id
    return Floor(rooms, tuple(doors), tuple(walls), *building, tuple(furniture), tuple(possible_doors))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("floors") / "floor.geojson"


@pytest.fixture(scope="module")
def valid(path):
    save_floor(FLOOR, path)
    return path.read_bytes()


def feature(properties: object, geometry: object) -> dict[str, object]:
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def write(path, *features: object, **members: object) -> None:
    header = {
        "type": "FeatureCollection",
        "format": "pianta floor",
        "version": "2.0",
        "frame": "map",
        "units": "metres",
    }
    path.write_text(json.dumps(header | {"features": features} | members))


def test_floor_survives(path):
    save_floor(FLOOR, path)
    assert read_floor(path) == FLOOR


@pytest.mark.slow
@given(floor=floors())
def test_round_trip_is_exact_and_stable(path, floor):
    save_floor(floor, path)
    content = path.read_bytes()
    read = read_floor(path)
    assert read == floor
    save_floor(read, path)
    assert path.read_bytes() == content


def test_file_is_plain_geojson(valid):
    collection = json.loads(valid)
    assert collection["type"] == "FeatureCollection"
    assert (collection["frame"], collection["units"], collection["version"]) == ("map", "metres", "2.7")
    features = collection["features"]
    inner = ["room-4", "room-2", "door-1", "door-2", "door-3", "wall-1", "wall-2"]
    loose = ["furniture-1", "furniture-2", "possible_door-1", "possible_door-2"]
    assert [part["id"] for part in features] == [*inner, *loose]
    assert all(part["type"] == "Feature" for part in features)
    shapes = [shape(part["geometry"]) for part in features]
    building = [room.polygon for room in FLOOR.rooms] + [door.line for door in FLOOR.doors] + list(FLOOR.walls)
    shut = [door.line for door in FLOOR.possible_doors]
    assert shapes == building + [piece.polygon for piece in FLOOR.furniture] + shut
    assert shapes[0].exterior.is_ccw
    assert not shapes[0].interiors[0].is_ccw


def test_properties_are_named(valid):
    properties = [part["properties"] for part in json.loads(valid)["features"]]
    texts: dict[str, object] = {"number": None, "name": None, "label": None}
    unlabelled = texts | {"labels": {}, "label_probabilities": {}}
    assert properties[0]["labels"] == {"R/C": "ROOM", "school": "AULA È"}
    assert properties[0]["label_probabilities"] == {"R/C": {"ROOM": 1.0}, "school": {"AULA È": 0.7, "LAB": 0.3}}
    unknown = {"probability": None}
    size = {"area": 15.3}
    assert properties[1] == {"class": "room", "room": 2, "partial": True} | unlabelled | unknown | size
    assert properties[3] == {"class": "door", "rooms": [2, 4], "width": 1.0, "kind": "opening"} | unknown
    assert properties[4] == {"class": "door", "rooms": [4, None], "width": 1.0, "kind": "door"} | unknown
    assert properties[5] == {"class": "wall"}
    assert properties[7] == {"class": "furniture", "kind": "bed"} | unknown
    assert properties[8] == {"class": "furniture", "probability": 0.75}
    assert json.loads(valid)["last_id"] == 9


def test_a_prediction_is_a_feature_of_its_own(path):
    predicted = box(0, 0, 4, 3)
    floor = Floor((Room(1, box(0, 0, 2, 3), partial=True, predicted=predicted, confidence=0.75),))
    save_floor(floor, path)
    room, prediction = json.loads(path.read_bytes())["features"]
    assert room["properties"].keys().isdisjoint({"predicted", "confidence"})
    assert prediction["properties"] == {"class": "predicted_room", "room": 1, "confidence": 0.75}
    assert shape(prediction["geometry"]).equals(predicted)
    assert read_floor(path) == floor


def test_a_prediction_of_version_2_4_is_a_property_of_the_room(path):
    larger = {"type": "Polygon", "coordinates": [[[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]]}
    write(path, feature(ROOM | {"partial": True, "predicted": larger, "confidence": 0.5}, SQUARE), version="2.4")
    (room,) = read_floor(path)
    assert room.predicted is not None
    assert (room.predicted.area, room.confidence) == (16, 0.5)


@pytest.mark.parametrize(
    ("rooms", "message"),
    [([1, 1], "room 1 is predicted more than once"), ([7], r"rooms \[7\] that do not exist"), (["1"], "room")],
)
def test_stray_predictions_are_refused(path, rooms, message):
    predictions = [feature({"class": "predicted_room", "room": room}, SQUARE) for room in rooms]
    write(path, feature(ROOM | {"partial": True}, SQUARE), *predictions, version="2.5")
    with pytest.raises(FloorError, match=message):
        read_floor(path)


def test_gdal_takes_the_file_for_metres(valid, path):
    pyogrio = pytest.importorskip("pyogrio")
    path.write_bytes(valid)
    crs = pytest.importorskip("pyproj").CRS(pyogrio.read_info(path)["crs"])
    assert (crs.is_geographic, crs.is_projected, [axis.unit_name for axis in crs.axis_info]) == (
        False,
        False,
        ["metre", "metre"],
    )


def test_a_file_of_version_2_0_has_no_predictions(path):
    write(path, feature(ROOM | {"partial": True}, SQUARE), version="2.0")
    assert (read_floor(path).rooms[0].predicted, read_floor(path).rooms[0].confidence) == (None, None)


def test_a_name_survives_and_a_file_of_version_2_1_has_no_names(path):
    floor = Floor((Room(1, box(0, 0, 2, 3), "LAB", name="12 Büro – [1]"),))
    save_floor(floor, path)
    assert json.loads(path.read_bytes())["features"][0]["properties"]["name"] == "12 Büro – [1]"
    assert read_floor(path) == floor
    write(path, feature(ROOM, SQUARE), version="2.1")
    assert read_floor(path).rooms[0].name is None


def test_probabilities_survive_and_a_file_of_version_2_2_has_none(path):
    rooms = Room(1, box(0, 0, 2, 3), probability=0.5), Room(2, box(2, 0, 4, 3), probability=0)
    floor = Floor(rooms, (Door((1, 2), LineString([(2, 1), (2, 2)]), 1.0, probability=0.25),))
    save_floor(floor, path)
    properties = [part["properties"] for part in json.loads(path.read_bytes())["features"]]
    assert [each["probability"] for each in properties] == [0.5, 0, 0.25]
    assert read_floor(path) == floor
    write(path, feature(ROOM, SQUARE), feature(DOOR | {"rooms": [1, None]}, LINE), version="2.2")
    read = read_floor(path)
    assert (read.rooms[0].probability, read.doors[0].probability, read.furniture) == (None, None, ())


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"name": "a\tb"}, "printed"),
        ({"name": "x" * 201}, "200"),
        ({"name": 12}, "name"),
        ({"predicted": SQUARE}, "partial"),
        ({"partial": True, "predicted": BOW_TIE}, "predicted"),
        ({"partial": True, "predicted": SQUARE, "confidence": 2.0}, r"2\.0"),
        ({"partial": True, "predicted": LINE}, "Polygon"),
    ],
)
def test_a_faulty_prediction_is_refused(path, change, expected):
    write(path, feature(ROOM | change, SQUARE))
    with pytest.raises(FloorError, match=expected):
        read_floor(path)


def test_a_file_without_a_last_id_gets_the_highest_id(path):
    write(path, feature(ROOM | {"room": 7}, SQUARE), feature(ROOM | {"room": 3}, SQUARE))
    assert read_floor(path).last_id == 7


def test_empty_floor_survives(path):
    save_floor(Floor(()), path)
    assert read_floor(path) == Floor(())


def test_unknown_members_are_skipped(path):
    stairs = feature({"class": "stairs"}, {"type": "Point", "coordinates": [0, 0, 0]})
    room = feature(ROOM | {"height": 3}, SQUARE | {"bbox": []}) | {"bbox": None}
    write(path, stairs, room, feature(None, None), version="2.7", crs=None)
    assert read_floor(path) == Floor((Room(1, shape(SQUARE)),))


def test_newer_format_is_refused_before_anything_else(path):
    path.write_text('{"format": "pianta floor", "version": "3.0", "levels": []}')
    with pytest.raises(FloorError, match=r"3\.0"):
        read_floor(path)


@pytest.mark.parametrize("version", ["1.0", "1.7"])
def test_probabilities_of_version_1_become_those_of_the_type(path, version):
    labelling = {"label": "LAB", "label_probabilities": {"LAB": 0.7}}
    write(path, feature(ROOM | labelling, SQUARE), feature(ROOM | {"room": 2}, SQUARE), version=version)
    first, second = read_floor(path).rooms
    assert (first.label, first.labels, first.label_probabilities) == ("LAB", {}, {"type": {"LAB": 0.7}})
    assert (second.label, second.labels, second.label_probabilities) == (None, {}, {})


def test_version_2_has_no_flat_probabilities(path):
    write(path, feature(ROOM | {"label_probabilities": {"LAB": 0.7}}, SQUARE))
    with pytest.raises(FloorError, match=r"LAB.*0\.7"):
        read_floor(path)


def test_other_geojson_is_refused(path):
    path.write_text('{"type": "FeatureCollection", "features": []}')
    with pytest.raises(FloorError, match=r"format.*version"):
        read_floor(path)


@pytest.mark.parametrize(
    ("features", "message"),
    [
        ([feature(ROOM, BOW_TIE)], r"features\[0\].room"),
        ([feature(ROOM | {"room": 0}, SQUARE)], "id"),
        ([feature(ROOM | {"room": "1"}, SQUARE)], "properties.room"),
        ([feature(ROOM, LINE)], "LineString"),
        ([feature(ROOM, {"type": "Polygon", "coordinates": []})], "coordinates"),
        ([feature(ROOM, {"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [0, 0]]]})], "coordinates"),
        (
            [feature({"class": "wall"}, LINE | {"coordinates": [[0, 0], [1e9, 0]]})],
            r"coordinates\[1\]\[0\].*1000000000",
        ),
        ([feature({"class": "wall"}, LINE | {"coordinates": [[0, 0], [10**400, 0]]})], r"coordinates\[1\]\[0\]"),
        ([feature(ROOM, SQUARE)] * 2, r"\[1\]"),
        ([feature(ROOM, SQUARE), feature(DOOR, LINE)], r"\[2\]"),
        ([feature(DOOR | {"rooms": [1, 1], "width": 1}, LINE)], "itself"),
        ([feature(DOOR | {"width": -1}, LINE)], "width"),
        ([feature(DOOR | {"rooms": [None, None]}, LINE)], r"properties.rooms\[0\]"),
        ([feature(DOOR | {"rooms": [1]}, LINE)], r"properties.rooms\[1\]"),
        ([feature(ROOM | {"probability": 1.5}, SQUARE)], r"room 1 has probability 1\.5"),
        ([feature(DOOR | {"probability": -0.5}, LINE)], r"rooms 1 and 2 has probability -0\.5"),
        ([feature(DOOR | {"probability": "0.5"}, LINE)], r"properties.probability"),
        ([feature(FURNITURE, BOW_TIE)], r"features\[0\].furniture"),
        ([feature(FURNITURE, LINE)], "LineString"),
        ([feature(FURNITURE | {"probability": 2}, SQUARE)], r"furniture has probability 2"),
        ([feature(DOOR | {"rooms": [1, "2"]}, LINE)], r"properties.rooms\[1\].*'2'"),
        ([feature(DOOR | {"rooms": [8, None]}, LINE)], r"\[8\]"),
        (
            [feature(ROOM | {"label_probabilities": {"R/C": {"a\nb": -2, "c": 1.5}}}, SQUARE)],
            r"a\\nb.*-2.*1\.5",
        ),
        ([5], r"features\[0\]"),
    ],
)
def test_messages_of_faults_have_position_and_value(path, features, message):
    write(path, *features)
    with pytest.raises(FloorError, match=message) as error:
        read_floor(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("last_id", "message"),
    [(1, "last id"), ("9", r"\blast_id\b"), (8.5, r"\blast_id\b")],
)
def test_a_wrong_last_id_is_refused(path, last_id, message):
    write(path, feature(ROOM | {"room": 7}, SQUARE), last_id=last_id)
    with pytest.raises(FloorError, match=message):
        read_floor(path)


def test_faults_are_listed_together_and_bounded(path):
    write(path, *[feature(ROOM, BOW_TIE)] * 12, feature(DOOR | {"width": "wide"}, None))
    with pytest.raises(FloorError, match=r"features\[0\].*features\[9\].*4 more"):
        read_floor(path)


@pytest.mark.parametrize(
    "text",
    ["[" * 100_000, '{"features": NaN}', '{"version": ' + "9" * 10_000 + "}", "\ufeff", "null", "\x00", '"\\ud800"'],
)
def test_hostile_json_is_refused(path, text):
    path.write_text(text)
    with pytest.raises(FloorError, match="floor"):
        read_floor(path)


def test_nan_is_refused(path):
    write(path, feature({"class": "wall"}, LINE | {"coordinates": [[0, 0], [float("nan"), 0]]}))
    with pytest.raises(FloorError, match=r"coordinates\[1\]\[0\]"):
        read_floor(path)


def test_size_is_limited(path, monkeypatch):
    write(path)
    monkeypatch.setattr("pianta.io.floors.MAX_FILE_BYTES", 10)
    with pytest.raises(FloorError, match="bytes"):
        read_floor(path)


@pytest.mark.parametrize(
    "floor",
    [
        Floor((), walls=(LineString(),)),
        Floor((), walls=(LineString([(0, 0, 1), (1, 1, 1)]),)),
        Floor((), walls=(LineString([(0, 0), (float("inf"), 1)]),)),
        Floor((), walls=(LineString([(0, 0), (1e9, 1)]),)),
        Floor((), building_type={"SCHOOL": float("nan")}),
        Floor((), source="\ud800"),
        Floor(FLOOR.rooms, (Door((2, 4), LineString([(0, 0), (1, 1)]), float("inf")),)),
    ],
)
def test_floors_that_could_not_be_read_again_are_not_written(path, floor):
    path.write_text("old")
    with pytest.raises(FloorError, match="save"):
        save_floor(floor, path)
    assert path.read_text() == "old"
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_missing_folder(tmp_path):
    with pytest.raises(PiantaError, match="write"):
        save_floor(FLOOR, tmp_path / "none" / "floor.geojson")


@given(fuzz=st.data())
def test_damaged_file_is_read_or_refused(path, valid, fuzz):
    path.write_bytes(fuzz.draw(st.binary() | mutated(valid)))
    with suppress(FloorError):
        assert isinstance(read_floor(path), Floor)


@given(fuzz=st.data())
def test_misplaced_values_are_read_or_refused(path, valid, fuzz):
    """A member of the file, at any depth, is replaced by another value."""
    collection = json.loads(valid)
    holder, key = fuzz.draw(st.sampled_from(list(members(collection))))
    values: list[object] = [
        None,
        True,
        -1,
        0,
        1,
        2.5,
        1e300,
        10**30,
        "",
        "room",
        [],
        [[]],
        {},
        [[0, 0]],
        BOW_TIE,
        LINE,
        ROOM,
    ]
    holder[key] = fuzz.draw(st.sampled_from(values))
    path.write_text(json.dumps(collection))
    with suppress(FloorError):
        assert isinstance(read_floor(path), Floor)


def members(value: Any) -> Iterator[tuple[Any, Any]]:
    """Every container and key inside a JSON value."""
    keys = value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        yield value, key
        yield from members(value[key])
