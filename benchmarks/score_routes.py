"""Score route graphs and cleaning plans on the maps of the survey, bare and furnished.

Run: OMP_NUM_THREADS=1 python benchmarks/score_routes.py [--json FILE] [--data DIR] [--map NAME ...]

Each map is read at 0.05 m per cell and reconstructed without predictions. Then every cell that is not free is an
obstacle: much of the furniture is drawn in light grey, which is read as unknown. The graph is written by
`pianta.convert`, read again, and measured by code of its own: closed cells by scipy's distance transform, edges by
samples each twentieth of a cell. Lengths are compared for all pairs of rooms that the open cells join, with the
shortest paths over these cells (8 neighbours, no corner of a closed cell is cut), and for up to 100 of these pairs,
drawn with a fixed seed, with the same paths straightened. The graph without a map joins
`polygon.representative_point()` of each room with the middles of its doors.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
import warnings
from itertools import combinations
from math import ceil, hypot
from pathlib import Path
from statistics import fmean, pstdev
from typing import Any

import networkx as nx
import numpy as np
from scipy.ndimage import distance_transform_edt

import pianta
from pianta._types import Mask
from pianta.exploration.routes import find_route, measure_distances, straighten_route
from pianta.floor import Floor
from pianta.gridmap import FREE, OCCUPIED, GridMap
from pianta.navigation.cleaning import measure_plain_sweep
from pianta.navigation.robot import ROBOT_RADIUS
from pianta_bench.data.folders import find_data

RESOLUTION = 0.05
SAMPLES_PER_CELL = 20
STRAIGHTENED_PAIRS = 100
COLUMNS = {
    "joined": "pairs of rooms with a door that the graph joins",
    "joinable": "those that the open cells join",
    "cut": "edges that touch a closed cell",
    "ratio": "mean length over that of the shortest path on the grid, 8 neighbours",
    "straight": "the same over straightened paths",
    "smaller": "open cells per node",
    "seconds": "of processor time to write the graph",
    "coverage": "share of the reachable floor that the plan sweeps",
    "overlap": "length times width over swept area, minus 1",
    "plain coverage": "the same of a plain sweep",
    "plain overlap": "the same of a plain sweep",
    "clean seconds": "of processor time to plan the cleaning",
    "naive points": "room points of the graph without a map that are in closed cells",
    "naive cut": "its edges that touch a closed cell",
}


def main() -> None:
    """Print a row for each map, and the mean and standard deviation of each set."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--map", action="append")
    options = parser.parse_args()
    folder = find_data(options.data) / "survey"
    bare = sorted(file.stem.removesuffix("_layout_gt") for file in folder.glob("*_layout_gt.xml"))
    rows: dict[str, dict[str, Any]] = {}
    for name in options.map or [*bare, *(f"{name}_furnitures" for name in bare)]:
        rows[name] = score_map(folder / f"{name}.png")
        print(name, " ".join(f"{key}={format_figure(value)}" for key, value in rows[name].items()), flush=True)
    for part in ("", "_furnitures"):
        chosen = [row for name, row in rows.items() if name.endswith("_furnitures") == bool(part)]
        for key in COLUMNS if chosen else ():
            values = [row[key] for row in chosen]
            print(f"{part or 'bare'}: {key}: {fmean(values):.3f} ± {pstdev(values):.3f}, {COLUMNS[key]}")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


def score_map(file: Path) -> dict[str, Any]:
    """All figures of a map."""
    warnings.simplefilter("ignore")
    read = pianta.read_map(file, resolution=RESOLUTION)
    floor = pianta.reconstruct(read, predict_partial=False)
    grid = GridMap(np.where(read.free, FREE, OCCUPIED).astype(np.int8), read.resolution, read.origin, read.source)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "route.geojson"
        start = time.process_time()
        pianta.convert(floor, path, to="nav2-route", grid=grid)
        seconds = time.process_time() - start
        graph = pianta.read_route_graph(path)
    is_open = grid.free & (distance_transform_edt(~grid.occupied) * RESOLUTION > ROBOT_RADIUS)
    start = time.process_time()
    plan = pianta.plan_cleaning(floor, grid)
    clean_seconds = time.process_time() - start
    plain = measure_plain_sweep(floor, grid, plan.rooms)
    return {
        "rooms": len(floor),
        "nodes": len(graph),
        "edges": graph.number_of_edges(),
        "cut": sum(cuts(grid, is_open, *(position(graph, node) for node in edge)) for edge in graph.edges),
        **compare_lengths(floor, grid, graph, is_open),
        "smaller": float(is_open.sum() / len(graph)),
        "seconds": seconds,
        "coverage": plan.swept.coverage,
        "overlap": plan.swept.overlap,
        "length": plan.swept.length,
        "plain coverage": plain.coverage,
        "plain overlap": plain.overlap,
        "plain length": plain.length,
        "left out": len(plan.left_out),
        "clean seconds": clean_seconds,
        **score_graph_without_map(floor, grid, is_open),
    }


def compare_lengths(floor: Floor, grid: GridMap, graph: nx.DiGraph, is_open: Mask) -> dict[str, float]:
    """Which pairs are joined, and how long the ways are."""
    cells = {room.id: find_cell(grid, *position(graph, room.id)) for room in floor if room.id in graph}
    on_grid = {room: measure_distances(is_open, [cell], resolution=RESOLUTION) for room, cell in cells.items()}
    on_graph = {room: nx.single_source_dijkstra_path_length(graph, room, weight="cost") for room in cells}
    pairs = [pair for pair in combinations(cells, 2) if np.isfinite(on_grid[pair[0]][cells[pair[1]]])]
    missing = [pair for pair in pairs if pair[1] not in on_graph[pair[0]] or pair[0] not in on_graph[pair[1]]]
    ratios = {(a, b): on_graph[a][b] / on_grid[a][cells[b]] for a, b in pairs if (a, b) not in missing}
    every = sorted(ratios)
    chosen = np.random.default_rng(0).permutation(len(every))[:STRAIGHTENED_PAIRS]
    straight = []
    for a, b in (every[index] for index in chosen):
        corners = straighten_route(find_route(on_grid[a], cells[b], resolution=RESOLUTION), is_open)
        straight.append(on_graph[a][b] / (float(np.hypot(*np.diff(corners, axis=0).T).sum()) * RESOLUTION))
    with_door = {door.rooms for door in floor.doors if not door.is_entrance}
    joined = [pair for pair in with_door if pair[0] in cells and pair[1] in on_graph[pair[0]]]
    joinable = [(a, b) for a, b in with_door if {a, b} <= cells.keys() and np.isfinite(on_grid[a][cells[b]])]
    return {
        "pairs with a door": len(with_door),
        "joined": len(joined),
        "joinable": len(joinable),
        "pairs not joined": len(missing),
        "ratio": fmean(ratios.values()),
        "largest ratio": max(ratios.values()),
        "straight": fmean(straight),
    }


def score_graph_without_map(floor: Floor, grid: GridMap, is_open: Mask) -> dict[str, float]:
    """The graph that joins a point of each room with the middles of its doors by straight edges."""
    points = {room.id: room.polygon.representative_point() for room in floor}
    closed = [not is_open[find_cell(grid, point.x, point.y)] for point in points.values()]
    cut = []
    for door in floor.doors:
        middle = door.line.interpolate(0.5, normalized=True)
        ends = [(points[room].x, points[room].y) for room in door.room_ids]
        cut += [cuts(grid, is_open, end, (middle.x, middle.y)) for end in ends]
    return {"naive points": fmean(closed), "naive cut": fmean(cut)}


def position(graph: nx.DiGraph, node: int) -> tuple[float, float]:
    """The x, y of a node."""
    return graph.nodes[node]["x"], graph.nodes[node]["y"]


def find_cell(grid: GridMap, x: float, y: float) -> tuple[int, int]:
    """The row and col of a position."""
    row, col = grid.map_to_pixel(x, y)
    return int(row), int(col)


def cuts(grid: GridMap, is_open: Mask, start: tuple[float, float], end: tuple[float, float]) -> bool:
    """Whether a straight line touches a closed cell."""
    count = ceil(hypot(end[0] - start[0], end[1] - start[1]) / RESOLUTION * SAMPLES_PER_CELL) + 2
    rows, cols = grid.map_to_pixel(np.linspace(start[0], end[0], count), np.linspace(start[1], end[1], count))
    return not is_open[np.floor(rows).astype(int), np.floor(cols).astype(int)].all()


def format_figure(value: float) -> str:
    """Whole numbers as they are, others with three digits."""
    return str(value) if isinstance(value, int) else f"{value:.3f}"


if __name__ == "__main__":
    main()
