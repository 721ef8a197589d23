"""What the labels of rooms look like in pictures: fills, inks, shapes, and the entries of a legend."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from shapely import STRtree

from pianta.floor import Floor, Room
from pianta.labels import (
    FCES,
    FCES_COLORS,
    RC,
    SCHEMAS,
    GeneralLabel,
    Label,
    LabelConvention,
    LabelSchema,
    LabelSet,
    normalize_label,
)

# Label schemas by building type.
Schemas: TypeAlias = Mapping[str, LabelSchema]

# Labels that a coarse label set has, as the colours of the schema of schools show them.
COARSE_COLORS: Mapping[str, str] = MappingProxyType(
    {
        **{str(function): color for function, color in FCES_COLORS.items()},
        RC.ROOM: FCES_COLORS[FCES.FUNCTIONAL],
        RC.CORRIDOR: FCES_COLORS[FCES.CONNECTION],
        GeneralLabel.CORRIDOR: FCES_COLORS[FCES.CONNECTION],
        GeneralLabel.HALL: "#bf5719",
        GeneralLabel.SMALL: "#3fbf04",
        GeneralLabel.MEDIUM: "#2a90f2",
        GeneralLabel.BIG: "#2267f2",
    }
)
NEUTRAL_COLOR, DARK_INK, LIGHT_INK = "#ffffff", "#222222", "#ffffff"
# A fill lets this share of its colour through on white, so that the map is seen; that of a partial room less.
OPACITY, PARTIAL_OPACITY = 0.75, 0.4
# A label below this probability is shown as uncertain.
CERTAIN_FROM = 0.6
CORRIDOR_LABELS = frozenset({RC.CORRIDOR, FCES.CONNECTION, GeneralLabel.CORRIDOR, GeneralLabel.HALL})
# Paul Tol's "light" scheme, made for areas with dark labels and for colour-blind readers.
ROOM_COLORS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#ccaadd")
# Rooms no further apart, m, are neighbours: the thickest wall between two rooms.
NEIGHBOUR_DISTANCE = 0.5


@dataclass(frozen=True)
class RoomStyle:
    """How a room with its label is drawn.

    color: #rrggbb of the label, of its function where no schema knows it, white if unknown.
    opacity: with which the colour covers what lies below.
    is_corridor: whether it is a square in the graph.
    is_uncertain: whether its label has a probability below 0.6.
    """

    color: str
    opacity: float = OPACITY
    is_corridor: bool = False
    is_uncertain: bool = False

    @property
    def fill(self) -> str:
        """The colour as it looks on white."""
        parts = (round(255 + self.opacity * (part - 255)) for part in bytes.fromhex(self.color[1:]))
        return f"#{bytes(parts).hex()}"

    @property
    def ink(self) -> str:
        """The colour, dark or white, that is read best on the fill."""
        luminance = _luminance(self.fill)
        # Contrast as WCAG 2 defines it.
        dark = (luminance + 0.05) / (_luminance(DARK_INK) + 0.05)
        light = (_luminance(LIGHT_INK) + 0.05) / (luminance + 0.05)
        return DARK_INK if dark >= light else LIGHT_INK


@dataclass(frozen=True)
class LegendEntry:
    """A label of a floor: its name as in its schema, None for rooms without one; its style; the ids of its rooms."""

    label: str | None
    style: RoomStyle
    room_ids: tuple[int, ...]


def style_rooms(floor: Floor, schemas: Schemas = SCHEMAS) -> dict[int, RoomStyle]:
    """The style of each room by its id, in the colours and shapes of the thesis (Figs. 5.2 and 5.3)."""
    of_floor = _schemas_of(floor, schemas)
    return {room.id: _style_room(room, of_floor, schemas) for room in floor.rooms}


def list_labels(floor: Floor, schemas: Schemas = SCHEMAS) -> list[LegendEntry]:
    """The labels that rooms of a floor have: in the schema's order, then others by name, rooms without one last."""
    of_floor = _schemas_of(floor, schemas)
    order = {label.name: number for schema in of_floor for number, label in enumerate(schema.labels)}
    styles = style_rooms(floor, schemas)
    rooms_of: defaultdict[tuple[str | None, str], list[int]] = defaultdict(list)
    for room in floor.rooms:
        known = _find_label(room, of_floor)
        rooms_of[known.name if known else room.label, styles[room.id].color].append(room.id)
    entries = [LegendEntry(label, RoomStyle(color), tuple(sorted(ids))) for (label, color), ids in rooms_of.items()]
    return sorted(
        entries,
        key=lambda entry: (
            entry.label is None,
            order.get(entry.label or "", len(order)),
            entry.label or "",
            entry.style.color,
        ),
    )


def _schemas_of(floor: Floor, schemas: Schemas) -> list[LabelSchema]:
    """Schemas of the floor's building types, the most probable first, then of the label sets that rooms have."""
    label_sets = sorted({label_set.lower() for room in floor.rooms for label_set in room.labels})
    names = dict.fromkeys([*floor.building_types, *label_sets])
    return [schemas[name] for name in names if name in schemas]


def _find_label(room: Room, of_floor: list[LabelSchema]) -> Label | None:
    """The label of a room in the first schema that has it, in whatever case somebody gave it."""
    name = normalize_label(room.label)
    return next((schema.by_name[name] for schema in of_floor if name in schema.by_name), None) if name else None


def _style_room(room: Room, of_floor: list[LabelSchema], schemas: Schemas) -> RoomStyle:
    name, label = normalize_label(room.label) or "", _find_label(room, of_floor)
    coarse = _coarsen(name, room, label, schemas)
    color = label.color if label else COARSE_COLORS.get(coarse, NEUTRAL_COLOR)
    probability = room.label_probability
    return RoomStyle(
        color=color if name else NEUTRAL_COLOR,
        opacity=PARTIAL_OPACITY if room.partial else OPACITY,
        is_corridor=room.labels.get(LabelSet.R_C, coarse) in CORRIDOR_LABELS,
        is_uncertain=probability is not None and probability < CERTAIN_FROM,
    )


def _coarsen(name: str, room: Room, label: Label | None, schemas: Schemas) -> str:
    """Where a room lies in a coarse label set: as it says, else in that of the experiments, where label_rooms puts it.

    name: of its label, in capitals; what no schema of its floor knows has the function that it has in all others.
    """
    if LabelSet.F_C_E_S in room.labels or (label is None and name in COARSE_COLORS):
        return room.labels.get(LabelSet.F_C_E_S, name)
    labels = [label] if label else [schema.by_name[name] for schema in schemas.values() if name in schema.by_name]
    functions = {str(known.function_in(LabelConvention.EXPERIMENTS)) for known in labels}
    return functions.pop() if len(functions) == 1 else name


def _luminance(color: str) -> float:
    """Relative luminance of #rrggbb, 0 to 1 (WCAG 2)."""
    shares = [part / 255 for part in bytes.fromhex(color[1:])]
    linear = [share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def color_neighbours(rooms: Sequence[Room]) -> list[str]:
    """A colour for each room: the least used that no neighbour has; rooms with the most neighbours choose first."""
    polygons = np.array([room.polygon for room in rooms], dtype=object)
    first, second = STRtree(polygons).query(polygons, predicate="dwithin", distance=NEIGHBOUR_DISTANCE)
    neighbours = [second[first == index] for index in range(len(rooms))]
    colors = [""] * len(rooms)
    for index in sorted(range(len(rooms)), key=lambda index: -len(neighbours[index])):
        near = {colors[other] for other in neighbours[index]}
        used = Counter(colors)
        colors[index] = min(ROOM_COLORS, key=lambda color: (color in near, used[color]))
    return colors
