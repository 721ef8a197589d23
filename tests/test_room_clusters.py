from collections.abc import Sequence

import numpy as np
import pytest

from pianta_bench.types.clusters import (
    find_bend,
    find_room_clusters,
    measure_clusters,
    measure_distances,
    name_by_majority,
)
from pianta_bench.types.room_sets import RoomSet


def make_rooms(areas: Sequence[float], doors: Sequence[float], labels: str) -> RoomSet:
    geometry = np.column_stack([areas, doors, np.ones(len(areas))])
    return RoomSet("Office", geometry, np.zeros((len(areas), 5)), np.array([*labels]), np.array([""] * len(areas)), {})


# Seven rooms at 10 m², seven at 40 m², which differ from 3 m² by less than ε; one corridor far away.
BLOBS = make_rooms(
    [10 + 0.1 * n for n in range(7)] + [40 + 0.1 * n for n in range(7)] + [90], [1] * 14 + [9], "S" * 7 + "M" * 7 + "C"
)


def test_two_dense_groups_and_one_room_apart():
    clustering = find_room_clusters(BLOBS, scale="a (m²), d, rt")
    assert clustering.clusters.tolist() == [0] * 7 + [1] * 7 + [-1]
    assert clustering.plane.shape == (15, 2)
    assert clustering.figures == pytest.approx(
        {
            "clusters": 2,
            "outliers": 1 / 15,
            "corridors_in_outliers": 1,
            "homogeneity": 1,
            "completeness": 1,
            "homogeneity_r_c": 1,
            "homogeneity_r_c_clustered": 1,
            "accuracy_clustered": 1,
            "accuracy_outliers_together": 1,
            "accuracy_outliers_majority": 14 / 15,
            "always_majority": 14 / 15,
            "four_doorways": 1,
        }
    )


def test_the_scale_decides_what_is_near():
    # In per cent of the range, 90 - 10 m², steps of 0.1 m² are 0.125 and 30 m² are 37.5.
    assert find_room_clusters(BLOBS, scale="% of range").clusters.tolist() == [0] * 7 + [1] * 7 + [-1]
    wide = make_rooms([10 + 4.0 * n for n in range(15)], [1] * 15, "S" * 15)
    assert set(find_room_clusters(wide, scale="a (m²), d, rt").clusters) == {-1}
    far = make_rooms([10 + 0.5 * n for n in range(14)] + [5000], [1] * 15, "S" * 15)
    assert find_room_clusters(far, scale="% of range").clusters.tolist() == [0] * 14 + [-1]


def test_where_all_rooms_are_outliers_scores_of_clusters_are_none():
    figures = measure_clusters(make_rooms([1, 2, 3], [1] * 3, "CSS"), np.array([-1, -1, -1]))
    assert (figures["clusters"], figures["outliers"]) == (0, 1)
    assert figures["corridors_in_outliers"] == pytest.approx(1 / 3)
    assert figures["accuracy_clustered"] is figures["homogeneity_r_c_clustered"] is None
    assert figures["accuracy_outliers_together"] == figures["accuracy_outliers_majority"] == pytest.approx(2 / 3)


def test_the_naive_rule_by_hand():
    # Cluster 0: C C S; cluster 1: S S H; outliers: C C B.
    rooms = make_rooms([1.0] * 9, [1] * 9, "CCSSSHCCB")
    figures = measure_clusters(rooms, np.repeat([0, 1, -1], 3))
    assert figures["accuracy_clustered"] == pytest.approx(4 / 6)
    assert figures["accuracy_outliers_together"] == pytest.approx(6 / 9)
    # Most rooms of the set, 5 of 9, are CORRIDOR.
    assert figures["accuracy_outliers_majority"] == pytest.approx(6 / 9)
    assert figures["always_majority"] == pytest.approx(5 / 9)
    assert figures["corridors_in_outliers"] == pytest.approx(2 / 3)
    # With one doorway each, all are called ROOM, and 4 are.
    assert figures["four_doorways"] == pytest.approx(4 / 9)


def test_a_tie_is_a_room():
    assert not name_by_majority(np.array([True, False]), np.array([0, 0])).any()


def test_outliers_are_one_cluster_in_homogeneity():
    rooms = make_rooms([1.0] * 4, [1] * 4, "SSCS")
    figures = measure_clusters(rooms, np.array([0, 0, -1, -1]))
    assert figures["homogeneity_r_c_clustered"] == 1
    # Entropies: 1/4, 3/4 overall; 1 bit in the outliers, which are half of the rooms.
    overall = -(0.25 * np.log2(0.25) + 0.75 * np.log2(0.75))
    assert figures["homogeneity_r_c"] == pytest.approx(1 - 0.5 / overall)


def test_distances_are_to_the_sixth_room_itself_counted():
    features = np.array([[0.0], [1], [2], [3], [4], [5]])
    assert measure_distances(features).tolist() == [3, 3, 4, 4, 5, 5]


def test_the_bend_is_furthest_below_the_line_between_the_ends():
    assert find_bend(np.array([0.0, 1, 2, 3, 4, 8, 12, 16])) == 4
    # The farthest fiftieth does not move it.
    assert find_bend(np.array([*np.linspace(0, 1, 80), *np.linspace(1.5, 10, 18), 1e6, 1e9])) == 1
