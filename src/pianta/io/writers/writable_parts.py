"""The parts of a building that other formats can hold: shapes of a millimetre or more, texts on one line, small ids."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import shapely
from shapely import LineString, Point, Polygon

from pianta.building import Building, Storey
from pianta.errors import FloorError
from pianta.floor import DOOR_WIDTH, MAX_ROOM_NAME_LENGTH, Door, Floor, Room
from pianta.io._files import count_noun, short_repr
from pianta.io._names import clean_name, is_clean

# Metres: the precision of the formats; what is smaller would be invalid in them.
MIN_SIZE = 0.001
# Metres, more than any door; the width of a wider one without jambs is wrong.
MAX_WIDTH = 10.0
MAX_ID = 2**31 - 1  # of an integer in databases and in ROS
MAX_LISTED = 5  # ids in a note
_CHANGED = f"characters that cannot be printed, and all after {MAX_ROOM_NAME_LENGTH}, left out"


def keep_writable(building: Building) -> tuple[Building, list[str]]:
    """The building without shapes that other formats cannot hold, and what was left out or changed, a line each.

    Raises FloorError, in one line, for names of storeys that cannot be printed, and for ids above MAX_ID.
    """
    _check_names(building)
    notes: list[str] = []
    storeys = tuple(_keep_storey(storey, notes) for storey in building)
    rooms = {(storey.name, room.id) for storey in storeys for room in storey.floor}
    links = tuple(link for link in building.links if rooms.issuperset(link.ends))
    if len(links) < len(building.links):
        notes.append(f"{count_noun(len(building.links) - len(links), 'link')} to rooms without area left out")
    name, titles = _clean(building.name), [_clean(storey.title) for storey in storeys]
    if name != building.name or titles != [storey.title for storey in storeys]:
        notes.append(f"{_CHANGED} in names of the building or its storeys")
    titled = (replace(storey, title=title) for storey, title in zip(storeys, titles, strict=True))
    return Building(tuple(titled), name, links), notes


def _check_names(building: Building) -> None:
    for storey in building:
        if not is_clean(storey.name):
            raise FloorError(f"storey {short_repr(storey.name)} has a name that cannot be printed, rename it")
    highest = max((room.id for _, room in building.list_rooms()), default=0)
    if highest > MAX_ID:
        raise FloorError(f"room id is {short_repr(highest)}, other formats hold up to {MAX_ID}; read the map again")


def _keep_storey(storey: Storey, notes: list[str]) -> Storey:
    """The storey with what can be written; adds to the notes."""
    floor = storey.floor
    rooms = tuple(_clean_room(room) for room in floor if _has_area(room.polygon))
    kept_ids = {room.id for room in rooms}
    doors, possible_doors = (
        tuple(_lengthen(door, floor) for door in each if kept_ids.issuperset(door.room_ids))
        for each in (floor.doors, floor.possible_doors)
    )
    furniture = tuple(piece for piece in floor.furniture if _has_area(piece.polygon))
    walls = tuple(wall for wall in floor.walls if wall.length >= MIN_SIZE)
    name = f"storey {storey.name}: " if storey.name else ""
    notes += [f"{name}{note}" for note in _list_changes(floor, rooms, furniture, walls)]
    changed = replace(floor, rooms=rooms, doors=doors, possible_doors=possible_doors, furniture=furniture, walls=walls)
    return replace(storey, floor=changed)


def _list_changes(
    floor: Floor, rooms: tuple[Room, ...], furniture: tuple[object, ...], walls: tuple[LineString, ...]
) -> list[str]:
    kept_ids = {room.id for room in rooms}
    dropped = [room.id for room in floor if room.id not in kept_ids]
    short = sum(_is_short(door) for door in (*floor.doors, *floor.possible_doors) if kept_ids.issuperset(door.room_ids))
    pieces, lines = len(floor.furniture) - len(furniture), len(floor.walls) - len(walls)
    texts = sum(room.label != floor[room.id].label for room in rooms)
    listed = ", ".join(map(str, dropped[:MAX_LISTED])) + (", …" if len(dropped) > MAX_LISTED else "")
    notes = [f"{count_noun(len(dropped), 'room')} ({listed}) without area left out, with doors"] if dropped else []
    notes += [f"{count_noun(short, 'door')} without length drawn along the outline of the room"] if short else []
    notes += [f"{count_noun(pieces, 'piece')} of furniture without area left out"] if pieces else []
    notes += [f"{count_noun(lines, 'wall')} without length left out"] if lines else []
    return notes + ([f"{_CHANGED} in {count_noun(texts, 'label')}"] if texts else [])


def _has_area(polygon: Polygon) -> bool:
    """Whether a polygon still has an area with corners at whole millimetres."""
    with np.errstate(all="ignore"):  # of corners that are next to nothing apart
        return not shapely.set_precision(polygon, MIN_SIZE).is_empty


def _clean(text: str) -> str:
    return text if is_clean(text) else clean_name(text) or ""


def _clean_room(room: Room) -> Room:
    """The room with clean labels, and without a prediction that has no area."""
    predicted = room.predicted if room.predicted and _has_area(room.predicted) else None
    texts = [room.label or "", *_list_texts(room)]
    if predicted is room.predicted and all(map(is_clean, texts)):
        return room
    return replace(
        room,
        label=room.label and _clean(room.label),
        labels={_clean(key): _clean(label) for key, label in room.labels.items()},
        label_probabilities={
            _clean(key): {_clean(label): value for label, value in values.items()}
            for key, values in room.label_probabilities.items()
        },
        predicted=predicted,
        confidence=room.confidence if predicted else None,
    )


def _list_texts(room: Room) -> Iterable[str]:
    yield from room.labels
    yield from room.labels.values()
    for key, values in room.label_probabilities.items():
        yield key
        yield from values


def _is_short(door: Door) -> bool:
    ends = shapely.get_coordinates(door.line)[[0, -1]]
    return bool(np.hypot(*(ends[1] - ends[0])) < MIN_SIZE)


def _lengthen(door: Door, floor: Floor) -> Door:
    """A door whose jambs are one point, as wide as it says, along the side of its room that is nearest."""
    if not _is_short(door):
        return door
    outline = floor[door.room_ids[0]].polygon
    rings = (outline.exterior, *outline.interiors)
    sides = [LineString(side) for ring in rings for side in pairwise(ring.coords) if side[0] != side[1]]
    middle = Point(door.line.coords[0])
    start, end = shapely.get_coordinates(min(sides, key=middle.distance))
    along = (end - start) / np.hypot(*(end - start))
    width = door.width if MIN_SIZE <= door.width <= MAX_WIDTH else DOOR_WIDTH
    return replace(door, line=LineString(shapely.get_coordinates(middle) + np.outer([-0.5, 0.5], along) * width))
