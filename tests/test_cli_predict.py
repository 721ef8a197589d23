"""`pianta predict`, as a user runs it."""

import json
from dataclasses import replace

import networkx as nx
import numpy as np
import pytest
from PIL import Image
from shapely import box

from pianta.errors import LabelError, OptionError
from pianta.floor import Room
from pianta.generation.functional_areas import Segmentation
from pianta.generation.type_model import learn_type
from pianta.generation.type_model_file import save_type_model
from pianta.gridmap import GridMap
from pianta.io.floors import read_floor, save_floor
from pianta.io.graphml import save_graphml
from pianta.io.graphs import read_graph, save_graph
from pianta.io.maps import read_npz_map
from pianta.prediction.revealed_floor import reveal_corridors
from tests.command_line import list_files, run_pianta
from tests.generated_types import SCHOOL, join_wings, make_schools, make_wing
from tests.test_cli_generate import draw_floor

# Two wings; only the corridor of the second is discovered, and a closet of the first was not entered.
EXPLORED = join_wings(("CCCCS", "CT"), ((0, 1),), source="explored")
EXPLORED.nodes[5].update(label=None, partial=True)
EXPLORED.nodes[6].update(partial=True)


def write_floor(graph: nx.Graph, path, **attributes: str):
    copy = graph.copy()
    copy.graph.clear()
    copy.graph.update(attributes)
    save_graph(copy, path)
    return path


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """The model of all schools but the fourth, as a file."""
    path = tmp_path_factory.mktemp("model") / "school.json"
    schools = make_schools()
    save_type_model(learn_type([*schools[:3], *schools[4:]], SCHOOL), path)
    return path


@pytest.fixture(scope="module")
def school_file(tmp_path_factory):
    """The fourth school, of four wings in a ring."""
    path = tmp_path_factory.mktemp("school_file") / "school d.geojson"
    save_floor(draw_floor(make_schools()[3]), path)
    return path


@pytest.fixture
def explored(tmp_path):
    return write_floor(EXPLORED, tmp_path / "explored.json", building_type="school")


def test_a_partly_explored_floor_cannot_be_explored_again(explored, model):
    code, out, err = run_pianta("predict", explored, model, "--explored", "1")
    assert (code, out) == (2, "")
    assert "5, 6" in err


class TestPredict:
    def test_prints_sizes_open_ends_and_labels(self, explored, model):
        outcome = run_pianta("predict", explored, model, "-n", 20)
        assert outcome.code == 0, outcome.err
        counts, size, *tables = outcome.out.splitlines()
        assert counts == "8 rooms known, 2 open ends, 20 floors sampled"
        assert size.startswith("the whole floor: ")
        assert "true" not in outcome.out
        text = "\n".join(tables)
        assert "corridor 6" in text
        assert "door 5" in text
        assert "0 CORRIDOR" in text
        assert "unknown rooms" in text
        assert list_files(explored.parent).keys() == {"explored.json"}

    def test_writes_prediction_picture_and_samples(self, explored, model, tmp_path):
        outcome = run_pianta("predict", explored, model, "-n", 6, "-o", tmp_path / "new" / "predicted")
        assert outcome.code == 0, outcome.err
        assert outcome.out.splitlines()[-1].startswith(f"in {tmp_path / 'new' / 'predicted'}: prediction.json")
        names = [f"sample-{number:03}" for number in range(1, 7)]
        files = list_files(tmp_path / "new" / "predicted")
        assert files.keys() == {"prediction.json", "picture.png", *(f"{name}.json" for name in names)}
        content = json.loads(files["prediction.json"])
        assert (content["format"], content["version"]) == ("pianta prediction", "1.0")
        assert (content["source"], content["building_type"], content["samples"]) == ("explored.json", "school", 6)
        assert content["known"] == [0, 1, 2, 3, 4, 6, 7, 8]
        assert [(end["kind"], end["room"], end["near"]) for end in content["open_ends"]] == [
            ("corridor", 6, 6),
            ("door", 5, 0),
        ]
        assert "truth" not in content
        with Image.open(tmp_path / "new" / "predicted" / "picture.png") as picture:
            assert picture.width > picture.height

    def test_a_floor_with_outlines_is_written_for_the_page(self, model, tmp_path):
        graph = join_wings(("CCCCS", "CT"), ((0, 1),), source="read")
        floor = draw_floor(graph)
        # The corridor of the second wing is open; nodes have ids from 1 on.
        rooms = tuple(replace(room, partial=room.id == 7) for room in floor.rooms)
        floor = replace(floor, rooms=rooms)
        (tmp_path / "explored").mkdir()
        grid = GridMap(np.zeros((4, 5), np.int8), 0.1)
        grid.save(tmp_path / "explored" / "grid.npz")
        save_floor(floor, tmp_path / "explored" / "floor.geojson")
        code, _, err = run_pianta("predict", tmp_path / "explored", model, "-n", 2, "-o", tmp_path / "out")
        assert (code, err) == (0, "")
        assert read_floor(tmp_path / "out" / "explored.geojson") == floor
        assert read_npz_map(tmp_path / "out" / "explored.npz").shape == (4, 5)

    @pytest.mark.slow
    def test_samples_keep_the_known_part_and_complete_it(self, explored, model, tmp_path):
        assert run_pianta("predict", explored, model, "-n", 6, "-q", "-o", tmp_path / "new").code == 0
        known_part = EXPLORED.subgraph([0, 1, 2, 3, 4, 6, 7, 8])
        for number in range(1, 7):
            graph = read_graph(tmp_path / "new" / f"sample-{number:03}.json")
            assert graph.graph == {"source": f"sample-{number:03}", "building_type": "school"}
            node_of = {room: node for node, room in graph.nodes(data="room") if room is not None}
            assert node_of.keys() == set(known_part)
            doors = {frozenset((node_of[one], node_of[other])) for one, other in known_part.edges}
            assert {frozenset(edge) for edge in graph.subgraph(node_of.values()).edges} == doors
            for behind in [node for node, door in graph.nodes(data="door") if door == 5]:
                assert graph.has_edge(behind, node_of[0])
                assert graph.nodes[behind]["label"] in SCHOOL.by_name

    @pytest.mark.slow
    def test_figures_agree_with_the_samples(self, explored, model, tmp_path):
        assert run_pianta("predict", explored, model, "-n", 8, "-q", "-o", tmp_path / "new").code == 0
        content = json.loads((tmp_path / "new" / "prediction.json").read_text())
        graphs = [read_graph(tmp_path / "new" / f"sample-{number:03}.json") for number in range(1, 9)]
        assert content["rooms"]["mean"] == pytest.approx(sum(map(len, graphs)) / 8)
        for label, spread in content["unknown"].items():
            counts = [
                sum(data["label"] == label and "room" not in data for _, data in graph.nodes(data=True))
                for graph in graphs
            ]
            assert spread["mean"] == pytest.approx(sum(counts) / 8, abs=1e-4)
        behind = [data["label"] for graph in graphs for _, data in graph.nodes(data=True) if data.get("door") == 5]
        # Half of the probability is the share of the samples, half what is behind similar doors of the model.
        labels = content["open_ends"][1]["labels"]
        rest = {label: labels[label] - behind.count(label) / len(behind) / 2 for label in labels}
        assert {*behind} <= labels.keys()
        assert all(value > -1e-4 for value in rest.values())
        assert sum(rest.values()) == pytest.approx(0.5, abs=1e-3)
        assert rest.keys() - {*behind}

    @pytest.mark.slow
    def test_is_repeatable_with_a_seed(self, explored, model, tmp_path):
        for name, seed in (("one", 0), ("two", 0), ("other", 1)):
            assert (
                run_pianta("predict", explored, model, "-n", 3, "-q", "--seed", seed, "-o", tmp_path / name).code == 0
            )
        one, two, other = (list_files(tmp_path / name) for name in ("one", "two", "other"))
        assert one == two
        assert one != other

    def test_as_printed(self, explored, model, tmp_path):
        for name, options in (("default", ()), ("printed", ("--as-printed",))):
            outcome = run_pianta("predict", explored, model, "-n", 5, "-q", "-o", tmp_path / name, *options)
            assert outcome.code == 0, outcome.err
        default, printed = (
            json.loads((tmp_path / name / "prediction.json").read_text()) for name in ("default", "printed")
        )
        assert printed["known"] == default["known"]
        assert printed["rooms"] != default["rooms"]

    def test_quiet_prints_nothing(self, explored, model):
        assert run_pianta("predict", explored, model, "-n", 2, "-q") == (0, "", "")

    @pytest.mark.slow
    def test_reads_graphml_like_json(self, model, tmp_path):
        """GraphML holds label probabilities as text."""
        graph = EXPLORED.copy()
        graph.nodes[5].update(label="CLOSET", label_probabilities={"school": {"CLOSET": 0.2}})
        graph.graph.clear()
        save_graph(graph, tmp_path / "explored.json")
        save_graphml(graph, tmp_path / "explored.graphml")
        for suffix in ("json", "graphml"):
            outcome = run_pianta(
                "predict", tmp_path / f"explored.{suffix}", model, "-n", 2, "-q", "-o", tmp_path / suffix
            )
            assert outcome.code == 0, outcome.err
        one, other = (json.loads((tmp_path / suffix / "prediction.json").read_text()) for suffix in ("json", "graphml"))
        assert one | {"source": None} == other | {"source": None}

    @pytest.mark.slow
    @pytest.mark.parametrize(
        "odd", [{"label_probabilities": "{"}, {"label_probabilities": [1]}, {"predicted_area": "much"}, {"area": None}]
    )
    def test_invalid_attributes_of_a_partial_room_are_ignored(self, model, tmp_path, odd):
        graph = EXPLORED.copy()
        graph.nodes[5].update({"label": "CLOSET", "predicted_area": 8.0, "area": 7.0} | odd)
        outcome = run_pianta("predict", write_floor(graph, tmp_path / "explored.json"), model, "-n", 2)
        assert outcome.code == 0, outcome.err
        assert outcome.out.startswith("9 rooms known, 1 open end, ")

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("seen_area", "probability", "is_known"),
        [(4.9, 0.9, False), (5.1, 0.1, True)],
    )
    def test_a_glimpsed_room_is_unknown(self, model, tmp_path, seen_area, probability, is_known):
        """Half of 10 m² must be explored for a label to count, however probable it is."""
        graph = EXPLORED.copy()
        label = {"label": "CLOSET", "label_probabilities": {"school": {"CLOSET": probability}}}
        graph.nodes[5].update(label, predicted_area=10.0, area=seen_area)
        outcome = run_pianta("predict", write_floor(graph, tmp_path / "explored.json"), model, "-n", 2)
        assert outcome.code == 0, outcome.err
        assert outcome.out.startswith(f"{8 + is_known} rooms known, ")

    def test_reads_the_folder_of_a_reading_and_warns_of_rooms_without_a_door(self, model, tmp_path):
        floor = draw_floor(join_wings(("CCCCS", "CT"), ((0, 1),), source="read"))
        *rooms, corridor, classroom, bathroom = floor.rooms
        alone = Room(20, box(0, 5, 1, 6), label="CLOSET")
        partly_explored = (*rooms, replace(corridor, partial=True), classroom, bathroom, alone)
        (tmp_path / "read").mkdir()
        save_floor(replace(floor, rooms=partly_explored, last_id=20), tmp_path / "read" / "floor.geojson")
        outcome = run_pianta("predict", tmp_path / "read", model, "-n", 2)
        assert outcome.code == 0, outcome.err
        assert "rooms 20" in outcome.err
        assert outcome.out.startswith("9 rooms known, 1 open end, 2 floors sampled\n")


class TestExplored:
    @pytest.mark.slow
    def test_compares_with_the_truth(self, school_file, model, tmp_path):
        outcome = run_pianta("predict", school_file, model, "--explored", 1, "-n", 10, "-o", tmp_path / "new")
        assert outcome.code == 0, outcome.err
        # The corridor with the most doors leads to four rooms, a closet and two corridors.
        assert outcome.out.startswith("8 rooms known, 2 open ends, 10 floors sampled\n")
        assert f"in truth {len(make_schools()[3])} rooms" in outcome.out
        truth = json.loads((tmp_path / "new" / "prediction.json").read_text())["truth"]
        assert truth["rooms"] == len(make_schools()[3])
        assert sum(truth["unknown"].values()) == len(make_schools()[3]) - 8

    @pytest.mark.slow
    def test_names_what_is_behind_doors(self, model, tmp_path):
        graph = make_schools()[3]
        graph.add_edge(1, len(graph))
        graph.nodes[len(graph) - 1]["label"] = "CLOSET"
        save_floor(draw_floor(graph), tmp_path / "school.geojson")
        outcome = run_pianta(
            "predict", tmp_path / "school.geojson", model, "--explored", 1, "-n", 3, "-o", tmp_path / "new"
        )
        assert outcome.code == 0, outcome.err
        content = json.loads((tmp_path / "new" / "prediction.json").read_text())
        # Rooms have ids from 1 on.
        name = f"2-{len(graph)}"
        assert content["truth"]["behind"] == [{"door": name, "room": len(graph), "label": "CLOSET"}]
        assert content["open_ends"][-1]["room"] == name
        assert f"door {name}" in outcome.out

    def test_warns_of_a_floor_that_the_model_knows(self, model, tmp_path):
        save_floor(draw_floor(make_schools()[1]), tmp_path / "known.geojson")
        outcome = run_pianta("predict", tmp_path / "known.geojson", model, "--explored", 1, "-n", 2, "-q")
        assert outcome.code == 0, outcome.err
        assert "trained" in outcome.err

    @pytest.mark.parametrize(("corridors", "fragment"), [(9, "9"), (4, "--explored")])
    def test_refuses_too_many_corridors(self, school_file, model, corridors, fragment):
        assert_one_error(run_pianta("predict", school_file, model, "--explored", corridors), fragment)


class TestRefusals:
    def test_a_floor_without_open_ends(self, school_file, model, tmp_path):
        outcome = run_pianta("predict", school_file, model, "-o", tmp_path / "new")
        assert_one_error(outcome, "--explored")
        assert not (tmp_path / "new").exists()

    def test_a_floor_of_another_type(self, model, tmp_path):
        floor = write_floor(EXPLORED, tmp_path / "office.json", building_type="office")
        assert_one_error(run_pianta("predict", floor, model), "'office'")

    @pytest.mark.parametrize("label", [None, "FUNCTIONAL"])
    def test_a_reading_without_labels_of_the_type(self, model, tmp_path, label):
        graph = EXPLORED.copy()
        graph.nodes[1]["label"] = label
        outcome = run_pianta("predict", write_floor(graph, tmp_path / "explored.json"), model)
        assert_one_error(outcome, "--type")

    def test_labels_of_another_schema(self, model, tmp_path):
        """An office's labels, in a file that does not say its type."""
        graph = EXPLORED.copy()
        graph.nodes[1]["label"] = "CUBICULE"
        outcome = run_pianta("predict", write_floor(graph, tmp_path / "explored.json"), model)
        assert_one_error(outcome, "CUBICULE")

    def test_a_model_of_one_building(self, explored, model, tmp_path):
        content = json.loads(model.read_text())
        content["floors"] = content["floors"][:1]
        (tmp_path / "one.json").write_text(json.dumps(content))
        assert_one_error(run_pianta("predict", explored, tmp_path / "one.json"), "one.json")

    def test_a_model_without_corridors(self, explored, tmp_path):
        rooms = [nx.path_graph(count) for count in (3, 4)]
        for graph in rooms:
            nx.set_node_attributes(graph, "CLASSROOM", "label")
        save_type_model(learn_type(rooms, SCHOOL), tmp_path / "rooms.json")
        for options in ((), ("--as-printed",)):
            outcome = run_pianta("predict", explored, tmp_path / "rooms.json", *options)
            assert_one_error(outcome, "no floor of the model")

    def test_refuses_a_missing_floor(self, model):
        assert_one_error(run_pianta("predict", "nowhere.geojson", model), "nowhere.geojson")

    def test_a_model_by_ncut(self, explored, tmp_path):
        save_type_model(learn_type(make_schools(), SCHOOL, segmentation=Segmentation.NCUT), tmp_path / "cut.json")
        assert_one_error(run_pianta("predict", explored, tmp_path / "cut.json"), "corr")

    @pytest.mark.slow
    def test_a_folder_with_other_samples(self, explored, model, tmp_path):
        assert run_pianta("predict", explored, model, "-n", 2, "-q", "-o", tmp_path / "new").code == 0
        before = list_files(tmp_path / "new")
        outcome = run_pianta("predict", explored, model, "-n", 1, "-o", tmp_path / "new")
        assert_one_error(outcome, "sample-002")
        assert list_files(tmp_path / "new") == before


class TestExploreFloor:
    def test_keeps_names_and_numbers_doors_that_have_one_name(self):
        """Rooms are named 2-1 and 1, and a door of 2 leads to 1: the unknown room behind it gets another name."""
        graph = make_wing("CC")
        graph.add_edge(1, 3, label=None)
        graph.nodes[3]["label"] = "CLOSET"
        graph = nx.relabel_nodes(graph, {0: "hub", 1: "2", 2: "2-1", 3: "1"})
        floor = reveal_corridors(graph, SCHOOL, corridors=1)
        assert set(floor.graph) == {"hub", "2", "2-1", "1"}
        assert floor.behind == {"2-1'": "1"}
        assert floor.unknown == ("1",)
        assert floor.counts == {"CLOSET": 1}
        assert floor.shares == {"CLOSET": 1.0}
        assert floor.area is None
        assert set(floor.part.edges("2")) == {("2", "hub"), ("2", "2-1'")}

    def test_sums_areas(self):
        graph = make_wing("CC")
        nx.set_node_attributes(graph, 2.5, "area")
        assert reveal_corridors(graph, SCHOOL, corridors=1).area == 7.5

    def test_refuses_what_no_model_takes(self):
        graph = make_wing("CC")
        with pytest.raises(OptionError, match="explore"):
            reveal_corridors(graph, SCHOOL, corridors=0)
        graph.nodes[1]["label"] = None
        with pytest.raises(LabelError, match="label"):
            reveal_corridors(graph, SCHOOL, corridors=1)


def assert_one_error(outcome, fragment: str) -> None:
    assert outcome.code == 2
    assert not outcome.out
    (line,) = [line for line in outcome.err.splitlines() if line]
    assert line.startswith("error: ")
    assert fragment in line
