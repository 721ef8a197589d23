"""Connected components: numbered by their first nodes, as scipy.sparse.csgraph numbers them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from pianta.graphs.components import number_components


def test_components_are_numbered_by_their_first_nodes() -> None:
    # 0-4-2 and 1-3 are joined, 5 is alone.
    assert number_components(np.array([[4, 2], [3, 1], [0, 4]]), 6).tolist() == [0, 1, 0, 1, 0, 2]


def test_a_long_chain_in_any_order() -> None:
    order = np.random.default_rng(0).permutation(1000)
    assert number_components(np.column_stack([order[:-1], order[1:]]), 1000).tolist() == [0] * 1000


def test_no_pair_and_no_node() -> None:
    assert number_components(np.zeros((0, 2), int), 3).tolist() == [0, 1, 2]
    assert number_components(np.zeros((0, 2), int), 0).tolist() == []


@given(st.integers(1, 12).flatmap(lambda n: st.tuples(st.just(n), st.lists(st.tuples(*[st.integers(0, n - 1)] * 2)))))
def test_scipy_finds_the_same(graph: tuple[int, list[tuple[int, int]]]) -> None:
    count, edges = graph
    pairs = np.array(edges, int).reshape(-1, 2)
    matrix = coo_array((np.ones(len(pairs)), pairs.T), shape=(count, count))
    assert number_components(pairs, count).tolist() == connected_components(matrix, directed=False)[1].tolist()
