import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from sklearn.cluster import DBSCAN

from pianta.layout.parameters import ThesisParameters
from pianta.layout.thesis.affinity import cluster_faces, compute_affinity_matrix, find_partial_faces, normalise_affinity
from pianta.layout.thesis.contour import compute_map_contour
from pianta.layout.thesis.faces import Faces, find_faces, label_faces, share_free, share_inside
from pianta.layout.thesis.lines import RepresentativeLine
from tests.drawn_maps import carve, make_working_grid


def put_side_by_side(*weights: float):
    """Unit squares along x, divided by walls of given weights."""
    count = len(weights)
    first = np.arange(count)
    polygons = shapely.box(np.arange(count + 1), 0, np.arange(1, count + 2), 1)
    x = first + 1.0
    ends = np.column_stack([x, np.zeros(count)]), np.column_stack([x, np.ones(count)])
    return Faces(polygons, first, first + 1, *ends, np.array(weights, float))


def part(labels: np.ndarray):
    """Clusters as sets of positions."""
    return {frozenset(np.flatnonzero(labels == label).tolist()) for label in np.unique(labels)}


def test_affinity_falls_with_the_weight_between_adjacent_faces():
    # exp(-0 / 0.1) = 1, exp(-0.2 / 0.1) = 0.135335.
    affinity = compute_affinity_matrix(put_side_by_side(0, 0.2), sigma=0.1)
    assert affinity.toarray() == pytest.approx(np.array([[1, 1, 0], [1, 1, 0.135335], [0, 0.135335, 1]]), abs=1e-6)


def test_local_affinity_has_rows_that_sum_to_one():
    local = normalise_affinity(compute_affinity_matrix(put_side_by_side(0, 0.2), sigma=0.1)).toarray()
    # The rows of L sum to 2, 2.135335 and 1.135335.
    by_hand = [[1 / 2, 1 / 2, 0], [1 / 2.135335, 1 / 2.135335, 0.063379], [0, 0.119203, 1 / 1.135335]]
    assert local == pytest.approx(np.array(by_hand), abs=1e-6)


@pytest.mark.parametrize(
    ("weights", "rooms"),
    [
        ([0, 0], [{0, 1, 2}]),
        ([1, 1], [{0}, {1}, {2}]),
        # By the matrix above, faces 0 and 1 are 0.5 apart, faces 1 and 2 are 0.881 apart.
        ([0, 0.2], [{0, 1}, {2}]),
    ],
)
def test_faces_join_where_no_wall_is(weights, rooms):
    local = normalise_affinity(compute_affinity_matrix(put_side_by_side(*weights), sigma=0.1))
    assert part(cluster_faces(local, epsilon=0.85)) == {frozenset(room) for room in rooms}


@pytest.mark.slow
@given(
    st.integers(1, 9).flatmap(
        lambda count: st.tuples(
            st.just(count),
            st.dictionaries(
                st.tuples(st.integers(0, count - 1), st.integers(0, count - 1)).filter(lambda pair: pair[0] < pair[1]),
                st.floats(0, 1),
            ),
        )
    ),
    st.sampled_from([0.3, 0.6, 0.85]),
)
def test_clusters_are_those_of_dbscan(graph, epsilon):
    count, edges = graph
    affinity = np.eye(count)
    for (i, j), weight in edges.items():
        affinity[i, j] = affinity[j, i] = np.exp(-weight / 0.15)
    local = normalise_affinity(csr_array(affinity))
    dense = local.toarray()
    distance = np.clip(1 - np.maximum(dense, dense.T), 0, None)
    np.fill_diagonal(distance, 0)
    reference = DBSCAN(eps=epsilon, min_samples=1, metric="precomputed").fit_predict(distance)
    assert part(cluster_faces(local, epsilon=epsilon)) == part(reference)


def test_only_internal_faces_open_to_an_external_one_are_partial():
    faces = put_side_by_side(0.1, 0.1, 0.3, 0.1)
    internal = np.array([True, True, False, True, True])
    open_edges = np.ones(4)
    partial = find_partial_faces(faces, internal, open_edges, partial_weight=0.2)
    assert partial.tolist() == [False, True, False, False, False]


def test_an_edge_that_is_not_free_opens_no_face():
    faces = put_side_by_side(0.1, 0.1)
    partial = find_partial_faces(faces, np.array([True, False, True]), np.array([0.4, 0.6]), partial_weight=0.2)
    assert partial.tolist() == [False, False, True]


def test_a_room_that_has_not_been_seen_to_its_end_has_a_partial_face():
    # A room of 4 m by 4 m without a wall on its right side, beyond which little has been seen.
    canvas = make_working_grid(carve((120, 180), (20, 100, 20, 106), (55, 65, 100, 120)))
    left = RepresentativeLine(np.pi / 2, -1.0, np.array([[1.0, 5.0]]))
    right = RepresentativeLine(np.pi / 2, -5.0, np.array([[1.0, 1.2]]))
    top, bottom = (RepresentativeLine(0.0, y, np.array([[1.0, 5.0]])) for y in (1.0, 5.0))
    faces = find_faces([left, right, top, bottom], canvas)
    labels = label_faces(faces, canvas)
    inner = compute_map_contour(canvas, ThesisParameters())
    internal = share_inside(labels, inner, len(faces.polygons)) >= 0.5
    partial = find_partial_faces(faces, internal, share_free(faces, canvas), partial_weight=0.2)
    assert faces.polygons[internal].tolist() == faces.polygons[partial].tolist()
    assert [polygon.bounds for polygon in faces.polygons[partial]] == [pytest.approx((1, 1, 5, 5))]
