"""Pictures of buildings as graphs, in the style of Figs. 7.10 to 7.12: squares for corridors, circles for rooms.

Nodes have no positions on a map: they lie where the drawing is clear. All lengths in a drawing are in lengths of its
shortest edges. The numbers of the layout were chosen by hand.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, shortest_path

from pianta._types import Floats, Mask
from pianta.errors import OptionError
from pianta.io._files import count_noun
from pianta.labels import RC, LabelConvention, LabelSchema, normalize_label
from pianta.plot.figure import GRAPH_LEVEL, clean_legend, new_ax, new_figure, shorten
from pianta.plot.room_marks import make_node
from pianta.plot.styles import DARK_INK, EDGE_COLOR, NEUTRAL_COLOR, RoomStyle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

# Radius of a room and half the side of a corridor, which have the same area.
RADIUS = 0.36
HALF_SIDE = 0.32
# Space around the drawing, and its least height, so that the nodes of small buildings are not too large.
MARGIN = 0.6
LEAST_HEIGHT = 7.0
# Least distances between two nodes, and between a node and an edge of other nodes.
NODE_GAP = 0.95
EDGE_GAP = 0.5
# Length that each room takes on the circle around its corridor.
ROOM_ARC = 0.9
# Distance between components of a graph.
COMPONENT_GAP = 1.5
# Steps of stress majorization, and those after a swap of two nodes.
STEPS = 100
STEPS_AFTER_SWAP = 8
# Swaps of nodes, and the crossings of edges that are considered for each.
MAX_SWAPS = 10
CROSSINGS_PER_SWAP = 3
# Steps that push nodes apart.
PUSHES = 60
# A drawing is rotated by one of these many equal angles below a half turn, of those whose picture is at most this much
# larger than the smallest.
ROTATIONS = 36
LARGER_ROTATED = 1.15
# Nodes never start at equal positions: offset of each, and the angle between two offsets (the golden angle).
OFFSET = 1e-3
GOLDEN_ANGLE = 2.399963
# Widths of lines, points: outlines of nodes and of fixed nodes, edges, and edges between corridors.
OUTLINE = 0.6
THICK_OUTLINE = 1.6
EDGE = 0.6
SPINE = 1.8

# A sheet shows at most this number of buildings.
MAX_SHEET = 24
COLUMNS = 6
# Inches: size of a building with its title, height of the title, and space between two buildings.
CELL_WIDTH = 3.0
CELL_HEIGHT = 2.4
TITLE_HEIGHT = 0.4
CELL_GAP = 0.2
# Inches: height of the heading of the sheet; height of a row and width of a column of the legend.
HEADING = 0.4
LEGEND_ROW = 0.22
LEGEND_WIDTH = 2.5
FONT_SIZE = 10
OTHER_LABELS = "other or no label"
FIXED = "kept"


def plot_room_graph(
    graph: nx.Graph, *, ax: Axes | None = None, schema: LabelSchema, fixed: Collection[Hashable] = frozenset()
) -> Axes:
    """Draw a building as a graph: squares for corridors, circles for rooms, in the colours of their labels.

    The same graph has the same drawing, whose nodes do not overlap. Edges between corridors are thick.

    Parameters
    ----------
    graph
        Undirected, connected or not, or without nodes; the `label` of a node may be missing.
    ax
        Where to draw, in lengths of the shortest edges; a new figure if None.
    schema
        The labels and their colours; rooms with other labels are white.
    fixed
        Nodes with a thick outline.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    References
    ----------
    M. Luperto, PhD thesis, Figs. 7.10 to 7.12.

    Examples
    --------
    >>> import networkx as nx
    >>> import pianta
    >>> from pianta.labels import SCHOOL
    >>> graph = nx.star_graph(4)
    >>> nx.set_node_attributes(graph, {0: "CORRIDOR", 1: "CLASSROOM", 2: "GYM"}, "label")
    >>> ax = pianta.plot.plot_room_graph(graph, schema=SCHOOL)
    """
    from matplotlib.collections import LineCollection

    ax = new_ax(ax)
    styles = {node: _style_room(label, schema) for node, label in graph.nodes(data="label")}
    positions = place_nodes(graph)
    edges = [(first, second) for first, second in graph.edges if first != second]
    lines = [[positions[first], positions[second]] for first, second in edges]
    widths = [SPINE if styles[first].is_corridor and styles[second].is_corridor else EDGE for first, second in edges]
    ax.add_collection(LineCollection(lines, linewidths=widths, colors=EDGE_COLOR, zorder=GRAPH_LEVEL - 0.5))
    for node, center in positions.items():
        width = THICK_OUTLINE if node in fixed else OUTLINE
        ax.add_patch(make_node(center, styles[node], RADIUS, HALF_SIDE, edgecolor=DARK_INK, linewidth=width))
    _set_limits(ax, np.array([*positions.values()]).reshape(-1, 2))
    return ax


def draw_contact_sheet(
    graphs: Sequence[nx.Graph],
    *,
    schema: LabelSchema,
    titles: Sequence[str] | None = None,
    heading: str | None = None,
    columns: int = COLUMNS,
    fixed: Sequence[Collection[Hashable]] | None = None,
) -> Figure:
    """Picture of several buildings as graphs side by side, over a legend of their labels.

    Of more than MAX_SHEET buildings it shows the first, and the heading says so. titles: of each building, by default
    its number and its count of rooms. heading: above all. fixed: for each building, as in plot_room_graph.

    Raises OptionError without any building, for less than one column, and for other numbers of titles or fixed sets.
    """
    _check_sheet(graphs, titles, fixed, columns)
    drawn_graphs = graphs[:MAX_SHEET]
    fixed = fixed or [()] * len(drawn_graphs)
    titles = titles or [f"{number}: {count_noun(len(graph), 'room')}" for number, graph in enumerate(drawn_graphs, 1)]
    count = f"{MAX_SHEET} of {len(graphs)}" if len(graphs) > MAX_SHEET else None
    handles = list_handles(drawn_graphs, schema, fixed=any(map(len, fixed[:MAX_SHEET])))
    figure, axes = _make_empty_sheet(len(drawn_graphs), columns, handles, ": ".join(filter(None, (heading, count))))
    for ax, graph, nodes, title in zip(axes, drawn_graphs, fixed, titles, strict=False):
        plot_room_graph(graph, ax=ax, schema=schema, fixed=nodes)
        ax.set_title(shorten(title), fontsize=FONT_SIZE, color=DARK_INK, pad=3, parse_math=False)
    return figure


def place_nodes(graph: nx.Graph) -> dict[Hashable, tuple[float, float]]:
    """x, y of each node in a drawing: rooms around their corridors, components side by side.

    Distances of nodes approximate the lengths of the shortest paths between them (stress majorization, Gansner, Koren
    and North 2004); edges of a corridor are longer the more rooms it has.
    """
    if not len(graph):
        return {}
    joined = nx.to_numpy_array(graph, weight=None) > 0
    np.fill_diagonal(joined, 0)
    count, component_of_node = connected_components(joined, directed=False)
    members = [np.flatnonzero(component_of_node == component) for component in range(count)]
    components = [_place_component(joined[np.ix_(nodes, nodes)]) for nodes in members]
    xy = np.empty((len(graph), 2))
    for nodes, component, corner in zip(members, components, _pack_components(components), strict=True):
        xy[nodes] = component + corner
    return {node: (float(x), float(y)) for node, (x, y) in zip(graph, xy, strict=True)}


def _place_component(joined: Mask) -> Floats:
    """Positions of connected nodes, shape (n, 2); the smallest x and y are 0."""
    if len(joined) == 1:
        return np.zeros((1, 2))
    edges = np.argwhere(np.triu(joined))
    wanted = _wanted_distances(joined)
    candidates = [_majorize(start, wanted, STEPS) for start in _start_positions(joined, wanted)]
    xy = min(candidates, key=lambda candidate: (len(_find_crossings(candidate, edges)), _stress(candidate, wanted)))
    return _rotate(_push_apart(_uncross(xy, edges, wanted), edges))


def _rotate(xy: Floats) -> Floats:
    """Positions rotated so that the drawing fills a picture and is flat; the smallest x and y are 0."""
    angles = np.linspace(0, np.pi, ROTATIONS, endpoint=False)
    rotated = [xy @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) for a in angles]
    sides = np.ptp(rotated, axis=1)
    sizes = (sides / (CELL_WIDTH, CELL_HEIGHT)).max(axis=1)
    flattest = np.where(sizes <= LARGER_ROTATED * sizes.min(), sides[:, 1], np.inf).argmin()
    return np.asarray(rotated[flattest] - rotated[flattest].min(axis=0))


def _wanted_distances(joined: Mask) -> Floats:
    """Lengths of shortest paths, shape (n, n); an edge is as long as the circles of rooms around its ends need."""
    degrees = joined.sum(axis=1)
    circles = np.where(degrees > 1, ROOM_ARC * degrees / (2 * np.pi), 0)
    lengths = np.maximum(circles[:, None] + circles, 1)
    return np.asarray(shortest_path(np.where(joined, lengths, 0), directed=False))


def _start_positions(joined: Mask, wanted: Floats) -> Iterator[Floats]:
    """Two starts: all nodes by classical scaling; or only inner nodes, each other node beside its neighbour."""
    angles = GOLDEN_ANGLE * np.arange(len(joined))
    offsets = OFFSET * np.column_stack([np.cos(angles), np.sin(angles)])
    yield _scale(wanted) + offsets
    inner = joined.sum(axis=1) > 1
    if inner.sum() > 2:
        wanted_inner = wanted[np.ix_(inner, inner)]
        xy = np.zeros((len(joined), 2))
        xy[inner] = _majorize(_scale(wanted_inner) + offsets[inner], wanted_inner, STEPS)
        xy[~inner] = xy[joined[~inner].argmax(axis=1)]
        yield xy + offsets


def _scale(wanted: Floats) -> Floats:
    """Classical scaling: positions, shape (n, 2), from distances."""
    squares = wanted**2
    centred = squares.mean(axis=0) + squares.mean(axis=1)[:, None] - squares.mean() - squares
    values, vectors = np.linalg.eigh(centred / 2)
    return np.asarray(vectors[:, -2:] * np.sqrt(np.maximum(values[-2:], 0)))


def _majorize(xy: Floats, wanted: Floats, steps: int) -> Floats:
    """Positions after steps towards wanted distances; a pair of nodes has the weight 1 / distance²."""
    count = len(xy)
    weights = _pair_weights(wanted)
    inverse = np.linalg.inv(np.diag(weights.sum(axis=1)) - weights + 1 / count) - 1 / count
    pulls = weights * wanted
    for _ in range(steps):
        pull = -pulls / np.maximum(_distances(xy), 1e-9)
        np.fill_diagonal(pull, 0)
        np.fill_diagonal(pull, -pull.sum(axis=1))
        xy = inverse @ (pull @ xy)
    return xy


def _stress(xy: Floats, wanted: Floats) -> float:
    """Sum of squared differences between distances and wanted ones; each pair has the weight of `_pair_weights`."""
    return float((_pair_weights(wanted) * (_distances(xy) - wanted) ** 2).sum())


def _pair_weights(wanted: Floats) -> Floats:
    """1 / distance² of each pair of nodes, shape (n, n); 0 on the diagonal."""
    off_diagonal = ~np.eye(len(wanted), dtype=bool)
    return np.asarray(np.divide(1, wanted**2, out=np.zeros_like(wanted), where=off_diagonal))


def _distances(xy: Floats) -> Floats:
    """Distances between all pairs of points, shape (n, n)."""
    return np.asarray(np.hypot(*(xy[:, None] - xy).transpose(2, 0, 1)))


def _find_crossings(xy: Floats, edges: NDArray[np.intp]) -> NDArray[np.intp]:
    """Pairs of edges without a common end that cross, shape (k, 2)."""
    first, second = xy[edges].transpose(1, 0, 2)
    along = (second - first)[:, None]

    def find_side(points: Floats) -> Mask:
        """For edge i and the point of edge j whether it lies left of i."""
        offsets = points - first[:, None]
        return np.asarray(along[..., 0] * offsets[..., 1] > along[..., 1] * offsets[..., 0])

    separated = find_side(first) != find_side(second)
    common = (edges[:, None, :, None] == edges[:, None, :]).any(axis=(2, 3))
    return np.argwhere(np.triu(separated & separated.T & ~common))


def _uncross(xy: Floats, edges: NDArray[np.intp], wanted: Floats) -> Floats:
    """Positions after swaps of nodes at the ends of crossing edges, while a swap reduces the crossings."""
    crossings = _find_crossings(xy, edges)
    for _ in range(MAX_SWAPS):
        swapped = []
        for one, other in crossings[:CROSSINGS_PER_SWAP]:
            for pair in product(edges[one], edges[other]):
                candidate = xy.copy()
                candidate[[*pair]] = xy[[*reversed(pair)]]
                swapped.append(_majorize(candidate, wanted, STEPS_AFTER_SWAP))
        best = min(swapped, key=lambda candidate: len(_find_crossings(candidate, edges)), default=xy)
        remaining = _find_crossings(best, edges)
        if len(remaining) >= len(crossings):
            break
        xy, crossings = best, remaining
    return xy


def _push_apart(xy: Floats, edges: NDArray[np.intp]) -> Floats:
    """Positions after pushes, so that nodes touch neither each other nor edges of other nodes, if possible."""
    xy = xy.copy()
    nodes = np.arange(len(xy))
    unrelated = (edges[:, :1] != nodes) & (edges[:, 1:] != nodes)
    for _ in range(PUSHES):
        push = _push_nodes(xy) + _push_from_edges(xy, edges, unrelated)
        if np.abs(push).max(initial=0) < 1e-3:
            break
        xy += push
    for _ in range(PUSHES):
        xy += _push_nodes(xy)
    return xy


def _push_nodes(xy: Floats) -> Floats:
    """Move of each node, shape (n, 2), away from nodes nearer than NODE_GAP, by half of what is missing to it."""
    distances = np.maximum(_distances(xy), 1e-9)
    shares = np.maximum(NODE_GAP / distances - 1, 0) / 2
    np.fill_diagonal(shares, 0)
    return np.asarray(((xy[:, None] - xy) * shares[..., None]).sum(axis=1))


def _push_from_edges(xy: Floats, edges: NDArray[np.intp], unrelated: Mask) -> Floats:
    """Move of each node, shape (n, 2), away from edges nearer than EDGE_GAP, by half of what is missing.

    The edges move by the other half.

    unrelated: for edge i and node j whether j is no end of i.
    """
    first, second = xy[edges].transpose(1, 0, 2)
    along = second - first
    share = ((xy - first[:, None]) * along[:, None]).sum(axis=-1) / np.maximum((along**2).sum(axis=-1), 1e-9)[:, None]
    away = xy - (first[:, None] + np.clip(share, 0, 1)[..., None] * along[:, None])
    distances = np.hypot(away[..., 0], away[..., 1])
    lack = np.where(unrelated & (share > 0) & (share < 1), np.maximum(EDGE_GAP - distances, 0) / 2, 0)
    pushes = away * (lack / np.maximum(distances, 1e-9))[..., None]
    push = pushes.sum(axis=0)
    np.add.at(push, edges, -pushes.sum(axis=1)[:, None] / 2)
    return np.asarray(push)


def _pack_components(components: Sequence[Floats]) -> list[Floats]:
    """The lower left corner of each component, in rows of about the shape of a picture, the largest first."""
    sizes = [component.max(axis=0) + COMPONENT_GAP for component in components]
    area = sum(float(size.prod()) for size in sizes)
    row_width = max([np.sqrt(area * CELL_WIDTH / CELL_HEIGHT), *(size[0] for size in sizes)], default=0)
    corners: list[Floats] = [np.zeros(2)] * len(components)
    x, top, row_height = 0.0, 0.0, 0.0
    for index in sorted(range(len(components)), key=lambda index: (-sizes[index].prod(), index)):
        width, height = sizes[index]
        if x and x + width > row_width * (1 + 1e-9):
            x, top, row_height = 0.0, top - row_height, 0.0
        row_height = max(row_height, height)
        corners[index] = np.array([x, top - height])
        x += width
    return corners


def _style_room(name: str | None, schema: LabelSchema) -> RoomStyle:
    """Colour and form of a room with a label; the neutral colour for labels that the schema does not have."""
    label = schema.by_name.get(normalize_label(name) or "")
    if label is None:
        return RoomStyle(NEUTRAL_COLOR)
    return RoomStyle(label.color, is_corridor=label.room_or_corridor(LabelConvention.GRAPHS) == RC.CORRIDOR)


def _set_limits(ax: Axes, xy: Floats) -> None:
    """Set the limits of the axes so that all nodes, shape (n, 2), fill the view; it is LEAST_HEIGHT high at least."""
    low, high = (xy.min(axis=0), xy.max(axis=0)) if len(xy) else np.zeros((2, 2))
    half = (high - low) / 2 + MARGIN
    wide_per_high = ax.bbox.width / ax.bbox.height
    half_height = max(half[0] / wide_per_high, half[1], LEAST_HEIGHT / 2)
    x, y = (low + high) / 2
    ax.set(xlim=(x - half_height * wide_per_high, x + half_height * wide_per_high), aspect="equal")
    ax.set_ylim(y - half_height, y + half_height)
    ax.set_axis_off()


def list_handles(graphs: Sequence[nx.Graph], schema: LabelSchema, *, fixed: bool) -> list[Line2D]:
    """Entries of a legend: the labels of rooms in the order of the schema, then one for all other labels."""
    names = {normalize_label(label) for graph in graphs for _, label in graph.nodes(data="label")}
    handles = [_make_handle(shorten(name), _style_room(name, schema)) for name in schema.by_name if name in names]
    if names.difference(schema.by_name):
        handles.append(_make_handle(OTHER_LABELS, RoomStyle(NEUTRAL_COLOR)))
    if fixed:
        handles.append(_make_handle(FIXED, RoomStyle(NEUTRAL_COLOR), fixed=True))
    return handles


def _make_handle(text: str, style: RoomStyle, *, fixed: bool = False) -> Line2D:
    """A legend entry: the node of a room in a style, with a thick outline if it is fixed."""
    from matplotlib.lines import Line2D

    marker, width = "s" if style.is_corridor else "o", THICK_OUTLINE if fixed else OUTLINE
    look: dict[str, Any] = {"markerfacecolor": style.fill, "markeredgecolor": DARK_INK, "markeredgewidth": width}
    return Line2D([], [], linestyle="none", marker=marker, markersize=9, label=text, **look)


def _make_empty_sheet(count: int, columns: int, handles: Sequence[Line2D], heading: str) -> tuple[Figure, list[Axes]]:
    """A figure with `count` empty axes in rows of `columns`, a heading above them and a legend below.

    handles: the entries of the legend. The axes are in reading order, each with space for a title above it.
    """
    columns = min(columns, count)
    width = CELL_WIDTH * columns
    legend_columns = min(int(width / LEGEND_WIDTH), max(len(handles), 1))
    above, below = HEADING if heading else 0.0, LEGEND_ROW * (-(-len(handles) // legend_columns) + 1)
    height = above - (-count // columns) * CELL_HEIGHT + below
    figure = new_figure(width, height)
    text: dict[str, Any] = {"fontsize": 1.4 * FONT_SIZE, "color": DARK_INK, "va": "top", "parse_math": False}
    figure.text(0.1 / width, 1 - 0.1 / height, heading, **text)
    clean_legend(
        figure.legend(handles=handles, loc="lower center", ncols=legend_columns, frameon=False, fontsize=FONT_SIZE)
    )
    share = ((CELL_WIDTH - CELL_GAP) / width, (CELL_HEIGHT - TITLE_HEIGHT) / height)
    corners = (
        ((column * CELL_WIDTH + CELL_GAP / 2) / width, 1 - (above + (row + 1) * CELL_HEIGHT) / height)
        for row, column in (divmod(index, columns) for index in range(count))
    )
    return figure, [figure.add_axes((*corner, *share)) for corner in corners]


def _check_sheet(
    graphs: Sequence[nx.Graph], titles: Sequence[str] | None, fixed: Sequence[Collection[Hashable]] | None, columns: int
) -> None:
    """Raise OptionError without graphs or columns, and for titles or fixed rooms that are not one for each graph."""
    if not graphs:
        raise OptionError("there is no building to draw, give one at least")
    if columns < 1:
        raise OptionError(f"a sheet of {columns} columns has no space for a building, give 1 at least")
    for name, values in (("titles", titles), ("sets of fixed rooms", fixed)):
        if values is not None and len(values) != len(graphs):
            raise OptionError(f"there are {len(values)} {name} for {len(graphs)} buildings, give one for each")
