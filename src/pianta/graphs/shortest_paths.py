"""Shortest paths of graphs that are arrays: which nodes are near, how far they are, and how many paths lead there.

Breadth first, from all nodes at once: each step of all searches is a few operations of numpy.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pianta._types import Floats, Indices


@dataclass(frozen=True, eq=False)
class Adjacency:
    """The edges of an undirected graph of n nodes, m in number.

    Parameters
    ----------
    n : int
        The number of nodes, which are 0 … n - 1.
    starts, ends : Indices, shape (2m,)
        Each edge from both of its ends.

    """

    n: int
    starts: Indices
    ends: Indices

    def leave(self, nodes: Indices) -> tuple[Indices, Indices]:
        """All edges from some nodes: the place in `nodes` from which each goes, and its place in `starts` and `ends`.

        Those from one node stand together, in the order in which the nodes are given.
        """
        degrees = self._degrees[nodes]
        firsts = self._firsts[nodes] - (np.cumsum(degrees) - degrees)
        return np.repeat(np.arange(len(nodes)), degrees), self._order[
            np.repeat(firsts, degrees) + np.arange(degrees.sum())
        ]

    @cached_property
    def _order(self) -> Indices:
        """The edges by their starts."""
        return np.argsort(self.starts, kind="stable")

    @cached_property
    def _degrees(self) -> Indices:
        return np.bincount(self.starts, minlength=self.n)

    @cached_property
    def _firsts(self) -> Indices:
        """Where the edges of each node begin in `_order`."""
        return np.cumsum(self._degrees) - self._degrees


@dataclass(frozen=True, eq=False)
class NearPairs:
    """Pairs of nodes that are near each other, by root and then by node, p in number.

    roots, nodes: shape (p,): a node, and one that is near it. steps: edges between them, shape (p,).
    """

    roots: Indices
    nodes: Indices
    steps: Indices


def find_near(edges: Adjacency, reach: int) -> NearPairs:
    """All pairs of nodes with a path of at most `reach` edges between them, a node and itself included.

    Takes memory for these pairs only, whatever the size of the graph.
    """
    # A pair is one number: root n + node.
    before, here = np.zeros(0, np.intp), np.arange(edges.n) * (edges.n + 1)
    levels = [here]
    while len(here) and len(levels) <= reach:
        origins, gone = edges.leave(here % max(edges.n, 1))
        there = np.unique(here[origins] // max(edges.n, 1) * edges.n + edges.ends[gone])
        # What is next to a level lies on it, on the one before, or on the one after.
        seen = np.isin(there, here, assume_unique=True) | np.isin(there, before, assume_unique=True)
        before, here = here, there[~seen]
        levels.append(here)
    pairs = np.concatenate(levels)
    order = np.argsort(pairs)
    steps = np.repeat(np.arange(len(levels)), [len(level) for level in levels])
    return NearPairs(*divmod(pairs[order], max(edges.n, 1)), steps[order])


@dataclass(frozen=True, eq=False)
class ShortestPaths:
    """All shortest paths of a graph of n nodes.

    Parameters
    ----------
    distances : Floats, shape (n, n)
        Edges on a shortest path, infinite where there is none.
    counts : Floats, shape (n, n)
        How many shortest paths there are, from a root to a node.
    arcs : list of pairs of Indices
        By length of the paths: the last edges of shortest paths, from and to pairs root n + node.

    """

    distances: Floats
    counts: Floats
    arcs: list[tuple[Indices, Indices]]

    def measure_betweenness(self) -> Floats:
        """Over all other nodes, the sum of the shares of shortest paths to them that lead through a node, shape (n,).

        Each path counts from both of its ends (Brandes, 2001).
        """
        counts, through = self.counts.ravel(), np.zeros(self.counts.size)
        for tails, heads in reversed(self.arcs):
            np.add.at(through, tails, counts[tails] / counts[heads] * (1 + through[heads]))
        table = through.reshape(self.counts.shape)
        # A path does not lead through the node where it begins.
        return np.asarray(table.sum(axis=0) - table.diagonal())


def find_shortest_paths(edges: Adjacency) -> ShortestPaths:
    """All shortest paths of a graph, in memory that grows with the square of its nodes."""
    distances, counts = np.full(edges.n**2, np.inf), np.zeros(edges.n**2)
    here = np.arange(edges.n) * (edges.n + 1)
    distances[here], counts[here] = 0, 1
    last = np.zeros(edges.n**2, np.intp)
    arcs: list[tuple[Indices, Indices]] = []
    while len(here):
        origins, gone = edges.leave(here % edges.n)
        tails = here[origins]
        heads = tails // edges.n * edges.n + edges.ends[gone]
        new = np.isinf(distances[heads])
        tails, heads = tails[new], heads[new]
        distances[heads] = len(arcs) + 1
        np.add.at(counts, heads, counts[tails])
        arcs.append((tails, heads))
        # Each pair that was reached once: where it stands last.
        last[heads] = np.arange(len(heads))
        here = heads[last[heads] == np.arange(len(heads))]
    shape = edges.n, edges.n
    return ShortestPaths(distances.reshape(shape), counts.reshape(shape), arcs)
