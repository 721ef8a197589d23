"""The process `pianta` with standard streams that are full or closed, and with few open files."""

import errno
import subprocess
import sys
from pathlib import Path

import pytest

import pianta
from pianta.cli import main

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the shell is that of Unix")


@pytest.fixture
def world(tmp_path: Path) -> Path:
    (tmp_path / "maps").mkdir()
    pianta.make_world("corridor")[1].save(tmp_path / "maps" / "map.yaml")
    return tmp_path


def run_in_shell(words: str, redirection: str, folder: Path) -> tuple[int, str]:
    """The exit code of a command with redirections, and what it prints on stderr."""
    line = f"{sys.executable} -m pianta {words} {redirection}"
    done = subprocess.run(["sh", "-c", line], cwd=folder, stderr=subprocess.PIPE, text=True, check=False)
    return done.returncode, done.stderr


@pytest.mark.parametrize("words", ["--version", pytest.param("read maps -o out --no-labels", marks=pytest.mark.slow)])
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_a_full_disk_behind_stdout_is_one_line(world, words):
    assert run_in_shell(words, ">/dev/full", world) == (
        2,
        "error: the system refuses: No space left on device; free space where the output goes\n",
    )


@pytest.mark.parametrize("words", ["--version", pytest.param("read maps -o out --no-labels", marks=pytest.mark.slow)])
@pytest.mark.parametrize("streams", ["<&- >&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_streams_may_be_closed(world, words, streams):
    assert run_in_shell(words, streams, world) == (0, "")
    assert (world / "out").exists() == words.startswith("read")


def test_other_faults_of_the_system_keep_their_traceback(monkeypatch):
    def refuse(*_: object) -> None:
        raise OSError(errno.EBADF, "Bad file descriptor")

    monkeypatch.setattr("pianta.cli.run_app", refuse)
    with pytest.raises(OSError, match="Bad file descriptor"):
        main(["--version"])


@pytest.mark.slow
@pytest.mark.parametrize("limit", [12, 16])
def test_too_few_open_files_are_one_line(world, limit):
    line = f"ulimit -n {limit}; exec {sys.executable} -m pianta read maps -o more --no-labels --jobs 2"
    done = subprocess.run(["sh", "-c", line], cwd=world, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert done.stderr.startswith("error: processes cannot be started: Too many open files; give --jobs 1")
    assert not (world / "more").exists()
