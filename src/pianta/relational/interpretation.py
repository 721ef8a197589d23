"""A floor as an interpretation: facts about its rooms (thesis, section 6.1.2).

A relation is a signature and a Python function that finds its facts on a floor, so that users can add their own.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from pianta.errors import LabelError, RelationError
from pianta.floor import Floor, Room
from pianta.graphs.centrality import Centrality, drop_isolated, measure_betweenness, measure_closeness
from pianta.io._faults import join_faults
from pianta.labels import FCES, RC, SCHEMAS, LabelConvention, LabelSchema, LabelSet
from pianta.relational.facts import (
    FLOOR_SIGNATURES,
    Fact,
    Interpretation,
    Signature,
    Value,
    by_name,
    check_interpretation,
)
from pianta.relational.room_relations import find_aligned, find_symmetric
from pianta.rooms._outlines import draw_outlines, measure_unit
from pianta.rooms._surroundings import share_walls
from pianta.rooms.thesis_features import GEOMETRIC

# The arguments of each fact of a relation.
Arguments = Iterable[tuple[Value, ...]]

_SIGNATURES = by_name(FLOOR_SIGNATURES)
ROOM, LABEL = _SIGNATURES["room"], _SIGNATURES["label"]
# Measures by their names in the authors' files; the names here are those of the thesis.
_GEOMETRIC = {
    "area": "area",
    "perimeter": "perimeter",
    "aoverp": "area_over_perimeter",
    "adcs": "mean_distance",
    "ff": "form_factor",
    "circularity": "circularity",
    "normalcirc": "normalised_circularity",
    "andcs": "normalised_mean_distance",
}
# The authors' files use these names for F/C/E/S as well.
_FILE_LABELS: dict[str, str] = {FCES.FUNCTIONAL: RC.ROOM, FCES.CONNECTION: RC.CORRIDOR}


@dataclass(frozen=True)
class Relation:
    """A signature, and the function that finds its facts on a floor.

    find: gives the arguments of each fact. A room is its integer id; other entities and properties are text or numbers.
        For an unordered signature a pair may come once or in both orders.
    """

    signature: Signature
    find: Callable[[Floor], Arguments]


def find_building_type(floor: Floor) -> Arguments:
    """The most probable type of the building, if there is one."""
    return [(name.replace(" ", ""),) for name in floor.building_types[:1]]


def find_doors(floor: Floor) -> Arguments:
    """The number of doors, openings and entrances of each room."""
    counts = Counter(room_id for door in floor.doors for room_id in door.room_ids)
    return [(room.id, counts[room.id]) for room in floor.rooms]


def find_entrances(floor: Floor) -> Arguments:
    """The rooms that a door joins to the outside."""
    return [(room_id,) for room_id in sorted({door.rooms[0] for door in floor.doors if door.is_entrance})]


def find_partial(floor: Floor) -> Arguments:
    """The rooms that border on unobserved space."""
    return [(room.id,) for room in floor.rooms if room.partial]


def find_connected(floor: Floor) -> Arguments:
    """The pairs of rooms that one or more doors or openings join."""
    return sorted({door.room_ids for door in floor.doors if door.joins_rooms})


def find_shared_walls(floor: Floor) -> Arguments:
    """The pairs of rooms that share a wall longer than a corner."""
    if not floor.rooms:
        return []
    unit = measure_unit(floor)
    walls = share_walls(draw_outlines(floor, unit), unit)
    ids = [room.id for room in floor.rooms]
    return [
        (ids[one], ids[other]) for one, other in zip(*((walls + walls.T) > 0).nonzero(), strict=True) if one < other
    ]


def _find_measure(name: str) -> Callable[[Floor], Arguments]:
    measure = GEOMETRIC[name]
    return lambda floor: [(room.id, measure(room.polygon)) for room in floor.rooms]


def _find_centrality(measure: Callable[..., Centrality]) -> Callable[[Floor], Arguments]:
    """As in Table 5.1: in the graph without isolated rooms, whose value is 0."""

    def find(floor: Floor) -> Arguments:
        values = measure(drop_isolated(floor.graph()))
        return [(room.id, float(values.get(room.id, 0.0))) for room in floor.rooms]

    return find


_FINDERS: dict[str, Callable[[Floor], Arguments]] = {
    "buildingtype": find_building_type,
    **{name: _find_measure(feature) for name, feature in _GEOMETRIC.items()},
    "betwenness": _find_centrality(measure_betweenness),
    "closeness": _find_centrality(measure_closeness),
    "doors": find_doors,
    "entrance": find_entrances,
    "partial": find_partial,
    "connected": find_connected,
    "sharedwall": find_shared_walls,
}
FLOOR_RELATIONS: tuple[Relation, ...] = tuple(Relation(_SIGNATURES[name], find) for name, find in _FINDERS.items())

# Not part of FLOOR_RELATIONS, as they have many facts on each floor.
ALIGNED = Relation(_SIGNATURES["aligned"], find_aligned)
SYMMETRIC = Relation(_SIGNATURES["symmetric"], find_symmetric)


def is_corridor(
    *, convention: LabelConvention = LabelConvention.EXPERIMENTS, schema: LabelSchema | None = None
) -> Relation:
    """The relation iscorr: the rooms that are a CORRIDOR in R/C.

    It follows from the labels, so hide it if these are the target of learning. Options as in interpret_floor.
    """

    def find(floor: Floor) -> Arguments:
        labels = list_labels(floor, LabelSet.R_C, convention=convention, schema=schema)
        return [(room_id,) for room_id, label in labels if label == RC.CORRIDOR]

    return Relation(_SIGNATURES["iscorr"], find)


def interpret_floor(
    floor: Floor,
    *,
    relations: Iterable[Relation] = FLOOR_RELATIONS,
    label_set: LabelSet | None = LabelSet.TYPE,
    convention: LabelConvention = LabelConvention.EXPERIMENTS,
    schema: LabelSchema | None = None,
    name: str | None = None,
) -> Interpretation:
    """The facts of a floor: its rooms, `room(r12)`, those of all relations, then the labels, `label(r12,lcorridor)`.

    Measures are in metres. Labels are those of label_atom.
    relations: FLOOR_RELATIONS, and what users add, `(*FLOOR_RELATIONS, ALIGNED, Relation(signature, function))`.
    label_set, convention: which labels; None for no labels. Rooms without a label have no such fact.
    schema: maps labels to the label set; None for that of the most probable building type.
    name: of the interpretation; None for the floor's source, or "floor" without one.

    Raises LabelError for labels that cannot be mapped to the label set, RelationError for facts that contradict the
    signatures and for rooms that are not on the floor.
    """
    relations = list(relations)
    signatures = (*by_name([ROOM, *(relation.signature for relation in relations), LABEL]).values(),)
    rooms = {room.id: f"r{room.id}" for room in floor.rooms}
    facts = [Fact(ROOM.name, (atom,)) for atom in rooms.values()]
    for relation in relations:
        facts += _make_facts(relation, floor, rooms)
    if label_set is not None:
        labels = list_labels(floor, label_set, convention=convention, schema=schema)
        facts += [Fact(LABEL.name, (rooms[room_id], label_atom(label))) for room_id, label in labels]
    interpretation = Interpretation(name or floor.source or "floor", tuple(facts))
    check_interpretation(interpretation, signatures)
    return interpretation


def label_atom(label: str) -> str:
    """A label as in the authors' files: lbigservice for BIG SERVICE, lroom for FUNCTIONAL, lcorridor for CONNECTION."""
    return "l" + "".join(_FILE_LABELS.get(label, label).lower().split())


def list_labels(
    floor: Floor,
    label_set: LabelSet,
    *,
    convention: LabelConvention = LabelConvention.EXPERIMENTS,
    schema: LabelSchema | None = None,
) -> list[tuple[int, str]]:
    """Room ids and labels in a label set, of the rooms that have a label; options and errors as in interpret_floor."""
    rooms = [room for room in floor.rooms if room.label is not None]
    if label_set is LabelSet.TYPE:
        return [(room.id, str(room.label)) for room in rooms]
    schema = schema or next((SCHEMAS[name] for name in floor.building_types[:1] if name in SCHEMAS), None)
    return [
        (room.id, str(label))
        for room, label in zip(rooms, _map_labels(rooms, label_set, convention, schema), strict=True)
    ]


def _map_labels(
    rooms: Sequence[Room], label_set: LabelSet, convention: LabelConvention, schema: LabelSchema | None
) -> Sequence[str]:
    """Labels of rooms in a label set, by the schema; for a label that it lacks, the room's own label in that set."""
    names = schema.by_name if schema else {}
    own = {room.id: room.labels[label_set] for room in rooms if room.label not in names and label_set in room.labels}
    others = [room for room in rooms if room.id not in own]
    if others and schema is None:
        raise LabelError(
            f"where {others[0].label!r} of room {others[0].id} lies in {label_set} is unknown without a building type "
            "that has a schema, give schema= or label_set=LabelSet.TYPE"
        )
    mapped = schema.map_labels([room.label for room in others], label_set, convention=convention) if schema else []
    by_id = own | dict(zip([room.id for room in others], mapped, strict=True))
    return [by_id[room.id] for room in rooms]


def _make_facts(relation: Relation, floor: Floor, rooms: dict[int, str]) -> Iterator[Fact]:
    """The different facts of a relation, with atoms for rooms."""
    signature = relation.signature
    facts: set[tuple[Value, ...]] = set()
    for values in _find_arguments(relation, floor, rooms):
        arguments = [
            rooms[int(value)] if argument.kind == ROOM.name else value
            for value, argument in zip(values, signature.arguments, strict=True)
        ]
        standard = signature.standard_arguments(arguments)
        if standard not in facts:
            yield Fact(signature.name, tuple(arguments))
        facts.add(standard)


def _find_arguments(relation: Relation, floor: Floor, rooms: Mapping[int, str]) -> list[tuple[Value, ...]]:
    """The arguments that a relation finds; raises RelationError, with all faults in one line, for invalid ones."""
    name, count = relation.signature.name, len(relation.signature.arguments)
    try:
        arguments = [tuple(values) for values in relation.find(floor)]
    except TypeError as error:
        raise RelationError(f"{name} found no tuples of {count} values: {error}") from error
    faults = [f"{values!r}, give {count} values" for values in arguments if len(values) != count]
    unknown = dict.fromkeys(
        repr(value)
        for values in arguments
        if len(values) == count
        for value, argument in zip(values, relation.signature.arguments, strict=True)
        if argument.kind == ROOM.name and value not in rooms
    )
    faults += [f"{value}, which is the id of no room of the floor" for value in unknown]
    if faults:
        raise RelationError(f"{name} found {join_faults(faults)}")
    return arguments
