"""Many generated buildings: parts of a folder each, which are those of one run, and a journal of what is done."""

import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from io import StringIO
from pathlib import Path

import networkx as nx
import pytest
from PIL import Image
from rich.console import Console

import pianta
from pianta.batch import generate_batch as batch_module
from pianta.batch.journal import Entry, Journal
from pianta.errors import OptionError
from pianta.evaluation.graph_sets import find_fingerprints
from pianta.generation.type_model import TypeModel, learn_type
from pianta.generation.type_model_file import save_type_model
from pianta.io.graphs import read_graph
from tests.command_line import list_files, run_pianta
from tests.generated_types import SCHOOL, make_schools, sized_model


@pytest.fixture(scope="module")
def model():
    """The model of the schools, with short chains."""
    return replace(learn_type(make_schools(), SCHOOL), sweeps=5, edge_moves=20, door_moves=5)


@pytest.fixture
def small_parts(monkeypatch):
    monkeypatch.setattr(batch_module, "PART", 3)


def generate(model: TypeModel, count: int, out: Path, **options) -> dict[str, pianta.BatchItem]:
    return {item.folder.name: item for item in pianta.generate_batch(model, count, out=out, **options)}


def read_parts(out: Path) -> list[nx.Graph]:
    return [read_graph(file) for file in sorted(out.glob("part-*/building-*.json"))]


@pytest.mark.usefixtures("small_parts")
class TestGenerateBatch:
    def test_the_parts_have_the_buildings_of_generate(self, model, tmp_path):
        parts = generate(model, 8, tmp_path / "out", seed=4)
        assert [*parts] == ["part-0001", "part-0002", "part-0003"]
        assert all(item.fault is None and item.is_new for item in parts.values())
        written, expected = read_parts(tmp_path / "out"), pianta.generate(model, 8, seed=4)
        assert find_fingerprints(written) == find_fingerprints(expected)
        assert [graph.graph["source"] for graph in written] == [f"building-{number:06}" for number in range(1, 9)]
        assert parts["part-0003"].description["rooms"] == [len(graph) for graph in expected[6:]]
        assert (tmp_path / "out" / "part-0003" / "sheet.png").is_file()

    def test_what_is_done_is_not_done_again_unless_options_change(self, model, tmp_path):
        out = tmp_path / "out"
        generate(model, 6, out)
        assert [item.is_new for item in generate(model, 6, out).values()] == [False, False]
        assert [item.is_new for item in generate(model, 6, out, seed=1).values()] == [True, True]
        assert [item.is_new for item in generate(replace(model, sweeps=6), 6, out, seed=1).values()] == [True, True]
        school = make_schools()[0]
        assert [item.is_new for item in generate(model, 6, out, similar_to=school).values()] == [True, True]
        assert [item.is_new for item in generate(model, 6, out, similar_to=school).values()] == [False, False]

    def test_more_buildings_are_added_to_those_that_are_there(self, model, tmp_path):
        generate(model, 4, tmp_path / "out")
        parts = generate(model, 7, tmp_path / "out")
        assert {name: item.is_new for name, item in parts.items()} == {
            "part-0001": False,
            "part-0002": True,
            "part-0003": True,
        }
        generate(model, 7, tmp_path / "whole")
        files = {name: content for name, content in list_files(tmp_path / "out").items() if "journal" not in name}
        others = {name: content for name, content in list_files(tmp_path / "whole").items() if "journal" not in name}
        assert files == others

    def test_fewer_buildings_than_are_there_are_refused(self, model, tmp_path):
        generate(model, 7, tmp_path / "out")
        fault = r"part-0002' has building-000005, which is not among 4 buildings in parts; give as many as before"
        with pytest.raises(OptionError, match=fault):
            generate(model, 4, tmp_path / "out")

    def test_buildings_that_the_journal_does_not_have_are_not_mixed_with_others(self, model, tmp_path):
        generate(model, 7, tmp_path / "out", shard="1/1")
        (tmp_path / "out" / "journal-1-of-1.sqlite").unlink()
        with pytest.raises(OptionError, match="part-0002' has building-000005, which is not among 4"):
            generate(model, 4, tmp_path / "out")
        with pytest.raises(OptionError, match=r"part-0001' has results that .* not know \(of 3 such folders\); move"):
            generate(model, 8, tmp_path / "out")
        generate(model, 8, tmp_path / "out", resume=False)
        assert len(read_parts(tmp_path / "out")) == 8

    def test_buildings_outside_parts_are_not_mixed_with_parts(self, model, tmp_path):
        names = ["building-001", "building-002"]
        batch_module.save_buildings(pianta.generate(model, 2), names, model, tmp_path)
        with pytest.raises(OptionError, match="has building-001, which is not among 4 buildings in parts"):
            generate(model, 4, tmp_path)

    def test_the_folder_of_another_command_is_refused(self, model, tmp_path):
        with Journal(tmp_path / "journal.sqlite") as journal:
            journal.record(Entry("/a.yaml", "a", "", "", "", 1.0))
        with pytest.raises(OptionError, match=r"has the journal of `pianta read`, give another output folder"):
            generate(model, 4, tmp_path)
        generate(model, 4, tmp_path / "out")
        with pytest.raises(OptionError, match=r"has the journal of `pianta generate`, give another output folder"):
            pianta.collect_batch(tmp_path / "out")

    def test_shards_are_parts_of_all(self, model, tmp_path):
        for shard in ("1/2", "2/2"):
            generate(model, 8, tmp_path / "out", shard=shard)
        generate(model, 8, tmp_path / "whole")
        assert find_fingerprints(read_parts(tmp_path / "out")) == find_fingerprints(read_parts(tmp_path / "whole"))

    def test_repeats_are_counted_over_all_parts(self, model, tmp_path):
        items = [*generate(model, 9, tmp_path / "out").values()]
        fingerprints = find_fingerprints(pianta.generate(model, 9))
        assert batch_module.count_repeats(items) == 9 - len(set(fingerprints))

    @pytest.mark.slow
    def test_steps_of_a_part_are_tracked(self, tmp_path):
        """Two small buildings, which are also drawn and furnished."""
        messages = []

        def track(names: Sequence[str]) -> Iterator[str]:
            for name in names:
                messages.append(name)
                yield name

        short = replace(sized_model(), sweeps=5, edge_moves=20, door_moves=5)
        generate(short, 2, tmp_path / "out", rooms=(7, 8), worlds=True, furniture=0.0, track=track)
        steps = ("functional areas", "functional graphs", "doors")
        assert messages == [
            *(f"buildings 1 to 2: {step}" for step in steps),
            "plan 1",
            "plan 2",
            "picture of building-000001",
            "picture of building-000002",
            "world 1",
            "world 2",
        ]

    @pytest.mark.parametrize(
        ("count", "options", "fault"),
        [
            (0, {}, "0 buildings are wanted"),
            (100_001, {}, "give 1 to 100000"),
            (3, {"seed": -1}, "seed is -1"),
            (3, {"shard": "3/2"}, "shard is '3/2'"),
            (3, {"jobs": 0}, "jobs is 0"),
        ],
    )
    def test_options_out_of_range_are_refused(self, model, tmp_path, count, options, fault):
        with pytest.raises(OptionError, match=fault):
            generate(model, count, tmp_path / "out", **options)
        assert not (tmp_path / "out").exists()


def test_a_fingerprint_depends_on_labels_and_doors_alone():
    one, other, *_ = make_schools()
    renamed = one.copy()
    renamed.graph.clear()
    changed = one.copy()
    changed.nodes[1]["label"] = "GYM"
    first, same, second, third = find_fingerprints([one, renamed, other, changed])
    assert first == same
    assert len({first, second, third}) == 3


@pytest.fixture(scope="module")
def model_file(model, tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "school.json"
    save_type_model(model, path)
    return path


def test_a_terminal_shows_the_parts_and_the_steps_of_one(model_file, tmp_path, monkeypatch):
    terminal = StringIO()
    monkeypatch.setattr("pianta.cli.terminal.stderr", Console(file=terminal, force_terminal=True, width=120))
    outcome = run_pianta("generate", model_file, "-n", 2, "--shard", "1/1", "-o", tmp_path / "out")
    assert outcome.code == 0
    assert outcome.out.splitlines()[0].startswith(f"{tmp_path / 'out' / 'part-0001'}: 2 buildings, ")
    for text in ("0/1", "buildings 1 to 2: functional areas", "buildings 1 to 2: doors"):
        assert text in terminal.getvalue()


@pytest.mark.slow
class TestCommand:
    def test_more_than_a_thousand_are_in_parts(self, model_file, tmp_path):
        command = [
            sys.executable,
            "-m",
            "pianta",
            "generate",
            str(model_file),
            "-n",
            "1002",
            "-o",
            "out",
            "--jobs",
            "2",
        ]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        *parts, counted, sizes, copies, where = done.stdout.splitlines()
        first, second = sorted(parts)
        assert first.startswith("out/part-0001: 1000 buildings, ")
        assert second.startswith("out/part-0002: 2 buildings, ")
        assert counted == "2 of 2 parts generated"
        assert sizes.startswith("1002 buildings of type school, ")
        assert copies.startswith("copies of a floor of the model: ")
        assert where == "in out: part-*, each with building-*.json, building-*.graphml, sheet.png"
        assert len(read_parts(tmp_path / "out")) == 1002
        again = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert again.stdout.splitlines() == [
            "2 of 2 parts generated, 2 of them before; --no-resume generates them again",
            sizes,
            copies,
            where,
        ]

    def test_plans_are_floors_with_the_doors_of_the_graphs(self, model, tmp_path):
        schools = make_schools()
        for school in schools:
            nx.set_node_attributes(school, 30.0, "area")
        save_type_model(replace(learn_type(schools, SCHOOL), sweeps=5), tmp_path / "school.json")
        command = ("generate", tmp_path / "school.json", "-n", 2, "--plans", "-o")
        outcome = run_pianta(*command, tmp_path / "out")
        assert outcome.code == 0, outcome.err
        assert outcome.out.splitlines()[-1].endswith("building-*.geojson, building-*.png, plans.png")
        for number in (1, 2):
            floor = pianta.read_floor(tmp_path / "out" / f"building-{number:03}.geojson")
            graph = read_graph(tmp_path / "out" / f"building-{number:03}.json")
            assert nx.is_isomorphic(floor.graph(), graph, node_match=lambda one, other: one["label"] == other["label"])
            with Image.open(tmp_path / "out" / f"building-{number:03}.png") as picture:
                assert max(picture.size) >= 1600
        with Image.open(tmp_path / "out" / "plans.png") as sheet:
            assert (sheet.width, sheet.height > 500) == (1280, True)
        assert run_pianta(*command, tmp_path / "two", "--jobs", 2).code == 0
        assert list_files(tmp_path / "two") == list_files(tmp_path / "out")
        assert run_pianta(*command, tmp_path / "parts", "--shard", "1/1").code == 0
        part = tmp_path / "parts" / "part-0001"
        assert [
            pianta.read_floor(part / f"building-{number:06}.geojson").rooms
            == pianta.read_floor(tmp_path / "out" / f"building-{number:03}.geojson").rooms
            for number in (1, 2)
        ] == [True, True]
        assert run_pianta(*command[:4], "-o", tmp_path / "out").code == 0
        assert {path.suffix for path in (tmp_path / "out").iterdir()} == {".json", ".graphml", ".png"}
        assert not (tmp_path / "out" / "plans.png").exists()

    def test_a_model_without_areas_cannot_draw_plans(self, model_file, tmp_path):
        code, out, err = run_pianta("generate", model_file, "-n", 1, "--plans", "-o", tmp_path / "out")
        assert (code, out, len(err.splitlines())) == (2, "", 1)
        assert "the model has no areas of rooms" in err
        assert not (tmp_path / "out").exists()

    def test_few_buildings_are_not_written_beside_parts(self, model_file, tmp_path):
        outcome = run_pianta("generate", model_file, "-n", 2, "-o", tmp_path, "--shard", "1/1", "-q")
        assert outcome.code == 0, outcome.err
        (tmp_path / "journal-1-of-1.sqlite").unlink()
        code, out, err = run_pianta("generate", model_file, "-n", 2, "-o", tmp_path)
        assert (code, out) == (2, "")
        assert "has buildings in parts, part-0001; give another folder" in err

    def test_what_cannot_be_met_and_a_bad_folder_are_one_line(self, model_file, tmp_path):
        arguments = ("generate", model_file, "-n", 4, "--shard", "1/1", "-o")
        outcome = run_pianta(*arguments, tmp_path / "out", "--rooms", "900")
        assert (outcome.code, outcome.out, len(outcome.err.splitlines())) == (2, "", 1)
        assert "900" in outcome.err
        (tmp_path / "file").write_text("")
        outcome = run_pianta(*arguments, tmp_path / "file" / "out")
        assert (outcome.code, outcome.out, len(outcome.err.splitlines())) == (2, "", 1)
        assert not (tmp_path / "out").exists()
