"""Buildings with the map that a robot would make of them: synthetic ones, and those of a building type."""

from __future__ import annotations

from typing import Literal, Unpack

from pianta._arguments import check_argument
from pianta.errors import LabelError, OptionError
from pianta.floor import Floor
from pianta.generation.type_model import TypeModel
from pianta.gridmap import GridMap
from pianta.io._files import short_repr
from pianta.labels import standard_building_type
from pianta.worlds.make import SAMPLE, MapOptions, check_seed, make_synthetic_world, map_world

# The options of a map that are numbers.
MEASURES: tuple[Literal["resolution", "noise", "furniture", "yaw"], ...] = ("resolution", "noise", "furniture", "yaw")


def make_world(
    name: str = SAMPLE, *, model: TypeModel | None = None, seed: int | None = None, **options: Unpack[MapOptions]
) -> tuple[Floor, GridMap]:
    """Make a building and the map that a robot would make of it: a synthetic one, or one of a building type.

    The command `pianta world` calls this function.

    Parameters
    ----------
    name
        "sample", which is always the same, or "corridor", "l", "ring" or "hall", or, with labels, "home", "office",
        "open_plan", "ward" or "depot". With a model its building type, such as "school".
    model
        Model of a building type, from `train_type` or `load_model`, of floors with areas; the building is the first
        one of `generate` with this seed, drawn by `draw_plan`. None for a synthetic building.
    seed
        Of the building and the noise; None for 0.
    **options
        `resolution` (metres per cell), `noise` (0 … 1), `furniture` (0 empty, 1 a busy office, at most 10),
        `dense_furniture` (whether it is chosen by the labels of rooms, stands in corridors too, and may nearly close
        passages), `door_leaves` (whether doors are open, half open and shut, not gaps),
        `glass_spray` (whether one outer wall is glass), `yaw` (radians from the building's axes to the map's).

    Returns
    -------
    floor : Floor
        The truth: rooms, doors and furniture, metres of the map frame.
    grid : GridMap
        The map.

    Raises
    ------
    OptionError
        The name is unknown or not the type of the model, an option or the seed is out of range, or the sample has
        options.
    ModelError
        The floors of the model have no areas.

    Warns
    -----
    BuildingWarning
        A door of the graph could not be drawn.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor", resolution=0.1)
    >>> len(floor), grid.shape
    (19, (167, 323))
    >>> model = pianta.load_model("school.json")  # doctest: +SKIP
    >>> school, grid = pianta.make_world("school", model=model, furniture=1, dense_furniture=True)  # doctest: +SKIP
    """
    if model is None:
        return make_synthetic_world(name, seed=seed, **options)
    check_argument(model, (TypeModel,), "model", "a model of train_type or load_model")
    check_seed(seed)
    _check_type(name, model)
    return _make_type_world(model, seed or 0, options)


def _check_type(name: str, model: TypeModel) -> None:
    """Raise OptionError for a name that is not the building type of a model."""
    try:
        is_type = standard_building_type(name) == standard_building_type(model.building_type)
    except LabelError:
        is_type = False
    if not is_type:
        raise OptionError(
            f"name is {short_repr(name)}, the model is of type {short_repr(model.building_type)}; give that name, "
            "or leave out the model"
        )


def _make_type_world(model: TypeModel, seed: int, options: MapOptions) -> tuple[Floor, GridMap]:
    from pianta.generation.buildings import find_building_seed
    from pianta.generation.drawing.draw import draw_plan, warn_of_missing_doors
    from pianta.generation.generate import generate
    from pianta.worlds.scan import check_map_options

    measures: dict[str, float] = {name: options[name] for name in MEASURES if name in options}
    check_map_options(None, **measures)
    # The first building of the seed as a graph
    (graph,) = generate(model, seed=seed)
    graph.graph["source"] = model.building_type
    # Its floor
    number_seed = find_building_seed(seed, 0)
    plan = draw_plan(graph, model, seed=number_seed)
    warn_of_missing_doors(plan, model.building_type)
    # Its furniture, and its map
    return map_world(plan.floor, seed=number_seed, **options)
