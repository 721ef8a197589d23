"""Features of rooms in their building: values by hand, invariances, and unusual floors."""

import warnings
from dataclasses import replace
from math import cos, log, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from shapely import LineString, Polygon, box
from shapely.affinity import affine_transform

from pianta.errors import BuildingWarning
from pianta.floor import Door, Floor, Room
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.rooms._outlines import draw_outlines, measure_unit
from pianta.rooms._shapes import MISSING, fit_rectangles, list_door_ends, measure_shapes
from pianta.rooms._surroundings import _draw_band
from pianta.rooms.features import CONTEXT_FEATURES, RoomContext, describe_rooms
from pianta.worlds.floors import FLOOR_MAKERS, make_floor

# A corridor of 12 m by 2 m below three rooms of 4 m by 3 m, each with a door 1 m from its left end.
CORRIDOR = box(0, 0, 12, 2)
ROOMS = [box(x, 2, x + 4, 5) for x in (0, 4, 8)]
UNIT = sqrt(12)


def hang_door(one: int, other: int | None, x: float, y: float, door_kind: str = "door") -> Door:
    assert door_kind in ("door", "opening")
    line = LineString([(x - 0.45, y), (x + 0.45, y)])
    return Door((one, other), line, 0.9, "opening" if door_kind == "opening" else "door")


def build(*polygons: Polygon, doors: tuple[Door, ...] = ()) -> Floor:
    return Floor(tuple(Room(number, polygon) for number, polygon in enumerate(polygons, start=1)), doors)


def row_of_rooms() -> Floor:
    doors = tuple(hang_door(1, 2 + index, 1 + 4 * index, 2) for index in range(3))
    return build(CORRIDOR, *ROOMS, doors=doors)


def column(context: RoomContext, name: str) -> list[float]:
    values: list[float] = context.features[:, CONTEXT_FEATURES.index(name)].tolist()
    return values


def move(floor: Floor, *, turn: float = 0.0, scale: float = 1.0, shift: tuple[float, float] = (0.0, 0.0)) -> Floor:
    a, b = scale * cos(turn), scale * sin(turn)
    matrix = (a, -b, b, a, *shift)
    rooms = [replace(room, polygon=affine_transform(room.polygon, matrix)) for room in floor.rooms]
    doors = [replace(door, line=affine_transform(door.line, matrix), width=door.width * scale) for door in floor.doors]
    return Floor(tuple(rooms), tuple(doors))


def grid_of_rooms(rows: int, cols: int) -> list[Polygon]:
    return [box(4 * col, 3 * row, 4 * col + 4, 3 * row + 3) for row in range(rows) for col in range(cols)]


@pytest.mark.parametrize(
    ("name", "values"),
    {
        "compactness": [4 * pi * 24 / 28**2, *[4 * pi * 12 / 14**2] * 3],
        "elongation": [6, *[4 / 3] * 3],
        "rectangularity": [1] * 4,
        "convexity": [1] * 4,
        "doors": [3, 1, 1, 1],
        "openings": [0] * 4,
        "door_span": [8 / 12, 0, 0, 0],
        "door_to_end": [1 / 12, *[1 / 4] * 3],
        "size_to_median": [log(2), 0, 0, 0],
        "size_rank": [(3 / 4 + 1) / 2, *[3 / 8] * 3],
        "length_to_floor": [12 / sqrt(60), *[4 / sqrt(60)] * 3],
        "share_of_floor": [24 / 60, *[12 / 60] * 3],
        "size_to_commonest": [log(2), 0, 0, 0],
        "alike": [0, 2, 2, 2],
        "alike_share": [0, 1 / 2, 1 / 2, 1 / 2],
        "size_to_nearest": [log(2), 0, 0, 0],
        "facade_sides": [3, 2, 1, 2],
        "wall_neighbours": [3, 2, 3, 2],
        "wall_neighbours_alike": [0, 1, 2, 1],
        "wall_size_max": [-log(2), *[log(2)] * 3],
        "wall_size_min": [-log(2), 0, 0, 0],
        "degree": [3, 1, 1, 1],
        "mean_degree": [6 / 4] * 4,
        "closeness": [1, *[3 / 5] * 3],
        "betweenness": [1 / 2, 0, 0, 0],
        "eccentricity": [1, 2, 2, 2],
        "eccentricity_share": [1 / 2, 1, 1, 1],
        "within_2": [4] * 4,
        "within_3_share": [1] * 4,
        "hops_to_hub": [0, 1, 1, 1],
        "parts": [3, 1, 1, 1],
        "cut_off": [2, 0, 0, 0],
        "cut_off_share": [1 / 2, 0, 0, 0],
        "leaves": [3, 0, 0, 0],
        "leaves_share": [1, 0, 0, 0],
        "small_leaves": [0] * 4,
        "siblings": [0, 2, 2, 2],
        "siblings_alike_share": [0, 1, 1, 1],
        "main_end": [1 / 4, 1 / 12, 5 / 12, 3 / 12],
        "neighbour_size_max": [-log(2), *[log(2)] * 3],
        "neighbour_degree_mean": [1, 3, 3, 3],
        "neighbour_elongation_min": [4 / 3, 6, 6, 6],
    }.items(),
)
def test_features_of_a_corridor_with_three_rooms(name: str, values: list[float]) -> None:
    assert_allclose(column(describe_rooms(row_of_rooms()), name), values, atol=1e-9)


def test_relations_of_the_rooms_of_a_corridor() -> None:
    context = describe_rooms(row_of_rooms())
    star = [[0, 1, 1, 1], [1, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]]
    assert_allclose(context.doors, star)
    assert_allclose(context.hops, [[0, 1, 1, 1], [1, 0, 2, 2], [1, 2, 0, 2], [1, 2, 2, 0]])
    assert context.alike.tolist() == [
        [False] * 4,
        *[[False, *(one != other for other in range(3))] for one in range(3)],
    ]
    assert_allclose(context.area, [24, 12, 12, 12])


def test_katz_centrality_of_a_star_does_not_depend_on_its_length() -> None:
    alpha = 0.5 / sqrt(3)
    centre = (1 + 3 * alpha) / (1 - 3 * alpha**2)
    values = np.array([centre, *[1 + alpha * centre] * 3])
    assert_allclose(column(describe_rooms(row_of_rooms()), "katz"), values / np.sqrt((values**2).mean()))


def test_shared_walls_continue_around_corners_by_a_share_of_the_unit() -> None:
    walls = describe_rooms(row_of_rooms()).walls
    reach = 0.12 * UNIT
    assert_allclose(walls[1], [(4 + 2 * reach) / 14, 0, (3 + 2 * reach) / 14, 0])
    # The room in the middle has neighbours on three sides; its walls continue around all corners but the upper two.
    assert_allclose(walls[2], [(4 + 2 * reach) / 14, (3 + 2 * reach) / 14, 0, (3 + 2 * reach) / 14])
    assert (walls.sum(axis=1) <= 1 + 1e-9).all()


def test_walls_of_a_room_inside_a_ring_add_up_to_its_perimeter() -> None:
    ring = box(0, 0, 10, 10).difference(box(3, 3, 7, 7))
    walls = describe_rooms(build(ring, box(3, 3, 7, 5), box(3, 5, 7, 7))).walls
    assert walls[1].sum() == pytest.approx(1)
    assert walls[1, 2] == pytest.approx(walls[2, 1])
    assert walls[1, 2] > 0.2


def test_the_facade_of_an_outline_with_a_repeated_corner() -> None:
    """The band around this outline, of a reading of a real map, crosses itself: GEOS cannot intersect it."""
    hull = Polygon(
        [
            (139.4914993903683, -94.02905197634985),
            (139.4798369736795, -95.23028089529345),
            (139.46252680424504, -97.01322834704301),
            (139.46252680424507, -97.01322834704298),
            (139.42344383481276, -101.03877419857209),
            (16.32344383481278, -83.81377419857212),
        ]
    )
    width = 0.4577621189001988
    assert not hull.boundary.buffer(width, join_style="mitre").is_valid
    band = _draw_band(hull, width)
    assert shapely.length(shapely.intersection(hull.exterior, band)) == pytest.approx(hull.length)
    # A strip along the outline, longer outside than inside by the mitres
    assert band.area == pytest.approx(2 * width * hull.length, rel=0.05)


def test_facade_is_the_share_of_the_outline_near_the_outside() -> None:
    reach = 0.083 * UNIT
    facade = column(describe_rooms(row_of_rooms()), "facade")
    assert_allclose(facade[1:3], [(3 + 4 + 2 * reach) / 14, (4 + 2 * reach) / 14], rtol=1e-6)


def test_a_courtyard_is_outside() -> None:
    around = [box(0, 0, 10, 3), box(0, 7, 10, 10), box(0, 3, 3, 7), box(7, 3, 10, 7)]
    at_courtyard = column(describe_rooms(build(*around)), "facade_sides")
    filled = column(describe_rooms(build(*around, box(3, 3, 7, 7))), "facade_sides")
    assert at_courtyard[2:4] == [2, 2]
    assert filled[2:4] == [1, 1]


def test_openings_and_entrances_are_doors_and_entrances_join_no_rooms() -> None:
    floor = build(*ROOMS, doors=(hang_door(1, 2, 4, 3, "opening"), hang_door(2, None, 6, 5), hang_door(3, None, 9, 5)))
    context = describe_rooms(floor)
    assert column(context, "doors") == [1, 2, 1]
    assert column(context, "openings") == [1, 1, 0]
    assert column(context, "degree") == [1, 1, 0]


def test_a_room_without_doors_has_no_neighbours_to_measure() -> None:
    context = describe_rooms(build(*ROOMS, doors=(hang_door(1, 2, 4, 3),)))
    assert column(context, "hops_to_hub")[2] == 0  # No room is between others, so that each is a hub.
    assert column(context, "door_to_end")[2] == column(context, "main_end")[2] == MISSING
    assert column(context, "neighbour_size_mean")[2] == column(context, "neighbour_facade_min")[2] == MISSING
    assert context.hops[0].tolist() == [0, 1, np.inf]


def test_a_hub_without_a_path_to_it() -> None:
    floor = build(*grid_of_rooms(1, 4), doors=(hang_door(1, 2, 4, 1), hang_door(2, 3, 8, 1)))
    assert column(describe_rooms(floor), "hops_to_hub") == [1, 0, 1, MISSING]


def test_rooms_behind_rooms_are_cut_off_with_them() -> None:
    doors = tuple(hang_door(room, room + 1, 4 * room, 1) for room in range(1, 5))
    context = describe_rooms(build(*grid_of_rooms(1, 5), doors=doors))
    assert column(context, "parts") == [1, 2, 2, 2, 1]
    assert column(context, "cut_off") == [0, 1, 2, 1, 0]
    pair = describe_rooms(build(*ROOMS[:2], doors=(hang_door(1, 2, 4, 3),)))
    assert column(pair, "parts") == column(pair, "cut_off") == [0, 0]


def test_outlines_meet_in_the_middle_of_thick_walls() -> None:
    annotated = row_of_rooms()
    thick = replace(
        annotated,
        rooms=tuple(replace(room, polygon=room.polygon.buffer(-0.1, join_style="mitre")) for room in annotated.rooms),
    )
    outlines = draw_outlines(thick, measure_unit(thick))
    for room, outline in zip(annotated.rooms, outlines, strict=True):
        assert outline.symmetric_difference(room.polygon).area < 1e-9
    for name in ("compactness", "share_of_floor", "wall_neighbours", "facade_sides", "main_end", "alike"):
        assert_allclose(column(describe_rooms(thick), name), column(describe_rooms(annotated), name))


def test_openings_do_not_count_for_the_wall_thickness() -> None:
    apart = build(box(0, 0, 4, 3), box(4.4, 0, 8.4, 3), doors=(hang_door(1, 2, 4.2, 1, "opening"),))
    assert_allclose(shapely.area(draw_outlines(apart, measure_unit(apart))), 12)


def test_niches_pillars_and_corners_in_a_wall_do_not_count_for_the_outline() -> None:
    plain = box(0, 0, 8, 6)
    niche = plain.difference(box(3, 5.8, 3.2, 6))
    pillar = plain.difference(box(4, 3, 4.5, 3.5))
    corners = shapely.segmentize(plain, 0.5)
    floor = build(plain, niche, pillar, corners)
    outlines = draw_outlines(floor, measure_unit(floor))
    for outline in outlines:
        assert outline.symmetric_difference(plain).area < 1e-9
    spreads = measure_shapes(np.array([plain, corners]), fit_rectangles(np.array([plain, corners])))["spread"]
    assert spreads[0] == pytest.approx(spreads[1])


def test_a_room_too_thin_to_open_keeps_its_outline() -> None:
    thin = box(0, 3, 6, 3.1)
    floor = build(box(0, 0, 6, 3), box(0, 3.1, 6, 6), thin)
    assert draw_outlines(floor, measure_unit(floor))[2].equals(thin)


def test_spread_is_the_mean_over_the_outline() -> None:
    outlines = np.array([shapely.Point(3, 4).buffer(2, quad_segs=90), box(0, 0, 2, 2)])
    # The mean distance from the middle to a side of a square of side 2: (√2 + asinh 1) / 2; to its corners, √2.
    circle, square = measure_shapes(outlines, fit_rectangles(outlines))["spread"]
    assert circle == pytest.approx(1, abs=1e-4)
    assert square == pytest.approx((sqrt(2) + np.arcsinh(1)) / 2 / sqrt(2))


def test_both_sides_of_a_square_are_long_sides() -> None:
    floor = build(box(0, 0, 4, 4), doors=(hang_door(1, None, 1, 4), hang_door(1, None, 1.5, 0)))
    ends = list_door_ends(floor)
    squares = fit_rectangles(np.array([box(0, 0, 4, 4)]))
    assert_allclose(squares.distance_to_ends(ends.rooms, np.array([[1.0, 3.0], [1.5, 2.0]])), [1, 1.5])


@pytest.mark.parametrize("turn", [0.0, 0.3, 2.0])
def test_rectangles_are_the_smallest_and_nearest_to_a_square(turn: float) -> None:
    corner = Polygon([(0, 0), (9, 0), (9, 2), (2, 2), (2, 4), (0, 4)])
    # Along its sides of 3 and 4 the triangle fills half of 3 by 4, along the third half of 5 by 2.4.
    triangle = Polygon([(0, 0), (4, 0), (0, 3)])
    moved = move(build(corner, triangle, shapely.segmentize(box(5, 5, 6, 12), 0.4)), turn=turn)
    rectangles = fit_rectangles(np.array([room.polygon for room in moved.rooms]))
    assert_allclose(rectangles.length, [9, 4, 7])
    assert_allclose(rectangles.width, [4, 3, 1])
    around = shapely.polygons(rectangles.corners)
    assert_allclose(shapely.area(around), [36, 12, 7])
    assert all(shapely.covers(shapely.buffer(around, 1e-9), [room.polygon for room in moved.rooms]))


@pytest.mark.slow
@settings(max_examples=30)
@example(floor_maker="hall", seed=0, turn=1.0, scale=0.3, shift=(3.0, 4.0))
@given(
    floor_maker=st.sampled_from(sorted(FLOOR_MAKERS)),
    seed=st.integers(0, 9),
    turn=st.floats(0, 2 * pi),
    scale=st.floats(0.3, 3),
    shift=st.tuples(st.floats(-50, 50), st.floats(-50, 50)),
)
def test_no_feature_depends_on_turn_scale_shift_or_order(
    *, floor_maker: str, seed: int, turn: float, scale: float, shift: tuple[float, float]
) -> None:
    floor = make_floor(floor_maker, seed=seed)
    moved = move(floor, turn=turn, scale=scale, shift=shift)
    rng = np.random.default_rng(seed)
    order, doors = rng.permutation(len(floor.rooms)), rng.permutation(len(floor.doors))
    moved = replace(
        moved, rooms=tuple(moved.rooms[row] for row in order), doors=tuple(moved.doors[row] for row in doors)
    )
    one, other = describe_rooms(floor), describe_rooms(moved)
    assert_allclose(other.features, one.features[order], atol=1e-6)
    assert_allclose(other.walls, one.walls[order][:, order], atol=1e-6)
    assert (other.doors == one.doors[order][:, order]).all()
    assert (other.hops == one.hops[order][:, order]).all()
    assert (other.alike == one.alike[order][:, order]).all()
    assert_allclose(other.area, one.area[order] * scale**2)


@pytest.mark.slow
@settings(max_examples=40)
@given(
    st.lists(st.tuples(*[st.integers(0, 20)] * 2, *[st.floats(0.05, 12)] * 2, st.booleans()), min_size=1, max_size=8),
    st.data(),
)
def test_all_features_are_finite(boxes: list[tuple[int, int, float, float, bool]], data: st.DataObject) -> None:
    rooms = [
        Polygon([(x, y), (x + w, y), (x, y + h)]) if is_corner else box(x, y, x + w, y + h)
        for x, y, w, h, is_corner in boxes
    ]
    ids = st.integers(1, len(rooms))
    pairs = data.draw(st.lists(st.tuples(ids, ids | st.none()).filter(lambda pair: pair[0] != pair[1]), max_size=10))
    kinds = st.sampled_from(["door", "opening"])
    doors = tuple(
        hang_door(*pair, *data.draw(st.tuples(st.floats(0, 30), st.floats(0, 30))), data.draw(kinds)) for pair in pairs
    )
    check_finite(build(*rooms, doors=doors))


ODD_FLOORS = {
    "one room": build(box(0, 0, 3, 4)),
    "one room and an entrance": build(box(0, 0, 3, 4), doors=(hang_door(1, None, 1, 0),)),
    "two rooms": build(*ROOMS[:2], doors=(hang_door(1, 2, 4, 3),)),
    "no doors": build(CORRIDOR, *ROOMS),
    "two floors": build(*ROOMS, *grid_of_rooms(1, 3), doors=(hang_door(1, 2, 4, 3), hang_door(4, 5, 4, 1))),
    "the same room": build(*[box(0, 0, 3, 4)] * 5, doors=tuple(hang_door(1, n, 1, 0) for n in (2, 3, 4, 5))),
    "one door twice": build(*ROOMS[:2], doors=(hang_door(1, 2, 4, 3), hang_door(1, 2, 4, 4))),
    "door without length": build(*ROOMS[:2], doors=(Door((1, 2), LineString([(4, 3), (4, 3)]), 0.0),)),
    "slivers": build(box(0, 0, 1e-6, 1e-6), box(0, 0, 100, 1e-3), box(1, 1, 9, 9)),
    "partial": Floor((Room(7, CORRIDOR, partial=True),)),
    "ring": build(box(0, 0, 9, 9).difference(box(1, 1, 8, 8)), box(2, 2, 7, 7)),
    "500 rooms": build(*grid_of_rooms(20, 25), doors=tuple(hang_door(1, n, 4, 3) for n in range(2, 501, 2))),
}


@pytest.mark.slow
@pytest.mark.parametrize("floor", ODD_FLOORS.values(), ids=ODD_FLOORS.keys())
def test_odd_floors_have_finite_features(floor: Floor) -> None:
    check_finite(floor)


@pytest.mark.slow
@pytest.mark.parametrize("building_type", ["school", "office"])
def test_annotated_floors_have_finite_features(data: Path, building_type: str) -> None:
    files = sorted((data / "buildings" / building_type).glob("*.xml"))
    assert files
    for file in files:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", BuildingWarning)
            floor = read_building_xml(file)
        check_finite(floor)


def test_a_floor_without_rooms() -> None:
    context = describe_rooms(Floor(()))
    assert context.features.shape == (0, len(CONTEXT_FEATURES))
    assert context.doors.shape == context.hops.shape == context.walls.shape == context.alike.shape == (0, 0)
    assert context.area.shape == (0,)


def check_finite(floor: Floor) -> None:
    context = describe_rooms(floor)
    n = len(floor.rooms)
    assert context.features.shape == (n, len(CONTEXT_FEATURES))
    assert np.isfinite(context.features).all()
    assert (context.walls >= 0).all()
    assert (context.walls.sum(axis=1) <= 1 + 1e-9).all()
    assert not context.alike.diagonal().any()


def test_names_are_listed_once() -> None:
    assert len({*CONTEXT_FEATURES}) == len(CONTEXT_FEATURES)
