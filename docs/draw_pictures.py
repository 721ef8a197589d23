"""Draw the pictures of the README and of docs/: `make docs`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from pianta.drawing import plot_doors, plot_graph, plot_rooms, save_picture
from pianta.gridmap import GridMap
from pianta.layout.affinity import find_partial_faces
from pianta.layout.canvas import Canvas, draw_canvas
from pianta.layout.clutter import remove_clutter
from pianta.layout.contour import compute_map_contour
from pianta.layout.doors import compute_clearance, draw_voronoi_diagram
from pianta.layout.faces import Faces, cut_lines, find_faces, label_faces, share_free, share_inside
from pianta.layout.lines import RepresentativeLine, cluster_angles, get_representative_lines
from pianta.layout.parameters import ThesisParameters
from pianta.layout.reconstruct import reconstruct
from pianta.layout.walls import detect_edges, detect_segments
from pianta.worlds.floors import make_ring_floor
from pianta.worlds.scan import make_sample, map_floor

IMAGES = Path(__file__).parent / "images"
PARAMETERS = ThesisParameters()
FREE, SHADE, WALL, ACCENT = "#ffffff", "#d9d9d9", "#303030", "#b5123b"


def main() -> None:
    """Draw all pictures."""
    IMAGES.mkdir(exist_ok=True)
    _, grid = make_sample()
    save_picture(reconstruct(grid), grid, IMAGES / "sample.png")
    draw_steps(grid, IMAGES / "algorithm1.png")
    draw_doors(grid, IMAGES / "doors.png")
    ring = map_floor(make_ring_floor(seed=4), noise=0.3, furniture=0.2, seed=4)
    save_picture(reconstruct(ring), ring, IMAGES / "ring.png", walls=True)


def draw_steps(grid: GridMap, path: Path) -> None:
    """Draw the steps of Algorithm 1 on one map."""
    free = remove_clutter(grid.free, size_px=PARAMETERS.clutter_size / grid.resolution)
    canvas = draw_canvas(grid, free, resolution=PARAMETERS.working_resolution)
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
    floor = reconstruct(grid)
    plot_rooms(floor, ax=axes[5])
    plot_doors(floor, ax=axes[5])
    frame(axes[5], "rooms and doors")
    match_extent(axes[5], canvas)
    save(figure, path)


def draw_doors(grid: GridMap, path: Path) -> None:
    """Draw the distance map, the Voronoi diagram and the topological map (Fig. 3.2)."""
    free = remove_clutter(grid.free, size_px=PARAMETERS.clutter_size / grid.resolution)
    canvas = draw_canvas(grid, free, resolution=PARAMETERS.working_resolution)
    figure = Figure(figsize=(15, 4.7), layout="constrained")
    axes = figure.subplots(1, 3)
    clearance = np.where(canvas.free, compute_clearance(canvas.free), np.nan)
    axes[0].imshow(on_grid(canvas, clearance), cmap="viridis")
    frame(axes[0], "distance map")
    show_mask(canvas, canvas.free, "Voronoi diagram", ax=axes[1])
    rows, cols = np.nonzero(on_grid(canvas, draw_voronoi_diagram(canvas.free)))
    axes[1].plot(cols, rows, ".", color=ACCENT, markersize=1)
    floor = reconstruct(grid)
    plot_rooms(floor, ax=axes[2])
    plot_doors(floor, ax=axes[2])
    plot_graph(floor, ax=axes[2])
    frame(axes[2], "topological map")
    match_extent(axes[2], canvas)
    save(figure, path)


def on_grid(canvas: Canvas, cells: np.ndarray) -> np.ndarray:
    """Cells of a canvas in the pose of the map."""
    rows, cols = (np.arange(size) + 0.5 for size in cells.shape)
    corners = canvas.to_grid @ np.array([[rows[0], rows[-1]], [cols[0], cols[-1]], [1.0, 1.0]])
    turned = cells.T if abs(canvas.to_grid[0, 0]) < 1e-9 else cells
    upright = turned[::-1] if corners[0, 0] > corners[0, 1] else turned
    return upright[:, ::-1] if corners[1, 0] > corners[1, 1] else upright


def show_mask(canvas: Canvas, mask: np.ndarray, title: str, *, ax: Axes) -> Axes:
    """Show a mask of a canvas, true in white."""
    ax.imshow(on_grid(canvas, mask), cmap="gray", vmin=-4, vmax=1)
    return frame(ax, title)


def plot_segments(segments: np.ndarray, canvas: Canvas, *, ax: Axes) -> Axes:
    """Plot Hough segments, a colour for each angular cluster."""
    angular, _ = cluster_angles(segments, PARAMETERS)
    drawn = [to_axes(shapely.LineString(ends.reshape(2, 2)), canvas) for ends in segments]
    ax.add_collection(LineCollection(drawn, colors=[f"C{label}" for label in angular], linewidths=1.2))
    match_extent(ax, canvas)
    return frame(ax, "segments, coloured by angular cluster")


def plot_lines(lines: list[RepresentativeLine], faces: Faces, canvas: Canvas, *, ax: Axes) -> Axes:
    """Plot representative lines, and what segments cover of them."""
    extent = shapely.box(*shapely.total_bounds(faces.polygons))
    drawn = [to_axes(part, canvas) for part in cut_lines(lines, extent)]
    ax.add_collection(LineCollection(drawn, colors=ACCENT, linewidths=0.6, alpha=0.6))
    covered = [
        to_axes(shapely.LineString([line.normal * line.offset + line.direction * t for t in interval]), canvas)
        for line in lines
        for interval in line.covered
    ]
    ax.add_collection(LineCollection(covered, colors=WALL, linewidths=2))
    match_extent(ax, canvas)
    return frame(ax, "representative lines, and their covered parts")


def plot_weights(faces: Faces, inner: np.ndarray, canvas: Canvas, *, ax: Axes) -> Axes:
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


def to_axes(geometry: shapely.Geometry, canvas: Canvas) -> np.ndarray:
    """Coordinates of a geometry of the canvas, moved into the map frame."""
    return shapely.get_coordinates(canvas.to_map(geometry))


def match_extent(ax: Axes, canvas: Canvas) -> Axes:
    """Show the whole canvas, x to the right and y up."""
    height, width = np.array(canvas.free.shape) * canvas.resolution
    corners = to_axes(shapely.box(0, 0, width, height), canvas)
    ax.set_xlim(corners[:, 0].min(), corners[:, 0].max())
    ax.set_ylim(corners[:, 1].min(), corners[:, 1].max())
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
