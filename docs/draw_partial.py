"""Draw the picture of docs/methods/partial-rooms.md: python docs/draw_partial.py."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure
from shapely import total_bounds

from pianta.layout.reconstruct import reconstruct
from pianta.plot.floor_parts import plot_doors, plot_rooms, plot_walls
from pianta.plot.grid import plot_grid
from pianta.worlds.floors import make_l_floor
from pianta.worlds.partial_scan import simulate_partial_map
from pianta.worlds.scan import simulate_map
from pianta_bench.harness.charts import save_chart

IMAGES = Path(__file__).parent / "images"
SEED, DPI, MARGIN = 5, 110, 1.0


def main() -> None:
    """Draw a partly explored floor: its walls, its predicted rooms, and the truth as red lines."""
    true = make_l_floor(seed=SEED)
    grid = simulate_partial_map(
        true, simulate_map(true, noise=0.3, seed=SEED), share=0.7, reach=12, entered=0.3, seed=SEED
    )
    floor = reconstruct(grid)
    left, bottom, right, top = total_bounds([room.polygon for room in true.rooms])
    figure = Figure(figsize=(13, 5.2), layout="constrained")
    titles = ("the map, and the lines of its walls", "the rooms, their predicted extent, and the truth, red")
    for ax, title in zip(figure.subplots(1, 2), titles, strict=True):
        plot_grid(grid, ax=ax)
        ax.set(xlim=(left - MARGIN, right + MARGIN), ylim=(bottom - MARGIN, top + MARGIN), aspect="equal", title=title)
        ax.set_axis_off()
    walls, rooms = figure.axes
    plot_walls(floor, ax=walls)
    plot_rooms(floor, ax=rooms)
    plot_doors(floor, ax=rooms)
    for room in true.rooms:
        rooms.plot(*room.polygon.exterior.xy, color="#cc3311", linewidth=0.8)
    IMAGES.mkdir(exist_ok=True)
    save_chart(figure, IMAGES / "partial.png", dpi=DPI)


if __name__ == "__main__":
    main()
