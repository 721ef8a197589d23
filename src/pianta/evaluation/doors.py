"""Doors that were found, against the true ones, by where they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pianta._types import Floats
from pianta.floor import Door, Floor


@dataclass(frozen=True)
class DoorScores:
    """Numbers of doors: true ones, found ones, and found ones that are each where one true door is."""

    true: int
    found: int
    right: int

    @property
    def recall(self) -> float:
        """Share of the true doors that were found; where one side has no doors 0, where neither has 1."""
        return self.right / self.true if self.true else float(not self.found)

    @property
    def precision(self) -> float:
        """Share of the found doors that are true; where one side has no doors 0, where neither has 1."""
        return self.right / self.found if self.found else float(not self.true)

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        both = self.true + self.found
        return 2 * self.right / both if both else 1.0


def score_doors(found: Floor, truth: Floor, *, reach: float | None = None) -> DoorScores:
    """Doors and openings of a floor against those of the true floor, both in one frame.

    As many as possible are matched one to one; a found door can be a true one when their middles are at most the reach
    apart. The rooms that they join do not count.

    reach: metres; None for half the width of each true door.
    The thesis' truth lists doors between rooms only. Where the truth has no entrances, those that are found are
    neither right nor wrong and are left out.
    """
    entrances = any(door.is_entrance for door in truth.doors)
    judged = [door for door in found.doors if entrances or not door.is_entrance]
    reaches = np.array([door.width / 2 if reach is None else reach for door in truth.doors])
    apart = np.linalg.norm(_find_middles(judged)[:, None] - _find_middles(truth.doors)[None], axis=2)
    return DoorScores(len(truth.doors), len(judged), _count_matches(apart, reaches))


def _find_middles(doors: tuple[Door, ...] | list[Door]) -> Floats:
    """Middles of doors, shape (N, 2)."""
    middles = [door.line.interpolate(0.5, normalized=True) for door in doors]
    return np.array([(middle.x, middle.y) for middle in middles]).reshape(-1, 2)


def _count_matches(apart: Floats, reaches: Floats) -> int:
    """Most pairs that lie within reach; apart: shape (N, M), reaches: shape (M,)."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import maximum_bipartite_matching

    near = apart <= reaches + 1e-9
    return int((maximum_bipartite_matching(csr_array(near)) >= 0).sum()) if near.any() else 0
