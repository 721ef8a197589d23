"""The buildings that bench exploration explores: schools and offices of the data, synthetic ones, and drawn ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil
from pathlib import Path

import networkx as nx

from pianta.errors import DataError, LabelError, OptionError, PiantaError
from pianta.exploration.starts import CORRIDOR_LABELS
from pianta.floor import Floor
from pianta.generation.drawing.draw import draw_plan
from pianta.generation.generate import generate
from pianta.generation.type_model import MIN_FLOORS, learn_type, prepare_room_graph
from pianta.gridmap import GridMap
from pianta.io._files import one_line_reason
from pianta.labels import SCHEMAS, SCHOOL, standard_name
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta_bench.data.annotated_floors import AnnotatedFloor, read_annotated_buildings
from pianta_bench.exploration import DEFAULT_SETS, DRAWN_SET, SETS, SYNTHETIC

SYNTHETIC_SEEDS = range(3)
# Robots search for a label that at most this many rooms of the floor have. Chosen by hand.
MAX_ROOMS = 2
# And that is on at least this many floors of other buildings. Chosen by hand.
MIN_OTHER_FLOORS = 4
# Robots start in such rooms, or pass through them all the time: no search for these.
WAYS = (*CORRIDOR_LABELS, "ENTRANCE")
DRAWN_SCHOOLS = 30
# Buildings that are generated for each one that is wanted: a few are not drawn with all doors.
GENERATED = 1.5


@dataclass(frozen=True, eq=False)
class ExploredBuilding:
    """A floor to explore.

    part: the set it belongs to. others: the room graphs of all other buildings of its type, to learn from; empty if
    these are too few. labels: those to search for. building_type: that of `others`; empty without them. grid: the map
    of a building of which there is nothing else; its floor then has no rooms.
    """

    part: str
    name: str
    floor: Floor
    others: tuple[nx.Graph, ...] = ()
    labels: tuple[str, ...] = ()
    building_type: str = ""
    grid: GridMap | None = None


@dataclass(frozen=True, eq=False)
class BuildingSet:
    """The buildings of a set.

    failures: by floor that cannot be read the reason. unmodelled: by floor that no model can learn from the reason.
    notes: on how they were chosen.
    """

    buildings: tuple[ExploredBuilding, ...]
    failures: Mapping[str, str] = field(default_factory=dict)
    unmodelled: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def choose_sets(names: Sequence[str]) -> tuple[str, ...]:
    """The sets of these names, each once, DEFAULT_SETS without names; raises OptionError for others."""
    for name in names:
        if name not in SETS:
            raise OptionError(f"set is {name!r}, give one of {', '.join(SETS)}")
    return tuple(name for name in SETS if name in (names or DEFAULT_SETS))


def make_buildings() -> BuildingSet:
    """Synthetic floors of each layout; no model fits their labels."""
    return BuildingSet(
        tuple(
            ExploredBuilding(SYNTHETIC, f"{layout}-{seed}", make_floor(layout, seed=seed))
            for layout in FLOOR_MAKERS
            for seed in SYNTHETIC_SEEDS
        )
    )


def draw_buildings(data: Path) -> BuildingSet:
    """Schools that a model of all schools of the data generates and draws, the first ones that have all their doors.

    Policies learn from the schools of the data. Raises DataError as `read_buildings`, and for too few schools.
    """
    real_type = SCHOOL.building_type
    real = read_buildings(data, real_type)
    graphs = tuple(dict.fromkeys(graph for building in real.buildings for graph in building.others))
    if not graphs:
        raise DataError(
            f"{len(real.buildings)} schools are too few to learn a model from, give {MIN_FLOORS + 1} or more"
        )
    model = learn_type(graphs, SCHOOL)
    buildings: list[ExploredBuilding] = []
    incomplete = 0
    for number, graph in enumerate(generate(model, ceil(GENERATED * DRAWN_SCHOOLS)), start=1):
        plan = draw_plan(graph, model, seed=number)
        if plan.given_up:
            incomplete += 1
            continue
        buildings.append(ExploredBuilding(DRAWN_SET, f"drawn-{number:02}", plan.floor, graphs, building_type=real_type))
        if len(buildings) == DRAWN_SCHOOLS:
            break
    note = f"Generated and drawn with all doors; {incomplete} others lack some and were passed over."
    return BuildingSet(tuple(buildings), notes=(note,))


def read_buildings(data: Path, building_type: str) -> BuildingSet:
    """The floors of data/buildings/TYPE/*.xml.

    Floors in several parts, or with labels that the type does not have, are explored, but no model learns from them.
    Raises DataError if there is no floor, or none can be read.
    """
    floors, failed = read_annotated_buildings(data, building_type, lambda floor: floor)
    if not floors:
        raise DataError(f"no floor of {building_type}s can be read, the first: {failed[0].item}, {failed[0].failure}")
    graphs, unmodelled = {}, {}
    for floor in floors:
        try:
            graph = floor.floor.graph()
            graph.graph["source"] = floor.item
            graphs[floor.item] = prepare_room_graph(graph, SCHEMAS[building_type])
        except PiantaError as error:
            unmodelled[floor.item] = one_line_reason(error)
    buildings = []
    for floor in floors:
        others = [other for other in floors if other.building != floor.building]
        training = tuple(graphs[other.item] for other in others if other.item in graphs)
        usable = training if len(training) >= MIN_FLOORS else ()
        labels = choose_labels(floor, others)
        buildings.append(ExploredBuilding(building_type, floor.item, floor.floor, usable, labels, building_type))
    return BuildingSet(tuple(buildings), {row.item: row.failure or "" for row in failed}, unmodelled)


def choose_labels(floor: AnnotatedFloor, others: Sequence[AnnotatedFloor]) -> tuple[str, ...]:
    """Labels to search for, sorted: rare on the floor, and known from other floors."""
    labels = list_labels(floor.floor)
    elsewhere = [label for other in others for label in {*list_labels(other.floor)}]
    return tuple(
        label
        for label in sorted({*labels} - {*WAYS})
        if labels.count(label) <= MAX_ROOMS and elsewhere.count(label) >= MIN_OTHER_FLOORS
    )


def list_labels(floor: Floor) -> list[str]:
    """The labels of the rooms in standard form, without invalid ones."""
    labels = []
    for room in floor.rooms:
        try:
            labels += [standard_name(room.label)] if room.label else []
        except LabelError:
            continue
    return labels
