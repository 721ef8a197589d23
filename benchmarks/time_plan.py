"""How long `pianta.read_plan` takes for a sheet of 3000 × 2000 pixels with text, and how much memory.

Run: OMP_NUM_THREADS=1 python benchmarks/time_plan.py [PICTURE ...] [--repeats N]

The sheet is a drawn floor of a school with names, furniture and doors, or each picture that is given, enlarged or
shrunk to as many pixels. Processor time counts, beside that of one pass of Canny's edges and of the distance transform
over as many pixels, in the same process; the smallest of the repeats of each.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import process_time

import cv2
import numpy as np

import pianta
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.plans.drawing import draw_plan

WIDTH, HEIGHT = 3000, 2000
NAMES = ("Classroom", "Office", "Store", "Library", "Laboratory", "Staff room")


def main() -> None:
    """Print the ratio and the memory for each sheet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", nargs="*", type=Path, metavar="PICTURE")
    parser.add_argument("--repeats", type=int, default=2)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    cv2.setNumThreads(1)
    sheets = {picture.name: cv2.imread(str(picture)) for picture in options.pictures}
    sheets = sheets or {"a drawn school": draw_sheet()}
    sys.stdout.write(f"pianta {pianta.__version__}, {options.repeats} repeats\n")
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "plan.png")
        for name, sheet in sheets.items():
            colors = resize_sheet(sheet)
            cv2.imwrite(file, colors)
            reading = min(measure(lambda: pianta.read_plan(file)) for _ in range(options.repeats))
            grey = cv2.cvtColor(colors, cv2.COLOR_BGR2GRAY)
            unit = min(measure(partial(find_edges_and_distances, grey)) for _ in range(10))
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
            height, width = grey.shape
            sys.stdout.write(
                f"{name}, {width} × {height}: {reading:.2f} s of processor, {reading / unit:.0f} times the "
                f"{unit:.3f} s of edges and distances; at most {memory:.0f} MB so far\n"
            )


def draw_sheet() -> np.ndarray:
    """A drawn floor, blue, green, red, shape (H, W, 3)."""
    floor = make_corridor_floor(length=60.0, room_width=(4.0, 8.0))
    names = {room.id: NAMES[index % len(NAMES)] for index, room in enumerate(floor)}
    plan = draw_plan(floor, texts=names, px_per_metre=45.0, furniture=0.6, windows=2, dimensions=True)
    return np.ascontiguousarray(plan.colors[..., ::-1])


def resize_sheet(colors: np.ndarray) -> np.ndarray:
    """A sheet with the pixels of 3000 × 2000."""
    factor = (WIDTH * HEIGHT / (colors.shape[0] * colors.shape[1])) ** 0.5
    method = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(colors, None, fx=factor, fy=factor, interpolation=method))


def find_edges_and_distances(grey: np.ndarray) -> None:
    """One pass of each over a sheet of grey, shape (H, W)."""
    edges = cv2.Canny(grey, 50, 150)
    cv2.distanceTransform(255 - edges, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)


def measure(run: Callable[[], object]) -> float:
    """Processor time, seconds."""
    start = process_time()
    run()
    return process_time() - start


if __name__ == "__main__":
    main()
