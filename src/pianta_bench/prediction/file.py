"""The file of a PredictionBench: every figure, and the floor, stage or door that it belongs to."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from pianta_bench.harness.comparison import save_comparisons
from pianta_bench.prediction.measure import PredictionBench, TypeOfFloors
from pianta_bench.prediction.tables import tabulate_prediction


def save_prediction(bench: PredictionBench, path: str | Path) -> None:
    """Write every figure as JSON; raises PiantaError when it cannot be written."""
    more = {
        "seed": bench.seed,
        "count": bench.count,
        "types": {kind: _type_as_json(of) for kind, of in bench.types.items()},
    }
    save_comparisons("prediction", tabulate_prediction(bench), bench.items, path, more=more)


def _type_as_json(of: TypeOfFloors) -> dict[str, object]:
    seconds = zip(of.floors, of.learning_seconds, of.sampler_seconds, strict=True)
    return {
        "floors": [
            {"floor": floor.source, "learning_seconds": learning, "sampler_seconds": sampler}
            for floor, learning, sampler in seconds
        ],
        "doors": [
            {"floor": floor.source, "corridors": stage.corridors, **asdict(guess)}
            for floor in of.floors
            for stage in floor.stages
            for guess in stage.guesses
        ],
    }
