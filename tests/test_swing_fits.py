"""Leaf, arc, jamb and hinge about a circle make a swing; all of them are needed."""

import numpy as np
import pytest

from pianta._types import Mask
from pianta.plan.doors.swing_fits import SwingFit, fit_swings

# Rings about a circle lie 1/32 of its radius apart from 1/8 on: those of the leaf, from 0.25 to 0.94, of the arc, of
# the jamb, from 1.06 to 1.28, and of the hinge, up to 0.28.
LEAF, ARC, JAMB, HINGE = slice(4, 27), slice(28, 29), slice(30, 38), slice(0, 6)
# Within the arc, from 0.375 to 0.81, and around it, from 1.19 to 1.25.
INSIDE, AROUND = slice(8, 23), slice(34, 37)


def draw(*strokes: tuple[int, int, slice]) -> Mask:
    """Rays with ink from one direction of 96 to another, both included, on some rings."""
    rays = np.zeros((96, 41), bool)
    for first, last, rings in strokes:
        rays[first : last + 1, rings] = True
    return rays


def door(leaf: int, closed: int, *, without: slice | None = None, arc: tuple[int, int] | None = None) -> Mask:
    """A door that is open at one direction and closed at another; its hinge lies half a turn from where it closes."""
    opposite = (closed + 48) % 96
    first, last = arc or (min(leaf, closed), max(leaf, closed))
    strokes = (
        (leaf, leaf, LEAF),
        (first, last, ARC),
        (closed, closed, JAMB),
        (opposite, opposite, HINGE),
    )
    return draw(*(stroke for stroke in strokes if stroke[2] != without))


def read(*images: Mask) -> tuple[float, int, int] | None:
    """Score, leaf and closed door of the swing about a circle, with the ink of several images."""
    (fit,) = fit_swings(np.any(images, axis=0)[None])
    return None if fit is None else as_numbers(fit)


def as_numbers(fit: SwingFit) -> tuple[float, int, int]:
    return round(fit.score, 9), fit.leaf, fit.closed


@pytest.mark.parametrize(("leaf", "closed"), [(36, 60), (60, 36), (30, 54), (66, 42)])
def test_swings_are_fitted_in_both_directions(leaf, closed):
    assert read(door(leaf, closed)) == pytest.approx((1, leaf, closed))


@pytest.mark.parametrize("part", [LEAF, ARC, JAMB, HINGE], ids=["leaf", "arc", "jamb", "hinge"])
@pytest.mark.parametrize(("leaf", "closed"), [(36, 60), (60, 36)])
def test_a_swing_needs_each_of_its_parts(leaf, closed, part):
    assert read(door(leaf, closed, without=part)) is None


@pytest.mark.parametrize(("n_rings", "score"), [(4, None), (5, (1 + 1 + 5 / 8) / 3), (8, 1)])
def test_at_least_three_fifths_of_a_jamb_are_drawn(n_rings, score):
    """It has eight rings."""
    fit = read(door(36, 60, without=JAMB), draw((60, 60, slice(30, 30 + n_rings))))
    assert fit == (None if score is None else pytest.approx((score, 36, 60)))


@pytest.mark.parametrize(("n_rings", "score"), [(13, None), (14, (14 / 23 + 1 + 1) / 3)])
def test_at_least_three_fifths_of_a_leaf_are_drawn(n_rings, score):
    """It has 23 rings."""
    fit = read(door(60, 36, without=LEAF), draw((60, 60, slice(4, 4 + n_rings))))
    assert fit == (None if score is None else pytest.approx((score, 60, 36)))


def test_a_wall_behind_the_leaf_is_drawn_no_better_than_the_jamb():
    wall_at_leaf, most_of_jamb = draw((36, 36, JAMB)), draw((60, 60, slice(30, 36)))
    assert read(door(36, 60), wall_at_leaf) == pytest.approx((1, 36, 60))
    assert read(door(36, 60, without=JAMB), most_of_jamb) == pytest.approx(((1 + 1 + 6 / 8) / 3, 36, 60))
    assert read(door(36, 60, without=JAMB), most_of_jamb, wall_at_leaf) is None


@pytest.mark.parametrize(("leaf", "closed"), [(36, 60), (60, 36)])
def test_up_to_a_quarter_within_the_arc_may_be_drawn(leaf, closed):
    """Counted over the 15 directions from 41 to 55; a tenth more around the arc."""
    one_door = door(leaf, closed)
    assert read(one_door, draw((46, 48, INSIDE))) == pytest.approx((1 - 3 / 15, leaf, closed))
    assert read(one_door, draw((46, 49, INSIDE))) is None
    assert read(one_door, draw((46, 50, AROUND))) == pytest.approx((1 - (5 / 15 - 0.1), leaf, closed))
    assert read(one_door, draw((46, 51, AROUND))) is None


@pytest.mark.parametrize(
    ("leaf", "closed", "arc", "is_swing"),
    [
        (40, 56, (40, 56), False),
        (40, 57, (40, 57), True),
        (57, 40, (40, 57), True),
        (32, 56, (32, 64), True),
        (64, 40, (32, 64), True),
        (32, 56, (32, 65), False),
        (65, 41, (32, 65), False),
    ],
)
def test_arcs_span_17_to_32_directions(leaf, closed, arc, is_swing):
    """A short one ends at the closed door; a long one goes on in the wall, and the door closes after a quarter."""
    assert read(door(leaf, closed, arc=arc)) == (pytest.approx((1, leaf, closed)) if is_swing else None)


def test_arcs_have_gaps_of_one_direction():
    """One or two of the 15 directions are missing."""
    rest = door(36, 60, without=ARC)
    assert read(rest, draw((36, 44, ARC), (46, 60, ARC))) == pytest.approx((14 / 15, 36, 60))
    assert read(rest, draw((36, 44, ARC), (47, 60, ARC))) is None


@pytest.mark.parametrize(("leaf", "closed"), [(36, 60), (60, 36)])
def test_a_leaf_at_both_ends_scores_less(leaf, closed):
    """A leaf in the closed door costs up to 0.3; the better one of two swings counts."""
    assert read(door(leaf, closed), draw((closed, closed, LEAF))) == pytest.approx((0.7, leaf, closed))
    most_of_leaf = draw((closed, closed, slice(4, 20)))
    both = read(door(leaf, closed), door(closed, leaf, without=LEAF), most_of_leaf)
    assert both == pytest.approx((1 - 0.3 * 16 / 23, leaf, closed))


def test_each_circle_is_fitted_by_itself():
    nothing, everything = draw(), draw((0, 95, slice(0, 41)))
    fits = fit_swings(np.stack([nothing, door(60, 36), everything, door(36, 60)]))
    assert [fit and as_numbers(fit) for fit in fits] == [None, (1, 60, 36), None, (1, 36, 60)]


def test_no_circles_have_no_fits():
    assert fit_swings(np.zeros((0, 96, 41), bool)) == []
