"""Descriptions of whole floors: hand-made answers, and what they must not depend on."""

from dataclasses import replace
from math import log, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from shapely import box

from pianta.building_types.description import (
    MIN_SHARE,
    ONE_SIDE_SHARE,
    SEVERAL_SIDES_SHARE,
    BuildingDescription,
    describe_building,
    name_features,
)
from pianta.errors import LabelError
from pianta.floor import Floor, Room
from pianta.labels import SCHEMAS, LabelSet
from pianta.rooms.completion import map_labels_upwards
from pianta.rooms.features import CONTEXT_FEATURES, describe_rooms
from tests.typed_floors import ALL_SCHEMAS, build, hang_door, make_house, move, typed_floors

LABEL_SETS = (LabelSet.R_C, LabelSet.F_C_E_S)


def small_school() -> Floor:
    """A corridor of 12 m by 2 m, on its long side two rooms of 4 m by 3 m and a closet of 4 m by 1 m."""
    rooms = [("CORRIDOR", box(0, 0, 12, 2)), ("CLASSROOM", box(0, 2, 4, 5)), ("CLASSROOM", box(4, 2, 8, 5))]
    doors = [hang_door(1, 2 + i, 1 + 4 * i, 2) for i in range(3)]
    return map_labels_upwards(
        build("school", "s.xml", [*rooms, ("CLOSET", box(8, 2, 12, 3))], doors), SCHEMAS["school"]
    )


def spread(floor: Floor) -> Floor:
    return map_labels_upwards(floor, ALL_SCHEMAS[floor.building_types[0]])


def feature(description: BuildingDescription, label_set: LabelSet, name: str) -> float:
    return float(description.features[name_features(label_set).index(name)])


def test_labels_are_spread_upwards():
    labels = [room.labels for room in small_school().rooms]
    assert labels[0] == {"R/C": "CORRIDOR", "F/C/E/S": "CONNECTION"}
    assert labels[1] == {"R/C": "ROOM", "F/C/E/S": "FUNCTIONAL"}
    assert labels[3] == {"R/C": "ROOM", "F/C/E/S": "SERVICE"}


def test_unknown_labels_cannot_be_spread():
    with pytest.raises(LabelError, match="POOL"):
        map_labels_upwards(Floor((Room(1, box(0, 0, 1, 1), label="POOL"),)), SCHEMAS["school"])


def test_a_small_school():
    description = describe_building(small_school(), LabelSet.F_C_E_S)
    assert description.source == "s.xml"
    assert description.labels == ("CONNECTION", "FUNCTIONAL", "FUNCTIONAL", "SERVICE")
    assert description.doors == ((0, 1), (0, 2), (0, 3))
    assert_allclose(description.sizes, [log(2), 0, 0, log(1 / 3)], atol=1e-5)
    values = {name: feature(description, LabelSet.F_C_E_S, name) for name in name_features(LabelSet.F_C_E_S)}
    assert values["rooms"] == pytest.approx(log(4), abs=1e-5)
    assert values["largest_share"] == pytest.approx(log(24 / 52), abs=1e-5)
    assert values["concentration"] == pytest.approx(log((24**2 + 2 * 12**2 + 4**2) / 52**2), abs=1e-5)
    assert values["FUNCTIONAL share"] == 0.5
    assert values["FUNCTIONAL area_share"] == pytest.approx(log(24 / 52 + MIN_SHARE), abs=1e-5)
    assert values["CONNECTION size"] == pytest.approx(log(24 / 12), abs=1e-5)
    assert values["ENTRANCE share"] == 0
    assert values["ENTRANCE area_share"] == pytest.approx(log(MIN_SHARE), abs=1e-5)
    assert values["ENTRANCE size"] == 0
    # Three rooms behind the corridor, each a leaf; the corridor lies between 3 pairs of rooms, of 2 · 3 in order.
    assert values["mean leaves"] == 3 / 4
    assert values["mean betweenness"] == pytest.approx(3 / 6 / 4)


def test_the_mean_of_corridors_is_of_corridors_alone():
    description = describe_building(small_school(), LabelSet.R_C)
    assert description.labels == ("CORRIDOR", "ROOM", "ROOM", "ROOM")
    assert feature(description, LabelSet.R_C, "corridors' rectangularity") == pytest.approx(1)
    assert feature(description, LabelSet.R_C, "CORRIDOR share") == 1 / 4
    house = describe_building(spread(make_house(3)), LabelSet.R_C)
    assert set(house.labels) == {"ROOM"}
    assert np.isfinite(house.features).all()


@pytest.mark.parametrize("label_set", LABEL_SETS)
def test_there_is_a_name_for_every_feature(label_set):
    names = name_features(label_set)
    assert len(set(names)) == len(names) == len(describe_building(small_school(), label_set).features)


@pytest.mark.parametrize("label_set", LABEL_SETS)
def test_a_single_room(label_set):
    label = {LabelSet.R_C: "ROOM", LabelSet.F_C_E_S: "FUNCTIONAL"}[label_set]
    room = Room(7, box(0, 0, 5, 4), labels={str(label_set): label})
    description = describe_building(Floor((room,)), label_set)
    assert (description.labels, description.doors, description.sizes) == ((label,), (), (0,))
    assert np.isfinite(description.features).all()


@pytest.mark.parametrize(("floor", "message"), [(Floor(()), "rooms"), (make_house(2), "LIVING ROOM")])
def test_floors_that_cannot_be_described(floor, message):
    with pytest.raises(LabelError, match=message):
        describe_building(floor, LabelSet.F_C_E_S)


def test_rooms_without_a_label_are_listed():
    floor = small_school()
    bare = replace(floor, rooms=(replace(floor.rooms[0], label=None, labels={}), *floor.rooms[1:]))
    with pytest.raises(LabelError, match="R/C"):
        describe_building(bare, LabelSet.R_C)


@pytest.mark.slow
@given(
    st.sampled_from(typed_floors()),
    st.floats(0, 2 * pi),
    st.floats(0.01, 100),
    st.tuples(st.floats(-100, 100), st.floats(-100, 100)),
    st.sampled_from(LABEL_SETS),
)
def test_turned_scaled_and_shifted_floors_are_described_alike(floor, turn, scale, shift, label_set):
    predicted = describe_building(spread(floor), label_set)
    moved = describe_building(spread(move(floor, turn=turn, scale=scale, shift=shift)), label_set)
    # Façades are found by buffers, whose round corners are polygons that do not turn with the floor.
    assert_allclose(moved.features, predicted.features, atol=5e-3)
    assert_allclose(moved.sizes, predicted.sizes, atol=1e-4)
    assert (moved.labels, moved.doors) == (predicted.labels, predicted.doors)
    # The number of sides depends on thresholds: a façade within the same tolerance of one may be on either side of it.
    facade = describe_rooms(floor).features[:, [CONTEXT_FEATURES.index("facade")]]
    clear = (np.abs(facade - (ONE_SIDE_SHARE, SEVERAL_SIDES_SHARE)) > 5e-3).all(axis=1)
    assert_array_equal(np.array(moved.sides)[clear], np.array(predicted.sides)[clear])


@pytest.mark.slow
@given(st.sampled_from(typed_floors()), st.randoms(use_true_random=False), st.sampled_from(LABEL_SETS))
def test_the_order_of_rooms_does_not_count(floor, random, label_set):
    rooms, doors = list(floor.rooms), list(floor.doors)
    random.shuffle(rooms)
    random.shuffle(doors)
    predicted = describe_building(spread(floor), label_set)
    shuffled = describe_building(spread(replace(floor, rooms=tuple(rooms), doors=tuple(doors))), label_set)
    assert_allclose(shuffled.features, predicted.features, atol=1e-4)
    order = [floor.rooms.index(room) for room in rooms]
    assert shuffled.labels == tuple(predicted.labels[index] for index in order)
    assert {tuple(sorted((order[one], order[other]))) for one, other in shuffled.doors} == set(predicted.doors)


def test_patterns_name_rooms_by_label_size_and_sides():
    predicted = BuildingDescription(
        "x", np.zeros(0), ("ROOM", "CORRIDOR", "ROOM"), (-1.0, 0.0, 2.0), (0, 1, 2), ((0, 1),)
    )
    assert predicted.name_rooms(np.array([-0.5, 1.0])) == (
        "ROOM size 0 sides 0",
        "CORRIDOR size 1 sides 1",
        "ROOM size 2 sides 2",
    )
