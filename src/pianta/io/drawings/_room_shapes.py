"""Shapes of an SVG that ids, classes or labels name rooms, as outlines with stamps."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely

from pianta._types import Floats
from pianta.io.drawings._drawing import DrawnStamp
from pianta.io.drawings._layers import ANNOTATIONS, DrawnPieces, words_in, words_of_name

ROOMS_LAYER = "rooms"
MAX_SHAPES = 20_000
MAX_NUMBER = 8  # characters of a number of a room, as in 2502C

# In English, German, Italian, French and Spanish, without accents.
_ONE_ROOM = words_in("room space raum zimmer stanza vano locale piece local habitacion estancia recinto")
_ROOMS = words_in("rooms spaces raume raeume zimmer stanze vani locali pieces locaux habitaciones estancias recintos")
_OUTSIDE = words_in("outside outdoor outdoors exterior exteriors aussen draussen esterno esterni exterieur afuera")
# What editors call a shape without a name
_AUTOMATIC = re.compile(
    r"(path|rect|polygon|polyline|shape|svg|layer|group|g|use|ellipse|circle|element|object)[-_ ]?[\d_-]*",
    re.IGNORECASE,
)


@dataclass
class RoomShapes:
    """The shapes of elements that are named rooms.

    elements: the names of each element. shapes: their areas with the number of the element and their own names.
    """

    elements: list[tuple[str, ...]] = field(default_factory=list)
    shapes: list[tuple[int, shapely.Polygon, tuple[str, ...]]] = field(default_factory=list)

    def add_element(self, names: tuple[str, ...]) -> int:
        """The number of another element with names of rooms."""
        self.elements.append(names)
        return len(self.elements) - 1

    def add_shape(self, element: int, rings: Sequence[Floats], names: tuple[str, ...]) -> None:
        """Add the largest ring of a shape, each shape (N, 2), in an element; names: of the shape and its groups."""
        polygons = [shapely.Polygon(ring) for ring in rings if np.isfinite(ring).all()]
        if polygons and len(self.shapes) < MAX_SHAPES:
            self.shapes.append((element, max(polygons, key=lambda each: each.area), names))

    def add_to(self, pieces: DrawnPieces) -> None:
        """Add outlines to the pieces, and stamps where no text stands in one.

        An element that is named one room has its largest shape for outline; one that is named rooms has all. What is
        named outside, around the rooms, is no room.
        """
        by_element: dict[int, list[tuple[shapely.Polygon, tuple[str, ...]]]] = {}
        for element, polygon, names in self.shapes:
            if _has_word((*names, *self.elements[element]), _OUTSIDE):
                continue
            by_element.setdefault(element, []).append((polygon, names))
        chosen: list[tuple[shapely.Polygon, str]] = []
        for element, shapes in by_element.items():
            if _has_word(self.elements[element], _ROOMS):
                chosen += [(polygon, _title_of(names)) for polygon, names in shapes]
            else:
                largest = max((polygon for polygon, _ in shapes), key=lambda polygon: polygon.area)
                chosen.append((largest, _title_of(self.elements[element])))
        texts = shapely.STRtree(shapely.points(np.reshape([(text.x, text.y) for text in pieces.texts], (-1, 2))))
        for polygon, title in chosen:
            pieces.add_outline([shapely.get_coordinates(polygon.exterior)[:-1]], ROOMS_LAYER)
            if title and polygon.is_valid and polygon.area > 0 and not len(texts.query(polygon, "intersects")):
                point = polygon.point_on_surface()
                is_number = len(title) <= MAX_NUMBER and any(map(str.isdigit, title)) and " " not in title
                pieces.add_stamp(DrawnStamp(point.x, point.y, *((title, "") if is_number else ("", title))))


def names_rooms(names: Iterable[str]) -> bool:
    """Whether one of the names means a room or rooms, such as class room or id room-lobby; not a text about one."""
    names = list(names)
    return _has_word(names, _ONE_ROOM | _ROOMS) and not _has_word(names, ANNOTATIONS)


def _has_word(names: Iterable[str], words: frozenset[str]) -> bool:
    return any(not words.isdisjoint(words_of_name(name)) for name in names)


def _title_of(names: Iterable[str]) -> str:
    """What the first name that says more than room calls it, as lobby for room-lobby; "" without one."""
    for name in names:
        parts = [part for part in re.split(r"[\s_:-]+", name) if not _has_word([part], _ONE_ROOM | _ROOMS)]
        if parts and not _AUTOMATIC.fullmatch(name):
            return " ".join(parts)
    return ""
