"""Maps of buildings that a simulated robot has explored in part, with all true rooms, to learn from.

A robot explores simulated maps of drawn schools and offices and of made floors, and real maps whose rooms are known:
those of data/slam and data/survey. Buildings of data/partial are left out, so that `pianta bench partial` measures on
buildings that took no part.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from zlib import crc32

import numpy as np
import shapely

from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io.maps import read_map
from pianta.layout._label_images import outline_labels
from pianta.layout.reconstruct import find_rooms
from pianta.worlds.partial_scan import simulate_partial_map
from pianta_bench.data.annotated_floors import read_drawing
from pianta_bench.data.building_of import building_of
from pianta_bench.data.folders import SLAM_FOLDER, SLAM_RESOLUTION, SLAM_TRUTH, list_maps
from pianta_bench.data.map_sets import SETS
from pianta_bench.partial.maps import PartialMap, grow_to_walls, simulate_drawing, simulate_world

DRAWING = "drawn"
WORLD = "world"
SLAM = "slam"
# Sets of real maps of data/survey.
SURVEY_SETS = ("survey", "furniture")
# Buildings, chosen by hand, that the network does not learn from, and that the choice of a hypothesis is tuned on.
VALIDATION = ("plans", "officeb", "labf", "sidneyriver")
# The constants were chosen by hand.
# Explorations of each drawing, of each map of data/slam, and of each of data/survey.
ROUNDS = {DRAWING: 4, SLAM: 8, **dict.fromkeys(SURVEY_SETS, 8)}
# Made floors.
WORLDS = 60
# Ranges of the explorations of real maps: metres that the lidar sees, share of the doors, and probability of entering.
REACHES = (6.0, 8.0, 12.0, 20.0, 30.0)
SHARES = (0.1, 0.9)
ENTERED = (0.1, 0.9)


@dataclass(frozen=True)
class Job:
    """One exploration. source: of ROUNDS, or WORLD. item: name of the drawing or map, or number of the made floor."""

    source: str
    building: str
    item: str
    number: int

    @property
    def name(self) -> str:
        """A name that no other job has, fit for a file."""
        return f"{self.source}__{self.building}__{self.item}-{self.number}"

    @property
    def seed(self) -> int:
        """Of the simulation; the same in each run."""
        return crc32(self.name.encode())

    def read(self, data: Path) -> PartialMap:
        """The map and its true rooms; raises PiantaError if it cannot be made."""
        if self.source == WORLD:
            return simulate_world(self.number, first_seed=0)
        if self.source == DRAWING:
            building_type, _, name = self.item.partition(".")
            drawing = read_drawing(data / "buildings" / building_type / f"{name}.xml")
            return simulate_drawing(drawing, seed=self.seed)
        return self._explore(*(_read_school if self.source == SLAM else _read_survey)(data, self.source, self.item))

    def _explore(self, floor: Floor, grid: GridMap, rooms: list[shapely.Polygon]) -> PartialMap:
        rng = np.random.default_rng(self.seed)
        inner = replace(floor, doors=tuple(door for door in floor.doors if not door.is_entrance))
        reach, share, entered = float(rng.choice(REACHES)), rng.uniform(*SHARES), rng.uniform(*ENTERED)
        explored = simulate_partial_map(inner, grid, share=share, reach=reach, entered=entered, seed=self.seed)
        return PartialMap(self.name, explored, rooms)


def list_jobs(data: Path) -> list[Job]:
    """All explorations, without the buildings of data/partial."""
    left_out = {building_of(data, f"buildings/school/{folder.name}.xml") for folder in (data / "partial").iterdir()}
    items = [item for item in _list_items(data) if item[2] not in left_out]
    jobs = [
        Job(source, building, item, number)
        for number in range(max(ROUNDS.values()))
        for source, item, building in items
        if number < ROUNDS[source]
    ]
    return jobs + [Job(WORLD, f"world{number}", "floor", number) for number in range(WORLDS)]


def _list_items(data: Path) -> Iterator[tuple[str, str, str]]:
    """Source, item and building of real maps and drawings."""
    for item in list_maps(data / SLAM_FOLDER, SLAM_TRUTH):
        yield SLAM, item, building_of(data, f"{SLAM_FOLDER}/{item}.png")
    for name in SURVEY_SETS:
        for item in SETS[name].list_items(data):
            yield name, item, SETS[name].building_of(data, item)
    for building_type in ("school", "office"):
        for file in sorted((data / "buildings" / building_type).glob("*.xml")):
            yield DRAWING, f"{building_type}.{file.stem}", building_of(data, f"buildings/{building_type}/{file.name}")


def _read_school(data: Path, _: str, item: str) -> tuple[Floor, GridMap, list[shapely.Polygon]]:
    """The true floor, the map and the true rooms of a school of data/slam."""
    grid = read_map(data / SLAM_FOLDER / f"{item}.png", resolution=SLAM_RESOLUTION)
    floor = read_drawing(data / SLAM_FOLDER / f"{item}{SLAM_TRUTH}", grid=grid)
    return floor, grid, [room.polygon for room in floor.rooms]


def _read_survey(data: Path, name: str, item: str) -> tuple[Floor, GridMap, list[shapely.Polygon]]:
    """A map of data/survey with the doors that pianta finds, and its true rooms to the middle of their walls."""
    true = SETS[name].read(data / SETS[name].folder, item)
    outlines, _ = outline_labels(true.spaces.astype(np.int32))
    rooms = [
        shapely.transform(outline, lambda xy: np.column_stack(true.grid.pixel_to_map(xy[:, 1], xy[:, 0])))
        for outline in outlines
    ]
    return find_rooms(true.grid, method="structure"), true.grid, grow_to_walls(rooms)


def add_data_option(parser: argparse.ArgumentParser) -> None:
    """Add the option --data to a script."""
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
