"""How fast `pianta read` is beside the work that it must do.

    python benchmarks/time_read.py [--data DIR] [--repeats N]

Two ratios of processor time (user and system, of one thread), which other load on the machine hardly changes:

cold: `pianta read` of the sample, in a process of its own, over a process that imports numpy, cv2, shapely and
    matplotlib and saves one figure. The median of all repeats of each.
warm: `pianta read` of 20 maps in one process, over the sum of `reconstruct` and labelling of the same maps.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from time import process_time

# One thread: threads that wait for each other would count as work.
THREADS = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OPENCV_FOR_THREADS_NUM": "1"}
BASELINE = """
import numpy, cv2, shapely, matplotlib
from matplotlib.figure import Figure
figure = Figure()
figure.add_subplot().plot([0, 1], [0, 1])
figure.savefig({path!r})
"""
MAPS = 20
# Largest acceptable ratios; chosen by hand.
MAX_COLD = 2.5
MAX_WARM = 1.3


def measure_process(arguments: Sequence[str]) -> float:
    """Processor time of a process, seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *arguments], check=True, env=os.environ | THREADS, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure_cold(folder: Path, repeats: int) -> tuple[float, float]:
    """Seconds of reading the sample, and of the baseline."""
    subprocess.run(
        [sys.executable, "-m", "pianta", "world", "sample", "-o", folder], check=True, stdout=subprocess.DEVNULL
    )
    read = ["-m", "pianta", "read", str(folder / "map.yaml"), "-o", str(folder / "read"), "-q"]
    baseline = ["-c", BASELINE.format(path=str(folder / "baseline.png"))]
    # In turns, so that both run under the same load; the first run of each fills the caches.
    pairs = [(measure_process(read), measure_process(baseline)) for _ in range(repeats + 1)][1:]
    first, second = (statistics.median(column) for column in zip(*pairs, strict=True))
    return first, second


def list_maps(data: Path) -> list[Path]:
    """The maps of robots and of vacuums from the web."""
    maps = sorted((data / "robotmaps").glob("*/*.yaml")) + sorted((data / "vacuum").glob("*.yaml"))
    if len(maps) < MAPS:
        sys.exit(f"{data} holds {len(maps)} maps of robotmaps and vacuum, {MAPS} are needed; give another --data")
    return maps[:MAPS]


def measure_warm(maps: Sequence[Path], folder: Path) -> tuple[float, float]:
    """Seconds of `pianta read` of maps, and of their reconstruction and labelling alone."""
    command = ["-m", "pianta", "read", *map(str, maps), "-o", str(folder / "many"), "-q"]
    total = measure_process(command)
    stages = float(
        subprocess.run(
            [sys.executable, __file__, "--stages", *map(str, maps)],
            check=True,
            env=os.environ | THREADS,
            capture_output=True,
            text=True,
        ).stdout
    )
    return total, stages


def measure_stages(maps: Sequence[str]) -> float:
    """Seconds of reconstructing and labelling maps; imports, models and decoding are not counted."""
    import pianta
    from pianta.reading._labelling import Labelling

    labelling = Labelling.make(None, None, None, None)
    total = 0.0

    def timed(run: Callable[[], pianta.Floor]) -> pianta.Floor:
        nonlocal total
        start = process_time()
        floor = run()
        total += process_time() - start
        return floor

    _, grid = pianta.make_world()
    labelling.label(pianta.reconstruct(grid))
    for path in maps:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            grid = pianta.read_map(path)
        floor = timed(lambda grid=grid: pianta.reconstruct(grid))
        timed(lambda floor=floor: labelling.label(floor))
    return total


def main() -> None:
    """Print both ratios."""
    parser = argparse.ArgumentParser(description="Processor time of pianta read, as ratios.")
    parser.add_argument("--data", type=Path, default=os.environ.get("PIANTA_DATA", "../shared/data"))
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--stages", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.stages:
        print(measure_stages(options.stages))
        return
    with tempfile.TemporaryDirectory() as name:
        read, baseline = measure_cold(Path(name), options.repeats)
        print(f"cold: {read:.2f} s / {baseline:.2f} s = {read / baseline:.2f} (at most {MAX_COLD})")
        total, stages = measure_warm(list_maps(Path(options.data)), Path(name))
        print(f"warm, {MAPS} maps: {total:.2f} s / {stages:.2f} s = {total / stages:.2f} (at most {MAX_WARM})")


if __name__ == "__main__":
    main()
