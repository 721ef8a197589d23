"""Floors as pianta sees them by itself: without the labels that somebody gave, and as read from a robot's map."""

from __future__ import annotations

from dataclasses import replace

from pianta.errors import PiantaError
from pianta.floor import Floor
from pianta.worlds.simulated_readings import simulate_and_reconstruct
from pianta_bench.data.annotated_floors import AnnotatedFloor

UNLABELLED, MAPPED = "labels found", "on a map"


def read_again(drawn: AnnotatedFloor, *, seed: int) -> dict[str, Floor]:
    """By UNLABELLED the drawing without labels, by MAPPED what is read from a simulated map of it, if that shows rooms.

    seed: of the simulation.
    """
    views = {UNLABELLED: drawn.unlabelled}
    try:
        found = simulate_and_reconstruct(drawn.floor, seed=seed)
    except PiantaError:
        return views
    rooms = tuple(replace(room, label=None, labels={}, label_probabilities={}) for room in found.rooms)
    return views | ({MAPPED: replace(found, rooms=rooms, building_type={})} if rooms else {})
