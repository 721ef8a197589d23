"""`pianta bench types --maps`: which maps it reads, what it counts, and its tables."""

import json
from dataclasses import replace
from math import comb
from pathlib import Path

import numpy as np
import pytest
from shapely import box

from pianta.building_types.map_types import OTHER, MapTypeModel, MapTypePrediction, train_map_types
from pianta.errors import DataError, OptionError
from pianta.floor import Floor, Room
from pianta.generation.world import make_world
from pianta_bench.data.typed_maps import TypedMap, list_typed_maps
from pianta_bench.harness.records import Results
from pianta_bench.types import maps as type_maps
from pianta_bench.types.maps import (
    BY_CHANCE,
    CALIBRATION,
    MAPS,
    RIGHT,
    UNKNOWN,
    WRONG,
    WRONG_ABOVE_LIMIT,
    join_chances,
    measure_maps,
    score_type,
)
from pianta_bench.types.measure import measure
from pianta_bench.types.tables import tabulate
from tests.test_map_types import make_examples


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Two maps of one campus building, a school, a home and an office."""
    folder = tmp_path_factory.mktemp("data")
    names = {
        "slam": ("tinyschool.png", "tinyschool_gt.xml"),
        "kth": ("50010535_A.png", "50010535_A_rooms.png", "50010536_B.png", "50010536_B_rooms.png"),
        "vacuum": ("home.yaml", "home_gt.png"),
    }
    for name, files in names.items():
        (folder / name).mkdir()
        for file in files:
            (folder / name / file).touch()
    (folder / "robotmaps" / "urjc_lab").mkdir(parents=True)
    (folder / "robotmaps" / "urjc_lab" / "urjc_lab.yaml").touch()
    return folder


def test_maps_and_their_types(data):
    types = {
        each.item: (each.part, each.building_type, each.building, each.resolution) for each in list_typed_maps(data)
    }
    assert types == {
        "tinyschool": ("schools", "school", "school/tinyschool", 0.1),
        "50010535_A": ("kth", "office", "office/5001053", 0.05),
        "50010536_B": ("kth", "office", "office/5001053", 0.05),
        "home": ("vacuum", OTHER, "other/home", None),
        "urjc_lab": ("robotmaps", "office", "office/urjc_lab", None),
    }


def test_data_without_typed_maps_is_refused(tmp_path):
    with pytest.raises(DataError, match="no maps of buildings of a known type"):
        list_typed_maps(tmp_path)


@pytest.mark.parametrize(
    ("chances", "true_type", "expected"),
    [
        ((0.8, 0.1), "office", (1, 0, 0, 0)),
        ((0.5, 0.3), "office", (0, 1, 0, 0)),
        ((0.6, 0.3), "school", (0, 0, 1, 0)),
        ((0.8, 0.1), "school", (0, 0, 1, 1)),
        ((0.3, 0.1), OTHER, (1, 1, 0, 0)),
        ((0.1, 0.8), OTHER, (0, 0, 1, 1)),
    ],
)
def test_scored_types(chances, true_type, expected):
    office, school = chances
    prediction = MapTypePrediction({"office": office, "school": school}, 1 - office - school)
    scores = score_type(prediction, true_type)
    assert tuple(scores[name] for name in (RIGHT, UNKNOWN, WRONG, WRONG_ABOVE_LIMIT)) == expected


def test_chances_in_the_order_of_the_classes():
    each = TypedMap("kth", "a", Path("a.png"), 0.05, "school", "school/a")
    prediction = MapTypePrediction({"office": 0.1, "school": 0.7}, 0.2)
    chances, truth = join_chances([(each, prediction)], ("office", OTHER, "school"))
    np.testing.assert_allclose(chances, [[0.1, 0.2, 0.7]])
    assert truth.tolist() == [2]
    assert join_chances([], ("office", OTHER, "school"))[0].shape == (0, 3)


def test_each_map_is_classified_without_its_building(data, monkeypatch):
    examples = make_examples()
    model = train_map_types(replace(examples, buildings=("office/5001053", *examples.buildings[1:])))
    left_out = []

    def leave_out(each: MapTypeModel, building: str) -> MapTypeModel:
        left_out.append(building)
        return each

    monkeypatch.setattr(TypedMap, "read", lambda each: make_world("corridor", resolution=0.1)[1])
    monkeypatch.setattr(MapTypeModel, "leave_out", leave_out)
    floor = Floor((Room(1, box(0, 0, 4, 3)), Room(2, box(4, 0, 8, 3))))
    results = measure_maps(data, model=model, read=lambda grid: floor)
    assert left_out == ["office/5001053"]
    assert len(results.details["maps"]) == 5
    assert not results.failed
    assert {record["part"] for record in results.select(metric=RIGHT)} == {
        "schools, school",
        "kth, office",
        "vacuum, neither",
        "robotmaps, office",
    }
    assert results.select(part=CALIBRATION, item=MAPS, metric="floors")[0]["value"] == 5
    # All five maps have one probability p: exact ones would be off by E|k / 5 - p| of a binomial k.
    (top,) = {max(*each["probabilities"].values(), each["neither"]) for each in results.details["maps"]}
    expected = sum(comb(5, k) * top**k * (1 - top) ** (5 - k) * abs(k / 5 - top) for k in range(6))
    by_chance = results.select(part=CALIBRATION, item=MAPS, metric=BY_CHANCE)[0]["value"]
    assert by_chance == pytest.approx(expected, abs=0.04)
    json.dumps(results.details)
    counts, calibration = tabulate(results)
    assert "Building types of robots' maps" in counts.title
    assert "calibration" in calibration.title


def test_pictures_are_of_drawn_floors(data, tmp_path):
    with pytest.raises(OptionError, match="--pictures"):
        measure(data, maps=True, pictures=tmp_path)


def test_the_option_measures_maps(data, monkeypatch):
    expected = Results(options={"maps": True})
    monkeypatch.setattr(type_maps, "measure_maps", lambda folder, *, track: expected if folder == data else None)
    assert measure(data, maps=True) is expected
