"""The choice of patterns among correspondences: those that save most rooms, and smaller ones within them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely

from pianta._types import Floats, Indices, Mask
from pianta.patterns._correspondences import Correspondences
from pianta.patterns._room_table import RoomTable

# Distances and areas that differ by less are equal, in units and squares of it, so that rounding decides nothing.
ROUNDING = 1e-3


@dataclass(frozen=True, eq=False)
class Repeated:
    """A pattern by indices in a RoomTable.

    copies: the rooms of each occurrence, shape (occurrences, rooms); rooms of one column correspond, the first row is
    the model. inner: patterns within the model.
    """

    copies: Indices
    inner: tuple[Repeated, ...]


def choose_patterns(table: RoomTable, matches: Correspondences) -> tuple[Repeated, ...]:
    """Patterns that share no room, those that save most rooms first.

    In each step the pattern is used that saves most rooms: those of all its occurrences but one. Then the same is done
    with the rooms that are left; and within one occurrence, as Fig. 4.2 has the pattern C in B.
    """
    grown = _grow_all(table, matches)
    return _choose(table, matches, grown, np.ones(len(table), bool))


def _choose(table: RoomTable, matches: Correspondences, grown: list[Indices], free: Mask) -> tuple[Repeated, ...]:
    """The patterns among free rooms; grown: rooms that may be a model."""
    chosen: list[Repeated] = []
    free = free.copy()
    inside = [rooms for rooms in grown if free[rooms].all()]
    while inside:
        candidates = [_list_copies(table, matches, rooms, free) for rooms in inside]
        best = max(candidates, key=lambda copies: _rank(table, copies))
        if len(best) < 2:
            break
        within = np.zeros(len(free), bool)
        within[best[0]] = True
        free[best.ravel()] = False
        chosen.append(Repeated(best, _choose(table, matches, grown, within)))
        inside = [rooms for rooms in inside if free[rooms].all()]
    return tuple(chosen)


def _rank(table: RoomTable, copies: Indices) -> tuple[float, ...]:
    """What decides between patterns: the rooms that one saves, then its area, then the numbers of its rooms."""
    saved = (len(copies) - 1) * copies.shape[1]
    area = float(shapely.area(table.shapes[copies]).sum()) / table.unit**2
    return saved, round(area / ROUNDING), *(-copies[0]).tolist()


def _list_copies(table: RoomTable, matches: Correspondences, rooms: Indices, free: Mask) -> Indices:
    """The occurrences of a model that share no room, shape (occurrences, rooms); itself first, then the nearest."""
    targets = matches.find_copies(rooms)
    targets = targets[free[targets].all(axis=1)]
    away = np.hypot(*(table.middles[targets] - table.middles[rooms]).mean(axis=1).T)
    apart = table.storeys[targets[:, :1]].ravel() != table.storeys[rooms[0]]
    used = set(rooms.tolist())
    copies = [rooms]
    for index in np.lexsort([np.arange(len(away)), (away / table.unit / ROUNDING).round(), apart]):
        copy = targets[index].tolist()
        if used.isdisjoint(copy):
            used.update(copy)
            copies.append(targets[index])
    return np.array(copies)


def _grow_all(table: RoomTable, matches: Correspondences) -> list[Indices]:
    """All sets of rooms that a correspondence maps onto other rooms, and that are as large as they can be."""
    away = np.hypot(*(table.middles[:, None] - table.middles).transpose(2, 0, 1)) / table.unit
    grown = {
        rooms
        for image, least in zip(matches.images, matches.least, strict=True)
        for rooms in _grow(table.near, away, image)
        if len(rooms) >= least
    }
    return [np.array(rooms) for rooms in sorted(grown)]


def _grow(near: Mask, away: Floats, image: Indices) -> Iterator[tuple[int, ...]]:
    """The connected sets of rooms around each room that share no room with their images.

    A set takes, again and again, the room nearest to its first one among those that are near a room of the set, while
    their images are near each other too.
    """
    members = np.flatnonzero((image >= 0) & (image != np.arange(len(image))))
    joined = near[np.ix_(members, members)] & near[np.ix_(image[members], image[members])]
    position = {room: index for index, room in enumerate(members.tolist())}
    blocks = [
        {position[room] for room in (target, source) if room in position}
        for target, source in zip(image[members].tolist(), _find_sources(image, members), strict=True)
    ]
    order = np.lexsort([np.broadcast_to(members, joined.shape), (away[np.ix_(members, members)] / ROUNDING).round()])
    for start in range(len(members)):
        rooms, reachable = [start], joined[start].copy()
        open_ = np.ones(len(members), bool)
        open_[[start, *blocks[start]]] = False
        while True:
            nearest = next((index for index in order[start].tolist() if reachable[index] and open_[index]), None)
            if nearest is None:
                break
            rooms.append(nearest)
            open_[[nearest, *blocks[nearest]]] = False
            reachable |= joined[nearest]
        yield tuple(sorted(members[rooms].tolist()))


def _find_sources(image: Indices, members: Indices) -> list[int]:
    """The room whose image each member is; -1 without one."""
    source = np.full(len(image), -1)
    source[image[members]] = members
    return [int(room) for room in source[members]]
