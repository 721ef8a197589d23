"""Coordinates in whole millimetres."""

import re

from shapely import LineString, Polygon, box

import pianta
from pianta.floor import Door, Floor, Furniture, Room, round_floor


def test_coordinates_and_widths_become_millimetres():
    third = 1 / 3
    floor = Floor(
        (Room(1, box(third, 0, 2, 2), partial=True, predicted=box(third, 0, 2, 3 + third)),),
        (Door((1, None), LineString([(2, third), (2, 4 * third)]), 2 * third),),
        (LineString([(-third, 0), (2, 0)]),),
        furniture=(Furniture(box(1, 1, 1 + third, 2)),),
        possible_doors=(Door((1, None), LineString([(third, 0.5), (third, 1)]), 0.5),),
    )
    rounded = round_floor(floor)
    assert rounded[1].polygon.bounds == (0.333, 0, 2, 2)
    assert rounded[1].predicted is not None
    assert rounded[1].predicted.bounds == (0.333, 0, 2, 3.333)
    assert ([*rounded.doors[0].line.coords], rounded.doors[0].width) == ([(2, 0.333), (2, 1.333)], 0.667)
    assert [*rounded.walls[0].coords] == [(-0.333, 0), (2, 0)]
    assert rounded.furniture[0].polygon.bounds == (1, 1, 1.333, 2)
    assert [*rounded.possible_doors[0].line.coords] == [(0.333, 0.5), (0.333, 1)]
    assert round_floor(rounded) == rounded


def test_a_polygon_that_would_be_invalid_stays():
    # A slit of 0.4 mm would close
    slit = Polygon([(0, 0), (4, 0), (4, 3), (2.0004, 3), (2.0004, 1), (2, 1), (2, 3), (0, 3)])
    floor = Floor((Room(1, slit),))
    assert round_floor(floor) == floor
    thin = Floor((Room(1, box(0, 0, 3, 0.0004)),))
    assert round_floor(thin) == thin


def test_what_read_saves_has_no_more_than_millimetres(tmp_path):
    pianta.make_world("corridor")[1].save(tmp_path / "map.yaml")
    pianta.read(tmp_path / "map.yaml", labels=False).save(tmp_path / "out")
    text = (tmp_path / "out" / "floor.geojson").read_text(encoding="utf-8")
    decimals = re.findall(r"-?\d+\.(\d+)[,\]]", "".join(re.findall(r'"coordinates": (\[.*?\])}', text)))
    assert decimals
    assert max(map(len, decimals)) <= 3
