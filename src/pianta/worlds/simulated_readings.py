"""Labelled floors as a robot would find them: a building is mapped in simulation, and its map is read.

What the reconstruction makes of a map differs from what people draw: walls have a thickness, rooms are joined or
divided, a door is missed. `train_rooms` can learn from such floors besides the drawn ones, with less weight; the model
that comes with pianta has seen drawn floors only, as the classifier of the thesis (section 5.3).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pianta.evaluation.coverage import overlap_areas
from pianta.floor import Floor, Room, scale_floor
from pianta.layout._outlines import largest_part
from pianta.layout.reconstruct import reconstruct
from pianta.worlds.scan import map_floor

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
    stretched = scale_floor(floor, size * aspect, size / aspect)
    # Entrances lead out of what is mapped.
    inner = tuple(door for door in stretched.doors if not door.is_entrance)
    walled = replace(stretched, rooms=tuple(map(leave_walls, stretched.rooms)), doors=inner)
    found = reconstruct(replace(map_floor(walled, resolution=RESOLUTION, noise=NOISE, seed=seed), source=floor.source))
    shared = overlap_areas(*(np.array([room.polygon for room in each.rooms]) for each in (found, stretched)))
    labels = [floor.rooms[best].label for best in shared.argmax(axis=1)]
    rooms = [replace(room, label=label) for room, label in zip(found.rooms, labels, strict=True)]
    # What covers no true room has no true label; nothing is learned from such a floor's stray.
    stray = {room.id for room, areas in zip(found.rooms, shared, strict=True) if not areas.any()}
    doors = [door for door in found.doors if stray.isdisjoint(door.room_ids)]
    kept = tuple(room for room in rooms if room.id not in stray)
    return replace(found, rooms=kept, doors=tuple(doors), building_type=floor.building_type)


def leave_walls(room: Room) -> Room:
    """The room without half a wall on every side, where it is that wide."""
    inner = largest_part(room.polygon.buffer(-HALF_WALL, join_style="mitre"))
    return room if inner.is_empty else replace(room, polygon=inner)
