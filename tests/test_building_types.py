"""Building types of floors: types that are built in different ways, unusual floors, and real ones."""

from dataclasses import replace
from math import pi

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist
from shapely import box

from pianta.building_types.classify import classify_building, predict_building_type
from pianta.building_types.description import describe_building
from pianta.building_types.kernel import DISTANCE, RADIUS, BuildingKernel, cached_patterns, stack_patterns
from pianta.building_types.model import TypePrediction, check_types, predict_held_out, train_building_types
from pianta.building_types.model_file import read_default_building_type_model
from pianta.errors import LabelError, ModelError
from pianta.evaluation.folds import leave_buildings_out
from pianta.floor import Floor, Room
from pianta.graphs.feature_counts import compare_counts, merge_counts
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.io.buildings.read import read_building
from pianta.labels import LabelSet
from pianta.rooms.completion import fill_missing_labels, map_labels_upwards
from pianta.rooms.label import label_rooms
from tests.typed_floors import (
    ALL_SCHEMAS,
    make_house,
    make_office,
    make_school,
    move,
    typed_floors,
    typed_model,
)

NEW = {
    "school": make_school(7, width=6.8, source="new.xml"),
    "office": make_office(5, depth=3.2, source="new.xml"),
    "house": make_house(6, width=5.2, source="new.xml"),
}


def spread(floor: Floor) -> Floor:
    return map_labels_upwards(floor, ALL_SCHEMAS[floor.building_types[0]])


def best(prediction: TypePrediction) -> str:
    return prediction.likeliest


def test_three_types_are_distinguished():
    assert typed_model().building_types == ("house", "office", "school")
    for type_name, floor in NEW.items():
        verdict = typed_model().predict(spread(floor))
        assert best(verdict) == type_name
        assert verdict.is_known
        assert sum(verdict.probabilities.values()) == pytest.approx(1)
        assert all(source.startswith(type_name) for source in verdict.alike)


def test_two_types_are_distinguished():
    model = train_building_types([floor for floor in typed_floors() if floor.building_types != ("house",)])
    assert model.building_types == ("office", "school")
    assert [best(model.predict(spread(NEW[type_name]))) for type_name in ("office", "school")] == ["office", "school"]


@pytest.mark.slow
@pytest.mark.parametrize("label_set", [LabelSet.R_C, LabelSet.F_C_E_S])
def test_held_out_buildings_are_predicted_by_models_without_them(label_set):
    model = train_building_types(typed_floors(), schemas=ALL_SCHEMAS, label_set=label_set)
    verdicts = predict_held_out(model)
    assert [best(verdict) for verdict in verdicts] == list(model.types)
    for verdict, own in zip(verdicts, model.buildings, strict=True):
        assert own not in {
            model.buildings[[training.source for training in model.training_floors].index(name)]
            for name in verdict.alike
        }


@pytest.mark.slow
def test_leaving_out_gives_the_model_of_the_others():
    floors = typed_floors()
    others = train_building_types(floors[2:], schemas=ALL_SCHEMAS)
    floor = spread(NEW["school"])
    assert typed_model().buildings[:2] == ("school a", "school a")
    assert typed_model().leave_out(np.array([0, 1])).predict(floor) == others.predict(floor)


@pytest.mark.slow
def test_only_one_building_of_a_type_left():
    """Without one of two buildings of a type only one remains, which cannot be left out for the calibration."""
    model = train_building_types([*typed_floors()[1:3], *typed_floors()[6:9]])
    assert [best(verdict) for verdict in predict_held_out(model)][2:] == ["office"] * 3


@pytest.mark.slow
@given(
    st.sampled_from(sorted(NEW)),
    st.floats(0, 2 * pi),
    st.floats(0.01, 100),
    st.randoms(use_true_random=False),
)
@settings(max_examples=30)
def test_predictions_do_not_depend_on_turn_scale_or_order(type_name, turn, scale, random):
    floor = spread(move(NEW[type_name], turn=turn, scale=scale, shift=(7.0, -3.0)))
    rooms = list(floor.rooms)
    random.shuffle(rooms)
    predicted, before = (
        typed_model().predict(replace(floor, rooms=tuple(rooms))),
        typed_model().predict(spread(NEW[type_name])),
    )
    assert predicted.probabilities == pytest.approx(before.probabilities, abs=0.02)
    assert (best(predicted), predicted.is_known) == (best(before), before.is_known)


@pytest.mark.slow
def test_the_order_of_training_does_not_count():
    reordered = train_building_types(typed_floors()[::-1], schemas=ALL_SCHEMAS)
    for floor in map(spread, NEW.values()):
        one, other = typed_model().predict(floor), reordered.predict(floor)
        assert other.probabilities == pytest.approx(one.probabilities, abs=1e-3)
        assert (other.typicality, other.is_known) == (one.typicality, one.is_known)


def lone_room(label: str = "FUNCTIONAL") -> Floor:
    return Floor((Room(1, box(0, 0, 30, 20), labels={"F/C/E/S": label}),))


def test_a_hall_alone_is_of_no_known_type():
    verdict = typed_model().predict(lone_room())
    assert (verdict.typicality, verdict.is_known) == (0, False)
    assert classify_building(lone_room(), typed_model()).building_type == {}


def test_the_classified_floor_differs_in_its_type_alone():
    floor = spread(NEW["office"])
    predicted = classify_building(floor, typed_model())
    assert predicted.building_types[0] == "office"
    assert replace(predicted, building_type=floor.building_type) == floor


def test_rooms_without_labels_are_labelled_for_it():
    bare = Floor(tuple(replace(room, label=None, labels={}) for room in NEW["school"].rooms), NEW["school"].doors)
    assert predict_building_type(bare, typed_model()) == typed_model().predict(label_rooms(bare))
    assert {room.label for room in classify_building(bare, typed_model()).rooms} == {None}


def test_existing_labels_are_used():
    """A school whose rooms are all labelled SERVICE is less typical than with predicted labels."""
    rooms = tuple(replace(room, label="SERVICE", labels={"F/C/E/S": "SERVICE"}) for room in NEW["school"].rooms)
    floor = replace(NEW["school"], rooms=rooms)
    assert predict_building_type(floor, typed_model()) == typed_model().predict(floor)
    assert (
        predict_building_type(floor, typed_model()).typicality < typed_model().predict(spread(NEW["school"])).typicality
    )


def test_labels_of_the_type_are_mapped_upwards():
    """The rooms are CLASSROOM, CORRIDOR and CLOSET; the labels FUNCTIONAL, CONNECTION and SERVICE follow from these."""
    assert predict_building_type(NEW["school"], typed_model()) == typed_model().predict(spread(NEW["school"]))


def test_a_floor_without_rooms():
    assert classify_building(Floor((), building_type={}), typed_model()) == Floor(())
    with pytest.raises(LabelError, match="no rooms"):
        predict_building_type(Floor(()), typed_model())


@pytest.mark.parametrize("floor", [lone_room(), lone_room("CONNECTION"), spread(make_house(2)), spread(make_house(3))])
def test_floors_of_few_rooms_and_without_corridors_can_be_predicted(floor):
    verdict = predict_building_type(floor, typed_model())
    assert sum(verdict.probabilities.values()) == pytest.approx(1)
    assert 0 <= verdict.typicality <= 1


def test_floors_of_one_building_are_recognised_by_their_names():
    assert typed_model().buildings[:3] == ("school a", "school a", "school b")
    numbered = [replace(floor, source=f"{floor.building_types[0]}{i}.xml") for i, floor in enumerate(typed_floors())]
    model = train_building_types(numbered, schemas=ALL_SCHEMAS)
    assert len(set(model.buildings)) == len(numbered)


def test_buildings_that_are_given():
    names = ["x", "x", "y", *["z"] * 2, "u", *"abcde", *"fghij"]
    assert train_building_types(typed_floors(), buildings=names, schemas=ALL_SCHEMAS).buildings == tuple(names)


def test_floors_without_rooms_are_skipped():
    empty = Floor((), building_type={"school": 1.0}, source="empty.xml")
    model = train_building_types([empty, *typed_floors()], schemas=ALL_SCHEMAS)
    assert [training.source for training in model.training_floors] == [floor.source for floor in typed_floors()]


@pytest.mark.parametrize(
    ("floors", "message"),
    [
        ([], "0 building types are given"),
        (typed_floors()[:4], "1 building type is given"),
        (typed_floors()[:7], "office has 1 building, give two types"),
        ([typed_floors()[1], typed_floors()[6]], "school has 1 building; office has 1 building"),
    ],
)
def test_invalid_training_floors_are_refused(floors, message):
    with pytest.raises(ModelError, match=message):
        train_building_types(floors)


def test_all_faults_are_listed_together():
    bare = replace(
        typed_floors()[6], rooms=(replace(typed_floors()[6].rooms[0], label=None), *typed_floors()[6].rooms[1:])
    )
    with pytest.raises(LabelError) as caught:
        train_building_types(
            [*typed_floors()[:3], bare, *(replace(each, building_type={"inn": 1}) for each in typed_floors()[-2:])]
        )
    message = str(caught.value)
    assert "\n" not in message
    for fault in (
        "rooms 1 of office a.xml have no label",
        "no schema of building type 'inn'",
        "office has 1 building",
    ):
        assert fault in message


def test_untyped_floors_are_not_too_few_types():
    untyped = [replace(floor, building_type={}) for floor in typed_floors()[:2]]
    with pytest.raises(LabelError, match="do not have a building type") as caught:
        train_building_types(untyped)
    assert "given" not in str(caught.value)


def test_types_and_buildings():
    check_types(["a", "a", "b", "b"], ["1", "2", "1", "2"])
    with pytest.raises(ModelError, match="b has 1 building"):
        check_types(["a", "a", "b", "b"], ["1", "2", "3", "3"])


def test_buildings_are_left_out_in_order():
    parts = [(training.tolist(), held_out.tolist()) for training, held_out in leave_buildings_out(["b", "a", "b", "c"])]
    assert parts == [([1, 3], [0, 2]), ([0, 2, 3], [1]), ([0, 1, 2], [3])]


def test_many_buildings_are_left_out_some_together():
    parts = [held_out.tolist() for _, held_out in leave_buildings_out(["b", "a", "b", "c"], parts=2)]
    assert parts == [[0, 2, 3], [1]]


@pytest.mark.slow
@pytest.mark.parametrize("label_set", [LabelSet.R_C, LabelSet.F_C_E_S])
def test_the_kernel(label_set):
    training = [describe_building(spread(floor), label_set) for floor in typed_floors()]
    kernel = BuildingKernel().fit(training)
    gram = kernel.compare()
    assert (gram == kernel.compare(training)).all()
    assert np.diag(gram) == pytest.approx(1)
    assert gram == pytest.approx(gram.T)
    assert (gram >= 0).all()
    assert (gram <= 1 + 1e-12).all()
    assert np.linalg.eigvalsh(gram).min() > -1e-9


def test_patterns_are_those_of_the_graph_kernel():
    """Bit by bit the values of NSPDK for each graph alone, also with some of the floors in the cache."""
    floors = [describe_building(spread(floor), LabelSet.F_C_E_S) for floor in typed_floors()]
    bounds = np.array([-0.3, 0.3])
    named = [(floor.name_rooms(bounds), floor.doors) for floor in floors]
    graphs = []
    for names, doors in named:
        graph = nx.Graph(doors)
        graph.add_nodes_from((index, {"label": name}) for index, name in enumerate(names))
        graphs.append(graph)
    kernel = NeighborhoodPairs(radius=RADIUS, distance=DISTANCE).fit(graphs[:9])
    cached_patterns(named[4:7])
    training, new = (
        [merge_counts(stack_patterns(blocks)) for blocks in zip(*cached_patterns(part), strict=True)]
        for part in (named[:9], named[9:])
    )
    np.testing.assert_array_equal(compare_counts(training, training), kernel.compare())
    np.testing.assert_array_equal(compare_counts(new, training), kernel.compare(graphs[9:]))


def test_features_are_compared_by_a_gaussian():
    training = typed_model().training_floors
    features = np.array([floor.features for floor in training])
    scaled = (features - features.mean(axis=0)) / np.where(features.std(axis=0) < 1e-6, np.inf, features.std(axis=0))
    apart = cdist(scaled, scaled, "sqeuclidean") / features.shape[1]
    predicted = BuildingKernel().fit(training).compare_features(training)
    np.testing.assert_allclose(predicted, np.exp(-apart / 2), rtol=0, atol=1e-14)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_real_floors_are_classified_correctly(data):
    model = read_default_building_type_model()
    for name in ("school/bronxville.xml", "office/off2.xml"):
        floor = spread(read_building(data / "buildings" / name))
        verdict = model.predict(floor)
        assert best(verdict) == name.partition("/")[0]
        assert verdict.is_known
        assert verdict.alike[0] == name.partition("/")[2]


@pytest.mark.slow
def test_held_out_training_floors():
    """On the platform of the measurement four of 43 are wrong and four unknown."""
    model = read_default_building_type_model()
    verdicts = predict_held_out(model)
    wrong = [
        training.source
        for training, type_name, predicted in zip(model.training_floors, model.types, verdicts, strict=True)
        if best(predicted) != type_name
    ]
    assert len(wrong) <= 5
    assert sum(not predicted.is_known for predicted in verdicts) <= 4


@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
@pytest.mark.parametrize("name", ["iranopen2013round2", "robocup2012preliminary1", "robocup2013final1"])
def test_worlds_of_robocup_are_no_buildings(data, name):
    floor = read_building(data / "buildings" / "robocup" / f"{name}.xml")
    assert classify_building(floor).building_type == {}


def test_buildings_of_two_types_with_the_same_names_are_four():
    floors = [replace(floor, source=f"{floor.source[-5]}.xml") for floor in typed_floors()]
    chosen = [floor for floor in floors if floor.building_types[0] != "house" and floor.source in ("a.xml", "b.xml")]
    model = train_building_types(chosen, schemas=ALL_SCHEMAS)
    assert set(model.buildings) == {"school/a", "school/b", "office/a", "office/b"}
    assert len(predict_held_out(model)) == len(chosen)


def test_features_that_are_equal_in_all_training_floors_do_not_count():
    training = typed_model().training_floors
    alike = [replace(each, features=np.r_[each.features, 0.5]) for each in training]
    other = replace(alike[0], features=np.r_[training[0].features, 0.9])
    assert BuildingKernel().fit(alike[1:]).compare([other]) == pytest.approx(
        BuildingKernel().fit(alike[1:]).compare([alike[0]])
    )


def test_missing_labels_are_predicted_and_the_others_stay():
    """The other rooms keep the labels that they have, although a new prediction would give other ones."""
    rooms = NEW["school"].rooms
    predicted = {"F/C/E/S": "SERVICE"}
    labelled = [
        replace(room, label="SERVICE", labels=predicted, label_probabilities={"F/C/E/S": {}}) for room in rooms[1:]
    ]
    floor = Floor((replace(rooms[0], label=None), *labelled), NEW["school"].doors)
    completed = fill_missing_labels(floor, LabelSet.F_C_E_S)
    assert [room.label for room in completed.floor.rooms[1:]] == ["SERVICE"] * len(labelled)
    assert completed.floor.rooms[0].label is not None
