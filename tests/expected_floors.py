"""Small maps and models for tests of policies: rooms with two unopened doors, and schools."""

from collections.abc import Sequence
from functools import cache

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from shapely import LineString, box

from pianta.exploration.frontiers import Frontier
from pianta.exploration.lidar import Pose
from pianta.exploration.policy_input import PolicyInput
from pianta.exploration.recognised_rooms import RecognisedRoom, RecognisedRooms
from pianta.floor import Door, Floor, Room
from pianta.generation.type_model import learn_type
from pianta.labels import SCHEMAS
from pianta.prediction.unexplored_part import FloorSampler

# Doors 5 and 7 of the true floor are unopened: in the library, at x = 0, and at the far end of the corridor.
LIBRARY_DOOR, CORRIDOR_DOOR = -6, -8
ROOMS = (
    Room(1, box(0, 0, 20, 3), "CORRIDOR"),
    Room(2, box(0, 3, 4, 7), "LIBRARY"),
    Room(3, box(4, 3, 8, 7), "CLASSROOM"),
)


def recognised_rooms() -> RecognisedRooms:
    """A corridor, a library and a classroom that robots recognised."""
    doors = (Door((1, 2), LineString([(1, 3), (2, 3)]), 1.0), Door((1, 3), LineString([(5, 3), (6, 3)]), 1.0))
    rooms = tuple(RecognisedRoom(room.id, room.label, room.polygon.area, 1.0, entered=room.id != 3) for room in ROOMS)
    lines = LineString([(0, 5), (0, 6)]), LineString([(20, 1), (20, 2)])
    return RecognisedRooms(rooms, Floor(ROOMS, doors), ((2, 5), (1, 7)), lines)


def make_school(classrooms: int) -> nx.Graph:
    """A corridor with classrooms of 50 m², and a library of 80 m², the only room with a door to a gym of 300 m²."""
    graph = nx.Graph(source=f"school {'abcdef'[classrooms]}.xml")
    graph.add_node(0, label="CORRIDOR", area=60.0)
    for room in range(1, classrooms + 1):
        graph.add_node(room, label="CLASSROOM", area=50.0)
        graph.add_edge(0, room)
    graph.add_node(classrooms + 1, label="LIBRARY", area=80.0)
    graph.add_node(classrooms + 2, label="GYM", area=300.0)
    graph.add_edges_from([(0, classrooms + 1), (classrooms + 1, classrooms + 2)])
    return graph


@cache
def school_sampler() -> FloorSampler:
    """A sampler of a model of four schools with two to five classrooms."""
    return FloorSampler(learn_type([make_school(number) for number in range(2, 6)], SCHEMAS["school"]))


def make_policy_input(
    points: Sequence[tuple[float, float]],
    distances: Sequence[Sequence[float]],
    *,
    lengths: Sequence[float] | None = None,
    rooms: Sequence[int] | None = None,
    recognised: RecognisedRooms | None = None,
    cells: NDArray[np.int8] | None = None,
) -> PolicyInput:
    """Robots and frontiers at points of a map of 25 × 10 m in cells of 0.5 m, unknown except for the corridor."""
    if cells is None:
        cells = np.full((20, 50), -1, np.int8)
        cells[14:20, :40] = 0
    targets = [(19 - int(2 * y), int(2 * x)) for x, y in points]
    frontiers = tuple(
        Frontier(np.array([target]), target, length, number)
        for number, (target, length) in enumerate(zip(targets, lengths or [1.0] * len(points), strict=True))
    )
    poses = tuple(Pose(1, 1) for _ in distances)
    in_rooms = tuple(rooms or [0] * len(points))
    return PolicyInput(
        cells,
        cells == 0,
        0.5,
        (0.0, 0.0, 0.0),
        poses,
        frontiers,
        np.array(distances, float),
        np.array(points, float),
        in_rooms,
        reach=8.0,
        recognised=recognised,
    )


def sight_only_weights() -> dict[str, NDArray[np.float64]]:
    """Weights of a perceptron that returns the first of its ten measures, the area in sight."""
    identity = np.zeros((10, 1))
    identity[0] = 1
    return {
        "mean": np.zeros(10),
        "spread": np.ones(10),
        "weights 0": identity,
        "bias 0": np.zeros(1),
        "weights 1": np.ones((1, 1)),
        "bias 1": np.zeros(1),
    }
