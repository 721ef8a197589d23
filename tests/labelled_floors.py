"""Made floors with labels that follow from their shape, so that a model can learn them."""

from dataclasses import replace
from functools import cache

import numpy as np

from pianta.floor import Floor
from pianta.rooms.model import RoomModel
from pianta.rooms.training import train_rooms
from pianta.worlds.floors import make_floor


def label_by_rule(floor: Floor, *, source: str) -> Floor:
    """A school: rooms with four neighbours or more are corridors, small rooms closets, the largest other a gym."""
    graph = floor.graph()
    side = np.median([room.polygon.area for room in floor.rooms])
    ends = [room.id for room in floor.rooms if graph.degree(room.id) < 4]
    largest = max(ends, key=lambda room_id: graph.nodes[room_id]["area"])

    def label(room_id: int, area: float) -> str:
        if graph.degree(room_id) >= 4:
            return "CORRIDOR"
        if room_id == largest:
            return "STAIRS"
        return "CLOSET" if area < 0.8 * side else "CLASSROOM"

    rooms = tuple(replace(room, label=label(room.id, room.polygon.area)) for room in floor.rooms)
    return replace(floor, rooms=rooms, building_type={"school": 1.0}, source=source)


@cache
def labelled_floors() -> tuple[Floor, ...]:
    """Six floors of three kinds."""
    kinds = ("corridor", "l", "ring")
    generated = [
        (f"{type_name} house {seed}.xml", make_floor(type_name, seed=seed)) for type_name in kinds for seed in (1, 2)
    ]
    return tuple(label_by_rule(floor, source=source) for source, floor in generated)


@cache
def small_model() -> RoomModel:
    """A model trained on them."""
    return train_rooms(labelled_floors())
