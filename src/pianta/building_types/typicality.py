"""Typicality: whether a floor is like the training floors, compared with how similar these are to each other.

A one-class answer: it needs no example of anything else (section 8.1 of the thesis has both classes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pianta._types import Floats
from pianta.building_types.description import BuildingDescription
from pianta.building_types.kernel import BuildingKernel
from pianta.evaluation.folds import leave_buildings_out

# A floor is compared with this many training floors, the most similar ones; chosen by hand.
NEAREST_FLOORS = 3
# Folds of the cross-validation by buildings; each costs a fit of the kernel.
FOLDS = 16


@dataclass(frozen=True, eq=False)
class Typicality:
    """How similar training floors are to each other.

    likenesses: of each, the mean similarity to the NEAREST_FLOORS floors of other buildings; ascending.
    """

    likenesses: Floats

    def rank(self, likenesses: Floats) -> Floats:
        """The share of training floors that are less typical, from 0 to 1 (0.5: as typical as the median).

        likenesses: those of `measure_likeness`, any shape.
        """
        below, not_above = (np.searchsorted(self.likenesses, likenesses, side) for side in ("left", "right"))
        return np.asarray((below + not_above) / (2 * len(self.likenesses)))


def measure_likeness(gram: Floats) -> Floats:
    """Mean similarity to the NEAREST_FLOORS training floors, shape (floors,); gram: shape (floors, training floors)."""
    return np.asarray(np.sort(gram, axis=1)[:, -NEAREST_FLOORS:].mean(axis=1))


def find_most_similar(gram: Floats, floors: Sequence[BuildingDescription]) -> tuple[str, ...]:
    """Sources of the NEAREST_FLOORS training floors of one floor, the most similar first; gram: shape (1, floors)."""
    return tuple(floors[index].source for index in np.argsort(-gram[0], kind="stable")[:NEAREST_FLOORS])


def fit_typicality(floors: Sequence[BuildingDescription], buildings: Sequence[str]) -> Typicality:
    """Compare each training floor with those of other buildings, by a kernel that was not fitted to its own.

    Of more than FOLDS buildings, several are left out together.
    """
    likenesses = np.zeros(len(floors))
    for training, held_out in leave_buildings_out(buildings, parts=FOLDS):
        kernel = BuildingKernel().fit([floors[index] for index in training])
        likenesses[held_out] = measure_likeness(kernel.compare([floors[index] for index in held_out]))
    return Typicality(np.sort(likenesses))
