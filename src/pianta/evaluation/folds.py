"""Cross-validation by buildings: floors of one building are similar, so they are left out together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pianta._types import Indices


def leave_buildings_out(buildings: Sequence[str], *, parts: int | None = None) -> Iterator[tuple[Indices, Indices]]:
    """For each building, in order, the indices of the floors of all others, and of its own.

    parts: number of folds; of more buildings than this, several are left out together.
    """
    numbers = {name: number for number, name in enumerate(dict.fromkeys(buildings))}
    count = min(parts or len(numbers), len(numbers))
    part = np.array([numbers[name] % count for name in buildings])
    for number in range(count):
        yield np.flatnonzero(part != number), np.flatnonzero(part == number)
