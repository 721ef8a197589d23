"""Models of building types: their content, invalid floors, and floors outside the training."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import GraphError, LabelError, ModelError
from pianta.generation.functional_areas import Segmentation
from pianta.generation.type_model import (
    MAX_ROOMS,
    TypeModel,
    area_subgraph,
    assign_area_clusters,
    count_labels,
    learn_type,
    prepare_room_graph,
)
from tests.generated_types import SCHOOL, build_floor, join_wings, make_schools, make_wing, small_model


def change_label(label: object, *, source: str = "") -> nx.Graph:
    """A wing with another label for its first room."""
    graph = make_wing("CCT")
    graph.graph["source"] = source
    graph.nodes[1]["label"] = label
    return graph


def test_floors_in_areas_of_clusters():
    model = small_model()
    assert [floor.source for floor in model.floors] == [f"school {name}.xml" for name in "abcdefgh"]
    assert [len(floor.areas) for floor in model.floors] == [2, 3, 3, 4, 2, 3, 3, 2]
    # A wing is an area.
    assert model.floors[1].areas == (frozenset(range(5)), frozenset(range(5, 10)), frozenset(range(10, 14)))
    assert model.floors[3].cuts == {(0, 1): [(0, 6)], (0, 3): [(0, 16)], (1, 2): [(6, 12)], (2, 3): [(12, 16)]}
    assert nx.is_isomorphic(model.floors[3].functional_graph, nx.cycle_graph(4))
    assert len(model.areas) == len(model.clusters) == 22
    assert model.configurations.sum() == 22
    assert (model.configurations.sum(axis=1) == [2, 3, 3, 4, 2, 3, 3, 2]).all()
    assert model.door_counts == [1] * sum(len(floor.cuts) for floor in model.floors)
    assert str(model) == f"8 floors, 22 functional areas by corr, {model.clusters.max() + 1} clusters"


def test_configurations_by_hand():
    floors = (build_floor(("C", "C", "A"), ((0, 1), (1, 2)), (0, 0, 2)), build_floor(("A", "G"), ((0, 1),), (2, 1)))
    model = TypeModel(SCHOOL, Segmentation.CORR, floors)
    assert model.clusters.tolist() == [0, 0, 2, 2, 1]
    assert model.configurations.tolist() == [[2, 0, 1], [0, 1, 1]]
    assert model.floors[0].functional_graph.nodes(data="label")[2] == "2"
    counts = dict(zip(SCHOOL.by_name, count_labels(model.areas, SCHOOL).T.tolist(), strict=True))
    assert counts["CORRIDOR"] == [1, 1, 1, 1, 1]
    assert counts["CLASSROOM"] == [1, 1, 0, 0, 0]
    assert counts["GYM"] == [0, 0, 0, 0, 1]
    assert sum(map(sum, counts.values())) == 10


def test_doors_between_the_same_areas_are_counted():
    floor = build_floor(("CC", "AA"), ((0, 1),), (0, 1))
    floor.graph.add_edge(1, 4)
    floor.graph.add_edge(2, 5)
    model = TypeModel(SCHOOL, Segmentation.CORR, (floor, build_floor(("C", "A"), ((0, 1),), (0, 1))))
    assert model.door_counts == [1, 3]


def test_floors_without_cuts_have_one_door_for_each_edge():
    floors = (build_floor(("C",), (), (0,)), build_floor(("A",), (), (0,)))
    assert TypeModel(SCHOOL, Segmentation.CORR, floors).door_counts == [1]


@pytest.mark.slow
@pytest.mark.parametrize("segmentation", Segmentation)
def test_nodes_may_be_anything(segmentation):
    names = [
        lambda node: f"room {node}",
        lambda node: (node, "x"),
        lambda node: frozenset({node}),
        lambda node: node - 7,
        lambda node: node if node % 2 else f"{node}",
    ]
    expected_model = learn_type(make_schools(), SCHOOL, segmentation=segmentation)
    for name in names:
        graphs = [nx.relabel_nodes(graph, name) for graph in make_schools()]
        model = learn_type(graphs, SCHOOL, segmentation=segmentation)
        assert [floor.areas for floor in model.floors] == [floor.areas for floor in expected_model.floors]
        assert model.clusters.tolist() == expected_model.clusters.tolist()
        rooms = [room for _, room in model.floors[2].graph.nodes(data="room")]
        assert rooms == list(graphs[2])


def test_given_graphs_stay_as_they_are():
    graphs = make_schools()
    learn_type(graphs, SCHOOL)
    assert all(nx.utils.graphs_equal(one, other) for one, other in zip(graphs, make_schools(), strict=True))


def test_labels_in_any_case_and_rooms_without_doors():
    graph = make_wing("CCT")
    graph.nodes[1]["label"] = "  ClassRoom\n"
    graph.add_node(99, label="no label of schools")
    graph.add_node(98)
    prepared = prepare_room_graph(graph, SCHOOL)
    assert [*prepared.nodes(data="label")] == [(0, "CORRIDOR"), (1, "CLASSROOM"), (2, "CLASSROOM"), (3, "BATHROOM")]


@pytest.mark.parametrize(
    ("label", "message"),
    [
        (None, "label"),
        (5, "text"),
        (("GYM",), "text"),
        ("", "''"),
        ("POOL", "POOL"),
        ("GYM\x00", r"GYM\\x00"),
    ],
)
def test_invalid_labels_are_refused(label, message):
    with pytest.raises(LabelError, match=message) as caught:
        prepare_room_graph(change_label(label), SCHOOL)
    assert "\n" not in str(caught.value)


LOOP, CUT, LARGE = make_wing("CC"), make_wing("CC"), make_wing("C" * MAX_ROOMS)
LOOP.add_edge(1, 1)
CUT.add_edge("far", "away")
nx.set_node_attributes(CUT, {"far": "GYM", "away": "GYM"}, "label")


@pytest.mark.parametrize(
    ("graph", "message"),
    [
        (nx.Graph(), "door"),
        (nx.empty_graph(3), "door"),
        (CUT, "parts"),
        (LARGE, "1001"),
        (LOOP, "doors"),
        (nx.DiGraph(make_wing("C")), "DiGraph"),
        (nx.MultiGraph(make_wing("C")), "MultiGraph"),
    ],
)
def test_invalid_floors_are_refused(graph, message):
    with pytest.raises(GraphError, match=rf"^[^\n]*{message}[^\n]*$"):
        prepare_room_graph(graph, SCHOOL)
    with pytest.raises(ModelError, match=rf"^floor 2: [^\n]*{message}[^\n]*$"):
        learn_type([make_wing("C"), graph, make_wing("A")], SCHOOL)


def test_all_faults_are_in_one_line():
    named = change_label(None, source="lab.xml")
    with pytest.raises(ModelError) as caught:
        learn_type([CUT, make_wing("C"), named, LOOP, change_label("POOL")], SCHOOL)
    message = str(caught.value)
    assert "\n" not in message
    for part in ("floor 1", "lab.xml", "floor 4", "floor 5"):
        assert part in message
    assert message.count("floor ") == 4


@pytest.mark.parametrize("graphs", [[], [make_wing("CCT")]])
def test_one_floor_is_no_type(graphs):
    number = ["0 floors", "1 floor"][len(graphs)]
    with pytest.raises(ModelError, match=number):
        learn_type(graphs, SCHOOL)


def test_areas_that_a_model_knows_are_recognized():
    for floor, graph in zip(small_model().floors, make_schools(), strict=True):
        result = assign_area_clusters(graph, small_model())
        assert result.source == floor.source
        assert result.areas == floor.areas
        assert result.clusters == floor.clusters
        assert nx.utils.graphs_equal(result.graph, floor.graph)
    assert len(set(assign_area_clusters(join_wings(("CCCC", "AA"), ((0, 1),), source=""), small_model()).clusters)) == 2


def test_names_of_recognized_rooms():
    graph = nx.relabel_nodes(join_wings(("CCC", "AAS"), ((0, 1),), source="x"), lambda node: f"r{node}")
    floor = assign_area_clusters(graph, small_model())
    assert [room for _, room in floor.graph.nodes(data="room")] == list(graph)
    assert [room for area in floor.area_graphs for _, room in area.nodes(data="room")] == list(graph)


@pytest.mark.parametrize("graph", [nx.Graph(), CUT, LOOP])
def test_floors_that_cannot_be_recognized(graph):
    with pytest.raises(GraphError):
        assign_area_clusters(graph, small_model())
    with pytest.raises(LabelError):
        assign_area_clusters(change_label("POOL"), small_model())


@pytest.mark.slow
@given(st.sets(st.integers(0, 13), min_size=1))
def test_areas_are_used_unchanged(area):
    graph = make_schools()[1]
    part = area_subgraph(graph, frozenset(area))
    assert list(part) == [node for node in graph if node in area]
    assert {frozenset(edge) for edge in part.edges} == {frozenset(edge) for edge in graph.subgraph(area).edges}
    assert dict(part.nodes(data="label")) == dict(graph.subgraph(area).nodes(data="label"))


def test_labels_of_no_graphs_are_counted():
    assert count_labels([], SCHOOL).shape == (0, len(SCHOOL.labels))
    assert count_labels([nx.Graph()], SCHOOL).tolist() == [[0] * len(SCHOOL.labels)]
    assert count_labels([make_wing("CC")], SCHOOL).dtype == np.int64
