"""Robots' maps of buildings whose type is known by their names or by what their owners say."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from pianta.building_types.map_types import OTHER
from pianta.errors import DataError
from pianta.gridmap import GridMap
from pianta.io._files import short_repr
from pianta.io.maps import read_map
from pianta_bench.data.building_of import building_of
from pianta_bench.data.folders import REMEDY, SLAM_FOLDER, SLAM_RESOLUTION, SLAM_TRUTH, list_maps
from pianta_bench.data.map_sets import RESOLUTION

SCHOOL = "school"
# Offices, laboratories and institutes.
OFFICE = "office"
# Sets of maps: name, folder, ending of the truths and of the maps, resolution, and building type.
SETS_WITH_TRUTH = (
    ("schools", SLAM_FOLDER, SLAM_TRUTH, ".png", SLAM_RESOLUTION, SCHOOL),
    ("survey", "survey", "_gt_segmentation.png", ".png", RESOLUTION, OFFICE),
    ("furniture", "survey", "_gt_segmentation.png", "_furnitures.png", RESOLUTION, OFFICE),
    ("kth", "kth", "_rooms.png", ".png", RESOLUTION, OFFICE),
    ("vacuum", "vacuum", "_gt.png", ".yaml", None, OTHER),
)
# Maps of data/clutter by the type of their building, which is not known of the others.
CLUTTER: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        OFFICE: (
            *("freiburg79_map15", "freiburg79_map15_raw", "freiburg_building79", "freiburg_building101"),
            *("umicfirstfloor_photo20200108", "umicfirstfloororiginal"),
        ),
        OTHER: (
            *("aafdeployment16cropped", "benedetti", "bertolani", "casamatteo", "delcegno", "simonahouse"),
            *("vimantichouse20", "vimantichouse23", "vimantichouse30", "vottero"),
        ),
    }
)
# Schools whose names differ by one number only. The data give each a building of its own, and their drawings differ;
# models of the types of maps keep them together for caution.
SAME_BUILDING: Mapping[str, str] = MappingProxyType({"school/scuolasconosciuta2": "school/scuolasconosciuta"})
# Maps of data/robotmaps that are of offices and laboratories; the others are homes, care homes and warehouses.
ROBOTMAPS_OFFICES = ("jsk_eng6-3f", "josefgst_rosmap12", "urjc_lab")


@dataclass(frozen=True)
class TypedMap:
    """A map of a building of a type.

    part: the set of maps. resolution: metres per cell, None if the file says it. building_type: OTHER for one that is
    neither a school nor an office. building: as of read_annotated_floors.
    """

    part: str
    item: str
    file: Path
    resolution: float | None
    building_type: str
    building: str

    def read(self) -> GridMap:
        """The map; raises MapError."""
        return read_map(self.file) if self.resolution is None else read_map(self.file, resolution=self.resolution)


def name_training_building(building: str) -> str:
    """The building, as of read_annotated_floors, with which one is left out of models of the types of maps.

    Examples
    --------
    >>> name_training_building("school/scuolasconosciuta2"), name_training_building("school/plans")
    ('school/scuolasconosciuta', 'school/plans')
    """
    return SAME_BUILDING.get(building, building)


def list_typed_maps(data: Path) -> list[TypedMap]:
    """All maps of the sets that are in the data; raises DataError without maps."""
    typed_maps = []
    for part, item, path, resolution, building_type in _list_files(data):
        building = f"{building_type}/{building_of(data, path)}"
        typed_maps.append(TypedMap(part, item, data / path, resolution, building_type, building))
    if not typed_maps:
        raise DataError(f"no maps of buildings of a known type in {short_repr(data)}, {REMEDY}")
    return typed_maps


def _list_files(data: Path) -> Iterator[tuple[str, str, str, float | None, str]]:
    """Part, item, path in the data, resolution and building type of each map."""
    for part, folder, truth, ending, resolution, building_type in SETS_WITH_TRUTH:
        for item in _list_items(data / folder, truth):
            yield part, item, f"{folder}/{item}{ending}", resolution, building_type
    yield from _list_clutter(data)
    for file in sorted((data / "robotmaps").glob("*/*.yaml")):
        building_type = OFFICE if file.stem in ROBOTMAPS_OFFICES else OTHER
        yield "robotmaps", file.stem, file.relative_to(data).as_posix(), None, building_type


def _list_clutter(data: Path) -> Iterator[tuple[str, str, str, float | None, str]]:
    """The maps of data/clutter, by their map.yaml where there is one."""
    for building_type, items in CLUTTER.items():
        for item in items:
            path = f"clutter/{item}.yaml"
            if (data / path).is_file():
                yield "clutter", item, path, None, building_type
            elif (data / f"clutter/{item}.png").is_file():
                yield "clutter", item, f"clutter/{item}.png", RESOLUTION, building_type


def _list_items(folder: Path, ending: str) -> list[str]:
    """The maps of a folder; none if the folder is not in the data."""
    try:
        return list_maps(folder, ending)
    except DataError:
        return []
