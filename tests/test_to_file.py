"""Results written in the formats of other programs by their own method, and the format known by the suffix."""

import pytest

import pianta
from pianta.errors import OptionError
from pianta.io.writers._formats import FORMATS
from pianta.io.writers.convert import find_format_name
from tests.command_line import run_pianta
from tests.test_convert_cad import FLOOR, HOUSE


def test_floor_building_and_reading_write_what_convert_writes(tmp_path):
    pianta.make_world("corridor")[1].save(tmp_path / "map.yaml")
    reading = pianta.read(tmp_path / "map.yaml", labels=False)
    for source in (FLOOR, HOUSE, reading):
        expected = pianta.convert(source, tmp_path / "expected.csv", to="csv")
        assert source.to_file(tmp_path / "rooms.csv") == expected
        assert (tmp_path / "rooms.csv").read_bytes() == (tmp_path / "expected.csv").read_bytes()


def test_a_reading_has_its_map_with_it(tmp_path):
    pianta.make_world("corridor")[1].save(tmp_path / "map.yaml")
    reading = pianta.read(tmp_path / "map.yaml", labels=False)
    reading.to_file(tmp_path / "route.geojson", to="nav2-route")
    assert pianta.read_route_graph(tmp_path / "route.geojson").number_of_nodes() >= len(reading.floor)


@pytest.mark.parametrize(
    ("name", "to"), [("a.dxf", "dxf"), ("a.XLSX", "excel"), ("a.gpkg", "gpkg"), ("a.svg", "svg"), ("a.ifc", "ifc")]
)
def test_a_suffix_of_one_format_is_enough(tmp_path, name, to):
    assert find_format_name(tmp_path / name) == to


def test_other_suffixes_are_refused_with_the_choice(tmp_path):
    shared = [name for name, each in FORMATS.items() if each.file.endswith(".osm")]
    assert len(shared) == 2
    with pytest.raises(OptionError, match=r"output 'a.osm' does not show the format, give one of osm, osmag"):
        FLOOR.to_file(tmp_path / "a.osm")
    for name in ("a.docx", "a"):
        with pytest.raises(OptionError, match=rf"output '{name}' does not show the format, give one of csv, excel, "):
            FLOOR.to_file(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_the_command_takes_the_suffix(tmp_path):
    FLOOR.save(tmp_path / "floor.geojson")
    result = run_pianta("convert", tmp_path / "floor.geojson", "-o", tmp_path / "rooms.csv")
    assert (result.code, result.err) == (0, "")
    assert (tmp_path / "rooms.csv").read_text(encoding="utf-8").startswith("storey,id,number,name")
    result = run_pianta("convert", tmp_path / "floor.geojson")
    assert (result.code, result.err) == (2, "error: no format, give --to FORMAT\n")
