"""Graphs with labels for the tests of kernels: made by hand, drawn by hypothesis, and made at random."""

from random import Random

import networkx as nx
import numpy as np
from hypothesis import strategies as st


def make_path(labels: str) -> nx.Graph:
    """Nodes 0, 1, 2, … in a row, each with a letter."""
    graph = nx.path_graph(len(labels))
    nx.set_node_attributes(graph, dict(enumerate(labels)), "label")
    return graph


def make_plan(size: int, *, seed: int) -> nx.Graph:
    """A tree with some cycles, as rooms make, with labels on nodes and edges and three numbers on each node."""
    random = Random(seed)  # noqa: S311
    graph = nx.Graph((node, random.randrange(node)) for node in range(1, size))
    graph.add_node(0)
    graph.add_edges_from(random.sample(range(size), 2) for _ in range(size // 6))
    for node in graph:
        graph.nodes[node].update(label=random.choice("ABCD"), features=[random.gauss(0, 1) for _ in range(3)])
    nx.set_edge_attributes(graph, {edge: random.choice("xy") for edge in graph.edges}, "door")
    return graph


@st.composite
def labelled_graphs(draw: st.DrawFn, *, max_size: int = 9) -> nx.Graph:
    """Graphs of 0 to `max_size` nodes, of one part or several, with few labels, so that much is alike."""
    size = draw(st.integers(0, max_size))
    graph = nx.empty_graph(size)
    pairs = [(one, other) for other in range(size) for one in range(other)]
    graph.add_edges_from(draw(st.lists(st.sampled_from(pairs), max_size=2 * size)) if pairs else [])
    for node in graph:
        graph.nodes[node].update(label=draw(st.sampled_from("AB")), features=draw(st.tuples(*[st.integers(-2, 2)] * 2)))
    for edge in graph.edges:
        graph.edges[edge]["door"] = draw(st.sampled_from("xy"))
    return graph


def rename(graph: nx.Graph, *, seed: int) -> nx.Graph:
    """An isomorphic copy: other names, nodes and edges in another order, edges turned round."""
    random = Random(seed)  # noqa: S311
    nodes, edges = list(graph.nodes(data=True)), list(graph.edges(data=True))
    random.shuffle(nodes)
    random.shuffle(edges)
    names = dict(zip(graph, random.sample(range(1000), len(graph)), strict=True))
    copy = nx.Graph()
    copy.add_nodes_from((f"room {names[node]}", data) for node, data in nodes)
    copy.add_edges_from((f"room {names[end]}", f"room {names[start]}", data) for start, end, data in edges)
    return copy


def assert_kernel(gram: np.ndarray) -> None:
    """The matrix is symmetric and positive semidefinite."""
    np.testing.assert_array_equal(gram, gram.T)
    assert np.linalg.eigvalsh(gram).min(initial=0) >= -1e-9 * np.abs(gram).max(initial=0)
