"""Clusters of functional areas that are alike, over all floors (thesis, section 7.3.2)."""

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

# As of the authors for schools, `corr` and `ncut`; where messages swing, more.
DAMPING: Mapping[Segmentation, float] = MappingProxyType({Segmentation.CORR: 0.8, Segmentation.NCUT: 0.7})
MORE_DAMPING = (0.9, 0.97)
# Quantile of the affinities that is the preference. The median is that of the authors, who stop after 100 iterations:
# areas of `corr` then still are in fewer clusters. With a third, they are in as few once the messages have settled.
PREFERENCE: Mapping[Segmentation, float] = MappingProxyType({Segmentation.CORR: 1 / 3, Segmentation.NCUT: 1 / 2})
# Messages have settled when the clusters have been the same for so many iterations.
MAX_ITERATIONS, SETTLED = 3000, 100
# Similarities of areas that are all the same differ by less.
SAME_BELOW = 1e-9


class AreaKernel(StrEnum):
    """By what areas are compared: section 7.3.3 prefers Graph Hopper."""

    GRAPH_HOPPER = "graph hopper"
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

    gram: what `compare_areas` gives. Two areas are alike here when they are alike to the same areas: the affinity is
    minus the squared distance of their rows. With the kernel itself for the affinity there are more clusters than
    section 7.3.3 prints, and several of one area.

    Raises ModelError when the messages do not settle.
    """
    from sklearn.cluster import AffinityPropagation
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.metrics import pairwise_distances

    if np.ptp(gram, axis=0).max(initial=0) < SAME_BELOW:
        return np.zeros(len(gram), np.intp)
    affinities = -(pairwise_distances(gram) ** 2)
    preference = float(np.quantile(affinities, PREFERENCE[segmentation]))
    options = {"max_iter": MAX_ITERATIONS, "convergence_iter": SETTLED, "preference": preference, "random_state": 0}
    with warnings.catch_warnings():
        warnings.simplefilter("error", ConvergenceWarning)
        # Of two areas all similarities are equal.
        warnings.filterwarnings("ignore", "All samples have mutually equal similarities", UserWarning)
        for damping in (DAMPING[segmentation], *MORE_DAMPING):
            messages = AffinityPropagation(damping=damping, affinity="precomputed", **options)
            with suppress(ConvergenceWarning):
                return np.asarray(messages.fit_predict(affinities), np.intp)
    raise ModelError(f"{len(gram)} functional areas form no stable clusters, give more buildings")


def measure_cluster_similarity(gram: NDArray[np.float64], clusters: NDArray[np.intp]) -> NDArray[np.float64]:
    """Mean similarity of the areas of each two clusters, shape (clusters, clusters), as the heat maps of Fig. 7.5."""
    members = np.equal.outer(np.arange(clusters.max(initial=-1) + 1), clusters).astype(np.float64)
    means = members / members.sum(axis=1, keepdims=True)
    similarity: NDArray[np.float64] = means @ gram @ means.T
    return similarity
