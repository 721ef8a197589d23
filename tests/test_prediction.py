"""Summaries of sampled floors: counts, shares, open ends, the skeleton; and what cannot be predicted."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pianta.errors import GraphError, LabelError, OptionError
from pianta.evaluation.prediction import measure_divergence
from pianta.generation.functional_areas import Segmentation
from pianta.labels import SCHOOL as SCHEMA
from pianta.prediction.explored_part import ExploredPart, explore_by_corridors, hide_rooms, read_explored_part
from pianta.prediction.label_distributions import find_nearest_distribution
from pianta.prediction.prediction import (
    MAX_SAMPLES,
    Prediction,
    SampleInterval,
    assign_unseen_rooms,
    predict,
)
from pianta.prediction.unexplored_part import FloorSampler, SampledFloor
from tests.generated_types import SCHOOL, WINGS, join_wings, small_model

SAMPLER = FloorSampler(small_model())


def make_part() -> ExploredPart:
    """Corridor 0 with classroom 1 and an unopened door (3), open corridor 2, an unopened door of the classroom (4)."""
    graph = nx.Graph(source="made")
    graph.add_nodes_from(
        [
            ("hall", {"label": "CORRIDOR", "area": 20.0}),
            ("class", {"label": "CLASSROOM", "area": 50.0}),
            ("side", {"label": "CORRIDOR", "partial": True, "area": 10.0}),
            ("?", {"label": None, "partial": True}),
            ("??", {"label": None, "partial": True}),
        ]
    )
    graph.add_edges_from([("hall", "class"), ("hall", "side"), ("hall", "?"), ("class", "??")])
    return read_explored_part(graph, SCHOOL)


def make_sample(labels: str, edges: str, *, behind: dict[int, int] | None = None) -> SampledFloor:
    """A sample around that part: rooms 3 … with labels by letters and areas (m²) equal to their ids; doors as 3-4."""
    names = {"C": "CORRIDOR", "R": "CLASSROOM", "S": "CLOSET"}
    graph = nx.Graph([(0, 1), (0, 2)])
    graph.add_edges_from(tuple(map(int, edge.split("-"))) for edge in edges.split())
    nx.set_node_attributes(graph, {0: "CORRIDOR", 1: "CLASSROOM", 2: "CORRIDOR"}, "label")
    nx.set_node_attributes(graph, {0: 20.0, 1: 50.0, 2: 10.0}, "area")
    for room, letter in enumerate(labels, 3):
        graph.nodes[room].update(label=names[letter], area=float(room))
    return SampledFloor(graph, {0: 0, 1: 1, 2: 2}, behind if behind is not None else {3: 3, 4: 4})


def predict_by(*samples: SampledFloor) -> Prediction:
    return Prediction(make_part(), samples, SCHEMA, {})


# Behind "?" a corridor with a closet; behind "??" a classroom; along "side" two closets.
ONE = make_sample("CRSSS", "0-3 1-4 3-5 2-6 2-7")
# "?" leads to a classroom, "??" to a corridor that also the open corridor leads to.
TWO = make_sample("RC", "0-3 1-4 2-4")


def test_intervals_of_samples():
    """80 % of ten numbers are between the second and the ninth."""
    assert SampleInterval.from_values([*range(10)]) == SampleInterval(4.5, 1, 8)
    assert SampleInterval.from_values([3.0]) == SampleInterval(3, 3, 3)


def test_numbers_of_rooms():
    prediction = predict_by(ONE, TWO)
    assert prediction.rooms == SampleInterval(6.5, 5, 8)
    assert prediction.area is not None
    # 80 m² are explored; ONE has 3 + 4 + 5 + 6 + 7 m² more, TWO 3 + 4 m².
    assert prediction.area == SampleInterval(96, 87, 105)
    assert {label: spread.mean for label, spread in prediction.counts.items()} == {
        "CLOSET": 1.5,
        "CLASSROOM": 1,
        "CORRIDOR": 1,
    }
    assert next(iter(prediction.counts)) == "CLOSET"
    assert prediction.counts["CLOSET"].high == 3
    del ONE.graph.nodes[7]["area"]
    assert predict_by(ONE, TWO).area is None
    ONE.graph.nodes[7]["area"] = 7.0


def test_shares_of_one_sample_are_its_own():
    assert predict_by(TWO).shares == pytest.approx({"CLASSROOM": 0.5, "CORRIDOR": 0.5}, abs=1e-6)
    assert sum(predict_by(ONE, TWO).shares.values()) == pytest.approx(1)


def test_without_unseen_rooms_there_are_no_shares():
    prediction = predict_by(make_sample("", "", behind={}))
    assert prediction.shares == {}
    assert prediction.counts == {}
    assert [end.labels for end in prediction.ends] == [{}] * 3
    # Samples without unseen rooms do not count.
    assert predict_by(make_sample("", "", behind={}), TWO).shares == pytest.approx(predict_by(TWO).shares)


def test_rooms_are_those_of_the_nearest_end():
    part = make_part()
    assert assign_unseen_rooms(ONE, part) == {2: [6, 7], 3: [3, 5], 4: [4]}
    # Room 4 is behind the door "??", and one hop from the open corridor.
    assert assign_unseen_rooms(TWO, part) == {2: [], 3: [3], 4: [4]}
    # Without that door it belongs to the open corridor.
    without = make_sample("RC", "0-3 2-4", behind={3: 3})
    assert assign_unseen_rooms(without, part) == {2: [4], 3: [3], 4: []}


def test_open_ends():
    side, door, other = predict_by(ONE, TWO).ends
    assert (side.room, side.near, side.is_door) == ("side", "side", False)
    assert (door.room, door.near, door.is_door) == ("?", "hall", True)
    assert (other.room, other.near) == ("??", "class")
    assert side.labels == {"CLOSET": 1}
    assert door.labels == {"CORRIDOR": 0.5, "CLASSROOM": 0.5}
    assert other.labels == {"CLASSROOM": 0.5, "CORRIDOR": 0.5}
    assert (side.leads_on, door.leads_on, other.leads_on) == (0, 0.5, 0.5)
    assert side.rooms == SampleInterval(1, 0, 2)
    assert door.rooms == SampleInterval(1.5, 1, 2)
    assert door.area == SampleInterval(5.5, 3, 8)


def test_skeleton():
    """In ONE "?" is a corridor at the hall; in TWO "??" is a corridor, also at the open corridor."""
    graph = predict_by(ONE, TWO).skeleton
    result = {frozenset(edge): probability for *edge, probability in graph.edges(data="probability")}
    beyond = ("beyond", "side")
    assert result == {
        frozenset(("hall", "side")): 1,
        frozenset(("hall", "?")): 0.5,
        frozenset(("side", beyond)): 0.5,
        frozenset((beyond, "??")): 0.5,
    }
    assert dict(graph.nodes(data="probability")) == {"hall": 1, "side": 1, "?": 0.5, beyond: 0.5, "??": 0.5}


def test_typical():
    prediction = predict_by(ONE, TWO, make_sample("RC", "0-3 1-4 2-4"), make_sample("RCS", "0-3 1-4 2-4 3-5"))
    assert prediction.typical is TWO
    assert nx.is_isomorphic(prediction.corridor_graph(TWO), nx.path_graph(3))
    assert predict_by(ONE).typical is ONE


def test_nearest_distribution():
    rows = np.array([[4.0, 0, 0], [4, 0, 0], [2, 2, 0]])
    nearest = find_nearest_distribution(rows)
    assert nearest.sum() == pytest.approx(1)
    grid = np.array([(p, 1 - p, 0) for p in np.linspace(0.5, 1, 501)])
    shares = rows / rows.sum(axis=1, keepdims=True)
    costs = np.array([measure_divergence(shares, point).mean() for point in grid])
    assert measure_divergence(shares, nearest).mean() <= costs.min() + 1e-6
    assert abs(nearest[0] - grid[costs.argmin()][0]) < 0.01
    # A label that only one of three rows has is rarer than in the mean.
    assert nearest[1] < (rows.sum(axis=0) / rows.sum())[1]


@settings(max_examples=30)
@given(st.lists(st.lists(st.integers(0, 6), min_size=4, max_size=4).filter(any), min_size=1, max_size=6))
def test_nearest_distribution_is_nearer_than_the_mean(rows):
    counts = np.array(rows, float)
    weights = counts.sum(axis=1) / counts.sum()
    shares = counts / counts.sum(axis=1, keepdims=True)

    def cost(guess: np.ndarray) -> float:
        return float(weights @ measure_divergence(shares, guess))

    nearest = find_nearest_distribution(counts)
    assert nearest.min() > 0
    assert cost(nearest) <= cost(weights @ shares) + 1e-6
    assert all(cost(nearest) <= cost(row) + 1e-6 for row in shares)


def explore(name: str, number: int) -> nx.Graph:
    graph = join_wings(*WINGS[name], source=name)
    return explore_by_corridors(graph, [node for node, label in graph.nodes(data="label") if label == "CORRIDOR"])[
        number
    ]


def test_predictions_of_a_floor():
    prediction = predict(explore("d", 0), small_model(), count=20)
    assert len(prediction.samples) == 20
    assert prediction.average == SAMPLER.label_shares
    assert prediction.rooms.low >= len(prediction.explored.known_graph)
    by_sampler = predict(explore("d", 0), SAMPLER, count=20)
    assert by_sampler.shares == prediction.shares
    assert [nx.to_dict_of_lists(sample.graph) for sample in by_sampler.samples] == [
        nx.to_dict_of_lists(sample.graph) for sample in prediction.samples
    ]
    assert nx.utils.graphs_equal(by_sampler.skeleton, prediction.skeleton)
    fewer = predict(explore("d", 0), SAMPLER, count=5)
    for one, two in zip(fewer.samples, by_sampler.samples, strict=False):
        assert nx.utils.graphs_equal(one.graph, two.graph)
    other = predict(explore("d", 0), SAMPLER, count=20, seed=1)
    assert any(
        not nx.utils.graphs_equal(one.graph, two.graph)
        for one, two in zip(other.samples, prediction.samples, strict=True)
    )


def test_the_more_corridors_are_open_the_more_is_expected():
    """School d has two open corridors at first; at the end only the rooms of the fourth corridor are unexplored."""
    first, last = (predict(explore("d", number), SAMPLER, count=60) for number in (0, 2))
    unseen = [prediction.rooms.mean - len(prediction.explored.known_graph) for prediction in (first, last)]
    assert unseen[0] > unseen[1] > 0
    # Samples have all corridors of the floor; at the end four of them are explored.
    assert all(len(last.corridor_graph(sample)) >= 4 for sample in last.samples)


def test_a_reading_of_a_partial_map():
    """Rooms with numbers and label sets; one corridor is partly explored, one room to a tenth, one to nine tenths."""
    graph = nx.Graph(source="part")
    graph.add_node(1, label="CORRIDOR", area=30.0, partial=True, predicted_area=60.0)
    graph.add_node(2, label="CLASSROOM", area=50.0, partial=False)
    messages = {"R/C": {"ROOM": 1.0}, "type": {"CLASSROOM": 0.6, "LAB": 0.4}}
    graph.add_node(3, label="CLASSROOM", area=5.0, partial=True, predicted_area=50.0, label_probabilities=messages)
    graph.add_node(4, label="CLASSROOM", area=45.0, partial=True, predicted_area=50.0, label_probabilities=messages)
    graph.add_edges_from([(1, 2), (1, 3), (1, 4)])
    prediction = predict(graph, SAMPLER, count=30)
    assert [(end.room, end.near) for end in prediction.ends] == [(1, 1), (3, 1)]
    (_, door) = prediction.ends
    assert sum(door.labels.values()) == pytest.approx(1)
    assert door.rooms.mean >= 1
    assert 4 in [room for _, room in prediction.explored.known_graph.nodes(data="room")]


def test_what_cannot_be_predicted():
    complete = join_wings(*WINGS["a"], source="a")
    for graph in (complete, explore("a", -1), hide_rooms(complete, {*complete})):
        with pytest.raises(
            GraphError, match=r"^no door of it is unopened and no corridor goes on, so there is nothing"
        ):
            predict(graph, SAMPLER)
    with pytest.raises(GraphError, match="no room of it is known"):
        predict(nx.Graph(), SAMPLER)
    with pytest.raises(
        OptionError, match=r"^the model has areas by ncut, prediction needs areas by corr; train it with these$"
    ):
        predict(explore("a", 0), small_model(Segmentation.NCUT))
    for count in (0, MAX_SAMPLES + 1):
        with pytest.raises(OptionError, match=rf"^{count} samples are wanted, give 1 to 10000$"):
            predict(explore("a", 0), SAMPLER, count=count)
    with pytest.raises(OptionError, match=r"^seed is -1, give 0 or more$"):
        predict(explore("a", 0), SAMPLER, seed=-1)
    unusual = explore("a", 0)
    unusual.nodes[1]["label"] = "SPA"
    with pytest.raises(LabelError, match="'SPA'"):
        predict(unusual, SAMPLER)
