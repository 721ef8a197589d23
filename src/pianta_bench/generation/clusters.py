"""Clusters of functional areas: how alike the areas of each are to each other, and to those of other clusters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pianta.generation.area_clusters import compare_areas, measure_cluster_similarity
from pianta.generation.type_model import TypeModel


@dataclass(frozen=True, eq=False)
class ClusterScores:
    """What was found of the clusters of a model.

    gram: of all areas, shape (areas, areas). clusters: of each area. similarity: of each two clusters, shape
    (clusters, clusters), each area compared with itself too, as in Fig. 7.5.
    intra: mean similarity of two areas of each cluster, nan for a cluster of one. inter: of an area of it and one of
    any other cluster, nan for the only cluster. sizes: areas of each.
    """

    gram: NDArray[np.float64]
    clusters: NDArray[np.intp]
    similarity: NDArray[np.float64]
    intra: NDArray[np.float64]
    inter: NDArray[np.float64]
    sizes: NDArray[np.intp]

    @property
    def loose(self) -> int:
        """Clusters whose areas are not more alike to each other than to those of other clusters."""
        return int((self.intra <= self.inter).sum())

    @property
    def mixed(self) -> int:
        """Clusters whose areas are as alike to those of one other cluster as to each other."""
        others = self.similarity.copy()
        np.fill_diagonal(others, -np.inf)
        return int((self.intra <= others.max(axis=1)).sum())


def score_clusters(model: TypeModel) -> ClusterScores:
    """Scores of the clusters of a model's areas, by the normalised Graph Hopper kernel."""
    gram, clusters = compare_areas(model.areas), model.clusters
    return score_gram(gram, clusters)


def score_gram(gram: NDArray[np.float64], clusters: NDArray[np.intp]) -> ClusterScores:
    """Scores of clusters, shape (areas,), by the Gram matrix of the areas."""
    sizes = np.bincount(clusters)
    similarity = measure_cluster_similarity(gram, clusters)
    sums = similarity * np.outer(sizes, sizes)
    own = np.diagonal(sums)
    selves = np.bincount(clusters, np.diagonal(gram))
    with np.errstate(invalid="ignore"):
        intra = (own - selves) / (sizes * (sizes - 1))
        inter = (sums.sum(axis=1) - own) / (sizes * (sizes.sum() - sizes))
    intra[sizes == 1] = np.nan
    return ClusterScores(gram, clusters, similarity, intra, inter, sizes)
