"""Colours of rooms without labels, such that neighbours differ."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from shapely import STRtree

from pianta.floor import Room

# Paul Tol's "light" scheme, made for areas with dark labels and for colour-blind readers.
ROOM_COLORS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#ccaadd")
# Rooms no further apart, m, are neighbours: the thickest wall between two rooms.
NEIGHBOUR_DISTANCE = 0.5


def color_neighbours(rooms: Sequence[Room]) -> list[str]:
    """A colour for each room: the least used that no neighbour has; rooms with the most neighbours choose first."""
    polygons = np.array([room.polygon for room in rooms], dtype=object)
    first, second = STRtree(polygons).query(polygons, predicate="dwithin", distance=NEIGHBOUR_DISTANCE)
    neighbours = [second[first == index] for index in range(len(rooms))]
    colors = [""] * len(rooms)
    for index in sorted(range(len(rooms)), key=lambda index: -len(neighbours[index])):
        near = {colors[other] for other in neighbours[index]}
        used = Counter(colors)
        colors[index] = min(ROOM_COLORS, key=lambda color: (color in near, used[color]))
    return colors
