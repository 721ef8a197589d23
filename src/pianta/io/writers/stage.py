"""A world of Stage: an image of the walls, the world that uses it, and a map.yaml of the same image."""

from __future__ import annotations

from math import ceil
from pathlib import Path

import numpy as np
import shapely

from pianta.building import Building, Storey
from pianta.errors import OptionError
from pianta.floor import cells_of_polygon
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.io._files import MAX_CELLS, count_noun
from pianta.io._folders import choose_names
from pianta.io.ros_maps import save_ros_map
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.wall_parts import WALL_HEIGHT, find_walls

RESOLUTION = 0.05  # metres per pixel where there is no map
MARGIN = 1.0  # metres around the walls
DOOR_DEPTH = 0.1  # metres on both sides of a door that are free of walls, with corners that stand out
WINDOW = (900, 700)  # pixels

WORLD = """\
# Written by pianta: {rooms}.
resolution {resolution:.4f}
interval_sim 100

window
(
  size [ {window[0]} {window[1]} ]
  center [ {x:.3f} {y:.3f} ]
  scale {scale:.3f}
)

define floorplan model
(
  color "gray30"
  boundary 0
  gui_nose 0
  gui_grid 0
  gui_outline 0
  gripper_return 0
  fiducial_return 0
  ranger_return 1
)

floorplan
(
  name "{name}"
  bitmap "{name}.png"
  size [ {width:.4f} {height:.4f} {wall_height} ]
  pose [ {x:.4f} {y:.4f} 0 0 ]
)
"""


def write_stage(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """For each storey its world, its image, and the YAML of a ROS map."""
    plain = ["".join(letter if letter.isalnum() else "_" for letter in storey.name) or "floor" for storey in building]
    numbered = [f"{name}_{number}" for number, name in enumerate(plain)]
    for storey, name in zip(building, choose_names(plain, numbered), strict=True):
        grid = draw_grid(storey)
        save_ros_map(grid, target / f"{name}.yaml")
        (target / f"{name}.world").write_text(_describe_world(grid, name, storey), encoding="utf-8")
    notes = ["each storey is a world of its own"] if len(building) > 1 else []
    if building.links:
        notes.append(f"Stage holds no {count_noun(len(building.links), 'link')} between storeys, left out")
    return notes


def draw_grid(storey: Storey) -> GridMap:
    """The walls and the furniture of a storey as occupied cells, its rooms and doors as free ones; no yaw."""
    floor = storey.floor
    resolution = storey.grid.resolution if storey.grid else RESOLUTION
    solid = [part.area.buffer(resolution / 2, join_style="mitre") for part in find_walls(floor).solid]
    rooms = [room.polygon for room in floor]
    shapes = [*solid, *rooms]
    low_x, low_y, high_x, high_y = shapely.total_bounds(shapes) if shapes else np.zeros(4)
    low = np.floor(np.array([low_x, low_y]) - MARGIN)
    width, height = np.array([high_x, high_y]) + MARGIN - low
    cols, rows = ceil(width / resolution), ceil(height / resolution)
    if cols * rows > MAX_CELLS:
        raise OptionError(
            f"the image of {width:.0f} m × {height:.0f} m would have {cols} × {rows} pixels, the limit is {MAX_CELLS} "
            "in all; correct the floor, or read a part of it"
        )
    cells = np.full((rows, cols), UNKNOWN, np.int8)
    grid = GridMap(cells, resolution, (float(low[0]), float(low[1]), 0.0))
    doors = [door.line.buffer(DOOR_DEPTH, cap_style="flat") for door in floor.doors if door.line.length]
    filled = cells.copy()
    furniture = [piece.polygon for piece in floor.furniture]
    layers = ((rooms, FREE), (solid, OCCUPIED), (doors, FREE), (furniture, OCCUPIED))
    for areas, value in layers:
        for area in areas:
            rows_of, cols_of, inside = cells_of_polygon(area, grid)
            filled[rows_of, cols_of][inside] = value
    return GridMap(filled, resolution, grid.origin)


def _describe_world(grid: GridMap, name: str, storey: Storey) -> str:
    rows, cols = grid.cells.shape
    width, height = cols * grid.resolution, rows * grid.resolution
    return WORLD.format(
        rooms=count_noun(len(storey.floor), "room"),
        resolution=grid.resolution,
        window=WINDOW,
        scale=min(WINDOW[0] / width, WINDOW[1] / height),
        name=name,
        width=width,
        height=height,
        wall_height=WALL_HEIGHT,
        x=grid.origin[0] + width / 2,
        y=grid.origin[1] + height / 2,
    )
