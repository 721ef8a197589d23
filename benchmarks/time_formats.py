"""Time `pianta convert` for a floor of 60 rooms, for each format, beyond imports.

Run: OMP_NUM_THREADS=1 python benchmarks/time_formats.py [--repeats N]

The first conversion into a format imports its packages and is not counted. A format whose extra is not installed is
named and left out.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

import pianta
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io.georeference import read_georeference
from pianta.io.writers._formats import FORMATS
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.scan import simulate_map

# A corridor with rooms of 4 m on both sides, metres.
LENGTH = 125.0
ROOM_WIDTH = (4.0, 4.4)
# Somewhere on the earth.
ANCHOR = '{"latitude": 45.478, "longitude": 9.227, "bearing": 0}'


def main() -> None:
    """Print the seconds of each format, mean ± sd."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    floor = make_corridor_floor(length=LENGTH, room_width=ROOM_WIDTH)
    grid = simulate_map(floor)
    sys.stdout.write(f"pianta {pianta.__version__}, {len(floor)} rooms, {repeats} repeats\n")
    for name in FORMATS:
        try:
            times = time_format(name, floor, grid, repeats)
        except OptionError as error:
            sys.stdout.write(f"{name}: {error}\n")
            continue
        sys.stdout.write(f"{name}: {times.mean():.3f} ± {times.std(ddof=1):.3f} s, at most {times.max():.3f} s\n")


def time_format(name: str, floor: Floor, grid: GridMap, repeats: int) -> np.ndarray:
    """The seconds of each conversion but the first."""
    seconds = []
    with TemporaryDirectory() as folder:
        anchor = Path(folder) / "anchor.json"
        anchor.write_text(ANCHOR, encoding="utf-8")
        # A keep-out mask needs rooms to keep out of
        rooms = ["1"] if name == "nav2-keepout" else []
        georeference = read_georeference(anchor) if FORMATS[name].needs_georeference else None
        for _ in range(repeats + 1):
            start = perf_counter()
            target = Path(folder) / FORMATS[name].file
            pianta.convert(floor, target, to=name, grid=grid, georeference=georeference, rooms=rooms)
            seconds.append(perf_counter() - start)
    return np.array(seconds[1:])


if __name__ == "__main__":
    main()
