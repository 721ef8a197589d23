"""Batches: folders of maps, a journal of what is done, processes that may die, parts for several machines, tables."""

import errno
import gc
import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
import weakref
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress
from functools import partial
from pathlib import Path
from shutil import copytree, rmtree

import numpy as np
import psutil
import pytest
from PIL import Image

import pianta
from pianta.batch import geoparquet, processes
from pianta.batch.generate_batch import PLAN_SHEET, SHEET, list_plan_files
from pianta.batch.inputs import RESULT_NAME, SUFFIXES, expand_patterns, list_inputs
from pianta.batch.journal import BEGUN, Entry, Journal, _as_option_error, read_journals
from pianta.batch.predict_batch import EXPLORED, PICTURE, PLAN_FILES
from pianta.batch.processes import Fault, run_items, work_in_worker
from pianta.batch.read_batch import _identify, _is_complete
from pianta.batch.run_batch import WorkItem, digest_options
from pianta.building import Building, Storey
from pianta.cli.batches import ending_by_signal
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import FREE, OCCUPIED, GridMap
from pianta.io._folders import atomic_folder
from pianta.io.building_folders import save_building_file
from pianta.reading._reader import Reader
from pianta.reading.reading import OPTIONAL, OUTPUTS, Reading, list_input_files
from pianta.rooms import name_dictionary
from tests.command_line import list_files, run_pianta


def make_map(rooms: int = 2) -> GridMap:
    """Rooms of 4 × 4 m side by side, with doors of 1 m between them."""
    cells = np.full((84, 4 + 80 * rooms), OCCUPIED, np.int8)
    for room in range(rooms):
        cells[4:80, 4 + 80 * room : 80 + 80 * room] = FREE
        if room:
            cells[30:50, 80 * room - 1 : 80 * room + 5] = FREE
    return GridMap(cells, 0.05)


@pytest.fixture
def maps(tmp_path: Path) -> Path:
    """A folder with three maps and one that is broken."""
    folder = tmp_path / "maps"
    for name in ("a", "b", "c"):
        (folder / name).mkdir(parents=True)
        make_map().save(folder / name / f"{name}.yaml")
    (folder / "broken.npz").write_text("no archive")
    return folder


def read(maps: Path, out: Path, **options) -> dict[str, pianta.BatchItem]:
    items = [*pianta.read_batch([maps], out=out, labels=False, **options)]
    assert len({item.path for item in items}) == len(items)
    return {item.path.stem: item for item in items}


def count_rooms(reading: Reading) -> int:
    return len(reading.floor)


def list_new(items: dict[str, pianta.BatchItem]) -> set[str]:
    return {name for name, item in items.items() if item.is_new}


class TestInputs:
    def test_a_folder_stands_for_its_maps_and_plans(self, maps):
        (maps / "notes.txt").write_text("no map")
        (maps / "settings.yaml").write_text("speed: 1\n")
        (maps / ".hidden.npz").write_text("hidden")
        (maps / "a" / "plan.pdf").write_text("a plan")
        results = maps / "results"
        results.mkdir()
        (results / "floor.geojson").write_text("{}")
        (results / "picture.png").write_text("")
        names = [str(path.relative_to(maps)) for path in list_inputs([maps])]
        assert names == ["broken.npz", "a/a.yaml", "a/plan.pdf", "b/b.yaml", "c/c.yaml"]

    def test_a_pattern_stands_for_what_matches(self, maps):
        assert [path.name for path in list_inputs([f"{maps}/**/[ab].yaml", maps / "a" / "a.yaml"])] == [
            "a.yaml",
            "b.yaml",
        ]

    def test_what_belongs_to_a_batch_is_no_input(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        (tmp_path / "out" / "faults").mkdir()
        assert {path.name for path in expand_patterns([f"{tmp_path}/out/*"])} == {"a", "b", "c"}

    @pytest.mark.parametrize("name", ["floor.geojson", "prediction.json", "building-0001.graphml"])
    def test_results_are_no_inputs(self, maps, name):
        Image.new("L", (9, 9)).save(maps / "a" / "picture.png")
        assert maps / "a" / "picture.png" in list_inputs([maps])
        (maps / "a" / name).write_text("")
        (maps / "a" / "inner").mkdir()
        make_map().save(maps / "a" / "inner" / "x.npz")
        # Maps and plans beside their results do not belong to them
        assert [path.name for path in list_inputs([maps])] == ["broken.npz", "a.yaml", "x.npz", "b.yaml", "c.yaml"]
        assert [path.name for path in list_inputs([f"{maps}/**/*.png"])] == ["a.png", "b.png", "c.png"]

    def test_results_that_could_be_inputs_are_known(self):
        written = {*OUTPUTS, *OPTIONAL, PICTURE, *EXPLORED, *PLAN_FILES, SHEET, PLAN_SHEET}
        written |= {*list_plan_files(["building-001", "building-000001"])}
        similar = {name for name in written if Path(name).suffix in SUFFIXES}
        assert {name for name in similar if not RESULT_NAME.fullmatch(name)} == set()
        assert len(similar) == 11

    @pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes")
    def test_a_pipe_is_not_waited_for(self, maps):
        os.mkfifo(maps / "pipe.yaml")
        assert "pipe.yaml" in [path.name for path in list_inputs([maps])]

    def test_files_in_a_folder_that_is_read_are_inputs(self, tmp_path):
        (tmp_path / "bag").mkdir()
        for name in ("metadata.yaml", "0.db3"):
            (tmp_path / "bag" / name).write_text(name)
        names = [str(file.relative_to(tmp_path)) for file in list_input_files(tmp_path / "bag")]
        assert names == ["bag", "bag/0.db3", "bag/metadata.yaml"]

    def test_folders_behind_links_are_listed_once(self, maps, tmp_path):
        (tmp_path / "elsewhere").mkdir()
        make_map().save(tmp_path / "elsewhere" / "x.npz")
        (maps / "link").symlink_to(tmp_path / "elsewhere")
        (maps / "same").symlink_to(maps / "a")
        (maps / "a" / "circle").symlink_to(maps)
        assert [path.name for path in list_inputs([maps])] == ["broken.npz", "a.yaml", "b.yaml", "c.yaml", "x.npz"]

    def test_an_image_may_be_in_another_folder_than_its_map(self, maps):
        (maps / "a" / "images").mkdir()
        (maps / "a" / "a.png").rename(maps / "a" / "images" / "a.png")
        yaml = (maps / "a" / "a.yaml").read_text()
        (maps / "a" / "a.yaml").write_text(yaml.replace("a.png", "images/a.png"))
        assert [path.name for path in list_inputs([maps])] == ["broken.npz", "a.yaml", "b.yaml", "c.yaml"]

    def test_the_path_without_links_names_a_file(self, maps):
        (maps / "0-current").symlink_to("a")
        assert maps / "a" / "a.yaml" in list_inputs([maps])

    def test_results_without_their_floor_are_no_inputs(self, maps):
        read(maps, maps / "out")
        (maps / "out" / "a" / "floor.geojson").unlink()
        assert list_new(read(maps, maps / "out")) == {"a", "broken"}

    def test_results_that_match_a_pattern_of_the_shell_are_passed_over(self, maps):
        for _ in range(2):
            listed = [maps / "a", maps / "b"] + [maps / "out"] * (maps / "out").exists()
            assert [item.fault for item in pianta.read_batch(listed, out=maps / "out", labels=False)] == [None, None]
        with pytest.raises(OptionError, match=r"folder '.*out' has no map or plan"):
            list_inputs([maps / "out"])

    @pytest.mark.parametrize("path", [b"x", 3, None, "", "\0", "\ud800"])
    def test_what_is_no_path_is_an_error(self, path):
        with pytest.raises(OptionError, match=r"paths= has .*, (which no file can be called|give paths as texts)$"):
            list_inputs([path])

    def test_a_folder_that_cannot_be_listed_is_an_error(self, maps, monkeypatch):
        scandir = os.scandir

        def refuse(path: str) -> Iterator[os.DirEntry[str]]:
            """For root, who may list every folder."""
            if Path(path).name == "a":
                raise PermissionError(13, "Permission denied", path)
            return scandir(path)

        monkeypatch.setattr(os, "scandir", refuse)
        with pytest.raises(OptionError, match=r"folder '.*a' cannot be listed: Permission denied"):
            list_inputs([maps])

    def test_a_name_with_brackets_is_no_pattern_if_it_exists(self, tmp_path):
        file = tmp_path / "map[1].npz"
        make_map().save(file)
        assert list_inputs([file]) == [file]

    def test_nothing_to_read_is_an_error(self, tmp_path):
        with pytest.raises(OptionError, match=r"nothing matches '.*\*\.yaml', check the pattern"):
            list_inputs([f"{tmp_path}/*.yaml"])
        with pytest.raises(OptionError, match=r"has no map or plan, give one with a map\.yaml"):
            list_inputs([tmp_path])

    def test_folders_without_maps_that_a_pattern_matches_are_passed_over(self, maps):
        (maps / "empty").mkdir()
        assert [path.name for path in list_inputs([f"{maps}/*"])] == ["a.yaml", "b.yaml", "broken.npz", "c.yaml"]
        with pytest.raises(OptionError, match="has no map or plan"):
            list_inputs([f"{maps}/e*"])

    @pytest.mark.parametrize("line", ["image: a.png", "'image': \"a.png\"  # the map", "image:a.png"])
    def test_the_image_of_a_faulty_map_is_no_input(self, maps, line):
        (maps / "a" / "a.yaml").write_text(f"resolution: none\n{line}\n")
        make_map().save(maps / "a" / "b.yaml")
        names = {path.name for path in list_inputs([maps / "a"])}
        assert names == {"a.yaml", "b.yaml"}


class TestResume:
    def test_what_was_read_is_not_read_again(self, maps, tmp_path):
        first = read(maps, tmp_path / "out")
        assert list_new(first) == {"a", "b", "c", "broken"}
        assert first["broken"].group == "map"
        assert "broken.npz' is no NumPy archive" in (first["broken"].fault or "")
        before = list_files(tmp_path / "out" / "a")
        second = read(maps, tmp_path / "out")
        assert list_new(second) == {"broken"}
        assert second["a"].fault is None
        assert list_files(tmp_path / "out" / "a") == before
        assert before.keys() == set(OUTPUTS)

    def test_a_dictionary_that_has_changed_is_another_option_also_as_a_text(self, maps, tmp_path):
        words = tmp_path / "words.json"
        words.write_bytes(Path(name_dictionary.__file__).with_suffix(".json").read_bytes())

        def is_new() -> bool:
            (item,) = pianta.read_batch([maps / "a" / "a.yaml"], out=tmp_path / "out", words=str(words))
            assert item.fault is None
            return item.is_new

        assert [is_new(), is_new()] == [True, False]
        words.write_bytes(words.read_bytes() + b"\n")
        assert is_new()

    def test_what_has_changed_is_read_again(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        make_map(3).save(maps / "b" / "b.yaml")
        (tmp_path / "out" / "c" / "floor.geojson").unlink()
        for file in (tmp_path / "out" / "c").iterdir():
            file.unlink()
        (tmp_path / "out" / "c").rmdir()
        assert list_new(read(maps, tmp_path / "out")) == {"b", "c", "broken"}
        assert len(pianta.read_floor(tmp_path / "out" / "b" / "floor.geojson")) == 3

    def test_other_options_and_versions_and_no_resume_read_all_again(self, maps, tmp_path, monkeypatch):
        read(maps, tmp_path / "out")
        everything = {"a", "b", "c", "broken"}
        assert list_new(read(maps, tmp_path / "out", walls=True)) == everything
        assert list_new(read(maps, tmp_path / "out", walls=True, resume=False)) == everything
        monkeypatch.setattr("pianta.batch.run_batch.__version__", "99")
        assert list_new(read(maps, tmp_path / "out", walls=True)) == everything

    @pytest.mark.parametrize("jobs", [1, 2])
    def test_results_that_were_replaced_without_an_entry_are_not_taken_for_the_old_ones(
        self, maps, tmp_path, monkeypatch, jobs
    ):
        """The program ends between the results and the entry of a map that is read with other options."""
        (maps / "broken.npz").unlink()
        read(maps, tmp_path / "out")
        before = {name: list_files(tmp_path / "out" / name) for name in ("a", "b", "c")}

        def stop(*_: object) -> None:
            raise KeyboardInterrupt

        with monkeypatch.context() as patched:
            patched.setattr(Journal, "record", stop)
            with pytest.raises(KeyboardInterrupt):
                read(maps, tmp_path / "out", graph=True, jobs=jobs)
        assert list_new(read(maps, tmp_path / "out"))
        assert list_new(read(maps, tmp_path / "out")) == set()
        for name in ("a", "b", "c"):
            assert list_files(tmp_path / "out" / name) == before[name]

    def test_options_that_are_left_out_have_their_usual_values(self, maps, tmp_path):
        """What was read without labels is read again with them."""
        read(maps, tmp_path / "out")
        assert list_new(read(maps, tmp_path / "out", method="structure", predict_partial=True)) == {"broken"}
        assert all(item.is_new for item in pianta.read_batch([maps], out=tmp_path / "out"))

    def test_only_failed_reads_no_new_files(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        make_map().save(maps / "broken.npz")
        make_map().save(maps / "new.npz")
        mended = read(maps, tmp_path / "out", only_failed=True)
        assert list_new(mended) == {"broken"}
        assert mended["broken"].fault is None

    def test_only_failed_does_not_mix_batches(self, maps, tmp_path):
        with pytest.raises(OptionError, match="has no journal yet, so nothing has failed; leave out only_failed="):
            read(maps, tmp_path / "out", only_failed=True)
        assert not (tmp_path / "out").exists()
        read(maps, tmp_path / "out")
        with pytest.raises(OptionError, match="has results with other options or of another version; give the same"):
            read(maps, tmp_path / "out", only_failed=True, walls=True)
        assert list_new(read(maps, tmp_path / "out", only_failed=True)) == {"broken"}

    def test_a_file_keeps_its_folder_when_names_repeat_later(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        (maps / "d").mkdir()
        make_map().save(maps / "d" / "a.yaml")
        items = [*pianta.read_batch([maps], out=tmp_path / "out", labels=False)]
        assert {(item.path.parent.name, item.folder.name) for item in items if item.path.stem == "a"} == {
            ("a", "a"),
            ("d", "d-a"),
        }

    def test_what_lacks_a_description_is_read_again(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        assert list_new(read(maps, tmp_path / "out", describe=count_rooms)) == {"a", "b", "c", "broken"}
        items = read(maps, tmp_path / "out", describe=count_rooms)
        assert [items[name].description for name in ("a", "b", "c", "broken")] == [2, 2, 2, None]
        assert list_new(items) == {"broken"}

    @pytest.mark.parametrize("damage", ["other", '"other"', '{"by": "someone"}', "null"])
    def test_descriptions_of_others_are_made_anew(self, maps, tmp_path, damage):
        (maps / "broken.npz").unlink()
        read(maps, tmp_path / "out", describe=lambda _: "theirs")
        with closing(sqlite3.connect(tmp_path / "out" / "journal.sqlite")) as journal, journal:
            journal.execute("update entries set description = ? where folder = 'a'", [damage])
        assert list_new(read(maps, tmp_path / "out")) == set()
        items = read(maps, tmp_path / "out", describe=count_rooms)
        assert {name: item.description for name, item in items.items()} == {"a": 2, "b": 2, "c": 2}
        assert list_new(items) == {"a", "b", "c"}

    def test_no_resume_forgets_files_that_are_gone(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        (tmp_path / "new").mkdir()
        moved = maps.rename(tmp_path / "new" / "maps")
        assert list_new(read(moved, tmp_path / "out")) == {"a", "b", "c", "broken"}
        assert len(read_journals(tmp_path / "out")) == 8
        read(moved, tmp_path / "out", resume=False)
        assert [Path(entry.path).is_relative_to(moved) for entry in read_journals(tmp_path / "out")] == [True] * 4

    def test_equal_sizes_and_times_do_not_make_two_maps_one(self, tmp_path):
        maps = tmp_path / "maps"
        for name, rooms in (("one", 2), ("two", 3)):
            (maps / name).mkdir(parents=True)
            make_map(rooms).save(maps / name / "map.npz")
            content = (maps / name / "map.npz").read_bytes()
            (maps / name / "map.npz").write_bytes(content + bytes(4000 - len(content)))
            os.utime(maps / name / "map.npz", (1, 1))
        [*pianta.read_batch([maps], out=tmp_path / "out", labels=False)]
        (maps / "one").rename(maps / "old")
        (maps / "two").rename(maps / "one")
        items = pianta.read_batch([maps], out=tmp_path / "out", labels=False, describe=count_rooms)
        assert {item.path.parent.name: item.description for item in items} == {"old": 2, "one": 3}

    def test_a_missing_or_empty_result_is_read_again(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        (tmp_path / "out" / "b" / "rooms.png").unlink()
        (tmp_path / "out" / "c" / "floor.geojson").write_bytes(b"")
        assert list_new(read(maps, tmp_path / "out")) == {"b", "c", "broken"}
        assert list_new(read(maps, tmp_path / "out")) == {"broken"}

    def test_a_missing_storey_is_read_again(self, tmp_path):
        item = WorkItem("", tmp_path, (), "", tmp_path, "", None)
        for name in ("ground", "first"):
            (tmp_path / name).mkdir()
            for file in OUTPUTS:
                (tmp_path / name / file).write_text("{}")
        floor = Floor(())
        save_building_file(Building((Storey(floor, "ground"), Storey(floor, "first"))), tmp_path / "building.json")
        assert _is_complete(item)
        (tmp_path / "first" / "grid.npz").unlink()
        assert not _is_complete(item)
        (tmp_path / "building.json").write_text("{")
        assert not _is_complete(item)

    def test_results_that_the_journal_does_not_know_are_not_replaced(self, maps, tmp_path):
        make_map(3).save(tmp_path / "other.npz")
        pianta.read(tmp_path / "other.npz", labels=False).save(tmp_path / "out" / "b")
        before = (tmp_path / "out" / "b" / "floor.geojson").read_bytes()
        with pytest.raises(OptionError, match=r"folder '.*b' has results that .* not know; move .* resume=False and"):
            read(maps, tmp_path / "out")
        assert (tmp_path / "out" / "b" / "floor.geojson").read_bytes() == before
        assert [path.name for path in (tmp_path / "out").iterdir()] == ["b"]
        assert list_new(read(maps, tmp_path / "out", resume=False)) == {"a", "b", "c", "broken"}
        assert list_new(read(maps, tmp_path / "out")) == {"broken"}

    def test_corrections_are_not_given_to_another_file_after_the_journal_was_removed(self, maps, tmp_path):
        """Two files of one name change places in the list."""
        (maps / "d").mkdir()
        make_map(3).save(maps / "d" / "a.yaml")
        first, second = maps / "a" / "a.yaml", maps / "d" / "a.yaml"
        [*pianta.read_batch([first], out=tmp_path / "out", labels=False)]
        floor = tmp_path / "out" / "a" / "floor.geojson"
        assert run_pianta("correct", floor.parent, "--name", 1, "Aula").code == 0
        (tmp_path / "out" / "journal.sqlite").unlink()
        before = floor.read_bytes()
        for resume in (True, False):
            with pytest.raises(OptionError, match="has corrections of a floor that the journal does not know; move"):
                [*pianta.read_batch([second], out=tmp_path / "out", labels=False, resume=resume)]
        assert floor.read_bytes() == before

    def test_a_batch_that_is_refused_forgets_nothing(self, maps, tmp_path):
        """Corrected maps are on a disk that is not mounted, and another one has their name."""
        read(maps, tmp_path / "out")
        assert run_pianta("correct", tmp_path / "out" / "a", "--name", 1, "Aula").code == 0
        away = (maps / "a").rename(tmp_path / "away")
        (maps / "other").mkdir()
        make_map(3).save(maps / "other" / "a.yaml")
        items = read(maps, tmp_path / "out", resume=False)
        assert (items["a"].folder.name, items["a"].fault) == ("a-2", None)
        away.rename(maps / "a")
        assert {item.folder.name for item in pianta.read_batch([maps], out=tmp_path / "out", labels=False)} == {
            *("a", "a-2", "b", "c", "broken"),
        }

    def test_what_a_killed_batch_has_only_entered_is_done_once(self, maps, tmp_path):
        """Killed before the first result, with another folder for one of the maps."""
        (tmp_path / "out").mkdir()
        (maps / "broken.npz").unlink()
        with Journal(tmp_path / "out" / "journal.sqlite") as journal:
            journal.begin({str(maps / name / f"{name}.yaml"): f"{name}-2" for name in ("a", "b", "c")})
            journal.begin({str(tmp_path / "gone.yaml"): "a"})
        assert {item.folder.name for item in read(maps, tmp_path / "out").values()} == {"a", "b", "c"}
        assert list_new(read(maps, tmp_path / "out")) == set()

    def test_what_was_not_begun_is_not_done_again(self, maps, tmp_path, monkeypatch):
        """Ctrl+C in the first map of a batch with another option, given by mistake."""
        (maps / "broken.npz").unlink()
        read(maps, tmp_path / "out")
        usual = Reader.read

        def stop(reader: Reader, path: str | Path) -> Reading:
            if Path(path).stem == "b":
                raise KeyboardInterrupt
            return usual(reader, path)

        with monkeypatch.context() as patched:
            patched.setattr(Reader, "read", stop)
            with pytest.raises(KeyboardInterrupt):
                read(maps, tmp_path / "out", graph=True)
        assert list_new(read(maps, tmp_path / "out")) == {"a"}

    def test_a_folder_that_is_moved_ends_the_batch(self, maps, tmp_path, monkeypatch):
        usual = Reader.read

        def move(reader: Reader, path: str | Path) -> Reading:
            if Path(path).stem == "b":
                (tmp_path / "out").rename(tmp_path / "moved")
            return usual(reader, path)

        monkeypatch.setattr(Reader, "read", move)
        with pytest.raises(OptionError, match="out' was moved or removed while the batch was running; remove what is"):
            read(maps, tmp_path / "out")

    def test_parts_forget_files_that_are_gone(self, maps, tmp_path):
        for number in (1, 2):
            read(maps, tmp_path / "out", shard=f"{number}/2")
        (maps / "a").rename(maps / "d")
        for number in (1, 2):
            read(maps, tmp_path / "out", shard=f"{number}/2", resume=False)
        assert {Path(entry.path).parent.name for entry in read_journals(tmp_path / "out")} == {"maps", "b", "c", "d"}

    def test_results_of_another_command_are_not_replaced(self, maps, tmp_path):
        (tmp_path / "out" / "a").mkdir(parents=True)
        (tmp_path / "out" / "a" / "prediction.json").write_text("{}")
        with pytest.raises(OptionError, match="a' has results that the journal does not know"):
            read(maps, tmp_path / "out")

    @pytest.mark.parametrize("name", ["floor.geojson", "uncorrected.geojson"])
    def test_damaged_results_with_corrections_are_kept_and_named(self, maps, tmp_path, name):
        read(maps, tmp_path / "out")
        assert run_pianta("correct", tmp_path / "out" / "a", "--name", 1, "Aula").code == 0
        (tmp_path / "out" / "a" / name).write_bytes(b"")
        (item,) = pianta.read_batch([maps / "a"], out=tmp_path / "out", labels=False)
        assert "the corrections of '" in str(item.fault)
        assert str(item.fault).endswith("a' to another place, and the file is read without its corrections")
        assert (tmp_path / "out" / "a" / "corrections.json").exists()

    def test_an_empty_map_with_corrections_is_made_again(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        assert run_pianta("correct", tmp_path / "out" / "a", "--name", 1, "Aula").code == 0
        (tmp_path / "out" / "a" / "grid.npz").write_bytes(b"")
        (item,) = pianta.read_batch([maps / "a"], out=tmp_path / "out", labels=False)
        assert (item.fault, item.is_new) == (None, True)
        assert pianta.read_floor(tmp_path / "out" / "a" / "floor.geojson")[1].name == "Aula"

    @pytest.mark.parametrize("content", [None, b"", b'{"format": '])
    def test_lost_corrections_are_named_and_results_are_collected(self, maps, tmp_path, content):
        geopandas = pytest.importorskip("geopandas")
        read(maps, tmp_path / "out")
        assert run_pianta("correct", tmp_path / "out" / "a", "--name", 1, "Aula").code == 0
        corrections = tmp_path / "out" / "a" / "corrections.json"
        corrections.unlink() if content is None else corrections.write_bytes(content)
        for walls in (True, False):
            (item,) = pianta.read_batch([maps / "a"], out=tmp_path / "out", labels=False, walls=walls)
            assert str(item.fault).endswith("a' to another place, and the file is read without its corrections")
        assert pianta.read_floor(tmp_path / "out" / "a" / "floor.geojson")[1].name == "Aula"
        rooms = geopandas.read_parquet(pianta.collect_batch(tmp_path / "out")["rooms"])
        assert "Aula" in set(rooms["name"])

    def test_processes_that_cannot_start_change_nothing(self, maps, tmp_path, monkeypatch):
        read(maps, tmp_path / "out")
        (maps / "c").rename(tmp_path / "unmounted")
        before = read_journals(tmp_path / "out")

        def refuse(_: object) -> None:
            raise OptionError("processes cannot be started")

        monkeypatch.setattr(processes, "_start", refuse)
        with pytest.raises(OptionError, match="processes cannot be started"):
            read(maps, tmp_path / "out", jobs=2, resume=False)
        assert read_journals(tmp_path / "out") == before

    @pytest.mark.parametrize("scheduler", ["nowhere.json", "tcp://127.0.0.1:1"])
    def test_a_scheduler_that_does_not_answer_changes_nothing(self, maps, tmp_path, monkeypatch, scheduler):
        cluster = pytest.importorskip("pianta.batch.cluster")
        monkeypatch.setattr(cluster, "SECONDS_TO_CONNECT", 1)
        read(maps, tmp_path / "out")
        before = read_journals(tmp_path / "out")
        with pytest.raises(OptionError, match="does not answer"):
            read(maps, tmp_path / "out", scheduler=scheduler, walls=True)
        assert read_journals(tmp_path / "out") == before

    def test_corrected_storeys_stay_and_are_collected(self, maps, tmp_path):
        geopandas = pytest.importorskip("geopandas")
        house = tmp_path / "house"
        storeys = ("--storey", "ground:0", "--storey", "first:3", "-o", house, "--no-labels")
        assert run_pianta("read", maps / "a" / "a.yaml", maps / "b" / "b.yaml", *storeys).code == 0
        (tmp_path / "plans").mkdir()
        assert run_pianta("convert", house, "--to", "ifc", "-o", tmp_path / "plans" / "house.ifc").code == 0
        read_house = {"out": tmp_path / "out", "labels": False}
        assert [item.fault for item in pianta.read_batch([tmp_path / "plans"], **read_house)] == [None]
        assert run_pianta("correct", tmp_path / "out" / "house" / "first", "--name", 1, "Aula").code == 0
        os.utime(tmp_path / "plans" / "house.ifc", (1, 1))
        (item,) = pianta.read_batch([tmp_path / "plans"], **read_house)
        assert "has several storeys, of which some were corrected" in str(item.fault)
        buildings = geopandas.read_parquet(pianta.collect_batch(tmp_path / "out")["buildings"])
        assert sorted(buildings["storey"]) == ["first", "ground"]
        (tmp_path / "out" / "journal.sqlite").unlink()
        with pytest.raises(OptionError, match="house' has corrections of a floor that the journal does not know"):
            [*pianta.read_batch([tmp_path / "plans"], resume=False, **read_house)]

    def test_results_without_an_entry_belong_to_the_batch_that_was_ended(self, maps, tmp_path, monkeypatch):
        def stop(*_: object) -> None:
            raise KeyboardInterrupt

        (maps / "broken.npz").unlink()
        with monkeypatch.context() as patched:
            patched.setattr(Journal, "record", stop)
            with pytest.raises(KeyboardInterrupt):
                read(maps, tmp_path / "out")
        assert [(entry.folder, entry.group) for entry in read_journals(tmp_path / "out")] == [("a", BEGUN)]
        with pytest.raises(OptionError, match=r"nothing in folder .* has failed, and 3 are still to be done"):
            read(maps, tmp_path / "out", only_failed=True)
        assert list_new(read(maps, tmp_path / "out")) == {"a", "b", "c"}
        assert list_new(read(maps, tmp_path / "out")) == set()

    def test_two_files_do_not_write_into_one_folder_by_a_link(self, maps, tmp_path):
        (tmp_path / "out" / "a").mkdir(parents=True)
        (tmp_path / "out" / "b").symlink_to("a")
        with pytest.raises(OptionError, match=r"folders '.*a' and '.*b' are one folder; remove the link"):
            read(maps, tmp_path / "out")

    def test_functions_with_one_name_do_not_share_descriptions(self, maps, tmp_path):
        read(maps, tmp_path / "out", describe=lambda reading: len(reading.floor))
        items = read(maps, tmp_path / "out", describe=lambda reading: len(reading.floor.doors))
        assert items["a"].description == 1
        assert list_new(read(maps, tmp_path / "out", describe=print)) == {"a", "b", "c", "broken"}
        with pytest.raises(OptionError, match="describe is 'count_rooms', give a function of a module"):
            read(maps, tmp_path / "out", describe="count_rooms")

    def test_a_function_is_itself_whatever_refers_to_its_constants(self):
        def describe(_: Reading) -> tuple[str, float]:
            return "constant of this function", 2.5

        before = _identify(describe)
        constants = [*describe.__code__.co_consts]
        assert constants
        assert _identify(describe) == before

    def test_corrections_of_a_building_are_applied_again(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        assert run_pianta("correct", tmp_path / "out" / "a", "--name", 1, "Kitchen").code == 0
        assert list_new(read(maps, tmp_path / "out", walls=True)) == {"a", "b", "c", "broken"}
        assert pianta.read_floor(tmp_path / "out" / "a" / "floor.geojson")[1].name == "Kitchen"

    @pytest.mark.parametrize(
        ("options", "fault"),
        [
            ({"jobs": "2"}, "jobs= is a str, give a number"),
            ({"shard": (1, 2)}, "shard= is a tuple, give a text such as 2/8"),
            ({"time_limit": "5", "jobs": 2}, "time_limit= is a str, give seconds"),
            ({"out": None}, "out= is a NoneType, give a folder"),
            ({"paths": None}, "paths is None, give a list"),
            ({"jobs": 2, "describe": lambda _: 1}, "give a function of a module"),
        ],
    )
    def test_arguments_of_other_types_are_one_line(self, maps, tmp_path, options, fault):
        with pytest.raises(OptionError, match=fault):
            pianta.read_batch(**{"paths": [maps], "out": tmp_path / "out", **options})
        assert not (tmp_path / "out").exists()

    def test_only_failed_without_a_failure_names_what_is_left(self, maps, tmp_path):
        (maps / "broken.npz").unlink()
        read(maps, tmp_path / "out")
        make_map().save(maps / "new.npz")
        with pytest.raises(OptionError, match="has failed, and 1 are still to be done; leave out only_failed="):
            read(maps, tmp_path / "out", only_failed=True)
        assert list_new(read(maps, tmp_path / "out")) == {"new"}

    def test_ctrl_c_counts_also_where_python_drops_its_exception(self, maps, tmp_path, monkeypatch):
        usual = Reader.read

        def interrupt(reader: Reader, path: str | Path) -> Reading:
            with suppress(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
            return usual(reader, path)

        monkeypatch.setattr(Reader, "read", interrupt)
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            code, _, _ = run_pianta("read", maps, "-o", tmp_path / "out", "--no-labels")
        finally:
            signal.signal(signal.SIGINT, before)
        assert code == 130
        assert len(read_journals(tmp_path / "out")) == 1

    def test_a_symbol_that_has_changed_is_another_option(self, maps, tmp_path):
        symbols = tmp_path / "symbols"
        symbols.mkdir()
        Image.new("L", (20, 20)).save(symbols / "door.png")
        options = {"symbols": symbols}
        before = digest_options(options)
        Image.new("L", (30, 30)).save(symbols / "door.png")
        assert digest_options(options) != before

    def test_copied_maps_are_others(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        copied = Path(copytree(maps, tmp_path / "copied"))
        assert {item.folder.name for item in read(copied, tmp_path / "out").values() if item.fault is None} == {
            "a-2",
            "b-2",
            "c-2",
        }

    def test_a_path_with_dots_is_the_same_file(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        assert list_new(read(maps / "a" / "..", tmp_path / "out")) == {"broken"}

    def test_dots_after_a_link_lead_to_another_file(self, maps, tmp_path):
        """link/.. is the folder of the target of a link."""
        (tmp_path / "other").mkdir()
        (tmp_path / "other" / "link").symlink_to(maps / "a")
        make_map(3).save(tmp_path / "other" / "x.npz")
        make_map(4).save(maps / "x.npz")
        items = pianta.read_batch(
            [tmp_path / "other" / "link" / ".." / "x.npz", tmp_path / "other" / "x.npz"],
            out=tmp_path / "out",
            labels=False,
            describe=count_rooms,
        )
        assert sorted(item.description for item in items) == [3, 4]

    def test_only_failed_and_no_resume_contradict_each_other(self, maps, tmp_path):
        code, _, err = run_pianta("read", maps, "-o", tmp_path / "out", "--retry-failed", "--no-resume")
        assert (code, err) == (2, "error: --retry-failed and --no-resume contradict each other, leave one out\n")

    def test_names_that_are_no_utf8_or_those_of_our_folders(self, tmp_path):
        maps = tmp_path / "maps"
        maps.mkdir()
        for name in (b"\xff\xfe.npz", b"faults.npz", b"journal.sqlite.npz", b"Journal-1-of-2.sqlite-wal.npz"):
            make_map().save(maps / "x.npz")
            os.rename(bytes(maps / "x.npz"), bytes(maps) + b"/" + name)  # noqa: PTH104 - the name is bytes
        items = [*pianta.read_batch([maps], out=tmp_path / "out", labels=False)]
        assert {item.folder.name: item.fault for item in items} == dict.fromkeys(
            ("\\xff\\xfe", "faults-2", "journal.sqlite-2", "Journal-1-of-2.sqlite-wal-2")
        )
        again = [*pianta.read_batch([maps], out=tmp_path / "out", labels=False)]
        assert [item.is_new for item in again] == 4 * [False]

    def test_a_name_that_spells_the_escape_of_another_one_is_another_file(self, tmp_path):
        maps = tmp_path / "maps"
        maps.mkdir()
        make_map(3).save(maps / "\\xff.npz")
        make_map().save(maps / "x.npz")
        os.rename(bytes(maps / "x.npz"), bytes(maps) + b"/\xff.npz")  # noqa: PTH104 - the name is bytes
        read_maps = {"out": tmp_path / "out", "labels": False, "describe": count_rooms}
        assert sorted(item.description for item in pianta.read_batch([maps], **read_maps)) == [2, 3]
        assert [item.is_new for item in pianta.read_batch([maps], **read_maps)] == [False, False]
        assert [entry.path.removeprefix(str(tmp_path)) for entry in read_journals(tmp_path / "out")] == [
            "/maps/\\xff.npz",
            f"file://{tmp_path}/maps/%FF.npz",
        ]
        assert [*pianta.collect_batch(tmp_path / "out")] == ["buildings", "rooms", "doors"]
        os.remove(bytes(maps) + b"/\xff.npz")  # noqa: PTH107 - the name is bytes
        [*pianta.read_batch([maps], resume=False, **read_maps)]
        assert len(read_journals(tmp_path / "out")) == 1


class TestOutputFolder:
    @pytest.mark.parametrize("out", ["\0", "\ud800"])
    def test_what_no_folder_can_be_called_is_refused(self, maps, out):
        with pytest.raises(OptionError, match=r"^output folder .* cannot be used: "):
            read(maps, out)

    def test_a_link_to_nothing_is_refused(self, maps, tmp_path):
        (tmp_path / "out").symlink_to("nowhere")
        with pytest.raises(OptionError, match=r"'.*out' is a link to what does not exist, remove it or give another"):
            read(maps, tmp_path / "out")

    def test_a_file_in_the_place_of_results_is_a_fault(self, maps, tmp_path):
        (tmp_path / "out").mkdir()
        (tmp_path / "out" / "a").write_text("notes")
        items = read(maps, tmp_path / "out")
        assert str(items["a"].fault).endswith("a' is a file, give another folder")
        assert (tmp_path / "out" / "a").read_text() == "notes"
        assert items["b"].fault is None

    def test_results_do_not_replace_or_hide_other_inputs(self, maps, tmp_path):
        """The results of house.yaml would be in the folder of another map."""
        for folder in (maps / "a", maps / "b", maps / "c"):
            folder.rename(folder.with_name(f"{folder.name}-old"))
        make_map().save(maps / "a-old.npz")
        with pytest.raises(
            OptionError,
            match=r"file '.*a\.yaml' is in folder '.*a-old', in which the results of '.*a-old\.npz' would be; give",
        ):
            read(maps, maps)
        assert not (maps / "journal.sqlite").exists()

    def test_a_map_called_like_a_table_or_a_journal_gets_another_name(self, maps, tmp_path):
        make_map().save(maps / "buildings.parquet.npz")
        assert read(maps, tmp_path / "out")["buildings.parquet"].folder.name == "buildings.parquet-2"

    def test_a_part_does_not_take_the_folder_of_another_one(self, maps, tmp_path):
        """Of two parts that were given different files, with one name."""
        other = tmp_path / "other" / "a.npz"
        other.parent.mkdir()
        make_map().save(other)
        with Journal(tmp_path / "out.sqlite") as journal:
            journal.record(Entry("/elsewhere/a.npz", "a", "a.npz 1 2", "", "", 1.0))
        (tmp_path / "out").mkdir()
        shards = [(f"{number}/2", f"journal-{3 - number}-of-2.sqlite") for number in (1, 2)]
        for shard, sibling in shards:
            (tmp_path / "out.sqlite").rename(tmp_path / "out" / sibling)
            folders = {item.folder.name for item in read(other.parent, tmp_path / "out", shard=shard).values()}
            assert folders <= {"a-2"}
            (tmp_path / "out" / sibling).rename(tmp_path / "out.sqlite")
            for own in (tmp_path / "out").glob("journal*"):
                own.unlink()

    @pytest.mark.parametrize("name", ["a/a.yaml", "a/a.png"])
    def test_json_does_not_replace_a_map(self, maps, tmp_path, name):
        before = list_files(maps)
        code, _, err = run_pianta("read", maps, "-o", tmp_path / "out", "--json", maps / name)
        assert code == 2
        assert "is there and not of pianta, give another name or remove it" in err
        assert list_files(maps) == before

    def test_storeys_are_not_read_into_the_folder_of_a_batch(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        files = (maps / "a" / "a.yaml", maps / "b" / "b.yaml")
        code, _, err = run_pianta("read", *files, "-o", tmp_path / "out", "--storey", "a:0", "--storey", "b:3")
        assert code == 2
        assert "has the results of a batch; give 'building' a folder of its own" in err

    @pytest.mark.parametrize("name", ["journal.sqlite", "rooms.parquet", "floor.geojson"])
    def test_json_does_not_replace_a_journal_or_a_result(self, maps, tmp_path, name):
        code, _, err = run_pianta("read", maps, "-o", tmp_path / "out", "--json", tmp_path / name)
        assert code == 2
        assert "has the name of another result, give another name" in err

    def test_the_folder_that_is_proposed_for_one_file_is_free(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        code, _, err = run_pianta("read", maps / "a" / "a.yaml", "-o", tmp_path / "out")
        assert code == 2
        assert err.endswith(f"such as -o '{tmp_path / 'out-a'}'\n")


class Cycle:
    """Refers to itself, as a figure of matplotlib does."""

    def __init__(self) -> None:
        self.itself = self


def test_a_process_frees_the_cycles_that_an_item_leaves():
    left: list[weakref.ref[Cycle]] = []

    def leave_cycle(item: int) -> int:
        left.append(weakref.ref(Cycle()))
        return item

    gc.disable()
    try:
        for number in range(2):
            outcome = work_in_worker(leave_cycle, number)
            assert (outcome.result, [reference() for reference in left]) == (number, [None] * (number + 1))
    finally:
        gc.unfreeze()
        gc.enable()


class TestFaults:
    def test_an_unforeseen_fault_is_a_line_and_a_report(self, maps, tmp_path, monkeypatch):
        usual = Reader.read

        def fail_for_b(reader: Reader, path: str | Path) -> Reading:
            if Path(path).stem == "b":
                raise ZeroDivisionError("division\nby zero")
            return usual(reader, path)

        monkeypatch.setattr(Reader, "read", fail_for_b)
        items = read(maps, tmp_path / "out")
        report = tmp_path / "out" / "faults" / "b.txt"
        assert items["b"].group == "unforeseen"
        assert items["b"].fault == (
            f"file '{maps / 'b' / 'b.yaml'}' cannot be read: an unforeseen fault, ZeroDivisionError: division by zero; "
            f"report in {report}"
        )
        assert "fail_for_b" in report.read_text(encoding="utf-8")
        assert items["c"].fault is None

    def test_a_full_disk_ends_the_batch(self, maps, tmp_path, monkeypatch):
        """No map after it could be written."""
        usual = Path.write_bytes

        def write(path: Path, content: bytes) -> int:
            if (tmp_path / "out" / "a").exists():
                raise OSError(errno.ENOSPC, "No space left on device")
            return usual(path, content)

        with monkeypatch.context() as patched:
            patched.setattr(Path, "write_bytes", write)
            with pytest.raises(OptionError) as refused:
                read(maps, tmp_path / "out")
        remedy = "free space where the output goes, and go on by the same command"
        assert (
            str(refused.value)
            == f"cannot write '{tmp_path / 'out' / 'b' / 'floor.geojson'}': No space left on device; {remedy}"
        )
        assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["a", "journal.sqlite"]
        assert list_new(read(maps, tmp_path / "out")) == {"b", "c", "broken"}

    @pytest.mark.slow
    def test_a_process_that_dies_stops_nothing(self):
        outcomes = {outcome.item: outcome for outcome in run_items(square_or_die, [*range(6)], jobs=2)}
        assert {item: outcome.result for item, outcome in outcomes.items()} == {0: 0, 1: 1, 2: 4, 3: None, 4: 16, 5: 25}
        assert outcomes[3].fault == Fault("killed", "its process ended with code -9, 2 times")

    @pytest.mark.slow
    def test_an_item_that_hangs_stops_nothing(self):
        outcomes = {outcome.item: outcome for outcome in run_items(sleep_or_square, [0, 30, 3], jobs=2, time_limit=5)}
        assert {item: outcome.result for item, outcome in outcomes.items()} == {0: 0, 30: None, 3: 9}
        assert outcomes[30].fault == Fault("time", "it took longer than 5 s")

    @pytest.mark.slow
    def test_an_item_that_is_ended_leaves_no_temporary_folder(self, tmp_path):
        (outcome,) = run_items(write_and_hang, [tmp_path / "out"], jobs=2, time_limit=4)
        assert outcome.fault == Fault("time", "it took longer than 4 s")
        assert [path.name for path in tmp_path.iterdir()] == ["started"]

    @pytest.mark.slow
    def test_the_message_for_a_program_without_a_guard_of_main_names_it(self, maps, tmp_path):
        """Each process would run the program again."""
        program = tmp_path / "program.py"
        program.write_text(f"import pianta\nfor item in pianta.read_batch([{str(maps)!r}], out='out', jobs=2): pass\n")
        done = subprocess.run([sys.executable, program], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.stderr.splitlines()[-1].endswith(
            "put the program under `if __name__ == '__main__':`, or give jobs=1"
        )
        assert done.stderr.count("Traceback") == 1
        assert not (tmp_path / "out").exists()

    @pytest.mark.slow
    def test_an_item_whose_process_was_killed_once_is_done_again(self, tmp_path):
        items = [tmp_path / str(number) for number in range(4)]
        outcomes = [*run_items(die_once, items, jobs=2)]
        assert Counter(outcome.result for outcome in outcomes) == {"done": 4}

    @pytest.mark.slow
    def test_a_broken_pool_is_replaced(self, monkeypatch):
        """As if a process had been killed while it started: what ran in the pool has no outcome."""
        usual, calls = processes._collect, []

        def collect_without_the_first(*arguments):
            calls.append(arguments)
            return None if len(calls) == 1 else usual(*arguments)

        monkeypatch.setattr(processes, "_collect", collect_without_the_first)
        outcomes = [*run_items(sleep_or_square, [0, 1, 2, 3], jobs=2)]
        assert sorted((outcome.item, outcome.result) for outcome in outcomes) == [(0, 0), (1, 1), (2, 4), (3, 9)]
        assert len(calls) == 5

    @pytest.mark.slow
    def test_processes_that_never_start_end_the_batch(self, monkeypatch):
        monkeypatch.setattr(processes, "MAX_BREAKS", 2)
        with pytest.raises(OptionError, match="2 times in turn processes ended while they started; put"):
            list(run_items(str, [DiesWhenReceived()], jobs=2))

    @pytest.mark.slow
    def test_results_are_the_same_for_any_number_of_processes(self, maps, tmp_path):
        for jobs in (1, 2):
            read(maps, tmp_path / str(jobs), jobs=jobs)
            (tmp_path / str(jobs) / "journal.sqlite").unlink()
        assert list_files(tmp_path / "1") == list_files(tmp_path / "2")


class DiesWhenReceived:
    """Ends the process that it is sent to, before the process can say that it has it."""

    def __reduce__(self):
        return os._exit, (9,)


def square_or_die(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number**2


def sleep_or_square(number: int) -> int:
    if number == 30:
        time.sleep(60)
    return number**2


def write_and_hang(folder: Path) -> None:
    with atomic_folder(folder) as new:
        (new / "half").write_text("half-written")
        (folder.parent / "started").touch()
        time.sleep(60)


def die_once(marker: Path) -> str:
    if not marker.exists():
        marker.write_text("tried")
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"


class TestShards:
    def test_each_file_is_in_one_part(self, maps, tmp_path):
        for name in "defghijk":
            make_map().save(maps / f"{name}.npz")
        parts = [set(read(maps, tmp_path / "out", shard=f"{number}/3")) for number in (1, 2, 3)]
        assert sorted(name for part in parts for name in part) == sorted({*"abcdefghijk", "broken"})
        assert sum(map(bool, parts)) > 1
        assert len(read_journals(tmp_path / "out")) == 12

    @pytest.mark.parametrize(("before", "after"), [(None, "1/3"), ("2/3", None), ("2/3", "1/4")])
    def test_journals_that_do_not_know_each_other_are_refused(self, maps, tmp_path, before, after):
        with Journal(
            tmp_path / (f"journal-{before.replace('/', '-of-')}.sqlite" if before else "journal.sqlite")
        ) as own:
            own.record(TestJournal.ENTRY)
        expected = "a batch without parts" if before is None else "one of 3 parts"
        with pytest.raises(OptionError, match=f"has the journal of {expected}.* or give another folder"):
            read(maps, tmp_path, shard=after)
        assert len([*tmp_path.glob("journal*")]) == 1

    def test_a_part_of_another_command_is_refused_also_while_it_is_written(self, maps, tmp_path):
        with Journal(tmp_path / "journal-2-of-3.sqlite", "predict") as other:
            other.record(TestJournal.ENTRY)
            with pytest.raises(OptionError, match="has the journal of `pianta predict`, give another"):
                read(maps, tmp_path, shard="1/3")
        with Journal(tmp_path / "journal-3-of-3.sqlite"), pytest.raises(OptionError, match="`pianta predict`"):
            read(maps, tmp_path, shard="1/3")

    def test_a_part_that_is_being_read_does_not_stop_the_others(self, maps, tmp_path):
        with Journal(tmp_path / "journal-3-of-3.sqlite"):
            assert all(
                item.fault is None or item.path.name == "broken.npz"
                for item in read(maps, tmp_path, shard="1/3").values()
            )

    @pytest.mark.parametrize("shard", ["0/2", "3/2", "2", "1/0", "a/b", "1/2/3", "-1/2", "1/99999999"])
    def test_impossible_parts_are_refused(self, maps, tmp_path, shard):
        with pytest.raises(OptionError, match="give 1/8 … 8/8 for eight parts"):
            read(maps, tmp_path / "out", shard=shard)
        assert not (tmp_path / "out").exists()


class TestJournal:
    ENTRY = Entry("/maps/a.yaml", "a", "a.yaml 1 2", "0123", "0.2.0", 1.5, "map", "no map", "null")

    def test_the_last_entry_of_a_file_counts(self, tmp_path):
        with Journal(tmp_path / "journal.sqlite") as journal:
            journal.record(self.ENTRY)
            journal.record(Entry("/maps/a.yaml", "a", "a.yaml 1 3", "0123", "0.2.0", 2.5))
        (entry,) = read_journals(tmp_path)
        assert (entry.inputs, entry.is_done) == ("a.yaml 1 3", True)

    def test_a_second_program_is_refused(self, tmp_path):
        with Journal(tmp_path / "journal.sqlite"), pytest.raises(OptionError, match="is in use by another pianta"):
            Journal(tmp_path / "journal.sqlite")

    def test_one_without_an_entry_is_not_left(self, tmp_path):
        with Journal(tmp_path / "journal.sqlite"):
            pass
        assert not [*tmp_path.iterdir()]
        for _ in range(2):
            with Journal(tmp_path / "journal.sqlite") as journal:
                journal.record(self.ENTRY)
        with Journal(tmp_path / "journal.sqlite"):
            pass
        assert len(read_journals(tmp_path)) == 1

    def test_a_damaged_journal_and_that_of_another_program_are_refused(self, tmp_path):
        (tmp_path / "journal.sqlite").write_bytes(b"SQLite format 3\0" + b"x" * 5000)
        with pytest.raises(OptionError, match=r"cannot be used: .*; remove it, and do all again with resume=False"):
            read_journals(tmp_path)
        with closing(sqlite3.connect(tmp_path / "journal-1-of-2.sqlite")) as other:
            other.execute("create table birds (name)")
        with pytest.raises(OptionError, match="is no journal of this pianta"):
            Journal(tmp_path / "journal-1-of-2.sqlite")

    @pytest.mark.parametrize(
        ("column", "value"),
        [("folder", "'..'"), ("folder", "'../x'"), ("folder", "''"), ("folder", "x'ff'"), ("seconds", "'abc'")],
    )
    def test_entries_with_other_values_are_refused(self, maps, tmp_path, column, value):
        read(maps, tmp_path / "out")
        with closing(sqlite3.connect(tmp_path / "out" / "journal.sqlite", isolation_level=None)) as journal:
            journal.execute(f"update entries set {column} = {value} where folder = 'a'")  # noqa: S608 - literals above
        for work in (lambda: read(maps, tmp_path / "out"), lambda: pianta.collect_batch(tmp_path / "out")):
            with pytest.raises(OptionError, match=r"the entry of '.*a\.yaml' is damaged; remove it, and do all"):
                work()

    def test_a_full_disk_is_no_reason_to_remove_it(self, tmp_path):
        error = _as_option_error(tmp_path / "journal.sqlite", sqlite3.OperationalError("database or disk is full"))
        assert str(error).endswith("is full; free space on its disk, and go on by the same command")

    def test_one_that_may_not_be_written_is_not_to_be_removed(self, tmp_path, monkeypatch):
        (tmp_path / "journal.sqlite").write_bytes(b"SQLite format 3\0" + b"x" * 5000)
        monkeypatch.setattr(os, "access", lambda path, _: Path(path) != tmp_path / "journal.sqlite")
        with pytest.raises(OptionError, match=r"cannot be used: .*; check its permissions and those of its folder"):
            read_journals(tmp_path)

    def test_files_with_similar_names_are_no_journals(self, tmp_path):
        (tmp_path / "journal-notes.sqlite").write_text("birds")
        with pytest.raises(OptionError, match=r"has no journal\.sqlite"):
            read_journals(tmp_path)

    def test_a_folder_without_one_is_refused(self, tmp_path):
        with pytest.raises(OptionError, match=r"has no journal\.sqlite, read files into it first"):
            read_journals(tmp_path)


class TestCollection:
    def test_the_tables_have_all_rooms_and_doors(self, maps, tmp_path):
        geopandas = pytest.importorskip("geopandas")
        make_map(3).save(maps / "b" / "b.yaml")
        read(maps, tmp_path / "out")
        tables = {name: geopandas.read_parquet(file) for name, file in pianta.collect_batch(tmp_path / "out").items()}
        assert tables["buildings"][["building", "rooms", "doors"]].values.tolist() == [
            ["a", 2, 1],
            ["b", 3, 2],
            ["c", 2, 1],
        ]
        assert tables["rooms"]["building"].tolist() == [*"aabbbcc"]
        floor = pianta.read_floor(tmp_path / "out" / "b" / "floor.geojson")
        second = tables["rooms"][tables["rooms"]["building"] == "b"]
        assert second["area"].tolist() == [room.polygon.area for room in floor]
        assert second.geometry.geom_equals_exact(
            geopandas.GeoSeries([room.polygon for room in floor], second.index), 0
        ).all()
        assert len(tables["doors"]) == 4

    @pytest.mark.parametrize("row_group", [1, 2, 1000])
    def test_row_groups_are_one_table(self, maps, tmp_path, monkeypatch, row_group):
        geopandas = pytest.importorskip("geopandas")
        parquet = pytest.importorskip("pyarrow.parquet")
        read(maps, tmp_path / "out")
        tables = {name: geopandas.read_parquet(file) for name, file in pianta.collect_batch(tmp_path / "out").items()}
        monkeypatch.setattr(geoparquet, "ROW_GROUP", row_group)
        files = pianta.collect_batch(tmp_path / "out", tmp_path / "groups")
        for name, file in files.items():
            assert geopandas.read_parquet(file).equals(tables[name])
            stored = parquet.ParquetFile(file)
            described = json.loads(stored.metadata.metadata[b"geo"])["columns"]["geometry"]
            assert described["bbox"] == pytest.approx(tables[name].total_bounds.tolist())
            assert described["geometry_types"] == sorted(set(tables[name].geom_type))
            # A storey and its rooms are added at once
            assert stored.num_row_groups == (
                1 if row_group == 1000 else {1: 3, 2: {"rooms": 3}.get(name, 2)}[row_group]
            )

    def test_threads_of_pyarrow_do_not_abort_the_program(self, maps, tmp_path, monkeypatch):
        """Those of read_table, in pyarrow 26, do so at its end one time in twenty."""
        parquet = pytest.importorskip("pyarrow.parquet")
        read(maps, tmp_path / "out")
        usual, threads = parquet.ParquetFile.read, []

        def read_tracked(file: object, **options: object) -> object:
            threads.append(options.get("use_threads", True))
            return usual(file, **options)

        monkeypatch.setattr(parquet.ParquetFile, "read", read_tracked)
        monkeypatch.delattr(parquet, "read_table")
        pianta.collect_batch(tmp_path / "out")
        assert threads == [False] * 3

    def test_a_batch_on_a_disk_that_cannot_be_written_is_collected(self, maps, tmp_path, monkeypatch):
        pytest.importorskip("geopandas")
        read(maps, tmp_path / "out")
        before = list_files(tmp_path / "out")
        access = os.access
        monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK and access(path, mode))
        assert [entry.folder for entry in read_journals(tmp_path / "out")] == ["a", "b", "broken", "c"]
        assert list_files(tmp_path / "out") == before

    def test_a_map_that_was_removed_with_its_results_is_left_out(self, maps, tmp_path):
        geopandas = pytest.importorskip("geopandas")
        read(maps, tmp_path / "out")
        rmtree(maps / "a")
        rmtree(tmp_path / "out" / "a")
        table = geopandas.read_parquet(pianta.collect_batch(tmp_path / "out")["buildings"])
        assert table["building"].tolist() == ["b", "c"]

    def test_results_that_are_gone_are_an_error(self, maps, tmp_path):
        read(maps, tmp_path / "out")
        (tmp_path / "out" / "a" / "floor.geojson").unlink()
        with pytest.raises(pianta.PiantaError, match="remove it, and `pianta read` reads the file again"):
            pianta.collect_batch(tmp_path / "out")
        assert not list((tmp_path / "out").glob("*.parquet"))


class TestCommand:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (["--clean", "clean.npz"], "--clean is for one map and"),
            (["--explain"], "--explain is for one map and"),
            (["--time-limit", "5"], "--time-limit ends processes, and one job needs none; give --jobs 2 or more"),
            (["--time-limit", "-5", "--jobs", "2"], "Invalid value for '--time-limit'"),
            (["--shard", "3/2"], "shard is '3/2', give 1/8 … 8/8 for eight parts"),
            (["--storey", "ground", "--shard", "1/2"], "storeys are read together, leave out --shard"),
        ],
    )
    def test_flags_that_do_not_fit_are_refused(self, maps, tmp_path, arguments, message):
        code, out, err = run_pianta("read", maps, "-o", tmp_path / "out", *arguments)
        assert (code, out) == (2, "")
        assert message in err
        assert not (tmp_path / "out").exists()

    def test_a_file_with_a_flag_of_batches_is_a_batch(self, maps, tmp_path):
        code, out, _ = run_pianta(
            "read", maps / "a" / "a.yaml", "-o", tmp_path / "out", "--shard", "1/1", "--no-labels"
        )
        assert (code, out.splitlines()[-1]) == (0, "1 of 1 file read")
        assert (tmp_path / "out" / "a" / "floor.geojson").is_file()

    def test_a_folder_is_read_and_counted(self, maps, tmp_path):
        arguments = ("read", maps, "-o", tmp_path / "out", "--no-labels")
        code, out, err = run_pianta(*arguments, "--json", tmp_path / "all.json")
        assert code == 1
        assert out.splitlines()[-1] == "3 of 4 files read"
        assert err.count("\n") == 1
        first = json.loads((tmp_path / "all.json").read_text(encoding="utf-8"))["files"]
        assert [len(file["storeys"][0]["rooms"]) for file in first] == [2, 2, 2]
        code, out, _ = run_pianta(*arguments, "--json", tmp_path / "all.json")
        assert (code, out) == (1, "3 of 4 files read, 3 of them before; --no-resume reads them again\n")
        assert json.loads((tmp_path / "all.json").read_text(encoding="utf-8"))["files"] == first
        code, out, _ = run_pianta("collect", tmp_path / "out", "-o", tmp_path / "tables")
        assert code == 0
        assert out.split() == [str(tmp_path / "tables" / f"{name}.parquet") for name in ("buildings", "rooms", "doors")]

    def test_one_file_is_not_read_into_the_folder_of_a_batch(self, maps, tmp_path):
        assert run_pianta("read", maps, "-o", tmp_path / "out", "--no-labels", "-q").code == 1
        before = list_files(tmp_path / "out")
        code, out, err = run_pianta("read", maps / "a" / "a.yaml", "-o", tmp_path / "out", "--no-labels")
        assert (code, out) == (2, "")
        assert f"has the results of a batch; give '{maps}/a/a.yaml' a folder of its own, such as -o '" in err
        assert list_files(tmp_path / "out") == before

    @pytest.mark.slow
    @pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
    def test_processes_end_with_the_program(self, maps, tmp_path, how):
        """SIGTERM, of a cluster whose time is over, leaves no warning of what was not closed either."""
        command = [sys.executable, "-m", "pianta", "read", str(maps), "-o", str(tmp_path / "out"), "--jobs", "2"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert process.stderr is not None
            process.stdout.readline()
            children = psutil.Process(process.pid).children(recursive=True)
            process.send_signal(how)
            gone, alive = psutil.wait_procs(children, timeout=30)
            assert not alive
            assert len(gone) >= 2
            assert process.wait(30) == (128 + how if how == signal.SIGTERM else -how)
            if how == signal.SIGTERM:
                assert "leaked" not in process.stderr.read()

    def test_signals_that_follow_at_once_are_one(self):
        """The second one must not end what ends the processes."""
        caught: list[int] = []

        def send() -> None:
            with ending_by_signal(), ExitStack() as ends:
                for number in (signal.SIGINT, signal.SIGTERM):
                    ends.callback(caught.append, number)
                    ends.callback(signal.raise_signal, number)
                signal.raise_signal(signal.SIGTERM)

        with pytest.raises(SystemExit) as ended:
            send()
        assert ended.value.code == 128 + signal.SIGTERM
        assert caught == [signal.SIGTERM, signal.SIGINT]

    def test_a_later_signal_ends_again(self, monkeypatch, request):
        monkeypatch.setattr("pianta.cli.batches.PAUSE", 0.0)
        # A shell ignores Ctrl+C for what it runs in the background, as these tests
        request.addfinalizer(partial(signal.signal, signal.SIGINT, signal.getsignal(signal.SIGINT)))
        signal.signal(signal.SIGINT, signal.default_int_handler)

        def send() -> None:
            with ending_by_signal(), ExitStack() as ends:
                ends.callback(signal.raise_signal, signal.SIGINT)
                signal.raise_signal(signal.SIGTERM)

        with pytest.raises(KeyboardInterrupt):
            send()

    @pytest.mark.slow
    def test_a_killed_batch_goes_on_where_it_was(self, tmp_path):
        """Killed three times at different moments; no file is lost, half-written, or read again when it was done."""
        maps, out = tmp_path / "maps", tmp_path / "out"
        maps.mkdir()
        for number in range(9):
            make_map(4).save(maps / f"m{number:02}.npz")
        command = [sys.executable, "-m", "pianta", "read", str(maps), "-o", str(out), "--jobs", "2", "--no-labels"]
        done: set[str] = set()
        for enough in (2, 4, 6):
            with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
                lines = [line for _, line in zip(range(enough - len(done)), process.stdout or (), strict=False)]
                process.kill()
            assert not done & {Path(line.split()[-1]).name for line in lines}
            done |= {Path(line.split()[-1]).name for line in lines}
            results = [folder for folder in out.iterdir() if folder.is_dir() and not folder.name.startswith(".")]
            assert {folder.name for folder in results} >= done
            # A process that has outlived the killed one may be writing into a hidden folder
            assert all(set(OUTPUTS) <= list_files(folder).keys() for folder in results)
        last = subprocess.run(command, capture_output=True, text=True, check=True)
        assert not done & {Path(line.split()[-1]).name for line in last.stdout.splitlines()[:-1]}
        assert last.stdout.splitlines()[-1].startswith("9 of 9 files read")
        assert {path.name for path in out.iterdir() if path.is_dir()} == {f"m{number:02}" for number in range(9)}
