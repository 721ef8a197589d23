"""The benches layout and segmentation: scores by hand, failures, output, and the published figures."""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image
from shapely import LineString, Polygon, box
from threadpoolctl import threadpool_info, threadpool_limits

from pianta.errors import DataError, MapError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta_bench.data.folders import find_data, list_maps
from pianta_bench.harness.records import Results
from pianta_bench.harness.tables import Cell
from pianta_bench.layout import tables as layout_tables
from pianta_bench.layout import timing
from pianta_bench.layout.measure import measure as measure_layout
from pianta_bench.segmentation import tables as segmentation_tables
from pianta_bench.segmentation.measure import DRAWN_METRICS
from pianta_bench.segmentation.measure import measure as measure_segmentation
from tests.bench_results import Row, list_rows, show_lines
from tests.tiny_data import ONE_ROOM, OUTLINES, TRUE_FLOOR, write_slam, write_survey

TIMES = {"seconds", "transforms"}
NO_DOORS = {f"{count}_{item}": 0 for count in ("true", "found", "right") for item in ("doors", "edges", "pairs")}
LASTING = {"rooms_before", "still_there", "kept_id"}
measure_survey = partial(measure_segmentation, methods=("thesis",), sets=("survey", "furniture"))


@pytest.fixture
def find(monkeypatch):
    """Replaces reconstruct by a function that returns a given floor."""

    def replace(floor: Floor) -> None:
        monkeypatch.setattr(timing, "reconstruct", lambda *_, **__: floor)

    return replace


def scores_of(row: Row) -> dict[str, float | None]:
    """The figures, without those of drawn layouts, of which the tiny data have none."""
    assert [row.figures[metric] for metric in DRAWN_METRICS if metric in row.figures] in ([], [None] * 10)
    return {key: figure for key, figure in row.figures.items() if key not in TIMES | LASTING | {*DRAWN_METRICS}}


def test_the_data_folder_is_the_given_one_else_that_of_the_environment_else_the_default(tmp_path, monkeypatch):
    for name in ("given", "named", "shared/data", "project"):
        (tmp_path / name).mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "project")
    monkeypatch.delenv("PIANTA_DATA", raising=False)
    assert find_data().resolve() == tmp_path / "shared" / "data"
    monkeypatch.setenv("PIANTA_DATA", "")
    assert find_data().resolve() == tmp_path / "shared" / "data"
    monkeypatch.setenv("PIANTA_DATA", str(tmp_path / "named"))
    assert find_data() == tmp_path / "named"
    assert find_data(tmp_path / "given") == tmp_path / "given"


@pytest.mark.parametrize("name", ["none", "file", "n" * 5000, "a\0b"])
def test_missing_data_are_named_with_a_remedy(tmp_path, name):
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match=r"--data.*\$PIANTA_DATA"):
        find_data(tmp_path / name)


def test_maps_are_those_with_a_truth(tmp_path):
    for name in ("b_gt.xml", "a_gt.xml", "c.png", "b.png"):
        (tmp_path / name).touch()
    assert list_maps(tmp_path, "_gt.xml") == ["a", "b"]
    with pytest.raises(DataError, match=r"\*_gt\.png"):
        list_maps(tmp_path, "_gt.png")


@pytest.mark.parametrize("measure", [measure_layout, measure_survey])
def test_data_without_the_maps_of_a_bench_are_refused(tmp_path, measure):
    with pytest.raises(DataError, match=r"slam|survey"):
        measure(tmp_path)


def test_segmentation_of_one_room_where_there_are_two(tmp_path, find):
    """The one room is 124 px wide, the two true ones 80 and 40 px, and the wall between them 4 px."""
    write_survey(tmp_path, "a")
    find(ONE_ROOM)
    results = measure_survey(tmp_path)
    assert [item.part for item in results.items] == ["survey", "furniture"]
    for part in ("survey", "furniture"):
        (row,) = list_rows(results, part, method="thesis")
        assert (row.item, row.failure, row.warnings) == ("a", None, ())
        assert scores_of(row) == pytest.approx(
            {
                "precision": 100 * 80 / 124,
                "recall": 100,
                "a_fc": 100 * 80 / 124,
                "mean_iou": 100 * 60 / 124,
                "f1": 100 * 2 / 3,
                "found": 1,
                "true": 2,
                "matched": 1,
                "precision_free": 100 * 80 / 120,
                "recall_free": 100,
                "a_fc_free": 100 * 80 / 120,
                "mean_iou_free": 50,
                "f1_free": 100 * 2 / 3,
                "precision_rest": 100 * 80 / 120,
                "recall_rest": 100,
            }
        )


def test_white_patches_of_the_truth(tmp_path, find):
    """20 px in the wall are free cells but no room; 120 px outside, 0.3 m², are a room unless the limit is 1 m²."""
    write_survey(tmp_path, "a")
    truth = tmp_path / "survey" / "a_gt_segmentation.png"
    with Image.open(truth) as image:
        greys = np.array(image)
    greys[50:60, 101:103] = 251
    greys[65:75, 101:103] = 250
    greys[0:10, 0:12] = 255
    Image.fromarray(greys).save(truth)
    find(ONE_ROOM)
    results = measure_survey(tmp_path)
    for part in ("survey", "furniture"):
        figures = list_rows(results, part)[0].figures
        assert figures["true"] == 3
        assert figures["precision"] == pytest.approx(100 * 80 / 124)
        assert figures["recall"] == pytest.approx(100 * 2 / 3)
        assert figures["precision_free"] == pytest.approx(100 * 4800 / 7220)
        assert figures["recall_free"] == 100


def test_free_cells_in_no_room_are_one_more_room(tmp_path, find):
    """The second room is in no reconstructed room; _rest counts its cells as one more room, which matches."""
    write_survey(tmp_path, "a")
    find(Floor(TRUE_FLOOR.rooms[:1]))
    figures = list_rows(measure_survey(tmp_path), "survey")[0].figures
    assert (figures["precision_free"], figures["recall_free"]) == (100, 50)
    assert (figures["precision_rest"], figures["recall_rest"]) == (100, 100)


def test_layout_of_one_room_where_there_are_two(tmp_path, find):
    """The larger room is 4 m of 6 m wide on free cells, and 4.1 m of 6.2 m with its half of the wall."""
    write_slam(tmp_path, "a")
    find(ONE_ROOM)
    (row,) = list_rows(measure_layout(tmp_path), "schools")
    assert scores_of(row) == pytest.approx(
        {
            "a_fc_free": 100 * 4 / 6,
            "a_fc_walls": 100 * 4.1 / 6.2,
            "a_bc_free": 100,
            "a_bc_walls": 100,
            "mean_iou": 50,
            "f1": 100 * 2 / 3,
            "door_precision": 100,
            "door_recall": 100,
            "found": 1,
            "true": 2,
            **NO_DOORS,
            **dict.fromkeys(("doors_f1", "edges_f1", "pairs_f1"), 100),
        }
    )


def test_doors_of_the_layout_are_those_between_true_rooms(tmp_path, find):
    """The true door joins rooms 1 and 2; a wrong reconstructed door joins rooms 2 and 3."""
    third = box(1, 0.2, 5, 0.8)
    write_slam(tmp_path, "a", outlines=(*OUTLINES, third))
    file = tmp_path / "slam" / "a_gt.xml"
    portal = "<portals><portal><target><id>0</id><id>1</id></target></portal></portals></space>"
    file.write_text(file.read_text().replace("</space>", portal, 1))
    three = (*TRUE_FLOOR.rooms, Room(3, third))
    right, wrong = (Door(pair, LineString([(5, 2), (5, 3)]), 1.0) for pair in ((1, 2), (2, 3)))
    for doors, precision, recall in (((), 0, 0), ((right,), 100, 100), ((wrong,), 0, 0), ((right, wrong), 50, 100)):
        find(Floor(three, doors))
        figures = list_rows(measure_layout(tmp_path), "schools")[0].figures
        assert (figures["door_precision"], figures["door_recall"]) == (precision, recall)


def test_the_true_rooms_score_100_but_for_the_walls_of_the_schools(tmp_path, find):
    write_survey(tmp_path, "a", "b")
    write_slam(tmp_path, "a", "b")
    find(TRUE_FLOOR)
    layout, segmentation = measure_layout(tmp_path), measure_survey(tmp_path)
    rows = [*list_rows(layout, "schools"), *list_rows(segmentation, "survey"), *list_rows(segmentation, "furniture")]
    assert len(rows) == 6
    for row in rows:
        short = {"a_bc_walls": 100 * 6 / 6.2} if "a_bc_walls" in row.figures else {}
        counts = {key: 2 for key in ("found", "true", "matched") if key in row.figures}
        doors = {key: 0 for key in NO_DOORS if key in row.figures}
        expected = dict.fromkeys(scores_of(row), 100) | counts | doors | short
        assert scores_of(row) == pytest.approx(expected)


@pytest.mark.slow
def test_real_reconstructions_of_the_tiny_maps(tmp_path):
    write_survey(tmp_path, "a")
    write_slam(tmp_path, "a")
    tracked: list[Sequence[str]] = []

    def track(maps: Sequence[str]) -> Iterator[str]:
        tracked.append(maps)
        return iter(maps)

    (tmp_path / "out").mkdir()
    layout, survey = (
        measure(tmp_path, pictures=tmp_path / "out", track=track) for measure in (measure_layout, measure_survey)
    )
    for row in (*list_rows(layout, "schools"), *list_rows(survey, "survey"), *list_rows(survey, "furniture")):
        assert row.failure is None
        assert (row.figures["found"], row.figures["true"]) == (2, 2)
        assert (row.figures["mean_iou"] or 0) > 90
        assert all((row.figures[time] or 0) > 0 for time in TIMES)
    assert tracked == [["a"], ["a, thesis"] * 2]
    pictures = {path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*.png")}
    assert pictures == {"a.png", "thesis/survey/a.png", "thesis/furniture/a.png"}


def test_time_is_counted_in_median_distance_transforms_on_one_thread(monkeypatch):
    clock = iter([0.0, 10.0, 20.0, 21.0, 30.0, 32.0, 40.0, 43.0, 50.0, 59.0, 60.0, 62.0])
    threads = []

    def reconstruct(*_: object, **__: object) -> Floor:
        threads.extend([cv2.getNumThreads(), *[library["num_threads"] for library in threadpool_info()]])
        return TRUE_FLOOR

    timing._load_method("thesis")
    monkeypatch.setattr(timing, "perf_counter", lambda: next(clock))
    monkeypatch.setattr(timing, "reconstruct", reconstruct)
    cv2.setNumThreads(2)
    try:
        with threadpool_limits(2):
            floor, time = timing.time_reconstruction(GridMap(np.array([[0, 100]], np.int8), 0.05), method="thesis")
            assert 2 in [library["num_threads"] for library in threadpool_info()]
        assert cv2.getNumThreads() == 2
    finally:
        cv2.setNumThreads(1)
    assert floor == TRUE_FLOOR
    assert set(threads) == {1}
    assert len(threads) > 1
    assert time == {"seconds": 10.0, "transforms": 5.0}


@pytest.mark.parametrize("exception", [MapError("no\nroom"), RuntimeError("no room"), RecursionError(), MemoryError()])
def test_a_map_that_fails_is_named_and_counts_as_0(tmp_path, monkeypatch, exception):
    write_survey(tmp_path, "a", "b", "c")
    failing = iter([None, exception, None, None, None, None])

    def reconstruct(*_: object, **__: object) -> Floor:
        if (error := next(failing)) is not None:
            raise error
        return TRUE_FLOOR

    timing._load_method("thesis")
    monkeypatch.setattr(timing, "reconstruct", reconstruct)
    results = measure_survey(tmp_path)
    assert results.failed
    empty, furnished = (list_rows(results, part) for part in ("survey", "furniture"))
    reason = {MapError: "no room", RuntimeError: "RuntimeError: no room"}.get(
        type(exception), f"{type(exception).__name__}: {type(exception).__name__}"
    )
    assert [row.failure for row in empty] == [None, reason, None]
    assert not any(row.failure for row in furnished)
    nothing = dict.fromkeys(scores_of(empty[1]), 0) | {"true": 2}
    assert scores_of(empty[1]) == nothing
    assert all(empty[1].figures[time] is None for time in TIMES)
    tables = segmentation_tables.tabulate(results)
    means = next(table for table in tables if table.title == "Means of all figures").rows
    assert means["survey, thesis"]["precision"].mean == pytest.approx(200 / 3)
    assert means["survey, thesis"]["found"].mean == pytest.approx(4 / 3)
    assert means["furniture, thesis"]["precision"].mean == 100
    lines = show_lines(tables, results)
    assert f"b failed (survey): {reason}" in lines
    assert "A map that failed counts as 0." in lines


def test_unreadable_files_fail_one_by_one(tmp_path, find):
    write_slam(tmp_path, "a", "b", "c", "d")
    find(TRUE_FLOOR)
    (tmp_path / "slam" / "a.png").unlink()
    (tmp_path / "slam" / "b_gt.xml").write_text("<building")
    (tmp_path / "slam" / "c.png").write_bytes(b"no image")
    results = measure_layout(tmp_path)
    rows = list_rows(results, "schools")
    for row, reason in zip(rows, ("exist", "XML", "image"), strict=False):
        assert reason in str(row.failure)
        assert row.figures["found"] == 0
        assert row.figures["true"] is None
    assert rows[3].failure is None
    maps, _, graph = layout_tables.tabulate(results)
    assert [maps.rows[name]["\ntrue"] for name in maps.rows] == [
        *[Cell(None)] * 3,
        Cell(2),
        Cell(2),
        Cell(None),
        Cell(2),
    ]
    assert graph.rows["schools"]["doors\nF1"].mean == 25


def test_a_picture_that_cannot_be_written_keeps_the_scores(tmp_path, find):
    write_slam(tmp_path, "a")
    find(TRUE_FLOOR)
    (tmp_path / "pictures" / "a.png").mkdir(parents=True)
    (row,) = list_rows(measure_layout(tmp_path, pictures=tmp_path / "pictures"), "schools")
    assert row.figures["a_fc_free"] == 100
    assert "write" in str(row.failure)


def test_warnings_are_counted_and_saved_with_their_map(tmp_path, find):
    crossed = Polygon([(1, 1), (5, 1), (5, 4), (1, 4), (1, 0), (0, 0), (0, 2), (1, 2)])
    write_slam(tmp_path, "a", "b", outlines=(crossed, OUTLINES[1]))
    find(TRUE_FLOOR)
    results = measure_layout(tmp_path)
    for row in list_rows(results, "schools"):
        (warned,) = row.warnings
        assert f"{row.item}_gt.xml' was repaired" in warned
    lines = show_lines(layout_tables.tabulate(results), results)
    assert "Warnings on 2 of 2 schools; --json lists them." in lines


@pytest.mark.parametrize("width", [80, 120])
def test_every_figure_is_legible_in_a_terminal_of_80_columns(tmp_path, find, width):
    school, map_ = "school_with_21_[b]ody", "Freiburg[101]_scan"
    write_slam(tmp_path, school)
    write_survey(tmp_path, map_)
    find(TRUE_FLOOR)
    layout, survey = measure_layout(tmp_path), measure_survey(tmp_path)
    lines = show_lines(layout_tables.tabulate(layout), layout, width)
    lines += show_lines(segmentation_tables.tabulate(survey), survey, width)
    assert max(map(len, lines)) <= width
    assert not any("…" in line for line in lines)
    figures = {name: [line.split()[1:] for line in lines if line.startswith(name)] for name in (school, map_)}
    # Eight scores, two counts and two times of the school; five, two and two of the map, twice.
    assert sum(map(len, figures[school])) == 12
    assert sum(row.count("100.0") for row in figures[school]) >= 7
    assert sum(map(len, figures[map_])) == 18
    assert sum(row.count("100.0") for row in figures[map_]) == 10


def test_the_published_figures_are_those_of_the_thesis():
    """Table 3.1, cell by cell, copied from the thesis."""
    table = layout_tables.TABLE_3_1A.fill([], method="thesis")
    published = {name: (cell.published_mean, cell.published_sd) for name, cell in table.rows["schools"].items()}
    forward, backward = (87.6, 5.7), (87.8, 4.5)
    assert published == dict(
        zip(("A_FC\nfree", "A_BC\nfree", "A_FC\nwalls", "A_BC\nwalls"), (forward, backward) * 2, strict=True)
    )
    parts = [segmentation_tables.TABLE_3_1B.narrow(part=part).fill([], part=part) for part in ("survey", "furniture")]
    assert [table.columns for table in parts] == [("\nprec.", "\nrecall")] * 2
    assert {
        method: [
            (table.rows[method][column].published_mean, table.rows[method][column].published_sd)
            for table in parts
            for column in table.columns
        ]
        for method in parts[0].rows
    } == {
        "thesis as printed": [(90.1, 6.3), (90.0, 4.1), (94.0, 2.2), (89.5, 6.2)],
        "thesis": [(90.1, 6.3), (90.0, 4.1), (94.0, 2.2), (89.5, 6.2)],
        "morphological": [(88.5, 9.2), (98.1, 2.4), (90.5, 8.1), (84.6, 7.2)],
        "distance": [(88.4, 9.3), (96.9, 2.8), (88.4, 8.5), (76.1, 12.3)],
        "voronoi": [(94.8, 5.0), (95.0, 2.3), (94.5, 5.1), (86.6, 5.2)],
        "features": [(90.2, 8.0), (89.2, 11.8), (87.0, 14.5), (85.5, 7.2)],
    }


def link_maps(data: Path, folder: Path, *names: str) -> Path:
    """A data folder with some of the maps, because all maps take a minute."""
    for file in [file for name in names for file in data.glob(f"{name}[._]*")]:
        (folder / data.name).mkdir(exist_ok=True)
        (folder / data.name / file.name).symlink_to(file.resolve())
    return folder


def assert_means_above(results: Results, part: str, bars: dict[str, float]) -> None:
    means = {metric: Cell.over(results.values(part=part, metric=metric)) for metric in bars}
    assert {cell.count for cell in means.values()} == {3}
    assert all((means[metric].mean or 0) >= bar for metric, bar in bars.items()), means


@pytest.mark.slow
def test_layout_of_three_schools_is_above_the_bars(data, tmp_path):
    results = measure_layout(link_maps(data / "slam", tmp_path, "plans2", "rockislandsecondfloor", "sidneyriver"))
    assert not results.failed
    bars = {"a_fc_free": 93, "a_bc_free": 92.5, "a_fc_walls": 87, "a_bc_walls": 88}
    assert_means_above(results, "schools", bars)


@pytest.mark.slow
def test_segmentation_of_three_maps_is_above_the_bars(data, tmp_path):
    results = measure_survey(link_maps(data / "survey", tmp_path, "Freiburg79_scan", "lab_f_scan", "office_a"))
    assert not results.failed
    assert_means_above(results, "survey", {"precision_free": 90, "recall_free": 91})
    assert_means_above(results, "furniture", {"precision_free": 89, "recall_free": 89.5})
