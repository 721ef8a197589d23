"""Lessons of the network of map regions: their rooms, walls, doors and furniture are those of the floor."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import LineString, box

import pianta
from pianta.layout.structure.evidence import DOOR, FLOOR, FURNITURE, OUTSIDE, WALL

pytest.importorskip("numba", reason="pianta[sim] is not installed")
sys.path.append(str(Path(__file__).parents[1] / "training"))
worlds = import_module("lesson_worlds")
lessons = import_module("map_lessons")

# Two rooms of 4 by 5 m with a door of 1 m in the wall between them, and one of 3 by 5 m without a door.
FLOOR_OF_THREE = pianta.Floor(
    (pianta.Room(5, box(0, 0, 4, 5)), pianta.Room(7, box(4, 0, 8, 5)), pianta.Room(9, box(8, 0, 11, 5))),
    (pianta.Door((5, 7), LineString([(4, 2), (4, 3)]), 1.0),),
)
# Fine cells of a metre, and where the floor begins.
PER_METRE = 20
START = 3 * PER_METRE


@pytest.fixture
def plain(monkeypatch):
    """The floor as it is: not turned, empty, with walls of 0.2 m, without leaves, wide openings and glass."""
    monkeypatch.setattr(worlds, "transform_floor", lambda floor, scale, rng: shift_floor(floor))
    for name, value in (
        ("BOARD_SHARE", 0.0),
        ("WALL_THICKNESSES", (0.2, 0.2)),
        ("WIDE_SHARE", 0.0),
        ("LEAF_SHARE", 0.0),
        ("DENSITY_SHARES", (1.0, 0.0, 0.0)),
        ("OPAQUE_SHARE", 1.0),
    ):
        monkeypatch.setattr(worlds, name, value)
    return monkeypatch


def shift_floor(floor: pianta.Floor) -> pianta.Floor:
    """The floor with its corner at MARGIN, where transform_floor puts it."""
    rooms = tuple(pianta.Room(room.id, shift(room.polygon)) for room in floor.rooms)
    return pianta.Floor(rooms, tuple(pianta.Door(door.rooms, shift(door.line), door.width) for door in floor.doors))


def shift(shape: Any) -> Any:
    return worlds.affinity.translate(shape, worlds.MARGIN, worlds.MARGIN)


def build(seed: int = 0) -> Any:
    return worlds.build_world(FLOOR_OF_THREE, 1.0, np.random.default_rng(seed))


def cell(image: Any, x: float, y: float) -> int:
    """The value at a point of the floor, metres."""
    return int(image[START + int(y * PER_METRE), START + int(x * PER_METRE)])


def to_lesson(world: Any, cells: Any) -> Any:
    return lessons.to_lesson(cells, world.classes, world.rooms, coarse=False)


def test_walls_are_where_rooms_meet_and_around_them(plain):
    world = build()
    assert [cell(world.classes, x, 1) for x in (-0.05, 2, 3.95, 4.05, 6, 8, 9.5, 11.05)] == [
        *(WALL, FLOOR, WALL, WALL, FLOOR, WALL, FLOOR, WALL)
    ]
    assert [cell(world.rooms, x, 1) for x in (-0.05, 2, 4, 6, 8, 9.5, 11.05)] == [0, 1, 0, 2, 0, 3, 0]
    assert cell(world.classes, -0.5, 1) == OUTSIDE
    assert cell(world.classes, 2, 5.05) == WALL
    # 0.2 m, and a cell for the border.
    row = world.classes[START + PER_METRE, START + 2 * PER_METRE : START + 6 * PER_METRE]
    assert 0.2 <= (row == WALL).sum() / PER_METRE <= 0.3
    assert np.array_equal(world.stops, world.classes == WALL)


def test_a_door_joins_two_rooms(plain):
    world = build()
    rows, cols = np.nonzero(world.classes == DOOR)
    assert not world.stops[world.classes == DOOR].any()
    # It is 1 m wide, from y = 2 to 3, and as deep as the wall.
    assert (rows.max() - rows.min() + 1) / PER_METRE == pytest.approx(1.0, abs=0.1)
    assert cell(world.classes, 4, 1.8) == cell(world.classes, 4, 3.2) == WALL
    row = world.rooms[START + int(2.5 * PER_METRE)]
    assert (row[cols.min() - 1], row[cols.max() + 1]) == (1, 2)


@pytest.mark.parametrize("one_sided", [0.0, 1.0])
def test_a_wide_opening_is_in_the_wall_of_its_rooms_with_a_stub_on_both_sides_or_on_one(plain, one_sided):
    """The wall is 5 m long; a stub has 0.15 m or more, of which the edge of a cell may take 0.05 m."""
    plain.setattr(worlds, "WIDE_SHARE", 1e6)
    plain.setattr(worlds, "ONE_SIDED_SHARE", one_sided)
    widths = []
    for seed in range(5):
        rows, cols = np.nonzero(build(seed).classes == DOOR)
        stubs = [(rows.min() - START) / PER_METRE, 5 - (rows.max() + 1 - START) / PER_METRE]
        assert sum(stub >= 0.1 for stub in stubs) >= (1 if one_sided else 2)
        assert np.abs(cols - START - 4 * PER_METRE).max() <= 0.3 * PER_METRE
        widths.append((rows.max() - rows.min() + 1) / PER_METRE)
    assert min(widths) >= 1.1
    assert len(set(widths)) > 1


def test_some_walls_are_boards_of_one_cell(plain):
    """The wall between the two rooms, at x = 4 m."""
    plain.setattr(worlds, "BOARD_SHARE", 1.0)
    middle = START + int(2.5 * PER_METRE)
    row = next(row for row in (middle - 20, middle + 20) if not (build().classes[row] == DOOR).any())
    inner = build().classes[row, START + 2 * PER_METRE : START + 6 * PER_METRE]
    assert np.count_nonzero(inner == WALL) == 1


def test_a_shut_leaf_stops_beams_in_its_door(plain):
    for name in ("LEAF_SHARE", "SHUT_SHARE"):
        plain.setattr(worlds, name, 1.0)
    world = build()
    rows = np.flatnonzero((world.classes == DOOR).any(axis=1))[1:-1]
    middle = slice(START + 4 * PER_METRE - 4, START + 4 * PER_METRE + 4)
    assert world.stops[rows, middle].any(axis=1).all()


def test_furniture_stands_in_rooms(plain):
    plain.setattr(worlds, "DENSITY_SHARES", (0.0, 0.0, 1.0))
    world = build()
    furniture = world.classes == FURNITURE
    assert furniture.any()
    assert world.stops[furniture].all()
    assert world.rooms[furniture].all()
    assert np.isin(world.classes[world.rooms > 0], (FLOOR, FURNITURE)).all()


def test_annotated_floors_are_scaled_with_doors_of_usual_width():
    for seed in range(8):
        floor = worlds.transform_floor(FLOOR_OF_THREE, 2.0, np.random.default_rng(seed))
        assert sum(room.polygon.area for room in floor.rooms) == pytest.approx(4 * 55)
        assert 0.7 <= floor.doors[0].line.length <= 1.1
        assert np.allclose(worlds.shapely.total_bounds([room.polygon for room in floor.rooms])[:2], worlds.MARGIN)


def test_a_lesson_of_a_drawing(plain):
    world = build()
    plain.setattr(lessons, "DRAWING_SHARE", 1.0)
    lesson = to_lesson(world, lessons.map_world(world, np.random.default_rng(0)))
    shape = tuple(side // 2 for side in world.rooms.shape)
    assert {image.shape for image in lesson.values()} == {shape}
    assert set(np.unique(lesson["classes"])) == {OUTSIDE, FLOOR, WALL, DOOR}
    assert (lesson["free"] + lesson["occupied"]).max() == 4
    assert (lesson["occupied"][(lesson["classes"] == FLOOR)] <= 2).all()
    # Rooms of 4 by 5 m less 0.1 m of wall, or 0.25 m at most where cells are rounded, on each side.
    for number, width in ((1, 4), (2, 4), (3, 3)):
        assert (width - 0.5) * 4.5 <= (lesson["rooms"] == number).sum() / 100 <= (width - 0.2) * 4.8
    assert not lesson["rooms"][np.isin(lesson["classes"], (OUTSIDE, WALL, DOOR))].any()


def test_an_unobserved_room_is_outside(plain):
    world = build()
    cells = np.where(world.classes == FLOOR, lessons.FREE_CELL, lessons.UNKNOWN_CELL).astype(np.uint8)
    cells[:, START + 8 * PER_METRE :] = lessons.UNKNOWN_CELL
    lesson = to_lesson(world, cells)
    assert set(np.unique(lesson["rooms"])) == {0, 1, 2}
    col = START // 2 + 95
    assert (lesson["classes"][START // 2 + 10 : START // 2 + 40, col] == OUTSIDE).all()
    # The wall behind the unobserved room does not count.
    right_wall = lesson["classes"][START // 2 + 25] == WALL
    assert right_wall.sum() > 6
    assert not lesson["counts"][START // 2 + 25, np.flatnonzero(right_wall)[-1]]
    assert lesson["counts"][START // 2 + 25, START // 2 + 20]


def test_shares_of_cells():
    cells = np.array([[1, 1, 2, 1], [1, 0, 1, 1]], np.uint8)
    rooms = np.ones((2, 4), np.int32)
    classes = np.full((2, 4), FLOOR, np.uint8)
    fine = lessons.to_lesson(cells, classes, rooms, coarse=False)
    assert (fine["free"].tolist(), fine["occupied"].tolist()) == ([[3, 3]], [[0, 1]])
    coarse = lessons.to_lesson(cells, classes, rooms, coarse=True)
    assert (coarse["free"].tolist(), coarse["occupied"].tolist()) == ([[4, 0]], [[0, 4]])


def test_a_thin_wall_is_not_lost():
    classes = np.full((2, 4), FLOOR, np.uint8)
    classes[:, 1] = WALL
    lesson = lessons.to_lesson(np.ones((2, 4), np.uint8), classes, np.ones((2, 4), np.int32), coarse=False)
    assert lesson["classes"].tolist() == [[WALL, FLOOR]]
    assert lesson["rooms"].tolist() == [[0, 1]]


@pytest.mark.slow
def test_a_beam_ends_at_the_wall_and_passes_glass():
    stops = np.zeros((60, 60), bool)
    stops[:, 40] = True
    poses = np.tile([30.5, 20.5, 0.0, 0.0], (20, 1))
    lidar = lessons.Lidar(beams=720, reach=100.0, noise=0.0, dropout=0.0, passing=1.0)
    passes, hits = lessons.scan(stops, np.zeros_like(stops), poses, lidar, 1)
    assert set(np.nonzero(hits)[1]) <= {40, 41}
    assert hits[30, 40] > 0
    assert passes[30, 30] > 0
    assert not passes[:, 42:].any()
    glass_passes, _ = lessons.scan(stops, stops, poses, lidar, 1)
    assert glass_passes[30, 50] > 0


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_lesson_of_a_robot(seed):
    lesson = None
    rng = np.random.default_rng(seed)
    while lesson is None:
        lesson = lessons.make_lesson([FLOOR_OF_THREE], rng)
    free, occupied = lesson["free"], lesson["occupied"]
    assert set(np.unique(free + occupied)) <= set(range(5))
    assert set(np.unique(lesson["classes"])) <= {OUTSIDE, FLOOR, WALL, DOOR, FURNITURE}
    assert np.array_equal(lesson["rooms"] > 0, np.isin(lesson["classes"], (FLOOR, FURNITURE)))
    # Cells are free in rooms rather than in walls, and each room was observed.
    assert (free[lesson["classes"] == FLOOR] > 0).mean() > (free[lesson["classes"] == WALL] > 0).mean()
    for number in np.unique(lesson["rooms"])[1:]:
        assert free[lesson["rooms"] == number].any()
