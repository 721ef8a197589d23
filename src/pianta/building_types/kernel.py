"""How alike two floors are, from 0 to 1: half by how they are made up, half by the local patterns of their rooms."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from pianta.building_types.description import BuildingDescription, draw_rooms
from pianta.graphs.explicit_kernel import FeatureCounts, gather_counts
from pianta.graphs.neighborhood_pairs import NeighborhoodPairs

Floats = NDArray[np.float64]

# NSPDK on the graph of rooms: a room with those behind its doors, and two of these with a room between.
RADIUS, DISTANCE = 1, 2
# Rooms are small, medium or large, a third of the known rooms each.
SIZE_CLASSES = 3
# What patterns count beside features.
PATTERN_SHARE = 0.5
# Of a feature that varies less among known floors nobody knows how much it may vary, and it does not count.
LEAST_SPREAD = 1e-6
# Patterns of so many floors are kept: those of known floors are asked for again whenever others are left out.
MAX_REMEMBERED = 1024


class BuildingKernel:
    """A kernel on descriptions of floors: fit to known floors, compare others with them.

    The features are standardised on the known floors and compared by a Gaussian whose width is their number; the
    patterns by the normalised NSPDK. The kernel is their mean, and 1 for the same floor.
    """

    def fit(self, known: Sequence[BuildingDescription]) -> Self:
        """Learn what is usual, and keep the known floors."""
        features = np.array([description.features for description in known])
        sizes = np.concatenate([description.sizes for description in known])
        spreads = features.std(axis=0)
        self.means_, self.spreads_ = features.mean(axis=0), np.where(spreads < LEAST_SPREAD, np.inf, spreads)
        self.bounds_ = np.quantile(sizes, np.arange(1, SIZE_CLASSES) / SIZE_CLASSES)
        self.floors_, self.known_ = known, self._standardise(known)
        self.patterns_ = NeighborhoodPairs(radius=RADIUS, distance=DISTANCE).fit_counts(self._count_patterns(known))
        return self

    def compare(self, floors: Sequence[BuildingDescription] | None = None) -> Floats:
        """How alike floors are to the known ones, shape (floors, known); these to each other where none are given."""
        patterns = self.patterns_.compare_counts(None if floors is None else self._count_patterns(floors))
        features = self.compare_features(self.floors_ if floors is None else floors)
        return np.asarray((1 - PATTERN_SHARE) * features + PATTERN_SHARE * patterns)

    def compare_features(self, floors: Sequence[BuildingDescription]) -> Floats:
        """The share of the features in `compare`, from 0 to 1, shape (floors, known)."""
        apart = cdist(self._standardise(floors), self.known_, "sqeuclidean") / self.known_.shape[1]
        return np.asarray(np.exp(-apart / 2))

    def _standardise(self, floors: Sequence[BuildingDescription]) -> Floats:
        features = np.array([description.features for description in floors])
        return np.asarray((features - self.means_) / self.spreads_)

    def _count_patterns(self, floors: Sequence[BuildingDescription]) -> list[FeatureCounts]:
        """Patterns of floors, a row for each, by block of NSPDK."""
        counted = [_count_patterns(floor.name_rooms(self.bounds_), floor.doors) for floor in floors]
        return [_stack(blocks) for blocks in zip(*counted, strict=True)]


@lru_cache(maxsize=MAX_REMEMBERED)
def _count_patterns(names: tuple[str, ...], doors: tuple[tuple[int, int], ...]) -> tuple[FeatureCounts, ...]:
    """Patterns of one floor by block of NSPDK, each once with its count."""
    blocks = NeighborhoodPairs(radius=RADIUS, distance=DISTANCE).count_features([draw_rooms(names, doors)])
    found = (np.unique(block.codes, return_counts=True) for block in blocks)
    return tuple(
        FeatureCounts(1, np.zeros(len(codes), np.intp), codes, counts.astype(np.float64)) for codes, counts in found
    )


def _stack(floors: Sequence[FeatureCounts]) -> FeatureCounts:
    """The counts of single floors as rows of one."""
    rows = [floor.rows + row for row, floor in enumerate(floors)]
    return gather_counts(len(floors), rows, [floor.codes for floor in floors], [floor.counts for floor in floors])
