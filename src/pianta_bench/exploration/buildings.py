"""The buildings that bench exploration explores: schools and offices of the data, and synthetic ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import networkx as nx

from pianta.errors import DataError, LabelError, OptionError, PiantaError
from pianta.exploration.starts import CORRIDOR_LABELS
from pianta.floor import Floor
from pianta.generation.type_model import MIN_FLOORS, prepare_room_graph
from pianta.io._files import one_line_reason
from pianta.labels import SCHEMAS, standard_name
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta_bench.data.annotated_floors import AnnotatedFloor, read_annotated_buildings
from pianta_bench.harness.table import Row

SYNTHETIC = "synthetic"
SETS = ("school", "office", SYNTHETIC)
SYNTHETIC_SEEDS = range(3)
# A label is looked for where at most so many rooms have it, and at least so many floors of other buildings.
MOST_ROOMS, LEAST_OTHERS = 2, 4
# What robots start in, or are in all the time, is not looked for.
WAYS = (*CORRIDOR_LABELS, "ENTRANCE")


@dataclass(frozen=True, eq=False)
class ExploredBuilding:
    """A floor to explore.

    kind: its set. others: the floors of all other buildings of its type as a model takes them, none where these are too
    few. labels: those to look for.
    """

    kind: str
    name: str
    floor: Floor
    others: tuple[nx.Graph, ...] = ()
    labels: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class BuildingSet:
    """The buildings of a set. failed: what cannot be read. unmodelled: what no model takes, and why."""

    buildings: tuple[ExploredBuilding, ...]
    failed: tuple[Row, ...] = ()
    unmodelled: tuple[Row, ...] = ()


def check_sets(names: Sequence[str]) -> tuple[str, ...]:
    """The names without doubles, all of SETS for none; raises OptionError for others."""
    for name in names:
        if name not in SETS:
            raise OptionError(f"set is {name!r}, give one of {', '.join(SETS)}")
    return tuple(name for name in SETS if name in names or not names)


def make_buildings() -> BuildingSet:
    """Synthetic floors of each kind; no model fits their labels."""
    return BuildingSet(
        tuple(
            ExploredBuilding(SYNTHETIC, f"{kind}-{seed}", make_floor(kind, seed=seed))
            for kind in FLOOR_MAKERS
            for seed in SYNTHETIC_SEEDS
        )
    )


def read_buildings(data: Path, kind: str) -> BuildingSet:
    """The floors of data/buildings/KIND/*.xml.

    Floors in several parts, or with labels that the type does not have, are explored, but no model learns from them.
    Raises DataError where there is no floor, or none can be read.
    """
    drawn, failed = read_annotated_buildings(data, kind, lambda floor: floor)
    if not drawn:
        raise DataError(f"no floor of {kind}s can be read, the first: {failed[0].item}, {failed[0].failure}")
    graphs, unmodelled = {}, []
    for floor in drawn:
        try:
            graph = floor.floor.graph()
            graph.graph["source"] = floor.item
            graphs[floor.item] = prepare_room_graph(graph, SCHEMAS[kind])
        except PiantaError as error:
            unmodelled.append(Row(floor.item, {}, one_line_reason(error)))
    buildings = []
    for floor in drawn:
        others = [other for other in drawn if other.building != floor.building]
        known = tuple(graphs[other.item] for other in others if other.item in graphs)
        labels = choose_labels(floor, others)
        usable = known if len(known) >= MIN_FLOORS else ()
        buildings.append(ExploredBuilding(kind, floor.item, floor.floor, usable, labels))
    return BuildingSet(tuple(buildings), failed, tuple(unmodelled))


def choose_labels(floor: AnnotatedFloor, others: Sequence[AnnotatedFloor]) -> tuple[str, ...]:
    """Labels worth a search: of one or two rooms of a floor, and on some of the others; sorted."""
    here = list_labels(floor.floor)
    elsewhere = [label for other in others for label in {*list_labels(other.floor)}]
    return tuple(
        label
        for label in sorted({*here} - {*WAYS})
        if here.count(label) <= MOST_ROOMS and elsewhere.count(label) >= LEAST_OTHERS
    )


def list_labels(floor: Floor) -> list[str]:
    """The labels of the rooms in standard form; those that are none are left out."""
    labels = []
    for room in floor.rooms:
        try:
            labels += [standard_name(room.label)] if room.label else []
        except LabelError:
            continue
    return labels
