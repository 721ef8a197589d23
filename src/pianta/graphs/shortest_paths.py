"""Shortest paths of graphs as arrays: nearby nodes, distances, and numbers of paths.

Breadth-first search from all nodes at once: each level of all searches takes a few operations of numpy.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pianta._types import Floats, Indices


@dataclass(frozen=True, eq=False)
class Adjacency:
    """An undirected graph of nodes 0 … n - 1 with m edges.

    starts, ends: the nodes of each edge, in both directions, shape (2m,).
    """

    n: int
    starts: Indices
    ends: Indices

    def leave(self, nodes: Indices) -> tuple[Indices, Indices]:
        """All edges from some nodes: the index of the start in `nodes`, and the index in `starts` and `ends`.

        Edges are in the order of `nodes`.
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
        """The index in `_order` of the first edge of each node."""
        return np.cumsum(self._degrees) - self._degrees


@dataclass(frozen=True, eq=False)
class NearPairs:
    """Pairs of nodes that are near each other, sorted by root and then by node.

    roots, nodes: of each pair, shape (p,). steps: edges between them, shape (p,).
    """

    roots: Indices
    nodes: Indices
    steps: Indices


def find_near(edges: Adjacency, reach: int) -> NearPairs:
    """All pairs of nodes with a path of at most `reach` edges between them, a node and itself included.

    Takes memory only for these pairs, whatever the size of the graph.
    """
    # A pair is one number: root n + node.
    before, here = np.zeros(0, np.intp), np.arange(edges.n) * (edges.n + 1)
    levels = [here]
    while len(here) and len(levels) <= reach:
        origins, taken_edges = edges.leave(here % max(edges.n, 1))
        there = np.unique(here[origins] // max(edges.n, 1) * edges.n + edges.ends[taken_edges])
        # Neighbours of a level are in it, in the one before, or in the one after.
        visited = np.isin(there, here, assume_unique=True) | np.isin(there, before, assume_unique=True)
        before, here = here, there[~visited]
        levels.append(here)
    pairs = np.concatenate(levels)
    order = np.argsort(pairs)
    steps = np.repeat(np.arange(len(levels)), [len(level) for level in levels])
    return NearPairs(*divmod(pairs[order], max(edges.n, 1)), steps[order])


@dataclass(frozen=True, eq=False)
class ShortestPaths:
    """All shortest paths of a graph of n nodes.

    distances: lengths, infinite without a path, shape (n, n). counts: numbers of shortest paths, shape (n, n).
    arcs: by length, the last edges of the paths, from and to pairs root n + node.
    """

    distances: Floats
    counts: Floats
    arcs: list[tuple[Indices, Indices]]

    def measure_betweenness(self) -> Floats:
        """Sum over pairs of other nodes of the share of their shortest paths through a node, shape (n,).

        Each pair counts in both directions (Brandes, 2001).
        """
        counts, through = self.counts.ravel(), np.zeros(self.counts.size)
        for tails, heads in reversed(self.arcs):
            np.add.at(through, tails, counts[tails] / counts[heads] * (1 + through[heads]))
        table = through.reshape(self.counts.shape)
        # The start of a path does not count.
        return np.asarray(table.sum(axis=0) - table.diagonal())


def find_shortest_paths(edges: Adjacency) -> ShortestPaths:
    """All shortest paths of a graph, in memory that grows with the square of its nodes."""
    distances, counts = np.full(edges.n**2, np.inf), np.zeros(edges.n**2)
    here = np.arange(edges.n) * (edges.n + 1)
    distances[here], counts[here] = 0, 1
    last = np.zeros(edges.n**2, np.intp)
    arcs: list[tuple[Indices, Indices]] = []
    while len(here):
        origins, taken_edges = edges.leave(here % edges.n)
        tails = here[origins]
        heads = tails // edges.n * edges.n + edges.ends[taken_edges]
        new = np.isinf(distances[heads])
        tails, heads = tails[new], heads[new]
        distances[heads] = len(arcs) + 1
        np.add.at(counts, heads, counts[tails])
        arcs.append((tails, heads))
        # Each new pair once: the last of its occurrences.
        last[heads] = np.arange(len(heads))
        here = heads[last[heads] == np.arange(len(heads))]
    shape = edges.n, edges.n
    return ShortestPaths(distances.reshape(shape), counts.reshape(shape), arcs)
