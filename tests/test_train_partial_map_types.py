"""Readings of maps of which a robot has seen a part, as training data of building types."""

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from pianta import GridMap, make_world
from pianta.building_types.map_types import name_map_features
from pianta.exploration.world import read_world

sys.path.append(str(Path(__file__).parents[1] / "training"))
training = import_module("train_partial_map_types")


@pytest.fixture(scope="module")
def world():
    _, grid = make_world("corridor", seed=1)
    return read_world(grid)


def test_the_map_is_read_at_each_share_and_stays_in_the_folder(world, tmp_path):
    run = training.Run("one", "office", "b", lambda: world)
    features, complete = training.describe_readings(run, tmp_path)
    assert 3 <= len(features) <= len(training.SHARES)
    assert features.shape[1] == len(name_map_features())
    # The numbers of rooms grow with the shares
    rooms = features[:, name_map_features().index("rooms")]
    assert rooms[-1] > rooms[0]
    assert ((complete >= 0) & (complete <= 1)).all()

    def fail() -> None:
        raise AssertionError("the world is opened again")

    again = training.describe_readings(training.Run("one", "office", "b", fail), tmp_path)
    np.testing.assert_array_equal(again[0], features)
    np.testing.assert_array_equal(again[1], complete)


def test_each_share_is_watched_once():
    class Inputs:
        resolution = 1.0
        origin = (0.0, 0.0, 0.0)

        def __init__(self, free: int) -> None:
            self.cells = np.where(np.arange(100).reshape(10, 10) < free, 0, -1).astype(np.int8)

    watcher = training.Watcher(100.0)
    watcher.policy = type("Policy", (), {"choose": lambda self, inputs: []})()
    for free in (5, 12, 13, 45, 46):
        watcher.choose(Inputs(free))
    # 12 % is the first share; 45 % passes those of 20, 30 and 40 %
    assert [np.count_nonzero(each.cells == 0) for each in watcher.maps] == [12, 45]
    assert isinstance(watcher.maps[0], GridMap)
    assert watcher.shares == [0.5, 0.65, 0.8]
