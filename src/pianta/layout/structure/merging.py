"""Which borders part two rooms, and which only look like it: pieces are merged into rooms."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices, Mask
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.pieces import Borders, Hull, Labels, Pieces
from pianta.models import MODELS

# Shares and areas (m²) below these tell no more, and their logarithms stay finite.
LEAST_SHARE, LEAST_AREA = 0.02, 0.01
# More neighbours than this are as good as many.
MANY = 5
# Two stretches of one corridor are at least this many times as long as wide, and meet over at least these shares of
# their widths and of the line between them.
STRETCHED, AS_WIDE, NEARLY_AS_WIDE, AS_OPEN = 2.0, 0.8, 0.45, 0.8


@dataclass(frozen=True)
class MergeModel:
    """Logistic regression for "the rooms on both sides of this border are one room".

    weights: of the features of describe_borders, shape (11,). constant: log odds where all features are 0.
    """

    weights: tuple[float, ...]
    constant: float

    def weigh_borders(self, features: Floats) -> Floats:
        """Log odds of one room for features of shape (N, 11), shape (N,)."""
        return np.asarray(features @ np.array(self.weights) + self.constant)


FEATURES = (
    "log opening over narrower width",
    "log opening over wider width",
    "open share",
    "wall between",
    "log smaller area",
    "log smaller over larger area",
    "opening",
    "neighbours of the smaller",
    "wall in line, less",
    "wall in line, more",
    "gain of convexity",
)
MODEL_FILE = MODELS / "room_borders.json"


def read_merge_model(path: Path = MODEL_FILE) -> MergeModel:
    """The model that training/fit_room_borders.py has written."""
    fitted = json.loads(path.read_text(encoding="utf-8"))
    return MergeModel(tuple(float(fitted["weights"][name]) for name in FEATURES), float(fitted["constant"]))


@cache
def read_default_merge_model() -> MergeModel:
    """The model that comes with pianta."""
    return read_merge_model()


@dataclass(frozen=True, eq=False)
class Rooms:
    """The rooms that the pieces make up so far; a room has the number of one of its pieces.

    owner: shape (1 + P,), the room of each piece. width, area, hulls: as in Pieces, of the rooms.
    """

    owner: Indices
    width: Floats
    area: Floats
    hulls: tuple[Hull, ...]


def start_rooms(pieces: Pieces) -> Rooms:
    """Every piece as a room of its own."""
    return Rooms(np.arange(len(pieces.area)), pieces.width, pieces.area, pieces.hulls)


def merge_pieces(pieces: Pieces, borders: Borders, model: MergeModel) -> tuple[Rooms, NDArray[np.intp], Floats]:
    """Rooms of pieces; the borders that still part two rooms, shape (N,), and their log odds of one room, below 0.

    Two rooms become one across the border that is the likeliest of both to be none. After every round the borders are
    judged anew, because the rooms beside them have grown. When the model joins no more, stretches of one corridor are.
    """
    rooms = start_rooms(pieces)
    while True:
        parting = find_parting_borders(rooms, borders)
        pairs = rooms.owner[borders.sides[parting]]
        features = describe_borders(rooms, borders, parting, resolution=pieces.resolution)
        odds = model.weigh_borders(features)
        chosen = select_likeliest(pairs, odds, odds > 0)
        if not len(chosen):
            chosen = select_likeliest(pairs, odds, find_bends(rooms, pairs, features))
        if not len(chosen):
            return rooms, parting, odds
        rooms = join_rooms(rooms, pairs[chosen])


def select_likeliest(pairs: Indices, odds: Floats, eligible: Mask) -> Indices:
    """Of the eligible borders between pairs of rooms, shape (N, 2), those with the best odds of both their rooms."""
    best = np.full(int(pairs.max(initial=0)) + 1, -np.inf)
    for side in pairs.T:
        np.maximum.at(best, side[eligible], odds[eligible])
    return np.flatnonzero(eligible & (odds == best[pairs].min(axis=1)) & (odds == best[pairs].max(axis=1)))


def find_bends(rooms: Rooms, pairs: Indices, features: Floats) -> Mask:
    """Whether each border only crosses a corridor, which goes on behind it as wide as before; shape (N,)."""
    length = rooms.area / np.maximum(rooms.width, LEAST_AREA) ** 2
    as_wide = (features[:, 0] >= np.log(AS_WIDE)) & (features[:, 1] >= np.log(NEARLY_AS_WIDE))
    return np.asarray(as_wide & (features[:, 2] >= AS_OPEN) & (length[pairs].min(axis=1) >= STRETCHED))


def find_parting_borders(rooms: Rooms, borders: Borders) -> Indices:
    """Borders that have two different rooms beside them, shape (N,)."""
    one, other = rooms.owner[borders.sides].T
    return np.flatnonzero(one != other)


def describe_borders(rooms: Rooms, borders: Borders, parting: Indices, *, resolution: float) -> Floats:
    """What speaks for and against one room across each of the given borders, shape (N, 11).

    0, 1: log of the opening over the width of the narrower room, and over that of the wider (a neck is narrow).
    2, 3: share of the line between the two rooms that is open; metres of it that are wall (a room has walls).
    4, 5: log of the smaller area in m², and of it over the larger.
    6: the opening in metres. 7: neighbours of the smaller room (a corridor has many).
    8, 9: metres of wall of one of the two rooms that are in line with the opening, at the end with less, and with more.
    10: how much more convex the two are as one room than as two.
    """
    one, other = rooms.owner[borders.sides].T
    by_one = rooms.owner[borders.left] == one[borders.border]
    by_other = rooms.owner[borders.right] == other[borders.border]
    between = _count_samples(borders, by_one & by_other)[parting]
    opened = _count_samples(borders, by_one & by_other & borders.open)[parting]
    in_line = [
        _count_samples(borders, (by_one | by_other) & ~borders.open & (borders.beyond == end))[parting]
        for end in (1, 2)
    ]
    one, other = one[parting], other[parting]
    widths = np.sort(np.stack([rooms.width[one], rooms.width[other]]), axis=0)
    areas = np.sort(np.stack([rooms.area[one], rooms.area[other]]), axis=0) + LEAST_AREA
    opening = borders.opening[parting]
    smaller = np.where(rooms.area[one] < rooms.area[other], one, other)
    return np.column_stack(
        [
            *np.log((opening / np.maximum(widths, resolution)).clip(LEAST_SHARE, 1)),
            opened / np.maximum(between, 1),
            (between - opened) * resolution,
            np.log(areas[0]),
            np.log(areas[0] / areas[1]),
            opening,
            np.minimum(_count_neighbours(one, other, len(rooms.owner))[smaller], MANY),
            *(np.sort(np.stack(in_line), axis=0) * resolution),
            _gain_convexity(rooms, one, other, resolution),
        ]
    )


def join_rooms(rooms: Rooms, pairs: Indices) -> Rooms:
    """Rooms where those of each pair, shape (N, 2), are one, with the smaller number.

    Of pairs that share a room, as equal odds may give, the first counts.
    """
    owner, width, area, hulls = np.arange(len(rooms.owner)), rooms.width.copy(), rooms.area.copy(), list(rooms.hulls)
    joined: set[int] = set()
    for one, other in np.sort(pairs, axis=1).tolist():
        if one in joined or other in joined:
            continue
        joined |= {one, other}
        owner[other] = one
        width[one] = max(width[one], width[other])
        area[one] += area[other]
        hulls[one] = _join_hulls(hulls[one], hulls[other])
    return Rooms(owner[rooms.owner], width, area, tuple(hulls))


def absorb_small_rooms(
    owner: Indices, pieces: Pieces, borders: Borders, parting: Indices, odds: Floats, *, parameters: StructureParameters
) -> Indices:
    """Room of each piece, shape (1 + P,), where what is too small for a room belongs to a neighbour, or else to none.

    A small room goes over the border with the best odds of one room. One without any border, behind a passage that is
    too narrow, goes to the room that it touches most.
    """
    owner = owner.copy()
    area = np.bincount(owner, weights=pieces.area, minlength=len(owner))
    bordered = np.unique(owner[borders.sides[parting]])
    contacts = _list_contacts(pieces.labels)
    closed = contacts[~np.isin(owner[contacts], bordered).all(axis=1)]
    by_odds = borders.sides[parting[np.argsort(-odds, kind="stable")]]
    for pairs, least in ((by_odds, parameters.room_area), (closed, parameters.closed_room_area)):
        for pair in pairs:
            one, other = sorted(owner[pair].tolist(), key=lambda room: (area[room], room))
            if one != other and area[one] < least:
                owner[owner == one] = other
                area[other] += area[one]
    return np.where(area[owner] < parameters.room_area, 0, owner)


def _list_contacts(labels: Labels) -> Indices:
    """Pairs of labels above 0 that touch by an edge, the longest contact first; shape (N, 2)."""
    touching = []
    for one, other in ((labels[:-1], labels[1:]), (labels[:, :-1], labels[:, 1:])):
        meet = (one != other) & (one > 0) & (other > 0)
        touching.append(np.column_stack([one[meet], other[meet]]))
    pairs, lengths = np.unique(np.sort(np.concatenate(touching), axis=1), axis=0, return_counts=True)
    return pairs[np.argsort(-lengths, kind="stable")].astype(np.intp)


def _count_samples(borders: Borders, chosen: Mask) -> NDArray[np.intp]:
    return np.bincount(borders.border[chosen], minlength=len(borders.sides))


def _count_neighbours(one: Indices, other: Indices, count: int) -> Indices:
    """Rooms that share a border with each room, shape (count,)."""
    pairs = np.unique(np.sort(np.column_stack([one, other]), axis=1), axis=0)
    return np.bincount(pairs.ravel(), minlength=count)


def _gain_convexity(rooms: Rooms, one: Indices, other: Indices, resolution: float) -> Floats:
    """Area over hull area of each two rooms as one, less the mean of theirs by area; shape (N,)."""
    cell = resolution**2
    apart = np.array([cv2.contourArea(hull) for hull in rooms.hulls]) * cell
    pairs = zip(one.tolist(), other.tolist(), strict=True)
    both = np.array([cv2.contourArea(_join_hulls(rooms.hulls[i], rooms.hulls[j])) for i, j in pairs]) * cell
    convexity = rooms.area / np.maximum(apart, cell)
    area = rooms.area[one] + rooms.area[other]
    mean = (convexity[one] * rooms.area[one] + convexity[other] * rooms.area[other]) / np.maximum(area, cell)
    return np.asarray(area / np.maximum(both, cell) - mean)


def _join_hulls(one: Hull, other: Hull) -> Hull:
    return np.asarray(cv2.convexHull(np.concatenate([one, other])), np.int32)
