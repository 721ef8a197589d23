"""The probability of rooms and doors to be right: measures by hand, and what every output has."""

import json
from collections.abc import Sequence
from dataclasses import replace
from math import log

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from shapely import LineString, box

import pianta
from pianta.floor import Door, Room
from pianta.gridmap import GridMap
from pianta.io.floors import read_floor
from pianta.layout._working_grid import WorkingGrid
from pianta.layout.structure import confidence
from pianta.layout.structure.confidence import (
    DOOR_MEASURES,
    ROOM_MEASURES,
    LogisticModel,
    measure_doors,
    measure_least_rooms,
    measure_rooms,
    rate_regions,
    read_confidence_model,
)
from pianta.layout.structure.evidence import CELL, FLOOR, WALL, Evidence
from tests.command_line import run_pianta
from tests.drawn_evidence import make_classes, make_evidence, set_class

SIDE = 20
LABELS = np.array([[1] * 6 + [2] * 6], np.int32)
TWO_ROOMS = [Room(1, box(0, 0, 2, 1)), Room(2, box(2, 0, 3, 1))]


def name_measures(row: np.ndarray, names: tuple[str, ...]) -> dict[str, float]:
    return dict(zip(names, row.tolist(), strict=True))


def list_probabilities(rooms: Sequence[Room], doors: Sequence[Door]) -> list[float | None]:
    return [room.probability for room in rooms] + [door.probability for door in doors]


def measure_room(labels: np.ndarray, rooms: list[Room], *, affinity: float) -> dict[str, float]:
    """The measures of the first room."""
    return name_measures(
        measure_rooms(rooms, labels, make_evidence(make_classes(labels.shape), affinity=affinity))[0], ROOM_MEASURES
    )


class TestRooms:
    def test_two_rooms_of_six_cells(self):
        """Pairs begin at cells 0, 2, …: 0 and 4 are in room 1, 2 and 6, 4 and 8, and 0 and 10 in both."""
        measures = measure_room(LABELS, TWO_ROOMS, affinity=0.9)
        expected = {
            "leak": 3 * 0.9 / (0.9 + 3 * 0.9 + 1),
            "weakest border": log(9),
            "division inside": 0.1 / 2,
            "floor": 1.0,
            "log area": log(2),
            "convexity": 1.0,
        }
        assert measures == pytest.approx(expected, rel=1e-5)

    def test_a_room_alone_has_no_border(self):
        measures = measure_room(np.ones((1, 12), np.int32), TWO_ROOMS[:1], affinity=0.9)
        assert measures["leak"] == 0
        assert measures["weakest border"] == pytest.approx(log(0.02 / 0.98))

    def test_a_contact_of_two_pairs_is_no_border(self):
        """Cells 2 and 6, and 4 and 8, and none further apart."""
        measures = measure_room(LABELS[:, :10], TWO_ROOMS, affinity=0.9)
        assert measures["weakest border"] == pytest.approx(log(0.02 / 0.98))
        assert measures["leak"] > 0

    def test_a_room_without_cells_of_the_network(self):
        """A label on the working grid that no middle of a coarser cell is in."""
        measures = measure_room(np.zeros((1, 12), np.int32) + (np.arange(12) == 0), TWO_ROOMS[:1], affinity=0.9)
        assert measures["division inside"] == 0
        assert all(np.isfinite([*measures.values()]))

    def test_an_l_covers_a_part_of_its_hull(self):
        """A square of 2 m without one of 1 m: 3 of 3.5 m²."""
        room = Room(1, box(0, 0, 2, 2).difference(box(1, 1, 2, 2)))
        measures = measure_room(LABELS, [room], affinity=0.9)
        assert measures["convexity"] == pytest.approx(3 / 3.5)

    def test_another_kind_of_floor_is_less_probable(self):
        classes = make_classes(LABELS.shape)
        classes[FLOOR, 0, :3] = 0.5
        row = measure_rooms(TWO_ROOMS, LABELS, make_evidence(classes))[0]
        assert name_measures(row, ROOM_MEASURES)["floor"] == pytest.approx((3 * 0.5 + 3) / 6)


def make_door(start: tuple[float, float], end: tuple[float, float], width: float = 0.9) -> Door:
    """A door between the middles of two cells, row and col, of a map of SIDE cells."""
    points = [((col + 0.5) * CELL, (SIDE - row - 0.5) * CELL) for row, col in (start, end)]
    return Door((1, 2), LineString(points), width)


def make_door_map() -> tuple[WorkingGrid, Evidence]:
    """Column 10 is a wall, with a doorway in rows 5 to 14; cells before and behind it are in two rooms."""
    classes = make_classes((SIDE, SIDE))
    column = np.zeros((SIDE, SIDE), bool)
    column[:, 10] = True
    doorway = column.copy()
    doorway[:5] = doorway[15:] = False
    set_class(classes, column, wall=1.0)
    set_class(classes, doorway, door=0.75, wall=0.25)
    evidence = make_evidence(classes)
    evidence.affinities[0] = 0.1
    grid = GridMap(np.zeros((SIDE, SIDE), np.int8), CELL)
    return WorkingGrid(grid.free, CELL, np.eye(3), grid), evidence


def measure_door(door: Door) -> dict[str, float]:
    (row,) = measure_doors([door], *make_door_map())
    return name_measures(row, DOOR_MEASURES[:-1])


class TestDoors:
    def test_a_door_in_its_doorway(self):
        expected = {"door": 0.75, "wall": 0.25, "across": log(0.1 / 0.9), "jambs": 1.0, "unusual width": 0.0}
        assert measure_door(make_door((5, 10), (14, 10))) == pytest.approx(expected, rel=1e-5)
        # The direction of the line does not matter
        assert measure_door(make_door((14, 10), (5, 10))) == pytest.approx(expected, rel=1e-5)

    def test_a_line_in_a_room(self):
        """It runs along a row, so that cells of other rows are before and behind it."""
        measures = measure_door(make_door((10, 1), (10, 5), width=1.8))
        assert measures["door"] == measures["wall"] == measures["jambs"] == 0
        assert measures["across"] == pytest.approx(log(0.95 / 0.05), rel=1e-5)
        assert measures["unusual width"] == pytest.approx(log(2))

    def test_the_weaker_jamb_counts(self):
        """Beyond row 18 is the end of the map."""
        assert measure_door(make_door((5, 10), (19, 10)))["jambs"] == 0
        assert measure_door(make_door((5, 10), (17, 10)))["jambs"] == 1

    def test_a_closed_slit_has_a_least_width(self):
        assert measure_door(make_door((5, 10), (6, 10), width=0.0))["unusual width"] == pytest.approx(log(9))

    def test_the_less_probable_room_counts(self):
        doors = [make_door((5, 10), (14, 10)), Door((2, None), LineString([(0, 0), (0, 1)]), 1.0)]
        assert measure_least_rooms(doors, {1: 0.5, 2: 0.8}).tolist() == [0, pytest.approx(log(4))]

    def test_no_doors(self):
        assert measure_doors([], *make_door_map()).shape == (0, len(DOOR_MEASURES) - 1)
        assert measure_least_rooms([], {}).shape == (0,)


def test_a_logistic_model_by_hand():
    """Log odds of 2 · (5 - 3) / 4 - 1 = 0, and 2 · 4 - 1 = 7 for a measure that is limited to 4 spreads."""
    model = LogisticModel(np.array([3.0]), np.array([4.0]), np.array([2.0]), -1.0)
    assert model.predict(np.array([[5.0], [1000.0]])) == pytest.approx([0.5, 1 / (1 + np.exp(-7))])


@given(arrays(float, (3, len(DOOR_MEASURES)), elements=st.floats(-1e9, 1e9)))
def test_probabilities_are_between_0_and_1(measures):
    for model in (read_confidence_model().doors, read_confidence_model().rooms):
        chances = model.predict(measures[:, : len(model.weights)])
        assert ((chances > 0) & (chances < 1)).all()


@given(st.floats(0, 1), st.floats(0, 1))
def test_rooms_and_doors_are_rated_for_any_evidence(affinity, wall):
    classes = make_classes((SIDE, SIDE))
    classes[FLOOR], classes[WALL] = 1 - wall, wall
    working_grid, _ = make_door_map()
    labels = np.repeat([1, 2], SIDE // 2)[None].repeat(SIDE, axis=0).astype(np.int32)
    doors = [make_door((5, 10), (14, 10))]
    evidence = make_evidence(classes, affinity=affinity)
    rooms, rated_doors = rate_regions(TWO_ROOMS, doors, labels, working_grid, evidence)
    for probability in list_probabilities(rooms, rated_doors):
        assert probability is not None
        assert 0 <= probability <= 1
    assert [replace(room, probability=None) for room in rooms] == TWO_ROOMS


def test_what_the_network_sees_decides():
    """A room that hangs together and is parted from its neighbour is more probable; so is a door in a doorway."""
    model = read_confidence_model()
    joined, divided = (
        measure_rooms(TWO_ROOMS, LABELS, make_evidence(make_classes(LABELS.shape), affinity=affinity))
        for affinity in (0.02, 0.98)
    )
    joined[:, ROOM_MEASURES.index("division inside")] = 0.01
    assert (model.rooms.predict(joined) > model.rooms.predict(divided)).all()
    doorway, floor = (
        [*measure_doors([door], *make_door_map())[0], 0.0]
        for door in (make_door((5, 10), (14, 10)), make_door((10, 1), (10, 5)))
    )
    chances = model.doors.predict(np.array([doorway, floor]))
    assert chances[0] > chances[1]


@pytest.fixture(scope="module")
def reading(tmp_path_factory):
    """The folder of the files of `pianta read` for a synthetic map."""
    folder = tmp_path_factory.mktemp("confidence")
    _, grid = pianta.make_world("hall", seed=1)
    grid.save(folder / "map.yaml")
    code, _, _ = run_pianta("read", folder / "map.yaml", "-o", folder / "out", "--no-labels")
    assert code == 0
    return folder / "out"


def test_every_file_has_probabilities(reading):
    floor = read_floor(reading / "floor.geojson")
    assert floor.rooms
    assert floor.doors
    assert None not in list_probabilities(floor.rooms, floor.doors)
    assert {piece.probability for piece in floor.furniture} <= {None}
    nodes = json.loads((reading / "graph.json").read_text(encoding="utf-8"))["nodes"]
    assert [node["probability"] for node in nodes] == [room.probability for room in floor.rooms]
    assert floor.graph().nodes[1]["probability"] == floor.rooms[0].probability
    features = json.loads((reading / "floor.geojson").read_text(encoding="utf-8"))["features"]
    assert all(
        0 <= feature["properties"]["probability"] <= 1
        for feature in features
        if feature["properties"]["class"] in {"room", "door"}
    )


def test_entrances_are_rated_too():
    _, grid = pianta.make_world("corridor", glass_spray=True)
    floor = pianta.reconstruct(grid, predict_partial=False)
    assert None not in [door.probability for door in floor.doors]


def test_other_methods_have_no_probabilities():
    _, grid = pianta.make_world("hall", seed=1)
    floor = pianta.reconstruct(grid, method="morphological")
    assert {room.probability for room in floor.rooms} == {None}


def test_a_clean_map_is_rather_certain():
    """All rooms of a clean synthetic map are right, so the mean probability is high."""
    true_floor, grid = pianta.make_world("corridor")
    floor = pianta.reconstruct(grid)
    assert len(floor) == len(true_floor)
    assert np.mean([room.probability for room in floor.rooms]) > 0.85
    assert np.mean([door.probability for door in floor.doors]) > 0.85


def test_the_model_has_all_measures():
    content = json.loads(confidence.MODEL_FILE.read_text(encoding="utf-8"))
    assert tuple(content["rooms"]["measures"]) == ROOM_MEASURES
    assert tuple(content["doors"]["measures"]) == DOOR_MEASURES
