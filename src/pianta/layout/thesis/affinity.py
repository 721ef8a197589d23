"""From faces to rooms: spatial affinity, external and partial faces, DBSCAN (Algorithm 1, last steps)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import connected_components

from pianta._types import Floats, Indices, Mask
from pianta.layout.thesis.faces import Faces

# Share of an edge to an external face that must be free space for the face to be partial (chosen by hand).
MIN_FREE_SHARE = 0.5


def compute_affinity_matrix(faces: Faces, *, sigma: float) -> csr_array:
    """L ← computeAffinityMatrix(F): exp(-w / σ) between adjacent faces, 1 on the diagonal; sparse, shape (F, F)."""
    count = len(faces.polygons)
    affinity = np.exp(-faces.weight / sigma)
    rows = np.concatenate([faces.first, faces.second, np.arange(count)])
    cols = np.concatenate([faces.second, faces.first, np.arange(count)])
    return csr_array((np.concatenate([affinity, affinity, np.ones(count)]), (rows, cols)), shape=(count, count))


def normalise_affinity(affinity: csr_array) -> csr_array:
    """A = D⁻¹ L with D = diag(Σ_j L_ij): the local affinity of each face to its neighbours; shape (F, F)."""
    return csr_array(diags_array(1.0 / affinity.sum(axis=1)) @ affinity)


def find_partial_faces(faces: Faces, internal: Mask, free_share: Floats, *, partial_weight: float) -> Mask:
    """Internal faces that no wall separates from an external face, shape (F,).

    free_share: shape (E,), the share of each edge in free space. The rule of the thesis uses the weight alone; a wall
    beside its line would then count as a frontier, so more than half of the edge must be free.
    """
    is_open = (faces.weight < partial_weight) & (free_share > MIN_FREE_SHARE)
    partial = np.zeros(len(internal), bool)
    for inside, outside in ((faces.first, faces.second), (faces.second, faces.first)):
        partial[inside[is_open & internal[inside] & ~internal[outside]]] = True
    return partial


def cluster_faces(local_affinity: csr_array, *, epsilon: float) -> Indices:
    """DBSCAN of faces with minPoints = 1, given their local affinity A; the cluster of each face, shape (F,).

    A is a similarity, so the distance is 1 - max(A_ij, A_ji) between adjacent faces, and infinite between others.
    With minPoints = 1 every face is a core point, and the clusters of DBSCAN are the connected components of the
    graph of all pairs at most epsilon apart.
    """
    symmetric = local_affinity.maximum(local_affinity.T)
    near = csr_array(symmetric >= 1 - epsilon)
    return np.asarray(connected_components(near, directed=False)[1], np.intp)
