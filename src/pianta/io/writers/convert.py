"""Write a floor or a building in a format of other programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Protocol, TypedDict

from pianta.building import Building, Storey
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.floor.area_trust import AreaTrust
from pianta.floor.straight import straighten_floor
from pianta.gridmap import GridMap
from pianta.io._files import atomic_file, count_noun, short_repr
from pianta.io._folders import atomic_folder
from pianta.io.building_folders import read_building_folder
from pianta.io.georeference import Georeference, read_georeference
from pianta.io.writers._formats import FORMATS, SPEED, Format, WriteOptions
from pianta.io.writers.writable_parts import keep_writable
from pianta.navigation.robot import ROBOT_RADIUS

# Of robots, metres; the paths of smaller ones would have more points than memory holds.
MIN_RADIUS = 0.01
MAX_RADIUS = 10.0


class HasBuilding(Protocol):
    """A reading of `pianta.read`, whose storeys are a building."""

    @property
    def building(self) -> Building:
        """The storeys with their maps, and the stairs and lifts that join them."""


class ConvertOptions(TypedDict, total=False):
    """The options of `convert` beside the format."""

    robot_radius: float
    rooms: Sequence[str]
    speed: float
    straight: bool
    georeference: Georeference | str | Path | None
    robot_map: str | Path | None


def convert(
    source: Building | Floor | HasBuilding | str | Path,
    path: str | Path,
    *,
    to: str | None = None,
    grid: GridMap | None = None,
    robot_radius: float = ROBOT_RADIUS,
    rooms: Sequence[str] = (),
    speed: float = SPEED,
    straight: bool = False,
    georeference: Georeference | str | Path | None = None,
    robot_map: str | Path | None = None,
) -> list[str]:
    """Write a floor or a building in a format of other programs.

    Parameters
    ----------
    source
        A building, a floor, what `pianta.read` gives, or a folder that `pianta read` has written.
    path
        The file or the folder to write; older ones are replaced, all files or none.
    to
        The format, one of those that `pianta convert --help` lists; if None, the one format whose files have the suffix
        of the path.
    grid
        The map of a floor, which formats for robots need; a folder has it.
    robot_radius
        Of the robot, metres, for routes, waypoints and cleaning.
    rooms
        The rooms of a mask, by ids, names or labels; all if empty.
    speed
        Of a speed mask, percent.
    straight
        Whether outlines get right angles where the building has them.
    georeference
        From the map frame to the earth, or its file: control points or an anchor.
    robot_map
        Valetudo's map JSON of the robot, whose segment ids rooms get.

    Returns
    -------
    list of str
        What the format cannot hold and what was changed for it, a line each.

    Raises
    ------
    OptionError
        There is no such format, several have the suffix, it has not these options, or a package is not installed.
    PiantaError
        The source cannot be read, does not have what the format needs, or a file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> import pianta
    >>> floor, _ = pianta.make_world("corridor")
    >>> pianta.convert(floor, "rooms.csv")
    []
    >>> Path("rooms.csv").read_text(encoding="utf-8")[:21]
    'storey,id,number,name'
    """
    if to is None:
        to = find_format_name(Path(path))
    chosen = find_format(to)
    options = WriteOptions(
        robot_radius=robot_radius,
        rooms=tuple(rooms),
        speed=speed,
        straight=straight,
        georeference=read_georeference(georeference) if isinstance(georeference, str | Path) else georeference,
        robot_map=None if robot_map is None else Path(robot_map),
    )
    check_options(to, options)
    building, notes = keep_writable(_make_building(source, grid))
    if options.straight:
        building, notes_of_straight = straighten_building(building)
        notes += notes_of_straight
    without = [storey.name or storey.floor.source for storey in building if storey.grid is None]
    if chosen.needs_map and without:
        raise OptionError(
            f"format {to} needs the map, which {', '.join(map(short_repr, without))} is without; read it again"
        )
    writer = chosen.find_writer()
    target = Path(path)
    with atomic_folder(target) if chosen.is_folder else atomic_file(target) as temporary:
        return notes + writer(building, temporary, options) + describe_trust(building)


def describe_trust(building: Building) -> list[str]:
    """That the scale of a plan is doubtful, and so are the areas in the file; a line for each reason."""
    doubtful: dict[AreaTrust, list[str]] = {}
    for storey in building:
        if storey.area_trust is not AreaTrust.EXACT:
            doubtful.setdefault(storey.area_trust, []).append(storey.name)
    return [
        (f"storeys {', '.join(map(short_repr, names))}: " if len(building) > 1 else "") + trust.warning
        for trust, names in doubtful.items()
    ]


def straighten_building(building: Building) -> tuple[Building, list[str]]:
    """The building with right angles, and a note on the rooms that have none."""
    straight = [straighten_floor(storey.floor) for storey in building]
    storeys = tuple(replace(storey, floor=each.floor) for storey, each in zip(building, straight, strict=True))
    unchanged = sum(len(each.unchanged) for each in straight)
    rooms = count_noun(sum(len(storey.floor) for storey in building), "room")
    notes = [f"{unchanged} of {rooms} have no right angles and are as they were"] if unchanged else []
    return replace(building, storeys=storeys), notes


def find_format_name(path: Path) -> str:
    """The only format whose files have the suffix of a path; raises OptionError unless there is just one."""
    suffix = path.suffix.lower()
    names = [name for name, each in FORMATS.items() if suffix and Path(each.file).suffix == suffix]
    if len(names) != 1:
        choice = ", ".join(names or FORMATS)
        raise OptionError(f"output {short_repr(path.name)} does not show the format, give one of {choice}")
    return names[0]


def find_format(name: str) -> Format:
    """The format of a name; raises OptionError for another name."""
    if name not in FORMATS:
        raise OptionError(f"format is {short_repr(name)}, give one of {', '.join(FORMATS)}")
    return FORMATS[name]


def check_options(name: str, options: WriteOptions) -> None:
    """Raise OptionError for options that a format does not have, and for values out of range."""
    surplus = sorted({*options.list_changed()} - find_format(name).options)
    if surplus:
        raise OptionError(f"format {name} takes no {' and no '.join(surplus)}, leave it out")
    if find_format(name).needs_georeference and options.georeference is None:
        raise OptionError(f"format {name} needs longitudes and latitudes, give georeference=")
    if not MIN_RADIUS <= options.robot_radius < MAX_RADIUS:
        raise OptionError(
            f"robot_radius is {options.robot_radius}, give metres from {MIN_RADIUS} to below {MAX_RADIUS}"
        )
    if not 0 < options.speed <= 100:
        raise OptionError(f"speed is {options.speed}, give a percentage up to 100")


def _make_building(source: Building | Floor | HasBuilding | str | Path, grid: GridMap | None) -> Building:
    if isinstance(source, Building):
        return source
    if isinstance(source, Floor):
        return Building((Storey(source, grid=grid),), Path(source.source).stem)
    if isinstance(source, str | Path):
        return read_building_folder(source)
    return source.building
