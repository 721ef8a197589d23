"""How far generated graphs are from the nearest floor of their model, and these floors from each other."""

from __future__ import annotations

from collections.abc import Sequence

import networkx as nx
import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from pianta._types import Floats
from pianta.generation.type_model import TypeModel, assign_area_clusters
from pianta_bench.harness.records import Results

# Metrics: of each graph, to its nearest floor.
EDITS = "edits"  # share of all nodes and edges of both graphs
WL_DISTANCE = "Weisfeiler-Lehman distance"  # sqrt(2 - 2 K)
STEPS = "steps of the configuration"  # areas of a cluster more or less
DISTANCES = (EDITS, WL_DISTANCE, STEPS)
SAME = "configuration of a floor"
ONE_STEP = "one step away at most"
# Rounds of labels around a node by which nodes are matched, each with a third of the weight of the one before; chosen
# by hand.
ROUNDS = 3
ROUND_WEIGHT = 1 / 3
ITERATIONS = 5  # of the Weisfeiler-Lehman kernel; its default in pianta


def add_distances(
    results: Results,
    part: str,
    graphs: Sequence[nx.Graph],
    model: TypeModel,
    *,
    buildings: Sequence[str] | None = None,
) -> None:
    """Append the distances of each graph to its nearest floor of a model, and whether its configuration is near.

    buildings: of each graph, if these are the floors of the model; floors of one building are then not compared.
    """
    floors = [floor.graph for floor in model.floors]
    apart = np.zeros((len(graphs), len(floors)), bool)
    if buildings is not None:
        apart = np.equal.outer(buildings, buildings)
    configurations = np.array([model.count_clusters(assign_area_clusters(graph, model)) for graph in graphs])
    steps = np.abs(configurations[:, None] - model.configurations).sum(axis=2)
    measured = {EDITS: measure_edits(graphs, floors), WL_DISTANCE: measure_wl_distances(graphs, floors), STEPS: steps}
    nearest = {name: np.where(apart, np.inf, distances).min(axis=1) for name, distances in measured.items()}
    for number, graph in enumerate(graphs):
        figures = {name: float(distances[number]) for name, distances in nearest.items()}
        shares = {SAME: float(figures[STEPS] == 0), ONE_STEP: float(figures[STEPS] <= 1)}
        results.add(part, str(graph.graph.get("source", number)), figures | shares)


def measure_wl_distances(graphs: Sequence[nx.Graph], floors: Sequence[nx.Graph]) -> Floats:
    """Distances sqrt(2 - 2 K), K the normalised Weisfeiler-Lehman kernel, shape (graphs, floors)."""
    from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

    similarity = WeisfeilerLehman(iterations=ITERATIONS).fit(floors).compare(graphs)
    distances: Floats = np.sqrt(np.maximum(2 - 2 * similarity, 0))
    return distances


def measure_edits(graphs: Sequence[nx.Graph], floors: Sequence[nx.Graph]) -> Floats:
    """Edits from each graph to each floor, as a share of the nodes and edges of both, shape (graphs, floors).

    An edit adds, removes or relabels a node, or adds or removes an edge. The number is an upper bound: nodes are
    matched by their labels and those around them (Riesen and Bunke, 2009), because the exact distance takes too long.
    """
    labels = sorted({str(label) for graph in (*graphs, *floors) for _, label in graph.nodes(data="label")})
    ones, others = ([_describe(graph, labels) for graph in each] for each in (graphs, floors))
    return np.array([[_count_edits(one, other) for other in others] for one in ones])


def _describe(graph: nx.Graph, labels: Sequence[str]) -> tuple[Floats, list[Floats]]:
    """The adjacency matrix, and in each round the shares of labels around nodes, shape (nodes, labels) each."""
    columns = {label: column for column, label in enumerate(labels)}
    adjacency = nx.to_numpy_array(graph, weight=None)
    around = np.zeros((len(graph), len(labels)))
    around[np.arange(len(graph)), [columns[str(label)] for _, label in graph.nodes(data="label")]] = 1
    rounds = [around]
    for _ in range(ROUNDS):
        # Sums, so that the number of neighbours counts as well.
        rounds.append(adjacency @ around)
        around = rounds[-1] / np.maximum(adjacency.sum(axis=1, keepdims=True), 1)
    return adjacency, rounds


def _count_edits(one: tuple[Floats, list[Floats]], other: tuple[Floats, list[Floats]]) -> float:
    size = max(len(one[0]), len(other[0]))
    (adjacency, rounds), (other_adjacency, other_rounds) = (
        (_pad(matrix, size, size), [_pad(around, size, around.shape[1]) for around in each])
        for matrix, each in (one, other)
    )
    gaps = [cdist(around, others, "cityblock") for around, others in zip(rounds, other_rounds, strict=True)]
    mismatch = gaps[0].clip(0, 1)
    cost = mismatch + sum(gap / 2 * ROUND_WEIGHT**number for number, gap in enumerate(gaps[1:]))
    order = linear_sum_assignment(cost)[1]
    nodes = mismatch[np.arange(size), order].sum()
    edges = np.abs(adjacency - other_adjacency[np.ix_(order, order)]).sum() / 2
    elements = sum(len(matrix) + matrix.sum() / 2 for matrix in (one[0], other[0]))
    return float((nodes + edges) / elements) if elements else 0.0


def _pad(matrix: Floats, rows: int, columns: int) -> Floats:
    """The matrix with zeros below and to the right."""
    return np.pad(matrix, ((0, rows - len(matrix)), (0, columns - matrix.shape[1])))
