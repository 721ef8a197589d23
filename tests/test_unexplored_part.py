"""Sampled floors around explored parts: explored rooms stay, every door leads to a room, and the floor is connected."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pianta.errors import OptionError
from pianta.generation.functional_areas import Segmentation
from pianta.generation.type_model import learn_type
from pianta.prediction.explored_part import ExploredPart, explore_by_corridors, hide_rooms, read_explored_part
from pianta.prediction.unexplored_part import FloorSampler, SampledFloor
from tests.generated_types import SCHOOL, WINGS, join_wings, make_schools, small_model

SAMPLER = FloorSampler(small_model())


def make_back_doors() -> list[nx.Graph]:
    """The small schools, with an office behind the first classroom of each and a passage from it to the last room."""
    graphs = make_schools()
    for graph in graphs:
        last, extra = len(graph) - 1, len(graph)
        graph.add_node(extra, label="SMALL ADMINISTRATIVE", area=12.0)
        graph.add_edges_from([(1, extra), (1, last)])
    return graphs


# Computed before the first test, because hypothesis controls the random numbers of tests.
BACK_DOORS = FloorSampler(learn_type(make_back_doors(), SCHOOL))
ANY = FloorSampler(learn_type(make_back_doors()[1:], SCHOOL))


def explore(graph: nx.Graph, explored: set[int], discovered: set[int] | None = None) -> ExploredPart:
    return read_explored_part(hide_rooms(graph, explored, discovered or set()), SCHOOL)


def list_corridors(graph: nx.Graph) -> list[int]:
    return [node for node, label in graph.nodes(data="label") if label == "CORRIDOR"]


def check_known_part(sample: SampledFloor, explored: ExploredPart) -> None:
    """The sample has the explored rooms, labels and doors; closed rooms get new doors only for unopened ones."""
    graph, nodes = sample.graph, sample.known_nodes
    assert [*graph] == [*range(len(graph))]
    assert {*nodes} == {*explored.known_graph}
    assert len({*nodes.values()}) == len(nodes)
    for node, index in nodes.items():
        assert graph.nodes[index]["label"] == explored.graph.nodes[node]["label"]
    doors = {frozenset((nodes[near], sample.behind.get(door))) for door, near in explored.doors.items()}
    before = {frozenset((nodes[one], nodes[other])) for one, other in explored.known_graph.edges}
    result = {frozenset(edge) for edge in graph.edges}
    ends = {nodes[corridor] for corridor in explored.open}
    assert before <= result
    for edge in result - before:
        assert edge in doors or not edge & ({*nodes.values()} - ends)


def check_doors(sample: SampledFloor, explored: ExploredPart) -> None:
    """Each door leads from its room to one unknown room or, seldom, to an open corridor."""
    ends = {sample.known_nodes[corridor] for corridor in explored.open}
    behind: dict[int, list[int]] = {}
    for door, index in sample.behind.items():
        near = explored.doors[door]
        assert sample.graph.has_edge(sample.known_nodes[near], index)
        assert index in ends or index in sample.unseen
        behind.setdefault(near, []).append(index)
    # Doors of one room lead to different rooms.
    assert all(len({*positions}) == len(positions) for positions in behind.values())


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.sampled_from([*WINGS]), st.data(), st.integers(0, 1000))
def test_properties_of_samples_of_any_explored_part(name, data, seed):
    graph = join_wings(*WINGS[name], source=name)
    graph.add_edge(1, len(graph) - 1)
    explored = data.draw(st.sets(st.sampled_from([*graph]), min_size=1))
    corridors = [node for node in list_corridors(graph) if node not in explored]
    discovered = {node for node in corridors if any(near in explored for near in graph[node])}
    part = explore(graph, explored, discovered)
    if not part.open_ends:
        return
    samples = ANY.sample(part, range(4), seed=seed)
    for sample in samples:
        check_known_part(sample, part)
        check_doors(sample, part)
        if nx.is_connected(part.known_graph):
            assert nx.is_connected(sample.graph)


@pytest.mark.slow
def test_stages_of_exploration():
    lost, doors = 0, 0
    for graph in make_back_doors():
        for nodes in explore_by_corridors(graph, list_corridors(graph))[:-1]:
            part = read_explored_part(nodes, SCHOOL)
            if not part.open_ends:
                continue
            for sample in BACK_DOORS.sample(part, range(20)):
                check_known_part(sample, part)
                check_doors(sample, part)
                assert nx.is_connected(sample.graph)
                lost += len(part.doors) - len(sample.behind)
                doors += len(part.doors)
    assert doors > 100
    assert lost <= 0.02 * doors


@pytest.mark.slow
def test_doors_of_an_open_corridor():
    graph = nx.star_graph(6)
    unknown = {node: {"label": None, "partial": True} for node in graph}
    nx.set_node_attributes(graph, unknown | {0: {"label": "CORRIDOR", "partial": True}})
    part = read_explored_part(graph, SCHOOL)
    for sampler in (SAMPLER, BACK_DOORS):
        for sample in sampler.sample(part, range(30)):
            assert {*sample.behind} == {*part.doors}
            check_known_part(sample, part)
            check_doors(sample, part)
            assert nx.is_connected(sample.graph)


def test_a_door_of_a_room_where_no_model_has_one():
    """In the small schools no classroom has such a door; the unopened door still leads to a room."""
    assert "CLASSROOM" not in SAMPLER.ends.by_label
    graph = nx.path_graph(2)
    nx.set_node_attributes(graph, {0: {"label": "CLASSROOM"}, 1: {"label": None, "partial": True}})
    part = read_explored_part(graph, SCHOOL)
    for sample in SAMPLER.sample(part, range(40)):
        assert {*sample.behind} == {1}
        assert nx.is_connected(sample.graph)


def test_floors_of_corridors_alone_have_no_examples_of_doors():
    corridors = []
    for length in (2, 3, 4):
        graph = nx.path_graph(length)
        nx.set_node_attributes(graph, "CORRIDOR", "label")
        graph.graph["source"] = f"{length} corridors"
        corridors.append(graph)
    sampler = FloorSampler(learn_type(corridors, SCHOOL))
    assert sampler.ends.examples == []
    graph = nx.path_graph(2)
    nx.set_node_attributes(graph, {0: {"label": "CLASSROOM"}, 1: {"label": None, "partial": True}})
    for sample in sampler.sample(read_explored_part(graph, SCHOOL), range(10)):
        assert {*sample.behind} == {1}


@pytest.mark.parametrize(
    ("label", "is_corridor", "examples"), [("HALL", True, "at_corridors"), ("GYM", False, "at_rooms")]
)
def test_behind_corridors_is_what_was_at_corridors(label, is_corridor, examples):
    """No floor of the model has a door of this label, so all doors of its kind count."""
    assert label not in BACK_DOORS.ends.by_label
    assert BACK_DOORS.ends.at_corridors != BACK_DOORS.ends.at_rooms
    generator = np.random.default_rng(0)
    sampled = [
        BACK_DOORS._draw_branch(label, is_corridor=is_corridor, leads_on=True, generator=generator) for _ in range(300)
    ]
    branches = {id(branch) for branch in sampled if branch is not None}
    assert branches
    assert branches <= {id(example.branch) for example in getattr(BACK_DOORS.ends, examples)}


@pytest.mark.slow
def test_only_an_open_corridor_is_known():
    part = explore(join_wings(*WINGS["d"], source="d"), set(), {0})
    for sample in SAMPLER.sample(part, range(60)):
        assert nx.is_connected(sample.graph)
        assert sample.known_nodes.keys() == {0}


def test_parallel_doors():
    """Two rooms each with a door to the same unknown room: each door leads to a room."""
    graph = join_wings(*WINGS["a"], source="a")
    graph.add_edge(1, 2)
    graph.add_node("?", label=None, partial=True)
    graph.add_edges_from([(1, "?"), (2, "?")])
    part = read_explored_part(graph, SCHOOL)
    assert len(part.doors) == 2
    for sample in BACK_DOORS.sample(part, range(30)):
        check_known_part(sample, part)
        check_doors(sample, part)


def test_a_known_room_at_an_open_corridor():
    graph = join_wings(*WINGS["b"], source="b")
    part = explore(graph, {0, 1, 2, 3, 4, 6}, {5})
    assert part.graph.number_of_edges() == 6
    for sample in SAMPLER.sample(part, range(30)):
        check_known_part(sample, part)
        room = next(node for node in part.known_graph if part.graph.nodes[node]["room"] == 6)
        assert sample.graph.degree(sample.known_nodes[room]) == 1
        assert nx.is_connected(sample.graph)


@pytest.mark.slow
def test_samples_depend_only_on_their_seed_and_number():
    graph = make_back_doors()[3]
    part = read_explored_part(explore_by_corridors(graph, list_corridors(graph))[0], SCHOOL)

    def sample(numbers, seed=0, sampler=BACK_DOORS) -> list[object]:
        return [
            (nx.to_dict_of_lists(one.graph), [*one.graph.nodes(data=True)], one.known_nodes, one.behind)
            for one in sampler.sample(part, numbers, seed=seed)
        ]

    together = sample(range(8))
    assert sample(range(8)) == together
    assert [sample([number])[0] for number in range(8)] == together
    assert sample([5, 2]) == [together[5], together[2]]
    assert sample(range(8), sampler=FloorSampler(learn_type(make_back_doors(), SCHOOL))) == together
    assert sample(range(8), seed=1) != together


@pytest.mark.slow
@pytest.mark.parametrize("observed", [7.0, 12.0])
def test_sizes_of_rooms(observed):
    """Rooms keep their areas; an open corridor has the larger of its explored area and that of its sampled area."""
    graphs = make_back_doors()
    for graph in graphs:
        nx.set_node_attributes(graph, 10.0, "area")
    sampler = FloorSampler(learn_type(graphs, SCHOOL))
    graph = graphs[1].copy()
    nx.set_node_attributes(graph, observed, "area")
    part = read_explored_part(explore_by_corridors(graph, list_corridors(graph))[0], SCHOOL)
    result: set[float] = set()
    for sample in sampler.sample(part, range(10)):
        sizes = {node: sample.graph.nodes[index]["area"] for node, index in sample.known_nodes.items()}
        assert {sizes[node] for node in part.closed} == {observed}
        result.update(sizes[node] for node in part.open)
        assert {sample.graph.nodes[node]["area"] for node in sample.unseen} <= {10.0}
    # That of a corridor whose area has no rooms is what is seen.
    assert max(observed, 10.0) in result <= {observed, 10.0}


def test_shares_of_labels():
    """Means over floors with equal weights: a has 10 rooms with 2 corridors, …"""
    shares = SAMPLER.label_shares
    assert [*shares] == [*SCHOOL.by_name]
    corridor_nodes = [len(wings) / (len(wings) + sum(map(len, wings))) for wings, _ in WINGS.values()]
    assert shares["CORRIDOR"] == pytest.approx(sum(corridor_nodes) / len(corridor_nodes))
    assert sum(shares.values()) == pytest.approx(1)


def test_areas_by_ncut_are_refused():
    with pytest.raises(OptionError, match="ncut"):
        FloorSampler(small_model(Segmentation.NCUT))
