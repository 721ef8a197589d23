"""Floors as interpretations: a floor by hand, and the facts that the thesis' authors published."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from shapely import LineString, box

from pianta.errors import LabelError, RelationError
from pianta.floor import Door, Floor, Room
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.io.floors import save_floor
from pianta.labels import SCHOOL, LabelConvention, LabelSet
from pianta.relational.fact_files import read_interpretations, save_interpretations
from pianta.relational.facts import FLOOR_SIGNATURES, SELF, Argument, Fact, Interpretation, Signature, find_faults
from pianta.relational.interpretation import (
    ALIGNED,
    FLOOR_RELATIONS,
    SYMMETRIC,
    Relation,
    interpret_floor,
    is_corridor,
    label_atom,
)

# Two rooms of 4 m by 5 m above a corridor of 8 m by 2 m with an entrance, and a room without a door.
ROOMS = (
    Room(3, box(0, 2, 4, 7), "CLASSROOM"),
    Room(1, box(4, 2, 8, 7), "MEDIUM SERVICE", partial=True),
    Room(7, box(0, 0, 8, 2), "CORRIDOR"),
    Room(9, box(20, 0, 22, 2), "STAIRS"),
)
DOORS = (
    Door((7, 3), LineString([(1, 2), (2, 2)]), 1.0),
    Door((3, 7), LineString([(3, 2), (3.5, 2)]), 0.5, "opening"),
    Door((1, 7), LineString([(5, 2), (6, 2)]), 1.0),
    Door((7, None), LineString([(0, 0), (0, 1)]), 1.0),
)
FLOOR = Floor(ROOMS, DOORS, building_type={"office": 0.2, "school": 0.8}, source="wing a")


def facts_of(interpretation: Interpretation, relation: str) -> list[tuple[object, ...]]:
    return [fact.arguments for fact in interpretation.facts_of(relation)]


def test_the_facts_of_a_floor():
    facts = interpret_floor(FLOOR)
    assert facts.name == "wing a"
    assert find_faults(facts, FLOOR_SIGNATURES) == []
    assert facts_of(facts, "room") == [("r3",), ("r1",), ("r7",), ("r9",)]
    assert facts_of(facts, "buildingtype") == [("school",)]
    assert facts_of(facts, "area") == [("r3", 20.0), ("r1", 20.0), ("r7", 16.0), ("r9", 4.0)]
    assert facts_of(facts, "perimeter") == [("r3", 18.0), ("r1", 18.0), ("r7", 20.0), ("r9", 8.0)]
    assert facts_of(facts, "aoverp")[2] == ("r7", 0.8)
    assert facts_of(facts, "circularity")[2] == ("r7", 25.0)
    assert facts_of(facts, "doors") == [("r3", 2), ("r1", 1), ("r7", 4), ("r9", 0)]
    assert facts_of(facts, "entrance") == [("r7",)]
    assert facts_of(facts, "partial") == [("r1",)]
    assert facts_of(facts, "connected") == [("r1", "r7"), ("r3", "r7")]
    assert sorted(facts_of(facts, "sharedwall")) == [("r1", "r7"), ("r3", "r1"), ("r3", "r7")]
    assert facts_of(facts, "closeness")[2:] == [("r7", 1.0), ("r9", 0.0)]
    assert facts_of(facts, "betwenness") == [("r3", 0.0), ("r1", 0.0), ("r7", 0.5), ("r9", 0.0)]
    labels = [("r3", "lclassroom"), ("r1", "lmediumservice"), ("r7", "lcorridor"), ("r9", "lstairs")]
    assert facts_of(facts, "label") == labels
    assert facts.facts[-4:] == tuple(Fact("label", label) for label in labels)


@pytest.mark.parametrize("relation", ["adcs", "andcs", "ff", "normalcirc"])
def test_every_room_has_every_measure(relation):
    facts = facts_of(interpret_floor(FLOOR), relation)
    assert [room for room, _ in facts] == ["r3", "r1", "r7", "r9"]
    assert all(isinstance(value, float) and value > 0 for _, value in facts)


@pytest.mark.parametrize(
    ("label_set", "convention", "expected"),
    [
        (LabelSet.R_C, LabelConvention.EXPERIMENTS, "lroom lroom lcorridor lroom"),
        (LabelSet.R_C, LabelConvention.FIGURE, "lroom lroom lcorridor lcorridor"),
        (LabelSet.F_C_E_S, LabelConvention.EXPERIMENTS, "lroom lservice lcorridor lentrance"),
        (LabelSet.GENERAL, LabelConvention.EXPERIMENTS, "lm lm lc ls"),
        (None, LabelConvention.EXPERIMENTS, ""),
    ],
)
def test_labels_are_those_of_a_label_set(label_set, convention, expected):
    facts = interpret_floor(FLOOR, label_set=label_set, convention=convention)
    assert [label for _, label in facts_of(facts, "label")] == expected.split()


def test_rooms_without_a_label_have_no_such_fact():
    some = replace(FLOOR, rooms=(replace(ROOMS[0], label=None), *ROOMS[1:]))
    assert [room for room, _ in facts_of(interpret_floor(some, label_set=LabelSet.R_C), "label")] == ["r1", "r7", "r9"]
    none = Floor(tuple(replace(room, label=None) for room in ROOMS), DOORS)
    facts = interpret_floor(none, label_set=LabelSet.F_C_E_S)
    assert {"label", "buildingtype"}.isdisjoint({fact.relation for fact in facts.facts})
    assert facts.name == "floor"


def test_the_schema_maps_labels():
    untyped = replace(FLOOR, building_type={})
    assert interpret_floor(untyped).facts_of("label")
    with pytest.raises(LabelError, match="CLASSROOM"):
        interpret_floor(untyped, label_set=LabelSet.R_C)
    typed = interpret_floor(untyped, label_set=LabelSet.R_C, schema=SCHOOL)
    assert typed.facts_of("label") == interpret_floor(FLOOR, label_set=LabelSet.R_C).facts_of("label")
    unusual = replace(FLOOR, rooms=(replace(ROOMS[0], label="MORGUE"), *ROOMS[1:]))
    with pytest.raises(LabelError, match="MORGUE"):
        interpret_floor(unusual, label_set=LabelSet.R_C)


def test_labels_of_the_room_count_if_the_schema_lacks_them():
    labels = {"R/C": "ROOM", "F/C/E/S": "FUNCTIONAL"}
    room = replace(ROOMS[0], label="FUNCTIONAL", labels=labels)
    for types in ({}, {"school": 1.0}):
        facts = interpret_floor(Floor((room,), building_type=types), label_set=LabelSet.R_C)
        assert facts_of(facts, "label") == [("r3", "lroom")]


def test_a_corrected_label_replaces_the_predicted_one():
    room = replace(ROOMS[0], label="CORRIDOR", labels={"R/C": "ROOM", "school": "CLASSROOM"})
    facts = interpret_floor(Floor((room,), building_type={"school": 1.0}), label_set=LabelSet.R_C)
    assert facts_of(facts, "label") == [("r3", "lcorridor")]


def test_corridors_are_facts_on_request():
    facts = interpret_floor(FLOOR, relations=[is_corridor()], label_set=None)
    assert [str(fact) for fact in facts.facts] == ["room(r3)", "room(r1)", "room(r7)", "room(r9)", "iscorr(r7)"]
    figure = interpret_floor(FLOOR, relations=[is_corridor(convention=LabelConvention.FIGURE)])
    assert facts_of(figure, "iscorr") == [("r7",), ("r9",)]
    assert not interpret_floor(FLOOR).facts_of("iscorr")


def test_a_floor_without_rooms_has_a_type_at_most():
    assert interpret_floor(Floor(())).facts == ()
    assert [str(fact) for fact in interpret_floor(Floor((), building_type={"high school": 1})).facts] == [
        "buildingtype(highschool)"
    ]
    assert interpret_floor(Floor(()), relations=[ALIGNED, SYMMETRIC]).facts == ()


def test_users_add_relations_of_their_own(tmp_path):
    larger = Signature("larger", (Argument("r1", "room"), Argument("r2", "room"), Argument("by")), intensional=True)

    def find_larger(floor):
        areas = [(room.id, room.polygon.area) for room in floor.rooms]
        return [(one, other, "much") for one, big in areas for other, small in areas if big > 4.5 * small]

    relations = (*FLOOR_RELATIONS, ALIGNED, SYMMETRIC, Relation(larger, find_larger))
    facts = interpret_floor(FLOOR, relations=relations)
    assert facts_of(facts, "larger") == [("r3", "r9", "much"), ("r1", "r9", "much")]
    assert facts_of(facts, "symmetric") == [("r1", "r3")]
    assert ("r3", "r7") in {tuple(sorted(pair)) for pair in facts_of(facts, "aligned")}  # type: ignore[type-var]
    save_interpretations(tmp_path / "facts.pl", [facts], signatures=(*FLOOR_SIGNATURES, larger))
    assert read_interpretations(tmp_path / "facts.pl") == [facts]


def test_users_add_entities_of_their_own():
    door = Signature("door", (Argument("door_id", SELF), Argument("kind")))
    leads = Signature("leads", (Argument("door", "door"), Argument("room", "room")))
    doors = Relation(door, lambda floor: [(f"d{n}", one.kind) for n, one in enumerate(floor.doors)])
    ends = Relation(leads, lambda floor: [(f"d{n}", i) for n, one in enumerate(floor.doors) for i in one.room_ids])
    facts = interpret_floor(FLOOR, relations=[doors, ends], label_set=None)
    assert facts_of(facts, "door") == [("d0", "door"), ("d1", "opening"), ("d2", "door"), ("d3", "door")]
    assert facts_of(facts, "leads")[-2:] == [("d2", "r7"), ("d3", "r7")]


def test_pairs_of_an_unordered_relation_come_once():
    near = Signature("near", (Argument("r1", "room"), Argument("r2", "room")), unordered=True)
    facts = interpret_floor(FLOOR, relations=[Relation(near, lambda floor: [(3, 1), (1, 3), (3, 1), (9, 7)])])
    assert facts_of(facts, "near") == [("r3", "r1"), ("r9", "r7")]


@pytest.mark.parametrize(
    ("result", "message"),
    [
        ([(3, 4)], "near"),
        ([("r3", 1)], "'r3'"),
        ([(3,)], "(3,)"),
    ],
)
def test_results_of_user_functions_must_be_rooms_of_the_floor(result, message):
    near = Signature("near", (Argument("r1", "room"), Argument("r2", "room")))
    with pytest.raises(RelationError, match=re.escape(message)):
        interpret_floor(FLOOR, relations=[Relation(near, lambda floor: result)])


def test_a_relation_has_one_signature():
    other = Relation(Signature("area", (Argument("room", "room"),)), lambda floor: [])
    with pytest.raises(RelationError, match="area"):
        interpret_floor(FLOOR, relations=(*FLOOR_RELATIONS, other))


def test_labels_are_atoms_of_small_letters():
    assert label_atom("SMALL ADMINISTRATIVE") == "lsmalladministrative"
    assert {label_atom(name) for name in ("ROOM", "FUNCTIONAL")} == {"lroom"}


LABEL_FILES = {LabelSet.TYPE: "all", LabelSet.F_C_E_S: "RCES", LabelSet.R_C: "RC"}


def name_of(interpretation: Interpretation) -> str:
    """The name without the annotator's endings."""
    return re.sub("(_updated)?xml$|_", "", interpretation.name.lower())


def by_place(interpretation: Interpretation, relation: str) -> set[tuple[object, ...]]:
    """Facts, each once, with the index of a room instead of its identifier."""
    indices = {room: index for index, (room,) in enumerate(facts_of(interpretation, "room"))}
    facts = (tuple(indices.get(value, value) for value in fact) for fact in facts_of(interpretation, relation))
    return {tuple(sorted(fact)) if relation == "connected" else fact for fact in facts}  # type: ignore[type-var]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
@pytest.mark.parametrize("type_name", ["school", "office"])
@pytest.mark.parametrize("label_set", LABEL_FILES)
def test_annotated_buildings_have_the_rooms_doors_and_labels_that_the_authors_published(data, type_name, label_set):
    published = read_interpretations(data / "klog" / f"{type_name}_{LABEL_FILES[label_set]}.pl")
    files = {f"i{type_name}{file.stem}": file for file in (data / "buildings" / type_name).glob("*.xml")}
    compared = [(floor, files[name_of(floor)]) for floor in published if name_of(floor) in files]
    assert len(compared) == len(published)
    for floor, file in compared:
        measured = interpret_floor(read_building_xml(file), label_set=label_set)
        assert [by_place(measured, relation) for relation in ("room", "connected", "label")] == [
            by_place(floor, relation) for relation in ("room", "connected", "label")
        ]


def test_the_snippets_of_the_page_run_one_after_the_other(tmp_path, monkeypatch):
    page = (Path(__file__).parents[1] / "docs" / "methods" / "relations.md").read_text(encoding="utf-8")
    snippets = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    save_floor(FLOOR, "floor.geojson")
    names: dict[str, Any] = {}
    for snippet in snippets:
        exec(snippet, names)  # noqa: S102
    assert len(snippets) == 6
    assert names["gram"] == pytest.approx(1)
    assert names["facts"].facts_of("muchlarger")
    assert names["alike"].shape == (2, 6)
    assert [len(floor.rooms) for floor in names["others"]] == [len(each) for each in names["labelled"]]
    assert [each.count("CORRIDOR") for each in names["labelled"]] == [1, 1]
    assert names["kinds_of_others"] == ["corridor", "hall"]
