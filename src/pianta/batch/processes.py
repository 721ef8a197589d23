"""Work on many items in processes: one that crashes, hangs or runs out of memory stops nothing."""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import threading
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.context import SpawnContext, SpawnProcess
from time import perf_counter
from traceback import format_exception
from types import FrameType
from typing import TYPE_CHECKING, ClassVar, Generic, TypeVar

from pianta.errors import OptionError, PiantaError
from pianta.io._files import describe_lack, is_disk_full, one_line_reason
from pianta.io._folders import remove_open_folders

if TYPE_CHECKING:
    from pebble import ProcessPool

Item = TypeVar("Item")
Result = TypeVar("Result")

MAX_TRIES = 2  # of an item whose process ended: another program may have killed it, or another item filled the memory
PARENT_PAUSE = 0.5  # s between two looks whether the program is there
FULL_DISK = "full disk"  # the group of a fault that items after it would have, too
MAX_BREAKS = 10  # in turn, of all processes, without an item that ends
QUEUED_PER_JOB = 2  # items that are handed out, so that no process waits, and memory does not grow with the batch


@dataclass(frozen=True)
class Fault:
    """Why an item has no result.

    group: what faults are counted by: the noun of a PiantaError, such as "map", or "killed", "time", "memory",
    "unforeseen". message: one line. report: the traceback of an unforeseen fault.
    """

    group: str
    message: str
    report: str = ""


@dataclass(frozen=True)
class Outcome(Generic[Item, Result]):
    """An item with its result or its fault; seconds: of its last try."""

    item: Item
    result: Result | None
    fault: Fault | None
    seconds: float


def run_items(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    jobs: int,
    time_limit: float | None = None,
) -> Generator[Outcome[Item, Result]]:
    """The outcome of each item, in the order in which they end.

    work: a function of a module, which processes can import. jobs: processes; with 1 the items run in this one, where
    nothing can end a hanging item. time_limit: seconds for an item, None for no limit.
    """
    if jobs == 1:
        for item in items:
            yield guard_item(work, item)
        return
    end_in_start()
    yield from _run_in_processes(work, items, jobs, time_limit)


def end_in_start() -> None:
    """End a process that starts, if the program would start processes in it: it has no `if __name__ == "__main__":`."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        os._exit(1)


def guard_item(work: Callable[[Item], Result], item: Item) -> Outcome[Item, Result]:
    """The outcome of an item; its exceptions, but not Ctrl+C, are faults."""
    start = perf_counter()
    result, fault = None, None
    try:
        result = work(item)
    except Exception as error:  # whatever is unforeseen in an item must not end the batch
        fault = describe_fault(error)
    return Outcome(item, result, fault, perf_counter() - start)


def work_in_worker(work: Callable[[Item], Result], item: Item) -> Outcome[Item, Result]:
    """The outcome of an item as of guard_item, in a process that has many of them: it frees what one has left.

    Figures of matplotlib are cycles that hold megabytes, and Python would keep hundreds of them.
    """
    outcome = guard_item(work, item)
    gc.collect()
    if not gc.get_freeze_count():
        # Of the models and modules that the first item has loaded nothing will be garbage
        gc.freeze()
    return outcome


def describe_fault(error: Exception) -> Fault:
    """The fault of an exception; that of a PiantaError is its own line."""
    if is_disk_full(error):
        return Fault(FULL_DISK, describe_lack(error) if isinstance(error, OSError) else str(error))
    if isinstance(error, PiantaError):
        # A reader of plans that failed in its own process gives its traceback as a note
        report = "\n".join(getattr(error, "__notes__", []))
        return Fault("unforeseen" if report else type(error).__name__.removesuffix("Error").lower(), str(error), report)
    if isinstance(error, MemoryError):
        return Fault("memory", "it needs more memory than there is, read it on a larger machine")
    reason = " ".join(str(error).split())[:200]
    message = f"an unforeseen fault, {type(error).__name__}{reason and ': '}{reason}"
    return Fault("unforeseen", message, "".join(format_exception(error)))


def _run_in_processes(
    work: Callable[[Item], Result], items: Sequence[Item], jobs: int, time_limit: float | None
) -> Iterator[Outcome[Item, Result]]:
    """The outcomes from processes; one that ends is replaced, and its item tried again.

    Raises OptionError if processes end again and again while they start.
    """
    waiting = [*reversed(range(len(items)))]
    tries: Counter[int] = Counter()
    breaks = 0
    while waiting:
        running: dict[Future[Outcome[Item, Result]], int] = {}
        with _open_pool(jobs) as pool:
            # A process that is killed while it starts breaks the pool; what ran in it runs in the next one
            while pool.active and (waiting or running):
                while waiting and len(running) < QUEUED_PER_JOB * jobs:
                    try:
                        future = pool.schedule(work_in_worker, args=[work, items[waiting[-1]]], timeout=time_limit)
                    except RuntimeError:  # it broke meanwhile
                        break
                    running[future] = waiting.pop()
                done, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    index = running.pop(future)
                    outcome = _collect(future, items[index], time_limit)
                    if outcome is None:
                        waiting.append(index)
                        continue
                    breaks, tries[index] = 0, tries[index] + 1
                    if outcome.fault and outcome.fault.group == "killed" and tries[index] < MAX_TRIES:
                        waiting.append(index)
                    else:
                        yield outcome
        waiting += sorted(running.values(), reverse=True)
        breaks += 1
        if breaks > MAX_BREAKS:
            fault = f"{MAX_BREAKS} times in turn processes ended while they started"
            raise OptionError(f"{fault}; put the program under `if __name__ == '__main__':`, or give jobs=1")


class _Process(SpawnProcess):
    """A process that Ctrl+C does not interrupt, also while it starts: the program ends it."""

    def start(self) -> None:
        if not hasattr(signal, "pthread_sigmask"):
            super().start()
            return
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Context(SpawnContext):
    """Starts such processes."""

    Process: ClassVar[type[SpawnProcess]] = _Process


@contextmanager
def _open_pool(jobs: int) -> Iterator[ProcessPool]:
    """Processes that end with the block; what still runs then is not waited for: nothing of it is half-written.

    Raises OptionError if they cannot be started.
    """
    from pebble import ProcessPool

    # A forked process would inherit the locks that threads of OpenCV and BLAS hold
    threads = max(1, (os.cpu_count() or 1) // jobs)
    pool = ProcessPool(
        max_workers=jobs,
        context=_Context(),
        initializer=_prepare_process,
        initargs=[threads],
    )
    try:
        _start(pool)
        yield pool
    finally:
        pool.stop()
        pool.join()


def _start(pool: ProcessPool) -> None:
    """Start the processes of a pool. Raises OptionError if the system refuses them."""
    try:
        _ = pool.active
    except (BrokenProcessPool, OSError) as error:
        reason = one_line_reason(error.__cause__ or error)
        raise OptionError(f"processes cannot be started: {reason}; give jobs=1") from None


def _prepare_process(threads: int) -> None:
    """In a process: limit its threads, and end it when the program has been killed.

    It would write results later, over those of the program that is started again.
    """
    limit_threads(threads)
    signal.signal(signal.SIGTERM, _end)
    threading.Thread(target=_end_with_parent, args=[os.getppid()], daemon=True).start()


def _end(number: int, _frame: FrameType | None) -> None:
    """End a process without remains: at Ctrl+C, at the end of its time."""
    remove_open_folders()
    os._exit(128 + number)


def _end_with_parent(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(PARENT_PAUSE)
    os._exit(1)


def limit_threads(threads: int) -> None:
    """In a process: let OpenCV use its share of the cores, so that processes do not slow each other down."""
    import cv2

    cv2.setNumThreads(threads)


def _collect(
    future: Future[Outcome[Item, Result]], item: Item, time_limit: float | None
) -> Outcome[Item, Result] | None:
    """The outcome that a process gave, or how it ended; None if the pool broke, so that the item has no outcome."""
    from pebble import ProcessExpired

    try:
        return future.result()
    except (BrokenProcessPool, CancelledError):
        return None
    except TimeoutError:
        fault = Fault("time", f"it took longer than {time_limit:g} s")
    except ProcessExpired as error:
        fault = Fault("killed", f"its process ended with code {error.exitcode}, {MAX_TRIES} times")
    except Exception as error:  # such as a result that cannot be pickled
        fault = describe_fault(error)
    return Outcome(item, None, fault, time_limit or 0.0)
