"""Fit of a door that opens by a quarter turn to the ink around a circle: its leaf, jamb, hinge and arc.

Directions are seen from the centre of the circle and counted from 0 to N_DIRECTIONS - 1; the arc is around the middle
one. Radii are relative to the radius of the circle.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask

Directions = NDArray[np.int64]

N_DIRECTIONS = 96
QUARTER = N_DIRECTIONS // 4
# Radii at which the ink about a circle is sampled
RADII = np.linspace(0.125, 1.375, 41)


@dataclass(frozen=True, kw_only=True)
class SwingFitParameters:
    """Thresholds of `fit_swings`; radii are relative to the circle's. Chosen by hand, no fit is on record."""

    min_arc: int = 17  # directions that the arc of a door spans
    max_arc: int = 32  # directions; walls lengthen the arc
    leaf_radii: tuple[float, float] = (0.25, 0.94)  # where the leaf is drawn
    jamb_radii: tuple[float, float] = (1.06, 1.3)  # where the wall beyond the jamb is drawn
    hinge_radii: tuple[float, float] = (0.125, 0.3)  # where the wall beyond the hinge is drawn, opposite to the door
    arc_radii: tuple[float, float] = (0.94, 1.06)  # where the arc is looked for
    exact_arc_radii: tuple[float, float] = (0.98, 1.02)  # where the ink of the arc adds to the score
    inner_radii: tuple[float, float] = (0.35, 0.84)  # what is clear within the arc
    outer_radii: tuple[float, float] = (1.16, 1.25)  # what is clear around the arc
    min_drawn: float = 0.6  # share of ink along each of leaf, jamb and hinge
    max_clutter: float = 0.25  # share of ink within or around the arc
    outer_allowance: float = 0.1  # share of ink that is allowed around the arc, where walls and text may lie
    leaf_reach: int = 4  # directions from the end of the arc to the leaf, at most
    leaf_tolerance: float = 0.05  # share of ink; directions that miss the best by less are part of the leaf
    quarter_tolerance: int = 4  # directions that an arc may lack of a quarter without ending at the closed door
    wall_reach: int = 3  # directions from the closed door to jamb and hinge, at most
    stroke: int = 5  # directions next to leaf and closed door that are their strokes, and no clutter
    closed_leaf_weight: float = 0.3  # how much the score loses if a leaf is drawn in the closed door, too


PARAMETERS = SwingFitParameters()


@dataclass(frozen=True)
class SwingFit:
    """A swing fitted to a circle.

    score: how completely it is drawn, less the clutter; up to 1. leaf, closed: directions of the leaf and of the closed
    door, from the hinge.
    """

    score: float
    leaf: int
    closed: int


def fit_swings(rays: Mask) -> list[SwingFit | None]:
    """Fit the drawing of a swing to the ink around the centre of each circle.

    rays: whether there is ink, by circle, direction and radius, shape (M, N_DIRECTIONS, len(RADII)).
    Returns None for a circle whose arc is too short or too long, where leaf, jamb or hinge is not drawn, or where there
    is other ink within or around the arc.
    """
    first, last = _arc_ends(np.asarray(rays[:, :, _radii_between(PARAMETERS.arc_radii)].any(axis=2)))
    span = last - first
    fitting = np.flatnonzero((span >= PARAMETERS.min_arc) & (span <= PARAMETERS.max_arc))
    shares, first, last = _InkShares.measure(rays[fitting]), first[fitting], last[fitting]
    one, other = shares.score(first, last, way=1), shares.score(last, first, way=-1)
    best = np.where(other[:, :1] > one[:, :1], other, one)
    fits: list[SwingFit | None] = [None] * len(rays)
    for index, (score, leaf, closed) in zip(fitting.tolist(), best.tolist(), strict=True):
        if score > -inf:
            fits[index] = SwingFit(score, int(leaf), int(closed))
    return fits


@dataclass(frozen=True, eq=False)
class _InkShares:
    """Shares of ink in each direction about circles, shape (M, N_DIRECTIONS), 0 … 1.

    leaf, jamb: along a leaf, and beyond the arc. hinge: at the hinge, opposite to a door of that direction.
    inner, outer: within and around the arc. arc: whether the arc is drawn.
    """

    leaf: Floats
    jamb: Floats
    hinge: Floats
    inner: Floats
    outer: Floats
    arc: Mask

    @staticmethod
    def measure(rays: Mask) -> _InkShares:
        """The shares from the ink around circles; rays: as of `fit_swings`."""
        p = PARAMETERS
        widened = rays | np.roll(rays, 1, axis=1) | np.roll(rays, -1, axis=1)
        leaf, jamb, hinge = (
            widened[:, :, _radii_between(ends)].mean(axis=2) for ends in (p.leaf_radii, p.jamb_radii, p.hinge_radii)
        )
        inner, outer = (rays[:, :, _radii_between(ends)].mean(axis=2) for ends in (p.inner_radii, p.outer_radii))
        arc = np.asarray(rays[:, :, _radii_between(p.exact_arc_radii)].any(axis=2))
        return _InkShares(leaf, jamb, np.roll(hinge, -N_DIRECTIONS // 2, axis=1), inner, outer, arc)

    def score(self, end: Directions, other_end: Directions, *, way: int) -> Floats:
        """Score, leaf and closed door of each circle if the leaf is at one end of its arc, shape (M, 3).

        way: in which the door closes, 1 or -1. The score is -inf where there is no swing.
        """
        p = PARAMETERS
        circles = np.arange(len(end))
        # The leaf is the middle of the directions near the end of the arc that have the most ink
        around = np.arange(-p.leaf_reach, p.leaf_reach + 1)
        along = self.leaf[circles[:, None], end[:, None] + around]
        most = along >= along.max(axis=1, keepdims=True) - p.leaf_tolerance
        leaf = end + np.rint(most @ around / most.sum(axis=1)).astype(np.int64)
        # A long arc goes on in the wall, so the door closes after a quarter; a short one ends at the closed door
        is_long = way * (other_end - leaf) >= QUARTER - p.quarter_tolerance
        closed = np.where(is_long, leaf + way * QUARTER, other_end)
        near = (closed[:, None] + np.arange(-p.wall_reach, p.wall_reach + 1)) % N_DIRECTIONS
        jamb, hinge = (share[circles[:, None], near].max(axis=1) for share in (self.jamb, self.hinge))
        low, high = np.sort([leaf + p.stroke * way, closed - p.stroke * way], axis=0)
        directions = np.arange(N_DIRECTIONS)
        swept = (low[:, None] <= directions) & (high[:, None] >= directions)
        inner, outer, arc = (
            (share * swept).sum(axis=1) / swept.sum(axis=1) for share in (self.inner, self.outer, self.arc)
        )
        clutter = np.maximum(inner, outer - p.outer_allowance)
        parts = np.stack([self.leaf[circles, leaf], jamb, hinge])
        closed_leaf = self.leaf[circles, closed % N_DIRECTIONS]
        score = parts.mean(axis=0) * arc * (1 - p.closed_leaf_weight * closed_leaf) - clutter
        # A wall behind the leaf that is drawn better than the jamb is the wall of another door
        is_behind = self.jamb[circles, leaf] > jamb
        no_swing = (parts.min(axis=0) < p.min_drawn) | (clutter > p.max_clutter) | is_behind
        return np.column_stack([np.where(no_swing, -inf, score), leaf, closed])


def _arc_ends(rings: Mask) -> tuple[Directions, Directions]:
    """First and last direction of the arc on each ring, shape (M,) each: the ink that is connected with the middle one.

    rings: whether there is ink in each direction, shape (M, N_DIRECTIONS). A gap of one direction does not end the arc.
    """
    circles, ends = np.arange(len(rings)), []
    for way in (-1, 1):
        end = np.full(len(rings), N_DIRECTIONS // 2)
        goes_on = np.ones(len(rings), bool)
        while goes_on.any():
            # All that is looked up near an end stays within the directions
            goes_on &= (end > 6) & (end < N_DIRECTIONS - 7)
            goes_on &= rings[circles, end + way] | rings[circles, end + 2 * way]
            end = end + way * goes_on
        ends.append(end)
    return ends[0], ends[1]


def _radii_between(ends: tuple[float, float]) -> slice:
    """The indices of RADII from one radius to another."""
    low, high = ends
    first, last = np.searchsorted(RADII, (low - 1e-9, high + 1e-9))
    return slice(int(first), int(last))
