"""Read thousands of files: what is done stays done, and no file stops the others."""

from __future__ import annotations

import marshal
import pickle
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from hashlib import sha256
from inspect import signature
from pathlib import Path
from typing import Any, Unpack

from pianta._arguments import check_argument
from pianta.batch.inputs import list_inputs
from pianta.batch.journal import READ
from pianta.batch.run_batch import (
    Batch,
    BatchItem,
    RunOptions,
    WorkItem,
    WorkResult,
    collect_warnings,
    describe_files,
    digest_options,
    name_file,
)
from pianta.corrections.corrections_file import FILE_NAME as CORRECTIONS
from pianta.errors import CorrectionError, FloorError, OptionError
from pianta.io._files import is_filled_file, short_repr
from pianta.io._folders import check_output_folder, finish_changes
from pianta.io.building_folders import BUILDING_FILE, read_storey_folders
from pianta.reading._reader import Reader, ReadOptions
from pianta.reading.read import name_folders, read
from pianta.reading.reading import OUTPUTS, UNCORRECTED, Reading, check_output, list_input_files, may_have_corrections

RESULTS = (OUTPUTS[0], BUILDING_FILE)
MARSHAL_VERSION = 2
FILE_OPTIONS = ("symbols", "words", "room_model", "building_model")  # of `read`, if they are texts


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
        they have changed, or lack a result or a description that is asked for. If not, results are also replaced of
        which the journal does not know from which file they are.
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
        As of `read_all`, before the first file is read; the journal is of another program, or in use; `out` has
        results or corrections that the journal does not know.

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
    if isinstance(paths, str | Path) or not isinstance(paths, Iterable):
        raise OptionError(f"paths is {short_repr(paths)}, give a list of files and folders")
    check_argument(out, (str, Path), "out", "a folder")
    run = RunOptions(jobs, resume, only_failed, shard, time_limit, scheduler)
    if describe is not None:
        _check_function(describe, is_sent=jobs > 1 or scheduler is not None)
    files = list_inputs([*paths])
    if options.get("previous") is not None:
        raise OptionError(f"previous= is one floor and {len(files)} files are given, read each file on its own")
    target = Path(out)
    check_output_folder(target)
    work = _Work(Reader.make(**options), describe, walls, graph)
    defaults = {name: parameter.default for name, parameter in signature(read).parameters.items() if name != "path"}
    named = {name: Path(value) for name, value in options.items() if name in FILE_OPTIONS and isinstance(value, str)}
    digest = digest_options({**defaults, **options, **named, "walls": walls, "graph": graph})
    items = [_make_item(file, target / name) for file, name in zip(files, name_folders(files), strict=True)]
    describer = "" if describe is None else _identify(describe)
    return Batch(target, READ, digest, run, RESULTS, _is_complete, describer).do_all(items, work, progress)


def _check_function(describe: Callable[[Reading], Any], *, is_sent: bool) -> None:
    """Raise OptionError for what is no function, and for one that cannot be sent to processes if it must be."""
    is_usable = callable(describe)
    if is_usable and is_sent:
        try:
            pickle.dumps(describe)
        except (pickle.PicklingError, AttributeError, TypeError):
            is_usable = False
    if not is_usable:
        raise OptionError(f"describe is {short_repr(describe)}, give a function of a module")


def _identify(describe: Callable[[Reading], Any]) -> str:
    """What distinguishes a function from others, such as those of other programs that have its name."""
    name = f"{describe.__module__}.{getattr(describe, '__qualname__', type(describe).__qualname__)}"
    code = getattr(describe, "__code__", None)
    if code is None:
        return f"{name} {describe!r}"
    # Later versions of marshal give other bytes for equal code
    content = marshal.dumps(code, MARSHAL_VERSION) + repr(getattr(describe, "__defaults__", None)).encode()
    return f"{name} {sha256(content).hexdigest()[:16]}"


def _make_item(file: Path, folder: Path) -> WorkItem[None]:
    inputs = list_input_files(file)
    undone = f"file {short_repr(file)} cannot be read"
    return WorkItem(name_file(file), folder, tuple(inputs), describe_files(inputs), file, undone, None)


def _is_complete(item: WorkItem[None]) -> bool:
    """Whether all results of a file are there, each with content."""
    try:
        storeys = read_storey_folders(item.folder)
    except FloorError:
        return False
    folders = [item.folder / name for name in storeys.titles] if storeys else [item.folder]
    files = [folder / name for folder in folders for name in OUTPUTS]
    corrected = [folder for folder in folders if (folder / CORRECTIONS).exists() or (folder / UNCORRECTED).exists()]
    files += [folder / name for folder in corrected for name in (CORRECTIONS, UNCORRECTED)]
    return all(map(is_filled_file, files))


@dataclass(frozen=True)
class _Work:
    """What is done for each file, in a process."""

    reader: Reader
    describe: Callable[[Reading], Any] | None
    walls: bool
    graph: bool

    def __call__(self, item: WorkItem[None]) -> WorkResult:
        """Read a file and write its results. Raises PiantaError."""
        return collect_warnings(lambda: self._read(item))

    def _read(self, item: WorkItem[None]) -> Any:  # noqa: ANN401  # what JSON can hold
        check_output(item.path, item.folder)
        check_output_folder(item.folder)
        finish_changes(item.folder)
        # What people have corrected in an older result is corrected in the new one
        reading = self._read_corrected(item) if may_have_corrections(item.folder) else self.reader.read(item.path)
        reading.save(item.folder, walls=self.walls, graph=self.graph)
        return self.describe(replace(reading, folder=item.folder)) if self.describe else None

    def _read_corrected(self, item: WorkItem[None]) -> Reading:
        """The reading of a file whose folder has corrections. Raises PiantaError if these do not fit."""
        folder = item.folder
        remedy = f"move folder {short_repr(folder)} to another place, and the file is read without its corrections"
        if not any((folder / name).exists() for name in (CORRECTIONS, UNCORRECTED)):
            fault = f"plan {short_repr(item.path)} has several storeys, of which some were corrected"
            raise OptionError(f"{fault}, and corrections of storeys are not applied again; {remedy}")
        if not (folder / CORRECTIONS).exists():
            raise OptionError(f"folder {short_repr(folder)} has {UNCORRECTED} without {CORRECTIONS}; {remedy}")
        try:
            return self.reader.keep(folder).read(item.path)
        except (FloorError, CorrectionError, OptionError) as error:
            raise type(error)(f"the corrections of {short_repr(item.path)} do not fit it: {error}; {remedy}") from None
