"""Typicality: whether a floor is like the known ones, calibrated by how much these are like each other.

A one-class answer: no example of anything else is needed (thesis, section 8.1, has both classes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pianta._types import Floats
from pianta.building_types.description import BuildingDescription
from pianta.building_types.kernel import BuildingKernel
from pianta.evaluation.folds import leave_buildings_out

# A floor is compared with so many known floors: those that it is most like.
NEAREST = 3
# Buildings are left out in so many parts: each costs a fit of the kernel.
PARTS = 16


@dataclass(frozen=True, eq=False)
class Typicality:
    """How much known floors are like each other.

    likenesses: of each known floor, the mean likeness to the NEAREST floors of other buildings, ascending.
    """

    likenesses: Floats

    def rank(self, likenesses: Floats) -> Floats:
        """The share of known floors that are less typical, from 0 to 1; 0.5 is as typical as the median.

        likenesses: means as `measure_likeness` gives them, any shape.
        """
        ranks = np.searchsorted(self.likenesses, likenesses, side="left") + np.searchsorted(
            self.likenesses, likenesses, side="right"
        )
        return np.asarray(ranks / (2 * len(self.likenesses)))


def measure_likeness(gram: Floats) -> Floats:
    """Mean likeness of floors to the NEAREST known ones, shape (floors,); gram: shape (floors, known)."""
    nearest = np.sort(gram, axis=1)[:, -NEAREST:]
    return np.asarray(nearest.mean(axis=1))


def find_most_alike(gram: Floats, known: Sequence[BuildingDescription]) -> tuple[str, ...]:
    """Sources of the NEAREST known floors of one floor, the most alike first; gram: shape (1, known)."""
    return tuple(known[place].source for place in np.argsort(-gram[0], kind="stable")[:NEAREST])


def learn_typicality(known: Sequence[BuildingDescription], buildings: Sequence[str]) -> Typicality:
    """From known floors; buildings: of each. What is usual is learnt without the floor that is compared, as of others.

    Of more than PARTS buildings some are left out together.
    """
    likenesses = np.zeros(len(known))
    for seen, held_out in leave_buildings_out(buildings, parts=PARTS):
        kernel = BuildingKernel().fit([known[place] for place in seen])
        likenesses[held_out] = measure_likeness(kernel.compare([known[place] for place in held_out]))
    return Typicality(np.sort(likenesses))
