"""Files of buildings of every kind, read into floors: the one door for whoever takes buildings."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from pianta.errors import BuildingError, PiantaError
from pianta.floor import Floor
from pianta.io._files import one_line_reason, short_repr
from pianta.io.buildings._kinds import Kind, kind_of_building
from pianta.io.buildings.house_expo import read_house_expo
from pianta.io.buildings.kth_xml import read_kth_xml
from pianta.io.buildings.mit_xml import read_mit_xml
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.floors import read_floor

SUFFIXES = (".xml", ".json", ".geojson")

_READERS: MappingProxyType[Kind, Callable[[str | Path], Floor]] = MappingProxyType(
    {
        Kind.LAYOUT: read_building_xml,
        Kind.KTH: read_kth_xml,
        Kind.MIT: read_mit_xml,
        Kind.HOUSE_EXPO: read_house_expo,
        Kind.FLOOR: read_floor,
    }
)


def read_building(path: str | Path) -> Floor:
    """Read a drawn building: layout XML of the thesis, KTH XML, MIT XML, HouseExpo JSON or floor.geojson.

    Parameters
    ----------
    path
        The file; its content tells the kind.

    Returns
    -------
    Floor
        The floor in metres, y up; which frame, the page on file formats says for each kind.

    Raises
    ------
    BuildingError
        The file is none of these, and the message says what it looks like; or it is damaged.
    FloorError
        A floor.geojson is damaged, or of a newer format.

    Warns
    -----
    BuildingWarning
        Defects of the drawing were repaired.

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
    return _READERS[kind_of_building(path)](path)


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
    """The files of buildings that are meant by files and folders, each once, in the order given.

    A file is taken as it is. A folder stands for its *.xml, *.json and *.geojson, and those of the folders in it,
    sorted; hidden files and folders are passed by, as are JSON files of other content, such as graph.json.
    Raises BuildingError, in one line, for a folder that has none or cannot be listed.
    """
    found: dict[Path, Path] = {}
    for path in map(Path, paths):
        files = list(_list_folder(path)) if path.is_dir() else [path]
        if not files:
            raise BuildingError(f"folder {short_repr(path)} has no building, give one with {', '.join(SUFFIXES)} files")
        for file in files:
            found.setdefault(file.resolve(), file)
    return list(found.values())


def _list_folder(folder: Path) -> Iterator[Path]:
    for name, folders, files in os.walk(folder, onerror=_refuse_folder):
        folders[:] = sorted(inner for inner in folders if not inner.startswith("."))
        for file in sorted(files):
            path = Path(name, file)
            if not file.startswith(".") and path.suffix.lower() in SUFFIXES and not _is_other_json(path):
                yield path


def _refuse_folder(error: OSError) -> None:
    raise BuildingError(f"folder {short_repr(error.filename)} cannot be listed: {one_line_reason(error)}")


def _is_other_json(path: Path) -> bool:
    """Whether a file is called JSON and holds no building; a GeoJSON that is none is worth an error."""
    if path.suffix.lower() != ".json":
        return False
    try:
        kind_of_building(path)
    except BuildingError:
        return True
    return False


def name_sources(files: Sequence[str | Path]) -> list[str]:
    """Names of files, all different: their own; as soon as one repeats, all with as many folders as it takes."""
    parts = [Path(file).absolute().parts for file in files]
    for depth in range(1, max(map(len, parts), default=0) + 1):
        names = [Path(*of_file[-depth:]).as_posix() for of_file in parts]
        if len(set(names)) == len(names):
            return names
    return [str(file) for file in files]
