"""The classifier two-sample test: how often a classifier tells generated graphs from real ones.

Lopez-Paz and Oquab, Revisiting Classifier Two-Sample Tests, 2017: of two sets from the same source a classifier, asked
about graphs that it has not seen, is right half of the time.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices
from pianta.errors import GraphError, OptionError
from pianta.graphs.metrics import measure_graph

if TYPE_CHECKING:
    from pianta.graphs.explicit_kernel import ExplicitKernel

# Of the places of seen graphs and of those left out: whether each of the latter is thought to be generated.
Guess: TypeAlias = Callable[[Indices, Indices], NDArray[np.bool_]]

# `nodes_r` and `nodes_c` are rooms and corridors.
STRUCTURE_METRICS: tuple[str, ...] = (
    *("nodes", "edges", "nodes_r", "nodes_c", "mean_degree", "largest_degree", "leaves", "path_length", "diameter"),
    *("art_points", "assortativity", "cycles", "transitivity"),
)
COST = 10.0
TREES = 100
REPEATS = 10


@dataclass(frozen=True)
class TwoSampleScores:
    """Shares of graphs that were told right, 0 … 1, one for each repeat; as many graphs are real as generated.

    one_out: each graph is left out alone. In what is left its own set is the smaller one, so that a classifier that
    has learnt nothing but which set is larger is always wrong: of sets that are the same, this is below a half.
    pair_out: a real and a generated graph are left out together, each graph once. The sets stay equally large, and
    this is a half of sets that are the same. Well below a half it is where generated graphs are copies of real ones.
    """

    one_out: tuple[float, ...]
    pair_out: tuple[float, ...]


def describe_structure(graph: nx.Graph, corridors: Collection[Hashable]) -> Floats:
    """STRUCTURE_METRICS of a simple undirected graph, shape (13,), 0 for what it does not have.

    corridors: its nodes that are CORRIDOR, such as `find_corridors` finds. Leaves are nodes with one edge; cycles are
    edges - nodes + parts; transitivity is the share of pairs of edges at a node that a third edge closes; the others
    are those of `measure_graph`.
    """
    measured = measure_graph(graph, corridors)
    degrees = np.array([degree for _, degree in graph.degree()], float)
    measured |= {
        "mean_degree": float(degrees.mean()) if degrees.size else None,
        "largest_degree": degrees.max(initial=0),
        "leaves": int((degrees == 1).sum()),
        "cycles": graph.number_of_edges() - len(graph) + nx.number_connected_components(graph),
        "transitivity": nx.transitivity(graph),
    }
    return np.array([measured[name] or 0.0 for name in STRUCTURE_METRICS])


def kernel_two_sample_test(
    real: Sequence[nx.Graph],
    generated: Sequence[nx.Graph],
    kernel: ExplicitKernel,
    *,
    seed: int,
    repeats: int = REPEATS,
    cost: float = COST,
) -> TwoSampleScores:
    """Scores of a support vector machine on a graph kernel, such as `NeighborhoodPairs` or `WeisfeilerLehman`.

    kernel: normalised, else the machine looks at the sizes of graphs first. cost: C of the machine.
    In each repeat as many generated graphs are drawn as there are real ones.
    Raises GraphError for less than 2 real graphs, for fewer generated ones, and as the kernel does.
    """
    from sklearn.base import clone
    from sklearn.svm import SVC

    # What a graph shares with another does not depend on the other graphs, so one matrix serves all parts.
    gram = clone(kernel).fit([*real, *generated]).compare()

    def guess(seen: Indices, left_out: Indices) -> NDArray[np.bool_]:
        machine = SVC(kernel="precomputed", C=cost).fit(gram[np.ix_(seen, seen)], seen >= len(real))
        return np.asarray(machine.predict(gram[np.ix_(left_out, seen)]))

    return _score(guess, len(real), len(generated), repeats=repeats, random=np.random.default_rng(seed))


def forest_two_sample_test(
    real: Floats, generated: Floats, *, seed: int, repeats: int = REPEATS, trees: int = TREES
) -> TwoSampleScores:
    """Scores of Extra-Trees on features, shapes (real, features) and (generated, features), as `describe_structure`.

    In each repeat as many generated graphs are drawn as there are real ones; `trees` grow for each part left out.
    Raises OptionError for arrays that are not of such shapes, GraphError as `kernel_two_sample_test` does.
    """
    from sklearn.ensemble import ExtraTreesClassifier

    if real.ndim != 2 or real.shape[1:] != generated.shape[1:]:
        shapes = f"{real.shape} and {generated.shape}"
        raise OptionError(f"features have the shapes {shapes}, give a row for each graph, all of one length")
    features = np.concatenate([real, generated])
    random = np.random.default_rng(seed)

    def guess(seen: Indices, left_out: Indices) -> NDArray[np.bool_]:
        forest = ExtraTreesClassifier(trees, random_state=int(random.integers(2**32)))
        return np.asarray(forest.fit(features[seen], seen >= len(real)).predict(features[left_out]))

    return _score(guess, len(real), len(generated), repeats=repeats, random=random)


def _score(guess: Guess, real: int, generated: int, *, repeats: int, random: np.random.Generator) -> TwoSampleScores:
    """Scores over repeats; places 0 … real - 1 are real graphs, those after them generated ones."""
    if real < 2:
        raise GraphError(f"real has {real} graphs, give 2 at least")
    if generated < real:
        raise GraphError(f"generated has {generated} graphs beside {real} real ones, give as many at least")
    one_out, pair_out = [], []
    for _ in range(repeats):
        pairs = np.column_stack([np.arange(real), real + random.permutation(generated)[:real]])
        one_out.append(_score_parts(guess, pairs.reshape(-1, 1), real))
        pair_out.append(_score_parts(guess, pairs, real))
    return TwoSampleScores(tuple(one_out), tuple(pair_out))


def _score_parts(guess: Guess, parts: Indices, real: int) -> float:
    """Share told right, each row of parts left out once."""
    told = [guess(np.setdiff1d(parts, left_out), left_out) == (left_out >= real) for left_out in parts]
    return float(np.mean(told))
