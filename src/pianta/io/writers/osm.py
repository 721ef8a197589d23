"""OpenStreetMap with Simple Indoor Tagging: rooms as closed ways, doors as nodes that the ways of rooms share."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from shapely import Polygon, unary_union

from pianta.building import Building, Storey
from pianta.floor import Door, Room
from pianta.floor.polygons import list_polygons
from pianta.io._files import count_noun
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.doorways import place_points, reach_doors
from pianta.io.writers.layers import note_links
from pianta.io.writers.osm_files import OsmFile
from pianta.io.writers.room_texts import number_and_name
from pianta.io.writers.room_uses import find_osm_use, is_corridor
from pianta.io.writers.storey_levels import number_storeys

# Rooms of a building are closer than twice this, metres: half of a thick wall; chosen by hand.
HALF_WALL = 0.5


def write_osm(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """All storeys with their levels, and the outline of the building."""
    file = OsmFile(options.georeference)
    levels = number_storeys(building)
    for storey in building:
        level = levels[storey.name]
        polygons = reach_doors(storey.floor)
        for room in storey.floor:
            _add_room(file, polygons[room.id], _tag_room(room, level), level)
        for door in storey.floor.doors:
            file.add_node(place_points(door).middle, _tag_door(door, level), level=level)
        for wall in storey.floor.walls:
            file.add_way([(x, y) for x, y, *_ in wall.coords], {"indoor": "wall", "level": str(level)}, level=level)
    for outline in outline_storeys(building.storeys):
        tags = {"building": "yes", "min_level": str(min(levels.values())), "max_level": str(max(levels.values()))}
        tags |= {"name": building.name} if building.name else {}
        _add_room(file, outline, tags, max(levels.values()) + 1)
    file.write(target)
    return note_links(building) + (
        [f"{count_noun(file.shortened, 'text')} cut to 255 characters"] * bool(file.shortened)
    )


def outline_storeys(storeys: tuple[Storey, ...]) -> list[Polygon]:
    """The outlines of what the rooms of storeys cover, with the walls between them; several for several parts."""
    rooms = [room.polygon for storey in storeys for room in storey.floor]
    covered = unary_union([room.buffer(HALF_WALL, join_style="mitre") for room in rooms])
    # Outlines of maps have a corner for each cell, which are not needed here
    covered = covered.buffer(-HALF_WALL, join_style="mitre").union(unary_union(rooms))
    return [Polygon(part.exterior) for part in list_polygons(covered)]


def _add_room(file: OsmFile, polygon: Polygon, tags: Mapping[str, str], level: int) -> None:
    """A closed way, or a multipolygon of them if the room has holes."""
    rings = [[(x, y) for x, y, *_ in ring.coords] for ring in (polygon.exterior, *polygon.interiors)]
    if len(rings) == 1:
        file.add_way(rings[0], tags, level=level)
        return
    file.add_multipolygon([file.add_way(ring, {}, level=level) for ring in rings], tags)


def _tag_room(room: Room, level: int) -> dict[str, str]:
    number, name = number_and_name(room)
    use = find_osm_use(room)
    tags = {"indoor": "corridor" if is_corridor(room) else "room", "level": str(level)}
    tags |= {"ref": number} if number else {}
    tags |= {"name": name} if name else {}
    tags |= {"room": use} if use else {}
    return (
        tags | ({"stairs": "yes"} if use == "stairs" else {}) | ({"highway": "elevator"} if use == "elevator" else {})
    )


def _tag_door(door: Door, level: int) -> dict[str, str]:
    tags = {"door": "no" if door.kind == "opening" else "yes", "level": str(level), "width": f"{door.width:.2f}"}
    return tags | ({"entrance": "yes"} if door.is_entrance else {})
