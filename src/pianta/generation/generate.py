"""New buildings of a type: the function behind the verb `pianta generate`."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence

import networkx as nx
import numpy as np

from pianta._arguments import check_argument
from pianta.errors import BuildingWarning, GraphError, LabelError, OptionError
from pianta.floor import Floor
from pianta.generation.area_clusters import AreaKernel
from pianta.generation.buildings import BuildingSampler, Costs, sample_buildings
from pianta.generation.constraints import Constraints
from pianta.generation.type_model import TypeFloor, TypeModel, assign_area_clusters, check_model_type
from pianta.graphs.labelled_graphs import name_some
from pianta.io._files import short_repr


def generate(
    model: TypeModel,
    count: int = 1,
    *,
    rooms: int | tuple[int, int] | None = None,
    at_least: Mapping[str, int] | None = None,
    at_most: Mapping[str, int] | None = None,
    similar_to: Floor | nx.Graph | None = None,
    keep: Floor | nx.Graph | None = None,
    costs: str = "density",
    recombine: bool = True,
    kernel: str = "weisfeiler-lehman",
    seed: int = 0,
    jobs: int = 1,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> list[nx.Graph]:
    """Generate new buildings of a type, as graphs of labelled rooms joined by doors (thesis, chapter 7).

    The command `pianta generate` calls this function.

    Parameters
    ----------
    model
        Model of the building type, from `train_type` or `load_model`.
    count
        Number of buildings.
    rooms
        Number of rooms of each building, corridors included; or minimum and maximum. None for the sizes of the model.
    at_least, at_most
        Label -> minimum, or maximum, number of rooms with this label.
    similar_to
        A floor that the buildings resemble, also in size.
    keep
        A floor whose rooms and doors each building contains, besides others; `room` is their id in the new graphs.
        Rooms without a door are left out, with a warning.
    costs
        Costs of the sampler: "density", or "thesis" for those of section 7.4.3.
    recombine
        Whether the functional areas change inside: rooms of a building are exchanged between its areas, left out and
        added. False for areas of real floors as they are; always so with the costs of the thesis.
    kernel
        What compares graphs in steps 2 and 4: "weisfeiler-lehman", or "graph-hopper", which takes far longer (Table
        7.2).
    seed
        The same seed gives the same buildings.
    jobs
        Number of processes; the buildings do not depend on it.
    track
        Wraps the names of the steps, to show progress.

    Returns
    -------
    list of networkx.Graph
        Nodes are 0 … n - 1, each with a `label`.

    Raises
    ------
    OptionError
        An option is out of range, or no building can have these numbers of rooms.
    ModelError
        No sampled building had these numbers of rooms, or `similar_to` or `keep` is of another type.
    GraphError, LabelError
        `similar_to` or `keep` has no doors, or labels that the model does not have.

    Warns
    -----
    BuildingWarning
        Rooms of `similar_to` or `keep` have no door.

    References
    ----------
    M. Luperto, PhD thesis, section 7.4.3.

    Examples
    --------
    >>> import pianta
    >>> model = pianta.load_model("school.json")  # doctest: +SKIP
    >>> pianta.generate(model, 24, rooms=(30, 50), at_least={"GYM": 1})  # doctest: +SKIP
    """
    sampler = make_sampler(
        model,
        rooms=rooms,
        at_least=at_least,
        at_most=at_most,
        similar_to=similar_to,
        keep=keep,
        costs=costs,
        recombine=recombine,
        kernel=kernel,
    )
    return sample_buildings(sampler, count, seed=seed, jobs=jobs, track=track)


def make_sampler(
    model: TypeModel,
    *,
    rooms: int | tuple[int, int] | None = None,
    at_least: Mapping[str, int] | None = None,
    at_most: Mapping[str, int] | None = None,
    similar_to: Floor | nx.Graph | None = None,
    keep: Floor | nx.Graph | None = None,
    costs: str = "density",
    recombine: bool = True,
    kernel: str = "weisfeiler-lehman",
) -> BuildingSampler:
    """What samples buildings with these options, which are those of `generate`. Raises and warns as `generate`."""
    check_argument(model, TypeModel, "model", "a model of train_type or load_model")
    if costs not in [*Costs]:
        raise OptionError(f"costs is {short_repr(costs)}, give one of {', '.join(Costs)}")
    if kernel not in [*AreaKernel]:
        raise OptionError(f"kernel is {short_repr(kernel)}, give one of {', '.join(sorted(AreaKernel, reverse=True))}")
    constraints = Constraints(
        # Accepts integers of NumPy.
        rooms=(int(rooms), int(rooms)) if isinstance(rooms, int | np.integer) else rooms,
        at_least=at_least or {},
        at_most=at_most or {},
    )
    return BuildingSampler(
        model,
        constraints,
        _assign_clusters(similar_to, model),
        _assign_clusters(keep, model),
        Costs(costs),
        recombine,
        AreaKernel(kernel),
    )


def _assign_clusters(floor: Floor | nx.Graph | None, model: TypeModel) -> TypeFloor | None:
    """Divide a floor of the model's type into functional areas of the model; warns of rooms without a door."""
    if floor is None:
        return None
    graph = floor.graph() if isinstance(floor, Floor) else floor
    name = f"floor {short_repr(graph.graph.get('source', ''))}"
    building_type = floor.given_type if isinstance(floor, Floor) else floor.graph.get("building_type")
    check_model_type(building_type, model, name)
    try:
        type_floor = assign_area_clusters(graph, model)
    except GraphError as error:
        raise GraphError(f"{name}: {error}") from error
    except LabelError as error:
        command = f"pianta read map.yaml --type {model.building_type} -o building"
        raise LabelError(f"{name}: {error}; or read its map with labels of the type: `{command}`") from error
    if alone := [node for node, doors in graph.degree if not doors]:
        warnings.warn(BuildingWarning(f"{name}: rooms {name_some(alone)} have no door and are left out"), stacklevel=4)
    return type_floor
