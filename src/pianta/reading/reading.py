"""Reading: the building of a map or a plan, and the files that it is saved in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pianta.building import Building, Storey
from pianta.corrections.corrections_file import FILE_NAME, read_corrections, save_corrections
from pianta.corrections.kinds import Correction
from pianta.errors import FloorError, OptionError, PiantaError
from pianta.floor import Floor
from pianta.floor.area_trust import AreaTrust
from pianta.gridmap import GridMap
from pianta.io._files import count_noun, find_output_fault, real_path, short_repr
from pianta.io._folders import atomic_folder, check_output_file, only_writer
from pianta.io.building_folders import BUILDING_FILE, read_storey_folders, save_building_file
from pianta.labels import LabelSchema
from pianta.reading.storeys import make_building

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pianta.io.writers.convert import ConvertOptions
    from pianta.layout.explanation import Explanation
    from pianta.plan.sheets.sheet import PlanScale


OUTPUTS = ("floor.geojson", "rooms.png", "graph.json", "picture.png", "grid.npz")
# The sheet of a plan, on the cells of the grid, beside them.
PAPER = "paper.png"
# The floor as it was read, if it has corrections.
UNCORRECTED = "uncorrected.geojson"
# The picture of an explanation, beside them.
EXPLANATION = "explain.png"
# Results that not every reading has; building.json is of several storeys.
OPTIONAL = (PAPER, UNCORRECTED, EXPLANATION, BUILDING_FILE)


@dataclass(frozen=True, eq=False)
class StoreyReading:
    """One storey of a building.

    Attributes
    ----------
    floor
        Its rooms, doors and walls, with labels and the type of the building.
    grid
        The map; for a plan the frame of the sheet, its cells unknown.
    name
        "" if the file has one storey, else "floor-1", "floor-2", …, the largest first.
    scale
        Metres per pixel of a plan, and their evidence; None for a map.
    paper
        The sheet of a plan, RGB of shape (H, W, 3) on the cells of the grid; None for a map, and for an IFC.
    candidate_types
        The building types among which the model chose the floor's; empty if a user has given the type.
    messages
        Notes for the user, a line each.
    uncorrected
        The floor without the corrections of the previous one; None if that has none.
    corrections
        The corrections of the previous floor, in the frame of this one.
    title
        What the file calls the storey; "" if it does not name it.
    elevation
        Height of its floor, metres; None if the file does not give it.
    previous_corrections
        The same as they were read; `Reading.save` refuses a folder that has others by then.
    uncorrected_scale
        The scale without the corrections; None for a map, and without corrections.
    """

    floor: Floor
    grid: GridMap
    name: str = ""
    scale: PlanScale | None = None
    paper: NDArray[np.uint8] | None = None
    candidate_types: tuple[str, ...] = ()
    messages: tuple[str, ...] = ()
    uncorrected: Floor | None = None
    corrections: tuple[Correction, ...] = ()
    title: str = ""
    elevation: float | None = None
    previous_corrections: tuple[Correction, ...] = ()
    uncorrected_scale: PlanScale | None = None

    @property
    def area_trust(self) -> AreaTrust:
        """Whether the scale is certain enough for areas; exact for a map."""
        return find_area_trust(self.scale)


@dataclass(frozen=True, eq=False)
class Reading:
    """The building that `read` has reconstructed from a file.

    `floor`, `grid`, `scale` and `messages` are those of the first storey, the only one of a map and of most plans.

    Attributes
    ----------
    path
        The file.
    storeys
        The storeys, the largest first.
    schemas
        Building type -> schema of its room labels.
    folder
        Where `read_all` wrote the results; None if it did not.

    Examples
    --------
    >>> import pianta
    >>> pianta.make_world("corridor")[1].save("map.yaml")
    >>> reading = pianta.read("map.yaml", labels=False)
    >>> [folder.name for folder in reading.save("building")]
    ['building']
    >>> pianta.read_floor("building/floor.geojson") == reading.floor
    True
    """

    path: Path
    storeys: tuple[StoreyReading, ...]
    schemas: Mapping[str, LabelSchema]
    folder: Path | None = None

    def __repr__(self) -> str:
        """The file and its floors."""
        return f"<Reading {str(self.path)!r}: {', '.join(map(repr, self.floors))}>"

    @property
    def floor(self) -> Floor:
        """The floor; the largest if there are several."""
        return self.storeys[0].floor

    @property
    def floors(self) -> tuple[Floor, ...]:
        """All floors, the largest first."""
        return tuple(storey.floor for storey in self.storeys)

    @property
    def building(self) -> Building:
        """The storeys with their maps, the lowest first, and the stairs and lifts that join them."""
        # Floors of a sheet lie beside each other, and those of an IFC or .sh3d above each other
        storeys = [
            Storey(each.floor, each.name, each.elevation, each.grid, each.title, each.area_trust)
            for each in self.storeys
        ]
        return make_building(storeys, self.path.stem, one_frame=self.path.suffix.lower() in {".ifc", ".sh3d"})

    @property
    def grid(self) -> GridMap:
        """The map; for a plan the frame of the sheet, its cells unknown."""
        return self.storeys[0].grid

    @property
    def scale(self) -> PlanScale | None:
        """Metres per pixel of a plan, and their evidence; None for a map."""
        return self.storeys[0].scale

    @property
    def messages(self) -> tuple[str, ...]:
        """Notes for the user, a line each."""
        return self.storeys[0].messages

    def plot(self, *, ax: Axes | None = None, walls: bool = False, graph: bool = False) -> Axes:
        """Draw the floor on its map, in metres of the map frame.

        Parameters
        ----------
        ax
            Where to draw; a new figure if None.
        walls, graph
            Whether to draw the wall lines and the topological graph too.

        Returns
        -------
        Axes
            The ax that was drawn on; nothing is shown.
        """
        from pianta.plot.floor import plot_floor

        first = self.storeys[0]
        return plot_floor(
            first.floor, first.grid, ax=ax, walls=walls, graph=graph, schemas=self.schemas, paper=first.paper
        )

    def _repr_png_(self) -> bytes:
        """The floor on its map as a notebook shows it."""
        from pianta.plot.figure import encode_png
        from pianta.plot.floor import draw_floor

        first = self.storeys[0]
        picture = draw_floor(
            first.floor, first.grid, schemas=self.schemas, paper=first.paper, area_trust=first.area_trust
        )
        return encode_png(picture)

    def save(self, folder: str | Path, *, walls: bool = False, graph: bool = False) -> list[Path]:
        """Write floor.geojson, rooms.png, graph.json and picture.png; several storeys in folders, and building.json.

        Parameters
        ----------
        folder
            Made if it does not exist; older results in it are replaced, all or none.
        walls, graph
            Whether picture.png shows the wall lines and the topological graph.

        Returns
        -------
        list of Path
            The folder of each storey.

        Raises
        ------
        PiantaError
            A file cannot be written, or would replace the file that was read.
        """
        check_output(self.path, folder)
        folders = [Path(folder) / storey.name for storey in self.storeys]
        _refuse_folders_as_results(folders)
        emptied = _list_others(Path(folder), folders)
        with ExitStack() as together:
            together.callback(_remove_empty, emptied)
            for target in emptied:
                check_corrections(target)
            for storey, target in zip(self.storeys, folders, strict=True):
                if target.is_dir():
                    together.enter_context(only_writer(target))
                if storey.uncorrected is None:
                    check_corrections(target)
                else:
                    _check_corrections_stayed(target, storey.previous_corrections)
            for storey, target in zip(self.storeys, folders, strict=True):
                new = together.enter_context(atomic_folder(target, optional=OPTIONAL))
                self._write(storey, new, walls=walls, graph=graph)
            for target in emptied:
                # Without a floor, files of these names may be a user's own
                older = (*OUTPUTS, *OPTIONAL, FILE_NAME) if (target / OUTPUTS[0]).is_file() else ()
                new = together.enter_context(atomic_folder(target, optional=older))
                if len(self.storeys) > 1 and target == Path(folder):
                    save_building_file(self.building, new / BUILDING_FILE)
        return folders

    def to_file(self, path: str | Path, *, to: str | None = None, **options: Unpack[ConvertOptions]) -> list[str]:
        """Write the building in a format of other programs; see `pianta.convert`.

        Parameters
        ----------
        path
            The file or the folder to write; older ones are replaced, all files or none.
        to
            The format; if None, the one format whose files have the suffix of the path.
        **options
            Those of `pianta.convert`: robot_radius, rooms, speed, straight, georeference, robot_map.

        Returns
        -------
        list of str
            What the format cannot hold and what was changed for it, a line each.

        Raises
        ------
        PiantaError
            As `pianta.convert`.

        Examples
        --------
        >>> import pianta
        >>> pianta.make_world("corridor")[1].save("map.yaml")
        >>> pianta.read("map.yaml", labels=False).to_file("rooms.csv")
        []
        """
        from pianta.io.writers.convert import convert

        return convert(self, path, to=to, **options)

    def clean_map(self) -> GridMap:
        """Make the map without furniture, spray and people; see `pianta.clean_map`.

        Returns
        -------
        GridMap
            The clean map, in the frame of the map that was read.

        Raises
        ------
        OptionError
            The file is a plan, which has no map.
        """
        from pianta.layout.clean_map import clean_map

        if self.scale is not None:
            raise OptionError(f"plan {short_repr(self.path)} has no map to clean, give a robot's map")
        return clean_map(self.grid, self.floor)

    def explain(self) -> Explanation:
        """Explain the floor, if the method `structure` has found it; see `pianta.explain`.

        Returns
        -------
        Explanation
            The borders between rooms that were considered, with the ids of this floor.

        Raises
        ------
        OptionError
            The file is a plan, whose rooms were drawn and not found.
        """
        from pianta.layout.explanation import explain

        if self.scale is not None:
            raise OptionError(f"plan {short_repr(self.path)} was not divided by pianta, give a robot's map")
        return explain(self.grid, self.floor)

    def _write(self, storey: StoreyReading, folder: Path, *, walls: bool, graph: bool) -> None:
        """Write the result files of a storey; walls, graph: whether picture.png shows them."""
        from pianta.io.floors import save_floor

        storey.grid.save(folder / OUTPUTS[-1])
        if storey.paper is not None:
            Image.fromarray(storey.paper).save(folder / PAPER)
        write_floor(
            storey.floor,
            storey.grid,
            folder,
            self.schemas,
            paper=storey.paper,
            scale=storey.scale,
            walls=walls,
            graph=graph,
        )
        if storey.uncorrected is not None:
            scale = storey.uncorrected_scale
            save_floor(storey.uncorrected, folder / UNCORRECTED, scale=None if scale is None else scale.as_json())
            save_corrections(storey.corrections, folder / FILE_NAME)


def _list_others(folder: Path, folders: Sequence[Path]) -> list[Path]:
    """The folders from which results of an older reading go: of storeys, and of the building itself if it has some."""
    return [path for path in (folder, *_list_storeys(folder)) if path not in folders]


def _remove_empty(folders: Sequence[Path]) -> None:
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()


def write_floor(
    floor: Floor,
    grid: GridMap,
    folder: Path,
    schemas: Mapping[str, LabelSchema],
    *,
    paper: NDArray[np.uint8] | None = None,
    scale: PlanScale | None = None,
    walls: bool = False,
    graph: bool = False,
) -> None:
    """Write floor.geojson, rooms.png, graph.json and picture.png.

    scale: of a plan, which floor.geojson keeps; picture.png marks a doubtful one. walls, graph: whether picture.png
    shows them.
    """
    from pianta.io.floors import save_floor, save_label_image
    from pianta.io.graphs import save_graph
    from pianta.plot.figure import save_figure
    from pianta.plot.floor import draw_floor

    geojson, labels, node_link, picture = (folder / name for name in OUTPUTS[:4])
    save_floor(floor, geojson, scale=None if scale is None else scale.as_json())
    save_label_image(floor.label_image(grid), labels)
    save_graph(floor.graph(), node_link)
    figure = draw_floor(
        floor, grid, walls=walls, graph=graph, schemas=schemas, paper=paper, area_trust=find_area_trust(scale)
    )
    save_figure(figure, picture)


def find_area_trust(scale: PlanScale | None) -> AreaTrust:
    """Whether a scale is certain enough for areas; None, as of a map, is."""
    return AreaTrust.EXACT if scale is None else scale.area_trust


def check_clean_map(path: str | Path, target: str | Path, folder: str | Path | None = None) -> None:
    """Refuse, before any work, a name for the clean map that cannot be written or would replace another file.

    path: the map that is read. target: the file of the clean map. folder: that of the results, None without results.

    Raises OptionError, in one line, for the map that is read or its image, and for a result.
    """
    from pianta.io.maps import list_saved_files

    results = [] if folder is None else [Path(folder) / name for name in (*OUTPUTS, EXPLANATION)]
    for written in list_saved_files(target):
        check_output_file(written, "clean map")
        if any(_is_same_file(written, file) for file in list_input_files(path)):
            raise OptionError(f"clean map {short_repr(written)} would replace the map that is read, give another name")
        if any(_is_same_file(written, result) for result in results):
            raise OptionError(f"clean map {short_repr(written)} would replace a result, give another name")


def _is_same_file(one: Path, other: Path) -> bool:
    """Whether two paths lead to one file, also by links and by names that differ in case on some disks."""
    try:
        return one.samefile(other)
    except OSError:
        return real_path(one) == real_path(other)


def check_output(path: str | Path, folder: str | Path, *, names: Sequence[str] = OUTPUTS) -> None:
    """Raise OptionError if a result in a folder, one of the names, would replace the file that is read or its image."""
    for file in list_input_files(path):
        if file.name in names and real_path(file).parent == real_path(folder):
            raise OptionError(f"map {short_repr(file)} would be replaced by a result, give another output folder")


def check_corrections(folder: str | Path, previous: object = None) -> None:
    """Raise OptionError if a folder has corrections that are lost when a reading without them is written into it.

    previous: as of `read`; the corrections of that folder are applied again.
    """
    file = Path(folder) / FILE_NAME
    if isinstance(previous, str | Path) and real_path(folder) in {real_path(previous), real_path(previous).parent}:
        return
    corrections = read_corrections(file) if file.exists() else []
    if corrections:
        raise OptionError(
            f"folder {short_repr(folder)} has {count_noun(len(corrections), 'correction')}, which would be lost; give "
            "it as previous= and they are applied again, or give another output folder"
        )


def may_have_corrections(folder: Path) -> bool:
    """Whether a folder has a floor that people have corrected, or a building with such a storey.

    So may one whose corrections are lost or damaged.
    """
    try:
        return any(_is_corrected(each) for each in (folder, *_list_storeys(folder)))
    except PiantaError:
        return True


def _is_corrected(folder: Path) -> bool:
    file = folder / FILE_NAME
    return bool(read_corrections(file)) if file.exists() else (folder / UNCORRECTED).exists()


def _list_storeys(folder: Path) -> list[Path]:
    """The folders of the storeys in a folder; none for a single floor."""
    with suppress(FloorError):  # of a damaged building.json
        older = read_storey_folders(folder)
        return [folder / name for name in older.titles if (folder / name).is_dir()] if older else []
    return []


def _check_corrections_stayed(folder: Path, previous: tuple[Correction, ...]) -> None:
    """Raise OptionError if another program has changed the corrections of a folder since they were read."""
    file = folder / FILE_NAME
    corrections = tuple(read_corrections(file)) if file.exists() else ()
    if corrections not in ((), previous):
        raise OptionError(
            f"the corrections of folder {short_repr(folder)} have changed since they were read, nothing was written; "
            "read the map again"
        )


def list_input_files(path: str | Path) -> list[Path]:
    """The file that is read, and the image of a map.yaml, or what is in a folder, such as a bag."""
    file = Path(path)
    if file.is_dir():
        with suppress(OSError):
            return [file, *sorted(file.iterdir())]
        return [file]
    if file.suffix.lower() not in {".yaml", ".yml"}:
        return [file]
    from pianta.io.ros_maps import find_map_image

    image = find_map_image(file)
    return [file] if image is None else [file, image]


def _refuse_folders_as_results(folders: Sequence[Path]) -> None:
    """Raise OptionError if a folder, device or pipe has the name of a result, before any result is written."""
    for target in (folder / name for folder in folders for name in OUTPUTS):
        fault = find_output_fault(target, remedy="give another output folder")
        if fault:
            raise OptionError(f"cannot write {short_repr(target)}: it {fault}")
