"""What a million maps cost, and where the bottleneck is: a simulation of many workers with one journal.

Run: OMP_NUM_THREADS=1 python benchmarks/simulate_batches.py OUT [--maps 1000000]

OUT: a folder that `pianta read FOLDER` has written, as by time_batches.py. Its journal gives the seconds of each map,
and its results the bytes of each. What the client does for a map is measured here, on a new journal: a record, and the
listing of a file; so is what `pianta collect` takes for each map.

The simulation gives the next free worker the next map, with seconds drawn from those of the journal; a result waits
until the client, or the scheduler before it, has dealt with the earlier ones. What Dask takes for a task on the
scheduler is stated by its documentation as up to a millisecond; it is a constant here.
"""

from __future__ import annotations

import argparse
import heapq
import sys
import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pianta.batch.collect import collect_batch
from pianta.batch.inputs import list_inputs
from pianta.batch.journal import Entry, Journal, read_journals
from pianta.batch.processes import QUEUED_PER_JOB

DASK_SECONDS = 1e-3  # of the scheduler for a task
RECORDS = 2000  # that are written to measure one
WORKERS = (1, 2, 8, 32, 128, 512, 2048)
MAPS_PER_WORKER = 200  # that are simulated


def main() -> None:
    """Print the measured costs, and the table of the simulation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--maps", type=int, default=1_000_000)
    options = parser.parse_args()
    entries = [entry for entry in read_journals(options.out) if entry.is_done]
    seconds = np.array([entry.seconds for entry in entries])
    sizes = [sum(file.stat().st_size for file in (options.out / entry.folder).iterdir()) for entry in entries]
    record, client = measure_records(entries[0]), measure_listing(Path(entries[0].path).parent)
    collected = measure_collection(options.out, len(entries))
    sys.stdout.write(
        f"{len(entries)} maps: {seconds.mean():.2f} ± {seconds.std():.2f} s, {np.mean(sizes) / 2**20:.2f} MiB results\n"
        f"client: {1000 * client:.2f} ms to list a file, {1000 * record:.2f} ms to record it; collect: "
        f"{1000 * collected:.1f} ms a map\n"
        f"{options.maps} maps: {options.maps * seconds.mean() / 3600:,.0f} hours of a core, "
        f"{options.maps * np.mean(sizes) / 2**40:.2f} TiB, {options.maps * collected / 3600:.1f} hours to "
        "collect\n"
    )
    for workers in WORKERS:
        rate, busy = simulate(workers, seconds, record + DASK_SECONDS)
        hours = options.maps / rate / 3600
        sys.stdout.write(f"{workers:5} workers: {hours:10.1f} h, workers busy {busy:.0%} of the time\n")


def measure_records(entry: Entry) -> float:
    """Seconds to record an entry."""
    with TemporaryDirectory() as folder, Journal(Path(folder) / "journal.sqlite") as journal:
        start = time.perf_counter()
        for number in range(RECORDS):
            journal.record(replace(entry, path=f"{entry.path}{number}"))
        return (time.perf_counter() - start) / RECORDS


def measure_listing(folder: Path) -> float:
    """Seconds to list a file of a folder of maps."""
    start = time.perf_counter()
    count = len(list_inputs([folder]))
    return (time.perf_counter() - start) / count


def measure_collection(out: Path, count: int) -> float:
    """Seconds that `collect` takes for a map."""
    start = time.perf_counter()
    with TemporaryDirectory() as folder:
        collect_batch(out, folder)
    return (time.perf_counter() - start) / count


def simulate(workers: int, seconds: np.ndarray, per_result: float) -> tuple[float, float]:
    """Maps a second, and the share of the time in which a worker works.

    seconds: of maps, from which theirs are drawn. per_result: seconds of the client for each, one after the other.
    """
    rng = np.random.default_rng(1)
    work = rng.choice(seconds, MAPS_PER_WORKER * workers)
    free = [0.0] * workers
    client = 0.0
    for each in work:
        done = heapq.heappop(free) + each
        client = max(client, done) + per_result
        # A worker has some maps at hand, and then waits for the client
        heapq.heappush(free, max(done, client - QUEUED_PER_JOB * each))
    end = max(client, *free)
    return len(work) / end, float(work.sum() / (workers * end))


if __name__ == "__main__":
    main()
