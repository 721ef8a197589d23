"""Paths that are safe to open, and outputs that appear whole or not at all."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pianta.errors import FloorError, MapError, PiantaError
from pianta.io._files import atomic_file, check_cell_count, check_input_file, one_line_reason, short_repr

KILLED_WRITER = """
import os, sys
from pianta.io._files import atomic_file
with atomic_file(sys.argv[1]) as temporary:
    temporary.write_text("half")
    os._exit(9)
"""


@pytest.mark.parametrize("url", ["http://a.b/m.yaml", "https://a/m", "ftp://a/m", "s3://bucket/m", "S3://bucket/m"])
@pytest.mark.parametrize("what", [str, Path])
def test_addresses_are_to_be_downloaded_first(url, what):
    with pytest.raises(MapError, match="address"):
        check_input_file(what(url), "map", MapError)


def test_unusable_inputs_are_named_in_one_line(tmp_path):
    (tmp_path / "empty").touch()
    cases = {
        tmp_path / "gone\nline": "exist",
        tmp_path / "empty" / "below": "exist",
        tmp_path: "folder",
        tmp_path / "empty": "empty",
        Path(os.devnull): "device",
        tmp_path / ("x" * 300): "open",
        "nul\0": "open",
    }
    for path, fault in cases.items():
        with pytest.raises(FloorError, match=rf"^floor '[^\n]*' [^\n]*{fault}[^\n]*$"):
            check_input_file(path, "floor", FloorError)


def test_input_without_permission_is_refused(tmp_path, monkeypatch):
    (tmp_path / "secret").write_text("x")
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.R_OK)  # root may read everything
    with pytest.raises(MapError, match="read"):
        check_input_file(tmp_path / "secret", "map", MapError)


def test_relative_input_starts_at_the_folder_and_absolute_does_not(tmp_path):
    file = tmp_path / "file"
    file.write_text("x")
    assert check_input_file("file", "map", MapError, folder=tmp_path) == file
    assert check_input_file(file, "map", MapError, folder=Path("/elsewhere")) == file


def test_home_is_expanded_unless_there_is_a_folder(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("x")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert check_input_file("~/file", "map", MapError) == tmp_path / "file"
    with pytest.raises(MapError, match="~/file"):
        check_input_file("~/file", "map", MapError, folder=tmp_path)


def test_cell_count_above_the_limit_names_size_limit_and_option():
    check_cell_count((20, 30), "image", max_cells=600)
    with pytest.raises(MapError, match=r"600.*max_cells="):
        check_cell_count((20, 30), "image", max_cells=599)


def test_messages_stay_short_and_on_one_line():
    assert short_repr(Path("a\nb")) == r"'a\nb'"
    assert len(short_repr("x" * 10_000)) < 500
    assert one_line_reason(ValueError("two\n lines")) == "two lines"
    assert one_line_reason(MemoryError()) == "MemoryError"


def test_written_file_replaces_the_old_and_leaves_nothing_else(tmp_path):
    target = tmp_path / "out.txt"
    target.write_text("old")
    with atomic_file(target) as temporary:
        assert (temporary.parent, temporary.suffix) == (tmp_path, ".txt")
        temporary.write_text("new")
        assert target.read_text() == "old"
    assert target.read_text() == "new"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("failure", [KeyboardInterrupt, RuntimeError, MapError])
def test_failing_writer_leaves_the_old_file_and_nothing_else(tmp_path, failure):
    target = tmp_path / "out.txt"
    target.write_text("old")

    def write() -> None:
        with atomic_file(target) as temporary:
            temporary.write_text("half")
            raise failure("on the way")

    with pytest.raises(failure, match="on the way"):
        write()
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_killed_writer_is_never_in_the_way(tmp_path):
    target = tmp_path / "out.txt"
    target.write_text("old")
    source = str(Path(__file__).parents[1] / "src")
    environment = os.environ | {"PYTHONPATH": source}
    killed = subprocess.run([sys.executable, "-c", KILLED_WRITER, str(target)], env=environment, check=False)
    assert killed.returncode == 9
    assert target.read_text() == "old"
    with atomic_file(target) as temporary:
        temporary.write_text("new")
    assert target.read_text() == "new"


def test_unwritable_targets_are_refused_in_one_line(tmp_path):
    (tmp_path / "file").write_text("x")
    cases = {
        tmp_path: "folder",
        tmp_path / "file" / "below": "Not a directory",
        tmp_path / "gone" / "below": "No such file or directory",
        Path("/"): "folder",
    }
    for target, fault in cases.items():
        with pytest.raises(PiantaError, match=rf"^[^\n]*'[^\n]*'[^\n]*{fault}[^\n]*$"):
            write_text(target)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def write_text(target: Path) -> None:
    with atomic_file(target) as temporary:
        temporary.write_text("x")
