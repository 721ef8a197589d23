"""Doors of a plan as lines from jamb to jamb, whatever told them; and the rooms on both sides of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from scipy import ndimage
from shapely import LineString, Point, STRtree

from pianta._types import Floats, Mask
from pianta.floor import Door, Room
from pianta.plan.doors.swings import SPREAD, Swing, agree_on_size
from pianta.plan.symbols.poses import PlacedSymbol
from pianta.plan.walls.regions import DOOR, DOOR_CELLS, Regions

# A region is a door from this probability on.
DOOR_FROM = 0.4
# Cells of a region, at least.
LEAST_CELLS = 4
# So many swings of one width are doors.
SURE_SWINGS = 8
# Any other swing or symbol is a door where this is the probability of a door somewhere near its line.
SEEN_FROM = 0.1
# Below these probabilities a region and a symbol are doubtful doors, and so is a region shorter than this share of one.
SURE_REGION, SURE_SYMBOL, SHORTEST_REGION = 0.6, 0.4, 0.6
# A leaf closes on the face of its wall, so many widths before the middle.
HALF_WALL = 0.1
# The leaves of a double door end within this share of their width of each other.
MEET = 0.3
# Doors whose middles are within this share of the wider one are one door.
SAME = 0.75
# How far beside a door its rooms are looked for, metres: beyond half of the thickest wall. Its line may be drawn this
# far beside the wall.
BESIDE, ASIDE = (0.2, 0.4, 0.7, 1.0), 0.7


@dataclass(frozen=True, eq=False)
class PlanDoors:
    """Doors of a sheet.

    lines: from jamb to jamb in the middle of the wall, shape (D, 2, 2), row and col in pixels of the sheet. closed: the
    same where their leaves close, on the face of the wall. doubtful: shape (D,), those that are doors only where a room
    has no other.
    """

    lines: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    closed: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    doubtful: Mask = field(default_factory=lambda: np.zeros(0, bool))


def find_doors(regions: Regions, swings: Sequence[Swing], symbols: Sequence[PlacedSymbol], named: Floats) -> PlanDoors:
    """The doors that anything tells.

    named: shape (N, 2, 2), doors that the file names. Of several that tell one door the file comes first, then swings
    of which many have one width, then symbols and other swings, which know the jambs, too, where the network thinks
    that a door may be; then what only the network sees.
    """
    sure = _agree(swings)
    shortest = SHORTEST_REGION * DOOR_CELLS * regions.cell_px
    told = [(line, line, False) for line in named]
    told += [(line, moved, False) for line, moved in _close_leaves(sure)]
    drawn = [
        (*_close_symbol(symbol), SURE_SYMBOL)
        for symbol in symbols
        if symbol.kind == "door" and symbol.jambs is not None
    ]
    drawn += [(*leaves, SEEN_FROM) for leaves in _close_leaves([swing for swing in swings if swing not in sure])]
    for line, moved, least in drawn:
        if (chance := _door_near(regions, line)) >= SEEN_FROM:
            told.append((line, moved, chance < least))
    for line in find_door_regions(regions):
        is_short = np.hypot(*(line[1] - line[0])) < shortest
        told.append((line, line, bool(is_short or _door_near(regions, line) < SURE_REGION)))
    kept: list[tuple[Floats, Floats, bool]] = []
    for line, moved, is_doubtful in told:
        if all(not _is_same(line, other) for other, _, _ in kept):
            kept.append((line, moved, is_doubtful))
    closed, lines, doubtful = zip(*kept, strict=True) if kept else ((), (), ())
    return PlanDoors(
        np.array(lines, float).reshape(-1, 2, 2), np.array(closed, float).reshape(-1, 2, 2), np.array(doubtful, bool)
    )


def _close_leaves(swings: Sequence[Swing]) -> list[tuple[Floats, Floats]]:
    """Each door where its leaves close, and in the middle of its wall; two leaves that meet are one door."""
    doors = []
    single = list(swings)
    while single:
        swing = single.pop(0)
        other = next((other for other in single if _meet(swing, other)), None)
        line, ajar = swing.closed, swing.open_end - swing.hinge
        if other is not None:
            single.remove(other)
            line = np.array([swing.hinge, other.hinge])
        doors.append((line, line - HALF_WALL * ajar))
    return doors


def _meet(swing: Swing, other: Swing) -> bool:
    """Whether two swings are the leaves of a double door: they meet in the middle and open to the same side."""
    radius = (swing.radius + other.radius) / 2
    apart = np.hypot(*(swing.jamb - other.jamb)), np.hypot(*(swing.hinge - other.hinge))
    opens = (swing.open_end - swing.hinge) @ (other.open_end - other.hinge)
    return bool(
        apart[0] < MEET * radius and apart[1] > (2 - MEET) * radius and opens > 0.9 * swing.radius * other.radius
    )


def _close_symbol(symbol: PlacedSymbol) -> tuple[Floats, Floats]:
    """The line of a door where it closes, and in the middle of its wall."""
    line = np.asarray(symbol.jambs, float)
    across = (line[1] - line[0])[::-1] * (-1, 1)
    side = np.sign(across @ (symbol.corners.mean(axis=0) - line.mean(axis=0)))
    return line, line - HALF_WALL * side * across


def find_door_regions(regions: Regions) -> Floats:
    """Doors that the network sees, shape (D, 2, 2): the principal axis of each region, as long as the region."""
    door = regions.probabilities[DOOR]
    labels, _ = ndimage.label(door >= DOOR_FROM, np.ones((3, 3)))
    lines = []
    for number, window in enumerate(ndimage.find_objects(labels), start=1):
        cells = np.argwhere(labels[window] == number) + [axis.start for axis in window]
        if len(cells) < LEAST_CELLS:
            continue
        weights = door[tuple(cells.T)].astype(float)
        middle = np.average(cells, axis=0, weights=weights)
        along = np.linalg.svd((cells - middle) * np.sqrt(weights)[:, None], full_matrices=False)[2][0]
        half = (np.ptp((cells - middle) @ along) + 1) / 2
        lines.append([middle - half * along, middle + half * along])
    return (np.array(lines).reshape(-1, 2, 2) + 0.5) * regions.cell_px


def join_rooms(rooms: Sequence[Room], lines: Sequence[LineString]) -> list[Door]:
    """Doors along lines, metres, each between the rooms on its two sides, or into the only one.

    A line may lie some way off the wall between two rooms, inside of one. With the same room on both sides, or none,
    it is no door.
    """
    tree = STRtree([room.polygon for room in rooms])
    doors = []
    for line in lines:
        sides = [[_find_room(line, side * far, rooms, tree) for far in BESIDE] for side in (1, -1)]
        pairs = [pair for pair, far in zip(zip(*sides, strict=True), BESIDE, strict=True) if far <= ASIDE]
        first = tuple(next((room for room in found if room is not None), None) for found in sides)
        known = next((pair for pair in pairs if None not in pair and len(set(pair)) == 2), first)
        within = [room for room in known if room is not None]
        if within and len(set(known)) == 2:
            doors.append(Door((within[0], within[1] if len(within) == 2 else None), line, line.length))
    return doors


def _agree(swings: Sequence[Swing]) -> list[Swing]:
    """The swings of the usual width, where they are so many that nobody doubts that they are doors."""
    size = agree_on_size(swings)
    if size is None or size.count < SURE_SWINGS:
        return []
    return [swing for swing in swings if abs(np.log(swing.radius / size.px)) <= np.log1p(SPREAD)]


def _door_near(regions: Regions, line: Floats) -> float:
    """The highest probability of a door within a quarter of its length from the middle of a line."""
    door = regions.probabilities[DOOR]
    middle, reach = line.mean(axis=0) / regions.cell_px, np.hypot(*(line[1] - line[0])) / 4 / regions.cell_px + 1
    low = np.maximum(np.floor(middle - reach).astype(int), 0)
    high = np.maximum(np.ceil(middle + reach).astype(int), 0)
    return float(door[low[0] : high[0], low[1] : high[1]].max(initial=0.0))


def _is_same(line: Floats, other: Floats) -> bool:
    width = max(np.hypot(*(line[1] - line[0])), np.hypot(*(other[1] - other[0])))
    return bool(np.hypot(*(line.mean(axis=0) - other.mean(axis=0))) < SAME * width)


def _find_room(line: LineString, aside: float, rooms: Sequence[Room], tree: STRtree) -> int | None:
    """The id of the room so far beside the middle of a line, metres, to the left if positive; None for outside."""
    (start, end) = shapely.get_coordinates(line)
    across = np.array([start[1] - end[1], end[0] - start[0]]) / max(line.length, 1e-9)
    hit = tree.query(Point((start + end) / 2 + aside * across), predicate="within")
    return rooms[int(hit[0])].id if len(hit) else None
