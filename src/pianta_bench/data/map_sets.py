"""The sets of maps with true rooms that segmentation is measured on, each read into one form."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta.errors import DataError
from pianta.evaluation.segmentation import drop_small_rooms
from pianta.gridmap import GridMap
from pianta.io._files import short_repr
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.images import read_grey
from pianta.io.maps import read_map
from pianta_bench.data.building_of import building_of
from pianta_bench.data.color_truth import read_color_truth
from pianta_bench.data.folders import REMEDY, SLAM_FOLDER, SLAM_RESOLUTION, SLAM_TRUTH, check_set, list_maps
from pianta_bench.data.id_truth import read_id_truth
from pianta_bench.data.survey_truth import ROOM_ABOVE_GREY, label_free_rooms, label_patches

RESOLUTION = 0.05  # m per pixel, that of the survey (Bormann et al., ICRA 2016)
SURVEY_LAYOUT = "_layout_gt.xml"  # ending of the layout that the thesis' author drew of a map of the survey
CLOSED = "_[0-9][0-9]_IN.png"  # ending of maps with closed doors, after their number


@dataclass(frozen=True, eq=False)
class TrueMap:
    """A map and its true rooms.

    spaces: shape (H, W), 0 no room, n a true room, with all its pixels.
    rooms: the same for the counts on free cells, where the survey's rooms begin at 1 m².
    free: shape (H, W), the free cells of the map, or of the truth where it is a map itself.
    layout: the file of the layout that the thesis' author drew of the map, where there is one.
    """

    grid: GridMap
    spaces: NDArray[np.int32]
    rooms: NDArray[np.int32]
    free: NDArray[np.bool_]
    layout: Path | None = None


@dataclass(frozen=True)
class MapSet:
    """Maps whose scores are averaged together.

    folder: below the data. ending: follows the name of a map in the file name of its truth.
    read: reads a map by folder and name.
    free_only: truth and result are cut to free cells, because the truth includes walls, or has free cells only.
    in_places: the truth has only some of the rooms.
    grows: each map is a later state of the one before.
    """

    name: str
    folder: str
    ending: str
    read: Callable[[Path, str], TrueMap]
    free_only: bool = False
    in_places: bool = False
    grows: bool = False

    def list_items(self, data: Path) -> list[str]:
        """Names of the maps, sorted; raises DataError without maps."""
        return list_maps(data / self.folder, self.ending)

    def building_of(self, data: Path, item: str) -> str:
        """The building that a map shows."""
        return building_of(data, f"{self.folder}/{item}{self.ending}")


def choose_sets(names: Sequence[str], data: Path) -> dict[MapSet, list[str]]:
    """The named sets with their maps; without names all sets that are in the data.

    Raises OptionError for the name of no set, DataError when a named set, or every set, is missing.
    """
    for name in names:
        check_set(name)
    chosen = {}
    for name in dict.fromkeys(names) or SETS:
        try:
            chosen[SETS[name]] = SETS[name].list_items(data)
        except DataError:
            if names:
                raise
    if not chosen:
        folders = sorted({mapset.folder for mapset in SETS.values()})
        raise DataError(
            f"no data in {short_repr(data)}: none of {', '.join(folders)} has maps with true rooms, {REMEDY}"
        )
    return chosen


def read_survey_map(folder: Path, name: str, *, ending: str) -> TrueMap:
    """A map of the survey; its truth is an image of the empty rooms, with and without furniture, and a layout."""
    grey, _ = read_grey(folder / f"{name}_gt_segmentation.png")
    grid = read_map(folder / f"{name}{ending}", resolution=RESOLUTION)
    layout = folder / f"{name}{SURVEY_LAYOUT}"
    true_rooms = label_patches(grey), label_free_rooms(grey)
    return TrueMap(grid, *true_rooms, grey > ROOM_ABOVE_GREY, layout if layout.exists() else None)


def read_colored_map(folder: Path, name: str) -> TrueMap:
    """A real map whose rooms have been coloured, furniture left out."""
    truth = read_color_truth(folder / f"{name}_gt.png")
    grid = read_map(folder / f"{name}.png", resolution=RESOLUTION)
    return TrueMap(grid, truth, truth, grid.free)


def read_vacuum_map(folder: Path, name: str) -> TrueMap:
    """A home that a vacuum robot mapped; its true rooms are those of the robot, which its owner corrected."""
    truth = read_id_truth(folder / f"{name}_gt.png")
    grid = read_map(folder / f"{name}.yaml")
    return TrueMap(grid, truth, truth, grid.free)


def read_closed_doors(folder: Path, name: str) -> TrueMap:
    """A full map; its true rooms are the spaces behind one closed door each.

    NAME_nn_IN.png is the same map with nn doors closed and the cells behind them unknown. The true rooms are the
    4-connected parts of the free cells that the map with the most closed doors lacks. Most of them are single rooms,
    some may be suites; the rooms behind the open doors are unknown. No resolution is recorded: at 0.05 m per pixel,
    as in the other maps, the buildings are 26 to 75 m wide, about as wide as the schools.
    """
    from scipy.ndimage import label

    grid = read_map(folder / f"{name}_GT.png", resolution=RESOLUTION)
    closed = max(folder.glob(f"{name}{CLOSED}"), default=folder / f"{name}_15_IN.png")
    patches, _ = label(grid.free & ~read_map(closed, resolution=RESOLUTION).free)
    truth = drop_small_rooms(patches, resolution=RESOLUTION)
    return TrueMap(grid, truth, truth, grid.free)


def read_school(folder: Path, name: str) -> TrueMap:
    """A school's map, and the rooms of its layout XML, walls included."""
    grid = read_map(folder / f"{name}.png", resolution=SLAM_RESOLUTION)
    truth = read_building_xml(folder / f"{name}{SLAM_TRUTH}", grid=grid).label_image(grid).astype(np.int32)
    return TrueMap(grid, truth, truth, grid.free)


SETS = {
    mapset.name: mapset
    for mapset in (
        MapSet("survey", "survey", "_gt_segmentation.png", partial(read_survey_map, ending=".png")),
        MapSet("furniture", "survey", "_gt_segmentation.png", partial(read_survey_map, ending="_furnitures.png")),
        MapSet("clutter", "clutter", "_gt.png", read_colored_map, free_only=True),
        MapSet("vacuum", "vacuum", "_gt.png", read_vacuum_map, free_only=True),
        MapSet("doors", "doors", "_GT.png", read_closed_doors, free_only=True, in_places=True),
        MapSet("schools", SLAM_FOLDER, SLAM_TRUTH, read_school, free_only=True),
        MapSet("growing", "partial/freiburg79", "_gt.png", read_colored_map, free_only=True, grows=True),
    )
}
