"""`pianta train buildings` and the building type of `pianta read`, as a user runs them."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from pianta.building_types.model import train_building_types
from pianta.building_types.model_file import read_building_type_model, save_building_type_model
from pianta.floor import Floor
from pianta.io.floors import read_floor, save_floor
from pianta.io.ros_maps import save_ros_map
from pianta.labels import LabelSet
from pianta.rooms.features import RoomContext
from pianta.rooms.model import RoomModel
from pianta.worlds.scan import simulate_map
from pianta.worlds.simulated_readings import simulate_and_reconstruct
from tests.command_line import list_files, run_pianta
from tests.labelled_floors import small_model
from tests.typed_floors import ALL_SCHEMAS, make_house, make_office, make_school, typed_floors

HOUSE = """
format: pianta labels
version: "1.0"
building_type: house
labels:
  - {name: LIVING ROOM, function: FUNCTIONAL}
  - {name: BATH, function: SERVICE}
"""
FUNCTIONS = {"FUNCTIONAL", "CONNECTION", "ENTRANCE", "SERVICE"}


@pytest.fixture(scope="module")
def buildings(tmp_path_factory):
    """A folder for each type."""
    folder = tmp_path_factory.mktemp("buildings")
    for floor in typed_floors():
        save_as(floor, folder / floor.building_types[0] / floor.source.replace(".xml", ".geojson"))
    (folder / "house.yaml").write_text(HOUSE)
    return folder


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """A model of floors as they are reconstructed from maps."""
    floors = [simulate_and_reconstruct(floor, seed=seed) for seed, floor in enumerate(typed_floors())]
    path = tmp_path_factory.mktemp("model") / "types.json"
    save_building_type_model(train_building_types(floors, schemas=ALL_SCHEMAS, label_set=LabelSet.R_C), path)
    return path


def map_of(floor: Floor, folder: Path) -> Path:
    """A map of a floor with walls of 20 cm."""
    folder.mkdir(exist_ok=True)
    rooms = tuple(replace(room, polygon=room.polygon.buffer(-0.1, join_style="mitre")) for room in floor.rooms)
    save_ros_map(simulate_map(replace(floor, rooms=rooms)), folder / "map.yaml")
    return folder / "map.yaml"


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    """A map of a new building of each type."""
    folder = tmp_path_factory.mktemp("maps")
    new_floors = {"school": make_school(7, width=6.8), "office": make_office(5, depth=3.2), "house": make_house(6)}
    return {type_name: map_of(floor, folder / type_name) for type_name, floor in new_floors.items()}


def save_as(floor: Floor, path: Path) -> Path:
    path.parent.mkdir(exist_ok=True)
    save_floor(floor, path)
    return path


@pytest.mark.slow
def test_train_on_three_types(buildings, tmp_path):
    folders = [buildings / type_name for type_name in ("school", "office", "house")]
    out_file = tmp_path / "types.json"
    code, out, err = run_pianta("train", "buildings", *folders, "--labels", buildings / "house.yaml", "-o", out_file)
    assert (code, err) == (0, "")
    trained, wrong, unknown, output = out.splitlines()
    assert trained == (
        "trained on 16 floors: 5 floors of 5 buildings of type house, 5 floors of 5 buildings of type office, "
        "6 floors of 5 buildings of type school"
    )
    assert wrong == "wrong types of floors whose building was left out: 0 of 16, 0.0%"
    assert re.fullmatch(r"called unknown when left out: \d+ of 16, \d+\.\d%", unknown)
    assert re.fullmatch(rf"in {re.escape(str(out_file))}, \d+ KB", output)
    assert read_building_type_model(out_file).building_types == ("house", "office", "school")
    assert list(tmp_path.iterdir()) == [out_file]


@pytest.mark.slow
def test_training_again_gives_the_same_bytes(buildings, tmp_path):
    for name in "ab":
        folders = buildings / "school", buildings / "office"
        assert run_pianta("train", "buildings", *folders, "-o", tmp_path / name, "-q") == (0, "", "")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_the_type_of_files_without_a_type(buildings, tmp_path):
    for number, floor in enumerate(typed_floors()[-3:]):
        save_as(replace(floor, building_type={}), tmp_path / f"{'abc'[number]}.geojson")
    options = ("--labels", buildings / "house.yaml", "--type", " House ", "-o", tmp_path / "types.json", "-q")
    assert run_pianta("train", "buildings", buildings / "school", tmp_path, *options) == (0, "", "")
    assert read_building_type_model(tmp_path / "types.json").building_types == ("house", "school")


@pytest.mark.slow
@pytest.mark.parametrize("what", ["buildings", "places"])
def test_a_predicted_type_is_not_used_in_training(buildings, tmp_path, what):
    """`pianta read` writes its prediction into floor.geojson; a user who corrects the labels does not confirm it."""
    for number, floor in enumerate(typed_floors()[-3:]):
        predicted = replace(floor, building_type={"school": 0.9, "office": 0.1})
        save_as(predicted, tmp_path / f"{'abc'[number]}.geojson")
    command = ("train", what, buildings / "school", tmp_path, "-o", tmp_path / "m.npz")
    code, out, err = run_pianta(*command)
    assert (code, out) == (2, "")
    assert " type" in err
    assert run_pianta(*command, "--labels", buildings / "house.yaml", "--type", "house", "-q") == (0, "", "")


def test_one_type_is_too_few(buildings, tmp_path):
    code, out, err = run_pianta("train", "buildings", buildings / "school", "-o", tmp_path / "types.json")
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert line.startswith("error: 1 building type")
    assert list_files(tmp_path) == {}


def test_all_faults_in_one_line(buildings, tmp_path):
    """Labels of another schema, a room without a label, and too few buildings."""
    office = typed_floors()[6]
    save_as(replace(office, rooms=(replace(office.rooms[0], label=None), *office.rooms[1:])), tmp_path / "x.geojson")
    school = typed_floors()[1]
    rooms = tuple(replace(room, label="WARD") for room in school.rooms)
    save_as(replace(school, rooms=rooms), tmp_path / "y.geojson")
    code, out, err = run_pianta("train", "buildings", tmp_path, buildings / "school", "-o", tmp_path / "types.json")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    for fault in ("x.geojson", "WARD", "office"):
        assert fault in err
    assert not (tmp_path / "types.json").exists()


@pytest.mark.slow
def test_a_building_that_cannot_be_read_does_not_stop_the_others(buildings, tmp_path):
    (tmp_path / "bad.xml").write_text("<svg/>")
    folders = buildings / "school", buildings / "office", tmp_path / "bad.xml"
    code, out, err = run_pianta("train", "buildings", *folders, "-o", tmp_path / "types.json")
    assert code == 1
    assert "bad.xml" in err
    assert "trained on 11 floors" in out


@pytest.mark.parametrize(("options", "fragment"), [(("--type", " "), "--type"), (("--labels", "no.yaml"), "no.yaml")])
def test_training_options_without_meaning_are_refused(buildings, tmp_path, options, fragment):
    code, out, err = run_pianta("train", "buildings", buildings, *options, "-o", tmp_path / "types.json")
    assert (code, out) == (2, "")
    assert fragment in err


@pytest.mark.slow
def test_read_prints_the_type(maps, model, tmp_path):
    for type_name, path in maps.items():
        code, out, err = run_pianta("read", path, "-o", tmp_path, "--building-model", model)
        assert (code, err) == (0, "")
        type_line = next(line for line in out.splitlines() if line.startswith("building: "))
        floor = read_floor(tmp_path / "floor.geojson")
        assert floor.building_types[0] == type_name
        assert sum(floor.building_type.values()) == pytest.approx(1)
        first, *others = (f"{name} {floor.building_type[name]:.2f}" for name in floor.building_types)
        assert type_line == f"building: {first} ({', '.join(others)})"
        assert set(floor.building_type) == {"house", "office", "school"}


def set_predicted_type(chances: dict[str, float], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "pianta.building_types.classify.classify_described",
        lambda floor, model=None, *, context=None: replace(floor, building_type=chances),
    )


@pytest.mark.slow
@pytest.mark.parametrize("chances", [{"school": 0.99, "office": 0.01}, {"school": 0.2, "house": 0.8}, {}])
def test_a_predicted_type_gives_rooms_no_labels(maps, tmp_path, monkeypatch, chances):
    set_predicted_type(chances, monkeypatch)
    assert run_pianta("read", maps["school"], "-o", tmp_path, "-q") == (0, "", "")
    floor = read_floor(tmp_path / "floor.geojson")
    assert floor.building_type == chances
    for room in floor.rooms:
        if chances:
            assert room.labels.keys() == {"R/C", "F/C/E/S"}
            assert room.label in FUNCTIONS
        else:
            assert room.labels.keys() == {"R/C"}
            assert room.label in {"ROOM", "CORRIDOR", None}


@pytest.mark.slow
def test_a_building_unlike_all_training_floors(maps, model, tmp_path):
    hall = map_of(make_house(1, width=30), tmp_path / "hall")
    code, out, err = run_pianta("read", hall, "-o", tmp_path, "--building-model", model)
    assert (code, err) == (0, "")
    unknown = "building: unknown, unlike every type that the model knows (house, office, school)"
    assert unknown in out.splitlines()
    floor = read_floor(tmp_path / "floor.geojson")
    assert floor.building_type == {}
    assert {room.label for room in floor.rooms} <= {"ROOM", "CORRIDOR", None}
    left_out = "labels: ROOM and CORRIDOR alone, where they are certain; --label-unknown shows the others"
    assert left_out in out.splitlines()
    options = ("--building-model", model, "--label-unknown")
    code, out, err = run_pianta("read", hall, "-o", tmp_path, *options)
    assert (code, err) == (0, "")
    assert unknown in out.splitlines()
    assert left_out not in out
    assert {room.label for room in read_floor(tmp_path / "floor.geojson").rooms} <= FUNCTIONS


@pytest.mark.slow
@pytest.mark.parametrize(
    ("chances", "description"),
    [({"office": 0.3, "school": 0.7}, "school 0.70"), ({"house": 1.0}, "house 1.00"), ({}, "unknown type")],
)
def test_the_type_in_the_line_of_each_map(maps, tmp_path, monkeypatch, chances, description):
    set_predicted_type(chances, monkeypatch)
    code, out, err = run_pianta("read", *maps.values(), "-o", tmp_path)
    assert (code, err) == (0, "")
    assert [line.partition(" m², ")[2] for line in out.splitlines()[:3]] == [
        f"{description}, in {tmp_path / type_name}-map" for type_name in maps
    ]


@pytest.mark.slow
@pytest.mark.parametrize("options", [("--type", "school"), ("--no-labels",)])
def test_a_given_type_is_not_predicted(maps, tmp_path, options):
    code, out, err = run_pianta("read", maps["house"], "-o", tmp_path, *options)
    assert (code, err) == (0, "")
    assert "building:" not in out
    assert read_floor(tmp_path / "floor.geojson").building_type == ({"school": 1.0} if "school" in options else {})
    _, out, _ = run_pianta("read", maps["house"], maps["office"], "-o", tmp_path, *options)
    assert "unknown type" not in out


@pytest.mark.slow
def test_a_given_type_stays_and_a_predicted_one_does_not(maps, tmp_path):
    folder = tmp_path / "out"
    for old, type_line in [
        ({"office": 1.0}, "building: office, as given by a user"),
        ({"office": 0.9, "school": 0.1}, None),
    ]:
        assert run_pianta("read", maps["school"], "-o", folder, "-q") == (0, "", "")
        floor = read_floor(folder / "floor.geojson")
        predicted = floor.building_type
        save_floor(replace(floor, building_type=old), folder / "floor.geojson")
        code, out, err = run_pianta("read", maps["school"], "--previous", folder, "-o", folder)
        assert (code, err) == (0, "")
        again = read_floor(folder / "floor.geojson")
        assert again.building_type == (old if type_line else predicted)
        assert type_line is None or type_line in out.splitlines()
    assert run_pianta("read", maps["school"], "--previous", folder, "-o", folder, "--type", "school", "-q").code == 0
    assert read_floor(folder / "floor.geojson").building_type == {"school": 1.0}


@pytest.mark.slow
def test_manual_labels_stay_under_a_predicted_type(maps, model, tmp_path):
    assert run_pianta("read", maps["school"], "-o", tmp_path, "-q", "--building-model", model) == (0, "", "")
    floor = read_floor(tmp_path / "floor.geojson")
    corrected = (replace(floor.rooms[0], label="CHAPEL"), *floor.rooms[1:])
    save_floor(replace(floor, rooms=corrected), tmp_path / "floor.geojson")
    options = ("--previous", tmp_path, "-o", tmp_path, "-q", "--building-model", model)
    assert run_pianta("read", maps["school"], *options) == (0, "", "")
    again = read_floor(tmp_path / "floor.geojson")
    by_id = {room.id: room for room in again.rooms}
    assert (by_id[floor.rooms[0].id].label, by_id[floor.rooms[0].id].labels) == ("CHAPEL", {})
    assert again.building_type == floor.building_type
    assert all(by_id[room.id].label == room.label for room in floor.rooms[1:])


@pytest.mark.parametrize(
    ("options", "fragment"),
    [
        (("--building-model", "nowhere.json"), "nowhere.json"),
        (("--building-model", "types.json", "--type", "school"), "--building-model"),
        (("--building-model", "types.json", "--no-labels"), "--no-labels"),
    ],
)
def test_reading_options_without_meaning_are_refused(maps, tmp_path, options, fragment):
    code, out, err = run_pianta("read", maps["school"], "-o", tmp_path / "out", *options)
    assert (code, out) == (2, "")
    assert fragment in err
    assert err.count("\n") == 1
    assert not list_files(tmp_path / "out")


@pytest.mark.slow
def test_models_of_rooms_and_of_buildings_are_not_mixed_up(maps, model, tmp_path):
    from pianta.rooms.model_file import save_room_model

    save_room_model(small_model(), tmp_path / "places.npz")
    code, _, err = run_pianta("read", maps["school"], "-o", tmp_path, "--building-model", tmp_path / "places.npz")
    assert (code, "pianta train buildings" in err) == (2, True)
    code, _, err = run_pianta("read", maps["school"], "-o", tmp_path, "--model", model)
    assert (code, str(model) in err) == (2, True)


@pytest.mark.slow
def test_the_type_is_predicted_from_manual_labels(maps, tmp_path, monkeypatch):
    folder = tmp_path / "out"
    assert run_pianta("read", maps["school"], "-o", folder, "-q") == (0, "", "")
    floor = read_floor(folder / "floor.geojson")
    rooms = tuple(replace(room, label="ENTRANCE") for room in floor.rooms)
    save_floor(replace(floor, rooms=rooms), folder / "floor.geojson")
    classified: list[Floor] = []

    def classify(floor: Floor, model: object = None, *, context: object = None) -> Floor:
        classified.append(floor)
        return floor

    monkeypatch.setattr("pianta.building_types.classify.classify_described", classify)
    assert run_pianta("read", maps["school"], "--previous", folder, "-o", folder, "-q") == (0, "", "")
    assert {room.label for room in classified[0].rooms} == {"ENTRANCE"}


@pytest.mark.slow
def test_only_the_given_room_model_labels_rooms(maps, tmp_path, monkeypatch):
    """A label that no schema has stays; for the building type, the label of the given model counts."""
    folder = tmp_path / "out"
    assert run_pianta("read", maps["school"], "-o", folder, "-q") == (0, "", "")
    floor = read_floor(folder / "floor.geojson")
    ward, *others = floor.rooms
    save_floor(replace(floor, rooms=(replace(ward, label="WARD"), *others)), folder / "floor.geojson")
    labelled: list[Floor] = []
    label = RoomModel.label

    def count(model: RoomModel, floor: Floor, *, context: RoomContext | None = None) -> Floor:
        labelled.append(floor)
        return label(model, floor, context=context)

    monkeypatch.setattr(RoomModel, "label", count)
    assert run_pianta("read", maps["school"], "--previous", folder, "-o", folder, "-q") == (0, "", "")
    assert len(labelled) == 1
    assert read_floor(folder / "floor.geojson").rooms[0].label == "WARD"
