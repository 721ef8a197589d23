"""How many iterations the chains of a model take to forget where they started (thesis, section 7.4.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from pianta._types import Floats
from pianta.generation.buildings import STEPS, BuildingSampler
from pianta.generation.metropolis_hastings import measure_convergence
from pianta.generation.type_model import MIXED_BELOW, Mixing, ModelMixing, TypeModel

# Chains with one target, and targets: floors of the model.
CHAINS, TARGETS = 4, 6
# Chains have mixed where R̂ of the median target is below; a chain takes so many times its iterations at most.
MOST = 4


def find_mixing(
    model: TypeModel, *, seed: int = 0, track: Callable[[Sequence[str]], Iterable[str]] = iter
) -> ModelMixing:
    """How many iterations the chains of a model take: those of the authors, which it has at first, or more.

    Chains with the same target start apart, each from another floor or graph. As long as they differ in the second half
    of their iterations more than each does in itself, R̂ being 1.1 or above, these are doubled, twice at most.
    track: wraps the names of the steps, to show progress.
    """
    runs = (_run_sweeps, model.sweeps), (_run_edge_moves, model.edge_moves), (_run_door_moves, model.door_moves)
    names = track([f"iterations of {step}" for step in STEPS])
    return ModelMixing(*(_double(*run, model, seed) for _, run in zip(names, runs, strict=True)))


def _double(runner: Callable[[BuildingSampler, int], Floats], iterations: int, model: TypeModel, seed: int) -> Mixing:
    """So many iterations, or twice, or four times, by when chains have mixed."""
    most = MOST * iterations
    while True:
        longer = replace(model, sweeps=iterations, edge_moves=iterations, door_moves=iterations)
        traces = runner(BuildingSampler(longer), seed)
        # Without a target nothing has to mix.
        found = [measure_convergence(of_target[:, iterations // 2 :]) for of_target in traces]
        convergence = float(np.median(found)) if found else 1.0
        if convergence < MIXED_BELOW or iterations >= most:
            return Mixing(iterations, convergence)
        iterations *= 2


def _run_sweeps(sampler: BuildingSampler, seed: int) -> Floats:
    """Costs of step 1, shape (1, chains, sweeps): all chains have one target, and start from floors of the model."""
    floors = sampler.model.configurations
    starts = floors[np.random.default_rng(seed).integers(len(floors), size=CHAINS * TARGETS)]
    traces: list[Floats] = []
    sampler.sample_areas(starts, _generators(seed, len(starts)), traces=traces)
    return np.array(traces).T[None]


def _run_edge_moves(sampler: BuildingSampler, seed: int) -> Floats:
    """Costs of step 2, shape (targets, chains, moves), each target the areas of a floor."""
    traces: list[Floats] = []
    chosen = [target for target in _list_targets(sampler, seed) for _ in range(CHAINS)]
    if not chosen:
        return np.zeros((0, CHAINS, 0))
    sampler.join_areas([areas for areas, _ in chosen], _generators(seed, len(chosen)), traces=traces)
    return np.array(traces).T.reshape(-1, CHAINS, len(traces))


def _run_door_moves(sampler: BuildingSampler, seed: int) -> Floats:
    """Costs of step 4, shape (targets, chains, moves), each target the areas of a floor, joined as they are."""
    traces: list[Floats] = []
    chosen = [target for target in _list_targets(sampler, seed) for _ in range(CHAINS)]
    if not chosen:
        return np.zeros((0, CHAINS, 0))
    graphs = [sampler.model.floors[place].functional_graph for _, place in chosen]
    sampler.connect_rooms([areas for areas, _ in chosen], graphs, _generators(seed, len(chosen)), traces=traces)
    return np.array(traces).T.reshape(-1, CHAINS, len(traces))


def _list_targets(sampler: BuildingSampler, seed: int) -> list[tuple[list[int], int]]:
    """Floors of two areas and more, at most TARGETS: their areas, and their places in the model."""
    ends = np.cumsum([len(floor.areas) for floor in sampler.model.floors]).tolist()
    found = [
        ([*range(end - len(floor.areas), end)], place)
        for place, (floor, end) in enumerate(zip(sampler.model.floors, ends, strict=True))
        if len(floor.areas) > 1
    ]
    order = np.random.default_rng(seed).permutation(len(found))[:TARGETS]
    return [found[place] for place in order]


def _generators(seed: int, count: int) -> list[np.random.Generator]:
    return [np.random.default_rng((seed, number)) for number in range(count)]
