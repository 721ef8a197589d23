"""Views of an annotated floor: without its labels, and as read from a robot's map."""

from __future__ import annotations

from dataclasses import replace

from pianta.errors import PiantaError
from pianta.floor import Floor
from pianta.worlds.simulated_readings import simulate_and_reconstruct
from pianta_bench.data.annotated_floors import AnnotatedFloor

UNLABELLED = "labels found"
MAPPED = "on a map"


def view_floor(annotated: AnnotatedFloor, *, seed: int) -> dict[str, Floor]:
    """By UNLABELLED the drawing without labels, by MAPPED the floor read from a simulated map, if that shows rooms.

    seed: of the simulation.
    """
    views = {UNLABELLED: annotated.unlabelled}
    try:
        mapped = simulate_and_reconstruct(annotated.floor, seed=seed)
    except PiantaError:
        return views
    rooms = tuple(replace(room, label=None, labels={}, label_probabilities={}) for room in mapped.rooms)
    return views | ({MAPPED: replace(mapped, rooms=rooms, building_type={})} if rooms else {})
