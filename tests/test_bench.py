"""The benches measure what they say they measure, and no map stops them."""

import re
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image
from shapely import LineString, Polygon, box

from pianta.errors import DataError, MapError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta_bench.data.folders import find_data, list_maps
from pianta_bench.harness.table import Figures, Part, Row, Summary
from pianta_bench.layout import scores as rooms
from pianta_bench.layout.measure import measure_layout
from pianta_bench.segmentation.measure import measure_segmentation
from tests.tiny_data import ONE_ROOM, OUTLINES, TRUE_FLOOR, show_lines, write_slam, write_survey

TIMES = {"seconds", "transforms"}
LASTING = {"rooms_before", "still_there", "kept_id"}
measure_survey = partial(measure_segmentation, methods=("thesis",), sets=("survey", "furniture"))


@pytest.fixture
def find(monkeypatch):
    """Lets reconstruct find a given floor."""

    def replace(floor: Floor) -> None:
        monkeypatch.setattr(rooms, "reconstruct", lambda *_, **__: floor)

    return replace


def scores_of(row: Row) -> Figures:
    return {key: figure for key, figure in row.figures.items() if key not in TIMES | LASTING}


def test_the_data_are_those_given_then_those_of_the_environment_then_those_beside_the_project(tmp_path, monkeypatch):
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
    """The rooms are 80 and 40 of the 124 px that the one room is wide, the wall between them is 4."""
    write_survey(tmp_path, "a")
    find(ONE_ROOM)
    table = measure_survey(tmp_path)
    assert [(part.name, part.method) for part in table.parts] == [("survey", "thesis"), ("furniture", "thesis")]
    for part in table.parts:
        (row,) = part.rows
        assert (row.item, row.failure, row.warned) == ("a", None, ())
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
    """20 px in the wall are no room, yet free cells; 120 px outside are a room of 0.3 m², but of no 1 m²."""
    write_survey(tmp_path, "a")
    truth = tmp_path / "survey" / "a_gt_segmentation.png"
    with Image.open(truth) as image:
        greys = np.array(image)
    greys[50:60, 101:103] = 251
    greys[65:75, 101:103] = 250
    greys[0:10, 0:12] = 255
    Image.fromarray(greys).save(truth)
    find(ONE_ROOM)
    for part in measure_survey(tmp_path).parts:
        figures = part.rows[0].figures
        assert figures["true"] == 3
        assert figures["precision"] == pytest.approx(100 * 80 / 124)
        assert figures["recall"] == pytest.approx(100 * 2 / 3)
        assert figures["precision_free"] == pytest.approx(100 * 4800 / 7220)
        assert figures["recall_free"] == 100


def test_free_cells_in_no_room_are_one_more_room(tmp_path, find):
    """The second room was left over, which is as good as found."""
    write_survey(tmp_path, "a")
    find(Floor(TRUE_FLOOR.rooms[:1]))
    figures = measure_survey(tmp_path).parts[0].rows[0].figures
    assert (figures["precision_free"], figures["recall_free"]) == (100, 50)
    assert (figures["precision_rest"], figures["recall_rest"]) == (100, 100)


def test_layout_of_one_room_where_there_are_two(tmp_path, find):
    """On free cells the larger room is 4 of 6 m wide, with its half of the wall 4.1 of 6.2 m."""
    write_slam(tmp_path, "a")
    find(ONE_ROOM)
    (part,) = measure_layout(tmp_path).parts
    assert scores_of(part.rows[0]) == pytest.approx(
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
        }
    )


def test_doors_of_the_layout_are_those_between_true_rooms(tmp_path, find):
    """The truth joins the first room to the second by a door, and what is found the second to a third, by mistake."""
    third = box(1, 0.2, 5, 0.8)
    write_slam(tmp_path, "a", outlines=(*OUTLINES, third))
    file = tmp_path / "slam" / "a_gt.xml"
    portal = "<portals><portal><target><id>0</id><id>1</id></target></portal></portals></space>"
    file.write_text(file.read_text().replace("</space>", portal, 1))
    rooms = (*TRUE_FLOOR.rooms, Room(3, third))
    right, wrong = (Door(pair, LineString([(5, 2), (5, 3)]), 1.0) for pair in ((1, 2), (2, 3)))
    for doors, precision, recall in (((), 0, 0), ((right,), 100, 100), ((wrong,), 0, 0), ((right, wrong), 50, 100)):
        find(Floor(rooms, doors))
        figures = measure_layout(tmp_path).parts[0].rows[0].figures
        assert (figures["door_precision"], figures["door_recall"]) == (precision, recall)


def test_the_true_rooms_score_100_but_for_the_walls_of_the_schools(tmp_path, find):
    write_survey(tmp_path, "a", "b")
    write_slam(tmp_path, "a", "b")
    find(TRUE_FLOOR)
    layout, segmentation = measure_layout(tmp_path), measure_survey(tmp_path)
    for row in (row for table in (layout, segmentation) for part in table.parts for row in part.rows):
        short = {"a_bc_walls": 100 * 6 / 6.2} if "a_bc_walls" in row.figures else {}
        counts = {key: 2 for key in ("found", "true", "matched") if key in row.figures}
        expected = dict.fromkeys(scores_of(row), 100) | counts | short
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
    tables = [measure(tmp_path, pictures=tmp_path / "out", track=track) for measure in (measure_layout, measure_survey)]
    for row in (row for table in tables for part in table.parts for row in part.rows):
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
        threads.append(cv2.getNumThreads())
        return TRUE_FLOOR

    rooms._load_method("thesis")
    monkeypatch.setattr(rooms, "perf_counter", lambda: next(clock))
    monkeypatch.setattr(rooms, "reconstruct", reconstruct)
    cv2.setNumThreads(2)
    try:
        floor, time = rooms.time_reconstruction(GridMap(np.array([[0, 100]], np.int8), 0.05), method="thesis")
        assert cv2.getNumThreads() == 2
    finally:
        cv2.setNumThreads(1)
    assert floor == TRUE_FLOOR
    assert threads == [1]
    assert time == {"seconds": 10.0, "transforms": 5.0}


@pytest.mark.parametrize("exception", [MapError("no\nroom"), RuntimeError("no room"), RecursionError(), MemoryError()])
def test_a_map_that_fails_is_named_and_counts_as_0(tmp_path, monkeypatch, exception):
    write_survey(tmp_path, "a", "b", "c")
    failing = iter([None, exception, None, None, None, None])

    def reconstruct(*_: object, **__: object) -> Floor:
        if (error := next(failing)) is not None:
            raise error
        return TRUE_FLOOR

    rooms._load_method("thesis")
    monkeypatch.setattr(rooms, "reconstruct", reconstruct)
    table = measure_survey(tmp_path)
    assert table.failed
    empty, furnished = table.parts
    reason = {MapError: "no room", RuntimeError: "RuntimeError: no room"}.get(
        type(exception), f"{type(exception).__name__}: {type(exception).__name__}"
    )
    assert [row.failure for row in empty.rows] == [None, reason, None]
    assert not any(row.failure for row in furnished.rows)
    nothing = dict.fromkeys(scores_of(empty.rows[1]), 0) | {"true": 2}
    assert scores_of(empty.rows[1]) == nothing
    assert all(empty.rows[1].figures[time] is None for time in TIMES)
    assert empty.summarise("precision").mean == pytest.approx(200 / 3)
    assert empty.summarise("found").mean == pytest.approx(4 / 3)
    assert furnished.summarise("precision").mean == 100
    assert f"b failed, scores not measured count as 0: {reason}" in show_lines(table)


def test_unreadable_files_fail_one_by_one(tmp_path, find):
    write_slam(tmp_path, "a", "b", "c", "d")
    find(TRUE_FLOOR)
    (tmp_path / "slam" / "a.png").unlink()
    (tmp_path / "slam" / "b_gt.xml").write_text("<building")
    (tmp_path / "slam" / "c.png").write_bytes(b"no image")
    (part,) = measure_layout(tmp_path).parts
    for row, told in zip(part.rows, ("exist", "XML", "image"), strict=False):
        assert told in str(row.failure)
        assert row.figures["found"] == 0
        assert row.figures["true"] is None
    assert part.rows[3].failure is None
    assert part.summarise("true") == Summary(2, None, 2)


def test_a_picture_that_cannot_be_written_keeps_the_scores(tmp_path, find):
    write_slam(tmp_path, "a")
    find(TRUE_FLOOR)
    (part,) = measure_layout(tmp_path, pictures=tmp_path / "none").parts
    assert part.rows[0].figures["a_fc_free"] == 100
    assert "write" in str(part.rows[0].failure)


def test_warnings_are_counted_and_kept_with_their_map(tmp_path, find):
    crossed = Polygon([(1, 1), (5, 1), (5, 4), (1, 4), (1, 0), (0, 0), (0, 2), (1, 2)])
    write_slam(tmp_path, "a", "b", outlines=(crossed, OUTLINES[1]))
    find(TRUE_FLOOR)
    table = measure_layout(tmp_path)
    for row in table.parts[0].rows:
        (warned,) = row.warned
        assert f"{row.item}_gt.xml' was repaired" in warned
    assert "Warnings on 2 of 2 maps; --json lists them." in show_lines(table)


@pytest.mark.parametrize("width", [80, 120])
def test_every_figure_is_legible_in_a_terminal_of_80_columns(tmp_path, find, width):
    school, map_ = "school_with_21_[b]ody", "Freiburg[101]_scan"
    write_slam(tmp_path, school)
    write_survey(tmp_path, map_)
    find(TRUE_FLOOR)
    lines = show_lines(measure_layout(tmp_path), width) + show_lines(measure_survey(tmp_path), width)
    assert max(map(len, lines)) <= width
    assert not any("…" in line for line in lines)
    for name, count in ((school, 1), (map_, 2)):
        # A long name goes on in the next line
        starts = [n for n, line in enumerate(lines) if (first := line.split(" ")[0]) and name.startswith(first)]
        rows = [[*lines[n].split(), lines[n + 1]] for n in starts]
        assert len(rows) == count
        assert all(name in (row[0], row[0] + row[-1]) for row in rows)
        assert all(len(row) in (11, 12, 14) and row.count("100.0") >= 5 for row in rows)


def test_the_printed_figures_are_those_of_the_thesis(tmp_path, find):
    """Table 3.1, cell by cell, as it stands in the thesis."""
    write_survey(tmp_path, "a")
    write_slam(tmp_path, "a")
    find(TRUE_FLOOR)
    lines = [
        re.sub(" +", " ", line) for bench in (measure_layout, measure_survey) for line in show_lines(bench(tmp_path))
    ]
    assert [line for line in lines if line.startswith("thesis, ")] == [
        "thesis, our method 20 87.6 ± 5.7 87.8 ± 4.5",
        "thesis, our method 20 90.1 ± 6.3 90.0 ± 4.1 94.0 ± 2.2 89.5 ± 6.2",
        "thesis, morph 20 88.5 ± 9.2 98.1 ± 2.4 90.5 ± 8.1 84.6 ± 7.2",
        "thesis, distance 20 88.4 ± 9.3 96.9 ± 2.8 88.4 ± 8.5 76.1 ± 12.3",
        "thesis, Voronoi 20 94.8 ± 5.0 95.0 ± 2.3 94.5 ± 5.1 86.6 ± 5.2",
        "thesis, feature-based 20 90.2 ± 8.0 89.2 ± 11.8 87.0 ± 14.5 85.5 ± 7.2",
    ]


def link_maps(data: Path, folder: Path, *names: str) -> Path:
    """A data folder with some of the maps; all of them take `pianta bench` a minute."""
    for file in [file for name in names for file in data.glob(f"{name}[._]*")]:
        (folder / data.name).mkdir(exist_ok=True)
        (folder / data.name / file.name).symlink_to(file.resolve())
    return folder


def assert_means_above(part: Part, bars: dict[str, float]) -> None:
    means = {key: part.summarise(key).mean for key in bars}
    assert len(part.rows) == 3
    assert all((means[key] or 0) >= bar for key, bar in bars.items()), means


@pytest.mark.slow
def test_layout_of_three_schools_is_above_the_bars(data, tmp_path):
    table = measure_layout(link_maps(data / "slam", tmp_path, "plans2", "rockislandsecondfloor", "sidneyriver"))
    assert not table.failed
    assert_means_above(table.parts[0], {"a_fc_free": 93, "a_bc_free": 92.5, "a_fc_walls": 87, "a_bc_walls": 88})


@pytest.mark.slow
def test_segmentation_of_three_maps_is_above_the_bars(data, tmp_path):
    table = measure_survey(link_maps(data / "survey", tmp_path, "Freiburg79_scan", "lab_f_scan", "office_a"))
    assert not table.failed
    empty, furnished = table.parts
    assert_means_above(empty, {"precision_free": 90, "recall_free": 91})
    assert_means_above(furnished, {"precision_free": 89, "recall_free": 89.5})
