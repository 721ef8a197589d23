"""Labels of rooms in R/C or F/C/E/S: manual ones mapped up from finer sets, predicted ones for all other rooms."""

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
    """A floor all of whose rooms have a label in one coarse label set, and no other label.

    predicted: the ids of the rooms whose label is not manual, but predicted now or when the floor was read.
    """

    floor: Floor
    predicted: tuple[int, ...]


def fill_missing_labels(
    floor: Floor,
    label_set: LabelSet,
    *,
    schemas: Mapping[str, LabelSchema] = SCHEMAS,
    labelled: Sequence[Room] | None = None,
) -> CoarseFloor:
    """The floor with a label of each room in a label set, R/C or F/C/E/S, by the convention of the experiments.

    Manual labels are mapped upwards by the schema of the floor's building type; if that lacks them, by all others if
    these agree. Rooms without such a label keep their predicted one, or get one by label_rooms.
    labelled: the rooms as label_rooms labels them, if these are at hand.
    """
    name = str(label_set)
    manual = {room.id: _map_manual_label(room, floor, label_set, schemas) for room in floor.rooms}
    labels = {room.id: manual[room.id] or room.labels.get(name) for room in floor.rooms}
    if not all(labels.values()):
        predicted = labelled or label_rooms(replace(floor, building_type={})).rooms
        by_id = {room.id: room.labels[name] for room in predicted}
        labels = {room_id: label or by_id[room_id] for room_id, label in labels.items()}
    rooms = tuple(
        replace(room, label=labels[room.id], labels={name: str(labels[room.id])}, label_probabilities={})
        for room in floor.rooms
    )
    return CoarseFloor(replace(floor, rooms=rooms), tuple(room.id for room in floor.rooms if manual[room.id] is None))


def _map_manual_label(room: Room, floor: Floor, label_set: LabelSet, schemas: Mapping[str, LabelSchema]) -> str | None:
    """The manual label of a room, mapped to a label set; None if it has none, or no schema has it."""
    if not has_manual_label(room):
        # Predicted labels always have probabilities.
        return None if room.label_probabilities else room.labels.get(str(label_set))
    name = normalize_label(room.label) or ""
    if name in LABELS[label_set]:
        return name
    if label_set is LabelSet.R_C and name in LABELS[LabelSet.F_C_E_S]:
        return str(RC.CORRIDOR if name == FCES.CONNECTION else RC.ROOM)
    own = [schemas[each] for each in floor.building_types if each in schemas and name in schemas[each].by_name]
    candidates = own[:1] or [schema for schema in schemas.values() if name in schema.by_name]
    mapped = {str(schema.map_labels([name], label_set)[0]) for schema in candidates}
    return mapped.pop() if len(mapped) == 1 else None


def list_labels(rooms: Iterable[Room], label_set: LabelSet) -> list[str]:
    """The label of each room in a label set.

    Raises LabelError that lists the rooms without a label, or with one of another set.
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
    """The floor with each room's label, one of a schema, mapped up to F/C/E/S and R/C.

    Raises LabelError that lists the labels that the schema lacks.
    """
    names = [room.label for room in floor.rooms]
    sets = (LabelSet.R_C, LabelSet.F_C_E_S)
    mapped = zip(*(schema.map_labels(names, label_set, convention=convention) for label_set in sets), strict=True)
    rooms = [
        replace(room, labels=dict(zip(map(str, sets), map(str, labels), strict=True)))
        for room, labels in zip(floor.rooms, mapped, strict=True)
    ]
    return replace(floor, rooms=tuple(rooms))
