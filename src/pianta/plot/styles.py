"""What the labels of rooms look like in pictures: fills, inks, shapes, and the entries of a legend."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

import numpy as np
from shapely import STRtree

from pianta.floor import PREDICTED_FLAG, Floor, Room
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

# Colours of the labels of coarse label sets, after those of the schema of schools.
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
# Colours of functions that also differ for people without cones of one kind. Without red cones the teal of an entrance
# in FCES_COLORS looks like the grey of service; tests/test_view_colours.py measures the differences.
FUNCTION_COLORS: Mapping[FCES, str] = MappingProxyType({**FCES_COLORS, FCES.ENTRANCE: "#2f3ea8"})
# Fill of rooms without a known label.
NEUTRAL_COLOR = "#ffffff"
DARK_INK = "#222222"
LIGHT_INK = "#ffffff"
# Outlines of rooms, and edges of graphs.
EDGE_COLOR = "#555555"
# Opacity of fills, so that the map shows through; of partial rooms it is lower.
OPACITY = 0.75
PARTIAL_OPACITY = 0.4
# Opacity of fills of rooms that were only predicted.
PREDICTED_OPACITY = 0.25
# Labels of lower probability are marked as uncertain; chosen by hand.
CERTAIN_FROM = 0.6
# Functions by coarse label.
_FUNCTIONS: Mapping[str, FCES] = MappingProxyType(
    {
        **{str(function): function for function in FCES},
        RC.ROOM: FCES.FUNCTIONAL,
        **dict.fromkeys((RC.CORRIDOR, GeneralLabel.CORRIDOR, GeneralLabel.HALL), FCES.CONNECTION),
    }
)
CORRIDOR_LABELS = frozenset({RC.CORRIDOR, FCES.CONNECTION, GeneralLabel.CORRIDOR, GeneralLabel.HALL})
# Paul Tol's "light" scheme, made for areas with dark labels and for colour-blind readers.
ROOM_COLORS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#ccaadd")
# Rooms no farther apart are neighbours, m: the thickest wall between two rooms.
NEIGHBOUR_DISTANCE = 0.5


@dataclass(frozen=True)
class RoomStyle:
    """How a room with its label is drawn.

    color: #rrggbb of the label; of its function if no schema has the label; white if that is unknown too.
    opacity: of the colour over the map.
    is_corridor: whether its node in a graph is a square.
    is_uncertain: whether its label has a probability below CERTAIN_FROM.
    function: what the room is for, of which a room of any use has that of most rooms; None if that is unknown.
    """

    color: str
    opacity: float = OPACITY
    is_corridor: bool = False
    is_uncertain: bool = False
    function: FCES | None = None

    @property
    def fill(self) -> str:
        """The colour as it looks on white."""
        channels = (round(255 + self.opacity * (channel - 255)) for channel in bytes.fromhex(self.color[1:]))
        return f"#{bytes(channels).hex()}"

    @property
    def ink(self) -> str:
        """The colour of text, dark or white, with the better contrast to the fill."""
        luminance = _luminance(self.fill)
        # Contrast as WCAG 2 defines it.
        dark = (luminance + 0.05) / (_luminance(DARK_INK) + 0.05)
        light = (_luminance(LIGHT_INK) + 0.05) / (luminance + 0.05)
        return DARK_INK if dark >= light else LIGHT_INK


class LegendEntry(NamedTuple):
    """A label of a floor, None for rooms without one; its colour; the ids of its rooms."""

    label: str | None
    color: str
    room_ids: tuple[int, ...]


def style_rooms(floor: Floor, schemas: Schemas = SCHEMAS) -> dict[int, RoomStyle]:
    """The style of each room by its id, in the colours and shapes of the thesis (Figs. 5.2 and 5.3)."""
    floor_schemas = _list_schemas(floor, schemas)
    return {room.id: _style_room(room, floor_schemas, schemas) for room in floor.rooms}


def list_labels(floor: Floor, schemas: Schemas = SCHEMAS) -> list[LegendEntry]:
    """The labels of a floor: in the order of the schemas, then other labels by name, then rooms without a label."""
    floor_schemas = _list_schemas(floor, schemas)
    order = {label.name: index for schema in floor_schemas for index, label in enumerate(schema.labels)}
    styles = style_rooms(floor, schemas)
    room_ids: defaultdict[tuple[str | None, str], list[int]] = defaultdict(list)
    for room in floor.rooms:
        label = _find_label(room, floor_schemas)
        room_ids[label.name if label else room.label, styles[room.id].color].append(room.id)
    entries = [LegendEntry(label, color, tuple(sorted(ids))) for (label, color), ids in room_ids.items()]

    def rank(entry: LegendEntry) -> tuple[bool, int, str, str]:
        name = entry.label or ""
        return entry.label is None, order.get(name, len(order)), name, entry.color

    return sorted(entries, key=rank)


def _list_schemas(floor: Floor, schemas: Schemas) -> list[LabelSchema]:
    """Schemas of the floor's building types, the most probable first, then of the label sets of its rooms."""
    label_sets = sorted({label_set.lower() for room in floor.rooms for label_set in room.labels})
    names = dict.fromkeys([*floor.building_types, *label_sets])
    return [schemas[name] for name in names if name in schemas]


def _find_label(room: Room, floor_schemas: list[LabelSchema]) -> Label | None:
    """The label of a room in the first schema that has it, in any case of letters."""
    name = normalize_label(room.label)
    return next((schema.by_name[name] for schema in floor_schemas if name in schema.by_name), None) if name else None


def _style_room(room: Room, floor_schemas: list[LabelSchema], schemas: Schemas) -> RoomStyle:
    """How a room is drawn by its label; floor_schemas: those of its floor. schemas: all, for other labels."""
    name, label = normalize_label(room.label) or "", _find_label(room, floor_schemas)
    coarse = _coarsen(name, room, label, schemas)
    color = label.color if label else COARSE_COLORS.get(coarse, NEUTRAL_COLOR)
    probability = room.label_probability
    return RoomStyle(
        color=color if name else NEUTRAL_COLOR,
        opacity=_find_opacity(room),
        is_corridor=room.labels.get(LabelSet.R_C, coarse) in CORRIDOR_LABELS,
        is_uncertain=probability is not None and probability < CERTAIN_FROM,
        function=_FUNCTIONS.get(coarse),
    )


def _find_opacity(room: Room) -> float:
    if room.flag == PREDICTED_FLAG:
        return PREDICTED_OPACITY
    return PARTIAL_OPACITY if room.partial else OPACITY


def _coarsen(name: str, room: Room, label: Label | None, schemas: Schemas) -> str:
    """The coarse label of a room: its own in F/C/E/S, else that of its label in the convention of the experiments.

    name: its normalized label. If no schema of its floor has the label, it gets the function that it has in all other
    schemas; the name itself if they disagree or none has it.
    """
    if LabelSet.F_C_E_S in room.labels or (label is None and name in COARSE_COLORS):
        return room.labels.get(LabelSet.F_C_E_S, name)
    labels = [label] if label else [schema.by_name[name] for schema in schemas.values() if name in schema.by_name]
    functions = {str(each.function_in(LabelConvention.EXPERIMENTS)) for each in labels}
    return functions.pop() if len(functions) == 1 else name


def _luminance(color: str) -> float:
    """Relative luminance of #rrggbb, 0 to 1 (WCAG 2)."""
    channels = [channel / 255 for channel in bytes.fromhex(color[1:])]
    linear = [value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4 for value in channels]
    return sum(weight * value for weight, value in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def color_neighbours(rooms: Sequence[Room]) -> list[str]:
    """A colour for each room: the least used that no neighbour has; rooms with the most neighbours come first."""
    polygons = np.array([room.polygon for room in rooms], dtype=object)
    first, second = STRtree(polygons).query(polygons, predicate="dwithin", distance=NEIGHBOUR_DISTANCE)
    neighbours = [second[first == index] for index in range(len(rooms))]
    colors = [""] * len(rooms)
    for index in sorted(range(len(rooms)), key=lambda index: -len(neighbours[index])):
        nearby = {colors[other] for other in neighbours[index]}
        counts = Counter(colors)
        colors[index] = min(ROOM_COLORS, key=lambda color: (color in nearby, counts[color]))
    return colors
