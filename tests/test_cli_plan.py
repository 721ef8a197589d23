"""Plans on the command line: pianta read plan.png, as a user runs it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from shapely import box

from pianta._types import Colors
from pianta.floor import Floor, Room
from pianta.floor.area_trust import AreaTrust
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io.floors import read_floor
from pianta.plan import read_plan as plan_reading
from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.text.recognition import read_texts
from pianta.reading._reader import Reader
from pianta.reading.reading import OUTPUTS, StoreyReading
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.plans.drawing import draw_plan
from tests.command_line import list_files, run_pianta
from tests.test_map_or_plan import NO_DRAWINGS

PX_PER_METRE = 30.0


@pytest.fixture(scope="module")
def texts_of_sheets() -> dict[bytes, tuple[PlacedText, ...]]:
    """A cache of the texts of sheets, by their pixels."""
    return {}


@pytest.fixture(autouse=True)
def texts_are_read_once(texts_of_sheets: dict[bytes, tuple[PlacedText, ...]], monkeypatch: pytest.MonkeyPatch) -> None:
    """Caches the texts of sheets: reading them is slow, and many tests read the same plan."""

    def read_once(colors: Colors) -> tuple[PlacedText, ...]:
        key = repr(colors.shape).encode() + colors.tobytes()
        if key not in texts_of_sheets:
            texts_of_sheets[key] = read_texts(colors)
        return texts_of_sheets[key]

    monkeypatch.setattr(plan_reading, "read_texts", read_once)


@pytest.fixture(scope="module")
def true_floor() -> Floor:
    return make_corridor_floor(length=14, room_width=(4.0, 6.0), seed=3)


@pytest.fixture(scope="module")
def plan(true_floor: Floor, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("plan") / "plan.png"
    drawing = draw_plan(true_floor, style="thick", px_per_metre=PX_PER_METRE, doors="arc", seed=1)
    Image.fromarray(drawing.colors).save(file)
    return file


@pytest.mark.slow
@pytest.mark.parametrize("doors", ["arc", "gap"])
def test_rough_areas_are_marked_or_left_out_and_the_interval_is_kept(true_floor: Floor, tmp_path: Path, doors: str):
    """Without names, sizes and drawn doors nothing but the look shows the scale."""
    drawing = draw_plan(true_floor, style="thick", px_per_metre=PX_PER_METRE, doors=doors, seed=1)
    Image.fromarray(drawing.colors).save(tmp_path / "plan.png")
    out = tmp_path / "out"
    result = run_pianta("read", str(tmp_path / "plan.png"), "-o", str(out), "--json", str(tmp_path / "all.json"))
    assert result.code == 0, result.err
    scale = json.loads((out / "floor.geojson").read_text())["scale"]
    assert json.loads((tmp_path / "all.json").read_text())["files"][0]["storeys"][0]["scale"] == scale
    low, high = scale["interval"]
    assert low < scale["metres_per_pixel"] < high
    assert scale["is_rough"] == bool(re.search(r"factor of [2-9]|10 or more", result.out))
    assert ("~" in result.out) == (scale["is_rough"] and not scale["is_look"])
    summary = result.out.strip().splitlines()[-1]
    assert scale["is_look"] == (" m²" not in summary) == (AreaTrust.UNKNOWN.note in result.out)
    if doors == "gap":
        assert scale["is_rough"]
        assert scale["sources"] == ["the look of the drawing"]


@pytest.mark.slow
def test_a_plan_is_read_into_its_files(plan: Path, true_floor: Floor, tmp_path: Path):
    result = run_pianta("read", str(plan), "-o", str(tmp_path / "out"))
    assert result.code == 0, result.err
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == [
        "floor.geojson",
        "graph.json",
        "grid.npz",
        "paper.png",
        "picture.png",
        "rooms.png",
    ]
    assert "scale: " in result.out
    floor = read_floor(tmp_path / "out" / "floor.geojson")
    assert len(floor.rooms) == len(true_floor.rooms)
    assert not any(room.partial for room in floor.rooms)
    with Image.open(plan) as sheet, Image.open(tmp_path / "out" / "rooms.png") as labels:
        assert labels.size == sheet.size


@pytest.mark.slow
def test_a_given_resolution_is_the_scale(plan: Path, true_floor: Floor, tmp_path: Path):
    resolution = 1 / PX_PER_METRE
    result = run_pianta("read", str(plan), "-o", str(tmp_path), "--resolution", str(resolution), "-q")
    assert result.code == 0, result.err
    assert not result.out
    area = sum(room.polygon.area for room in read_floor(tmp_path / "floor.geojson").rooms)
    assert area == pytest.approx(sum(room.polygon.area for room in true_floor.rooms), rel=0.12)


def test_as_map_reads_a_plan_as_a_map(plan: Path, tmp_path: Path):
    result = run_pianta("read", str(plan), "-o", str(tmp_path), "--as", "map")
    assert result.code == 2
    assert "--resolution" in result.err


@pytest.mark.slow
def test_previous_keeps_the_ids_of_a_plan(plan: Path, tmp_path: Path):
    for more in ([], ["--previous", str(tmp_path)]):
        result = run_pianta("read", str(plan), "-o", str(tmp_path), *more)
        assert result.code == 0, result.err
    assert "0 are new, 0 are gone" in result.out


@pytest.mark.slow
def test_a_batch_goes_on_after_a_file_that_is_no_plan(plan: Path, tmp_path: Path):
    broken = tmp_path / "broken.svg"
    broken.write_text("<svg><!-- nothing -->")
    result = run_pianta("read", str(plan), str(broken), "-o", str(tmp_path / "out"))
    assert result.code == 1
    assert "broken.svg" in result.err
    assert (tmp_path / "out" / "plan" / "floor.geojson").is_file()
    assert "; scale: 0.0" in result.out


@pytest.mark.slow
def test_the_number_of_symbols_of_a_folder_is_printed(plan: Path, true_floor: Floor, tmp_path: Path):
    symbols = tmp_path / "symbols"
    symbols.mkdir()
    with Image.open(plan) as sheet:
        door = next(door for door in true_floor.doors if abs(door.line.coords[0][1] - door.line.coords[1][1]) < 0.01)
        reach, middle = round(0.8 * PX_PER_METRE), door.line.interpolate(0.5, normalized=True)
        grid = draw_plan(true_floor, style="thick", px_per_metre=PX_PER_METRE, doors="arc", seed=1).grid
        row, col = (round(float(value)) for value in grid.map_to_pixel(middle.x, middle.y))
        sheet.crop((col - reach, row - reach, col + reach, row + reach)).save(symbols / "door7.png")
    read = ("read", str(plan), "-o", str(tmp_path / "out"), "--no-labels", "--symbols", str(symbols))
    result = run_pianta(*read)
    assert result.code == 0, result.err
    matches = next(line for line in result.out.splitlines() if line.startswith("symbols: "))
    assert re.search(r" found: \d+ door7\.png$", matches)

    Image.fromarray(np.tri(40, dtype=np.uint8) * 200).save(symbols / "door7.png")
    assert "found, cut them out of a sheet like this one, at its scale" in run_pianta(*read).out.replace("\n", " ")


def test_a_file_that_is_neither_map_nor_plan_is_refused_with_what_can_be_read(tmp_path: Path):
    (tmp_path / "notes.md").write_text("rooms")
    result = run_pianta("read", str(tmp_path / "notes.md"), "-o", str(tmp_path / "out"))
    assert result.code == 2
    assert re.search(r"notes\.md.*\.yaml.*\.svg", result.err)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "fragment"),
    [
        (["--page", "2"], "--page"),
        (["--trust-thresholds"], "--trust-thresholds"),
        (["--symbols", "nowhere"], "nowhere"),
        (["--resolution", "-1"], "-1"),
        (["--words", "nowhere.json"], "nowhere.json"),
    ],
)
def test_options_without_meaning_are_refused_in_one_line(plan: Path, tmp_path: Path, options: list[str], fragment: str):
    result = run_pianta("read", str(plan), "-o", str(tmp_path / "out"), *options)
    assert result.code == 2
    assert fragment in result.err.replace("\n", " ")
    assert not (tmp_path / "out" / "floor.geojson").exists()


def test_a_page_of_a_map_is_refused(tmp_path: Path):
    result = run_pianta("world", "sample", "-o", str(tmp_path))
    assert result.code == 0
    result = run_pianta("read", str(tmp_path / "map.yaml"), "-o", str(tmp_path / "out"), "--page", "1")
    assert result.code == 2
    assert "--page" in result.err


def test_a_white_sheet_has_no_rooms(tmp_path: Path):
    Image.new("L", (400, 300), 255).save(tmp_path / "white.png")
    result = run_pianta("read", str(tmp_path / "white.png"), "-o", str(tmp_path / "out"))
    assert result.code == 2
    assert "blank" in result.err
    assert result.err.count("error") == 1


@pytest.mark.slow
def test_names_are_in_the_files(true_floor: Floor, tmp_path: Path):
    pytest.importorskip("rapidocr")
    texts = {room.id: "Office" for room in true_floor.rooms[1:4]}
    drawing = draw_plan(true_floor, style="thick", px_per_metre=40, texts=texts, seed=1)
    Image.fromarray(drawing.colors).save(tmp_path / "named.png")
    result = run_pianta("read", str(tmp_path / "named.png"), "-o", str(tmp_path / "out"))
    assert result.code == 0, result.err
    graph = json.loads((tmp_path / "out" / "graph.json").read_text())
    assert [node["name"] for node in graph["nodes"]].count("Office") == len(drawing.names)


@pytest.mark.parametrize(
    ("options", "fragment"),
    [
        (["--page", "2"], ("--page",)),
        (["--resolution", "0.05"], ("--resolution",)),
        (["--symbols", "."], ("--symbols",)),
        (["--resolution", "1", "--page", "1"], ("--page", "--resolution")),
    ],
)
def test_options_of_drawings_are_refused_for_an_ifc(tmp_path: Path, options: list[str], fragment: tuple[str, ...]):
    (tmp_path / "house.ifc").write_text("ISO-10303-21;")
    result = run_pianta("read", str(tmp_path / "house.ifc"), "-o", str(tmp_path / "out"), *options)
    assert result.code == 2
    assert "house.ifc" in result.err.replace("\n", "")
    assert [option for option in ("--page", "--resolution", "--symbols") if option in result.err] == [*fragment]
    assert not (tmp_path / "out").exists()


def opened_floors(*folders: str) -> list[StoreyReading]:
    """The same two rooms of 2 m × 2 m for each folder."""
    floor = Floor((Room(1, box(0, 0, 2, 2)), Room(2, box(2, 0, 4, 2))), ())
    return [StoreyReading(floor, GridMap(np.full((20, 40), UNKNOWN, np.int8), 0.1), folder) for folder in folders]


@pytest.mark.slow
def test_all_floors_of_a_plan_are_written_or_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    floors = opened_floors("floor-1", "floor-2")
    monkeypatch.setattr(Reader, "_open", lambda *_: floors)
    read = ("read", "plan.png", "-o", str(tmp_path / "out"), "--no-labels")
    pictures = []

    def fail_at_second(*_: object, **__: object) -> None:
        pictures.append(1)
        if len(pictures) == 2:
            raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr("pianta.plot.figure.save_figure", fail_at_second)
        result = run_pianta(*read)
    assert result.code == 2
    assert re.search("floor-2.*No space left", result.err)
    assert not (tmp_path / "out").exists()

    (tmp_path / "out" / "floor-1" / "rooms.png").mkdir(parents=True)
    result = run_pianta(*read)
    assert result.code == 2
    assert re.search(r"rooms\.png.*folder", result.err)
    assert [path.name for path in (tmp_path / "out").rglob("*")] == ["floor-1", "rooms.png"]

    (tmp_path / "out" / "floor-1" / "rooms.png").rmdir()
    assert run_pianta(*read).code == 0
    assert sorted(list_files(tmp_path / "out")) == sorted(
        ["building.json", *(f"floor-{number}/{name}" for number in (1, 2) for name in OUTPUTS)]
    )


@pytest.mark.slow
@pytest.mark.parametrize("as_plan", [("--as", "plan"), ()])
@pytest.mark.parametrize("drawing", NO_DRAWINGS)
def test_files_without_a_plan_are_refused_in_one_line_before_anything_slow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawing: str, as_plan: tuple[str, ...]
):
    for slow in ("read_texts", "segment_sheet", "find_symbols", "find_scale"):
        monkeypatch.setattr(f"pianta.plan.read_plan.{slow}", None)
    Image.fromarray(NO_DRAWINGS[drawing]).save(tmp_path / "no-plan.png")
    result = run_pianta("read", str(tmp_path / "no-plan.png"), "-o", str(tmp_path / "out"), *as_plan)
    assert (result.code, result.out) == (2, "")
    assert result.err.startswith("error: ")
    assert result.err.count("error") == 1
    assert "no-plan.png" in result.err
    assert "blank" in result.err or ("resolution" in result.err and not as_plan)
    assert not (tmp_path / "out").exists()
