"""Georeferences: control points and anchors, and what is refused."""

from math import hypot

import numpy as np
import pytest
from shapely import LineString, Point, box

import pianta
from pianta.errors import OptionError
from pianta.io.georeference import WGS84, Georeference, fit_motion, read_georeference

pyproj = pytest.importorskip("pyproj")

# The world is the map turned by 90° counter-clockwise, twice as large, at 500000, 5000000.
TURNED = """
crs: EPSG:32632
points:
  - {map: [0, 0], world: [500000, 5000000]}
  - {map: [10, 0], world: [500000, 5000020]}
  - {map: [0, 5], world: [499990, 5000000]}
"""


@pytest.fixture
def file(tmp_path):
    return tmp_path / "place.yaml"


def test_control_points_give_a_rotation_a_scale_and_a_shift(file):
    file.write_text(TURNED)
    georeference = read_georeference(file)
    assert georeference.crs == "EPSG:32632"
    assert georeference.matrix == pytest.approx((0, -2, 500000, 2, 0, 5000000), abs=1e-6)
    assert georeference.residuals == pytest.approx((0, 0, 0), abs=1e-6)
    moved = georeference.to_world(LineString([(0, 0), (3, 4)]))
    assert np.allclose(moved.coords, [(500000, 5000000), (499992, 5000006)])


def test_json_is_read_too(file):
    file.write_text('{"latitude": 45, "longitude": 9, "bearing": 0}')
    assert read_georeference(file).matrix == pytest.approx((1, 0, 0, 0, 1, 0))


def test_residuals_show_by_how_much_points_are_missed(file):
    # The last point is 3 m off, so least squares misses all by something, and the mean motion stays between
    file.write_text(TURNED.replace("[499990, 5000000]", "[499987, 5000000]"))
    georeference = read_georeference(file)
    assert max(georeference.residuals) > 0.5
    assert "control points are missed by" in georeference.describe()
    file.write_text(TURNED.replace("[499990, 5000000]", "[499987, 5000000]") + "transform: affine\n")
    assert max(read_georeference(file).residuals) == pytest.approx(0, abs=1e-6)


def test_least_squares_are_those_of_the_mean_when_points_disagree():
    points = np.array([[0.0, 0], [2, 0], [2, 2], [0, 2]])
    world = points + np.array([[0.1, 0], [-0.1, 0], [0.1, 0], [-0.1, 0]])
    assert fit_motion(points, world, affine=False) == pytest.approx((1, 0, 0, 0, 1, 0))


def test_degrees_are_fitted_in_a_plane_of_metres(file):
    # 0.001° of latitude are 111.2 m, and of longitude at 45° 78.8 m (WGS 84)
    file.write_text(
        "{crs: 'EPSG:4326', points: [{map: [0, 0], world: [9, 45]}, "
        "{map: [78.847, 0], world: [9.001, 45]}, {map: [0, 111.131], world: [9, 45.001]}]}"
    )
    georeference = read_georeference(file)
    assert max(georeference.residuals) < 0.02
    moved = georeference.to_wgs84(Point(78.847, 111.131))
    assert (moved.x, moved.y) == pytest.approx((9.001, 45.001), abs=1e-6)


def test_the_bearing_is_that_of_the_y_axis(file):
    file.write_text("{latitude: 45.5, longitude: 9.2, bearing: 90, map: [2, 1]}")
    georeference = read_georeference(file)
    anchor, north = georeference.to_wgs84(Point(2, 1)), georeference.to_wgs84(Point(2, 101))
    assert (anchor.x, anchor.y) == pytest.approx((9.2, 45.5), abs=1e-9)
    # y leads to the east: the same latitude, and a larger longitude
    assert north.y == pytest.approx(45.5, abs=1e-6)
    geodesic = pyproj.Geod(ellps="WGS84").inv(anchor.x, anchor.y, north.x, north.y)
    assert (geodesic[0], geodesic[2]) == pytest.approx((90, 100), abs=1e-3)


def test_lengths_stay_what_they_are(file):
    file.write_text("{latitude: 60, longitude: 25, bearing: 17}")
    georeference = read_georeference(file)
    start, end = georeference.to_wgs84(Point(-40, 30)), georeference.to_wgs84(Point(60, -10))
    length = pyproj.Geod(ellps="WGS84").inv(start.x, start.y, end.x, end.y)[2]
    assert length == pytest.approx(hypot(100, 40), abs=1e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1, 2]", "no members"),
        ("{a: *b}", "aliases"),
        ("{latitude: 91, longitude: 0}", "latitude"),
        ("{latitude: 45, longitude: 9, height: 3}", "height"),
        (TURNED.replace("EPSG:32632", "EPSG:1"), "EPSG:1"),
        (TURNED.replace("EPSG:32632", "EPSG:5703"), "EPSG:5703"),
        (TURNED[: TURNED.rindex("  -")], "points"),
        ("{crs: 'EPSG:32632', points: [" + "{map: [1, 1], world: [2, 2]}," * 3 + "]}", "one point"),
        (TURNED.replace("[0, 5]", "[20, 0]") + "transform: affine\n", "one line"),
        (TURNED.replace("[10, 0]", "[.nan, 0]"), "map"),
        ("\x00", "neither"),
    ],
)
def test_other_files_are_refused(file, text, message):
    file.write_text(text)
    with pytest.raises(OptionError, match=message) as error:
        read_georeference(file)
    assert "\n" not in str(error.value)


def test_an_identity_in_degrees_is_left_as_it_is():
    georeference = Georeference(WGS84, (1, 0, 0, 0, 1, 0))
    assert georeference.to_wgs84(Point(9, 45)).coords[0] == pytest.approx((9, 45))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{latitude: 1, longitude: 1, map: [1e300, 0]}", r"map\[0\]: Input should be less than or equal to 100000000"),
        ("{latitude: 1, longitude: 1, bearing: 1e300}", "bearing: Input should be less than or equal to 360"),
        (
            TURNED.replace("500000", "1e9"),
            "world.*Input should be less than or equal to 100000000",
        ),
        (
            TURNED.replace("EPSG:32632", "EPSG:4326"),
            "world points are no longitude, latitude of EPSG:4326, give degrees in this order",
        ),
        # The map is mirrored
        (
            TURNED.replace("map: [0, 5]", "map: [0, -5]"),
            "control points are missed by .*; check them: axes swapped, mirrored, mixed up",
        ),
    ],
)
def test_positions_off_the_earth_and_mirrored_points_are_refused(tmp_path, text, message):
    pytest.importorskip("pyproj")
    (tmp_path / "points.yaml").write_text(text)
    with pytest.raises(OptionError, match=message):
        read_georeference(tmp_path / "points.yaml")


def test_a_map_outside_of_its_system_is_refused(tmp_path):
    pytest.importorskip("pyproj")
    far = Georeference("EPSG:32632", (1.0, 0.0, 1e9, 0.0, 1.0, 1e9))
    floor = pianta.Floor((pianta.Room(1, box(0, 0, 4, 3)),))
    with pytest.raises(OptionError, match=r"^the georeference puts the map outside of EPSG:32632, check its points"):
        pianta.convert(floor, tmp_path / "floor.osm", to="osm", georeference=far)
    assert [*tmp_path.iterdir()] == []
