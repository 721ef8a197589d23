"""The bench of cost: what it measures on, and what it makes of it."""

import json
from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from pianta_bench.cost import measure as cost
from pianta_bench.cost.measure import tile_floor
from pianta_bench.cost.stages import OTHER, STAGES, TOTAL, profile_reading
from pianta_bench.cost.tables import derive, derive_stages, tabulate
from pianta_bench.harness.records import Results
from tests.command_line import run_pianta

METRICS = ("cells", "rooms", "seconds", "transforms", "megabytes")


def make_results() -> Results:
    results = Results({"methods": ("thesis",), "tiles": 16})
    for floors, figures in ((1, (1_000_000, 50, 0.5, 20.0, 200.0)), (16, (16_000_000, 800, 12.0, 30.0, 1200.0))):
        costs = dict(zip(METRICS, figures, strict=True))
        results.add("cost", f"{floors} floors, thesis", costs, method="thesis", floors=floors)
    return results


def test_tiles_are_copies_of_one_floor_apart_from_each_other():
    one, four = tile_floor(600, 1), tile_floor(600, 2)
    assert (one.shape, four.shape) == ((600, 600), (1200, 1200))
    assert (four.cells[600:, :600] == one.cells).all()
    assert one.free.mean() > 0.5
    assert one.unknown[-10:].all()
    assert one.unknown[:, -10:].all()


def test_growth_is_the_time_of_all_floors_in_times_of_one():
    (growth,) = [record for record in derive(make_results()) if record["metric"] == "growth"]
    assert growth["value"] == pytest.approx(12 / (16 * 0.5))


def test_shares_and_growth_of_stages():
    results = make_results()
    for floors, seconds in ((1, {"network": 1.0, "walls": 0.001, TOTAL: 4.0}), (16, {"network": 40.0, TOTAL: 80.0})):
        results.add("stages", f"{floors} floors", seconds, names=("stage",), metric="seconds", floors=floors)
    derived = {(each["stage"], each["metric"], each["floors"]): each["value"] for each in derive_stages(results)}
    assert derived == {
        ("network", "share", 1): 25.0,
        ("walls", "share", 1): pytest.approx(0.025),
        (TOTAL, "share", 1): 100.0,
        ("network", "share", 16): 50.0,
        ("network", "growth", 16): 40 / 16,
        (TOTAL, "share", 16): 100.0,
        (TOTAL, "growth", 16): 80 / 64,
    }
    cost_table, stage_table = tabulate(results)
    assert cost_table.rows["thesis, 16"]["growth"].mean == pytest.approx(1.5)
    assert [*stage_table.rows] == ["network", "walls", TOTAL]


@pytest.mark.slow
def test_the_stages_of_a_reading_are_most_of_it_and_none_counts_twice():
    profiled = profile_reading(tile_floor(600, 1, unseen=0.15))
    assert [*profiled] == [*STAGES, OTHER, TOTAL]
    seconds = {stage: value or 0.0 for stage, value in profiled.items()}
    assert all(seconds[stage] > 0 for stage in STAGES)
    assert sum(seconds[stage] for stage in STAGES) + seconds[OTHER] == pytest.approx(seconds[TOTAL])
    assert 0 <= seconds[OTHER] < seconds[TOTAL] / 2


@pytest.mark.slow
def test_each_map_is_measured_in_a_process_of_its_own():
    tracked: list[str] = []

    def track(names: Sequence[str]) -> Iterator[str]:
        tracked.extend(names)
        return iter(names)

    results = cost.measure(methods=("thesis",), side=600, tiles=2, track=track)
    assert tracked == ["1 floors, thesis", "4 floors, thesis"]
    one, many = (
        {record["metric"]: record["value"] for record in results.select(floors=floors, method="thesis")}
        for floors in (1, 4)
    )
    assert (one["cells"], many["cells"]) == (360_000, 1_440_000)
    assert many["rooms"] == pytest.approx(4 * one["rooms"], rel=0.2)
    assert all(part["seconds"] > 0 and part["transforms"] > 0 and part["megabytes"] > 50 for part in (one, many))


def test_the_command_prints_and_writes_growths(monkeypatch, tmp_path):
    monkeypatch.setattr(cost, "measure", lambda **_: make_results())
    code, out, err = run_pianta("bench", "cost", "--method", "thesis", "--json", tmp_path / "new" / "cost.json")
    assert (code, err) == (0, "")
    rows = [line.split() for line in out.splitlines() if line.startswith("thesis")]
    assert rows == [
        ["thesis,", "1", "1.0", "50", "0.50", "20", "200", "–"],
        ["thesis,", "16", "16.0", "800", "12.00", "30", "1200", "1.50"],
    ]
    content = json.loads((tmp_path / "new" / "cost.json").read_text())
    assert content["options"]["methods"] == ["thesis"]
    assert {"row": "thesis, 16", "column": "growth", "mean": 1.5}.items() <= content["tables"][0]["cells"][-1].items()
    megabytes = [record["value"] for record in content["records"] if record["metric"] == "megabytes"]
    assert megabytes == [200.0, 1200.0]


def test_an_unknown_method_costs_nothing(monkeypatch):
    monkeypatch.setattr(cost, "measure_cost", lambda *_: pytest.fail("measured"))
    code, _, err = run_pianta("bench", "cost", "--method", "magic")
    assert code == 2
    assert err.startswith("error: ")
    assert "magic" in err


def test_generated_floors_are_the_same_each_time():
    assert np.array_equal(tile_floor(600, 1).cells, tile_floor(600, 1).cells)
