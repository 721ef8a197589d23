"""Speed of people and flow through doors: the hydraulic model of the SFPE Handbook, with queues.

S. M. V. Gwynne and E. R. Rosenbaum, Employing the hydraulic model in assessing emergency movement, chapter 59 of the
SFPE Handbook of Fire Protection Engineering, 5th edition, 2016: speed S = k - a k D, specific flow F = S D.
"""

from __future__ import annotations

import numpy as np

from pianta._types import Floats

SPEED_FACTOR = 1.40  # k, m/s, of corridors and doorways
DENSITY_FACTOR = 0.266  # a, m² per person
FREE_DENSITY = 0.54  # people per m²; below it people walk freely
BEST_DENSITY = 1 / (2 * DENSITY_FACTOR)  # people per m²; the flow (1 - a D) k D is largest; crowds are not slower
MAX_FLOW = SPEED_FACTOR / (4 * DENSITY_FACTOR)  # people per second and metre of effective width, 1.32
BOUNDARY = 0.15  # metres beside each jamb that people keep away from
MIN_EFFECTIVE_WIDTH = 0.3  # metres: one person, sideways, passes any door; chosen by hand


def walking_speed(density: float) -> float:
    """Speed in m/s in a room with a density in people per m².

    >>> round(walking_speed(0.1), 2), round(walking_speed(1.0), 2)
    (1.2, 1.03)
    """
    crowded = min(max(density, FREE_DENSITY), BEST_DENSITY)
    return SPEED_FACTOR * (1 - DENSITY_FACTOR * crowded)


FREE_SPEED = walking_speed(0)


def door_capacity(width: float) -> float:
    """People per second through a door with a clear width in metres.

    >>> round(door_capacity(0.9), 2)
    0.79
    """
    return MAX_FLOW * max(width - 2 * BOUNDARY, MIN_EFFECTIVE_WIDTH)


def pass_queue(arrivals: Floats, capacity: float) -> Floats:
    """When each person passes a door, shape (N,), s: first come, first served, at most `capacity` people per second.

    arrivals: sorted, shape (N,), s.

    >>> pass_queue(np.array([0.0, 0.0, 9.0]), 0.5).tolist()
    [0.0, 2.0, 9.0]
    """
    turns = np.arange(len(arrivals)) / capacity
    return np.asarray(turns + np.maximum.accumulate(arrivals - turns))
