"""Walls as straight parts with a thickness, from the gaps between the outlines of rooms, and the doors in them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, combinations, pairwise
from typing import TypeAlias

import numpy as np
import shapely
from shapely import LineString, Polygon, STRtree

from pianta._types import Floats, Indices
from pianta.floor import Door, Floor

# Metres, chosen by hand:
MAX_GAP = 0.6  # between rooms with a wall between them; wider gaps have a wall on each side
OUTER_THICKNESS = 0.15  # of a wall with no room behind it
SHARED_THICKNESS = 0.1  # of the wall between rooms that touch
MIN_THICKNESS = 0.02
MIN_LENGTH = 0.02
ROUGHNESS = 0.05  # the size of a cell; outlines are followed so closely
# Heights, metres: a usual storey, and the clear height of a door by DIN 18100.
WALL_HEIGHT = 2.7
DOOR_HEIGHT = 2.0
# Cosine of the angle between two faces of one wall; 15°, chosen by hand.
MIN_PARALLEL = 0.966
# Of the length of a door, in one part of a wall; else the door gets a part of its own.
MIN_HOSTED = 0.8

Interval: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class WallPart:
    """A straight part of a wall. line: its middle, from end to end. rooms: ids of those on its sides."""

    line: LineString
    thickness: float
    rooms: tuple[int, ...]

    @cached_property
    def ends(self) -> Floats:
        """Both ends, shape (2, 2)."""
        return np.asarray(shapely.get_coordinates(self.line))

    @property
    def length(self) -> float:
        """From end to end, metres."""
        return float(self.line.length)

    @cached_property
    def direction(self) -> Floats:
        """The unit vector from end to end."""
        along = self.ends[1] - self.ends[0]
        return np.asarray(along / np.hypot(*along))

    @property
    def area(self) -> Polygon:
        """Its rectangle."""
        return self.line.buffer(self.thickness / 2, cap_style="flat")

    def cut(self, start: float, end: float) -> WallPart:
        """The piece between two lengths along it, metres."""
        points = self.ends[0] + np.outer([start, end], self.direction)
        return replace(self, line=LineString(points))


@dataclass(frozen=True)
class Walls:
    """The walls of a floor: parts without the doors, and for each door of the floor the part that it is in.

    parts: with the parts of doors whole, to be cut by openings. hosts: door -> index of its part.
    solid: all parts, cut at doors, from floor to ceiling.
    """

    parts: tuple[WallPart, ...]
    hosts: tuple[int, ...]
    solid: tuple[WallPart, ...]


def find_walls(floor: Floor) -> Walls:
    """The walls of a floor.

    A face of a room and one of another room that is parallel and at most MAX_GAP away are the faces of one part. What
    remains of faces has a part of OUTER_THICKNESS behind it, or less where another room begins.
    """
    parts = _close_corners([*_list_parts(floor)], floor)
    hosts: list[int] = []
    hosted: dict[int, list[Interval]] = {}
    removed: dict[int, list[Interval]] = {}
    beside: dict[frozenset[int], list[int]] = {}
    for index, part in enumerate(parts):
        beside.setdefault(frozenset(part.rooms), []).append(index)
    for door in floor.doors:
        near = sorted(chain.from_iterable(beside.get(rooms, []) for rooms in _list_sides(door)))
        spans = {index: span for index in near if (span := _find_span(parts[index], door)) is not None}
        host = max(spans, key=lambda index: spans[index][1] - spans[index][0], default=None)
        if host is None or spans[host][1] - spans[host][0] < MIN_HOSTED * door.line.length:
            parts.append(_make_part(door))
            host, own = len(parts) - 1, (0.0, float(door.line.length))
        else:
            own = spans.pop(host)
        hosts.append(host)
        hosted.setdefault(host, []).append(own)
        for index, span in spans.items():
            removed.setdefault(index, []).append(span)
    pieces = [
        (index, piece)
        for index, part in enumerate(parts)
        for piece in _cut(part, removed.get(index, []), uncut=index in hosted)
    ]
    positions = {index: position for position, (index, _) in enumerate(pieces)}
    solid = [
        piece
        for index, part in enumerate(parts)
        for piece in _cut(part, [*removed.get(index, []), *hosted.get(index, [])])
    ]
    return Walls(tuple(piece for _, piece in pieces), tuple(positions[host] for host in hosts), tuple(solid))


def door_depth(part: WallPart) -> float:
    """How deep the opening of a door is in its wall, with some more on both sides to cut it clearly; metres."""
    return part.thickness + 2 * MIN_THICKNESS


@dataclass(frozen=True)
class _Faces:
    """The edges of the outlines of rooms. starts, along: shape (N, 2), along: unit vectors; outward: to their right."""

    starts: Floats
    along: Floats
    outward: Floats
    lengths: Floats
    rooms: Sequence[int]


def _list_faces(floor: Floor) -> _Faces:
    starts, ends, rooms = [np.zeros((0, 2))], [np.zeros((0, 2))], []
    for room in floor:
        smooth = shapely.orient_polygons(room.polygon.simplify(ROUGHNESS))
        for ring in (smooth.exterior, *smooth.interiors):
            corners = shapely.get_coordinates(ring)
            starts.append(corners[:-1])
            ends.append(corners[1:])
            rooms += [room.id] * (len(corners) - 1)
    first, along = np.concatenate(starts), np.concatenate(ends) - np.concatenate(starts)
    lengths = np.hypot(*along.T)
    along = along / np.maximum(lengths, 1e-9)[:, None]
    return _Faces(first, along, along[:, ::-1] * (1, -1), lengths, rooms)


def _list_parts(floor: Floor) -> Iterator[WallPart]:
    """The parts between faces, then those behind the rest of each face."""
    faces = _list_faces(floor)
    outlines = [room.polygon for room in floor]
    ids = [room.id for room in floor]
    rooms = STRtree(outlines)
    corners = (
        faces.starts[:, None] + faces.along[:, None] * faces.lengths[:, None, None] * np.array([0, 1])[None, :, None]
    )
    tree = STRtree(shapely.linestrings(corners)) if len(corners) else STRtree([])
    reaches = [
        _make_box(faces, index, (0, faces.lengths[index]), -ROUGHNESS, MAX_GAP) for index in range(len(faces.rooms))
    ]
    for index, reach in enumerate(reaches):
        covered: list[Interval] = []
        for other, span, gaps in _list_opposite(faces, index, tree.query(reach)):
            for piece in _subtract(span, covered):
                if index < other:
                    yield _part_between(faces, index, other, piece, gaps)
            covered.append(span)
        for piece in _subtract((0.0, float(faces.lengths[index])), covered):
            behind = [outlines[room] for room in rooms.query(reach) if ids[room] != faces.rooms[index]]
            yield from _parts_behind(faces, index, piece, behind)


def _list_opposite(faces: _Faces, index: int, candidates: Indices) -> list[tuple[int, Interval, Floats]]:
    """Faces across the gap: index, where along this face, and the offset and slope of the gap; the nearest first."""
    opposite = []
    start, along, outward = faces.starts[index], faces.along[index], faces.outward[index]
    for other in map(int, candidates[faces.along[candidates] @ along <= -MIN_PARALLEL]):
        ends = np.array([faces.starts[other], faces.starts[other] + faces.along[other] * faces.lengths[other]]) - start
        (high, low), depths = ends @ along, ends @ outward
        span = max(0.0, float(low)), min(float(faces.lengths[index]), float(high))
        if span[1] - span[0] < MIN_LENGTH:
            continue
        slope = (depths[0] - depths[1]) / (high - low)
        gap = depths[1] + slope * (np.mean(span) - low)
        if -ROUGHNESS <= gap <= MAX_GAP:
            opposite.append((gap, other, span, np.array([depths[1] - slope * low, slope])))
    return [entry[1:] for entry in sorted(opposite, key=lambda entry: entry[:2])]


def _part_between(faces: _Faces, index: int, other: int, span: Interval, gap: Floats) -> WallPart:
    gaps = np.maximum(gap[0] + gap[1] * np.array(span), 0)
    middle = faces.starts[index] + np.outer(span, faces.along[index]) + np.outer(gaps / 2, faces.outward[index])
    thickness = float(gaps.mean()) if gaps.mean() > MIN_THICKNESS else SHARED_THICKNESS
    rooms = tuple(dict.fromkeys(sorted((faces.rooms[index], faces.rooms[other]))))
    return WallPart(LineString(middle), thickness, rooms)


def _parts_behind(faces: _Faces, index: int, span: Interval, others: Sequence[Polygon]) -> Iterator[WallPart]:
    """The parts behind a face: they are thinner where another room begins behind it."""
    box = _make_box(faces, index, span, 0, OUTER_THICKNESS)
    begins: list[tuple[float, float, float]] = []
    for area in shapely.get_parts([box.intersection(other) for other in others]):
        points = shapely.get_coordinates(area) - faces.starts[index]
        along, depths = points @ faces.along[index], points @ faces.outward[index]
        # A room that only touches this one at an end of the face is beside it
        if len(along) and np.ptp(along) > MIN_LENGTH:
            begins.append((float(along.min()), float(along.max()), float(depths.min())))
    bounds = [span[0]]
    for bound in sorted(bound for low, high, _ in begins for bound in (low, high)):
        if bounds[-1] + MIN_LENGTH < bound < span[1] - MIN_LENGTH:
            bounds.append(bound)
    for start, end in pairwise([*bounds, span[1]]):
        middle = (start + end) / 2
        depth = min((depth for low, high, depth in begins if low <= middle <= high), default=OUTER_THICKNESS)
        thickness = float(np.clip(depth, MIN_THICKNESS, OUTER_THICKNESS))
        face = faces.starts[index] + np.outer((start, end), faces.along[index])
        yield WallPart(LineString(face + faces.outward[index] * thickness / 2), thickness, (faces.rooms[index],))


def _make_box(faces: _Faces, index: int, span: Interval, near: float, far: float) -> Polygon:
    face = faces.starts[index] + np.outer(span, faces.along[index])
    return Polygon([*(face + faces.outward[index] * near), *(face[::-1] + faces.outward[index] * far)])


def _subtract(span: Interval, covered: Sequence[Interval]) -> list[Interval]:
    """What remains of an interval, without pieces shorter than MIN_LENGTH."""
    rest = [span]
    for low, high in covered:
        rest = [piece for start, end in rest for piece in ((start, min(end, low)), (max(start, high), end))]
        rest = [(start, end) for start, end in rest if end - start > MIN_LENGTH]
    return [(start, end) for start, end in rest if end - start > MIN_LENGTH]


def _close_corners(parts: Sequence[WallPart], floor: Floor) -> list[WallPart]:
    """Parts that are longer at ends behind which no room begins, so that they meet at corners."""
    if not parts:
        return []
    tree = STRtree(shapely.buffer([room.polygon for room in floor], -ROUGHNESS / 2))
    # Shape (N, 2, 2): part, end, x and y
    ends = np.stack([part.ends for part in parts])
    longer = ends + OUTER_THICKNESS * np.stack([part.direction for part in parts])[:, None] * [[-1], [1]]
    beyond = shapely.linestrings(np.stack([ends, longer], axis=2).reshape(-1, 2, 2))
    widths = np.repeat([part.thickness / 2 for part in parts], 2)
    blocked = np.zeros(len(beyond), bool)
    blocked[tree.query(shapely.buffer(beyond, widths, cap_style="flat"), "intersects")[0]] = True
    closed = np.where(blocked.reshape(-1, 2, 1), ends, longer)
    return [replace(part, line=LineString(line)) for part, line in zip(parts, closed, strict=True)]


def _list_sides(door: Door) -> Iterator[frozenset[int]]:
    """The rooms that a part beside a door may have: some of the rooms of the door, or none."""
    rooms = sorted({*door.room_ids})
    return (frozenset(some) for count in range(len(rooms) + 1) for some in combinations(rooms, count))


def _find_span(part: WallPart, door: Door) -> Interval | None:
    """Where along a part that has some of its rooms a door is; None if it is elsewhere."""
    if not door.line.length:
        return None
    ends = shapely.get_coordinates(door.line)
    along = (ends[1] - ends[0]) / door.line.length
    across = part.direction[::-1] * (-1, 1)
    depth = abs(across @ (ends.mean(axis=0) - part.ends[0]))
    if abs(along @ part.direction) < MIN_PARALLEL or depth > MAX_GAP / 2 + part.thickness / 2:
        return None
    low, high = np.sort((ends - part.ends[0]) @ part.direction)
    span = max(0.0, float(low)), min(part.length, float(high))
    return span if span[1] - span[0] > MIN_LENGTH else None


def _make_part(door: Door) -> WallPart:
    """A part for a door in no wall, of its length."""
    ends = shapely.get_coordinates(door.line)[[0, -1]]
    if not door.line.length:
        ends[1, 0] += SHARED_THICKNESS
    return WallPart(LineString(ends), SHARED_THICKNESS, door.room_ids)


def _cut(part: WallPart, spans: Sequence[Interval], *, uncut: bool = False) -> Iterator[WallPart]:
    """The pieces of a part between intervals; the part itself if it is to stay whole."""
    for start, end in [(0.0, part.length)] if uncut or not spans else _subtract((0.0, part.length), spans):
        yield part.cut(start, end)
