"""Fuzz readers and commands with mutated inputs, guided by coverage where Atheris is installed.

    python fuzzing/fuzz.py [TARGET ...] [--inputs 1000000] [--jobs N] [--seed S] [--out fuzzing/found]

The inputs are dealt to the targets by turns, in pieces that each run in a process of its own. A finding is an exception
other than PiantaError, a message of more than one line, more than 10 s, more than 2 GiB, or the end of the process. Its
input is written into OUT, one for each kind of exception and line of pianta; small ones belong into tests/found_inputs,
where a test reads them. At the end a table counts inputs, seconds and findings of each target; the exit code is 1 if
there are any.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

HERE = Path(__file__).parent
PIECE = 10_000  # inputs of a process
SECONDS = 10  # of the clock for an input
MEMORY = 2 * 2**30  # bytes of addresses that an input may take
# The same for a command, which also computes: its networks and their libraries reserve much more than they use
COMMANDS = "commands"
COMMAND_PIECE = 1000
COMMAND_SECONDS = 120
COMMAND_MEMORY = 12 * 2**30


def main() -> None:
    """Print a table of what was run and found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", metavar="TARGET")
    parser.add_argument("--inputs", type=int, default=1_000_000)
    parser.add_argument("--seconds", type=float, help="after which no piece starts")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--out", type=Path, default=HERE / "found")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    names = options.targets or list_names()
    end = time.monotonic() + options.seconds if options.seconds else float("inf")
    pieces = max(len(names), -(-options.inputs // PIECE))
    counts: Counter[str] = Counter()
    seconds: defaultdict[str, float] = defaultdict(float)
    findings_of: defaultdict[str, set[str]] = defaultdict(set)

    def run(piece: int) -> None:
        name = names[piece % len(names)]
        if time.monotonic() > end:
            return
        start = time.monotonic()
        done, findings = run_piece(
            name, min(COMMAND_PIECE if name == COMMANDS else PIECE, options.inputs), options.seed + piece, options.out
        )
        counts[name] += done
        seconds[name] += time.monotonic() - start
        findings_of[name] |= findings
        sys.stdout.write(f"piece {piece + 1} of {pieces}: {name}, {done} inputs, {len(findings)} findings\n")
        sys.stdout.flush()

    with ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(run, range(pieces)))
    for name in names:
        line = f"{name:14} {counts[name]:9,} inputs {seconds[name]:8.0f} s {len(findings_of[name]):3} findings"
        sys.stdout.write(f"{line}\n")
    sys.stdout.write(f"{'all':14} {counts.total():9,} inputs, seed {options.seed}\n")
    for name in names:
        for finding in sorted(findings_of[name]):
            sys.stdout.write(f"{name}: {finding}\n")
    sys.exit(1 if any(findings_of.values()) else 0)


def list_names() -> list[str]:
    """The names of the targets."""
    listed = subprocess.run([sys.executable, str(HERE / "piece.py"), "--list"], capture_output=True, check=True)
    return listed.stdout.decode().split()


def run_piece(name: str, inputs: int, seed: int, out: Path) -> tuple[int, set[str]]:
    """Inputs that a target has read, and its findings: a line each."""
    with TemporaryDirectory(prefix="pianta-fuzz-") as parent:
        # Commands may read all files of the folder above
        folder = str(Path(parent, "work"))
        Path(folder).mkdir()
        command = [sys.executable, str(HERE / "piece.py"), name, folder, str(inputs), str(seed), str(out)]
        done = subprocess.run(command, capture_output=True, check=False, cwd=folder)
        report = Path(folder) / "report.json"
        counted, findings = json.loads(report.read_text()) if report.exists() else (0, [])
        if done.returncode:
            last = Path(folder) / "last_input"
            lines = done.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
            finding = f"the process ended with {done.returncode}: {lines[-1][:200]}"
            (out / f"{name}-process-{seed}").write_bytes(last.read_bytes() if last.exists() else b"")
            findings = [*findings, finding]
        return counted, set(findings)


if __name__ == "__main__":
    main()
