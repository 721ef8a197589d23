"""The factors that make a map worse, and the maps of a floor at their levels; all other factors stay clean."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import inf
from types import MappingProxyType

import networkx as nx
import numpy as np

from pianta._types import LabelImage
from pianta.floor import Floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.worlds.partial_scan import choose_viewpoints, find_visible_cells
from pianta.worlds.scan import label_displaced_rooms, simulate_map

# Cells of the maps, as in the survey; metres.
RESOLUTION = 0.05


@dataclass(frozen=True, eq=False)
class WorseMap:
    """A map, and its true rooms: their ids where they are on this map, shape (H, W), also under furniture."""

    grid: GridMap
    truth: LabelImage


@dataclass(frozen=True)
class Factor:
    """What makes a map worse.

    clean: the level of the clean map. levels: the others, from little to much; chosen by hand. unit: of a level.
    simulate: the map of a floor at a level, by a seed. The random numbers do not depend on the level.
    """

    title: str
    clean: float
    levels: tuple[float, ...]
    unit: str
    simulate: Callable[[Floor, float, int], WorseMap]

    def choose_levels(self, count: int) -> list[float]:
        """Some levels, evenly chosen, with the last one."""
        return [self.levels[-1 - step * len(self.levels) // count] for step in reversed(range(count))]

    def name_level(self, level: float) -> str:
        """A level as tables and figures have it."""
        if level == self.clean:
            return "clean"
        return f"{100 * level:g} %" if self.unit == "%" else f"{level:g} {self.unit}".rstrip()


def add_noise(floor: Floor, level: float, seed: int) -> WorseMap:
    """Specks, holes, rough and missing walls, without drift; level: the noise of simulate_map."""
    grid = simulate_map(floor, resolution=RESOLUTION, noise=level, drift=0.0, seed=seed)
    return WorseMap(grid, label_displaced_rooms(floor, grid, noise=level, drift=0.0, seed=seed))


def add_drift(floor: Floor, level: float, seed: int) -> WorseMap:
    """Walls bent by a smooth displacement of at most `level` metres along each axis; the true rooms bend with them."""
    grid = simulate_map(floor, resolution=RESOLUTION, drift=level, seed=seed)
    return WorseMap(grid, label_displaced_rooms(floor, grid, noise=0.0, drift=level, seed=seed))


def add_furniture(floor: Floor, level: float, seed: int) -> WorseMap:
    """Furniture by the labels of rooms, also in corridors; level: its density."""
    grid = simulate_map(floor, resolution=RESOLUTION, furniture=level, dense_furniture=True, seed=seed)
    return WorseMap(grid, label_displaced_rooms(floor, grid, noise=0.0, drift=0.0, seed=seed))


def shut_doors(floor: Floor, share: float, seed: int) -> Floor:
    """The floor without a share of its doors, rounded; a door that is shut at one share is shut at all higher ones.

    Openings stay.
    """
    doors = [index for index, door in enumerate(floor.doors) if door.kind != "opening"]
    order = np.random.default_rng(seed).permutation(doors)
    shut = {int(index) for index in order[: round(share * len(doors))]}
    return replace(floor, doors=tuple(door for index, door in enumerate(floor.doors) if index not in shut))


def remove_doors(floor: Floor, level: float, seed: int) -> WorseMap:
    """A share of the doors is a wall on the map; all rooms are still on it, as they were mapped at another time."""
    grid = simulate_map(shut_doors(floor, level, seed), resolution=RESOLUTION, seed=seed)
    return WorseMap(grid, label_displaced_rooms(floor, grid, noise=0.0, drift=0.0, seed=seed))


def limit_reach(floor: Floor, level: float, seed: int) -> WorseMap:
    """Only what a lidar of a reach detects, metres, after a robot has been at every door and in every room."""
    grid = simulate_map(floor, resolution=RESOLUTION, seed=seed)
    truth = label_displaced_rooms(floor, grid, noise=0.0, drift=0.0, seed=seed)
    if level == inf:
        return WorseMap(grid, truth)
    observed = np.zeros(grid.shape, bool)
    for part in list_connected_parts(floor):
        for viewpoint in choose_viewpoints(part, share=1.0, entered=1.0, seed=seed):
            observed |= find_visible_cells(grid, viewpoint, reach=level)
    return WorseMap(replace(grid, cells=np.where(observed, grid.cells, UNKNOWN)), truth)


def list_connected_parts(floor: Floor) -> list[Floor]:
    """The floor, divided into parts that no door joins."""
    graph = nx.Graph()
    graph.add_nodes_from(room.id for room in floor.rooms)
    graph.add_edges_from(door.rooms for door in floor.doors if not door.is_entrance)
    return [
        replace(
            floor,
            rooms=tuple(room for room in floor.rooms if room.id in part),
            doors=tuple(door for door in floor.doors if part.issuperset(door.room_ids)),
        )
        for part in nx.connected_components(graph)
    ]


FACTORS: Mapping[str, Factor] = MappingProxyType(
    {
        "noise": Factor("noise", 0.0, (0.25, 0.5, 0.75, 1.0), "", add_noise),
        "drift": Factor("drift", 0.0, (0.1, 0.2, 0.4, 0.8), "m", add_drift),
        "furniture": Factor("furniture", 0.0, (0.5, 1.0, 1.5, 2.0), "", add_furniture),
        "doors": Factor("doors shut", 0.0, (0.25, 0.5, 0.75, 1.0), "%", remove_doors),
        "reach": Factor("reach of the lidar", inf, (10.0, 6.0, 4.0, 2.5), "m", limit_reach),
    }
)
