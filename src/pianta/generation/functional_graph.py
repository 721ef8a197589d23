"""Step 2 of section 7.4.3: which functional areas of a new building are joined."""

from __future__ import annotations

from collections.abc import Sequence

import networkx as nx
import numpy as np
import rustworkx as rx

from pianta._types import Floats, Indices, Mask
from pianta.generation.gram_rows import GraphBatch, References
from pianta.generation.metropolis_hastings import accept, choose, draw_uniforms

# λ1 and λ2 of the moves.
GROWTH, DECLINE = 0.1, 0.1
DRAWS = 6
# A graph with fewer independent cycles than K_3,3 is planar (Kuratowski, 1930).
CYCLES_OF_NON_PLANAR = 4


class FunctionalGraphs:
    """The chains of step 2: connected functional graphs Ĥ of n buildings, changed edge by edge.

    references: the functional graphs of the model. graphs: what the chains start from, connected, the areas 0 … with
    their clusters as labels; edges with a true `known` stay. kept: the number of areas of each building, the first
    ones, whose edges stay as they are. closed: these areas have as many edges to others as at the start.
    """

    def __init__(
        self, references: References, graphs: Sequence[nx.Graph], *, kept: int = 0, closed: bool = False
    ) -> None:
        self.batch = GraphBatch(references, graphs)
        self.sizes = self.batch.present.sum(axis=1)
        self.kept, self.closed = kept, kept if closed else 0
        self.costs = self.batch.measure_costs()
        self._known = np.zeros(self.batch.adjacency.shape, bool)
        self._known[:, :kept, :kept] = True
        for chain, graph in enumerate(graphs):
            for one, other, is_known in graph.edges(data="known"):
                self._known[chain, [one, other], [other, one]] |= bool(is_known)
        # Kept areas may be joined by bridges.
        self._flat = np.array([is_planar([*graph.edges], len(graph)) for graph in graphs])

    def move(self, uniforms: Floats) -> None:
        """T2 on each chain: ADD or REMOVE an edge, or SWAP one end of it; uniforms: shape (n, DRAWS)."""
        free = self._list_free_edges()
        edges = self.batch.adjacency.sum(axis=(1, 2)) / 2
        # As in method-notes.md, ε has its sign back.
        adding = 1 - np.exp(-GROWTH * self.sizes / np.maximum(edges, 1))
        removing = (1 - adding) * (1 - np.exp(-DECLINE * edges / self.sizes))
        adds = uniforms[:, 0] < adding
        removes = ~adds & (uniforms[:, 0] < adding + removing)
        swaps = ~adds & ~removes
        ones, others = _choose_edges(free, uniforms[:, 1])
        ones, others = np.where((uniforms[:, 2] < 1 / 2) | (ones < self.closed), (ones, others), (others, ones))
        targets = choose(uniforms[:, 3], self.sizes)
        sources = np.where(swaps, ones, choose(uniforms[:, 4], self.sizes))
        existing = free.any(axis=(1, 2))
        every = np.arange(len(edges))
        possible: Mask = (sources != targets) & ~self.batch.adjacency[every, sources, targets]
        possible &= (sources >= self.kept) | (targets >= self.kept)
        possible &= (targets >= self.closed) & (swaps | (sources >= self.closed))
        possible = np.asarray(np.where(adds, possible, existing & (np.where(removes, ones >= self.closed, possible))))
        taken, given = possible & ~adds, possible & ~removes
        chains = np.concatenate([every[taken], every[given]])
        ends = np.concatenate([ones[taken], sources[given]]), np.concatenate([others[taken], targets[given]])
        present = np.repeat([False, True], [taken.sum(), given.sum()])
        self.batch.change_edges(chains, *ends, present=present)
        costs = self.batch.measure_costs()
        costs[taken] = np.where(self._are_connected(taken), costs[taken], np.inf)
        costs[~self._are_planar(given)] = np.inf
        stays = possible & ~accept(self.costs, costs, uniforms[:, 5])
        back = stays[chains]
        self.batch.change_edges(chains[back], ends[0][back], ends[1][back], present=~present[back])
        self.costs = np.where(possible & ~stays, costs, self.costs)

    def to_graphs(self) -> list[nx.Graph]:
        """The graphs as they are now, without labels."""
        pairs = zip(self.batch.adjacency, self.sizes.tolist(), strict=True)
        return [nx.from_numpy_array(adjacency[:size, :size], edge_attr=None) for adjacency, size in pairs]

    def _list_free_edges(self) -> Mask:
        """Edges that may go, shape (n, nodes, nodes), each once."""
        return np.triu(self.batch.adjacency & ~self._known)

    def _are_connected(self, chosen: Mask) -> Mask:
        """Which of the chosen graphs are in one part, shape (chosen,)."""
        adjacency, present = self.batch.adjacency[chosen], self.batch.present[chosen]
        reached = np.zeros(present.shape, bool)
        reached[:, 0] = True
        while True:
            further = reached | (adjacency & reached[:, None, :]).any(axis=2)
            if (further == reached).all():
                return np.asarray((reached | ~present).all(axis=1))
            reached = further

    def _are_planar(self, given: Mask) -> Mask:
        """Which graphs are planar, of those that got an edge and were so at first; the others are taken for planar."""
        planar = np.ones(len(given), bool)
        cycles = self.batch.adjacency.sum(axis=(1, 2)) // 2 - self.sizes + 1
        for chain in np.flatnonzero(given & self._flat & (cycles >= CYCLES_OF_NON_PLANAR)).tolist():
            planar[chain] = is_planar(
                np.argwhere(np.triu(self.batch.adjacency[chain])).tolist(), int(self.sizes[chain])
            )
        return planar


def is_planar(edges: Sequence[Sequence[int]], nodes: int, *, parts: int = 1) -> bool:
    """Whether a graph can be drawn without crossings, as a floor's can where no passage bridges another.

    parts: how many parts it falls into, or more.
    """
    # Each edge beyond those of a tree for each part closes a cycle.
    if len(edges) - nodes + parts < CYCLES_OF_NON_PLANAR:
        return True
    graph: rx.PyGraph[None, None] = rx.PyGraph()
    graph.extend_from_edge_list([(one, other) for one, other in edges])
    return bool(rx.is_planar(graph))


def draw_start(labels: Sequence[str], generator: np.random.Generator, *, kept: nx.Graph | None = None) -> nx.Graph:
    """A random connected graph to start from: each area is joined to one of those before it.

    kept: joins the first areas as it does.
    """
    graph = nx.Graph()
    graph.add_nodes_from((place, {"label": label}) for place, label in enumerate(labels))
    if kept is not None:
        graph.add_edges_from(kept.edges)
    first = 1 if kept is None else len(kept)
    graph.add_edges_from((place, int(generator.integers(place))) for place in range(first, len(labels)))
    return graph


def sample_functional_graphs(
    chains: FunctionalGraphs,
    generators: Sequence[np.random.Generator],
    *,
    moves: int,
    traces: list[Floats] | None = None,
) -> list[nx.Graph]:
    """Run the chains for so many moves: the functional graphs of the buildings.

    traces: gets the costs after each move.
    """
    draws = draw_uniforms(generators, DRAWS)
    for _ in range(moves):
        chains.move(next(draws))
        if traces is not None:
            traces.append(chains.costs)
    return chains.to_graphs()


def draw_door_counts(graph: nx.Graph, counts: Sequence[int], generator: np.random.Generator) -> None:
    """Give each edge of Ĥ without one a number of `cuts`, as often as the functional graphs of a model have it.

    The thesis makes one door for each edge; real areas are often joined by more, which are the cycles of a building.
    """
    for one, other in sorted((min(edge), max(edge)) for edge in graph.edges):
        graph.edges[one, other].setdefault("cuts", counts[int(generator.integers(len(counts)))])


def _choose_edges(edges: Mask, draws: Floats) -> tuple[Indices, Indices]:
    """An edge of each graph, as the places of its ends; any where there is none."""
    flat = edges.reshape(len(edges), -1)
    wanted = choose(draws, flat.sum(axis=1)) + 1
    found = (np.cumsum(flat, axis=1) < wanted[:, None]).sum(axis=1)
    found = np.minimum(found, flat.shape[1] - 1)
    return found // edges.shape[1], found % edges.shape[1]
