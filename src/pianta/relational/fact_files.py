"""kLog fact files: `interpretation(floor, fact).` clauses in Prolog's syntax (thesis, section 6.1.2)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from pianta.errors import RelationError
from pianta.io._faults import join_faults
from pianta.io._files import atomic_file, check_input_file, short_repr
from pianta.relational._clauses import Clause, ClauseError, Token, split_clauses
from pianta.relational.facts import (
    FLOOR_SIGNATURES,
    LISTING_SIGNATURES,
    Argument,
    Fact,
    Interpretation,
    Signature,
    Value,
    find_faults,
    locate_faults,
    write_term,
)

MAX_FILE_BYTES = 16 * 2**20
# A file with more faults has another format; its rest is not read.
MAX_FAULTS = 1000
# The relation that the authors' files list after all other facts of all floors.
LAST_RELATION = "label"


def read_interpretations(path: str | Path, *, signatures: Iterable[Signature] | None = None) -> list[Interpretation]:
    """Read the floors of a fact file in the order in which it first names them, their facts in its order.

    signatures: those of the facts; None for those of read_signatures.
    Raises RelationError, with every fault and its line in one message, for a file that is not UTF-8 or too large, for
    anything that is not a ground fact (variables, nested terms, rules, …), and for the faults of
    `pianta.relational.facts.find_faults`.
    """
    return _read(path, signatures)[0]


def read_signatures(path: str | Path) -> tuple[Signature, ...]:
    """The signatures that a fact file declares; without any, LISTING_SIGNATURES or FLOOR_SIGNATURES.

    LISTING_SIGNATURES are for a file with facts of `space` but not of `room`. A relation is unordered if its entities
    have the same role, as in `signature aligned(r1@r::room, r2@r::room)::intensional.`, or if its declaration is that
    of an unordered relation of these two sets. Raises RelationError as read_interpretations does.
    """
    return _read(path, None)[1]


def save_interpretations(
    path: str | Path,
    interpretations: Iterable[Interpretation],
    *,
    signatures: Iterable[Signature] | None = None,
    declare: bool | None = None,
) -> None:
    """Write floors as a fact file from which read_interpretations reads equal ones.

    Labels at the end of a floor's facts come after the facts of all floors, as in the authors' files.
    signatures: those of the facts; None for FLOOR_SIGNATURES, or LISTING_SIGNATURES for spaces.
    declare: whether to write the signatures too; None to write them unless they are the default of read_signatures.

    Raises RelationError, with every fault in one message, for names that occur twice, floors without facts and the
    faults of `pianta.relational.facts.find_faults`; PiantaError if the file cannot be written.
    """
    interpretations = list(interpretations)
    default = _choose_signatures(fact for floor in interpretations for fact in floor.facts)
    chosen = default if signatures is None else tuple(signatures)
    faults = _find_faults_of_floors(interpretations, chosen)
    if faults:
        raise RelationError(f"cannot write {short_repr(path)}: {join_faults(faults)}")
    head = (
        [signature.declare(role="r") for signature in chosen]
        if (chosen != default if declare is None else declare)
        else []
    )
    content = "".join(f"{line}\n" for line in [*head, *_write_facts(interpretations)]).encode()
    if len(content) > MAX_FILE_BYTES:
        raise RelationError(
            f"cannot write {short_repr(path)}: more than {MAX_FILE_BYTES} bytes, save fewer floors in a file"
        )
    with atomic_file(path) as temporary:
        temporary.write_bytes(content)


class _FileFact(NamedTuple):
    """A fact of a file, its floor and line."""

    floor: str
    fact: Fact
    line: int


@dataclass(frozen=True)
class _Content:
    """The content of a file; faults with their lines, and the atoms of unreadable clauses."""

    facts: list[_FileFact]
    declared: dict[str, Signature]
    faults: list[tuple[int, str]]
    unread: set[Value]


def _read(
    path: str | Path, signatures: Iterable[Signature] | None
) -> tuple[list[Interpretation], tuple[Signature, ...]]:
    """The floors and signatures of a fact file; signatures: None for its own. RelationError lists faults by line."""
    file = check_input_file(path, "fact file", RelationError)
    if file.stat().st_size > MAX_FILE_BYTES:
        raise RelationError(f"fact file {short_repr(file)} has more than {MAX_FILE_BYTES} bytes, split it")
    try:
        content = _parse(file.read_bytes().decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise RelationError(f"fact file {short_repr(file)} is not UTF-8 at byte {error.start}, convert it") from None
    except OSError as error:
        raise RelationError(f"fact file {short_repr(file)} cannot be read: {error.strerror}") from None
    used = (
        _choose_signatures((one.fact for one in content.facts), content.declared.values())
        if signatures is None
        else signatures
    )
    used = tuple(used)
    by_floor = _group_by_floor(content.facts)
    floors = [Interpretation(name, tuple(one.fact for one in facts)) for name, facts in by_floor.items()]
    faults = content.faults + _find_faults_in(floors, list(by_floor.values()), used, content.unread)
    if not floors and not faults:
        raise RelationError(f"fact file {short_repr(file)} has no facts, give interpretation(floor, fact). clauses")
    if faults:
        lines = [f"line {line}: {fault}" for line, fault in sorted(faults)]
        raise RelationError(f"cannot read the facts of {short_repr(file)}: {join_faults(lines)}")
    return floors, used


def _find_faults_in(
    floors: Sequence[Interpretation],
    facts: Sequence[Sequence[_FileFact]],
    signatures: tuple[Signature, ...],
    unread: set[Value],
) -> list[tuple[int, str]]:
    """Faults of the facts with their lines; entities that an unreadable clause may declare are assumed."""
    undeclared, undeclarable = _find_undeclared([one for each in facts for one in each], signatures)
    return undeclared + [
        (file_facts[index].line, fault)
        for floor, file_facts in zip(floors, facts, strict=True)
        for index, fault in locate_faults(floor, signatures, assumed=unread | undeclarable)
    ]


def _find_undeclared(
    facts: Iterable[_FileFact], signatures: tuple[Signature, ...]
) -> tuple[list[tuple[int, str]], set[Value]]:
    """Faults for kinds of entities without a signature, with the first line of each, and the names of these entities.

    No fact could declare them.
    """
    declarable = {signature.name for signature in signatures if signature.self_index is not None}
    named = {signature.name: signature for signature in signatures}
    faults: dict[str, tuple[int, str]] = {}
    entities: set[Value] = set()
    for one in facts:
        arguments = named[one.fact.relation].arguments if one.fact.relation in named else ()
        for argument, value in zip(arguments, one.fact.arguments, strict=False):
            if argument.is_entity and argument.kind not in declarable:
                name, relation = argument.kind, short_repr(one.fact.relation)
                fault = f"{relation} is about {short_repr(name)}, add signature {name}(id::self)::extensional"
                faults.setdefault(name, (one.line, fault))
                entities.add(value)
    return [*faults.values()], entities


def _group_by_floor(facts: Iterable[_FileFact]) -> dict[str, list[_FileFact]]:
    floors: dict[str, list[_FileFact]] = {}
    for one in facts:
        floors.setdefault(one.floor, []).append(one)
    return floors


def _choose_signatures(facts: Iterable[Fact], declared: Collection[Signature] = ()) -> tuple[Signature, ...]:
    relations = set() if declared else {fact.relation for fact in facts}
    is_listing = "space" in relations and "room" not in relations
    return tuple(declared) or (LISTING_SIGNATURES if is_listing else FLOOR_SIGNATURES)


def _parse(text: str) -> _Content:
    """The facts, signatures and faults in the text of a fact file; reading stops after MAX_FAULTS faults."""
    content = _Content([], {}, [], set())
    for clause in split_clauses(text):
        line = clause[0].line
        try:
            if clause[0].value == "signature":
                signature = _parse_declaration(clause)
                if content.declared.setdefault(signature.name, signature) != signature:
                    raise ClauseError(f"signature {signature.name} has two different declarations, keep one")
            else:
                content.facts.append(_FileFact(*_parse_fact(clause), line))
        except (ClauseError, RelationError) as error:
            content.faults.append((line, str(error)))
            content.unread.update(token.value for token in clause if token.kind in ("atom", "number"))
        if len(content.faults) == MAX_FAULTS:
            content.faults.append((line, "the rest is not read"))
            break
    return content


def _parse_fact(tokens: Sequence[Token]) -> tuple[str, Fact]:
    """The floor and the fact of `interpretation(floor, relation(argument, ...))`."""
    clause = Clause(tokens)
    if tokens[0].value != "interpretation":
        raise ClauseError(f"{short_repr(tokens[0].value)} begins a clause, give interpretation(floor, fact)")
    clause.expect("atom", "interpretation")
    clause.expect("(", "(")
    floor = clause.expect_atom("the name of a floor")
    clause.expect(",", "a comma")
    relation = clause.expect_atom("a relation")
    clause.expect("(", "( and the arguments of a relation")
    arguments = [clause.expect_value()]
    while not clause.has(")"):
        clause.expect(",", "a comma or )")
        arguments.append(clause.expect_value())
    clause.expect(")", ")")
    clause.expect(")", ")")
    clause.finish()
    return floor, Fact(relation, tuple(arguments))


def _parse_declaration(tokens: Sequence[Token]) -> Signature:
    """The signature of `signature name(argument::kind, ...)::extensional`."""
    clause = Clause(tokens)
    clause.expect("atom", "signature")
    name = clause.expect_atom("the name of a relation")
    clause.expect("(", "(")
    parsed = [_parse_argument(clause)]
    while not clause.has(")"):
        clause.expect(",", "a comma or )")
        parsed.append(_parse_argument(clause))
    clause.expect(")", ")")
    clause.expect("::", "::")
    level = clause.expect_atom("extensional or intensional")
    if level not in ("extensional", "intensional"):
        raise ClauseError(f"signature {short_repr(name)} is {short_repr(level)}, give extensional or intensional")
    clause.finish()
    roles = [role for argument, role in parsed if argument.is_entity]
    unordered = len(roles) > 1 and None not in roles and len(set(roles)) == 1
    arguments = tuple(argument for argument, _ in parsed)
    signature = Signature(name, arguments, intensional=level == "intensional", unordered=unordered)
    shipped = (*FLOOR_SIGNATURES, *LISTING_SIGNATURES)
    return next((one for one in shipped if str(one) == str(signature)), signature)


def _parse_argument(clause: Clause) -> tuple[Argument, str | None]:
    """An argument and its role, or None."""
    name, role = clause.expect_atom("the name of an argument"), None
    if clause.has("@"):
        clause.expect("@", "@")
        role = clause.expect_atom("a role")
    clause.expect("::", "::")
    return Argument(name, clause.expect_atom("self, property or an entity")), role


def _find_faults_of_floors(floors: Sequence[Interpretation], signatures: tuple[Signature, ...]) -> list[str]:
    """Messages about no floors, floors of equal names or without facts, and facts that contradict the signatures."""
    names = [floor.name for floor in floors]
    faults = [] if floors else ["there is no floor, give one or more"]
    faults += [f"floor {short_repr(name)} occurs {n} times, rename them" for name, n in Counter(names).items() if n > 1]
    faults += [f"floor {short_repr(floor.name)} has no facts, leave it out" for floor in floors if not floor.facts]
    return faults + [
        f"floor {short_repr(floor.name)}: {fault}" for floor in floors for fault in find_faults(floor, signatures)
    ]


def _write_facts(floors: Sequence[Interpretation]) -> Iterator[str]:
    """A line for each fact; the labels at the end of floors come after all else, unless a floor has only labels."""
    starts = []
    for floor in floors:
        start = len(floor.facts)
        while start and floor.facts[start - 1].relation == LAST_RELATION:
            start -= 1
        # A floor with only labels keeps its position among the others.
        starts.append(start or len(floor.facts))
    for floor, start in zip(floors, starts, strict=True):
        yield from (f"interpretation({write_term(floor.name)},{fact})." for fact in floor.facts[:start])
    for floor, start in zip(floors, starts, strict=True):
        yield from (f"interpretation({write_term(floor.name)},{fact})." for fact in floor.facts[start:])
