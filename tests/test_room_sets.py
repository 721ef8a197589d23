import json

import numpy as np
import pytest
from shapely import LineString, box

from pianta.errors import DataError, LabelError
from pianta.floor import Door, Floor, Room
from pianta_bench.types.room_sets import RoomSet, join_room_sets, name_sizes_by_area, read_room_sets, represent_floor
from tests.tiny_types import write_types


def make_set(labels: str, areas: list[float]) -> RoomSet:
    geometry = np.column_stack([areas, np.ones((len(areas), 2))])
    names = {(label, label.lower()): labels.count(label) for label in labels}
    return RoomSet(
        "House", geometry, np.zeros((len(areas), 5)), np.array([*labels]), np.array(["x"] * len(areas)), names
    )


def test_rooms_are_described_by_geometry_and_by_what_is_behind_their_doors():
    rooms = Room(4, box(0, 0, 10, 2)), Room(2, box(0, 2, 3, 5)), Room(9, box(3, 2, 5, 3))
    line = LineString([(1, 2), (2, 2)])
    doors = [Door(ids, line, 1) for ids in ((4, 2), (2, 4), (4, 9), (4, None))]
    geometry, neighbours = represent_floor(Floor(rooms, tuple(doors)), ["C", "M", "S"])
    assert geometry.tolist() == [[20, 4, 5], [9, 2, 1], [2, 1, 2]]
    assert neighbours.tolist() == [[0, 0, 1, 2, 0], [2, 0, 0, 0, 0], [1, 0, 0, 0, 0]]


def test_sizes_by_area_leave_corridors_and_halls():
    by_area = name_sizes_by_area(make_set("CHBSM", [1, 500, 10, 10.1, 30]), (10, 20))
    assert by_area.labels.tolist() == ["C", "H", "S", "M", "B"]
    assert by_area.corridors.tolist() == [True, True, False, False, False]


def test_the_union_has_all_rooms_and_counts_names_together():
    union = join_room_sets("U", [make_set("CS", [1, 2]), make_set("SB", [3, 4])])
    assert union.geometry[:, 0].tolist() == [1, 2, 3, 4]
    assert union.labels.tolist() == [*"CSSB"]
    assert union.names == {("C", "c"): 1, ("S", "s"): 2, ("B", "b"): 1}


def test_types_in_the_data_are_read_and_joined(tmp_path):
    write_types(tmp_path, "school", "office")
    (school, office, union), failed = read_room_sets(tmp_path)
    assert failed == []
    assert (school.name, office.name, union.name) == ("School", "Office", "S+O")
    assert len(school.labels) == 28
    assert school.names == {("C", "CORRIDOR"): 2, ("M", "CLASSROOM"): 12, ("S", "CLOSET"): 12, ("H", "HALL"): 2}
    assert set(union.buildings) == {"school/school0", "school/school1", "office/office0", "office/office1"}
    assert len(union.labels) == 56


def test_houses_come_first_with_general_labels_or_a_schema_of_their_own(tmp_path):
    write_types(tmp_path, "house", "school")
    assert [rooms.name for rooms in read_room_sets(tmp_path)[0]] == ["House", "School", "H+S"]
    schema = tmp_path / "buildings" / "house" / "labels.yaml"
    labels = [("M", "FUNCTIONAL", "B"), ("S", "SERVICE", "S"), ("H", "CONNECTION", "H"), ("C", "CONNECTION", "C")]
    lines = [f"  - {{name: {name}, function: {function}, size: {size}}}" for name, function, size in labels]
    header = ['format: "pianta labels"', 'version: "1.0"', "building_type: house", "labels:"]
    schema.write_text("\n".join([*header, *lines]))
    house = read_room_sets(tmp_path)[0][0]
    assert set(house.labels) == {"B", "S", "H", "C"}


def test_floors_of_one_building_are_joined_by_the_list_of_files(tmp_path):
    write_types(tmp_path, "school", buildings=3)
    records = [{"path": f"buildings/school/school{n}.xml", "building": "both"} for n in (0, 2)]
    (tmp_path / "manifest.json").write_text(json.dumps(records))
    (school,), _ = read_room_sets(tmp_path)
    assert set(school.buildings) == {"school/both", "school/school1"}
    (tmp_path / "manifest.json").write_text("{}x")
    with pytest.raises(DataError, match=r"manifest\.json"):
        read_room_sets(tmp_path)


def test_what_cannot_be_learnt_from_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"house.*school.*office"):
        read_room_sets(tmp_path)
    write_types(tmp_path, "school", buildings=1)
    with pytest.raises(DataError, match="school"):
        read_room_sets(tmp_path)


def test_one_bad_floor_does_not_stop_the_others(tmp_path):
    write_types(tmp_path, "house", buildings=4)
    folder = tmp_path / "buildings" / "house"
    unknown_label, broken = folder / "house0.xml", folder / "house1.xml"
    unknown_label.write_text(unknown_label.read_text().replace("<label>M<", "<label>KITCHEN<"))
    broken.write_text("<building")
    (house,), failed = read_room_sets(tmp_path)
    assert set(house.buildings) == {"house/house2", "house/house3"}
    assert len(house.labels) == sum(house.names.values()) == 28
    assert [(item.part, item.item) for item in failed] == [("houses", "house0"), ("houses", "house1")]
    assert failed[0].failure == ("labels KITCHEN are not among C, H, S, M, B, give the schema of houses as labels.yaml")
    assert "is no XML" in str(failed[1].failure)


def test_where_too_few_floors_are_left_the_error_names_the_faults(tmp_path):
    write_types(tmp_path, "house")
    for file in (tmp_path / "buildings" / "house").iterdir():
        file.write_text(file.read_text().replace("<label>M<", "<label>KITCHEN<"))
    with pytest.raises(DataError, match=r"house0.*KITCHEN.*house1"):
        read_room_sets(tmp_path)


def test_a_schema_that_is_none_is_refused(tmp_path):
    write_types(tmp_path, "house")
    (tmp_path / "buildings" / "house" / "labels.yaml").write_text("labels: none")
    with pytest.raises(LabelError, match=r"labels\.yaml"):
        read_room_sets(tmp_path)
