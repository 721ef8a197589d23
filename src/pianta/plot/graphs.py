"""Pictures of buildings as graphs, in the style of Figs. 7.10 to 7.12: squares for corridors, circles for rooms.

Nothing here has a place on a map: nodes lie where the drawing is clear.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, shortest_path

from pianta._types import Floats, Mask
from pianta.errors import OptionError
from pianta.labels import RC, LabelConvention, LabelSchema, normalize_label
from pianta.plot._figure import new_ax, save_png
from pianta.plot.floor import DPI, EDGE_COLOR, GRAPH_LEVEL, INK, LONGEST_LABEL
from pianta.plot.styles import NEUTRAL_COLOR, RoomStyle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch


# A sheet has no more buildings.
MAX_SHEET = 24
# All lengths in a drawing are in lengths of its shortest edges.
# Radius of a room and half the side of a corridor, which have the same area; around the drawing; its least height.
RADIUS, HALF_SIDE, MARGIN, LEAST_HEIGHT = 0.36, 0.32, 0.6, 7.0
# Nodes are no closer to each other, and to edges of others.
NODE_GAP, EDGE_GAP = 0.95, 0.5
# Of the circle around a corridor each room has so much; parts of a building are so far apart.
ROOM_ARC, PART_GAP = 0.9, 1.5
# Steps of stress majorization, and after a swap of two nodes; swaps; crossings looked at for a swap; pushes apart.
STEPS, STEPS_OF_SWAP, MAX_SWAPS, CROSSINGS_A_SWAP, PUSHES = 100, 8, 10, 3, 60
# A drawing is turned by multiples of a half turn over so many; it may need so many times the least scale.
TURNS, LARGER_TURNED = 36, 1.15
# Nodes never start at the same place: offset of the first, and the angle between two, the golden one.
OFFSET, GOLDEN_ANGLE = 1e-3, 2.399963
OUTLINE, THICK_OUTLINE, EDGE, SPINE = 0.6, 1.6, 0.6, 1.8
# Inches: width and height of a building, its title, a row of the legend, the sheet's title.
CELL_WIDTH, CELL_HEIGHT, TITLE_HEIGHT, LEGEND_ROW, HEADING = 3.0, 2.4, 0.4, 0.22, 0.4
# Of a column of the legend; between two buildings.
LEGEND_WIDTH, CELL_GAP = 2.5, 0.2
COLUMNS, FONT_SIZE = 6, 10
OTHER_LABELS, FIXED = "other or no label", "kept"


def plot_room_graph(
    graph: nx.Graph, *, ax: Axes | None = None, schema: LabelSchema, fixed: Collection[Hashable] = frozenset()
) -> Axes:
    """Draw a building as a graph: squares for corridors, circles for rooms, in the colours of their labels.

    The same graph has the same drawing, whose nodes do not overlap. Edges between corridors are thick.

    Parameters
    ----------
    graph
        Undirected, of any number of parts, also of none; the `label` of a node may be missing.
    ax
        Where to draw, in lengths of the shortest edges; a new figure if None.
    schema
        The labels; rooms with labels that it does not have are white.
    fixed
        Nodes with a thick outline.

    Returns
    -------
    Axes
        The ax that was drawn on; nothing is shown.

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
    places = place_nodes(graph)
    edges = [(first, second) for first, second in graph.edges if first != second]
    lines = [[places[first], places[second]] for first, second in edges]
    widths = [SPINE if styles[first].is_corridor and styles[second].is_corridor else EDGE for first, second in edges]
    ax.add_collection(LineCollection(lines, linewidths=widths, colors=EDGE_COLOR, zorder=GRAPH_LEVEL - 0.5))
    for node, place in places.items():
        ax.add_patch(_make_node(place, styles[node], fixed=node in fixed))
    _frame(ax, np.array([*places.values()]).reshape(-1, 2))
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
    """Picture of many buildings as graphs side by side, over a legend of the labels that they have.

    Of more than MAX_SHEET buildings it has the first, and says so above. titles: one a building, its number and the
    count of its rooms unless given. heading: above all. fixed: for each building, as in plot_room_graph.

    Raises OptionError without any building, with less than a column, and with more or less titles than buildings.
    """
    _check_sheet(graphs, titles, fixed, columns)
    shown = graphs[:MAX_SHEET]
    fixed = fixed or [()] * len(shown)
    counts = [f"{len(graph)} room{'s' * (len(graph) != 1)}" for graph in shown]
    titles = titles or [f"{number}: {count}" for number, count in enumerate(counts, 1)]
    cut = f"{MAX_SHEET} of {len(graphs)}" if len(graphs) > MAX_SHEET else None
    handles = list_handles(shown, schema, fixed=any(map(len, fixed[:MAX_SHEET])))
    figure, axes = _start_sheet(len(shown), columns, handles, ": ".join(part for part in (heading, cut) if part))
    for ax, graph, nodes, title in zip(axes, shown, fixed, titles, strict=False):
        plot_room_graph(graph, ax=ax, schema=schema, fixed=nodes)
        ax.set_title(_cut(title), fontsize=FONT_SIZE, color=INK, pad=3, parse_math=False)
    return figure


def save_contact_sheet(
    graphs: Sequence[nx.Graph],
    path: str | Path,
    *,
    schema: LabelSchema,
    titles: Sequence[str] | None = None,
    heading: str | None = None,
    columns: int = COLUMNS,
    fixed: Sequence[Collection[Hashable]] | None = None,
) -> None:
    """Write the picture of draw_contact_sheet as a PNG, the same bytes for the same graphs.

    Raises OptionError as draw_contact_sheet does, and PiantaError when the file cannot be written.
    """
    figure = draw_contact_sheet(graphs, schema=schema, titles=titles, heading=heading, columns=columns, fixed=fixed)
    save_png(figure, path)


def place_nodes(graph: nx.Graph) -> dict[Hashable, tuple[float, float]]:
    """x, y of each node in a drawing, in lengths of its shortest edges: rooms around their corridors, parts apart.

    Nodes lie so that their distances are those of the shortest paths as far as they can (stress majorization, Gansner,
    Koren and North 2004), where a corridor has the longer edges the more rooms it has.
    """
    if not len(graph):
        return {}
    joined = nx.to_numpy_array(graph, weight=None) > 0
    np.fill_diagonal(joined, 0)
    count, part_of = connected_components(joined, directed=False)
    members = [np.flatnonzero(part_of == part) for part in range(count)]
    parts = [_place_part(joined[np.ix_(nodes, nodes)]) for nodes in members]
    xy = np.empty((len(graph), 2))
    for nodes, part, corner in zip(members, parts, _pack_parts(parts), strict=True):
        xy[nodes] = part + corner
    return {node: (float(x), float(y)) for node, (x, y) in zip(graph, xy, strict=True)}


def _place_part(joined: Mask) -> Floats:
    """Places of connected nodes, shape (n, 2), from 0 upwards."""
    if len(joined) == 1:
        return np.zeros((1, 2))
    edges = np.argwhere(np.triu(joined))
    wanted = _wanted_distances(joined)
    tried = [_majorize(start, wanted, STEPS) for start in _start_places(joined, wanted)]
    xy = min(tried, key=lambda places: (len(_find_crossings(places, edges)), _stress(places, wanted)))
    return _turn(_push_apart(_uncross(xy, edges, wanted), edges))


def _turn(xy: Floats) -> Floats:
    """Places turned so that the drawing is large in a picture, from 0 upwards."""
    angles = np.linspace(0, np.pi, TURNS, endpoint=False)
    turned = [xy @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) for a in angles]
    sides = np.ptp(turned, axis=1)
    sizes = (sides / (CELL_WIDTH, CELL_HEIGHT)).max(axis=1)
    # A long building lies rather than climbs.
    flattest = np.where(sizes <= LARGER_TURNED * sizes.min(), sides[:, 1], np.inf).argmin()
    return np.asarray(turned[flattest] - turned[flattest].min(axis=0))


def _wanted_distances(joined: Mask) -> Floats:
    """Lengths of shortest paths, shape (n, n), where an edge leads out of the circles of rooms around both its ends."""
    degrees = joined.sum(axis=1)
    circles = np.where(degrees > 1, ROOM_ARC * degrees / (2 * np.pi), 0)
    lengths = np.maximum(circles[:, None] + circles, 1)
    return np.asarray(shortest_path(np.where(joined, lengths, 0), directed=False))


def _start_places(joined: Mask, wanted: Floats) -> Iterator[Floats]:
    """Where nodes start: all by classical scaling, and those with two neighbours so, the others on their neighbour."""
    angles = GOLDEN_ANGLE * np.arange(len(joined))
    offsets = OFFSET * np.column_stack([np.cos(angles), np.sin(angles)])
    yield _scale(wanted) + offsets
    inner = joined.sum(axis=1) > 1
    if inner.sum() > 2:
        among = wanted[np.ix_(inner, inner)]
        xy = np.zeros((len(joined), 2))
        xy[inner] = _majorize(_scale(among) + offsets[inner], among, STEPS)
        xy[~inner] = xy[joined[~inner].argmax(axis=1)]
        yield xy + offsets


def _scale(wanted: Floats) -> Floats:
    """Classical scaling: places, shape (n, 2), from distances."""
    squares = wanted**2
    centred = squares.mean(axis=0) + squares.mean(axis=1)[:, None] - squares.mean() - squares
    values, vectors = np.linalg.eigh(centred / 2)
    return np.asarray(vectors[:, -2:] * np.sqrt(np.maximum(values[-2:], 0)))


def _majorize(xy: Floats, wanted: Floats, steps: int) -> Floats:
    """Places after steps towards wanted distances; a pair of nodes counts by 1 / distance²."""
    count = len(xy)
    weights = _weigh(wanted)
    inverse = np.linalg.inv(np.diag(weights.sum(axis=1)) - weights + 1 / count) - 1 / count
    pulls = weights * wanted
    for _ in range(steps):
        pull = -pulls / np.maximum(_distances(xy), 1e-9)
        np.fill_diagonal(pull, 0)
        np.fill_diagonal(pull, -pull.sum(axis=1))
        xy = inverse @ (pull @ xy)
    return xy


def _stress(xy: Floats, wanted: Floats) -> float:
    return float((_weigh(wanted) * (_distances(xy) - wanted) ** 2).sum())


def _weigh(wanted: Floats) -> Floats:
    off = ~np.eye(len(wanted), dtype=bool)
    return np.asarray(np.divide(1, wanted**2, out=np.zeros_like(wanted), where=off))


def _distances(xy: Floats) -> Floats:
    return np.asarray(np.hypot(*(xy[:, None] - xy).transpose(2, 0, 1)))


def _find_crossings(xy: Floats, edges: NDArray[np.intp]) -> NDArray[np.intp]:
    """Pairs of edges without a common end that cross, shape (k, 2)."""
    first, second = xy[edges].transpose(1, 0, 2)
    along = (second - first)[:, None]

    def find_side(of: Floats) -> Mask:
        """For edge i and a point of edge j whether it lies left of i."""
        to = of - first[:, None]
        return np.asarray(along[..., 0] * to[..., 1] > along[..., 1] * to[..., 0])

    parted = find_side(first) != find_side(second)
    common = (edges[:, None, :, None] == edges[:, None, :]).any(axis=(2, 3))
    return np.argwhere(np.triu(parted & parted.T & ~common))


def _uncross(xy: Floats, edges: NDArray[np.intp], wanted: Floats) -> Floats:
    """Places after swaps of nodes at the ends of edges that cross, as long as a swap makes fewer cross."""
    crossings = _find_crossings(xy, edges)
    for _ in range(MAX_SWAPS):
        swapped = []
        for one, other in crossings[:CROSSINGS_A_SWAP]:
            for pair in product(edges[one], edges[other]):
                places = xy.copy()
                places[[*pair]] = xy[[*reversed(pair)]]
                swapped.append(_majorize(places, wanted, STEPS_OF_SWAP))
        fewest = min(swapped, key=lambda places: len(_find_crossings(places, edges)), default=xy)
        left = _find_crossings(fewest, edges)
        if len(left) >= len(crossings):
            break
        xy, crossings = fewest, left
    return xy


def _push_apart(xy: Floats, edges: NDArray[np.intp]) -> Floats:
    """Places where no node touches another or an edge of others, as far as pushes lead."""
    xy = xy.copy()
    nodes = np.arange(len(xy))
    strangers = (edges[:, :1] != nodes) & (edges[:, 1:] != nodes)
    for _ in range(PUSHES):
        push = _push_nodes(xy) + _push_from_edges(xy, edges, strangers)
        if np.abs(push).max(initial=0) < 1e-3:
            break
        xy += push
    for _ in range(PUSHES):
        xy += _push_nodes(xy)
    return xy


def _push_nodes(xy: Floats) -> Floats:
    """Half of what nodes lack of their distance, shape (n, 2)."""
    distances = np.maximum(_distances(xy), 1e-9)
    shares = np.maximum(NODE_GAP / distances - 1, 0) / 2
    np.fill_diagonal(shares, 0)
    return np.asarray(((xy[:, None] - xy) * shares[..., None]).sum(axis=1))


def _push_from_edges(xy: Floats, edges: NDArray[np.intp], strangers: Mask) -> Floats:
    """Half of what nodes lack of a distance to edges, shape (n, 2), the edge the other half."""
    first, second = xy[edges].transpose(1, 0, 2)
    along = second - first
    share = ((xy - first[:, None]) * along[:, None]).sum(axis=-1) / np.maximum((along**2).sum(axis=-1), 1e-9)[:, None]
    away = xy - (first[:, None] + np.clip(share, 0, 1)[..., None] * along[:, None])
    distances = np.hypot(away[..., 0], away[..., 1])
    lack = np.where(strangers & (share > 0) & (share < 1), np.maximum(EDGE_GAP - distances, 0) / 2, 0)
    of_node = away * (lack / np.maximum(distances, 1e-9))[..., None]
    push = of_node.sum(axis=0)
    np.add.at(push, edges, -of_node.sum(axis=1)[:, None] / 2)
    return np.asarray(push)


def _pack_parts(parts: Sequence[Floats]) -> list[Floats]:
    """For each part of a building its lower left corner, in rows of about the shape of a picture, the largest first."""
    sizes = [part.max(axis=0) + PART_GAP for part in parts]
    area = sum(float(size.prod()) for size in sizes)
    widest = max([np.sqrt(area * CELL_WIDTH / CELL_HEIGHT), *(size[0] for size in sizes)], default=0)
    corners: list[Floats] = [np.zeros(2)] * len(parts)
    x, top, row = 0.0, 0.0, 0.0
    for index in sorted(range(len(parts)), key=lambda index: (-sizes[index].prod(), index)):
        wide, high = sizes[index]
        if x and x + wide > widest * (1 + 1e-9):
            x, top, row = 0.0, top - row, 0.0
        row = max(row, high)
        corners[index] = np.array([x, top - high])
        x += wide
    return corners


def _style_room(label: str | None, schema: LabelSchema) -> RoomStyle:
    known = schema.by_name.get(normalize_label(label) or "")
    if known is None:
        return RoomStyle(NEUTRAL_COLOR)
    return RoomStyle(known.color, is_corridor=known.room_or_corridor(LabelConvention.GRAPHS) == RC.CORRIDOR)


def _make_node(place: tuple[float, float], style: RoomStyle, *, fixed: bool) -> Patch:
    from matplotlib.patches import Circle, Rectangle

    width = THICK_OUTLINE if fixed else OUTLINE
    look: dict[str, Any] = {"facecolor": style.fill, "edgecolor": INK, "linewidth": width, "zorder": GRAPH_LEVEL}
    if not style.is_corridor:
        return Circle(place, RADIUS, **look)
    return Rectangle((place[0] - HALF_SIDE, place[1] - HALF_SIDE), 2 * HALF_SIDE, 2 * HALF_SIDE, **look)


def _frame(ax: Axes, xy: Floats) -> None:
    """Show all nodes in all of the ax, and few of them not too large."""
    low, high = (xy.min(axis=0), xy.max(axis=0)) if len(xy) else np.zeros((2, 2))
    half = (high - low) / 2 + MARGIN
    wide_per_high = ax.bbox.width / ax.bbox.height
    half_height = max(half[0] / wide_per_high, half[1], LEAST_HEIGHT / 2)
    x, y = (low + high) / 2
    ax.set(xlim=(x - half_height * wide_per_high, x + half_height * wide_per_high), aspect="equal")
    ax.set_ylim(y - half_height, y + half_height)
    ax.set_axis_off()


def list_handles(graphs: Sequence[nx.Graph], schema: LabelSchema, *, fixed: bool) -> list[Line2D]:
    """Entries of a legend: the labels that rooms have, in the order of the schema, then those it does not have."""
    names = {normalize_label(label) for graph in graphs for _, label in graph.nodes(data="label")}
    handles = [_make_handle(_cut(name), _style_room(name, schema)) for name in schema.by_name if name in names]
    if names.difference(schema.by_name):
        handles.append(_make_handle(OTHER_LABELS, RoomStyle(NEUTRAL_COLOR)))
    if fixed:
        handles.append(_make_handle(FIXED, RoomStyle(NEUTRAL_COLOR), fixed=True))
    return handles


def _make_handle(text: str, style: RoomStyle, *, fixed: bool = False) -> Line2D:
    from matplotlib.lines import Line2D

    marker, width = "s" if style.is_corridor else "o", THICK_OUTLINE if fixed else OUTLINE
    look: dict[str, Any] = {"markerfacecolor": style.fill, "markeredgecolor": INK, "markeredgewidth": width}
    return Line2D([], [], linestyle="none", marker=marker, markersize=9, label=text, **look)


def _start_sheet(count: int, columns: int, handles: Sequence[Line2D], heading: str) -> tuple[Figure, list[Axes]]:
    """A figure with a heading and a legend, and so many axes in columns between them, each with place for a title."""
    from matplotlib.figure import Figure

    columns = min(columns, count)
    width = CELL_WIDTH * columns
    legend_columns = min(int(width / LEGEND_WIDTH), max(len(handles), 1))
    above, below = HEADING if heading else 0.0, LEGEND_ROW * (-(-len(handles) // legend_columns) + 1)
    height = above - (-count // columns) * CELL_HEIGHT + below
    figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    figure.text(0.1 / width, 1 - 0.1 / height, heading, fontsize=1.4 * FONT_SIZE, color=INK, va="top", parse_math=False)
    legend = figure.legend(handles=handles, loc="lower center", ncols=legend_columns, frameon=False, fontsize=FONT_SIZE)
    for text in legend.get_texts():
        text.set(color=INK, parse_math=False)
    share = ((CELL_WIDTH - CELL_GAP) / width, (CELL_HEIGHT - TITLE_HEIGHT) / height)
    corners = (
        ((column * CELL_WIDTH + CELL_GAP / 2) / width, 1 - (above + (row + 1) * CELL_HEIGHT) / height)
        for row, column in (divmod(place, columns) for place in range(count))
    )
    return figure, [figure.add_axes((*corner, *share)) for corner in corners]


def _check_sheet(
    graphs: Sequence[nx.Graph], titles: Sequence[str] | None, fixed: Sequence[Collection[Hashable]] | None, columns: int
) -> None:
    if not graphs:
        raise OptionError("there is no building to draw, give one at least")
    if columns < 1:
        raise OptionError(f"a sheet of {columns} columns has no place for a building, give 1 at least")
    for what, given in (("titles", titles), ("sets of fixed rooms", fixed)):
        if given is not None and len(given) != len(graphs):
            raise OptionError(f"there are {len(given)} {what} for {len(graphs)} buildings, give one for each")


def _cut(text: str) -> str:
    return text if len(text) <= LONGEST_LABEL else f"{text[: LONGEST_LABEL - 1]}…"
