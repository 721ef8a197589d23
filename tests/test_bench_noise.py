"""`pianta bench noise`: maps of small floors at the levels of each factor, and figures reckoned by hand."""

import json
from dataclasses import replace
from math import inf, pi
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import binary_erosion
from shapely import LineString, box

from pianta.errors import DataError, MapError, OptionError
from pianta.floor import Door, Floor, Room, scale_floor
from pianta.labels import FCES, LabelSet
from pianta.worlds.scan import label_displaced_rooms, simulate_map
from pianta_bench.data.annotated_floors import AnnotatedFloor
from pianta_bench.noise import FACTOR_NAMES
from pianta_bench.noise import measure as noise
from pianta_bench.noise.factors import FACTORS, RESOLUTION, WorseMap, limit_reach, list_connected_parts, shut_doors
from pianta_bench.noise.floors import NoiseFloor, list_floors, order_floors
from pianta_bench.noise.measure import LABELS, TYPES, measure, score_functions, score_rooms
from pianta_bench.noise.tables import tabulate
from tests.command_line import run_pianta
from tests.tiny_data import ROOMS, write_schools

DOOR = Door((1, 2), LineString([(5.1, 2), (5.1, 3)]), 1.0)
# Rooms of 12 and of 6 m².
FLOOR = Floor((Room(1, ROOMS[0], "OFFICE"), Room(2, ROOMS[1], "CORRIDOR")), (DOOR,), building_type={"office": 1.0})
CELLS = {1: 4800, 2: 2400}
TRUTH = label_displaced_rooms(FLOOR, simulate_map(FLOOR), noise=0.0, drift=0.0, seed=0)


def count_cells(truth) -> dict[int, int]:
    ids, counts = np.unique(truth[truth > 0], return_counts=True)
    return dict(zip(ids.tolist(), counts.tolist(), strict=True))


@pytest.mark.parametrize("name", FACTOR_NAMES)
def test_the_first_level_of_each_factor_is_the_clean_map(name):
    factor = FACTORS[name]
    clean = factor.simulate(FLOOR, factor.clean, 5)
    assert clean.grid.cells.tolist() == simulate_map(FLOOR, resolution=RESOLUTION, seed=5).cells.tolist()
    assert count_cells(clean.truth) == CELLS
    # Rooms of 32 m × 24 m and 16 m × 24 m are larger than the shortest reach.
    large = scale_floor(FLOOR, 8, 8)
    first, worst = (factor.simulate(large, level, 5).grid.cells for level in (factor.clean, factor.levels[-1]))
    assert first.shape == worst.shape
    assert (first != worst).any()


def test_levels_are_chosen_evenly_and_named_with_their_unit():
    doors, drift = FACTORS["doors"], FACTORS["drift"]
    assert [doors.choose_levels(count) for count in (1, 2, 4)] == [[1], [0.5, 1], [0.25, 0.5, 0.75, 1]]
    assert [doors.name_level(level) for level in (0, 0.25)] == ["clean", "25 %"]
    assert [drift.name_level(level) for level in (0, 0.4)] == ["clean", "0.4 m"]
    assert [FACTORS["reach"].name_level(level) for level in (inf, 2.5)] == ["clean", "2.5 m"]


def test_a_share_of_the_doors_is_shut_and_openings_stay():
    """Of 8 doors 2, 4 and 8 are shut; those that are shut at a quarter are shut at a half too."""
    doors = [replace(DOOR, width=1 + number / 10) for number in range(8)]
    floor = replace(FLOOR, doors=(*doors, replace(DOOR, kind="opening")))
    quarter, half, all_shut = (shut_doors(floor, share, 3).doors for share in (0.25, 0.5, 1.0))
    assert [len(quarter), len(half), len(all_shut)] == [7, 5, 1]
    assert all_shut[0].kind == "opening"
    assert {door.width for door in half} < {door.width for door in quarter}
    assert shut_doors(floor, 0.0, 3) == floor


def test_a_shut_door_is_a_wall():
    closed = FACTORS["doors"].simulate(FLOOR, 1.0, 0).grid
    row, col = (int(value) for value in closed.map_to_pixel(5.1, 2.5))
    assert not closed.free[row, col]
    assert simulate_map(FLOOR).free[row, col]


def test_the_reach_limits_what_is_known():
    """From the middle of a hall without doors a lidar of 4 m knows a disc of 16 pi m²."""
    hall = Floor((Room(1, box(0, 0, 20, 20)),))
    worse = limit_reach(hall, 4.0, 0)
    assert worse.grid.free.sum() * RESOLUTION**2 == pytest.approx(16 * pi, rel=0.02)
    assert not worse.grid.occupied.any()
    assert count_cells(worse.truth) == {1: 160_000}
    assert limit_reach(hall, inf, 0).grid.free.sum() == 160_000


def test_rooms_that_no_door_joins_are_explored_too():
    floor = replace(FLOOR, doors=())
    assert [[room.id for room in part.rooms] for part in list_connected_parts(floor)] == [[1], [2]]
    assert [len(part.doors) for part in list_connected_parts(FLOOR)] == [1]
    explored = limit_reach(floor, 10.0, 0)
    assert np.unique(explored.truth[explored.grid.free]).tolist() == [1, 2]


@pytest.mark.parametrize(("noise_level", "drift", "reach"), [(0.0, 0.5, 0.5), (0.0, None, 0.0), (1.0, 0.0, 0.085)])
def test_true_rooms_move_with_the_walls_and_no_farther_than_the_drift(noise_level, drift, reach):
    """Noise 1 without drift moves walls by at most 0.05 + 0.035 m along each axis."""
    floor = replace(FLOOR, doors=())
    truth = label_displaced_rooms(floor, simulate_map(floor), noise=noise_level, drift=drift, seed=4)
    cells = round(reach / 0.05 + 0.5)
    for room in (1, 2):
        inside = binary_erosion(room == TRUTH, np.ones((2 * cells + 1, 2 * cells + 1)))
        assert inside.any()
        assert (truth[inside] == room).all()
    assert (truth != TRUTH).any() == (reach > 0)
    if not noise_level:
        grid = simulate_map(floor, drift=drift, seed=4)
        assert (grid.free == (truth > 0)).all()


def test_drift_out_of_range():
    with pytest.raises(OptionError, match=r"drift is -1, give 0 … 10 metres"):
        simulate_map(FLOOR, drift=-1)


def test_rooms_are_scored_on_the_cells_of_true_rooms():
    """Two rooms of 4800 and 2400 cells found as one: IoU 2/3 with the first, so F1 is 2 · 1 / (1 + 2)."""
    worse = WorseMap(simulate_map(FLOOR), TRUTH)
    assert score_rooms(TRUTH, worse) == 100
    assert score_rooms(np.ones_like(TRUTH), worse) == pytest.approx(100 * 2 / 3)
    assert score_rooms(np.zeros_like(TRUTH), worse) == 0


def test_labels_are_those_of_the_true_room_that_a_room_overlaps_most():
    """Of four rooms one has the label of its true room, one another label, one no true room and one no cell."""

    def label(number: int, function: str) -> Room:
        return Room(number, ROOMS[0], labels={LabelSet.F_C_E_S: function})

    rooms = [label(7, FCES.FUNCTIONAL), label(8, FCES.FUNCTIONAL), label(9, FCES.FUNCTIONAL), label(10, FCES.SERVICE)]
    labels = np.where(TRUTH == 1, 7, np.where(TRUTH == 2, 8, 0))
    labels[:5] = 9
    assert score_functions(Floor(tuple(rooms)), labels, TRUTH, FLOOR) == 25


def test_types_come_in_turn_and_a_building_once_before_again():
    names = ["school/a", "school/a", "school/a", "school/b", "school/c", "office/d"]
    floors = [AnnotatedFloor(f"{n}", name.partition("/")[0], name, FLOOR) for n, name in enumerate(names)]
    for seed in range(5):
        ordered = order_floors(floors, seed=seed)
        assert sorted(each.item for each in ordered) == sorted(each.item for each in floors)
        assert [each.kind for each in ordered[:2]] == ["school", "office"]
        assert {each.building for each in ordered[:4]} == {"school/a", "school/b", "school/c", "office/d"}


def write_data(data) -> None:
    """Three schools and an office; maps of the first school and of the office."""
    write_schools(data, "KLC", "KKW-LC", "KCC")
    (data / "buildings" / "office").mkdir()
    school = (data / "buildings" / "school" / "school0.xml").read_text()
    office = school.replace("CLASSROOM", "OFFICE").replace("LAB", "KITCHEN")
    (data / "buildings" / "office" / "office0.xml").write_text(office)
    (data / "slam").mkdir()
    for name in ("school0", "office0"):
        (data / "slam" / f"{name}_gt.xml").touch()


def test_drawn_floors_are_of_buildings_that_the_network_has_not_seen(tmp_path):
    write_data(tmp_path)
    floors = list_floors(tmp_path, "drawn", count=9, seed=0)
    assert {each.building for each in floors} == {"school/school0", "office/office0"}
    assert [len(each.others) for each in floors] == [3, 3]
    # Drawn rooms meet in the middle of the wall.
    area = {each.kind: sum(room.polygon.area for room in each.floor.rooms) for each in floors}
    assert 0 < area["school"] < 12 * 2 + 3 * 4 * 4
    (tmp_path / "slam" / "school0_gt.xml").unlink()
    (tmp_path / "slam" / "office0_gt.xml").unlink()
    with pytest.raises(DataError, match="no drawn floor of a building of slam or doors"):
        list_floors(tmp_path, "drawn", count=1, seed=0)


def test_the_bench_of_drawn_floors(tmp_path):
    write_data(tmp_path)
    options = "--floors", 1, "--factor", "doors", "--levels", 1, "--method", "voronoi"
    code, out, err = run_pianta("bench", "noise", "--data", tmp_path, *options)
    assert (code, err) == (0, "")
    assert "Floors: school0." in out
    assert "Labels" not in out


@pytest.mark.slow
def test_the_bench_of_made_floors(tmp_path):
    options = "--set", "worlds", "--floors", 1, "--factor", "drift", "--factor", "doors", "--levels", 1
    outputs = "--json", tmp_path / "noise.json", "--pictures", tmp_path / "pictures"
    code, out, err = run_pianta("bench", "noise", *options, "--method", "thesis", "--method", "distance", *outputs)
    assert (code, err) == (0, "")
    assert "Rooms over drift" in out
    assert "Labels and building type over doors shut" in out
    content = json.loads((tmp_path / "noise.json").read_text())
    assert content["options"]["floors"] == ["office-0"]
    by_level = [(item["part"], item["item"]) for item in content["items"]]
    assert by_level == [
        *(("clean", f"office-0, clean, {method}") for method in ("thesis", "distance")),
        *(("drift", f"office-0, 0.8 m, {method}") for method in ("thesis", "distance")),
        *(("doors", f"office-0, 100 %, {method}") for method in ("thesis", "distance")),
    ]
    types = [record["value"] for record in content["records"] if record["metric"] in TYPES.values()]
    assert len(types) == 12
    assert sum(types) == 400
    assert (tmp_path / "pictures" / "curves.png").stat().st_size > 10_000


def test_a_map_without_rooms_counts_as_nothing_and_its_type_is_unknown(monkeypatch):
    def find_nothing(*_, **__):
        raise MapError("the map shows no room")

    monkeypatch.setattr(noise, "reconstruct", find_nothing)
    results = measure(floor_set="worlds", floors=1, factors=["doors"], levels=1, methods=["structure"])
    assert not results.failed
    figures = {record["metric"]: record["value"] for record in results.select(level="100 %")}
    types = {TYPES["right"]: 0, TYPES["unknown"]: 100, TYPES["wrong"]: 0}
    assert figures == {noise.ROOMS: 0, LABELS: 0} | types


def test_a_method_that_fails_counts_as_nothing(monkeypatch):
    def fail(*_, **__):
        raise RuntimeError("broken")

    monkeypatch.setattr(noise, "reconstruct", fail)
    options = "--set", "worlds", "--floors", 1, "--factor", "doors", "--levels", 1, "--method", "voronoi"
    code, out, _ = run_pianta("bench", "noise", *options)
    assert code == 1
    assert "office-0, 100 %, voronoi failed (doors): RuntimeError: broken" in out
    assert "A map that failed counts as 0." in out


def test_the_clean_map_is_read_once_and_stands_first_in_every_table(monkeypatch):
    read = []

    def reconstruct(grid, **_):
        read.append(grid)
        return SimpleNamespace(rooms=())

    monkeypatch.setattr(noise, "reconstruct", reconstruct)
    results = measure(floor_set="worlds", floors=1, factors=["doors", "drift"], levels=2, methods=["voronoi"])
    assert len(read) == 1 + 2 + 2
    doors, drift = tabulate(results)
    assert [*doors.rows] == ["clean", "50 %", "100 %"]
    assert [*drift.rows] == ["clean", "0.2 m", "0.8 m"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--set", "castle"), "set is 'castle', give drawn or worlds"),
        (("--factor", "rain"), "factor is 'rain', give one of noise, drift, furniture, doors, reach"),
        (("--method", "magic"), "'magic'"),
        (("--data", "nowhere"), "no data in 'nowhere'"),
    ],
)
def test_bad_input_is_one_line(options, message):
    code, out, err = run_pianta("bench", "noise", *options)
    assert (code, out) == (2, "")
    assert message in err
    assert len(err.splitlines()) == 1


def test_a_building_that_cannot_be_left_out_of_the_types_is_refused():
    floor = NoiseFloor("a", "school", "school/nowhere", Floor(()), others=[("b", ())])  # type: ignore[list-item]
    with pytest.raises(DataError, match="'school/nowhere' is not in the model of types"):
        floor.train_type_model()
