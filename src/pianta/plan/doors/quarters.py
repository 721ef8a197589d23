"""Quarters about circles: whether leaf, jamb and hinge are drawn as of a door that swings open by a quarter."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask

Directions = NDArray[np.int64]

# Circles are looked at in so many directions, and from the middle to so many radii.
DIRECTIONS, RINGS = 96, np.linspace(0.125, 1.375, 41)
NUMBERS = np.arange(DIRECTIONS)
# Directions of a quarter, and those that the arc of a door may have: walls lengthen it.
QUARTER, LEAST_ARC, MOST_ARC = DIRECTIONS // 4, DIRECTIONS * 17 // 96, DIRECTIONS * 32 // 96
# Where leaf, jamb, hinge and arc are drawn, and what is clear within the arc and around it, radii.
LEAF, JAMB, HINGE, ON, EXACTLY = (0.25, 0.94), (1.06, 1.3), (0.125, 0.3), (0.94, 1.06), (0.98, 1.02)
INSIDE, OUTSIDE = (0.35, 0.84), (1.16, 1.25)
# Of leaf, jamb and hinge so much is drawn at least, and between leaf and door so much at most.
LEAST_PART, MOST_CLUTTER = 0.6, 0.25


@dataclass(frozen=True)
class Quarter:
    """The directions of a leaf and of the door when closed, counted, and how much of it is drawn."""

    score: float
    leaf: int
    closed: int


def read_quarters(rays: Mask) -> list[Quarter | None]:
    """The swing about each circle, None where there is no leaf, no jamb or more than a quarter.

    rays: ink about the circles, shape (M, DIRECTIONS, len(RINGS)).
    """
    first, last = _extend(np.asarray(rays[:, :, _between(*ON)].any(axis=2)))
    fitting = np.flatnonzero((last - first >= LEAST_ARC) & (last - first <= MOST_ARC))
    shares, first, last = _Shares.measure(rays[fitting]), first[fitting], last[fitting]
    one, other = shares.read(first, last, way=1), shares.read(last, first, way=-1)
    best = np.where(other[:, :1] > one[:, :1], other, one)
    quarters: list[Quarter | None] = [None] * len(rays)
    for number, (score, leaf, closed) in zip(fitting.tolist(), best.tolist(), strict=True):
        if score > -inf:
            quarters[number] = Quarter(score, int(leaf), int(closed))
    return quarters


@dataclass(frozen=True, eq=False)
class _Shares:
    """How much is drawn in each direction about circles, each of shape (M, DIRECTIONS), 0 … 1.

    leaf, jamb: along a leaf, and beyond the arc. hinge: opposite to a door at its hinge. inside, outside: of the arc.
    arc: whether the arc is drawn.
    """

    leaf: Floats
    jamb: Floats
    hinge: Floats
    inside: Floats
    outside: Floats
    arc: Mask

    @staticmethod
    def measure(rays: Mask) -> _Shares:
        """rays: shape (M, DIRECTIONS, len(RINGS))."""
        spread = rays | np.roll(rays, 1, axis=1) | np.roll(rays, -1, axis=1)
        leaf, jamb, hinge = (spread[:, :, _between(*rings)].mean(axis=2) for rings in (LEAF, JAMB, HINGE))
        inside, outside = (rays[:, :, _between(*rings)].mean(axis=2) for rings in (INSIDE, OUTSIDE))
        arc = np.asarray(rays[:, :, _between(*EXACTLY)].any(axis=2))
        return _Shares(leaf, jamb, np.roll(hinge, -DIRECTIONS // 2, axis=1), inside, outside, arc)

    def read(self, end: Directions, other: Directions, *, way: int) -> Floats:
        """Score, leaf and closed door of each circle when the leaf is at an end of its arc, shape (M, 3).

        way: in which the door closes, 1 or -1. The score is -inf where there is no swing.
        """
        each = np.arange(len(end))[:, None]
        around = np.arange(-4, 5)
        along = self.leaf[each, end[:, None] + around]
        drawn = along >= along.max(axis=1, keepdims=True) - 0.05
        leaf = end + np.rint(drawn @ around / drawn.sum(axis=1)).astype(np.int64)
        closed = np.where(way * (other - leaf) >= QUARTER - 4, leaf + way * QUARTER, other)
        near = (closed[:, None] + np.arange(-3, 4)) % DIRECTIONS
        each, at_leaf = each[:, 0], self.leaf[each[:, 0], leaf]
        jamb, hinge = (part[each[:, None], near].max(axis=1) for part in (self.jamb, self.hinge))
        low, high = np.sort([leaf + 5 * way, closed - 5 * way], axis=0)
        swept = (low[:, None] <= NUMBERS) & (high[:, None] >= NUMBERS)
        inside, outside, arc = (
            (part * swept).sum(axis=1) / swept.sum(axis=1) for part in (self.inside, self.outside, self.arc)
        )
        clutter = np.maximum(inside, outside - 0.1)
        parts = np.stack([at_leaf, jamb, hinge])
        score = parts.mean(axis=0) * arc * (1 - 0.3 * self.leaf[each, closed % DIRECTIONS]) - clutter
        none = (parts.min(axis=0) < LEAST_PART) | (clutter > MOST_CLUTTER) | (self.jamb[each, leaf] > jamb)
        return np.column_stack([np.where(none, -inf, score), leaf, closed])


def _extend(rings: Mask) -> tuple[Directions, Directions]:
    """How far the ink of each ring, shape (M, DIRECTIONS), goes from its middle; first and last direction.

    Gaps of one direction are passed over.
    """
    each, ends = np.arange(len(rings)), []
    for way in (-1, 1):
        end = np.full(len(rings), DIRECTIONS // 2)
        goes_on = np.ones(len(rings), bool)
        while goes_on.any():
            goes_on &= (end > 6) & (end < DIRECTIONS - 7)
            goes_on &= rings[each, end + way] | rings[each, end + 2 * way]
            end = end + way * goes_on
        ends.append(end)
    return ends[0], ends[1]


def _between(low: float, high: float) -> slice:
    """The rings from a radius to another."""
    first, last = np.searchsorted(RINGS, (low - 1e-9, high + 1e-9))
    return slice(int(first), int(last))
