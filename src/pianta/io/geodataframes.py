"""Floors as GeoDataFrames, the tables of GIS programs in Python."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.io._files import shown

if TYPE_CHECKING:
    from geopandas import GeoDataFrame

LAYERS = ("rooms", "doors", "walls")


def floor_to_geodataframe(floor: Floor, layer: str) -> GeoDataFrame:
    """A layer of a floor as a GeoDataFrame; see `Floor.to_geodataframe`."""
    if layer not in LAYERS:
        raise OptionError(f"layer is {shown(layer)}, give one of {', '.join(LAYERS)}")
    try:
        from geopandas import GeoDataFrame
    except ImportError:
        raise OptionError("geopandas is not installed, install it with: pip install 'pianta[geo]'") from None
    if layer == "walls":
        return GeoDataFrame({"geometry": list(floor.walls)}, geometry="geometry")
    rows: list[dict[str, Any]] = (
        [
            {
                "name": room.name,
                "label": room.label,
                "label_probability": room.label_probability,
                "partial": room.partial,
                "area": room.polygon.area,
                "geometry": room.polygon,
            }
            for room in floor.rooms
        ]
        if layer == "rooms"
        else [
            {
                "room": door.rooms[0],
                "other_room": door.rooms[1],
                "width": door.width,
                "kind": door.kind,
                "geometry": door.line,
            }
            for door in floor.doors
        ]
    )
    columns = list(rows[0]) if rows else ["geometry"]
    table = GeoDataFrame(rows, columns=columns, geometry="geometry")
    if layer == "rooms":
        table.index = [room.id for room in floor.rooms]
        table.index.name = "id"
    else:
        table["other_room"] = table["other_room"].astype("Int64")
    return table
