"""Files: input paths that are safe to open, and outputs that are written completely or not at all."""

from __future__ import annotations

import errno
import os
import re
import stat
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from math import prod
from pathlib import Path
from reprlib import Repr
from secrets import token_hex

from pianta.errors import MapError, OptionError, PiantaError, WriteError

MAX_CELLS = 300_000_000  # of a map or picture, such as 16,000 × 16,000; 300 MB in memory

FULL = frozenset({errno.ENOSPC, errno.EDQUOT})
# What a system may lack, and the remedy.
LACKS = {
    **dict.fromkeys(FULL, "free space where the output goes"),
    errno.EMFILE: "raise the number of open files, `ulimit -n`",
}

# One slash is enough because Path("http://a") is "http:/a"; two letters, not to match Windows drives.
_ADDRESS = re.compile(r"[a-z][a-z0-9+.-]+:/", re.IGNORECASE)

_REPR = Repr()
_REPR.maxstring = _REPR.maxother = 300


def short_repr(value: object) -> str:
    """A value in messages: quoted, on one line, shortened."""
    return _REPR.repr(str(value) if isinstance(value, Path) else value)


def as_utf8(path: str) -> str:
    """A path that files of text can hold: bytes that are no UTF-8 become escapes."""
    return os.fsencode(path).decode(errors="backslashreplace")


def is_utf8(path: str) -> bool:
    """Whether a path has no bytes other than UTF-8."""
    return as_utf8(path) == path


def is_filled_file(file: Path) -> bool:
    """Whether a file is there and not empty, as the files of a machine that lost its power may be."""
    return file.is_file() and file.stat().st_size > 0


def check_path(path: object, argument: str) -> None:
    """Raise OptionError for a value of an argument that cannot be the path of a file."""
    if not isinstance(path, str | Path):
        raise OptionError(f"{argument}= has {short_repr(path)}, give paths as texts")
    try:
        is_possible = str(path) != "" and b"\0" not in os.fsencode(path)
    except UnicodeEncodeError:
        is_possible = False
    if not is_possible:
        raise OptionError(f"{argument}= has {short_repr(path)}, which no file can be called")


def one_line_reason(exception: BaseException) -> str:
    """The reason of an exception on one line: the operating system's text, the message, or the exception's name."""
    text = getattr(exception, "strerror", None) or str(exception) or type(exception).__name__
    return " ".join(str(text).split())[:300]


def check_input_file(path: str | Path, what: str, error: type[PiantaError], *, folder: Path | None = None) -> Path:
    """The path of a regular file that exists, has content and may be read.

    what: the noun for the file in messages, such as "map".
    folder: of a relative path; None for the working directory, or the user's home after a leading ~/.

    Raises error, in one line, for a web address, a missing, empty or unreadable file, a folder and a device.
    """
    if _ADDRESS.match(str(path)):
        raise error(f"{what} {short_repr(path)} is an address, download it first and give the file")
    expanded = Path(path).expanduser() if str(path).startswith("~/") else Path(path)
    file = expanded if folder is None else folder / path
    fault = _find_input_fault(file)
    if fault:
        raise error(f"{what} {short_repr(file)} {fault}")
    return file


def make_write_error(path: str | Path, reason: OSError) -> WriteError:
    """The error of a file or folder that the system does not write; to be raised from the reason."""
    return WriteError(f"cannot write {short_repr(path)}: {_add_remedy(reason)}")


def describe_lack(error: OSError) -> str:
    """What the system refuses, and the remedy for what it may lack."""
    return f"the system refuses: {_add_remedy(error)}"


def _add_remedy(error: OSError) -> str:
    return f"{one_line_reason(error)}; {LACKS[error.errno]}" if error.errno in LACKS else one_line_reason(error)


def is_disk_full(error: BaseException) -> bool:
    """Whether an error is that of a full disk."""
    reason = error.__cause__ if isinstance(error, WriteError) else error
    return isinstance(reason, OSError) and reason.errno in FULL


def _find_input_fault(file: Path) -> str | None:
    """Why a file cannot be read, as the end of a message that begins with its name; None if it can."""
    try:
        status = file.stat()
    except (FileNotFoundError, NotADirectoryError):
        return "does not exist, check the path"
    except (OSError, ValueError) as exception:
        return f"cannot be opened: {one_line_reason(exception)}"
    if stat.S_ISDIR(status.st_mode):
        return "is a folder, give a file"
    if not stat.S_ISREG(status.st_mode):
        return "is a device or pipe, give a regular file"
    if status.st_size == 0:
        return "is empty, write it again"
    return None if os.access(file, os.R_OK) else "may not be read, check its permissions"


def check_cell_count(sizes: Sequence[int], what: str, *, max_cells: int) -> None:
    """Raise MapError for more than max_cells cells, before memory is allocated for them."""
    if prod(sizes) > max_cells:
        size = f"{' × '.join(map(str, sizes))} = {prod(sizes)}"
        raise MapError(f"{what} has {size} cells, the limit is {max_cells}; lift it with max_cells=")


def check_byte_count(count: int, error: type[PiantaError], *, max_bytes: int) -> None:
    """Raise error for a file of more than max_bytes; the message follows the name of the file."""
    if count > max_bytes:
        raise error(f"it has {count} bytes, the limit is {max_bytes}; give a smaller file")


def find_output_fault(file: Path, *, remedy: str = "give the name of a file") -> str | None:
    """Why a file must not be written, as the end of a message that begins with its name; None if it may.

    A device or pipe that exists would be replaced: /dev/null of the system, for one.
    """
    try:
        mode = file.stat().st_mode
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as exception:
        return f"cannot be written: {one_line_reason(exception)}"
    if stat.S_ISDIR(mode):
        return f"is a folder, {remedy}"
    return None if stat.S_ISREG(mode) else f"is a device or pipe, {remedy}"


@contextmanager
def atomic_file(path: str | Path) -> Iterator[Path]:
    """A temporary path, with the folder and suffix of `path`, which is renamed to `path` if the block succeeds.

    If the block fails, even by KeyboardInterrupt, `path` stays as it was and the temporary file is removed.
    Temporary names are random, so that the remains of a killed process are never in the way.

    Raises WriteError, in one line, for every OSError of the block, and PiantaError if `path` is a folder, device or
    pipe.
    """
    path = Path(path)
    temporary = path.parent / f".pianta-{token_hex(8)}{path.suffix}"
    try:
        fault = find_output_fault(path)
        if fault:
            raise PiantaError(f"cannot write {short_repr(path)}: it {fault}")
        yield temporary
        temporary.replace(path)
    except OSError as exception:
        raise make_write_error(path, exception) from exception
    finally:
        with suppress(OSError):
            temporary.unlink()


def real_path(path: str | Path) -> Path:
    """The path without links, to compare files; unlike by Path.resolve, a link to itself is no error."""
    return Path(os.path.realpath(path))


def is_folder(path: Path) -> bool:
    """Whether a path is a folder; False for one that the system refuses, whose reader says why."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def count_noun(number: int, noun: str) -> str:
    """A number with its noun: "1 room", "2 rooms"."""
    return f"{number} {noun}{'s' * (number != 1)}"
