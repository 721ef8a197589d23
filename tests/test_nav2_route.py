"""Route graphs: drivable, joined, short, and by the rules of Nav2's loader."""

import json
from typing import Any

import networkx as nx
import numpy as np
import pytest
from shapely import LineString, MultiPoint, Point, box

import pianta
from pianta.errors import FloorError, OptionError
from pianta.navigation.free_space import FreeSpace, cross_cells, find_free_space
from pianta.navigation.lattice import build_lattice
from tests.nav2_rules import find_broken_rules

# Two rooms of 4 m x 3 m, cells of 0.1 m; the wall between them is a cell thick and has a door of 1 m at y = 1 … 2.
CELLS = np.full((32, 83), 100, np.int8)
CELLS[1:31, 1:41] = CELLS[1:31, 42:82] = 0
CELLS[11:21, 41] = 0
GRID = pianta.GridMap(CELLS, 0.1, (-0.1, -0.1, 0.0))
NAME = '204 <A> & "B" =1+1 ☕'
ROOMS = (pianta.Room(3, box(0, 0, 4, 3), "OFFICE", name=NAME), pianta.Room(7, box(4.1, 0, 8.1, 3), "CORRIDOR"))
DOOR = pianta.Door((3, 7), LineString([(4.05, 1), (4.05, 2)]), 1.0)
FLOOR = pianta.Floor(ROOMS, (DOOR,))


def measure_clearance(graph: nx.DiGraph, grid: pianta.GridMap) -> float:
    """Metres between the middle of the robot, on any edge, and the nearest middle of an occupied cell."""
    rows, cols = np.nonzero(grid.occupied)
    obstacles = MultiPoint(np.column_stack(grid.pixel_to_map(rows + 0.5, cols + 0.5)))
    lines = [LineString([(graph.nodes[n]["x"], graph.nodes[n]["y"]) for n in edge]) for edge in graph.edges]
    return float(min(line.distance(obstacles) for line in lines))


def test_two_rooms_and_a_door():
    graph = pianta.build_route_graph(FLOOR, GRID)
    assert graph.nodes[3]["metadata"]["class"] == "OFFICE"
    assert graph.nodes[3]["metadata"]["name"] == NAME
    assert {graph.nodes[n]["metadata"]["type"] for n in nx.shortest_path(graph, 3, 7)} == {"room", "door"}
    # Straight through the door at y = 1.5: the rooms are in the middle between the walls
    length = nx.shortest_path_length(graph, 3, 7, weight="cost")
    (x0, y0), (x1, y1) = ((graph.nodes[n]["x"], graph.nodes[n]["y"]) for n in (3, 7))
    straight = np.hypot(x1 - x0, y1 - y0)
    assert straight <= length < 1.1 * straight
    for start, end, data in graph.edges(data=True):
        assert graph.has_edge(end, start)
        first, last = graph.nodes[start], graph.nodes[end]
        assert data["cost"] == pytest.approx(np.hypot(last["x"] - first["x"], last["y"] - first["y"]), abs=1e-3)


@pytest.mark.parametrize("radius", [0.1, 0.22, 0.35])
@pytest.mark.parametrize("world", ["corridor", "ring", "home"])
def test_edges_are_drivable(world, radius):
    floor, grid = pianta.make_world(world, seed=1, furniture=0.5)
    graph = pianta.build_route_graph(floor, grid, robot_radius=radius)
    # An edge may pass a corner of a cell whose middle is farther away: half a diagonal of 5 cm
    assert measure_clearance(graph, grid) > radius - 0.05 * 2**-0.5
    cells = np.array([cell for edge in graph.edges for cell in list_cells(graph, edge, grid)])
    assert find_free_space(floor, grid, radius).open[tuple(cells.T)].all()


def list_cells(graph: nx.DiGraph, edge: tuple[int, int], grid: pianta.GridMap) -> list[list[int]]:
    ends = [np.array(grid.map_to_pixel(graph.nodes[n]["x"], graph.nodes[n]["y"])) for n in edge]
    cells: list[list[int]] = cross_cells(*ends)[0].tolist()
    return cells


@pytest.mark.parametrize("world", ["corridor", "ring", "home", "office", "ward"])
def test_rooms_that_doors_join_are_joined(world):
    floor, grid = pianta.make_world(world, seed=2)
    graph = pianta.build_route_graph(floor, grid)
    for first, second in floor.graph().edges:
        assert nx.has_path(graph, first, second)
        assert nx.has_path(graph, second, first)


def test_a_robot_that_fits_through_no_door_has_separate_rooms():
    """The door is 10 cells wide: its best cell is 5 cells from the jambs' cells."""
    graph = pianta.build_route_graph(FLOOR, GRID, robot_radius=0.49)
    assert nx.has_path(graph, 3, 7)
    graph = pianta.build_route_graph(FLOOR, GRID, robot_radius=0.5)
    assert not nx.has_path(graph, 3, 7)
    assert {3, 7} <= {*graph}


def test_a_curved_passage_has_nodes_between():
    """A corridor in the shape of a U: no straight line joins its ends."""
    cells = np.full((42, 42), 100, np.int8)
    cells[1:41, 1:11] = cells[1:41, 31:41] = cells[31:41, 1:41] = 0
    grid = pianta.GridMap(cells, 0.1)
    outline = box(0.1, 0.1, 4.1, 4.1) - box(1.1, 1.1, 3.1, 4.2)
    doors = tuple(pianta.Door((1, None), LineString([(x, 4.05), (x + 1, 4.05)]), 1.0) for x in (0.1, 3.1))
    graph = pianta.build_route_graph(pianta.Floor((pianta.Room(1, outline),), doors), grid)
    ends = [n for n, data in graph.nodes(data=True) if data["metadata"]["type"] == "door"]
    way = nx.shortest_path(graph, *ends, weight="cost")
    assert len(way) >= 4
    bends = [n for n in way if graph.nodes[n]["metadata"]["type"] == "way"]
    assert all(graph.nodes[n]["metadata"]["room"] == 1 for n in bends)


def test_the_file_obeys_the_loader_and_comes_back(tmp_path):
    notes = pianta.convert(FLOOR, tmp_path / "route.geojson", to="nav2-route", grid=GRID)
    text = (tmp_path / "route.geojson").read_text(encoding="utf-8")
    assert find_broken_rules(text) == []
    assert notes == []
    graph, again = pianta.build_route_graph(FLOOR, GRID), pianta.read_route_graph(tmp_path / "route.geojson")
    assert dict(again.nodes(data=True)) == dict(graph.nodes(data=True))
    assert list(again.edges(data=True)) == list(graph.edges(data=True))
    assert {feature["properties"].get("frame", "map") for feature in json.loads(text)["features"]} == {"map"}


@pytest.mark.parametrize("world", ["corridor", "home", "office"])
def test_the_rules_hold_for_whole_floors(world, tmp_path):
    floor, grid = pianta.make_world(world, seed=3)
    pianta.convert(floor, tmp_path / "route.geojson", to="nav2-route", grid=grid)
    assert find_broken_rules((tmp_path / "route.geojson").read_text(encoding="utf-8")) == []


def test_what_the_robot_cannot_reach_is_listed(tmp_path):
    """A third room, behind a door of 0.3 m, and one too small for the robot."""
    cells = np.full((32, 135), 100, np.int8)
    cells[:, :83] = CELLS
    cells[1:31, 83:113] = 0
    cells[11:14, 82] = 0
    cells[1:5, 114:118] = 0
    grid = pianta.GridMap(cells, 0.1, GRID.origin)
    rooms = (*ROOMS, pianta.Room(8, box(8.2, 0, 11.2, 3)), pianta.Room(9, box(11.3, 2.6, 11.7, 3)))
    doors = (DOOR, pianta.Door((7, 8), LineString([(8.15, 1.7), (8.15, 2)]), 0.3))
    floor = pianta.Floor(rooms, doors)
    notes = pianta.convert(floor, tmp_path / "route.geojson", to="nav2-route", grid=grid)
    assert notes == ["the robot fits nowhere in rooms 9", "the robot passes no door between rooms 7–8"]


@pytest.mark.parametrize("rooms", [ROOMS[:1], ROOMS])
def test_a_graph_without_edges_is_refused(tmp_path, rooms):
    with pytest.raises(FloorError, match=r"has no edge, which Nav2 refuses"):
        pianta.convert(pianta.Floor(rooms), tmp_path / "route.geojson", to="nav2-route", grid=GRID)
    assert not (tmp_path / "route.geojson").exists()


def test_a_building_of_two_storeys_is_refused(tmp_path):
    storeys = tuple(pianta.Storey(FLOOR, name, grid=GRID) for name in ("ground", "first"))
    with pytest.raises(OptionError, match="one of the storeys 'ground', 'first'"):
        pianta.convert(pianta.Building(storeys), tmp_path / "route.geojson", to="nav2-route")


def test_a_turned_map_has_the_same_graph():
    """Positions are those of the map frame, whatever the yaw of the grid."""
    turned = pianta.GridMap(np.rot90(CELLS, -1), 0.1, (-0.1, 3.1, -np.pi / 2))
    graph, other = pianta.build_route_graph(FLOOR, GRID), pianta.build_route_graph(FLOOR, turned)
    assert FLOOR.room_at(other.nodes[3]["x"], other.nodes[3]["y"]) == ROOMS[0]
    lengths = [nx.shortest_path_length(each, 3, 7, weight="cost") for each in (graph, other)]
    assert lengths[0] == pytest.approx(lengths[1], rel=0.1)


def make_graph(**changes: dict[str, Any]) -> str:
    """A file of two nodes and an edge, with changed properties of a feature: key of the feature, then properties."""
    features: dict[str, dict[str, Any]] = {
        "node": {"type": "Point", "coordinates": [0, 0], "properties": {"id": 0, "frame": "map"}},
        "other": {"type": "Point", "coordinates": [1, 0], "properties": {"id": 1, "frame": "map"}},
        "edge": {
            "type": "LineString",
            "coordinates": [[0, 0], [1, 0]],
            "properties": {"id": 2, "startid": 0, "endid": 1},
        },
    }
    for key, properties in changes.items():
        features[key]["properties"] |= properties
    listed = [
        {"type": "Feature", "properties": each.pop("properties"), "geometry": each}
        for key, each in features.items()
        if changes.get(key) != {"id": None}
    ]
    return json.dumps({"type": "FeatureCollection", "features": listed})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"edge": {"id": None}}, "no edge"),
        ({"edge": {"id": 1}}, "id 1 occurs 2 times"),
        ({"edge": {"startid": 9}}, "end 9, which is no node"),
        ({"node": {"id": -1}}, "greater than or equal to 0"),
        ({"node": {"id": "0"}}, "valid integer"),
        ({"node": {"metadata": {"name": None}}}, "null is no value"),
        ({"edge": {"metadata": {"inner": {"region": [[0, 1]]}}}}, "lists or objects in it"),
        ({"edge": {"cost": -2}}, "cost"),
        ({"node": {"frame": "odom"}}, "frames 'map', 'odom'"),
    ],
)
def test_the_reader_and_the_rules_refuse_the_same(tmp_path, changes, words):
    file = tmp_path / "route.geojson"
    file.write_text(make_graph(), encoding="utf-8")
    assert find_broken_rules(file.read_text(encoding="utf-8")) == []
    assert len(pianta.read_route_graph(file)) == 2
    file.write_text(make_graph(**changes), encoding="utf-8")
    assert find_broken_rules(file.read_text(encoding="utf-8"))
    with pytest.raises(FloorError, match=words):
        pianta.read_route_graph(file)


def test_cells_that_a_line_crosses():
    """From the middle of [0, 0] to that of [1, 2]: half a cell, then pieces of a slope of 1 : 2."""
    cells, lengths = cross_cells(np.array([0.5, 0.5]), np.array([1.5, 2.5]))
    assert cells.tolist() == [[0, 0], [0, 1], [1, 1], [1, 2]]
    assert lengths.tolist() == pytest.approx([5**0.5 / 4] * 4)


def test_the_lattice_of_four_cells():
    """One is closed: a step along the row and one along the column, none past the corner."""
    is_open = np.array([[True, True], [True, False]])
    grid = pianta.GridMap(np.where(is_open, 0, 100).astype(np.int8), 0.5)
    space = FreeSpace(grid, 0.0, is_open, np.where(is_open, 9.0, 0.0), is_open.astype(np.int32))
    lattice = build_lattice(space, is_open, (0, 0), 1)
    assert lattice.points.tolist() == [[0, 0], [0, 1], [1, 0]]
    assert lattice.costs.toarray().tolist() == [[0, 0.5, 0.5], [0.5, 0, 0], [0.5, 0, 0]]


def test_the_room_at_a_position():
    assert FLOOR.room_at(1, 1) == ROOMS[0]
    assert FLOOR.room_at(8.1, 3) == ROOMS[1]
    assert FLOOR.room_at(4.05, 1.5) is None
    with_hole = pianta.Floor((pianta.Room(1, box(0, 0, 3, 3) - Point(1.5, 1.5).buffer(0.5)),))
    assert with_hole.room_at(1.5, 1.5) is None
