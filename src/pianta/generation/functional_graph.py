"""Step 2 of section 7.4.3: the edges between the functional areas of a new building."""

from __future__ import annotations

from collections.abc import Sequence

import networkx as nx
import numpy as np
import rustworkx as rx

from pianta._types import Floats, Indices, Mask
from pianta.generation.hopper_gram import HopperReferences
from pianta.generation.incremental_gram import ReferenceGraphs
from pianta.generation.metropolis_hastings import accept, choose, draw_uniforms

# λ1 and λ2 of the moves: the authors' values (method-notes.md).
LAMBDA_ADD = 0.1
LAMBDA_REMOVE = 0.1
# Random numbers of a move.
DRAWS = 6
# A graph with fewer independent cycles than K_3,3 is planar (Kuratowski, 1930).
CYCLES_OF_NON_PLANAR = 4


class FunctionalGraphs:
    """The chains of step 2: connected functional graphs Ĥ of n buildings, changed edge by edge.

    references: the functional graphs of the model. graphs: the start of each chain, connected, the areas 0 … with their
    clusters as labels; edges with a true `known` are fixed. n_fixed: number of fixed areas, the first ones of each
    building, whose edges to each other are fixed. closed: the number of their edges to other areas is fixed, too.
    """

    def __init__(
        self,
        references: ReferenceGraphs | HopperReferences,
        graphs: Sequence[nx.Graph],
        *,
        n_fixed: int = 0,
        closed: bool = False,
    ) -> None:
        self.batch = references.start(graphs)
        self.sizes = self.batch.present.sum(axis=1)
        self.n_fixed, self.n_closed = n_fixed, n_fixed if closed else 0
        self.costs = self.batch.measure_costs()
        self._fixed = np.zeros(self.batch.adjacency.shape, bool)
        self._fixed[:, :n_fixed, :n_fixed] = True
        for chain, graph in enumerate(graphs):
            for one, other, is_known in graph.edges(data="known"):
                self._fixed[chain, [one, other], [other, one]] |= bool(is_known)
        # Fixed areas may be connected by bridges.
        self._starts_planar = np.array([is_planar([*graph.edges], len(graph)) for graph in graphs])

    def move(self, uniforms: Floats) -> None:
        """T2 on each chain: ADD an edge, REMOVE one, or SWAP one end of it; uniforms: shape (n, DRAWS)."""
        free = self._list_free_edges()
        edges = self.batch.adjacency.sum(axis=(1, 2)) / 2
        # ε with the sign that is missing in the thesis (method-notes.md).
        adding = 1 - np.exp(-LAMBDA_ADD * self.sizes / np.maximum(edges, 1))
        removing = (1 - adding) * (1 - np.exp(-LAMBDA_REMOVE * edges / self.sizes))
        adds = uniforms[:, 0] < adding
        removes = ~adds & (uniforms[:, 0] < adding + removing)
        swaps = ~adds & ~removes
        ones, others = _choose_edges(free, uniforms[:, 1])
        ones, others = np.where((uniforms[:, 2] < 1 / 2) | (ones < self.n_closed), (ones, others), (others, ones))
        targets = choose(uniforms[:, 3], self.sizes)
        sources = np.where(swaps, ones, choose(uniforms[:, 4], self.sizes))
        existing = free.any(axis=(1, 2))
        every = np.arange(len(edges))
        possible: Mask = (sources != targets) & ~self.batch.adjacency[every, sources, targets]
        possible &= (sources >= self.n_fixed) | (targets >= self.n_fixed)
        possible &= (targets >= self.n_closed) & (swaps | (sources >= self.n_closed))
        possible = np.asarray(np.where(adds, possible, existing & (np.where(removes, ones >= self.n_closed, possible))))
        loses, gains = possible & ~adds, possible & ~removes
        chains = np.concatenate([every[loses], every[gains]])
        ends = np.concatenate([ones[loses], sources[gains]]), np.concatenate([others[loses], targets[gains]])
        present = np.repeat([False, True], [loses.sum(), gains.sum()])
        self.batch.change_edges(chains, *ends, present=present)
        costs = self.batch.measure_costs()
        costs[loses] = np.where(self._are_connected(loses), costs[loses], np.inf)
        costs[~self._are_planar(gains)] = np.inf
        stays = possible & ~accept(self.costs, costs, uniforms[:, 5])
        back = stays[chains]
        self.batch.change_edges(chains[back], ends[0][back], ends[1][back], present=~present[back])
        self.costs = np.where(possible & ~stays, costs, self.costs)

    def to_graphs(self) -> list[nx.Graph]:
        """The graphs as they are now, without labels."""
        pairs = zip(self.batch.adjacency, self.sizes.tolist(), strict=True)
        return [nx.from_numpy_array(adjacency[:size, :size], edge_attr=None) for adjacency, size in pairs]

    def _list_free_edges(self) -> Mask:
        """Edges that may be removed, shape (n, nodes, nodes), each once."""
        return np.triu(self.batch.adjacency & ~self._fixed)

    def _are_connected(self, chosen: Mask) -> Mask:
        """Which of the chosen graphs are connected, shape (chosen,)."""
        adjacency, present = self.batch.adjacency[chosen], self.batch.present[chosen]
        reached = np.zeros(present.shape, bool)
        reached[:, 0] = True
        while True:
            further = reached | (adjacency & reached[:, None, :]).any(axis=2)
            if (further == reached).all():
                return np.asarray((reached | ~present).all(axis=1))
            reached = further

    def _are_planar(self, changed: Mask) -> Mask:
        """Which graphs are planar; graphs that did not change, or started non-planar, count as planar."""
        planar = np.ones(len(changed), bool)
        cycles = self.batch.adjacency.sum(axis=(1, 2)) // 2 - self.sizes + 1
        for chain in np.flatnonzero(changed & self._starts_planar & (cycles >= CYCLES_OF_NON_PLANAR)).tolist():
            planar[chain] = is_planar(
                np.argwhere(np.triu(self.batch.adjacency[chain])).tolist(), int(self.sizes[chain])
            )
        return planar


def is_planar(edges: Sequence[Sequence[int]], nodes: int, *, parts: int = 1) -> bool:
    """Whether a graph is planar, as the graph of a floor without bridges is.

    parts: upper limit of the number of connected components.
    """
    # Each edge beyond those of a spanning forest closes a cycle.
    if len(edges) - nodes + parts < CYCLES_OF_NON_PLANAR:
        return True
    graph: rx.PyGraph[None, None] = rx.PyGraph()
    graph.extend_from_edge_list([(one, other) for one, other in edges])
    return bool(rx.is_planar(graph))


def draw_start(labels: Sequence[str], generator: np.random.Generator, *, fixed: nx.Graph | None = None) -> nx.Graph:
    """A random connected graph as the start of a chain: each area is connected to an earlier one.

    fixed: the edges of the first areas.
    """
    graph = nx.Graph()
    graph.add_nodes_from((index, {"label": label}) for index, label in enumerate(labels))
    if fixed is not None:
        graph.add_edges_from(fixed.edges)
    first = 1 if fixed is None else len(fixed)
    graph.add_edges_from((index, int(generator.integers(index))) for index in range(first, len(labels)))
    return graph


def sample_functional_graphs(
    chains: FunctionalGraphs,
    generators: Sequence[np.random.Generator],
    *,
    moves: int,
    traces: list[Floats] | None = None,
) -> list[nx.Graph]:
    """Run the chains for a number of moves; traces: receives the costs after each move."""
    draws = draw_uniforms(generators, DRAWS)
    for _ in range(moves):
        chains.move(next(draws))
        if traces is not None:
            traces.append(chains.costs)
    return chains.to_graphs()


def draw_door_counts(graph: nx.Graph, counts: Sequence[int], generator: np.random.Generator) -> None:
    """Draw the number of doors, `cuts`, of each edge of Ĥ that has none yet, from the counts of a model.

    The thesis makes one door for each edge; real areas often have more doors, which are the cycles of a building.
    """
    for one, other in sorted((min(edge), max(edge)) for edge in graph.edges):
        graph.edges[one, other].setdefault("cuts", counts[int(generator.integers(len(counts)))])


def _choose_edges(edges: Mask, draws: Floats) -> tuple[Indices, Indices]:
    """A random edge of each graph, as its two nodes; any two nodes if the graph has no edge."""
    flat = edges.reshape(len(edges), -1)
    ranks = choose(draws, flat.sum(axis=1)) + 1
    chosen = (np.cumsum(flat, axis=1) < ranks[:, None]).sum(axis=1)
    chosen = np.minimum(chosen, flat.shape[1] - 1)
    return chosen // edges.shape[1], chosen % edges.shape[1]
