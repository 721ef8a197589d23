"""Scene graph JSON as spark-dsg 1.1.3, the library of Hydra, reads and writes it: rooms, a building, and doors."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import shapely

from pianta.building import Building, Storey
from pianta.floor import Room
from pianta.io._files import count_noun
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.room_texts import place_text
from pianta.io.writers.storey_heights import list_elevations
from pianta.io.writers.wall_parts import WALL_HEIGHT

# The version of the format that spark-dsg 1.1.3 writes.
HEADER = {"project_name": "main", "version": {"major": 1, "minor": 1, "patch": 3}}
# The layers of spark-dsg.
LAYERS = {"OBJECTS": 2, "AGENTS": 2, "PLACES": 3, "ROOMS": 4, "BUILDINGS": 5}
NO_LABEL = 2**32 - 1
CATEGORY_BITS = 56  # an id is a letter in its highest byte, and a number below it
# Between the numbers of rooms of a storey and those of the next one; more than any storey has.
STOREY_STEP = 1_000_000
NO_TURN = {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}
NO_FEATURE = {"cols": 0, "data": None, "rows": 0}
BLACK = {"a": 255, "b": 0, "g": 0, "r": 0}


def write_scene_graph(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """A node for each room and one for the building; doors, stairs and lifts are edges; outlines are in metadata."""
    heights, notes = list_elevations(building)
    nodes = [_make_building(building, heights)]
    edges = []
    step = _choose_step(building)
    for number, (storey, height) in enumerate(zip(building, heights, strict=True)):
        for room in storey.floor:
            node = node_id("R", number * step + room.id)
            nodes.append(_make_node(node, "ROOMS", _describe_room(room, storey, height)))
            edges.append(_make_edge(node_id("B", 0), node))
        graph = storey.floor.graph()
        for first, second, data in graph.edges(data=True):
            ends = (node_id("R", number * step + room) for room in (first, second))
            edges.append(_make_edge(*ends, doors=data["doors"], width=round(float(data["width"]), 3)))
    storey_numbers = {storey.name: number for number, storey in enumerate(building)}
    for link in building.links:
        ends = (node_id("R", storey_numbers[name] * step + room) for name, room in link.ends)
        edges.append(_make_edge(*ends, kind=link.kind))
    keys = {name: {"layer": layer, "partition": 0} for name, layer in LAYERS.items()}
    content = {
        "SPARK_DSG_header": HEADER,
        "directed": False,
        "multigraph": False,
        "layer_keys": [{"layer": layer, "partition": 0} for layer in sorted({*LAYERS.values()})],
        "layer_names": keys,
        "metadata": {},
        "nodes": nodes,
        "edges": edges,
    }
    target.write_text(json.dumps(content, allow_nan=False) + "\n", encoding="utf-8")
    return notes + _list_notes(building)


def node_id(category: str, index: int) -> int:
    """The id of a node: the code of a letter in the highest byte of 64 bits, and its number; above 2^53."""
    return (ord(category) << CATEGORY_BITS) + index


def _choose_step(building: Building) -> int:
    """Between the numbers of one room id on two storeys: STOREY_STEP, or a power of ten above all ids."""
    highest = max((room.id for _, room in building.list_rooms()), default=0)
    return max(STOREY_STEP, int(10 ** len(str(highest))))


def _list_notes(building: Building) -> list[str]:
    entrances = sum(door.is_entrance for storey in building for door in storey.floor.doors)
    notes = [f"a scene graph holds no {count_noun(entrances, 'entrance')}, left out"] if entrances else []
    if len(building) > 1:
        step = _choose_step(building)
        notes.append(f"room 3 of the second storey is R({step + 3}), of the third R({2 * step + 3})")
    return notes


def _make_node(node: int, layer: str, attributes: Mapping[str, Any]) -> dict[str, Any]:
    return {"id": node, "layer": LAYERS[layer], "partition": 0, "attributes": {**attributes}}


def _make_edge(source: int, target: int, **metadata: float | str) -> dict[str, Any]:
    info = {"type": "EdgeAttributes", "weight": 1.0, "weighted": False, "metadata": metadata}
    return {"source": source, "target": target, "info": info}


def _describe(node_type: str, name: str, position: tuple[float, ...], box: Mapping[str, Any]) -> dict[str, Any]:
    """What nodes of rooms and of buildings have."""
    return {
        "type": node_type,
        "name": name,
        "position": list(position),
        "bounding_box": box,
        "color": BLACK,
        "is_active": False,
        "is_predicted": False,
        "last_update_time_ns": 0,
        "semantic_feature": NO_FEATURE,
        "semantic_label": NO_LABEL,
    }


def _make_box(bounds: tuple[float, ...], low: float, high: float) -> dict[str, Any]:
    x_min, y_min, x_max, y_max = bounds
    return {
        "type": "AABB",
        "dimensions": [x_max - x_min, y_max - y_min, high - low],
        "world_P_center": [(x_min + x_max) / 2, (y_min + y_max) / 2, (low + high) / 2],
        "world_R_center": NO_TURN,
    }


def _describe_room(room: Room, storey: Storey, height: float) -> dict[str, Any]:
    x, y, _ = place_text(room)
    box = _make_box(room.polygon.bounds, height, height + WALL_HEIGHT)
    sets = [room.label_probabilities[each] for each in room.labels if each in room.label_probabilities]
    probabilities = sets[-1] if sets else {room.label: 1.0} if room.label else {}
    rings = (room.polygon.exterior, *room.polygon.interiors)
    return {
        **_describe("RoomNodeAttributes", room.title or f"Room {room.id}", (x, y, height), box),
        "semantic_class_probabilities": dict(probabilities),
        "metadata": {
            "room": room.id,
            "storey": storey.name,
            "label": room.label or "",
            "polygon": [shapely.get_coordinates(ring).round(3).tolist() for ring in rings],
        },
    }


def _make_building(building: Building, heights: list[float]) -> dict[str, Any]:
    outlines = [room.polygon for _, room in building.list_rooms()]
    bounds = tuple(map(float, shapely.total_bounds(outlines))) if outlines else (0.0,) * 4
    box = _make_box(bounds, min(heights), max(heights) + WALL_HEIGHT)
    middle = tuple(box["world_P_center"])
    attributes = {**_describe("SemanticNodeAttributes", building.name or "Building", middle, box), "metadata": {}}
    return _make_node(node_id("B", 0), "BUILDINGS", attributes)
