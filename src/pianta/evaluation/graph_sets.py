"""Comparison of sets of generated and real graphs: validity, novelty, uniqueness, and statistics.

Graphs are simple undirected networkx graphs with the attribute `label` at each node. The functions raise GraphError for
other graphs, which it lists, and for sets that are too small.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from hashlib import sha256
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
# Hexadecimal digits: two of a million graphs have the same by chance once in ten million sets.
FINGERPRINT_DIGITS = 16
# Edges of the bins of clustering coefficients and of eigenvalues.
CLUSTERING_EDGES = np.linspace(0, 1, 101)
# The first edge is below 0, so that 0, 1/2, 1 and 3/2, frequent in graphs of rooms, are not on edges.
SPECTRUM_EDGES = np.linspace(-1e-5, 2, 201)


@dataclass(frozen=True)
class Validity:
    """Shares of the graphs, 0 … 1, that are connected, that are planar, and whose nodes all have a valid label."""

    connected: float
    planar: float
    labelled: float


class Trial(NamedTuple):
    """A random split of real graphs into halves, and as many generated graphs as half_a has, independent of half_b."""

    generated: Sequence[nx.Graph]
    half_a: Sequence[nx.Graph]
    half_b: Sequence[nx.Graph]


@dataclass(frozen=True)
class DiscrepancyRatio:
    """Mean squared discrepancies from half B of real graphs, over trials: of generated graphs, and of half A."""

    generated: float
    real: float

    @property
    def ratio(self) -> float:
        """Generated / real: about 1 if generated graphs are like real ones; 1 if both are 0, infinite if real is."""
        if self.generated == self.real:
            return 1.0
        return self.generated / self.real if self.real > 0 else float("inf")


def measure_validity(graphs: Iterable[nx.Graph], labels: Collection[str]) -> Validity:
    """Validity of a set of graphs; a graph without nodes is not connected.

    labels: the valid ones, such as `LabelSchema.by_name`. Nodes without a label are accepted here.
    """
    graphs = _check_simple(graphs)
    _check_filled(graphs=graphs)
    valid = frozenset(labels)
    connected = [nx.number_connected_components(graph) == 1 for graph in graphs]
    planar = [nx.check_planarity(graph)[0] for graph in graphs]
    labelled = [all(label in valid for _, label in graph.nodes(data="label")) for graph in graphs]
    return Validity(*(float(np.mean(shares)) for shares in (connected, planar, labelled)))


def find_copies(graphs: Iterable[nx.Graph], training: Iterable[nx.Graph]) -> list[bool]:
    """For each graph, whether a training graph is isomorphic to it, labels included: 1 - mean is novelty."""
    index = _GraphIndex()
    for graph in read_labelled_graphs(training, node_label="label"):
        index.add(graph)
    return [index.find(graph) for graph in read_labelled_graphs(graphs, node_label="label")]


def find_repeats(graphs: Iterable[nx.Graph]) -> list[bool]:
    """For each graph, whether an earlier one is isomorphic to it, labels included: 1 - mean is uniqueness."""
    index = _GraphIndex()
    return [index.add(graph) for graph in read_labelled_graphs(graphs, node_label="label")]


def find_fingerprints(graphs: Iterable[nx.Graph]) -> list[str]:
    """A text for each graph that is equal for isomorphic ones, labels included, and hardly ever for others.

    It is a hash of the colours of nodes after ROUNDS rounds of colour refinement.
    """
    read = read_labelled_graphs(graphs, node_label="label")
    return [sha256(_join_colors(_refine(graph))).hexdigest()[:FINGERPRINT_DIGITS] for graph in read]


def describe_statistic(graphs: Iterable[nx.Graph], statistic: str) -> Floats:
    """Normalised histograms, shape (graphs, bins); zeros for a graph without nodes.

    statistic: `degree`, a bin for each of 0 … the largest degree of all graphs; `clustering`, the local clustering
    coefficients in 100 bins of 0 … 1; `spectrum`, the eigenvalues of the normalised Laplacian in 200 bins of 0 … 2;
    `labels`, a bin for each label of the graphs, in alphabetical order.
    Only rows of one call have the same bins. Raises OptionError for another statistic.
    """
    bins = _get_statistic(statistic).find_bins(graphs)
    count = 1 + max((int(each.max(initial=-1)) for each in bins), default=-1)
    counts = np.array([np.bincount(each, minlength=count) for each in bins], float).reshape(len(bins), count)
    sizes = counts.sum(axis=1, keepdims=True)
    shares: Floats = np.divide(counts, sizes, out=np.zeros_like(counts), where=sizes > 0)
    return shares


def measure_discrepancy(one: Sequence[nx.Graph], other: Sequence[nx.Graph], *, statistic: str) -> float:
    """Squared maximum mean discrepancy of a statistic of two sets of graphs: 0 if it is equal, at most 2.

    Defined by You et al., GraphRNN, 2018, with the kernel of Liao et al., GRAN, 2019: k(x, y) = exp(-d² / 2σ²), where d
    is the total variation distance of two histograms (half the sum of absolute differences), and σ = 1, but 0.1 for
    clustering; mean k within one set + mean k within the other - 2 mean k across. As there, a graph is also compared
    with itself, so small sets from one source differ by chance: see `compare_discrepancy`. The kernel is not positive
    definite, so for very few graphs the discrepancy can be slightly below 0.
    """
    _check_filled(one=one, other=other)
    rows = describe_statistic([*one, *other], statistic)
    return _measure_rows(rows[: len(one)], rows[len(one) :], _get_statistic(statistic).width)


def draw_trials(
    generated: Sequence[nx.Graph] | GraphMaker,
    real: Sequence[nx.Graph],
    *,
    repeats: int,
    seed: int,
    buildings: Sequence[str] | None = None,
) -> list[Trial]:
    """Random splits of real graphs into halves A and B (of an odd number one is left out), with generated graphs.

    generated: a set from which graphs are sampled, each at most once in a trial; if their model was trained on all real
    graphs, half B included, they may be nearer to B than A is. Or a function of half A and a random generator, which
    generates graphs by a model of half A alone.
    buildings: of each real graph; those of one building are in the same half. Halves may then be smaller.
    Raises GraphError for fewer than two real graphs or buildings, and for too few generated graphs.
    """
    if len(real) < 2:
        raise GraphError(f"real has {len(real)} graphs, give 2 at least to have two halves")
    if buildings is not None and len(set(buildings)) < 2:
        raise GraphError(f"all {len(real)} real graphs are of building {buildings[0]}, give those of 2 at least")
    random = np.random.default_rng(seed)
    size = len(real) // 2
    trials = []
    for _ in range(repeats):
        order = random.permutation(len(real))
        one, other = (order[:size], order[size : 2 * size]) if buildings is None else _split(order, buildings)
        half_a, half_b = [real[i] for i in one], [real[i] for i in other]
        graphs = generated(half_a, random) if callable(generated) else generated
        if len(graphs) < len(half_a):
            raise GraphError(
                f"generated has {len(graphs)} graphs beside a half of {len(half_a)}, give as many at least"
            )
        trials.append(Trial([graphs[i] for i in random.permutation(len(graphs))[: len(half_a)]], half_a, half_b))
    return trials


def _split(order: Indices, buildings: Sequence[str]) -> tuple[list[int], list[int]]:
    """Halves of equal size of shuffled graphs, those of one building in the same half."""
    groups: dict[str, list[int]] = {}
    for index in order.tolist():
        groups.setdefault(buildings[index], []).append(index)
    halves: tuple[list[int], list[int]] = ([], [])
    for group in groups.values():
        min(halves, key=len).extend(group)
    size = min(map(len, halves))
    return halves[0][:size], halves[1][:size]


def compare_discrepancy(trials: Iterable[Trial], *, statistic: str) -> DiscrepancyRatio:
    """The discrepancy of generated graphs from half B of real ones, and that of half A, by `measure_discrepancy`.

    Generated graphs and half A have the same number, so chance has the same effect on both. The ratio is 1 if the
    generated graphs have the distribution of the real ones, and less only if they are less diverse.
    Raises GraphError for no trials, and for a trial with an empty part or with more or fewer generated graphs than
    half A.
    """
    trials = [Trial(*trial) for trial in trials]
    _check_filled(trials=trials)
    for trial in trials:
        _check_filled(**trial._asdict())
        generated, half = len(trial.generated), len(trial.half_a)
        if generated != half:
            raise GraphError(f"{generated} generated graphs beside {half} of half A, give equally many")
    graphs = {id(graph): graph for trial in trials for graph in chain(*trial)}
    rows = dict(zip(graphs, describe_statistic(graphs.values(), statistic), strict=True))
    width = _get_statistic(statistic).width
    measured = []
    for trial in trials:
        generated_rows, half_a, half_b = (np.array([rows[id(graph)] for graph in part]) for part in trial)
        measured.append((_measure_rows(generated_rows, half_b, width), _measure_rows(half_a, half_b, width)))
    return DiscrepancyRatio(*(float(mean) for mean in np.mean(measured, axis=0)))


class _GraphIndex:
    """Graphs by a fingerprint that is equal for isomorphic ones; those with equal ones are compared node by node."""

    def __init__(self) -> None:
        self._by_fingerprint: dict[bytes, list[nx.Graph]] = {}

    def add(self, graph: LabelledGraph) -> bool:
        """Add a graph; returns whether an isomorphic one was there already."""
        colors = _refine(graph)
        candidates = self._by_fingerprint.setdefault(_join_colors(colors), [])
        colored = _color_nodes(graph, colors)
        is_repeated = _has_isomorphic(colored, candidates)
        if not is_repeated:
            candidates.append(colored)
        return is_repeated

    def find(self, graph: LabelledGraph) -> bool:
        """Whether an isomorphic graph is there."""
        colors = _refine(graph)
        candidates = self._by_fingerprint.get(_join_colors(colors), [])
        return _has_isomorphic(_color_nodes(graph, colors), candidates)


def _refine(graph: LabelledGraph) -> Codes:
    """Colours of nodes that isomorphisms preserve, shape (n,): hashes of the labels within `ROUNDS` edges."""
    colors = graph.labels
    for number in range(ROUNDS):
        around = np.zeros_like(colors)
        np.add.at(around, graph.starts, mix(colors[graph.ends]))
        colors = join(number, colors, around)
    return colors


def _join_colors(colors: Codes) -> bytes:
    return np.sort(colors).tobytes()


def _color_nodes(graph: LabelledGraph, colors: Codes) -> nx.Graph:
    """A copy of the graph with the text of the label and the colour as node attributes."""
    copy = nx.Graph()
    nodes = zip(graph.graph.nodes(data="label"), colors.tolist(), strict=True)
    copy.add_nodes_from((node, {"label": str(label), "color": color}) for (node, label), color in nodes)
    copy.add_edges_from(graph.graph.edges)
    return copy


def _has_isomorphic(graph: nx.Graph, others: Iterable[nx.Graph]) -> bool:
    # Colours leave few pairs of nodes to try.
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
    coefficients = (np.array(list(nx.clustering(graph).values()), float) for graph in _check_simple(graphs))
    return [_find_bins(values, CLUSTERING_EDGES) for values in coefficients]


def _find_spectra(graphs: Iterable[nx.Graph]) -> list[Indices]:
    return [_find_bins(_measure_spectrum(graph), SPECTRUM_EDGES) for graph in _check_simple(graphs)]


def _measure_spectrum(graph: nx.Graph) -> Floats:
    """Eigenvalues of the normalised Laplacian; a node without edges has 0."""
    if not len(graph):
        return np.zeros(0)
    return np.asarray(np.linalg.eigvalsh(nx.normalized_laplacian_matrix(graph, weight=None).toarray()))


def _find_labels(graphs: Iterable[nx.Graph]) -> list[Indices]:
    read = read_labelled_graphs(graphs, node_label="label")
    texts = [[str(label) for _, label in graph.graph.nodes(data="label")] for graph in read]
    indices = {text: index for index, text in enumerate(sorted(set(chain(*texts))))}
    return [np.array([indices[text] for text in each], np.intp) for each in texts]


def _find_bins(values: Floats, edges: Floats) -> Indices:
    """The bin of each value; values outside, by rounding, are in the first or the last."""
    return np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)


@dataclass(frozen=True)
class _Statistic:
    """find_bins: for each graph, the bins of its nodes or eigenvalues. width: σ of the kernel."""

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


def _check_filled(**sets: Sequence[object]) -> None:
    """Raise GraphError for the first of the sets, by name, that is empty."""
    for name, graphs in sets.items():
        if not len(graphs):
            raise GraphError(f"{name} is empty, give 1 at least")
