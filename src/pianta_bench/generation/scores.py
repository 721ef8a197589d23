"""How generated buildings differ from real ones, of the model's floors and held out: the usual scores of generators."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass

import networkx as nx
import numpy as np

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
    Groups,
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

# Metrics of records.
VALIDITY = ("connected", "planar", "labelled", "novel", "unique")  # shares of the graphs, 0 … 1
DISCREPANCY = "discrepancy"  # by `statistic` and `side`: generated, real, or their ratio
ACCURACY = "accuracy"  # by `classifier` and `left_out`, 0 … 1
HELD_OUT_DISCREPANCY = "held-out discrepancy"
HELD_OUT_ACCURACY = "held-out accuracy"  # by `classifier` and `left_out`, 0 … 1
PAIR = "a pair"
SIBLINGS = "and siblings"
BUILDING = "building"  # attribute of a graph: the building of a real floor, or of the floor that a new one follows


@dataclass(frozen=True)
class Repeats:
    """How often what depends on chance is measured.

    trials: splits of the real graphs. draws: of as many generated graphs as there are real ones, for a kernel machine;
    forest_draws: the same for forests of `trees` trees; one draw if there are several models.
    models: each of a half of the real graphs. multiple: buildings of each, as a multiple of a half.
    subsamples: of these buildings, each as large as a half.
    """

    trials: int = 200
    draws: int = 10
    forest_draws: int = 3
    trees: int = 100
    models: int = 6
    multiple: int = 2
    subsamples: int = 50


@dataclass(frozen=True)
class SetScorer:
    """Appends the scores of sets of graphs of a building type to the results of a bench.

    schema: the labels of the type. seed: of all that is random.
    """

    results: Results
    repeats: Repeats
    schema: LabelSchema
    seed: int = 0

    def score_set(self, part: str, generated: Sequence[nx.Graph], real: Sequence[nx.Graph]) -> None:
        """Scores of a set of graphs beside all real ones, which are as many or fewer."""
        item = "all graphs"
        self.results.add(part, item, asdict(measure_validity(generated, self.schema.by_name)))
        copies, repeated = float(np.mean(find_copies(generated, real))), float(np.mean(find_repeats(generated)))
        self.results.add(part, item, {"novel": 1 - copies, "unique": 1 - repeated})
        trials = draw_trials(generated, real, repeats=self.repeats.trials, seed=self.seed)
        self._add_discrepancies(part, item, trials, DISCREPANCY)
        for classifier, scores in self.compare_samples(generated, real, self.repeats.forest_draws).items():
            for left_out, shares in (("one out", scores.one_out), ("pair out", scores.pair_out)):
                for number, share in enumerate(shares, 1):
                    self.results.add(
                        part, f"draw {number}", {ACCURACY: share}, classifier=classifier, left_out=left_out
                    )

    def score_held_out(self, part: str, halves: Iterable[Trial]) -> None:
        """Scores, beside half B, of what models of half A have made (`draw_halves`).

        A discrepancy is the mean over subsamples of a model's graphs, each as large as half A.
        """
        for number, trial in enumerate(halves, 1):
            random, size = np.random.default_rng(self.seed), len(trial.half_a)
            draws = [random.permutation(len(trial.generated))[:size] for _ in range(self.repeats.subsamples)]
            self._score_half(part, f"model {number}", trial.generated, draws, trial)

    def score_real_halves(self, part: str, halves: Iterable[Trial], *, copies: int = 1) -> None:
        """Scores of half A itself beside half B, about the best possible for a model that knows only half A.

        copies: of each floor, as of a model that makes several buildings of each.
        Discrepancies are of as many floors drawn from half A with replacement, as of a model that copies its floors.
        """
        for number, trial in enumerate(halves, 1):
            random, size = np.random.default_rng(self.seed), len(trial.half_a)
            draws = random.integers(size, size=(self.repeats.subsamples, size))
            self._score_half(part, f"model {number}", [*trial.half_a] * copies, draws, trial)

    def compare_samples(
        self, generated: Sequence[nx.Graph], real: Sequence[nx.Graph], forest_draws: int, groups: Groups | None = None
    ) -> Mapping[str, TwoSampleScores]:
        """The classifier two-sample tests: kernel machines on NSPDK and WL, Extra-Trees on thirteen metrics.

        groups: of real and of generated graphs, for `TwoSampleScores.group_out`.
        """
        from pianta.graphs.nspdk import NeighborhoodPairs
        from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

        seed, repeats = self.seed, self.repeats
        kernels = {
            NSPDK: NeighborhoodPairs(radius=RADIUS, distance=DISTANCE),
            WL: WeisfeilerLehman(iterations=ITERATIONS),
        }
        scores = {
            name: kernel_two_sample_test(real, generated, kernel, seed=seed, repeats=repeats.draws, groups=groups)
            for name, kernel in kernels.items()
        }
        features = (
            np.array([describe_structure(graph, find_corridors(graph, self.schema)) for graph in graphs])
            for graphs in (real, generated)
        )
        scores[FOREST] = forest_two_sample_test(
            *features, seed=seed, repeats=forest_draws, trees=repeats.trees, groups=groups
        )
        return scores

    def _score_half(
        self, part: str, item: str, graphs: Sequence[nx.Graph], draws: Iterable[Iterable[int]], trial: Trial
    ) -> None:
        """Discrepancies of draws of the graphs, and accuracies on all of them, both beside half B."""
        trials = [trial._replace(generated=[graphs[index] for index in draw]) for draw in draws]
        self._add_discrepancies(part, item, trials, HELD_OUT_DISCREPANCY)
        groups = _find_groups(trial.half_b, graphs)
        for classifier, scores in self.compare_samples(graphs, trial.half_b, 1, groups).items():
            for left_out, shares in ((PAIR, scores.pair_out), (SIBLINGS, scores.group_out)):
                figures = {HELD_OUT_ACCURACY: float(np.mean(shares))} if shares else {}
                self.results.add(part, item, figures, classifier=classifier, left_out=left_out)

    def _add_discrepancies(self, part: str, item: str, trials: Sequence[Trial], metric: str) -> None:
        for statistic in STATISTICS:
            discrepancy = compare_discrepancy(trials, statistic=statistic)
            figures = {**asdict(discrepancy), "ratio": keep_finite(discrepancy.ratio)}
            self.results.add(part, item, figures, names=("side",), metric=metric, statistic=statistic)


def _find_groups(real: Sequence[nx.Graph], generated: Sequence[nx.Graph]) -> Groups | None:
    """The buildings of real and of generated graphs; None if some have none, or if those of a set are of one."""
    one, other = ([graph.graph.get(BUILDING) for graph in graphs] for graphs in (real, generated))
    return None if any(None in each or len({*each}) < 2 for each in (one, other)) else (one, other)


def draw_halves(
    make: GraphMaker,
    real: Sequence[nx.Graph],
    *,
    models: int,
    seed: int,
    buildings: Sequence[str] | None = None,
) -> list[Trial]:
    """As `draw_trials`, but with all graphs that are made, and not only as many as half A has."""
    sets: list[Sequence[nx.Graph]] = []

    def remember(half: Sequence[nx.Graph], random: np.random.Generator) -> Sequence[nx.Graph]:
        sets.append(make(half, random))
        return sets[-1]

    trials = draw_trials(remember, real, repeats=models, seed=seed, buildings=buildings)
    return [trial._replace(generated=graphs) for trial, graphs in zip(trials, sets, strict=True)]


def pool_ratios(ratios: Sequence[DiscrepancyRatio]) -> DiscrepancyRatio:
    """The ratio of the means over models, in which a model whose halves are similar by chance has little weight."""
    return DiscrepancyRatio(
        *(float(np.mean([getattr(each, name) for each in ratios])) for name in ("generated", "real"))
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
