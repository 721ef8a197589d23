"""Leaves of doors: open, half open and shut ones, as a lidar detects them."""

from __future__ import annotations

import numpy as np
from shapely import LineString, Polygon

from pianta._types import Floats
from pianta.floor import Door, Floor

# The measures and shares were chosen by hand.
# Thickness of a leaf; metres.
LEAF = 0.045
# Wider doors have two leaves, or slide; metres.
WIDEST_LEAF = 1.15
# Wider doors have no leaf; metres.
WIDEST_DOOR = 2.6
# How often a door of middle width slides.
SLIDING_SHARE = 0.5
# How often a door is open without a leaf that a lidar detects: it stands at a wall, or the gap has no leaf.
NO_LEAF_SHARE = 0.2
# Angles of half open and of open leaves; degrees.
HALF_OPEN = (20.0, 60.0)
OPEN = (60.0, 110.0)


def draw_door_leaves(
    floor: Floor, *, rng: np.random.Generator, shut: float = 0.2, half_open: float = 0.15
) -> tuple[list[Polygon], list[int]]:
    """Leaves of the doors of a floor, metres, and the indices of the doors that are shut.

    shut, half_open: their shares; all others are open. Openings and very wide doors have no leaves.
    Shut doors may leave a room that no open door leads to.
    """
    leaves: list[Polygon] = []
    shut_doors: list[int] = []
    for index, door in enumerate(floor.doors):
        draw = float(rng.random())
        if door.kind == "opening" or door.line.length > WIDEST_DOOR or door.line.length < 0.3:
            continue
        if draw < shut:
            shut_doors.append(index)
            leaves.append(_shut_leaf(door))
        elif draw < shut + half_open:
            leaves += _swing_leaves(door, HALF_OPEN, rng)
        elif rng.random() >= NO_LEAF_SHARE:
            leaves += _swing_leaves(door, OPEN, rng)
    return leaves, shut_doors


def _shut_leaf(door: Door) -> Polygon:
    return door.line.buffer(LEAF / 2, cap_style="flat")


def _swing_leaves(door: Door, angles: tuple[float, float], rng: np.random.Generator) -> list[Polygon]:
    """One leaf, two, or a sliding one."""
    first, last = (np.array(point) for point in (door.line.coords[0], door.line.coords[-1]))
    if door.line.length <= WIDEST_LEAF:
        hinge, tip = (first, last) if rng.random() < 0.5 else (last, first)
        return [_swing_leaf(hinge, tip, angles, 1 if rng.random() < 0.5 else -1, rng)]
    if rng.random() < SLIDING_SHARE:
        # A sliding leaf covers part of the door.
        share = rng.uniform(0.1, 0.6)
        start, stop = (0.0, share) if rng.random() < 0.5 else (1 - share, 1.0)
        part = LineString([first + start * (last - first), first + stop * (last - first)])
        return [part.buffer(LEAF / 2, cap_style="flat")]
    middle, side = (first + last) / 2, 1 if rng.random() < 0.5 else -1
    return [_swing_leaf(first, middle, angles, side, rng), _swing_leaf(last, middle, angles, -side, rng)]


def _swing_leaf(
    hinge: Floats, tip: Floats, angles: tuple[float, float], side: int, rng: np.random.Generator
) -> Polygon:
    """A leaf on a hinge, turned from the wall to a side: 1 counter-clockwise, -1 clockwise."""
    turn = side * np.radians(rng.uniform(*angles))
    rotation = np.array([(np.cos(turn), np.sin(turn)), (-np.sin(turn), np.cos(turn))])
    return LineString([hinge, hinge + (tip - hinge) @ rotation]).buffer(LEAF / 2, cap_style="flat")
