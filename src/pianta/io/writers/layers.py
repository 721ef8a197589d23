"""A building as layers of one type of geometry each: rooms, doors, walls and more, as GIS programs have them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from shapely import LineString, Polygon, transform
from shapely.geometry import mapping

from pianta.building import Building, Storey
from pianta.floor import Door, Furniture, Room
from pianta.io._files import count_noun
from pianta.io.floors import LOCAL_CRS
from pianta.io.georeference import Georeference
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.storey_levels import number_storeys

if TYPE_CHECKING:
    from geopandas import GeoDataFrame

Shape: TypeAlias = Polygon | LineString

# Columns and their types in tables of pandas, which have missing values in each of them.
TYPES = {
    "storey": "string",
    "level": "int64",
    "elevation": "float64",
    "room": "int64",
    "other_room": "Int64",
    "number": "string",
    "name": "string",
    "flag": "string",
    "global_id": "string",
    "label": "string",
    "label_probability": "float64",
    "probability": "float64",
    "confidence": "float64",
    "partial": "bool",
    "area": "float64",
    "width": "float64",
    "kind": "string",
}
STOREY = ("storey", "level", "elevation")
DOOR = ("room", "other_room", "width", "kind", "probability", "global_id")
COLUMNS = {
    "rooms": (
        *STOREY,
        "room",
        "number",
        "name",
        "label",
        "label_probability",
        "probability",
        "partial",
        "area",
        "flag",
        "global_id",
    ),
    "doors": (*STOREY, *DOOR),
    "walls": STOREY,
    "furniture": (*STOREY, "area", "probability"),
    "possible_doors": (*STOREY, *DOOR),
    "predicted_rooms": (*STOREY, "room", "confidence", "area"),
}
# Layers that are there even if they have no rows.
ALWAYS = ("rooms", "doors")
AREA_DIGITS = 4  # of square metres
METRE_DIGITS = 3
DEGREE_DIGITS = 9  # a tenth of a millimetre
PARQUET_VERSION = "1.1.0"  # of GeoParquet
GEOPACKAGE_VERSION = "1.2"  # which GDAL of 2017 and later reads without a warning; the layers need nothing newer


@dataclass(frozen=True)
class Layer:
    """Rows of one type of geometry. shapes: metres of the map frame; areas and widths are in metres too."""

    name: str
    rows: Sequence[tuple[Any, ...]]
    shapes: Sequence[Shape]

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the values of a row."""
        return COLUMNS[self.name]


def list_layers(building: Building) -> list[Layer]:
    """The layers of a building, those without rows left out but for rooms and doors."""
    levels = number_storeys(building)
    layers = []
    for name, list_storey in _LISTERS.items():
        rows, shapes = [], []
        for storey in building:
            storey_values = storey.name or None, levels[storey.name], storey.elevation
            for row, shape in list_storey(storey):
                rows.append((*storey_values, *row))
                shapes.append(shape)
        if rows or name in ALWAYS:
            layers.append(Layer(name, rows, shapes))
    return layers


def write_geojson_layers(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """A GeoJSON for each layer, in WGS 84 with a georeference, and else in millimetres of the map frame."""
    georeference = options.georeference
    digits = DEGREE_DIGITS if georeference else METRE_DIGITS
    crs = {} if georeference else {"crs": {"type": "name", "properties": {"name": LOCAL_CRS}}}
    for layer in list_layers(building):
        features = [
            json.dumps(
                {
                    "type": "Feature",
                    "properties": dict(zip(layer.columns, row, strict=True)),
                    "geometry": mapping(_round(georeference.to_wgs84(shape) if georeference else shape, digits)),
                },
                ensure_ascii=False,
                allow_nan=False,
            )
            for row, shape in zip(layer.rows, layer.shapes, strict=True)
        ]
        header = json.dumps({"type": "FeatureCollection", "name": layer.name, **crs})
        text = f'{header[:-1]}, "features": [\n' + ",\n".join(features) + "\n]}\n"
        (target / f"{layer.name}.geojson").write_text(text, encoding="utf-8")
    return note_links(building)


def write_geopackage(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """A GeoPackage with a layer for each."""
    for layer in list_layers(building):
        table = make_table(layer, options.georeference)
        geometry_type = "Polygon" if layer.name in ("rooms", "furniture", "predicted_rooms") else "LineString"
        version = GEOPACKAGE_VERSION
        table.to_file(
            target, layer=layer.name, driver="GPKG", engine="pyogrio", geometry_type=geometry_type, VERSION=version
        )
    return note_links(building)


def write_geoparquet(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """A GeoParquet for each layer; without a georeference its coordinate system is null, which means unknown."""
    for layer in list_layers(building):
        table = make_table(layer, options.georeference)
        if options.georeference is None:
            table = table.set_crs(None, allow_override=True)
        table.to_parquet(target / f"{layer.name}.parquet", index=False, schema_version=PARQUET_VERSION)
    return note_links(building)


def make_table(layer: Layer, georeference: Georeference | None) -> GeoDataFrame:
    """A layer as a table of geopandas, in the coordinate system of the georeference or a local one of metres."""
    from geopandas import GeoDataFrame

    shapes = [georeference.to_world(shape) if georeference else shape for shape in layer.shapes]
    crs = georeference.name_crs() if georeference else LOCAL_CRS
    table = GeoDataFrame([*layer.rows], columns=[*layer.columns], geometry=shapes, crs=crs)
    typed: GeoDataFrame = table.astype({name: TYPES[name] for name in layer.columns})
    return typed


def note_links(building: Building) -> list[str]:
    """That a format has no stairs and lifts, if the building has any."""
    count = len(building.links)
    return [f"{count_noun(count, 'link')} between storeys (stairs, lifts) left out"] if count else []


def _round(shape: Shape, digits: int) -> Shape:
    rounded: Shape = transform(shape, lambda points: np.round(points, digits) + 0.0)
    return rounded if rounded.is_valid else shape


def _list_rooms(storey: Storey) -> Iterator[tuple[tuple[Any, ...], Shape]]:
    for room in storey.floor:
        certainty = room.label_probability, room.probability, room.partial
        row = room.id, room.number, room.name, room.label, *certainty, _measure(room), room.flag, room.global_id
        yield row, room.polygon


def _list_doors(storey: Storey) -> Iterator[tuple[tuple[Any, ...], Shape]]:
    for door in storey.floor.doors:
        yield _describe_door(door), door.line


def _list_possible_doors(storey: Storey) -> Iterator[tuple[tuple[Any, ...], Shape]]:
    for door in storey.floor.possible_doors:
        yield _describe_door(door), door.line


def _list_walls(storey: Storey) -> Iterator[tuple[tuple[Any, ...], Shape]]:
    for wall in storey.floor.walls:
        yield (), wall


def _list_furniture(storey: Storey) -> Iterator[tuple[tuple[Any, ...], Shape]]:
    for piece in storey.floor.furniture:
        yield (_measure(piece), piece.probability), piece.polygon


def _list_predicted(storey: Storey) -> Iterator[tuple[tuple[Any, ...], Shape]]:
    for room in storey.floor:
        if room.predicted:
            yield (room.id, room.confidence, round(room.predicted.area, AREA_DIGITS)), room.predicted


def _describe_door(door: Door) -> tuple[Any, ...]:
    return *door.rooms, round(door.width, METRE_DIGITS), door.kind, door.probability, door.global_id


def _measure(part: Room | Furniture) -> float:
    return round(float(part.polygon.area), AREA_DIGITS)


_LISTERS: dict[str, Callable[[Storey], Iterator[tuple[tuple[Any, ...], Shape]]]] = {
    "rooms": _list_rooms,
    "doors": _list_doors,
    "walls": _list_walls,
    "furniture": _list_furniture,
    "possible_doors": _list_possible_doors,
    "predicted_rooms": _list_predicted,
}
