"""How one file is read: opened as a map or a plan, then ids, labels and the building's type."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypedDict, Unpack, get_args

from pianta.errors import MapError, MapWarning, OptionError, PiantaError
from pianta.floor import Floor
from pianta.io._files import MAX_CELLS, check_input_file, short_repr
from pianta.labels import SCHEMAS
from pianta.layout.parameters import Parameters
from pianta.layout.reconstruct import DEFAULT_METHOD, check_method
from pianta.reading._labelling import Labelling
from pianta.reading.reading import OUTPUTS, Reading, StoreyReading

if TYPE_CHECKING:
    from pianta.building_types.model import BuildingTypeModel
    from pianta.io.images import DecodedImage
    from pianta.plan.symbols.poses import PlacedSymbol
    from pianta.rooms.model import RoomModel

MAX_LISTED_IDS = 10
Kind = Literal["map", "plan"]


class ReadOptions(TypedDict, total=False):
    """The options of `read`, which `read_all` takes too."""

    kind: Kind | None
    resolution: float | None
    trust_thresholds: bool
    max_cells: int
    page: int | None
    symbols: str | Path | None
    words: str | Path | None
    method: str
    parameters: Parameters | None
    building_type: str | None
    room_model: RoomModel | str | Path | None
    building_model: BuildingTypeModel | str | Path | None
    labels: bool
    previous: Floor | str | Path | None


@dataclass(frozen=True)
class Reader:
    """How files are read. labelling: None for no labels. previous: the floor whose ids and given labels stay."""

    labelling: Labelling | None
    previous: Floor | None
    kind: Kind | None
    resolution: float | None
    trust_thresholds: bool
    max_cells: int
    page: int | None
    symbols: Path | None
    method: str
    parameters: Parameters | None

    @classmethod
    def make(cls, **options: Unpack[ReadOptions]) -> Reader:
        """Check the options, and read the models and the previous floor.

        Raises OptionError and what their readers raise, and TypeError for an option that there is not.
        """
        _check_options(options)
        previous, symbols = options.get("previous"), options.get("symbols")
        models = options.get("room_model"), options.get("building_model")
        return cls(
            labelling=Labelling.make(*models, options.get("words"), options.get("building_type"))
            if options.get("labels", True)
            else None,
            previous=previous if previous is None or isinstance(previous, Floor) else read_previous(previous),
            kind=options.get("kind"),
            resolution=options.get("resolution"),
            trust_thresholds=options.get("trust_thresholds", False),
            max_cells=options.get("max_cells", MAX_CELLS),
            page=options.get("page"),
            symbols=None if symbols is None else Path(symbols),
            method=options.get("method", DEFAULT_METHOD),
            parameters=options.get("parameters"),
        )

    def read(self, path: str | Path) -> Reading:
        """The building of a file.

        Raises PiantaError, in one line that names the file.
        """
        # A map or a plan: its rooms, doors and walls (chapter 3)
        storeys = self._open(path)
        if self.previous is not None and len(storeys) > 1:
            raise OptionError(f"previous= is one floor and plan {short_repr(path)} shows {len(storeys)}, leave it out")
        schemas = self.labelling.schemas if self.labelling else SCHEMAS
        return Reading(Path(path), tuple(self._finish(storey, path) for storey in storeys), schemas)

    def _finish(self, storey: StoreyReading, path: str | Path) -> StoreyReading:
        """The storey with the ids of the previous floor, labels, and the type of its building."""
        floor, messages = storey.floor, []
        # Rooms that were there before keep their ids
        if self.previous is not None:
            floor = _keep_ids(floor, self.previous, path)
            messages.append(describe_ids(floor, self.previous))
        # What each room is for (chapters 4 and 5), and what kind of building it is (chapter 6)
        floor = self._label(floor)
        known = self.labelling.predicted_types if self.labelling and floor.rooms else ()
        return replace(storey, floor=floor, known_types=known, messages=(*messages, *storey.messages))

    def _label(self, floor: Floor) -> Floor:
        """The floor with its type and labels; what somebody has said of a room, or of the type before, stays.

        Without labels, what somebody has said is all that stays.
        """
        from pianta.rooms.model import keep_manual_label

        given = self.labelling.building_type if self.labelling else None
        if given is None and self.previous is not None:
            given = self.previous.given_type
        floor = replace(floor, building_type={given: 1.0} if given else {})
        if self.labelling:
            return self.labelling.label(floor)
        return replace(floor, rooms=tuple(map(keep_manual_label, floor.rooms)))

    def _open(self, path: str | Path) -> list[StoreyReading]:
        """The storeys of a file before they are labelled, one of a map."""
        from pianta.io.images import PICTURE_SUFFIXES, open_image
        from pianta.plan.sheets.map_or_plan import detect_input_kind

        _refuse_folder(path)
        if self.kind is None:
            _refuse_suffix(path)
        is_picture = Path(path).suffix.lower() in PICTURE_SUFFIXES
        # A picture is decoded once, for the question what it is and for what follows.
        image = open_image(path, max_cells=self.max_cells) if is_picture and self.kind is None else None
        kind = self.kind or detect_input_kind(image or path)
        return self._read_plan(path, image) if kind == "plan" else [self._read_map(path, image)]

    def _read_map(self, path: str | Path, image: DecodedImage | None) -> StoreyReading:
        from pianta.io.maps import read_map
        from pianta.layout.reconstruct import reconstruct

        given = {"page=": self.page, "symbols=": self.symbols}
        useless = " and ".join(name for name, value in given.items() if value is not None)
        if useless:
            raise OptionError(f"map {short_repr(path)} is no plan, leave out {useless} or give kind='plan'")
        grid = read_map(
            image or path,
            resolution=self.resolution,
            trust_thresholds=self.trust_thresholds,
            max_cells=self.max_cells,
        )
        try:
            return StoreyReading(reconstruct(grid, method=self.method, parameters=self.parameters), grid)
        except PiantaError as error:
            raise type(error)(f"map {short_repr(path)}: {error}") from error

    def _read_plan(self, path: str | Path, image: DecodedImage | None) -> list[StoreyReading]:
        from pianta.plan.read_plan import read_plan

        if self.trust_thresholds:
            raise OptionError(f"plan {short_repr(path)} is no map, leave out trust_thresholds=True or give kind='map'")
        if self.parameters is not None:
            raise OptionError(f"plan {short_repr(path)} is no map, leave out parameters= or give kind='map'")
        plan = read_plan(
            image or path,
            resolution=self.resolution,
            page=self.page,
            symbols=self.symbols,
            method=self.method,
            max_cells=self.max_cells,
        )
        paper = plan.sheet.colors if plan.sheet else None
        unit = plan.sheet.px_per_unit if plan.sheet else 1.0
        several = len(plan.floors) > 1
        matched = (_describe_matches(plan.symbols, self.symbols),) if self.symbols else ()
        return [
            StoreyReading(
                found.floor,
                found.grid,
                name=f"floor-{number}" if several else "",
                scale=found.scale,
                paper=paper,
                messages=(f"scale: {found.scale.describe(px_per_unit=unit)}", *matched),
            )
            for number, found in enumerate(plan.floors, start=1)
        ]


def _check_options(options: ReadOptions) -> None:
    """Raise OptionError for options that make no sense, alone or together, and TypeError for unknown ones."""
    if unknown := options.keys() - ReadOptions.__annotations__.keys():
        raise TypeError(f"there is no option {', '.join(sorted(unknown))}=")
    given = {name: options.get(name) for name in ("room_model", "building_model", "words", "building_type")}
    useless = [f"{name}=" for name, value in given.items() if value is not None]
    if not options.get("labels", True) and useless:
        raise OptionError(f"labels=False makes {' and '.join(useless)} useless, leave either out")
    kind = options.get("kind")
    if kind is not None and kind not in get_args(Kind):
        raise OptionError(f"kind is {short_repr(kind)}, give one of {', '.join(get_args(Kind))}, or None")
    resolution = options.get("resolution")
    if resolution is not None and not (isfinite(resolution) and resolution > 0):
        raise OptionError(f"resolution is {resolution}, give positive metres per cell, or per pixel of a plan")
    check_method(options.get("method", DEFAULT_METHOD))


def read_previous(path: str | Path) -> Floor:
    """The floor of a floor.geojson, or of a folder that holds one.

    Raises FloorError, in one line.
    """
    from pianta.io.floors import read_floor

    is_folder = False
    with suppress(OSError, ValueError):  # read_floor says what is wrong with the path
        is_folder = Path(path).is_dir()
    return read_floor(Path(path) / OUTPUTS[0] if is_folder else path)


def describe_ids(floor: Floor, previous: Floor) -> str:
    """How many rooms kept their ids, how many are new, and which are gone."""
    ids, old_ids = ({room.id for room in each.rooms} for each in (floor, previous))
    kept, new, gone = len(ids & old_ids), len(ids - old_ids), sorted(old_ids - ids)
    line = f"{kept} room{'s' * (kept != 1)} kept {'its id' if kept == 1 else 'their ids'}"
    line += f", {new} {'is' if new == 1 else 'are'} new, {len(gone)} {'is' if len(gone) == 1 else 'are'} gone"
    names = " ".join(map(str, gone[:MAX_LISTED_IDS])) + (" …" if len(gone) > MAX_LISTED_IDS else "")
    return f"{line} ({names})" if gone else line


def _keep_ids(floor: Floor, previous: Floor, path: str | Path) -> Floor:
    """The floor with the ids of the previous one; warns when they have no room in common."""
    from pianta.layout.room_ids import keep_room_ids

    floor = keep_room_ids(floor, previous)
    old_ids = {room.id for room in previous.rooms}
    if old_ids.isdisjoint(room.id for room in floor.rooms):
        message = f"map {short_repr(path)} has no room in common with the floor of previous=, every room got a new id"
        warnings.warn(MapWarning(f"{message}; check that both are of one building"), stacklevel=2)
    return floor


def _describe_matches(symbols: Iterable[PlacedSymbol], folder: Path) -> str:
    """How many symbols were found of each file of a folder."""
    counts = Counter(symbol.name for symbol in symbols if Path(symbol.name).suffix)
    if not counts:
        return f"symbols: none of {short_repr(folder)} found, cut them out of a sheet like this one, at its scale"
    named = ", ".join(f"{count} {name}" for name, count in counts.most_common())
    return f"symbols: {counts.total()} of {short_repr(folder)} found: {named}"


def _refuse_suffix(path: str | Path) -> None:
    """Raise MapError for a file that exists and is neither a map nor a plan by its suffix."""
    from pianta.io.maps import MAP_SUFFIXES
    from pianta.plan.sheets.map_or_plan import PLAN_SUFFIXES

    known = dict.fromkeys([*MAP_SUFFIXES, *PLAN_SUFFIXES])
    if Path(path).suffix.lower() not in known:
        file = check_input_file(path, "file", MapError)
        raise MapError(f"file {short_repr(file)} is of no known kind, give one of {', '.join(known)}")


def _refuse_folder(path: str | Path) -> None:
    """Raise MapError for a folder, naming the YAMLs in it, one of which may be meant."""
    from pianta.io.ros_maps import YAML_SUFFIXES

    try:
        inside = sorted(Path(path).iterdir())
    except (OSError, ValueError):  # no folder; the reader says what it is
        return
    yamls = [short_repr(file) for file in inside if file.suffix.lower() in YAML_SUFFIXES]
    more = " …" if len(yamls) > 3 else ""
    remedy = " or ".join(yamls[:3]) + more if yamls else "the map.yaml or the image of a map"
    raise MapError(f"map {short_repr(path)} is a folder, give {remedy}")
