"""kLog files: real ones are rewritten byte for byte, others fact for fact; other files are refused in one line."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import PiantaError, RelationError
from pianta.relational import fact_files as klog
from pianta.relational.fact_files import read_interpretations, read_signatures, save_interpretations
from pianta.relational.facts import (
    FLOOR_SIGNATURES,
    LISTING_SIGNATURES,
    PROPERTY,
    SELF,
    Argument,
    Fact,
    Interpretation,
    Signature,
    find_faults,
)
from tests.mutation import mutated, refused_in_one_line
from tests.test_relations import LISTING_6_1, interpret

LISTING_6_2 = """\
interpretation(floor01,buildingtype(school)).
interpretation(floor01,space(s001)).
interpretation(floor01,label(s001,classroom)).
interpretation(floor01,space(s002)).
interpretation(floor01,label(s002,corridor)).
interpretation(floor01,space(s003)).
interpretation(floor01,label(s003,classroom)).
interpretation(floor01,connected(s001,s002)).
interpretation(floor01,connected(s002,s003)).
interpretation(floor01,area(s001,100)).
interpretation(floor01,perimeter(s001,40)).
"""
FACTS = {"office": (7604, 535, 1184), "robocup": (3120, 209, 612), "school": (11856, 830, 1896)}
FLOORS = {"office": 11, "robocup": 5, "school": 20}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("facts") / "facts.pl"


def read_text(path, text, **options) -> list[Interpretation]:
    path.write_text(text, encoding="utf-8")
    return read_interpretations(path, **options)


def read_facts(path, facts) -> list[Fact]:
    """The facts after room(r1)."""
    (floor,) = read_text(path, f"interpretation(f,room(r1)). {facts}")
    return list(floor.facts[1:])


def fault_of(path, text, **options) -> str:
    with pytest.raises(RelationError) as refused:
        read_text(path, text, **options)
    message = str(refused.value)
    assert "\n" not in message
    named, _, fault = message.partition(f"{str(path)!r}: ")
    assert named != message
    return fault


@pytest.mark.slow
@pytest.mark.parametrize("building_type", FLOORS)
@pytest.mark.parametrize("labels", ["RC", "RCES", "all"])
def test_real_files_are_read_whole_and_written_again_byte_for_byte(data, path, building_type, labels):
    file = data / "klog" / f"{building_type}_{labels}.pl"
    floors = read_interpretations(file)
    facts = [fact for floor in floors for fact in floor.facts]
    rooms, doors = (sum(fact.relation == relation for fact in facts) for relation in ("room", "connected"))
    assert len(floors) == FLOORS[building_type]
    assert (len(facts), rooms, doors) == FACTS[building_type]
    save_interpretations(path, floors)
    assert path.read_bytes() == file.read_bytes()
    assert read_signatures(file) == FLOOR_SIGNATURES


def test_the_fragment_of_the_thesis_is_read(path):
    (floor,) = read_text(path, LISTING_6_2)
    assert floor.name == "floor01"
    assert len(floor.facts) == 11
    assert floor.facts[-1] == Fact("perimeter", ("s001", 40))
    assert floor.entities(LISTING_SIGNATURES[1]) == ("s001", "s002", "s003")
    assert read_signatures(path) == LISTING_SIGNATURES
    save_interpretations(path, [floor])
    assert path.read_text(encoding="utf-8") == LISTING_6_2


def test_facts_must_agree_with_declarations(path):
    (floor,) = read_text(path, LISTING_6_1 + LISTING_6_2)
    assert len(floor.facts) == 11
    assert read_signatures(path) == LISTING_SIGNATURES
    without_area = LISTING_6_1.replace("signature area(", "signature surface(")
    assert "line 17" in fault_of(path, without_area + LISTING_6_2)
    assert read_text(path, without_area + LISTING_6_2, signatures=LISTING_SIGNATURES) == [floor]


def test_the_listing_as_printed_is_read(path):
    printed = LISTING_6_1.replace("room_id::space", "room_id::room")
    assert len(read_text(path, printed + LISTING_6_2)) == 1


def test_equal_roles_mark_unordered_relations(path):
    path.write_text(
        "signature atm(a::self, element::property)::extensional. signature bond(x@b::atm,y@b::atm)::intensional.\n"
        "signature after(x@b::atm,y@c::atm)::extensional. signature next(x::atm,y::atm)::extensional.\n"
        "interpretation(m, atm(a1, c)).",
        encoding="utf-8",
    )
    both = (Argument("x", "atm"), Argument("y", "atm"))
    assert read_signatures(path) == (
        Signature("atm", (Argument("a", SELF), Argument("element", PROPERTY))),
        Signature("bond", both, intensional=True, unordered=True),
        Signature("after", both),
        Signature("next", both),
    )


def test_signatures_of_users_are_written_with_the_facts(path):
    opposite = Signature("opposite", (Argument("r1", "room"), Argument("r2", "room")), unordered=True)
    floor = interpret(("room", "r1"), ("room", "r2"), ("opposite", "r1", "r2"))
    save_interpretations(path, [floor], signatures=(*FLOOR_SIGNATURES, opposite))
    assert "signature opposite(r1@r::room, r2@r::room)::extensional.\n" in path.read_text(encoding="utf-8")
    assert read_interpretations(path) == [floor]
    assert read_signatures(path) == (*FLOOR_SIGNATURES, opposite)
    save_interpretations(path, [floor], signatures=(*FLOOR_SIGNATURES, opposite), declare=False)
    assert path.read_text(encoding="utf-8").count("\n") == 3
    save_interpretations(path, [interpret(("room", "r1"))], declare=True)
    assert path.read_text(encoding="utf-8").count("signature ") == len(FLOOR_SIGNATURES)
    assert read_signatures(path) == FLOOR_SIGNATURES


def test_floors_may_be_mixed_and_keep_their_order(path):
    text = "interpretation(b,room(r1)). interpretation(a,room(r1)). interpretation(b,area(r1,5))."
    assert read_text(path, text) == [
        interpret(("room", "r1"), ("area", "r1", 5), name="b"),
        interpret(("room", "r1"), name="a"),
    ]


def test_facts_that_occur_twice_stay_twice(path):
    both = "interpretation(f,connected(r1,r2)). interpretation(f,connected(r2,r1))."
    assert len(read_facts(path, f"interpretation(f,room(r2)). {both} {both}")) == 5


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("5", 5),
        ("-5", -5),
        ("+5", 5),
        ("5.0", 5.0),
        ("1e3", 1000.0),
        ("1.5E-3", 0.0015),
        ("lroom", "lroom"),
        ("a1_B", "a1_B"),
        ("漢字", "漢字"),
        ("'Two words'", "Two words"),
        ("''", ""),
        ("'it''s'", "it's"),
        (r"'it\'s'", "it's"),
        (r"'\n\t\\\"\x41\\101\'", '\n\t\\"AA'),
        ("'% no comment /* */ ). '", "% no comment /* */ ). "),
    ],
)
def test_atoms_and_numbers(path, written, value):
    (fact,) = read_facts(path, f"interpretation(f,label(r1,{written})).")
    assert fact.arguments == ("r1", value)
    assert type(fact.arguments[1]) is type(value)


def test_white_space_and_comments_may_be_anywhere(path):
    text = "% a comment\ninterpretation ( f , % and 'another'\r\n\tarea(/* r2. */r1\n,5)\n)\n.\n/* the\nend. */"
    assert read_facts(path, text) == [Fact("area", ("r1", 5))]
    assert read_text(path, "\ufeffinterpretation(f,room(r1)).%end") == [interpret(("room", "r1"), name="f")]


@pytest.mark.parametrize(
    ("clause", "fault"),
    [
        ("interpretation(f,area(X,5)).", "'X'"),
        ("interpretation(f,area(r1,_)).", "'_'"),
        ("interpretation(F,area(r1,5)).", "'F'"),
        ("interpretation(f,Area(r1,5)).", "Area"),
        ("interpretation(f,area(g(r1),5)).", "g("),
        ("interpretation(f,area(r1,5)) :- true.", "directive"),
        (":- dynamic(f).", "directive"),
        ("area(r1,5).", "area"),
        ("interpretation(f,room).", "')'"),
        ("interpretation(f,room()).", "')'"),
        ("interpretation(1,room(r2)).", "'1'"),
        ("interpretation(f,area(r1,5).", ")"),
        ("interpretation(f,area(r1,5))).", "')'"),
        ("interpretation(f area(r1,5)).", "area"),
        ("interpretation(f,area(r1;5)).", "';5'"),
        ("interpretation(f,area(r1,[5])).", "[5]"),
        ("interpretation(f,area(r1,5a)).", "'5a'"),
        ("interpretation(f,area(r1,1e999)).", "1e999"),
        (f"interpretation(f,area(r1,{'9' * 400})).", "digits"),
        (f"interpretation(f,area(r1,0.{'3' * 5000})).", "digits"),
        ('interpretation(f,label(r1,"text")).', "ends"),
        ("interpretation(f,label(r1,'text)).", "ends"),
        (r"interpretation(f,label(r1,'\q')).", "\\\\q"),
        (r"interpretation(f,label(r1,'\xd800\')).", "escape"),
        ("interpretation(f,area(r1,5)", "end"),
        ("/* interpretation(f,area(r1,5)).", "/* interpretation(f,area(r1,5)"),
        ("interpretation(f,area(r1,5)).room(r1).", "facts"),
        (f"interpretation(f,area({'r1,' * 2000}5)).", "1000"),
        ("signature area.", "("),
        ("signature area(a::b)::observed.", "observed"),
        ("signature area(a::'B')::extensional.", "'B'"),
        ("signature a(x::self, y::self)::extensional.", "self"),
    ],
)
def test_invalid_clauses_are_faults_with_their_lines(path, clause, fault):
    result = fault_of(path, f"interpretation(f,room(r1)).\n\n{clause}", signatures=FLOOR_SIGNATURES)
    assert result.startswith("line 3: ")
    assert fault in result


def test_a_signature_has_one_meaning(path):
    text = (
        "signature room(a::self)::extensional.\nsignature room(a::property)::extensional.\ninterpretation(f,room(a))."
    )
    assert re.match("line 2: .*room", fault_of(path, text))


def test_all_faults_of_a_file_are_listed_together(path):
    text = """\
interpretation(f,room(r1)).
interpretation(f,area(R2,5)).
interpretation(f,colour(r1,red)).
interpretation(g,perimeter(r3,5)).
interpretation(f,area(r1)).
interpretation(f,room(r1)).
"""
    faults = fault_of(path, text).split("; ")
    listed = [
        "line 2: .*R2",
        r"line 3: colour\(r1,red",
        r"line 4: perimeter\(r3,5",
        r"line 5: area\(r1",
        r"line 6: room\(r1",
    ]
    assert len(faults) == len(listed)
    assert all(re.match(start, fault) for start, fault in zip(listed, faults, strict=True))


def test_many_faults_are_counted(path):
    text = "".join(f"interpretation(f,area(R{number},5)).\n" for number in range(500))
    assert re.search("line 10: [^;]*R9[^;]*; and 490 more$", fault_of(path, text))
    assert fault_of(path, "no.\n" * 2_000).endswith("; and 991 more")


def test_an_entity_that_an_unreadable_clause_may_declare_is_not_reported_as_missing(path):
    result = fault_of(path, "interpretation(f,room(r1) .\ninterpretation(f,area(r1,5)).\ninterpretation(f,area(r2,5)).")
    assert result == "line 1: the clause ends where ) belongs; line 3: area(r2,5) names no room, add the fact room(r2)"


def test_files_that_hold_no_text_or_no_facts_are_refused(path):
    path.write_bytes(b"interpretation(f,room(\xff)).")
    with pytest.raises(RelationError, match="22"):
        read_interpretations(path)
    path.write_bytes(b"% nothing\n")
    with pytest.raises(RelationError, match="facts"):
        read_interpretations(path)
    path.write_bytes(b"")
    with pytest.raises(RelationError, match="empty"):
        read_interpretations(path)
    with pytest.raises(RelationError, match="exist"):
        read_interpretations(path.with_name("missing.pl"))


def test_large_files_are_refused(path, monkeypatch):
    monkeypatch.setattr(klog, "MAX_FILE_BYTES", 27)
    assert len(read_text(path, "interpretation(f,room(r1)).")) == 1
    with pytest.raises(RelationError, match="27"):
        read_text(path, "interpretation(f,room(r12)).")
    with pytest.raises(RelationError, match="27"):
        save_interpretations(path, [interpret(("room", "r12"))])


@pytest.mark.slow
@pytest.mark.parametrize("piece", ["(", "'", "/*", "''", "1", "a(", ".", "\\", "+", "1.1e", "x,'", "%", "/"])
def test_no_file_takes_long(path, piece):
    # An algorithm of quadratic time in the length of the file would take hours.
    with pytest.raises(RelationError):
        read_text(path, piece * (2**18 // len(piece)))


@pytest.mark.parametrize(
    ("floors", "message"),
    [
        ([], "floor"),
        ([interpret(("room", "r1"))] * 2, "'floor'"),
        ([Interpretation("f", ())], "'f'"),
        ([interpret(("area", "r1", 5))], "area(r1,5)"),
        ([interpret(("room", "r1"), ("area", "r1", float("nan")))], "area(r1,nan)"),
    ],
)
def test_floors_that_could_not_be_read_again_are_not_written(path, floors, message):
    path.unlink(missing_ok=True)
    with pytest.raises(RelationError, match=re.escape(message)):
        save_interpretations(path, floors)
    assert not path.exists()
    with pytest.raises(PiantaError, match="write"):
        save_interpretations(path.parent, [interpret(("room", "r1"))])


names = st.text(min_size=1, max_size=6)
numbers = st.integers(-(10**30), 10**30) | st.floats(allow_nan=False, allow_infinity=False)
properties = st.text(max_size=6) | numbers


@st.composite
def floors(draw) -> list[Interpretation]:
    """Floors with any names, identifiers and properties that are texts, and facts in any order."""
    annotated = []
    for name in draw(st.lists(names, min_size=1, max_size=3, unique=True)):
        rooms = draw(st.lists(names | st.integers(), min_size=1, max_size=4, unique=True))
        a_room = st.sampled_from(rooms)
        more = st.one_of(
            st.tuples(st.just("area"), a_room, properties),
            st.tuples(st.just("label"), a_room, properties),
            st.tuples(st.just("connected"), a_room, a_room),
            st.tuples(st.just("buildingtype"), properties),
        )
        facts = [("room", room) for room in rooms] + draw(st.lists(more, max_size=6))
        annotated.append(interpret(*draw(st.permutations(facts)), name=name))
    return annotated


def test_a_floor_with_labels_only_keeps_its_position(path):
    signatures = [Signature("label", (Argument("label"),)), Signature("colour", (Argument("colour"),))]
    annotated = [interpret(("label", "a"), name="f"), interpret(("colour", "b"), name="g")]
    save_interpretations(path, annotated, signatures=signatures)
    assert read_interpretations(path) == annotated


@pytest.mark.slow
@given(floors=floors(), declare=st.booleans())
def test_round_trip_is_exact_and_stable(path, floors, declare):
    save_interpretations(path, floors, declare=declare)
    content = path.read_bytes()
    read = read_interpretations(path)
    assert read == floors
    values = [[type(value) for fact in floor.facts for value in fact.arguments] for floor in floors]
    assert [[type(value) for fact in floor.facts for value in fact.arguments] for floor in read] == values
    save_interpretations(path, read, declare=declare)
    assert path.read_bytes() == content


VALID = (LISTING_6_1 + LISTING_6_2 + "interpretation('f 2',space('\\x41\\ b')). /* end */").encode()


@pytest.mark.slow
@given(content=mutated(VALID))
def test_damaged_files_are_read_or_refused_in_one_line(path, content):
    path.write_bytes(content)
    with refused_in_one_line():
        for floor in read_interpretations(path):
            assert find_faults(floor, read_signatures(path)) == []
