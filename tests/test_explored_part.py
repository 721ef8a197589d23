"""The explored part of a floor, and the exploration of a floor by corridors."""

import itertools
from collections.abc import Mapping

import networkx as nx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pianta.errors import GraphError, LabelError
from pianta.labels import OFFICE
from pianta.prediction.explored_part import explore_by_corridors, find_start, hide_rooms, read_explored_part
from tests.generated_types import SCHOOL, WINGS, join_wings


def make_graph(rooms: Mapping[str, Mapping[str, object]], *edges: tuple[str, str]) -> nx.Graph:
    graph = nx.Graph(source="made")
    graph.add_nodes_from((name, dict(attributes)) for name, attributes in rooms.items())
    graph.add_edges_from(edges)
    return graph


def name_rooms(graph: nx.Graph, nodes) -> set[object]:
    return {graph.nodes[node]["room"] for node in nodes}


# A corridor with a classroom, an elevator and an office; behind the office another corridor with a closet.
FLOOR = make_graph(
    {
        "hall": {"label": "CORRIDOR"},
        "class": {"label": "CLASSROOM"},
        "lift": {"label": "ELEVATOR"},
        "office": {"label": "SMALL ADMINISTRATIVE"},
        "back": {"label": "CORRIDOR"},
        "closet": {"label": "CLOSET"},
    },
    ("hall", "class"),
    ("hall", "lift"),
    ("hall", "office"),
    ("office", "back"),
    ("back", "closet"),
)
CORRIDORS = {"hall", "back"}


def test_rooms_doors_and_open_corridors():
    part = read_explored_part(
        make_graph(
            {
                "hall": {"label": "corridor", "area": 20.0},
                "class": {"label": "CLASSROOM", "area": -1},
                "side": {"label": "CORRIDOR", "partial": True},
                "?": {"label": None, "partial": True},
            },
            ("hall", "class"),
            ("hall", "side"),
            ("class", "?"),
        ),
        SCHOOL,
    )
    assert part.source == "made"
    rooms = dict(part.graph.nodes(data="room"))
    assert [*rooms.values()] == ["hall", "class", "side", "?"]
    assert dict(part.graph.nodes(data="label")) == {0: "CORRIDOR", 1: "CLASSROOM", 2: "CORRIDOR", 3: None}
    assert part.corridors == {0, 2}
    assert (part.open, part.closed) == ((2,), (0, 1))
    assert part.doors == {3: 1}
    assert set(part.known_graph.edges) == {(0, 1), (0, 2)}
    assert part.open_ends == 2
    assert part.graph.nodes[0]["area"] == 20
    assert "area" not in part.graph.nodes[1]


def test_parallel_doors_lead_to_rooms_of_their_own():
    part = read_explored_part(
        make_graph(
            {"hall": {"label": "CORRIDOR"}, "class": {"label": "CLASSROOM"}, "?": {"label": None, "partial": True}},
            ("hall", "class"),
            ("hall", "?"),
            ("class", "?"),
        ),
        SCHOOL,
    )
    assert part.doors == {2: 0, 3: 1}
    assert name_rooms(part.graph, part.doors) == {"?"}
    assert all(part.graph.degree(door) == 1 for door in part.doors)


@pytest.mark.parametrize(
    ("messages", "is_unknown"),
    [
        ({"area": 4.9, "predicted_area": 10.0}, True),
        ({"area": 5.0, "predicted_area": 10.0}, False),
        ({"label_probabilities": {"R/C": {"ROOM": 1.0}, "type": {"CLASSROOM": 0.39, "LAB": 0.3}}}, True),
        ({"label_probabilities": {"type": {"CLASSROOM": 0.41, "LAB": 0.3}}}, False),
        ({"label_probabilities": {"R/C": {"ROOM": 1.0}}}, False),
        # The label of a room that was explored to a half counts, however uncertain.
        ({"area": 5.0, "predicted_area": 10.0, "label_probabilities": {"type": {"CLASSROOM": 0.1}}}, False),
        # GraphML has label sets as a text.
        ({"label_probabilities": '{"type": {"CLASSROOM": 0.39}}'}, True),
        ({"label_probabilities": '{"type": {"CLASSROOM": 0.41}}'}, False),
        ({"label_probabilities": "no JSON"}, False),
        ({}, False),
        ({"label": None}, True),
    ],
)
def test_a_reading_with_partial_rooms(messages, is_unknown):
    rooms: dict[str, dict[str, object]] = {
        "hall": {"label": "CORRIDOR"},
        "class": {"label": "CLASSROOM", "partial": True} | messages,
    }
    part = read_explored_part(make_graph(rooms, ("hall", "class")), SCHOOL)
    assert part.doors == ({1: 0} if is_unknown else {})
    assert part.open == ()
    # Probabilities of a room that is not partial are not used.
    rooms["class"]["partial"] = False
    if rooms["class"]["label"]:
        assert read_explored_part(make_graph(rooms, ("hall", "class")), SCHOOL).doors == {}


def test_a_glimpsed_corridor_is_open():
    rooms: dict[str, dict[str, object]] = {
        "hall": {"label": "CORRIDOR"},
        "side": {"label": "CORRIDOR", "partial": True, "area": 1.0, "predicted_area": 9.0},
    }
    assert read_explored_part(make_graph(rooms, ("hall", "side")), SCHOOL).open == (1,)


@pytest.mark.parametrize(
    ("messages", "is_unknown"),
    [
        # Through their doors rooms look like entrances; labels of corridors count together.
        ({"ENTRANCE": 0.4, "CORRIDOR": 0.09, "CLASSROOM": 0.51}, True),
        ({"ENTRANCE": 0.4, "CORRIDOR": 0.1, "CLASSROOM": 0.5}, False),
        ({"ENTRANCE": 0.4, "HALL": "much", "LOBBY": True, "CORRIDOR": float("nan")}, True),
        # Without a probability of the label itself, it counts.
        ({"CLASSROOM": 0.9}, False),
    ],
)
def test_doubtful_corridors_are_rooms(messages, is_unknown):
    rooms: dict[str, dict[str, object]] = {
        "hall": {"label": "CORRIDOR"},
        "side": {
            "label": "ENTRANCE",
            "partial": True,
            "area": 4.9,
            "predicted_area": 10.0,
            "label_probabilities": {"R/C": {"ROOM": 0.9, "CORRIDOR": 0.1}, "school": messages},
        },
    }
    graph = make_graph(rooms, ("hall", "side"))
    part = read_explored_part(graph, SCHOOL)
    assert (part.open, part.doors) == ((), {1: 0}) if is_unknown else ((1,), {})
    # Of a room of which half was seen, the label counts, but it is no corridor.
    graph.nodes["side"]["area"] = 5.0
    part = read_explored_part(graph, SCHOOL)
    assert part.doors == {}
    assert part.open == (() if is_unknown else (1,))
    assert part.corridors == ({0} if is_unknown else {0, 1})


def test_openspaces_of_offices_stay_corridors():
    rooms: dict[str, dict[str, object]] = {
        "hall": {"label": "CORRIDOR"},
        "space": {
            "label": "OPENSPACE",
            "partial": True,
            "label_probabilities": {"R/C": {"ROOM": 0.98, "CORRIDOR": 0.02}, "office": {"OPENSPACE": 0.9}},
        },
    }
    assert read_explored_part(make_graph(rooms, ("hall", "space")), OFFICE).open == (1,)


def test_huge_numbers_as_probabilities_are_left_out():
    rooms: dict[str, dict[str, object]] = {
        "hall": {"label": "CORRIDOR"},
        "class": {"label": "CLASSROOM", "partial": True, "label_probabilities": {"type": {"CLASSROOM": 10**400}}},
    }
    assert read_explored_part(make_graph(rooms, ("hall", "class")), SCHOOL).doors == {}


@pytest.mark.parametrize(
    ("observed", "predicted", "is_open"),
    [
        (7.9, 10.0, True),
        (8.0, 10.0, False),
        # Nothing is predicted beyond the observed part, so how much is unseen is unknown.
        (10.0, 10.0, True),
        (10.0, None, True),
    ],
)
def test_corridors_of_which_most_was_seen_are_complete(observed, predicted, is_open):
    rooms: dict[str, dict[str, object]] = {
        "hall": {"label": "CORRIDOR"},
        "side": {"label": "CORRIDOR", "partial": True, "area": observed, "predicted_area": predicted},
    }
    part = read_explored_part(make_graph(rooms, ("hall", "side")), SCHOOL)
    assert part.open == ((1,) if is_open else ())
    assert part.corridors == {0, 1}


def test_rooms_without_doors_and_loops_are_left_out():
    rooms = {"alone": {"label": "CLOSET"}, "hall": {"label": "CORRIDOR"}, "class": {"label": "CLASSROOM"}}
    part = read_explored_part(make_graph(rooms, ("hall", "class"), ("hall", "hall")), SCHOOL)
    assert name_rooms(part.graph, part.graph) == {"hall", "class"}
    assert [*part.graph.edges] == [(0, 1)]


def test_invalid_explored_parts_are_refused():
    with pytest.raises(LabelError, match="class"):
        read_explored_part(make_graph({"class": {"label": None}}), SCHOOL)
    with pytest.raises(LabelError, match="SPA"):
        read_explored_part(make_graph({"class": {"label": "SPA"}}), SCHOOL)
    with pytest.raises(LabelError, match="text"):
        read_explored_part(make_graph({"class": {"label": 3}}), SCHOOL)
    for graph in (nx.Graph(), make_graph({"?": {"label": None, "partial": True}})):
        with pytest.raises(GraphError, match="door"):
            read_explored_part(graph, SCHOOL)
    with pytest.raises(GraphError, match="1001"):
        read_explored_part(nx.star_graph(1000), SCHOOL)


def test_start():
    assert find_start(FLOOR, CORRIDORS) == "lift"
    stairs = FLOOR.copy()
    stairs.nodes["class"]["label"] = "STAIRS"
    assert find_start(stairs, CORRIDORS) == "lift"
    stairs.nodes["closet"]["label"] = "ENTRANCE"
    assert find_start(stairs, CORRIDORS) == "closet"
    plain = FLOOR.copy()
    plain.nodes["lift"]["label"] = "CLOSET"
    assert find_start(plain, CORRIDORS) == "hall"
    assert find_start(plain, set()) == "hall"


def test_exploration_by_corridors():
    """From the elevator to the first corridor; no other corridor is discovered there, so the office is opened next."""
    first, last = explore_by_corridors(FLOOR, CORRIDORS)
    assert {*first} == {"hall", "class", "lift", "office", "office-back"}
    at_hall = {frozenset(("hall", room)) for room in ("class", "lift", "office")}
    assert {frozenset(edge) for edge in first.edges} == at_hall | {frozenset(("office", "office-back"))}
    assert first.nodes["office-back"] == {"label": None, "partial": True}
    assert nx.utils.graphs_equal(nx.Graph(last.edges), nx.Graph(FLOOR.edges))
    assert not any(partial for _, partial in last.nodes(data="partial"))


def test_doors_of_corridors_are_seen_before_their_rooms():
    first, second, third, last = explore_by_corridors(FLOOR, CORRIDORS, corridors_first=True)
    assert {*first} == {"lift", "hall", "hall-class", "hall-office"}
    assert {*third} == {"hall", "class", "lift", "office", "back", "back-closet"}
    assert [second, last] == [
        stage if nx.utils.graphs_equal(stage, other) else None
        for stage, other in zip([second, last], explore_by_corridors(FLOOR, CORRIDORS), strict=True)
    ]


def test_the_nearest_discovered_corridor_is_next():
    """School d has four corridors in a ring: the first has the neighbours 1 and 3, and 2 is the nearest to 1."""
    graph = join_wings(*WINGS["d"], source="d")
    corridors = [node for node, label in graph.nodes(data="label") if label == "CORRIDOR"]
    stages = explore_by_corridors(graph, corridors)
    explored = [[node for node in corridors if node in stage and not stage.nodes[node]["partial"]] for stage in stages]
    first, second, third, fourth = corridors
    assert explored == [[first], [first, second], [first, second, third], corridors]
    assert [node for node in corridors if stages[0].nodes.get(node, {}).get("partial")] == [second, fourth]
    assert third not in stages[0]


def test_discovered_rooms_keep_their_label_and_hide_their_doors():
    part = hide_rooms(FLOOR, {"lift"}, {"hall"})
    assert {*part} == {"lift", "hall"}
    assert part.nodes["hall"] == {"label": "CORRIDOR", "partial": True}
    # Both rooms of a door are explored, but no door is seen from a room that is only discovered.
    assert {frozenset(edge) for edge in hide_rooms(FLOOR, {"class", "lift"}).edges} == {
        frozenset(("class", "class-hall")),
        frozenset(("lift", "lift-hall")),
    }


@st.composite
def partial_floors(draw) -> tuple[nx.Graph, set[int]]:
    graph = join_wings(*WINGS[draw(st.sampled_from([*WINGS]))], source="drawn")
    return graph, draw(st.sets(st.sampled_from([*graph]), min_size=1))


@settings(max_examples=60)
@given(partial_floors())
def test_every_door_of_an_explored_room_is_there_once(sampled):
    graph, explored = sampled
    part = read_explored_part(hide_rooms(graph, explored), SCHOOL)
    node_of = {room: node for node, room in part.graph.nodes(data="room")}
    for room in explored:
        assert part.graph.degree(node_of[room]) == graph.degree(room)
    assert name_rooms(part.graph, part.closed) == explored
    assert len(part.doors) == sum(near not in explored for room in explored for near in graph[room])


@settings(max_examples=40)
@given(st.sampled_from([*WINGS]), st.data())
def test_exploration_only_grows_and_ends_with_the_floor(name, data):
    graph = join_wings(*WINGS[name], source=name)
    start = data.draw(st.sampled_from([*graph]))
    graph.nodes[start]["label"] = "STAIRS" if graph.degree(start) == 1 else "CORRIDOR"
    corridors = {node for node, label in graph.nodes(data="label") if label == "CORRIDOR"}
    stages = explore_by_corridors(graph, corridors)
    assert len(stages) == len(corridors)
    known_part = [{node for node in stage if isinstance(node, int)} for stage in stages]
    assert all(before <= after for before, after in itertools.pairwise(known_part))
    assert known_part[-1] == {*graph}
    assert all(nx.is_connected(stage) for stage in stages)
