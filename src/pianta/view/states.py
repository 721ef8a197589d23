"""What the page shows of a floor, as objects of JSON; coordinates are metres of the map frame."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from shapely import Polygon
from shapely.geometry import mapping

from pianta.corrections._positions import position_in
from pianta.corrections.correct import Outcome
from pianta.corrections.corrections_file import describe_correction
from pianta.corrections.kinds import XY
from pianta.floor import Floor
from pianta.floor.area_trust import AreaTrust
from pianta.gridmap import GridMap
from pianta.io.floors import describe_floor
from pianta.labels import ALL_SCHEMAS
from pianta.plot.styles import FUNCTION_COLORS, NEUTRAL_COLOR, color_neighbours, style_rooms
from pianta.reading.saved_reading import SavedReading

# Rooms whose centres are kept, so that an edit computes those of changed rooms alone; 2000 rooms and their edits.
KEPT_CENTRES = 20_000
# Of a room whose label has no known function, on a floor with labels; the page has a pattern for it.
UNKNOWN_FUNCTION = "UNKNOWN"


def describe_changes(reading: SavedReading) -> dict[str, Any]:
    """The members that corrections change: the floor, its graph, the type of its building, and the corrections.

    Also how the page shows areas, which a correction of the scale changes.
    """
    floor = reading.floor
    return {
        "floor": _describe_shapes(floor),
        "graph": _list_edges(floor),
        "building_type": dict(floor.building_type),
        "areas": describe_trust(reading.area_trust),
        "corrections": describe_outcomes(reading.outcomes),
    }


def describe_trust(area_trust: AreaTrust) -> dict[str, str]:
    """How the page shows areas, and why so."""
    return {"trust": str(area_trust), "note": area_trust.note}


def describe_outcomes(outcomes: Sequence[Outcome]) -> list[dict[str, Any]]:
    """Each correction with its text, and why it does not fit, if it does not."""
    return [
        {**describe_correction(each.correction), "text": str(each.correction), "problem": each.problem}
        for each in outcomes
    ]


def describe_labels(floor: Floor) -> list[dict[str, str]]:
    """The labels of all schemas, those of the floor's building types first."""
    types = {**dict.fromkeys(each for each in floor.building_types if each in ALL_SCHEMAS), **ALL_SCHEMAS}
    return [
        {"label": label.name, "schema": name, "colour": label.color}
        for name in types
        for label in ALL_SCHEMAS[name].labels
    ]


def corners_of(grid: GridMap) -> list[list[float]]:
    """The corners of a map as its picture has them: top left, top right, bottom left."""
    height, width = grid.shape
    x, y = grid.pixel_to_map([0, 0, height], [0, width, 0])
    return [[float(a), float(b)] for a, b in zip(x, y, strict=True)]


def name_type(floor: Floor) -> str | None:
    """The most probable type of the building."""
    return next(iter(floor.building_types), None)


def _describe_shapes(floor: Floor) -> dict[str, Any]:
    """The object of floor.geojson, with what the page shows of a room: title, area, centre, look, doors, neighbours."""
    described = describe_floor(floor)
    looks = choose_looks(floor)
    doors = Counter(room_id for door in floor.doors for room_id in door.room_ids)
    neighbours = defaultdict[int, set[int]](set)
    for door in floor.doors:
        for room_id in door.room_ids:
            neighbours[room_id] |= {*door.room_ids} - {room_id}
    # The rooms are the first features.
    for room, feature in zip(floor.rooms, described["features"], strict=False):
        feature["properties"] |= {
            "predicted": room.predicted and mapping(room.predicted),
            "confidence": room.confidence,
            "title": room.title,
            "area": room.polygon.area,
            "centre": _centre_of(room.polygon),
            **looks[room.id],
            "doors": doors[room.id],
            "neighbours": sorted(neighbours[room.id]),
        }
    return described


def choose_looks(floor: Floor) -> dict[int, dict[str, str | None]]:
    """The function of each room, by its id, and the colour of it: UNKNOWN and white if its label has none.

    If no room has a label, the function is None, and the colour one that no neighbour has.
    """
    if not any(room.label for room in floor.rooms):
        colours = color_neighbours(floor.rooms)
        return {
            room.id: {"function": None, "colour": colour} for room, colour in zip(floor.rooms, colours, strict=True)
        }
    # Where the type is unknown and the schemas disagree, as on OFFICE, those of the thesis decide.
    printed = style_rooms(floor)
    functions = {
        room_id: style.function or printed[room_id].function
        for room_id, style in style_rooms(floor, ALL_SCHEMAS).items()
    }
    return {
        room_id: {
            "function": str(function) if function else UNKNOWN_FUNCTION,
            "colour": FUNCTION_COLORS[function] if function else NEUTRAL_COLOR,
        }
        for room_id, function in functions.items()
    }


def _list_edges(floor: Floor) -> list[list[XY]]:
    """For each door between two rooms a path from centre to centre through its middle."""
    centres = {room.id: _centre_of(room.polygon) for room in floor.rooms}
    paths = []
    for door in floor.doors:
        if door.joins_rooms:
            first, second = door.room_ids
            middle = door.line.interpolate(0.5, normalized=True)
            paths.append([centres[first], (middle.x, middle.y), centres[second]])
    return paths


@lru_cache(KEPT_CENTRES)
def _centre_of(polygon: Polygon) -> XY:
    return position_in(polygon)
