"""Building types of maps that are still growing, by a model of whole floors and one of parts of floors."""

from dataclasses import replace

import numpy as np
import pytest
from shapely import box

from pianta.building_types.growing_map_types import (
    GrowingMapTypeModel,
    mix_predictions,
    read_default_growing_map_type_model,
)
from pianta.building_types.map_types import (
    OTHER,
    MapExamples,
    MapTypePrediction,
    describe_map,
    name_map_features,
    train_map_types,
)
from pianta.building_types.partial_map_types import train_partial_map_types
from pianta.errors import LabelError
from pianta.floor import Floor, Room
from pianta.rooms.features import describe_rooms
from pianta.worlds.floors import make_floor
from pianta_bench.data.annotated_floors import read_annotated_floors
from pianta_bench.data.typed_maps import name_training_building

# Four rooms in a row without doors.
ROW = Floor(tuple(Room(number, box(4 * number, 0, 4 * number + 4, 3 + number)) for number in range(1, 5)))


def make_examples(classes: tuple[str, ...], buildings: int = 10) -> MapExamples:
    """Three floors of each building, with random features: no model can know their type."""
    count = 3 * buildings
    features = np.random.default_rng(0).normal(0, 1, (count, len(name_map_features())))
    types = tuple(classes[i // 3 % len(classes)] for i in range(count))
    return MapExamples(features, types, tuple(f"b{i // 3}" for i in range(count)), tuple(map(str, range(count))))


@pytest.fixture(scope="module")
def model():
    examples = make_examples(("office", OTHER, "school"))
    return GrowingMapTypeModel(train_map_types(examples), train_partial_map_types(examples))


def make_partial(count: int) -> Floor:
    """The row; the first rooms were seen in part."""
    return replace(ROW, rooms=tuple(replace(room, partial=room.id <= count) for room in ROW))


class TestMixPredictions:
    FIRST = MapTypePrediction({"office": 0.1, "school": 0.8}, 0.1)
    SECOND = MapTypePrediction({"office": 0.4, "school": 0.2}, 0.4)

    def test_half_of_each_by_hand(self):
        # Square roots of 0.04, 0.16 and 0.04: 0.2, 0.4, 0.2
        mixed = mix_predictions(self.FIRST, self.SECOND, 0.5)
        assert mixed.probabilities == pytest.approx({"office": 0.25, "school": 0.5})
        assert mixed.neither == pytest.approx(0.25)

    @pytest.mark.parametrize(("weight", "expected"), [(0.0, FIRST), (1.0, SECOND)])
    def test_no_weight_and_all_weight(self, weight, expected):
        mixed = mix_predictions(self.FIRST, self.SECOND, weight)
        assert mixed.probabilities == pytest.approx(dict(expected.probabilities))
        assert mixed.neither == pytest.approx(expected.neither)


class TestGrowingMapTypeModel:
    def test_a_complete_floor_is_read_by_the_model_of_whole_floors(self, model):
        expected = model.floor_model.predict(ROW)
        assert model.predict(ROW).probabilities == pytest.approx(dict(expected.probabilities))

    def test_a_floor_without_a_complete_room_is_read_by_the_model_of_parts(self, model):
        expected = model.partial_model.predict_description(describe_map(describe_rooms(ROW)))
        assert expected.probabilities != pytest.approx(dict(model.floor_model.predict(ROW).probabilities))
        assert model.predict(make_partial(4)).probabilities == pytest.approx(dict(expected.probabilities))

    def test_with_half_of_the_rooms_complete_the_model_of_parts_counts_seven_eighths(self, model):
        by_parts = model.partial_model.predict_description(describe_map(describe_rooms(ROW)))
        expected = mix_predictions(model.floor_model.predict(ROW), by_parts, 7 / 8)
        assert model.predict(make_partial(2)).probabilities == pytest.approx(dict(expected.probabilities))

    def test_a_building_is_left_out_of_both(self, model):
        without = model.leave_out("b0")
        for without_b0, before in (
            (without.floor_model, model.floor_model),
            (without.partial_model, model.partial_model),
        ):
            assert "b0" not in without_b0.examples.buildings
            assert len(without_b0.examples.types) == len(before.examples.types) - 3

    def test_a_building_that_it_does_not_know_cannot_be_left_out(self, model):
        with pytest.raises(LabelError, match="not trained on 'b77'"):
            model.leave_out("b77")

    def test_a_floor_without_rooms_has_no_type(self, model):
        with pytest.raises(LabelError, match="no rooms"):
            model.predict(Floor(()))

    def test_models_of_other_types_do_not_fit(self, model):
        other = train_partial_map_types(make_examples(("home", "hospital", OTHER)))
        with pytest.raises(
            LabelError, match=r"knows office, other, school, that of parts home, hospital, other; train both"
        ):
            GrowingMapTypeModel(model.floor_model, other)


def test_the_models_that_come_with_pianta():
    model = read_default_growing_map_type_model()
    assert model.partial_model.classes == ("office", OTHER, "school")
    prediction = model.predict(make_partial(4))
    assert sum(prediction.probabilities.values()) + prediction.neither == pytest.approx(1)


def make_western_half(floor: Floor) -> Floor:
    """The rooms whose centre is in the western half, every third one partial, without labels."""
    middle = np.median([room.polygon.centroid.x for room in floor])
    chosen = [room for room in floor if room.polygon.centroid.x <= middle]
    rooms = tuple(Room(room.id, room.polygon, partial=index % 3 == 0) for index, room in enumerate(chosen))
    ids = {room.id for room in rooms}
    return Floor(rooms, tuple(door for door in floor.doors if ids.issuperset(door.room_ids)))


@pytest.mark.parametrize(
    "maker",
    [
        "home",
        pytest.param("depot", marks=pytest.mark.xfail(strict=True, reason="8 of 16 exact halves of depots get a type")),
    ],
)
def test_parts_of_homes_and_depots_are_seldom_given_a_type(maker):
    model = read_default_growing_map_type_model()
    parts = [make_western_half(make_floor(maker, seed=seed)) for seed in range(16)]
    assert sum(model.predict(part).is_known for part in parts) <= 3


def test_all_drawn_buildings_can_be_left_out(data):
    floors, _ = read_annotated_floors(data)
    buildings = {name_training_building(each.building) for each in floors if each.kind in {"office", "school"}}
    assert buildings <= read_default_growing_map_type_model().buildings


def test_parts_of_schools_are_schools(data):
    """Every fourth school; the model has seen other parts of them."""
    floors, _ = read_annotated_floors(data)
    schools = [each.floor for each in floors if each.kind == "school"][::4]
    model = read_default_growing_map_type_model()
    is_right = [model.predict(make_western_half(school)).likeliest == "school" for school in schools]
    assert np.mean(is_right) >= 0.7
