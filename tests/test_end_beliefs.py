"""Beliefs over what lies behind the open ends of a map that grows."""

from dataclasses import replace

import numpy as np
import pytest
from shapely import LineString, box

import pianta
from pianta import Door, Floor, Mapper, Room
from pianta.errors import ModelError, OptionError
from pianta.mapping.beliefs import MIN_PROBABILITY
from pianta.mapping.end_beliefs import predict_ends
from tests.expected_floors import ROOMS, school_sampler
from tests.generated_types import sized_model

# Behind the library is a room that was seen through the door; in all schools of the model it is a gym.
UNKNOWN = Room(4, box(-3, 5, 0, 6), partial=True)
DOORS = (
    Door((1, 2), LineString([(1, 3), (2, 3)]), 1.0),
    Door((1, 3), LineString([(5, 3), (6, 3)]), 1.0),
    Door((2, 4), LineString([(0, 5), (0, 6)]), 1.0),
)
FLOOR = Floor((*ROOMS, UNKNOWN), DOORS)


class TestPredictedEnds:
    def test_the_first_belief_is_that_of_the_samples_and_rules_no_label_out(self):
        ends, prediction = predict_ends(FLOOR, school_sampler(), {}, is_new=True)
        assert prediction is not None
        (end,), (sampled,) = ends, prediction.ends
        assert (end.name, end.near, end.room, end.is_door) == ("2-4", 2, 4, True)
        assert next(iter(end.labels)) == "GYM"
        # Each label that no sample has gets one in a thousand, and the sum stays 1
        weights = {
            label: max(sampled.labels.get(label, 0.0), MIN_PROBABILITY) for label in school_sampler().label_shares
        }
        assert end.labels["GYM"] == pytest.approx(weights["GYM"] / sum(weights.values()), abs=1e-4)
        assert end.labels["LIBRARY"] == pytest.approx(MIN_PROBABILITY / sum(weights.values()), abs=1e-4)
        assert sum(end.labels.values()) == pytest.approx(1, abs=1e-2)

    def test_a_belief_moves_half_of_the_way_in_log_odds_and_stays_if_nothing_was_read(self):
        sampler = school_sampler()
        (first,), _ = predict_ends(FLOOR, sampler, {}, is_new=True)
        even = dict.fromkeys(first.labels, 1 / len(first.labels))
        (moved,), _ = predict_ends(FLOOR, sampler, {"2-4": even}, is_new=True)
        odds = [each.labels["GYM"] / each.labels["CLASSROOM"] for each in (first, moved)]
        assert odds[1] == pytest.approx(odds[0] ** 0.5, rel=0.1)
        (same,), _ = predict_ends(FLOOR, sampler, {"2-4": even}, is_new=False)
        assert same.labels == even

    def test_nothing_is_expected_of_a_floor_without_open_ends_or_known_rooms(self):
        closed = Floor(ROOMS, DOORS[:2])
        assert predict_ends(closed, school_sampler(), {}, is_new=True) == ((), None)
        assert predict_ends(Floor((UNKNOWN,)), school_sampler(), {}, is_new=True) == ((), None)


class TestMapperWithAModel:
    def test_it_knows_the_type_and_its_beliefs_survive(self, tmp_path):
        grid = pianta.make_world("corridor")[1]
        cells = grid.cells.copy()
        cells[:, grid.shape[1] // 2 :] = -1
        half = replace(grid, cells=cells)
        mapper = Mapper(model=sized_model())
        assert mapper.building_type == "school"
        update = mapper.update(half)
        assert update.prediction is not None
        assert update.prediction.rooms.mean > 0
        ids = {room.id for room in update.floor}
        assert update.ends
        assert all({end.near, end.room} <= ids for end in update.ends)
        mapper.save(tmp_path)
        loaded = Mapper.load(tmp_path, model=sized_model())
        for each in (mapper, loaded):
            again = each.update(half)
            assert [end.labels for end in again.ends] == [end.labels for end in update.ends]
        one, other = mapper.update(grid), loaded.update(grid)
        assert [end.labels for end in one.ends] == [end.labels for end in other.ends]

    def test_without_a_model_nothing_is_expected(self):
        update = Mapper(labels=False).update(pianta.make_world("corridor")[1])
        assert (update.ends, update.prediction) == ((), None)

    def test_a_model_of_another_type_and_what_is_no_model_are_refused(self):
        with pytest.raises(ModelError, match="the building is of type 'office' and the model of 'school'"):
            Mapper(model=sized_model(), building_type="office")
        with pytest.raises(OptionError, match="model= is a ndarray, give a model of train_type or load_model"):
            Mapper(model=np.zeros(3))  # type: ignore[arg-type]
