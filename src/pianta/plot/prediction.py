"""Pictures of predictions, in the style of Figs. 8.9 to 8.12: what is known is shaded, what is not is expected."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Hashable, Mapping
from math import ceil
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, TypeAlias

import networkx as nx
import shapely

from pianta.labels import LabelSchema
from pianta.plot._figure import new_ax, save_png
from pianta.plot.floor import DPI, INK
from pianta.plot.graphs import HALF_SIDE, list_handles, place_nodes, plot_room_graph
from pianta.prediction.prediction import Prediction
from pianta.prediction.revealed_floor import RevealedFloor
from pianta.prediction.unexplored_part import SampledFloor

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Box: TypeAlias = tuple[float, float, float, float]

OVERLAY, CORRIDOR_COLOR, OPEN_COLOR, EDGE_COLOR = "#d4d4d4", "#f5a442", "#c1272d", "#555555"
# Around known nodes and along edges between them, in lengths of the shortest edges; the frame of an open corridor.
NODE_RIM, EDGE_RIM, OPEN_RIM = 0.6, 0.3, 0.16
# As in the thesis: of the real floor, of all floors of the model, predicted.
TRUE_COLOR, AVERAGE_COLOR, PREDICTED_COLOR = "#e8c520", "#4c9f50", "#7b4fa3"
# Labels with less everywhere have no bars; bars of a label together are so wide.
LEAST_SHARE, BARS_WIDTH = 0.005, 0.8
# Half the side of a corridor of the skeleton, whose edges have numbers on them.
SKELETON_HALF = 0.2
# A sample is of middle size when it is among so many of all.
MIDDLE_SHARE = 0.25
# Less probable edges of the skeleton are not drawn; numbers of the most probable ones are; widths; no edge is fainter.
LEAST_PROBABILITY, MOST_NUMBERS, NARROWEST, WIDEST, FAINTEST = 0.05, 30, 1.0, 5.0, 0.5
OVERLAY_LEVEL, LINE_LEVEL, NODE_LEVEL, TEXT_LEVEL = -1, 1, 2, 6
# Inches: the picture, its upper row, titles, margins, names below bars, a row of the legend.
WIDTH, UPPER, LOWER, TITLE, MARGIN, NAMES, LEGEND_ROW = 14.0, 6.0, 4.0, 0.45, 0.25, 1.0, 0.24
SKELETON_SHARE, LEGEND_COLUMNS, LONGEST_NAME = 0.45, 6, 6
FONT_SIZE, SMALL, TINY = 10, 7.5, 5.5


def draw_prediction(prediction: Prediction, *, truth: RevealedFloor | None = None) -> Figure:
    """Picture of a prediction: what is known, a sample, the corridors, and bars of labels, over a legend.

    truth: the whole floor, which is drawn in the place of what is known of it, with that shaded.
    """
    from matplotlib.figure import Figure

    sample = choose_sample(prediction)
    graphs = [truth.graph if truth else prediction.explored.graph, sample.graph]
    handles = list_handles(graphs, prediction.schema, fixed=False)
    below = LEGEND_ROW * (-(-len(handles) // LEGEND_COLUMNS) + 1)
    figure = Figure(figsize=(WIDTH, UPPER + LOWER + below), dpi=DPI, facecolor="white")
    half, skeleton = WIDTH / 2, SKELETON_SHARE * WIDTH
    plot_explored(prediction, ax=_add_axes(figure, (0, below + LOWER, half, UPPER)), truth=truth)
    plot_sample(sample, prediction, ax=_add_axes(figure, (half, below + LOWER, half, UPPER)))
    plot_skeleton(prediction.skeleton, ax=_add_axes(figure, (0, below, skeleton, LOWER)))
    bars = _add_axes(figure, (skeleton + 2 * MARGIN, below + NAMES, WIDTH - skeleton - 2 * MARGIN, LOWER - NAMES))
    plot_label_shares(prediction.shares, prediction.average, ax=bars, true=truth.shares if truth else None)
    legend = figure.legend(handles=handles, loc="lower center", ncols=LEGEND_COLUMNS, frameon=False, fontsize=FONT_SIZE)
    for text in legend.get_texts():
        text.set(color=INK, parse_math=False)
    return figure


def save_prediction_picture(prediction: Prediction, path: str | Path, *, truth: RevealedFloor | None = None) -> None:
    """Write the picture of draw_prediction as a PNG, the same bytes for the same prediction.

    Raises PiantaError when the file cannot be written.
    """
    figure = draw_prediction(prediction, truth=truth)
    save_png(figure, path)


def plot_explored(prediction: Prediction, *, ax: Axes | None = None, truth: RevealedFloor | None = None) -> Axes:
    """Draw what is known of a floor, shaded; open corridors in a red frame, and `?` for rooms behind unopened doors.

    Corridors have their names, as in `plot_skeleton`.

    Parameters
    ----------
    prediction
        Of `predict`.
    ax
        Where to draw, in lengths of the shortest edges; a new figure if None.
    truth
        Draw the whole floor instead, what is known of it shaded.

    Returns
    -------
    Axes
        The ax that was drawn on; nothing is shown.

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
    names = dict(explored.graph.nodes(data="room"))
    open_ends = [names[node] if truth else node for node in explored.open]
    corridors = {names[node] if truth else node: names[node] for node in explored.corridors}
    if truth:
        known: list[Hashable] = [names[node] for node in explored.known_graph]
        plot_known_part(truth.graph, known, ax=ax, schema=prediction.schema, open_ends=open_ends, names=corridors)
        _add_title(ax, f"the floor: {_count(len(truth.graph), 'room')}, {len(known)} of them known (grey)")
    else:
        plot_known_part(
            explored.graph, explored.known_graph, ax=ax, schema=prediction.schema, open_ends=open_ends, names=corridors
        )
        seen = f"{_count(len(explored.known_graph), 'room')} known (grey)"
        _add_title(ax, f"explored: {seen}, {_count(explored.open_ends, 'open end')} (red, ?)")
    return ax


def choose_sample(prediction: Prediction) -> SampledFloor:
    """The sample of about middle size whose unknown rooms have labels most like those that are expected.

    Not `Prediction.typical`: small floors are most like all others by the normalised kernel, also without any unknown
    room.
    """
    middle = median(len(sample.graph) for sample in prediction.samples)
    by_size = sorted(prediction.samples, key=lambda sample: abs(len(sample.graph) - middle))

    def differ(sample: SampledFloor) -> float:
        found = Counter(sample.graph.nodes[node]["label"] for node in sample.unseen)
        return round(sum(abs(found[label] - spread.mean) for label, spread in prediction.counts.items()), 9)

    return min(by_size[: ceil(MIDDLE_SHARE * len(by_size))], key=differ)


def plot_sample(sample: SampledFloor, prediction: Prediction, *, ax: Axes | None = None) -> Axes:
    """Draw a sample, what is known shaded, open corridors in a red frame."""
    ax = new_ax(ax)
    open_ends = [sample.known_nodes[node] for node in prediction.explored.open]
    plot_known_part(sample.graph, sample.known_nodes.values(), ax=ax, schema=prediction.schema, open_ends=open_ends)
    of = f"one of {len(prediction.samples)} samples, of middle size: {_count(len(sample.graph), 'room')}"
    _add_title(ax, f"{of} ({prediction.rooms.low:.0f}–{prediction.rooms.high:.0f} expected)")
    return ax


def plot_known_part(
    graph: nx.Graph,
    known: Collection[Hashable],
    *,
    ax: Axes | None = None,
    schema: LabelSchema,
    open_ends: Collection[Hashable] = (),
    names: Mapping[Any, Hashable] | None = None,
) -> Axes:
    """Draw a floor as plot_room_graph does, its known part on a grey overlay (Figs. 8.9 to 8.22).

    Rooms without a label have a `?`. open_ends: nodes with a red frame. names: what is written on nodes.
    """
    from matplotlib.patches import Rectangle
    from shapely.plotting import patch_from_polygon

    ax = new_ax(ax)
    plot_room_graph(graph, ax=ax, schema=schema)
    places = place_nodes(graph)
    shade = _shade(graph.subgraph(known), places)
    for part in shapely.get_parts(shade):
        ax.add_patch(patch_from_polygon(part, facecolor=OVERLAY, edgecolor="none", zorder=OVERLAY_LEVEL))
    half = HALF_SIDE + OPEN_RIM
    for node in open_ends:
        x, y = places[node]
        frame: dict[str, Any] = {"facecolor": "none", "edgecolor": OPEN_COLOR, "linewidth": 1.5, "zorder": TEXT_LEVEL}
        ax.add_patch(Rectangle((x - half, y - half), 2 * half, 2 * half, **frame))
    written = {node: "?" for node, label in graph.nodes(data="label") if label is None}
    written |= {node: str(name)[:LONGEST_NAME] for node, name in (names or {}).items()}
    look: dict[str, Any] = {"ha": "center", "va": "center_baseline", "fontsize": TINY, "zorder": TEXT_LEVEL}
    for node, text in written.items():
        ax.text(*places[node], text, color=INK, parse_math=False, **look)
    return ax


def plot_skeleton(skeleton: nx.Graph, *, ax: Axes | None = None) -> Axes:
    """Draw the corridors of `Prediction.skeleton`: known ones filled, edges as wide and dark as they are probable.

    Numbers are probabilities in %; edges below 5 % are not drawn, nor what only they lead to.

    Parameters
    ----------
    skeleton
        The `skeleton` of a `Prediction`; each node and edge has a `probability`.
    ax
        Where to draw, in lengths of the shortest edges; a new figure if None.

    Returns
    -------
    Axes
        The ax that was drawn on; nothing is shown.

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
    from matplotlib.patches import Rectangle

    ax = new_ax(ax)
    shown = _list_probable(skeleton)
    places = place_nodes(shown)
    for one, other, probability in shown.edges(data="probability"):
        width = NARROWEST + (WIDEST - NARROWEST) * probability
        xs, ys = zip(places[one], places[other], strict=True)
        color = EDGE_COLOR if probability == 1 else OPEN_COLOR
        ax.plot(xs, ys, color=color, linewidth=width, alpha=max(FAINTEST, probability), zorder=LINE_LEVEL)
    for node, probability in shown.nodes(data="probability"):
        (x, y), is_known = places[node], probability == 1
        look: dict[str, Any] = {"facecolor": CORRIDOR_COLOR if is_known else "white", "edgecolor": INK}
        look |= {"linestyle": "-" if is_known else ":", "linewidth": 0.8, "zorder": NODE_LEVEL}
        ax.add_patch(Rectangle((x - SKELETON_HALF, y - SKELETON_HALF), 2 * SKELETON_HALF, 2 * SKELETON_HALF, **look))
        name = "?" if isinstance(node, tuple) or not is_known else str(node)[:LONGEST_NAME]
        ax.text(x, y, name, ha="center", va="center_baseline", fontsize=SMALL, zorder=TEXT_LEVEL, parse_math=False)
    _number_edges(shown, places, ax=ax)
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
    sets = [(true, TRUE_COLOR, "true")] if true is not None else []
    sets += [(average, AVERAGE_COLOR, "average of the model"), (predicted, PREDICTED_COLOR, "predicted")]
    given: list[Mapping[str, float]] = [shares for shares, *_ in sets if shares is not None]
    names = list(dict.fromkeys(name for shares in given for name in shares))
    names = [name for name in names if max(shares.get(name, 0) for shares in given) >= LEAST_SHARE]
    names.sort(key=lambda name: -predicted.get(name, 0))
    width = BARS_WIDTH / len(sets)
    for number, (shares, color, told) in enumerate(sets):
        left = [place - BARS_WIDTH / 2 + (number + 0.5) * width for place in range(len(names))]
        ax.bar(left, [100 * (shares or {}).get(name, 0) for name in names], width, color=color, label=told)
    ax.set_xticks(range(len(names)), names, rotation=40, ha="right", rotation_mode="anchor", parse_math=False)
    ax.set_ylabel("% of unknown rooms", fontsize=FONT_SIZE, color=INK)
    ax.tick_params(labelsize=SMALL, colors=INK, length=0)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(frameon=False, fontsize=FONT_SIZE, labelcolor=INK)
    _add_title(ax, "labels of unknown rooms")
    return ax


def _shade(known: nx.Graph, places: Mapping[Hashable, tuple[float, float]]) -> shapely.Geometry:
    """The ground of known nodes and of the edges between them."""
    nodes = [shapely.Point(places[node]).buffer(NODE_RIM) for node in known]
    edges = [shapely.LineString([places[one], places[other]]).buffer(EDGE_RIM) for one, other in known.edges]
    return shapely.union_all([*nodes, *edges])


def _list_probable(skeleton: nx.Graph) -> nx.Graph:
    """The skeleton without improbable edges and what only they lead to."""
    shown = nx.Graph()
    shown.add_nodes_from((node, data) for node, data in skeleton.nodes(data=True) if data["probability"] == 1)
    for one, other, probability in skeleton.edges(data="probability"):
        if probability >= LEAST_PROBABILITY:
            shown.add_nodes_from((node, skeleton.nodes[node]) for node in (one, other))
            shown.add_edge(one, other, probability=probability)
    return shown


def _number_edges(shown: nx.Graph, places: Mapping[Hashable, tuple[float, float]], *, ax: Axes) -> None:
    """Write the probabilities of edges on them, the most probable ones where there are many."""
    uncertain = [edge for edge in shown.edges(data="probability") if edge[2] < 1]
    box = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}
    for one, other, probability in sorted(uncertain, key=lambda edge: -edge[2])[:MOST_NUMBERS]:
        (x, y), (further_x, further_y) = places[one], places[other]
        middle = ((x + further_x) / 2, (y + further_y) / 2)
        text = f"{100 * probability:.0f}"
        ax.text(*middle, text, ha="center", va="center", fontsize=SMALL, color=INK, bbox=box, zorder=TEXT_LEVEL)


def _add_axes(figure: Figure, box: Box) -> Axes:
    """Axes in a box of the figure, x, y, width and height in inches, inside margins and below a title."""
    width, height = figure.get_size_inches()
    x, y, wide, high = box
    return figure.add_axes(
        ((x + MARGIN) / width, (y + MARGIN) / height, (wide - 2 * MARGIN) / width, (high - TITLE - MARGIN) / height)
    )


def _add_title(ax: Axes, text: str) -> None:
    ax.set_title(text, fontsize=FONT_SIZE + 1, color=INK, pad=5)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"
