"""An IFC model as its readers need it: texts, storeys, placements and shapes in metres of the model's world frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from pianta._types import Floats
from pianta.floor import MAX_ROOM_NAME_LENGTH
from pianta.io.drawings._layers import plan_error

if TYPE_CHECKING:
    from ifcopenshell import entity_instance, file

# Limits against hostile files.
MAX_TRIANGLES = 20_000_000  # of all shapes together; 1.5 GB
_MAX_PARENTS = 20  # from an element up to its storey
_GLOBAL_ID_LENGTH = 22  # characters, ISO 16739

# Chosen by hand:
ROUNDING = 1e-4  # metres; smaller details of an outline are removed
SURFACE_THICKNESS = 0.02  # metres, of shapes that are no solids
STAND_ABOVE = 0.5  # metres that the foot of an element may be below its storey


@dataclass(frozen=True)
class Shape:
    """The triangles of a product. corners: shape (N, 3), metres; faces: shape (M, 3), of corners."""

    corners: Floats
    faces: NDArray[np.intp]

    @property
    def low(self) -> float:
        """Height of its lowest corner, metres; infinite without corners."""
        return float(self.corners[:, 2].min(initial=np.inf))

    @property
    def high(self) -> float:
        """Height of its highest corner, metres."""
        return float(self.corners[:, 2].max(initial=-np.inf))

    def project(self, *, low: float = -np.inf, high: float = np.inf) -> BaseGeometry:
        """Its area from above, metres, of the triangles that are as a whole between two heights."""
        triangles = self.corners[self.faces]
        heights = triangles[:, :, 2]
        chosen = triangles[(heights >= low).all(axis=1) & (heights <= high).all(axis=1)][:, :, :2]
        areas = shapely.polygons(chosen) if len(chosen) else np.array([])
        horizontal = areas[shapely.area(areas) > 0]
        union: BaseGeometry = shapely.union_all(shapely.normalize(horizontal), grid_size=ROUNDING)
        return union.simplify(ROUNDING)

    def cut(self, height: float) -> BaseGeometry:
        """Its area at a height, metres; surfaces without a volume get a thickness."""
        triangles = self.corners[self.faces]
        # A corner at the very height counts as above it
        above = triangles[:, :, 2] >= height
        triangles, above = triangles[above.any(axis=1) & ~above.all(axis=1)], above[above.any(1) & ~above.all(1)]
        if not len(triangles):
            return Polygon()
        # The corner that is alone on its side is between the two edges that are cut
        alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
        rows = np.arange(len(triangles))
        tip, others = triangles[rows, alone], [triangles[rows, (alone + step) % 3] for step in (1, 2)]
        shares = [(height - tip[:, 2]) / (other[:, 2] - tip[:, 2]) for other in others]
        ends = [tip + (other - tip) * share[:, None] for other, share in zip(others, shares, strict=True)]
        segments = np.round(np.stack(ends, axis=1)[:, :, :2], 5)
        segments = segments[(segments[:, 0] != segments[:, 1]).any(axis=1)]
        lines = shapely.union_all(shapely.linestrings(segments)) if len(segments) else Polygon()
        area: BaseGeometry = shapely.build_area(lines)
        return area if not area.is_empty else lines.buffer(SURFACE_THICKNESS / 2)


NO_SHAPE = Shape(np.zeros((0, 3)), np.zeros((0, 3), np.intp))


@dataclass
class IfcModel:
    """A model with the shapes that were computed so far."""

    file: file
    path: Path
    _shapes: dict[int, Shape] = field(default_factory=dict)
    _triangles: int = 0

    def list_products(self, *types: str) -> list[entity_instance]:
        """The entities of some types, in the order of their numbers in the file."""
        by_number: dict[int, entity_instance] = {}
        for ifc_type in types:
            by_number |= {entity.id(): entity for entity in self._list_type(ifc_type)}
        return [by_number[number] for number in sorted(by_number)]

    def _list_type(self, ifc_type: str) -> Sequence[entity_instance]:
        try:
            return [*self.file.by_type(ifc_type)]
        except RuntimeError:  # a type that the schema of the file does not have
            return ()

    def shape_of(self, product: entity_instance) -> Shape:
        """The shape of a product, in the frame of the whole model; NO_SHAPE if it has none."""
        number = product.id()
        if number not in self._shapes:
            self._shapes[number] = self._compute(product)
            self._triangles += len(self._shapes[number].faces)
            if self._triangles > MAX_TRIANGLES:
                raise plan_error(self.path, f"has shapes of more than {MAX_TRIANGLES:,} triangles, give a part of it")
        return self._shapes[number]

    def _compute(self, product: entity_instance) -> Shape:
        from ifcopenshell import geom

        if product.Representation is None:
            return NO_SHAPE
        try:
            shape: Any = geom.create_shape(self._settings, product)
        except RuntimeError:
            return NO_SHAPE
        corners = np.array(shape.geometry.verts, float).reshape(-1, 3)
        faces = np.array(shape.geometry.faces, np.intp).reshape(-1, 3)
        return Shape(corners, faces[np.isfinite(corners[faces]).all(axis=(1, 2))])

    def outline_of(self, product: entity_instance) -> BaseGeometry:
        """The area within the curves of a product that is drawn in two dimensions, metres."""
        from ifcopenshell import geom

        representations = product.Representation.Representations if product.Representation else ()
        for representation in representations:
            try:
                shape: Any = geom.create_shape(self._curve_settings, product, representation)
            except RuntimeError:
                continue
            geometry = getattr(shape, "geometry", shape)
            corners = np.array(geometry.verts, float).reshape(-1, 3)[:, :2]
            edges = np.array(geometry.edges, np.intp).reshape(-1, 2)
            lines = shapely.linestrings(corners[edges]) if len(edges) else np.array([])
            area = shapely.build_area(shapely.union_all(lines[shapely.length(lines) > 0]))
            if not area.is_empty:
                return area.simplify(ROUNDING)
        return Polygon()

    def locate(self, product: entity_instance) -> Floats:
        """The placement of a product: shape (4, 4), metres."""
        from ifcopenshell.util.placement import get_local_placement

        matrix = np.array(get_local_placement(product.ObjectPlacement), float)
        matrix[:3, 3] *= self.metres_per_unit
        return matrix

    @cached_property
    def metres_per_unit(self) -> float:
        """Metres per unit of length of the file."""
        from ifcopenshell.util.unit import calculate_unit_scale

        return float(calculate_unit_scale(self.file))

    @cached_property
    def storeys(self) -> list[entity_instance]:
        """All storeys, in the order of the file."""
        return self.list_products("IfcBuildingStorey")

    def storey_of(self, element: entity_instance) -> entity_instance | None:
        """What contains an element: its storey, or else the storey at its height, or else its building or site."""
        parent: entity_instance | None = element
        outer = None
        for _ in range(_MAX_PARENTS):
            if parent is None or parent.is_a("IfcBuildingStorey"):
                break
            outer = parent if outer is None and parent.is_a() in {"IfcBuilding", "IfcSite"} else outer
            parent = next(_parents_of(parent), None)
        else:
            return None
        if parent is not None or outer is None:
            return parent
        return self._storey_at(element) or outer

    def _storey_at(self, element: entity_instance) -> entity_instance | None:
        """The highest storey that is not above the foot of an element, else the lowest; None without storeys."""
        low = self.shape_of(element).low
        foot = low if isfinite(low) else float(self.locate(element)[2, 3])
        heights = {storey.id(): self.base_of(storey) for storey in self.storeys}
        below = [storey for storey in self.storeys if heights[storey.id()] <= foot + STAND_ABOVE]
        if below:
            return max(below, key=lambda storey: heights[storey.id()])
        return min(self.storeys, key=lambda storey: heights[storey.id()], default=None)

    def base_of(self, storey: entity_instance) -> float:
        """Height of a storey in the frame of shapes, metres."""
        if storey.ObjectPlacement is None:
            return self.elevation_of(storey)
        return float(self.locate(storey)[2, 3])

    def elevation_of(self, storey: entity_instance) -> float:
        """Height of a storey as the file states it, metres; else that of its placement, or 0."""
        elevation = getattr(storey, "Elevation", None)
        if elevation is not None and isfinite(elevation):
            return float(elevation) * self.metres_per_unit
        return float(self.locate(storey)[2, 3]) if storey.ObjectPlacement is not None else 0.0

    @cached_property
    def _settings(self) -> Any:  # noqa: ANN401  # made by a library without types
        """Settings by which ifcopenshell computes shapes, in the coordinates of the whole model."""
        from ifcopenshell import geom

        settings = geom.settings()
        settings.set("use-world-coords", True)  # noqa: FBT003
        return settings

    @cached_property
    def _curve_settings(self) -> Any:  # noqa: ANN401  # made by a library without types
        """The same for curves."""
        from ifcopenshell import geom, ifcopenshell_wrapper

        settings = geom.settings()
        settings.set("use-world-coords", True)  # noqa: FBT003
        settings.set("dimensionality", ifcopenshell_wrapper.CURVES_SURFACES_AND_SOLIDS)
        return settings


def read_text(entity: entity_instance, name: str) -> str | None:
    """An attribute on one line, without characters that cannot be printed; None if nothing remains."""
    value = getattr(entity, name, None)
    plain = "".join(filter(str.isprintable, " ".join(str(value or "").split())))
    return plain[:MAX_ROOM_NAME_LENGTH].strip() or None


def read_global_id(entity: entity_instance) -> str | None:
    """The GlobalId; None for one that is not as long as the standard says."""
    text = read_text(entity, "GlobalId")
    return text if text is not None and len(text) == _GLOBAL_ID_LENGTH else None


def read_property(entity: entity_instance, group: str, name: str) -> object:
    """The value of a property of a property set, of the entity or its type; None if it is not there."""
    from ifcopenshell.util.element import get_pset

    return get_pset(entity, group, name)


def list_boundaries(element: entity_instance) -> list[entity_instance]:
    """The boundaries of spaces that an element makes, in the order of the file."""
    return sorted(getattr(element, "ProvidesBoundaries", ()), key=lambda relation: relation.id())


def list_parts(element: entity_instance) -> list[entity_instance]:
    """What an element is made of, directly."""
    return [part for relation in getattr(element, "IsDecomposedBy", ()) for part in relation.RelatedObjects]


def _parents_of(element: entity_instance) -> Iterator[entity_instance]:
    """What contains an element, directly: storeys and other structures, then the elements that it is a part of."""
    yield from (relation.RelatingStructure for relation in getattr(element, "ContainedInStructure", ()))
    yield from (relation.RelatingObject for relation in getattr(element, "Decomposes", ()))
    # An opening is where its wall is, and a door where its opening is
    yield from (relation.RelatingBuildingElement for relation in getattr(element, "VoidsElements", ()))
    yield from (relation.RelatingOpeningElement for relation in getattr(element, "FillsVoids", ()))
