"""Labels of rooms in R/C or F/C/E/S, as people have given them, or as pianta finds them where nobody has."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

from pianta.errors import LabelError
from pianta.floor import Floor, Room
from pianta.io._faults import join_faults
from pianta.labels import FCES, RC, SCHEMAS, LabelConvention, LabelSchema, LabelSet, normalize_label
from pianta.rooms.label import label_rooms
from pianta.rooms.model import has_manual_label

# The label sets by which buildings are compared.
LABELS: Mapping[LabelSet, tuple[str, ...]] = MappingProxyType(
    {LabelSet.R_C: tuple(map(str, RC)), LabelSet.F_C_E_S: tuple(map(str, FCES))}
)


@dataclass(frozen=True)
class CoarseFloor:
    """A floor all of whose rooms have a label in one label set, and no other.

    found: the ids of the rooms whose label pianta has found, now or when it read the floor; nobody has given it.
    """

    floor: Floor
    found: tuple[int, ...]


def fill_missing_labels(
    floor: Floor,
    label_set: LabelSet,
    *,
    schemas: Mapping[str, LabelSchema] = SCHEMAS,
    found: Sequence[Room] | None = None,
) -> CoarseFloor:
    """The floor with a label of each room in a label set, R/C or F/C/E/S, split as in the thesis' experiments.

    What somebody has given is mapped upwards, by the schema of the floor's building type where that has it, else by
    all others where these agree. Rooms without such a label keep the one of pianta, or get one by label_rooms.
    found: the rooms as label_rooms has labelled them, where that is known already.
    """
    name = str(label_set)
    given = {room.id: _place_given(room, floor, label_set, schemas) for room in floor.rooms}
    missing = [room for room in floor.rooms if given[room.id] is None and name not in room.labels]
    read = {room.id: room.labels.get(name) for room in floor.rooms}
    if missing:
        labelled = {room.id: room.labels[name] for room in found or label_rooms(replace(floor, building_type={})).rooms}
        read |= {room.id: labelled[room.id] for room in missing}
    labels = {room.id: given[room.id] or str(read[room.id]) for room in floor.rooms}
    rooms = tuple(
        replace(room, label=labels[room.id], labels={name: labels[room.id]}, label_probabilities={})
        for room in floor.rooms
    )
    by_pianta = tuple(room.id for room in floor.rooms if given[room.id] is None)
    return CoarseFloor(replace(floor, rooms=rooms), by_pianta)


def _place_given(room: Room, floor: Floor, label_set: LabelSet, schemas: Mapping[str, LabelSchema]) -> str | None:
    """Where the label that somebody gave a room lies in a label set; None for no label, and one that nobody knows."""
    if not has_manual_label(room):
        # Labels that say nothing of probabilities are no finding of pianta.
        return None if room.label_probabilities else room.labels.get(str(label_set))
    name = normalize_label(room.label) or ""
    if name in LABELS[label_set]:
        return name
    if label_set is LabelSet.R_C and name in LABELS[LabelSet.F_C_E_S]:
        return str(RC.CORRIDOR if name == FCES.CONNECTION else RC.ROOM)
    own = [schemas[kind] for kind in floor.building_types if kind in schemas and name in schemas[kind].by_name]
    knowing = own[:1] or [schema for schema in schemas.values() if name in schema.by_name]
    places = {
        str(schema.map_labels([name], label_set, convention=LabelConvention.EXPERIMENTS)[0]) for schema in knowing
    }
    return places.pop() if len(places) == 1 else None


def list_labels(rooms: Iterable[Room], label_set: LabelSet) -> list[str]:
    """The label of each room in a label set.

    Raises LabelError that lists the rooms that have none, or one that is not of the set.
    """
    rooms = list(rooms)
    labels = [room.labels.get(str(label_set)) or room.label for room in rooms]
    faults = [
        f"{room.id} ({label})" if label else str(room.id)
        for room, label in zip(rooms, labels, strict=True)
        if label not in LABELS[label_set]
    ]
    if faults:
        raise LabelError(f"rooms {join_faults(faults)} have no label in {label_set}, label them with label_rooms")
    return [str(label) for label in labels]


def map_labels_upwards(
    floor: Floor, schema: LabelSchema, *, convention: LabelConvention = LabelConvention.EXPERIMENTS
) -> Floor:
    """The floor with each room's given label, one of a schema, mapped up to F/C/E/S and R/C.

    Raises LabelError that lists the labels that the schema does not have.
    """
    given = [room.label for room in floor.rooms]
    sets = (LabelSet.R_C, LabelSet.F_C_E_S)
    mapped = zip(*(schema.map_labels(given, label_set, convention=convention) for label_set in sets), strict=True)
    rooms = [
        replace(room, labels=dict(zip(map(str, sets), map(str, labels), strict=True)))
        for room, labels in zip(floor.rooms, mapped, strict=True)
    ]
    return replace(floor, rooms=tuple(rooms))
