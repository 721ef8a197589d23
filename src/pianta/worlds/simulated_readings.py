"""Labelled floors as a robot would reconstruct them: a building is mapped in simulation, and its map is reconstructed.

A reconstructed floor differs from a drawn one: walls have a thickness, rooms are merged or split, doors are missed.
The model of the building types of maps was trained on such floors besides drawn ones. `train_rooms` can learn from them
too, with less weight; the model of rooms that comes with pianta was trained on drawn floors only.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np

from pianta.evaluation.coverage import overlap_areas
from pianta.floor import Floor, Room, scale_floor
from pianta.layout._label_images import largest_part
from pianta.layout.reconstruct import reconstruct
from pianta.worlds.make import MapOptions
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
# Median area of the rooms of a furnished floor before it is stretched: some drawings have a wrong scale; m².
MEDIAN_ROOM = (8.0, 25.0)
# Cells of the maps of furnished floors; metres.
FURNISHED_RESOLUTIONS = (0.05, 0.1)
# Noise of the maps of furnished floors, 0 … 1.
NOISES = (0.1, 0.9)
# How often a floor is empty; has some furniture in its rooms; is densely furnished and has door leaves.
FURNITURE_SHARES = (0.25, 0.3, 0.45)
# Density of furniture, as simulate_map takes it.
DENSITIES = (0.3, 1.3)
# How often a furnished floor has a wall of glass, and how often its map is turned by any angle.
GLASS_SHARE = 0.2
TURNED_SHARE = 0.25


def simulate_and_reconstruct(
    floor: Floor, *, seed: int, furnished: bool = False, walls_are_drawn: bool = False
) -> Floor:
    """The floor reconstructed from a simulated map; each room has the label of the true room that it overlaps most.

    The building is stretched a little at random first, and the map is noisy. Building type and source stay.
    furnished: whether furniture, doors, glass, noise, turn and cells are drawn at random, and a wrong scale is mended;
    else the floor is empty, and its map like all others.
    walls_are_drawn: whether there is a wall between rooms, as on floors of make_floor.
    Raises MapError when the map shows no room.
    """
    rng = np.random.default_rng(seed)
    size, aspect = np.exp(rng.normal(0, (SIZE_SPREAD, ASPECT_SPREAD)))
    if furnished:
        area = float(np.median([room.polygon.area for room in floor.rooms]))
        size *= sqrt(min(max(area, MEDIAN_ROOM[0]), MEDIAN_ROOM[1]) / area)
    stretched = scale_floor(floor, size * aspect, size / aspect)
    # Entrances lead out of the map.
    inner = tuple(door for door in stretched.doors if door.joins_rooms)
    rooms = stretched.rooms if walls_are_drawn else tuple(map(inset_room, stretched.rooms))
    walled = replace(stretched, rooms=rooms, doors=inner)
    options = draw_map_options(rng) if furnished else MapOptions(resolution=RESOLUTION, noise=NOISE)
    grid = simulate_map(walled, seed=seed, **options)
    # What is beyond the partial rooms is no feature of any room.
    reconstructed = reconstruct(replace(grid, source=floor.source), predict_partial=False)
    shared = overlap_areas(*(np.array([room.polygon for room in each.rooms]) for each in (reconstructed, stretched)))
    labels = [floor.rooms[best].label for best in shared.argmax(axis=1)]
    labelled = [replace(room, label=label) for room, label in zip(reconstructed.rooms, labels, strict=True)]
    # Rooms that overlap no true room have no true label, and are dropped.
    unmatched = {room.id for room, areas in zip(reconstructed.rooms, shared, strict=True) if not areas.any()}
    doors = tuple(door for door in reconstructed.doors if unmatched.isdisjoint(door.room_ids))
    matched = tuple(room for room in labelled if room.id not in unmatched)
    return replace(reconstructed, rooms=matched, doors=doors, building_type=floor.building_type)


def draw_map_options(rng: np.random.Generator) -> MapOptions:
    """Options of simulate_map for a floor that is empty, somewhat or densely furnished, and a map of any noise."""
    fullness = int(rng.choice(len(FURNITURE_SHARES), p=FURNITURE_SHARES))
    return MapOptions(
        resolution=float(rng.choice(FURNISHED_RESOLUTIONS)),
        noise=float(rng.uniform(*NOISES)),
        furniture=float(rng.uniform(*DENSITIES)) if fullness else 0.0,
        dense_furniture=fullness == 2,
        door_leaves=fullness == 2,
        glass_spray=bool(rng.random() < GLASS_SHARE),
        yaw=float(rng.uniform(-pi, pi)) if rng.random() < TURNED_SHARE else 0.0,
    )


def inset_room(room: Room) -> Room:
    """The room without half a wall on every side; unchanged if it is too narrow for that."""
    inner = largest_part(room.polygon.buffer(-HALF_WALL, join_style="mitre"))
    return room if inner.is_empty else replace(room, polygon=inner)
