"""Right-angled outlines where a building has right angles: corners at wall lines, areas and doors kept."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple, TypeAlias

import numpy as np
import shapely
from shapely import LineString, Polygon, STRtree

from pianta._types import Floats
from pianta.floor._floor import Floor
from pianta.floor._parts import Door

# Chosen by hand, metres unless stated:
TOLERANCE = 0.12  # of the outline that is divided into walls; between a cell and a wall
MIN_WALL = 0.3  # shorter walls do not count for the directions
# Shorter sides are steps of cells, doorways and jambs; the smaller ones where an outline would change too much.
MIN_SIDES = (0.3, 0.2, 0.1)
WALL_REACH = 0.1  # from a side of a room to the line of a wall on which it is put
MAX_AREA_CHANGE = 0.02  # share of the area of a room
MAX_SKEW = 0.15  # share of the length of an outline that runs more than SKEW across both directions
SKEW = np.radians(15)
MIN_SHARE = 0.15  # of the length of all walls, in a direction such as that of a wing
MIN_IOU = 0.9  # of the straight outline with the given one
MAX_DOOR_SHIFT = 0.25  # by which a door may be further away from a room than it was
MIN_OVERLAP = 1e-6  # square metres, rounding
DIRECTION_BINS = 90  # of one degree, over the quarter turn after which walls are parallel again


class Straightened(NamedTuple):
    """A floor, and the ids of its rooms whose outlines are as they were."""

    floor: Floor
    unchanged: tuple[int, ...]


def straighten_floor(floor: Floor) -> Straightened:
    """Give the rooms of a floor right angles where the building has them.

    A room stays as it is if its walls run across its two directions, if it would change its area by more than
    MAX_AREA_CHANGE or overlap another room, or if one of its doors would be in no wall.
    """
    # The directions of the building, by the length of its walls
    directions = find_directions(room.polygon for room in floor)
    lines = [line for line in floor.walls if line.length > MIN_WALL]
    outlines = {room.id: room.polygon for room in floor}
    straight: dict[int, Polygon] = {}
    for room in floor:
        # Sides along two directions, on the lines of walls near them, or else where they keep the area
        for min_side, near in product(MIN_SIDES, (lines, [])):
            candidates = (_straighten(room.polygon, angle, near, min_side) for angle in directions)
            fitting = [each for each in candidates if each is not None and _is_same(room.polygon, each)]
            if fitting:
                straight[room.id] = max(fitting, key=lambda each: _iou(room.polygon, each))
                break
    # Rooms do not overlap, and doors stay in walls; a room that cannot keep to this is as it was
    _drop_overlaps(outlines, straight)
    _drop_without_doors(floor, outlines, straight)
    rooms = tuple(replace(room, polygon=straight.get(room.id, room.polygon)) for room in floor)
    unchanged = tuple(room.id for room in floor if room.id not in straight)
    doors = tuple(_move_door(door, {**outlines, **straight}, straight) for door in floor.doors)
    return Straightened(replace(floor, rooms=rooms, doors=doors), unchanged)


def find_directions(outlines: Iterable[Polygon]) -> list[float]:
    """The directions of walls, radians below a quarter turn, the most frequent first.

    Walls along a direction and across it count together; each direction has MIN_SHARE of the length of all walls.
    """
    edges = [np.diff(shapely.get_coordinates(outline.simplify(TOLERANCE).exterior), axis=0) for outline in outlines]
    steps = np.concatenate([np.zeros((0, 2)), *edges])
    lengths, angles = np.hypot(*steps.T), np.arctan2(steps[:, 1], steps[:, 0]) % (np.pi / 2)
    weights = np.where(lengths > MIN_WALL, lengths, 0)
    if not weights.sum():
        return []
    counts = np.bincount((np.degrees(angles).round().astype(int)) % DIRECTION_BINS, weights, DIRECTION_BINS)
    smooth = sum(np.roll(counts, shift) for shift in (-2, -1, 0, 1, 2))
    directions: list[float] = []
    for peak in np.argsort(-smooth):
        centre = np.radians(float(peak))
        near = np.abs(_fold(angles - centre)) < np.radians(3)
        far = all(abs(_fold(centre - other)) > np.radians(5) for other in directions)
        if far and weights[near].sum() >= MIN_SHARE * weights.sum():
            directions.append(
                float(centre + np.average(_fold(angles[near] - centre), weights=weights[near] ** 2 + 1e-12))
            )
    return directions


def _fold(angles: Floats) -> Floats:
    """Differences of directions, within an eighth of a turn on both sides."""
    return (angles + np.pi / 4) % (np.pi / 2) - np.pi / 4


def _straighten(outline: Polygon, angle: float, lines: Sequence[LineString], min_side: float) -> Polygon | None:
    """The outline with sides along an angle and across it, of min_side or longer; None if it has other walls."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    levels = _list_levels(outline, lines, turn)
    rings = [
        _straighten_ring(shapely.get_coordinates(ring)[:-1] @ turn, levels, min_side)
        for ring in (outline.exterior, *outline.interiors)
    ]
    if rings[0] is None:
        return None
    holes = [ring @ turn.T for ring in rings[1:] if ring is not None]
    polygon = Polygon(rings[0] @ turn.T, holes)
    return polygon if polygon.is_valid and polygon.area else None


def _list_levels(outline: Polygon, lines: Sequence[LineString], turn: Floats) -> tuple[Floats, Floats]:
    """The x of walls that run along y, and the y of those that run along x, near an outline, turned."""
    levels: tuple[list[float], list[float]] = ([], [])
    for line in lines:
        if line.distance(outline.exterior) <= WALL_REACH:
            ends = shapely.get_coordinates(line)[[0, -1]] @ turn
            across = np.abs(ends[1] - ends[0])
            axis = int(across[0] > across[1])  # constant coordinate of the wall
            if across[axis] <= np.sin(SKEW) * across.max():
                levels[axis].append(float(ends[:, axis].mean()))
    return np.array(levels[0]), np.array(levels[1])


def _straighten_ring(points: Floats, levels: tuple[Floats, Floats], min_side: float) -> Floats | None:
    """Corners of a ring with sides along x and y; None if walls run across, or fewer than four sides remain."""
    corners = shapely.get_coordinates(shapely.LinearRing(points).simplify(min(TOLERANCE, min_side / 2)))[:-1]
    steps = np.roll(corners, -1, axis=0) - corners
    lengths = np.hypot(*steps.T)
    # Walls across both directions
    skewed = np.abs(_fold(np.arctan2(steps[:, 1], steps[:, 0]))) > SKEW
    if lengths[skewed & (lengths > MIN_WALL)].sum() > MAX_SKEW * lengths.sum():
        return None
    # Each side is along x (its y is constant) or along y; neighbours along one axis are one side
    axes = (np.abs(steps[:, 0]) > np.abs(steps[:, 1])).astype(int)
    sides = _merge_sides([(int(axis), [piece]) for axis, *piece in zip(axes, steps, corners, strict=True)], min_side)
    if len(sides) < 4:
        return None
    # The constant coordinate of a side: that of a wall line, or the mean along it, which keeps the area
    values = [_find_level(axis, pieces, levels[axis]) for axis, pieces in sides]
    return _join_sides([axis for axis, _ in sides], values)


# The axis along whose coordinate it is constant, and its steps and their starts.
Side: TypeAlias = tuple[int, list[Sequence[Floats]]]


def _merge_sides(sides: list[Side], min_side: float) -> list[Side]:
    """Join neighbours along one axis; then, from the shortest on, leave out sides below min_side and join those beside.

    Sides that are left out are steps: what is before and after them is one wall.
    """
    while len(sides) > 4:
        same = [index for index in range(len(sides)) if sides[index][0] == sides[index - 1][0]]
        if same:
            sides = [*sides[same[0] :], *sides[: same[0]]]
            sides = [(sides[0][0], sides[-1][1] + sides[0][1]), *sides[1:-1]]
            continue
        lengths = [abs(sum(float(step[1 - axis]) for step, _ in pieces)) for axis, pieces in sides]
        shortest = int(np.argmin(lengths))
        if lengths[shortest] >= min_side:
            break
        after, *others, before = [*sides[shortest + 1 :], *sides[:shortest]]
        sides = [(before[0], before[1] + after[1]), *others]
    return sides


def _find_level(axis: int, pieces: Sequence[Sequence[Floats]], levels: Floats) -> float:
    """The constant coordinate of a side along x or y: axis 1 has a constant y."""
    weights = np.array([abs(step[1 - axis]) for step, _ in pieces]) + 1e-9
    values = np.array([corner[axis] + step[axis] / 2 for step, corner in pieces])
    mean = float(np.average(values, weights=weights))
    main = float(values[weights.argmax()])
    near = levels[np.abs(levels - main) <= WALL_REACH] if len(levels) else levels
    return float(near[np.abs(near - main).argmin()]) if len(near) else mean


def _join_sides(axes: Sequence[int], values: Sequence[float]) -> Floats | None:
    """The corners where each side meets the one before it."""
    if any(axis == before for axis, before in zip(axes, [axes[-1], *axes[:-1]], strict=True)):
        return None
    corners = np.zeros((len(axes), 2))
    for index, (axis, value) in enumerate(zip(axes, values, strict=True)):
        corners[index, axis], corners[index, 1 - axis] = value, values[index - 1]
    return corners


def _is_same(outline: Polygon, straight: Polygon) -> bool:
    change = abs(straight.area / outline.area - 1)
    return change <= MAX_AREA_CHANGE and _iou(outline, straight) >= MIN_IOU


def _iou(one: Polygon, other: Polygon) -> float:
    return float(one.intersection(other).area / one.union(other).area)


def _drop_overlaps(outlines: dict[int, Polygon], straight: dict[int, Polygon]) -> None:
    """Cut the larger of two rooms that overlap, or else take the outlines back until no straight one overlaps."""
    ids = [*outlines]
    while straight:
        current = [straight.get(each, outlines[each]) for each in ids]
        before = STRtree(current).query(current, "intersects").T
        pairs = [(ids[a], ids[b]) for a, b in before if a < b and (ids[a] in straight or ids[b] in straight)]
        pairs = [pair for pair in pairs if _overlaps(pair, outlines, straight)]
        if not pairs:
            return
        for pair in pairs:
            if _overlaps(pair, outlines, straight):
                _separate(pair, outlines, straight)


def _separate(pair: tuple[int, int], outlines: dict[int, Polygon], straight: dict[int, Polygon]) -> None:
    """Cut the larger of two rooms, or else the smaller one, or else take an outline back."""
    larger, smaller = sorted(pair, key=lambda each: -outlines[each].area)
    for room, other in ((larger, smaller), (smaller, larger)):
        if room in straight:
            rest = straight[room].difference(straight.get(other, outlines[other]))
            cut = max(shapely.get_parts(rest), key=shapely.area, default=None)
            # A straight room keeps its right angles only beside another straight one
            if other in straight and isinstance(cut, Polygon) and _is_same(outlines[room], cut):
                straight[room] = cut
                return
    del straight[larger if larger in straight else smaller]


def _overlaps(pair: tuple[int, int], outlines: dict[int, Polygon], straight: dict[int, Polygon]) -> bool:
    """Whether two rooms overlap more than they did."""
    one, other = (straight.get(each, outlines[each]) for each in pair)
    before = outlines[pair[0]].intersection(outlines[pair[1]]).area
    return bool(one.intersection(other).area > before + MIN_OVERLAP)


def _drop_without_doors(floor: Floor, outlines: dict[int, Polygon], straight: dict[int, Polygon]) -> None:
    """Take back the outlines of rooms that a door would be too far from, and then those that overlap them."""
    for door in floor.doors:
        middle = door.line.interpolate(0.5, normalized=True)
        for room in door.room_ids:
            if room in straight:
                shift = straight[room].exterior.distance(middle) - outlines[room].exterior.distance(middle)
                if shift > MAX_DOOR_SHIFT:
                    del straight[room]
    _drop_overlaps(outlines, straight)


def _move_door(door: Door, outlines: dict[int, Polygon], straight: dict[int, Polygon]) -> Door:
    """A door in the middle between the sides of its straight rooms next to it, parallel to the longer of them."""
    if not door.line.length or not straight.keys() >= {*door.room_ids}:
        return door
    ends = shapely.get_coordinates(door.line)[[0, -1]]
    middle, along = ends.mean(axis=0), (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
    sides = []
    for room in door.room_ids:
        corners = shapely.get_coordinates(outlines[room].exterior)
        edges = np.stack([corners[:-1], corners[1:]], axis=1)
        units = (edges[:, 1] - edges[:, 0]) / np.maximum(np.hypot(*(edges[:, 1] - edges[:, 0]).T), 1e-9)[:, None]
        parallel = np.abs(units @ along) > np.cos(2 * SKEW)
        if not parallel.any():
            return door
        distances = shapely.distance(shapely.linestrings(edges), shapely.Point(middle))
        nearest = int(np.where(parallel, distances, np.inf).argmin())
        sides.append((edges[nearest, 0], units[nearest]))
    direction = sides[0][1] * np.sign(sides[0][1] @ along)
    normal = direction[::-1] * (-1, 1)
    shift = np.mean([(start - middle) @ normal for start, _ in sides])
    centre, half = middle + shift * normal, door.line.length / 2
    return replace(door, line=LineString([centre - half * direction, centre + half * direction]))


def measure_right_angles(outlines: Iterable[Polygon]) -> Floats:
    """Share of the corners of each outline that are right angles, to a degree."""
    shares = []
    for outline in outlines:
        corners = shapely.get_coordinates(outline.exterior)[:-1]
        steps = np.roll(corners, -1, axis=0) - corners
        headings = np.arctan2(steps[:, 1], steps[:, 0])
        turns = np.abs(_fold(headings - np.roll(headings, 1)))
        straight_on = np.abs((headings - np.roll(headings, 1) + np.pi) % (2 * np.pi) - np.pi) < np.radians(1)
        right = (turns < np.radians(1)) & ~straight_on
        shares.append(float(right[~straight_on].mean()) if (~straight_on).any() else 0.0)
    return np.array(shares)
