"""Floors from files of buildings in any format."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from pianta.errors import BuildingError, PiantaError
from pianta.floor import Floor
from pianta.io._files import one_line_reason, real_path, short_repr
from pianta.io.buildings._formats import BuildingFormat, detect_building_format
from pianta.io.buildings.house_expo import read_house_expo
from pianta.io.buildings.kth_xml import read_kth_xml
from pianta.io.buildings.mit_xml import read_mit_xml
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.buildings.valetudo import read_valetudo_floor
from pianta.io.floors import read_floor

SUFFIXES = (".xml", ".json", ".geojson")

_READERS: MappingProxyType[BuildingFormat, Callable[[str | Path], Floor]] = MappingProxyType(
    {
        BuildingFormat.LAYOUT: read_building_xml,
        BuildingFormat.KTH: read_kth_xml,
        BuildingFormat.MIT: read_mit_xml,
        BuildingFormat.HOUSE_EXPO: read_house_expo,
        BuildingFormat.VALETUDO: read_valetudo_floor,
        BuildingFormat.FLOOR: read_floor,
    }
)


def read_building(path: str | Path) -> Floor:
    """Read a drawn building: layout XML of the thesis, KTH XML, MIT XML, HouseExpo JSON, Valetudo or floor.geojson.

    Parameters
    ----------
    path
        The file; its format is detected by its content.

    Returns
    -------
    Floor
        The floor in metres, y up; the page on file formats describes the frame of each format.

    Raises
    ------
    BuildingError
        The file has another format, which the message describes, or is damaged.
    FloorError
        A floor.geojson is damaged, or of a newer format.

    Warns
    -----
    BuildingWarning
        Defects of the drawing were repaired, or rooms without an outline left out.

    References
    ----------
    M. Luperto, PhD thesis, section 4.2.

    Examples
    --------
    >>> import pianta
    >>> pianta.make_world("corridor")[0].save("drawn.geojson")
    >>> floor = pianta.read_building("drawn.geojson")
    >>> len(floor)
    19
    """
    return _READERS[detect_building_format(path)](path)


def read_buildings(
    files: Sequence[str | Path], *, track: Callable[[Sequence[str]], Iterable[str]] = iter
) -> Iterator[tuple[Path, Floor | PiantaError]]:
    """Each file with its floor, or with the error if it cannot be read; the sources of the floors are all different.

    track: wraps the names of the files, to show progress.
    """
    names = [str(file) for file in files]
    for file, source in zip(track(names), name_sources(names), strict=True):
        try:
            yield Path(file), replace(read_building(file), source=source)
        except PiantaError as error:
            yield Path(file), error


def list_buildings(paths: Iterable[str | Path]) -> list[Path]:
    """The files of buildings among files and in folders, each once, in the given order.

    A folder stands for its *.xml, *.json and *.geojson, and those of its subfolders, sorted; hidden files and folders
    are skipped, as are JSON files of other content, such as graph.json.
    Raises BuildingError, in one line, for a folder that has no building or cannot be listed.
    """
    buildings: dict[Path, Path] = {}
    for path in map(Path, paths):
        files = list(_list_folder(path)) if path.is_dir() else [path]
        if not files:
            raise BuildingError(f"folder {short_repr(path)} has no building, give one with {', '.join(SUFFIXES)} files")
        for file in files:
            buildings.setdefault(real_path(file), file)
    return list(buildings.values())


def _list_folder(folder: Path) -> Iterator[Path]:
    """The building files in a folder and its subfolders, without hidden ones; BuildingError if one cannot be listed."""
    for name, folders, files in os.walk(folder, onerror=_refuse_folder):
        folders[:] = sorted(inner for inner in folders if not inner.startswith("."))
        for file in sorted(files):
            path = Path(name, file)
            if not file.startswith(".") and path.suffix.lower() in SUFFIXES and not _is_other_json(path):
                yield path


def _refuse_folder(error: OSError) -> None:
    raise BuildingError(f"folder {short_repr(error.filename)} cannot be listed: {one_line_reason(error)}")


def _is_other_json(path: Path) -> bool:
    """Whether a file has the suffix .json and no building; one with the suffix .geojson is an error instead."""
    if path.suffix.lower() != ".json":
        return False
    try:
        detect_building_format(path)
    except BuildingError:
        return True
    return False


def name_sources(files: Sequence[str | Path]) -> list[str]:
    """Names of files, all different: their own, or if any repeats, all with the fewest parent folders that differ."""
    parts = [Path(file).absolute().parts for file in files]
    for depth in range(1, max(map(len, parts), default=0) + 1):
        names = [Path(*steps[-depth:]).as_posix() for steps in parts]
        if len(set(names)) == len(names):
            return names
    return [str(file) for file in files]
