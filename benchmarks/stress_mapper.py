"""A thousand updates of a mapper: its memory, and whether it goes on after it was killed.

    python benchmarks/stress_mapper.py [--updates 1000] [--kills 50]

A synthetic floor grows along x again and again, in a new building each time, so that every update changes something.
The mapper saves its state after each update. First without kills: the memory after a tenth of the updates, and at the
end. Then the process is killed (SIGKILL) at random moments, and another one loads the state and goes on; no state may
be damaged, and none may be older than the last one that was saved.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory
from time import sleep

import numpy as np

import pianta
from pianta.errors import PiantaError
from pianta.gridmap import UNKNOWN, GridMap
from pianta.mapping.mapper import Mapper

STEPS = 40  # updates in which a floor is revealed
FIRST_SHARE = 0.35  # of the columns of its map
KIBIBYTES_PER_MIB = 1024
LONGEST_LIFE = 12.0  # s of a process until it is killed


def main() -> None:
    """Measure memory, then kill."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--updates", type=int, default=1000)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--work", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.work is not None:
        work(arguments.work, arguments.updates)
        return
    with TemporaryDirectory() as folder:
        work(Path(folder), arguments.updates)
    with TemporaryDirectory() as folder:
        kill(Path(folder), arguments.updates, arguments.kills)


def work(folder: Path, updates: int) -> None:
    """Go on from the state in a folder until the last update; print the number of each once it is saved."""
    is_new = not (folder / "mapper.json").is_file()
    mapper = Mapper() if is_new else Mapper.load(folder)
    state = mapper.state
    done = 0 if state is None or state.time is None else int(state.time)
    for number in range(done + 1, updates + 1):
        mapper.update(reveal(number), time=number)
        mapper.save(folder)
        print(number, flush=True)
        if number in (updates // 10, updates):
            print(f"largest memory until update {number}: {measure_memory():.0f} MiB", file=sys.stderr)


def reveal(number: int) -> GridMap:
    """The map of an update: a floor of its own for each STEPS updates, seen from the left."""
    round_number, step = divmod(number - 1, STEPS)
    _, grid = pianta.make_world("corridor", seed=round_number)
    share = FIRST_SHARE + (1 - FIRST_SHARE) * step / (STEPS - 1)
    cells = np.full(grid.shape, UNKNOWN, np.int8)
    columns = round(share * grid.shape[1])
    cells[:, :columns] = grid.cells[:, :columns]
    return GridMap(cells, grid.resolution, grid.origin)


def measure_memory() -> float:
    """The largest memory of this process until now, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / KIBIBYTES_PER_MIB


def kill(folder: Path, updates: int, kills: int) -> None:
    """Kill processes at random moments, and load what each has left."""
    rng = np.random.default_rng(0)
    last, killed, starts = 0, 0, 0
    while last < updates:
        command = [sys.executable, __file__, "--work", str(folder), "--updates", str(updates)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
            starts += 1
            if killed < kills:
                sleep(rng.uniform(0, LONGEST_LIFE))
                process.kill()
                killed += 1
            printed, _ = process.communicate()
        numbers = [int(line) for line in printed.split() if line.isdecimal()]
        last = max([last, *numbers])
        check(folder, last)
    print(
        f"{killed} kills, {starts} starts, {updates} updates, no state damaged or older than the last one",
        file=sys.stderr,
    )


def check(folder: Path, last: int) -> None:
    """Stop if the state of a folder cannot be loaded, or is older than the last update that was saved."""
    if not last:
        return
    try:
        state = Mapper.load(folder).state
    except PiantaError as error:
        sys.exit(f"damaged after update {last}: {error}")
    if state is None or state.time is None or state.time < last:
        sys.exit(f"update {last} was saved, and the state is of {state and state.time}")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
