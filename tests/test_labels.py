"""The label schemas agree with the thesis' figure, its experiments, its graphs, and every label in the data."""

import copy
import json
import pickle
import re
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from defusedxml import ElementTree

from pianta import make_world
from pianta.errors import LabelError
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.labels import (
    FCES,
    FCES_COLORS,
    HOSPITAL,
    HOUSE,
    OFFICE,
    RC,
    SCHEMAS,
    SCHOOL,
    GeneralLabel,
    Label,
    LabelConvention,
    LabelSchema,
    LabelSet,
    schema_of,
)

PAGE = Path(__file__).parents[1] / "docs" / "methods" / "labels.md"

CONNECTING = {
    "CONNECTION": {"CORRIDOR": "corridor", "LOBBY": "lobby", "HALL": "hall"},
    "ENTRANCE": {"ENTRANCE": "entrance", "ELEVATOR": "elevator", "STAIRS": "stairs"},
}
ADMINISTRATIVE = {
    "SMALL ADMINISTRATIVE": "small admin. room",
    "MEDIUM ADMINISTRATIVE": "medium admin. room",
    "BIG ADMINISTRATIVE": "big admin. room",
}
# Fig. 4.5: the name of a label in files, and its name in the figure.
FIGURE = {
    "school": {
        "FUNCTIONAL": {
            "CLASSROOM": "classroom",
            "SMALL": "support",
            "MEDIUM": "teachers' room",
            "LAB": "laboratory",
        },
        "SERVICE": {
            **ADMINISTRATIVE,
            "GYM": "gym",
            "KITCHEN": "kitchen",
            "CLOSET": "closet",
            "CONFERENCE": "conference room",
            "MEDIUM SERVICE": "medium service room",
            "BIG SERVICE": "big service room",
            "LIBRARY": "library",
            "BATHROOM": "bathroom",
            "WASHROOM": "washroom",
            "CANTEEN": "cafeteria canteen",
        },
        **CONNECTING,
    },
    "office": {
        "FUNCTIONAL": {
            "CUBICULE": "cubicle",
            "CONFERENCE ROOM": "conference room",
            "EXECUTIVE OFFICE": "executive office",
            "OPENSPACE": "openspace",
            "CONFERENCE HALL": "conference hall",
            "OFFICE": "office",
            "SHARED OFFICE": "shared office",
        },
        "SERVICE": {
            **ADMINISTRATIVE,
            "RECEPTION": "reception",
            "KITCHEN": "kitchen",
            "CLOSET": "closet",
            "CONVENIENCE STORE": "convenience store",
            "MEDIUM SERVICE": "medium service room",
            "BIG SERVICE": "big service room",
            "COLLECTIVE SERVICE ROOM": "collective service room",
            "BATHROOM": "bathroom",
            "WASHROOM": "washroom",
            "CAFETERIA": "cafeteria",
        },
        **CONNECTING,
    },
}

KLOG_FCES = {
    "room": FCES.FUNCTIONAL,
    "corridor": FCES.CONNECTION,
    "entrance": FCES.ENTRANCE,
    "service": FCES.SERVICE,
}
KLOG_RC = {"room": RC.ROOM, "corridor": RC.CORRIDOR}
LAMP = Label("LAMP", FCES.SERVICE, GeneralLabel.SMALL, "#ffffff")


@pytest.mark.parametrize("schema", SCHEMAS.values(), ids=SCHEMAS)
def test_functions_by_the_convention_of_the_figure_are_those_of_the_figure(schema):
    printed = FIGURE[schema.building_type]
    functions = {name: function for function, names in printed.items() for name in names}
    assert {label.name: label.function_in(LabelConvention.FIGURE) for label in schema.labels} == functions
    corridors = {
        name for name in schema.by_name if schema.by_name[name].room_or_corridor(LabelConvention.FIGURE) is RC.CORRIDOR
    }
    assert corridors == {*CONNECTING["CONNECTION"], *CONNECTING["ENTRANCE"]}


@pytest.mark.parametrize("schema", SCHEMAS.values(), ids=SCHEMAS)
@pytest.mark.parametrize("convention", [LabelConvention.FIGURE, LabelConvention.EXPERIMENTS])
def test_r_c_labels_follow_from_f_c_e_s_labels(schema, convention):
    pairs = {(label.function_in(convention), label.room_or_corridor(convention)) for label in schema.labels}
    entrance = RC.CORRIDOR if convention is LabelConvention.FIGURE else RC.ROOM
    assert pairs == {
        (FCES.FUNCTIONAL, RC.ROOM),
        (FCES.SERVICE, RC.ROOM),
        (FCES.CONNECTION, RC.CORRIDOR),
        (FCES.ENTRANCE, entrance),
    }


@pytest.mark.parametrize("schema", SCHEMAS.values(), ids=SCHEMAS)
def test_corridors_and_halls_are_the_corridors_of_section_4_3_1(schema):
    for label in schema.labels:
        connects = label.general in (GeneralLabel.CORRIDOR, GeneralLabel.HALL)
        assert connects is (label.room_or_corridor(LabelConvention.EXPERIMENTS) is RC.CORRIDOR), label


def test_experiments_differ_from_the_figure_in_two_labels():
    departing = [
        (schema.building_type, label.name, label.function_in(LabelConvention.EXPERIMENTS))
        for schema in SCHEMAS.values()
        for label in schema.labels
        if label.function_in(LabelConvention.EXPERIMENTS) is not label.function_in(LabelConvention.FIGURE)
    ]
    assert departing == [("school", "GYM", FCES.FUNCTIONAL), ("school", "CONFERENCE", FCES.FUNCTIONAL)]


def test_corridors_of_the_graphs():
    corridors = {
        schema.building_type: {
            label.name for label in schema.labels if label.room_or_corridor(LabelConvention.GRAPHS) is RC.CORRIDOR
        }
        for schema in SCHEMAS.values()
    }
    school = {"CORRIDOR", "HALL", "LOBBY", "ENTRANCE"}
    assert corridors == {"school": school, "office": school | {"OPENSPACE"}}


def test_labels_are_mapped_to_every_set():
    names = ["gym", "Small  administrative ", "STAIRS", "HALL"]
    assert SCHOOL.map_labels(names, LabelSet.TYPE) == ["GYM", "SMALL ADMINISTRATIVE", "STAIRS", "HALL"]
    assert SCHOOL.map_labels(names, LabelSet.GENERAL) == ["B", "S", "S", "H"]
    assert SCHOOL.map_labels(names, LabelSet.F_C_E_S) == ["FUNCTIONAL", "SERVICE", "ENTRANCE", "CONNECTION"]
    assert SCHOOL.map_labels(names, LabelSet.F_C_E_S, convention=LabelConvention.FIGURE)[0] == "SERVICE"
    assert SCHOOL.map_labels(names, LabelSet.R_C) == ["ROOM", "ROOM", "ROOM", "CORRIDOR"]
    assert SCHOOL.map_labels(names, LabelSet.R_C, convention=LabelConvention.FIGURE) == [
        "ROOM",
        "ROOM",
        "CORRIDOR",
        "CORRIDOR",
    ]
    assert OFFICE.map_labels(["OPENSPACE"], LabelSet.R_C, convention=LabelConvention.GRAPHS) == ["CORRIDOR"]
    assert SCHOOL.map_labels([], LabelSet.R_C) == []


def test_all_unknown_labels_are_reported():
    with pytest.raises(LabelError, match=r"OFFICE.*POOL.*None"):
        SCHOOL.map_labels(["POOL", "GYM", None, "OFFICE", "POOL"], LabelSet.R_C)
    with pytest.raises(LabelError, match=r"'A\\nB'"):
        SCHOOL.map_labels(["A\nB"], LabelSet.R_C)


def test_a_label_called_none_is_not_a_room_without_label():
    schema = LabelSchema("house", (Label("none", FCES.SERVICE, GeneralLabel.SMALL, "#ffffff"),))
    assert schema.map_labels(["None"], LabelSet.TYPE) == ["NONE"]
    with pytest.raises(LabelError, match="None"):
        schema.map_labels([None], LabelSet.TYPE)


def test_names_types_and_colours_take_their_standard_form():
    label = Label(" coat \t room", FCES.SERVICE, GeneralLabel.SMALL, "#ABCDEF")
    schema = LabelSchema(" Old  House", (label,))
    assert (label.name, label.color, schema.building_type) == ("COAT ROOM", "#abcdef", "old house")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Label(" ", FCES.SERVICE, GeneralLabel.SMALL, "#ffffff"), "name"),
        (lambda: Label("x" * 101, FCES.SERVICE, GeneralLabel.SMALL, "#ffffff"), "101"),
        (lambda: Label("A\u202eB", FCES.SERVICE, GeneralLabel.SMALL, "#ffffff"), "printed"),
        (lambda: Label("A", FCES.SERVICE, GeneralLabel.SMALL, "white"), "white"),
        (lambda: Label("A", FCES.SERVICE, GeneralLabel.SMALL, "#ffffff\n"), "colour"),
        (lambda: Label("A", FCES.CONNECTION, GeneralLabel.SMALL, "#ffffff"), "CONNECTION"),
        (lambda: Label("A", FCES.SERVICE, GeneralLabel.HALL, "#ffffff"), "SERVICE"),
        (lambda: LabelSchema("", (LAMP,)), "name"),
        (lambda: LabelSchema("house", ()), "house"),
        (lambda: LabelSchema("house", (LAMP, LAMP)), "LAMP"),
    ],
)
def test_invalid_labels_and_schemas_are_refused(make, message):
    with pytest.raises(LabelError, match=message) as error:
        make()
    assert "\n" not in str(error.value)


def test_an_entrance_may_be_a_hall_or_a_room():
    for general in GeneralLabel:
        assert Label("A", FCES.ENTRANCE, general, "#ffffff").general is general


def test_schemas_are_found_by_building_type():
    assert schema_of("SCHOOL") is SCHOOL
    assert schema_of(" office ") is OFFICE
    assert (schema_of("House"), schema_of("hospital")) == (HOUSE, HOSPITAL)
    with pytest.raises(LabelError, match=r"inn.*school, office, house, home, hospital"):
        schema_of("inn")


def test_schemas_can_be_copied_and_sent_to_other_processes():
    assert SCHOOL.by_name["GYM"].general is GeneralLabel.BIG
    assert pickle.loads(pickle.dumps(SCHOOL)) == SCHOOL  # noqa: S301
    assert copy.deepcopy(OFFICE) == OFFICE


def test_colours_of_functions_are_those_of_one_of_their_labels():
    assert set(FCES_COLORS) == set(FCES)
    for function, color in FCES_COLORS.items():
        for schema in SCHEMAS.values():
            assert color in {label.color for label in schema.labels if label.function is function}


def labels_of(file: Path) -> tuple[LabelSchema, set[str]]:
    """The schema of a layout XML, and the labels of its rooms."""
    root = ElementTree.parse(file).getroot()
    spaces = root.findall("floor/spaces/space")
    assert spaces, file
    schema = schema_of(root.findtext("building_type/main_type") or "")
    return schema, {(space.findtext("labels/label") or "").strip() for space in spaces}


@pytest.mark.slow
@pytest.mark.parametrize(
    "folder",
    ["buildings/school", "buildings/office", "buildings/robocup", "floorplans", "partial", "slam", "survey"],
)
def test_every_label_of_real_buildings_is_known(data, folder):
    colours: dict[str, set[str]] = defaultdict(set)
    for file in (data / folder).rglob("*.xml"):
        schema, labels = labels_of(file)
        colours[schema.building_type] |= labels
    assert colours
    for building_type, labels in colours.items():
        assert schema_of(building_type).map_labels(labels, LabelSet.TYPE)


@pytest.mark.parametrize(
    ("name", "schema", "missing"),
    [
        ("school", SCHOOL, set()),
        ("office", OFFICE, set()),
        ("labels_drawing_tool", SCHOOL, {"KITCHEN"}),
    ],
)
def test_names_and_colours_are_those_of_the_annotators(data, name, schema, missing):
    labels = ElementTree.parse(data / "labels" / f"{name}.xml").getroot().findall("labels/label")
    colors = {
        label.findtext("name", "").strip(): "#{:02x}{:02x}{:02x}".format(
            *(int(label.find("color").get(c)) for c in "rgb")
        )
        for label in labels
    }
    label_colors = {label.name: label.color for label in schema.labels if label.name not in missing}
    assert colors == label_colors


@pytest.mark.parametrize("schema", SCHEMAS.values(), ids=SCHEMAS)
def test_graphs_and_sizes_are_those_of_the_codes(data, schema):
    codes = json.loads((data / "labels" / "label_codes.json").read_text())[schema.building_type]
    corridors = {label["name"]: label["code"] >= 100 for label in codes}
    assert {
        name: label.room_or_corridor(LabelConvention.GRAPHS) is RC.CORRIDOR for name, label in schema.by_name.items()
    } == corridors
    generals = {"S": GeneralLabel.SMALL, "M": GeneralLabel.MEDIUM, "B": GeneralLabel.BIG, "U": GeneralLabel.BIG}
    sized = {label["name"]: generals[label["size"]] for label in codes if label["size"] in generals}
    assert {name: schema.by_name[name].general for name in sized} == sized
    assert set(schema.by_name) - set(sized) == {
        *CONNECTING["CONNECTION"],
        *CONNECTING["ENTRANCE"],
        "WASHROOM",
        *({"OPENSPACE"} if schema is OFFICE else ()),
    }


def klog_labels(file: Path) -> dict[tuple[str, str], str]:
    """The label of each room, by building and room, in kLog's spelling without the leading l."""
    facts = re.findall(r"interpretation\((\w+),label\((\w+),l(\w+)\)\)\.", file.read_text())
    assert facts, file
    labels = {(building, room): label for building, room, label in facts}
    assert len(labels) == len(facts)
    return labels


@pytest.mark.parametrize(("name", "schema"), [("school", SCHOOL), ("office", OFFICE), ("robocup", OFFICE)])
def test_experiments_are_those_of_the_facts(data, name, schema):
    type_labels, fces, rc = (klog_labels(data / "klog" / f"{name}_{labels}.pl") for labels in ("all", "RCES", "RC"))
    assert type_labels.keys() == fces.keys() == rc.keys()
    spelled = {label.name.lower().replace(" ", ""): label for label in schema.labels}
    wrong = {
        (label, fces[room], rc[room])
        for room, label in type_labels.items()
        if spelled[label].function_in() is not KLOG_FCES[fces[room]]
        or spelled[label].room_or_corridor() is not KLOG_RC[rc[room]]
    }
    assert not wrong


def table_of_labels(schema: LabelSchema) -> str:
    """The table of a schema in the page; of the conventions only differences from the figure."""
    rows = ["| label | in Fig. 4.5 | F/C/E/S | R/C | general | experiments | graphs |", "|" + " --- |" * 7]
    for label in schema.labels:
        figure = label.function_in(LabelConvention.FIGURE), label.room_or_corridor(LabelConvention.FIGURE)
        splits = (
            (label.function_in(convention), label.room_or_corridor(convention))
            for convention in (LabelConvention.EXPERIMENTS, LabelConvention.GRAPHS)
        )
        departing = (", ".join(word for word in convention if word not in figure) for convention in splits)
        printed = FIGURE[schema.building_type][label.function][label.name]
        rows.append(f"| {' | '.join((label.name, printed, *figure, label.general, *departing))} |".replace("  ", " "))
    return "\n".join(rows)


@pytest.mark.parametrize("schema", SCHEMAS.values(), ids=SCHEMAS)
def test_tables_of_the_page_are_those_of_the_code(schema):
    assert f"\n\n{table_of_labels(schema)}\n\n" in PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("schema", [HOUSE, HOSPITAL], ids=["house", "hospital"])
def test_tables_of_schemas_that_the_thesis_does_not_have(schema):
    rows = ["| label | F/C/E/S | R/C | general | graphs |", "|" + " --- |" * 5]
    for label in schema.labels:
        figure, graphs = (
            label.room_or_corridor(convention) for convention in (LabelConvention.FIGURE, LabelConvention.GRAPHS)
        )
        differs = (
            "" if label.function in {FCES.FUNCTIONAL, FCES.SERVICE, FCES.CONNECTION} or graphs is figure else graphs
        )
        row = f"| {label.name} | {label.function} | {figure} | {label.general} | {differs} |"
        rows.append(row.replace("  ", " "))
    assert "\n\n{}\n\n".format("\n".join(rows)) in PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("schema", [HOUSE, HOSPITAL], ids=["house", "hospital"])
def test_schemas_that_the_thesis_does_not_have_are_divided_as_its_own(schema):
    assert {label.function for label in schema.labels} == {*FCES}
    assert {label.general for label in schema.labels} == {*GeneralLabel}
    for name in ("CORRIDOR", "LOBBY", "HALL", "ENTRANCE", "ELEVATOR", "STAIRS"):
        own, school = schema.by_name[name], SCHOOL.by_name[name]
        assert own == school
    assert len({label.color for label in schema.labels}) == len(schema.labels)


@pytest.mark.parametrize(("world", "schema"), [("home", HOUSE), ("ward", HOSPITAL)])
def test_worlds_have_labels_of_their_schemas(world, schema):
    labels = {room.label for seed in range(8) for room in make_world(world, seed=seed)[0]}
    assert len(labels) > 4
    assert labels <= {*schema.by_name}


def test_houses_have_the_labels_of_house_expo():
    names = (
        "Living_Room Kitchen Bedroom Child_Room Dining_Room Bathroom Toilet Hall Hallway Office Guest_Room Wardrobe "
        "Room Garage Balcony Storage Gym Terrace Loggia Aeration Lobby Passenger_elevator Freight_elevator "
        "Boiler_room Entryway"
    )
    functions = HOUSE.map_labels(names.replace("_", "\t").split(" "), LabelSet.F_C_E_S)
    assert len(functions) == 25
    assert functions[:2] == [FCES.FUNCTIONAL, FCES.SERVICE]
    assert functions[7:9] == [FCES.CONNECTION] * 2


# Table 4.2: share of the rooms in percent, mean area in square metres, mean number of doorways.
TABLE_4_2 = {
    ("school", "C"): (15.4, 36.1, 5.7),
    ("school", "H"): (5.6, 205.1, 6.9),
    ("school", "S"): (55.6, 10.0, 1.1),
    ("school", "M"): (21.3, 54.8, 1.6),
    ("school", "B"): (2.0, 102.9, 2.1),
    ("office", "C"): (20.6, 30.5, 6.7),
    ("office", "H"): (6.6, 106.9, 6.5),
    ("office", "S"): (23.2, 4.5, 1.0),
    ("office", "M"): (34.5, 18.5, 1.2),
    ("office", "B"): (14.8, 31.3, 1.4),
}


def measured_rooms(folder: Path, schema: LabelSchema) -> dict[str, list[tuple[float, int]]]:
    """Area in square metres and number of doors of every room, by its general label."""
    rooms: dict[str, list[tuple[float, int]]] = defaultdict(list)
    for file in sorted(folder.glob("*.xml")):
        floor = read_building_xml(file)
        generals = schema.map_labels([room.label for room in floor.rooms], LabelSet.GENERAL)
        for room, general in zip(floor.rooms, generals, strict=True):
            rooms[general].append((room.polygon.area, sum(room.id in door.rooms for door in floor.doors)))
    return rooms


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_sizes_of_the_page_are_those_of_the_data(data):
    folders = {name: data / "buildings" / name for name in SCHEMAS}
    if [len(list(folder.glob("*.xml"))) for folder in folders.values()] != [32, 11]:
        pytest.skip(f"{data} has other buildings than the page was measured on")
    rooms = {name: measured_rooms(folder, SCHEMAS[name]) for name, folder in folders.items()}
    rows = []
    for (name, general), (share, area, doors) in TABLE_4_2.items():
        percent = 100 * len(rooms[name][general]) / sum(map(len, rooms[name].values()))
        mean_area, mean_doors = np.mean(rooms[name][general], axis=0)
        measured = f"{percent:.1f} ({share}) | {mean_doors:.1f} ({doors}) | {mean_area:.1f} ({area})"
        rows.append(f"| {name} | {general} | {measured} |")
        assert bool(mean_doors > 4) is (general in "CH")
    assert f"\n{chr(10).join(rows)}\n\n" in PAGE.read_text(encoding="utf-8")
