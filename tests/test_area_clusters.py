"""Clusters of functional areas: obvious ones, areas that are all the same, and messages that do not settle."""

import numpy as np
import pytest

from pianta.errors import ModelError
from pianta.generation import area_clusters
from pianta.generation.area_clusters import cluster_areas, compare_areas, measure_cluster_similarity
from pianta.generation.functional_areas import Segmentation
from pianta.generation.type_model import learn_type
from pianta.labels import SCHEMAS
from tests.generated_types import make_wing
from tests.labelled_graphs import assert_kernel
from tests.school_graphs import read_schools

TEACHING = [make_wing(rooms) for rooms in ("CCC", "CCCC", "CCCCC", "CCCT", "CCCCT")]
OFFICES = [make_wing(rooms, hub="HALL") for rooms in ("AA", "AAA", "AAS", "AAAS")]
STORES = [make_wing(rooms, hub="LOBBY") for rooms in ("SSS", "SSSS", "SSSSS")]


def group(clusters) -> set[frozenset[int]]:
    return {frozenset(np.flatnonzero(clusters == cluster).tolist()) for cluster in set(clusters.tolist())}


@pytest.mark.parametrize("segmentation", Segmentation)
def test_obvious_clusters(segmentation):
    clusters = cluster_areas(compare_areas([*TEACHING, *OFFICES, *STORES]), segmentation=segmentation)
    assert group(clusters) == {frozenset(range(5)), frozenset(range(5, 9)), frozenset(range(9, 12))}
    assert sorted(set(clusters.tolist())) == [0, 1, 2]


def test_the_order_of_areas_does_not_matter():
    areas = [*TEACHING, *OFFICES, *STORES]
    order = np.random.default_rng(1).permutation(len(areas))
    reordered = cluster_areas(compare_areas([areas[index] for index in order]))
    clusters = np.empty(len(areas), int)
    clusters[order] = reordered
    assert group(clusters) == group(cluster_areas(compare_areas(areas)))


def test_similarities_are_a_normalised_kernel():
    gram = compare_areas([*TEACHING, *OFFICES])
    assert_kernel(gram)
    np.testing.assert_allclose(np.diag(gram), 1)


@pytest.mark.parametrize("count", [1, 2, 3, 30])
def test_areas_that_are_the_same_are_one_cluster(count):
    assert cluster_areas(compare_areas([make_wing("CCT")] * count)).tolist() == [0] * count


@pytest.mark.parametrize("segmentation", Segmentation)
def test_two_areas_are_clusters_without_a_warning(segmentation):
    clusters = cluster_areas(compare_areas([TEACHING[0], STORES[0]]), segmentation=segmentation).tolist()
    assert sorted(set(clusters)) == [*range(len(set(clusters)))]


def test_messages_that_do_not_settle(monkeypatch):
    monkeypatch.setattr(area_clusters, "MAX_ITERATIONS", 5)
    with pytest.raises(ModelError, match="clusters"):
        cluster_areas(compare_areas([*TEACHING, *OFFICES, *STORES]))


def test_cluster_similarity_by_hand():
    gram = np.array([[1, 0.8, 0.1], [0.8, 1, 0.3], [0.1, 0.3, 1]])
    # Of two areas the mean of four, each with itself among them.
    np.testing.assert_allclose(measure_cluster_similarity(gram, np.array([0, 0, 1])), [[0.9, 0.2], [0.2, 1]])
    np.testing.assert_allclose(measure_cluster_similarity(gram, np.array([1, 0, 1])), [[1, 0.55], [0.55, 0.55]])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
@pytest.mark.parametrize("segmentation", Segmentation)
def test_clusters_of_schools_are_more_alike_inside_than_outside(data, segmentation):
    model = learn_type(read_schools(data), SCHEMAS["school"], segmentation=segmentation)
    similarity = measure_cluster_similarity(compare_areas(model.areas), model.clusters)
    inside = np.diag(similarity)
    outside = (similarity.sum(axis=1) - inside) / (len(similarity) - 1)
    assert (inside > outside).all()
