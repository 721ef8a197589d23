"""Round trips of GraphML are exact, networkx reads the same graphs, and other files are refused."""

import re

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, box

from pianta.errors import FloorError
from pianta.floor import Door, Floor, Room
from pianta.io import graphml
from pianta.io.graphml import read_graphml, save_graphml
from tests.mutation import mutated, refused_in_one_line

FLOOR = Floor(
    (
        Room(3, box(0, 0, 4, 3), "OFFICE", {"R/C": "ROOM"}, {"office": {"BÜRO": 0.6}}),
        Room(1, box(4, 0, 9, 3)),
    ),
    (Door((1, 3), LineString([(4, 0.1), (4, 1)]), 0.9, probability=0.75),),
    source="Büro",
)
TWO_ROOMS = """<?xml version='1.0' encoding='utf-8'?>
<graphml xmlns="http://graphml.graphdrawing.org/xmlns">
  <key id="graph0" for="graph" attr.name="source" attr.type="string" />
  <key id="node1" for="node" attr.name="label" attr.type="string" />
  <key id="node2" for="node" attr.name="area" attr.type="double" />
  <key id="node3" for="node" attr.name="partial" attr.type="boolean" />
  <key id="edge4" for="edge" attr.name="doors" attr.type="long" />
  <graph edgedefault="undirected">
    <data key="graph0">a &amp; b</data>
    <node id="1">
      <data key="node1">LAB</data>
      <data key="node2">12.5</data>
    </node>
    <node id="0">
      <data key="node3">true</data>
    </node>
    <edge source="1" target="0">
      <data key="edge4">2</data>
    </edge>
  </graph>
</graphml>
"""

# Characters that XML can hold.
texts = st.text(
    st.characters(exclude_categories=["Cs"]).filter(lambda c: c >= " " or c in "\t\n\r"), max_size=5
).filter(lambda text: not {"\ufffe", "\uffff"} & set(text))
finite = st.floats(allow_nan=False, allow_infinity=False)
attributes = st.dictionaries(texts, st.booleans() | st.integers(-(2**63) + 1, 2**63 - 1) | finite | texts, max_size=3)
integer_ids = st.lists(st.integers(-(10**18) + 1, 10**18 - 1), unique=True, max_size=5)
text_ids = st.lists(texts, unique=True, max_size=5).filter(lambda ids: not all(map(graphml._INTEGER_ID.fullmatch, ids)))


@st.composite
def graphs(draw, ids=integer_ids | text_ids) -> nx.Graph:
    graph = nx.Graph()
    graph.graph.update(draw(attributes))
    nodes = draw(ids)
    graph.add_nodes_from(nodes)
    for node in nodes:
        graph.nodes[node].update(draw(attributes))
    if nodes:
        ends = st.tuples(st.sampled_from(nodes), st.sampled_from(nodes))
        for _ in range(draw(st.integers(0, 5))):
            pair = draw(ends)
            graph.add_edge(*pair)
            graph.edges[pair].update(draw(attributes))
    return graph


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("graphs") / "graph.graphml"


def two_rooms() -> nx.Graph:
    graph = nx.Graph(source="a & b")
    graph.add_node(1, label="LAB", area=12.5)
    graph.add_node(0, partial=True)
    graph.add_edge(1, 0, doors=2)
    return graph


def types_of(graph: nx.Graph) -> list[dict[str, type]]:
    parts = [graph.graph, *graph.nodes.values(), *graph.edges.values()]
    return [{name: type(value) for name, value in part.items()} for part in parts]


def test_the_file_by_hand(path):
    save_graphml(two_rooms(), path)
    assert path.read_text(encoding="utf-8") == TWO_ROOMS
    assert nx.utils.graphs_equal(read_graphml(path), two_rooms())
    assert list(read_graphml(path)) == [1, 0]


@pytest.mark.slow
@given(graph=graphs())
def test_round_trip_is_exact_and_stable(path, graph):
    save_graphml(graph, path)
    content = path.read_bytes()
    again = read_graphml(path)
    assert nx.utils.graphs_equal(again, graph)
    assert types_of(again) == types_of(graph)
    save_graphml(again, path)
    assert path.read_bytes() == content


@pytest.mark.slow
@given(graph=graphs(integer_ids))
def test_networkx_reads_the_same_graph(path, graph):
    save_graphml(graph, path)
    read_by_networkx = nx.read_graphml(path, node_type=int)
    del read_by_networkx.graph["node_default"], read_by_networkx.graph["edge_default"]
    assert nx.utils.graphs_equal(read_by_networkx, graph)


@pytest.mark.slow
@given(graph=graphs(integer_ids))
def test_a_file_of_networkx_is_read(path, graph):
    """Without carriage returns, which networkx writes so that they become line feeds."""
    for part in (graph.graph, *graph.nodes.values(), *graph.edges.values()):
        for name in [name for name, value in part.items() if "\r" in f"{name}{value}"]:
            del part[name]
    nx.write_graphml_xml(graph, path)
    assert nx.utils.graphs_equal(read_graphml(path), graph)


def test_the_graph_of_a_floor(path):
    """Dicts become JSON text, and None is left out."""
    save_graphml(FLOOR.graph(), path)
    graph = read_graphml(path)
    assert graph.graph == {"source": "Büro"}
    assert graph.nodes[3]["label"] == "OFFICE"
    assert graph.nodes[3]["label_probabilities"] == '{"office": {"BÜRO": 0.6}}'
    assert graph.nodes[1] == {
        "labels": "{}",
        "label_probabilities": "{}",
        "area": 15.0,
        "x": 6.5,
        "y": 1.5,
        "partial": False,
        "entrances": 0,
    }
    assert graph.edges[1, 3] == FLOOR.graph().edges[1, 3]


def test_numbers_of_numpy_are_numbers(path):
    graph = nx.Graph([(np.int64(0), np.int64(1))], a=np.float32(0.5), b=np.uint8(7), c=np.bool_(True), d=np.float64(2))
    save_graphml(graph, path)
    again = read_graphml(path)
    assert again.graph == {"a": 0.5, "b": 7, "c": True, "d": 2.0}
    assert types_of(again)[0] == {"a": float, "b": int, "c": bool, "d": float}
    assert list(again.edges) == [(0, 1)]


@pytest.mark.parametrize(
    ("ids", "read"),
    [
        (["1", "2"], [1, 2]),
        ([1, "a"], ["1", "a"]),
        (["01", "1"], ["01", "1"]),
        (["1" * 19, "1"], ["1" * 19, "1"]),
        (["²", "٣"], ["²", "٣"]),
    ],
)
def test_ids_are_integers_if_all_are_written_as_integers(path, ids, read):
    graph = nx.Graph()
    graph.add_nodes_from(ids)
    save_graphml(graph, path)
    assert list(read_graphml(path)) == read


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (float("nan"), "value"),
        (float("-inf"), "-inf"),
        ([float("nan")], "JSON"),
        ({"a": object()}, "object"),
        ((1, 2), "tuple"),
        (2**63, "64"),
        ("a\x00", r"\\x00"),
        ("\ud800", r"\\ud800"),
        ("\uffff", r"\\uffff"),
    ],
)
def test_attributes_that_graphml_does_not_have_are_refused(path, value, message):
    path.write_text("old")
    with pytest.raises(FloorError, match=message):
        save_graphml(nx.Graph(value=value), path)
    assert path.read_text() == "old"


def test_faults_of_a_graph_are_listed_together(path):
    graph = nx.Graph()
    graph.add_nodes_from([1, "1", (2, 3), False, "\x01"])
    graph.nodes["1"].update({4: "a", "\x02": "b"})
    with pytest.raises(FloorError) as error:
        save_graphml(graph, path)
    message_text = str(error.value)
    assert "'1'" in message_text
    assert "(2, 3)" in message_text
    assert "False" in message_text
    assert "\\x01" in message_text
    assert "attribute 4" in message_text
    assert "\\x02" in message_text
    assert "\n" not in message_text


@pytest.mark.parametrize("graph_class", [nx.DiGraph, nx.MultiGraph])
def test_other_graphs_are_refused(path, graph_class):
    with pytest.raises(FloorError, match="directed"):
        save_graphml(graph_class([(1, 2)]), path)


def changed(old: str, new: str) -> str:
    assert old in TWO_ROOMS
    return TWO_ROOMS.replace(old, new)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"undirected"', '"directed"', "directed"),
        ('target="0"', 'target="0" directed="true"', "'1'"),
        ('<node id="0">', '<node id="1">', "'1'"),
        ('<node id="0">', "<node>", "node"),
        ('target="0"', 'target="7"', "'7'"),
        ("</edge>", '</edge><edge source="0" target="1"/>', "'1'"),
        ("12.5", "NaN", "area.*NaN"),
        ("12.5", "1e999", "1e999"),
        ("12.5", "", "area"),
        (">true<", ">maybe<", "maybe"),
        (">2<", ">2.5<", r"2\.5"),
        (">2<", f">{'2' * 5000}<", "long"),
        ('key="edge4"', 'key="edge5"', "edge5"),
        ('<key id="edge4"', '<key id="node1"', "node1"),
        ('"double"', '"complex"', "complex"),
        ('key="node2">12.5', 'key="node1">12.5', "label"),
        ('"long" />', '"long"><default>a</default></key>', "edge4"),
        ("</graphml>", '<graph edgedefault="undirected"/></graphml>', "graphs"),
        ("</node>", '<graph edgedefault="undirected"/></node>', "groups"),
        ("</edge>", "</edge><hyperedge/>", "edges"),
        ("graphml", "svg", "svg"),
        ("</graphml>", "", "XML"),
        ("utf-8", "klingon", "XML"),
    ],
)
def test_other_files_are_refused(path, old, new, message):
    path.write_text(changed(old, new))
    with pytest.raises(FloorError, match=message) as error:
        read_graphml(path)
    assert "\n" not in str(error.value)


def test_faults_of_a_file_are_listed_together(path):
    path.write_text(changed("12.5", "nan").replace('target="0"', 'target="7"'))
    with pytest.raises(FloorError, match=r"double.*'7'"):
        read_graphml(path)


BOMB = '<!DOCTYPE graphml [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
FILE_ENTITY = '<!DOCTYPE graphml [<!ENTITY a SYSTEM "file:///etc/passwd">]>'


@pytest.mark.parametrize("declaration", [BOMB, FILE_ENTITY, "<!DOCTYPE graphml>"])
def test_entities_are_refused(path, declaration):
    path.write_text(changed("?>", f"?>{declaration}").replace("LAB", "&a;"))
    with pytest.raises(FloorError, match=r"\bentities\b"):
        read_graphml(path)


def test_large_files_are_refused(path, monkeypatch):
    save_graphml(two_rooms(), path)
    monkeypatch.setattr(graphml, "MAX_FILE_BYTES", 100)
    with pytest.raises(FloorError, match="100"):
        read_graphml(path)
    with pytest.raises(FloorError, match="100"):
        save_graphml(two_rooms(), path)


def test_missing_and_empty_files_are_refused(tmp_path):
    (tmp_path / "empty.graphml").touch()
    with pytest.raises(FloorError, match=r"\bempty\b"):
        read_graphml(tmp_path / "empty.graphml")
    with pytest.raises(FloorError, match="exist"):
        read_graphml(tmp_path / "missing.graphml")


def test_defaults_fill_missing_attributes(path):
    path.write_text(changed('name="label" attr.type="string" />', 'name="label"><default>ROOM</default></key>'))
    assert dict(read_graphml(path).nodes(data="label")) == {1: "LAB", 0: "ROOM"}
    assert "label" not in read_graphml(path).graph
    assert "label" not in read_graphml(path).edges[0, 1]


def test_a_namespace_is_optional(path):
    path.write_text(
        changed(' xmlns="http://graphml.graphdrawing.org/xmlns"', "").replace(' edgedefault="undirected"', "")
    )
    assert nx.utils.graphs_equal(read_graphml(path), two_rooms())


def test_texts_drawn_in_yed_are_labels(path):
    """As yEd writes them, with its keys, ids and geometry; an attribute `label` has precedence."""
    drawing = (
        '<data key="d6"><y:ShapeNode><y:Geometry height="30" width="30" x="1" y="2"/>'
        '<y:NodeLabel fontSize="12">{}<y:LabelModel/></y:NodeLabel><y:Shape type="rectangle"/></y:ShapeNode></data>'
    )
    path.write_text(
        '<graphml xmlns="http://graphml.graphdrawing.org/xmlns" xmlns:y="http://www.yworks.com/xml/graphml">'
        '<key for="node" id="d4" attr.name="label" attr.type="string"/>'
        '<key for="port" id="d1" yfiles.type="portgraphics"/>'
        '<key for="node" id="d6" yfiles.type="nodegraphics"/><key for="edge" id="d10" yfiles.type="edgegraphics"/>'
        '<key for="graphml" id="d7" yfiles.type="resources"/><key for="node" id="d8" attr.name="NodeGraphics"/>'
        '<graph edgedefault="undirected" id="G">'
        f'<node id="n0">{drawing.format("Class room ")}</node>'
        f'<node id="n1"><data key="d4">HALL</data>{drawing.format("1")}</node>'
        f'<node id="n2"><data key="d8"> <y:Shape/> </data>{drawing.format(" ")}</node>'
        '<edge id="e0" source="n0" target="n1"><data key="d10"><y:PolyLineEdge/></data></edge>'
        '</graph><data key="d7"><y:Resources/></data></graphml>'
    )
    graph = read_graphml(path)
    assert dict(graph.nodes(data=True)) == {"n0": {"label": "Class room"}, "n1": {"label": "HALL"}, "n2": {}}
    assert list(graph.edges(data=True)) == [("n0", "n1", {})]


def test_keys_differ_from_those_of_yed(path):
    """Gephi takes the key d3 for the label of a node, whatever its name is."""
    save_graphml(nx.Graph([(1, 2, dict.fromkeys("abcdef", 1))], **dict.fromkeys("ghi", 1)), path)
    ids = re.findall(r'<key id="(\w+)"', path.read_text())
    assert len(set(ids)) == 9
    assert not any(key.startswith("d") for key in ids)


@given(fuzz=st.data())
def test_damaged_file_is_read_or_refused(path, fuzz):
    path.write_bytes(fuzz.draw(st.binary() | mutated(TWO_ROOMS.encode())))
    with refused_in_one_line():
        assert isinstance(read_graphml(path), nx.Graph)
