"""Generated graphs beside real ones, as sets: are they valid, are they copies, and are their statistics the same.

Graphs are simple undirected networkx graphs with the attribute `label` at each node. The functions raise GraphError
that lists what is no such graph, and for sets that are too small.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

import networkx as nx
import numpy as np

from pianta._types import Floats, Indices
from pianta.errors import GraphError, OptionError
from pianta.graphs.labelled_graphs import LabelledGraph, read_labelled_graphs
from pianta.graphs.stable_hash import Codes, join, mix

GraphMaker: TypeAlias = Callable[[Sequence[nx.Graph], np.random.Generator], Sequence[nx.Graph]]

# Rounds of colour refinement before graphs are compared node by node.
ROUNDS = 5
CLUSTERING_EDGES = np.linspace(0, 1, 101)
# The first edge is below 0, so that 0, 1/2, 1 and 3/2, which graphs of rooms have often, are on no edge.
SPECTRUM_EDGES = np.linspace(-1e-5, 2, 201)


@dataclass(frozen=True)
class Validity:
    """Shares of the graphs, 0 … 1, that are in one part, that are planar, and whose nodes all have a known label."""

    connected: float
    planar: float
    labelled: float


class Trial(NamedTuple):
    """Real graphs in two halves at random, and as many graphs as half_a has, made without a look at half_b."""

    made: Sequence[nx.Graph]
    half_a: Sequence[nx.Graph]
    half_b: Sequence[nx.Graph]


@dataclass(frozen=True)
class DiscrepancyRatio:
    """Squared discrepancies from half B of real graphs, means over trials: of made graphs, and of half A."""

    made: float
    real: float

    @property
    def ratio(self) -> float:
        """Made / real: about 1 where made graphs are as real ones; 1 where both are 0, infinite where only real is."""
        if self.made == self.real:
            return 1.0
        return self.made / self.real if self.real > 0 else float("inf")


def measure_validity(graphs: Iterable[nx.Graph], labels: Collection[str]) -> Validity:
    """Validity of a set of graphs; a graph without nodes is not connected.

    labels: those that a node may have, such as `LabelSchema.by_name`. A node may lack a label here.
    """
    graphs = _check_graphs(graphs)
    known = frozenset(labels)
    connected = [nx.number_connected_components(graph) == 1 for graph in graphs]
    planar = [nx.check_planarity(graph)[0] for graph in graphs]
    labelled = [all(label in known for _, label in graph.nodes(data="label")) for graph in graphs]
    return Validity(*(float(np.mean(shares)) for shares in (connected, planar, labelled)))


def find_copies(graphs: Iterable[nx.Graph], known: Iterable[nx.Graph]) -> list[bool]:
    """For each graph, whether one of the known graphs is isomorphic to it, labels included: 1 - mean is novelty."""
    seen = _SeenGraphs()
    for graph in read_labelled_graphs(known, node_label="label"):
        seen.add(graph)
    return [seen.find(graph) for graph in read_labelled_graphs(graphs, node_label="label")]


def find_repeats(graphs: Iterable[nx.Graph]) -> list[bool]:
    """For each graph, whether an earlier one is isomorphic to it, labels included: 1 - mean is uniqueness."""
    seen = _SeenGraphs()
    return [seen.add(graph) for graph in read_labelled_graphs(graphs, node_label="label")]


def describe_statistic(graphs: Iterable[nx.Graph], statistic: str) -> Floats:
    """Histograms, shape (graphs, bins), each with the sum 1; zeros for a graph without nodes.

    statistic: `degree`, a bin for each of 0 … the largest degree of all graphs; `clustering`, the local clustering
    coefficients in 100 bins of 0 … 1; `spectrum`, the eigenvalues of the normalised Laplacian in 200 bins of 0 … 2;
    `labels`, a bin for each label that one of the graphs has, in the order of the alphabet.
    Rows can be compared when they come from one call. Raises OptionError for another statistic.
    """
    bins = _get_statistic(statistic).find_bins(graphs)
    count = 1 + max((int(of_graph.max(initial=-1)) for of_graph in bins), default=-1)
    counts = np.array([np.bincount(of_graph, minlength=count) for of_graph in bins], float).reshape(len(bins), count)
    sizes = counts.sum(axis=1, keepdims=True)
    shares: Floats = np.divide(counts, sizes, out=np.zeros_like(counts), where=sizes > 0)
    return shares


def measure_discrepancy(one: Sequence[nx.Graph], other: Sequence[nx.Graph], *, statistic: str) -> float:
    """Squared maximum mean discrepancy of a statistic of two sets of graphs: 0 where it is the same, at most 2.

    As of You et al., GraphRNN, 2018, with the kernel of Liao et al., GRAN, 2019: k(x, y) = exp(-d² / 2σ²), d the total
    variation distance of the histograms of two graphs (half of the sum of differences), σ = 1, for clustering 0.1;
    mean k within one set + mean k within the other - 2 mean k across. A graph is compared with itself too, as there,
    so that small sets from one source are apart by chance: see `compare_discrepancy`. The kernel is not positive
    definite: of very few graphs the discrepancy can be a little below 0.
    """
    _check_filled(one=one, other=other)
    rows = describe_statistic([*one, *other], statistic)
    return _measure_rows(rows[: len(one)], rows[len(one) :], _get_statistic(statistic).width)


def draw_trials(
    generated: Sequence[nx.Graph] | GraphMaker, real: Sequence[nx.Graph], *, repeats: int, seed: int
) -> list[Trial]:
    """Random splits of real graphs into halves A and B (of an odd number one is left out), with graphs of each.

    generated: the set that graphs are drawn from, each once in a trial; what comes from a model of all real graphs has
    seen half B too, and can be nearer to it than half A. Or a function of half A and a generator of random numbers,
    that makes graphs of a model of half A alone.
    """
    if len(real) < 2:
        raise GraphError(f"real has {len(real)} graphs, give 2 at least to have two halves")
    random = np.random.default_rng(seed)
    size = len(real) // 2
    trials = []
    for _ in range(repeats):
        order = random.permutation(len(real))
        half_a, half_b = ([real[place] for place in places] for places in (order[:size], order[size : 2 * size]))
        made = generated(half_a, random) if callable(generated) else generated
        if len(made) < size:
            raise GraphError(f"generated has {len(made)} graphs beside a half of {size}, give as many at least")
        trials.append(Trial([made[place] for place in random.permutation(len(made))[:size]], half_a, half_b))
    return trials


def compare_discrepancy(trials: Iterable[Trial], *, statistic: str) -> DiscrepancyRatio:
    """How far made graphs are from half B of real ones, beside half A, by `measure_discrepancy`.

    Made graphs and half A are equally many: what sets of this size are apart by chance is the same on both sides, and
    the ratio is 1 where graphs are made by what made the real ones, and less only where they are more of a kind.
    Raises GraphError for no trials, and for a trial with an empty part or with more or fewer made graphs than half A.
    """
    trials = [Trial(*trial) for trial in trials]
    _check_filled(trials=trials)
    for trial in trials:
        _check_filled(**trial._asdict())
        if len(trial.made) != len(trial.half_a):
            raise GraphError(f"{len(trial.made)} made graphs beside {len(trial.half_a)} of half A, give equally many")
    graphs = {id(graph): graph for trial in trials for graph in chain(*trial)}
    rows = dict(zip(graphs, describe_statistic(graphs.values(), statistic), strict=True))
    width = _get_statistic(statistic).width
    measured = []
    for trial in trials:
        made, half_a, half_b = (np.array([rows[id(graph)] for graph in part]) for part in trial)
        measured.append((_measure_rows(made, half_b, width), _measure_rows(half_a, half_b, width)))
    return DiscrepancyRatio(*(float(mean) for mean in np.mean(measured, axis=0)))


class _SeenGraphs:
    """Graphs by a fingerprint that isomorphic ones share; those that share it are compared node by node."""

    def __init__(self) -> None:
        self._by_fingerprint: dict[bytes, list[nx.Graph]] = {}

    def add(self, graph: LabelledGraph) -> bool:
        """Keep a graph; whether it was there already."""
        colors = _refine(graph)
        alike = self._by_fingerprint.setdefault(_join_colors(colors), [])
        painted = _paint(graph, colors)
        found = _has_isomorphic(painted, alike)
        if not found:
            alike.append(painted)
        return found

    def find(self, graph: LabelledGraph) -> bool:
        """Whether a graph is there."""
        colors = _refine(graph)
        alike = self._by_fingerprint.get(_join_colors(colors), [])
        return _has_isomorphic(_paint(graph, colors), alike)


def _refine(graph: LabelledGraph) -> Codes:
    """Colours of nodes, shape (n,), that an isomorphism keeps: the label, and what is up to `ROUNDS` edges around."""
    colors = graph.labels
    for number in range(ROUNDS):
        around = np.zeros_like(colors)
        np.add.at(around, graph.starts, mix(colors[graph.ends]))
        colors = join(number, colors, around)
    return colors


def _join_colors(colors: Codes) -> bytes:
    return np.sort(colors).tobytes()


def _paint(graph: LabelledGraph, colors: Codes) -> nx.Graph:
    """The graph with the text of the label and the colour of each node as its attributes."""
    painted = nx.Graph()
    nodes = zip(graph.graph.nodes(data="label"), colors.tolist(), strict=True)
    painted.add_nodes_from((node, {"label": str(label), "color": color}) for (node, label), color in nodes)
    painted.add_edges_from(graph.graph.edges)
    return painted


def _has_isomorphic(graph: nx.Graph, others: Iterable[nx.Graph]) -> bool:
    # Colours leave few nodes to try.
    same = nx.isomorphism.categorical_node_match(["label", "color"], [None, None])
    return any(nx.is_isomorphic(graph, other, node_match=same) for other in others)


def _measure_rows(one: Floats, other: Floats, width: float) -> float:
    """Squared maximum mean discrepancy of two sets of histograms with the same bins."""
    from scipy.spatial.distance import cdist

    def mean_kernel(first: Floats, second: Floats) -> float:
        distances = cdist(first, second, "cityblock") / 2
        return float(np.exp(-(distances**2) / (2 * width**2)).mean())

    return mean_kernel(one, one) + mean_kernel(other, other) - 2 * mean_kernel(one, other)


def _find_degrees(graphs: Iterable[nx.Graph]) -> list[Indices]:
    return [np.array([degree for _, degree in graph.degree()], np.intp) for graph in _check_simple(graphs)]


def _find_clustering(graphs: Iterable[nx.Graph]) -> list[Indices]:
    found = (np.array(list(nx.clustering(graph).values()), float) for graph in _check_simple(graphs))
    return [_find_places(values, CLUSTERING_EDGES) for values in found]


def _find_spectra(graphs: Iterable[nx.Graph]) -> list[Indices]:
    return [_find_places(_measure_spectrum(graph), SPECTRUM_EDGES) for graph in _check_simple(graphs)]


def _measure_spectrum(graph: nx.Graph) -> Floats:
    """Eigenvalues of the normalised Laplacian; a node without edges has 0."""
    if not len(graph):
        return np.zeros(0)
    return np.asarray(np.linalg.eigvalsh(nx.normalized_laplacian_matrix(graph, weight=None).toarray()))


def _find_labels(graphs: Iterable[nx.Graph]) -> list[Indices]:
    read = read_labelled_graphs(graphs, node_label="label")
    texts = [[str(label) for _, label in graph.graph.nodes(data="label")] for graph in read]
    places = {text: place for place, text in enumerate(sorted(set(chain(*texts))))}
    return [np.array([places[text] for text in of_graph], np.intp) for of_graph in texts]


def _find_places(values: Floats, edges: Floats) -> Indices:
    """The bin of each value; what rounding puts outside is in the first or the last."""
    return np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)


@dataclass(frozen=True)
class _Statistic:
    """find_bins: for each graph the bins that its nodes or eigenvalues are in. width: σ of the kernel."""

    find_bins: Callable[[Iterable[nx.Graph]], list[Indices]]
    width: float


_STATISTICS = MappingProxyType(
    {
        "degree": _Statistic(_find_degrees, 1.0),
        "clustering": _Statistic(_find_clustering, 0.1),
        "spectrum": _Statistic(_find_spectra, 1.0),
        "labels": _Statistic(_find_labels, 1.0),
    }
)
STATISTICS: tuple[str, ...] = tuple(_STATISTICS)


def _get_statistic(name: str) -> _Statistic:
    if name not in _STATISTICS:
        raise OptionError(f"there is no statistic {name!r}, give one of {', '.join(_STATISTICS)}")
    return _STATISTICS[name]


def _check_simple(graphs: Iterable[nx.Graph]) -> list[nx.Graph]:
    return [graph.graph for graph in read_labelled_graphs(graphs, node_label=None)]


def _check_graphs(graphs: Iterable[nx.Graph]) -> list[nx.Graph]:
    checked = _check_simple(graphs)
    _check_filled(graphs=checked)
    return checked


def _check_filled(**sets: Sequence[object]) -> None:
    """Raise GraphError for the first of the sets, by name, that is empty."""
    for name, given in sets.items():
        if not len(given):
            raise GraphError(f"{name} is empty, give 1 at least")
