"""Local patterns of a floor: a room and what lies behind its doors, and how often that is seen on reference floors."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pianta.building_types.description import BuildingDescription
from pianta.realism.measures import USUAL, show_value
from pianta.rooms.completion import LABELS

# From so many neighbours of a label on they are not told apart.
MANY = 3
PATTERNS_TOLD = 3
# What deviates less is chance, by the distribution of chi-squared in 1 of 100 patterns; so is a room alone.
LEAST_DEVIANCE = 6.63
LEAST_ROOMS = 2
# A pattern that no reference floor has is thought to occur in this share of a room on them together.
UNSEEN = 0.5


@dataclass(frozen=True, order=True)
class RoomPattern:
    """A room with the rooms behind its doors.

    label: of the room. behind: labels of these and how many have them, MANY for more; sorted by label.
    """

    label: str
    behind: tuple[tuple[str, int], ...]

    def __str__(self) -> str:
        if not self.behind:
            return f"{self.label} without a door to another room"
        told = [_count(label, count) for label, count in self.behind]
        connecting = next(kinds[1] for kinds in LABELS.values() if self.label in kinds)
        if connecting != self.label and connecting not in dict(self.behind):
            told.append(f"no {connecting}")
        only = " only" if len(told) == 1 else ""
        return f"{self.label} that leads to {' and '.join(told)}{only}"


@dataclass(frozen=True)
class OffPattern:
    """A pattern that is much more, or much less, frequent on a floor than is usual.

    rooms: ids of the rooms of the floor that have it. share: of the rooms of the floor.
    usual: that share on each of the reference floors, ascending. strangeness: the deviance of the number of rooms from
    the expected one.
    """

    pattern: RoomPattern
    rooms: tuple[int, ...]
    share: float
    usual: tuple[float, ...]
    strangeness: float

    @property
    def is_frequent(self) -> bool:
        """Whether there is too much of it, and not too little."""
        return self.share > float(np.median(self.usual))

    def as_json(self) -> dict[str, object]:
        """All of it, as JSON can hold it."""
        of_pattern = {"pattern": str(self.pattern), "rooms": self.rooms, "share": self.share, "usual": self.usual}
        return of_pattern | {"strangeness": self.strangeness, "reason": str(self)}

    def __str__(self) -> str:
        low, high = (show_value(float(bound), None) for bound in np.quantile(self.usual, USUAL))
        usually = f"usually {low} to {high}" if low != high else f"usually {low}"
        rooms = f" (rooms {' '.join(map(str, self.rooms))})" if self.rooms and self.is_frequent else ""
        often = "often" if self.is_frequent else "seldom"
        return f"{often} a {self.pattern}: {show_value(self.share, None)} of the rooms, {usually}{rooms}"


def list_patterns(description: BuildingDescription) -> list[RoomPattern]:
    """The pattern of each room, in the order of the description."""
    behind: list[Counter[str]] = [Counter() for _ in description.labels]
    for one, other in description.doors:
        behind[one][description.labels[other]] += 1
        behind[other][description.labels[one]] += 1
    return [
        RoomPattern(label, tuple(sorted((name, min(count, MANY)) for name, count in around.items())))
        for label, around in zip(description.labels, behind, strict=True)
    ]


def find_off_patterns(
    patterns: Sequence[RoomPattern], known: Sequence[Sequence[RoomPattern]], room_ids: Sequence[int]
) -> tuple[OffPattern, ...]:
    """The patterns whose share of the rooms is outside the usual range, the strangest first.

    patterns: of the rooms of a floor, whose ids are room_ids. known: of the rooms of each reference floor.
    """
    rooms_of: dict[RoomPattern, list[int]] = {}
    for pattern, room_id in zip(patterns, room_ids, strict=True):
        rooms_of.setdefault(pattern, []).append(room_id)
    off = sorted(_list_off_patterns(rooms_of, known), key=lambda found: (-found.strangeness, found.pattern))
    return tuple(off[:PATTERNS_TOLD])


def _list_off_patterns(
    rooms_of: Mapping[RoomPattern, Sequence[int]], known: Sequence[Sequence[RoomPattern]]
) -> Iterator[OffPattern]:
    counts = [Counter(of_floor) for of_floor in known]
    rooms = sum(map(len, rooms_of.values()))
    rooms_known = sum(map(len, known))
    for pattern in sorted({*rooms_of, *(pattern for of_floor in counts for pattern in of_floor)}):
        usual = sorted(count[pattern] / len(of_floor) for count, of_floor in zip(counts, known, strict=True))
        ids = tuple(sorted(rooms_of.get(pattern, ())))
        share = len(ids) / rooms
        low, high = np.quantile(usual, USUAL)
        expected = rooms * max(float(np.mean(usual)), UNSEEN / rooms_known)
        deviance = _measure_deviance(len(ids), expected)
        if (share < low or (share > high and len(ids) >= LEAST_ROOMS)) and deviance >= LEAST_DEVIANCE:
            yield OffPattern(pattern, ids, share, tuple(usual), deviance)


def _measure_deviance(count: int, expected: float) -> float:
    """How much a count deviates from the expected one, as Poisson's distribution has it; 0 when it does not."""
    return 2 * ((count * float(np.log(count / expected)) if count else 0.0) - (count - expected))


def _count(label: str, count: int) -> str:
    if count == 1:
        return f"1 {label}"
    return f"{count}{' or more' * (count == MANY)} {label}s"
