"""building.json: the storeys of a building, each in a folder of its own, and the stairs and lifts between them."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from pianta.building import Building, Link, Storey
from pianta.errors import FloorError, OptionError
from pianta.floor.area_trust import AreaTrust
from pianta.io._checked import FileFormat, read_checked, save_checked
from pianta.io._faults import validation_as
from pianta.io._files import short_repr
from pianta.io._folders import finish_changes
from pianta.io.floors import read_floor, read_scale_member
from pianta.io.graphs import FLOOR_FILE
from pianta.io.maps import read_npz_map

FORMAT = FileFormat("pianta building", 1, 0)
BUILDING_FILE = "building.json"
# The map in the folder of a floor.
GRID_FILE = "grid.npz"
MAX_FILE_BYTES = 2**20
MAX_STOREYS = 1000  # more than any building has
MAX_TEXT = 200  # characters of a name, and bytes of that of a folder
# The name of a folder beside the file, never a path to elsewhere.
_NAME = re.compile(r"^[^/\\\x00-\x1f.][^/\\\x00-\x1f]*$")


def read_building_folder(path: str | Path) -> Building:
    """Read the building in a folder that `pianta read` has written, or of a floor.geojson.

    Parameters
    ----------
    path
        A folder with a building.json, or of one floor, or the floor.geojson of one.

    Returns
    -------
    Building
        With the maps of its storeys, where they are in their folders.

    Raises
    ------
    PiantaError
        A file is missing or damaged, in one line.
    """
    folder = Path(path)
    finish_changes(folder)
    if (folder / BUILDING_FILE).is_file():
        return read_checked(
            folder / BUILDING_FILE,
            "building",
            FloorError,
            lambda content: _parse_building(content, folder),
            max_bytes=MAX_FILE_BYTES,
        )
    if folder.is_dir() and not (folder / FLOOR_FILE).is_file():
        raise FloorError(f"folder {short_repr(path)} has no {FLOOR_FILE}, give a folder of `pianta read`")
    file = folder / FLOOR_FILE if folder.is_dir() else folder
    floor = read_floor(file)
    return Building((_read_storey(file),), name=Path(floor.source).stem or file.parent.name)


@dataclass(frozen=True)
class StoreyFolders:
    """The storeys of a building.json without their floors.

    titles: what people call each, by its name, the lowest first. links: stairs and lifts.
    """

    titles: Mapping[str, str]
    links: tuple[Link, ...]


def read_storey_folders(folder: Path) -> StoreyFolders | None:
    """The storeys in a folder; None if it has no building.json. Raises FloorError for a damaged one."""
    file = folder / BUILDING_FILE
    if not file.is_file():
        return None
    parsed = read_checked(file, "building", FloorError, _parse_file, max_bytes=MAX_FILE_BYTES)
    return StoreyFolders({each.name: each.title or each.name for each in parsed.storeys}, _list_links(parsed))


def save_building_file(building: Building, path: str | Path) -> None:
    """Write building.json; each storey is in the folder of its name beside it."""
    content = {
        **FORMAT.header,
        "name": building.name,
        "storeys": [{"name": storey.name, "title": storey.title, "elevation": storey.elevation} for storey in building],
        "links": [{"kind": link.kind, "ends": [list(end) for end in link.ends]} for link in building.links],
    }
    save_checked(path, "building", FloorError, lambda: json.dumps(content, indent=1, allow_nan=False).encode() + b"\n")


def check_storey_name(name: str) -> None:
    """Raise OptionError for a name that cannot be that of a folder."""
    if not (_NAME.fullmatch(name) and len(name.encode()) <= MAX_TEXT and name.isprintable()):
        raise OptionError(
            f"storey {short_repr(name)} has no name for a folder, give one of up to {MAX_TEXT} bytes that can be "
            "printed, without / and leading dot"
        )


def _read_storey(file: Path, name: str = "", title: str = "", elevation: float | None = None) -> Storey:
    grid = file.parent / GRID_FILE
    floor, trust = read_floor(file), AreaTrust.from_member(read_scale_member(file))
    return Storey(floor, name, elevation, read_npz_map(grid) if grid.is_file() else None, title, trust)


class _Storey(BaseModel):
    model_config = ConfigDict(frozen=True)

    name: Annotated[str, Field(max_length=MAX_TEXT, pattern=_NAME)]
    title: Annotated[str, Field(max_length=MAX_TEXT)] = ""
    elevation: FiniteFloat | None = None


_End = tuple[str, int]


class _Link(BaseModel):
    model_config = ConfigDict(frozen=True)

    kind: Literal["stairs", "lift"]
    ends: tuple[_End, _End]


class _Building(BaseModel):
    model_config = ConfigDict(frozen=True)

    name: Annotated[str, Field(max_length=MAX_TEXT)] = ""
    storeys: Annotated[list[_Storey], Field(min_length=1, max_length=MAX_STOREYS)]
    links: list[_Link] = []


def _parse_file(content: bytes) -> _Building:
    with validation_as(FloorError):
        FORMAT.check_version(content, FloorError)
        return _Building.model_validate_json(content)


def _list_links(parsed: _Building) -> tuple[Link, ...]:
    return tuple(Link(link.kind, link.ends) for link in parsed.links)


def _parse_building(content: bytes, folder: Path) -> Building:
    parsed = _parse_file(content)
    storeys = tuple(
        _read_storey(folder / each.name / FLOOR_FILE, each.name, each.title, each.elevation) for each in parsed.storeys
    )
    return Building(storeys, parsed.name, _list_links(parsed))
