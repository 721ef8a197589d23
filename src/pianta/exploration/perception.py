"""What robots take for rooms while they explore, and for the room that they search; and the perfect perception."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pianta.errors import OptionError
from pianta.exploration.recognised_rooms import RecognisedRooms, recognise_rooms
from pianta.exploration.record import Record
from pianta.exploration.starts import find_rooms
from pianta.exploration.world import World
from pianta.gridmap import GridMap


@dataclass(frozen=True, eq=False)
class Percept:
    """What robots perceive. recognised: None without rooms. room_of_cell: shape (H, W), ids of rooms, 0 for none."""

    recognised: RecognisedRooms | None
    room_of_cell: NDArray[np.uint16]


@dataclass(frozen=True)
class WantedRoom:
    """A room that robots take for one of the wanted label.

    id: of the true room, or of that of the robots' map. label: as the room has it. is_right: whether a true room of
    this label is there; None if the truth has no label there, or just ROOM for one that is finer than R/C.
    probability: of the label, by the belief of the robots.
    """

    id: int
    label: str
    is_right: bool | None
    probability: float = 1.0


class Perception(Protocol):
    """Recognises rooms."""

    def check_label(self, label: str) -> None:
        """Raise OptionError for a label, in standard form, that no room can have."""
        ...

    def find_room(self, label: str, record: Record) -> WantedRoom | None:
        """A recognised room with a label in standard form; None without one. record: of the run until now."""
        ...

    def find_likeliest_room(self, label: str, grid: GridMap) -> WantedRoom | None:
        """After a search in vain, the room that has a label in standard form most probably; None without a belief.

        grid: the map at the end of the run.
        """
        ...

    def perceive(self, grid: GridMap, record: Record) -> Percept:
        """What robots perceive on their map. record: of the run until now."""
        ...


@dataclass(frozen=True, eq=False)
class PerfectPerception:
    """Rooms are recognised with their true outlines and labels, as section 8.3 of the thesis assumes."""

    world: World
    _wanted: dict[str, list[int]] = field(init=False, default_factory=dict)

    def check_label(self, label: str) -> None:
        """Raise OptionError with the existing labels if no true room has this one."""
        if find_rooms(self.world.floor, [label]):
            return
        floor = self.world.floor
        labels = sorted({room.label for room in floor.rooms if room.label} if floor else set())
        there = f"give one of {', '.join(labels)}" if labels else "its rooms have no labels, give a labelled floor"
        raise OptionError(f"no room of the world is {label}, {there}")

    def find_room(self, label: str, record: Record) -> WantedRoom | None:
        """A true room of the label of which enough was observed, or in which a robot was."""
        if label not in self._wanted:
            self._wanted[label] = find_rooms(self.world.floor, [label])
        recognised = record.recognised_at.keys() | record.entered_at.keys()
        wanted = next((room for room in self._wanted[label] if room in recognised), None)
        if wanted is None or self.world.floor is None:
            return None
        name = next(room.label for room in self.world.floor.rooms if room.id == wanted)
        return WantedRoom(wanted, name or label, is_right=True)

    def find_likeliest_room(self, label: str, grid: GridMap) -> WantedRoom | None:  # noqa: ARG002
        """None: robots that recognise rooms without error have found it, or it is not there."""
        return None

    def perceive(self, grid: GridMap, record: Record) -> Percept:
        """The true rooms of which enough was observed."""
        recognised = recognise_rooms(
            self.world, grid.cells, counts=record.room_counts, entered=record.entered_at.keys()
        )
        return Percept(recognised, self.world.room_of_cell)
