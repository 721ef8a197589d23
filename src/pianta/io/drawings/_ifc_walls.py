"""Rooms from the walls, slabs, doors and windows of an IFC, for models without spaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from pianta.floor.polygons import list_polygons
from pianta.io.drawings._ifc_model import ROUNDING, IfcModel, Shape
from pianta.io.drawings._layers import plan_error

if TYPE_CHECKING:
    from ifcopenshell import entity_instance

# What closes a room. Coverings are layers of walls in some models, and slabs and roofs the walls of an attic.
BARRIERS = (
    *("IfcWall", "IfcCurtainWall", "IfcPlate", "IfcMember", "IfcWindow", "IfcDoor", "IfcColumn", "IfcCovering"),
    *("IfcRoof", "IfcSlab"),
)
FLOORS = ("IfcSlab", "IfcCovering", "IfcFooting", "IfcRoof")
MAX_BARRIERS = 50_000  # against hostile files

# Metres above the floor, chosen by hand:
CUT = 1.0  # plans are cut there: above sills and parapets, below the heads of doors
MIN_STOREY = 1.0  # storeys that are closer are one storey with several reference heights
FLOOR_BELOW, FLOOR_ABOVE = 0.6, 0.4  # where the slab of a storey is
# Metres of a plan, chosen by hand:
MAX_GAP = 0.1  # between walls that should meet
MAX_OPENING = 2.0  # a wider opening without a door makes one room of two, as a double door is narrower
# People count no shaft or cupboard below this area (m²), and none in which they cannot turn (width, metres).
MIN_ROOM, MIN_WIDTH = 1.0, 0.6
MIN_FLOOR_SHARE = 0.5  # of a room; shafts and the upper parts of halls have none


@dataclass(frozen=True)
class WalledStorey:
    """A storey that has walls. base: height of its floor in the frame of shapes, metres."""

    entity: entity_instance
    base: float


@dataclass
class Walls:
    """The walls of a model, and the rooms between them."""

    model: IfcModel

    @cached_property
    def barriers(self) -> list[tuple[entity_instance, Shape]]:
        """What closes rooms, with its shape."""
        products = self.model.list_products(*BARRIERS)
        if len(products) > MAX_BARRIERS:
            raise plan_error(self.model.path, f"has {len(products)} walls and slabs, give at most {MAX_BARRIERS}")
        shapes = ((product, self.model.shape_of(product)) for product in products)
        return [(product, shape) for product, shape in shapes if len(shape.faces)]

    @cached_property
    def openings(self) -> list[tuple[entity_instance, Shape]]:
        """The openings of walls, with their shapes."""
        hosts = {"IfcWall", "IfcCovering", "IfcCurtainWall", "IfcPlate"}
        voids = []
        for opening in self.model.list_products("IfcOpeningElement"):
            voided = [relation.RelatingBuildingElement for relation in opening.VoidsElements]
            if any(element.is_a(host) for element in voided for host in hosts):
                voids.append((opening, self.model.shape_of(opening)))
        return voids

    def list_storeys(self) -> list[WalledStorey]:
        """The storeys with walls or doors, from below; of those closer than MIN_STOREY the one with the most."""
        counts: dict[int, int] = {}
        doors: dict[int, list[float]] = {}
        for product in self.model.list_products("IfcWall", "IfcDoor"):
            storey = self.model.storey_of(product)
            if storey is not None:
                counts[storey.id()] = counts.get(storey.id(), 0) + 1
                if product.is_a("IfcDoor"):
                    doors.setdefault(storey.id(), []).append(self.model.shape_of(product).low)
        storeys = [self._place_storey(self.model.file[number], doors.get(number, [])) for number in counts]
        separate: list[WalledStorey] = []
        for storey in sorted(storeys, key=lambda each: -counts[each.entity.id()]):
            if all(abs(storey.base - other.base) >= MIN_STOREY for other in separate):
                separate.append(storey)
        return sorted(separate, key=lambda each: each.base)

    def _place_storey(self, entity: entity_instance, doors: Sequence[float]) -> WalledStorey:
        """The storey on which its doors stand; files have heights of storeys that their shapes do not have."""
        base, feet = self.model.base_of(entity), np.array([foot for foot in doors if np.isfinite(foot)])
        is_near = len(feet) == 0 or np.abs(feet - base).min() <= FLOOR_BELOW
        return WalledStorey(entity, base if is_near else float(np.median(feet)))

    def cut(self, height: float) -> BaseGeometry:
        """What closes rooms at a height, with its doors, windows and narrow openings shut; metres."""
        crossed = [(product, shape) for product, shape in self.barriers if shape.low < height < shape.high]
        parts = [
            self._shut(product, shape) if product.is_a("IfcDoor") else shape.cut(height) for product, shape in crossed
        ]
        for opening, shape in self.openings:
            if shape.low < height < shape.high:
                closed = self._clip(shape.project(), opening)
                if opening.HasFillings or measure_length(closed) <= MAX_OPENING:
                    parts.append(closed)
        solid = shapely.union_all([part for part in parts if not part.is_empty], grid_size=ROUNDING)
        half = MAX_GAP / 2
        closed = solid.buffer(half, join_style="mitre").buffer(-half, join_style="mitre")
        return shapely.union_all(list_polygons(shapely.union_all([solid, closed])))

    def _shut(self, door: entity_instance, shape: Shape) -> BaseGeometry:
        """The rectangle of a door, in its wall; in some files only this is at its place, and the opening is not."""
        area = shape.project().minimum_rotated_rectangle
        opening = next((relation.RelatingOpeningElement for relation in door.FillsVoids), None)
        return area if opening is None else self._clip(area, opening)

    def _clip(self, area: BaseGeometry, opening: entity_instance) -> BaseGeometry:
        """The part of an area that is in the walls of an opening, which is often deeper than they are."""
        hosts = (relation.RelatingBuildingElement for relation in opening.VoidsElements)
        around = [self.model.shape_of(host).project().convex_hull for host in hosts]
        walls = shapely.union_all([hull for hull in around if not hull.is_empty])
        return area if walls.is_empty else area.intersection(walls)

    def find_rooms(self, storey: WalledStorey) -> list[Polygon]:
        """The outlines of the rooms of a storey, metres, from the largest."""
        solid = self.cut(storey.base + CUT)
        free = fill_holes(solid).difference(solid)
        candidates = [part for part in list_polygons(free) if _is_wide(part)]
        floor = self._project_floor(storey)
        rooms = [
            room
            for room in candidates
            if floor.is_empty or room.intersection(floor).area >= MIN_FLOOR_SHARE * room.area
        ]
        outlines = (room.simplify(ROUNDING) for room in rooms)
        return sorted((each for each in outlines if isinstance(each, Polygon)), key=lambda room: -room.area)

    def _project_floor(self, storey: WalledStorey) -> BaseGeometry:
        """The area of the slabs of a storey, metres; empty if the model has none there."""
        low, high = storey.base - FLOOR_BELOW, storey.base + FLOOR_ABOVE
        parts = [
            shape.project(low=low, high=high)
            for product, shape in self.barriers
            if any(product.is_a(each) for each in FLOORS) and shape.low < high and shape.high > low
        ]
        return shapely.union_all([part for part in parts if not part.is_empty])


def fill_holes(area: BaseGeometry) -> BaseGeometry:
    """An area with what it encloses."""
    filled: BaseGeometry = shapely.union_all([Polygon(part.exterior) for part in list_polygons(area)])
    return filled


def measure_length(area: BaseGeometry) -> float:
    """The longer side of an area, metres."""
    rectangle = area.minimum_rotated_rectangle
    if not isinstance(rectangle, Polygon) or rectangle.is_empty:
        return float(rectangle.length)
    sides = np.hypot(*np.diff(shapely.get_coordinates(rectangle.exterior)[:3], axis=0).T)
    return float(sides.max(initial=0))


def _is_wide(room: Polygon) -> bool:
    return room.area >= MIN_ROOM and not room.buffer(-MIN_WIDTH / 2).is_empty
