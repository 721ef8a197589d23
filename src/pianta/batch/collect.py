"""One table of all buildings that were read into a folder: GeoParquet of buildings, rooms and doors."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from types import NoneType

from shapely import unary_union

from pianta._arguments import check_argument
from pianta.batch.geoparquet import TABLES, Row, open_table
from pianta.batch.journal import Entry, read_journals
from pianta.batch.run_batch import is_gone
from pianta.building import Building, Storey
from pianta.errors import OptionError, PiantaError
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_output_folder
from pianta.io.building_folders import read_building_folder
from pianta.reading.reading import may_have_corrections


def collect_batch(folder: str | Path, out: str | Path | None = None) -> dict[str, Path]:
    """Write buildings.parquet, rooms.parquet and doors.parquet of all files that were read into a folder.

    Each storey is a row of buildings; geometries are metres in the frame of its own map, so rooms of two buildings may
    lie over each other. Of a door to no room `other_room` is missing. Buildings with corrections stay in the tables if
    their file has changed and cannot be read.

    Parameters
    ----------
    folder
        That of `read_batch`, with its journals.
    out
        Where the tables are written; None for the same folder.

    Returns
    -------
    dict of Path
        The file of each table.

    Raises
    ------
    OptionError
        There is no journal, or one is in use; geopandas is not installed.
    PiantaError
        The results of a file that was read are missing or damaged.

    Examples
    --------
    >>> import pianta
    >>> pianta.make_world("corridor")[1].save("map.yaml")
    >>> _ = [*pianta.read_batch(["."], out="buildings", labels=False)]
    >>> import geopandas
    >>> len(geopandas.read_parquet(pianta.collect_batch("buildings")["rooms"]))
    19
    """
    check_argument(folder, (str, Path), "folder", "that of `read_batch`")
    check_argument(out, (str, Path, NoneType), "out", "a folder")
    target = Path(folder if out is None else out)
    check_output_folder(target)
    entries = [entry for entry in read_journals(Path(folder)) if _has_results(entry, Path(folder))]
    if not entries:
        raise OptionError(f"the journal of {short_repr(folder)} has no file that was read, so there is no table")
    with atomic_folder(target) as new, ExitStack() as stack:
        writers = {table: stack.enter_context(open_table(table, new / f"{table}.parquet")) for table in TABLES}
        for entry in sorted(entries, key=lambda entry: entry.folder):
            for storey in _read_results(Path(folder), entry):
                writers["buildings"].write([_describe_storey(storey, entry)])
                writers["rooms"].write(_list_rooms(storey, entry))
                writers["doors"].write(_list_doors(storey, entry))
    return {table: target / f"{table}.parquet" for table in TABLES}


def _has_results(entry: Entry, folder: Path) -> bool:
    """Whether an entry has results: not those that a user has removed with their file.

    What people have corrected stays if the file cannot be read again.
    """
    if not entry.is_done:
        return may_have_corrections(folder / entry.folder)
    return (folder / entry.folder).exists() or not is_gone(entry.path)


def _read_results(folder: Path, entry: Entry) -> Building:
    """The building that was read from a file."""
    try:
        return read_building_folder(folder / entry.folder)
    except PiantaError as error:
        raise type(error)(f"{error}; remove it, and `pianta read` reads the file again") from None


def _describe_storey(storey: Storey, entry: Entry) -> Row:
    floor = storey.floor
    types = floor.building_types
    return {
        "building": entry.folder,
        "storey": storey.name,
        "file": entry.path,
        "building_type": types[0] if types else None,
        "probability": floor.building_type[types[0]] if types else None,
        "rooms": len(floor.rooms),
        "doors": len(floor.doors),
        "area": sum(room.polygon.area for room in floor),
        "area_trust": storey.area_trust.name.lower(),
        "seconds": entry.seconds,
        "version": entry.version,
        "geometry": unary_union([room.polygon for room in floor]),
    }


def _list_rooms(storey: Storey, entry: Entry) -> Iterator[Row]:
    for room in storey.floor:
        yield {
            "building": entry.folder,
            "storey": storey.name,
            "id": room.id,
            "number": room.number,
            "name": room.name,
            "label": room.label,
            "label_probability": room.label_probability,
            "area": room.polygon.area,
            "partial": room.partial,
            "probability": room.probability,
            "flag": room.flag,
            "global_id": room.global_id,
            "geometry": room.polygon,
        }


def _list_doors(storey: Storey, entry: Entry) -> Iterator[Row]:
    for door in storey.floor.doors:
        room, other_room = door.rooms
        yield {
            "building": entry.folder,
            "storey": storey.name,
            "room": room,
            "other_room": other_room,
            "width": door.width,
            "kind": door.kind,
            "probability": door.probability,
            "global_id": door.global_id,
            "geometry": door.line,
        }
