"""Whether the chains of a model have mixed: R̂ of every target of every step (thesis, section 7.4.2)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType

from pianta.generation.train import MAX_FACTOR, TARGETS
from pianta.generation.type_model import MIXED_BELOW, Mixing, ModelMixing
from pianta_bench.generation.clusters import keep_finite
from pianta_bench.harness.records import Results
from pianta_bench.harness.tables import Cell, Table

# By field of ModelMixing the step.
STEPS: Mapping[str, str] = MappingProxyType({"sweeps": "step 1", "edge_moves": "step 2", "door_moves": "step 4"})
ITERATIONS = "iterations"
HIGHEST = "highest R̂"
R_HATS = tuple(f"R̂ of target {number}" for number in range(1, TARGETS + 1))

TABLE = Table(
    title="Section 7.4.2, convergence of chains",
    rows=("metric",),
    columns=("part", "step"),
    where={"metric": [ITERATIONS, *R_HATS, HIGHEST], "step": list(STEPS.values())},
    summarise=Cell.only,
    digits=3,
    notes=(
        "R̂: of the second half of the iterations of all chains with one target, which",
        "is the areas of a floor, and in step 1 the density. Iterations are doubled until",
        f"all targets are below {MIXED_BELOW}, to {MAX_FACTOR} times the authors' at most.",
        "{stopped}",
    ),
)


def add_mixing(results: Results, part: str, item: str, mixing: ModelMixing) -> None:
    """Append the records of all steps of a model: its iterations, and R̂ of each target."""
    for name, step in STEPS.items():
        chains: Mixing = getattr(mixing, name)
        figures = dict(zip(R_HATS, map(keep_finite, chains.targets), strict=False))
        highest = {HIGHEST: keep_finite(chains.convergence)}
        results.add(part, item, {ITERATIONS: chains.iterations, **figures, **highest}, step=step)


def describe_stops(models: Mapping[str, ModelMixing | None]) -> str:
    """Which steps of models were stopped by the limit of iterations before their chains had mixed."""
    return "\n".join(_list_stops(models)) or "No step was stopped there."


def _list_stops(models: Mapping[str, ModelMixing | None]) -> Iterator[str]:
    for part, mixing in models.items():
        for name, step in STEPS.items() if mixing else ():
            chains: Mixing = getattr(mixing, name)
            if not chains.has_mixed:
                high = sum(target >= MIXED_BELOW for target in chains.targets)
                yield f"Stopped there: {step}, {part}; {high} of {len(chains.targets)} targets at R̂ 1.1 or above."
