"""The sets of maps with true rooms and doors that layouts are measured on, and the choice of maps of all sets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from pianta.errors import DataError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.maps import read_map
from pianta.worlds.make import make_synthetic_world
from pianta_bench.data.folders import SLAM_FOLDER, SLAM_RESOLUTION, SLAM_TRUTH, check_set, choose_items, list_maps
from pianta_bench.data.map_sets import RESOLUTION, SETS, SURVEY_LAYOUT

WORLDS = ("home", "office", "ward", "corridor", "l", "ring", "hall")
WORLD_SEEDS = range(5)
# 0 empty … 1 a busy office; half of it, chosen by hand.
WORLD_FURNITURE = 0.5
# 0 clean … 1 a bad map; chosen by hand.
WORLD_NOISE = 0.3


@dataclass(frozen=True)
class LayoutSet:
    """Maps whose scores are averaged together.

    list_items: the names of the maps in the folder of the data; raises DataError without maps.
    read: the map of that folder and name, and its true floor in the map frame.
    """

    name: str
    list_items: Callable[[Path], list[str]]
    read: Callable[[Path, str], tuple[GridMap, Floor]]


def list_schools(data: Path) -> list[str]:
    """Names of the schools."""
    return list_maps(data / SLAM_FOLDER, SLAM_TRUTH)


def read_school_layout(data: Path, name: str) -> tuple[GridMap, Floor]:
    """A school's map, and its layout XML."""
    folder = data / SLAM_FOLDER
    grid = read_map(folder / f"{name}.png", resolution=SLAM_RESOLUTION)
    return grid, read_building_xml(folder / f"{name}{SLAM_TRUTH}", grid=grid)


def list_survey(data: Path) -> list[str]:
    """Names of the survey's maps with a layout."""
    return list_maps(data / "survey", SURVEY_LAYOUT)


def read_survey_layout(data: Path, name: str, *, ending: str) -> tuple[GridMap, Floor]:
    """A map of the survey, and the layout XML that the thesis' author drew of it; its doors are points."""
    folder = data / "survey"
    grid = read_map(folder / f"{name}{ending}", resolution=RESOLUTION)
    return grid, read_building_xml(folder / f"{name}{SURVEY_LAYOUT}", grid=grid)


def list_worlds(_: Path) -> list[str]:
    """Names of the made worlds: the kind and the seed."""
    return [f"{name}_{seed}" for name in WORLDS for seed in WORLD_SEEDS]


def read_world(_: Path, item: str) -> tuple[GridMap, Floor]:
    """A made world, furnished and with noise."""
    name, seed = item.split("_")
    floor, grid = make_synthetic_world(name, seed=int(seed), furniture=WORLD_FURNITURE, noise=WORLD_NOISE)
    return grid, floor


LAYOUT_SETS = {
    layout_set.name: layout_set
    for layout_set in (
        LayoutSet("schools", list_schools, read_school_layout),
        LayoutSet("survey", list_survey, partial(read_survey_layout, ending=".png")),
        LayoutSet("furniture", list_survey, partial(read_survey_layout, ending="_furnitures.png")),
        LayoutSet("worlds", list_worlds, read_world),
    )
}


def choose_maps(
    data: Path, sets: Sequence[str] | None, items: Sequence[str] | None, *, names: Sequence[str], usual: Sequence[str]
) -> list[tuple[str, str]]:
    """The maps to measure, each with the name of its set: of the given sets, else of the usual ones that are there.

    sets: of `names`, which are of SETS or LAYOUT_SETS. items: only maps of these names.
    Raises OptionError for the name of no set or map, DataError when a given set is missing.
    """
    for name in sets or ():
        check_set(name, names)
    chosen = {}
    for name in dict.fromkeys(sets or usual):
        try:
            chosen[name] = (SETS[name] if name in SETS else LAYOUT_SETS[name]).list_items(data)
        except DataError:
            if sets:
                raise
    return choose_items(chosen, items)
