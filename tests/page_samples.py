"""The files that the commands of the pages name, made small: maps, a plan, symbols, buildings and a model."""

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from PIL import Image

import pianta
from pianta.plan.symbols.drawings import draw_symbol
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.plans.drawing import draw_plan
from tests.labelled_floors import labelled_floors
from tests.typed_floors import make_office

NAMES = ("Classroom", "Office", "Store", "Kitchen", "Library")


def make_page_samples(folder: Path) -> None:
    """Write all of them into a folder."""
    _, grid = pianta.make_world("sample")
    for path in (folder / "map.yaml", folder / "demo" / "map.yaml"):
        path.parent.mkdir(exist_ok=True)
        grid.save(path)
    Image.open(folder / "map.png").save(folder / "scan.png")
    save_robot_files(folder)
    draw_page_plan(folder / "plan.png")
    (folder / "symbols").mkdir()
    Image.fromarray(draw_symbol("door", size_px=28)).save(folder / "symbols" / "door1.png")
    save_buildings(folder / "buildings")
    if find_spec("ifcopenshell"):
        save_ifc(folder / "plan.ifc")


def save_robot_files(folder: Path) -> None:
    """The map of a vacuum, the points of a floor, and a bag with a map that grows, if rosbags is installed."""
    floor, grid = pianta.make_world("corridor")
    pianta.convert(floor, folder / "vacuum.json", to="valetudo", grid=grid)
    save_points(grid, folder / "floor.ply")
    if find_spec("rosbags"):
        from tests.bag_files import GRID_TYPE, ROS1, make_grid_of_map, write_bag

        half = grid.cells.copy()
        half[:, grid.shape[1] // 2 :] = -1
        grids = (pianta.GridMap(half, grid.resolution, grid.origin), grid)
        write_bag(folder / "run.bag", [("/map", GRID_TYPE, make_grid_of_map(ROS1, each)) for each in grids])


def save_points(grid: pianta.GridMap, path: Path) -> None:
    """Points of the floor, and walls of 2 m, in the middle of each cell."""
    columns = [(grid.free, 0.0), *((grid.occupied, height) for height in np.arange(0.05, 2.0, 0.2))]
    points = []
    for mask, height in columns:
        rows, cols = np.nonzero(mask)
        x, y = grid.pixel_to_map(rows + 0.5, cols + 0.5)
        points.append(np.column_stack([x, y, np.full(len(x), height)]))
    table = np.concatenate(points).astype("<f4")
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(table)}\n"
    head += "".join(f"property float {name}\n" for name in "xyz") + "end_header\n"
    path.write_bytes(head.encode() + table.tobytes())


def draw_page_plan(path: Path) -> None:
    """A small plan with names in its rooms, which is quickly read."""
    floor = make_corridor_floor(seed=4, length=14.0)
    texts = {room.id: NAMES[room.id % len(NAMES)] for room in floor.rooms[1:]}
    Image.fromarray(draw_plan(floor, seed=4, style="double", px_per_metre=24, texts=texts).colors).save(path)


def save_ifc(path: Path) -> None:
    """A model of a house with two storeys."""
    ground, first = (make_corridor_floor(seed=seed, length=14.0) for seed in (4, 5))
    storeys = pianta.Storey(ground, "ground", 0.0, title="Ground"), pianta.Storey(first, "first", 3.0, title="First")
    pianta.convert(pianta.Building(storeys), path, to="ifc")


def save_buildings(folder: Path) -> None:
    """Labelled floors of both types that pianta knows."""
    for floor in labelled_floors():
        name = f"{floor.source.split()[0]}-{'ab'[int(floor.source.split()[2][0]) - 1]}"
        save_floor(replace(floor, source=name), folder / "school")
    for number, name in enumerate("abcde", start=2):
        save_floor(make_office(number, source=f"office-{name}"), folder / "office")


def save_floor(floor: pianta.Floor, folder: Path) -> None:
    """Write a floor into a folder, named after its source."""
    folder.mkdir(parents=True, exist_ok=True)
    floor.save(folder / f"{floor.source}.geojson")
