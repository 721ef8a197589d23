"""Rooms, doors and floors, their graph, and the cells that rooms cover."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon, affinity, box, contains_xy, distance, points

from pianta.errors import FloorError
from pianta.floor import Door, Floor, Furniture, Room, cells_of_polygon, scale_floor
from pianta.gridmap import GridMap

SHELL = [(0, 0), (4, 0), (4, 3), (0, 3)]
HOLE = [(1, 1), (2, 1), (2, 2), (1, 2)]
BOW_TIE = Polygon([(0, 0), (1, 1), (1, 0), (0, 1)])
WIDE = LineString([(4, 0), (4, 2)])
NARROW = LineString([(4, 2.2), (4, 2.8)])

fine = st.integers(-400, 1600).map(lambda hundredths: hundredths / 100)
corner = st.tuples(fine, fine)
yaw = st.floats(-pi, pi)


def free_map(*, resolution: float = 1.0, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> GridMap:
    return GridMap(np.zeros((10, 12), np.int8), resolution, origin)


def mask_of_polygon(polygon: Polygon, grid: GridMap) -> np.ndarray:
    mask = np.zeros(grid.shape, bool)
    rows, cols, inside = cells_of_polygon(polygon, grid)
    mask[rows, cols] = inside
    return mask


def centres_of_cells(grid: GridMap) -> tuple[np.ndarray, np.ndarray]:
    row, col = np.indices(grid.shape) + 0.5
    return grid.pixel_to_map(row, col)


@pytest.mark.parametrize("turn", [1, -1])
def test_room_turns_its_rings(turn):
    room = Room(1, Polygon(SHELL[::turn], [HOLE[::turn]]))
    assert room.polygon.exterior.is_ccw
    assert not room.polygon.interiors[0].is_ccw
    assert room.polygon.area == 11


@pytest.mark.parametrize("id_", [0, -3])
def test_room_id_is_positive(id_):
    with pytest.raises(FloorError, match=str(id_)):
        Room(id_, box(0, 0, 1, 1))


@pytest.mark.parametrize("polygon", [Polygon(), BOW_TIE, box(0, 0, 1, 1).boundary, Polygon([(0, 0), (1, 1), (2, 2)])])
def test_room_polygon_is_valid(polygon):
    with pytest.raises(FloorError, match="polygon"):
        Room(7, polygon)


@pytest.mark.parametrize("probability", [-0.1, 1.01, float("nan"), float("inf")])
def test_probabilities_of_labels_are_probabilities(probability):
    with pytest.raises(FloorError, match=f"LAB.*{probability}"):
        Room(7, box(0, 0, 1, 1), label_probabilities={"R/C": {"ROOM": 1}, "school": {"HALL": 0, "LAB": probability}})


def test_probabilities_belong_to_a_label_set():
    with pytest.raises(FloorError, match="LAB"):
        Room(7, box(0, 0, 1, 1), label_probabilities={"LAB": 0.5})  # type: ignore[dict-item]


def test_labels_of_a_room_are_copied_and_a_label_needs_no_probability():
    labels = {"R/C": "ROOM", "school": "LAB"}
    lab: dict[str, float] = {"LAB": np.float64(0.5)}
    room = Room(7, box(0, 0, 1, 1), "LAB", labels, {"school": lab})
    labels["R/C"], lab["LAB"] = "CORRIDOR", 0.9
    assert room == Room(7, box(0, 0, 1, 1), "LAB", {"R/C": "ROOM", "school": "LAB"}, {"school": {"LAB": 0.5}})
    assert type(room.label_probabilities["school"]["LAB"]) is float
    node = Floor((room,)).graph().nodes[7]
    node["labels"].clear()
    node["label_probabilities"]["school"].clear()
    assert (room.labels["school"], room.label_probabilities["school"]) == ("LAB", {"LAB": 0.5})


@pytest.mark.parametrize(
    ("labels", "probabilities", "probability"),
    [
        ({"R/C": "CORRIDOR", "school": "CORRIDOR"}, {"school": {"CORRIDOR": 0.7}, "R/C": {"CORRIDOR": 0.9}}, 0.7),
        ({}, {"R/C": {"CORRIDOR": 0.9}, "school": {"CORRIDOR": 0.7}}, 0.7),
        ({"R/C": "CORRIDOR", "school": "CORRIDOR"}, {"R/C": {"CORRIDOR": 0.9}, "school": {"LAB": 0.7}}, 0.9),
        ({"R/C": "CORRIDOR"}, {"R/C": {"ROOM": 1.0}}, None),
        ({}, {}, None),
    ],
)
def test_the_probability_of_the_label_is_that_of_the_finest_set(labels, probabilities, probability):
    assert Room(1, box(0, 0, 1, 1), "CORRIDOR", labels, probabilities).label_probability == probability
    assert Room(1, box(0, 0, 1, 1), None, labels, probabilities).label_probability is None


def test_door_sorts_its_rooms():
    assert Door((5, 2), WIDE, 2.0).rooms == (2, 5)


@pytest.mark.parametrize("rooms", [(3, None), (None, 3)])
def test_an_entrance_is_a_door_to_no_second_room(rooms):
    entrance = Door(rooms, WIDE, 2.0)
    assert (entrance.rooms, entrance.room_ids, entrance.is_entrance) == ((3, None), (3,), True)
    assert entrance.renumber_rooms({3: 8}).rooms == (8, None)
    door = Door((2, 5), WIDE, 2.0)
    assert (door.room_ids, door.is_entrance) == ((2, 5), False)
    assert door.renumber_rooms({2: 9, 5: 4}) == Door((4, 9), WIDE, 2.0)


def test_an_entrance_needs_a_room_and_a_width():
    with pytest.raises(FloorError, match="room"):
        Door((None, None), WIDE, 1.0)  # type: ignore[arg-type]
    with pytest.raises(FloorError, match="width"):
        Door((3, None), WIDE, -1)
    with pytest.raises(FloorError, match=r"\b8\b"):
        Floor((Room(1, box(0, 0, 1, 1)),), (Door((1, None), WIDE, 1.0), Door((8, None), WIDE, 1.0)))


@pytest.mark.parametrize(("given_id", "last_id"), [(0, 7), (7, 7), (9, 9)])
def test_last_id_is_the_highest_id_unless_a_higher_one_was_given(given_id, last_id):
    rooms = Room(7, box(0, 0, 1, 1)), Room(2, box(1, 0, 2, 1))
    assert Floor(rooms, last_id=given_id).last_id == last_id


@pytest.mark.parametrize("last_id", [6, 1, -1])
def test_last_id_is_not_below_an_id(last_id):
    with pytest.raises(FloorError, match=str(last_id)):
        Floor((Room(7, box(0, 0, 1, 1)),), last_id=last_id)


@pytest.mark.parametrize("width", [-0.1, float("nan")])
def test_door_width_is_not_negative(width):
    with pytest.raises(FloorError, match="width"):
        Door((2, 5), WIDE, width)


def test_door_joins_two_rooms():
    with pytest.raises(FloorError, match="itself"):
        Door((2, 2), WIDE, 1.0)


def test_floor_lists_all_its_faults():
    room = Room(1, box(0, 0, 1, 1))
    with pytest.raises(FloorError, match=r"\b1\b.*\b8, 9\b"):
        Floor((room, room), (Door((9, 8), WIDE, 1.0),))


def test_graph_joins_rooms_by_their_widest_door():
    room_labels = {"R/C": "ROOM", "office": "OFFICE"}, {"office": {"OFFICE": 0.8, "HALL": 0.2}}
    office = Room(1, box(0, 0, 4, 3), "OFFICE", *room_labels)
    rooms = office, Room(2, box(4, 0, 9, 3), partial=True, probability=0.25), Room(3, box(9, 0, 10, 3))
    doors = (
        Door((2, 1), WIDE, 2.0, probability=0.75),
        Door((1, 2), NARROW, 0.6),
        Door((2, None), WIDE, 2.0),
        Door((2, None), NARROW, 0.6),
    )
    graph = Floor(rooms, doors, source="here").graph()
    assert graph.graph == {"source": "here"}
    assert list(graph) == [1, 2, 3]
    label_fields = {"label": "OFFICE", "labels": room_labels[0], "label_probabilities": room_labels[1]}
    assert graph.nodes[1] == label_fields | {
        "area": 12.0,
        "x": 2.0,
        "y": 1.5,
        "partial": False,
        "entrances": 0,
    } | dict.fromkeys(("number", "name", "flag", "predicted_area", "confidence", "probability"))
    assert [graph.nodes[2][name] for name in label_fields] == [None, {}, {}]
    assert graph.nodes[2]["partial"]
    assert graph.nodes[2]["probability"] == 0.25
    assert [graph.nodes[room_id]["entrances"] for room_id in graph] == [0, 2, 0]
    assert list(graph.edges(data=True)) == [(1, 2, {"doors": 2, "width": 2.0, "x": 4.0, "y": 1.0, "probability": 0.75})]


def test_possible_doors_join_no_rooms_in_the_graph():
    rooms = Room(1, box(0, 0, 4, 3)), Room(2, box(4, 0, 9, 3))
    floor = Floor(rooms, possible_doors=(Door((1, 2), NARROW, 0.6), Door((2, None), WIDE, 2.0)))
    assert [*floor.graph().edges] == []
    assert [floor.graph().nodes[room_id]["entrances"] for room_id in (1, 2)] == [0, 0]


def test_possible_doors_lead_to_rooms_of_the_floor():
    with pytest.raises(FloorError, match=r"doors lead to rooms \[5\] that do not exist"):
        Floor((Room(1, box(0, 0, 4, 3)),), possible_doors=(Door((1, 5), NARROW, 0.6),))


def test_label_image_has_row_0_at_the_top():
    labels = Floor((Room(7, box(1, 0, 3, 1)), Room(9, box(3, 0, 4, 2)))).label_image(
        GridMap(np.zeros((3, 5), np.int8), resolution=1.0)
    )
    assert labels.dtype == np.uint16
    assert labels.tolist() == [[0, 0, 0, 0, 0], [0, 0, 0, 9, 0], [0, 7, 7, 9, 0]]


def test_label_image_follows_the_yaw_of_the_map():
    # The map's rows point along -x: its lower left corner is at (3, 0), its columns run up.
    grid = GridMap(np.zeros((3, 2), np.int8), resolution=1.0, origin=(3.0, 0.0, pi / 2))
    labels = Floor((Room(1, box(0, 0, 1, 1)), Room(2, box(2, 1, 3, 2)))).label_image(grid)
    assert labels.tolist() == [[1, 0], [0, 0], [0, 2]]


def test_label_image_leaves_holes_and_the_outside():
    ring = Room(1, Polygon([(-5, -5), (50, -5), (50, 50), (-5, 50)], [[(2, 2), (9, 2), (9, 7), (2, 7)]]))
    labels = Floor((ring, Room(2, box(100, 100, 101, 101)))).label_image(free_map())
    assert (labels == 0).sum() == 35
    assert (labels == 1).sum() == 85


def test_label_image_holds_16_bits():
    assert Floor((Room(65535, box(0, 0, 1, 1)),)).label_image(free_map()).max() == 65535
    with pytest.raises(FloorError, match="65536"):
        Floor((Room(65536, box(0, 0, 1, 1)),)).label_image(free_map())


@pytest.mark.slow
@given(corners=st.lists(corner, min_size=3, max_size=6), yaw=yaw)
def test_cells_are_those_whose_centre_is_inside(corners, yaw):
    polygon = LineString(corners).buffer(0.5, quad_segs=2)
    grid = free_map(resolution=0.7, origin=(1.0, -2.0, yaw))
    x, y = centres_of_cells(grid)
    clear = distance(polygon.boundary, points(x, y)) > 1e-9
    assert (mask_of_polygon(polygon, grid) == contains_xy(polygon, x, y))[clear].all()


@given(a=corner, b=corner, c=corner, d=corner)
@example(a=(2.45, 9.65), b=(7.45, 9.65), c=(3.7, 5.9), d=(-2.55, 9.65))  # crosses cell centres
def test_polygons_that_share_an_edge_share_no_cell(a, b, c, d):
    """Two triangles on both sides of a diagonal tile their quadrilateral, whichever way the diagonal runs."""
    left, right = Polygon([a, b, c]), Polygon([c, d, a])
    if left.area == 0 or right.area == 0 or left.intersection(right).area > 0:
        return
    grid = free_map()
    masks = mask_of_polygon(left, grid), mask_of_polygon(right, grid)
    assert not (masks[0] & masks[1]).any()
    x, y = centres_of_cells(grid)
    inside = contains_xy(left.union(right), x, y) & (distance(left.union(right).boundary, points(x, y)) > 1e-9)
    assert (masks[0] | masks[1])[inside].all()


@pytest.mark.slow
@given(cuts=st.lists(st.integers(0, 120), min_size=2, max_size=8, unique=True).map(sorted), yaw=yaw)
def test_rooms_side_by_side_cover_each_cell_once(cuts, yaw):
    rectangles = [box(left / 10, 0, right / 10, 10) for left, right in pairwise(cuts)]
    turned = [affinity.rotate(rectangle, yaw, origin=(0, 0), use_radians=True) for rectangle in rectangles]
    grid = free_map(origin=(0.0, 0.0, yaw))
    masks = [mask_of_polygon(polygon, grid) for polygon in turned]
    assert np.sum(masks, axis=0).max() <= 1
    labels = Floor(tuple(Room(number, polygon) for number, polygon in enumerate(turned, start=1))).label_image(grid)
    assert all((labels == number).tolist() == mask.tolist() for number, mask in enumerate(masks, start=1))


def test_building_types_are_in_lower_case_and_the_most_probable_comes_first():
    floor = Floor((), building_type={"Office": 0.3, " SCHOOL ": 0.2, "school": 0.4, "old  house": 0.1})
    assert floor.building_type == pytest.approx({"office": 0.3, "school": 0.6, "old house": 0.1})
    assert floor.building_types == ("school", "office", "old house")
    assert Floor(()).building_types == ()


@pytest.mark.parametrize("name", ["", "  ", "X" * 101, "BELL\a"])
def test_building_types_that_are_no_names_stay(name):
    assert Floor((), building_type={name: 1.0}).building_types == (name,)


TABLE = Furniture(box(1, 0.5, 1.5, 1), 0.5)


def test_scaled_floor():
    rooms = Room(1, box(1, 0, 2, 1), "GYM"), Room(2, box(2, 0, 3, 1))
    doors = Door((1, 2), LineString([(2, 0.2), (2, 0.6)]), 0.5), Door((1, None), LineString([(1, 0), (2, 0)]), 0.8)
    floor = Floor(rooms, doors, (LineString([(1, 0), (1, 1)]),), {"school": 1.0}, "a.xml", 7, (TABLE,), doors[:1])
    larger = scale_floor(floor, 3, 2)
    assert larger.possible_doors == larger.doors[:1]
    assert [room.polygon.bounds for room in larger.rooms] == [(3, 0, 6, 2), (6, 0, 9, 2)]
    assert [door.width for door in larger.doors] == pytest.approx([1.0, 2.4])
    bounds = [bound for door in larger.doors for bound in door.line.bounds]
    assert bounds == pytest.approx([6, 0.4, 6, 1.2, 3, 0, 6, 0])
    assert larger.walls[0].bounds == (3, 0, 3, 2)
    assert [(piece.polygon.bounds, piece.probability) for piece in larger.furniture] == [((3, 1, 4.5, 2), 0.5)]
    assert larger.rooms[0].label == "GYM"
    assert (larger.building_type, larger.source, larger.last_id) == ({"school": 1.0}, "a.xml", 7)
    assert scale_floor(floor, 1, 1) == floor


def test_a_door_without_length_is_scaled():
    point = LineString([(1, 0.5), (1, 0.5)])
    floor = Floor((Room(1, box(0, 0, 1, 1)),), (Door((1, None), point, 0.9),))
    assert scale_floor(floor, 1, 4).doors[0].width == pytest.approx(1.8)


@pytest.mark.parametrize(
    ("types", "building_type"),
    [({"school": 1.0}, "school"), ({"school": 0.9, "office": 0.1}, None), ({"school": 0.9}, None), ({}, None)],
)
def test_a_type_with_probability_1_is_a_given_type(types, building_type):
    assert Floor((), building_type=types).given_type == building_type


def test_the_name_of_a_room_is_also_that_of_its_node():
    floor = Floor((Room(1, box(0, 0, 1, 1), name="204 Französisch"), Room(2, box(1, 0, 2, 1), name="x" * 200)))
    assert [floor.graph().nodes[room_id]["name"] for room_id in (1, 2)] == ["204 Französisch", "x" * 200]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("", "name"),
        (" ", "name"),
        ("x" * 201, "x" * 20),
        (12, "12"),
        ("a\nb", r"a\\nb"),
    ],
)
def test_the_name_of_a_room_is_a_short_printable_text(name, message):
    with pytest.raises(FloorError, match=message):
        Room(7, box(0, 0, 1, 1), name=name)


@pytest.mark.parametrize("polygon", [Polygon(), BOW_TIE, Point(0, 0)])
def test_furniture_needs_a_valid_polygon(polygon):
    with pytest.raises(FloorError, match="furniture has no valid polygon"):
        Furniture(polygon)


def test_furniture_is_stored_counter_clockwise():
    clockwise = Polygon([(0, 0), (0, 1), (1, 1), (1, 0)])
    assert not clockwise.exterior.is_ccw
    assert Furniture(clockwise).polygon.exterior.is_ccw


@pytest.mark.parametrize("probability", [-0.01, 1.01, float("nan")])
def test_a_probability_is_between_0_and_1(probability):
    with pytest.raises(FloorError, match=f"room 3 has probability {probability}, give 0 to 1"):
        Room(3, box(0, 0, 1, 1), probability=probability)
    with pytest.raises(FloorError, match=f"entrance to room 3 has probability {probability}, give 0 to 1"):
        Door((3, None), WIDE, 1.0, probability=probability)
    with pytest.raises(FloorError, match=f"furniture has probability {probability}, give 0 to 1"):
        Furniture(box(0, 0, 1, 1), probability)


def test_a_door_keeps_its_probability_between_rooms_with_new_ids():
    door = Door((1, 2), WIDE, 1.0, probability=0.5).renumber_rooms({1: 4, 2: 3})
    assert (door.rooms, door.probability) == ((3, 4), 0.5)
