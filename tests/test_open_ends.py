"""What lay behind the open ends of floors of a model, explored as far as a given part."""

import networkx as nx
import numpy as np
import pytest

from pianta.errors import ModelError, OptionError
from pianta.generation.functional_areas import Segmentation
from pianta.generation.type_model import learn_type
from pianta.prediction.explored_part import explore_by_corridors, hide_rooms, read_explored_part
from pianta.prediction.open_ends import OpenEnds, count_labels_of_part, extract_branch, find_hub
from tests.generated_types import SCHOOL, WINGS, join_wings, make_wing, small_model

ENDS = OpenEnds(small_model())


def make_back_rooms(*, source: str) -> nx.Graph:
    """Corridor 0 with classrooms 1 and 2; behind 2 a closet, 3, and behind 1 the corridor 4 with a gym, 5."""
    graph = make_wing("CC")
    graph.add_nodes_from([(3, {"label": "CLOSET"}), (4, {"label": "CORRIDOR"}), (5, {"label": "GYM"})])
    graph.add_edges_from([(2, 3), (1, 4), (4, 5)])
    graph.graph["source"] = source
    return graph


def test_stages_of_floors():
    """School c: corridor 0 with six rooms, corridors 7 with three and 11 with two at it; 7 is explored first."""
    floor = small_model().floors[2]
    stages = [stage for stage in ENDS.stages if stage.floor == 2]
    hubs = [find_hub(floor.graph, area, {0, 7, 11}) for area in floor.areas]
    assert hubs == [0, 7, 11]
    counts = [(stage.open, stage.doors, stage.corridor_doors, stage.areas) for stage in stages]
    assert counts[:3] == [(2, 0, 0, (1, 2)), (1, 0, 0, (2,)), (0, 0, 0, ())]
    # The same with the rooms of the last corridor behind their doors
    assert counts[3:] == [(2, 0, 6, (1, 2)), (1, 0, 3, (2,)), (0, 0, 2, ())]
    assert [int(stage.labels.sum()) for stage in stages] == [9, 12, 14, 3, 9, 12]
    columns = {label: column for column, label in enumerate(SCHOOL.by_name)}
    assert stages[0].labels[columns["CLASSROOM"]] == 5
    assert stages[0].labels[columns["CORRIDOR"]] == 3


def test_examples_of_doors():
    """The closet is of the area that is explored with corridor 0, the second corridor is another area."""
    ends = OpenEnds(learn_type([make_back_rooms(source=name) for name in "ab"], SCHOOL))
    assert len(ends.at_rooms) == 4
    own = [example for example in ends.at_rooms if example.floor == 0]
    assert [example.near for example in own] == ["CLASSROOM", "CLASSROOM"]
    (branch,) = [example.branch for example in own if example.branch is not None]
    assert dict(branch.nodes(data="label")) == {3: "CLOSET"}
    assert [len(examples) for examples in ends.by_label["CLASSROOM"]] == [2, 2]
    assert [*ends.by_label] == ["CLASSROOM", "CORRIDOR"]
    assert sorted((example.far, example.area, int(example.labels.sum())) for example in own) == [
        ("CLOSET", None, 3),
        ("CORRIDOR", None, 3),
    ]


def test_examples_of_doors_of_corridors():
    """Behind the doors of corridor 0 are two classrooms, with a closet and with nothing; of corridor 4 a gym."""
    ends = OpenEnds(learn_type([make_back_rooms(source=name) for name in "ab"], SCHOOL))
    own = [example for example in ends.at_corridors if example.floor == 0]
    assert [(example.near, example.far, int(example.labels.sum())) for example in own] == [
        ("CORRIDOR", "CLASSROOM", 1),
        ("CORRIDOR", "CLASSROOM", 1),
        ("CORRIDOR", "GYM", 5),
    ]
    rooms = [sorted(example.branch) for example in own if example.branch is not None]
    assert rooms == [[1], [2, 3], [5]]


def test_floors_without_doors_to_other_rooms_have_examples_of_corridors_alone():
    assert {example.near for example in ENDS.examples} == {"CORRIDOR"}
    assert ENDS.at_rooms == ENDS.at_corridors == ENDS.examples
    assert [*ENDS.by_label] == ["CORRIDOR"]


def test_weights():
    floor = small_model().floors[3]
    corridors = {node for node, label in floor.graph.nodes(data="label") if label == "CORRIDOR"}
    explored = read_explored_part(explore_by_corridors(floor.graph, corridors)[0], SCHOOL)
    weights = ENDS.stage_weights(explored)
    assert weights.shape == (len(ENDS.stages),)
    assert weights.sum() == pytest.approx(1)
    assert [*(weights > 0)] == [stage.corridor_doors == 0 for stage in ENDS.stages]
    # As far as itself, of which nothing is apart; it has four stages with all rooms at corridors.
    own = [position for position, stage in enumerate(ENDS.stages) if stage.floor == 3]
    stages = [position for position in own if ENDS.stages[position].corridor_doors == 0]
    assert (len(own), len(stages)) == (8, 4)
    assert weights[stages].argmax() == 0
    complete = [position for position, stage in enumerate(ENDS.stages) if stage.open == 0]
    assert weights[complete].max() < weights[stages[0]]


def test_weights_as_written():
    """exp(-d² / (2 · 0.5²) - JS / 0.2) over the alike stages of a floor, d of the logarithms of one more."""
    explored = read_explored_part(hide_rooms(make_wing("CC"), {0}), SCHOOL)
    assert (len(explored.open), explored.doors) == (0, {1: 0, 2: 0})
    result = ENDS.stage_weights(explored)
    labels = count_labels_of_part(explored, SCHOOL)
    assert labels.sum() == 1

    def weigh(stage) -> float:
        if not stage.corridor_doors:
            return 0.0
        share = stage.labels / stage.labels.sum()
        corridor = [*SCHOOL.by_name].index("CORRIDOR")
        p = share[corridor]
        middle = (p + 1) / 2
        # Only corridors are known: bits of both halves by hand.
        first = p * np.log2(p / middle) + sum(q * np.log2(2) for q in np.delete(share, corridor) if q > 0)
        divergence = (first + np.log2(1 / middle)) / 2
        apart = np.log(1 + stage.open) ** 2 + (np.log(1 + stage.corridor_doors) - np.log(3)) ** 2
        n_stages = sum(other.floor == stage.floor for other in ENDS.stages if other.corridor_doors)
        return float(np.exp(-apart / 0.5 - divergence / 0.2) / n_stages)

    assert not any(stage.doors for stage in ENDS.stages)
    expected = np.array([weigh(stage) for stage in ENDS.stages])
    np.testing.assert_allclose(result, expected / expected.sum(), rtol=1e-9)


def test_hubs():
    graph = make_wing("CCT")
    assert find_hub(graph, frozenset({0, 1, 2}), {0}) == 0
    graph.add_edges_from([(1, 2), (1, 3)])
    assert find_hub(graph, frozenset({1, 2, 3}), set()) == 1
    assert find_hub(graph, frozenset({1, 2, 3}), {3}) == 3


def test_branches_begin_at_the_door():
    graph = nx.path_graph(6)
    nx.set_node_attributes(graph, "CLOSET", "label")
    branch = extract_branch(graph, frozenset({0, 1, 2, 4}), 2)
    assert [*branch] == [2, 0, 1]
    assert {frozenset(edge) for edge in branch.edges} == {frozenset((0, 1)), frozenset((1, 2))}
    assert branch.nodes[0] == {"label": "CLOSET"}


def test_models_that_cannot_be_explored():
    with pytest.raises(OptionError, match=r"ncut.*corr"):
        OpenEnds(small_model(Segmentation.NCUT))
    rooms = [nx.path_graph(count) for count in (3, 4)]
    for graph in rooms:
        nx.set_node_attributes(graph, "CLASSROOM", "label")
    with pytest.raises(ModelError, match="corridor"):
        OpenEnds(learn_type(rooms, SCHOOL))


def test_known_labels():
    graph = join_wings(*WINGS["a"], source="a")
    explored = read_explored_part(hide_rooms(graph, {0, 1, 5}, {6}), SCHOOL)
    counts = dict(zip(SCHOOL.by_name, count_labels_of_part(explored, SCHOOL).tolist(), strict=True))
    assert {label: count for label, count in counts.items() if count} == {"CORRIDOR": 2, "CLASSROOM": 1, "BATHROOM": 1}
