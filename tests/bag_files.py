"""Bags for tests, written by rosbags: grids, updates, and messages of other topics."""

from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from pianta.gridmap import GridMap
from pianta.io.bags import UPDATE_DEFINITION, UPDATE_TYPE

ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
for store in (ROS1, ROS2):
    store.register(get_types_from_msg(UPDATE_DEFINITION, UPDATE_TYPE))
GRID_TYPE = "nav_msgs/msg/OccupancyGrid"


def make_header(types: Any, seconds: int = 0) -> Any:
    extra = {"seq": 0} if types is ROS1 else {}
    stamp = types.types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=0)
    return types.types["std_msgs/msg/Header"](stamp=stamp, frame_id="map", **extra)


def make_grid(
    types: Any, cells: Any, *, resolution: float = 0.05, position=(0.0, 0.0), turn=(0.0, 0.0, 0.0, 1.0)
) -> Any:
    """An OccupancyGrid; cells: shape (H, W), row 0 at the bottom."""
    named, cells = types.types, np.asarray(cells, np.int8)
    point = named["geometry_msgs/msg/Point"](x=position[0], y=position[1], z=0.0)
    pose = named["geometry_msgs/msg/Pose"](
        position=point, orientation=named["geometry_msgs/msg/Quaternion"](x=turn[0], y=turn[1], z=turn[2], w=turn[3])
    )
    info = named["nav_msgs/msg/MapMetaData"](
        map_load_time=named["builtin_interfaces/msg/Time"](sec=0, nanosec=0),
        resolution=resolution,
        width=cells.shape[1],
        height=cells.shape[0],
        origin=pose,
    )
    return named[GRID_TYPE](header=make_header(types), info=info, data=cells.ravel())


def make_grid_of_map(types: Any, grid: GridMap) -> Any:
    return make_grid(types, np.flipud(grid.cells), resolution=grid.resolution, position=grid.origin[:2])


def make_update(types: Any, cells: Any, x: int, y: int) -> Any:
    cells = np.asarray(cells, np.int8)
    return types.types[UPDATE_TYPE](
        header=make_header(types), x=x, y=y, width=cells.shape[1], height=cells.shape[0], data=cells.ravel()
    )


def write_bag(path: Path, messages: list[tuple[str, str, Any]], *, storage: str = "mcap") -> Path:
    """A ROS 2 folder, or a ROS 1 .bag by its suffix, of topics, types and messages, a second apart."""
    types: Any = ROS1 if path.suffix == ".bag" else ROS2
    serialize = types.serialize_ros1 if types is ROS1 else types.serialize_cdr
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    writer: Any = Writer1(path) if types is ROS1 else Writer2(path, version=9, storage_plugin=plugin)
    with writer as open_writer:
        connections: dict[str, Any] = {}
        for second, (topic, message_type, message) in enumerate(messages, start=1):
            if topic not in connections:
                connections[topic] = open_writer.add_connection(topic, message_type, typestore=types)
            open_writer.write(connections[topic], second * 10**9, serialize(message, message_type))
    return path
