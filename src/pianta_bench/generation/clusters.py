"""Clusters of functional areas: how similar the areas of each are to each other, and to those of other clusters."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np

from pianta._types import Floats, Indices
from pianta.generation.area_clusters import measure_cluster_similarity
from pianta_bench.harness.records import Results


@dataclass(frozen=True, eq=False)
class ClusterScores:
    """Similarities of the clusters of a model.

    gram: of all areas, shape (areas, areas). clusters: of each area. similarity: mean of each two clusters, shape
    (clusters, clusters), each area compared with itself too, as in Fig. 7.5.
    intra: mean similarity of two areas of each cluster, nan for a cluster of one. inter: of an area of it and one of
    any other cluster, nan for the only cluster. sizes: areas of each.
    """

    gram: Floats
    clusters: Indices
    similarity: Floats
    intra: Floats
    inter: Floats
    sizes: Indices

    @property
    def loose(self) -> int:
        """Clusters whose areas are not more similar to each other than to those of all other clusters."""
        return int((self.intra <= self.inter).sum())

    @property
    def mixed(self) -> int:
        """Clusters whose areas are as similar to those of one other cluster as to each other."""
        others = self.similarity.copy()
        np.fill_diagonal(others, -np.inf)
        return int((self.intra <= others.max(axis=1)).sum())


def score_gram(gram: Floats, clusters: Indices) -> ClusterScores:
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


def add_cluster_scores(results: Results, part: str, model: str, scores: ClusterScores, *, by_wl: int) -> None:
    """Append the records of a model and of each of its clusters. by_wl: clusters by the Weisfeiler-Lehman kernel."""
    figures = {
        "functional areas": len(scores.clusters),
        "clusters": len(scores.sizes),
        "clusters by WL": by_wl,
        "areas of the smallest cluster": int(scores.sizes.min()),
        "areas of the largest cluster": int(scores.sizes.max()),
        "clusters of one area": int((scores.sizes == 1).sum()),
        "loose clusters": scores.loose,
        "mixed clusters": scores.mixed,
    }
    results.add(part, model, figures)
    for number, (size, intra, inter) in enumerate(zip(scores.sizes, scores.intra, scores.inter, strict=True), 1):
        # The table leaves out clusters of one area.
        several = "cluster" if size > 1 else "cluster of one area"
        similarities = {f"similarity within a {several}": intra, f"similarity of a {several} to others": inter}
        results.add(part, f"cluster {number}", {"areas of the cluster": int(size)})
        results.add(part, f"cluster {number}", {name: keep_finite(value) for name, value in similarities.items()})


def keep_finite(figure: float) -> float | None:
    """The figure, None for infinity and nan."""
    return float(figure) if isfinite(figure) else None
