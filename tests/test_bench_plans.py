"""`pianta bench plans`: tiny plans, and readers whose figures can be computed by hand."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from shapely import LineString, box
from shapely.affinity import translate

from pianta.errors import DataError, OptionError, PlanError
from pianta.floor import Door, Floor, Room, scale_floor
from pianta.gridmap import GridMap
from pianta.plan.read_plan import PlanFloor, PlanReading
from pianta.plan.sheets.sheet import PlanScale
from pianta_bench.harness.records import Results
from pianta_bench.harness.tables import FilledTable
from pianta_bench.plans import measure as plans_module
from pianta_bench.plans.figures import DOOR_COLOR, TRUTH_COLOR, paint_plan
from pianta_bench.plans.measure import choose_plans, measure
from pianta_bench.plans.plan_sets import (
    COLORED,
    DRAWN_PLANS,
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
from pianta_bench.plans.scores import PERCENT, SCORES, UNITS, match_floors, merge_floors, move_floor, score_reading
from pianta_bench.plans.tables import tabulate
from pianta_bench.plans.text import PART
from tests.bench_results import list_rows, show_lines
from tests.command_line import list_files, run_pianta
from tests.tiny_data import write_school

# The sheet, pixels of 0.1 m, and on it a corridor of 8 m × 2 m and two rooms of 4 m × 4 m below it.
SHAPE = (80, 100)
GRID = GridMap(np.full(SHAPE, -1), 0.1)
CORRIDOR, WEST, EAST = box(0, 6, 8, 8), box(0, 2, 4, 6), box(4, 2, 8, 6)
DOORS = (Door((1, 2), LineString([(1.55, 6), (2.45, 6)]), 0.9), Door((1, 3), LineString([(5.55, 6), (6.45, 6)]), 0.9))
TRUE = Floor(tuple(Room(number, polygon) for number, polygon in enumerate((CORRIDOR, WEST, EAST), 1)), DOORS)
ONE_ROOM = Floor((Room(1, box(0, 2, 8, 8)),))
PLAN = TruePlan("tiny", np.full((*SHAPE, 3), 255, np.uint8), TRUE, GRID, LINES, "school")


def reading_of(*floors: Floor, grid: GridMap = GRID) -> PlanReading:
    scale = PlanScale(grid.resolution, "doors", 1.0)
    return PlanReading(tuple(PlanFloor(floor, grid, scale) for floor in floors), None)


@dataclass
class FakeReader:
    """Finds a floor by the name of the plan, and by itself the whole as one room without symbols."""

    floors: Mapping[str, Floor]
    calls: list[tuple[str, bool, bool]] = field(default_factory=list)

    def __call__(self, path: Path, *, with_symbols: bool, with_text: bool) -> PlanReading:
        self.calls.append((path.stem, with_symbols, with_text))
        if path.stem not in self.floors:
            raise PlanError(f"plan {path.name} shows no walls")
        return reading_of(self.floors[path.stem] if with_symbols else ONE_ROOM)


def read_nothing(path: Path, *, with_symbols: bool, with_text: bool) -> PlanReading:
    return reading_of()


def write_plan(data: Path, name: str, *, building_type: str = "SCHOOL", suffix: str = ".png") -> None:
    folder = data / "floorplans"
    folder.mkdir(parents=True, exist_ok=True)
    typed = f"<building_type><main_type>{building_type}</main_type></building_type><floor>"
    (folder / f"{name}.xml").write_text(write_school(["KK"]).replace("<floor>", typed))
    Image.fromarray(PLAN.colors).save(folder / f"{name}{suffix}")


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    write_plan(tmp_path, "good")
    write_plan(tmp_path, "hard", building_type="OFFICE", suffix=".jpg")
    return tmp_path


def shares_of(figures: Mapping[str, float | None]) -> list[float | None]:
    return [figures[key] for key in SCORES]


def test_a_perfect_reading_of_a_wrong_scale_in_another_frame():
    frame = GridMap(np.full(SHAPE, -1), 0.2, (5.0, -3.0, 0.5))
    floor = move_floor(TRUE, GRID, frame)
    assert floor.doors[0].width == pytest.approx(1.8)
    figures = score_reading(reading_of(floor, grid=frame), PLAN)
    assert shares_of(figures) == pytest.approx([100] * 6)
    assert (figures["doors_f1"], figures["edges_f1"]) == pytest.approx((100, 100))
    assert figures["scale_error"] == pytest.approx(100)
    assert (figures["found"], figures["true"], figures["floors"], figures["unmatched"]) == (3, 3, 1, 0)


def test_rooms_and_doors_are_scored():
    """One room of 48 m² instead of three of 16 m²; a door 0.3 m off, and one too many."""
    rooms = score_reading(reading_of(ONE_ROOM), PLAN)
    assert shares_of(rooms) == pytest.approx([100 / 3, 100, 100 / 3, 100, 100 / 3, 0])
    moved = [Door(door.rooms, translate(door.line, 0.3), 0.9) for door in DOORS[:1]]
    stray = Door((2, 3), LineString([(4, 3), (4, 4)]), 1.0)
    entrance = Door((1, None), LineString([(0, 6.5), (0, 7.5)]), 1.0)
    figures = score_reading(reading_of(Floor(TRUE.rooms, (*moved, stray, entrance))), PLAN)
    assert (figures["doors_precision"], figures["doors_recall"], figures["doors_f1"]) == pytest.approx((50, 50, 50))
    assert (figures["edges_precision"], figures["edges_recall"]) == pytest.approx((50, 50))


def test_openings_join_rooms_and_are_no_doors():
    opening = Door((2, 3), LineString([(4, 3), (4, 4)]), 1.0, "opening")
    figures = score_reading(reading_of(Floor(TRUE.rooms, (DOORS[0], opening))), PLAN)
    assert (figures["doors_precision"], figures["doors_recall"]) == pytest.approx((100, 50))
    assert (figures["edges_precision"], figures["edges_recall"]) == pytest.approx((50, 50))


def test_the_other_floor_of_a_sheet_does_not_count():
    other = Floor((Room(1, box(0, 0, 8, 1.5)),))
    figures = score_reading(reading_of(TRUE, other), PLAN)
    assert shares_of(figures) == pytest.approx([100] * 6)
    assert figures["unmatched"] == pytest.approx(100 * 12 / 60)
    assert (figures["found"], figures["floors"]) == (3, 2)


def test_floors_count_with_all_their_rooms():
    """Alone, or mostly on the truth, a floor answers for what it finds beside it."""
    with_more = Floor((*TRUE.rooms, Room(4, box(0, 0, 8, 2))), DOORS)
    alone = Floor((Room(1, box(0, 0, 8, 1.5)),))
    for floors in ((with_more,), (with_more, alone)):
        matched, _ = match_floors(reading_of(*floors).floors, PLAN)
        assert len(matched.rooms) == 4
    assert match_floors(reading_of(alone).floors, PLAN) == (alone, 0)


def test_floors_all_beside_the_truth_all_count():
    strays = [Floor((Room(1, box(x, 0, x + 2, 1)),)) for x in (0, 4)]
    matched, unmatched = match_floors(reading_of(*strays).floors, PLAN)
    assert len(matched.rooms) == 2
    assert unmatched == 0


def test_a_floor_that_was_read_in_parts_counts_as_a_whole():
    parts = [Floor(TRUE.rooms[:2], DOORS[:1]), Floor(TRUE.rooms[2:])]
    matched, unmatched = match_floors(reading_of(*parts).floors, PLAN)
    assert [room.polygon for room in matched.rooms] == [room.polygon for room in TRUE.rooms]
    assert [door.rooms for door in matched.doors] == [(1, 2)]
    assert unmatched == 0


def test_no_floor_scores_nothing():
    figures = score_reading(reading_of(), PLAN)
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


def test_kinds_are_detected_from_pixels():
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
    figures = score_reading(reading_of(plan.truth, grid=plan.grid), plan)
    assert shares_of(figures) == pytest.approx([100] * 6)
    assert (figures["doors_f1"], figures["edges_f1"], figures["scale_error"]) == pytest.approx((100, 100, 0))


def test_each_plan_is_read_with_and_without_symbols(tiny, tmp_path):
    reader = FakeReader({"good": TRUE, "hard": ONE_ROOM})
    pictures = tmp_path / "pictures"
    results = measure(tiny, sets=["real"], with_text=False, read=reader, pictures=pictures)
    assert reader.calls == [(name, symbols, False) for name in ("good", "hard") for symbols in (True, False)]
    rows = [list_rows(results, f"real, {reading}") for reading in ("with symbols", "without")]
    good, hard = zip(*rows, strict=True)
    assert [shares_of(row.figures)[:2] for row in good] == [pytest.approx([100, 100]), pytest.approx([100 / 3, 100])]
    assert shares_of(hard[0].figures) == shares_of(hard[1].figures)
    assert results.details["plans"][0]["scales"] == {"with symbols": "doors", "without": "doors"}
    assert not results.failed
    assert list(list_files(pictures)) == ["good.png", "hard.png"]
    for row in good:
        assert row.figures.keys() == UNITS.keys()
        assert row.figures["megapixels"] == pytest.approx(0.008)


def test_what_fails_is_named_and_counts_as_0(tiny):
    (tiny / "floorplans" / "blank.xml").write_text("<building/>")
    write_plan(tiny, "dark")
    results = measure(tiny, sets=["real"], with_text=False, read=FakeReader({"good": TRUE, "hard": TRUE}))
    assert results.failed
    assert not results.select(item="blank")
    (dark,) = (row for row in list_rows(results, "real, with symbols") if row.item == "dark")
    assert shares_of(dark.figures) == [0] * 6
    faults = [(item.item, item.part, item.failure) for item in results.items if item.failure]
    assert [fault[:2] for fault in faults[:1]] == [("blank", "real, truth")]
    assert faults[1:] == [
        ("dark", f"real, {reading}", "plan dark.png shows no walls") for reading in ("with symbols", "without")
    ]
    assert tabulate(results)[1].rows["all (3)"]["A_FC"].mean == pytest.approx(200 / 3)


def names_on_sheets(*exact: float) -> Results:
    """Names on drawn sheets, ten a sheet."""
    results = Results()
    for number, count in enumerate(exact):
        figures = {"names": 10, "exact": count}
        results.add(PART, f"sheet {number}", figures, font="font", capital=f"{number} px", rotation="0°")
    return results


def test_names_are_read_beside_the_drawn_plans(tmp_path, monkeypatch):
    monkeypatch.setattr(plans_module, "DRAWN_PLANS", {"drawn-thick": DRAWN_PLANS["drawn-thick"]})
    monkeypatch.setattr(plans_module, "measure_text", lambda *, track: names_on_sheets(9, 7))
    monkeypatch.setattr(plans_module, "_default_reader", lambda _: read_nothing)
    outcome = run_pianta("bench", "plans", "--set", "drawn", "--json", tmp_path / "figures.json")
    assert outcome.code == 0
    assert "Names of rooms on synthetic plans, font" in outcome.out
    records = json.loads((tmp_path / "figures.json").read_text())["records"]
    assert [record["value"] for record in records if record["metric"] == "exact"] == [9, 7]
    measure_drawn = partial(measure, read=read_nothing)
    assert not measure_drawn(sets=["drawn"], with_text=False).select(part=PART)
    assert not measure_drawn(only=["drawn-thick"]).select(part=PART)


def test_the_reason_is_shown_if_names_cannot_be_read(monkeypatch):
    def fail(*, track: object) -> Results:
        msg = "no rapidocr"
        raise ImportError(msg)

    monkeypatch.setattr(plans_module, "DRAWN_PLANS", {"drawn-thick": DRAWN_PLANS["drawn-thick"]})
    monkeypatch.setattr(plans_module, "measure_text", fail)
    results = measure(sets=["drawn"], read=read_nothing)
    assert not results.failed
    assert not results.select(part=PART)
    assert tabulate(results)[1].notes[1:] == ("Names on drawn plans were not read: no rapidocr",)


def test_plans_are_chosen_by_set_and_name(tiny):
    assert choose_plans(tiny, [], []) == {"real": ["good", "hard"], "drawn": list(DRAWN_PLANS)}
    assert choose_plans(tiny, [], ["hard"]) == {"real": ["hard"]}
    assert choose_plans(None, ["drawn"], []) == {"drawn": list(DRAWN_PLANS)}
    assert choose_plans(Path("nowhere"), [], ["drawn-thick"]) == {"drawn": ["drawn-thick"]}
    with pytest.raises(OptionError, match="old"):
        choose_plans(tiny, ["old"], [])
    with pytest.raises(OptionError, match="absent"):
        choose_plans(tiny, [], ["good", "absent"])
    with pytest.raises(DataError, match="nowhere"):
        choose_plans(Path("nowhere"), [], [])


def add_plan(results: Results, name: str, with_: float, without: float, **more: object) -> None:
    """Add a school of which each share is the same."""
    defects = more.pop("defects", ())
    fields: dict[str, Any] = {
        "kind": LINES,
        "building_type": "school",
        "draws_doors": True,
        "is_sound": not defects,
    } | more
    for reading, share in (("with symbols", with_), ("without", without)):
        figures = {**dict.fromkeys(UNITS, 1.0), **dict.fromkeys(PERCENT, share)}
        figures |= {"seconds": 4.0, "megapixels": 3.0 if name == "a" else 0.1}
        results.add(f"real, {reading}", name, figures, set="real", reading=reading, **fields)
    results.details["plans"].append({"set": "real", "plan": name, "defects": defects})


@pytest.fixture
def hand_made() -> Results:
    results = Results(details={"plans": []})
    add_plan(results, "a", 90, 50)
    add_plan(results, "b", 80, 80)
    add_plan(results, "c", 40, 60, kind=COLORED, building_type="office", draws_doors=False)
    add_plan(results, "d", 10, 0, defects=("leaves the image by 9 px",))
    add_plan(results, "e", 20, 0, kind=SCREENSHOT, building_type="office")
    return results


def means_of(table: FilledTable, column: str) -> dict[str, float | None]:
    return {name: cells[column].mean for name, cells in table.rows.items()}


def test_kinds_and_plans_that_are_left_apart(hand_made):
    assert means_of(tabulate(hand_made)[1], "A_FC") == {
        "line drawing (2)": 85,
        "coloured (1)": 40,
        "schools (2)": 85,
        "offices (1)": 40,
        "all (3)": 70,
        "all, median (3)": 80,
        "apart: truth not sound (1)": 10,
        "apart: screenshots (1)": 20,
    }


def test_symbols_are_compared_on_plans_that_draw_their_doors(hand_made):
    table = tabulate(hand_made)[2]
    assert table.title == "Plans that draw their doors (2), with and without symbols"
    assert means_of(table, "A_FC") == {"with symbols": 85, "without": 65, "difference": 20}
    assert table.notes[0].startswith("Better with symbols, by the mean of A_FC and A_BC, on 1 of 2 plans; equal,")
    assert table.notes[0].endswith("on 1.")


def test_summary(hand_made):
    figures = {
        "A_FC, median": 80,
        "A_FC, mean": 70,
        "A_BC, median": 80,
        "A_BC, mean": 70,
        "doors F1, median": 85,
        "doors F1, mean": 85,
        "better with symbols, % of plans": 50,
        "seconds for 6 million pixels": 8,
        "names read exactly, %": None,
    }
    assert means_of(tabulate(hand_made)[3], "here") == figures
    hand_made.extend(names_on_sheets(9, 7))
    tables = tabulate(hand_made)
    assert means_of(tables[3], "here") == {**figures, "names read exactly, %": 80}
    assert means_of(tables[-1], "read exactly") == {"all": 80, "font": 80, "0 px": 90, "1 px": 70, "0°": 80}


def test_tables_fit_a_terminal(hand_made):
    lines = show_lines(tabulate(hand_made), hand_made, width=100)
    assert "* d: the truth leaves the image by 9 px." in lines
    assert any(line.startswith("d* ") for line in lines)
    assert max(map(len, lines)) <= 100


def test_pictures_show_the_floor_and_the_truth():
    floor = Floor((Room(1, CORRIDOR), Room(2, WEST)), (Door((1, 2), LineString([(0.2, 6), (1.2, 6)]), 1),))
    colors = paint_plan(PLAN, floor, factor=4.0)
    assert colors.shape == (320, 400, 3)

    def color_at(x: float, y: float) -> tuple[int, ...]:
        row, col = (int(4 * value) for value in GRID.map_to_pixel(x, y))
        return tuple(colors[row, col].tolist())

    assert color_at(0.7, 6) == DOOR_COLOR
    assert color_at(4, 3) == TRUTH_COLOR
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
    assert "hard failed (real, with symbols): plan hard.jpg shows no walls" in outcome.out
    assert "A plan that failed counts as 0" in outcome.out
    assert list(list_files(pictures)) == ["good.png"]
    content = json.loads(file.read_text())
    assert content["bench"] == "plans"
    assert {(item["part"], item["item"]) for item in content["items"]} == {
        (f"real, {reading}", name) for reading in ("with symbols", "without") for name in ("good", "hard")
    }
    assert content["plans"][0]["building_type"] == "school"
    assert run_pianta("bench", "plans", "--data", tiny, "--only", "good", "--no-text").code == 0


def test_the_command_refuses_unknown_options_before_reading(tiny, tmp_path, monkeypatch):
    monkeypatch.setattr(plans_module, "_default_reader", lambda _: pytest.fail("read"))
    outcome = run_pianta("bench", "plans", "--data", tiny, "--set", "old")
    assert (outcome.code, len(outcome.err.splitlines())) == (2, 1)
    assert "'old'" in outcome.err
    assert run_pianta("bench", "plans", "--data", tiny, "--json", tmp_path).code == 2


def test_plans_with_a_kind_on_record_have_an_image(data):
    names = [name for name in list_plans(data) if name in KIND_OF_PLAN]
    if not names:
        pytest.skip("the data have none of the plans whose kind is on record")
    assert {find_image(data, name).stem for name in names} == set(names)
    assert set(KIND_OF_PLAN.values()) == set(KINDS)
    assert KIND_OF_PLAN.keys() >= WITHOUT_DOOR_SYMBOLS


@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_truths_of_real_plans(data):
    if not {"off2", "plans1"} <= set(list_plans(data)):
        pytest.skip("the data lack one of the plans")
    off2, plans1 = (read_true_plan(data, name) for name in ("off2", "plans1"))
    assert (off2.kind, off2.building_type, off2.draws_doors, off2.defects) == (LINES, "office", True, ())
    assert len(off2.truth.rooms) == 31
    assert off2.grid.resolution == pytest.approx(0.9 / 22.4)
    assert plans1.defects == ("leaves the image by 16 px",)
