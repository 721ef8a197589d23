"""Many items of work, each with a folder of results: what is done stays done, and no item stops the others."""

from __future__ import annotations

import json
import os
import re
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import chain
from pathlib import Path
from types import ModuleType, NoneType
from typing import Any, Generic, TypeVar
from urllib.parse import unquote_to_bytes

from pianta import __version__
from pianta._arguments import check_argument
from pianta.batch.inputs import is_result_folder
from pianta.batch.journal import BEGUN, FAULTS, Entry, Journal, check_journals, is_reserved, name_journal, read_siblings
from pianta.batch.processes import FULL_DISK, Fault, Outcome, end_in_start, run_items
from pianta.errors import OptionError, PiantaError
from pianta.io._files import as_utf8, atomic_file, is_utf8, real_path, short_repr
from pianta.io._folders import new_folder, remove_remains
from pianta.io.building_folders import BUILDING_FILE
from pianta.reading.read import MAX_JOBS
from pianta.reading.reading import list_input_files, may_have_corrections

UNFORESEEN = ("time", "killed", "memory", "unforeseen")  # groups of faults whose message does not name the item
FILE_ADDRESS = "file://"
MAX_NAME_BYTES = 200  # of a folder, which with a number is shorter than the 255 of most disks
_SHARD = re.compile(r"([1-9][0-9]{0,5})/([1-9][0-9]{0,5})")

Value = TypeVar("Value")
Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class BatchItem:
    """What became of an item of a batch: of a file, a floor, or a part of the generated buildings.

    Attributes
    ----------
    path
        The file that was read; of generated buildings the folder.
    folder
        Of its results.
    fault
        Why there are no results, in one line; None if there are.
    group
        What faults are counted by, such as "map", "plan", "time", "killed" and "unforeseen"; empty without a fault.
    seconds
        Of the work.
    is_new
        Whether it was done now; False if the journal says that it was done before.
    description
        What the journal keeps of the results, such as what `describe` of `read_batch` returned; None without it.
    """

    path: Path
    folder: Path
    fault: str | None
    group: str
    seconds: float
    is_new: bool
    description: Any = None


@dataclass(frozen=True)
class WorkItem(Generic[Value]):
    """An item and the folder of its results.

    key: in the journal; for a file its absolute path. folder: of the results; another one if an item of before has it.
    files: what is read. inputs: their sizes and times, when it was listed: it is done again if they change. path: of
    the `BatchItem`. undone: what cannot be done, for faults, such as "file 'a.yaml' cannot be read". value: what the
    work takes.
    """

    key: str
    folder: Path
    files: tuple[Path, ...]
    inputs: str
    path: Path
    undone: str
    value: Value


@dataclass(frozen=True)
class WorkResult:
    """description: of the results, what JSON can hold. warnings: that were issued."""

    description: Any
    warnings: tuple[Warning, ...]


@dataclass(frozen=True)
class RunOptions:
    """How a batch is run: as of `read_batch`.

    Raises OptionError for options out of range or that do not fit together.
    """

    jobs: int = 1
    resume: bool = True
    only_failed: bool = False
    shard: str | None = None
    time_limit: float | None = None
    scheduler: str | None = None

    def __post_init__(self) -> None:
        check_argument(self.jobs, (int,), "jobs", "a number")
        check_argument(self.shard, (str, NoneType), "shard", "a text such as 2/8")
        check_argument(self.time_limit, (int, float, NoneType), "time_limit", "seconds")
        check_argument(self.scheduler, (str, NoneType), "scheduler", "an address or the name of a file")
        if not 1 <= self.jobs <= MAX_JOBS:
            raise OptionError(f"jobs is {self.jobs}, give 1 to {MAX_JOBS}")
        if self.time_limit is not None and not self.time_limit > 0:
            raise OptionError(f"time_limit is {self.time_limit}, give seconds")
        if self.time_limit is not None and self.jobs == 1:
            raise OptionError("time_limit= ends processes, and one job needs none; give jobs=2 or more")
        if self.scheduler is not None and (self.jobs > 1 or self.time_limit is not None):
            raise OptionError("scheduler= has workers of its own, leave out jobs= and time_limit=")
        if self.only_failed and not self.resume:
            raise OptionError("only_failed= and resume=False contradict each other, leave one out")
        _parse_shard(self.shard)
        if self.jobs > 1:
            end_in_start()

    @property
    def part(self) -> tuple[int, int] | None:
        """The number of the part that is done, and of all parts; None for all items."""
        return _parse_shard(self.shard)


@dataclass(frozen=True)
class Batch:
    """A batch in an output folder.

    verb: of the command. options: the digest of what changes results. results: files of which a folder of results has
    one. is_complete: whether an item has all results. describer: what makes the descriptions of results, empty for
    none; items with those of another one are done again.
    """

    out: Path
    verb: str
    options: str
    run: RunOptions
    results: Sequence[str]
    is_complete: Callable[[WorkItem[Any]], bool]
    describer: str = ""

    def do_all(
        self,
        listed: Sequence[WorkItem[Value]],
        work: Callable[[WorkItem[Value]], WorkResult],
        progress: Progress | None = None,
        *,
        check: Callable[[WorkItem[Value]], object] = lambda _: None,
    ) -> Iterator[BatchItem]:
        """Do what the journal does not have yet; first what was done before, then each item when it is done.

        work: a function of a module, which writes the results of an item. progress: takes the number of items that are
        done, and of all. check: refuses the folder of an item, before any work.
        """
        part = self.run.part
        with new_folder(self.out), self._open_journal(part) as journal:
            if part is None:
                remove_remains(self.out)
            entries = journal.read_entries()
            entries = {key: entry for key, entry in entries.items() if not self._is_unused(entry)}
            forgotten = self._list_forgotten(listed, entries)
            entries = {key: entry for key, entry in entries.items() if key not in forgotten}
            items = [*_choose_folders(listed, [*read_siblings(self.out, part), *entries.values()])]
            _check_folders(items)
            for item in items:
                check(item)
            items = [item for item in items if part is None or _is_in(item.key, part)]
            self._refuse_unknown(item.folder for item in items if item.key not in entries)
            done = [item for item in items if self.run.resume and self._is_done(item, entries.get(item.key))]
            done_keys = {item.key for item in done}
            left = [item for item in items if item.key not in done_keys]
            if self.run.only_failed:
                left = self._choose_failed(left, entries)
            if left and self.run.scheduler is not None:
                import_cluster().check_scheduler(self.run.scheduler)
            report = progress or (lambda _done, _all: None)
            report(0, len(left))
            if not left:
                journal.forget(forgotten)
            for item in done:
                yield self._describe_entry(item, entries[item.key], is_new=False)
            for count, (item, entry, issued) in enumerate(self._do(work, left, journal, entries), start=1):
                if count == 1:  # nothing is refused any more
                    journal.forget(forgotten)
                report(count, len(left))
                for warning in issued:
                    warnings.warn(warning, stacklevel=2)
                yield self._describe_entry(item, entry, is_new=True)

    def _is_unused(self, entry: Entry) -> bool:
        """Whether an item was begun and has left nothing, so that its folder is free."""
        return entry.group == BEGUN and not (self.out / entry.folder).exists()

    def _list_forgotten(self, listed: Sequence[WorkItem[Value]], entries: Mapping[str, Entry]) -> set[str]:
        """The keys of entries of files that are gone, which are forgotten without resuming.

        Corrections would lose their file, which may be on a disk that comes back.
        """
        if self.run.resume:
            return set()
        gone = {key for key in entries.keys() - {item.key for item in listed} if is_gone(key)}
        return {key for key in gone if not may_have_corrections(self.out / entries[key].folder)}

    def _do(
        self,
        work: Callable[[WorkItem[Value]], WorkResult],
        items: Sequence[WorkItem[Value]],
        journal: Journal,
        before: Mapping[str, Entry],
    ) -> Iterator[tuple[WorkItem[Value], Entry, Sequence[Warning]]]:
        """Do items; each with its entry, which is in the journal, and its warnings.

        before: the entries of earlier batches.
        """
        left = {item.key: (item.folder, self._describe_results(item.folder)) for item in items}
        # Results may be there before their entry says so, and must not be taken for those of another command
        journal.begin({key: folder.name for key, (folder, _) in left.items()})
        try:
            with closing(self._run_anywhere(work, items)) as outcomes:
                for outcome in outcomes:
                    if outcome.fault and outcome.fault.group == FULL_DISK:
                        raise OptionError(f"{outcome.fault.message}, and go on by the same command")
                    entry = self._make_entry(outcome)
                    journal.record(entry)
                    del left[entry.path]
                    yield outcome.item, entry, outcome.result.warnings if outcome.result else ()
        finally:
            # Workers of a cluster may still write results
            if self.run.scheduler is None:
                untouched = [
                    key for key, (folder, results) in left.items() if self._describe_results(folder) == results
                ]
                with suppress(OptionError):  # of a full disk, which has ended the batch
                    journal.restore({key: before.get(key) for key in untouched})

    def _describe_results(self, folder: Path) -> str:
        """What changes if the results in a folder are replaced."""
        return describe_files([folder, *(folder / name for name in self.results)])

    def _refuse_unknown(self, folders: Iterable[Path]) -> None:
        """Raise OptionError if folders of items without an entry have results, perhaps of another command.

        Without resuming they are replaced, but not what people have corrected.
        """
        unknown = [folder for folder in folders if folder.is_dir() and self._has_results(folder)]
        corrected = [folder for folder in unknown if may_have_corrections(folder)]
        if corrected:
            fault = f"folder {short_repr(corrected[0])} has corrections of a floor that the journal does not know"
            raise OptionError(f"{fault}; move it to another place, or give another output folder")
        if unknown and self.run.resume:
            fault = f"folder {short_repr(unknown[0])} has results that the journal does not know"
            others = f" (of {len(unknown)} such folders)" if len(unknown) > 1 else ""
            remedy = "move it to another place, or give resume=False and it is replaced"
            raise OptionError(f"{fault}{others}; {remedy}")

    def _has_results(self, folder: Path) -> bool:
        """Whether a folder has results, also of another command."""
        names = [file.name for file in folder.iterdir()]
        return not {*self.results, BUILDING_FILE}.isdisjoint(names) or is_result_folder(names)

    def _open_journal(self, part: tuple[int, int] | None) -> Journal:
        check_journals(self.out, part, self.verb)
        return Journal(self.out / name_journal(part), self.verb)

    def _choose_failed(self, left: Sequence[WorkItem[Value]], entries: Mapping[str, Entry]) -> list[WorkItem[Value]]:
        """The items that have failed. Raises OptionError if they would not fit to those that are done."""
        folder = short_repr(self.out)
        if left and not entries:
            raise OptionError(f"folder {folder} has no journal yet, so nothing has failed; leave out only_failed=")
        before = [entries[item.key] for item in left if item.key in entries and entries[item.key].group != BEGUN]
        if any((entry.options, entry.version) != (self.options, __version__) for entry in before):
            fault = f"folder {folder} has results with other options or of another version"
            raise OptionError(f"{fault}; give the same options, or leave out only_failed= and all are done again")
        failed = [item for item in left if item.key in entries and entries[item.key].is_failed]
        if left and not failed:
            fault = f"nothing in folder {folder} has failed, and {len(left)} are still to be done"
            raise OptionError(f"{fault}; leave out only_failed=")
        return failed

    def _run_anywhere(
        self, work: Callable[[WorkItem[Value]], WorkResult], items: Sequence[WorkItem[Value]]
    ) -> Generator[Outcome[WorkItem[Value], WorkResult]]:
        """The outcome of each item, from processes of this machine or from a cluster."""
        run = self.run
        if run.scheduler is None:
            return run_items(work, items, jobs=run.jobs, time_limit=run.time_limit)
        # Workers have working folders of their own
        absolute = [replace(item, path=item.path.absolute(), folder=item.folder.absolute()) for item in items]
        relative = {item.key: item for item in items}
        outcomes = import_cluster().run_on_cluster(
            work, absolute, scheduler=run.scheduler, batch=f"{self.verb} {real_path(self.out)}"
        )
        return (replace(outcome, item=relative[outcome.item.key]) for outcome in outcomes)

    def _is_done(self, item: WorkItem[Value], entry: Entry | None) -> bool:
        """Whether an item was done as it is, with these options, and its results are all there."""
        if entry is None or not entry.is_done or not self.is_complete(item):
            return False
        if self.describer and not self._has_description(entry):
            return False
        return (entry.inputs, entry.options, entry.version) == (item.inputs, self.options, __version__)

    def _make_entry(self, outcome: Outcome[WorkItem[Value], WorkResult]) -> Entry:
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
            json.dumps({"by": self.describer, "value": outcome.result.description if outcome.result else None}),
        )

    def _has_description(self, entry: Entry) -> bool:
        """Whether an entry has a description of this batch's describer, which others cannot read."""
        try:
            description = json.loads(entry.description)
        except ValueError:
            return False
        return isinstance(description, dict) and description.get("by") == self.describer and "value" in description

    def _describe_fault(self, item: WorkItem[Value], fault: Fault) -> str:
        """The line of a fault; the report of an unforeseen one is written into a file, which it names."""
        line = f"{item.undone}: {fault.message}" if fault.group in UNFORESEEN else fault.message
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

    def _describe_entry(self, item: WorkItem[Value], entry: Entry, *, is_new: bool) -> BatchItem:
        fault = None if entry.is_done else entry.fault
        description = json.loads(entry.description)["value"] if self.describer else None
        return BatchItem(item.path, item.folder, fault, entry.group, entry.seconds, is_new, description)


def _choose_folders(items: Iterable[WorkItem[Value]], entries: Iterable[Entry]) -> Iterator[WorkItem[Value]]:
    """The items with their folders: those of their entries, else of a name that no other item has."""
    folders = {entry.path: entry.folder for entry in entries}
    owners = {folder.casefold(): key for key, folder in folders.items()}
    for item in items:
        name = as_utf8(item.folder.name).encode()[:MAX_NAME_BYTES].decode(errors="ignore")
        folder = folders.get(item.key, name)
        number = 1
        while is_reserved(folder) or owners.get(folder.casefold(), item.key) != item.key:
            number += 1
            folder = f"{name}-{number}"
        owners[folder.casefold()] = item.key
        yield replace(item, folder=item.folder.with_name(folder))


def _check_folders(items: Sequence[WorkItem[Value]]) -> None:
    """Raise OptionError if the folder of an item has files that are read, or is that of another item, by a link.

    Results would replace some of the files, and hide others from the next run.
    """
    folders: dict[Path, Path] = {}
    for file in chain.from_iterable(item.files for item in items):
        for parent in real_path(file).parents:
            folders.setdefault(parent, file)
    owners: dict[Path, Path] = {}
    for item in items:
        real = real_path(item.folder)
        if inside := folders.get(real):
            fault = f"file {short_repr(inside)} is in folder {short_repr(item.folder)}, in which the results of"
            raise OptionError(f"{fault} {short_repr(item.path)} would be; give another output folder")
        if (other := owners.setdefault(real, item.folder)) != item.folder:
            fault = f"folders {short_repr(other)} and {short_repr(item.folder)} are one folder"
            raise OptionError(f"{fault}; remove the link, or give another output folder")


def name_file(file: Path) -> str:
    """The key of a file: its absolute path, without `..` where that leads to the same file.

    A path with bytes that are no UTF-8 becomes a file: address, as escapes may be the name of another file.
    """
    absolute = Path(os.path.abspath(file))  # noqa: PTH100 - Path.resolve follows links, which machines may have others of
    named = absolute if real_path(absolute) == real_path(file) else file.absolute()
    return str(named) if is_utf8(str(named)) else named.as_uri()


def is_gone(key: str) -> bool:
    """Whether the file of a key, as of `name_file`, is not there any more."""
    is_address = key.startswith(FILE_ADDRESS)
    return not os.path.lexists(unquote_to_bytes(key.removeprefix(FILE_ADDRESS)) if is_address else key)


def describe_files(files: Iterable[Path]) -> str:
    """Sizes and times of files: if they change, what was computed from them is computed again."""
    described = []
    for file in files:
        try:
            status = file.stat()
            described.append(f"{file.name} {status.st_size} {status.st_mtime_ns}")
        except (OSError, ValueError):
            described.append(f"{file.name} missing")
    return as_utf8("; ".join(described))


def digest_options(options: Mapping[str, Any]) -> str:
    """A digest of options that change results, with sizes and times of files among them, and of those in folders."""
    described = {
        name: [str(value), describe_files(list_input_files(value))] if isinstance(value, Path) else value
        for name, value in options.items()
    }
    return sha256(json.dumps(described, sort_keys=True, default=repr).encode()).hexdigest()[:16]


def collect_warnings(work: Callable[[], Any]) -> WorkResult:
    """What a function returns, with the warnings that it issues; they are issued again where it counts."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        described = work()
    issued = tuple(each.message for each in caught if isinstance(each.message, Warning))
    json.dumps(described)  # what it cannot hold is a fault of the item, not of the batch
    return WorkResult(described, issued)


def import_cluster() -> ModuleType:
    """The module that runs items on a Dask cluster.

    Raises OptionError if Dask is not installed.
    """
    try:
        from pianta.batch import cluster
    except ImportError:
        raise OptionError("scheduler= needs Dask, install pianta[dask]") from None
    return cluster


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
    """Whether an item belongs to a part, by the digest of its key."""
    digest = int.from_bytes(sha256(key.encode()).digest()[:8])
    return digest % part[1] == part[0] - 1
