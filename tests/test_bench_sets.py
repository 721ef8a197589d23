"""The sets of maps that segmentation is measured on: how each is read and counted, and the tables of all of them."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from shapely import LineString, box

from pianta.errors import DataError, MapError, OptionError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.io.maps import read_map
from pianta_bench.data import map_sets as sets
from pianta_bench.data.folders import SET_NAMES
from pianta_bench.data.id_truth import read_id_truth
from pianta_bench.data.map_sets import SETS, choose_sets
from pianta_bench.harness.report import save_results
from pianta_bench.layout import timing
from pianta_bench.segmentation.counts import pool_counts
from pianta_bench.segmentation.measure import measure as measure_segmentation
from pianta_bench.segmentation.tables import tabulate
from tests.bench_results import list_rows, show_lines
from tests.tiny_data import (
    ONE_ROOM,
    ROOMS,
    TRUE_FLOOR,
    write_all_sets,
    write_colors,
    write_doors,
    write_slam,
    write_survey,
    write_vacuum,
)

PERFECT = {"precision": 100, "recall": 100, "a_fc": 100, "mean_iou": 100, "f1": 100}


@pytest.fixture
def find(monkeypatch):
    """Replaces reconstruct by a function that returns given floors in order, and then always the last one."""

    def replace(*floors: Floor) -> None:
        left = list(floors)
        monkeypatch.setattr(timing, "_load_method", lambda _: None)
        monkeypatch.setattr(timing, "reconstruct", lambda *_, **__: left.pop(0) if len(left) > 1 else left[0])

    return replace


def measure_set(data, name: str) -> list[dict[str, float | None]]:
    results = measure_segmentation(data, methods=("thesis",), sets=(name,))
    assert not results.failed
    assert {item.part for item in results.items} == {name}
    return [row.figures for row in list_rows(results, name)]


def pick(figures: dict[str, float | None], *keys: str) -> list[float | None]:
    return [figures[key] for key in keys]


def test_the_names_of_the_sets_are_those_of_the_help():
    assert tuple(SETS) == SET_NAMES


def test_the_true_floor_is_perfect_on_every_set(tmp_path, find):
    write_all_sets(tmp_path, "a")
    find(TRUE_FLOOR)
    results = measure_segmentation(tmp_path, methods=("thesis",))
    assert [item.part for item in results.items] == list(SET_NAMES)
    for part in SET_NAMES:
        (row,) = list_rows(results, part)
        number = 1 if part == "doors" else 2
        assert row.failure is None
        assert {key: row.figures[key] for key in PERFECT} == PERFECT
        assert pick(row.figures, "found", "true", "matched") == [number] * 3


def test_clutter_counts_free_cells_on_both_sides(tmp_path, find):
    """The wall between the rooms is 4 of 124 px wide and has no colour, as furniture has none."""
    write_colors(tmp_path / "clutter", "a")
    find(ONE_ROOM)
    (figures,) = measure_set(tmp_path, "clutter")
    assert pick(figures, "precision", "precision_free") == pytest.approx([100 * 80 / 120, 100 * 80 / 120])


def test_homes_of_vacuum_robots_count_free_cells_on_both_sides(tmp_path, find):
    """The wall is 4 of 124 px wide and does not count, so that the one room has 120 px, 80 of them in the larger."""
    write_vacuum(tmp_path, "a")
    find(ONE_ROOM)
    (figures,) = measure_set(tmp_path, "vacuum")
    assert pick(figures, "precision", "mean_iou", "found", "true") == pytest.approx([100 * 80 / 120, 50, 1, 2])
    true_map = SETS["vacuum"].read(tmp_path / "vacuum", "a")
    assert np.unique(true_map.spaces).tolist() == [0, 7, 300]


def test_a_coloured_image_is_no_truth_of_room_ids(tmp_path):
    Image.new("RGB", (4, 4)).save(tmp_path / "a_gt.png")
    with pytest.raises(MapError, match="grey"):
        read_id_truth(tmp_path / "a_gt.png")


def test_walls_of_the_schools_do_not_count(tmp_path, find):
    write_slam(tmp_path, "a")
    find(ONE_ROOM)
    (figures,) = measure_set(tmp_path, "schools")
    assert pick(figures, "precision", "mean_iou", "found", "true") == pytest.approx([100 * 40 / 60, 50, 1, 2])


def test_behind_a_closed_door_only_that_room_counts(tmp_path, find):
    """The smaller room, 40 of 120 free px wide, is behind a door that is closed in the last map."""
    write_doors(tmp_path, "a", "b")
    write_survey(tmp_path, "a")
    find(TRUE_FLOOR, ONE_ROOM)
    own, swallowed = measure_set(tmp_path, "doors")
    assert pick(own, "precision", "recall", "mean_iou", "f1", "found", "true") == [100, 100, 100, 100, 1, 1]
    assert pick(swallowed, "precision", "recall", "mean_iou") == pytest.approx([100 / 3, 100, 100 / 3])
    assert pick(swallowed, "f1", "found", "true", "precision_rest") == [0, 1, 1, None]


def test_ids_and_rooms_that_last_are_counted_where_maps_grow(tmp_path, find):
    """The rooms of the second step get the ids of the first; the third step has one room less."""
    write_colors(tmp_path / "partial" / "freiburg79", "r_1", "r_2", "r_3")
    swapped = Floor((Room(1, ROOMS[1]), Room(2, ROOMS[0])))
    find(TRUE_FLOOR, swapped, Floor((Room(1, ROOMS[1]),)))
    results = measure_segmentation(tmp_path, methods=("thesis",), sets=("growing",))
    rows = list_rows(results, "growing")
    lasting = [pick(row.figures, "rooms_before", "still_there", "kept_id") for row in rows]
    assert lasting == [[0, 0, 0], [2, 2, 2], [2, 1, 1]]
    note = "thesis: 75.0% of rooms are there in the next step, 100.0% of these with their id."
    assert note in " ".join(show_lines(tabulate(results), results)).replace("  ", " ")


def test_counts_of_right_split_and_merged_rooms_and_of_doors(tmp_path, find):
    """In a the smaller room is in two halves, and the larger has an entrance; in b there is one room for two."""
    write_vacuum(tmp_path, "a", "b")
    write_doors(tmp_path, "a")
    halves = (Room(2, box(5.2, 1, 7.2, 2.5)), Room(3, box(5.2, 2.5, 7.2, 4)))
    wall = LineString([(5.1, 2), (5.1, 3)])
    doors = tuple(Door(pair, wall, 1.0) for pair in ((1, 2), (2, 3), (1, None)))
    find(Floor((Room(1, ROOMS[0]), *halves), doors), ONE_ROOM)
    results = measure_segmentation(tmp_path, methods=("thesis",), sets=("vacuum",), count=True)
    names = "counted_true", "counted_found", "right", "right_whole", "splits", "merges", "no_rooms"
    rows = [pick(row.figures, *names, "doors", "within", "nowhere") for row in list_rows(results, "vacuum")]
    assert rows == [[2, 3, 1, 1, 1, 0, 0, 3, 1, 1], [2, 1, 1, 1, 0, 1, 0, 0, 0, 0]]
    pooled = {record["metric"]: record["value"] for record in pool_counts(results, "vacuum")}
    assert (pooled["share_right"], pooled["splits_per_map"], pooled["merges_per_map"]) == (50, 0.5, 0.5)
    assert pooled["share_doors_wrong"] == pytest.approx(200 / 3)
    lines = [line.split() for line in show_lines(tabulate(results), results)]
    assert ["thesis", "4", "50.0", "50.0", "0.5", "0.5", "0", "3", "1", "1", "66.7"] in lines
    assert ["a", "2", "3", "1", "1", "1", "0", "0", "3", "1", "1"] in lines
    find(TRUE_FLOOR)
    assert not [*pool_counts(measure_segmentation(tmp_path, methods=("thesis",), sets=("doors",), count=True), "doors")]


def test_true_rooms_of_a_map_that_fails_are_counted(tmp_path, monkeypatch):
    write_vacuum(tmp_path, "a")

    def fail(*_: object, **__: object) -> None:
        raise MapError("no room")

    monkeypatch.setattr(timing, "_load_method", lambda _: None)
    monkeypatch.setattr(timing, "reconstruct", fail)
    results = measure_segmentation(tmp_path, methods=("thesis",), sets=("vacuum",), count=True)
    pooled = {record["metric"]: record["value"] for record in pool_counts(results, "vacuum")}
    assert (pooled["all_counted_true"], pooled["share_right"], pooled["share_doors_wrong"]) == (2, 0, None)


def test_each_map_is_read_once_for_all_methods(tmp_path, find, monkeypatch):
    write_survey(tmp_path, "a", "b")
    find(TRUE_FLOOR)
    read = []

    def note_and_read(path: Path, *, resolution: float) -> GridMap:
        read.append(path.name)
        return read_map(path, resolution=resolution)

    monkeypatch.setattr(sets, "read_map", note_and_read)
    results = measure_segmentation(tmp_path, methods=("thesis", "distance"), sets=("survey",))
    assert read == ["a.png", "b.png"]
    for method in ("thesis", "distance"):
        assert [record["item"] for record in results.select(method=method, metric="f1")] == ["a", "b"]


def test_several_methods_are_summarised_and_their_maps_printed_on_request(tmp_path, find):
    """Only the first reading, of map a by the first method, is right."""
    write_all_sets(tmp_path, "a", "b")
    find(TRUE_FLOOR, ONE_ROOM)
    methods = "thesis", "morphological"
    results = measure_segmentation(tmp_path, methods=methods, sets=("survey", "schools"))
    output_lines = show_lines(tabulate(results), results)
    lines = [line.replace(" ± ", "±").split() for line in output_lines]
    rows = [line for line in lines if len(line) > 2 and line[0] in methods]
    assert rows[0] == ["thesis", "82.3±25.1", "100.0±0.0", "82.3±25.1", "74.2±36.5", "83.3±23.6"]
    assert rows[1] == ["morphological", "64.5±0.0", "100.0±0.0", "64.5±0.0", "48.4±0.0", "66.7±0.0"]
    assert [row[1] for row in rows[2:4]] == ["0.75", "0.50"]
    # Free cells; the same with the rest, which is empty; no layout was drawn; then what the thesis prints
    counts = [f"{share}±0.0" for share in ("66.7", "100.0", "66.7", "100.0")]
    assert ["morphological", *counts, "–", "–"] in rows
    assert ["morphological", "88.5±9.2", "98.1±2.4"] in rows
    assert not any(line[:1] == ["a"] for line in lines)
    assert max(map(len, output_lines)) <= 80
    results.options["maps"] = True
    assert sum(line.startswith("a ") for line in show_lines(tabulate(results), results)) == 4


def test_the_file_has_set_and_method_of_every_figure(tmp_path, find):
    write_survey(tmp_path, "a")
    find(ONE_ROOM)
    methods = ["thesis", "distance"]
    results = measure_segmentation(tmp_path, methods=methods)
    save_results("segmentation", tabulate(results), results, tmp_path / "figures.json")
    content = json.loads((tmp_path / "figures.json").read_text())
    assert content["options"] == {"methods": methods, "sets": ["survey", "furniture"], "maps": False, "count": False}
    free = [record for record in content["records"] if record["metric"] == "precision_free"]
    assert [(record["part"], record["method"]) for record in free] == [
        (name, method) for name in ("survey", "furniture") for method in methods
    ]
    assert [record["value"] for record in free] == [pytest.approx(200 / 3)] * 4
    cells = [cell for table in content["tables"] for cell in table["cells"] if cell["column"] == "found / true"]
    assert [cell["mean"] for cell in cells] == [0.5] * 4


def test_sets_that_are_not_in_the_data_are_left_out_unless_named(tmp_path):
    write_slam(tmp_path, "a")
    (tmp_path / "clutter").mkdir()
    assert choose_sets((), tmp_path) == {SETS["schools"]: ["a"]}
    assert choose_sets(("schools", "schools"), tmp_path) == {SETS["schools"]: ["a"]}
    with pytest.raises(DataError, match="clutter"):
        choose_sets(("schools", "clutter"), tmp_path)
    with pytest.raises(OptionError, match="attic"):
        choose_sets(("attic",), tmp_path)
    with pytest.raises(DataError, match=r"clutter.*--data"):
        choose_sets((), tmp_path / "none")


def test_the_rooms_of_real_homes_lie_on_free_cells(data):
    for name, count in (("z10_1056_paths", 7), ("d9_1093_huge", 14)):
        true_map = SETS["vacuum"].read(data / "vacuum", name)
        assert len(np.unique(true_map.spaces)) == 1 + count
        assert true_map.free[true_map.spaces > 0].all()


@pytest.mark.slow
def test_the_rooms_behind_closed_doors_of_a_real_building(data):
    """The twelve closed doors of Franch1 close off ten spaces."""
    true_map = SETS["doors"].read(data / "doors", "franch1")
    areas = np.bincount(true_map.spaces.ravel())[1:] * 0.05**2
    areas = areas[areas > 0]
    assert (len(areas), areas.min() > 0.25) == (10, True)
    assert true_map.free[true_map.spaces > 0].all()


def test_real_coloured_truths_lie_on_their_maps(data):
    for name, count in (("freiburg_building101", 10), ("umicfirstfloor_photo20200108", 28)):
        true_map = SETS["clutter"].read(data / "clutter", name)
        assert true_map.spaces.max() == count
        assert true_map.free[true_map.spaces > 0].mean() > 0.85


def test_a_picture_shows_truth_and_result_side_by_side(tmp_path, find):
    write_survey(tmp_path, "a")
    find(Floor((Room(1, ROOMS[0]), Room(2, box(5.2, 1, 7.2, 1.6)))))
    measure_segmentation(tmp_path, methods=("thesis",), sets=("survey",), pictures=tmp_path)
    with Image.open(tmp_path / "thesis" / "survey" / "a.png") as image:
        picture = np.asarray(image.convert("RGB")).astype(int)
    left, right = picture[:, : picture.shape[1] // 2], picture[:, picture.shape[1] // 2 :]
    height, width = left.shape[:2]
    spot = height // 2, width // 3
    assert (left[spot] == right[spot]).all()
    assert len(set(left[spot])) > 1
    red = [((side - (204, 20, 40)) ** 2).sum(axis=2) < 100 for side in (left, right)]
    assert all(0 < side.mean() < 0.1 for side in red)
