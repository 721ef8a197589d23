"""The file of a PlanBench: every figure of every plan, what kind it is, and where its scale is from."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from pianta_bench.harness.comparison import save_comparisons
from pianta_bench.plans.measure import PlanBench
from pianta_bench.plans.scores import COLUMNS
from pianta_bench.plans.tables import is_sound, tabulate_plans


def save_plans(bench: PlanBench, path: str | Path) -> None:
    """Write every figure as JSON; raises PiantaError when it cannot be written."""
    plans = [
        {
            "set": of,
            "plan": result.name,
            "kind": result.kind,
            "building_type": result.building_type,
            "draws_doors": result.draws_doors,
            "counts_for_bars": is_sound(result),
            "defects": result.defects,
            "truth_failure": result.truth_failure,
            "scales": {**result.scales},
        }
        for of, results in bench.results.items()
        for result in results
    ]
    text = None if bench.text is None else asdict(bench.text)
    more = {
        "units": {column.key: column.unit for column in COLUMNS},
        "with_text": bench.with_text,
        "plans": plans,
        "text": text,
    }
    save_comparisons("plans", tabulate_plans(bench), bench.items, path, more=more)
