"""A publisher of maps as a ROS 2 node is one: by DDS, reliable and latched. As a script it runs as its own process."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from cyclonedds.util import duration

import pianta
from pianta.ros.dds_messages import Header, MapMetaData, OccupancyGrid, Point, Pose, Quaternion, Time
from pianta.ros.dds_topics import LOOPBACK


def make_writer(domain: int, topic: str) -> Any:
    participant = DomainParticipant(domain)
    qos = Qos(
        Policy.Reliability.Reliable(max_blocking_time=duration(seconds=1)),
        Policy.Durability.TransientLocal,
        Policy.History.KeepLast(1),
    )
    return DataWriter(participant, Topic(participant, "rt/" + topic.strip("/"), OccupancyGrid, qos=qos), qos=qos)


def make_message(grid: pianta.GridMap) -> OccupancyGrid:
    height, width = grid.shape
    pose = Pose(Point(*grid.origin[:2], 0.0), Quaternion(0.0, 0.0, 0.0, 1.0))
    info = MapMetaData(Time(0, 0), grid.resolution, width, height, pose)
    cells: Any = np.flipud(grid.cells).ravel().tolist()
    return OccupancyGrid(Header(Time(1, 0), "map"), info, cells)


def main(domain: str, topic: str, map_file: str) -> None:
    """Publish a map once, and stay until standard input ends."""
    started = Domain(int(domain), f"<CycloneDDS><Domain Id='any'>{LOOPBACK}</Domain></CycloneDDS>")
    writer = make_writer(int(domain), topic)
    writer.write(make_message(pianta.read_map(Path(map_file))))
    sys.stdout.write("published\n")
    sys.stdout.flush()
    sys.stdin.read()
    del writer, started


if __name__ == "__main__":
    main(*sys.argv[1:])
