"""Count the corrections that a person needs until all rooms of a map are right: what our errors cost.

Run: OMP_NUM_THREADS=1 python benchmarks/count_corrections.py [SET ...] [--data DIR] [--most 10]

A simulated person knows the true rooms and mends the reading of `structure`, one correction at a time: merges the
parts of a true room, splits a room along a straight line between two true ones, draws a room that is missing, and
deletes one that is no room. All rooms are right if F1 is 100: each true room matches one room with an IoU above 0.5,
and each room a true one, as in `pianta bench segmentation`. A person who is less careful needs more corrections.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon
from sklearn.svm import LinearSVC

from pianta.corrections._positions import position_in
from pianta.corrections.by_id import merge_by_id, position_of
from pianta.corrections.correct import correct
from pianta.corrections.kinds import Correction, DeleteRoom, DrawRoom, SplitRoom
from pianta.errors import CorrectionError
from pianta.evaluation.segmentation import match_rooms, score_labels
from pianta.floor import Floor
from pianta.layout._label_images import largest_part, outline_labels
from pianta.layout.reconstruct import reconstruct
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import SETS, MapSet, TrueMap
from pianta_bench.segmentation.measure import cut_spaces, find_spaces

DEFAULT_SETS = ("survey", "furniture", "clutter", "vacuum")
# A room is a part of a true room if more than this share of it is there.
PART_SHARE = 0.5
# A true room is in a room if more than this share of it is there.
INSIDE_SHARE = 0.4
# Tolerance of a drawn outline; metres.
DRAWN_TOLERANCE = 0.15
# Cells from which a border is fitted, at most, of each side; a limit of time.
MAX_CELLS = 400


def main() -> None:
    """Print the F1 of each map as it is read, and the corrections that it needs; then the means of each set."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sets", nargs="*", metavar="SET", choices=[*SETS, []], help=f"of {', '.join(SETS)}")
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    parser.add_argument("--most", type=int, default=10, help="corrections of a map, at most")
    options = parser.parse_args()
    data = find_data(options.data)
    for name in options.sets or DEFAULT_SETS:
        counts = []
        for item in SETS[name].list_items(data):
            true_map = SETS[name].read(data / SETS[name].folder, item)
            floor = reconstruct(true_map.grid)
            before = score(floor, true_map, SETS[name])
            corrected, corrections = mend(floor, true_map, SETS[name], most=options.most)
            after = score(corrected, true_map, SETS[name])
            counts.append((before, after, len(corrections), len(floor)))
            sys.stdout.write(
                f"{name} {item}: {len(floor)} rooms, F1 {before:.1f}, {len(corrections)} corrections, F1 {after:.1f}\n"
            )
            sys.stdout.flush()
        print_summary(name, np.array(counts))


def print_summary(name: str, counts: NDArray[np.float64]) -> None:
    """Print how many maps are right before and after, and the corrections of a map and of ten rooms."""
    before, after, corrections, rooms = counts.T
    spread = corrections.std(ddof=1) if len(corrections) > 1 else 0.0
    sys.stdout.write(
        f"{name}, {len(counts)} maps: F1 {before.mean():.1f} -> {after.mean():.1f}; all rooms right on "
        f"{(before == 100).sum()} as read, on {(after == 100).sum()} corrected; "
        f"{corrections.mean():.1f} ± {spread:.1f} corrections for a map, "
        f"{10 * corrections.sum() / rooms.sum():.1f} for ten rooms\n"
    )


def score(floor: Floor, true_map: TrueMap, mapset: MapSet) -> float:
    """F1 of the rooms, %."""
    truth = cut_spaces(true_map.spaces, true_map, mapset)
    return 100 * float(score_labels(find_spaces(floor, true_map, mapset), truth).f1)


def mend(floor: Floor, true_map: TrueMap, mapset: MapSet, *, most: int) -> tuple[Floor, list[Correction]]:
    """The floor with the corrections that a person makes, until all rooms are right or there are `most` of them."""
    truth = cut_spaces(true_map.spaces, true_map, mapset)
    compared = Comparison(floor, find_spaces(floor, true_map, mapset), truth, true_map)
    corrections: list[Correction] = []
    while len(corrections) < most:
        for correction in propose(compared):
            try:
                corrected = correct(compared.floor, correction)
            except CorrectionError:
                continue
            after = Comparison(corrected, find_spaces(corrected, true_map, mapset), truth, true_map)
            if corrected is not compared.floor and len(after.matches) >= len(compared.matches):
                compared = after
                corrections.append(correction)
                break
        else:
            break
    return compared.floor, corrections


@dataclass(frozen=True, eq=False)
class Comparison:
    """A floor beside the true rooms. labels, truth: shape (H, W), of the cells that count.

    rooms, true_rooms: those with cells; area, true_area: their cells; common: cells of a room and a true one. right:
    rooms that match a true one; missing: true rooms that no room matches.
    """

    floor: Floor
    labels: NDArray[np.int32]
    truth: NDArray[np.int32]
    true_map: TrueMap

    @cached_property
    def area(self) -> dict[int, int]:
        """Cells of each room."""
        return count_cells(self.labels)

    @cached_property
    def true_area(self) -> dict[int, int]:
        """Cells of each true room."""
        return count_cells(self.truth)

    @cached_property
    def matches(self) -> dict[int, int]:
        """The true room of each room that is right."""
        return match_rooms(self.labels, self.truth)

    @property
    def missing(self) -> list[int]:
        """True rooms that no room matches."""
        return sorted(self.true_area.keys() - set(self.matches.values()))

    @property
    def wrong(self) -> list[int]:
        """Rooms that match no true one."""
        return sorted(self.area.keys() - self.matches.keys())

    @cached_property
    def common(self) -> Counter[tuple[int, int]]:
        """Cells of each room in each true one."""
        both = (self.labels > 0) & (self.truth > 0)
        return Counter(zip(self.labels[both].tolist(), self.truth[both].tolist(), strict=True))


def count_cells(labels: NDArray[np.int32]) -> dict[int, int]:
    """The number of cells of each room."""
    ids, counts = np.unique(labels[labels > 0], return_counts=True)
    return dict(zip(ids.tolist(), counts.tolist(), strict=True))


def propose(compared: Comparison) -> Iterator[Correction]:
    """Corrections of rooms that are not right, the simplest first."""
    yield from propose_merges(compared)
    yield from propose_splits(compared)
    for true_room in compared.missing:
        covered = sum(compared.common[room, true_room] for room in compared.area)
        if covered < INSIDE_SHARE * compared.true_area[true_room]:
            yield DrawRoom(tuple(outline_true_room(compared.truth == true_room, compared.true_map)))
    for room in compared.wrong:
        yield DeleteRoom(position_of(compared.floor, room))


def propose_merges(compared: Comparison) -> Iterator[Correction]:
    """Merges of the rooms that are parts of a missing true one."""
    for true_room in compared.missing:
        parts = [room for room, area in compared.area.items() if compared.common[room, true_room] > PART_SHARE * area]
        if len(parts) > 1:
            yield merge_by_id(compared.floor, parts)


def propose_splits(compared: Comparison) -> Iterator[Correction]:
    """Splits of the rooms that hold a missing true one and another."""
    for room in compared.area:
        inside = [t for t, area in compared.true_area.items() if compared.common[room, t] > INSIDE_SHARE * area]
        if len(inside) < 2 or not set(inside) & set(compared.missing):
            continue
        own = compared.labels == room
        for true_room in inside:
            this = compared.truth == true_room
            sides = [np.argwhere(own & this), np.argwhere(own & ~this & np.isin(compared.truth, inside))]
            line = fit_border(sides, compared.floor[room].polygon, compared.true_map)
            if line is not None:
                yield line


def fit_border(sides: list[NDArray[np.intp]], room: Polygon, true_map: TrueMap) -> SplitRoom | None:
    """The straight border that separates cells of two true rooms best; None if it does not divide the room."""
    if min(map(len, sides)) < 2:
        return None
    rng = np.random.default_rng(0)
    cells = [side[rng.permutation(len(side))[:MAX_CELLS]] + 0.5 for side in sides]
    points = [np.column_stack(true_map.grid.pixel_to_map(*each.T)) for each in cells]
    xy = np.concatenate(points)
    middle, spread = xy.mean(axis=0), xy.std()
    svm = LinearSVC(C=10, dual=False).fit((xy - middle) / spread, np.repeat([0, 1], [len(each) for each in points]))
    normal = svm.coef_[0] / np.hypot(*svm.coef_[0])
    foot = middle - normal * svm.intercept_[0] / np.hypot(*svm.coef_[0]) * spread
    along = np.array([-normal[1], normal[0]])
    reach = room.length
    largest = shapely.intersection(room, LineString([foot - along * reach, foot + along * reach]))
    pieces = [piece for piece in shapely.get_parts(largest) if isinstance(piece, LineString)]
    if not pieces:
        return None
    # The piece between the two
    near = shapely.MultiPoint(np.concatenate(points)).centroid
    piece = min(pieces, key=lambda each: each.distance(near))
    parts = [largest_part(shapely.MultiPoint(each).buffer(0.1)) for each in points]
    ends = tuple((float(x), float(y)) for x, y in piece.coords)
    return SplitRoom(ends, (position_in(parts[0]), position_in(parts[1])))


def outline_true_room(cells: NDArray[np.bool_], true_map: TrueMap) -> list[tuple[float, float]]:
    """The outline of a true room, as a person would draw it."""
    outlines, _ = outline_labels(cells.astype(np.int32))
    largest = max(outlines, key=lambda each: each.area)
    pixels = shapely.get_coordinates(largest.exterior)
    xy = np.column_stack(true_map.grid.pixel_to_map(pixels[:, 1], pixels[:, 0]))
    simple = shapely.simplify(Polygon(xy), DRAWN_TOLERANCE)
    return [(float(x), float(y)) for x, y in simple.exterior.coords[:-1]]


if __name__ == "__main__":
    main()
