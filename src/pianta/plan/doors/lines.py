"""Doors of a plan as lines from jamb to jamb, from all evidence; and the rooms on both sides of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import shapely
from scipy import ndimage
from shapely import LineString, Point, STRtree

from pianta._types import Floats, Mask
from pianta.floor import Door, Floor, Room
from pianta.plan.doors.swings import PARAMETERS as SWING_PARAMETERS
from pianta.plan.doors.swings import Swing, consensus_door_width
from pianta.plan.symbols.poses import PlacedSymbol
from pianta.plan.walls.segmentation import DOOR, DOOR_CELLS, ClassMap


@dataclass(frozen=True, kw_only=True)
class DoorParameters:
    """Thresholds of `find_doors` and `join_rooms`; probabilities are the network's of a door.

    Chosen by hand, no fit is on record.
    """

    min_probability: float = 0.4  # in each cell of a door that only the network finds
    min_cells: int = 4  # of such a door
    certain_probability: float = 0.6  # of such a door; below, it is uncertain
    certain_length: float = 0.6  # of such a door, in door widths; shorter ones are uncertain
    n_certain_swings: int = 8  # with at least as many swings of equal radius, all count as doors
    min_probability_nearby: float = 0.1  # near any other swing, and near a symbol; below, it is no door
    certain_symbol_probability: float = 0.4  # near a symbol; below, it is uncertain
    half_wall: float = 0.1  # door widths from the face of the wall, where a leaf closes, to its middle
    double_leaf_gap: float = 0.3  # door widths between the ends of the two leaves of a double door, at most
    double_leaf_cosine: float = 0.9  # of the angle between its two open leaves, at least
    same_door_distance: float = 0.75  # between middles, in widths of the wider door: nearer ones are the same
    probe_distances: tuple[float, ...] = (0.2, 0.4, 0.7, 1.0)  # m beside a door, where its rooms are looked for
    max_wall_offset: float = 0.7  # m between a door's line and its wall
    narrowest: float = (
        0.3  # m of a door or an opening: people do not fit through narrower ones, which hatches of walls look like
    )


PARAMETERS = DoorParameters()


@dataclass(frozen=True, eq=False)
class PlanDoors:
    """Doors of a sheet.

    lines: from jamb to jamb in the middle of the wall, shape (D, 2, 2), row and col in pixels of the sheet.
    closed: the same on the face of the wall, where their leaves close.
    uncertain: shape (D,), which are doors only if one of their rooms has no other.
    """

    lines: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    closed: Floats = field(default_factory=lambda: np.zeros((0, 2, 2)))
    uncertain: Mask = field(default_factory=lambda: np.zeros(0, bool))


def find_doors(
    class_map: ClassMap, swings: Sequence[Swing], symbols: Sequence[PlacedSymbol], named: Floats
) -> PlanDoors:
    """The doors of a sheet by all evidence.

    named: shape (N, 2, 2), doors that the file names or draws. If several kinds of evidence find the same door, the
    first of these counts: the file; the swings if many have one radius; symbols, then other swings, where the network
    finds a door possible; the network alone, which does not know the jambs.
    """
    certain = _swings_of_usual_width(swings)
    candidates = [(line, line, False) for line in named]
    candidates += [(closed, line, False) for closed, line in _close_leaves(certain)]
    least = PARAMETERS.min_probability_nearby
    drawn_lines = [
        (*_close_symbol(symbol), PARAMETERS.certain_symbol_probability)
        for symbol in symbols
        if symbol.kind == "door" and symbol.jambs is not None
    ]
    drawn_lines += [(*lines, least) for lines in _close_leaves([swing for swing in swings if swing not in certain])]
    for closed, line, certain_from in drawn_lines:
        if (probability := _probability_near(class_map, closed)) >= least:
            candidates.append((closed, line, probability < certain_from))
    shortest = PARAMETERS.certain_length * DOOR_CELLS * class_map.cell_px
    for line in find_network_doors(class_map):
        is_short = np.hypot(*(line[1] - line[0])) < shortest
        is_faint = _probability_near(class_map, line) < PARAMETERS.certain_probability
        candidates.append((line, line, bool(is_short or is_faint)))
    doors: list[tuple[Floats, Floats, bool]] = []
    for candidate in candidates:
        if all(not _is_same(candidate[0], other) for other, _, _ in doors):
            doors.append(candidate)
    return PlanDoors(
        lines=np.array([line for _, line, _ in doors], float).reshape(-1, 2, 2),
        closed=np.array([closed for closed, _, _ in doors], float).reshape(-1, 2, 2),
        uncertain=np.array([is_uncertain for _, _, is_uncertain in doors], bool),
    )


def _swings_of_usual_width(swings: Sequence[Swing]) -> list[Swing]:
    """The swings of the usual radius; none if too few agree to be certainly doors."""
    width = consensus_door_width(swings)
    if width is None or width.count < PARAMETERS.n_certain_swings:
        return []
    spread = np.log1p(SWING_PARAMETERS.radius_spread)
    return [swing for swing in swings if abs(np.log(swing.radius / width.px)) <= spread]


def _close_leaves(swings: Sequence[Swing]) -> list[tuple[Floats, Floats]]:
    """The line of each door where its leaves close, and in the middle of its wall; a double door is one."""
    doors = []
    single = list(swings)
    while single:
        swing = single.pop(0)
        other = next((other for other in single if _is_double_door(swing, other)), None)
        line, opened = swing.closed, swing.open_end - swing.hinge
        if other is not None:
            single.remove(other)
            line = np.array([swing.hinge, other.hinge])
        doors.append((line, line - PARAMETERS.half_wall * opened))
    return doors


def _is_double_door(swing: Swing, other: Swing) -> bool:
    """Whether two swings are the leaves of a double door: they meet in the middle and open to the same side."""
    radius, gap = (swing.radius + other.radius) / 2, PARAMETERS.double_leaf_gap
    jambs, hinges = np.hypot(*(swing.jamb - other.jamb)), np.hypot(*(swing.hinge - other.hinge))
    along = (swing.open_end - swing.hinge) @ (other.open_end - other.hinge)
    is_parallel = along > PARAMETERS.double_leaf_cosine * swing.radius * other.radius
    return bool(jambs < gap * radius and hinges > (2 - gap) * radius and is_parallel)


def _close_symbol(symbol: PlacedSymbol) -> tuple[Floats, Floats]:
    """The line of a door where it closes, and in the middle of its wall."""
    line = np.asarray(symbol.jambs, float)
    across = (line[1] - line[0])[::-1] * (-1, 1)
    side = np.sign(across @ (symbol.corners.mean(axis=0) - line.mean(axis=0)))
    return line, line - PARAMETERS.half_wall * side * across


def find_network_doors(class_map: ClassMap) -> Floats:
    """Doors that the network finds, shape (D, 2, 2): the principal axis of each region, as long as the region."""
    door = class_map.probabilities[DOOR]
    labels, _ = ndimage.label(door >= PARAMETERS.min_probability, np.ones((3, 3)))
    lines = []
    for number, window in enumerate(ndimage.find_objects(labels), start=1):
        cells = np.argwhere(labels[window] == number) + [axis.start for axis in window]
        if len(cells) < PARAMETERS.min_cells:
            continue
        weights = door[tuple(cells.T)].astype(float)
        middle = np.average(cells, axis=0, weights=weights)
        along = np.linalg.svd((cells - middle) * np.sqrt(weights)[:, None], full_matrices=False)[2][0]
        half = (np.ptp((cells - middle) @ along) + 1) / 2
        lines.append([middle - half * along, middle + half * along])
    return (np.array(lines).reshape(-1, 2, 2) + 0.5) * class_map.cell_px


def _probability_near(class_map: ClassMap, line: Floats) -> float:
    """The highest probability of a door within a quarter of a line's length from its middle."""
    door = class_map.probabilities[DOOR]
    middle = line.mean(axis=0) / class_map.cell_px
    reach = np.hypot(*(line[1] - line[0])) / 4 / class_map.cell_px + 1
    low = np.maximum(np.floor(middle - reach).astype(int), 0)
    high = np.maximum(np.ceil(middle + reach).astype(int), 0)
    return float(door[low[0] : high[0], low[1] : high[1]].max(initial=0.0))


def _is_same(line: Floats, other: Floats) -> bool:
    width = max(np.hypot(*(line[1] - line[0])), np.hypot(*(other[1] - other[0])))
    return bool(np.hypot(*(line.mean(axis=0) - other.mean(axis=0))) < PARAMETERS.same_door_distance * width)


def join_rooms(rooms: Sequence[Room], lines: Sequence[LineString]) -> list[Door]:
    """Doors along lines, metres, each between the rooms on its two sides, or into the only one.

    A line may lie beside the wall between two rooms, inside one of them. With the same room on both sides, or no room,
    it is no door.
    """
    tree = STRtree([room.polygon for room in rooms])
    doors = []
    for line in lines:
        sides = [[_room_beside(line, way * far, rooms, tree) for far in PARAMETERS.probe_distances] for way in (1, -1)]
        pairs = zip(*sides, strict=True)
        near = [
            pair
            for pair, far in zip(pairs, PARAMETERS.probe_distances, strict=True)
            if far <= PARAMETERS.max_wall_offset
        ]
        nearest = tuple(next((room for room in side if room is not None), None) for side in sides)
        joined = next((pair for pair in near if None not in pair and len(set(pair)) == 2), nearest)
        within = [room for room in joined if room is not None]
        if within and len(set(joined)) == 2:
            doors.append(Door((within[0], within[1] if len(within) == 2 else None), line, line.length))
    return doors


def drop_narrow_doors(floor: Floor) -> Floor:
    """The floor, in metres, without doors and openings that are too narrow for people."""
    return replace(floor, doors=tuple(door for door in floor.doors if door.width >= PARAMETERS.narrowest))


def _room_beside(line: LineString, distance: float, rooms: Sequence[Room], tree: STRtree) -> int | None:
    """The id of the room at a distance, metres, from the middle of a line, left if positive; None if outside."""
    (start, end) = shapely.get_coordinates(line)
    across = np.array([start[1] - end[1], end[0] - start[0]]) / max(line.length, 1e-9)
    hit = tree.query(Point((start + end) / 2 + distance * across), predicate="within")
    return rooms[int(hit[0])].id if len(hit) else None
