"""The verb watch: the building of the map that a running robot publishes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pianta.cli.terminal import Quiet, describe_floor, print_error, print_result
from pianta.errors import MapError, PiantaError
from pianta.gridmap import GridMap
from pianta.io._folders import check_output_folder
from pianta.ros.dds_topics import MAX_DOMAIN, iterate_topic
from pianta.ros.map_watcher import MapWatcher

EXAMPLES = (
    "pianta watch -o building",
    "pianta watch --topic /robot/map -o building --interface eth0",
)

Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for the results; created if necessary.")]
Topic = Annotated[str, typer.Option(metavar="NAME", help="Topic of nav_msgs/OccupancyGrid.")]
Interface = Annotated[
    str | None, typer.Option(metavar="NAME", help="Network interface of the robot; else this computer's loopback.")
]
DomainId = Annotated[
    int, typer.Option("--domain", min=0, max=MAX_DOMAIN, envvar="ROS_DOMAIN_ID", help="Domain of DDS.")
]
Count = Annotated[int | None, typer.Option(min=1, metavar="N", help="Stop after N readings; else with Ctrl+C.")]
Type = Annotated[str | None, typer.Option("--type", metavar="NAME", help="Building type, such as school or office.")]
NoLabels = Annotated[bool, typer.Option("--no-labels", help="Leave out the labels of rooms and the building type.")]


def watch_map(
    *,
    out: Out,
    topic: Topic = "/map",
    interface: Interface = None,
    domain: DomainId = 0,
    count: Count = None,
    building_type: Type = None,
    no_labels: NoLabels = False,
    quiet: Quiet = False,
) -> None:
    """Read what has changed on the map of a running robot, and print what has happened.

    Experimental: it takes nav_msgs/OccupancyGrid of ROS 2 from DDS, without ROS
    installed, by CycloneDDS; from this computer alone unless --interface names
    a network.

    Writes what `pianta read` writes. Rooms keep their ids, also those of a floor
    that is in the folder already; a map like the last one is not read again.
    """
    check_output_folder(out)
    watcher = MapWatcher.make(out, topic, building_type=building_type, labels=not no_labels)
    done = 0
    try:
        for grid in iterate_topic(topic, interface=interface, domain=domain):
            if isinstance(grid, MapError):
                print_error(grid)
            elif grid is not None:
                done += _read_map(watcher, grid, quiet=quiet)
            if done == count:
                return
    except KeyboardInterrupt:
        if not quiet:
            print_result(f"{done} readings, in {out}")


def _read_map(watcher: MapWatcher, grid: GridMap, *, quiet: bool) -> bool:
    """Read a map and print a line for it; whether it was read."""
    try:
        reading = watcher.update(grid)
    except PiantaError as error:
        print_error(error)
        return False
    if reading is not None and not quiet:
        print_result("; ".join([describe_floor(reading.floor), *reading.messages]))
    return reading is not None
