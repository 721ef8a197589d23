"""Labelled floors as a robot would reconstruct them: a building is mapped in simulation, and its map is reconstructed.

A reconstructed floor differs from a drawn one: walls have a thickness, rooms are merged or split, doors are missed.
`train_rooms` can learn from such floors besides drawn ones, with less weight; the model that comes with pianta was
trained on drawn floors only, like the classifier of the thesis (section 5.3).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pianta.evaluation.coverage import overlap_areas
from pianta.floor import Floor, Room, scale_floor
from pianta.layout._label_images import largest_part
from pianta.layout.reconstruct import reconstruct
from pianta.worlds.scan import simulate_map

# The constants were chosen by hand.
# Half the thickness of the walls between drawn rooms, which meet in the middle of the wall; metres.
HALF_WALL = 0.12
# Cells of the simulated maps; metres.
RESOLUTION = 0.1
# Noise of the simulated maps, 0 … 1.
NOISE = 0.5
# Standard deviation of the logarithm of the scale, because drawings are scaled by eye, and buildings differ.
SIZE_SPREAD = 0.2
# Standard deviation of the logarithm of the aspect.
ASPECT_SPREAD = 0.2


def simulate_and_reconstruct(floor: Floor, *, seed: int) -> Floor:
    """The floor reconstructed from a simulated map; each room has the label of the true room that it overlaps most.

    The building is stretched a little at random first, and the map is noisy. Building type and source stay.
    Raises MapError when the map shows no room.
    """
    rng = np.random.default_rng(seed)
    size, aspect = np.exp(rng.normal(0, (SIZE_SPREAD, ASPECT_SPREAD)))
    stretched = scale_floor(floor, size * aspect, size / aspect)
    # Entrances lead out of the map.
    inner = tuple(door for door in stretched.doors if not door.is_entrance)
    walled = replace(stretched, rooms=tuple(map(inset_room, stretched.rooms)), doors=inner)
    grid = simulate_map(walled, resolution=RESOLUTION, noise=NOISE, seed=seed)
    reconstructed = reconstruct(replace(grid, source=floor.source))
    shared = overlap_areas(*(np.array([room.polygon for room in each.rooms]) for each in (reconstructed, stretched)))
    labels = [floor.rooms[best].label for best in shared.argmax(axis=1)]
    rooms = [replace(room, label=label) for room, label in zip(reconstructed.rooms, labels, strict=True)]
    # Rooms that overlap no true room have no true label, and are dropped.
    unmatched = {room.id for room, areas in zip(reconstructed.rooms, shared, strict=True) if not areas.any()}
    doors = tuple(door for door in reconstructed.doors if unmatched.isdisjoint(door.room_ids))
    matched = tuple(room for room in rooms if room.id not in unmatched)
    return replace(reconstructed, rooms=matched, doors=doors, building_type=floor.building_type)


def inset_room(room: Room) -> Room:
    """The room without half a wall on every side; unchanged if it is too narrow for that."""
    inner = largest_part(room.polygon.buffer(-HALF_WALL, join_style="mitre"))
    return room if inner.is_empty else replace(room, polygon=inner)
