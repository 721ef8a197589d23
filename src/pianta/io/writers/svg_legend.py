"""The legend of a drawing as SVG: a scale bar, the colours of the labels of rooms, and the signs of doors."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from math import log10
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

from pianta.building import Building
from pianta.floor import Floor, Room
from pianta.floor.area_trust import AreaTrust
from pianta.labels import ALL_SCHEMAS, FCES, FCES_COLORS, RC, LabelConvention, LabelSet, normalize_label

# Metres on the drawing, which is at 1:100.
LETTERS = 0.3
LETTER_WIDTH = 0.6 * LETTERS  # of sans-serif letters on average, rounded up
SAMPLE = 0.6  # width of the sign before a text
GAP = 0.2  # between a sign and its text; three of them between a text and the next sign
ROW = 0.6
LONGEST_LABEL = 40  # characters
TINT = 0.35  # opacity of the colours of labels on white, so that black texts and green doors stand out
INK = "#222222"
Styles = Mapping[str, Mapping[str, str]]
# Colours of labels that no building type has.
_COLORS = {
    **{str(function): color for function, color in FCES_COLORS.items()},
    str(RC.ROOM): FCES_COLORS[FCES.FUNCTIONAL],
    str(RC.CORRIDOR): FCES_COLORS[FCES.CONNECTION],
}


def find_tints(floor: Floor) -> dict[int, str]:
    """The fill of each room with a label, by its id: the colour of the label in its schema, else of its function."""
    colors = {room.id: _find_color(room, floor) for room in floor if room.label}
    return {room_id: _mix_with_white(color) for room_id, color in colors.items() if color}


class Sample(NamedTuple):
    """An entry: sign is "area", "line" or "door"."""

    sign: str
    style: Mapping[str, str]
    text: str


def draw_legend(
    building: Building, left_top: tuple[float, float], width: float, styles: Styles
) -> tuple[Element, float]:
    """The group `legend` of a drawing, and its height; left_top, width: its place, in units of the drawing.

    styles: by group of the drawing, whose signs are explained.
    """
    # Readers of drawings take no walls and doors from a group of this name
    group = Element("g", {"id": "legend", "fill": INK, "font-family": "sans-serif", "font-size": f"{LETTERS:g}"})
    left, top = left_top
    x, y = left + _draw_scale_bar(group, left, top, _round_length(width / 2), building.area_trust), top
    for sample in _list_samples(building, styles):
        entry = SAMPLE + GAP + len(sample.text) * LETTER_WIDTH
        if x + entry > left + width and x > left:
            x, y = left, y + ROW
        _draw_sample(group, sample, x, y)
        _add_text(group, sample.text, x + SAMPLE + GAP, y)
        x += entry + 3 * GAP
    return group, y + ROW - top


def _list_samples(building: Building, styles: Styles) -> Iterator[Sample]:
    """The labels of rooms, those of the most rooms first, then what else is drawn."""
    counts: Counter[tuple[str, str]] = Counter()
    for storey in building:
        tints = find_tints(storey.floor)
        counts.update(
            (" ".join(room.label.split())[:LONGEST_LABEL], tints.get(room.id, styles["rooms"]["fill"]))
            for room in storey.floor
            if room.label
        )
    for (label, tint), count in sorted(counts.items(), key=lambda item: (-item[1], item[0])):
        yield Sample("area", {**styles["rooms"], "fill": tint}, f"{label} ({count})")
    floors = [storey.floor for storey in building]
    kinds = {door.kind for floor in floors for door in floor.doors}
    if kinds - {"opening"}:
        yield Sample("door", styles["doors"], "door (side of its leaf unknown)")
    if "opening" in kinds:
        yield Sample("line", styles["openings"], "opening")
    if any(floor.furniture for floor in floors):
        yield Sample("area", styles["furniture"], "furniture")


def _draw_scale_bar(group: Element, left: float, top: float, length: float, area_trust: AreaTrust) -> float:
    """A bar of a length with its text; how much of the row it takes."""
    middle, half = top + ROW / 2, LETTERS / 3
    path = (
        f"M {left:g} {middle - half:g} V {middle + half:g} M {left:g} {middle:g} H {left + length:g} "
        f"M {left + length:g} {middle - half:g} V {middle + half:g}"
    )
    SubElement(group, "path", {"d": path, "fill": "none", "stroke": INK, "stroke-width": "0.04"})
    text = area_trust.mark_size(f"{length:g} m")
    _add_text(group, text, left + length + GAP, top)
    return length + GAP + len(text) * LETTER_WIDTH + 3 * GAP


def _draw_sample(group: Element, sample: Sample, left: float, top: float) -> None:
    middle, side = top + ROW / 2, LETTERS
    low = middle + side / 2
    path = {
        "area": f"M {left:g} {low:g} h {SAMPLE:g} v {-side:g} h {-SAMPLE:g} Z",
        "line": f"M {left:g} {middle:g} h {SAMPLE:g}",
        "door": f"M {left:g} {low:g} v {-side:g} a {side:g} {side:g} 0 0 1 {side:g} {side:g} Z",
    }[sample.sign]
    SubElement(group, "path", {**sample.style, "d": path})


def _add_text(group: Element, text: str, left: float, top: float) -> None:
    SubElement(group, "text", {"x": f"{left:g}", "y": f"{top + ROW / 2 + LETTERS / 3:g}"}).text = text


def _find_color(room: Room, floor: Floor) -> str | None:
    name = normalize_label(room.label) or ""
    schemas = [ALL_SCHEMAS[each] for each in floor.building_types if each in ALL_SCHEMAS]
    label = next((schema.by_name[name] for schema in schemas if name in schema.by_name), None)
    if label:
        return label.color
    if LabelSet.F_C_E_S in room.labels or name in _COLORS:
        return _COLORS.get(room.labels.get(LabelSet.F_C_E_S, name))
    # The function that the label has in all types of buildings, if it is one
    labels = [schema.by_name[name] for schema in ALL_SCHEMAS.values() if name in schema.by_name]
    functions = {each.function_in(LabelConvention.EXPERIMENTS) for each in labels}
    return FCES_COLORS[functions.pop()] if len(functions) == 1 else None


def _mix_with_white(color: str) -> str:
    channels = (round(255 + TINT * (channel - 255)) for channel in bytes.fromhex(color[1:]))
    return f"#{bytes(channels).hex()}"


def _round_length(longest: float) -> float:
    """The largest 1, 2 or 5 times a power of ten up to a length."""
    power: float = 10.0 ** (log10(longest) // 1)
    return power * max(step for step in (1, 2, 5) if step * power <= longest)
