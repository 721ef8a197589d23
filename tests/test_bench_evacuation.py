"""`pianta bench evacuation` on generated buildings."""

from math import hypot

import pytest
from shapely import LineString, box

import pianta
from pianta.errors import BuildingWarning, DataError
from pianta.floor import Door, Floor, Room
from pianta_bench.evacuation import maps
from pianta_bench.evacuation.maps import compare_floors
from pianta_bench.evacuation.measure import describe_evacuation, measure
from pianta_bench.evacuation.tables import tabulate
from tests.command_line import run_pianta
from tests.test_bench_graphs import write_comb
from tests.tiny_data import write_slam


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


# A corridor with a room and stairs above it; on the map the room begins 0.2 m later, and its door is elsewhere.
CORRIDOR = Room(1, box(0, 0, 10, 2), "CORRIDOR")
TRUE = Floor(
    (CORRIDOR, Room(2, box(0, 2, 4, 6)), Room(3, box(8, 2, 10, 6), "STAIRS")),
    (Door((1, 2), LineString([(1, 2), (3, 2)]), 2.0), Door((1, 3), LineString([(8.5, 2), (9.5, 2)]), 1.0)),
)
READ = Floor(
    (Room(7, box(0, 0, 10, 2)), Room(8, box(0, 2.2, 4, 6)), Room(9, box(8, 2, 10, 5)), Room(10, box(5, 2, 6, 3))),
    (Door((7, 8), LineString([(0, 2.2), (2, 2.2)]), 2.0), Door((7, 9), LineString([(8.5, 2), (9.5, 2)]), 1.0)),
)


def test_a_floor_of_a_map_is_compared_room_by_room():
    """The farthest corner of the room is (0, 6) on both; of the corridor it is (0, 0)."""
    with pytest.warns(BuildingWarning, match="no way out.*: 10"):
        figures = compare_floors(READ, TRUE)
    room, corridor = hypot(2, 4) + 7, hypot(9, 2)
    # From (4, 6) by (1, 2.2) on the map, where the door is in a wall of 0.2 m.
    on_map = hypot(3, 3.8) + 0.2 + 8
    assert figures["error"] == pytest.approx(abs(on_map - room) / 2)
    assert figures["longest, truth"] == pytest.approx(max(room, corridor))
    assert (figures["exits"], figures["rooms"], figures["no way"]) == (1, 1, 0)
    assert figures["agreement"] == figures["one way, truth"] == 1
    assert figures["one way, map"] == pytest.approx(2 / 3)


def test_a_map_without_a_true_exit_fails():
    with pytest.raises(DataError, match="no room on the map covers an exit"):
        compare_floors(Floor(READ.rooms[:2], READ.doors[:1]), TRUE)


@pytest.mark.slow
def test_the_bench_reads_maps(monkeypatch, tmp_path):
    """The map is that of the drawn floor itself."""
    write_slam(tmp_path, "a")
    monkeypatch.setattr(maps, "reconstruct", lambda grid, **_: READ)
    monkeypatch.setattr(maps, "read_drawing", lambda file, **_: TRUE)
    code, out, err = run_pianta("bench", "evacuation", "--maps", "--data", tmp_path)
    assert (code, err) == (0, "")
    assert "true rooms on the map, IoU 0.5" in out


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
