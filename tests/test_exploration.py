"""Explorations of tiny worlds from start to end, and the choices of policies."""

import os
import subprocess
import sys
import warnings
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from shapely import LineString, box

from pianta.errors import MapWarning, OptionError
from pianta.exploration import beams
from pianta.exploration.classical_policies import InformationGain, NearestFrontier
from pianta.exploration.explore import Settings, _Run, explore
from pianta.exploration.frontiers import Frontier
from pianta.exploration.lidar import Lidar, Pose
from pianta.exploration.perception import PerfectPerception
from pianta.exploration.policies import POLICIES, make_policy
from pianta.exploration.policy_input import PolicyInput
from pianta.exploration.recognised_rooms import recognise_rooms
from pianta.exploration.robots import Robot
from pianta.exploration.world import World, build_world, read_world
from pianta.floor import Door, Floor, Room
from pianta.io.buildings.read import read_building
from pianta.worlds.floors import make_floor
from tests.explored_worlds import two_room_world, two_rooms


def row_of_rooms(*labels: str, door: bool = True) -> Floor:
    """Rooms of 4 × 4 m side by side, each with a door to the next."""
    rooms = tuple(Room(n + 1, box(4 * n, 0, 4 * n + 4, 4), label) for n, label in enumerate(labels))
    middles = [LineString([(4 * n, 1.5), (4 * n, 2.4)]) for n in range(1, len(rooms))]
    doors = tuple(Door((n, n + 1), line, 0.9) for n, line in enumerate(middles, start=1)) if door else ()
    return Floor(rooms, doors)


def make_policy_input(
    distances: list[list[float]], points: ArrayLike | None = None, *, mapped: NDArray[np.int8] | None = None
) -> PolicyInput:
    """Robots and frontiers at given distances from each other, on an unknown map of 0.1 m cells."""
    ways = np.array(distances, float)
    count = ways.shape[1]
    positions = np.array([(100.0 * n, 0) for n in range(count)] if points is None else points)
    mapped = np.full((101, 101), -1, np.int8) if mapped is None else mapped
    targets = [(50, 20 * n + 30) for n in range(count)]
    frontiers = tuple(Frontier(np.array([target]), target, 1.0, n) for n, target in enumerate(targets))
    poses = tuple(Pose(0, 0) for _ in ways)
    return PolicyInput(mapped, mapped == 0, 0.1, (0, 0, 0), poses, frontiers, ways, positions, (0,) * count, reach=2.0)


def ids_of(choice: Sequence[Frontier | None]) -> list[int | None]:
    return [None if frontier is None else frontier.id for frontier in choice]


@pytest.mark.parametrize("policy", POLICIES)
def test_two_rooms_are_explored_to_the_end(policy):
    run = explore(two_room_world(), make_policy(policy), starts=[(2, 2)])
    assert run.outcome == "done"
    assert run.share[-1] == 1
    assert run.reachable_area == pytest.approx(3.9 * 4 + 2.9 * 4 + 0.2 * 0.9)
    assert run.entered_at.keys() == {1, 2} or run.recognised_at.keys() == {1, 2}
    assert run.recognised_at[1] == 0
    assert 0 < run.distance[-1] < 20
    assert (np.diff(run.distance) >= 0).all()
    assert (np.diff(run.area) >= 0).all()
    assert len(run.distance) == len(run.area) == len(run.time) == len(run.tracks[0])


def test_distances_to_shares_are_those_of_the_log():
    run = explore(two_room_world(), NearestFrontier(), starts=[(2, 2)])
    assert run.distance_to(0) == 0
    assert run.distance_to(1.01) == inf
    half, all_ = run.distance_to(0.5), run.distance_to(1)
    assert half < all_ <= run.distance[-1]
    assert run.share[np.searchsorted(run.distance, all_)] == 1


def test_the_final_map_shows_walls_where_they_are():
    world = two_room_world()
    run = explore(world, NearestFrontier(), starts=[(2, 2)])
    free = run.map.cells == 0
    assert np.count_nonzero(free & world.blocked) < 0.01 * np.count_nonzero(world.free)
    assert (run.map.resolution, run.map.origin) == (world.resolution, world.origin)
    assert ((run.scan_of_cell >= 0) == (run.map.cells != -1)).all()


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"robots": 2}, {"drive": "differential"}, {"lidar": Lidar(field=2.0)}])
def test_the_same_seed_is_the_same_run(options):
    world = build_world(make_floor("hall", seed=2))
    first, again = (explore(world, InformationGain(), seed=7, stop=0.7, **options) for _ in range(2))
    assert np.array_equal(first.distance, again.distance)
    assert np.array_equal(first.area, again.area)
    assert np.array_equal(first.map.cells, again.map.cells)


def test_another_seed_is_another_noise():
    world, lidar = two_room_world(), Lidar(noise=0.1)
    first, other = (explore(world, NearestFrontier(), starts=[(2, 2)], lidar=lidar, seed=seed) for seed in (1, 2))
    assert not np.array_equal(first.map.cells, other.map.cells)


def test_without_numba_the_run_is_the_same(monkeypatch):
    runs = []
    for numba in (True, False):
        monkeypatch.setattr(beams, "has_numba", lambda numba=numba: numba)
        runs.append(explore(two_room_world(), InformationGain(), starts=[(2, 2)]))
    assert np.array_equal(runs[0].distance, runs[1].distance)
    assert np.array_equal(runs[0].map.cells, runs[1].map.cells)


@pytest.mark.slow
def test_the_run_is_the_same_under_every_hash_seed():
    code = (
        "from pianta.exploration.explore import explore;"
        "from pianta.exploration.classical_policies import InformationGain;"
        "from tests.explored_worlds import two_room_world;"
        "run = explore(two_room_world(), InformationGain(), robots=2);"
        "print(run.distance.tolist(), run.area.tolist(), run.recognised_at, run.entered_at)"
    )
    messages = [
        subprocess.run(
            [sys.executable, "-c", code], env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, check=True
        ).stdout
        for seed in ("1", "2")
    ]
    assert messages[0] == messages[1]
    assert messages[0]


@pytest.mark.slow
def test_the_robot_never_drives_through_a_wall():
    world = build_world(make_floor("ring", seed=4))
    run = explore(world, NearestFrontier(), stop=0.8)
    for (x0, y0, _), (x1, y1, _) in zip(run.tracks[0], run.tracks[0][1:], strict=False):
        for share in np.linspace(0, 1, 11):
            assert not world.blocked[world.cell(x0 + share * (x1 - x0), y0 + share * (y1 - y0))]


def test_a_turning_robot_drives_as_far_and_takes_longer():
    world = two_room_world()
    point, wheels = (
        explore(world, NearestFrontier(), starts=[(2, 2)], drive=drive) for drive in ("point", "differential")
    )
    assert np.array_equal(point.distance, wheels.distance)
    assert point.time[-1] == pytest.approx(point.distance[-1] / 0.5)
    assert wheels.time[-1] > point.time[-1]


def test_a_share_ends_the_run():
    run = explore(build_world(row_of_rooms(*"ABCDEF")), NearestFrontier(), starts=[(2, 2)], stop=0.5)
    assert run.outcome == "share reached"
    assert 0.5 <= run.share[-1] < 0.8
    assert run.share[-2] < 0.5


def test_a_distance_ends_the_run():
    run = explore(build_world(row_of_rooms(*"ABCDEF")), NearestFrontier(), starts=[(2, 2)], max_distance=5)
    assert run.outcome == "distance limit"
    assert 5 <= run.distance[-1] <= 5.5


def test_a_policy_can_advise_to_stop():
    class Stay:
        def choose(self, inputs):
            return [None] * len(inputs.poses)

    run = explore(two_room_world(), Stay(), starts=[(2, 3.5)])
    assert (run.outcome, run.decisions, run.distance[-1]) == ("stopped by the policy", 1, 0)


def test_a_room_of_a_label_is_found():
    world = build_world(row_of_rooms("OFFICE", "LAB", "OFFICE", "GYM"))
    run = explore(world, NearestFrontier(), starts=[(2, 2)], find="gym")
    assert (run.outcome, run.found_room) == ("found GYM", 4)
    assert 4 in run.recognised_at.keys() | run.entered_at.keys()
    assert run.distance[-1] > 3
    here = explore(world, NearestFrontier(), starts=[(2, 2)], find="office")
    assert (here.found_room, here.distance[-1]) == (1, 0)


def test_a_label_that_no_room_has_is_refused_with_a_list_of_labels():
    world = build_world(row_of_rooms("OFFICE", "LAB"))
    with pytest.raises(OptionError, match="GYM"):
        explore(world, NearestFrontier(), find="gym")
    with pytest.raises(OptionError, match="labels"):
        explore(read_world(world.grid), NearestFrontier(), find="gym")


def test_an_unreachable_room_is_a_warning_and_the_run_ends_normally():
    world = build_world(row_of_rooms("OFFICE", "GYM", door=False))
    with pytest.warns(MapWarning, match="GYM") as messages:
        run = explore(world, NearestFrontier(), starts=[(2, 2)], find="GYM")
    assert len(messages) == 1
    assert (run.outcome, run.found_room) == ("done", None)
    assert run.share[-1] > 0.99


@pytest.mark.parametrize("start", [(4, 0.5), (-50, 2)])
def test_a_start_in_a_wall_is_refused(start):
    with pytest.raises(OptionError, match="free point"):
        explore(two_room_world(), NearestFrontier(), starts=[start])


@pytest.mark.parametrize(
    ("options", "messages"),
    [
        ({"robots": 0, "radius": -1}, "robots.*radius"),
        ({"step": 0}, "step"),
        ({"stop": 1.5}, "stop"),
        ({"stop": "most"}, "most"),
        ({"drive": "legs"}, "legs"),
        ({"max_distance": inf}, "max_distance"),
    ],
)
def test_options_without_meaning_are_refused(options, messages):
    with pytest.raises(OptionError, match=messages):
        explore(two_room_world(), NearestFrontier(), **options)


@pytest.mark.parametrize("thickness", [1, 2])
def test_a_robot_never_squeezes_through_a_slit_narrower_than_itself(thickness):
    blocked = np.ones((44, 84), bool)
    blocked[2:42, 2:40] = blocked[2:42, 40 + thickness : 82] = False
    blocked[20:22, 40 : 40 + thickness] = False
    run = explore(World(blocked, 0.1), NearestFrontier(), starts=[(2, 2.2)], lidar=Lidar(noise=0))
    # The wall with the slit of 0.2 m begins at 4 m; the lidar of the robot reaches through the slit.
    assert 3.5 < run.tracks[0][:, 0].max() < 4
    assert run.outcome == "no reachable frontier"


@pytest.mark.parametrize(("came_through", "outcome"), [(True, None), (False, "no reachable frontier")])
def test_a_robot_gets_out_by_the_way_that_it_came(came_through, outcome):
    """Its map has a door of 0.3 m, too narrow for it, to the room with the last unknown cells, left of x = 1."""
    world = two_room_world()
    settings = Settings(Lidar(), 0.2, "point", 0.5, stop=None, max_distance=100.0, min_length=0.4)
    run = _Run(
        world, NearestFrontier(), settings, PerfectPerception(world), points=[(6.0, 1.95)], area=world.free,
        wanted=None, seed=0, track=None,
    )  # fmt: skip
    run.map.cells[:] = np.where(world.blocked, 100, 0)
    rows, cols = world.door_cells[0].T
    middle = world.cell(4.0, 1.95)[0]
    jambs = np.abs(rows - middle) > 1
    run.map.cells[rows[jambs], cols[jambs]] = 100
    run.map.cells[:, : world.cell(1.0, 1.0)[1]] = -1
    if came_through:
        run.robots[0].corners.insert(0, (2.0, 1.95))
    assert run._decide() == outcome
    goal = run.robots[0].goal
    assert (goal is not None) is came_through
    if goal is not None:
        assert world.point(goal.target)[0] < 2


def test_a_robot_remembers_the_corners_of_its_way():
    """1 m to the right, then 1 m up, in steps of 0.75 m."""
    robot = Robot(Pose(0.0, 0.0), route=deque([(1.0, 0.0), (1.0, 1.0)]))
    for _ in range(3):
        robot.advance(0.75)
    assert robot.corners == [(0, 0), (0.75, 0), (1, 0), (1, 0.5), (1, 1)]


def test_a_grid_map_without_truth_is_explored():
    run = explore(read_world(two_room_world().grid), NearestFrontier())
    assert run.outcome == "done"
    assert run.share[-1] == 1
    assert run.recognised_at == run.entered_at == {}


@pytest.mark.slow
def test_several_robots_explore_together_on_different_paths():
    world = build_world(make_floor("ring", seed=1))
    requested = []

    class Watched(NearestFrontier):
        def choose(self, inputs):
            choice = super().choose(inputs)
            requested.append((len(inputs.frontiers), ids_of(choice)))
            return choice

    two = explore(world, Watched(), robots=2)
    for there, chosen in requested:
        some = [frontier for frontier in chosen if frontier is not None]
        assert len(set(some)) == len(some)
        assert len(some) == min(there, 2)
    assert two.share[-1] > 0.99
    assert two.robot_distance.shape == (len(two.distance), 2)
    assert np.allclose(two.robot_distance.sum(axis=1), two.distance)
    alone = explore(world, NearestFrontier(), robots=1)
    assert two.time[-1] < alone.time[-1]


def test_the_nearest_frontier_is_chosen():
    assert ids_of(NearestFrontier().choose(make_policy_input([[5, 3, 4]]))) == [1]


def test_robots_get_different_frontiers_and_the_last_may_get_none():
    assert ids_of(NearestFrontier().choose(make_policy_input([[5, 3, 4], [2.5, 1, 9]]))) == [2, 1]
    assert ids_of(NearestFrontier().choose(make_policy_input([[1], [2]]))) == [0, None]
    assert ids_of(NearestFrontier().choose(make_policy_input([[1, 2], [inf, inf]]))) == [0, None]


@pytest.mark.slow
def test_robots_do_not_crowd():
    beside = make_policy_input([[1, 1.5, 3], [1, 1.5, 3]], [(0, 0), (0.2, 0), (50, 0)])
    assert ids_of(NearestFrontier().choose(beside)) == [0, 2]
    assert ids_of(InformationGain().choose(beside)) == [0, 2]


@pytest.mark.parametrize("worth", ["ratio", "exponential"])
def test_the_gain_is_weighed_against_the_distance(worth):
    mapped = np.full((101, 101), -1, np.int8)
    mapped[:, :40] = 0
    near_and_poor = [[2.0, 4.0]]
    assert ids_of(InformationGain(worth).choose(make_policy_input(near_and_poor, mapped=mapped))) == [1]
    assert ids_of(InformationGain(worth).choose(make_policy_input([[2.0, 40.0]], mapped=mapped))) == [0]


def test_a_gain_without_meaning_is_refused():
    with pytest.raises(OptionError, match="most"):
        InformationGain("most")  # type: ignore[arg-type]
    with pytest.raises(OptionError, match="decay"):
        InformationGain(decay=-1)
    with pytest.raises(OptionError, match="best"):
        make_policy("best")


def test_rooms_are_recognised_by_their_explored_part():
    world = build_world(row_of_rooms("OFFICE", "LAB", "GYM"))
    mapped = np.full(world.blocked.shape, -1, np.int8)
    mapped[world.room_of_cell == 1] = 0
    mapped[tuple(world.door_cells[0].T)] = 0
    observed = recognise_rooms(world, mapped)
    assert observed is not None
    assert [(room.id, room.label, room.entered) for room in observed.rooms] == [(1, "OFFICE", False)]
    assert observed.rooms[0].share == 1
    assert observed.unopened == ((1, 0),)
    assert observed.floor.doors == ()
    further = recognise_rooms(world, mapped, entered={2})
    assert further is not None
    assert [room.id for room in further.rooms] == [1, 2]
    assert [door.rooms for door in further.floor.doors] == [(1, 2)]
    assert further.unopened == ()
    assert recognise_rooms(read_world(world.grid), mapped) is None


def test_policies_get_the_recognised_rooms():
    messages = []

    class Watched(NearestFrontier):
        def choose(self, inputs):
            messages.append(inputs)
            return super().choose(inputs)

    explore(build_world(row_of_rooms(*"ABC")), Watched(), starts=[(2, 2)])
    assert messages[0].recognised.rooms[0].label == "A"
    assert {room.label for room in messages[-1].recognised.rooms} == {*"ABC"}
    assert not messages[0].cells.flags.writeable
    assert all(len(one.rooms) == len(one.frontiers) for one in messages)
    assert all(one.distances.shape == (1, len(one.frontiers)) for one in messages)


@pytest.mark.slow
def test_a_school_is_explored_to_the_end(data):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        floor = read_building(data / "buildings" / "school" / "franch1.xml")
        run = explore(build_world(floor), NearestFrontier())
    assert run.outcome == "done"
    assert run.share[-1] > 0.99


@pytest.mark.slow
def test_importing_the_simulator_does_not_import_numba():
    code = (
        "import sys, pianta.exploration.explore, pianta.exploration.policies;"
        "assert 'numba' not in sys.modules and 'scipy' not in sys.modules and 'sklearn' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_only_the_unknown_floor_is_replaced():
    # The recognised floor keeps the building type, which policies may use.
    floor = replace(two_rooms(), building_type={"school": 1.0})
    observed = recognise_rooms(build_world(floor), np.zeros(build_world(floor).blocked.shape, np.int8))
    assert observed is not None
    assert observed.floor.building_type == {"school": 1.0}


def test_more_starts_than_robots_are_refused():
    with pytest.raises(OptionError, match="starts"):
        explore(two_room_world(), make_policy("nearest"), starts=[(2, 2), (1, 1)])
