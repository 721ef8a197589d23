"""What is behind unopened doors, from similar doors: answers by hand."""

from dataclasses import replace

import networkx as nx
import numpy as np
import pytest

from pianta.prediction.explored_part import ExploredPart, read_explored_part
from pianta.prediction.label_distributions import mix_labels
from pianta.prediction.open_ends import DoorExample
from pianta.prediction.similar_doors import LEAST_DOORS, DoorWeights, SimilarDoors
from tests.generated_types import SCHOOL

NAMES = [*SCHOOL.by_name]


def make_example(near: str, far: str, *, area: float | None = None, known_label: str = "CLASSROOM") -> DoorExample:
    return DoorExample(0, near, None, far, area, np.array([float(name == known_label) for name in NAMES]))


def make_part(label: str = "CLASSROOM", area: float | None = None) -> ExploredPart:
    """One room with an unopened door, 1."""
    graph = nx.path_graph(2)
    nx.set_node_attributes(graph, {0: {"label": label}, 1: {"label": None, "partial": True}})
    if area:
        graph.nodes[0]["area"] = area
    return read_explored_part(graph, SCHOOL)


def test_frequencies_by_label_function_and_of_all():
    """Behind two classrooms a closet and a lab, behind a gym (FUNCTIONAL too) a closet, behind a closet a bathroom."""
    examples = [
        make_example("CLASSROOM", "CLOSET"),
        make_example("CLASSROOM", "LAB"),
        make_example("GYM", "CLOSET"),
        make_example("CLOSET", "BATHROOM"),
    ]
    doors = SimilarDoors(examples, SCHOOL, DoorWeights(any_doors=1.0, function_doors=2.0))
    predicted = doors.predict(make_part())[1]
    total = 4 + LEAST_DOORS * len(NAMES)
    prior = {"CLOSET": (2 + LEAST_DOORS) / total, "BATHROOM": (1 + LEAST_DOORS) / total}
    # Three doors of FUNCTIONAL rooms, and all doors as one more.
    function = {"CLOSET": (2 + prior["CLOSET"]) / 4, "BATHROOM": prior["BATHROOM"] / 4}
    # Two doors of classrooms, and those of FUNCTIONAL rooms as two more.
    assert predicted["CLOSET"] == pytest.approx((1 + 2 * function["CLOSET"]) / 4)
    assert predicted["BATHROOM"] == pytest.approx(2 * function["BATHROOM"] / 4)
    assert sum(predicted.values()) == pytest.approx(1)
    assert [*predicted] == NAMES


def test_rooms_of_another_size_count_less():
    """A classroom twice as large counts exp(-ln(2)² / (2 · 0.5²)); one of unknown size fully."""
    examples = [
        make_example("CLASSROOM", "CLOSET", area=50.0),
        make_example("CLASSROOM", "LAB", area=100.0),
        make_example("CLASSROOM", "BATHROOM"),
    ]
    weights = DoorWeights(any_doors=1e-9, function_doors=1e-9)
    predicted = SimilarDoors(examples, SCHOOL, weights).predict(make_part(area=50.0))[1]
    assert predicted["LAB"] / predicted["CLOSET"] == pytest.approx(np.exp(-(np.log(2) ** 2) / 0.5))
    assert predicted["BATHROOM"] == pytest.approx(predicted["CLOSET"])


def test_floors_with_other_labels_count_less():
    """Labels of which none is common diverge by one bit: exp(-1 / 0.2)."""
    examples = [make_example("CLASSROOM", "CLOSET"), make_example("CLASSROOM", "LAB", known_label="GYM")]
    weights = DoorWeights(any_doors=1e-9, function_doors=1e-9)
    predicted = SimilarDoors(examples, SCHOOL, weights).predict(make_part())[1]
    assert predicted["LAB"] / predicted["CLOSET"] == pytest.approx(np.exp(-5))


def test_doors_of_corridors_and_of_rooms_are_apart():
    """Behind corridors are classrooms, behind classrooms closets."""
    corridor = replace(make_example("CORRIDOR", "CLASSROOM", known_label="CORRIDOR"), is_corridor=True)
    examples = [corridor, make_example("CLASSROOM", "CLOSET")]
    doors = SimilarDoors(examples, SCHOOL)
    for label, behind in (("CORRIDOR", "CLASSROOM"), ("CLASSROOM", "CLOSET")):
        predicted = doors.predict(make_part(label))[1]
        assert predicted[behind] > 0.95
    # Without doors of rooms, those of corridors say what there is.
    assert SimilarDoors([corridor], SCHOOL).predict(make_part())[1]["CLASSROOM"] > 0.95


def test_without_examples():
    assert SimilarDoors([], SCHOOL).predict(make_part()) == {}


def test_mixed_labels():
    """Half from samples, half from similar doors; the most probable first."""
    assert mix_labels({"LAB": 0.75, "GYM": 0.25}, {"GYM": 0.8, "CLOSET": 0.2}) == pytest.approx(
        {"GYM": 0.525, "LAB": 0.375, "CLOSET": 0.1}
    )
    assert [*mix_labels({"LAB": 0.75, "GYM": 0.25}, {"GYM": 0.8, "CLOSET": 0.2})] == ["GYM", "LAB", "CLOSET"]
    assert mix_labels({"LAB": 1.0}, {}) == {"LAB": 1.0}
    assert [*mix_labels({}, {"GYM": 0.2, "LAB": 0.8})] == ["LAB", "GYM"]
    assert mix_labels({}, {}) == {}
