"""How generated buildings differ from real ones, seen by the model or held out: what the field asks of generators."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.evaluation.graph_sets import (
    STATISTICS,
    DiscrepancyRatio,
    GraphMaker,
    Trial,
    Validity,
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

NSPDK, WL, FOREST = CLASSIFIERS = ("NSPDK SVM", "WL SVM", "Extra-Trees")
# Radius and distance of NSPDK, rounds of WL.
RADIUS, DISTANCE, ITERATIONS = 2, 4, 5


@dataclass(frozen=True)
class Effort:
    """How often what depends on chance is measured.

    trials: splits of the real graphs. draws: of as many generated graphs as there are real ones, for a machine on a
    kernel, forest_draws for forests of so many trees, one draw where there are several models.
    models: each of a half of the real graphs. made: buildings of each, in times of a half. subsamples: of these, each
    as large as a half.
    """

    trials: int = 200
    draws: int = 10
    forest_draws: int = 3
    trees: int = 100
    models: int = 6
    made: int = 2
    subsamples: int = 50


@dataclass(frozen=True)
class SetScores:
    """Of generated graphs beside all real ones.

    novel, unique: shares, 0 … 1, that are no copy of a real one, of an earlier one. discrepancies: by statistic.
    told: by classifier, how often it tells generated graphs from real ones.
    """

    validity: Validity
    novel: float
    unique: float
    discrepancies: Mapping[str, DiscrepancyRatio]
    told: Mapping[str, TwoSampleScores]


@dataclass(frozen=True)
class HeldOutScores:
    """Of graphs made by models of half A beside half B, a figure for each model.

    discrepancies: by statistic. told: by classifier, shares told right when a graph of each side is left out.
    """

    discrepancies: Mapping[str, tuple[DiscrepancyRatio, ...]]
    told: Mapping[str, tuple[float, ...]]


def score_set(
    generated: Sequence[nx.Graph], real: Sequence[nx.Graph], schema: LabelSchema, *, seed: int, effort: Effort
) -> SetScores:
    """Scores of a set of graphs, at least as many as there are real ones."""
    trials = draw_trials(generated, real, repeats=effort.trials, seed=seed)
    return SetScores(
        measure_validity(generated, schema.by_name),
        1 - float(np.mean(find_copies(generated, real))),
        1 - float(np.mean(find_repeats(generated))),
        {name: compare_discrepancy(trials, statistic=name) for name in STATISTICS},
        tell_apart(generated, real, schema, seed=seed, effort=effort),
    )


def draw_halves(make: GraphMaker, real: Sequence[nx.Graph], *, models: int, seed: int) -> list[Trial]:
    """As `draw_trials`, with all graphs that are made in the place of as many as half A has."""
    made: list[Sequence[nx.Graph]] = []

    def remember(half: Sequence[nx.Graph], random: np.random.Generator) -> Sequence[nx.Graph]:
        made.append(make(half, random))
        return made[-1]

    trials = draw_trials(remember, real, repeats=models, seed=seed)
    return [trial._replace(generated=graphs) for trial, graphs in zip(trials, made, strict=True)]


def score_held_out(halves: Sequence[Trial], schema: LabelSchema, *, seed: int, effort: Effort) -> HeldOutScores:
    """Scores of what models of half A have made: `draw_halves` gives it.

    A discrepancy is the mean over subsamples of a model's graphs, each as large as half A.
    """
    discrepancies: dict[str, tuple[DiscrepancyRatio, ...]] = {}
    subsamples = [_draw_subsamples(trial, effort.subsamples, seed) for trial in halves]
    for name in STATISTICS:
        discrepancies[name] = tuple(compare_discrepancy(trials, statistic=name) for trials in subsamples)
    told = tell_halves([(trial.generated, trial.half_b) for trial in halves], schema, seed=seed, effort=effort)
    return HeldOutScores(discrepancies, told)


def score_halves(halves: Sequence[Trial], schema: LabelSchema, *, seed: int, effort: Effort) -> HeldOutScores:
    """What half A itself scores beside half B, about the best that one who knows only half A can hope for.

    Discrepancies are of as many floors drawn from half A, some more than once: of one that knows all of A by heart.
    """
    redrawn = [_draw_again(trial, effort.subsamples, seed) for trial in halves]
    discrepancies = {
        name: tuple(compare_discrepancy(trials, statistic=name) for trials in redrawn) for name in STATISTICS
    }
    told = tell_halves([(trial.half_a, trial.half_b) for trial in halves], schema, seed=seed, effort=effort)
    return HeldOutScores(discrepancies, told)


def tell_halves(
    pairs: Iterable[tuple[Sequence[nx.Graph], Sequence[nx.Graph]]], schema: LabelSchema, *, seed: int, effort: Effort
) -> dict[str, tuple[float, ...]]:
    """By classifier, the share told right of each pair of made graphs and half B when one of each side is left out."""
    once = replace(effort, forest_draws=1)
    told = [tell_apart(made, half_b, schema, seed=seed, effort=once) for made, half_b in pairs]
    return {name: tuple(float(np.mean(of[name].pair_out)) for of in told) for name in CLASSIFIERS}


def pool_ratios(ratios: Sequence[DiscrepancyRatio]) -> DiscrepancyRatio:
    """The ratio of the means over models, which a model whose two halves are near by chance does not rule."""
    return DiscrepancyRatio(
        *(float(np.mean([getattr(each, name) for each in ratios])) for name in ("generated", "real"))
    )


def measure_ratio_error(ratios: Sequence[DiscrepancyRatio]) -> float | None:
    """Standard error of the pooled ratio, by leaving out a model at a time (jackknife).

    None for fewer than two, and where all the halves of the others are the same.
    """
    if len(ratios) < 2:
        return None
    left_out = [pool_ratios([*ratios[:place], *ratios[place + 1 :]]).ratio for place in range(len(ratios))]
    if not np.isfinite(left_out).all():
        return None
    return float(np.sqrt(len(ratios) - 1) * np.std(left_out))


def tell_apart(
    generated: Sequence[nx.Graph], real: Sequence[nx.Graph], schema: LabelSchema, *, seed: int, effort: Effort
) -> Mapping[str, TwoSampleScores]:
    """The classifier two-sample tests: machines on NSPDK and WL, Extra-Trees on thirteen metrics."""
    from pianta.graphs.nspdk import NeighborhoodPairs
    from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

    kernels = {NSPDK: NeighborhoodPairs(radius=RADIUS, distance=DISTANCE), WL: WeisfeilerLehman(iterations=ITERATIONS)}
    told = {
        name: kernel_two_sample_test(real, generated, kernel, seed=seed, repeats=effort.draws)
        for name, kernel in kernels.items()
    }
    features = (_describe(graphs, schema) for graphs in (real, generated))
    told[FOREST] = forest_two_sample_test(*features, seed=seed, repeats=effort.forest_draws, trees=effort.trees)
    return told


def _describe(graphs: Sequence[nx.Graph], schema: LabelSchema) -> NDArray[np.float64]:
    return np.array([describe_structure(graph, find_corridors(graph, schema)) for graph in graphs])


def _draw_again(trial: Trial, count: int, seed: int) -> list[Trial]:
    random = np.random.default_rng(seed)
    size = len(trial.half_a)
    places = random.integers(size, size=(count, size)).tolist()
    return [trial._replace(generated=[trial.half_a[place] for place in row]) for row in places]


def _draw_subsamples(trial: Trial, count: int, seed: int) -> list[Trial]:
    random = np.random.default_rng(seed)
    size = len(trial.half_a)
    orders = [random.permutation(len(trial.generated))[:size] for _ in range(count)]
    return [trial._replace(generated=[trial.generated[place] for place in order]) for order in orders]
