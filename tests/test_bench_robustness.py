"""The bench of robustness: noise and turns of small maps, and shares of numbers of rooms by hand."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import DataError, MapError, OptionError
from pianta.floor import Floor, Room
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta_bench.data.folders import DEFAULT_ROBUSTNESS_SETS, ROBUSTNESS_SET_NAMES
from pianta_bench.data.layout_sets import LAYOUT_SETS
from pianta_bench.data.map_sets import SETS
from pianta_bench.robustness import measure as robustness
from pianta_bench.robustness.measure import is_as_many, measure
from pianta_bench.robustness.tables import tabulate
from pianta_bench.robustness.variants import add_salt_and_pepper, rotate_cells
from tests.bench_results import show_lines
from tests.command_line import run_pianta
from tests.tiny_data import ROOMS, write_all_sets, write_vacuum

GRID = GridMap(np.array([[0, 100, -1], [0, 50, 30]]), 0.05)


@pytest.fixture
def find(monkeypatch):
    """Replaces reconstruct by a function that returns floors with given numbers of rooms in order."""

    def replace(*numbers: int | Exception) -> None:
        left = iter(numbers)

        def reconstruct(*_: object, **__: object) -> Floor:
            number = next(left)
            if isinstance(number, Exception):
                raise number
            return Floor(tuple(Room(index + 1, ROOMS[0]) for index in range(number)))

        monkeypatch.setattr(robustness, "reconstruct", reconstruct)

    return replace


def figures_of(results, item: str) -> dict[str, float | None]:
    return {record["metric"]: record["value"] for record in results.select(item=item, variant="")}


def test_one_cell_of_a_hundred_is_salt_or_pepper():
    """Of 20 × 30 cells 6 are chosen: 3 become occupied, 3 free."""
    grid = GridMap(np.full((20, 30), UNKNOWN), 0.05, (1.0, 2.0, 0.5), "map.yaml")
    noisy = add_salt_and_pepper(grid, seed=3, draw=0)
    assert [(noisy.cells == value).sum() for value in (OCCUPIED, FREE, UNKNOWN)] == [3, 3, 594]
    assert (noisy.resolution, noisy.origin, noisy.source) == (grid.resolution, grid.origin, grid.source)
    assert (grid.cells == UNKNOWN).all()


def test_draws_differ_and_repeat():
    grid = GridMap(np.zeros((40, 40), int), 0.05)
    first, again, other, third = (
        add_salt_and_pepper(grid, seed=seed, draw=draw).cells.tolist()
        for seed, draw in ((0, 0), (0, 0), (0, 1), (1, 0))
    )
    assert first == again
    assert first not in (other, third)


@pytest.mark.parametrize(("degrees", "turns"), [(0, 0), (90, 1), (180, 2), (270, 3)])
def test_quarter_turns_are_exact(degrees, turns):
    assert rotate_cells(GRID, degrees).cells.tolist() == np.rot90(GRID.cells, turns).tolist()


def test_a_square_on_its_corner_has_unknown_corners():
    """A square of 4 cells turned by 45° spans 4 √2 = 5.66, so 6 cells; its middle stays, the corners are outside."""
    turned = rotate_cells(GridMap(np.zeros((4, 4), int), 0.05), 45)
    assert turned.shape == (6, 6)
    assert (turned.cells[2:4, 2:4] == FREE).all()
    assert [int(turned.cells[row, col]) for row in (0, 5) for col in (0, 5)] == [UNKNOWN] * 4


def test_a_turn_is_counter_clockwise():
    """A bar to the right of the middle points up after a turn by 80°."""
    cells = np.full((21, 21), UNKNOWN)
    cells[10, 11:21] = OCCUPIED
    rows, cols = np.nonzero(rotate_cells(GridMap(cells, 0.05), 80).cells == OCCUPIED)
    height, width = rotate_cells(GridMap(cells, 0.05), 80).shape
    assert rows.max() < height / 2
    assert cols.min() >= width // 2 - 1


@given(st.integers(0, 360))
def test_a_turn_keeps_the_area(degrees):
    turned = rotate_cells(GridMap(np.zeros((30, 50), int), 0.05), degrees)
    assert (turned.cells == FREE).sum() == pytest.approx(1500, rel=0.03)


def test_a_number_may_differ_by_a_twentieth():
    assert [is_as_many(20, number) for number in (18, 19, 20, 21, 22)] == [False, True, True, True, False]
    assert [is_as_many(19, number) for number in (18, 19, 20)] == [False, True, False]


def test_shares_of_draws_that_change_and_of_turns_that_do_not(tmp_path, find):
    """The map has 20 rooms; one of four draws has none, one has 22; two of the three turns by 90° are within."""
    write_vacuum(tmp_path, "a")
    find(20, 20, 22, MapError("no room"), 21, 19, 20, 23)
    results = measure(tmp_path, sets=("vacuum",), draws=4, turns=90)
    expected: dict[str, Any] = {"rooms": 20, "changed": 50, "noise_least": 0, "noise_most": 22}
    expected |= {"within": pytest.approx(200 / 3), "turn_least": 19, "turn_most": 23}
    assert figures_of(results, "a") == expected
    rooms = {record["variant"]: record["value"] for record in results.select(metric="rooms")}
    assert rooms == {"": 20, **dict(zip((f"draw {draw}" for draw in range(4)), (20, 22, 0, 21), strict=True))} | {
        "turn 90": 19,
        "turn 180": 20,
        "turn 270": 23,
    }


def test_turns_stop_before_the_full_circle(tmp_path, find):
    write_vacuum(tmp_path, "a")
    find(*[3] * 72)
    results = measure(tmp_path, sets=("vacuum",), draws=0, turns=5)
    turns = [record["variant"] for record in results.select(metric="rooms")][1:]
    assert turns == [f"turn {angle}" for angle in range(5, 360, 5)]
    assert figures_of(results, "a")["changed"] is None
    lines = " ".join(show_lines(tabulate(results), results))
    assert "draws of" not in lines
    assert "multiple of 5°" in lines


def test_a_map_that_fails_counts_as_changed_by_all(tmp_path, find):
    write_vacuum(tmp_path, "a", "b")
    find(MapError("no room"), 2, 2, 2)
    results = measure(tmp_path, sets=("vacuum",), draws=1, turns=180)
    assert [item.failure for item in results.items] == ["no room", None]
    assert figures_of(results, "a") == {"changed": 100, "within": 0}
    means = tabulate(results)[-1].rows["vacuum"]
    assert [means[name].mean for name in means] == [2, 50, 1, 50, 1]


def test_the_names_of_the_sets_are_those_of_the_help(tmp_path, monkeypatch):
    write_all_sets(tmp_path, "a")
    measured: list[str] = []

    def run_steps(steps: Mapping[str, object], **_: object) -> tuple[()]:
        measured[:] = steps
        return ()

    monkeypatch.setattr(robustness, "run_steps", run_steps)
    assert {*ROBUSTNESS_SET_NAMES} <= {*SETS, *LAYOUT_SETS}
    assert measure(tmp_path).options["sets"] == [*DEFAULT_ROBUSTNESS_SETS]
    measure(tmp_path, sets=("vacuum",))
    assert measured == ["vacuum, a"]
    for part in ROBUSTNESS_SET_NAMES[:-1]:
        assert robustness.read_grid(tmp_path, part, "a").free.any()


def test_options_without_meaning_are_refused(tmp_path):
    write_vacuum(tmp_path, "a")
    for options in ({"draws": 0, "turns": 0}, {"sets": ("attic",)}, {"items": ("none",)}, {"method": "magic"}):
        with pytest.raises(OptionError):
            measure(tmp_path, **options)
    with pytest.raises(DataError, match="clutter"):
        measure(tmp_path, sets=("clutter",))


def test_the_command_prints_what_it_measures(tmp_path, monkeypatch):
    write_vacuum(tmp_path, "a")

    def cycle() -> Iterator[Floor]:
        while True:
            yield Floor((Room(1, ROOMS[0]),))

    floors = cycle()
    monkeypatch.setattr(robustness, "reconstruct", lambda *_, **__: next(floors))
    options = "--data", tmp_path, "--set", "vacuum", "--item", "a", "--draws", "2", "--turns", "90"
    code, out, err = run_pianta("bench", "robustness", *options, "--json", tmp_path / "new.json")
    assert (code, err) == (0, "")
    rows = [line.split() for line in out.splitlines()]
    assert ["a", "1", "0.0", "1", "1", "100.0", "1", "1"] in rows
    assert ["vacuum", "1", "0.0", "1", "100.0", "1"] in rows
    assert (tmp_path / "new.json").is_file()


@pytest.mark.slow
def test_the_figures_do_not_depend_on_the_processes(tmp_path):
    write_vacuum(tmp_path, "a", "b")
    one, two = (measure(tmp_path, sets=("vacuum",), draws=2, turns=120, jobs=jobs) for jobs in (1, 2))
    assert one.records == two.records
    assert len(one.records) == 2 * (1 + 2 + 3 + 2 + 3)
