"""The functions behind the commands: worlds, realism, models of a type, new buildings, explorations."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import networkx as nx
import numpy as np
import pytest
from shapely import box

import pianta
from pianta import Floor, GridMap, Room
from pianta._types import Floats
from pianta.errors import BuildingWarning, GraphError, LabelError, ModelError, OptionError
from pianta.exploration.lidar import Lidar
from pianta.generation import train
from pianta.generation.buildings import BuildingSampler
from pianta.labels import LabelSet
from pianta.realism.model import train_realism
from pianta.rooms.completion import fill_missing_labels
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta.worlds.scan import make_sample, simulate_map
from tests.explored_worlds import two_rooms
from tests.generated_types import SCHOOL, make_schools, make_wing, small_model
from tests.test_cli_generate import draw_floor

QUICK = replace(small_model(), sweeps=8, edge_moves=40, door_moves=10)
SHORT_SIGHTED = Lidar(beams=90, reach=2.0)


def as_edges(graph: nx.Graph) -> tuple[list[tuple[int, str]], list[tuple[int, int]]]:
    return [*graph.nodes(data="label")], [*graph.edges]


class TestMakeWorld:
    def test_the_sample_is_always_the_same(self):
        floor, grid = pianta.make_world()
        assert floor == make_sample()[0]
        assert (grid.cells == make_sample()[1].cells).all()

    @pytest.mark.parametrize("world_type", FLOOR_MAKERS)
    def test_every_world_type(self, world_type):
        floor, grid = pianta.make_world(world_type, seed=3, resolution=0.2, noise=0.3)
        assert floor == make_floor(world_type, seed=3)
        assert (grid.cells == simulate_map(floor, seed=3, resolution=0.2, noise=0.3).cells).all()

    def test_the_seed_is_0_unless_given(self):
        assert pianta.make_world("hall")[0] == pianta.make_world("hall", seed=0)[0]

    @pytest.mark.parametrize(
        ("arguments", "options", "message"),
        [
            (["castle"], {}, "name is 'castle', give one of sample, corridor, l, ring, hall"),
            ([], {"seed": 0}, "the sample is always the same"),
            (["sample"], {"noise": 0.5}, "the sample is always the same"),
            (["ring"], {"seed": -1}, "seed is -1, give 0 or more"),
            (["ring"], {"noise": 2}, "noise is 2, give 0 … 1"),
        ],
    )
    def test_refuses_what_makes_no_sense(self, arguments, options, message):
        with pytest.raises(OptionError, match=message):
            pianta.make_world(*arguments, **options)


class TestAssessRealism:
    WORLDS = tuple(make_floor(name, seed=seed) for name in ("corridor", "ring", "hall") for seed in range(2))

    def test_accepts_floors_or_their_model(self):
        model = train_realism(
            [fill_missing_labels(floor, LabelSet.R_C).floor for floor in self.WORLDS], label_set=LabelSet.R_C
        )
        by_floors, by_model = (pianta.assess_realism(two_rooms(), reference) for reference in (self.WORLDS, model))
        assert by_floors == by_model
        assert by_floors.score == 0
        assert len(by_floors.usual) == 6

    def test_refuses_few_buildings(self):
        with pytest.raises(ModelError, match="1 reference buildings are too few, give 3 at least"):
            pianta.assess_realism(two_rooms(), self.WORLDS[:1])

    def test_refuses_a_floor_without_rooms(self):
        with pytest.raises(LabelError):
            pianta.assess_realism(Floor(()), self.WORLDS)


class TestGenerate:
    def test_is_repeatable_with_a_seed(self):
        first, second = (pianta.generate(QUICK, 2, seed=5) for _ in range(2))
        assert [as_edges(graph) for graph in first] == [as_edges(graph) for graph in second]
        assert len(first) == 2
        assert all(nx.is_connected(graph) for graph in first)

    @pytest.mark.parametrize("rooms", [9, np.int64(9), (9, 9), [9, 9]], ids=["number", "NumPy", "tuple", "list"])
    def test_meets_a_number_of_rooms(self, rooms):
        (building,) = pianta.generate(QUICK, rooms=rooms)
        assert len(building) == 9

    def test_meets_numbers_of_labels(self):
        (building,) = pianta.generate(QUICK, at_least={"CLASSROOM": 4}, at_most={"GYM": 0})
        labels = [label for _, label in building.nodes(data="label")]
        assert labels.count("CLASSROOM") >= 4
        assert labels.count("GYM") == 0

    def test_keeps_the_rooms_of_a_floor_and_warns_of_those_without_a_door(self):
        wing = make_wing("CC")
        wing.add_node(9, label="GYM")
        wing.graph["source"] = "wing"
        with pytest.warns(BuildingWarning, match=r"rooms 10 have no door and are left out") as caught:
            (building,) = pianta.generate(QUICK, keep=draw_floor(wing))
        assert caught[0].filename == __file__
        room_nodes = [node for node, room in building.nodes(data="room") if room is not None]
        assert len(room_nodes) == 3
        assert sorted(building.nodes[node]["label"] for node in room_nodes) == ["CLASSROOM", "CLASSROOM", "CORRIDOR"]

    @pytest.mark.parametrize(
        ("options", "error", "message"),
        [
            ({"costs": "money"}, OptionError, "costs is 'money', give one of density, thesis"),
            ({"rooms": (12, 8)}, OptionError, "12 to 8 rooms is no range"),
            ({"rooms": 0}, OptionError, "0 to 0 rooms is no range"),
            ({"seed": -1}, OptionError, "seed is -1, give 0 or more"),
            ({"count": 0}, OptionError, "0 buildings are wanted"),
            ({"at_least": {"THRONE ROOM": 1}}, OptionError, "no rooms of label THRONE ROOM"),
            ({"similar_to": Floor((Room(1, box(0, 0, 1, 1), "CORRIDOR"),))}, GraphError, "floor ''"),
            ({"keep": two_rooms(door=True)}, None, ""),
            ({"similar_to": nx.path_graph(3)}, LabelError, "floor ''"),
        ],
        ids=lambda value: "-".join(value) if isinstance(value, dict) else "",
    )
    def test_refuses_what_makes_no_sense(self, options, error, message):
        if error is None:
            assert pianta.generate(QUICK, **options)
            return
        with pytest.raises(error) as caught:
            pianta.generate(QUICK, **options)
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)


class TestTrainType:
    @pytest.fixture(autouse=True)
    def _quick(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Chains that mix at once."""

        def run(sampler: BuildingSampler, seed: int) -> Floats:
            return np.random.default_rng(seed).normal(size=(3, train.CHAINS, sampler.model.sweeps))

        for name in ("_run_sweeps", "_run_edge_moves", "_run_door_moves"):
            monkeypatch.setattr(train, name, run)

    def test_accepts_graphs_with_a_schema(self, tmp_path):
        model = pianta.train_type(make_schools(), schema=SCHOOL)
        assert str(model) == str(small_model())
        assert model.mixing is not None
        model.save(tmp_path / "school.json")
        assert str(pianta.load_model(tmp_path / "school.json")) == str(model)

    def test_accepts_floors_with_a_type(self):
        floors = [replace(draw_floor(graph), building_type={"School": 1.0}) for graph in make_schools()[:3]]
        from_list, from_iterator = pianta.train_type(floors), pianta.train_type(iter(floors))  # type: ignore[arg-type]
        assert str(from_list) == str(from_iterator)
        assert from_list.building_type == "school"
        assert len(from_list.floors) == 3

    @pytest.mark.parametrize(
        ("types", "options", "error", "message"),
        [
            ([], {}, ModelError, "no floor has a building type"),
            ([], {"schema": SCHOOL}, ModelError, "0 floors given, give two at least"),
            (["school"], {}, ModelError, "1 floor given, give two at least"),
            (["school", "office"], {}, ModelError, "the buildings are of types office, school"),
            (["school", None], {}, ModelError, "has no building type"),
            (["castle", "castle"], {}, LabelError, "no schema of building type 'castle', give one by schema="),
            (["school", "school"], {"areas": "rooms"}, OptionError, "areas is 'rooms', give one of corr, ncut"),
            (["school", "school"], {"seed": -1}, OptionError, "seed is -1, give 0 or more"),
        ],
    )
    def test_refuses_what_it_cannot_use(self, types, options, error, message):
        drawings = [draw_floor(graph) for graph in make_schools()[: len(types)]]
        floors = [
            replace(floor, building_type={name: 1.0} if name else {})
            for floor, name in zip(drawings, types, strict=True)
        ]
        with pytest.raises(error) as caught:
            pianta.train_type(floors, **options)
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)


class TestExplore:
    @pytest.mark.parametrize("policy", ["nearest", "gain", "gain-exp", "predicted"])
    def test_a_floor_with_a_policy_by_its_name(self, policy):
        run = pianta.explore(two_rooms(), policy, lidar=SHORT_SIGHTED)
        assert run.outcome == "done"
        assert run.recognised_at.keys() == {1, 2}
        assert run.share[-1] > 0.999
        assert run.decisions > 0

    def test_searches_for_a_label(self):
        run = pianta.explore(two_rooms(), find="stairs", lidar=SHORT_SIGHTED, starts=[(1, 1)])
        assert (run.outcome, run.found_room) == ("found STAIRS", 2)

    def test_a_map(self):
        """A square of 2 × 2 m without a wall is seen at once."""
        run = pianta.explore(GridMap(np.zeros((20, 20), int), 0.1))
        assert (run.outcome, run.decisions) == ("done", 0)
        assert run.reachable_area == pytest.approx(4)
        assert run.distance.tolist() == [0]

    def test_a_file(self, tmp_path):
        two_rooms().save(tmp_path / "floor.geojson")
        from_floor, from_file, from_folder = (
            pianta.explore(world, lidar=SHORT_SIGHTED)
            for world in (two_rooms(), tmp_path / "floor.geojson", str(tmp_path))
        )
        assert from_floor.distance.tolist() == from_file.distance.tolist() == from_folder.distance.tolist()

    def test_a_world_type_with_the_seed(self):
        by_kind, by_floor, other = (
            pianta.explore(world, seed=seed, max_distance=1.0, lidar=SHORT_SIGHTED)
            for world, seed in (("hall", 3), (make_floor("hall", seed=3), 3), ("hall", 0))
        )
        assert by_kind.reachable_area == by_floor.reachable_area
        assert by_kind.reachable_area != other.reachable_area

    def test_accepts_starts_as_an_array(self):
        starts: list[Any] = [[(1.0, 1.0), (6.0, 1.0)], np.array([[1.0, 1.0], [6.0, 1.0]])]
        listed, array = (pianta.explore(two_rooms(), starts=each, robots=2, lidar=SHORT_SIGHTED) for each in starts)
        assert [track[0, :2].tolist() for track in array.tracks] == [[1, 1], [6, 1]]
        assert array.distance.tolist() == listed.distance.tolist()

    @pytest.mark.parametrize(
        ("world", "arguments", "options", "message"),
        [
            (two_rooms(), ["wise"], {}, "policy is 'wise', give one of nearest"),
            (two_rooms(), [], {"seed": -1}, "seed is -1, give 0 or more"),
            (two_rooms(), [], {"robots": 0}, "robots are 0"),
            (two_rooms(), [], {"stop": 2}, "stop is 2, give a share"),
            (two_rooms(), [], {"find": "GYM"}, "no room of the world is GYM, give one of CLASSROOM, STAIRS"),
            ("castle", [], {}, "world is 'castle', give a file, a folder, or one of sample"),
            (Floor(()), [], {}, "the floor has no rooms"),
        ],
    )
    def test_refuses_what_makes_no_sense(self, world, arguments, options, message):
        with pytest.raises(OptionError, match=message):
            pianta.explore(world, *arguments, **options)


def public(name: str) -> Any:
    """A public function without its types, for arguments of wrong types."""
    return getattr(pianta, name)


@pytest.mark.parametrize(
    ("call", "argument"),
    [
        (lambda floor: public("reconstruct")("map.yaml"), "grid="),
        (lambda floor: public("label_rooms")("floor.geojson"), "floor="),
        (lambda floor: public("label_rooms")(floor, "rooms.npz"), "model="),
        (lambda floor: public("classify_building")(floor, "types.json"), "model="),
        (lambda floor: public("generate")("school.json", 3), "model="),
        (lambda floor: public("predict")(floor, "school.json"), "model="),
        (lambda floor: public("assess_realism")(floor, "offices"), "reference="),
    ],
)
def test_a_path_instead_of_its_content_is_refused_by_name(call: Callable[[Any], object], argument: str) -> None:
    floor = pianta.Floor((pianta.Room(1, box(0, 0, 4, 3)),))
    with pytest.raises(OptionError, match=f"{argument} is a str"):
        call(floor)
