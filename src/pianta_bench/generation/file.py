"""The file of a GenerationBench: every figure, and the graph, model or floor that it belongs to."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from pianta.evaluation.graph_sets import DiscrepancyRatio
from pianta_bench.generation.measure import GenerationBench, JudgedModel
from pianta_bench.generation.scores import HeldOutScores, SetScores
from pianta_bench.generation.tables import MetricGap, compare_metrics, keep_finite, tabulate_generation
from pianta_bench.harness.comparison import save_comparisons


def save_generation(bench: GenerationBench, path: str | Path) -> None:
    """Write every figure as JSON; raises PiantaError when it cannot be written."""
    more = {
        "seed": bench.seed,
        "count": bench.count,
        "effort": asdict(bench.effort),
        "gaps": {part: [_gap_as_json(gap) for gap in compare_metrics(bench, part)] for part in bench.scores},
        "scores": {part: _scores_as_json(scores) for part, scores in bench.scores.items()},
        "models": {part: _model_as_json(judged) for part, judged in bench.models.items()},
        "real_halves": _held_out_as_json(bench.real_halves),
    }
    save_comparisons("generation", tabulate_generation(bench), bench.items, path, more=more)


def _gap_as_json(gap: MetricGap) -> dict[str, object]:
    return {**asdict(gap), "nearer": gap.is_nearer, "alike": gap.is_alike}


def _ratio_as_json(ratio: DiscrepancyRatio) -> dict[str, object]:
    return {**asdict(ratio), "ratio": keep_finite(ratio.ratio)}


def _scores_as_json(scores: SetScores) -> dict[str, object]:
    return {
        **asdict(scores.validity),
        "novel": scores.novel,
        "unique": scores.unique,
        "discrepancies": {name: _ratio_as_json(ratio) for name, ratio in scores.discrepancies.items()},
        "told": {name: asdict(told) for name, told in scores.told.items()},
    }


def _model_as_json(judged: JudgedModel) -> dict[str, object]:
    clusters = judged.clusters
    return {
        "mixing": {
            step: {"iterations": found["iterations"], "convergence": keep_finite(found["convergence"])}
            for step, found in (asdict(judged.mixing) if judged.mixing else {}).items()
        },
        "training_seconds": judged.training,
        "learning_seconds": judged.learning,
        "sampling": asdict(judged.sampling),
        "clusters": [
            {
                "areas": int(size),
                "intra": keep_finite(intra),
                "inter": keep_finite(inter),
                "similarity": similarity.tolist(),
            }
            for size, intra, inter, similarity in zip(
                clusters.sizes, clusters.intra, clusters.inter, clusters.similarity, strict=True
            )
        ],
        "clusters_by_wl": judged.clusters_by_wl,
        "areas": [
            {"floor": floor.source, "rooms": len(area), "cluster": int(cluster)}
            for floor in judged.model.floors
            for area, cluster in zip(floor.areas, floor.clusters, strict=True)
        ],
        "held_out": _held_out_as_json(judged.held_out),
    }


def _held_out_as_json(scores: HeldOutScores) -> dict[str, object]:
    return {
        "discrepancies": {name: list(map(_ratio_as_json, of)) for name, of in scores.discrepancies.items()},
        "told": {name: list(shares) for name, shares in scores.told.items()},
    }
