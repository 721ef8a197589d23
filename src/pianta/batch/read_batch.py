"""Read thousands of files: what is done stays done, and no file stops the others."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from inspect import signature
from pathlib import Path
from typing import Any, Unpack

from pianta import __version__
from pianta.batch.inputs import list_inputs
from pianta.batch.journal import JOURNAL, Entry, Journal
from pianta.batch.processes import Fault, Outcome, run_items
from pianta.errors import OptionError, PiantaError
from pianta.io._files import as_utf8, atomic_file, short_repr
from pianta.io._folders import check_output_folder, remove_remains
from pianta.reading._reader import Reader, ReadOptions
from pianta.reading.read import MAX_JOBS, name_folders, read
from pianta.reading.reading import Reading, check_corrections, check_output, list_input_files

FAULTS = "faults"  # the folder of reports on what was unforeseen
NO_DESCRIPTION = "null"  # JSON
_SHARD = re.compile(r"([1-9][0-9]{0,5})/([1-9][0-9]{0,5})")


@dataclass(frozen=True)
class BatchItem:
    """What became of a file of a batch.

    Attributes
    ----------
    path
        The file.
    folder
        Of its results.
    fault
        Why it could not be read, in one line; None if it was read.
    group
        What faults are counted by, such as "map", "plan", "time", "killed" and "unforeseen"; empty if it was read.
    seconds
        Of the reading.
    is_new
        Whether it was read now; False if the journal says that it was read before.
    description
        What `describe` returned for the reading; None without it.
    """

    path: Path
    folder: Path
    fault: str | None
    group: str
    seconds: float
    is_new: bool
    description: Any = None


def read_batch(
    paths: Iterable[str | Path],
    *,
    out: str | Path,
    jobs: int = 1,
    resume: bool = True,
    only_failed: bool = False,
    shard: str | None = None,
    time_limit: float | None = None,
    scheduler: str | None = None,
    walls: bool = False,
    graph: bool = False,
    describe: Callable[[Reading], Any] | None = None,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[ReadOptions],
) -> Iterator[BatchItem]:
    """Read the maps and plans of folders into a folder, with a journal of what is done.

    Parameters
    ----------
    paths
        Files as of `read`, folders, and patterns with `*`.
    out
        Each file gets a folder of its own in it, as of `Reading.save`; journal.sqlite is beside them.
    jobs
        Processes. From 2 on a process that crashes is replaced, and its file read once more.
    resume
        Whether files that the journal has as read, with these options and by this version, are not read again unless
        they have changed, or lack a description that is asked for.
    only_failed
        Whether only files are read that have failed.
    shard
        "2/8" for the second of eight parts of the files, each for another machine; which part a file belongs to
        depends on its absolute path alone. Each part has a journal of its own.
    time_limit
        Seconds for a file, from 2 jobs on; None for no limit.
    scheduler
        The address of a Dask scheduler, or the file that it has written: its workers read the files, which must be
        under the same paths there. None to read them on this machine.
    walls, graph
        As of `Reading.save`.
    describe
        A function of a module, which is called with each reading where it was read; it must return what JSON can hold.
    progress
        Called with the number of files that are done and of all, at the start and after each file.
    **options
        As of `read`, without a previous floor.

    Returns
    -------
    iterator of BatchItem
        First what was read before, then each file when it is done.

    Raises
    ------
    OptionError, ModelError, LabelError
        As of `read_all`, before the first file is read; the journal is of another program, or in use.

    Warns
    -----
    MapWarning, PlanWarning
        As of `read`, for each file.

    Examples
    --------
    >>> import pianta
    >>> pianta.make_world("corridor")[1].save("map.yaml")
    >>> [item.folder.name for item in pianta.read_batch(["."], out="buildings", labels=False)]
    ['map']
    >>> [item.is_new for item in pianta.read_batch(["."], out="buildings", labels=False)]
    [False]
    """
    if isinstance(paths, str | Path):
        raise OptionError(f"paths is {short_repr(paths)}, give a list of files and folders")
    if not 1 <= jobs <= MAX_JOBS:
        raise OptionError(f"jobs is {jobs}, give 1 to {MAX_JOBS}")
    if time_limit is not None and not time_limit > 0:
        raise OptionError(f"time_limit is {time_limit}, give seconds")
    if time_limit is not None and jobs == 1:
        raise OptionError("time_limit= ends processes, and one job needs none; give jobs=2 or more")
    if scheduler is not None and (jobs > 1 or time_limit is not None):
        raise OptionError("scheduler= has workers of its own, leave out jobs= and time_limit=")
    part = _parse_shard(shard)
    files = list_inputs(paths)
    if options.get("previous") is not None:
        raise OptionError(f"previous= is one floor and {len(files)} files are given, read each file on its own")
    target = Path(out)
    check_output_folder(target)
    reader = Reader.make(**options)
    batch = _Batch(target, _digest_options(options, walls=walls, graph=graph), describe)
    how = _How(jobs, resume, only_failed, time_limit, scheduler)
    return batch.run(files, _Work(reader, describe, walls, graph), part, how, progress)


@dataclass(frozen=True)
class _How:
    """jobs, resume, only_failed, time_limit, scheduler: as of `read_batch`."""

    jobs: int
    resume: bool
    only_failed: bool
    time_limit: float | None
    scheduler: str | None


@dataclass(frozen=True)
class _Item:
    """A file and the folder of its results.

    path: as it was given. key: the absolute path, in the journal. inputs: sizes and times, when it was listed.
    """

    path: Path
    key: str
    folder: Path
    inputs: str


@dataclass(frozen=True)
class _Result:
    """description: of the reading, JSON. warnings: that were issued."""

    description: str
    warnings: tuple[Warning, ...]


@dataclass(frozen=True)
class _Work:
    """What is done for each file, in a process."""

    reader: Reader
    describe: Callable[[Reading], Any] | None
    walls: bool
    graph: bool

    def __call__(self, item: _Item) -> _Result:
        """Read a file and write its results. Raises PiantaError."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            check_output(item.path, item.folder)
            check_corrections(item.folder)
            reading = self.reader.read(item.path)
            reading.save(item.folder, walls=self.walls, graph=self.graph)
        described = self.describe(replace(reading, folder=item.folder)) if self.describe else None
        issued = tuple(each.message for each in caught if isinstance(each.message, Warning))
        return _Result(json.dumps(described), issued)


@dataclass(frozen=True)
class _Batch:
    """The output folder of a batch. options: the digest of what changes results."""

    out: Path
    options: str
    describe: Callable[[Reading], Any] | None

    def run(
        self,
        files: Sequence[Path],
        work: _Work,
        part: tuple[int, int] | None,
        how: _How,
        progress: Callable[[int, int], None] | None,
    ) -> Iterator[BatchItem]:
        """Read what the journal does not have yet."""
        self.out.mkdir(parents=True, exist_ok=True)
        name = JOURNAL if part is None else f"journal-{part[0]}-of-{part[1]}.sqlite"
        with Journal(self.out / name) as journal:
            if part is None:
                remove_remains(self.out)
            entries = journal.read_entries()
            items = [item for item in self._name_items(files, entries) if part is None or _is_in(item.key, part)]
            done = [item for item in items if how.resume and self._is_done(item, entries.get(item.key))]
            keys = {item.key for item in done}
            left = [item for item in items if item.key not in keys]
            if how.only_failed:
                left = [item for item in left if item.key in entries and not entries[item.key].is_done]
            report = progress or (lambda _done, _all: None)
            report(0, len(left))
            for item in done:
                yield self._describe_entry(item, entries[item.key], is_new=False)
            for count, outcome in enumerate(_run(work, left, how), start=1):
                entry = self._make_entry(outcome)
                journal.record(entry)
                report(count, len(left))
                for warning in outcome.result.warnings if outcome.result else ():
                    warnings.warn(warning, stacklevel=2)
                yield self._describe_entry(outcome.item, entry, is_new=True)

    def _name_items(self, files: Sequence[Path], entries: Mapping[str, Entry]) -> Iterator[_Item]:
        """Each file with its folder: the one that the journal has, else a name that no other file has."""
        owners = {FAULTS: "", **{entry.folder.casefold(): path for path, entry in entries.items()}}
        for file, short_name in zip(files, name_folders(files), strict=True):
            key, name = as_utf8(str(file.absolute())), as_utf8(short_name)
            entry = entries.get(key)
            folder = entry.folder if entry else name
            number = 1
            while owners.get(folder.casefold(), key) != key:
                number += 1
                folder = f"{name}-{number}"
            owners[folder.casefold()] = key
            yield _Item(file, key, self.out / folder, _describe_inputs(file))

    def _is_done(self, item: _Item, entry: Entry | None) -> bool:
        """Whether a file was read as it is, with these options, and its results are there."""
        if entry is None or not entry.is_done or not item.folder.is_dir():
            return False
        if self.describe and entry.description == NO_DESCRIPTION:
            return False
        return (entry.inputs, entry.options, entry.version) == (item.inputs, self.options, __version__)

    def _make_entry(self, outcome: Outcome[_Item, _Result]) -> Entry:
        item, fault = outcome.item, outcome.fault
        return Entry(
            item.key,
            item.folder.name,
            item.inputs,
            self.options,
            __version__,
            round(outcome.seconds, 3),
            fault.group if fault else "",
            as_utf8(self._describe_fault(item, fault)) if fault else "",
            outcome.result.description if outcome.result else NO_DESCRIPTION,
        )

    def _describe_fault(self, item: _Item, fault: Fault) -> str:
        """The line of a fault; the report of an unforeseen one is written into a file, which it names."""
        if fault.group in ("time", "killed", "memory", "unforeseen"):
            line = f"file {short_repr(item.path)} cannot be read: {fault.message}"
        else:
            line = fault.message
        if not fault.report:
            return line
        report = self.out / FAULTS / f"{item.folder.name}.txt"
        try:
            report.parent.mkdir(exist_ok=True)
            with atomic_file(report) as new:
                new.write_text(f"pianta {__version__}\n{line}\n\n{fault.report}", encoding="utf-8", errors="replace")
        except (OSError, PiantaError):
            return line
        return f"{line}; report in {report}"

    def _describe_entry(self, item: _Item, entry: Entry, *, is_new: bool) -> BatchItem:
        fault = None if entry.is_done else entry.fault
        description = json.loads(entry.description) if self.describe else None
        return BatchItem(item.path, item.folder, fault, entry.group, entry.seconds, is_new, description)


def _run(work: _Work, items: Sequence[_Item], how: _How) -> Iterator[Outcome[_Item, _Result]]:
    """The outcome of each file, from processes of this machine or from a cluster."""
    if how.scheduler is None:
        return run_items(work, items, jobs=how.jobs, time_limit=how.time_limit)
    try:
        from pianta.batch.cluster import run_on_cluster
    except ImportError:
        raise OptionError("scheduler= needs Dask, install pianta[dask]") from None
    # Workers have working folders of their own
    absolute = [replace(item, path=item.path.absolute(), folder=item.folder.absolute()) for item in items]
    return run_on_cluster(work, absolute, scheduler=how.scheduler)


def _parse_shard(shard: str | None) -> tuple[int, int] | None:
    """The number of a part, and of all parts. Raises OptionError."""
    if shard is None:
        return None
    match = _SHARD.fullmatch(shard)
    number, total = map(int, match.groups()) if match else (1, 0)
    if number > total:
        raise OptionError(f"shard is {short_repr(shard)}, give 1/8 … 8/8 for eight parts")
    return number, total


def _is_in(key: str, part: tuple[int, int]) -> bool:
    """Whether a file belongs to a part, by the digest of its absolute path."""
    digest = int.from_bytes(sha256(key.encode()).digest()[:8])
    return digest % part[1] == part[0] - 1


def _describe_inputs(path: Path) -> str:
    """Sizes and times of a file and of the image that it names: if they change, it is read again."""
    described = []
    for file in list_input_files(path):
        try:
            status = file.stat()
            described.append(f"{file.name} {status.st_size} {status.st_mtime_ns}")
        except (OSError, ValueError):
            described.append(f"{file.name} missing")
    return as_utf8("; ".join(described))


def _digest_options(options: ReadOptions, *, walls: bool, graph: bool) -> str:
    """A digest of the options that change results, with the sizes and times of files among them."""
    defaults = {name: parameter.default for name, parameter in signature(read).parameters.items() if name != "path"}
    everything: dict[str, Any] = {**defaults, **options, "walls": walls, "graph": graph}
    described = {
        name: [str(value), _describe_inputs(Path(value))] if isinstance(value, Path) else value
        for name, value in everything.items()
    }
    return sha256(json.dumps(described, sort_keys=True, default=repr).encode()).hexdigest()[:16]
