"""Train a model of a building type on labelled floors: the function behind the verb `pianta train type`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.errors import LabelError, ModelError, OptionError
from pianta.floor import Floor
from pianta.generation.buildings import STEPS, BuildingSampler
from pianta.generation.functional_areas import Segmentation
from pianta.generation.metropolis_hastings import measure_convergence
from pianta.generation.room_shapes import describe_shapes
from pianta.generation.type_model import Mixing, ModelMixing, TypeModel, learn_type
from pianta.io._files import short_repr
from pianta.labels import ALL_SCHEMAS, LabelSchema

# Chains for each target. All three values were chosen by hand.
CHAINS = 4
# Targets: floors of the model.
TARGETS = 6
# Upper limit of the iterations, relative to those of the authors.
MAX_FACTOR = 4


def train_type(
    floors: Sequence[Floor | nx.Graph],
    *,
    schema: LabelSchema | None = None,
    areas: str = "corr",
    seed: int = 0,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> TypeModel:
    """Train a model of one type of buildings on labelled floors, to generate and predict such buildings.

    The command `pianta train type` calls this function.

    Parameters
    ----------
    floors
        At least two floors, better dozens, of one type; or their graphs. Each room has a label of the schema.
    schema
        The labels of the type; None for the built-in schema of the type of the floors.
    areas
        How floors are divided into functional areas: "corr", by corridors, or "ncut", by normalised cuts (section
        7.3.1).
    seed
        Seed of the chains that measure the iterations.
    track
        Wraps the names of the steps, to show progress.

    Returns
    -------
    TypeModel
        `model.save(path)` writes it; `model.mixing` has the iterations of its chains, and their R-hat.

    Raises
    ------
    ModelError
        Fewer than two floors, or floors of several types.
    LabelError, GraphError
        A floor has rooms without a label of the schema, or is not connected; the message names all faults.
    OptionError
        `areas` is not "corr" or "ncut", or the seed is negative.

    References
    ----------
    M. Luperto, PhD thesis, section 7.3.

    Examples
    --------
    >>> import pianta
    >>> floors = [pianta.read_building(file) for file in ("a.xml", "b.xml", "c.xml")]  # doctest: +SKIP
    >>> model = pianta.train_type(floors)  # doctest: +SKIP
    >>> model.save("school.json")  # doctest: +SKIP
    """
    if areas not in [*Segmentation]:
        raise OptionError(f"areas is {short_repr(areas)}, give one of {', '.join(Segmentation)}")
    if seed < 0:
        raise OptionError(f"seed is {seed}, give 0 or more")
    floors = list(floors)
    graphs = [describe_shapes(floor) if isinstance(floor, Floor) else floor for floor in floors]
    schema = schema or choose_schema([floor for floor in floors if isinstance(floor, Floor)])
    model = learn_type(graphs, schema, segmentation=Segmentation(areas))
    mixing = count_mixing_iterations(model, seed=seed, track=track)
    return replace(
        model,
        sweeps=mixing.sweeps.iterations,
        edge_moves=mixing.edge_moves.iterations,
        door_moves=mixing.door_moves.iterations,
        mixing=mixing,
    )


def choose_schema(floors: Sequence[Floor], schemas: Mapping[str, LabelSchema] = ALL_SCHEMAS) -> LabelSchema:
    """Return the schema of the building type of all floors.

    schemas: by building type.
    Raises ModelError for floors without a type and for several types, LabelError for a type without a schema.
    """
    untyped = [floor.source for floor in floors if not floor.given_type]
    if untyped:
        others = f", nor have {len(untyped) - 1} more" if len(untyped) > 1 else ""
        raise ModelError(f"{short_repr(untyped[0])} has no building type{others}; give it by building_type=")
    types = sorted({floor.given_type for floor in floors if floor.given_type})
    if not types:
        raise ModelError("no floor has a building type, give the schema of the labels")
    if len(types) > 1:
        raise ModelError(f"the buildings are of types {', '.join(types)}, and a model is of one; give those of one")
    if types[0] not in schemas:
        names = ", ".join(schemas)
        raise LabelError(f"there is no schema of building type {short_repr(types[0])}, give one by schema=, or {names}")
    return schemas[types[0]]


def count_mixing_iterations(
    model: TypeModel, *, seed: int = 0, track: Callable[[Sequence[str]], Iterable[str]] = iter
) -> ModelMixing:
    """Count the iterations until the chains of a model have mixed, from those of the authors on (section 7.4.2).

    Chains with the same target start from different floors or graphs. The iterations are doubled, at most twice, while
    R̂ of the second half of the iterations is 1.1 or more for any target.
    track: wraps the names of the steps, to show progress.
    """
    runs = (_run_sweeps, model.sweeps), (_run_edge_moves, model.edge_moves), (_run_door_moves, model.door_moves)
    names = track([f"iterations of {step}" for step in STEPS])
    return ModelMixing(*(_double(*run, model, seed) for _, run in zip(names, runs, strict=True)))


def _double(runner: Callable[[BuildingSampler, int], Floats], iterations: int, model: TypeModel, seed: int) -> Mixing:
    """Double the iterations until the chains of all targets have mixed, or the limit is reached."""
    most = MAX_FACTOR * iterations
    while True:
        longer = replace(model, sweeps=iterations, edge_moves=iterations, door_moves=iterations)
        traces = runner(BuildingSampler(longer), seed)
        mixing = Mixing(iterations, tuple(measure_convergence(chains[:, iterations // 2 :]) for chains in traces))
        if mixing.has_mixed or iterations >= most:
            return mixing
        iterations *= 2


def _run_sweeps(sampler: BuildingSampler, seed: int) -> Floats:
    """Costs of step 1, shape (1, chains, sweeps): all chains have one target and start from floors of the model."""
    floors = sampler.model.configurations
    starts = floors[np.random.default_rng(seed).integers(len(floors), size=CHAINS * TARGETS)]
    traces: list[Floats] = []
    sampler.sample_areas(starts, _generators(seed, len(starts)), traces=traces)
    return np.array(traces).T[None]


def _run_edge_moves(sampler: BuildingSampler, seed: int) -> Floats:
    """Costs of step 2, shape (targets, chains, moves); a target is the areas of a floor."""
    traces: list[Floats] = []
    chosen = [target for target in _list_targets(sampler, seed) for _ in range(CHAINS)]
    if not chosen:
        return np.zeros((0, CHAINS, 0))
    sampler.join_areas([areas for areas, _ in chosen], _generators(seed, len(chosen)), traces=traces)
    return np.array(traces).T.reshape(-1, CHAINS, len(traces))


def _run_door_moves(sampler: BuildingSampler, seed: int) -> Floats:
    """Costs of step 4, shape (targets, chains, moves); a target is the areas of a floor with its functional graph."""
    traces: list[Floats] = []
    chosen = [target for target in _list_targets(sampler, seed) for _ in range(CHAINS)]
    if not chosen:
        return np.zeros((0, CHAINS, 0))
    graphs = [sampler.model.floors[floor].functional_graph for _, floor in chosen]
    areas = [[sampler.areas[area] for area in own] for own, _ in chosen]
    sampler.connect_rooms(areas, graphs, _generators(seed, len(chosen)), traces=traces)
    return np.array(traces).T.reshape(-1, CHAINS, len(traces))


def _list_targets(sampler: BuildingSampler, seed: int) -> list[tuple[list[int], int]]:
    """Random floors with at least two areas, at most TARGETS: their areas, and their indices in the model."""
    ends = np.cumsum([len(floor.areas) for floor in sampler.model.floors]).tolist()
    targets = [
        ([*range(end - len(floor.areas), end)], index)
        for index, (floor, end) in enumerate(zip(sampler.model.floors, ends, strict=True))
        if len(floor.areas) > 1
    ]
    order = np.random.default_rng(seed).permutation(len(targets))[:TARGETS]
    return [targets[index] for index in order]


def _generators(seed: int, count: int) -> list[np.random.Generator]:
    return [np.random.default_rng((seed, number)) for number in range(count)]
