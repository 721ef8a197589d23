"""Graphs of interpretations: the figure of the thesis, and invariance to identifiers, order and repetition."""

import re

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import ModelError, OptionError, RelationError
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.relational.fact_files import read_interpretations
from pianta.relational.facts import (
    FLOOR_SIGNATURES,
    LISTING_SIGNATURES,
    SELF,
    Argument,
    Fact,
    Interpretation,
    Signature,
)
from pianta.relational.graphicalization import Graphicalizer
from tests.test_relations import interpret

FLOOR01 = interpret(
    ("buildingtype", "school"),
    ("space", "s001"),
    ("label", "s001", "classroom"),
    ("space", "s002"),
    ("label", "s002", "corridor"),
    ("space", "s003"),
    ("label", "s003", "classroom"),
    ("connected", "s001", "s002"),
    ("connected", "s002", "s003"),
    ("area", "s001", 100),
    ("perimeter", "s001", 40),
    name="floor01",
)
KERNEL = NeighborhoodPairs(label="label", edge_label="role")


def draw(*interpretations, **options) -> list[nx.Graph]:
    return Graphicalizer(**options).fit_transform(interpretations)


def labels_of(graph: nx.Graph) -> dict[object, str]:
    return dict(graph.nodes(data="label"))


def test_the_listing_becomes_the_graph_of_the_figure():
    (graph,) = draw(FLOOR01, signatures=LISTING_SIGNATURES)
    assert labels_of(graph) == {
        "s001": "space",
        "s002": "space",
        "s003": "space",
        ("buildingtype", "school"): "buildingtype(school)",
        ("label", "s001", "classroom"): "label(classroom)",
        ("label", "s002", "corridor"): "label(corridor)",
        ("label", "s003", "classroom"): "label(classroom)",
        ("connected", "s001", "s002"): "connected",
        ("connected", "s002", "s003"): "connected",
        ("area", "s001", 100): "area(0)",
        ("perimeter", "s001", 40): "perimeter(0)",
    }
    roles = {(relation, entity): role for relation, entity, role in graph.edges(data="role")}
    roles |= {(entity, relation): role for relation, entity, role in graph.edges(data="role")}
    assert graph.number_of_edges() == 3 + 2 * 2 + 2
    assert set(roles.values()) == {0}
    assert set(graph["connected", "s001", "s002"]) == {"s001", "s002"}
    assert graph.degree[("buildingtype", "school")] == 0
    assert graph.graph == {"name": "floor01"}
    assert nx.is_bipartite(graph)


def test_values_may_be_nodes_that_join_the_facts_that_share_them():
    (graph,) = draw(FLOOR01, signatures=LISTING_SIGNATURES, share_values=True)
    labels = labels_of(graph)
    assert labels[("label", "s001", "classroom")] == "label"
    (classroom,) = (node for node, label in labels.items() if label == "label.label=classroom")
    assert set(graph[classroom]) == {("label", "s001", "classroom"), ("label", "s003", "classroom")}
    assert nx.shortest_path_length(graph, "s001", "s003") == 4
    (area,) = (node for node, label in labels.items() if label == "area.area=0")
    assert graph.edges[area, ("area", "s001", 100)]["role"] == 1
    alone = [("buildingtype", "school")]
    assert [labels[node] for node in graph[alone[0]]] == ["buildingtype.buildingtype=school"]


def test_hidden_relations_leave_no_trace():
    (graph,) = draw(FLOOR01, signatures=LISTING_SIGNATURES, hidden=("label", "buildingtype"))
    (same,) = draw(FLOOR01.without("label", "buildingtype"), signatures=LISTING_SIGNATURES)
    assert nx.utils.graphs_equal(graph, same)
    assert len(graph) == 7
    assert len(draw(FLOOR01, signatures=LISTING_SIGNATURES, hidden="label")[0]) == 8


def test_numbers_become_bins_of_the_training_set():
    train = interpret(*[("room", f"r{n}") for n in range(8)], *[("area", f"r{n}", 10 * n) for n in range(8)])
    graphicalizer = Graphicalizer(bins=4).fit([train])
    assert graphicalizer.edges_["area", 1] == pytest.approx([17.5, 35, 52.5])
    test = interpret(
        ("room", 1), ("area", 1, -5), ("area", 1, 17.5), ("area", 1, 17.6), ("area", 1, 36), ("area", 1, 1e9)
    )
    (graph,) = graphicalizer.transform([test])
    labels = [label for node, label in graph.nodes(data="label") if node != 1]
    assert labels == ["area(0)", "area(0)", "area(1)", "area(2)", "area(3)"]
    (train_graph,) = graphicalizer.transform([train])
    assert sorted(label for label in labels_of(train_graph).values() if label != "room") == [
        f"area({n})" for n in range(4) for _ in range(2)
    ]


def test_equal_numbers_are_in_one_bin_up_to_rounding():
    # Half of the rooms have no betweenness, so that several of the eight bounds are 0.
    rooms = [("room", f"r{n}") for n in range(8)]
    (graph,) = draw(interpret(*rooms, *[("betwenness", f"r{n}", max(0.0, n - 4.0)) for n in range(8)]))
    bins = [label for label in labels_of(graph).values() if label != "room"]
    assert bins[:5] == ["betwenness(0)"] * 5
    assert len(set(bins)) == 4
    for error in (1e-13, -1e-13):
        turned = interpret(*rooms, *[("area", f"r{n}", 12 + error * n) for n in range(8)])
        assert set(labels_of(draw(turned)[0]).values()) == {"room", "area(0)"}


def test_numbers_absent_from_the_training_set_have_one_bin():
    graphicalizer = Graphicalizer().fit([interpret(("room", "r1"), ("label", "r1", "hall"))])
    (graph,) = graphicalizer.transform([interpret(("room", 1), ("label", 1, 7), ("label", 1, "7"), ("label", 1, "0"))])
    assert sorted(labels_of(graph).values()) == ["label('0')", "label('7')", "label(0)", "room"]


def test_repeated_and_reversed_facts_are_one_atom():
    rooms = [("room", "r1"), ("room", "r2")]
    (once,) = draw(interpret(*rooms, ("connected", "r1", "r2"), ("area", "r1", 5)))
    (often,) = draw(
        interpret(("area", "r1", 5.0), ("connected", "r2", "r1"), *rooms, ("connected", "r1", "r2"), ("area", "r1", 5))
    )
    assert nx.utils.graphs_equal(once, often)


def test_ordered_relations_have_a_role_for_each_position():
    above = Signature("above", (Argument("upper", "room"), Argument("by"), Argument("lower", "room")))
    facts = [("room", "r1"), ("room", "r2"), ("above", "r1", "far", "r2"), ("above", "r2", "far", "r2")]
    (graph,) = draw(interpret(*facts), signatures=(*FLOOR_SIGNATURES, above))
    node = ("above", "r1", "far", "r2")
    assert labels_of(graph)[node] == "above(far)"
    assert {entity: graph.edges[node, entity]["role"] for entity in graph[node]} == {"r1": 0, "r2": 2}
    assert graph.edges[("above", "r2", "far", "r2"), "r2"]["role"] == (0, 2)


def test_entities_have_properties_and_name_others():
    atm = Signature("atm", (Argument("id", SELF), Argument("element"), Argument("next", "atm")))
    (graph,) = draw(interpret(("atm", 1, "c", 2), ("atm", 2, "o", 2)), signatures=[atm])
    assert labels_of(graph) == {1: "atm(c)", 2: "atm(o)"}
    assert list(graph.edges(data="role")) == [(1, 2, 2)]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"bins": 0}, "bins"),
        ({"hidden": ("label", "lable")}, "lable"),
        ({"hidden": "room"}, "hidden"),
    ],
)
def test_options_without_meaning_are_refused(options, message):
    with pytest.raises(OptionError, match=message):
        Graphicalizer(**options)


def test_facts_that_contradict_the_signatures_are_refused():
    wrong = interpret(("room", "r1"), ("area", "r1", float("nan")), ("area", "r2", 5), name="f")
    message = re.escape("area(r1,nan)")
    for use in (Graphicalizer().fit, Graphicalizer().fit([]).transform):
        with pytest.raises(RelationError, match=message + ".*; area.r2,5."):
            use([wrong])


def test_bins_must_be_learnt_first():
    with pytest.raises(ModelError, match="fit"):
        Graphicalizer().transform([FLOOR01])


@st.composite
def floors(draw) -> Interpretation:
    n = draw(st.integers(1, 6))
    rooms = st.sampled_from(range(n))
    more = st.one_of(
        st.tuples(st.just("area"), rooms, st.integers(0, 9)),
        st.tuples(st.just("label"), rooms, st.sampled_from("ab")),
        st.tuples(st.just("connected"), rooms, rooms),
        st.tuples(st.just("buildingtype"), st.sampled_from("ab")),
    )
    facts = [*(("room", room) for room in range(n)), *draw(st.lists(more, max_size=15))]
    return interpret(*facts)


@pytest.mark.slow
@given(floors(), st.randoms(use_true_random=False), st.booleans())
def test_names_and_order_do_not_change_the_graph(floor, random, share_values):
    names = [f"n{n}" for n in range(6)]
    random.shuffle(names)
    facts = [
        Fact(fact.relation, tuple(names[value] if isinstance(value, int) and index < 1 + (fact.relation == "connected")
                                  else value for index, value in enumerate(fact.arguments)))
        for fact in floor.facts
    ]  # fmt: skip
    random.shuffle(facts)
    graphs = draw(floor, Interpretation("other", tuple(facts)), share_values=share_values)
    first, second = graphs
    assert nx.is_isomorphic(
        first,
        second,
        node_match=lambda one, other: one["label"] == other["label"],
        edge_match=lambda one, other: one["role"] == other["role"],
    )
    assert KERNEL.fit(graphs).compare() == pytest.approx(np.ones((2, 2)))


@pytest.mark.slow
@given(floors(), st.booleans())
def test_graphs_are_bipartite_without_identifiers(floor, share_values):
    (graph,) = draw(floor, share_values=share_values)
    assert nx.is_bipartite(graph)
    pattern = r"room|connected|(area\(\d\)|label\([ab]\)|buildingtype\([ab]\))"
    if share_values:
        pattern = (
            r"room|connected|area|label|buildingtype|(area\.area=\d|(label\.label|buildingtype\.buildingtype)=[ab])"
        )
    assert all(re.fullmatch(pattern, label) for label in labels_of(graph).values())
    assert len(graph) == len({*graph.nodes}) >= 1
    assert all(role is not None for *_, role in graph.edges(data="role"))


@pytest.mark.slow
def test_real_floors_have_an_atom_for_each_fact(data):
    schools = read_interpretations(data / "klog" / "school_RC.pl")
    graphs = Graphicalizer(hidden="label").fit_transform(schools)
    assert [graph.graph["name"] for graph in graphs] == [school.name for school in schools]
    for school, graph in zip(schools, graphs, strict=True):
        rooms = len(school.facts_of("room"))
        doors = {frozenset(fact.arguments) for fact in school.facts_of("connected")}
        assert len(graph) == 11 * rooms + len(doors)
        assert graph.number_of_edges() == 10 * rooms + 2 * len(doors)
    areas = {label for graph in graphs for label in labels_of(graph).values() if label.startswith("area(")}
    assert areas == {f"area({n})" for n in range(8)}
    gram = KERNEL.fit(graphs).compare()
    assert gram.diagonal() == pytest.approx(np.ones(20))
    assert gram[~np.eye(20, dtype=bool)].max() < 0.99
