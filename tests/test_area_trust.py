"""Doubtful areas are marked or left out where people look; those of a map stay as they are."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from shapely import box

import pianta
from pianta.cli.reading_text import tabulate_rooms
from pianta.cli.terminal import describe_floor
from pianta.corrections.kinds import ScaleToArea
from pianta.floor import Floor, Room
from pianta.floor.area_trust import AreaTrust
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io.building_folders import read_building_folder
from pianta.io.floors import read_scale_member
from pianta.labels import ALL_SCHEMAS
from pianta.plan.sheets.sheet import PlanScale
from pianta.plot.picture import plot_scale_bar
from pianta.reading.reading import OUTPUTS, StoreyReading, write_floor
from pianta.reading.saved_reading import SavedReading
from pianta.view.sessions import Session
from tests.command_line import run_pianta

# A room of 12.34 m² and one of 123.4 m²
FLOOR = Floor((Room(1, box(0, 0, 2, 6.17)), Room(2, box(2, 0, 22, 6.17))))
GRID = GridMap(np.full((80, 230), UNKNOWN, np.int8), 0.1, (-0.5, -0.5, 0.0))
CERTAIN = PlanScale(0.1, "the units of the file", 0.95)
# 1.5 times the length at most is 2.25 times the area
ROUGH = PlanScale(0.1, "3 doors", 0.5, (0.09, 0.12), (0.08, 0.15))
LOOK = PlanScale(0.1, "the look of the drawing", 0.3, (0.08, 0.12), (0.05, 0.2), is_look=True)


def write(folder: Path, scale: PlanScale | None) -> Path:
    """The folder of the floor, as `pianta read` writes it."""
    folder.mkdir(exist_ok=True)
    GRID.save(folder / OUTPUTS[-1])
    write_floor(FLOOR, GRID, folder, ALL_SCHEMAS, scale=scale)
    return folder


@pytest.mark.parametrize(
    ("scale", "trust", "texts"),
    [
        (CERTAIN, AreaTrust.EXACT, ["12.3 m²", "123.4 m²"]),
        (ROUGH, AreaTrust.ROUGH, ["≈ 12 m²", "≈ 120 m²"]),
        (LOOK, AreaTrust.UNKNOWN, ["?", "?"]),
        (LOOK.corrected(2.0), AreaTrust.EXACT, ["12.3 m²", "123.4 m²"]),
    ],
)
def test_areas_are_as_certain_as_the_scale(scale, trust, texts):
    assert scale.area_trust is trust
    assert [trust.format_area(room.polygon.area) for room in FLOOR] == texts
    assert AreaTrust.from_member(scale.as_json()) is trust
    assert StoreyReading(FLOOR, GRID, scale=scale).area_trust is trust


def test_a_map_has_exact_areas():
    assert StoreyReading(FLOOR, GRID).area_trust is AreaTrust.EXACT
    assert not AreaTrust.EXACT.note


@pytest.mark.parametrize("member", [None, [], "rough", 1, {}, {"is_rough": "yes"}, {"is_look": 1}])
def test_a_damaged_scale_marks_nothing(member):
    assert AreaTrust.from_member(member) is AreaTrust.EXACT


def test_a_file_that_has_gone_since_it_was_read_has_no_scale(tmp_path):
    (tmp_path / "floor.geojson").write_text("{")
    assert read_scale_member(tmp_path / "floor.geojson") is None
    assert read_scale_member(tmp_path / "gone.geojson") is None


@pytest.mark.parametrize("scale", [ROUGH, LOOK])
def test_csv_marks_rough_areas_in_its_last_column(tmp_path, scale):
    notes = pianta.convert(write(tmp_path / "plan", scale), tmp_path / "rooms.csv")
    with (tmp_path / "rooms.csv").open(encoding="utf-8", newline="") as file:
        rows = [*csv.DictReader(file)]
    assert [row["area_is_rough"] for row in rows] == ["yes", "yes"]
    assert [row["area_m2"] for row in rows] == ["12.34", "123.4"]
    (note,) = notes
    assert note == scale.area_trust.warning
    assert "--resolution" in note


@pytest.mark.parametrize("scale", [None, CERTAIN])
def test_the_csv_of_a_certain_floor_has_no_further_column(tmp_path, scale):
    assert pianta.convert(write(tmp_path / "plan", scale), tmp_path / "rooms.csv") == []
    assert (tmp_path / "rooms.csv").read_text().splitlines()[0].endswith("neighbours,flag,global_id")


def test_only_the_rough_storeys_of_a_table_are_marked(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    storeys = pianta.Storey(FLOOR, "ground"), pianta.Storey(FLOOR, "first", area_trust=AreaTrust.ROUGH)
    notes = pianta.convert(pianta.Building(storeys), tmp_path / "rooms.xlsx")
    book = openpyxl.load_workbook(tmp_path / "rooms.xlsx")
    columns = {name: [row[-1] for row in book[name].values] for name in ("Rooms", "Totals")}
    assert columns["Rooms"] == ["area_is_rough", "no", "no", "yes", "yes"]
    # The label and all of ground, those of first, and all of the building
    assert columns["Totals"] == ["area_is_rough", "no", "no", "yes", "yes", "yes"]
    assert notes == [f"storeys 'first': {AreaTrust.ROUGH.note}"]


@pytest.mark.parametrize(
    ("trust", "areas", "bar"),
    [
        (AreaTrust.EXACT, ["12.3 m²", "123.4 m²"], "10 m"),
        (AreaTrust.ROUGH, ["≈ 12 m²", "≈ 120 m²"], "≈ 10 m"),
        (AreaTrust.UNKNOWN, ["?", "?"], "?"),
    ],
)
def test_drawings_mark_areas_and_the_scale_bar(tmp_path, trust, areas, bar):
    pianta.convert(pianta.Building((pianta.Storey(FLOOR, area_trust=trust),)), tmp_path / "floor.svg", to="svg")
    svg = (tmp_path / "floor.svg").read_text(encoding="utf-8")
    assert all(f">{text}</text>" in svg for text in [*areas, bar])


@pytest.mark.parametrize(("trust", "text"), [(AreaTrust.EXACT, "2 m"), (AreaTrust.ROUGH, "≈ 2 m")])
def test_the_scale_bar_of_a_picture_has_a_mark(trust, text):
    ax = Figure().add_axes((0, 0, 1, 1), xlim=(0, 10), ylim=(0, 10))
    plot_scale_bar(ax=ax, area_trust=trust)
    assert [each.get_text() for each in ax.texts] == [text]
    assert len(ax.lines) == 1


@pytest.mark.parametrize("width", [2, 8])
def test_a_picture_without_scale_has_the_reason(width):
    """In as many lines as fit, and without a bar."""
    figure = Figure(figsize=(width, 8), dpi=200)
    ax = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(0, 8))
    plot_scale_bar(ax=ax, area_trust=AreaTrust.UNKNOWN)
    (text,) = ax.texts
    assert text.get_text().replace("\n", " ") == AreaTrust.UNKNOWN.note
    assert not ax.lines
    extent = text.get_window_extent()
    assert figure.bbox.x0 <= extent.x0 <= extent.x1 <= figure.bbox.x1


def test_the_picture_of_a_map_is_that_of_a_certain_plan(tmp_path):
    pictures = [
        (write(tmp_path / name, scale) / "picture.png").read_bytes()
        for name, scale in (("map", None), ("certain", CERTAIN), ("rough", ROUGH), ("look", LOOK))
    ]
    assert pictures[0] == pictures[1]
    assert len({*pictures}) == 3


def test_the_terminal_marks_areas_or_leaves_them_out():
    assert describe_floor(FLOOR) == "2 rooms, 0 doors, 135.7 m²"
    assert describe_floor(FLOOR, AreaTrust.ROUGH) == "2 rooms, 0 doors, ~140 m²"
    assert describe_floor(FLOOR, AreaTrust.UNKNOWN) == "2 rooms, 0 doors"
    for trust, cells in ((AreaTrust.ROUGH, ["~12", "~120"]), (AreaTrust.UNKNOWN, ["?", "?"])):
        table = tabulate_rooms(FLOOR, trust)
        assert [*next(column for column in table.columns if column.header == "area m²").cells] == cells


def test_a_person_who_gives_the_scale_gets_areas(tmp_path):
    folder = write(tmp_path / "plan", LOOK)
    assert run_pianta("correct", folder, "--name", "1", "Kitchen").out.startswith("2 rooms, 0 doors, 1 correction")
    assert run_pianta("correct", folder, "--area", "1", "49.36").out.startswith("2 rooms, 0 doors, 543.0 m²")
    assert read_building_folder(folder).area_trust is AreaTrust.EXACT


def test_the_page_and_the_gallery_know_how_certain_areas_are(tmp_path):
    session = Session(0, "plan", write(tmp_path / "plan", LOOK))
    unknown = {"trust": "unknown", "note": AreaTrust.UNKNOWN.note}
    assert session.summarize()["areas"] == unknown
    state = session.describe()
    assert state["areas"] == unknown
    corrected = session.edit(state["version"], [], {"kind": "area", "room": 1, "area": 49.36})
    assert corrected["areas"] == {"trust": "exact", "note": ""}
    SavedReading.open(tmp_path / "plan").add(ScaleToArea((1, 1), 49.36)).save()
    assert "areas" not in session.summarize()
    assert not json.loads((tmp_path / "plan" / "floor.geojson").read_text())["scale"]["is_rough"]
