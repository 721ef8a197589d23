"""Work on many items on a Dask cluster: workers of any machines that see the same files."""

from __future__ import annotations

import logging
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import islice
from math import inf
from pathlib import Path
from secrets import token_hex
from threading import Thread
from typing import Any, TypeVar

from distributed import Client, Future, KilledWorker, Worker, WorkerPlugin, as_completed, get_worker

from pianta import __version__
from pianta.batch.processes import QUEUED_PER_JOB, Fault, Outcome, describe_fault, limit_threads, work_in_worker
from pianta.errors import OptionError
from pianta.io._files import one_line_reason, short_repr

Item = TypeVar("Item")
Result = TypeVar("Result")

SECONDS_TO_CONNECT = 20
MAX_TRIES = 5  # of a call to all workers, which fails if one of them ends meanwhile
PAUSE = 0.5  # s between two of them
SECONDS_TO_LEAVE = 5  # for workers that do not answer at the end
SECONDS_TO_END = 600  # for what workers still do for a program that was killed

# On a worker: how many items of each batch it works on; those of a killed program, too
_running: Counter[str] = Counter()


def run_on_cluster(
    work: Callable[[Item], Result], items: Sequence[Item], *, scheduler: str, batch: str = ""
) -> Iterator[Outcome[Item, Result]]:
    """The outcome of each item, in the order in which they end.

    scheduler: the address of a Dask scheduler, such as tcp://host:8786, or the file that it has written. batch: a name.
    What workers still do for a killed program of the same batch is waited for: its results would replace newer ones.
    Workers may come and go. The item of one that ends runs on another one; if it ends several workers, it has failed.
    Raises OptionError if the scheduler does not answer, or its workers are others than pianta needs.
    """
    with _connect(scheduler) as client:
        _wait_for_running(client, batch)
        plugin = _WorkPlugin(work, batch or token_hex(8))
        _call_workers(lambda: client.register_plugin(plugin))
        waiting, running = iter(enumerate(items)), as_completed(loop=client.loop)
        numbers: dict[str, int] = {}
        count_threads = _ThreadCount(client)

        def submit() -> None:
            for number, item in islice(waiting, max(0, QUEUED_PER_JOB * count_threads() - len(numbers))):
                future = client.submit(_run_item, plugin.name, batch, item, pure=False)
                numbers[future.key] = number
                running.add(future)

        try:
            submit()
            for future in running:
                yield _collect(future, items[numbers.pop(future.key)], scheduler)
                submit()
        finally:
            _call_briefly(lambda: client.unregister_worker_plugin(plugin.name))


def check_scheduler(scheduler: str) -> None:
    """Raise OptionError if a scheduler does not answer, or its workers are others than pianta needs."""
    with _connect(scheduler):
        pass


class _WorkPlugin(WorkerPlugin):  # type: ignore[misc]  # of a library without types
    """Gives the work to each worker, also to those that start later: it has megabytes of models.

    That of a killed program of the same batch is replaced.
    """

    def __init__(self, work: Callable[[Any], Any], batch: str) -> None:
        self.name = f"pianta {batch}"
        self.work = work

    def setup(self, worker: Worker) -> None:
        """Keep the work in a worker, which has one thread."""
        limit_threads(1)
        for callback in _list_profilers(worker):
            callback.stop()
        setattr(worker, self.name, self.work)

    def teardown(self, worker: Worker) -> None:
        """Forget it."""
        delattr(worker, self.name)
        for callback in _list_profilers(worker):
            callback.start()


class _ThreadCount:
    """Counts the threads of all workers, of which some come and go; at least one, and asked for once a second."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._number, self._asked = 1, -inf

    def __call__(self) -> int:
        """The number."""
        if time.monotonic() > self._asked + 1:
            self._number = max(1, sum(self._client.nthreads().values()))
            self._asked = time.monotonic()
        return self._number


def _list_profilers(worker: Worker) -> list[Any]:
    """What samples the stack of a worker's tasks: Dask keeps an hour of it, half a megabyte for each map."""
    return [callback for name, callback in worker.periodic_callbacks.items() if name.startswith("profile")]


def _run_item(name: str, batch: str, item: Any) -> Any:  # noqa: ANN401  # of any batch
    """On a worker: the outcome of an item. name: of the plugin that has brought the work."""
    _running[batch] += 1
    try:
        return work_in_worker(getattr(get_worker(), name), item)
    finally:
        _running[batch] -= 1


def _is_running(batch: str) -> bool:
    """On a worker: whether it works on a batch."""
    return _running[batch] > 0


def _wait_for_running(client: Client, batch: str) -> None:
    """Wait until no worker works on a batch for another program; at most SECONDS_TO_END."""
    deadline = time.monotonic() + SECONDS_TO_END
    while batch and time.monotonic() < deadline:
        answers = _call_workers(lambda: client.run(_is_running, batch, on_error="ignore"))
        if not any(answers.values()):
            return
        time.sleep(PAUSE)


def _call_workers(call: Callable[[], Result]) -> Result:
    """The answer of a call to all workers, which is tried again if a worker ends meanwhile."""
    for _ in range(MAX_TRIES - 1):
        with suppress(OSError):
            return call()
        time.sleep(PAUSE)
    return call()


def _call_briefly(call: Callable[[], object]) -> None:
    """Call workers, of which one may not answer, at the end of a batch."""

    def attempt() -> None:
        with suppress(Exception):  # of a scheduler that is gone
            call()

    thread = Thread(target=attempt, daemon=True)
    thread.start()
    thread.join(SECONDS_TO_LEAVE)


def _collect(future: Future, item: Item, scheduler: str) -> Outcome[Item, Any]:
    """The outcome of a future; OptionError if the scheduler is gone."""
    if future.status in {"lost", "cancelled"}:
        raise _is_gone(scheduler)
    if future.status == "finished":
        outcome: Outcome[Item, Any] = future.result()
        future.release()  # else it is done again if the worker that has its result ends
        return outcome
    error = future.exception()
    if isinstance(error, KilledWorker):
        return Outcome(item, None, Fault("killed", "it ended several workers, see their logs"), 0.0)
    fault = describe_fault(error) if isinstance(error, Exception) else Fault("unforeseen", one_line_reason(error))
    return Outcome(item, None, fault, 0.0)


def _is_gone(scheduler: str) -> OptionError:
    remedy = "start it and its workers again, and give the same command; what was read is not read again"
    return OptionError(f"the Dask scheduler {short_repr(scheduler)} is gone, {remedy}")


@contextmanager
def _connect(scheduler: str) -> Iterator[Client]:
    """A client of a scheduler whose workers have one thread and this version of pianta."""
    is_file = "://" not in scheduler and Path(scheduler).is_file()
    where = {"scheduler_file": scheduler} if is_file else {"address": scheduler}
    # It prints tracebacks when a connection ends; what ended becomes one line
    for logger in ("distributed", "distributed.client"):  # the client has a level of its own
        logging.getLogger(logger).setLevel(logging.CRITICAL)
    try:
        client = Client(**where, timeout=SECONDS_TO_CONNECT, set_as_default=False)
    except (OSError, ValueError, TypeError, KeyError, AssertionError) as exception:
        reason = one_line_reason(exception) if is_file or ":" in scheduler else "there is no such file"
        fault = f"the Dask scheduler {short_repr(scheduler)} does not answer: {reason}"
        raise OptionError(f"{fault}; give its address, such as tcp://host:8786, or its --scheduler-file") from None
    try:
        with client:
            _check_workers(client, f"--scheduler-file {scheduler}" if is_file else scheduler)
            yield client
    except OSError:
        raise _is_gone(scheduler) from None


def _check_workers(client: Client, scheduler: str) -> None:
    """Raise OptionError for no workers, for some with several threads, and for other versions of pianta.

    scheduler: as `dask worker` takes it. Workers that were just started have SECONDS_TO_CONNECT to appear.
    """
    noun = f"the Dask scheduler {short_repr(scheduler)}"
    try:
        client.wait_for_workers(1, timeout=SECONDS_TO_CONNECT)
    except TimeoutError:
        command = f"dask worker {scheduler} --nthreads 1 --nworkers 2"
        raise OptionError(f"{noun} has no workers, start some: {command}") from None
    threads = client.nthreads()
    if max(threads.values()) > 1:
        raise OptionError(f"{noun} has workers with several threads, start them with --nthreads 1 and more --nworkers")
    answers = _call_workers(lambda: client.run(_read_version, on_error="ignore"))
    versions = set(answers.values()) - {__version__}
    if versions:
        raise OptionError(f"{noun} has workers with pianta {', '.join(sorted(versions))}, install {__version__} there")


def _read_version() -> str:
    """On a worker: its version of pianta."""
    return __version__
