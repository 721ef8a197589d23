"""Reader: turns one file, a map or a plan, into floors with room ids, labels and a building type."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack, get_args

from pianta.corrections.correct import Outcome, correct_all, find_unlabelled
from pianta.corrections.corrections_file import FILE_NAME
from pianta.corrections.kinds import Correction, SetType
from pianta.errors import FloorError, MapError, MapWarning, OptionError, PiantaError
from pianta.floor import Floor, round_floor
from pianta.gridmap import GridMap
from pianta.io._files import as_utf8, check_input_file, count_noun, short_repr
from pianta.io.bags import BAG_SUFFIXES, Message, check_message, is_bag
from pianta.labels import SCHEMAS
from pianta.layout.parameters import Parameters
from pianta.layout.reconstruct import DEFAULT_METHOD, check_as_printed, check_method
from pianta.layout.room_ids import keep_room_ids
from pianta.reading._labelling import Labelling
from pianta.reading.reading import OUTPUTS, Reading, StoreyReading
from pianta.reading.saved_reading import CarriedOver, SavedReading, keep_words, measure_factor
from pianta.reading.storeys import name_folders

if TYPE_CHECKING:
    from pianta.building_types.model import BuildingTypeModel
    from pianta.io.images import DecodedImage
    from pianta.plan.read_plan import PlanReading
    from pianta.plan.symbols.poses import PlacedSymbol
    from pianta.rooms.model import RoomModel

MAX_LISTED_IDS = 10
LAYER_OPTIONS = ("wall_layers", "door_layers", "room_layers")
InputKind = Literal["map", "plan"]


class ReadOptions(TypedDict, total=False):
    """The options of `read`, which `read_all` has too."""

    input_kind: InputKind | None
    resolution: float | None
    trust_thresholds: bool
    topic: str | None
    message: Message
    max_cells: int
    page: int | None
    symbols: str | Path | None
    wall_layers: Sequence[str]
    door_layers: Sequence[str]
    room_layers: Sequence[str]
    words: str | Path | None
    method: str
    parameters: Parameters | None
    as_printed: bool
    predict_partial: bool
    building_type: str | None
    room_model: RoomModel | str | Path | None
    building_model: BuildingTypeModel | str | Path | None
    labels: bool
    label_unknown: bool
    previous: Floor | str | Path | None
    earlier: Sequence[Floor | str | Path]


@dataclass(frozen=True)
class Reader:
    """Checked options of `read`.

    labelling: None for no labels. previous: the floor whose room ids and user labels are kept. earlier: floors before
    it, the newest first. corrected: the folder of the previous floor, if it has corrections.
    """

    options: ReadOptions
    labelling: Labelling | None
    previous: Floor | None
    earlier: tuple[Floor, ...]
    corrected: SavedReading | None = None

    @classmethod
    def make(cls, **options: Unpack[ReadOptions]) -> Reader:
        """Check the options, and read the models and the previous floor.

        Raises OptionError, the exceptions of the readers of these files, and TypeError for an unknown option.
        """
        _check_options(options)
        labelling = None
        if options.get("labels", True):
            models = options.get("room_model"), options.get("building_model")
            label_unknown = options.get("label_unknown", False)
            names_and_type = options.get("words"), options.get("building_type")
            labelling = Labelling.make(*models, *names_and_type, label_unknown=label_unknown)
        floors = options.get("previous"), *options.get("earlier", ())
        previous, *earlier = (
            each if each is None or isinstance(each, Floor) else read_previous(each) for each in floors
        )
        corrected = None if isinstance(floors[0], Floor | None) else open_corrected(floors[0])
        return cls(options, labelling, previous, tuple(floor for floor in earlier if floor), corrected)

    def keep(self, folder: Path) -> Reader:
        """The same reader, for a file of which a folder has an older reading: ids and corrections are kept."""
        return replace(self, previous=read_previous(folder), corrected=open_corrected(folder))

    def read(self, path: str | Path) -> Reading:
        """The building of a file.

        Raises PiantaError, in one line that names the file.
        """
        # A map or a plan: its rooms, doors and walls (chapter 3)
        storeys = self._open(path)
        if self.previous is not None and len(storeys) > 1:
            raise OptionError(f"previous= is one floor and plan {short_repr(path)} shows {len(storeys)}, leave it out")
        schemas = self.labelling.schemas if self.labelling else SCHEMAS
        finished = [self._finish(storey, path) for storey in storeys]
        if self.labelling and len(finished) > 1:
            shared = self.labelling.share_home([storey.floor for storey in finished])
            finished = [replace(storey, floor=floor) for storey, floor in zip(finished, shared, strict=True)]
        return Reading(Path(path), tuple(finished), schemas)

    def _finish(self, storey: StoreyReading, path: str | Path) -> StoreyReading:
        """The storey with the ids of the previous floor, labels, and the type of its building."""
        # Files that people open have millimetres, not 17 digits
        rounded = round_floor(storey.floor)
        storey = replace(storey, floor=replace(rounded, source=as_utf8(rounded.source)))
        floor, messages, grid = storey.floor, [], storey.grid
        uncorrected: Floor | None = None
        scale = storey.scale
        corrections: tuple[Correction, ...] = ()
        unlabelled: list[int] = []
        # What people have corrected in the previous floor is corrected here too
        if self.corrected is not None:
            carried = self._carry_over(storey, self.corrected, path)
            uncorrected, corrections = carried.floor, tuple(carried.corrections)
            # Labels that people have given in the corrected floor have priority over those of the uncorrected one
            floor, outcomes = correct_all(keep_words(uncorrected, carried.read), corrections)
            grid = grid.scaled(measure_factor(outcomes))
            scale = None if scale is None else scale.corrected(measure_factor(outcomes))
            messages += [*describe_restored(carried.restored), *describe_outcomes(outcomes)]
            unlabelled = find_unlabelled(floor, outcomes)
            uncorrected = self._label(uncorrected, self.corrected.uncorrected)
        # Rooms of the previous floor keep their ids
        if self.previous is not None:
            floor = keep_room_ids(floor, self.previous, earlier=self.earlier)
            warn_of_other_building(floor, self.previous, self.earlier, path)
            messages.append(describe_ids(floor, self.previous, self.earlier))
        # What each room is for (chapters 4 and 5), and what kind of building it is (chapter 6)
        floor = without_labels(self._label(floor, self.previous), corrections, unlabelled)
        types = self.labelling.predicted_types if self.labelling and floor.rooms else ()
        return replace(
            storey,
            floor=floor,
            grid=grid,
            scale=scale,
            candidate_types=types,
            messages=(*messages, *storey.messages),
            uncorrected=uncorrected,
            uncorrected_scale=None if uncorrected is None else storey.scale,
            corrections=corrections,
            previous_corrections=self.corrected.corrections if self.corrected else (),
        )

    def _carry_over(self, storey: StoreyReading, corrected: SavedReading, path: str | Path) -> CarriedOver:
        """The floor with the ids of the previous one, uncorrected; and the corrections of that in the new frame."""
        try:
            return corrected.carry_over(storey.floor, storey.grid)
        except FloorError as error:
            raise FloorError(f"map {short_repr(path)}: {error}") from error

    def _label(self, floor: Floor, previous: Floor | None) -> Floor:
        """The floor with its building type and labels; a user's label of a room, or previous type, stays.

        With labels=False only the user's labels stay.
        """
        from pianta.rooms.model import keep_manual_label

        building_type = self.labelling.building_type if self.labelling else None
        if building_type is None and previous is not None:
            building_type = previous.given_type
        floor = replace(floor, building_type={building_type: 1.0} if building_type else {})
        if self.labelling:
            return self.labelling.label(floor)
        return replace(floor, rooms=tuple(map(keep_manual_label, floor.rooms)))

    def _open(self, path: str | Path) -> list[StoreyReading]:
        """The unlabelled storeys of a file; a map has one."""
        from pianta.io.images import PICTURE_SUFFIXES, open_image
        from pianta.plan.sheets.map_or_plan import detect_input_kind

        if is_bag(path):
            return [self._read_map(path, None)]
        _refuse_folder(path)
        input_kind = self.options.get("input_kind")
        image = None
        if input_kind is None:
            _refuse_suffix(path)
            # A picture is decoded once, to detect its kind and to be read.
            if Path(path).suffix.lower() in PICTURE_SUFFIXES:
                image = open_image(path, **self._choose("max_cells"))
            input_kind = detect_input_kind(image or path)
        return self._read_plan(path, image) if input_kind == "plan" else [self._read_map(path, image)]

    def _choose(self, *names: str) -> dict[str, Any]:
        """Those of the options that were given; the others keep the defaults of the function that is called."""
        return {name: value for name, value in self.options.items() if name in names}

    def _read_map(self, path: str | Path, image: DecodedImage | None) -> StoreyReading:
        """Reconstruct the floor of a map; OptionError for options of plans. image: decoded, None to read the file."""
        from pianta.io.maps import JSON_SUFFIX, MissingResolutionError, read_map
        from pianta.io.vacuum_segments import name_rooms
        from pianta.io.valetudo import is_wrapped, read_vacuum_map

        names = ("page", "symbols", *LAYER_OPTIONS)
        useless = " and ".join(f"{name}=" for name in names if self.options.get(name) not in {None, ()})
        if useless:
            raise OptionError(f"map {short_repr(path)} is no plan, leave out {useless} or give input_kind='plan'")
        options = self._choose("resolution", "trust_thresholds", "topic", "message", "max_cells")
        try:
            grid = read_map(image or path, **options)
        except MissingResolutionError as error:
            if self.options.get("input_kind"):
                raise
            raise MapError(f"{error}; if it is a floor plan, give input_kind='plan'") from error
        storey = self._reconstruct(grid, path)
        if Path(path).suffix.lower() == JSON_SUFFIX or is_wrapped(path):
            # Names that the robot or its owner has given to segments
            limit = self._choose("max_cells")
            storey = replace(storey, floor=name_rooms(storey.floor, read_vacuum_map(path, **limit)))
        return storey

    def read_grid(self, grid: GridMap, path: str | Path) -> Reading:
        """The building of a map; path: where it comes from, for messages. Raises PiantaError, in one line."""
        schemas = self.labelling.schemas if self.labelling else SCHEMAS
        return Reading(Path(path), (self._finish(self._reconstruct(grid, path), path),), schemas)

    def _reconstruct(self, grid: GridMap, path: str | Path) -> StoreyReading:
        """The unlabelled floor of a map; warns of an implausible one."""
        from pianta.layout.reconstruct import reconstruct

        try:
            floor = reconstruct(grid, **self._choose("method", "parameters", "as_printed", "predict_partial"))
        except PiantaError as error:
            raise explain_map_fault(error, grid, path) from error
        warn_of_implausible_map(floor, grid, path)
        return StoreyReading(floor, grid)

    def _read_plan(self, path: str | Path, image: DecodedImage | None) -> list[StoreyReading]:
        """Read all floors of a plan; OptionError for options of maps. image: decoded, None to read the file."""
        from pianta.plan.read_pages import read_plan_pages

        useless = {
            "trust_thresholds=True": self.options.get("trust_thresholds"),
            "topic=": self.options.get("topic") is not None,
            "message=": self.options.get("message", "last") != "last",
            "parameters=": self.options.get("parameters") is not None,
            "as_printed=True": self.options.get("as_printed"),
            "predict_partial=False": not self.options.get("predict_partial", True),
        }
        for option in (name for name, is_given in useless.items() if is_given):
            raise OptionError(f"plan {short_repr(path)} is no map, leave out {option} or give input_kind='map'")
        names = ("resolution", "page", "symbols", "method", "max_cells", *LAYER_OPTIONS)
        pages = read_plan_pages(image or path, **self._choose(*names))
        folders = iter(name_folders([floor.name for plan in pages for floor in plan.floors]))
        return [storey for plan in pages for storey in self._storeys_of_plan(plan, folders)]

    def _storeys_of_plan(self, plan: PlanReading, folders: Iterator[str]) -> Iterator[StoreyReading]:
        """The unlabelled floors of a plan; folders: their names."""
        paper = plan.sheet.colors if plan.sheet else None
        unit = plan.px_per_unit
        symbols = self.options.get("symbols")
        matches = () if symbols is None else (_describe_matches(plan.symbols, Path(symbols)),)
        was_read = plan.sheet is not None and plan.sheet.texts is None
        for each in plan.floors:
            yield StoreyReading(
                self._correct_spelling(each.floor) if was_read else each.floor,
                each.grid,
                name=next(folders),
                scale=each.scale,
                title=each.name,
                elevation=each.elevation,
                paper=paper,
                messages=(
                    f"scale: {each.scale.describe(px_per_unit=unit)}",
                    *plan.notes,
                    *matches,
                    *_describe_missing_doors(each.floor),
                ),
            )

    def _correct_spelling(self, floor: Floor) -> Floor:
        """The floor with the words of its rooms that were misread from pixels mended."""
        from pianta.rooms.home import read_home_dictionary
        from pianta.rooms.name_dictionary import read_default_room_name_dictionary
        from pianta.rooms.spelling import correct_spelling

        return correct_spelling(floor, read_default_room_name_dictionary(), read_home_dictionary())


def _describe_missing_doors(floor: Floor) -> list[str]:
    """That no doors join the rooms of a plan; nothing if some do, or for a single room."""
    if len(floor) < 2 or any(None not in door.rooms for door in floor.doors):
        return []
    return ["graph: doors between rooms are not drawn on this plan, or none was found, so that no rooms are joined"]


def explain_map_fault(error: PiantaError, grid: GridMap, path: str | Path) -> PiantaError:
    """The error of a map that cannot be read, with its path and what may be the reason."""
    from pianta.reading._plausibility import describe_inverted_greys

    reasons = "; ".join([str(error), *describe_inverted_greys(grid)])
    return type(error)(f"map {short_repr(path)}: {reasons}")


def warn_of_implausible_map(floor: Floor, grid: GridMap, path: str | Path) -> None:
    """Warn of what is implausible about a map and its floor."""
    from pianta.reading._plausibility import describe_implausible_reading

    for message in describe_implausible_reading(floor, grid):
        warnings.warn(MapWarning(f"map {short_repr(path)}: {message}"), stacklevel=2)


def _check_options(options: ReadOptions) -> None:
    """Raise OptionError for impossible values or combinations, and TypeError for unknown options."""
    if unknown := options.keys() - ReadOptions.__annotations__.keys():
        raise TypeError(f"there is no option {', '.join(sorted(unknown))}=")
    label_options = ("room_model", "building_model", "words", "building_type")
    useless = [f"{name}=" for name in label_options if options.get(name) is not None]
    useless += ["label_unknown=True"] if options.get("label_unknown") else []
    if not options.get("labels", True) and useless:
        raise OptionError(f"labels=False makes {' and '.join(useless)} useless, leave either out")
    input_kind = options.get("input_kind")
    if input_kind is not None and input_kind not in get_args(InputKind):
        choices = ", ".join(get_args(InputKind))
        raise OptionError(f"input_kind is {short_repr(input_kind)}, give one of {choices}, or None")
    resolution = options.get("resolution")
    if resolution is not None and not (isfinite(resolution) and resolution > 0):
        raise OptionError(f"resolution is {resolution}, give positive metres per cell, or per pixel of a plan")
    check_message(options.get("message", "last"))
    method = options.get("method", DEFAULT_METHOD)
    check_method(method)
    if options.get("as_printed"):
        check_as_printed(method, options.get("parameters"))
    earlier = options.get("earlier", ())
    if isinstance(earlier, str | Path | Floor):
        raise OptionError(f"earlier is {short_repr(earlier)}, give a list of floors or of their files")
    if earlier and options.get("previous") is None:
        raise OptionError("earlier= is given without previous=, give the newest floor as previous=")


def read_previous(path: str | Path) -> Floor:
    """The floor of a floor.geojson, or of a folder that holds one.

    Raises FloorError, in one line.
    """
    from pianta.io.floors import read_floor

    is_folder = False
    with suppress(OSError, ValueError):  # read_floor reports a faulty path
        is_folder = Path(path).is_dir()
    return read_floor(Path(path) / OUTPUTS[0] if is_folder else path)


def open_corrected(path: str | Path) -> SavedReading | None:
    """The folder of a floor with corrections; None if it has none.

    path: of the folder, or of the floor.geojson in it. Raises PiantaError, in one line, if a file of it is damaged.
    """
    folder = Path(path) if Path(path).is_dir() else Path(path).parent
    is_whole = Path(path).is_dir() or Path(path).name == OUTPUTS[0]
    return SavedReading.open(folder) if is_whole and (folder / FILE_NAME).exists() else None


def describe_restored(count: int) -> list[str]:
    """How many rooms have the outline of the previous floor, because corrections confirm it; nothing for none."""
    has = "room that corrections confirm has its" if count == 1 else "rooms that corrections confirm have their"
    return [f"{count} {has} previous outline, since the map is the same there"] if count else []


def without_labels(floor: Floor, corrections: Iterable[Correction], unlabelled: Collection[int]) -> Floor:
    """The floor without the labels of rooms, named by their indexes, and the type that people have taken away."""
    rooms = tuple(
        replace(room, label=None, labels={}, label_probabilities={}) if index in unlabelled else room
        for index, room in enumerate(floor)
    )
    types = [each.building_type for each in corrections if isinstance(each, SetType)]
    return replace(floor, rooms=rooms, building_type={} if types[-1:] == [None] else floor.building_type)


def describe_outcomes(outcomes: Sequence[Outcome]) -> list[str]:
    """How many corrections were applied, and which no longer fit."""
    unfit = [(number, outcome) for number, outcome in enumerate(outcomes, start=1) if outcome.problem]
    line = f"{len(outcomes) - len(unfit)} of {count_noun(len(outcomes), 'correction')} applied"
    return [
        line,
        *(f"correction {number}, {each.correction}, no longer fits: {each.problem}" for number, each in unfit),
    ]


def describe_ids(floor: Floor, previous: Floor, earlier: Sequence[Floor] = ()) -> str:
    """How many rooms kept their ids, have them back from earlier floors, are new; and which are gone."""
    ids, old_ids = ({room.id for room in each.rooms} for each in (floor, previous))
    earlier_ids = {room.id for each in earlier for room in each.rooms} - old_ids
    common, back, gone = len(ids & old_ids), len(ids & earlier_ids), sorted(old_ids - ids)
    new = len(ids) - common - back
    line = f"{common} room{'s' * (common != 1)} kept {'its id' if common == 1 else 'their ids'}"
    line += f", {back} {'has its id' if back == 1 else 'have their ids'} back" if earlier else ""
    line += f", {new} {'is' if new == 1 else 'are'} new, {len(gone)} {'is' if len(gone) == 1 else 'are'} gone"
    names = " ".join(map(str, gone[:MAX_LISTED_IDS])) + (" …" if len(gone) > MAX_LISTED_IDS else "")
    return f"{line} ({names})" if gone else line


def warn_of_other_building(floor: Floor, previous: Floor, earlier: Sequence[Floor], path: str | Path) -> None:
    """Warn if a floor with the ids of previous ones has no room in common with them."""
    old_ids = {room.id for each in (previous, *earlier) for room in each.rooms}
    if old_ids.isdisjoint(room.id for room in floor.rooms):
        message = f"map {short_repr(path)} has no room in common with the floor of previous=, every room got a new id"
        warnings.warn(MapWarning(f"{message}; check that both are of one building"), stacklevel=2)


def _describe_matches(symbols: Iterable[PlacedSymbol], folder: Path) -> str:
    """How many symbols the plan has of each template file in a folder."""
    counts = Counter(symbol.name for symbol in symbols if Path(symbol.name).suffix)
    if not counts:
        return f"symbols: none of {short_repr(folder)} found, cut them out of a sheet like this one, at its scale"
    named = ", ".join(f"{count} {name}" for name, count in counts.most_common())
    return f"symbols: {counts.total()} of {short_repr(folder)} found: {named}"


def _refuse_suffix(path: str | Path) -> None:
    """Raise MapError for a file that exists and is neither a map nor a plan by its suffix."""
    from pianta.io.drawings.dxf import DWG_REMEDY
    from pianta.io.maps import MAP_SUFFIXES
    from pianta.plan.sheets.map_or_plan import PLAN_SUFFIXES

    suffixes = dict.fromkeys([*MAP_SUFFIXES, *PLAN_SUFFIXES])
    if Path(path).suffix.lower() not in suffixes:
        file = check_input_file(path, "file", MapError)
        if file.suffix.lower() == ".dwg":
            raise MapError(f"file {short_repr(file)} is a DWG, {DWG_REMEDY}")
        raise MapError(f"file {short_repr(file)} is of no known kind, give one of {', '.join(suffixes)}")


def _refuse_folder(path: str | Path) -> None:
    """Raise MapError for a folder; the message suggests the YAML files and bags in it."""
    from pianta.io.ros_maps import YAML_SUFFIXES

    try:
        inside = sorted(Path(path).iterdir())
    except (OSError, ValueError):  # no folder; the reader reports other faults
        return
    maps = [short_repr(file) for file in inside if file.suffix.lower() in (*YAML_SUFFIXES, *BAG_SUFFIXES)]
    more = " …" if len(maps) > 3 else ""
    remedy = " or ".join(maps[:3]) + more if maps else "the map.yaml or the image of a map"
    raise MapError(f"map {short_repr(path)} is a folder, give {remedy}")
