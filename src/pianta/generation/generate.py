"""New buildings of a type: the function behind the verb `pianta generate`."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence

import networkx as nx
import numpy as np

from pianta._arguments import check_argument
from pianta.errors import BuildingWarning, GraphError, LabelError, OptionError
from pianta.floor import Floor
from pianta.generation.buildings import Costs, generate_buildings
from pianta.generation.type_model import TypeFloor, TypeModel, recognize_areas
from pianta.generation.wishes import Wishes
from pianta.graphs.labelled_graphs import name_some
from pianta.io._files import short_repr


def generate(
    model: TypeModel,
    count: int = 1,
    *,
    rooms: int | tuple[int, int] | None = None,
    at_least: Mapping[str, int] | None = None,
    at_most: Mapping[str, int] | None = None,
    like: Floor | nx.Graph | None = None,
    keep: Floor | nx.Graph | None = None,
    costs: str = "density",
    seed: int = 0,
    jobs: int = 1,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> list[nx.Graph]:
    """Generate new buildings of a type, as graphs of labelled rooms joined by doors (thesis, chapter 7).

    The command `pianta generate` calls this function.

    Parameters
    ----------
    model
        Model of the building type, of `train_type` or `load_model`.
    count
        How many buildings.
    rooms
        Rooms of each building, corridors included: their number, or the fewest and the most. None for any number.
    at_least, at_most
        Label -> fewest, or most, rooms of this label.
    like
        A floor that the buildings are to be like, and about as large.
    keep
        A floor whose rooms and doors each building has, besides others; `room` is their id in the new graphs. Rooms
        without a door are left out, with a warning.
    costs
        What the sampler follows: "density", or "thesis" for the costs of section 7.4.3.
    seed
        The same seed gives the same buildings.
    jobs
        Processes; the buildings are the same for any number of them.
    track
        Wraps the names of the steps, to show progress.

    Returns
    -------
    list of networkx.Graph
        Nodes are 0 … n - 1, each with a `label`.

    Raises
    ------
    OptionError
        An option makes no sense, or no building can meet the numbers of rooms.
    ModelError
        No building met the numbers of rooms in time.
    GraphError, LabelError
        `like` or `keep` has no doors, or labels that the model does not have.

    Warns
    -----
    BuildingWarning
        Rooms of `like` or `keep` have no door.

    References
    ----------
    M. Luperto, PhD thesis, section 7.4.3.

    Examples
    --------
    >>> import pianta
    >>> model = pianta.load_model("school.json")  # doctest: +SKIP
    >>> pianta.generate(model, 24, rooms=(30, 50), at_least={"GYM": 1})  # doctest: +SKIP
    """
    check_argument(model, TypeModel, "model", "a model of train_type or load_model")
    if costs not in [*Costs]:
        raise OptionError(f"costs is {short_repr(costs)}, give one of {', '.join(Costs)}")
    return generate_buildings(
        model,
        count,
        seed=seed,
        wishes=Wishes(
            rooms=_take_range(rooms),
            at_least=at_least or {},
            at_most=at_most or {},
        ),
        like=_take_floor(like, model),
        kept=_take_floor(keep, model),
        costs=Costs(costs),
        jobs=jobs,
        track=track,
    )


def _take_range(rooms: int | tuple[int, int] | None) -> tuple[int, int] | None:
    """The fewest and the most rooms; a number of NumPy is a number."""
    if isinstance(rooms, int | np.integer):
        return int(rooms), int(rooms)
    return rooms


def _take_floor(floor: Floor | nx.Graph | None, model: TypeModel) -> TypeFloor | None:
    """The functional areas of a floor, as the model clusters them; warns of rooms without a door."""
    if floor is None:
        return None
    graph = floor.graph() if isinstance(floor, Floor) else floor
    name = f"floor {short_repr(graph.graph.get('source', ''))}"
    try:
        known = recognize_areas(graph, model)
    except (GraphError, LabelError) as error:
        raise type(error)(f"{name}: {error}") from error
    if alone := [node for node, doors in graph.degree if not doors]:
        warnings.warn(BuildingWarning(f"{name}: rooms {name_some(alone)} have no door and are left out"), stacklevel=3)
    return known
