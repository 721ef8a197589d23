"""Draw the graph of a building: the function behind `pianta generate --plans`."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from types import NoneType

import networkx as nx
import numpy as np
from shapely import Polygon

from pianta._arguments import check_argument
from pianta.errors import BuildingWarning, OptionError
from pianta.floor import Floor
from pianta.generation.drawing.blocks import DOOR_CELLS, MARGIN_CELLS, NO_ROOM, Cells, measure_contact, paint_cells
from pianta.generation.drawing.choices import Edge
from pianta.generation.drawing.compaction import compact
from pianta.generation.drawing.gaps import close_gaps
from pianta.generation.drawing.layouts import Layout, find_layouts
from pianta.generation.drawing.losses import (
    ROOM_FACTOR,
    find_missing_doors,
    measure_arms,
    measure_corners,
    measure_form,
)
from pianta.generation.drawing.programme import Programme, make_programme, make_site_programme
from pianta.generation.drawing.short_arms import find_short_arm
from pianta.generation.drawing.site import OUTSIDE, list_scales, make_site
from pianta.generation.drawing.walls import build_plan, find_closed_entrances
from pianta.generation.type_model import TypeModel, prepare_room_graph

# All chosen by hand, on generated schools.
FINISHED = 8  # layouts, the best ones, that get arms; more, up to MOST_FINISHED, while doors are missing
MOST_FINISHED = 16
COMPACTED = 3  # candidates, the best ones, that are compacted
ORDERS = 6  # of arms, while doors are missing
SITE_TRIES = 2  # of all scales of areas, while doors are missing or nothing fits into an outline


@dataclass(frozen=True)
class DrawnPlan:
    """A graph as a floor.

    Attributes
    ----------
    floor
        Rooms with outlines, walls and doors, metres; room ids are those of the nodes plus one.
    given_up
        Pairs of room ids between which the graph has a door and the floor does not.
    closed_entrances
        Ids of rooms labelled ENTRANCE that have no door to the outside, as they have no outer wall for it.
    """

    floor: Floor
    given_up: tuple[tuple[int, int], ...]
    closed_entrances: tuple[int, ...] = ()


@dataclass(frozen=True)
class _Candidate:
    """cells: the node of each cell. loss: the less, the better. missing: doors of the graph without a wall for them.

    loose: the cells before gaps were closed. arm_loss: the part of the loss by the number and lengths of arms.
    """

    cells: Cells
    loss: float
    missing: tuple[Edge, ...]
    loose: Cells
    arm_loss: float


def draw_plan(graph: nx.Graph, model: TypeModel, *, seed: int = 0, outline: Polygon | None = None) -> DrawnPlan:
    """Draw the graph of a building as a floor: corridors as strips, rooms along them, walls and doors.

    Rooms have areas of the rooms of the type with the same label. Many layouts are drawn; the one is returned that has
    most doors of the graph, and among these one that is compact. The command `pianta generate --plans` calls this
    function.

    Parameters
    ----------
    graph
        Connected, with a `label` of the type at each node, as of `generate`.
    model
        Model of the building type, from `train_type` or `load_model`, of floors with areas.
    seed
        The same seed gives the same floor.
    outline
        In which the building is drawn, metres, such as the walls of one that is to be planned anew. Rooms have the
        areas of a floor of the type that fills it best, and become smaller, within limits, to fit.

    Returns
    -------
    DrawnPlan
        The floor, and the doors that could not be drawn, also those to the outside.

    Raises
    ------
    GraphError, LabelError
        The graph is not connected, or has other labels than the type.
    ModelError
        The floors of the model have no area of a room with one of the labels.
    OptionError
        The seed is negative, or an argument of another type; the outline is too small, or no layout fits into it.

    References
    ----------
    M. Luperto, PhD thesis, chapter 7, whose buildings end as graphs.

    Examples
    --------
    >>> import pianta
    >>> model = pianta.load_model("school.json")  # doctest: +SKIP
    >>> plan = pianta.draw_plan(pianta.generate(model)[0], model)  # doctest: +SKIP
    >>> plan.floor.save("floor.geojson")  # doctest: +SKIP
    """
    check_argument(graph, (nx.Graph,), "graph", "a graph of generate")
    check_argument(model, (TypeModel,), "model", "a model of train_type or load_model")
    check_argument(outline, (Polygon, NoneType), "outline", "a polygon of shapely")
    if seed < 0:
        raise OptionError(f"seed is {seed}, give 0 or more")
    prepared = prepare_room_graph(graph, model.schema)
    rng = np.random.default_rng(seed)
    # Each room gets the area of a room of the type, most of them those of one floor
    if outline is None:
        programme = make_programme(prepared, model, rng)
    else:
        programme = make_site_programme(prepared, model, rng, make_site(outline))
    plan = _choose_plan(programme, rng)
    doors = [edge for edge in prepared.edges if edge not in plan.missing]
    # Cells become rooms between walls, with a door for each edge
    floor = build_plan(plan.cells, programme, doors, rng, building_type=model.building_type)
    if programme.site is not None:
        floor = programme.site.move(floor)
    given_up = tuple(sorted((one + 1, other + 1) for one, other in plan.missing))
    return DrawnPlan(floor, given_up, find_closed_entrances(floor))


def warn_of_missing_doors(plan: DrawnPlan, name: str) -> None:
    """Warn of the doors that a plan of a name lacks, between rooms and to the outside."""
    faults = []
    if plan.given_up:
        pairs = ", ".join(f"{one}–{other}" for one, other in plan.given_up)
        faults.append(f"no wall for doors {pairs}")
    if plan.closed_entrances:
        rooms = ", ".join(map(str, plan.closed_entrances))
        faults.append(f"no outer wall for the door to the outside of ENTRANCE {rooms}")
    if faults:
        warnings.warn(BuildingWarning(f"{name}: {'; '.join(faults)}"), stacklevel=3)


def _choose_plan(programme: Programme, rng: np.random.Generator) -> _Candidate:
    """The best candidate; on a site rooms become smaller until one has all doors. Raises OptionError if none fits."""
    site, best = programme.site, None
    for scale in [1.0] if site is None else SITE_TRIES * list_scales(sum(programme.areas.values()), site):
        scaled = programme.scaled(scale)
        # Spanning trees are drawn without overlaps: corridors as strips, their rooms on both sides
        layouts = find_layouts(scaled, rng)
        # Doors outside the tree get arms around or between rooms, the best layouts first; parts of the building move
        # towards each other, and rooms grow into narrow gaps
        best = _choose_better(best, _finish_best(layouts, scaled, rng))
        if best is not None and not best.missing:
            break
    if best is not None:
        return best
    fault = f"no layout of the {len(programme.graph)} rooms that was tried fits into the outline"
    raise OptionError(f"{fault}; give a larger outline, fewer rooms, or another seed")


def _finish_best(layouts: Sequence[Layout], programme: Programme, rng: np.random.Generator) -> _Candidate | None:
    """The best candidate, by missing doors and then by loss, after the best layouts got arms and were compacted.

    None if no layout fits on the site.
    """
    candidates: list[_Candidate] = []
    for number, layout in enumerate(layouts[:MOST_FINISHED]):
        most = min((len(each.missing) for each in candidates), default=inf)
        if not most and number >= FINISHED:
            break
        candidate = _finish(layout, programme, rng, most_missing=most)
        if candidate is not None:
            candidates.append(candidate)
    candidates.sort(key=_rank)
    if programme.site is None:
        candidates += [_compact(each, programme) for each in candidates[:COMPACTED]]
    return min(candidates, key=_rank, default=None)


def _choose_better(one: _Candidate | None, other: _Candidate | None) -> _Candidate | None:
    """The candidate with fewer missing doors, of equal ones that which loses less; None is the worst."""
    return min((each for each in (one, other) if each is not None), key=_rank, default=None)


def _finish(
    layout: Layout, programme: Programme, rng: np.random.Generator, *, most_missing: float
) -> _Candidate | None:
    """The best candidate of some orders of arms for the doors that miss a wall; the first arms find most ways.

    None for a layout that does not fit on the site, or if more doors than most_missing have no wall.
    """
    cells = paint_cells(layout.block, MARGIN_CELLS)
    on_site = cells if programme.site is None else programme.site.put(cells)
    if on_site is None:
        return None
    best, failures = None, Counter[Edge]()
    # Once a layout has all doors, another one has to be better without many tries
    for _ in range(ORDERS if most_missing else 1):
        candidate = _add_arms(on_site.copy(), programme, rng, failures, most_missing=most_missing)
        best = _choose_better(best, candidate)
        if best is not None:
            if not best.missing:
                break
            most_missing = min(most_missing, len(best.missing))
    return best


def _rank(candidate: _Candidate) -> tuple[int, float]:
    return len(candidate.missing), candidate.loss


def _add_arms(
    cells: Cells,
    programme: Programme,
    rng: np.random.Generator,
    failures: Counter[Edge],
    *,
    most_missing: float,
) -> _Candidate | None:
    """A candidate with arms; corridors reach for rooms, if one of both is a corridor.

    cells: of the layout, perhaps on a site, changed in place. failures: how often each door has found no way; the most
    frequent ones are the first. None once more doors than most_missing find no way.
    """
    graph, corridors = programme.graph, programme.corridors
    arms, used, failed = 0, 0, 0
    missing = find_missing_doors(cells, graph)
    order = [missing[index] for index in rng.permutation(len(missing))]
    for one, other in sorted(order, key=lambda edge: (-failures[edge], -sum(node in corridors for node in edge))):
        if measure_contact(cells, one, other) >= DOOR_CELLS:
            continue
        room, goal = (other, one) if other in corridors and one not in corridors else (one, other)
        arm = find_short_arm(cells, room, goal, graph, corridors)
        if arm is not None:
            cells[arm] = room
            arms += 1
            used += int(arm.sum()) * (1 if room in corridors else ROOM_FACTOR)
            continue
        failures[one, other] += 1
        failed += 1
        if failed > most_missing:
            return None
    return _close_gaps(cells, measure_arms(cells, arms, used), programme)


def _close_gaps(loose: Cells, arm_loss: float, programme: Programme) -> _Candidate:
    """A candidate of cells, in which rooms grow into narrow gaps. arm_loss: of its arms."""
    cells = loose.copy()
    close_gaps(cells, [*programme.graph])
    cells[cells == OUTSIDE] = NO_ROOM
    loss = measure_form(cells, programme) + arm_loss + measure_corners(cells)
    return _Candidate(cells, loss, find_missing_doors(cells, programme.graph), loose, arm_loss)


def _compact(candidate: _Candidate, programme: Programme) -> _Candidate:
    """A candidate whose parts are as near to each other as the areas of its rooms allow."""
    return _close_gaps(compact(candidate.loose, programme.graph, programme.areas), candidate.arm_loss, programme)
