"""Sets of graphs: validity, copies and discrepancies by hand, and the thesis' samples beside real schools."""

from itertools import product
from math import exp, inf

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import GraphError, OptionError
from pianta.evaluation.graph_sets import (
    STATISTICS,
    DiscrepancyRatio,
    Trial,
    Validity,
    compare_discrepancy,
    describe_statistic,
    draw_trials,
    find_copies,
    find_repeats,
    measure_discrepancy,
    measure_validity,
)
from pianta.labels import SCHOOL
from tests.labelled_graphs import labelled_graphs, make_path, make_plan, rename
from tests.school_graphs import read_samples, read_schools

ONE_APART = 2 - 2 * exp(-1 / 2)


def paint(graph: nx.Graph, label: str = "A") -> nx.Graph:
    nx.set_node_attributes(graph, label, "label")
    return graph


def test_validity():
    graphs = [make_path("AB"), paint(nx.complete_graph(5)), paint(nx.empty_graph(2)), make_path("AC"), nx.path_graph(2)]
    assert measure_validity(graphs, {"A", "B"}) == Validity(connected=4 / 5, planar=4 / 5, labelled=3 / 5)


def test_a_graph_without_nodes_is_not_connected():
    assert measure_validity([nx.Graph()], SCHOOL.by_name) == Validity(connected=0, planar=1, labelled=1)


def test_copies():
    training = [make_path("ABC"), paint(nx.disjoint_union(nx.cycle_graph(3), nx.cycle_graph(3)))]
    assert find_copies([make_path("CBA"), make_path("ACB"), make_path("ABCA"), make_path("AB")], training) == [
        *(True, False),  # the same labels and degrees, at other nodes
        *(False, False),
    ]
    assert find_copies([paint(nx.disjoint_union(nx.cycle_graph(3), nx.cycle_graph(3)))], training) == [True]
    # Each of its nodes has the same neighbourhood as each node of the two rings.
    assert find_copies([paint(nx.cycle_graph(6))], training) == [False]
    assert find_copies([make_path("A")], []) == [False]


def test_repeats():
    graphs = [make_path("ABC"), make_path("BAC"), make_path("CBA"), make_path("AB"), make_path("CAB"), make_path("BA")]
    assert find_repeats(graphs) == [False, False, True, False, True, True]


@pytest.mark.slow
@given(st.lists(labelled_graphs(max_size=4), max_size=4), st.lists(labelled_graphs(max_size=4), max_size=4))
def test_copies_are_the_isomorphic_ones(graphs, training):
    same_label = nx.isomorphism.categorical_node_match("label", None)
    expected = [any(nx.is_isomorphic(graph, other, node_match=same_label) for other in training) for graph in graphs]
    assert find_copies(graphs, training) == expected


@pytest.mark.slow
@given(labelled_graphs(), st.integers(0, 99))
def test_a_renamed_graph_is_a_copy(graph, seed):
    assert find_copies([graph], [rename(graph, seed=seed)]) == [True]
    assert find_repeats([graph, rename(graph, seed=seed)]) == [False, True]


def test_degrees():
    rows = describe_statistic([nx.path_graph(4), nx.star_graph(3), nx.Graph(), nx.empty_graph(1)], "degree")
    assert rows.tolist() == [[0, 1 / 2, 1 / 2, 0], [0, 3 / 4, 0, 1 / 4], [0, 0, 0, 0], [1, 0, 0, 0]]


def test_labels_in_the_order_of_the_alphabet():
    rows = describe_statistic([make_path("HBAB"), make_path("CGDEF")], "labels")
    assert rows.tolist() == [[1 / 4, 1 / 2, 0, 0, 0, 0, 0, 1 / 4], [0, 0, 1 / 5, 1 / 5, 1 / 5, 1 / 5, 1 / 5, 0]]


def test_clustering():
    # A triangle with a tail: of the node in both, one of three pairs of neighbours is joined.
    tailed = nx.Graph([(0, 1), (1, 2), (2, 0), (0, 3)])
    (row,) = describe_statistic([tailed], "clustering")
    assert {index: row[index] for index in np.flatnonzero(row)} == {0: 1 / 4, 33: 1 / 4, 99: 1 / 2}


@pytest.mark.parametrize(
    ("graph", "eigenvalues"),
    [
        (nx.path_graph(2), [0, 2]),
        (nx.complete_graph(3), [0, 1.5, 1.5]),
        (nx.star_graph(4), [0, 1, 1, 1, 2]),
        (nx.empty_graph(2), [0, 0]),
    ],
)
def test_spectrum(graph, eigenvalues):
    (row,) = describe_statistic([graph], "spectrum")
    full = np.zeros(200)
    np.add.at(full, [min(int(value / 2 * 200), 199) for value in eigenvalues], 1 / len(eigenvalues))
    np.testing.assert_allclose(row, full[: len(row)])
    assert full.sum() == pytest.approx(row.sum())


@pytest.mark.parametrize(
    ("statistic", "one", "other", "expected"),
    [
        ("labels", "AB", "CD", ONE_APART),
        ("labels", "AAB", "AB", 2 - 2 * exp(-((1 / 6) ** 2) / 2)),
        ("labels", "AAB", "CBABAA", 2 - 2 * exp(-((1 / 6) ** 2) / 2)),
        ("degree", "AAAA", "AA", 2 - 2 * exp(-((1 / 2) ** 2) / 2)),
    ],
)
def test_discrepancy_of_two_paths(statistic, one, other, expected):
    assert measure_discrepancy([make_path(one)], [make_path(other)], statistic=statistic) == pytest.approx(expected)


def test_discrepancy_of_an_edge_and_a_triangle():
    edge, triangle = [nx.path_graph(2)], [nx.complete_graph(3)]
    assert measure_discrepancy(edge, triangle, statistic="degree") == pytest.approx(ONE_APART)
    assert measure_discrepancy(edge, triangle, statistic="clustering") == pytest.approx(2 - 2 * exp(-50))
    # One half at 0 and one at 2, against one third at 0 and two at 3/2: two thirds have to move.
    assert measure_discrepancy(edge, triangle, statistic="spectrum") == pytest.approx(2 - 2 * exp(-2 / 9))


def test_graphs_are_compared_with_themselves_too():
    # Two of four pairs within the first set are equal, and one of two pairs across the sets.
    one, other = [make_path("A"), make_path("B")], [make_path("A")]
    expected = (2 + 2 * exp(-1 / 2)) / 4 + 1 - 2 * (1 + exp(-1 / 2)) / 2
    assert measure_discrepancy(one, other, statistic="labels") == pytest.approx(expected)


@pytest.mark.parametrize("statistic", STATISTICS)
def test_names_and_order_change_nothing(statistic):
    plans = [make_plan(size, seed=size) for size in range(2, 30)]
    renamed = [rename(plan, seed=1) for plan in plans[::-1]]
    assert measure_discrepancy(plans, renamed, statistic=statistic) == pytest.approx(0, abs=1e-12)
    np.testing.assert_array_equal(describe_statistic(renamed, statistic), describe_statistic(plans, statistic)[::-1])


@pytest.mark.slow
@given(st.lists(labelled_graphs(), min_size=1, max_size=4), st.lists(labelled_graphs(), min_size=1, max_size=4))
def test_discrepancy_by_its_definition(one, other):
    for statistic, width in zip(STATISTICS, (1, 0.1, 1, 1), strict=True):
        rows = describe_statistic([*one, *other], statistic)
        first, second = rows[: len(one)], rows[len(one) :]

        def mean(some: np.ndarray, others: np.ndarray, width: float = width) -> float:
            kernels = [exp(-((abs(x - y).sum() / 2 / width) ** 2) / 2) for x, y in product(some, others)]
            return float(np.mean(kernels))

        expected = mean(first, first) + mean(second, second) - 2 * mean(first, second)
        assert measure_discrepancy(one, other, statistic=statistic) == pytest.approx(expected, abs=1e-12)
        assert measure_discrepancy(one, one, statistic=statistic) == 0


def test_the_ratio_is_that_of_the_means():
    same, half, total = [make_path("AA")], [make_path("AB")], [make_path("BB")]
    trials = [Trial(total, half, same), Trial(same, total, same)]
    half_apart = 2 - 2 * exp(-1 / 8)
    compared = compare_discrepancy(trials, statistic="labels")
    assert (compared.generated, compared.real) == pytest.approx((ONE_APART / 2, (half_apart + ONE_APART) / 2))
    assert compared.ratio == pytest.approx(ONE_APART / (half_apart + ONE_APART))


@pytest.mark.parametrize(("built", "real", "ratio"), [(3, 2, 1.5), (0, 2, 0), (0, 0, 1), (1, 0, inf)])
def test_ratio(built, real, ratio):
    assert DiscrepancyRatio(built, real).ratio == ratio


@pytest.mark.parametrize("count", [6, 7])
def test_trials_split_the_real_graphs(count):
    real, generated = ([make_path(letter)] * count for letter in "AB")
    real, generated = [graph.copy() for graph in real], [graph.copy() for graph in generated]
    trials = draw_trials(generated, real, repeats=20, seed=3)
    assert len(trials) == 20
    for trial in trials:
        assert [len({id(graph) for graph in part}) for part in trial] == [3, 3, 3]
        assert not {id(graph) for graph in trial.half_a} & {id(graph) for graph in trial.half_b}
    for part, drawn_from in zip(zip(*trials, strict=True), (generated, real, real), strict=True):
        assert {id(graph) for graphs in part for graph in graphs} == {id(graph) for graph in drawn_from}
    again, other = (draw_trials(generated, real, repeats=20, seed=seed) for seed in (3, 4))
    assert again == trials
    assert other != trials


def test_floors_of_a_building_are_in_one_half():
    real = [nx.path_graph(2 + number) for number in range(10)]
    buildings = [*"aaabbcdefg"]
    trials = draw_trials(real, real, repeats=30, seed=0, buildings=buildings)
    building = {id(graph): name for graph, name in zip(real, buildings, strict=True)}
    for trial in trials:
        halves = [{building[id(graph)] for graph in half} for half in (trial.half_a, trial.half_b)]
        assert not halves[0] & halves[1]
        assert len(trial.half_a) == len(trial.half_b) == len(trial.generated) >= 4
    assert len({tuple(map(id, trial.half_a)) for trial in trials}) > 20
    with pytest.raises(GraphError, match="building a"):
        draw_trials(real, real, repeats=1, seed=0, buildings=["a"] * 10)


def test_trials_of_a_generator():
    real = [make_path("A" * size) for size in range(1, 9)]
    queries = []

    def make(half, random):
        queries.append(half)
        return [nx.relabel_nodes(graph, {0: int(random.integers(100, 200))}) for graph in half]

    trials = draw_trials(make, real, repeats=5, seed=0)
    assert queries == [trial.half_a for trial in trials]
    for trial in trials:
        assert sorted(map(len, trial.generated)) == sorted(map(len, trial.half_a))
    # The graphs that are made from half A are exactly as far from B as A.
    compared = compare_discrepancy(trials, statistic="labels")
    assert compared.generated == compared.real


@pytest.mark.slow
@pytest.mark.parametrize("statistic", STATISTICS)
def test_graphs_from_one_source_have_a_ratio_near_one(statistic):
    # For a single set of 20 real graphs the ratio varies from 0.1 to 6.
    sources = [[make_plan(10, seed=40 * source + graph) for graph in range(40)] for source in range(40)]
    trials = [draw_trials(plans[:20], plans[20:], repeats=10, seed=0) for plans in sources]
    compared = [compare_discrepancy(trial, statistic=statistic) for trial in trials]
    ratio = np.mean([one.generated for one in compared]) / np.mean([one.real for one in compared])
    assert ratio == pytest.approx(1, abs=0.15)


def test_invalid_sets_of_graphs_are_refused():
    paths = [make_path("A")] * 3
    with pytest.raises(GraphError, match="DiGraph"):
        measure_validity([nx.Graph(), nx.DiGraph()], ())
    for statistic in STATISTICS:
        with pytest.raises(GraphError, match="MultiGraph"):
            describe_statistic([nx.MultiGraph()], statistic)
    for find in (find_repeats, lambda graphs: find_copies(graphs, []), lambda graphs: find_copies([], graphs)):
        with pytest.raises(GraphError, match="label"):
            find([nx.path_graph(2)])
    with pytest.raises(OptionError, match="orbits"):
        measure_discrepancy(paths, paths, statistic="orbits")
    with pytest.raises(GraphError, match="graphs"):
        measure_validity([], ())
    with pytest.raises(GraphError, match="other"):
        measure_discrepancy(paths, [], statistic="degree")


def test_invalid_trials_are_refused():
    paths = [make_path("A")] * 5
    with pytest.raises(GraphError, match="real"):
        draw_trials(paths, paths[:1], repeats=1, seed=0)
    with pytest.raises(GraphError, match="generated"):
        draw_trials(paths[:1], paths, repeats=1, seed=0)
    with pytest.raises(GraphError, match="trials"):
        compare_discrepancy([], statistic="degree")
    with pytest.raises(GraphError, match="half_b"):
        compare_discrepancy([Trial(paths, paths, [])], statistic="degree")
    with pytest.raises(GraphError, match="half"):
        compare_discrepancy([Trial(paths, paths[:2], paths)], statistic="degree")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_the_samples_of_the_thesis_beside_real_schools(data):
    real, samples = read_schools(data), read_samples(data)
    assert measure_validity(samples, SCHOOL.by_name) == measure_validity(real, SCHOOL.by_name) == Validity(1, 1, 1)
    assert not any(find_copies(samples, real))
    assert not any(find_repeats(samples))
    trials = draw_trials(samples, real, repeats=100, seed=0)
    ratios = {statistic: compare_discrepancy(trials, statistic=statistic).ratio for statistic in STATISTICS}
    # The samples have nearly twice as many triangles.
    assert ratios == pytest.approx({"degree": 0.6, "clustering": 1.6, "spectrum": 1.1, "labels": 0.9}, abs=0.15)
