"""Room graphs from files of all formats, and the sampled graphs of the thesis."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, box

from pianta.errors import FloorError
from pianta.floor import Door, Floor, Room
from pianta.io import graphs as room_graphs
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.floors import save_floor
from pianta.io.graphml import save_graphml
from pianta.io.graphs import read_room_graph, read_room_graphs, save_graph
from tests.mutation import mutated, refused_in_one_line
from tests.test_building_xml import TWO_ROOMS
from tests.test_house_expo import house
from tests.test_kth_xml import TWO_ROOMS as TWO_ROOMS_OF_KTH

FLOOR = Floor(
    (Room(4, box(0, 0, 4, 3), "class  room"), Room(2, box(4, 0, 9, 3))),
    (Door((2, 4), LineString([(4, 0.1), (4, 1)]), 0.9),),
    building_type={"school": 1.0},
    source="map.yaml",
)
LABELS = {4: "CLASS ROOM", 2: None}


def sample(**changes) -> dict[str, Any]:
    graph = {
        "id": "grafogen_7",
        "nodes": [{"id": 0, "code": 3, "label": "Classroom"}, {"id": 1, "code": 10, "label": "MEDIUM  SERVICE"}],
        "edges": [[0, 1]],
    }
    return {"building_type": "SCHOOL", "source": "thesis", "graphs": [graph | changes]}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("graphs") / "a.json"


def write(path, content) -> None:
    path.write_text(json.dumps(content))


def test_a_sampled_graph(path):
    write(path, sample())
    (graph,) = read_room_graphs(path)
    assert graph.graph == {"source": "grafogen_7", "building_type": "school"}
    assert list(graph.nodes(data=True)) == [(0, {"label": "CLASSROOM"}), (1, {"label": "MEDIUM SERVICE"})]
    assert list(graph.edges(data=True)) == [(0, 1, {})]


def test_a_file_without_graphs_is_valid(path):
    write(path, sample() | {"graphs": []})
    assert read_room_graphs(path) == []


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"nodes": [{"id": 0, "label": "a"}] * 2, "edges": [[7, 0], [0, 0], [0, 7]]},
            "node 0.*node 7.*0 to 7.*edge 0",
        ),
        ({"nodes": [{"id": 0}], "edges": []}, r"graphs\[0\].nodes\[0\].label"),
        ({"nodes": [{"id": 0, "label": " "}], "edges": []}, r"nodes\[0\].label"),
        ({"nodes": [{"id": True, "label": "a"}], "edges": []}, r"nodes\[0\].id"),
        ({"nodes": [{"id": float("nan"), "label": "a"}]}, r"nodes\[0\].id"),
        ({"edges": [[0, 1, 1]]}, r"edges\[0\]"),
        ({"id": 7}, r"graphs\[0\].id"),
    ],
)
def test_other_sampled_graphs_are_refused(path, changes, message):
    write(path, sample(**changes))
    with pytest.raises(FloorError, match=message) as error:
        read_room_graphs(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"graphs": sample()["graphs"] * 2}, "grafogen_7"),
        ({"building_type": ""}, "building_type"),
        ({"building_type": None}, "building_type"),
    ],
)
def test_other_files_of_graphs_are_refused(path, changes, message):
    write(path, sample() | changes)
    with pytest.raises(FloorError, match=message):
        read_room_graphs(path)


def test_large_files_are_refused(path, monkeypatch):
    write(path, sample())
    monkeypatch.setattr(room_graphs, "MAX_FILE_BYTES", 100)
    with pytest.raises(FloorError, match="100"):
        read_room_graphs(path)


@given(fuzz=st.data())
def test_damaged_file_of_graphs_is_read_or_refused(path, fuzz):
    path.write_bytes(fuzz.draw(st.binary() | mutated(json.dumps(sample()).encode())))
    with refused_in_one_line():
        assert all(len(graph) <= 2 for graph in read_room_graphs(path))


@pytest.mark.parametrize(
    ("name", "graphs", "nodes", "edges"),
    [
        ("corr_table7_1", 124, 5119, 5444),
        ("batch_2016_02_19_1", 125, 3827, 4008),
        ("batch_2016_02_19_2", 28, 892, 927),
        ("batch_2016_02_19_3", 29, 1015, 1080),
        ("batch_2016_02_19_4", 29, 957, 1021),
        ("batch_old", 49, 1451, 1512),
    ],
)
def test_the_graphs_of_the_thesis(data, name, graphs, nodes, edges):
    read = read_room_graphs(data / "sampled" / f"{name}.json")
    assert len(read) == graphs
    assert sum(map(len, read)) == nodes
    assert sum(graph.number_of_edges() for graph in read) == edges
    assert {graph.graph["building_type"] for graph in read} == {"school"}
    assert all(list(graph) == list(range(len(graph))) for graph in read)


def test_the_first_graph_of_the_thesis_survives(data, path):
    graph = read_room_graphs(data / "sampled" / "corr_table7_1.json")[0]
    assert graph.graph["source"] == "grafogen_2"
    assert [graph.nodes[node]["label"] for node in range(3)] == ["CLASSROOM", "WASHROOM", "CLOSET"]
    for save in (save_graph, save_graphml):
        save(graph, path)
        again = read_room_graph(path)
        assert again.graph.pop("source") == "a.json"
        assert again.nodes == graph.nodes
        assert again.adj == graph.adj
        assert again.graph == {"building_type": "school"}


@pytest.mark.parametrize(
    ("save", "name"),
    [
        (save_graph, "a.json"),
        (save_graph, "a.txt"),
        (save_graphml, "a.graphml"),
        (save_graphml, "a.json"),
        (save_graphml, "a.xml"),
    ],
)
def test_graphs_are_detected_by_their_content(tmp_path, save, name):
    graph = FLOOR.graph()
    graph.graph["building_type"] = "SCHOOL"
    save(graph, tmp_path / name)
    read = read_room_graph(tmp_path / name)
    assert dict(read.nodes(data="label")) == LABELS
    assert read.graph == {"source": name, "building_type": "school"}
    assert read.edges[2, 4]["width"] == 0.9
    assert dict(read.nodes(data="area")) == {4: 12.0, 2: 15.0}


def test_graphml_in_utf_16_is_detected_by_its_name(tmp_path):
    text = '<graphml><graph edgedefault="undirected"><node id="7"/></graph></graphml>'
    (tmp_path / "a.GraphML").write_bytes(text.encode("utf-16"))
    assert dict(read_room_graph(tmp_path / "a.GraphML").nodes(data="label")) == {7: None}


@pytest.mark.parametrize("name", ["a.geojson", "a.json"])
def test_a_floor_is_a_room_graph(tmp_path, name):
    save_floor(FLOOR, tmp_path / name)
    graph = read_room_graph(tmp_path / name)
    assert dict(graph.nodes(data="label")) == LABELS
    assert list(graph.edges) == [(4, 2)]
    assert graph.graph == {"source": name, "building_type": "school"}


def test_a_predicted_type_is_left_out(tmp_path):
    floor = Floor(FLOOR.rooms, building_type={"school": 0.6, "office": 0.4})
    save_floor(floor, tmp_path / "floor.geojson")
    assert read_room_graph(tmp_path / "floor.geojson").graph == {"source": "floor.geojson"}


@pytest.mark.parametrize(
    ("content", "labels"),
    [
        (TWO_ROOMS, ["OFFICE", "CORRIDOR"]),
        (TWO_ROOMS_OF_KTH, ["KONTOR", "KORRIDOR"]),
        (house({"Lab": [[0, 0, 10, 6]]}), ["LAB"]),
    ],
)
def test_drawn_buildings_are_room_graphs(path, content, labels):
    path.write_text(content)
    assert [label for _, label in read_room_graph(path).nodes(data="label")] == labels


def node_link(**changes) -> str:
    parts = {"directed": False, "multigraph": False, "graph": {}, "nodes": [{"id": 1}], "edges": []}
    return json.dumps(parts | changes)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (node_link(directed=True), "directed"),
        (
            node_link(nodes=[{"id": 1, "label": 5}, {"id": 2, "label": ""}], edges=[{"source": 1, "target": 1}]),
            "node 1.*node 1.*node 2",
        ),
        (node_link(graph={"building_type": ["school"]}), "building_type"),
        (json.dumps(sample()), "read_room_graphs"),
        ('<graphml><graph edgedefault="directed"/></graphml>', "directed"),
        ("<svg/>", "SVG.*GraphML"),
        ('{"type": "FeatureCollection", "features": []}', "GeoJSON"),
        ('{"format": "pianta floor", "features": 1}', "floor"),
        ("{}", "JSON"),
        ('{"nodes": [', "JSON"),
        ("[" * 10_000, "JSON"),
        ("\x89PNG", "XML"),
        ("", "empty"),
    ],
)
def test_files_without_a_room_graph_are_refused(path, content, message):
    path.write_text(content)
    with pytest.raises(FloorError, match=message) as error:
        read_room_graph(path)
    assert "\n" not in str(error.value)


def test_large_graphs_are_refused(path, monkeypatch):
    path.write_text(node_link())
    monkeypatch.setattr(room_graphs, "MAX_FILE_BYTES", 10)
    monkeypatch.setattr("pianta.io._xml.MAX_FILE_BYTES", 10)
    with pytest.raises(FloorError, match="bytes"):
        read_room_graph(path)


def test_missing_files_are_refused(tmp_path):
    with pytest.raises(FloorError, match="exist"):
        read_room_graph(tmp_path / "a.graphml")
    with pytest.raises(FloorError, match="folder"):
        read_room_graphs(tmp_path)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
@given(fuzz=st.data())
def test_damaged_file_is_read_or_refused(path, fuzz):
    valid = fuzz.draw(st.sampled_from([node_link(), TWO_ROOMS, "<graphml><graph><node id='1'/></graph></graphml>"]))
    path.write_bytes(fuzz.draw(mutated(valid.encode())))
    with refused_in_one_line():
        assert all("label" in attributes for attributes in read_room_graph(path).nodes.values())


@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_a_real_building_is_a_room_graph(data):
    file = sorted(data.glob("buildings/school/*.xml"))[0]
    graph, floor = read_room_graph(file), read_building_xml(file)
    assert graph.graph == {"source": file.name, "building_type": "school"}
    assert graph.nodes == floor.graph().nodes
    assert graph.adj == floor.graph().adj
