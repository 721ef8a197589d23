"""Plans as IFC, the exchange format of building information models: spaces are rooms, doors join them."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely import Polygon

from pianta.errors import PlanWarning
from pianta.floor import Door, Floor, Room
from pianta.io._faults import join_faults
from pianta.io._files import one_line_reason, short_repr
from pianta.io.drawings._flags_by_name import find_flag_in_name
from pianta.io.drawings._ifc_model import IfcModel, list_parts, read_global_id, read_text
from pianta.io.drawings._ifc_outside import Outside, find_flag
from pianta.io.drawings._ifc_passages import Passages, StoreyRooms
from pianta.io.drawings._ifc_units import set_missing_unit
from pianta.io.drawings._ifc_walls import WalledStorey, Walls
from pianta.io.drawings._layers import check_plan_file, damage_as_plan_error, plan_error, require_library

if TYPE_CHECKING:
    from ifcopenshell import entity_instance, file


# Limits against hostile files.
MAX_FILE_BYTES = 256 * 2**20
MAX_SPACES = 5000
MAX_DOORS = 20_000
MAX_BOUNDARIES = 200_000
MAX_HEADER = 2**16  # bytes in which the schema is named

# Chosen by hand:
MIN_PART_SHARE = 0.01  # of the largest part of a space; a smaller part is no loss
MAX_NUMBER = 12  # characters; longer numbers are names
MAX_STEP = 0.8  # metres between the foot of a door and the floor of its storey
_START, _END = b"ISO-10303-21;", b"END-ISO-10303-21;"
_SCHEMA = re.compile(rb"FILE_SCHEMA\s*\(\s*\(\s*'([^']{1,40})'")
# Of 1997 to 2003; IFC2X3 is of 2006.
_OLD_SCHEMAS = ("IFC1", "IFC20", "IFC2.", "IFC2X_", "IFC2X2")
_OLDEST_READ = "IFC2X3"


@dataclass(frozen=True)
class IfcStorey:
    """A storey that has rooms.

    floor: in metres of the model's world frame, x and y as in the file; rooms have numbers, names and GlobalIds.
    name: of the storey. elevation: metres above the model's zero.
    """

    floor: Floor
    name: str
    elevation: float

    @property
    def names(self) -> dict[int, str]:
        """The names of rooms by their ids, without rooms that have no name."""
        return {room.id: room.name for room in self.floor.rooms if room.name is not None}


def read_ifc_plan(path: str | Path, *, storey: str | None = None) -> list[IfcStorey]:
    """Read the storeys of an IFC (STEP) file that have rooms, from the lowest to the highest, with rooms and doors.

    storey: the name of the only one to read, in any case.

    A room is the footprint of a space, numbered from 1 in the order of the file. Its number is the Name of the space,
    its name the LongName, or else a Name that is no number. Spaces made of spaces and those of gross areas are left
    out; balconies, terraces, attics and roofs are flagged. Without any space, rooms are what walls, doors, windows and
    slabs enclose 1 m above each storey.
    The line of a door is as long as the opening that it fills, or else as its own shape; its width is OverallWidth. It
    joins the spaces that it bounds (IfcRelSpaceBoundary of any level), and if these are fewer than two, the rooms on
    both its sides at most MAX_WALL metres away; with one room it is an entrance if it leads to the ground outside.
    Openings join rooms at virtual boundaries, at openings of walls that nothing fills, and where rooms touch without a
    wall. Lengths are converted to metres by IfcUnitAssignment.

    One PlanWarning counts spaces and doors that cannot be located; they are left out.
    Raises PlanError, in one line, if ifcopenshell (pianta[bim]) is missing, and for a file that is no IFC, of a schema
    before IFC2X3, cut off, damaged, too large, or has no rooms, or no storey of that name.
    Source of the format: ISO 16739, through IfcOpenShell.
    """
    file = check_plan_file(path, max_bytes=MAX_FILE_BYTES)
    model = _open_model(file)
    with damage_as_plan_error(file, "IFC"):  # IfcOpenShell checks entities when they are used
        unit = set_missing_unit(model)
        reader = _Reader(IfcModel(model, file))
        storeys = reader.read_storeys(storey)
    notes = [f"{count} {what}, left out" for what, count in reader.left_out.items() if count]
    notes += [unit] if unit else []
    notes += ["no spaces (IfcSpace), its rooms are made from its walls"] if reader.from_walls else []
    if notes:
        warnings.warn(f"plan {short_repr(file)} has {join_faults(notes)}", PlanWarning, stacklevel=2)
    return storeys


def _open_model(file: Path) -> file:
    """The model in an IFC file; raises PlanError for a file that is no IFC or is cut off."""
    require_library(file, "ifcopenshell", "an IFC", "bim")
    import ifcopenshell

    with file.open("rb") as stream:
        start = stream.read(MAX_HEADER)
        stream.seek(max(0, file.stat().st_size - 200))
        end = stream.read()
    if _START not in start[:200]:
        raise plan_error(file, "is no IFC, save it as .ifc (STEP), not zipped and not as XML")
    _refuse_old_schema(file, start)
    if _END not in end:
        raise plan_error(file, "is cut off, its last line is not END-ISO-10303-21; save it again")
    try:
        return ifcopenshell.open(file, format=".ifc")
    except Exception as exception:
        reason = one_line_reason(exception)
        raise plan_error(file, f"is no IFC or damaged, save it again as .ifc: {reason}") from exception


def _refuse_old_schema(file: Path, header: bytes) -> None:
    """Raise PlanError for a schema of 2003 or before, by its name."""
    named = _SCHEMA.search(header)
    schema = named.group(1).decode("ascii", "replace").strip().upper() if named else ""
    if schema.startswith(_OLD_SCHEMAS) or schema == "IFC2X":
        raise plan_error(
            file,
            f"is of {short_repr(schema)}, a version of IFC of 2003 or before; open it in a BIM program and save it as "
            f"{_OLDEST_READ} or IFC4",
        )


@dataclass
class _Reader:
    """Reads a model; left_out: counts of elements that are left out, by the reason."""

    model: IfcModel
    left_out: Counter[str] = field(default_factory=Counter)

    def read_storeys(self, only: str | None) -> list[IfcStorey]:
        """The storeys that have rooms, or the one of a name."""
        self._check_counts()
        storeys = self._choose(self._rooms_from_walls() if self.from_walls else self._rooms_of_spaces(), only)
        doors = self._doors_by_storey(storeys)
        read = [self._finish(each, doors.get(each.storey.id(), [])) for each in storeys]
        return sorted(read, key=lambda storey: storey.elevation)

    def _check_counts(self) -> None:
        """Raise PlanError for more elements than a building has."""
        limits = (("IfcSpace", MAX_SPACES, "spaces"), ("IfcDoor", MAX_DOORS, "doors"))
        for ifc_type, limit, noun in (*limits, ("IfcRelSpaceBoundary", MAX_BOUNDARIES, "boundaries of spaces")):
            count = len(self.model.list_products(ifc_type))
            if count > limit:
                raise plan_error(self.model.path, f"has {count} {noun}, give at most {limit}")

    @cached_property
    def from_walls(self) -> bool:
        """Whether the model has no spaces."""
        return not self.model.list_products("IfcSpace")

    @cached_property
    def walls(self) -> Walls:
        """What closes rooms."""
        return Walls(self.model)

    @cached_property
    def passages(self) -> Passages:
        """Reads doors and openings."""
        return Passages(self.model, self.outside)

    @cached_property
    def outside(self) -> Outside:
        """Decides what is outside."""
        return Outside(self.model, self.walls)

    def _choose(self, storeys: Sequence[StoreyRooms], only: str | None) -> Sequence[StoreyRooms]:
        """The storeys with rooms, or the one of a name; raises PlanError without any."""
        if only is not None:
            chosen = [each for each in storeys if _name_of(each.storey).casefold() == only.strip().casefold()]
            if not chosen:
                names = ", ".join(short_repr(_name_of(each.storey)) for each in storeys)
                raise plan_error(self.model.path, f"has no storey {short_repr(only)}, it has {names}")
            storeys = chosen
        storeys = [each for each in storeys if each.rooms]
        if not storeys:
            what = "spaces (IfcSpace), and no walls that enclose rooms, export the rooms with it"
            what = what if self.from_walls else "spaces with a shape, export their geometry with it"
            raise plan_error(self.model.path, f"has no {what}")
        return storeys

    def _rooms_of_spaces(self) -> list[StoreyRooms]:
        """The rooms of each storey that has spaces, in the order of the file."""
        by_storey: dict[int, list[entity_instance]] = {}
        for space in filter(self._is_room, self.model.list_products("IfcSpace")):
            storey = self.model.storey_of(space)
            if storey is None:
                self.left_out["spaces on no storey"] += 1
            else:
                by_storey.setdefault(storey.id(), []).append(space)
        return [self._read_rooms(self.model.file[number], spaces) for number, spaces in by_storey.items()]

    def _is_room(self, space: entity_instance) -> bool:
        """Whether a space is no gross floor area, contains no other space, and is no part of a space with a shape."""
        if getattr(space, "PredefinedType", None) == "GFA":
            return False
        parts = [part for part in list_parts(space) if part.is_a("IfcSpace")]
        parents = [relation.RelatingObject for relation in space.Decomposes]
        if any(parent.is_a("IfcSpace") and self._is_whole(parent) for parent in parents):
            return False
        return not parts or self._is_whole(space)

    def _is_whole(self, space: entity_instance) -> bool:
        """Whether a space is one room, although it has parts: they are PARTIAL, and it has a shape of its own."""
        parts = [part for part in list_parts(space) if part.is_a("IfcSpace")]
        is_divided = bool(parts) and all(part.CompositionType == "PARTIAL" for part in parts)
        return is_divided and self._footprint_of(space) is not None

    def _read_rooms(self, storey: entity_instance, spaces: Sequence[entity_instance]) -> StoreyRooms:
        """The rooms of a storey; those without a shape are counted as left out."""
        rooms: dict[int, Room] = {}
        is_ground = self.outside.is_ground(storey)
        for space in spaces:
            outline = self._footprint_of(space)
            if outline is None:
                self.left_out["spaces without a shape"] += 1
                continue
            number, name = _read_number_and_name(space)
            shape = self.model.shape_of(space)
            height = shape.high - shape.low if len(shape.faces) else 0.0
            rooms[space.id()] = Room(
                len(rooms) + 1,
                outline,
                name=name,
                number=number,
                global_id=read_global_id(space),
                flag=find_flag(space, height=height, is_ground=is_ground),
            )
        feet = [self.model.shape_of(self.model.file[number]).low for number in rooms]
        feet = [foot for foot in feet if np.isfinite(foot)]
        base = float(np.median(feet)) if feet else self.model.base_of(storey)
        return StoreyRooms(storey, tuple(rooms.values()), rooms, base)

    def _footprint_of(self, space: entity_instance) -> Polygon | None:
        """The area of a space from above, metres; only its largest part."""
        area = self.model.shape_of(space).project()
        if area.is_empty:
            area = self.model.outline_of(space)
        parts = [part for part in shapely.get_parts(area) if isinstance(part, Polygon) and part.is_valid]
        largest = max(parts, key=lambda part: part.area, default=None)
        if largest is None or largest.is_empty:
            return None
        lost = sum(part.area >= MIN_PART_SHARE * largest.area for part in parts) - 1
        self.left_out["parts of spaces in several parts"] += lost
        return largest

    def _rooms_from_walls(self) -> list[StoreyRooms]:
        """The rooms that the walls of each storey enclose, from the largest."""
        return [self._enclose_rooms(storey) for storey in self.walls.list_storeys()]

    def _enclose_rooms(self, storey: WalledStorey) -> StoreyRooms:
        flag = find_flag_in_name(_name_of(storey.entity))
        outlines = self.walls.find_rooms(storey)
        rooms = tuple(Room(number, outline, flag=flag) for number, outline in enumerate(outlines, start=1))
        return StoreyRooms(storey.entity, rooms, {}, storey.base)

    def _doors_by_storey(self, storeys: Sequence[StoreyRooms]) -> dict[int, list[entity_instance]]:
        """Doors by the number of their storey: that of a space that they bound, else the one that contains them."""
        storey_of_space = {space: each.storey.id() for each in storeys for space in each.by_space}
        by_storey: dict[int, list[entity_instance]] = {}
        for door in self.model.list_products("IfcDoor"):
            spaces = (boundary.RelatingSpace for boundary in door.ProvidesBoundaries)
            numbers = (space.id() for space in spaces if space is not None)
            bounded = (storey_of_space[number] for number in numbers if number in storey_of_space)
            storey = next(bounded, None) or self._storey_of_door(door, storeys)
            if storey is not None:
                by_storey.setdefault(storey, []).append(door)
            else:
                self.left_out["doors on no storey"] += 1
        return by_storey

    def _storey_of_door(self, door: entity_instance, storeys: Sequence[StoreyRooms]) -> int | None:
        """The number of the storey that contains a door; with rooms from walls, of the one on which it stands."""
        if self.from_walls:
            foot = self.model.shape_of(door).low
            near = [each for each in storeys if abs(each.base - foot) <= MAX_STEP]
            if near:
                return int(min(near, key=lambda each: abs(each.base - foot)).storey.id())
        container = self.model.storey_of(door)
        return None if container is None else int(container.id())

    def _finish(self, on: StoreyRooms, doors: Iterable[entity_instance]) -> IfcStorey:
        """A storey with its rooms, doors and openings, metres."""
        read = [self.passages.read_door(door, on) for door in doors]
        self.left_out["doors that do not lead from a room to another or outside"] += read.count(None)
        passages: list[Door] = [door for door in read if door is not None]
        passages += self.passages.list_openings(on, passages)
        passages += self.passages.list_gaps(on, passages)
        name, elevation = _name_of(on.storey), self.model.elevation_of(on.storey)
        floor = Floor(on.rooms, tuple(passages), source=self.model.path.name, title=name, elevation=elevation)
        return IfcStorey(replace(floor, global_id=read_global_id(on.storey)), name, elevation)


def _name_of(storey: entity_instance) -> str:
    """What a storey is called."""
    return read_text(storey, "Name") or read_text(storey, "LongName") or f"storey {storey.id()}"


def _read_number_and_name(space: entity_instance) -> tuple[str | None, str | None]:
    """The Name of a space, and its LongName, or else a Name in words, such as "Kitchen"."""
    number, name = read_text(space, "Name"), read_text(space, "LongName")
    if name is None and number is not None and not _is_number(number):
        name = number
    return number, name


def _is_number(text: str) -> bool:
    return any(map(str.isdigit, text)) and " " not in text and len(text) <= MAX_NUMBER
