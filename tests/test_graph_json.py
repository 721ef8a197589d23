"""Topological graphs survive their JSON, and nothing else passes for one."""

import json
from contextlib import suppress

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, box

from pianta.errors import FloorError
from pianta.floor import Door, Floor, Room
from pianta.io.graphs import read_graph, save_graph
from tests.mutation import mutated

ENTRANCE = Door((2, None), LineString([(10, 1), (10, 2)]), 1.0)
FLOOR = Floor(
    (
        Room(3, box(0, 0, 4, 3), "OFFICE", {"R/C": "ROOM"}, {"office": {"OFFICE": 0.6, "CUBICULE": 0.4}}),
        Room(1, box(4, 0, 9, 3)),
        Room(2, box(9, 0, 10, 3)),
    ),
    (Door((1, 3), LineString([(4, 0.1), (4, 1)]), 0.9), Door((1, 2), LineString([(9, 0), (9, 1)]), 1.0), ENTRANCE),
    source="Büro",
)

attributes = st.dictionaries(
    st.text(max_size=5).filter(lambda name: name not in ("id", "source", "target")),
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=5),
    max_size=3,
)


@st.composite
def graphs(draw) -> nx.Graph:
    graph = nx.Graph(**draw(attributes))
    nodes = draw(st.lists(st.integers(1, 99) | st.text(max_size=3), unique=True, max_size=5))
    graph.add_nodes_from((node, draw(attributes)) for node in nodes)
    if nodes:
        ends = st.tuples(st.sampled_from(nodes), st.sampled_from(nodes))
        graph.add_edges_from((*draw(ends), draw(attributes)) for _ in range(draw(st.integers(0, 5))))
    return graph


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("graphs") / "graph.json"


def write(path, **changes) -> None:
    parts = {"directed": False, "multigraph": False, "graph": {}, "nodes": [{"id": 1}], "edges": []}
    path.write_text(json.dumps(parts | changes))


def test_floor_graph_survives(path):
    save_graph(FLOOR.graph(), path)
    graph = read_graph(path)
    assert list(graph) == [3, 1, 2]
    assert nx.utils.graphs_equal(graph, FLOOR.graph())
    assert graph.graph == {"source": "Büro"}
    assert graph.nodes[3]["labels"] == {"R/C": "ROOM"}
    assert graph.nodes[3]["label_probabilities"] == {"office": {"OFFICE": 0.6, "CUBICULE": 0.4}}
    assert dict(graph.nodes(data="entrances")) == {3: 0, 1: 0, 2: 1}
    assert {frozenset(edge) for edge in graph.edges} == {frozenset((1, 3)), frozenset((1, 2))}


@pytest.mark.slow
@given(graph=graphs())
def test_round_trip_is_exact_and_stable(path, graph):
    save_graph(graph, path)
    content = path.read_bytes()
    assert nx.utils.graphs_equal(read_graph(path), graph)
    save_graph(read_graph(path), path)
    assert path.read_bytes() == content


def test_networkx_reads_it(path):
    save_graph(FLOOR.graph(), path)
    parts = json.loads(path.read_text())
    assert nx.utils.graphs_equal(nx.node_link_graph(parts, edges="edges"), FLOOR.graph())


@pytest.mark.parametrize("value", [float("nan"), float("inf"), (1, 2), object(), {1: 2}])
def test_attributes_that_json_does_not_have_are_refused(path, value):
    path.write_text("old")
    with pytest.raises(FloorError, match="graph"):
        save_graph(nx.Graph(value=value), path)
    assert path.read_text() == "old"


@pytest.mark.parametrize("graph_class", [nx.DiGraph, nx.MultiGraph])
def test_other_graphs_are_refused(path, graph_class):
    with pytest.raises(FloorError, match=r"directed|multigraph"):
        save_graph(graph_class([(1, 2)]), path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"nodes": [{"id": 1}, {"id": 1}], "edges": [{"source": 1, "target": 7}]},
            "node 1.*node 7",
        ),
        (
            {"nodes": [{"id": 1.5}, {}], "directed": True},
            r"directed.*nodes\[0\]\.id.*nodes\[1\]\.id",
        ),
        ({"nodes": [{"id": 1, "x": float("nan")}]}, r"nodes\[0\].x"),
        ({"graph": {"a b": [float("inf")]}}, r"graph\['a b'\]"),
        ({"edges": [{"source": 1}]}, r"edges\[0\].target"),
        ({"graph": []}, "graph"),
    ],
)
def test_faults_are_listed_together(path, changes, message):
    write(path, **changes)
    with pytest.raises(FloorError, match=message):
        read_graph(path)


@pytest.mark.parametrize(
    "text", ["[" * 100_000, '{"nodes": ' + "9" * 10_000 + "}", "\ufeff", "null", "\x00", '"\\ud800"']
)
def test_hostile_json_is_refused(path, text):
    path.write_text(text)
    with pytest.raises(FloorError, match="graph"):
        read_graph(path)


@pytest.fixture(scope="module")
def valid(path):
    save_graph(FLOOR.graph(), path)
    return path.read_bytes()


@given(fuzz=st.data())
def test_damaged_file_is_read_or_refused(path, valid, fuzz):
    path.write_bytes(fuzz.draw(st.binary() | mutated(valid)))
    with suppress(FloorError):
        assert isinstance(read_graph(path), nx.Graph)
