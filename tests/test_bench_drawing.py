"""`pianta bench drawing`: measures of literal floors, tables of literal figures, and a run on real schools."""

import json
from dataclasses import replace

import networkx as nx
import pytest
from shapely import LineString, box

import pianta
from pianta.errors import OptionError
from pianta.floor import Door, Floor, Room
from pianta_bench.drawing.circle import (
    DOORS,
    EMPTY,
    IN_USE,
    ROOMS,
    SAME,
    SAME_LABELLED,
    SCANS,
    SOME,
    count_reached_rooms,
    have_same_graph,
    scan_and_read,
)
from pianta_bench.drawing.figures import draw_pairs
from pianta_bench.drawing.measure import (
    ALL_DOORS,
    COURTS,
    EDGES,
    FACADE,
    GENERATED,
    HULL,
    NARROW,
    NARROW_DOORS,
    OVERLAP,
    REAL,
    REALISED,
    SECONDS,
    WITHHELD,
    find_lit_shares,
    leave_geometry_out,
    list_sizes,
    measure,
    measure_compactness,
    measure_floor,
)
from pianta_bench.drawing.tables import DOOR_SHARE, LARGEST_TIME, SHARE, SMALL_SHARE, tabulate
from pianta_bench.harness.records import Results
from tests.command_line import run_pianta
from tests.generated_types import SCHOOL, make_schools, sized_model
from tests.tiny_data import read_as_buildings, write_schools

FLOOR = Floor(
    (
        Room(1, box(0, 0, 10, 2), "CORRIDOR", labels={"R/C": "CORRIDOR"}),
        Room(2, box(0, 2, 5, 6), "CLASSROOM", labels={"R/C": "ROOM"}),
        Room(3, box(6, 1.9, 7, 6), "CLOSET", labels={"R/C": "ROOM"}),
    ),
    (
        Door((1, 2), LineString([(2, 2), (2.9, 2)]), 0.9),
        Door((1, 3), LineString([(6.2, 2), (6.8, 2)]), 0.6),
    ),
    source="literal",
)


def make_results(floors: dict[str, list[Floor]]) -> Results:
    results = Results({"type": "school"}, objects={"floors": floors})
    rows = (("a", 40, 1, 50, 50, 1.0), ("b", 70, 0, 100, 97, 5.0), ("c", 20, 1, 50, 50, 3.0))
    names = ("rooms", ALL_DOORS, EDGES, REALISED, SECONDS)
    for part in (GENERATED, WITHHELD):
        for item, *figures in rows:
            results.add(part, item, dict(zip(names, figures, strict=True)))
            results.add(part, item, {NARROW: 1, NARROW_DOORS: 0, OVERLAP: 0.0})
            results.add(part, item, {"typicality": 0.4}, label_set="R/C")
    return results


class TestFloors:
    def test_what_is_too_narrow_or_overlaps_is_counted(self):
        graph = nx.Graph([(0, 1), (0, 2), (1, 2)])
        assert measure_floor(FLOOR, graph, 1) == {
            "rooms": 3,
            ALL_DOORS: False,
            EDGES: 3,
            REALISED: 2,
            NARROW: 1,
            NARROW_DOORS: 1,
            OVERLAP: pytest.approx(0.1),
        }

    def test_sizes_by_label(self):
        sizes = list_sizes([FLOOR, FLOOR])
        assert sizes["CORRIDOR"] == ([20.0, 20.0], [5.0, 5.0])
        assert sizes["CLASSROOM"] == ([20.0, 20.0], [1.25, 1.25])

    def test_rooms_with_windows_by_label(self):
        inner = box(4, 4, 6, 6)
        around = Floor((Room(1, box(0, 0, 10, 10).difference(inner), "CLASSROOM"), Room(2, inner, "CLOSET")))
        assert find_lit_shares([FLOOR, around]) == {"CORRIDOR": 1.0, "CLASSROOM": 1.0, "CLOSET": 0.5}

    def test_a_court_is_in_the_hull_and_at_the_facade(self):
        """Rooms around a court of 4 m; with walls of 0.3 m it is 3.4 m wide in a square of 12.6 m."""
        sides = (box(0, 0, 12, 4), box(0, 8, 12, 12), box(0, 4, 4, 8), box(8, 4, 12, 8))
        floor = Floor(tuple(Room(number, side) for number, side in enumerate(sides, 1)))
        body = 12.6**2 - 3.4**2
        assert measure_compactness(floor) == pytest.approx(
            {HULL: body / 12.6**2, COURTS: 3.4**2 / 12.6**2, FACADE: 4 * (12.6 + 3.4) / body**0.5}
        )

    def test_a_model_without_a_building_draws_other_areas(self):
        model = sized_model()
        source = model.floors[0].source
        assert [floor.source for floor in leave_geometry_out(model, frozenset({source})).floors] == [
            floor.source for floor in model.floors if floor.source != source
        ]


class TestClosedCircle:
    def test_an_empty_school_is_read_as_it_was_drawn(self):
        plan = pianta.draw_plan(make_schools()[0], sized_model(), seed=1)
        figures = scan_and_read(plan.floor, EMPTY, SCHOOL, seed=1)
        assert (figures[ROOMS], figures[DOORS], figures[SAME]) == (1, 1, True)

    @pytest.mark.parametrize(("width", "reached"), [(0.9, 3), (0.3, 2)])
    def test_a_robot_reaches_the_rooms_behind_doors_that_are_as_wide_as_it(self, width, reached):
        """A corridor with two rooms; the door of one is narrower than a robot of a radius of 0.2 m."""
        rooms = (box(0, 0, 9, 2), box(0, 2.2, 4, 6), box(4.2, 2.2, 9, 6))
        doors = (
            Door((1, 2), LineString([(1, 2.1), (2, 2.1)]), 1.0),
            Door((1, 3), LineString([(6, 2.1), (6 + width, 2.1)]), width),
        )
        floor = Floor(tuple(Room(number, room, "OFFICE") for number, room in enumerate(rooms, 1)), doors)
        assert count_reached_rooms(floor) == reached

    def test_labels_can_make_graphs_differ(self):
        other = replace(FLOOR, rooms=(*FLOOR.rooms[:2], replace(FLOOR.rooms[2], labels={"R/C": "CORRIDOR"})))
        assert have_same_graph(FLOOR, other)
        assert have_same_graph(FLOOR, FLOOR, labels=True)
        assert not have_same_graph(FLOOR, other, labels=True)

    def test_a_label_of_one_of_many_rooms_at_a_corridor_is_found_at_once(self):
        corridor = Room(1, box(0, 0, 30, 2), "CORRIDOR", labels={"R/C": "CORRIDOR"})
        rooms = [Room(n, box(n, 2, n + 1, 6), "CLASSROOM", labels={"R/C": "ROOM"}) for n in range(2, 30)]
        doors = tuple(Door((1, room.id), LineString([(room.id, 2), (room.id + 0.9, 2)]), 0.9) for room in rooms)
        floor = Floor((corridor, *rooms), doors)
        other = Floor((corridor, *rooms[:-1], replace(rooms[-1], labels={"R/C": "CORRIDOR"})), doors)
        assert have_same_graph(floor, floor, labels=True)
        assert not have_same_graph(floor, other, labels=True)


class TestTables:
    def test_shares_of_buildings_and_of_doors(self):
        results = make_results({GENERATED: [FLOOR], WITHHELD: [FLOOR], REAL: [FLOOR, FLOOR]})
        doors, sizes, compactness, realism = tabulate(results)
        assert doors.rows[SHARE][GENERATED].mean == pytest.approx(200 / 3)
        assert doors.rows[SMALL_SHARE][GENERATED].mean == 100
        assert doors.rows[DOOR_SHARE][GENERATED].mean == pytest.approx(98.5)
        assert doors.rows[NARROW][WITHHELD].mean == 3
        assert (doors.rows["processor time, s"][GENERATED].mean, doors.rows[LARGEST_TIME][GENERATED].mean) == (3, 5)
        assert sizes.rows[f"CORRIDOR, {REAL}"]["aspect"].mean == 5
        assert sizes.rows[f"CORRIDOR, {GENERATED}"]["p of areas"].mean == 1
        assert compactness.rows[f"{HULL}, {REAL}"]["up to 30"].mean == measure_compactness(FLOOR)[HULL]
        assert realism.rows["R/C"][GENERATED].mean == 0.4

    def test_scans_are_two_tables(self):
        results = make_results({GENERATED: [FLOOR], WITHHELD: [FLOOR], REAL: [FLOOR]})
        for item, same in (("a", True), ("b", False)):
            for scan in SCANS:
                figures = {ROOMS: 0.9, DOORS: 0.8, SAME: same, SAME_LABELLED: False}
                results.add(GENERATED, item, figures, scan=scan)
        *_, circle, graphs = tabulate(results)
        assert circle.rows[f"{GENERATED}, {SOME}"][ROOMS].mean == pytest.approx(90)
        assert (graphs.rows[f"{GENERATED}, {IN_USE}"][SAME].mean, graphs.rows[f"{GENERATED}, {IN_USE}"][SAME].sd) == (
            50,
            None,
        )
        assert circle.notes[0] == "2 generated and 0 real graphs of at most 35 rooms."

    def test_pairs_are_real_floors_above_drawn_ones(self):
        figure = draw_pairs(make_results({GENERATED: [], WITHHELD: [FLOOR], REAL: [FLOOR]}))
        assert [ax.get_title() for ax in figure.axes] == ["literal, 3 rooms", "drawn from its graph"]


def test_unknown_types_are_refused():
    with pytest.raises(OptionError, match="type is 'castle', give one of school, office"):
        measure(type="castle")


def test_schools_are_drawn_and_read_again(tmp_path, monkeypatch):
    write_schools(tmp_path / "data", "KKKW-KL", "KKS-KK", "LLW-KKK", "KKC-LK", "LLC-KKW", "KK-KWL")
    monkeypatch.setattr("pianta_bench.drawing.measure.read_annotated_buildings", read_as_buildings)
    options = ("--data", tmp_path / "data", "--count", 2, "--scanned", 1, "--jobs", 1)
    run = run_pianta("bench", "drawing", *options, "--json", tmp_path / "new.json", "--pictures", tmp_path / "pictures")
    assert "Drawn school floors" in run.out
    # Areas of a label that one building alone has are unknown without it
    assert run.code == 1
    assert "the model has no areas of rooms 'STAIRS'" in " ".join(run.out.split())
    assert (tmp_path / "pictures" / "pairs.png").stat().st_size > 10_000
    content = json.loads((tmp_path / "new.json").read_text())
    parts = [record["part"] for record in content["records"] if record["metric"] == ALL_DOORS]
    assert (parts.count(GENERATED), parts.count(WITHHELD)) == (2, 5)
    scans = [(record["part"], record["scan"]) for record in content["records"] if record["metric"] == ROOMS]
    assert scans == [(part, scan) for part in (GENERATED, WITHHELD) for scan in SCANS]
    assert all(record["value"] == 0 for record in content["records"] if record["metric"] == OVERLAP)
