"""Doors of a plan as lines from jamb to jamb, whatever told them; and the rooms on both sides of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from scipy import ndimage
from shapely import LineString, Point, STRtree

from pianta.floor import Door, Room
from pianta.plan.door_swings import SPREAD, Swing, agree_on_size
from pianta.plan.regions import DOOR, DOOR_CELLS, Regions
from pianta.plan.sheet import Floats, Mask
from pianta.plan.symbol_poses import PlacedSymbol

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
# Doors whose middles are within this share of the wider one are one door.
SAME = 0.75
# How far beside a door its rooms are looked for, metres: beyond half of the thickest wall. Its line may be drawn this
# far beside the wall.
BESIDE, ASIDE = (0.2, 0.4, 0.7, 1.0), 0.7


@dataclass(frozen=True, eq=False)
class PlanDoors:
    """Doors of a sheet.

    lines: from jamb to jamb, shape (D, 2, 2), row and col in pixels of the sheet. doubtful: shape (D,), those that are
    doors only where a room has no other.
    """

    lines: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    doubtful: Mask = field(default_factory=lambda: np.zeros(0, bool))


def find_doors(regions: Regions, swings: Sequence[Swing], symbols: Sequence[PlacedSymbol], named: Floats) -> PlanDoors:
    """The doors that anything tells.

    named: shape (N, 2, 2), doors that the file names. Of several that tell one door the file comes first, then swings
    of which many have one width, then symbols and other swings, which know the jambs, too, where the network thinks
    that a door may be; then what only the network sees.
    """
    sure = _agree(swings)
    shortest = SHORTEST_REGION * DOOR_CELLS * regions.cell_px
    told = [(line, False) for line in [*named, *(swing.closed for swing in sure)]]
    drawn = [(symbol.jambs, SURE_SYMBOL) for symbol in symbols if symbol.kind == "door" and symbol.jambs is not None]
    drawn += [(swing.closed, SEEN_FROM) for swing in swings if swing not in sure]
    seen = [(line, chance, least) for line, least in drawn if (chance := _door_near(regions, line)) >= SEEN_FROM]
    told += [(line, chance < least) for line, chance, least in seen]
    for line in find_door_regions(regions):
        is_short = np.hypot(*(line[1] - line[0])) < shortest
        told.append((line, bool(is_short or _door_near(regions, line) < SURE_REGION)))
    kept: list[tuple[Floats, bool]] = []
    for line, is_doubtful in told:
        if all(not _is_same(line, other) for other, _ in kept):
            kept.append((np.asarray(line, float), is_doubtful))
    lines = np.array([line for line, _ in kept]).reshape(-1, 2, 2)
    return PlanDoors(lines, np.array([is_doubtful for _, is_doubtful in kept], bool))


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
