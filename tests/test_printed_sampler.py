"""The sampler of section 8.3 as printed, on literal schools."""

import networkx as nx
import numpy as np
import pytest

from pianta.prediction.explored_part import explore_by_corridors, hide_rooms, read_explored_part
from pianta.prediction.prediction import predict
from pianta.prediction.printed_sampler import PrintedSampler, sample_further_areas
from pianta.prediction.unexplored_part import FloorSampler
from tests.generated_types import SCHOOL, WINGS, join_wings, make_wing, small_model

SAMPLER = PrintedSampler(small_model())


def explore(name: str, number: int) -> nx.Graph:
    graph = join_wings(*WINGS[name], source=name)
    hubs = [node for node, label in graph.nodes(data="label") if label == "CORRIDOR"]
    return explore_by_corridors(graph, hubs)[number]


def test_step_1_keeps_the_bounds_of_each_cluster():
    """Known and further areas of a cluster are at most those of any floor; with known ones beyond, only the known."""
    model = small_model()
    most = model.configurations.max(axis=0)
    full = int(most.argmax())
    clusters = [full] * int(most[full] + 1)
    known_areas = [model.areas[0]] * len(clusters)
    generators = [np.random.default_rng(number) for number in range(40)]
    sampled = sample_further_areas(model, known_areas, clusters, generators)
    counts = np.array([np.bincount(model.clusters[areas], minlength=len(most)) for areas in sampled])
    assert (counts[:, full] == 0).all()
    others = [cluster for cluster in range(len(most)) if cluster != full]
    assert (counts[:, others] <= most[others]).all()
    assert (counts.sum(axis=1) >= 1).all()


def test_the_known_part_and_its_doors_stay():
    """Corridor 0 of school d with its rooms, two open corridors, and an unopened door of a classroom."""
    graph = join_wings(*WINGS["d"], source="d")
    graph.add_edge(1, len(graph))
    graph.nodes[len(graph) - 1]["label"] = "CLOSET"
    explored = read_explored_part(hide_rooms(graph, {*range(6)}, {6, 16}), SCHOOL)
    (door,) = explored.doors
    samples = SAMPLER.sample(explored, range(30))
    for sample in samples:
        nodes = sample.known_nodes
        known_graph = explored.known_graph
        assert {nodes[node]: label for node, label in known_graph.nodes(data="label")} == {
            node: sample.graph.nodes[node]["label"] for node in nodes.values()
        }
        edges = {frozenset((nodes[one], nodes[other])) for one, other in known_graph.edges}
        assert all(sample.graph.has_edge(*edge) for edge in edges)
        # Sampled doors may lead to discovered corridors, not from one explored room to another.
        explored_rooms = [nodes[node] for node in explored.closed]
        assert {frozenset(edge) for edge in sample.graph.subgraph(explored_rooms).edges} <= edges
        assert sample.graph.has_edge(nodes[explored.doors[door]], sample.behind[door])
        assert nx.is_connected(sample.graph)


def test_known_rooms_may_get_further_doors():
    """Only known connections are fixed: in some samples an explored room has a further door."""
    explored = read_explored_part(explore("d", 0), SCHOOL)
    further = {True: 0, False: 0}
    for sampler in (SAMPLER, FloorSampler(small_model())):
        for sample in sampler.sample(explored, range(30)):
            unseen = {*sample.unseen}
            closed = [sample.known_nodes[node] for node in explored.closed]
            further[sampler is SAMPLER] += any(unseen.intersection(sample.graph[node]) for node in closed)
    assert further[True] > 0
    assert further[False] == 0


def test_samples_depend_only_on_their_number():
    explored = read_explored_part(explore("d", 0), SCHOOL)
    (alone,) = SAMPLER.sample(explored, [3])
    assert nx.utils.graphs_equal(alone.graph, SAMPLER.sample(explored, range(5))[3].graph)


def test_predict_as_printed():
    """The same from a model, from its sampler and from the printed sampler; labels are those of the samples."""
    part = explore("d", 0)
    predictions = [
        predict(part, small_model(), count=5, as_printed=True),
        predict(part, FloorSampler(small_model()), count=5, as_printed=True),
        predict(part, SAMPLER, count=5),
    ]
    first = predictions[0]
    assert all(each.rooms == first.rooms and each.shares == first.shares for each in predictions)
    assert all(end.labels == end.sampled for end in first.ends)
    assert predict(part, small_model(), count=5).rooms != pytest.approx(first.rooms)


def test_a_part_without_an_explored_corridor():
    """A corridor that was only discovered: no area is known."""
    graph = make_wing("CC")
    graph.nodes[0]["partial"] = True
    graph.remove_nodes_from([1, 2])
    prediction = predict(graph, SAMPLER, count=5)
    assert prediction.rooms.low >= 1
