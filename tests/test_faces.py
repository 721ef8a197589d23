import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from pianta.layout.thesis.faces import Faces, cut_lines, find_faces, label_faces, share_free, share_inside
from pianta.layout.thesis.lines import RepresentativeLine
from tests.drawn_maps import carve, make_working_grid

# 6 m by 6 m of free space; lines are drawn to 1 m beyond it.
HALL = make_working_grid(np.ones((120, 120), bool))
ALL = [[-9.0, 9.0]]

lines_of_any_kind = st.lists(
    st.tuples(st.floats(0, 3.14), st.floats(-6, 6)).map(lambda values: RepresentativeLine(*values, np.array(ALL))),
    max_size=6,
)


def upright(x: float, covered=ALL):
    """Line at x; covered intervals of y."""
    return RepresentativeLine(np.pi / 2, -x, np.array(covered, float))


def level(y: float, covered=ALL):
    """Line at y; covered intervals of x."""
    return RepresentativeLine(0.0, y, np.array(covered, float))


def edge_weight(faces: Faces, x, y):
    """Weight of the common edge whose middle is x, y."""
    middles = (faces.starts + faces.ends) / 2
    (index,) = np.flatnonzero(np.abs(middles - [x, y]).max(axis=1) < 1e-5)
    return faces.weight[index]


def test_four_lines_crossing_like_a_hash_make_nine_faces_and_twelve_edges():
    faces = find_faces([upright(2), upright(4), level(2), level(4)], HALL)
    assert sorted(shapely.area(faces.polygons)) == pytest.approx(sorted([9, 6, 9, 6, 4, 6, 9, 6, 9]))
    assert len(faces.first) == 12
    pairs = {frozenset(pair) for pair in zip(faces.first.tolist(), faces.second.tolist(), strict=True)}
    # Centres of neighbours are 2.5 m apart, all others 3.5 m and more.
    centres = shapely.centroid(faces.polygons)
    near = np.triu(shapely.distance(centres[:, None], centres) < 3, k=1)
    assert pairs == {frozenset(pair) for pair in np.argwhere(near).tolist()}


def test_weight_is_the_share_of_the_edge_that_is_wall():
    walls = [upright(2), upright(4, [[2.5, 3.0]]), level(2, [[-1, 2.6], [3.0, 7]]), level(4, [[0, 2], [6, 9]])]
    faces = find_faces(walls, HALL)
    assert edge_weight(faces, 2, 3) == pytest.approx(1)
    assert edge_weight(faces, 4, 3) == pytest.approx(0.25)
    # A wall of 2 m with a gap of 0.4 m for a door.
    assert edge_weight(faces, 3, 2) == pytest.approx(0.8)
    assert edge_weight(faces, 3, 4) == pytest.approx(0, abs=1e-9)
    # 2 m of wall from -1 to 2, and 1 m of wall from 4 to 7.
    assert edge_weight(faces, 0.5, 4) == pytest.approx(2 / 3)
    assert edge_weight(faces, 5.5, 4) == pytest.approx(1 / 3)


@pytest.mark.parametrize("apart", [1e-9, 1e-7, 3e-7])
def test_nearly_coincident_lines_leave_no_slivers(apart):
    faces = find_faces([upright(3), upright(3 + apart), level(3), level(3 - apart)], HALL)
    assert sorted(shapely.area(faces.polygons)) == pytest.approx([16] * 4, abs=1e-3)
    assert len(faces.first) == 4


def test_lines_through_nearly_one_point_leave_no_slivers():
    diagonal = RepresentativeLine(np.pi / 4, 1e-8, np.array(ALL))
    faces = find_faces([upright(3), level(3), diagonal], HALL)
    assert sorted(shapely.area(faces.polygons)) == pytest.approx([8, 8, 8, 8, 16, 16], abs=1e-3)


def test_without_lines_there_is_one_face():
    faces = find_faces([], HALL)
    assert shapely.area(faces.polygons) == pytest.approx([64])
    assert len(faces.first) == len(faces.weight) == 0


@pytest.mark.slow
@given(lines_of_any_kind)
def test_faces_tile_the_frame_and_meet_along_their_edges(lines):
    faces = find_faces(lines, HALL)
    assert shapely.area(faces.polygons).sum() == pytest.approx(64)
    assert shapely.coverage_is_valid(faces.polygons)
    assert ((faces.weight >= 0) & (faces.weight <= 1)).all()
    edges = shapely.linestrings(np.stack([faces.starts, faces.ends], axis=1))
    for side in (faces.first, faces.second):
        assert (shapely.distance(shapely.get_exterior_ring(faces.polygons[side]), edges) < 1e-9).all()
    shared = shapely.length(edges).sum()
    assert shapely.length(faces.polygons).sum() == pytest.approx(2 * shared + 32)


@pytest.mark.slow
@given(lines_of_any_kind)
def test_cells_carry_the_face_that_they_lie_in(lines):
    faces = find_faces(lines, HALL)
    labels = label_faces(faces, HALL)
    assert labels.min() >= 0
    rows, cols = np.indices(labels.shape)[:, ::10, ::10]
    centres = shapely.points((cols + 0.5) * 0.05, (rows + 0.5) * 0.05)
    # OpenCV rounds corners to a sixteenth of a cell, and draws whole cells on the edges.
    assert shapely.distance(faces.polygons[labels[rows, cols]], centres).max() < 0.05


def test_share_inside_counts_the_cells_of_each_face():
    faces = find_faces([upright(2), level(3)], HALL)
    labels = label_faces(faces, HALL)
    shares = share_inside(labels, carve((120, 120), (0, 60, 0, 80)), 4)
    centres = shapely.get_coordinates(shapely.centroid(faces.polygons))
    expected = [0 if y > 3 else 1 if x < 2 else 0.5 for x, y in centres]
    assert shares == pytest.approx(expected, abs=0.02)


def test_share_inside_of_a_face_without_a_cell_is_zero():
    assert share_inside(np.zeros((2, 2), np.int32), np.ones((2, 2), bool), 3).tolist() == [1, 0, 0]


def test_share_free_is_the_share_of_an_edge_in_free_cells():
    # Free but for the left half of the middle rows, and for what lies off the canvas.
    canvas = make_working_grid(~carve((120, 120), (50, 70, 0, 60)))
    faces = find_faces([level(3)], canvas)
    assert share_free(faces, canvas).tolist() == pytest.approx([3 / 8], abs=1 / 32)


def test_lines_are_cut_to_a_region_and_left_out_beyond_it():
    parts = cut_lines([level(2), level(7), upright(1)], shapely.box(0, 0, 6, 4))
    assert [part.length for part in parts] == pytest.approx([6, 4])
    assert parts[0].equals_exact(shapely.LineString([(0, 2), (6, 2)]), 1e-9, normalize=True)
