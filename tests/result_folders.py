"""Folders of results as `pianta predict`, `explore`, `generate` and `realism` write them, with simple figures."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
from shapely import LineString, box

from pianta.floor import Door, Floor, Room
from pianta.gridmap import FREE, UNKNOWN, GridMap
from pianta.io.floors import describe_floor, save_floor
from pianta.io.graphs import save_graph
from tests.served_floors import FLOOR, make_grid

SPREAD = {"mean": 2.0, "low": 1.0, "high": 4.0}
# Rooms 1 and 3 of FLOOR are known; behind the door to room 2 is something.
PREDICTED_FLOOR = replace(
    FLOOR,
    rooms=(FLOOR.rooms[0], replace(FLOOR.rooms[1], label=None, name=None, partial=True), FLOOR.rooms[2]),
    doors=FLOOR.doors[:2],
)


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(content), encoding="utf-8")


def describe_prediction(**members: Any) -> dict[str, Any]:
    """The content of prediction.json."""
    end = {"kind": "door", "room": 2, "near": 3, "labels": {"KITCHEN": 0.6, "OFFICE": 0.3}, "leads_on": 0.25}
    return {
        "format": "pianta prediction",
        "version": "1.0",
        "source": "floor.geojson",
        "building_type": "office",
        "samples": 2,
        "known": [1, 3],
        "rooms": SPREAD,
        "area": None,
        "unknown": {"KITCHEN": SPREAD},
        "open_ends": [{**end, "rooms": SPREAD, "area": None}],
        **members,
    }


def make_sample(label: str) -> nx.Graph:
    """Rooms 3 and 1, what is behind the door to room 2, and a room of 8 m² behind that."""
    graph = nx.Graph(source="sample", building_type="office")
    graph.add_node(0, label="CORRIDOR", room=3)
    graph.add_node(1, label="OFFICE", room=1)
    graph.add_node(2, label=label, door=2)
    graph.add_node(3, label="STORAGE", area=8.0)
    graph.add_edges_from([(0, 1), (0, 2), (2, 3)])
    return graph


def write_prediction(folder: Path, *, outlines: bool = True, **members: Any) -> Path:
    """A prediction with two samples, over a floor if it has outlines."""
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / "prediction.json", describe_prediction(**members))
    for number, label in enumerate(("KITCHEN", "OFFICE"), start=1):
        save_graph(make_sample(label), folder / f"sample-{number:03}.json")
    if outlines:
        save_floor(PREDICTED_FLOOR, folder / "explored.geojson")
        make_grid().save(folder / "explored.npz")
    return folder


def write_exploration(folder: Path, steps: Sequence[int] = (1, 3), **members: Any) -> Path:
    """An exploration; steps: the number of rooms of FLOOR in each, from room 1."""
    folder.mkdir(parents=True, exist_ok=True)
    described = []
    for number, rooms in enumerate(steps, start=1):
        name = f"step-{number:03}"
        cells = np.full((60, 90), UNKNOWN, np.int8)
        cells[: 10 * number] = FREE
        GridMap(cells, 0.1, (-0.3, -0.3, 0.0)).save(folder / f"{name}.npz")
        doors = FLOOR.doors if rooms == len(FLOOR) else ()
        save_floor(replace(FLOOR, rooms=FLOOR.rooms[:rooms], doors=doors), folder / f"{name}.geojson")
        figures = {"distance": 5.0 * number, "time": 60.0 * number, "area": 10.0 * rooms, "share": rooms / 3}
        described.append({"name": name, "scan": number, "pose_counts": [number], **figures})
    content = {
        "format": "pianta exploration",
        "version": "1.0",
        "world": "corridor",
        "policy": "nearest",
        "outcome": "done",
        "reachable_area": 30.0,
        "tracks": [[[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [3.0, 1.0, 0.0]]],
        "steps": described,
        **members,
    }
    write_json(folder / "exploration.json", content)
    return folder


def write_buildings(folder: Path, sizes: Sequence[int] = (2, 4, 3), label: str = "CLASSROOM") -> Path:
    """Generated buildings: a corridor with rooms around it; sizes: how many."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, size in enumerate(sizes, start=1):
        graph = nx.star_graph(size)
        nx.set_node_attributes(graph, label, "label")
        graph.nodes[0]["label"] = "CORRIDOR"
        graph.graph.update(source=f"building-{number:03}", building_type="school")
        save_graph(graph, folder / f"building-{number:03}.json")
    return folder


def write_realism(folder: Path, scores: Mapping[str, float]) -> Path:
    """Results of realism for floors of two rooms; scores: by the names of the floors."""
    folder.mkdir(parents=True, exist_ok=True)
    rooms = (Room(1, box(0, 0, 4, 3), "FUNCTIONAL"), Room(2, box(4, 0, 8, 3), "SERVICE"))
    floor = Floor(rooms, (Door((1, 2), LineString([(4, 1), (4, 2)]), 1.0),))
    floors = [
        {
            "floor": name,
            "labels_by_pianta": [],
            "left_out": False,
            "score": score,
            "verdict": f"typicality {score}",
            "typicality": score,
            "probability": None,
            "likeness": 0.5,
            "usual_likenesses": [0.5],
            "alike": ["a.xml"],
            "measures": [{"measure": "nodes", "name": "rooms", "value": 2, "reason": "the floor is small"}],
            "patterns": [],
            "shapes": describe_floor(floor),
        }
        for name, score in scores.items()
    ]
    content = {"pianta": "0", "label_set": "F/C/E/S", "reference": ["a.xml"], "unrealistic": [], "floors": floors}
    write_json(folder / "realism.json", content)
    return folder
