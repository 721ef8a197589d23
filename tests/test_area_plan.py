"""Known areas of a floor that is explored in part, and sampled ones beside them."""

import networkx as nx
import numpy as np
import pytest

from pianta.prediction.area_plan import AreaPlan, NewArea, plan_areas, segment_known_rooms
from pianta.prediction.explored_part import ExploredPart, hide_rooms, read_explored_part
from tests.generated_types import LABELS, SCHOOL, WINGS, join_wings, make_wing

WING = NewArea(make_wing("GST"), 0, "5")


def explore(name: str, explored: set[int], discovered: set[int] | None = None) -> ExploredPart:
    """School a has the corridors 0 and 6; b 0, 5 and 10."""
    return read_explored_part(hide_rooms(join_wings(*WINGS[name], source=name), explored, discovered or set()), SCHOOL)


def make_branch(*labels: str) -> nx.Graph:
    branch = nx.path_graph(len(labels))
    nx.set_node_attributes(branch, {node: LABELS[label] for node, label in enumerate(labels)}, "label")
    return branch


def plan(explored: ExploredPart, chosen=(), branches=None, seed=0) -> AreaPlan:
    known_areas = segment_known_rooms(explored)
    return plan_areas(
        explored,
        known_areas,
        ["1"] * len(known_areas),
        chosen=chosen,
        branches=branches or {},
        generator=np.random.default_rng(seed),
    )


def test_open_corridors_are_in_no_known_area():
    explored = explore("b", {0, 1, 2, 3, 4}, {5})
    assert explored.open == (5,)
    assert segment_known_rooms(explored) == [frozenset({0, 1, 2, 3, 4})]
    assert segment_known_rooms(read_explored_part(hide_rooms(make_wing("CC"), set(), {0}), SCHOOL)) == []


def test_parts_that_no_known_door_joins_have_areas_of_their_own():
    explored = explore("b", {0, 1, 10, 11})
    areas = segment_known_rooms(explored)
    rooms = dict(explored.graph.nodes(data="room"))
    assert [{rooms[node] for node in area} for area in areas] == [{0, 1}, {10, 11}]


def test_an_open_corridor_takes_the_place_of_that_of_an_area():
    explored = explore("a", {0, 1, 2, 3, 4, 5}, {6})
    planned = plan(explored, [WING])
    assert (planned.n_known, planned.clusters) == (1, ["1", "5"])
    new = planned.areas[1]
    assert sorted(label for _, label in new.nodes(data="label")) == ["BATHROOM", "CLOSET", "CORRIDOR", "GYM"]
    assert {*new} == {6, (0, 1), (0, 2), (0, 3)}
    # The area of the model is not changed.
    assert [*WING.graph] == [0, 1, 2, 3]
    assert "room" not in WING.graph.nodes[0]


def test_areas_go_to_corridors_with_their_label():
    explored = explore("b", {0, 1, 2, 3, 4}, {5})
    explored.graph.nodes[5]["label"] = "HALL"
    hall = NewArea(make_wing("G", hub="HALL"), 0, "7")
    first, second = plan(explored, [WING, hall]).areas[1:]
    assert (5 in first, 5 in second) == (False, True)
    assert plan(explored, [WING]).areas[1].nodes[5]["label"] == "HALL"


def test_open_corridors_without_an_area_are_alone():
    planned = plan(explore("a", {0, 1, 2, 3, 4, 5}, {6}))
    assert [*planned.areas[1]] == [6]
    assert planned.clusters == ["1", ""]


def test_known_rooms_at_an_open_corridor_are_not_sampled_again():
    """A bathroom at corridor 6 is known, so that of the area goes; a classroom there is not, and changes nothing."""
    graph = join_wings(*WINGS["a"], source="a")
    for label, rooms in (("BATHROOM", 2), ("CLASSROOM", 3)):
        graph.nodes[7]["label"] = label
        explored = read_explored_part(hide_rooms(graph, {0, 1, 2, 3, 4, 5, 7}, {6}), SCHOOL)
        (hub,) = explored.open
        (area,) = [area for area in plan(explored, [WING]).areas if hub in area]
        assert area.degree(hub) == rooms


def test_doors_of_an_open_corridor_lead_to_rooms_of_its_area():
    graph = nx.star_graph(5)
    unknown = {node: {"label": None, "partial": True} for node in graph}
    nx.set_node_attributes(graph, unknown | {0: {"label": "CORRIDOR", "partial": True}})
    explored = read_explored_part(graph, SCHOOL)
    branches = dict.fromkeys(explored.doors, make_branch("A", "C"))
    (area,) = plan(explored, [WING], branches).areas
    assert {*explored.doors} <= {*area}
    labels = [area.nodes[door]["label"] for door in explored.doors]
    # Three rooms of the area, then branches for the other two, each with a room beyond.
    assert sorted(labels[:3]) == ["BATHROOM", "CLOSET", "GYM"]
    assert labels[3:] == [LABELS["A"]] * 2
    assert len(area) == 8
    assert nx.is_connected(area)


def test_branches_are_of_the_area_of_their_door():
    explored = explore("a", {0, 1, 2})
    near = {door: explored.graph.nodes[room]["room"] for door, room in explored.doors.items()}
    assert [*near.values()] == [0, 0, 0, 0]
    one, two, *others = explored.doors
    planned = plan(explored, [WING], {one: make_branch("A", "S"), two: None, **dict.fromkeys(others, nx.Graph())})
    (known_areas, _) = planned.areas
    assert planned.doors == {0: [two]}
    assert known_areas.nodes[one]["label"] == LABELS["A"]
    assert known_areas.nodes[0, one, 1]["label"] == LABELS["S"]
    assert known_areas.degree(one) == 2
    assert len(known_areas) == 5


def test_start_of_the_functional_graph():
    explored = explore("b", {0, 1, 2, 3, 4}, {5})
    for seed in range(10):
        graph = plan(explored, [WING] * 4).start(np.random.default_rng(seed))
        assert nx.is_connected(graph)
        assert graph.number_of_edges() == 4
        assert graph.edges[0, 1] == {"known": True, "cuts": 0}
        assert [*graph[0]] == [1]
        assert "known" not in graph.edges[next(edge for edge in graph.edges if edge != (0, 1))]


@pytest.mark.parametrize("explored", [{0, 1, 2, 5, 6, 10, 11}, {0, 5}, {10, 0}])
def test_parts_are_joined_by_what_is_unknown(explored):
    part = explore("b", explored)
    branches = dict.fromkeys(part.doors)
    for seed in range(10):
        graph = plan(part, [WING] * 3, branches).start(np.random.default_rng(seed))
        assert nx.is_connected(graph)


def test_only_open_corridors_are_known():
    part = read_explored_part(hide_rooms(make_wing("CC"), set(), {0}), SCHOOL)
    graph = plan(part, [WING] * 3).start(np.random.default_rng(0))
    assert nx.is_connected(graph)
    assert len(graph) == 3


def test_doors_lead_to_areas_that_are_joined():
    """Three doors of the known area, two areas beyond: each is reached by one at least, none by any other way."""
    part = explore("a", {0, 1, 2})
    branches = dict.fromkeys(part.doors, None) | {next(iter(part.doors)): nx.Graph()}
    for seed in range(10):
        generator = np.random.default_rng(seed)
        planned = plan(part, [WING] * 2, branches)
        functional = planned.start(generator)
        building, opened = planned.build(functional, [9], generator)
        joined = {edge: doors for edge, doors in opened.items() if edge[0] == 0}
        assert sorted(door for doors in joined.values() for door in doors) == [*part.doors][1:]
        assert {edge for edge in functional.edges if 0 in edge} == set(joined)
        hub = planned.number_rooms()[0]
        for edge, doors in joined.items():
            assert functional.edges[edge]["cuts"] == len(doors) >= 1
            assert building.known_ends[edge] == [hub] * len(doors)
        # Between new areas numbers of doors are drawn.
        assert {functional.edges[edge]["cuts"] for edge in functional.edges if 0 not in edge} <= {9}


def test_known_doors_are_in_the_building():
    part = explore("b", {0, 1, 2, 3, 4, 11}, {5, 10})
    planned = plan(part, [WING])
    generator = np.random.default_rng(0)
    building, _ = planned.build(planned.start(generator), [1], generator)
    positions = planned.number_rooms()
    doors = {frozenset(door) for door in building.list_doors()}
    assert {frozenset((positions[one], positions[other])) for one, other in part.known_graph.edges} <= doors
