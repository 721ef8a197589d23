"""Campus floors of `pianta bench exploration`: maps in larger cells, starts, and tiny folders of maps."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pianta import GridMap
from pianta.errors import DataError, OptionError
from pianta.exploration.world import read_world
from pianta_bench.data.folders import list_maps
from pianta_bench.exploration import CAMPUS
from pianta_bench.exploration import measure as exploration_measure
from pianta_bench.exploration.campus import TRUTH_ENDING, choose_starts, count_joined, join_cells, read_campus
from pianta_bench.exploration.measure import measure
from tests.command_line import run_pianta
from tests.explored_worlds import draw_cells, draw_world
from tests.tiny_data import write_image


@pytest.fixture(autouse=True)
def few_scans(monkeypatch):
    monkeypatch.setattr(exploration_measure, "TIMED", {True: 10, False: 2})


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """A map of a room of 4 × 3 m and one of 2 × 3 m without a door, a file of text, and a black image."""
    folder = tmp_path / CAMPUS
    folder.mkdir()
    write_image(folder / "one.png", 0.05, other=0)
    write_image(folder / "black.png", 0.05, other=0, rooms=())
    (folder / "text.png").write_text("text")
    for name in ("one", "black", "text"):
        (folder / f"{name}{TRUTH_ENDING}").touch()
    return tmp_path


class TestJoinedCells:
    GRID = GridMap(
        draw_cells(
            """
            ....#
            .....
            ..#..
            """
        ),
        0.05,
        (1.0, 2.0, 0.0),
    )

    def test_a_cell_is_free_if_all_of_its_own_are(self):
        """The last row and column reach beyond the map, which is 0.15 m high, so that its bottom is 0.05 m lower."""
        joined = join_cells(self.GRID, 2)
        assert joined.free.tolist() == [[True, True, False], [False, False, False]]
        assert joined.resolution == 0.1
        assert joined.origin == pytest.approx((1.0, 1.95, 0.0))
        assert joined.pixel_to_map(0.0, 0.0) == pytest.approx(self.GRID.pixel_to_map(0.0, 0.0))

    def test_one_is_the_map_itself(self):
        assert (join_cells(self.GRID, 1).free == self.GRID.free).all()

    @pytest.mark.parametrize(("resolution", "side"), [(0.05, 1), (0.1, 2), (0.15, 3), (0.5, 10)])
    def test_sides(self, resolution, side):
        assert count_joined(resolution) == side

    @pytest.mark.parametrize("resolution", [0.02, 0.12])
    def test_other_sizes_are_an_error(self, resolution):
        with pytest.raises(OptionError, match=rf"resolution is {resolution}, give a multiple of 0\.05 m"):
            measure(sets=[CAMPUS], resolution=resolution)


class TestStarts:
    WORLD = draw_world(
        """
        #########
        #...#...#
        #...#...#
        #...#...#
        #...#####
        #########
        """,
        resolution=0.5,
    )

    def test_they_are_in_the_largest_area_and_the_first_is_the_widest(self):
        """In cells of 0.5 m no cell of the larger room is nearer than 0.2 m to a wall; its middle column is widest."""
        starts = choose_starts(self.WORLD)
        cells = [self.WORLD.cell(*start) for start in starts]
        assert cells[0] in {(2, 2), (3, 2)}
        assert all(1 <= row <= 4 and 1 <= col <= 3 for row, col in cells)
        assert len(starts) == 3
        assert choose_starts(self.WORLD) == starts
        assert choose_starts(self.WORLD, 1) == starts[:1]


class TestMaps:
    def test_those_that_cannot_be_read_are_named(self, tiny):
        campus = read_campus(tiny)
        assert [(building.part, building.name, building.others) for building in campus.buildings] == [
            ("kth", "one", ())
        ]
        assert campus.failures["black"] == "the map has no free cell, give one with white floors"
        assert "text.png" in campus.failures["text"]

    def test_none_that_can_be_read_is_an_error(self, tiny):
        (tiny / CAMPUS / "one.png").unlink()
        with pytest.raises(DataError, match="no map of kth can be read, the first: black, the map has no free cell"):
            read_campus(tiny)

    @pytest.mark.slow
    def test_robots_explore_the_largest_free_area(self, tiny):
        """All of the room of 12 m² is seen from its middle; the other one is behind its wall."""
        results = measure(tiny, sets=[CAMPUS], policies=["nearest"], starts=1, resolution=0.1)
        assert [item.item for item in results.items if item.failure] == ["black", "text"]
        figures = {record["metric"]: record["value"] for record in results.records}
        assert figures["area"] == pytest.approx(12.0)
        assert figures["share"] > 0.99
        assert figures["metres to 99 %"] == 0.0

    def test_real_ones(self, data):
        if not (data / CAMPUS).is_dir():
            pytest.skip(f"no {CAMPUS} in {data}")
        campus = read_campus(data)
        assert [building.name for building in campus.buildings] == list_maps(data / CAMPUS, TRUTH_ENDING)
        assert not campus.failures
        for building in campus.buildings:
            assert building.grid is not None
            world = read_world(join_cells(building.grid, 4))
            # No wall opens in larger cells
            assert np.count_nonzero(world.free) * 0.2**2 < np.count_nonzero(building.grid.free) * 0.05**2


class TestCommand:
    @pytest.mark.slow
    def test_tables(self, tiny, tmp_path):
        file = tmp_path / "figures.json"
        outcome = run_pianta(
            "bench", "exploration", "--data", tiny, "--set", "kth", "--policy", "nearest", "--starts", 1, "--json", file
        )
        assert (outcome.code, outcome.err) == (1, "")
        assert "Distance to a share of the area, kth" in outcome.out
        assert "black failed (kth): the map has no free cell, give one with white floors" in outcome.out
        assert [run["outcome"] for run in json.loads(file.read_text())["runs"]] == ["done"]

    def test_a_folder_without_the_maps(self, tmp_path):
        outcome = run_pianta("bench", "exploration", "--data", tmp_path, "--set", "kth")
        assert (outcome.code, outcome.out) == (2, "")
        assert len(outcome.err.splitlines()) == 1
        assert "kth" in outcome.err

    def test_a_map_whose_image_is_hostile(self, tmp_path):
        """An image of more cells than a map may have, in a file of a few kilobytes."""
        folder = tmp_path / CAMPUS
        folder.mkdir()
        Image.new("1", (20_000, 20_000)).save(folder / "large.png")
        (folder / f"large{TRUTH_ENDING}").touch()
        outcome = run_pianta("bench", "exploration", "--data", tmp_path, "--set", "kth")
        assert (outcome.code, len(outcome.err.splitlines())) == (2, 1)
        assert "no map of kth can be read, the first: large, " in outcome.err
