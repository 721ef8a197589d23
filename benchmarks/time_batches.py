"""Rate, memory and loss of batches: `pianta read FOLDER` on many made maps, some of them broken, with random kills.

Run: OMP_NUM_THREADS=1 python benchmarks/time_batches.py FOLDER [--maps 1000] [--broken 20] [--kills 300] [--dask]
     OMP_NUM_THREADS=1 python benchmarks/time_batches.py FOLDER --rounds 3 [--maps 450] [--dask]

The maps, made floors of mixed kinds and sizes, are written into FOLDER/maps if they are not there yet. They are read
with one process and with two, or with --dask by one and by two workers of a local cluster: the ratio of the rates
counts. They are then read with two while processes are killed at random moments: one process that reads, or the program
itself, which is started again. At the end

- each map must have all its results, byte for byte those of the run with one process,
- nothing that the journal had as read before a kill may have been read again,
- the broken maps, and no others, must have failed; apart from maps whose process was killed twice, which are named.

Memory is the resident one of the processes that read, sampled while they do, mean of the processes: the mean over the
last tenth of the batch, against the second tenth.

With --rounds, only rates are compared: the maps are divided into this number of parts, each of which one process reads,
then two, then two programs that share nothing. Where the speed of the machine changes within minutes, this is fairer;
that programs start counts more.
"""

from __future__ import annotations

import argparse
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from statistics import StatisticsError, mean

import numpy as np
import psutil

from pianta.batch.journal import FAULTS, JOURNAL
from pianta.reading.reading import OUTPUTS
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.scan import simulate_map

PAUSE = 0.1  # s between two looks at the processes


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--maps", type=int, default=1000)
    parser.add_argument("--broken", type=int, default=20)
    parser.add_argument("--kills", type=int, default=300)
    parser.add_argument("--rounds", type=int, default=0)
    parser.add_argument("--dask", action="store_true")
    options = parser.parse_args()
    maps = make_maps(options.folder / "maps", options.maps, options.broken)
    noun, runs = ("workers", on_cluster) if options.dask else ("jobs", with_jobs)
    if options.rounds:
        files = sorted(maps.iterdir())[: options.maps]
        compare_rates(files, options.folder / f"rounds-of-{noun}", runs, options.rounds)
        return
    seconds = {}
    for number in (1, 2):
        with runs([maps], number) as run:
            seconds[number] = time_batch(maps, options.folder / f"{noun}-{number}", run)
    share = seconds[1] / seconds[2] / 2
    sys.stdout.write(f"one {seconds[1]:.1f} s, two {seconds[2]:.1f} s: {share:.0%} of twice the rate\n")
    if options.kills:
        with runs([maps], 2) as run:
            kill_batch(options.folder / f"{noun}-killed", options.kills, run)
    last = f"{noun}-killed" if options.kills else f"{noun}-2"
    compare_results(options.folder / f"{noun}-1", options.folder / last)


def make_maps(folder: Path, count: int, broken: int) -> Path:
    """A folder with maps, the first of which are broken."""
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(count):
        file = folder / f"map-{number:05}.npz"
        if file.exists():
            continue
        if number < broken:
            file.write_bytes(np.random.default_rng(number).bytes(1000))
        else:
            rng = np.random.default_rng(number)
            floor = make_corridor_floor(length=float(rng.uniform(8, 60)), room_width=(3.0, 8.0), seed=number)
            simulate_map(floor, seed=number).save(file)
    return folder


@dataclass(frozen=True)
class Run:
    """How maps are read.

    name: for the lines. start: the program, given the folder of results. list_readers: the processes that read, given
    the program. replace_readers: starts new ones for those that have ended, if the program does not.
    """

    name: str
    start: Callable[[Path], subprocess.Popen[bytes]]
    list_readers: Callable[[subprocess.Popen[bytes]], list[psutil.Process]]
    replace_readers: Callable[[], None] = lambda: None


@contextmanager
def with_jobs(maps: Sequence[Path], jobs: int) -> Iterator[Run]:
    """Reading in processes of the program."""

    def list_readers(process: subprocess.Popen[bytes]) -> list[psutil.Process]:
        program = psutil.Process(process.pid)
        if jobs == 1:
            return [program]
        # The resource tracker of multiprocessing is a child too
        return [child for child in program.children(recursive=True) if "spawn_main" in " ".join(child.cmdline())]

    yield Run(f"--jobs {jobs}", lambda out: start_program(maps, out, "--jobs", str(jobs)), list_readers)


@contextmanager
def on_cluster(maps: Sequence[Path], workers: int) -> Iterator[Run]:
    """Reading by the workers of a local Dask cluster, programs that are started again when they end."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address=None) as cluster:
        address = cluster.scheduler_address
        running = [start_worker(address) for _ in range(workers)]

        def replace_readers() -> None:
            for index, worker in enumerate(running):
                if worker.poll() is not None:
                    running[index] = start_worker(address)

        yield Run(
            f"{workers} workers",
            lambda out: start_program(maps, out, "--scheduler", address),
            lambda _: [psutil.Process(worker.pid) for worker in running if worker.poll() is None],
            replace_readers,
        )
        for worker in running:
            worker.terminate()
            worker.wait()


def start_worker(scheduler: str) -> subprocess.Popen[bytes]:
    """A worker of a cluster, as a program."""
    options = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--memory-limit", "0"]
    command = [sys.executable, "-m", "distributed.cli.dask_worker", scheduler, *options]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def start_program(maps: Sequence[Path], out: Path, *options: str) -> subprocess.Popen[bytes]:
    """The program that reads the maps, files or folders."""
    command = [sys.executable, "-m", "pianta", "read", *map(str, maps), "-o", str(out), *options, "-q"]
    with out.with_suffix(".log").open("w") as log:
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=log)


def compare_rates(
    files: Sequence[Path], out: Path, runs: Callable[[Sequence[Path], int], AbstractContextManager[Run]], rounds: int
) -> None:
    """Print how near two processes and two programs come to twice the rate of one, over parts of the files."""
    shares: dict[str, list[float]] = {"two processes": [], "two programs": []}
    out.mkdir()
    for number in range(rounds):
        part = files[number::rounds]
        with runs(part, 1) as run:
            one = time_programs([run], out / f"{number}-one")
        with runs(part, 2) as run:
            two = time_programs([run], out / f"{number}-two")
        with with_jobs(part[::2], 1) as run, with_jobs(part[1::2], 1) as other:
            apart = time_programs([run, other], out / f"{number}-apart")
        shares["two processes"].append(one / two / 2)
        shares["two programs"].append(one / apart / 2)
        sys.stdout.write(f"{len(part)} maps: one {one:.1f} s, two {two:.1f} s, two programs {apart:.1f} s\n")
        sys.stdout.flush()
    for name, values in shares.items():
        sys.stdout.write(f"{name}: {np.mean(values):.0%} ± {np.std(values):.0%} of twice the rate of one\n")


def time_programs(runs: Sequence[Run], out: Path) -> float:
    """Seconds until the last of programs that start together ends."""
    out.mkdir()
    start = time.perf_counter()
    for program in [run.start(out / str(number)) for number, run in enumerate(runs)]:
        program.wait()
    return time.perf_counter() - start


def time_batch(maps: Path, out: Path, run: Run) -> float:
    """Seconds of a batch; prints the memory of the processes that read."""
    start, total = time.perf_counter(), sum(1 for _ in maps.iterdir())
    samples: list[tuple[int, float]] = []
    with run.start(out) as process:
        while process.poll() is None:
            with suppress(psutil.Error, StatisticsError):
                resident = mean(reader.memory_info().rss for reader in run.list_readers(process))
                samples.append((count_entries(out), resident))
            time.sleep(PAUSE)
    seconds = time.perf_counter() - start
    tenths = [[rss for done, rss in samples if low <= done / total < high] for low, high in ((0.1, 0.2), (0.9, 1.0))]
    first, last = (float(np.mean(each)) / 2**20 if each else float("nan") for each in tenths)
    sys.stdout.write(
        f"{run.name}: {total} maps, {total / seconds:.2f} a second; memory of a process {first:.0f} MiB in the second "
        f"tenth, {last:.0f} MiB in the last ({last / first - 1:+.0%})\n"
    )
    sys.stdout.flush()
    return seconds


def count_entries(out: Path) -> int:
    """Files of a batch with a folder of results."""
    return sum(1 for _ in out.iterdir()) if out.is_dir() else 0


def kill_batch(out: Path, kills: int, run: Run) -> None:
    """Read the maps while processes are killed, and check that nothing is half-written or read twice."""
    rng = np.random.default_rng(1)
    process, left, starts, again = run.start(out), kills, 1, 0
    done: dict[str, float] = {}
    while True:
        time.sleep(float(rng.uniform(0.5, 4)))
        run.replace_readers()
        if process.poll() is not None:
            if process.returncode not in {0, 1}:
                sys.stdout.write(f"ended with {process.returncode}, see {out.with_suffix('.log')}\n")
            break
        if not left:
            continue
        left -= 1
        readers = run.list_readers(process)
        if rng.random() < 0.5 and readers:
            with suppress(psutil.Error):
                readers[int(rng.integers(len(readers)))].kill()
            continue
        process.kill()
        process.wait()
        times = read_times(out)
        again += sum(times[name] != seconds for name, seconds in done.items())
        done = times
        check_results(out)
        process, starts = run.start(out), starts + 1
    times = read_times(out)
    again += sum(times[name] != seconds for name, seconds in done.items())
    check_results(out)
    sys.stdout.write(f"{kills - left} kills, {starts} starts: {len(times)} maps read, {again} of them twice\n")
    for path, group in read_faults(out):
        if group != "map":
            sys.stdout.write(f"failed: {path}, {group}\n")
    sys.stdout.write(f"failed as maps: {sum(group == 'map' for _, group in read_faults(out))}\n")


def read_times(out: Path) -> dict[str, float]:
    """When the results of each map that the journal has as read were written."""
    if not (out / JOURNAL).exists():
        return {}
    with closing(sqlite3.connect(f"file:{out / JOURNAL}?mode=ro", uri=True)) as journal:
        folders = journal.execute("""select folder from entries where "group" = ''""").fetchall()
    return {folder: (out / folder / OUTPUTS[0]).stat().st_mtime for (folder,) in folders}


def read_faults(out: Path) -> list[tuple[str, str]]:
    """Paths of the maps that have failed, and what faults are counted by."""
    with closing(sqlite3.connect(f"file:{out / JOURNAL}?mode=ro", uri=True)) as journal:
        return journal.execute("""select path, "group" from entries where "group" != ''""").fetchall()


def check_results(out: Path) -> None:
    """Each folder of results must have all its files."""
    # A program that was killed early has not created it
    for folder in out.iterdir() if out.is_dir() else ():
        if folder.is_dir() and not folder.name.startswith(".") and folder.name != FAULTS:
            missing = [name for name in OUTPUTS if not (folder / name).is_file()]
            if missing:
                sys.stdout.write(f"half-written: {folder} lacks {missing}\n")


def compare_results(one: Path, other: Path) -> None:
    """Count the files that differ between two batches."""
    files = [file.relative_to(one) for file in one.rglob("*") if file.is_file() and file.name != JOURNAL]
    lost = [file for file in files if not (other / file).is_file()]
    changed = [file for file in files if file not in lost and (one / file).read_bytes() != (other / file).read_bytes()]
    sys.stdout.write(f"{len(files)} files: {len(lost)} lost, {len(changed)} different\n")


if __name__ == "__main__":
    main()
