"""`pianta bench` as a user runs it."""

import json
import subprocess
import sys
from io import StringIO
from itertools import product
from statistics import fmean

import pytest
from rich.console import Console

from pianta import __version__
from pianta.errors import MapError
from pianta.layout.reconstruct import METHODS
from pianta_bench.data.folders import SET_NAMES
from pianta_bench.layout import timing
from tests.command_line import list_files, run_pianta
from tests.tiny_data import TRUE_FLOOR, write_all_sets

BENCHES = ("layout", "segmentation")
KEYS = {
    "layout": ("a_fc_free", "a_bc_free", "a_fc_walls", "a_bc_walls", "mean_iou", "f1", "door_precision", "door_recall"),
    "segmentation": ("precision", "recall", "a_fc", "mean_iou", "f1"),
}


@pytest.fixture
def tiny(tmp_path, monkeypatch):
    """A data folder with two maps for each bench; reconstruct is replaced by a function that returns the true rooms."""
    write_all_sets(tmp_path / "data", "a", "b")
    monkeypatch.setattr(timing, "reconstruct", lambda *_, **__: TRUE_FLOOR)
    monkeypatch.delenv("PIANTA_DATA", raising=False)
    return tmp_path / "data"


def rows_of(out: str, *names: str) -> list[list[str]]:
    """The printed rows of these names, split at white space."""
    return [line.split() for line in out.splitlines() if line.split(" ")[0] in names]


@pytest.mark.parametrize("bench", BENCHES)
def test_the_file_holds_what_is_printed(tiny, tmp_path, bench):
    json_file = tmp_path / "new" / "figures.json"
    code, out, err = run_pianta("bench", bench, "--data", tiny, "--method", "thesis", "--json", json_file)
    assert (code, err) == (0, "")
    content = json.loads(json_file.read_text())
    assert (content["pianta"], content["bench"]) == (__version__, bench)
    figures = {(r["part"], r["item"], r["metric"]): r["value"] for r in content["records"]}
    digits = dict.fromkeys(KEYS[bench], 1) | {"found": None, "true": None, "seconds": 2, "transforms": 1}
    expected = []
    for part in dict.fromkeys(item["part"] for item in content["items"]):
        own = [[figures[part, name, metric] for metric in digits] for name in ("a", "b")]
        means = [fmean(column) for column in zip(*own, strict=True)]
        for name, values, default in (("a", own[0], "d"), ("b", own[1], "d"), ("mean", means, ".1f")):
            formats = [default if count is None else f".{count}f" for count in digits.values()]
            expected.append([name, *map(format, values, formats)])
    # A table of many columns is printed in blocks: its rows are joined again.
    rows = [row for row in rows_of(out, "a", "b", "mean") if "±" not in row]
    width = 1 + len(digits)
    joined: dict[tuple[int, str], list[str]] = {}
    for row in rows:
        table = sum(len(full) == width for (_, name), full in joined.items() if name == row[0])
        joined.setdefault((table, row[0]), [row[0]]).extend(row[1:])
    assert [*joined.values()] == expected
    assert len(expected) == 3 * len({item["part"] for item in content["items"]})


@pytest.mark.parametrize("bench", BENCHES)
def test_a_map_that_fails_is_named_and_the_exit_code_is_1(tiny, monkeypatch, tmp_path, bench):
    def fail(*_: object, **__: object) -> None:
        raise MapError("the map shows no room")

    monkeypatch.setattr(timing, "reconstruct", fail)
    json_file = tmp_path / "figures.json"
    code, out, err = run_pianta("bench", bench, "--data", tiny, "--method", "thesis", "--json", json_file)
    assert (code, err) == (1, "")
    content = json.loads((tmp_path / "figures.json").read_text())
    assert {item["failure"] for item in content["items"]} == {"the map shows no room"}
    assert {record["value"] for record in content["records"] if record["metric"] == "found"} == {0}
    assert {record["value"] for record in content["records"] if record["metric"] == "seconds"} == {None}
    for item in content["items"]:
        assert f"{item['item']} failed ({item['part']}): the map shows no room" in out
    true_rooms = {record["part"]: record["value"] for record in content["records"] if record["metric"] == "true"}
    assert set(true_rooms.items()) >= {("schools", 2)}
    assert true_rooms.get("doors", 1) == 1
    cells = [cell for row in rows_of(out, "a") if "failed" not in row for cell in row[1:]]
    scores = ["0.0"] * len(KEYS[bench])
    assert cells == [cell for true in true_rooms.values() for cell in (*scores, "0", str(true), "–", "–")]


@pytest.mark.slow
def test_pictures_are_written_for_every_map(tiny, tmp_path):
    pictures = tmp_path / "new" / "pictures"
    options = "--data", tiny, "--set", "survey", "--set", "schools", "--pictures", pictures
    assert run_pianta("bench", "segmentation", *options).code == 0
    assert list_files(pictures).keys() == {
        f"{method}/{name}/{item}.png" for method in METHODS for name in ("survey", "schools") for item in ("a", "b")
    }


@pytest.mark.slow
def test_all_methods_are_measured_on_all_sets_unless_some_are_named(tiny, tmp_path):
    json_file = tmp_path / "figures.json"
    assert run_pianta("bench", "segmentation", "--data", tiny, "--json", json_file).code == 0
    content = json.loads(json_file.read_text())
    assert content["options"]["methods"] == list(METHODS)
    assert {(record["part"], record["method"]) for record in content["records"]} == {*product(SET_NAMES, METHODS)}
    named = "--set", "clutter", "--method", METHODS[0], "--method", METHODS[0]
    assert run_pianta("bench", "segmentation", "--data", tiny, "--json", json_file, *named).code == 0
    content = json.loads(json_file.read_text())
    assert {(record["part"], record["method"]) for record in content["records"]} == {("clutter", METHODS[0])}


def test_rows_of_the_maps_are_shown_for_several_methods_on_request(tiny, monkeypatch):
    monkeypatch.setattr("pianta_bench.segmentation.measure.METHODS", ("thesis", "distance"))
    arguments = "bench", "segmentation", "--data", tiny, "--set", "clutter"
    assert not rows_of(run_pianta(*arguments).out, "a", "b")
    assert len(rows_of(run_pianta(*arguments, "--maps").out, "a", "b")) == 4
    assert len(rows_of(run_pianta(*arguments, "--method", "thesis").out, "a", "b")) == 2


@pytest.mark.parametrize(
    ("options", "name"),
    [
        (["--set", "attic"], "attic"),
        (["--set", "doors", "--data", "."], "doors"),
    ],
)
def test_a_set_that_is_unknown_or_missing_is_named(tiny, monkeypatch, options, name):
    monkeypatch.chdir(tiny.parent)
    code, out, err = run_pianta("bench", "segmentation", "--data", tiny, *options, "--pictures", tiny.parent / "new")
    assert (code, out) == (2, "")
    assert name in err
    assert len(err.splitlines()) == 1


def test_the_data_are_found_by_the_environment(tiny, monkeypatch):
    monkeypatch.setenv("PIANTA_DATA", str(tiny))
    assert run_pianta("bench", "layout").code == 0


@pytest.mark.slow
@pytest.mark.parametrize("bench", BENCHES)
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ["--data", "none"],
            "--data",
        ),
        (["--data", "."], "data"),
        ([], "../shared/data"),
        (["--method", "magic"], "magic"),
        (["--json", "folder"], "folder"),
        (["--json", "file/figures.json"], "'file'"),
        (["--pictures", "file"], "'file'"),
    ],
)
def test_an_option_without_meaning_is_one_line_before_anything_is_measured(tiny, monkeypatch, bench, options, message):
    def stop(*_: object, **__: object) -> None:
        raise AssertionError("measured")

    monkeypatch.setattr(timing, "reconstruct", stop)
    folder_of_run = tiny.parent / "folder_of_run"
    (folder_of_run / "folder").mkdir(parents=True)
    (folder_of_run / "file").touch()
    monkeypatch.chdir(folder_of_run)
    before = list_files(folder_of_run)
    data = [] if "--data" in options or not options else ["--data", tiny]
    code, out, err = run_pianta("bench", bench, *data, *options)
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert line.startswith("error: ")
    assert message in line
    assert list_files(folder_of_run) == before


def test_progress_is_shown_in_a_terminal_only(tiny, monkeypatch):
    terminal = StringIO()
    monkeypatch.setattr("pianta.cli.terminal.stderr", Console(file=terminal, force_terminal=True, width=80))
    assert run_pianta("bench", "layout", "--data", tiny).code == 0
    assert "0/2" in terminal.getvalue()
    monkeypatch.setattr("pianta.cli.terminal.stderr", Console(file=(pipe := StringIO()), width=80))
    assert run_pianta("bench", "layout", "--data", tiny).code == 0
    assert pipe.getvalue() == ""


@pytest.mark.parametrize("verb", [*BENCHES, "cost"])
def test_help_has_examples(verb):
    assert f"\n pianta bench {verb}" in run_pianta("bench", verb, "--help").out


@pytest.mark.slow
def test_help_imports_nothing_heavy():
    code = (
        "import sys; from pianta.cli import main\n"
        "try: main(['bench', 'layout', '--help'])\n"
        "finally: print('heavy:', *sorted({'cv2', 'sklearn', 'skimage', 'matplotlib'} & sys.modules.keys()))"
    )
    process = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env={"PYTHONPATH": ":".join(sys.path)}, check=True
    )
    assert process.stdout.splitlines()[-1] == "heavy:"
