"""Plans as IFC, the exchange format of building information models: spaces are rooms, doors join them."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon

from pianta._types import Floats
from pianta.errors import PlanWarning
from pianta.floor import DOOR_WIDTH, MAX_ROOM_NAME_LENGTH, Door, Floor, Room
from pianta.io._faults import join_faults
from pianta.io._files import one_line_reason, short_repr
from pianta.io.drawings._layers import check_plan_file, damage_as_plan_error, plan_error, require_library

if TYPE_CHECKING:
    from ifcopenshell import entity_instance, file


# Limits against hostile files.
MAX_FILE_BYTES = 256 * 2**20
MAX_SPACES = 5000
MAX_DOORS = 20_000
_MAX_PARENTS = 20  # from an element up to its storey

# Chosen by hand:
MAX_WALL = 1.0  # metres from the middle of a door to its room
_MIN_DEPTH = 0.05  # metres of a room in front of a door
_ROUNDING = 1e-4  # metres; smaller details of an outline are removed
_START, _END = b"ISO-10303-21;", b"END-ISO-10303-21;"


@dataclass(frozen=True)
class IfcStorey:
    """A storey that has rooms.

    floor: in metres of the model's world frame, x and y as in the file; rooms have names.
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
    """Read the storeys of an IFC (STEP) file that have spaces, from the lowest to the highest, with rooms and doors.

    storey: the name of the only one to read, in any case.

    A room is the footprint of a space, numbered from 1 in the order of the file, with its LongName or else its Name;
    spaces made of spaces, outer ones and those of gross areas are left out. The line of a door is as long as the
    opening that it fills, or else as its own shape; its width is OverallWidth. It joins the spaces that it bounds
    (IfcRelSpaceBoundary of any level), and if these are fewer than two, the rooms on both its sides at most MAX_WALL
    metres away; with one room it is an entrance. Lengths are converted to metres by IfcUnitAssignment.

    One PlanWarning counts spaces and doors that cannot be located; they are left out.
    Raises PlanError, in one line, if ifcopenshell (pianta[bim]) is missing, and for a file that is no IFC, cut off,
    damaged, too large, or has no spaces with a shape, or no storey of that name.
    Source of the format: ISO 16739, through IfcOpenShell.
    """
    file = check_plan_file(path, max_bytes=MAX_FILE_BYTES)
    model = _open_model(file)
    with damage_as_plan_error(file, "IFC"):  # IfcOpenShell checks entities when they are used
        reader = _Reader(model, file)
        storeys = reader.read_storeys(storey)
    if reader.left_out:
        counts = join_faults([f"{count} {what}" for what, count in reader.left_out.items()])
        warnings.warn(f"plan {short_repr(file)} has {counts}, left out", PlanWarning, stacklevel=2)
    return storeys


def _open_model(file: Path) -> file:
    """The model in an IFC file; raises PlanError for a file that is no IFC or is cut off."""
    require_library(file, "ifcopenshell", "an IFC", "bim")
    import ifcopenshell

    with file.open("rb") as stream:
        start = stream.read(200)
        stream.seek(max(0, file.stat().st_size - 200))
        end = stream.read()
    if _START not in start:
        raise plan_error(file, "is no IFC, save it as .ifc (STEP), not zipped and not as XML")
    if _END not in end:
        raise plan_error(file, "is cut off, its last line is not END-ISO-10303-21; save it again")
    try:
        return ifcopenshell.open(file, format=".ifc")
    except Exception as exception:
        reason = one_line_reason(exception)
        raise plan_error(file, f"is no IFC or damaged, save it again as .ifc: {reason}") from exception


@dataclass
class _Reader:
    """Reads a model; left_out: counts of elements that are left out, by the reason."""

    model: file
    path: Path
    left_out: Counter[str] = field(default_factory=Counter)

    def read_storeys(self, only: str | None) -> list[IfcStorey]:
        """The storeys that have rooms, or the one of a name."""
        spaces = self._spaces_by_storey()
        names = {number: _name_of(self.model[number], prefer="Name") or f"storey {number}" for number in spaces}
        if only is not None:
            chosen = {number for number, name in names.items() if name.casefold() == only.strip().casefold()}
            if not chosen:
                storey_names = ", ".join(map(short_repr, names.values()))
                raise plan_error(self.path, f"has no storey {short_repr(only)}, it has {storey_names}")
            spaces = {number: spaces[number] for number in spaces if number in chosen}
        doors = self._doors_by_storey({space.id(): number for number in spaces for space in spaces[number]})
        storeys = [
            self._read_storey(number, names[number], storey_spaces, doors.get(number, []))
            for number, storey_spaces in spaces.items()
        ]
        storeys = [storey for storey in storeys if storey.floor.rooms]
        if not storeys:
            raise plan_error(self.path, "has no spaces with a shape, export their geometry with it")
        return sorted(storeys, key=lambda storey: storey.elevation)

    def _spaces_by_storey(self) -> dict[int, list[entity_instance]]:
        """Spaces that are rooms, in the order of the file, by the number of their storey."""
        spaces = _in_order(self.model.by_type("IfcSpace"))
        if len(spaces) > MAX_SPACES:
            raise plan_error(self.path, f"has {len(spaces)} spaces, give at most {MAX_SPACES}")
        if not spaces:
            raise plan_error(self.path, "has no spaces (IfcSpace), export the rooms with it")
        by_storey: dict[int, list[entity_instance]] = {}
        for space in filter(_is_room, spaces):
            storey = _storey_of(space)
            if storey is None:
                self.left_out["spaces on no storey"] += 1
            else:
                by_storey.setdefault(storey.id(), []).append(space)
        return by_storey

    def _doors_by_storey(self, storey_of_space: dict[int, int]) -> dict[int, list[entity_instance]]:
        """Doors by the number of their storey: that of a space that they bound, else the one that contains them."""
        doors = _in_order(self.model.by_type("IfcDoor"))
        if len(doors) > MAX_DOORS:
            raise plan_error(self.path, f"has {len(doors)} doors, give at most {MAX_DOORS}")
        by_storey: dict[int, list[entity_instance]] = {}
        for door in doors:
            bounded = (storey_of_space[space] for space, _ in _bounded_spaces(door) if space in storey_of_space)
            container = _storey_of(door)
            storey = next(bounded, None) or (container.id() if container is not None else None)
            if storey is not None:
                by_storey.setdefault(storey, []).append(door)
            else:
                self.left_out["doors on no storey"] += 1
        return by_storey

    def _read_storey(
        self, number: int, name: str, spaces: Sequence[entity_instance], doors: Sequence[entity_instance]
    ) -> IfcStorey:
        """A storey with its rooms and doors, metres; number: the id of its IfcBuildingStorey."""
        rooms: dict[int, Room] = {}
        for space in spaces:
            outline = self._footprint_of(space)
            if outline is None:
                self.left_out["spaces without a shape"] += 1
            else:
                rooms[space.id()] = Room(len(rooms) + 1, outline, name=_name_of(space, prefer="LongName"))
        floor_doors = [self._read_door(door, rooms) for door in doors] if rooms else []
        self.left_out += Counter({"doors that do not lead from a room to another or outside": floor_doors.count(None)})
        floor = Floor(tuple(rooms.values()), tuple(filter(None, floor_doors)), source=self.path.name)
        return IfcStorey(floor, name, self._elevation_of(self.model[number]))

    def _footprint_of(self, space: entity_instance) -> Polygon | None:
        """The area of a space from above, metres; only its largest part."""
        corners, faces = self._mesh_of(space)
        triangles = shapely.polygons(corners[faces][:, :, :2]) if len(faces) else np.array([])
        horizontal = triangles[shapely.area(triangles) > 0]
        if not len(horizontal):
            return None
        area = shapely.union_all(shapely.normalize(horizontal), grid_size=_ROUNDING).simplify(_ROUNDING)
        parts = [part for part in shapely.get_parts(area) if isinstance(part, Polygon) and part.is_valid]
        return max(parts, key=lambda part: part.area, default=None)

    def _mesh_of(self, product: entity_instance) -> tuple[Floats, NDArray[np.intp]]:
        """Corners, shape (N, 3), metres, and faces, shape (M, 3), of a product; empty if it has no shape."""
        from ifcopenshell import geom

        try:
            shape: Any = geom.create_shape(self._settings, product)
        except RuntimeError:
            return np.zeros((0, 3)), np.zeros((0, 3), np.intp)
        corners = np.array(shape.geometry.verts, float).reshape(-1, 3)
        faces = np.array(shape.geometry.faces, np.intp).reshape(-1, 3)
        return corners, faces[np.isfinite(corners[faces]).all(axis=(1, 2))]

    def _read_door(self, door: entity_instance, rooms: dict[int, Room]) -> Door | None:
        """A door between rooms, which are keyed by the numbers of their spaces; None if it joins none."""
        line, width = self._line_of_door(door)
        bounded = _bounded_spaces(door)
        joined = list(dict.fromkeys(rooms[space].id for space, _ in bounded if space in rooms))
        is_outer = any(boundary.startswith("EXTERNAL") for _, boundary in bounded)
        if len(joined) != 2 and not (len(joined) == 1 and is_outer):
            beside = rooms_beside(line, list(rooms.values()))
            joined = beside if beside else joined[:2]
        if not joined or (len(joined) == 2 and joined[0] == joined[1]):
            return None
        return Door((joined[0], joined[1] if len(joined) == 2 else None), line, width)

    def _line_of_door(self, door: entity_instance) -> tuple[LineString, float]:
        """From jamb to jamb, metres, through the middle of the opening or the door if it has a shape; and the width."""
        from ifcopenshell.util.placement import get_local_placement

        matrix = np.array(get_local_placement(door.ObjectPlacement), float)
        start, axes = matrix[:2, 3] * self._metres_per_unit, matrix[:2, :2]
        width = float(door.OverallWidth or 0) * self._metres_per_unit
        opening = next((fill.RelatingOpeningElement for fill in door.FillsVoids), None)
        meshes = (self._mesh_of(product)[0] for product in (opening, door) if product is not None)
        corners = next((mesh for mesh in meshes if len(mesh)), None)
        if corners is None:
            ends = np.array([[0, 0], [width or DOOR_WIDTH, 0]])
        else:
            local = (corners[:, :2] - start) @ axes
            low, high = local.min(axis=0), local.max(axis=0)
            longer = int(high[1] - low[1] > high[0] - low[0])
            ends = np.tile((low + high) / 2, (2, 1))
            ends[:, longer] = low[longer], high[longer]
        line = LineString(start + ends @ axes.T)
        return line, width if isfinite(width) and width > 0 else float(line.length)

    def _elevation_of(self, storey: entity_instance) -> float:
        """Height of a storey, metres; 0 if the file does not give it."""
        elevation = storey.Elevation
        return float(elevation) * self._metres_per_unit if elevation is not None and isfinite(elevation) else 0.0

    @cached_property
    def _metres_per_unit(self) -> float:
        """Metres per unit of length of the file."""
        from ifcopenshell.util.unit import calculate_unit_scale

        return float(calculate_unit_scale(self.model))

    @cached_property
    def _settings(self) -> Any:  # noqa: ANN401  # made by a library without types
        """Settings by which ifcopenshell computes shapes, in the coordinates of the whole model."""
        from ifcopenshell import geom

        settings = geom.settings()
        settings.set("use-world-coords", True)  # noqa: FBT003
        return settings


def _in_order(entities: Sequence[entity_instance]) -> list[entity_instance]:
    """Entities in the order of their numbers in the file."""
    return sorted(entities, key=lambda entity: entity.id())


def _is_room(space: entity_instance) -> bool:
    """Whether a space contains no other space, is inside, and is no gross floor area."""
    parts = (part for relation in space.IsDecomposedBy for part in relation.RelatedObjects)
    types = {getattr(space, name, None) for name in ("PredefinedType", "InteriorOrExteriorSpace")}
    return not any(part.is_a("IfcSpace") for part in parts) and types.isdisjoint({"EXTERNAL", "GFA"})


def _storey_of(element: entity_instance) -> entity_instance | None:
    """The storey that contains an element, directly or through other elements."""
    parent: entity_instance | None = element
    for _ in range(_MAX_PARENTS):
        if parent is None or parent.is_a("IfcBuildingStorey"):
            return parent
        parent = next(_parents_of(parent), None)
    return None


def _parents_of(element: entity_instance) -> Iterator[entity_instance]:
    """What contains an element, directly: storeys and other structures, then the elements that it is a part of."""
    yield from (relation.RelatingStructure for relation in getattr(element, "ContainedInStructure", ()))
    yield from (relation.RelatingObject for relation in getattr(element, "Decomposes", ()))


def _bounded_spaces(door: entity_instance) -> list[tuple[int, str]]:
    """The numbers of the spaces that a door bounds, and whether each boundary is INTERNAL or EXTERNAL."""
    relations = sorted(door.ProvidesBoundaries, key=lambda relation: relation.id())
    spaces = ((relation.RelatingSpace, relation.InternalOrExternalBoundary) for relation in relations)
    return [(space.id(), str(boundary)) for space, boundary in spaces if space is not None and space.is_a("IfcSpace")]


def _name_of(entity: entity_instance, *, prefer: str) -> str | None:
    """Its LongName or Name on one line, the preferred one where it has both."""
    names = (getattr(entity, name, None) for name in (prefer, "LongName", "Name"))
    plain = ("".join(filter(str.isprintable, " ".join(str(name or "").split()))) for name in names)
    return next((name[:MAX_ROOM_NAME_LENGTH].strip() for name in plain if name.strip()), None)


def rooms_beside(line: LineString, rooms: Sequence[Room]) -> list[int]:
    """The ids of the rooms on both sides of a door: those with the longest share of MAX_WALL metres in front of it.

    The ids are equal if the same room is on both sides.
    """
    ends = shapely.get_coordinates(line)
    along = ends[1] - ends[0]
    length = np.hypot(*along)
    if not np.isfinite(length) or length == 0 or not rooms:
        return []
    outlines = np.array([room.polygon for room in rooms])
    beside = []
    for side in (-1, 1):
        across = np.array([-along[1], along[0]]) * side * MAX_WALL / length
        ray = LineString([ends.mean(axis=0), ends.mean(axis=0) + across])
        depths = shapely.length(shapely.intersection(outlines, ray))
        if depths.max() > _MIN_DEPTH:
            beside.append(rooms[int(depths.argmax())].id)
    return beside
