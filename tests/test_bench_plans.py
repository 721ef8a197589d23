"""`pianta bench plans`: tiny plans, and readers whose figures can be reckoned by hand."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rich.console import Console
from shapely import LineString, box
from shapely.affinity import translate

from pianta.errors import DataError, OptionError, PlanError
from pianta.floor import Door, Floor, Room, scale_floor
from pianta.gridmap import GridMap
from pianta_bench._plans_cli import SET_NAMES
from pianta_bench.harness.comparison import ComparisonTable, show_comparisons
from pianta_bench.harness.table import BenchTable, Column, Part, Row
from pianta_bench.plans import measure as plans_module
from pianta_bench.plans.figures import FOUND_DOOR, TRUTH, paint_plan
from pianta_bench.plans.measure import PlanBench, PlanResult, choose_plans, measure_plans
from pianta_bench.plans.plan_sets import (
    COLORED,
    DRAWN,
    EVACUATION,
    KIND_OF_PLAN,
    KINDS,
    LINES,
    SCREENSHOT,
    THIN,
    WITHOUT_DOOR_SYMBOLS,
    TruePlan,
    detect_input_kind,
    draw_true_plan,
    find_defects,
    find_image,
    list_plans,
    read_true_plan,
)
from pianta_bench.plans.scores import COLUMNS, judge_floors, merge_floors, move_floor, score_reading
from pianta_bench.plans.tables import accuracy_of, is_sound, list_faults, tabulate_plans
from tests.command_line import list_files, run_pianta
from tests.tiny_data import write_school

# The sheet, pixels of 0.1 m, and on it a corridor of 8 m × 2 m and two rooms of 4 m × 4 m below it.
SHAPE = (80, 100)
GRID = GridMap(np.full(SHAPE, -1), 0.1)
CORRIDOR, WEST, EAST = box(0, 6, 8, 8), box(0, 2, 4, 6), box(4, 2, 8, 6)
DOORS = (Door((1, 2), LineString([(1.55, 6), (2.45, 6)]), 0.9), Door((1, 3), LineString([(5.55, 6), (6.45, 6)]), 0.9))
TRUE = Floor(tuple(Room(number, polygon) for number, polygon in enumerate((CORRIDOR, WEST, EAST), 1)), DOORS)
WHOLE = Floor((Room(1, box(0, 2, 8, 8)),))
PLAN = TruePlan("tiny", np.full((*SHAPE, 3), 255, np.uint8), TRUE, GRID, LINES, "school")
SCORES = ("a_fc", "a_bc", "precision", "recall", "mean_iou", "f1")


@dataclass(frozen=True)
class FakeScale:
    resolution: float
    source: str = "doors"
    spread: float = 0.0


@dataclass(frozen=True)
class FakeFloor:
    floor: Floor
    grid: GridMap = GRID
    scale: FakeScale = field(default_factory=lambda: FakeScale(0.1))


@dataclass(frozen=True)
class FakeReading:
    floors: tuple[FakeFloor, ...]


@dataclass
class FakeReader:
    """Finds a floor by the name of the plan, and by itself the whole as one room without symbols."""

    floors: Mapping[str, Floor]
    calls: list[tuple[str, bool, bool]] = field(default_factory=list)

    def __call__(self, path: Path, *, with_symbols: bool, with_text: bool) -> FakeReading:
        self.calls.append((path.stem, with_symbols, with_text))
        if path.stem not in self.floors:
            raise PlanError(f"plan {path.name} shows no walls")
        return FakeReading((FakeFloor(self.floors[path.stem] if with_symbols else WHOLE),))


def find_nothing(path: Path, *, with_symbols: bool, with_text: bool) -> FakeReading:
    return FakeReading(())


def write_plan(data: Path, name: str, *, kind: str = "SCHOOL", suffix: str = ".png") -> None:
    folder = data / "floorplans"
    folder.mkdir(parents=True, exist_ok=True)
    typed = f"<building_type><main_type>{kind}</main_type></building_type><floor>"
    (folder / f"{name}.xml").write_text(write_school(["KK"]).replace("<floor>", typed))
    Image.fromarray(PLAN.colors).save(folder / f"{name}{suffix}")


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    write_plan(tmp_path, "good")
    write_plan(tmp_path, "hard", kind="OFFICE", suffix=".jpg")
    return tmp_path


def shares_of(figures: Mapping[str, float | None]) -> list[float | None]:
    return [figures[key] for key in SCORES]


def test_a_perfect_reading_of_a_wrong_scale_in_another_frame():
    frame = GridMap(np.full(SHAPE, -1), 0.2, (5.0, -3.0, 0.5))
    found = move_floor(TRUE, GRID, frame)
    assert found.doors[0].width == pytest.approx(1.8)
    figures = score_reading(FakeReading((FakeFloor(found, frame, FakeScale(0.2)),)), PLAN)
    assert shares_of(figures) == pytest.approx([100] * 6)
    assert (figures["doors_f1"], figures["edges_f1"]) == pytest.approx((100, 100))
    assert figures["scale_error"] == pytest.approx(100)
    assert (figures["found"], figures["true"], figures["floors"], figures["aside"]) == (3, 3, 1, 0)


def test_rooms_and_doors_are_scored():
    """One room of 48 m² instead of three of 16 m²; a door 0.3 m aside, and one too many."""
    rooms = score_reading(FakeReading((FakeFloor(WHOLE),)), PLAN)
    assert shares_of(rooms) == pytest.approx([100 / 3, 100, 100 / 3, 100, 100 / 3, 0])
    moved = [Door(door.rooms, translate(door.line, 0.3), 0.9) for door in DOORS[:1]]
    stray = Door((2, 3), LineString([(4, 3), (4, 4)]), 1.0)
    entrance = Door((1, None), LineString([(0, 6.5), (0, 7.5)]), 1.0)
    figures = score_reading(FakeReading((FakeFloor(Floor(TRUE.rooms, (*moved, stray, entrance))),)), PLAN)
    assert (figures["doors_precision"], figures["doors_recall"], figures["doors_f1"]) == pytest.approx((50, 50, 50))
    assert (figures["edges_precision"], figures["edges_recall"]) == pytest.approx((50, 50))


def test_openings_join_rooms_and_are_no_doors():
    opening = Door((2, 3), LineString([(4, 3), (4, 4)]), 1.0, "opening")
    figures = score_reading(FakeReading((FakeFloor(Floor(TRUE.rooms, (DOORS[0], opening))),)), PLAN)
    assert (figures["doors_precision"], figures["doors_recall"]) == pytest.approx((100, 50))
    assert (figures["edges_precision"], figures["edges_recall"]) == pytest.approx((50, 50))


def test_the_other_floor_of_a_sheet_is_not_judged():
    other = Floor((Room(1, box(0, 0, 8, 1.5)),))
    figures = score_reading(FakeReading((FakeFloor(TRUE), FakeFloor(other))), PLAN)
    assert shares_of(figures) == pytest.approx([100] * 6)
    assert figures["aside"] == pytest.approx(100 * 12 / 60)
    assert (figures["found"], figures["floors"]) == (3, 2)


def test_floors_are_judged_with_all_their_rooms():
    """Alone, or mostly on the truth, a floor answers for what it finds beside it."""
    with_more = Floor((*TRUE.rooms, Room(4, box(0, 0, 8, 2))), DOORS)
    alone = Floor((Room(1, box(0, 0, 8, 1.5)),))
    for floors in ((with_more,), (with_more, alone)):
        judged, _ = judge_floors([FakeFloor(floor) for floor in floors], PLAN)
        assert len(judged.rooms) == 4
    assert judge_floors([FakeFloor(alone)], PLAN) == (alone, 0)


def test_floors_all_beside_the_truth_are_all_judged():
    strays = [Floor((Room(1, box(x, 0, x + 2, 1)),)) for x in (0, 4)]
    judged, aside = judge_floors([FakeFloor(floor) for floor in strays], PLAN)
    assert len(judged.rooms) == 2
    assert aside == 0


def test_a_floor_that_was_found_in_parts_is_judged_whole():
    parts = [Floor(TRUE.rooms[:2], DOORS[:1]), Floor(TRUE.rooms[2:])]
    judged, aside = judge_floors([FakeFloor(floor) for floor in parts], PLAN)
    assert [room.polygon for room in judged.rooms] == [room.polygon for room in TRUE.rooms]
    assert [door.rooms for door in judged.doors] == [(1, 2)]
    assert aside == 0


def test_no_floor_scores_nothing():
    figures = score_reading(FakeReading(()), PLAN)
    assert shares_of(figures) == [0] * 6
    assert (figures["doors_f1"], figures["floors"], figures["scale_error"]) == (0, 0, None)


def test_merged_floors_are_numbered_on():
    shifted = Floor((Room(7, EAST), Room(9, WEST)), (Door((7, 9), LineString([(4, 3), (4, 4)]), 1),))
    merged = merge_floors([TRUE, shifted])
    assert [room.id for room in merged.rooms] == [1, 2, 3, 4, 5]
    assert [door.rooms for door in merged.doors] == [(1, 2), (1, 3), (4, 5)]


def test_a_grid_of_another_shape_is_refused():
    with pytest.raises(PlanError, match=r"\(80, 90\).*\(80, 100\)"):
        move_floor(TRUE, GridMap(np.full((80, 90), -1), 0.1), GRID)


@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_truths_come_in_the_frame_of_their_image(tiny):
    plan = read_true_plan(tiny, "good")
    assert plan.grid.shape == SHAPE
    assert plan.grid.resolution == pytest.approx(0.1)
    assert [room.polygon.equals(true.polygon) for room, true in zip(plan.truth.rooms, TRUE.rooms, strict=True)] == [
        True
    ] * 3
    assert (plan.building_type, plan.kind, plan.draws_doors, plan.defects) == ("school", THIN, True, ())
    assert find_image(tiny, "hard").suffix == ".jpg"
    with pytest.raises(DataError, match="absent"):
        find_image(tiny, "absent")


def test_truths_that_leave_the_image_or_lie_twice_are_not_sound():
    assert list(find_defects(TRUE, GRID)) == []
    assert list(find_defects(scale_floor(TRUE, 1.5, 1), GRID)) == ["leaves the image by 20 px"]
    assert list(find_defects(scale_floor(TRUE, 1.06, 1.06), GRID)) == []
    twice = Floor((*TRUE.rooms, Room(4, box(0, 2, 2, 4))))
    assert list(find_defects(twice, GRID)) == ["8% of its area is in two rooms"]


def test_kinds_are_told_by_pixels():
    paper = np.full((100, 100, 3), 255, np.uint8)
    lines, colored, signs, screen = paper.copy(), paper.copy(), paper.copy(), paper.copy()
    lines[::20] = 0
    colored[:30] = (240, 170, 90)
    signs[:10, :10], signs[20:30, :10] = (220, 0, 0), (0, 170, 60)
    screen[:80] = (90, 85, 80)
    kinds = [detect_input_kind(colors) for colors in (paper, lines, colored, signs, screen)]
    assert kinds == [THIN, LINES, COLORED, EVACUATION, SCREENSHOT]


@pytest.mark.parametrize("name", ["drawn-thick", "drawn-single-thin"])
def test_drawn_plans_score_full_with_their_truth(name):
    plan = draw_true_plan(name)
    figures = score_reading(FakeReading((FakeFloor(plan.truth, plan.grid, FakeScale(plan.grid.resolution)),)), plan)
    assert shares_of(figures) == pytest.approx([100] * 6)
    assert (figures["doors_f1"], figures["edges_f1"], figures["scale_error"]) == pytest.approx((100, 100, 0))


def test_each_plan_is_read_with_and_without_symbols(tiny, tmp_path):
    reader = FakeReader({"good": TRUE, "hard": WHOLE})
    pictures = tmp_path / "pictures"
    pictures.mkdir()
    bench = measure_plans(tiny, sets=["real"], with_text=False, read=reader, pictures=pictures)
    assert reader.calls == [(name, symbols, False) for name in ("good", "hard") for symbols in (True, False)]
    good, hard = bench.results["real"]
    assert [shares_of(row.figures)[:2] for row in good.rows.values()] == [
        pytest.approx([100, 100]),
        pytest.approx([100 / 3, 100]),
    ]
    assert shares_of(hard.rows["with symbols"].figures) == shares_of(hard.rows["without"].figures)
    assert good.scales == {"with symbols": "doors", "without": "doors"}
    assert not bench.failed
    assert list(list_files(pictures)) == ["good.png", "hard.png"]
    assert bench.items.keys() == {"real, with symbols", "real, without"}
    for row in good.rows.values():
        assert row.figures.keys() == {column.key for column in COLUMNS}
        assert row.figures["megapixels"] == pytest.approx(0.008)


def test_what_fails_is_named_and_counts_as_0(tiny):
    (tiny / "floorplans" / "blank.xml").write_text("<building/>")
    write_plan(tiny, "dark")
    bench = measure_plans(tiny, sets=["real"], with_text=False, read=FakeReader({"good": TRUE, "hard": TRUE}))
    blank, dark, _, _ = bench.results["real"]
    assert bench.failed
    assert shares_of(dark.rows["with symbols"].figures) == [0] * 6
    assert dark.rows["without"].failure == "plan dark.png shows no walls"
    assert blank.rows == {}
    faults = list(list_faults(bench))
    assert faults[0].startswith("blank (real) has no truth, not counted: ")
    assert faults[1:] == [
        f"dark (real, {reading}) failed, counts as 0: plan dark.png shows no walls"
        for reading in ("with symbols", "without")
    ]
    means = {row.name: row.cells[0].mean for row in tabulate_plans(bench)[1].rows}
    assert means["all (3)"] == pytest.approx(200 / 3)


def table_of_names(*exact: float) -> BenchTable:
    """Names on drawn sheets, ten a sheet."""
    rows = tuple(Row(f"sheet {number}", {"names": 10, "exact": count}) for number, count in enumerate(exact))
    columns = tuple(Column(key, key, "") for key in ("names", "exact"))
    return BenchTable("plan text", "Names", ("rapidocr",), columns, (Part("font", rows, "rapidocr"),), (), {}, (), ())


def test_how_names_are_read_stands_beside_the_drawn_plans(tmp_path, monkeypatch):
    monkeypatch.setattr(plans_module, "DRAWN", {"drawn-thick": DRAWN["drawn-thick"]})
    monkeypatch.setattr("pianta_bench.plans.text.measure_text", lambda *, track: table_of_names(9, 7))
    monkeypatch.setattr(plans_module, "_default_reader", lambda _: find_nothing)
    outcome = run_pianta("bench", "plans", "--set", "drawn", "--json", tmp_path / "figures.json")
    assert outcome.code == 0
    assert "Names, method rapidocr" in outcome.out
    assert json.loads((tmp_path / "figures.json").read_text())["text"]["parts"][0]["rows"][1]["figures"]["exact"] == 7
    measure = partial(measure_plans, read=find_nothing)
    assert measure(sets=["drawn"], with_text=False).text is None
    assert measure(only=["drawn-thick"]).text is None


def test_names_that_cannot_be_read_are_told(monkeypatch):
    def fail(*, track: object) -> BenchTable:
        msg = "no rapidocr"
        raise ImportError(msg)

    monkeypatch.setattr(plans_module, "DRAWN", {"drawn-thick": DRAWN["drawn-thick"]})
    monkeypatch.setattr("pianta_bench.plans.text.measure_text", fail)
    bench = measure_plans(sets=["drawn"], read=find_nothing)
    assert bench.text is None
    assert list(list_faults(bench)) == ["Names on drawn plans were not read: no rapidocr"]


def test_plans_are_chosen_by_set_and_name(tiny):
    assert choose_plans(tiny, [], []) == {"real": ["good", "hard"], "drawn": list(DRAWN)}
    assert choose_plans(tiny, [], ["hard"]) == {"real": ["hard"]}
    assert choose_plans(None, ["drawn"], []) == {"drawn": list(DRAWN)}
    assert choose_plans(Path("nowhere"), [], ["drawn-thick"]) == {"drawn": ["drawn-thick"]}
    with pytest.raises(OptionError, match="old"):
        choose_plans(tiny, ["old"], [])
    with pytest.raises(OptionError, match="absent"):
        choose_plans(tiny, [], ["good", "absent"])
    with pytest.raises(DataError, match="nowhere"):
        choose_plans(Path("nowhere"), [], [])


def result_of(name: str, with_: float, without: float, **more: object) -> PlanResult:
    """A school of which each share is the same."""
    rows = {}
    for reading, share in (("with symbols", with_), ("without", without)):
        figures = {column.key: share if column.unit == "%" else 1.0 for column in COLUMNS}
        rows[reading] = Row(name, figures | {"seconds": 4.0, "megapixels": 3.0 if name == "a" else 0.1})
    return PlanResult(name, **({"kind": LINES, "building_type": "school", "rows": rows} | more))  # type: ignore[arg-type]


HAND_MADE = PlanBench(
    {
        "real": (
            result_of("a", 90, 50),
            result_of("b", 80, 80),
            result_of("c", 40, 60, kind=COLORED, building_type="office", draws_doors=False),
            result_of("d", 10, 0, defects=("leaves the image by 9 px",)),
            result_of("e", 20, 0, kind=SCREENSHOT, building_type="office"),
        )
    },
    with_text=False,
)


def cells_of(table: ComparisonTable) -> dict[str, list[float | None]]:
    return {row.name: [cell.mean for cell in row.cells] for row in table.rows}


def test_kinds_and_what_is_left_apart():
    assert [is_sound(result) for result in HAND_MADE.results["real"]] == [True, True, True, False, False]
    means = {name: cells[0] for name, cells in cells_of(tabulate_plans(HAND_MADE)[1]).items()}
    assert means == {
        "line drawing (2)": 85,
        "coloured (1)": 40,
        "schools (2)": 85,
        "offices (1)": 40,
        "all (3)": 70,
        "all, median (3)": 80,
        "apart: truth not sound (1)": 10,
        "apart: screenshots (1)": 20,
    }


def test_symbols_are_weighed_on_plans_that_draw_their_doors():
    table = tabulate_plans(HAND_MADE)[2]
    assert {name: cells[0] for name, cells in cells_of(table).items()} == {
        "with symbols": 85,
        "without": 65,
        "difference": 20,
    }
    assert table.notes[0].startswith("Better with symbols, by the mean of A_FC and A_BC, on 1 of 2 plans; equal,")
    assert table.notes[0].endswith("on 1.")
    assert accuracy_of(HAND_MADE.results["real"][0], "without") == 50


def test_bars_stand_beside_what_was_measured():
    bars = cells_of(tabulate_plans(HAND_MADE)[3])
    assert bars == {
        "A_FC, median, at least": [80, 82, 92],
        "A_FC, mean, at least": [70, 74, None],
        "A_BC, median, at least": [80, 82, 92],
        "A_BC, mean, at least": [70, 74, None],
        "doors F1, median, at least": [85, 70, 85],
        "better with symbols, % of plans, at least": [50, 80, None],
        "seconds for 6 million pixels, at most": [8, 5, None],
        "printed names read exactly, %, at least": [None, 90, None],
    }
    with_text = cells_of(tabulate_plans(PlanBench(HAND_MADE.results, with_text=True, text=table_of_names(9, 7)))[3])
    assert with_text["seconds for 6 million pixels, at most"][1] == 15
    assert with_text["printed names read exactly, %, at least"] == [80, 90, None]


def test_tables_fit_a_terminal():
    console = Console(file=StringIO(), width=100)
    console.print(show_comparisons(tabulate_plans(HAND_MADE)))
    assert isinstance(console.file, StringIO)
    lines = console.file.getvalue().splitlines()
    assert "* d: the truth leaves the image by 9 px." in [line.rstrip() for line in lines]
    assert max(map(len, lines)) <= 100


def test_pictures_show_what_was_found_and_what_is_true():
    found = Floor((Room(1, CORRIDOR), Room(2, WEST)), (Door((1, 2), LineString([(0.2, 6), (1.2, 6)]), 1),))
    colors = paint_plan(PLAN, found, factor=4.0)
    assert colors.shape == (320, 400, 3)

    def color_at(x: float, y: float) -> tuple[int, ...]:
        row, col = (int(4 * value) for value in GRID.map_to_pixel(x, y))
        return tuple(colors[row, col].tolist())

    assert color_at(0.7, 6) == FOUND_DOOR
    assert color_at(4, 3) == TRUTH
    assert color_at(6, 3) == color_at(9, 1) == (255, 255, 255)
    assert len({color_at(3, 7), color_at(2, 4), (255, 255, 255)}) == 3


def test_the_command(tiny, tmp_path, monkeypatch):
    reader = FakeReader({"good": TRUE})
    monkeypatch.setattr(plans_module, "_default_reader", lambda _: reader)
    file, pictures = tmp_path / "figures.json", tmp_path / "pictures"
    outcome = run_pianta(
        *("bench", "plans", "--data", tiny, "--set", "real", "--no-text", "--json", file, "--pictures", pictures)
    )
    assert outcome.code == 1
    assert "hard (real, with symbols) failed, counts as 0: plan hard.jpg shows no walls" in outcome.out
    assert "Bars" in outcome.out
    assert list(list_files(pictures)) == ["good.png"]
    content = json.loads(file.read_text())
    assert content["bench"] == "plans"
    assert {(item["part"], item["item"]) for item in content["items"]} == {
        (f"real, {reading}", name) for reading in ("with symbols", "without") for name in ("good", "hard")
    }
    assert content["plans"][0]["counts_for_bars"] is True
    assert run_pianta("bench", "plans", "--data", tiny, "--only", "good", "--no-text").code == 0


def test_the_command_refuses_strange_options_before_reading(tiny, tmp_path, monkeypatch):
    monkeypatch.setattr(plans_module, "_default_reader", lambda _: pytest.fail("read"))
    outcome = run_pianta("bench", "plans", "--data", tiny, "--set", "old")
    assert (outcome.code, len(outcome.err.splitlines())) == (2, 1)
    assert "'old'" in outcome.err
    assert run_pianta("bench", "plans", "--data", tiny, "--json", tmp_path).code == 2
    assert SET_NAMES == plans_module.SET_NAMES


def test_plans_that_were_looked_at_have_a_kind_and_an_image(data):
    names = [name for name in list_plans(data) if name in KIND_OF_PLAN]
    if not names:
        pytest.skip("none of the plans that were looked at is in the data")
    assert {find_image(data, name).stem for name in names} == set(names)
    assert set(KIND_OF_PLAN.values()) == set(KINDS)
    assert KIND_OF_PLAN.keys() >= WITHOUT_DOOR_SYMBOLS


@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_truths_of_real_plans(data):
    if not {"off2", "plans1"} <= set(list_plans(data)):
        pytest.skip("the data have not both plans")
    off2, plans1 = (read_true_plan(data, name) for name in ("off2", "plans1"))
    assert (off2.kind, off2.building_type, off2.draws_doors, off2.defects) == (LINES, "office", True, ())
    assert len(off2.truth.rooms) == 31
    assert off2.grid.resolution == pytest.approx(0.9 / 22.4)
    assert plans1.defects == ("leaves the image by 16 px",)
