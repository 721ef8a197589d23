"""Frontiers and shortest paths on small maps, with values by hand."""

from math import inf, sqrt
from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.exploration.frontiers import Frontier, count_border, find_frontiers
from pianta.exploration.routes import (
    find_route,
    measure_distances,
    straighten_route,
)
from tests.explored_worlds import draw_cells

MAP = """
??????????
?########?
?#......??
?#......??
?#......??
?###..###?
????..????
"""


def find(picture: str, *, reachable: str | None = None, **options: Any) -> list[Frontier]:
    mapped = draw_cells(picture)
    free = mapped == 0 if reachable is None else draw_cells(reachable) == 0
    return find_frontiers(mapped, free, resolution=1, **{"min_length": 1} | options)


def test_frontiers_are_free_cells_beside_the_unknown():
    east, south = find(MAP)
    assert east.cells.tolist() == [[2, 7], [3, 7], [4, 7]]
    assert (east.target, east.length, east.id) == ((3, 7), 3, 37)
    assert south.cells.tolist() == [[6, 4], [6, 5]]
    assert south.length == 2


def test_short_frontiers_are_left_out():
    (east,) = find(MAP, min_length=3)
    assert east.length == 3
    assert find(MAP, min_length=4) == []


def test_a_frontier_that_no_robot_reaches_is_left_out():
    west = "?????????? ?########? ?#.#####?? ?#.#####?? ?#.#####?? ?########? ??????????"
    assert find(MAP, reachable=west) == []


def test_the_target_is_where_a_robot_can_stand():
    top = "?????????? ?########? ?#......?? ?#....##?? ?#....##?? ?###..###? ????..????"
    east, _ = find(MAP, reachable=top)
    assert east.target == (2, 7)


def test_a_frontier_along_a_wall_is_reached_from_beside_it():
    mapped = np.zeros((9, 9), np.int8)
    mapped[0] = -1
    reachable = np.zeros((9, 9), bool)
    reachable[3, 2:7] = True
    (along,) = find_frontiers(mapped, reachable, resolution=0.1)
    assert along.cells[:, 0].tolist() == [1] * 9
    assert along.target == (3, 4)
    reachable[3] = False
    reachable[6] = True
    assert find_frontiers(mapped, reachable, resolution=0.1) == []


def test_given_up_cells_are_no_frontier():
    given_up = np.zeros(draw_cells(MAP).shape, bool)
    given_up[2:5, 7] = True
    (south,) = find(MAP, given_up=given_up)
    assert south.target[0] == 6


def test_a_long_frontier_is_divided():
    mapped = np.zeros((3, 100), np.int8)
    mapped[0] = -1
    parts = find_frontiers(mapped, mapped == 0, resolution=0.1)
    assert [len(part.cells) for part in parts] == [50, 50]
    assert [part.target for part in parts] == [(1, 24), (1, 74)]


def test_scanned_cells_are_no_longer_a_frontier():
    mapped = draw_cells(MAP)
    (east, _) = find(MAP)
    assert count_border(mapped, east.cells) == 3
    mapped[2:4, 8] = 100
    assert count_border(mapped, east.cells) == 1
    mapped[4, 7] = 100
    assert count_border(mapped, east.cells) == 0


def test_paths_have_straight_and_diagonal_steps_and_cut_no_corner():
    passable = draw_cells("..... .##.. .....") == 0
    distances = measure_distances(passable, [(0, 0)], resolution=0.5)
    diagonal = 0.5 * 99 / 70
    assert distances[0].tolist() == [0, 0.5, 1, 1.5, 2]
    assert distances[2, 2] == 2
    assert distances[2, 4] == pytest.approx(1.5 + diagonal + 0.5)
    assert distances[1, 1] == inf
    assert diagonal == pytest.approx(0.5 * sqrt(2), rel=1e-4)


def test_no_path_leads_between_cells_that_touch_at_a_corner():
    distances = measure_distances(draw_cells(".# #.") == 0, [(0, 0)], resolution=1)
    assert distances[1, 1] == inf


def test_the_nearest_source_counts_and_barred_ones_do_not():
    passable = draw_cells("........#") == 0
    distances = measure_distances(passable, [(0, 0), (0, 6), (0, 8)], resolution=1)
    assert distances[0].tolist() == [0, 1, 2, 3, 2, 1, 0, 1, inf]
    assert (measure_distances(passable, [(0, 8)], resolution=1) == inf).all()


def test_a_route_is_as_long_as_its_distance():
    passable = draw_cells("...... .####. ......") == 0
    distances = measure_distances(passable, [(0, 0)], resolution=0.1)
    route = find_route(distances, (2, 5), resolution=0.1)
    assert route[0].tolist() == [0, 0]
    assert route[-1].tolist() == [2, 5]
    assert np.abs(np.diff(route, axis=0)).sum(axis=1).tolist() == [1] * 7
    assert distances[2, 5] == pytest.approx(0.7)


masks = st.integers(1, 9).flatmap(
    lambda width: st.lists(st.lists(st.sampled_from([True, True, False]), min_size=width, max_size=width), min_size=1)
)


@pytest.mark.slow
@given(masks, st.data())
def test_distances_are_those_of_the_graph_of_cells(cells, data):
    passable = np.array(cells)
    candidates = [(row, col) for row, col in np.argwhere(passable).tolist()]
    if not candidates:
        return
    sources = data.draw(st.lists(st.sampled_from(candidates), min_size=1, max_size=3))
    graph = nx.Graph()
    graph.add_nodes_from(candidates)
    for row, col in candidates:
        for down, right, cost in ((0, 1, 70), (1, 0, 70), (1, 1, 99), (1, -1, 99)):
            beside = [(row + down, col + right), (row + down, col), (row, col + right)]
            if all(cell in graph for cell in beside):
                graph.add_edge((row, col), beside[0], weight=cost)
    lengths = nx.multi_source_dijkstra_path_length(graph, set(sources))
    distances = measure_distances(passable, sources, resolution=70)
    expected = np.full(passable.shape, inf)
    for cell, length in lengths.items():
        expected[cell] = length
    assert np.array_equal(distances, expected)


@pytest.mark.slow
@given(masks)
def test_routes_step_between_passable_neighbours_and_add_up(cells):
    passable = np.array(cells)
    candidates = [(row, col) for row, col in np.argwhere(passable).tolist()]
    if not candidates:
        return
    distances = measure_distances(passable, candidates[:1], resolution=1)
    for target in candidates:
        if distances[target] < inf:
            route = find_route(distances, target, resolution=1)
            steps = np.abs(np.diff(route, axis=0))
            assert (steps.max(axis=1) == 1).all() if len(steps) else target == candidates[0]
            lengths = np.where(steps.sum(axis=1) == 2, 99 / 70, 1)
            assert lengths.sum() == pytest.approx(distances[target])
            assert passable[tuple(route.T)].all()


def test_a_route_is_pulled_tight():
    passable = draw_cells("....... ....... ..###.. ....... .......") == 0
    distances = measure_distances(passable, [(4, 0)], resolution=1)
    corners = straighten_route(find_route(distances, (4, 6), resolution=1), passable)
    assert corners.tolist() == [[4, 0], [4, 6]]
    round_the_wall = measure_distances(passable, [(3, 3)], resolution=1)
    corners = straighten_route(find_route(round_the_wall, (1, 3), resolution=1), passable)
    lengths = np.hypot(*np.diff(corners, axis=0).T).sum()
    assert lengths <= round_the_wall[1, 3]
    assert len(corners) >= 3


def test_a_route_of_one_cell_has_one_corner():
    route = np.array([[2, 3]])
    assert straighten_route(route, np.ones((5, 5), bool)).tolist() == [[2, 3]]
