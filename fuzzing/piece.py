"""A piece of fuzzing in a process of its own; see fuzz.py.

python fuzzing/piece.py TARGET FOLDER INPUTS SEED OUT, or --list
"""

from __future__ import annotations

import json
import os
import random
import resource
import signal
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from types import FrameType

from fuzz import COMMAND_MEMORY, COMMAND_SECONDS, COMMANDS, MEMORY, SECONDS

sys.path.insert(0, str(Path(__file__).parent))

try:
    import atheris
except ImportError:
    atheris = None

if atheris is not None and "--list" not in sys.argv:
    # Readers are small; instrumenting all of pianta with its layouts would slow the start
    with atheris.instrument_imports(include=["pianta.io"], enable_loader_override=False):
        import targets
else:
    import targets

from pianta.errors import PiantaError  # after the instrumented imports

MAX_LENGTH = 100_000  # bytes of an input
REPORT_EVERY = 50


class TooSlowError(BaseException):
    """An input has taken too long; no reader catches it."""


def _stop(_signal: int, _frame: FrameType | None) -> None:
    raise TooSlowError


class Piece:
    """Reads inputs, and keeps those that a reader neither reads nor refuses."""

    def __init__(self, name: str, target: targets.Target, folder: Path, out: Path) -> None:
        self.name, self.target, self.folder, self.out = name, target, folder, out
        self.count, self.findings = 0, list[str]()
        self.file = folder / f"input{target.suffix}"
        is_command = name == COMMANDS
        self.seconds, self.memory = (COMMAND_SECONDS, COMMAND_MEMORY) if is_command else (SECONDS, MEMORY)
        self.known: set[str] = set()

    def read(self, content: bytes) -> None:
        """Read an input."""
        self.count += 1
        self.file.write_bytes(content)
        (self.folder / "last_input").write_bytes(content)
        signal.alarm(self.seconds)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                self.target.read(self.file)
        except PiantaError as error:
            signal.alarm(0)
            if "\n" in str(error):
                self._keep(content, "a message of several lines", error)
        except TooSlowError as error:
            self._keep(content, f"more than {self.seconds} s", error)
        except MemoryError as error:
            signal.alarm(0)
            self._keep(content, f"more than {self.memory / 2**30:.0f} GiB", error)
        except Exception as error:  # what is looked for
            signal.alarm(0)
            self._keep(content, type(error).__name__, error)
        finally:
            signal.alarm(0)
        if self.count % REPORT_EVERY == 0:
            self.report()

    def _keep(self, content: bytes, what: str, error: BaseException) -> None:
        """Keep an input unless one with the same fault at the same line is kept."""
        lines = [frame for frame in traceback.extract_tb(error.__traceback__) if "pianta" in frame.filename]
        where = f"{Path(lines[-1].filename).name}:{lines[-1].lineno}" if lines else "?"
        finding = f"{what} at {where}: {' '.join(str(error).split())[:120]}"
        if f"{what} at {where}" in self.known:
            return
        self.known.add(f"{what} at {where}")
        self.findings.append(finding)
        digest = sha256(f"{what} at {where}".encode()).hexdigest()[:8]
        (self.out / f"{self.name}-{digest}{self.target.suffix}").write_bytes(content)
        (self.out / f"{self.name}-{digest}.log").write_text("".join(traceback.format_exception(error)), "utf-8")

    def report(self) -> None:
        """Write what was read so far, for the parent."""
        (self.folder / "report.json").write_text(json.dumps([self.count, self.findings]), encoding="utf-8")


def mutate(content: bytes, seeds: tuple[bytes, ...], rng: random.Random) -> bytes:
    """An input with some pieces changed, cut out, repeated, or taken from another input."""
    data = bytearray(content)
    for _ in range(1 + int(rng.expovariate(0.6))):
        start = rng.randrange(len(data) + 1)
        stop = min(len(data), start + int(rng.expovariate(0.1)) + 1)
        choice = rng.randrange(8)
        if choice == 0 and data:
            data[min(start, len(data) - 1)] = rng.randrange(256)
        elif choice == 1:
            del data[start:stop]
        elif choice == 2:
            data[start:start] = data[start:stop] * rng.choice((1, 2, 50, 1000))
        elif choice == 3:
            data[start:stop] = rng.choice(
                (b"-1", b"0", b"1e999", b"NaN", b"99999999999999999999", b"\xff\xfe", b"null")
            )
        elif choice == 4:
            other = rng.choice(seeds)
            begin = rng.randrange(len(other) + 1)
            data[start:stop] = other[begin : begin + int(rng.expovariate(0.02))]
        elif choice == 5:
            data[start:stop] = rng.randbytes(stop - start)
        elif choice == 6 and data:
            data[min(start, len(data) - 1)] ^= 1 << rng.randrange(8)
        else:
            data[start:stop] = bytes(reversed(data[start:stop]))
    return bytes(data[:MAX_LENGTH])


def run_randomly(read: Callable[[bytes], None], seeds: tuple[bytes, ...], inputs: int, seed: int) -> None:
    """Read mutations of the seeds, and of what came from them."""
    rng = random.Random(seed)  # noqa: S311  # no secret
    pool = list(seeds)
    for _ in range(inputs):
        content = mutate(rng.choice(pool), seeds, rng)
        if rng.random() < 0.02:
            pool.append(content)
        read(content)


def run_guided(read: Callable[[bytes], None], seeds: tuple[bytes, ...], inputs: int, seed: int, folder: Path) -> None:
    """Read what Atheris makes of the seeds; it ends the process."""
    corpus = folder / "corpus"
    corpus.mkdir()
    for number, content in enumerate(seeds):
        (corpus / str(number)).write_bytes(content)
    arguments = [sys.argv[0], f"-runs={inputs}", f"-seed={seed}", f"-max_len={MAX_LENGTH}", "-timeout=0", str(corpus)]
    atheris.Setup(arguments, read)
    atheris.Fuzz()


def main() -> None:
    """Run a piece."""
    if "--list" in sys.argv:
        with tempfile.TemporaryDirectory() as folder:
            sys.stdout.write(" ".join(targets.list_targets(Path(folder))) + "\n")
        return
    name, folder, inputs, seed, out = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]), sys.argv[5]
    target = targets.list_targets(folder)[name]
    signal.signal(signal.SIGALRM, _stop)
    piece = Piece(name, target, folder, Path(out))
    resource.setrlimit(resource.RLIMIT_AS, (piece.memory, piece.memory))
    for content in target.seeds:
        piece.read(content)
    os.chdir(folder)
    guided = atheris is not None and name != COMMANDS and seed % 2
    if guided:
        run_guided(piece.read, target.seeds, inputs, seed, folder)
    else:
        run_randomly(piece.read, target.seeds, inputs, seed)
    piece.report()


if __name__ == "__main__":
    main()
