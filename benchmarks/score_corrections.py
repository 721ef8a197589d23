"""Count the corrections of real maps that still apply to the right place when the map is read again.

Run: OMP_NUM_THREADS=1 python benchmarks/score_corrections.py [--data DIR] [--only NAME] [--positions]

Each map is read by `structure`, and corrected as a person would: two rooms merged, the largest split, five named, a
door deleted, a door drawn, a room deleted. Then it is changed, read again, and corrected by `pianta read --previous`.
A correction is right if the room that it makes, names or deletes has an IoU above 0.5 with the one on the first map,
moved by the true motion; if a deleted door was or is within 0.5 m of its true place; if a drawn door is, and joins the
rooms that cover most of the first ones. A correction that the new reading is as it says already is right too.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from shapely import LineString, Point, Polygon

from pianta.corrections._positions import middle_of, position_in
from pianta.corrections.by_id import merge_by_id, position_of, split_by_id
from pianta.corrections.correct import correct_all
from pianta.corrections.kinds import (
    Correction,
    DeleteDoor,
    DeleteRoom,
    DrawDoor,
    MergeRooms,
    NameRoom,
    SplitRoom,
    name_kind,
)
from pianta.errors import CorrectionError, FloorError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.io.maps import read_map
from pianta.layout.reconstruct import reconstruct
from pianta.reading.saved_reading import SavedReading
from pianta_bench.data.folders import SLAM_RESOLUTION, find_data

sys.path.append(str(Path(__file__).parents[1]))
from tests.test_invariance import View, view_doubled, view_padded, view_symmetry, view_turned

RESOLUTION = 0.05  # metres per cell of maps without a map.yaml
MAPS = (
    *("survey/lab_c_scan.png", "survey/Freiburg101_scan_furnitures.png", "survey/office_a_furnitures.png"),
    *("clutter/freiburg79_map15.png", "clutter/freiburg_building101.png", "clutter/vimantichouse20.yaml"),
    *("vacuum/converted_3790.yaml", "vacuum/l10su_1058_goto_target.yaml"),
)
# Maps that are turned by 17° alone.
TURNED_MAPS = (
    *("survey/Freiburg79_scan.png", "survey/lab_c_scan_furnitures.png", "survey/office_b_furnitures.png"),
    *("survey/office_d.png", "survey/office_i.png", "clutter/g4s_y2.png", "clutter/vimantichouse23.yaml"),
    *("clutter/simonahouse.yaml", "clutter/casamatteo.png", "clutter/umicfirstfloor_photo20200108.png"),
    *("vacuum/misc_monastery_with_cutoff.yaml", "vacuum/S5_FW2020_with_segments.yaml"),
)
# Steps of the runs of data/partial whose maps grow; each pair of neighbours is a map and the grown one.
RUNS = (
    ("freiburg79", ("r_003", "r_005", "r_008")),
    ("freiburg79", ("r_004", "r_006", "r_007", "r_009", "r_011", "r_013", "r_014")),
    ("bronxville", ("a_200", "a_300")),
    ("bronxville", ("a_060", "a_090", "a_120", "a_150", "a_250")),
    ("putnamjuniorhigh", ("a_180", "a_280")),
    ("putnamjuniorhigh", ("a_070", "a_090", "a_110", "a_210", "a_306")),
)
# Nothing was chosen by these. The runs are other steps of the same buildings, the only ones that data/partial has.
NEW_MAPS = (
    *("survey/lab_f_scan.png", "survey/NLB_furnitures.png", "clutter/vimantichouse30.yaml"),
    *("vacuum/d9_1093_huge.yaml", "vacuum/z10_1056_paths.yaml"),
)
NEW_RUNS = (
    ("freiburg79", ("r_010", "r_012", "r_015")),
    ("bronxville", ("a_350", "a_418")),
    ("putnamjuniorhigh", ("a_130", "a_150")),
)
TURNED = "turned by 17°"
USED, NEW = "used while it was built", "not used"
NAMES = 5
SAME_IOU = 0.5
# A door is at a place if its middle is nearer; metres.
SAME_PLACE = 0.5
DOOR_WIDTH = 0.9
# A wall between rooms that a door is drawn in is at most so thick, and at least so long; metres.
MAX_WALL, MIN_WALL = 0.5, 1.5
# Smaller rooms are not corrected; m².
MIN_AREA = 2.0
# By which the frame of the shifted map is moved; metres.
SHIFT = (37.3, -21.7)

Move = Callable[[np.ndarray], np.ndarray]


class Case(NamedTuple):
    """A map that is read first, the same map changed, and the true motion of points from one frame to the other."""

    part: str
    name: str
    change: str
    first: GridMap
    changed: GridMap
    move: Move


@dataclass(frozen=True)
class Verdict:
    """Whether a correction applies to the right place on the changed map. why: what is wrong."""

    part: str
    case: str
    change: str
    correction: Correction
    why: str | None


def main() -> None:
    """Print the share of each change, and what fails."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--only", default="", help="Maps whose names contain this.")
    parser.add_argument("--positions", action="store_true", help="Without rooms that corrections confirm.")
    options = parser.parse_args()
    verdicts: list[Verdict] = []
    for case in list_cases(find_data(options.data), options.only):
        checked = [*check_case(case, positions=options.positions)]
        right = sum(each.why is None for each in checked)
        sys.stdout.write(f"{case.name}, {case.change}: {right} of {len(checked)}\n")
        for each in checked:
            if each.why:
                sys.stdout.write(f"    {each.correction}: {each.why}\n")
        sys.stdout.flush()
        verdicts += checked
    for part in dict.fromkeys(each.part for each in verdicts):
        chosen = [each for each in verdicts if each.part == part]
        for key in (lambda each: each.change, lambda each: name_kind(each.correction)):
            for name in dict.fromkeys(map(key, chosen)):
                print_share(f"{part}, {name}", [each for each in chosen if key(each) == name])
        print_share(f"{part}, all", chosen)
    print_share("all", verdicts)


def print_share(title: str, verdicts: Sequence[Verdict]) -> None:
    """Print the pooled share of right corrections, and its mean ± sd over the maps, %."""
    by_case = {each.case: [] for each in verdicts}
    for each in verdicts:
        by_case[each.case].append(each.why is None)
    shares = 100 * np.array([np.mean(right) for right in by_case.values()])
    right = sum(each.why is None for each in verdicts)
    sys.stdout.write(
        f"{title}: {right} of {len(verdicts)}, {100 * right / len(verdicts):.1f} %; "
        f"{shares.mean():.1f} ± {shares.std(ddof=min(1, len(shares) - 1)):.1f} over {len(shares)} maps\n"
    )


def list_cases(data: Path, only: str) -> Iterator[Case]:
    """All maps with all changes."""
    for part, names, runs in ((USED, (*MAPS, *TURNED_MAPS), RUNS), (NEW, NEW_MAPS, NEW_RUNS)):
        for name in names:
            if only in name:
                resolution = None if name.endswith(".yaml") else RESOLUTION
                cases = change_map(part, name, read_map(data / name, resolution=resolution))
                yield from (case for case in cases if name not in TURNED_MAPS or case.change == TURNED)
        for building, steps in runs:
            if only in building:
                for step, later in pairwise(steps):
                    yield read_growing(part, data / "partial" / building, step, later)


def change_map(part: str, name: str, grid: GridMap) -> Iterator[Case]:
    """The map turned by 90° and 17°, shifted, padded and at double resolution."""
    views: dict[str, Callable[[GridMap], View]] = {
        "turned by 90°": lambda each: view_symmetry(each, 1, mirrored=False),
        TURNED: view_turned,
        "padded": view_padded,
        "double resolution": view_doubled,
    }
    for change, view in views.items():
        changed = view(grid)
        yield Case(part, name, change, grid, changed.grid, measure_motion(grid, changed))
    x, y, yaw = grid.origin
    shifted = replace(grid, origin=(x + SHIFT[0], y + SHIFT[1], yaw))
    yield Case(part, name, "shifted", grid, shifted, lambda xy: xy + np.array(SHIFT))


def measure_motion(grid: GridMap, view: View) -> Move:
    """The rigid motion from the frame of a map to that of a view, from three points."""
    corners = np.array([[0.0, 0.0], [0.0, 10.0], [10.0, 0.0]])
    there = np.column_stack(view.grid.pixel_to_map(*corners.T))
    here = np.column_stack(grid.pixel_to_map(*view.to_source(*corners.T)))
    affine = np.linalg.solve(np.column_stack([here, np.ones(3)]), there)
    return lambda xy: np.column_stack([xy, np.ones(len(xy))]) @ affine


def read_growing(part: str, folder: Path, step: str, later: str) -> Case:
    """Two maps of a run; their images have one frame, or are shifted as their steps.json says."""
    entries = {
        Path(each["file"]).stem: each for each in json.loads((folder / "steps.json").read_text(encoding="utf-8"))
    }
    affines = [entries[each].get("affine") for each in (step, later)]
    resolution = SLAM_RESOLUTION if affines[0] else RESOLUTION
    first, changed = (read_map(folder / f"{each}.png", resolution=resolution) for each in (step, later))
    by_pixels = np.zeros(2) if affines[0] is None else (np.array(affines[1]) - np.array(affines[0]))[:, 2]

    def move(xy: np.ndarray) -> np.ndarray:
        row, col = first.map_to_pixel(*xy.T)
        return np.column_stack(changed.pixel_to_map(row + by_pixels[1], col + by_pixels[0]))

    return Case(part, f"{folder.name} {step}", "grown", first, changed, move)


def check_case(case: Case, *, positions: bool = False) -> Iterator[Verdict]:
    """A verdict on each correction of a map. positions: without rooms that corrections confirm."""
    floor = read_first(case.first)
    first = SavedReading(Path(), floor, floor, grid=None if positions else case.first)
    states = [first]
    for make in choose_corrections(floor):
        try:
            states.append(states[-1].add(make(states[-1].floor)))
        except CorrectionError as error:
            sys.stdout.write(f"    {case.name}: not corrected, {error}\n")
    new = reconstruct(case.changed, predict_partial=False)
    verdict = partial(Verdict, case.part, case.name, case.change)
    try:
        carried = states[-1].carry_over(new, case.changed)
    except FloorError as error:
        yield from (verdict(correction, str(error)) for correction in states[-1].corrections)
        return
    new = carried.floor
    for (before, after), correction in zip(pairwise(states), carried.corrections, strict=True):
        corrected, (outcome,) = correct_all(new, [correction])
        old = [move_floor(each.floor, case.move) for each in (before, after)]
        why = find_fault(after.corrections[-1], *old, new, corrected)
        yield verdict(after.corrections[-1], why and f"{why}; {outcome.problem or 'applied elsewhere'}")
        new = corrected


_READ: dict[int, Floor] = {}


def read_first(grid: GridMap) -> Floor:
    """The floor of the first map, which is read once for all changes."""
    if id(grid.cells) not in _READ:
        _READ.clear()
        _READ[id(grid.cells)] = reconstruct(grid, predict_partial=False)
    return _READ[id(grid.cells)]


def choose_corrections(floor: Floor) -> Iterator[Callable[[Floor], Correction]]:
    """Plausible corrections of a floor, each made on the floor with those before it."""
    random = np.random.default_rng(0)
    inner = [door for door in floor.doors if not door.is_entrance]
    if inner:
        yield partial(merge_neighbours, door=inner[random.integers(len(inner))])
    yield split_largest
    rooms = [room for room in floor if room.polygon.area >= MIN_AREA]
    chosen = random.permutation(len(rooms))
    for number in chosen[:NAMES]:
        # A room that was merged has the name of the whole
        yield lambda now, room=rooms[number]: NameRoom(find_place(now, room), f"Name {room.id}")
    if len(inner) > 1:
        yield lambda _: DeleteDoor(middle_of(inner[random.integers(len(inner))].line))
    yield draw_door
    if len(chosen) > NAMES:
        yield lambda now: DeleteRoom(find_place(now, rooms[chosen[NAMES]]))


def find_place(floor: Floor, room: Room) -> tuple[float, float]:
    """A place in a room that may have been merged or split since."""
    return position_of(floor, room.id) if room.id in floor else position_in(room.polygon)


def merge_neighbours(floor: Floor, door: Door) -> Correction:
    """The rooms on both sides of a door are one."""
    return merge_by_id(floor, door.room_ids)


def split_largest(floor: Floor) -> Correction:
    """The largest room divided across its longer side, through its middle."""
    room = max(floor, key=lambda each: each.polygon.area)
    box = shapely.minimum_rotated_rectangle(room.polygon)
    corners = shapely.get_coordinates(box)
    sides = np.diff(corners[:3], axis=0)
    across = sides[np.hypot(*sides.T).argmin()]
    middle = np.array(position_of(floor, room.id))
    cut = shapely.intersection(LineString([middle - across, middle + across]), room.polygon)
    piece = min(shapely.get_parts(cut), key=lambda part: part.distance(Point(middle)))
    return split_by_id(floor, room.id, tuple((round(x, 3), round(y, 3)) for x, y in piece.coords))


def draw_door(floor: Floor) -> Correction:
    """A door in the middle of the longest wall between two rooms without one."""
    joined = {frozenset(door.room_ids) for door in floor.doors}
    strips = []
    for one, other in combinations(floor.rooms, 2):
        if {one.id, other.id} not in joined and one.polygon.distance(other.polygon) <= MAX_WALL:
            near = [each.polygon.buffer(MAX_WALL / 2 + 0.1) for each in (one, other)]
            parts = shapely.get_parts(shapely.intersection(*near))
            strips += [part for part in parts if part.area > 0]
    for strip in sorted(strips, key=lambda part: -part.length):
        corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(strip))
        sides = np.diff(corners[:3], axis=0)
        lengths = np.hypot(*sides.T)
        if lengths.max() < MIN_WALL:
            break
        along = sides[lengths.argmax()] / lengths.max() * DOOR_WIDTH / 2
        middle = shapely.get_coordinates(shapely.maximum_inscribed_circle(strip, 0.02))[0]
        line = tuple((round(x, 3), round(y, 3)) for x, y in (middle - along, middle + along))
        _, (outcome,) = correct_all(floor, [DrawDoor(line)])
        if outcome.changed:
            return DrawDoor(line)
    raise CorrectionError("no wall without a door is long enough")


def move_floor(floor: Floor, move: Move) -> Floor:
    """The floor in another frame."""
    rooms = tuple(
        replace(room, polygon=shapely.transform(room.polygon, move), predicted=None, confidence=None) for room in floor
    )
    doors = tuple(replace(door, line=shapely.transform(door.line, move)) for door in floor.doors)
    return replace(floor, rooms=rooms, doors=doors, possible_doors=(), walls=(), furniture=())


def find_fault(correction: Correction, before: Floor, after: Floor, new: Floor, corrected: Floor) -> str | None:  # noqa: PLR0911 - one for each kind
    """What is wrong with a correction on a new floor; None if it is right.

    before, after: the first floor without and with it, in the frame of the new one. corrected: the new floor with it.
    """
    if isinstance(correction, MergeRooms | SplitRoom):
        changed = [room for room in after if room.id not in before or before[room.id].polygon != room.polygon]
        worst = min(max_iou(room.polygon, corrected) for room in changed)
        return None if worst > SAME_IOU else f"IoU {worst:.2f}"
    if isinstance(correction, NameRoom):
        named, wanted = ([room.polygon for room in each if room.name == correction.name] for each in (corrected, after))
        if len(named) != 1:
            return f"{len(named)} rooms have the name"
        iou = measure_iou(named[0], wanted[0])
        return None if iou > SAME_IOU else f"IoU {iou:.2f}"
    if isinstance(correction, DeleteRoom):
        (gone,) = [room.polygon for room in before if room.id not in after]
        deleted = [room.polygon for room in new if room.id not in corrected]
        iou = max((measure_iou(gone, each) for each in deleted), default=1 - max_iou(gone, corrected))
        return None if iou > SAME_IOU else f"IoU {iou:.2f}"
    if isinstance(correction, DeleteDoor):
        (door,) = [each for each in before.doors if each not in after.doors]
        deleted = [each for each in new.doors if each not in corrected.doors]
        away = [measure_distance(door, each) for each in deleted]
        left = [measure_distance(door, each) for each in corrected.doors]
        is_right = min(away) < SAME_PLACE if away else min(left) > SAME_PLACE
        return None if is_right else f"{min(away or left):.2f} m from the place"
    (door,) = [each for each in after.doors if each not in before.doors]
    sides = [find_counterpart(after[room], corrected) for room in door.room_ids]
    near = [each for each in corrected.doors if measure_distance(door, each) < SAME_PLACE]
    if any({*each.room_ids} == {*sides} for each in near):
        return None
    return f"{len(near)} doors are there, which join other rooms"


def measure_iou(one: Polygon, other: Polygon) -> float:
    """Intersection over union."""
    common = shapely.intersection(one, other).area
    return float(common / (one.area + other.area - common))


def max_iou(polygon: Polygon, floor: Floor) -> float:
    """The IoU of the most similar room."""
    return max(measure_iou(polygon, room.polygon) for room in floor)


def measure_distance(one: Door, other: Door) -> float:
    """Metres between the middles of two doors."""
    return float(np.hypot(*np.subtract(middle_of(one.line), middle_of(other.line))))


def find_counterpart(room: Room, floor: Floor) -> int:
    """The id of the room that covers most of another one."""
    return max(floor, key=lambda each: shapely.intersection(each.polygon, room.polygon).area).id


if __name__ == "__main__":
    main()
