"""Rooms that are open to each other wider than a neck, divided along the lines of their walls."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from pianta._types import Floats, Indices, Mask
from pianta.graphs.components import number_components
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.necks import Clearance
from pianta.layout.structure.pieces import Labels, look_up
from pianta.layout.structure.wall_lines import STEP, WallLines

Window = tuple[slice, slice]

# A part may be divided in its turn, so many times.
ROUNDS = 6
# Metres beside a wall line at which the rooms beside it are looked for: walls are thinner than twice the last.
BESIDE = (0.1, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0)
# How far inside the wall its line is followed, and there an opening is free from -1 to 2 times this; metres.
INSIDE = 0.05


@dataclass(frozen=True, eq=False)
class _Profile:
    """What lies along wall lines: samples every step of so many cells.

    places: shape (L, T, 2). open: shape (L, T), whether no wall is there. beside: shape (K, L, 2), steps across.
    """

    places: Floats
    open: Mask
    beside: Floats
    along: Floats
    step: int
    resolution: float


@dataclass(frozen=True, eq=False)
class _Openings:
    """Openings of wall lines in a room.

    line, first, last: shape (O,), the line, and the samples that it begins with and that it ends before.
    ends: shape (O, 2, 2), the line that closes it, in cells.
    """

    line: Indices
    first: Indices
    last: Indices
    ends: Floats


@dataclass(frozen=True, eq=False)
class _Atoms:
    """A room, cut by all its openings at once: whatever openings are closed, an atom is never divided.

    labels: shape (h, w) of the window of the room, n > 0 for atom n, in reading order. corner: its first row and col.
    area: shape (1 + A,), m². radius: shape (1 + A,), metres.
    edges: shape (E, 2), atoms that touch. opening, on: shape (C,), each opening and each atom that lies on its line.
    """

    labels: Labels
    corner: Floats
    area: Floats
    radius: Floats
    edges: Indices
    opening: Indices
    on: Indices


def split_rooms(
    labels: Labels,
    space: Mask,
    clearance: Clearance,
    lines: WallLines,
    *,
    parameters: StructureParameters,
    resolution: float,
) -> tuple[Labels, Floats]:
    """Rooms divided along wall lines, and the openings that this closed, shape (N, 2, 2): end, then row and col.

    labels: shape (H, W), n > 0 for room n. space: shape (H, W), where a robot may be. clearance: its distance
    transform, in cells. The first part of a room, in reading order, keeps its number; the others get new ones.

    The representative lines of the walls (thesis section 3.1) decide, not the widths: two parts are rooms when most
    of the line between them is wall, or nearly, and its openings are no wider than the narrower part.
    """
    labels, closed = labels.astype(np.int32), [np.zeros((0, 2, 2))]
    # Follow every wall line beyond its face: wall here, an opening there
    profile = _sample_lines(lines, space, parameters.line_reach, resolution)
    rooms = np.unique(labels[labels > 0]).astype(np.intp)
    for _ in range(ROUNDS):
        parts = [np.zeros(0, np.intp)]
        # A room with enough of a line's wall inside may be two
        windows = ndimage.find_objects(labels)
        for room, candidates in _find_candidates(labels, profile, rooms, parameters):
            window = _widen(windows[room - 1])
            openings = _find_openings(labels, room, window, profile, candidates, longest=parameters.longest_opening)
            atoms = _cut_into_atoms(labels[window] == room, window, clearance[window], openings, resolution)
            # Of its lines the one with the smallest openings for the parts that they join divides it
            chosen = _choose_openings(atoms, openings, profile, candidates, parameters)
            if len(chosen):
                close = np.isin(np.arange(len(openings.line)), chosen)
                parts.append(_divide(labels, room, window, atoms, close, least=parameters.split_area))
                closed.append(openings.ends[chosen])
        rooms = np.concatenate(parts)
        if not len(rooms):
            break
    return labels, np.concatenate(closed)


def _sample_lines(lines: WallLines, space: Mask, reach: float, resolution: float) -> _Profile:
    step = max(1, round(STEP / resolution))
    most = int(reach / resolution) // step * step
    inside = max(1.0, INSIDE / resolution)
    distances = np.arange(-most, most + 1, step)[:, None]
    places = lines.points[:, None] + lines.along[:, None] * distances + lines.towards[:, None] * inside
    depths = np.arange(-1, 3) * inside
    is_open = np.logical_and.reduce([look_up(space, places + depth * lines.towards[:, None]) for depth in depths])
    beside = np.array(BESIDE)[:, None, None] / resolution * lines.towards
    return _Profile(places, is_open, beside, lines.along, step, resolution)


def _look_beside(image: Labels, numbers: Indices, places: Floats, beside: Floats) -> tuple[Indices, Indices]:
    """The first number other than 0 on both sides of places, shape (S, 2); beside: shape (K, S, 2), steps across.

    numbers: of each value of the image.
    """
    both = []
    for side in (1, -1):
        found = np.zeros(len(places), np.intp)
        for steps in beside:
            unknown = np.flatnonzero(found == 0)
            found[unknown] = numbers[look_up(image, places[unknown] + side * steps[unknown])]
        both.append(found)
    return both[0], both[1]


def _find_candidates(
    labels: Labels, profile: _Profile, rooms: Indices, parameters: StructureParameters
) -> list[tuple[int, Indices]]:
    """Rooms, large enough for two, that have enough wall of a line with them on both sides, and these lines."""
    line, sample = np.nonzero(~profile.open)
    count = int(labels.max(initial=0)) + 1
    area = np.bincount(labels.ravel(), minlength=count) * profile.resolution**2
    one, other = _look_beside(labels, np.arange(count), profile.places[line, sample], profile.beside[:, line])
    within = (one == other) & (one > 0)
    pairs, samples = np.unique(line[within] + one[within] * len(profile.places), return_counts=True)
    pairs = pairs[samples * profile.step * profile.resolution >= parameters.split_wall]
    room_of, line_of = np.divmod(pairs, max(len(profile.places), 1))
    large = [room for room in rooms.tolist() if area[room] >= 2 * parameters.split_area]
    return [(room, line_of[room_of == room]) for room in large if (room_of == room).any()]


def _widen(window: Window) -> Window:
    """Window with a cell more on all sides, where the image has one."""
    rows, cols = window
    return slice(max(rows.start - 1, 0), rows.stop + 1), slice(max(cols.start - 1, 0), cols.stop + 1)


def _corner(window: Window) -> Floats:
    return np.array([axis.start for axis in window], float)


def _find_openings(
    labels: Labels, room: int, window: Window, profile: _Profile, lines: Indices, *, longest: float
) -> _Openings:
    """Openings of lines within a room, no longer than the longest (metres)."""
    is_open = profile.open[lines] & (look_up(labels[window], profile.places[lines] - _corner(window)) == room)
    change = np.diff(is_open.astype(np.int8), axis=1, prepend=0, append=0)
    (row, first), (_, last) = np.nonzero(change == 1), np.nonzero(change == -1)
    short = (last - first) * profile.step * profile.resolution <= longest
    row, first, last = row[short], first[short], last[short]
    line = lines[row]
    # The jambs are a step beyond the last free samples; a cell more closes it for sure
    beyond = profile.along[line] * (profile.step + 1)
    ends = np.stack([profile.places[line, first] - beyond, profile.places[line, last - 1] + beyond], axis=1)
    return _Openings(line, first, last, ends)


def _cut_into_atoms(
    inside: Mask, window: Window, clearance: Clearance, openings: _Openings, resolution: float
) -> _Atoms:
    from skimage.measure import label

    cell, opening = _rasterize(openings.ends - _corner(window), inside)
    # Cells on the same openings are alike: sums of random numbers tell one set of openings from another
    mark = np.random.default_rng(0).random(len(openings.line))
    kind = np.unique(np.bincount(cell, mark[opening], inside.size), return_inverse=True)[1].reshape(inside.shape) + 1
    pieces = label(np.where(inside, kind, 0), connectivity=1).astype(np.int32)
    edges = [np.zeros((0, 2), np.intp)]
    for one, other in ((pieces[1:], pieces[:-1]), (pieces[:, 1:], pieces[:, :-1])):
        touch = (one != other) & (one > 0) & (other > 0)
        edges.append(np.column_stack([one[touch], other[touch]]))
    radius = np.zeros(int(pieces.max()) + 1)
    np.maximum.at(radius, pieces[inside], clearance[inside])
    area = np.bincount(pieces[inside], minlength=len(radius)).astype(np.float64) * resolution**2
    on = np.unique(np.column_stack([opening, pieces.ravel()[cell]]), axis=0)
    return _Atoms(
        pieces, _corner(window), area, radius * resolution, np.unique(np.concatenate(edges), axis=0), on[:, 0], on[:, 1]
    )


def _rasterize(ends: Floats, inside: Mask) -> tuple[Indices, Indices]:
    """Flat index of the cells inside that lie on lines, shape (N, 2, 2), and the line of each; shapes (C,)."""
    canvas = np.zeros(inside.shape, np.uint8)
    cells = [np.zeros(0, np.intp)]
    for (row0, col0), (row1, col1) in np.rint(ends).astype(int).tolist():
        cv2.line(canvas, (col0, row0), (col1, row1), 1)
        top, left = max(min(row0, row1), 0), max(min(col0, col1), 0)
        box = np.s_[top : max(row0, row1) + 1, left : max(col0, col1) + 1]
        rows, cols = np.nonzero(canvas[box] & inside[box])
        cells.append((rows + top) * inside.shape[1] + cols + left)
        canvas[box] = 0
    return np.concatenate(cells), np.repeat(np.arange(len(ends)), [len(some) for some in cells[1:]])


def _join_atoms(atoms: _Atoms, closed: Mask) -> Indices:
    """Part that each atom is in, shape (1 + A,), when openings are closed; 0 on these; in reading order."""
    kept = np.ones(len(atoms.area), bool)
    kept[0] = False
    kept[atoms.on[closed[atoms.opening]]] = False
    group = number_components(atoms.edges[kept[atoms.edges].all(axis=1)], len(kept))
    part = np.zeros(len(kept), np.intp)
    part[kept] = np.unique(group[kept], return_inverse=True)[1] + 1
    return part


def _choose_openings(
    atoms: _Atoms, openings: _Openings, profile: _Profile, lines: Indices, parameters: StructureParameters
) -> Indices:
    """The openings that part two rooms best: of the line with the least score; none where no line parts two."""
    best, chosen = np.inf, np.zeros(0, np.intp)
    for line in lines.tolist():
        own = openings.line == line
        part = _join_atoms(atoms, own)
        area = np.bincount(part, atoms.area)
        large = area >= parameters.split_area
        large[0] = False
        if not own.any() or large.sum() < 2:
            continue
        places = profile.places[line] - atoms.corner
        beside = np.broadcast_to(profile.beside[:, line, None], (len(profile.beside), *places.shape))
        one, other = _look_beside(atoms.labels, part, places, beside)
        between = (one != other) & large[one] & large[other]
        is_open = profile.open[line] & (look_up(atoms.labels, places) > 0)
        pair = np.where(between, np.minimum(one, other) * len(large) + np.maximum(one, other), -1)
        radius = np.zeros(len(large))
        np.maximum.at(radius, part, atoms.radius)
        for key in np.unique(pair[between & ~is_open]).tolist():
            samples = np.cumsum(np.r_[0, (pair == key) & is_open])
            lengths = samples[openings.last[own]] - samples[openings.first[own]]
            width = 2 * radius[list(divmod(key, len(large)))].min()
            step = profile.step * profile.resolution
            score = _score(
                samples[-1] * step, ((pair == key) & ~is_open).sum() * step, lengths.max() * step, width, parameters
            )
            used = np.flatnonzero(own)[lengths > 0]
            if score < best and _count_large(atoms, openings, used, parameters) > 1:
                best, chosen = score, used
    return chosen


def _score(opened: float, wall: float, longest: float, width: float, parameters: StructureParameters) -> float:
    """Share of the line that is open times longest opening over width; infinite where the parts are one room."""
    if wall < parameters.split_wall or not 0 < opened <= parameters.split_share * (opened + wall):
        return np.inf
    if width < parameters.split_clearance or longest > parameters.split_opening * width:
        return np.inf
    return opened / (opened + wall) * longest / width


def _count_large(atoms: _Atoms, openings: _Openings, used: Indices, parameters: StructureParameters) -> int:
    """Parts of enough area that the openings used leave."""
    part = _join_atoms(atoms, np.isin(np.arange(len(openings.line)), used))
    return int((np.bincount(part, atoms.area)[1:] >= parameters.split_area).sum())


def _divide(labels: Labels, room: int, window: Window, atoms: _Atoms, closed: Mask, *, least: float) -> Indices:
    """Divide a room of the labels, in place, where openings are closed; returns the numbers of its parts."""
    part = _join_atoms(atoms, closed)
    large = np.flatnonzero(np.bincount(part, atoms.area) >= least)
    large = large[large > 0]
    numbers = np.append(room, labels.max() + 1 + np.arange(len(large) - 1))
    number = np.zeros(part.max() + 1, np.int32)
    number[large] = numbers
    inside = labels[window] == room
    parts = number[part][atoms.labels]
    # What is too small, and the cells under the line, go to the nearest part
    nearest = ndimage.distance_transform_edt(parts == 0, return_distances=False, return_indices=True)
    labels[window][inside] = parts[tuple(nearest)][inside]
    return np.asarray(numbers)
