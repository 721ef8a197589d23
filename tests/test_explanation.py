"""Why rooms were divided: borders with probabilities, in words and as a picture, by `pianta read --explain`."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image
from shapely import LineString, box

import pianta
from pianta.errors import OptionError
from pianta.floor import Door, Floor, Furniture, Room
from pianta.gridmap import GridMap
from pianta.layout.explanation import Border, Explanation, find_sides
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.evidence import DOOR, OUTSIDE, WALL
from pianta.layout.structure.evidence import FLOOR as FLOOR_CLASS
from pianta.layout.structure.explain import explain_structure
from pianta.plan.sheets.sheet import PlanScale
from pianta.plot.explanation import CUT_COLOR, JOINED_COLOR, draw_explanation, plot_explanation
from pianta.reading.reading import StoreyReading
from tests.command_line import list_files, run_pianta
from tests.drawn_maps import carve, make_grid

# Two rooms of 4 × 4 m, an opening of 3 m to a third one; metres, the map is 12.4 × 5 m.
GRID = GridMap(np.zeros((50, 124), int), 0.1)
FLOOR = Floor(
    (Room(1, box(0, 0, 4, 4)), Room(2, box(4.2, 0, 8, 4)), Room(5, box(8, 0, 12, 4))),
    (
        Door((1, 2), LineString([(4.1, 1), (4.1, 2)]), 1.0),
        Door((2, 5), LineString([(8, 1), (8, 3.5)]), 2.5, "opening"),
    ),
    furniture=(Furniture(box(1, 1, 2, 2)),),
)
BORDERS = (
    Border((1, 2), LineString([(4.1, 1), (4.1, 2)]), 0.974, "narrow"),
    Border((2, 5), LineString([(8, 1), (8, 3.5)]), None, "by the line of a wall"),
    Border((1, 1), LineString([(2, 0), (2, 4)]), 0.12, "wide"),
    Border((1, 1), LineString([(0, 2), (1, 2)]), 0.3, "wide"),
    Border((1, 1), LineString([(1, 3), (2, 3)]), 0.04, "wide"),
    Border((1, 1), LineString([(3, 3), (4, 3)]), 0.2, "wide"),
    Border((1, 2), LineString([(4.1, 3), (4.1, 3.5)]), 0.6, "narrow"),
)
EXPLANATION = Explanation(GRID, FLOOR, BORDERS)


class TestWords:
    def test_a_room_with_borders_to_others_and_inside(self):
        """The most probable first, at most three inside; no door is near the second border to room 2."""
        assert EXPLANATION.describe_room(1) == (
            "room 1: divided from 2 by a door of 1.0 m (p = 0.97), from 2 by a wall (p = 0.60); "
            "not divided along 1.0 m at (0.5, 2.0) (p = 0.30), along 1.0 m at (3.5, 3.0) (p = 0.20), "
            "along 4.0 m at (2.0, 2.0) (p = 0.12)"
        )

    def test_a_border_that_a_rule_has_decided(self):
        assert EXPLANATION.describe_room(5) == "room 5: divided from 2 by an opening of 2.5 m (by the line of a wall)"

    def test_a_room_without_borders(self):
        without = replace(EXPLANATION, borders=(), floor=replace(FLOOR, doors=()))
        assert without.describe_room(2) == "room 2: no border was considered"

    def test_every_door_is_named_once(self):
        """Two borders are at the one door between 1 and 2, none at the opening to 5."""
        borders = (BORDERS[0], Border((1, 2), LineString([(4.05, 1), (4.05, 2)]), 0.7, "narrow"))
        assert replace(EXPLANATION, borders=borders).describe_room(2) == (
            "room 2: divided from 1 by a door of 1.0 m (p = 0.97), from 5 by an opening of 2.5 m (a gap in the wall)"
        )

    def test_an_unknown_room(self):
        with pytest.raises(KeyError, match="3"):
            EXPLANATION.describe_room(3)


def test_the_rooms_on_the_two_sides_of_a_line():
    """Room 1 is to the left of a line that runs up; a wall of 0.2 m is no matter; outside there is no room."""
    lines = np.array(
        [[(4.1, 1), (4.1, 2)], [(4.1, 2), (4.1, 1)], [(2, 0.5), (2, 3.5)], [(0, 1), (0, 3)], [(50, 1), (50, 2)]], float
    )
    assert find_sides(lines, FLOOR, GRID).tolist() == [[1, 2], [2, 1], [1, 1], [0, 1], [0, 0]]
    assert find_sides(np.zeros((0, 2, 2)), FLOOR, GRID).shape == (0, 2)


# Two rooms of 4 × 4 m and a door of 0.9 m in the wall of 0.2 m between them, cells of 0.05 m.
TWO_ROOMS = make_grid(carve((100, 184), (10, 90, 10, 90), (40, 58, 90, 94), (10, 90, 94, 174)), yaw=0.2)


class TestStructure:
    def test_a_door_divides_two_rooms(self):
        explanation = pianta.explain(TWO_ROOMS)
        (border,) = [border for border in explanation.borders if border.divides]
        (door,) = explanation.floor.doors
        assert border.rooms == (1, 2)
        assert border.probability is not None
        assert border.probability > 0.9
        assert border.line.distance(door.line) < 0.15
        assert border.line.length == pytest.approx(0.9, abs=0.11)
        assert explanation.describe_room(1).startswith("room 1: divided from 2 by a door of 0.9 m (p = ")

    def test_the_ids_are_those_of_the_floor(self):
        floor = pianta.reconstruct(TWO_ROOMS)
        ids = {1: 7, 2: 3}
        rooms = tuple(replace(room, id=ids[room.id]) for room in floor)
        renumbered = Floor(rooms, tuple(door.renumber_rooms(ids) for door in floor.doors))
        assert {border.rooms for border in pianta.explain(TWO_ROOMS, renumbered).borders if border.divides} == {(3, 7)}

    def test_all_borders_have_a_probability_and_a_reason(self):
        _, grid = pianta.make_world("hall", furniture=1.0)
        considered = explain_structure(grid, parameters=StructureParameters())
        assert len(considered.lines) == len(considered.reasons) == len(considered.probabilities) > 0
        assert all(0 <= probability <= 1 for probability in considered.probabilities if probability is not None)

    def test_the_evidence_is_that_of_the_cells_of_the_map(self):
        """Rows 10 to 89 are floor, columns 90 to 93 the wall with the door in rows 40 to 57; outside is far away."""
        evidence = explain_structure(TWO_ROOMS, parameters=StructureParameters()).evidence
        assert evidence is not None
        assert evidence.shape == (100, 184, 5)
        assert evidence.sum(axis=2) == pytest.approx(1, abs=1e-3)
        assert evidence[50, 40].argmax() == evidence[50, 130].argmax() == FLOOR_CLASS
        assert evidence[49, 92].argmax() == DOOR
        assert evidence[20, 92].argmax() == WALL
        assert evidence[0, 0].argmax() == OUTSIDE

    def test_a_floor_without_doors_has_no_dividing_border(self):
        explanation = pianta.explain(make_grid(carve((60, 60), (10, 50, 10, 50))))
        assert explanation.borders == ()
        assert explanation.describe_room(1) == "room 1: no border was considered"

    def test_parameters_of_another_method(self):
        with pytest.raises(OptionError, match="StructureParameters"):
            pianta.explain(TWO_ROOMS, parameters=pianta.ThesisParameters())


class TestPicture:
    def test_borders_have_colours_and_numbers(self):
        ax = plot_explanation(EXPLANATION, ax=Figure().add_subplot())
        colors = [to_hex(line.get_color()) for line in ax.lines]
        assert colors == [CUT_COLOR] * 2 + [JOINED_COLOR] * 4 + [CUT_COLOR]
        assert [line.get_linestyle() for line in ax.lines] == ["-"] * 2 + ["--"] * 4 + ["-"]
        starts = [np.asarray(line.get_xydata())[0].tolist() for line in ax.lines]
        assert starts == [list(border.line.coords[0]) for border in BORDERS]
        # None for the one of a rule, and for one inside a room that is improbable.
        assert [text.get_text() for text in ax.texts] == ["0.97", "0.12", "0.30", "0.20", "0.60"]

    def test_evidence_is_drawn_instead_of_furniture(self):
        plain, tinted = Figure().add_subplot(), Figure().add_subplot()
        plot_explanation(EXPLANATION, ax=plain)
        plot_explanation(replace(EXPLANATION, evidence=np.zeros((50, 124, 5), np.float32)), ax=tinted)
        # A layer for each of walls, doors and furniture.
        assert len(tinted.images) == len(plain.images) + 3
        assert len(tinted.patches) == len(plain.patches) - len(FLOOR.furniture)

    def test_a_legend_names_what_is_drawn(self):
        def entries(explanation: Explanation) -> list[str]:
            legend = draw_explanation(explanation).axes[1].get_legend()
            return [text.get_text() for text in legend.get_texts()] if legend else []

        borders = ["divides two rooms, with its probability", "considered, one room"]
        assert entries(EXPLANATION) == [*borders, "furniture"]
        assert entries(replace(EXPLANATION, floor=replace(FLOOR, furniture=()))) == borders
        evidence = np.zeros((50, 124, 5), np.float32)
        assert entries(replace(EXPLANATION, evidence=evidence)) == [*borders, "wall", "door", "furniture"]

    def test_a_floor_without_rooms(self):
        assert not plot_explanation(Explanation(GRID, Floor(()), ()), ax=Figure().add_subplot()).lines


@pytest.fixture(scope="module")
def world(tmp_path_factory) -> Path:
    folder = Path(tmp_path_factory.mktemp("world"))
    run_pianta("world", "corridor", "-o", folder, "--furniture", 0.5)
    return folder / "map.yaml"


class TestCommand:
    def test_it_prints_a_line_for_each_room_and_draws_a_picture(self, world, tmp_path):
        outcome = run_pianta("read", world, "-o", tmp_path / "out", "--explain", "--no-labels")
        assert (outcome.code, outcome.err) == (0, "")
        floor = pianta.read_floor(tmp_path / "out" / "floor.geojson")
        lines = [line for line in outcome.out.splitlines() if line.startswith("room ") and ":" in line]
        assert [line.split(":")[0] for line in lines] == [f"room {room.id}" for room in floor]
        assert all(": divided from " in line and "(p = " in line for line in lines)
        assert sorted(list_files(tmp_path / "out")) == [
            "explain.png",
            "floor.geojson",
            "graph.json",
            "grid.npz",
            "picture.png",
            "rooms.png",
        ]
        with Image.open(tmp_path / "out" / "explain.png") as image:
            assert max(image.size) >= 1600

    def test_quiet_prints_nothing_and_draws(self, world, tmp_path):
        outcome = run_pianta("read", world, "-o", tmp_path, "--explain", "--no-labels", "-q")
        assert outcome == (0, "", "")
        assert (tmp_path / "explain.png").is_file()

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            (["--method", "voronoi"], "method voronoi has no explanation, leave out --explain or give structure"),
            (["map.yaml"], "--explain is for one map and 2 files are given, read each file on its own"),
        ],
    )
    def test_what_cannot_be_explained(self, world, tmp_path, options, message):
        outcome = run_pianta("read", world, *options, "-o", tmp_path / "out", "--explain")
        assert (outcome.code, outcome.out) == (2, "")
        assert message in outcome.err
        assert list_files(tmp_path) == {}

    def test_the_map_is_not_replaced_by_the_picture(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        TWO_ROOMS.save("map.yaml")
        Path("map.png").rename("explain.png")
        Path("map.yaml").write_text(Path("map.yaml").read_text().replace("map.png", "explain.png"))
        before = list_files(tmp_path)
        for options in (["explain.png", "--as", "map", "--resolution", 0.05], ["map.yaml"]):
            outcome = run_pianta("read", *options, "-o", ".", "--explain")
            assert outcome.code == 2
            assert "'explain.png' would be replaced by a result, give another output folder" in outcome.err
        assert list_files(tmp_path) == before

    def test_a_plan_was_not_divided(self):
        storey = StoreyReading(FLOOR, GRID, scale=PlanScale(0.05, "a guess", 1.0))
        with pytest.raises(OptionError, match=r"plan 'house.dxf' was not divided by pianta, give a robot's map"):
            pianta.Reading(Path("house.dxf"), (storey,), {}).explain()
