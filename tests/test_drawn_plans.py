"""Graphs that are drawn as floors: every door of the graph, rooms that do not overlap, areas of the type."""

from collections import Counter
from copy import deepcopy
from dataclasses import replace

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import box, unary_union

import pianta
from pianta.errors import BuildingWarning, GraphError, LabelError, ModelError, OptionError
from pianta.generation.drawing.arms import find_arm
from pianta.generation.drawing.blocks import Block, Rectangle, measure_contacts, paint_cells
from pianta.generation.drawing.choices import Choices, sample_choices
from pianta.generation.drawing.draw import warn_of_missing_doors
from pianta.generation.drawing.gaps import MAX_GROWTH
from pianta.generation.drawing.layouts import find_layouts
from pianta.generation.drawing.losses import (
    count_inner_corners,
    count_narrow_rooms,
    find_missing_doors,
    measure_arms,
    measure_corners,
    measure_gaps,
    measure_shape,
    measure_width,
)
from pianta.generation.drawing.programme import Programme
from pianta.generation.drawing.room_blocks import draw_room, draw_suite, stack_blocks
from pianta.generation.drawing.room_sizes import measure_wall, sample_areas, sample_corridor_aspects
from pianta.generation.drawing.short_arms import find_harmed, find_short_arm
from pianta.generation.drawing.site import OUTSIDE
from pianta.generation.drawing.strips import TreeLayout, find_adjacent_blocks
from pianta.generation.drawing.walls import build_plan, find_closed_entrances
from pianta.generation.room_shapes import OPENING
from pianta.generation.type_model import TypeModel, learn_type
from tests.generated_types import AREAS, OTHER_AREA, SCHOOL, WINGS, join_wings, make_schools, sized_model


@pytest.fixture(scope="module")
def model() -> TypeModel:
    return sized_model()


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(3)


def list_doors(graph: nx.Graph) -> set[frozenset[int]]:
    """The edges of a graph with nodes 0, 1, …, by the ids of rooms."""
    return {frozenset((one + 1, other + 1)) for one, other in graph.edges}


def check_floor(floor: pianta.Floor) -> None:
    """Rooms that do not overlap and are wide enough, doors wide enough and in the walls between their rooms."""
    polygons = {room.id: room.polygon for room in floor}
    assert sum(polygon.area for polygon in polygons.values()) == pytest.approx(
        unary_union([room.polygon for room in floor]).area, abs=1e-6
    )
    for room in floor:
        assert room.polygon.geom_type == "Polygon"
        # 1.2 m are free everywhere, but in corners behind thicker walls
        eroded = room.polygon.buffer(-0.595, join_style="mitre").buffer(0.595, join_style="mitre")
        assert room.polygon.area - eroded.area < 0.2
    for door in floor.doors:
        assert door.width >= 0.7
        near = door.line.buffer(0.4)
        assert all(near.intersects(polygons[room]) for room in door.room_ids)
        others = [room for room in floor if room.id not in door.room_ids]
        assert not any(door.line.intersects(room.polygon) for room in others)


class TestBlocks:
    def test_cells_have_their_rooms(self):
        block = Block((Rectangle(0, 0, 0, 2, 1), Rectangle(1, 0, 1, 2, 2)), 0, 2)
        assert paint_cells(block, 1).tolist() == [[-1] * 4, [-1, 0, 0, -1], [-1, 1, 1, -1], [-1] * 4]
        assert block.mirrored() == block

    def test_mirrored_exchanges_left_and_right(self):
        block = Block((Rectangle(5, 0, 0, 2, 3), Rectangle(6, 2, 0, 3, 1)), 0, 2)
        assert block.mirrored() == Block((Rectangle(5, 1, 0, 3, 3), Rectangle(6, 0, 0, 1, 1)), 1, 3)

    def test_contacts_are_the_longest_straight_walls(self):
        cells = np.array([[0, 0, 0, 1], [0, 2, 2, 1], [0, 2, 2, -1]], np.int32)
        assert measure_contacts(cells) == {(0, 1): 1, (0, 2): 2, (1, 2): 1}

    def test_a_wall_that_is_interrupted_counts_in_parts(self):
        cells = np.array([[0, 0, 0, 0, 0], [1, 1, 2, 1, -1]], np.int32)
        assert measure_contacts(cells)[0, 1] == 2

    @pytest.mark.parametrize(("area", "size"), [(96.0, (8, 12)), (24.0, (4, 5)), (432.0, (27, 16))])
    def test_usual_small_and_large_rooms_of_a_row_of_12(self, area, size, rng):
        """8 × 12 cells; small, √20 wide; large, √(432 / 1.6) deep."""
        block = draw_room(1, area, 12, rng)
        assert abs(block.width - size[0]) <= 1
        assert abs(block.height - size[1]) <= 1

    def test_a_suite_is_a_rectangle_with_a_small_room_at_its_back(self, rng):
        """9 cells would be a strip of 3 × 10, as wide as narrow rooms are, and more than 3.5 times 2.7."""
        block = draw_suite(0, [1], {0: 100.0, 1: 9.0}, 12, rng)
        cells = paint_cells(block, 0)
        assert (cells >= 0).all()
        assert set(cells[0].tolist()) == {0}
        assert 1 in cells[-1]
        assert measure_contacts(cells)[0, 1] >= 3

    def test_two_rooms_of_a_suite_are_a_strip_beside_it(self, rng):
        """20 + 30 cells in a row of 10 are a strip 5 wide, one behind the other; the room is 10 × 10."""
        block = draw_suite(0, [1, 2], {0: 100.0, 1: 20.0, 2: 30.0}, 10, rng)
        assert paint_cells(block, 0).tolist() == [[2] * 5 + [0] * 10] * 6 + [[1] * 5 + [0] * 10] * 4
        assert (block.start, block.stop) == (5, 15)

    def test_a_small_room_is_in_front_of_a_room_that_is_reached_through_a_suite(self, rng):
        """Strips of 50 cells, 5 × 10, on both sides of a room of 8 × 10; the second one has inner rooms alone."""
        areas = {0: 80.0, 1: 15.0, 2: 20.0, 3: 30.0, 4: 35.0}
        block = draw_suite(0, [2, 3, 4], areas, 10, rng, front=1)
        cells = paint_cells(block, 0)
        assert cells[0].tolist() == [1] * 5 + [0] * 8 + [3] * 5
        assert cells[-1].tolist() == [4] * 5 + [0] * 8 + [2] * 5
        contacts = measure_contacts(cells)
        assert min(contacts[0, inner] for inner in (2, 3, 4)) >= 3

    def test_blocks_behind_a_room_have_wall_for_a_door(self, rng):
        room = draw_room(0, 40.0, 10, rng)
        behind = [draw_room(number, 60.0, 10, rng) for number in (1, 2)]
        for count in (1, 2):
            contacts = measure_contacts(paint_cells(stack_blocks(room, behind[:count]), 0))
            assert all(contacts[0, number] >= 3 for number in range(1, count + 1))


class TestArms:
    CELLS = np.full((9, 12), -1, np.int32)
    CELLS[3:6, 0:3] = 0
    CELLS[3:6, 9:12] = 1

    def test_the_shortest_arm_is_straight(self):
        arm = find_arm(self.CELLS, 0, 1, 3)
        assert arm is not None
        assert np.argwhere(arm).tolist() == np.argwhere(np.pad(np.ones((3, 6)), ((3, 3), (3, 3)))).tolist()

    def test_it_goes_around_what_is_between(self):
        cells = self.CELLS.copy()
        cells[2:, 5:7] = 2
        arm = find_arm(cells, 0, 1, 2)
        assert arm is not None
        assert not (arm & (cells >= 0)).any()
        cells[arm] = 0
        assert measure_contacts(cells)[0, 1] >= 2

    @pytest.mark.parametrize("gap", [6, 30, 90])
    def test_it_is_the_same_at_any_distance(self, gap):
        """Ways are searched for nearby first."""
        cells = np.full((9, gap + 6), -1, np.int32)
        cells[3:6, :3], cells[3:6, -3:] = 0, 1
        arm = find_arm(cells, 0, 1, 3)
        assert arm is not None
        assert np.argwhere(arm).tolist() == np.argwhere(np.pad(np.ones((3, gap)), ((3, 3), (3, 3)))).tolist()

    def test_none_if_there_is_no_way(self):
        cells = self.CELLS.copy()
        cells[:, 5:7] = 2
        assert find_arm(cells, 0, 1, 2) is None
        assert find_arm(self.CELLS, 0, 1, 4) is None

    def test_without_a_way_it_leads_along_the_walls_of_a_large_room(self):
        """Rooms 0 and 1 on both sides of a room of 20 × 13 cells, with a cell of free space around."""
        cells = np.full((20, 23), 2, np.int32)
        cells[:, :5], cells[:, 18:] = 0, 1
        cells = np.pad(cells, 1, constant_values=-1)
        arm = find_short_arm(cells, 0, 1, nx.Graph([(0, 2), (2, 1)]), corridors={0})
        assert arm is not None
        assert np.argwhere(arm).tolist() == np.argwhere(np.pad(np.ones((5, 13)), ((1, 16), (6, 6)))).tolist()

    def test_it_takes_nothing_from_corridors_or_of_rooms_that_would_be_small(self):
        cells = np.full((20, 23), 2, np.int32)
        cells[:, :5], cells[:, 18:] = 0, 1
        cells = np.pad(cells, 1, constant_values=-1)
        assert find_short_arm(cells, 0, 1, nx.Graph(), corridors={0, 2}) is None
        cells[13:] = OUTSIDE
        assert find_short_arm(cells, 0, 1, nx.Graph(), corridors={0}) is None

    def test_rooms_are_harmed_that_lose_a_door_or_fall_into_parts(self):
        cells = np.full((9, 6), 1, np.int32)
        cells[:, 0] = 0
        cells[:, 5] = 2
        arm = np.zeros(cells.shape, bool)
        arm[:, 4] = True
        assert find_harmed(cells, 0, arm, nx.Graph([(1, 2)])) == {1, 2}
        arm[:, 4], arm[4, 1:5] = False, True
        assert 1 in find_harmed(cells, 0, arm, nx.Graph())


class TestChoices:
    RING = nx.cycle_graph(4)

    def test_the_tree_leaves_out_the_edge_with_the_highest_weight(self):
        choices = Choices(0, False, {(0, 1): 0.1, (0, 3): 0.2, (1, 2): 0.9, (2, 3): 0.3}, {})
        assert sorted(choices.find_tree(self.RING, frozenset()).edges) == [(0, 1), (0, 3), (2, 3)]

    @pytest.mark.parametrize(("chance", "edges"), [(0.4, [(0, 1), (0, 3), (1, 2)]), (1.0, [(0, 1), (0, 3), (2, 3)])])
    def test_corridors_lead_to_corridors_and_most_rooms_to_nothing(self, chance, edges):
        """The corridors 0 and 1 keep their edge; rooms 2 and 3 keep theirs to corridors, except for much chance."""
        choices = Choices(0, False, {(0, 1): 1.0, (0, 3): 0.2, (1, 2): chance, (2, 3): 0.0}, {})
        assert sorted(choices.find_tree(self.RING, frozenset({0, 1})).edges) == edges

    def test_a_change_changes_one_thing(self, rng):
        choices = sample_choices(self.RING, 0, alleys=False, rng=rng)
        for _ in range(50):
            changed = choices.change([0, 1], [(0, 1)], [2], rng)
            same_tree, same_rooms = changed.weights == choices.weights, changed.seeds == choices.seeds
            same_root = (changed.root, changed.alleys) == (choices.root, choices.alleys)
            assert same_tree + same_rooms + same_root == 2
            assert all(changed.seeds[room] == choices.seeds[room] for room in (0, 1, 3))

    def test_random_numbers_of_a_room_are_the_same_again(self, rng):
        choices = sample_choices(self.RING, 0, alleys=False, rng=rng)
        assert choices.make_rng(1).random() == choices.make_rng(1).random()
        assert choices.make_rng(1).random() != choices.make_rng(2).random()


class TestLosses:
    def test_missing_doors_have_less_than_three_cells_of_wall(self):
        cells = np.array([[0, 0, 0, 2, 2], [1, 1, 1, 1, 1]], np.int32)
        assert find_missing_doors(cells, nx.Graph([(0, 1), (1, 2), (2, 0)])) == ((0, 2), (1, 2))

    def test_the_shape_is_the_bounding_box_over_the_area_and_its_elongation(self):
        cells = paint_cells(Block((Rectangle(0, 0, 0, 4, 2), Rectangle(1, 0, 2, 2, 4)), 0, 4), 3)
        assert measure_shape(cells) == pytest.approx(16 / 12 + 0.3)

    def test_gaps_lose_by_their_way(self):
        """Arms of 5 cells for each cell of the way, 6 times over the area; six times for two rooms; no way is 150."""
        cells = np.full((24, 40), -1, np.int32)
        cells[8:16, 8:16], cells[8:16, 24:32] = 0, 1
        free = measure_gaps(cells, [(0, 1)], frozenset({0}))
        assert 0.3 + 6 * 5 * 2 / 128 < free < 0.3 + 6 * 5 * 12 / 128
        assert measure_gaps(cells, [(0, 1)], frozenset()) == pytest.approx(0.3 + 6 * (free - 0.3))
        cells[4:8, 8:16], cells[16:20, 8:16], cells[4:20, 4:8], cells[4:20, 16:20] = 2, 2, 2, 2
        assert measure_gaps(cells, [(0, 1)], frozenset({0})) == pytest.approx(0.3 + 6 * 5 * 150 / (cells >= 0).sum())

    def test_inner_corners(self):
        bend = np.array([[0, 0, -1], [-1, 0, 1], [-1, 0, 1]], np.int32)
        assert count_inner_corners(bend) == 1
        cross = np.array([[1, 0, 2], [0, 0, 0], [-1, 0, 3]], np.int32)
        assert count_inner_corners(cross) == 4

    @pytest.mark.parametrize(("width", "narrow"), [(10, 0), (6, 1)])
    def test_a_long_arm_that_is_narrower_is_a_narrow_part(self, width, narrow):
        """A square of 10 cells, and an arm of 12."""
        cells = np.full((12, 24), -1, np.int32)
        cells[1:11, 1:11] = 0
        cells[1 : 1 + width, 11:23] = 0
        assert measure_width(cells == 0) == 10
        assert count_narrow_rooms(cells) == narrow
        corner = 0.05 * (width < 10)
        assert measure_corners(cells) == pytest.approx(narrow + corner)

    def test_arms_lose_by_their_number_and_by_their_share_of_the_area(self):
        assert measure_arms(np.zeros((10, 20), np.int32), 2, 10) == pytest.approx(0.6 + 60 / 200)


class TestStrips:
    STAR = nx.star_graph(5)

    def draw(self, areas: dict[int, float], aspect: float, seed: int) -> tuple[np.ndarray, Block]:
        """A corridor, room 0, with five rooms."""
        choices = sample_choices(self.STAR, 0, alleys=False, rng=np.random.default_rng(seed))
        block = TreeLayout(self.STAR, areas, frozenset({0}), choices, {0: aspect}).draw()
        return paint_cells(block, 1), block

    @pytest.mark.parametrize("seed", range(20))
    def test_rooms_do_not_overlap_and_have_wall_for_a_door(self, seed):
        """Those of 25 cells may be at an end, as wide as the corridor, those of 150 are wider than it."""
        areas = {0: 120.0, 1: 25.0, 2: 25.0, 3: 150.0, 4: 150.0, 5: 60.0}
        cells, block = self.draw(areas, 3.0, seed)
        assert (cells >= 0).sum() == sum((r.x1 - r.x0) * (r.y1 - r.y0) for r in block.rectangles)
        assert find_missing_doors(cells, self.STAR) == ()

    def test_a_corridor_has_its_aspect_where_its_rooms_leave_it(self):
        """144 cells with an aspect of 1 are 12 × 12, with an aspect of 4 6 × 24."""
        areas = {0: 144.0} | dict.fromkeys(range(1, 6), 81.0)
        for aspect, sides in ((1.0, (12, 12)), (4.0, (6, 24))):
            (corridor,) = (r for r in self.draw(areas, aspect, 1)[1].rectangles if r.room == 0)
            assert sorted((corridor.x1 - corridor.x0, corridor.y1 - corridor.y0)) == list(sides)

    def test_changed_choices_are_drawn_as_if_they_were_new(self, rng):
        """Of a school with four wings, whose corridors are in a ring."""
        graph = join_wings(*WINGS["d"], source="")
        corridors = [node for node, label in graph.nodes(data="label") if label == "CORRIDOR"]
        areas = {room: AREAS.get(label, OTHER_AREA) * 4 for room, label in graph.nodes(data="label")}
        choices = sample_choices(graph, 0, alleys=False, rng=rng)
        tree = TreeLayout(graph, areas, frozenset(corridors), choices)
        tree.draw()
        for _ in range(30):
            changed = tree.choices.change(corridors, [*graph.edges], [*graph], rng)
            tree = tree.change(changed)
            assert tree.draw() == TreeLayout(graph, areas, frozenset(corridors), changed).draw()

    def test_rows_with_rooms_of_one_size_have_one_depth(self):
        """Ten rooms of 120 cells: all but two at most, which may be at ends of the corridor, have the same sides."""
        star = nx.star_graph(10)
        areas = {0: 200.0} | dict.fromkeys(range(1, 11), 120.0)
        for seed in range(10):
            choices = sample_choices(star, 0, alleys=False, rng=np.random.default_rng(seed))
            block = TreeLayout(star, areas, frozenset({0}), choices, {0: 8.0}).draw()
            sides = Counter(
                tuple(sorted((r.x1 - r.x0, r.y1 - r.y0))) for r in block.rectangles if r.room in range(1, 11)
            )
            assert sides.most_common(1)[0][1] >= 8

    def test_blocks_with_a_door_between_them_should_be_beside_each_other(self):
        """Corridor 0 leads to rooms 1 and 2 and to corridor 3, which leads to rooms 4 and 5."""
        tree = nx.Graph([(0, 1), (0, 2), (0, 3), (3, 4), (3, 5)])
        beside, near_parent = find_adjacent_blocks(tree, 0, [(1, 5)])
        assert [*beside.edges] == [(1, 3)]
        assert near_parent == {5}
        beside, near_parent = find_adjacent_blocks(tree, 0, [(1, 2), (0, 4)])
        assert [*beside.edges] == [(1, 2)]
        assert near_parent == {4}

    def test_blocks_with_a_door_between_them_are_beside_each_other_more_often(self):
        """Two corridors, each with six rooms; one room of each has a door to one of the other."""
        graph = join_wings(("C" * 6, "C" * 6), ((0, 1),), source="")
        graph.add_edge(1, 8)
        corridors = frozenset({0, 7})
        areas = {room: 150.0 if room in corridors else 100.0 for room in graph}

        def count_doors(ordered: float, monkeypatch: pytest.MonkeyPatch) -> int:
            monkeypatch.setattr("pianta.generation.drawing.strips.ORDERED", ordered)
            complete = 0
            for seed in range(150):
                choices = sample_choices(graph, 0, alleys=False, rng=np.random.default_rng(seed))
                choices = replace(choices, weights=dict.fromkeys(choices.weights, 0.5))
                block = TreeLayout(graph, areas, corridors, choices).draw()
                complete += find_missing_doors(paint_cells(block, 1), graph) == ()
            return complete

        with pytest.MonkeyPatch.context() as monkeypatch:
            assert count_doors(1.0, monkeypatch) > 2 * count_doors(0.0, monkeypatch)


class TestLayouts:
    def test_changes_make_a_layout_better(self, rng):
        """A ring of corridors with rooms: the best layout is no worse than the best one at random."""
        ring = join_wings(("CCC",) * 4, ((0, 1), (1, 2), (2, 3), (0, 3)), source="")
        corridors = frozenset(node for node, label in ring.nodes(data="label") if label == "CORRIDOR")
        areas, needs = dict.fromkeys(ring, 120.0), dict.fromkeys(ring, 0.0)
        layouts = find_layouts(Programme(ring, corridors, areas, needs, [0.9]), rng)
        losses = [layout.loss for layout in layouts]
        assert losses == sorted(losses)
        assert all(layout.block.rooms == set(ring) for layout in layouts)
        at_random = [layout for layout in layouts if layout.tree.choices.seeds != layouts[0].tree.choices.seeds]
        assert layouts[0].loss < min(layout.loss for layout in at_random[2:])


class TestDrawPlan:
    @pytest.mark.parametrize("number", range(8))
    def test_the_floor_has_the_doors_and_labels_of_the_graph(self, model, number):
        graph = make_schools()[number]
        plan = pianta.draw_plan(graph, model, seed=number)
        assert plan.given_up == ()
        assert {frozenset(edge) for edge in plan.floor.graph().edges} == list_doors(graph)
        assert {room.id: room.label for room in plan.floor} == {
            node + 1: label for node, label in graph.nodes(data="label")
        }
        assert plan.floor.building_type == {"school": 1.0}

    def test_corridors_are_joined_by_openings_as_on_the_floors_of_the_type(self, model):
        """All that joins two corridors of the type is an opening, and nothing else is."""
        graph = make_schools()[0]
        for floor in (copied := replace(model, floors=tuple(map(deepcopy, model.floors)))).floors:
            nx.set_edge_attributes(floor.graph, True, OPENING)
        plan = pianta.draw_plan(graph, copied)
        corridors = {node + 1 for node, label in graph.nodes(data="label") if label == "CORRIDOR"}
        kinds = {door.kind for door in plan.floor.doors if {*door.room_ids} <= corridors and door.joins_rooms}
        assert kinds == {"opening"}
        assert all(door.kind == "door" for door in plan.floor.doors if not {*door.room_ids} <= corridors)
        assert max(door.width for door in plan.floor.doors if door.kind == "opening") > 2
        check_floor(plan.floor)

    def test_areas_are_those_of_the_type(self, model):
        plan = pianta.draw_plan(join_wings(("C" * 12, "C" * 12 + "G"), ((0, 1),), source=""), model)
        classrooms = [room.polygon.area for room in plan.floor if room.label == "CLASSROOM"]
        assert np.mean(classrooms) == pytest.approx(60, rel=0.1)
        (gym,) = [room.polygon.area for room in plan.floor if room.label == "GYM"]
        # 4 % are walls and rounding
        assert 0.96 * 400 < gym < (1 + MAX_GROWTH) * 400

    def test_corridors_with_more_rooms_are_larger(self, model, rng):
        graphs = make_schools()
        for graph in graphs:
            for node, room in graph.nodes(data=True):
                room["area"] = 10.0 * graph.degree[node] if room["label"] == "CORRIDOR" else 20.0
        areas = sample_areas(join_wings(("CC", "C" * 9), ((0, 1),), source=""), learn_type(graphs, SCHOOL), rng)
        assert areas[3] > areas[0]

    def test_most_rooms_have_areas_of_one_floor(self, rng):
        """Each floor has classrooms and closets of a size of its own."""
        graphs = make_schools()
        for number, graph in enumerate(graphs):
            for _, room in graph.nodes(data=True):
                room["area"] = 10.0 + number
        graph = join_wings(("C" * 40,), (), source="")
        areas = sample_areas(graph, learn_type(graphs, SCHOOL), rng, from_one_floor=True)
        rooms = [round(area, 6) for node, area in areas.items() if graph.nodes[node]["label"] == "CLASSROOM"]
        assert 25 <= max(map(rooms.count, rooms)) < 40

    def test_floors_with_many_rooms_of_the_frequent_labels_are_followed(self, rng):
        """Of ten classrooms one, of 200 m², is on the floor that has all closets; all floors have one corridor."""
        graphs = [join_wings(("C" * 3,), (), source=str(number)) for number in range(3)]
        graphs.append(join_wings(("C" + "S" * 40,), (), source="3"))
        for number, graph in enumerate(graphs):
            for _, room in graph.nodes(data=True):
                room["area"] = 200.0 if number == 3 else 50.0
        model, graph = learn_type(graphs, SCHOOL), join_wings(("C" * 8 + "S",), (), source="")
        large = [sample_areas(graph, model, rng, from_one_floor=True)[1] > 100 for _ in range(800)]
        followed = (8**2 * 0.1 + 1 * 1.0 + 1 * 0.25) / 66
        assert np.mean(large) == pytest.approx(0.75 * followed + 0.25 * 0.1, abs=0.04)

    def test_corridors_have_areas_of_those_with_as_much_wall_of_rooms(self, rng):
        """As many floors have three classrooms of 4 m² at a corridor of 10 m², and three of 400 m² at one of 90 m²."""
        graphs = [join_wings(("CCC",), (), source=str(number)) for number in range(30)]
        for number, graph in enumerate(graphs):
            for _, room in graph.nodes(data=True):
                is_corridor, is_large = room["label"] == "CORRIDOR", number % 2
                room["area"] = (90.0 if is_large else 10.0) if is_corridor else (400.0 if is_large else 4.0)
        model = learn_type(graphs, SCHOOL)
        assert measure_wall(graphs[0], 0, {1: 4.0, 2: 4.0}) == 4
        for _ in range(20):
            areas = sample_areas(graphs[0], model, rng)
            # Three rooms of 400 m² or of 4 m² each need 60 m or 6 m, two of 400 m² need 42 m
            assert (areas[0] > 50) == (sum(areas[room] > 100 for room in (1, 2, 3)) >= 2)

    def test_corridors_have_the_aspect_of_those_with_as_many_doors_and_a_similar_area(self, rng):
        """Twenty corridors with two doors, of 2, 4, … 40 m², and as many with three; the aspect is the area."""
        graphs = [join_wings(("C" * doors,), (), source=f"{doors} {n}") for doors in (2, 3) for n in range(20)]
        for number, graph in enumerate(graphs):
            for _, room in graph.nodes(data=True):
                room["area"] = 2.0 * (1 + number % 20)
                room["aspect"] = room["area"] + 100 * (number >= 20)
        model = learn_type(graphs, SCHOOL)
        aspects = [sample_corridor_aspects(graphs[0], model, {0: 9.9}, rng) for _ in range(60)]
        # Of two doors the first 15, of these the five with an area near 9.9 m²
        assert {aspect for each in aspects for aspect in each.values()} == {6.0, 8.0, 10.0, 12.0, 14.0}
        for graph in graphs:
            for _, room in graph.nodes(data=True):
                del room["aspect"]
        assert sample_corridor_aspects(graphs[0], learn_type(graphs, SCHOOL), {0: 9.9}, rng) == {}

    def test_the_same_seed_gives_the_same_floor(self, model):
        graph = make_schools()[3]
        assert pianta.draw_plan(graph, model, seed=5) == pianta.draw_plan(graph, model, seed=5)
        assert pianta.draw_plan(graph, model, seed=5) != pianta.draw_plan(graph, model, seed=6)

    def test_corridors_close_a_ring(self, model):
        ring = join_wings(("CCC",) * 4, ((0, 1), (1, 2), (2, 3), (0, 3)), source="")
        plan = pianta.draw_plan(ring, model)
        assert plan.given_up == ()
        check_floor(plan.floor)
        assert len(nx.cycle_basis(plan.floor.graph())) == 1

    def test_a_star_of_80_rooms(self, model):
        plan = pianta.draw_plan(join_wings(("C" * 80,), (), source=""), model)
        assert plan.given_up == ()
        assert len(plan.floor) == 81

    def test_doors_that_cannot_be_drawn_are_given_up_and_named(self, model):
        """K₆ is not planar: some doors have no wall."""
        graph = nx.complete_graph(6)
        nx.set_node_attributes(graph, "CLASSROOM", "label")
        plan = pianta.draw_plan(graph, model)
        assert plan.given_up
        doors = {frozenset(edge) for edge in plan.floor.graph().edges}
        assert doors | set(map(frozenset, plan.given_up)) == list_doors(graph)
        assert not doors & set(map(frozenset, plan.given_up))

    def test_entrances_lead_out(self, model):
        graph = make_schools()[0]
        graph.nodes[5]["label"] = "ENTRANCE"
        schools = [*make_schools(), graph]
        for school in schools:
            nx.set_node_attributes(school, 30.0, "area")
        plan = pianta.draw_plan(graph, learn_type(schools, SCHOOL))
        (entrance,) = [door for door in plan.floor.doors if door.is_entrance]
        assert entrance.room_ids == (6,)
        outside = box(*unary_union([room.polygon for room in plan.floor]).bounds).buffer(1)
        rooms = unary_union([room.polygon for room in plan.floor])
        assert entrance.line.buffer(0.3).intersects(outside.difference(rooms.buffer(0.2)))
        assert plan.closed_entrances == ()

    def test_entrances_without_an_outer_wall_stay_closed(self):
        """Nine rooms of 2 m in a square; only the one in the middle has no outer wall, and one is no ENTRANCE."""
        cells = np.kron(np.arange(9, dtype=np.int32).reshape(3, 3), np.ones((4, 4), np.int32))
        graph = nx.relabel_nodes(nx.grid_2d_graph(3, 3), lambda cell: 3 * cell[0] + cell[1])
        nx.set_node_attributes(graph, "ENTRANCE", "label")
        graph.nodes[8]["label"] = "CLOSET"
        programme = Programme(graph, frozenset(), dict.fromkeys(graph, 16.0), {}, (0.9,))
        floor = build_plan(np.pad(cells, 1, constant_values=-1), programme, graph.edges, np.random.default_rng(0),
                           building_type="school")  # fmt: skip
        assert sorted(door.room_ids for door in floor.doors if door.is_entrance) == [
            (n,) for n in (1, 2, 3, 4, 6, 7, 8)
        ]
        assert find_closed_entrances(floor) == (5,)

    def test_doors_that_are_missing_are_one_warning(self):
        plan = pianta.DrawnPlan(pianta.Floor(()), ((2, 3), (2, 7)), (5, 9))
        with pytest.warns(BuildingWarning) as caught:
            warn_of_missing_doors(plan, "building 4")
        (warning,) = caught
        assert str(warning.message) == (
            "building 4: no wall for doors 2–3, 2–7; no outer wall for the door to the outside of ENTRANCE 5, 9"
        )

    def test_what_cannot_be_drawn_is_refused(self, model):
        graph = make_schools()[0]
        with pytest.raises(OptionError, match="graph= is a list"):
            pianta.draw_plan([graph], model)
        with pytest.raises(OptionError, match="seed is -1"):
            pianta.draw_plan(graph, model, seed=-1)
        with pytest.raises(GraphError, match="in 2 parts"):
            pianta.draw_plan(nx.disjoint_union(graph, graph), model)
        with pytest.raises(LabelError, match="have no label"):
            pianta.draw_plan(nx.path_graph(3), model)
        bare = replace(model, floors=learn_type(make_schools(), SCHOOL).floors)
        with pytest.raises(ModelError, match=r"has no areas of rooms 'BATHROOM', 'CLASSROOM', .*train it on floors"):
            pianta.draw_plan(graph, bare)


@pytest.mark.slow
@settings(deadline=None, max_examples=12)
@given(
    st.lists(st.text("CSTA", min_size=1, max_size=6), min_size=1, max_size=5),
    st.lists(st.tuples(st.integers(0, 30), st.integers(0, 30)), max_size=3),
    st.integers(0, 99),
)
def test_any_graph_is_a_floor_without_overlaps_that_has_all_other_doors(wings, extra, seed):
    """Chains of wings with further doors between any rooms."""
    graph = join_wings(tuple(wings), tuple((wing - 1, wing) for wing in range(1, len(wings))), source="")
    nodes = len(graph)
    graph.add_edges_from((one % nodes, other % nodes) for one, other in extra if one % nodes != other % nodes)
    schools = make_schools()
    for school in schools:
        for _, room in school.nodes(data=True):
            room["area"] = AREAS.get(room["label"], OTHER_AREA)
    plan = pianta.draw_plan(graph, learn_type(schools, SCHOOL), seed=seed)
    doors = {frozenset(edge) for edge in plan.floor.graph().edges}
    assert doors | set(map(frozenset, plan.given_up)) == list_doors(graph)
    check_floor(plan.floor)
