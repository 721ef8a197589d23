"""Splitting rooms that are open to each other wider than a neck, along the lines of their walls."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.graphs.components import number_components
from pianta.layout._label_images import list_contacts
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.necks import Clearance
from pianta.layout.structure.regions import sample_image
from pianta.layout.structure.wall_lines import SAMPLE_SPACING, WallLines

Window = tuple[slice, slice]

# The constants were chosen by hand on the maps of the benches (docs/methods/structure.md).
# Parts of a room are split again, up to this many times in all.
MAX_ROUNDS = 6
# Distances from a wall line at which the rooms on its two sides are searched, nearest first: walls are thinner than
# twice the last; metres.
SIDE_DISTANCES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0)
# Depth inside the wall at which its line is followed; an opening is free at -1, 0, 1 and 2 times this depth; metres.
INSIDE_DEPTH = 0.05


@dataclass(frozen=True, eq=False)
class _Profile:
    """Samples along wall lines, every step cells.

    samples: shape (L, T, 2), row and col. open: shape (L, T), whether there is no wall.
    to_sides: shape (K, L, 2), vectors across each line to where the rooms beside it are searched; cells.
    along: shape (L, 2), unit vector along each line. resolution: metres per cell.
    """

    samples: Floats
    open: Mask
    to_sides: Floats
    along: Floats
    step: int
    resolution: float


@dataclass(frozen=True, eq=False)
class _Openings:
    """Openings of wall lines in a room.

    line, first, last: shape (O,), the line, its first sample in the opening, and the one after the last.
    ends: shape (O, 2, 2), the line that closes it, in cells.
    """

    line: Indices
    first: Indices
    last: Indices
    ends: Floats


@dataclass(frozen=True, eq=False)
class _Atoms:
    """A room cut by all its openings at once: no combination of closed openings divides an atom.

    labels: shape (h, w) of the window of the room, n > 0 for atom n, in reading order. corner: its first row and col.
    area: shape (1 + A,), m². radius: shape (1 + A,), of the largest circle; metres.
    contacts: shape (E, 2), atoms that touch.
    crossed_opening, crossed_atom: shape (C,), each opening, and each atom that lies on its line.
    """

    labels: LabelImage
    corner: Floats
    area: Floats
    radius: Floats
    contacts: Indices
    crossed_opening: Indices
    crossed_atom: Indices


def split_rooms(
    labels: LabelImage,
    space: Mask,
    clearance: Clearance,
    lines: WallLines,
    *,
    parameters: StructureParameters,
    resolution: float,
) -> tuple[LabelImage, Floats]:
    """Rooms split along wall lines, and the openings closed by this, shape (N, 2, 2): end, then row and col.

    labels: shape (H, W), n > 0 for room n. space: shape (H, W), the free cells. clearance: its distance transform, in
    cells. The first part of a room, in reading order, keeps its number; the others get new ones.

    The representative lines of the walls (thesis section 3.1) decide, not the widths: two parts are rooms if enough of
    the line between them is wall, and its openings are about as wide as the narrower part at most.
    """
    labels, closed_lines = labels.astype(np.int32), [np.zeros((0, 2, 2))]
    # Follow every wall line beyond its face, where it is wall or opening
    profile = _sample_lines(lines, space, parameters.line_reach, resolution)
    rooms = np.unique(labels[labels > 0]).astype(np.intp)
    for _ in range(MAX_ROUNDS):
        parts = [np.zeros(0, np.intp)]
        # A room that contains enough wall of a line may be two rooms
        windows = ndimage.find_objects(labels)
        for room, candidates in _find_candidates(labels, profile, rooms, parameters):
            window = _widen(windows[room - 1])
            openings = _find_openings(labels, room, window, profile, candidates, longest=parameters.longest_opening)
            atoms = _cut_into_atoms(labels[window] == room, window, clearance[window], openings, resolution)
            # The line with the lowest score divides the room
            chosen = _choose_openings(atoms, openings, profile, candidates, parameters)
            if len(chosen):
                closed = np.isin(np.arange(len(openings.line)), chosen)
                parts.append(_divide(labels, room, window, atoms, closed, min_area=parameters.split_area))
                closed_lines.append(openings.ends[chosen])
        rooms = np.concatenate(parts)
        if not len(rooms):
            break
    return labels, np.concatenate(closed_lines)


def _sample_lines(lines: WallLines, space: Mask, reach: float, resolution: float) -> _Profile:
    """Sample each line up to `reach` metres on both sides of its point; space: shape (H, W), the free cells."""
    step = max(1, round(SAMPLE_SPACING / resolution))
    steps = int(reach / resolution) // step * step
    depth = max(1.0, INSIDE_DEPTH / resolution)
    distances = np.arange(-steps, steps + 1, step)[:, None]
    samples = lines.points[:, None] + lines.along[:, None] * distances + lines.towards[:, None] * depth
    depths = np.arange(-1, 3) * depth
    is_open = np.logical_and.reduce([sample_image(space, samples + d * lines.towards[:, None]) for d in depths])
    to_sides = np.array(SIDE_DISTANCES)[:, None, None] / resolution * lines.towards
    return _Profile(samples, is_open, to_sides, lines.along, step, resolution)


def _sample_sides(image: LabelImage, numbers: Indices, samples: Floats, to_sides: Floats) -> tuple[Indices, Indices]:
    """The nearest number other than 0 on both sides of samples, shape (S, 2); to_sides: shape (K, S, 2).

    numbers: the number of each value of the image.
    """
    both = []
    for side in (1, -1):
        nearest = np.zeros(len(samples), np.intp)
        for step in to_sides:
            missing = np.flatnonzero(nearest == 0)
            nearest[missing] = numbers[sample_image(image, samples[missing] + side * step[missing])]
        both.append(nearest)
    return both[0], both[1]


def _find_candidates(
    labels: LabelImage, profile: _Profile, rooms: Indices, parameters: StructureParameters
) -> list[tuple[int, Indices]]:
    """Rooms large enough for two, and the lines of which they have enough wall with the room on both sides."""
    line, sample = np.nonzero(~profile.open)
    count = int(labels.max(initial=0)) + 1
    area = np.bincount(labels.ravel(), minlength=count) * profile.resolution**2
    one, other = _sample_sides(labels, np.arange(count), profile.samples[line, sample], profile.to_sides[:, line])
    within = (one == other) & (one > 0)
    pairs, samples = np.unique(line[within] + one[within] * len(profile.samples), return_counts=True)
    pairs = pairs[samples * profile.step * profile.resolution >= parameters.split_wall]
    pair_room, pair_line = np.divmod(pairs, max(len(profile.samples), 1))
    large = [room for room in rooms.tolist() if area[room] >= 2 * parameters.split_area]
    return [(room, pair_line[pair_room == room]) for room in large if (pair_room == room).any()]


def _widen(window: Window) -> Window:
    """Window with one cell more on all sides, within the image."""
    rows, cols = window
    return slice(max(rows.start - 1, 0), rows.stop + 1), slice(max(cols.start - 1, 0), cols.stop + 1)


def _corner(window: Window) -> Floats:
    return np.array([axis.start for axis in window], float)


def _find_openings(
    labels: LabelImage, room: int, window: Window, profile: _Profile, lines: Indices, *, longest: float
) -> _Openings:
    """Openings of lines within a room, no longer than the longest (metres)."""
    in_room = sample_image(labels[window], profile.samples[lines] - _corner(window)) == room
    is_open = profile.open[lines] & in_room
    change = np.diff(is_open.astype(np.int8), axis=1, prepend=0, append=0)
    (row, first), (_, last) = np.nonzero(change == 1), np.nonzero(change == -1)
    short = (last - first) * profile.step * profile.resolution <= longest
    row, first, last = row[short], first[short], last[short]
    line = lines[row]
    # The jambs are one step beyond the last free samples; one cell more makes sure that the line closes the opening.
    beyond = profile.along[line] * (profile.step + 1)
    ends = np.stack([profile.samples[line, first] - beyond, profile.samples[line, last - 1] + beyond], axis=1)
    return _Openings(line, first, last, ends)


def _cut_into_atoms(
    inside: Mask, window: Window, clearance: Clearance, openings: _Openings, resolution: float
) -> _Atoms:
    """Cut a room by the lines of its openings; inside: shape (h, w), its cells in the window. clearance: in cells."""
    from skimage.measure import label

    cell, opening = _rasterize(openings.ends - _corner(window), inside)
    # Each set of openings is identified by the sum of a random number for each opening.
    key = np.random.default_rng(0).random(len(openings.line))
    sums = np.bincount(cell, key[opening], inside.size)
    opening_set = np.unique(sums, return_inverse=True)[1].reshape(inside.shape) + 1
    labels = label(np.where(inside, opening_set, 0), connectivity=1).astype(np.int32)
    radius = np.zeros(int(labels.max()) + 1)
    np.maximum.at(radius, labels[inside], clearance[inside])
    area = np.bincount(labels[inside], minlength=len(radius)).astype(np.float64) * resolution**2
    crossed = np.unique(np.column_stack([opening, labels.ravel()[cell]]), axis=0)
    contacts, _ = list_contacts(labels)
    return _Atoms(labels, _corner(window), area, radius * resolution, contacts, crossed[:, 0], crossed[:, 1])


def _rasterize(ends: Floats, inside: Mask) -> tuple[Indices, Indices]:
    """Flat index of the cells inside that lie on lines, shape (N, 2, 2), and the line of each; shapes (C,)."""
    image = np.zeros(inside.shape, np.uint8)
    cells = [np.zeros(0, np.intp)]
    for (row0, col0), (row1, col1) in np.rint(ends).astype(int).tolist():
        cv2.line(image, (col0, row0), (col1, row1), 1)
        top, left = max(min(row0, row1), 0), max(min(col0, col1), 0)
        box = np.s_[top : max(row0, row1) + 1, left : max(col0, col1) + 1]
        rows, cols = np.nonzero(image[box] & inside[box])
        cells.append((rows + top) * inside.shape[1] + cols + left)
        image[box] = 0
    return np.concatenate(cells), np.repeat(np.arange(len(ends)), [len(line_cells) for line_cells in cells[1:]])


def _join_atoms(atoms: _Atoms, closed: Mask) -> Indices:
    """Part of each atom, shape (1 + A,), in reading order, when openings are closed; 0 for the atoms on these."""
    free = np.ones(len(atoms.area), bool)
    free[0] = False
    free[atoms.crossed_atom[closed[atoms.crossed_opening]]] = False
    group = number_components(atoms.contacts[free[atoms.contacts].all(axis=1)], len(free))
    part = np.zeros(len(free), np.intp)
    part[free] = np.unique(group[free], return_inverse=True)[1] + 1
    return part


def _choose_openings(
    atoms: _Atoms, openings: _Openings, profile: _Profile, lines: Indices, parameters: StructureParameters
) -> Indices:
    """The openings to close: those of the line with the lowest score; empty if no line divides the room."""
    best, chosen = np.inf, np.zeros(0, np.intp)
    for line in lines.tolist():
        own = openings.line == line
        part = _join_atoms(atoms, own)
        area = np.bincount(part, atoms.area)
        large = area >= parameters.split_area
        large[0] = False
        if not own.any() or large.sum() < 2:
            continue
        samples = profile.samples[line] - atoms.corner
        to_sides = np.broadcast_to(profile.to_sides[:, line, None], (len(profile.to_sides), *samples.shape))
        one, other = _sample_sides(atoms.labels, part, samples, to_sides)
        between = (one != other) & large[one] & large[other]
        is_open = profile.open[line] & (sample_image(atoms.labels, samples) > 0)
        pair = np.where(between, np.minimum(one, other) * len(large) + np.maximum(one, other), -1)
        radius = np.zeros(len(large))
        np.maximum.at(radius, part, atoms.radius)
        for key in np.unique(pair[between & ~is_open]).tolist():
            open_samples = np.cumsum(np.r_[0, (pair == key) & is_open])
            lengths = open_samples[openings.last[own]] - open_samples[openings.first[own]]
            width = 2 * radius[list(divmod(key, len(large)))].min()
            step = profile.step * profile.resolution
            score = _score(
                open_samples[-1] * step,
                ((pair == key) & ~is_open).sum() * step,
                lengths.max() * step,
                width,
                parameters,
            )
            used = np.flatnonzero(own)[lengths > 0]
            if score < best and _count_large_parts(atoms, openings, used, parameters) > 1:
                best, chosen = score, used
    return chosen


def _score(opened: float, wall: float, longest: float, width: float, parameters: StructureParameters) -> float:
    """Open share of the line times longest opening over width; infinite if the parts are one room."""
    if wall < parameters.split_wall or not 0 < opened <= parameters.split_share * (opened + wall):
        return np.inf
    if width < parameters.split_clearance or longest > parameters.split_opening * width:
        return np.inf
    return opened / (opened + wall) * longest / width


def _count_large_parts(atoms: _Atoms, openings: _Openings, used: Indices, parameters: StructureParameters) -> int:
    """Number of parts of enough area when the used openings are closed."""
    part = _join_atoms(atoms, np.isin(np.arange(len(openings.line)), used))
    return int((np.bincount(part, atoms.area)[1:] >= parameters.split_area).sum())


def _divide(labels: LabelImage, room: int, window: Window, atoms: _Atoms, closed: Mask, *, min_area: float) -> Indices:
    """Divide a room of the labels, in place, where openings are closed; returns the numbers of its parts."""
    part = _join_atoms(atoms, closed)
    large = np.flatnonzero(np.bincount(part, atoms.area) >= min_area)
    large = large[large > 0]
    numbers = np.append(room, labels.max() + 1 + np.arange(len(large) - 1))
    number = np.zeros(part.max() + 1, np.int32)
    number[large] = numbers
    inside = labels[window] == room
    parts = number[part][atoms.labels]
    # Parts that are too small, and the cells under the line, go to the nearest part
    nearest = ndimage.distance_transform_edt(parts == 0, return_distances=False, return_indices=True)
    labels[window][inside] = parts[tuple(nearest)][inside]
    return np.asarray(numbers)
