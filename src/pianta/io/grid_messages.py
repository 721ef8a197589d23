"""ROS messages of grids: nav_msgs/OccupancyGrid, and map_msgs/OccupancyGridUpdate, which changes a part of one.

Nothing of ROS is imported: a message is any object with the fields of its definition, be it of a bag, of DDS or of
rclpy. Row 0 of a message is at the bottom of the map, and row 0 of a GridMap at the top.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot, isfinite
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pianta.errors import MapError
from pianta.gridmap import OCCUPIED, UNKNOWN, GridMap
from pianta.io._files import MAX_CELLS, check_cell_count

# Of a quaternion's length from 1, and of a rotation from the plane (sine of the angle); chosen by hand.
MAX_LENGTH_ERROR = 0.01
MAX_TILT = 0.001


class GridMessage(Protocol):
    """A nav_msgs/OccupancyGrid."""

    info: Any
    data: Any


class UpdateMessage(Protocol):
    """A map_msgs/OccupancyGridUpdate."""

    x: int
    y: int
    width: int
    height: int
    data: Any


@dataclass
class MapBuilder:
    """A map as messages make it: a grid replaces it, and updates change parts of it.

    cells: shape (H, W), row 0 at the bottom; origin: x, y, yaw of the lower-left corner.
    """

    cells: NDArray[np.int8]
    resolution: float
    origin: tuple[float, float, float]

    @classmethod
    def from_message(cls, message: GridMessage, *, max_cells: int = MAX_CELLS) -> MapBuilder:
        """The map of a grid; raises MapError for sizes that contradict the data, and for an impossible origin."""
        info = message.info
        cells = _read_cells(message.data, info.width, info.height, "grid", max_cells).copy()
        resolution = float(info.resolution)
        if not (isfinite(resolution) and resolution > 0):
            raise MapError(f"resolution is {resolution}, give positive metres per cell")
        # The shortest number with the same 32 bits: 0.05, and not 0.05000000074505806
        resolution = float(str(np.float32(resolution)))
        position = float(info.origin.position.x), float(info.origin.position.y)
        if not all(map(isfinite, position)):
            raise MapError(f"origin is {position}, give finite metres")
        return cls(cells, resolution, (*position, read_yaw(info.origin.orientation)))

    def update(self, message: UpdateMessage) -> None:
        """Change the cells of an update; raises MapError if they do not lie on the map."""
        height, width = self.cells.shape
        x, y = int(message.x), int(message.y)
        part = _read_cells(message.data, message.width, message.height, "update", self.cells.size)
        rows, cols = part.shape
        if x < 0 or y < 0 or x + cols > width or y + rows > height:
            raise MapError(f"an update of {cols} × {rows} cells at {x}, {y} is not on the map of {width} × {height}")
        self.cells[y : y + rows, x : x + cols] = part

    def build(self, source: str = "") -> GridMap:
        """The map as it is now."""
        return GridMap(np.flipud(self.cells).copy(), self.resolution, self.origin, source)


def grid_from_message(message: GridMessage, source: str = "") -> GridMap:
    """Map of a nav_msgs/OccupancyGrid; raises MapError for another message."""
    return MapBuilder.from_message(message).build(source)


def read_yaw(quaternion: Any) -> float:  # noqa: ANN401
    """The angle of a rotation in the plane, radians; raises MapError for other rotations.

    A quaternion of zeros, which is what ROS 1 has where none was set, is no rotation.
    """
    x, y, z, w = (float(getattr(quaternion, name)) for name in "xyzw")
    length = hypot(x, y, z, w)
    if length == 0:
        return 0.0
    if not abs(length - 1) <= MAX_LENGTH_ERROR:
        raise MapError(f"orientation is {x}, {y}, {z}, {w}, give a quaternion of length 1")
    if hypot(x, y) / length > MAX_TILT:
        raise MapError(f"orientation {x}, {y}, {z}, {w} has roll or pitch, give a map that is level")
    return 2 * atan2(z, w) if w >= 0 else 2 * atan2(-z, -w)


def _read_cells(data: Any, width: int, height: int, what: str, max_cells: int) -> NDArray[np.int8]:  # noqa: ANN401
    """The cells of a message, shape (H, W); raises MapError."""
    columns, rows = int(width), int(height)
    check_cell_count((columns, rows), f"the {what}", max_cells=max_cells)
    if columns < 1 or rows < 1 or len(data) != columns * rows:
        raise MapError(f"the {what} says {columns} × {rows} cells and has {len(data)}, the message is damaged")
    cells = np.frombuffer(data, np.int8) if isinstance(data, bytes | bytearray) else np.asarray(data)
    if cells.dtype == np.uint8:
        cells = cells.view(np.int8)
    if cells.min() < UNKNOWN or cells.max() > OCCUPIED:
        raise MapError(f"cells of the {what} lie in {cells.min()} … {cells.max()}, give -1 to 100")
    return cells.astype(np.int8, copy=False).reshape(rows, columns)
