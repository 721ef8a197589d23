"""Right-angled outlines: corners at walls, areas, doors, and rooms that stay as they are."""

import json
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
import shapely
from defusedxml import ElementTree
from shapely import LineString, Point, Polygon, affinity, box

import pianta
from pianta.floor.straight import find_directions, measure_right_angles, straighten_floor
from pianta.io.georeference import Georeference
from pianta.io.writers._formats import FORMATS


def make_ragged(x_min: float, y_min: float, x_max: float, y_max: float, step: float = 0.05) -> Polygon:
    """A rectangle whose sides go in and out by a cell every half metre."""
    sides = []
    for (x0, y0), (x1, y1) in zip(
        [(x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max)],
        [(x_max, y_min), (x_max, y_max), (x_min, y_max), (x_min, y_min)],
        strict=True,
    ):
        length = abs(x1 - x0) + abs(y1 - y0)
        along = np.array([x1 - x0, y1 - y0]) / length
        inward = np.array([-along[1], along[0]]) * step
        for index in range(int(length / 0.5)):
            for share in (0.0, 0.5):
                point = np.array([x0, y0]) + along * (0.5 * index + share * 0.5)
                offset = inward if index % 2 and index < int(length / 0.5) - 1 else 0
                sides.append(tuple(point + offset))
    return Polygon(sides).buffer(0)


ROOMS = (pianta.Room(1, make_ragged(0, 0, 4, 3)), pianta.Room(2, make_ragged(4.2, 0, 8.2, 3)))
DOOR = pianta.Door((1, 2), LineString([(4.1, 1), (4.12, 2)]), 1.0)


@pytest.mark.parametrize("angle", [0, 17, 44])
def test_ragged_rooms_get_four_corners(angle):
    floor = pianta.Floor(
        tuple(
            pianta.Room(room.id, affinity.rotate(room.polygon, angle, origin=(0, 0)), "OFFICE", name="7")
            for room in ROOMS
        ),
        (pianta.Door((1, 2), affinity.rotate(DOOR.line, angle, origin=(0, 0)), 1.0),),
    )
    assert np.degrees(find_directions(room.polygon for room in floor)) == pytest.approx([angle], abs=0.5)
    straight, unchanged = straighten_floor(floor)
    assert unchanged == ()
    for room, twin in zip(floor, straight, strict=True):
        assert len(twin.polygon.exterior.coords) == 5
        assert twin.polygon.area == pytest.approx(room.polygon.area, rel=0.02)
        assert (twin.label, twin.name) == ("OFFICE", "7")
    assert measure_right_angles(room.polygon for room in straight) == pytest.approx([1, 1])
    # The door is parallel to the wall, halfway between the rooms
    ends = [Point(end) for end in straight.doors[0].line.coords]
    distances = [[room.polygon.exterior.distance(end) for room in straight] for end in ends]
    assert np.ptp(distances) == pytest.approx(0, abs=1e-9)


def test_sides_are_on_the_lines_of_walls():
    walls = (LineString([(0.0, -1), (0.0, 4)]), LineString([(-1, 0.0), (5, 0.0)]))
    room = pianta.Room(1, make_ragged(0, 0, 4, 3, step=0.02))
    straight, _ = straighten_floor(pianta.Floor((room,), walls=walls))
    assert straight[1].polygon.bounds[:2] == pytest.approx((0, 0), abs=1e-9)


def test_a_round_room_stays_round():
    round_room = Point(0, 0).buffer(3)
    straight, unchanged = straighten_floor(pianta.Floor((pianta.Room(1, round_room), pianta.Room(2, box(5, 0, 9, 3)))))
    assert unchanged == (1,)
    assert straight[1].polygon.equals(round_room)


def test_holes_get_right_angles_too():
    outline = Polygon(box(0, 0, 8, 6).exterior, [make_ragged(2, 2, 5, 4).exterior])
    straight, unchanged = straighten_floor(pianta.Floor((pianta.Room(1, outline),)))
    assert unchanged == ()
    (hole,) = straight[1].polygon.interiors
    assert len(hole.coords) == 5


def test_rooms_of_worlds_do_not_overlap_and_keep_doors_and_areas():
    for name in ("corridor", "home", "ring"):
        _, grid = pianta.make_world(name)
        floor = pianta.reconstruct(grid)
        straight, unchanged = straighten_floor(floor)
        assert len(unchanged) <= len(floor) / 4
        union = shapely.union_all([room.polygon for room in straight])
        assert sum(room.polygon.area for room in straight) == pytest.approx(union.area, rel=1e-6)
        assert [door.rooms for door in straight.doors] == [door.rooms for door in floor.doors]
        for room, twin in zip(floor, straight, strict=True):
            assert twin.polygon.area == pytest.approx(room.polygon.area, rel=0.02)


def test_convert_counts_rooms_that_are_not_straight(tmp_path):
    floor = pianta.Floor((pianta.Room(1, Point(0, 0).buffer(3)), *(pianta.Room(2, box(5, 0, 9, 3)),)))
    notes = pianta.convert(floor, tmp_path / "floor.svg", to="svg", straight=True)
    assert notes == ["1 of 2 rooms have no right angles and are as they were"]


def count_corners(path: Path, to: str) -> int:
    """The corners of the outline of the only room in a file, the first again at the end."""
    if to in ("geojson-layers", "imdf"):
        text = (path / "rooms.geojson").read_bytes() if to != "imdf" else ZipFile(path).read("unit.geojson")
        return len(json.loads(text)["features"][0]["geometry"]["coordinates"][0])
    if to in ("gpkg", "geoparquet"):
        geopandas = pytest.importorskip("geopandas")
        is_file = to == "gpkg"
        table = geopandas.read_file(path, layer="rooms") if is_file else geopandas.read_parquet(path / "rooms.parquet")
        return len(table.geometry[0].exterior.coords)
    root = ElementTree.parse(path).getroot()
    if to == "indoorgml":
        return next(len(each.text.split()) // 3 for each in root.iter() if each.tag.endswith("posList"))
    ways = [way for way in root.iter("way") if "room" in {tag.get("v") for tag in way.iter("tag")}]
    return len([*ways[0].iter("nd")])


@pytest.mark.parametrize("to", ["geojson-layers", "gpkg", "geoparquet", "indoorgml", "osm", "osmag", "imdf"])
def test_formats_of_gis_programs_take_straight_outlines(to, tmp_path):
    pytest.importorskip("geopandas")
    floor = pianta.Floor((pianta.Room(1, make_ragged(0, 0, 4, 3)),))
    earth = Georeference("EPSG:32632", (1, 0, 5e5, 0, 1, 5e6)) if to in ("osm", "osmag", "imdf") else None
    corners = []
    for straight in (False, True):
        path = tmp_path / str(straight) / FORMATS[to].file
        path.parent.mkdir()
        pianta.convert(floor, path, to=to, straight=straight, georeference=earth)
        corners.append(count_corners(path, to))
    assert corners[0] > 20
    assert corners[1] == 5


def test_a_straight_table_has_the_perimeter_of_the_walls(tmp_path):
    floor = pianta.Floor((pianta.Room(1, make_ragged(0, 0, 4, 3)),))
    pianta.convert(floor, tmp_path / "rooms.csv", to="csv", straight=True)
    row = (tmp_path / "rooms.csv").read_text(encoding="utf-8").splitlines()[1].split(",")
    # 2 x (4 m + 3 m), less up to a cell of 5 cm on each side
    assert 13.6 <= float(row[7]) <= 14.0


def test_nothing_is_straight_on_an_empty_floor():
    assert straighten_floor(pianta.Floor(())).unchanged == ()
