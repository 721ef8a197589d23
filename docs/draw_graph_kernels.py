"""Draw the picture of docs/methods/graph-kernels.md: python docs/draw_graph_kernels.py."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from itertools import pairwise

import networkx as nx
from draw_pictures import ACCENT, IMAGES, SHADE, WALL, frame, save
from matplotlib.axes import Axes
from matplotlib.figure import Figure

PALE = "#f0b7c8"
# Rooms of a small floor: name, label, x and y. The last two rooms have a door between them.
ROOMS = {
    "a": ("E", 0.0, 0.0),
    "b": ("C", 1.0, 0.0),
    "c": ("C", 2.2, 0.0),
    "d": ("R", 1.0, 1.0),
    "e": ("S", 1.0, -1.0),
    "f": ("R", 2.2, 1.0),
    "g": ("S", 2.2, -1.0),
    "h": ("R", 3.3, 0.6),
    "i": ("R", 3.3, -0.6),
}
DOORS = ("ab", "bc", "bd", "be", "cf", "cg", "ch", "ci", "hi")


def main() -> None:
    """Draw what each kernel counts, on one graph."""
    figure = Figure(figsize=(15, 4.1), layout="constrained")
    graph = nx.Graph([tuple(door) for door in DOORS])
    axes = figure.subplots(1, 3)
    draw_rounds(graph, ax=axes[0])
    draw_path(graph, ax=axes[1])
    draw_pair(graph, ax=axes[2])
    save(figure, IMAGES / "graph_kernels.png")


def draw_rounds(graph: nx.Graph, *, ax: Axes) -> None:
    """Draw what the label of a node stands for after each iteration of Weisfeiler-Lehman."""
    away = nx.single_source_shortest_path_length(graph, "d")
    colors = [ACCENT, "#d9577c", PALE]
    fills = {node: colors[steps] for node, steps in away.items() if steps < len(colors)}
    plot_rooms(graph, fills, [], ax=ax)
    frame(ax, "Weisfeiler-Lehman: R\nafter 1 iteration R by C, after 2 R by (C by C, E, R, S)")


def draw_path(graph: nx.Graph, *, ax: Axes) -> None:
    """Draw a shortest path and the indices of its nodes."""
    path = nx.shortest_path(graph, "a", "h")
    plot_rooms(graph, dict.fromkeys(path, ACCENT), list(pairwise(path)), ax=ax)
    for index, node in enumerate(path):
        x, y = ROOMS[node][1:]
        ax.annotate(f"i = {index}", (x - 0.02, y - 0.3), color=ACCENT, ha="right", fontsize=11)
    frame(ax, "Graph Hopper: one path of l = 3 edges\nwith E, C, C, R in its places i")


def draw_pair(graph: nx.Graph, *, ax: Axes) -> None:
    """Draw two neighbourhoods whose roots are apart."""
    fills, marked = {}, []
    for root, color in (("d", ACCENT), ("h", WALL)):
        neighbourhood = nx.ego_graph(graph, root, radius=1)
        fills |= dict.fromkeys(neighbourhood, color)
        marked += [(*edge, color) for edge in neighbourhood.edges]
    plot_rooms(graph, fills, marked, roots="dh", ax=ax)
    frame(ax, "NSPDK: neighbourhoods of radius 1\naround two roots (bold) that are 3 edges apart")


def plot_rooms(
    graph: nx.Graph, fills: Mapping[str, str], marked: Collection[tuple[str, ...]], *, ax: Axes, roots: str = ""
) -> None:
    """Plot nodes with their labels, and edges; marked edges may bring their colour."""
    for one, other in graph.edges:
        plot_edge(one, other, SHADE, 2, ax=ax)
    for one, other, *color in marked:
        plot_edge(one, other, color[0] if color else ACCENT, 4, ax=ax)
    for node, (label, x, y) in ROOMS.items():
        width = 3.5 if node in roots else 1
        ax.plot(
            x, y, "o", markersize=27, color=fills.get(node, "white"), markeredgecolor="black", markeredgewidth=width
        )
        ax.annotate(
            label,
            (x, y),
            color="black" if fills.get(node, PALE) == PALE else "white",
            ha="center",
            va="center",
            fontsize=13,
        )
    ax.margins(0.12, 0.18)


def plot_edge(one: str, other: str, color: str, width: float, *, ax: Axes) -> None:
    """Plot a door between two rooms."""
    (_, *start), (_, *end) = ROOMS[one], ROOMS[other]
    ax.plot(*zip(start, end, strict=True), color=color, linewidth=width, zorder=0)


if __name__ == "__main__":
    main()
