"""Representative lines: clusters of collinear segments (Algorithm 1, third and fourth step)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pianta._types import Floats, Indices
from pianta.layout.parameters import ThesisParameters
from pianta.layout.thesis.segments import Segments

# Mean shift stops when no centre moves by more; radians (as in the experiments of the authors of the thesis).
SHIFT_TOLERANCE = 1e-5
# Centres with smaller gaps are one cluster; radians.
SAME_ANGLE = 1e-2
# Iterations of the mean shift, at most.
MAX_SHIFTS = 200
# Angles are rounded to this, so that a noisy map has few different ones: 0.1° is less than the error of short segments.
ANGLE_STEP = np.radians(0.1)


@dataclass(frozen=True, eq=False)
class RepresentativeLine:
    """The line of a cluster of segments: points p with p · normal = offset.

    angle: of the direction (cos, sin), radians in 0 … π.
    offset: along the normal (-sin, cos), metres of the working grid.
    covered: shape (K, 2), disjoint intervals of the direction coordinate, sorted, that segments project onto, with
        the door gaps between them filled; metres.
    """

    angle: float
    offset: float
    covered: Floats

    @property
    def direction(self) -> Floats:
        """Unit vector along the line."""
        return np.array([np.cos(self.angle), np.sin(self.angle)])

    @property
    def normal(self) -> Floats:
        """Unit vector across the line."""
        return np.array([-np.sin(self.angle), np.cos(self.angle)])

    def cover(self, start: Floats, end: Floats) -> Floats:
        """Length of the intervals start … end of the direction coordinate that segments cover; metres, shape (N,)."""
        lengths = np.cumsum(self.covered[:, 1] - self.covered[:, 0])
        before = np.column_stack([np.append(0.0, lengths[:-1]), lengths])
        knots, covered = self.covered.ravel(), before.ravel()
        return np.asarray(np.interp(end, knots, covered) - np.interp(start, knots, covered))


def cluster_angles(segments: Segments, parameters: ThesisParameters) -> tuple[Indices, Floats]:
    """C ← meanShiftClustering(S): the angular cluster of each segment, shape (N,), and the angle of each cluster.

    Eqs. 3.1 and 3.2, with angles modulo π.
    """
    steps = segments[:, 2:] - segments[:, :2]
    angles = np.arctan2(steps[:, 1], steps[:, 0]) % np.pi
    angles, which, counts = np.unique(
        np.round(angles / ANGLE_STEP) * ANGLE_STEP % np.pi, return_inverse=True, return_counts=True
    )
    # Angles modulo π are averaged as directions of the doubled angle.
    doubled = np.exp(2j * angles) * counts
    centres = angles
    for _ in range(MAX_SHIFTS):
        shifted = np.angle(_angular_kernel(centres, angles, parameters.angle_bandwidth) @ doubled) / 2 % np.pi
        moved = np.abs((shifted - centres + np.pi / 2) % np.pi - np.pi / 2).max(initial=0.0)
        centres = shifted
        if moved <= SHIFT_TOLERANCE:
            break
    labels = _group_circular(centres)
    weighted = np.exp(2j * centres) * counts
    sums = np.bincount(labels, weighted.real) + 1j * np.bincount(labels, weighted.imag)
    return labels[which.ravel()], np.angle(sums) / 2 % np.pi


def chain_spatially(offsets: Floats, line_distance: float) -> Indices:
    """C' ← spatialClustering(C, line_distance) as printed: any two segments less than line_distance apart; shape (N,).

    Offsets in metres. Clusters are those of a single linkage: a chain of near segments is one of them.
    """
    order = np.argsort(offsets, kind="stable")
    labels = np.empty(len(offsets), np.intp)
    labels[order] = np.append(0, np.cumsum(np.diff(offsets[order]) >= line_distance))
    return labels


def cluster_spatially(offsets: Floats, line_distance: float) -> Indices:
    """C' ← spatialClustering(C, line_distance): clusters of parallel lines, given their offsets in metres; shape (N,).

    Neighbouring clusters are joined, nearest first, while their mean lines are less than line_distance apart. (The
    thesis joins any two segments at such a distance, as chain_spatially does; in a map with drift that rule chains
    walls of different rooms.)
    """
    values, which, sizes = np.unique(offsets, return_inverse=True, return_counts=True)
    means, weights = values, sizes.astype(float)
    firsts = np.arange(len(values))
    while len(means) > 1:
        gaps = np.diff(means)
        i = int(gaps.argmin())
        if gaps[i] >= line_distance:
            break
        weight = weights[i] + weights[i + 1]
        means[i] = (means[i] * weights[i] + means[i + 1] * weights[i + 1]) / weight
        weights[i] = weight
        means, weights, firsts = (np.delete(array, i + 1) for array in (means, weights, firsts))
    return np.asarray(np.searchsorted(firsts, which.ravel(), side="right") - 1)


def get_representative_lines(segments: Segments, parameters: ThesisParameters) -> list[RepresentativeLine]:
    """Lines ← getRepresentativeLines(C'): one line through the median of the middles of each spatial cluster.

    Clusters with a total length of segments below line_support are noise, and give no line. Gaps of at most filled_gap
    count as covered, as section 3.3 fills the door gaps of floor plans.
    """
    if not len(segments):
        return []
    middles = (segments[:, :2] + segments[:, 2:]) / 2
    lengths = np.hypot(*(segments[:, 2:] - segments[:, :2]).T)
    angular, angles = cluster_angles(segments, parameters)
    cluster = chain_spatially if parameters.chain_lines else cluster_spatially
    gap = parameters.filled_gap if parameters.fill_gaps else 0.0
    lines = []
    for label, angle in enumerate(angles):
        members = np.flatnonzero(angular == label)
        direction, normal = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        offsets = middles[members] @ normal
        spatial = cluster(offsets, parameters.line_distance)
        for number in range(spatial.max() + 1):
            chosen = members[spatial == number]
            if parameters.drop_weak_lines and lengths[chosen].sum() < parameters.line_support:
                continue
            ends = np.column_stack([segments[chosen, :2] @ direction, segments[chosen, 2:] @ direction])
            median = float(np.median(offsets[spatial == number]))
            lines.append(RepresentativeLine(float(angle), median, join_intervals(np.sort(ends, axis=1), gap=gap)))
    return lines


def _angular_kernel(centres: Floats, angles: Floats, bandwidth: float) -> Floats:
    """Eq. 3.2 between each centre and each angle, modulo π; shape (C, A)."""
    cosines = np.outer(np.cos(centres), np.cos(angles)) + np.outer(np.sin(centres), np.sin(angles))
    # |cos| is the cosine of the difference modulo π.
    return np.asarray(np.clip(1 - (1 - np.abs(cosines)) / bandwidth, 0.0, None) ** 2)


def _group_circular(angles: Floats) -> Indices:
    """Groups of angles modulo π with gaps of more than SAME_ANGLE between them; shape (N,)."""
    order = np.argsort(angles)
    labels = np.empty(len(angles), np.intp)
    labels[order] = np.append(0, np.cumsum(np.diff(angles[order]) > SAME_ANGLE))
    wraps = angles[order[0]] + np.pi - angles[order[-1]] <= SAME_ANGLE
    return labels % labels.max() if wraps and labels.max() > 0 else labels


def join_intervals(intervals: Floats, *, gap: float) -> Floats:
    """Union of intervals, shape (N, 2), and of the gaps of at most gap between them: disjoint, sorted, shape (K, 2)."""
    starts, ends = intervals[np.argsort(intervals[:, 0], kind="stable")].T
    reach = np.maximum.accumulate(ends)
    breaks = np.flatnonzero(starts[1:] > reach[:-1] + gap)
    return np.column_stack([starts[np.append(0, breaks + 1)], reach[np.append(breaks, len(reach) - 1)]])
