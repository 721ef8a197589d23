"""Score the rooms, doors and names that are read from the pictures of plans in `planfiles`.

Run: OMP_NUM_THREADS=1 python benchmarks/score_plan_rooms.py [NAME ...] [--data DIR] [--networks FILE ...]

The truth, `plan_truth.json`, was drawn by hand: outlines of rooms, row and col in pixels, with all names that stand in
a room, and the middle and width of each door that is drawn. Open-plan space is one room; where nothing is drawn between
two named parts, they are one. Many outlines started from what pianta had read, where that was right by eye.

A room is right if it has an IoU of 0.7 with one that was read; *false* are rooms without a flag that are right for
none. A door is right if a read one, of kind "door", has its middle within 0.6 widths of its own. A name is right if it
is read letter by letter, apart from case, spaces and punctuation; misread words are mended as `pianta.read` does. The
pictures were looked at while the reader was written: nothing here is held out.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment
from shapely import LinearRing, LineString, Polygon, get_coordinates

from pianta.errors import PlanWarning
from pianta.plan.read_plan import PlanFloor, PlanReading, read_plan
from pianta.plan.walls.segmentation import NETWORKS
from pianta.rooms.home import read_home_dictionary
from pianta.rooms.name_dictionary import read_default_room_name_dictionary
from pianta.rooms.spelling import correct_spelling
from pianta_bench.data.folders import find_data

FOLDER = "planfiles/raster"
TRUTH = Path(__file__).with_name("plan_truth.json")
RIGHT_IOU = 0.7
DOOR_REACH = 0.6  # widths of a door from its middle


@dataclass(frozen=True)
class Score:
    """Counts of a plan. found_rooms: rooms without a flag."""

    rooms: int
    found_rooms: int
    right: int
    doors: int
    found_doors: int
    right_doors: int
    names: int
    right_names: int

    def __str__(self) -> str:
        rooms = f"rooms {self.right}/{self.rooms}, {self.found_rooms - self.right} false"
        doors = f"doors {self.right_doors}/{self.doors}, {self.found_doors - self.right_doors} false"
        return f"{rooms}; {doors}; names {self.right_names}/{self.names}"


def main() -> None:
    """Print a line for each plan, and one for each kind."""
    truth = json.loads(TRUTH.read_text(encoding="utf-8"))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="file names of plans")
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    parser.add_argument("--networks", nargs="+", default=NETWORKS, help="files of the networks")
    options = parser.parse_args()
    warnings.simplefilter("ignore", PlanWarning)
    scores: dict[str, list[Score]] = {}
    for name in options.names or truth:
        reading = read_plan(find_data(options.data) / FOLDER / name, networks=options.networks)
        score = score_reading(reading, truth[name])
        scores.setdefault(truth[name]["kind"], []).append(score)
        sys.stdout.write(f"{name:24} {score}\n")
        sys.stdout.flush()
    for plan_kind, own in scores.items():
        print_kind(plan_kind, own)
    print_kind("all", [score for own in scores.values() for score in own])


def score_reading(reading: PlanReading, truth: dict[str, Any]) -> Score:
    """The counts of a plan; truth: of `plan_truth.json`."""
    rooms, names, doors = [], [], []
    for each in reading.floors:

        def to_pixels(line: LineString | LinearRing, each: PlanFloor = each) -> np.ndarray:
            return np.column_stack(each.grid.map_to_pixel(*get_coordinates(line).T))

        for room in correct_spelling(each.floor, read_default_room_name_dictionary(), read_home_dictionary()):
            if room.flag not in {"outside", "attic", "roof"}:
                rooms.append(Polygon(to_pixels(room.polygon.exterior)).buffer(0))
                names.append(" ".join(filter(None, (room.number, room.name))))
        doors += [to_pixels(door.line).mean(axis=0) for door in each.floor.doors if door.kind == "door"]
    true_rooms = [Polygon(room["outline"]).buffer(0) for room in truth["rooms"]]
    shares = [[iou(one, other) for other in rooms] for one in true_rooms]
    overlaps = np.array(shares).reshape(len(true_rooms), len(rooms))
    pairs = match(overlaps >= RIGHT_IOU)
    named = [index for index, room in enumerate(truth["rooms"]) if "name" in room]
    best = {index: names[int(overlaps[index].argmax())] for index in named} if rooms else {}
    right_names = sum(plain(best.get(index, "")) in map(plain, truth["rooms"][index]["name"]) for index in named)
    reach = [
        [np.hypot(*(np.array(door["middle"]) - other)) <= DOOR_REACH * door["width"] for other in doors]
        for door in truth["doors"]
    ]
    right_doors = len(match(np.array(reach, bool).reshape(len(truth["doors"]), len(doors))))
    return Score(
        len(true_rooms), len(rooms), len(pairs), len(truth["doors"]), len(doors), right_doors, len(named), right_names
    )


def iou(one: Polygon, other: Polygon) -> float:
    """The area that two polygons share, over that of both."""
    return float(one.intersection(other).area / max(one.union(other).area, 1e-9))


def match(fits: np.ndarray) -> list[tuple[int, int]]:
    """As many pairs that fit as possible, each row and column at most once."""
    pairs = zip(*linear_sum_assignment(~fits), strict=True)
    return [(int(row), int(col)) for row, col in pairs if fits[row, col]]


def plain(name: str) -> str:
    """The letters and digits of a name, in small letters."""
    return "".join(filter(str.isalnum, name.casefold()))


def print_kind(plan_kind: str, scores: Sequence[Score]) -> None:
    """Print the shares of a kind of plans, of all their rooms and doors together, and the mean of the plans."""
    total = Score(*np.sum([list(vars(score).values()) for score in scores], axis=0).tolist())
    per_plan = np.array([100 * score.right / score.rooms for score in scores])
    precision = total.right_doors / max(total.found_doors, 1)
    recall = total.right_doors / max(total.doors, 1)
    f1 = 2 * precision * recall / max(precision + recall, 1e-9)
    sys.stdout.write(
        f"{plan_kind} ({len(scores)}): rooms right {100 * total.right / total.rooms:.0f} % "
        f"(mean of plans {per_plan.mean():.0f} ± {per_plan.std():.0f}), {total.found_rooms - total.right} false of "
        f"{total.found_rooms}; doors precision {100 * precision:.0f}, recall {100 * recall:.0f}, F1 {100 * f1:.0f} %; "
        f"names right {100 * total.right_names / max(total.names, 1):.0f} % of {total.names}\n"
    )


if __name__ == "__main__":
    main()
