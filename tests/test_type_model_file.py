"""Model files of chapter 7: round trip, and files from untrusted sources."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import networkx as nx
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pianta.errors import ModelError
from pianta.generation.buildings import generate_buildings
from pianta.generation.functional_areas import Segmentation
from pianta.generation.type_model import TypeModel, learn_type
from pianta.generation.type_model_file import MAX_FILE_BYTES, read_type_model, save_type_model
from pianta.labels import FCES, GeneralLabel, Label, LabelSchema
from tests.generated_types import build_floor, make_schools, small_model
from tests.mutation import mutated, refused_in_one_line

Change = Callable[[dict[str, Any]], object]


@pytest.fixture(scope="module")
def model_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "school.json"
    save_type_model(replace(small_model(), sweeps=3, edge_moves=10, door_moves=2), path)
    return path


def refuse(path: Path, match: str) -> None:
    with pytest.raises(ModelError, match=match) as caught:
        read_type_model(path)
    assert "\n" not in str(caught.value)
    assert path.name in str(caught.value)


def rewrite(model_file: Path, path: Path, change: Change) -> Path:
    """A copy of a model file whose content is changed."""
    content = json.loads(model_file.read_text())
    change(content)
    path.write_text(json.dumps(content))
    return path


def list_rooms(building: nx.Graph) -> tuple[list[Any], list[Any]]:
    return [*building.nodes(data=True)], sorted(building.edges)


@pytest.mark.parametrize("segmentation", Segmentation)
def test_round_trip(tmp_path, segmentation):
    model = replace(small_model(segmentation), sweeps=3, edge_moves=10, door_moves=2)
    save_type_model(model, tmp_path / "m.json")
    read = read_type_model(tmp_path / "m.json")
    assert (read.schema, read.segmentation) == (model.schema, segmentation)
    assert (read.sweeps, read.edge_moves, read.door_moves) == (3, 10, 2)
    for one, other in zip(read.floors, model.floors, strict=True):
        assert (one.source, one.areas, one.clusters, one.cuts) == (
            other.source,
            other.areas,
            other.clusters,
            other.cuts,
        )
        assert [*one.graph.nodes(data="label")] == [*other.graph.nodes(data="label")]
    save_type_model(read, tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "m.json").read_bytes()
    reread, expected = (generate_buildings(type_model, 4, seed=5) for type_model in (read, model))
    assert list(map(list_rooms, reread)) == list(map(list_rooms, expected))


def test_a_type_of_the_user(tmp_path):
    house = LabelSchema(
        "house",
        (
            Label("CORRIDOR", FCES.ENTRANCE, GeneralLabel.CORRIDOR, "#112233", FCES.SERVICE, corridor_in_graphs=True),
            Label("Bäder", FCES.SERVICE, GeneralLabel.SMALL, "#AABBCC"),
        ),
    )
    graphs = []
    for rooms in (1, 2, 3):
        graph = nx.star_graph(rooms)
        graph.graph["source"] = f"Häuser {rooms}\n"
        nx.set_node_attributes(graph, {node: "bäder" if node else "corridor" for node in graph}, "label")
        graphs.append(graph)
    save_type_model(learn_type(graphs, house), tmp_path / "m.json")
    read = read_type_model(tmp_path / "m.json")
    assert read.schema == house
    assert [floor.source for floor in read.floors] == [graph.graph["source"] for graph in graphs]


def test_it_replaces_an_older_file(tmp_path):
    (tmp_path / "m.json").write_text("older")
    save_type_model(small_model(), tmp_path / "m.json")
    assert read_type_model(tmp_path / "m.json").building_type == "school"


def test_a_line_for_each_floor(model_file):
    lines = [line for line in model_file.read_text().splitlines() if '"source"' in line]
    assert [json.loads(line.rstrip(","))["source"] for line in lines] == [
        floor.source for floor in small_model().floors
    ]


def test_a_model_that_could_not_be_read_is_not_saved(tmp_path):
    floor = build_floor(("CC", "AA"), ((0, 1),), (0, 2))
    with pytest.raises(ModelError, match="gaps") as caught:
        save_type_model(replace(small_model(), floors=(floor, floor)), tmp_path / "m.json")
    assert "\n" not in str(caught.value)
    assert not [*tmp_path.iterdir()]


def change_floor(**changes: Any) -> Change:
    return lambda content: content["floors"][0].update(changes)


# School a: corridor 0 with rooms 1 to 5, corridor 6 with rooms 7 to 9.
AREAS = [[0, 1, 2, 3, 4, 5], [6, 7, 8, 9]]
DOORS = [[0, 1], [0, 2], [0, 3], [0, 4], [0, 5], [6, 7], [6, 8], [6, 9], [0, 6]]


def test_the_floor_that_other_tests_change(model_file):
    floor = json.loads(model_file.read_text())["floors"][0]
    assert floor["areas"] == AREAS
    assert sorted(map(sorted, floor["doors"])) == sorted(DOORS)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (change_floor(openings=[True]), "9 doors have 1 openings"),
        (change_floor(areas=[AREAS[0], AREAS[1][1:]]), r"school a\.xml"),
        (change_floor(areas=[[*AREAS[0], 6], AREAS[1]]), "area"),
        (change_floor(areas=[[*AREAS[0], 0], AREAS[1]]), "area"),
        (change_floor(areas=[*AREAS, []], clusters=[0, 1, 0]), r"areas\[2\]"),
        (change_floor(areas=[AREAS[0], [*AREAS[1], 10]]), "area"),
        (change_floor(areas=[AREAS[0], [*AREAS[1], -1]]), r"areas\[1\]\[4\].*0"),
        (change_floor(areas=[]), "areas"),
        (change_floor(areas=[[0, 1, 2, 3, 4, 7], [6, 5, 8, 9]]), "area 0.*area 1"),
        (change_floor(areas=[*AREAS, AREAS[0]]), "area.*clusters"),
        (change_floor(clusters=[0]), "clusters"),
        (change_floor(clusters=[0, 1.0]), r"clusters\[1\]"),
        (change_floor(clusters=[0, 10**30]), r"clusters\[1\]"),
        (change_floor(clusters=[0, 999]), "gaps"),
        (change_floor(doors=[*DOORS, [3, 3]]), r"\[3, 3\]"),
        (change_floor(doors=[*DOORS, [3, 10]]), r"\[3, 10\]"),
        (change_floor(doors=[*DOORS, [1, 0]]), "door"),
        (change_floor(doors=[*DOORS, [1]]), r"doors\[9\]"),
        (change_floor(doors=[*DOORS, [1, 2, 3]]), r"doors\[9\]"),
        (change_floor(doors=[*DOORS, [1, "2"]]), r"doors\[9\]\[1\]"),
        (change_floor(doors=DOORS[:-1]), "not connected"),
        (change_floor(doors=[]), "not connected"),
        (change_floor(labels=["CORRIDOR"] * 9), "rooms.*area"),
        (change_floor(labels=["CORRIDOR"] * 9 + ["POOL"]), "POOL"),
        (change_floor(labels=["CORRIDOR"] * 9 + ["gym"]), "gym"),
        (change_floor(labels=["CORRIDOR"] * 9 + [None]), r"labels\[9\]"),
        (change_floor(labels=["CORRIDOR"], doors=[], areas=[[0]], clusters=[0]), "labels"),
        (change_floor(labels=["GYM"] * 1001), "labels"),
        (change_floor(source=7), "source"),
        (lambda content: content["floors"][0].pop("doors"), r"floors\[0\].doors"),
        (lambda content: content.pop("labels"), "labels"),
        (lambda content: content.pop("sweeps"), "sweeps"),
        (lambda content: content.update(sweeps=0), "sweeps"),
        (lambda content: content.update(sweeps=10**6), "sweeps.*1000000"),
        (lambda content: content.update(door_moves=1e400), "door_moves.*inf"),
        (lambda content: content.update(edge_moves=float("nan")), "edge_moves.*nan"),
        (lambda content: content.update(edge_moves=True), "edge_moves.*True"),
        (lambda content: content.update(edge_moves=10**5000 // 10**4000), "edge_moves"),
        (lambda content: content.update(segmentation="rooms"), "segmentation.*corr.*ncut"),
        (lambda content: content.update(building_type="School"), "School"),
        (lambda content: content.update(building_type=""), "building_type"),
        (lambda content: content.update(labels=[]), "labels"),
        (lambda content: content["labels"].append(content["labels"][0]), "CLASSROOM"),
        (lambda content: content["labels"][0].update(color="red"), "red"),
        (lambda content: content["labels"][0].update(function="NOTHING"), r"labels\[0\].function"),
        (lambda content: content.update(floors=content["floors"][:1]), "floors"),
        (lambda content: content.update(floors={}), "floors"),
        (lambda content: content.update(format="pianta types"), "model"),
        (lambda content: content.update(version="2.0"), r"2\.0"),
        (lambda content: content.update(version="99999999999999999999.0"), r"1\.x"),
        (lambda content: content.update(version=1.0), r"1\.0"),
        (lambda content: content.update(version="²"), "²"),
        (lambda content: content.pop("version"), "version"),
    ],
)
def test_files_changed_by_hand(model_file, tmp_path, change, match):
    refuse(rewrite(model_file, tmp_path / "changed.json", change), match)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (b"", "empty"),
        (b" ", "JSON"),
        (b"{", "JSON"),
        (b"\xff\xfe\x00", "JSON"),
        (b"[" * 100_000, "JSON"),
        (b'{"format": ' * 100_000, "JSON"),
        (b"9" * 10_000, "JSON"),
        (b"null", "model"),
        (b"[1, 2]", "model"),
        (b'{"format": "pianta type", "version": "1.0", "floors": %s}' % (b"[" * 500 + b"]" * 500), ": "),
        (b'{"format": "pianta type", "version": "1.0"}', "building_type"),
    ],
)
def test_other_files_are_refused(tmp_path, content, match):
    (tmp_path / "none.json").write_bytes(content)
    refuse(tmp_path / "none.json", match)


def test_a_file_that_is_too_large(tmp_path):
    with (tmp_path / "large.json").open("wb") as file:
        file.truncate(MAX_FILE_BYTES + 1)
    refuse(tmp_path / "large.json", f"{MAX_FILE_BYTES + 1}.*{MAX_FILE_BYTES}")


def test_no_file(tmp_path):
    refuse(tmp_path / "no.json", "no.json")


def test_a_small_file_that_would_fill_the_memory(model_file, tmp_path):
    def change(content: dict[str, Any]) -> None:
        row = {"source": "", "labels": ["GYM"] * 1000, "doors": [[room, room + 1] for room in range(999)]}
        pair = {"source": "", "labels": ["GYM"] * 2, "doors": [[0, 1]], "areas": [[0], [1]]}
        content["floors"] = [
            {**row, "areas": [[room] for room in range(1000)], "clusters": [0] * 1000},
            *({**pair, "clusters": [2 * number % 1000, 2 * number % 1000 + 1]} for number in range(999)),
        ]

    refuse(
        rewrite(model_file, tmp_path / "memory.json", change),
        "1000",
    )


def test_a_later_minor_version_is_read(model_file, tmp_path):
    path = rewrite(model_file, tmp_path / "later.json", lambda content: content.update(version="1.7", later=[1]))
    assert len(read_type_model(path).floors) == 8


def test_the_same_floor_in_another_order_is_harmless(model_file, tmp_path):
    def turn(content: dict[str, Any]) -> None:
        for floor in content["floors"]:
            floor["doors"] = [door[::-1] for door in reversed(floor["doors"])]
            floor["areas"] = [area[::-1] for area in floor["areas"]]

    turned = read_type_model(rewrite(model_file, tmp_path / "turned.json", turn))
    assert [floor.areas for floor in turned.floors] == [floor.areas for floor in read_type_model(model_file).floors]
    assert_sampled(turned)


def test_all_faults_are_reported(model_file, tmp_path):
    def change(content: dict[str, Any]) -> None:
        content["floors"][0]["clusters"] = [0]
        content["floors"][1]["doors"] = []
        content["sweeps"] = -1

    path = rewrite(model_file, tmp_path / "changed.json", change)
    refuse(path, "clusters")
    refuse(path, r"school b\.xml.*not connected")
    refuse(path, "sweeps")


def assert_sampled(model: TypeModel) -> None:
    """Every model that can be read generates buildings."""
    (building,) = generate_buildings(replace(model, sweeps=2, edge_moves=4, door_moves=2), 1)
    assert nx.is_connected(building)


@pytest.mark.slow
@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_damaged_files(model_file, tmp_path, data):
    path = tmp_path / "damaged.json"
    path.write_bytes(data.draw(mutated(model_file.read_bytes())))
    with refused_in_one_line():
        assert_sampled(read_type_model(path))


VALUES = st.one_of(
    st.integers(-2, 12),
    st.none(),
    st.booleans(),
    st.floats(),
    st.text(max_size=3),
    st.just([]),
    st.just({}),
    st.just([0]),
)


@pytest.mark.slow
@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_value_replaced_by_another(model_file, tmp_path, data):
    content = json.loads(model_file.read_text())
    index: Any = content
    while True:
        key = data.draw(st.sampled_from(sorted(index) if isinstance(index, dict) else range(len(index))))
        if not isinstance(index[key], dict | list) or not index[key] or data.draw(st.integers(0, 4)) == 0:
            break
        index = index[key]
    index[key] = data.draw(VALUES)
    path = tmp_path / "replaced.json"
    path.write_text(json.dumps(content))
    with refused_in_one_line():
        assert_sampled(read_type_model(path))


def test_floors_in_order(model_file):
    assert [floor.source for floor in read_type_model(model_file).floors] == [
        graph.graph["source"] for graph in make_schools()
    ]
