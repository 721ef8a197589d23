"""The classifier two-sample test: the accuracy of a classifier of generated and real graphs.

Lopez-Paz and Oquab, Revisiting Classifier Two-Sample Tests, 2017: for two sets from the same source, the accuracy on
held-out graphs is one half.
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

# From the indices of training graphs and of held-out graphs: whether each of the latter is predicted to be generated.
Predictor: TypeAlias = Callable[[Indices, Indices], NDArray[np.bool_]]
# The origin of each real and of each generated graph, such as the building of a floor.
Groups: TypeAlias = tuple[Sequence[Hashable], Sequence[Hashable]]

# `nodes_r` and `nodes_c` are the numbers of rooms and corridors.
STRUCTURE_METRICS: tuple[str, ...] = (
    *("nodes", "edges", "nodes_r", "nodes_c", "mean_degree", "largest_degree", "leaves", "path_length", "diameter"),
    *("art_points", "assortativity", "cycles", "transitivity"),
)
# C of the support vector machine, trees of the forest, and repeats with other generated graphs; chosen by hand.
COST = 10.0
TREES = 100
REPEATS = 10


@dataclass(frozen=True)
class TwoSampleScores:
    """Accuracies, 0 … 1, one for each repeat, with equally many real and generated graphs.

    one_out: each graph is left out alone. Its own set is then the smaller one, so a classifier that has only learnt
    which set is larger is always wrong: for equal sets, this is below one half.
    pair_out: a real and a generated graph are left out together, each graph once, so both sets have the same size; for
    equal sets this is one half. It is far below if generated graphs are copies of real ones.
    group_out: as pair_out, but trained without any graph of their groups, on equally many of both sets; empty without
    groups. Graphs of one origin resemble each other, so that by pair_out a classifier recognises the origin of a graph
    rather than its set.
    """

    one_out: tuple[float, ...]
    pair_out: tuple[float, ...]
    group_out: tuple[float, ...] = ()


def describe_structure(graph: nx.Graph, corridors: Collection[Hashable]) -> Floats:
    """STRUCTURE_METRICS of a simple undirected graph, shape (13,); 0 if undefined.

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
    groups: Groups | None = None,
) -> TwoSampleScores:
    """Scores of a support vector machine on a graph kernel, such as `NeighborhoodPairs` or `WeisfeilerLehman`.

    kernel: should be normalised, else sizes of graphs dominate. cost: C of the machine. groups: for `group_out`.
    Each repeat samples as many generated graphs as there are real ones.
    Raises GraphError for fewer than 2 real graphs, for fewer generated than real ones, for a set of one group, and as
    the kernel does.
    """
    from sklearn.base import clone
    from sklearn.svm import SVC

    # The kernel of two graphs does not depend on others, so one matrix serves all folds.
    gram = clone(kernel).fit([*real, *generated]).compare()

    def predict(training: Indices, held_out: Indices) -> NDArray[np.bool_]:
        machine = SVC(kernel="precomputed", C=cost).fit(gram[np.ix_(training, training)], training >= len(real))
        return np.asarray(machine.predict(gram[np.ix_(held_out, training)]))

    random = np.random.default_rng(seed)
    return _score(predict, len(real), len(generated), repeats=repeats, random=random, groups=groups)


def forest_two_sample_test(
    real: Floats,
    generated: Floats,
    *,
    seed: int,
    repeats: int = REPEATS,
    trees: int = TREES,
    groups: Groups | None = None,
) -> TwoSampleScores:
    """Scores of Extra-Trees on features, shapes (real, features) and (generated, features), as `describe_structure`.

    Each repeat samples as many generated graphs as there are real ones. trees: of the forest of each fold. groups: for
    `group_out`.
    Raises OptionError for arrays of other shapes, GraphError as `kernel_two_sample_test` does.
    """
    from sklearn.ensemble import ExtraTreesClassifier

    if real.ndim != 2 or real.shape[1:] != generated.shape[1:]:
        shapes = f"{real.shape} and {generated.shape}"
        raise OptionError(f"features have the shapes {shapes}, give a row for each graph, all of one length")
    features = np.concatenate([real, generated])
    random = np.random.default_rng(seed)

    def predict(training: Indices, held_out: Indices) -> NDArray[np.bool_]:
        forest = ExtraTreesClassifier(trees, random_state=int(random.integers(2**32)))
        return np.asarray(forest.fit(features[training], training >= len(real)).predict(features[held_out]))

    return _score(predict, len(real), len(generated), repeats=repeats, random=random, groups=groups)


def _score(
    predict: Predictor,
    real: int,
    generated: int,
    *,
    repeats: int,
    random: np.random.Generator,
    groups: Groups | None,
) -> TwoSampleScores:
    """Scores over repeats; graphs 0 … real - 1 are real, the rest generated."""
    if real < 2:
        raise GraphError(f"real has {real} graphs, give 2 at least")
    if generated < real:
        raise GraphError(f"generated has {generated} graphs beside {real} real ones, give as many at least")
    numbers = None if groups is None else _number_groups(groups)
    # Draws of its own, so that groups change no other score of a kernel machine.
    (group_random,) = random.spawn(1)
    one_out, pair_out, group_out = [], [], []
    for _ in range(repeats):
        pairs = np.column_stack([np.arange(real), real + random.permutation(generated)[:real]])
        one_out.append(_score_folds(predict, pairs.reshape(-1, 1), real))
        pair_out.append(_score_folds(predict, pairs, real))
        if numbers is not None:
            group_out.append(_score_groups(predict, pairs, real, numbers, group_random))
    return TwoSampleScores(tuple(one_out), tuple(pair_out), tuple(group_out))


def _score_folds(predict: Predictor, folds: Indices, real: int) -> float:
    """Accuracy, with each row of folds left out once."""
    is_correct = [predict(np.setdiff1d(folds, fold), fold) == (fold >= real) for fold in folds]
    return float(np.mean(is_correct))


def _number_groups(groups: Groups) -> Indices:
    """A number for the group of each graph, the real ones first."""
    for name, each in zip(("real", "generated"), groups, strict=True):
        if len({*each}) < 2:
            raise GraphError(f"all {name} graphs are of one group, give those of 2 at least")
    numbers = {group: number for number, group in enumerate(dict.fromkeys([*groups[0], *groups[1]]))}
    return np.array([numbers[group] for each in groups for group in each], np.intp)


def _score_groups(predict: Predictor, pairs: Indices, real: int, groups: Indices, random: np.random.Generator) -> float:
    """Accuracy, with each pair left out once, and no graph of the groups of the pair for training."""
    graphs = np.arange(len(groups))
    is_correct = []
    for pair in pairs:
        others = [side[groups[side] != groups[own]] for side, own in zip(np.split(graphs, [real]), pair, strict=True)]
        # Sets of equal size, else a classifier prefers the larger one.
        size = min(map(len, others))
        training = np.concatenate([random.permutation(side)[:size] for side in others])
        is_correct.append(predict(np.sort(training), pair) == (pair >= real))
    return float(np.mean(is_correct))
