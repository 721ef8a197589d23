"""osmAG: an area graph in OpenStreetMap's XML, in which passages lead from area to area by their names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pianta.building import Building, Storey
from pianta.io._files import count_noun
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.doorways import place_points, reach_doors
from pianta.io.writers.osm import outline_storeys
from pianta.io.writers.osm_files import OsmFile
from pianta.io.writers.room_uses import find_osm_use, is_corridor
from pianta.io.writers.storey_levels import number_storeys

OUTSIDE = "outside"
# The value of `osmAG:areaType` by what people do in the room.
AREA_TYPES = {"elevator": "elevator", "stairs": "stairs"}


def write_osmag(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """A structure for each storey with its rooms, a passage for each door, and the origin of the map as root node."""
    file = OsmFile(options.georeference)
    levels = number_storeys(building)
    names, changed = _choose_names(building)
    file.add_node((0.0, 0.0), {"name": "root"}, level=min(levels.values()) - 1)
    for storey in building:
        level = levels[storey.name]
        tags = {"osmAG:type": "area", "indoor": "area", "level": str(level)}
        structure = names[storey.name, 0]
        for outline in outline_storeys((storey,))[:1]:
            ring = [(x, y) for x, y, *_ in outline.exterior.coords]
            file.add_way(ring, {**tags, "osmAG:areaType": "structure", "name": structure}, level=level)
        _add_rooms(file, storey, names, {**tags, "osmAG:parent": structure})
        for door in storey.floor.doors:
            points = place_points(door)
            ends = [OUTSIDE if room is None else names[storey.name, room] for room in door.rooms]
            file.add_way([points.start, points.end], _tag_passage(ends, level), level=level)
    for link in building.links:
        nodes = [_add_place(file, building, end, levels[end[0]]) for end in link.ends]
        file.join_nodes(nodes, _tag_passage([names[end] for end in link.ends], levels[link.ends[0][0]]))
    file.write(target)
    holes = sum(len(room.polygon.interiors) for _, room in building.list_rooms())
    walls = sum(len(storey.floor.walls) for storey in building)
    notes = [f"{count_noun(holes, 'hole')} of rooms left out, areas are without"] if holes else []
    notes += [f"{count_noun(walls, 'wall')} left out"] if walls else []
    return notes + ([f"{count_noun(changed, 'name')} of rooms got a number, as names are ids here"] if changed else [])


def _add_place(file: OsmFile, building: Building, end: tuple[str, int], level: int) -> int:
    """A node inside the room at an end of stairs or a lift."""
    name, room_id = end
    floor = next(storey.floor for storey in building if storey.name == name)
    location = floor[room_id].polygon.representative_point()
    return file.add_node((location.x, location.y), level=level)


def _add_rooms(file: OsmFile, storey: Storey, names: Mapping[tuple[str, int], str], tags: Mapping[str, str]) -> None:
    polygons = reach_doors(storey.floor)
    for room in storey.floor:
        area = AREA_TYPES.get(find_osm_use(room), "corridor" if is_corridor(room) else "room")
        corners = [(x, y) for x, y, *_ in polygons[room.id].exterior.coords]
        own = {"osmAG:areaType": area, "name": names[storey.name, room.id]}
        file.add_way(corners, {**tags, **own, "indoor": "room"}, level=int(tags["level"]))


def _tag_passage(ends: list[str], level: int) -> dict[str, str]:
    return {"osmAG:type": "passage", "osmAG:from": ends[0], "osmAG:to": ends[1], "level": str(level)}


def _choose_names(building: Building) -> tuple[dict[tuple[str, int], str], int]:
    """A name for each storey, as its room 0, and for each room, all different, and how many had to change."""
    names: dict[tuple[str, int], str] = {}
    used = {OUTSIDE, "root"}
    changed = 0
    for storey in building:
        wanted = [(0, storey.title or storey.name or building.name or "building")]
        wanted += [(room.id, room.title or f"room {room.id}") for room in storey.floor]
        for room_id, name in wanted:
            free = name
            number = 2
            while free in used:
                free = f"{name} {number}"
                number += 1
            changed += free != name
            used.add(free)
            names[storey.name, room_id] = free
    return names, changed
