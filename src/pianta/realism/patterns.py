"""Local patterns of a floor: a room with the rooms behind its doors, and how frequent it is on reference floors."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pianta.building_types.description import BuildingDescription
from pianta.realism.measures import USUAL, format_value
from pianta.rooms.completion import LABELS

# Neighbours of one label are counted up to this number.
MANY = 3
# Unusual patterns that are reported, those with the largest deviation.
MAX_PATTERNS = 3
# 99 % quantile of chi-squared with 1 degree of freedom: a smaller deviance is chance.
MIN_DEVIANCE = 6.63
# A single room with a rare pattern is chance, too.
MIN_ROOMS = 2
# Rooms of all reference floors together that are assumed to have a pattern that none of them has.
UNSEEN_ROOMS = 0.5


@dataclass(frozen=True, order=True)
class RoomPattern:
    """A room with the rooms behind its doors.

    label: of the room. behind: labels of these rooms and how many have them, at most MANY; sorted by label.
    """

    label: str
    behind: tuple[tuple[str, int], ...]

    def __str__(self) -> str:
        if not self.behind:
            return f"{self.label} without a door to another room"
        neighbours = [_count(label, count) for label, count in self.behind]
        connecting = next(labels[1] for labels in LABELS.values() if self.label in labels)
        if connecting != self.label and connecting not in dict(self.behind):
            neighbours.append(f"no {connecting}")
        only = " only" if len(neighbours) == 1 else ""
        return f"{self.label} that leads to {' and '.join(neighbours)}{only}"


@dataclass(frozen=True)
class UnusualPattern:
    """A pattern that is much more, or much less, frequent on a floor than on the reference floors.

    rooms: ids of the rooms of the floor that have it. share: of the rooms of the floor.
    usual: that share on each of the reference floors, ascending. deviation: the deviance of the number of rooms from
    the expected one.
    """

    pattern: RoomPattern
    rooms: tuple[int, ...]
    share: float
    usual: tuple[float, ...]
    deviation: float

    @property
    def is_frequent(self) -> bool:
        """Whether it is too frequent, not too rare."""
        return self.share > float(np.median(self.usual))

    def as_json(self) -> dict[str, object]:
        """All attributes, as values that JSON can hold."""
        return {
            "pattern": str(self.pattern),
            "rooms": self.rooms,
            "share": self.share,
            "usual": self.usual,
            "deviation": self.deviation,
            "reason": str(self),
        }

    def __str__(self) -> str:
        low, high = (format_value(float(bound), None) for bound in np.quantile(self.usual, USUAL))
        usually = f"usually {low} to {high}" if low != high else f"usually {low}"
        rooms = f" (rooms {' '.join(map(str, self.rooms))})" if self.rooms and self.is_frequent else ""
        often = "often" if self.is_frequent else "seldom"
        return f"{often} a {self.pattern}: {format_value(self.share, None)} of the rooms, {usually}{rooms}"


def list_patterns(description: BuildingDescription) -> list[RoomPattern]:
    """The pattern of each room, in the order of the description."""
    behind: list[Counter[str]] = [Counter() for _ in description.labels]
    for one, other in description.doors:
        behind[one][description.labels[other]] += 1
        behind[other][description.labels[one]] += 1
    return [
        RoomPattern(label, tuple(sorted((name, min(count, MANY)) for name, count in counts.items())))
        for label, counts in zip(description.labels, behind, strict=True)
    ]


def find_unusual_patterns(
    patterns: Sequence[RoomPattern], reference: Sequence[Sequence[RoomPattern]], room_ids: Sequence[int]
) -> tuple[UnusualPattern, ...]:
    """The patterns whose share of the rooms is outside the usual range, the largest deviation first.

    patterns: of the rooms of a floor, whose ids are room_ids. reference: of the rooms of each reference floor.
    """
    rooms: dict[RoomPattern, list[int]] = {}
    for pattern, room_id in zip(patterns, room_ids, strict=True):
        rooms.setdefault(pattern, []).append(room_id)
    unusual = sorted(_list_unusual_patterns(rooms, reference), key=lambda each: (-each.deviation, each.pattern))
    return tuple(unusual[:MAX_PATTERNS])


def _list_unusual_patterns(
    rooms_by_pattern: Mapping[RoomPattern, Sequence[int]], reference: Sequence[Sequence[RoomPattern]]
) -> Iterator[UnusualPattern]:
    """The patterns that are too rare or too frequent; rooms_by_pattern: ids of rooms. reference: patterns by floor."""
    counts = [Counter(floor) for floor in reference]
    rooms = sum(map(len, rooms_by_pattern.values()))
    reference_rooms = sum(map(len, reference))
    for pattern in sorted({*rooms_by_pattern, *(pattern for floor in counts for pattern in floor)}):
        usual = sorted(count[pattern] / len(floor) for count, floor in zip(counts, reference, strict=True))
        ids = tuple(sorted(rooms_by_pattern.get(pattern, ())))
        share = len(ids) / rooms
        low, high = np.quantile(usual, USUAL)
        expected = rooms * max(float(np.mean(usual)), UNSEEN_ROOMS / reference_rooms)
        deviance = _measure_deviance(len(ids), expected)
        if (share < low or (share > high and len(ids) >= MIN_ROOMS)) and deviance >= MIN_DEVIANCE:
            yield UnusualPattern(pattern, ids, share, tuple(usual), deviance)


def _measure_deviance(count: int, expected: float) -> float:
    """The deviance of a count from the expected one by Poisson's distribution; 0 if they are equal."""
    return 2 * ((count * float(np.log(count / expected)) if count else 0.0) - (count - expected))


def _count(label: str, count: int) -> str:
    if count == 1:
        return f"1 {label}"
    return f"{count}{' or more' * (count == MANY)} {label}s"
