"""How generated buildings differ from real ones, of the model's floors and held out: the usual scores of generators."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.evaluation.graph_sets import (
    STATISTICS,
    DiscrepancyRatio,
    GraphMaker,
    Trial,
    compare_discrepancy,
    draw_trials,
    find_copies,
    find_repeats,
    measure_validity,
)
from pianta.evaluation.two_sample import (
    TwoSampleScores,
    describe_structure,
    forest_two_sample_test,
    kernel_two_sample_test,
)
from pianta.graphs.metrics import find_corridors
from pianta.labels import LabelSchema
from pianta_bench.generation.clusters import keep_finite
from pianta_bench.harness.records import Results

NSPDK = "NSPDK SVM"
WL = "WL SVM"
FOREST = "Extra-Trees"
CLASSIFIERS = (NSPDK, WL, FOREST)
RADIUS = 2  # edges, of NSPDK; chosen by hand
DISTANCE = 4  # edges, of NSPDK; chosen by hand
ITERATIONS = 5  # of WL; its default in pianta

# Metrics; the first are shares of the graphs, 0 … 1.
NOVEL = "novel"
UNIQUE = "unique"
VALIDITY = ("connected", "planar", "labelled", NOVEL, UNIQUE)
DISCREPANCY = "discrepancy"
ACCURACY = "accuracy"
HELD_OUT_DISCREPANCY = "held-out discrepancy"
HELD_OUT_ACCURACY = "held-out accuracy"
# What a discrepancy is of: the two of a DiscrepancyRatio, and their ratio.
GENERATED = "generated"
REAL_HALF = "real"
RATIO = "ratio"
# Which graphs a classifier is tested on.
ONE_OUT = "one out"
PAIR_OUT = "pair out"
ALL_GRAPHS = "all graphs"


@dataclass(frozen=True)
class Repeats:
    """How often what depends on chance is measured.

    trials: splits of the real graphs. draws: of as many generated graphs as there are real ones, for a kernel machine;
    forest_draws: the same for forests of `trees` trees; one draw if there are several models.
    models: each of a half of the real graphs. made: buildings of each, as a multiple of a half. subsamples: of these,
    each as large as a half.
    """

    trials: int = 200
    draws: int = 10
    forest_draws: int = 3
    trees: int = 100
    models: int = 6
    made: int = 2
    subsamples: int = 50


def add_set_scores(
    results: Results,
    part: str,
    generated: Sequence[nx.Graph],
    real: Sequence[nx.Graph],
    schema: LabelSchema,
    *,
    seed: int,
    repeats: Repeats,
) -> None:
    """Append the scores of a set of graphs beside all real ones, which are as many as them or fewer."""
    results.add(part, ALL_GRAPHS, asdict(measure_validity(generated, schema.by_name)))
    copies, doubles = float(np.mean(find_copies(generated, real))), float(np.mean(find_repeats(generated)))
    results.add(part, ALL_GRAPHS, {NOVEL: 1 - copies, UNIQUE: 1 - doubles})
    trials = draw_trials(generated, real, repeats=repeats.trials, seed=seed)
    for statistic in STATISTICS:
        discrepancy = compare_discrepancy(trials, statistic=statistic)
        _add_discrepancy(results, part, ALL_GRAPHS, discrepancy, metric=DISCREPANCY, statistic=statistic)
    for classifier, scores in compare_samples(generated, real, schema, seed=seed, repeats=repeats).items():
        for left_out, shares in ((ONE_OUT, scores.one_out), (PAIR_OUT, scores.pair_out)):
            for number, share in enumerate(shares, 1):
                results.add(part, f"draw {number}", {ACCURACY: share}, classifier=classifier, left_out=left_out)


def draw_halves(make: GraphMaker, real: Sequence[nx.Graph], *, models: int, seed: int) -> list[Trial]:
    """As `draw_trials`, but with all graphs that are made, and not only as many as half A has."""
    made: list[Sequence[nx.Graph]] = []

    def remember(half: Sequence[nx.Graph], random: np.random.Generator) -> Sequence[nx.Graph]:
        made.append(make(half, random))
        return made[-1]

    trials = draw_trials(remember, real, repeats=models, seed=seed)
    return [trial._replace(generated=graphs) for trial, graphs in zip(trials, made, strict=True)]


def add_held_out(
    results: Results, part: str, halves: Sequence[Trial], schema: LabelSchema, *, seed: int, repeats: Repeats
) -> None:
    """Append the scores, beside half B, of what models of half A have made (`draw_halves`).

    A discrepancy is the mean over subsamples of a model's graphs, each as large as half A.
    """
    subsamples = [_draw_subsamples(trial, repeats.subsamples, seed) for trial in halves]
    _add_halves(results, part, subsamples, [trial.generated for trial in halves], schema, seed=seed, repeats=repeats)


def add_real_halves(
    results: Results, part: str, halves: Sequence[Trial], schema: LabelSchema, *, seed: int, repeats: Repeats
) -> None:
    """Append the scores of half A itself beside half B, about the best possible for a model that knows only half A.

    Discrepancies are of as many floors drawn from half A with replacement, as of a model that copies its floors.
    """
    redrawn = [_draw_again(trial, repeats.subsamples, seed) for trial in halves]
    _add_halves(results, part, redrawn, [trial.half_a for trial in halves], schema, seed=seed, repeats=repeats)


def pool_ratios(ratios: Sequence[DiscrepancyRatio]) -> DiscrepancyRatio:
    """The ratio of the means over models, in which a model whose halves are similar by chance has little weight."""
    return DiscrepancyRatio(
        *(float(np.mean([getattr(each, name) for each in ratios])) for name in (GENERATED, REAL_HALF))
    )


def measure_ratio_error(ratios: Sequence[DiscrepancyRatio]) -> float | None:
    """Standard error of the pooled ratio, by leaving out a model at a time (jackknife).

    None for fewer than two, and if all the halves of the others are the same.
    """
    if len(ratios) < 2:
        return None
    left_out = [pool_ratios([*ratios[:index], *ratios[index + 1 :]]).ratio for index in range(len(ratios))]
    if not np.isfinite(left_out).all():
        return None
    return float(np.sqrt(len(ratios) - 1) * np.std(left_out))


def compare_samples(
    generated: Sequence[nx.Graph], real: Sequence[nx.Graph], schema: LabelSchema, *, seed: int, repeats: Repeats
) -> Mapping[str, TwoSampleScores]:
    """The classifier two-sample tests: kernel machines on NSPDK and WL, Extra-Trees on thirteen metrics."""
    from pianta.graphs.nspdk import NeighborhoodPairs
    from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

    kernels = {NSPDK: NeighborhoodPairs(radius=RADIUS, distance=DISTANCE), WL: WeisfeilerLehman(iterations=ITERATIONS)}
    scores = {
        name: kernel_two_sample_test(real, generated, kernel, seed=seed, repeats=repeats.draws)
        for name, kernel in kernels.items()
    }
    features = (_describe(graphs, schema) for graphs in (real, generated))
    scores[FOREST] = forest_two_sample_test(*features, seed=seed, repeats=repeats.forest_draws, trees=repeats.trees)
    return scores


def _add_halves(
    results: Results,
    part: str,
    trials: Iterable[Sequence[Trial]],
    generated: Iterable[Sequence[nx.Graph]],
    schema: LabelSchema,
    *,
    seed: int,
    repeats: Repeats,
) -> None:
    """Append discrepancies and accuracies of each model. trials: of each. generated: the graphs to classify."""
    once = replace(repeats, forest_draws=1)
    for number, (of_model, graphs) in enumerate(zip(trials, generated, strict=True), 1):
        item = f"model {number}"
        for statistic in STATISTICS:
            discrepancy = compare_discrepancy(of_model, statistic=statistic)
            _add_discrepancy(results, part, item, discrepancy, metric=HELD_OUT_DISCREPANCY, statistic=statistic)
        tests = compare_samples(graphs, of_model[0].half_b, schema, seed=seed, repeats=once)
        for classifier, scores in tests.items():
            results.add(part, item, {HELD_OUT_ACCURACY: float(np.mean(scores.pair_out))}, classifier=classifier)


def _add_discrepancy(results: Results, part: str, item: str, discrepancy: DiscrepancyRatio, **fields: str) -> None:
    figures = {**asdict(discrepancy), RATIO: keep_finite(discrepancy.ratio)}
    results.add(part, item, figures, names=("side",), **fields)


def _describe(graphs: Sequence[nx.Graph], schema: LabelSchema) -> Floats:
    return np.array([describe_structure(graph, find_corridors(graph, schema)) for graph in graphs])


def _draw_again(trial: Trial, count: int, seed: int) -> list[Trial]:
    random = np.random.default_rng(seed)
    size = len(trial.half_a)
    draws = random.integers(size, size=(count, size)).tolist()
    return [trial._replace(generated=[trial.half_a[index] for index in draw]) for draw in draws]


def _draw_subsamples(trial: Trial, count: int, seed: int) -> list[Trial]:
    random = np.random.default_rng(seed)
    size = len(trial.half_a)
    draws = [random.permutation(len(trial.generated))[:size] for _ in range(count)]
    return [trial._replace(generated=[trial.generated[index] for index in draw]) for draw in draws]
