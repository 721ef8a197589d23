"""IFC models for tests, built with ifcopenshell, in millimetres by default."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from pianta.io.drawings.ifc import IfcStorey, read_ifc_plan

Point = tuple[float, float]
Corners = Sequence[Point]


class Model:
    """An IFC under construction, of one building, in millimetres by default."""

    def __init__(self, *, schema: Any = "IFC4", prefix: str | None = "MILLI") -> None:
        from ifcopenshell.api import aggregate, context, owner, project, root, unit

        self.file = project.create_file(version=schema)
        if schema == "IFC2X3":  # which knows no anonymous authors
            person, group = owner.add_person(self.file), owner.add_organisation(self.file)
            owner.add_person_and_organisation(self.file, person=person, organisation=group)
            owner.add_application(self.file)
        container = root.create_entity(self.file, ifc_class="IfcProject", name="Project")
        unit.assign_unit(self.file, units=[unit.add_si_unit(self.file, unit_type="LENGTHUNIT", prefix=prefix)])
        model = context.add_context(self.file, context_type="Model")
        self.body = context.add_context(
            self.file, context_type="Model", context_identifier="Body", target_view="MODEL_VIEW", parent=model
        )
        self.site, self.building = (
            root.create_entity(self.file, ifc_class=f"Ifc{ifc_type}") for ifc_type in ("Site", "Building")
        )
        for part, outer in pairwise([self.building, self.site, container]):
            aggregate.assign_object(self.file, products=[part], relating_object=outer)

    def storey(self, name: str = "Ground", elevation: float = 0.0) -> Any:
        return self.part("IfcBuildingStorey", self.building, Name=name, Elevation=elevation)

    def part(self, ifc_type: str, container: Any, **attributes: object) -> Any:
        from ifcopenshell.api import aggregate, root

        entity = root.create_entity(self.file, ifc_class=ifc_type)
        for name, value in attributes.items():
            setattr(entity, name, value)
        aggregate.assign_object(self.file, products=[entity], relating_object=container)
        return entity

    def space(
        self, storey: Any, corners: Corners | None, *, at: Point = (0, 0), turn: float = 0.0, **attributes: object
    ) -> Any:
        """A space over corners, or one without a shape."""
        space = self.part("IfcSpace", storey, **attributes)
        if corners:
            self.shape(space, corners)
        self.locate(space, at, turn)
        return space

    def shape(self, product: Any, corners: Corners, *, low: float = 0.0, height: float = 3000.0) -> None:
        """Extrude corners from a height above the placement of the product."""
        from ifcopenshell.api import geometry

        points = [self.file.createIfcCartesianPoint(tuple(map(float, corner))) for corner in [*corners, corners[0]]]
        profile = self.file.createIfcArbitraryClosedProfileDef("AREA", None, self.file.createIfcPolyline(points))
        origin = self.file.createIfcAxis2Placement3D(self.file.createIfcCartesianPoint((0.0, 0.0, low)))
        up = self.file.createIfcDirection((0.0, 0.0, 1.0))
        solid = self.file.createIfcExtrudedAreaSolid(profile, origin, up, height)
        body = self.file.createIfcShapeRepresentation(self.body, "Body", "SweptSolid", [solid])
        geometry.assign_representation(self.file, product=product, representation=body)

    def locate(self, product: Any, at: Point, turn: float) -> None:
        from ifcopenshell.api import geometry

        matrix = np.eye(4)
        matrix[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        matrix[:2, 3] = at
        geometry.edit_object_placement(self.file, product=product, matrix=matrix, is_si=False)

    def door(
        self,
        storey: Any,
        at: Point,
        *,
        width: float | None = 900.0,
        turn: float = np.pi / 2,
        bounding: Sequence[Any] = (),
        boundary: str = "INTERNAL",
    ) -> Any:
        """A door without a shape that runs from a point, to the north unless turned."""
        from ifcopenshell.api import root, spatial

        door = root.create_entity(self.file, ifc_class="IfcDoor")
        door.OverallWidth = width
        if storey is not None:
            spatial.assign_container(self.file, products=[door], relating_structure=storey)
        self.locate(door, at, turn)
        for space in bounding:
            relation = root.create_entity(self.file, ifc_class=self.boundary_class)
            relation.RelatingSpace, relation.RelatedBuildingElement = space, door
            relation.PhysicalOrVirtualBoundary, relation.InternalOrExternalBoundary = "PHYSICAL", boundary
        return door

    boundary_class = "IfcRelSpaceBoundary"

    def read(self, path: Path, **options: str) -> list[IfcStorey]:
        self.file.write(str(path))
        return read_ifc_plan(path, **options)

    def element(
        self,
        ifc_type: str,
        storey: Any,
        corners: Corners,
        *,
        low: float = 0.0,
        height: float = 3000.0,
        **attributes: object,
    ) -> Any:
        """A wall, a slab or another element of a storey, over corners."""
        from ifcopenshell.api import root, spatial

        element = root.create_entity(self.file, ifc_class=ifc_type)
        for name, value in attributes.items():
            setattr(element, name, value)
        spatial.assign_container(self.file, products=[element], relating_structure=storey)
        self.shape(element, corners, low=low, height=height)
        self.locate(element, (0, 0), 0)
        return element

    def opening(self, wall: Any, corners: Corners, *, low: float = 0.0, height: float = 2000.0) -> Any:
        """An opening of a wall, which nothing fills."""
        from ifcopenshell.api import feature, root

        opening = root.create_entity(self.file, ifc_class="IfcOpeningElement")
        self.shape(opening, corners, low=low, height=height)
        self.locate(opening, (0, 0), 0)
        feature.add_feature(self.file, feature=opening, element=wall)
        return opening

    def fill(self, opening: Any, door: Any) -> None:
        from ifcopenshell.api import feature

        feature.add_filling(self.file, opening=opening, element=door)

    def bound(self, space: Any, element: Any, *, ifc_class: str = "IfcRelSpaceBoundary", **attributes: object) -> Any:
        """A virtual boundary of a space unless the attributes say otherwise."""
        from ifcopenshell.api import root

        relation = root.create_entity(self.file, ifc_class=ifc_class)
        relation.RelatingSpace, relation.RelatedBuildingElement = space, element
        values = {"PhysicalOrVirtualBoundary": "VIRTUAL", "InternalOrExternalBoundary": "INTERNAL", **attributes}
        for name, value in values.items():
            setattr(relation, name, value)
        return relation

    def upright(self, start: Point, end: Point) -> Any:
        """The geometry of an upright boundary, 3000 high, in the frame of its space."""
        point, direction = self.file.createIfcCartesianPoint, self.file.createIfcDirection
        length = float(np.hypot(end[0] - start[0], end[1] - start[1]))
        along = ((end[0] - start[0]) / length, (end[1] - start[1]) / length, 0.0)
        normal = (along[1], -along[0], 0.0)
        frame = self.file.createIfcAxis2Placement3D(
            point((*map(float, start), 0.0)), direction(normal), direction(along)
        )
        corners = [(0.0, 0.0), (length, 0.0), (length, 3000.0), (0.0, 3000.0), (0.0, 0.0)]
        outline = self.file.createIfcPolyline([point(corner) for corner in corners])
        surface = self.file.createIfcCurveBoundedPlane(self.file.createIfcPlane(frame), outline, [])
        return self.file.createIfcConnectionSurfaceGeometry(surface, None)

    def set_properties(self, product: Any, group: str, **properties: object) -> None:
        from ifcopenshell.api import pset

        added = pset.add_pset(self.file, product=product, name=group)
        pset.edit_pset(self.file, pset=added, properties=properties)
