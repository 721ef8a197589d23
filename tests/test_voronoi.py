"""The Voronoi segmentation, step by step, and its merging of cells, checked by hand."""

from dataclasses import replace

import numpy as np
import pytest

from pianta._types import Mask
from pianta.layout._voronoi_doors import draw_voronoi_diagram
from pianta.layout.rivals.patches import measure_padded_clearance
from pianta.layout.rivals.voronoi import (
    WALL,
    MergeRule,
    VoronoiParameters,
    draw_critical_lines,
    find_critical_points,
    measure_cells,
    merge_cells,
    prune_diagram,
    segment_by_voronoi_diagram,
)
from tests.drawn_maps import carve, make_grid

DEFAULT = VoronoiParameters()
# Two rooms of 4 × 4 m and 0.2 m of wall with a door of 0.9 m.
PAIR = carve((100, 184), (10, 90, 10, 90), (10, 90, 94, 174), (41, 59, 90, 94))
DOOR = (slice(41, 59), slice(90, 94))

# Three cells in a row, the first two with 3 sides in common, the last two with 1.
ROW = np.array([[1, 1, 2, 2, 0, 0], [1, 1, 2, 2, 3, 3], [1, 1, 2, 2, 0, 0]])


def diagram_of(free: Mask):
    clearance = measure_padded_clearance(free)
    return prune_diagram(draw_voronoi_diagram(free), clearance), clearance


def test_branches_into_corners_are_pruned_and_the_way_through_the_door_stays():
    diagram, _ = diagram_of(PAIR)
    rows, cols = np.nonzero(diagram)
    assert rows.min() > 40
    assert rows.max() < 60
    assert set(range(50, 134)) <= set(cols.tolist())


def test_a_lone_line_is_no_branch():
    line = carve((9, 30), (4, 5, 3, 27))
    assert (prune_diagram(line, measure_padded_clearance(line)) == line).all()


def test_the_door_is_the_narrowest_critical_point():
    diagram, clearance = diagram_of(PAIR)
    row, col = find_critical_points(diagram, clearance, 0.05, DEFAULT)[0]
    assert (row in range(48, 52), col in range(90, 94)) == (True, True)


def test_critical_points_come_narrowest_first():
    diagram, clearance = diagram_of(PAIR)
    points = find_critical_points(diagram, clearance, 0.05, DEFAULT)
    assert (np.diff(clearance[tuple(points.T)]) >= 0).all()


def test_a_diagram_without_a_point_has_no_critical_one():
    nothing = np.zeros((5, 6), bool)
    assert find_critical_points(nothing, np.zeros((5, 6)), 0.05, DEFAULT).shape == (0, 2)


def test_a_critical_line_closes_the_door_from_jamb_to_jamb():
    lines = draw_critical_lines(np.array([[49, 92]]), measure_padded_clearance(PAIR), DEFAULT.spacing)
    rows, cols = np.nonzero(lines & PAIR)
    assert sorted(rows.tolist()) == list(range(41, 59))
    assert set(cols.tolist()) <= set(range(90, 94))


@pytest.mark.parametrize(("spacing", "lines"), [(0.05, 2), (0.5, 1)])
def test_of_two_near_points_the_narrower_draws_its_line(spacing, lines):
    corridor = carve((40, 100), (10, 30, 0, 100))
    lines_drawn = draw_critical_lines(np.array([[20, 50], [20, 53]]), measure_padded_clearance(corridor), spacing)
    assert lines_drawn[20].nonzero()[0].tolist() == [50, 53][:lines]


def test_two_rooms_meet_in_the_door():
    labels = segment_by_voronoi_diagram(make_grid(PAIR))
    assert labels.max() == 2
    assert ((labels > 0) == PAIR).all()
    assert len(set(labels[10:90, 10:90].ravel().tolist())) == 1
    assert len(set(labels[10:90, 94:174].ravel().tolist())) == 1


def test_narrow_gaps_are_no_passage():
    # Without its door the wall has a gap of 0.1 m; no line is lines_drawn there, and the gap divides nothing.
    free = PAIR.copy()
    free[DOOR] = False
    free[50:52, 90:94] = True
    assert segment_by_voronoi_diagram(make_grid(free)).max() == 1
    assert segment_by_voronoi_diagram(make_grid(free), parameters=replace(DEFAULT, passage_width=0.04)).max() == 2


def test_borders_are_counted_in_sides_of_cells():
    cells = measure_cells(ROW, 0.5)
    assert cells.area[1:] == [1.5, 1.5, 0.5]
    assert cells.border[1] == {WALL: 7, 2: 3}
    assert cells.border[2] == {WALL: 6, 1: 3, 3: 1}
    assert cells.border[3] == {WALL: 5, 2: 1}


def test_merging_adds_areas_and_borders():
    cells = measure_cells(ROW, 0.5)
    cells.merge(2, 1)
    assert cells.area[1:] == [3.0, 0.0, 0.5]
    assert cells.border[1] == {WALL: 13, 3: 1}
    assert cells.border[3] == {WALL: 5, 1: 1}


@pytest.mark.parametrize(
    ("rule", "rooms"),
    [
        (MergeRule(area=0.4), [1, 2, 3]),
        (MergeRule(area=0.5), [1, 2, 2]),
        (MergeRule(area=0.5, wall=0.8), [1, 2, 3]),
        (MergeRule(area=0.5, wall=0.9), [1, 2, 2]),
        (MergeRule(shared=0.29), [1, 1, 2]),
        (MergeRule(shared=0.31), [1, 2, 3]),
        (MergeRule(shared=0.29, shared_back=0.31), [1, 2, 3]),
        (MergeRule(neighbours=1, area=0.5), [1, 2, 2]),
        (MergeRule(neighbours=0), [1, 2, 3]),
        (MergeRule(), [1, 1, 1]),
    ],
)
def test_a_rule_merges_the_cells_it_fits(rule, rooms):
    labels = merge_cells(ROW, 0.5, [rule])
    assert labels[1, [0, 2, 4]].tolist() == rooms


def test_of_several_neighbours_the_one_with_the_longest_common_border_takes_the_cell():
    labels = merge_cells(
        np.array([[1, 1, 3, 2], [1, 1, 3, 2], [1, 1, 3, 0]]), 1.0, [MergeRule(area=3, neighbours=2, wall=0.5)]
    )
    assert labels[0, 2] == labels[0, 0]
