"""Colours, inks and shapes of labels, and what a legend lists."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import box

from pianta.floor import Floor, Room
from pianta.labels import FCES, FCES_COLORS, SCHEMAS, GeneralLabel, Label, LabelSchema
from pianta.plot.styles import DARK_INK, LIGHT_INK, NEUTRAL_COLOR, RoomStyle, list_labels, style_rooms

SQUARE = box(0, 0, 1, 1)
SCHOOL, OFFICE = {"SCHOOL": 0.7, "office": 0.3}, {"school": 0.3, "office": 0.7}


def style_of(label: str | None, building_type: dict[str, float] | None = None, **attributes) -> RoomStyle:
    return style_rooms(Floor((Room(4, SQUARE, label, **attributes),), building_type=building_type or {}))[4]


@pytest.mark.parametrize(
    ("label", "labels", "building_type", "color"),
    [
        ("KITCHEN", {}, SCHOOL, "#b27abe"),
        (" kitchen ", {}, SCHOOL, "#b27abe"),
        ("conference  Room", {}, {" OFFICE ": 1.0}, "#3fbf04"),
        ("Lab", {}, {}, FCES_COLORS[FCES.FUNCTIONAL]),
        ("room", {}, {}, FCES_COLORS[FCES.FUNCTIONAL]),
        ("", {}, SCHOOL, NEUTRAL_COLOR),
        ("CLASSROOM", {}, OFFICE, "#1bddf2"),
        ("CUBICULE", {"office": "CUBICULE"}, {}, "#2e7880"),
        ("WARD", {"F/C/E/S": "SERVICE"}, SCHOOL, FCES_COLORS[FCES.SERVICE]),
        ("LAB", {}, {}, FCES_COLORS[FCES.FUNCTIONAL]),
        ("STAIRS", {}, {"hospital": 1.0}, FCES_COLORS[FCES.ENTRANCE]),
        ("CORRIDOR", {}, {}, FCES_COLORS[FCES.CONNECTION]),
        ("ROOM", {}, {}, FCES_COLORS[FCES.FUNCTIONAL]),
        ("H", {}, {}, "#bf5719"),
        ("WARD", {"R/C": "ROOM"}, SCHOOL, NEUTRAL_COLOR),
        (None, {"F/C/E/S": "SERVICE"}, SCHOOL, NEUTRAL_COLOR),
    ],
)
def test_a_label_has_the_colour_of_its_schema_else_of_its_function(label, labels, building_type, color):
    assert style_of(label, building_type, labels=labels).color == color


@pytest.mark.parametrize(
    ("label", "labels", "building_type", "is_corridor"),
    [
        ("LOBBY", {}, SCHOOL, True),
        ("OPENSPACE", {}, OFFICE, False),
        ("ENTRANCE", {}, SCHOOL, False),
        ("lobby", {}, SCHOOL, True),
        ("Corridor", {}, {}, True),
        ("LOBBY", {}, {}, True),
        ("STAIRS", {}, SCHOOL, False),
        ("LOBBY", {"R/C": "ROOM"}, SCHOOL, False),
        ("WARD", {"R/C": "CORRIDOR"}, {}, True),
        ("WARD", {"F/C/E/S": "CONNECTION"}, {}, True),
        ("CORRIDOR", {}, {}, True),
        ("ROOM", {}, {}, False),
        (None, {}, SCHOOL, False),
    ],
)
def test_corridors_are_those_of_r_c_else_those_of_the_experiments_of_the_thesis(
    label, labels, building_type, is_corridor
):
    assert style_of(label, building_type, labels=labels).is_corridor == is_corridor


@pytest.mark.parametrize(
    ("probabilities", "is_uncertain"),
    [
        ({}, False),
        ({"school": {"LAB": 0.6}}, False),
        ({"school": {"LAB": 0.59}}, True),
        ({"R/C": {"ROOM": 0.2}, "school": {"GYM": 0.2}}, False),
    ],
)
def test_a_label_below_0_6_is_uncertain(probabilities, is_uncertain):
    assert style_of("LAB", SCHOOL, label_probabilities=probabilities).is_uncertain == is_uncertain


def test_a_partial_room_is_lighter_in_the_same_colour():
    full, partial = style_of("LAB", SCHOOL), style_of("LAB", SCHOOL, partial=True)
    assert full.color == partial.color
    assert full.fill == "#598df5"  # 255 + 0.75 * (0x22, 0x67, 0xf2 - 255)
    assert partial.fill == "#a7c2fa"


@pytest.mark.parametrize(
    ("label", "ink"), [("LIBRARY", LIGHT_INK), ("GYM", LIGHT_INK), ("CLASSROOM", DARK_INK), ("BATHROOM", DARK_INK)]
)
def test_ids_are_white_on_dark_colours_only(label, ink):
    assert style_of(label, SCHOOL).ink == ink


@given(st.integers(0, 0xFFFFFF), st.floats(0, 1))
def test_ink_can_be_read_on_every_fill(number, opacity):
    style = RoomStyle(f"#{number:06x}", opacity)
    brightness = sum(
        weight * (part / 255) ** 2.2
        for weight, part in zip((0.2126, 0.7152, 0.0722), bytes.fromhex(style.fill[1:]), strict=True)
    )
    contrast = (brightness + 0.05) / 0.066 if style.ink == DARK_INK else 1.05 / (brightness + 0.05)
    assert contrast > 3.8


@pytest.mark.parametrize("schema", SCHEMAS.values())
def test_a_floor_with_all_labels_has_the_colours_and_order_of_the_schema(schema):
    names = [label.name for label in schema.labels]
    rooms = [Room(number, SQUARE, name) for number, name in enumerate(reversed(names), start=1)]
    entries = list_labels(Floor(tuple(rooms), building_type={schema.building_type: 1.0}))
    assert [(entry.label, entry.color) for entry in entries] == [(each.name, each.color) for each in schema.labels]


def test_the_legend_lists_unknown_labels_by_name_and_rooms_without_one_last():
    labels = {9: "WARD", 2: None, 3: "GYM", 4: "ICU", 5: "CLASSROOM", 1: "GYM"}
    rooms = tuple(Room(id_, SQUARE, label, partial=id_ == 3) for id_, label in labels.items())
    entries = list_labels(Floor(rooms, building_type={"school": 1.0}))
    listed = [("CLASSROOM", (5,)), ("GYM", (1, 3)), ("ICU", (4,)), ("WARD", (9,)), (None, (2,))]
    assert [(entry.label, entry.room_ids) for entry in entries] == listed


def test_a_label_with_two_colours_is_listed_with_each():
    functions = {1: "SERVICE", 2: "FUNCTIONAL", 3: "SERVICE"}
    rooms = tuple(Room(id_, SQUARE, "WARD", {"F/C/E/S": function}) for id_, function in functions.items())
    entries = {entry.color: entry.room_ids for entry in list_labels(Floor(rooms))}
    assert entries == {FCES_COLORS[FCES.SERVICE]: (1, 3), FCES_COLORS[FCES.FUNCTIONAL]: (2,)}


def test_colours_of_a_schema_of_the_user():
    ward = Label("WARD", FCES.FUNCTIONAL, GeneralLabel.MEDIUM, "#8c3b2e")
    schemas = {**SCHEMAS, "hospital": LabelSchema("hospital", (ward,))}
    labels = {"R/C": "ROOM", "F/C/E/S": "FUNCTIONAL", "hospital": "WARD"}
    floor = Floor((Room(4, SQUARE, "WARD", labels=labels),), building_type={"hospital": 1.0})
    assert style_rooms(floor)[4].color == FCES_COLORS[FCES.FUNCTIONAL]
    assert style_rooms(floor, schemas)[4].color == "#8c3b2e"
    assert [entry.color for entry in list_labels(floor, schemas)] == ["#8c3b2e"]


@pytest.mark.parametrize("schema", SCHEMAS.values())
def test_given_labels_look_like_those_of_a_model(schema):
    """A model gives the coarser label sets, too, in the convention of the experiments."""
    for label in schema.labels:
        sets = {
            "R/C": str(label.room_or_corridor()),
            "F/C/E/S": str(label.function_in()),
            schema.building_type: label.name,
        }
        types = {schema.building_type: 1.0}
        assert style_of(label.name.title(), types) == style_of(label.name, types, labels=sets)


def test_a_label_in_several_spellings_is_listed_once():
    rooms = tuple(Room(number, SQUARE, label) for number, label in enumerate(("Gym", "GYM", " gym"), start=1))
    assert [(each.label, each.room_ids) for each in list_labels(Floor(rooms, building_type=SCHOOL))] == [
        ("GYM", (1, 2, 3))
    ]
