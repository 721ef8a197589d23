"""What of an IFC is outside, or no usual room: where doors lead, and which spaces are balconies, attics or roofs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely import LineString, Point
from shapely.geometry.base import BaseGeometry

from pianta.floor import BALCONY_FLAG, OUTSIDE_FLAG
from pianta.io.drawings._flags_by_name import find_flag_in_name
from pianta.io.drawings._ifc_model import IfcModel, list_boundaries, read_property, read_text
from pianta.io.drawings._ifc_walls import CUT, Walls, fill_holes

if TYPE_CHECKING:
    from ifcopenshell import entity_instance

LOW = "low"

# Chosen by hand:
BELOW_GROUND = -0.5  # metres; a storey below this is a basement
MAX_STEPS = 1.5  # metres from the ground up to the floor behind an outer door, by outer steps
NEAR_ZERO = 2.5  # metres; where no storey is lower, heights are above the sea and not above the ground
MIN_HEADROOM = 1.5  # metres; people do not stand below it
BEYOND = 1.0  # metres from a door to where it leads


def find_flag(space: entity_instance, *, height: float, is_ground: bool) -> str | None:
    """Why people may not count a space as a room; None for a usual one. height: of its body, metres."""
    types = {str(getattr(space, name, None)) for name in ("PredefinedType", "InteriorOrExteriorSpace")}
    name = " ".join(filter(None, (read_text(space, each) for each in ("LongName", "Name", "ObjectType"))))
    flag = OUTSIDE_FLAG if any(each.startswith("EXTERNAL") for each in types) else find_flag_in_name(name)
    if flag == OUTSIDE_FLAG and not is_ground:
        return BALCONY_FLAG
    return LOW if flag is None and 0 < height < MIN_HEADROOM else flag


@dataclass
class Outside:
    """Where the outside of a model is."""

    model: IfcModel
    walls: Walls

    def is_ground(self, storey: entity_instance) -> bool:
        """Whether one can leave a storey without stairs: it is at most MAX_STEPS above the ground."""
        return self.model.elevation_of(storey) <= self._ground_of(storey) + MAX_STEPS

    def leads_out(self, door: entity_instance, line: LineString, inner: BaseGeometry, storey: entity_instance) -> bool:
        """Whether a door of one room leads to the ground outside; inner: the outline of the room, metres.

        Upstairs only a fire exit does. At the ground the file says it (IsExternal, a boundary), or else
        walls around what is beyond the door show that it is inside.
        """
        is_external = read_property(door, "Pset_DoorCommon", "IsExternal") is True
        if not self.is_ground(storey):
            return is_external and read_property(door, "Pset_DoorCommon", "FireExit") is True
        boundaries = list_boundaries(door)
        sides = {str(each.InternalOrExternalBoundary) for each in boundaries}
        if is_external or any(side.startswith("EXTERNAL") for side in sides):
            return True
        if sides == {"INTERNAL"}:
            return False
        return not self.outline_of(storey).contains(_step_through(line, inner))

    def outline_of(self, storey: entity_instance) -> BaseGeometry:
        """The area within the walls of a storey, metres."""
        return fill_holes(self.cut_of(storey, self.model.base_of(storey)))

    def cut_of(self, storey: entity_instance, base: float) -> BaseGeometry:
        """The walls of a storey, whose floor is at a height, metres."""
        if storey.id() not in self._cuts:
            self._cuts[storey.id()] = self.walls.cut(base + CUT)
        return self._cuts[storey.id()]

    @cached_property
    def _cuts(self) -> dict[int, BaseGeometry]:
        return {}

    def _ground_of(self, storey: entity_instance) -> float:
        """The height of the ground floor of the building of a storey, metres, as the file states it."""
        building = _parent_of(storey)
        own = [each for each in self.model.storeys if _parent_of(each) == building] or [storey]
        heights = sorted(height for each in own if (height := self.model.elevation_of(each)) >= BELOW_GROUND)
        if not heights:
            return max(map(self.model.elevation_of, own))
        if heights[0] <= NEAR_ZERO:
            return heights[0]
        return min((height for height in heights if height in self._outer_heights), default=heights[0])

    @cached_property
    def _outer_heights(self) -> set[float]:
        """The heights of storeys that have a door which the file calls external."""
        doors = self.model.list_products("IfcDoor")
        outer = [door for door in doors if read_property(door, "Pset_DoorCommon", "IsExternal") is True]
        storeys = [self.model.storey_of(door) for door in outer]
        return {self.model.elevation_of(storey) for storey in storeys if storey is not None}


def _parent_of(storey: entity_instance) -> int | None:
    return next((relation.RelatingObject.id() for relation in getattr(storey, "Decomposes", ())), None)


def _step_through(line: LineString, inner: BaseGeometry) -> Point:
    """The point BEYOND a door, on the side where its room is not."""
    ends = shapely.get_coordinates(line)
    along = ends[-1] - ends[0]
    across = np.array([-along[1], along[0]]) * BEYOND / (np.hypot(*along) or 1.0)
    sides = [Point(ends.mean(axis=0) + across), Point(ends.mean(axis=0) - across)]
    return max(sides, key=lambda side: side.distance(inner))
