"""Draw the pictures of docs/methods/navigation.md: python docs/draw_navigation.py [--data DIR]."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import pianta
from pianta.gridmap import FREE, OCCUPIED, GridMap
from pianta.plot.figure import save_figure
from pianta.plot.navigation import plot_cleaning, plot_route_graph
from pianta.plot.picture import find_extent, new_picture, plot_scale_bar
from pianta_bench.data.folders import find_data

IMAGES = Path(__file__).parent / "images"
# Of the survey, with furniture.
MAP = "lab_c_scan_furnitures"
RESOLUTION = 0.05


def main() -> None:
    """Draw a route graph and a plan to clean, over the same map."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path)
    file = find_data(parser.parse_args().data) / "survey" / f"{MAP}.png"
    read = pianta.read_map(file, resolution=RESOLUTION)
    floor = pianta.reconstruct(read, predict_partial=False)
    # Furniture is drawn in light grey, which is read as unknown
    grid = GridMap(np.where(read.free, FREE, OCCUPIED).astype(np.int8), read.resolution, read.origin)
    for name in ("route_graph", "cleaning"):
        figure, ax = new_picture(find_extent(floor, None))
        if name == "cleaning":
            plot_cleaning(pianta.plan_cleaning(floor, grid), floor, grid=grid, ax=ax)
        else:
            plot_route_graph(pianta.build_route_graph(floor, grid), floor, grid=grid, ax=ax)
        plot_scale_bar(ax=ax)
        save_figure(figure, IMAGES / f"{name}.png")


if __name__ == "__main__":
    main()
