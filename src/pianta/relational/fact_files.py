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
# A file with more faults is of another kind; the rest of it is not looked at.
MAX_FAULTS = 1000
# Relations that the real files list after all other facts of all floors.
LAST = "label"


def read_interpretations(path: str | Path, *, signatures: Iterable[Signature] | None = None) -> list[Interpretation]:
    """Read the floors of a fact file in the order in which it first names them, their facts in its order.

    signatures: what the facts must agree with; when None, those that read_signatures finds.
    Raises RelationError, with every fault and its line in one message, for a file that is not UTF-8 or too large, for
    variables, terms within terms, rules and whatever else is no ground fact, and for the faults of
    `pianta.relational.facts.find_faults`.
    """
    return _read(path, signatures)[0]


def read_signatures(path: str | Path) -> tuple[Signature, ...]:
    """The signatures that a fact file declares; where it declares none, LISTING_SIGNATURES or FLOOR_SIGNATURES.

    It is LISTING_SIGNATURES when there are facts of `space` and none of `room`. A relation is unordered when its
    entities have one role, as in `signature aligned(r1@r::room, r2@r::room)::intensional.`, or when its declaration is
    that of one of these two sets which is. Raises RelationError as read_interpretations does.
    """
    return _read(path, None)[1]


def save_interpretations(
    path: str | Path,
    interpretations: Iterable[Interpretation],
    *,
    signatures: Iterable[Signature] | None = None,
    declare: bool | None = None,
) -> None:
    """Write floors as a fact file that read_interpretations reads as equal ones.

    The facts at the end of a floor that tell its labels come after those of all floors, as in the real files.
    signatures: what the facts must agree with; when None, FLOOR_SIGNATURES, or LISTING_SIGNATURES for spaces.
    declare: write the signatures too; when None, if they are not those that read_signatures takes without.

    Raises RelationError, with every fault in one message, for names that occur twice, floors without facts and the
    faults of `pianta.relational.facts.find_faults`; PiantaError when the file cannot be written.
    """
    interpretations = list(interpretations)
    default = _choose_signatures(fact for of in interpretations for fact in of.facts)
    chosen = default if signatures is None else tuple(signatures)
    faults = _find_faults_of_floors(interpretations, chosen)
    if faults:
        raise RelationError(f"cannot write {short_repr(path)}: {join_faults(faults)}")
    head = [signature.declare(role="r") for signature in chosen] if _is_told(declare, chosen, default) else []
    content = "".join(f"{line}\n" for line in [*head, *_write_facts(interpretations)]).encode()
    if len(content) > MAX_FILE_BYTES:
        raise RelationError(
            f"cannot write {short_repr(path)}: more than {MAX_FILE_BYTES} bytes, save fewer floors in a file"
        )
    with atomic_file(path) as temporary:
        temporary.write_bytes(content)


class _Stated(NamedTuple):
    floor: str
    fact: Fact
    line: int


@dataclass(frozen=True)
class _Content:
    """What a file says; faults with their lines, and the atoms of clauses that could not be read."""

    stated: list[_Stated]
    declared: dict[str, Signature]
    faults: list[tuple[int, str]]
    unread: set[Value]


def _read(
    path: str | Path, signatures: Iterable[Signature] | None
) -> tuple[list[Interpretation], tuple[Signature, ...]]:
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
        _choose_signatures((one.fact for one in content.stated), content.declared.values())
        if signatures is None
        else signatures
    )
    used = tuple(used)
    places = _group_by_floor(content.stated)
    floors = [Interpretation(name, tuple(one.fact for one in of_floor)) for name, of_floor in places.items()]
    faults = content.faults + _find_faults_in(floors, list(places.values()), used, content.unread)
    if not floors and not faults:
        raise RelationError(f"fact file {short_repr(file)} has no facts, give interpretation(floor, fact). clauses")
    if faults:
        told = [f"line {line}: {fault}" for line, fault in sorted(faults)]
        raise RelationError(f"cannot read the facts of {short_repr(file)}: {join_faults(told)}")
    return floors, used


def _find_faults_in(
    floors: Sequence[Interpretation],
    stated: Sequence[Sequence[_Stated]],
    signatures: tuple[Signature, ...],
    unread: set[Value],
) -> list[tuple[int, str]]:
    """Faults of the facts with their lines; entities that an unreadable clause may declare are not missed."""
    undeclared, unknowable = _find_undeclared([one for of_floor in stated for one in of_floor], signatures)
    return undeclared + [
        (of_floor[place].line, fault)
        for floor, of_floor in zip(floors, stated, strict=True)
        for place, fault in locate_faults(floor, signatures, known=unread | unknowable)
    ]


def _find_undeclared(
    stated: Iterable[_Stated], signatures: tuple[Signature, ...]
) -> tuple[list[tuple[int, str]], set[Value]]:
    """Entities without a signature, with the line of the first fact about each, and what the facts call them.

    No fact could declare these.
    """
    declarable = {signature.name for signature in signatures if signature.self_place is not None}
    named = {signature.name: signature for signature in signatures}
    faults: dict[str, tuple[int, str]] = {}
    called: set[Value] = set()
    for one in stated:
        arguments = named[one.fact.relation].arguments if one.fact.relation in named else ()
        for argument, value in zip(arguments, one.fact.arguments, strict=False):
            if argument.is_entity and argument.kind not in declarable:
                kind, relation = argument.kind, short_repr(one.fact.relation)
                fault = f"{relation} is about {short_repr(kind)}, add signature {kind}(id::self)::extensional"
                faults.setdefault(kind, (one.line, fault))
                called.add(value)
    return [*faults.values()], called


def _group_by_floor(stated: Iterable[_Stated]) -> dict[str, list[_Stated]]:
    floors: dict[str, list[_Stated]] = {}
    for one in stated:
        floors.setdefault(one.floor, []).append(one)
    return floors


def _choose_signatures(facts: Iterable[Fact], declared: Collection[Signature] = ()) -> tuple[Signature, ...]:
    relations = set() if declared else {fact.relation for fact in facts}
    is_listing = "space" in relations and "room" not in relations
    return tuple(declared) or (LISTING_SIGNATURES if is_listing else FLOOR_SIGNATURES)


def _parse(text: str) -> _Content:
    content = _Content([], {}, [], set())
    for clause in split_clauses(text):
        line = clause[0].line
        try:
            if clause[0].value == "signature":
                signature = _parse_declaration(clause)
                if content.declared.setdefault(signature.name, signature) != signature:
                    raise ClauseError(f"signature {signature.name} is declared again and otherwise, keep one")
            else:
                content.stated.append(_Stated(*_parse_fact(clause), line))
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
    clause.take("atom", "interpretation")
    clause.take("(", "(")
    floor = clause.take_atom("the name of a floor")
    clause.take(",", "a comma")
    relation = clause.take_atom("a relation")
    clause.take("(", "( and the arguments of a relation")
    arguments = [clause.take_value()]
    while not clause.has(")"):
        clause.take(",", "a comma or )")
        arguments.append(clause.take_value())
    clause.take(")", ")")
    clause.take(")", ")")
    clause.finish()
    return floor, Fact(relation, tuple(arguments))


def _parse_declaration(tokens: Sequence[Token]) -> Signature:
    """The signature of `signature name(argument::kind, ...)::extensional`."""
    clause = Clause(tokens)
    clause.take("atom", "signature")
    name = clause.take_atom("the name of a relation")
    clause.take("(", "(")
    parsed = [_parse_argument(clause)]
    while not clause.has(")"):
        clause.take(",", "a comma or )")
        parsed.append(_parse_argument(clause))
    clause.take(")", ")")
    clause.take("::", "::")
    level = clause.take_atom("extensional or intensional")
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
    """An argument and its role, None when it has none of its own."""
    name, role = clause.take_atom("the name of an argument"), None
    if clause.has("@"):
        clause.take("@", "@")
        role = clause.take_atom("a role")
    clause.take("::", "::")
    return Argument(name, clause.take_atom("self, property or an entity")), role


def _find_faults_of_floors(floors: Sequence[Interpretation], signatures: tuple[Signature, ...]) -> list[str]:
    names = [floor.name for floor in floors]
    faults = [] if floors else ["there is no floor, give one or more"]
    faults += [f"floor {short_repr(name)} occurs {n} times, rename them" for name, n in Counter(names).items() if n > 1]
    faults += [f"floor {short_repr(floor.name)} has no facts, leave it out" for floor in floors if not floor.facts]
    return faults + [
        f"floor {short_repr(floor.name)}: {fault}" for floor in floors for fault in find_faults(floor, signatures)
    ]


def _is_told(declare: bool | None, signatures: tuple[Signature, ...], default: tuple[Signature, ...]) -> bool:  # noqa: FBT001
    return signatures != default if declare is None else declare


def _write_facts(floors: Sequence[Interpretation]) -> Iterator[str]:
    starts = []
    for floor in floors:
        start = len(floor.facts)
        while start and floor.facts[start - 1].relation == LAST:
            start -= 1
        # A floor of nothing but labels keeps its place among the others.
        starts.append(start or len(floor.facts))
    for floor, start in zip(floors, starts, strict=True):
        yield from (f"interpretation({write_term(floor.name)},{fact})." for fact in floor.facts[:start])
    for floor, start in zip(floors, starts, strict=True):
        yield from (f"interpretation({write_term(floor.name)},{fact})." for fact in floor.facts[start:])
