"""Folds by building, of a limited number, so that the cost of a bench grows with the number of its floors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pianta._types import Indices

# The 35 buildings of the data are left out one by one. Of more buildings, neighbours in the order of names are left out
# together: models are trained for each fold, so one fold per building would cost the square of their number.
MAX_FOLDS = 36


def list_folds(buildings: Sequence[str], *, most: int = MAX_FOLDS) -> list[tuple[Indices, Indices]]:
    """For each fold the indices of the items of other buildings, and of its own; in the order of the names.

    buildings: the building of each item.
    """
    names = sorted(set(buildings))
    count = min(most, len(names))
    fold_of = {name: number * count // len(names) for number, name in enumerate(names)}
    folds = np.array([fold_of[name] for name in buildings])
    return [(np.flatnonzero(folds != fold), np.flatnonzero(folds == fold)) for fold in range(count)]
