"""`pianta train type` and `pianta generate`, as a user runs them."""

import json
from dataclasses import replace
from pathlib import Path

import networkx as nx
import pytest
from PIL import Image
from shapely import LineString, box

from pianta.floor import Door, Floor, Room
from pianta.generation.type_model_file import read_type_model
from pianta.io.floors import save_floor
from pianta.io.graphml import read_graphml
from pianta.io.graphs import read_graph
from tests.command_line import list_files, run_pianta
from tests.generated_types import make_schools

READ_AGAIN = "or read its map with labels of the type: `pianta read map.yaml --type school -o building`"


def draw_floor(graph: nx.Graph, *, building_type: str | None = "school") -> Floor:
    """A floor with the rooms and doors of a graph, its rooms squares in a row with ids from 1 on."""
    rooms = tuple(
        Room(node + 1, box(2 * node, 0, 2 * node + 1, 1), label=label) for node, label in graph.nodes("label")
    )
    doors = tuple(Door((one + 1, other + 1), LineString([(0, 0), (0, 1)]), 1.0) for one, other in graph.edges)
    return Floor(
        rooms, doors, building_type={building_type: 1.0} if building_type else {}, source=graph.graph["source"]
    )


def part_floor(floor: Floor) -> Floor:
    """The floor without the doors between its corridors."""
    hubs = {room.id for room in floor.rooms if room.label == "CORRIDOR"}
    return replace(floor, doors=tuple(door for door in floor.doors if not hubs.issuperset(door.rooms)))


@pytest.fixture(scope="module")
def schools(tmp_path_factory):
    """A folder of eight schools."""
    folder = tmp_path_factory.mktemp("schools")
    for graph in make_schools():
        save_floor(draw_floor(graph), folder / f"{Path(graph.graph['source']).stem}.geojson")
    return folder


@pytest.fixture(scope="module")
def model(tmp_path_factory, schools):
    """The model of the schools, with short chains."""
    path = tmp_path_factory.mktemp("model") / "school.json"
    outcome = run_pianta("train", "type", schools, "-o", path)
    assert outcome.code == 0, outcome.err
    content = json.loads(path.read_text())
    path.write_text(json.dumps(content | {"sweeps": 20, "edge_moves": 50, "door_moves": 10}))
    return path


def label_counts(graph: nx.Graph) -> dict[str, int]:
    labels = [label for _, label in graph.nodes(data="label")]
    return {label: labels.count(label) for label in labels}


def read_generated(folder: Path) -> list[nx.Graph]:
    return [read_graph(file) for file in sorted(folder.glob("building-*.json"))]


class TestTrainType:
    @pytest.mark.slow
    def test_learns_and_prints_the_next_command(self, schools, tmp_path):
        outcome = run_pianta("train", "type", schools, "-o", tmp_path / "new" / "school.json")
        assert outcome.code == 0, outcome.err
        trained, mixed, written, following = outcome.out.splitlines()
        learned = read_type_model(tmp_path / "new" / "school.json")
        assert [floor.source for floor in learned.floors] == [f"school {name}.geojson" for name in "abcdefgh"]
        assert trained == f"trained on {learned} of {min_max(learned)}, type school"
        assert "R-hat" in mixed
        assert "school.json" in written
        command = following.removeprefix("next: pianta ")
        assert command.startswith(f"generate {tmp_path / 'new' / 'school.json'} -n 24 -o ")

    @pytest.mark.slow
    def test_gives_the_same_bytes_again(self, schools, tmp_path):
        for name in ("one.json", "other.json"):
            assert run_pianta("train", "type", schools, "-q", "-o", tmp_path / name).code == 0
        assert (tmp_path / "one.json").read_bytes() == (tmp_path / "other.json").read_bytes()

    @pytest.mark.slow
    def test_cuts_by_normalized_cut(self, schools, tmp_path):
        assert run_pianta("train", "type", schools, "--areas", "ncut", "-q", "-o", tmp_path / "cut.json").code == 0
        assert read_type_model(tmp_path / "cut.json").segmentation == "ncut"

    @pytest.mark.slow
    def test_leaves_out_what_it_cannot_use(self, schools, tmp_path):
        first, second = make_schools()[:2]
        unlabelled = draw_floor(first)
        rooms = (replace(unlabelled.rooms[0], label=None), *unlabelled.rooms[1:])
        save_floor(replace(unlabelled, rooms=rooms), tmp_path / "unlabelled.geojson")
        second.remove_edge(0, 5)
        save_floor(draw_floor(second), tmp_path / "parted.geojson")
        (tmp_path / "broken.geojson").write_text("{")
        outcome = run_pianta("train", "type", schools, tmp_path, "-o", tmp_path / "model.json")
        assert outcome.code == 1
        assert len(read_type_model(tmp_path / "model.json").floors) == 8
        broken, parted, unlabelled_line = sorted(line for line in outcome.err.splitlines() if "error" in line)
        assert "broken.geojson" in broken
        assert "parted.geojson" in parted
        assert "2 parts" in parted
        assert "unlabelled.geojson" in unlabelled_line
        assert "label" in unlabelled_line.replace("unlabelled.geojson", "")

    @pytest.mark.parametrize(
        ("change", "fragment"),
        [
            (lambda floor: replace(floor, rooms=tuple(replace(room, label=None) for room in floor.rooms)), "label"),
            (part_floor, "door"),
            (lambda floor: replace(floor, doors=()), "door"),
            (lambda floor: replace(floor, building_type={}), "--type"),
            (lambda floor: replace(floor, building_type={"castle": 1.0}), "castle"),
        ],
    )
    def test_refuses_a_set_that_it_cannot_use(self, change, fragment, tmp_path):
        for graph in make_schools()[:3]:
            save_floor(change(draw_floor(graph)), tmp_path / f"{Path(graph.graph['source']).stem}.geojson")
        outcome = run_pianta("train", "type", tmp_path, "-o", tmp_path / "model.json")
        assert_one_error(outcome, fragment)
        assert not (tmp_path / "model.json").exists()

    def test_refuses_one_floor(self, schools, tmp_path):
        outcome = run_pianta("train", "type", schools / "school a.geojson", "-o", tmp_path / "model.json")
        assert_one_error(outcome, "floors")

    def test_refuses_several_types(self, schools, tmp_path):
        save_floor(draw_floor(make_schools()[0], building_type="office"), tmp_path / "office.geojson")
        outcome = run_pianta("train", "type", schools, tmp_path, "-o", tmp_path / "model.json")
        assert_one_error(outcome, "office, school")

    def test_refuses_unknown_areas(self, schools, tmp_path):
        outcome = run_pianta("train", "type", schools, "--areas", "rooms", "-o", tmp_path / "model.json")
        assert_one_error(outcome, "'rooms'")


class TestGenerate:
    @pytest.mark.slow
    def test_writes_graphs_and_their_sheet(self, model, tmp_path):
        outcome = run_pianta("generate", model, "-n", 5, "-o", tmp_path / "made")
        assert outcome.code == 0, outcome.err
        names = [f"building-{number:03}" for number in range(1, 6)]
        expected = {f"{name}.{suffix}" for name in names for suffix in ("json", "graphml")} | {"sheet.png"}
        assert list_files(tmp_path / "made").keys() == expected
        sizes, copies, outputs = outcome.out.splitlines()
        graphs = read_generated(tmp_path / "made")
        rooms = [len(graph) for graph in graphs]
        assert sizes.startswith(f"5 buildings of type school, {min(rooms)} to {max(rooms)} rooms, ")
        assert copies.startswith("copies of a floor of the model: ")
        assert str(tmp_path / "made") in outputs
        for name, graph in zip(names, graphs, strict=True):
            assert nx.is_connected(graph)
            assert graph.graph == {"source": name, "building_type": "school"}
            assert nx.utils.graphs_equal(read_graphml(tmp_path / "made" / f"{name}.graphml"), graph)
        with Image.open(tmp_path / "made" / "sheet.png") as sheet:
            assert sheet.width > sheet.height

    @pytest.mark.slow
    def test_gives_the_same_for_a_seed_and_any_number_of_jobs(self, model, tmp_path):
        for name, options in (("one", ()), ("two", ("--jobs", 2)), ("other", ("--seed", 1))):
            assert run_pianta("generate", model, "-n", 4, "-q", "-o", tmp_path / name, *options).code == 0
        one, two, other = (list_files(tmp_path / name) for name in ("one", "two", "other"))
        assert one == two
        assert one != other

    @pytest.mark.slow
    def test_meets_constraints(self, model, tmp_path):
        constraints = ("--rooms", "12-16", "--at-least", "classroom=5", "--at-least", "GYM", "--at-most", "CLOSET=2")
        outcome = run_pianta("generate", model, "-n", 6, *constraints, "-o", tmp_path / "made")
        assert outcome.code == 0, outcome.err
        for graph in read_generated(tmp_path / "made"):
            counts = label_counts(graph)
            assert 12 <= len(graph) <= 16
            assert counts["CLASSROOM"] >= 5
            assert counts["GYM"] >= 1
            assert counts.get("CLOSET", 0) <= 2

    @pytest.mark.slow
    def test_makes_buildings_like_a_floor(self, model, schools, tmp_path):
        outcome = run_pianta(
            "generate", model, "-n", 4, "--like", schools / "school d.geojson", "-o", tmp_path / "made"
        )
        assert outcome.code == 0, outcome.err
        rooms = len(make_schools()[3])
        # SIZE_MARGIN, rounded to whole rooms
        assert all(
            round(0.8 * rooms) <= len(graph) <= round(1.2 * rooms) for graph in read_generated(tmp_path / "made")
        )

    @pytest.mark.slow
    def test_keeps_rooms_and_doors(self, model, schools, tmp_path):
        outcome = run_pianta(
            "generate", model, "-n", 3, "--keep", schools / "school a.geojson", "-o", tmp_path / "made"
        )
        assert outcome.code == 0, outcome.err
        school = make_schools()[0]
        for graph in read_generated(tmp_path / "made"):
            assert len(graph) > len(school)
            node_of = {room: node for node, room in graph.nodes(data="room") if room is not None}
            assert {room: graph.nodes[node]["label"] for room, node in node_of.items()} == {
                node + 1: label for node, label in school.nodes(data="label")
            }
            common = graph.subgraph(node_of.values())
            doors = {frozenset((node_of[one + 1], node_of[other + 1])) for one, other in school.edges}
            assert {frozenset(edge) for edge in common.edges} == doors

    @pytest.mark.slow
    def test_reads_the_folder_of_a_reading(self, model, schools, tmp_path):
        (tmp_path / "read").mkdir()
        content = (schools / "school a.geojson").read_bytes()
        (tmp_path / "read" / "floor.geojson").write_bytes(content)
        for name, floor in (("one", tmp_path / "read"), ("other", tmp_path / "read" / "floor.geojson")):
            assert run_pianta("generate", model, "-n", 1, "-q", "--keep", floor, "-o", tmp_path / name).code == 0
        assert list_files(tmp_path / "one") == list_files(tmp_path / "other")

    def test_warns_of_rooms_without_a_door(self, model, tmp_path):
        graph = make_schools()[0]
        graph.add_node(len(graph), label="CLOSET")
        save_floor(draw_floor(graph), tmp_path / "floor.geojson")
        outcome = run_pianta("generate", model, "-n", 1, "--keep", tmp_path / "floor.geojson", "-o", tmp_path / "made")
        assert outcome.code == 0
        assert f"rooms {len(graph)}" in outcome.err

    @pytest.mark.slow
    def test_follows_the_printed_costs(self, model, tmp_path):
        for costs in ("density", "thesis"):
            assert run_pianta("generate", model, "-n", 2, "-q", "--costs", costs, "-o", tmp_path / costs).code == 0
        assert list_files(tmp_path / "density") != list_files(tmp_path / "thesis")
        outcome = run_pianta("generate", model, "--costs", "low", "-o", tmp_path / "low")
        assert_one_error(outcome, "'low'")

    @pytest.mark.slow
    def test_areas_of_real_floors_and_graph_hopper(self, model, tmp_path):
        for name, options in (("new", ()), ("real", ("--no-recombine",)), ("hopper", ("--kernel", "graph-hopper"))):
            assert run_pianta("generate", model, "-n", 2, "-q", *options, "-o", tmp_path / name).code == 0
        files = [list_files(tmp_path / name) for name in ("new", "real", "hopper")]
        assert files[0] != files[1]
        assert files[0] != files[2]

    def test_refuses_an_unknown_kernel(self, model, tmp_path):
        outcome = run_pianta("generate", model, "--kernel", "linear", "-o", tmp_path / "made")
        assert_one_error(outcome, "'linear', give one of weisfeiler-lehman, graph-hopper")

    @pytest.mark.parametrize(
        ("change", "options", "fragment"),
        [
            (part_floor, (), "2 parts"),
            (lambda floor: replace(floor, doors=()), (), "door"),
            (
                lambda floor: replace(floor, rooms=(replace(floor.rooms[0], label=None), *floor.rooms[1:])),
                (),
                f"rooms 1 have no label, label them; {READ_AGAIN}",
            ),
            # The wings have six and four rooms, and one more area has two at least.
            (lambda floor: floor, ("--rooms", "10"), "at most 10 rooms in all are allowed"),
            (lambda floor: floor, ("--at-most", "CORRIDOR=1"), "each building has 3 or more"),
        ],
    )
    def test_refuses_a_floor_that_it_cannot_continue(self, model, change, options, fragment, tmp_path):
        save_floor(change(draw_floor(make_schools()[0])), tmp_path / "seen.geojson")
        outcome = run_pianta("generate", model, "--keep", tmp_path / "seen.geojson", *options, "-o", tmp_path / "made")
        assert_one_error(outcome, fragment)
        assert not (tmp_path / "made").exists()

    @pytest.mark.slow
    def test_reads_its_own_output(self, model, tmp_path):
        assert run_pianta("generate", model, "-n", 1, "-q", "-o", tmp_path / "made").code == 0
        for suffix in ("json", "graphml"):
            floor = tmp_path / "made" / f"building-001.{suffix}"
            assert run_pianta("generate", model, "-n", 1, "-q", "--keep", floor, "-o", tmp_path / suffix).code == 0
        assert list_files(tmp_path / "json") == list_files(tmp_path / "graphml")

    @pytest.mark.parametrize(
        ("options", "fragment"),
        [
            (("--rooms", "many"), "--rooms"),
            (("--rooms", "50-30"), "range"),
            (("--rooms", "900"), "900"),
            (("--rooms", "5", "--at-least", "CLASSROOM=6"), "labels"),
            (("--at-least", "CLASSROOM=4", "--at-most", "CLASSROOM=2"), "CLASSROOM"),
            (("--at-least", "LIBRARY"), "LIBRARY"),
            (("--at-least", "CLASSROOM=few"), "number"),
            (("--at-least", "GYM=1", "--at-least", "gym"), "GYM"),
            (("--at-most", "GYM"), "number"),
            (("--like", "nowhere.geojson"), "nowhere.geojson"),
        ],
    )
    def test_refuses_what_cannot_be(self, model, options, fragment, tmp_path):
        outcome = run_pianta("generate", model, "-n", 2, *options, "-o", tmp_path / "made")
        assert_one_error(outcome, fragment)
        assert not (tmp_path / "made").exists()

    def test_refuses_a_floor_of_other_labels(self, model, tmp_path):
        graph = make_schools()[0]
        graph.nodes[3]["label"] = "DUNGEON"
        save_floor(draw_floor(graph), tmp_path / "castle.geojson")
        outcome = run_pianta("generate", model, "--keep", tmp_path / "castle.geojson", "-o", tmp_path / "made")
        assert_one_error(outcome, "labels 'DUNGEON' are not in the schema of 'school'")
        assert "castle.geojson" in outcome.err
        assert f"; {READ_AGAIN}" in outcome.err

    @pytest.mark.parametrize("option", ["--keep", "--like"])
    def test_refuses_a_floor_of_another_type(self, model, option, tmp_path):
        save_floor(draw_floor(make_schools()[0], building_type="office"), tmp_path / "office.geojson")
        outcome = run_pianta("generate", model, option, tmp_path / "office.geojson", "-o", tmp_path / "made")
        assert_one_error(outcome, "is of type 'office' and the model of 'school', give a model of type 'office'")
        assert not (tmp_path / "made").exists()

    @pytest.mark.parametrize(
        ("change", "fragment"),
        [
            ({"version": "2.0"}, "2.0"),
            ({"format": "pianta labels"}, " model "),
            ({"sweeps": 0}, "sweeps"),
        ],
    )
    def test_refuses_other_models(self, model, change, fragment, tmp_path):
        (tmp_path / "model.json").write_text(json.dumps(json.loads(model.read_text()) | change))
        assert_one_error(run_pianta("generate", tmp_path / "model.json", "-o", tmp_path / "made"), fragment)

    @pytest.mark.slow
    def test_leaves_other_buildings_alone(self, model, tmp_path):
        assert run_pianta("generate", model, "-n", 3, "-q", "-o", tmp_path).code == 0
        before = list_files(tmp_path)
        outcome = run_pianta("generate", model, "-n", 2, "-o", tmp_path)
        assert_one_error(outcome, "building-003")
        assert list_files(tmp_path) == before
        assert run_pianta("generate", model, "-n", 3, "-q", "--seed", 1, "-o", tmp_path).code == 0
        assert list_files(tmp_path).keys() == before.keys()


def min_max(model) -> str:
    sizes = [int((model.clusters == cluster).sum()) for cluster in set(model.clusters.tolist())]
    return f"{min(sizes)} to {max(sizes)}"


def assert_one_error(outcome, fragment: str) -> None:
    assert outcome.code == 2
    assert outcome.out == ""
    (line,) = [line for line in outcome.err.splitlines() if not line.startswith("warning: ")]
    assert line.startswith("error: ")
    assert fragment in line
