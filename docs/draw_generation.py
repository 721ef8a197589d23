"""Draw the pictures of docs/methods/generation.md: python docs/draw_generation.py."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import networkx as nx
import numpy as np
from draw_pictures import ACCENT, IMAGES, SHADE, WALL, frame, save
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image
from shapely import Polygon, box
from shapely.affinity import rotate

from pianta.batch.world_folders import FURNITURE, NOISE
from pianta.errors import DataError
from pianta.floor import Floor
from pianta.generation.buildings import BuildingSampler, generate_buildings
from pianta.generation.drawing.draw import draw_plan
from pianta.generation.drawing.site import choose_rooms
from pianta.generation.generate import generate
from pianta.generation.train import train_type
from pianta.generation.type_model import TypeFloor, TypeModel
from pianta.io.buildings.read import list_buildings, read_building
from pianta.labels import SCHOOL
from pianta.navigation.robot import ROBOT_RADIUS
from pianta.plot.figure import new_figure, save_figure
from pianta.plot.floor import plot_floor
from pianta.plot.graphs import draw_contact_sheet, place_nodes
from pianta.plot.grid import plot_grid
from pianta.plot.plan_sheet import add_shared_legend, draw_plan_sheet, plot_scaled_floor, show_with_scale
from pianta.worlds.furnish import furnish_for_robot
from pianta.worlds.scan import simulate_map
from pianta_bench.data.folders import find_data

FLOORS, SEED, COUNT = 16, 6, 18
PLANS = 6  # of the generated buildings, drawn as floors
WORLDS = 3  # of these, the smallest ones, furnished and scanned
# In metres: turned, an L, and with a court
OUTLINES = (
    rotate(box(0, 0, 62, 34), 25),
    Polygon([(0, 0), (62, 0), (62, 26), (26, 26), (26, 62), (0, 62)]),
    box(0, 0, 56, 48).difference(box(20, 20, 36, 30)),
)
WORLD_WIDTH = 5.0  # inches
WORLD_GRID = {"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.99, "wspace": 0.02, "hspace": 0.02}
LEGEND_GAP = 0.6  # inches, between scales and the legend
# Colours of the picture; with so few its file has a fifth of the size.
PALETTE = 128
# A wing of a synthetic school: the label of its corridor, and label -> fewest and most rooms behind it.
WINGS = (
    ("CORRIDOR", {"CLASSROOM": (3, 5), "WASHROOM": (1, 1), "STAIRS": (1, 1)}),
    ("CORRIDOR", {"SMALL ADMINISTRATIVE": (2, 3), "CLOSET": (1, 2), "CONFERENCE": (0, 1)}),
    ("LOBBY", {"ENTRANCE": (1, 2), "LIBRARY": (0, 1), "CANTEEN": (1, 1)}),
    ("HALL", {"GYM": (1, 1), "CLOSET": (1, 2), "WASHROOM": (2, 2)}),
)
# Paul Tol's "bright" scheme.
COLORS = ("#4477aa", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#bbbbbb", "#ee6677")
NODE_SIZE, CUT_WIDTH = 90, 2.6


def main() -> None:
    """Draw the method on synthetic schools, and buildings generated from real ones; without data, the latter stay."""
    random = np.random.default_rng(SEED)
    model = train_type([make_school(random) for _ in range(FLOORS)], schema=SCHOOL)
    draw_steps(model)
    try:
        files = list_buildings([find_data() / "buildings" / "school"])
    except DataError:
        return
    model = train_type([read_building(file) for file in files], schema=SCHOOL)
    buildings = generate_buildings(model, COUNT, seed=SEED)
    save_small(draw_contact_sheet(buildings, schema=SCHOOL), "generation")
    floors = [draw_plan(building, model, seed=number).floor for number, building in enumerate(buildings[:PLANS])]
    titles = [f"{len(floor)} rooms" for floor in floors]
    save_small(draw_plan_sheet(floors, titles, schema=SCHOOL), "drawn_plans")
    save_small(draw_outlines(model), "drawn_outlines")
    smallest = sorted(floors, key=len)[:WORLDS]
    save_small(draw_worlds(smallest), "drawn_worlds")


def draw_outlines(model: TypeModel) -> Figure:
    """Schools inside outlines, which are dashed."""
    figure = new_figure(WORLD_WIDTH * len(OUTLINES), WORLD_WIDTH)
    axes = figure.subplots(1, len(OUTLINES), squeeze=False, gridspec_kw=WORLD_GRID)[0]
    floors = []
    for outline, ax in zip(OUTLINES, axes, strict=True):
        (building,) = generate(model, 1, rooms=choose_rooms(outline, model), seed=SEED)
        floors.append(draw_plan(building, model, outline=outline).floor)
        plot_floor(floors[-1], ax=ax)
        for ring in (outline.exterior, *outline.interiors):
            ax.plot(*ring.xy, "--", color=ACCENT, linewidth=1.2)
        left, bottom, right, top = outline.buffer(1).bounds
        show_with_scale((left, bottom, right, top), ax)
    add_legend_below(figure, floors)
    return figure


def draw_worlds(floors: Sequence[Floor]) -> Figure:
    """Furnished floors, and below each the map that a robot would make of it."""
    figure = new_figure(WORLD_WIDTH * len(floors), 2 * WORLD_WIDTH)
    axes = figure.subplots(2, len(floors), squeeze=False, gridspec_kw=WORLD_GRID)
    worlds = [
        furnish_for_robot(each, furniture=FURNITURE, radius=ROBOT_RADIUS, seed=n) for n, each in enumerate(floors)
    ]
    for seed, (furnished, (above, below)) in enumerate(zip(worlds, axes.T, strict=True)):
        scan = simulate_map(furnished, noise=NOISE, seed=seed)
        plot_scaled_floor(furnished, ax=above)
        plot_grid(scan, ax=below)
        below.set(xlim=above.get_xlim(), ylim=above.get_ylim(), aspect="equal")
        below.set_axis_off()
    add_legend_below(figure, worlds)
    return figure


def add_legend_below(figure: Figure, floors: Sequence[Floor]) -> None:
    """Add the legend of the labels of all floors below the axes of a figure."""
    height = figure.get_figheight()
    below = add_shared_legend(figure, floors) + LEGEND_GAP
    figure.set_figheight(height + below)
    figure.subplots_adjust(bottom=(below + WORLD_GRID["bottom"] * height) / (height + below))


def save_small(figure: Figure, name: str) -> None:
    """Save a picture with few colours."""
    file = IMAGES / f"{name}.png"
    save_figure(figure, file)
    with Image.open(file) as picture:
        picture.convert("RGB").quantize(PALETTE).save(file, optimize=True)


def make_school(random: np.random.Generator) -> nx.Graph:
    """The graph of a school of two to five wings, each joined to one before it."""
    graph = nx.Graph()
    hubs: list[int] = []
    for wing in [2, *random.choice([0, 0, 1, 3], size=random.integers(1, 5))]:
        label, rooms = WINGS[wing]
        hub = len(graph)
        graph.add_node(hub, label=label)
        if hubs:
            graph.add_edge(hub, int(random.choice(hubs)))
        hubs.append(hub)
        for room, (fewest, most) in rooms.items():
            for _ in range(random.integers(fewest, most + 1)):
                graph.add_edge(hub, len(graph))
                graph.nodes[len(graph) - 1]["label"] = room
    return graph


def draw_steps(model: TypeModel) -> None:
    """Draw a floor cut into functional areas, the clusters, and the steps to a new building."""
    sampler = BuildingSampler(model)
    generators = [np.random.default_rng(SEED)]
    chosen = sampler.sample_areas(model.configurations[[largest(model)]], generators)
    (functional,) = sampler.join_areas(chosen, generators)
    (building,) = sampler.connect_rooms([[sampler.areas[area] for area in chosen[0]]], [functional], generators)
    clusters = model.clusters[chosen[0]].tolist()
    sizes = [len(model.areas[area]) for area in chosen[0]]
    figure = Figure(figsize=(16, 4.4), layout="constrained")
    axes = figure.subplots(1, 4)
    plot_type_floor(model.floors[largest(model)], ax=axes[0])
    plot_clusters(model, ax=axes[1])
    plot_functional_graph(functional, clusters, ax=axes[2])
    areas = np.repeat(np.arange(len(sizes)), sizes).tolist()
    plot_graph(
        building, {room: clusters[area] for room, area in enumerate(areas)}, find_doors(building, areas), ax=axes[3]
    )
    frame(axes[3], "Steps 3 and 4: any area of the cluster,\nand the doors between them (red)")
    save(figure, IMAGES / "generation_steps.png")


def largest(model: TypeModel) -> int:
    """The index of the floor with the most areas."""
    return int(model.configurations.sum(axis=1).argmax())


def find_doors(building: nx.Graph, areas: list[int]) -> list[tuple[int, int]]:
    """The doors between rooms of different areas."""
    return [(one, other) for one, other in building.edges if areas[one] != areas[other]]


def plot_type_floor(floor: TypeFloor, *, ax: Axes) -> None:
    """Plot a floor of the model, its rooms in the colours of their areas' clusters, its cuts red."""
    clusters = {room: cluster for area, cluster in zip(floor.areas, floor.clusters, strict=True) for room in area}
    cuts = [cut for cuts in floor.cuts.values() for cut in cuts]
    plot_graph(floor.graph, clusters, cuts, ax=ax)
    frame(ax, "The model: a floor is cut (red)\ninto functional areas")


def plot_clusters(model: TypeModel, *, ax: Axes) -> None:
    """Plot the first areas of each cluster, a row each."""
    for cluster in range(model.configurations.shape[1]):
        for column, area in enumerate(np.flatnonzero(model.clusters == cluster)[:3]):
            positions = place_nodes(model.areas[area])
            xy = np.array([*positions.values()])
            xy = (xy - xy.mean(axis=0)) / max(np.ptp(xy, axis=0).max(), 1.0) * 1.9
            shifted = {node: (2.6 * column + x, -2.6 * cluster + y) for node, (x, y) in zip(positions, xy, strict=True)}
            plot_graph(
                model.areas[area], dict.fromkeys(positions, cluster), [], ax=ax, positions=shifted, size=NODE_SIZE / 3
            )
        ax.annotate(str(cluster), (-1.9, -2.6 * cluster), ha="center", va="center", fontsize=13)
    frame(ax, "Similar areas of all floors\nare a cluster")


def plot_functional_graph(graph: nx.Graph, clusters: list[int], *, ax: Axes) -> None:
    """Plot the areas of a new building, with the numbers of their clusters."""
    positions = place_nodes(graph)
    for one, other in graph.edges:
        ax.plot(*zip(positions[one], positions[other], strict=True), color=WALL, linewidth=2, zorder=0)
    for area, (x, y) in positions.items():
        ax.scatter(x, y, s=900, color=COLORS[clusters[area] % len(COLORS)], edgecolors="black", zorder=1)
        ax.annotate(str(clusters[area]), (x, y), ha="center", va="center", fontsize=14)
    ax.margins(0.25)
    ax.set_aspect("equal", adjustable="datalim")
    frame(ax, "Steps 1 and 2: how many areas of each cluster,\nand which are joined")


def plot_graph(
    graph: nx.Graph,
    clusters: Mapping[int, int],
    marked: Collection[tuple[int, int]],
    *,
    ax: Axes,
    positions: Mapping[int, tuple[float, float]] | None = None,
    size: float = NODE_SIZE,
) -> None:
    """Plot rooms as circles, corridors as squares, in the colours of clusters; marked doors are red."""
    positions = place_nodes(graph) if positions is None else positions
    red = {frozenset(door) for door in marked}
    for one, other in graph.edges:
        is_marked = frozenset((one, other)) in red
        color, width = (ACCENT, CUT_WIDTH) if is_marked else (SHADE, 1.2)
        ax.plot(*zip(positions[one], positions[other], strict=True), color=color, linewidth=width, zorder=0)
    for node, label in graph.nodes(data="label"):
        marker = "s" if SCHOOL.by_name[label].room_or_corridor() == "CORRIDOR" else "o"
        color = COLORS[clusters[node] % len(COLORS)]
        ax.scatter(*positions[node], s=size, marker=marker, color=color, edgecolors="black", linewidths=0.8, zorder=1)
    ax.set_aspect("equal", adjustable="datalim")


if __name__ == "__main__":
    main()
