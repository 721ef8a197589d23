"""What is thought of the rooms around a room: the input of the second pass, and the pairs of the random field.

Tu and Bai (Auto-context and its application to high-level vision tasks, 2010) call it auto-context.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pianta.rooms.features import RoomContext
from pianta.rooms.random_field import Neighbourhood

Floats = NDArray[np.float64]

# Columns for each label that describe_neighbours adds to the context of a room.
AROUND = 9


def describe_neighbours(context: RoomContext, probabilities: Floats) -> Floats:
    """Features of rooms, what is thought of each, and of the rooms around it: shape (n, k + AROUND L).

    probabilities: of L labels, shape (n, L).
    """
    at_two_doors = (context.hops == 2).astype(float)
    surroundings = [
        probabilities,
        context.doors @ probabilities,
        _average(context.doors, probabilities),
        _highest(context.doors, probabilities),
        _average(at_two_doors, probabilities),
        _average(context.walls, probabilities),
        _average(context.alike, probabilities),
        np.broadcast_to(probabilities.mean(axis=0), probabilities.shape),
        np.broadcast_to(np.average(probabilities, axis=0, weights=context.area), probabilities.shape),
    ]
    return np.hstack([context.features, *surroundings])


def find_neighbourhood(context: RoomContext) -> Neighbourhood:
    """The pairs of rooms with a door between them, and those that are alike."""
    doors = np.argwhere(np.triu(context.doors, 1) > 0)
    alike = np.argwhere(np.triu(context.alike, 1))
    count = context.alike.sum(axis=1)
    return Neighbourhood(doors, alike, 2 / np.maximum(count[alike].sum(axis=1), 1))


def join_neighbourhoods(contexts: Sequence[RoomContext]) -> Neighbourhood:
    """The pairs of several floors, their rooms numbered through."""
    near = [find_neighbourhood(context) for context in contexts]
    starts = np.cumsum([0, *(len(context.features) for context in contexts[:-1])])
    doors = [each.doors + start for each, start in zip(near, starts, strict=True)]
    alike = [each.alike + start for each, start in zip(near, starts, strict=True)]
    return Neighbourhood(np.concatenate(doors), np.concatenate(alike), np.concatenate([each.share for each in near]))


def _average(weights: NDArray[np.generic], probabilities: Floats) -> Floats:
    """Weighted means of the rows of probabilities, 0 where all weights are, shape (n, L)."""
    totals = np.asarray(weights, float).sum(axis=1, keepdims=True)
    return np.asarray(np.asarray(weights, float) @ probabilities / np.maximum(totals, 1e-9))


def _highest(doors: NDArray[np.generic], probabilities: Floats) -> Floats:
    """Highest probability of each label behind any door, 0 where there is none, shape (n, L)."""
    behind = np.where(np.asarray(doors)[:, :, None] > 0, probabilities[None], 0.0)
    return np.asarray(behind.max(axis=1, initial=0))
