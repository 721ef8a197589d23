"""README, the first page and the how-to pages do what they say: their commands and their Python run, in order."""

import importlib.util
import os
import re
import shlex
import signal
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from http import HTTPStatus
from http.client import HTTPConnection
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.page_samples import make_page_samples

ROOT = Path(__file__).parents[1]
PAGES = [
    ROOT / "README.md",
    ROOT / "docs" / "get-started.md",
    *sorted({*(ROOT / "docs" / "how-to").glob("*.md")} - {ROOT / "docs" / "how-to" / "index.md"}),
]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
# Packages of extras without which a page cannot run.
NEEDED = {
    "bim-cad.md": "ifcopenshell",
    "bags.md": "rosbags",
    "qgis.md": "geopandas",
    "drawings.md": "rapidocr",
    "symbols.md": "rapidocr",
}
# Set up what a user starts from: here a test checks that they are there, and .ci/run runs them.
MAKE, INSTALL = re.compile(r"make ([\w-]+)"), re.compile(r"pip install '?\.(?:\[([\w,]+)\])?'?")


class Block(NamedTuple):
    language: str
    code: str
    file: str
    """The file that the paragraph before it names last."""


def read_blocks(page: Path) -> Iterator[Block]:
    """Blocks of commands, of Python and of files, in order."""
    text = page.read_text(encoding="utf-8")
    for match in re.finditer(r"^```(console|python|json)\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
        named = re.findall(r"`([\w./-]+\.\w+)`", text[: match.start()])
        yield Block(match.group(1), match.group(2), named[-1] if named else "")


def list_commands(page: Path) -> list[str]:
    return [line for block in read_blocks(page) if block.language == "console" for line in block.code.splitlines()]


def is_set_up(command: str) -> bool:
    return bool(MAKE.fullmatch(command) or INSTALL.fullmatch(command))


def is_server(command: str) -> bool:
    return command.startswith("pianta view ") and "--html" not in command


def make_environment() -> dict[str, str]:
    return {
        **os.environ,
        "OMP_NUM_THREADS": "1",
        "MPLBACKEND": "agg",
        "BROWSER": "true",  # the program of this name opens nothing
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT / "src"),
    }


def run(*command: str, folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, env=make_environment(), capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"


def run_server(command: str, folder: Path) -> None:
    """Run a command that serves a page until Ctrl+C, and load the page."""
    with subprocess.Popen(
        shlex.split(command), cwd=folder, env=make_environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as process:
        first = process.stdout.readline().decode() if process.stdout else ""
        address = re.search(r"http://(127\.0\.0\.1:\d+)(/\S+/)", first)
        try:
            assert address, f"{command}\n{first}"
            connection = HTTPConnection(address.group(1))
            connection.request("GET", address.group(2))
            assert connection.getresponse().status == HTTPStatus.OK
            connection.close()
        finally:
            process.send_signal(signal.SIGINT)
        assert process.wait() == 0


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a user has before the first command; `school.json` is trained by the command of the page about training."""
    folder = tmp_path_factory.mktemp("samples")
    make_page_samples(folder)
    run("pianta", "train", "type", "buildings/school", "-o", "school.json", folder=folder)
    run("pianta", "read", "map.yaml", "-o", "building", "--type", "school", folder=folder)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_and_python_run(page, samples, tmp_path):
    needed = NEEDED.get(page.name)
    if needed and not importlib.util.find_spec(needed):
        pytest.skip(f"{needed} is not installed, see the extras in pyproject.toml")
    for entry in samples.iterdir():
        (tmp_path / entry.name).symlink_to(entry)
    (tmp_path / "building").unlink()
    run("cp", "-r", str(samples / "building"), "building", folder=tmp_path)
    python = ""
    for language, code, file in read_blocks(page):
        if language == "json":
            (tmp_path / file).write_text(code, encoding="utf-8")
        elif language == "python":
            # Blocks of a page share their names.
            python += code
            run(sys.executable, "-c", python, folder=tmp_path)
        else:
            for command in code.splitlines():
                if is_server(command):
                    run_server(command, tmp_path)
                elif not is_set_up(command):
                    run("bash", "-ec", command, folder=tmp_path)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_sets_up_is_there(page):
    """These commands would run themselves again, or install: `.ci/run` runs them from a bare clone."""
    targets = {match.group(1) for command in list_commands(page) if (match := MAKE.fullmatch(command))}
    assert targets <= {
        *re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE),
        "test",
    }
    assert targets <= {*re.findall(r"^make (\w+)$", (ROOT / ".ci" / "run").read_text(encoding="utf-8"), re.MULTILINE)}
    extras = [match.group(1) or "" for command in list_commands(page) if (match := INSTALL.fullmatch(command))]
    assert {name for listed in extras for name in listed.split(",") if name} <= {*EXTRAS}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_other_command_is_one_of_pianta(page):
    assert [
        command for command in list_commands(page) if not is_set_up(command) and not command.startswith("pianta ")
    ] == []
