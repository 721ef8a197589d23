"""Score what is read from DXFs whose rooms are drawn as closed outlines.

Run: OMP_NUM_THREADS=1 python benchmarks/score_dxf.py [--data DIR]

The truth of a file that was made by code are its own closed LWPOLYLINEs. The other files are exports of readings of the
robots' maps of the survey, which are read again: the truth is the floor that was exported. A room is exact if its IoU
with a room of the result is 1 to 1e-6 and both have the same corners, to a millimetre; names, numbers and doors count
if they are those of the exported floor. Nothing was fitted on these files.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import ezdxf
import numpy as np
import shapely
from shapely import Polygon

import pianta
from pianta.floor import Floor
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import SETS

GENERATED = {"made_a_area.dxf": 1.0, "made_cafm_stamp.dxf": 1.0, "made_a_area_nounits_mm.dxf": 0.001}
MIN_IOU = 1 - 1e-6
TOLERANCE = 0.0011  # metres: results have millimetres


def main() -> None:
    """Print a line for each file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    data = find_data(parser.parse_args().data)
    for name, metres in GENERATED.items():
        file = data / "planfiles" / "dxf" / name
        print_score(name, list(drawn_outlines(file, metres)), pianta.read(file, labels=False).floor)
    totals = np.zeros(4, int)
    with tempfile.TemporaryDirectory() as folder:
        for item in SETS["survey"].list_items(data):
            floor = pianta.reconstruct(SETS["survey"].read(data / SETS["survey"].folder, item).grid)
            target = Path(folder) / "floor.dxf"
            pianta.convert(floor, target, to="dxf")
            again = pianta.read(target, labels=False).floor
            counts = print_score(f"survey {item}", [room.polygon for room in floor], again)
            truth, pairs = pairs_of(floor, floor), pairs_of(again, floor)
            print(f"    pairs of rooms that doors join: {len(truth & pairs)} of {len(truth)}, {len(pairs)} found")
            totals += (*counts, len(truth & pairs), len(truth))
    print(f"survey: {totals[0]} of {totals[1]} rooms exact, {totals[2]} of {totals[3]} pairs joined")


def drawn_outlines(file: Path, metres: float) -> Iterator[Polygon]:
    """The closed polylines of a file, metres."""
    for line in ezdxf.readfile(file).modelspace().query("LWPOLYLINE"):
        yield Polygon(np.array(line.get_points("xy"), float) * metres)


def print_score(name: str, truth: Sequence[Polygon], floor: Floor) -> tuple[int, int]:
    """Print how many rooms are exact; their number, and that of the true rooms."""
    exact = sum(any(is_exact(polygon, room.polygon) for room in floor) for polygon in truth)
    print(f"{name}: {exact} of {len(truth)} rooms exact, {len(floor)} found")
    return exact, len(truth)


def is_exact(truth: Polygon, room: Polygon) -> bool:
    """Whether two outlines are the same, with the same corners."""
    common = shapely.intersection(truth, room).area
    if common < MIN_IOU * shapely.union(truth, room).area:
        return False
    corners, others = (shapely.get_coordinates(polygon.exterior)[:-1] for polygon in (truth, room))
    distances = np.hypot(*(corners[:, None] - others[None]).transpose(2, 0, 1))
    return len(corners) == len(others) and bool((distances.min(axis=1) <= TOLERANCE).all())


def pairs_of(floor: Floor, truth: Floor) -> set[frozenset[int]]:
    """The pairs of rooms that doors of a floor join, as ids of the true rooms that each has most in common with."""
    same = {
        room.id: max(truth, key=lambda other, room=room: other.polygon.intersection(room.polygon).area).id
        for room in floor
    }
    return {frozenset(same[room] for room in door.room_ids) for door in floor.doors if len(door.room_ids) == 2}


if __name__ == "__main__":
    main()
