"""Connected components of graphs that are given as pairs of numbered nodes."""

from __future__ import annotations

import numpy as np
import rustworkx as rx
from numpy.typing import NDArray


def number_components(pairs: NDArray[np.integer], count: int) -> NDArray[np.intp]:
    """The component of each node, numbered from 0 by their first nodes.

    rustworkx is imported for other reasons too; scipy.sparse.csgraph does the same and takes 50 ms to import.

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
    graph = rx.PyGraph(multigraph=True)
    graph.add_nodes_from(range(count))
    graph.add_edges_from_no_data(list(map(tuple, np.asarray(pairs).tolist())))
    numbers = np.zeros(count, np.intp)
    for number, nodes in enumerate(sorted(rx.connected_components(graph), key=min)):
        numbers[list(nodes)] = number
    return numbers
