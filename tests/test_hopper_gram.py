"""Rows of the Graph Hopper Gram matrix of changing graphs: equal to the kernel, and computed once for each graph."""

import networkx as nx
import numpy as np
import pytest

from pianta._types import Floats
from pianta.generation.hopper_gram import HopperReferences
from pianta.generation.incremental_gram import ALPHA, PUBLISHED_FLOORS
from pianta.graphs.graph_hopper import GraphHopper


def make_path(labels: str) -> nx.Graph:
    graph = nx.path_graph(len(labels))
    nx.set_node_attributes(graph, dict(enumerate(labels)), "label")
    return graph


REFERENCES = [make_path("AAB"), make_path("ABAB")]


def test_rows_equal_those_of_the_kernel():
    graphs = [make_path("AAB"), make_path("BBBA")]
    gram = HopperReferences(REFERENCES).start(graphs)
    assert gram.measure_similarity() == pytest.approx(GraphHopper().fit(REFERENCES).compare(graphs))
    gram.change_edges(np.array([1, 1]), np.array([0, 2]), np.array([3, 3]), present=np.array([True, False]))
    graphs[1].add_edge(0, 3)
    graphs[1].remove_edge(2, 3)
    assert gram.measure_similarity() == pytest.approx(GraphHopper().fit(REFERENCES).compare(graphs))


def test_costs():
    """The row of a reference is (1, k): the mean distance is that to the other reference, halved."""
    similarity = GraphHopper().fit(REFERENCES).compare(REFERENCES)[0, 1]
    (cost,) = HopperReferences(REFERENCES).start(REFERENCES[:1]).measure_costs()
    assert cost == pytest.approx(ALPHA * PUBLISHED_FLOORS * np.sqrt(2 - 2 * similarity) / 2)


def test_a_rejected_move_needs_no_new_row(monkeypatch):
    gram = HopperReferences(REFERENCES).start([make_path("AABB"), make_path("BA")])
    before = gram.measure_similarity()
    compared: list[int] = []
    compare = gram._kernel.compare

    def count_and_compare(graphs: list[nx.Graph]) -> Floats:
        compared.append(len(graphs))
        return compare(graphs)

    monkeypatch.setattr(gram._kernel, "compare", count_and_compare)
    edge = np.array([0]), np.array([0]), np.array([3])
    gram.change_edges(*edge, present=True)
    assert (gram.measure_similarity()[0] != before[0]).any()
    gram.change_edges(*edge, present=False)
    assert (gram.measure_similarity() == before).all()
    assert compared == [1]
