"""Our policy: what it chooses by hand-made expectations, and whole runs in a small school."""

from math import inf

import numpy as np
import pytest

from pianta.errors import OptionError
from pianta.exploration import frontier_area
from pianta.exploration.expectations import Beyond, RoomExpectations
from pianta.exploration.explore import explore
from pianta.exploration.predicted_gain import PredictedGain
from pianta.exploration.world import build_world
from pianta.generation.type_model import learn_type
from pianta.labels import SCHEMAS
from pianta.prediction.unexplored_part import FloorSampler
from tests.expected_floors import (
    CORRIDOR_DOOR,
    LIBRARY_DOOR,
    make_policy_input,
    recognised_rooms,
    school_sampler,
    sight_only_weights,
)
from tests.test_exploration import ids_of
from tests.typed_floors import make_school

# The corridor's door is near the robot, the library's is far; either leads to as much.
AT_DOORS = [(19, 1.5), (0.5, 2.5)]
WAYS = [[4, 9]]


@pytest.fixture
def plain(monkeypatch):
    """What is in sight is all that is found, and the gym is behind the library."""
    monkeypatch.setattr(frontier_area, "_read_weights", sight_only_weights)
    result = Beyond({LIBRARY_DOOR: 20.0, CORRIDOR_DOOR: 20.0}, {LIBRARY_DOOR: 1.0, CORRIDOR_DOOR: 0.0})
    monkeypatch.setattr(RoomExpectations, "predict_beyond", lambda *_: result)


@pytest.fixture(scope="module")
def sampler():
    """Floors as those of three schools on either side of a corridor."""
    floors = [make_school(rooms, source=f"school {'abcdef'[rooms]}.xml") for rooms in (3, 4, 5)]
    return FloorSampler(learn_type([floor.graph() for floor in floors], SCHEMAS["school"]))


@pytest.fixture(scope="module")
def school():
    """A school of seven rooms that the model does not know."""
    return build_world(make_school(4, width=6, source="school x.xml"), resolution=0.2)


def test_a_search_goes_to_the_door_behind_which_the_label_is_certain(plain):
    inputs = make_policy_input(AT_DOORS, WAYS, recognised=recognised_rooms())
    assert ids_of(PredictedGain(school_sampler()).choose(inputs)) == [0]
    assert ids_of(PredictedGain(school_sampler(), find="gym").choose(inputs)) == [1]


def test_two_robots_get_different_frontiers_and_the_last_may_get_none(plain):
    inputs = make_policy_input(AT_DOORS, [*WAYS, *WAYS], recognised=recognised_rooms())
    for find in (None, "gym"):
        first, second = ids_of(PredictedGain(school_sampler(), find=find).choose(inputs))
        assert {first, second} == {0, 1}
    assert ids_of(PredictedGain().choose(make_policy_input([(19, 1.5)], [[4], [5]]))) == [0, None]
    assert ids_of(PredictedGain().choose(make_policy_input(AT_DOORS, [[inf, inf], [4, 9]]))) == [None, 0]


def test_robots_keep_apart():
    # Two frontiers side by side, and one that is a little further.
    inputs = make_policy_input([(19, 1.5), (18, 1.5), (3, 2.5)], [[3, 3.5, 8], [3, 3.5, 6]])
    assert ids_of(PredictedGain().choose(inputs)) == [0, 2]


def test_without_a_model_the_unknown_in_sight_is_all_that_is_expected():
    _, areas, hits = PredictedGain().expect(make_policy_input(AT_DOORS, WAYS, recognised=recognised_rooms()))
    assert (areas > 1).all()
    assert not hits.any()
    all_known = np.zeros((20, 50), np.int8)
    assert PredictedGain().expect(make_policy_input(AT_DOORS, WAYS, cells=all_known))[1].tolist() == [0.25, 0.25]


def test_what_is_hardly_worth_the_way_is_left_for_the_last():
    inputs = np.full((20, 50), 0, np.int8)
    inputs[:8, :] = -1
    # The unknown is out of sight of the near frontier, but in that of the far one.
    inputs[10, :] = 100
    poor = make_policy_input([(5, 1), (12, 6)], [[1, 20]], cells=inputs)
    assert ids_of(PredictedGain().choose(poor)) == [1]
    assert ids_of(PredictedGain().choose(make_policy_input([(5, 1), (12, 6)], [[1, inf]], cells=inputs))) == [0]


def test_the_share_that_was_seen_is_that_of_all_that_is_expected():
    inputs = make_policy_input(AT_DOORS, WAYS)
    # The corridor has 60 m².
    assert PredictedGain().expect_share(inputs, np.array([15.0, 5.0])) == pytest.approx(0.75)


def test_it_advises_to_stop_when_enough_was_seen(plain):
    inputs = make_policy_input(AT_DOORS, [*WAYS, *WAYS], recognised=recognised_rooms())
    _, areas, _ = PredictedGain(school_sampler()).expect(inputs)
    share = 60 / (60 + areas.sum())
    assert PredictedGain(school_sampler(), enough=share - 0.01).choose(inputs) == [None, None]
    assert None not in PredictedGain(school_sampler(), enough=share + 0.01).choose(inputs)


@pytest.mark.parametrize("enough", [0, -1, 1.1, float("nan")])
def test_a_share_without_meaning_is_refused(enough):
    with pytest.raises(OptionError, match="share"):
        PredictedGain(school_sampler(), enough=enough)


def test_a_share_needs_a_model():
    with pytest.raises(OptionError, match="model"):
        PredictedGain(enough=0.9)


@pytest.mark.slow
def test_a_school_is_explored_to_the_end_and_always_alike(sampler, school):
    one, again = (explore(school, PredictedGain(sampler), starts=[(1, 1.5)]) for _ in range(2))
    assert one.outcome == "done"
    assert one.share[-1] > 0.99
    assert np.array_equal(one.tracks[0], again.tracks[0])


def test_a_run_ends_by_its_advice(sampler, school):
    run = explore(school, PredictedGain(sampler, enough=0.6), starts=[(1, 1.5)])
    assert run.outcome == "stopped by the policy"
    assert 0.2 < run.share[-1] < 0.95


def test_a_search_prefers_the_wanted_room(sampler, school):
    run = explore(school, PredictedGain(sampler, find="closet"), starts=[(1, 1.5)], find="closet")
    assert run.outcome == "found CLOSET"


@pytest.mark.slow
def test_several_robots_explore(sampler, school):
    run = explore(school, PredictedGain(sampler), starts=[(1, 1.5)], robots=2)
    assert run.outcome == "done"
    assert (run.robot_distance[-1] > 5).all()
