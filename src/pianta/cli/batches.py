"""What the verbs that work on many files have in common: options, progress, faults, and counts at the end."""

from __future__ import annotations

import gc
import math
import os
import signal
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from types import FrameType
from typing import Annotated, TypedDict

import typer

from pianta.batch.journal import has_journal
from pianta.batch.run_batch import BatchItem
from pianta.cli.terminal import BatchBar, counting_batch, print_error, print_result
from pianta.errors import OptionError, PiantaError
from pianta.io._files import count_noun, short_repr
from pianta.reading.read import MAX_JOBS, name_folders

PAUSE = 1.0  # s between two signals that end a program; the second one ends it also where the first is dropped
GARBAGE_THRESHOLD = 700  # new objects after which Python collects garbage, its own default

Jobs = Annotated[
    int, typer.Option(min=1, max=MAX_JOBS, help="Processes for several files; the results are the same for any number.")
]
Resume = Annotated[
    bool, typer.Option("--resume/--no-resume", help="Of several files, skip those that OUT has, if they are unchanged.")
]
RetryFailed = Annotated[bool, typer.Option("--retry-failed", help="Of several files, only those that have failed.")]
Shard = Annotated[
    str | None, typer.Option(metavar="I/N", help="Only the Ith of N parts of the files, each on another machine.")
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS|FILE",
        help="Dask scheduler, or the file that it has written; its workers do the work instead of --jobs.",
    ),
]
TimeLimit = Annotated[
    float | None,
    typer.Option(metavar="S", min=0.1, help="Seconds for a file, with --jobs from 2 on; it fails if it needs more."),
]


class RunArguments(TypedDict):
    """The arguments of functions for batches that say how they are run."""

    jobs: int
    resume: bool
    only_failed: bool
    shard: str | None
    time_limit: float | None
    scheduler: str | None


@dataclass(frozen=True)
class BatchFlags:
    """The options of the command line that say how a batch is run."""

    jobs: int
    resume: bool
    retry_failed: bool
    shard: str | None
    time_limit: float | None
    scheduler: str | None

    @property
    def batch_only(self) -> list[str]:
        """Those that were given of the flags for batches alone."""
        values = {
            "--retry-failed": self.retry_failed,
            "--shard": self.shard,
            "--time-limit": self.time_limit,
            "--scheduler": self.scheduler,
        }
        return [flag for flag, value in values.items() if value]

    @property
    def arguments(self) -> RunArguments:
        """The arguments of `read_batch` and others."""
        return {
            "jobs": self.jobs,
            "resume": self.resume,
            "only_failed": self.retry_failed,
            "shard": self.shard,
            "time_limit": self.time_limit,
            "scheduler": self.scheduler,
        }


@dataclass(frozen=True)
class BatchWords:
    """What a batch is called. noun: of an item, such as "file". done, does: such as "read" and "reads"."""

    noun: str
    done: str
    does: str


def run_batch(
    start: Callable[[BatchBar], Iterator[BatchItem]],
    words: BatchWords,
    list_lines: Callable[[BatchItem], list[str]],
    *,
    quiet: bool,
    keep: Callable[[BatchItem], BatchItem] = lambda item: item,
) -> list[BatchItem]:
    """All items of a batch, which is followed on the terminal; print its counts.

    start: starts the batch, given what shows its progress. list_lines: what is printed of an item that was done now.
    keep: what is kept of an item.
    """
    # Garbage of hours would fill the memory with the threshold that __main__ sets for short commands
    gc.set_threshold(GARBAGE_THRESHOLD)
    items: list[BatchItem] = []
    with (
        ending_by_signal() as interrupts,
        counting_batch(noun=f"{words.noun}s", quiet=quiet) as bar,
    ):
        for item in start(bar):
            items.append(keep(item))
            if interrupts:  # Python drops the exception of Ctrl+C in some of its own functions
                raise KeyboardInterrupt
            if item.fault is not None:
                print_error(PiantaError(item.fault))
                bar.add_failure()
            elif item.is_new and not quiet:
                for line in list_lines(item):
                    print_result(line)
    if not quiet:
        _print_counts(items, words)
    return items


@contextmanager
def ending_by_signal() -> Iterator[list[int]]:
    """A block that SIGTERM, of a cluster whose time is over, ends as Ctrl+C does: with its processes.

    So does SIGHUP, of a terminal that is closed, unless `nohup` has it ignored. The list has what Ctrl+C sends. Signals
    that follow at once are one: another exception would end what ends the processes.
    """
    interrupts: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield interrupts
        return

    last = -math.inf

    def end(number: int, frame: FrameType | None) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last < PAUSE:
            return
        last = now
        if number == signal.SIGINT:
            interrupts.append(number)
            signal.default_int_handler(number, frame)
        sys.exit(128 + number)

    numbers = [signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else [])]
    before = {number: signal.getsignal(number) for number in numbers if signal.getsignal(number) != signal.SIG_IGN}
    for number in before:
        signal.signal(number, end)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        before[signal.SIGINT] = signal.default_int_handler
        signal.signal(signal.SIGINT, end)
    try:
        yield interrupts
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def refuse_batch(out: Path, path: str) -> None:
    """Raise OptionError for a folder with the results of a batch, in which those of one file would be lost."""
    if has_journal(out):
        fault = f"folder {short_repr(out)} has the results of a batch; give {short_repr(path)} a folder of its own"
        (name,) = name_folders([path])
        # Beside it: what is in it belongs to the batch
        beside = Path(os.path.abspath(out)) if out.name in {"", ".."} else out  # noqa: PTH100 - as `name_file`
        stem = f"{beside.name}-{name}"
        numbered = (beside.with_name(stem if number == 1 else f"{stem}-{number}") for number in count(1))
        raise OptionError(f"{fault}, such as -o {short_repr(next(each for each in numbered if not each.exists()))}")


def exit_if_any_failed(items: list[BatchItem]) -> None:
    """End with exit code 1 if an item has a fault."""
    if any(item.fault is not None for item in items):
        raise typer.Exit(1)


def _print_counts(items: list[BatchItem], words: BatchWords) -> None:
    """How many items were done, now and before, and how many have failed for which kind of reason."""
    failed = Counter(item.group for item in items if item.fault is not None)
    before = sum(not item.is_new for item in items)
    line = f"{len(items) - failed.total()} of {count_noun(len(items), words.noun)} {words.done}"
    if before:
        line += f", {before} of them before; --no-resume {words.does} them again"
    print_result(line)
    if failed.total() > 1:
        listed = ", ".join(f"{group} {count}" for group, count in failed.most_common())
        print_result(f"faults: {listed}")
