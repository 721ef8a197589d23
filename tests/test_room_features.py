"""Features of rooms: values by hand, effects of turning and scaling, and the values in the files of the data."""

import warnings
from math import cos, pi, sin, sqrt, tau
from pathlib import Path

import numpy as np
import pytest
from defusedxml import ElementTree
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from shapely import LineString, Polygon, box
from shapely.affinity import affine_transform

from pianta.errors import BuildingWarning
from pianta.floor import Door, Floor, Room
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.rooms.thesis_features import (
    GENERAL_FEATURES,
    GEOMETRIC,
    ROOM_FEATURES,
    area,
    area_over_perimeter,
    axes_ratio,
    circularity,
    compute_general_features,
    compute_room_features,
    form_factor,
    mean_distance,
    normalised_circularity,
    normalised_mean_distance,
    perimeter,
)

# Scaling lengths by k scales each feature by k to this power.
POWERS = {"area": 2.0, "perimeter": 1.0, "area_over_perimeter": 1.0, "mean_distance": 1.0, "form_factor": 1.5}
IN_FILES = ("area", "perimeter", "aoverp", "adcs", "ff", "circularity", "normalcirc", "andcs")
LINE = LineString([(0, 0), (0, 0.9)])


@st.composite
def floors(draw: st.DrawFn) -> Floor:
    """Rooms with 3 to 8 corners around their middles, and doors between any of them and to the outside."""
    shapes = draw(st.lists(st.lists(st.floats(1, 10), min_size=3, max_size=8), min_size=1, max_size=6))
    rooms = []
    for number, radii in enumerate(shapes, start=1):
        turns = [tau * index / len(radii) for index in range(len(radii))]
        corners = [(30 * number + r * cos(turn), r * sin(turn)) for r, turn in zip(radii, turns, strict=True)]
        rooms.append(Room(number, Polygon(corners)))
    ids = st.integers(1, len(rooms))
    pairs = draw(st.lists(st.tuples(ids, ids | st.none()).filter(lambda pair: pair[0] != pair[1]), max_size=12))
    return Floor(tuple(rooms), tuple(Door(pair, LINE, 0.9) for pair in pairs))


def move(floor: Floor, *, turn: float = 0.0, scale: float = 1.0, shift: tuple[float, float] = (0.0, 0.0)) -> Floor:
    a, b = scale * cos(turn), scale * sin(turn)
    rooms = tuple(Room(room.id, affine_transform(room.polygon, (a, -b, b, a, *shift))) for room in floor.rooms)
    return Floor(rooms, floor.doors)


def test_names_in_the_order_of_section_5_2() -> None:
    assert " ".join(ROOM_FEATURES) == (
        "area perimeter area_over_perimeter mean_distance form_factor circularity normalised_circularity"
        " normalised_mean_distance doors closeness betweenness"
    )
    assert GENERAL_FEATURES == ("area", "doors", "axes_ratio")


def test_a_rectangle_of_3_by_4_metres() -> None:
    room = box(10, 20, 13, 24)
    assert area(room) == 12
    assert perimeter(room) == 14
    assert area_over_perimeter(room) == pytest.approx(12 / 14)
    assert mean_distance(room) == pytest.approx(2.5)
    assert form_factor(room) == pytest.approx(48 * pi / sqrt(14))
    assert circularity(room) == pytest.approx(196 / 12)
    assert normalised_circularity(room) == pytest.approx(48 * pi / 196)
    assert normalised_mean_distance(room) == 1
    assert axes_ratio(room) == pytest.approx(4 / 3)


def test_corners_along_a_wall_count_in_the_mean_distance_only() -> None:
    # Corners at the middles of the long walls are 1.5 m from the centroid, the four others 2.5 m.
    room = Polygon([(0, 0), (3, 0), (3, 2), (3, 4), (0, 4), (0, 2)])
    assert mean_distance(room) == pytest.approx((4 * 2.5 + 2 * 1.5) / 6)
    assert normalised_mean_distance(room) == pytest.approx((4 + 2 * 0.6) / 6)
    assert circularity(room) == pytest.approx(196 / 12)


def test_the_centroid_is_that_of_the_area() -> None:
    # It is also the mean of the three corners, but not of the four points of the closed outline.
    triangle = Polygon([(0, 0), (6, 0), (0, 3)])
    assert mean_distance(triangle) == pytest.approx((sqrt(5) + sqrt(17) + sqrt(8)) / 3)
    assert normalised_mean_distance(triangle) == pytest.approx((sqrt(5) + sqrt(17) + sqrt(8)) / 3 / sqrt(17))


def test_a_hole_is_no_area_and_part_of_the_boundary() -> None:
    ring = Polygon(box(0, 0, 8, 8).exterior, [box(1, 1, 7, 7).exterior])
    assert (area(ring), perimeter(ring)) == (28, 56)
    assert mean_distance(ring) == pytest.approx(3.5 * sqrt(2))
    assert axes_ratio(ring) == 1


def test_the_axes_of_triangles_do_not_depend_on_which_side_is_taken() -> None:
    # All boxes along a side of a triangle have the same area; those of this one are 4 × 3 and 5 × 2.4.
    triangle = Polygon([(0, 0), (4, 0), (0, 3)])
    for degrees in range(0, 360, 7):
        assert axes_ratio(move(Floor((Room(1, triangle),)), turn=degrees * pi / 180).rooms[0].polygon) == (
            pytest.approx(4 / 3)
        )


def test_doors_and_roles_of_a_small_floor() -> None:
    # 1 - 2 - 3 and an isolated room; two doors from 1 to 2, an opening and an entrance.
    rooms = tuple(Room(number, box(3 * number, 0, 3 * number + 2, 1)) for number in (7, 2, 3, 1))
    opening = Door((2, 3), LINE, 0.9, "opening")
    floor = Floor(rooms, (Door((1, 2), LINE, 0.9), Door((1, 2), LINE, 0.9), opening, Door((1, None), LINE, 0.9)))
    roles = compute_room_features(floor)[:, 8:]
    assert_allclose(roles, [[0.0, 0, 0], [3, 1, 0.5], [1, 2 / 3, 0], [3, 2 / 3, 0]])
    assert_allclose(compute_general_features(floor), [[2, 0, 2], [2, 3, 2], [2, 1, 2], [2, 3, 2]])


def test_an_isolated_room_has_no_part_in_the_roles_of_others() -> None:
    rooms = tuple(Room(number, box(3 * number, 0, 3 * number + 2, 1)) for number in (1, 2, 3))
    doors = (Door((1, 2), LINE, 0.9), Door((2, 3), LINE, 0.9))
    with_one_more = Floor((*rooms, Room(9, box(0, 5, 1, 6))), doors)
    assert_allclose(compute_room_features(with_one_more)[:3], compute_room_features(Floor(rooms, doors)))


def test_a_floor_without_rooms() -> None:
    assert compute_room_features(Floor(())).shape == (0, 11)
    assert compute_general_features(Floor(())).shape == (0, 3)


@pytest.mark.slow
@given(floors(), st.floats(0, tau), st.tuples(st.floats(-100, 100), st.floats(-100, 100)))
def test_turning_and_shifting_change_nothing(floor: Floor, turn: float, shift: tuple[float, float]) -> None:
    moved = move(floor, turn=turn, shift=shift)
    assert_allclose(compute_room_features(moved), compute_room_features(floor), rtol=1e-9, atol=1e-12)
    assert_allclose(compute_general_features(moved), compute_general_features(floor), rtol=1e-9)


@pytest.mark.slow
@given(floors(), st.floats(0.1, 10))
def test_scaling_changes_by_known_powers(floor: Floor, scale: float) -> None:
    factors = [scale ** POWERS.get(name, 0.0) for name in ROOM_FEATURES]
    scaled = move(floor, scale=scale)
    assert_allclose(compute_room_features(scaled), compute_room_features(floor) * factors, rtol=1e-9, atol=1e-12)
    assert_allclose(compute_general_features(scaled), compute_general_features(floor) * (scale**2, 1, 1), rtol=1e-9)


@pytest.mark.slow
@given(floors())
def test_bounds(floor: Floor) -> None:
    values = dict(zip(ROOM_FEATURES, compute_room_features(floor).T, strict=True))
    assert (values["circularity"] >= 4 * pi).all()
    for name in ("normalised_circularity", "normalised_mean_distance", "closeness"):
        assert (values[name] <= 1 + 1e-12).all()
    assert (values["betweenness"] <= 0.5).all()
    assert (compute_general_features(floor)[:, 2] >= 1).all()


@pytest.mark.slow
def test_geometry_equals_that_of_the_files(data: Path) -> None:
    """The authors' code took vertices divided by the door's width, without a remainder, and rounded half areas up."""
    same, from_origin, rooms = np.zeros(len(GEOMETRIC)), 0, 0
    for path in list_buildings(data):
        root = ElementTree.parse(path).getroot()
        door = int(root.findtext("scale/represented_distance/value"))
        for space in root.iterfind("floor/spaces/space"):
            points = space.iterfind("bounding_polygon/point")
            outline = Polygon([(int(point.get("x")) // door, int(point.get("y")) // door) for point in points])
            if area(outline) % 1:
                continue
            measured = [measure(outline) for measure in GEOMETRIC.values()]
            reference = [float(space.find(f"features/{name}").get("value")) for name in IN_FILES]
            same += np.isclose(measured, reference, rtol=1e-6)
            from_origin += np.isclose(np.hypot(*outline.exterior.xy)[:-1].mean(), reference[3])
            rooms += 1
    shares = dict(zip(GEOMETRIC, same / rooms, strict=True))
    assert shares.pop("mean_distance") == shares.pop("normalised_mean_distance") == 0
    # In the files these are the distances to the origin.
    assert min(*shares.values(), from_origin / rooms) > 0.998


@pytest.mark.slow
def test_centralities_equal_those_of_the_files(data: Path) -> None:
    """Betweenness in the files is the usual one, twice that of Table 5.1; the values of some rooms are unexplained."""
    same, rooms = np.zeros(2), 0
    for path in list_buildings(data):
        spaces = ElementTree.parse(path).getroot().iterfind("floor/spaces/space")
        reference = [
            [float(space.find(f"features/{name}").get("value")) for name in ("closeness", "betweenness")]
            for space in spaces
        ]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", BuildingWarning)
            measured = compute_room_features(read_building_xml(path))[:, 9:] * (1, 2)
        same += np.isclose(measured, reference, rtol=1e-6, atol=1e-9).sum(axis=0)
        rooms += len(measured)
    assert (same / rooms > (0.75, 0.65)).all()


def list_buildings(data: Path) -> list[Path]:
    return [
        path
        for building_type in ("school", "office")
        for path in sorted((data / "buildings" / building_type).glob("*.xml"))
    ]
