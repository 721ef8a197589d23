"""From faces to rooms: spatial affinity, external and partial faces, DBSCAN (Algorithm 1, last steps)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import connected_components

from pianta._types import Floats, Mask
from pianta.layout.thesis.faces import Faces


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
    """Faces, shape (F,), that are not external and that no wall divides from an external face.

    free_share: shape (E,), the share of each edge in free space. The printed rule looks at the weight alone; a wall
    that stands beside its line would then be taken for a frontier, so more than half of the edge must be free.
    """
    is_open = (faces.weight < partial_weight) & (free_share > 0.5)
    partial = np.zeros(len(internal), bool)
    for inside, outside in ((faces.first, faces.second), (faces.second, faces.first)):
        partial[inside[is_open & internal[inside] & ~internal[outside]]] = True
    return partial


def cluster_faces(local_affinity: csr_array, *, epsilon: float) -> NDArray[np.int32]:
    """DBSCAN of faces with minPoints = 1, given their local affinity A; the cluster of each face, shape (F,).

    A grows with nearness, so the distance is 1 - max(A_ij, A_ji) between adjacent faces, and infinite between others.
    With minPoints = 1 every face is a core point, and the clusters of DBSCAN are the connected components of the
    graph of all pairs at most epsilon apart.
    """
    symmetric = local_affinity.maximum(local_affinity.T)
    near = csr_array(symmetric >= 1 - epsilon)
    return np.asarray(connected_components(near, directed=False)[1])
