"""Maps that show a building in part, with all its true rooms: the real ones of data/partial, and simulated ones."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, STRtree

from pianta.errors import BuildingWarning, DataError, MapError
from pianta.floor import Floor, Room, scale_floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io._files import short_repr
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.maps import read_map
from pianta.layout._label_images import largest_part, outline_labels
from pianta.layout.partial.predict import measure_half_wall
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta.worlds.partial_scan import simulate_partial_map
from pianta.worlds.scan import simulate_map
from pianta.worlds.simulated_readings import ASPECT_SPREAD, RESOLUTION, SIZE_SPREAD, inset_room
from pianta.worlds.wall_axes import INNER_WALL
from pianta_bench.data.color_truth import read_color_truth
from pianta_bench.data.folders import REMEDY, SLAM_RESOLUTION

FOLDER = "partial"
STEPS = "steps.json"
SIMULATED = "simulated"
# A coloured truth shows the visible part; the last one of a run is the truth for the whole run.
COLORED_RUN = "r"  # name of the run with coloured truths
COLORED_RESOLUTION = 0.05  # m per cell
# Ranges of the simulated explorations and surroundings; all chosen by hand.
SHARES = (0.15, 0.9)  # of the doors that the robot visits
REACHES = (8.0, 12.0, 20.0, 30.0, 40.0)  # m, of the lidar
ENTERED = (0.1, 0.9)  # probability that it enters the room behind a door
MOST_NOISE = 0.7  # of simulate_map, from 0 to 1
MOST_FURNITURE = 0.8  # of simulate_map, where 1 is usual furniture
MOST_YAW = 0.8  # rad, between the walls and the axes of the map
SIMULATED_COUNT = 24  # worlds of the bench
FIRST_SEED = 40_000  # of these worlds; the model was fitted on others


@dataclass(frozen=True, eq=False)
class PartialMap:
    """A map that shows a part of a building. rooms: all true rooms, to the middle of their walls, map frame."""

    item: str
    grid: GridMap
    rooms: Sequence[Polygon]


@dataclass(frozen=True)
class MapOfRun:
    """Where a real partial map and its truth are.

    affine: shape (2, 3), from x, y of the layout XML to col, row of the map; None where the truth is a picture.
    """

    item: str
    run: str
    image: Path
    truth: Path
    affine: tuple[tuple[float, ...], ...] | None

    def read(self) -> PartialMap:
        """The map and its true rooms; raises PiantaError when one cannot be read."""
        resolution = SLAM_RESOLUTION if self.affine else COLORED_RESOLUTION
        grid = read_map(self.image, resolution=resolution)
        rooms = self._read_layout(grid) if self.affine else _outline_colors(self.truth, grid)
        return PartialMap(self.item, grid, rooms)

    def _read_layout(self, grid: GridMap) -> list[Polygon]:
        """The true rooms by the layout XML, metres in the map frame; only the largest part of each."""
        # On this grid of one cell of 1 m, x is the column and y = 1 - row.
        pixels = GridMap(np.array([[UNKNOWN]]), 1.0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", BuildingWarning)
            layout = read_building_xml(self.truth, grid=pixels)
        affine = np.array(self.affine)

        def move(xy: NDArray[np.float64]) -> NDArray[np.float64]:
            col, row = affine @ np.stack([xy[:, 0], 1 - xy[:, 1], np.ones(len(xy))])
            return np.column_stack(grid.pixel_to_map(row, col))

        return [largest_part(shapely.transform(room.polygon, move)) for room in layout.rooms]


def list_real_maps(data: Path) -> list[MapOfRun]:
    """The maps of data/partial whose whole building is known, by building, run and step.

    The last map of a run with coloured truths is left out: it has no truth beyond itself.
    Raises DataError if there are no maps, or if a list of steps cannot be used.
    """
    folders = sorted(file.parent for file in (data / FOLDER).glob(f"*/{STEPS}"))
    maps = [entry for folder in folders for entry in _list_steps(folder, data)]
    if not maps:
        raise DataError(f"no partial maps in {short_repr(data / FOLDER)}: no BUILDING/{STEPS} lists any, {REMEDY}")
    return maps


def _list_steps(folder: Path, data: Path) -> Iterator[MapOfRun]:
    """The maps that a folder lists, by run and step, with their truth; DataError if the list cannot be used."""
    file = folder / STEPS
    layout = data / "buildings" / "school" / f"{folder.name}.xml"
    try:
        steps = sorted(json.loads(file.read_text(encoding="utf-8")), key=lambda step: (step["run"], step["step"]))
        colored = [step for step in steps if step["run"] == COLORED_RUN]
        for step in steps:
            make = partial(MapOfRun, f"{folder.name}/{Path(step['file']).stem}", f"{folder.name} {step['run']}")
            if step["run"] != COLORED_RUN:
                yield make(folder / step["file"], layout, _check_affine(step))
            elif step is not colored[-1]:
                yield make(folder / step["file"], folder / colored[-1]["gt"], None)
    except (OSError, ValueError, KeyError, TypeError):
        raise DataError(f"{short_repr(file)} is no list of maps with file, run, step and affine, repair it") from None


def _check_affine(step: dict[str, Any]) -> tuple[tuple[float, ...], ...]:
    affine = np.array(step["affine"], float)
    if affine.shape != (2, 3) or not np.isfinite(affine).all():
        raise ValueError("no affine map")
    return tuple(tuple(row) for row in affine.tolist())


def _outline_colors(truth: Path, grid: GridMap) -> list[Polygon]:
    """Outlines of rooms in a picture of the truth, to the middle of their walls, metres in the map frame.

    The picture has rooms without walls. Raises MapError unless it has the map's shape.
    """
    labels = read_color_truth(truth)
    if labels.shape != grid.shape:
        raise MapError(f"truth {short_repr(truth)} has shape {labels.shape}, the map {grid.shape}")
    outlines, _ = outline_labels(labels)
    return grow_to_walls(
        [
            shapely.transform(outline, lambda xy: np.column_stack(grid.pixel_to_map(xy[:, 1], xy[:, 0])))
            for outline in outlines
        ]
    )


def grow_to_walls(rooms: Sequence[Polygon]) -> list[Polygon]:
    """Rooms that end at the faces of their walls, grown to the middle of the walls, but not into each other."""
    half_wall = measure_half_wall(Floor(tuple(Room(number, room) for number, room in enumerate(rooms, start=1))))
    polygons = np.array(rooms, dtype=object)
    grown = shapely.buffer(polygons, half_wall, join_style="mitre", mitre_limit=2)
    tree = STRtree(polygons)
    rest = [polygons[near[near != i]] for i, near in enumerate(map(tree.query, grown))]
    return [
        largest_part(shapely.difference(room, shapely.union_all(near))) for room, near in zip(grown, rest, strict=True)
    ]


def simulate_world(number: int, *, first_seed: int = FIRST_SEED) -> PartialMap:
    """A partial map of a generated floor."""
    seed = first_seed + number
    rng = np.random.default_rng(seed)
    shape = (*FLOOR_MAKERS,)[number % len(FLOOR_MAKERS)]
    floor = make_floor(shape, seed=seed)
    noise, furniture, yaw = _draw_surroundings(rng)
    grid = simulate_map(floor, noise=noise, furniture=furniture, yaw=yaw, seed=seed)
    rooms = [room.polygon.buffer(INNER_WALL / 2, join_style="mitre") for room in floor.rooms]
    return PartialMap(f"{shape}-{seed}", _explore(floor, grid, rng, seed), rooms)


def simulate_drawing(floor: Floor, *, seed: int) -> PartialMap:
    """A partial map of an annotated floor that is stretched a little at random.

    Raises MapError for a floor that cannot be mapped.
    """
    rng = np.random.default_rng(seed)
    size, aspect = np.exp(rng.normal(0, (SIZE_SPREAD, ASPECT_SPREAD)))
    scaled = scale_floor(floor, size * aspect, size / aspect)
    inner = tuple(door for door in scaled.doors if not door.is_entrance)
    walled = replace(scaled, rooms=tuple(map(inset_room, scaled.rooms)), doors=inner)
    noise, furniture, yaw = _draw_surroundings(rng)
    grid = simulate_map(walled, resolution=RESOLUTION, noise=noise, furniture=furniture, yaw=yaw, seed=seed)
    return PartialMap(
        f"{floor.source}-{seed}", _explore(walled, grid, rng, seed), [room.polygon for room in scaled.rooms]
    )


def _draw_surroundings(rng: np.random.Generator) -> tuple[float, float, float]:
    """Noise, furniture and yaw: half of the buildings are empty, and half of the robots start along the walls."""
    yaw = float(rng.choice([0.0, rng.uniform(-MOST_YAW, MOST_YAW)]))
    furniture = float(rng.choice([0.0, rng.uniform(0, MOST_FURNITURE)]))
    return MOST_NOISE * rng.random(), furniture, yaw


def _explore(floor: Floor, grid: GridMap, rng: np.random.Generator, seed: int) -> GridMap:
    reach, share, entered = float(rng.choice(REACHES)), rng.uniform(*SHARES), rng.uniform(*ENTERED)
    return simulate_partial_map(floor, grid, share=share, reach=reach, entered=entered, seed=seed)
