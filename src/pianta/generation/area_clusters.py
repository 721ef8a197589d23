"""Clusters of functional areas that are alike, over all floors (thesis, section 7.3.2)."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.errors import ModelError

# As of the authors for schools, `corr` and `ncut`; more damping only takes longer.
DAMPING = 0.8
MAX_ITERATIONS = 1000


def compare_areas(areas: Iterable[nx.Graph]) -> NDArray[np.float64]:
    """Gram matrix of the areas, shape (areas, areas), by the normalised Graph Hopper kernel."""
    from pianta.graphs.graph_hopper import GraphHopper

    gram: NDArray[np.float64] = GraphHopper().fit(areas).compare()
    return gram


def cluster_areas(gram: NDArray[np.float64], *, damping: float = DAMPING) -> NDArray[np.intp]:
    """The cluster of each area, shape (areas,), numbered from 0: affinity propagation, its preference the median.

    gram: what `compare_areas` gives. Two areas are alike here when they are alike to the same areas: the affinity is
    minus the squared distance of their rows. With the kernel itself for the affinity there are half as many clusters
    again as section 7.3.3 prints, and several of one area.

    Raises ModelError when the messages do not settle.
    """
    from sklearn.cluster import AffinityPropagation
    from sklearn.exceptions import ConvergenceWarning

    with warnings.catch_warnings():
        warnings.simplefilter("error", ConvergenceWarning)
        try:
            found = AffinityPropagation(damping=damping, max_iter=MAX_ITERATIONS, random_state=0).fit_predict(gram)
        except ConvergenceWarning:
            raise ModelError(f"{len(gram)} functional areas form no stable clusters, give more buildings") from None
    clusters: NDArray[np.intp] = found.astype(np.intp)
    return clusters


def measure_cluster_similarity(gram: NDArray[np.float64], clusters: NDArray[np.intp]) -> NDArray[np.float64]:
    """Mean similarity of the areas of each two clusters, shape (clusters, clusters), as the heat maps of Fig. 7.5."""
    members = np.equal.outer(np.arange(clusters.max(initial=-1) + 1), clusters).astype(np.float64)
    means = members / members.sum(axis=1, keepdims=True)
    similarity: NDArray[np.float64] = means @ gram @ means.T
    return similarity
