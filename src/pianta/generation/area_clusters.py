"""Clusters of similar functional areas over all floors (thesis, section 7.3.2)."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from contextlib import suppress
from enum import StrEnum
from types import MappingProxyType

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.errors import ModelError
from pianta.generation.functional_areas import Segmentation

# Damping of affinity propagation: the authors' values for schools.
DAMPING: Mapping[Segmentation, float] = MappingProxyType({Segmentation.CORR: 0.8, Segmentation.NCUT: 0.7})
# Tried in turn if messages oscillate; chosen by hand.
MORE_DAMPING = (0.9, 0.97)
# The preference, as a quantile of the affinities. The authors use the median and stop after 100 iterations, before
# messages converge: areas of `corr` are then in fewer clusters. A third gives the same number after convergence.
PREFERENCE: Mapping[Segmentation, float] = MappingProxyType({Segmentation.CORR: 1 / 3, Segmentation.NCUT: 1 / 2})
MAX_ITERATIONS = 3000
# Messages have converged if the clusters are the same for this many iterations.
CONVERGENCE_ITERATIONS = 100
# Smaller differences of similarities are rounding errors.
TOLERANCE = 1e-9


class AreaKernel(StrEnum):
    """The kernel that compares areas; section 7.3.3 prefers Graph Hopper."""

    GRAPH_HOPPER = "graph-hopper"
    WEISFEILER_LEHMAN = "weisfeiler-lehman"


def compare_areas(areas: Iterable[nx.Graph], *, kernel: AreaKernel = AreaKernel.GRAPH_HOPPER) -> NDArray[np.float64]:
    """Gram matrix of the areas, shape (areas, areas), by a normalised kernel."""
    from pianta.graphs.graph_hopper import GraphHopper
    from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

    chosen = GraphHopper() if kernel is AreaKernel.GRAPH_HOPPER else WeisfeilerLehman()
    gram: NDArray[np.float64] = chosen.fit(areas).compare()
    return gram


def cluster_areas(gram: NDArray[np.float64], *, segmentation: Segmentation = Segmentation.CORR) -> NDArray[np.intp]:
    """The cluster of each area, shape (areas,), numbered from 0, by affinity propagation (Frey and Dueck, 2007).

    gram: result of `compare_areas`. The affinity of two areas is minus the squared distance of their rows. With the
    kernel itself as affinity there would be more clusters than in section 7.3.3, several of them with one area.

    Raises ModelError if the messages do not converge.
    """
    from sklearn.cluster import AffinityPropagation
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.metrics import pairwise_distances

    if np.ptp(gram, axis=0).max(initial=0) < TOLERANCE:
        return np.zeros(len(gram), np.intp)
    affinities = -(pairwise_distances(gram) ** 2)
    preference = float(np.quantile(affinities, PREFERENCE[segmentation]))
    options = {
        "max_iter": MAX_ITERATIONS,
        "convergence_iter": CONVERGENCE_ITERATIONS,
        "preference": preference,
        "random_state": 0,
    }
    with warnings.catch_warnings():
        warnings.simplefilter("error", ConvergenceWarning)
        # Two areas have equal similarities.
        warnings.filterwarnings("ignore", "All samples have mutually equal similarities", UserWarning)
        for damping in (DAMPING[segmentation], *MORE_DAMPING):
            messages = AffinityPropagation(damping=damping, affinity="precomputed", **options)
            with suppress(ConvergenceWarning):
                return np.asarray(messages.fit_predict(affinities), np.intp)
    raise ModelError(f"{len(gram)} functional areas form no stable clusters, give more buildings")


def measure_cluster_similarity(gram: NDArray[np.float64], clusters: NDArray[np.intp]) -> NDArray[np.float64]:
    """Mean similarity of the areas of each two clusters, shape (clusters, clusters), as in Fig. 7.5."""
    members = np.equal.outer(np.arange(clusters.max(initial=-1) + 1), clusters).astype(np.float64)
    means = members / members.sum(axis=1, keepdims=True)
    similarity: NDArray[np.float64] = means @ gram @ means.T
    return similarity
