"""Similarity of two floors, from 0 to 1: half by features of the whole floor, half by local patterns of its rooms."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Self, TypeAlias

import numpy as np

from pianta._types import Floats
from pianta.building_types.description import BuildingDescription
from pianta.graphs.feature_counts import FeatureCounts, compare_counts, gather_counts, merge_counts
from pianta.graphs.labelled_graphs import LabelledNodes, hash_labels
from pianta.graphs.nspdk_features import list_codes
from pianta.graphs.stable_hash import Codes

# Node labels of the rooms of a floor, and the pairs of rooms that a door joins.
RoomGraph: TypeAlias = tuple[tuple[str, ...], tuple[tuple[int, int], ...]]
# Patterns of a floor by block of NSPDK: their codes, and how often each occurs.
Patterns: TypeAlias = tuple[tuple[Codes, Floats], ...]

# NSPDK on the graph of rooms: a room with the rooms behind its doors (radius 1), and two of these up to 2 doors apart.
RADIUS = 1
DISTANCE = 2
# Small, medium and large rooms: terciles of the training rooms.
SIZE_CLASSES = 3
# Weight of the patterns beside the features; chosen by hand.
PATTERN_WEIGHT = 0.5
# A feature with a smaller standard deviation over the training floors is left out: its usual range is unknown.
MIN_DEVIATION = 1e-6
# Floors whose patterns are cached; cross-validation needs those of the training floors again and again.
CACHE_SIZE = 1024


class BuildingKernel:
    """A kernel on descriptions of floors: fit it to training floors, then compare others with them.

    The features are standardised on the training floors and compared by a Gaussian whose squared width is their number;
    the patterns by the normalised NSPDK. The kernel is the mean of both, and 1 for the same floor.
    """

    def fit(self, floors: Sequence[BuildingDescription]) -> Self:
        """Learn means, deviations and size classes from training floors, and store these floors."""
        features = np.array([description.features for description in floors])
        sizes = np.concatenate([description.sizes for description in floors])
        deviations = features.std(axis=0)
        self.means_ = features.mean(axis=0)
        self.deviations_ = np.where(deviations < MIN_DEVIATION, np.inf, deviations)
        self.bounds_ = np.quantile(sizes, np.arange(1, SIZE_CLASSES) / SIZE_CLASSES)
        self.floors_ = floors
        self.features_ = self._standardise(floors)
        self.patterns_ = self._count_patterns(floors)
        return self

    def compare(self, floors: Sequence[BuildingDescription] | None = None) -> Floats:
        """Similarity of floors to the training floors, shape (floors, training floors); None: these to each other."""
        counts = self.patterns_ if floors is None else self._count_patterns(floors)
        patterns = compare_counts(counts, self.patterns_)
        features = self.compare_features(self.floors_ if floors is None else floors)
        return np.asarray((1 - PATTERN_WEIGHT) * features + PATTERN_WEIGHT * patterns)

    def compare_features(self, floors: Sequence[BuildingDescription]) -> Floats:
        """Similarity of the features alone, from 0 to 1, shape (floors, training floors)."""
        squared_distances = np.zeros((len(floors), len(self.features_)))
        # One feature at a time, as all at once would need that many times the memory.
        for column, training_column in zip(self._standardise(floors).T, self.features_.T, strict=True):
            squared_distances += (column[:, None] - training_column) ** 2
        return np.asarray(np.exp(-squared_distances / self.features_.shape[1] / 2))

    def _standardise(self, floors: Sequence[BuildingDescription]) -> Floats:
        features = np.array([description.features for description in floors])
        return np.asarray((features - self.means_) / self.deviations_)

    def _count_patterns(self, floors: Sequence[BuildingDescription]) -> list[FeatureCounts]:
        """Patterns of floors, a row for each, by block of NSPDK."""
        patterns = cached_patterns([(floor.name_rooms(self.bounds_), floor.doors) for floor in floors])
        return [merge_counts(stack_patterns(blocks)) for blocks in zip(*patterns, strict=True)]


_CACHE: dict[RoomGraph, Patterns] = {}


def cached_patterns(floors: Sequence[RoomGraph]) -> list[Patterns]:
    """The patterns of each floor, from the cache if they are there."""
    patterns = {floor: _CACHE[floor] for floor in floors if floor in _CACHE}
    new = [floor for floor in dict.fromkeys(floors) if floor not in patterns]
    if new:
        patterns |= dict(zip(new, count_patterns(new), strict=True))
        if len(_CACHE) + len(new) > CACHE_SIZE:
            _CACHE.clear()
        _CACHE.update({floor: patterns[floor] for floor in new[:CACHE_SIZE]})
    return [patterns[floor] for floor in floors]


def count_patterns(floors: Sequence[RoomGraph]) -> list[Patterns]:
    """The patterns of each floor, counted on one graph of which the floors are parts."""
    rooms = [len(names) for names, _ in floors]
    floor_indices = np.repeat(np.arange(len(floors)), rooms)
    first_rooms = np.repeat(np.cumsum(rooms) - rooms, [len(pairs) for _, pairs in floors])
    doors = np.array([pair for _, pairs in floors for pair in pairs], np.intp).reshape(-1, 2) + first_rooms[:, None]
    starts, ends = np.concatenate([doors, doors[:, ::-1]]).T
    labels = hash_labels(name for names, _ in floors for name in names)
    graph = LabelledNodes(labels, starts, ends, np.zeros(len(starts), np.uint64))
    blocks = []
    for pairs in list_codes(graph, radius=RADIUS, distance=DISTANCE):
        counts = merge_counts(gather_counts(len(floors), [floor_indices[pairs.roots]], [pairs.codes]))
        by_floor = np.argsort(counts.rows, kind="stable")
        bounds = np.searchsorted(counts.rows[by_floor], np.arange(len(floors) + 1)).tolist()
        codes, numbers = counts.codes[by_floor], counts.counts[by_floor]
        blocks.append([(codes[start:end], numbers[start:end]) for start, end in pairwise(bounds)])
    return list(zip(*blocks, strict=True))


def stack_patterns(floors: Sequence[tuple[Codes, Floats]]) -> FeatureCounts:
    """The patterns of single floors as rows of one table."""
    rows = [np.full(len(codes), row) for row, (codes, _) in enumerate(floors)]
    return gather_counts(len(floors), rows, [codes for codes, _ in floors], [counts for _, counts in floors])
