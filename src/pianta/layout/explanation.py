"""Why a floor was divided as it was: the borders between rooms that were considered, with their probabilities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString

from pianta._arguments import check_argument
from pianta._types import Floats, Indices
from pianta.floor import Door, Floor
from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters, StructureParameters, check_parameters

# The constants were chosen by hand.
# Distances from a border at which the rooms on its two sides are searched, nearest first; metres.
SIDE_DISTANCES = (0.1, 0.2, 0.3, 0.5)
# Positions along a border where they are searched, as shares of its length; most of them decide.
POSITIONS = (0.2, 0.35, 0.5, 0.65, 0.8)
# The door on a border is at most this far from its middle; metres.
DOOR_DISTANCE = 0.5
# A room is described by the most probable ones of the borders that do not divide it.
MAX_INNER_BORDERS = 3
# Why there is a door where no border was considered.
GAP_REASON = "a gap in the wall"


@dataclass(frozen=True)
class Border:
    """A line along which two rooms could meet.

    Attributes
    ----------
    rooms
        The ids of the rooms on both sides, the smaller first; the same id twice if they are one room.
    line
        Metres of the map frame.
    probability
        That it divides two rooms; None if a rule decided.
    reason
        What the decision rests on, in a few words.
    """

    rooms: tuple[int, int]
    line: LineString
    probability: float | None
    reason: str

    @property
    def divides(self) -> bool:
        """Whether there are two rooms."""
        return self.rooms[0] != self.rooms[1]


@dataclass(frozen=True, eq=False)
class Explanation:
    """What the method `structure` saw in a map, and how it decided.

    Attributes
    ----------
    grid
        The map.
    floor
        Its floor.
    borders
        All borders that were considered and have rooms on both sides.
    evidence
        Probability that a cell is outside, floor, wall, door or furniture, shape (H, W, 5) of the map; None without a
        model that gives it.

    Examples
    --------
    >>> import pianta
    >>> _, grid = pianta.make_world("corridor")
    >>> explanation = pianta.explain(grid)
    >>> {border.rooms for border in explanation.borders if 2 in border.rooms and border.divides}
    {(2, 9)}
    >>> explanation.describe_room(2).startswith("room 2: divided from 9 by a door of 0.9 m (p = ")
    True
    """

    grid: GridMap
    floor: Floor
    borders: tuple[Border, ...]
    evidence: NDArray[np.float32] | None = None

    def describe_room(self, room_id: int) -> str:
        """Say why a room was divided from its neighbours, and why it was not divided.

        Parameters
        ----------
        room_id
            The id of a room of the floor.

        Returns
        -------
        str
            One line: all borders to other rooms, and the most probable ones inside.

        Raises
        ------
        KeyError
            No room of the floor has this id.
        """
        room = self.floor[room_id]
        own = [border for border in self.borders if room.id in border.rooms]
        outer = self._describe_outer([border for border in sorted(own, key=_rank) if border.divides], room.id)
        inner = [_describe_inner(border) for border in sorted(own, key=_rank) if not border.divides]
        parts = [f"divided from {', from '.join(outer)}"] if outer else []
        parts += [f"not divided {', '.join(inner[:MAX_INNER_BORDERS])}"] if inner else []
        return f"room {room.id}: {'; '.join(parts) or 'no border was considered'}"

    def _describe_outer(self, borders: Sequence[Border], room_id: int) -> list[str]:
        """For each door, and for each room beyond a wall, what is there and why; the first border of each counts."""
        doors = [door for door in self.floor.doors if room_id in door.rooms and door.joins_rooms]
        passages: list[tuple[tuple[int, int | None], Door | None, str]] = [
            (border.rooms, find_door(border, doors), _describe_reason(border)) for border in borders
        ]
        # The line of a door need not be a border that was considered
        passages += [(door.rooms, door, GAP_REASON) for door in doors]
        described: dict[tuple[int, int], str] = {}
        for rooms, door, reason in passages:
            (other,) = {room for room in rooms if room is not None} - {room_id}
            described.setdefault((other, id(door)), f"{other} by {_describe_passage(door)} ({reason})")
        return [*described.values()]


def _describe_passage(door: Door | None) -> str:
    if door is None:
        return "a wall"
    return f"{'an' if door.kind == 'opening' else 'a'} {door.kind} of {door.width:.1f} m"


def _describe_inner(border: Border) -> str:
    (middle,) = border.line.interpolate(0.5, normalized=True).coords
    x, y = (coordinate + 0.0 for coordinate in middle)
    return f"along {border.line.length:.1f} m at ({x:.1f}, {y:.1f}) ({_describe_reason(border)})"


def _describe_reason(border: Border) -> str:
    return border.reason if border.probability is None else f"p = {border.probability:.2f}"


def _rank(border: Border) -> tuple[float, tuple[int, int]]:
    """The most probable first; what a rule decided is certain."""
    return -(1.0 if border.probability is None else border.probability), border.rooms


def explain(grid: GridMap, floor: Floor | None = None, *, parameters: Parameters | None = None) -> Explanation:
    """Explain the floor that the method `structure` finds in a map.

    Parameters
    ----------
    grid
        The map.
    floor
        Its floor, whose ids are used; None to reconstruct it.
    parameters
        Those with which the floor was reconstructed; None for the default values.

    Returns
    -------
    Explanation
        The borders that were considered, with the probability that each divides two rooms.

    Raises
    ------
    OptionError
        The parameters belong to another method.
    MapError
        The map shows no room.

    Examples
    --------
    >>> import pianta
    >>> _, grid = pianta.make_world("corridor")
    >>> floor = pianta.reconstruct(grid)
    >>> explanation = pianta.explain(grid, floor)
    >>> sum(border.divides for border in explanation.borders) >= len(floor.doors)
    True
    """
    from pianta.layout.reconstruct import find_rooms
    from pianta.layout.structure.explain import explain_structure

    check_argument(grid, GridMap, "grid", "a GridMap of read_map")
    checked = check_parameters(parameters, StructureParameters)
    floor = floor or find_rooms(grid, method="structure", parameters=checked)
    considered = explain_structure(grid, parameters=checked)
    sides = find_sides(considered.lines, floor, grid)
    rows = zip(sides.tolist(), considered.lines, considered.probabilities, considered.reasons, strict=True)
    borders = tuple(_make_borders(rows))
    return Explanation(grid, floor, borders, considered.evidence)


def _make_borders(rows: Iterator[tuple[list[int], Floats, float | None, str]]) -> Iterator[Border]:
    """Borders of rows of rooms, line, probability and reason, without those that have no room on a side."""
    for (one, other), line, probability, reason in rows:
        if one and other:
            yield Border((min(one, other), max(one, other)), LineString(line), probability, reason)


def find_sides(lines: Floats, floor: Floor, grid: GridMap) -> Indices:
    """Ids of the rooms on the two sides of lines, shape (N, 2), 0 for none. lines: shape (N, 2, 2), x and y, metres."""
    labels = floor.label_image(grid)
    along = lines[:, 1] - lines[:, 0]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    sides = np.zeros((len(lines), 2), np.intp)
    for number, (start, step, normal) in enumerate(zip(lines[:, 0], along, across, strict=True)):
        points = start + np.array(POSITIONS)[:, None] * step
        for side, direction in enumerate((normal, -normal)):
            sides[number, side] = _find_most_common([_find_room(point, direction, labels, grid) for point in points])
    return sides


def _find_room(point: Floats, direction: Floats, labels: NDArray[np.uint16], grid: GridMap) -> int:
    """The first room from a point in a direction, x and y in metres; 0 for none."""
    steps = point + np.array(SIDE_DISTANCES)[:, None] * direction
    rows, cols = (np.floor(values).astype(int) for values in grid.map_to_pixel(*steps.T))
    inside = (rows >= 0) & (rows < labels.shape[0]) & (cols >= 0) & (cols < labels.shape[1])
    rooms = labels[rows[inside], cols[inside]]
    return int(rooms[rooms > 0][0]) if (rooms > 0).any() else 0


def _find_most_common(rooms: Sequence[int]) -> int:
    """The most common id, 0 if there is no room at all; of equally common ones the smallest."""
    counts = np.bincount([room for room in rooms if room], minlength=1)
    return int(counts.argmax()) if counts.any() else 0


def find_door(border: Border, doors: Sequence[Door]) -> Door | None:
    """The door between the rooms of a border that is nearest to its middle, if any is near."""
    middle = border.line.interpolate(0.5, normalized=True)
    between = [door for door in doors if door.rooms == border.rooms]
    nearest = min(between, key=lambda door: float(shapely.distance(door.line, middle)), default=None)
    return nearest if nearest is not None and nearest.line.distance(middle) <= DOOR_DISTANCE else None
