"""Labelled floors as a robot would find them: a building is mapped in simulation, and its map is read.

What the reconstruction makes of a map differs from what people draw: walls have a thickness, rooms are joined or
divided, a door is missed. A model that shall label robots' maps has to see such floors (thesis, section 5.3).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon
from shapely.affinity import scale

from pianta.floor import Floor, Room
from pianta.layout.reconstruct import reconstruct
from pianta.worlds.scan import map_floor

Shape = TypeVar("Shape", bound=shapely.Geometry)

# Half a wall between drawn rooms, which meet in its middle, and the cells of the simulated maps; m.
HALF_WALL, RESOLUTION = 0.12, 0.1
NOISE = 0.5
# Standard deviations of the logarithms of size and aspect: drawings are scaled by eye, and buildings differ.
SIZE_SPREAD, ASPECT_SPREAD = 0.2, 0.2


def simulate_reading(floor: Floor, *, seed: int) -> Floor:
    """The floor as `reconstruct` finds it on a simulated robot's map, its rooms labelled by what they overlap most.

    The building is stretched a little at random first, and the map is noisy. Type and source are kept.
    Raises MapError when nothing is found on the map.
    """
    rng = np.random.default_rng(seed)
    size, aspect = np.exp(rng.normal(0, (SIZE_SPREAD, ASPECT_SPREAD)))
    stretched = _stretch_floor(floor, size * aspect, size / aspect)
    walled = replace(stretched, rooms=tuple(_leave_walls(room) for room in stretched.rooms))
    found = reconstruct(map_floor(walled, resolution=RESOLUTION, noise=NOISE, seed=seed), source=floor.source)
    shared = _measure_overlaps(found, stretched)
    labels = [floor.rooms[best].label for best in shared.argmax(axis=1)]
    rooms = [replace(room, label=label) for room, label in zip(found.rooms, labels, strict=True)]
    # What covers no true room has no true label; nothing is learned from such a floor's stray.
    stray = {room.id for room, areas in zip(found.rooms, shared, strict=True) if not areas.any()}
    doors = [door for door in found.doors if stray.isdisjoint(door.room_ids)]
    kept = tuple(room for room in rooms if room.id not in stray)
    return replace(found, rooms=kept, doors=tuple(doors), building_type=floor.building_type)


def _stretch_floor(floor: Floor, along_x: float, along_y: float) -> Floor:
    """The floor scaled by different factors; entrances lead out of what is mapped and are left out."""

    def stretch(shape: Shape) -> Shape:
        stretched: Shape = scale(shape, along_x, along_y, origin=(0, 0))
        return stretched

    rooms = tuple(replace(room, polygon=stretch(room.polygon)) for room in floor.rooms)
    doors = tuple(replace(door, line=stretch(door.line)) for door in floor.doors if not door.is_entrance)
    return Floor(rooms, doors)


def _leave_walls(room: Room) -> Room:
    """The room without half a wall on every side, where it is that wide."""
    inner = room.polygon.buffer(-HALF_WALL, join_style="mitre")
    parts = [part for part in shapely.get_parts(inner) if isinstance(part, Polygon) and not part.is_empty]
    return replace(room, polygon=max(parts, key=lambda part: part.area)) if parts else room


def _measure_overlaps(found: Floor, true: Floor) -> NDArray[np.float64]:
    """Area that each found room shares with each true one, m²; shape (rooms found, true rooms)."""
    ours = np.array([room.polygon for room in found.rooms])
    theirs = np.array([room.polygon for room in true.rooms])
    return np.asarray(shapely.area(shapely.intersection(ours[:, None], theirs[None])))
