"""Shapes of rooms that models of building types keep, and what drawn buildings take from them."""

from dataclasses import replace

import networkx as nx
import numpy as np
import pytest
from shapely import LineString, box

import pianta
from pianta.generation.drawing.blocks import NO_ROOM
from pianta.generation.drawing.losses import (
    LOSS_BY_DARKNESS,
    LOSS_BY_DOOR,
    LOSS_BY_OPEN_SIDES,
    measure_gaps,
    measure_outer_walls,
)
from pianta.generation.drawing.programme import USUAL_DOOR, find_opening_shares, find_window_needs, list_door_widths
from pianta.generation.room_shapes import ROOM_MEASURES, describe_shapes, list_measures
from pianta.generation.type_model import learn_type
from pianta.generation.type_model_file import read_type_model
from pianta.graphs.metrics import find_corridors
from pianta.labels import SCHOOL
from tests.generated_types import join_wings, make_schools

# Nine rooms of 5 m by 5 m; that in the middle has no outer wall
NINE = pianta.Floor(
    tuple(
        pianta.Room(number + 1, box(x, y, x + 5, y + 5), label="CLASSROOM")
        for number, (x, y) in enumerate((5 * (number % 3), 5 * (number // 3)) for number in range(9))
    ),
    doors=tuple(
        pianta.Door((one, one + 1), LineString([(5 * x, 5 * y + 1), (5 * x, 5 * y + 1.8)]), 0.8)
        for one, x, y in ((1, 1, 0), (2, 2, 0), (4, 1, 1), (5, 2, 1), (7, 1, 2), (8, 2, 2))
    ),
)


def test_aspects_and_outer_walls():
    rooms = dict(describe_shapes(NINE).nodes(data=True))
    assert [rooms[room]["aspect"] for room in rooms] == pytest.approx([1.0] * 9)
    assert rooms[5]["outer_wall"] == 0
    assert rooms[2]["outer_wall"] == pytest.approx(5, abs=1)
    assert rooms[1]["outer_wall"] == pytest.approx(10, abs=1)
    long = describe_shapes(pianta.Floor((pianta.Room(7, box(0, 0, 12, 3)),)))
    assert (long.nodes[7]["aspect"], long.nodes[7]["outer_wall"]) == pytest.approx((4.0, 30.0))
    assert len(describe_shapes(pianta.Floor(()))) == 0


def test_openings():
    opening = pianta.Door((3, 6), LineString([(11, 5), (14, 5)]), 3.0, kind="opening")
    graph = describe_shapes(replace(NINE, doors=(*NINE.doors, opening)))
    assert [(one, other) for one, other, is_opening in graph.edges(data="opening") if is_opening] == [(3, 6)]


def test_what_is_no_measure_is_unknown():
    measures = {"area": 3, "aspect": 0.5, "outer_wall": float("nan"), "other": 1.0}
    assert list_measures(measures, ROOM_MEASURES) == {"area": 3.0}
    assert list_measures({"area": np.float64(2.5)}, ROOM_MEASURES) == {"area": 2.5}
    assert list_measures({"area": True, "aspect": "2", "outer_wall": 0}, ROOM_MEASURES) == {"outer_wall": 0.0}


def test_a_model_keeps_them(tmp_path):
    schools = make_schools()
    for number, school in enumerate(schools):
        for node, room in school.nodes(data=True):
            room.update({"outer_wall": 5.0 if room["label"] == "CLASSROOM" else 1.0 * node, "aspect": 1.25})
        nx.set_edge_attributes(school, 0.8 if number % 2 else 5.0, "width")
        corridors = {node for node, label in school.nodes(data="label") if label == "CORRIDOR"}
        for one, other, door in school.edges(data=True):
            door["opening"] = {one, other} <= corridors and number % 4 > 0
    learn_type(schools, SCHOOL).save(tmp_path / "school.json")
    model = read_type_model(tmp_path / "school.json")
    assert {room["aspect"] for floor in model.floors for _, room in floor.graph.nodes(data=True)} == {1.25}
    assert set(list_door_widths(model)) == {0.8}
    needs = find_window_needs(model)
    assert needs["CLASSROOM"] == 1.0
    between = [
        len(school.subgraph(n for n, label in school.nodes(data="label") if label == "CORRIDOR").edges)
        for school in schools
    ]
    opened = sum(count for number, count in enumerate(between) if number % 4)
    # All corridors have the same label, so that their doors have the share of all
    edge = next(edge for edge in schools[0].edges if {*edge} <= set(find_corridors(schools[0], SCHOOL)))
    assert find_opening_shares(schools[0], model)[edge] == pytest.approx(opened / sum(between))
    with_window = [
        room["outer_wall"] >= 2
        for floor in model.floors
        for _, room in floor.graph.nodes(data=True)
        if room["label"] == "CORRIDOR"
    ]
    assert needs["CORRIDOR"] == pytest.approx(max(0, 2 * np.mean(with_window) - 1))


def test_a_model_without_them():
    model = learn_type(make_schools(), SCHOOL)
    assert find_window_needs(model) == {}
    assert list_door_widths(model) == [USUAL_DOOR]
    assert find_opening_shares(make_schools()[0], model) == {}


@pytest.mark.parametrize(("gap", "dark"), [(2, 2), (20, 0)])
def test_rooms_want_windows_to_the_outside_and_to_courts(gap, dark):
    """Rooms 1 and 2 inside room 0, with a gap between them."""
    cells = np.zeros((30, 70), np.int32)
    cells[10:20, 20:25] = 1
    cells[10:20, 25 : 25 + gap] = NO_ROOM
    cells[10:20, 25 + gap : 30 + gap] = 2
    if gap > 10:
        cells[5:25, 25 : 25 + gap] = NO_ROOM
    cells = np.pad(cells, 20, constant_values=NO_ROOM)
    needs = {0: 1.0, 1: 0.5, 2: 0.5}
    assert measure_outer_walls(cells, needs, frozenset()) == pytest.approx(LOSS_BY_DARKNESS * 0.5 * dark / 3)


def test_openings_are_where_corridors_with_such_labels_have_them():
    """Corridors are open to corridors, and have doors to lobbies, as often as each of both is known: ten times."""
    schools = [join_wings(("CC", "CC", "AA"), ((0, 1), (1, 2)), source=str(number)) for number in range(10)]
    for school in schools:
        first, second, third = find_corridors(school, SCHOOL)
        school.nodes[third]["label"] = "LOBBY"
        school.edges[first, second]["opening"], school.edges[second, third]["opening"] = True, False
        school.edges[first, 1]["opening"] = False
    shares = find_opening_shares(schools[0], learn_type(schools, SCHOOL))
    # Of all half are openings, which count as two doors besides
    assert shares == {(first, second): pytest.approx(11 / 12), (second, third): pytest.approx(1 / 12)}


def test_corridors_lose_by_their_outer_walls():
    """A corridor of 10 by 40 cells with a room on a long side: of its 100 cells of wall 60 are outer ones."""
    cells = np.full((70, 90), NO_ROOM, np.int32)
    cells[20:30, 20:60], cells[30:50, 20:60] = 0, 1
    assert measure_outer_walls(cells, {0: 0.0, 1: 0.0}, frozenset({0})) == pytest.approx(0.6 * LOSS_BY_OPEN_SIDES)
    assert measure_outer_walls(cells, {0: 0.0, 1: 0.0}, frozenset()) == 0


def test_ways_of_several_doors_are_those_of_each():
    cells = np.full((60, 90), NO_ROOM, np.int32)
    cells[20:30, 10:20], cells[20:30, 60:70], cells[40:50, 30:40], cells[10:14, 40:44] = 0, 1, 2, 3
    edges = [(0, 1), (0, 2), (3, 0), (1, 2)]
    together = measure_gaps(cells, edges, frozenset({0}))
    assert together == pytest.approx(sum(measure_gaps(cells, [edge], frozenset({0})) for edge in edges))
    assert measure_gaps(cells, edges, frozenset({0}), below=0.0) == pytest.approx(4 * LOSS_BY_DOOR)
