"""IFC4: project, site, building and storeys; rooms are spaces with quantities, walls have openings, doors fill them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import NAMESPACE_URL, uuid5

import numpy as np
import shapely
from shapely import Polygon, box

from pianta._types import Floats
from pianta.building import Building, Storey
from pianta.floor import BALCONY_FLAG, OUTSIDE_FLAG, Door, Room
from pianta.io._files import count_noun
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.room_texts import number_and_name, title_storey
from pianta.io.writers.storey_heights import list_elevations
from pianta.io.writers.wall_parts import DOOR_HEIGHT, WALL_HEIGHT, WallPart, door_depth, find_walls

if TYPE_CHECKING:
    from ifcopenshell import entity_instance, file

SCHEMA = "IFC4"
PRECISION = 1e-5  # metres, of geometry; the value that BIM programs write
WRITTEN = "1970-01-01T00:00:00"  # in the header
LEAF_THICKNESS = 0.04  # metres, of a usual door
FURNITURE_HEIGHT = 0.75  # metres, of a table
GLOBAL_ID = re.compile(r"[0-3][0-9A-Za-z_$]{21}")  # 128 bits in base 64, ISO 16739


def write_ifc(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """A building model in metres; the identifiers of the same building are the same."""
    import ifcopenshell

    model = _Model(ifcopenshell.file(schema=SCHEMA), building.name)
    project, site = model.add("IfcProject", "project", Name=building.name or "Building"), model.add("IfcSite", "site")
    project.UnitsInContext = model.make_units()
    project.RepresentationContexts = [model.context]
    house = model.add("IfcBuilding", "building", Name=building.name or None, CompositionType="ELEMENT")
    for parent, part in ((project, site), (site, house)):
        model.relate("IfcRelAggregates", RelatingObject=parent, RelatedObjects=[part])
    elevations, notes = list_elevations(building)
    storeys = [_add_storey(model, storey, height) for storey, height in zip(building, elevations, strict=True)]
    model.relate("IfcRelAggregates", RelatingObject=house, RelatedObjects=[storey for storey, _ in storeys])
    spaces = {
        (each.name, room): space
        for each, (_, own) in zip(building, storeys, strict=True)
        for room, space in own.items()
    }
    for link in building.links:
        zone = model.add("IfcZone", f"link {link}", Name=link.kind, ObjectType=link.kind.upper())
        model.relate("IfcRelAssignsToGroup", RelatedObjects=[spaces[end] for end in link.ends], RelatingGroup=zone)
    # Equal buildings give equal bytes
    model.file.header.file_name.time_stamp = WRITTEN
    model.file.write(str(target))
    if model.refused:
        notes.append(f"{count_noun(model.refused, 'identifier')} that no IFC can have, or that occur twice, are new")
    return notes


@dataclass
class _Model:
    """A model in an IFC file, with numbers for its relations.

    identifiers: identifiers from another file that are in use. refused: how many could not be kept.
    """

    file: file
    name: str
    relations: int = 0
    identifiers: set[str] = field(default_factory=set)
    refused: int = 0

    def add(
        self,
        entity: str,
        key: str,
        *,
        global_id: str | None = None,
        **values: Any,  # noqa: ANN401  # values of IFC
    ) -> entity_instance:
        """An entity with its known identifier, or one which a key makes unlike all other ones."""
        import ifcopenshell.guid

        identifier = ifcopenshell.guid.compress(uuid5(NAMESPACE_URL, f"pianta/{self.name}/{key}").hex)
        if global_id is not None and GLOBAL_ID.fullmatch(global_id) and global_id not in self.identifiers:
            identifier = global_id
            self.identifiers.add(global_id)
        else:
            self.refused += global_id is not None
        return self.file.create_entity(entity, GlobalId=identifier, **values)

    def relate(self, entity: str, **values: Any) -> entity_instance:  # noqa: ANN401  # values of IFC
        """A relation between entities."""
        self.relations += 1
        return self.add(entity, f"relation {self.relations}", **values)

    def make_units(self) -> entity_instance:
        """Metres, square metres, cubic metres and radians."""
        kinds = {
            "LENGTHUNIT": "METRE",
            "AREAUNIT": "SQUARE_METRE",
            "VOLUMEUNIT": "CUBIC_METRE",
            "PLANEANGLEUNIT": "RADIAN",
        }
        units = [self.file.create_entity("IfcSIUnit", UnitType=entity, Name=name) for entity, name in kinds.items()]
        return self.file.create_entity("IfcUnitAssignment", units)

    @cached_property
    def context(self) -> entity_instance:
        """The context of all shapes."""
        frame = self.file.create_entity("IfcAxis2Placement3D", self.point(0, 0, 0))
        return self.file.create_entity("IfcGeometricRepresentationContext", None, "Model", 3, PRECISION, frame)

    @cached_property
    def body(self) -> entity_instance:
        """The context of bodies."""
        return self.file.create_entity(
            "IfcGeometricRepresentationSubContext",
            ContextIdentifier="Body",
            ContextType="Model",
            ParentContext=self.context,
            TargetView="MODEL_VIEW",
        )

    def point(self, *position: float) -> entity_instance:
        """A point in two or three dimensions."""
        return self.file.create_entity("IfcCartesianPoint", [float(each) for each in position])

    def locate(
        self, parent: entity_instance | None, position: Sequence[float], along: Sequence[float] | Floats = (1, 0)
    ) -> entity_instance:
        """A placement relative to another one; along: its x axis."""
        axis, x_axis = (
            self.file.create_entity("IfcDirection", [float(each) for each in direction])
            for direction in ((0, 0, 1), (*along, 0))
        )
        frame = self.file.create_entity("IfcAxis2Placement3D", self.point(*position), axis, x_axis)
        return self.file.create_entity("IfcLocalPlacement", parent, frame)

    def extrude(self, area: Polygon, height: float) -> entity_instance:
        """The body of an area, from the floor up to a height."""
        outline, *holes = (self._curve(ring) for ring in (area.exterior, *area.interiors))
        if holes:
            profile = self.file.create_entity("IfcArbitraryProfileDefWithVoids", "AREA", None, outline, holes)
        else:
            profile = self.file.create_entity("IfcArbitraryClosedProfileDef", "AREA", None, outline)
        frame = self.file.create_entity("IfcAxis2Placement3D", self.point(0, 0, 0))
        up = self.file.create_entity("IfcDirection", (0.0, 0.0, 1.0))
        solid = self.file.create_entity("IfcExtrudedAreaSolid", profile, frame, up, float(height))
        shape = self.file.create_entity("IfcShapeRepresentation", self.body, "Body", "SweptSolid", [solid])
        return self.file.create_entity("IfcProductDefinitionShape", None, None, [shape])

    def _curve(self, ring: shapely.LinearRing) -> entity_instance:
        first, *corners = [self.point(*corner) for corner in shapely.get_coordinates(ring)[:-1]]
        return self.file.create_entity("IfcPolyline", [first, *corners, first])


def _add_storey(model: _Model, storey: Storey, height: float) -> tuple[entity_instance, dict[int, entity_instance]]:
    """A storey with its spaces by the ids of rooms."""
    frame, floor, key = model.locate(None, (0, 0, height)), storey.floor, f"storey {storey.name}"
    title = title_storey(storey) or "Storey"
    added = model.add(
        "IfcBuildingStorey", key, global_id=floor.global_id, Name=title, ObjectPlacement=frame, Elevation=height
    )
    spaces = {room.id: _add_space(model, room, frame, key) for room in floor}
    if spaces:
        model.relate("IfcRelAggregates", RelatingObject=added, RelatedObjects=[*spaces.values()])
    walls = find_walls(floor)
    elements = [_add_wall(model, part, number, frame, key) for number, part in enumerate(walls.parts, start=1)]
    for part, wall in zip(walls.parts, elements, strict=True):
        _bound(model, wall, part.rooms, spaces)
    hosts = [(walls.parts[host], elements[host]) for host in walls.hosts]
    doors = [
        _add_door(model, door, *host, key=f"{key} door {number}")
        for number, (door, host) in enumerate(zip(floor.doors, hosts, strict=True), start=1)
    ]
    for door, entity in zip(floor.doors, doors, strict=True):
        _bound(model, entity, door.room_ids, spaces, is_outer=door.is_entrance, is_open=door.kind == "opening")
    elements += [entity for door, entity in zip(floor.doors, doors, strict=True) if door.kind == "door"]
    for number, piece in enumerate(floor.furniture, start=1):
        placed = {
            "ObjectPlacement": model.locate(frame, (0, 0, 0)),
            "Representation": model.extrude(piece.polygon, FURNITURE_HEIGHT),
        }
        elements.append(model.add("IfcFurniture", f"{key} furniture {number}", Name=f"Furniture {number}", **placed))
    if elements:
        model.relate("IfcRelContainedInSpatialStructure", RelatedElements=elements, RelatingStructure=added)
    return added, spaces


def _add_space(model: _Model, room: Room, frame: entity_instance, key: str) -> entity_instance:
    """The space of a room, with its number, name, label and base quantities."""
    number, name = number_and_name(room)
    space = model.add(
        "IfcSpace",
        f"{key} room {room.id}",
        global_id=room.global_id,
        Name=number or str(room.id),
        LongName=name,
        ObjectType=room.label,
        ObjectPlacement=model.locate(frame, (0, 0, 0)),
        Representation=model.extrude(room.polygon, WALL_HEIGHT),
        CompositionType="ELEMENT",
        PredefinedType="EXTERNAL" if room.flag in {OUTSIDE_FLAG, BALCONY_FLAG} else "INTERNAL",
    )
    area, perimeter = room.polygon.area, room.polygon.exterior.length
    sizes = {"Height": WALL_HEIGHT, "NetFloorArea": area, "GrossFloorArea": area, "GrossPerimeter": perimeter}
    quantities = [
        _make_quantity(model, name, value) for name, value in {**sizes, "NetVolume": area * WALL_HEIGHT}.items()
    ]
    base = model.add(
        "IfcElementQuantity", f"{key} quantities {room.id}", Name="Qto_SpaceBaseQuantities", Quantities=quantities
    )
    model.relate("IfcRelDefinesByProperties", RelatedObjects=[space], RelatingPropertyDefinition=base)
    return space


def _make_quantity(model: _Model, name: str, value: float) -> entity_instance:
    entity = next((entity for entity in ("Area", "Volume") if name.endswith(entity)), "Length")
    return model.file.create_entity(f"IfcQuantity{entity}", name, None, None, float(value))


def _add_wall(model: _Model, part: WallPart, number: int, frame: entity_instance, key: str) -> entity_instance:
    """A part of a wall; its x axis is its middle."""
    area = box(0, -part.thickness / 2, part.length, part.thickness / 2)
    return model.add(
        "IfcWall",
        f"{key} wall {number}",
        Name=f"Wall {number}",
        ObjectPlacement=model.locate(frame, (*part.ends[0], 0), part.direction),
        Representation=model.extrude(area, WALL_HEIGHT),
        PredefinedType="SOLIDWALL",
    )


def _add_door(model: _Model, door: Door, part: WallPart, wall: entity_instance, *, key: str) -> entity_instance:
    """A door in an opening of its wall; an opening without a door is the opening itself."""
    along = np.sort((shapely.get_coordinates(door.line)[[0, -1]] - part.ends[0]) @ part.direction)
    start, width = float(along[0]), float(along[1] - along[0]) or part.length
    depth, number = door_depth(part), key.rpartition(" ")[2]
    frame = model.locate(wall.ObjectPlacement, (start, 0, 0))
    opening = model.add(
        "IfcOpeningElement",
        f"{key} opening",
        Name=f"Opening {number}",
        ObjectPlacement=frame,
        Representation=model.extrude(box(0, -depth / 2, width, depth / 2), DOOR_HEIGHT),
        PredefinedType="OPENING",
    )
    model.relate("IfcRelVoidsElement", RelatingBuildingElement=wall, RelatedOpeningElement=opening)
    if door.kind == "opening":
        return opening
    leaf = box(0, -LEAF_THICKNESS / 2, width, LEAF_THICKNESS / 2)
    added = model.add(
        "IfcDoor",
        key,
        global_id=door.global_id,
        Name=f"Door {number}",
        ObjectPlacement=model.locate(frame, (0, 0, 0)),
        Representation=model.extrude(leaf, DOOR_HEIGHT),
        OverallHeight=DOOR_HEIGHT,
        OverallWidth=door.width or width,
        PredefinedType="DOOR",
        OperationType="NOTDEFINED",
    )
    model.relate("IfcRelFillsElement", RelatingOpeningElement=opening, RelatedBuildingElement=added)
    return added


def _bound(
    model: _Model,
    element: entity_instance,
    rooms: Sequence[int],
    spaces: dict[int, entity_instance],
    *,
    is_outer: bool | None = None,
    is_open: bool = False,
) -> None:
    """The boundaries of the spaces on the sides of an element."""
    outer = len(rooms) == 1 if is_outer is None else is_outer
    for room in rooms:
        model.relate(
            "IfcRelSpaceBoundary",
            RelatingSpace=spaces[room],
            RelatedBuildingElement=element,
            PhysicalOrVirtualBoundary="VIRTUAL" if is_open else "PHYSICAL",
            InternalOrExternalBoundary="EXTERNAL" if outer else "INTERNAL",
        )
