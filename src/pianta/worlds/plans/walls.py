"""The walls of a drawn plan, with the gaps of doors and windows and the symbols in them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from shapely import Point, Polygon, get_coordinates, get_parts, polygonize, unary_union
from shapely.geometry.base import BaseGeometry

from pianta.floor import Floor, Room
from pianta.floor.polygons import list_polygons
from pianta.plan.symbols.drawings import Mark
from pianta.worlds.plans.look import Canvas
from pianta.worlds.plans.symbols import Window, find_windows, mark_doors, mark_windows
from pianta.worlds.wall_axes import INNER_WALL, OUTER_WALL

# Gaps extend beyond the faces of a wall by this; metres.
GAP_OVERLAP = 0.02
# Smaller holes of rooms are pillars; m².
MAX_PILLAR = 2.0


def paint_walls(canvas: Canvas, floor: Floor, rng: np.random.Generator) -> None:
    """The walls with the gaps of doors and windows, then the doors and windows."""
    look = canvas.look
    windows = find_windows(floor, canvas.footprint) if look.windows else []
    gaps = [door.line.buffer(OUTER_WALL / 2 + GAP_OVERLAP, cap_style="flat") for door in floor.doors]
    if look.style == "single":
        windows = [replace(window, wall=INNER_WALL) for window in windows]
    paint = _paint_axes if look.style == "single" else _paint_bodies
    paint(canvas, floor, unary_union([*gaps, *map(_window_gap, windows)]))
    depth = 0.0 if look.style == "single" else INNER_WALL
    canvas.paint(mark_windows(windows, look.windows) + mark_doors(floor, look.doors, wall=depth, rng=rng))


def extend_rooms_to_axes(floor: Floor) -> Floor:
    """The floor with rooms that meet in the axes of the walls, without the pillars in them."""
    faces = get_parts(polygonize([unary_union(floor.walls)]))

    def extend(room: Room) -> Room:
        inside = Point(room.polygon.representative_point())
        around = [face for face in faces if face.contains(inside)]
        return replace(room, polygon=around[0].difference(unary_union(_list_pillars(room)))) if around else room

    return replace(floor, rooms=tuple(map(extend, floor.rooms)))


def _paint_axes(canvas: Canvas, floor: Floor, gaps: BaseGeometry) -> None:
    """Walls as single lines."""
    pillars = [pillar.exterior for room in floor.rooms for pillar in _list_pillars(room)]
    lines = get_parts(unary_union([*floor.walls, *pillars]).difference(gaps))
    canvas.paint([Mark(get_coordinates(line)) for line in lines], strokes=2)


def _paint_bodies(canvas: Canvas, floor: Floor, gaps: BaseGeometry) -> None:
    """Walls of their real thickness, filled or as the lines of their faces."""
    body = canvas.footprint.difference(unary_union([room.polygon for room in floor.rooms])).difference(gaps)
    if canvas.look.style == "thick":
        canvas.fill(body, canvas.look.color)
        return
    rings = [ring for part in list_polygons(body) for ring in (part.exterior, *part.interiors)]
    canvas.paint([Mark(get_coordinates(ring)[:-1], closed=True) for ring in rings])


def _window_gap(window: Window) -> BaseGeometry:
    return window.line.buffer(window.wall / 2 + GAP_OVERLAP, cap_style="flat")


def _list_pillars(room: Room) -> list[Polygon]:
    return [hole for ring in room.polygon.interiors if (hole := Polygon(ring)).area < MAX_PILLAR]
