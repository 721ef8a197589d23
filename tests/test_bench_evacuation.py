"""`pianta bench evacuation` on generated buildings."""

import pytest
from shapely import LineString, box

import pianta
from pianta.floor import Door, Floor, Room
from pianta_bench.evacuation.measure import describe_evacuation, measure
from pianta_bench.evacuation.tables import tabulate
from tests.command_line import run_pianta
from tests.test_bench_graphs import write_comb


def test_figures_of_a_floor():
    """Two rooms in a row behind the stairs: from the first one has to pass the second."""
    rooms = [Room(1, box(0, 0, 4, 2)), Room(2, box(4, 0, 8, 2)), Room(3, box(8, 0, 10, 2), "STAIRS")]
    doors = [Door((n, n + 1), LineString([(4 * n, 0.5), (4 * n, 1.5)]), 1.0) for n in (1, 2)]
    figures = describe_evacuation(pianta.evacuate(Floor(tuple(rooms), tuple(doors))))
    assert figures["exits"] == 1
    assert figures["median way"] == pytest.approx((6 + 2) / 2)
    assert figures["one way"] == figures["worst door"] == 1
    assert figures["dead ends"] == 0.5
    assert figures["longest dead end"] == figures["longest"] == pytest.approx(17**0.5 + 4)
    assert (figures["no way"], figures["delay"]) == (0, None)


def test_the_bench_counts_floors_and_names_failures(tmp_path):
    write_comb(tmp_path / "buildings" / "school" / "a.xml", "CLASSROOM", "STAIRS")
    write_comb(tmp_path / "buildings" / "school" / "b.xml", "CLASSROOM", "LAB")
    write_comb(tmp_path / "buildings" / "office" / "c.xml", "OFFICE", "STAIRS", building_type="OFFICE")
    results = measure(tmp_path)
    assert [item.failure is None for item in results.items] == [True, False, True]
    assert "no exit is known" in str(results.items[1].failure)
    lengths, shares = tabulate(results)
    assert lengths.rows["exits"]["schools"].mean == 1
    assert shares.rows["rooms with one way out"]["offices"].mean is not None
    assert shares.notes[-1] == "Floors: schools 1, offices 1."
    assert run_pianta("bench", "evacuation", "--data", tmp_path).code == 1
