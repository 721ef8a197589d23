"""The bench of calibration: right rooms and doors of tiny maps, and shares by probability by hand."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from shapely import LineString

from pianta.errors import DataError, MapError, OptionError
from pianta.floor import Door, Floor, Room
from pianta_bench.calibration import measure as calibration
from pianta_bench.calibration.figures import COLORS
from pianta_bench.calibration.measure import measure
from pianta_bench.calibration.tables import measure_ranking, tabulate
from pianta_bench.data.folders import CALIBRATION_SET_NAMES, DEFAULT_CALIBRATION_SETS
from pianta_bench.data.layout_sets import LAYOUT_SETS, LayoutSet
from pianta_bench.data.map_sets import SETS
from pianta_bench.harness.records import Results
from tests.bench_results import show_lines
from tests.command_line import list_files, run_pianta
from tests.tiny_data import (
    ONE_ROOM,
    OUTLINES,
    ROOMS,
    write_all_sets,
    write_building,
    write_colors,
    write_survey,
    write_vacuum,
)

# The room of 12 m² has an IoU of 12 / 18 with both together, the smaller one is a room of its own.
FLOOR = Floor((Room(1, ROOMS[0], probability=0.9), Room(2, ROOMS[1], probability=0.25)))
BOTH = Floor((replace(ONE_ROOM.rooms[0], probability=0.35),))


@pytest.fixture
def find(monkeypatch):
    """Replaces find_rooms by a function that returns given floors in order, the last one again and again."""

    def replace_function(*floors: Floor | Exception) -> None:
        left = list(floors)

        def find_rooms(*_: object, **__: object) -> Floor:
            floor = left.pop(0) if len(left) > 1 else left[0]
            if isinstance(floor, Exception):
                raise floor
            return floor

        monkeypatch.setattr(calibration, "find_rooms", find_rooms)

    return replace_function


def regions_of(results: Results, item: str, regions: str = "rooms") -> list[tuple[float, float]]:
    """Probability and whether it is right, of each room or door of a map."""
    records = results.select(item=item, regions=regions)
    values = {metric: [each["value"] for each in records if each["metric"] == metric] for metric in calibration_metrics}
    return list(zip(values["probability"], values["right"], strict=True))


calibration_metrics = ("probability", "right")


def test_rooms_are_right_as_the_bench_of_segmentation_counts_them(tmp_path, find):
    write_vacuum(tmp_path, "a", "b", "c")
    find(FLOOR, BOTH, MapError("no room"))
    results = measure(tmp_path, sets=("vacuum",))
    assert regions_of(results, "a") == [(0.9, 1), (0.25, 1)]
    # 12 of 18 m² of free cells are one true room
    assert regions_of(results, "b") == [(0.35, 1)]
    assert regions_of(results, "c") == []
    assert [item.failure for item in results.items] == [None, None, "no room"]


def test_doors_are_right_near_a_true_door(tmp_path, find, monkeypatch):
    """The true door is 1 m wide: a middle 0.4 m away is right, one 0.6 m away is not, and entrances do not count."""
    lines = [LineString([(5.1, y), (5.1, y + 1)]) for y in (1.4, 2.6)]
    entrance = Door((1, None), LineString([(1, 2), (1, 3)]), 1.0, probability=0.7)
    doors = tuple(Door((1, 2), line, 1.0, probability=0.8) for line in lines)
    truth = replace(FLOOR, doors=(Door((1, 2), LineString([(5.1, 1), (5.1, 2)]), 1.0),))
    find(replace(FLOOR, doors=(*doors, entrance)))
    write_vacuum(tmp_path, "home_0")
    grid = SETS["vacuum"].read(tmp_path / "vacuum", "home_0").grid
    layout_set = LayoutSet("worlds", lambda _: ["home_0"], lambda *_: (grid, truth))
    monkeypatch.setitem(LAYOUT_SETS, "worlds", layout_set)
    results = measure(tmp_path, sets=("worlds",))
    assert regions_of(results, "home_0", "doors") == [(0.8, 1), (0.8, 0)]
    # Both join the two rooms of the true one
    assert regions_of(results, "home_0", "doors by place or rooms") == [(0.8, 1), (0.8, 1)]
    assert regions_of(results, "home_0") == [(0.9, 1), (0.25, 1)]


def test_figures_of_four_rooms_by_hand(tmp_path):
    """Bins of 0.8 to 0.9 with two rooms, one right, and of 0.2 to 0.3 with two, one right.

    The mean distances are 0.85 - 0.5 and 0.5 - 0.25; a right room has the higher probability in 3 of 4 pairs.
    """
    results = Results()
    results.items.append(calibration_item("clutter"))
    for number, (probability, right) in enumerate([(0.9, 1), (0.8001, 0), (0.25, 0), (0.25, 1)], start=1):
        figures = {("rooms", number, "probability"): probability, ("rooms", number, "right"): float(right)}
        results.add("clutter", "a", figures, names=calibration.NAMES)
    set_table, bin_table = tabulate(results)
    row = {name: cell.mean for name, cell in set_table.rows["clutter"].items()}
    assert row["n"] == 4
    assert row["right,\n%"] == 50
    assert row["calibration\nerror"] == pytest.approx(100 * ((0.85 - 0.5) + 0.25) / 2, abs=0.01)
    # 0.9 beats both wrong ones, 0.25 one of them by half: 2.5 of 4
    assert row["ranking,\n%"] == 62.5
    assert bin_table.rows["80 to 90 %"]["clutter, right, %"].mean == 50
    assert bin_table.rows["20 to 30 %"]["clutter, n"].mean == 2
    assert bin_table.rows["0 to 10 %"]["clutter, right, %"].mean is None


def calibration_item(part: str) -> Any:
    from pianta_bench.harness.records import Item

    return Item(part, "a")


def test_ranking_by_hand():
    assert measure_ranking(np.array([0.9, 0.1]), np.array([True, False])) == 100
    assert measure_ranking(np.array([0.1, 0.9]), np.array([True, False])) == 0
    assert measure_ranking(np.array([0.5, 0.5]), np.array([True, False])) == 50
    assert measure_ranking(np.array([0.5, 0.5]), np.array([True, True])) is None


def test_sets_together(tmp_path, find):
    """Maps of robots in furnished places are one more row; with another set, all sets too."""
    write_vacuum(tmp_path, "a")
    write_colors(tmp_path / "clutter", "a")
    find(FLOOR)
    results = measure(tmp_path, sets=("clutter", "vacuum"))
    assert [*tabulate(results)[0].rows] == ["clutter", "vacuum", "real maps"]
    lines = " ".join(show_lines(tabulate(results), results))
    assert "doors" not in lines
    write_survey(tmp_path, "a")
    (tmp_path / "survey" / "a_layout_gt.xml").write_text(write_building(OUTLINES, 0.05))
    results = measure(tmp_path, sets=("clutter", "vacuum", "furniture"))
    assert [*tabulate(results)[0].rows] == ["clutter", "vacuum", "furniture", "real maps", "all"]
    assert [item.failure for item in results.items] == [None] * 3


def test_the_names_of_the_sets_are_those_of_the_help(tmp_path, monkeypatch):
    write_all_sets(tmp_path, "a")
    monkeypatch.setattr(calibration, "run_steps", lambda *_, **__: ())
    assert {*CALIBRATION_SET_NAMES} <= {*SETS, *LAYOUT_SETS}
    assert {*DEFAULT_CALIBRATION_SETS} <= {*CALIBRATION_SET_NAMES} == {*COLORS}
    assert not any(SETS[name].in_places for name in CALIBRATION_SET_NAMES if name in SETS)
    assert measure(tmp_path).options["sets"] == [*DEFAULT_CALIBRATION_SETS]


def test_options_without_meaning_are_refused(tmp_path):
    write_vacuum(tmp_path, "a")
    with pytest.raises(OptionError, match="attic"):
        measure(tmp_path, sets=("attic",))
    with pytest.raises(OptionError, match="none"):
        measure(tmp_path, sets=("vacuum",), items=("none",))
    with pytest.raises(DataError, match="clutter"):
        measure(tmp_path, sets=("clutter",))


def test_the_command_prints_tables_and_draws_the_diagram(tmp_path, find):
    write_vacuum(tmp_path, "a")
    find(FLOOR)
    pictures = tmp_path / "pictures"
    options = "--data", tmp_path, "--set", "vacuum", "--pictures", pictures, "--json", tmp_path / "new.json"
    code, out, err = run_pianta("bench", "calibration", *options)
    assert (code, err) == (0, "")
    assert "Calibration of the probabilities of rooms" in out
    assert {*list_files(pictures)} == {"reliability.png"}
    assert (tmp_path / "new.json").is_file()
