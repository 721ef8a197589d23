"""The building that a file of the data shows."""

import json

import pytest

from pianta.errors import DataError
from pianta_bench.data.building_of import building_of


@pytest.mark.parametrize(
    ("file", "building"),
    [
        ("buildings/school/plans1.xml", "plans1"),
        ("kth/50010535_PLAN1.png", "5001053"),
        ("kth/50010536_PLAN3_rooms.png", "5001053"),
        ("vacuum/l10su_1058_goto_target_gt.png", "home1058"),
        ("vacuum/z10_1056_paths.yaml", "home1058"),
        ("vacuum/S5_FW2020_with_segments_gt.png", "S5_FW2020_with_segments"),
    ],
)
def test_a_file_without_a_record_is_a_building_of_its_own(tmp_path, file, building):
    assert building_of(tmp_path, file) == building


def test_files_of_one_building_have_one_name(tmp_path):
    files = ["buildings/school/rockislandgroundfloor.xml", "slam/rockislandsecondfloor.png"]
    (tmp_path / "manifest.json").write_text(json.dumps([{"path": file, "building": "rockisland"} for file in files]))
    assert {building_of(tmp_path, file) for file in files} == {"rockisland"}
    assert building_of(tmp_path, "slam/other.png") == "other"


def test_a_manifest_is_read_again_when_it_has_changed(tmp_path):
    for number in (1, 2):
        (tmp_path / "manifest.json").write_text(json.dumps([{"path": "a/b.xml", "building": "x" * number}]))
        assert building_of(tmp_path, "a/b.xml") == "x" * number


@pytest.mark.parametrize("content", ["{}x", "[1]", '[{"path": "a"}]'])
def test_a_manifest_of_another_kind_is_refused(tmp_path, content):
    (tmp_path / "manifest.json").write_text(content)
    with pytest.raises(DataError, match=r"manifest\.json.* is no list of files with `path` and `building`"):
        building_of(tmp_path, "a/b.xml")
