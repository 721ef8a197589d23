"""Connected components of graphs that are given as pairs of numbered nodes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def number_components(pairs: NDArray[np.integer], count: int) -> NDArray[np.intp]:
    """The component of each node, numbered from 0 by their first nodes.

    Trees of nodes hook onto each other and become flat again, all at once (Shiloach and Vishkin, 1982).
    scipy.sparse.csgraph does the same, and is slow to import.

    Parameters
    ----------
    pairs
        Nodes that an edge joins, shape (E, 2).
    count
        Number of nodes N.

    Returns
    -------
    numpy.ndarray
        Shape (N,).

    Examples
    --------
    >>> number_components(np.array([[3, 1]]), 4).tolist()
    [0, 1, 2, 1]

    """
    parent = np.arange(count)
    one, other = np.asarray(pairs, np.intp).reshape(-1, 2).T
    while len(one):
        # The root of the greater number hooks onto the lesser one
        low, high = np.minimum(parent[one], parent[other]), np.maximum(parent[one], parent[other])
        np.minimum.at(parent, high, low)
        # Every node points at its root again
        while not np.array_equal(flat := parent[parent], parent):
            parent = flat
        apart = parent[one] != parent[other]
        one, other = one[apart], other[apart]
    return np.unique(parent, return_inverse=True)[1].astype(np.intp)
