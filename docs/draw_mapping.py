"""Draw the picture and the animation of docs/methods/mapping.md: python docs/draw_mapping.py."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path

import numpy as np
from draw_pictures import IMAGES, frame, save
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from pianta.building_types.growing_map_types import read_default_growing_map_type_model
from pianta.exploration.explore import explore
from pianta.exploration.policies import make_policy
from pianta.exploration.record import Exploration
from pianta.exploration.world import build_world
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.labels import SCHEMAS
from pianta.mapping.mapper import Mapper
from pianta.plot.floor import plot_floor
from pianta.plot.picture import Extent, find_extent, show_extent
from pianta.plot.plan_sheet import add_shared_legend
from pianta.rooms.training import train_rooms
from pianta_bench.data.annotated_floors import read_annotated_buildings, set_building_type
from pianta_bench.data.folders import find_data
from pianta_bench.online.measure import choose_update_scans

ITEM = "bluefieldschoolfirstfloor"
SHARES = (0.25, 0.5, 0.75, 1.0)  # of the area
FRAMES = 24
FRAME_SIZE = (5.0, 5.4)  # inches
FRAME_DPI = 80
FRAME_MS, LAST_FRAME_MS = 400, 4000
COLORS = 64


@dataclass(frozen=True)
class Hypothesis:
    """What the robot knew at a share of the area, after some metres."""

    share: float
    metres: float
    floor: Floor
    grid: GridMap


def main() -> None:
    """Explore a school with models that were trained without it, and draw what a mapper understands on the way."""
    floors, _ = read_annotated_buildings(
        find_data(None), "school", lambda each: replace(each, floor=set_building_type(each.floor, "school"))
    )
    (school,) = (each for each in floors if each.item == ITEM)
    others = [each.floor for each in floors if each.building != school.building]
    mapper = Mapper(
        room_model=train_rooms(others), type_model=read_default_growing_map_type_model().leave_out(school.building)
    )
    run = explore(build_world(school.floor), make_policy("gain"))
    way = [*follow(mapper, run)]
    extent = find_extent(way[-1].floor, way[-1].grid)
    figure = Figure(figsize=(15, 6))
    stages = [next(each for each in way if each.share >= share - 1e-9) for share in SHARES]
    for ax, hypothesis in zip(figure.subplots(1, len(SHARES)).flat, stages, strict=True):
        plot_hypothesis(hypothesis, extent, ax=ax)
    below = (
        add_shared_legend(figure, [replace(each.floor, furniture=()) for each in stages], schemas=SCHEMAS)
        / figure.get_figheight()
    )
    figure.subplots_adjust(left=0.005, right=0.995, top=0.93, bottom=below, wspace=0.02)
    save(figure, IMAGES / "mapping.png")
    shares = np.array([each.share for each in way])
    chosen = np.unique(np.searchsorted(shares, np.linspace(shares[0], shares[-1], FRAMES) - 1e-9))
    save_animation([way[number] for number in chosen], extent)


def follow(mapper: Mapper, run: Exploration) -> Iterator[Hypothesis]:
    """The hypotheses of a mapper that gets the map every few metres, and at the end."""
    # At the first scan the robot sees no room yet
    for scan in choose_update_scans(run)[1:]:
        grid = run.map_at(scan)
        share, metres = float(run.share[scan] / run.share[-1]), float(run.distance[scan])
        yield Hypothesis(share, metres, mapper.update(grid).floor, grid)


def plot_hypothesis(hypothesis: Hypothesis, extent: Extent, *, ax: Axes) -> Axes:
    """Draw a hypothesis in an extent, with what the robot knows of the building above it."""
    floor = hypothesis.floor
    plot_floor(floor, hypothesis.grid, ax=ax, furniture=False, schemas=SCHEMAS)
    show_extent(extent, ax)
    types = ", ".join(f"{name} {probability:.2f}" for name, probability in floor.building_type.items())
    title = (
        f"{hypothesis.metres:.0f} m, {hypothesis.share:.0%} of the area\n{len(floor)} rooms, {types or 'type unknown'}"
    )
    return frame(ax, title)


def save_animation(way: list[Hypothesis], extent: Extent) -> None:
    """Write mapping.gif."""
    pictures = []
    for each in way:
        figure = Figure(figsize=FRAME_SIZE, layout="compressed")
        plot_hypothesis(each, extent, ax=figure.subplots())
        file = BytesIO()
        figure.savefig(file, dpi=FRAME_DPI)
        pictures.append(Image.open(file).convert("RGB").quantize(COLORS, dither=Image.Dither.NONE))
    durations = [FRAME_MS] * (len(pictures) - 1) + [LAST_FRAME_MS]
    path = Path(IMAGES / "mapping.gif")
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=durations, loop=0, optimize=True)


if __name__ == "__main__":
    main()
