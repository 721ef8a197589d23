"""Building types of maps that are still growing, by a forest of whole floors and one of parts of floors."""

from dataclasses import replace

import numpy as np
import pytest
from shapely import box

from pianta.building_types.growing_map_types import (
    DEFAULT_PART_MODEL,
    GrowingMapTypeModel,
    mix_predictions,
    read_default_growing_map_type_model,
    train_part_types,
)
from pianta.building_types.map_types import (
    OTHER,
    MapExamples,
    MapTypePrediction,
    name_map_features,
    train_map_types,
)
from pianta.errors import LabelError
from pianta.floor import Floor, Room

MAX_PART_BYTES = 1_500_000
# Four rooms in a row without doors.
ROW = Floor(tuple(Room(number, box(4 * number, 0, 4 * number + 4, 3 + number)) for number in range(1, 5)))


def make_examples(classes: tuple[str, ...], buildings: int = 10) -> MapExamples:
    """Three floors of each building, with random features: no forest can know their type."""
    count = 3 * buildings
    features = np.random.default_rng(0).normal(0, 1, (count, len(name_map_features())))
    types = tuple(classes[i // 3 % len(classes)] for i in range(count))
    return MapExamples(features, types, tuple(f"b{i // 3}" for i in range(count)), tuple(map(str, range(count))))


@pytest.fixture(scope="module")
def model():
    examples = make_examples(("office", OTHER, "school"))
    return GrowingMapTypeModel(train_map_types(examples), train_part_types(examples))


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
        expected = model.part_model.predict(ROW)
        assert expected.probabilities != pytest.approx(dict(model.floor_model.predict(ROW).probabilities))
        assert model.predict(make_partial(4)).probabilities == pytest.approx(dict(expected.probabilities))

    def test_with_half_of_the_rooms_complete_the_model_of_parts_counts_seven_eighths(self, model):
        expected = mix_predictions(model.floor_model.predict(ROW), model.part_model.predict(ROW), 7 / 8)
        assert model.predict(make_partial(2)).probabilities == pytest.approx(dict(expected.probabilities))

    def test_a_building_is_left_out_of_both(self, model):
        without = model.leave_out("b0")
        for part, before in ((without.floor_model, model.floor_model), (without.part_model, model.part_model)):
            assert "b0" not in part.examples.buildings
            assert len(part.examples.types) == len(before.examples.types) - 3

    def test_a_floor_without_rooms_has_no_type(self, model):
        with pytest.raises(LabelError, match="no rooms"):
            model.predict(Floor(()))

    def test_models_of_other_types_do_not_fit(self, model):
        other = train_part_types(make_examples(("hospital", OTHER)))
        with pytest.raises(LabelError, match=r"knows office, other, school, that of parts hospital, other; train both"):
            GrowingMapTypeModel(model.floor_model, other)


def test_the_models_that_come_with_pianta():
    model = read_default_growing_map_type_model()
    assert model.part_model.classes == ("office", OTHER, "school")
    assert DEFAULT_PART_MODEL.stat().st_size < MAX_PART_BYTES
    prediction = model.predict(make_partial(4))
    assert sum(prediction.probabilities.values()) + prediction.neither == pytest.approx(1)
