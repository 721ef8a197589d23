"""Which labels `pianta read` leaves out in a building of no known type."""

from dataclasses import replace
from pathlib import Path

import pytest
from shapely import LineString, box

import pianta
from pianta.errors import OptionError
from pianta.floor import Door, Floor, Room
from pianta.labels import RC
from pianta.reading._labelling import MIN_COARSE_PROBABILITY, Labelling
from tests.command_line import run_pianta

# A flat: two rooms at a hall.
FLAT = Floor(
    rooms=(Room(1, box(0, 0, 4, 3)), Room(2, box(0, 4.5, 4, 8)), Room(3, box(0, 3.1, 4, 4.4))),
    doors=(Door((1, 3), LineString([(1, 3.05), (2, 3.05)]), 1.0), Door((2, 3), LineString([(1, 4.45), (2, 4.45)]), 1)),
)


def set_predicted_type(chances: dict[str, float], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "pianta.building_types.classify.classify_described",
        lambda floor, model=None, *, context=None: replace(floor, building_type=chances),
    )


@pytest.fixture
def labelling() -> Labelling:
    return Labelling.make(None, None, None, None)


def test_a_known_type_keeps_all_labels(labelling, monkeypatch):
    set_predicted_type({"school": 1.0}, monkeypatch)
    for room in labelling.label(FLAT).rooms:
        assert room.labels.keys() == {"R/C", "F/C/E/S"}
        assert room.label == room.labels["F/C/E/S"]


def test_an_unknown_type_keeps_certain_rooms_and_corridors(labelling, monkeypatch):
    set_predicted_type({"school": 1.0}, monkeypatch)
    full_floor = labelling.label(FLAT)
    set_predicted_type({}, monkeypatch)
    unknown = labelling.label(FLAT)
    assert not unknown.building_type
    for room, full in zip(unknown.rooms, full_floor.rooms, strict=True):
        assert room.labels == {"R/C": full.labels["R/C"]}
        assert room.label_probabilities == {"R/C": full.label_probabilities["R/C"]}
        probability = room.label_probabilities["R/C"][room.labels["R/C"]]
        assert room.label == (room.labels["R/C"] if probability >= MIN_COARSE_PROBABILITY else None)


@pytest.mark.parametrize(("probability", "label"), [(0.95, "CORRIDOR"), (0.85, None)])
def test_a_label_below_the_limit_is_left_out(labelling, monkeypatch, probability, label):
    set_predicted_type({}, monkeypatch)
    probabilities = {
        "R/C": {str(RC.ROOM): 1 - probability, str(RC.CORRIDOR): probability},
        "F/C/E/S": {"CONNECTION": probability, "SERVICE": 1 - probability},
    }
    labels = {"R/C": "CORRIDOR", "F/C/E/S": "CONNECTION"}
    rooms = tuple(
        replace(room, label="CONNECTION", labels=labels, label_probabilities=probabilities) for room in FLAT.rooms
    )
    monkeypatch.setattr(
        "pianta.rooms.from_names.label_named_rooms",
        lambda floor, model, words, *, context=None: replace(floor, rooms=rooms),
    )
    assert [room.label for room in labelling.label(FLAT).rooms] == [label] * 3
    everything = replace(labelling, label_unknown=True)
    assert everything.label(FLAT).rooms == rooms


def test_manual_labels_and_labels_by_name_stay(labelling, monkeypatch):
    set_predicted_type({}, monkeypatch)
    first, second, hall = FLAT.rooms
    floor = replace(FLAT, rooms=(replace(first, label="CHAPEL"), replace(second, name="WC"), replace(hall, name="Zx")))
    chapel, toilet, unnamed = labelling.label(floor).rooms
    assert chapel.label == "CHAPEL"
    assert toilet.label == "SERVICE"
    assert unnamed.label in {"ROOM", "CORRIDOR", None}


def test_a_given_type_keeps_all_labels(monkeypatch):
    set_predicted_type({}, monkeypatch)
    labelling = Labelling.make(None, None, None, "school")
    labels = [room.labels for room in labelling.label(replace(FLAT, building_type={"school": 1.0})).rooms]
    assert all(each.keys() == {"R/C", "F/C/E/S", "school"} for each in labels)


def test_no_labels_contradicts_all_labels(tmp_path: Path):
    with pytest.raises(OptionError, match="label_unknown=True"):
        pianta.read("map.yaml", labels=False, label_unknown=True)
    code, out, err = run_pianta("read", "map.yaml", "-o", tmp_path, "--no-labels", "--label-unknown")
    assert (code, out) == (2, "")
    assert "--no-labels makes --label-unknown useless" in err
