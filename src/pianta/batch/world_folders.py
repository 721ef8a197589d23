"""Folders of worlds: a furnished floor as a map, for a robot simulator, and as the truth; and a robot's map of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pianta.batch.processes import run_items
from pianta.errors import PiantaError

if TYPE_CHECKING:
    from pianta.floor import Floor

# Of generated worlds: rooms in use, cells of usual maps, and the noise of a usual scan; chosen by hand.
FURNITURE = 1.0
RESOLUTION = 0.05  # metres per cell
NOISE = 0.3
# The files of a world in its folder, and those of its scan in that.
WORLD_FILES = ("map.yaml", "map.png", "truth.geojson", "world.sdf", "rooms.json")
SCAN_FILES = ("map.yaml", "map.png")


@dataclass(frozen=True)
class WorldOptions:
    """How floors become worlds.

    furniture: 0 empty … 1 in use, at most 10; by the labels of rooms. resolution: of the maps, metres per cell.
    scan: whether a robot's map is made, too. noise: of that map, 0 clean … 1 bad.
    """

    furniture: float = FURNITURE
    resolution: float = RESOLUTION
    scan: bool = False
    noise: float = NOISE

    def __post_init__(self) -> None:
        from pianta.worlds.scan import check_map_options

        check_map_options(resolution=self.resolution, noise=self.noise, furniture=self.furniture)


def save_world(floor: Floor, name: str, out: Path, options: WorldOptions, *, seed: int) -> None:
    """Write the world of a floor into a new folder of its name, and its scan into one of `name_scan`."""
    from pianta.building import Building, Storey
    from pianta.io.floors import save_floor
    from pianta.io.ros_maps import save_ros_map
    from pianta.io.writers.convert import convert
    from pianta.navigation.robot import ROBOT_RADIUS
    from pianta.worlds.furnish import furnish_for_robot
    from pianta.worlds.scan import simulate_map

    # The same furniture is in all files, and leaves ways for a robot
    truth = furnish_for_robot(floor, furniture=options.furniture, radius=ROBOT_RADIUS, seed=seed)
    folder = out / name
    folder.mkdir()
    # The map as the truth: walls and furniture in full depth
    save_ros_map(simulate_map(truth, resolution=options.resolution, solid_walls=True), folder / "map.yaml")
    save_floor(truth, folder / "truth.geojson")
    convert(Building((Storey(truth),), name), folder, to="gazebo")
    if options.scan:
        # The map of a robot: the faces of walls and furniture, with noise
        (out / name_scan(name)).mkdir()
        scan = simulate_map(truth, resolution=options.resolution, noise=options.noise, seed=seed)
        save_ros_map(scan, out / name_scan(name) / "map.yaml")


def name_scan(name: str) -> str:
    """The folder of the scan of a building: scan-001 for building-001."""
    return name.replace("building", "scan")


def save_worlds(
    floors: Sequence[tuple[int, str, Floor]],
    out: Path,
    options: WorldOptions,
    *,
    seed: int = 0,
    jobs: int = 1,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> None:
    """Write the worlds of drawn floors into folders of their names.

    floors: number, from 0, on which the world depends; name; and the floor. track: wraps the names of the steps.

    Raises PiantaError for a world that cannot be made.
    """
    names = [f"world {number + 1}" for number, _, _ in floors]
    outcomes = run_items(_WorldWork(out, options, seed), floors, jobs=jobs)
    faults = {outcome.item[1]: outcome.fault for _, outcome in zip(track(names), outcomes, strict=True)}
    for name, fault in faults.items():
        if fault:
            raise PiantaError(f"the world of {name} cannot be made: {fault.message}")


def list_world_files(names: Iterable[str], *, scan: bool = True) -> list[str]:
    """The files of the worlds of buildings; scan: with those of their scans."""
    scans = SCAN_FILES if scan else ()
    return [
        f"{folder}/{file}"
        for name in names
        for folder, files in ((name, WORLD_FILES), (name_scan(name), scans))
        for file in files
    ]


@dataclass(frozen=True)
class _WorldWork:
    """Writes a world, in a process."""

    out: Path
    options: WorldOptions
    seed: int

    def __call__(self, item: tuple[int, str, Floor]) -> None:
        from pianta.generation.buildings import find_building_seed

        number, name, floor = item
        seed = find_building_seed(self.seed, number)
        save_world(replace(floor, source=name), name, self.out, self.options, seed=seed)
