"""The journal of a batch: which files are done, which failed and why, in an SQLite file in the output folder."""

from __future__ import annotations

import os
import re
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import astuple, dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from pianta.batch.geoparquet import TABLES
from pianta.errors import OptionError
from pianta.io._files import one_line_reason, short_repr

JOURNAL = "journal.sqlite"
PATTERN = "journal*.sqlite"
FAULTS = "faults"  # the folder of reports on what was unforeseen, beside it
TABLE_FILES = tuple(f"{table}.parquet" for table in TABLES)  # of `pianta collect`, beside it
SUFFIXES = ("", "-wal", "-shm", "-journal")  # of a journal, and of what SQLite writes beside it
_NAME = re.compile(r"journal(?:-(?P<number>[0-9]+)-of-(?P<total>[0-9]+))?\.sqlite")
READ = "read"  # the verb of a journal, unless another is given
BEGUN = "begun"  # the group of an entry whose file may have results, of a batch that was ended before it was recorded
APPLICATION_ID = 0x7069616E  # "pian", in the header of the file
FORMAT = 2


@dataclass(frozen=True)
class Entry:
    """What became of a file.

    path: of the file. folder: of its results, in the output folder. inputs: sizes and times of the file and what it
    refers to. options: the digest of the options it was read with. version: of pianta. seconds: of the reading.
    group, fault: as of `Fault`, empty if it was read. description: JSON, of whoever reads.
    """

    path: str
    folder: str
    inputs: str
    options: str
    version: str
    seconds: float
    group: str = ""
    fault: str = ""
    description: str = ""

    @property
    def is_done(self) -> bool:
        """Whether the file was read."""
        return not self.group

    @property
    def is_failed(self) -> bool:
        """Whether the file was tried, and has a fault."""
        return self.group not in {"", BEGUN}


NO_SPACE = ("is full", "disk I/O error")  # of SQLite, if nothing more can be written

_CREATE = """create table if not exists entries (
    path text primary key, folder text not null, inputs text not null, options text not null, version text not null,
    seconds real not null, "group" text not null, fault text not null, description text not null)"""
_CREATE_ABOUT = "create table if not exists about (verb text not null)"
_RECORD = "insert or replace into entries values (?, ?, ?, ?, ?, ?, ?, ?, ?)"
_BEGIN = """insert into entries values (?, ?, '', '', '', 0.0, ?, '', '')
    on conflict (path) do update set folder = excluded.folder, inputs = ''"""
_FORGET = "delete from entries where path = ?"
_SELECT = """select path, folder, inputs, options, version, seconds, "group", fault, description
    from entries order by path"""


class Journal:
    """The journal of one batch, which one program at a time can write.

    verb: of the command whose batch it is; the journal of another one is refused. A new journal without an entry is
    removed at the end.

    Each entry is on the disk when `record` returns. The write-ahead log has no shared memory, so that the file may lie
    on a network disk.
    """

    def __init__(self, file: Path, verb: str = READ) -> None:
        self.file, self.verb = file, verb
        self._is_new = not file.exists()
        try:
            self._connection = sqlite3.connect(file, timeout=0, isolation_level=None)
        except sqlite3.Error as error:
            raise _as_option_error(file, error) from None
        try:
            self._open()
        except sqlite3.Error as error:
            self._connection.close()
            raise _as_option_error(file, error) from None
        except BaseException:  # also of a signal, after which an empty journal would stay
            self.__exit__(None, None, None)
            raise

    def _open(self) -> None:
        """Lock the file and check whose journal it is."""
        self._connection.execute("pragma locking_mode = exclusive")
        self._connection.execute("pragma journal_mode = wal")
        self._connection.execute("pragma synchronous = full")
        self._connection.execute("begin immediate")
        self._check_format()
        self._check_verb()
        self._connection.execute(_CREATE)
        self._connection.execute("commit")
        # Programs with another part of the batch read whose journal it is while this one writes
        self._connection.execute("pragma wal_checkpoint(truncate)")
        self._status = self.file.stat()

    def _check_format(self) -> None:
        (application,), (version,) = (
            self._connection.execute(f"pragma {name}").fetchone() for name in ("application_id", "user_version")
        )
        if (application, version) == (0, 0) and not self._connection.execute("select 1 from sqlite_master").fetchone():
            self._connection.execute(f"pragma application_id = {APPLICATION_ID}")
            self._connection.execute(f"pragma user_version = {FORMAT}")
        elif (application, version) != (APPLICATION_ID, FORMAT):
            self._connection.execute("rollback")
            raise OptionError(f"file {short_repr(self.file)} is no journal of this pianta, give another output folder")

    def _check_verb(self) -> None:
        self._connection.execute(_CREATE_ABOUT)
        verbs = [verb for (verb,) in self._connection.execute("select verb from about")]
        if not verbs:
            self._connection.execute("insert into about values (?)", [self.verb])
        elif not isinstance(verbs[0], str):
            raise sqlite3.DatabaseError("its command is damaged")
        elif verbs != [self.verb]:
            self._connection.execute("rollback")
            raise _is_of(verbs[0], self.file.parent)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, _type: type[BaseException] | None, _error: BaseException | None, _traceback: TracebackType | None
    ) -> None:
        is_unused = self._is_new and not self._has_entries()
        self._connection.close()
        if is_unused:
            remove_journal(self.file)

    def _has_entries(self) -> bool:
        try:
            return self._connection.execute("select 1 from entries").fetchone() is not None
        except sqlite3.Error:
            return True

    def read_entries(self) -> dict[str, Entry]:
        """The last entry of each file, by its path."""
        try:
            return {entry.path: entry for entry in _select_entries(self._connection)}
        except sqlite3.Error as error:
            raise _as_option_error(self.file, error) from None

    def forget(self, paths: Iterable[str]) -> None:
        """Remove the entries of files."""
        try:
            self._connection.execute("begin immediate")
            self._connection.executemany(_FORGET, [[path] for path in paths])
            self._connection.execute("commit")
        except sqlite3.Error as error:
            raise _as_option_error(self.file, error) from None

    def begin(self, folders: Mapping[str, str]) -> None:
        """Enter files whose results may be written from now on; those with an entry count as changed.

        folders: of the results, by the path of the file.
        """
        try:
            self._connection.execute("begin immediate")
            self._connection.executemany(_BEGIN, ([path, folder, BEGUN] for path, folder in folders.items()))
            self._connection.execute("commit")
        except sqlite3.Error as error:
            raise _as_option_error(self.file, error) from None

    def restore(self, entries: Mapping[str, Entry | None]) -> None:
        """Put back entries as they were before `begin`, by the path of their file; None removes one."""
        try:
            self._connection.execute("begin immediate")
            self._connection.executemany(_FORGET, ([path] for path, entry in entries.items() if entry is None))
            self._connection.executemany(_RECORD, (astuple(entry) for entry in entries.values() if entry is not None))
            self._connection.execute("commit")
        except sqlite3.Error as error:
            raise _as_option_error(self.file, error) from None

    def record(self, entry: Entry) -> None:
        """Write an entry, over the one before of the same file. Raises OptionError also if the journal was moved."""
        try:
            is_there = os.path.samestat(self.file.stat(), self._status)
        except OSError:
            is_there = False
        if not is_there:
            fault = f"folder {short_repr(self.file.parent)} was moved or removed while the batch was running"
            raise OptionError(f"{fault}; remove what is there now, move it back, and go on by the same command")
        try:
            self._connection.execute(_RECORD, astuple(entry))
        except sqlite3.Error as error:
            raise _as_option_error(self.file, error) from None


def name_journal(part: tuple[int, int] | None) -> str:
    """The file name of the journal of a batch; part: the number of the part and of all parts, None without parts."""
    return JOURNAL if part is None else f"journal-{part[0]}-of-{part[1]}.sqlite"


def has_journal(folder: Path) -> bool:
    """Whether a folder has the journal of a batch, or of a part of one."""
    return any(_NAME.fullmatch(file.name) for file in folder.glob(PATTERN))


def is_reserved(name: str) -> bool:
    """Whether a name in the folder of a batch is that of reports, a table, a journal, or what is beside a journal."""
    folded = name.casefold()
    return folded in {FAULTS, *TABLE_FILES} or any(_NAME.fullmatch(folded.removesuffix(suffix)) for suffix in SUFFIXES)


def remove_journal(file: Path) -> None:
    """Remove a journal."""
    for suffix in SUFFIXES:
        file.with_name(file.name + suffix).unlink(missing_ok=True)


def check_journals(folder: Path, part: tuple[int, int] | None, verb: str) -> None:
    """Raise OptionError if a folder has journals that do not know that of a batch, or those of another command.

    part: as of `name_journal`. Only other parts of the same number fit.
    """
    for file in sorted(folder.glob(PATTERN)):
        match = _NAME.fullmatch(file.name)
        total = match and match["total"]
        if not match or file.name == name_journal(part):
            continue
        if total is None:
            fault = f"the journal of a batch without parts, {JOURNAL}; leave out shard=,"
        elif part is None or int(total) != part[1]:
            fault = f"the journal of one of {total} parts, {file.name}; give shard= of as many,"
        else:
            other = _read_verb(file)
            if other not in {None, verb}:
                raise _is_of(str(other), folder)
            continue
        raise OptionError(f"folder {short_repr(folder)} has {fault} or give another folder")


def _read_verb(file: Path) -> str | None:
    """Whose journal a file is, which another program may be writing; None if unknown."""
    with suppress(sqlite3.Error), closing(_open_immutable(file)) as open_:
        return next((str(verb) for (verb,) in open_.execute("select verb from about")), None)
    return None


def read_siblings(folder: Path, part: tuple[int, int] | None) -> list[Entry]:
    """The entries of the journals of the other parts, without those that other programs have just written."""
    entries: list[Entry] = []
    for file in sorted(folder.glob(PATTERN)) if part else ():
        if file.name != name_journal(part):
            with suppress(sqlite3.Error), closing(_open_immutable(file)) as open_:
                entries += _select_entries(open_)
    return entries


def _open_immutable(file: Path) -> sqlite3.Connection:
    """A journal as it is, which another program may be writing."""
    return sqlite3.connect(f"{file.absolute().as_uri()}?immutable=1", uri=True)


def _is_of(verb: str, folder: Path) -> OptionError:
    return OptionError(f"folder {short_repr(folder)} has the journal of `pianta {verb}`, give another output folder")


def read_journals(folder: Path) -> list[Entry]:
    """The entries of all journals of a folder, in the order of their paths; of a file with several, one that was read.

    Raises OptionError without a journal, and for one that is damaged or being written.
    """
    files = sorted(file for file in folder.glob(PATTERN) if _NAME.fullmatch(file.name)) if folder.is_dir() else []
    if not files:
        raise OptionError(f"folder {short_repr(folder)} has no {JOURNAL}, read files into it first")
    entries: dict[str, Entry] = {}
    for file in files:
        for entry in _read_entries(file):
            if entry.path not in entries or entry.is_done:
                entries[entry.path] = entry
    return [entries[path] for path in sorted(entries)]


def _read_entries(file: Path) -> list[Entry]:
    """The entries of a journal, which may be on a disk that cannot be written. Raises OptionError."""
    unwritten = file.with_name(f"{file.name}-wal")
    if os.access(file, os.W_OK) and os.access(file.parent, os.W_OK):
        with Journal(file) as journal:
            return [*journal.read_entries().values()]
    try:
        if unwritten.exists() and unwritten.stat().st_size:
            raise sqlite3.OperationalError("a stopped batch has left entries beside it")
        with closing(_open_immutable(file)) as open_:
            return [*_select_entries(open_)]
    except sqlite3.Error as error:
        raise _as_option_error(file, error) from None


def _select_entries(connection: sqlite3.Connection) -> Iterator[Entry]:
    for row in connection.execute(_SELECT):
        entry = Entry(*row)
        if not _is_sound(entry):
            raise sqlite3.DatabaseError(f"the entry of {short_repr(entry.path)} is damaged")
        yield entry


def _is_sound(entry: Entry) -> bool:
    """Whether an entry has values as `record` writes them, and a folder that is in that of the batch."""
    texts = [entry.path, entry.folder, entry.inputs, entry.options, entry.version]
    texts += [entry.group, entry.fault, entry.description]
    if not (all(isinstance(text, str) for text in texts) and isinstance(entry.seconds, int | float)):
        return False
    return entry.folder not in {"", ".", ".."} and not {"/", "\0", os.sep}.intersection(entry.folder)


def _as_option_error(file: Path, error: sqlite3.Error) -> OptionError:
    if "locked" in str(error):
        return OptionError(
            f"journal {short_repr(file)} is in use by another pianta, wait for it or give another folder"
        )
    remedy = "remove it, and do all again with resume=False"
    if any(text in str(error) for text in NO_SPACE):
        remedy = "free space on its disk, and go on by the same command"
    elif not os.access(file.parent, os.W_OK) or (file.exists() and not os.access(file, os.R_OK | os.W_OK)):
        remedy = "check its permissions and those of its folder"
    return OptionError(f"journal {short_repr(file)} cannot be used: {one_line_reason(error)}; {remedy}")
