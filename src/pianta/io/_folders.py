"""Output folders: checked before the work starts, and written completely at its end or not at all."""

from __future__ import annotations

import os
import re
import signal
import threading
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from itertools import count
from pathlib import Path
from secrets import token_hex
from shutil import rmtree

from pianta.errors import OptionError, PiantaError
from pianta.io._files import find_output_fault, one_line_reason, short_repr

MAX_LISTED = 3  # older outputs in a message
_REMAINS = re.compile(r"\.pianta-[0-9a-f]{16}")


def check_output_folder(folder: Path) -> None:
    """Raise OptionError, in one line, for a folder that cannot be created or written into."""
    try:
        # The root always exists, and so does "." of a relative path.
        existing = next(path for path in (folder, *folder.parents) if path.exists())
    except (OSError, ValueError) as exception:
        raise OptionError(f"output folder {short_repr(folder)} cannot be used: {one_line_reason(exception)}") from None
    if not existing.is_dir():
        raise OptionError(f"output folder {short_repr(folder)}: {short_repr(existing)} is a file, give another folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise OptionError(
            f"output folder {short_repr(folder)}: {short_repr(existing)} may not be written, check its permissions"
        )


@contextmanager
def atomic_folder(folder: Path) -> Iterator[Path]:
    """A temporary folder; if the block succeeds, its files move into `folder`, over older files of the same names.

    If the block fails, even by KeyboardInterrupt, `folder` stays as it was, or is not created. A new folder appears
    with all its files at once, even if the process is killed.

    Raises PiantaError, in one line, for every OSError of the block and if a folder has the name of a file.
    """
    new_folders = [path for path in (folder, *folder.parents) if not path.exists()]
    is_new = folder in new_folders
    temporary = (folder.parent if is_new else folder) / f".pianta-{token_hex(8)}"
    try:
        temporary.mkdir(parents=True)
        yield temporary
        if is_new and not folder.exists():
            temporary.rename(folder)
            return
        moves = {file: folder / file.name for file in sorted(temporary.iterdir())}
        for target in moves.values():
            fault = find_output_fault(target, remedy="give another output folder")
            if fault:
                raise PiantaError(f"cannot write {short_repr(target)}: it {fault}")
        with _without_interrupts():
            for file, target in moves.items():
                file.replace(target)
    except OSError as exception:
        raise PiantaError(f"cannot write into {short_repr(folder)}: {one_line_reason(exception)}") from exception
    finally:
        rmtree(temporary, ignore_errors=True)
        for path in new_folders:
            with suppress(OSError):  # not empty if the block succeeded
                path.rmdir()


def remove_remains(folder: Path) -> None:
    """Remove what a killed process has left in a folder of results."""
    for remains in folder.glob(".pianta-*") if folder.is_dir() else ():
        if _REMAINS.fullmatch(remains.name):
            rmtree(remains, ignore_errors=True)


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """A block that Ctrl+C does not end; KeyboardInterrupt comes after it."""
    # Python interrupts the main thread alone, and not in the background of a shell, where the signal is ignored
    is_ignored = signal.getsignal(signal.SIGINT) == signal.SIG_IGN
    if is_ignored or threading.current_thread() is not threading.main_thread():
        yield
        return
    interrupts: list[object] = []
    before = signal.signal(signal.SIGINT, lambda *_: interrupts.append(None))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)
    if interrupts:
        raise KeyboardInterrupt


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """A block in which no other pianta corrects the floor in a folder, on systems and disks that have locks."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    with ExitStack() as opened:
        # A folder that is gone is found by the block
        with suppress(OSError, ValueError):
            descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            opened.callback(os.close, descriptor)
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield


def check_output_file(file: Path, noun: str) -> None:
    """Refuse, before any work, a file that cannot be written; messages call it by the noun, such as "JSON file".

    Raises OptionError, in one line.
    """
    check_output_folder(file.parent)
    fault = find_output_fault(file)
    if fault:
        raise OptionError(f"{noun} {short_repr(file)} {fault}")


def number_outputs(stem: str, total: int, out: Path | None) -> list[str]:
    """Names STEM-001, STEM-002, … for as many outputs.

    Raises OptionError, in one line, for a folder that cannot be written, or has other STEM files, which would stay.
    """
    names = [f"{stem}-{number:0{max(3, len(str(total)))}}" for number in range(1, total + 1)]
    if out is None:
        return names
    check_output_folder(out)
    others = {file.stem for file in out.glob(f"{stem}-*.*")} - set(names) if out.is_dir() else set()
    if others:
        listed = ", ".join(sorted(others)[:MAX_LISTED]) + (", …" if len(others) > MAX_LISTED else "")
        raise OptionError(f"folder {short_repr(out)} has other {stem}s, {listed}; remove them or give another folder")
    return names


def choose_names(short: Sequence[str], long: Sequence[str]) -> list[str]:
    """A name for each output, all different: the short one; if that repeats, the long one; then with a number.

    Names that differ in case alone count as equal, as on some disks.
    """
    occurrences = Counter(name.casefold() for name in short)
    names: dict[str, str] = {}
    for short_name, long_name in zip(short, long, strict=True):
        name = short_name if occurrences[short_name.casefold()] == 1 else long_name
        numbered = (name if number == 1 else f"{name}-{number}" for number in count(1))
        free = next(candidate for candidate in numbered if candidate.casefold() not in names)
        names[free.casefold()] = free
    return list(names.values())
