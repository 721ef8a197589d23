"""New areas of a building: branches of its own areas, around hubs that stay."""

from collections import Counter
from collections.abc import Sequence
from itertools import chain

import networkx as nx
import numpy as np
import pytest

from pianta.generation.constraints import Constraints
from pianta.generation.functional_areas import Segmentation
from pianta.generation.recombined_areas import (
    P_REMOVED,
    AreaParts,
    AreaRecombiner,
    Branch,
    build_area,
    recombine_areas,
    split_area,
)
from pianta.generation.type_model import TypeModel, count_labels
from tests.generated_types import SCHOOL, build_floor, make_wing


def single(label: str) -> Branch:
    """A room with a door to its hub."""
    return Branch((label,), (), (0,))


def make_area() -> nx.Graph:
    """A corridor with a gym, and with a classroom and its closet, both of which have a door to the corridor."""
    area = nx.Graph([(5, 9), (5, 2), (2, 7), (5, 7)])
    labels = {5: "CORRIDOR", 9: "GYM", 2: "CLASSROOM", 7: "CLOSET"}
    nx.set_node_attributes(area, labels, "label")
    return area


def test_parts_of_an_area():
    parts = split_area(make_area(), SCHOOL)
    assert (parts.hub, parts.is_corridor) == ("CORRIDOR", True)
    assert parts.branches == (Branch(("CLASSROOM", "CLOSET"), ((0, 1),), (0, 1)), single("GYM"))


def test_the_parts_make_the_area_again():
    area, again = make_area(), build_area(split_area(make_area(), SCHOOL))
    assert nx.is_isomorphic(area, again, node_match=lambda one, other: one["label"] == other["label"])
    assert again.nodes[0]["label"] == "CORRIDOR"


def test_a_hub_alone():
    area = nx.Graph()
    area.add_node(3, label="GYM")
    assert split_area(area, SCHOOL) == AreaParts("GYM", False, ())
    assert recombine_areas([AreaParts("GYM", False, ())], np.random.default_rng(0)) == [AreaParts("GYM", False, ())]


def test_branches_are_those_of_the_building_and_of_the_same_kind_of_hub():
    areas = [
        AreaParts("CORRIDOR", True, (single("CLASSROOM"), single("CLOSET"))),
        AreaParts("HALL", True, (single("GYM"),)),
        AreaParts("CLASSROOM", False, (single("LAB"),)),
    ]
    fixed = [AreaParts("CORRIDOR", True, (single("LIBRARY"),))]
    random = np.random.default_rng(0)
    counts: dict[str, Counter[str]] = {area.hub: Counter() for area in areas}
    for _ in range(4000):
        new = recombine_areas(areas, random, others=fixed)
        assert [(area.hub, area.is_corridor) for area in new] == [(area.hub, area.is_corridor) for area in areas]
        for area in new:
            counts[area.hub].update(label for branch in area.branches for label in branch.labels)
    assert counts["CLASSROOM"].keys() == {"LAB"}
    # Branches are drawn alike from all four, and their number stays the same on average, but for those that keep one,
    # or two, if they had two at least.
    p_none = P_REMOVED * np.exp(-P_REMOVED)
    p_one = 2 * P_REMOVED * (1 - P_REMOVED) * np.exp(-2 * P_REMOVED) + 2 * P_REMOVED * p_none**2
    for hub, count in (("CORRIDOR", 2 + 2 * p_none**2 + p_one), ("HALL", 1 + p_none)):
        assert counts[hub].keys() == {"CLASSROOM", "CLOSET", "GYM", "LIBRARY"}
        for number in counts[hub].values():
            assert number == pytest.approx(4000 * count / 4, rel=0.08)


def test_a_hub_has_no_more_branches_than_any_with_its_label():
    areas = [AreaParts("CORRIDOR", True, (single("CLASSROOM"),) * 3), AreaParts("HALL", True, (single("GYM"),) * 3)]
    random = np.random.default_rng(0)
    counts = {
        tuple(len(area.branches) for area in recombine_areas(areas, random, most={"HALL": 3})) for _ in range(400)
    }
    assert {hall for _, hall in counts} == {2, 3}
    assert {2, 3, 4, 5} <= {corridor for corridor, _ in counts}


def test_how_many_branches_change():
    area = AreaParts("CORRIDOR", True, tuple(single("CLASSROOM") for _ in range(10)))
    random = np.random.default_rng(1)
    counts = [len(recombine_areas([area], random)[0].branches) for _ in range(4000)]
    assert np.mean(counts) == pytest.approx(10, abs=0.15)
    # A binomial number is kept, a Poisson number is added.
    assert np.var(counts) == pytest.approx(10 * P_REMOVED * (1 - P_REMOVED) + 10 * P_REMOVED, rel=0.1)


FLOORS = (
    build_floor(("CC", "GG"), ((0, 1),), (0, 1)),
    build_floor(("AAAA", "SSS"), ((0, 1),), (0, 1)),
)
MODEL = TypeModel(SCHOOL, Segmentation.CORR, FLOORS)


def list_labels(areas) -> set[str]:
    return {*chain(*(nx.get_node_attributes(area, "label").values() for area in areas))} - {"CORRIDOR"}


def test_the_areas_of_a_building_come_from_one_floor():
    # Area 0 is of floor 0, area 3 of floor 1.
    recombiner = AreaRecombiner(MODEL, MODEL.areas, 0, Constraints())
    random = np.random.default_rng(2)
    for floor, graph in enumerate(FLOORS):
        shares = np.eye(2)[floor]
        for _ in range(20):
            assert list_labels(recombiner.renew([0, 3], shares, random)) <= list_labels([graph.graph])
    mixed = AreaRecombiner(MODEL, MODEL.areas, 0, Constraints(), mixes_floors=True)
    labels = set().union(*(list_labels(mixed.renew([0, 3], np.eye(2)[0], random)) for _ in range(20)))
    assert labels == list_labels([MODEL.areas[0], MODEL.areas[3]])


def test_fixed_areas_stay():
    fixed = make_wing("TTT")
    recombiner = AreaRecombiner(MODEL, [*MODEL.areas, fixed], 1, Constraints())
    first, *others = recombiner.renew([4, 0, 1], np.eye(2)[0], np.random.default_rng(3))
    assert first is fixed
    assert len(others) == 2


def test_constraints_are_met_or_the_areas_stay():
    random = np.random.default_rng(4)
    recombiner = AreaRecombiner(MODEL, MODEL.areas, 0, Constraints(rooms=(6, 6), at_most={"gym": 2}))
    for _ in range(30):
        counts = dict(
            zip(
                SCHOOL.by_name, count_labels(recombiner.renew([0, 1], np.eye(2)[0], random), SCHOOL).sum(0), strict=True
            )
        )
        assert sum(counts.values()) == 6
        assert counts["GYM"] <= 2
    # New areas of floor 0 have no closets, and the chosen ones have three.
    closets = AreaRecombiner(MODEL, MODEL.areas, 0, Constraints(at_least={"closet": 3}))
    result = closets.renew([0, 3], np.eye(2)[0], random)
    assert [area is real for area, real in zip(result, (MODEL.areas[0], MODEL.areas[3]), strict=True)] == [True, True]


def test_no_more_rooms_of_a_label_than_a_floor_has():
    # Floor 0 has two gyms and two classrooms.
    recombiner = AreaRecombiner(MODEL, MODEL.areas, 0, Constraints())
    random = np.random.default_rng(5)
    for _ in range(40):
        counts = count_labels(recombiner.renew([0, 1], np.eye(2)[0], random), SCHOOL).sum(axis=0)
        columns = dict(zip(SCHOOL.by_name, counts.tolist(), strict=True))
        assert columns["GYM"] <= 2
        assert columns["CLASSROOM"] <= 2


def test_shares_of_functions_are_those_of_floors():
    """Floor 0 has as many gyms as classrooms, and floor 1 has closets."""
    recombiner = AreaRecombiner(MODEL, MODEL.areas, 0, Constraints())
    graphs = [floor.graph for floor in FLOORS]

    def share_service(graphs: Sequence[nx.Graph]) -> float:
        labels = [label for graph in graphs for _, label in graph.nodes(data="label")]
        return sum(SCHOOL.by_name[label].function_in() == "SERVICE" for label in labels) / len(labels)

    bounds = sorted(share_service([graph]) for graph in graphs)
    random = np.random.default_rng(7)
    for _ in range(60):
        assert bounds[0] <= share_service(recombiner.renew([2, 3], np.eye(2)[1], random)) <= bounds[1]


def test_of_several_buildings_the_most_novel_is_made(monkeypatch):
    recombiner = AreaRecombiner(MODEL, MODEL.areas, 0, Constraints())
    shares = np.array([count_labels([floor.graph], SCHOOL)[0] for floor in FLOORS], float)
    shares /= shares.sum(axis=1, keepdims=True)

    def measure_median_distance(candidates: int) -> float:
        monkeypatch.setattr("pianta.generation.recombined_areas.CANDIDATES", candidates)
        random = np.random.default_rng(6)
        distances = []
        for _ in range(60):
            counts = count_labels(recombiner.renew([2, 3], np.eye(2)[1], random), SCHOOL).sum(axis=0)
            distances.append(np.abs(counts / counts.sum() - shares).sum(axis=1).min() / 2)
        return float(np.median(distances))

    assert measure_median_distance(8) > measure_median_distance(1)
