"""Doors and edges in the bench of layouts: their scores by hand, and the sets of maps."""

import pytest
from shapely import LineString, box

from pianta.errors import BuildingWarning, DataError, OptionError
from pianta.floor import Door, Floor, Room
from pianta_bench.data.folders import LAYOUT_SET_NAMES
from pianta_bench.data.layout_sets import LAYOUT_SETS, read_world
from pianta_bench.harness.records import Results
from pianta_bench.layout import timing
from pianta_bench.layout.graph_scores import pool_maps
from pianta_bench.layout.measure import measure
from tests.bench_results import list_rows
from tests.command_line import run_pianta
from tests.tiny_data import OUTLINES, ROOMS, TRUE_FLOOR, write_building, write_slam, write_survey

DOOR = Door((1, 2), LineString([(5.1, 2.05), (5.1, 2.95)]), 0.9)
# The portal of the tiny building is a point in the middle of the wall, at (5.1, 2.5).
PORTAL = "<portals><portal><target><id>0</id><id>1</id></target></portal></portals></space>"


@pytest.fixture
def find(monkeypatch):
    """Replaces reconstruct by a function that returns given floors in order."""

    def replace(*floors: Floor) -> None:
        left = iter(floors)
        monkeypatch.setattr(timing, "_load_method", lambda _: None)
        monkeypatch.setattr(timing, "reconstruct", lambda *_, **__: next(left))

    return replace


def write_layouts(data, *names: str) -> None:
    write_survey(data, *names)
    for name in names:
        building = write_building(OUTLINES, 0.05).replace("</space>", PORTAL, 1)
        (data / "survey" / f"{name}_layout_gt.xml").write_text(building)


def move(door: Door, metres: float) -> Door:
    return Door(door.rooms, LineString([(x, y + metres) for x, y in door.line.coords]), door.width)


def test_the_names_of_the_sets_are_those_of_the_help():
    assert tuple(LAYOUT_SETS) == LAYOUT_SET_NAMES


def test_doors_count_by_their_middle_and_edges_by_the_rooms_that_match(tmp_path, find):
    """The first floor is right; the door of the second is 0.5 m away; the third has the larger room in two halves."""
    write_layouts(tmp_path, "a", "b", "c")
    lower, upper = box(1, 1, 5, 2.5), box(1, 2.5, 5, 4)
    third = Floor((Room(1, lower), Room(2, ROOMS[1]), Room(3, upper)), (DOOR, Door((1, 3), DOOR.line, 1.0)))
    find(Floor(TRUE_FLOOR.rooms, (DOOR,)), Floor(TRUE_FLOOR.rooms, (move(DOOR, 0.5),)), third)
    results = measure(tmp_path, method="structure", sets=("survey",))
    assert not results.failed
    rows = [row.figures for row in list_rows(results, "survey")]
    assert [row["doors_f1"] for row in rows] == pytest.approx([100, 0, 200 / 3])
    assert [row["edges_f1"] for row in rows] == pytest.approx([100, 100, 0])
    assert [row["pairs_f1"] for row in rows] == pytest.approx([100, 100, 100])
    pooled = {record["metric"]: record["value"] for record in pool_maps(results, "survey")}
    assert pooled["doors_pooled_precision"] == pytest.approx(50)
    assert pooled["doors_pooled_recall"] == pytest.approx(200 / 3)
    assert pooled["doors_pooled_f1"] == pytest.approx(100 * 4 / 7)
    assert pooled["edges_pooled_precision"] == pytest.approx(50)
    assert (pooled["doors_true"], pooled["edges_true"]) == (3, 3)


def test_true_doors_of_a_map_that_fails_are_missed_in_the_pool(tmp_path, find):
    write_layouts(tmp_path, "a", "b")
    find(Floor(TRUE_FLOOR.rooms, (DOOR,)))
    results = measure(tmp_path, method="structure", sets=("survey",))
    assert [row.failure is None for row in list_rows(results, "survey")] == [True, False]
    pooled = {record["metric"]: record["value"] for record in pool_maps(results, "survey")}
    assert (pooled["doors_pooled_precision"], pooled["doors_pooled_recall"], pooled["doors_true"]) == (100, 50, 2)


def test_a_set_without_doors_has_a_pool_of_100():
    assert {record["value"] for record in pool_maps(Results(), "survey")} == {100, 0}


def test_made_worlds_are_their_own_truth(tmp_path, find):
    assert len(LAYOUT_SETS["worlds"].list_items(tmp_path)) == 7 * 5
    _, truth = read_world(tmp_path, "l_1")
    find(truth)
    results = measure(tmp_path, method="structure", sets=("worlds",), items=("l_1",))
    (row,) = list_rows(results, "worlds")
    assert row.item == "l_1"
    assert [row.figures[key] for key in ("mean_iou", "doors_f1", "edges_f1", "a_fc_walls")] == pytest.approx([100] * 4)
    assert row.figures["true_doors"] == len(truth.doors) > 10


def test_sets_and_maps_that_do_not_exist_are_refused(tmp_path):
    write_slam(tmp_path, "a")
    with pytest.raises(OptionError, match="attic"):
        measure(tmp_path, sets=("attic",))
    with pytest.raises(OptionError, match="'b'"):
        measure(tmp_path, items=("a", "b"))
    with pytest.raises(DataError, match="survey"):
        measure(tmp_path, sets=("survey",))


def test_the_command_prints_doors_and_edges_of_the_maps_on_request(tmp_path, find):
    write_layouts(tmp_path, "a", "b")
    correct = Floor(TRUE_FLOOR.rooms, (DOOR,))
    find(*[correct] * 8)
    options = "bench", "layout", "--data", tmp_path, "--set", "survey", "--set", "furniture", "--item", "a"
    code, out, err = run_pianta(*options, "--maps", "--pictures", tmp_path / "new")
    assert (code, err) == (0, "")
    rows = [line.split() for line in out.splitlines() if line.startswith("a ")]
    assert rows.count(["a", *["100.0", "1", "1", "1"] * 3]) == 2
    assert {path.relative_to(tmp_path / "new").as_posix() for path in (tmp_path / "new").rglob("*.png")} == {
        "survey/a.png",
        "furniture/a.png",
    }
    assert "Doors and edges of each map" not in run_pianta(*options).out


def test_real_layouts_of_the_survey_lie_on_their_maps(data):
    with pytest.warns(BuildingWarning, match="does not join two rooms"):
        grid, truth = LAYOUT_SETS["survey"].read(data, "lab_c_scan")
    assert (len(truth.rooms), len(truth.doors)) == (17, 17)
    assert (truth.label_image(grid) > 0)[grid.free].mean() > 0.9
