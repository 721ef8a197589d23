"""What the labels of rooms look like in pictures: fills, inks, shapes, and the entries of a legend."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from pianta.floor import Floor, Room
from pianta.labels import FCES, FCES_COLORS, RC, SCHEMAS, General, Label, LabelSchema, LabelSet, Split

# Label schemas by building type.
Schemas: TypeAlias = Mapping[str, LabelSchema]

# Labels that a coarse label set has, as the colours of the schema of schools show them.
COARSE_COLORS: Mapping[str, str] = MappingProxyType(
    {
        **{str(function): color for function, color in FCES_COLORS.items()},
        RC.ROOM: FCES_COLORS[FCES.FUNCTIONAL],
        RC.CORRIDOR: FCES_COLORS[FCES.CONNECTION],
        General.CORRIDOR: FCES_COLORS[FCES.CONNECTION],
        General.HALL: "#bf5719",
        General.SMALL: "#3fbf04",
        General.MEDIUM: "#2a90f2",
        General.BIG: "#2267f2",
    }
)
NEUTRAL_COLOR, DARK_INK, LIGHT_INK = "#ffffff", "#222222", "#ffffff"
# A fill lets this share of its colour through on white, so that the map is seen; that of a partial room less.
OPACITY, PARTIAL_OPACITY = 0.75, 0.4
# A label below this probability is shown as uncertain.
CERTAIN_FROM = 0.6
CORRIDOR_LABELS = frozenset({RC.CORRIDOR, FCES.CONNECTION, General.CORRIDOR, General.HALL})


@dataclass(frozen=True)
class RoomStyle:
    """How a room with its label is drawn.

    color: #rrggbb of the label, of its function where no schema knows it, white where nobody said.
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
    """A label of a floor: its name, None for rooms without one; its style; the ids of its rooms."""

    label: str | None
    style: RoomStyle
    room_ids: tuple[int, ...]


def style_rooms(floor: Floor, schemas: Schemas = SCHEMAS) -> dict[int, RoomStyle]:
    """The style of each room by its id, in the colours and shapes of the thesis (Figs. 5.2 and 5.3)."""
    of_floor = _schemas_of(floor, schemas)
    return {room.id: _style_room(room, of_floor, schemas) for room in floor.rooms}


def list_labels(floor: Floor, schemas: Schemas = SCHEMAS) -> list[LegendEntry]:
    """The labels that rooms of a floor have: in the schema's order, then others by name, rooms without one last."""
    order = {label.name: number for schema in _schemas_of(floor, schemas) for number, label in enumerate(schema.labels)}
    styles = style_rooms(floor, schemas)
    rooms_of: defaultdict[tuple[str | None, str], list[int]] = defaultdict(list)
    for room in floor.rooms:
        rooms_of[room.label, styles[room.id].color].append(room.id)
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
    types = sorted(floor.building_type, key=lambda building_type: -floor.building_type[building_type])
    types += sorted({label_set for room in floor.rooms for label_set in room.labels})
    known = dict.fromkeys(building_type.lower() for building_type in types)
    return [schemas[building_type] for building_type in known if building_type in schemas]


def _style_room(room: Room, of_floor: list[LabelSchema], schemas: Schemas) -> RoomStyle:
    label = next((known for schema in of_floor if (known := schema.by_name.get(room.label or ""))), None)
    probability = room.label_probability
    return RoomStyle(
        color=_color_of_label(room, label, schemas),
        opacity=PARTIAL_OPACITY if room.partial else OPACITY,
        is_corridor=_is_corridor(room, label),
        is_uncertain=probability is not None and probability < CERTAIN_FROM,
    )


def _color_of_label(room: Room, label: Label | None, schemas: Schemas) -> str:
    """The colour in the schema, or of F/C/E/S, or of the function that the label has in every schema that knows it."""
    if room.label is None:
        return NEUTRAL_COLOR
    if label is not None:
        return label.color
    coarse = room.labels.get(LabelSet.F_C_E_S, room.label)
    functions = {schema.by_name[room.label].in_f_c_e_s() for schema in schemas.values() if room.label in schema.by_name}
    if coarse not in COARSE_COLORS and len(functions) == 1:
        coarse = functions.pop()
    return COARSE_COLORS.get(coarse, NEUTRAL_COLOR)


def _is_corridor(room: Room, label: Label | None) -> bool:
    """Whether it is CORRIDOR in R/C: as the room says, else by the schema as in the graphs of chapter 5."""
    said = room.labels.get(LabelSet.R_C)
    if said is None and label is not None:
        said = label.in_r_c(Split.GRAPHS)
    return (said or room.labels.get(LabelSet.F_C_E_S) or room.label) in CORRIDOR_LABELS


def _luminance(color: str) -> float:
    """Relative luminance of #rrggbb, 0 to 1 (WCAG 2)."""
    shares = [part / 255 for part in bytes.fromhex(color[1:])]
    linear = [share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))
