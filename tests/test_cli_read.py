"""`pianta read` as a user runs it."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from io import StringIO
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from rich.console import Console
from shapely import LineString, box

from pianta import __version__
from pianta.cli import main
from pianta.cli.reading_text import tabulate_rooms
from pianta.errors import PiantaError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.io._folders import atomic_folder
from pianta.io.floors import read_floor
from pianta.io.graphs import read_graph
from pianta.io.ros_maps import save_ros_map
from pianta.layout.reconstruct import METHODS
from pianta.reading.read import name_folders
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.scan import make_sample, simulate_map
from tests.command_line import list_files, run_pianta

OUTPUTS = {"floor.geojson", "rooms.png", "graph.json", "picture.png", "grid.npz"}
HEAVY = {"cv2", "sklearn", "skimage", "matplotlib"}


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The map.yaml of the sample."""
    path = tmp_path_factory.mktemp("sample") / "map.yaml"
    save_ros_map(make_sample()[1], path)
    return path


@pytest.fixture(scope="module")
def sample_out(sample: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The output folder of `pianta read` for the sample."""
    out = tmp_path_factory.mktemp("out") / "building"
    assert run_pianta("read", sample, "-o", out, "--quiet") == (0, "", "")
    return out


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The map.yaml of a corridor with four rooms."""
    path = tmp_path_factory.mktemp("small") / "small.yaml"
    save_ros_map(simulate_map(make_corridor_floor(length=10, room_width=(5, 5))), path)
    return path


def write_uniform_map(cell: int, shape: tuple[int, int] = (200, 300)) -> Callable[[Path], object]:
    def write(folder: Path) -> Path:
        save_ros_map(GridMap(np.full(shape, cell, np.int8), 0.05), folder / "map.yaml")
        return folder / "map.yaml"

    return write


def write_changed_yaml(**changes: object) -> Callable[[Path], object]:
    """A valid map whose YAML has other values; None removes a key."""

    def write(folder: Path) -> Path:
        path = folder / "map.yaml"
        save_ros_map(GridMap(np.zeros((20, 20), np.int8), 0.05), path)
        keys = yaml.safe_load(path.read_text()) | changes
        path.write_text(yaml.safe_dump({key: value for key, value in keys.items() if value is not None}))
        return path

    return write


def write_bytes(name: str, content: bytes) -> Callable[[Path], object]:
    def write(folder: Path) -> Path:
        (folder / name).write_bytes(content)
        return folder / name

    return write


def write_half_an_image(folder: Path) -> Path:
    path = folder / "map.yaml"
    save_ros_map(make_sample()[1], path)
    image = path.with_suffix(".png")
    image.write_bytes(image.read_bytes()[: image.stat().st_size // 2])
    return path


BAD_INPUTS = {
    "missing file": (lambda folder: folder / "none.yaml", ["none.yaml' does not exist"]),
    "missing YAML keys": (
        write_changed_yaml(resolution=None, origin=None),
        ["resolution is missing", "origin is missing"],
    ),
    "wrong YAML keys": (
        write_changed_yaml(resolution="wide", negate="maybe", mode="odd"),
        ["resolution is 'wide'", "negate is 'maybe'", "mode is 'odd'"],
    ),
    "no YAML": (write_bytes("map.yaml", b"{"), ["map.yaml' is no YAML"]),
    "no image": (write_bytes("map.png", b"no image"), ["map.png' is no image"]),
    "unknown format": (write_bytes("map.txt", b"?"), ["map.txt' is of no known kind"]),
    "empty file": (write_bytes("map.yaml", b""), ["map.yaml' is empty"]),
    "zero resolution": (write_changed_yaml(resolution=0), ["resolution is '0'"]),
    "negative resolution": (write_changed_yaml(resolution=-0.05), ["resolution is '-0.05'"]),
    "1 × 1 map": (write_uniform_map(FREE, (1, 1)), ["map.yaml'"]),
    "all unknown": (write_uniform_map(UNKNOWN), ["map.yaml'"]),
    "all free": (write_uniform_map(FREE), ["map.yaml'"]),
    "all occupied": (write_uniform_map(OCCUPIED), ["map.yaml'"]),
    "huge image": (write_bytes("map.pgm", b"P5 30000 30000 255\n\0"), ["900000000", "300000000", "--max-cells"]),
    "image missing": (write_changed_yaml(image="none.png"), ["none.png' does not exist"]),
    "NaN in the origin": (write_changed_yaml(origin=[0.0, float("nan"), 0.0]), ["origin is", "three finite numbers"]),
    "half an image": (write_half_an_image, ["map.png' is damaged"]),
    "folder": (lambda folder: folder, ["has no map or plan, give one with a map.yaml"]),
    "address": (lambda _: "https://example.org/map.yaml", ["'https://example.org/map.yaml' is an address"]),
    "a name too long for a file": (lambda _: "n" * 5000, ["File name too long"]),
}


@pytest.mark.slow
@pytest.mark.parametrize(("write", "fragments"), BAD_INPUTS.values(), ids=BAD_INPUTS)
def test_bad_input_is_one_line_and_writes_nothing(tmp_path, write, fragments):
    (tmp_path / "in").mkdir()
    options = ["--resolution", "0.05"] if "map.p" in str(path := write(tmp_path / "in")) else []
    code, out, err = run_pianta("read", path, *options, "-o", tmp_path / "out" / "deep")
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert line.startswith("error: ")
    assert all(text in line for text in fragments), line
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


@pytest.mark.parametrize(
    ("options", "remedy"), [([], "; if it is a floor plan, give --as plan"), (["--as", "map"], "")]
)
def test_an_image_without_a_resolution_may_be_a_plan(sample, tmp_path, options, remedy):
    """Unless the user says that it is a map."""
    image = tmp_path / "scan.png"
    Image.open(sample.with_suffix(".png")).save(image)
    code, _, err = run_pianta("read", image, *options, "-o", tmp_path / "out")
    assert code == 2
    assert err.endswith(f"give its map.yaml, or the metres per cell by --resolution{remedy}\n")


@pytest.mark.parametrize("resolution", ["0", "-1", "nan", "inf"])
def test_a_resolution_without_meaning_is_refused(tmp_path, resolution):
    Image.new("L", (9, 9)).save(tmp_path / "scan.png")
    code, _, err = run_pianta("read", tmp_path / "scan.png", "--resolution", resolution, "-o", tmp_path / "out")
    assert code == 2
    assert err.startswith("error: resolution is ")


def test_an_unknown_method_is_refused_with_a_list_of_methods(small, tmp_path):
    code, out, err = run_pianta("read", small, "-o", tmp_path / "out", "--method", "magic")
    assert (code, out, err) == (2, "", f"error: method is 'magic', give one of {', '.join(METHODS)}\n")
    assert not list(tmp_path.iterdir())


def test_an_output_folder_that_is_a_file_is_refused_before_the_map_is_read(tmp_path):
    (tmp_path / "file").touch()
    for out in ("file", "file/deep"):
        code, _, err = run_pianta("read", "missing.yaml", "-o", tmp_path / out)
        assert code == 2
        assert err.endswith("file' is a file, give another folder\n")
        assert len(err.splitlines()) == 1


@pytest.mark.slow
def test_the_outputs_describe_the_same_floor(sample, sample_out):
    assert {path.name for path in sample_out.iterdir()} == OUTPUTS
    floor = read_floor(sample_out / "floor.geojson")
    assert floor.source == "map.yaml"
    ids = {room.id for room in floor.rooms}
    assert len(ids) > 10
    grid = make_sample()[1]
    labels = np.array(Image.open(sample_out / "rooms.png"))
    assert labels.shape == grid.shape
    assert set(np.unique(labels)) == ids | {0}
    assert (labels == floor.label_image(grid)).all()
    graph = read_graph(sample_out / "graph.json")
    assert set(graph) == ids
    assert nx.utils.graphs_equal(graph, nx.node_link_graph(json.loads((sample_out / "graph.json").read_text())))
    assert {tuple(sorted(edge)) for edge in graph.edges} == {door.rooms for door in floor.doors}
    with Image.open(sample_out / "picture.png") as picture:
        assert max(picture.size) in (1599, 1600)


@pytest.mark.slow
def test_reading_again_gives_the_same_bytes_and_keeps_other_files(sample, sample_out, tmp_path):
    for name in ("floor.geojson", "notes.txt"):
        (tmp_path / name).write_text("older")
    run_pianta("read", sample, "-o", tmp_path)
    assert list_files(tmp_path) == list_files(sample_out) | {"notes.txt": b"older"}


@pytest.mark.slow
def test_the_table_and_the_summary_are_printed(small, tmp_path):
    code, out, err = run_pianta("read", small, "-o", tmp_path / "out")
    assert (code, err) == (0, "")
    floor = read_floor(tmp_path / "out" / "floor.geojson")
    for room in floor.rooms:
        assert any(line.split()[:2] == [str(room.id), f"{room.polygon.area:.1f}"] for line in out.splitlines())
    assert out.splitlines()[-1].startswith(f"{len(floor.rooms)} rooms, ")
    assert out.endswith(f" m², in {tmp_path / 'out'}\n")


def test_table_names_doors_neighbours_labels_and_partial_rooms():
    floor = Floor(
        rooms=(Room(1, box(0, 0, 4, 3), "LAB"), Room(2, box(5, 0, 6, 3)), Room(3, box(8, 0, 9, 9), partial=True)),
        doors=tuple(Door((1, other), LineString([(0, 0), (0, 1)]), 1) for other in (3, 2, 2)),
    )
    console = Console(file=StringIO(), width=80)
    console.print(tabulate_rooms(floor))
    assert isinstance(console.file, StringIO)
    rows = [line.split() for line in console.file.getvalue().splitlines()]
    assert ["room", "area", "m²", "doors", "neighbours", "label", "seen"] in rows
    assert ["1", "12.0", "3", "2", "3", "LAB"] in rows
    assert ["2", "3.0", "2", "1"] in rows
    assert ["3", "9.0", "1", "1", "in", "part"] in rows


def test_the_table_has_names_when_a_room_has_one():
    console = Console(width=80, record=True)
    rooms = Room(1, box(0, 0, 4, 3), name="[b]204 French"), Room(2, box(4, 0, 8, 3))
    console.print(tabulate_rooms(Floor(rooms)))
    rows = [line.split() for line in console.export_text().splitlines() if line.strip()]
    assert (rows[0], rows[2]) == (["room", "area", "m²", "doors", "name"], ["1", "12.0", "0", "[b]204", "French"])


def test_the_table_has_the_probabilities_of_rooms_when_they_are_known():
    console = Console(width=80, record=True)
    rooms = Room(1, box(0, 0, 4, 3), probability=0.876), Room(2, box(4, 0, 8, 3))
    console.print(tabulate_rooms(Floor(rooms)))
    rows = [line.split() for line in console.export_text().splitlines() if line.strip()]
    assert (rows[0], rows[2]) == (["room", "area", "m²", "doors", "sure"], ["1", "12.0", "0", "0.88"])


def test_the_table_has_the_probabilities_of_labels_within_80_columns():
    probabilities = {"school": {"SMALL ADMINISTRATIVE": 0.834, "CORRIDOR": 1.0}}
    labels = "CORRIDOR", "SMALL ADMINISTRATIVE", "LAB"
    rooms = [Room(i, box(0, 0, 4, 3), label, {}, probabilities) for i, label in enumerate(labels, start=1)]
    doors = tuple(Door((1, other), LineString([(0, 0), (0, 1)]), 1) for other in (2, 3))
    others = Door((1, 4), LineString([(0, 0), (0, 1)]), 1, "opening"), Door((4, None), LineString([(0, 0), (0, 1)]), 1)
    console = Console(file=StringIO(), width=80)
    console.print(tabulate_rooms(Floor(tuple(rooms), doors)))
    assert isinstance(console.file, StringIO)
    lines = [" ".join(line.split()) for line in console.file.getvalue().splitlines()]
    rows = ["1 12.0 2 2 3 CORRIDOR 1.00", "2 12.0 1 1 SMALL ADMINISTRATIVE 0.83", "3 12.0 1 1 LAB"]
    assert lines[3:6] == rows
    console.print(tabulate_rooms(Floor((*rooms, Room(4, box(0, 0, 9, 9), partial=True)), (*doors, *others))))
    assert "…" not in console.file.getvalue()
    assert max(map(len, console.file.getvalue().splitlines())) <= 80


@pytest.mark.slow
def test_walls_and_graph_change_the_picture_only(sample, sample_out, tmp_path):
    run_pianta("read", sample, "-o", tmp_path, "--walls", "--graph")
    changed = {name for name, content in list_files(tmp_path).items() if content != list_files(sample_out)[name]}
    assert changed == {"picture.png"}


@pytest.mark.slow
def test_an_image_is_read_with_a_resolution(tmp_path):
    grid = simulate_map(make_corridor_floor(length=10, room_width=(5, 5)))
    greys = np.select([grid.free, grid.occupied], [254, 0], 205).astype(np.uint8)
    Image.fromarray(greys).save(tmp_path / "scan.png")
    code, _, err = run_pianta("read", tmp_path / "scan.png", "-o", tmp_path / "out")
    assert code == 2
    assert "--resolution" in err
    assert run_pianta("read", tmp_path / "scan.png", "--resolution", "0.05", "-o", tmp_path / "out").code == 0
    assert read_floor(tmp_path / "out" / "floor.geojson").rooms


@pytest.mark.slow
def test_a_warning_is_one_line_on_stderr(small, tmp_path):
    keys = yaml.safe_load(small.read_text())
    image = small.with_suffix(".png")
    (tmp_path / "old.yaml").write_text(yaml.safe_dump(keys | {"free_thresh": 0.25, "image": str(image)}))
    code, _, err = run_pianta("read", tmp_path / "old.yaml", "-o", tmp_path / "out", "--quiet")
    assert code == 0
    (line,) = err.splitlines()
    assert line.startswith("warning: map ")
    assert "--trust-thresholds" in line


@pytest.mark.slow
def test_a_map_over_the_limit_is_read_when_the_limit_is_lifted(small, tmp_path):
    assert run_pianta("read", small, "-o", tmp_path / "out", "--max-cells", "99").code == 2
    with Image.open(small.with_suffix(".png")) as image:
        cells = image.width * image.height
    assert run_pianta("read", small, "-o", tmp_path / "out", "--max-cells", cells).code == 0


@pytest.mark.slow
def test_several_maps_get_a_folder_each(sample, sample_out, small, tmp_path):
    code, out, err = run_pianta("read", sample, small, "-o", tmp_path)
    assert (code, err) == (0, "")
    assert {path.name for path in tmp_path.iterdir()} == {"map", "small", "journal.sqlite"}
    assert list_files(tmp_path / "map") == list_files(sample_out)
    assert list_files(tmp_path / "small").keys() == OUTPUTS
    assert [line.rpartition(" ")[2] for line in out.splitlines()[:2]] == [
        str(tmp_path / "map"),
        str(tmp_path / "small"),
    ]
    assert out.splitlines()[2:] == ["2 of 2 files read"]


@pytest.mark.slow
def test_a_bad_map_does_not_stop_the_others(small, tmp_path):
    code, out, err = run_pianta("read", "none.yaml", small, "other.yaml", "-o", tmp_path / "out")
    assert code == 1
    assert [line.split()[:3] for line in err.splitlines()] == [
        ["error:", "map", "'none.yaml'"],
        ["error:", "map", "'other.yaml'"],
    ]
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"small", "journal.sqlite"}
    assert out.splitlines()[-2:] == ["1 of 3 files read", "faults: map 2"]


def test_a_batch_of_bad_maps_has_a_journal_alone(tmp_path):
    assert run_pianta("read", "a.yaml", "b.yaml", "-o", tmp_path / "out").code == 1
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["journal.sqlite"]


@pytest.mark.slow
def test_a_batch_shows_its_progress_in_a_terminal(small, tmp_path, monkeypatch):
    terminal = StringIO()
    monkeypatch.setattr("pianta.cli.terminal.stderr", Console(file=terminal, force_terminal=True, width=80))
    run_pianta("read", small, "none.yaml", "-o", tmp_path)
    assert "1 failed" in terminal.getvalue()
    assert "0/2" in terminal.getvalue()


@pytest.mark.slow
def test_results_are_printed_on_their_own_lines_above_the_progress_bar(small, tmp_path, monkeypatch):
    other = tmp_path / "other.yaml"
    save_ros_map(simulate_map(make_corridor_floor(length=10, room_width=(5, 5))), other)
    terminal = StringIO()
    monkeypatch.setattr(terminal, "isatty", lambda: True, raising=False)
    monkeypatch.setattr("sys.stdout", terminal)
    monkeypatch.setattr("pianta.cli.terminal.stderr", Console(file=terminal, force_terminal=True, width=200))
    with pytest.raises(SystemExit):
        main(["read", str(small), str(other), "-o", str(tmp_path / "out")])
    erased_line, style = r"\x1b\[2K", r"(\x1b\[[\d;]*m)*"
    assert len(re.findall(rf"{erased_line}{style}\d+{style} rooms, ", terminal.getvalue())) == 2


@pytest.mark.parametrize(
    ("maps", "names"),
    [
        (["a/x.yaml", "b/y.png"], ["x", "y"]),
        (["a/map.yaml", "b/map.yaml", "c.yaml"], ["a-map", "b-map", "c"]),
        (["a/map.yaml", "a/Map.png", "a/map.yaml"], ["a-map", "a-Map-2", "a-map-3"]),
        (["a/map.yaml", "b/map.yaml", "b-map.yaml"], ["a-map", "b-map", "b-map-2"]),
        (["...yaml", ".hidden.yaml", "v1.2.yaml"], ["map", "hidden", "v1.2"]),
    ],
)
def test_folders_are_named_after_the_maps(maps, names):
    assert name_folders(maps) == names


@pytest.mark.slow
@given(st.lists(st.text(st.sampled_from("aA./-2"), min_size=1), max_size=8))
def test_folder_names_differ_and_stay_in_the_output_folder(maps):
    names = name_folders(maps)
    assert len({name.casefold() for name in names}) == len(maps)
    assert all(name and "/" not in name and not name.startswith(".") for name in names)


@pytest.mark.slow
@pytest.mark.parametrize("failure", [KeyboardInterrupt, PiantaError("disk full"), OSError(28, "No space left")])
@pytest.mark.parametrize("older", [{}, {"rooms.png": b"older", "notes.txt": b"mine"}])
def test_a_failure_in_the_middle_leaves_the_folder_as_it_was(small, tmp_path, monkeypatch, failure, older):
    def fail(*_: object, **__: object) -> None:
        raise failure

    monkeypatch.setattr("pianta.plot.figure.save_figure", fail)
    out = tmp_path / "out"
    for name, content in older.items():
        out.mkdir(exist_ok=True)
        (out / name).write_bytes(content)
    assert run_pianta("read", small, "-o", out).code not in (0, None)
    assert list_files(tmp_path) == {f"out/{name}": content for name, content in older.items()}
    assert out.exists() == bool(older)


def test_a_folder_with_the_name_of_an_output_file_prevents_all_outputs(small, tmp_path):
    (tmp_path / "rooms.png").mkdir()
    code, _, err = run_pianta("read", small, "-o", tmp_path)
    assert code == 2
    assert err.endswith("rooms.png': it is a folder, give another output folder\n")
    assert [path.name for path in tmp_path.iterdir()] == ["rooms.png"]


def test_files_that_are_written_together_appear_together(tmp_path):
    with atomic_folder(tmp_path / "new" / "out") as temporary:
        (temporary / "one").touch()
        assert list_files(tmp_path).keys() == {f"new/{temporary.name}/one"}
    assert list_files(tmp_path).keys() == {"new/out/one"}


def run_process(*arguments: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, env=environment, check=False, timeout=60
    )


@pytest.mark.slow
@pytest.mark.parametrize("argument", ["--help", "--version"])
def test_starting_up_imports_nothing_heavy(argument):
    code = (
        "import sys; from pianta.cli import main\n"
        f"try: main(['{argument}'])\n"
        f"finally: print('heavy:', *sorted({HEAVY} & sys.modules.keys()))"
    )
    process = run_process("-c", code)
    assert (process.returncode, process.stderr) == (0, "")
    assert process.stdout.splitlines()[-1] == "heavy:"


@pytest.mark.slow
def test_reading_never_imports_pyplot(small, tmp_path):
    code = (
        "import sys; from pianta.cli import main\n"
        f"try: main(['read', {str(small)!r}, '-o', {str(tmp_path)!r}, '-q'])\n"
        "finally: print('matplotlib' in sys.modules, 'matplotlib.pyplot' in sys.modules)"
    )
    process = run_process("-c", code)
    assert (process.returncode, process.stdout, process.stderr) == (0, "True False\n", "")


@pytest.mark.slow
def test_the_process_exits_as_documented():
    process = run_process("-m", "pianta", "read", "none.yaml", "-o", "none")
    assert (process.returncode, process.stdout) == (2, "")
    assert process.stderr == "error: map 'none.yaml' does not exist, check the path\n"
    process = run_process("-m", "pianta", "--version")
    assert (process.returncode, process.stdout) == (0, f"pianta {__version__}\n")


@pytest.mark.parametrize("verb", ["read", "world"])
def test_help_has_examples(verb):
    assert f"\n pianta {verb} " in run_pianta(verb, "--help").out


def test_the_map_itself_is_never_replaced(small, tmp_path):
    image = tmp_path / "rooms.png"
    image.write_bytes(small.with_suffix(".png").read_bytes())
    before = image.read_bytes()
    outcome = run_pianta("read", image, "--resolution", "0.05", "-o", tmp_path)
    assert outcome.code == 2
    assert "would be replaced" in outcome.err
    assert image.read_bytes() == before
