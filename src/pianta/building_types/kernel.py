"""How alike two floors are, from 0 to 1: half by how they are made up, half by the local patterns of their rooms."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Self, TypeAlias

import numpy as np

from pianta._types import Floats
from pianta.building_types.description import BuildingDescription
from pianta.graphs.feature_counts import FeatureCounts, compare_counts, gather_counts, merge_counts
from pianta.graphs.labelled_graphs import LabelledNodes, hash_labels
from pianta.graphs.neighborhood_features import list_codes
from pianta.graphs.stable_hash import Codes

# A floor as patterns see it: the names of its rooms, and its doors.
NamedFloor: TypeAlias = tuple[tuple[str, ...], tuple[tuple[int, int], ...]]
# Patterns of a floor by block of NSPDK: their codes, and how often each occurs.
Patterns: TypeAlias = tuple[tuple[Codes, Floats], ...]

# NSPDK on the graph of rooms: a room with those behind its doors, and two of these with a room between.
RADIUS, DISTANCE = 1, 2
# Rooms are small, medium or large, a third of the known rooms each.
SIZE_CLASSES = 3
# What patterns count beside features.
PATTERN_SHARE = 0.5
# Of a feature that varies less among known floors nobody knows how much it may vary, and it does not count.
LEAST_SPREAD = 1e-6
# Patterns of this many floors are kept: those of known floors are asked for again whenever others are left out.
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
        self.patterns_ = self._count_patterns(known)
        return self

    def compare(self, floors: Sequence[BuildingDescription] | None = None) -> Floats:
        """How alike floors are to the known ones, shape (floors, known); these to each other where none are given."""
        counts = self.patterns_ if floors is None else self._count_patterns(floors)
        patterns = compare_counts(counts, self.patterns_)
        features = self.compare_features(self.floors_ if floors is None else floors)
        return np.asarray((1 - PATTERN_SHARE) * features + PATTERN_SHARE * patterns)

    def compare_features(self, floors: Sequence[BuildingDescription]) -> Floats:
        """The share of the features in `compare`, from 0 to 1, shape (floors, known)."""
        apart = np.zeros((len(floors), len(self.known_)))
        # One feature after the other, for all at once would take their number of times the memory.
        for own, known in zip(self._standardise(floors).T, self.known_.T, strict=True):
            apart += (own[:, None] - known) ** 2
        return np.asarray(np.exp(-apart / self.known_.shape[1] / 2))

    def _standardise(self, floors: Sequence[BuildingDescription]) -> Floats:
        features = np.array([description.features for description in floors])
        return np.asarray((features - self.means_) / self.spreads_)

    def _count_patterns(self, floors: Sequence[BuildingDescription]) -> list[FeatureCounts]:
        """Patterns of floors, a row for each, by block of NSPDK."""
        counted = recall_patterns([(floor.name_rooms(self.bounds_), floor.doors) for floor in floors])
        return [merge_counts(stack_patterns(blocks)) for blocks in zip(*counted, strict=True)]


_REMEMBERED: dict[NamedFloor, Patterns] = {}


def recall_patterns(floors: Sequence[NamedFloor]) -> list[Patterns]:
    """The patterns of each floor; those that were counted before are remembered."""
    found = {floor: _REMEMBERED[floor] for floor in floors if floor in _REMEMBERED}
    new = [floor for floor in dict.fromkeys(floors) if floor not in found]
    if new:
        found |= dict(zip(new, count_patterns(new), strict=True))
        if len(_REMEMBERED) + len(new) > MAX_REMEMBERED:
            _REMEMBERED.clear()
        _REMEMBERED.update({floor: found[floor] for floor in new[:MAX_REMEMBERED]})
    return [found[floor] for floor in floors]


def count_patterns(floors: Sequence[NamedFloor]) -> list[Patterns]:
    """The patterns of each floor, all counted together: floors are parts of one graph."""
    rooms = [len(names) for names, _ in floors]
    floor_of = np.repeat(np.arange(len(floors)), rooms)
    first_rooms = np.repeat(np.cumsum(rooms) - rooms, [len(pairs) for _, pairs in floors])
    doors = np.array([pair for _, pairs in floors for pair in pairs], np.intp).reshape(-1, 2) + first_rooms[:, None]
    starts, ends = np.concatenate([doors, doors[:, ::-1]]).T
    labels = hash_labels(name for names, _ in floors for name in names)
    graph = LabelledNodes(labels, starts, ends, np.zeros(len(starts), np.uint64))
    blocks = []
    for pairs in list_codes(graph, radius=RADIUS, distance=DISTANCE):
        counts = merge_counts(gather_counts(len(floors), [floor_of[pairs.roots]], [pairs.codes]))
        by_floor = np.argsort(counts.rows, kind="stable")
        bounds = np.searchsorted(counts.rows[by_floor], np.arange(len(floors) + 1)).tolist()
        codes, numbers = counts.codes[by_floor], counts.counts[by_floor]
        blocks.append([(codes[start:end], numbers[start:end]) for start, end in pairwise(bounds)])
    return list(zip(*blocks, strict=True))


def stack_patterns(floors: Sequence[tuple[Codes, Floats]]) -> FeatureCounts:
    """The counts of single floors as rows of one."""
    rows = [np.full(len(codes), row) for row, (codes, _) in enumerate(floors)]
    return gather_counts(len(floors), rows, [codes for codes, _ in floors], [counts for _, counts in floors])
