"""A growing map: all maps of a bag, each read with the rooms of the one before."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from pianta.errors import MapError, OptionError, PiantaError
from pianta.io._files import MAX_CELLS, short_repr
from pianta.io._folders import check_output_folder
from pianta.io.bags import is_bag, iterate_bag
from pianta.reading._reader import Reader, ReadOptions
from pianta.reading.growing_map import GrowingMap
from pianta.reading.read import Failure
from pianta.reading.reading import Reading, check_corrections

MIN_DIGITS = 3  # of the number of a folder


def read_series(
    path: str | Path,
    *,
    out: str | Path | None = None,
    walls: bool = False,
    graph: bool = False,
    **options: Unpack[ReadOptions],
) -> Iterator[Reading | Failure]:
    """Read all maps of a bag, one after another, as the map of a building that grows.

    Rooms keep their ids from map to map. A `Mapper` reads what has changed on each map, and carries its beliefs about
    labels and the type on, unless an option is given that it does not have (`method`, `parameters`, `as_printed`,
    `words`, `building_model`, `label_unknown`, `earlier`), or people have named rooms of the previous floor: then each
    map is read as a whole. A map that is equal to the one before is left out.

    Parameters
    ----------
    path
        A rosbag, as of `read_map`.
    out
        Folder in which each map gets a folder of its own, 001, 002, …, for its results; None to write nothing.
    walls, graph
        As of `Reading.save`.
    **options
        As of `read`, without `message`.

    Returns
    -------
    iterator of Reading or Failure
        In the order of the maps; each is read when its result is asked for. A map without rooms, such as the first of
        a robot that has just started, is a Failure.

    Raises
    ------
    MapError
        The file is no bag, or damaged.
    OptionError, ModelError, FloorError, LabelError
        As of `read`.

    Examples
    --------
    >>> import pianta
    >>> for reading in pianta.read_series("run.bag", out="series"):  # doctest: +SKIP
    ...     print(reading.folder, len(reading.floor))
    """
    if "message" in options:
        raise OptionError("message= is for one map of a bag, leave it out to read them all")
    if not is_bag(path):
        raise MapError(f"map {short_repr(path)} is no bag, and has no series of maps; give a .bag, .mcap or .db3")
    if out is not None:
        check_output_folder(Path(out))
    reader = Reader.make(**options)
    return _read_maps(reader, Path(path), None if out is None else Path(out), walls=walls, graph=graph)


def _read_maps(
    reader: Reader, path: Path, out: Path | None, *, walls: bool, graph: bool
) -> Iterator[Reading | Failure]:
    limit = reader.options.get("max_cells", MAX_CELLS)
    growing = GrowingMap(reader)
    grids = iterate_bag(path, topic=reader.options.get("topic"), max_cells=limit)
    for number, grid in enumerate(grids, start=1):
        folder = None if out is None else out / f"{number:0{MIN_DIGITS}}"
        if isinstance(grid, MapError):
            yield Failure(path, grid)
            continue
        try:
            if folder is not None:
                check_corrections(folder)
            reading = growing.read(grid, path)
            if folder is not None:
                reading.save(folder, walls=walls, graph=graph)
        except PiantaError as error:
            yield Failure(path, type(error)(f"map {number} of {short_repr(path)}: {error}"))
            continue
        yield replace(reading, folder=folder)
