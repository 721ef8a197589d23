"""Signatures, facts and interpretations, and contradictions among them."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import PiantaError, RelationError
from pianta.relational.facts import (
    FLOOR_SIGNATURES,
    LISTING_SIGNATURES,
    SELF,
    Argument,
    Fact,
    Interpretation,
    Signature,
    by_name,
    check_interpretation,
    find_faults,
    write_term,
)

LISTING_6_1 = """\
signature buildingtype(buildingtype::property)::extensional.
signature space(space_id::self)::extensional.
signature connected(s1::space, s2::space)::extensional.
signature label(space_id::space, label::property)::extensional.
signature area(space_id::space, area::property)::extensional.
signature perimeter(space_id::space, perimeter::property)::extensional.
signature iscorr(room_id::space)::intensional.
"""
ROOM = by_name(FLOOR_SIGNATURES)["room"]


def interpret(*facts: tuple[object, ...], name: str = "floor") -> Interpretation:
    return Interpretation(name, tuple(Fact(relation, arguments) for relation, *arguments in facts))  # type: ignore[arg-type]


def faults_of(*facts) -> list[str]:
    return find_faults(interpret(*facts), FLOOR_SIGNATURES)


def test_signatures_of_the_listing_are_printed_as_there():
    # The listing's own iscorr names an entity that it does not declare.
    assert "".join(f"{signature}\n" for signature in LISTING_SIGNATURES) == LISTING_6_1


def test_floor_signatures_have_the_relations_of_the_real_files_and_more():
    names = set(by_name(FLOOR_SIGNATURES))
    measures = {"area", "perimeter", "aoverp", "adcs", "ff", "circularity", "normalcirc", "andcs"}
    assert names >= measures | {"room", "betwenness", "closeness", "connected", "label", "buildingtype", "doors"}
    assert names >= {"sharedwall", "partial", "entrance", "iscorr", "aligned", "symmetric"}
    assert len(names) == len(FLOOR_SIGNATURES)


def test_equal_roles_mark_interchangeable_entities():
    bond = Signature("bond", (Argument("a1", "atm"), Argument("kind"), Argument("a2", "atm")), unordered=True)
    assert str(bond) == "signature bond(a1::atm, kind::property, a2::atm)::extensional."
    assert bond.declare(role="b") == "signature bond(a1@b::atm, kind::property, a2@b::atm)::extensional."
    assert bond.standard_arguments(("z", "double", "a")) == ("a", "double", "z")
    assert ROOM.declare(role="b") == str(ROOM)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Argument("Room", "self"), "Room"),
        (lambda: Argument("a", "two words"), "two words"),
        (lambda: Signature("", (Argument("a"),)), "signature"),
        (lambda: Signature("none", ()), "'none'"),
        (lambda: Signature("twice", (Argument("a"), Argument("a"))), "a, a"),
        (lambda: Signature("two", (Argument("a", SELF), Argument("b", SELF))), "self"),
        (lambda: Signature("alone", (Argument("a", "room"),), unordered=True), "alone"),
        (
            lambda: Signature("mixed", (Argument("a", "room"), Argument("b", "door")), unordered=True),
            "mixed",
        ),
        (
            lambda: Fact("area", ("r1", None)),  # type: ignore[arg-type]
            "None",
        ),
        (lambda: Fact("area", ("r1", True)), "True"),
        (lambda: Fact("area", ("r1", np.True_)), "number"),  # type: ignore[arg-type]
        (lambda: Fact("area", ("r1", "\ud800")), "number"),
        (lambda: Fact("\ud800", ("r1",)), "relation"),
        (lambda: Interpretation("\ud800", ()), "name"),
        (lambda: by_name([ROOM, Signature("room", (Argument("room"),))]), "room"),
    ],
)
def test_invalid_signatures_and_facts_are_refused(make, message):
    with pytest.raises(RelationError, match=re.escape(message)) as refused:
        make()
    assert "\n" not in str(refused.value)
    assert isinstance(refused.value, PiantaError)


def test_numbers_of_numpy_become_those_of_python():
    fact = Fact("area", ("r1", np.float64(1.5), np.int64(2), np.float32(0.5)))  # type: ignore[arg-type]
    assert fact == Fact("area", ("r1", 1.5, 2, 0.5))
    assert [type(value) for value in fact.arguments] == [str, float, int, float]
    assert str(fact) == "area(r1,1.5,2,0.5)"


@pytest.mark.parametrize(
    ("value", "written"),
    [
        ("classroom", "classroom"),
        ("r4e0514", "r4e0514"),
        ("Hall", "'Hall'"),
        ("", "''"),
        ("5", "'5'"),
        ("two words", "'two words'"),
        ("è", "'è'"),
        ("it's \\ so\n", r"'it\'s \\ so\n'"),
        ("\0", "'\\x0\\'"),
        (5, "5"),
        (-0.0, "-0.0"),
        (5.40949908039e-05, "5.40949908039e-05"),
    ],
)
def test_terms_are_written_in_the_syntax_of_prolog(value, written):
    assert write_term(value) == written


def test_entities_and_facts_of_a_relation_are_listed():
    floor = interpret(("room", "r1"), ("area", "r1", 5), ("room", "r2"), ("area", "r2", 6.5))
    assert floor.entities(ROOM) == ("r1", "r2")
    assert floor.entities(by_name(FLOOR_SIGNATURES)["area"]) == ()
    assert floor.facts_of("area") == (Fact("area", ("r1", 5)), Fact("area", ("r2", 6.5)))
    assert floor.facts_of("label") == ()
    assert floor.without("area") == interpret(("room", "r1"), ("room", "r2"))


def test_a_floor_that_agrees_with_its_signatures_has_no_faults():
    facts = [("buildingtype", "school"), ("connected", "r1", 2), ("room", "r1"), ("room", 2), ("area", 2, 1e300)]
    assert faults_of(*facts, ("connected", 2, "r1"), ("connected", 2, "r1")) == []
    check_interpretation(interpret(*facts), FLOOR_SIGNATURES)


@pytest.mark.parametrize(
    ("facts", "faults"),
    [
        ([("colour", "r1", "red")] * 2, ["colour(r1,red) .*signature"]),
        ([("buildingtype",)], ["buildingtype() .*0"]),
        ([("room", "r1"), ("area", "r1")], ["area(r1) .*room_id, area"]),
        ([("room", "r1"), ("room", "r1")], ["room(r1) .*entity"]),
        ([("area", "r1", 5)], ["area(r1,5) .*room(r1)"]),
        ([("area", "r1", 5), ("label", "r1", "a")], ["area(r1,5) .*room(r1)"]),
        ([("room", "r1"), ("area", "r1", float("nan"))], ["area(r1,nan) .*finite"]),
        ([("room", "r1"), ("area", "r1", float("inf"))], ["area(r1,inf) .*finite"]),
        ([("room", "r1"), ("area", "r1", 10**400)], ["area(r1,1000"]),
        ([("room", 1.5)], ["room(1.5) .*whole number"]),
        (
            [("connected", "r1", "r2"), ("shape", "r1"), ("room", "r1")],
            ["connected(r1,r2) .*room(r2)", "shape(r1) .*signature"],
        ),
    ],
)
def test_faults_are_named_with_a_remedy(facts, faults):
    result = faults_of(*facts)
    assert len(result) == len(faults)
    for fault, text in zip(result, faults, strict=True):
        start, _, word = text.partition(" .*")
        assert fault.startswith(start)
        assert word in fault


def test_entities_of_another_kind_are_reported_as_missing():
    signatures = [ROOM, Signature("door", (Argument("d", SELF),)), Signature("of", (Argument("d", "door"),))]
    assert find_faults(interpret(("room", "r1"), ("of", "r1")), signatures) == [
        "of(r1) names no door, add the fact door(r1)"
    ]
    assert len(find_faults(interpret(("room", "r1"), ("door", "r1")), signatures)) == 1


def test_all_faults_are_listed_in_one_line():
    facts = [("area", f"r{number}", 5) for number in range(12)]
    with pytest.raises(RelationError) as refused:
        check_interpretation(interpret(*facts, name="my floor\n"), FLOOR_SIGNATURES)
    message = str(refused.value)
    assert message.startswith("interpretation 'my floor\\n': area(r0,5)")
    assert "area(r9,5)" in message
    assert message.endswith("; and 2 more")
    assert "\n" not in message


def test_long_names_are_cut_in_messages():
    (fault,) = faults_of(("x" * 10_000, "r1"))
    assert len(fault) < 300


values = st.text(max_size=8) | st.integers(-(10**20), 10**20) | st.floats()


@given(st.lists(st.tuples(st.sampled_from([*by_name(FLOOR_SIGNATURES), "other"]), values, values), max_size=8))
def test_any_facts_can_be_checked(facts):
    try:
        floor = interpret(*facts)
    except RelationError:
        return
    faults = find_faults(floor, FLOOR_SIGNATURES)
    assert all("\n" not in fault for fault in faults)
    if not faults:
        # No relation of two arguments has only properties, so that some entity would have to be declared.
        assert facts == []


def test_the_page_names_every_signature():
    page = (Path(__file__).parents[1] / "docs" / "methods" / "relations.md").read_text(encoding="utf-8")
    assert [name for name in by_name(FLOOR_SIGNATURES) if f"`{name}" not in page] == []
