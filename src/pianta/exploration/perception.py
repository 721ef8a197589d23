"""What robots take for rooms while they explore, and the interface of perceptions; the perfect one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pianta.exploration.recognised_rooms import RecognisedRooms, recognise_rooms
from pianta.exploration.record import Record
from pianta.exploration.world import World
from pianta.gridmap import GridMap


@dataclass(frozen=True, eq=False)
class Percept:
    """What robots perceive. recognised: None without rooms. room_of_cell: shape (H, W), ids of rooms, 0 for none."""

    recognised: RecognisedRooms | None
    room_of_cell: NDArray[np.uint16]


class Perception(Protocol):
    """Recognises rooms."""

    def perceive(self, grid: GridMap, record: Record) -> Percept:
        """What robots perceive on their map. record: of the run until now."""
        ...


@dataclass(frozen=True, eq=False)
class PerfectPerception:
    """Rooms are recognised with their true outlines and labels, as section 8.3 of the thesis assumes."""

    world: World

    def perceive(self, grid: GridMap, record: Record) -> Percept:
        """The true rooms of which enough was observed."""
        recognised = recognise_rooms(
            self.world, grid.cells, counts=record.room_counts, entered=record.entered_at.keys()
        )
        return Percept(recognised, self.world.room_of_cell)
