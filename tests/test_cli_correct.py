"""`pianta correct`, and `pianta read --previous` of a folder with corrections, as a user runs them."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest
from PIL import Image

import pianta
from pianta.corrections.corrections_file import read_corrections
from pianta.corrections.kinds import NameRoom
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import OCCUPIED, UNKNOWN, GridMap
from pianta.io.floors import read_floor
from pianta.io.maps import read_map
from pianta.reading.saved_reading import SavedReading
from pianta.worlds.floors import make_corridor_floor, make_hall_floor
from pianta.worlds.scan import simulate_map
from tests.command_line import list_files, run_pianta
from tests.test_invariance import view_doubled, view_turned

pytestmark = pytest.mark.slow
# The first map: rooms 1 to 4 north of corridor 5, from x = 0 to 20, and rooms 6 to 11 south of it, where y is negative.
# Room 2 reaches from (3.95, 2.40) to (8.40, 8.25), room 8 from (6.85, -5.85) to (9.85, 0.00).
SPLIT_8 = "6.85,-3 9.85,-3"
DOOR_6_7 = "3.22,-3.5 3.22,-2.6"


@pytest.fixture(scope="module")
def grid() -> GridMap:
    return simulate_map(make_corridor_floor(length=20, room_width=(3, 5), seed=2))


@pytest.fixture(scope="module")
def read_once(grid: GridMap, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the map, and its reading in `building`."""
    folder = tmp_path_factory.mktemp("read")
    grid.save(folder / "map.yaml")
    assert run_pianta("read", folder / "map.yaml", "-o", folder / "building", "--no-labels", "-q").code == 0
    return folder


@pytest.fixture
def folder(read_once: Path, tmp_path: Path) -> Path:
    """A copy of that folder."""
    return copytree(read_once, tmp_path / "here")


@pytest.fixture
def building(folder: Path) -> Path:
    return folder / "building"


def floor_of(building: Path) -> Floor:
    return read_floor(building / "floor.geojson")


def ids_of(building: Path) -> list[int]:
    return [room.id for room in floor_of(building)]


def correct(building: Path, *arguments: object) -> str:
    """What a correction prints."""
    code, out, err = run_pianta("correct", building, *arguments)
    assert (code, err) == (0, "")
    return out


def read_again(path: Path, building: Path, *arguments: object) -> list[str]:
    """What reading a map with the previous building prints at its end, from the corrections on."""
    code, out, err = run_pianta("read", path, "--previous", building, "-o", building, "--no-labels", *arguments)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    return lines[next(number for number, line in enumerate(lines) if " applied" in line) :]


class TestCorrect:
    def test_the_map_is_read_as_the_tests_expect(self, building):
        floor = floor_of(building)
        assert ids_of(building) == [*range(1, 12)]
        assert floor[8].polygon.bounds == pytest.approx((6.85, -5.85, 9.85, 0), abs=0.05)
        assert floor[2].polygon.bounds == pytest.approx((3.95, 2.40, 8.40, 8.25), abs=0.05)

    def test_corrections_are_made_in_their_order(self, building):
        out = correct(building, "--merge", 7, 6, "--name", 6, "Hall", "--split", 8, SPLIT_8, "--name", 12, "Store")
        assert out == f"11 rooms, 10 doors, 1 opening, {area_of(building):.1f} m², 4 corrections, in {building}\n"
        floor = floor_of(building)
        assert ids_of(building) == [1, 2, 3, 4, 5, 6, 8, 12, 9, 10, 11]
        assert [floor[room].name for room in (6, 8, 12)] == ["Hall", None, "Store"]
        assert floor[6].polygon.bounds == pytest.approx((0.15, -5.85, 6.7, 0), abs=0.05)
        assert [door.kind for door in floor.doors if {*door.rooms} == {8, 12}] == ["opening"]

    def test_all_files_are_made_again(self, building):
        before = list_files(building)
        correct(building, "--merge", 6, 7)
        after = list_files(building)
        changed = {name for name in before if before[name] != after[name]}
        assert changed == {"floor.geojson", "rooms.png", "graph.json", "picture.png"}
        assert after.keys() - before.keys() == {"corrections.json", "uncorrected.geojson"}
        assert after["uncorrected.geojson"] == before["floor.geojson"]
        with Image.open(building / "rooms.png") as image:
            assert set(np.unique(np.asarray(image))) == {0, *range(1, 12)} - {7}
        assert {node["id"] for node in json.loads(after["graph.json"])["nodes"]} == {*range(1, 12)} - {7}

    def test_a_name_is_of_the_room_at_that_moment(self, building):
        correct(building, "--name", 7, "West", "--merge", 6, 7, "--name", 6, "Both")
        assert floor_of(building)[6].name == "Both"
        code, out, err = run_pianta("correct", building, "--merge", 8, 9, "--name", 9, "Gone")
        assert (code, out) == (2, "")
        assert err == "error: --name '9' 'Gone': there is no room 9, the ids of the floor are 1 … 6, 8, 10, 11\n"
        assert len(read_corrections(building / "corrections.json")) == 3

    def test_a_number_is_beside_the_name_and_is_taken_back(self, building):
        out = correct(building, "--number", 2, "204", "--name", 2, "French", "--list")
        assert out.splitlines()[0].endswith("has the number '204'")
        assert (floor_of(building)[2].number, floor_of(building)[2].name) == ("204", "French")
        correct(building, "--undo", 2)
        assert floor_of(building)[2].title is None
        correct(building, "--number", 2, "204", "--number", 2, "")
        assert floor_of(building)[2].number is None

    def test_a_number_stays_when_the_map_is_read_again(self, folder, building):
        correct(building, "--number", 2, "204")
        assert run_pianta("read", folder / "map.yaml", "--previous", building, "-o", building).code == 0
        assert floor_of(building)[2].number == "204"

    def test_labels_are_found_in_any_case_and_taken_away(self, building):
        correct(building, "--label", 2, "kitchen")
        assert (floor_of(building)[2].label, floor_of(building)[2].labels) == ("KITCHEN", {})
        correct(building, "--label", 2, "")
        assert floor_of(building)[2].label is None

    def test_doors_are_drawn_moved_changed_and_deleted_at_negative_coordinates(self, building):
        correct(building, "--door", DOOR_6_7, "--to-opening", "3.22,-3")
        (door,) = [door for door in floor_of(building).doors if {*door.rooms} == {6, 7}]
        assert door.kind == "opening"
        assert door.width == pytest.approx(0.9)
        correct(building, "--move-door", "3.22,-3", "3.22,-5 3.22,-4.1", "--delete-door", "4.9,0")
        doors = [{*door.rooms} for door in floor_of(building).doors]
        assert ({6, 7} in doors, {5, 7} in doors) == (True, False)

    def test_a_room_is_drawn_and_deleted_at_negative_coordinates(self, building):
        correct(building, "--room", "-5,-5 -3,-5 -3,-3 -5,-3", "--name", 12, "Shed")
        assert floor_of(building)[12].polygon.area == pytest.approx(4)
        correct(building, "--delete", 12, "--outside", "-1,-7 4,-7 4,-3 -1,-3")
        assert ids_of(building) == [*range(1, 12)]
        assert floor_of(building)[6].polygon.bounds[1] == pytest.approx(-3)

    def test_the_scale_is_corrected_with_the_map(self, building):
        area = floor_of(building)[2].polygon.area
        before = read_map(building / "grid.npz")
        correct(building, "--area", 2, 4 * area, "--type", "school")
        floor, after = floor_of(building), read_map(building / "grid.npz")
        assert floor[2].polygon.area == pytest.approx(4 * area)
        assert after.resolution == pytest.approx(2 * before.resolution)
        assert after.origin[:2] == pytest.approx([2 * value for value in before.origin[:2]])
        assert floor.given_type == "school"
        correct(building, "--undo", 2)
        assert floor_of(building)[2].polygon.area == pytest.approx(area)
        assert read_map(building / "grid.npz").resolution == pytest.approx(before.resolution)


class TestUndo:
    def test_corrections_are_taken_back_from_the_last_one(self, building):
        before = floor_of(building)
        correct(building, "--name", 2, "Bar", "--label", 3, "KITCHEN", "--merge", 6, 7)
        out = correct(building, "--undo", 1)
        assert out.endswith(f"2 corrections, in {building}\n")
        assert ids_of(building) == [*range(1, 12)]
        correct(building, "--undo", 2)
        after = floor_of(building)
        assert (after[2].name, after[3].label) == (None, None)
        assert after == before

    def test_an_id_of_a_room_that_is_taken_back_is_not_used_again(self, building):
        correct(building, "--split", 8, SPLIT_8)
        correct(building, "--undo", 1, "--split", 2, "6,2.4 6,8.25")
        assert ids_of(building)[:3] == [1, 2, 13]

    def test_ids_stay_when_a_scale_is_taken_back(self, building):
        correct(building, "--split", 8, SPLIT_8, "--delete", 2)
        before = {room.id: room.polygon.centroid for room in floor_of(building)}
        correct(building, "--length", "0,0 5,0", 6.5)
        correct(building, "--undo", 1)
        after = {room.id: room.polygon.centroid for room in floor_of(building)}
        assert after.keys() == before.keys()
        assert all(after[room_id].distance(before[room_id]) < 0.01 for room_id in before)

    def test_more_than_there_are_is_refused(self, building):
        correct(building, "--name", 2, "Bar")
        refuse(building, ["--undo", 2], "--undo is 2 and the floor has 1 correction")


class TestList:
    def test_it_names_each_and_changes_nothing(self, building):
        correct(building, "--name", 2, "Bar", "--split", 8, SPLIT_8)
        before = list_files(building)
        assert correct(building, "--list").splitlines()[:2] == [
            "1. the room at (6.17, 5.38) has the name 'Bar'",
            "2. split the room along (6.85, -3.00) (9.85, -3.00)",
        ]
        assert list_files(building) == before

    def test_nothing_is_printed_if_quiet(self, building):
        assert correct(building, "--merge", 6, 7, "--quiet") == ""


def area_of(building: Path) -> float:
    return float(sum(room.polygon.area for room in floor_of(building)))


def refuse(building: Path, arguments: list[object], fragment: str) -> None:
    """A correction is refused in one line with exit code 2, and no file changes."""
    before = list_files(building)
    code, out, err = run_pianta("correct", building, *arguments)
    (line,) = err.splitlines()
    assert (code, out) == (2, "")
    assert line.startswith("error: ")
    assert fragment in line
    assert list_files(building) == before


class TestErrors:
    @pytest.mark.parametrize(
        ("arguments", "fragment"),
        [
            ([], "no correction is given, such as --merge 4 5"),
            (["3", "4"], "'3' belongs to no correction"),
            (["--mrge", "3", "4"], "there is no correction '--mrge', give one of --merge, --split"),
            (["--", "--", "--merge"], "there is no correction '--'"),
            (["--merge", "3"], "--merge '3' does not have the form --merge ID ID …"),
            (["--merge", "3", "3"], "one room alone cannot be merged"),
            (["--merge", "3", "x"], "'x' is no id, give that of a room"),
            (["--merge", "3", "99"], "there is no room 99, the ids of the floor are 1 … 11"),
            (["--merge", "1", "11"], "m apart, rooms to merge must be neighbours"),
            (["--name", "3"], "does not have the form --name ID TEXT"),
            (["--name", "3", "a", "b"], "does not have the form --name ID TEXT"),
            (["--number", "3"], "does not have the form --number ID TEXT"),
            (["--number", "3", "a\nb"], "with characters that cannot be printed"),
            (["--name", "3", "x" * 201], "give 1 to 200 characters"),
            (["--name", "3", "   "], "give 1 to 200 characters"),
            (["--name", "3", "a\x1b[31mb"], "with characters that cannot be printed"),
            (["--name", "3", "a\nb"], "with characters that cannot be printed"),
            (["--label", "3", "KITCHN"], "'KITCHN' is in no schema, give one such as KITCHEN"),
            (["--split", "8", "7,-3 8,-3"], "does not divide room 8, draw it from wall to wall"),
            (["--split", "8", "7,-3"], "'7,-3' are no 2 points or more"),
            (["--split", "8", "7,-3 7;-4"], "are no 2 points or more"),
            (["--split", "8", "nan,-3 9,-3"], "is no position, give metres"),
            (["--door", "inf,1 2,3"], "is no position, give metres"),
            (["--door", "1e9,1 2,3"], "is no position, give metres"),
            (["--door", "8,-2 8,-3"], "room 8 is on both sides"),
            (["--delete-door", "-5,-2"], "no door is within 0.9 m of (-5.00, -2.00)"),
            (["--delete-door", "1,2 3,4"], "is more than one point"),
            (["--room", "0,0 1,1 1,0 0,1"], "crosses itself or has no area"),
            (["--area", "2", "0"], "is no size, give a positive number"),
            (["--area", "2", "nan"], "is no size, give a positive number"),
            (["--length", "0,0 4,0", "4 m"], "'4 m' is no number"),
            (["--type", "x" * 201], "building_type"),
            (["--outside", "9" * 5000], "is no id, give that of a room"),
            (["--delete", "3", "--merge", "3", "4"], "--merge '3' '4': there is no room 3"),
            (["--label", "3", "", "--list"], "--label '3' '' changes nothing, leave it out"),
        ],
    )
    def test_they_are_one_line_and_change_no_file(self, building, arguments, fragment):
        refuse(building, arguments, fragment)

    def test_what_follows_a_good_correction_undoes_it(self, building):
        refuse(building, ["--merge", 6, 7, "--name", 99, "x"], "there is no room 99")

    def test_the_folder_is_first(self, building):
        code, out, err = run_pianta("correct", "--merge", 6, 7, building)
        assert (code, out) == (2, "")
        assert err == "error: the folder is '--merge', give the folder first and then the corrections\n"

    def test_another_folder_is_refused(self, folder):
        code, out, err = run_pianta("correct", folder, "--merge", 6, 7)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert "has no floor.geojson, give a folder of `pianta read`" in err

    @pytest.mark.parametrize("content", ["", "{", "[]", '{"format": "pianta corrections", "version": "2.0"}'])
    def test_damaged_corrections_are_refused_and_stay(self, building, folder, content):
        correct(building, "--merge", 6, 7)
        (building / "corrections.json").write_text(content, encoding="utf-8")
        refuse(building, ["--name", 2, "x"], "corrections.json'")
        before = list_files(building)
        for previous in ([], ["--previous", building]):
            code, _, err = run_pianta("read", folder / "map.yaml", *previous, "-o", building)
            assert (code, err.count("\n"), "corrections.json'" in err) == (2, 1, True)
            assert list_files(building) == before

    def test_a_lost_uncorrected_floor_is_named(self, building):
        correct(building, "--merge", 6, 7)
        (building / "uncorrected.geojson").unlink()
        refuse(building, ["--name", 2, "x"], "uncorrected.geojson' does not exist")

    def test_a_folder_of_an_older_pianta_is_refused_with_the_remedy(self, building):
        (building / "grid.npz").unlink()
        refuse(building, ["--name", 2, "x"], "has no grid.npz, read the map again with this pianta")
        assert run_pianta("correct", building, "--list").code == 0


class TestFoldersThatChange:
    """Files that are of another building, that are no files, and folders that others write at the same time."""

    def test_a_floor_of_another_building_is_not_taken_as_the_uncorrected_one(self, building):
        correct(building, "--merge", 6, 7)
        make_hall_floor(seed=4).save(building / "uncorrected.geojson")
        refuse(building, ["--undo", 1], "floor.geojson is not uncorrected.geojson with the corrections of")

    def test_a_map_of_another_building_is_refused(self, building, grid):
        GridMap(grid.cells, grid.resolution, (1000.0, 0.0, 0.0)).save(building / "grid.npz")
        refuse(building, ["--merge", 6, 7], "no room of floor.geojson is on the map grid.npz")

    def test_a_link_that_leads_nowhere_is_refused(self, building):
        correct(building, "--merge", 6, 7)
        (building / "corrections.json").unlink()
        (building / "corrections.json").symlink_to(building / "gone.json")
        refuse(building, ["--name", 2, "x"], "corrections.json' does not exist")

    @pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no pipes")
    def test_a_pipe_is_not_waited_for(self, building):
        os.mkfifo(building / "paper.png")
        refuse(building, ["--name", 2, "x"], "paper.png' is no regular file")

    def test_two_at_the_same_time_are_both_made(self, building):
        command = [sys.executable, "-m", "pianta", "correct", building, "--quiet"]
        both = [subprocess.Popen([*command, "--name", str(room), name]) for room, name in ((2, "A"), (3, "B"))]
        assert [each.wait(120) for each in both] == [0, 0]
        floor = floor_of(building)
        assert (floor[2].name, floor[3].name) == ("A", "B")

    @pytest.fixture
    def foreground(self) -> Iterator[None]:
        """SIGINT as a program in the foreground has it; a shell ignores it for one in the background."""
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        yield
        signal.signal(signal.SIGINT, before)

    @pytest.mark.usefixtures("foreground")
    def test_ctrl_c_between_two_files_of_a_save_comes_after_the_last_one(self, building, monkeypatch):
        replace_file = Path.replace

        def interrupt(file: Path, target: Path) -> Path:
            if target.parent == building:
                signal.raise_signal(signal.SIGINT)
            return replace_file(file, target)

        monkeypatch.setattr(Path, "replace", interrupt)
        reading = SavedReading.open(building)
        with pytest.raises(KeyboardInterrupt):
            reading.add(NameRoom((6.17, 5.38), "x")).save()
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
        assert floor_of(building)[2].name == "x"
        assert len(read_corrections(building / "corrections.json")) == 1
        assert not [*building.glob(".pianta-*")]


@pytest.mark.parametrize(
    "name", ["<img src=x onerror=alert(1)>", "'; rm -rf /", "[red]x[/red]", "-2 % Küche 室", "ab\\n"]
)
def test_names_are_text(building, name):
    correct(building, "--name", 2, name)
    assert floor_of(building)[2].name == name
    (correction,) = read_corrections(building / "corrections.json")
    assert getattr(correction, "name", None) == name
    assert repr(name) in correct(building, "--list")


class TestReadAgain:
    def test_the_same_map_keeps_everything(self, folder, building):
        correct(building, "--merge", 6, 7, "--split", 8, SPLIT_8, "--name", 12, "Store", "--label", 3, "KITCHEN")
        correct(building, "--door", "3.88,5 3.88,5.9", "--delete", 11, "--type", "school")
        before, files = floor_of(building), list_files(building)
        assert read_again(folder / "map.yaml", building)[:2] == [
            "7 of 7 corrections applied",
            "10 rooms kept their ids, 0 are new, 0 are gone",
        ]
        assert floor_of(building) == before
        # What pianta has computed from coordinates in memory differs from the rounded ones of the file
        assert {name: content for name, content in list_files(building).items() if name != "graph.json"} == {
            name: content for name, content in files.items() if name != "graph.json"
        }
        correct(building, "--undo", 7)
        assert replace(floor_of(building), last_id=11) == read_floor(building / "uncorrected.geojson")

    def test_a_label_that_was_changed_in_the_file_stays_too(self, folder, building):
        correct(building, "--name", 2, "Bar")
        floor = floor_of(building)
        rooms = tuple(replace(room, label="LAB") if room.id == 3 else room for room in floor)
        replace(floor, rooms=rooms).save(building / "floor.geojson")
        read_again(folder / "map.yaml", building)
        assert (floor_of(building)[3].label, floor_of(building)[2].name) == ("LAB", "Bar")

    def test_a_map_that_is_turned_keeps_ids_and_corrections(self, folder, building, grid):
        correct(building, "--merge", 6, 7, "--split", 8, SPLIT_8, "--name", 12, "Store", "--door", "3.88,5 3.88,5.9")
        before = floor_of(building)
        view_turned(grid, 15).grid.save(folder / "turned.yaml")
        assert read_again(folder / "turned.yaml", building)[:2] == [
            "4 of 4 corrections applied",
            "11 rooms kept their ids, 0 are new, 0 are gone",
        ]
        after = floor_of(building)
        assert [after[room.id].polygon.area for room in before] == pytest.approx(
            [room.polygon.area for room in before], rel=0.06
        )
        assert [room.id for room in after if room.name == "Store"] == [12]
        assert {frozenset(door.rooms) for door in after.doors} == {frozenset(door.rooms) for door in before.doors}
        # And back again
        read_again(folder / "map.yaml", building)
        assert {room.id: room.name for room in floor_of(building)} == {room.id: room.name for room in before}

    @pytest.mark.parametrize("change", ["grown", "double"])
    def test_a_map_that_has_grown_or_is_finer_keeps_corrections(self, folder, building, grid, change):
        correct(building, "--merge", 6, 7, "--split", 8, SPLIT_8, "--name", 12, "Store")
        before = {room.id: room.name for room in floor_of(building)}
        padded = np.pad(grid.cells, ((30, 75), (110, 12)), constant_values=UNKNOWN)
        changed = view_doubled(grid).grid if change == "double" else GridMap(padded, grid.resolution)
        changed.save(folder / "changed.yaml")
        assert read_again(folder / "changed.yaml", building)[0] == "3 of 3 corrections applied"
        assert {room.id: room.name for room in floor_of(building)} == before

    def test_corrections_after_one_of_the_scale_are_in_the_new_metres(self, folder, building):
        area = floor_of(building)[2].polygon.area
        correct(building, "--area", 2, 4 * area, "--name", 11, "Store", "--merge", 6, 7)
        before = floor_of(building)
        read_again(folder / "map.yaml", building)
        assert floor_of(building) == before

    def test_corrections_that_no_longer_fit_are_named_and_stay(self, folder, building, grid):
        # The west of the building up to x = 3.2 is no longer on the map
        correct(building, "--name", 6, "Store", "--name", 11, "Lab")
        cells = grid.cells.copy()
        _, cols = (int(value) for value in grid.map_to_pixel(3.2, 0.0))
        cells[:, :cols] = UNKNOWN
        GridMap(cells, grid.resolution, grid.origin).save(folder / "less.yaml")
        lines = read_again(folder / "less.yaml", building)
        assert lines[0] == "1 of 2 corrections applied"
        named = "correction 1, the room at (1.65, -2.98) has the name 'Store', no longer fits: there is no room"
        assert lines[1].startswith(named)
        assert [room.name for room in floor_of(building) if room.name] == ["Lab"]
        assert "(does not fit: there is no room at" in correct(building, "--list").splitlines()[0]
        assert read_again(folder / "map.yaml", building)[0] == "2 of 2 corrections applied"
        # The id of a room that was gone is not used again
        (store,) = [room for room in floor_of(building) if room.name == "Store"]
        assert store.id > 11
        assert store.polygon.bounds == pytest.approx((0.15, -5.85, 3.15, 0), abs=0.05)

    def test_a_map_of_another_building_is_refused(self, folder, building):
        correct(building, "--merge", 6, 7)
        simulate_map(make_hall_floor(seed=4)).save(folder / "other.yaml")
        before = list_files(building)
        code, out, err = run_pianta("read", folder / "other.yaml", "--previous", building, "-o", building)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert "other.yaml': the previous floor is of another building: " in err
        assert list_files(building) == before


class TestLabels:
    """Labels of rooms, which this reading has."""

    @pytest.fixture
    def labelled(self, folder: Path) -> Path:
        assert run_pianta("read", folder / "map.yaml", "-o", folder / "labelled", "-q").code == 0
        return folder / "labelled"

    def read_labels(self, folder: Path, labelled: Path) -> None:
        arguments = "--previous", labelled, "-o", labelled, "-q"
        assert run_pianta("read", folder / "map.yaml", *arguments) == (0, "", "")

    def test_rooms_get_labels_of_a_type_that_is_given(self, folder, labelled):
        before = floor_of(labelled)
        correct(labelled, "--label", 3, "LAB", "--label", 4, "", "--type", "school")
        after = floor_of(labelled)
        assert after.building_type == {"school": 1.0}
        # The corridor, and all rooms but those that people have labelled
        assert [room.label for room in after if room.id in (3, 4, 5)] == ["LAB", None, "CORRIDOR"]
        assert all("school" in room.labels for room in after if room.id not in (3, 4))
        self.read_labels(folder, labelled)
        assert floor_of(labelled) == after
        correct(labelled, "--undo", 3)
        assert replace(floor_of(labelled), last_id=before.last_id) == before

    def test_a_label_and_a_type_that_were_taken_away_stay_away(self, folder, labelled):
        assert floor_of(labelled)[4].label is not None
        correct(labelled, "--label", 4, "", "--label", 3, "", "--label", 3, "LAB", "--type", "")
        for area in (None, 300):
            if area:
                # All lengths are larger after this one, and the positions of the others are as they were
                correct(labelled, "--area", 2, area)
            self.read_labels(folder, labelled)
            after = floor_of(labelled)
            assert (after[4].label, after[3].label, after.building_type) == (None, "LAB", {})
            assert after[2].label is not None

    def test_a_door_that_is_not_found_any_more_is_deleted(self, folder, labelled, grid):
        (door,) = [door for door in floor_of(labelled).doors if {*door.rooms} == {5, 7}]
        x, y = door.line.interpolate(0.5, normalized=True).coords[0]
        correct(labelled, "--delete-door", f"{x},{y}")
        # A wall fills the doorway, from jamb to jamb
        cells = grid.cells.copy()
        row, col = (int(value) for value in grid.map_to_pixel(x, y))
        cells[row - 4 : row + 5, col - 14 : col + 15] = OCCUPIED
        GridMap(cells, grid.resolution, grid.origin).save(folder / "map.yaml")
        code, out, err = run_pianta("read", folder / "map.yaml", "--previous", labelled, "-o", labelled)
        assert (code, err) == (0, "")
        assert "1 of 1 correction applied" in out.splitlines()
        code, _, err = run_pianta("correct", labelled, "--delete-door", f"{x},{y}")
        assert (code, err.startswith(f"error: --delete-door '{x},{y}': no door is within 0.9 m of")) == (2, True)


class TestWithoutPrevious:
    def list_readings(self, folder: Path) -> Iterator[list[object]]:
        yield ["read", folder / "map.yaml", "-o", folder / "building"]
        yield ["read", folder / "map.yaml", "--previous", folder / "elsewhere", "-o", folder / "building"]

    def test_corrections_are_not_lost(self, folder, building):
        copytree(building, folder / "elsewhere")
        correct(building, "--merge", 6, 7, "--name", 2, "Bar")
        before = list_files(building)
        for arguments in self.list_readings(folder):
            code, out, err = run_pianta(*arguments)
            assert (code, out) == (2, "")
            assert err == (
                f"error: folder {str(building)!r} has 2 corrections, which would be lost; give it as --previous and "
                "they are applied again, or give another output folder\n"
            )
            assert list_files(building) == before

    def test_neither_are_those_that_are_made_while_the_map_is_read(self, folder, building):
        correct(building, "--merge", 6, 7)
        reading = pianta.read(folder / "map.yaml", previous=building, labels=False)
        correct(building, "--name", 2, "Bar")
        before = list_files(building)
        with pytest.raises(OptionError, match="have changed since they were read, nothing was written"):
            reading.save(building)
        assert list_files(building) == before

    def test_those_of_a_folder_of_several_are_applied_again(self, folder):
        (folder / "second.yaml").write_bytes((folder / "map.yaml").read_bytes())
        files = folder / "map.yaml", folder / "second.yaml"
        assert run_pianta("read", *files, "-o", folder / "out", "--no-labels", "-q").code == 0
        correct(folder / "out" / "map", "--merge", 6, 7)
        corrected = ids_of(folder / "out" / "map")
        assert run_pianta("read", *files, "-o", folder / "out", "--no-labels", "--no-resume", "-q").code == 0
        assert ids_of(folder / "out" / "map") == corrected
        assert len(ids_of(folder / "out" / "second")) == len(ids_of(folder / "out" / "map")) + 1
        assert len(read_corrections(folder / "out" / "map" / "corrections.json")) == 1

    def test_a_folder_whose_corrections_were_taken_back_is_free(self, folder, building):
        correct(building, "--merge", 6, 7)
        correct(building, "--undo", 1)
        assert run_pianta("read", folder / "map.yaml", "-o", building, "--no-labels", "-q") == (0, "", "")
        correct(building, "--merge", 6, 7)
        assert ids_of(building) == [*range(1, 7), *range(8, 12)]
