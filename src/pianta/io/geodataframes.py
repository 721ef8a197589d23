"""Floors as GeoDataFrames, the tables of GIS programs in Python."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shapely.geometry.base import BaseGeometry

from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.io._files import short_repr

if TYPE_CHECKING:
    from geopandas import GeoDataFrame

# The columns of each layer besides the geometry, also of a layer without rows.
LAYERS = {
    "rooms": ("number", "name", "label", "label_probability", "partial", "area", "probability"),
    "doors": ("room", "other_room", "width", "kind", "probability"),
    "walls": (),
    "furniture": ("area", "probability"),
    "possible_doors": ("room", "other_room", "width", "kind", "probability"),
}


def floor_to_geodataframe(floor: Floor, layer: str) -> GeoDataFrame:
    """A layer of a floor as a GeoDataFrame; see `Floor.to_geodataframe`."""
    if layer not in tuple(LAYERS):
        raise OptionError(f"layer is {short_repr(layer)}, give one of {', '.join(LAYERS)}")
    try:
        from geopandas import GeoDataFrame
    except ImportError:
        raise OptionError("geopandas is not installed, install it with: pip install 'pianta[geo]'") from None
    rows, shapes = _list_rows(floor, layer)
    table = GeoDataFrame(rows, columns=LAYERS[layer], geometry=shapes)
    if layer == "rooms":
        table = table.set_index([[room.id for room in floor.rooms]]).rename_axis("id")
        table.index = table.index.astype("int64")
        table["label_probability"] = table["label_probability"].astype("float64")
    if "other_room" in LAYERS[layer]:
        table["other_room"] = table["other_room"].astype("Int64")
    if "probability" in LAYERS[layer]:
        table["probability"] = table["probability"].astype("float64")
    return table


def _list_rows(floor: Floor, layer: str) -> tuple[list[tuple[object, ...]], list[BaseGeometry]]:
    """The values of the columns of a layer, row by row, and the shapes."""
    rows: list[tuple[object, ...]]
    if layer == "rooms":
        rows = [
            (
                room.number,
                room.name,
                room.label,
                room.label_probability,
                room.partial,
                room.polygon.area,
                room.probability,
            )
            for room in floor.rooms
        ]
        return rows, [room.polygon for room in floor.rooms]
    if layer in ("doors", "possible_doors"):
        doors = floor.doors if layer == "doors" else floor.possible_doors
        return [(*door.rooms, door.width, door.kind, door.probability) for door in doors], [door.line for door in doors]
    if layer == "furniture":
        rows = [(piece.polygon.area, piece.probability) for piece in floor.furniture]
        return rows, [piece.polygon for piece in floor.furniture]
    return [() for _ in floor.walls], [*floor.walls]
