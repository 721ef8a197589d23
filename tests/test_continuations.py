"""Samples of predictions that are continuations behind the open ends of a floor, and the grid of their shares."""

import json
from dataclasses import replace
from math import cos, log, pi, sin
from typing import Any

import numpy as np
import pytest
import shapely
from shapely import LineString, Point, affinity, box
from shapely.geometry.base import BaseGeometry

import pianta
from pianta.errors import FloorError, ModelError, OptionError
from pianta.floor import PREDICTED_FLAG, Door, Floor, Room
from pianta.generation.drawing.blocks import NO_ROOM, Contact, find_contacts
from pianta.generation.type_model import TypeModel
from pianta.generation.type_model_file import save_type_model
from pianta.gridmap import GridMap
from pianta.io.floors import read_floor, save_floor
from pianta.io.graphs import save_graph
from pianta.prediction.continuation.continuations import choose_typical
from pianta.prediction.continuation.drawn_floor import _locate_passage, round_outline
from pianta.prediction.continuation.free_probability import LEAST_SHARE, describe_cells, find_free_probability
from pianta.prediction.continuation.ground import find_threshold, make_frame
from pianta.prediction.continuation.known_part import locate_known_part
from pianta.prediction.continuation.layout import BLOCKED, SpaceFiller
from pianta.prediction.continuation.shares import ShareGrid, move_to_map
from pianta.prediction.explored_part import read_explored_part
from pianta.prediction.revealed_floor import reveal_corridors
from tests.command_line import list_files, run_pianta
from tests.generated_types import SCHOOL, sized_model, small_model


@pytest.fixture(scope="module")
def model() -> TypeModel:
    return sized_model()


def make_floor() -> Floor:
    """A corridor that goes on to the right, three rooms at it, and a door to a room of which little was seen."""
    rooms = (
        Room(1, box(0, 0, 20, 2.5), "CORRIDOR", partial=True),
        Room(2, box(0, 2.7, 8, 9), "CLASSROOM"),
        Room(3, box(8.2, 2.7, 16, 9), "CLASSROOM"),
        Room(4, box(0, -6, 6, -0.2), "CLOSET"),
        Room(7, box(2, -7.2, 4, -6.2), partial=True),
    )
    doors = (
        Door((1, 2), LineString([(3, 2.6), (4, 2.6)]), 1.0),
        Door((1, 3), LineString([(10, 2.6), (11, 2.6)]), 1.0),
        Door((1, 4), LineString([(3, -0.1), (4, -0.1)]), 1.0),
        Door((4, 7), LineString([(2.5, -6.1), (3.5, -6.1)]), 1.0),
    )
    return Floor(rooms, doors, building_type={"school": 1.0}, source="literal")


def turn(floor: Floor, angle: float, x: float, y: float) -> Floor:
    """A floor in another frame."""

    def move(shape: BaseGeometry) -> Any:
        return affinity.translate(affinity.rotate(shape, angle, (0, 0), use_radians=True), x, y)

    rooms = tuple(replace(room, polygon=move(room.polygon)) for room in floor)
    return replace(floor, rooms=rooms, doors=tuple(replace(door, line=move(door.line)) for door in floor.doors))


def make_whole_floor() -> Floor:
    """Two corridors one after the other, each with a classroom."""
    rooms = (
        Room(1, box(0, 0, 10, 2), "CORRIDOR"),
        Room(2, box(10, 0, 30, 2), "CORRIDOR"),
        Room(3, box(0, 2, 6, 8), "CLASSROOM"),
        Room(4, box(20, 2, 26, 8), "CLASSROOM"),
        Room(5, box(0, -2, 2, 0), "ENTRANCE"),
    )
    doors = (
        Door((1, 2), LineString([(10, 0.5), (10, 1.5)]), 1.0),
        Door((1, 3), LineString([(3, 2), (4, 2)]), 1.0),
        Door((2, 4), LineString([(22, 2), (23, 2)]), 1.0),
        Door((1, 5), LineString([(0.5, 0), (1.5, 0)]), 1.0),
    )
    return Floor(rooms, doors, building_type={"school": 1.0}, source="whole")


def draw(floor: Floor, model: TypeModel, *, count: int = 6, **options) -> pianta.Continuations:
    return pianta.draw_continuations(pianta.predict(floor, model, count=count), floor, model=model, **options)


def check_plan(plan: Floor, floor: Floor) -> None:
    """Known rooms and doors stay; new rooms overlap nothing; predicted doors are wide enough, between their rooms."""
    new = [room for room in plan if room.id not in floor]
    assert all(room.flag == PREDICTED_FLAG for room in new)
    assert all(plan[room.id] == replace(room, predicted=plan[room.id].predicted) for room in floor)
    assert {*plan.doors} >= {*floor.doors}
    shapes = [*(room.predicted or room.polygon for room in plan)]
    assert sum(shape.area for shape in shapes) == pytest.approx(shapely.union_all(shapes).area, abs=0.05)
    known_part = shapely.union_all([room.polygon for room in floor])
    assert all(room.polygon.intersection(known_part).area < 1e-6 for room in new)
    for room in floor:
        shape = plan[room.id].predicted
        assert shape is None or room.partial
        assert shape is None or shape.buffer(1e-6).contains(room.polygon)
    for door in {*plan.doors} - {*floor.doors}:
        assert door.width >= 0.7
        assert door.line.length == pytest.approx(door.width)
        assert all((plan[room].predicted or plan[room].polygon).distance(door.line) < 0.5 for room in door.room_ids)


class TestDrawContinuations:
    @pytest.mark.parametrize(("angle", "x", "y", "seed"), [(0, 0, 0, 0), (0.4, 300.3, -20.7, 1), (-1.9, -50, 7, 2)])
    def test_rooms_are_behind_open_ends_in_the_frame_of_the_map(self, model, angle, x, y, seed):
        floor = turn(make_floor(), angle, x, y)
        continuations = draw(floor, model, seed=seed)
        assert len(continuations.plans) == 3
        assert sum(plan.share for plan in continuations.plans) == pytest.approx(1)
        assert continuations.placed > 0.9
        for plan in continuations.plans:
            check_plan(plan.floor, floor)
        # The sides of new rooms are along the walls
        largest = max((plan.floor for plan in continuations.plans), key=len)
        assert len(largest) > len(floor)
        for room in (room for room in largest if room.flag):
            side = np.diff(shapely.get_coordinates(room.polygon), axis=0)[0]
            turned = (np.arctan2(side[1], side[0]) - angle) / (pi / 2)
            assert turned == pytest.approx(round(turned), abs=0.01)
        frame = continuations.grid.frame
        for room in largest:
            point = room.polygon.representative_point()
            row, col = (int(part) for part in frame.map_to_pixel(point.x, point.y))
            assert continuations.grid.observed[row, col] == (room.flag is None)
            assert continuations.grid.free[row, col] >= (1 if room.flag is None else 1 / 6 - 1e-6)

    def test_shares_are_those_of_samples(self, model):
        grid = draw(make_floor(), model).grid
        layers = (grid.free, grid.wall, grid.outside)
        assert all(layer.min() >= 0 and layer.max() <= 1 for layer in layers)
        np.testing.assert_allclose(sum(layers), 1, atol=1e-6)
        # Six samples
        np.testing.assert_allclose(6 * grid.free, np.round(6 * grid.free), atol=1e-5)
        assert {*np.unique(grid.free[grid.observed])} <= {0, 1}
        assert 0 <= grid.free_probability.min() <= grid.free_probability.max() <= 1

    def test_the_same_seed_gives_the_same_plans(self, model):
        first, second, other = (draw(make_floor(), model, count=3, seed=seed) for seed in (4, 4, 5))
        assert first.plans == second.plans
        np.testing.assert_array_equal(first.grid.free, second.grid.free)
        assert first.plans != other.plans

    def test_no_room_is_where_the_map_is_known(self, model):
        floor = make_floor()
        # Free space beyond a wall, such as a yard seen through a window, in the way of the corridor
        cells = np.full((300, 500), -1, np.int8)
        grid = GridMap(cells, 0.1, (-10, -15, 0))
        rows, cols = (grid.map_to_pixel(*corner) for corner in ((21, 9), (30, -5)))
        window = np.s_[int(rows[0]) : int(cols[0]), int(rows[1]) : int(cols[1])]
        changed = cells.copy()
        changed[window] = 0
        yard = box(21, -5, 30, 9).buffer(-0.5)
        continuations = draw(floor, model, grid=GridMap(changed, 0.1, grid.origin))
        for plan in continuations.plans:
            assert all(room.polygon.intersection(yard).area < 1e-6 for room in plan.floor if room.flag)
        assert continuations.grid.resolution == pytest.approx(0.1)
        row, col = (int(part) for part in continuations.grid.frame.map_to_pixel(25, 2))
        assert (continuations.grid.free[row, col], continuations.grid.observed[row, col]) == (1, True)

    def test_a_model_without_areas_is_refused(self):
        floor = make_floor()
        with pytest.raises(ModelError, match="no areas"):
            draw(floor, small_model(), count=1)

    def test_another_floor_and_a_negative_seed_are_refused(self, model):
        floor = make_floor()
        prediction = pianta.predict(floor, model, count=1)
        others = replace(floor, rooms=(floor[1],), doors=())
        with pytest.raises(FloorError, match="rooms 2, 3, 4 of the prediction are not on the floor"):
            pianta.draw_continuations(prediction, others, model=model)
        with pytest.raises(FloorError, match="no door between rooms"):
            pianta.draw_continuations(prediction, replace(floor, doors=floor.doors[:3]), model=model)
        with pytest.raises(OptionError, match="seed is -1"):
            pianta.draw_continuations(prediction, floor, model=model, seed=-1)

    def test_a_floor_that_is_too_large_is_refused(self, model):
        rooms = (*make_floor().rooms, Room(9, box(5000, 0, 5010, 10), "GYM"))
        with pytest.raises(FloorError, match="250000 m² at most"):
            draw(replace(make_floor(), rooms=rooms, last_id=9), model, count=1)


class TestKnownPart:
    def test_of_an_open_corridor_only_what_is_near_the_door_is_seen(self):
        floor = make_whole_floor()
        truth = reveal_corridors(floor.graph(), SCHOOL, corridors=2)
        known_part = locate_known_part(read_explored_part(truth.part, SCHOOL), floor, truth)
        assert {room.id: room.partial for room in known_part.floor} == {1: False, 2: True, 3: False, 5: False}
        # Within 3 m of the door of 1 m, in the middle of 2 m: 3 m along it, and beside it less
        beside = 2 * (np.arcsin(0.5 / 3) * 9 / 2 + 0.5 * (9 - 0.25) ** 0.5 / 2)
        assert known_part.floor[2].polygon.area == pytest.approx(3 + beside, rel=0.01)
        assert known_part.ends == {}
        assert {door.rooms for door in known_part.floor.doors} == {(1, 2), (1, 3), (1, 5)}

    def test_a_room_that_is_seen_through_two_doors_is_one(self, model):
        floor = make_floor()
        rooms = tuple(replace(room, polygon=box(2, -7.2, 8, -6.2)) if room.id == 7 else room for room in floor)
        side = (Room(8, box(6.2, -6, 9, -0.2), "CLOSET"),)
        doors = (
            Door((7, 8), LineString([(6.8, -6.1), (7.7, -6.1)]), 0.9),
            Door((1, 8), LineString([(7, -0.1), (8, -0.1)]), 1.0),
        )
        floor = replace(floor, rooms=(*rooms, *side), doors=(*floor.doors, *doors), last_id=8)
        explored = read_explored_part(floor.graph(), SCHOOL)
        assert len(explored.doors) == 2
        known_part = locate_known_part(explored, floor)
        assert sorted(known_part.ids.values()) == [1, 7]
        assert len(known_part.ends) == 1
        for plan in draw(floor, model, count=3).plans:
            check_plan(plan.floor, floor)

    def test_plans_of_a_whole_floor_show_nothing_of_what_is_not_explored(self, model):
        floor = make_whole_floor()
        truth = reveal_corridors(floor.graph(), SCHOOL, corridors=2)
        prediction = pianta.predict(truth.part, model, count=3)
        for plan in pianta.draw_continuations(prediction, floor, model=model, truth=truth).plans:
            assert [room.id for room in plan.floor if not room.flag] == [1, 2, 3, 5]
            assert plan.floor[2].partial
            # No new id is that of a true room
            assert all(room.id > 5 for room in plan.floor if room.flag)


class TestSpaceFiller:
    def fill(self, picture: str, **options) -> SpaceFiller:
        cells = np.array([[{".": NO_ROOM, "#": BLOCKED, "0": 0}[cell] for cell in line] for line in picture.split()])
        defaults = {"areas": {0: 9.0, 1: 9.0}, "corridors": frozenset(), "thresholds": {}}
        return SpaceFiller(cells.astype(np.int32), **defaults | options, rng=np.random.default_rng(0))

    def test_a_room_fills_the_only_gap_beside_its_parent(self):
        filler = self.fill("####### ####### #000### #000### #000### #...### #...### #...### #######")
        assert filler.add_room(1, 0, 9.0, [])
        assert (filler.cells == 1).sum() == 9
        assert (filler.cells[5:8, 1:4] == 1).all()

    def test_a_room_without_space_is_not_added(self):
        filler = self.fill("##### #000# #..## #..## #####")
        assert not filler.add_room(1, 0, 9.0, [])
        assert not (filler.cells == 1).any()

    def test_a_room_behind_a_door_covers_the_cells_before_it(self):
        picture = "........ ........ ........ ........ ........ ........ ........ ........"
        threshold = np.zeros((8, 8), bool)
        threshold[3, 2:5] = True
        filler = self.fill(picture, thresholds={1: threshold})
        assert filler.add_room(1, None, 9.0, [])
        assert (filler.cells[threshold] == 1).all()

    def test_no_cells_of_others_change(self):
        rng = np.random.default_rng(2)
        cells = np.where(rng.random((40, 40)) < 0.03, BLOCKED, NO_ROOM).astype(np.int32)
        cells[18:22, 10:30] = 0
        before = cells.copy()
        areas = dict.fromkeys(range(1, 8), 30.0)
        filler = SpaceFiller(cells, areas, frozenset({1}), {}, rng)
        assert sum(filler.add_room(node, 0, 30.0, []) for node in areas) >= 5
        changed = filler.cells != before
        assert (before[changed] == NO_ROOM).all()
        contacts = find_contacts(filler.cells)
        assert all(contacts[0, node].length >= 3 for node in areas if (filler.cells == node).any())


class TestGeometry:
    def test_passages_are_in_the_middle_of_walls(self):
        cells = np.array([[0, 0, 0, -1], [1, 1, 1, -1]], np.int32)
        assert find_contacts(cells) == {(0, 1): Contact(3, 0, 0, is_level=True)}
        # Cells of 0.5 m, two rows: the wall of 1.5 m is 0.5 m above the lower side
        line = _locate_passage(Contact(3, 0, 0, is_level=True), 2)
        assert line.equals_exact(LineString([(0.3, 0.5), (1.2, 0.5)]), 1e-9)
        upright = np.array([[0, 1], [0, 1], [0, 1]], np.int32)
        assert find_contacts(upright) == {(0, 1): Contact(3, 0, 0, is_level=False)}
        assert _locate_passage(Contact(3, 0, 0, is_level=False), 3).bounds == pytest.approx((0.5, 0.3, 0.5, 1.2))

    def test_the_frame_is_along_the_walls(self):
        shape = affinity.rotate(box(0, 0, 30, 10), 25, (0, 0))
        frame = make_frame([shape], 2.0)
        assert frame.origin[2] == pytest.approx(25 * pi / 180, abs=1e-6)
        assert frame.shape == (28, 68)
        x, y = frame.pixel_to_map(28, 0)
        angle = frame.origin[2]
        assert (x, y) == pytest.approx((-2 * cos(angle) + 2 * sin(angle), -2 * sin(angle) - 2 * cos(angle)), abs=1e-6)

    def test_the_threshold_of_a_door_is_on_its_free_side(self):
        frame = GridMap(np.zeros((8, 8), np.int8), 0.5)
        free = np.zeros((8, 8), bool)
        # Space above y = 2
        free[:4] = True
        mask = find_threshold(LineString([(1.25, 2), (2.25, 2)]), free, frame)
        assert [*zip(*np.nonzero(mask), strict=True)] == [(3, 2), (3, 3), (3, 4)]
        assert not find_threshold(LineString([(1, 2), (2, 2)]), np.zeros((8, 8), bool), frame).any()

    def test_features_of_cells(self):
        shares = np.full((3, 80), 0.5)
        unknown = np.ones((3, 80))
        unknown[:, 0] = 0
        openings = np.zeros((3, 80), bool)
        features = describe_cells(shares, unknown, openings, cell=1.0)
        assert features.shape == (3, 80, 4)
        np.testing.assert_allclose(features[1, 20, :2], 0, atol=1e-6)
        assert features[1, 20, 2] == pytest.approx(log(21))
        assert features[1, 79, 2] == features[1, 0, 3] == pytest.approx(log(41))
        certain = describe_cells(np.ones((3, 3)), np.ones((3, 3)), openings[:, :3], cell=1.0)
        assert certain[1, 1, 0] == pytest.approx(log((1 + LEAST_SHARE) / LEAST_SHARE))
        assert (find_free_probability(features) > 0).all()

    def test_more_samples_that_are_free_make_a_cell_more_probable(self):
        unknown, openings = np.ones((40, 40)), np.zeros((40, 40), bool)
        openings[20, 20] = True
        low, high = (
            find_free_probability(describe_cells(np.full((40, 40), share), unknown, openings, cell=0.5))
            for share in (0.1, 0.9)
        )
        assert (low < high).all()


class TestChooseTypical:
    def test_masks_stand_for_their_groups(self):
        left, right, none = (np.array([row], bool) for row in ((1, 1, 1, 0, 0, 0), (0, 0, 0, 1, 1, 1), (0,) * 6))
        nearly = np.array([[1, 1, 0, 0, 0, 0]], bool)
        assert choose_typical([left, nearly, right, left, right], 2) == {0: 0.6, 2: 0.4}
        assert choose_typical([none, none], 3) == {0: 1.0, 1: 0.0}


class TestMoveToMap:
    def test_blocks_of_the_map_have_its_frame(self):
        # Two samples' cells of 0.1 m right of a map of 2 × 2 cells of 0.05 m, one of them occupied
        free = np.array([[1, 0.5, 0.25]], np.float32)
        zero = np.zeros_like(free)
        grid = ShareGrid(free, zero, 1 - free, free.copy(), np.zeros((1, 3), bool), 0.1, (1.0, 2.0, 0.0))
        moved = move_to_map(grid, GridMap(np.array([[0, 100], [0, -1]]), 0.05, (1.0, 2.0, 0.0)))
        assert (moved.resolution, moved.origin) == (0.1, (1.0, 2.0, 0.0))
        np.testing.assert_allclose(moved.free, [[0, 0.5, 0.25]])
        np.testing.assert_allclose(moved.wall, [[1, 0, 0]])
        np.testing.assert_allclose(moved.outside, [[0, 0.5, 0.75]])
        assert moved.observed.tolist() == [[True, False, False]]

    def test_the_grid_grows_by_whole_blocks_on_all_sides(self):
        free = np.ones((2, 2), np.float32)
        yaw = 0.3
        corner = affinity.rotate(Point(-0.1, -0.1), yaw, (0, 0), use_radians=True)
        grid = ShareGrid(free, 0 * free, 0 * free, free, np.zeros((2, 2), bool), 0.1, (corner.x, corner.y, yaw))
        observed_map = GridMap(np.full((3, 3), -1, np.int8), 0.05, (0.0, 0.0, yaw))
        moved = move_to_map(grid, observed_map)
        # The map has three cells, a block and a half; the grid begins one block before it
        assert moved.free.shape == (3, 3)
        assert moved.origin == pytest.approx((corner.x, corner.y, yaw))
        np.testing.assert_allclose(moved.free, [[0, 0, 0], [1, 1, 0], [1, 1, 0]])
        np.testing.assert_allclose(moved.outside, 1 - moved.free)


PLAN_FILES = {"plan-1.geojson", "plan-2.geojson", "plan-3.geojson", "plans.png", "shares.npz"}


def test_an_outline_in_millimetres_has_no_neck_that_would_close():
    """Two boxes of 4 m² and 6 m², joined by a neck of 0.4 mm."""
    shape = shapely.union_all([box(0, 0, 2, 2), box(1, 1, 4, 1.0004), box(3, 0, 6, 2)])
    outline = round_outline(shape)
    assert outline.is_valid
    assert outline.equals(box(3, 0, 6, 2))


class TestCommand:
    @pytest.fixture
    def model_file(self, model, tmp_path):
        save_type_model(model, tmp_path / "school.json")
        return tmp_path / "school.json"

    @pytest.fixture
    def explored(self, tmp_path):
        """A folder as `pianta read` writes it."""
        folder = tmp_path / "explored"
        folder.mkdir()
        save_floor(make_floor(), folder / "floor.geojson")
        GridMap(np.full((200, 300), -1, np.int8), 0.05, (-2, -2, 0.2)).save(folder / "grid.npz")
        return folder

    def test_writes_plans_and_shares_and_removes_old_ones(self, explored, model_file, tmp_path):
        arguments = ("predict", explored, model_file, "-n", 4, "-o", tmp_path / "out")
        outcome = run_pianta(*arguments, "--plans")
        assert (outcome.code, outcome.err) == (0, "")
        assert "plans: space for" in outcome.out
        files = list_files(tmp_path / "out")
        assert files.keys() >= PLAN_FILES
        content = json.loads(files["prediction.json"])["plans"]
        assert [plan["file"] for plan in content["floors"]] == sorted(name for name in PLAN_FILES if "geojson" in name)
        assert sum(plan["share"] for plan in content["floors"]) == pytest.approx(1)
        for plan in content["floors"]:
            floor = read_floor(tmp_path / "out" / plan["file"])
            check_plan(floor, make_floor())
            assert 1 <= plan["sample"] <= 4
        with np.load(tmp_path / "out" / "shares.npz") as arrays:
            assert {*arrays} == {"free", "wall", "outside", "free_probability", "observed", "resolution", "origin"}
            assert content["grid"]["shape"] == [*arrays["free"].shape]
            assert content["grid"]["origin"] == arrays["origin"].tolist()
            assert (arrays["resolution"], arrays["origin"][2]) == (0.1, 0.2)
        assert run_pianta(*arguments, "--plans", "-q").code == 0
        assert list_files(tmp_path / "out") == files
        assert run_pianta(*arguments, "-q").code == 0
        without = list_files(tmp_path / "out")
        assert without.keys() == files.keys() - PLAN_FILES
        assert "plans" not in json.loads(without["prediction.json"])

    def test_a_whole_floor_is_explored_and_drawn(self, model_file, tmp_path):
        save_floor(make_whole_floor(), tmp_path / "school.geojson")
        arguments = ("school.geojson", "school.json", "--explored", 2, "-n", 2, "--plans", "-q", "-o", tmp_path / "out")
        outcome = run_pianta(
            "predict", *(tmp_path / each if str(each).startswith("school") else each for each in arguments)
        )
        assert (outcome.code, outcome.err) == (0, "")
        plan = read_floor(tmp_path / "out" / "plan-1.geojson")
        assert 4 not in plan
        assert plan[2].partial

    def test_plans_need_a_folder_and_outlines(self, explored, model_file, tmp_path):
        outcome = run_pianta("predict", explored, model_file, "--plans")
        assert outcome.code == 2
        assert "-o" in outcome.err
        graph = make_floor().graph()
        graph.graph.clear()
        save_graph(graph, tmp_path / "graph.json")
        outcome = run_pianta("predict", tmp_path / "graph.json", model_file, "-n", 2, "--plans", "-o", tmp_path / "out")
        assert outcome.code == 2
        assert "has no outlines" in outcome.err
        assert "--plans" in outcome.err
        assert not (tmp_path / "out").exists()

    def test_a_floor_that_is_explored_completely_is_refused(self, model_file, tmp_path):
        save_floor(make_whole_floor(), tmp_path / "complete.geojson")
        outcome = run_pianta("predict", tmp_path / "complete.geojson", model_file, "--plans", "-o", tmp_path / "out")
        assert outcome.code == 2
        assert "nothing to predict" in outcome.err
        assert not (tmp_path / "out").exists()

    def test_several_floors_are_drawn_in_their_folders(self, explored, model_file, tmp_path):
        (tmp_path / "floors" / "two").mkdir(parents=True)
        explored.rename(tmp_path / "floors" / "one")
        (tmp_path / "floors" / "two" / "floor.geojson").write_text("damaged")
        arguments = ("predict", tmp_path / "floors", model_file, "-n", 3, "-q", "-o", tmp_path / "out")
        assert run_pianta(*arguments, "--plans").code == 1
        files = list_files(tmp_path / "out" / "one")
        assert files.keys() >= PLAN_FILES
        # Predictions without plans are other results
        assert run_pianta(*arguments).code == 1
        assert not PLAN_FILES.intersection(list_files(tmp_path / "out" / "one"))
