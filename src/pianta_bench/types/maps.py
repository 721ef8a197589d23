"""Building types of robots' maps: right, unknown and wrong ones, with the building left out of the model."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from pathlib import Path

import numpy as np

from pianta._types import Floats, Indices
from pianta.building_types.map_type_file import read_default_map_type_model
from pianta.building_types.map_types import OTHER, MapTypeModel, MapTypePrediction, predict_left_out, soften
from pianta.evaluation.prediction import expect_calibration_error
from pianta.evaluation.semantics import measure_reliability
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.layout.reconstruct import reconstruct
from pianta_bench.data.folders import find_data
from pianta_bench.data.typed_maps import TypedMap, list_typed_maps
from pianta_bench.harness.records import Figures, Results, Track

# A wrong type with a higher probability is worse than none.
HIGH_PROBABILITY = 0.7
RIGHT = "right"
UNKNOWN = "unknown"
WRONG = "wrong"
WRONG_ABOVE_LIMIT = f"wrong above {HIGH_PROBABILITY}"
CALIBRATION = "calibration error"
# The error that exact probabilities of as many maps would have on average, over this number of draws of the truth.
BY_CHANCE = "by chance alone"
CHANCE_DRAWS = 200
FLOORS = "floors"
# Parts of the calibration: the maps, and the floors that the model was trained on.
MAPS = "maps"
TRAINING_FLOORS = "training floors, simulated maps too"
DIGITS = 3


def measure_maps(
    data: Path | None = None,
    *,
    track: Track = iter,
    model: MapTypeModel | None = None,
    read: Callable[[GridMap], Floor] | None = None,
) -> Results:
    """Read the maps of buildings of a known type, and predict the type by a model without the building.

    Records of each map: 0 or 1 for right, unknown, wrong and wrong with more than HIGH_PROBABILITY. A building
    that is neither a school nor an office is right if no type is given. And expected calibration errors, from 0 to 1.
    model: None for the one that comes with pianta. read: reconstructs a map; None for the usual method.
    Raises DataError if there are no such maps.
    """
    maps, model = list_typed_maps(find_data(data)), model or read_default_map_type_model()
    read = read or (lambda grid: reconstruct(grid, predict_partial=False))
    without = cache(model.leave_out)
    results = Results(details={"maps": []})
    predictions: list[tuple[TypedMap, MapTypePrediction]] = []

    def classify(each: TypedMap) -> Iterator[Figures]:
        own = without(each.building) if each.building in model.examples.buildings else model
        prediction = own.predict(read(each.read()))
        predictions.append((each, prediction))
        yield score_type(prediction, each.building_type)

    for each, _ in zip(maps, track([f"{each.part}/{each.item}" for each in maps]), strict=True):
        part = name_part(each.part, each.building_type, model)
        results.measure(part, each.item, partial(classify, each))
    results.details["maps"] = [describe_map(each, prediction) for each, prediction in predictions]
    for name, chances, truth in (
        (MAPS, *join_chances(predictions, model.classes)),
        (TRAINING_FLOORS, soften(predict_left_out(model.examples), model.temperature), model.examples.truth),
    ):
        error = measure_reliability(chances, truth).error if len(truth) else None
        by_chance = expect_calibration_error(chances, draws=CHANCE_DRAWS, seed=0) if len(truth) else None
        results.add(CALIBRATION, name, {CALIBRATION: error, BY_CHANCE: by_chance, FLOORS: len(truth)})
    return results


def name_part(part: str, building_type: str, model: MapTypeModel) -> str:
    """A set of maps and the type of its buildings, as the tables have it."""
    return f"{part}, {building_type if building_type in model.building_types else 'neither'}"


def score_type(prediction: MapTypePrediction, true_type: str) -> dict[str, float]:
    """1 for what is true of a prediction, else 0: right, unknown, wrong, and wrong with more than HIGH_PROBABILITY."""
    predicted = prediction.likeliest if prediction.is_known else OTHER
    is_wrong = predicted not in (true_type, OTHER)
    probability = prediction.probabilities[prediction.likeliest]
    return {
        RIGHT: float(predicted == true_type),
        UNKNOWN: float(predicted == OTHER),
        WRONG: float(is_wrong),
        WRONG_ABOVE_LIMIT: float(is_wrong and probability > HIGH_PROBABILITY),
    }


def join_chances(
    predictions: Sequence[tuple[TypedMap, MapTypePrediction]], classes: Sequence[str]
) -> tuple[Floats, Indices]:
    """Probabilities of the classes, shape (maps, classes), and the true ones, shape (maps,)."""
    rows = [[{**each.probabilities, OTHER: each.neither}[name] for name in classes] for _, each in predictions]
    truth = [list(classes).index(each.building_type) for each, _ in predictions]
    return np.array(rows).reshape(len(rows), len(classes)), np.array(truth, np.intp)


def describe_map(each: TypedMap, prediction: MapTypePrediction) -> Mapping[str, object]:
    """A map and its prediction, as the JSON file has it."""
    chances = {name: round(value, DIGITS) for name, value in prediction.probabilities.items()}
    return {
        "part": each.part,
        "item": each.item,
        "building": each.building,
        "type": each.building_type,
        "probabilities": chances,
        "neither": round(prediction.neither, DIGITS),
    }
