"""Readers of untrusted plans in a child process: bounded in time and memory, without network and environment.

The libraries that parse PDF, SVG, DXF and IFC may crash, hang or fill the memory for a hostile file, and a fault in one
of them may run code of the file. The child has no variables of the environment, writes no files, starts no programs and
opens no connections, as far as the system and the audit events of Python can refuse them. What it answers is unpickled
by `_AnswerUnpickler`, which makes nothing but data.
"""

from __future__ import annotations

import ctypes
import json
import os
import pickle
import signal
import subprocess
import sys
import warnings
from contextlib import suppress
from dataclasses import dataclass, is_dataclass
from importlib import import_module
from io import BytesIO
from pathlib import Path
from traceback import format_exception
from types import MappingProxyType
from typing import Any

import pianta.errors
from pianta.errors import PiantaError, PlanError, PlanWarning
from pianta.io._files import one_line_reason
from pianta.io.drawings._layers import check_plan_file, plan_error


@dataclass(frozen=True)
class BoundedReader:
    """A reader and what it may take.

    function: MODULE:NAME; it takes the file and options. seconds: of the processor. memory: bytes of addresses.
    remedy: for a file that takes more.
    """

    function: str
    seconds: int
    memory: int
    remedy: str = "give one floor"


GIB = 2**30
_FOLDER = "pianta.io.drawings."
# Chosen by hand: several times what the largest plans of the data take
READERS = MappingProxyType(
    {
        "pdf": BoundedReader(_FOLDER + "pdf:read_document", 20, 2 * GIB, "give one floor, or the page as PNG"),
        "pages": BoundedReader(_FOLDER + "pdf:count_pages", 20, 2 * GIB),
        "svg": BoundedReader(_FOLDER + "svg:read_svg_plan", 60, 4 * GIB),
        "dxf": BoundedReader(_FOLDER + "dxf:read_dxf_plan", 120, 4 * GIB),
        "ifc": BoundedReader(_FOLDER + "ifc:read_ifc_plan", 600, 8 * GIB, "give a part of it"),
    }
)
NO_MEMORY = 3  # exit code of the child
CLOCK_FACTOR = 10  # of the seconds by the clock: on a busy machine those of the processor take longer
# Signals by which the system ends a process that takes too much
_LIMIT_SIGNALS = frozenset({"SIGXCPU", "SIGKILL"})
_KEPT_VARIABLES = ("LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "SYSTEMROOT")  # without which Python may not start
# Of Python's audit events: programs, and connections
_REFUSED_EVENTS = ("socket.", "subprocess.", "os.system", "os.exec", "os.fork", "os.posix_spawn", "os.spawn", "pty.")
_CHILD = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
_CHILD += "from pianta.io.drawings._child import answer_parent; answer_parent(int(sys.argv[2]), int(sys.argv[3]))"
# What an answer may hold besides dataclasses of pianta and plain values
_ANSWERS = frozenset(
    {
        ("numpy._core.multiarray", "_reconstruct"),
        ("numpy.core.multiarray", "_reconstruct"),
        ("numpy._core.multiarray", "scalar"),
        ("numpy.core.multiarray", "scalar"),
        ("numpy", "ndarray"),
        ("numpy", "dtype"),
        ("shapely.io", "from_wkb"),
        ("collections", "Counter"),
    }
)


@dataclass(frozen=True)
class _Answer:
    """What the child answers.

    result: of the reader. error: the class and the line of a PiantaError. crash: the traceback of another exception.
    warned: the lines of PlanWarnings.
    """

    result: Any = None
    error: tuple[str, str] | None = None
    crash: str = ""
    warned: tuple[str, ...] = ()


class _AnswerUnpickler(pickle.Unpickler):
    """Unpickles arrays, shapes and dataclasses of pianta alone."""

    def find_class(self, module: str, name: str) -> Any:  # noqa: ANN401  # as of pickle
        """A class that an answer may have; UnpicklingError for others."""
        class_ = (
            super().find_class(module, name) if (module, name) in _ANSWERS or module.startswith("pianta.") else None
        )
        if class_ is None or (module.startswith("pianta.") and not (isinstance(class_, type) and is_dataclass(class_))):
            raise pickle.UnpicklingError(f"an answer with {module}.{name}")
        return class_


def read_in_child(name: str, path: str | Path, **options: object) -> Any:  # noqa: ANN401  # readers differ
    """What a reader of READERS gives for a file and options, read in a child process.

    Raises the PiantaErrors of the reader, and PlanError if it takes more than it may, crashes, or fails in a way that
    it does not foresee; the traceback is then a note of the error.
    Warns as the reader.
    """
    reader, file = READERS[name], check_plan_file(path)
    request = pickle.dumps((reader.function, path, options))
    variables = {each: os.environ[each] for each in _KEPT_VARIABLES if each in os.environ}
    one_thread = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    arguments = [json.dumps(sys.path), str(reader.seconds), str(reader.memory)]
    try:
        child = subprocess.run(  # noqa: S603  # pianta itself, isolated from modules in the working folder
            [sys.executable, "-I", "-c", _CHILD, *arguments],
            input=request,
            capture_output=True,
            check=False,
            env=variables | one_thread,
            timeout=CLOCK_FACTOR * reader.seconds,
        )
    except subprocess.TimeoutExpired:
        raise _too_large(file, reader) from None
    except OSError as exception:
        raise plan_error(file, f"cannot be read in a child process: {one_line_reason(exception)}") from None
    _check_exit(child, file, reader)
    answer = _unpickle(child, file)
    for line in answer.warned:
        warnings.warn(line, PlanWarning, stacklevel=3)
    return answer.result


def _check_exit(child: subprocess.CompletedProcess[bytes], file: Path, reader: BoundedReader) -> None:
    """Raise PlanError for a child that ended before it answered."""
    code = child.returncode
    ended_by = signal.Signals(-code).name if code < 0 else ""
    if code == NO_MEMORY or ended_by in _LIMIT_SIGNALS:
        raise _too_large(file, reader)
    if ended_by:
        needs = f"it is damaged, or needs more than {reader.memory / GIB:.2g} GiB"
        raise plan_error(file, f"crashes its reader ({ended_by}), {needs}; save it again, or {reader.remedy}")


def _unpickle(child: subprocess.CompletedProcess[bytes], file: Path) -> _Answer:
    """The answer of a child; the errors in it are raised."""
    try:
        answer = _AnswerUnpickler(BytesIO(child.stdout)).load()
    except (pickle.UnpicklingError, EOFError, AttributeError, ImportError, IndexError) as exception:
        messages = child.stderr.decode(errors="replace").strip().splitlines() or [one_line_reason(exception)]
        raise plan_error(file, f"cannot be read in a child process: {messages[-1]}") from None
    if not isinstance(answer, _Answer):
        raise plan_error(file, "cannot be read in a child process: no answer")
    if answer.error is not None:
        error = getattr(pianta.errors, answer.error[0], PlanError)
        raise error(answer.error[1])
    if answer.crash:
        reason = answer.crash.strip().splitlines()[-1][:200]
        fault = plan_error(file, f"makes its reader fail, {reason}; save it again, or report it")
        fault.add_note(answer.crash)
        raise fault
    return answer


def _too_large(file: Path, reader: BoundedReader) -> PlanError:
    limits = f"{reader.seconds} s or {reader.memory / GIB:.2g} GiB"
    return plan_error(file, f"takes more than {limits} to read, {reader.remedy}")


def answer_parent(seconds: int, memory: int) -> None:
    """In the child process: bound it, read what stands in its input, and write an answer to its output."""
    function, path, options = pickle.load(sys.stdin.buffer)  # noqa: S301  # of the parent
    # What libraries print must not mix with the answer
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    module, _, name = function.partition(":")
    read = getattr(import_module(module), name)
    _bound_process(seconds, memory)
    try:
        answer = _answer(read, path, options)
    except MemoryError:
        os._exit(NO_MEMORY)
    with output:
        pickle.dump(answer, output)


def _answer(read: Any, path: str | Path, options: dict[str, Any]) -> _Answer:  # noqa: ANN401  # readers differ
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            result = read(path, **options)
        except PiantaError as error:
            return _Answer(error=(type(error).__name__, str(error)))
        except MemoryError:
            raise
        except Exception as error:  # whatever a hostile file provokes
            return _Answer(crash="".join(format_exception(error)))
    return _Answer(result, warned=tuple(str(each.message) for each in caught if issubclass(each.category, PlanWarning)))


def _bound_process(seconds: int, memory: int) -> None:
    """Limit this process, and cut it off from the network, files that it could write, and other programs."""
    with suppress(ImportError, OSError, ValueError):  # on Windows, and if the limits are lower already
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    with suppress(OSError, AttributeError):  # a namespace without network, where the system allows it
        new_user, new_network = 0x10000000, 0x40000000  # CLONE_NEWUSER, CLONE_NEWNET of sched.h
        ctypes.CDLL(None).unshare(new_user | new_network)
    sys.addaudithook(_refuse)


def _refuse(event: str, _arguments: tuple[object, ...]) -> None:
    """Raise PermissionError for events of Python that a reader has no use for."""
    if event.startswith(_REFUSED_EVENTS):
        raise PermissionError(f"a reader of plans may not use {event}")
