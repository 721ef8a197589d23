"""The file of an ExplorationBench: every run, its building, start and policy, and what was left out."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from pianta_bench.exploration.measure import ExplorationBench
from pianta_bench.exploration.runs import SHARES, BuildingRuns
from pianta_bench.exploration.scores import pair_searches, pair_share
from pianta_bench.exploration.tables import tabulate_exploration
from pianta_bench.harness.comparison import save_comparisons


def save_exploration(bench: ExplorationBench, path: str | Path) -> None:
    """Write every figure as JSON; raises PiantaError when it cannot be written."""
    policies = bench.settings.policies
    more = {
        "settings": asdict(bench.settings),
        "scans": asdict(bench.scans),
        "left_out": {
            kind: {f"{share:g}": pair_share(results, policies, share).left_out for share in SHARES}
            | {"searches": pair_searches(results, policies).left_out}
            for kind, results in bench.results.items()
        },
        "unmodelled": {kind: {row.item: row.failure for row in of.unmodelled} for kind, of in bench.sets.items()},
        "runs": [run for results in bench.results.values() for result in results for run in list_runs(result)],
    }
    save_comparisons("exploration", tabulate_exploration(bench), bench.items, path, more=more)


def list_runs(result: BuildingRuns) -> list[dict[str, object]]:
    """The runs of a building, with what they are of. start: x, y, metres."""
    return [
        {
            "set": result.kind,
            "building": result.name,
            "start": result.points[run.start],
            "policy": run.policy,
            "label": run.label,
            "outcome": run.outcome,
            "failure": run.row.failure,
            "figures": {**run.row.figures},
        }
        for run in result.runs
    ]
