"""Functional areas: small floors by both segmentations, and properties for any graph."""

from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.generation.functional_areas import (
    Segmentation,
    build_functional_graph,
    find_cuts,
    find_functional_areas,
    segment_by_corridors,
    segment_by_normalized_cut,
)
from pianta.generation.type_model import learn_type
from pianta.labels import SCHEMAS
from tests.generated_types import build_floor
from tests.labelled_graphs import make_plan
from tests.school_graphs import read_schools

# Section 7.3.3, of 50 schools.
PRINTED_AREAS = {Segmentation.CORR: 287 / 50, Segmentation.NCUT: 207 / 50}
# Two rings of five rooms; 4 and 5 are the door between them.
RINGS = nx.Graph([*pairwise([0, 1, 2, 3, 4, 0]), *pairwise([5, 6, 7, 8, 9, 5]), (4, 5)])


def sort_areas(areas) -> list[list[int]]:
    return sorted(sorted(area) for area in areas)


@st.composite
def plans(draw):
    """A connected graph, and some of its nodes for corridors."""
    graph = make_plan(draw(st.integers(1, 24)), seed=draw(st.integers(0, 10**6)))
    graph.remove_edges_from(nx.selfloop_edges(graph))
    return graph, draw(st.sets(st.sampled_from(sorted(graph))))


def test_each_room_goes_to_its_nearest_corridor():
    # Corridors 0 and 3, one behind the other room of the other.
    graph = nx.path_graph(5)
    assert segment_by_corridors(graph, {0, 3}) == (frozenset({0, 1}), frozenset({2, 3, 4}))


def test_a_tie_goes_to_the_corridor_of_higher_degree():
    # Room 1 is between the corridors 0 and 2; corridor 2 has one room more.
    graph = nx.path_graph(4)
    graph.add_edge(0, 4)
    graph.add_edge(2, 5)
    assert segment_by_corridors(graph, {0, 2}) == (frozenset({0, 4}), frozenset({1, 2, 3, 5}))


@pytest.mark.parametrize(("order", "hub"), [([0, 1, 2, 3, 4], 0), ([2, 1, 0, 3, 4], 2)])
def test_a_tie_of_degrees_goes_to_the_first_corridor(order, hub):
    graph = nx.Graph()
    graph.add_nodes_from(order)
    graph.add_edges_from([(0, 1), (1, 2), (0, 3), (2, 4)])
    (with_room,) = (area for area in segment_by_corridors(graph, {0, 2}) if 1 in area)
    assert hub in with_room


def test_the_nearest_counts_before_the_degree():
    # Room 2 is one door from corridor 1, two from corridor 4 with its many rooms.
    graph = nx.Graph([(1, 2), (2, 3), (3, 4), (4, 5), (4, 6), (4, 7)])
    assert segment_by_corridors(graph, {1, 4}) == (frozenset({1, 2}), frozenset({3, 4, 5, 6, 7}))


def test_a_corridor_without_rooms_joins_the_nearest_that_has_some():
    # Corridors 0 - 1 - 2 in a row, rooms at both ends, more of them at 2.
    graph = nx.Graph([(0, 1), (1, 2), (0, 3), (2, 4), (2, 5)])
    assert segment_by_corridors(graph, {0, 1, 2}) == (frozenset({0, 3}), frozenset({1, 2, 4, 5}))


@pytest.mark.parametrize("corridors", [set(), {0, 1, 2, 3}])
def test_only_rooms_or_only_corridors_are_one_area(corridors):
    assert segment_by_corridors(nx.path_graph(4), corridors) == (frozenset(range(4)),)


def test_areas_are_in_the_order_of_their_first_nodes():
    graph = nx.Graph()
    graph.add_nodes_from([5, 4, 3, 2, 1, 0])
    graph.add_edges_from([(5, 0), (4, 1), (0, 1), (3, 1), (2, 0)])
    assert segment_by_corridors(graph, {0, 1}) == (frozenset({5, 2, 0}), frozenset({4, 3, 1}))


@given(plans(), st.sampled_from(Segmentation))
def test_areas_divide_a_graph_and_are_connected(plan, segmentation):
    graph, corridors = plan
    areas = find_functional_areas(graph, corridors, segmentation=segmentation)
    assert sorted(node for area in areas for node in area) == sorted(graph)
    assert all(nx.is_connected(graph.subgraph(area)) for area in areas)
    firsts = [min(list(graph).index(node) for node in area) for area in areas]
    assert firsts == sorted(firsts)


@given(plans())
def test_by_corridors_no_other_corridor_is_nearer(plan):
    graph, corridors = plan
    hop_counts = dict(nx.all_pairs_shortest_path_length(graph))
    for area in segment_by_corridors(graph, corridors):
        for room in area - corridors if corridors else ():
            nearest = min(hop_counts[room][hub] for hub in corridors)
            own = [hub for hub in area & corridors if hop_counts[room][hub] == nearest]
            most = max(graph.degree(hub) for hub in corridors if hop_counts[room][hub] == nearest)
            assert any(graph.degree(hub) == most for hub in own)


@pytest.mark.slow
@given(st.randoms(use_true_random=False), st.sampled_from(Segmentation))
def test_names_and_order_do_not_matter_where_nothing_ties(random, segmentation):
    floor = build_floor(("CCCCC", "CCCCCCC", "SSSSSSSSS"), ((0, 1), (1, 2)), (0, 0, 0))
    corridors = {node for node, label in floor.graph.nodes(data="label") if label == "CORRIDOR"}
    names = dict(zip(floor.graph, random.sample(range(100), len(floor.graph)), strict=True))
    edges = [(names[one], names[other]) for one, other in floor.graph.edges]
    random.shuffle(edges)
    renamed = nx.Graph(edges)
    result = find_functional_areas(renamed, {names[node] for node in corridors}, segmentation=segmentation)
    assert sort_areas(result) == sort_areas({names[node] for node in area} for area in floor.areas)


def test_two_stars_joined_by_an_edge_are_cut_there():
    graph = build_floor(("CCCCC", "CCCC"), ((0, 1),), (0, 0)).graph
    assert segment_by_normalized_cut(graph) == (frozenset(range(6)), frozenset(range(6, 11)))


@pytest.mark.parametrize("rooms", [1, 4, 9, 10, 30, 99])
def test_a_star_is_never_cut(rooms):
    assert segment_by_normalized_cut(nx.star_graph(rooms)) == (frozenset(range(rooms + 1)),)


def test_the_threshold_is_the_normalised_cut():
    # One edge between two rings, each with five edges more: 1 / 11 + 1 / 11.
    halves = (frozenset(range(5)), frozenset(range(5, 10)))
    assert segment_by_normalized_cut(RINGS, max_cut=0.1818182) == halves
    assert segment_by_normalized_cut(RINGS, max_cut=0.1818181) == (frozenset(range(10)),)


def test_least_is_of_both_sides():
    assert len(segment_by_normalized_cut(RINGS, min_rooms=5)) == 2
    assert len(segment_by_normalized_cut(RINGS, min_rooms=6)) == 1
    # The best cut leaves 3 rooms on one side, and no other cut is tried.
    lopsided = nx.Graph([*pairwise([0, 1, 2, 0]), (2, 3), *pairwise(range(3, 11)), (10, 3), (4, 9), (5, 8)])
    assert len(segment_by_normalized_cut(lopsided, max_cut=2, min_rooms=3)) > 1
    assert len(segment_by_normalized_cut(lopsided, max_cut=2, min_rooms=4)) == 1


def find_best_split(graph) -> tuple[dict[frozenset[frozenset[int]], float], bool]:
    """Normalised cut of the best split along the order of the Fiedler vector, and the gaps of values around it."""
    nodes = sorted(graph)
    adjacency = nx.to_numpy_array(graph, nodelist=nodes)
    degrees = np.diag(adjacency.sum(axis=0))
    values, vectors = np.linalg.eig(np.linalg.inv(degrees) @ (degrees - adjacency))
    second = np.argsort(values.real)[1]
    ordered = [nodes[position] for position in np.argsort(vectors[:, second].real)]
    splits = {}
    for first in range(1, len(nodes)):
        side, other = set(ordered[:first]), set(ordered[first:])
        cut = nx.cut_size(graph, side, other)
        splits[frozenset([frozenset(side), frozenset(other)])] = cut / nx.volume(graph, side) + cut / nx.volume(
            graph, other
        )
    simple = np.diff(np.sort(values.real))[1] > 1e-6
    distinct = np.diff(np.sort(vectors[:, second].real)).min() > 1e-6
    return splits, bool(simple and distinct)


@given(st.integers(4, 14), st.integers(0, 10**6))
def test_the_least_normalised_cut_of_all_splits_along_the_fiedler_vector(size, seed):
    graph = make_plan(size, seed=seed)
    graph.remove_edges_from(nx.selfloop_edges(graph))
    splits, certain = find_best_split(graph)
    least = min(splits.values())
    best = [sides for sides, value in splits.items() if value < least + 1e-9]
    if not certain or len(best) > 1:
        return
    assert len(segment_by_normalized_cut(graph, max_cut=least - 1e-6, min_rooms=1)) == 1
    result = segment_by_normalized_cut(graph, max_cut=least + 1e-6, min_rooms=1)
    assert len(result) > 1
    (sides,) = best
    assert all(any(area <= side for side in sides) for area in result)


def test_parts_are_cut_again():
    wings = build_floor(("CCCCC", "CCCCC", "CCCCC", "CCCCC"), ((0, 1), (1, 2), (2, 3)), (0,) * 4)
    assert segment_by_normalized_cut(wings.graph) == wings.areas


def test_cuts_and_the_functional_graph():
    #  0 - 1   areas {0, 1}, {2}, {3, 4}; two doors between the first and the last
    #  |   |\
    #  3 - 4 2
    graph = nx.Graph([(1, 0), (0, 3), (4, 1), (3, 4), (2, 1)])
    areas = (frozenset({0, 1}), frozenset({2}), frozenset({3, 4}))
    cuts = {pair: sorted(result) for pair, result in find_cuts(graph, areas).items()}
    assert cuts == {(0, 1): [(1, 2)], (0, 2): [(0, 3), (1, 4)]}
    functional = build_functional_graph(graph, areas, ["a", "b", "a"])
    assert dict(functional.nodes(data="label")) == {0: "a", 1: "b", 2: "a"}
    assert sorted(functional.edges(data="cuts")) == [(0, 1, 1), (0, 2, 2)]


@pytest.mark.slow
@given(plans(), st.sampled_from(Segmentation))
def test_doors_are_cuts_or_inside_of_areas(plan, segmentation):
    graph, corridors = plan
    areas = find_functional_areas(graph, corridors, segmentation=segmentation)
    cuts = find_cuts(graph, areas)
    inside = sum(graph.subgraph(area).number_of_edges() for area in areas)
    assert inside + sum(map(len, cuts.values())) == graph.number_of_edges()
    assert all(one in areas[a] and other in areas[b] for (a, b), result in cuts.items() for one, other in result)
    assert nx.is_connected(build_functional_graph(graph, areas, ["a"] * len(areas)))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_schools_have_as_many_areas_as_printed(data):
    graphs = read_schools(data)
    for segmentation, printed in PRINTED_AREAS.items():
        model = learn_type(graphs, SCHEMAS["school"], segmentation=segmentation)
        assert len(model.areas) / len(graphs) == pytest.approx(printed, rel=0.1)
        assert 8 <= model.configurations.shape[1] <= 20
