"""Realism: of generated floors with known answers, and of the RoboCup worlds."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from shapely import Geometry, LineString, affinity, box

from pianta.building_types.description import describe_building
from pianta.building_types.kernel import BuildingKernel
from pianta.building_types.model import BuildingTypeModel
from pianta.errors import LabelError, ModelError
from pianta.floor import Door, Floor, Room
from pianta.labels import LabelSet
from pianta.plot.figure import save_figure
from pianta.plot.realism import draw_realism
from pianta.realism.classifier import LinearBuildingKernel, RealismClassifier
from pianta.realism.measures import (
    MAX_MEASURES,
    find_unusual_measures,
    list_measures,
    measure_description,
)
from pianta.realism.model import Realism, RealismModel, name_buildings, reference_from_types, train_realism
from pianta.realism.patterns import MANY, RoomPattern, find_unusual_patterns, list_patterns
from pianta.rooms.completion import fill_missing_labels
from pianta_bench.data.annotated_floors import read_annotated_buildings
from tests.simulated_offices import make_grid_floor, make_offices, make_snake, make_worlds

R_C, F_C_E_S = LabelSet.R_C, LabelSet.F_C_E_S
ROOM_AT_CORRIDOR = RoomPattern("ROOM", (("CORRIDOR", 1),))


def join_row(labels: str, *pairs: tuple[int, int], label: str = "label") -> Floor:
    """Rooms of 1 m² in a row, C for CORRIDOR and R for ROOM, with doors between pairs."""
    names = {"C": "CORRIDOR", "R": "ROOM"}
    rooms = tuple(Room(n, box(n, 0, n + 1, 1), label=names[each]) for n, each in enumerate(labels, start=1))
    return Floor(rooms, tuple(Door(pair, LineString([(0, 0), (1, 0)]), 1.0) for pair in pairs), source="row")


@cache
def one_class() -> RealismModel:
    return train_realism(make_offices(), label_set=R_C)


@cache
def two_classes() -> RealismModel:
    return train_realism(make_offices(), label_set=R_C, unrealistic=make_worlds())


def make_realism(typicality: float, probability: float | None = None) -> Realism:
    return Realism(0.5, (0.1, 0.2, 0.3, 0.4), typicality, probability, ("a",), (), ())


def test_patterns_by_hand():
    floor = join_row("CRRRRRR", (1, 2), (1, 3), (1, 4), (1, 5), (5, 6))
    patterns = list_patterns(describe_building(floor, R_C))
    assert [str(pattern) for pattern in patterns] == [
        "CORRIDOR that leads to 3 or more ROOMs only",
        *["ROOM that leads to 1 CORRIDOR only"] * 3,
        "ROOM that leads to 1 CORRIDOR and 1 ROOM",
        "ROOM that leads to 1 ROOM and no CORRIDOR",
        "ROOM without a door to another room",
    ]
    assert patterns[0] == RoomPattern("CORRIDOR", (("ROOM", MANY),))
    assert str(RoomPattern("SERVICE", (("ENTRANCE", 2),))) == "SERVICE that leads to 2 ENTRANCEs and no CONNECTION"
    assert str(RoomPattern("CONNECTION", (("SERVICE", 2),))) == "CONNECTION that leads to 2 SERVICEs only"


def test_unusual_patterns_by_hand():
    through = RoomPattern("ROOM", (("ROOM", 2),))
    alone = RoomPattern("ROOM", ())
    training = [[ROOM_AT_CORRIDOR] * 9 + [through], [ROOM_AT_CORRIDOR] * 8 + [through] * 2]
    result = find_unusual_patterns([through] * 9 + [alone], training, [*range(11, 21)])
    assert [(off.pattern, off.is_frequent) for off in result] == [(through, True), (ROOM_AT_CORRIDOR, False)]
    often, seldom = result
    assert often.rooms == (*range(11, 20),)
    assert often.usual == pytest.approx((0.1, 0.2))
    # Poisson deviance of 9 rooms with 1.5 expected, and of 0 rooms with 8.5 expected.
    assert often.deviation == pytest.approx(2 * (9 * np.log(6) - 7.5))
    assert seldom.deviation == pytest.approx(17)
    assert str(often) == (
        "often a ROOM that leads to 2 ROOMs and no CORRIDOR: 90% of the rooms, usually 11% to 20% "
        "(rooms 11 12 13 14 15 16 17 18 19)"
    )
    assert str(seldom) == "seldom a ROOM that leads to 1 CORRIDOR only: 0% of the rooms, usually 80% to 90%"
    assert find_unusual_patterns(training[0], training, [*range(10)]) == ()


def test_measures_by_hand():
    measured = measure_description(describe_building(join_row("CRRR", (1, 2), (1, 3), (1, 4)), R_C), R_C)
    assert [*measured] == [measure.key for measure in list_measures(R_C)]
    assert (measured["nodes"], measured["nodes_c"], measured["diameter"]) == (4, 1, 2)
    assert (measured["betweenness_r"], measured["betweenness_c"]) == (0, 0.5)
    assert measured["assortativity"] == pytest.approx(-1)
    assert measured["mean leaves"] == pytest.approx(0.75)
    assert measured["largest_share"] == pytest.approx(0.25, rel=1e-4)
    assert measured["CORRIDOR share"] == pytest.approx(0.25)
    assert measured["CORRIDOR area_share"] == pytest.approx(0.25, rel=1e-4)
    without = measure_description(describe_building(join_row("RR", (1, 2)), R_C), R_C)
    assert (without["betweenness_c"], without["assortativity"], without["CORRIDOR area_share"]) == (None, None, 0)


def test_unusual_measures_by_hand():
    keys = [measure.key for measure in list_measures(R_C)]
    training: list[dict[str, float | None]] = [dict.fromkeys(keys, 10.0 + number) for number in range(5)]
    usual = dict.fromkeys(keys, 12.0)
    assert find_unusual_measures(usual, training, R_C) == ()
    # The percentiles 5 and 95 of 10 … 14 are 10.2 and 13.8; a tenth of that range beyond is still usual.
    assert find_unusual_measures(usual | {"diameter": 14.1}, training, R_C) == ()
    (off,) = find_unusual_measures(usual | {"diameter": 19.2, "path_length": 18.0}, training, R_C)
    assert off.deviation == pytest.approx(2)
    assert [*off.usual] == [10, 11, 12, 13, 14]
    assert str(off) == (
        "the longest way leads through many doors: doors on the longest way 19.2, usually 10.2 to 13.8 (median 12)"
    )
    (low,) = find_unusual_measures(usual | {"diameter": 1.0}, training, R_C)
    assert low.meaning == "the longest way leads through few doors"
    all_off = find_unusual_measures(dict.fromkeys(keys, 99.0), training, R_C)
    assert len(all_off) == len({each.measure.family for each in all_off}) == MAX_MEASURES
    assert find_unusual_measures(dict.fromkeys(keys), training, R_C) == ()
    rare = [floor | {"diameter": None} for floor in training[:3]] + training[3:]
    assert find_unusual_measures(usual | {"diameter": 99.0}, rare, R_C) == ()


@pytest.mark.parametrize(
    ("typicality", "words"),
    [
        (0, "less typical than any of the 4 reference floors"),
        (0.1, "less typical than 90% of the 4 reference floors"),
        (0.5, "typical, 50% of the 4 reference floors are less so"),
        (0.8, "more typical than 80% of the 4 reference floors"),
        (1, "more typical than any of the 4 reference floors"),
    ],
)
def test_verdicts(typicality, words):
    assessed = make_realism(typicality)
    assert (assessed.score, assessed.verdict) == (typicality, words)
    assessed = make_realism(typicality, 0.2)
    assert (assessed.score, assessed.verdict) == (0.2, f"not realistic, probability 0.20 of being so; {words}")
    joined = ", but " if typicality <= 0.1 else "; "
    assert make_realism(typicality, 0.5).verdict == f"realistic, probability 0.50 of being so{joined}{words}"


@pytest.mark.slow
def test_one_class_ranks_worlds_below_offices():
    model = one_class()
    worlds = [model.assess(world) for world in make_worlds()]
    offices = [model.leave_out(floor.source).assess(floor) for floor in make_offices()]
    assert max(world.likeness for world in worlds) < min(office.likeness for office in offices)
    assert {world.typicality for world in worlds} == {0}
    assert np.median([office.typicality for office in offices]) > 0.2
    assert all(world.probability is None for world in worlds)


def test_reasons_name_unusual_measures():
    assessed = one_class().assess(make_snake(5, 4))
    assert {"paths", "betweenness"} <= {off.measure.family for off in assessed.measures}
    often = next(off for off in assessed.patterns if off.is_frequent)
    assert often.pattern == RoomPattern("ROOM", (("ROOM", 2),))
    assert often.rooms == (*range(2, 19),)
    assert any(off.pattern == ROOM_AT_CORRIDOR and not off.is_frequent for off in assessed.patterns)
    assert assessed.reasons == (*map(str, assessed.measures), *map(str, assessed.patterns))


@pytest.mark.slow
def test_two_classes_separate_held_out_floors():
    model = two_classes()
    for floor in make_offices()[::3]:
        assert (model.leave_out(floor.source).assess(floor).probability or 0) > 0.5
    for world in make_worlds():
        assert (model.leave_out(world.source).assess(world).probability or 1) < 0.5


def test_features_far_from_all_floors_still_count_in_the_linear_kernel():
    """Twice the distance from the mean gives twice the value, where the value of the Gaussian kernel is 0."""
    training = [describe_building(floor, R_C) for floor in make_offices()]
    linear, gaussian = (kernel().fit(training) for kernel in (LinearBuildingKernel, BuildingKernel))
    far = [replace(training[0], features=linear.means_ + factor * linear.deviations_) for factor in (20, 40)]
    one, two = linear.compare_features(far)
    np.testing.assert_allclose(two, 2 * one)
    np.testing.assert_allclose(gaussian.compare_features(far), 0, atol=1e-12)


def test_classes_count_the_same_however_many_floors_they_have():
    descriptions = [describe_building(floor, R_C) for floor in (*make_offices()[:3], *make_worlds())]
    names = [description.source for description in descriptions]
    predicted = RealismClassifier().fit(descriptions, [True] * 3 + [False] * 3, names)
    opposite = RealismClassifier().fit(descriptions, [False] * 3 + [True] * 3, names)
    for description in descriptions:
        assert predicted.predict_probability(description) + opposite.predict_probability(description) == pytest.approx(
            1, abs=1e-4
        )


@pytest.mark.slow
@given(
    st.sampled_from([*make_offices()[:2], make_snake(4, 3)]),
    st.floats(0.05, 20),
    st.floats(-180, 180),
    st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    st.randoms(use_true_random=False),
)
@settings(max_examples=15)
def test_pose_scale_and_order_change_nothing(floor, factor, angle, shift, random):
    def move(shape: Geometry) -> Geometry:
        return affinity.translate(
            affinity.rotate(affinity.scale(shape, factor, factor, origin=(0, 0)), angle, origin=(0, 0)), *shift
        )

    rooms = [replace(room, polygon=move(room.polygon)) for room in floor.rooms]
    doors = [replace(door, line=move(door.line), width=factor * door.width) for door in floor.doors]
    random.shuffle(rooms)
    random.shuffle(doors)
    model = one_class().leave_out(floor.source)
    expected, moved = model.assess(floor), model.assess(Floor(tuple(rooms), tuple(doors)))
    assert moved.typicality == expected.typicality
    assert moved.likeness == pytest.approx(expected.likeness, abs=1e-4)
    assert moved.patterns == expected.patterns
    assert [str(off) for off in moved.measures] == [str(off) for off in expected.measures]


@pytest.mark.slow
def test_order_of_the_reference_changes_nothing():
    turned = train_realism(make_offices()[::-1], label_set=R_C, unrealistic=make_worlds()[::-1])
    assessed, expected = (model.assess(make_snake(4, 4)) for model in (turned, two_classes()))
    assert assessed.likeness == pytest.approx(expected.likeness)
    assert assessed.probability == pytest.approx(expected.probability, abs=1e-3)
    assert assessed.reasons == expected.reasons


def test_too_few_buildings():
    offices, worlds = make_offices(), make_worlds()
    with pytest.raises(ModelError, match="reference"):
        train_realism(offices[:2], label_set=R_C)
    with pytest.raises(ModelError, match="reference"):
        train_realism(offices[:3], buildings=["a", "a", "b"], label_set=R_C)
    with pytest.raises(ModelError, match="unrealistic"):
        train_realism(offices, label_set=R_C, unrealistic=worlds[:1])
    with pytest.raises(ModelError, match="reference"):
        train_realism(offices[:3], label_set=R_C).leave_out(offices[0].source)
    empty = Floor((), source="empty")
    assert train_realism([*offices, empty], label_set=R_C).buildings == one_class().buildings
    with pytest.raises(LabelError, match="rooms"):
        one_class().assess(empty)


def test_names_of_buildings():
    many = [f"house {type_name}{floor}.xml" for type_name in "abcde" for floor in (1, 2)]
    assert name_buildings(many) == [f"house {type_name}" for type_name in "abcde" for _ in (1, 2)]
    assert name_buildings(["office1.xml", "office2.xml"]) == ["office1.xml", "office2.xml"]


def test_floors_of_a_building_model():
    training = tuple(describe_building(floor, R_C) for floor in (*make_offices(), *make_worlds()))
    types = ("office",) * 8 + ("maze",) * 3
    model = BuildingTypeModel(training, types, tuple(each.source for each in training), R_C)
    offices = reference_from_types(model, ["office"])
    assert offices.assess(make_snake(4, 4)) == one_class().assess(make_snake(4, 4))
    assert len(reference_from_types(model).reference_floors) == 11
    with pytest.raises(ModelError, match="church"):
        reference_from_types(model, ["church", "office"])


def test_given_labels():
    """R/C labels from labels of offices, schools, F/C/E/S and R/C; from label sets; and from predictions of pianta."""
    result = {"R/C": {"ROOM": 0.9, "CORRIDOR": 0.1}}
    rooms = (
        Room(1, box(0, 0, 1, 1), label="lobby"),
        Room(2, box(1, 0, 2, 1), label="CLASSROOM"),
        Room(3, box(2, 0, 3, 1), label="CONNECTION"),
        Room(4, box(3, 0, 4, 1), label="SERVICE"),
        Room(5, box(4, 0, 5, 1), label="CORRIDOR"),
        Room(6, box(5, 0, 6, 1), labels={"R/C": "CORRIDOR"}),
        Room(7, box(6, 0, 7, 1), label="ROOM", labels={"R/C": "ROOM"}, label_probabilities=result),
    )
    coarse = fill_missing_labels(Floor(rooms), R_C)
    kinds = ["CORRIDOR", "ROOM", "CORRIDOR", "ROOM", "CORRIDOR", "CORRIDOR", "ROOM"]
    assert [room.label for room in coarse.floor.rooms] == kinds
    assert [dict(room.labels) for room in coarse.floor.rooms] == [{"R/C": type_name} for type_name in kinds]
    assert coarse.predicted == (7,)
    floor = Floor(rooms[:2], building_type={"office": 1.0})
    assert [room.label for room in fill_missing_labels(floor, F_C_E_S).floor.rooms] == ["CONNECTION", "FUNCTIONAL"]


def test_labels_that_are_predicted():
    floor = make_offices()[0]
    unusual = replace(floor, rooms=tuple(replace(room, label="WARD" if room.id > 1 else None) for room in floor.rooms))
    coarse = fill_missing_labels(unusual, R_C)
    assert coarse.predicted == tuple(room.id for room in floor.rooms)
    assert coarse.floor.rooms[0].label == "CORRIDOR"
    assert {room.label for room in coarse.floor.rooms[1:]} == {"ROOM"}
    assert fill_missing_labels(floor, R_C).predicted == ()


def test_picture(tmp_path):
    floor = fill_missing_labels(make_grid_floor(4, 4), R_C).floor
    assessed = one_class().assess(floor)
    figure = draw_realism(floor, assessed)
    # The floor, its legend, and a strip for the likeness and for each reason.
    assert len(figure.axes) == 3 + len(assessed.reasons)
    hatched = [patch for patch in figure.axes[0].patches if patch.get_hatch()]
    assert len(hatched) == sum(len(off.rooms) for off in assessed.patterns if off.is_frequent) > 0
    for name in ("one.png", "other.png"):
        save_figure(draw_realism(floor, assessed), tmp_path / name)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "other.png").read_bytes()
    with Image.open(tmp_path / "one.png") as image:
        # Matplotlib rounds up or down, depending on its version
        assert image.size == pytest.approx(figure.get_size_inches() * figure.dpi, abs=1)


@pytest.mark.slow
@pytest.mark.parametrize("label_set", [R_C, F_C_E_S])
def test_robocup_worlds_are_separated_from_offices(data, label_set):
    def describe(annotated):
        floor = fill_missing_labels(replace(annotated.floor, source=annotated.item), label_set).floor
        return annotated.building, describe_building(floor, label_set), [room.id for room in floor.rooms]

    (offices, failed), (worlds, failed_worlds) = (
        read_annotated_buildings(data, type_name, describe) for type_name in ("office", "robocup")
    )
    assert (len(offices), len(worlds), failed, failed_worlds) == (11, 5, (), ())
    names, training, _ = zip(*offices, strict=True)
    unrealistic_names, unrealistic_floors, _ = zip(*worlds, strict=True)
    two = RealismModel(training, names, label_set, unrealistic_floors, unrealistic_names)
    one = replace(two, unrealistic_floors=(), unrealistic_buildings=())
    office_assessments, world_assessments = (
        [one.leave_out(name).assess_description(floor, ids) for name, floor, ids in part] for part in (offices, worlds)
    )
    assert max(world.likeness for world in world_assessments) < np.median(
        [office.likeness for office in office_assessments]
    )
    assert max(world.typicality for world in world_assessments) < 0.1
    assert min(len(world.reasons) for world in world_assessments) > np.median(
        [len(office.reasons) for office in office_assessments]
    )
    # The offices that are least like the others, by two classes.
    least = np.argsort([office.likeness for office in office_assessments])[:3]
    for name, floor, ids in [*(offices[index] for index in least), *worlds]:
        predicted = two.leave_out(name).assess_description(floor, ids).probability
        assert predicted is not None
        assert (predicted > 0.5) is (floor in training)
