"""Draw the pictures of the README and of docs/: `make docs`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import networkx as nx
import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from pianta._types import Floats, LabelImage
from pianta.errors import DataError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.layout._voronoi_doors import compute_clearance, draw_voronoi_diagram
from pianta.layout._working_grid import WorkingGrid, remove_clutter, to_working_grid
from pianta.layout.parameters import StructureParameters, ThesisParameters
from pianta.layout.reconstruct import reconstruct
from pianta.layout.structure.evidence import DOOR, FLOOR, FURNITURE, OUTSIDE
from pianta.layout.structure.evidence import WALL as WALL_CLASS
from pianta.layout.structure.explain import ConsideredBorders, explain_structure
from pianta.layout.structure.reconstruct import Division, divide_floor
from pianta.layout.thesis.affinity import find_partial_faces
from pianta.layout.thesis.contour import compute_map_contour
from pianta.layout.thesis.faces import Faces, cut_lines, find_faces, label_faces, share_free, share_inside
from pianta.layout.thesis.lines import RepresentativeLine, cluster_angles, get_representative_lines
from pianta.layout.thesis.segments import detect_edges, detect_segments
from pianta.plot.figure import save_figure
from pianta.plot.floor import draw_floor
from pianta.plot.floor_parts import plot_doors, plot_furniture, plot_rooms
from pianta.plot.room_marks import plot_graph
from pianta.plot.styles import ROOM_COLORS
from pianta.rooms.label import label_rooms
from pianta.worlds.floors import make_ring_floor
from pianta.worlds.scan import make_sample, simulate_map
from pianta_bench.data.folders import find_data
from pianta_bench.types.figures import draw_accuracies, draw_clusters
from pianta_bench.types.measure import measure as measure_types

IMAGES = Path(__file__).parent / "images"
PARAMETERS, STRUCTURE = ThesisParameters(), StructureParameters()
FREE, SHADE, WALL, ACCENT = "#ffffff", "#d9d9d9", "#303030", "#b5123b"
# Name and colour of each class of the evidence.
CLASSES = {
    WALL_CLASS: ("wall", WALL),
    DOOR: ("door", "#2aa84a"),
    FURNITURE: ("furniture", "#f0932b"),
    FLOOR: ("floor", FREE),
    OUTSIDE: ("outside", SHADE),
}


def main() -> None:
    """Draw all pictures."""
    IMAGES.mkdir(exist_ok=True)
    _, grid = make_sample()
    floor = label_rooms(reconstruct(grid))
    save_figure(draw_floor(floor, grid), IMAGES / "sample.png")
    school = label_rooms(replace(floor, building_type={"school": 1.0}))
    save_figure(draw_floor(school, grid, graph=True), IMAGES / "labels.png")
    draw_structure(simulate_map(make_open_floor(), noise=0.3, furniture=0.7, seed=7), IMAGES / "structure.png")
    draw_steps(grid, IMAGES / "algorithm1.png")
    draw_doors(grid, IMAGES / "doors.png")
    ring = simulate_map(make_ring_floor(seed=4), noise=0.3, furniture=0.2, seed=4)
    save_figure(draw_floor(reconstruct(ring, method="thesis"), ring, walls=True), IMAGES / "ring.png")
    draw_types()


def draw_types() -> None:
    """Draw accuracies and clusters of building types; without data, the pictures stay as they are."""
    try:
        bench = measure_types(find_data())
    except DataError:
        return
    save(draw_accuracies(bench), IMAGES / "types_accuracy.png")
    save(draw_clusters(bench), IMAGES / "types_clusters.png")


def make_open_floor() -> Floor:
    """A hall with three bays that are open along most of their front, rooms, and a corridor with a bend."""
    corridor = shapely.union(shapely.box(16, 1.2, 22, 3.2), shapely.box(20, 3.2, 22, 9))
    bays = [(0, 4.5, 5.2, 9), (5.2, 4.5, 10.6, 9), (10.6, 4.5, 16, 9)]
    rooms = [(0, -5, 4, 0), (4, -5, 9, 0), (9, -5, 16, 0), (16, 3.2, 20, 9), (16, -5, 22, 1.2)]
    spaces = [shapely.box(0, 0, 16, 4.5), corridor, *(shapely.box(*bounds) for bounds in (*bays, *rooms))]
    passages = [
        ((1, 2), [(16, 1.3), (16, 3.1)]),
        ((1, 3), [(1, 4.5), (4.2, 4.5)]),
        ((1, 4), [(6.3, 4.5), (9.5, 4.5)]),
        ((1, 5), [(11.7, 4.5), (14.9, 4.5)]),
        ((1, 6), [(1.5, 0), (2.4, 0)]),
        ((1, 7), [(6, 0), (6.9, 0)]),
        ((1, 8), [(12, 0), (12.9, 0)]),
        ((2, 9), [(20, 5), (20, 5.9)]),
        ((2, 10), [(18, 1.2), (18.9, 1.2)]),
    ]
    return Floor(
        rooms=tuple(
            Room(number, space.buffer(-0.075, join_style="mitre"), label="CORRIDOR" if number == 2 else "ROOM")
            for number, space in enumerate(spaces, start=1)
        ),
        doors=tuple(
            Door(pair, line, line.length)
            for pair, line in ((pair, shapely.LineString(ends)) for pair, ends in passages)
        ),
    )


def draw_structure(grid: GridMap, path: Path) -> None:
    """Draw the steps of the method `structure` on one map."""
    division = divide_floor(grid, STRUCTURE)
    canvas = division.working_grid
    figure = Figure(figsize=(15, 10.6), layout="constrained")
    axes = figure.subplots(2, 2).ravel()
    plot_evidence(division, ax=axes[0])
    plot_pieces(division, explain_structure(grid, parameters=STRUCTURE), ax=axes[1])
    show_labels(division.labels, canvas, ax=axes[2])
    plot_cuts(division.borders, canvas, color=ACCENT, ax=axes[2])
    frame(axes[2], "rooms of the multicut, with straight borders (red)")
    floor = reconstruct(grid, method="structure")
    plot_rooms(floor, ax=axes[3])
    plot_furniture(floor, ax=axes[3])
    plot_doors(floor, ax=axes[3])
    match_extent(axes[3], canvas)
    frame(axes[3], "outlines, furniture, doors (bold) and openings (dashed)")
    save(figure, path)


def plot_evidence(division: Division, *, ax: Axes) -> Axes:
    """Plot the probabilities of the classes: the mean of their colours."""
    evidence, canvas = division.evidence, division.working_grid
    colors = np.array([to_rgb(color) for _, color in CLASSES.values()])
    shares = np.stack([on_grid(canvas, evidence.enlarge(evidence.classes[number])) for number in CLASSES], axis=-1)
    ax.imshow((shares @ colors).clip(0, 1), extent=bounds_of(canvas))
    samples = [Patch(facecolor=color, edgecolor=WALL, label=name) for name, color in CLASSES.values()]
    ax.legend(handles=samples, loc="upper center", bbox_to_anchor=(0.5, -0.01), ncols=len(samples), frameon=False)
    return frame(ax, "evidence of the network")


def plot_pieces(division: Division, considered: ConsideredBorders, *, ax: Axes) -> Axes:
    """Plot the pieces of the floor, and the probabilities of the lines between them."""
    canvas = division.working_grid
    show_labels(division.pieces.labels, canvas, ax=ax, strength=0.45)
    lines = LineCollection(considered.lines, array=considered.probabilities, cmap="RdYlGn_r", linewidths=3.5)
    lines.set_clim(0, 1)
    ax.add_collection(lines)
    bar = ax.inset_axes((0.25, -0.05, 0.5, 0.025))
    ax.figure.colorbar(lines, cax=bar, orientation="horizontal")
    return frame(ax, "pieces, and the probability of each border between them")


def plot_cuts(lines: Floats, canvas: WorkingGrid, *, color: str, ax: Axes, width: float = 3.5) -> Axes:
    """Plot lines between cells of a canvas, shape (N, 2, 2): end, then row and col."""
    segments = [to_axes(shapely.LineString((line[:, ::-1] + 0.5) * canvas.resolution), canvas) for line in lines]
    ax.add_collection(LineCollection(segments, colors=color, linewidths=width))
    return ax


def show_labels(labels: LabelImage, canvas: WorkingGrid, *, ax: Axes, strength: float = 1.0) -> Axes:
    """Labels of a canvas in colours that differ between neighbours, also through a wall; pale if strength is low."""
    across = [(labels[:-8], labels[8:]), (labels[:, :-8], labels[:, 8:])]
    pairs = np.concatenate([np.column_stack([one.ravel(), other.ravel()]) for one, other in across])
    pairs = np.unique(pairs[(pairs > 0).all(axis=1) & (pairs[:, 0] != pairs[:, 1])], axis=0)
    color_of = nx.greedy_color(nx.Graph(pairs.tolist()), strategy="DSATUR")
    palette = np.array([to_rgb(SHADE)] + [to_rgb(ROOM_COLORS[color_of.get(n, 0)]) for n in range(1, labels.max() + 1)])
    palette[1:] = 1 - strength * (1 - palette[1:])
    ax.imshow(palette[on_grid(canvas, labels)], extent=bounds_of(canvas))
    return ax


def draw_steps(grid: GridMap, path: Path) -> None:
    """Draw the steps of Algorithm 1 on one map."""
    free = remove_clutter(grid.free, size_px=PARAMETERS.clutter_size / grid.resolution)
    canvas = to_working_grid(grid, free, resolution=PARAMETERS.working_resolution)
    segments = detect_segments(detect_edges(canvas, PARAMETERS), canvas.resolution, PARAMETERS)
    lines = get_representative_lines(segments, PARAMETERS)
    faces = find_faces(lines, canvas)
    inner = compute_map_contour(canvas, PARAMETERS)
    figure = Figure(figsize=(15, 8.2), layout="constrained")
    axes = figure.subplots(2, 3).ravel()
    show_mask(canvas, canvas.free, "free space, small groups of cells removed", ax=axes[0])
    plot_segments(segments, canvas, ax=axes[1])
    show_mask(canvas, inner, "inner area, from the contour", ax=axes[2])
    plot_lines(lines, faces, canvas, ax=axes[3])
    plot_weights(faces, inner, canvas, ax=axes[4])
    floor = reconstruct(grid, method="thesis")
    plot_rooms(floor, ax=axes[5])
    plot_doors(floor, ax=axes[5])
    frame(axes[5], "rooms and doors")
    match_extent(axes[5], canvas)
    save(figure, path)


def draw_doors(grid: GridMap, path: Path) -> None:
    """Draw the distance map, the Voronoi diagram and the topological map (Fig. 3.2)."""
    free = remove_clutter(grid.free, size_px=PARAMETERS.clutter_size / grid.resolution)
    canvas = to_working_grid(grid, free, resolution=PARAMETERS.working_resolution)
    figure = Figure(figsize=(15, 4.7), layout="constrained")
    axes = figure.subplots(1, 3)
    clearance = np.where(canvas.free, compute_clearance(canvas.free), np.nan)
    axes[0].imshow(on_grid(canvas, clearance), cmap="viridis")
    frame(axes[0], "distance map")
    show_mask(canvas, canvas.free, "Voronoi diagram", ax=axes[1])
    rows, cols = np.nonzero(on_grid(canvas, draw_voronoi_diagram(canvas.free)))
    axes[1].plot(cols, rows, ".", color=ACCENT, markersize=1)
    floor = reconstruct(grid, method="thesis")
    plot_rooms(floor, ax=axes[2])
    plot_doors(floor, ax=axes[2])
    plot_graph(floor, ax=axes[2])
    frame(axes[2], "topological map")
    match_extent(axes[2], canvas)
    save(figure, path)


def on_grid(canvas: WorkingGrid, cells: np.ndarray) -> np.ndarray:
    """Cells of a canvas in the pose of the map."""
    rows, cols = (np.arange(size) + 0.5 for size in cells.shape)
    corners = canvas.to_grid @ np.array([[rows[0], rows[-1]], [cols[0], cols[-1]], [1.0, 1.0]])
    turned = cells.T if abs(canvas.to_grid[0, 0]) < 1e-9 else cells
    upright = turned[::-1] if corners[0, 0] > corners[0, 1] else turned
    return upright[:, ::-1] if corners[1, 0] > corners[1, 1] else upright


def show_mask(canvas: WorkingGrid, mask: np.ndarray, title: str, *, ax: Axes) -> Axes:
    """Show a mask of a canvas, true in white."""
    ax.imshow(on_grid(canvas, mask), cmap="gray", vmin=-4, vmax=1)
    return frame(ax, title)


def plot_segments(segments: np.ndarray, canvas: WorkingGrid, *, ax: Axes) -> Axes:
    """Plot Hough segments, a colour for each angular cluster."""
    angular, _ = cluster_angles(segments, PARAMETERS)
    lines = [to_axes(shapely.LineString(ends.reshape(2, 2)), canvas) for ends in segments]
    ax.add_collection(LineCollection(lines, colors=[f"C{label}" for label in angular], linewidths=1.2))
    match_extent(ax, canvas)
    return frame(ax, "segments, coloured by angular cluster")


def plot_lines(lines: list[RepresentativeLine], faces: Faces, canvas: WorkingGrid, *, ax: Axes) -> Axes:
    """Plot representative lines, and what segments cover of them."""
    extent = shapely.box(*shapely.total_bounds(faces.polygons))
    infinite = [to_axes(part, canvas) for part in cut_lines(lines, extent)]
    ax.add_collection(LineCollection(infinite, colors=ACCENT, linewidths=0.6, alpha=0.6))
    covered = [
        to_axes(shapely.LineString([line.normal * line.offset + line.direction * t for t in interval]), canvas)
        for line in lines
        for interval in line.covered
    ]
    ax.add_collection(LineCollection(covered, colors=WALL, linewidths=2))
    match_extent(ax, canvas)
    return frame(ax, "representative lines, and their covered parts")


def plot_weights(faces: Faces, inner: np.ndarray, canvas: WorkingGrid, *, ax: Axes) -> Axes:
    """Plot faces (external grey, partial hatched) and the weights of their edges."""
    share = share_inside(label_faces(faces, canvas), inner, len(faces.polygons))
    internal = share >= PARAMETERS.inside_share
    partial = find_partial_faces(faces, internal, share_free(faces, canvas), partial_weight=PARAMETERS.partial_weight)
    for polygon, inside, unsure in zip(faces.polygons, internal, partial, strict=True):
        corners = to_axes(polygon.exterior, canvas)
        ax.fill(*corners.T, color=FREE if inside else SHADE, hatch="///" if unsure else None, linewidth=0)
    edges = [
        to_axes(shapely.LineString([start, end]), canvas) for start, end in zip(faces.starts, faces.ends, strict=True)
    ]
    ax.add_collection(LineCollection(edges, array=faces.weight, cmap="inferno_r", linewidths=1.6))
    match_extent(ax, canvas)
    return frame(ax, "faces, and the weights of their edges")


def to_axes(geometry: shapely.Geometry, canvas: WorkingGrid) -> np.ndarray:
    """Coordinates of a geometry of the canvas, moved into the map frame."""
    return shapely.get_coordinates(canvas.to_map(geometry))


def bounds_of(canvas: WorkingGrid) -> tuple[float, float, float, float]:
    """Left, right, bottom and top of a canvas in the map frame."""
    height, width = np.array(canvas.free.shape) * canvas.resolution
    left, bottom, right, top = canvas.to_map(shapely.box(0, 0, width, height)).bounds
    return left, right, bottom, top


def match_extent(ax: Axes, canvas: WorkingGrid) -> Axes:
    """Show the whole canvas, x to the right and y up."""
    left, right, bottom, top = bounds_of(canvas)
    ax.set(xlim=(left, right), ylim=(bottom, top))
    return ax


def frame(ax: Axes, title: str) -> Axes:
    """Title above, no ticks, equal scales."""
    ax.set_title(title, fontsize=11)
    ax.set_xticks([])
    ax.set_yticks([])
    ax.set_aspect("equal")
    return ax


def save(figure: Figure, path: Path) -> None:
    """Write a figure as PNG without a date, so that the same picture has the same bytes."""
    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
