"""Folders of results change all at once, also if the process is killed between any two of its calls to the system."""

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from shapely import box

import pianta
from pianta.errors import PiantaError, WriteError
from pianta.io._files import atomic_file, is_disk_full
from pianta.io._folders import atomic_folder, finish_changes, remove_remains

NAMES = ("a.txt", "b.txt", "c.txt", "inner/d.txt")
# Kills itself before the audit event of this number that touches files, of those in the folder of the test
WRITER = """
import os, signal, sys
from pathlib import Path
from pianta.io._folders import atomic_folder
folder, last, count = Path(sys.argv[1]), int(sys.argv[2]), 0
WATCHED = {"open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.listdir", "os.scandir", "shutil.rmtree"}
def watch(event, arguments):
    global count
    if event in WATCHED and str(folder.parent) in str(arguments[0]):
        count += 1
        if count == last:
            os.kill(os.getpid(), signal.SIGKILL)
sys.addaudithook(watch)
with atomic_folder(folder) as new:
    (new / "inner").mkdir()
    for name in ("a.txt", "b.txt", "c.txt", "inner/d.txt"):
        (new / name).write_text("new")
"""
needs_kill = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system has no SIGKILL")


def write(folder: Path, content: str) -> None:
    with atomic_folder(folder) as new:
        (new / "inner").mkdir()
        for name in NAMES:
            (new / name).write_text(content)


def contents(folder: Path) -> set[str]:
    return {(folder / name).read_text() for name in NAMES}


def hidden(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir() if path.name.startswith(".pianta")]


def kill_at(number: int, folder: Path) -> bool:
    """Whether a process that writes into a folder was killed before its event of a number."""
    done = subprocess.run([sys.executable, "-c", WRITER, str(folder), str(number)], check=False, capture_output=True)
    assert done.returncode in {0, -signal.SIGKILL}, done.stderr.decode()
    return done.returncode != 0


@needs_kill
@pytest.mark.slow
@pytest.mark.parametrize("is_there", [True, False], ids=["older files", "a new folder"])
def test_killed_between_any_two_calls_all_files_are_old_or_all_new(tmp_path, is_there):
    states = []
    for number in range(1, 200):
        folder = tmp_path / f"run{number}" / "out"
        folder.parent.mkdir()
        if is_there:
            write(folder, "old")
            (folder / "notes.txt").write_text("mine")
        was_killed = kill_at(number, folder)
        finish_changes(folder)
        states.append(contents(folder) if folder.exists() else set())
        if is_there:
            assert (folder / "notes.txt").read_text() == "mine"
        # The next process that writes leaves nothing of the killed one
        write(folder, "next")
        assert contents(folder) == {"next"}
        assert not hidden(folder)
        assert not hidden(folder.parent)
        if not was_killed:
            break
    old, new = ({"old"}, {"new"}) if is_there else (set(), {"new"})
    assert states[0] == old
    assert states[-1] == new
    assert states == sorted(states, key=lambda state: state == new)
    assert all(state in (old, new) for state in states)
    assert len(states) > 8


def test_read_floor_finishes_what_was_decided(tmp_path):
    old, new = (pianta.Floor((pianta.Room(1, box(0, 0, side, 3)),)) for side in (4, 5))
    old.save(tmp_path / "floor.geojson")
    decided = tmp_path / ".pianta-done-0123456789abcdef"
    decided.mkdir()
    new.save(decided / "floor.geojson")
    os.utime(tmp_path / "floor.geojson", (1, 1))
    assert pianta.read_floor(tmp_path / "floor.geojson") == new
    assert not decided.exists()


def test_a_file_that_a_person_changed_since_stays(tmp_path):
    decided = tmp_path / ".pianta-done-0123456789abcdef"
    decided.mkdir()
    for name in ("a.txt", "b.txt"):
        (decided / name).write_text("new")
        os.utime(decided / name, (1000, 1000))
    (tmp_path / "a.txt").write_text("by hand")
    finish_changes(tmp_path)
    assert ((tmp_path / "a.txt").read_text(), (tmp_path / "b.txt").read_text()) == ("by hand", "new")
    assert not decided.exists()


def test_what_is_optional_is_removed_if_it_is_not_written(tmp_path):
    for name in ("a.txt", "b.txt", "c.txt"):
        (tmp_path / name).write_text("old")
    with atomic_folder(tmp_path, optional=("b.txt", "c.txt", "d.txt")) as new:
        (new / "b.txt").write_text("new")
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {"a.txt": "old", "b.txt": "new"}


def test_what_is_decided_to_be_gone_is_removed_unless_a_person_changed_it_since(tmp_path):
    decided = tmp_path / ".pianta-done-0123456789abcdef"
    decided.mkdir()
    for name in ("a.txt", "b.txt"):
        (tmp_path / name).write_text("old")
        (decided / f".gone-{name}").touch()
    os.utime(decided / ".gone-a.txt", (1000, 1000))
    os.utime(tmp_path / "b.txt", (1000, 1000))
    finish_changes(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_files_in_inner_folders_move_and_go_as_others_do(tmp_path):
    for name in ("a/old.txt", "a/mine.txt", "b/old.txt", "b/c/old.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("old")
    with atomic_folder(tmp_path, optional=("a/old.txt", "b/old.txt", "b/c/old.txt", "d/none.txt")) as new:
        (new / "a").mkdir()
        (new / "a" / "new.txt").write_text("new")
        (new / "e" / "f").mkdir(parents=True)
        (new / "e" / "f" / "new.txt").write_text("new")
    assert sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")) == [
        "a",
        "a/mine.txt",
        "a/new.txt",
        "e",
        "e/f",
        "e/f/new.txt",
    ]


def test_inner_folders_that_were_decided_are_finished(tmp_path):
    decided = tmp_path / ".pianta-done-0123456789abcdef"
    (decided / "a" / "b").mkdir(parents=True)
    (decided / "a" / "b" / "new.txt").write_text("new")
    (decided / "a" / "by hand.txt").write_text("new")
    (decided / "a" / ".gone-old.txt").touch()
    os.utime(decided / "a" / "by hand.txt", (1000, 1000))
    (tmp_path / "a").mkdir()
    for name in ("old.txt", "by hand.txt"):
        (tmp_path / "a" / name).write_text("old")
    os.utime(tmp_path / "a" / "old.txt", (1000, 1000))
    finish_changes(tmp_path)
    files = {str(path.relative_to(tmp_path)): path.read_text() for path in tmp_path.rglob("*") if path.is_file()}
    assert files == {"a/b/new.txt": "new", "a/by hand.txt": "old"}
    assert not decided.exists()


def test_a_file_with_the_name_of_an_inner_folder_is_one_line_and_nothing_changes(tmp_path):
    (tmp_path / "a").write_text("mine")

    def write_both() -> None:
        with atomic_folder(tmp_path) as new:
            (new / "a").mkdir()
            (new / "a" / "new.txt").write_text("new")
            (new / "b.txt").write_text("new")

    with pytest.raises(PiantaError, match=r"a/new\.txt'"):
        write_both()
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "mine"}


def test_a_new_folder_appears_at_once(tmp_path):
    with atomic_folder(tmp_path / "new") as folder:
        (folder / "one.txt").write_text("1")
        assert not (tmp_path / "new").exists()
    assert [path.relative_to(tmp_path).as_posix() for path in sorted(tmp_path.rglob("*"))] == ["new", "new/one.txt"]


def test_remains_of_a_killed_process_are_removed(tmp_path):
    (tmp_path / ".pianta-0123456789abcdef").mkdir()
    (tmp_path / ".pianta-notes").mkdir()
    remove_remains(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".pianta-notes"]


def test_the_temporary_folder_of_a_living_process_stays(tmp_path):
    (tmp_path / "out").mkdir()
    with atomic_folder(tmp_path / "out") as first, atomic_folder(tmp_path / "out") as second:
        assert first != second
        remove_remains(tmp_path / "out")
        (first / "a.txt").write_text("first")
        (second / "b.txt").write_text("second")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["a.txt", "b.txt"]


def test_a_file_that_fails_is_not_called_by_its_temporary_folder(tmp_path):
    def fill_the_disk() -> None:
        with atomic_folder(tmp_path / "new") as folder, atomic_file(folder / "one.txt"):
            raise OSError(errno.ENOSPC, "No space left on device")

    message = (
        f"cannot write '{tmp_path / 'new' / 'one.txt'}': No space left on device; free space where the output goes"
    )
    with pytest.raises(WriteError, match=f"^{message}$") as refused:
        fill_the_disk()
    assert is_disk_full(refused.value)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_fails_leaves_nothing(tmp_path):
    def fill_the_disk() -> None:
        with atomic_folder(tmp_path / "x" / "new") as folder:
            (folder / "one.txt").write_text("1")
            raise OSError("full")

    with pytest.raises(WriteError, match=r"^cannot write '.*new': full$"):
        fill_the_disk()
    assert not list(tmp_path.iterdir())
