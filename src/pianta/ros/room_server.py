"""RoomServer: what a ROS node of pianta gives to others, as texts, arrays and dataclasses of no ROS package."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from shapely import Point

from pianta.errors import PiantaError
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.io.bags import is_same_map
from pianta.io.floors import describe_floor
from pianta.io.grid_messages import GridMessage, MapBuilder
from pianta.plot.styles import style_rooms
from pianta.reading._reader import Reader, ReadOptions
from pianta.reading.growing_map import GrowingMap
from pianta.reading.reading import Reading

logger = logging.getLogger(__name__)
# A position beside every room is of the nearest one up to this far, metres: a robot stands in a doorway, or beside a
# wall that was drawn too thick. Chosen by hand.
MAX_DISTANCE = 0.5


@dataclass(frozen=True)
class RoomMarker:
    """A room as a marker shows it: outline and middle in metres, a text, and red, green and blue from 0 to 1."""

    id: int
    text: str
    outline: tuple[tuple[float, float], ...]
    middle: tuple[float, float]
    color: tuple[float, float, float]


@dataclass
class RoomServer:
    """The building of the last map, and the answers about it.

    growing: the readings so far. The state changes in `update` alone, as a whole, so that callbacks may run together.
    """

    growing: GrowingMap
    reading: Reading | None = field(default=None, init=False)

    @classmethod
    def make(cls, building_type: str = "", *, labels: bool = True) -> RoomServer:
        """A server without a map. building_type: "" if unknown. Raises PiantaError for an unknown type."""
        options: ReadOptions = {"labels": labels}
        if building_type:
            options["building_type"] = building_type
        return cls(GrowingMap(Reader.make(**options)))

    def update(self, message: GridMessage, log: Callable[[str], object] = logger.warning) -> bool:
        """Read the map of a nav_msgs/OccupancyGrid; whether there is a new building, with the ids of the last one.

        log: gets a line for a map that cannot be read; the last building stays then.
        """
        try:
            grid = MapBuilder.from_message(message).build("map")
            if self.reading is not None and is_same_map(grid, self.reading.grid):
                return False
            self.reading = self.growing.read(grid, "map")
        except PiantaError as error:
            log(str(error))
            return False
        return True

    @property
    def floor(self) -> Floor:
        """The rooms; none before the first map."""
        return self.reading.floor if self.reading else Floor(())

    def describe_floor(self) -> str:
        """The floor.geojson of the building, as text."""
        return json.dumps(describe_floor(self.floor), ensure_ascii=False, allow_nan=False)

    def list_rooms(self) -> str:
        """A JSON list of the rooms: id, name, label, area in m², and a point inside, in metres of the map."""
        rooms = []
        for room in self.floor:
            inside = room.polygon.representative_point()
            position = {"x": round(inside.x, 3), "y": round(inside.y, 3)}
            area = round(room.polygon.area, 2)
            rooms.append({"id": room.id, "name": room.title, "label": room.label, "area": area, **position})
        return json.dumps(rooms, ensure_ascii=False)

    def find_room(self, x: float, y: float) -> Room | None:
        """The room of a position in metres of the map; the nearest up to 0.5 m away, None beyond."""
        position = Point(x, y)
        nearest = min(self.floor, key=lambda room: room.polygon.distance(position), default=None)
        if nearest is None or not nearest.polygon.distance(position) <= MAX_DISTANCE:
            return None
        return nearest

    def label_image(self) -> NDArray[np.int32]:
        """The id of the room of each cell, 0 for none, shape (H, W), row 0 at the top, as sensor_msgs/Image 32SC1."""
        if self.reading is None:
            return np.zeros((0, 0), np.int32)
        return self.floor.label_image(self.grid).astype(np.int32)

    @property
    def grid(self) -> GridMap:
        """The last map; raises PiantaError before the first."""
        if self.reading is None:
            raise PiantaError("no map has arrived, publish one")
        return self.reading.grid

    def list_markers(self) -> list[RoomMarker]:
        """A marker for each room, in the colour that pictures of pianta give it."""
        return list(map(self._make_marker, self.floor))

    def _make_marker(self, room: Room) -> RoomMarker:
        from matplotlib.colors import to_rgb

        inside = room.polygon.representative_point()
        text = room.title or room.label or str(room.id)
        outline = tuple((x, y) for x, y, *_ in room.polygon.exterior.coords)
        color = to_rgb(style_rooms(self.floor)[room.id].color)
        return RoomMarker(room.id, text, outline, (inside.x, inside.y), color)
