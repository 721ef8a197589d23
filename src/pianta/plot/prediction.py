"""Pictures of predictions, in the style of Figs. 8.9 to 8.12: the known part of a floor shaded, beside samples."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Hashable, Mapping
from math import ceil
from statistics import median
from typing import TYPE_CHECKING, Any, TypeAlias

import networkx as nx
import shapely

from pianta.floor.polygons import list_polygons
from pianta.io._files import count_noun
from pianta.labels import LabelSchema
from pianta.plot.figure import clean_legend, make_square, new_ax, new_figure
from pianta.plot.graphs import HALF_SIDE, list_handles, place_nodes, plot_room_graph
from pianta.plot.styles import DARK_INK, EDGE_COLOR
from pianta.prediction.prediction import Prediction
from pianta.prediction.revealed_floor import RevealedFloor
from pianta.prediction.unexplored_part import SampledFloor

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Positions: TypeAlias = Mapping[Hashable, tuple[float, float]]

SHADE_COLOR = "#d4d4d4"
CORRIDOR_COLOR = "#f5a442"
OPEN_COLOR = "#c1272d"
# Bars as in the thesis: of the true floor, of all floors of the model, predicted.
TRUE_COLOR = "#e8c520"
AVERAGE_COLOR = "#4c9f50"
PREDICTED_COLOR = "#7b4fa3"

# In lengths of the shortest edges: shade around known nodes and along edges between them, frame around an open
# corridor, half the side of a corridor of the skeleton (small, as its edges have numbers).
NODE_RIM = 0.6
EDGE_RIM = 0.3
OPEN_RIM = 0.16
SKELETON_HALF = 0.2
# Labels with a smaller share in each distribution have no bars; width of all bars of a label together.
MIN_SHARE = 0.005
BARS_WIDTH = 0.8
# Share of the samples, those nearest to the median size, from which the sample that is drawn is chosen.
MIDDLE_SHARE = 0.25
# Skeleton: less probable edges are not drawn; only this number of the most probable edges have numbers.
MIN_PROBABILITY = 0.05
MAX_NUMBERS = 30
# Widths of its edges, points, for probability 0 and 1; least opacity.
NARROWEST = 1.0
WIDEST = 5.0
MIN_OPACITY = 0.5
SHADE_LEVEL, LINE_LEVEL, NODE_LEVEL, TEXT_LEVEL = -1, 1, 2, 6

# Inches: width of the picture, heights of its upper and lower row, of a title, of margins, of the names below bars, and
# of a row of the legend.
WIDTH = 14.0
UPPER = 6.0
LOWER = 4.0
TITLE = 0.45
MARGIN = 0.25
NAMES = 1.0
LEGEND_ROW = 0.24
# Width of the skeleton, per width of the picture.
SKELETON_SHARE = 0.45
LEGEND_COLUMNS = 6
# Characters of the name of a corridor.
MAX_NAME_LENGTH = 6
FONT_SIZE = 10
SMALL_FONT_SIZE = 7.5
TINY_FONT_SIZE = 5.5


def draw_prediction(prediction: Prediction, *, truth: RevealedFloor | None = None) -> Figure:
    """Picture of a prediction: the known part, a sample, the corridors, and bars of labels, over a legend.

    truth: the whole floor; it is then drawn with its known part shaded, instead of the known part alone.
    """
    sample = choose_sample(prediction)
    graphs = [truth.graph if truth else prediction.explored.graph, sample.graph]
    handles = list_handles(graphs, prediction.schema, fixed=False)
    below = LEGEND_ROW * (-(-len(handles) // LEGEND_COLUMNS) + 1)
    figure = new_figure(WIDTH, UPPER + LOWER + below)
    half, skeleton = WIDTH / 2, SKELETON_SHARE * WIDTH
    plot_explored(prediction, ax=_add_axes(figure, 0, below + LOWER, half, UPPER), truth=truth)
    plot_sample(sample, prediction, ax=_add_axes(figure, half, below + LOWER, half, UPPER))
    plot_skeleton(prediction.skeleton, ax=_add_axes(figure, 0, below, skeleton, LOWER))
    bars = _add_axes(figure, skeleton + 2 * MARGIN, below + NAMES, WIDTH - skeleton - 2 * MARGIN, LOWER - NAMES)
    plot_label_shares(prediction.shares, prediction.average, ax=bars, true=truth.shares if truth else None)
    clean_legend(
        figure.legend(handles=handles, loc="lower center", ncols=LEGEND_COLUMNS, frameon=False, fontsize=FONT_SIZE)
    )
    return figure


def plot_explored(prediction: Prediction, *, ax: Axes | None = None, truth: RevealedFloor | None = None) -> Axes:
    """Draw the known part of a floor, shaded, with red frames on open corridors and `?` behind unopened doors.

    Corridors have their names, as in `plot_skeleton`.

    Parameters
    ----------
    prediction
        The result of `predict`.
    ax
        Where to draw, in lengths of the shortest edges; a new figure if None.
    truth
        Draw the whole floor instead, with its known part shaded.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    References
    ----------
    M. Luperto, PhD thesis, Figs. 8.8 to 8.12.

    Examples
    --------
    >>> import pianta
    >>> model = pianta.load_model("school.json")  # doctest: +SKIP
    >>> prediction = pianta.predict(pianta.read_floor("floor.geojson"), model)  # doctest: +SKIP
    >>> ax = pianta.plot.plot_explored(prediction)  # doctest: +SKIP
    """
    ax = new_ax(ax)
    explored = prediction.explored
    room_ids = dict(explored.graph.nodes(data="room"))
    # Nodes of the whole floor are the ids of its rooms; those of the explored part are not.
    node_names = room_ids if truth else {node: node for node in explored.graph}
    graph = truth.graph if truth else explored.graph
    known_nodes = [node_names[node] for node in explored.known_graph]
    open_ends = [node_names[node] for node in explored.open]
    corridors = {node_names[node]: room_ids[node] for node in explored.corridors}
    plot_known_part(graph, known_nodes, ax=ax, schema=prediction.schema, open_ends=open_ends, names=corridors)
    if truth:
        title = f"the floor: {count_noun(len(graph), 'room')}, {len(known_nodes)} of them known (grey)"
    else:
        ends = count_noun(explored.open_ends, "open end")
        title = f"explored: {count_noun(len(known_nodes), 'room')} known (grey), {ends} (red, ?)"
    _add_title(ax, title)
    return ax


def choose_sample(prediction: Prediction) -> SampledFloor:
    """Of the samples of about median size the one whose unknown rooms have labels nearest to the expected ones.

    Not `Prediction.typical`: by the normalised kernel small floors are the most similar to all others, even floors
    without any unknown room.
    """
    middle = median(len(sample.graph) for sample in prediction.samples)
    by_size = sorted(prediction.samples, key=lambda sample: abs(len(sample.graph) - middle))

    def differ(sample: SampledFloor) -> float:
        counts = Counter(sample.graph.nodes[node]["label"] for node in sample.unseen)
        return round(sum(abs(counts[label] - expected.mean) for label, expected in prediction.counts.items()), 9)

    return min(by_size[: ceil(MIDDLE_SHARE * len(by_size))], key=differ)


def plot_sample(sample: SampledFloor, prediction: Prediction, *, ax: Axes | None = None) -> Axes:
    """Draw a sample, its known part shaded, with red frames on open corridors."""
    ax = new_ax(ax)
    open_ends = [sample.known_nodes[node] for node in prediction.explored.open]
    plot_known_part(sample.graph, sample.known_nodes.values(), ax=ax, schema=prediction.schema, open_ends=open_ends)
    title = f"one of {len(prediction.samples)} samples, of middle size: {count_noun(len(sample.graph), 'room')}"
    _add_title(ax, f"{title} ({prediction.rooms.low:.0f}–{prediction.rooms.high:.0f} expected)")
    return ax


def plot_known_part(
    graph: nx.Graph,
    known_nodes: Collection[Hashable],
    *,
    ax: Axes | None = None,
    schema: LabelSchema,
    open_ends: Collection[Hashable] = (),
    names: Mapping[Any, Hashable] | None = None,
) -> Axes:
    """Draw a floor as plot_room_graph does, its known part on a grey shade (Figs. 8.9 to 8.22).

    Rooms without a label have a `?`. open_ends: nodes with a red frame. names: texts of nodes.
    """
    from shapely.plotting import patch_from_polygon

    ax = new_ax(ax)
    plot_room_graph(graph, ax=ax, schema=schema)
    positions = place_nodes(graph)
    shade = _shade(graph.subgraph(known_nodes), positions)
    for part in list_polygons(shade):
        ax.add_patch(patch_from_polygon(part, facecolor=SHADE_COLOR, edgecolor="none", zorder=SHADE_LEVEL))
    for node in open_ends:
        frame = {"facecolor": "none", "edgecolor": OPEN_COLOR, "linewidth": 1.5, "zorder": TEXT_LEVEL}
        ax.add_patch(make_square(positions[node], HALF_SIDE + OPEN_RIM, frame))
    texts = {node: "?" for node, label in graph.nodes(data="label") if label is None}
    texts |= {node: str(name)[:MAX_NAME_LENGTH] for node, name in (names or {}).items()}
    look: dict[str, Any] = {"ha": "center", "va": "center_baseline", "fontsize": TINY_FONT_SIZE, "zorder": TEXT_LEVEL}
    for node, text in texts.items():
        ax.text(*positions[node], text, color=DARK_INK, parse_math=False, **look)
    return ax


def plot_skeleton(skeleton: nx.Graph, *, ax: Axes | None = None) -> Axes:
    """Draw the corridors of `Prediction.skeleton`: known ones filled, edges wider and darker if more probable.

    Numbers are probabilities in %; edges below 5 % are not drawn, nor corridors that only they lead to.

    Parameters
    ----------
    skeleton
        The `skeleton` of a `Prediction`; each node and edge has a `probability`.
    ax
        Where to draw, in lengths of the shortest edges; a new figure if None.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import networkx as nx
    >>> import pianta
    >>> skeleton = nx.Graph()
    >>> skeleton.add_node(3, probability=1.0)
    >>> skeleton.add_node(("beyond", 3), probability=0.4)
    >>> skeleton.add_edge(3, ("beyond", 3), probability=0.4)
    >>> ax = pianta.plot.plot_skeleton(skeleton)
    """
    ax = new_ax(ax)
    probable = _list_probable(skeleton)
    positions = place_nodes(probable)
    for one, other, probability in probable.edges(data="probability"):
        width = NARROWEST + (WIDEST - NARROWEST) * probability
        xs, ys = zip(positions[one], positions[other], strict=True)
        color = EDGE_COLOR if probability == 1 else OPEN_COLOR
        ax.plot(xs, ys, color=color, linewidth=width, alpha=max(MIN_OPACITY, probability), zorder=LINE_LEVEL)
    for node, probability in probable.nodes(data="probability"):
        is_known = probability == 1
        look: dict[str, Any] = {"facecolor": CORRIDOR_COLOR if is_known else "white", "edgecolor": DARK_INK}
        look |= {"linestyle": "-" if is_known else ":", "linewidth": 0.8, "zorder": NODE_LEVEL}
        ax.add_patch(make_square(positions[node], SKELETON_HALF, look))
        name = "?" if isinstance(node, tuple) or not is_known else str(node)[:MAX_NAME_LENGTH]
        text: dict[str, Any] = {
            "ha": "center",
            "va": "center_baseline",
            "fontsize": SMALL_FONT_SIZE,
            "zorder": TEXT_LEVEL,
        }
        ax.text(*positions[node], name, parse_math=False, **text)
    _number_edges(probable, positions, ax=ax)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.12)
    ax.set_axis_off()
    _add_title(ax, "corridors: known ones, and what may join them (%)")
    return ax


def plot_label_shares(
    predicted: Mapping[str, float],
    average: Mapping[str, float],
    *,
    ax: Axes | None = None,
    true: Mapping[str, float] | None = None,
) -> Axes:
    """Draw bars of the shares of labels among unknown rooms: true, of the model's floors, predicted (Fig. 8.9c)."""
    ax = new_ax(ax, equal=False)
    series = [(true, TRUE_COLOR, "true")] if true is not None else []
    series += [(average, AVERAGE_COLOR, "average of the model"), (predicted, PREDICTED_COLOR, "predicted")]
    names = list(dict.fromkeys(name for shares, *_ in series for name in shares))
    names = [name for name in names if max(shares.get(name, 0) for shares, *_ in series) >= MIN_SHARE]
    names.sort(key=lambda name: -predicted.get(name, 0))
    width = BARS_WIDTH / len(series)
    for number, (shares, color, title) in enumerate(series):
        centers = [index - BARS_WIDTH / 2 + (number + 0.5) * width for index in range(len(names))]
        ax.bar(centers, [100 * shares.get(name, 0) for name in names], width, color=color, label=title)
    ax.set_xticks(range(len(names)), names, rotation=40, ha="right", rotation_mode="anchor", parse_math=False)
    ax.set_ylabel("% of unknown rooms", fontsize=FONT_SIZE, color=DARK_INK)
    ax.tick_params(labelsize=SMALL_FONT_SIZE, colors=DARK_INK, length=0)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(frameon=False, fontsize=FONT_SIZE, labelcolor=DARK_INK)
    _add_title(ax, "labels of unknown rooms")
    return ax


def _shade(known_part: nx.Graph, positions: Positions) -> shapely.Geometry:
    """The area around known nodes and along the edges between them."""
    nodes = [shapely.Point(positions[node]).buffer(NODE_RIM) for node in known_part]
    edges = [shapely.LineString([positions[one], positions[other]]).buffer(EDGE_RIM) for one, other in known_part.edges]
    return shapely.union_all([*nodes, *edges])


def _list_probable(skeleton: nx.Graph) -> nx.Graph:
    """The skeleton without improbable edges and the nodes that only they lead to."""
    probable = nx.Graph()
    probable.add_nodes_from((node, data) for node, data in skeleton.nodes(data=True) if data["probability"] == 1)
    for one, other, probability in skeleton.edges(data="probability"):
        if probability >= MIN_PROBABILITY:
            probable.add_nodes_from((node, skeleton.nodes[node]) for node in (one, other))
            probable.add_edge(one, other, probability=probability)
    return probable


def _number_edges(skeleton: nx.Graph, positions: Positions, *, ax: Axes) -> None:
    """Write the probabilities of uncertain edges on them, the most probable ones if there are many."""
    uncertain = [edge for edge in skeleton.edges(data="probability") if edge[2] < 1]
    box = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}
    look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": SMALL_FONT_SIZE, "color": DARK_INK}
    for one, other, probability in sorted(uncertain, key=lambda edge: -edge[2])[:MAX_NUMBERS]:
        (x, y), (other_x, other_y) = positions[one], positions[other]
        ax.text((x + other_x) / 2, (y + other_y) / 2, f"{100 * probability:.0f}", bbox=box, zorder=TEXT_LEVEL, **look)


def _add_axes(figure: Figure, x: float, y: float, width: float, height: float) -> Axes:
    """Axes in a box of the figure in inches, inside margins and below a title."""
    total_width, total_height = figure.get_size_inches()
    inner_width, inner_height = width - 2 * MARGIN, height - TITLE - MARGIN
    corner = (x + MARGIN) / total_width, (y + MARGIN) / total_height
    return figure.add_axes((*corner, inner_width / total_width, inner_height / total_height))


def _add_title(ax: Axes, text: str) -> None:
    ax.set_title(text, fontsize=FONT_SIZE + 1, color=DARK_INK, pad=5)
