"""A model of a building type from labelled floors: the function behind the verb `pianta train type`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import networkx as nx

from pianta.errors import LabelError, ModelError, OptionError
from pianta.floor import Floor
from pianta.generation.functional_areas import Segmentation
from pianta.generation.mixing import find_mixing
from pianta.generation.type_model import TypeModel, learn_type
from pianta.io._files import short_repr
from pianta.labels import SCHEMAS, LabelSchema


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
        Two floors or more, better dozens, of one type; or their graphs. Each room has a label of the schema.
    schema
        The labels of the type; None for those that come with pianta, by the type that the floors have.
    areas
        How functional areas are found: "corr", by corridors, or "ncut", by normalised cuts (section 7.3.1).
    seed
        Of the chains by which iterations are counted.
    track
        Wraps the names of the steps, to show progress.

    Returns
    -------
    TypeModel
        `model.save(path)` writes it; `model.mixing` says how many iterations its chains take, and their R-hat.

    Raises
    ------
    ModelError
        Fewer than two floors, or floors of several types.
    LabelError, GraphError
        A floor has rooms without a label of the schema, or parts that no door joins; the message names all of them.
    OptionError
        `areas` is none of the two, or the seed is negative.

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
    graphs = [floor.graph() if isinstance(floor, Floor) else floor for floor in floors]
    schema = schema or choose_schema([floor for floor in floors if isinstance(floor, Floor)])
    model = learn_type(graphs, schema, segmentation=Segmentation(areas))
    found = find_mixing(model, seed=seed, track=track)
    return replace(
        model,
        sweeps=found.sweeps.iterations,
        edge_moves=found.edge_moves.iterations,
        door_moves=found.door_moves.iterations,
        mixing=found,
    )


def choose_schema(floors: Sequence[Floor], schemas: Mapping[str, LabelSchema] = SCHEMAS) -> LabelSchema:
    """The schema of the one building type that all floors have.

    schemas: by building type.
    Raises ModelError for floors without a given type and for several types, LabelError for a type without a schema.
    """
    untyped = [floor.source for floor in floors if not floor.given_type]
    if untyped:
        others = f", nor do {len(untyped) - 1} more" if len(untyped) > 1 else ""
        raise ModelError(f"{short_repr(untyped[0])} does not tell its building type{others}; give it by building_type=")
    kinds = sorted({floor.given_type for floor in floors if floor.given_type})
    if not kinds:
        raise ModelError("no floor tells the type of the buildings, give the schema of their labels")
    if len(kinds) > 1:
        raise ModelError(f"the buildings are of types {', '.join(kinds)}, and a model is of one; give those of one")
    if kinds[0] not in schemas:
        names = ", ".join(schemas)
        raise LabelError(f"there is no schema of building type {short_repr(kinds[0])}, give one by schema=, or {names}")
    return schemas[kinds[0]]
