"""Merging regions into rooms: which separators divide two rooms, and which only look like it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import cv2
import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.layout._label_images import list_contacts
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.regions import Hull, Regions, Separators
from pianta.models import MODELS

# Lower bound of shares, so that their logarithms stay finite; part of the features that the model was fitted to.
MIN_SHARE = 0.02
# Lower bound of areas and of squared widths, for the same reason; m².
MIN_AREA = 0.01
# More neighbours than this count as this many; part of the features that the model was fitted to.
MAX_NEIGHBOURS = 5
# Two stretches of one corridor (docs/methods/structure.md, "Bends of corridors"; chosen on the maps of the benches):
# area over squared width of each, at least;
CORRIDOR_ASPECT = 2.0
# opening over the width of the narrower one, at least;
CORRIDOR_NARROWER_SHARE = 0.8
# opening over the width of the wider one, at least;
CORRIDOR_WIDER_SHARE = 0.45
# open share of the line between them, at least.
CORRIDOR_OPEN_SHARE = 0.8


@dataclass(frozen=True)
class MergeModel:
    """Logistic regression of whether the rooms on both sides of a separator are one room.

    weights: of the features of describe_separators, shape (11,). constant: log odds where all features are 0.
    """

    weights: tuple[float, ...]
    constant: float

    def log_odds(self, features: Floats) -> Floats:
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
    """The model in a file of training/fit_room_borders.py."""
    fitted = json.loads(path.read_text(encoding="utf-8"))
    return MergeModel(tuple(float(fitted["weights"][name]) for name in FEATURES), float(fitted["constant"]))


@cache
def read_default_merge_model() -> MergeModel:
    """The model that comes with pianta."""
    return read_merge_model()


@dataclass(frozen=True, eq=False)
class Rooms:
    """The rooms that regions have been merged into so far; a room has the number of one of its regions.

    owner: shape (1 + R,), the room of each region. width, area, hulls: as in Regions, of the rooms.
    """

    owner: Indices
    width: Floats
    area: Floats
    hulls: tuple[Hull, ...]


def initial_rooms(regions: Regions) -> Rooms:
    """Rooms of one region each."""
    return Rooms(np.arange(len(regions.area)), regions.width, regions.area, regions.hulls)


def merge_regions(regions: Regions, separators: Separators, model: MergeModel) -> tuple[Rooms, Indices, Floats]:
    """Rooms; the separators that still divide two rooms, shape (N,), and their log odds of one room.

    Two rooms are merged if their separator has positive log odds, and neither has another with higher ones. After every
    round the log odds are computed again, because the rooms have grown. When the model merges no more, stretches of one
    corridor are merged.
    """
    rooms = initial_rooms(regions)
    while True:
        active = find_active_separators(rooms, separators)
        pairs = rooms.owner[separators.sides[active]]
        features = describe_separators(rooms, separators, active, resolution=regions.resolution)
        log_odds = model.log_odds(features)
        chosen = select_likeliest(pairs, log_odds, log_odds > 0)
        if not len(chosen):
            chosen = select_likeliest(pairs, log_odds, find_corridor_bends(rooms, pairs, features))
        if not len(chosen):
            return rooms, active, log_odds
        rooms = join_rooms(rooms, pairs[chosen])


def select_likeliest(pairs: Indices, log_odds: Floats, eligible: Mask) -> Indices:
    """The eligible separators between pairs of rooms, shape (N, 2), with the highest log odds of both their rooms."""
    best = np.full(int(pairs.max(initial=0)) + 1, -np.inf)
    for side in pairs.T:
        np.maximum.at(best, side[eligible], log_odds[eligible])
    return np.flatnonzero(eligible & (log_odds == best[pairs].min(axis=1)) & (log_odds == best[pairs].max(axis=1)))


def find_corridor_bends(rooms: Rooms, pairs: Indices, features: Floats) -> Mask:
    """Whether each separator crosses a corridor that goes on behind it with the same width; shape (N,)."""
    aspect = rooms.area / np.maximum(rooms.width, MIN_AREA) ** 2
    same_width = (features[:, 0] >= np.log(CORRIDOR_NARROWER_SHARE)) & (features[:, 1] >= np.log(CORRIDOR_WIDER_SHARE))
    is_long = aspect[pairs].min(axis=1) >= CORRIDOR_ASPECT
    return np.asarray(same_width & (features[:, 2] >= CORRIDOR_OPEN_SHARE) & is_long)


def find_active_separators(rooms: Rooms, separators: Separators) -> Indices:
    """Separators with a different room on each side, shape (N,)."""
    one, other = rooms.owner[separators.sides].T
    return np.flatnonzero(one != other)


def describe_separators(rooms: Rooms, separators: Separators, active: Indices, *, resolution: float) -> Floats:
    """Features of the active separators, shape (N, 11), in the order of FEATURES.

    0, 1: log of the opening over the width of the narrower room, and over that of the wider (a neck is narrow).
    2, 3: open share of the line between the two rooms; metres of it that are wall (a room has walls).
    4, 5: log of the smaller area in m², and of the smaller over the larger.
    6: the opening in metres. 7: number of neighbours of the smaller room (a corridor has many).
    8, 9: metres of wall of one of the two rooms in line with the opening, at the end with less, and with more.
    10: convexity of both as one room, less their mean convexity.
    """
    one, other = rooms.owner[separators.sides].T
    by_one = rooms.owner[separators.left] == one[separators.separator]
    by_other = rooms.owner[separators.right] == other[separators.separator]
    between = _count_samples(separators, by_one & by_other)[active]
    opened = _count_samples(separators, by_one & by_other & separators.open)[active]
    in_line = [
        _count_samples(separators, (by_one | by_other) & ~separators.open & (separators.beyond == end))[active]
        for end in (1, 2)
    ]
    one, other = one[active], other[active]
    widths = np.sort(np.stack([rooms.width[one], rooms.width[other]]), axis=0)
    areas = np.sort(np.stack([rooms.area[one], rooms.area[other]]), axis=0) + MIN_AREA
    opening = separators.opening[active]
    smaller = np.where(rooms.area[one] < rooms.area[other], one, other)
    return np.column_stack(
        [
            *np.log((opening / np.maximum(widths, resolution)).clip(MIN_SHARE, 1)),
            opened / np.maximum(between, 1),
            (between - opened) * resolution,
            np.log(areas[0]),
            np.log(areas[0] / areas[1]),
            opening,
            np.minimum(_count_neighbours(one, other, len(rooms.owner))[smaller], MAX_NEIGHBOURS),
            *(np.sort(np.stack(in_line), axis=0) * resolution),
            _gain_convexity(rooms, one, other, resolution),
        ]
    )


def join_rooms(rooms: Rooms, pairs: Indices) -> Rooms:
    """Rooms where those of each pair, shape (N, 2), are one, with the smaller number.

    If several pairs share a room, which equal log odds can cause, only the first is joined.
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
    owner: Indices,
    regions: Regions,
    separators: Separators,
    active: Indices,
    log_odds: Floats,
    *,
    parameters: StructureParameters,
) -> Indices:
    """Room of each region, shape (1 + R,), where small rooms belong to a neighbour, or to no room (0).

    A small room joins the neighbour across the separator with the highest log odds. One without a separator, behind a
    passage that is too narrow, joins the room with the longest contact.
    """
    owner = owner.copy()
    area = np.bincount(owner, weights=regions.area, minlength=len(owner))
    separated = np.unique(owner[separators.sides[active]])
    pairs, lengths = list_contacts(regions.labels)
    contacts = pairs[np.argsort(-lengths, kind="stable")]
    closed = contacts[~np.isin(owner[contacts], separated).all(axis=1)]
    by_odds = separators.sides[active[np.argsort(-log_odds, kind="stable")]]
    for neighbours, min_area in ((by_odds, parameters.room_area), (closed, parameters.closed_room_area)):
        for pair in neighbours:
            one, other = sorted(owner[pair].tolist(), key=lambda room: (area[room], room))
            if one != other and area[one] < min_area:
                owner[owner == one] = other
                area[other] += area[one]
    return np.where(area[owner] < parameters.room_area, 0, owner)


def _count_samples(separators: Separators, chosen: Mask) -> Indices:
    return np.bincount(separators.separator[chosen], minlength=len(separators.sides))


def _count_neighbours(one: Indices, other: Indices, count: int) -> Indices:
    """Number of rooms that share a separator with each room, shape (count,)."""
    pairs = np.unique(np.sort(np.column_stack([one, other]), axis=1), axis=0)
    return np.bincount(pairs.ravel(), minlength=count)


def _gain_convexity(rooms: Rooms, one: Indices, other: Indices, resolution: float) -> Floats:
    """Area over hull area of each pair as one room, less the mean of the two, weighted by area; shape (N,)."""
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
