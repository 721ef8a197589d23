"""Memory and time of reading a map from bags that grow: half of their bytes are maps, half are of another topic.

Each bag is made by rosbags and read in a process of its own, whose largest resident size is measured, less that of a
process that imports the same and reads nothing. The slope is that of the line through all sizes, by least squares.
"""

# ruff: noqa: ANN401 - rosbags makes the types of messages at run time
from __future__ import annotations

import argparse
import resource
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np

SIDE = 1000  # cells of a map; 1 MB a message
MB = 1_000_000
FILES = {"ROS 1 .bag": "run.bag", "ROS 2 .mcap": "run.mcap", "ROS 2 .db3": "run.db3"}


def main() -> None:
    """Print a table of all bags, and the slope of each kind."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=[50, 150, 300, 600], metavar="MB")
    parser.add_argument("--read", type=Path, help="Read this bag, in this process, and print its memory.")
    parser.add_argument("--series", action="store_true", help="With --read: iterate over all maps.")
    arguments = parser.parse_args()
    if arguments.read:
        print(*read_bag(arguments.read, is_series=arguments.series))
        return
    print("| bag | MB | last map: MB of memory | s | all maps: MB of memory | s |")
    print("| --- | --- | --- | --- | --- | --- |")
    slopes = []
    base = measure(Path(), [])[0]
    for title, name in FILES.items():
        rows = []
        for size in arguments.sizes:
            with TemporaryDirectory() as folder:
                path = make_bag(Path(folder), name, size)
                (last, last_time), (series, series_time) = measure(path, []), measure(path, ["--series"])
                size_mb = path.stat().st_size / MB
            rows.append((size_mb, last - base, series - base))
            values = (last - base, last_time, series - base, series_time)
            print(f"| {title} | {size_mb:.0f} | " + " | ".join(f"{value:.1f}" for value in values) + " |", flush=True)
        sizes, lasts, all_maps = np.array(rows).T
        slopes.append(
            f"{title}: slope {np.polyfit(sizes, lasts, 1)[0]:.4f} MB of memory a MB of bag for the last map, "
            f"{np.polyfit(sizes, all_maps, 1)[0]:.4f} for all"
        )
    print("\n" + "\n".join(slopes))


def measure(path: Path, options: list[str]) -> tuple[float, float]:
    """Largest resident size in MB, and seconds, of a process that reads a bag."""
    command = [sys.executable, __file__, "--read", str(path), *options]
    memory, seconds = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    return float(memory), float(seconds)


def read_bag(path: Path, *, is_series: bool) -> tuple[float, float]:
    """Largest resident size in MB and seconds of reading a bag; nothing is read from the working folder."""
    import rosbags.rosbag1
    import rosbags.rosbag2  # noqa: F401
    from rosbags.typesys import Stores, get_typestore

    from pianta.io import bags

    get_typestore(Stores.ROS2_HUMBLE)
    start = perf_counter()
    if path != Path():
        maps = bags.iterate_bag(path) if is_series else [bags.read_bag(path)]
        for grid in maps:
            if grid.shape != (SIDE, SIDE):
                raise ValueError(f"the map has the shape {grid.shape}")
    seconds = perf_counter() - start
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000, round(seconds, 2)


def make_bag(folder: Path, name: str, size: int) -> Path:
    """A bag of about `size` MB: maps that change by a cell, and images of noise, in turn."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    is_ros1 = name.endswith(".bag")
    types: Any = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_HUMBLE)
    serialize = types.serialize_ros1 if is_ros1 else types.serialize_cdr
    plugin = StoragePlugin.MCAP if name.endswith(".mcap") else StoragePlugin.SQLITE3
    writer: Any = Writer1(folder / name) if is_ros1 else Writer2(folder / "run", version=9, storage_plugin=plugin)
    random = np.random.default_rng(0)
    cells = random.choice(np.array([-1, 0, 100], np.int8), (SIDE, SIDE))
    with writer as opened:
        map_type, image_type = "nav_msgs/msg/OccupancyGrid", "sensor_msgs/msg/Image"
        maps = opened.add_connection("/map", map_type, typestore=types)
        images = opened.add_connection("/camera", image_type, typestore=types)
        for second in range(size // 2):
            cells[second % SIDE, 0] = second % 100
            opened.write(maps, second * 10**9, serialize(make_map(types, cells), map_type))
            noise = random.integers(0, 256, SIDE * SIDE, np.uint8)
            opened.write(images, second * 10**9 + 1, serialize(make_image(types, noise), image_type))
    return folder / name if is_ros1 else next((folder / "run").glob(f"*{Path(name).suffix}"))


def make_header(types: Any) -> Any:
    """A header without a time."""
    extra = {"seq": 0} if "seq" in dict(types.fielddefs["std_msgs/msg/Header"][1]) else {}
    return types.types["std_msgs/msg/Header"](stamp=make_time(types), frame_id="map", **extra)


def make_time(types: Any) -> Any:
    """The time zero."""
    return types.types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)


def make_map(types: Any, cells: Any) -> Any:
    """An OccupancyGrid."""
    named = types.types
    pose = named["geometry_msgs/msg/Pose"](
        position=named["geometry_msgs/msg/Point"](x=0.0, y=0.0, z=0.0),
        orientation=named["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
    )
    info = named["nav_msgs/msg/MapMetaData"](
        map_load_time=make_time(types), resolution=0.05, width=SIDE, height=SIDE, origin=pose
    )
    return named["nav_msgs/msg/OccupancyGrid"](header=make_header(types), info=info, data=cells.ravel())


def make_image(types: Any, noise: Any) -> Any:
    """An image of one channel."""
    return types.types["sensor_msgs/msg/Image"](
        header=make_header(types), height=SIDE, width=SIDE, encoding="mono8", is_bigendian=0, step=SIDE, data=noise
    )


if __name__ == "__main__":
    main()
