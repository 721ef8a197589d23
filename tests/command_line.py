"""The command line as a user runs it, in this process."""

from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import pytest

from pianta.cli import main


class Outcome(NamedTuple):
    code: int | str | None
    out: str
    err: str


def run_pianta(*arguments: object) -> Outcome:
    """What `pianta ARGUMENTS` prints and the code that it exits with."""
    with redirect_stdout(StringIO()) as out, redirect_stderr(StringIO()) as err, pytest.raises(SystemExit) as exit_:
        main([str(argument) for argument in arguments])
    return Outcome(exit_.value.code, out.getvalue(), err.getvalue())


def list_files(folder: Path) -> dict[str, bytes]:
    """Content of every file below a folder, by path; nothing when there is no folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
