"""Output folders: checked before the work starts, and written completely at its end or not at all."""

from __future__ import annotations

import os
import re
import signal
import threading
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from hashlib import sha256
from itertools import count
from pathlib import Path
from secrets import token_hex
from shutil import rmtree

from pianta.errors import OptionError, PiantaError, WriteError
from pianta.io._files import find_output_fault, make_write_error, one_line_reason, short_repr

MAX_LISTED = 3  # older outputs in a message
GONE = ".gone-"  # before the name of a file that is to be removed
_DECIDED = re.compile(r"\.pianta-done-[0-9a-f]{16}")  # whose files are to be moved
_open_folders: set[Path] = set()  # temporary folders of this process
_TEMPORARY = re.compile(r"\.pianta-[0-9a-f]{16}")


def check_output_folder(folder: Path) -> None:
    """Raise OptionError, in one line, for a folder that cannot be created or written into."""
    parents = (folder, *folder.parents)
    try:
        with suppress(FileNotFoundError, NotADirectoryError):
            folder.lstat()  # refuses what no folder can be called
        dangling = next((path for path in parents if path.is_symlink() and not path.exists()), None)
        # The root always exists, and so does "." of a relative path.
        existing = next(path for path in parents if path.exists())
    except (OSError, ValueError) as exception:
        raise OptionError(f"output folder {short_repr(folder)} cannot be used: {one_line_reason(exception)}") from None
    if dangling:
        fault = f"{short_repr(dangling)} is a link to what does not exist"
        raise OptionError(f"output folder {short_repr(folder)}: {fault}, remove it or give another folder")
    if not existing.is_dir():
        raise OptionError(f"output folder {short_repr(folder)}: {short_repr(existing)} is a file, give another folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise OptionError(
            f"output folder {short_repr(folder)}: {short_repr(existing)} may not be written, check its permissions"
        )


@contextmanager
def new_folder(folder: Path) -> Iterator[None]:
    """A block for which a folder is created, with its parents; those that are empty after it are removed again."""
    new_folders = [path for path in (folder, *folder.parents) if not path.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    finally:
        _remove_empty(new_folders)


def _remove_empty(folders: Sequence[Path]) -> None:
    for folder in folders:
        with suppress(OSError):  # not empty, or not there
            folder.rmdir()


@contextmanager
def atomic_folder(folder: Path, *, optional: Sequence[str] = ()) -> Iterator[Path]:
    """A temporary folder; if the block succeeds, its files move into `folder`, over older files of the same names.

    Files in folders of it move into the folders of the same names.
    If the block fails, even by KeyboardInterrupt, `folder` stays as it was, or is not created. A new folder appears
    with all its files at once. In one that is there the files change together, too: the renaming of the temporary
    folder decides that they change, and if the process is killed while they move, `finish_changes` moves the others.
    optional: names of files, NAME or FOLDER/NAME, that are removed from `folder` if the block does not write them; so
    are folders that are empty after it.

    Raises WriteError, in one line, for every OSError of the block, and PiantaError if a folder has the name of a file.
    """
    new_folders = [path for path in (folder, *folder.parents) if not path.exists()]
    is_new, temporary = folder in new_folders, folder
    try:
        if is_new:
            folder.parent.mkdir(parents=True, exist_ok=True)
        else:
            finish_changes(folder)
            remove_remains(folder)
        with _locked_folder(folder.parent if is_new else folder, for_name=folder.name) as temporary:
            yield temporary
            if is_new and not folder.exists():
                temporary.rename(folder)
                return
            for file in _list_files(temporary):
                target = folder / file.relative_to(temporary)
                fault = find_output_fault(target, remedy="give another output folder")
                if fault:
                    raise PiantaError(f"cannot write {short_repr(target)}: it {fault}")
            for name in optional:
                if not (temporary / name).exists() and (folder / name).is_file():
                    mark = (temporary / name).with_name(f"{GONE}{Path(name).name}")
                    mark.parent.mkdir(parents=True, exist_ok=True)
                    mark.touch()
            with _without_interrupts():
                decided = temporary.rename(folder / f".pianta-done-{token_hex(8)}")
                _move_all(decided, folder)
    except OSError as exception:
        raise make_write_error(folder, exception) from exception
    except WriteError as error:
        # It names a file of the temporary folder
        raise WriteError(str(error).replace(str(temporary), str(folder))) from error.__cause__
    finally:
        _remove_empty(new_folders)


def finish_changes(folder: Path) -> None:
    """Move into a folder what a killed process had decided to write there; a file that changed since stays."""
    with suppress(OSError, ValueError):  # of a disk that is not to be written, whose reader sees what is there
        for decided in sorted(folder.glob(".pianta-done-*")):
            if not _DECIDED.fullmatch(decided.name):
                continue
            for file in _list_files(decided):
                with suppress(FileNotFoundError):
                    target = _find_target(file, decided, folder)
                    if target.stat().st_mtime_ns > file.stat().st_mtime_ns:
                        file.unlink()
            _move_all(decided, folder)


def _move_all(decided: Path, folder: Path) -> None:
    """Move the files of a folder into another one, and remove the folder; another process may do the same.

    A file .gone-NAME removes NAME.
    """
    with suppress(FileNotFoundError):
        for file in _list_files(decided):
            target = _find_target(file, decided, folder)
            with suppress(FileNotFoundError):
                if file.name.startswith(GONE):
                    target.unlink(missing_ok=True)
                    file.unlink()
                    _remove_empty([parent for parent in target.parents if folder in parent.parents])
                else:
                    target.parent.mkdir(parents=True, exist_ok=True)
                    file.replace(target)
        _remove_empty(sorted((path for path in decided.rglob("*") if path.is_dir()), reverse=True))
        decided.rmdir()


def remove_open_folders() -> None:
    """Remove the temporary folders of this process, which ends at once."""
    for folder in _open_folders:
        rmtree(folder, ignore_errors=True)


def _list_files(folder: Path) -> list[Path]:
    """The files in a folder and the folders in it, sorted."""
    return sorted(path for path in folder.rglob("*") if not path.is_dir())


def _find_target(file: Path, decided: Path, folder: Path) -> Path:
    """Where a file of a folder that is decided belongs."""
    return (folder / file.relative_to(decided)).with_name(file.name.removeprefix(GONE))


def remove_remains(folder: Path) -> None:
    """Remove the temporary folders that killed processes have left in a folder, and not those of living ones."""
    for remains in folder.glob(".pianta-*") if folder.is_dir() else ():
        if _TEMPORARY.fullmatch(remains.name):
            _remove_abandoned(remains)


@contextmanager
def _locked_folder(beside: Path, *, for_name: str) -> Iterator[Path]:
    """A temporary folder in another one, which is locked as long as the block lasts.

    for_name: of the folder for which it is; the next process that writes one of this name removes what is left.
    """
    usual = sha256(os.fsencode(for_name)).hexdigest()[:16]
    _remove_abandoned(beside / f".pianta-{usual}")
    temporary, descriptor = _make_locked(beside, usual)
    status = temporary.stat()
    _open_folders.add(temporary)
    try:
        yield temporary
    finally:
        _open_folders.discard(temporary)
        # After the block the name may be that of another process
        if _is_folder(status, temporary):
            rmtree(temporary, ignore_errors=True)
        if descriptor is not None:
            os.close(descriptor)


def _make_locked(beside: Path, usual: str) -> tuple[Path, int | None]:
    """A new temporary folder and what locks it; of the usual name, unless another process has that."""
    name = usual
    while True:
        temporary, name = beside / f".pianta-{name}", token_hex(8)
        with suppress(FileExistsError, BlockingIOError):
            temporary.mkdir()
            descriptor = _lock(temporary)
            if descriptor is None or _is_folder(os.fstat(descriptor), temporary):
                return temporary, descriptor
            # Another process has removed it before it was locked
            os.close(descriptor)


def _is_folder(status: os.stat_result, folder: Path) -> bool:
    """Whether a path leads to the folder that has a status."""
    try:
        return os.path.samestat(status, folder.stat())
    except OSError:
        return False


def _remove_abandoned(temporary: Path) -> None:
    """Remove a temporary folder unless a process has locked it."""
    with suppress(BlockingIOError):
        descriptor = _lock(temporary)
        if descriptor is not None:
            rmtree(temporary, ignore_errors=True)
            os.close(descriptor)


def _lock(folder: Path) -> int | None:
    """The descriptor that locks a folder until it is closed; None if it is not there, or on disks without locks.

    Raises BlockingIOError if another process has locked it.
    """
    try:
        import fcntl

        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except (ImportError, OSError):
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as exception:
        os.close(descriptor)
        if isinstance(exception, BlockingIOError):
            raise
        return None
    return descriptor


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
    check_other_outputs(stem, names, out)
    return names


def check_other_outputs(stem: str, names: Iterable[str], out: Path) -> None:
    """Raise OptionError, in one line, for a folder with STEM files of other names, which would stay."""
    others = {file.stem for file in out.glob(f"{stem}-*.*")} - set(names) if out.is_dir() else set()
    if others:
        listed = ", ".join(sorted(others)[:MAX_LISTED]) + (", …" if len(others) > MAX_LISTED else "")
        raise OptionError(f"folder {short_repr(out)} has other {stem}s, {listed}; remove them or give another folder")


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
