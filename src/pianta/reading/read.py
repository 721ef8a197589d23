"""Read a map or a plan, or many: the functions behind the verb `pianta read`."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from pianta.errors import OptionError, PiantaError
from pianta.floor import Floor
from pianta.io._files import MAX_CELLS, is_folder, short_repr
from pianta.io._folders import check_output_folder, choose_names
from pianta.io.bags import Message
from pianta.layout.parameters import Parameters
from pianta.layout.reconstruct import DEFAULT_METHOD

if TYPE_CHECKING:
    from pianta.building_types.model import BuildingTypeModel
    from pianta.rooms.model import RoomModel

from pianta.reading._reader import InputKind, Reader, ReadOptions
from pianta.reading.reading import Reading, check_corrections, check_output

MAX_JOBS = 256


@dataclass(frozen=True)
class Failure:
    """A file that `read_all` could not read, and why.

    Attributes
    ----------
    path
        The file.
    error
        What `read` would raise; its message is one line.
    """

    path: Path
    error: PiantaError


def read(
    path: str | Path,
    *,
    input_kind: InputKind | None = None,
    resolution: float | None = None,
    trust_thresholds: bool = False,
    topic: str | None = None,
    message: Message = "last",
    max_cells: int = MAX_CELLS,
    page: int | None = None,
    symbols: str | Path | None = None,
    wall_layers: Sequence[str] = (),
    door_layers: Sequence[str] = (),
    room_layers: Sequence[str] = (),
    words: str | Path | None = None,
    method: str = DEFAULT_METHOD,
    parameters: Parameters | None = None,
    as_printed: bool = False,
    predict_partial: bool = True,
    building_type: str | None = None,
    room_model: RoomModel | str | Path | None = None,
    building_model: BuildingTypeModel | str | Path | None = None,
    labels: bool = True,
    label_unknown: bool = False,
    previous: Floor | str | Path | None = None,
    earlier: Sequence[Floor | str | Path] = (),
) -> Reading:
    """Read a robot's map or a plan into a building: its rooms, doors and walls, labels, names and type.

    The command `pianta read` calls this function.

    Parameters
    ----------
    path
        A map, as of `read_map`; a plan as image, DXF, SVG, PDF, IFC or .sh3d.
    input_kind
        "map" or "plan"; None to detect it.
    resolution
        Metres per cell of an image without a map.yaml, per pixel of a plan, or per unit of a DXF or SVG. None to use
        the file's own, or to detect it in the plan.
    trust_thresholds
        Keep greys of unknown free or occupied where the thresholds of a map.yaml make them so: 205, which map savers
        write, or another middle grey that fills the edge of the map.
    topic
        The topic of a bag; None for the only one with maps.
    message
        The number of the map in a bag, from 1, or "last"; `read_series` reads them all.
    max_cells
        The largest map or picture that is read, in cells or pixels.
    page
        The page of a PDF, from 1.
    symbols
        Folder with PNGs of symbols of plans, besides our own; door*.png are doors.
    wall_layers, door_layers, room_layers
        The layers of a DXF on which walls, doors and the outlines of rooms are drawn, in any case, with * for any
        letters; empty to find them.
    words
        JSON file with words in names of rooms, besides our own.
    method
        How rooms are found, one of `METHODS`.
    parameters
        The thresholds of the method; None for those that fit most buildings. Not for plans.
    as_printed
        True for the method "thesis" as the thesis prints it, without our departures. Not for plans.
    predict_partial
        False to leave out the predicted shapes of rooms that were seen in part, which is faster. Not for plans.
    building_type
        The type of the building, such as "school" or "office"; None if unknown. Rooms get the labels of this type.
    room_model, building_model
        Models of `train_rooms` and `train_building_types`, or their files; None for those that come with pianta.
    labels
        False to leave out labels and the building's type.
    label_unknown
        Whether rooms keep all labels if the building is unlike every type that the model knows. Otherwise they are
        ROOM or CORRIDOR then, where that is certain, unless their names say more.
    previous
        An older floor of this building, its floor.geojson, or the folder that holds one. Rooms keep their ids, and
        labels and a type from a user stay. The map may have grown, and its origin may have moved.
    earlier
        Floors before the previous one, the newest first: a room that `previous` cuts differently gets back its id.

    Returns
    -------
    Reading
        `reading.floor` is the floor; `reading.save(folder)` writes what the command writes.

    Raises
    ------
    MapError, PlanError
        The file cannot be read, or shows no room.
    OptionError
        An option has an impossible value, or contradicts another one.
    ModelError, FloorError, LabelError
        A model, the previous floor, or the building's type cannot be used.

    Warns
    -----
    MapWarning, PlanWarning
        The file was read, but something in it is suspicious.

    References
    ----------
    M. Luperto, PhD thesis, chapters 3 (layout), 4 and 5 (labels) and 6 (types).

    Examples
    --------
    >>> import pianta
    >>> pianta.make_world("corridor")[1].save("map.yaml")
    >>> reading = pianta.read("map.yaml")
    >>> len(reading.floor), reading.floor[9].labels["R/C"]
    (19, 'CORRIDOR')
    >>> ax = reading.plot()
    """
    reader = Reader.make(
        input_kind=input_kind,
        resolution=resolution,
        trust_thresholds=trust_thresholds,
        topic=topic,
        message=message,
        max_cells=max_cells,
        page=page,
        symbols=symbols,
        wall_layers=wall_layers,
        door_layers=door_layers,
        room_layers=room_layers,
        words=words,
        method=method,
        parameters=parameters,
        as_printed=as_printed,
        predict_partial=predict_partial,
        building_type=building_type,
        room_model=room_model,
        building_model=building_model,
        labels=labels,
        label_unknown=label_unknown,
        previous=previous,
        earlier=earlier,
    )
    return reader.read(path)


def read_all(
    paths: Iterable[str | Path],
    *,
    out: str | Path | None = None,
    names: Sequence[str] | None = None,
    walls: bool = False,
    graph: bool = False,
    jobs: int = 1,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[ReadOptions],
) -> Iterator[Reading | Failure]:
    """Read several files one by one; one that cannot be read does not stop the others.

    Parameters
    ----------
    paths
        The files, as of `read`.
    out
        Folder in which each file gets a folder of its own for its results, as of `Reading.save`; None to write
        nothing. A folder has the stem of its file, with the name of the file's folder where stems repeat.
    names
        The names of these folders, all different; None for those.
    walls, graph
        As of `Reading.save`.
    jobs
        Processes; the results are the same, and in the same order, for any number of them.
    progress
        Called with the number of files that are done and of all, at the start and after each file.
    **options
        As of `read`; a previous floor only for a single file.

    Returns
    -------
    iterator of Reading or Failure
        In the order of the paths; each file is read when its result is asked for.

    Raises
    ------
    OptionError, ModelError, FloorError, LabelError
        As of `read`, before the first file is read; or `jobs` is out of range, or `paths` is a single path.

    Warns
    -----
    MapWarning, PlanWarning
        As of `read`, for each file, whatever the number of processes.

    Examples
    --------
    >>> import pianta
    >>> for result in pianta.read_all(["nowhere.yaml"]):
    ...     if isinstance(result, pianta.Failure):
    ...         print(result.error)
    map 'nowhere.yaml' does not exist, check the path
    """
    if isinstance(paths, str | Path):
        raise OptionError(f"paths is {short_repr(paths)}, give a list of files, or use read for one")
    files = list(paths)
    if options.get("previous") is not None and len(files) > 1:
        raise OptionError(f"previous= is one floor and {len(files)} files are given, read each file on its own")
    if not 1 <= jobs <= MAX_JOBS:
        raise OptionError(f"jobs is {jobs}, give 1 to {MAX_JOBS}")
    if out is not None:
        check_output_folder(Path(out))
    reader = Reader.make(**options)
    folders = [None] * len(files) if out is None else [Path(out) / name for name in names or name_folders(files)]
    tasks = [_Task(reader, file, folder, walls, graph) for file, folder in zip(files, folders, strict=True)]
    return _run(tasks, jobs, progress)


def name_folders(paths: Sequence[str | Path]) -> list[str]:
    """A folder name for each file, all different: its stem; where stems repeat its folder and stem; then a number.

    A folder has no stem: its name may have dots.
    """
    files = [Path(path).absolute() for path in paths]
    # A file can be called "...yaml", and its stem is the parent folder.
    stems = [(file.name if is_folder(file) else file.stem).lstrip(".") or "map" for file in files]
    with_folders = [f"{file.parent.name}-{stem}".lstrip("-.") for file, stem in zip(files, stems, strict=True)]
    return choose_names(stems, with_folders)


@dataclass(frozen=True)
class _Task:
    """A file of `read_all`, and the folder for its results; None to write none."""

    reader: Reader
    path: str | Path
    folder: Path | None
    walls: bool
    graph: bool

    def run(self) -> Reading | Failure:
        """Read the file and write the results, if there is a folder; a PiantaError becomes a Failure."""
        try:
            if self.folder is None:
                return self.reader.read(self.path)
            check_output(self.path, self.folder)
            check_corrections(self.folder, self.reader.options.get("previous"))
            reading = self.reader.read(self.path)
            reading.save(self.folder, walls=self.walls, graph=self.graph)
        except PiantaError as error:
            return Failure(Path(self.path), error)
        return replace(reading, folder=self.folder)

    def run_with_warnings(self) -> tuple[Reading | Failure, list[Warning]]:
        """The result and the warnings, which this process must not print itself."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            result = self.run()
        return result, [each.message for each in caught if isinstance(each.message, Warning)]


def _run(tasks: Sequence[_Task], jobs: int, progress: Callable[[int, int], None] | None) -> Iterator[Reading | Failure]:
    report = progress or (lambda _done, _all: None)
    report(0, len(tasks))
    for done, result in enumerate(_run_in_processes(tasks, jobs) if jobs > 1 else map(_Task.run, tasks), start=1):
        report(done, len(tasks))
        yield result


def _run_in_processes(tasks: Sequence[_Task], jobs: int) -> Iterator[Reading | Failure]:
    """The results of tasks in their order, from `jobs` processes; their warnings are issued in this process."""
    from joblib import Parallel, delayed

    run = delayed(_Task.run_with_warnings)
    for result, caught in Parallel(n_jobs=jobs, return_as="generator")(run(task) for task in tasks):
        for warning in caught:
            warnings.warn(warning, stacklevel=3)
        yield result
