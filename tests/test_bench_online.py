"""`pianta bench online`: what a mapper understands over the way, on a tiny school, and by figures made by hand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pianta.errors import OptionError
from pianta.mapping.events import Event, EventKind
from pianta_bench.harness.records import Results
from pianta_bench.online import measure as online
from pianta_bench.online.figures import draw_curves, save_figures
from pianta_bench.online.measure import (
    LABEL_BELIEF,
    LONGER,
    METRES_MAP,
    METRES_PERFECT,
    ROOMS,
    TYPE_BELIEF,
    name_stage,
)
from pianta_bench.online.tables import tabulate
from tests.command_line import run_pianta
from tests.tiny_data import read_as_buildings, write_schools

SCHOOLS = "KKKW-KL", "KKS-KK", "LLW-KKK", "KKC-LK", "LLC-KKW", "KK-KWL", "KSS-KKL"


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Seven schools, of which the last has two starts, as it has two stairs."""
    data = tmp_path_factory.mktemp("data")
    write_schools(data, *SCHOOLS)
    return data


@pytest.fixture(scope="module")
def measured(tiny: Path) -> Results:
    with pytest.MonkeyPatch.context() as patch:
        # The names of tiny schools end with a number, as those of the floors of one building.
        patch.setattr(online, "read_annotated_buildings", read_as_buildings)
        return online.measure(tiny, items=["school6"], starts=2)


@pytest.mark.slow
def test_a_school_has_figures_at_each_share_and_at_the_end(measured: Results) -> None:
    assert [(item.item, item.failure) for item in measured.items] == [("school6", None)]
    shares = [name_stage(ROOMS, stage) for stage in online.STAGES]
    assert shares == ["rooms F1 at 25%", "rooms F1 at 50%", "rooms F1 at 75%", "rooms F1 at 100%"]
    first, *_, last = (measured.values(metric=share)[0] for share in shares)
    assert 0 <= first <= last <= 1
    assert last > 0.7
    for metric in (online.RATIO, online.COST, online.LONGER):
        assert measured.values(metric=metric)[0] > 0
    ways = measured.select(metric=online.LONGER)
    assert [way["start"] for way in ways] == [0, 1]
    assert {record["metric"] for record in measured.records} >= {LABEL_BELIEF, TYPE_BELIEF}


@pytest.mark.slow
def test_curves_have_each_metric_at_each_share(measured: Results, tmp_path: Path) -> None:
    rights, expected, cost = draw_curves(measured).axes
    for ax, names in (
        (rights, ["rooms F1", "doors F1", "labels right", "type right"]),
        (expected, ["behind doors right", "expected rooms, error"]),
        (cost, ["update, s"]),
    ):
        assert [line.get_label() for line in ax.lines] == names
    shares, rooms = (np.asarray(each) for each in rights.lines[0].get_data())
    assert shares.tolist() == pytest.approx([10, 20, 25, 30, 40, 50, 60, 70, 75, 80, 90, 100])
    assert rooms[-1] == pytest.approx(100 * measured.values(metric="rooms F1 at 100%")[0])
    save_figures(measured, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["curves.png"]


def test_each_share_that_was_passed_counts_once() -> None:
    stages = [0.1, 0.2, 0.3, 1.0]
    assert online._pop_passed(stages, 0.05) == []
    assert online._pop_passed(stages, 0.2) == [0.1, 0.2]
    assert stages == [0.3, 1.0]


@pytest.mark.slow
def test_tables_have_the_way_the_end_and_calibration(measured: Results) -> None:
    assert [table.title for table in tabulate(measured)] == [
        "schools while a robot maps them",
        "At the end of the way, and what updates cost",
        "Calibration over the way",
    ]


def test_the_calibration_error_is_the_mean_difference_over_bins() -> None:
    results = Results({"type": "school", "seed": 0})
    # Bin 0.9 to 1: 0.95 and half right; bin 0.6 to 0.7: 0.65 and all right
    for probability, is_right in ((0.95, 1.0), (0.95, 0.0), (0.65, 1.0), (0.65, 1.0)):
        results.add("school", "a", {TYPE_BELIEF: is_right}, probability=probability)
    *_, calibration = tabulate(results)
    assert calibration.rows[TYPE_BELIEF]["error"].mean == pytest.approx(100 * (0.45 * 0.5 + 0.35 * 0.5))


def test_metres_are_the_means_of_buildings_over_the_starts_that_both_robots_finish() -> None:
    results = Results({"type": "school", "seed": 0})
    for item, start, by_map, perfect in (("a", 0, 10.0, 10.0), ("a", 1, 30.0, 20.0), ("b", 0, 12.0, 8.0)):
        metres = {METRES_MAP: by_map, METRES_PERFECT: perfect, LONGER: by_map / perfect}
        results.add("school", item, metres, start=start)
    results.add("school", "b", {METRES_MAP: None, METRES_PERFECT: 90.0, LONGER: None}, start=1)
    _, end, _ = tabulate(results)
    means = {metric: end.rows[metric]["school"].mean for metric in (METRES_MAP, METRES_PERFECT, LONGER)}
    assert means == {METRES_MAP: 16.0, METRES_PERFECT: 11.5, LONGER: pytest.approx((1.25 + 1.5) / 2)}
    assert list(end.columns) == ["school"]
    assert end.notes[-3:] == (
        "Ways for the metres: 3. The mean of each floor comes first.",
        "Over perfect: 1.25 to 1.50, 95 % of the means when floors are resampled (bootstrap).",
        "Without 90 % by both, or with 0 m, left out: b start 1.",
    )


def test_a_single_floor_has_no_interval() -> None:
    results = Results({"type": "school", "seed": 0})
    results.add("school", "a", {METRES_MAP: 10.0, METRES_PERFECT: 8.0, LONGER: 1.25}, start=0)
    _, end, _ = tabulate(results)
    assert end.notes[-1] == "Ways for the metres: 1. The mean of each floor comes first."


def test_the_type_counts_from_where_it_is_right_to_the_end() -> None:
    def compare(share: float, *, is_right: bool) -> online._Comparison:
        return online._Comparison(share, 1.0, 1.0, None, is_right, {}, [])

    history = [compare(0.1, is_right=True), compare(0.2, is_right=False), compare(0.4, is_right=True)]
    assert online._find_type_share([*history, compare(1.0, is_right=True)]) == 0.4
    assert online._find_type_share([*history, compare(1.0, is_right=False)]) is None


def test_an_id_that_changes_counts_unless_rooms_were_joined_or_divided() -> None:
    before, ids = {1: 7, 2: 8, 3: 9}, {1: 7, 2: 5, 3: 6, 4: 4}
    assert online._count_changed_ids(before, ids, ()) == 2
    assert online._count_changed_ids(before, ids, (Event(EventKind.DIVIDED_ROOM, (8, 5)),)) == 1
    assert online._count_changed_ids(before, ids, (Event(EventKind.COMPLETE_ROOM, (6,)),)) == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--type", "castle"], "type is 'castle', give one of "),
        (["--item", "school9"], "no building is called school9"),
    ],
)
def test_bad_options_are_refused(tiny: Path, arguments: list[str], message: str) -> None:
    code, _, err = run_pianta("bench", "online", "--data", tiny, *arguments)
    assert code == 2
    assert message in err


def test_starts_below_0_are_refused(tiny: Path) -> None:
    with pytest.raises(OptionError, match="starts is -1, give how many at most, or 0 for all"):
        online.measure(tiny, starts=-1)


@pytest.mark.slow
def test_a_building_that_fails_has_neither_beliefs_nor_metres(tiny: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OptionError("no")

    monkeypatch.setattr(online, "read_annotated_buildings", read_as_buildings)
    monkeypatch.setattr(online, "_follow_ends", fail)
    results = online.measure(tiny, items=["school0"], starts=1)
    assert [item.failure for item in results.items] == ["no"]
    assert not results.select(metric=[LABEL_BELIEF, TYPE_BELIEF, LONGER])


def test_too_few_buildings_are_refused(tmp_path: Path) -> None:
    write_schools(tmp_path, "KKK-KL", "KW-KK")
    with pytest.raises(OptionError, match="castle"):
        online.measure(tmp_path, type="castle")
    code, _, err = run_pianta("bench", "online", "--data", tmp_path)
    assert code == 2
    assert "are too few to learn from" in err


def test_a_floor_in_two_parts_is_explored_but_no_model_learns_from_it(tiny: Path) -> None:
    first, other, *_ = read_as_buildings(tiny, "school", lambda each: each)[0]
    parted = replace(other, floor=replace(other.floor, doors=()))
    graphs, unmodelled = online._prepare_graphs([first, parted], "school")
    assert list(graphs) == [first.item]
    assert list(unmodelled) == [parted.item]
    assert unmodelled[parted.item] == "no door connects two of its rooms, add doors or leave it out"
