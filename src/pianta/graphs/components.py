"""Connected components of graphs whose edges are pairs of node indices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def number_components(pairs: NDArray[np.integer], count: int) -> NDArray[np.intp]:
    """The component of each node, numbered from 0 in the order of their first nodes, shape (count,).

    Hooking and pointer jumping of all trees at once (Shiloach and Vishkin, 1982). scipy.sparse.csgraph does the same,
    but is slow to import.
    pairs: edges, shape (E, 2). count: number of nodes.

    >>> number_components(np.array([[3, 1]]), 4).tolist()
    [0, 1, 2, 1]
    """
    parent = np.arange(count)
    one, other = np.asarray(pairs, np.intp).reshape(-1, 2).T
    while len(one):
        # The root with the greater number becomes a child of the other
        low, high = np.minimum(parent[one], parent[other]), np.maximum(parent[one], parent[other])
        np.minimum.at(parent, high, low)
        # Every node becomes a child of its root
        while not np.array_equal(flat := parent[parent], parent):
            parent = flat
        apart = parent[one] != parent[other]
        one, other = one[apart], other[apart]
    return np.unique(parent, return_inverse=True)[1].astype(np.intp)
