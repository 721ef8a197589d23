"""The model floor plan of a building: the rooms of which the others are repetitions (thesis, section 4.2.2)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
import shapely

from pianta._arguments import check_argument
from pianta._types import Floats, Indices
from pianta.errors import FloorError, OptionError
from pianta.floor import Floor
from pianta.patterns._correspondences import find_correspondences, fit_motion, overlap_shapes
from pianta.patterns._room_table import RoomTable, build_room_table
from pianta.patterns._selection import Repeated, choose_patterns

SHUFFLES = 20  # by default; the standard error of their mean is then a fifth of their standard deviation
# A reflection is stated only if its rooms overlap more by this IoU than those of a rotation; chosen by hand.
REFLECTION_GAIN = 0.02
SAME_ANGLE = 3  # degrees; a rotation is named by a right angle that is no farther; chosen by hand


@dataclass(frozen=True)
class Motion:
    """What takes the first occurrence of a pattern to another one: (x, y) becomes matrix · (x, y) + shift, metres.

    Parameters
    ----------
    matrix
        Two rows of two numbers: a rotation, or a reflection.
    shift
        Metres in x and y.
    overlap
        The mean IoU of the moved rooms and those of the occurrence, 0 … 1.

    Examples
    --------
    >>> from pianta.patterns.model_floor_plan import Motion
    >>> Motion(((0.0, -1.0), (1.0, 0.0)), (8.0, 0.0), 0.9).name
    'turned by 90°'
    """

    matrix: tuple[tuple[float, float], tuple[float, float]]
    shift: tuple[float, float]
    overlap: float

    @property
    def mirrored(self) -> bool:
        """Whether it is a reflection."""
        (a, b), (c, d) = self.matrix
        return a * d - b * c < 0

    @property
    def angle(self) -> float:
        """The angle of a rotation, or that of the axis of a reflection with the x-axis; degrees, counter-clockwise."""
        angle = float(np.degrees(np.arctan2(self.matrix[1][0], self.matrix[0][0])))
        return round(angle / 2 % 180, 3) if self.mirrored else round(angle % 360, 3)

    @property
    def name(self) -> str:
        """What it is in words: moved, turned or mirrored."""
        if self.mirrored:
            return "mirrored"
        right = round(self.angle / 90) * 90
        degrees = (right if abs(self.angle - right) <= SAME_ANGLE else round(self.angle)) % 360
        return f"turned by {degrees}°" if degrees else "moved"


@dataclass(frozen=True)
class Occurrence:
    """The rooms of one occurrence of a pattern.

    Parameters
    ----------
    rooms
        Ids of the rooms; those in the same place of two occurrences correspond.
    storey
        The index of their storey among the given floors.
    motion
        What takes the first occurrence here; None for the first one.
    """

    rooms: tuple[int, ...]
    storey: int
    motion: Motion | None


@dataclass(frozen=True)
class Pattern:
    """A group of rooms that is repeated.

    Parameters
    ----------
    name
        A, B and so on, by the number of rooms that they save; patterns within A are A.1, A.2 and so on.
    kind
        "row" if the rooms are on one side of a corridor, else "part".
    occurrences
        Two at least; no room is in two of them. The first is the model of the others.
    inner
        Patterns within the first occurrence.
    """

    name: str
    kind: str
    occurrences: tuple[Occurrence, ...]
    inner: tuple[Pattern, ...]

    @property
    def saved(self) -> int:
        """The rooms that need not be known: those of all occurrences but the first, and inside the first."""
        rooms = (len(self.occurrences) - 1) * len(self.occurrences[0].rooms)
        return rooms + sum(pattern.saved for pattern in self.inner)

    @property
    def rooms(self) -> int:
        """The rooms of all occurrences."""
        return len(self.occurrences) * len(self.occurrences[0].rooms)


@dataclass(frozen=True)
class Chance:
    """What the same rooms give when they exchange shapes and labels at random: means and standard deviations.

    Parameters
    ----------
    repeated, repeated_sd
        Of the share of the rooms that are in a pattern.
    saved, saved_sd
        Of the share of the rooms that patterns save.
    below
        The share of the shuffles that save fewer rooms than the true order; chance explains patterns where it is low.
    shuffles
        How many times the rooms were shuffled.
    """

    repeated: float
    repeated_sd: float
    saved: float
    saved_sd: float
    below: float
    shuffles: int


@dataclass(frozen=True)
class ModelFloorPlan:
    """The patterns of a floor, or of the storeys of a building.

    Parameters
    ----------
    patterns
        Those that save most rooms first; no room is in two of them.
    rooms
        The number of rooms.
    area
        Of all rooms, m².
    repeated_area
        Of the rooms in patterns, m².
    chance
        What shuffled rooms give; None if they were not shuffled.
    """

    patterns: tuple[Pattern, ...]
    rooms: int
    area: float
    repeated_area: float
    chance: Chance | None = None

    @property
    def repeated(self) -> float:
        """The share of the rooms that are in a pattern, 0 … 1."""
        return sum(pattern.rooms for pattern in self.patterns) / self.rooms

    @property
    def saved(self) -> float:
        """The score, 0 … 1: the share of the rooms that follow from the others, the rooms of the model floor plan."""
        return sum(pattern.saved for pattern in self.patterns) / self.rooms

    @property
    def model_rooms(self) -> int:
        """The number of rooms of the model floor plan: those that are left when no pattern is repeated."""
        return self.rooms - sum(pattern.saved for pattern in self.patterns)

    def as_json(self) -> dict[str, object]:
        """All patterns and figures, as values that JSON can hold.

        Returns
        -------
        dict
            The members of this class, and `repeated`, `saved` and `model_rooms`.
        """
        shares = {"repeated": self.repeated, "saved": self.saved, "model_rooms": self.model_rooms}
        return asdict(self) | shares


def find_model_floor_plan(
    floor: Floor | Sequence[Floor],
    *,
    labels: bool = True,
    shuffles: int = SHUFFLES,
    within_labels: bool = False,
    seed: int = 0,
) -> ModelFloorPlan:
    """Find the groups of rooms that a floor repeats: along its corridors, in its wings, and on its other storeys.

    Rooms are repeated when a motion maps them onto others of nearly the same shape, or when rooms of nearly the same
    frontage and depth follow each other along two stretches of corridors in the same or the opposite order. A pattern
    has two rooms at least. Patterns are chosen one after the other, each time the one that saves most rooms; the same
    is done within its first occurrence.

    Parameters
    ----------
    floor
        A floor, true or read from a map; or the storeys of a building, each in its own frame.
    labels
        Whether rooms of a pattern must have the same labels as their models; rooms without a label correspond to any.
    shuffles
        How often shapes and labels are shuffled among the rooms that are no corridors, to know what chance gives; 0 for
        never, which is that many times faster.
    within_labels
        Whether only rooms of the same label are shuffled, so that chance knows where which labels are.
    seed
        Of the shuffles.

    Returns
    -------
    ModelFloorPlan
        The patterns, the share of the rooms that they save, and what chance gives. It does not depend on the position,
        direction, handedness or scale of the floor.

    Raises
    ------
    FloorError
        No storey has rooms.
    OptionError
        The number of shuffles is negative, or a storey is no Floor.

    References
    ----------
    M. Luperto, PhD thesis, section 4.2.2; the method is ours.

    Examples
    --------
    >>> import pianta
    >>> from shapely import box
    >>> sizes = [(0, 3), (3, 5), (8, 4), (12, 3), (15, 5)]  # m: where each room begins, and how wide it is
    >>> rooms = [pianta.Room(n, box(x, 0, x + width, 6)) for n, (x, width) in enumerate(sizes, start=1)]
    >>> plan = pianta.find_model_floor_plan(pianta.Floor(tuple(rooms)), shuffles=0)
    >>> [occurrence.rooms for occurrence in plan.patterns[0].occurrences]
    [(1, 2), (4, 5)]
    >>> plan.repeated, plan.saved, plan.model_rooms
    (0.8, 0.4, 3)
    """
    if shuffles < 0:
        raise OptionError(f"shuffles is {shuffles}, give 0 or more")
    storeys = [*floor] if isinstance(floor, Sequence) else [floor]
    for storey in storeys:
        check_argument(storey, Floor, "floor", "a Floor, or a list of them")
    if not any(storey.rooms for storey in storeys):
        raise FloorError("the floor has no rooms, give one with rooms")
    table = build_room_table(storeys, labels=labels)
    chosen = choose_patterns(table, find_correspondences(table))
    area = shapely.area(table.shapes)
    plan = ModelFloorPlan(
        tuple(_describe(table, repeated, name) for name, repeated in zip(_letters(), chosen, strict=False)),
        len(table),
        float(area.sum()),
        float(sum(area[repeated.copies].sum() for repeated in chosen)),
    )
    if not shuffles:
        return plan
    generator = np.random.default_rng(seed)
    tables = (table.shuffle(generator, within_labels=within_labels) for _ in range(shuffles))
    return replace(plan, chance=_measure_chance(tables, plan.saved))


def _measure_chance(tables: Iterable[RoomTable], saved: float) -> Chance:
    """Means and standard deviations (n - 1; 0 of one) over shuffled rooms; saved: the share in their true order."""
    rows = []
    for table in tables:
        chosen = choose_patterns(table, find_correspondences(table))
        rooms = sum(each.copies.size for each in chosen), sum(map(_count_saved, chosen))
        rows.append(np.array(rooms) / len(table))
    shares = np.array(rows)
    means, deviations = shares.mean(axis=0), np.std(shares, axis=0, ddof=min(1, len(rows) - 1))
    below = float((shares[:, 1] < saved).mean())
    return Chance(
        float(means[0]), float(deviations[0]), float(means[1]), float(deviations[1]), below, shuffles=len(rows)
    )


def _count_saved(repeated: Repeated) -> int:
    """The rooms that a pattern and those within it save."""
    occurrences, rooms = repeated.copies.shape
    return int((occurrences - 1) * rooms + sum(map(_count_saved, repeated.inner)))


def _letters() -> Iterator[str]:
    """A to Z, then AA, AB and so on."""
    letters = [chr(code) for code in range(ord("A"), ord("Z") + 1)]
    yield from letters
    for first in _letters():
        yield from (first + letter for letter in letters)


def _describe(table: RoomTable, repeated: Repeated, name: str) -> Pattern:
    """A pattern by the ids of its rooms."""
    first, *others = repeated.copies
    in_row = any(np.isin(first, rooms).all() for rooms, _ in table.rows)
    occurrences = [_name_rooms(table, first, None)]
    occurrences += [_name_rooms(table, copy, _find_motion(table, first, copy)) for copy in others]
    inner = tuple(_describe(table, each, f"{name}.{number}") for number, each in enumerate(repeated.inner, start=1))
    return Pattern(name, "row" if in_row else "part", tuple(occurrences), inner)


def _name_rooms(table: RoomTable, rooms: Indices, motion: Motion | None) -> Occurrence:
    return Occurrence(tuple(table.ids[rooms].tolist()), int(table.storeys[rooms[0]]), motion)


def _find_motion(table: RoomTable, first: Indices, copy: Indices) -> Motion:
    """The rotation or reflection that takes rooms nearest to others; the rotation unless reflected rooms fit better."""
    moves = [_overlap(table, first, copy, mirrored=mirrored) for mirrored in (False, True)]
    (rotation, shift, overlap), reflection = moves
    if reflection[2] > overlap + REFLECTION_GAIN:
        rotation, shift, overlap = reflection
    (a, b), (c, d) = rotation.round(9).tolist()
    x, y = shift.round(6).tolist()
    return Motion(((a, b), (c, d)), (x, y), round(overlap, 6))


def _overlap(table: RoomTable, first: Indices, copy: Indices, *, mirrored: bool) -> tuple[Floats, Floats, float]:
    """The matrix and shift of the best rotation or reflection of rooms onto others, and the mean IoU after it."""
    matrix, shift = fit_motion(table.middles[first], table.middles[copy], mirrored=mirrored)
    moved = np.asarray(shapely.transform(table.outlines(first), lambda xy: xy @ matrix.T + shift), dtype=object)
    return matrix, shift, float(overlap_shapes(moved, table.outlines(copy)).mean())
