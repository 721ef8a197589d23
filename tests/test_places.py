"""Training of room models, and the labels that they predict."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from shapely import box
from shapely.affinity import rotate, scale, translate

from pianta.errors import LabelError, ModelError
from pianta.floor import Floor, Room, scale_floor
from pianta.labels import FCES, SCHEMAS, SCHOOL, GeneralLabel, Label, LabelSchema
from pianta.rooms.label import label_rooms
from pianta.rooms.model import FUNCTIONS, choose_functions, has_manual_label, keep_manual_label
from pianta.rooms.training import SIMULATED_WEIGHT, building_name, check_labels, train_rooms
from pianta.worlds.floors import make_floor
from pianta.worlds.simulated_readings import draw_map_options, simulate_and_reconstruct
from tests.labelled_floors import label_by_rule, labelled_floors, small_model


@pytest.fixture(scope="module")
def unseen():
    return label_by_rule(make_floor("corridor", seed=5), source="unseen.xml")


def unlabelled(floor: Floor) -> Floor:
    return replace(floor, rooms=tuple(Room(room.id, room.polygon) for room in floor.rooms))


def test_labels_of_an_unseen_floor(unseen):
    labelled = label_rooms(unlabelled(unseen), small_model())
    right = [room.label == true.label for room, true in zip(labelled.rooms, unseen.rooms, strict=True)]
    assert np.mean(right) > 0.8
    corridors = {room.id for room in unseen.rooms if room.label == "CORRIDOR"}
    assert {room.id for room in labelled.rooms if room.labels["R/C"] == "CORRIDOR"} == corridors


def test_label_sets_agree_with_each_other(unseen):
    for room in label_rooms(unlabelled(unseen), small_model()).rooms:
        assert list(room.labels) == ["R/C", "F/C/E/S", "school"]
        label = SCHOOL.by_name[room.labels["school"]]
        assert (label.room_or_corridor(), label.function_in()) == (room.labels["R/C"], room.labels["F/C/E/S"])
        assert room.label == room.labels["school"]


def test_probabilities_add_up_level_by_level(unseen):
    for room in label_rooms(unlabelled(unseen), small_model()).rooms:
        functions, names = room.label_probabilities["F/C/E/S"], room.label_probabilities["school"]
        assert sum(functions.values()) == pytest.approx(1)
        assert room.label_probabilities["R/C"]["CORRIDOR"] == functions["CONNECTION"]
        for function, probability in functions.items():
            below = [label.name for label in SCHOOL.labels if label.function_in() == function]
            assert sum(names[name] for name in below) == pytest.approx(probability)


def test_without_a_type_there_are_no_names(unseen):
    floor = replace(unlabelled(unseen), building_type={})
    for room in label_rooms(floor, small_model()).rooms:
        assert list(room.labels) == list(room.label_probabilities) == ["R/C", "F/C/E/S"]
        assert room.label == room.labels["F/C/E/S"]


def test_a_type_that_the_model_does_not_know_gives_no_names(unseen):
    floor = replace(unlabelled(unseen), building_type={"castle": 0.9, "school": 0.1})
    assert list(label_rooms(floor, small_model()).rooms[0].labels) == ["R/C", "F/C/E/S", "school"]
    floor = replace(floor, building_type={"castle": 1.0})
    assert list(label_rooms(floor, small_model()).rooms[0].labels) == ["R/C", "F/C/E/S"]


def test_older_labels_do_not_matter(unseen):
    wrong = replace(unseen, rooms=tuple(replace(room, label="GYM") for room in unseen.rooms))
    assert label_rooms(wrong, small_model()) == label_rooms(unlabelled(unseen), small_model())


def test_nothing_else_of_the_floor_changes(unseen):
    labelled = label_rooms(unlabelled(unseen), small_model())
    assert replace(labelled, rooms=unlabelled(unseen).rooms) == unlabelled(unseen)
    assert [room.polygon for room in labelled.rooms] == [room.polygon for room in unseen.rooms]


def test_turned_moved_and_rescaled_floors_get_the_same_labels(unseen):
    def move(shape: Any) -> Any:
        return translate(scale(rotate(shape, 33, origin=(0, 0)), 1.7, 1.7, origin=(0, 0)), 40, -7)

    rooms = tuple(replace(room, polygon=move(room.polygon)) for room in unseen.rooms)
    doors = tuple(replace(door, line=move(door.line), width=door.width * 1.7) for door in unseen.doors)
    moved = replace(unseen, rooms=rooms, doors=doors, walls=())
    predicted, predicted_of_moved = (small_model().passes(each)["random field"] for each in (unseen, moved))
    assert predicted_of_moved == pytest.approx(predicted, abs=0.05)


def test_a_single_room_and_none():
    alone = label_rooms(Floor((Room(1, box(0, 0, 4, 3)),)), small_model())
    assert list(alone.rooms[0].labels) == ["R/C", "F/C/E/S"]
    assert label_rooms(Floor(()), small_model()) == Floor(())


def test_training_record_in_words():
    training = small_model().training
    assert training.floors == tuple(sorted(floor.source for floor in labelled_floors()))
    assert training.rooms == {"school": sum(len(floor.rooms) for floor in labelled_floors())}
    assert str(training).startswith("6 floors: ")
    assert 0 <= training.errors["R/C"] <= training.errors["F/C/E/S"] < 0.3


@pytest.mark.slow
def test_the_same_seed_trains_the_same_model(unseen):
    again = train_rooms(labelled_floors())
    for predicted, predicted_again in zip(
        small_model().passes(unseen).values(), again.passes(unseen).values(), strict=True
    ):
        assert (predicted == predicted_again).all()
    assert again.field.temperature == small_model().field.temperature


@pytest.mark.slow
def test_folds_do_not_depend_on_the_order_of_floors():
    backwards = train_rooms(labelled_floors()[::-1])
    assert backwards.training.floors == small_model().training.floors


def test_passes_are_the_steps_of_the_model(unseen):
    passes = small_model().passes(unseen)
    assert list(passes) == ["first pass", "second pass", "random field"]
    assert all(predicted.shape == (len(unseen.rooms), len(FUNCTIONS)) for predicted in passes.values())
    assert all(predicted.sum(axis=1) == pytest.approx(1) for predicted in passes.values())


def test_unknown_labels_are_all_listed():
    first, *others = labelled_floors()
    rooms = (replace(first.rooms[0], label="POOL"), replace(first.rooms[1], label=None), *first.rooms[2:])
    with pytest.raises(LabelError, match=rf"rooms {rooms[1].id} of corridor house 1.xml have no label.*'POOL' "):
        train_rooms([replace(first, rooms=rooms), *others])


def test_unknown_types_are_listed():
    first, *others = labelled_floors()
    with pytest.raises(LabelError, match="no schema of building type 'castle'"):
        train_rooms([replace(first, building_type={"castle": 1.0}), *others])


def test_one_building_is_too_few():
    with pytest.raises(ModelError, match="1 building is too few"):
        train_rooms([*labelled_floors()[:1]] * 2)


@pytest.mark.slow
def test_few_floors_with_numbered_names_are_buildings_of_their_own():
    assert [building_name(floor.source) for floor in labelled_floors()[:2]] == ["corridor house"] * 2
    assert train_rooms(labelled_floors()[:2]).training.rooms["school"] > 20


@pytest.mark.slow
def test_a_schema_of_the_user():
    ward = Label("WARD", FCES.FUNCTIONAL, GeneralLabel.MEDIUM, "#112233")
    hospital = LabelSchema("hospital", (ward, SCHOOL.by_name["CORRIDOR"], SCHOOL.by_name["STAIRS"]))
    rename = {"CLASSROOM": "WARD", "CLOSET": "WARD"}
    floors = [
        replace(
            floor,
            building_type={"hospital": 1.0},
            rooms=tuple(replace(room, label=rename.get(str(room.label), room.label)) for room in floor.rooms),
        )
        for floor in labelled_floors()
    ]
    model = train_rooms(floors, schemas={**SCHEMAS, "hospital": hospital})
    assert model.building_types == ("hospital",)
    assert {room.label for room in model.label(floors[0]).rooms} <= {"WARD", "CORRIDOR", "STAIRS"}


@pytest.mark.parametrize(
    ("source", "building"),
    [
        ("falaelem1.xml", "falaelem"),
        ("dir/Valleceppi_P0.xml", "dir/Valleceppi_P"),
        ("St. Anna 1.xml", "St. Anna"),
        ("St. Anna 1", "St. Anna"),
        ("b1-1.xml", "b1"),
        ("b1-2.GeoJSON", "b1"),
        ("house/1.xml", "house/1.xml"),
        ("house 2", "house"),
        ("bronxville.xml", "bronxville"),
        ("123.xml", "123.xml"),
        ("", ""),
    ],
)
def test_building_of_a_file(source, building):
    assert building_name(source) == building


@pytest.mark.slow
def test_simulated_reading_keeps_labels():
    floor = labelled_floors()[0]
    read = simulate_and_reconstruct(floor, seed=1)
    assert abs(len(read.rooms) - len(floor.rooms)) <= 2
    assert read.building_type == floor.building_type
    assert read.source == floor.source
    corridors = [room for room in read.rooms if room.label == "CORRIDOR"]
    assert max(read.rooms, key=lambda room: read.graph().degree(room.id)) in corridors
    assert simulate_and_reconstruct(floor, seed=1) == read
    assert simulate_and_reconstruct(floor, seed=2) != read


def test_simulated_readings_of_furnished_floors():
    floor = labelled_floors()[0]
    read = simulate_and_reconstruct(floor, seed=3, furnished=True)
    assert simulate_and_reconstruct(floor, seed=3, furnished=True) == read
    assert read != simulate_and_reconstruct(floor, seed=3)
    assert {room.label for room in read.rooms} <= {room.label for room in floor.rooms}
    # A drawing with a wrong scale is read at a usual one.
    huge = simulate_and_reconstruct(scale_floor(floor, 10, 10), seed=3, furnished=True)
    assert np.median([room.polygon.area for room in huge.rooms]) < 100


def test_maps_of_furnished_floors_differ_in_all_options():
    all_options = [draw_map_options(np.random.default_rng(seed)) for seed in range(60)]
    assert {options["resolution"] for options in all_options} == {0.05, 0.1}
    empty, dense = (
        sum(map(check, all_options)) for check in (lambda o: not o["furniture"], lambda o: o["dense_furniture"])
    )
    assert 5 <= empty <= 25
    assert 15 <= dense <= 40
    assert all(0.1 <= options["noise"] <= 0.9 for options in all_options)


def test_labels_set_by_a_person():
    room = Room(1, box(0, 0, 4, 3))
    predicted = {"R/C": {"ROOM": 0.9, "CORRIDOR": 0.1}}
    by_model = replace(room, label="GYM", labels={"R/C": "ROOM", "school": "GYM"}, label_probabilities=predicted)
    assert not has_manual_label(room)
    assert not has_manual_label(by_model)
    assert has_manual_label(replace(room, label="GYM"))
    corrected = replace(by_model, label="LIBRARY")
    assert has_manual_label(corrected)
    assert keep_manual_label(corrected) == replace(room, label="LIBRARY")
    assert keep_manual_label(by_model) == room


def test_floors_without_a_type_are_named():
    first, *others = labelled_floors()
    with pytest.raises(LabelError, match=r"corridor house 1.xml .*building_type="):
        train_rooms([replace(first, building_type={}), *others])


@pytest.mark.slow
def test_a_type_may_be_in_any_case(unseen):
    for name in ("School", " school ", "SCHOOL"):
        floor = replace(unlabelled(unseen), building_type={name: 1.0})
        assert label_rooms(floor, small_model()).rooms == label_rooms(unlabelled(unseen), small_model()).rooms
    loud = [replace(floor, building_type={" SCHOOL": 1.0}) for floor in labelled_floors()]
    check_labels(loud)
    assert train_rooms(loud[:2]).training.rooms.keys() == {"school"}


def test_a_function_is_chosen_from_r_c_down():
    """The second room is no corridor, although CONNECTION is the most probable of the four."""
    assessed = np.array([[0.1, 0.6, 0.2, 0.1], [0.3, 0.4, 0.2, 0.1], [0.0, 0.5, 0.1, 0.4], [0.7, 0.1, 0.1, 0.1]])
    assert choose_functions(assessed).tolist() == [1, 0, 3, 0]


def test_faults_of_simulated_floors_are_listed_once_after_those_of_annotated_ones():
    first, *others = labelled_floors()
    unusual = replace(first, rooms=(replace(first.rooms[0], label="POOL"), *first.rooms[1:]))
    with pytest.raises(LabelError, match="'POOL'"):
        train_rooms(labelled_floors(), simulated=[unusual])
    bare = replace(first, rooms=(replace(first.rooms[0], label=None), *first.rooms[1:]))
    with pytest.raises(LabelError) as caught:
        train_rooms([bare, *others], simulated=[bare])
    assert str(caught.value).count("have no label") == 1


@pytest.mark.slow
def test_simulated_rooms_count_less_for_names():
    """Copies of the floors whose classrooms are called LAB: only the weights differ."""
    floors, renamed = labelled_floors(), {"CLASSROOM": "LAB"}
    simulated = [
        replace(
            floor, rooms=tuple(replace(room, label=renamed.get(str(room.label), room.label)) for room in floor.rooms)
        )
        for floor in floors
    ]
    model = train_rooms(floors, simulated=simulated)
    predicted = [
        room.label_probabilities["school"]
        for floor in floors
        for room, true in zip(model.label(floor).rooms, floor.rooms, strict=True)
        if true.label == "CLASSROOM"
    ]
    shares = [names["LAB"] / (names["LAB"] + names["CLASSROOM"]) for names in predicted]
    assert np.median(shares) == pytest.approx(SIMULATED_WEIGHT / (1 + SIMULATED_WEIGHT), abs=0.01)


@pytest.mark.slow
def test_simulated_rooms_without_weight_change_nothing(monkeypatch):
    """Their pairs of classrooms would change the random field if they counted."""
    floors = labelled_floors()
    unusual = [replace(each, rooms=tuple(replace(room, label="STAIRS") for room in each.rooms)) for each in floors]
    annotated = train_rooms(floors)
    monkeypatch.setattr("pianta.rooms.training.SIMULATED_WEIGHT", 1e-9)
    both = train_rooms(floors, simulated=unusual)
    assert both.field.doors == pytest.approx(annotated.field.doors, abs=0.1)
    assert both.field.alike == pytest.approx(annotated.field.alike, abs=0.1)
    monkeypatch.setattr("pianta.rooms.training.SIMULATED_WEIGHT", 0.99)
    counted = train_rooms(floors, simulated=unusual)
    assert abs(counted.field.doors - annotated.field.doors).max() > 1
