"""Generated buildings: with constraints, similar to a floor, around a floor; and reproducible by the seed."""

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pianta.errors import ModelError, OptionError
from pianta.generation.area_clusters import AreaKernel
from pianta.generation.buildings import MAX_BUILDINGS, BuildingSampler, Costs, generate_buildings
from pianta.generation.constraints import Constraints
from pianta.generation.functional_areas import Segmentation
from pianta.generation.type_model import TypeFloor, TypeModel, assign_area_clusters, learn_type
from tests.generated_types import SCHOOL, build_floor, join_wings, make_wing, small_model

# The explored part of a building, with names of rooms that are not numbers.
OBSERVED = nx.relabel_nodes(join_wings(("CCCT", "GS"), ((0, 1),), source="seen"), lambda node: f"room {node}")


@cache
def quick_model(segmentation=Segmentation.CORR) -> TypeModel:
    """The small model with few iterations."""
    return replace(small_model(segmentation), sweeps=6, edge_moves=30, door_moves=6)


@cache
def seen_floor() -> TypeFloor:
    return assign_area_clusters(OBSERVED, quick_model())


def list_rooms(building) -> tuple[list[Any], list[Any]]:
    """The rooms and doors of a building, for comparison."""
    return [*building.nodes(data=True)], sorted(tuple(sorted(edge)) for edge in building.edges)


def count_label(building, name) -> int:
    return [label for _, label in building.nodes(data="label")].count(name)


def assert_building(building, model) -> None:
    assert list(building) == [*range(len(building))]
    assert nx.is_connected(building)
    assert not [*nx.selfloop_edges(building)]
    model_labels = {label for floor in model.floors for _, label in floor.graph.nodes(data="label")}
    assert {label for _, label in building.nodes(data="label")} <= model_labels


@pytest.mark.slow
@pytest.mark.parametrize("costs", Costs)
@pytest.mark.parametrize("segmentation", Segmentation)
def test_buildings_are_floors_of_the_type(segmentation, costs):
    model = quick_model(segmentation)
    buildings = generate_buildings(model, 12, costs=costs)
    assert len(buildings) == 12
    for building in buildings:
        assert_building(building, model)
        assert not nx.get_node_attributes(building, "room")
    assert len({nx.weisfeiler_lehman_graph_hash(building, node_attr="label") for building in buildings}) > 6


def test_sizes_exceed_those_of_floors_by_a_fifth_at_most():
    sizes = [len(floor.graph) for floor in quick_model().floors]
    result = [len(building) for building in generate_buildings(quick_model(), 60)]
    assert 0.8 * min(sizes) - 0.5 <= min(result)
    assert max(result) <= 1.2 * max(sizes) + 0.5
    assert len(set(result)) > 5


@pytest.mark.slow
@settings(max_examples=8)
@given(st.lists(st.integers(0, 40), min_size=1, max_size=4, unique=True), st.integers(0, 2**32))
def test_buildings_are_independent_of_each_other(numbers, seed):
    constraints = Constraints(rooms=(15, 16), at_least={"gym": 1})
    together = BuildingSampler(quick_model(), constraints).sample(numbers, seed=seed)
    for number, building in zip(numbers, together, strict=True):
        (alone,) = BuildingSampler(quick_model(), constraints).sample([number], seed=seed)
        assert list_rooms(alone) == list_rooms(building)


@pytest.mark.slow
@pytest.mark.parametrize("given_floor", ["none", "similar_to", "fixed"])
def test_batches_are_the_same_as_all_at_once(given_floor):
    template, fixed_floor = (seen_floor() if given_floor == name else None for name in ("similar_to", "fixed"))
    sampler = BuildingSampler(quick_model(), similar_to=template, fixed=fixed_floor)
    parts = [*sampler.sample(range(3), seed=2), *sampler.sample(range(3, 6), seed=2)]
    complete = BuildingSampler(quick_model(), similar_to=template, fixed=fixed_floor).sample(range(6), seed=2)
    assert list(map(list_rooms, parts)) == list(map(list_rooms, complete))


def test_areas_change_inside_unless_they_are_those_of_floors():
    """Areas of real floors are stars with the rooms of a wing; new ones have other rooms."""
    model = quick_model()
    wings = {label_star(area) for area in model.areas}
    for recombines in (True, False):
        sampler = BuildingSampler(model, recombines=recombines)
        generators = [np.random.default_rng(number) for number in range(12)]
        chosen = sampler.sample_areas(model.configurations[[3] * 12], generators)
        areas = sampler.renew_areas(chosen, generators)
        assert [len(graphs) for graphs in areas] == [len(row) for row in chosen]
        are_real = [label_star(area) in wings for graphs in areas for area in graphs]
        assert all(are_real) is not recombines
    printed = BuildingSampler(model, costs=Costs.THESIS)
    chosen = [[0, 1]]
    assert [list(map(label_star, graphs)) for graphs in printed.renew_areas(chosen, generators[:1])] == [
        [label_star(model.areas[0]), label_star(model.areas[1])]
    ]


def label_star(area: nx.Graph) -> tuple[str, ...]:
    return tuple(sorted(label for _, label in area.nodes(data="label")))


def test_each_building_follows_a_floor():
    """Without constraints no floor is followed again before all others, so all labels of a building are of one."""
    model = learn_type([make_wing("CCCCC"), make_wing("AAAAA"), make_wing("GGGGG")], SCHOOL)
    buildings = generate_buildings(replace(model, sweeps=5, edge_moves=20, door_moves=5), 9)
    rooms = [{label for _, label in building.nodes(data="label")} - {"CORRIDOR"} for building in buildings]
    for turn in (rooms[:3], rooms[3:6], rooms[6:]):
        assert sorted(map(sorted, turn)) == [["CLASSROOM"], ["GYM"], ["SMALL ADMINISTRATIVE"]]


def test_graph_hopper_follows_the_same_floors():
    model = quick_model()
    one, other = (generate_buildings(model, 3, kernel=kernel) for kernel in AreaKernel)
    # Steps 1 and 3 do not compare graphs.
    assert [list(building.nodes(data="label")) for building in one] == [
        list(building.nodes(data="label")) for building in other
    ]
    assert list(map(list_rooms, one)) != list(map(list_rooms, other))
    for building in one:
        assert_building(building, model)


def test_jobs_make_the_same_buildings():
    one, two = (generate_buildings(quick_model(), 4, seed=3, jobs=jobs) for jobs in (1, 2))
    assert list(map(list_rooms, one)) == list(map(list_rooms, two))


def test_the_first_buildings_do_not_depend_on_the_count():
    few, many = generate_buildings(quick_model(), 3, seed=1), generate_buildings(quick_model(), 9, seed=1)
    assert list(map(list_rooms, few)) == list(map(list_rooms, many[:3]))


def test_seeds_differ():
    one, two = generate_buildings(quick_model(), 3, seed=1), generate_buildings(quick_model(), 3, seed=2)
    assert list(map(list_rooms, one)) != list(map(list_rooms, two))


HASHED = """
import networkx as nx
from dataclasses import replace
from pianta.generation.buildings import generate_buildings
from pianta.generation.type_model import learn_type, assign_area_clusters
from tests.generated_types import SCHOOL, join_wings, make_schools
from tests.test_generated_buildings import OBSERVED, list_rooms
named = [nx.relabel_nodes(graph, lambda node: f"room {node}") for graph in make_schools()]
for segmentation in ("corr", "ncut"):
    model = replace(learn_type(named, SCHOOL, segmentation=segmentation), sweeps=5, edge_moves=20, door_moves=4)
    floor = assign_area_clusters(OBSERVED, model)
    for buildings in (generate_buildings(model, 3), generate_buildings(model, 2, fixed=floor, similar_to=floor)):
        print(*map(list_rooms, buildings))
"""


@pytest.mark.slow
def test_the_same_under_every_hash_seed():
    result = [
        subprocess.run(
            [sys.executable, "-c", HASHED],
            check=True,
            capture_output=True,
            text=True,
            cwd=Path(__file__).parents[1],
            env=os.environ | {"PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2", "3")
    ]
    assert "room 4" in result[0]
    assert len(set(result)) == 1


def test_constraints_are_met():
    constraints = Constraints(rooms=(14, 18), at_least={"Classroom": 6, "GYM": 1}, at_most={"closet": 3})
    buildings = generate_buildings(quick_model(), 20, constraints=constraints)
    for building in buildings:
        assert_building(building, quick_model())
        assert 14 <= len(building) <= 18
        assert count_label(building, "CLASSROOM") >= 6
        assert count_label(building, "GYM") >= 1
        assert count_label(building, "CLOSET") <= 3
    assert len({len(building) for building in buildings}) > 1


@pytest.mark.parametrize("rooms", [(3, 5), (21, 22)])
def test_sizes_that_no_floor_has(rooms):
    # Floors have 9 to 19 rooms.
    for building in generate_buildings(quick_model(), 10, constraints=Constraints(rooms=rooms)):
        assert rooms[0] <= len(building) <= rooms[1]


def test_an_exact_number_of_rooms():
    assert {
        len(building) for building in generate_buildings(quick_model(), 10, constraints=Constraints(rooms=(17, 17)))
    } == {17}


@pytest.mark.parametrize(
    ("constraints", "message"),
    [
        (Constraints(at_least={"gym": 30}), "GYM"),
        (Constraints(at_least={"canteen": 1}), "CANTEEN"),
        (Constraints(at_most={"pool": 1}), "POOL"),
        (Constraints(rooms=(500, 600)), "500"),
    ],
)
def test_constraints_that_no_building_can_meet(constraints, message):
    with pytest.raises(OptionError, match=rf"^[^\n]*{message}[^\n]*$"):
        generate_buildings(quick_model(), 2, constraints=constraints)


def test_constraints_that_contradict_fixed_rooms():
    with pytest.raises(OptionError, match="CLASSROOM") as caught:
        generate_buildings(
            quick_model(), 2, fixed=seen_floor(), constraints=Constraints(rooms=(1, 5), at_most={"classroom": 2})
        )
    assert "11" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_constraints_that_are_not_met():
    # With one corridor there is one area, and no area has that many rooms.
    constraints = Constraints(rooms=(19, 20), at_most={"corridor": 1})
    with pytest.raises(ModelError, match="60 sweeps"):
        generate_buildings(quick_model(), 1, constraints=constraints)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"count": 0}, "buildings"),
        ({"count": MAX_BUILDINGS + 1}, "100001"),
        ({"count": 1, "jobs": 0}, "jobs"),
        ({"count": 1, "seed": -1}, "seed"),
    ],
)
def test_invalid_options_are_refused(options, message):
    with pytest.raises(OptionError, match=rf"^[^\n]*{message}[^\n]*$"):
        generate_buildings(quick_model(), **options)


def test_like_a_floor():
    template = quick_model().floors[3]
    buildings = generate_buildings(quick_model(), 12, similar_to=template)
    size = len(template.graph)
    assert all(0.8 * size - 0.5 <= len(building) <= 1.2 * size + 0.5 for building in buildings)
    assert len({str(list_rooms(building)) for building in buildings}) > 6
    requested = generate_buildings(quick_model(), 4, similar_to=template, constraints=Constraints(rooms=(12, 12)))
    assert [len(building) for building in requested] == [12] * 4


def test_like_a_floor_with_areas_larger_than_any():
    floor = assign_area_clusters(make_wing("C" * 80), quick_model())
    # 81 rooms are impossible, and no constraint asks for them.
    buildings = generate_buildings(quick_model(), 2, similar_to=floor)
    assert all(nx.is_connected(building) for building in buildings)


def test_fixed_rooms_and_doors_are_in_every_building():
    for building in generate_buildings(quick_model(), 12, fixed=seen_floor(), constraints=Constraints(rooms=(14, 20))):
        assert_building(building, quick_model())
        node_of = {room: node for node, room in building.nodes(data="room") if room is not None}
        assert node_of.keys() == set(OBSERVED)
        assert sorted(node_of.values()) == [*range(len(OBSERVED))]
        assert all(building.nodes[node]["label"] == OBSERVED.nodes[room]["label"] for room, node in node_of.items())
        observed = {frozenset((node_of[one], node_of[other])) for one, other in OBSERVED.edges}
        assert {frozenset(edge) for edge in building.subgraph(node_of.values()).edges} == observed
        assert 14 <= len(building) <= 20


def test_the_fixed_part_may_be_larger_than_any_floor():
    graph = join_wings(
        ("CCCCC", "CCCC", "AAS", "GS", "CCT", "AA", "CCCCCC"), tuple((0, n) for n in range(1, 7)), source=""
    )
    floor = assign_area_clusters(graph, quick_model())
    for building in generate_buildings(quick_model(), 2, fixed=floor):
        assert len(building) >= len(graph)
        assert building.subgraph(range(len(graph))).number_of_edges() == graph.number_of_edges()


def test_fixed_rooms_a_template_and_constraints_together():
    (building,) = generate_buildings(
        quick_model(),
        1,
        fixed=seen_floor(),
        similar_to=quick_model().floors[3],
        constraints=Constraints(at_least={"small administrative": 2}),
    )
    assert count_label(building, "SMALL ADMINISTRATIVE") >= 2
    assert nx.get_node_attributes(building, "room")


@pytest.mark.slow
@pytest.mark.parametrize(
    "graphs",
    [
        [make_wing("CCT"), make_wing("AAAAAS")],
        [make_wing("CCT"), make_wing("CCT")],
        [make_wing("C"), make_wing("A")],
        [make_wing("C"), join_wings(("CCC", "GGG"), ((0, 1),), source="")],
        [nx.relabel_nodes(make_wing("CCC", hub="GYM"), {0: "hall"}), make_wing("C")],
    ],
)
@pytest.mark.parametrize("segmentation", Segmentation)
def test_types_of_two_floors(graphs, segmentation):
    model = replace(learn_type(graphs, SCHOOL, segmentation=segmentation), sweeps=5, edge_moves=20, door_moves=5)
    for building in generate_buildings(model, 6):
        assert_building(building, model)
    first, second = model.floors
    (building,) = generate_buildings(model, 1, similar_to=first, fixed=second)
    assert len(building) >= len(second.graph)


def test_clusters_that_no_floor_has_together():
    # No training floor has these areas joined; in one building all ways to join them are equally likely.
    floors = (build_floor(("CCT",), (), (0,)), build_floor(("AAS",), (), (1,)))
    model = TypeModel(SCHOOL, Segmentation.CORR, floors, 5, 20, 5)
    buildings = generate_buildings(model, 40, constraints=Constraints(rooms=(8, 8)), costs=Costs.THESIS)
    assert all(nx.is_connected(building) and len(building) == 8 for building in buildings)


def test_progress_is_reported():
    messages = []

    def track(names: Sequence[str]) -> Iterator[str]:
        for name in names:
            messages.append(name)
            yield name

    generate_buildings(quick_model(), 2, track=track)
    assert messages == [f"buildings 1 to 2: {step}" for step in ("functional areas", "functional graphs", "doors")]
