"""Step 4: potentials of doors against a second computation, and properties of the doors of all buildings."""

from collections import Counter

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pianta._types import Floats
from pianta.generation.cut_potentials import CutPotentials, build_neighborhood, describe_neighborhood
from pianta.generation.door_costs import DoorCosts, learn_door_costs
from pianta.generation.functional_areas import Segmentation
from pianta.generation.incremental_gram import ReferenceGraphs
from pianta.generation.node_connections import ConnectedBuilding, NodeConnections, Pair, connect_areas
from pianta.generation.type_model import TypeModel
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from tests.generated_types import SCHOOL, build_floor, make_wing, small_model

# Cuts: corridor to corridor in both, and classroom to closet by a back door in the second.
BACK_DOOR = build_floor(("CCT", "SA"), ((0, 1),), (0, 1))
BACK_DOOR.graph.add_edge(1, 5)
MODEL = TypeModel(SCHOOL, Segmentation.CORR, (build_floor(("CCC", "AS"), ((0, 1),), (0, 1)), BACK_DOOR))
POTENTIALS = CutPotentials(MODEL)
REFERENCES = ReferenceGraphs([floor.graph for floor in MODEL.floors])
Connected = tuple[NodeConnections, list[Counter[Pair]], list[nx.Graph]]
# New buildings: corridor 0 with rooms 1 to 3, corridor 4 with rooms 5 and 6.
# Computed before the first test, because hypothesis controls the random numbers of tests.
SCHOOL_AREAS = small_model().areas
AREAS = (make_wing("CCT"), make_wing("SA"))


def neighborhood_of_edge(graph, one, other) -> nx.Graph:
    """N_1 of an edge: its ends, their neighbours, and the doors at both ends."""
    around = nx.Graph([(one, other), *graph.edges([one, other])])
    nx.set_node_attributes(around, dict(graph.nodes(data="label")), "label")
    return around


def list_cuts() -> list[tuple[nx.Graph, int, int]]:
    return [(floor.graph, *cut) for floor in MODEL.floors for cuts in floor.cuts.values() for cut in cuts]


def measure_xi(around: nx.Graph) -> float:
    """Ξ as printed in the thesis, with d as the distance of the normalised kernel."""
    cuts = [neighborhood_of_edge(*cut) for cut in list_cuts()]
    kernel = WeisfeilerLehman(iterations=5).fit(cuts)
    between = np.sqrt(np.maximum(2 - 2 * kernel.compare(), 0))
    mean = between.mean(axis=1)
    to_cuts = np.sqrt(np.maximum(2 - 2 * kernel.compare([around])[0], 0))

    def gauss(distances: Floats) -> Floats:
        return np.asarray(np.exp(-((distances - mean) ** 2) / (2 * 0.5**2)))

    return float(gauss(to_cuts).sum() / sum(gauss(row).sum() for row in between))


def measure_phi(graph, one, other) -> float:
    """Φ as printed in the thesis, without the sum of degrees, which is equal for all pairs."""
    labels = {graph.nodes[one]["label"], graph.nodes[other]["label"]}
    pairs = [{cut[0].nodes[cut[1]]["label"], cut[0].nodes[cut[2]]["label"]} for cut in list_cuts()]
    upsilon = pairs.count(labels) / len(pairs)
    degrees: int = graph.degree(one) * graph.degree(other)
    return measure_xi(neighborhood_of_edge(graph, one, other)) * degrees * upsilon


def test_cuts_of_the_model():
    labels = Counter(
        frozenset({graph.nodes[one]["label"], graph.nodes[other]["label"]}) for graph, one, other in list_cuts()
    )
    assert labels == {frozenset({"CORRIDOR"}): 2, frozenset({"CLASSROOM", "CLOSET"}): 1}


def test_frequencies_of_labels():
    assert POTENTIALS.measure_frequency("CORRIDOR", "CORRIDOR") == 2 / 3
    assert POTENTIALS.measure_frequency("CLOSET", "CLASSROOM") == 1 / 3
    assert POTENTIALS.measure_frequency("CLASSROOM", "CLOSET") == 1 / 3
    assert POTENTIALS.measure_frequency("CLASSROOM", "CLASSROOM") == 0


def test_p_conn_as_printed():
    building = ConnectedBuilding(AREAS)
    candidates = building.list_candidates((0, 1), POTENTIALS)
    assert candidates.pairs == [(0, 4), (1, 5), (2, 5)]
    resemblance = POTENTIALS.measure_resemblance(candidates.neighborhoods)
    result = np.array(candidates.weights) * [resemblance[around] for around in candidates.neighborhoods]
    expected = np.array([measure_phi(building.to_graph(), *pair) for pair in candidates.pairs])
    np.testing.assert_allclose(result / result.sum(), expected / expected.sum(), rtol=1e-9)
    bounds = np.cumsum(expected / expected.sum())
    for position, bound in enumerate(bounds):
        assert candidates.draw(POTENTIALS, float(bound) - 1e-6) == candidates.pairs[position]
    assert candidates.draw(POTENTIALS, float(bounds[0]) + 1e-6) == candidates.pairs[1]
    assert candidates.draw(POTENTIALS, 0.0) == candidates.pairs[0]
    assert candidates.draw(POTENTIALS, float(np.nextafter(1, 0))) == candidates.pairs[-1]


def test_pairs_that_close_a_triangle_are_as_frequent_as_among_cuts():
    # None of the three cuts closes a triangle; with the prior of one half this is (0 + 1/2) / (3 + 1).
    assert POTENTIALS.closed == 1 / 8
    building = ConnectedBuilding(AREAS)
    building.connect(0, 5)
    candidates = building.list_candidates((0, 1), POTENTIALS)
    closing = [bool(common) for *_, common in candidates.neighborhoods]
    assert dict(zip(candidates.pairs, closing, strict=True)) == {(0, 4): True, (1, 5): True, (2, 5): True}
    apart = ConnectedBuilding([*AREAS, make_wing("C")])
    hub = apart.areas[2][0]
    apart.connect(0, hub)
    apart.connect(4, hub)
    candidates = apart.list_candidates((0, 1), POTENTIALS)
    assert [bool(common) for *_, common in candidates.neighborhoods] == [True, False, False]
    assert candidates.draw(POTENTIALS, 1 / 8 - 1e-9) == (0, 4)
    assert candidates.draw(POTENTIALS, 1 / 8 + 1e-9) == candidates.pairs[1]


def test_resemblance_is_that_of_the_printed_formula():
    graph = BACK_DOOR.graph
    labels = [label for _, label in graph.nodes(data="label")]
    neighbors = [set(graph[node]) for node in graph]
    for one, other in [(0, 4), (1, 5), (0, 1), (3, 6), (2, 5)]:
        around = describe_neighborhood(labels, neighbors, one, other)
        result = POTENTIALS.measure_resemblance([around])[around]
        assert result == pytest.approx(measure_xi(neighborhood_of_edge(graph, one, other)), rel=1e-12)


def test_resemblance_of_all_cuts_has_the_sum_1():
    # This follows from the denominator of Ξ.
    assert sum(measure_xi(neighborhood_of_edge(*cut)) for cut in list_cuts()) == pytest.approx(1)


def test_resemblance_does_not_depend_on_other_neighborhoods():
    building = ConnectedBuilding([*small_model().areas[:4]])
    potentials = CutPotentials(small_model())
    wanted = [
        around
        for edge in ((0, 1), (1, 2), (2, 3))
        for around in building.list_candidates(edge, potentials).neighborhoods
    ]
    together = dict(potentials.measure_resemblance(wanted))
    for around in wanted:
        assert CutPotentials(small_model()).measure_resemblance([around])[around] == together[around]


@given(st.integers(0, 10**6))
def test_neighborhoods_are_those_of_the_graph(seed):
    random = np.random.default_rng(seed)
    graph = nx.gnp_random_graph(7, 0.4, seed=seed)
    nx.set_node_attributes(graph, {node: "AB"[random.integers(2)] for node in graph}, "label")
    one, other = random.choice(7, 2, replace=False).tolist()
    labels, neighbors = [label for _, label in graph.nodes(data="label")], [set(graph[node]) for node in graph]
    described = describe_neighborhood(labels, neighbors, one, other)
    assert described == describe_neighborhood(labels, neighbors, other, one)
    assert nx.is_isomorphic(
        build_neighborhood(described),
        neighborhood_of_edge(graph, one, other),
        node_match=lambda first, second: first["label"] == second["label"],
    )


def test_rooms_that_are_joined_are_no_candidates():
    building = ConnectedBuilding(AREAS)
    building.connect(0, 4)
    building.connect(1, 5)
    assert building.list_candidates((0, 1), POTENTIALS).pairs == [(2, 5)]


def test_all_pairs_where_no_cut_has_their_labels():
    building = ConnectedBuilding([make_wing("GG", hub="HALL"), make_wing("A", hub="LOBBY")])
    candidates = building.list_candidates((0, 1), POTENTIALS)
    assert len(candidates.pairs) == 6
    # They differ only in their degrees: 2, 1, 1 and 1, 1.
    assert candidates.weights == [2, 2, 1, 1, 1, 1]


def test_a_model_without_cuts():
    model = TypeModel(SCHOOL, Segmentation.CORR, (build_floor(("CC",), (), (0,)), build_floor(("AA",), (), (1,))))
    potentials = CutPotentials(model)
    building = ConnectedBuilding(model.areas)
    candidates = building.list_candidates((0, 1), potentials)
    assert len(candidates.pairs) == 9
    # The weights add up to 4 + 4 * 2 + 4 * 1; the first pair, both corridors, has a quarter.
    assert candidates.draw(potentials, 0.2499) == (0, 3)
    assert candidates.draw(potentials, 0.2501) != (0, 3)


@st.composite
def functional_trees(draw):
    """Areas of the small model, and a tree that joins them by one door or more."""
    areas = draw(st.lists(st.sampled_from(SCHOOL_AREAS), min_size=1, max_size=6))
    functional = nx.empty_graph(len(areas))
    for position in range(1, len(areas)):
        functional.add_edge(draw(st.integers(0, position - 1)), position, cuts=draw(st.integers(1, 8)))
    return areas, functional


def count_doors(building, functional) -> Counter[Pair]:
    area_of = {room: position for position, area in enumerate(building.areas) for room in area}
    pairs = [(area_of[one], area_of[other]) for one, other in building.list_doors()]
    counts = Counter((min(pair), max(pair)) for pair in pairs if pair[0] != pair[1])
    assert counts.keys() == {tuple(sorted(edge)) for edge in functional.edges}
    return counts


def list_inside(graph, rooms) -> set[frozenset[int]]:
    return {frozenset((one - rooms.start, other - rooms.start)) for one, other in graph.subgraph(rooms).edges}


def connect(areas, functional, *, seeds=(0,), model=None, moves=10) -> Connected:
    model = model or small_model()
    buildings = [ConnectedBuilding(areas) for _ in seeds]
    generators = [np.random.default_rng(seed) for seed in seeds]
    references = ReferenceGraphs([floor.graph for floor in model.floors])
    chains = NodeConnections(references, buildings, [functional] * len(seeds), CutPotentials(model), generators)
    starts = [count_doors(building, functional) for building in buildings]
    graphs = connect_areas(chains, moves=moves)
    return chains, starts, graphs


@pytest.mark.slow
@settings(max_examples=40)
@given(functional_trees(), st.integers(0, 1000))
def test_properties_of_all_doors(sampled, seed):
    areas, functional = sampled
    chains, (start,), (graph,) = connect(areas, functional, seeds=[seed])
    (building,) = chains.buildings
    counts = count_doors(building, functional)
    assert counts == start
    for pair, count in counts.items():
        # Fewer doors only if another one would cross; one door between two areas is always possible.
        assert 1 <= count <= functional.edges[pair]["cuts"]
        assert sorted(building.doors[pair]) == sorted(set(building.doors[pair]))
        assert len(building.doors[pair]) == count
    for area, rooms in zip(areas, building.areas, strict=True):
        positions = {node: position for position, node in enumerate(area)}
        assert list_inside(graph, rooms) == {frozenset((positions[one], positions[other])) for one, other in area.edges}
        assert [graph.nodes[room]["label"] for room in rooms] == [label for _, label in area.nodes(data="label")]
    assert nx.is_connected(graph)
    assert nx.check_planarity(graph)[0]
    similarity = WeisfeilerLehman().fit([floor.graph for floor in small_model().floors]).compare([graph])
    assert chains.costs[0] == pytest.approx(50 * np.sqrt(np.maximum(2 - 2 * similarity, 0)).mean(), rel=1e-12)


def test_single_doors_are_all_made():
    areas = small_model().areas[:5]
    functional = nx.cycle_graph(5)
    nx.set_edge_attributes(functional, 1, "cuts")
    chains, starts, _ = connect(areas, functional, seeds=range(20))
    for start, building in zip(starts, chains.buildings, strict=True):
        assert set(start.values()) == set(count_doors(building, functional).values()) == {1}


def test_there_are_at_most_as_many_doors_as_pairs():
    functional = nx.Graph()
    functional.add_edge(0, 1, cuts=50)
    _, (start,), (graph,) = connect([make_wing("C"), make_wing("A")], functional, model=MODEL)
    assert start == {(0, 1): 4}
    assert graph.number_of_edges() == 6


def test_doors_that_would_cross_are_not_made():
    functional = nx.Graph()
    functional.add_edge(0, 1, cuts=9)
    areas = [make_wing("GG", hub="HALL"), make_wing("AA", hub="LOBBY")]
    _, starts, graphs = connect(areas, functional, seeds=range(10), model=MODEL)
    assert all(nx.check_planarity(graph)[0] for graph in graphs)
    # A planar graph of six rooms has twelve doors at most: the four of the areas and eight more.
    assert all(4 <= start[0, 1] <= 8 for start in starts)


def test_doors_where_no_cut_has_these_labels():
    functional = nx.Graph()
    functional.add_edge(0, 1, cuts=1)
    areas = [make_wing("GG", hub="HALL"), make_wing("A", hub="LOBBY")]
    _, _, graphs = connect(areas, functional, seeds=range(30), model=MODEL)
    assert all(nx.is_connected(graph) for graph in graphs)
    assert len({frozenset(graph.edges) for graph in graphs}) > 1


@pytest.mark.slow
def test_costs_fall():
    functional = nx.path_graph(4)
    nx.set_edge_attributes(functional, 2, "cuts")
    areas = small_model().areas[:4]
    first, _, _ = connect(areas, functional, seeds=range(20), moves=0)
    last, _, _ = connect(areas, functional, seeds=range(20), moves=60)
    assert last.costs.mean() < first.costs.mean()


def test_chains_are_independent():
    functional = nx.cycle_graph(4)
    nx.set_edge_attributes(functional, 2, "cuts")
    areas = small_model().areas[3:7]
    _, _, together = connect(areas, functional, seeds=range(4))
    for seed, graph in enumerate(together):
        _, _, (alone,) = connect(areas, functional, seeds=[seed])
        assert nx.utils.graphs_equal(alone, graph)


def test_doors_do_not_depend_on_the_order_of_edges_in_the_functional_graph():
    one, other = nx.Graph(), nx.Graph()
    one.add_edges_from([(0, 1), (1, 2), (0, 2)], cuts=2)
    other.add_edges_from([(2, 0), (2, 1), (1, 0)], cuts=2)
    areas = small_model().areas[:3]
    (first,), (second,) = connect(areas, one)[2], connect(areas, other)[2]
    assert nx.utils.graphs_equal(first, second)


def test_kept_doors_never_move():
    fixed = small_model().floors[3]
    areas = [*fixed.area_graphs, *small_model().areas[:2]]
    functional = nx.Graph()
    functional.add_edges_from([*fixed.functional_graph.edges, (0, 4), (4, 5)], cuts=2)
    building = ConnectedBuilding(areas)
    building.add_fixed_doors(fixed)
    before = {*building.list_doors()}
    references = ReferenceGraphs([floor.graph for floor in small_model().floors])
    chains = NodeConnections(
        references, [building], [functional], CutPotentials(small_model()), [np.random.default_rng(0)], n_fixed=4
    )
    (graph,) = connect_areas(chains, moves=30)
    assert before <= {*graph.edges}
    assert set(building.doors) == {(0, 4), (4, 5)}
    rooms = range(len(fixed.graph))
    labels = [label for _, label in fixed.graph.nodes(data="label")]
    assert Counter(graph.nodes[room]["label"] for room in rooms) == Counter(labels)
    assert graph.subgraph(rooms).number_of_edges() == fixed.graph.number_of_edges()


def test_door_costs_are_log_odds():
    """Each of both floors has two corridors with a door between them, and neither has one door only."""
    costs = learn_door_costs(MODEL)
    assert costs.dead_ends == {"CORRIDOR": pytest.approx(np.log(4.5 / 0.5))}
    assert costs.corridors == {"CORRIDOR"}
    assert costs.parted == pytest.approx(np.log(2.5 / 0.5))
    most = {label: count for label, (count, _) in costs.most_doors.items()}
    # A classroom of the second floor has a back door to a closet
    assert (most["CLASSROOM"], most["CLOSET"], most["BATHROOM"]) == (2, 2, 1)
    assert costs.most_doors["CORRIDOR"][1] == pytest.approx(np.log(4.5 / 0.5))


def test_what_costs():
    """A corridor with a classroom, which leads to another corridor with a gym."""
    labels = ["CORRIDOR", "CLASSROOM", "CORRIDOR", "GYM"]
    neighbors = [{1}, {0, 2}, {1, 3}, {2}]
    assert DoorCosts().measure(labels, neighbors) == 0
    assert DoorCosts(dead_ends={"CORRIDOR": 3.0}).measure(labels, neighbors) == 3
    assert DoorCosts(most_doors={"CLASSROOM": (1, 2.0)}).measure(labels, neighbors) == 2
    parted = DoorCosts(parted=5.0, corridors=frozenset({"CORRIDOR"}))
    assert parted.measure(labels, neighbors) == 5
    assert parted.measure(["CORRIDOR"] * 4, neighbors) == 0


def test_doors_move_to_dead_ends():
    areas = [make_wing("CCT"), make_wing("SA")]
    areas[1].nodes[1]["label"] = "CORRIDOR"
    functional = nx.Graph()
    functional.add_edge(0, 1, cuts=1)
    shares = []
    for costs in ({}, {"CORRIDOR": 20.0}):
        buildings = [ConnectedBuilding(areas) for _ in range(40)]
        generators = [np.random.default_rng(seed) for seed in range(40)]
        door_costs = DoorCosts(dead_ends=costs)
        chains = NodeConnections(
            REFERENCES, buildings, [functional] * 40, POTENTIALS, generators, door_costs=door_costs
        )
        graphs = connect_areas(chains, moves=60)
        # Room 5 is the corridor with one door, beside the corridor of its area.
        shares.append(np.mean([graph.degree(5) > 1 for graph in graphs]))
        for building, cost in zip(buildings, chains.costs, strict=True):
            graph = building.to_graph()
            similarity = WeisfeilerLehman().fit([floor.graph for floor in MODEL.floors]).compare([graph])
            gamma = 50 * np.sqrt(np.maximum(2 - 2 * similarity, 0)).mean()
            assert cost == pytest.approx(gamma + costs.get("CORRIDOR", 0.0) * (graph.degree(5) == 1))
    assert shares[0] < 0.5
    assert shares[1] == 1


def connect_known_ends(ends: list[int], *, seed: int, moves: int = 30) -> tuple[ConnectedBuilding, nx.Graph]:
    """Two areas joined by doors at known rooms of the first, corridor 0 with rooms 1 to 3."""
    building = ConnectedBuilding(AREAS)
    building.known_ends[0, 1] = ends
    functional = nx.Graph()
    functional.add_edge(0, 1, cuts=len(ends))
    references = ReferenceGraphs([floor.graph for floor in MODEL.floors])
    chains = NodeConnections(references, [building], [functional], POTENTIALS, [np.random.default_rng(seed)], n_fixed=1)
    (graph,) = connect_areas(chains, moves=moves)
    return building, graph


def test_doors_stay_at_their_known_ends():
    others = set()
    for seed in range(20):
        building, graph = connect_known_ends([1, 0, 1], seed=seed)
        doors = building.doors[0, 1]
        assert [one for one, _ in doors] == [1, 0, 1]
        # The two doors of room 1 lead to different rooms.
        assert doors[0][1] != doors[2][1]
        assert {edge for edge in graph.edges if edge[0] < 4 <= edge[1]} == set(doors)
        # A classroom leads to a closet, and there is only one.
        assert doors[0][1] == 5
        others.add(doors[2][1])
    assert others == {4, 6}


def test_candidates_of_a_known_end():
    building = ConnectedBuilding(AREAS)
    building.known_ends[0, 1] = [3, 0]
    # No cut has a bathroom, so any room may be behind its door; a corridor leads to a corridor.
    assert building.list_candidates((0, 1), POTENTIALS, index=0).pairs == [(3, 4), (3, 5), (3, 6)]
    assert building.list_candidates((0, 1), POTENTIALS, index=1).pairs == [(0, 4)]
    building.connect(0, 4)
    assert building.list_candidates((0, 1), POTENTIALS, index=1).pairs == [(0, 5), (0, 6)]


def test_more_doors_than_rooms_behind_them():
    """The first three of four doors of a room lead to the three rooms of the other area."""
    building, _ = connect_known_ends([2] * 4, seed=0, moves=5)
    assert sorted(building.doors[0, 1]) == [(2, 4), (2, 5), (2, 6)]


def test_known_doors_are_made_even_where_they_cross():
    """All nine pairs of two triples cross already; the known doors are made nevertheless."""
    building = ConnectedBuilding([make_wing("CC"), make_wing("CC"), make_wing("C")])
    for one in range(3):
        for other in range(3, 6):
            building.connect(one, other)
    building.known_ends[0, 2] = [0, 1]
    functional = nx.Graph()
    functional.add_edge(0, 2, cuts=2)
    references = ReferenceGraphs([floor.graph for floor in MODEL.floors])
    NodeConnections(references, [building], [functional], POTENTIALS, [np.random.default_rng(0)])
    assert [one for one, _ in building.doors[0, 2]] == [0, 1]


@given(st.integers(2, 5), st.integers(0, 10**6))
def test_planarity_is_that_of_networkx(count, seed):
    random = np.random.default_rng(seed)
    building = ConnectedBuilding([make_wing("C" * int(random.integers(0, 4))) for _ in range(count)])
    # Only the first two areas may be joined; the others are isolated trees and must be counted too.
    for _ in range(int(random.integers(0, 16))):
        building.connect(int(random.choice(building.areas[0])), int(random.choice(building.areas[1])))
    assert building.is_planar() == nx.check_planarity(building.to_graph())[0]


def test_a_crossing_is_detected_beside_isolated_areas():
    # All nine pairs of two triples: K_3,3 with more edges.
    building = ConnectedBuilding([make_wing("CC"), make_wing("CC"), *[make_wing("C")] * 9])
    for one in range(3):
        for other in range(3, 6):
            building.connect(one, other)
    assert not building.is_planar()
