"""A floor as an interpretation: what is known of its rooms, as facts (thesis, section 6.1.2).

A relation is a signature and a Python function that finds its facts on a floor, so that users add their own.
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

Found = Iterable[tuple[Value, ...]]

_SIGNATURES = by_name(FLOOR_SIGNATURES)
ROOM, LABEL = _SIGNATURES["room"], _SIGNATURES["label"]
# The names of the real files, and ours, which are those of the thesis.
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
# The real files have these names for F/C/E/S as well.
_IN_FILES: dict[str, str] = {FCES.FUNCTIONAL: RC.ROOM, FCES.CONNECTION: RC.CORRIDOR}


@dataclass(frozen=True)
class Relation:
    """A signature, and the function that finds its facts on a floor.

    find: gives the arguments of each fact. A room is its id, an integer; the entities of other signatures and the
        properties are text or numbers. Where the signature is unordered, a pair may come once or in both orders.
    """

    signature: Signature
    find: Callable[[Floor], Found]


def find_building_type(floor: Floor) -> Found:
    """The most probable type of the building, when anybody said one."""
    return [(name.replace(" ", ""),) for name in floor.building_types[:1]]


def find_doors(floor: Floor) -> Found:
    """How many doors, openings and entrances each room has."""
    counts = Counter(room_id for door in floor.doors for room_id in door.room_ids)
    return [(room.id, counts[room.id]) for room in floor.rooms]


def find_entrances(floor: Floor) -> Found:
    """The rooms that a door joins to the outside."""
    return [(room_id,) for room_id in sorted({door.rooms[0] for door in floor.doors if door.is_entrance})]


def find_partial(floor: Floor) -> Found:
    """The rooms that touch space that nobody has seen."""
    return [(room.id,) for room in floor.rooms if room.partial]


def find_connected(floor: Floor) -> Found:
    """The pairs of rooms that one or more doors or openings join."""
    return sorted({door.room_ids for door in floor.doors if not door.is_entrance})


def find_shared_walls(floor: Floor) -> Found:
    """The pairs of rooms that lie on both sides of a wall, which is longer than a corner."""
    if not floor.rooms:
        return []
    unit = measure_unit(floor)
    walls = share_walls(draw_outlines(floor, unit), unit)
    ids = [room.id for room in floor.rooms]
    return [
        (ids[one], ids[other]) for one, other in zip(*((walls + walls.T) > 0).nonzero(), strict=True) if one < other
    ]


def _find_measure(name: str) -> Callable[[Floor], Found]:
    measure = GEOMETRIC[name]
    return lambda floor: [(room.id, measure(room.polygon)) for room in floor.rooms]


def _find_centrality(measure: Callable[..., Centrality]) -> Callable[[Floor], Found]:
    """As in Table 5.1: in the graph without isolated rooms, which have 0."""

    def find(floor: Floor) -> Found:
        values = measure(drop_isolated(floor.graph()))
        return [(room.id, float(values.get(room.id, 0.0))) for room in floor.rooms]

    return find


_FINDERS: dict[str, Callable[[Floor], Found]] = {
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

# Of these there are many on a floor, so that they come only when asked for.
ALIGNED = Relation(_SIGNATURES["aligned"], find_aligned)
SYMMETRIC = Relation(_SIGNATURES["symmetric"], find_symmetric)


def is_corridor(
    *, convention: LabelConvention = LabelConvention.EXPERIMENTS, schema: LabelSchema | None = None
) -> Relation:
    """The relation iscorr: the rooms that are a CORRIDOR in R/C.

    It tells of the labels, so that who learns these hides it as well. Options as in interpret_floor.
    """

    def find(floor: Floor) -> Found:
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
    label_set, convention: which labels; None tells no labels. Rooms without a label have no such fact.
    schema: where labels lie in the label set; that of the most probable building type when None.
    name: that of the interpretation; the floor's source when None, or "floor".

    Raises LabelError for labels whose place in the label set is unknown, RelationError for facts that contradict the
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
    """A label as the real files write it: BIG SERVICE is lbigservice, FUNCTIONAL is lroom, CONNECTION is lcorridor."""
    return "l" + "".join(_IN_FILES.get(label, label).lower().split())


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
    """Labels of rooms in a label set, by the schema; where it lacks a room's label, as the room itself says."""
    known = schema.by_name if schema else {}
    alone = {room.id: room.labels[label_set] for room in rooms if room.label not in known and label_set in room.labels}
    others = [room for room in rooms if room.id not in alone]
    if others and schema is None:
        raise LabelError(
            f"where {others[0].label!r} of room {others[0].id} lies in {label_set} is unknown without a building type "
            "that has a schema, give schema= or label_set=LabelSet.TYPE"
        )
    mapped = schema.map_labels([room.label for room in others], label_set, convention=convention) if schema else []
    by_id = alone | dict(zip([room.id for room in others], mapped, strict=True))
    return [by_id[room.id] for room in rooms]


def _make_facts(relation: Relation, floor: Floor, rooms: dict[int, str]) -> Iterator[Fact]:
    """Facts of a relation with atoms for rooms, each once."""
    signature = relation.signature
    found = _check_found(relation, floor, rooms)
    seen: set[tuple[Value, ...]] = set()
    for values in found:
        arguments = [
            rooms[int(value)] if argument.kind == ROOM.name else value
            for value, argument in zip(values, signature.arguments, strict=True)
        ]
        standard = signature.standard_arguments(arguments)
        if standard not in seen:
            yield Fact(signature.name, tuple(arguments))
        seen.add(standard)


def _check_found(relation: Relation, floor: Floor, rooms: Mapping[int, str]) -> list[tuple[Value, ...]]:
    """What a relation finds; raises RelationError, with all faults in one line, for what are no arguments of it."""
    name, count = relation.signature.name, len(relation.signature.arguments)
    try:
        found = [tuple(values) for values in relation.find(floor)]
    except TypeError as error:
        raise RelationError(f"{name} found no tuples of {count} values: {error}") from error
    faults = [f"{values!r}, give {count} values" for values in found if len(values) != count]
    kinds = [argument.kind for argument in relation.signature.arguments]
    given = (zip(values, kinds, strict=True) for values in found if len(values) == count)
    strange = dict.fromkeys(
        repr(value) for pairs in given for value, kind in pairs if kind == ROOM.name and value not in rooms
    )
    faults += [f"{value}, which is the id of no room of the floor" for value in strange]
    if faults:
        raise RelationError(f"{name} found {join_faults(faults)}")
    return found
