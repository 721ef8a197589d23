"""Buildings of every format through one function, detected by their content."""

import os
from pathlib import Path

import pytest
from shapely import box

from pianta.errors import BuildingError, FloorError
from pianta.floor import Floor, Room
from pianta.io.buildings._formats import BuildingFormat, detect_building_format
from pianta.io.buildings.read import list_buildings, read_building
from pianta.io.floors import save_floor
from pianta.io.graphs import save_graph
from tests import test_building_xml, test_house_expo, test_kth_xml, test_mit_xml

FLOOR = Floor((Room(1, box(0, 0, 1, 1), "LAB"),))
CONTENTS = {
    BuildingFormat.LAYOUT: test_building_xml.TWO_ROOMS,
    BuildingFormat.KTH: test_kth_xml.TWO_ROOMS,
    BuildingFormat.MIT: test_mit_xml.TWO_ROOMS,
    BuildingFormat.HOUSE_EXPO: test_house_expo.house({"Lab": [[0, 0, 10, 6]]}),
}


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


@pytest.mark.parametrize(("building_format", "labels"), [
    (BuildingFormat.LAYOUT, ["OFFICE", "CORRIDOR"]),
    (BuildingFormat.KTH, ["KONTOR", "KORRIDOR"]),
    (BuildingFormat.MIT, ["OFF", "P CIRC"]),
    (BuildingFormat.HOUSE_EXPO, ["LAB"]),
])  # fmt: skip
@pytest.mark.parametrize("name", ["a.xml", "a.json", "a.txt"])
def test_every_format_is_detected_by_its_content(tmp_path, building_format, labels, name):
    path = write(tmp_path / name, "\n" * (building_format is BuildingFormat.HOUSE_EXPO) + CONTENTS[building_format])
    assert detect_building_format(path) is building_format
    assert [room.label for room in read_building(path).rooms] == labels


def test_a_floor_comes_back(tmp_path):
    save_floor(FLOOR, tmp_path / "floor.geojson")
    assert read_building(tmp_path / "floor.geojson") == FLOOR


def test_another_encoding_is_read(tmp_path):
    path = tmp_path / "a.xml"
    path.write_bytes(
        CONTENTS[BuildingFormat.KTH].replace("<?xml", '<?xml encoding="utf-16"').split("?>")[1].encode("utf-16")
    )
    assert len(read_building(path).rooms) == 2


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            '<svg xmlns="http://www.w3.org/2000/svg"/>',
            "SVG",
        ),
        ("<html/>", "web"),
        ("<osm/>", "OpenStreetMap"),
        ('<c:IndoorFeatures xmlns:c="http://www.opengis.net/indoorgml/1.0/core"/>', "IndoorGML"),
        (
            "<labels/>",
            "labels",
        ),
        ('{"type": "FeatureCollection", "features": []}', "GeoJSON"),
        ('{"nodes": [], "edges": []}', "graph"),
        ("{}", "JSON"),
        ("{", "JSON"),
        ("P5 1 1 255 a", "XML"),
        ("", "empty"),
    ],
)
def test_unknown_files_are_refused(tmp_path, content, message):
    with pytest.raises(BuildingError, match=message) as error:
        read_building(write(tmp_path / "a.xml", content))
    assert "\n" not in str(error.value)


def test_a_damaged_floor_is_refused_by_its_reader(tmp_path):
    with pytest.raises(FloorError, match=r"\bfloor\b"):
        read_building(write(tmp_path / "a.geojson", '{"format": "pianta floor", "features": 1}'))


def test_folders_stand_for_their_buildings(tmp_path):
    """Hidden ones, graphs and files of other names are passed by; a file that is given is taken as it is."""
    house, layout = CONTENTS[BuildingFormat.HOUSE_EXPO], CONTENTS[BuildingFormat.LAYOUT]
    for name in ("b.XML", "a/z.xml", "a/c.xml", ".hidden/a.xml", "a/.x.xml", "map.yaml", "rooms.xml.bak"):
        write(tmp_path / name, layout)
    write(tmp_path / "c.json", house)
    write(tmp_path / "steps.json", '{"order": []}')
    save_floor(FLOOR, tmp_path / "d.geojson")
    save_graph(FLOOR.graph(), tmp_path / "graph.json")
    assert [str(path.relative_to(tmp_path)) for path in list_buildings([tmp_path])] == [
        *("b.XML", "c.json", "d.geojson", "a/c.xml", "a/z.xml")
    ]
    map_file = tmp_path / "map.yaml"
    assert list_buildings([map_file, str(tmp_path / "a"), tmp_path / "a" / ".." / "map.yaml", tmp_path / "a"]) == [
        map_file,
        tmp_path / "a" / "c.xml",
        tmp_path / "a" / "z.xml",
    ]
    assert list_buildings([]) == []


def test_a_folder_without_buildings_is_refused(tmp_path):
    write(tmp_path / "a.txt", "a")
    with pytest.raises(BuildingError, match=r"\.geojson"):
        list_buildings([tmp_path])


def test_a_folder_that_may_not_be_listed_is_refused(tmp_path, monkeypatch):
    def refuse(path):
        raise PermissionError(13, "Permission denied", path)

    monkeypatch.setattr(os, "scandir", refuse)
    with pytest.raises(BuildingError, match="Permission"):
        list_buildings([tmp_path])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_the_buildings_of_the_data_are_listed_and_read(data):
    files = list_buildings([data / "buildings"])
    assert files == sorted(data.glob("buildings/*/*.xml"))
    assert all(detect_building_format(file) is BuildingFormat.LAYOUT for file in files)
    assert len(read_building(files[0]).rooms) == 38
